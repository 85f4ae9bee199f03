"""The smallest and largest values of all that is charted, where they are, and how large it is on average."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..common.arguments import typed
from ..common.arrays import Array
from ..common.results import Record, Records
from ..common.units import RPM
from ..dynamics.inverse_dynamics import Reactions
from ..kinematics.motion import Motion
from ..simulation.run import Run
from . import charts

NOTHING = 1e-12  # of the largest value: less is rounding


@dataclass(frozen=True, repr=False)
class Extreme(Record, units={"smallest_at": "deg", "largest_at": "deg"}):
    """Extremes of one quantity over a motion's states, in its unit.

    Attributes:
        smallest_at, largest_at: crank angle [deg], as `Motion.crank_degrees`.
        range: largest less smallest.
        rms: root of the mean square over the states, which is that over time where these are equally spaced in it, as in a `cycle` or run.
    """

    quantity: str
    unit: str
    smallest: float
    smallest_at: float
    largest: float
    largest_at: float
    range: float
    rms: float


@typed
def extremes(reactions: Reactions) -> Records[Extreme]:
    """Extremes of slide, crank speed where it is not constant, torques, bearing forces, the moments that bearings hold
    (`charts.held_moments`), shaking force and shaking moment: components along the world's axes and magnitudes.

    Slide position in mm, crank speed in r/min, all else in SI units. Components that are zero throughout, but for rounding, are left out.

    Raises:
        PinpressError: a value that is not finite.
    """
    motion = charts.driven(reactions)
    angle = charts.finite("crank angle", motion.crank_degrees)
    return Records(
        Extreme, (_extreme(quantity, unit, charts.finite(quantity, values), angle) for quantity, unit, values in _series(reactions))
    )


def _series(reactions: Reactions) -> Iterator[tuple[str, str, Array]]:
    motion = reactions.motion
    least = charts.rounding(reactions)
    if motion._guide is not None:
        yield "slide position", "mm", 1e3 * motion.slide_position
        yield "slide velocity", "m/s", motion.slide_velocity
        yield "slide acceleration", "m/s²", motion.slide_acceleration
    if charts.crank_speed(motion):
        yield from _by_driver("crank speed", "r/min", motion.crank_speed / RPM, motion)
    yield from _by_driver("driving torque", "N m", charts.clean_torque(reactions), motion)
    if isinstance(motion, Run):
        yield from _by_driver("drive torque", "N m", motion.drive_torque, motion)
    for name, force in reactions.bearing_force.items():
        yield from _vector(f"force in {name}", "N", force, least.force)
    for name, moment in charts.held_moments(reactions).items():
        if np.abs(moment).max() > least.moment:
            yield from _vector(f"moment in {name}", "N m", moment, least.moment)
    yield from _vector("shaking force", "N", reactions.shaking_force, least.force)
    yield from _vector("shaking moment", "N m", reactions.shaking_moment, least.moment)


def _by_driver(quantity: str, unit: str, values: Array, motion: Motion) -> Iterator[tuple[str, str, Array]]:
    """A quantity (n,); of several drivers (n, drivers), one each."""
    if values.ndim == 1:
        yield quantity, unit, values
    else:
        yield from ((f"{quantity} of {driver}", unit, values[:, i]) for i, driver in enumerate(motion.drivers))


def _vector(name: str, unit: str, vector: Array, least: float) -> Iterator[tuple[str, str, Array]]:
    charts.finite(name, vector)
    shown = [i for i in range(3) if np.abs(vector[:, i]).max() > least]
    yield f"{name}, magnitude", unit, np.linalg.norm(vector[:, shown], axis=1)
    for i in shown:
        yield f"{name}, {charts.AXES[i]}", unit, vector[:, i]


def _extreme(quantity: str, unit: str, values: Array, angle: Array) -> Extreme:
    low, high = int(values.argmin()), int(values.argmax())
    smallest, largest = float(values[low]), float(values[high])
    size = float(np.abs(values).max()) or 1.0  # divided by before squaring: squares of large numbers overflow
    smallest, largest = (0.0 if abs(value) < NOTHING * size else value for value in (smallest, largest))
    width = largest - smallest
    rms = size * float(np.sqrt(np.mean((values / size) ** 2)))
    return Extreme(quantity, unit, smallest, float(angle[low]), largest, float(angle[high]), width if width > NOTHING * size else 0.0, rms)
