"""What a simulation went through, readable at any time: segments solved over the crank angle, and segments integrated over time."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from ..common.arrays import Array

LEDGERS = ("drive_work", "load_work", "motor_squared", "lost")
"""What is summed up: work of the drive on the crank [J], work against the loads [J], motor torque squared over time [N2 m2 s], energy lost
in clutch and brake [J]."""
DRIVE_WORK, LOAD_WORK, MOTOR_SQUARED, LOST = range(len(LEDGERS))


class Reading(NamedTuple):
    """States at n times.

    Attributes:
        position, speed, acceleration: (size, n) of the crank alone, or of all joints.
        torque: (n,) of the drive; motor: of its motor, at the motor's own shaft. own: (n,) speed of its side of the clutch [rad/s].
        ledgers: (4, n).
    """

    position: Array
    speed: Array
    acceleration: Array
    torque: Array
    motor: Array
    own: Array
    ledgers: Array


class Segment(Protocol):
    """A part of a run, from one time to another."""

    @property
    def start(self) -> float: ...
    @property
    def end(self) -> float: ...
    @property
    def steps(self) -> int: ...
    @property
    def evaluations(self) -> int: ...
    @property
    def travelled(self) -> float:
        """Angle that the crank has turned, either way [rad]."""
        ...

    @property
    def solvers(self) -> tuple[str, ...]:
        """What it was found by."""
        ...

    @property
    def standing(self) -> float | None:
        """Since when the press stands at the end, held by loads [s]; None where it does not."""
        ...

    def read(self, times: Array, whole: bool = True) -> Reading:
        """States at times (n,) within the segment; where it is not needed ``whole``, without accelerations, and loops not closed anew."""
        ...


@dataclass(frozen=True, eq=False, repr=False)
class Path:
    """The segments of a run, one after the other."""

    segments: Sequence[Segment]

    @property
    def steps(self) -> int:
        return sum(segment.steps for segment in self.segments)

    @property
    def evaluations(self) -> int:
        return sum(segment.evaluations for segment in self.segments)

    @property
    def solvers(self) -> tuple[str, ...]:
        """What it was found by, in the order in which they came."""
        return tuple(dict.fromkeys(solver for segment in self.segments for solver in segment.solvers))

    @property
    def standing(self) -> float | None:
        """Since when the press stands at the end of the run, held by loads [s]; None where it does not."""
        return self.segments[-1].standing

    @property
    def turns(self) -> float:
        """Turns of the crank, those back counted too."""
        return sum(segment.travelled for segment in self.segments) / (2 * np.pi)

    def read(self, times: Array, whole: bool = True) -> Reading:
        """States at rising times (n,); where it is not needed ``whole``, without accelerations, and loops not closed anew."""
        starts = np.array([segment.start for segment in self.segments])
        owner = np.clip(starts.searchsorted(times, side="right") - 1, 0, len(starts) - 1)
        cuts = np.flatnonzero(np.diff(owner)) + 1
        parts = [self.segments[int(owner[part[0]])].read(times[part], whole) for part in np.split(np.arange(len(times)), cuts)]
        if not whole:
            parts = [part._replace(acceleration=np.zeros((0, part.position.shape[1]))) for part in parts]
        return Reading(*(np.concatenate(rows, axis=-1) for rows in zip(*parts, strict=True)))
