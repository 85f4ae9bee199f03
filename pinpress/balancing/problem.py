"""Balancing as a problem: criteria that are minimised or limited, and the series of forces behind them, linear in the variables.

A criterion is the range, rms or peak of a force, moment or torque over a motion; the added mass can be minimised or limited too. All are
convex functions of the added masses, because every force is linear in the masses. The constant part of a force, which includes the
weight, shakes nothing: range and rms leave it out, and the peak counts it. The variables are those of the regions for counterweights,
scaled so that all numbers are about one in size.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from ..common.arguments import suitable_numbers
from ..common.conic_program import Rows
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.quantities import Array
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..linkage.linkage import Linkage
from .counterweights import MassResponse, OperatingCondition, mass_response, moving_mass
from .regions import CounterweightRegion, RegionVariables, points_of, region_variables

ROUNDING = 1e-11  # a criterion below this share of the largest change that the regions can cause is zero
NOISE = 1e-12  # a criterion below this share of the vector of which it takes a component is rounding
DRIVING = {"driving_torque": "N m", "driving_force": "N"}  # the latter of drivers that slide
QUANTITIES = {"shaking_force": "N", "shaking_moment": "N m", **DRIVING, "bearing_force": "N", "bearing_moment": "N m"}
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


class ForceSeries(Protocol):
    """The forces that `Reactions` and their changes by masses (`MassResponse`) have in common."""

    @property
    def shaking_force(self) -> Array: ...
    @property
    def shaking_moment(self) -> Array: ...
    @property
    def driving_torque(self) -> Array: ...
    @property
    def bearing_force(self) -> Mapping[str, Array]: ...
    @property
    def bearing_moment(self) -> Mapping[str, Array]: ...


@dataclass(frozen=True)
class Criterion:
    """Base of `Range`, `Rms` and `Peak`: one number for a quantity of `Reactions` over a motion.

    Attributes:
        quantity: "shaking_force", "shaking_moment", "driving_torque", of a driver that slides "driving_force", "bearing_force" or
            "bearing_moment".
        axis: "x", "y", "z" or a direction (3,) in world axes, whose component is measured; None for the length of the whole vector, and
            for the driving torque or force.
        bearing: name of the bearing, for a bearing force or bearing moment.
        about: point (3,) in world axes that a shaking moment is taken about [m].

    Raises:
        UnknownNameError: there is no such quantity.
        PinpressError: the quantity and the other arguments do not go together, or an axis or point is not three finite numbers.
    """

    quantity: str
    axis: str | tuple[float, float, float] | None = None
    bearing: str | None = None
    about: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if type(self) is Criterion:
            raise PinpressError("Criterion is what Range, Rms and Peak have in common: write one of these")
        if not isinstance(self.quantity, str) or self.quantity not in QUANTITIES:
            raise UnknownNameError("quantity", self.quantity, tuple(QUANTITIES))
        self._refuse_wrong_combination()
        direction = AXES.get(self.axis, self.axis) if isinstance(self.axis, str) else AXES["z"] if self.axis is None else self.axis
        suitable_numbers(f"{self}: axis", direction, "a direction, three numbers, or 'x', 'y' or 'z'", (3,), np.any)

    def _refuse_wrong_combination(self) -> None:
        if self.quantity.startswith("bearing") != (self.bearing is not None):
            raise PinpressError(f"{self.words}: a bearing force or moment needs bearing=, the other quantities have none")
        suitable_numbers(f"{type(self).__name__}: about", self.about, "a point, three numbers [m]", (3,))
        if any(self.about) and self.quantity != "shaking_moment":
            raise PinpressError(f"{self.words}: about goes with a shaking moment")
        if self.quantity in DRIVING and self.axis is not None:
            raise PinpressError(f"{self.words}: the {self.quantity.replace('_', ' ')} has no axis: leave it out")
        if isinstance(self, Range) and self.quantity not in DRIVING and self.axis is None:
            raise PinpressError(f"{self.words}: a vector has no range: name an axis, or take Rms or Peak")

    @property
    def unit(self) -> str:
        """Unit of the value: "N" or "N m"."""
        return QUANTITIES[self.quantity]

    @property
    def words(self) -> str:
        """Name in messages and tables, such as "range of the shaking force, z"."""
        what = self.quantity.replace("_", " ") + ("" if self.bearing is None else f" of {self.bearing}")
        where = "" if self.axis is None else f", {self.axis if isinstance(self.axis, str) else _point_words(self.axis)}"
        point = f" about {_point_words(self.about)}" if any(self.about) else ""
        return f"{type(self).__name__.lower()} of the {what}{where}{point}"

    def vector(self, forces: ForceSeries) -> Array:
        """The vector (n, 3) whose component is measured; (n, drivers) for the driving torque or force."""
        values = getattr(forces, "driving_torque" if self.quantity in DRIVING else self.quantity)
        if self.bearing is not None:
            values = values[self.bearing]
        if any(self.about):
            values = values - np.cross(self.about, forces.shaking_force)
        return np.asarray(values.reshape(len(values), -1))

    def series(self, forces: ForceSeries) -> Array:
        """The series (n, components) whose range, rms or peak is taken; it is linear in the forces."""
        values = self.vector(forces)
        if self.axis is None:
            return values
        direction = np.array(AXES[self.axis] if isinstance(self.axis, str) else self.axis, dtype=float)
        return np.asarray(values @ (direction / np.linalg.norm(direction)))[:, None]

    def varying(self, series: Array) -> Array:
        """A series (n, components) without its constant part, where that does not count."""
        return np.asarray(series - series.mean(axis=0))

    def value(self, forces: ForceSeries) -> float:
        """The criterion of `Reactions`, in its unit."""
        return self.of(self.series(forces))

    def of(self, series: Array) -> float:
        """The criterion of a series (n, components)."""
        raise NotImplementedError


class Range(Criterion):
    """Largest value less smallest value over the motion's states."""

    def of(self, series: Array) -> float:
        return float(np.ptp(series))


