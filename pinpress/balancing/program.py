"""Balancing as a convex program: the best design within limits, or which limits contradict one another.

All measures are convex functions of variables in which the forces are linear. A range or a peak is held by the few states in which it is
reached. The program begins with some states and takes in those that its solution violates, until there are none: its optimum is then that
of all states, and its dual cost a bound for all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..common.conic_program import AT_MOST, CONE, EQUAL, InfeasibleError, Optimum, Rows, minimise
from ..common.errors import PinpressError
from ..common.quantities import Array
from .problem import AddedMass, BalancingProblem, Range, Rms, Signal, Target, limit_words

Program = tuple[Array, tuple[Rows, ...]]  # cost and constraints
FIRST_STATES = 24  # of a motion, with which a program begins, besides the extremes of what it is made of
VIOLATED = 1e-10  # of a measure before balancing: a state that exceeds the program's extreme by less does not violate it
MOST_ROUNDS = 60
LARGEST = 10.0  # times the moving mass: counterweights without limits that would weigh more grow without end
LIGHTER = (
    1e-6  # of the objective before balancing: what it is worth to save the press's whole moving mass, so that of equals the lightest wins
)
ZERO = 1e-10  # of a measure before balancing, and of the largest effect on it: less is rounding
INVOLVED = 1e-6  # of all: a limit with a smaller part in a contradiction has none


@dataclass(frozen=True, eq=False, repr=False)
class Design:
    """The best variables, and the proof.

    Attributes:
        variables: (variables,).
        bound: No design has a lower objective, weighted and relative to before.
        residual: Residual of the proof.
        rows: Constraints of the program.
        prices: Dual variables of each constraint: by how much the value falls where a bound is raised by one.
    """

    variables: Array
    bound: float
    residual: float
    rows: tuple[Rows, ...]
    prices: tuple[Array, ...]


def solve(problem: BalancingProblem, objective: Mapping[Target, float], limits: Mapping[Target, float]) -> Design:
    """The design with the least objective within limits, and of equal ones the lightest (`LIGHTER`).

    Args:
        problem: The problem, with the signals of all measures.
        objective: Targets with their weights; each counts relative to what it is before balancing, in its worst condition.
        limits: The most of each target in all conditions, in its unit.

    Raises:
        InfeasibleError: No design is within the limits.
        PinpressError: The program was not solved.
    """
    problem = _restricted(problem, [*objective, *limits])
    states = {signal: _first_states(signal) for signal in problem.signals}
    total = sum(objective.values())
    shares = {target: weight / total for target, weight in objective.items()}  # so that the cost is about one
    light, _ = _over_all_states(problem, states, lambda: _preferring_light(problem, *_program(problem, shares, limits, states)))
    best, rows = _over_all_states(problem, states, lambda: _program(problem, shares, limits, states))
    u, prices = light.x[: len(problem.mass)], tuple(total * price for price in best.prices)
    return Design(u, total * best.bound, light.residual, rows, prices)


def contradiction(problem: BalancingProblem, limits: Mapping[Target, float]) -> str:
    """Say in words which limits cannot be met together, and what their least common excess is.

    All limits are let out by the same share of their measures before balancing (masses: of their own size), the least share that makes them
    possible. The limits whose dual variables are then not zero are those that contradict one another.
    """
    excess, parts = _least_excess(problem, limits)
    names = list(dict.fromkeys(name for name, part in parts if part > INVOLVED)) or [name for name, _ in parts]
    return (
        f"no counterweights in these regions fulfil {' and '.join(f'the {name}' for name in names)}: they would if each were let out by"
        f" {100 * excess:.3g} % (of its measure before balancing; of a mass, of itself or the moving mass); allow more, or larger regions"
    )


def objective_value(problem: BalancingProblem, objective: Mapping[Target, float], u: Array) -> float:
    """The objective at values (variables,), from all states."""
    total = 0.0
    for target, weight in objective.items():
        if isinstance(target, AddedMass):
            total += weight * problem.added(u) / problem.moving
        else:
            total += weight * max(target.of(signal.at(u)) for signal in problem.signals if signal.measure == target)
    return total


def _least_excess(problem: BalancingProblem, limits: Mapping[Target, float]) -> tuple[float, list[tuple[str, float]]]:
    """The least share by which all limits that are numbers, those of regions too, must be let out, and the part of each in it."""
    problem = _restricted(problem, limits)
    states = {signal: _first_states(signal) for signal in problem.signals}
    best, rows = _over_all_states(problem, states, lambda: _let_out(*_program(problem, {}, limits, states, zero_as_equations=False)))
    parts = [(part, float(price[0] if part.kind == CONE else price.sum())) for part, price in zip(rows, best.prices, strict=True)]
    return best.value, [(part.name, share) for part, share in parts if part.name and part.unit]


def _restricted(problem: BalancingProblem, targets: Collection[Target]) -> BalancingProblem:
    """The problem with the signals of these targets alone."""
    return replace(problem, signals=tuple(signal for signal in problem.signals if signal.measure in targets))


# ---------------------------------------------------------------------------------------------------------------- over all states


def _over_all_states(
    problem: BalancingProblem, states: dict[Signal, Array], program: Callable[[], Program]
) -> tuple[Optimum, tuple[Rows, ...]]:
    """The optimum over all states. ``program`` makes the program over those taken in, which are in ``states`` and grow."""
    for _ in range(MOST_ROUNDS):
        cost, rows = program()
        optimum = minimise(cost, rows)
        found = {signal: _violated(signal, optimum.x[: len(problem.mass)], taken) for signal, taken in states.items()}
        if not any(len(more) for more in found.values()):
            return optimum, rows
        states.update({signal: np.union1d(states[signal], more) for signal, more in found.items()})
    raise PinpressError(f"the optimum was not found within {MOST_ROUNDS} rounds: give fewer states or bring limits to sensible sizes")


def _first_states(signal: Signal) -> Array:
    """Indices of the states with which a program begins."""
    series = np.concatenate([signal.fixed[:, :, None], signal.effects], axis=2).reshape(len(signal.fixed), -1)
    even = np.linspace(0, len(series) - 1, FIRST_STATES).astype(int)
    return np.unique(np.concatenate([even, series.argmax(axis=0), series.argmin(axis=0)]))


def _violated(signal: Signal, u: Array, states: Array) -> Array:
    """Indices of further states, besides those taken in, that violate these: the local maxima of a signal's sides beyond them."""
    series = signal.at(u)
    if isinstance(signal.measure, Rms):
        return np.empty(0, int)
    sides = [series[:, 0], -series[:, 0]] if isinstance(signal.measure, Range) else [np.linalg.norm(series, axis=1)]
    found = []
    for side in sides:
        around = np.concatenate([[-np.inf], side, [-np.inf]])
        top = (side >= around[:-2]) & (side >= around[2:]) & (side > side[states].max() + VIOLATED)
        found.append(np.flatnonzero(top))
    return np.concatenate(found)


