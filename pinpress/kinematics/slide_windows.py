"""Windows of the crank angle in which the slide is above a height, or within other heights on one of its ways."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import typed
from ..common.quantities import Array
from ..common.results import Record, Records
from .even_speed import inside_stroke
from .periodic_curve import step_angle, step_time
from .slide_path import SlideMotion, slide_path

ROUNDING = 1e-12  # of a slide position, as a share of the stroke


@dataclass(frozen=True, repr=False)
class AngleWindow(Record, units={"crank_angle": "rad", "ends_at": "rad", "turned": "rad", "duration": "s"}):
    """A window of the crank angle.

    Attributes:
        name: what happens in it.
        crank_angle: crank angle at which it begins, within the period [rad].
        ends_at: crank angle at which it ends, within the period; less than the beginning if it goes through the period's end [rad].
        turned: angle by which the crank turns in the window [rad].
        duration: its time [s].
    """

    name: str
    crank_angle: float
    ends_at: float
    turned: float
    duration: float


@typed
def windows(motion: SlideMotion, above: float) -> Records[AngleWindow]:
    """Windows in which the slide is above a height, such as that at which a strip can be fed: one a stroke, through top dead centre.

    The ends are roots of the slide's path, not places of states. If the slide repeats its motion within the period, the windows are those
    of the first repetition.

    Args:
        motion: one period at constant speed.
        above: height above bottom dead centre [m].

    Returns:
        The windows, each from where the slide rises through the height.

    Raises:
        PinpressError: a height that is not between 0 and the stroke; a motion that is not one period at constant speed, has too few states,
            no slide, or one that does not turn back.
    """
    path = slide_path(motion)
    least, most = path.extremes()
    level = least.real + inside_stroke(most - least, "above", above)
    return Records(AngleWindow, windows_where(motion, "die open", [level], lambda position, downwards: position > level))


def windows_where(
    motion: SlideMotion, name: str, levels: Iterable[float], holds: Callable[[Array, NDArray[np.bool_]], NDArray[np.bool_]]
) -> Iterator[AngleWindow]:
    """Windows where a condition holds that changes only at slide positions ``levels`` [m] and where the slide turns back.

    Args:
        motion: one period at constant speed.
        name: of the windows.
        levels: slide positions [m].
        holds: takes slide positions (m,) [m] and whether the slide moves downwards (m,); returns where the condition holds.
    """
    path = slide_path(motion)
    period, (lowest, highest) = path.states, (end.real for end in path.extremes())
    rounding = ROUNDING * (highest - lowest)  # a level at a dead centre is not passed
    levels = [level for level in levels if lowest + rounding < level < highest - rounding]
    nodes = np.unique(np.concatenate([path.turning_places.real % period, *(path.crossings(level).real % period for level in levels)]))
    ends = np.append(nodes[1:], nodes[0] + period)
    position, speed = (part.real for part in path.at(0.5 * (nodes + ends), 1))
    inside = holds(position, speed < 0)
    if inside.all():
        yield window(motion, name, float(np.asarray(motion.crank_angle)[0].real), period)
    for k in np.flatnonzero(inside & ~np.roll(inside, 1)):
        lasts = int(np.argmin(np.roll(inside, -k)))  # number of pieces until the condition ends
        until = (ends[(k + lasts - 1) % len(nodes)] - nodes[k]) % period
        yield window(motion, name, float(np.asarray(motion.crank_angle)[0].real + step_angle(motion) * nodes[k]), float(until))


def window(motion: SlideMotion, name: str, begins: float, states: float) -> AngleWindow:
    """The window that begins at an angle [rad] and lasts for a number of steps from state to state."""
    step = step_angle(motion)
    period = 2 * math.pi * (motion.period_turns or 1)
    return AngleWindow(name, begins % period, (begins + step * states) % period, abs(step) * states, step_time(motion).real * states)
