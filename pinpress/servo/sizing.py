"""What a servo press needs: the smallest motor of a catalogue with its best gear, and the capacitor that evens out its power."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..common import tables
from ..common.arguments import LARGEST, expect, number, numbers, positive, typed
from ..common.errors import PinpressError, shown
from ..common.quantities import RPM
from ..common.results import Record, Records, Tabular
from ..linkage.linkage import Linkage
from ..loads.link import Load
from .limits import Limit
from .motion import ServoMotion
from .motion_optimum import MotionOptimum
from .motors import CatalogueMotor, MotorUtilisation, motor_use
from .optimum import POINTS, best_motion
from .paths import Path

LARGEST_RATIO = 1e6
MARGIN = 0.97  # share of a limited torque that a motion is asked to keep, because between its nodes it exceeds it by up to 2 %


@dataclass(frozen=True, repr=False)
class EnergyStore(
    Record,
    units={
        "mean_power": "W",
        "peak_power": "W",
        "peak_returned": "W",
        "energy_swing": "J",
        "upper_voltage": "V",
        "lower_voltage": "V",
        "capacitance": "F",
    },
):
    """The capacitor that evens out the power of a servo press, so that the mains give its mean alone.

    Attributes:
        mean_power: mean electrical power of the cycle, what the mains give with the capacitor [W].
        peak_power: largest electrical power, what the mains would give without it [W].
        peak_returned: largest electrical power that braking gives back [W].
        energy_swing: difference between the largest and the smallest energy in the capacitor [J].
        upper_voltage: of the direct-current link when it is full [V].
        lower_voltage: when it is empty [V].
        capacitance: 2 energy_swing / (upper_voltage² - lower_voltage²) [F].
    """

    mean_power: float
    peak_power: float
    peak_returned: float
    energy_swing: float
    upper_voltage: float
    lower_voltage: float
    capacitance: float


@typed
def capacitor(motion: ServoMotion, upper_voltage: float = 750.0, lower_voltage: float = 450.0) -> EnergyStore:
    """The capacitor in the direct-current link that evens out a motion's power: the mains feed its mean, the capacitor the rest.

    The electrical power is the mechanical one with the heat in windings and iron, `ServoMotion.mains_power`. All that braking gives back
    goes into the capacitor. With the losses of converters and a capacitor that ages more is needed.

    Args:
        motion: the motion.
        upper_voltage: of the link when the capacitor is full [V].
        lower_voltage: when it is empty [V].

    Raises:
        PinpressError: the upper voltage is not above the lower one.
    """
    expect("motion", motion, ServoMotion, "servo.evaluate or best_motion")
    upper, lower = positive("upper_voltage", upper_voltage, "V"), positive("lower_voltage", lower_voltage, "V")
    if not upper > lower:
        raise PinpressError(f"upper_voltage is {upper:g} V, not above the lower_voltage of {lower:g} V: exchange them")
    power = motion.mains_power
    mean = float(motion.weight @ power) / motion.duration
    given = np.concatenate([[0.0], np.cumsum(motion.weight * (power - mean))])
    swing = float(np.ptp(given))
    peak, returned = max(float(power.max()), 0.0), max(float(-power.min()), 0.0)
    return EnergyStore(mean, peak, returned, swing, upper, lower, 2 * swing / (upper**2 - lower**2))


@dataclass(frozen=True, repr=False)
class TriedMotor(
    Record, units={"ratio": "-", "rms_torque": "N m", "mean_speed": "rad/s", "thermal": "-", "peak": "-", "speed": "-", "peak_power": "W"}
):
    """A motor behind a gear with the motion that suffices, or else with the one of the least heat. Shares are those of `MotorUtilisation`.

    Attributes:
        motor: name of the motor.
        ratio: of the gear [-].
        rms_torque: root mean square of the torque over cycle and pause [N m].
        mean_speed: mean size of the speed over cycle and pause [rad/s].
        thermal: rms torque as a share of the permanent torque at the mean speed [-].
        peak: largest torque as a share of the peak torque at its speed [-].
        speed: largest speed as a share of the highest [-].
        peak_power: largest mechanical power [W].
        remark: why it does not suffice; empty where it does.
    """

    motor: str
    ratio: float
    rms_torque: float
    mean_speed: float
    thermal: float
    peak: float
    speed: float
    peak_power: float
    remark: str


@dataclass(frozen=True, eq=False, repr=False)
class MotorChoice(Tabular):
    """The smallest motor of a catalogue that suffices for a press and its work.

    Attributes:
        press_name: name of the press.
        motor: the motor; None where none suffices.
        best: its best motion, with the drive and its ratio; None where none suffices.
        use: what this motion uses of the motor; None where none suffices.
        tried: all motors and ratios that were tried, the smallest motor first.
    """

    press_name: str
    motor: CatalogueMotor | None
    best: MotionOptimum | None
    use: MotorUtilisation | None
    tried: Records[TriedMotor]

    @property
    def title(self) -> str:
        if self.motor is None or self.use is None:
            return f"MotorChoice for {self.press_name}: none of the motors suffices"
        return (
            f"MotorChoice for {self.press_name}: {self.motor.name}, ratio {self.use.ratio:g}, {self.use.rms_torque:.6g} N m rms,"
            f" {100 * self.use.thermal:.0f} % of its permanent torque"
        )

    def columns(self) -> dict[str, tables.Column]:
        """The columns of what was tried."""
        return self.tried.columns()

    def __str__(self) -> str:
        heads = ["motor", "ratio", "rms [N m]", "at [r/min]", "thermal [%]", "peak [%]", "speed [%]", "power [kW]", ""]
        rows = [heads]
        for each in self.tried:
            values = (each.rms_torque, each.mean_speed / RPM, 100 * each.thermal, 100 * each.peak, 100 * each.speed, 1e-3 * each.peak_power)
            rows.append([each.motor, f"{each.ratio:g}", *(f"{value:.4g}" for value in values), each.remark])
        return "\n".join([self.title, *(line.rstrip() for line in tables.fitted(rows))])


@typed
def choose_motor(
    press: Linkage,
    motors: Sequence[CatalogueMotor],
    loads: Sequence[Load] = (),
    *,
    ratios: Sequence[float],
    time: float,
    path: Path | None = None,
    limits: Sequence[Limit] = (),
    pause: float = 0.0,
    gear_inertia: float = 0.0,
    points: int = POINTS,
) -> MotorChoice:
    """The smallest motor that can do a press's work, with the ratio of its gear at which it is warmed least.

    Motors are tried from the smallest permanent power on, each with all ratios, until one suffices. Each gets the motion with the least
    heat of all, which is proved: a motor that is too warm by it is too warm by any motion. Where this motion crosses the curve of peak
    torque or is too fast, the best motions of limited drives are looked at: with the largest torque up to the highest speed, and up to each
    of the catalogue's speeds with the torque that the motor has all the way to it; less a margin of 3 %, because between its nodes a motion
    exceeds a limited torque a little. That no other motion is below the curve is not proved, and nothing is said of ratios between those
    given.

    Args:
        press: the press.
        motors: the catalogue, see `read_motors`.
        loads: as of `inverse_dynamics`.
        ratios: gear ratios to try, speed of the motor by speed of the crank.
        time: most time of a cycle, see `best_motion` [s].
        path: as of `best_motion`.
        limits: as of `best_motion`.
        pause: time after each cycle in which the motor carries no current (duty S3) [s].
        gear_inertia: of gears at the crank [kg m2].
        points: as of `best_motion`.

    Raises:
        PinpressError: there is no motor or no ratio, no motion of any motor keeps the limits, or as `best_motion`.
    """
    given = list(motors)
    if not given or not all(isinstance(each, CatalogueMotor) for each in given):
        raise PinpressError(f"motors is {shown(motors)}: give one or more motors, servo.read_motors(path)")
    chosen = numbers("ratios", ratios, (None,))
    if not len(chosen) or not np.all((chosen > 0) & (chosen <= LARGEST_RATIO)):
        raise PinpressError(f"ratios is {shown(ratios)}: give one or more positive gear ratios, up to {LARGEST_RATIO:g}")
    at_crank = number("gear_inertia", gear_inertia, "kg m2")
    if not 0 <= at_crank <= LARGEST:
        raise PinpressError(f"gear_inertia is {at_crank:g} kg m2: give 0 or more, up to {LARGEST:g}")
    idle = number("pause", pause, "s")
    tried: list[TriedMotor] = []
    for motor in sorted(given, key=lambda each: each.rated_power):
        found: list[tuple[MotorUtilisation, MotionOptimum]] = []
        for ratio in chosen.tolist():
            row, sufficient = _tried(press, motor, ratio, at_crank, loads, time, path, limits, idle, points)
            tried.append(row)
            found += sufficient
        if found:
            use, best = min(found, key=lambda each: each[0].thermal)
            return MotorChoice(press.name, motor, best, use, Records(TriedMotor, tried))
    return MotorChoice(press.name, None, None, None, Records(TriedMotor, tried))


def _tried(
    press: Linkage,
    motor: CatalogueMotor,
    ratio: float,
    gear_inertia: float,
    loads: Sequence[Load],
    time: float,
    path: Path | None,
    limits: Sequence[Limit],
    pause: float,
    points: int,
) -> tuple[TriedMotor, list[tuple[MotorUtilisation, MotionOptimum]]]:
    """What came of a motor and a ratio, and its use where it suffices; arguments as of `choose_motor`."""
    free = replace(motor.drive(ratio, gear_inertia=gear_inertia), peak_torque=None, top_speed=None)
    best = best_motion(press, free, loads, time=time, path=path, limits=limits, points=points)
    use = motor_use(motor, best.motion, pause=pause)
    if use.thermal > 1:
        return _row(use, best, "too warm"), []
    if use.suffices:
        return _row(use, best, ""), [(use, best)]
    remark = "above its peak torque" if use.peak > 1 else "too fast"
    found = []
    for up_to in (None, *motor.speed[1:]):
        drive = motor.drive(ratio, up_to=up_to, gear_inertia=gear_inertia)
        drive = replace(drive, peak_torque=MARGIN * (drive.peak_torque or 0.0))
        try:
            limited = best_motion(press, drive, loads, time=time, path=path, limits=limits, points=points)
        except PinpressError:  # no motion keeps them
            continue
        used = motor_use(motor, limited.motion, pause=pause)
        if used.suffices:
            found.append((used, limited))
        elif used.thermal > 1:
            remark = "too warm below its curve"
    if not found:
        return _row(use, best, remark), []
    used, limited = min(found, key=lambda each: each[0].thermal)
    return _row(used, limited, ""), [(used, limited)]


def _row(use: MotorUtilisation, best: MotionOptimum, remark: str) -> TriedMotor:
    return TriedMotor(
        use.motor,
        use.ratio,
        use.rms_torque,
        use.mean_speed,
        use.thermal,
        use.peak,
        use.speed,
        best.motion.peak_power,
        remark,
    )
