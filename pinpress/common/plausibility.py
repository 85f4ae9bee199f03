"""Warnings of arguments that are allowed but hardly meant: speeds and heights in another unit, columns of a servo motion that do not
fit."""

import math
from collections.abc import Sequence

import numpy as np

from .errors import caution
from .quantities import RPM, Array

FASTEST = 1000.0  # no crank or motor of a press turns faster [rad/s], 9549 r/min
AMISS = 0.05  # share of a motion up to which its columns may disagree
FAR = 10.0  # no part of a press is further away [lengths of the linkage]
MILLI = 1e-3


def speeds(name: str, values: Array | float) -> None:
    """Warn of speeds [rad/s], of any shape, that no press runs at: they may be in r/min."""
    fastest = float(np.abs(values).max(initial=0.0))
    if fastest > FASTEST:
        caution(f"{name} is {fastest:g} rad/s, {fastest / RPM:g} r/min: if r/min are meant, write {fastest:g} * pinpress.RPM")


def heights(load: str, stretches: Sequence[tuple[float, float]], low: float, high: float, size: float) -> None:
    """Warn of a process load that acts nowhere on the slide's stroke, or ends far off the linkage: its heights may be in mm.

    Args:
        load: its name.
        stretches: lower and upper ends [m], both ways.
        low, high: ends of the stroke, as heights above the load's datum [m]; infinite where they are not known.
        size: length of the linkage [m].
    """
    if not stretches:
        return
    lowest, highest = min(lower for lower, _ in stretches), max(upper for _, upper in stretches)
    said = f"{load} acts from {lowest:g} to {highest:g} m above its datum"
    remedy = "give heights and datum in m"
    stroke = high - low
    # that a die or stop lies a little too low for the slide to meet it may be meant
    if math.isfinite(stroke) and all(lower >= high or upper < low - stroke for lower, upper in stretches):
        caution(f"{said}, nowhere on the slide's stroke, which goes from {low:g} to {high:g} m: {remedy}")
    elif math.isfinite(highest - lowest) and max(abs(lowest), abs(highest)) > FAR * size:  # without ends it acts everywhere, as is meant
        caution(f"{said}, far off a linkage of {size:g} m: {remedy}")


def point(name: str, position: Array, size: float) -> None:
    """Warn of a point (3,) in a link's frame that is far off a linkage of that ``size`` [m], and in mm would be on it, or near."""
    distance = float(np.abs(position).max())
    if FAR * size < distance <= FAR * size / MILLI:
        caution(f"{name} is {distance:g} m from its link's origin, far off a linkage of {size:g} m: give x, y, z in m")


def servo_motion(angle: Array, speed: Array, acceleration: Array | None, time: Array | None) -> None:
    """Warn of a servo motion whose columns (n,) or (n, drivers) do not fit together; acceleration None: it is not given, time None: the
    states are in no time of the caller's."""
    if acceleration is None and np.any(speed != speed[0]):
        caution(
            "the speed varies, but no acceleration is given, so that it counts as 0: give acceleration=..., [rad/s2], e.g."
            " numpy.gradient(speed, time), or acceleration=0.0 where none is meant"
        )
    if time is None:
        return
    steps = np.diff(time).reshape(-1, *([1] * (angle.ndim - 1)))
    rate = np.zeros_like(speed) if acceleration is None else acceleration
    if (missed := _missed(angle, speed, rate, steps)) > AMISS:
        caution(
            f"angle and speed do not fit together over time, by {100 * missed:.0f} % of the way: give speed [rad/s] as the angle's"
            " derivative by time [s], e.g. numpy.gradient(angle, time)"
        )
    elif acceleration is not None and (missed := _missed(speed, acceleration, None, steps)) > AMISS:
        caution(
            f"speed and acceleration do not fit together over time, by {100 * missed:.0f} % of the change of speed: give acceleration"
            " [rad/s2] as the speed's derivative by time [s], e.g. numpy.gradient(speed, time)"
        )


def _missed(value: Array, rate: Array, bend: Array | None, steps: Array) -> float:
    """By what part of its changes a column differs from the integral of its rate, beyond what the trapezoidal rule may miss: half the
    change of rate within a step, and what its derivative ``bend`` at both ends may add."""
    gained, summed = np.diff(value, axis=0), 0.5 * steps * (rate[1:] + rate[:-1])
    allowed = 0.5 * steps * np.abs(np.diff(rate, axis=0))
    if bend is not None:
        allowed = allowed + 0.25 * steps**2 * (np.abs(bend[1:]) + np.abs(bend[:-1]))
    way = float(np.maximum(np.abs(gained), np.abs(summed)).sum())
    return float(np.maximum(np.abs(gained - summed) - allowed, 0.0).sum()) / way if way else 0.0
