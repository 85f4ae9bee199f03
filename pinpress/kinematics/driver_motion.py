"""How the drivers of a linkage move: angle, speed, acceleration and time from any consistent part of them.

States with times are a motion: quantities that are missing are derived, and contradictions are refused with the instant. States without
times, for which angle, speed and acceleration are given, are independent of each other.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.arguments import number, numbers
from ..common.errors import PinpressError, caution
from ..common.quantities import Array, DriverCoordinate
from ..linkage.assembly import refuse_far
from .sampled_column import FEWEST, SampledColumn

KEPT = 1e6  # least length of a step, in roundings of time, with which the step is known
AMISS = 0.05  # share of a motion by which columns of fewer states than `FEWEST` may contradict each other
LEAST = 1e-3  # share of the largest rate that counts as digits lost in printing
CLOSED = 1e-6  # share of a step by which a motion may miss the end of its period
SEAM = 1e-4, 1e-2  # shares of a turn, and of the largest speed, by which the last state of a closed motion may differ from the first
NOISY, COARSE = 0.03, 0.05  # uncertainties of derivatives, as shares of their size, above which noise and long steps dominate them
NOISE_SHARE = 8.0, 5.0  # factors from the uncertainty of a first and of a second derivative to its error by white noise
MOST_ROUNDS = 60  # most rounds in which the times of states are found
SETTLED = 1e-13  # relative change of a step of time that ends these rounds


class Drivers(NamedTuple):
    """The drivers of a linkage.

    Attributes:
        names: names of their joints.
        coordinates: what their coordinates are.
    """

    names: tuple[str, ...]
    coordinates: tuple[DriverCoordinate, ...]

    @property
    def one(self) -> bool:
        """Whether there is one driver alone."""
        return len(self.names) == 1

    @property
    def units(self) -> tuple[str, ...]:
        """Units of angle, speed and acceleration, in words."""
        unit = self.coordinates[0].unit
        return tuple(unit + per for per in ("", "/s", "/s2"))


@dataclass(frozen=True, eq=False)
class DriverMotion:
    """States of the drivers.

    Attributes:
        angle: (n,) of one driver, (n, drivers) of several, as speed and acceleration [rad or m].
        speed: [rad/s or m/s].
        acceleration: [rad/s2 or m/s2].
        time: (n,) [s]; None if the states are no motion in time.
    """

    angle: Array
    speed: Array
    acceleration: Array
    time: Array | None


class _Contradiction(NamedTuple):
    """A state in which a column and its rate contradict each other.

    Attributes:
        state: index of the state.
        driver: index of the driver.
        said: words for the message, with gaps for names and units.
    """

    state: int
    driver: int
    said: str


def driver_motion(
    drivers: Drivers,
    angle: ArrayLike,
    speed: ArrayLike | None,
    acceleration: ArrayLike | None,
    time: ArrayLike | None,
    period: float | None = None,
) -> DriverMotion:
    """The motion of the drivers, with what of it is not given; arguments as of `servo_cycle`.

    Raises:
        PinpressError: as of `servo_cycle`.
    """
    if time is not None:
        return _InTime(drivers, numbers("time", time), period).motion(angle, speed, acceleration)
    if period is not None:
        raise PinpressError("period is given, but no time: give time=..., (n,) [s]; without it a motion is not closed")
    return _by_state(drivers, angle, speed, acceleration)


def _by_state(drivers: Drivers, angle: ArrayLike, speed: ArrayLike | None, acceleration: ArrayLike | None) -> DriverMotion:
    """The motion in states without given times."""
    angles = numbers("angle", angle)
    _refuse_shape(angles, drivers)
    refuse_far("angle", angles, drivers.coordinates)
    if speed is None:
        raise PinpressError(
            f"servo_cycle needs the speed of the driver [{drivers.units[1]}], or time: give one number, or the speeds of all states, or"
            " time=..., from which speed and acceleration are derived"
        )
    speeds = _column("speed", speed, angles.shape)
    times = _times(*((angles, speeds) if angles.ndim == 1 else (angles[:, 0], speeds[:, 0])))
    if acceleration is not None:
        accelerations = _column("acceleration", acceleration, angles.shape)
        if times is not None and not _is_zero(acceleration):
            for value, rate, bend in ((angles, speeds, accelerations), (speeds, accelerations, None)):
                if times is not None and _contradiction(_whole(times), value, rate, bend):
                    times = None
        return DriverMotion(angles, speeds, accelerations, times)
    if np.all(speeds == speeds[0]):
        return DriverMotion(angles, speeds, np.zeros_like(speeds), times)
    if times is None:
        raise PinpressError(_no_time(drivers, angles, speeds))
    _refuse_few(len(times), "the acceleration")
    timing = _whole(times)
    _refuse(drivers, timing, angles, 0, angles, speeds, None)
    column = SampledColumn(times, speeds)
    _doubt(drivers, "speed", column, 1, speeds)
    return DriverMotion(angles, speeds, column.derivative(1), times)


class _Timing(NamedTuple):
    """The states of a motion from which derivatives are found: those of a closed motion without a state at the end of the period.

    Attributes:
        time: (m,) [s].
        period: [s]; None of a motion that is not closed.
        repeated: whether one more state is at the end of the period.
    """

    time: Array
    period: float | None
    repeated: bool

    def column(self, values: Array, advance: Array | float = 0.0) -> SampledColumn:
        """The column of values (n,) or (n, drivers), which include any state at the end of the period; ``advance``: see `SampledColumn`."""
        return SampledColumn(self.time, values[: len(self.time)], self.period, advance)

    def all_states(self, values: Array) -> Array:
        """Values of all states, with that at the end of the period if there is one."""
        return np.concatenate([values, values[:1]]) if self.repeated else values


def _whole(time: Array) -> _Timing:
    return _Timing(time, None, False)


@dataclass(frozen=True, eq=False)
class _InTime:
    """States with times.

    Attributes:
        drivers: names of the drivers.
        time: (n,) as given [s].
        period: as given [s]; None of a motion that is not closed.
    """

    drivers: Drivers
    time: Array
    period: float | None

    def motion(self, angle: ArrayLike | None, speed: ArrayLike | None, acceleration: ArrayLike | None) -> DriverMotion:
        timing = self._timing()
        if angle is None:
            raise PinpressError(
                f"give angle, (n,) [{self.drivers.units[0]}], or one number: the angle at the start, from which it is found by the speed"
            )
        given = numbers("angle", angle)
        begin = given.shape == (() if self.drivers.one else (len(self.drivers.names),))
        shape = (len(self.time), *given.shape) if begin else given.shape
        if not begin:
            _refuse_shape(given, self.drivers)
            if len(self.time) != len(given):
                raise PinpressError(f"time has shape {self.time.shape}, but angle has {given.shape}")
        speeds = None if speed is None else self._speeds(speed, acceleration, shape, timing, begin)
        accelerations = None if acceleration is None else _column("acceleration", acceleration, shape)
        if begin:
            if speeds is None:
                raise PinpressError(f"angle is that at the start alone: give speed too, (n,) or one number [{self.drivers.units[1]}]")
            angles = given + _integral(timing, speeds, "the angle")
        else:
            angles = given
            if self.drivers.coordinates[0].turns:
                _refuse_wrap(angles)
        refuse_far("angle", angles, self.drivers.coordinates)
        advance = self._advance(timing, angles, speeds) if timing.period else 0.0
        if speeds is None:
            _refuse_few(len(timing.time), "speed and acceleration")
            of_angle = timing.column(angles, advance)
            speeds = timing.all_states(of_angle.derivative(1))
            if accelerations is None:
                _doubt(self.drivers, "angle", of_angle, 2, speeds)
                return DriverMotion(angles, speeds, timing.all_states(of_angle.derivative(2)), self.time)
        elif not begin:
            _refuse(self.drivers, timing, angles, 0, angles, speeds, accelerations, advance)
        if accelerations is None:
            return DriverMotion(angles, speeds, self._derive_accelerations(timing, speeds), self.time)
        if acceleration is not None and _is_zero(acceleration):
            if np.any(speeds != speeds[0]):
                caution(
                    f"the speed varies over time, from {speeds.min():g} to {speeds.max():g} {self.drivers.units[1]}, and acceleration=0.0"
                    " leaves out what that takes: leave acceleration out, and it is derived"
                )
        else:
            _refuse(self.drivers, timing, angles, 1, speeds, accelerations, None)
        return DriverMotion(angles, speeds, accelerations, self.time)

    def _timing(self) -> _Timing:
        """The states that count; raises PinpressError where times do not rise, or do not agree with the period."""
        time = self.time
        if time.ndim != 1 or not len(time):
            raise PinpressError(f"time has shape {time.shape}: give (n,) times [s]")
        steps = np.diff(time)
        if np.any(steps <= 0):
            raise PinpressError("time does not rise throughout")
        if len(steps) and steps.min() < KEPT * np.spacing(np.abs(time).max()):
            latest = np.abs(time).max()
            raise PinpressError(f"time is up to {latest:g} s, where its steps are lost in rounding: count it from where the motion begins")
        if self.period is None:
            return _whole(time)
        period = number("period", self.period, positive=True)
        _refuse_few(len(time) - 1, "a closed motion")
        left = period - float(time[-1] - time[0])
        if abs(left) <= CLOSED * steps.min():
            return _Timing(time[:-1], period, True)
        if not 0 < left <= 2 * steps.max():
            raise PinpressError(
                f"period is {period:.10g} s, but the states take {time[-1] - time[0]:.10g} s, in steps of up to {steps.max():g} s: after"
                " the last state, or one step later, the first is to come again"
            )
        return _Timing(time, period, False)

    def _speeds(self, speed: ArrayLike, acceleration: ArrayLike | None, shape: tuple[int, ...], timing: _Timing, begin: bool) -> Array:
        """Speeds of all states: as given, one number of all, or, of a motion of which only the start and the acceleration are given,
        from that at the start."""
        given = numbers("speed", speed)
        if begin and acceleration is not None and given.shape in ((), shape[1:]):
            return given + _integral(timing, _column("acceleration", acceleration, shape), "the speed")
        return _column("speed", speed, shape)

    def _advance(self, timing: _Timing, angles: Array, speeds: Array | None) -> Array:
        """By what angle, a whole number of turns, the drivers have turned after the period; one that slides is back.

        Raises:
            PinpressError: the motion does not come back.
        """
        first, turning = self.drivers.coordinates[0], np.array([each.turns for each in self.drivers.coordinates]).reshape(angles.shape[1:])
        turn = np.where(turning, 2 * np.pi, np.maximum(np.ptp(angles, axis=0), np.finfo(float).tiny))

        def whole(made: Array) -> Array:
            return np.asarray(np.where(turning, turn * np.round(made / turn), 0.0))

        if timing.repeated:
            made = angles[-1] - angles[0]
            missed = np.abs(made - whole(made))
            if np.any(missed > SEAM[0] * turn):
                raise PinpressError(
                    f"after the period of {timing.period:g} s the angle is {first.shown(missed.max(), '.4g')} beside where it"
                    " began: give a motion over whole turns or to and fro, or leave period out"
                )
            if speeds is not None and np.any(np.abs(speeds[-1] - speeds[0]) > SEAM[1] * np.abs(speeds).max(axis=0)):
                raise PinpressError(
                    f"after the period of {timing.period:g} s the speed is {speeds[-1]} {self.drivers.units[1]}, but {speeds[0]} at its"
                    " start: leave period out where the motion is not closed"
                )
            return whole(made)
        steps = np.diff(angles, axis=0)
        slopes = steps / np.diff(self.time).reshape(-1, *([1] * (angles.ndim - 1)))
        left = (timing.period or 0.0) - (self.time[-1] - self.time[0])
        made = angles[-1] - angles[0] + 0.5 * left * (slopes[0] + slopes[-1])
        advance = whole(made)
        if np.any(np.abs(made - advance) > 0.5 * left * np.abs(slopes).max(axis=0) + SEAM[0] * turn):
            raise PinpressError(
                f"after the period of {timing.period:g} s the angle is not back: it goes on to {first.shown(np.max(made), '.4g')} from its"
                " start, no whole number of turns; leave period out where the motion is not closed"
            )
        return advance

    def _derive_accelerations(self, timing: _Timing, speeds: Array) -> Array:
        """Accelerations of all states, derived from the speeds."""
        if np.all(speeds == speeds[0]):
            return np.zeros_like(speeds)
        _refuse_few(len(timing.time), "the acceleration")
        column = timing.column(speeds)
        _doubt(self.drivers, "speed", column, 1, speeds)
        return timing.all_states(column.derivative(1))


def _integral(timing: _Timing, rate: Array, what: str) -> Array:
    """Integrals of a rate from the first state to each; ``what``: their name in messages."""
    if np.all(rate == rate[0]):
        since = timing.time - timing.time[0]
        return np.asarray(np.multiply.outer(np.append(since, timing.period) if timing.period and timing.repeated else since, rate[0]))
    _refuse_few(len(timing.time), what)
    column = timing.column(rate)
    if not timing.repeated:
        return column.integral
    return np.concatenate([column.integral, column.gains[0].sum(axis=0, keepdims=True)])


def _refuse_shape(angles: Array, drivers: Drivers) -> None:
    count, first = len(drivers.names), drivers.coordinates[0]
    if count == 1 and (angles.ndim != 1 or len(angles) == 0):
        raise PinpressError(f"angle has shape {angles.shape}: give (n,) {first.position}s [{first.unit}]")
    if count > 1 and (angles.ndim != 2 or len(angles) == 0 or angles.shape[1] != count):
        raise PinpressError(f"angle has shape {angles.shape}: give (n, {count}), the angles of all drivers [rad]")


def _column(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Values for all states; one number is that of all."""
    given = numbers(name, values)
    if given.ndim and given.shape != shape:
        raise PinpressError(f"{name} has shape {given.shape}, but angle has {shape}")
    return np.broadcast_to(given, shape).copy()


