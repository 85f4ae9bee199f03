"""What of one measure must be given for another: the balanced presses between the best of either (Pareto curves)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..common.arguments import typed
from ..common.arrays import Array
from ..common.checks import whole_number
from ..common.errors import PinpressError, shown
from ..common.frozen import Frozen
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..loads.link import Load
from .mass_response import Case
from .objectives import AddedMass, Measure, Target
from .optimum import balanced, checked
from .problem import build
from .regions import Room
from .result import Balance

GIVEN = 1e-7  # of a measure before balancing: what is given of its best so that the other can be improved


MOST_POINTS = 10_000  # each an optimisation


@dataclass(frozen=True, eq=False, repr=False)
class TradeOff(Frozen):
    """Balanced presses of which none is better in one measure without being worse in the other.

    Attributes:
        first, second: the measures. designs: from the best of the first to the best of the second.
        values: (designs, 2) of both measures, in their units.
    """

    first: Target
    second: Target
    designs: tuple[Balance, ...]
    values: Array

    def __repr__(self) -> str:
        return f"<TradeOff of the {self.first.words} and the {self.second.words}: {len(self.designs)} designs>"


@typed
def trade_off(
    press: Linkage,
    motion: Motion,
    rooms: Sequence[Room],
    first: Target,
    second: Target,
    limits: Mapping[Target, float] | None = None,
    loads: Sequence[Load] = (),
    points: int = 13,
) -> TradeOff:
    """The curve between the least of one measure and the least of another, each point a proved optimum.

    Between its ends the first is minimised under equally spaced limits of the second. Arguments as of `balance`.

    Raises:
        PinpressError: as `balance`; both measures the same, fewer than two points.
    """
    for name, target in (("first", first), ("second", second)):
        if not isinstance(target, Measure | AddedMass):
            raise PinpressError(f"{name}: {shown(target)} is no measure: give Range, Rms, Peak or AddedMass()")
    if first == second:
        raise PinpressError(f"both measures are the {first.words}: give two")
    points = whole_number("points", points, 2, MOST_POINTS)
    held = dict(limits or {})
    objectives = {target: checked(target, held) for target in (first, second)}
    cases = (Case(motion, tuple(loads)),)
    problem, before = build(press, cases, rooms, [first, second, *held])

    def best(target: Target, other: Target, most: float) -> Balance:
        tighter = held | {other: min(most, held.get(other, math.inf))} if most < math.inf else held
        return balanced(press, cases, problem, before, objectives[target], tighter, absolute=True)

    def end(least: Target, other: Target) -> Balance:
        """The best of one measure, and of all such the best of the other; of no added mass there is but one."""
        design = best(least, other, math.inf)
        return design if isinstance(least, AddedMass) else best(other, least, design.value + GIVEN * least.value(before[0]))

    ends = end(first, second), end(second, first)
    between = np.linspace(_value(ends[0], second), _value(ends[1], second), points)[1:-1]
    designs = (ends[0], *(best(first, second, float(most)) for most in between), ends[1])
    values = np.array([[_value(design, target) for target in (first, second)] for design in designs])
    values.setflags(write=False)
    return TradeOff(first, second, designs, values)


def _value(design: Balance, target: Target) -> float:
    if isinstance(target, AddedMass):
        return design.added_mass
    return next(outcome.after for outcome in design.outcomes if outcome.measure == target)
