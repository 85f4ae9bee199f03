"""Small numerics: Gauss-Legendre quadrature on -1..1 with the polynomials through its nodes, and Radau IIA collocation. Roots within
brackets: by Newton's method, which halves the bracket where a step would leave it, or without derivatives. Undamped modes, and damped ones,
each with the undamped mode to which it belongs.
"""

import itertools
import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .products import product
from .quantities import Array, ComplexArray

NODES = 14  # nodes of the quadrature; the polynomials through them have one degree less
MOST_STEPS = 60  # most steps of Newton's method: as many halvings narrow a bracket down to rounding
Numbers = NDArray[np.float64] | NDArray[np.complex128]
ValueAndSlope = Callable[[Array], tuple[Any, Any]]
"""Places (m,) -> values and derivatives of a function there, (m,) each. They may be complex; decisions are made on their real parts."""


class GaussRule(NamedTuple):
    """Quadrature at q nodes on -1..1, and the polynomial through values at them.

    Coefficients of powers are computed from those of Legendre polynomials in two matrix products, because the product of both matrices
    would have such large entries that it rounds a hundred times as much.

    Attributes:
        nodes: (q,) nodes from -1 to 1.
        weights: (q,) weights of the quadrature.
        to_end: (q + 1, q) from values at the nodes to integrals from -1 to the nodes and, in the last row, to 1.
        legendre: (q, q) from values at the nodes to coefficients of Legendre polynomials.
        powers: (q, q) from coefficients of Legendre polynomials to coefficients of rising powers.
        integrals: (q + 1, q) from coefficients of Legendre polynomials to coefficients of rising powers of their integrals from -1.
    """

    nodes: Array
    weights: Array
    to_end: Array
    legendre: Array
    powers: Array
    integrals: Array

    @property
    def cumulative(self) -> Array:
        """(q, q) from values at the nodes to integrals from -1 to the nodes."""
        return self.to_end[:-1]

    def polynomial(self, values: Array) -> Array:
        """Coefficients (q, n) in rising powers of the polynomials through values (q, n) at the nodes."""
        return product(self.powers, product(self.legendre, values))

    def integral(self, values: Array) -> Array:
        """Coefficients (q + 1, n) in rising powers of the integrals from -1 of these polynomials."""
        return product(self.integrals, product(self.legendre, values))


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
    return GaussRule(nodes, weights, np.vstack([cumulative @ to_legendre, weights]), to_legendre, powers, integrals)


class RadauRule(NamedTuple):
    """Radau IIA collocation with s points on 0..1, of order 2 s - 1 at the end.

    Attributes:
        points: (s,) the last is 1.
        series: (s, s) from values at the points to Legendre coefficients on 0..1 of the polynomial through them.
        integral: (s + 1, s) from values at the points to Legendre coefficients of the integral of that polynomial from 0.
        integrate: (s, s) from values at the points to integrals from 0 to the points; the last row has the weights.
        integrate_twice: (s, s) from values at the points to second integrals.

    Source: Hairer and Wanner, Solving Ordinary Differential Equations II, IV.5.
    """

    points: Array
    series: Array
    integral: Array
    integrate: Array
    integrate_twice: Array


@cache
def radau_rule(stages: int) -> RadauRule:
    """The Radau IIA rule with s points, from the conditions that define it."""
    legendre = np.polynomial.legendre
    polynomial = np.zeros(stages + 1)
    polynomial[stages], polynomial[stages - 1] = 1.0, -1.0  # the points are the roots of P_s - P_(s-1)
    x = np.sort(legendre.legroots(polynomial).real)
    x -= legendre.legval(x, polynomial) / legendre.legval(x, legendre.legder(polynomial))  # eigenvalues are rounded; this is exact
    x[-1] = 1.0
    series = np.asarray(np.linalg.inv(legendre.legvander(x, stages - 1)), dtype=np.float64)
    integral = 0.5 * np.asarray(legendre.legint(series, lbnd=-1, axis=0), dtype=np.float64)
    integrate = np.asarray(legendre.legvander(x, stages) @ integral)
    return RadauRule(0.5 * (x + 1.0), series, integral, integrate, integrate @ integrate)


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
        slope *= x
        slope += value
        value *= x
        value += coefficients[k]
    return value, slope


def quintics(steps: Array, value: Numbers, first: Numbers, second: Numbers) -> Any:
    """Coefficients (6, ..., m) of the polynomials that have given values and derivatives at both ends of m intervals.

    They belong to rising powers of the distance from an interval's start.

    Args:
        steps: (m,) lengths of the intervals.
        value: (..., m + 1) values at their ends.
        first: (..., m + 1) first derivatives.
        second: (..., m + 1) second derivatives.
    """
    # SciPy's BPoly does the same, but importing it takes longer than everything else that a first cycle does.
    h, start, slope, bend = steps, value[..., :-1], first[..., :-1], second[..., :-1]
    rise = value[..., 1:] - start - h * (slope + 0.5 * h * bend)
    speeding = h * (first[..., 1:] - slope - h * bend)
    bending = 0.5 * h**2 * (second[..., 1:] - bend)
    third = (10 * rise - 4 * speeding + bending) / h**3
    fourth = (-15 * rise + 7 * speeding - 2 * bending) / h**4
    fifth = (6 * rise - 3 * speeding + bending) / h**5
    return np.stack([start, slope, 0.5 * bend, third, fourth, fifth])


