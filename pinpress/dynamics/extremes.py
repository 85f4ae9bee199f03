"""Smallest, largest and rms values of motion, torques and forces, with the crank angles where they are reached; and what counts as
rounding, so that no peak is reported for a bearing that carries nothing.

Signs and axes are those of `inverse_dynamics`. All functions raise `PinpressError` for values that are not finite.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeVar, runtime_checkable

import numpy as np

from ..common.arguments import expect, typed
from ..common.errors import PinpressError
from ..common.numerics import bracketed_roots, gauss_rule
from ..common.quantities import RPM, Array
from ..common.results import Record, Records
from ..kinematics.motion import ROUNDING, Motion, finite, is_constant, is_cycle
from ..kinematics.poses import poses
from .between import SIDE, AlongMotion, Resolved
from .inverse_dynamics import in_other_states
from .reactions import Reactions, carrying

ROUNDING_OF_VALUES = 1e-12  # share of a quantity's largest value below which a value is rounding
FEWER_DIGITS = 1e-3  # share of the largest force or moment below which others need fewer digits: a thousand times what panels may miss
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
        rms: root mean square over time; over the states if nothing is known between them.
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

    Neither they nor the rms values depend on where the motion's states are. Where a load begins or ends with a step, extremes are the
    limits at both sides of the step; smooth peaks are found between the states. If nothing is known between the states, as under forces
    that are given state by state, all numbers are those of the given states.

    Vectors are listed by their magnitude and their components along the world axes, without components that are zero to rounding. Bearing
    moments are those that `held_moments` returns. Slide positions are in mm and crank speeds in r/min, all else is in SI units.

    Args:
        reactions: reactions of all bearings.

    Raises:
        PinpressError: A value is not finite, or bearings were left out.
    """
    rounding(reactions)  # which refuses forces that are not finite
    found, mean = at_peaks(reactions), over_time(reactions)
    motion = found.reactions.motion
    kind, places = ExtremeValues if motion.driver_coordinates[0].turns else ExtremesOverTravel, finite("crank angle", motion.shown_position)
    if len(motion.drivers) > 1 and motion._time is not None:  # no one of them tells the states apart
        kind, places = ExtremesOverTime, motion.time
    # a quantity that is rounding at all nodes of the integral is not among them
    rms = {quantity: rms_of(finite(quantity, values), mean.share) for quantity, _, values in _series(mean.reactions)}
    series = [(quantity, unit, finite(quantity, values)) for quantity, unit, values in _series(found.reactions)]
    return Records(kind, (_extreme_values(kind, name, unit, values, places, rms.get(name, 0.0)) for name, unit, values in series))


def at_peaks(reactions: Reactions) -> PeakStates:
    """The states of reactions, and those at which quantities that `extremes` and summaries list jump or are largest; the given states if
    nothing is known between them. They are found once for all readers.

    Raises:
        PinpressError: forces between the states are not finite.
    """
    return _kept(reactions, "_peaks", lambda: _between(reactions).peak_states())


def over_time(reactions: Reactions) -> MeanStates:
    """States for integrals over time of the quantities that `extremes` lists: by Gauss's rule, or the given states by trapezoids if nothing
    is known between them. They are found once for all readers; raises as `at_peaks`."""
    return _kept(reactions, "_over_time", lambda: _between(reactions).mean_states())


def _between(reactions: Reactions) -> ResolvedStates | GivenStates:
    return _kept(reactions, "_between", lambda: between_states(reactions, _listed))


T = TypeVar("T")


def _kept(reactions: Reactions, name: str, find: Callable[[], T]) -> T:
    """What was found of reactions, kept as a cached property would, which Reactions cannot have: these states are Reactions too."""
    derived = vars(reactions)
    if name not in derived:
        derived[name] = find()
    kept: T = derived[name]
    return kept


