"""Synthesis: the link lengths and pivots of a press that minimise an objective under constraints.

    found = synthesise(
        load("thin_wall"),
        {"l4": (0.05, 0.22, 0.40), "h": (0.60, 0.63, 0.70)},  # lower bound, start, upper bound [m]
        minimise=lambda t: speed_variation(t.motion, 0.12),
        subject_to={"pressure angle": (lambda t: pressure_angle(t.motion, t.positions["E"], t.positions["D"], (1, 0, 0)), None, 0.7)},
        geometry=lambda l4, h: {("E", "coupler"): (l4, 0, 0), ("slide_guide", "frame"): (0, 0, h)},
        speed=7.54,
    )
    found.press, found.variables, found.active

All gradients are exact (`pinpress.derivatives`), and the assembly is continued from design to design. The result meets the conditions of an
optimum; otherwise an error explains why the search found no optimum.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..common import tables
from ..common.arguments import any_numbers, suitable_numbers, typed
from ..common.errors import AssemblyError, PinpressError, SingularityError, UnknownNameError, caution, shown
from ..common.frozen import FrozenMapping, read_only
from ..common.quantities import Array
from ..common.results import Record, Records, Tabular
from ..common.tables import Column
from ..derivatives.motion import Pivots, nowhere, pivot_positions, planar
from ..derivatives.reactions import refuse_unknown
from ..derivatives.reshape import reshaped
from ..kinematics.cycle import cycle, period_at
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..loads.link import Load
from .design import Design, Start
from .problem import Function, Point, Problem, Requirement, Variable, verify_gradients
from .search import ActiveBound, Search, optimality

SYNTHESISED = "_synthesised"  # end of the name of the resulting press
UNCONSTRAINED: Mapping[str, Any] = FrozenMapping({})
SAME = 1e-9  # largest difference between the motions of the resulting press and its trial, as a share of the linkage's size
FINER = 8  # factor for the number of crank angles at which the result is checked
NOTICED = 1e-3  # share of a constraint's size by which it may be missed between the crank angles of trials
WIDE = 14  # characters of a number's column


@typed
def synthesise(
    press: Linkage,
    variables: Mapping[str, tuple[float, float, float]],
    *,
    minimise: Function,
    subject_to: Mapping[str, tuple[Function, float | None, float | None]] = UNCONSTRAINED,
    geometry: Callable[..., Pivots] | None = None,
    speed: float,
    points: int | None = None,
    method: str = "local",
    loads: Sequence[Load] = (),
    seed: int = 0,
) -> SynthesisResult:
    """Find the lengths of a planar press that minimise an objective over one period at constant speed.

    Args:
        press: a planar press. It keeps all lengths that no variable changes.
        variables: name -> (lower bound, start, upper bound) [SI].
        minimise: function of a `Trial` that returns a number, or an array (m,) whose largest element is minimised.
        subject_to: name -> (function of a `Trial`, lower bound, upper bound). None or infinity means no bound, and equal bounds mean an
            equation. If the function returns an array, every element keeps the bounds.
        geometry: function of the variables, with their names as arguments, that returns pivots as for `reshaped`, written with NumPy's
            functions. Write design rules here. None: variables are single coordinates, named bearing.link.axis, e.g. "B.crank.x".
        speed: speed of the crank [rad/s].
        points: number of crank angles of the period at which trials are evaluated; None: 360 a turn.
        method: "local" for the optimum next to the start, "global" for the best of the optima next to many starts within the bounds.
        loads: constant forces, and process loads with a datum.
        seed: seed of the random starts of a global search.

    Returns:
        The resulting press, with the bounds that are active at the optimum.

    Raises:
        PinpressError: the linkage is not planar, an argument is not as described, the start cannot be assembled or its crank does not turn
            fully, a function fails or has a wrong gradient, no design keeps the constraints, or the search does not converge.
        UnknownNameError: the linkage does not have a bearing or link with this name.
    """
    problem = state_problem(press, variables, minimise, subject_to, geometry)
    refuse_unknown(loads)
    if not isinstance(method, str) or method not in ("local", "global"):
        raise PinpressError(f"method is {shown(method)}: write 'local' or 'global'")
    start = _start(press, problem, speed, points, loads)
    verify_gradients(start, [np.random.default_rng(0).uniform(0.5, 1.0, len(problem.variables))])
    search = Search(start.problem)
    return _result_of_search(start, search, search.local(start) if method == "local" else search.best(start, seed), speed, points)


def local_optimum(press: Linkage, problem: Problem, speed: float, points: int | None, loads: Sequence[Load]) -> SynthesisResult:
    """The optimum next to the start of a problem whose gradients are already checked. Raises as `synthesise`."""
    start = _start(press, problem, speed, points, loads)
    search = Search(start.problem)
    return _result_of_search(start, search, search.local(start), speed, points)


@dataclass(frozen=True, eq=False, repr=False)
class SynthesisResult(Tabular):
    """The optimum of a synthesis.

    Attributes:
        press: the linkage with the optimal lengths, as from `reshaped`.
        variables: name -> value of each variable [SI].
        value: value of the objective at the optimum [SI].
        start_value: value of the objective at the start [SI].
        constraints: name -> value of each constraint at the optimum, a number or (m,) [SI].
        active: the active bounds of variables and constraints, with their multipliers.
        idle: names of the variables that influence neither the objective nor a constraint; any value of these is optimal.
        missed: how far the worst constraint is outside its bounds at eight times the crank angles, as a share of the constraint's size [-].
        finer_value: value of the objective at eight times the crank angles [SI].
        kkt: residual of the conditions of Karush, Kuhn and Tucker, at most 1e-6 [-]: the unbalanced change of the objective, divided by
            its size, for a change of a variable over its whole range.
        evaluations: number of evaluated designs.
        infeasible: number of designs that could not be assembled or evaluated.
    """

    press: Linkage
    variables: Mapping[str, float]
    value: float
    start_value: float
    constraints: Mapping[str, float | Array]
    active: Records[ActiveBound]
    idle: tuple[str, ...]
    missed: float
    finer_value: float
    kkt: float
    evaluations: int
    infeasible: int
    _rows: Records[BoundedQuantity]

    @property
    def title(self) -> str:
        found = ", ".join(f"{name} = {value:.6g}" for name, value in self.variables.items())
        return f"SynthesisResult of {self.press.name}: {self.start_value:.6g} to {self.value:.6g} with {found}"

    def __str__(self) -> str:
        return _text(self)

    def table(self) -> Records[BoundedQuantity]:
        """A row for each variable, then for each constraint."""
        return self._rows

    def columns(self) -> dict[str, Column]:
        """The columns of `table`; None for a missing bound."""
        return self._rows.columns()


@dataclass(frozen=True, repr=False)
class BoundedQuantity(Record):
    """A variable or constraint in the table of a synthesis; for a constraint with several elements the one nearest to a bound.

    Attributes:
        name: name of the variable or constraint.
        kind: "variable" or "constraint".
        lower: lower bound [SI]; None: no lower bound.
        start: value at the start [SI].
        value: value at the optimum [SI].
        upper: upper bound [SI]; None: no upper bound.
    """

    name: str
    kind: str
    lower: float | None
    start: float
    value: float
    upper: float | None


def state_problem(press: Linkage, variables: Any, minimise: Any, subject_to: Any, geometry: Any) -> Problem:
    """The problem of checked arguments, with requirements that are not yet scaled."""
    planar(press)
    for name, mapping in (("variables", variables), ("subject_to", subject_to)):
        if not isinstance(mapping, Mapping):
            raise PinpressError(f"{name} is a {type(mapping).__name__}: give a mapping from names")
    if geometry is not None and not callable(geometry):
        raise PinpressError(f"geometry is a {type(geometry).__name__}: give a function of the variables that returns pivots")
    checked = tuple(_variable(name, bounds) for name, bounds in variables.items())
    if not checked:
        raise PinpressError("variables is empty: give {name: (lower bound, start, upper bound)}")
    requirements = (Requirement("", minimise), *(_constraint(name, constraint) for name, constraint in subject_to.items()))
    return Problem(checked, geometry or _coordinates(press, tuple(variables)), requirements)


def _variable(name: str, bounds: Any) -> Variable:
    expected = "(lower bound, start, upper bound), three finite numbers"
    lower, start, upper = suitable_numbers(f"variable {shown(name)}", bounds, expected, (3,)).tolist()
    if lower > upper:
        raise PinpressError(f"variable {shown(name)}: its lower bound {lower:g} is above its upper bound {upper:g}: exchange them")
    if not lower <= start <= upper:
        raise PinpressError(
            f"variable {shown(name)} starts at {start:g}, outside its bounds {lower:g} to {upper:g}: give a start between them"
        )
    return Variable(name, lower, start, upper)


def _constraint(name: str, given: Any) -> Requirement:
    if not isinstance(given, tuple | list) or len(given) != 3 or not callable(given[0]):
        raise PinpressError(f"constraint {shown(name)} is {shown(given)}: give (function of a trial, lower bound, upper bound)")
    open_bounds = [-math.inf if given[1] is None else given[1], math.inf if given[2] is None else given[2]]
    lower, upper = (float(any_numbers(f"constraint {shown(name)}", bound, ())) for bound in open_bounds)
    if math.isnan(lower) or math.isnan(upper) or lower > upper:
        raise PinpressError(f"constraint {shown(name)}: its lower bound {lower:g} is above its upper bound {upper:g}: exchange them")
    return Requirement(name, given[0], lower, upper)


def _coordinates(press: Linkage, names: tuple[str, ...]) -> Callable[..., Pivots]:
    """The geometry whose variables are single coordinates of pivots."""
    positions = pivot_positions(press)
    coordinates = {f"{bearing}.{link}.{axis}": ((bearing, link), k) for bearing, link in positions for k, axis in enumerate("xyz")}
    for name in names:
        if name not in coordinates:
            raise UnknownNameError("coordinate", name, coordinates)

    def geometry(**values: Any) -> Pivots:
        pivots: dict[tuple[str, str], Any] = {coordinates[name][0]: list(positions[coordinates[name][0]]) for name in values}
        for name, value in values.items():
            pivot, axis = coordinates[name]
            pivots[pivot][axis] = value
        return pivots

    return geometry


def _start(press: Linkage, problem: Problem, speed: float, points: int | None, loads: Sequence[Load]) -> Point:
    """The start, with requirements scaled by their size there.

    Raises:
        PinpressError: the start cannot be assembled, or locks.
    """
    values = {variable.name: variable.start for variable in problem.variables}
    try:
        drawn = reshaped(press, problem.pivots(values))
        motion = cycle(drawn, speed, points=points)
    except (AssemblyError, SingularityError) as error:
        listed = ", ".join(f"{name} = {value:g}" for name, value in values.items())
        raise PinpressError(f"the start, {listed}, is not a valid press: {error}; start elsewhere") from error
    design = _close_design(drawn, motion, values, loads)
    point = problem.at(problem.scaled(values), design)
    scaled = tuple(
        _scale_requirement(requirement, values_) for requirement, values_ in zip(problem.requirements, point.values, strict=True)
    )
    return Problem(problem.variables, problem.geometry, scaled).at(point.z, design)


def _close_design(drawn: Linkage, motion: Motion, values: dict[str, float], loads: Sequence[Load]) -> Design:
    """The design of a drawn press, closed at the crank angles of a motion."""
    plane = planar(drawn)
    closure = drawn.engine().close(motion.crank_angle, motion.joint_position.T)
    state = closure.position, closure.first, closure.second, closure.gap
    return Design(Start(drawn, plane, motion, loads), values, nowhere(drawn), [], plane, *state)


def _scale_requirement(requirement: Requirement, values: Array) -> Requirement:
    """The requirement, scaled by the larger of the sizes of its values and its bounds."""
    sizes = [float(np.abs(values).max()), *(abs(bound) for bound in (requirement.lower, requirement.upper) if math.isfinite(bound))]
    return Requirement(requirement.name, requirement.function, requirement.lower, requirement.upper, max(sizes) or 1.0)


def _result_of_search(start: Point, search: Search, found: Point, speed: float, points: int | None) -> SynthesisResult:
    """The result of a search.

    Raises:
        PinpressError: the resulting press moves in another way than its trial, because it locks between two points.
    """
    motion, trial = period_at(found.design.press, speed, points), found.design.motion
    if not np.abs(motion.joint_position - trial.joint_position).max() <= SAME * (1 + found.design.plane.size):
        raise PinpressError("the resulting press moves in another assembly than its drawn pose: give narrower bounds of the variables")
    return _result(start, found, search, _finer(found, speed))


def _finer(found: Point, speed: float) -> Point:
    """The resulting design, with more crank angles.

    Raises:
        PinpressError: the design locks between the crank angles of its trial, or a function fails.
    """
    design, problem = found.design, found.problem
    drawn = replace(problem, variables=tuple(replace(variable, start=design.variables[variable.name]) for variable in problem.variables))
    values = drawn.values(found.z)
    press = reshaped(design.press, drawn.pivots(values))
    motion = cycle(press, speed, points=FINER * len(design.motion.time))
    return drawn.at(found.z, _close_design(press, motion, values, design.start.loads))


def _missed_between(found: Point, finer: Point) -> tuple[float, str]:
    """The largest excess of a constraint between the crank angles of trials, as a share of the constraint's size, and as text."""
    worst, words = 0.0, ""
    for requirement, values in zip(found.problem.requirements[1:], finer.values[1:], strict=True):
        for bound, beyond in ((requirement.lower, requirement.lower - values.min()), (requirement.upper, values.max() - requirement.upper)):
            if beyond / requirement.scale > worst:
                worst = float(beyond / requirement.scale)
                words = f"{requirement.title} misses its bound {bound:g} by {beyond:.4g} between the crank angles of the trials"
    return worst, words


