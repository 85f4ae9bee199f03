"""The motor with an electromagnetic slip clutch and its speed control: Zhang 2007, section 4.3."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..common.arguments import suitable_numbers
from ..common.errors import PinpressError, caution, shown
from ..common.parameters import parameter
from ..common.quantities import RPM, Values
from .electric import ElectricMotor, MotorPower
from .protocol import limit


@dataclass(frozen=True)
class SlipClutchMotor(ElectricMotor):
    """An adjustable-speed motor with electromagnetic slip clutch ("YCT"): Zhang 2007, section 4.3, with closed-loop speed control.

    An induction motor turns the driving half of the clutch at n0, and the excitation current I_f draws the driven half along:
    n = n0 - K T^2 / I_f^4 (4.3.1), so T = I_f^2 sqrt((n0 - n) / K). I_f is a share of its largest value. The thesis prints neither K nor
    the gains. Here K follows from the torque at the top of the speed range with I_f = 1.

    The control is that of its Fig. 4-7: the measured speed, or the share ``feedback`` of it, is taken from the set speed, and an amplifier
    makes the current of the difference: I_f = gain x error, with ``integral_time`` plus the integral of it by this time, between
    ``residual_current`` and 1. (Where the current is at one of its limits, the integral stops at the edge.) Where no amplification is
    given, the gain follows from the regulation, which is met at every set speed up to the top speed: at lower speeds the rated torque
    takes less current.

    The control is lost where the current is at a limit. A load above that of the full current slows the shaft along (4.3.1), whatever is
    set; below that of the residual current the shaft runs up along it; see ``controllable_torque``. With too little feedback the current
    falls only at speeds that the clutch does not reach, see ``control_speeds``: where even the first of these is above n0, the full current
    drives the shaft to its natural speed, whatever is set. Without any, the loop is open.

    It cannot brake: the torque is zero above the speed at which the current is, and above n0. The slope of the torque at n0 is infinite, as
    (4.3.1) has it. Turned backwards the clutch slips more, and (4.3.1) is extrapolated: the torque rises further with the root of the slip.
    (The 30 kW of the thesis's YCT280-4A do not agree with 189 N m at its 1320 r/min, which are 26 kW: they are closer to the power of its
    induction motor, slip power included.)

    The clutch turns T (n0 - n) into heat by eddy currents. Losses of the induction motor and of the excitation are given in addition.

    Attributes:
        rated_torque: [N m].
        primary_speed: n0, constant speed of the driving half [rad/s].
        top_speed: highest speed at which it gives the rated torque [rad/s]; below primary_speed.
        set_speed: that the control holds [rad/s]; at most top_speed.
        regulation: drop of speed from the set speed, where there is no torque, to the rated torque, as a share of the set speed; below 1.
        lag: time constant with which the excitation current follows the amplifier [s]; 0: at once. With a lag the current is the first
            state; it is zero at the start, when the motor is switched on.
        inertia: of the driven half [kg m2], or (S,).
        amplification: of the control: current, as a share of its largest value, by speed error [s/rad]; in place of the regulation.
        integral_time: of the control [s]; None: it is proportional. The integral, as a share of the largest current, is the last state, and
            zero at the start.
        feedback: share of the measured speed that is fed back; 1: as much as the set speed stands for; 0: the loop is open.
        residual_current: least current, as a share of the largest: what the clutch still draws along unexcited; below 1.
        excitation_power: of the largest current [W]; it goes with the square of the current.
        load_loss: loss of the induction motor at the rated torque that grows with the square of the torque [W]; None: no such loss, so
            the power from the mains is a lower bound.
        constant_loss: losses of the induction motor in iron, bearings and fan [W].
        rated_rise: final temperature rise at the rated torque and the top speed [K]; None: temperatures are not computed.
        thermal_time: time constant of its temperature [s]; None: not known.
    """

    rated_torque: float = field(metadata=parameter("N m", "positive"))
    primary_speed: float = field(metadata=parameter("rad/s", "positive"))
    top_speed: float = field(metadata=parameter("rad/s", "positive"))
    set_speed: float = field(metadata=parameter("rad/s", "positive"))
    regulation: float = field(default=0.025, metadata=parameter("-", "positive"))
    lag: float = field(default=0.0, metadata=parameter("s", "not negative"))
    inertia: Values = field(default=0.0, metadata=parameter("kg m2", "not negative", scenarios=True))
    amplification: float | None = field(default=None, kw_only=True, metadata=parameter("s/rad", "positive"))
    integral_time: float | None = field(default=None, kw_only=True, metadata=parameter("s", "positive"))
    feedback: float = field(default=1.0, kw_only=True, metadata=parameter("-", "not negative"))
    residual_current: float = field(default=0.0, kw_only=True, metadata=parameter("-", "not negative"))
    excitation_power: float = field(default=0.0, kw_only=True, metadata=parameter("W", "not negative"))

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, what in (("regulation", "the set speed below 1, e.g. 0.025"), ("residual_current", "the largest below 1, e.g. 0.1")):
            if not getattr(self, name) < 1:
                raise PinpressError(f"SlipClutchMotor: {name} is {shown(getattr(self, name))}; give a share of {what}")
        if not self.top_speed < self.primary_speed:
            raise PinpressError(
                f"SlipClutchMotor: top_speed is {self.top_speed / RPM:.6g} r/min, primary_speed {self.primary_speed / RPM:.6g} r/min;"
                " give a top_speed below it [rad/s]: the clutch pulls only where it slips"
            )
        if not self.set_speed <= self.top_speed:
            raise PinpressError(
                f"SlipClutchMotor: set_speed is {self.set_speed / RPM:.6g} r/min, top_speed {self.top_speed / RPM:.6g} r/min;"
                " give a set_speed of at most that [rad/s]"
            )
        if self.feedback and self.integral_time is None and self.control_speeds[0] >= self.primary_speed:
            caution(
                f"SlipClutchMotor: with feedback {self.feedback:g} it has its full current up to primary_speed, and runs without control;"
                f" give more than {(self.set_speed - 1.0 / self.gain) / self.primary_speed:.4g}, or 0 for an open loop"
            )

    @property
    def state(self) -> tuple[float, ...]:
        return (0.0,) * ((self.lag > 0) + (self.integral_time is not None))

    @property
    def timed(self) -> bool:
        return bool(self.state)

    @property
    def corners(self) -> tuple[Values, ...]:
        """Speeds at which the amplifier leaves its largest current, and at which it reaches its least; n0, where the clutch has current
        there."""
        if self.timed:
            return ()
        limits = self.control_speeds if self.feedback else ()
        return (*limits, self.primary_speed) if self.excitation(self.primary_speed) else limits

    @cached_property
    def gain(self) -> float:
        """Gain of the amplifier: excitation current, as a share of its largest value, by speed error [s/rad]."""
        if self.amplification is not None:
            return self.amplification
        drop = self.regulation * self.set_speed
        rated = (self.primary_speed - self.top_speed) / (self.primary_speed - self.set_speed + drop)  # to the fourth power
        return math.sqrt(math.sqrt(rated)) / drop

    @property
    def control_speeds(self) -> tuple[float, float]:
        """Speeds between which the amplifier sets the current, without its integral: at the first it is full, at the second it is least
        [rad/s]; infinite without feedback."""
        full, least = self.set_speed - 1.0 / self.gain, self.set_speed - self.residual_current / self.gain
        return (full / self.feedback, least / self.feedback) if self.feedback else (math.inf, math.inf)

    def controllable_torque(self, speed: Values) -> tuple[Values, Values]:
        """Least and largest torque (...) that the control can set at a speed (...) [N m, rad/s]: with the residual and with the full
        current. A load beyond them is without control."""
        most = self._of_current(1.0, speed)
        return self.residual_current * self.residual_current * most, most

    def speed_under(self, torque: Values, current: Values = 1.0) -> Values:
        """Speed n0 - K T^2 / I_f^4 (...) of (4.3.1) under torques (...) [N m] with currents (...), as shares of the largest [rad/s].

        Raises:
            PinpressError: a torque is negative, or a current not above 0 and at most 1.
        """
        load = suitable_numbers("speed_under: torque", torque, "finite numbers [N m], not negative", None, lambda each: np.all(each >= 0))
        share = suitable_numbers(
            "speed_under: current", current, "shares of the largest current, above 0", None, lambda each: np.all((each > 0) & (each <= 1))
        )
        speed = self.primary_speed - (self.primary_speed - self.top_speed) * (load / (self.rated_torque * share**2)) ** 2
        return float(speed) if np.ndim(speed) == 0 else speed

    def excitation(self, speed: Values, integral: Values = 0.0) -> Values:
        """Excitation current that the amplifier demands, residual_current to 1; ``integral``: of the control."""
        return limit(self.residual_current, self.gain * (self.set_speed - self.feedback * speed) + integral, 1.0)

    def _current(self, speed: Values, state: tuple[Values, ...]) -> Values:
        """The excitation current."""
        if self.lag and state:
            return state[0]
        return self.excitation(speed, state[-1] if state else 0.0)

    def _of_current(self, current: Values, speed: Values) -> Values:
        share = limit(0.0, (self.primary_speed - speed) / (self.primary_speed - self.top_speed), math.inf)
        return self.rated_torque * (current * current) * share**0.5

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        """See `Drive.torque`. ``state``: the excitation current if there is a lag, then the integral of the control if it has one; without
        states it is the current that the proportional amplifier demands."""
        return self._of_current(self._current(speed, state), speed)

    def rates(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> tuple[Values, ...]:
        integral = state[-1] if self.integral_time is not None else 0.0
        demanded = self.excitation(speed, integral)
        rates = ((demanded - state[0]) / self.lag,) if self.lag else ()
        return rates if self.integral_time is None else (*rates, (demanded - integral) / self.integral_time)

    def slip_power(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        """Power lost in the clutch, T (n0 - n) [W]; arguments as for ``torque``."""
        return self.torque(speed, angle, time, state) * (self.primary_speed - speed)

    @property
    def rated_slip_loss(self) -> float:
        """Loss in the clutch at the rated torque and the top speed [W]."""
        return self.rated_torque * (self.primary_speed - self.top_speed)

    @property
    def rated_heat(self) -> float:
        """All losses at the rated torque and the top speed [W]."""
        return self.rated_slip_loss + (self.load_loss or 0.0) + self.excitation_power + self.constant_loss

    def power(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> MotorPower:
        """Where the power of motor and clutch goes; arguments as for ``torque``."""
        current, zero = self._current(speed, state), 0.0 * speed
        torque = self._of_current(current, speed)
        load = (self.load_loss or 0.0) * (torque / self.rated_torque) ** 2 + self.excitation_power * current * current
        return MotorPower(torque * speed, torque * (self.primary_speed - speed), load, zero + self.constant_loss, zero, zero)
