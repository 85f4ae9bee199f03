"""The drawn assembly of a linkage, carried over the crank angle.

Loop equations have several solutions at one crank angle, and a closure residual cannot tell them apart. The branch is therefore walked once
from the drawn pose, in steps so small that another assembly cannot be reached, and kept as a table: quintic Hermite polynomials through the
joint coordinates and their first two derivatives by the crank angle. It predicts any configuration closely enough for Newton's method
to have nothing, or one step, left to do.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .coordinates import Array, ComplexArray
from .errors import AssemblyError, PinpressError, SingularityError

COARSE_STEP = 2 * np.pi / 64  # longest step of the walk, unless the linkage moves too fast for it [rad]
SUBDIVISION = 8  # nodes of the table per step of the walk
FIRST_STEP = 1e-3  # of the walk, to learn how the margins change [rad]
SMALLEST_STEP = 1e-10  # the walk ends where it would need a shorter one: the linkage locks there [rad]
SMALLEST_MARGIN = 1e-6  # below it rounding of the loop equations decides where two assemblies meet: the walk ends there too
LARGEST_CORRECTION = 1e-3  # Newton's method may move a joint so far from its prediction [rad, or lengths of the linkage]
NEARLY_CLOSED = 1e-6  # gap that Newton's method leaves only where redundant equations contradict each other [lengths of the linkage]
MOST_TURNS = 16  # turns of the crank in which a linkage is looked for back at its start; it is followed no further


@dataclass(frozen=True, eq=False, repr=False)
class Closure:
    """Closed configurations and their first-order and second-order influence coefficients.

    Attributes:
        position: (nv, n) joint coordinates [rad or m].
        first: (nv, n) d position / d crank angle.
        second: (nv, n) d2 position / d crank angle2.
        gap: (n,) largest distance between the two sides of a loop [m]; large or not finite where Newton's method failed.
        widest: the largest gap [m].
        iterations: Newton steps taken.
        margins: (blocks, n) distance of every block of loops from singularity: the smallest singular value of its Jacobian, columns scaled
            to unit length, with the sign of its determinant (the Pinocchio engine has one block, and no sign). Zero where two assemblies
            meet. None unless asked for.
        basis: of the planar engine, see `plane`; None from the other.
    """

    position: Array
    first: Array
    second: Array
    gap: Array
    widest: float
    iterations: int
    margins: Array | None = None
    basis: ComplexArray | None = None


def joined(pieces: Sequence[Closure]) -> Closure:
    """One closure from those of consecutive crank angles; margins are left out."""

    def along(name: str) -> Array:
        return np.concatenate([getattr(piece, name) for piece in pieces], axis=-1)

    return Closure(
        position=along("position"),
        first=along("first"),
        second=along("second"),
        gap=along("gap"),
        widest=max(piece.widest for piece in pieces),
        iterations=max(piece.iterations for piece in pieces),
        basis=None if pieces[0].basis is None else np.concatenate([p.basis for p in pieces if p.basis is not None], axis=1),
    )


Close = Callable[[Array, Array], Closure]
"""(crank angles (n,), guesses (nv, n)) -> Closure with its margins. Never raises; the caller judges gap and margins."""


@dataclass(frozen=True, eq=False, repr=False)
class Branch:
    """The table. ``period`` is the crank angle after which the linkage is back at its start [rad], None where it locks before, or is not
    back after `MOST_TURNS` turns.

    Attributes:
        angles: (m + 1,) nodes over the crank angle, rising [rad].
        coefficients: (m, 6, nv) of the polynomials in (crank angle - node).
        advance: (nv,) what every joint gains over a period (whole turns; 0 for a joint that swings).
        locks: crank angle [rad] and smallest margin where the linkage locks, downwards and upwards; None where it does not.
    """

    angles: Array
    coefficients: Array
    period: float | None
    advance: Array
    locks: "tuple[Lock | None, Lock | None]"


class Lock(NamedTuple):
    """Where a walk ended: the crank angle [rad] at which the linkage locks or two assemblies meet, and the margin left before it."""

    angle: float
    margin: float


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
    close: Close, drawn: Array, returning: Returning, size: float, tolerance: float, smallest_margin: float = SMALLEST_MARGIN
) -> Branch:
    """Walk the branch of the closed configuration ``drawn`` (nv,) at crank angle 0, up to a full period or to where it locks both ways.

    Args:
        close: the engine's closure.
        drawn: (nv,) joint coordinates.
        returning: the joints that have to come back.
        size: length of the linkage [m], to weigh travels against angles.
        tolerance: gap at which a loop counts as closed [m].
        smallest_margin: at which it locks.

    Raises:
        SingularityError: it locks at its drawn pose.
        AssemblyError: its loops do not stay closed, or it moves too fast to be followed.
    """
    longest = COARSE_STEP
    while longest > FIRST_STEP:
        follower = _Follower(close, size, tolerance, longest, smallest_margin)
        nodes, locks, advance = _around(follower, drawn, returning)
        if len(nodes) == 1:
            raise SingularityError("the linkage locks at its drawn pose; draw it elsewhere", 0.0, float(np.abs(nodes[0].margins).min()))
        found = _table(follower, nodes)
        if found is not None:
            period = None if advance is None else nodes[-1].angle - nodes[0].angle
            return Branch(*found, period, np.zeros_like(drawn) if advance is None else advance, locks)
        longest /= 2
    raise AssemblyError("the drawn assembly moves too fast to be followed", 0.0, 0.0, 0)


class _Follower(NamedTuple):
    """How a branch is followed: see `walk`; in steps up to the ``longest``."""

    close: Close
    size: float
    tolerance: float
    longest: float = COARSE_STEP
    smallest_margin: float = SMALLEST_MARGIN


def _around(follower: _Follower, drawn: Array, returning: Returning) -> "tuple[list[_Node], tuple[Lock | None, Lock | None], Array | None]":
    """Nodes of a full period, or from lock to lock, or of as many turns as are followed; the locks; `Branch.advance`."""
    upward = [_Node.of(0.0, follower.close(np.zeros(1), drawn[:, None]))]
    high = None
    for turn in range(1, MOST_TURNS + 1):
        high = _advance(follower, upward, 2 * np.pi * turn)
        if high is not None:
            break
        advance = returning.advance(upward[-1].position - drawn, 1e-9 * (1 + follower.size))
        if advance is not None:
            return upward, (None, None), advance
    downward = upward[:1]
    low = _advance(follower, downward, -2 * np.pi * MOST_TURNS)
    return downward[:0:-1] + upward, (low, high), None


def follow(close: Close, start: Array, distance: float, size: float, tolerance: float) -> "Array | Lock":
    """The closed configuration (nv,) a ``distance`` [rad] along a path, followed from the closed one ``start`` (nv,) at its beginning; or
    where the linkage locks on the way. ``close`` takes distances along the path for crank angles."""
    nodes = [_Node.of(0.0, close(np.zeros(1), start[:, None]))]
    locked = _advance(_Follower(close, size, tolerance), nodes, distance)
    return nodes[-1].position if locked is None else locked


def predict(branch: Branch, angle: Array) -> Array:
    """Joint coordinates (nv, n) of the branch at crank angles (n,), to about 1e-12 of their range.

    Raises:
        SingularityError: the linkage locks before it reaches one of the angles.
        PinpressError: it is not followed as far.
    """
    turns, local = None, angle
    if angle.min() < branch.angles[0] or angle.max() > branch.angles[-1]:
        if branch.period is None:
            raise _beyond(branch, angle)
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


@dataclass(frozen=True, eq=False, repr=False)
class _Node:
    angle: float
    position: Array
    first: Array
    second: Array
    margins: Array

    @staticmethod
    def of(angle: float, closure: Closure) -> "_Node":
        assert closure.margins is not None
        return _Node(angle, closure.position[:, 0], closure.first[:, 0], closure.second[:, 0], closure.margins[:, 0])


def _advance(follower: _Follower, nodes: list[_Node], target: float) -> Lock | None:
    """Append nodes up to the crank angle ``target``; where the linkage locks before it, say where."""
    direction = 1.0 if target > nodes[-1].angle else -1.0
    step = FIRST_STEP
    weight = 1.0 / (1.0 + follower.size)
    while abs(target - nodes[-1].angle) > 0:
        last = nodes[-1]
        ahead = _singularity_ahead(nodes[-2], last) if len(nodes) > 1 else np.inf
        margin = float(np.abs(last.margins).min(initial=1.0))
        if margin < follower.smallest_margin:
            return Lock(last.angle + direction * min(ahead, follower.longest), margin)
        step = min(step, 0.5 * ahead)
        remaining = abs(target - last.angle)
        # the last step of a turn is stretched or cut to end on it exactly
        angle = target if remaining <= 1.01 * step else last.angle + direction * step
        h = angle - last.angle
        guess = last.position + h * (last.first + 0.5 * h * last.second)
        closure = follower.close(np.array([angle]), guess[:, None])
        if _belongs(closure, guess, last, h, weight, follower.tolerance):
            nodes.append(_Node.of(angle, closure))
            step = min(2 * step, follower.longest)
        else:
            step = min(step, abs(h)) / 2
            if step < SMALLEST_STEP:
                return Lock(last.angle, margin)
    return None


def _singularity_ahead(before: _Node, last: _Node) -> float:
    """Crank angle in which the first of the margins would reach zero, falling on as it has fallen [rad].

    A change point that the linkage runs through smoothly shows in nothing but a margin that falls to zero and rises again.
    """
    margins, fallen = np.abs(last.margins), np.abs(before.margins) - np.abs(last.margins)
    share = np.max(fallen / margins, initial=0.0)
    return float(abs(last.angle - before.angle) / share) if share > 0 else np.inf


def _belongs(closure: Closure, guess: Array, last: _Node, h: float, weight: float, tolerance: float) -> bool:
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


def _table(follower: _Follower, nodes: list[_Node]) -> tuple[Array, Array] | None:
    """Nodes and polynomials on a finer grid than the walk's, its nodes closed all at once from the walk's own polynomials.

    None where the walk was too coarse for these: its steps are to be shorter.
    """
    coarse = np.array([node.angle for node in nodes])
    polynomials = _hermite(coarse, *(np.array([getattr(node, name) for node in nodes]) for name in ("position", "first", "second")))
    shares = np.arange(SUBDIVISION) / SUBDIVISION
    angles = np.append((coarse[:-1, None] + np.diff(coarse)[:, None] * shares).ravel(), coarse[-1])
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
    return angles, _hermite(angles, closure.position.T, closure.first.T, closure.second.T)


def _hermite(angles: Array, position: Array, first: Array, second: Array) -> Array:
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


def _beyond(branch: Branch, angle: Array) -> PinpressError:
    """Why a motion leaves a branch without a period."""
    low, high = np.degrees([branch.angles[0], branch.angles[-1]])
    lock = branch.locks[1] if angle.max() > branch.angles[-1] else branch.locks[0]
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
