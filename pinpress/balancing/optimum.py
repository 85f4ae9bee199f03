"""Balancing: the counterweights that make shaking forces, torques or bearing forces as small as possible, with the proof that they do; and
what of one measure must be given for another, the balanced presses between the best of either (Pareto curves).

At a given motion all forces are linear in the mass, mass moment and moment of inertia of every link, and range, rms and peak are convex.
So the best counterweights are the optimum of a convex program: it is found without a start, and its dual proves it. (Zhang 2007, 5.5,
searches step by step.)
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..common.arguments import is_number, typed, whole_number
from ..common.conic_program import CONE, InfeasibleError
from ..common.errors import PinpressError, shown
from ..common.quantities import Array
from ..common.results import Tabular
from ..dynamics.harmonics import is_cycle
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..kinematics.motion import Motion, as_prescribed
from ..linkage.linkage import Linkage
from ..loads.link import Load
from .counterweights import Counterweight, OperatingCondition, combined, refuse_unphysical
from .problem import ROUNDING, AddedMass, BalancingProblem, Measure, Target, build_problem
from .program import LARGEST, Design, contradiction, objective_value, solve
from .regions import CounterweightRegion, RegionVariables
from .result import ActiveConstraint, BalancedPress, MeasureChange

NEGLIGIBLE = 1e-5  # of the press's moving mass: a counterweight that is lighter,
TRACE = 1e-9  # and without which measures are worse by less than this of what they were before, is left out
SUFFIX = "_balanced"  # of a balanced press's name
PRICELESS = 1e-7  # of the objective before, for as much again of what is limited: a constraint of that price does not hold it back
INERTIA_ROUNDING = 1e-11  # of a counterweight's mass times the square of its distance: a moment of inertia this small is rounding
ENDLESS = 0.999  # of the most that the program allows: a mass this large grows without end
CONFIRMED = 1e-8  # of the forces before balancing: how well inverse dynamics of the balanced press meets what the program promises


@typed
def balance(
    press: Linkage,
    motion: Motion | Sequence[OperatingCondition],
    *,
    regions: Sequence[CounterweightRegion],
    minimise: Target | Mapping[Target, float],
    limits: Mapping[Target, float] | None = None,
    loads: Sequence[Load] = (),
) -> BalancedPress:
    """Find the best counterweights of a press.

    Of counterweights that are equally good they are the lightest: to save the press's whole moving mass is worth 1e-6 of the objective
    before. Range and peak are those of the motion's states. Between states the forces exceed them by about (pi / states)^2 / 2 of the
    harmonic that they consist of.

    Args:
        press: The press.
        motion: Its motion, or several operating conditions: limits hold in all of them, and for every measure the worst one counts.
        regions: Where counterweights may be.
        minimise: A measure (`Range`, `Rms`, `Peak`) or `AddedMass`; or several with weights, each counting relative to what it is before
            balancing (added mass: to the moving mass). The objective of Zhang 2007, (5-14), is
            ``{Rms("shaking_force", "z"): w1, Range("shaking_force", "z"): w2, Rms("shaking_moment", "y"): w3, ...}``.
        limits: The most of measures and of added mass, in their units. 0 is taken literally.
        loads: Loads on the one motion, as `inverse_dynamics` takes them; operating conditions have their own.

    Raises:
        UnknownNameError: The press has no such link or bearing.
        PinpressError: The regions cannot meet the limits, which are named, and by how much; a counterweight would grow without end; a
            measure is zero before; a region makes no sense.
    """
    conditions = _conditions(motion, loads)
    objective, held = checked_objective(minimise), checked_limits(limits)
    problem = build_problem(press, conditions, regions, [*objective, *held])
    return optimal_press(problem, objective, held, absolute=len(conditions) == 1 and not isinstance(minimise, Mapping))


def _conditions(motion: Motion | Sequence[OperatingCondition], loads: Sequence[Load]) -> tuple[OperatingCondition, ...]:
    if isinstance(motion, Motion):
        return (OperatingCondition(motion, tuple(loads)),)
    if not isinstance(motion, Sequence) or not motion or not all(isinstance(each, OperatingCondition) for each in motion):
        raise PinpressError("motion is neither a motion, as cycle or simulate return, nor a list of OperatingCondition(motion, loads)")
    if loads:
        raise PinpressError("loads goes with one motion: give every OperatingCondition its own, OperatingCondition(motion, loads)")
    return tuple(motion)


def checked_objective(minimise: Target | Mapping[Target, float]) -> dict[Target, float]:
    """The objective as targets with weights above zero.

    Raises:
        PinpressError: It is no measure, or no weight is above zero.
    """
    if not isinstance(minimise, Mapping | Measure | AddedMass):
        raise PinpressError(f"minimise: {shown(minimise)} is no measure: give Range, Rms, Peak or AddedMass()")
    objective = dict(minimise) if isinstance(minimise, Mapping) else {minimise: 1.0}
    _refuse_wrong_numbers("minimise", "weight", objective)
    if not any(objective.values()):
        raise PinpressError("minimise: no weight is above zero, so that all counterweights are as good: give one")
    return {target: float(weight) for target, weight in objective.items() if weight > 0}


def checked_limits(limits: Mapping[Target, float] | None) -> dict[Target, float]:
    """The limits, none where there are none; raises PinpressError for what is no measure, or no finite number from 0."""
    _refuse_wrong_numbers("limits", "limit", limits or {})
    return dict(limits or {})


def _refuse_wrong_numbers(argument: str, what: str, targets: Mapping[Target, float]) -> None:
    for target, number in targets.items():
        if not isinstance(target, Measure | AddedMass):
            raise PinpressError(f"{argument}: {shown(target)} is no measure: give Range, Rms, Peak or AddedMass()")
        if not is_number(number) or number < 0:
            raise PinpressError(
                f"{argument}: the {what} of the {target.words} is {shown(number)}: give a finite number that is not negative"
            )


def optimal_press(
    problem: BalancingProblem, objective: Mapping[Target, float], limits: Mapping[Target, float], absolute: bool
) -> BalancedPress:
    """The press with the best design of a problem, and what inverse dynamics says of it.

    Args:
        problem: The problem, with the signals of all measures.
        objective: Targets with their weights.
        limits: As of `balance`.
        absolute: Whether the value is wanted in the unit of the objective's one measure.

    Raises:
        PinpressError: As `balance`.
    """
    _refuse_nothing(problem, objective)
    try:
        design = solve(problem, objective, limits)
    except InfeasibleError:
        raise PinpressError(contradiction(problem, limits)) from None
    u = _without_traces(problem, objective, limits, design.variables)
    fillings = _fillings(problem, u)
    press = _with_fillings(problem, fillings)
    reactions = _confirmed_reactions(problem, u, press)
    scale = _size_of_one(problem, objective) if absolute else 1.0
    filled = list(zip(problem.regions, fillings, strict=True))
    return BalancedPress(
        original=problem.press,
        press=press,
        conditions=problem.conditions,
        objective=dict(objective),
        limits=dict(limits),
        counterweights=tuple(_counterweight(problem.press, each, filling) for each, filling in filled if filling.mass),
        added_mass=problem.added(u),
        value=scale * objective_value(problem, objective, u),
        unit=next(iter(objective)).unit if absolute else "",
        bound=scale * design.bound,
        residual=design.residual,
        changes=tuple(_changes(problem, [*objective, *limits], reactions)),
        active=tuple(_active(design, scale, [each.region for each, filling in filled if not filling.mass])),
        reactions_before=problem.reactions,
        reactions_after=reactions,
    )


def _refuse_nothing(problem: BalancingProblem, objective: Mapping[Target, float]) -> None:
    """Raise where a measure of the objective is zero before, so that relative to it nothing can be said."""
    for signal in problem.signals:
        before = problem.reactions[signal.condition]
        if signal.measure in objective and not signal.measure.value(before) >= (1 - ROUNDING) * signal.size:
            raise PinpressError(
                f"the {signal.measure.words} of {problem.press.name} is zero before balancing: take it out of minimise, or limit it"
            )


def _without_traces(problem: BalancingProblem, objective: Mapping[Target, float], limits: Mapping[Target, float], best: Array) -> Array:
    """The best variables with zero in regions that are as good as empty: the solver stops where it cannot tell a little from none."""
    u, start = best.copy(), 0
    for each in problem.regions:
        own = slice(start, start + len(each.mass))
        if each.own is None and each.region.mass[0] <= 0 and abs(each.mass @ u[own]) <= NEGLIGIBLE * problem.moving:
            empty = u.copy()
            empty[own] = 0.0
            if _no_worse(problem, objective, limits, empty, u):
                u = empty
        start += len(each.mass)
    return u


def _no_worse(problem: BalancingProblem, objective: Mapping[Target, float], limits: Mapping[Target, float], u: Array, best: Array) -> bool:
    """Whether variables are, but for a trace, as good as the best in the objective and in what is limited."""
    limited = [signal for signal in problem.signals if signal.measure in limits]
    return objective_value(problem, objective, u) <= objective_value(problem, objective, best) + TRACE * sum(objective.values()) and all(
        signal.measure.of(signal.at(u)) <= max(limits[signal.measure] / signal.size, signal.measure.of(signal.at(best))) + TRACE
        for signal in limited
    )


def _fillings(problem: BalancingProblem, u: Array) -> list[pin.Inertia]:
    """The inertia that fills every region, in its joint's frame."""
    ends = np.cumsum([len(each.mass) for each in problem.regions])[:-1]
    fillings = []
    for each, own in zip(problem.regions, np.split(u, ends), strict=True):
        filling = each.filling(own)
        if each.own is not None and filling.mass <= NEGLIGIBLE * problem.moving:
            raise PinpressError(
                f"it would be best to leave {shown(each.region.link)} without mass: give its region a least mass, mass=(least, most)"
            )
        fillings.append(filling)
    if problem.unlimited @ u > ENDLESS * LARGEST * problem.moving:
        unlimited = [(filling.mass, each.region) for filling, each in zip(fillings, problem.regions, strict=True)]
        _, heaviest = max((pair for pair in unlimited if math.isinf(pair[1].mass[1])), key=lambda pair: pair[0])
        raise PinpressError(
            f"counterweights grow beyond {LARGEST:g} times the moving mass, above all in the {heaviest.words}: limit it, mass=(0, most)"
        )
    return fillings


