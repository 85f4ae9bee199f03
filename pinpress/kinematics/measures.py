"""Measures of the slide's motion and of the angles between links, in which requirements on a press are stated.

They are functions of a motion over one period at constant speed, as `cycle` gives it. The working stroke goes downwards, against
the slide's direction; with ``downwards=False`` a measure is that of the other stroke. Heights [m] count from bottom dead centre, the lowest
turning point. Between its states a motion is interpolated by quintics through positions, velocities and
accelerations: the measures of the shipped presses have errors of 1e-9 with 360 points and of 1e-5 with 45. A motion with too few states to
be resolved to 1e-5 is refused.

All functions are analytic in the arrays of the motion, so that the complex-step method gives derivatives by parameters: for arrays of
values + i h derivatives, with h about 1e-30, the imaginary part of the measure divided by h is its derivative.

All raise PinpressError for a motion that is not one period at constant speed, has no slide, has a slide that does not turn back, or has too
few states. Those of the working stroke also raise it for a slide that turns back more than twice in the period.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import suitable_numbers, typed
from ..common.errors import PinpressError
from ..common.frozen import NamedArrays
from ..common.numerics import Numbers
from ..common.quantities import Array, ComplexArray
from ..linkage.linkage import Linkage
from .even_speed import evenest_window, inside_stroke, longest_window
from .motion import Motion, refuse_motion_of_another
from .periodic_curve import CrankMotion, Curve, curve, step_angle, step_time
from .poses import bearing_points, poses
from .slide_path import SlideMotion, slide_path, working_stroke

FINER = 8  # places between two states at which an angle's cosine or squared sine is evaluated


def stroke(motion: SlideMotion) -> float:
    """Distance between the slide's outermost turning points [m].

    Raises:
        PinpressError: the motion is not one period at constant speed, has no slide, a slide that does not turn back, or too few states.
    """
    path = slide_path(motion)
    bottom, top = path.extremes()
    return path.number(top - bottom)


@typed
def quick_return_ratio(motion: SlideMotion, downwards: bool = True) -> float:
    """Time of the working stroke divided by that of the return stroke [-]: more than 1 where the slide returns quickly.

    It is K = (pi + theta) / (pi - theta) where the working stroke takes the crank angle pi + theta (Chen 2002).
    """
    way = working_stroke(motion, downwards)
    working = way.end - way.start
    return way.path.number(working / (way.path.states - working))


@typed
def speed_ratio(motion: SlideMotion, downwards: bool = True) -> float:
    """Highest speed of the slide in the working stroke divided by its mean speed there [-] (objective of Chen 2002)."""
    way = working_stroke(motion, downwards)
    speeds = way.speed(way.speed_extremes)
    return way.path.number(speeds[speeds.real.argmax()] * (way.end - way.start) / way.length)


@typed
def speed_variation(motion: SlideMotion, length: float, downwards: bool = True) -> float:
    """Smallest variation of speed, 1 - lowest / highest, over any part of the working stroke that has this length [-]. 0 is an even speed.

    Args:
        motion: one period at constant speed.
        length: length of the part, less than the stroke [m].
        downwards: whether the working stroke goes against the slide's direction.

    Raises:
        PinpressError: a length that is not between 0 and the stroke; a motion that `stroke` refuses, or a slide that turns back more than
            twice in the period.
    """
    way = working_stroke(motion, downwards)
    return way.path.number(evenest_window(way, inside_stroke(way.length, "length", length))[1])


@typed
def even_length(motion: SlideMotion, variation: float, downwards: bool = True) -> float:
    """Longest part of the working stroke in which the speed varies by no more than a share, 1 - lowest / highest [m].

    It is the length whose `speed_variation` is ``variation``: 0.1 gives the part on which the slide keeps 90 % of its highest speed there.

    Args:
        motion: one period at constant speed.
        variation: share between 0 and 1 [-].
        downwards: whether the working stroke goes against the slide's direction.

    Raises:
        PinpressError: a variation that is not between 0 and 1; a motion that `stroke` refuses, or a slide that turns back more than twice
            in the period.
    """
    way = working_stroke(motion, downwards)
    share = float(suitable_numbers("variation", variation, "a share of the highest speed between 0 and 1", suits=lambda x: 0.0 < x < 1.0))
    return way.path.number(longest_window(way, share))


@typed
def speed_at(motion: SlideMotion, height: float, downwards: bool = True) -> float:
    """Speed of the slide at a height above bottom dead centre, such as that at which the tool meets the work; positive [m/s].

    Args:
        motion: one period at constant speed.
        height: above bottom dead centre [m].
        downwards: whether the working stroke goes against the slide's direction.

    Raises:
        PinpressError: a height that is not between 0 and the stroke; a motion that `stroke` refuses, or a slide that turns back more than
            twice in the period.
    """
    path, speed = _speed_by_state(motion, height, downwards)
    return path.number(speed / step_time(motion))


@typed
def mechanical_advantage(motion: SlideMotion, height: float, downwards: bool = True) -> float:
    """Force on the slide for each N m on the crank at a height above bottom dead centre, without losses and inertia [1/m].

    By virtual work it is crank speed divided by slide speed, 1 / |ds/dtheta|. It grows without bounds towards the dead centres.

    Args:
        motion: one period at constant speed.
        height: above bottom dead centre [m].
        downwards: whether the working stroke goes against the slide's direction.

    Raises:
        PinpressError: a height that is not between 0 and the stroke; a motion that `stroke` refuses, or a slide that turns back more than
            twice in the period.
    """
    path, speed = _speed_by_state(motion, height, downwards)
    return path.number(abs(step_angle(motion)) / speed)


def dwell_angle(motion: SlideMotion, tolerance: float) -> float:
    """Angle by which the crank turns while the slide stays near bottom dead centre without a break [rad].

    Args:
        motion: one period at constant speed.
        tolerance: height above bottom dead centre up to which the slide counts as near it [m].

    Raises:
        PinpressError: a tolerance that is not between 0 and the stroke; a motion that `stroke` refuses, or a slide that turns back more
            than twice in the period.
    """
    path, states = _dwell(motion, tolerance)
    return path.number(states * abs(step_angle(motion)))


def dwell_time(motion: SlideMotion, tolerance: float) -> float:
    """Time for which the slide stays near bottom dead centre without a break [s]. Arguments and errors as of `dwell_angle`."""
    path, states = _dwell(motion, tolerance)
    return path.number(states * step_time(motion))


def pressure_angle(motion: CrankMotion, driven: Numbers, other: Numbers, axis: ArrayLike) -> float:
    """Largest angle between a link, taken as the line through two of its pins, and the guide of what it drives, 0 to pi/2 [rad].

    It is the angle between force and velocity if the link carries no load between its pins:
    sin(angle) = |axis x (driven - other)| / length.
    pi/2 means that the link is perpendicular to the guide at some crank angle. Chen 2002 asks for at most 40 degrees.

    Args:
        motion: one period at constant speed.
        driven: (n, 3) positions of the pin on what the link drives [m], see `bearing_positions`.
        other: (n, 3) positions of the link's other pin [m].
        axis: (3,) direction of the guide, of any length.

    Raises:
        PinpressError: not one period at constant speed; arrays of other shapes or not finite; pins in one place; too few states.
    """
    link = _vector_between(motion, "driven", driven, "other", other)
    way = suitable_numbers("axis", axis, "a direction (3,)", (3,), np.any)
    way = way / np.abs(way).max()  # so that no square overflows, or is lost
    way = way / np.linalg.norm(way)
    along, across = link @ way, np.cross(link, way)
    squared_sine = _trigonometric_curve("the pressure angle", _dot(across, across) / _dot(link, link), driven, other)
    largest = squared_sine.extremes()[1]
    turned_away = along.real.min() <= 0.0 <= along.real.max()
    return squared_sine.number(0.5 * np.pi if turned_away or largest.real >= 1.0 else np.arcsin(np.sqrt(largest)))


def transmission_angle(motion: CrankMotion, pin: Numbers, one: Numbers, another: Numbers) -> float:
    """Smallest acute angle between the lines of two links at the pin that joins them, 0 to pi/2 [rad].

    |cos(angle)| = |(one - pin) . (another - pin)| / lengths. 0 means that the links come into line at some crank angle.

    Args:
        motion: one period at constant speed.
        pin: (n, 3) positions of the pin that joins the links [m], see `bearing_positions`.
        one: (n, 3) positions of the first link's other pin [m].
        another: (n, 3) positions of the second link's other pin [m].

    Raises:
        PinpressError: not one period at constant speed; arrays of other shapes or not finite; pins in one place; too few states.
    """
    first, second = _vector_between(motion, "one", one, "pin", pin), _vector_between(motion, "another", another, "pin", pin)
    cosine = _trigonometric_curve(
        "the transmission angle", _dot(first, second) / np.sqrt(_dot(first, first) * _dot(second, second)), pin, one, another
    )
    least, most = cosine.extremes()
    sharpest = most if most.real > -least.real else -least
    across = np.cross(first, second).real
    in_line = np.any(np.sum(across * np.roll(across, -1, axis=0), axis=1) <= 0)  # they pass each other from one state to the next
    return cosine.number(0.0 if in_line or sharpest.real >= 1.0 else np.arccos(sharpest))


@typed
def bearing_positions(press: Linkage, motion: Motion) -> Mapping[str, Array]:
    """World positions (n, 3) of all bearings by their names, where their forces act [m]: the origin of the child's joint frame, or a loop's
    point.

    Raises:
        PinpressError: a motion of a linkage with other joints or lengths.
    """
    refuse_motion_of_another(press, motion)
    return NamedArrays(press.bearings, bearing_points(press, poses(press, motion.joint_position)))


def _speed_by_state(motion: SlideMotion, height: float, downwards: bool) -> tuple[Curve, complex]:
    """The slide's path, and its speed at a height [m for each step from state to state]."""
    way = working_stroke(motion, downwards)
    above = inside_stroke(way.length, "height", height)
    place = way.place_at(np.array([way.length - above if downwards else above + 0j]))
    return way.path, complex(way.speed(place)[0])


