"""A motion between its states, and functions along it that are resolved between their jumps.

A process load may begin or end with its full force. Torque and bearing forces then jump, and their largest values are the limits at one
side of the jump, which evenly spaced states meet only by chance. Jumps are where the slide passes the ends of the loads' intervals, where
the slide turns back, where bearings with friction turn back, and where the law of a cam has a corner. All of these are roots of known
functions along the motion. Between them functions are polynomials on panels, which are halved until these resolve them. Where a polynomial
turns a quantity is largest, and its nodes are those of Gauss's rule. So no number depends on how many states a motion has.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple, Protocol, cast, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ..common.errors import PinpressError, caution
from ..common.numerics import bracketed_roots, polynomial_values, quintics
from ..common.quantities import Array
from ..engines.machine_elements.cams import CamContact
from ..kinematics.cycle import POINTS, moved
from ..kinematics.motion import Motion, is_constant, is_cycle
from ..linkage.linkage import Linkage
from ..loads.link import Friction, Load, PointForce, PointMoment
from ..loads.link import is_constant as is_constant_load
from ..loads.process import ProcessLoad, TimeForce
from .applied_loads import RelativeTurn, acting_between, relative_turn, turn_between
from .panels import Panels, last_terms, resolve

SIDE = 1e-8
"""Distance of a state from a jump, as a share of a step. In steps of half a degree this is 1e-10 rad, 100 times what counts as rest."""
MOST_STEPS = 20  # of Newton's method to a corner of a cam, which takes three or four
PANELS = 16  # a turn; they resolve most presses at once
MISSED = 1e-9  # what a panel may miss of an integral over the whole motion: three digits more than are printed
MOST_STATES = 10_000  # of a table between whose states quantities are looked at; a panel from each to the next would take gigabytes
MOST_NODES = 20 * MOST_STATES  # of panels: friction that reverses a thousand times takes fewer, a force that is noise has no end

Functions = Callable[[Motion], Iterable[tuple[Array, float]]]
"""Functions along a motion, as groups (n, k) with the size below which those of a group need fewer digits."""
AlongMotion = Callable[[Motion], tuple[Array, Array]]
"""A function along a motion: its values and its slopes in time (n,)."""


@runtime_checkable
class Simulated(Protocol):
    """A motion that is known at all times, as a `Run`."""

    def at_times(self, times: Array) -> Motion: ...

    @property
    def jumps(self) -> Array | None: ...

    @property
    def smooth_between(self) -> Array: ...


class _UnsettledError(Exception):
    """Polynomials do not resolve the quantities."""


# ------------------------------------------------------------------------------------------------------------ the motion between its states


@dataclass(frozen=True, eq=False)
class Path:
    """A motion that is known between its states, under loads and friction.

    Attributes:
        given: the motion.
        press: the press.
        loads: that act on it.
        friction: of its bearings.
        engine: by which it moves.
        times: (n,) between which a function passes zero at most once [s]; those of a `cycle` begin and end with its period.
        smooth_between: times, the first and the last among them, between which the motion itself is smooth [s].
        closed: whether the end is the beginning again.
    """

    given: Motion
    press: Linkage
    loads: Sequence[Load]
    friction: Mapping[str, Friction]
    engine: str
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
        motion = self.given
        driver = np.array([motion.crank_angle, motion.crank_speed, motion.crank_acceleration])
        if self.closed:
            period = np.copysign(2 * np.pi * (motion.period_turns or 1), driver[0, -1] - driver[0, 0])
            driver = np.column_stack([driver, driver[:, 0] + [period, 0.0, 0.0]])
        return np.asarray(quintics(np.diff(self.times), *driver))

    def at(self, times: Array) -> Motion:
        """The motion at rising times (m,) [s]. Between two states the driver follows the quintic through both."""
        motion, press = self.given, self.press
        if isinstance(motion, Simulated):
            return motion.at_times(times)
        if self.even:
            even = np.full(len(times), motion.crank_speed[0])
            angle = motion.crank_angle[0] + even * (times - self.times[0])
            return moved(press, press.branch_through_change_points, angle, even, 0.0 * even, times, self.engine)
        place = (np.searchsorted(self.times, times, side="right") - 1).clip(0, len(self.times) - 2)
        polynomials = self._polynomials[:, place]
        derivatives = (np.asarray(np.polynomial.polynomial.polyder(polynomials, order), dtype=float) for order in range(3))
        angle, speed, acceleration = (polynomial_values(each, times - self.times[place]) for each in derivatives)
        return moved(press, press.branch_through_change_points, angle, speed, acceleration, times, self.engine)

    @property
    def even(self) -> bool:
        """Whether it is a period at constant speed, which is known without its states."""
        return self.closed and is_constant(self.given.crank_speed)

    @cached_property
    def jumps(self) -> tuple[Array, Array]:
        """Times (k,) at which quantities may jump, and how far from them the states on both sides are [s]."""
        crossings, turns = _crossings(self)
        events = self.given.jumps if isinstance(self.given, Simulated) else None
        jumps = np.concatenate([crossings, _corners(self), [] if events is None else events, turns])
        # nearer than 1e-4 of a step to its dead centre the slide's height does not change in floating point
        return jumps, self.step * np.repeat([SIDE, 1e-4], [len(jumps) - len(turns), len(turns)])

    def resolve(self, functions: Functions, corners: AlongMotion | None = None) -> Resolved | None:
        """Resolve functions along the motion; None if no panels do.

        Args:
            functions: that are resolved.
            corners: functions that pass zero where a resolved one has a corner: values and slopes in time (m, n).

        Warns:
            PinpressWarning: no panels resolve the functions.
        """
        count = 0 if corners is None else len(corners(self.motion)[0])
        places = [_roots(self, partial(_one_of, cast(AlongMotion, corners), k)) for k in range(count)]
        borders = np.unique(np.concatenate([self.smooth_between, self.inside(self.jumps[0]), *places]))
        borders = np.append(borders[:-1][np.diff(borders) > 2 * SIDE * self.step], borders[-1])
        whole, sizes, nodes = float(borders[-1] - borders[0]), list[Array](), 0

        def sample(times: Array) -> Array:
            nonlocal nodes
            nodes += len(times)
            if nodes > MOST_NODES:
                raise _UnsettledError
            order = np.argsort(times)  # halved panels come in another order
            groups = list(functions(self.at(times[order])))
            rows = np.concatenate([values.T for values, _ in groups])
            least = np.repeat([size for _, size in groups], [values.shape[1] for values, _ in groups])
            size = np.maximum(np.abs(rows).max(axis=1), least)
            sizes[:] = [np.maximum(sizes[0], size) if sizes else size]
            rows[:, order] = rows.copy()
            return rows

        def missed(values: Array) -> Array:
            return np.asarray((last_terms(values) / np.where(sizes[0] > 0.0, sizes[0], 1.0)[:, None]).max(axis=0))

        try:
            panels, _ = resolve(sample, borders, missed, MISSED, narrowest=1e-8 * whole, whole=whole)
        except _UnsettledError:
            problem = f"a load of {self.press.name} jumps from state to state, however close these are"
            caution(f"{problem}: largest values and means are those of the given states; give a smooth law, or one of few steps")
            return None
        reach = np.abs(panels.coefficients[:, :, 1:]).sum(axis=2).max(axis=0)
        return Resolved(self, panels, reach > 1e-9 * sizes[0])


class Resolved(NamedTuple):
    """Functions along a motion as polynomials in time, and which of them vary by more than rounding."""

    path: Path
    panels: Panels
    varies: NDArray[np.bool_]

    def peak_times(self) -> Array:
        """Times of the motion's states, those on both sides of jumps, and those at which functions are largest or smallest, rising [s]."""
        path, (jumps, distance) = self.path, self.path.jumps
        # also at a jump itself, where a bearing with friction rests
        sides = path.inside(np.concatenate([jumps - distance, jumps, jumps + distance]))
        known = np.union1d(path.given.time, sides)
        peaks = self.panels.peaks(self.varies)
        behind = np.searchsorted(known, peaks).clip(1, len(known) - 1)
        apart = np.minimum(np.abs(peaks - known[behind - 1]), np.abs(peaks - known[behind])) > SIDE * path.step
        return np.union1d(known, path.inside(peaks[apart]))


