"""The smallest and largest values of motion, torques and forces, where they are, and how large these are on average."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from ..common.arguments import typed
from ..common.arrays import Array
from ..common.results import Record, Records
from ..common.units import RPM
from ..kinematics.motion import Motion
from .inverse_dynamics import Reactions
from .rounding import AXES, finite, held_moments, is_constant, rounding, torque_without_rounding

NOTHING = 1e-12  # of the largest value: less is rounding


@runtime_checkable
class DrivenMotion(Protocol):
    """A motion that a drive made, as a `Run` is."""

    @property
    def drive_torque(self) -> Array: ...


@dataclass(frozen=True, repr=False)
class ExtremeValues(Record, units={"smallest_at": "deg", "largest_at": "deg"}):
    """Extremes of one quantity over a motion's states, in its unit.

    Attributes:
        quantity: Its name, for example "shaking force, x".
        unit: Its unit.
        smallest: Smallest value.
        smallest_at: Crank angle of the smallest value [deg], as of `Motion.crank_degrees`.
        largest: Largest value.
        largest_at: Crank angle of the largest value [deg].
        range: Largest value less the smallest.
        rms: Root of the mean square over the states, which is that over time where the states are equally spaced in time, as in a `cycle`
            or a run.
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
def extremes(reactions: Reactions) -> Records[ExtremeValues]:
    """Find the extremes of slide, torques, bearing forces and moments, shaking force and shaking moment, and of a crank speed that varies.

    Of vectors these are the components along the world's axes and the magnitude; components that are zero throughout, but for rounding,
    are left out. Of bearings' moments only those count that hold links against turning. Slide positions are in mm and crank speeds in
    r/min, all else is in SI units.

    Args:
        reactions: Reactions of all bearings.

    Raises:
        PinpressError: A value is not finite, or bearings were left out.
    """
    motion = reactions.motion
    angle = finite("crank angle", motion.crank_degrees)
    series = _series(reactions)
    return Records(ExtremeValues, (_extreme_values(quantity, unit, finite(quantity, values), angle) for quantity, unit, values in series))


def _series(reactions: Reactions) -> Iterator[tuple[str, str, Array]]:
    motion = reactions.motion
    least = rounding(reactions)
    if motion._guide is not None:
        yield "slide position", "mm", 1e3 * motion.slide_position
        yield "slide velocity", "m/s", motion.slide_velocity
        yield "slide acceleration", "m/s²", motion.slide_acceleration
    if not is_constant(finite("crank speed", motion.crank_speed)):
        yield from _by_driver("crank speed", "r/min", motion.crank_speed / RPM, motion)
    yield from _by_driver("driving torque", "N m", torque_without_rounding(reactions), motion)
    if isinstance(motion, DrivenMotion):
        yield from _by_driver("drive torque", "N m", motion.drive_torque, motion)
    for name, force in reactions.bearing_force.items():
        yield from _vector(f"force in {name}", "N", force, least.force)
    for name, moment in held_moments(reactions).items():
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
    finite(name, vector)
    shown = [i for i in range(3) if np.abs(vector[:, i]).max() > least]
    yield f"{name}, magnitude", unit, np.linalg.norm(vector[:, shown], axis=1)
    for i in shown:
        yield f"{name}, {AXES[i]}", unit, vector[:, i]


def _extreme_values(quantity: str, unit: str, values: Array, angle: Array) -> ExtremeValues:
    low, high = int(values.argmin()), int(values.argmax())
    smallest, largest = float(values[low]), float(values[high])
    size = float(np.abs(values).max()) or 1.0  # divided by before squaring: squares of large numbers overflow
    smallest, largest = (0.0 if abs(value) < NOTHING * size else value for value in (smallest, largest))
    width = largest - smallest if largest - smallest > NOTHING * size else 0.0
    rms = size * float(np.sqrt(np.mean((values / size) ** 2)))
    return ExtremeValues(quantity, unit, smallest, float(angle[low]), largest, float(angle[high]), width, rms)
