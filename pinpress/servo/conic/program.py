"""The best motion along a path as a second-order cone program, with the proof of its optimum.

The unknowns at the nodes are b, the square of the crank's speed, and its root c. The unknowns of each segment are d = 1 / (c_i + c_{i+1})
and e = torque^2 d. p is the energy drawn. With h, the absolute step of a segment,

    c^2 <= b,  1 <= d (c_i + c_{i+1}),  torque^2 <= e (c_i + c_{i+1}),  time = sum 2 h d,  heat = sum 2 h e.

A segment takes the time 2 h / (c_i + c_{i+1}), which is exact for a constant acceleration, also from rest. The square of the torque is the
mean of the squares at two inner places of a segment, by Gauss's rule. Limits of the torque, and work, use the mean torque of the segment,
which follows exactly from the kinetic energies at the segment's ends.
The convex form is from Verscheure et al. 2009, IEEE Trans. Automatic Control 54(10). Unknowns and cones are scaled by their sizes at each
node; without scaling, interior-point methods lose six digits near rests.

A cone only allows quantities to be larger than their exact values. So the dual cost is a bound for all motions, even if a cone is not
tight. The value is computed from b alone. The difference of value and bound is the gap.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.conic_program import AT_MOST, CONE, EQUAL, Rows, UnsolvedError, minimise
from ...common.quantities import Array
from .motion_problem import Affine, Bounded, Index, MotionProblem, RelaxedPower, figures, objective, rest_below

TOLERANCE = 1e-9  # of the solver
REMEDY = "give limits, inertia and time of a realistic size, or another number of points="


class Sizes(NamedTuple):
    """Sizes by which unknowns and cones are scaled."""

    b: Array  # (N + 1,) size of b at the nodes; 0 at rests
    torque: float  # of torques [N m]
    torques: Array  # (N,) of the torque of each segment [N m]
    speed: float  # of the crank [rad/s]


def first_sizes(problem: MotionProblem) -> Sizes:
    """Guessed sizes, before a motion is computed."""
    grid, c = problem.coefficients.grid, problem.coefficients
    length, inertia = float(np.abs(grid.step).sum()), float(np.mean(c.inertia)) + problem.inertia
    if problem.time is None or problem.time <= problem.resting:
        limits = [each.limit for each in problem.bounds if each.name.startswith(("torque", "curve of torque"))]
        torque = problem.rms or (limits[0] if limits else float(np.sqrt(np.mean(c.inner_torque**2))) + inertia)
        speed = float(np.sqrt(torque * length / inertia))
    else:
        speed = length / (problem.time - problem.resting)
        constant = c.inner_torque + 0.5 * c.inner_slope * speed**2
        torque = float(np.sqrt(np.mean(constant**2) + (inertia * speed**2 / length) ** 2))
    b = np.full(len(grid.angle), speed**2)
    if not grid.legs.closed:
        b = 4.0 * b * np.minimum(grid.share, 1.0 - grid.share)
    for each in problem.bounds:
        if each.quantity is None:
            b[each.nodes] = np.minimum(b[each.nodes], each.most)
    b[grid.rest] = 0.0
    own = np.sqrt(np.mean((c.inner_torque + 0.25 * c.inner_slope * (b[1:] + b[:-1])) ** 2, axis=0))
    return Sizes(b, torque, np.hypot(torque, own), speed)


def sizes_of(problem: MotionProblem, b: Array) -> Sizes:
    """Sizes of a computed motion."""
    cost = figures(problem, b)
    moving = cost.time - problem.resting
    least = 1e-9 * float(b.max())
    sizes = np.where(problem.coefficients.grid.rest, 0.0, np.maximum(b, least))
    torque = np.sqrt(max(cost.heat / cost.time, (1e-3 * cost.peak) ** 2))
    inner = np.stack([each.at(b) for each in problem.inner_torques()])
    return Sizes(
        sizes,
        float(torque),
        np.hypot(torque, np.sqrt(np.mean(inner**2, axis=0))),
        float(np.abs(problem.coefficients.grid.step).sum()) / moving,
    )


@dataclass(frozen=True, eq=False, repr=False)
class Solution:
    """An optimum and its proof."""

    b: Array  # (N + 1,) at the nodes [rad2/s2]
    value: float  # objective of b
    bound: float  # no motion along these nodes has a lower objective
    prices: Mapping[str, float]  # name of a limit -> the objective falls by this much for each unit by which the limit is relaxed
    where: Mapping[str, NDArray[np.bool_]]  # name of a limit -> (N + 1,) or (N,) bool, nodes or segments at which the limit is active
    relaxed: float = 0.0  # share by which limits are relaxed, of a program that relaxes limits
    # name of a limit -> its part in the contradiction, of a program that relaxes limits
    parts: Mapping[str, float] = field(default_factory=dict)

    @property
    def gap(self) -> float:
        """How far the value is above the bound, as a share of its size."""
        return (self.value - self.bound) / max(abs(self.value), 1e-300)


class _Limit(NamedTuple):
    """The rows of a limit; ``slope``: growth of each row's bound by the share of relaxation; ``at``: node or segment of each row."""

    rows: int
    slope: Array
    at: Index


