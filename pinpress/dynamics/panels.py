"""Functions of the crank angle, or of time, as polynomials, panel by panel.

A function is sampled at the nodes of Gauss's quadrature. A panel is halved where the polynomial through these values does not resolve it.
"""

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from ..common.numerics import NODES, bracketed_roots, gauss_rule, values_and_slopes
from ..common.products import product
from ..common.quantities import Array

POWERS = np.arange(NODES)


@dataclass(frozen=True, eq=False, repr=False)
class Panels:
    """Rows of functions as polynomials, panel by panel.

    Attributes:
        borders: (p + 1,) of the panels, rising [rad].
        coefficients: (p, rows, q) of powers of x, from -1 to 1 over a panel.
        period: after which the functions come back [rad]; None if they do not.
    """

    borders: Array
    coefficients: Array
    period: float | None

    @cached_property
    def _by_power(self) -> Array:
        """(q, rows, p) coefficients, those of each power side by side."""
        return np.ascontiguousarray(self.coefficients.transpose(2, 1, 0))

    @cached_property
    def _edges(self) -> list[float]:
        return list(map(float, self.borders))

    @cached_property
    def _falling(self) -> list[list[list[float]]]:
        """Coefficients of falling powers of x, by panels and rows."""
        falling: list[list[list[float]]] = self.coefficients[:, :, ::-1].tolist()
        return falling

    def at(self, angle: Array, derivative: bool = True) -> tuple[Array, Array]:
        """Rows (rows, ...) at angles (...) between the first and the last border, and their derivatives, zero without ``derivative``."""
        panel, half, x = self.place(angle)
        picked = self._by_power.take(panel, axis=-1)  # (q, rows, ...)
        value = picked[-1]
        slope = np.zeros_like(value)
        for coefficients in picked[-2::-1]:
            if derivative:
                slope *= x
                slope += value
            value *= x
            value += coefficients
        return value, slope / half

    def place(self, angle: Array) -> tuple[NDArray[np.intp], Array, Array]:
        """The panels (...) of angles (...) between the first and the last border, half their widths, and places from -1 to 1 there."""
        panel = np.clip(self.borders.searchsorted(angle, side="right") - 1, 0, len(self.borders) - 2)
        half = 0.5 * (self.borders[panel + 1] - self.borders[panel])
        return panel, half, (angle - self.borders[panel]) / half - 1.0

    def panel_of(self, angle: float) -> tuple[int, float, float]:
        """The panel of one angle between the first and the last border, half its width, and the place x from -1 to 1 on it."""
        edges = self._edges
        panel = min(max(bisect_right(edges, angle) - 1, 0), len(edges) - 2)
        half = 0.5 * (edges[panel + 1] - edges[panel])
        return panel, half, (angle - edges[panel]) / half - 1.0

    def one(self, angle: float) -> tuple[list[float], list[float]]:
        """Rows at one angle between the first and the last border, and their derivatives, by Python's own numbers: NumPy takes longer."""
        panel, half, x = self.panel_of(angle)
        values, slopes = [], []
        for row in self._falling[panel]:
            value = slope = 0.0
            for coefficient in row:
                slope = slope * x + value
                value = value * x + coefficient
            values.append(value)
            slopes.append(slope / half)
        return values, slopes

    def roots(self, row: int, level: float = 0.0, slope: bool = False) -> Array:
        """Angles at which a row, or its ``slope`` by x, passes through a level."""
        coefficients = self.coefficients[:, row]
        if slope:
            coefficients = coefficients[:, 1:] * POWERS[1:]
        samples = np.linspace(-1.0, 1.0, 2 * NODES)
        above = coefficients @ np.vander(samples, coefficients.shape[1], increasing=True).T >= level
        panels, left = np.nonzero(above[:, 1:] != above[:, :-1])
        polynomials = coefficients[panels].T
        polynomials[0] -= level
        # a step of Newton's method this small is rounding
        x = bracketed_roots(lambda places: values_and_slopes(polynomials, places), samples[left], samples[left + 1], absolute=1e-15)
        inside = self.borders[panels] + 0.5 * (1 + x) * (self.borders[panels + 1] - self.borders[panels])
        # a root on a border between two panels may show in neither of them
        ends = np.flatnonzero(above[:-1, -1] != above[1:, 0]) + 1
        if self.period is not None and above[-1, -1] != above[0, 0]:
            ends = np.append(ends, 0)
        return np.concatenate([inside, self.borders[ends]])

    def integrals(self) -> Array:
        """(rows,) over all panels."""
        even = self.coefficients[:, :, ::2] @ (1.0 / (1.0 + POWERS[::2]))
        return np.asarray(np.diff(self.borders) @ even)

    def peaks(self, rows: NDArray[np.bool_]) -> Array:
        """Places (m,), rising, at which some of the rows (rows,) are largest or smallest: where a polynomial turns, or at a border.

        Of turning points that may be the highest for all that samples tell, all are returned.
        """
        coefficients = self.coefficients[:, rows]
        samples = np.linspace(-1.0, 1.0, 2 * NODES)
        powers, width = np.vander(samples, NODES, increasing=True).T, samples[1] - samples[0]
        slopes = coefficients[:, :, 1:] * POWERS[1:]
        values, rising = coefficients @ powers, slopes @ powers[:-1]
        middle, half = 0.5 * (self.borders[1:] + self.borders[:-1]), 0.5 * np.diff(self.borders)
        found = [np.zeros(0)]
        for sign in (1.0, -1.0):
            value, slope = sign * values, sign * rising
            by_row = value.swapaxes(0, 1).reshape(value.shape[1], len(value) * len(samples))
            highest = by_row.max(axis=1)
            panel, at = np.divmod(by_row.argmax(axis=1), len(samples))
            found.append(middle[panel] + half[panel] * samples[at])
            # between two samples no concave function exceeds its tangents there
            most = np.minimum(value[:, :, :-1] + width * slope[:, :, :-1], value[:, :, 1:] - width * slope[:, :, 1:])
            panel, row, at = np.nonzero((slope[:, :, :-1] > 0) & (slope[:, :, 1:] <= 0) & (most >= highest[:, None]))
            polynomials = slopes[panel, row].T
            x = bracketed_roots(partial(values_and_slopes, polynomials), samples[at], samples[at + 1], absolute=1e-12)
            found.append(middle[panel] + half[panel] * x)
        return np.unique(np.concatenate(found))


