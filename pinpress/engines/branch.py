"""The drawn assembly of a linkage, followed over the crank angle, or over the travel of a driver that slides.

Loop equations have several solutions at one crank angle, and a closure residual cannot tell them apart. The branch is therefore walked once
from the drawn pose, in steps so small that another assembly cannot be reached, and kept as a table: quintic Hermite polynomials through the
joint coordinates and their first two derivatives by the crank angle. The table predicts any configuration so closely that Newton's method
needs one step or none.

A change point is a crank angle at which two assemblies meet and the drawn one runs smoothly through. A parallelogram whose links lie in a
line may go on as a crossed four-bar; the slide of a crank as long as its rod may go on or stay on the crankshaft. The equations of the
loops do not say which at the point itself, and beside it the rounding of their solution grows as the distance falls. Yet either assembly is
an analytic function of the crank angle. The drawn one is therefore closed on both sides, where the equations are good, and polynomials
through these configurations stand for the assembly between them. If they close the loops there too, both sides belong to one assembly; at a
lock there is no other side.

A driver that slides goes to and fro between two ends. The walk counts its travel as an angle, by a length that it takes for 1 rad.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from ..common.errors import AssemblyError, PinpressError, SingularityError
from ..common.quantities import CRANK, RAM, Array, DriverCoordinate
from .engine import Close, Closure

COARSE_STEP = 2 * np.pi / 64  # longest step of the walk, unless the linkage moves too fast for it [rad]
FIRST_STEP = 1e-3  # first step of the walk, which shows how the margins change [rad]
SMALLEST_STEP = 1e-10  # the walk ends where it would need a shorter one: the linkage locks there [rad]
SMALLEST_MARGIN = 1e-6  # the walk ends at a smaller margin, where rounding of the loop equations decides between two assemblies
SUBDIVISION = 8  # nodes of the table per step of the walk
LARGEST_CORRECTION = 1e-3  # by which Newton's method may move a joint from its prediction [rad, or lengths of the linkage]
NEARLY_CLOSED = 1e-6  # gap that Newton's method leaves only where redundant equations contradict each other [lengths of the linkage]
MOST_TURNS = 16  # the walk ends after this many turns of the crank if the linkage is not back at its start

WIDEST, NARROWEST = 0.3, 5e-3  # half widths of the range round a change point that polynomials cover [rad]
INNER = 0.35  # share of this range in which polynomials replace the equations, whose rounding grows as 1 / distance^3
LEAP = 1 / 8  # share of this range on either side that is crossed in one step
RESOLVED = 1e-9  # error accepted of the polynomials' positions and influence coefficients [rad, lengths of the linkage]
EQUAL = 5e-3  # multiple of the accepted gap that the polynomials may leave, five times rounding: more where lengths are not quite equal
MET = 1e-6  # distance from a change point at which forces, which grow as 1 / distance, are rounding [rad]
AMBIGUOUS = 1e-2  # correction of a joint accepted beyond a change point, as a share of the distance: the other assembly is as far as that

Gap = Callable[[Array], Array]
"""Joint coordinates (nv, n) -> largest gap (n,) of a loop or coupling [m]."""


def _chebyshev_nodes(count: int) -> Array:
    """The nodes from -1 to 1 at which a polynomial of ``count`` terms is best given."""
    return np.asarray(-np.cos((np.arange(count) + 0.5) * np.pi / count))


PLACES = np.delete(_chebyshev_nodes(18), [8, 9])  # of closed configurations over the range: none in its middle
BESIDE = _chebyshev_nodes(12)  # of closed configurations on one side, from which the other side is extrapolated


@dataclass(frozen=True, eq=False, repr=False)
class Branch:
    """The drawn assembly over the crank angle, as a table.

    Attributes:
        angles: (m + 1,) nodes over the crank angle, rising [rad].
        coefficients: (m, 6, nv) coefficients of the polynomials in (crank angle - node), rising powers.
        period: crank angle after which the linkage is back at its start [rad]; None where it locks before, or is not back after
            `MOST_TURNS` turns.
        gain_per_period: (nv,) by how much every joint has advanced after a period [rad or m]: whole turns, 0 for a joint that swings.
        locks: where the linkage locks, below and above the drawn pose; None where it does not.
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
            coefficients=self.coefficients / unit ** np.arange(6.0)[:, None],
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


