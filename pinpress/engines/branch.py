"""The drawn assembly of a linkage, followed over the crank angle.

Loop equations have several solutions at one crank angle, and a closure residual cannot tell them apart. The branch is therefore walked once
from the drawn pose, in steps so small that another assembly cannot be reached, and kept as a table: quintic Hermite polynomials through the
joint coordinates and their first two derivatives by the crank angle. It predicts any configuration closely enough for Newton's method
to have nothing, or one step, left to do.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.arrays import Array
from ..common.errors import AssemblyError, PinpressError, SingularityError
from . import change_points
from .change_points import ChangePoint, Gap
from .closure import Close
from .continuation import COARSE_STEP, FIRST_STEP, SMALLEST_MARGIN, Follower, Node, SingularPosition, advance, hermite

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
        found = None if gap is None else change_points.across(follower, nodes, lock.angle, target, gap)
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
