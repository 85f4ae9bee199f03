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
from .state_curve import state_curve

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

    A quintic connects two states of the motion. It has the angles, speeds and accelerations of both states; for heights those of the slide.
    For a table over a master axis see `cam_table`.

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
    if of == "angle":
        states, scale = (motion.angle, motion.speed, motion.acceleration), 180 / math.pi
    else:
        states, scale = (motion.height, motion.motion.slide_velocity, motion.motion.slide_acceleration), 1e3
    time: Array = width * np.arange(count + 1, dtype=float)
    end = motion.duration
    if time[-1] > end * (1 + SAME):
        time[-1] = end
    sampled = state_curve(motion.time - motion.time[0], *states).at(time)[0]
    return MotionTable(motion.press_name, of, time, scale * sampled)  # type: ignore[arg-type]  # checked above
