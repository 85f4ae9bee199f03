"""The lengths along which loads act on a linkage in space on springs; see `load_paths` for those in a plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....common.quantities import Array
from ...driven_press import Coordinate, End, JointPosition, Length, WorkOfForce
from ..press_on_springs import PathMotion
from .bodies import PressInSpace

NEAREST = 1e-300  # least length of a distance, which has no direction where it is zero [m]


@dataclass(frozen=True, eq=False)
class PointInSpace:
    """A point of a body.

    Attributes:
        body: the body; the last is the frame.
        arm: (3,) from its centre of mass, in its own axes [m].
    """

    body: int
    arm: Array

    def over(self, sprung: PressInSpace, coordinates: Array, rates: Array) -> tuple[Array, Array, Array]:
        """Its place (n, 3), and the derivatives of the place by all coordinates, (n, k, 3) and (n, k, k, 3)."""
        at = sprung.turned(coordinates, rates)
        assert at.by_twice is not None
        n, k, first = *coordinates.shape, 6 * self.body
        place = sprung.places(coordinates)[:, self.body] + at.matrix[:, self.body].reshape(n, 3, 3) @ self.arm
        by, twice = np.zeros((n, k, 3)), np.zeros((n, k, k, 3))
        own = np.array([first + 3, first + 4, first + 5, k - 1])
        by[:, first : first + 3] = np.eye(3)
        by[:, own] = at.by[:, self.body].reshape(n, 4, 3, 3) @ self.arm
        twice[:, own[:, None], own] = at.by_twice[:, self.body].reshape(n, 4, 4, 3, 3) @ self.arm
        return place, by, twice


@dataclass(frozen=True, eq=False)
class PointPathInSpace:
    """How far a point of a body has moved along a direction.

    Attributes:
        point: the point.
        direction: (3,) of length 1, or a force, along which the value is its work.
        offset: the value where the point is at the origin.
    """

    point: PointInSpace
    direction: Array
    offset: float

    def over(self, sprung: PressInSpace, coordinates: Array, rates: Array) -> PathMotion:
        """The path at all coordinates and rates (n, k)."""
        place, by, twice = self.point.over(sprung, coordinates, rates)
        gradient = by @ self.direction
        rate = np.einsum("nk,nk->n", gradient, rates)
        bend = twice @ self.direction
        return PathMotion(place @ self.direction + self.offset, rate, sprung.to_free(gradient), sprung.to_free_twice(bend))


@dataclass(frozen=True, eq=False)
class LengthPathInSpace:
    """Distance between two points of bodies.

    Attributes:
        points: the points.
    """

    points: tuple[PointInSpace, PointInSpace]

    def over(self, sprung: PressInSpace, coordinates: Array, rates: Array) -> PathMotion:
        """The distance at all coordinates and rates (n, k)."""
        (place1, by1, twice1), (place2, by2, twice2) = (point.over(sprung, coordinates, rates) for point in self.points)
        apart, by = place2 - place1, by2 - by1
        length = np.maximum(np.linalg.norm(apart, axis=1), NEAREST)
        along = apart / length[:, None]
        gradient = (by @ along[:, :, None])[..., 0]
        bend = (by @ by.swapaxes(1, 2) - gradient[:, :, None] * gradient[:, None, :]) / length[:, None, None]
        bend += np.einsum("nabi,ni->nab", twice2 - twice1, along)
        rate = np.einsum("nk,nk->n", gradient, rates)
        return PathMotion(length, rate, sprung.to_free(gradient), sprung.to_free_twice(bend))


@dataclass(frozen=True, eq=False)
class SpringPathInSpace:
    """The extension of a spring.

    Attributes:
        line: the press with that spring alone.
    """

    line: PressInSpace

    def over(self, sprung: PressInSpace, coordinates: Array, rates: Array) -> PathMotion:
        """The path at all coordinates and rates (n, k)."""
        value, rate, gradient, bend = self.line.extensions(sprung.turned(coordinates, rates), coordinates, rates)
        return PathMotion(value[:, 0], rate[:, 0], sprung.to_free(gradient[:, 0]), sprung.to_free_twice(bend))


def path_in_space(sprung: PressInSpace, coordinate: Coordinate) -> PointPathInSpace | LengthPathInSpace:
    """The path of a coordinate along which forces act."""
    press = sprung.press
    if isinstance(coordinate, JointPosition):  # with one driver it is the slide's
        point, direction = press.tool.in_body, press.slide_direction
        drawn = press.model.jointPlacements[coordinate.joint + 1].act(point)
        return PointPathInSpace(_point(sprung, (coordinate.joint + 1, point)), direction, coordinate.offset - float(direction @ drawn))
    if isinstance(coordinate, Length):
        return LengthPathInSpace((_point(sprung, coordinate.first), _point(sprung, coordinate.second)))
    assert isinstance(coordinate, WorkOfForce)
    return PointPathInSpace(_point(sprung, coordinate.end), coordinate.force, 0.0)


def _point(sprung: PressInSpace, end: End) -> PointInSpace:
    """A point of a link; a cross without mass has the point of its joint alone, which the body behind it has too."""
    joint, point = end
    if joint == 0:
        return PointInSpace(sprung.count, np.asarray(point, dtype=float))
    body = sprung.joints.index(joint)
    return PointInSpace(body, sprung.own_axes[body].T @ (np.asarray(point, dtype=float) - sprung.lever[body]))
