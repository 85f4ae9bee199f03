"""Peaks of a motion's quantities between its states: where they jump, and where they are largest.

A process load may begin or end with its full force. Torque and bearing forces then jump, and their largest values are the limits at one
side of the jump, which evenly spaced states meet only by chance. Jumps are where the slide passes the ends of the loads' intervals, where
the slide turns back, where bearings with friction turn back, and where the law of a cam has a corner. All of these are roots of known
functions along the motion. States are added on both sides of each. Smooth peaks are found by parabolas through three states.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from ..common.errors import PinpressError
from ..common.numerics import bracketed_roots, polynomial_values, quintics
from ..common.quantities import Array
from ..engines.machine_elements.cams import CamContact
from ..kinematics.cycle import moved
from ..kinematics.motion import Motion, is_cycle
from ..loads import caller_laws
from ..loads.link import LinkLoad, PointForce, PointMoment, is_constant
from ..loads.process import ProcessLoad, TimeForce, datum
from .applied_loads import RelativeTurn, intervals_of, relative_turn
from .inverse_dynamics import in_other_states
from .reactions import Reactions

SIDE = 1e-8
"""Distance of a state from a jump, as a share of a step. In steps of half a degree this is 1e-10 rad, 100 times what counts as rest."""
MOST_STEPS = 20  # of Newton's method to a corner of a cam, which takes three or four


class PeakStates(NamedTuple):
    """The reactions in a motion's states, and in those states between them in which quantities jump or are largest.

    Attributes:
        reactions: in all these states, in the order of time.
        remarks: for each state a remark such as "where the load begins"; mostly empty.
        weight: (n,) share of the period or of the states for which each state counts in sums; 0 for smooth peaks between the states.
    """

    reactions: Reactions
    remarks: tuple[str, ...]
    weight: Array


@runtime_checkable
class Simulated(Protocol):
    """A motion that is known at all times, as a `Run`."""

    def at_times(self, times: Array) -> Motion: ...

    @property
    def jumps(self) -> Array | None: ...


def peak_states(reactions: Reactions, quantities: Callable[[Reactions], Iterable[Array]]) -> PeakStates:
    """The states of reactions, and those between them in which quantities (n,) jump, or are largest or smallest.

    Some motions are known in their states alone: states that do not follow each other in time, several drivers that follow a table, and
    loads given as arrays. Then only the given states are returned.
    """
    motion = reactions.motion
    count = len(motion.crank_angle)
    given_states = PeakStates(reactions, ("",) * count, np.full(count, 1.0 / max(count, 1)))
    path = _path(reactions)
    if path is None:
        return given_states
    crossings, turns = _crossings(reactions, path)
    events = motion.jumps if isinstance(motion, Simulated) else None
    jumps = np.concatenate([crossings, _corners(reactions, path), [] if events is None else events, turns])
    # nearer than 1e-4 of a step to its dead centre the slide's height does not change in floating point
    distance = path.step * np.repeat([SIDE, 1e-4], [len(jumps) - len(turns), len(turns)])
    sides = path.inside(np.concatenate([jumps - distance, jumps + distance]))
    times = np.union1d(path.times[:count], np.concatenate([sides, _states_between(path, np.union1d(crossings, turns))]))
    smooth = _smooth_peaks(path, times, quantities)
    if len(times) + len(smooth) == count:
        return given_states
    behind = np.searchsorted(times, smooth)
    before, after = times[(behind - 1).clip(0)], times[behind.clip(0, len(times) - 1)]
    all_times = np.union1d(times, smooth[np.minimum(np.abs(smooth - before), np.abs(smooth - after)) > SIDE * path.step])
    at_peaks = in_other_states(reactions, path.at(all_times))
    places = np.searchsorted(times, all_times).clip(0, len(times) - 1)
    weight = np.where(times[places] == all_times, _weights(path, times)[places], 0.0)
    return PeakStates(at_peaks, _remarks(at_peaks, all_times, jumps, distance), weight)


def integration_states(reactions: Reactions, reversing: Callable[[Motion], Iterable[tuple[Array, Array]]]) -> tuple[Reactions, Array]:
    """States and weights (n,) [s] that integrate quantities over the time of a motion: by Gauss's rule between its states, the jumps of
    loads and friction, and the zeros of functions. The zeros are states too, of weight 0.

    A motion that is known only in its states is integrated by trapezoids.

    Args:
        reactions: to the motion.
        reversing: gives values and slopes in time (n,) of functions that pass zero where an integrand has a corner.

    Raises:
        PinpressError: the motion has no times.
    """
    path, motion = _path(reactions), reactions.motion
    if path is None:
        if motion._time is None or len(motion.time) < 2:
            raise PinpressError("the motion has no times, over which to integrate: give servo_cycle(press, angle, time=time)")
        steps = np.diff(motion.time)
        return reactions, 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))
    crossings, turns = _crossings(reactions, path)
    events = motion.jumps if isinstance(motion, Simulated) else None
    jumps = np.concatenate([crossings, _corners(reactions, path), turns, [] if events is None else events])
    states = path.times[: len(motion.crank_angle)]
    count = len(list(reversing(motion)))
    zeros = [_roots(path, lambda motion, k=k: list(reversing(motion))[k], states, motion) for k in range(count)]  # type: ignore[misc]
    ends = np.unique(np.concatenate([path.times, jumps, *zeros]))
    ends = np.append(ends[:-1][np.diff(ends) > SIDE * path.step], ends[-1])
    nodes, shares = np.polynomial.legendre.leggauss(4)
    half = 0.5 * np.diff(ends)
    times = np.column_stack([ends[:-1], ends[:-1, None] + half[:, None] * (1 + nodes)]).ravel()
    weight = np.column_stack([np.zeros(len(half)), half[:, None] * shares]).ravel()
    return in_other_states(reactions, path.at(times)), weight


def states_at(reactions: Reactions, angles: Array) -> Reactions:
    """The reactions in the states in which the first driver is at angles (m,) [rad or m], of a period in any of its turns.

    Raises:
        PinpressError: the driver does not reach an angle, or the motion is known only in its given states.
    """
    path, coordinate = _path(reactions), reactions.motion.driver_coordinates[0]
    if path is None:
        raise PinpressError("the motion is known in its states alone: give at='states', or a motion of one driver with times")
    drive, found = path.driver[0], []
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
        times: (n,) of its states; after the last state of a `cycle` comes the end of the period [s].
        driver: (3, n) position, speed and acceleration of the driver at these times.
        closed: whether the end is the beginning again.
    """

    reactions: Reactions
    times: Array
    driver: Array
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

    def at(self, times: Array) -> Motion:
        """The motion at rising times (m,) [s]. Between two states the driver follows the quintic through both."""
        motion, press = self.reactions.motion, self.reactions._press
        if isinstance(motion, Simulated):
            return motion.at_times(times)
        place = (np.searchsorted(self.times, times, side="right") - 1).clip(0, len(self.times) - 2)
        polynomials = quintics(np.diff(self.times), *self.driver)[:, place]
        derivatives = (np.polynomial.polynomial.polyder(polynomials, order) for order in range(3))
        angle, speed, acceleration = (polynomial_values(each, times - self.times[place]) for each in derivatives)
        return moved(press, press.branch_through_change_points, angle, speed, acceleration, times, self.reactions.engine)