def _is_zero(acceleration: ArrayLike) -> bool:
    """Whether the acceleration is the number 0, by which it is left out on purpose."""
    return np.ndim(acceleration) == 0 and float(np.asarray(acceleration)) == 0.0


def _refuse_few(states: int, what: str) -> None:
    if states < FEWEST:
        raise PinpressError(f"{states} states are too few to find {what}: give {FEWEST} or more, or angle, speed and acceleration of all")


def _refuse_wrap(angles: Array) -> None:
    """Raise PinpressError where angles start again after a turn, as those of an encoder."""
    steps = np.diff(angles, axis=0)
    wraps = np.abs(steps) > np.pi
    if not wraps.any() or len(steps) < FEWEST or np.median(np.abs(steps)) > 0.5 * np.pi:
        return
    unwrapped = np.abs(np.diff(np.unwrap(angles, axis=0), axis=0))
    if unwrapped[wraps].max() <= 2 * unwrapped[~wraps].max():
        state = int(np.argwhere(wraps)[0][0])
        ends = np.degrees(angles[state : state + 2].reshape(2, -1)[:, int(np.argmax(wraps[state]))])
        raise PinpressError(
            f"angle jumps from {ends[0]:.6g} to {ends[1]:.6g} deg between states {state} and {state + 1}: give it unwrapped,"
            " numpy.unwrap(angle)"
        )


