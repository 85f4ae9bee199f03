"""Balancing as a convex program: the best counterweights within limits, or the limits that contradict one another.

All criteria are convex functions of variables in which the forces are linear. Only a few states determine a range or a peak. So the program
starts with some states, and adds the states that its solution violates until no state is violated. Then its optimum is the optimum over all
states, and its dual cost is a bound for all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..common.conic_program import AT_MOST, CONE, EQUAL, InfeasibleError, Optimum, Rows, minimise
from ..common.errors import PinpressError
from ..common.quantities import Array
from .problem import AddedMass, BalancingProblem, Range, Rms, Signal, Target, limit_words

Program = tuple[Array, tuple[Rows, ...]]  # cost and constraints
LARGEST = 10.0  # unlimited counterweights above 10 times the moving mass count as growing without limit
OTHERS = 1e-5  # weight of the mean over all conditions, next to the worst, with adjustable counterweights
LIGHTER = 1e-6  # value of saving the whole moving mass, as a share of the objective before: the lightest of equal optima wins


@dataclass(frozen=True, eq=False, repr=False)
class ProvenOptimum:
    """The best values of a problem's variables, with the proof of the optimum.

    Attributes:
        variables: (variables,) the best values.
        bound: no values have a lower objective, weighted and relative to before balancing.
        residual: largest violation of the conditions of optimality.
        rows: constraints of the program.
        prices: dual variables of each constraint: the fall of the objective per unit by which a bound is raised.
    """

    variables: Array
    bound: float
    residual: float
    rows: tuple[Rows, ...]
    prices: tuple[Array, ...]


def solve(problem: BalancingProblem, objective: Mapping[Target, float], limits: Mapping[Target, float]) -> ProvenOptimum:
    """Find the variables with the least objective within limits, and the lightest of equally good variables (`LIGHTER`).

    If the worst condition counts and counterweights are adjusted, the other conditions get their best adjustment too (`OTHERS`).

    Args:
        problem: the problem, with the signals of all criteria.
        objective: targets with their weights; each counts relative to its value before balancing in the worst operating condition.
        limits: largest value of each target in all operating conditions, in its unit.

    Raises:
        InfeasibleError: no variables keep the limits.
        PinpressError: the program was not solved.
    """
    problem = _restrict(problem, [*objective, *limits])
    states = {signal: _first_states(signal) for signal in problem.signals}
    total = sum(objective.values())
    shares = {target: weight / total for target, weight in objective.items()}  # so that the cost is about one
    others = problem.shares is None and any(region.region.reset for region in problem.regions[0])

    def preferring_light() -> Program:
        cost, rows = _program(problem, shares, limits, states, others=others)
        cost[: problem.size] += LIGHTER * (problem.mass.mean(axis=0) / problem.moving_mass)
        return cost, rows

    light, _ = _over_all_states(problem, states, preferring_light)
    best, rows = _over_all_states(problem, states, lambda: _program(problem, shares, limits, states))
    u, prices = light.x[: problem.size], tuple(total * price for price in best.prices)
    return ProvenOptimum(u, total * best.bound, light.residual, rows, prices)


def infeasible_limits(problem: BalancingProblem, limits: Mapping[Target, float]) -> str:
    """A text that names the limits that cannot be met together, and by how much they must be relaxed.

    All limits are relaxed by the same share of their criteria before balancing (mass limits: of the limit or of the moving mass). The
    program finds the least possible share. The limits whose dual variables are not zero then contradict one another.
    """
    problem = _restrict(problem, limits)
    states = {signal: _first_states(signal) for signal in problem.signals}
    best, rows = _over_all_states(problem, states, lambda: _relax(*_program(problem, {}, limits, states, zero_as_equations=False)))
    duals = [(row, float(price[0] if row.kind == CONE else price.sum())) for row, price in zip(rows, best.prices, strict=True)]
    parts = [(row.name, part) for row, part in duals if row.name and row.unit]
    names = list(dict.fromkeys(name for name, part in parts if part > 1e-6)) or [name for name, _ in parts]  # the parts sum to one
    relaxed = " and ".join(f"the {name}" for name in names)
    return (
        f"no counterweights in these regions keep {relaxed}: relax each limit by {100 * best.value:.3g} %"
        " (of its criterion before balancing; a mass limit: of the limit or of the moving mass), or give larger regions"
    )


def objective_value(problem: BalancingProblem, objective: Mapping[Target, float], u: Array) -> float:
    """The objective at values (variables,) of the variables, over all states, weighted and relative to before balancing."""
    return sum(weight * over_conditions(problem.shares, _values(problem, target, u)) for target, weight in objective.items())


def over_conditions(shares: Array | None, values: Sequence[float]) -> float:
    """The value of a target over all conditions: the largest, or the mean weighted by shares; a single value holds for all conditions."""
    return max(values) if shares is None or len(values) == 1 else float(shares @ values)


def _values(problem: BalancingProblem, target: Target, u: Array) -> list[float]:
    """The values of a target in all conditions, relative to before balancing; one value for masses that are the same in all."""
    if isinstance(target, AddedMass):
        return [float(mass - problem.replaced_mass) / problem.moving_mass for mass in problem.mass @ u]
    return [target.of(signal.at(u)) for signal in problem.signals if signal.criterion == target]


def _restrict(problem: BalancingProblem, targets: Collection[Target]) -> BalancingProblem:
    """The problem with only the signals of these targets."""
    return replace(problem, signals=tuple(signal for signal in problem.signals if signal.criterion in targets))


# ---------------------------------------------------------------------------------------------------------------- over all states


def _over_all_states(
    problem: BalancingProblem, states: dict[Signal, Array], program: Callable[[], Program]
) -> tuple[Optimum, tuple[Rows, ...]]:
    """The optimum over all states. ``program`` makes the program over ``states``, to which this function adds states."""
    for _ in range(60):  # ten rounds are already many
        cost, rows = program()
        optimum = minimise(cost, rows, remedy="give counterweights a largest mass, and limits that are neither very large nor very small")
        violated = {signal: _violated(signal, optimum.x[: problem.size], taken) for signal, taken in states.items()}
        if not any(len(more) for more in violated.values()):
            return optimum, rows
        states.update({signal: np.union1d(states[signal], more) for signal, more in violated.items()})
    raise PinpressError("the optimum was not found within 60 rounds: give fewer states, or limits of a realistic size")


def _first_states(signal: Signal) -> Array:
    """Indices of the states with which a program starts: 24, and the extremes of each part of the signal."""
    series = np.concatenate([signal.fixed[:, :, None], signal.effects], axis=2).reshape(len(signal.fixed), -1)
    even = np.linspace(0, len(series) - 1, 24).astype(int)
    return np.unique(np.concatenate([even, series.argmax(axis=0), series.argmin(axis=0)]))


def _violated(signal: Signal, u: Array, states: Array) -> Array:
    """Indices of states outside the extremes of the program's states: local maxima of a signal, and for a range also local minima.

    A state is outside by 1e-10 of the criterion before balancing, or more.
    """
    if isinstance(signal.criterion, Rms):
        return np.empty(0, int)
    series = signal.at(u)
    sides = [series[:, 0], -series[:, 0]] if isinstance(signal.criterion, Range) else [np.linalg.norm(series, axis=1)]
    violated = []
    for side in sides:
        around = np.concatenate([[-np.inf], side, [-np.inf]])
        violated.append(np.flatnonzero((side >= around[:-2]) & (side >= around[2:]) & (side > side[states].max() + 1e-10)))
    return np.concatenate(violated)


# ------------------------------------------------------------------------------------------------------- the program over some states


@dataclass(frozen=True, eq=False, repr=False)
class _Columns:
    """The columns of the program's variables.

    Attributes:
        regions: number of the regions' variables, which come first.
        bounds: column of the upper bound of each target of the objective in each condition; one column for all if only the worst counts.
        worst: column of a bound in one condition -> column of the bound in the worst condition, if both count.
        costs: cost of each of these columns.
        extremes: column of the largest value of each signal of a range; the next column has the smallest value.
        width: number of all variables.
    """

    regions: int
    bounds: Mapping[tuple[Target, int], int]
    worst: Mapping[int, int]
    costs: Mapping[int, float]
    extremes: Mapping[Signal, int]
    width: int

    def wide(self, on_regions: Array, more: Mapping[int, float] | None = None) -> Array:
        """Coefficients (rows, width) from coefficients of the regions' variables (rows, regions); ``more``: column -> coefficient."""
        coefficients = np.zeros((len(on_regions), self.width))
        coefficients[:, : self.regions] = on_regions
        for column, coefficient in (more or {}).items():
            coefficients[:, column] = coefficient
        return coefficients


