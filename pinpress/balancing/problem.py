"""What balancing knows of a press: regions as variables, and measures as series that are linear in the variables, all about one in size."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..common.arrays import Array
from ..common.conic_program import Rows
from ..common.errors import PinpressError, shown
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..linkage.linkage import Linkage
from .mass_response import MassResponse, OperatingCondition, mass_response, moving_mass
from .objectives import Forces, Measure, Target, refuse_unknown
from .regions import CounterweightRegion, RegionVariables, points_of, region_variables

ROUNDING = 1e-11  # of what the regions could do to a measure: a measure this small is zero
NOISE = 1e-12  # of the forces that a measure is a component of: a measure this small is rounding


@dataclass(frozen=True, eq=False, repr=False)
class Signal:
    """The series of a measure in one operating condition, in units of its size: ``fixed + effects @ u`` for variables u.

    Attributes:
        measure: The measure.
        condition: Number of the operating condition.
        size: What one of the series means, in the measure's unit.
        fixed: (n, components) series without counterweights; `Measure.varying`.
        effects: (n, components, variables) change by one of each variable; `Measure.varying`.
    """

    measure: Measure
    condition: int
    size: float
    fixed: Array
    effects: Array

    def at(self, u: Array) -> Array:
        """The series (n, components) at values (variables,)."""
        return np.asarray(self.fixed + self.effects @ u)


@dataclass(frozen=True, eq=False, repr=False)
class BalancingProblem:
    """A press in its operating conditions, and all that may be asked of some regions.

    Attributes:
        press: The press before balancing.
        conditions: Operating conditions.
        reactions: Reactions of the press in every condition, with the bearings that are measured.
        regions: Regions, whose variables stand one after the other.
        rows: Constraints of the regions on all variables.
        signals: Signals of all measures in all conditions.
        mass: (variables,) mass of one of each [kg].
        own: Mass that regions take off links [kg].
        moving: Moving mass of the press [kg].
    """

    press: Linkage
    conditions: tuple[OperatingCondition, ...]
    reactions: tuple[Reactions, ...]
    regions: tuple[RegionVariables, ...]
    rows: tuple[Rows, ...]
    signals: tuple[Signal, ...]
    mass: Array
    own: float
    moving: float

    @property
    def unlimited(self) -> Array:
        """(variables,) `mass` of the regions without a most mass, zero of the others."""
        return np.concatenate([each.mass * math.isinf(each.region.mass[1]) for each in self.regions])

    def added(self, u: Array) -> float:
        """Added mass at values (variables,) [kg]."""
        return float(self.mass @ u) - self.own


def build_problem(
    press: Linkage, conditions: Sequence[OperatingCondition], regions: Sequence[CounterweightRegion], targets: Sequence[Target]
) -> BalancingProblem:
    """The problem of some measures. Arguments and errors are those of `balance`."""
    _refuse_no_regions(regions)
    measures = list(dict.fromkeys(target for target in targets if isinstance(target, Measure)))
    for measure in measures:
        refuse_unknown(measure, press)
    bearings = tuple(dict.fromkeys(measure.bearing for measure in measures if measure.bearing is not None))
    reactions = tuple(inverse_dynamics(press, each.motion, each.loads, bearings=bearings) for each in conditions)
    inertia_counts, moving = any(measure.quantity != "shaking_force" for measure in measures), moving_mass(press)
    variables = _variables(press, regions, inertia_counts, [moving] * len(regions))
    signals = [
        signal
        for number, (condition, before) in enumerate(zip(conditions, reactions, strict=True))
        for signal in _signals(press, condition, number, before, variables, measures)
    ]
    # The unit of a region's variables becomes the mass that changes the measures by about their size.
    shares = _shares(variables, signals)
    variables = _variables(press, regions, inertia_counts, [moving * share for share in shares])
    factors = np.concatenate([np.full(len(each.mass), share) for each, share in zip(variables, shares, strict=True)])
    return BalancingProblem(
        press,
        conditions=tuple(conditions),
        reactions=reactions,
        regions=variables,
        rows=_joined(variables),
        signals=tuple(replace(signal, effects=signal.effects * factors) for signal in signals),
        mass=np.concatenate([each.mass for each in variables]),
        own=sum(each.own.mass for each in variables if each.own is not None),
        moving=moving,
    )


def _refuse_no_regions(regions: Sequence[CounterweightRegion]) -> None:
    if not isinstance(regions, list | tuple) or not regions or not all(isinstance(each, CounterweightRegion) for each in regions):
        raise PinpressError(
            "regions is no list of CounterweightRegion: say on which links counterweights may be,"
            " [CounterweightRegion('crank', radius=0.3)]"
        )


def _variables(
    press: Linkage, regions: Sequence[CounterweightRegion], inertia_counts: bool, units: Sequence[float]
) -> tuple[RegionVariables, ...]:
    """Regions as variables, one of which means a unit [kg] each."""
    variables = tuple(region_variables(press, region, inertia_counts, unit) for region, unit in zip(regions, units, strict=True))
    replaced = [each.joint for each in variables if each.own is not None]
    for each in variables:
        if each.own is not None and replaced.count(each.joint) > 1:
            raise PinpressError(f"two regions replace the mass of link {shown(each.region.link)}: let one of them add to it")
    return variables


def _signals(
    press: Linkage,
    condition: OperatingCondition,
    number: int,
    reactions: Reactions,
    variables: Sequence[RegionVariables],
    measures: Sequence[Measure],
) -> list[Signal]:
    """The signals of one operating condition."""
    inner_forces = any(not measure.quantity.startswith("shaking") for measure in measures)
    responses = [mass_response(press, condition, reactions, part, inner_forces) for each in variables for part in each.parts]
    replaced = [points_of(press, each.region.link, each.own) for each in variables if each.own is not None]
    own = [mass_response(press, condition, reactions, masses, inner_forces) for masses in replaced]
    return [_signal(measure, number, reactions, responses, own) for measure in measures]


def _signal(measure: Measure, number: int, reactions: Reactions, responses: Sequence[MassResponse], own: Sequence[MassResponse]) -> Signal:
    """A measure's signal.

    Args:
        measure: The measure.
        number: Number of the operating condition.
        reactions: Reactions without counterweights.
        responses: Response to one of each variable.
        own: Response to the masses that regions replace.
    """
    forces: list[Forces] = [reactions, *responses, *own]
    fixed, *others = (measure.varying(measure.series(each)) for each in forces)
    effects, replaced = np.stack(others[: len(responses)], axis=2), others[len(responses) :]
    # Where there is nothing before, what the regions do gives the size; where they do nothing either, all is rounding of what cancels.
    influence = max(measure.of(effect) for effect in others[: len(responses)])
    noise = NOISE * max(float(np.abs(measure.vector(each)).max()) for each in forces)
    size = next((size for size in (measure.of(fixed), influence) if size > max(noise, ROUNDING * influence)), noise or 1.0)
    return Signal(measure, number, size, (fixed - sum(replaced)) / size, effects / size)


def _shares(variables: Sequence[RegionVariables], signals: Sequence[Signal]) -> list[float]:
    """For every region the inverse of its largest effect, at most one."""
    largest = np.max([np.abs(signal.effects).max(axis=(0, 1)) for signal in signals], axis=0) if signals else np.ones(1)
    ends = np.cumsum([len(each.mass) for each in variables])[:-1]
    return [1.0 / max(1.0, float(part.max(initial=0.0))) for part in np.split(largest, ends)]


def _joined(variables: Sequence[RegionVariables]) -> tuple[Rows, ...]:
    """The constraints of all regions, on the variables of all."""
    width, start, rows = sum(len(each.mass) for each in variables), 0, []
    for each in variables:
        for part in each.rows:
            coefficients = np.zeros((len(part.coefficients), width))
            coefficients[:, start : start + len(each.mass)] = part.coefficients
            rows.append(replace(part, coefficients=coefficients))
        start += len(each.mass)
    return tuple(rows)