def path_of(motion: Motion, press: Linkage, loads: Sequence[Load], friction: Mapping[str, Friction], engine: str) -> Path | None:
    """A motion between its states; None if nothing is known there.

    Some motions are known in their states alone: states that do not follow each other in time, several drivers that follow a table, and
    loads given as arrays.
    """
    closed = is_cycle(motion)
    if any(isinstance(load, str) or _changes_with_states(load) for load in loads):
        return None
    if motion._time is None or len(motion.time) < 3 or not np.all(np.diff(motion.time) > 0):
        return None
    if motion.jumps is None if isinstance(motion, Simulated) else len(motion.drivers) > 1 or len(motion.time) > MOST_STATES:
        return None
    times = motion.time
    if isinstance(motion, Simulated):
        smooth = motion.smooth_between
        times = np.union1d(times, smooth)
    else:
        times = smooth = np.append(times, 2 * times[-1] - times[-2]) if closed else times
        if closed and is_constant(motion.crank_speed):
            times, smooth = (np.linspace(times[0], times[-1], each * (motion.period_turns or 1) + 1) for each in (POINTS, PANELS))
    return Path(motion, press, loads, friction, engine, times, smooth, closed)


def _changes_with_states(load: object) -> bool:
    """Whether a load is a force that a caller gave for the states alone."""
    return isinstance(load, PointForce | PointMoment) and not is_constant_load(load)


