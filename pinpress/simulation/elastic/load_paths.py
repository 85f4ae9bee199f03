"""The lengths along which loads act on a press on springs: a point of a link along a direction, the distance between two points.

They are `Coordinate`s of the driven press, for links that yield: values, rates and derivatives by the free coordinates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...common.errors import PinpressError, shown
from ...common.quantities import Array
from ...engines.planar.model import Plane, to_complex
from ..driven_press import Coordinate, JointPosition, Length, WorkOfForce
from .assembly import DrawnBodies
from .in_space.bodies import PressInSpace
from .in_space.paths import SpringPathInSpace, path_in_space
from .preloaded_joint import OpenJoint
from .press_on_springs import LoadPath, PathMotion, PressOnSprings
from .sprung_press import LineSprings, SprungPress

NEAREST = 1e-300  # least length of a distance, which has no direction where it is zero [m]


@dataclass(frozen=True)
class PointPath:
    """How far a point of a link has moved along a direction.

    Attributes:
        body: the link; -1: the frame.
        arm: the point from the link's centre of mass, in the drawn pose [m].
        direction: of length 1, or a force, along which the value is its work.
        offset: the value in the drawn pose.
    """

    body: int
    arm: complex
    direction: complex
    offset: float

    def over(self, sprung: SprungPress, coordinates: Array, rates: Array) -> PathMotion:
        """The path at all coordinates and rates (n, 3 (bodies + 1))."""
        place, along = 3 * (self.body % len(sprung.centers)), self.direction.conjugate()
        arm = along * self.arm * np.exp(1j * coordinates[:, place + 2])
        gradient, bend = np.zeros_like(coordinates), np.zeros((*coordinates.shape, coordinates.shape[1]))
        gradient[:, place], gradient[:, place + 1], gradient[:, place + 2] = self.direction.real, self.direction.imag, -arm.imag
        bend[:, place + 2, place + 2] = -arm.real
        moved = (along * (coordinates[:, place] + 1j * coordinates[:, place + 1])).real + (arm - along * self.arm).real
        rate = np.einsum("nk,nk->n", gradient, rates)
        return PathMotion(self.offset + moved, rate, sprung.to_free(gradient), sprung.to_free_twice(bend))


@dataclass(frozen=True)
class LengthPath:
    """Distance between two points of links.

    Attributes:
        bodies: the links; -1: the frame.
        arms: the points from their links' centres of mass, in the drawn pose [m].
        height: how far they lie apart along the plane's normal [m].
        sign: -1 where the path counts the distance negatively.
    """

    bodies: tuple[int, int]
    arms: tuple[complex, complex]
    height: float
    sign: float = 1.0

    def over(self, sprung: SprungPress, coordinates: Array, rates: Array) -> PathMotion:
        """The distance at all coordinates and rates (n, 3 (bodies + 1))."""
        count = len(coordinates)
        apart, parts = np.zeros(count, dtype=complex), np.zeros((count, coordinates.shape[1]), dtype=complex)
        turned = []
        for body, own, sign in zip(self.bodies, self.arms, (-1.0, 1.0), strict=True):
            place = 3 * (body % len(sprung.centers))
            arm = own * np.exp(1j * coordinates[:, place + 2])
            apart += sign * (sprung.centers[body] + coordinates[:, place] + 1j * coordinates[:, place + 1] + arm)
            parts[:, place] += sign
            parts[:, place + 1] += sign * 1j
            parts[:, place + 2] += sign * 1j * arm
            turned.append((place + 2, -sign * arm))
        length = np.maximum(np.sqrt(apart.real**2 + apart.imag**2 + self.height**2), NEAREST)
        along = (apart / length).conj()
        gradient = (along[:, None] * parts).real
        bend = (parts.conj()[:, :, None] * parts[:, None, :]).real - gradient[:, :, None] * gradient[:, None, :]
        bend /= length[:, None, None]
        for place, second in turned:
            bend[:, place, place] += (along * second).real
        gradient, bend = self.sign * gradient, self.sign * bend
        rate = np.einsum("nk,nk->n", gradient, rates)
        return PathMotion(self.sign * length, rate, sprung.to_free(gradient), sprung.to_free_twice(bend))


@dataclass(frozen=True, eq=False)
class FramePath:
    """How far a point of a body has moved from a point of another along a direction that may turn with that.

    Attributes:
        line: the press with one spring along the path.
        offset: the value in the drawn pose [m].
    """

    line: SprungPress
    offset: float

    def over(self, sprung: SprungPress, coordinates: Array, rates: Array) -> PathMotion:
        """The path at all coordinates and rates (n, 3 (bodies + 1))."""
        at = self.line.geometry(coordinates, rates)
        bend = self.line._bend(at, np.ones((len(coordinates), 1)))
        return PathMotion(at.extension[:, 0] + self.offset, at.opening[:, 0], self.line._gradient(at)[:, 0], bend)


def joint_path(sprung: PressOnSprings, joint: OpenJoint) -> LoadPath:
    """The extension of the spring in whose place a preloaded joint stands, from the drawn pose."""
    if isinstance(sprung, PressInSpace):
        return SpringPathInSpace(sprung.alone(joint.spring))
    assert isinstance(sprung, SprungPress)
    own = slice(joint.spring, joint.spring + 1)
    line = LineSprings._make(column[own] for column in sprung.lines)
    return FramePath(replace(sprung, lines=line._replace(rest=np.zeros(1)), shapes=sprung.shapes[:, own]), 0.0)


def load_path(sprung: PressOnSprings, coordinate: Coordinate) -> LoadPath:
    """The path of a coordinate along which forces act."""
    if isinstance(sprung, PressInSpace):
        return path_in_space(sprung, coordinate)
    assert isinstance(sprung, SprungPress)
    press = sprung.press
    drawn = DrawnBodies(press)
    plane, centers = drawn.plane, drawn.centers
    if isinstance(coordinate, JointPosition):  # with one driver it is the slide's
        arm = drawn.point(coordinate.joint, press.tool.in_body) - centers[coordinate.joint]
        return PointPath(coordinate.joint, arm, complex(to_complex(plane, press.slide_direction)), coordinate.offset)
    if isinstance(coordinate, Length):
        bodies = (coordinate.first[0] - 1, coordinate.second[0] - 1)
        points = (drawn.point(joint - 1, point) for joint, point in (coordinate.first, coordinate.second))
        first, second = (point - (centers[body] if body >= 0 else 0.0) for body, point in zip(bodies, points, strict=True))
        heights = [_height(plane, joint - 1, point) for joint, point in (coordinate.first, coordinate.second)]
        return LengthPath(bodies, (first, second), heights[1] - heights[0])
    assert isinstance(coordinate, WorkOfForce)
    body = coordinate.end[0] - 1
    point = drawn.point(body, coordinate.end[1])
    force = complex(to_complex(plane, coordinate.force))
    return PointPath(body, point - centers[body], force, (force.conjugate() * point).real)


def _height(plane: Plane, joint: int, point: Array) -> float:
    """Where a point of a link lies along the plane's normal [m]."""
    return float(plane.normal @ point) if joint < 0 else float(plane.heights[joint] + plane.frames[joint][2] @ point)


