"""Balancing: counterweights that minimise shaking forces, torques or bearing forces, with a proof, and trade-offs between two criteria.

At a given motion all forces are linear in the mass, mass moment and moment of inertia of every link. Range, rms and peak are convex. So the
best counterweights are the optimum of a convex program, which needs no starting values. Its dual proves the optimum. (Zhang 2007, 5.5,
searches step by step.)
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ..common.arguments import suitable_numbers, typed, whole_number
from ..common.conic_program import CONE, InfeasibleError
from ..common.errors import PinpressError, shown
from ..common.frozen import read_only
from ..common.quantities import Array
from ..common.results import Records, Tabular
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.motion import Motion, as_prescribed, is_cycle
from ..linkage.linkage import Linkage
from ..loads.link import Load
from .counterweights import Counterweight, OperatingCondition, combine_inertias, refuse_unphysical
from .problem import ROUNDING, AddedMass, BalancingProblem, Criterion, Target, build_problem
from .program import LARGEST, ProvenOptimum, infeasible_limits, objective_value, solve
from .regions import CounterweightRegion, RegionVariables
from .result import ActiveConstraint, BalancedPress, CriterionChange

NEGLIGIBLE = 1e-5  # counterweights below this share of the moving mass are left out, if no criterion grows
SUFFIX = "_balanced"  # end of a balanced press's name


@typed
def balance(
    press: Linkage,
    motion: Motion | Sequence[OperatingCondition],
    *,
    regions: Sequence[CounterweightRegion],
    minimise: Target | Mapping[Target, float],
    limits: Mapping[Target, float] | None = None,
    loads: Sequence[Load] = (),
    shares: Sequence[float] | None = None,
) -> BalancedPress:
    """Find the best counterweights of a press, for one motion or for all its dies, strokes and speeds at once.

    Of equally good counterweights the result has the lightest: saving the whole moving mass of the press counts as 1e-6 of the objective
    before balancing. An adjustable counterweight is the best for every operating condition, not only for the worst: the mean over all
    conditions counts as 1e-5, in addition to the worst value.

    Ranges and peaks are those of the motion's states. Between two states a harmonic of order k may exceed them by up to about
    (pi k / states)^2 / 2 of its amplitude.

    Args:
        press: the press.
        motion: a motion of the press, or several operating conditions (`OperatingCondition`), each with its speed, loads, die and stroke.
            Limits hold in all conditions; a criterion counts with its worst value.
        regions: where counterweights may be. Regions with ``reset`` are adjusted in every operating condition; other regions are the same
            in all conditions.
        minimise: a criterion (`Range`, `Rms`, `Peak`), `AddedMass`, or several of them -> weight, relative to the largest value before
            balancing (added mass: to the moving mass) [-]. The objective of Zhang 2007, (5-14), is
            ``{Rms("shaking_force", "z"): w1, Range("shaking_force", "z"): w2, Rms("shaking_moment", "y"): w3, ...}``.
        limits: criterion or `AddedMass` -> largest permitted value, in its unit. A limit of 0 is met exactly.
        loads: loads on the one motion, as in `inverse_dynamics`; operating conditions have separate loads.
        shares: (conditions,) weights of the operating conditions [-], such as each die's share of all strokes. With weights the weighted
            mean of a criterion counts instead of its worst value.

    Raises:
        UnknownNameError: the press does not have a link or bearing with this name.
        PinpressError: an operating condition has a press with other links or bearings, the limits cannot be met together (the message names
            the limits and the shortfall), a counterweight would grow without limit, a minimised criterion is zero before balancing, or an
            argument is not as described.
    """
    conditions = _conditions(motion, loads)
    objective, checked = _checked_objective(minimise), _checked_limits(limits)
    weights = None
    if shares is not None:
        words = f"{len(conditions)} numbers that are not negative, one for each operating condition, and not all zero"
        weights = suitable_numbers("shares", shares, words, (len(conditions),), lambda given: (given >= 0).all() and given.any())
        weights = weights / weights.sum()
    problem = build_problem(press, conditions, regions, [*objective, *checked], weights)
    return _optimal_press(problem, objective, checked, absolute=not isinstance(minimise, Mapping))


@dataclass(frozen=True, eq=False, repr=False)
class TradeOffCurve(Tabular):
    """Balanced presses on the Pareto curve of two criteria: a design that is better in one criterion is worse in the other.

    Attributes:
        first: the first criterion.
        second: the second criterion.
        designs: balanced presses, from the best in the first criterion to the best in the second.
        values: (designs, 2) values of both criteria in the worst operating condition [units of the criteria].
        bounds: (designs,) proven lower bounds of the first criterion, for all counterweights in these regions that are not worse in the
            second criterion than the design [unit of the first criterion].
    """

    first: Target
    second: Target
    designs: tuple[BalancedPress, ...]
    values: Array
    bounds: Array

    @property
    def title(self) -> str:
        units = self.first.unit, self.second.unit
        ends = " and ".join(f"{self.values[0, k]:.6g} to {self.values[-1, k]:.6g} {unit}" for k, unit in enumerate(units))
        return f"TradeOffCurve of the {self.first.words} and the {self.second.words}: {len(self.designs)} designs, {ends}"

    def columns(self) -> dict[str, Array]:
        """A row for each design: both criteria, the proven bound of the first, and the added mass."""
        columns = {f"{target.words} [{target.unit}]": self.values[:, k] for k, target in enumerate((self.first, self.second))}
        columns[f"bound of the {self.first.words} [{self.first.unit}]"] = self.bounds
        return columns | {"added mass [kg]": np.array([design.added_mass for design in self.designs])}


@typed
def trade_off(
    press: Linkage,
    motion: Motion | Sequence[OperatingCondition],
    *,
    regions: Sequence[CounterweightRegion],
    first: Target,
    second: Target,
    limits: Mapping[Target, float] | None = None,
    loads: Sequence[Load] = (),
    points: int = 13,
) -> TradeOffCurve:
    """Find the trade-off between two criteria (their Pareto curve), from the least of one to the least of the other.

    Each point is a proved optimum. Between the ends the first criterion is minimised under equally spaced limits of the second criterion.

    Args:
        press: the press.
        motion: a motion of the press, or several operating conditions, as in `balance`. A criterion counts with its worst value.
        regions: where counterweights may be.
        first: the first criterion, or `AddedMass`.
        second: the second criterion, or `AddedMass`.
        limits: largest values of criteria and of added mass on the whole curve, as in `balance`.
        loads: loads on the one motion; operating conditions have separate loads.
        points: number of designs, 2 to 10 000.

    Raises:
        UnknownNameError: the press does not have a link or bearing with this name.
        PinpressError: both criteria are equal, ``points`` is out of range, or as `balance`.
    """
    for name, target in (("first", first), ("second", second)):
        _refuse_other_kinds(name, target)
    if first == second:
        raise PinpressError(f"both criteria are the {first.words}: give two different criteria")
    points = whole_number("points", points, 2, 10_000)
    checked = _checked_limits(limits)
    problem = build_problem(press, _conditions(motion, loads), regions, [first, second, *checked])
    (least, start), (_, end) = _end(problem, first, second, checked), _end(problem, second, first, checked)
    between = np.linspace(_value(start, second), _value(end, second), points)[1:-1]
    designs = (start, *(_best(problem, first, second, float(most), checked) for most in between), end)
    values = np.array([[_value(design, target) for target in (first, second)] for design in designs])
    bounds = np.array([least.bound, *(design.bound for design in designs[1:])])
    if next(iter(end.objective)) != first:  # the press as it is
        bounds[-1] = values[-1, 0]
    return TradeOffCurve(first, second, designs, read_only(values), read_only(bounds))


def _conditions(motion: Motion | Sequence[OperatingCondition], loads: Sequence[Load]) -> tuple[OperatingCondition, ...]:
    if isinstance(motion, Motion):
        return (OperatingCondition(motion, tuple(loads)),)
    if not isinstance(motion, Sequence) or not motion or not all(isinstance(given, OperatingCondition) for given in motion):
        raise PinpressError("motion is not a motion: give a motion of cycle or simulate, or a list of OperatingCondition(motion, loads)")
    if loads:
        raise PinpressError("loads needs one motion: give loads to every OperatingCondition instead, OperatingCondition(motion, loads)")
    return tuple(motion)


def _checked_objective(minimise: Target | Mapping[Target, float]) -> dict[Target, float]:
    """The objective as targets with weights above zero."""
    if not isinstance(minimise, Mapping):
        _refuse_other_kinds("minimise", minimise)
    objective = dict(minimise) if isinstance(minimise, Mapping) else {minimise: 1.0}
    _refuse_wrong_numbers("minimise", "weight", objective)
    if not any(objective.values()):
        raise PinpressError("minimise: no weight is above zero, so all counterweights are equally good: give a positive weight")
    return {target: float(weight) for target, weight in objective.items() if weight > 0}


def _checked_limits(limits: Mapping[Target, float] | None) -> dict[Target, float]:
    _refuse_wrong_numbers("limits", "limit", limits or {})
    return dict(limits or {})


def _refuse_wrong_numbers(argument: str, what: str, targets: Mapping[Target, float]) -> None:
    for target, number in targets.items():
        _refuse_other_kinds(argument, target)
        name = f"{argument}: the {what} of the {target.words}"
        suitable_numbers(name, number, "a finite number that is not negative", suits=lambda value: value >= 0)


def _refuse_other_kinds(argument: str, target: object) -> None:
    if not isinstance(target, Criterion | AddedMass):
        raise PinpressError(f"{argument}: {shown(target)} is not a criterion: give Range, Rms, Peak or AddedMass()")


def _optimal_press(
    problem: BalancingProblem, objective: Mapping[Target, float], limits: Mapping[Target, float], absolute: bool
) -> BalancedPress:
    """Solve a problem, build the balanced press, and confirm it by inverse dynamics. Raises as `balance`.

    ``absolute``: whether the value has the unit of the objective's only criterion.
    """
    sizes = {signal.criterion: signal.size for signal in problem.signals}
    for criterion in (target for target in objective if isinstance(target, Criterion)):
        if not max(criterion.value(before) for before in problem.reactions) >= (1 - ROUNDING) * sizes[criterion]:
            raise PinpressError(
                f"the {criterion.words} of {problem.press.name} is zero before balancing: limit it instead of minimising it, or leave it"
                " out"
            )
    try:
        design = solve(problem, objective, limits)
    except InfeasibleError:
        raise PinpressError(infeasible_limits(problem, limits)) from None
    u = _without_traces(problem, objective, limits, design.variables)
    fillings = _fillings(problem, u)
    presses = tuple(
        _fit_counterweights(condition.set_up(problem.press), regions, filled)
        for condition, regions, filled in zip(problem.conditions, problem.regions, fillings, strict=True)
    )
    reactions = _confirmed_reactions(problem, u, presses)
    target = next(iter(objective))
    scale = (problem.moving_mass if isinstance(target, AddedMass) else sizes[target]) if absolute else 1.0
    settings = tuple(
        Records(
            Counterweight,
            (_counterweight(problem.press, variables, filling) for variables, filling in zip(regions, filled, strict=True) if filling.mass),
        )
        for regions, filled in zip(problem.regions, fillings, strict=True)
    )
    empty = [region.region for region, *filled in zip(problem.regions[0], *fillings, strict=True) if not any(f.mass for f in filled)]
    return BalancedPress(
        original=problem.press,
        press=presses[0] if problem.conditions[0].press is None else _fit_counterweights(problem.press, problem.regions[0], fillings[0]),
        presses=presses,
        conditions=problem.conditions,
        objective=dict(objective),
        limits=dict(limits),
        shares=problem.shares,
        counterweights=settings[0],
        settings=settings,
        added_mass=problem.added_mass(u),
        value=scale * objective_value(problem, objective, u),
        unit=target.unit if absolute else "",
        bound=scale * design.bound,
        residual=design.residual,
        changes=Records(CriterionChange, _changes(problem, [*objective, *limits], reactions)),
        active=Records(ActiveConstraint, _active(design, scale, empty)),
        reactions_before=problem.reactions,
        reactions_after=reactions,
    )


def _without_traces(problem: BalancingProblem, objective: Mapping[Target, float], limits: Mapping[Target, float], best: Array) -> Array:
    """The best variables, with zeros in regions that are almost empty, because the solver leaves traces of mass in empty regions."""
    u = best.copy()
    for region, columns in _by_setting(problem):
        masses = [float(region.mass @ u[part]) for part in columns]
        if region.replaced is None and region.region.mass[0] <= 0 and max(map(abs, masses)) <= NEGLIGIBLE * problem.moving_mass:
            empty = u.copy()
            empty[np.concatenate(columns)] = 0.0
            if _no_worse(problem, objective, limits, empty, u):
                u = empty
    return u


def _by_setting(problem: BalancingProblem) -> Iterator[tuple[RegionVariables, list[NDArray[np.intp]]]]:
    """Each region with groups of columns that become zero together: all conditions of a mass that only moves are one group."""
    in_conditions = [[columns for columns, _ in problem.parts(number)] for number in range(len(problem.conditions))]
    for k, region in enumerate(problem.regions[0]):
        columns = [parts[k] for parts in in_conditions]
        if region.region.reset == "mass":
            yield from ((region, [setting]) for setting in columns)
        else:
            yield region, columns if region.region.reset else columns[:1]


def _no_worse(problem: BalancingProblem, objective: Mapping[Target, float], limits: Mapping[Target, float], u: Array, best: Array) -> bool:
    """Whether variables are as good as the best ones in the objective and in all limited criteria, within 1e-9 of before balancing."""
    limited = [signal for signal in problem.signals if signal.criterion in limits]
    return objective_value(problem, objective, u) <= objective_value(problem, objective, best) + 1e-9 * sum(objective.values()) and all(
        signal.criterion.of(signal.at(u)) <= max(limits[signal.criterion] / signal.size, signal.criterion.of(signal.at(best))) + 1e-9
        for signal in limited
    )


def _fillings(problem: BalancingProblem, u: Array) -> list[list[pin.Inertia]]:
    """The inertia of the counterweight in each region, in its joint's frame, for every operating condition.

    Raises:
        PinpressError: a link whose own mass is replaced would have no mass, or counterweights grow without limit.
    """
    fillings = [[region.filling(u[columns]) for columns, region in problem.parts(number)] for number in range(len(problem.conditions))]
    masses = [(region, [filling.mass for filling in filled]) for region, *filled in zip(problem.regions[0], *fillings, strict=True)]
    for region, filled in masses:
        if region.replaced is not None and min(filled) <= NEGLIGIBLE * problem.moving_mass:
            link = shown(region.region.link)
            raise PinpressError(f"the best mass of link {link} is zero: give its region a least mass, mass=(least, most)")
    if (problem.unlimited @ u).max() > 0.999 * LARGEST * problem.moving_mass:
        unlimited = [(region, filled) for region, filled in masses if math.isinf(region.region.mass[1])]
        heaviest, _ = max(unlimited, key=lambda pair: max(pair[1]))
        words = f"mostly in the {heaviest.region.words}: limit its mass, mass=(0, most)"
        raise PinpressError(f"counterweights grow beyond {LARGEST:g} times the moving mass, {words}")
    return fillings


def _fit_counterweights(press: Linkage, regions: Sequence[RegionVariables], fillings: Sequence[pin.Inertia]) -> Linkage:
    """The press with the counterweights of all regions; a region with ``replaces`` replaces the link's own mass."""
    inertias = list(press.model.inertias)
    for region in regions:
        if region.replaced is not None:
            inertias[region.joint] = pin.Inertia.Zero()
    for region, filling in zip(regions, fillings, strict=True):
        inertias[region.joint] = combine_inertias(inertias[region.joint], filling)
    for region in regions:
        refuse_unphysical(press, region.joint, inertias[region.joint])
    return press.with_inertias(inertias, name=press.name.removesuffix(SUFFIX) + SUFFIX)


