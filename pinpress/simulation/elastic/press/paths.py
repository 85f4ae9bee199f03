"""The lengths along which loads act on a press on springs: a point of a link along a direction, the distance between two points.

They are `Coordinate`s of the driven press, for links that yield: values, rates and derivatives by the free coordinates. Points and
directions are those of the press's geometry: (2,) in the axes of a plane, with complex arms of points, or (3,) in world axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from ....common.errors import PinpressError, shown
from ....common.quantities import Array
from ....engines.planar.model import to_complex
from ....engines.structure import drawn_placements
from ...driven_press import Coordinate, End, JointPosition, Length, Turn, WorkOfForce, WorkOfMoment
from .geometry import BodyState, Geometry
from .plane import DrawnBodies, Lines, PlaneGeometry
from .sprung_press import SprungPress

NEAREST = 1e-300  # least length of a distance, which has no direction where it is zero [m]


class PathMotion(NamedTuple):
    """A length along which a load acts, at n states.

    Attributes:
        value: (n,) [m].
        rate: (n,) [m/s].
        gradient: (n, f) of the value by the free coordinates.
        bend: (n, f, f) its second derivatives.
    """

    value: Array
    rate: Array
    gradient: Array
    bend: Array


class LoadPath(Protocol):
    """A length of a press on springs along which a load acts."""

    def over(self, sprung: SprungPress, state: BodyState) -> PathMotion:
        """The path at n states."""


@dataclass(frozen=True, eq=False)
class PointPath:
    """How far a point of a body has moved along a direction.

    Attributes:
        body: the body.
        arm: the point from the body's centre of mass.
        direction: of length 1, or a force, along which the value is its work.
        offset: the value where the point is at the origin [m].
    """

    body: int
    arm: Any
    direction: Array
    offset: float

    def over(self, sprung: SprungPress, state: BodyState) -> PathMotion:
        point = sprung.geometry.point(state, self.body, self.arm)
        gradient = point.by @ self.direction
        value = point.place @ self.direction + self.offset
        return _path(sprung, state, value, gradient, point.twice(self.direction))


@dataclass(frozen=True, eq=False)
class LengthPath:
    """Distance between two points of bodies.

    Attributes:
        bodies: the bodies.
        arms: the points from their centres of mass.
        height: how far they lie apart along the normal of a plane [m].
        sign: -1 where the path counts the distance negatively.
    """

    bodies: tuple[int, int]
    arms: tuple[Any, Any]
    height: float = 0.0
    sign: float = 1.0

    def over(self, sprung: SprungPress, state: BodyState) -> PathMotion:
        one, two = (sprung.geometry.point(state, body, arm) for body, arm in zip(self.bodies, self.arms, strict=True))
        apart, by = two.place - one.place, two.by - one.by
        length = np.maximum(np.sqrt((apart**2).sum(axis=1) + self.height**2), NEAREST)
        along = apart / length[:, None]
        gradient = (by @ along[:, :, None])[..., 0]
        bend = (by @ by.swapaxes(1, 2) - gradient[:, :, None] * gradient[:, None, :]) / length[:, None, None]
        bend += two.twice(along) - one.twice(along)
        return _path(sprung, state, self.sign * length, self.sign * gradient, self.sign * bend)


@dataclass(frozen=True, eq=False)
class LinePath:
    """The extension of a line.

    Attributes:
        line: the geometry with that line alone.
        offset: the value in the drawn pose [m].
    """

    line: Geometry
    offset: float = 0.0

    def over(self, sprung: SprungPress, state: BodyState) -> PathMotion:
        at = self.line.strains(state)
        bend = self.line.bend(at, np.ones((len(state.coordinates), 1)))
        gradient = sprung.to_free(self.line.gradient(at)[:, 0])
        return PathMotion(at.extension[:, 0] + self.offset, at.opening[:, 0], gradient, sprung.to_free_twice(bend))


@dataclass(frozen=True, eq=False)
class AnglePath:
    """Angle of a body of a plane against another one.

    Attributes:
        bodies: the bodies.
        factor: of the angle, which is positive about the plane's normal; a moment, along which the value is its work.
        outside: whether the first body is the ground also where the frame stands on mounts.
    """

    bodies: tuple[int, int]
    factor: float
    outside: bool = False

    def over(self, sprung: SprungPress, state: BodyState) -> PathMotion:
        gradient = np.zeros_like(state.coordinates)
        for body, sign in zip(self.bodies, (-1.0, 1.0), strict=True):
            gradient[:, 3 * body + 2] += sign * self.factor
        value, count = np.einsum("nk,nk->n", gradient, state.coordinates), gradient.shape[1]
        return _path(sprung, state, value, gradient, np.zeros((len(value), count, count)))


def _path(sprung: SprungPress, state: BodyState, value: Array, gradient: Array, bend: Array) -> PathMotion:
    """A path, of derivatives by all coordinates."""
    return PathMotion(value, np.einsum("nk,nk->n", gradient, state.rates), sprung.to_free(gradient), sprung.to_free_twice(bend))


def load_path(sprung: SprungPress, coordinate: Coordinate) -> LoadPath:
    """The path of a coordinate along which forces act."""
    press, place = sprung.press, _Places(sprung)
    if isinstance(coordinate, JointPosition):  # with one driver it is the slide's
        body, arm = place.of((coordinate.joint + 1, press.tool.in_body))
        direction = place.vector(press.slide_direction)
        drawn = place.drawn((coordinate.joint + 1, press.tool.in_body))
        return PointPath(body, arm, direction, coordinate.offset - float(direction @ drawn))
    if isinstance(coordinate, Length):
        (first, one), (second, two) = place.of(coordinate.first), place.of(coordinate.second)
        return LengthPath((first, second), (one, two), place.height(coordinate.second) - place.height(coordinate.first))
    if isinstance(coordinate, Turn):
        first, second = coordinate.turn.bodies
        axis = drawn_placements(press.model)[second].rotation @ coordinate.turn.axis
        return AnglePath((place.body(first), place.body(second)), float(axis @ place.normal))
    if isinstance(coordinate, WorkOfMoment):
        return AnglePath((place.body(0), place.body(coordinate.joint)), float(coordinate.moment @ place.normal), not coordinate.braced)
    assert isinstance(coordinate, WorkOfForce)
    return PointPath(*place.of(coordinate.end), place.vector(coordinate.force), 0.0)


class _Places:
    """Where points of links are in the geometry of a press."""

    def __init__(self, sprung: SprungPress) -> None:
        self.press, self.geometry = sprung.press, sprung.geometry
        self.bodies = DrawnBodies(sprung.press) if isinstance(sprung.geometry, PlaneGeometry) else None

    def of(self, end: End) -> tuple[int, Any]:
        """Body and arm of a point of a link, in the frame of Pinocchio's joint; in space a cross without mass has the point of its joint
        alone, which the body behind it has too."""
        (joint, point), geometry = end, self.geometry
        if self.bodies is not None:
            body = joint - 1 if joint else len(geometry.centers) - 1
            return body, self.bodies.point(joint - 1, point) - complex(geometry.centers[body])
        if joint == 0:
            return geometry.count, np.asarray(point, dtype=float)
        body = geometry.joints.index(joint)
        return body, geometry.own_axes[body].T @ (np.asarray(point, dtype=float) - geometry.lever[body])

    def body(self, joint: int) -> int:
        """The body of a Pinocchio joint."""
        return self.of((joint, np.zeros(3)))[0]

    @property
    def normal(self) -> Array:
        """The plane's normal in the world, about which angles of bodies are positive."""
        if self.bodies is None:
            name = self.press.name
            raise PinpressError(f"{name} moves in space, where elastic motion takes no moments and torsion springs: leave them out")
        return self.bodies.plane.normal

    def vector(self, along: Array) -> Array:
        """A vector of world axes in those of the geometry."""
        if self.bodies is None:
            return along
        across = complex(to_complex(self.bodies.plane, along))
        return np.array([across.real, across.imag])

    def drawn(self, end: End) -> Array:
        """The point of a link on the frame in the drawn pose."""
        if self.bodies is None:
            return np.asarray(self.press.model.jointPlacements[end[0]].act(end[1]))
        place = self.bodies.point(end[0] - 1, end[1])
        return np.array([place.real, place.imag])

    def height(self, end: End) -> float:
        """Where a point of a link lies along the plane's normal [m]; 0 in space."""
        if self.bodies is None:
            return 0.0
        plane, joint = self.bodies.plane, end[0] - 1
        return float(plane.normal @ end[1]) if joint < 0 else float(plane.heights[joint] + plane.frames[joint][2] @ end[1])