# ------------------------------------------------------------------------------------------------------- the program over some states


@dataclass(frozen=True, eq=False, repr=False)
class _Columns:
    """Where the program's variables stand.

    Attributes:
        regions: Number of the regions' variables, which come first.
        bounds: Column of the bound of every target of the objective.
        extremes: Column of the largest value of every signal of a range; the smallest value is in the next column.
        width: Number of all variables.
    """

    regions: int
    bounds: Mapping[Target, int]
    extremes: Mapping[Signal, int]
    width: int

    def wide(self, on_regions: Array, more: Mapping[int, float] | None = None) -> Array:
        """Coefficients (rows, width) from those on the regions' variables (rows, regions), and on others by their columns."""
        coefficients = np.zeros((len(on_regions), self.width))
        coefficients[:, : self.regions] = on_regions
        for column, coefficient in (more or {}).items():
            coefficients[:, column] = coefficient
        return coefficients


class _Ceiling(NamedTuple):
    """What a target in units of its size must stay below: a variable in a column plus a number, with the name of the limit."""

    column: int | None
    number: float
    name: str

    def slope(self, size: float = 1.0) -> dict[int, float]:
        """Coefficients on other than the regions' variables."""
        return {} if self.column is None else {self.column: -1.0 / size}


def _program(
    problem: BalancingProblem,
    objective: Mapping[Target, float],
    limits: Mapping[Target, float],
    states: Mapping[Signal, Array],
    zero_as_equations: bool = True,
) -> Program:
    """Cost and constraints over the states taken in. ``zero_as_equations``: whether limits of zero become equations."""
    columns = _columns(problem, objective)
    rows = [replace(part, coefficients=columns.wide(part.coefficients)) for part in problem.rows]
    rows.append(Rows(AT_MOST, columns.wide(problem.unlimited[None] / (LARGEST * problem.moving)), np.ones(1)))
    for signal in problem.signals:
        rows += _signal_rows(signal, columns, states[signal], limits, zero_as_equations)
    rows += _added_mass_rows(problem, columns, limits)
    cost = np.zeros(columns.width)
    for target, weight in objective.items():
        cost[columns.bounds[target]] = weight
    return cost, tuple(rows)


def _columns(problem: BalancingProblem, objective: Mapping[Target, float]) -> _Columns:
    count = len(problem.mass)
    ranges = [signal for signal in problem.signals if isinstance(signal.measure, Range)]
    return _Columns(
        regions=count,
        bounds={target: count + i for i, target in enumerate(objective)},
        extremes={signal: count + len(objective) + 2 * i for i, signal in enumerate(ranges)},
        width=count + len(objective) + 2 * len(ranges),
    )


def _preferring_light(problem: BalancingProblem, cost: Array, rows: tuple[Rows, ...]) -> Program:
    """The program that prefers the lighter of designs that are as good."""
    mass = np.zeros_like(cost)
    mass[: len(problem.mass)] = problem.mass / problem.moving
    return cost + LIGHTER * mass, rows