class SingularPosition(NamedTuple):
    """Where a walk ended because the linkage locks or two assemblies meet.

    Attributes:
        angle: crank angle [rad].
        margin: smallest margin at the last node before it, see `Closure`.
    """

    angle: float
    margin: float


Locks = tuple[SingularPosition | None, SingularPosition | None]


@dataclass(frozen=True, eq=False, repr=False)
class ChangePoint:
    """The drawn assembly in a range of crank angles round a change point.

    Attributes:
        angle: crank angle of the change point [rad].
        half: half width of the range [rad].
        coefficients: (terms, 3, nv) coefficients of Chebyshev polynomials over the range, for the joint coordinates and their first two
            derivatives by the crank angle.
    """

    angle: float
    half: float
    coefficients: Array

    @property
    def inner(self) -> float:
        """Distance from the change point within which the polynomials replace the equations [rad]."""
        return INNER * self.half

    def over_travel(self, unit: float) -> ChangePoint:
        """See `Branch.over_travel`."""
        return ChangePoint(self.angle * unit, self.half * unit, self.coefficients / unit ** np.arange(3.0)[:, None])

    def at(self, angle: Array) -> tuple[Array, Array, Array]:
        """Joint coordinates and their first two derivatives by the crank angle, (nv, n) each, at crank angles (n,) of the range."""
        position, first, second = np.polynomial.chebyshev.chebval((angle - self.angle) / self.half, self.coefficients)
        return position, first, second


class Returning(NamedTuple):
    """Which joints have to come back for a linkage to be back at its start.

    Attributes:
        on_loop: (nv,) whether a joint is on a loop.
        turns: (nv,) whether a joint turns.
    """

    on_loop: NDArray[np.bool_]
    turns: NDArray[np.bool_]

    def whole_turns(self, gained: Array, tolerance: float) -> Array | None:
        """By how much every joint (nv,) has advanced over a period, if all joints on loops are back after ``gained`` (nv,), but for whole
        turns; else None. A geared shaft that is on no loop may have any angle."""
        whole = np.where(self.turns, 2 * np.pi * np.round(gained / (2 * np.pi)), 0.0)
        back = np.abs(gained - whole) <= tolerance
        return np.where(self.on_loop, whole, gained) if np.all(back | ~self.on_loop) else None


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
        return _walk(Follower(close, size, tolerance, COARSE_STEP, smallest_margin), drawn, returning, gap, begin, None)
    unit = travel.unit

    def close_travel(angle: Array, guess: Array) -> Closure:
        found = close(angle * unit, guess)
        return replace(found, first=found.first * unit, second=found.second * unit**2)

    follower = Follower(close_travel, size, tolerance, COARSE_STEP, smallest_margin, unit, RAM)
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
                "the linkage locks at its drawn pose; draw it elsewhere", 0.0, float(np.abs(nodes[0].margins).min()), follower.coordinate
            )
        table = _table(follower, nodes, found.passed)
        if table is not None:
            period = None if gained is None else nodes[-1].angle - nodes[0].angle
            return Branch(*table, period, np.zeros_like(drawn) if gained is None else gained, found.locks, found.passed)
        follower = follower._replace(longest=follower.longest / 2)
    raise AssemblyError("the drawn assembly moves too fast to be followed", 0.0, 0.0, 0, follower.coordinate)


