"""Small numerics: Gauss-Legendre quadrature on -1..1 with the polynomials through its nodes, and roots within brackets, by Newton's method,
which halves the bracket where a step would leave it, or by Brent's, which takes no derivatives.
"""

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from .quantities import Array

NODES = 14  # nodes of the quadrature; the polynomials through them have one degree less
MOST_STEPS = 60  # most steps of Newton's method: as many halvings narrow a bracket down to rounding
EPSILON = float(np.finfo(float).eps)
MOST_BRENT_STEPS = 100  # most steps of Brent's method; it takes about ten
ValueAndSlope = Callable[[Array], tuple[Any, Any]]
"""Places (m,) -> values and derivatives of a function there, (m,) each. They may be complex; decisions are made on their real parts."""


class GaussRule(NamedTuple):
    """Quadrature at q nodes on -1..1, and the polynomial through values at them.

    Coefficients of powers are computed from those of Legendre polynomials in two matrix products, because the product of both matrices
    would have such large entries that it rounds a hundred times as much.

    Attributes:
        nodes: (q,) nodes from -1 to 1.
        weights: (q,) weights of the quadrature.
        cumulative: (q, q) from values at the nodes to integrals from -1 to the nodes.
        legendre: (q, q) from values at the nodes to coefficients of Legendre polynomials.
        powers: (q, q) from coefficients of Legendre polynomials to coefficients of rising powers.
        integrals: (q + 1, q) from coefficients of Legendre polynomials to coefficients of rising powers of their integrals from -1.
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
    """The Gauss-Legendre rule with `NODES` nodes."""
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
    """Value of one polynomial, given by coefficients of falling powers."""
    value = 0.0
    for coefficient in falling:
        value = value * x + coefficient
    return value


def bracketed_roots(function: ValueAndSlope, low: Array, high: Array, relative: float = 0.0, absolute: float = 0.0) -> Array:
    """Places (m,) at which a function changes sign, one in each of m brackets.

    Args:
        function: gives values and derivatives.
        low: (m,) lower ends of the brackets.
        high: (m,) upper ends of the brackets.
        relative: change of a place in a step, as a share of the place, that counts as rounding.
        absolute: change of a place in a step that counts as rounding.
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
    """The root of one polynomial, given by coefficients of rising powers, between two places from -1 to 1 at which its signs differ.

    It computes with Python's own numbers, because NumPy takes ten times as long for one polynomial.
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


def brent_root(function: Callable[[float], float], low: float, high: float, *, xtol: float = 2e-12, rtol: float = 4 * EPSILON) -> float:
    """The place between two others at which a function changes sign, by Brent's method.

    It takes the same steps as `scipy.optimize.brentq`, to the last bit, and saves its import, which takes a third of a second.

    Args:
        function: of one number.
        low: one end of the bracket.
        high: its other end, where the function has the other sign, or is zero.
        xtol: half-width of a bracket that is narrow enough.
        rtol: further half-width, as a share of the place.

    Raises:
        ValueError: the function has one sign at both ends, or no root was found in `MOST_BRENT_STEPS` steps.

    Source: R. P. Brent, Algorithms for Minimization Without Derivatives, 1973, chapter 4.
    """

    def value(place: float) -> float:
        found = float(function(place))
        if math.isnan(found):
            raise ValueError(f"the function has no value at {place}")
        return found

    # `here` is the best place, `before` the one before it, and the root is between `here` and `across`.
    before, here, across = float(low), float(high), 0.0
    f_before, f_here, f_across, last_step, step = value(before), value(here), 0.0, 0.0, 0.0
    if not f_before or not f_here:
        return here if f_before else before
    if (f_before < 0.0) == (f_here < 0.0):
        raise ValueError("the function has one sign at both ends of the bracket")
    for _ in range(MOST_BRENT_STEPS):
        if f_before and f_here and (f_before < 0.0) != (f_here < 0.0):
            across, f_across = before, f_before
            last_step = step = here - before
        if abs(f_across) < abs(f_here):
            before, here, across = here, across, here
            f_before, f_here, f_across = f_here, f_across, f_here
        narrow, half = (xtol + rtol * abs(here)) / 2, (across - here) / 2
        if not f_here or abs(half) < narrow:
            return here
        closer = math.inf
        if abs(last_step) > narrow and abs(f_here) < abs(f_before):
            if before == across:  # by a straight line
                closer = -f_here * (here - before) / (f_here - f_before)
            else:  # by an inverse parabola
                one, other = (f_before - f_here) / (before - here), (f_across - f_here) / (across - here)
                below = other * one * (f_across - f_before)
                closer = -f_here * (f_across * other - f_before * one) / below if below else math.inf
        if 2 * abs(closer) < min(abs(last_step), 3 * abs(half) - narrow):
            last_step, step = step, closer
        else:
            last_step = step = half
        before, f_before = here, f_here
        here += step if abs(step) > narrow else math.copysign(narrow, half)
        f_here = value(here)
    raise ValueError(f"no root was found in {MOST_BRENT_STEPS} steps")
