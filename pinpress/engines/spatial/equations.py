"""The equations of loops and couplings in space at all configurations at once, and what follows from them: closing, rates, accelerations.

Equations, their order and their scaling are those of `pinocchio.model`. Their Jacobian's columns of passive joints are brought to unit
length and factorised. Where an orthogonal triangularisation shows that all these columns are far from dependent, it serves; the other
configurations get a singular value decomposition, which finds the rank. Arrays for LAPACK have the configurations first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ...common.frozen import Frozen
from ...common.quantities import Array
from ..engine import ACCEPTED, MOST_NEWTON_STEPS, PIECE, Closure, joined
from ..forces import RANK
from ..pinocchio.model import PARALLEL_TO_ROUNDING, SpatialModel
from .bodies import Bodies, Placements, accelerations, build_bodies, cross, motion_axes, placements, velocities

CERTAINLY = 1e-5  # smallest singular value that is certainly above this shows full rank; so does RANK, but rounding is closer there
JACOBIANS = 500_000  # entries of the Jacobians of all configurations that are worked through at a time
HALF_TURN = -0.99  # cosine of an angle from which on the logarithm of a rotation needs care


@dataclass(frozen=True, eq=False, repr=False)
class Loops(Frozen):
    """Constants of the equations of a linkage.

    Attributes:
        spatial: constants of the linkage for Pinocchio's engine.
        bodies: constants of its bodies.
        joint: (2, nl) Pinocchio's indices of the joints whose bodies carry ends 1 and 2.
        point: (2, nl, 3) ends in the frames of these joints [m].
        passive: indices of the passive joints in v.
        pair_loop: (np,) a loop of each pair of a loop and a joint that carries one of its ends alone.
        pair_joint: (np,) index in v of the joint of each pair.
        pair_end: (np,) the end that it carries, 0 for end 1, 1 for end 2.
        coupled: (nc, nv) coefficients of the couplings.
        offsets: (nc,) their right-hand sides.
        rows: number of equations.
    """

    spatial: SpatialModel
    bodies: Bodies
    joint: NDArray[np.intp]
    point: Array
    passive: NDArray[np.intp]
    pair_loop: NDArray[np.intp]
    pair_joint: NDArray[np.intp]
    pair_end: NDArray[np.intp]
    coupled: Array
    offsets: Array
    rows: int

    @cached_property
    def piece(self) -> int:
        """Number of configurations that are worked through at a time, so that their Jacobians take a few megabytes."""
        return max(8, min(PIECE, JACOBIANS // max(1, self.rows * len(self.bodies.parents))))

    @cached_property
    def pair_sign(self) -> Array:
        """(np, 1, 1) +1 where the joint carries end 2, -1 where it carries end 1."""
        return np.asarray(2.0 * self.pair_end[:, None, None] - 1.0)

    @cached_property
    def crossing(self) -> Array:
        """(nv, np) sums over the pairs of a joint, with the signs of their loop forces on it."""
        result = np.zeros((len(self.bodies.parents), len(self.pair_joint)))
        result[self.pair_joint, np.arange(len(self.pair_joint))] = self.pair_sign.ravel()
        return result

    @cached_property
    def pair_turns(self) -> NDArray[np.bool_]:
        """(np,) whether the joint turns."""
        return np.asarray(self.bodies.turns[self.pair_joint])


def build_loops(spatial: SpatialModel) -> Loops:
    """The constants of a linkage."""
    loops = spatial.loops
    pairs = [(k, joint, int(sign > 0)) for k, joints in enumerate(spatial.joints_of_loop) for joint, sign in joints.items()]
    pair_loop, pair_joint, pair_end = np.array(pairs, dtype=np.intp).reshape(-1, 3).T.copy()
    equations = spatial.equations()
    return Loops(
        spatial=spatial,
        bodies=build_bodies(spatial),
        joint=np.array([[loop.joint1 for loop in loops], [loop.joint2 for loop in loops]], dtype=np.intp),
        point=np.array([[loop.point1 for loop in loops], [loop.point2 for loop in loops]]).reshape(2, len(loops), 3),
        passive=np.array(spatial.passive_joints, dtype=np.intp),
        pair_loop=pair_loop,
        pair_joint=pair_joint,
        pair_end=pair_end,
        coupled=equations.coupled,
        offsets=equations.offsets,
        rows=equations.rows,
    )


class Equations(NamedTuple):
    """The equations at n configurations.

    Attributes:
        placed: where the bodies are.
        ends: (2, nl, 3, n) world positions of the ends of the loops [m].
        gaps: (rows, n) what each equation misses [m].
        columns: (rows, nv, n) Jacobian of the gaps.
        held: for every loop (3, 0 to 3, n) world axes, as columns, of the rotations that its bearing prevents.
    """

    placed: Placements
    ends: Array
    gaps: Array
    columns: Array
    held: list[Array]

    def widest(self, loops: int) -> Array:
        """Largest gaps (n,) of a loop or coupling [m]."""
        n = self.gaps.shape[1]
        points = np.sqrt((self.gaps[: 3 * loops].reshape(loops, 3, n) ** 2).sum(axis=1)).max(axis=0, initial=0.0)
        return np.asarray(np.maximum(points, np.abs(self.gaps[3 * loops :]).max(axis=0, initial=0.0)))


def equations(loops: Loops, x: Array) -> Equations:
    """The equations at joint coordinates (nv, n)."""
    bodies, n = loops.bodies, x.shape[1]
    placed = placements(bodies, x)
    ends = placed.origin[loops.joint] + np.einsum("elikn,elk->elin", placed.rotation[loops.joint], loops.point)
    gaps, columns = np.empty((loops.rows, n)), np.zeros((loops.rows, *x.shape))
    count = loops.joint.shape[1]
    gaps[: 3 * count] = (ends[1] - ends[0]).reshape(3 * count, n)
    moving = _moving_pairs(loops, placed, ends)
    for row in range(3):
        columns[3 * loops.pair_loop + row, loops.pair_joint] = moving[:, row]
    held = _fill_rotation_rows(loops, placed, gaps, columns)
    if len(loops.offsets):
        columns[-len(loops.offsets) :] = loops.coupled[:, :, None]
        gaps[-len(loops.offsets) :] = loops.coupled @ x - loops.offsets[:, None]
    return Equations(placed, ends, gaps, columns, held)


def _moving_pairs(loops: Loops, placed: Placements, ends: Array) -> Array:
    """What a unit rate of the joint of each pair adds to the gap of its loop, (np, 3, n)."""
    axis = placed.axis[loops.pair_joint]
    moved = cross(axis, ends[loops.pair_end, loops.pair_loop] - placed.origin[loops.pair_joint + 1])
    if not loops.pair_turns.all():
        moved = np.where(loops.pair_turns[:, None, None], moved, axis)
    moved *= loops.pair_sign
    return moved


def _fill_rotation_rows(loops: Loops, placed: Placements, gaps: Array, columns: Array) -> list[Array]:
    """Fill in the rows of the rotations that bearings prevent, and return their world axes."""
    spatial, n = loops.spatial, gaps.shape[1]
    row, held = 3 * len(spatial.loops), []
    for k, loop in enumerate(spatial.loops):
        if not loop.held_rotations:
            held.append(np.empty((3, 0, n)))
            continue
        first = np.einsum("ikn,kl->iln", placed.rotation[loop.joint1], loop.rotation1)
        if loop.type == "revolute":
            axis2 = np.einsum("ikn,k->in", placed.rotation[loop.joint2], loop.rotation2[:, 0])
            # the two axes are aligned, but may point against each other
            error = cross(first[:, 0], axis2) * np.sign((first[:, 0] * axis2).sum(axis=0))
        else:
            second = np.einsum("ikn,kl->iln", placed.rotation[loop.joint2], loop.rotation2)
            error = np.einsum("ikn,kn->in", first, _logarithm(np.einsum("kin,kjn->ijn", first, second)))
        prevented = first[:, 3 - loop.held_rotations :]
        rows = slice(row, row + loop.held_rotations)
        gaps[rows] = spatial.size * np.einsum("ihn,in->hn", prevented, error)
        for joint, sign in spatial.joints_of_loop[k].items():
            if loops.bodies.turns[joint]:
                along = np.einsum("ihn,in->hn", prevented, sign * placed.axis[joint])
                along[np.abs(along) < PARALLEL_TO_ROUNDING] = 0.0
                columns[rows, joint] = spatial.size * along
        held.append(prevented)
        row += loop.held_rotations
    return held


def _logarithm(rotations: Array) -> Array:
    """Rotation vectors (3, n) of rotations (3, 3, n)."""
    twice = np.stack([rotations[2, 1] - rotations[1, 2], rotations[0, 2] - rotations[2, 0], rotations[1, 0] - rotations[0, 1]])
    sine, cosine = 0.5 * np.sqrt((twice * twice).sum(axis=0)), 0.5 * (np.einsum("iin->n", rotations) - 1.0)
    angle = np.arctan2(sine, cosine)
    vectors = 0.5 * twice * np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 1.0)
    for i in np.flatnonzero(cosine < HALF_TURN):
        vectors[:, i] = pin.log3(np.ascontiguousarray(rotations[:, :, i]))
    return vectors


def gaps(loops: Loops, position: Array) -> Array:
    """See `Engine.gaps`."""
    pieces = (position[:, k : k + loops.piece] for k in range(0, position.shape[1], loops.piece))
    return np.concatenate([np.zeros(0), *(equations(loops, some).widest(len(loops.spatial.loops)) for some in pieces)])


def drift(loops: Loops, found: Equations, axes: Array, v: Array) -> Array:
    """Second derivative (rows, n) of the gaps at joint rates (nv, n) and no joint acceleration; ``axes``: of `motion_axes`."""
    spatial, count = loops.spatial, len(loops.spatial.loops)
    moved = velocities(loops.bodies, axes, v)
    changed = accelerations(loops.bodies, axes, moved, v, None)
    spin, linear = moved.spin[loops.joint], moved.linear[loops.joint]
    of_ends = changed.linear[loops.joint] + cross(changed.turning[loops.joint], found.ends)
    of_ends += cross(spin, linear + cross(spin, found.ends))
    result = np.zeros_like(found.gaps)
    result[: 3 * count] = (of_ends[1] - of_ends[0]).reshape(3 * count, v.shape[1])
    row = 3 * count
    for k, (loop, held) in enumerate(zip(spatial.loops, found.held, strict=True)):
        if loop.held_rotations:
            (spin1, spin2), (turned1, turned2) = spin[:, k], changed.turning[loops.joint[:, k]]
            # of t . (spin2 - spin1), where the direction t turns with body 1
            relative = turned2 - turned1 + cross(spin2 - spin1, spin1)
            result[row : row + loop.held_rotations] = spatial.size * np.einsum("ihn,in->hn", held, relative)
            row += loop.held_rotations
    return result


class PassiveColumns:
    """The columns of the passive joints in the Jacobian of the equations, scaled to unit length, and factorised, at n configurations."""

    def __init__(self, loops: Loops, columns: Array) -> None:
        self.loops, (self.rows, _, self.n) = loops, columns.shape
        passive = columns[:, loops.passive]
        lengths = np.sqrt((passive * passive).sum(axis=0))
        still = lengths <= RANK * lengths.max(axis=0, initial=0.0)  # rounding: these joints move nothing here
        self.lengths = np.where(still, 1.0, lengths)
        self.scaled = np.where(still, 0.0, passive / self.lengths).transpose(2, 0, 1).copy()  # (n, rows, k)
        self.count = len(loops.passive)
        self.parts = list(self._factorised())

    def _factorised(self) -> Sequence[_Factors]:
        every = np.arange(self.n)
        if not 0 < self.count <= self.rows:
            return self._decomposed(every)
        left, right = np.linalg.qr(self.scaled, mode="complete")
        square = right[:, : self.count]
        diagonal = np.abs(np.einsum("nii->ni", square)).min(axis=1)
        good = diagonal > CERTAINLY
        if not good.any():
            return self._decomposed(every)
        if good.all():
            inverse = np.linalg.inv(square)
        else:
            inverse = np.zeros_like(square)
            inverse[good] = np.linalg.inv(square[good])
        good &= CERTAINLY * np.sqrt(np.einsum("nij,nij->n", inverse, inverse)) < 1.0
        if good.all():
            return [_Factors(slice(None), left[:, :, : self.count], inverse, left[:, :, self.count :])]
        parts = self._decomposed(every[~good])
        if good.any():
            parts = [_Factors(every[good], left[good, :, : self.count], inverse[good], left[good, :, self.count :]), *parts]
        return parts

    def _decomposed(self, states: NDArray[np.intp]) -> list[_Factors]:
        left, values, right = np.linalg.svd(self.scaled[states], full_matrices=True)
        rank = np.count_nonzero(values > RANK * np.maximum(1.0, values.max(axis=1, initial=0.0))[:, None], axis=1)
        parts = []
        for r in np.unique(rank):
            some = rank == r
            inverse = right[some, :r].swapaxes(1, 2) / values[some, None, :r]
            parts.append(_Factors(states[some], left[some, :, :r], inverse, left[some, :, r:]))
        return parts

    def rates(self, target: Array) -> Array:
        """Joint rates (nv, n), those of drivers zero, that change the gaps by ``target`` (rows, n) in the least-squares sense."""
        result = np.zeros((self.loops.spatial.model.nv, self.n))
        wanted, found = target.T[:, :, None], np.empty((self.n, self.count))
        for part in self.parts:
            found[part.states] = (part.inverse @ (part.left.swapaxes(1, 2) @ wanted[part.states]))[:, :, 0]
        result[self.loops.passive] = found.T / self.lengths
        return result

    def multipliers(self, effort: Array) -> Array:
        """Multipliers (rows, n) of least norm that balance the efforts (nv, n) of the passive joints."""
        wanted, found = (effort[self.loops.passive] / self.lengths).T[:, :, None], np.empty((self.n, self.rows))
        for part in self.parts:
            found[part.states] = (part.left @ (part.inverse.swapaxes(1, 2) @ wanted[part.states]))[:, :, 0]
        return found.T

    def margins(self) -> Array:
        """(n,) smallest singular values, see `Closure.margins`."""
        if self.count == 0:
            return np.ones(self.n)
        if self.count > self.rows:
            return np.zeros(self.n)
        return np.asarray(np.linalg.svd(self.scaled, compute_uv=False)[:, self.count - 1])


class Solved(NamedTuple):
    """The equations at closed configurations, kept for inverse dynamics.

    Attributes:
        equations: the equations.
        passive: their columns of the passive joints, factorised.
    """

    equations: Equations
    passive: PassiveColumns


class _Factors(NamedTuple):
    """The factors at some of the configurations, of one rank r.

    Attributes:
        states: which configurations, m of them.
        left: (m, rows, r) orthonormal basis of the columns.
        inverse: (m, columns, r) from components in this basis to the shortest combination of the columns.
        idle: (m, rows, rows - r) orthonormal basis of the multipliers that balance each other on the passive joints.
    """

    states: NDArray[np.intp] | slice
    left: Array
    inverse: Array
    idle: Array


def close(loops: Loops, drivers: Array, along: Array, guess: Array, with_margins: bool) -> Closure:
    """Close all loops by Newton's method at all configurations. It never raises: the caller judges gap and margins.

    Args:
        loops: constants of the equations.
        drivers: (drivers, n) driver positions [rad or m].
        along: (drivers, n) rates of the drivers to which the influence coefficients belong; 1 where there is one driver.
        guess: (nv, n) joint coordinates from which Newton's method starts.
        with_margins: whether margins are wanted.
    """
    n, step = guess.shape[1], loops.piece
    with np.errstate(all="ignore"):
        if n <= step:
            return _close(loops, drivers, along, guess, with_margins)
        parts = (slice(k, k + step) for k in range(0, n, step))
        pieces = (_close(loops, drivers[:, some], along[:, some], guess[:, some], with_margins) for some in parts)
        return joined([replace(piece, solved=None) for piece in pieces])  # its memory serves the next piece


def _close(loops: Loops, drivers: Array, along: Array, guess: Array, with_margins: bool) -> Closure:
    moving = list(loops.spatial.drivers)
    x = guess.copy()
    x[moving] = drivers
    found, gap, steps = _solved(loops, x)
    failed = ~np.isfinite(gap)
    if failed.any():
        found.columns[:, :, failed] = 0.0
    passive = PassiveColumns(loops, found.columns)
    first = passive.rates(-np.einsum("rdn,dn->rn", found.columns[:, moving], along))
    first[moving] = along
    axes = motion_axes(loops.bodies, found.placed)
    second = passive.rates(-drift(loops, found, axes, first))
    first[:, failed] = second[:, failed] = np.nan
    margins = np.where(failed, 0.0, passive.margins())[None] if with_margins else None
    return Closure(x, first, second, gap, float(gap.max(initial=0.0)), steps, margins, solved=Solved(found, passive))


def _solved(loops: Loops, x: Array) -> tuple[Equations, Array, int]:
    """The equations where Newton's method ends, from joint coordinates (nv, n), which it changes; their largest gaps (n,) [m], not finite
    where it failed; and the number of steps."""
    tolerance, count = loops.spatial.tolerance, len(loops.spatial.loops)
    before, steps = np.full(x.shape[1], np.inf), 0
    while True:
        found = equations(loops, x)
        gap = found.widest(count)
        gap[~np.isfinite(found.columns).all(axis=(0, 1))] = np.inf
        stalled = (gap > 0.5 * before) & (gap < ACCEPTED * tolerance)
        open_states = np.flatnonzero(~((gap <= tolerance) | stalled) & np.isfinite(gap))
        if not len(open_states) or steps == MOST_NEWTON_STEPS:
            return found, gap, steps
        before[open_states] = gap[open_states]
        passive = PassiveColumns(loops, found.columns[:, :, open_states])
        x[:, open_states] += passive.rates(-found.gaps[:, open_states])
        steps += 1


def rates(loops: Loops, position: Array, speed: Array, acceleration: Array) -> tuple[Array, Array, Array]:
    """See `Engine.rates`."""
    n, step = position.shape[1], loops.piece
    if n > step:
        parts = [rates(loops, *(values[:, k : k + step] for values in (position, speed, acceleration))) for k in range(0, n, step)]
        v, a, gaps = (np.concatenate(values, axis=-1) for values in zip(*parts, strict=True))
        return v, a, gaps
    moving, found = list(loops.spatial.drivers), equations(loops, position)
    passive, columns = PassiveColumns(loops, found.columns), found.columns[:, moving]
    v = passive.rates(-np.einsum("rdn,dn->rn", columns, speed))
    v[moving] = speed
    axes = motion_axes(loops.bodies, found.placed)
    a = passive.rates(-np.einsum("rdn,dn->rn", columns, acceleration) - drift(loops, found, axes, v))
    a[moving] = acceleration
    return v, a, found.widest(len(loops.spatial.loops))


def loop_spins(loops: Loops, placed: Placements, v: Array) -> Array:
    """Angular velocities (nl, 3, n) of body 2 against body 1 of the loops [rad/s], at joint rates (nv, n)."""
    turning = np.where(loops.bodies.turns[:, None, None], placed.axis, 0.0) * v[:, None]
    return np.asarray(np.einsum("jl,jin->lin", loops.spatial.incidence, turning))