def walk_beside(close: Close, branch: Branch, size: float, tolerance: float) -> Branch | None:
    """The branch of a linkage whose lengths are nearly those of another one, found without a walk: all nodes of the other one's table are
    closed at once.

    It begins at the drawn pose, where all joint coordinates are zero. Each second node must lie where polynomials through its neighbours
    predict it, and the linkage must be back after the period: so no node has gone over to another assembly.

    Args:
        close: the closing function of the linkage's engine.
        branch: the branch of the other one, over a period or a travel.
        size: length of the linkage [m].
        tolerance: gap at which a loop counts as closed [m].

    Returns:
        The branch; None where the lengths are too different, and it has to be walked.
    """
    if any(branch.locks) or branch.change_points or (branch.period is None and branch.coordinate.turns) or len(branch.angles) % 2 == 0:
        return None
    angles = branch.angles
    closure = close(angles, predict(branch, angles))
    if not closure.widest <= tolerance:
        return None
    columns = [values.T for values in (closure.position, closure.first, closure.second)]
    begin = int(np.argmin(np.abs(angles)))
    accepted = LARGEST_CORRECTION * (1 + size)
    coarse = Branch(angles[::2], hermite(angles[::2], *(values[::2] for values in columns)), None, np.zeros(0), (None, None))
    missed = np.abs(predict(coarse, angles) - closure.position).max()
    gained = closure.position[:, -1] - closure.position[:, 0] - branch.gain_per_period if branch.period else np.zeros(1)
    if angles[begin] or not max(missed, np.abs(gained).max(), np.abs(closure.position[:, begin]).max()) <= accepted:
        return None
    return replace(branch, coefficients=hermite(angles, *columns))


def follow(close: Close, start: Array, distance: float, size: float, tolerance: float) -> Array | SingularPosition:
    """Follow an assembly along a path, and return its configuration (nv,) at the end, or the place where it locks on the way.

    Args:
        close: closing function that takes distances along the path in place of crank angles.
        start: (nv,) closed configuration at the beginning of the path.
        distance: length of the path, counted as an angle [rad].
        size: length of the linkage [m].
        tolerance: gap at which a loop counts as closed [m].
    """
    nodes = [Node.of(0.0, close(np.zeros(1), start[:, None]))]
    locked = extend_walk(Follower(close, size, tolerance), nodes, distance)
    return nodes[-1].position if locked is None else locked


def predict(branch: Branch, angle: Array) -> Array:
    """Joint coordinates (nv, n) of the branch at crank angles (n,), with an error of about 1e-12 of their range.

    Raises:
        SingularityError: the linkage locks before it reaches one of the angles.
        PinpressError: the branch has no period, and was not followed as far as one of the angles.
    """
    turns, local = None, angle
    if angle.min() < branch.angles[0] or angle.max() > branch.angles[-1]:
        if branch.period is None:
            raise out_of_branch(branch, upwards=bool(angle.max() > branch.angles[-1]))
        turns = np.floor((angle - branch.angles[0]) / branch.period)
        local = angle - turns * branch.period
    interval = branch.angles[1:-1].searchsorted(local, side="right")
    powers = np.empty((6, len(angle)))
    powers[0] = 1.0
    np.subtract(local, branch.angles.take(interval), out=powers[1])
    for k in range(2, 6):
        np.multiply(powers[k - 1], powers[1], out=powers[k])
    x = np.einsum("nkj,kn->jn", branch.coefficients.take(interval, axis=0), powers)
    if turns is not None:
        x += branch.gain_per_period[:, None] * turns
    return np.asarray(x)


def periods_until_back(gain: Array) -> int | None:
    """Number of periods after which all of k joints are back, if each advances by ``gain`` (k,) in a period [rad]; None if they are not
    back after `MOST_TURNS` periods."""
    counts = np.arange(1, MOST_TURNS + 1)
    turns = np.multiply.outer(counts, gain / (2 * np.pi))
    back = np.all(np.abs(turns - np.round(turns)) < 1e-9, axis=1)
    return int(counts[np.argmax(back)]) if back.any() else None


def at_change_point(points: Sequence[ChangePoint], period: float | None, angle: Array) -> int | None:
    """Index of one of the crank angles (n,) that lies at a change point, to rounding; None where none does."""
    for point in points:
        distance = angle - point.angle
        if period is not None:
            distance -= period * np.round(distance / period)
        at = int(np.abs(distance).argmin())
        if abs(distance[at]) < MET:
            return at
    return None


def out_of_branch(branch: Branch, upwards: bool) -> PinpressError:
    """The error for a motion that leaves a branch without a period, upwards or downwards."""
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
    return SingularityError(
        f"the linkage locks: from its drawn pose the driver {'turns' if coordinate.turns else 'slides'} only from"
        f" {low * coordinate.scale:.6g} to {coordinate.shown(high)}; change the link lengths, or keep the motion inside",
        *lock,
        coordinate,
    )


