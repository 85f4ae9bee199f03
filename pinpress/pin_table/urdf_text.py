"""Write the URDF of a press that a pin table describes, with comments and a shape for every link."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from xml.sax.saxutils import quoteattr

import numpy as np
import pinocchio as pin

from ..common.quantities import Array
from ..visual.shapes.appearance import STAND_IN, ShownLink
from ..visual.shapes.solids import Box, Cylinder, Part, Plate, Shape, Sphere, TriangleMesh
from .copies import Parts
from .links import FRAME, Link, axes_along
from .machine_elements import MachineElement
from .placement import Pin, size_of
from .tool import Tool
from .tree import Bearing, Tree

REACH = 2.0  # limits of a guide without travel, in sizes of the press: URDF asks for limits, and the slide must not reach them
ENDLESS = 1e6  # limits of a guide that follows a shaft or a pinion: the shaft may turn without end [m]
EFFORT, VELOCITY = 1e9, 1e3  # limits that URDF asks for; so large that they limit nothing
REMARK = f"  <!-- Shapes named {STAND_IN} are for other programs; pinpress draws its own. Rename those that you change. -->"
MOMENTS = (("xx", 0, 0), ("xy", 0, 1), ("xz", 0, 2), ("yy", 1, 1), ("yz", 1, 2), ("zz", 2, 2))
WITHOUT_MASS = '<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'


def urdf_text(name: str, comment: str, parts: Parts, tree: Tree, tool: Tool | None = None, bodies: Sequence[ShownLink] = ()) -> bytes:
    """The URDF as UTF-8.

    Args:
        name: of the press.
        comment: at the top of the file.
        parts: links and pins in the drawn pose.
        tree: their bearings.
        tool: point of the slide where process forces act; None: the slide's pins determine it.
        bodies: shapes of the links; empty: the URDF has no shapes.
    """
    shapes = {body.name: [visual for each in body.parts for visual in _visuals(each, body.name)] for body in bodies}
    return _Writer(name, comment, parts, tree, tool, shapes).text().encode(errors="replace")  # a file's name need not be UTF-8


def drawn_frames(parts: Parts, tree: Tree) -> dict[str, pin.SE3]:
    """Frames of the links in the drawn pose, by the links' names; lengths in m."""
    links, frames = {link.name: link for link in parts.links}, {FRAME: pin.SE3.Identity()}
    for joint in tree.joints:
        link = links[joint.link2]
        frames[link.name] = pin.SE3(link.rotation, link.origin if joint.pin is None else parts.pins[joint.pin].point)
    return frames


