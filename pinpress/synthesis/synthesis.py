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
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..common import tables
from ..common.arguments import any_numbers, suitable_numbers, typed
from ..common.errors import AssemblyError, PinpressError, SingularityError, UnknownNameError, caution, shown
from ..common.files import path_of
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
from .problem import Function, Point, Problem, Requirement, Variable, listed, verify_gradients
from .search import ActiveBound, Search, optimality
from .table_variables import TableVariables

SYNTHESISED = "_synthesised"  # end of the name of the resulting press
UNCONSTRAINED: Mapping[str, Any] = FrozenMapping({})


@typed
def synthesise(
    press: Linkage | str | os.PathLike[str],
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
        press: a planar press, or the file of a pin table. It keeps all lengths that no variable changes.
        variables: name -> (lower bound, start, upper bound) [SI]. Of a table: its parameters, and the plain numbers of its pins, named
            pins.PIN.KEY, e.g. "pins.B.length", in the table's units and in degrees.
        minimise: function of a `Trial` that returns a number, or an array (m,) whose largest element is minimised.
        subject_to: name -> (function of a `Trial`, lower bound, upper bound). None or infinity means no bound, and equal bounds mean an
            equation. If the function returns an array, every element keeps the bounds.
        geometry: function of the variables, with their names as arguments, that returns pivots as for `reshaped`, written with NumPy's
            functions. Write design rules here. None: variables are single coordinates, named bearing.link.axis, e.g. "B.crank.x", or
            numbers of the table, whose formulas are the design rules.
        speed: speed of the crank [rad/s].
        points: number of crank angles of the period at which trials are evaluated; None: 360 a turn.
        method: "local" for the optimum next to the start, "global" for the best of the optima next to many starts within the bounds.
        loads: constant forces, and process loads with a datum.
        seed: seed of the random starts of a global search.

    Returns:
        The resulting press, with the bounds that are active at the optimum.

    Raises:
        PinpressError: the linkage is not planar, an argument is not as described, the start cannot be assembled or its crank does not turn
            fully, a function fails or has a wrong gradient, no design keeps the constraints, or the search does not converge; a variable
            of a table changes nothing, or turns the crank in the drawn pose, from which crank angles count.
        UnknownNameError: the linkage does not have a bearing or link with this name, or the table no such number.
        PinTableError: the file is no pin table, or makes no press with the values at the start.
    """
    problem = state_problem(press, variables, minimise, subject_to, geometry)
    refuse_unknown(loads)
    if not isinstance(method, str) or method not in ("local", "global"):
        raise PinpressError(f"method is {shown(method)}: write 'local' or 'global'")
    start = _start(press, problem, speed, points, loads)
    verify_gradients(start, [np.random.default_rng(0).uniform(0.5, 1.0, len(problem.variables))])
    search = Search(start.problem)
    return _result(start, search, search.local(start) if method == "local" else search.best(start, seed), speed, points)


def local_optimum(press: Any, problem: Problem, speed: float, points: int | None, loads: Sequence[Load]) -> SynthesisResult:
    """The optimum next to the start of a problem whose gradients are already checked. Raises as `synthesise`."""
    start = _start(press, problem, speed, points, loads)
    search = Search(start.problem)
    return _result(start, search, search.local(start), speed, points)


@dataclass(frozen=True, eq=False, repr=False)
class SynthesisResult(Tabular):
    """The optimum of a synthesis.

    Attributes:
        press: the linkage with the optimal lengths, as from `reshaped`, or built from ``pin_table``.
        pin_table: text of the pin table with the values that were found, to 12 digits; None if no table was given.
        variables: name -> value of each variable [SI, or as in the table].
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
    pin_table: str | None
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
        return f"SynthesisResult of {self.press.name}: {self.start_value:.6g} to {self.value:.6g} with {listed(self.variables)}"

    def __str__(self) -> str:
        """Objective, variables and constraints with their bounds, active bounds, and checks."""
        width, number = max(12, *(len(row.name) for row in self._rows)) + 2, 14
        lines = [
            f"{self.press.name}: {self.evaluations} designs judged, {self.infeasible} that could not be assembled",
            "",
            *tables.table([["objective", "", f"{self.start_value:.6g}", f"{self.value:.6g}"]], [width, number]),
        ]
        for kind in ("variable", "constraint"):
            rows = [row for row in self._rows if row.kind == kind]
            if rows:
                heads = [f"{kind.capitalize()}s", "lower", "start", "found", "upper"]
                lines += ["", *tables.table([heads], [width + 2, number], indent=""), *tables.table(map(_cells, rows), [width, number])]
        lines += ["", "Held by" if self.active else "Held by no bound"]
        lines += [
            f"  {bound.name}, {'value' if bound.side == 'equal' else f'{bound.side} bound'} {bound.bound:.6g}:"
            f" the objective changes by {bound.multiplier:.4g} times the change of the bound"
            for bound in self.active
        ]
        if self.idle:
            lines += [f"Without influence: {', '.join(self.idle)}"]
        checks = [
            ["conditions of the optimum", f"{self.kkt:.2g} of the objective"],
            ["objective between crank angles", f"{self.finer_value:.6g}"],
            ["constraints between them missed by", f"{self.missed:.2g} of their size"],
        ]
        return "\n".join([*lines, "", "Checks", *tables.table(checks, [max(width + number, 36), 0])])

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


def state_problem(press: Any, variables: Any, minimise: Any, subject_to: Any, geometry: Any) -> Problem:
    """The problem of checked arguments, with requirements that are not yet scaled."""
    if isinstance(press, Linkage):
        _refuse(press)
    else:
        path_of("press", press)
    for name, mapping in (("variables", variables), ("subject_to", subject_to)):
        if not isinstance(mapping, Mapping):
            raise PinpressError(f"{name} is a {type(mapping).__name__}: give a mapping from names")
    if geometry is not None and not callable(geometry):
        raise PinpressError(f"geometry is a {type(geometry).__name__}: give a function of the variables that returns pivots")
    checked = tuple(_variable(name, bounds) for name, bounds in variables.items())
    if not checked:
        raise PinpressError("variables is empty: give {name: (lower bound, start, upper bound)}")
    requirements = (Requirement("", minimise), *(_constraint(name, constraint) for name, constraint in subject_to.items()))
    if isinstance(press, Linkage):
        return Problem(checked, geometry or _coordinates(press, tuple(variables)), requirements)
    if geometry is not None:
        raise PinpressError(
            "geometry is given with a pin table, whose formulas are design rules: leave geometry out, or give the table's press"
        )
    table = TableVariables.of(press, {each.name: (each.start, each.range) for each in checked})
    return Problem(checked, table.pivots, requirements, table)


def _refuse(press: Linkage) -> None:
    """Refuse a press that a synthesis cannot move."""
    planar(press)
    press.refuse_joint_springs("a synthesis does not know them; take them out of the file")


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
        pivots: dict[tuple[str, str], Any] = {}
        for name, value in values.items():
            pivot, axis = coordinates[name]
            pivots.setdefault(pivot, list(positions[pivot]))[axis] = value
        return pivots

    return geometry


def _start(press: Any, problem: Problem, speed: float, points: int | None, loads: Sequence[Load]) -> Point:
    """The start, with requirements scaled by their size there.

    Raises:
        PinpressError: the start cannot be assembled, or locks.
    """
    values = {variable.name: variable.start for variable in problem.variables}
    if problem.table is not None:
        press = problem.table.press(values)
        _refuse(press)
    try:
        drawn = reshaped(press, problem.pivots(values))
        motion = cycle(drawn, speed, points=points)
    except (AssemblyError, SingularityError) as error:
        raise PinpressError(f"the start, {listed(values)}, is not a valid press: {error}; start elsewhere") from error
    design = _close_design(drawn, motion, values, loads, problem.table)
    point = problem.at(problem.scaled(values), design)
    scaled = tuple(replace(part, scale=_size(part, at_start)) for part, at_start in zip(problem.requirements, point.values, strict=True))
    return replace(problem, requirements=scaled).at(point.z, design)


def _close_design(drawn: Linkage, motion: Motion, values: dict[str, float], loads: Sequence[Load], table: TableVariables | None) -> Design:
    """The design of a drawn press, closed at the crank angles of a motion."""
    plane = planar(drawn)
    closure = drawn.engine().close(motion.crank_angle, motion.joint_position.T)
    state = closure.position, closure.first, closure.second, closure.gap
    return Design(Start(drawn, plane, motion, loads, table), values, nowhere(drawn), [], plane, *state)


def _size(requirement: Requirement, values: Array) -> float:
    """The largest size of its values and bounds, which scales a requirement."""
    bounds = [abs(bound) for bound in (requirement.lower, requirement.upper) if math.isfinite(bound)]
    return max(float(np.abs(values).max()), *bounds, 0.0) or 1.0


def _finer(optimum: Point, speed: float) -> Point:
    """The resulting design, with eight times the crank angles.

    Raises:
        PinpressError: the design locks between the crank angles of its trial, or a function fails.
    """
    design, problem = optimum.design, optimum.problem
    values = problem.values(optimum.z)
    press = reshaped(design.press, problem.pivots(values))
    motion = cycle(press, speed, points=8 * len(design.motion.time))
    return problem.at(optimum.z, _close_design(press, motion, values, design.start.loads, problem.table))


def _missed_between(finer: Point) -> float:
    """The largest excess of a constraint between the crank angles of trials, as a share of the constraint's size; cautions above 1e-3."""
    worst, words = 0.0, ""
    for requirement, values in zip(finer.problem.requirements[1:], finer.values[1:], strict=True):
        for bound, beyond in ((requirement.lower, requirement.lower - values.min()), (requirement.upper, values.max() - requirement.upper)):
            if beyond / requirement.scale > worst:
                worst = float(beyond / requirement.scale)
                words = f"{requirement.title} misses its bound {bound:g} by {beyond:.4g} between the crank angles of the trials"
    if worst > 1e-3:
        caution(f"{words}: give more points=")
    return worst


def _result(start: Point, search: Search, optimum: Point, speed: float, points: int | None) -> SynthesisResult:
    """The result of a search.

    Raises:
        PinpressError: the resulting press moves in another way than its trial, because it locks between two points; or as `_finer`.
    """
    problem, conditions, press = optimum.problem, optimality(optimum), optimum.design.press
    motion, trial = period_at(press, speed, points), optimum.design.motion
    if not np.abs(motion.joint_position - trial.joint_position).max() <= 1e-9 * (1 + optimum.design.plane.size):
        raise PinpressError("the resulting press moves in another assembly than its drawn pose: give narrower bounds of the variables")
    finer, values = _finer(optimum, speed), problem.values(optimum.z)
    rows = [BoundedQuantity(v.name, "variable", v.lower, v.start, values[v.name], v.upper) for v in problem.variables]
    constraints: dict[str, float | Array] = {}
    for requirement, *at_ends in zip(problem.requirements[1:], start.values[1:], optimum.values[1:], strict=True):
        lower, upper = (bound if math.isfinite(bound) else None for bound in (requirement.lower, requirement.upper))
        nearest = [_nearest(requirement, elements) for elements in at_ends]
        rows.append(BoundedQuantity(requirement.name, "constraint", lower, nearest[0], nearest[1], upper))
        constraints[requirement.name] = float(at_ends[1][0]) if len(at_ends[1]) == 1 else read_only(at_ends[1])
    if problem.table is not None:
        press = _built(problem.table, values, trial, speed, points)
    else:
        press = press.with_inertias(list(press.model.inertias), name=press.name.removesuffix(SYNTHESISED) + SYNTHESISED)
    return SynthesisResult(
        press=press,
        pin_table=None if problem.table is None else problem.table.text(values),
        variables=FrozenMapping(values),
        value=optimum.objective,
        start_value=start.objective,
        constraints=FrozenMapping(constraints),
        active=conditions.active,
        idle=conditions.idle,
        missed=_missed_between(finer),
        finer_value=finer.objective,
        kkt=conditions.residual,
        evaluations=search.evaluations,
        infeasible=search.infeasible,
        _rows=Records(BoundedQuantity, rows),
    )


def _built(table: TableVariables, values: Mapping[str, float], trial: Motion, speed: float, points: int | None) -> Linkage:
    """The press of a table with the values that were found; raises PinpressError if it moves in another way than its trial."""
    press = table.press(values)
    gone, expected = (each.joint_position - each.joint_position[0] for each in (period_at(press, speed, points), trial))
    if gone.shape != expected.shape or not np.abs(gone - expected).max() <= 1e-9 * (1 + press.size):
        raise PinpressError(f"the table with {listed(values)} moves in another way than its trial: give narrower bounds of the variables")
    return press


def _nearest(requirement: Requirement, values: Array) -> float:
    """The element that is nearest to a bound, or furthest outside its bounds."""
    return float(values[np.argmin(np.minimum(values - requirement.lower, requirement.upper - values))])


def _cells(row: BoundedQuantity) -> list[str]:
    return [row.name, *("-" if value is None else f"{value:.6g}" for value in (row.lower, row.start, row.value, row.upper))]