# --------------------------------------------------------------------------------------------------------------------------------- the walk


class Follower(NamedTuple):
    """How a branch is followed.

    Attributes:
        close: closes the loops.
        size: length of the linkage [m].
        tolerance: gap at which a loop is closed [m].
        longest: longest step of the walk [rad].
        smallest_margin: margin below which the walk ends.
        unit: travel of a driver that slides, counted as 1 rad [m].
        coordinate: of the driver.
    """

    close: Close
    size: float
    tolerance: float
    longest: float = COARSE_STEP
    smallest_margin: float = SMALLEST_MARGIN
    unit: float = 1.0
    coordinate: DriverCoordinate = CRANK


@dataclass(frozen=True, eq=False, repr=False)
class Node:
    """A closed configuration of a walk. All attributes but the angle are columns of a `Closure`.

    Attributes:
        angle: crank angle [rad].
        position: (nv,) joint coordinates [rad or m].
        first: (nv,) first-order influence coefficients.
        second: (nv,) second-order influence coefficients.
        margins: (blocks,) margins, see `Closure`.
    """

    angle: float
    position: Array
    first: Array
    second: Array
    margins: Array

    @staticmethod
    def of(angle: float, closure: Closure) -> Node:
        assert closure.margins is not None
        return Node(angle, closure.position[:, 0], closure.first[:, 0], closure.second[:, 0], closure.margins[:, 0])


