"""Choice of an induction motor of a catalogue, its gear and its flywheel, by the steady state of the press with each of them.

The flywheel is on the motor's shaft, so that motor and flywheel have (motor + flywheel) x ratio² at the crank. The rms torque of the motor,
its peak torque and the drop of speed all fall as the flywheel grows. So the smallest sufficient flywheel is the one with which the highest
use of these three is 1.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np

from ..common.arguments import LARGEST, number, numbers, positive, typed
from ..common.errors import PinpressError, SimulationError, shown
from ..common.numerics import sign_change
from ..common.quantities import RPM
from ..common.results import Record, Records, Tabular
from ..common.tables import Columns
from ..drives.motors import InductionMotor
from ..drives.transmission import Flywheel, Geared
from ..dynamics.driving_energy import driving_energy
from ..dynamics.inverse_dynamics import NONE_GIVEN, inverse_dynamics
from ..kinematics.cycle import cycle
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Friction, Load
from ..simulation.duty import MotorDuty, duty_cycle
from ..simulation.steady_state import steady_state
from .motors import start

RESERVE = 1.25  # at 10 % less voltage on the mains the breakdown torque is 19 % smaller, as it goes with the square
CLOSE = 1e-7  # of the largest flywheel: how closely the smallest one is found


@dataclass(frozen=True, repr=False)
class TriedDrive(
    Record,
    units={
        "ratio": "-",
        "flywheel": "kg m2",
        "mean_speed": "rad/s",
        "highest_speed": "rad/s",
        "lowest_speed": "rad/s",
        "speed_drop": "-",
        "rms_torque": "N m",
        "thermal": "-",
        "peak": "-",
        "start_time": "s",
        "start_heat": "J",
    },
):
    """A motor with a gear, and the smallest flywheel of the range with which it suffices; if it does not suffice, with the largest.

    Attributes:
        motor: name of the motor.
        ratio: gear ratio [-].
        flywheel: inertia on the motor's shaft, without that of the motor [kg m2].
        mean_speed: mean absolute speed of the crank [rad/s]; None if the motor stalls or is too weak.
        highest_speed: largest absolute speed of the crank [rad/s]; None as before.
        lowest_speed: smallest absolute speed of the crank [rad/s]; None as before.
        speed_drop: highest less lowest speed / mean speed [-]; None as before.
        rms_torque: rms torque of the motor [N m]; None as before.
        thermal: rms torque / rated torque [-]; None as before.
        peak: largest torque / breakdown torque [-]; None as before.
        start_time: from rest to the rated speed, with the clutch open [s].
        start_heat: heat in the rotor in such a start, up to the synchronous speed [J].
        remark: why it does not suffice; empty if it suffices.
    """

    motor: str
    ratio: float
    flywheel: float
    mean_speed: float | None
    highest_speed: float | None
    lowest_speed: float | None
    speed_drop: float | None
    rms_torque: float | None
    thermal: float | None
    peak: float | None
    start_time: float
    start_heat: float
    remark: str


@dataclass(frozen=True, eq=False, repr=False)
class DriveChoice(OfPress, Tabular):
    """The smallest motor of a catalogue that suffices for a press, and its smallest flywheel.

    Attributes:
        press_name: name of the press.
        best: the motor with its gear and flywheel; None if none suffices.
        drive: the motor behind its gear, as `steady_state` takes it; None if none suffices.
        flywheel: the flywheel, reduced to the crank; None if none suffices.
        flywheels: smallest and largest inertia of the range [kg m2].
        tried: every motor with every ratio, the smallest motor first.
    """

    _press: Linkage
    best: TriedDrive | None
    drive: Geared | None
    flywheel: Flywheel | None
    flywheels: tuple[float, float]
    tried: Records[TriedDrive]

    @property
    def title(self) -> str:
        if self.best is None:
            low, high = self.flywheels
            return f"DriveChoice for {self.press_name}: no motor suffices with a flywheel of {low:g} to {high:g} kg m2 on its shaft"
        best = self.best
        return f"DriveChoice for {self.press_name}: {best.motor}, ratio {best.ratio:g}, flywheel {best.flywheel:.6g} kg m2 on its shaft"

    def columns(self) -> Columns:
        """The columns of what was tried."""
        return self.tried.columns()


class Demand(NamedTuple):
    """A press and the limits of its drive: arguments of `choose_drive`; ``speeds`` are absolute values."""

    press: Linkage
    loads: Sequence[Load]
    friction: Mapping[str, Friction]
    speeds: tuple[float, float]
    flywheels: tuple[float, float]
    speed_drop: float
    reserve: float
    start_time: float
    power: float  # mean one that the motor has to give at the lowest speed of the band [W]


@typed
def choose_drive(
    press: Linkage,
    motors: Mapping[str, InductionMotor],
    loads: Sequence[Load] = (),
    friction: Mapping[str, Friction] = NONE_GIVEN,
    *,
    ratios: Sequence[float],
    flywheels: Sequence[float],
    speeds: Sequence[float],
    speed_drop: float,
    reserve: float = RESERVE,
    start_time: float | None = None,
    efficiency: float = 1.0,
) -> DriveChoice:
    """Choose the smallest motor of a catalogue that drives a press, with a gear and the smallest flywheel on the motor's shaft.

    Each motor with each ratio gets the smallest flywheel with which the steady state keeps three limits: the rms torque of the motor is at
    most its rated torque, its peak torque at most breakdown torque / reserve, and the speed drops by no more than ``speed_drop``. Of all
    that suffice, the best has the least rated power, and of equal power the smallest flywheel. A motor whose speed falls below its
    breakdown speed reaches its breakdown torque, so it never suffices.

    Args:
        press: a press with one crank.
        motors: the catalogue by names, see `read_motors`.
        loads: as in `steady_state`.
        friction: as in `steady_state`.
        ratios: gear ratios to try, speed of the motor / speed of the crank [-].
        flywheels: (2,) smallest and largest inertia of the flywheel on the motor's shaft [kg m2].
        speeds: (2,) the band of the crank's mean speed [rad/s]; both negative: backwards.
        speed_drop: highest less lowest speed / mean speed, at most [-].
        reserve: breakdown torque / largest torque of the motor, at least [-]. The default is what 10 % less voltage needs.
        start_time: from rest to the rated speed with the clutch open, at most [s]; None: any time.
        efficiency: of the gear [-].

    Raises:
        PinpressError: an argument is not as described, no ratio brings a motor into the band of speeds, or the loads take more power than
            every motor has.
    """
    press.refuse_several_drivers("a choice of motor and flywheel is for one crank")
    press.refuse_sliding_driver("a flywheel turns with a crank")
    catalogue, gear_ratios = _catalogue(motors), _ratios(ratios)
    low, high = _band("speeds", speeds, "rad/s")
    if low * high <= 0.0:
        raise PinpressError(f"speeds is {shown(speeds)}: give two speeds in one direction, such as (90 * pp.RPM, 105 * pp.RPM)")
    least, most = _band("flywheels", flywheels, "kg m2")
    if not 0.0 <= least < most <= LARGEST:
        raise PinpressError(f"flywheels is {shown(flywheels)}: give the smallest and the largest inertia on the motor's shaft, from 0 on")
    drop, margin = positive("speed_drop", speed_drop, "-"), number("reserve", reserve, "-")
    if not drop < 1.0:
        raise PinpressError(f"speed_drop is {drop:g}: give a share below 1, such as 0.06")
    if not margin > 1.0:
        raise PinpressError(f"reserve is {margin:g}: give breakdown torque / largest torque, above 1")
    longest = math.inf if start_time is None else positive("start_time", start_time, "s")
    sizes = (min(abs(low), abs(high)), max(abs(low), abs(high)))
    sense, gear = math.copysign(1.0, low), positive("efficiency", efficiency, "-", largest=1.0)
    _refuse_other_speeds(catalogue, gear_ratios, sizes)
    power = _mean_power(press, sense * sizes[0], loads, friction) / gear
    demand = Demand(press, list(loads), friction, sizes, (least, most), drop, margin, longest, power)
    strongest = max(float(motor.rated_power) for motor in catalogue.values())
    if power > strongest:
        raise PinpressError(
            f"the press takes {power / 1e3:.3g} kW at {sizes[0] / RPM:.4g} r/min, and the largest motor has {strongest / 1e3:.3g} kW: give"
            " larger motors or a lower speed"
        )
    tried, drives = [], []
    for name, motor in catalogue.items():
        for ratio in gear_ratios:
            drive = Geared(motor, sense * ratio, efficiency=gear)
            tried.append(_smallest(name, drive, demand))
            drives.append(drive)
    enough = [k for k, row in enumerate(tried) if not row.remark]
    if not enough:
        return DriveChoice(press, None, None, None, demand.flywheels, Records(TriedDrive, tried))
    k = min(enough, key=lambda k: (float(catalogue[tried[k].motor].rated_power), tried[k].flywheel))
    return DriveChoice(press, tried[k], drives[k], _at_crank(drives[k], tried[k].flywheel), demand.flywheels, Records(TriedDrive, tried))


# --------------------------------------------------------------------------------------------------------------------------- arguments


def _catalogue(motors: Mapping[str, InductionMotor]) -> dict[str, InductionMotor]:
    """The motors, the smallest first."""
    single = isinstance(motors, Mapping) and all(isinstance(each, InductionMotor) and not np.ndim(each.inertia) for each in motors.values())
    if not motors or not single or any(np.ndim(each.rated_power) for each in motors.values()):
        raise PinpressError(f"motors is {shown(motors)}: give InductionMotors by their names, e.g. mains.read_motors(path)")
    return dict(sorted(motors.items(), key=lambda each: float(each[1].rated_power)))


def _ratios(ratios: Sequence[float]) -> list[float]:
    values = numbers("ratios", ratios, (None,))
    if not len(values) or not np.all((values > 0) & (values <= LARGEST)):
        raise PinpressError(f"ratios is {shown(ratios)}: give one or more positive gear ratios")
    return [float(value) for value in values]


def _band(name: str, values: Sequence[float], unit: str) -> tuple[float, float]:
    low, high = numbers(name, values, (2,), unit=unit).tolist()
    if not low <= high:
        raise PinpressError(f"{name} is {shown(values)}: give two numbers, the lower one first [{unit}]")
    return low, high


def _refuse_other_speeds(motors: Mapping[str, InductionMotor], ratios: Sequence[float], speeds: tuple[float, float]) -> None:
    """Raise PinpressError if no motor with any ratio runs between its breakdown and its synchronous speed in the band."""
    low, high = speeds
    if any(
        motor.breakdown_speed / ratio <= high and motor.synchronous_speed / ratio >= low for motor in motors.values() for ratio in ratios
    ):
        return
    name, motor = next(iter(motors.items()))
    raise PinpressError(
        f"no ratio of {', '.join(f'{ratio:g}' for ratio in ratios)} brings a motor into {low / RPM:.4g} to {high / RPM:.4g} r/min of the"
        f" crank: give a ratio of {motor.rated_speed / high:.3g} to {motor.rated_speed / low:.3g} for {name}"
    )


def _mean_power(press: Linkage, speed: float, loads: Sequence[Load], friction: Mapping[str, Friction]) -> float:
    """Mean power at the crank at a constant speed [W]."""
    return driving_energy(inverse_dynamics(press, cycle(press, speed=speed), loads, friction)).mean_power


# ---------------------------------------------------------------------------------------------------------------------------- the search


def _at_crank(drive: Geared, inertia: float) -> Flywheel:
    """A flywheel on the motor's shaft, reduced to the crank."""
    return Flywheel(inertia * drive.ratio**2)


