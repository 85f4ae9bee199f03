"""The phases of a turn as a forming process sees them: approach, working, run-out and return."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..common.arguments import typed
from ..common.errors import PinpressError
from ..common.results import Record, Records
from .even_speed import evenest_window, inside_stroke
from .periodic_curve import step_angle, step_time
from .slide_path import SlideMotion, Stroke, working_stroke


@dataclass(frozen=True, repr=False)
class StrokePhase(
    Record,
    units={
        "crank_angle": "rad",
        "turned": "rad",
        "duration": "s",
        "travel": "m",
        "height": "m",
        "lowest_speed": "m/s",
        "mean_speed": "m/s",
        "highest_speed": "m/s",
    },
):
    """A part of the slide's motion over a turn.

    Attributes:
        phase: "approach", "working", "run-out" or "return", see `phases`.
        crank_angle: crank angle at which it begins, within the period [rad].
        turned: angle by which the crank turns in it [rad].
        duration: its time [s].
        travel: way of the slide in it [m].
        height: height of the slide above bottom dead centre where it begins [m].
        lowest_speed: lowest speed of the slide in it, 0 at a dead centre [m/s].
        mean_speed: travel by duration [m/s].
        highest_speed: highest speed of the slide in it [m/s].
    """

    phase: str
    crank_angle: float
    turned: float
    duration: float
    travel: float
    height: float
    lowest_speed: float
    mean_speed: float
    highest_speed: float


@typed
def phases(motion: SlideMotion, length: float, downwards: bool = True) -> Records[StrokePhase]:
    """Approach, working part, run-out and return of a press that forms over a part of its stroke at nearly even speed.

    The working part is that part of the working stroke with this length over which the speed varies least, see `speed_variation`
    (`even_length` gives the length that keeps a variation). The approach leads to it from the dead centre, the run-out from it to the other
    dead centre; the return is the other stroke. (Chen 2002, fig. 3, divides the turn so.) The numbers of a complex motion are real.

    Args:
        motion: one period at constant speed.
        length: way over which the slide works, less than the stroke [m].
        downwards: whether the working stroke goes against the slide's direction.

    Returns:
        The four phases, in their order.

    Raises:
        PinpressError: a length that is not between 0 and the stroke; a motion that is not one period at constant speed, has too few states,
            no slide, or one that does not turn back, or turns back more than twice.
    """
    way, back = working_stroke(motion, downwards), working_stroke(motion, not downwards)
    start = evenest_window(way, inside_stroke(way.length, "length", length))[0]
    end = way.place_at(way.travel(np.array([start])) + length)[0]
    if not way.start.real < start.real < end.real < way.end.real:
        raise PinpressError(f"length is {length:g} m, nothing or the whole stroke but for rounding: give another")
    parts = (("approach", way, way.start, start), ("working", way, start, end), ("run-out", way, end, way.end))
    ends = [*parts, ("return", back, back.start, back.end)]
    return Records(StrokePhase, (_phase(motion, name, stroke, first.real, last.real, downwards) for name, stroke, first, last in ends))


def _phase(motion: SlideMotion, name: str, stroke: Stroke, first: float, last: float, downwards: bool) -> StrokePhase:
    """The part of a stroke between two places."""
    ends = np.array([first, last])
    extremes = stroke.speed_extremes.real
    places = np.concatenate([ends, extremes[(extremes > first) & (extremes < last)]])
    time, angle = step_time(motion).real, step_angle(motion)
    speeds = stroke.speed(places).real / time
    speeds[(places == stroke.start.real) | (places == stroke.end.real)] = 0.0  # at a dead centre, but for rounding
    travelled = stroke.travel(ends).real
    duration, travel = (last - first) * time, float(travelled[1] - travelled[0])
    falls = downwards is (name != "return")  # towards bottom dead centre
    height = stroke.length.real - travelled[0] if falls else travelled[0]
    period = abs(angle) * stroke.path.states
    return StrokePhase(
        name,
        float(np.asarray(motion.crank_angle)[0].real + angle * first) % period,
        (last - first) * abs(angle),
        duration,
        travel,
        float(max(height, 0.0)),
        float(speeds.min()),
        travel / duration,
        float(speeds.max()),
    )
