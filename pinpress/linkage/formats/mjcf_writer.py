"""From a `Linkage` to an MJCF, the format of MuJoCo (mujoco.readthedocs.io, "XML Reference").

Every body stands at its joint's place, sites stand for ends of loops. MuJoCo draws bodies in the pose in which a simulation starts; here
that is the closed pose, and ``ref`` says which coordinates the joints have there, so that ``qpos`` counts from the zeros of the linkage.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

from ...common import files
from ...common.arguments import typed
from ...common.errors import caution
from ...common.quantities import Array
from ...engines.constraints import LoopJoint, Relation
from ...engines.mounting import limits
from ..description import FREE
from ..element import Element
from ..linkage import Linkage
from ..text import as_text, opening, tag
from .elements import make_unique
from .urdf import doubt_machine_elements, place_of

WORLD = "world"
DRAWN = 1e-9  # coordinates of the closed pose up to which bodies are drawn at zero: less is rounding of the file [rad or m]
LEAST_MASS, LEAST_MOMENT = 1e-12, 1e-14  # of a body, as MuJoCo refuses zeros [kg, kg m2]
STIFF = {"solref": "0.004 1", "solimp": "0.9999 0.9999 0.001 0.5 2"}  # of equalities: the least yielding that MuJoCo takes at its time step
LEVER = 0.25  # distance of the second point of a hinge that closes a loop from its first, as a share of the linkage's size
BOUND = 1e6  # limits from this on mean that there is none [rad, m, N or N m]


@typed
def write_mjcf(press: Linkage, path: str | os.PathLike[str]) -> Path:
    """Write a linkage as an MJCF for MuJoCo, and return its path.

    Bodies, joints and motors have the names of the linkage, ``qpos`` are its joint coordinates, and the simulation starts in its closed
    pose, which is the keyframe ``home`` too. A loop that is a ball is a ``<connect>``, a fixed one a ``<weld>``, a hinge two ``<connect>``
    on its axis: ``NAME`` and ``NAME_axis``. Gear pairs are equalities of joints, other relations equalities of tendons. Motors have a gear
    of 1, so that controls are the torques and forces of `Reactions`. A floating base has a free joint. `load` reads the file again.

    MuJoCo keeps equalities by stiff springs and dampers, so that loops open a little in a simulation: those of the shipped presses by less
    than 1e-4 of their size. It knows no held spins: a rod between
    two ball joints may turn about its line. Shapes are boxes, cylinders and spheres, which do not collide; meshes are left out. So are
    damping and friction of ``<dynamics>``, with which pinpress does not compute.

    Args:
        press: the linkage.
        path: of the file, which should end in ``.xml``.

    Raises:
        PinpressError: the press has a cam; the path cannot be written.

    Warns:
        PinpressWarning: machine elements, written as ratios of joints; moments of inertia that no body has, which MuJoCo refuses; they are
            raised in the file.
    """
    return files.write(path, "\n".join(mjcf(press)).encode())


def mjcf(press: Linkage) -> Iterator[str]:
    """The lines of a linkage as MJCF."""
    doubt_machine_elements(press, "MuJoCo")
    closed = press.closed
    drawn = closed if np.abs(closed).max() > DRAWN else np.zeros_like(closed)
    tree = _Tree.of(press, drawn)
    tendons = {relation: f"tendon_{relation.name}" for relation in press.relations if len(relation.coefficients) > 2}
    sections = {
        "tendon": [_tendon(press, relation, name) for relation, name in tendons.items()],
        "equality": [*_closings(press), *(_related(press, drawn, relation, tendons.get(relation, "")) for relation in press.relations)],
        "actuator": [tag("motor", {"name": name, "joint": name} | _effort(press, name)) for name in press.motors],
        "keyframe": [tag("key", {"name": "home", "qpos": as_text(tree.start(closed))})],
    }
    yield opening("mujoco", {"model": press.name})
    yield "  <!-- Written by pinpress. SI units; qpos are the joint coordinates of pinpress. -->"
    yield '  <compiler angle="radian" autolimits="false" inertiafromgeom="false"/>'
    yield f"  {tag('option', {'gravity': as_text(press.model.gravity.linear)})}"
    yield f"  {tag('default', {}, tag('equality', STIFF))}"
    yield "  <worldbody>"
    yield from tree.body(0, "    ")
    yield "  </worldbody>"
    for name, lines in sections.items():
        if lines:
            yield from (f"  <{name}>", *(f"    {line}" for line in lines), f"  </{name}>")
    yield "</mujoco>\n"


@dataclass(frozen=True, eq=False)
class _Tree:
    """The bodies of a linkage, by their Pinocchio joints (0: the frame); of a free body the last of its six joints.

    Attributes:
        press: the linkage.
        drawn: (nv,) joint coordinates at which bodies are drawn [rad or m].
        chains: Pinocchio joints from the parent's body to every body: one, or the six of a free body.
        children: bodies on every body, the free ones last.
        links: names of the links of every body, that which begins it first, with their shapes.
        sites: lines of the ends of loops on every body.
    """

    press: Linkage
    drawn: Array
    chains: dict[int, tuple[int, ...]]
    children: dict[int, list[int]]
    links: dict[int, list[tuple[str, Element]]]
    sites: dict[int, list[str]]

    @staticmethod
    def of(press: Linkage, drawn: Array) -> _Tree:
        model = press.model
        chains: dict[int, tuple[int, ...]] = {joint: (joint,) for joint in range(1, model.njoints)}
        for chain in _free_bodies(press):
            for joint in chain[:-1]:
                del chains[joint]
            chains[chain[-1]] = chain
        children: dict[int, list[int]] = {}
        for joint, chain in sorted(chains.items(), key=lambda item: len(item[1])):
            children.setdefault(int(model.parents[chain[0]]), []).append(joint)
        links: dict[int, list[tuple[str, Element]]] = {}
        for link in press.document.robot.all("link"):
            links.setdefault(int(press.frame_of(link.get("name")).parentJoint), []).append((link.get("name"), link))
        for joint, of_body in links.items():
            of_body.sort(key=lambda link: link[0] != press.link_of(joint))
        sites: dict[int, list[str]] = {}
        for joint, name, place in _ends(press):
            sites.setdefault(joint, []).append(tag("site", {"name": name} | _place(place)))
        return _Tree(press, drawn, chains, children, links, sites)

    def body(self, joint: int, indent: str) -> Iterator[str]:
        """The lines of a body and of all that it carries."""
        press, (first, *welded) = self.press, self.links[joint]
        inertia, of_world = press.model.inertias[joint], not joint and first[0] == WORLD
        inside = indent if of_world else indent + "  "
        if not of_world:
            name = make_unique(first[0], {WORLD})
            yield indent + opening("body", {"name": name} | _place(self._placement(joint, self.drawn)))
            yield from (inside + line for line in (*_inertial(inertia, joint > 0, press), *self._joint(joint)))
        yield from (inside + line for line in (*_geoms(first[1]), *self.sites.get(joint, ())))
        for k, (name, element) in enumerate(welded):  # their inertias are in that of the body
            place = press.frame_of(name).placement
            yield inside + opening("body", {"name": make_unique(name, {WORLD})} | _place(place))
            if of_world and k == 0:  # MuJoCo's world has no inertia
                yield from (inside + "  " + line for line in _inertial(place.actInv(inertia), False, press))
            yield from (inside + "  " + line for line in _geoms(element))
            yield inside + "</body>"
        children = self.children.get(joint, ())
        for child in children:
            if len(self.chains[child]) == 1:
                yield from self.body(child, inside)
        if not of_world:
            yield indent + "</body>"
        for child in children:
            if len(self.chains[child]) > 1:  # only MuJoCo's world may carry a free body
                yield from self.body(child, indent)

    def _placement(self, joint: int, x: Array) -> pin.SE3:
        """Placement of a body in its parent's at joint coordinates (nv,)."""
        place = pin.SE3.Identity()
        for each in self.chains.get(joint, ()):
            place = place * self.press.model.jointPlacements[each] * self.press.axes[each - 1].step(x[each - 1])
        return place

    def _joint(self, joint: int) -> Iterator[str]:
        """The line of the joint that carries a body."""
        press, model = self.press, self.press.model
        if not joint:
            return
        if len(self.chains[joint]) > 1:
            yield tag("freejoint", {"name": model.names[joint].removesuffix(FREE[-1])})
            return
        axis, name, at = press.axes[joint - 1], str(model.names[joint]), joint - 1
        attributes = {"name": name, "type": "hinge" if axis.turns else "slide", "axis": as_text(axis.direction)}
        if self.drawn[at]:
            attributes["ref"] = as_text([self.drawn[at]])
        if np.abs(ends := [limit[at] for limit in limits(press.structure)]).max() < BOUND:
            attributes |= {"limited": "true", "range": as_text(ends)}
        springs = [spring for spring in press.joint_springs if spring.joint == name]
        if stiffness := sum(spring.stiffness for spring in springs):
            slack = sum(spring.stiffness * spring.reference for spring in springs) / stiffness
            attributes |= {"stiffness": as_text([stiffness]), "springref": as_text([slack])}
        for attribute, value in (("damping", sum(spring.damping for spring in springs)), ("armature", model.armature[at])):
            attributes |= {attribute: as_text([value])} if value else {}
        yield tag("joint", attributes)

    def start(self, x: Array) -> Array:
        """MuJoCo's ``qpos`` at joint coordinates (nv,)."""
        qpos: list[float] = []
        left = [0]
        while left:
            joint = left.pop()
            left += reversed(self.children.get(joint, ()))
            if joint and len(self.chains[joint]) == 1:
                qpos.append(float(x[joint - 1]))
            elif joint:
                place = self._placement(joint, x)
                qpos += [*place.translation, *_quaternion(place.rotation)]
        return np.array(qpos)


