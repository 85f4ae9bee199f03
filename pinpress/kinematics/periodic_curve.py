"""A quantity over one period at constant crank speed, interpolated between the states.

A *place* counts states from the first one and may have a fraction: the period of n states goes from place 0 to n, where it begins again.
Between two states the quantity is the quintic that has its value, slope and curvature at both. Its error falls with the sixth power of the
step.

Everything is analytic in the quantity, so that derivatives can be found by the complex-step method: numbers may have tiny imaginary parts,
which are their changes with a parameter, and all decisions are made on real parts.
"""

import cmath
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from ..common.errors import PinpressError
from ..common.numerics import Numbers, ValueAndSlope, bracketed_roots, quintics
from ..common.quantities import Array, ComplexArray

MISSED = 1e-5  # accepted error of the end-corrected trapezoidal rule from state to state [share of the quantity's range]; measures err less
UNEQUAL = 1e-9  # difference of crank angle steps [rad], or share by which crank speeds differ, up to which they are equal
ROUNDING = 4 * float(np.finfo(float).eps)  # rounding of a place


class CrankMotion(Protocol):
    """The part of a motion that measures of the crank need. A `Motion` is one.

    Attributes:
        crank_angle: (n,) [rad].
        crank_speed: (n,) [rad/s].
        period_turns: turns of the crank in a period, None if there is no period.
    """

    @property
    def crank_angle(self) -> Numbers: ...
    @property
    def crank_speed(self) -> Numbers: ...
    @property
    def period_turns(self) -> int | None: ...


@dataclass(frozen=True, eq=False, repr=False)
class Curve:
    """A quantity over a period of n states.

    Attributes:
        coefficients: (6, n) coefficients of the quintics, for rising powers of the place since a state.
        real: whether the quantity was given by real numbers.
    """

    coefficients: ComplexArray
    real: bool

    @property
    def states(self) -> int:
        """Number of states of the period."""
        return int(self.coefficients.shape[1])

    def at(self, place: Numbers, derivatives: int = 3) -> tuple[ComplexArray, ...]:
        """The quantity and its first derivatives by the place, one to three of them, (m,) each, at places (m,)."""
        before = np.floor(place.real)
        since = place - before
        highest, next_highest, *others = self.coefficients[::-1, before.astype(int) % self.states]
        value, first = highest * since + next_highest, highest
        second = third = np.zeros(place.shape, complex)
        for coefficient in others:
            if derivatives > 2:
                third = third * since + 3 * second
            if derivatives > 1:
                second = second * since + 2 * first
            first = first * since + value
            value = value * since + coefficient
        return (value, first, second, third)[: 1 + derivatives]

    @cached_property
    def turning_places(self) -> ComplexArray:
        """Places (m,) from 0 to n at which the quantity turns back. Two of them within one step are missed."""
        backwards = np.signbit(self.coefficients[1].real)
        before = np.flatnonzero(backwards != np.roll(backwards, -1)).astype(float)

        def turning(place: Numbers) -> tuple[ComplexArray, ComplexArray]:
            _, first, second = self.at(place, 2)
            return first, second

        return zeros(turning, before, before + 1)

    def crossings(self, level: complex) -> ComplexArray:
        """Places (m,) from 0 to n at which the quantity passes a level."""
        # Between two of these places it does not turn back.
        places = np.unique(np.concatenate([np.arange(self.states + 1), self.turning_places.real]))
        above = self.at(places, 1)[0].real > level.real
        before = np.flatnonzero(above[1:] != above[:-1])

        def beyond(place: Numbers) -> tuple[ComplexArray, ComplexArray]:
            value, slope = self.at(place, 1)
            return value - level, slope

        return zeros(beyond, places[before], places[before + 1])

    def extremes(self) -> tuple[complex, complex]:
        """The smallest and the largest value."""
        values = np.concatenate([self.coefficients[0], self.at(self.turning_places, 1)[0]])
        return complex(values[values.real.argmin()]), complex(values[values.real.argmax()])

    def number(self, value: complex) -> float:
        """A result as it is returned: a float, or a complex number where the quantity is complex.

        Raises:
            PinpressError: the number is not finite.
        """
        if not cmath.isfinite(value):
            raise PinpressError("the measure is not finite, or has no derivative by the parameter here: change the parameter a little")
        return float(value.real) if self.real else complex(value)  # type: ignore[return-value]  # said in `measures`


