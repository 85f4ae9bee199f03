"""The drawn assembly of a linkage, followed over the crank angle.

Loop equations have several solutions at one crank angle, and a closure residual cannot tell them apart. The branch is therefore walked once
from the drawn pose, in steps so small that another assembly cannot be reached, and kept as a table: quintic Hermite polynomials through the
joint coordinates and their first two derivatives by the crank angle. It predicts any configuration closely enough for Newton's method
to have nothing, or one step, left to do.

A change point is a crank angle at which two assemblies meet, and the drawn one runs smoothly through. A parallelogram whose links lie in a
line may go on as a crossed four-bar; the slide of a crank as long as its rod may go on or stay on the crankshaft. At the point itself the
equations of the loops do not say which; beside it they answer with rounding divided by the distance. Yet either assembly is an analytic
function of the crank angle. The drawn one is therefore closed where the equations are good, on both sides, and polynomials through these
configurations are the assembly between them. That they close the loops there too is the proof that both sides are one assembly; at a lock
there is no other side.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.errors import AssemblyError, PinpressError, SingularityError
from ..common.quantities import Array
from .engine import Close, Closure

COARSE_STEP = 2 * np.pi / 64  # longest step of the walk, unless the linkage moves too fast for it [rad]
FIRST_STEP = 1e-3  # of the walk, to learn how the margins change [rad]
SMALLEST_STEP = 1e-10  # the walk ends where it would need a shorter one: the linkage locks there [rad]
SMALLEST_MARGIN = 1e-6  # below it rounding of the loop equations decides where two assemblies meet: the walk ends there too
SUBDIVISION = 8  # nodes of the table per step of the walk
LARGEST_CORRECTION = 1e-3  # Newton's method may move a joint so far from its prediction [rad, or lengths of the linkage]
NEARLY_CLOSED = 1e-6  # gap that Newton's method leaves only where redundant equations contradict each other [lengths of the linkage]
MOST_TURNS = 16  # turns of the crank in which a linkage is looked for back at its start; it is followed no further


@dataclass(frozen=True, eq=False, repr=False)
class Branch:
    """The table. ``period`` is the crank angle after which the linkage is back at its start [rad], None where it locks before, or is not
    back after `MOST_TURNS` turns.

    Attributes:
        angles: (m + 1,) nodes over the crank angle, rising [rad].
        coefficients: (m, 6, nv) of the polynomials in (crank angle - node).
        advance: (nv,) what every joint gains over a period (whole turns; 0 for a joint that swings).
        locks: crank angle [rad] and smallest margin where the linkage locks, downwards and upwards; None where it does not.
        change_points: those that it has been followed through, if it was.
    """

    angles: Array
    coefficients: Array
    period: float | None
    advance: Array
    locks: tuple[SingularPosition | None, SingularPosition | None]
    change_points: tuple[ChangePoint, ...] = ()


class Returning(NamedTuple):
    """What has to come back, for a linkage to be back at its start: (nv,) whether a joint is on a loop, and whether it turns."""

    on_loop: NDArray[np.bool_]
    turns: NDArray[np.bool_]

    def advance(self, gained: Array, tolerance: float) -> Array | None:
        """What every joint gains over a period, if what it has gained is that; else None. A geared shaft on no loop may gain anything."""
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
) -> Branch:
    """Walk the branch of a closed configuration ``drawn`` (nv,) up to a full period or to where it locks both ways.

    Args:
        close: the engine's closure.
        drawn: (nv,) joint coordinates.
        returning: the joints that have to come back.
        size: length of the linkage [m], to weigh travels against angles.
        tolerance: gap at which a loop counts as closed [m].
        smallest_margin: at which it locks.
        gap: the engine's gaps; with them it is followed through change points too.
        begin: crank angle of the configuration [rad].

    Raises:
        SingularityError: it locks at its drawn pose.
        AssemblyError: its loops do not stay closed, or it moves too fast to be followed.
    """
    longest = COARSE_STEP
    while longest > FIRST_STEP:
        follower = Follower(close, size, tolerance, longest, smallest_margin)
        found = _around(follower, begin, drawn, returning, gap)
        nodes, gained = found.nodes, found.advance
        if len(nodes) == 1:
            raise SingularityError("the linkage locks at its drawn pose; draw it elsewhere", 0.0, float(np.abs(nodes[0].margins).min()))
        table = _table(follower, nodes, found.passed)
        if table is not None:
            period = None if gained is None else nodes[-1].angle - nodes[0].angle
            return Branch(*table, period, np.zeros_like(drawn) if gained is None else gained, found.locks, found.passed)
        longest /= 2
    raise AssemblyError("the drawn assembly moves too fast to be followed", 0.0, 0.0, 0)


class _Walked(NamedTuple):
    """Nodes over rising crank angles, of a full period, or from lock to lock, or of as many turns as are followed; see `Branch`."""

    nodes: list[Node]
    locks: tuple[SingularPosition | None, SingularPosition | None]
    advance: Array | None
    passed: tuple[ChangePoint, ...]


def _around(follower: Follower, begin: float, drawn: Array, returning: Returning, gap: Gap | None) -> _Walked:
    passed: list[ChangePoint] = []
    upward = [Node.of(begin, follower.close(np.array([begin]), drawn[:, None]))]
    high = None
    for turn in range(1, MOST_TURNS + 1):
        high = _on(follower, upward, begin + 2 * np.pi * turn, gap, passed)
        if high is not None:
            break
        gained = returning.advance(upward[-1].position - drawn, 1e-9 * (1 + follower.size))
        if gained is not None:
            return _Walked(upward, (None, None), gained, tuple(passed))
    downward = upward[:1]
    low = _on(follower, downward, begin - 2 * np.pi * MOST_TURNS, gap, passed)
    return _Walked(downward[:0:-1] + upward, (low, high), None, tuple(passed))


def _on(follower: Follower, nodes: list[Node], target: float, gap: Gap | None, passed: list[ChangePoint]) -> SingularPosition | None:
    """Append nodes up to the crank angle ``target``, through change points where there are gaps to tell them by; the lock before it."""
    while (lock := advance(follower, nodes, target)) is not None:
        found = None if gap is None else across_change_point(follower, nodes, lock.angle, target, gap)
        if found is None:
            return lock
        point, beyond = found
        while len(nodes) > 1 and abs(nodes[-1].angle - point.angle) < point.inner:  # too near to it to be exact
            nodes.pop()
        nodes += beyond
        passed.append(point)
    return None


def predict(branch: Branch, angle: Array) -> Array:
    """Joint coordinates (nv, n) of the branch at crank angles (n,), to about 1e-12 of their range.

    Raises:
        SingularityError: the linkage locks before it reaches one of the angles.
        PinpressError: it is not followed as far.
    """
    turns, local = None, angle
    if angle.min() < branch.angles[0] or angle.max() > branch.angles[-1]:
        if branch.period is None:
            raise beyond(branch, upwards=bool(angle.max() > branch.angles[-1]))
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
        x += branch.advance[:, None] * turns
    return np.asarray(x)


def _table(follower: Follower, nodes: list[Node], passed: tuple[ChangePoint, ...]) -> tuple[Array, Array] | None:
    """Nodes and polynomials on a finer grid than the walk's, its nodes closed all at once from the walk's own polynomials; none where the
    equations fail beside the change points that it ``passed``.

    None where the walk was too coarse for these: its steps are to be shorter.
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
            float(angles[worst]),
            closure.widest,
            closure.iterations,
        )
    if not (closure.widest <= follower.tolerance and moved.max() <= LARGEST_CORRECTION * (1 + follower.size)):
        return None
    return angles, hermite(angles, closure.position.T, closure.first.T, closure.second.T)