# ----------------------------------------------------------------------------------------------------------------------------------- jumps


def _crossings(path: Path) -> tuple[Array, Array]:
    """Times at which loads and friction may jump, and those of them at which the slide turns back; both rise [s]."""
    press, turns = path.press, np.zeros(0)
    times = [np.array(load.edges) for load in path.loads if isinstance(load, TimeForce)]
    times += [_roots(path, rate) for name in path.friction if (rate := _rate(press, name)) is not None]
    for contact in press.contacts:
        if contact.rubbing:
            turn = relative_turn(press, press.link_of(contact.carrier), press.link_of(contact.first), contact.name)
            times += [] if turn is None else [_roots(path, _turning_rate(turn))]
    processes = [load for load in path.loads if isinstance(load, ProcessLoad) and not isinstance(load, TimeForce)]
    if processes:
        turns = np.unique(path.inside(_roots(path, lambda motion: (motion.slide_velocity, motion.slide_acceleration))))
        # the slide goes one way from state to state if it turns only at states
        states = np.union1d(path.times, turns)
        motion = path.at(states) if len(turns) else path.motion
        for level in {end for load in processes for _, *ends in acting_between(load, press) for end in ends if math.isfinite(end)}:
            edges = _roots(path, _height_above(level), states, motion)
            # a height within 1e-3 of a step from a dead centre is passed at the dead centre, or by rounding alone
            times.append(edges[np.abs(np.subtract.outer(edges, turns)).min(axis=1, initial=np.inf) > 1e-3 * path.step])
    return np.unique(path.inside(np.concatenate([np.zeros(0), *times]))), turns


def _corners(path: Path) -> Array:
    """Times (m,) at which acceleration or jerk of the follower of a cam may jump [s]."""
    press, times = path.press, [np.zeros(0)]
    for cam in (contact for contact in press.contacts if isinstance(contact, CamContact)):
        beyond = cam.angle(path.motion.joint_position.T) - cam.law.corners[:, None]
        before = np.signbit(np.sin(beyond))
        which, k = np.nonzero((before[:, :-1] != before[:, 1:]) & (np.cos(beyond[:, :-1]) > 0.0))
        if len(k):
            times.append(_passed(path, cam, cam.law.corners[which], path.times[k], path.times[k + 1]))
    return np.unique(path.inside(np.concatenate(times)))


def _passed(path: Path, cam: CamContact, angles: Array, low: Array, high: Array) -> Array:
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


def _rate(press: Linkage, name: str) -> AlongMotion | None:
    """The rate at which a bearing turns or slides; None of a loop whose links do not turn about one axis."""
    if name in press.joints:
        joint = press.joints.index(name)
        return lambda motion: (motion.v[:, joint], motion.a[:, joint])
    loop = next((loop for loop in press.loops if loop.name == name), None)
    with contextlib.suppress(PinpressError):
        turn = None if loop is None else turn_between(press, (loop.joint1, loop.joint2), name, "")
        return None if turn is None else _turning_rate(turn)
    return None


def _one_of(functions: AlongMotion, k: int, motion: Motion) -> tuple[Array, Array]:
    values, slopes = functions(motion)
    return values[k], slopes[k]


def _turning_rate(turn: RelativeTurn) -> AlongMotion:
    return lambda motion: (turn.angle(motion.v), turn.angle(motion.a))


def _height_above(level: float) -> AlongMotion:
    return lambda motion: (motion.slide_position - level, motion.slide_velocity)


def _roots(path: Path, function: AlongMotion, states: Array | None = None, motion: Motion | None = None) -> Array:
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
