"""The part of a stroke with the evenest speed: a window of given length with the smallest drop of speed, or the longest with a given drop.

All is analytic in the motion, see `periodic_curve`; lengths may be complex for the same reason.
"""

from __future__ import annotations

import itertools

import numpy as np

from ..common.arguments import suitable_numbers
from ..common.errors import PinpressError
from ..common.numerics import Numbers, sign_change
from ..common.quantities import Array, ComplexArray
from .periodic_curve import zeros
from .slide_path import Stroke

SHORTEST, LONGEST = 1e-6, 1 - 1e-9  # windows between which the longest is looked for, as shares of the stroke
ROUNDING = 4 * float(np.finfo(float).eps)  # of a length, as a share of the stroke
TINY = 1e-30  # step of the complex-step method [m]


def inside_stroke(stroke: complex, name: str, value: object) -> float:
    """A checked distance, more than 0 and less than the stroke [m]."""
    wanted = f"a distance between 0 and the stroke of {stroke.real:.6g} m ({1e3 * stroke.real:.6g} mm)"
    return float(suitable_numbers(name, value, wanted, suits=lambda distance: 0.0 < distance < stroke.real))


def evenest_window(stroke: Stroke, length: complex) -> tuple[complex, complex]:
    """Where the window of this length on the stroke with the smallest drop of speed starts, and that drop as a share of its largest speed.

    A window of this length is moved along the stroke. The largest and the least speed in it are each at an end of the window or at an
    extreme of the speed. Where the drop is smallest, either one of them passes from one of these places to another, or both are at the ends
    and the drop is stationary. There are only few such windows, and all of them are tried.

    Raises:
        PinpressError: the stroke has no such window, but for rounding.
    """
    last = float(stroke.place_at(np.array([stroke.length - length.real]))[0].real)
    grid = np.append(stroke.nodes[stroke.nodes < last], last)
    with np.errstate(all="ignore"):  # at the dead centres, where the speed is zero, ratios are not finite
        starts = np.concatenate(
            [_equal_speeds_at_ends(stroke, length, grid), _stationary_ratio(stroke, length, grid), _extreme_at_one_end(stroke, length)]
        )
    starts = starts[(starts.real > grid[0]) & (starts.real < last)]
    if not len(starts):
        raise PinpressError(f"no window of {length.real:g} m is inside the stroke but for rounding: give a shorter length")
    drops = _drops_from(stroke, length, starts)
    least = drops.real.argmin()
    return complex(starts[least]), complex(drops[least])


def longest_window(stroke: Stroke, drop: float) -> complex:
    """Length of the longest window on the stroke in which the speed drops by a share, 0 to 1, of its largest speed there [m].

    The least drop grows with the window's length, since a window holds all shorter ones.
    """

    def beyond(length: float) -> float:
        return evenest_window(stroke, length)[1].real - drop

    low, high = (stroke.length.real * share for share in (SHORTEST, LONGEST))
    if beyond(low) > 0 or beyond(high) < 0:
        raise PinpressError(f"a variation of {drop:g} is that of no part of the stroke, or of all of it, but for rounding: give another")
    length = sign_change(beyond, low, high, ROUNDING * high)
    if stroke.path.real:
        return length
    by_parameter = evenest_window(stroke, length)[1].imag
    slope = (evenest_window(stroke, length + 1j * TINY)[1].imag - by_parameter) / TINY
    return complex(length, -by_parameter / slope)


def _end_of_window(stroke: Stroke, length: complex, start: Numbers) -> ComplexArray:
    """Places of the ends of windows with these starts (m,)."""
    return stroke.place_at(stroke.travel(start) + length)


def _equal_speeds_at_ends(stroke: Stroke, length: complex, grid: Array) -> ComplexArray:
    """Starts of the windows with equal speeds at both ends."""

    def difference(start: Numbers) -> tuple[ComplexArray, ComplexArray]:
        (_, v, a), (_, v_end, a_end) = stroke.path.at(start, 2), stroke.path.at(_end_of_window(stroke, length, start), 2)
        return v - v_end, a - a_end * v / v_end

    return zeros(difference, *_sign_changes(difference(grid)[0].real, grid))


def _stationary_ratio(stroke: Stroke, length: complex, grid: Array) -> ComplexArray:
    """Starts of the windows whose ratio of the speeds at both ends is stationary."""
    inner = grid[1:-1]  # at the stroke's ends the speed is zero

    def growth(place: Numbers) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Growth of the speed's logarithm with travel, its derivative by the place, and the speed."""
        _, v, a, jerk = stroke.path.at(place)
        return a / v**2, jerk / v**2 - 2 * a**2 / v**3, v

    def difference(start: Numbers) -> tuple[ComplexArray, ComplexArray]:
        value, slope, v = growth(start)
        value_end, slope_end, v_end = growth(_end_of_window(stroke, length, start))
        return value - value_end, slope - slope_end * v / v_end

    return zeros(difference, *_sign_changes(difference(inner)[0].real, inner))


def _extreme_at_one_end(stroke: Stroke, length: complex) -> ComplexArray:
    """Starts of the windows at one of whose ends the speed equals one of its extremes on the stroke."""
    starts = [np.empty(0, complex)]
    extremes, nodes = stroke.speed_extremes, stroke.nodes
    speeds = stroke.speed(nodes).real
    for place, level in zip(extremes, stroke.speed(extremes), strict=True):

        def above(at: Numbers, level: complex = level) -> tuple[ComplexArray, ComplexArray]:
            return stroke.speed(at) - level, stroke.path.at(at, 2)[2]

        low, high = _sign_changes(speeds - level.real, nodes)
        touching = (low == place.real) | (high == place.real)  # at the extreme itself
        ends = zeros(above, low[~touching], high[~touching])
        travel = stroke.travel(ends)
        starts += [ends[(travel + length).real < stroke.length.real]]
        starts += [stroke.place_at(travel[travel.real > length.real] - length)]
    return np.concatenate(starts)


def _sign_changes(values: Array, places: Array) -> tuple[Array, Array]:
    """Lower and upper ends of the intervals between neighbouring places (m,) in which a quantity (m,) changes sign."""
    negative = np.signbit(values)
    before = np.flatnonzero(negative[1:] != negative[:-1])
    return places[before], places[before + 1]


def _drops_from(stroke: Stroke, length: complex, starts: ComplexArray) -> ComplexArray:
    """Drop of speed (m,) in the windows with these starts (m,)."""
    ends = _end_of_window(stroke, length, starts)
    peaks, peak_speeds = stroke.speed_extremes.real, stroke.speed(stroke.speed_extremes)
    drops = []
    for start, end, *own in zip(starts.real, ends.real, stroke.speed(starts), stroke.speed(ends), strict=True):
        speeds = np.array([*own, *itertools.compress(peak_speeds, (peaks > start) & (peaks < end))])
        drops.append(1 - speeds[speeds.real.argmin()] / speeds[speeds.real.argmax()])
    return np.array(drops)
