"""A column of numbers over time, of one driver or of several: its derivatives and its integral, with bounds of their errors.

Over a period in equal steps they are those of the trigonometric polynomial, if its last harmonics have died away; else those of the quintic
spline, periodic or with the not-a-knot condition. Their errors are judged by comparison with the cubic spline and with central differences,
which differ where a column has a corner, jumps or is noisy.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..common.quantities import Array, ComplexArray

FEWEST = 6  # least states for a quintic spline: with fewer a derivative cannot be compared
EQUAL = 1e-9  # share of a step by which equal steps may differ
LAST = 4  # the last quarter of the harmonics tells whether they have died away
CORNER, JUMP = 120.0, 400.0  # multiples of the difference between quintic and cubic spline, in derivatives and in integrals over a step
DIFFERENCES = 3.0  # multiple of the difference from central differences and from the trapezoidal rule
BENT = 3.0  # multiple of the difference of slopes or values from a line between their neighbours: that of a corner or jump is larger
NOISE = 35.0  # multiple of the median difference between the two splines: six standard deviations of white noise
ABOUT = 3  # states on either side in which a corner or a jump shows
ROUNDING = 64 * float(np.finfo(float).eps)
SAME = 1e-9  # share of the values below which differences are rounding
SHOWN = 100  # differences from which a common step is found


@dataclass(frozen=True, eq=False)
class SampledColumn:
    """Values over time, in at least `FEWEST` states.

    Attributes:
        time: (n,) rising [s].
        values: (n,) or (n, drivers).
        period: time after which the values repeat themselves [s], more than the time from first to last state; None if they do not.
        advance: growth of the values over the period, a number or (drivers,).
    """

    time: Array
    values: Array
    period: float | None = None
    advance: Array | float = 0.0

    def derivative(self, order: int) -> Array:
        """First or second derivatives by time, of the shape of the values."""
        trend = self._trend if order == 1 else 0.0
        if self._harmonics_die_away:
            found = np.fft.irfft(_stretch(self._rates, self._harmonics) ** order * self._harmonics, len(self.time), axis=0)
            return np.asarray(found + trend)
        return np.asarray(self._splines[0](self.time, order) + trend)

    @property
    def central_differences(self) -> Array:
        """First derivatives by central differences, at the ends of a column by one-sided differences."""
        if self.period is None:
            return np.asarray(np.gradient(self.values, self.time, axis=0))
        times = np.concatenate([[self.time[-1] - self.period], self._knots])
        values = np.concatenate([self.values[-1:] - self.advance, self._extended])
        return np.asarray(np.gradient(values, times, axis=0)[1:-1])

    @cached_property
    def derivative_error(self) -> Array:
        """Bounds for the errors of the first derivatives, with regard to corners, rounded values and noise, of the shape of the values."""
        rough, steps = self.roughness(1), np.diff(self._knots)
        slopes = np.diff(self._extended, axis=0) / _stretch(steps, self.values)
        bent = self._off_the_line(self._knots[:-1] + 0.5 * steps, slopes)
        beside = np.concatenate([bent[-1:] if self.period else bent[:1], bent, bent[-1:]])[: len(self.time) + 1]
        corner = np.minimum(
            CORNER * self._about(rough) + DIFFERENCES * np.abs(self.derivative(1) - self.central_differences),
            BENT * self._about(np.maximum(beside[1:], beside[:-1])),
        )
        if self.period is None:
            corner[[0, -1]] *= 4.0  # there a corner is seen from one side alone
        shortest = steps.min()
        rounding = ROUNDING * np.abs(self.values).max(axis=0) / shortest
        return np.asarray(corner + NOISE * self.uncertainty(1) + 2 * self._graduation / shortest + rounding)

    @cached_property
    def value_error(self) -> Array:
        """Bound for the error of each value of a smooth column that is rounded or has white noise, a number or (drivers,)."""
        steps = _stretch(np.gradient(self.time), self.values)
        return np.asarray(NOISE * np.median(self.roughness(1) * steps, axis=0) + self._graduation)

    def roughness(self, order: int) -> Array:
        """Differences between the derivatives of both splines, of the shape of the values."""
        quintic, cubic = self._splines
        return np.asarray(np.abs(quintic(self.time, order) - cubic(self.time, order)))

    def uncertainty(self, order: int) -> Array:
        """The median of the roughness, a number or (drivers,): for noise it is a fifth of the standard deviation."""
        return np.asarray(np.median(self.roughness(order), axis=0))

    def is_noisy(self, order: int) -> bool:
        """Whether every second state determines the derivatives better than all states do: noise counts less with longer steps."""
        if len(self.time) < 2 * FEWEST:
            return False
        every, half = SampledColumn(self.time, self.values), SampledColumn(self.time[::2], self.values[::2])
        return bool(np.any(half.uncertainty(order) < every.uncertainty(order)))

    @cached_property
    def gains(self) -> tuple[Array, Array]:
        """Integrals over the steps, for a periodic column also over the step to the next period, and bounds for their errors."""
        steps = _stretch(np.diff(self._knots), self.values)
        gained = np.diff(self._splines[0].antiderivative()(self._knots), axis=0) + steps * self.values[0]
        cubic = np.diff(self._splines[1].antiderivative()(self._knots), axis=0) + steps * self.values[0]
        bent = self._off_the_line(self._knots, self._extended)
        jump = np.minimum(
            JUMP * self._about(np.abs(gained - cubic)) + DIFFERENCES * np.abs(gained - self.trapezoids),
            BENT * self._about(steps) * self._about(np.maximum(bent[1:], bent[:-1])),
        )
        return gained, jump + steps * self.value_error

    @property
    def trapezoids(self) -> Array:
        """Integrals over the steps by the trapezoidal rule."""
        return np.asarray(0.5 * _stretch(np.diff(self._knots), self.values) * (self._extended[1:] + self._extended[:-1]))

    @cached_property
    def integral(self) -> Array:
        """The integrals from the first state to each, of the shape of the values."""
        if self._harmonics_die_away:
            rates = _stretch(self._rates, self._harmonics)
            waves = np.fft.irfft(
                np.divide(self._harmonics, rates, out=np.zeros_like(self._harmonics), where=rates != 0), axis=0, n=len(self.time)
            )
            mean = self._harmonics[:1].real / len(self.time) + self.values[0]
            return np.asarray(waves - waves[:1] + mean * _stretch(self.time - self.time[0], self.values))
        gained = self.gains[0][: len(self.time) - 1]
        return np.concatenate([np.zeros_like(self.values[:1]), np.cumsum(gained, axis=0)])

    @cached_property
    def _knots(self) -> Array:
        return self.time if self.period is None else np.append(self.time, self.time[0] + self.period)

    @cached_property
    def _extended(self) -> Array:
        return self.values if self.period is None else np.concatenate([self.values, self.values[:1] + self.advance])

    @property
    def _trend(self) -> Array | float:
        return 0.0 if self.period is None else self.advance / self.period

    @cached_property
    def _even(self) -> Array:
        """Values at the knots less the first one and the trend, so that the last value of a periodic column is the first."""
        if self.period is None:
            return np.asarray(self.values - self.values[0])
        even = self._extended - self.values[0] - np.multiply.outer(self._knots - self.time[0], np.asarray(self._trend))
        even[-1] = even[0]
        return np.asarray(even)

    @cached_property
    def _splines(self) -> tuple[Any, Any]:
        from scipy.interpolate import make_interp_spline  # to save start-up time: motions at constant speed do not need it

        ends = None if self.period is None else "periodic"
        quintic, cubic = (make_interp_spline(self._knots, self._even, k=degree, bc_type=ends) for degree in (5, 3))
        return quintic, cubic

    @cached_property
    def _harmonics(self) -> ComplexArray:
        return np.asarray(np.fft.rfft(self._even[:-1], axis=0))

    @cached_property
    def _rates(self) -> ComplexArray:
        """Factors (harmonics,) of the first derivative; zero for the last harmonic of an even number of states."""
        orders = np.arange(len(self.time) // 2 + 1)
        rates = 2j * np.pi / (self.period or np.inf) * orders
        if len(self.time) % 2 == 0:
            rates[-1] = 0.0
        return np.asarray(rates)

    @cached_property
    def _harmonics_die_away(self) -> bool:
        if self.period is None:
            return False
        steps = np.diff(self._knots)
        if np.ptp(steps) > EQUAL * steps.max():
            return False
        rates, harmonics = np.abs(self._rates), np.abs(self._harmonics)
        last = -max(2, len(rates) // LAST)
        left = 2 / len(self.time) * np.sum(_stretch(rates[last:], harmonics) * harmonics[last:], axis=0)
        return bool(np.all(left <= self.roughness(1).max(axis=0)))

    @cached_property
    def _graduation(self) -> Array:
        """Step to which the values are rounded, as in a table or by an encoder, if they show it; a number or (drivers,)."""
        steps = _stretch(np.gradient(self.time), self.values)
        # Steps of a rounded column are no larger than 12 times the largest difference between the two splines.
        largest = 12.0 * np.max(self.roughness(1) * steps, axis=0)
        common = np.array([_common_step(values) for values in self.values.reshape(len(self.time), -1).T])
        return np.asarray(np.minimum(largest, common.reshape(largest.shape)))

    def _off_the_line(self, at: Array, values: Array) -> Array:
        """Distances of values from the line between their neighbours; those at the ends are taken from beside them."""
        part = _stretch((at[1:-1] - at[:-2]) / (at[2:] - at[:-2]), values)
        off = np.abs(values[1:-1] - (1 - part) * values[:-2] - part * values[2:])
        return np.concatenate([off[:1], off, off[-1:]])

    def _about(self, values: Array) -> Array:
        """The largest of each value and its `ABOUT` neighbours on either side."""
        sides = [(ABOUT, ABOUT)] + [(0, 0)] * (values.ndim - 1)
        padded = np.pad(values, sides, mode="edge" if self.period is None else "wrap")
        return np.asarray(np.max([padded[shift : shift + len(values)] for shift in range(2 * ABOUT + 1)], axis=0))


def _stretch(along: Any, values: Any) -> Any:
    """Numbers (n,) in a shape that multiplies values (n,) or (n, drivers)."""
    return along.reshape(-1, *([1] * (values.ndim - 1)))


def _common_step(values: Array) -> float:
    """Step of which all differences of values (n,) are multiples; 0 where there is none."""
    least = SAME * float(np.abs(values).max())
    steps = np.diff(np.unique(values))
    steps = steps[steps > least]
    common = 0.0
    different = np.unique(np.round(steps / least), return_index=True)[1]
    for step in steps[different[:SHOWN]]:  # Euclid's algorithm
        larger, smaller = float(step), common
        while smaller > least:
            larger, smaller = smaller, abs(larger - smaller * round(larger / smaller))
        common = larger
        if common <= least:
            return 0.0
    multiples = steps / common
    return common if np.all(np.abs(multiples - np.round(multiples)) < 0.01) else 0.0