def _confirmed_reactions(problem: BalancingProblem, u: Array, presses: Sequence[Linkage]) -> tuple[Reactions, ...]:
    """Reactions of the balanced press in every operating condition.

    Inverse dynamics is independent of the program, and must agree with the program.

    Raises:
        PinpressError: both disagree, or a motion is shorter than the period of the balanced press.
    """
    for condition, press in zip(problem.conditions, presses, strict=True):
        _refuse_longer_period(condition, press)
    reactions = tuple(
        inverse_dynamics(press, as_prescribed(condition.motion, press), condition.loads, bearings=tuple(before.bearing_force))
        for press, condition, before in zip(presses, problem.conditions, problem.reactions, strict=True)
    )
    for signal in problem.signals:
        series = signal.criterion.series(reactions[signal.condition])
        promised, computed = signal.at(u), signal.criterion.varying(series) / signal.size
        missed = float(np.abs(computed - promised).max())
        if not missed <= 1e-8 * max(1.0, float(np.abs(signal.fixed).max())):
            raise PinpressError(
                f"the {signal.criterion.words} of the balanced press differs from the optimiser's by {missed:.1e} of its value before:"
                " masses differ too much in size; give regions masses closer to those of the links"
            )
    return reactions


def _refuse_longer_period(condition: OperatingCondition, press: Linkage) -> None:
    """Raise if a motion is one period of the original press, but a counterweight on a geared shaft makes the period longer."""
    turns = press.turns_until_back
    if is_cycle(condition.motion) and condition.motion.period_turns != turns:
        after = "never" if turns is None else f"only after {turns} turns"
        raise PinpressError(
            f"with a counterweight on a geared shaft {press.name} repeats itself {after}, but the motion is shorter: give a motion over"
            " all these turns, servo_cycle(press, angle, speed=...), or no region on that shaft"
        )