def periods_until_back(advance: Array) -> int | None:
    """Periods after which joints that turn, and gain so much (k,) in each [rad], are all back; None if not after `MOST_TURNS`."""
    counts = np.arange(1, MOST_TURNS + 1)
    turns = np.multiply.outer(counts, advance / (2 * np.pi))
    back = np.all(np.abs(turns - np.round(turns)) < 1e-9, axis=1)
    return int(counts[np.argmax(back)]) if back.any() else None


def beyond(branch: Branch, upwards: bool) -> PinpressError:
    """Why a motion leaves a branch without a period."""
    low, high = np.degrees([branch.angles[0], branch.angles[-1]])
    lock = branch.locks[upwards]
    if lock is None:
        return PinpressError(
            f"the linkage is not back at its drawn pose after {MOST_TURNS} turns of the driver, and is followed no further:"
            f" keep the motion between {low:.6g} and {high:.6g} deg"
        )
    low, high = (at if of is None else np.degrees(of.angle) for at, of in zip((low, high), branch.locks, strict=True))
    return SingularityError(
        f"the linkage locks: from its drawn pose the driver turns only from {low:.6g} to {high:.6g} deg;"
        " change the link lengths, or keep the motion inside",
        *lock,
    )


class SingularPosition(NamedTuple):
    """Where a walk ended: the crank angle [rad] at which the linkage locks or two assemblies meet, and the margin left before it."""

    angle: float
    margin: float