class _Writer:
    def __init__(self, name: str, comment: str, parts: Parts, tree: Tree, tool: Tool | None, shapes: Mapping[str, Sequence[str]]) -> None:
        self.name, self.comment, self.parts, self.tree, self.tool, self.shapes = name, comment, parts, tree, tool, shapes
        self.links = {link.name: link for link in parts.links}
        self.size = size_of(parts.pins) or 1.0
        self.places = drawn_frames(parts, tree)

    def text(self) -> str:
        """The whole file."""
        lines = ['<?xml version="1.0"?>', "<!--", *(f"  {line}".rstrip() for line in self.comment.replace("--", "- -").splitlines()), "-->"]
        lines += [f"<robot name={quoteattr(self.name)}>", *([REMARK] if self.shapes else [])]
        shown = [f"    {shape}" for shape in self.shapes.get(FRAME, ())]
        lines += [f'  <link name="{FRAME}">', *shown, "  </link>"] if shown else [f'  <link name="{FRAME}"/>']
        for link in self.links.values():
            lines += ["", *self._link(link)]
        lines += ["", *(line for joint in self.tree.joints for line in self._joint(joint)), "", *map(self._loop, self.tree.loops)]
        lines += map(self._element, self.parts.elements)
        for name in self.tree.drivers:
            lines += ["", f'  <transmission name="{name}_transmission"><joint name="{name}"/></transmission>']
        return "\n".join([*lines, "</robot>", ""])

    def _link(self, link: Link) -> Iterator[str]:
        place = self.places[link.name]
        for estimate in link.estimates:
            yield f"  <!-- Estimated: {estimate.replace('--', '- -')}. -->"
        inertia = place.rotation.T @ link.inertia @ place.rotation
        scale = float(np.abs(inertia).max())
        moments = " ".join(f'i{name}="{_number(inertia[i, j], scale)}"' for name, i, j in MOMENTS)
        yield f'  <link name="{link.name}">'
        centre = _vector(place.actInv(link.centre), self.size)
        yield f'    <inertial><origin xyz="{centre}"/><mass value="{_number(link.mass)}"/><inertia {moments}/></inertial>'
        yield from (f"    {shape}" for shape in self.shapes.get(link.name, ()))
        if self.tool is not None and self.tool.link == link.name:
            point = _vector(place.actInv(self.tool.point), self.size)
            yield f'    <tool name={quoteattr(self.tool.name)} xyz="{point}"/>'
        yield "  </link>"

    def _joint(self, joint: Bearing) -> list[str]:
        link = self.links[joint.link2]
        if joint.pin is None:
            return [self._guide(joint, link)]
        at = self.parts.pins[joint.pin]
        if at.axis is None:
            return self._ball(joint, link, at)
        axis = self.places[joint.link2].rotation.T @ at.axis
        return [self._hinge(joint.name, joint.link1, joint.link2, axis, self.places[joint.link1].actInv(self.places[joint.link2]))]

    def _hinge(self, name: str, parent: str, child: str, axis: Array, place: pin.SE3) -> str:
        """A hinge, with the place of the child's frame in the parent's."""
        ends = f'<parent link="{parent}"/><child link="{child}"/>{_origin(place, self.size)}'
        return f'  <joint name="{name}" type="continuous">{ends}<axis xyz="{_vector(axis, 1.0)}"/>{self._mimic(name)}</joint>'

    def _guide(self, joint: Bearing, link: Link) -> str:
        assert link.guide is not None
        place = self.places[joint.link2]
        axis = _vector(place.rotation.T @ link.guide.direction, 1.0)
        meshing = any(link.name in element.bodies for element in self.parts.elements if element.section in ("racks", "screws"))
        follows = (meshing or joint.name in self.tree.gears) and joint.name not in self.tree.drivers
        reach = ENDLESS if follows else REACH * self.size
        lower, upper = link.guide.travel or (-reach, reach)
        limit = f'<limit lower="{_number(lower)}" upper="{_number(upper)}" effort="{_number(EFFORT)}" velocity="{_number(VELOCITY)}"/>'
        origin = _origin(self.places[joint.link1].actInv(place), self.size)
        ends = f'<parent link="{joint.link1}"/><child link="{joint.link2}"/>{origin}'
        return f'  <joint name="{joint.name}" type="prismatic">{ends}<axis xyz="{axis}"/>{limit}{self._mimic(joint.name)}</joint>'

    def _ball(self, joint: Bearing, link: Link, at: Pin) -> list[str]:
        """Hinges with massless crosses between them: two for a rod between two balls, so that it cannot spin; three for any other link."""
        others = [self.parts.pins[name] for name in link.pins if name != joint.pin]
        rod = len(others) == 1 and others[0].axis is None
        along = axes_along(others[0].point - at.point if others else np.array([0.0, 0.0, 1.0]))
        axes = [along[:, 1], along[:, 2]] if rod else [along[:, 1], along[:, 2], along[:, 0]]
        lines, parent, place = [], joint.link1, self.places[joint.link1]
        for k, axis in enumerate(axes[:-1]):
            cross = f"{joint.name}_cross{k + 1 if len(axes) > 2 else ''}"
            upright = pin.SE3(np.eye(3), at.point)
            lines.append(f'  <link name="{cross}_link">{WITHOUT_MASS}</link>')
            lines.append(self._hinge(cross, parent, f"{cross}_link", axis, place.actInv(upright)))
            parent, place = f"{cross}_link", upright
        last = self.places[joint.link2]
        return [*lines, self._hinge(joint.name, parent, joint.link2, last.rotation.T @ axes[-1], place.actInv(last))]

    def _mimic(self, name: str) -> str:
        if name not in self.tree.gears:
            return ""
        leader, ratio = self.tree.gears[name]
        return f'<mimic joint="{leader}" multiplier="{_number(ratio)}" offset="0"/>'

    def _loop(self, loop: Bearing) -> str:
        """A loop joint. Pins in the picture's plane and balls need only coincident points; a hinge in space also needs a common axis."""
        assert loop.pin is not None
        at = self.parts.pins[loop.pin]
        hinge = at.in_space and at.axis is not None
        ends = ""
        for tag, link in (("link1", loop.link1), ("link2", loop.link2)):
            place = self.places[link]
            turn = "0 0 0" if at.axis is None or not hinge else _vector(_rpy(place.rotation.T @ _axes_with_x(at.axis)), 1.0)
            ends += f'<{tag} link="{link}" xyz="{_vector(place.actInv(at.point), self.size)}" rpy="{turn}"/>'
        kind, axis = ("revolute", '<axis xyz="1 0 0"/>') if hinge else ("spherical", "")
        return f'  <loop_joint name="{loop.name}" type="{kind}">{ends}{axis}</loop_joint>'

    def _element(self, element: MachineElement) -> str:
        """A machine element; the centre of a roller, or of a gear without a bearing of its own, is in the frame of its link."""
        said: dict[str, float | str] = {"name": element.name, **element.links}
        said |= element.values
        for (key, name), link in zip(element.centres.items(), (element.bodies[key != "center1"] for key in element.centres), strict=True):
            said[key] = _vector(self.places[link].actInv(self.parts.pins[name].point), self.size)
        points = "".join(f"<{tag} {_attributes(each)}/>" for tag, each in element.points)
        return f"  <{element.tag} {_attributes(said)}{f'>{points}</{element.tag}>' if points else '/>'}"


