"""What an engineer reads off a run: speed drop, works, the duty of motor and flywheel, and what the motor takes from the mains."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from ..common.arguments import is_number, number, typed
from ..common.errors import PinpressError, shown
from ..common.quantities import Array
from ..common.results import Record, Records
from ..drives.direct_current_link import DirectCurrentLink
from ..drives.transmission import Geared
from ..kinematics.slide_path import slide_turns, stroke_turns
from .motor_energy import ChargedLink, EnergyFlow, duty_of_motor, motor_energy_of
from .run import Run
from .trajectory import DRIVE_WORK, LOAD_WORK, LOST, MOTOR_SQUARED, Sample

ROUND = 1 + 1e-12  # rounding of times and turns

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
    "mains_work": "J",
    "slip_loss": "J",
    "efficiency": "-",
    "settled_rise": "K",
}


OVER_TRAVEL = UNITS | dict.fromkeys(("mean_speed", "highest_speed", "lowest_speed"), "m/s")  # of a driver that slides


@dataclass(frozen=True, repr=False)
class MotorDuty(Record, units=UNITS):
    """The duty of motor and flywheel in a stroke, or in any other part of a run.

    Attributes:
        start: [s].
        duration: [s].
        mean_speed: angle between start and end by the duration [rad/s].
        highest_speed: largest size of the crank's speed [rad/s].
        lowest_speed: smallest size of the crank's speed [rad/s].
        speed_drop: highest less lowest speed, as a share of the mean.
        drive_work: work of the drive on the crank's shaft [J].
        load_work: work against the loads [J].
        lost: energy lost in clutch, brake, and the friction of bearings and guides [J].
        flywheel_work: work that flywheel and drive give off from the highest to the lowest speed, J (w1^2 - w2^2) / 2 [J].
        recovery_time: time from the lowest speed to the highest, if the part were periodic [s].
        motor_rms: root mean square of the motor's torque at its own shaft [N m].
        motor_peak: largest size of the motor's torque at its own shaft [N m].
        utilisation: rms by rated torque; at 1 the motor is as warm as it may be for good. None if no rated torque is known.
        mains_work: energy from the mains [J]; None if the drive is no motor whose losses are known.
        slip_loss: of it lost by slip, in the rotor or in the slip clutch [J]; None in the same case.
        efficiency: work of the drive by that from the mains; None in the same case, and if one of them is not positive.
        settled_rise: temperature rise of the motor if the part is repeated for good [K]; None if its time constant is not known.
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
    mains_work: float | None
    slip_loss: float | None
    efficiency: float | None
    settled_rise: float | None


@dataclass(frozen=True, repr=False)
class ScrewDuty(MotorDuty, units=OVER_TRAVEL):
    """The duty of a motor behind a screw, whose nut is a driver that slides: attributes of `MotorDuty`, speeds of the driver [m/s]."""


@dataclass(frozen=True, repr=False)
class ForceDuty(MotorDuty, units=OVER_TRAVEL | {"motor_rms": "N", "motor_peak": "N"}):
    """The duty of a drive without a shaft on a driver that slides: attributes of `MotorDuty`, speeds [m/s], the drive's force [N]."""


@typed
def duty_cycle(run: Run, start: float = 0.0, end: float | None = None) -> MotorDuty:
    """The duty of motor and flywheel of a run.

    Extremes are searched from 720 states a turn and from the edges at which a load or the drive is not smooth; works and means are exact.

    Args:
        run: of a press with one driver.
        start: time from which on it counts [s].
        end: time up to which it counts [s]; None: to the end of the run.

    Raises:
        PinpressError: the times are not in the run, or the linkage has several drivers.
    """
    _check(run)
    last = float(run.time[-1])
    until = last if end is None else end
    numbers = all(map(is_number, (start, until)))
    if not numbers or not 0.0 <= start < until <= last * ROUND:
        raise PinpressError(f"start is {shown(start)} and end {shown(end)}: give times within the run, 0 to {last:g} s")
    return _duties(run, np.array([start, min(until, last)]))[0]


