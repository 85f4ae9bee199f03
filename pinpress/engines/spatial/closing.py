"""Closing loops in space at all configurations at once, and the rates and accelerations of all joints.

The columns of the passive joints in the equations' Jacobian are factorised block by block. Configurations at which a block is not certainly
regular get a singular value decomposition of the whole, which finds the rank.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.quantities import Array
from ..engine import MOST_NEWTON_STEPS, Closure, JointRates, joined
from ..rank import Decomposed, singular_values
from ..structure import ACCEPTED
from .blocks import InBlocks
from .equations import Equations, Kinematics, Loops

MOST_STEPS = 40  # of one closure where equations contradict each other: each is a share of the one before, larger with a larger misfit


class PassiveColumns:
    """The columns of the passive joints in the Jacobian of the equations, factorised, at n configurations.

    Attributes:
        regular: whether all columns are certainly independent, at all configurations.
    """

    def __init__(self, loops: Loops, entries: Array, in_blocks: bool = True) -> None:
        """Factorise the columns of some ``entries``, see `Loops`; ``in_blocks``: block by block where there are blocks."""
        self.loops, self.n, self._entries = loops, entries.shape[1], entries
        self._blocks = InBlocks(loops.blocks, entries) if in_blocks and loops.blocks is not None else None
        self._others = np.arange(self.n) if self._blocks is None else np.flatnonzero(~self._blocks.regular)
        self.regular = not len(self._others)

    @cached_property
    def _decomposed(self) -> Decomposed:
        """The configurations at which some columns may be dependent."""
        return Decomposed(self._columns(self._others), self.loops.structure.rank_tolerance)

    def _columns(self, states: NDArray[np.intp] | slice) -> Array:
        """The columns (m, rows, columns) at some configurations."""
        return self._entries[:, states].take(self.loops.passive_places, axis=0).transpose(2, 0, 1)

    @cached_property
    def parts(self) -> list[Part]:
        """The idle multipliers, in parts of equal rank."""
        parts = []
        if self._blocks is not None and self._blocks.regular.any() and self.loops.rows > len(self.loops.passive):
            states = slice(None) if self.regular else np.flatnonzero(self._blocks.regular)
            parts.append(Part(states, self._blocks.idle()[states]))
        if not self.regular:
            parts += [Part(self._others[part.states], part.left[:, :, part.rank :]) for part in self._decomposed.parts]
        return parts

    @property
    def undetermined(self) -> NDArray[np.intp]:
        """Indices of the configurations at which the equations do not determine the passive joints."""
        if self.regular:
            return self._others
        count = len(self.loops.passive)
        return np.concatenate([self._others[part.states] for part in self._decomposed.parts if part.rank < count] or [self._others[:0]])

    def rates(self, target: Array) -> Array:
        """Joint rates (nv, n), those of drivers zero, that change the gaps by ``target`` (rows, n) in the least-squares sense."""
        result = np.zeros((self.loops.structure.model.nv, self.n))
        if self._blocks is not None:
            self._blocks.rates(target, result)
        if not self.regular:
            result[np.ix_(self.loops.passive, self._others)] = self._decomposed.rates(target[:, self._others])
        return result

    def opening(self, rates: Array) -> Array:
        """How fast the gaps (rows, n) change at rates (nv, n) of the passive joints."""
        return np.asarray(np.einsum("nrk,kn->rn", self._columns(slice(None)), rates[self.loops.passive]))

    def multipliers(self, effort: Array) -> Array:
        """Multipliers (rows, n) of least norm that balance the efforts (nv, n) of the passive joints."""
        result = np.empty((self.loops.rows, self.n)) if self._blocks is None else self._blocks.multipliers(effort)
        if not self.regular:
            result[:, self._others] = self._decomposed.multipliers(effort[np.ix_(self.loops.passive, self._others)])
        return result

    def margins(self) -> Array:
        """(1, n), see `Closure.margins`."""
        count = len(self.loops.passive)
        if count == 0:
            return np.ones((1, self.n))
        if count > self.loops.rows:
            return np.zeros((1, self.n))
        return np.asarray(singular_values(self._columns(slice(None)))[None, :, count - 1])


class Part(NamedTuple):
    """Idle multipliers of some of the configurations.

    Attributes:
        states: which configurations, m of them.
        idle: (m, rows, k) orthonormal basis of the multipliers that balance each other on the passive joints.
    """

    states: NDArray[np.intp] | slice
    idle: Array


class Solved(NamedTuple):
    """The equations at closed configurations, kept for inverse dynamics.

    Attributes:
        equations: the equations.
        passive: their columns of the passive joints, factorised.
    """

    equations: Equations
    passive: PassiveColumns


def close(loops: Loops, drivers: Array, along: Array, guess: Array, with_margins: bool, by: Kinematics) -> Closure:
    """Close all loops by Newton's method at all configurations. It never raises: the caller judges gap and margins.

    Args:
        loops: constants of the equations.
        drivers: (drivers, n) driver positions [rad or m].
        along: (drivers, n) rates of the drivers to which the influence coefficients belong; 1 where there is one driver.
        guess: (nv, n) joint coordinates from which Newton's method starts.
        with_margins: whether margins are wanted.
        by: how the equations are computed and solved.
    """
    n, step = guess.shape[1], loops.piece
    with np.errstate(all="ignore"):
        if n <= step:
            return _close(loops, drivers, along, guess, with_margins, by)
        parts = (slice(k, k + step) for k in range(0, n, step))
        pieces = (_close(loops, drivers[:, piece], along[:, piece], guess[:, piece], with_margins, by) for piece in parts)
        return joined(pieces, n)


def _close(loops: Loops, drivers: Array, along: Array, guess: Array, with_margins: bool, by: Kinematics) -> Closure:
    moving = list(loops.structure.drivers)
    x = guess.copy()
    x[moving] = drivers
    equations, gap, steps = _solve_gaps(loops, x, by)
    failed = ~np.isfinite(gap)
    if failed.any():
        equations.entries[:, failed] = 0.0
    passive = PassiveColumns(loops, equations.entries, by.in_blocks)
    first = passive.rates(-np.einsum("rdn,dn->rn", equations.driving, along))
    first[moving] = along
    second = passive.rates(-by.drift(loops, equations, first))
    first[:, failed] = second[:, failed] = np.nan
    margins = np.where(failed, 0.0, passive.margins()) if with_margins else None
    return Closure(
        x, first, second, gap, float(gap.max(initial=0.0)), steps, margins, solved=Solved(equations, passive) if by.in_blocks else None
    )


def _solve_gaps(loops: Loops, x: Array, by: Kinematics) -> tuple[Equations, Array, int]:
    """The equations where Newton's method ends, from joint coordinates (nv, n), which it changes; their largest gaps (n,) [m], not finite
    where it failed; and the number of steps."""
    structure = loops.structure
    if structure.misfit:
        return _solve_least_squares(loops, x, by)
    before, steps = np.full(x.shape[1], np.inf), 0
    while True:
        equations = by.equations(loops, x)
        gap = equations.widest()
        gap[~np.isfinite(equations.entries).all(axis=0)] = np.inf
        stalled = (gap > 0.5 * before) & (gap < structure.tolerance)
        open_states = np.flatnonzero(~((gap <= structure.rounding) | stalled) & np.isfinite(gap))
        if not len(open_states) or steps == MOST_NEWTON_STEPS:
            return equations, gap, steps
        piece = slice(None) if len(open_states) == len(gap) else open_states  # without copies where all are open
        before[piece] = gap[piece]
        x[:, piece] -= PassiveColumns(loops, equations.entries[:, piece], by.in_blocks).rates(equations.gaps[:, piece])
        steps += 1


def _solve_least_squares(loops: Loops, x: Array, by: Kinematics) -> tuple[Equations, Array, int]:
    """`_solve_gaps` of equations that contradict each other. A gap is left where the sum of squares is least: what a step takes away of it
    has to become rounding, so that positions are smooth along a motion."""
    rounding = loops.structure.rounding
    before, steps = np.full(x.shape[1], np.inf), 0
    while True:
        equations = by.equations(loops, x)
        gap = equations.widest()
        failed = ~np.isfinite(equations.entries).all(axis=0)
        equations.entries[:, failed] = 0.0
        columns = PassiveColumns(loops, equations.entries, by.in_blocks)
        step = columns.rates(np.where(failed, 0.0, equations.gaps))
        closing = np.abs(columns.opening(step)).max(axis=0, initial=0.0)
        ended = (closing <= rounding) | ((closing > 0.5 * before) & (closing < ACCEPTED * rounding))
        if (ended | failed).all() or steps == MOST_STEPS:
            gap[failed | ~ended] = np.inf
            return equations, gap, steps
        x[:, ~ended] -= step[:, ~ended]
        before, steps = closing, steps + 1


def rates(loops: Loops, position: Array, speed: Array, acceleration: Array, by: Kinematics) -> JointRates:
    """See `Engine.rates`."""
    n, step = position.shape[1], loops.piece
    if n > step:
        pieces = (slice(k, k + step) for k in range(0, n, step))
        parts = [rates(loops, position[:, piece], speed[:, piece], acceleration[:, piece], by) for piece in pieces]
        return JointRates(*(np.concatenate([part[k] for part in parts], axis=-1) for k in range(3)))
    moving, equations = list(loops.structure.drivers), by.equations(loops, position)
    passive, columns = PassiveColumns(loops, equations.entries, by.in_blocks), equations.driving
    v = passive.rates(-np.einsum("rdn,dn->rn", columns, speed))
    v[moving] = speed
    a = passive.rates(-np.einsum("rdn,dn->rn", columns, acceleration) - by.drift(loops, equations, v))
    a[moving] = acceleration
    return JointRates(v, a, equations.widest(), Solved(equations, passive) if by.in_blocks else None)
