"""What a servo press needs: the smallest motor of a catalogue with its best gear, and the capacitor that evens out its power."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..common import plausibility, tables
from ..common.arguments import LARGEST, expect, number, numbers, positive, typed, whole_number
from ..common.errors import PinpressError, shown
from ..common.quantities import RPM
from ..common.results import Record, Records, Tabular
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Load
from .limits import Limit
from .motion import ServoMotion
from .motion_optimum import MotionOptimum
from .motors import CatalogueMotor, MotorUtilisation, motor_use
from .optimum import EXCEEDED, FEWEST_POINTS, MOST_POINTS, POINTS, best_motion, least_heat
from .paths import Path, Pendulum, Pulse

LARGEST_RATIO = 1e6
FAR = 2.0  # thermal use beyond which a motor is too warm by far, and no motion is looked for
ROUGHLY, LEAST_ROUGH = 4, 64  # a motor is first tried with so many times fewer segments, but at least so many
NEAR, CLEARLY = 0.02, 0.1  # thermal use so near to 1, and other use by less than so much above it, are looked at with all segments
MARGIN = 1.0 - 2.0 * EXCEEDED  # share of a limited torque that a motion is asked to keep, because between its nodes it may be above it


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

    Of a motor that is too warm by far, more than twice, there is no motion: what is given is what all motions have at least.

    Attributes:
        motor: name of the motor.
        ratio: of the gear [-].
        rms_torque: root mean square of the torque over cycle and pause [N m].
        mean_speed: mean size of the speed over cycle and pause [rad/s].
        thermal: rms torque as a share of the permanent torque at the mean speed [-].
        peak: largest torque as a share of the peak torque at its speed; None: no motion [-].
        speed: largest speed as a share of the highest; None: no motion [-].
        peak_power: largest mechanical power; None: no motion [W].
        remark: why it does not suffice; empty where it does.
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
        motor: the motor; None where none suffices.
        best: its best motion, with the drive and its ratio; None where none suffices.
        use: what this motion uses of the motor; None where none suffices.
        tried: all motors and ratios that were tried, the smallest motor first.
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

    def __str__(self) -> str:
        heads = ["motor", "ratio", "rms [N m]", "at [r/min]", "thermal [%]", "peak [%]", "speed [%]", "power [kW]", ""]
        rows = [heads]
        for each in self.tried:
            known = (each.rms_torque, each.mean_speed / RPM, 100 * each.thermal)
            others = ((each.peak, 100), (each.speed, 100), (each.peak_power, 1e-3))
            shown_ = [f"{value:.4g}" for value in known] + ["" if value is None else f"{by * value:.4g}" for value, by in others]
            rows.append([each.motor, f"{each.ratio:g}", *shown_, each.remark])
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
    points: int | None = None,
) -> MotorChoice:
    """The smallest motor that can do a press's work, with the ratio of its gear at which it is warmed least.

    Motors are tried from the smallest permanent power on, each with all ratios, until one suffices. Each gets the motion with the least
    heat of all, which is proved: a motor that is too warm by it is too warm by any motion. Where this motion crosses the curve of peak
    torque or is too fast, the best motion below the curve is looked for, less a margin of 0.1 %, because between its nodes a motion may be
    above a limited torque by so much. A motor that is too warm with a quarter of the points, and not nearly cool enough, is not looked at
    again. The motion's own notes say how closely it is proved. Nothing is said of ratios between those given.

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
    plausibility.stroke_time("pause", number("pause", pause, "s"))
    idle = number("pause", pause, "s")
    if points is not None:
        whole_number("points", points, FEWEST_POINTS, MOST_POINTS)
    tried: list[TriedMotor] = []
    for motor in sorted(given, key=lambda each: each.rated_power):
        found: list[tuple[MotorUtilisation, MotionOptimum]] = []
        for ratio in chosen.tolist():
            row, sufficient = _tried(press, motor, ratio, at_crank, loads, time, path, limits, idle, points)
            tried.append(row)
            found += sufficient
        if found:
            use, best = min(found, key=lambda each: each[0].thermal)
            return MotorChoice(press, motor, best, use, Records(TriedMotor, tried))
    return MotorChoice(press, None, None, None, Records(TriedMotor, tried))


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
    points: int | None,
) -> tuple[TriedMotor, list[tuple[MotorUtilisation, MotionOptimum]]]:
    """What came of a motor and a ratio, and its use where it suffices; arguments as of `choose_motor`."""
    drive = motor.drive(ratio, gear_inertia=gear_inertia)
    free = replace(drive, peak_torque=None, top_speed=None, curve_speed=None, curve_torque=None)
    most = POINTS if points is None else points
    rough = max(most // ROUGHLY, LEAST_ROUGH)
    if rough < most and not isinstance(path, Pendulum | Pulse):  # of a crank that goes one way the mean speed is known
        rms = math.sqrt(max(0.0, least_heat(press, free, loads, time, path, limits, rough)) / (time + pause)) / ratio
        mean = ratio * 2.0 * np.pi * dead_centres(press).turns / (time + pause)
        thermal = rms / float(motor.rated_torque_at(mean))
        if thermal > FAR:
            return TriedMotor(motor.name, ratio, rms, mean, thermal, None, None, None, "too warm by far"), []
    for count in (rough, points) if rough < most else (points,):
        best = best_motion(press, free, loads, time=time, path=path, limits=limits, points=count)
        use = motor_use(motor, best.motion, pause=pause)
        if use.thermal > (1.0 if count == points else 1.0 + NEAR):
            return _row(use, best, "too warm"), []
        if use.suffices and count == points:
            return _row(use, best, ""), [(use, best)]
        if max(use.peak, use.speed) > 1.0 + CLEARLY:
            break
    below = [MARGIN * torque for torque in drive.curve_torque or ()]
    drive = replace(drive, curve_torque=below, peak_torque=None, top_speed=MARGIN * motor.top_speed)
    try:
        limited = best_motion(press, drive, loads, time=time, path=path, limits=limits, points=points)
    except PinpressError:  # no motion keeps them
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
