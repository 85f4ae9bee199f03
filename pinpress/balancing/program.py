"""Balancing as a convex program: measures of forces that are linear in the variables of rooms.

A range or a peak is held by the few states in which it is reached. The program begins with some states and takes in those that its
solution turns out to violate, until there are none: its optimum is then that of all states, and its dual cost a bound for all of them.
"""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..common.arrays import Array
from ..common.conic_program import AT_MOST, CONE, EQUAL, InfeasibleError, Optimum, Rows, least
from ..common.errors import PinpressError
from .objectives import AddedMass, Range, Rms, Target
from .problem import Problem, Signal

Program = tuple[Array, tuple[Rows, ...]]  # cost and constraints
Wide = Callable[[Array, Mapping[int, float]], Array]  # coefficients on the rooms' variables, and on others by their columns, to all
FIRST_STATES = 24  # of a motion, that a program begins with, besides the extremes of what it is made of
VIOLATED = 1e-10  # of a measure before balancing: a state that exceeds the program's extreme by less does not
MOST_ROUNDS = 60
LARGEST = 10.0  # times the moving mass: counterweights without limits that would weigh more grow without end
LIGHTER = 1e-6  # of the objective before balancing: what saving the press's whole moving mass is worth, so that of equals the lightest wins
STILL = 1e-10  # of a measure before balancing, and of the largest effect on it: less is rounding


@dataclass(frozen=True, eq=False, repr=False)
class Design:
    """The best variables, and the proof.

    Attributes:
        variables: (variables,). bound: no design has less; objective weighted and relative to before. residual: of the proof.
        rows: the program's constraints. prices: its dual variables, by how much the value falls where a bound is raised by one.
    """

    variables: Array
    bound: float
    residual: float
    rows: tuple[Rows, ...]
    prices: tuple[Array, ...]


def solve(problem: Problem, objective: Mapping[Target, float], limits: Mapping[Target, float]) -> Design:
    """The design with the least objective within limits, of those with the same objective the lightest (`LIGHTER`).

    Args:
        objective: targets with their weights; each counts relative to what it is before balancing, in the worst of its cases.
        limits: the most of each, in its unit, in all cases.

    Raises:
        InfeasibleError: there is none.
        PinpressError: the program was not solved.
    """
    problem = _asked(problem, [*objective, *limits])
    states = {signal: _first_states(signal) for signal in problem.signals}
    total = sum(objective.values())
    shares = {target: weight / total for target, weight in objective.items()}  # so that the cost is about one
    light, _ = _exchanged(problem, states, lambda: _lighter(problem, *_program(problem, shares, limits, states)))
    best, rows = _exchanged(problem, states, lambda: _program(problem, shares, limits, states))
    u, prices = light.x[: len(problem.mass)], tuple(total * price for price in best.prices)
    return Design(u, total * best.bound, light.residual, rows, prices)


def relaxed(problem: Problem, limits: Mapping[Target, float]) -> tuple[float, list[tuple[str, float]]]:
    """The least share by which all limits, and the limits of rooms that are numbers, must be let out, and the part of each in it."""
    problem = _asked(problem, limits)
    states = {signal: _first_states(signal) for signal in problem.signals}
    best, rows = _exchanged(problem, states, lambda: _let_out(*_program(problem, {}, limits, states, still=False)))
    parts = [(part, float(price[0] if part.kind == CONE else price.sum())) for part, price in zip(rows, best.prices, strict=True)]
    return best.value, [(part.name, share) for part, share in parts if part.name and part.unit]


def _asked(problem: Problem, targets: Collection[Target]) -> Problem:
    """The problem with the signals of some targets alone."""
    return replace(problem, signals=tuple(signal for signal in problem.signals if signal.measure in targets))


def value_of(problem: Problem, objective: Mapping[Target, float], u: Array) -> float:
    """The objective, from all states."""
    total = 0.0
    for target, weight in objective.items():
        if isinstance(target, AddedMass):
            total += weight * problem.added(u) / problem.moving
        else:
            total += weight * max(target.of(signal.at(u)) for signal in problem.signals if signal.measure == target)
    return total


def _exchanged(problem: Problem, states: dict[Signal, Array], program: Callable[[], Program]) -> tuple[Optimum, tuple[Rows, ...]]:
    """The optimum over all states; ``program`` makes the one over those taken in, ``states``, which grow."""
    for _ in range(MOST_ROUNDS):
        cost, rows = program()
        optimum = least(cost, rows)
        found = {signal: _violated(signal, optimum.x[: len(problem.mass)], taken) for signal, taken in states.items()}
        if not any(len(more) for more in found.values()):
            return optimum, rows
        states.update({signal: np.union1d(states[signal], more) for signal, more in found.items()})
    raise PinpressError(f"the optimum was not found within {MOST_ROUNDS} rounds: give fewer states or bring limits to sensible sizes")


