"""How even the slide's speed is over a stretch of its working stroke.

A window of a given length is moved along the stroke; the speed drops in it from its largest to its least value, each of which is at an end
of the window or at an extreme of the speed in it. Where the drop is least, either the largest or the least value passes from one of these
to another, or both are at the ends and the drop is stationary: these windows are few, all are tried.
"""

import itertools

import numpy as np

from ..common.arrays import Array, ComplexArray
from ..common.errors import PinpressError
from .periodic_curve import Numbers, zeros
from .slide_path import Stroke


def least_drop(stroke: Stroke, length: float) -> complex:
    """Least drop of speed, beside its largest, in a window of a length between nothing and the stroke [m].

    Raises:
        PinpressError: the window cannot be found, states too far apart.
    """
    last = float(stroke.place_at(np.array([stroke.length - length]))[0].real)
    grid = np.append(stroke.nodes[stroke.nodes < last], last)
    with np.errstate(all="ignore"):  # at the dead centres, where the speed is zero, ratios are not finite
        starts = np.concatenate([_equal_ends(stroke, length, grid), _stationary(stroke, length, grid), _levels(stroke, length)])
    starts = starts[(starts.real > grid[0]) & (starts.real < last)]
    if not len(starts):
        raise PinpressError(f"no window of {length:g} m is inside the stroke but for rounding: give a shorter length")
    drops = _drops(stroke, length, starts)
    return complex(drops[drops.real.argmin()])


def _end(stroke: Stroke, length: float, start: Numbers) -> ComplexArray:
    return stroke.place_at(stroke.travel(start) + length)


def _equal_ends(stroke: Stroke, length: float, grid: Array) -> ComplexArray:
    """Starts of the windows with equal speeds at both ends."""

    def difference(start: Numbers) -> tuple[ComplexArray, ComplexArray]:
        (_, v, a, _), (_, v_end, a_end, _) = stroke.path.at(start), stroke.path.at(_end(stroke, length, start))
        return v - v_end, a - a_end * v / v_end

    return zeros(difference, *_changes(difference(grid)[0].real, grid))


def _stationary(stroke: Stroke, length: float, grid: Array) -> ComplexArray:
    """Starts of the windows whose ratio of the speeds at both ends is stationary."""
    inner = grid[1:-1]  # at the stroke's ends the speed is zero

    def growth(place: Numbers) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Of the speed's logarithm with travel; its derivative by the place; the speed."""
        _, v, a, jerk = stroke.path.at(place)
        return a / v**2, jerk / v**2 - 2 * a**2 / v**3, v

    def difference(start: Numbers) -> tuple[ComplexArray, ComplexArray]:
        value, slope, v = growth(start)
        value_end, slope_end, v_end = growth(_end(stroke, length, start))
        return value - value_end, slope - slope_end * v / v_end

    return zeros(difference, *_changes(difference(inner)[0].real, inner))


def _levels(stroke: Stroke, length: float) -> ComplexArray:
    """Starts of the windows that have at one end the speed of one of its extremes."""
    found = [np.empty(0, complex)]
    extremes, nodes = stroke.speed_extremes, stroke.nodes
    speeds = stroke.speed(nodes).real
    for place, level in zip(extremes, stroke.speed(extremes), strict=True):

        def above(at: Numbers, level: complex = level) -> tuple[ComplexArray, ComplexArray]:
            return stroke.speed(at) - level, stroke.path.at(at)[2]

        low, high = _changes(speeds - level.real, nodes)
        beside = (low == place.real) | (high == place.real)  # where the speed touches its extreme
        ends = zeros(above, low[~beside], high[~beside])
        travel = stroke.travel(ends)
        found += [ends[(travel + length).real < stroke.length.real]]
        found += [stroke.place_at(travel[travel.real > length] - length)]
    return np.concatenate(found)


def _changes(values: Array, places: Array) -> tuple[Array, Array]:
    """Stretches between neighbouring places in which a quantity (m,) changes sign."""
    negative = np.signbit(values)
    before = np.flatnonzero(negative[1:] != negative[:-1])
    return places[before], places[before + 1]


def _drops(stroke: Stroke, length: float, starts: ComplexArray) -> ComplexArray:
    """Drop of speed (m,) in windows with these starts."""
    ends = _end(stroke, length, starts)
    peaks, peak_speeds = stroke.speed_extremes.real, stroke.speed(stroke.speed_extremes)
    drops = []
    for start, end, *own in zip(starts.real, ends.real, stroke.speed(starts), stroke.speed(ends), strict=True):
        speeds = np.array([*own, *itertools.compress(peak_speeds, (peaks > start) & (peaks < end))])
        drops.append(1 - speeds[speeds.real.argmin()] / speeds[speeds.real.argmax()])
    return np.array(drops)
