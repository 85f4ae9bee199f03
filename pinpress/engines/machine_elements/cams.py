"""Cams: the law of the lift over a turn, and the contact of the cam with the roller of its follower.

The plane of a cam is a complex plane. Its origin is the axis of the cam, about which a positive angle of the cam turns counter-clockwise,
as of all complex numbers. The imaginary axis is the way of a follower in a guide; the real axis goes to the pivot of a follower on an arm.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...common.errors import UnknownNameError
from ...common.motion_laws import MotionLaw, vdi_law
from ...common.numerics import polynomial_values, quintics
from ...common.quantities import Array, ComplexArray
from ..constraints import Curve
from ..contacts import Contact, UnitWrench

TURN = 2 * np.pi
SAME = 1e-9  # difference of angles [rad], and of lifts or slopes as a share of the largest, that is rounding
SAMPLES, CLOSER, ROUNDS = 720, 10, 8  # places of a turn between which an extreme is searched, and how the search goes on from the best


# ------------------------------------------------------------------------------------------------------------------------------ the law


class CamPoint(NamedTuple):
    """A point of the law of a cam.

    Attributes:
        angle: of the cam [rad].
        lift: of the follower [m; of an arm rad].
        law: name of the motion law (`vdi_law`) that leads to the point; empty: a dwell, or a constant speed.
        slope: derivative of the lift by the angle [m/rad; of an arm rad/rad]; None if it is not given.
        bend: second derivative [m/rad2; of an arm rad/rad2]; None if it is not given.
    """

    angle: float
    lift: float
    law: str = ""
    slope: float | None = None
    bend: float | None = None


@dataclass(frozen=True)
class CamLaw:
    """The lift of a follower by the angle of its cam, over any number of turns; it has no `law_problem`.

    Attributes:
        points: by rising angles, over a turn or less; the law goes from the last point to the first one of the next turn.
        tabulated: whether the points are a table of lifts. A polynomial of degree five goes through slopes and bends from point to point;
            without them the law is the periodic cubic spline.
    """

    points: tuple[CamPoint, ...]
    tabulated: bool = False

    def __call__(self, angle: Array) -> tuple[Array, Array, Array]:
        """Lifts at angles (n,) [rad], and their first and second derivatives by the angle (n,) each [m; of an arm rad]."""
        first = self._knots[0]
        turned = first + (angle - first) % TURN
        piece = (np.searchsorted(self._knots, turned, side="right") - 1).clip(0, len(self._knots) - 2)
        since = turned - self._knots[piece]
        values = np.array([polynomial_values(each[:, piece], since) for each in self._derivatives])
        for k, (law, width, rise) in self._laws.items():
            inside = piece == k
            if inside.any():
                moves = law.values(np.minimum(since[inside] / width, 1.0))
                values[:, inside] += [rise / width**order * each for order, each in enumerate(moves)]
        return values[0], values[1], values[2]

    @cached_property
    def corners(self) -> Array:
        """(k,) angles within a turn where acceleration or jerk may jump [rad]; none of a table of lifts."""
        of_pieces = (self._knots[k] + width * np.array([0.0, *law.corners, 1.0]) for k, (law, width, _) in self._laws.items())
        return np.unique(np.concatenate([np.zeros(0), *of_pieces]))

    @cached_property
    def _knots(self) -> Array:
        return np.array([point.angle for point in closed(self.points)])

    @cached_property
    def _laws(self) -> dict[int, tuple[MotionLaw, float, float]]:
        """Indices of the pieces that follow a motion law: the law, the width of the piece [rad] and its rise."""
        pieces = enumerate(itertools.pairwise(closed(self.points)))
        return {k: (vdi_law(end.law), end.angle - start.angle, end.lift - start.lift) for k, (start, end) in pieces if end.law}

    @cached_property
    def _derivatives(self) -> tuple[Array, ...]:
        """(6, k), (5, k) and (4, k) coefficients of all pieces, and those of their first and second derivatives."""
        return tuple(np.asarray(np.polynomial.polynomial.polyder(self._polynomials, order), dtype=float) for order in range(3))

    @cached_property
    def _polynomials(self) -> Array:
        """(6, k) coefficients of every piece in rising powers of the angle since its start; of a piece with a motion law the lift there."""
        points = closed(self.points)
        lifts = np.array([point.lift for point in points])
        if not self.tabulated:
            result = np.zeros((6, len(points) - 1))
            straight = [k not in self._laws for k in range(len(points) - 1)]
            result[:2] = lifts[:-1], np.where(straight, np.diff(lifts) / np.diff(self._knots), 0.0)
            return result
        slopes, bends = (np.array([getattr(point, name) for point in points], dtype=float) for name in ("slope", "bend"))
        if np.isnan(slopes).any():
            from scipy.interpolate import CubicSpline  # slow to import

            lifts[-1] = lifts[0]
            spline = CubicSpline(self._knots, lifts, bc_type="periodic")
            slopes, bends = spline(self._knots, 1), spline(self._knots, 2)
        return np.asarray(quintics(np.diff(self._knots), lifts, slopes, bends))


def closed(points: Sequence[CamPoint]) -> tuple[CamPoint, ...]:
    """The points of a law and, if the last one is not a turn after the first one, the first one again after a turn."""
    first, last = points[0], points[-1]
    end = first.angle + TURN
    return (*points[:-1], last._replace(angle=end)) if abs(last.angle - end) < SAME else (*points, first._replace(angle=end))


def law_problem(points: Sequence[CamPoint], tabulated: bool, unit: str) -> tuple[str, str] | None:
    """Why points are not a law, and what to write; None if they are.

    Args:
        points: with finite numbers.
        tabulated: as of `CamLaw`.
        unit: of lifts, "m" or "rad".
    """
    if len(points) < 2 + tabulated:
        return f"its law has {len(points)} points", "write points over a turn: angle of the cam and lift"
    for before, after in itertools.pairwise(points):
        if after.angle - before.angle < SAME:
            problem = f"its law goes from {np.degrees(before.angle):g} to {np.degrees(after.angle):g} deg"
            return problem, "write points in the order of rising angles"
    first, last = points[0], points[-1]
    if last.angle - first.angle > TURN + SAME:
        return f"its law goes over {np.degrees(last.angle - first.angle):g} deg", "write points over one turn, 360 deg"
    if first.law:
        return f"its first point has the law {first.law!r}", "write a law with the point to which it leads"
    for point in points:
        if point.law:
            try:
                vdi_law(point.law)
            except UnknownNameError as error:
                return str(error).rstrip("."), "write the name of a law of VDI 2143"
    if len({(point.slope is None, point.bend is None) for point in points}) > 1 or (first.slope is None) != (first.bend is None):
        return "some rows of its table have slopes and bends, others do not", "write both in every row, or in none"
    rise = max(abs(point.lift - first.lift) for point in points)
    whole = len(closed(points)) == len(points)  # a table of less than a turn goes on to its first row
    if (whole or not tabulated) and abs(last.lift - first.lift) > SAME * rise:
        problem = f"its law is not closed: the lift is {last.lift:g} {unit} at {np.degrees(last.angle):g} deg, and {first.lift:g} {unit}"
        return f"{problem} where the next turn begins", "add the piece that leads back"
    if whole and tabulated and first.slope is not None and not _goes_on(points):
        return "its last row, a turn after the first one, has another slope or bend", "write the same, or leave the last row out"
    return None if tabulated else _speed_problem(points, unit)


def _goes_on(points: Sequence[CamPoint]) -> bool:
    """Whether slopes and bends of the last row of a table are those of the first one."""
    derivatives = np.array([(point.slope, point.bend) for point in points], dtype=float)
    return bool(np.all(np.abs(derivatives[-1] - derivatives[0]) <= SAME * np.abs(derivatives).max(axis=0)))


def _speed_problem(points: Sequence[CamPoint], unit: str) -> tuple[str, str] | None:
    """Where the speed of the follower jumps: pieces of constant speed meet another speed, or rest."""
    ends = closed(points)
    slopes = [0.0 if end.law else (end.lift - start.lift) / (end.angle - start.angle) for start, end in itertools.pairwise(ends)]
    for point, before, after in zip(ends, [slopes[-1], *slopes], slopes, strict=False):
        if abs(after - before) > SAME * max(map(abs, slopes)):
            problem = f"speed jumps at {np.degrees(point.angle):g} deg: {before:.6g} to {after:.6g} {unit}/rad"
            return problem, "write a law for the piece, such as modified sine"
    return None


# ---------------------------------------------------------------------------------------------------------------------------- the contact


class CamStates(NamedTuple):
    """A cam and its roller in n states.

    Attributes:
        lift: (n,) [m; of an arm rad].
        slope: (n,) derivative of the lift by the angle [m/rad; of an arm rad/rad].
        roller: (n,) centre of the roller in the plane of the cam [m].
        way: (n,) derivative of this place by the lift.
        normal: (n,) direction in which the cam pushes the roller, of length 1.
        curvature: (n,) of the path of the roller's centre on the cam, positive where this is convex [1/m].
    """

    lift: Array
    slope: Array
    roller: ComplexArray
    way: ComplexArray
    normal: ComplexArray
    curvature: Array

    @property
    def pressure_angle(self) -> Array:
        """(n,) angle from the way of the roller to the normal, counter-clockwise [rad]. With a positive one the force of the cam that lifts
        a follower in a guide also pushes this against the real axis."""
        return np.asarray(np.angle(self.normal / self.way))

    @property
    def leverage(self) -> Array:
        """(n,) way of the roller along the normal by the lift [1; of an arm m]: effort on the follower by force of the contact."""
        return np.asarray((self.normal.conjugate() * self.way).real)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class CamContact(Contact):
    """The contact of a cam (the first body) with the roller of its follower (the second body), which the same carrier guides.

    Attributes:
        curve: coordinate of the follower by that of the cam, which is the lift times ``sense``.
        sense: 1, or -1 where the follower's coordinate falls as the roller goes away from the cam.
        radius: distance of the roller's centre from the axis of the cam at the lift 0 [m].
        offset: of the way of a follower in a guide from the axis of the cam, along the real axis [m].
        arm: length from the pivot of the follower to the centre of its roller [m]; 0: the follower is in a guide.
        distance: from the axis of the cam to the pivot [m].
        turning: 1 if the arm turns in the sense of positive angles of the cam as the roller goes away from it, -1 if against it.
        roller_radius: [m].
        roller_width: length of the line of contact [m].
        grooved: whether the roller is in a groove, which can also pull it.
        origin: (3,) point on the axis of the cam in the plane of the roller, in the carrier's joint frame [m].
        axes: (2, 3) real and imaginary axis of the plane, in the carrier's joint frame.
    """

    curve: Curve
    sense: float
    radius: float
    offset: float = 0.0
    arm: float = 0.0
    distance: float = 0.0
    turning: float = 0.0
    roller_radius: float
    roller_width: float
    grooved: bool
    origin: Array
    axes: Array

    @property
    def law(self) -> CamLaw:
        """The follower's coordinate by the angle of the cam."""
        assert isinstance(self.curve.function, CamLaw)
        return self.curve.function

    @cached_property
    def start(self) -> float:
        """What a lift of 0 is: height of the roller's centre over the axis of the cam [m]; of an arm its angle from the line between
        pivot and axis [rad]."""
        if self.arm:
            return float(np.arccos((self.distance**2 + self.arm**2 - self.radius**2) / (2 * self.distance * self.arm)))
        return float(np.sqrt(self.radius**2 - self.offset**2))

    def at(self, angle: Array) -> CamStates:
        """Cam and roller at angles (n,) of the law [rad]."""
        lift, slope, bend = (self.sense * each for each in self.law(angle))
        if self.arm:
            out = -self.arm * np.exp(1j * self.turning * (self.start + lift))
            roller, way, turned = self.distance + out, 1j * self.turning * out, -out
        else:
            roller, way, turned = self.offset + 1j * (self.start + lift), np.full(lift.shape, 1j), np.zeros(lift.shape, dtype=complex)
        # the place of the roller's centre on the cam is this one, turned back; its derivatives by the angle are turned alike
        tangent = way * slope - 1j * roller
        change = turned * slope**2 + way * bend - 2j * way * slope - roller
        size = np.abs(tangent)
        curvature = -(tangent.conjugate() * change).imag / size**3
        return CamStates(lift, slope, roller, way, 1j * tangent / size, curvature)

    def angle(self, position: Array) -> Array:
        """Angles (n,) of the law at joint coordinates (nv, n) [rad]."""
        return np.asarray(self.curve.start + position[self.curve.joint])

    def wrench(self, position: Array) -> UnitWrench:
        states = self.at(self.angle(position))
        return UnitWrench(self._in_space(states.roller) + self.origin, self._in_space(self.sense * states.normal / states.leverage))

    def _in_space(self, plane: ComplexArray) -> Array:
        return np.asarray(np.stack([plane.real, plane.imag], axis=-1) @ self.axes)

    def largest_pressure_angle(self, way: float = 1.0) -> tuple[float, float]:
        """The largest size of the pressure angle over a turn and the angle of the law at which it is reached [rad]: of an open cam where it
        pushes its follower away as it turns one ``way``, 1 or -1; 0 for both ways, which is that of a groove."""
        way = 0.0 if self.grooved else way
        return self.largest(lambda states: np.where(way * states.slope >= 0.0, np.abs(states.pressure_angle), 0.0))

    def largest(self, of: Callable[[CamStates], Array]) -> tuple[float, float]:
        """The largest value of a quantity over a turn, and the first angle of the law at which it is reached [rad]."""
        first = self.law.points[0].angle
        ends = np.unique([first, *self.law.corners, first + TURN])
        best = (-np.inf, 0.0, 0.0, 0.0)
        for start, end in itertools.pairwise(ends[np.diff(ends, append=np.inf) > SAME]):
            inside = np.linspace(start, end, 4 + round(SAMPLES * (end - start) / TURN))
            inside[[0, -1]] += [1e-3 * SAME, -1e-3 * SAME]  # the limits on this side of a jump
            values = of(self.at(inside))
            k = int(values.argmax())
            if values[k] > best[0] + SAME * abs(best[0]) or best[0] == -np.inf:
                best = (float(values[k]), float(inside[k]), *inside[[max(k - 1, 0), min(k + 1, len(inside) - 1)]].tolist())
        value, angle, low, high = best
        for _ in range(ROUNDS):
            near = np.linspace(low, high, 2 * CLOSER + 1)
            values = of(self.at(near))
            k = int(values.argmax())
            if values[k] > value:
                value, angle = float(values[k]), float(near[k])
            low, high = near[max(k - 1, 0)], near[min(k + 1, len(near) - 1)]
        return value, angle % TURN
