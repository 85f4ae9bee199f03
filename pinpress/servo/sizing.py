"""Sizing of a servo press: the smallest motor of a catalogue with its best gear, and the capacitor that smooths its power."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..common import plausibility, tables
from ..common.arguments import LARGEST, expect, number, numbers, positive, typed, whole_number
from ..common.errors import PinpressError, shown
from ..common.results import Record, Records, Tabular
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Load
from .limits import Limit
from .motion import ServoMotion
from .motion_optimum import MotionOptimum
from .motors import CatalogueMotor, MotorUtilisation, motor_use
from .optimum import best_motion, least_heat
from .paths import Path, Pendulum, Pulse
from .task import EXCEEDED, FEWEST_POINTS, MOST_POINTS, POINTS

LARGEST_RATIO = 1e6
FAR = 2.0  # with a larger thermal use the motor is far too warm, and no motion is computed
MARGIN = 1.0 - 2.0 * EXCEEDED  # the program gets lower limits, because a motion may exceed them between its nodes


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
    """A capacitor that smooths the power of a servo press, so that the mains supply only the mean power.

    Attributes:
        mean_power: mean electrical power of the cycle, the mains power with the capacitor [W].
        peak_power: largest electrical power, the mains power without the capacitor [W].
        peak_returned: largest electrical power that braking gives back [W].
        energy_swing: difference between the largest and the smallest energy in the capacitor [J].
        upper_voltage: voltage of the DC link with the capacitor full [V].
        lower_voltage: voltage of the DC link with the capacitor empty [V].
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
    """Size the capacitor of the DC link that smooths a motion's power: the mains supply the mean power, the capacitor the difference.

    The electrical power is `ServoMotion.mains_power`: mechanical power + heat in windings and iron. All energy that braking gives back goes
    into the capacitor. The losses of the converters, and the ageing of the capacitor, need additional capacitance.

    Args:
        motion: the motion.
        upper_voltage: voltage of the DC link with the capacitor full [V].
        lower_voltage: voltage of the DC link with the capacitor empty [V].

    Raises:
        PinpressError: the upper voltage is not above the lower one.
    """
    expect("motion", motion, ServoMotion, "servo.evaluate or best_motion")
    upper, lower = positive("upper_voltage", upper_voltage, "V"), positive("lower_voltage", lower_voltage, "V")
    if not upper > lower:
        raise PinpressError(f"upper_voltage is {upper:g} V, not above the lower_voltage of {lower:g} V: exchange them")
    power = motion.mains_power
    mean = float(motion.weight @ power) / motion.duration
    supplied = np.concatenate([[0.0], np.cumsum(motion.weight * (power - mean))])
    swing = float(np.ptp(supplied))
    peak, returned = max(float(power.max()), 0.0), max(float(-power.min()), 0.0)
    return EnergyStore(mean, peak, returned, swing, upper, lower, 2 * swing / (upper**2 - lower**2))


@dataclass(frozen=True, repr=False)
class TriedMotor(
    Record, units={"ratio": "-", "rms_torque": "N m", "mean_speed": "rad/s", "thermal": "-", "peak": "-", "speed": "-", "peak_power": "W"}
):
    """A motor with a gear and a sufficient motion, or, if no motion suffices, with the motion of the least heat.

    If the thermal use would be above 2, no motion is computed. Then rms_torque and thermal are lower bounds for all motions.

    Attributes:
        motor: name of the motor.
        ratio: gear ratio [-].
        rms_torque: rms torque over cycle and pause [N m].
        mean_speed: mean absolute speed over cycle and pause [rad/s].
        thermal: rms torque / permanent torque at the mean speed [-].
        peak: largest ratio of the torque to the peak torque at the same speed [-]; None: no motion.
        speed: largest speed / highest speed of the motor [-]; None: no motion.
        peak_power: largest mechanical power [W]; None: no motion.
        remark: why the motor does not suffice; empty if it suffices.
    """

    motor: str
    ratio: float
    rms_torque: float
    mean_speed: float
    thermal: float
    peak: float | None
    speed: float | None
    peak_power: float | None
    remark: str