def _let_out(cost: Array, rows: tuple[Rows, ...]) -> Program:
    """The program of the least excess, one variable more, of all named constraints that are on numbers."""
    more = []
    for part in rows:
        let_out = np.zeros((len(part.bound), 1))
        if part.name and part.unit:
            let_out[: 1 if part.kind == CONE else None] = -1.0
        more.append(replace(part, coefficients=np.hstack([part.coefficients, let_out])))
    return np.append(np.zeros_like(cost), 1.0), tuple(more)


def _ceilings(target: Target, size: float, columns: _Columns, limits: Mapping[Target, float]) -> Iterator[_Ceiling]:
    """The bound of a target of the objective, and the limit of a target that is limited."""
    if target in columns.bounds:
        yield _Ceiling(columns.bounds[target], 0.0, "")
    if target in limits:
        yield _Ceiling(None, limits[target] / size, limit_words(target, limits[target]))


def _signal_rows(
    signal: Signal, columns: _Columns, states: Array, limits: Mapping[Target, float], zero_as_equations: bool
) -> Iterator[Rows]:
    """The constraints that hold a signal's measure below its bound and limit."""
    if signal in columns.extremes:
        effects, fixed, high = signal.effects[states], signal.fixed[states], columns.extremes[signal]
        yield Rows(AT_MOST, columns.wide(effects[:, 0], {high: -1.0}), -fixed[:, 0])
        yield Rows(AT_MOST, columns.wide(-effects[:, 0], {high + 1: 1.0}), fixed[:, 0])
    for ceiling in _ceilings(signal.measure, signal.size, columns, limits):
        if zero_as_equations and ceiling.column is None and ceiling.number == 0.0:
            yield _constant_signal(signal, columns, ceiling.name)
        else:
            yield from _below(signal, columns, states, ceiling)


def _below(signal: Signal, columns: _Columns, states: Array, ceiling: _Ceiling) -> Iterator[Rows]:
    """A signal's measure, over the states taken in, held below a ceiling."""
    effects, fixed = signal.effects[states], signal.fixed[states]
    if isinstance(signal.measure, Range):
        high, nothing = columns.extremes[signal], np.zeros((1, effects.shape[2]))
        coefficients = columns.wide(nothing, {high: 1.0, high + 1: -1.0} | ceiling.slope())
        yield Rows(AT_MOST, coefficients, np.array([ceiling.number]), ceiling.name, signal.size)
    elif isinstance(signal.measure, Rms):
        yield _cone(columns, *_rms_factor(signal), ceiling, signal.size)
    elif fixed.shape[1] == 1:
        both, right = np.concatenate([effects[:, 0], -effects[:, 0]]), np.concatenate([-fixed[:, 0], fixed[:, 0]])
        yield Rows(AT_MOST, columns.wide(both, ceiling.slope()), ceiling.number + right, ceiling.name, signal.size)
    else:
        yield from (_cone(columns, e, f, ceiling, signal.size) for e, f in zip(effects, fixed, strict=True))


def _cone(columns: _Columns, effects: Array, fixed: Array, ceiling: _Ceiling, unit: float) -> Rows:
    """The length of ``fixed + effects @ u`` held below a ceiling."""
    coefficients = np.concatenate([columns.wide(np.zeros((1, effects.shape[1])), ceiling.slope()), columns.wide(-effects)])
    return Rows(CONE, coefficients, np.concatenate([[ceiling.number], fixed]), ceiling.name, unit)


def _rms_factor(signal: Signal) -> tuple[Array, Array]:
    """Matrix (r, variables) and vector (r,) with which the length of ``vector + matrix @ u`` is the rms of a signal."""
    both = np.concatenate([signal.effects, signal.fixed[:, :, None]], axis=2)
    both = both.reshape(-1, both.shape[2]) / np.sqrt(len(both))
    factor = np.asarray(np.linalg.qr(both, mode="r"))
    return factor[:, :-1], factor[:, -1]


def _constant_signal(signal: Signal, columns: _Columns, name: str) -> Rows:
    """Equations, none of them redundant, under which a signal does not change, or is zero where a peak is measured.

    Raises:
        InfeasibleError: No variables fulfil them.
    """
    effects, fixed = signal.effects.reshape(-1, signal.effects.shape[2]), signal.fixed.ravel()
    left, sizes, right = np.linalg.svd(effects, full_matrices=False)
    kept = sizes > ZERO * max(sizes[0], 1.0)
    along = left[:, kept].T @ fixed
    if np.abs(fixed - left[:, kept] @ along).max() > ZERO:
        raise InfeasibleError(name)
    return Rows(EQUAL, columns.wide(right[kept]), -along / sizes[kept], name, signal.size)


def _added_mass_rows(problem: BalancingProblem, columns: _Columns, limits: Mapping[Target, float]) -> Iterator[Rows]:
    """The constraints that hold the added mass below its bound and limit."""
    for ceiling in _ceilings(AddedMass(), problem.moving, columns, limits):
        most = problem.own / problem.moving + ceiling.number
        size = max(1.0, most)
        mass = columns.wide(problem.mass[None] / (size * problem.moving), ceiling.slope(size))
        yield Rows(AT_MOST, mass, np.array([most / size]), ceiling.name, size * problem.moving)