def _free_bodies(press: Linkage) -> Iterator[tuple[int, ...]]:
    """The six Pinocchio joints of every free body on the frame that nothing but loops moves."""
    model = press.model
    bound = {*press.motors, *(spring.joint for spring in press.joint_springs)}
    bound |= {press.joints[joint] for relation in press.relations for joint in relation.joints}
    for names in press.document.description.bases.values():
        chain = tuple(int(model.getJointId(name)) for name in names)
        if not bound & {*names} and not model.parents[chain[0]] and not any(model.armature[joint - 1] for joint in chain):
            yield chain


def _inertial(inertia: pin.Inertia, moves: bool, press: Linkage) -> Iterator[str]:
    """The inertia of a body; one that moves has some, as MuJoCo demands."""
    mass, tensor, least = float(inertia.mass), np.array(inertia.inertia), LEAST_MOMENT
    if not moves and not mass:
        return
    moments, ways = np.linalg.eigh(tensor)
    missing = max(moments[2] - moments[0] - moments[1], 0.0)
    if moments[0] < least or missing:
        if missing > 1e-9 * moments[2]:
            shown = ", ".join(f"{moment:.6g}" for moment in moments)
            problem = f"no body has the principal moments of inertia {shown} kg m2: in the MJCF the two smaller ones are raised"
            caution(f"{press.name}: {problem}, which changes no motion in a plane")
        moments = np.maximum(moments + (0.5 + 1e-12) * missing * np.array([1.0, 1.0, 0.0]), least)
        tensor = ways @ np.diag(moments) @ ways.T if tensor.any() else np.diag(moments)
    values = {"pos": as_text(inertia.lever if mass else np.zeros(3)), "mass": as_text([max(mass, LEAST_MASS if moves else 0.0)])}
    yield tag("inertial", values | {"fullinertia": as_text(tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])})