def _with_fillings(problem: BalancingProblem, fillings: Sequence[pin.Inertia]) -> Linkage:
    press = problem.press
    inertias = list(press.model.inertias)
    for each in problem.regions:
        if each.own is not None:
            inertias[each.joint] = pin.Inertia.Zero()
    for each, filling in zip(problem.regions, fillings, strict=True):
        inertias[each.joint] = combined(inertias[each.joint], filling)
    for each in problem.regions:
        refuse_unphysical(press, each.joint, inertias[each.joint])
    return press.with_inertias(inertias, name=press.name.removesuffix(SUFFIX) + SUFFIX)


def _confirmed_reactions(problem: BalancingProblem, u: Array, press: Linkage) -> tuple[Reactions, ...]:
    """Reactions of the balanced press in every condition. Inverse dynamics knows nothing of the program, and must agree with it."""
    _refuse_longer_period(problem.conditions, press)
    reactions = tuple(
        inverse_dynamics(press, as_prescribed(each.motion, press), each.loads, bearings=tuple(before.bearing_force))
        for each, before in zip(problem.conditions, problem.reactions, strict=True)
    )
    for signal in problem.signals:
        series = signal.measure.series(reactions[signal.condition])
        promised, found = signal.at(u), signal.measure.varying(series) / signal.size
        missed = float(np.abs(found - promised).max())
        if not missed <= CONFIRMED * max(1.0, float(np.abs(signal.fixed).max())):
            raise PinpressError(
                f"the {signal.measure.words} of the balanced press is not what was worked out, but {missed:.1e} of what it was beside it:"
                " the masses are out of proportion; bring those of the regions nearer to those of the links"
            )
    return reactions