class _Program:
    """The columns of the unknowns, and the blocks of rows written so far."""

    def __init__(self, problem: MotionProblem, sizes: Sizes, let_out: Callable[[str], bool] | None) -> None:
        self.problem, self.sizes, self.let_out = problem, sizes, let_out
        grid = problem.coefficients.grid
        n, free = len(grid.step), ~grid.rest
        self.column = np.full(n + 1, -1)
        if grid.legs.closed:
            free[-1] = False
        self.nodes = np.flatnonzero(free)
        self.column[self.nodes] = np.arange(len(self.nodes))
        if grid.legs.closed:
            self.column[-1] = self.column[0]
        m = len(self.nodes)
        self.c, self.d, self.e = m, 2 * m, 2 * m + n
        self.p = self.e + n
        weights = problem.weights
        self.with_energy, self.with_peak = "energy" in weights, "peak" in weights
        self.with_heat = self.with_energy or "heat" in weights or problem.rms is not None
        self.peak = self.p + (n if self.with_energy else 0)
        self.cycle = self.peak + int(self.with_peak)
        self.out = self.cycle + 1
        self.width = self.out + int(let_out is not None)
        self.segments = np.arange(n)
        self.root = np.sqrt(sizes.b)
        self.s = self.root[1:] + self.root[:-1]  # size of c_i + c_{i+1}
        self.length = float(np.abs(grid.step).sum())
        self.unit_time = self.length / sizes.speed
        self.unit_heat = sizes.torque**2 * self.unit_time
        self.unit_energy = sizes.torque * self.length
        self.rows: list[Rows] = []
        self.limits: list[_Limit] = []

    def add(
        self,
        kind: str,
        entries: Sequence[tuple[Index, Index, Array]],
        bound: Array,
        limit: tuple[str, Array, Index, float] | None = None,
        size: int = 3,
    ) -> None:
        """Add rows; entries of column -1 are left out, because their unknown is 0. ``limit``: name, slope, places and change of the
        unit."""
        from scipy import sparse  # to save start-up time

        rows, columns, values = (np.concatenate([np.broadcast_to(entry[k], entry[0].shape) for entry in entries]) for k in range(3))
        kept = columns >= 0
        rows, columns, values = rows[kept], columns[kept], values[kept]
        name, slope, at, change = limit or ("", None, None, 1.0)
        if slope is not None and at is not None:
            self.limits.append(_Limit(len(self.rows), slope, at))
            if self.let_out is not None and self.let_out(name):
                some = np.flatnonzero(slope)
                rows = np.concatenate([rows, some])
                columns = np.concatenate([columns, np.full(len(some), self.out)])
                values = np.concatenate([values, -slope[some]])
        matrix = sparse.coo_matrix((values, (rows, columns)), shape=(len(bound), self.width))
        self.rows.append(Rows(kind, matrix, bound, name, change, size if kind == CONE else 0))

    def affine(self, quantity: Affine, scale: Array | float, rows: Index) -> list[tuple[Index, Index, Array]]:
        """Entries of a quantity divided by ``scale``, without its fixed part, in these rows."""
        at, b = quantity.segments, self.sizes.b
        entries = [
            (rows, self.column[at], quantity.before * b[at] * scale),
            (rows, self.column[at + 1], quantity.after * b[at + 1] * scale),
        ]
        if quantity.last is not None and quantity.last_nodes is not None:
            entries.append((rows, self.column[quantity.last_nodes], quantity.last * b[quantity.last_nodes] * scale))
        return entries

    def speeds(self, segments: Index, scale: Array | float, rows: Index) -> list[tuple[Index, Index, Array]]:
        """Entries of c_i + c_{i+1}."""
        first, second = self.column[segments], self.column[segments + 1]
        return [
            (rows, np.where(first < 0, -1, self.c + first), self.root[segments] * scale),
            (rows, np.where(second < 0, -1, self.c + second), self.root[segments + 1] * scale),
        ]

    # -------------------------------------------------------------------------------------------------------------- the motion itself

    def write(self) -> Array:
        """All rows; returns the cost."""
        problem, n = self.problem, len(self.segments)
        m, k = np.arange(len(self.nodes)), self.segments
        ones, none = np.ones(len(m)), np.zeros(len(m))
        bound = np.stack([ones, -ones, none], axis=1).ravel()
        self.add(CONE, [(3 * m, m, -ones), (3 * m + 1, m, -ones), (3 * m + 2, self.c + m, -2.0 * ones)], bound)
        ones, none = np.ones(n), np.zeros(n)
        share = self.speeds(k, -1.0 / self.s, 3 * k)
        minus = self.speeds(k, 1.0 / self.s, 3 * k + 1)
        self.add(
            CONE,
            [(3 * k, self.d + k, -ones), *share, (3 * k + 1, self.d + k, -ones), *minus],
            np.stack([none, none, 2.0 * ones], axis=1).ravel(),
        )
        if self.with_heat:
            torques, root = problem.inner_torques(), 2.0**0.5 / self.sizes.torques
            entries = [(4 * k, self.e + k, -ones), *self.speeds(k, -1.0 / self.s, 4 * k)]
            entries += [(4 * k + 1, self.e + k, -ones), *self.speeds(k, 1.0 / self.s, 4 * k + 1)]
            entries += [entry for j, torque in enumerate(torques) for entry in self.affine(torque, -root, 4 * k + 2 + j)]
            self.add(CONE, entries, np.stack([none, none, *(root * each.fixed for each in torques)], axis=1).ravel(), size=4)
        self._cycle_time()
        for each in problem.bounds:
            self._bounded(each)
        if problem.rms is not None:
            self._rms(problem.rms)
        if self.with_energy:
            self._energy()
        if self.with_peak:
            self._peak()
        if problem.power is not None:
            self._power(problem.power)
        cost = self._cost()
        if problem.ceiling is not None:
            room = problem.ceiling - self.fixed_cost()
            some = np.flatnonzero(cost)
            self.add(AT_MOST, self._row([(some, cost[some] / room)]), np.ones(1))
        return cost

    def moving_time(self, chosen: Index | None = None) -> tuple[Index, Array]:
        """Columns and coefficients of the time of all, or of chosen, segments, in the unit of time."""
        k = self.segments if chosen is None else chosen
        h = np.abs(self.problem.coefficients.grid.step)[k]
        return self.d + k, 2.0 * h / (self.s[k] * self.unit_time)

    def heat(self) -> tuple[list[tuple[Index, Array]], float]:
        """Columns and coefficients of the heat, in its unit, and its fixed part."""
        problem, grid = self.problem, self.problem.coefficients.grid
        h, drag, zero = np.abs(grid.step), problem.drive.crank_drag, np.zeros(len(self.segments), np.intp)
        parts = [(self.e + self.segments, 2.0 * h * self.sizes.torques**2 / (self.s * self.unit_heat))]
        fixed = problem.holding_heat
        if drag:
            mean = problem.mean_torque()
            parts += [(columns, values) for _, columns, values in self.affine(mean, 2.0 * drag * grid.step / self.unit_heat, zero)]
            rolled, level = self.rolled(drag**2 / self.unit_heat, zero)
            parts += [(columns, values) for _, columns, values in rolled]
            fixed += float(2.0 * drag * mean.fixed @ grid.step) + float(level.sum()) * self.unit_heat
        return parts, fixed / self.unit_heat

    def rolled(self, scale: float, rows: Index) -> tuple[list[tuple[Index, Index, Array]], Array]:
        """Entries and fixed parts (N,) of the integrals of the square of the speed over the times of the segments."""
        h, base = 0.5 * scale * np.abs(self.problem.coefficients.grid.step), self.problem.rolled_at
        if base is None:
            return self.speeds(self.segments, h, rows), np.zeros(len(h))
        speed = np.sqrt(base)
        slope = np.divide(0.5, speed, out=np.zeros_like(speed), where=speed > 0)  # at a rest b is zero and not an unknown
        tangent = Affine(h * slope[:-1], h * slope[1:], 0.5 * h * (speed[:-1] + speed[1:]), self.segments)
        return self.affine(tangent, 1.0, rows), tangent.fixed

    def _row(self, parts: Sequence[tuple[Index, Array]], row: int = 0, sign: float = 1.0) -> list[tuple[Index, Index, Array]]:
        return [(np.full(len(columns), row), np.asarray(columns), sign * np.asarray(values)) for columns, values in parts]

    def _cycle_time(self) -> None:
        """Rows for the cycle's time, a variable: at least moving + resting time, at least feed window + time outside it, at most the given
        time."""
        problem = self.problem
        cycle = (np.array([self.cycle]), np.array([-1.0]))
        resting = problem.resting / self.unit_time
        self.add(AT_MOST, self._row([self.moving_time(), cycle]), np.array([-resting]))
        if problem.below is not None:
            beside = -(rest_below(problem) + problem.feed_time) / self.unit_time
            limit = (problem.feed_name, np.array([problem.feed_time / self.unit_time]), np.zeros(1, np.intp), -problem.feed_time)
            self.add(AT_MOST, self._row([self.moving_time(np.flatnonzero(problem.below)), cycle]), np.array([beside]), limit)
        if problem.time is not None:
            most = np.array([problem.time / self.unit_time])
            self.add(AT_MOST, self._row([(cycle[0], np.ones(1))]), most, (problem.time_name, most, np.zeros(1, np.intp), problem.time))

    def _bounded(self, each: Bounded) -> None:
        if each.quantity is None:
            chosen = each.nodes
            rows, size = np.arange(len(chosen)), self.sizes.b[chosen]
            bound, step = each.most / size, np.ones(len(chosen))
            # the slide almost rests near dead centres: rows with a bound of 1e9 cost the solver six digits of its dual
            wide = bound > 1.0
            step[wide], bound[wide] = 1.0 / bound[wide], 1.0
            limit = (each.name, each.power * bound, chosen, each.limit)
            kind = EQUAL if each.equal else AT_MOST
            self.add(kind, [(rows, self.column[chosen], step)], bound, None if each.equal else limit)
            return
        at = each.quantity.segments
        rows, scale = np.arange(len(at)), 1.0 / each.most
        if each.length:
            parts = [entry for k, part in enumerate((each.quantity, *each.length)) for entry in self.affine(part, -scale, 4 * rows + k + 1)]
            bound = np.stack([np.ones(len(at)), *(part.fixed * scale for part in (each.quantity, *each.length))], axis=1)
            slope = np.zeros((len(at), 4))
            slope[:, 0] = 1.0
            self.add(CONE, parts, bound.ravel(), (each.name, slope.ravel(), np.repeat(at, 4), each.limit), 4)
            return
        if each.total:
            entries = self.affine(each.quantity, scale, np.zeros_like(at))
            self.add(AT_MOST, entries, np.array([1.0 - float(scale @ each.quantity.fixed)]))
            return
        for sign in (1.0, -1.0) if each.both else (1.0,):
            entries = self.affine(each.quantity, sign * scale, rows)
            if each.drag:
                way = self.problem.coefficients.grid.way[at]
                entries += self.speeds(at, 0.5 * each.drag * sign * way * scale, rows)
            if each.by_speed:
                entries += self.speeds(at, 0.5 * each.by_speed * scale, rows)
            limit = (each.name, np.full(len(at), each.power), at, each.limit)
            self.add(AT_MOST, entries, 1.0 - sign * scale * each.quantity.fixed, limit)

    def _rms(self, rms: float) -> None:
        parts, fixed = self.heat()
        most = rms**2 * self.unit_time / self.unit_heat  # heat per unit of time at this torque
        row = self._row([*((columns, values / most) for columns, values in parts), (np.array([self.cycle]), np.array([-1.0]))])
        # to first order in the share of relaxation, at the unit of time
        limit = (self.problem.rms_name, np.array([2.0]), np.zeros(1, np.intp), rms)
        self.add(AT_MOST, row, np.array([-fixed / most]), limit)

    def _energy(self) -> None:
        problem, grid, k = self.problem, self.problem.coefficients.grid, self.segments
        drive, mean, h = problem.drive, problem.mean_torque(), np.abs(grid.step)
        copper, drag, unit = drive.copper / drive.ratio**2, drive.crank_drag, self.unit_energy
        for share in dict.fromkeys((1.0, drive.regeneration)):
            by_torque = share * (1.0 + 2.0 * copper * drag) * grid.step / unit
            rolled, level = self.rolled(share * (drag + copper * drag**2 + drive.iron * drive.ratio**2) / unit, k)
            entries = [(k, self.p + k, -np.ones(len(k))), *self.affine(mean, by_torque, k), *rolled]
            entries.append((k, self.e + k, share * 2.0 * h * copper * self.sizes.torques**2 / (self.s * unit)))
            self.add(AT_MOST, entries, -by_torque * mean.fixed - level)

    def _peak(self) -> None:
        grid, k = self.problem.coefficients.grid, self.segments
        size, drag = self.sizes.torque, self.problem.drive.crank_drag
        for torque, end in zip(self.problem.end_torques(), (0, 1), strict=True):
            for sign in (1.0, -1.0):
                entries = [*self.affine(torque, sign / size, k), (k, np.full(len(k), self.peak), -np.ones(len(k)))]
                if drag:
                    entries.append(self.speeds(k, drag * sign * grid.way / size, k)[end])
                self.add(AT_MOST, entries, -sign * torque.fixed / size)

    def _power(self, relaxed: RelaxedPower) -> None:
        """Driving and braking torque over a segment are at most 2 power d, and d at most the mean of the chords of 1 / (2 speed)."""
        mean, grid, k = self.problem.mean_torque(), self.problem.coefficients.grid, self.segments
        size, drag = self.sizes.torque, self.problem.drive.crank_drag
        for sign in (1.0, -1.0):
            entries = [*self.affine(mean, sign / size, k), (k, self.d + k, -2.0 * relaxed.power / (self.s * size))]
            if drag:
                entries += self.speeds(k, 0.5 * drag * sign * grid.way / size, k)
            self.add(AT_MOST, entries, -sign * mean.fixed / size)
        least, most, b = relaxed.least, relaxed.most, self.sizes.b
        known = (least > 0) & np.isfinite(most)
        nodes = np.flatnonzero(known & (self.column >= 0))
        if not len(nodes):
            return
        rows = np.arange(len(nodes))
        self.add(AT_MOST, [(rows, self.column[nodes], np.ones(len(nodes)))], most[nodes] / b[nodes])
        self.add(AT_MOST, [(rows, self.column[nodes], -np.ones(len(nodes)))], -least[nodes] / b[nodes])
        both = np.flatnonzero(known[:-1] & known[1:])
        low, high = np.sqrt(np.where(known, least, 1.0)), np.sqrt(np.where(known, most, 2.0))
        slope = -1.0 / (low * high * (low + high))  # of the chord of 1 / sqrt(b)
        level = 1.0 / low - slope * low**2
        rows, s = np.arange(len(both)), self.s[both]
        entries = [(rows, self.d + both, np.ones(len(both)))]
        entries += [(rows, self.column[at], -0.25 * s * slope[at] * b[at]) for at in (both, both + 1)]
        self.add(AT_MOST, entries, 0.25 * s * (level[both] + level[both + 1]))

    def _cost(self) -> Array:
        """Coefficients of the objective, whose unit is 1; fixed parts are `fixed_cost`."""
        cost, weights = np.zeros(self.width), self.problem.weights
        if self.let_out is not None:
            cost[self.out] = 1.0
            return cost
        if weight := weights.get("heat", 0.0):
            for columns, values in self.heat()[0]:
                some = np.asarray(columns) >= 0
                np.add.at(cost, np.asarray(columns)[some], weight * self.unit_heat * values[some])
        cost[self.cycle] += weights.get("time", 0.0) * self.unit_time
        if self.with_energy:
            cost[self.p : self.p + len(self.segments)] += weights["energy"] * self.unit_energy
        if self.with_peak:
            cost[self.peak] += weights["peak"] * self.sizes.torque
        return cost

    def fixed_cost(self) -> float:
        """Part of the objective that no motion changes."""
        problem, weights = self.problem, self.problem.weights
        if self.let_out is not None:
            return 0.0
        held = problem.drive.copper / problem.drive.ratio**2 * problem.holding_heat
        return weights.get("heat", 0.0) * self.heat()[1] * self.unit_heat + weights.get("energy", 0.0) * held


