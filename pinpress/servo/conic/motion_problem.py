"""The problem of the best motion: objective and limits as functions of b, the square of the crank's speed, at the nodes of a path.

The module also computes what a motion costs, from b alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.quantities import Array
from ..drive import ServoDrive
from ..limits import Limit, TorqueRate
from .coefficients import Coefficients

Index = NDArray[np.intp]


class Affine(NamedTuple):
    """A quantity of each of m segments that is affine in b at the segment's ends: before b_i + after b_{i+1} + fixed.

    A quantity that belongs to two segments also has last x b at one more node.
    """

    before: Array  # (m,)
    after: Array  # (m,)
    fixed: Array  # (m,)
    segments: Index  # (m,) indices of the segments
    last: Array | None = None  # (m,) or None
    last_nodes: Index | None = None  # (m,) indices of these nodes, or None

    def at(self, b: Array) -> Array:
        """(m,) values, for b (N + 1,) at the nodes."""
        value = self.before * b[self.segments] + self.after * b[self.segments + 1] + self.fixed
        return value if self.last is None else value + self.last * b[self.last_nodes]


def inner_affine(c: Coefficients, place: int, by_acceleration: Array, by_square: Array, fixed: Array, segments: Index) -> Affine:
    """by_acceleration x acceleration + by_square x b + fixed at one of the inner places of segments, from coefficients (m,) there."""
    step, share = c.grid.step[segments], c.inner[place][segments]
    change = by_acceleration / (2.0 * step)
    return Affine((1.0 - share) * by_square - change, share * by_square + change, fixed, segments)


@dataclass(frozen=True, eq=False, repr=False)
class Bounded:
    """A named limit: a quantity of segments (an `Affine`), or b at nodes (``nodes``), is at most a bound, or equal to it."""

    name: str  # the limit as text
    most: Array  # (m,) the bound, proportional to limit^power
    limit: float  # the user's number, in ``unit``
    unit: str  # unit of the limit
    quantity: Affine | None = None  # the quantity of segments; None for b at nodes
    nodes: Index = field(default_factory=lambda: np.empty(0, np.intp))  # (m,) indices of nodes, where ``quantity`` is None
    power: float = 1.0  # see ``most``: 2 for a speed, whose square is bounded
    equal: bool = False  # whether the quantity equals the bound
    both: bool = False  # whether the negative quantity is bounded too
    drag: float = 0.0  # factor of c_i + c_{i+1}, which is added to the quantity in the crank's direction of turning: drag of the drive
    # factor of (c_i + c_{i+1}) / 2, which is added to the quantity and to its negative: so the bound falls with the speed
    by_speed: float = 0.0
    total: bool = False  # whether the sum of the quantity over the segments is bounded, by the first bound
    length: tuple[Affine, ...] = ()  # the two other components of a force; if given, the magnitude of the force is bounded


def below_tangents(
    torque: Affine, allowed: Array, fall: Array, speed: Array, slopes: tuple[Array, Array], limit: tuple[str, float, str]
) -> list[Bounded]:
    """Limits of a torque and of its negative, by the tangent of the allowed torque, which is convex in b.

    Args:
        torque: the torque of m segments.
        allowed: (m,) torque that the limit allows at the motion at which the tangent touches [N m].
        fall: (m,) by how much it falls with the speed there [N m s/rad].
        speed: (m,) speed there: the mean of the speeds at the ends of a segment, or the root of b within it [rad/s].
        slopes: (m,) derivatives of this speed by b at the beginning and at the end of the segment.
        limit: name, number and unit of the limit.
    """
    name, number, unit = limit
    level = allowed + 0.5 * fall * speed  # a root's tangent, continued to b = 0, has half the root's value there
    before, after = (fall * slope for slope in slopes)
    both = (
        Affine(sign * torque.before + before, sign * torque.after + after, sign * torque.fixed, torque.segments) for sign in (1.0, -1.0)
    )
    return [Bounded(name, level, number, unit, quantity) for quantity in both]


@dataclass(frozen=True, eq=False, repr=False)
class RelaxedPower:
    """A largest power in a form that is convex and that every motion within the power keeps.

    The torque of a segment is at most power x relaxed time / step. If b lies in a known range, the chord of 1 / speed over this range
    limits the relaxed time.
    """

    power: float  # largest power [W]
    least: Array  # (N + 1,) lower bounds of b at the nodes for every better motion; 0 if unknown [rad2/s2]
    most: Array  # (N + 1,) upper bounds of b at the nodes for every better motion; infinite if unknown [rad2/s2]


@dataclass(frozen=True, eq=False, repr=False)
class MotionProblem:
    """The problem: find the motion along a path with the least objective within limits."""

    coefficients: Coefficients
    drive: ServoDrive
    weights: Mapping[str, float]  # weights of "heat" [1/(N2 m2 s)], "time" [1/s], "energy" [1/J], "peak" [1/(N m)] in the objective
    time: float | None  # largest time of a cycle [s]; None: only the objective or other limits restrict it
    limits: tuple[Limit, ...] = ()  # the limits in addition to those of the drive
    bounds: tuple[Bounded, ...] = ()  # limits that are each proportional to one number
    rms: float | None = None  # largest root mean square of the torque at the crank [N m], or None
    below: NDArray[np.bool_] | None = None  # (N,) whether a segment is outside the feed window, or None
    feed_time: float = 0.0  # time of the feed window [s]
    power: RelaxedPower | None = None  # a largest power, relaxed, or None
    ceiling: float | None = None  # largest objective allowed, or None
    # (N + 1,) b of the motion at which tangents of the root of b give the losses, an upper bound; None: c gives them, a lower bound
    rolled_at: Array | None = None
    time_name: str = "cycle time"  # limits as text
    rms_name: str = "rms torque"
    feed_name: str = "feed window"

    @property
    def inertia(self) -> float:
        """Inertia of the drive at the crank [kg m2]."""
        return self.drive.crank_inertia

    @property
    def rate(self) -> float | None:
        """Largest rate of the torque at the crank [N m/s], or None."""
        return min((limit.rate * self.drive.ratio for limit in self.limits if isinstance(limit, TorqueRate)), default=None)

    def inner_torques(self) -> tuple[Affine, Affine]:
        """Torques at the two inner places of the segments, without the drag of the drive."""
        c, step = self.coefficients, self.coefficients.grid.step
        first, second = (
            inner_affine(c, k, (c.inner_inertia[k] + self.inertia), 0.5 * c.inner_slope[k], c.inner_torque[k], np.arange(len(step)))
            for k in range(2)
        )
        return first, second

    def torque_at(self, share: Array, segments: Index) -> Affine:
        """Torque at places (m,) within segments, as shares of their steps, without the drag of the drive.

        Loads and the slope of the inertia are straight lines through their values at the inner places.
        """
        c, step = self.coefficients, self.coefficients.grid.step[segments]
        first, last = c.inner[:, segments]
        along = (share - first) / (last - first)
        slope, fixed = (of[0, segments] + along * (of[1, segments] - of[0, segments]) for of in (c.inner_slope, c.inner_torque))
        inertia = c.inner_inertia[0, segments] + 0.5 * (share - first) * step * (slope + c.inner_slope[0, segments]) + self.inertia
        change = 0.5 * inertia / step
        return Affine(0.5 * (1.0 - share) * slope - change, 0.5 * share * slope + change, fixed, segments)

    def end_torques(self) -> tuple[Affine, Affine]:
        """Torques at the beginnings and at the ends of the segments, between which they are nearly straight lines."""
        segments = np.arange(len(self.coefficients.grid.step))
        return self.torque_at(np.zeros(len(segments)), segments), self.torque_at(np.ones(len(segments)), segments)

    def mean_torque(self) -> Affine:
        """Mean torque over the segments, without the drag of the drive."""
        c, step = self.coefficients, self.coefficients.grid.step
        inertia = (c.inertia + self.inertia) / 2.0
        return Affine(-inertia[:-1] / step, inertia[1:] / step, c.mean_torque, np.arange(len(step)))

    def with_drag(self, b: Array) -> tuple[Affine, Array]:
        """Mean torque over the segments with the drag of the drive at the speeds of a motion, and these mean speeds (N,) [rad/s]."""
        torque, speed = self.mean_torque(), 0.5 * (np.sqrt(b[1:]) + np.sqrt(b[:-1]))
        return torque._replace(fixed=torque.fixed + self.drive.crank_drag * self.coefficients.grid.way * speed), speed

    @property
    def resting(self) -> float:
        """Time of the required rests of the path [s]."""
        return self.coefficients.grid.legs.dwell

    @property
    def holding_heat(self) -> float:
        """Heat of holding in these rests [N2 m2 s]."""
        return float(self.coefficients.grid.legs.dwells @ self.coefficients.holding**2)


class Figures(NamedTuple):
    """What a motion costs, computed from b alone."""

    time: float  # time of moving and of the required rests [s]
    heat: float  # integral of the squared torque over time [N2 m2 s]
    energy: float  # energy drawn [J]
    peak: float  # largest torque at the ends of the segments [N m]
    below: float  # time outside the feed window [s]


def segment_times(coefficients: Coefficients, b: Array) -> Array:
    """(N,) times of the segments [s]."""
    speed = np.sqrt(b)
    return np.asarray(2.0 * np.abs(coefficients.grid.step) / (speed[1:] + speed[:-1]))


def figures(problem: MotionProblem, b: Array) -> Figures:
    """What a motion costs; ``b``: (N + 1,) at the nodes [rad2/s2]."""
    drive, grid = problem.drive, problem.coefficients.grid
    speed, step, times = np.sqrt(b), grid.step, segment_times(problem.coefficients, b)
    s, drag = speed[1:] + speed[:-1], drive.crank_drag
    mean = problem.mean_torque().at(b)
    rolled = 0.5 * np.abs(step) * s  # integral of the square of the speed over the time
    first, second = problem.inner_torques()
    heat = 0.5 * (first.at(b) ** 2 + second.at(b) ** 2) * times + 2.0 * drag * mean * step + drag**2 * rolled
    given = mean * step + drag * rolled + drive.copper / drive.ratio**2 * heat + drive.iron * drive.ratio**2 * rolled
    holding = drive.copper / drive.ratio**2 * problem.holding_heat
    below = float("nan") if problem.below is None else float(times[problem.below].sum()) + rest_below(problem)
    return Figures(
        time=float(times.sum()) + problem.resting,
        heat=float(heat.sum()) + problem.holding_heat,
        energy=float(np.maximum(given, drive.regeneration * given).sum()) + holding,
        peak=max(
            float(np.abs(torque.at(b) + drag * grid.way * rate).max())
            for torque, rate in zip(problem.end_torques(), (speed[:-1], speed[1:]), strict=True)
        ),
        below=below,
    )


def rest_below(problem: MotionProblem) -> float:
    """Time of the rests outside the feed window [s]."""
    if problem.below is None:
        return 0.0
    last = np.flatnonzero(np.append(np.diff(problem.coefficients.grid.leg) > 0, True))
    return float(problem.coefficients.grid.legs.dwells[problem.below[last]].sum())


def needed_time(problem: MotionProblem, cost: Figures) -> float:
    """Time of a cycle with the pause that limits require, for feeding or for cooling [s]."""
    time = cost.time if problem.below is None else max(cost.time, cost.below + problem.feed_time)
    return time if problem.rms is None else max(time, cost.heat / problem.rms**2)


def cycle_time(problem: MotionProblem, cost: Figures) -> float:
    """Time of a cycle with its pause [s].

    The pause fills the cycle up to the given time; if the time is minimised, the pause is as short as limits allow.
    """
    if problem.coefficients.grid.legs.closed:
        return cost.time
    if problem.time is None or "time" in problem.weights:
        return needed_time(problem, cost)
    return max(cost.time, problem.time)


def objective(problem: MotionProblem, b: Array) -> float:
    """The objective of a motion, computed from b alone."""
    cost = figures(problem, b)
    parts = {"heat": cost.heat, "time": needed_time(problem, cost), "energy": cost.energy, "peak": cost.peak}
    return sum(weight * parts[name] for name, weight in problem.weights.items())