@typed
def stroke_duties(run: Run) -> Records[MotorDuty]:
    """One `MotorDuty` for each stroke, counted from the crank angle at the start of the run.

    A stroke takes one turn of the crank, or several, or a part of one, where gears bring the slide back after these (`DeadCentres.turns`).
    Strokes that differ, as under a knuckle that passes its straight position, are taken together. There is none where the crank does not
    turn that far, or where the driver slides.

    Raises:
        PinpressError: the linkage has several drivers.
    """
    _check(run)
    turns = slide_turns(run.problem.driven.press)
    turning = run.driver_coordinates[0].turns
    marks = np.zeros(0) if turns is None or not turning else _stroke_ends(run, 2 * np.pi * turns)
    return Records(MotorDuty, _duties(run, marks) if len(marks) else ())


@typed
def motor_energy(
    run: Run, *, initial_rise: float | None = None, link: DirectCurrentLink | None = None, initial_voltage: float | None = None
) -> EnergyFlow:
    """What the motor of a run takes from the mains, where it goes, and how warm the motor becomes.

    The motor is an `InductionMotor`, `InverterMotor`, `SlipClutchMotor` or `ServoMotor`, behind gears or not; its losses are those of its
    model and of its data sheet, see there. A drive of your own tells them by a method ``power``, see `pinpress.drives.Drive`.

    Args:
        run: of a press with one driver.
        initial_rise: temperature rise of the motor at the start [K]; None: that to which it comes back at the end, as in a stroke that
            has been repeated for good.
        link: direct-current link of finite size between mains and motor, which feeds nothing back to the mains; None: what braking gives
            back, the motor's own `regeneration`, is used somewhere.
        initial_voltage: of the link at the start [V], at most its upper one; None: that to which it comes back at the end.

    Raises:
        PinpressError: the drive is no such motor, the linkage has several drivers, or the temperature is not known; the motor has no link
            or gives nothing back to it, the link falls below its lower voltage, or it cannot start at a voltage.

    Warns:
        PinpressWarning: the capacitor of the link does nothing.
    """
    _check(run)
    store = None if link is None and initial_voltage is None else _charged_link(link, initial_voltage)
    driven, first = run.problem.driven, run.driver_coordinates[0]
    turns = stroke_turns(driven.press) if first.turns else None
    strokes = None if turns is None else abs(float(run.crank_angle[-1] - run.crank_angle[0])) / (2 * np.pi * turns)
    rise = None if initial_rise is None else number("initial_rise", initial_rise, "K")
    return motor_energy_of(driven, np.array(run.time), run.trajectory, strokes, rise, store)


def _charged_link(link: DirectCurrentLink | None, initial_voltage: float | None) -> ChargedLink:
    """A link with the voltage at which it starts; raises PinpressError where it cannot."""
    if link is None:
        raise PinpressError("initial_voltage is of a direct-current link: give link=pp.drives.DirectCurrentLink(...) too, or leave it out")
    if initial_voltage is None:
        return ChargedLink(link, None)
    voltage = number("initial_voltage", initial_voltage, "V")
    least = link.charged_voltage if link.mains_power is None else link.lower_voltage
    if not least <= voltage <= link.upper_voltage:
        raise PinpressError(f"initial_voltage is {voltage:g} V: give one from {least:g} to {link.upper_voltage:g} V, those of the link")
    return ChargedLink(link, voltage)


def _stroke_ends(run: Run, period: float) -> Array:
    """Times of the start and of the ends of the strokes; none where there is no stroke. ``period``: crank angle of a stroke [rad]."""
    travelled = run.crank_angle - run.crank_angle[0]
    first = np.flatnonzero(travelled)
    if not len(first):
        return np.zeros(0)
    direction = float(np.sign(travelled[first[0]]))
    travelled = direction * travelled
    back = np.flatnonzero(np.diff(travelled) < 0)  # strokes end where the crank turns back
    upto = int(back[0]) + 1 if len(back) else len(travelled)
    turned = travelled[:upto] / period
    count = math.floor(float(turned[-1]) * ROUND + 1e-9)
    if count == 0:
        return np.zeros(0)
    marks = np.arange(count + 1)
    times = np.interp(marks, turned, run.time[:upto])
    for _ in range(6):  # Newton's method on the trajectory itself
        position, speed = _crank(run, run.trajectory.at(times, complete=False))
        late = position - (run.crank_angle[0] + direction * period * marks)
        step = np.where((marks > 0) & (speed != 0), late / np.where(speed == 0, 1.0, speed), 0.0)
        times = np.clip(times - step, 0.0, run.time[-1])
    return times