def _listed(reactions: Reactions) -> Iterator[tuple[Array, float]]:
    """All quantities of which extremes are listed, in groups (n, k) with the size below which they need fewer digits; vectors with their
    squares, because a magnitude is not smooth near zero."""
    motion, size = reactions.motion, reactions._press.size
    count = len(motion.crank_angle)
    torque, speed = (values.reshape(count, -1) for values in (reactions.driving_torque, motion.crank_speed))
    forces = [*reactions.bearing_force.values(), reactions.shaking_force]
    moments = [*reactions.bearing_moment.values(), *held_moments(reactions).values(), reactions.shaking_moment]
    losses = np.column_stack([np.zeros(count), *reactions.friction_power.values()])
    force = FEWER_DIGITS * max(float(np.abs(vector).max(initial=0.0)) for vector in forces)
    moment = max(force * size, FEWER_DIGITS * float(np.abs(torque).max(initial=0.0)))
    if motion._guide is not None:
        slide = (motion.slide_position, motion.slide_velocity, motion.slide_acceleration, reactions.process_force)
        yield from ((values[:, None], 0.0) for values in slide)
        yield (reactions.process_force * motion.slide_velocity)[:, None], 0.0
    yield speed, 0.0
    yield torque, moment
    power = moment * float(np.abs(speed).max(initial=0.0))
    yield torque * speed, power
    yield losses, max(power, FEWER_DIGITS * float(losses.max(initial=0.0)))
    if isinstance(motion, DrivenMotion):
        yield motion.drive_torque.reshape(count, -1), 0.0
    yield from ((pair[:, :1], moment) for pair in reactions.coupling_torque.values())
    for vectors, least in ((forces, force), (moments, moment)):
        for vector in vectors:
            yield vector, least
            yield np.square(vector).sum(axis=1, keepdims=True), least**2


def rms_of(values: Array, share: Array) -> float:
    """Root mean square of values (n,) that count by their shares, of any size: squares of large numbers would overflow."""
    size = float(np.abs(values).max(initial=0.0)) or 1.0
    return size * float(np.sqrt(share @ (values / size) ** 2))


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


def _extreme_values(kind: type[ExtremeValues], quantity: str, unit: str, values: Array, angle: Array, rms: float) -> ExtremeValues:
    low, high = int(values.argmin()), int(values.argmax())
    smallest, largest = float(values[low]), float(values[high])
    size = float(np.abs(values).max()) or 1.0
    smallest, largest = (0.0 if abs(value) < ROUNDING_OF_VALUES * size else value for value in (smallest, largest))
    width = largest - smallest if largest - smallest > ROUNDING_OF_VALUES * size else 0.0
    return kind(quantity, unit, smallest, float(angle[low]), largest, float(angle[high]), width, rms)


# ----------------------------------------------------------------------------------------------------------- between and in the states


Quantities = Callable[[Reactions], Iterable[tuple[Array, float]]]
"""Quantities in n states, as groups (n, k) with the size below which the quantities of a group need fewer digits."""


class PeakStates(NamedTuple):
    """The reactions in a motion's states, and in those states between them in which quantities jump or are largest.

    Attributes:
        reactions: in all these states, in the order of time.
        remarks: for each state a remark such as "where the load begins"; mostly empty.
    """

    reactions: Reactions
    remarks: tuple[str, ...]


class MeanStates(NamedTuple):
    """States whose sum is an integral over the time of a motion.

    Attributes:
        reactions: in these states, those of a panel one after the other; the given reactions if nothing is known between their states.
        weight: (n,) time for which each state counts [s]; the mean step where states have no times.
        borders: (p + 1,) of the panels [s]; of given states none.
    """

    reactions: Reactions
    weight: Array
    borders: Array

    @property
    def share(self) -> Array:
        """(n,) of the time for which each state counts."""
        return np.asarray(self.weight / self.weight.sum())


@dataclass(frozen=True, eq=False)
class ResolvedStates:
    """Reactions over a motion that is known between its states, with quantities that are resolved.

    Attributes:
        reactions: to the motion.
        resolved: the quantities over time.
    """

    reactions: Reactions
    resolved: Resolved

    def peak_states(self) -> PeakStates:
        """The states of the motion, those on both sides of jumps, and those in which quantities are largest or smallest."""
        times, path, reactions = self.resolved.peak_times(), self.resolved.path, self.reactions
        if len(times) == len(reactions.motion.time):
            return PeakStates(reactions, ("",) * len(times))
        found = in_other_states(reactions, path.at(times))
        return PeakStates(found, _remarks(found, times, *path.jumps))

    def mean_states(self) -> MeanStates:
        """The nodes of the panels."""
        borders, rule = self.resolved.panels.borders, gauss_rule()
        half = 0.5 * np.diff(borders)
        times = (borders[:-1] + half)[:, None] + half[:, None] * rule.nodes
        reactions = in_other_states(self.reactions, self.resolved.path.at(times.ravel()))
        return MeanStates(reactions, (half[:, None] * rule.weights).ravel(), borders)


