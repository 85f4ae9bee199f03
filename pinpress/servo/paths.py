"""Paths of the crank in a cycle: round, round with a rest, to and fro about bottom dead centre, or down in pulses.

A path defines where the crank goes and where it rests, but not its speed. `PathLegs` is the path of one press: crank angles at which the
crank rests and between which it goes in one direction, or one whole turn without a rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..common.arguments import suitable_numbers, truth_value
from ..common.errors import PinpressError, shown
from ..common.parameters import Checked, parameter, set_field
from ..common.quantities import Array
from ..kinematics.servo_motion import angle_on_flank
from ..kinematics.slide_path import DeadCentres, dead_centres
from ..linkage.linkage import Linkage

MOST_PULSES = 100


class PathLegs(NamedTuple):
    """The path of a press's crank in one cycle."""

    angles: Array  # (k + 1,) crank angles at the ends of the k legs, in order [rad]
    dwells: Array  # (k,) required rest at the end of each leg [s]
    closed: bool  # whether the crank never rests: one leg, a whole turn that ends where it starts
    strokes: int = 1  # number of parts made in a cycle

    @property
    def dwell(self) -> float:
        """Sum of the required rests [s]."""
        return float(self.dwells.sum())


@dataclass(frozen=True)
class Turn(Checked):
    """Full turns without a rest, from top dead centre to top dead centre.

    If the gears repeat the linkage's position only after several turns of the crank, these turns are one cycle (`Linkage.period_turns`).

    Attributes:
        backwards: whether the crank turns in the negative direction.
    """

    backwards: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        truth_value("Turn: backwards", self.backwards)

    def legs(self, press: Linkage) -> PathLegs:
        """The path of a press; raises PinpressError if the crank does not turn fully or the slide has no dead centres."""
        ends = _dead_centres(press)
        way = 2 * np.pi * press.period_turns * (-1 if self.backwards else 1)
        return PathLegs(ends.top_angle + np.array([0.0, way]), np.zeros(1), True, round(press.period_turns / ends.turns))


@dataclass(frozen=True)
class Stop(Checked):
    """A full turn that begins and ends at rest at top dead centre, and may rest at bottom dead centre too.

    The crank pauses at top dead centre for the remaining time of the cycle.

    Attributes:
        bottom: rest at bottom dead centre [s]; 0: a stop without a dwell; None: the crank passes bottom dead centre.
        backwards: whether the crank turns in the negative direction.
    """

    bottom: float | None = field(default=None, metadata=parameter("s", "not negative"))
    backwards: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        truth_value("Stop: backwards", self.backwards)

    def legs(self, press: Linkage) -> PathLegs:
        """The path of a press; raises the errors of `Turn.legs`."""
        ends = _dead_centres(press)
        way = -1 if self.backwards else 1
        full = 2 * np.pi * ends.turns
        if self.bottom is None:
            return PathLegs(ends.top_angle + np.array([0.0, way * full]), np.zeros(1), False)
        below = way * (ends.bottom_angle - ends.top_angle) % full
        return PathLegs(ends.top_angle + way * np.array([0.0, below, full]), np.array([self.bottom, 0.0]), False)


@dataclass(frozen=True)
class Pendulum(Checked):
    """A swing to and fro through bottom dead centre, between two crank angles with the same height of the slide: two strokes a cycle.

    Attributes:
        opening: height of the slide above bottom dead centre at which the crank turns back [m].
        dwell: rest at this height, for feeding [s].
    """

    opening: float = field(metadata=parameter("m", "positive"))
    dwell: float = field(default=0.0, metadata=parameter("s", "not negative"))

    def legs(self, press: Linkage) -> PathLegs:
        """The path of a press; raises PinpressError if the opening is not within the stroke."""
        ends = _dead_centres(press)
        _refuse_beyond("Pendulum: opening", self.opening, ends)
        before, after = _flanks(press, ends, self.opening)
        return PathLegs(np.array([before, after, before]), np.full(2, self.dwell), False, 2)


@dataclass(frozen=True)
class Pulse(Checked):
    """A full turn from top dead centre in which the slide goes down in steps, and rests or goes back up after each step.

    Attributes:
        heights: falling heights above bottom dead centre at which the steps end; the last may be 0 [m].
        back: distance that the slide goes back up after each step except the last [m]; 0: the slide only stops.
        dwell: rest at each of the heights [s].
    """

    heights: Sequence[float]
    back: float = field(default=0.0, metadata=parameter("m", "not negative"))
    dwell: float = field(default=0.0, metadata=parameter("s", "not negative"))

    def __post_init__(self) -> None:
        super().__post_init__()
        wanted = f"1 to {MOST_PULSES} falling heights above bottom dead centre, not negative [m], e.g. (0.02, 0.01, 0)"
        heights = suitable_numbers("Pulse: heights", self.heights, wanted, (None,), _fall)
        set_field(self, "heights", tuple(heights.tolist()))

    def legs(self, press: Linkage) -> PathLegs:
        """The path of a press; raises PinpressError if a height, or height + back, is not within the stroke."""
        ends = _dead_centres(press)
        full = 2 * np.pi * ends.turns
        angles, dwells = [ends.top_angle], []
        for height in self.heights:
            _refuse_beyond("Pulse: heights", height, ends)
            angles.append(_flanks(press, ends, height)[0] if height else _bottom(ends))
            dwells.append(self.dwell)
            if self.back and height != self.heights[-1]:
                _refuse_beyond("Pulse: back, from a height of heights,", height + self.back, ends)
                angles.append(_flanks(press, ends, height + self.back)[0])
                dwells.append(0.0)
        return PathLegs(np.array([*angles, ends.top_angle + full]), np.array([*dwells, 0.0]), False)


Path = Turn | Stop | Pendulum | Pulse


def legs_of(path: object, press: Linkage) -> PathLegs:
    """The path of a press; raises PinpressError if ``path`` is not a path or does not suit the press."""
    if not isinstance(path, Turn | Stop | Pendulum | Pulse):
        raise PinpressError(f"path is {shown(path)}: give servo.Turn(), Stop(...), Pendulum(...) or Pulse(...)")
    return path.legs(press)


def _fall(heights: Array) -> bool:
    return bool(0 < len(heights) <= MOST_PULSES and np.all(heights >= 0) and np.all(np.diff(heights) < 0))


def _dead_centres(press: Linkage) -> DeadCentres:
    press.refuse_sliding_driver("servo motions need a crank; give positions over time to servo_cycle")
    return dead_centres(press)


def _bottom(ends: DeadCentres) -> float:
    """Crank angle of the first bottom dead centre after top dead centre [rad]."""
    return ends.top_angle + (ends.bottom_angle - ends.top_angle) % (2 * np.pi * ends.turns)


def _flanks(press: Linkage, ends: DeadCentres, height: float) -> tuple[float, float]:
    """Crank angles at a height before and after the first bottom dead centre after top dead centre [rad]."""
    bottom, full = _bottom(ends), 2 * np.pi * ends.turns
    before, after = angle_on_flank(press, ends, height, True), angle_on_flank(press, ends, height, False)
    return bottom - (bottom - before) % full, bottom + (after - bottom) % full


def _refuse_beyond(name: str, height: float, ends: DeadCentres) -> None:
    if not height < ends.stroke:
        raise PinpressError(
            f"{name} is {height:g} m, not below top dead centre: give heights above bottom dead centre below the stroke of"
            f" {ends.stroke:.9g} m"
        )