def refuse_on_flexible_links(sprung: SprungPress, paths: Sequence[LoadPath]) -> None:
    """Raise PinpressError where a load acts on a link that bends: nothing says which of its nodes it moves."""
    for path in paths:
        bodies = (path.body,) if isinstance(path, PointPath) else path.bodies if isinstance(path, LengthPath | AnglePath) else ()
        for link in sprung.geometry.flexible if isinstance(sprung.geometry, PlaneGeometry) else ():
            if link.body in bodies:
                raise PinpressError(
                    f"a load acts on the flexible link {shown(link.name)}: it may bend between its pins alone; load another link"
                )


def from_frame(sprung: SprungPress, paths: Sequence[LoadPath], slide: bool) -> tuple[LoadPath, ...]:
    """Paths that count from a frame on mounts in place of the ground; ``slide``: whether the first is the slide's position."""
    geometry, base = sprung.geometry, sprung.geometry.base
    ground, counted = len(geometry.centers) - 1, list[LoadPath]()
    for number, path in enumerate(paths):
        if isinstance(path, PointPath) and slide and number == 0:
            point, along = complex(geometry.centers[path.body]) + path.arm, complex(*path.direction)
            row = (base, path.body, point - geometry.centers[base], path.arm, along, 1.0)
            line = replace(geometry, lines=Lines._make(np.array([value]) for value in row), shapes=np.zeros((2, 1, 0), dtype=complex))
            counted.append(LinePath(line, path.offset + (along.conjugate() * point).real))
        elif isinstance(path, LengthPath):
            centre = geometry.centers[base]
            ends = [
                (base, complex(arm - centre)) if body == ground else (body, arm) for body, arm in zip(path.bodies, path.arms, strict=True)
            ]
            counted.append(replace(path, bodies=(ends[0][0], ends[1][0]), arms=(ends[0][1], ends[1][1])))
        elif isinstance(path, AnglePath) and not path.outside:
            one, two = (base if body == ground else body for body in path.bodies)
            counted.append(replace(path, bodies=(one, two)))
        else:
            counted.append(path)
    return tuple(counted)