class _Ceiling(NamedTuple):
    """An upper bound of a target, divided by its size: a number plus the variable in ``column`` (None for a limit); an objective's bound
    has no name.
    """

    column: int | None
    number: float
    name: str

    def slope(self, size: float = 1.0) -> dict[int, float]:
        """Column -> coefficient of the variables that do not belong to regions."""
        return {} if self.column is None else {self.column: -1.0 / size}


def _program(
    problem: BalancingProblem,
    objective: Mapping[Target, float],
    limits: Mapping[Target, float],
    states: Mapping[Signal, Array],
    zero_as_equations: bool = True,
    others: bool = False,
) -> Program:
    """Cost and constraints over the program's states.

    Args:
        problem: the problem.
        objective: targets with their weights.
        limits: largest value of each target.
        states: indices of the states of each signal.
        zero_as_equations: whether limits of zero become equations.
        others: whether the mean over all conditions counts a little, in addition to the worst.
    """
    columns = _columns(problem, objective, others)
    rows = [replace(part, matrix=columns.wide(part.matrix)) for part in problem.rows]
    rows += (Rows(AT_MOST, columns.wide(mass[None] / (LARGEST * problem.moving_mass)), np.ones(1)) for mass in problem.unlimited)
    for signal in problem.signals:
        rows += _signal_rows(signal, columns, states[signal], limits, zero_as_equations)
    rows += _added_mass_rows(problem, columns, limits)
    nothing = np.zeros((1, problem.size))
    rows += (Rows(AT_MOST, columns.wide(nothing, {bound: 1.0, worst: -1.0}), np.zeros(1)) for bound, worst in columns.worst.items())
    cost = np.zeros(columns.width)
    for column, share in columns.costs.items():
        cost[column] = share
    return cost, tuple(rows)