def last_terms(values: Array) -> Array:
    """The larger (...) of the last two Legendre terms of polynomials through values (q, ...) at the nodes: what they miss of a function."""
    terms = product(gauss_rule().legendre[-2:], values.reshape(len(values), -1))
    return np.asarray(np.abs(terms).max(axis=0).reshape(values.shape[1:]))


def resolve(
    sample: Callable[[Array], Array],
    borders: Array,
    missed: Callable[[Array], Array],
    share: float = 1e-11,
    narrowest: float = 1e-7,
    whole: float | None = None,
) -> tuple[Panels, int]:
    """Sample functions over panels, and halve these until polynomials resolve the functions.

    Args:
        sample: returns the rows (rows, n) at angles (n,).
        borders: of the panels to begin with, rising.
        missed: returns (p,) what polynomials through values (q, rows, p) miss on each panel, as a share.
        share: that they may miss.
        narrowest: half the width of panels that are not halved again: what these do not resolve lies at a lock.
        whole: width of all panels, where what a panel misses counts by its share of them, as in an integral; None: it counts as it is.

    Returns:
        The panels, without a period, and the number of angles at which the functions were computed.
    """
    points, rule = 0, gauss_rule()
    starts, ends, coarser = borders[:-1], borders[1:], np.full(len(borders) - 1, np.inf)
    resolved: list[tuple[Array, Array]] = []  # starts of panels, and values there
    while len(starts):
        half = 0.5 * (ends - starts)
        angles = (starts + half)[:, None] + half[:, None] * rule.nodes
        values = np.moveaxis(sample(angles.ravel()).reshape(-1, *angles.shape), 2, 0)
        points += angles.size
        misses = missed(values) if whole is None else missed(values) * (ends - starts) / whole
        # Halving a panel that is nearly resolved divides what is missed by thousands. What it does not even divide by 10 is rounding, as
        # near change points.
        rounding = (misses <= 1e-8) & (misses > coarser / 10.0)
        good = (misses <= share) | rounding | (half < narrowest)
        resolved.append((starts[good], values[:, :, good]))
        low, middle, high = starts[~good], (starts + half)[~good], ends[~good]
        starts, ends, coarser = np.concatenate([low, middle]), np.concatenate([middle, high]), np.tile(misses[~good], 2)
    lower, samples = np.concatenate([starts for starts, _ in resolved]), np.concatenate([values for _, values in resolved], axis=2)
    order = np.argsort(lower)
    polynomials = rule.polynomial(samples[:, :, order].reshape(NODES, -1)).reshape(samples.shape)
    return Panels(np.append(lower[order], borders[-1]), np.ascontiguousarray(polynomials.transpose(2, 1, 0)), None), points
