"""What engineers read off a run: speed drop, energy of motor and flywheel, recovery time, and what the motor has to bear."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from ..common.arguments import typed
from ..common.arrays import Array
from ..common.checks import is_number
from ..common.errors import PinpressError, shown
from ..common.results import Record, Records
from ..kinematics.dead_centres import stroke_turns
from .run import Run
from .trajectory import DRIVE_WORK, LOAD_WORK, LOST, MOTOR_SQUARED, Sample

ROUND = 1 + 1e-12  # rounding of times and turns
STATES = 720  # looked at in a stroke, for extremes


UNITS = {
    "start": "s",
    "duration": "s",
    "mean_speed": "rad/s",
    "highest_speed": "rad/s",
    "lowest_speed": "rad/s",
    "speed_drop": "-",
    "drive_work": "J",
    "load_work": "J",
    "lost": "J",
    "flywheel_work": "J",
    "recovery_time": "s",
    "motor_rms": "N m",
    "motor_peak": "N m",
    "utilisation": "-",
}


@dataclass(frozen=True, repr=False)
class Duty(Record, units=UNITS):
    """A stroke, or any other part of a run.

    Attributes:
        start, duration: [s].
        mean_speed: angle between start and end by the duration; highest_speed, lowest_speed: of the crank, sizes [rad/s].
        speed_drop: highest less lowest, beside the mean.
        drive_work: of the drive on the crank's shaft; load_work: against the loads; lost: in clutch and brake [J].
        flywheel_work: that flywheel and drive give off from the highest to the lowest speed, J (w1^2 - w2^2) / 2 [J].
        recovery_time: from the lowest speed to the highest, the part taken for periodic [s].
        motor_rms, motor_peak: of the motor's torque at its own shaft, sizes [N m].
        utilisation: rms by rated torque, the heating that a motor bears for good is 1; None where no rated torque is known.
    """

    start: float
    duration: float
    mean_speed: float
    highest_speed: float
    lowest_speed: float
    speed_drop: float
    drive_work: float
    load_work: float
    lost: float
    flywheel_work: float
    recovery_time: float
    motor_rms: float
    motor_peak: float
    utilisation: float | None


@typed
def duty(run: Run, start: float = 0.0, end: float | None = None) -> Duty:
    """What a run was to its motor and flywheel, from one time to another; by default in all.

    Extremes are those of 720 states a turn; works and means are exact.

    Raises:
        PinpressError: times that are not in the run, a linkage with several drivers.
    """
    _check(run)
    last = float(run.time[-1])
    until = last if end is None else end
    numbers = all(map(is_number, (start, until)))
    if not numbers or not 0.0 <= start < until <= last * ROUND:
        raise PinpressError(f"start is {shown(start)} and end {shown(end)}: give times within the run, 0 to {last:g} s")
    return _duties(run, np.array([start, min(until, last)]))[0]


@typed
def strokes(run: Run) -> Records[Duty]:
    """One `Duty` for each stroke, from the angle at which the run began on: for each full turn of the crank, or each several turns, where
    gears bring the slide back only after these (`DeadCentres.turns`). None where the crank does not turn as far.

    Raises:
        PinpressError: a linkage with several drivers.
    """
    _check(run)
    travelled = run.crank_angle - run.crank_angle[0]
    first = np.flatnonzero(travelled)
    if not len(first):
        return Records(Duty, ())
    direction = float(np.sign(travelled[first[0]]))
    travelled = direction * travelled
    back = np.flatnonzero(np.diff(travelled) < 0)  # strokes end where the crank turns back
    upto = int(back[0]) + 1 if len(back) else len(travelled)
    turns = stroke_turns(run.problem.driven.press)
    if turns is None:
        return Records(Duty, ())
    period = 2 * np.pi * turns
    turned = travelled[:upto] / period
    count = math.floor(float(turned[-1]) * ROUND + 1e-9)
    if count == 0:
        return Records(Duty, ())
    marks = np.arange(count + 1)
    times = np.interp(marks, turned, run.time[:upto])
    for _ in range(6):  # Newton's method on the path itself
        position, speed = _crank(run, run.trajectory.at(times, complete=False))
        late = position - (run.crank_angle[0] + direction * period * marks)
        step = np.where((marks > 0) & (speed != 0), late / np.where(speed == 0, 1.0, speed), 0.0)
        times = np.clip(times - step, 0.0, run.time[-1])
    return Records(Duty, _duties(run, times))


def _check(run: Run) -> None:
    """Raise PinpressError where it is no run of one driver."""
    if not isinstance(run, Run):
        raise PinpressError(f"run is {shown(run)}: give a Run, as simulate and steady_state return it (of scenarios one, runs[k])")
    if len(run.drivers) > 1:
        raise PinpressError("duty and strokes are those of a press with one driver")


def _duties(run: Run, times: Array) -> list[Duty]:
    """One for each interval between the times."""
    trajectory, drive, inertia = run.trajectory, run.problem.driven.drive, run.problem.driven.inertia
    ends = trajectory.at(times, complete=False)
    angles = _crank(run, ends)[0]
    rated = None if drive is None else drive.rated_torque
    result = []
    for k, (start, end) in enumerate(itertools.pairwise(times)):
        net = abs(float(angles[k + 1] - angles[k]))
        count = STATES * max(1, math.ceil(net / (2 * np.pi) - 1e-9)) + 1
        inner = np.linspace(start, end, count)
        sample = trajectory.at(inner, complete=False)
        speed = np.abs(_crank(run, sample)[1])
        highest, lowest = int(speed.argmax()), int(speed.argmin())
        gained = ends.integrals[:, k + 1] - ends.integrals[:, k]
        duration = float(end - start)
        own = np.abs(sample.drive_speed)
        rms = math.sqrt(max(0.0, float(gained[MOTOR_SQUARED])) / duration)
        mean = net / duration
        result.append(
            Duty(
                start=float(start),
                duration=duration,
                mean_speed=mean,
                highest_speed=float(speed[highest]),
                lowest_speed=float(speed[lowest]),
                speed_drop=float(speed[highest] - speed[lowest]) / mean if mean else 0.0,
                drive_work=float(gained[DRIVE_WORK]),
                load_work=float(gained[LOAD_WORK]),
                lost=float(gained[LOST]),
                flywheel_work=0.5 * inertia * float(own.max() ** 2 - own.min() ** 2),
                recovery_time=float((inner[highest] - inner[lowest]) % duration),
                motor_rms=rms,
                motor_peak=float(np.abs(sample.motor_torque).max()),
                utilisation=None if rated is None else rms / float(np.ravel(rated)[0]),
            )
        )
    return result


def _crank(run: Run, sample: Sample) -> tuple[Array, Array]:
    """Angle and speed (n,) of the crank."""
    place = run.problem.driven.press.driver_indices[0] if len(sample.position) > 1 else 0
    return sample.position[place], sample.speed[place]
