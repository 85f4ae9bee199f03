"""Write the URDF of a press that a pin table describes, with comments and a shape for every link."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

import numpy as np
import pinocchio as pin

from ..common.quantities import Array
from ..visual.shapes.appearance import STAND_IN, ShownLink
from ..visual.shapes.solids import Box, Cylinder, Part, Plate, Shape, Sphere
from .copies import Parts
from .links import FRAME, Link, axes_along
from .placement import Pin
from .tool import Tool
from .tree import Joint, Tree

REACH = 2.0  # limits of a guide without travel, in sizes of the press: URDF asks for limits, and the slide must not reach them
ENDLESS = 1e6  # limits of a guide that follows a shaft: the shaft may turn without end [m]
EFFORT, VELOCITY = 1e9, 1e3  # limits that URDF asks for; so large that they limit nothing
REMARK = f"  <!-- Shapes named {STAND_IN} are for other programs; pinpress draws its own. Rename those that you change. -->"
CROSS = "_cross"  # added to the name of a ball joint that a link hangs by


@dataclass(frozen=True, eq=False)
class _Place:
    """A link's frame in the drawn pose."""

    origin: Array
    rotation: Array

    def inside(self, other: _Place) -> _Place:
        """The other frame in coordinates of this frame."""
        return _Place(self.rotation.T @ (other.origin - self.origin), self.rotation.T @ other.rotation)

    def point(self, world: Array) -> Array:
        """Coordinates of a world point in this frame."""
        return np.asarray(self.rotation.T @ (world - self.origin))


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