@dataclass(frozen=True, eq=False)
class GivenStates:
    """A motion of which nothing is known between its states."""

    reactions: Reactions

    def peak_states(self) -> PeakStates:
        """The given states."""
        return PeakStates(self.reactions, ("",) * len(self.reactions.motion.crank_angle))

    def mean_states(self) -> MeanStates:
        """The given states by trapezoids over time, all alike if they have no times."""
        motion = self.reactions.motion
        weight = np.ones(len(motion.crank_angle))
        if motion._time is not None and len(weight) > 1:
            steps = np.diff(motion.time)
            last = steps[-1] if is_cycle(motion) else 0.0
            weight = 0.5 * (np.append(steps, last) + np.append(last, steps))
        return MeanStates(self.reactions, weight, np.zeros(0))


def between_states(reactions: Reactions, quantities: Quantities, corners: AlongMotion | None = None) -> ResolvedStates | GivenStates:
    """The states of reactions in which quantities jump or are largest, and those that integrate them over time.

    Args:
        reactions: to a motion.
        quantities: that are resolved.
        corners: as of `Path.resolve`.

    Warns:
        PinpressWarning: no panels resolve the quantities, so that only the given states are left.
    """
    path = reactions._path
    resolved = None if path is None else path.resolve(lambda motion: quantities(in_other_states(reactions, motion)), corners)
    return GivenStates(reactions) if resolved is None else ResolvedStates(reactions, resolved)


def states_at(reactions: Reactions, angles: Array) -> Reactions:
    """The reactions in the states in which the first driver is at angles (m,) [rad or m], of a period in any of its turns.

    Raises:
        PinpressError: the driver does not reach an angle, or the motion is known only in its given states.
    """
    path, coordinate = reactions._path, reactions.motion.driver_coordinates[0]
    if path is None:
        raise PinpressError("the motion is known in its states alone: give at='states', or a motion of one driver with times")
    drive, found = path.motion.crank_angle, []
    for angle in angles:
        wanted = angle
        if path.closed and drive[-1] != drive[0]:
            wanted = drive[0] + (angle - drive[0]) % (drive[-1] - drive[0])
        beyond = drive - wanted
        before = np.flatnonzero(np.signbit(beyond[:-1]) != np.signbit(beyond[1:]))
        exact = path.times[beyond == 0.0]
        if not len(before) and not len(exact):
            ends = f"{coordinate.shown(drive.min())} to {coordinate.shown(drive.max())}"
            raise PinpressError(f"the motion does not reach {coordinate.at(angle)}: it goes from {ends}")
        roots = exact
        if not len(exact):

            def away(times: Array, wanted: float = wanted) -> tuple[Array, Array]:
                motion = path.at(times)
                return motion.crank_angle - wanted, motion.crank_speed

            roots = bracketed_roots(away, path.times[before], path.times[before + 1], absolute=1e-6 * SIDE * path.step)
        found.append(roots[:1])
    return in_other_states(reactions, path.at(np.concatenate(found)))


def _remarks(reactions: Reactions, times: Array, jumps: Array, distance: Array) -> tuple[str, ...]:
    """A remark for each state; ``distance``: (k,) of the states on both sides of the k jumps [s]."""
    remarks, force = [""] * len(times), reactions.process_force
    rounding = 1e-6 * float(np.abs(force).max(initial=0.0))  # of the force, from one side of a jump to the other
    for jump, side in zip(jumps, distance, strict=True):
        before, after = (int(np.abs(times - place).argmin()) for place in (jump - side, jump + side))
        change = abs(force[after]) - abs(force[before])
        if abs(change) > rounding:
            remarks[before] = remarks[after] = "where the load begins" if change > 0 else "where the load ends"
    return tuple(remarks)


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