@dataclass(frozen=True, eq=False, repr=False)
class MotorChoice(OfPress, Tabular):
    """The smallest motor of a catalogue that suffices for a press and its work.

    Attributes:
        press_name: name of the press.
        motor: the motor; None if no motor suffices.
        best: the motor's best motion, with the drive and its ratio; None if no motor suffices.
        use: how much of the motor this motion uses; None if no motor suffices.
        tried: all tried motors and ratios, the smallest motor first.
    """

    _press: Linkage
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
    points: int | None = None,
) -> MotorChoice:
    """Choose the smallest motor that can do a press's work, with the gear ratio at which the motor's thermal use is least.

    Motors are tried in the order of their permanent power, each with all ratios, until a motor suffices. Each motor gets the motion with
    the proved least heat. If the motor is too warm with this motion, it is too warm with any motion. If this motion exceeds the curve of
    peak torque or the top speed, the best motion within 99.9 % of both is computed. The margin is needed because a motion may exceed
    a limit between its nodes. A motor whose thermal use is above 2 by the bound of a quarter of the points gets no motion. The notes of the
    motion report how closely it is proved. Ratios between the given ones may be better.

    Args:
        press: the press.
        motors: the catalogue, see `read_motors`.
        loads: as in `inverse_dynamics`.
        ratios: gear ratios to try, speed of the motor / speed of the crank [-].
        time: largest time of a cycle, see `best_motion` [s].
        path: as in `best_motion`.
        limits: as in `best_motion`.
        pause: time after each cycle in which the motor carries no current (duty S3) [s].
        gear_inertia: inertia of gears at the crank [kg m2].
        points: as in `best_motion`.

    Raises:
        PinpressError: there is no motor or no ratio, no motion keeps the limits, or as `best_motion`.
    """
    catalogue = list(motors)
    if not catalogue or not all(isinstance(each, CatalogueMotor) for each in catalogue):
        raise PinpressError(f"motors is {shown(motors)}: give one or more motors, e.g. servo.read_motors(path)")
    gear_ratios = numbers("ratios", ratios, (None,))
    if not len(gear_ratios) or not np.all((gear_ratios > 0) & (gear_ratios <= LARGEST_RATIO)):
        raise PinpressError(f"ratios is {shown(ratios)}: give one or more positive gear ratios, up to {LARGEST_RATIO:g}")
    at_crank = number("gear_inertia", gear_inertia, "kg m2")
    if not 0 <= at_crank <= LARGEST:
        raise PinpressError(f"gear_inertia is {at_crank:g} kg m2: give 0 or more, up to {LARGEST:g}")
    plausibility.stroke_time("pause", number("pause", pause, "s"))
    idle = number("pause", pause, "s")
    if points is not None:
        whole_number("points", points, FEWEST_POINTS, MOST_POINTS)
    tried: list[TriedMotor] = []
    for motor in sorted(catalogue, key=lambda each: each.rated_power):
        sufficing: list[tuple[MotorUtilisation, MotionOptimum]] = []
        for ratio in gear_ratios.tolist():
            row, sufficient = _try_motor(press, motor, ratio, at_crank, loads, time, path, limits, idle, points)
            tried.append(row)
            sufficing += sufficient
        if sufficing:
            use, best = min(sufficing, key=lambda each: each[0].thermal)
            return MotorChoice(press, motor, best, use, Records(TriedMotor, tried))
    return MotorChoice(press, None, None, None, Records(TriedMotor, tried))


def _try_motor(
    press: Linkage,
    motor: CatalogueMotor,
    ratio: float,
    gear_inertia: float,
    loads: Sequence[Load],
    time: float,
    path: Path | None,
    limits: Sequence[Limit],
    pause: float,
    points: int | None,
) -> tuple[TriedMotor, list[tuple[MotorUtilisation, MotionOptimum]]]:
    """The result for a motor and a ratio, and, if the motor suffices, its use and motion; arguments as in `choose_motor`."""
    drive = motor.drive(ratio, gear_inertia=gear_inertia)
    free = replace(drive, peak_torque=None, top_speed=None, curve_speed=None, curve_torque=None)
    most = POINTS if points is None else points
    rough = max(most // 4, 64)
    if rough < most and not isinstance(path, Pendulum | Pulse):  # a crank that turns in one direction has a known mean speed
        rms = math.sqrt(max(0.0, least_heat(press, free, loads, time, path, limits, rough)) / (time + pause)) / ratio
        mean = ratio * 2.0 * np.pi * dead_centres(press).turns / (time + pause)
        thermal = rms / float(motor.rated_torque_at(mean))
        if thermal > FAR:
            return TriedMotor(motor.name, ratio, rms, mean, thermal, None, None, None, "too warm by far"), []
    best = best_motion(press, free, loads, time=time, path=path, limits=limits, points=points)
    use = motor_use(motor, best.motion, pause=pause)
    if use.thermal > 1:
        return _row(use, best, "too warm"), []
    if use.suffices:
        return _row(use, best, ""), [(use, best)]
    below = [MARGIN * torque for torque in drive.curve_torque or ()]
    drive = replace(drive, curve_torque=below, peak_torque=None, top_speed=MARGIN * motor.top_speed)
    try:
        limited = best_motion(press, drive, loads, time=time, path=path, limits=limits, points=points)
    except PinpressError:  # no motion keeps these limits
        return _row(use, best, "above its peak torque" if use.peak > 1 else "too fast"), []
    used = motor_use(motor, limited.motion, pause=pause)
    if used.suffices:
        return _row(used, limited, ""), [(used, limited)]
    return _row(used, limited, "too warm below its curve" if used.thermal > 1 else "above its peak torque"), []


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
