"""From a `Linkage` to SDF, the format of Gazebo (sdformat.org/spec, version 1.11)."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path

import numpy as np
import pinocchio as pin

from ...common import files
from ...common.arguments import LARGEST, typed
from ...common.errors import PinpressError, caution
from ...common.quantities import Array
from ..document import Document
from ..linkage import Linkage
from ..machine_elements import Mesh
from ..text import MOMENTS, as_text, opening, tag
from ..writing import drawn_text
from .elements import make_unique, take
from .mechanism import Follow, Joint, Link, Loop, Mechanism, Shape, placements
from .sdf import ARMATURE, CLOSES, WORLD
from .urdf import doubt_machine_elements, mechanism_of, with_machine_elements

LEAST = 1e-15, 1e-18  # mass and moments of moving links without mass, as SDF gives a link without them 1 kg and 1 kg m2 [kg, kg m2]
TYPES = {"spherical": "ball", "revolute": "revolute", "fixed": "fixed"}
PLUGIN = {"filename": "gz-sim-joint-controller-system", "name": "gz::sim::systems::JointController"}


@typed
def write_sdf(press: Linkage, path: str | os.PathLike[str]) -> Path:
    """Write a linkage as an SDF for Gazebo, and return its path.

    SDF has no place for a pose in which a linkage starts: links stand in the closed home pose, and there all joints are at zero; limits,
    springs and gears are moved with them. Loops are ball, revolute and fixed joints, gear pairs, racks and screws ``<mimic>``, meshing
    gears gearboxes, drivers the joints of Gazebo's joint controller. `load` reads the file again; give it gravity and slide.

    Args:
        press: the linkage.
        path: of the file, which should end in ``.sdf``.

    Raises:
        PinpressError: a relation of more than two joints, which SDF does not know; the path cannot be written.

    Warns:
        PinpressWarning: machine elements, which become ratios; the ``<tool>`` of the slide, which is left out; armature, which other
            programs skip; inertia that no body has, which Gazebo refuses; a link that had to get another name; damping that is not read
            back.
    """
    doubt_machine_elements(press, "Gazebo")
    document = Document(press.file, drawn_text(press))
    whole, gearboxes = with_machine_elements(mechanism_of(document), press), [mesh.name for mesh in _gearboxes(press)]
    relations = tuple(relation for relation in whole.relations if relation.name not in gearboxes)
    drawn = _with_gears(replace(whole, relations=relations), press.name)
    mechanism = _without_free_joints(drawn, press.root, document.description.bases)
    for element in document.robot.all("link"):
        if element.all("tool"):
            caution(f"{press.name}: SDF does not hold the <tool> of link {element.get('name')!r}: it was left out")
    for link in mechanism.links:
        if link.inertia is not None and link.inertia.mass and _is_odd(link.inertia.tensor):
            caution(f"{press.name}: link {link.name!r} has moments of inertia that no body has, which Gazebo refuses; written as they are")
    if rotors := [joint.name for joint in mechanism.joints if joint.armature]:
        caution(f"{press.name}: Gazebo knows no armature: that of {', '.join(rotors)} is in <{ARMATURE}>, which pinpress alone reads")
    if damped := [joint.name for joint in mechanism.joints if joint.spring is not None and not joint.spring.stiffness]:
        problem = f"the damping of {', '.join(damped)} acts in Gazebo, and not in pinpress, which reads that of joints on springs alone"
        caution(f"{press.name}: {problem}; give it as friction={{joint: Friction(...)}}")
    places = placements([press.root], ((joint.parent, joint.child, joint.place) for joint in drawn.joints))
    return files.write(path, ("\n".join(_Writer(mechanism, places, press).lines()) + "\n").encode())


def _is_odd(tensor: Array) -> bool:
    """Whether no body has a tensor: a principal moment that is not positive, or larger than the sum of the others."""
    smallest, middle, largest = np.linalg.eigvalsh(tensor)
    return bool(smallest <= 0.0 or smallest + middle < (1 - 1e-9) * largest)


def _without_free_joints(mechanism: Mechanism, root: str, bases: Mapping[str, Sequence[str]]) -> Mechanism:
    """The mechanism without the joints of free bodies, and without a root that only they had: in SDF a link that no joint carries is
    free."""
    chains = [joint for joint in mechanism.joints if any(joint.name in names for names in bases.values())]
    joints = tuple(joint for joint in mechanism.joints if joint not in chains)
    left_out = {joint.child for joint in chains} & {joint.parent for joint in chains}
    joined = {joint.parent for joint in joints} | {link for loop in mechanism.loops for link, _ in loop.ends}
    left_out |= {root} if chains and root not in joined else set()
    return replace(mechanism, joints=joints, links=tuple(link for link in mechanism.links if link.name not in left_out))


def _with_gears(mechanism: Mechanism, name: str) -> Mechanism:
    """The mechanism with relations of two joints as gears of the first; raises PinpressError for others."""
    gears = {}
    for relation in mechanism.relations:
        (joint, first), *others = relation.coefficients.items()
        if len(others) != 1 or joint in gears or any(each.follow for each in mechanism.joints if each.name == joint):
            raise PinpressError(
                f"{name}: SDF has no element for relation {relation.name!r}: it gears pairs of joints, and each follower once"
            )
        ((leader, second),) = others
        gears[joint] = Follow(leader, -second / first, relation.offset / first, relation.origin)
    geared = (replace(joint, follow=gears[joint.name]) if joint.name in gears else joint for joint in mechanism.joints)
    return replace(mechanism, joints=tuple(geared), relations=())


def _gearboxes(press: Linkage) -> list[Mesh]:
    """Gears that mesh, of which SDF knows the ratio against their carrier."""
    return [mesh for mesh in press.meshes.values() if mesh.kind == "gears"]


class _Writer:
    """Writes a mechanism that is closed where its joints are at zero."""

    def __init__(self, mechanism: Mechanism, places: Mapping[str, pin.SE3], press: Linkage) -> None:
        self.mechanism, self.places, self.drivers = mechanism, places, press.motors
        self.root, self.moving = press.root, {link for link, body in press.document.description.bodies.items() if body != press.root}
        self.gearboxes = _gearboxes(press)
        taken = {joint.name for joint in mechanism.joints} | {loop.name for loop in mechanism.loops}
        taken |= {gears.name for gears in self.gearboxes}
        self.names = {WORLD: WORLD}  # of links: in SDF they share names with joints
        for name in (link.name for link in mechanism.links if link.name != WORLD):
            self.names[name] = take(name if name not in taken else f"{name}_link", taken)
            if self.names[name] != name:
                caution(f"{press.name}: link {name!r} is called {self.names[name]!r} in SDF, because a joint has its name")
        self.held = make_unique(f"{self.root}_to_world", taken)

    def lines(self) -> Iterator[str]:
        yield "<?xml version='1.0'?>"
        yield '<sdf version="1.11">'
        yield "  <!-- Written by pinpress. Joints are at zero in the pose of this file. SI units. -->"
        yield f"  {opening('model', {'name': self.mechanism.name})}"
        for link in self.mechanism.links:
            if link.name != WORLD:
                yield from self._link(link)
        if self.root != WORLD and any(link.name == self.root for link in self.mechanism.links):
            yield from self._bearing(self.held, "fixed", WORLD, self.root, "")
        for joint in self.mechanism.joints:
            kind = "continuous" if joint.type == "revolute" and joint.limits is None else joint.type
            rotor = f"<{ARMATURE}>{as_text([joint.armature])}</{ARMATURE}>" if joint.armature else ""
            yield from self._bearing(joint.name, kind, joint.parent, joint.child, self._axis(joint) + rotor)
        for loop in self.mechanism.loops:
            yield from self._loop(loop)
        for gears in self.gearboxes:
            yield from self._gearbox(gears)
        if self.drivers:
            driven = "".join(f"<joint_name>{escape(name)}</joint_name>" for name in self.drivers)
            yield f"    {tag('plugin', PLUGIN, driven)}"
        yield "  </model>"
        yield "</sdf>"

    def _link(self, link: Link) -> Iterator[str]:
        yield f"    {opening('link', {'name': self.names[link.name]})}"
        yield f"      {_pose(self.places[link.name])}"
        inertia = link.inertia
        if inertia is not None and inertia.mass:
            moments = "".join(f"<{name}>{as_text([inertia.tensor[i, j]])}</{name}>" for name, i, j in MOMENTS)
            content = _pose(inertia.place) + f"<mass>{as_text([inertia.mass])}</mass>" + tag("inertia", {}, moments)
            yield f"      {tag('inertial', {}, content)}"
        elif link.name in self.moving:
            mass, moment = LEAST
            moments = "".join(f"<{name}>{as_text([moment if i == j else 0.0])}</{name}>" for name, i, j in MOMENTS)
            yield f"      {tag('inertial', {}, f'<mass>{mass!r}</mass>' + tag('inertia', {}, moments))}"
        for k, shape in enumerate(link.shapes, 1):
            yield f"      {_visual(k, shape)}"
        yield "    </link>"

    def _bearing(self, name: str, kind: str, parent: str, child: str, content: str) -> Iterator[str]:
        ends = f"<parent>{escape(self.names[parent])}</parent><child>{escape(self.names[child])}</child>"
        yield f"    {tag('joint', {'name': name, 'type': kind}, ends + content)}"

    def _axis(self, joint: Joint) -> str:
        if joint.type == "fixed":
            return ""
        limits = dict(zip(("lower", "upper"), joint.limits or (), strict=False)) | {"effort": joint.effort, "velocity": joint.velocity}
        written = {name: value for name, value in limits.items() if value is not None and abs(value) < LARGEST}
        dynamics = {"damping": joint.damping, "friction": joint.friction}
        if joint.spring is not None:
            spring = joint.spring
            dynamics |= {"damping": spring.damping, "spring_reference": spring.reference, "spring_stiffness": spring.stiffness}
        content = f"<xyz>{as_text(joint.axis)}</xyz>" + _numbers("limit", written)
        if any(dynamics.values()):
            content += _numbers("dynamics", dynamics)
        if joint.follow is not None:
            ratio = _numbers("", {"multiplier": joint.follow.multiplier, "offset": joint.follow.offset, "reference": 0.0})
            content += tag("mimic", {"joint": joint.follow.leader}, ratio)
        return tag("axis", {}, content)

    def _loop(self, loop: Loop) -> Iterator[str]:
        (parent, _), (child, place) = loop.ends
        axis = "" if loop.axis is None else tag("axis", {}, f"<xyz>{as_text(loop.axis)}</xyz>")
        yield from self._bearing(loop.name, TYPES[loop.type], parent, child, _pose(place) + axis + tag(CLOSES, {}))

    def _gearbox(self, gears: Mesh) -> Iterator[str]:
        """Gears of which the child turns -ratio times as far as the parent, both against the carrier. The world is no child."""
        (parent, child), ratio, axis = gears.links, -gears.ratio, gears.axes[1]
        if child == self.root:
            parent, child, ratio, axis = child, parent, 1 / ratio, gears.axes[0]
        content = _numbers("", {"gearbox_ratio": ratio}) + tag("gearbox_reference_body", {}, escape(self.names[gears.carrier]))
        content += "".join(tag(name, {}, f"<xyz>{as_text(axis)}</xyz>") for name in ("axis", "axis2"))
        yield from self._bearing(gears.name, "gearbox", parent, child, content)


def _pose(place: pin.SE3) -> str:
    if np.array_equal(place.rotation, np.eye(3)):
        return f"<pose>{as_text(place.translation)} 0 0 0</pose>"
    turned: Array = pin.Quaternion(place.rotation).coeffs()  # x y z w: unlike roll, pitch and yaw they have all digits everywhere
    return tag("pose", {"rotation_format": "quat_xyzw"}, f"{as_text(place.translation)} {as_text(turned)}")


def _numbers(name: str, values: Mapping[str, float]) -> str:
    """An element with numbers by their names; without a name of its own, the numbers alone."""
    content = "".join(f"<{key}>{as_text([value])}</{key}>" for key, value in values.items())
    return tag(name, {}, content) if name and content else content


def _visual(k: int, shape: Shape) -> str:
    values = dict(shape.attributes)
    if shape.tag == "mesh":
        values["uri"] = values.pop("filename", "").replace("package://", "model://")
    geometry = tag(shape.tag, {}, "".join(f"<{name}>{escape(value)}</{name}>" for name, value in values.items()))
    content = _pose(shape.place) + tag("geometry", {}, geometry)
    if shape.colour is not None:
        content += tag("material", {}, f"<diffuse>{as_text(shape.colour)}</diffuse>")
    return tag("visual", {"name": f"visual_{k}"}, content)
