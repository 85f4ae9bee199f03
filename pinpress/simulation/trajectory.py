"""The solution of a simulation, readable at any time: a sequence of segments, each found by one solver."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from ..common.frozen import read_only
from ..common.quantities import Array

INTEGRALS = ("drive_work", "load_work", "motor_squared", "lost")
"""Integrals over time that are solved with the motion: work of the drive on the crank [J], work against the loads [J], motor torque squared
[N2 m2 s], energy lost in clutch, brake, and the friction of bearings [J]."""
DRIVE_WORK, LOAD_WORK, MOTOR_SQUARED, LOST = range(len(INTEGRALS))


class State(NamedTuple):
    """The state that a run has reached."""

    time: float  # [s]
    angle: float  # of the crank [rad]
    speed: float  # of the crank [rad/s]
    integrals: Array  # (4,) the `INTEGRALS` since the start of the run


class Sample(NamedTuple):
    """States at n times.

    Attributes:
        position: (size, n) of the crank alone, or of all joints [rad or m].
        speed: (size, n) [rad/s or m/s].
        acceleration: (size, n) [rad/s2 or m/s2].
        drive_torque: (n,) of the drive, at the driver joint [N m].
        motor_torque: (n,) of its motor, at the motor's own shaft [N m].
        drive_speed: (n,) of the drive's side of the clutch, at the driver joint [rad/s].
        drive_states: (k, n) the drive's own states.
        integrals: (4, n) the `INTEGRALS` since the start of the run.
    """

    position: Array
    speed: Array
    acceleration: Array
    drive_torque: Array
    motor_torque: Array
    drive_speed: Array
    drive_states: Array
    integrals: Array


class Segment(Protocol):
    """A part of a run, from one time to another [s]."""

    @property
    def start(self) -> float: ...
    @property
    def end(self) -> float: ...
    @property
    def borders(self) -> Array:
        """Rising times, its start and end among them, between which it is smooth [s]."""
        ...

    @property
    def jumps(self) -> Array:
        """Those of the borders at which a load or the drive may jump [s]."""
        ...

    @property
    def steps(self) -> int: ...
    @property
    def evaluations(self) -> int: ...
    @property
    def travelled(self) -> float:
        """Angle that the crank has turned, either way [rad]."""
        ...

    @property
    def fastest(self) -> float:
        """Largest size of the crank's speed where it was solved [rad/s]."""
        ...

    @property
    def solvers(self) -> tuple[str, ...]:
        """Names of the solvers that found it, see `Stats`."""
        ...

    @property
    def standing(self) -> float | None:
        """Time since which the press stands at the end, held by loads [s]; None if it does not stand."""
        ...

    def at(self, times: Array, complete: bool = True) -> Sample:
        """States at times (n,) within the segment; if not ``complete``, without accelerations, and with loops not closed again."""
        ...


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """A whole run.

    Attributes:
        segments: its parts, one after the other.
    """

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
        """Time since which the press stands at the end of the run, held by loads [s]; None if it does not stand."""
        return self.segments[-1].standing

    @property
    def turns(self) -> float:
        """Turns of the crank, in either direction."""
        return sum(segment.travelled for segment in self.segments) / (2 * np.pi)

    @property
    def fastest(self) -> float:
        """Largest size of the crank's speed where it was solved [rad/s]."""
        return max(segment.fastest for segment in self.segments)

    @cached_property
    def borders(self) -> Array:
        """Rising times, start and end among them, between which the run is smooth [s]."""
        return read_only(np.unique(np.concatenate([segment.borders for segment in self.segments])))

    @cached_property
    def jumps(self) -> Array:
        """Those of the borders at which a load or the drive may jump [s]."""
        return read_only(np.unique(np.concatenate([segment.jumps for segment in self.segments])))

    def at(self, times: Array, complete: bool = True) -> Sample:
        """States at rising times (n,); if not ``complete``, without accelerations, and with loops not closed again."""
        if len(self.segments) == 1 and complete:
            return self.segments[0].at(times)
        starts = np.array([segment.start for segment in self.segments])
        owner = np.clip(starts.searchsorted(times, side="right") - 1, 0, len(starts) - 1)
        cuts = np.flatnonzero(np.diff(owner)) + 1
        parts = [self.segments[int(owner[part[0]])].at(times[part], complete) for part in np.split(np.arange(len(times)), cuts)]
        if not complete:
            parts = [part._replace(acceleration=np.zeros((0, part.position.shape[1]))) for part in parts]
        return Sample(*(np.concatenate(rows, axis=-1) for rows in zip(*parts, strict=True)))


@dataclass(frozen=True, eq=False, repr=False)
class StandstillSegment:
    """A press that stands.

    Attributes:
        state: in which it stands, with the time from which it does.
        end: time to which it stands [s].
    """

    state: State
    end: float
    solvers = ("standstill",)
    standing = None
    steps = 0
    evaluations = 0
    travelled = 0.0
    fastest = 0.0

    @property
    def start(self) -> float:
        return self.state.time

    @property
    def borders(self) -> Array:
        return np.array([self.start, self.end])

    jumps = borders

    def at(self, times: Array, complete: bool = True) -> Sample:
        none = np.zeros((1, len(times)))
        return Sample(none + self.state.angle, none, none, none[0], none[0], none[0], none[:0], self.state.integrals[:, None] + none)


@dataclass(frozen=True, eq=False, repr=False)
class RepetitionSegment:
    """A press that swings to and fro between two stops under forces that do not depend on its speed, and repeats one swing.

    Attributes:
        swing: segments that contain a whole swing.
        first: time at which the crank stopped in one place [s].
        start: time at which it stopped in the same place again, from which on the swing is repeated [s].
        end: end of the repetition [s].
    """

    swing: Trajectory
    first: float
    start: float
    end: float
    solvers = ("repetition",)
    standing = None
    steps = 0
    evaluations = 0

    @property
    def travelled(self) -> float:
        swings = (self.end - self.start) / (self.start - self.first)
        return swings * sum(segment.travelled for segment in self.swing.segments)

    @property
    def fastest(self) -> float:
        return self.swing.fastest

    @property
    def borders(self) -> Array:
        return self._repeat(self.swing.borders)

    @property
    def jumps(self) -> Array:
        return self._repeat(self.swing.jumps)

    def _repeat(self, inner: Array) -> Array:
        """Times of the swing, again in every repetition [s]."""
        period = self.start - self.first
        inner = inner[(inner >= self.first) & (inner <= self.start)]
        count = np.arange(1, np.ceil((self.end - self.start) / period) + 1)
        times = np.concatenate([(inner + period * count[:, None]).ravel(), [self.start, self.end]])
        return np.unique(times[(times >= self.start) & (times <= self.end)])

    def at(self, times: Array, complete: bool = True) -> Sample:
        period = self.start - self.first
        swings = np.floor((times - self.first) / period)
        within = np.clip(times - swings * period, self.first, self.start)
        order = np.argsort(within, kind="stable")
        back = np.argsort(order, kind="stable")
        sample = Sample(*(rows[..., back] for rows in self.swing.at(within[order], complete)))
        squared = self.swing.at(np.array([self.first, self.start]), complete=False).integrals[MOTOR_SQUARED]
        sample.integrals[MOTOR_SQUARED] += swings * (squared[1] - squared[0])  # all work is given back
        return sample
