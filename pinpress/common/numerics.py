"""Small numerics: Gauss-Legendre quadrature on -1..1 with the polynomials through its nodes, and Newton's method fenced in by a bracket:
where a step leads out of it, or nowhere, the bracket is halved.
"""

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from .quantities import Array

NODES = 14  # degree of the polynomials is one less


class GaussRule(NamedTuple):
    """Quadrature at q nodes on -1..1, and the polynomial through values at them.

    Powers are found from values by way of Legendre polynomials, in two products: the product of the two matrices has entries so large that
    their rounding would be a hundred times that of the values.

    Attributes:
        nodes: (q,) from -1 to 1.
        weights: (q,) of the quadrature.
        cumulative: (q, q) integrals from -1 to the nodes, of values at them.
        legendre: (q, q) coefficients of Legendre polynomials, of values at the nodes.
        powers: (q, q) coefficients in rising powers of the Legendre polynomials.
        integrals: (q + 1, q) coefficients in rising powers of their integrals from -1.
    """

    nodes: Array
    weights: Array
    cumulative: Array
    legendre: Array
    powers: Array
    integrals: Array

    def polynomial(self, values: Array) -> Array:
        """Coefficients (q, n) in rising powers of the polynomials through values (q, n) at the nodes."""
        return np.asarray(self.powers @ (self.legendre @ values))

    def integral(self, values: Array) -> Array:
        """Coefficients (q + 1, n) in rising powers of the integrals from -1 of these polynomials."""
        return np.asarray(self.integrals @ (self.legendre @ values))


@cache
def gauss_rule() -> GaussRule:
    """The rule of `NODES` nodes."""
    legendre = np.polynomial.legendre
    nodes, weights = legendre.leggauss(NODES)
    degrees = np.arange(NODES)
    to_legendre = (degrees[:, None] + 0.5) * legendre.legvander(nodes, NODES - 1).T * weights
    powers, integrals, cumulative = np.zeros((NODES, NODES)), np.zeros((NODES + 1, NODES)), np.zeros((NODES, NODES))
    for k in degrees:
        column, summed = legendre.leg2poly(np.eye(NODES)[k]), legendre.legint(np.eye(NODES)[k], lbnd=-1)
        powers[: len(column), k] = column
        integral = legendre.leg2poly(summed)
        integrals[: len(integral), k] = integral
        cumulative[:, k] = legendre.legval(nodes, summed)
    return GaussRule(nodes, weights, cumulative @ to_legendre, to_legendre, powers, integrals)


def polynomial_values(coefficients: Array, x: Array) -> Array:
    """Values (..., n) at places x (n,) of polynomials with coefficients (..., k, n) of rising powers."""
    value = coefficients[..., -1, :].copy()
    for k in range(coefficients.shape[-2] - 2, -1, -1):
        value *= x
        value += coefficients[..., k, :]
    return value


def values_and_slopes(coefficients: Array, x: Array) -> tuple[Array, Array]:
    """Values and derivatives (n,) at places x (n,) of polynomials with coefficients (k, n) of rising powers."""
    value, slope = coefficients[-1].copy(), np.zeros_like(x)
    for k in range(len(coefficients) - 2, -1, -1):
        slope = slope * x + value
        value = value * x + coefficients[k]
    return value, slope


def horner(falling: Sequence[float], x: float) -> float:
    """Value of one polynomial, coefficients of falling powers."""
    value = 0.0
    for coefficient in falling:
        value = value * x + coefficient
    return value


MOST_STEPS = 60  # halve a bracket down to rounding

ValueAndSlope = Callable[[Array], tuple[Any, Any]]
"""Places (m,) -> values of a function there and its derivatives, (m,) each, which may be complex: their real parts count."""


def bracketed_roots(function: ValueAndSlope, low: Array, high: Array, relative: float = 0.0, absolute: float = 0.0) -> Array:
    """Places (m,) at which a function changes sign, one in each of the brackets from ``low`` (m,) to ``high`` (m,).

    Args:
        relative: change of a place in a step, beside the place, that is rounding.
        absolute: change of a place in a step that is rounding.
    """
    before, place = np.signbit(function(low)[0].real), 0.5 * (low + high)
    for _ in range(MOST_STEPS):
        value, slope = function(place)
        same = np.signbit(value.real) == before
        low, high = np.where(same, place, low), np.where(same, high, place)
        with np.errstate(all="ignore"):
            closer = place - value.real / slope.real
        last, place = place, np.where((closer >= low) & (closer <= high), closer, 0.5 * (low + high))
        if np.all(np.abs(place - last) <= absolute + relative * np.abs(place)):
            break
    return place


def polynomial_root(polynomial: list[float], low: float, high: float) -> float:
    """The root of one polynomial, coefficients of rising powers, between two places from -1 to 1 at which its signs differ.

    Plain numbers: for one polynomial NumPy takes ten times as long.
    """
    powers_falling = polynomial[::-1]
    falling = horner(powers_falling, low) > 0
    x = 0.5 * (low + high)
    for _ in range(100):
        value = slope = 0.0
        for coefficient in powers_falling:
            slope = slope * x + value
            value = value * x + coefficient
        if (value > 0) == falling:
            low = x
        else:
            high = x
        step = value / slope if slope else math.inf
        before, x = x, x - step
        if not low < x < high:
            x = 0.5 * (low + high)
        if abs(x - before) <= 1e-16 or x in (low, high):
            break
    return x