class _Writer:
    def __init__(self, name: str, comment: str, parts: Parts, tree: Tree, tool: Tool | None, shapes: Mapping[str, Sequence[str]]) -> None:
        self.name, self.comment, self.parts, self.tree, self.tool, self.shapes = name, comment, parts, tree, tool, shapes
        self.links = {link.name: link for link in parts.links}
        points = np.array([pin.point for pin in parts.pins.values()])
        self.size = float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0
        by = {joint.child: joint for joint in tree.joints}
        self.places = {FRAME: _Place(np.zeros(3), np.eye(3))} | {n: self._place(by[n], link) for n, link in self.links.items()}

    def _place(self, joint: Joint, link: Link) -> _Place:
        return _Place(link.origin if joint.pin is None else self.parts.pins[joint.pin].point, link.rotation)

    def text(self) -> str:
        """The whole file."""
        lines = ['<?xml version="1.0"?>', "<!--", *(f"  {line}".rstrip() for line in self.comment.replace("--", "- -").splitlines()), "-->"]
        lines += [f"<robot name={quoteattr(self.name)}>", *([REMARK] if self.shapes else []), *self._frame()]
        for link in self.links.values():
            lines += ["", *self._link(link)]
        lines.append("")
        for joint in self.tree.joints:
            lines += self._joint(joint)
        lines.append("")
        lines += [self._loop(*each) for each in self._loops()]
        for name in self.tree.drivers:
            lines += ["", f'  <transmission name="{name}_transmission"><joint name="{name}"/></transmission>']
        return "\n".join([*lines, "</robot>", ""])

    # Links

    def _frame(self) -> list[str]:
        shapes = self.shapes.get(FRAME)
        if not shapes:
            return [f'  <link name="{FRAME}"/>']
        return [f'  <link name="{FRAME}">', *(f"    {shape}" for shape in shapes), "  </link>"]

    def _link(self, link: Link) -> Iterator[str]:
        place = self.places[link.name]
        for estimate in link.estimates:
            yield f"  <!-- Estimated: {estimate.replace('--', '- -')}. -->"
        inertia = place.rotation.T @ link.inertia @ place.rotation
        scale = float(np.abs(inertia).max())
        moments = {f"i{a}{b}": _number(inertia[i, j], scale) for a, b, i, j in _MOMENTS}
        yield f'  <link name="{link.name}">'
        centre = _vector(place.point(link.centre), self.size)
        yield f'    <inertial><origin xyz="{centre}"/><mass value="{_number(link.mass)}"/>{_tag("inertia", moments)}</inertial>'
        yield from (f"    {shape}" for shape in self.shapes.get(link.name, ()))
        if self.tool is not None and self.tool.link == link.name:
            yield f"    {_tag('tool', {'name': self.tool.name, 'xyz': _vector(place.point(self.tool.point), self.size)})}"
        yield "  </link>"

    # Bearings

    def _joint(self, joint: Joint) -> list[str]:
        link = self.links[joint.child]
        at = None if joint.pin is None else self.parts.pins[joint.pin]
        if at is None:
            return self._guide(joint, link)
        if at.axis is None:
            return self._ball(joint, link, at)
        axis = self.places[joint.child].rotation.T @ at.axis
        return [self._hinge(joint.name, joint.parent, joint.child, axis, self.places[joint.child])]

    def _hinge(self, name: str, parent: str, child: str, axis: Array, place: _Place, parent_place: _Place | None = None) -> str:
        origin = self._origin((parent_place or self.places[parent]).inside(place))
        ends = f'<parent link="{parent}"/><child link="{child}"/>'
        return f'  <joint name="{name}" type="continuous">{ends}{origin}<axis xyz="{_vector(axis, 1.0)}"/>{self._mimic(name)}</joint>'

    def _guide(self, joint: Joint, link: Link) -> list[str]:
        assert link.guide is not None
        place = self.places[joint.child]
        axis = _vector(place.rotation.T @ link.guide.direction, 1.0)
        follows = joint.name in self.tree.gears and joint.name not in self.tree.drivers
        reach = ENDLESS if follows else REACH * self.size
        lower, upper = link.guide.travel or (-reach, reach)
        limit = f'<limit lower="{_number(lower)}" upper="{_number(upper)}" effort="{_number(EFFORT)}" velocity="{_number(VELOCITY)}"/>'
        ends = f'<parent link="{joint.parent}"/><child link="{joint.child}"/>{self._origin(self.places[joint.parent].inside(place))}'
        return [f'  <joint name="{joint.name}" type="prismatic">{ends}<axis xyz="{axis}"/>{limit}{self._mimic(joint.name)}</joint>']

    def _ball(self, joint: Joint, link: Link, at: Pin) -> list[str]:
        """Hinges with massless crosses between them: two for a rod between two balls, so that it cannot spin; three for any other link."""
        others = [self.parts.pins[name] for name in link.pins if name != joint.pin]
        rod = len(others) == 1 and others[0].axis is None
        way = others[0].point - at.point if others else np.array([0.0, 0.0, 1.0])
        along = axes_along(way)
        axes = [along[:, 1], along[:, 2]] if rod else [along[:, 1], along[:, 2], along[:, 0]]
        lines, parent, place = [], joint.parent, None
        for k, axis in enumerate(axes[:-1]):
            cross = f"{joint.name}{CROSS}{k + 1 if len(axes) > 2 else ''}"
            lines.append(_light(f"{cross}_link", 0.0, 0.0))
            own = _Place(at.point, np.eye(3))
            lines.append(self._hinge(cross, parent, f"{cross}_link", axis, own, place))
            parent, place = f"{cross}_link", own
        own = self.places[joint.child]
        lines.append(self._hinge(joint.name, parent, joint.child, own.rotation.T @ axes[-1], own, place))
        return lines

    def _mimic(self, name: str) -> str:
        if name not in self.tree.gears:
            return ""
        leader, ratio = self.tree.gears[name]
        return f'<mimic joint="{leader}" multiplier="{_number(ratio)}" offset="0"/>'

    def _loops(self) -> Iterator[tuple[str, str, str, Pin]]:
        for loop in self.tree.loops:
            yield loop.name, loop.link1, loop.link2, self.parts.pins[loop.pin]

    def _loop(self, name: str, link1: str, link2: str, at: Pin) -> str:
        """A loop joint. Pins in the picture's plane and balls need only coincident points; a hinge in space also needs a common axis."""
        hinge = at.in_space and at.axis is not None
        turn = _axes_with_z(at.axis)[:, [2, 0, 1]] if hinge and at.axis is not None else None  # x along the axis

        def end(tag: str, link: str) -> str:
            place = self.places[link]
            xyz = _vector(place.point(at.point), self.size)
            rpy = "0 0 0" if turn is None else _vector(_rpy(place.rotation.T @ turn), 1.0)
            return f'<{tag} link="{link}" xyz="{xyz}" rpy="{rpy}"/>'

        kind = "revolute" if hinge else "spherical"
        axis = '<axis xyz="1 0 0"/>' if hinge else ""
        return f'  <loop_joint name="{name}" type="{kind}">{end("link1", link1)}{end("link2", link2)}{axis}</loop_joint>'

    def _origin(self, place: _Place) -> str:
        return _origin(place.origin, place.rotation, self.size)