class Rms(Criterion):
    """Root mean square of the difference from the mean, over the motion's states."""

    def of(self, series: Array) -> float:
        return math.sqrt(float(np.mean(np.sum((series - series.mean(axis=0)) ** 2, axis=1))))


class Peak(Criterion):
    """Largest magnitude over the motion's states, constant part included."""

    def varying(self, series: Array) -> Array:
        return series

    def of(self, series: Array) -> float:
        return float(np.linalg.norm(series, axis=1).max())


@dataclass(frozen=True)
class AddedMass:
    """The mass that balancing adds to the press [kg].

    Where a region replaces a link's own mass, only the difference from that mass counts.
    """

    unit = "kg"
    words = "added mass"


Target = Criterion | AddedMass


def limit_words(target: Target, limit: float) -> str:
    """Name of a limit in messages and tables, such as "limit of the added mass, 400 kg"."""
    return f"limit of the {target.words}, {limit:g} {target.unit}"


@dataclass(frozen=True, eq=False, repr=False)
class Signal:
    """The series of a criterion in one operating condition, ``size * (fixed + effects @ u)`` for variables u.

    Attributes:
        criterion: the criterion.
        condition: number of the operating condition.
        size: value of the criterion before balancing, in its unit; where that is zero, the most that the regions can change of it.
        fixed: (n, components) series without counterweights, with what `Criterion.varying` keeps of it [-].
        effects: (n, components, variables) its change by one of each variable [-].
    """

    criterion: Criterion
    condition: int
    size: float
    fixed: Array
    effects: Array

    def at(self, u: Array) -> Array:
        """The series (n, components) at values (variables,), divided by its size."""
        return np.asarray(self.fixed + self.effects @ u)


@dataclass(frozen=True, eq=False, repr=False)
class BalancingProblem:
    """A press in its operating conditions, and how all that is measured depends on the regions' variables.

    Attributes:
        press: the press before balancing.
        conditions: operating conditions.
        reactions: reactions of the press in every condition, with the bearings that are measured.
        regions: regions, whose variables stand one after the other.
        rows: constraints of the regions on all variables.
        signals: signals of all criteria in all conditions.
        mass: (variables,) mass that one of each variable means [kg].
        replaced_mass: mass of the links' own that regions replace [kg].
        moving_mass: mass of all links but the frame, before balancing [kg].
    """

    press: Linkage
    conditions: tuple[OperatingCondition, ...]
    reactions: tuple[Reactions, ...]
    regions: tuple[RegionVariables, ...]
    rows: tuple[Rows, ...]
    signals: tuple[Signal, ...]
    mass: Array
    replaced_mass: float
    moving_mass: float

    @property
    def unlimited(self) -> Array:
        """(variables,) `mass` in regions whose mass has no upper limit, zero in the others."""
        return np.concatenate([each.mass * math.isinf(each.region.mass[1]) for each in self.regions])

    def added_mass(self, u: Array) -> float:
        """Mass that balancing adds at values (variables,) [kg]."""
        return float(self.mass @ u) - self.replaced_mass


def build_problem(
    press: Linkage, conditions: Sequence[OperatingCondition], regions: Sequence[CounterweightRegion], targets: Sequence[Target]
) -> BalancingProblem:
    """Set up a problem: reactions before balancing, the regions' variables, and the signals of all criteria.

    Args:
        press: the press before balancing.
        conditions: its operating conditions.
        regions: where counterweights may be.
        targets: all criteria that will be minimised or limited.

    Raises:
        UnknownNameError: the press has no such link or bearing.
        PinpressError: there are no regions, a region does not fit the press, or a motion is not one of the press.
    """
    _refuse_no_regions(regions)
    criteria = list(dict.fromkeys(target for target in targets if isinstance(target, Criterion)))
    for criterion in criteria:
        _refuse_unknown(criterion, press)
    bearings = tuple(dict.fromkeys(criterion.bearing for criterion in criteria if criterion.bearing is not None))
    reactions = tuple(inverse_dynamics(press, each.motion, each.loads, bearings=bearings) for each in conditions)
    inertia_counts, moving = any(criterion.quantity != "shaking_force" for criterion in criteria), moving_mass(press)
    variables = _variables(press, regions, inertia_counts, [moving] * len(regions))
    signals = [
        signal
        for number, (condition, before) in enumerate(zip(conditions, reactions, strict=True))
        for signal in _signals(press, condition, number, before, variables, criteria)
    ]
    # The unit of a region's variables becomes the mass that changes the criteria by about as much as they are.
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
        replaced_mass=sum(each.replaced.mass for each in variables if each.replaced is not None),
        moving_mass=moving,
    )


