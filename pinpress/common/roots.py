"""Newton's method, fenced in by a bracket: where a step leads out of it, or nowhere, the bracket is halved."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from .arrays import Array
from .gauss import horner

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
