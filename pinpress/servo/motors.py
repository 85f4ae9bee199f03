"""Servo motors of a catalogue with their curves of torque over speed, and how much of a motor a motion uses.

A catalogue is a CSV file with a row for each point of a motor's curves, in the order of the speed. The rows of a motor follow one another:

    motor, inertia [kg m2], copper loss [W/(N m)2], speed [r/min], rated torque [N m], peak torque [N m]
    example 300, 0.31, 0.012, 0, 300, 800
    example 300, 0.31, 0.012, 1500, 270, 800
    example 300, 0.31, 0.012, 2500, 160, 420

Heads may name other units, for example speed [rpm]. The rated torque is the permanent torque (duty S1). The curves are linear between the
points. The last point is at the motor's highest speed.
"""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..common import plausibility
from ..common.arguments import expect, number, typed
from ..common.errors import PinpressError, shown
from ..common.parameters import Checked, parameter, set_field
from ..common.quantities import RPM, Array
from ..common.reading.columns import Wanted, read_columns
from ..common.results import Record
from .drive import ServoDrive
from .motion import ServoMotion

CATALOGUE = {  # columns of a catalogue
    "motor": Wanted(),
    "inertia": Wanted("kg m2"),
    "copper loss": Wanted("W/(N m)2"),
    "speed": Wanted("rad/s"),
    "rated torque": Wanted("N m"),
    "peak torque": Wanted("N m"),
}
ALIKE = 1e-9  # share by which inertias of one motor may differ


