"""Measures in which requirements on a press are stated, of its slide's motion and of the angles between its links (pressure angle and
transmission angle): plain functions of the motion of one period at constant speed, as `cycle` gives it.

The working stroke goes against the guide's axis, downwards in an upright press; with ``downwards=False`` the measure is that of the other
stroke. Heights [m] are those above bottom dead centre, the outermost turning point against the axis. Between its states a motion is taken
for the quintics through their positions, velocities and accelerations: the measures of the shipped presses are right to 1e-9 with 360
points and to 1e-5 with 45; fewer than resolve the motion to 1e-5 are refused.

All functions are analytic in the arrays of the motion: of complex ones the measure is complex, and derivatives by parameters are found by
the complex-step method, the imaginary part of the measure for arrays of values + i h derivatives, h about 1e-30, divided by h.

All raise PinpressError for a motion that is no such period, has no slide or one that does not turn back, or has too few states; those of
the working stroke for a slide that turns back more than twice in it too.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import suitable_numbers, typed
from ..common.errors import PinpressError
from ..common.frozen import NamedArrays
from ..common.quantities import Array, ComplexArray
from ..linkage.linkage import Linkage
from .motion import Motion, bearing_points, poses
from .periodic_curve import CrankMotion, Curve, Numbers, curve, step_angle, step_time, zeros
from .slide_path import SlideMotion, Stroke, slide_path, working_stroke

__all__ = [
    "SlideMotion",
    "bearing_positions",
    "dwell_angle",
    "dwell_time",
    "mechanical_advantage",
    "pressure_angle",
    "quick_return_ratio",
    "speed_at",
    "speed_ratio",
    "speed_variation",
    "stroke",
    "transmission_angle",
]


def stroke(motion: SlideMotion) -> float:
    """Distance between the slide's outermost turning points [m]."""
    path = slide_path(motion)
    bottom, top = path.extremes()
    return path.number(top - bottom)


@typed
def quick_return_ratio(motion: SlideMotion, downwards: bool = True) -> float:
    """Time of the working stroke beside that of the return stroke: more than 1 where the slide returns quickly.

    K = (pi + theta) / (pi - theta), the working stroke taking the crank angle pi + theta (Chen 2002).
    """
    way = working_stroke(motion, downwards)
    working = way.end - way.start
    return way.path.number(working / (way.path.states - working))


@typed
def speed_ratio(motion: SlideMotion, downwards: bool = True) -> float:
    """Highest speed of the slide in the working stroke beside its mean, stroke by time (objective of Chen 2002)."""
    way = working_stroke(motion, downwards)
    speeds = way.speed(way.speed_extremes)
    return way.path.number(speeds[speeds.real.argmax()] * (way.end - way.start) / way.length)


@typed
def speed_variation(motion: SlideMotion, length: float, downwards: bool = True) -> float:
    """Least drop of speed, 1 - lowest / highest, over any stretch of this length of the working stroke [-]; 0 is an even speed.

    Args:
        length: of the stretch, less than the stroke [m].

    Raises:
        PinpressError: a length that is not between 0 and the stroke.
    """
    way = working_stroke(motion, downwards)
    return way.path.number(_least_drop(way, _within(way.length, "length", length)))


@typed
def speed_at(motion: SlideMotion, height: float, downwards: bool = True) -> float:
    """Speed of the slide at a height above bottom dead centre [m], such as that at which the tool meets the work; positive [m/s].

    Raises:
        PinpressError: a height that is not between 0 and the stroke.
    """
    path, speed = _speed_by_state(motion, height, downwards)
    return path.number(speed / step_time(motion))


@typed
def mechanical_advantage(motion: SlideMotion, height: float, downwards: bool = True) -> float:
    """Force on the slide for each N m on the crank at a height above bottom dead centre [m], without losses and inertia: crank speed by
    slide speed, 1 / |ds/dtheta| [1/m] (virtual work). It grows without bounds towards the dead centres.

    Raises:
        PinpressError: a height that is not between 0 and the stroke.
    """
    path, speed = _speed_by_state(motion, height, downwards)
    return path.number(abs(step_angle(motion)) / speed)