def _result(start: Point, found: Point, search: Search, finer: Point) -> SynthesisResult:
    problem, conditions, press = found.problem, optimality(found), found.design.press
    missed, words = _missed_between(found, finer)
    if missed > NOTICED:
        caution(f"{words}: give more points=")
    constraints = {
        requirement.name: float(values[0]) if len(values) == 1 else read_only(values)
        for requirement, values in zip(problem.requirements[1:], found.values[1:], strict=True)
    }
    values = problem.values(found.z)
    rows = [BoundedQuantity(v.name, "variable", v.lower, v.start, values[v.name], v.upper) for v in problem.variables]
    for k, requirement in enumerate(problem.requirements[1:], 1):
        bounds = [bound if math.isfinite(bound) else None for bound in (requirement.lower, requirement.upper)]
        nearest = (_nearest(requirement, point.values[k]) for point in (start, found))
        rows.append(BoundedQuantity(requirement.name, "constraint", bounds[0], next(nearest), next(nearest), bounds[1]))
    return SynthesisResult(
        press=press.with_inertias(list(press.model.inertias), name=press.name.removesuffix(SYNTHESISED) + SYNTHESISED),
        variables=FrozenMapping(values),
        value=found.objective,
        start_value=start.objective,
        constraints=FrozenMapping(constraints),
        active=conditions.active,
        idle=conditions.idle,
        missed=missed,
        finer_value=finer.objective,
        kkt=conditions.residual,
        evaluations=search.evaluations,
        infeasible=search.infeasible,
        _rows=Records(BoundedQuantity, rows),
    )