def _duty(drive: Geared, inertia: float, demand: Demand) -> MotorDuty | None:
    """The duty of a stroke with a flywheel on the motor's shaft [kg m2]; None if the motor stalls.

    The search begins at the synchronous speed, so that it finds the faster one of two steady states on both sides of the breakdown slip.
    """
    motor = drive.drive
    assert isinstance(motor, InductionMotor)
    try:
        run = steady_state(
            demand.press,
            motor.synchronous_speed / drive.ratio,
            drive=drive,
            flywheel=_at_crank(drive, inertia),
            loads=demand.loads,
            friction=demand.friction,
        )
    except SimulationError:
        return None
    duty = duty_cycle(run)
    return duty if duty.mean_speed * abs(drive.ratio) > motor.breakdown_speed else None


def _uses(drive: Geared, duty: MotorDuty, demand: Demand) -> dict[str, float]:
    """Uses of the three limits that a larger flywheel lowers, by the remark on a motor that exceeds each limit."""
    motor = drive.drive
    assert isinstance(motor, InductionMotor)
    assert duty.utilisation is not None
    return {
        "too warm": duty.utilisation,
        "too near its breakdown torque": demand.reserve * duty.motor_peak / float(motor.breakdown_torque),
        "speed drops too much": duty.speed_drop / demand.speed_drop,
    }