@dataclass(frozen=True)
class CatalogueMotor(Checked):
    """A servo motor of a catalogue.

    Attributes:
        name: name of the motor.
        inertia: inertia of the rotor [kg m2].
        speed: (k,) rising speeds from 0 to the highest, the points of the curves [rad/s].
        rated_torque: (k,) permanent torques (duty S1) at these speeds [N m].
        peak_torque: (k,) largest torques at these speeds [N m].
        copper: heat in the windings / torque² [W/(N m)2].

    Raises:
        PinpressError: the columns differ in length, speeds do not rise from 0, or a rated torque is above the peak torque.
    """

    name: str
    inertia: float = field(metadata=parameter("kg m2", "positive"))
    speed: Sequence[float] | Array = field(metadata=parameter("rad/s", "not negative", axes=1))
    rated_torque: Sequence[float] | Array = field(metadata=parameter("N m", "positive", axes=1))
    peak_torque: Sequence[float] | Array = field(metadata=parameter("N m", "positive", axes=1))
    copper: float = field(default=0.0, metadata=parameter("W/(N m)2", "not negative"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.name, str) or not self.name:
            raise PinpressError(f"CatalogueMotor: name is {shown(self.name)}; give the name of the motor as text")
        speed, rated, peak = (np.asarray(column_) for column_ in (self.speed, self.rated_torque, self.peak_torque))
        if len({len(speed), len(rated), len(peak)}) > 1:
            raise PinpressError(
                f"{self.name}: there are {len(speed)} speeds, {len(rated)} rated and {len(peak)} peak torques; give both at each speed"
            )
        if len(speed) < 2 or speed[0] != 0 or not np.all(np.diff(speed) > 0):
            raise PinpressError(f"{self.name}: speeds do not rise from 0: give two or more speeds, from 0 to the highest [rad/s]")
        if np.any(rated > peak):
            k = int(np.argmax(rated > peak))
            raise PinpressError(f"{self.name}: at {speed[k] / RPM:g} r/min the rated torque is above the peak torque; exchange them")
        for name, column in (("speed", speed), ("rated_torque", rated), ("peak_torque", peak)):
            set_field(self, name, tuple(column.tolist()))
        plausibility.motor(self.name, float(peak[0]), float(speed[-1]), self.inertia, "peak_torque in N m")

    @property
    def top_speed(self) -> float:
        """Highest speed [rad/s]."""
        return float(self.speed[-1])

    @property
    def rated_power(self) -> float:
        """Largest permanent power on the points of the curve [W]."""
        return float(np.max(np.asarray(self.speed) * np.asarray(self.rated_torque)))

    def rated_torque_at(self, speed: float | Array) -> Array:
        """Permanent torque [N m] at speeds of any shape and sign [rad/s]; above the highest speed the torque at that speed."""
        return np.asarray(np.interp(np.abs(speed), self.speed, self.rated_torque))

    def peak_torque_at(self, speed: float | Array) -> Array:
        """Largest torque [N m] at speeds of any shape and sign [rad/s]; above the highest speed the torque at that speed."""
        return np.asarray(np.interp(np.abs(speed), self.speed, self.peak_torque))

    def drive(self, ratio: float, *, up_to: float | None = None, gear_inertia: float = 0.0, regeneration: float = 1.0) -> ServoDrive:
        """The motor with a gear, and with its curve of peak torque.

        Args:
            ratio: speed of the motor / speed of the crank [-].
            up_to: top speed of the drive, whose constant peak torque is the least of the curve up to there [rad/s]. None: the drive has the
                motor's highest speed and its curve; where the curve rises, it has the least torque of all lower speeds.
            gear_inertia: as in `ServoDrive` [kg m2].
            regeneration: as in `ServoDrive` [-].

        Raises:
            PinpressError: a number is not as described.
        """
        top, peak = self.top_speed, max(self.peak_torque)
        curve_speed: Sequence[float] | None = None
        curve_torque: Sequence[float] | None = None
        if up_to is None:
            curve_speed, curve_torque = tuple(self.speed), tuple(np.minimum.accumulate(np.asarray(self.peak_torque)).tolist())
            peak = curve_torque[0]
        if up_to is not None:
            top = min(number("up_to", up_to, "rad/s", positive=True), self.top_speed)
            peak = min(float(self.peak_torque_at(top)), *(p for n, p in zip(self.speed, self.peak_torque, strict=True) if n <= top))
        return ServoDrive(
            inertia=self.inertia,
            ratio=ratio,
            peak_torque=float(peak),
            rated_torque=float(self.rated_torque[0]),
            top_speed=top,
            copper=self.copper,
            gear_inertia=gear_inertia,
            regeneration=regeneration,
            curve_speed=curve_speed,
            curve_torque=curve_torque,
        )


@dataclass(frozen=True, repr=False)
class MotorUtilisation(
    Record,
    units={
        "rms_torque": "N m",
        "mean_speed": "rad/s",
        "rated_torque": "N m",
        "thermal": "-",
        "peak": "-",
        "peak_angle": "rad",
        "speed": "-",
    },
):
    """How much of a motor a motion uses, at the motor's shaft.

    Attributes:
        motor: name of the motor.
        ratio: gear ratio [-].
        rms_torque: rms torque over cycle and pause [N m].
        mean_speed: mean absolute speed over cycle and pause [rad/s].
        rated_torque: permanent torque (duty S1) at the mean speed [N m].
        thermal: rms torque / rated torque [-].
        peak: largest ratio of the torque to the peak torque at the same speed [-].
        peak_angle: crank angle at which this ratio is largest [rad].
        speed: largest speed / highest speed of the motor [-].
    """

    motor: str
    ratio: float
    rms_torque: float
    mean_speed: float
    rated_torque: float
    thermal: float
    peak: float
    peak_angle: float
    speed: float

    @property
    def suffices(self) -> bool:
        """Whether the motor can repeat the motion without end: no share is above 1."""
        return max(self.thermal, self.peak, self.speed) <= 1


@typed
def motor_use(motor: CatalogueMotor, motion: ServoMotion, *, pause: float = 0.0) -> MotorUtilisation:
    """How much of a motor a motion uses: of the permanent torque, of the peak torque at every speed, and of the highest speed.

    The rms torque over cycle and pause (duty S3) is compared with the permanent torque at the mean speed, as motor makers do.

    Args:
        motor: the motor.
        motion: a motion of a drive with this motor, see `CatalogueMotor.drive`; the torque includes that of the rotor.
        pause: time after each cycle in which the motor carries no current, for instance because a brake holds the press [s].

    Raises:
        PinpressError: the motion's drive has another rotor, or the pause is negative.
    """
    expect("motor", motor, CatalogueMotor, "servo.CatalogueMotor or read_motors")
    expect("motion", motion, ServoMotion, "servo.evaluate or best_motion")
    if abs(motion.drive.inertia - motor.inertia) > ALIKE * motor.inertia:
        raise PinpressError(
            f"motion has a drive whose rotor has {motion.drive.inertia:g} kg m2, but {motor.name} has {motor.inertia:g} kg m2: give a"
            " motion of motor.drive(ratio)"
        )
    idle = number("pause", pause, "s")
    if idle < 0:
        raise PinpressError(f"pause is {idle:g} s, less than 0: give 0 or more")
    duty, size, torque = motion.duration + idle, np.abs(motion.motor_speed), np.abs(motion.motor_torque)
    rms, mean = math.sqrt(motion.heat / duty) / motion.drive.ratio, float(motion.weight @ size) / duty
    rated, used = float(motor.rated_torque_at(mean)), torque / motor.peak_torque_at(size)
    k = int(used.argmax())
    return MotorUtilisation(
        motor.name,
        motion.drive.ratio,
        rms,
        mean,
        rated,
        rms / rated,
        float(used[k]),
        float(motion.angle[k]),
        float(size.max()) / motor.top_speed,
    )


def read_motors(path: str | os.PathLike[str]) -> tuple[CatalogueMotor, ...]:
    """Read the motors of a catalogue: a CSV file with a row for each point of a motor's curves, and these heads (units may differ).

        motor, inertia [kg m2], copper loss [W/(N m)2], speed [r/min], rated torque [N m], peak torque [N m]

    Raises:
        PinpressError: the file cannot be read, does not have these columns, or has no motor; the message names the row.
    """
    table = read_columns(path, CATALOGUE)
    name, rows = table.file, table.rows()
    for line, row in rows:
        if not row["motor"]:
            raise PinpressError(f"{name}, line {line}: the row does not name a motor; write the name of the motor")
    motors = []
    for motor, group in itertools.groupby((row for _, row in rows), key=lambda row: row["motor"]):
        _, inertia, copper, speed, rated, peak = zip(*(row.values() for row in group), strict=True)
        for head, column in (("inertia", inertia), ("copper loss", copper)):
            if len(set(column)) > 1:
                raise PinpressError(f"{name}: {motor} has several values of its {head}: give the same value in all rows of {motor}")
        try:
            motors.append(CatalogueMotor(motor, inertia[0], speed, rated, peak, copper[0]))
        except PinpressError as error:
            raise PinpressError(f"{name}: {error}") from None
    names = [motor.name for motor in motors]
    if twice := sorted({each for each in names if names.count(each) > 1}):
        raise PinpressError(f"{name}: other rows separate the rows of {twice[0]}: put the rows of a motor together")
    if not motors:
        raise PinpressError(f"{name} has no row under its heads: write one for each point of a motor's curves")
    return tuple(motors)