def _dwell(motion: SlideMotion, tolerance: float) -> tuple[Curve, complex]:
    """The slide's path, and for how many steps from state to state it stays within the tolerance of bottom dead centre."""
    path = slide_path(motion)
    least, most = path.extremes()
    level = least + inside_stroke(most - least, "tolerance", tolerance)
    turning = path.turning_places.real
    bottom = float(turning[path.at(turning, 1)[0].real.argmin()])
    crossings = path.crossings(level)
    if not len(crossings):
        raise PinpressError(f"tolerance is {tolerance:g}, the whole stroke but for rounding: give less")
    ahead = crossings - bottom
    ahead += np.where(ahead.real < 0, path.states, 0)
    return path, complex(ahead[ahead.real.argmin()] - ahead[ahead.real.argmax()]) + path.states


# --------------------------------------------------------------------------------------------------------------------- angles between links


def _vector_between(motion: CrankMotion, name: str, to: Numbers, beginning_name: str, beginning: Numbers) -> ComplexArray:
    """Checked vectors (n, 3) from one pin (``beginning``) to another (``to``), whose names are for messages."""
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
    """Scalar products (n,) of vectors (n, 3), without conjugation, which would not be analytic."""
    return np.asarray((one * another).sum(axis=1))


def _trigonometric_curve(what: str, values: ComplexArray, *given: Numbers) -> Curve:
    """A quantity (n,) of size about one over the period as a curve, by way of its trigonometric polynomial at more places.

    Args:
        what: the quantity, for messages.
        values: (n,) at the states.
        given: positions that it was worked out from; the measure is real where all of them are.

    Raises:
        PinpressError: too few states.
    """
    n = len(values)
    orders = np.arange(n // 2 + 1)
    harmonics = np.fft.rfft(values.real), np.fft.rfft(values.imag)  # apart: one transform would round the one into the other
    # States resolve a curve if the last quarter of its harmonics has amplitudes below the digits that measures promise.
    if np.abs(harmonics[0][-max(2, len(orders) // 4) :]).max() > 1e-9 * n:
        raise PinpressError(f"{n} states do not resolve {what} over the period, or the linkage is elsewhere after it: give more points")

    def derivative(order: int) -> ComplexArray:
        finer = FINER * n
        real, imaginary = (FINER * np.fft.irfft((2j * np.pi / finer * orders) ** order * harmonic, finer) for harmonic in harmonics)
        return np.asarray(real + 1j * imaginary)

    return curve(what, derivative(0), derivative(1), derivative(2), not any(map(np.iscomplexobj, given)))
