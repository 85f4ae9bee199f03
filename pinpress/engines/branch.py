"""The drawn assembly of a linkage, followed over the crank angle, or over the travel of a driver that slides.

Loop equations have several solutions at one crank angle, and a closure residual cannot tell them apart. The branch is therefore walked once
from the drawn pose, in steps so small that another assembly cannot be reached, and kept as a table: quintic Hermite polynomials through the
joint coordinates and their first two derivatives by the crank angle. The table predicts any configuration so closely that Newton's method
needs one step or none.

A driver that slides goes to and fro between two ends. The walk counts its travel as an angle, by a length that it takes for 1 rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from ..common.errors import AssemblyError, PinpressError, SingularityError
from ..common.numerics import quintics
from ..common.quantities import CRANK, RAM, Array, DriverCoordinate
from .change_points import ChangePoint, Gap, cross_change_point
from .engine import Close, Closure
from .following import COARSE_STEP, FIRST_STEP, Follower, Node, SingularPosition, columns, evaluated, extend_walk
from .structure import SMALLEST_MARGIN

SUBDIVISION = 8  # nodes of the table per step of the walk
LARGEST_CORRECTION = 1e-3  # by which Newton's method may move a joint from its prediction [rad, or lengths of the linkage]
MOST_TURNS = 128  # most turns of the crank that are walked until the linkage is back at its start: a pinion on a wheel of many teeth


@dataclass(frozen=True, eq=False, repr=False)
class Branch:
    """The drawn assembly over the crank angle, as a table.

    Attributes:
        angles: (m + 1,) nodes over the crank angle, rising [rad].
        coefficients: (6, nv, m) coefficients of the polynomials in (crank angle - node), rising powers.
        period: crank angle after which the linkage is back at its start [rad]; None if it locks before, or is not back after
            `MOST_TURNS` turns.
        gain_per_period: (nv,) by how much every joint has advanced after a period [rad or m]: whole turns, 0 for a joint that swings.
        locks: where the linkage locks, below and above the drawn pose; None if it does not.
        change_points: the change points that it has been followed through.
        coordinate: what the crank angle is; angles are travels [m] where the driver slides.
    """

    angles: Array
    coefficients: Array
    period: float | None
    gain_per_period: Array
    locks: Locks
    change_points: tuple[ChangePoint, ...] = ()
    coordinate: DriverCoordinate = CRANK

    def over_travel(self, unit: float) -> Branch:
        """This branch, whose angles stand for travels, over the travels of a driver that slides; ``unit``: travel counted as 1 rad [m]."""
        return Branch(
            angles=self.angles * unit,
            coefficients=self.coefficients / unit ** np.arange(6.0)[:, None, None],
            period=self.period,
            gain_per_period=self.gain_per_period,
            locks=cast(Locks, tuple(lock and SingularPosition(lock.angle * unit, lock.margin) for lock in self.locks)),
            change_points=tuple(point.over_travel(unit) for point in self.change_points),
            coordinate=RAM,
        )


class Travel(NamedTuple):
    """The travel of a driver that slides.

    Attributes:
        lower: its lower end [m].
        upper: its upper end [m].
        unit: the length that the walk counts as 1 rad [m].
    """

    lower: float
    upper: float
    unit: float


Locks = tuple[SingularPosition | None, SingularPosition | None]


class Returning(NamedTuple):
    """Which joints have to come back for a linkage to be back at its start.

    Attributes:
        closed: (nv,) whether a joint has to be back, see `Structure.returning`.
        turns: (nv,) whether a joint turns.
    """

    closed: NDArray[np.bool_]
    turns: NDArray[np.bool_]

    def farthest(self, size: float) -> Array:
        """How far a joint (nv,) may move in a linkage of this size: a slide between guides that become parallel moves beyond all bounds,
        and the rounding of its loop with it."""
        # A slide that is a thousand lengths of the linkage away is at no place of a machine.
        return np.where(self.closed & ~self.turns, 1e3 * size, np.inf)

    def whole_turns(self, gained: Array, tolerance: float) -> Array | None:
        """By how much every joint (nv,) has advanced over a period, if all joints that have to be back are, after ``gained`` (nv,), but for
        whole turns; else None. A geared shaft that moves nothing else may have any angle."""
        whole = np.where(self.turns, 2 * np.pi * np.round(gained / (2 * np.pi)), 0.0)
        back = np.abs(gained - whole) <= tolerance
        return np.where(self.closed, whole, gained) if np.all(back | ~self.closed) else None


def walk(
    close: Close,
    drawn: Array,
    returning: Returning,
    size: float,
    tolerance: float,
    smallest_margin: float = SMALLEST_MARGIN,
    gap: Gap | None = None,
    begin: float = 0.0,
    travel: Travel | None = None,
) -> Branch:
    """Walk the branch from a closed configuration over a full period, or to the locks on both sides; of a driver that slides to the ends
    of its travel.

    Args:
        close: the engine's closing function.
        drawn: (nv,) joint coordinates of the closed configuration.
        returning: the joints that have to come back after a period.
        size: length of the linkage [m], by which travels are compared with angles.
        tolerance: gap at which a loop counts as closed [m].
        smallest_margin: margin below which the linkage counts as locked.
        gap: the engine's gap function, with which the branch is followed through change points; None to stop at them.
        begin: crank angle of the configuration [rad or m].
        travel: of a driver that slides; None of one that turns.

    Raises:
        SingularityError: the linkage locks at its drawn pose.
        AssemblyError: its loops do not stay closed, or it moves too fast to be followed.
    """
    if travel is None:
        follower = Follower(close, size, tolerance, COARSE_STEP, smallest_margin, farthest=returning.farthest(size))
        return _walk(follower, drawn, returning, gap, begin, None)
    unit = travel.unit

    def close_travel(angle: Array, guess: Array) -> Closure:
        found = close(angle * unit, guess)
        return replace(found, first=found.first * unit, second=found.second * unit**2)

    follower = Follower(close_travel, size, tolerance, COARSE_STEP, smallest_margin, unit, RAM, returning.farthest(size))
    ends = travel.lower / unit, travel.upper / unit
    found = _walk(follower, drawn, returning, gap, begin / unit, ends).over_travel(unit)
    reached = [angle if lock else end for angle, lock, end in zip(found.angles[[0, -1]], found.locks, travel[:2], strict=True)]
    found.angles[[0, -1]] = reached  # without the rounding of the unit
    return found


def _walk(
    follower: Follower, drawn: Array, returning: Returning, gap: Gap | None, begin: float, ends: tuple[float, float] | None
) -> Branch:
    """`walk` with a travel counted as an angle, between ``ends`` where there are any."""
    while follower.longest > FIRST_STEP:
        found = _walk_period(follower, begin, drawn, returning, gap) if ends is None else _walk_travel(follower, begin, drawn, gap, ends)
        nodes, gained = found.nodes, found.gain_per_period
        if len(nodes) == 1:
            raise SingularityError(
                "the linkage locks at its drawn pose; draw it elsewhere",
                0.0,
                float(np.abs(nodes[0].margins).min()),
                follower.coordinate.at(0.0),
            )
        table = _table(follower, nodes, found.passed)
        if table is not None:
            period = None if gained is None else nodes[-1].angle - nodes[0].angle
            return Branch(*table, period, np.zeros_like(drawn) if gained is None else gained, found.locks, found.passed)
        follower = follower._replace(longest=follower.longest / 2)
    raise AssemblyError("the drawn assembly moves too fast to be followed", 0.0, 0.0, 0, follower.coordinate.at(0.0))


def leads_on(close: Close, branch: Branch, size: float, tolerance: float, gap: Gap) -> bool:
    """Whether a branch with a lock, of a driver that turns, leads on through a change point there. Few steps at the lock tell, so that a
    linkage that does lock need not be walked again. Arguments as of `walk`."""
    follower = Follower(close, size, tolerance)
    angles = branch.angles[::SUBDIVISION]
    closure = close(angles, predict(branch, angles))
    nodes = [Node.of(float(angle), closure, k) for k, angle in enumerate(angles)]
    return any(
        lock is not None and cross_change_point(follower, nodes[::way], lock.angle, lock.angle + way * 2 * np.pi, gap) is not None
        for lock, way in zip(branch.locks, (-1, 1), strict=True)
    )


def walk_beside(close: Close, branch: Branch, home: Array, driver: int, size: float, tolerance: float) -> Branch | None:
    """The branch of a linkage whose lengths are nearly those of another one, found without a walk: all nodes of the other one's table are
    closed at once.

    Both begin in one pose, with equal joint coordinates. Each second node must lie where polynomials through its neighbours predict it, and
    the linkage must be back after the period: so no node has gone over to another assembly.

    Args:
        close: the closing function of the linkage's engine.
        branch: the branch of the other one, over a period or a travel.
        home: (nv,) joint coordinates of the pose in which both begin.
        driver: index in v of the driver.
        size: length of the linkage [m].
        tolerance: gap at which a loop counts as closed [m].

    Returns:
        The branch; None if the lengths are too different, and it has to be walked.
    """
    if any(branch.locks) or branch.change_points or (branch.period is None and branch.coordinate.turns) or len(branch.angles) % 2 == 0:
        return None
    angles = branch.angles
    closure = close(angles, predict(branch, angles))
    if not closure.widest <= tolerance:
        return None
    rows = closure.position, closure.first, closure.second
    begin = int(np.argmin(np.abs(angles - home[driver])))
    accepted = LARGEST_CORRECTION * (1 + size)
    coarse = Branch(angles[::2], quintics(np.diff(angles[::2]), *(values[:, ::2] for values in rows)), None, np.zeros(0), (None, None))
    missed = np.abs(predict(coarse, angles) - closure.position).max()
    gained = closure.position[:, -1] - closure.position[:, 0] - branch.gain_per_period if branch.period else np.zeros(1)
    off = np.abs(closure.position[:, begin] - home).max()
    if abs(angles[begin] - home[driver]) > 1e-12 * (1 + size) or not max(missed, np.abs(gained).max(), off) <= accepted:
        return None
    return replace(branch, coefficients=quintics(np.diff(angles), *rows))


def predict(branch: Branch, angle: Array, ends: tuple[float, float] | None = None) -> Array:
    """Joint coordinates (nv, n) of the branch at crank angles (n,), with an error of about 1e-12 of their range.

    Args:
        branch: the branch.
        angle: (n,) crank angles [rad or m].
        ends: the smallest and the largest of them, where they are known.

    Raises:
        SingularityError: the linkage locks before it reaches one of the angles.
        PinpressError: the branch has no period, and was not followed as far as one of the angles.
    """
    local, turns = _within_period(branch, angle, ends)
    x = evaluated(branch.angles, branch.coefficients, local)
    if turns is not None:
        x += branch.gain_per_period[:, None] * turns
    return x


def nodes_before(branch: Branch, angle: Array) -> Array:
    """Joint coordinates (nv, n) at the nodes of the branch before crank angles (n,): they tell how many turns a joint has made. Raises as
    `predict`."""
    local, turns = _within_period(branch, angle, None)
    x: Array = branch.coefficients[0].take(branch.angles[1:-1].searchsorted(local, side="right"), axis=1)
    if turns is not None:
        x += branch.gain_per_period[:, None] * turns
    return x


def _within_period(branch: Branch, angle: Array, ends: tuple[float, float] | None) -> tuple[Array, Array | None]:
    """Crank angles (n,) within the table, and the periods (n,) taken off; None if there are none."""
    low, high = ends or (np.minimum.reduce(angle), np.maximum.reduce(angle))
    if branch.angles[0] <= low and high <= branch.angles[-1]:
        return angle, None
    if branch.period is None:
        raise out_of_branch(branch, upwards=bool(high > branch.angles[-1]))
    turns = np.floor((angle - branch.angles[0]) / branch.period)
    return angle - turns * branch.period, turns


def periods_until_back(gain: Array) -> int | None:
    """Number of periods after which all of k joints are back, if each advances by ``gain`` (k,) in a period [rad]; None if they are not
    back after `MOST_TURNS` periods."""
    counts = np.arange(1, MOST_TURNS + 1)
    turns = np.multiply.outer(counts, gain / (2 * np.pi))
    back = np.all(np.abs(turns - np.round(turns)) < 1e-9, axis=1)
    return int(counts[np.argmax(back)]) if back.any() else None


def out_of_branch(branch: Branch, upwards: bool, further: Branch | None = None) -> PinpressError:
    """The error for a motion that leaves a branch without a period, upwards or downwards; ``further``: the branch through change points."""
    coordinate, lock = branch.coordinate, branch.locks[upwards]
    low, high = float(branch.angles[0]), float(branch.angles[-1])
    if lock is None and not coordinate.turns:
        return PinpressError(
            f"the driver slides from {coordinate.shown(low)} to {coordinate.shown(high)} only: keep the motion inside, or widen the <limit>"
            " of its joint"
        )
    if lock is None:
        return PinpressError(
            f"the linkage is not back at its drawn pose after {MOST_TURNS} turns of the driver, and is followed no further:"
            f" keep the motion between {low * coordinate.scale:.6g} and {coordinate.shown(high)}"
        )
    low, high = (at if of is None else of.angle for at, of in zip((low, high), branch.locks, strict=True))
    meetings, period = ((), None) if further is None else (further.change_points, further.period)
    if any(abs(math.remainder(point.angle - lock.angle, period or math.inf)) < point.half for point in meetings):
        places = ", ".join(f"{place * coordinate.scale:.6g}" for place in sorted(point.angle for point in meetings))
        problem = f"two assemblies meet at {coordinate.position}s of {places} {coordinate.shown_unit}, and a prescribed motion does not say"
        remedy = "keep it between them, make the lengths unequal, or simulate a run, which goes on in the drawn one"
        return SingularityError(f"{problem} in which of them it goes on: {remedy}", *lock, coordinate.at(lock.angle))
    return SingularityError(
        f"the linkage locks: from its drawn pose the driver {'turns' if coordinate.turns else 'slides'} only from"
        f" {low * coordinate.scale:.6g} to {coordinate.shown(high)}; change the link lengths, or keep the motion inside",
        *lock,
        coordinate.at(lock.angle),
    )


# --------------------------------------------------------------------------------------------------------------------------------- the walk


class _Walked(NamedTuple):
    """A finished walk.

    Attributes:
        nodes: at rising crank angles, over a period, from lock to lock, or over `MOST_TURNS` turns.
        locks: see `Branch`.
        gain_per_period: (nv,) see `Branch`; None if there is no period.
        passed: change points through which the walk has gone.
    """

    nodes: list[Node]
    locks: Locks
    gain_per_period: Array | None
    passed: tuple[ChangePoint, ...]


def _walk_period(follower: Follower, begin: float, drawn: Array, returning: Returning, gap: Gap | None) -> _Walked:
    """Walk upwards until the linkage is back at its start; if it locks before, walk downwards too. Arguments as of `walk`."""
    passed: list[ChangePoint] = []
    upward = [Node.of(begin, follower.close(np.array([begin]), drawn[:, None]))]
    high = None
    for turn in range(1, MOST_TURNS + 1):
        high = _extend_through(follower, upward, begin + 2 * np.pi * turn, gap, passed)
        if high is not None:
            break
        gained = returning.whole_turns(upward[-1].position - drawn, 1e-9 * (1 + follower.size))
        if gained is not None:
            return _Walked(upward, (None, None), gained, tuple(passed))
    downward = upward[:1]
    low = _extend_through(follower, downward, begin - 2 * np.pi * MOST_TURNS, gap, passed)
    return _Walked(downward[:0:-1] + upward, (low, high), None, tuple(passed))


def _walk_travel(follower: Follower, begin: float, drawn: Array, gap: Gap | None, ends: tuple[float, float]) -> _Walked:
    """Walk to both ends, or to where the linkage locks before."""
    passed: list[ChangePoint] = []
    upward = [Node.of(begin, follower.close(np.array([begin]), drawn[:, None]))]
    high = _extend_through(follower, upward, ends[1], gap, passed)
    downward = upward[:1]
    low = _extend_through(follower, downward, ends[0], gap, passed)
    return _Walked(downward[:0:-1] + upward, (low, high), None, tuple(passed))


def _extend_through(
    follower: Follower, nodes: list[Node], target: float, gap: Gap | None, passed: list[ChangePoint]
) -> SingularPosition | None:
    """Append nodes up to the crank angle ``target``, through change points if there is a ``gap`` function, and append these to ``passed``.
    Returns the lock that ends the walk before the target, if there is one."""
    while (lock := extend_walk(follower, nodes, target)) is not None:
        found = None if gap is None else cross_change_point(follower, nodes, lock.angle, target, gap)
        if found is None:
            return lock
        point, nodes_beyond = found
        while len(nodes) > 1 and abs(nodes[-1].angle - point.angle) < point.inner:  # too near to it to be exact
            nodes.pop()
        nodes += nodes_beyond
        passed.append(point)
    return None


def _table(follower: Follower, nodes: list[Node], passed: tuple[ChangePoint, ...]) -> tuple[Array, Array] | None:
    """Nodes (m + 1,) and polynomials (m, 6, nv) of `Branch`, on a finer grid than that of the walk.

    The new nodes are closed all at once from the walk's own polynomials; there are none next to the change points that it ``passed``, where
    the equations fail. None if the walk was too coarse, and has to be repeated with shorter steps.

    Raises:
        AssemblyError: the loops do not stay closed.
    """
    coarse = np.array([node.angle for node in nodes])
    polynomials = quintics(np.diff(coarse), *columns(nodes))
    shares = np.arange(SUBDIVISION) / SUBDIVISION
    angles = np.append((coarse[:-1, None] + np.diff(coarse)[:, None] * shares).ravel(), coarse[-1])
    for point in passed:
        angles = angles[np.abs(angles - point.angle) >= point.inner]
    guess = predict(Branch(coarse, polynomials, None, np.zeros(0), (None, None)), angles)
    closure = follower.close(angles, guess)
    moved = np.abs(closure.position - guess).max(axis=0)
    # Newton's method leaves a gap as small as this only where redundant equations contradict each other.
    if follower.tolerance < closure.widest < max(1e-6 * follower.size, 10 * follower.tolerance):
        worst = int(np.argmax(closure.gap))
        raise AssemblyError(
            "the loops do not stay closed: they hold each other, so that lengths and angles must fit to all digits",
            float(angles[worst]) * follower.unit,
            closure.widest,
            closure.iterations,
            follower.coordinate.at(float(angles[worst]) * follower.unit),
        )
    if not (closure.widest <= follower.tolerance and moved.max() <= LARGEST_CORRECTION * (1 + follower.size)):
        return None
    return angles, quintics(np.diff(angles), closure.position, closure.first, closure.second)
