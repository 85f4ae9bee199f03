"""Angles between the links of a linkage over a period: pressure angle and transmission angle.

Of a planar linkage the pins' positions belong in one plane across the pins' axes.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import typed
from ..common.arrays import Array, ComplexArray
from ..common.checks import numbers
from ..common.errors import PinpressError, shown
from ..common.frozen import NamedArrays
from ..linkage.linkage import Linkage
from .motion import Motion
from .periodic_curve import CrankMotion, Curve, Numbers, curve, step_angle
from .poses import bearing_points, poses

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
    way = numbers("axis", axis)
    if way.shape != (3,) or not way.any():
        raise PinpressError(f"axis is {shown(axis)}: give a direction (3,)")
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
