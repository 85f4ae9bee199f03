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
from ..common.results import Tabular
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..loads.link import Load
from .mass_response import OperatingCondition
from .objectives import AddedMass, Measure, Target
from .optimum import checked_limits, optimal_press
from .problem import BalancingProblem, build_problem
from .regions import CounterweightRegion
from .result import BalancedPress

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