def _path(reactions: Reactions) -> _Path | None:
    """The motion between its states; None if nothing is known there."""
    motion, closed = reactions.motion, is_cycle(reactions.motion)
    if any(isinstance(load, str) or _changes_with_states(load) for load in reactions.loads):
        return None
    if motion._time is None or len(motion.time) < 3 or not np.all(np.diff(motion.time) > 0):
        return None
    if motion.jumps is None if isinstance(motion, Simulated) else len(motion.drivers) > 1:
        return None
    times, driver = motion.time, np.array([motion.crank_angle, motion.crank_speed, motion.crank_acceleration])
    if closed:
        times = np.append(times, 2 * times[-1] - times[-2])
        period = np.copysign(2 * np.pi * (motion.period_turns or 1), driver[0, -1] - driver[0, 0])
        driver = np.column_stack([driver, driver[:, 0] + [period, 0.0, 0.0]])
    return _Path(reactions, times, driver, closed)


def _changes_with_states(load: object) -> bool:
    """Whether a load is a force that a caller gave for the states alone."""
    return isinstance(load, PointForce | PointMoment) and not is_constant(load)


# ----------------------------------------------------------------------------------------------------------------------------------- jumps


def _crossings(reactions: Reactions, path: _Path) -> tuple[Array, Array]:
    """Times at which loads and friction may jump, and those of them at which the slide turns back; both rise [s]."""
    press, motion = reactions._press, reactions.motion
    states, turns = path.times[: len(motion.crank_angle)], np.zeros(0)
    times = [np.array(load.edges) for load in reactions.loads if isinstance(load, TimeForce)]
    for name in reactions.friction:
        if name in press.joints:
            joint = press.joints.index(name)
            times.append(_roots(path, _joint_rate(joint), states, motion))
    for contact in press.contacts:
        if contact.rubbing:
            turn = relative_turn(press, press.link_of(contact.carrier), press.link_of(contact.first), contact.name)
            times += [] if turn is None else [_roots(path, _turning_rate(turn), states, motion)]
    processes = [load for load in reactions.loads if not isinstance(load, LinkLoad | TimeForce)]
    if processes:
        turns = np.unique(path.inside(_roots(path, lambda motion: (motion.slide_velocity, motion.slide_acceleration), states, motion)))
        if len(turns):  # the slide goes one way from state to state if it turns only at states
            states = np.union1d(states, turns)
            motion = path.at(states)
        for level in {level for load in processes for level in _levels(load, reactions)}:
            edges = _roots(path, _height_above(level), states, motion)
            # a height within 1e-3 of a step from a dead centre is passed at the dead centre, or by rounding alone
            times.append(edges[np.abs(np.subtract.outer(edges, turns)).min(axis=1, initial=np.inf) > 1e-3 * path.step])
    return np.unique(path.inside(np.concatenate([np.zeros(0), *times]))), turns