def _columns(problem: BalancingProblem, objective: Mapping[Target, float], others: bool) -> _Columns:
    bounds, costs, width = dict[tuple[Target, int], int](), dict[int, float](), problem.size
    worst = dict[int, int]()
    for target, weight in objective.items():
        conditions = len(problem.mass) if isinstance(target, AddedMass) else len(problem.conditions)
        if others and conditions > 1:
            bounds |= {(target, condition): width + 1 + condition for condition in range(conditions)}
            worst |= dict.fromkeys(range(width + 1, width + 1 + conditions), width)
            weights = [weight, *[weight * OTHERS / conditions] * conditions]
        elif problem.shares is None or conditions == 1:
            bounds |= {(target, condition): width for condition in range(conditions)}
            weights = [weight]
        else:
            counting = np.flatnonzero(problem.shares)
            bounds |= {(target, int(condition)): width + place for place, condition in enumerate(counting)}
            weights = [weight * float(problem.shares[condition]) for condition in counting]
        costs |= dict(enumerate(weights, width))
        width += len(weights)
    ranges = [signal for signal in problem.signals if isinstance(signal.criterion, Range)]
    extremes = {signal: width + 2 * i for i, signal in enumerate(ranges)}
    return _Columns(problem.size, bounds, worst, costs, extremes, width + 2 * len(ranges))


def _relax(cost: Array, rows: tuple[Rows, ...]) -> Program:
    """The program of the least relaxation of all named numerical constraints; the share of relaxation is one more variable."""
    more = []
    for part in rows:
        relaxation = np.zeros((len(part.bound), 1))
        if part.name and part.unit:
            relaxation[: 1 if part.kind == CONE else None] = -1.0
        more.append(replace(part, matrix=np.hstack([part.matrix, relaxation])))
    return np.append(np.zeros_like(cost), 1.0), tuple(more)


def _ceilings(target: Target, condition: int, size: float, columns: _Columns, limits: Mapping[Target, float]) -> Iterator[_Ceiling]:
    """The upper bounds of a target in an operating condition: its variable in the objective, and its limit."""
    if (target, condition) in columns.bounds:
        yield _Ceiling(columns.bounds[target, condition], 0.0, "")
    if target in limits:
        yield _Ceiling(None, limits[target] / size, limit_words(target, limits[target]))


