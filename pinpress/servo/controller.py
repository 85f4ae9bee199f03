"""Tables for the controller of a servo press: the crank's angle, or the slide's height, in equal steps of time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..common.arguments import expect, positive, typed
from ..common.errors import PinpressError, shown
from ..common.quantities import Array
from ..common.results import Tabular
from .motion import MOST_STATES, ServoMotion

SAME = 1e-9  # share of the cycle: states that are closer in time count as one instant


@dataclass(frozen=True, eq=False, repr=False)
class MotionTable(Tabular):
    """A motion in equal steps of time, from the beginning of a cycle to its end.

    Attributes:
        press_name: name of the press.
        of: "angle" or "height".
        time: (n,) times [s].
        values: (n,) unwrapped crank angles [deg], or heights of the slide above bottom dead centre [mm].
    """

    press_name: str
    of: Literal["angle", "height"]
    time: Array
    values: Array

    @property
    def title(self) -> str:
        """The press, the tabulated quantity, the number of rows and the time of a cycle."""
        return f"MotionTable of {self.press_name}: {self.of} at {len(self.time)} times, {self.time[-1]:.6g} s"

    def columns(self) -> dict[str, Array]:
        """Time and angle, or time and height, in units of controllers: s, deg, mm. In a job, a table of angles can be the ``program`` of a
        servo motor."""
        return {"time [s]": self.time, "angle [deg]" if self.of == "angle" else "height [mm]": self.values}


@typed
def controller_table(motion: ServoMotion, of: str = "angle", *, step: float = 1e-3) -> MotionTable:
    """A motion as a table for a controller.

    A cubic connects two states of the motion. It has the angles and speeds of both states, and is exact for a constant acceleration. For
    heights it has the slide's heights and speeds.

    Args:
        motion: the motion.
        of: "angle" of the crank, or "height" of the slide.
        step: time between two rows; the last step may be shorter [s].

    Raises:
        PinpressError: ``of`` is neither "angle" nor "height", or the table would have more than a million rows.
    """
    expect("motion", motion, ServoMotion, "servo.evaluate or best_motion")
    if not isinstance(of, str) or of not in ("angle", "height"):
        raise PinpressError(f"of is {shown(of)}: give 'angle' or 'height'")
    width = positive("step", step, "s")
    count = math.ceil(motion.duration / width * (1 - SAME))
    if not count < MOST_STATES:
        raise PinpressError(f"step is {width:g} s: a cycle of {motion.duration:g} s would have {count} rows; give a longer step")
    from scipy.interpolate import CubicHermiteSpline  # to save start-up time

    kept = np.append(np.diff(motion.time) > SAME * motion.duration, True)
    if of == "angle":
        values, rates, scale = motion.angle, motion.speed, 180 / math.pi
    else:
        values, rates, scale = motion.height, motion.motion.slide_velocity, 1e3
    start = motion.time[kept][0]
    time, end = width * np.arange(count + 1), float(motion.time[-1] - start)
    if time[-1] > end * (1 + SAME):
        time[-1] = end
    sampled = CubicHermiteSpline(motion.time[kept] - start, values[kept], rates[kept])(np.minimum(time, end))
    return MotionTable(motion.press_name, of, time, scale * sampled)  # type: ignore[arg-type]  # checked above