def _corners(reactions: Reactions, path: _Path) -> Array:
    """Times (m,) at which acceleration or jerk of the follower of a cam may jump [s]."""
    press, times = reactions._press, [np.zeros(0)]
    for cam in (contact for contact in press.contacts if isinstance(contact, CamContact)):
        states = path.times[: len(reactions.motion.crank_angle)]
        beyond = cam.angle(reactions.motion.joint_position.T) - cam.law.corners[:, None]
        if path.closed:
            states, beyond = np.append(states, path.times[-1]), np.column_stack([beyond, beyond[:, 0]])
        before = np.signbit(np.sin(beyond))
        which, k = np.nonzero((before[:, :-1] != before[:, 1:]) & (np.cos(beyond[:, :-1]) > 0.0))
        if len(k):
            times.append(_passed(path, cam, cam.law.corners[which], states[k], states[k + 1]))
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


def _joint_rate(joint: int) -> AlongMotion:
    return lambda motion: (motion.v[:, joint], motion.a[:, joint])


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


def _roots(path: _Path, function: AlongMotion, states: Array, motion: Motion) -> Array:
    """Times (m,) at which a function passes zero.

    Args:
        path: the motion between its states.
        function: that passes zero.
        states: (n,) times between which it passes zero at most once [s].
        motion: the motion at these times.
    """
    values = function(motion)[0]
    if path.closed:
        states, values = np.append(states, path.times[-1]), np.append(values, values[0])
    before = np.flatnonzero(np.signbit(values[:-1]) != np.signbit(values[1:]))
    if not len(before):
        return np.zeros(0)
    # to a millionth of the distance of the states on both sides
    return bracketed_roots(lambda times: function(path.at(times)), states[before], states[before + 1], absolute=1e-6 * SIDE * path.step)


