"""Motors: the torque on their shaft at a speed, and the inertia that turns with it. They know no press.

Torques and speeds are positive along the motor's shaft, which it turns in the positive direction; ``Geared(motor, -1.0)`` turns it round.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..common import plausibility
from ..common.arguments import is_whole_number, suitable_numbers, truth_value
from ..common.errors import PinpressError, caution, shown
from ..common.parameters import parameter, set_field
from ..common.quantities import RPM, Array, Values
from .electric import ElectricMotor, MotorPower, check_load_loss, check_thermal_time
from .protocol import SpeedTorqueDrive, limit

MOST_SLIP = 0.5  # no motor has more at its rated point


@dataclass(frozen=True)
class ConstantTorque(SpeedTorqueDrive):
    """The same torque at every speed: the M_d of Zhang 2007, section 4.2. It has no inertia: give a `Flywheel`.

    Attributes:
        value: the torque [N m], on a driver that slides the force, a plain number [N], or (S,) for S scenarios; negative: backwards.
    """

    value: Values = field(metadata=parameter("N m", scenarios=True))

    @property
    def heeds_speed(self) -> bool:
        return False

    @property
    def inertia(self) -> Values:
        return 0.0

    @property
    def rated_torque(self) -> Values | None:
        return None

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        return self.value + 0.0 * speed  # in the shape of the speed


@dataclass(frozen=True)
class InductionMotor(ElectricMotor):
    """An induction motor on the mains, from its nameplate, by Kloss's formula: T = 2 Tb / (s / sb + sb / s) with slip s.

    It drives below its synchronous speed and brakes above it, as a generator; turned backwards it drives against the motion. The slip sb of
    the breakdown torque Tb = breakdown_ratio x rated torque is such that the curve passes through the rated point. Electrical transients
    and the skin effect at standstill are neglected.

    Attributes:
        rated_power: [W], or (S,) for S scenarios.
        rated_speed: [rad/s], below the synchronous speed.
        frequency: of the mains [Hz].
        poles: number of poles (twice that of pole pairs).
        breakdown_ratio: breakdown torque by rated torque, above 1.
        inertia: of the rotor [kg m2], or (S,).
        load_loss: losses at the rated point that grow with the square of the current, including losses by slip [W]; None: only the
            losses by slip count, so the power from the mains is a lower bound.
        constant_loss: losses in iron, bearings and fan [W].
        rated_rise: final temperature rise of the motor at the rated point [K]; None: temperatures are not computed.
        thermal_time: time constant of its temperature [s]; None: not known.
    """

    rated_power: Values = field(metadata=parameter("W", "positive", scenarios=True))
    rated_speed: float = field(metadata=parameter("rad/s", "positive"))
    frequency: float = field(default=50.0, metadata=parameter("Hz", "positive"))
    poles: int = 4
    breakdown_ratio: float = field(default=2.5, metadata=parameter("-", "positive"))
    inertia: Values = field(default=0.0, metadata=parameter("kg m2", "not negative", scenarios=True))

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_breakdown(self, self.breakdown_ratio)
        _check_rated_speed(self, self.rated_speed, self.frequency, self.poles)
        check_load_loss(self)
        in_watts = "rated_power in W"
        plausibility.motor("InductionMotor", self.rated_torque, self.rated_speed, self.inertia, in_watts, self.constant_loss)

    @cached_property
    def synchronous_speed(self) -> float:
        """4 pi f / poles [rad/s]."""
        return _synchronous(self.frequency, self.poles)

    @property
    def reversals(self) -> tuple[float, ...]:
        return (self.synchronous_speed,)

    @cached_property
    def rated_torque(self) -> Values:
        return self.rated_power / self.rated_speed

    @cached_property
    def breakdown_torque(self) -> Values:
        """Largest torque [N m]; (S,) if the power is."""
        return self.breakdown_ratio * self.rated_torque

    @cached_property
    def breakdown_speed(self) -> float:
        """Speed of the largest torque, (1 - sb) x synchronous speed [rad/s]; negative where sb > 1."""
        return self.synchronous_speed - self._breakdown_lag

    @cached_property
    def _breakdown_lag(self) -> float:
        """sb x synchronous speed: x = sN / sb solves x + 1 / x = 2 Tb / TN, and is below 1."""
        ratio = self.breakdown_ratio
        return (self.synchronous_speed - self.rated_speed) * (ratio + math.sqrt(ratio * ratio - 1.0))

    @cached_property
    def _twice_breakdown_torque(self) -> Values:
        return 2.0 * self.breakdown_torque

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        lag = self._breakdown_lag
        slip = self.synchronous_speed - speed
        most = slip * slip  # in place from here, because many scenarios have large arrays
        most += lag * lag
        slip /= most  # harmless at s = 0
        return self._twice_breakdown_torque * lag * slip

    @property
    def rated_slip_loss(self) -> Values:
        return self.rated_torque * (self.synchronous_speed - self.rated_speed)

    def power(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> MotorPower:
        """Where the motor's power goes. Above its synchronous speed it brakes, and feeds the mains; arguments as for ``torque``."""
        torque, zero = self.torque(speed), 0.0 * speed
        slip = torque * (self.synchronous_speed - speed)
        return MotorPower(torque * speed, slip, self._load_by_slip * slip, zero + self.constant_loss, zero, zero)