class Follower(NamedTuple):
    """How a branch is followed, see `branch.walk`: in steps up to the ``longest``."""

    close: Close
    size: float
    tolerance: float
    longest: float = COARSE_STEP
    smallest_margin: float = SMALLEST_MARGIN


@dataclass(frozen=True, eq=False, repr=False)
class Node:
    """A closed configuration of a walk; see `Closure`."""

    angle: float
    position: Array
    first: Array
    second: Array
    margins: Array

    @staticmethod
    def of(angle: float, closure: Closure) -> Node:
        assert closure.margins is not None
        return Node(angle, closure.position[:, 0], closure.first[:, 0], closure.second[:, 0], closure.margins[:, 0])


def advance(follower: Follower, nodes: list[Node], target: float) -> SingularPosition | None:
    """Append nodes up to the crank angle ``target``; where the linkage locks before it, say where."""
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
    """Crank angle in which the first of the margins would reach zero, falling on as it has fallen [rad].

    A change point that the linkage runs through smoothly shows in nothing but a margin that falls to zero and rises again.
    """
    margins, fallen = np.abs(last.margins), np.abs(before.margins) - np.abs(last.margins)
    share = np.max(fallen / margins, initial=0.0)
    return float(abs(last.angle - before.angle) / share) if share > 0 else np.inf


def _belongs(closure: Closure, guess: Array, last: Node, h: float, weight: float, tolerance: float) -> bool:
    """Whether a closed configuration is the continuation of the last node and not another assembly.

    Newton's method must have moved it little from its prediction, compared with the step itself, and every margin, which passes through
    zero where assemblies meet, must have kept its sign and half its value.
    """
    assert closure.margins is not None
    if not closure.gap[0] <= tolerance or not np.all(np.isfinite(closure.second)):
        return False
    before, margins = np.abs(last.margins), closure.margins[:, 0] * np.sign(last.margins)
    if np.any(margins < 0.5 * before) or np.any(margins > 2.0 * np.maximum(before, 0.25)):
        return False
    correction = weight * np.abs(closure.position[:, 0] - guess).max()
    return bool(correction <= 0.1 * abs(h) * (1.0 + weight * np.abs(last.first).max()))


def follow(close: Close, start: Array, distance: float, size: float, tolerance: float) -> Array | SingularPosition:
    """The closed configuration (nv,) a ``distance`` [rad] along a path, followed from the closed one ``start`` (nv,) at its beginning; or
    where the linkage locks on the way. ``close`` takes distances along the path for crank angles."""
    nodes = [Node.of(0.0, close(np.zeros(1), start[:, None]))]
    locked = advance(Follower(close, size, tolerance), nodes, distance)
    return nodes[-1].position if locked is None else locked