def _refuse_longer_period(conditions: Sequence[OperatingCondition], press: Linkage) -> None:
    """Raise where a motion is one period of the press before, and a counterweight on a geared shaft that was balanced makes that longer."""
    turns = press.turns_until_back
    if any(is_cycle(each.motion) and each.motion.period_turns != turns for each in conditions):
        after = "never" if turns is None else f"only after {turns} turns"
        raise PinpressError(
            f"with a counterweight on a geared shaft that was balanced {press.name} is back {after}, and the motion is shorter: give one"
            " over as many turns, servo_cycle(press, angle, speed=...), or no region on that shaft"
        )


def _size_of_one(problem: BalancingProblem, objective: Mapping[Target, float]) -> float:
    """What one of the objective means, in the unit of its one measure."""
    (target,) = objective
    return problem.moving if isinstance(target, AddedMass) else next(s.size for s in problem.signals if s.measure == target)


def _changes(problem: BalancingProblem, targets: Sequence[Target], after: Sequence[Reactions]) -> Iterator[MeasureChange]:
    """Changes of the measures among targets, then of all other signals' measures."""
    measures = [target for target in [*targets, *(signal.measure for signal in problem.signals)] if isinstance(target, Measure)]
    for measure in dict.fromkeys(measures):
        for number, (then, now) in enumerate(zip(problem.reactions, after, strict=True)):
            yield MeasureChange(measure, number, measure.value(then), measure.value(now))


def _counterweight(press: Linkage, variables: RegionVariables, filling: pin.Inertia) -> Counterweight:
    link = variables.region.link
    placement = press.model.frames[press.model.getFrameId(link, pin.BODY)].placement
    about = np.mean([axis @ filling.inertia @ axis for axis in press.engine().turning_axes(variables.joint)])
    if abs(about) <= INERTIA_ROUNDING * abs(filling.mass) * (filling.lever @ filling.lever):
        about = 0.0
    x, y, z = placement.actInv(filling.lever)
    return Counterweight(link, float(filling.mass), (float(x), float(y), float(z)), float(about))