def solve(
    problem: MotionProblem,
    sizes: Sizes,
    let_out: Callable[[str], bool] | None = None,
    extreme: tuple[int, float] | None = None,
) -> Solution:
    """The optimum; with ``let_out``, the least share by which the named limits must be relaxed.

    Args:
        problem: the problem.
        sizes: sizes that scale the problem.
        let_out: name of a limit -> whether it may be relaxed.
        extreme: a node, and a sign 1 or -1: minimise sign x b at this node instead of the objective.

    Raises:
        InfeasibleError: no motion keeps the limits.
        UnsolvedError: the solver found no answer, neither with these sizes nor with torques of three times this size.
    """
    try:
        return _solve(problem, sizes, let_out, extreme)
    except UnsolvedError:
        return _solve(problem, sizes._replace(torque=3.0 * sizes.torque, torques=3.0 * sizes.torques), let_out, extreme)


def _solve(problem: MotionProblem, sizes: Sizes, let_out: Callable[[str], bool] | None, extreme: tuple[int, float] | None) -> Solution:
    program = _Program(problem, sizes, let_out)
    cost, fixed = program.write(), program.fixed_cost()
    if extreme is not None:
        node, sign = extreme
        cost, fixed = np.zeros(program.width), 0.0
        cost[program.column[node]] = sign * sizes.b[node]
    scale = float(np.abs(cost).max())
    optimum = minimise(cost / scale, program.rows, tolerance=TOLERANCE, equilibrate=False, within=np.inf, remedy=REMEDY)
    x = optimum.x
    # b without a column is 0; rounding errors of the solver must not make b negative
    b = np.where(program.column < 0, 0.0, np.maximum(x[program.column], 1e-12) * sizes.b)
    # residuals of the dual equations lower the bound, for unknowns up to their sizes
    bound = optimum.bound - float(np.abs(optimum.slope) @ np.maximum(1.0 - np.abs(x), 0.0))
    prices, where, parts = _prices(program, scale, optimum.prices)
    share = float(x[program.out]) if let_out is not None else 0.0
    value = share if let_out is not None else objective(problem, b) if extreme is None else extreme[1] * float(b[extreme[0]])
    return Solution(b, value, scale * bound + fixed, prices, where, share, parts)


def _prices(
    program: _Program, scale: float, duals: Sequence[Array]
) -> tuple[dict[str, float], dict[str, NDArray[np.bool_]], dict[str, float]]:
    """Prices of limits, the places at which they act, and their parts in the objective."""
    prices: dict[str, float] = {}
    where: dict[str, NDArray[np.bool_]] = {}
    parts: dict[str, float] = {}
    rows: list[tuple[str, Index, Array]] = []
    for limit in program.limits:
        limited = program.rows[limit.rows]
        by_row = scale * duals[limit.rows] * limit.slope
        parts[limited.name] = parts.get(limited.name, 0.0) + float(by_row.sum())
        prices[limited.name] = prices.get(limited.name, 0.0) + float(by_row.sum()) / limited.unit
        rows.append((limited.name, limit.at, by_row))
    for name, at, by_row in rows:  # a limit may have several blocks; only one of them is active
        acts = where.setdefault(name, np.zeros(len(program.segments) + 1, bool))
        acts[at[by_row > 1e-4 * max(parts[name], 1e-300) / len(program.segments)]] = True
    return prices, where, parts
