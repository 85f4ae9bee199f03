"""A motion of a servo press and the torque it needs from its drive, by full inverse dynamics.

The drive drives the linkage, accelerates rotor and gears, and overcomes the drag of the motor:

    torque at the crank = driving torque + crank_inertia x acceleration + crank_drag x speed
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import expect, numbers, typed
from ..common.errors import PinpressError
from ..common.frozen import read_only
from ..common.quantities import Array
from ..common.results import Tabular
from ..dynamics.inverse_dynamics import NONE_GIVEN, inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.cycle import moved
from ..kinematics.motion import Motion
from ..kinematics.slide_path import dead_centres
from ..linkage.assembly import refuse_far
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Friction, Load
from .drive import ServoDrive
from .limits import CrankAcceleration, CrankSpeed, RmsTorque, SlideAcceleration, SlideSpeed, StateLimit, span

AMISS = 0.02  # share of the range of angles (speeds) by which they may differ from the integral of speeds (accelerations)
MOST_STATES = 10**6


@dataclass(frozen=True, eq=False, repr=False)
class ServoMotion(OfPress, Tabular):
    """One cycle of a servo press in n states, from its start to its end, and what it needs from the drive. All arrays are read-only.

    Torques and powers are those of the motor. They include the torque that accelerates its rotor and the torque that overcomes its drag.
    A positive torque acts in the positive direction of the crank. A positive power drives.

    Attributes:
        press_name: name of the press.
        drive: the drive.
        motion: the motion of the linkage, in the same states.
        time: (n,) time, never falling [s].
        weight: (n,) weight of each state in integrals over time [s].
        angle: (n,) crank angle, unwrapped [rad].
        speed: (n,) speed of the crank [rad/s].
        acceleration: (n,) acceleration of the crank [rad/s2].
        height: (n,) height of the slide above bottom dead centre [m].
        torque: (n,) torque of the motor at the crank: gear ratio x torque at the motor's shaft [N m].
    """

    _press: Linkage
    drive: ServoDrive
    motion: Motion
    time: Array
    weight: Array
    angle: Array
    speed: Array
    acceleration: Array
    height: Array
    torque: Array

    @property
    def title(self) -> str:
        return (
            f"ServoMotion of {self.press_name}: {self.duration:.6g} s, torque at the crank {self.rms_torque:.6g} N m rms, at most"
            f" {self.peak_torque:.6g} N m, power at most {1e-3 * self.peak_power:.6g} kW"
        )

    @cached_property
    def motor_torque(self) -> Array:
        """(n,) torque of the motor at the motor's shaft [N m]."""
        return read_only(self.torque / self.drive.ratio)

    @cached_property
    def motor_speed(self) -> Array:
        """(n,) speed of the motor [rad/s]."""
        return read_only(self.speed * self.drive.ratio)

    @cached_property
    def power(self) -> Array:
        """(n,) mechanical power of the motor [W]."""
        return read_only(self.torque * self.speed)

    @cached_property
    def mains_power(self) -> Array:
        """(n,) electrical power: mechanical power + heat in windings and iron [W]. It is negative when braking gives power back."""
        drive = self.drive
        return read_only(self.power + drive.copper * self.motor_torque**2 + drive.iron * self.motor_speed**2)

    @property
    def duration(self) -> float:
        """Time of the cycle, rests included [s]."""
        return float(self.time[-1] - self.time[0])

    @property
    def heat(self) -> float:
        """Integral over time of the squared torque at the crank [N2 m2 s]."""
        return float(self.weight @ self.torque**2)

    @property
    def rms_torque(self) -> float:
        """Rms torque at the crank over the cycle [N m]; ``rms_motor_torque`` is the one at the motor."""
        return float(np.sqrt(self.heat / self.duration))

    @property
    def rms_motor_torque(self) -> float:
        """Rms torque at the motor's shaft over the cycle, to compare with the motor's rated torque [N m]."""
        return self.rms_torque / self.drive.ratio

    @property
    def peak_torque(self) -> float:
        """Largest absolute torque at the crank [N m]."""
        return float(np.abs(self.torque).max())

    @property
    def peak_motor_torque(self) -> float:
        """Largest absolute torque at the motor's shaft [N m]."""
        return self.peak_torque / self.drive.ratio

    @property
    def peak_power(self) -> float:
        """Largest absolute mechanical power [W]."""
        return float(np.abs(self.power).max())

    @property
    def work(self) -> float:
        """Mechanical work of the motor in the cycle [J]."""
        return float(self.weight @ self.power)

    @property
    def energy_drawn(self) -> float:
        """Energy drawn from the mains in the cycle, less the share ``regeneration`` of the energy given back [J]."""
        returned = np.minimum(self.mains_power, 0.0)
        return float(self.weight @ (np.maximum(self.mains_power, 0.0) + self.drive.regeneration * returned))

    def columns(self) -> dict[str, Array]:
        """Time, crank, slide and drive as (n,) columns under their names with units."""
        return {
            "time [s]": self.time,
            "crank_angle [rad]": self.angle,
            "crank_speed [rad/s]": self.speed,
            "crank_acceleration [rad/s2]": self.acceleration,
            "height [m]": self.height,
            "slide_velocity [m/s]": self.motion.slide_velocity,
            "slide_acceleration [m/s2]": self.motion.slide_acceleration,
            "torque [N m]": self.torque,
            "motor_torque [N m]": self.motor_torque,
            "motor_speed [rad/s]": self.motor_speed,
            "power [W]": self.power,
            "mains_power [W]": self.mains_power,
        }


