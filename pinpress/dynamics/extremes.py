"""Smallest, largest and rms values of motion, torques and forces, with the crank angles where they are reached; and what counts as
rounding, so that no peak is reported for a bearing that carries nothing.

Signs and axes are those of `inverse_dynamics`. All functions raise `PinpressError` for values that are not finite.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from ..common.arguments import expect, typed
from ..common.errors import PinpressError
from ..common.quantities import RPM, Array
from ..common.results import Record, Records
from ..kinematics.motion import ROUNDING, Motion, finite, is_constant
from ..kinematics.poses import poses
from .peaks import PeakStates, peak_states
from .reactions import Reactions, carrying

ROUNDING_OF_VALUES = 1e-12  # share of a quantity's largest value below which a value is rounding
AXES = ("x", "y", "z")


@runtime_checkable
class DrivenMotion(Protocol):
    """A motion that results from a drive, as a `Run`."""

    @property
    def drive_torque(self) -> Array: ...


@dataclass(frozen=True, repr=False)
class ExtremeValues(Record, units={"smallest_at": "deg", "largest_at": "deg"}):
    """Extremes of one quantity over a motion, in its unit.

    Attributes:
        quantity: its name, for example "shaking force, x".
        unit: its unit.
        smallest: smallest value.
        smallest_at: crank angle of the smallest value, see `Motion.shown_position` [deg; of a driver that slides mm; of
            several drivers its time, s].
        largest: largest value.
        largest_at: crank angle of the largest value [deg or mm].
        range: largest value less the smallest.
        rms: root mean square over the period of a `cycle`, else over the states; it is that over time where these are equally spaced in
            time, as in a run.
    """

    quantity: str
    unit: str
    smallest: float
    smallest_at: float
    largest: float
    largest_at: float
    range: float
    rms: float


@dataclass(frozen=True, repr=False)
class ExtremesOverTravel(ExtremeValues, units={"smallest_at": "mm", "largest_at": "mm"}):
    """Extremes of one quantity over a motion of a driver that slides; attributes as of `ExtremeValues`, places in mm."""


@dataclass(frozen=True, repr=False)
class ExtremesOverTime(ExtremeValues, units={"smallest_at": "s", "largest_at": "s"}):
    """Extremes of one quantity over a motion of several drivers; attributes as of `ExtremeValues`, times in s."""


@typed
def extremes(reactions: Reactions) -> Records[ExtremeValues]:
    """Extremes of slide motion, torques, bearing forces and moments, shaking force and shaking moment, and of a crank speed that varies.

    They do not depend on where the motion's states are. Where a load begins or ends with a step, they are the limits at both sides of the
    step; smooth peaks are found between the states. Where nothing is known between the states, as under forces that are given state by
    state, they are those of the states.

    Vectors are listed by their magnitude and their components along the world axes, without components that are zero to rounding. Bearing
    moments are those that `held_moments` returns. Slide positions are in mm and crank speeds in r/min, all else is in SI units.

    Args:
        reactions: reactions of all bearings.

    Raises:
        PinpressError: A value is not finite, or bearings were left out.
    """
    rounding(reactions)  # which refuses forces that are not finite
    found = at_peaks(reactions)
    reactions, motion = found.reactions, found.reactions.motion
    kind, places = ExtremeValues if motion.driver_coordinates[0].turns else ExtremesOverTravel, finite("crank angle", motion.shown_position)
    if len(motion.drivers) > 1 and motion._time is not None:  # no one of them tells the states apart
        kind, places = ExtremesOverTime, motion.time
    series = _series(reactions)
    return Records(
        kind, (_extreme_values(kind, quantity, unit, finite(quantity, values), places, found.weight) for quantity, unit, values in series)
    )


def at_peaks(reactions: Reactions) -> PeakStates:
    """The states of reactions of all bearings, and those at which quantities that `extremes` and summaries list jump or are largest. They
    are found once for all readers.

    Raises:
        PinpressError: as `extremes`.
    """
    derived = vars(reactions)  # as a cached property would keep them, which Reactions cannot have: `peaks` stands on it
    if "_peaks" not in derived:
        derived["_peaks"] = peak_states(reactions, _listed)
    peaks: PeakStates = derived["_peaks"]
    return peaks


def _listed(reactions: Reactions) -> Iterator[Array]:
    """All quantities (n,) of which extremes are listed; always as many."""
    motion = reactions.motion
    if motion._guide is not None:
        yield from (motion.slide_position, motion.slide_velocity, motion.slide_acceleration, reactions.process_force)
    count = len(motion.crank_angle)
    torque, speed = (values.reshape(count, -1).T for values in (reactions.driving_torque, motion.crank_speed))
    yield from (*speed, *torque, *(torque * speed))
    if isinstance(motion, DrivenMotion):
        yield from motion.drive_torque.reshape(count, -1).T
    yield from (pair[:, 0] for pair in reactions.coupling_torque.values())
    moments = (*reactions.bearing_moment.values(), *held_moments(reactions).values())
    for vector in (*reactions.bearing_force.values(), *moments, reactions.shaking_force, reactions.shaking_moment):
        yield from (*vector.T, np.linalg.norm(vector, axis=1))


def _series(reactions: Reactions) -> Iterator[tuple[str, str, Array]]:
    motion = reactions.motion
    least = rounding(reactions)
    if motion._guide is not None:
        yield "slide position", "mm", 1e3 * motion.slide_position
        yield "slide velocity", "m/s", motion.slide_velocity
        yield "slide acceleration", "m/s²", motion.slide_acceleration
    if not is_constant(finite("crank speed", motion.crank_speed)):
        speeds = [("crank speed", "r/min", RPM) if each.turns else ("driver speed", "mm/s", 1e-3) for each in motion.driver_coordinates]
        yield from _by_driver(speeds, motion.crank_speed, motion)
    efforts = [(each.effort, each.effort_unit) for each in motion.driver_coordinates]
    yield from _by_driver([(f"driving {effort}", unit, 1.0) for effort, unit in efforts], torque_without_rounding(reactions), motion)
    if isinstance(motion, DrivenMotion):
        yield from _by_driver([(f"drive {effort}", unit, 1.0) for effort, unit in efforts], motion.drive_torque, motion)
    for name, force in finite_forces(reactions).items():
        yield from _vector(f"force in {name}", "N", force, least.force)
    for name, moment in held_moments(reactions).items():
        if np.abs(moment).max() > least.moment:
            yield from _vector(f"moment in {name}", "N m", moment, least.moment)
    yield from _vector("shaking force", "N", reactions.shaking_force, least.force)
    yield from _vector("shaking moment", "N m", reactions.shaking_moment, least.moment)


def _by_driver(heads: Sequence[tuple[str, str, float]], values: Array, motion: Motion) -> Iterator[tuple[str, str, Array]]:
    """Name, unit and values (n,) of a quantity of the driver, or of each of several drivers; ``heads``: name, unit and its size
    in SI units, by driver."""
    if values.ndim == 1:
        quantity, unit, size = heads[0]
        yield quantity, unit, values / size
    else:
        for i, (driver, (quantity, unit, size)) in enumerate(zip(motion.drivers, heads, strict=True)):
            yield f"{quantity} of {driver}", unit, values[:, i] / size


def _vector(name: str, unit: str, vector: Array, least: float) -> Iterator[tuple[str, str, Array]]:
    finite(name, vector)
    shown = [i for i in range(3) if np.abs(vector[:, i]).max() > least]
    yield f"{name}, magnitude", unit, np.linalg.norm(vector[:, shown], axis=1)
    for i in shown:
        yield f"{name}, {AXES[i]}", unit, vector[:, i]


def _extreme_values(kind: type[ExtremeValues], quantity: str, unit: str, values: Array, angle: Array, weight: Array) -> ExtremeValues:
    low, high = int(values.argmin()), int(values.argmax())
    smallest, largest = float(values[low]), float(values[high])
    size = float(np.abs(values).max()) or 1.0  # divided by before squaring: squares of large numbers overflow
    smallest, largest = (0.0 if abs(value) < ROUNDING_OF_VALUES * size else value for value in (smallest, largest))
    width = largest - smallest if largest - smallest > ROUNDING_OF_VALUES * size else 0.0
    rms = size * float(np.sqrt(weight @ (values / size) ** 2))
    return kind(quantity, unit, smallest, float(angle[low]), largest, float(angle[high]), width, rms)


# ------------------------------------------------------------------------------------------------------------------------- what is rounding


class Rounding(NamedTuple):
    """Magnitudes below which a component is rounding.

    Attributes:
        force: limit for forces [N].
        moment: limit for moments and torques [N m].
    """

    force: float
    moment: float


def rounding(reactions: Reactions) -> Rounding:
    """Limits of rounding: shares of the largest bearing force, and of the larger of driving torque and that force times the linkage's size.

    Raises:
        PinpressError: bearings were left out of the reactions, or a force is not finite.
    """
    expect("reactions", reactions, Reactions, "inverse_dynamics")
    if reactions.left_out or not math.isfinite(reactions._largest_force) or not len(reactions.driving_torque):
        finite_forces(reactions)  # refuses them by name
    largest = reactions._largest_force
    torque = float(np.abs(finite("driving torque", reactions.driving_torque)).max(initial=0.0))
    return Rounding(ROUNDING * largest, ROUNDING * max(torque, largest * reactions._press.size))


def finite_forces(reactions: Reactions) -> dict[str, Array]:
    """Forces (n, 3) [N] in bearings, in the order of the drawing, and in contacts, by their names.

    Raises:
        PinpressError: bearings were left out (the largest force decides what is rounding), or a force is not finite.
    """
    if reactions.left_out:
        raise PinpressError(
            f"charts need all bearings, and {', '.join(reactions.left_out)} were left out: make the reactions without bearings=..."
        )
    forces = reactions.bearing_force
    return {name: finite(f"force in {name}", forces[name]) for name in carrying(reactions._press, as_drawn=True)}


def torque_without_rounding(reactions: Reactions) -> Array:
    """Driving torque (n,) or (n, drivers) [N m]; that of a driver is zero if it is rounding in all states."""
    torque = finite("driving torque", reactions.driving_torque)
    return np.where(np.abs(torque).max(axis=0) > rounding(reactions).force * reactions._press.size, torque, 0.0)


def held_moments(reactions: Reactions) -> dict[str, Array]:
    """Moments (n, 3) by which bearings keep their links from tilting, by the bearings' names in the order of the drawing, world axes [N m].

    The component about the axis of a joint that turns is left out: it is the torque of drive, gear pair and friction. For a spherical loop
    the moment is zero.
    """
    press, moments = reactions._press, {}
    rotation = poses(press, reactions.motion.joint_position).rotation
    joints = enumerate(zip(press.joints, press.axes, strict=True), 1)
    turning = {name: (body, axis.direction) for body, (name, axis) in joints if axis.turns}
    turning |= {loop.name: (loop.joint1, loop.rotation1[:, 0]) for loop in press.loops if loop.type == "revolute"}
    spherical = {loop.name for loop in press.loops if loop.type == "spherical"}
    for name in filter(reactions.bearing_moment.__contains__, press.bearings_as_drawn):
        held = finite(f"moment in {name}", reactions.bearing_moment[name])
        if name in turning:
            body, direction = turning[name]
            axis = rotation[body] @ direction
            held = held - np.sum(held * axis, axis=1, keepdims=True) * axis
        moments[name] = np.zeros_like(held) if name in spherical else held
    return moments