def running_sums(start: Array | float, steps: Array) -> Array:
    """(p + 1, n) a ``start`` (n,), and what it becomes with each of the steps (p, n)."""
    result = np.empty((len(steps) + 1, steps.shape[1]))
    result[0], result[1:] = start, steps
    if result.shape[1] < 64:  # of many columns rows are added one by one
        return np.asarray(result.cumsum(axis=0))
    for before, after in itertools.pairwise(result):  # the same sums; for many columns `cumsum` goes through memory in strides
        after += before
    return result


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


def sign_change(function: Callable[[float], float], low: float, high: float, width: float) -> float:
    """The place at which a function of one number changes sign, within ``width``. It takes no derivatives.

    Every step cuts the bracket near the root of its chord, pushed a little towards the middle, but not farther from the middle than lets
    halving still finish in time: a smooth function takes 10 to 20 steps, any other at most four more than by halving. (SciPy's `brentq`
    does as well, but its import takes longer than all else in a first rating.)

    Args:
        function: of one number, with different signs at the ends of the bracket.
        low: one end of the bracket.
        high: its other end.
        width: of a bracket that is narrow enough, positive.

    Source: I. F. D. Oliveira, R. H. C. Takahashi, An enhancement of the bisection method average performance preserving minmax optimality,
    ACM Transactions on Mathematical Software 47(1), 2020.
    """
    f_low, f_high = function(low), function(high)
    steps = math.ceil(math.log2(max(abs(high - low) / width, 1.0))) + 4
    push = 0.2 / abs(high - low)
    for step in range(steps):
        if abs(high - low) <= width or not f_low or not f_high:
            break
        middle, half = 0.5 * (low + high), 0.5 * abs(high - low)
        chord = (f_high * low - f_low * high) / (f_high - f_low)
        towards = math.copysign(1.0, middle - chord)
        near = chord + towards * min(max(push * (2.0 * half) ** 2, 0.5 * width), abs(middle - chord))
        farthest = max(0.5 * width * 2.0 ** (steps - step) - half, 0.0)
        place = near if abs(near - middle) <= farthest else middle - towards * farthest
        value = function(place)
        if (value > 0.0) == (f_high > 0.0):
            high, f_high = place, value
        else:
            low, f_low = place, value
    return low if not f_low else high if not f_high else 0.5 * (low + high)


def undamped_modes(mass: Array, stiffness: Array) -> tuple[Array, Array]:
    """Squares of the natural frequencies (..., n), rising, and shapes (..., n, n) of modal mass 1 as columns.

    Raises:
        LinAlgError: a mass matrix (..., n, n) is not positive definite.
    """
    inverse = np.linalg.inv(np.linalg.cholesky(mass))
    transposed = np.swapaxes(inverse, -1, -2)
    squared, vectors = np.linalg.eigh(inverse @ stiffness @ transposed)
    return squared, transposed @ vectors


def pair_modes(likeness: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs of modes of two sets whose likenesses (m, n) sum to the most: numbers in the first set, rising, and in the second."""
    from scipy.optimize import linear_sum_assignment  # slow to import

    first, second = linear_sum_assignment(likeness, maximize=True)
    return first, second


class DampedModes(NamedTuple):
    """Damped modes, in the order of the undamped ones.

    Attributes:
        frequency: (n,) frequencies at which they swing, 0 for those that creep [rad/s].
        ratio: (n,) damping ratios: the mean rate of decay by the root of the product of the two eigenvalues [-].
        eigenvalues: (2 n,) of the system in first order [rad/s].
    """

    frequency: Array
    ratio: Array
    eigenvalues: ComplexArray


def damped_modes(frequency: Array, damping: Array) -> DampedModes:
    """Damped modes of a system in its undamped modes of modal mass 1.

    A mode swings with a pair of conjugate eigenvalues, or creeps with two real ones. Each pair, then each real one, goes to the undamped
    mode that takes most part in its motion.

    Args:
        frequency: (n,) undamped frequencies [rad/s].
        damping: (n, n) modal damping [1/s].
    """
    count = len(frequency)
    matrix = np.block([[np.zeros((count, count)), np.eye(count)], [-np.diag(frequency**2), -damping]])
    values, vectors = np.linalg.eig(matrix)
    values, moved = values.astype(complex), np.abs(vectors[:count]) ** 2
    part = moved / moved.sum(axis=0)  # (n, 2 n)
    swinging, creeping = np.flatnonzero(values.imag > 0), np.flatnonzero(values.imag == 0)
    modes, chosen = pair_modes(part[:, swinging])
    pairs = np.empty((count, 2), dtype=complex)
    pairs[modes] = np.stack([values[swinging[chosen]], values[swinging[chosen]].conj()], axis=1)
    crept = np.setdiff1d(np.arange(count), modes)
    chosen = pair_modes(np.repeat(part[crept], 2, axis=0)[:, creeping])[1]
    pairs[crept] = values[creeping[chosen]].reshape(-1, 2)
    product, fastest = pairs.prod(axis=1).real, np.abs(pairs).max(axis=1)
    # a slow rate that rounding hides is that of the undamped frequency, whose square is the product
    size = np.where(product > count * np.finfo(float).eps * fastest**2, np.sqrt(np.maximum(product, 0.0)), frequency)
    return DampedModes(pairs[:, 0].imag.copy(), -pairs.sum(axis=1).real / (2.0 * size), values)
