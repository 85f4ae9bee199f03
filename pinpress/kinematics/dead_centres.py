"""Where the slide turns back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..common.arguments import typed
from ..common.arrays import Array
from ..common.errors import PinpressError
from ..common.results import Record
from ..common.roots import bracketed_roots
from ..engines.branch import beyond
from ..linkage.linkage import Linkage
from ..linkage.memo import per_linkage
from .motion import motion_through_change_points

ROUNDING = 4 * float(np.finfo(float).eps)  # of a crank angle [rad]
SAMPLES = 720  # per turn; two dead centres closer than half a degree would be taken for none
EQUAL = 1e-9  # of the stroke: slide positions that differ by less differ by rounding


@dataclass(frozen=True, repr=False)
class DeadCentres(Record, units={"top_angle": "rad", "top_position": "m", "bottom_angle": "rad", "bottom_position": "m"}):
    """Outermost turning points of the slide along its guide's axis over one period; of equal ones the first.

    Attributes:
        turns: of the driver, after which the slide is where it was; all that moves with it may be back only later
            (`Linkage.period_turns`).
        top_angle: Angle of the driver joint at top dead centre, the far end along the axis, upwards in an upright press; from 0 to the end
            of these turns [rad].
        top_position: Position of the slide at top dead centre [m].
        bottom_angle: Angle of the driver joint at bottom dead centre, likewise [rad].
        bottom_position: Position of the slide at bottom dead centre [m].
    """

    top_angle: float
    top_position: float
    bottom_angle: float
    bottom_position: float
    turns: int

    @property
    def stroke(self) -> float:
        """Distance between the dead centres [m]."""
        return self.top_position - self.bottom_position


@typed
@per_linkage(of_geometry=True)
def dead_centres(press: Linkage) -> DeadCentres:
    """Dead centres of a press whose crank turns fully, to rounding: zeros of the slide's speed, found once and kept with the press.

    Raises:
        PinpressError: the linkage has no slide, its slide never turns back, or it is not back after many turns.
        SingularityError: the linkage locks within the period.
    """
    _ = press.slide_guide  # it has a slide
    period = press.branch_through_change_points.period
    if period is None:
        raise beyond(press.branch_through_change_points, upwards=press.branch_through_change_points.locks[True] is not None)

    def slide(angle: Array) -> tuple[Array, Array, Array]:
        motion = motion_through_change_points(press, angle, 1.0)
        return motion.slide_position, motion.slide_velocity, motion.slide_acceleration

    # A press is often drawn at a dead centre: a grid that starts off the drawn pose has no sample on it.
    samples = np.linspace(0.0, period, round(SAMPLES * period / (2 * np.pi)) + 1) - 0.38 * np.pi / SAMPLES
    way, speeds, _ = slide(samples)
    turning = np.flatnonzero(np.signbit(speeds[:-1]) != np.signbit(speeds[1:]))
    if len(turning) < 2:
        raise PinpressError(f"the slide of {press.name} does not turn back within its period: it has no dead centres")
    angles = bracketed_roots(lambda angle: slide(angle)[1:], samples[turning], samples[turning + 1], absolute=ROUNDING)
    positions = slide(angles)[0]
    angles = np.where(np.abs(angles) < 1e-12, 0.0, angles % period)  # not 360 degrees for one drawn there
    top, bottom = (int(np.argmax(sign * positions >= (sign * positions).max() - EQUAL * np.ptp(positions))) for sign in (1, -1))
    turns = _turns(way[:-1], round(period / (2 * np.pi)))
    return DeadCentres(float(angles[top]), float(positions[top]), float(angles[bottom]), float(positions[bottom]), turns)


def stroke_turns(press: Linkage) -> int | None:
    """Turns of the driver from stroke to stroke; of a linkage without dead centres those of its period, None where it has none."""
    try:
        return dead_centres(press).turns
    except PinpressError:
        return press.turns_until_back


def _turns(positions: Array, turns: int) -> int:
    """Turns after which positions (n,) of the slide, equally spaced over so many turns, come again."""
    by_turn = positions.reshape(turns, -1)
    least = EQUAL * float(np.ptp(positions))
    return next(t for t in range(1, turns + 1) if np.abs(np.roll(by_turn, t, axis=0) - by_turn).max() <= least)
