"""A balanced press: its counterweights, the proof of the optimum, and the criteria before and after."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..common.quantities import Array
from ..common.results import Record, Records, Tabular
from ..common.tables import Column
from ..dynamics.extremes import AXES, Rounding, rounding
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.cycle import cycle
from ..linkage.linkage import Linkage
from .counterweights import Counterweight, OperatingCondition
from .problem import Criterion, Peak, Range, Target


@dataclass(frozen=True, repr=False)
class CriterionChange(Record):
    """A criterion before and after balancing in one operating condition.

    Attributes:
        criterion: the criterion.
        condition: number of the operating condition, from 0.
        before: value before balancing, in the criterion's unit.
        after: value after balancing, in the criterion's unit.
    """

    criterion: Criterion
    condition: int
    before: float
    after: float

    @property
    def change(self) -> float:
        """Relative change [-]; NaN if the value before is zero."""
        return self.after / self.before - 1.0 if self.before else float("nan")

    @property
    def title(self) -> str:
        values = f"{self.before:.6g} to {self.after:.6g} {self.criterion.unit}"
        return f"CriterionChange of {self.criterion.words}, condition {self.condition}: {values}"

    def row(self) -> dict[str, object]:
        return {
            "criterion": self.criterion.words,
            "unit": self.criterion.unit,
            "condition": self.condition,
            "before": self.before,
            "after": self.after,
            "change [-]": None if math.isnan(self.change) else self.change,
        }


@dataclass(frozen=True, repr=False)
class ActiveConstraint(Record):
    """A constraint that is active at the optimum.

    Attributes:
        constraint: the constraint as text.
        price: fall of the objective per unit by which the limit is relaxed; None for the shape of a region, which is not a number.
    """

    constraint: str
    price: float | None


@dataclass(frozen=True, eq=False, repr=False)
class BalancedPress(Tabular):
    """A press with its best counterweights.

    Attributes:
        original: the press before balancing.
        press: the press with its counterweights, which `write_urdf` writes; adjustable counterweights are those of the first condition.
        presses: the balanced press in every operating condition, with the die, the stroke and the counterweights of this condition.
        conditions: operating conditions for which the press was balanced.
        objective: criterion -> weight.
        limits: the given limits.
        shares: (conditions,) weights of the operating conditions, with the sum one; None if the worst condition counts.
        counterweights: counterweights in the first condition in the order of the regions, without zero masses. If a region replaces a
            link's own mass, the counterweight is the whole new mass.
        settings: counterweights in every condition, which differ if regions are adjusted.
        added_mass: total mass that balancing adds, in the condition with the largest mass [kg].
        value: objective in the worst condition, or mean by shares. A single criterion has its unit; several criteria are summed with
            weights, each relative to its largest value before.
        unit: unit of the value; empty if the value is relative.
        bound: proven lower bound of the objective for all counterweights in these regions, at the states of the motion. The difference from
            ``value`` is the unproved part and the cost of preferring lighter counterweights.
        residual: largest violation of the conditions of optimality, relative to before.
        changes: changes of the criteria of the objective, then of the limited criteria, condition by condition.
        active: constraints that are active at the optimum.
        reactions_before: reactions of the press before balancing in every operating condition, with only the measured bearings.
        reactions_after: reactions of the balanced press in the same motions. Under its drive the balanced press has another motion:
            simulate it for that.
    """

    original: Linkage
    press: Linkage
    presses: tuple[Linkage, ...]
    conditions: tuple[OperatingCondition, ...]
    objective: Mapping[Target, float]
    limits: Mapping[Target, float]
    shares: Array | None
    counterweights: Records[Counterweight]
    settings: tuple[Records[Counterweight], ...]
    added_mass: float
    value: float
    unit: str
    bound: float
    residual: float
    changes: Records[CriterionChange]
    active: Records[ActiveConstraint]
    reactions_before: tuple[Reactions, ...]
    reactions_after: tuple[Reactions, ...]

    @cached_property
    def between_states(self) -> float | None:
        """Largest excess of a criterion between the states, as a share of its value before [-].

        The proof holds at the states of the motions. This check uses eight times the number of states. None if a motion is not one period
        at constant speed: then its positions between states are not known.
        """
        worst = 0.0
        for number, (press, condition) in enumerate(zip(self.presses, self.conditions, strict=True)):
            motion = condition.motion
            if motion.period_turns is None or np.ptp(motion.crank_speed) > 0:
                return None
            finer = cycle(press, float(motion.crank_speed[0]), points=8 * len(motion.time))
            changes = [change for change in self.changes if change.condition == number]
            bearings = {change.criterion.bearing for change in changes} - {None}
            reactions = inverse_dynamics(press, finer, condition.loads, bearings=sorted(map(str, bearings)))
            shares = ((change.criterion.value(reactions) - change.after) / change.before for change in changes if change.before)
            worst = max(worst, *shares, 0.0)
        return worst

    @property
    def title(self) -> str:
        return f"BalancedPress {self.press.name}: {self.added_mass:.6g} kg added, {len(self.counterweights)} counterweights"

    @cached_property
    def side_effects(self) -> Records[CriterionChange]:
        """Changes of the criteria that were neither minimised nor limited, condition by condition; computed at the first access.

        They are the range of the driving torque or force (of several drivers the peak), the peak of every bearing force, and the range of
        every component of shaking force and shaking moment, without the criteria in `changes`. A rounding error counts as 0. A criterion
        that is 0 before and after in all operating conditions is left out.
        """
        asked = {change.criterion for change in self.changes}
        originals = [condition.set_up(self.original) for condition in self.conditions]
        before, after = (
            [
                inverse_dynamics(press, reactions.motion, condition.loads)
                for press, reactions, condition in zip(presses, measured, self.conditions, strict=True)
            ]
            for presses, measured in ((originals, self.reactions_before), (self.presses, self.reactions_after))
        )
        least_of, effects = [rounding(reactions) for reactions in before], list[CriterionChange]()
        for criterion in _criteria_of(self.original):
            rows = [
                CriterionChange(criterion, number, _without_rounding(criterion, then, least), _without_rounding(criterion, now, least))
                for number, (then, now, least) in enumerate(zip(before, after, least_of, strict=True))
            ]
            if criterion not in asked and any(row.before or row.after for row in rows):
                effects += rows
        return Records(CriterionChange, effects)

    def columns(self) -> dict[str, Column]:
        """A row for each criterion in each operating condition, `changes` and then `side_effects`; None if there is no value."""
        changes = Records(CriterionChange, (*self.changes, *self.side_effects))
        return changes.columns() | {"limit": [self.limits.get(change.criterion) for change in changes]}


def _criteria_of(press: Linkage) -> Iterator[Criterion]:
    efforts = {f"driving_{coordinate.effort}" for coordinate in press.driver_coordinates}
    if len(efforts) == 1:  # torques and forces have no common measure
        (effort,) = efforts
        yield Range(effort) if len(press.drivers) == 1 else Peak(effort)
    yield from (Peak("bearing_force", bearing=bearing) for bearing in press.bearings_as_drawn)
    yield from (Range(quantity, axis) for quantity in ("shaking_force", "shaking_moment") for axis in AXES)


def _without_rounding(criterion: Criterion, reactions: Reactions, least: Rounding) -> float:
    """The value of a criterion; 0 for a rounding error."""
    value = criterion.value(reactions)
    return value if value > (least.force if criterion.unit == "N" else least.moment) else 0.0


def condition_name(balanced: BalancedPress, number: int) -> str:
    """The name of an operating condition in tables: its own, or its number."""
    return balanced.conditions[number].name or f"{number}"