@dataclass(frozen=True)
class InverterMotor(ElectricMotor):
    """An induction motor on an inverter that holds one frequency.

    Up to the rated frequency fN the flux is constant. Above it the voltage is constant, and the flux falls with fN / f (field weakening).
    The torque is a slope times the speed by which the shaft lags behind the synchronous speed. The slope is the rated torque by the rated
    lag, above fN times (fN / f)^2. The inverter limits the torque in both directions to `torque_limit`.

    Attributes:
        rated_torque: at the rated frequency [N m].
        rated_speed: at the rated frequency [rad/s], below the synchronous speed.
        frequency: at which it runs [Hz].
        rated_frequency: [Hz].
        poles: number of poles (twice that of pole pairs).
        overload: largest torque that the inverter allows by the permanent torque.
        breakdown_ratio: breakdown torque at the rated flux by rated torque, above 1.
        curve: pairs of rising frequency [Hz] and largest torque [N m], as from a catalogue, with straight lines between; in place of
            overload and breakdown_ratio.
        inertia: of the rotor [kg m2], or (S,).
        inverter_efficiency: of the inverter, in both directions; at most 1.
        feeds_back: whether braking feeds the mains through the inverter, which else burns it in a resistor.
        load_loss: losses at the rated point that grow with the square of the current, including losses by slip [W]; None: only the
            losses by slip count, so the power from the mains is a lower bound.
        constant_loss: losses in iron, bearings and fan [W], here at every frequency.
        rated_rise: final temperature rise of the motor at the rated point [K]; None: temperatures are not computed.
        thermal_time: time constant of its temperature [s]; None: not known.
    """

    rated_torque: float = field(metadata=parameter("N m", "positive"))
    rated_speed: float = field(metadata=parameter("rad/s", "positive"))
    frequency: float = field(metadata=parameter("Hz", "positive"))
    rated_frequency: float = field(default=50.0, metadata=parameter("Hz", "positive"))
    poles: int = 4
    overload: float = field(default=1.5, metadata=parameter("-", "positive"))
    breakdown_ratio: float = field(default=2.5, metadata=parameter("-", "positive"))
    curve: Sequence[tuple[float, float]] | None = None
    inertia: Values = field(default=0.0, metadata=parameter("kg m2", "not negative", scenarios=True))
    inverter_efficiency: float = field(default=1.0, kw_only=True, metadata=parameter("-", "positive"))
    feeds_back: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_breakdown(self, self.breakdown_ratio)
        _check_rated_speed(self, self.rated_speed, self.rated_frequency, self.poles)
        if self.curve is not None:
            set_field(self, "curve", _curve(self, self.curve))
        self.torque_limit(self.frequency)  # its frequency must lie on the curve
        check_load_loss(self)
        if self.inverter_efficiency > 1:
            raise PinpressError(f"InverterMotor: inverter_efficiency is {shown(self.inverter_efficiency)}; give a share of at most 1")
        truth_value("InverterMotor: feeds_back", self.feeds_back)
        plausibility.share("InverterMotor: overload", self.overload, plausibility.STEEPEST)
        plausibility.motor("InverterMotor", self.rated_torque, self.rated_speed, self.inertia, lossless=self.constant_loss)

    @cached_property
    def synchronous_speed(self) -> float:
        """4 pi f / poles at the frequency it runs at [rad/s]."""
        return _synchronous(self.frequency, self.poles)

    @property
    def reversals(self) -> tuple[float, ...]:
        return (self.synchronous_speed,)

    @property
    def corners(self) -> tuple[Values, ...]:
        """Speeds at which the limit sets in, in driving and in braking."""
        lag = self._limit / self._slope
        return (self.synchronous_speed - lag, self.synchronous_speed + lag)

    def torque_limit(self, frequency: Values) -> Values:
        """Largest torque [N m] at frequencies [Hz] of any shape.

        It is that of the ``curve``; else overload x rated torque, which above the rated frequency falls with fN / f as the permanent torque
        in Kong 2025, fig. 1, or the breakdown torque where that is smaller, which falls with (fN / f)^2.

        Raises:
            PinpressError: a frequency is not positive, or off the curve.
        """
        hertz = suitable_numbers("InverterMotor: frequency", frequency, "a positive number [Hz]", None, lambda values: values > 0)
        if self.curve is not None:
            frequencies, torques = np.array(self.curve).T
            if not np.all((hertz >= frequencies[0]) & (hertz <= frequencies[-1])):
                raise PinpressError(
                    f"InverterMotor: frequency is {shown(frequency)}, off its curve, which spans {frequencies[0]:g} to"
                    f" {frequencies[-1]:g} Hz;"
                    " give one on it, or a longer curve"
                )
            torque = np.interp(hertz, frequencies, torques)
        else:
            flux = np.minimum(1.0, self.rated_frequency / hertz)
            torque = self.rated_torque * np.minimum(self.overload * flux, self.breakdown_ratio * flux**2)
        return float(torque) if np.ndim(torque) == 0 else torque

    @cached_property
    def _limit(self) -> float:
        return float(self.torque_limit(self.frequency))

    @cached_property
    def _slope(self) -> float:
        """Torque by the lag behind the synchronous speed [N m s/rad]."""
        flux = min(1.0, self.rated_frequency / self.frequency)
        return flux**2 * self.rated_torque / (_synchronous(self.rated_frequency, self.poles) - self.rated_speed)

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        return limit(-self._limit, self._slope * (self.synchronous_speed - speed), self._limit)

    @property
    def rated_slip_loss(self) -> Values:
        return self.rated_torque * (_synchronous(self.rated_frequency, self.poles) - self.rated_speed)

    def power(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> MotorPower:
        """Where the power of motor and inverter goes; arguments as for ``torque``.

        The slip is torque by slope, also where the inverter limits the torque, because it then lowers its frequency. In a weakened field a
        torque takes a current that is larger by f / fN, and losses by the square of that.
        """
        torque, zero = self.torque(speed), 0.0 * speed
        slip = torque * torque / self._slope
        load = self._load_by_slip * slip
        into = torque * speed + slip + load + self.constant_loss  # at the motor's terminals
        driving, braking = np.maximum(into, 0.0), np.maximum(-into, 0.0)
        lost = driving * (1.0 / self.inverter_efficiency - 1.0)
        if self.feeds_back:
            return MotorPower(
                torque * speed, slip, load, zero + self.constant_loss, lost + braking * (1.0 - self.inverter_efficiency), zero
            )
        return MotorPower(torque * speed, slip, load, zero + self.constant_loss, lost, braking)


def _synchronous(frequency: float, poles: int) -> float:
    return 4.0 * math.pi * frequency / poles


def _check_breakdown(drive: object, ratio: float) -> None:
    if not ratio > 1:
        raise PinpressError(f"{type(drive).__name__}: breakdown_ratio is {shown(ratio)}; give breakdown by rated torque, above 1, e.g. 2.5")
    plausibility.share(f"{type(drive).__name__}: breakdown_ratio", ratio, plausibility.STEEPEST)


def _check_rated_speed(drive: object, rated_speed: float, frequency: float, poles: object) -> None:
    if not is_whole_number(poles) or not 2 <= poles <= 1000 or poles % 2:
        raise PinpressError(f"{type(drive).__name__}: poles is {shown(poles)}; give the number of poles: 2, 4, 6, ...")
    synchronous = _synchronous(frequency, int(poles))
    if not rated_speed < synchronous:
        in_rpm = (1 - MOST_SLIP) * synchronous < rated_speed * RPM < synchronous
        meant = f"; if {rated_speed:g} r/min are meant, write {rated_speed:g} * pp.RPM" if in_rpm else ""
        raise PinpressError(
            f"{type(drive).__name__}: rated_speed is {rated_speed / RPM:.6g} r/min, the synchronous speed at {frequency:g} Hz with"
            f" {poles} poles {synchronous / RPM:.6g} r/min; give a rated_speed below it [rad/s]{meant}"
        )
    if rated_speed < (1 - MOST_SLIP) * synchronous:
        caution(
            f"{type(drive).__name__}: rated_speed is {rated_speed / RPM:.6g} r/min, less than half of the synchronous speed,"
            f" {synchronous / RPM:.6g} r/min at {frequency:g} Hz with {poles} poles; see to all three, frequencies in Hz"
        )


def _curve(drive: object, given: object) -> tuple[tuple[float, float], ...]:
    name, wanted = f"{type(drive).__name__}: curve", "two or more pairs (frequency [Hz], torque [N m]), all positive"
    pairs = suitable_numbers(name, given, wanted, (None, 2), lambda pairs: len(pairs) > 1 and np.all(pairs > 0))
    if not np.all(np.diff(pairs[:, 0]) > 0):
        raise PinpressError(f"{type(drive).__name__}: the frequencies of its curve are {pairs[:, 0].tolist()}; give them rising")
    return tuple((frequency, torque) for frequency, torque in pairs.tolist())


@dataclass(frozen=True)
class ServoMotor(SpeedTorqueDrive):
    """A servo motor that follows a motion program of its shaft.

    The program is the cubic spline through its points that stands still at both ends, because the shaft is held at the first angle before
    and at the last one afterwards: its speed does not jump. For a run that begins in the middle of a motion the program begins earlier, at
    a negative time. The torque is stiffness x error of angle + damping x error of speed, limited to the peak torque.

    Attributes:
        times: (k,) rising times of the program's points [s].
        angles: (k,) angles of the shaft at these times [rad].
        stiffness: [N m/rad].
        damping: [N m s/rad].
        peak_torque: [N m].
        inertia: of the rotor [kg m2], or (S,) for S scenarios.
        rated_torque: permanent torque [N m]; None: not known.
        copper: heat in the windings by the torque's square, R / kt² [W/(N m)²].
        iron: loss in the iron by the speed's square [W s2/rad2].
        constant_loss: losses of motor and controller that do not depend on torque and speed [W].
        regeneration: share of the power of braking that is used again, by other axes, the mains or a capacitor that is large enough (see
            `pinpress.servo.capacitor`); the rest is burnt in a resistor.
        rated_rise: final temperature rise of the motor that holds its permanent torque [K], by ``copper`` and ``constant_loss``; it
            needs ``rated_torque``. None: temperatures are not computed.
        thermal_time: time constant of its temperature [s]; None: not known.
    """

    times: Sequence[float] | Array
    angles: Sequence[float] | Array
    stiffness: float = field(metadata=parameter("N m/rad", "positive"))
    damping: float = field(metadata=parameter("N m s/rad", "not negative"))
    peak_torque: float = field(metadata=parameter("N m", "positive"))
    inertia: Values = field(default=0.0, metadata=parameter("kg m2", "not negative", scenarios=True))
    rated_torque: float | None = field(default=None, metadata=parameter("N m", "positive"))
    copper: float = field(default=0.0, kw_only=True, metadata=parameter("W/(N m)2", "not negative"))
    iron: float = field(default=0.0, kw_only=True, metadata=parameter("W s2/rad2", "not negative"))
    constant_loss: float = field(default=0.0, kw_only=True, metadata=parameter("W", "not negative"))
    regeneration: float = field(default=1.0, kw_only=True, metadata=parameter("-", "not negative"))
    rated_rise: float | None = field(default=None, kw_only=True, metadata=parameter("K", "positive"))
    thermal_time: float | None = field(default=None, kw_only=True, metadata=parameter("s", "positive"))

    def __post_init__(self) -> None:
        super().__post_init__()
        check_thermal_time(self, self.thermal_time)
        plausibility.rise("ServoMotor: rated_rise", self.rated_rise)
        if self.regeneration > 1:
            raise PinpressError(f"ServoMotor: regeneration is {shown(self.regeneration)}; give a share from 0 to 1")
        if self.rated_rise is not None and (self.rated_torque is None or not self.copper):
            raise PinpressError("ServoMotor: rated_rise is by the heat at the permanent torque: give rated_torque= and copper= too")
        for name, unit in (("times", "s"), ("angles", "rad")):
            wanted = f"two or more finite numbers [{unit}]"
            values = suitable_numbers(f"ServoMotor: {name}", getattr(self, name), wanted, (None,), lambda values: len(values) > 1)
            set_field(self, name, tuple(values.tolist()))
        if len(self.times) != len(self.angles):
            raise PinpressError(f"ServoMotor: {len(self.times)} times and {len(self.angles)} angles; give an angle at each time")
        if not np.all(np.diff(self.times) > 0):
            k = int(np.argmin(np.diff(self.times) > 0))
            raise PinpressError(f"ServoMotor: times go from {self.times[k]:g} to {self.times[k + 1]:g} s; give them rising")

    @property
    def timed(self) -> bool:
        return True

    def program(self, time: Values) -> tuple[Values, Values]:
        """Angle [rad] and speed [rad/s] of the program at times [s] of any shape."""
        # integrators ask for one number at a time, for which an array takes forty times as long
        start, a, b, c, d = (
            self._rows[bisect_right(self.times, time)]
            if isinstance(time, float)
            else np.moveaxis(self._pieces[np.searchsorted(self._pieces[1:, 0], time, "right")], -1, 0)
        )
        t = time - start
        return a + t * (b + t * (c + t * d)), b + t * (2.0 * c + t * (3.0 * d))

    @cached_property
    def _pieces(self) -> Array:
        """(k + 1, 5): start of each piece of the program and its polynomial, constant first. In the first and last piece the shaft is
        held."""
        from scipy.interpolate import CubicSpline  # to save start-up time

        spline = CubicSpline(self.times, self.angles, bc_type="clamped")
        pieces = np.zeros((len(self.times) + 1, 5))
        pieces[:, 0] = [self.times[0], *self.times]
        pieces[1:-1, 1:] = spline.c[::-1].T
        pieces[[0, -1], 1] = self.angles[0], self.angles[-1]
        return pieces

    @cached_property
    def _rows(self) -> list[list[float]]:
        rows: list[list[float]] = self._pieces.tolist()
        return rows

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        wanted_angle, wanted_speed = self.program(time)
        torque = self.stiffness * (wanted_angle - angle) + self.damping * (wanted_speed - speed)
        return limit(-self.peak_torque, torque, self.peak_torque)

    def power(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> MotorPower:
        """Where the power of motor and controller goes, by the losses of `pinpress.servo.ServoDrive`; arguments as for ``torque``."""
        torque = self.torque(speed, angle, time)
        shaft, copper, iron = torque * speed, self.copper * torque * torque, self.constant_loss + self.iron * speed * speed
        braking = np.maximum(-(shaft + copper + iron), 0.0)
        return MotorPower(shaft, load=copper, constant=iron, resistor=(1.0 - self.regeneration) * braking)

    @property
    def thermal_resistance(self) -> float | None:
        """Final temperature rise by heat [K/W]; None if the rise at the permanent torque is not known."""
        if self.rated_rise is None or self.rated_torque is None:
            return None
        return self.rated_rise / (self.copper * self.rated_torque**2 + self.constant_loss)