def _times(angles: Array, speeds: Array) -> Array | None:
    """Time (n,) from 0, such that the integrals of the speeds are the angles; None if angles and speeds do not belong together.

    The trapezoidal rule gives first steps of time. Each is then multiplied by the ratio of its angle to that of the quintic spline through
    the speeds, until no step changes any more. Near a standstill with little acceleration the two rules differ, because hardly anything
    determines how long it takes: such states have no time.
    """
    with np.errstate(all="ignore"):
        steps = 2 * np.diff(angles) / (speeds[1:] + speeds[:-1])
        if not np.all(_take_time(steps)):
            return None
        if len(angles) < FEWEST or np.all(speeds == speeds[0]):
            return np.concatenate([[0.0], np.cumsum(steps)])
        trapezoids = steps
        for _ in range(MOST_ROUNDS):
            times = np.concatenate([[0.0], np.cumsum(steps)])
            factors = np.diff(angles) / SampledColumn(times, speeds).gains[0]
            if not np.all((factors > 0.1) & (factors < 10.0)):
                return None
            steps = steps * factors
            if not np.all(_take_time(steps)):
                return None
            if np.abs(factors - 1).max() < SETTLED:
                break
    # Where time is not determined, the trapezoidal rule and the spline differ by more than a tenth of a step.
    settled = np.abs(factors - 1).max() < 1e3 * SETTLED and np.abs(steps / trapezoids - 1).max() < 0.1
    return np.concatenate([[0.0], np.cumsum(steps)]) if settled else None