def _changes(problem: BalancingProblem, targets: Sequence[Target], after: Sequence[Reactions]) -> Iterator[CriterionChange]:
    """Changes of the criteria among targets, then of the criteria of all other signals."""
    criteria = [target for target in [*targets, *(signal.criterion for signal in problem.signals)] if isinstance(target, Criterion)]
    for criterion in dict.fromkeys(criteria):
        for number, (then, now) in enumerate(zip(problem.reactions, after, strict=True)):
            yield CriterionChange(criterion, number, criterion.value(then), criterion.value(now))


def _counterweight(press: Linkage, variables: RegionVariables, filling: pin.Inertia) -> Counterweight:
    """The counterweight in a region, in the link's own frame, from its inertia in the joint's frame."""
    link = variables.region.link
    about = np.mean([axis @ filling.inertia @ axis for axis in press.engine().turning_axes(variables.joint)])
    if abs(about) <= 1e-11 * abs(filling.mass) * (filling.lever @ filling.lever):  # rounding error of a point mass
        about = 0.0
    x, y, z = press.frame_of(link).placement.actInv(filling.lever)
    return Counterweight(link, float(filling.mass), (float(x), float(y), float(z)), float(about))


def _active(design: ProvenOptimum, scale: float, empty: Sequence[CounterweightRegion]) -> Iterator[ActiveConstraint]:
    """The named constraints whose relaxation by the whole limited quantity lowers the objective by 1e-7 of before balancing, or more.

    The shapes of empty regions (``empty``) are left out.
    """
    for rows, prices in zip(design.rows, design.prices, strict=True):
        price = float(prices[0] if rows.kind == CONE else np.abs(prices).sum())
        if not rows.name or price <= 1e-7 or (not rows.unit and any(region.words in rows.name for region in empty)):
            continue
        yield ActiveConstraint(rows.name, scale * price / rows.unit if rows.unit else None)


def _end(problem: BalancingProblem, least: Target, other: Target, limits: Mapping[Target, float]) -> tuple[BalancedPress, BalancedPress]:
    """The best press in one criterion, and the best in the other criterion of the presses that are worse by at most 1e-7 of before.

    Only one press has no added mass.
    """
    design = _best(problem, least, other, math.inf, limits)
    if isinstance(least, AddedMass) and not design.counterweights and not problem.replaced_mass:
        return design, design
    size = problem.moving_mass if isinstance(least, AddedMass) else max(least.value(before) for before in problem.reactions)
    return design, _best(problem, other, least, design.value + 1e-7 * size, limits)


def _best(problem: BalancingProblem, target: Target, other: Target, most: float, limits: Mapping[Target, float]) -> BalancedPress:
    """The best press in one criterion with at most ``most`` of the other."""
    tighter = {**limits, other: min(most, limits.get(other, math.inf))} if most < math.inf else limits
    return _optimal_press(problem, {target: 1.0}, tighter, absolute=True)


def _value(design: BalancedPress, target: Target) -> float:
    """The value of a target after balancing, in its worst operating condition, in its unit."""
    if isinstance(target, AddedMass):
        return design.added_mass
    return max(change.after for change in design.changes if change.criterion == target)
