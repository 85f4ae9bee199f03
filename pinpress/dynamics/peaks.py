"""Quantities between the states of a motion: where they jump, where they are largest, and their integrals over time.

A process load may begin or end with its full force. Torque and bearing forces then jump, and their largest values are the limits at one
side of the jump, which evenly spaced states meet only by chance. Jumps are where the slide passes the ends of the loads' intervals, where
the slide turns back, where bearings with friction turn back, and where the law of a cam has a corner. All of these are roots of known
functions along the motion. Between them quantities are polynomials on panels, which are halved until these resolve them. Where a
polynomial turns a quantity is largest, and its nodes are those of Gauss's rule. So no number depends on how many states a motion has.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ..common.errors import PinpressError, caution
from ..common.numerics import bracketed_roots, gauss_rule, polynomial_values, quintics
from ..common.quantities import Array
from ..engines.machine_elements.cams import CamContact
from ..kinematics.cycle import POINTS, moved
from ..kinematics.motion import Motion, is_constant, is_cycle
from ..loads import caller_laws
from ..loads.link import LinkLoad, PointForce, PointMoment
from ..loads.link import is_constant as is_constant_load
from ..loads.process import ProcessLoad, TimeForce, datum
from .applied_loads import RelativeTurn, intervals_of, relative_turn, turn_between
from .inverse_dynamics import in_other_states
from .panels import Panels, last_terms, resolve
from .reactions import Reactions

SIDE = 1e-8
"""Distance of a state from a jump, as a share of a step. In steps of half a degree this is 1e-10 rad, 100 times what counts as rest."""
MOST_STEPS = 20  # of Newton's method to a corner of a cam, which takes three or four
PANELS = 16  # a turn; they resolve most presses at once
MISSED = 1e-9  # what a panel may miss of an integral over the whole motion: three digits more than are printed
MOST_STATES = 10_000  # of a table between whose states quantities are looked at; a panel from each to the next would take gigabytes
MOST_NODES = 20 * MOST_STATES  # of panels: friction that reverses a thousand times takes fewer, a force that is noise has no end

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


@runtime_checkable
class Simulated(Protocol):
    """A motion that is known at all times, as a `Run`."""

    def at_times(self, times: Array) -> Motion: ...

    @property
    def jumps(self) -> Array | None: ...

    @property
    def smooth_between(self) -> Array: ...


@dataclass(frozen=True, eq=False)
class Resolved:
    """Quantities along a motion, resolved between its jumps.

    Attributes:
        path: the motion between its states.
        jumps: (k,) times of jumps [s].
        distance: (k,) from them at which the states on both sides are [s].
        panels: the quantities over time.
        varies: which rows of the panels vary by more than rounding.
    """

    path: _Path
    jumps: Array
    distance: Array
    panels: Panels
    varies: NDArray[np.bool_]

    def peak_states(self) -> PeakStates:
        """The states of the motion, those on both sides of jumps, and those in which quantities are largest or smallest."""
        path = self.path
        reactions = path.reactions
        # also at a jump itself, where a bearing with friction rests
        sides = path.inside(np.concatenate([self.jumps - self.distance, self.jumps, self.jumps + self.distance]))
        known = np.union1d(reactions.motion.time, sides)
        peaks = self.panels.peaks(self.varies)
        behind = np.searchsorted(known, peaks).clip(1, len(known) - 1)
        apart = np.minimum(np.abs(peaks - known[behind - 1]), np.abs(peaks - known[behind])) > SIDE * path.step
        times = np.union1d(known, path.inside(peaks[apart]))
        if len(times) == len(reactions.motion.time):
            return PeakStates(reactions, ("",) * len(times))
        found = in_other_states(reactions, path.at(times))
        return PeakStates(found, _remarks(found, times, self.jumps, self.distance))

    def mean_states(self) -> MeanStates:
        """The nodes of the panels."""
        half, rule = 0.5 * np.diff(self.panels.borders), gauss_rule()
        times = (self.panels.borders[:-1] + half)[:, None] + half[:, None] * rule.nodes
        reactions = in_other_states(self.path.reactions, self.path.at(times.ravel()))
        return MeanStates(reactions, (half[:, None] * rule.weights).ravel(), self.panels.borders)


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


class _UnsettledError(Exception):
    """Polynomials do not resolve the quantities."""


def between_states(
    reactions: Reactions, quantities: Quantities, reversing: Callable[[Motion], Iterable[tuple[Array, Array]]] | None = None
) -> Resolved | GivenStates:
    """Resolve quantities along a motion.

    Some motions are known in their states alone: states that do not follow each other in time, several drivers that follow a table, and
    loads given as arrays.

    Args:
        reactions: to the motion.
        quantities: that are resolved.
        reversing: gives values and slopes in time (n,) of functions that pass zero where a quantity has a corner.

    Warns:
        PinpressWarning: no panels resolve the quantities, so that only the given states are left.
    """
    path = _path(reactions)
    if path is None:
        return GivenStates(reactions)
    jumps, distance = _jumps(reactions, path)
    corners = [] if reversing is None else [_roots(path, _one_of(reversing, k)) for k in range(len(list(reversing(path.motion))))]
    borders = np.unique(np.concatenate([path.smooth_between, path.inside(jumps), *corners]))
    borders = np.append(borders[:-1][np.diff(borders) > 2 * SIDE * path.step], borders[-1])
    whole = float(borders[-1] - borders[0])
    sizes: list[Array] = []
    count = 0

    def sample(times: Array) -> Array:
        nonlocal count
        count += len(times)
        if count > MOST_NODES:
            raise _UnsettledError
        order = np.argsort(times)  # halved panels come in another order
        groups = list(quantities(in_other_states(reactions, path.at(times[order]))))
        rows = np.concatenate([values.T for values, _ in groups])
        least = np.repeat([size for _, size in groups], [values.shape[1] for values, _ in groups])
        size = np.maximum(np.abs(rows).max(axis=1), least)
        sizes[:] = [np.maximum(sizes[0], size) if sizes else size]
        rows[:, order] = rows.copy()
        return rows

    def missed(values: Array) -> Array:
        """Of the integrals: what the polynomial misses, times the share of the panel, which is not known here."""
        return np.asarray((last_terms(values) / np.where(sizes[0] > 0.0, sizes[0], 1.0)[:, None]).max(axis=0))

    try:
        panels, _ = resolve(sample, borders, missed, MISSED, narrowest=1e-8 * whole, whole=whole)
    except _UnsettledError:
        problem = f"a load of {reactions._press.name} jumps from state to state, however close these are"
        caution(f"{problem}: largest values and means are those of the given states; give a smooth law, or one of few steps")
        return GivenStates(reactions)
    reach = np.abs(panels.coefficients[:, :, 1:]).sum(axis=2).max(axis=0)
    return Resolved(path, jumps, distance, panels, reach > 1e-9 * sizes[0])


def states_at(reactions: Reactions, angles: Array) -> Reactions:
    """The reactions in the states in which the first driver is at angles (m,) [rad or m], of a period in any of its turns.

    Raises:
        PinpressError: the driver does not reach an angle, or the motion is known only in its given states.
    """
    path, coordinate = _path(reactions), reactions.motion.driver_coordinates[0]
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


# ------------------------------------------------------------------------------------------------------------ the motion between its states


@dataclass(frozen=True, eq=False)
class _Path:
    """A motion that is known between its states.

    Attributes:
        reactions: to the motion.
        times: (n,) between which a function passes zero at most once [s]; those of a `cycle` begin and end with its period.
        smooth_between: times, the first and the last among them, between which the motion itself is smooth [s].
        closed: whether the end is the beginning again.
    """

    reactions: Reactions
    times: Array
    smooth_between: Array
    closed: bool

    @property
    def step(self) -> float:
        """Mean step [s]."""
        return float(self.times[-1] - self.times[0]) / (len(self.times) - 1)

    def inside(self, times: Array) -> Array:
        """Those of the times at which the motion is known. In a `cycle` every time is: others are moved by a period."""
        first, last = self.times[0], self.times[-1]
        if self.closed:
            return np.asarray(first + (times - first) % (last - first))
        return np.asarray(times[(times >= first) & (times <= last)])

    @cached_property
    def motion(self) -> Motion:
        """The motion at `times`."""
        return self.at(self.times)

    @cached_property
    def _polynomials(self) -> Array:
        """(6, n - 1) of the driver between the states, and, in a `cycle`, from the last one to the end of the period."""
        motion = self.reactions.motion
        driver = np.array([motion.crank_angle, motion.crank_speed, motion.crank_acceleration])
        if self.closed:
            period = np.copysign(2 * np.pi * (motion.period_turns or 1), driver[0, -1] - driver[0, 0])
            driver = np.column_stack([driver, driver[:, 0] + [period, 0.0, 0.0]])
        return np.asarray(quintics(np.diff(self.times), *driver))

    def at(self, times: Array) -> Motion:
        """The motion at rising times (m,) [s]. Between two states the driver follows the quintic through both."""
        motion, press = self.reactions.motion, self.reactions._press
        if isinstance(motion, Simulated):
            return motion.at_times(times)
        if self.even:
            even = np.full(len(times), motion.crank_speed[0])
            angle = motion.crank_angle[0] + even * (times - self.times[0])
            return moved(press, press.branch_through_change_points, angle, even, 0.0 * even, times, self.reactions.engine)
        place = (np.searchsorted(self.times, times, side="right") - 1).clip(0, len(self.times) - 2)
        polynomials = self._polynomials[:, place]
        derivatives = (np.asarray(np.polynomial.polynomial.polyder(polynomials, order), dtype=float) for order in range(3))
        angle, speed, acceleration = (polynomial_values(each, times - self.times[place]) for each in derivatives)
        return moved(press, press.branch_through_change_points, angle, speed, acceleration, times, self.reactions.engine)

    @property
    def even(self) -> bool:
        """Whether it is a period at constant speed, which is known without its states."""
        return self.closed and is_constant(self.reactions.motion.crank_speed)


def _path(reactions: Reactions) -> _Path | None:
    """The motion between its states; None if nothing is known there."""
    motion, closed = reactions.motion, is_cycle(reactions.motion)
    if any(isinstance(load, str) or _changes_with_states(load) for load in reactions.loads):
        return None
    if motion._time is None or len(motion.time) < 3 or not np.all(np.diff(motion.time) > 0):
        return None
    if motion.jumps is None if isinstance(motion, Simulated) else len(motion.drivers) > 1 or len(motion.time) > MOST_STATES:
        return None
    times = motion.time
    if isinstance(motion, Simulated):
        inner = motion.smooth_between
        return _Path(reactions, np.union1d(times, inner), inner, closed)
    if closed:
        times = np.append(times, 2 * times[-1] - times[-2])
    if closed and is_constant(motion.crank_speed):
        turns, (first, last) = motion.period_turns or 1, times[[0, -1]]
        return _Path(reactions, np.linspace(first, last, POINTS * turns + 1), np.linspace(first, last, PANELS * turns + 1), True)
    return _Path(reactions, times, times, closed)


def _changes_with_states(load: object) -> bool:
    """Whether a load is a force that a caller gave for the states alone."""
    return isinstance(load, PointForce | PointMoment) and not is_constant_load(load)


# ----------------------------------------------------------------------------------------------------------------------------------- jumps


def _jumps(reactions: Reactions, path: _Path) -> tuple[Array, Array]:
    """Times (k,) at which quantities may jump, and how far from them the states on both sides are [s]."""
    crossings, turns = _crossings(reactions, path)
    events = reactions.motion.jumps if isinstance(reactions.motion, Simulated) else None
    jumps = np.concatenate([crossings, _corners(path), [] if events is None else events, turns])
    # nearer than 1e-4 of a step to its dead centre the slide's height does not change in floating point
    return jumps, path.step * np.repeat([SIDE, 1e-4], [len(jumps) - len(turns), len(turns)])


def _crossings(reactions: Reactions, path: _Path) -> tuple[Array, Array]:
    """Times at which loads and friction may jump, and those of them at which the slide turns back; both rise [s]."""
    press, turns = reactions._press, np.zeros(0)
    times = [np.array(load.edges) for load in reactions.loads if isinstance(load, TimeForce)]
    times += [_roots(path, rate) for name in reactions.friction if (rate := _rate(reactions, name)) is not None]
    for contact in press.contacts:
        if contact.rubbing:
            turn = relative_turn(press, press.link_of(contact.carrier), press.link_of(contact.first), contact.name)
            times += [] if turn is None else [_roots(path, _turning_rate(turn))]
    processes = [load for load in reactions.loads if not isinstance(load, LinkLoad | TimeForce)]
    if processes:
        turns = np.unique(path.inside(_roots(path, lambda motion: (motion.slide_velocity, motion.slide_acceleration))))
        # the slide goes one way from state to state if it turns only at states
        states = np.union1d(path.times, turns)
        motion = path.at(states) if len(turns) else path.motion
        for level in {level for load in processes for level in _levels(load, reactions)}:
            edges = _roots(path, _height_above(level), states, motion)
            # a height within 1e-3 of a step from a dead centre is passed at the dead centre, or by rounding alone
            times.append(edges[np.abs(np.subtract.outer(edges, turns)).min(axis=1, initial=np.inf) > 1e-3 * path.step])
    return np.unique(path.inside(np.concatenate([np.zeros(0), *times]))), turns


def _corners(path: _Path) -> Array:
    """Times (m,) at which acceleration or jerk of the follower of a cam may jump [s]."""
    press, times = path.reactions._press, [np.zeros(0)]
    for cam in (contact for contact in press.contacts if isinstance(contact, CamContact)):
        beyond = cam.angle(path.motion.joint_position.T) - cam.law.corners[:, None]
        before = np.signbit(np.sin(beyond))
        which, k = np.nonzero((before[:, :-1] != before[:, 1:]) & (np.cos(beyond[:, :-1]) > 0.0))
        if len(k):
            times.append(_passed(path, cam, cam.law.corners[which], path.times[k], path.times[k + 1]))
    return np.unique(path.inside(np.concatenate(times)))


def _passed(path: _Path, cam: CamContact, angles: Array, low: Array, high: Array) -> Array:
    """Times (m,) between low and high ones at which a cam passes angles of its law, by Newton's method [s]. It may be at the ends."""
    time = 0.5 * (low + high)
    for _ in range(MOST_STEPS):
        order = np.argsort(time)
        motion, back = path.at(time[order]), np.argsort(order)
        beyond = cam.angle(motion.joint_position.T)[back] - angles
        with np.errstate(all="ignore"):
            step = np.tan(beyond) / motion.v[back, cam.curve.joint]  # which is the same a turn further
        last, time = time, np.clip(np.where(beyond == 0.0, time, time - step), low, high)
        if np.all(np.abs(time - last) <= 1e-6 * SIDE * path.step):
            break
    return time