def step_time(motion: CrankMotion) -> complex:
    """Time from state to state [s] of one period at constant speed. Raises as `step_angle`."""
    return complex(step_angle(motion) / np.asarray(motion.crank_speed)[0])


def step_angle(motion: CrankMotion) -> float:
    """Crank angle from state to state [rad] of one period at constant speed, with its sign.

    Raises:
        PinpressError: the motion is not one period at constant speed in equal steps.
    """
    if not all(hasattr(motion, name) for name in ("crank_angle", "crank_speed", "period_turns")):
        raise PinpressError(f"motion is a {type(motion).__name__}, no Motion: give what cycle returns")
    angle, speed = np.asarray(motion.crank_angle).real, np.asarray(motion.crank_speed)
    remedy = "give the motion of one period at constant speed, cycle(press, speed=...)"
    if angle.ndim > 1:
        drivers = f"the linkage has {angle.shape[1]} drivers, and no one crank to turn"
        raise PinpressError(f"{drivers}: measures are those of a press with one; see slide_position and slide_velocity over time")
    if len(angle) < 3 or not np.all(np.isfinite(angle) & np.isfinite(speed)):
        raise PinpressError(f"the motion has fewer than three states, or one that is not finite: {remedy}")
    made = float(angle[-1] - angle[0])
    turns = motion.period_turns
    if turns is None and not all(each.turns for each in getattr(motion, "driver_coordinates", ())):
        raise PinpressError(
            "the driver of the motion slides to and fro, and measures are those of a crank at constant speed: dead_centres(press) has the"
            " stroke, extremes(reactions) has speeds and forces"
        )
    if turns is None:
        raise PinpressError(f"the linkage of the motion has no period after which all is where it was: {remedy}")
    period = math.copysign(2 * np.pi * turns, made)
    if np.abs(np.diff(angle, append=angle[0] + period) - period / len(angle)).max() > UNEQUAL:
        whole = "one turn" if turns == 1 else f"a period, {turns} turns"
        raise PinpressError(f"the motion is not {whole} of the crank in equal steps, its end left out: {remedy}")
    if np.ptp(speed.real) > UNEQUAL * abs(speed[0]) or speed[0].real * period <= 0:
        raise PinpressError(f"the crank does not turn at constant speed: {remedy}")
    return period / len(angle)


def curve(what: str, value: Numbers, first: Numbers, second: Numbers, real: bool) -> Curve:
    """The curve through values with their derivatives at n states.

    Args:
        what: the quantity, for messages.
        value: (n,) values.
        first: (n,) first derivatives by the place.
        second: (n,) second derivatives by the place.
        real: whether the quantity was given by real numbers.

    Raises:
        PinpressError: a number is not finite, there are too few states, or the value after the period is not that at its start.
    """
    x, v, a = (np.asarray(values, dtype=complex) for values in (value, first, second))
    if not np.all(np.isfinite(x + v + a)):
        raise PinpressError(f"{what} is not finite: give a motion that cycle returned")
    x_next, v_next, a_next = (np.roll(values, -1) for values in (x, v, a))
    missed = np.abs((x_next - x - 0.5 * (v + v_next) - (a - a_next) / 12).real).max()
    if missed > MISSED * np.ptp(x.real):
        raise PinpressError(
            f"{len(x)} states do not resolve {what} over the period, or it is elsewhere after it: give cycle more points; of a linkage that"
            " repeats itself only after several turns give all of them"
        )
    ends = (np.append(values, values[0]) for values in (x, v, a))
    return Curve(quintics(np.ones(len(x)), *ends), real)


def zeros(function: ValueAndSlope, low: Array, high: Array) -> ComplexArray:
    """Places (m,) at which a quantity changes sign, exact to rounding: one in each of the intervals from ``low`` (m,) to ``high`` (m,)."""
    place = bracketed_roots(function, low, high, relative=ROUNDING)
    value, slope = function(place)
    with np.errstate(all="ignore"):  # the imaginary part is tiny, so that one step of Newton's method makes it exact
        moved = np.divide(value.imag, slope.real, out=np.zeros_like(place), where=value.imag != 0)
    return np.asarray(place - 1j * moved)