def dwell_angle(motion: SlideMotion, tolerance: float) -> float:
    """Angle by which the crank turns while the slide stays within a tolerance [m] of bottom dead centre, at one stretch [rad].

    Raises:
        PinpressError: a tolerance that is not between 0 and the stroke.
    """
    path, states = _dwell(motion, tolerance)
    return path.number(states * abs(step_angle(motion)))


def dwell_time(motion: SlideMotion, tolerance: float) -> float:
    """The same as a time [s]. Raises as `dwell_angle`."""
    path, states = _dwell(motion, tolerance)
    return path.number(states * step_time(motion))


def _speed_by_state(motion: SlideMotion, height: float, downwards: bool) -> tuple[Curve, complex]:
    """The slide's path, and its speed at a height, in metres from state to state."""
    way = working_stroke(motion, downwards)
    above = _within(way.length, "height", height)
    place = way.place_at(np.array([way.length - above if downwards else above + 0j]))
    return way.path, complex(way.speed(place)[0])


def _dwell(motion: SlideMotion, tolerance: float) -> tuple[Curve, complex]:
    """The slide's path, and how many states long it stays within the tolerance."""
    path = slide_path(motion)
    least, most = path.extremes()
    level = least + _within(most - least, "tolerance", tolerance)
    turning = path.turning_places().real
    bottom = float(turning[path.at(turning)[0].real.argmin()])
    after = bottom + path.states
    # From bottom to bottom; between two of these the slide goes one way.
    places = np.unique(np.concatenate([[bottom, after], turning + path.states * (turning < bottom), np.arange(np.ceil(bottom), after)]))
    outside = np.flatnonzero(path.at(places)[0].real > level.real)
    if not len(outside):
        raise PinpressError(f"tolerance is {tolerance:g}, the whole stroke but for rounding: give less")
    leaves, returns = outside[0], outside[-1]

    def above(place: Numbers) -> tuple[ComplexArray, ComplexArray]:
        value, slope, _, _ = path.at(place)
        return value - level, slope

    until, since = zeros(above, places[[leaves - 1, returns]], places[[leaves, returns + 1]])
    return path, complex(until - since) + path.states


def _within(stroke: complex, name: str, value: object) -> float:
    """A distance that is more than nothing and less than the stroke [m]."""
    wanted = f"a distance between 0 and the stroke of {stroke.real:.6g} m"
    return float(suitable_numbers(name, value, wanted, suits=lambda distance: 0.0 < distance < stroke.real))


def _least_drop(stroke: Stroke, length: float) -> complex:
    """Least drop of speed, beside its largest, in a window of a length between nothing and the stroke [m].

    A window of this length is moved along the stroke. The speed drops in it from its largest to its least value, each of which is at an
    end of the window or at an extreme of the speed in it. Where the drop is least, either the largest or the least value passes from one
    of these to another, or both are at the ends and the drop is stationary: these windows are few, and all are tried.

    Raises:
        PinpressError: The window cannot be found, as states are too far apart.
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


def _end_of_window(stroke: Stroke, length: float, start: Numbers) -> ComplexArray:
    return stroke.place_at(stroke.travel(start) + length)


def _equal_ends(stroke: Stroke, length: float, grid: Array) -> ComplexArray:
    """Starts of the windows with equal speeds at both ends."""

    def difference(start: Numbers) -> tuple[ComplexArray, ComplexArray]:
        (_, v, a, _), (_, v_end, a_end, _) = stroke.path.at(start), stroke.path.at(_end_of_window(stroke, length, start))
        return v - v_end, a - a_end * v / v_end

    return zeros(difference, *_sign_changes(difference(grid)[0].real, grid))


def _stationary(stroke: Stroke, length: float, grid: Array) -> ComplexArray:
    """Starts of the windows whose ratio of the speeds at both ends is stationary."""
    inner = grid[1:-1]  # at the stroke's ends the speed is zero

    def growth(place: Numbers) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Of the speed's logarithm with travel; its derivative by the place; the speed."""
        _, v, a, jerk = stroke.path.at(place)
        return a / v**2, jerk / v**2 - 2 * a**2 / v**3, v

    def difference(start: Numbers) -> tuple[ComplexArray, ComplexArray]:
        value, slope, v = growth(start)
        value_end, slope_end, v_end = growth(_end_of_window(stroke, length, start))
        return value - value_end, slope - slope_end * v / v_end

    return zeros(difference, *_sign_changes(difference(inner)[0].real, inner))