def _signal_rows(
    signal: Signal, columns: _Columns, states: Array, limits: Mapping[Target, float], zero_as_equations: bool
) -> Iterator[Rows]:
    """The constraints that keep a signal's criterion below its bound and limit."""
    if signal in columns.extremes:
        effects, fixed, high = signal.effects[states], signal.fixed[states], columns.extremes[signal]
        yield Rows(AT_MOST, columns.wide(effects[:, 0], {high: -1.0}), -fixed[:, 0])
        yield Rows(AT_MOST, columns.wide(-effects[:, 0], {high + 1: 1.0}), fixed[:, 0])
    for ceiling in _ceilings(signal.criterion, signal.condition, signal.size, columns, limits):
        if zero_as_equations and ceiling.column is None and ceiling.number == 0.0:
            yield _constant_signal(signal, columns, ceiling.name)
        else:
            yield from _below(signal, columns, states, ceiling)


def _below(signal: Signal, columns: _Columns, states: Array, ceiling: _Ceiling) -> Iterator[Rows]:
    """The constraints that keep a signal's criterion below a ceiling in the program's states."""
    effects, fixed = signal.effects[states], signal.fixed[states]
    if isinstance(signal.criterion, Range):
        high, nothing = columns.extremes[signal], np.zeros((1, effects.shape[2]))
        coefficients = columns.wide(nothing, {high: 1.0, high + 1: -1.0} | ceiling.slope())
        yield Rows(AT_MOST, coefficients, np.array([ceiling.number]), ceiling.name, signal.size)
    elif isinstance(signal.criterion, Rms):
        both = np.concatenate([signal.effects, signal.fixed[:, :, None]], axis=2)
        both = both.reshape(-1, both.shape[2]) / np.sqrt(len(both))
        factor = np.asarray(np.linalg.qr(both, mode="r"))  # of the same length as the whole signal
        yield _cone(columns, factor[:, :-1], factor[:, -1], ceiling, signal.size)
    elif fixed.shape[1] == 1:
        both, right = np.concatenate([effects[:, 0], -effects[:, 0]]), np.concatenate([-fixed[:, 0], fixed[:, 0]])
        yield Rows(AT_MOST, columns.wide(both, ceiling.slope()), ceiling.number + right, ceiling.name, signal.size)
    else:
        yield from (_cone(columns, e, f, ceiling, signal.size) for e, f in zip(effects, fixed, strict=True))


def _cone(columns: _Columns, effects: Array, fixed: Array, ceiling: _Ceiling, unit: float) -> Rows:
    """The constraint that keeps the length of ``fixed + effects @ u`` below a ceiling."""
    coefficients = np.concatenate([columns.wide(np.zeros((1, effects.shape[1])), ceiling.slope()), columns.wide(-effects)])
    return Rows(CONE, coefficients, np.concatenate([[ceiling.number], fixed]), ceiling.name, unit)


def _constant_signal(signal: Signal, columns: _Columns, name: str) -> Rows:
    """Independent equations that keep a signal constant, or at zero for a peak.

    Raises:
        InfeasibleError: no variables fulfil them.
    """
    effects, fixed = signal.effects.reshape(-1, signal.effects.shape[2]), signal.fixed.ravel()
    left, sizes, right = np.linalg.svd(effects, full_matrices=False)
    rounding = 1e-10  # of the criterion before balancing, or of the largest effect on it
    kept = sizes > rounding * max(sizes[0], 1.0)
    along = left[:, kept].T @ fixed
    if np.abs(fixed - left[:, kept] @ along).max() > rounding:
        raise InfeasibleError(name)
    return Rows(EQUAL, columns.wide(right[kept]), -along / sizes[kept], name, signal.size)


def _added_mass_rows(problem: BalancingProblem, columns: _Columns, limits: Mapping[Target, float]) -> Iterator[Rows]:
    """The constraints that keep the added mass below its bound and limit."""
    for condition, added in enumerate(problem.mass):
        for ceiling in _ceilings(AddedMass(), condition, problem.moving_mass, columns, limits):
            most = problem.replaced_mass / problem.moving_mass + ceiling.number
            size = max(1.0, most)
            mass = columns.wide(added[None] / (size * problem.moving_mass), ceiling.slope(size))
            yield Rows(AT_MOST, mass, np.array([most / size]), ceiling.name, size * problem.moving_mass)