def _refuse_no_regions(regions: Sequence[CounterweightRegion]) -> None:
    if not isinstance(regions, list | tuple) or not regions or not all(isinstance(each, CounterweightRegion) for each in regions):
        raise PinpressError(
            "regions is no list of CounterweightRegion: say on which links counterweights may be,"
            " [CounterweightRegion('crank', radius=0.3)]"
        )


def _refuse_unknown(criterion: Criterion, press: Linkage) -> None:
    """Raise where a press does not have what is measured.

    Raises:
        UnknownNameError: the press has no such bearing.
        PinpressError: the driving torque of drivers that slide is asked for, or the force of others; or the range of that of several.
    """
    if criterion.bearing is not None and criterion.bearing not in press.bearings:
        raise UnknownNameError("bearing", criterion.bearing, press.bearings)
    if criterion.quantity in DRIVING and any(criterion.quantity != f"driving_{each.effort}" for each in press.driver_coordinates):
        given = (f"driver {name!r} takes a {each.effort}" for name, each in zip(press.drivers, press.driver_coordinates, strict=True))
        remedy = "driving_torque is that of drivers that turn, driving_force that of drivers that slide"
        raise PinpressError(f"{criterion.words}: {', '.join(given)}; {remedy}")
    if isinstance(criterion, Range) and criterion.quantity in DRIVING and len(press.drivers) > 1:
        efforts = criterion.quantity.replace("_", " ")
        raise PinpressError(f"{press.name} has {len(press.drivers)} {efforts}s, which have no range as a whole: take Rms or Peak")


def _variables(
    press: Linkage, regions: Sequence[CounterweightRegion], inertia_counts: bool, units: Sequence[float]
) -> tuple[RegionVariables, ...]:
    """Regions as variables; ``units``: for each region the mass that one of its variables means [kg]."""
    variables = tuple(region_variables(press, region, inertia_counts, unit) for region, unit in zip(regions, units, strict=True))
    replaced = [each.joint for each in variables if each.replaced is not None]
    for each in variables:
        if each.replaced is not None and replaced.count(each.joint) > 1:
            raise PinpressError(f"two regions replace the mass of link {shown(each.region.link)}: let one of them add to it")
    return variables


def _signals(
    press: Linkage,
    condition: OperatingCondition,
    number: int,
    reactions: Reactions,
    variables: Sequence[RegionVariables],
    criteria: Sequence[Criterion],
) -> list[Signal]:
    """The signals of one operating condition."""
    inner_forces = any(not criterion.quantity.startswith("shaking") for criterion in criteria)
    responses = [mass_response(press, condition, reactions, part, inner_forces) for each in variables for part in each.parts]
    replaced = [points_of(press, each.region.link, each.replaced) for each in variables if each.replaced is not None]
    own = [mass_response(press, condition, reactions, masses, inner_forces) for masses in replaced]
    return [_signal(criterion, number, reactions, responses, own) for criterion in criteria]


def _signal(
    criterion: Criterion, number: int, reactions: Reactions, responses: Sequence[MassResponse], own: Sequence[MassResponse]
) -> Signal:
    """A criterion's signal.

    Args:
        criterion: the criterion.
        number: number of the operating condition.
        reactions: reactions without counterweights.
        responses: response to one of each variable.
        own: response to the masses that regions replace.
    """
    forces: list[ForceSeries] = [reactions, *responses, *own]
    fixed, *others = (criterion.varying(criterion.series(each)) for each in forces)
    effects, replaced = np.stack(others[: len(responses)], axis=2), others[len(responses) :]
    # Where the criterion is zero before, the effect of the regions gives the size; where they have none either, all is rounding.
    influence = max(criterion.of(effect) for effect in others[: len(responses)])
    noise = NOISE * max(float(np.abs(criterion.vector(each)).max()) for each in forces)
    size = next((size for size in (criterion.of(fixed), influence) if size > max(noise, ROUNDING * influence)), noise or 1.0)
    return Signal(criterion, number, size, (fixed - sum(replaced)) / size, effects / size)


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


def _point_words(vector: tuple[float, float, float]) -> str:
    return f"({', '.join(f'{number:g}' for number in vector)})"