def _take_time(steps: Array) -> NDArray[np.bool_]:
    """Which steps of time (n,) are positive and count in their sum, where a rounding error vanishes."""
    return np.asarray(np.isfinite(steps) & (np.diff(np.cumsum(np.concatenate([[0.0], steps]))) > 0))


def _no_time(drivers: Drivers, angles: Array, speeds: Array) -> str:
    """Why the acceleration does not follow from angle and speed."""
    angle, speed = (values if values.ndim == 1 else values[:, 0] for values in (angles, speeds))
    with np.errstate(all="ignore"):
        steps = 2 * np.diff(angle) / (speed[1:] + speed[:-1])
        wrong = np.flatnonzero(~_take_time(steps))
    remedy = "give time=..., or acceleration=..., of which 0.0 leaves it out"
    first, rate = drivers.coordinates[0], drivers.units[1]
    if not len(wrong):
        k = int(np.abs(speed).argmin())
        return (
            f"the speed varies, but angle and speed do not determine the acceleration: state {k}, at {first.shown(angle[k])}, has a"
            f" speed of {speed[k]:g} {rate}, and how long the {first.part} is there does not show; {remedy}"
        )
    k = int(wrong[0])
    return (
        f"the speed varies, but angle and speed do not determine the acceleration: from state {k} to {k + 1} the angle goes from"
        f" {angle[k] * first.scale:.6g} to {first.shown(angle[k + 1])} at speeds of {speed[k]:g} and {speed[k + 1]:g} {rate}, which"
        f" take no definite time; {remedy}"
    )