def _origin(place: pin.SE3, size: float) -> str:
    xyz, rpy = _vector(place.translation, size), _vector(_rpy(place.rotation), 1.0)
    return f'<origin xyz="{xyz}"/>' if rpy == "0 0 0" else f'<origin xyz="{xyz}" rpy="{rpy}"/>'


def _visuals(part: Part, link: str) -> Iterator[str]:
    """A coloured solid, rounded to a hundredth of a millimetre. URDF has no plates, so a plate is drawn as boxes side by side; nor has it
    triangles outside of files, so that pitch circles and threads are left out."""
    if isinstance(part.shape, Plate):
        for strip, (x, y) in part.shape.strips():
            moved = part.placement @ np.array([x, y, 0.0, 1.0])
            yield _visual(strip, moved[:3], part, link)
    elif not isinstance(part.shape, TriangleMesh):
        yield _visual(part.shape, part.placement[:3, 3], part, link)


def _visual(shape: Shape, centre: Array, part: Part, link: str) -> str:
    if isinstance(shape, Box):
        solid = f'<box size="{_vector(np.round(shape.size, 5))}"/>'
    elif isinstance(shape, Cylinder):
        solid = f'<cylinder radius="{_number(round(shape.radius, 5))}" length="{_number(round(shape.length, 5))}"/>'
    else:
        assert isinstance(shape, Sphere)
        solid = f'<sphere radius="{_number(round(shape.radius, 5))}"/>'
    place = _origin(pin.SE3(part.placement[:3, :3], np.round(centre, 5) + 0.0), 1.0)
    colour = _vector(np.round(part.rgba, 3))
    paint = f'<material name="{link} {colour}"><color rgba="{colour}"/></material>'
    return f'<visual name="{STAND_IN}">{place}<geometry>{solid}</geometry>{paint}</visual>'


def _rpy(rotation: Array) -> Array:
    """Roll, pitch and yaw. A turn about y has only a pitch, of any size."""
    if abs(rotation[1, 1] - 1.0) < 1e-15:
        return np.array([0.0, math.atan2(rotation[0, 2], rotation[0, 0]), 0.0])
    return np.asarray(pin.rpy.matrixToRpy(rotation))


def _axes_with_x(direction: Array) -> Array:
    """Axes (3, 3) whose x is along a direction."""
    y = np.cross(np.eye(3)[int(np.abs(direction).argmin())], direction)
    y /= np.linalg.norm(y)
    return np.stack([direction, y, np.cross(direction, y)], axis=1)


def _attributes(said: Mapping[str, float | str]) -> str:
    return " ".join(f"{key}={quoteattr(value if isinstance(value, str) else _number(value))}" for key, value in said.items())


def _vector(values: Array | Sequence[float], scale: float = 0.0) -> str:
    return " ".join(_number(float(value), scale) for value in values)


def _number(value: float, scale: float = 0.0) -> str:
    """A number at full precision; zero if it is within rounding error of the scale."""
    if abs(value) <= 1e-16 * scale:
        return "0"
    return repr(float(value)).removesuffix(".0")