AlongMotion = Callable[[Motion], tuple[Array, Array]]
"""A function along a motion: its values and its slopes in time (n,)."""


def _rate(reactions: Reactions, name: str) -> AlongMotion | None:
    """The rate at which a bearing turns or slides; None of a loop whose links do not turn about one axis."""
    press = reactions._press
    if name in press.joints:
        joint = press.joints.index(name)
        return lambda motion: (motion.v[:, joint], motion.a[:, joint])
    loop = next((loop for loop in press.loops if loop.name == name), None)
    with contextlib.suppress(PinpressError):
        turn = None if loop is None else turn_between(press, (loop.joint1, loop.joint2), name, "")
        return None if turn is None else _turning_rate(turn)
    return None


def _one_of(functions: Callable[[Motion], Iterable[tuple[Array, Array]]], k: int) -> AlongMotion:
    return lambda motion: list(functions(motion))[k]


def _turning_rate(turn: RelativeTurn) -> AlongMotion:
    return lambda motion: (turn.angle(motion.v), turn.angle(motion.a))


def _height_above(level: float) -> AlongMotion:
    return lambda motion: (motion.slide_position - level, motion.slide_velocity)


def _levels(load: object, reactions: Reactions) -> Iterator[float]:
    """Slide positions at which a process load begins or ends [m]."""
    assert isinstance(load, ProcessLoad)
    intervals = intervals_of(caller_laws.asked_load(load))
    if intervals:
        zero = datum(load, reactions._press)
        yield from (zero + end for _, each in intervals for end in (each.lower, each.upper) if np.isfinite(end))


def _roots(path: _Path, function: AlongMotion, states: Array | None = None, motion: Motion | None = None) -> Array:
    """Times (m,) at which a function passes zero.

    Args:
        path: the motion between its states.
        function: that passes zero.
        states: (n,) times between which it passes zero at most once [s]; by default those of the path.
        motion: the motion at these times.
    """
    states = path.times if states is None else states
    values = function(path.motion if motion is None else motion)[0]
    if path.closed:
        values = np.append(values[:-1], values[0])
    before = np.flatnonzero(np.signbit(values[:-1]) != np.signbit(values[1:]))
    if not len(before):
        return np.zeros(0)
    # to a millionth of the distance of the states on both sides
    return bracketed_roots(lambda times: function(path.at(times)), states[before], states[before + 1], absolute=1e-6 * SIDE * path.step)


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