def _smallest(name: str, drive: Geared, demand: Demand) -> TriedDrive:
    """A motor and gear with the smallest sufficient flywheel of the range, or with the largest."""
    motor, (low, high) = drive.drive, demand.flywheels
    assert isinstance(motor, InductionMotor)
    if demand.power > float(motor.rated_torque) * motor.synchronous_speed:  # its mean torque is above the rated torque already
        return _row(name, drive, high, None, "too weak", demand)

    @cache
    def duty(inertia: float) -> MotorDuty | None:
        return _duty(drive, inertia, demand)

    def excess(inertia: float) -> float:
        """Of the highest use over 1, as 1 - 1 / use: nearly linear in the inertia, and 1 if the motor stalls."""
        found = duty(inertia)
        return 1.0 if found is None else 1.0 - 1.0 / max(_uses(drive, found, demand).values())

    width, smallest = CLOSE * high, high
    while smallest > low and excess(smallest) <= 0.0:  # by halves: it is costly to see that a motor with a small flywheel stalls
        below = 0.5 * smallest if 0.5 * smallest > max(low, width) else low
        if excess(below) > 0.0:
            smallest = min(sign_change(excess, below, smallest, width) + width, smallest)
            break
        smallest = below
    return _row(name, drive, smallest, duty(smallest), "stalls", demand)


def _row(name: str, drive: Geared, inertia: float, duty: MotorDuty | None, no_state: str, demand: Demand) -> TriedDrive:
    """The result of a motor, a gear and a flywheel; ``no_state``: the remark without a duty."""
    motor = drive.drive
    assert isinstance(motor, InductionMotor)
    begin, ratio = start(motor, float(motor.inertia) + inertia), abs(drive.ratio)
    if duty is None:
        return TriedDrive(name, ratio, inertia, None, None, None, None, None, None, None, *begin, no_state)
    remarks = [remark for remark, use in _uses(drive, duty, demand).items() if use > 1.0]
    low, high = demand.speeds
    remarks += ["too slow"] * (duty.mean_speed < low) + ["too fast"] * (duty.mean_speed > high)
    remarks += ["starts too slowly"] * (begin.time > demand.start_time)
    peak = duty.motor_peak / float(motor.breakdown_torque)
    speeds = (duty.mean_speed, duty.highest_speed, duty.lowest_speed, duty.speed_drop)
    return TriedDrive(name, ratio, inertia, *speeds, duty.motor_rms, duty.utilisation, peak, *begin, ", ".join(remarks))