def _doubt(drivers: Drivers, given: str, column: SampledColumn, order: int, speeds: Array) -> None:
    """Warn where accelerations, derivatives of a column, depend on how they are found, compared with those that follow from the speeds."""
    # An acceleration of less than a tenth of the squared speed moves a press little compared with its speed.
    acceleration, by_speed = np.mean(column.derivative(order) ** 2, axis=0), np.mean((0.1 * speeds**2) ** 2, axis=0)
    size = np.sqrt(acceleration + by_speed)
    part = float(np.max(np.divide(column.uncertainty(order), size, out=np.zeros_like(size), where=size > 0)))
    share = min(100.0, 100.0 * NOISE_SHARE[order - 1] * part)
    if part > NOISY and column.is_noisy(order):
        caution(
            f"the acceleration derived from the {given} over time is dominated by noise, to about {share:.0f} %: smooth the {given}, give"
            " fewer states, or give acceleration=..."
        )
    elif part > COARSE:
        caution(
            f"the acceleration derived from the {given} over time is uncertain: the states are too far apart for so quick a motion, or"
            " something jumps; give more states, or acceleration=..."
        )
    elif np.any((rough := column.roughness(order)) > 0.5 * size):  # of single states: at a jump both splines differ by half of the size
        state = int(np.argmax(rough.reshape(len(rough), -1).max(axis=1)))
        caution(
            f"the acceleration derived from the {given} over time is uncertain at {column.time[state]:.6g} s (state {state}), by"
            f" {rough[state].max():.3g} {drivers.units[2]} or more: the {given} jumps there, or is too coarsely rounded, as heights near a"
            " dead centre; smooth it, or give acceleration=..."
        )


def _refuse(
    drivers: Drivers,
    timing: _Timing,
    angles: Array,
    order: int,
    value: Array,
    rate: Array,
    bend: Array | None,
    advance: Array | float = 0.0,
) -> None:
    """Raise PinpressError where a column, the angle or its derivative of that order, does not have the rate that is given; of fewer states
    than `FEWEST`, which may lie too far apart to tell, warn of it."""
    of, by = ("angle", "speed") if order == 0 else ("speed", "acceleration")
    found = _contradiction(timing, value, rate, bend, advance)
    if found is None:
        return
    coordinate = drivers.coordinates[found.driver]
    place = f"state {found.state}, {coordinate.at(angles.reshape(len(angles), -1)[found.state, found.driver])}"
    who = "" if drivers.one else f" of driver {drivers.names[found.driver]}"
    (_, unit), (_, rate_unit) = coordinate.heads[order : order + 2]
    how = found.said.format(of=of, by=by, unit=unit, rate=rate_unit)
    said = (
        f"{of} and {by} do not fit together over time: at {timing.time[found.state]:.6g} s ({place}){who} {how}; give {by} [{rate_unit}] as"
        f" the derivative of {of} [{unit}] by time [s], or leave it out: it is derived"
    )
    if len(timing.time) >= FEWEST:
        raise PinpressError(said)
    caution(said)