@typed
def evaluate(
    press: Linkage,
    drive: ServoDrive,
    loads: Sequence[Load] = (),
    *,
    time: ArrayLike,
    angle: ArrayLike,
    speed: ArrayLike,
    acceleration: ArrayLike,
    friction: Mapping[str, Friction] = NONE_GIVEN,
) -> ServoMotion:
    """Compute what a motion of the crank needs from a drive, by full inverse dynamics.

    Integrals over time follow the trapezoidal rule between the states.

    Args:
        press: the press, with one crank.
        drive: the drive.
        loads: as in `inverse_dynamics`.
        time: (n,) rising times of one cycle; a motion that repeats ends with the state in which it starts [s].
        angle: (n,) crank angles, unwrapped [rad].
        speed: (n,) speeds of the crank, or one number [rad/s].
        acceleration: (n,) accelerations of the crank, or one number [rad/s2].
        friction: as in `inverse_dynamics`.

    Raises:
        PinpressError: the driver slides, the columns differ in length, time does not rise, or angle, speed and acceleration contradict one
            another; also as `inverse_dynamics`.
        SingularityError: the linkage locks within the motion.
    """
    expect("drive", drive, ServoDrive, "servo.ServoDrive")
    times = numbers("time", time, (None,), unit="s")
    if not 2 <= len(times) <= MOST_STATES or not np.all(np.diff(times) > 0):
        raise PinpressError(f"time does not have 2 to {MOST_STATES} rising values: give rising times [s]")
    columns = [
        _column(name, values, unit, len(times))
        for name, values, unit in (("angle", angle, "rad"), ("speed", speed, "rad/s"), ("acceleration", acceleration, "rad/s2"))
    ]
    _refuse_misfit(times, *columns)
    steps = np.diff(times)
    weight = 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))
    return evaluated(press, drive, loads, times, weight, columns[0], columns[1], columns[2], friction)[0]


def evaluated(
    press: Linkage,
    drive: ServoDrive,
    loads: Sequence[Load],
    time: Array,
    weight: Array,
    angle: Array,
    speed: Array,
    acceleration: Array,
    friction: Mapping[str, Friction] = NONE_GIVEN,
    bearings: Sequence[str] | None = (),
) -> tuple[ServoMotion, Reactions]:
    """The motion in states (n,), with the weights of a quadrature over time, and its reactions; other arguments and errors as `evaluate`.

    Args:
        press: the press.
        drive: the drive.
        loads: the loads.
        time: (n,) never falling [s].
        weight: (n,) [s].
        angle: (n,) [rad].
        speed: (n,) [rad/s].
        acceleration: (n,) [rad/s2].
        friction: friction of bearings.
        bearings: names of the bearings whose forces are computed; None: all.
    """
    press.refuse_sliding_driver("servo motions need a crank; give positions over time to servo_cycle")
    press.refuse_several_drivers("servo motions need one crank; give the angles of all cranks over time to servo_cycle")
    bottom = dead_centres(press).bottom_position
    refuse_far("angle", angle, press.driver_coordinates)
    motion = moved(press, press.branch, angle, speed, acceleration, time, "auto")
    reactions = inverse_dynamics(press, motion, loads, friction, bearings=bearings)
    torque = reactions.driving_torque + drive.crank_inertia * acceleration + drive.crank_drag * speed
    height = motion.slide_position - bottom
    return ServoMotion(press, drive, motion, time, weight, angle, speed, acceleration, height, torque), reactions


def _column(name: str, values: ArrayLike, unit: str, count: int) -> Array:
    column = numbers(name, values, unit=unit)
    if column.shape not in ((), (count,)):
        raise PinpressError(f"{name} has shape {column.shape}, but time has {(count,)}: give one value for each time")
    if not column.ndim and name == "angle":
        raise PinpressError(f"angle is one number: give {count} crank angles, one for each time [rad]")
    return np.array(np.broadcast_to(column, count))


def _refuse_misfit(time: Array, angle: Array, speed: Array, acceleration: Array) -> None:
    """Raise PinpressError if a column is far from the integral of its rate."""
    both = ("angle", angle, "speed", speed, "rad"), ("speed", speed, "acceleration", acceleration, "rad/s")
    for name, values, rate_name, rates, unit in both:
        summed = np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(time))])
        off = np.abs(values - values[0] - summed)
        range_ = max(float(np.ptp(values)), float(np.abs(values).max()) if name == "speed" else 0.0)
        if not off.max() <= AMISS * range_ and off.max() > 0:
            worst = int(off.argmax())
            raise PinpressError(
                f"{name} and {rate_name} do not fit together: at {time[worst]:.6g} s {name} differs by {off[worst]:.3g} {unit} from the"
                " integral"
                f" of {rate_name}; give more states, or the {rate_name} of this {name}"
            )


def largest_size(motion: ServoMotion, limit: StateLimit | RmsTorque) -> tuple[float, float]:
    """The largest absolute value of the limited quantity, within the limit's heights and flank, and the limit's value."""
    if isinstance(limit, RmsTorque):
        most = motion.drive.rated_torque if limit.torque is None else limit.torque
        if most is None:
            raise PinpressError("RmsTorque has no torque, and the drive of a motion has no rated_torque: give RmsTorque(torque)")
        return motion.rms_motor_torque, most
    if isinstance(limit, CrankAcceleration):
        return float(np.abs(motion.acceleration).max()), limit.acceleration
    low, high = span(limit)
    down = motion.motion.slide_velocity < 0
    inside = (motion.height > low) & (motion.height < high)
    inside &= True if limit.flank == "both" else down if limit.flank == "down" else ~down
    most = limit.acceleration if isinstance(limit, SlideAcceleration) else limit.speed
    values = {SlideSpeed: motion.motion.slide_velocity, CrankSpeed: motion.speed, SlideAcceleration: motion.motion.slide_acceleration}
    return float(np.abs(values[type(limit)][inside]).max(initial=0.0)), most