def refuse_on_flexible_links(sprung: PressOnSprings, paths: Sequence[LoadPath]) -> None:
    """Raise PinpressError where a load acts on a link that bends: nothing says which of its nodes it moves."""
    if not isinstance(sprung, SprungPress):
        return
    for path in paths:
        if isinstance(path, FramePath):
            continue
        assert isinstance(path, PointPath | LengthPath)
        bodies = (path.body,) if isinstance(path, PointPath) else path.bodies
        for link in sprung.flexible:
            if link.body in bodies:
                raise PinpressError(
                    f"a load acts on the flexible link {shown(link.name)}: it may bend between its pins alone; load another link"
                )


def from_frame(sprung: SprungPress, paths: Sequence[LoadPath], slide: bool) -> tuple[LoadPath, ...]:
    """Paths that count from a frame on mounts in place of the ground; ``slide``: whether the first is the slide's position."""
    base = sprung.base
    assert base is not None
    found: list[LoadPath] = []
    for number, path in enumerate(paths):
        if isinstance(path, PointPath) and slide and number == 0:
            point = complex(sprung.centers[path.body]) + path.arm
            row = (base, path.body, point - sprung.centers[base], path.arm, path.direction, 1.0, 0.0, 0.0, 0.0, -1, 1.0)
            line = LineSprings._make(np.array([value]) for value in row)
            found.append(FramePath(replace(sprung, lines=line, shapes=np.zeros((2, 1, 0), dtype=complex)), path.offset))
        elif isinstance(path, LengthPath):
            arms = [arm - (sprung.centers[base] if body < 0 else 0.0) for body, arm in zip(path.bodies, path.arms, strict=True)]
            bodies = [base if body < 0 else body for body in path.bodies]
            found.append(replace(path, bodies=(bodies[0], bodies[1]), arms=(complex(arms[0]), complex(arms[1]))))
        else:
            found.append(path)
    return tuple(found)