def _geoms(link: Element) -> Iterator[str]:
    """The boxes, cylinders and spheres of a link."""
    for visual in link.all("visual"):
        place = place_of(visual)
        colour = [rgba for material in visual.all("material") for each in material.all("color") if (rgba := each.numbers("rgba"))]
        looks = {"rgba": as_text(colour[0])} if colour else {}
        for shape in (shape for geometry in visual.all("geometry") for shape in geometry.all("box", "cylinder", "sphere")):
            first = 0.5 * np.array(shape.numbers("size")) if shape.tag == "box" else shape.numbers("radius")
            size = [*first, *(0.5 * np.array(shape.numbers("length")))]
            kind = {"type": shape.tag, "size": as_text(size), "contype": "0", "conaffinity": "0", "mass": "0"}
            yield tag("geom", kind | _place(place) | looks)


def _ends(press: Linkage) -> Iterator[tuple[int, str, pin.SE3]]:
    """The sites at the ends of loops: their Pinocchio joints, names and places in these joints' frames."""
    for loop in press.loops:
        ends = (loop.joint1, loop.point1, loop.rotation1), (loop.joint2, loop.point2, loop.rotation2)
        for k, (joint, point, rotation) in enumerate(ends, 1):
            yield joint, f"{loop.name}_{k}", pin.SE3(rotation, point)
            if loop.type == "revolute":
                yield joint, f"{_second(press, loop)}_{k}", pin.SE3(rotation, point + LEVER * press.size * rotation[:, 0])