def _levels(stroke: Stroke, length: float) -> ComplexArray:
    """Starts of the windows that have at one end the speed of one of its extremes."""
    found = [np.empty(0, complex)]
    extremes, nodes = stroke.speed_extremes, stroke.nodes
    speeds = stroke.speed(nodes).real
    for place, level in zip(extremes, stroke.speed(extremes), strict=True):

        def above(at: Numbers, level: complex = level) -> tuple[ComplexArray, ComplexArray]:
            return stroke.speed(at) - level, stroke.path.at(at)[2]

        low, high = _sign_changes(speeds - level.real, nodes)
        beside = (low == place.real) | (high == place.real)  # where the speed touches its extreme
        ends = zeros(above, low[~beside], high[~beside])
        travel = stroke.travel(ends)
        found += [ends[(travel + length).real < stroke.length.real]]
        found += [stroke.place_at(travel[travel.real > length] - length)]
    return np.concatenate(found)


def _sign_changes(values: Array, places: Array) -> tuple[Array, Array]:
    """Stretches between neighbouring places in which a quantity (m,) changes sign."""
    negative = np.signbit(values)
    before = np.flatnonzero(negative[1:] != negative[:-1])
    return places[before], places[before + 1]


def _drops(stroke: Stroke, length: float, starts: ComplexArray) -> ComplexArray:
    """Drop of speed (m,) in windows with these starts."""
    ends = _end_of_window(stroke, length, starts)
    peaks, peak_speeds = stroke.speed_extremes.real, stroke.speed(stroke.speed_extremes)
    drops = []
    for start, end, *own in zip(starts.real, ends.real, stroke.speed(starts), stroke.speed(ends), strict=True):
        speeds = np.array([*own, *itertools.compress(peak_speeds, (peaks > start) & (peaks < end))])
        drops.append(1 - speeds[speeds.real.argmin()] / speeds[speeds.real.argmax()])
    return np.array(drops)


FINER = 8  # times as many places as states that an angle's cosine or squared sine is worked out at
UNRESOLVED = 1e-9  # amplitude of one of the last quarter of the harmonics that n states carry, above which these are too few


@typed
def bearing_positions(press: Linkage, motion: Motion) -> Mapping[str, Array]:
    """World positions (n, 3) of all bearings [m], where their forces act: the origin of the child's joint frame, of a loop its point.

    Raises:
        PinpressError: a motion of a linkage with other joints. UnknownNameError: a bearing that is not there.
    """
    if motion.joints != press.joints:
        raise PinpressError(f"the motion is of {motion.linkage} with other joints than {press.name}: make it with cycle(press, ...)")
    return NamedArrays(press.bearings, bearing_points(press, poses(press, motion.joint_position)))


def pressure_angle(motion: CrankMotion, driven: Numbers, other: Numbers, axis: ArrayLike) -> float:
    """Largest angle between a link, the line of two of its pins, and the way of what it drives, 0 to pi/2 [rad].

    It is the angle between force and velocity where the link bears no load across: sin(angle) = |axis x (driven - other)| / length. pi/2
    means that the link stands square to the way at some crank angle. Chen 2002 asks for at most 40 degrees.

    Args:
        motion: one period at constant speed. driven, other: (n, 3) positions of the two pins [m], see `bearing_positions`.
        axis: (3,) of the guide; of any length.

    Raises:
        PinpressError: not such a period, arrays of other shapes or not finite, pins in one place, or states too far apart.
    """
    link = _line(motion, "driven", driven, "other", other)
    way = suitable_numbers("axis", axis, "a direction (3,)", (3,), np.any)
    way = way / np.abs(way).max()  # so that no square overflows, or is lost
    way = way / np.linalg.norm(way)
    along, across = link @ way, np.cross(link, way)
    squared_sine = _smooth("the pressure angle", _dot(across, across) / _dot(link, link), driven, other)
    largest = squared_sine.extremes()[1]
    turned_away = along.real.min() <= 0.0 <= along.real.max()
    return squared_sine.number(0.5 * np.pi if turned_away or largest.real >= 1.0 else np.arcsin(np.sqrt(largest)))