_MOMENTS = (("x", "x", 0, 0), ("x", "y", 0, 1), ("x", "z", 0, 2), ("y", "y", 1, 1), ("y", "z", 1, 2), ("z", "z", 2, 2))


def _origin(point: Array, rotation: Array, size: float) -> str:
    xyz, rpy = _vector(point, size), _vector(_rpy(rotation), 1.0)
    return f'<origin xyz="{xyz}"/>' if rpy == "0 0 0" else f'<origin xyz="{xyz}" rpy="{rpy}"/>'


def _visuals(part: Part, link: str) -> Iterator[str]:
    """A coloured solid, rounded to a hundredth of a millimetre. URDF has no plates, so a plate is drawn as boxes side by side."""
    if isinstance(part.shape, Plate):
        for strip, (x, y) in part.shape.strips():
            moved = part.placement @ np.array([x, y, 0.0, 1.0])
            yield _visual(strip, moved[:3], part, link)
    else:
        yield _visual(part.shape, part.placement[:3, 3], part, link)


def _visual(shape: Shape, centre: Array, part: Part, link: str) -> str:
    if isinstance(shape, Box):
        solid = f'<box size="{_vector(np.round(shape.size, 5))}"/>'
    elif isinstance(shape, Cylinder):
        solid = f'<cylinder radius="{_number(round(shape.radius, 5))}" length="{_number(round(shape.length, 5))}"/>'
    else:
        assert isinstance(shape, Sphere)
        solid = f'<sphere radius="{_number(round(shape.radius, 5))}"/>'
    place = _origin(np.round(centre, 5) + 0.0, part.placement[:3, :3], 1.0)
    colour = _vector(np.round(part.rgba, 3))
    paint = f'<material name="{link} {colour}"><color rgba="{colour}"/></material>'
    return f'<visual name="{STAND_IN}">{place}<geometry>{solid}</geometry>{paint}</visual>'


def _light(name: str, mass: float, moment: float) -> str:
    """A link with almost no mass or no mass, with the same moment of inertia about all axes."""
    moments = {f"i{a}{b}": _number(moment if a == b else 0.0) for a, b, _, _ in _MOMENTS}
    return f'  <link name="{name}"><inertial><mass value="{_number(mass)}"/>{_tag("inertia", moments)}</inertial></link>'


def _rpy(rotation: Array) -> Array:
    """Roll, pitch and yaw. A turn about y has only a pitch, of any size."""
    if abs(rotation[1, 1] - 1.0) < 1e-15:
        return np.array([0.0, math.atan2(rotation[0, 2], rotation[0, 0]), 0.0])
    return np.asarray(pin.rpy.matrixToRpy(rotation))


def _axes_with_z(direction: Array) -> Array:
    """Axes whose z is along a direction, like the axis of a URDF cylinder."""
    other = np.eye(3)[int(np.abs(direction).argmin())]
    x = np.cross(other, direction)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(direction, x), direction], axis=1)


def _vector(values: Array | Sequence[float], scale: float = 0.0) -> str:
    return " ".join(_number(float(value), scale) for value in values)


def _number(value: float, scale: float = 0.0) -> str:
    """A number at full precision; zero if it is within rounding error of the scale."""
    if abs(value) <= 1e-16 * scale:
        return "0"
    return repr(float(value)).removesuffix(".0")


def _tag(name: str, attributes: Mapping[str, str]) -> str:
    return f"<{name} {' '.join(f'{key}={quoteattr(value)}' for key, value in attributes.items())}/>"