def hermite(angles: Array, position: Array, first: Array, second: Array) -> Array:
    """Coefficients (m, 6, nv) of the quintics with these values and derivatives (m + 1, nv) at both ends.

    Written out, because SciPy's BPoly would cost its import (longer than everything else a first cycle does).
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


WIDEST, NARROWEST = 0.3, 5e-3  # half widths of the stretch with polynomials [rad]
INNER = 0.35  # share of it in which they stand for the equations, whose rounding grows as 1 / distance^3
LEAP = 1 / 8  # share of it that is leapt from either side at first
RESOLVED = 1e-9  # what the polynomials may miss, of positions and influence coefficients [rad, lengths of the linkage]
EQUAL = 5e-3  # share of the gap of a closed loop, by which the middle may miss: five times rounding; else links are not of equal length
MET = 1e-6  # distance from a change point at which forces, that grow as 1 / distance, are of rounding [rad]
AMBIGUOUS = 1e-2  # share of the distance across, by which Newton's method may move a joint: the other assembly is as far as that distance


def _chebyshev_nodes(count: int) -> Array:
    """Where polynomials of so many terms are best given, -1 to 1."""
    return np.asarray(-np.cos((np.arange(count) + 0.5) * np.pi / count))


PLACES = np.delete(_chebyshev_nodes(18), [8, 9])  # of closed configurations over the stretch: none in its middle
BESIDE = _chebyshev_nodes(12)  # of those that look across from one side

Gap = Callable[[Array], Array]
"""Joint coordinates (nv, n) -> largest gaps of a loop (n,) [m]."""


@dataclass(frozen=True, eq=False, repr=False)
class ChangePoint:
    """The drawn assembly around a change point.

    Attributes:
        angle: crank angle [rad].
        half: half width of the stretch [rad].
        coefficients: (terms, 3, nv) of Chebyshev polynomials over the stretch: joint coordinates and their first two derivatives by the
            crank angle.
    """

    angle: float
    half: float
    coefficients: Array

    @property
    def inner(self) -> float:
        """Distance from the crank angle within which the equations are not to be solved [rad]."""
        return INNER * self.half

    def at(self, angle: Array) -> tuple[Array, Array, Array]:
        """Joint coordinates and their first two derivatives by the crank angle (nv, n) at crank angles (n,) of the stretch."""
        position, first, second = np.polynomial.chebyshev.chebval((angle - self.angle) / self.half, self.coefficients)
        return position, first, second


def at_change_point(points: Sequence[ChangePoint], period: float | None, angle: Array) -> int | None:
    """Index of one of crank angles (n,) that is as good as at a change point, if there is one."""
    for point in points:
        distance = angle - point.angle
        if period is not None:
            distance -= period * np.round(distance / period)
        at = int(np.abs(distance).argmin())
        if abs(distance[at]) < MET:
            return at
    return None


def across_change_point(
    follower: Follower, nodes: list[Node], angle: float, target: float, gap: Gap
) -> tuple[ChangePoint, list[Node]] | None:
    """The change point about at a crank angle, at which a walk to a ``target`` has come to its end, and nodes beyond it; None where the
    linkage locks there."""
    direction = 1.0 if target > nodes[0].angle else -1.0
    half = min(WIDEST, 0.9 * abs(target - angle))
    while half > NARROWEST:
        found = _across(follower, nodes, angle, direction * half, gap)
        if found is not None:
            return found
        half /= 2
    return None


def _across(follower: Follower, nodes: list[Node], angle: float, reach: float, gap: Gap) -> tuple[ChangePoint, list[Node]] | None:
    """What `across` finds with one half width, ``reach``: positive to cross the point forwards."""
    share = [(angle - node.angle) / reach for node in nodes]
    start = next((k for k in reversed(range(len(nodes))) if share[k] >= LEAP), None)
    if start is None or share[start] > 0.5:
        return None
    finer = follower._replace(longest=min(follower.longest, abs(reach) / 4))
    near = [nodes[start]]
    if advance(finer, near, angle - reach) is not None:
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
    if advance(finer, far, angle + reach) is not None:
        return None
    return _joined(finer, near, far, angle, abs(reach), gap)


def _joined(
    follower: Follower, near: list[Node], far: list[Node], angle: float, half: float, gap: Gap
) -> tuple[ChangePoint, list[Node]] | None:
    """The polynomials through closed configurations on both sides, if they are the assembly in the middle too."""

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