def transmission_angle(motion: CrankMotion, pin: Numbers, one: Numbers, another: Numbers) -> float:
    """Smallest angle between the lines of two links at the pin that joins them, 0 to pi/2 [rad].

    cos(angle) = (one - pin) . (another - pin) / lengths, of an obtuse angle the one that makes it a straight angle. 0 means that the links
    come into line at some crank angle.

    Args:
        motion: one period at constant speed. pin, one, another: (n, 3) positions of the pin and of the links' other pins [m], see
            `bearing_positions`.

    Raises:
        PinpressError: not such a period, arrays of other shapes or not finite, pins in one place, or states too far apart.
    """
    first, second = _line(motion, "one", one, "pin", pin), _line(motion, "another", another, "pin", pin)
    cosine = _smooth("the transmission angle", _dot(first, second) / np.sqrt(_dot(first, first) * _dot(second, second)), pin, one, another)
    least, most = cosine.extremes()
    sharpest = most if most.real > -least.real else -least
    across = np.cross(first, second).real
    in_line = np.any(np.sum(across * np.roll(across, -1, axis=0), axis=1) <= 0)  # they pass each other from one state to the next
    return cosine.number(0.0 if in_line or sharpest.real >= 1.0 else np.arccos(sharpest))


def _line(motion: CrankMotion, name: str, to: Numbers, beginning_name: str, beginning: Numbers) -> ComplexArray:
    """Vectors (n, 3) from one pin to another."""
    step_angle(motion)  # refuses what is no full period
    states = len(motion.crank_angle)
    for what, positions in ((name, to), (beginning_name, beginning)):
        if not isinstance(positions, np.ndarray):
            raise PinpressError(f"{what} is a {type(positions).__name__}: give positions ({states}, 3), see bearing_positions")
        if positions.shape != (states, 3) or positions.dtype.kind not in "fc" or not np.all(np.isfinite(positions)):
            raise PinpressError(f"{what} has shape {np.shape(positions)}, or is not finite: give positions ({states}, 3), a state a row")
    line: ComplexArray = np.asarray(to, dtype=complex) - np.asarray(beginning, dtype=complex)
    if not np.all(_dot(line, line).real > 0):
        raise PinpressError(f"{name} and {beginning_name} are in one place at some crank angle: give two pins of one link")
    return line


def _dot(one: ComplexArray, another: ComplexArray) -> ComplexArray:
    """Products (n,) without conjugation, which would not be analytic."""
    return np.asarray((one * another).sum(axis=1))


def _smooth(what: str, values: ComplexArray, *given: Numbers) -> Curve:
    """A quantity (n,) of about one over the period: its trigonometric polynomial at more places, with derivatives."""
    n = len(values)
    orders = np.arange(n // 2 + 1)
    harmonics = np.fft.rfft(values.real), np.fft.rfft(values.imag)  # apart: one transform would round the one into the other
    if np.abs(harmonics[0][-max(2, len(orders) // 4) :]).max() > UNRESOLVED * n:
        raise PinpressError(f"{n} states do not resolve {what} over the period, or the linkage is elsewhere after it: give more points")

    def derivative(order: int) -> ComplexArray:
        finer = FINER * n
        real, imaginary = (FINER * np.fft.irfft((2j * np.pi / finer * orders) ** order * harmonic, finer) for harmonic in harmonics)
        return np.asarray(real + 1j * imaginary)

    return curve(what, derivative(0), derivative(1), derivative(2), not any(map(np.iscomplexobj, given)))