def _nearest(requirement: Requirement, values: Array) -> float:
    """The element that is nearest to a bound, or furthest outside its bounds."""
    return float(values[np.argmin(np.minimum(values - requirement.lower, requirement.upper - values))])


def _text(found: SynthesisResult) -> str:
    """Objective, variables and constraints with their bounds, active bounds, and the residual of the conditions of the optimum."""
    rows = found.table()
    width = max(12, *(len(row.name) for row in rows)) + 2
    lines = [
        f"{found.press.name}: {found.evaluations} designs judged, {found.infeasible} that could not be assembled",
        "",
        *tables.table([["objective", "", f"{found.start_value:.6g}", f"{found.value:.6g}"]], [width, WIDE]),
    ]
    for kind in ("variable", "constraint"):
        some = [row for row in rows if row.kind == kind]
        if some:
            heads = [f"{kind.capitalize()}s", "lower", "start", "found", "upper"]
            lines += ["", *tables.table([heads], [width + 2, WIDE], indent=""), *tables.table(map(_cells, some), [width, WIDE])]
    lines += ["", "Held by" if found.active else "Held by no bound"]
    lines += [
        f"  {bound.name}, {'value' if bound.side == 'equal' else f'{bound.side} bound'} {bound.bound:.6g}:"
        f" the objective changes by {bound.multiplier:.4g} times the change of the bound"
        for bound in found.active
    ]
    if found.idle:
        lines += [f"Without influence: {', '.join(found.idle)}"]
    rows_of_checks = [
        ["conditions of the optimum", f"{found.kkt:.2g} of the objective"],
        ["objective between crank angles", f"{found.finer_value:.6g}"],
        ["constraints between them missed by", f"{found.missed:.2g} of their size"],
    ]
    checks = tables.table(rows_of_checks, [width + WIDE, 0])
    return "\n".join([*lines, "", "Checks", *checks])


def _cells(row: BoundedQuantity) -> list[str]:
    return [row.name, *("-" if value is None else f"{value:.6g}" for value in (row.lower, row.start, row.value, row.upper))]