def _program(
    problem: Problem,
    objective: Mapping[Target, float],
    limits: Mapping[Target, float],
    states: Mapping[Signal, Array],
    still: bool = True,
) -> Program:
    """Cost and constraints over the states taken in. Variables: those of the rooms, a bound of every target of the objective, then largest
    and smallest value of every signal of a range. ``still``: limits of zero are equations."""
    count = len(problem.mass)
    bounds = {target: count + i for i, target in enumerate(objective)}
    ranges = [signal for signal in problem.signals if isinstance(signal.measure, Range)]
    extremes = {signal: count + len(objective) + 2 * i for i, signal in enumerate(ranges)}
    width = count + len(objective) + 2 * len(ranges)

    def wide(on_variables: Array, more: Mapping[int, float]) -> Array:
        coefficients = np.zeros((len(on_variables), width))
        coefficients[:, :count] = on_variables
        for column, coefficient in more.items():
            coefficients[:, column] = coefficient
        return coefficients

    rows = [replace(part, coefficients=wide(part.coefficients, {})) for part in problem.rows]
    rows.append(Rows(AT_MOST, wide(problem.unlimited[None] / (LARGEST * problem.moving), {}), np.ones(1)))
    for signal in problem.signals:
        effects, fixed = signal.effects[states[signal]], signal.fixed[states[signal]]
        if signal in extremes:
            high = extremes[signal]
            rows.append(Rows(AT_MOST, wide(effects[:, 0], {high: -1.0}), -fixed[:, 0]))
            rows.append(Rows(AT_MOST, wide(-effects[:, 0], {high + 1: 1.0}), fixed[:, 0]))
        for top, constant, name in _tops(signal.measure, signal.size, bounds, limits):
            if still and top is None and constant == 0.0:
                rows.append(_unmoved(signal, wide, name))
            else:
                rows += _held(signal, effects, fixed, wide, extremes.get(signal), top, constant, name)
    for top, constant, name in _tops(AddedMass(), problem.moving, bounds, limits):
        most = problem.own / problem.moving + constant
        size = max(1.0, most)
        mass = wide(problem.mass[None] / (size * problem.moving), {} if top is None else {top: -1.0 / size})
        rows.append(Rows(AT_MOST, mass, np.array([most / size]), name, size * problem.moving))
    cost = np.zeros(width)
    for target, weight in objective.items():
        cost[bounds[target]] = weight
    return cost, tuple(rows)


def _lighter(problem: Problem, cost: Array, rows: tuple[Rows, ...]) -> Program:
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


def _tops(
    target: Target, size: float, bounds: Mapping[Target, int], limits: Mapping[Target, float]
) -> Iterator[tuple[int | None, float, str]]:
    """What a target in units of its size is to stay below: a variable (its column) or a number, with the name of the limit."""
    if target in bounds:
        yield bounds[target], 0.0, ""
    if target in limits:
        yield None, limits[target] / size, limit_words(target, limits[target])


def limit_words(target: Target, limit: float) -> str:
    """Name of a limit."""
    return f"limit of the {target.words}, {limit:g} {target.unit}"


def _held(
    signal: Signal, effects: Array, fixed: Array, wide: Wide, high: int | None, top: int | None, constant: float, name: str
) -> list[Rows]:
    """A signal's measure held below a variable or a number; ``effects`` and ``fixed`` of the states taken in."""
    more = {} if top is None else {top: -1.0}
    if high is not None:
        return [
            Rows(
                AT_MOST, wide(np.zeros((1, effects.shape[2])), {high: 1.0, high + 1: -1.0} | more), np.array([constant]), name, signal.size
            )
        ]
    if isinstance(signal.measure, Rms):
        matrix, right = _root(signal)
        return [_cone(wide, matrix, right, more, constant, name, signal.size)]
    if fixed.shape[1] == 1:
        both, right = np.concatenate([effects[:, 0], -effects[:, 0]]), np.concatenate([-fixed[:, 0], fixed[:, 0]])
        return [Rows(AT_MOST, wide(both, more), constant + right, name, signal.size)]
    return [_cone(wide, e, f, more, constant, name, signal.size) for e, f in zip(effects, fixed, strict=True)]


def _cone(wide: Wide, effects: Array, fixed: Array, more: Mapping[int, float], constant: float, name: str, unit: float) -> Rows:
    """The length of ``fixed + effects @ u`` held below a variable or a constant."""
    coefficients = np.concatenate([wide(np.zeros((1, effects.shape[1])), more), wide(-effects, {})])
    return Rows(CONE, coefficients, np.concatenate([[constant], fixed]), name, unit)


def _root(signal: Signal) -> tuple[Array, Array]:
    """Matrix (r, variables) and vector (r,) so that the length of their ``vector + matrix @ u`` is the rms of a signal."""
    both = np.concatenate([signal.effects, signal.fixed[:, :, None]], axis=2)
    both = both.reshape(-1, both.shape[2]) / np.sqrt(len(both))
    factor = np.asarray(np.linalg.qr(both, mode="r"))
    return factor[:, :-1], factor[:, -1]


def _unmoved(signal: Signal, wide: Wide, name: str) -> Rows:
    """Equations, none of them superfluous, under which a signal does not change, or of a peak is zero.

    Raises:
        InfeasibleError: no variables do that.
    """
    effects, fixed = signal.effects.reshape(-1, signal.effects.shape[2]), signal.fixed.ravel()
    left, sizes, right = np.linalg.svd(effects, full_matrices=False)
    kept = sizes > STILL * max(sizes[0], 1.0)
    along = left[:, kept].T @ fixed
    if np.abs(fixed - left[:, kept] @ along).max() > STILL:
        raise InfeasibleError(name)
    return Rows(EQUAL, wide(right[kept], {}), -along / sizes[kept], name, signal.size)


def _first_states(signal: Signal) -> Array:
    """Indices of the states that a program begins with."""
    series = np.concatenate([signal.fixed[:, :, None], signal.effects], axis=2).reshape(len(signal.fixed), -1)
    even = np.linspace(0, len(series) - 1, FIRST_STATES).astype(int)
    return np.unique(np.concatenate([even, series.argmax(axis=0), series.argmin(axis=0)]))


def _violated(signal: Signal, u: Array, states: Array) -> Array:
    """Indices of the states, beside those taken in, where a signal's extremes exceed these: the tops of what sticks out."""
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
