"""The balancing problem: criteria that are minimised or limited, and their series of forces, which are linear in the variables.

A criterion is the range, rms or peak of a force, moment or torque over a motion. The added mass can be minimised or limited too. All are
convex functions of the added masses, because every force is linear in the masses. The constant part of a force, which includes the weight,
does not shake the press: range and rms exclude it, the peak includes it. The variables describe the counterweights in their regions, scaled
to a size of about one. An adjustable counterweight has separate variables for every operating condition.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import suitable_numbers
from ..common.conic_program import EQUAL, Rows
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.quantities import Array
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..linkage.linkage import Linkage
from .counterweights import MassResponse, OperatingCondition, mass_response, moving_mass
from .regions import CounterweightRegion, RegionVariables, points_of, region_variables

ROUNDING = 1e-11  # a criterion below this share of the largest change by the regions counts as zero
DRIVING = {"driving_torque": "N m", "driving_force": "N"}  # driving_force of drivers that slide
QUANTITIES = {"shaking_force": "N", "shaking_moment": "N m", **DRIVING, "bearing_force": "N", "bearing_moment": "N m"}
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


Forces = Reactions | MassResponse


@dataclass(frozen=True)
class Criterion:
    """Base of `Range`, `Rms` and `Peak`: one number for a quantity of `Reactions` over a motion.

    Attributes:
        quantity: "shaking_force", "shaking_moment", "driving_torque", "driving_force" (of a driver that slides), "bearing_force" or
            "bearing_moment".
        axis: axis of the measured component, "x", "y", "z" or a direction (3,) in world axes; None: length of the whole vector, or driving
            torque or force.
        bearing: name of the bearing, for a bearing force or bearing moment.
        about: reference point (3,) of a shaking moment, in world axes [m].

    Raises:
        UnknownNameError: no quantity has this name.
        PinpressError: the quantity does not take one of the other arguments, or an axis or point is not three finite numbers.
    """

    quantity: str
    axis: str | tuple[float, float, float] | None = None
    bearing: str | None = None
    about: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if type(self) is Criterion:
            raise PinpressError("Criterion is only the base of Range, Rms and Peak: write one of these three")
        if not isinstance(self.quantity, str) or self.quantity not in QUANTITIES:
            raise UnknownNameError("quantity", self.quantity, tuple(QUANTITIES))
        self._refuse_wrong_combination()
        direction = AXES.get(self.axis, self.axis) if isinstance(self.axis, str) else AXES["z"] if self.axis is None else self.axis
        suitable_numbers(f"{self}: axis", direction, "a direction, three numbers, or 'x', 'y' or 'z'", (3,), np.any)

    def _refuse_wrong_combination(self) -> None:
        if self.quantity.startswith("bearing") != (self.bearing is not None):
            raise PinpressError(f"{self.words}: give bearing= for a bearing force or moment, and only for these")
        suitable_numbers(f"{type(self).__name__}: about", self.about, "a point, three numbers [m]", (3,))
        if any(self.about) and self.quantity != "shaking_moment":
            raise PinpressError(f"{self.words}: about is only for a shaking moment: leave it out")
        if self.quantity in DRIVING and self.axis is not None:
            raise PinpressError(f"{self.words}: the {self.quantity.replace('_', ' ')} has no axis: leave out axis")
        if isinstance(self, Range) and self.quantity not in DRIVING and self.axis is None:
            raise PinpressError(f"{self.words}: a vector has no range: give an axis, or take Rms or Peak")

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

    def vector(self, forces: Forces) -> Array:
        """The vector (n, 3) whose component is measured; (n, drivers) for the driving torque or force."""
        values = getattr(forces, "driving_torque" if self.quantity in DRIVING else self.quantity)
        if self.bearing is not None:
            values = values[self.bearing]
        if any(self.about):
            values = values - np.cross(self.about, forces.shaking_force)
        return np.asarray(values.reshape(len(values), -1))

    def series(self, forces: Forces) -> Array:
        """The series (n, components) whose range, rms or peak is taken; it is linear in the forces."""
        values = self.vector(forces)
        if self.axis is None:
            return values
        direction = np.array(AXES[self.axis] if isinstance(self.axis, str) else self.axis, dtype=float)
        return np.asarray(values @ (direction / np.linalg.norm(direction)))[:, None]

    def varying(self, series: Array) -> Array:
        """A series (n, components), without its constant part if the criterion excludes it."""
        return np.asarray(series - series.mean(axis=0))

    def value(self, forces: Forces) -> float:
        """The criterion of `Reactions`, in its unit."""
        return self.of(self.series(forces))

    def of(self, series: Array) -> float:
        """The criterion of a series (n, components)."""
        raise NotImplementedError


class Range(Criterion):
    """Largest value - smallest value over the motion's states."""

    def of(self, series: Array) -> float:
        return float(np.ptp(series))