def _closings(press: Linkage) -> Iterator[str]:
    """The equalities of the loops."""
    for loop in press.loops:
        for name in (loop.name, _second(press, loop)) if loop.type == "revolute" else (loop.name,):
            yield tag("weld" if loop.type == "fixed" else "connect", {"name": name, "site1": f"{name}_1", "site2": f"{name}_2"})


def _second(press: Linkage, loop: LoopJoint) -> str:
    """Name of the second point of a hinge."""
    return make_unique(f"{loop.name}_axis", press.bearings)


def _related(press: Linkage, drawn: Array, relation: Relation, tendon: str) -> str:
    """The equality of a relation, which counts from the drawn pose, by the tendon of one with more than two joints."""
    offset = relation.offset - sum(coefficient * float(drawn[joint]) for joint, coefficient in relation.coefficients.items())
    name, (first, *others) = {"name": make_unique(f"relation_{relation.name}", press.bearings)}, relation.coefficients
    if tendon:
        return tag("tendon", name | {"tendon1": tendon, "polycoef": as_text([offset, 0.0, 0.0, 0.0, 0.0])})
    scale, ratio = relation.coefficients[first], 0.0
    joints = {"joint1": press.joints[first]}
    if others:
        joints["joint2"] = press.joints[others[0]]
        ratio = -relation.coefficients[others[0]] / scale
    return tag("joint", name | joints | {"polycoef": as_text([offset / scale, ratio, 0.0, 0.0, 0.0])})


def _tendon(press: Linkage, relation: Relation, name: str) -> str:
    """The tendon of joints whose length is the left-hand side of a relation."""
    joints = (tag("joint", {"joint": press.joints[joint], "coef": as_text([value])}) for joint, value in relation.coefficients.items())
    return tag("fixed", {"name": name}, "".join(joints))


def _effort(press: Linkage, joint: str) -> dict[str, str]:
    """The limits of the control of a motor, if its joint has a limit of effort."""
    most = float(press.model.upperEffortLimit[press.joints.index(joint)])
    return {"ctrllimited": "true", "ctrlrange": as_text([-most, most])} if 0.0 < most < BOUND else {}


def _place(place: pin.SE3) -> dict[str, str]:
    """The attributes of a placement."""
    turned = {} if np.array_equal(place.rotation, np.eye(3)) else {"quat": as_text(_quaternion(place.rotation))}
    return {"pos": as_text(place.translation)} | turned


def _quaternion(rotation: Array) -> list[float]:
    """w, x, y and z of a rotation matrix."""
    turned = pin.Quaternion(rotation)
    return [turned.w, turned.x, turned.y, turned.z]