def _states_between(path: _Path, jumps: Array) -> Array:
    """Times (m,) of 32 more states between any two jumps less than 32 steps apart, because a load may act over less than a step."""
    near = [(before, after) for before, after in itertools.pairwise(jumps) if after - before < 32 * path.step]
    return np.concatenate([np.zeros(0), *(np.linspace(*pair, 34)[1:-1] for pair in near)])


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


# ----------------------------------------------------------------------------------------------------------------------------- smooth peaks


def _smooth_peaks(path: _Path, state_times: Array, quantities: Callable[[Reactions], Iterable[Array]]) -> Array:
    """Times (m,) at which quantities are largest or smallest, by three parabolas each, from states at ``known`` times [s]."""

    def values(times: Array) -> Array:
        return np.array(list(quantities(in_other_states(path.reactions, path.at(times)))))

    times, at_times = state_times, values(state_times)
    for share in (1 / 8, 1 / 64):  # of a step, on both sides of the last vertex: there the next parabola's states are
        vertex = _vertices(path, times, at_times)
        place = np.searchsorted(times, vertex).clip(1, len(times) - 1)
        step = share * (times[place] - times[place - 1])
        trial = np.setdiff1d(path.inside(np.concatenate([vertex - step, vertex, vertex + step])), times)
        if not len(trial):
            break
        times, order = np.unique(np.concatenate([times, trial]), return_index=True)
        at_times = np.hstack([at_times, values(trial)])[:, order]
    best = times[np.concatenate([at_times.argmax(axis=1), at_times.argmin(axis=1)])]
    peaks = np.unique(np.concatenate([best, _vertices(path, times, at_times)]))
    return peaks[np.diff(peaks, prepend=-np.inf) > SIDE * path.step]


def _vertices(path: _Path, times: Array, values: Array) -> Array:
    """Vertices (m,) of the parabolas through three states each that lie above the largest or below the smallest of values (quantities, n)
    [s]. No parabola reaches over a jump."""
    if path.closed:
        period = path.times[-1] - path.times[0]
        times = np.concatenate([[times[-1] - period], times, [times[0] + period]])
        values = np.column_stack([values[:, -1], values, values[:, 0]])
    apart = np.diff(times) > 3 * SIDE * path.step
    slopes, left, right = np.diff(values) / np.diff(times), np.diff(times)[:-1], np.diff(times)[1:]
    with np.errstate(all="ignore"):
        bend = np.diff(slopes) / (left + right)
        tilt = (slopes[:, :-1] * right + slopes[:, 1:] * left) / (left + right)
        offset = -0.5 * tilt / bend
        height = values[:, 1:-1] + 0.5 * tilt * offset
    varies = np.ptp(values, axis=1) > 1e-9 * np.abs(values).max(axis=1)  # more than by rounding
    in_step = varies[:, None] & (offset > -left) & (offset < right) & apart[:-1] & apart[1:]
    vertex, chosen = times[1:-1] + offset, [np.zeros(0)]
    for sign in (1, -1):
        beyond = in_step & (sign * bend < 0) & (sign * height >= (sign * values[:, 1:-1]).max(axis=1, keepdims=True))
        # Parabolas cannot tell the highest of peaks that are nearly equal, so three are taken; rounding alone would give one in each state.
        highest = np.argsort(np.where(beyond, sign * height, -np.inf), axis=1)[:, -3:]
        chosen.append(np.take_along_axis(vertex, highest, axis=1)[np.take_along_axis(beyond, highest, axis=1)])
    return path.inside(np.unique(np.concatenate(chosen)))


def _weights(path: _Path, times: Array) -> Array:
    """Shares (n,) with which states at these times count in sums: of the period, by trapezoids, for a `cycle`; else of the given states."""
    if not path.closed:
        return np.where(np.isin(times, path.times), 1.0 / len(path.times), 0.0)
    steps = np.diff(np.append(times, path.times[-1] - path.times[0] + times[0]))
    return np.asarray(0.5 * (steps + np.roll(steps, 1)) / steps.sum())