class Rms(Criterion):
    """Root mean square of the difference from the mean, over the motion's states."""

    def of(self, series: Array) -> float:
        return math.sqrt(float(np.mean(np.sum((series - series.mean(axis=0)) ** 2, axis=1))))


class Peak(Criterion):
    """Largest absolute value over the motion's states, constant part included."""

    def varying(self, series: Array) -> Array:
        return series

    def of(self, series: Array) -> float:
        return float(np.linalg.norm(series, axis=1).max())


@dataclass(frozen=True)
class AddedMass:
    """The mass that balancing adds to the press [kg].

    If a region replaces a link's own mass, only the difference from that mass counts.
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
        size: value of the criterion before balancing in its worst condition, in its unit; if this is zero, the largest change by the
            regions.
        fixed: (n, components) series without counterweights, after `Criterion.varying` [-].
        effects: (n, components, variables) change of the series per unit of each variable [-].
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
    """A press in its operating conditions, and how the measured quantities depend on the variables.

    Attributes:
        press: the press before balancing.
        conditions: operating conditions.
        shares: (conditions,) weight of each condition in the objective, with the sum one; None if the worst condition counts.
        reactions: reactions of the press in every condition, with the measured bearings.
        regions: regions of every condition, described in the press of this condition.
        columns: columns of the variables of every condition's regions, region by region.
        rows: constraints of the regions on all variables.
        signals: signals of all criteria in all conditions.
        mass: (settings, variables) mass per unit of each variable, with a row for each condition if masses are adjusted, else one row [kg].
        replaced_mass: own mass of links that regions replace [kg].
        moving_mass: mass of all links except the frame, before balancing [kg].
    """

    press: Linkage
    conditions: tuple[OperatingCondition, ...]
    shares: Array | None
    reactions: tuple[Reactions, ...]
    regions: tuple[tuple[RegionVariables, ...], ...]
    columns: tuple[NDArray[np.intp], ...]
    rows: tuple[Rows, ...]
    signals: tuple[Signal, ...]
    mass: Array
    replaced_mass: float
    moving_mass: float

    @property
    def size(self) -> int:
        """Number of variables."""
        return len(self.mass[0])

    @property
    def unlimited(self) -> Array:
        """(settings, variables) `mass` in regions whose mass has no upper limit, zero in the others."""
        free = np.zeros(self.size)
        for columns, region in (part for condition in range(len(self.conditions)) for part in self.parts(condition)):
            free[columns] = math.isinf(region.region.mass[1])
        return self.mass * free

    def parts(self, condition: int) -> Iterator[tuple[NDArray[np.intp], RegionVariables]]:
        """Columns of the variables of each region in an operating condition, and the region."""
        ends = np.cumsum([len(region.mass) for region in self.regions[condition]])[:-1]
        yield from zip(np.split(self.columns[condition], ends), self.regions[condition], strict=True)

    def added_mass(self, u: Array) -> float:
        """Mass that balancing adds at values (variables,), in the condition with the largest mass [kg]."""
        return float((self.mass @ u).max()) - self.replaced_mass


def build_problem(
    press: Linkage,
    conditions: Sequence[OperatingCondition],
    regions: Sequence[CounterweightRegion],
    targets: Sequence[Target],
    shares: Array | None = None,
) -> BalancingProblem:
    """Set up a problem: reactions before balancing, the regions' variables, and the signals of all criteria.

    Args:
        press: the press before balancing.
        conditions: its operating conditions.
        regions: where counterweights may be.
        targets: all criteria that are minimised or limited.
        shares: (conditions,) weight of each condition in the objective, with the sum one; None if the worst condition counts.

    Raises:
        UnknownNameError: the press does not have a link or bearing with this name.
        PinpressError: there are no regions, a region does not suit the press, a motion belongs to another press, or a press in an
            operating condition has other links or bearings.
    """
    refuse_no_regions(regions)
    criteria = list(dict.fromkeys(target for target in targets if isinstance(target, Criterion)))
    for criterion in criteria:
        _refuse_unknown(criterion, press)
    presses = [condition.set_up(press) for condition in conditions]
    for number, (other, condition) in enumerate(zip(presses, conditions, strict=True)):
        _refuse_other_press(press, other, condition.name or f"number {number}")
    bearings = tuple(dict.fromkeys(criterion.bearing for criterion in criteria if criterion.bearing is not None))
    if (press.uneven and bearings) or (press.loses_power and any(criterion.quantity in DRIVING for criterion in criteria)):
        press.refuse_contacts("with them bearing forces and lossy torques are not linear in masses; balance shaking force and moment")
    reactions = tuple(
        inverse_dynamics(other, condition.motion, condition.loads, bearings=bearings)
        for other, condition in zip(presses, conditions, strict=True)
    )
    inertia_counts, moving = any(criterion.quantity != "shaking_force" for criterion in criteria), moving_mass(press)
    variables = _in_all(press, presses, regions, inertia_counts, [moving] * len(regions))
    by_condition = [_series(*given, criteria) for given in zip(presses, conditions, reactions, variables, strict=True)]
    by_criterion = zip(criteria, zip(*by_condition, strict=True), strict=True)
    signals = [signal for criterion, series in by_criterion for signal in _signals(criterion, series)]
    # The unit of a region's variables becomes the mass that changes the criteria by about their own size.
    largest = np.max([np.abs(signal.effects).max(axis=(0, 1)) for signal in signals], axis=0) if signals else np.ones(1)
    ends = np.cumsum([len(region.mass) for region in variables[0]])[:-1]
    shares_of_mass = [1.0 / max(1.0, float(part.max(initial=0.0))) for part in np.split(largest, ends)]
    variables = _in_all(press, presses, regions, inertia_counts, [moving * share for share in shares_of_mass])
    factors = np.concatenate([np.full(len(region.mass), share) for region, share in zip(variables[0], shares_of_mass, strict=True)])
    columns, width = _columns(variables[0], len(presses))
    return BalancingProblem(
        press,
        conditions=tuple(conditions),
        shares=shares,
        reactions=reactions,
        regions=variables,
        columns=columns,
        rows=_join_rows(variables, columns, width),
        signals=tuple(replace(signal, effects=_spread(signal.effects * factors, columns[signal.condition], width)) for signal in signals),
        mass=_masses(variables[0], columns, width),
        replaced_mass=sum(region.replaced.mass for region in variables[0] if region.replaced is not None),
        moving_mass=moving,
    )


def _refuse_other_press(press: Linkage, other: Linkage, condition: str) -> None:
    """Raise if the press of an operating condition is not the same machine as the press itself."""
    for what in ("links", "joints", "bearings", "drivers"):
        if getattr(press, what) != getattr(other, what):
            raise PinpressError(
                f"operating condition {condition}: its press {other.name} differs from {press.name} in: {what}. Give the same press with"
                " another die or stroke, made from the same file or table"
            )


def refuse_no_regions(regions: Sequence[CounterweightRegion]) -> None:
    """Raise PinpressError if there are no regions."""
    if not isinstance(regions, list | tuple) or not regions or not all(isinstance(region, CounterweightRegion) for region in regions):
        raise PinpressError(
            "regions is not a list of CounterweightRegion: give the links that may have counterweights, e.g."
            " [CounterweightRegion('crank', radius=0.3)]"
        )


def _refuse_unknown(criterion: Criterion, press: Linkage) -> None:
    """Raise if a press does not have the quantity of a criterion.

    Raises:
        UnknownNameError: the press does not have a bearing with this name.
        PinpressError: the criterion needs the driving torque of drivers that slide, the driving force of drivers that turn, or a range over
            several drivers.
    """
    if criterion.bearing is not None and criterion.bearing not in press.bearings:
        raise UnknownNameError("bearing", criterion.bearing, press.bearings)
    if criterion.quantity not in DRIVING:
        return
    efforts = [coordinate.effort for coordinate in press.driver_coordinates]
    if any(criterion.quantity != f"driving_{effort}" for effort in efforts):
        takes = (f"driver {name!r} takes a {effort}" for name, effort in zip(press.drivers, efforts, strict=True))
        remedy = "give driving_torque for drivers that turn, driving_force for drivers that slide"
        raise PinpressError(f"{criterion.words}: {', '.join(takes)}; {remedy}")
    if isinstance(criterion, Range) and len(efforts) > 1:
        several = criterion.quantity.replace("_", " ")
        raise PinpressError(f"{press.name} has {len(efforts)} {several}s, and several have no common range: take Rms or Peak")


def _in_all(
    press: Linkage, presses: Sequence[Linkage], regions: Sequence[CounterweightRegion], inertia_counts: bool, units: Sequence[float]
) -> tuple[tuple[RegionVariables, ...], ...]:
    """Regions as variables in every operating condition; ``units``: for each region the mass per unit of its variables [kg].

    Raises:
        PinpressError: a region is not the same in all conditions, or as `region_variables`.
    """
    variables = _variables(press, regions, inertia_counts, units)
    by_press = tuple(variables if other is press else _variables(other, regions, inertia_counts, units) for other in presses)
    for other, in_other in zip(presses, by_press, strict=True):
        for here, there in zip(variables, in_other, strict=True):
            _refuse_other_region(press, other, here, there)
    return by_press


def _refuse_other_region(press: Linkage, other: Linkage, here: RegionVariables, there: RegionVariables) -> None:
    """Raise if a unit of a variable is not the same body in both presses, so that one counterweight cannot be described for both."""
    compared = [(first.masses, second.masses) for first, second in zip(here.parts, there.parts, strict=True)]
    compared += [(first.points, second.points) for first, second in zip(here.parts, there.parts, strict=True)]
    compared.append((press.frame_of(here.region.link).placement.homogeneous, other.frame_of(here.region.link).placement.homogeneous))
    if here.replaced is not None and there.replaced is not None:
        compared.append((np.array([here.replaced.mass]), np.array([there.replaced.mass])))
    differs = (a.shape != b.shape or (np.abs(a - b) > 1e-12 * np.abs(a).max()).any() for a, b in compared)  # less is rounding error
    if here.joint != there.joint or any(differs):
        raise PinpressError(
            f"{here.region.words}: operating conditions have different frames or different own masses of this link, so the region is not"
            " the same body in all: put the die on a link that keeps its mass, or give at, radius or corners"
        )


def _variables(
    press: Linkage, regions: Sequence[CounterweightRegion], inertia_counts: bool, units: Sequence[float]
) -> tuple[RegionVariables, ...]:
    """Regions as variables; ``units``: for each region the mass per unit of its variables [kg]."""
    variables = tuple(region_variables(press, region, inertia_counts, unit) for region, unit in zip(regions, units, strict=True))
    replacing = [part for part in variables if part.replaced is not None]
    for part in replacing:
        if [other.joint for other in replacing].count(part.joint) > 1:
            raise PinpressError(f"two regions replace the mass of link {shown(part.region.link)}: leave out replaces=True in one of them")
    return variables


class _Series(NamedTuple):
    """A criterion in one operating condition.

    Attributes:
        fixed: (n, components) series without counterweights.
        replaced: (n, components) series of the masses that regions replace.
        effects: (n, components, variables) series per unit of each variable.
        before: value before balancing.
        influence: largest value of an effect.
        noise: size of rounding errors.
    """

    fixed: Array
    replaced: Array
    effects: Array
    before: float
    influence: float
    noise: float


def _series(
    press: Linkage,
    condition: OperatingCondition,
    reactions: Reactions,
    variables: Sequence[RegionVariables],
    criteria: Sequence[Criterion],
) -> Iterator[_Series]:
    """The series of all criteria in one operating condition."""
    inner_forces = any(not criterion.quantity.startswith("shaking") for criterion in criteria)
    parts = [part for region in variables for part in region.parts]
    parts += [points_of(press, region.region.link, region.replaced) for region in variables if region.replaced is not None]
    responses = [mass_response(press, condition, reactions, part, inner_forces) for part in parts]
    count = sum(len(region.parts) for region in variables)
    all_forces: list[Reactions | MassResponse] = [reactions, *responses]
    for criterion in criteria:
        fixed, *others = (criterion.varying(criterion.series(forces)) for forces in all_forces)
        yield _Series(
            fixed,
            replaced=sum(others[count:], np.zeros_like(fixed)),
            effects=np.stack(others[:count], axis=2),
            before=criterion.of(fixed),
            influence=max(criterion.of(effect) for effect in others[:count]),
            noise=1e-12 * max(float(np.abs(criterion.vector(forces)).max()) for forces in all_forces),
        )


def _signals(criterion: Criterion, series: Sequence[_Series]) -> Iterator[Signal]:
    """The signals of a criterion in all conditions, divided by the same size, so that the worst condition has the largest value."""
    # If the criterion is zero before, the effect of the regions gives the size. If that is zero too, all values are rounding errors.
    before, influence, noise = (max(getattr(part, name) for part in series) for name in ("before", "influence", "noise"))
    size = next((size for size in (before, influence) if size > max(noise, ROUNDING * influence)), noise or 1.0)
    for number, part in enumerate(series):
        yield Signal(criterion, number, size, (part.fixed - part.replaced) / size, part.effects / size)


def _columns(variables: Sequence[RegionVariables], conditions: int) -> tuple[tuple[NDArray[np.intp], ...], int]:
    """Columns of the regions' variables for every operating condition, and the number of columns.

    An adjusted region has separate columns in every condition.
    """
    by_condition, width = [list[NDArray[np.intp]]() for _ in range(conditions)], 0
    for region in variables:
        count = len(region.mass)
        for number, columns in enumerate(by_condition):
            if number and region.region.reset:
                width += count
            columns.append(np.arange(width, width + count))
        width += count
    return tuple(np.concatenate(columns) for columns in by_condition), width


def _spread(local: Array, columns: NDArray[np.intp], width: int) -> Array:
    """Coefficients (..., variables of one condition) as those (..., width) of all variables."""
    wide = np.zeros((*local.shape[:-1], width))
    wide[..., columns] = local
    return wide


def _masses(variables: Sequence[RegionVariables], columns: Sequence[NDArray[np.intp]], width: int) -> Array:
    """(settings, width) mass per unit of each variable [kg]."""
    settings = len(columns) if any(region.region.reset == "mass" for region in variables) else 1
    mass = np.concatenate([region.mass for region in variables])
    return np.array([_spread(mass, columns[number], width) for number in range(settings)])


def _join_rows(variables: Sequence[Sequence[RegionVariables]], columns: Sequence[NDArray[np.intp]], width: int) -> tuple[Rows, ...]:
    """The constraints of all regions, on the variables of all conditions."""
    ends, rows = np.cumsum([len(region.mass) for region in variables[0]])[:-1], list[Rows]()
    first, *others = [np.split(region, ends) for region in columns]
    for k, region in enumerate(variables[0]):
        rows += (replace(part, matrix=_spread(part.matrix, first[k], width)) for part in region.rows)
        for number, columns_of in enumerate(others if region.region.reset else (), 1):
            in_condition = f", condition {number}"
            rows += (
                replace(part, matrix=_spread(part.matrix, columns_of[k], width), name=part.name and part.name + in_condition)
                for part in region.rows
            )
            if region.region.reset == "position":  # the mass stays
                unit = np.abs(region.mass).max()
                difference = _spread(region.mass[None] / unit, columns_of[k], width) - _spread(region.mass[None] / unit, first[k], width)
                rows.append(Rows(EQUAL, difference, np.zeros(1)))
    return tuple(rows)


def _point_words(vector: tuple[float, float, float]) -> str:
    return f"({', '.join(f'{number:g}' for number in vector)})"