def _contradiction(timing: _Timing, value: Array, rate: Array, bend: Array | None, advance: Array | float = 0.0) -> _Contradiction | None:
    """Where a column (n,) or (n, drivers) does not have the rate that is given, beyond what sampling and noise explain; None if it has.

    ``bend`` is the derivative of the rate, where it is given.
    """
    states = len(timing.time)
    for driver, (x, r, growth) in enumerate(
        zip(_by_driver(value[:states]), _by_driver(rate[:states]), np.atleast_1d(np.broadcast_to(advance, value.shape[1:])), strict=True)
    ):
        bends = None if bend is None else _by_driver(bend[:states])[driver]
        found = _of_few(timing.time, x, r, bends) if states < FEWEST else _of_many(timing, x, r, float(growth))
        if found is not None:
            return _Contradiction(found[0], driver, found[1])
    return None


def _by_driver(values: Array) -> Array:
    return values.reshape(len(values), -1).T


def _of_few(time: Array, value: Array, rate: Array, bend: Array | None) -> tuple[int, str] | None:
    """Of few states: beyond what the trapezoidal rule may miss, half the change of rate within a step, and what its derivative at both ends
    may add."""
    steps, gained = np.diff(time), np.diff(value)
    summed, allowed = 0.5 * steps * (rate[1:] + rate[:-1]), 0.5 * steps * np.abs(np.diff(rate))
    if bend is not None:
        allowed = allowed + 0.25 * steps**2 * (np.abs(bend[1:]) + np.abs(bend[:-1]))
    missed = np.maximum(np.abs(gained - summed) - allowed, 0.0)
    way = float(np.maximum(np.abs(gained), np.abs(summed)).sum())
    if not missed.sum() > AMISS * way:
        return None
    return _step_in_words(int(missed.argmax()), gained, summed)


def _of_many(timing: _Timing, value: Array, rate: Array, advance: float) -> tuple[int, str] | None:
    of_value, of_rate = timing.column(value, advance), timing.column(rate)
    least = LEAST * float(np.abs(rate).max())
    derived = of_value.derivative(1)
    bound = of_value.derivative_error + of_rate.value_error + least
    beyond = np.minimum(np.abs(rate - derived), np.abs(rate - of_value.central_differences)) - bound
    if beyond.max() > 0:
        state = int(beyond.argmax())
        return state, (
            f"{{by}} is {rate[state]:.6g} {{rate}}, but the derivative of {{of}} is {derived[state]:.6g} {{rate}}, give or take"
            f" {bound[state]:.1g}"
        )
    ends = np.append(value, value[0] + advance) if timing.period else value
    gained, (summed, off) = np.diff(ends), of_rate.gains
    steps = np.diff(np.append(timing.time, timing.time[0] + timing.period) if timing.period else timing.time)
    rounding = 1e-14 * float(np.abs(value).max())
    missed = np.minimum(np.abs(gained - summed), np.abs(gained - of_rate.trapezoids))
    beyond = missed - off - least * steps - 2 * float(of_value.value_error) - rounding
    if beyond.max() > 0:
        return _step_in_words(int(beyond.argmax()), gained, summed)
    drift = np.minimum(np.abs(np.cumsum(gained - summed)), np.abs(np.cumsum(gained - of_rate.trapezoids)))
    beyond = drift - np.cumsum(off + least * steps) - off.max() - 2 * float(of_value.value_error) - rounding * np.arange(1, len(drift) + 1)
    if beyond.max() > 0:
        k = int(np.argmax(beyond > 0))
        state = min(k + 1, len(value) - 1)
        return state, (
            f"{{of}} has changed by {np.cumsum(gained)[k]:.6g} {{unit}} since the start, but {{by}} makes"
            f" {np.cumsum(summed)[k]:.6g} {{unit}} of it"
        )
    return None


def _step_in_words(step: int, gained: Array, summed: Array) -> tuple[int, str]:
    return step, f"{{of}} changes by {gained[step]:.6g} {{unit}} to the next state, but {{by}} makes {summed[step]:.6g} {{unit}} of it"