class _Walked(NamedTuple):
    """A finished walk.

    Attributes:
        nodes: at rising crank angles, over a period, from lock to lock, or over `MOST_TURNS` turns.
        locks: see `Branch`.
        gain_per_period: (nv,) see `Branch`; None where there is no period.
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


def extend_walk(follower: Follower, nodes: list[Node], target: float) -> SingularPosition | None:
    """Append nodes up to the crank angle ``target``. Returns where the linkage locks before it, None if it does not."""
    direction = 1.0 if target > nodes[-1].angle else -1.0
    step = FIRST_STEP
    weight = 1.0 / (1.0 + follower.size)
    while abs(target - nodes[-1].angle) > 0:
        last = nodes[-1]
        ahead = _singularity_ahead(nodes[-2], last) if len(nodes) > 1 else np.inf
        margin = float(np.abs(last.margins).min(initial=1.0))
        if margin < follower.smallest_margin:
            return SingularPosition(last.angle + direction * min(ahead, follower.longest), margin)
        step = min(step, 0.5 * ahead)
        remaining = abs(target - last.angle)
        # the last step of a turn is stretched or cut to end on it exactly
        angle = target if remaining <= 1.01 * step else last.angle + direction * step
        h = angle - last.angle
        guess = last.position + h * (last.first + 0.5 * h * last.second)
        closure = follower.close(np.array([angle]), guess[:, None])
        if _belongs(closure, guess, last, h, weight, follower.tolerance):
            nodes.append(Node.of(angle, closure))
            step = min(2 * step, follower.longest)
        else:
            step = min(step, abs(h)) / 2
            if step < SMALLEST_STEP:
                return SingularPosition(last.angle, margin)
    return None


def _singularity_ahead(before: Node, last: Node) -> float:
    """Crank angle after which the first of the margins would reach zero if all went on falling as between these nodes [rad].

    Nothing but such a margin shows a change point that the linkage runs through smoothly.
    """
    margins, fallen = np.abs(last.margins), np.abs(before.margins) - np.abs(last.margins)
    share = np.max(fallen / margins, initial=0.0)
    return float(abs(last.angle - before.angle) / share) if share > 0 else np.inf


def _belongs(closure: Closure, guess: Array, last: Node, h: float, weight: float, tolerance: float) -> bool:
    """Whether a closed configuration continues the assembly of the last node, and is not another assembly.

    Newton's method must have corrected the prediction by little, compared with the step. Every margin must have kept its sign and half its
    value, because it passes through zero where assemblies meet.

    Args:
        closure: the configuration.
        guess: (nv,) its prediction.
        last: the last node.
        h: step from it [rad].
        weight: factor by which corrections of joints are multiplied [rad or m], 1 / (1 + size).
        tolerance: gap at which a loop counts as closed [m].
    """
    assert closure.margins is not None
    if not closure.gap[0] <= tolerance or not np.all(np.isfinite(closure.second)):
        return False
    before, margins = np.abs(last.margins), closure.margins[:, 0] * np.sign(last.margins)
    if np.any(margins < 0.5 * before) or np.any(margins > 2.0 * np.maximum(before, 0.25)):
        return False
    correction = weight * np.abs(closure.position[:, 0] - guess).max()
    return bool(correction <= 0.1 * abs(h) * (1.0 + weight * np.abs(last.first).max()))


def _table(follower: Follower, nodes: list[Node], passed: tuple[ChangePoint, ...]) -> tuple[Array, Array] | None:
    """Nodes (m + 1,) and polynomials (m, 6, nv) of `Branch`, on a finer grid than that of the walk.

    The new nodes are closed all at once from the walk's own polynomials; there are none next to the change points that it ``passed``, where
    the equations fail. None where the walk was too coarse, and has to be repeated with shorter steps.

    Raises:
        AssemblyError: the loops do not stay closed.
    """
    coarse = np.array([node.angle for node in nodes])
    polynomials = hermite(coarse, *(np.array([getattr(node, name) for node in nodes]) for name in ("position", "first", "second")))
    shares = np.arange(SUBDIVISION) / SUBDIVISION
    angles = np.append((coarse[:-1, None] + np.diff(coarse)[:, None] * shares).ravel(), coarse[-1])
    for point in passed:
        angles = angles[np.abs(angles - point.angle) >= point.inner]
    guess = predict(Branch(coarse, polynomials, None, np.zeros(0), (None, None)), angles)
    closure = follower.close(angles, guess)
    moved = np.abs(closure.position - guess).max(axis=0)
    if follower.tolerance < closure.widest < NEARLY_CLOSED * follower.size:
        worst = int(np.argmax(closure.gap))
        raise AssemblyError(
            "the loops do not stay closed: they hold each other, so that lengths and angles must fit to all digits",
            float(angles[worst]) * follower.unit,
            closure.widest,
            closure.iterations,
            follower.coordinate,
        )
    if not (closure.widest <= follower.tolerance and moved.max() <= LARGEST_CORRECTION * (1 + follower.size)):
        return None
    return angles, hermite(angles, closure.position.T, closure.first.T, closure.second.T)


# ---------------------------------------------------------------------------------------------------------------------------- change points


def cross_change_point(
    follower: Follower, nodes: list[Node], angle: float, target: float, gap: Gap
) -> tuple[ChangePoint, list[Node]] | None:
    """The change point near a crank angle at which a walk to a ``target`` has ended, and nodes beyond it; None where the linkage locks."""
    direction = 1.0 if target > nodes[0].angle else -1.0
    half = min(WIDEST, 0.9 * abs(target - angle))
    while half > NARROWEST:
        found = _cross(follower, nodes, angle, direction * half, gap)
        if found is not None:
            return found
        half /= 2
    return None


def _cross(follower: Follower, nodes: list[Node], angle: float, reach: float, gap: Gap) -> tuple[ChangePoint, list[Node]] | None:
    """`cross_change_point` with one half width, ``reach`` [rad], which is positive to cross the point upwards."""
    share = [(angle - node.angle) / reach for node in nodes]
    start = next((k for k in reversed(range(len(nodes))) if share[k] >= LEAP), None)
    if start is None or share[start] > 0.5:
        return None
    finer = follower._replace(longest=min(follower.longest, abs(reach) / 4))
    near = [nodes[start]]
    if extend_walk(finer, near, angle - reach) is not None:
        return None
    places = 0.5 * (1 + LEAP) + 0.5 * (1 - LEAP) * BESIDE
    looked = finer.close(angle - reach * places, hermite_at(near, angle - reach * places))
    opposite = (-LEAP - 0.5 * (1 + LEAP)) / (0.5 * (1 - LEAP))
    guess: Array = np.asarray(np.polynomial.chebyshev.chebval(opposite, _fitted(BESIDE, looked.position.T)))
    closure = finer.close(np.array([angle + LEAP * reach]), guess[:, None])
    moved = float(np.abs(closure.position[:, 0] - guess).max()) / (1 + follower.size)
    if not (closure.gap[0] <= follower.tolerance and moved <= AMBIGUOUS * abs(LEAP * reach) and np.isfinite(closure.second).all()):
        return None
    far = [Node.of(angle + LEAP * reach, closure)]
    if extend_walk(finer, far, angle + reach) is not None:
        return None
    return _joined(finer, near, far, angle, abs(reach), gap)


def _joined(
    follower: Follower, near: list[Node], far: list[Node], angle: float, half: float, gap: Gap
) -> tuple[ChangePoint, list[Node]] | None:
    """The polynomials through closed configurations on both sides, with the nodes of the far side; None if they do not close the loops in
    the middle too."""

    def close(angles: Array) -> tuple[Array, float]:
        on_far = (angles - angle) * (far[0].angle - angle) > 0
        guess = np.where(on_far, hermite_at(far, angles), hermite_at(near, angles))
        closure = follower.close(angles, guess)
        return np.array([closure.position, closure.first, closure.second]), closure.widest

    values, widest = close(angle + half * PLACES)
    point = ChangePoint(angle, half, _fitted(PLACES, values.transpose(2, 0, 1)))
    between = angle + half * np.array([-0.9, -0.7, -0.5, -INNER, INNER, 0.5, 0.7, 0.9])
    checked, widest_between = close(between)
    missed = np.abs(checked - np.array(point.at(between))).max() / (1 + follower.size + np.abs(checked).max())
    middle = gap(point.at(angle + point.inner * np.linspace(-1, 1, 9))[0])
    closed = max(widest, widest_between) <= follower.tolerance and float(middle.max()) <= EQUAL * follower.tolerance
    if not (closed and missed <= RESOLVED):
        return None
    return point, far


def _fitted(places: Array, values: Array) -> Array:
    """Coefficients (n, ...) of the Chebyshev polynomials through values (n, ...) at places (n,)."""
    solved = np.linalg.solve(np.polynomial.chebyshev.chebvander(places, len(places) - 1), values.reshape(len(places), -1))
    return np.asarray(solved.reshape(values.shape), dtype=np.float64)


# -------------------------------------------------------------------------------------------------- polynomials through the nodes of a walk


def hermite(angles: Array, position: Array, first: Array, second: Array) -> Array:
    """Coefficients (m, 6, nv) of the quintics that have these values and derivatives (m + 1, nv) at both ends of m intervals.

    They are written out, because importing SciPy's BPoly takes longer than everything else that a first cycle does.
    """
    h = np.diff(angles)[:, None]
    value = position[1:] - position[:-1] - h * (first[:-1] + 0.5 * h * second[:-1])
    slope = h * (first[1:] - first[:-1] - h * second[:-1])
    bend = 0.5 * h**2 * (second[1:] - second[:-1])
    powers = [
        position[:-1],
        first[:-1],
        0.5 * second[:-1],
        (10 * value - 4 * slope + bend) / h**3,
        (-15 * value + 7 * slope - 2 * bend) / h**4,
        (6 * value - 3 * slope + bend) / h**5,
    ]
    return np.ascontiguousarray(np.stack(powers, axis=1))  # so that a prediction copies a few rows and not the table


def hermite_at(nodes: Sequence[Node], angle: Array) -> Array:
    """Joint coordinates (nv, n) at crank angles (n,) from the quintics through nodes in the order of a walk."""
    rising = sorted(nodes, key=lambda node: node.angle)
    borders = np.array([node.angle for node in rising])
    coefficients = hermite(borders, *(np.array([getattr(node, name) for node in rising]) for name in ("position", "first", "second")))
    interval = borders[1:-1].searchsorted(angle, side="right")
    powers = np.vander(angle - borders[interval], 6, increasing=True)
    return np.asarray(np.einsum("nkj,nk->jn", coefficients[interval], powers))