def _active(design: Design, scale: float, empty: Sequence[CounterweightRegion]) -> Iterator[ActiveConstraint]:
    """The named constraints whose dual variables are not zero. The shape of a region that stays empty holds nothing back."""
    for rows, prices in zip(design.rows, design.prices, strict=True):
        price = float(prices[0] if rows.kind == CONE else np.abs(prices).sum())
        if not rows.name or price <= PRICELESS or (not rows.unit and any(rows.name.endswith(region.words) for region in empty)):
            continue
        yield ActiveConstraint(rows.name, scale * price / rows.unit if rows.unit else None)


GIVEN = 1e-7  # of a measure before balancing: what is given of its best so that the other can be improved
MOST_POINTS = 10_000  # each an optimisation


@dataclass(frozen=True, eq=False, repr=False)
class TradeOffCurve(Tabular):
    """Balanced presses, none of which is better than another in one measure without being worse in the other.

    Attributes:
        first: The first measure.
        second: The second measure.
        designs: Balanced presses, from the best of the first measure to the best of the second.
        values: (designs, 2) of both measures, in their units.
    """

    first: Target
    second: Target
    designs: tuple[BalancedPress, ...]
    values: Array

    @property
    def title(self) -> str:
        units = self.first.unit, self.second.unit
        ends = " and ".join(f"{self.values[0, k]:.6g} to {self.values[-1, k]:.6g} {unit}" for k, unit in enumerate(units))
        return f"TradeOffCurve of the {self.first.words} and the {self.second.words}: {len(self.designs)} designs, {ends}"

    def columns(self) -> dict[str, Array]:
        """Both measures and the added mass of every design as columns under their names with units."""
        columns = {f"{target.words} [{target.unit}]": self.values[:, k] for k, target in enumerate((self.first, self.second))}
        return columns | {"added mass [kg]": np.array([design.added_mass for design in self.designs])}


@typed
def trade_off(
    press: Linkage,
    motion: Motion,
    *,
    regions: Sequence[CounterweightRegion],
    first: Target,
    second: Target,
    limits: Mapping[Target, float] | None = None,
    loads: Sequence[Load] = (),
    points: int = 13,
) -> TradeOffCurve:
    """Find the curve between the least of one measure and the least of another, each point a proved optimum.

    Between its ends the first measure is minimised under equally spaced limits of the second.

    Args:
        press: The press.
        motion: Its motion.
        regions: Where counterweights may be.
        first: The first measure, or `AddedMass`.
        second: The second measure, or `AddedMass`.
        limits: The most of measures and of added mass along the whole curve, as of `balance`.
        loads: Loads on the press in this motion.
        points: Number of designs, at least 2.

    Raises:
        PinpressError: As `balance`; both measures are the same, or there are fewer than two points.
    """
    _refuse_wrong_measures(first, second)
    points = whole_number("points", points, 2, MOST_POINTS)
    held = checked_limits(limits)
    problem = build_problem(press, (OperatingCondition(motion, tuple(loads)),), regions, [first, second, *held])
    ends = _end(problem, first, second, held), _end(problem, second, first, held)
    between = np.linspace(_value(ends[0], second), _value(ends[1], second), points)[1:-1]
    designs = (ends[0], *(_best(problem, first, second, float(most), held) for most in between), ends[1])
    values = np.array([[_value(design, target) for target in (first, second)] for design in designs])
    return TradeOffCurve(first, second, designs, values)


def _refuse_wrong_measures(first: Target, second: Target) -> None:
    for name, target in (("first", first), ("second", second)):
        if not isinstance(target, Measure | AddedMass):
            raise PinpressError(f"{name}: {shown(target)} is no measure: give Range, Rms, Peak or AddedMass()")
    if first == second:
        raise PinpressError(f"both measures are the {first.words}: give two")


def _end(problem: BalancingProblem, least: Target, other: Target, limits: Mapping[Target, float]) -> BalancedPress:
    """The best design in one measure, and of all such the best in the other; of no added mass there is but one."""
    design = _best(problem, least, other, math.inf, limits)
    if isinstance(least, AddedMass):
        return design
    return _best(problem, other, least, design.value + GIVEN * least.value(problem.reactions[0]), limits)


def _best(problem: BalancingProblem, target: Target, other: Target, most: float, limits: Mapping[Target, float]) -> BalancedPress:
    """The best design in one measure with at most this of the other."""
    tighter = {**limits, other: min(most, limits.get(other, math.inf))} if most < math.inf else limits
    return optimal_press(problem, {target: 1.0}, tighter, absolute=True)


def _value(design: BalancedPress, target: Target) -> float:
    if isinstance(target, AddedMass):
        return design.added_mass
    return next(change.after for change in design.changes if change.measure == target)
