"""Experiments: points of a sweep that fill ranges evenly, as all combinations of levels or as a Latin hypercube.

    points = pp.sweeps.latin_hypercube({"rod": (0.0, 150.0), "counterweight": (900.0, 1200.0)}, 200, seed=1)
    table = pp.sweeps.sweep(shaking_of, points, paired=True)  # def shaking_of(rod, counterweight): ... return {"range": ...}

A full factorial of d arguments with k levels has k^d points, and shows each argument at only k values. A Latin hypercube of n points has n
values of each argument, one in every n-th part of its range. Its number of points is free for any number of arguments.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..common.arguments import number, typed, whole_number
from ..common.errors import PinpressError, UnknownNameError, shown

MOST_POINTS = 10_000_000  # of one set of experiments
MOST_ARGUMENTS = 1000


@typed
def full_factorial(ranges: Mapping[str, object], levels: int | Mapping[str, int]) -> dict[str, tuple[float, ...]]:
    """Make the axes of all combinations of equally spaced levels, a grid for `sweep`.

    Args:
        ranges: name of an argument -> its lowest and highest value.
        levels: number of levels of every argument, including the ends, at least 2; or name -> number of levels.

    Returns:
        Name -> levels (k,), rising.

    Raises:
        PinpressError: a range is not two finite numbers, the lower one first, or there are fewer than two levels or too many points.
        UnknownNameError: levels are given for an argument that has no range.
    """
    ends = _ends(ranges)
    if isinstance(levels, Mapping):
        for name in levels:
            if name not in ends:
                raise UnknownNameError("range", name, tuple(ends))
        missing = [name for name in ends if name not in levels]
        if missing:
            raise PinpressError(f"levels: {', '.join(map(shown, missing))} is missing; give a number of levels for each range")
    counts = {
        name: whole_number(f"levels of {shown(name)}", levels[name] if isinstance(levels, Mapping) else levels, 2, MOST_POINTS)
        for name in ends
    }
    total = 1
    for count in counts.values():
        total *= count
    if total > MOST_POINTS:
        raise PinpressError(f"levels: {total} combinations; give fewer than {MOST_POINTS}, or a latin_hypercube")
    return {name: tuple(np.linspace(low, high, counts[name]).tolist()) for name, (low, high) in ends.items()}


@typed
def latin_hypercube(ranges: Mapping[str, object], count: int, *, seed: int = 0) -> dict[str, tuple[float, ...]]:
    """Make the columns of a Latin hypercube, for `sweep` with ``paired=True``: each n-th part of each range has one random point.

    Args:
        ranges: name of an argument -> its lowest and highest value.
        count: number n of points.
        seed: seed of the random numbers; the same seed gives the same points.

    Returns:
        Name -> values (n,) of the points.

    Raises:
        PinpressError: a range is not two finite numbers, the lower one first, or the number of points or the seed is wrong.
    """
    ends = _ends(ranges)
    points = whole_number("count", count, 1, MOST_POINTS)
    start = whole_number("seed", seed, 0, 2**63 - 1)
    if points * len(ends) > MOST_POINTS:
        raise PinpressError(f"count is {points} points of {len(ends)} arguments; give fewer than {MOST_POINTS} values in total")
    from scipy.stats import qmc  # slow to import

    shares = qmc.LatinHypercube(len(ends), seed=np.random.default_rng(start)).random(points)
    low, high = np.array(list(ends.values())).T
    values = (1.0 - shares) * low + shares * high  # no difference of large ends, which might overflow
    return {name: tuple(column.tolist()) for name, column in zip(ends, values.T, strict=True)}


def _ends(ranges: Mapping[str, object]) -> dict[str, tuple[float, float]]:
    """Lowest and highest value of each argument."""
    if not isinstance(ranges, Mapping) or not 0 < len(ranges) <= MOST_ARGUMENTS:
        raise PinpressError(
            f"ranges is {shown(ranges)}: give a mapping of 1 to {MOST_ARGUMENTS} names of arguments to their ends, {{'speed': (5.0, 7.0)}}"
        )
    found = {}
    for name, given in ranges.items():
        if not isinstance(name, str) or not name:
            raise PinpressError(f"ranges: {shown(name)} is not a name of an argument; give texts")
        ends = given.tolist() if isinstance(given, np.ndarray) else given
        if not isinstance(ends, list | tuple) or len(ends) != 2:
            raise PinpressError(f"ranges: the range of {shown(name)} is {shown(given)}; give its lowest and highest value, (5.0, 7.0)")
        low, high = (number(f"range of {shown(name)}", end) for end in ends)
        if not low < high:
            raise PinpressError(f"ranges: the range of {shown(name)} goes from {low:g} to {high:g}; give the lower end first")
        found[name] = (low, high)
    return found
