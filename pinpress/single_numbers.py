"""Arguments that are one number."""

import math

import numpy as np
from numpy.typing import ArrayLike

from .errors import PinpressError

SMALLEST, LARGEST = 1e-12, 1e12  # of a size, in SI units: squares of what is smaller or larger lose meaning


def number(name: str, value: ArrayLike, positive: bool = False) -> float:
    """The value as a finite number, named in the `PinpressError` where it is none."""
    try:
        array = np.asarray(value, dtype=float)
        found = float(array) if array.ndim == 0 and not isinstance(value, bool | str) else math.nan
    except (TypeError, ValueError):
        found = math.nan
    if not math.isfinite(found) or (positive and found <= 0):
        raise PinpressError(f"{name} is {value!r}: give one finite number{', positive' if positive else ''}")
    return found


def positive(what: str, value: object, unit: str) -> float:
    """A size as a number; raises PinpressError where it is not positive, or so small or large that its squares lose meaning."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not SMALLEST <= value <= LARGEST:
        raise PinpressError(f"{what} is {value!r}: give a positive number [{unit}], from {SMALLEST:g} to {LARGEST:g}")
    return float(value)
