"""Motors by their nameplates: induction motors on the mains and on inverters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..common.checks import finite_numbers
from ..common.errors import PinpressError, shown
from ..common.scenario_numbers import check, check_scenarios, set_field
from ..common.units import RPM
from .protocol import SpeedTorqueDrive, Values, between

MOST_POLES = 1000


@dataclass(frozen=True)
class InductionMotor(SpeedTorqueDrive):
    """An induction motor on the mains, from its nameplate, by Kloss's formula: T = 2 Tb / (s / sb + sb / s) with slip s.

    It drives below its synchronous speed and brakes above it, as a generator; turned backwards it drives on against the motion. The slip
    sb of the breakdown torque Tb = breakdown_ratio x rated torque is that at which the curve passes through the rated point. Electrical
    transients and the skin effect at standstill are left out.

    Attributes:
        rated_power: [W], or (S,). rated_speed: [rad/s], below the synchronous one. frequency: of the mains [Hz].
        poles: number of poles (twice that of pole pairs). breakdown_ratio: breakdown torque by rated torque, above 1.
        inertia: of the rotor [kg m2], or (S,).
    """

    per_scenario: ClassVar[Mapping[str, int]] = {"rated_power": 0, "inertia": 0}

    rated_power: Values
    rated_speed: float
    frequency: float = 50.0
    poles: int = 4
    breakdown_ratio: float = 2.5
    inertia: Values = 0.0

    def __post_init__(self) -> None:
        check(self, "rated_power", "positive", "W", scenarios=True)
        check(self, "rated_speed", "positive", "rad/s")
        check(self, "frequency", "positive", "Hz")
        _check_breakdown(self, self.breakdown_ratio)
        check(self, "inertia", "not negative", "kg m2", scenarios=True)
        check_scenarios(self, "rated_power", "inertia")
        _check_rated_speed(self, self.rated_speed, self.frequency, self.poles)

    @cached_property
    def synchronous_speed(self) -> float:
        """4 pi f / poles [rad/s]."""
        return _synchronous(self.frequency, self.poles)

    @cached_property
    def rated_torque(self) -> Values:
        return self.rated_power / self.rated_speed

    @cached_property
    def breakdown_torque(self) -> Values:
        """Largest torque [N m]; (S,) where the power is."""
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
        slip = (self.synchronous_speed - speed) / self._breakdown_lag  # s / sb
        return self._twice_breakdown_torque * (slip / (1.0 + slip * slip))  # harmless at s = 0


@dataclass(frozen=True)
class InverterMotor(SpeedTorqueDrive):
    """An induction motor on an inverter that holds one frequency.

    Up to the rated frequency fN the flux is constant, above it the voltage is, and the flux falls with fN / f: field weakening. The torque
    is a slope times the speed by which the shaft lags behind the synchronous one; the slope is the rated torque by the rated lag, times
    (fN / f)^2 above fN. The inverter limits it, both ways, to `torque_limit`.

    Attributes:
        rated_torque: at the rated frequency [N m]. rated_speed: there [rad/s], below the synchronous one.
        frequency: that it runs at [Hz]. rated_frequency: [Hz]. poles: number of poles (twice that of pole pairs).
        overload: largest torque the inverter allows, by the permanent one.
        breakdown_ratio: breakdown torque at the rated flux by rated torque, above 1.
        curve: pairs of frequency [Hz], rising, and largest torque [N m]: a catalogue's, straight between its points, in place of what
            `torque_limit` works out from overload and breakdown_ratio.
        inertia: of the rotor [kg m2], or (S,).
    """

    per_scenario: ClassVar[Mapping[str, int]] = {"inertia": 0}

    rated_torque: float
    rated_speed: float
    frequency: float
    rated_frequency: float = 50.0
    poles: int = 4
    overload: float = 1.5
    breakdown_ratio: float = 2.5
    curve: Sequence[tuple[float, float]] | None = None
    inertia: Values = 0.0

    def __post_init__(self) -> None:
        check(self, "rated_torque", "positive", "N m")
        check(self, "rated_speed", "positive", "rad/s")
        check(self, "frequency", "positive", "Hz")
        check(self, "rated_frequency", "positive", "Hz")
        check(self, "overload", "positive", "-")
        _check_breakdown(self, self.breakdown_ratio)
        check(self, "inertia", "not negative", "kg m2", scenarios=True)
        _check_rated_speed(self, self.rated_speed, self.rated_frequency, self.poles)
        if self.curve is not None:
            set_field(self, "curve", _curve(self, self.curve))
        self.torque_limit(self.frequency)  # its frequency must lie on the curve

    @cached_property
    def synchronous_speed(self) -> float:
        """4 pi f / poles at the frequency it runs at [rad/s]."""
        return _synchronous(self.frequency, self.poles)

    @property
    def corners(self) -> tuple[Values, ...]:
        """Where the limit sets in: driving, braking."""
        lag = self._limit / self._slope
        return (self.synchronous_speed - lag, self.synchronous_speed + lag)

    def torque_limit(self, frequency: Values) -> Values:
        """Largest torque [N m] at frequencies [Hz] of any shape: the ``curve``, or overload x rated torque up to the rated frequency
        and falling with fN / f above it, as Kong 2025, fig. 1, shows of the permanent torque; where the breakdown torque, that falls
        with (fN / f)^2, lies below this, the breakdown torque.

        Raises:
            PinpressError: a frequency that is not positive, or off the curve.
        """
        given = finite_numbers(frequency)
        if given is None or not np.all(given > 0):
            raise PinpressError(f"InverterMotor: frequency is {shown(frequency)}; give a positive number [Hz]")
        if self.curve is not None:
            frequencies, torques = np.array(self.curve).T
            if not np.all((given >= frequencies[0]) & (given <= frequencies[-1])):
                raise PinpressError(
                    f"InverterMotor: frequency is {shown(frequency)}, off its curve, which spans {frequencies[0]:g} to"
                    f" {frequencies[-1]:g} Hz;"
                    " give one on it, or a longer curve"
                )
            torque = np.interp(given, frequencies, torques)
        else:
            flux = np.minimum(1.0, self.rated_frequency / given)
            torque = self.rated_torque * np.minimum(self.overload * flux, self.breakdown_ratio * flux**2)
        return float(torque) if np.ndim(torque) == 0 else torque

    @cached_property
    def _limit(self) -> float:
        return float(self.torque_limit(self.frequency))

    @cached_property
    def _slope(self) -> float:
        """Torque by lag behind the synchronous speed [N m s/rad]."""
        flux = min(1.0, self.rated_frequency / self.frequency)
        return flux**2 * self.rated_torque / (_synchronous(self.rated_frequency, self.poles) - self.rated_speed)

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        return between(-self._limit, self._slope * (self.synchronous_speed - speed), self._limit)


def _synchronous(frequency: float, poles: int) -> float:
    return 4.0 * math.pi * frequency / poles


def _check_breakdown(drive: object, ratio: float) -> None:
    check(drive, "breakdown_ratio", "positive", "-")
    if not ratio > 1:
        raise PinpressError(f"{type(drive).__name__}: breakdown_ratio is {shown(ratio)}; give breakdown by rated torque, above 1, e.g. 2.5")


def _check_rated_speed(drive: object, rated_speed: float, frequency: float, poles: object) -> None:
    if isinstance(poles, bool | np.timedelta64) or not isinstance(poles, int | np.integer) or not 2 <= poles <= MOST_POLES or poles % 2:
        raise PinpressError(f"{type(drive).__name__}: poles is {shown(poles)}; give the number of poles: 2, 4, 6, ...")
    synchronous = _synchronous(frequency, int(poles))
    if not rated_speed < synchronous:
        raise PinpressError(
            f"{type(drive).__name__}: rated_speed is {rated_speed / RPM:.6g} r/min, the synchronous speed at {frequency:g} Hz with"
            f" {poles} poles {synchronous / RPM:.6g} r/min; give a rated_speed below it [rad/s]"
        )


def _curve(drive: object, given: object) -> tuple[tuple[float, float], ...]:
    pairs = finite_numbers(given)
    if pairs is None or pairs.ndim != 2 or pairs.shape[1] != 2 or len(pairs) < 2 or not np.all(pairs > 0):
        raise PinpressError(
            f"{type(drive).__name__}: curve is {shown(given)}; give two or more pairs (frequency [Hz], torque [N m]), all positive"
        )
    if not np.all(np.diff(pairs[:, 0]) > 0):
        raise PinpressError(f"{type(drive).__name__}: the frequencies of its curve are {pairs[:, 0].tolist()}; give them rising")
    return tuple((frequency, torque) for frequency, torque in pairs.tolist())