def _check(run: Run) -> None:
    """Raise PinpressError where it is no run of a press with one driver."""
    if not isinstance(run, Run):
        raise PinpressError(f"run is {shown(run)}: give a Run, as simulate and steady_state return it (of scenarios one, runs[k])")
    if len(run.drivers) > 1:
        several = f"{run.linkage} has {len(run.drivers)} drivers"
        raise PinpressError(
            f"{several}, but strokes, duties and motor_energy are those of a press with one driver: see drive_torque, drive_speed and"
            " drive_work of the run"
        )


def _duties(run: Run, times: Array) -> list[MotorDuty]:
    """One duty for each interval between the times."""
    ends = run.trajectory.at(times, complete=False)
    angles, gained = np.abs(np.diff(_crank(run, ends)[0])).tolist(), np.diff(ends.integrals)
    parts = zip(itertools.pairwise(times.tolist()), angles, gained.T, strict=True)
    return [_duty(run, start, end, angle, gains) for (start, end), angle, gains in parts]


def _duty(run: Run, start: float, end: float, angle: float, gained: Array) -> MotorDuty:
    """The duty from one time to another; ``angle``: that the crank turns [rad], ``gained``: (4,) growth of the `INTEGRALS`."""
    drive, inertia = run.problem.driven.drive, run.problem.driven.inertia
    even, edges = np.linspace(start, end, 720 * max(1, math.ceil(angle / (2 * np.pi) - 1e-9)) + 1), run.trajectory.borders
    # the crank is slowest where a blank breaks through, which is on an edge
    inner = np.union1d(even, edges[edges.searchsorted(start, "right") : edges.searchsorted(end)])
    inner = _with_peaks(run, inner)
    sample = run.trajectory.at(inner, complete=False)
    speed, drive_speed = np.abs(_crank(run, sample)[1]), np.abs(sample.drive_speed)
    highest, lowest = int(speed.argmax()), int(speed.argmin())
    duration = end - start
    mean, rms = angle / duration, math.sqrt(max(0.0, float(gained[MOTOR_SQUARED])) / duration)
    rated = None if drive is None else drive.rated_torque
    kind = MotorDuty if run.driver_coordinates[0].turns else ScrewDuty if isinstance(drive, Geared) else ForceDuty
    return kind(
        start=start,
        duration=duration,
        mean_speed=mean,
        highest_speed=float(speed[highest]),
        lowest_speed=float(speed[lowest]),
        speed_drop=float(speed[highest] - speed[lowest]) / mean if mean else 0.0,
        drive_work=float(gained[DRIVE_WORK]),
        load_work=float(gained[LOAD_WORK]),
        lost=float(gained[LOST]),
        flywheel_work=0.5 * inertia * float(drive_speed.max() ** 2 - drive_speed.min() ** 2),
        recovery_time=float((inner[highest] - inner[lowest]) % duration),
        motor_rms=rms,
        motor_peak=float(np.abs(sample.motor_torque).max()),
        utilisation=None if rated is None else rms / float(np.ravel(rated)[0]),
        **duty_of_motor(run.problem.driven, run.trajectory, start, end),
    )


def _with_peaks(run: Run, times: Array) -> Array:
    """Times with grids that close in on the highest and lowest speed and on the largest torque of the motor."""
    near = times
    for _ in range(3):  # a smooth extreme is flat: 2e-4 of a step in time are 1e-8 of the change in a step
        sample = run.trajectory.at(near, complete=False)
        speed, torque = np.abs(_crank(run, sample)[1]), np.abs(sample.motor_torque)
        places = (int(speed.argmax()), int(speed.argmin()), int(torque.argmax()))
        near = np.unique([np.linspace(near[max(k - 1, 0)], near[min(k + 1, len(near) - 1)], 33) for k in places])
        times = np.union1d(times, near)
    return times


def _crank(run: Run, sample: Sample) -> tuple[Array, Array]:
    """Angle and speed (n,) of the crank."""
    place = run.problem.driven.press.driver_indices[0] if len(sample.position) > 1 else 0
    return sample.position[place], sample.speed[place]
