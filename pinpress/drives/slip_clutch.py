"""The motor with electromagnetic slip clutch and speed control of Zhang 2007."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from ..common.errors import PinpressError, shown
from ..common.scenario_numbers import check
from ..common.units import RPM
from .protocol import SpeedTorqueDrive, Values, between


@dataclass(frozen=True)
class SlipClutchMotor(SpeedTorqueDrive):
    """An adjustable-speed motor with electromagnetic slip clutch ("YCT"): Zhang 2007, section 4.3, with closed-loop speed control.

    An induction motor turns the clutch's driving half at n0, the excitation current I_f pulls the driven half after it:
    n = n0 - K T^2 / I_f^4 (4.3.1), so T = I_f^2 sqrt((n0 - n) / K). I_f is in shares of its largest value. A proportional amplifier sets
    it from the set speed less the tachometer's, between 0 and 1. K and its gain are ours, as the thesis prints none: K from the torque at
    the top of the speed range with I_f = 1, the gain from the regulation. That is met at every set speed up to the top speed: the lower
    the speed, the less current the rated torque takes.

    It cannot brake: the torque is zero from the set speed on, or with a lag while there is current, from n0 on. There its slope is
    infinite, as (4.3.1) has it; without a lag n0 is out of reach. Turned backwards the clutch slips more, and (4.3.1) is taken on: the
    torque rises further, with the root of the slip. (The 30 kW of the thesis's YCT280-4A are not 189 N m at its 1320 r/min, which are
    26 kW: they are nearer to what its induction motor gives, slip power included.)

    Attributes:
        rated_torque: [N m]. primary_speed: n0, of the driving half, constant [rad/s].
        top_speed: highest speed of its range at which it gives the rated torque [rad/s]; below primary_speed.
        set_speed: that the control holds [rad/s]; at most top_speed.
        regulation: drop of speed from the set speed, where it gives no torque, to the rated torque, by the set speed; below 1.
        lag: time constant with which the excitation current follows the amplifier [s]; 0: at once. With a lag the current is the one
            state, zero at the start: switched on.
        inertia: of the driven half [kg m2], or (S,).
    """

    per_scenario: ClassVar[Mapping[str, int]] = {"inertia": 0}

    rated_torque: float
    primary_speed: float
    top_speed: float
    set_speed: float
    regulation: float = 0.025
    lag: float = 0.0
    inertia: Values = 0.0

    def __post_init__(self) -> None:
        check(self, "rated_torque", "positive", "N m")
        for field in ("primary_speed", "top_speed", "set_speed"):
            check(self, field, "positive", "rad/s")
        check(self, "regulation", "positive", "-")
        check(self, "lag", "not negative", "s")
        check(self, "inertia", "not negative", "kg m2", scenarios=True)
        if not self.regulation < 1:
            raise PinpressError(
                f"SlipClutchMotor: regulation is {shown(self.regulation)}; give a share of the set speed below 1, e.g. 0.025"
            )
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

    @property
    def state(self) -> tuple[float, ...]:
        return (0.0,) if self.lag else ()

    @property
    def timed(self) -> bool:
        return self.lag > 0

    @property
    def corners(self) -> tuple[Values, ...]:
        """Where the amplifier comes off its largest current, and where it reaches zero."""
        return () if self.lag else (self.set_speed - 1.0 / self.gain, self.set_speed)

    @cached_property
    def gain(self) -> float:
        """Of the amplifier: excitation current, in shares of its largest, by speed error [s/rad]."""
        drop = self.regulation * self.set_speed
        rated = (self.primary_speed - self.top_speed) / (self.primary_speed - self.set_speed + drop)  # to the fourth power
        return math.sqrt(math.sqrt(rated)) / drop

    def excitation(self, speed: Values) -> Values:
        """Excitation current that the amplifier asks for, 0 to 1."""
        return between(0.0, self.gain * (self.set_speed - speed), 1.0)

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        """As `Drive.torque`; ``state`` is the excitation current: without it that which the amplifier asks for."""
        current = state[0] if state else self.excitation(speed)
        share = between(0.0, (self.primary_speed - speed) / (self.primary_speed - self.top_speed), math.inf)
        return self.rated_torque * (current * current) * share**0.5

    def rates(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> tuple[Values, ...]:
        return ((self.excitation(speed) - state[0]) / self.lag,) if self.lag else ()

    def slip_power(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        """Power lost in the clutch, T (n0 - n) [W]; arguments as of ``torque``."""
        return self.torque(speed, angle, time, state) * (self.primary_speed - speed)
