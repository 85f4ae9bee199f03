"""The states between a motion's own at which its quantities jump or are largest, so that no peak depends on where states happen to be.

Where a process load begins or ends with its full force, torque and bearing forces jump. The largest value then is the limit at one side of
the jump, which even steps meet by chance. The jumps are where the slide passes the ends of the loads' intervals, where it turns back, and
where bearings with friction do: roots of known functions along the motion. States stand on both sides of each. Smooth peaks are found by
parabolas through three states.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from ..common.numerics import bracketed_roots, polynomial_values, quintics
from ..common.quantities import Array
from ..kinematics.motion import Motion, moved
from ..loads import caller_laws
from ..loads.link import PointForce, SpringDamper
from ..loads.process import ProcessLoad, TimeForce, datum
from .applied_loads import intervals_of
from .harmonics import is_cycle
from .inverse_dynamics import Reactions, in_other_states

BESIDE = 1e-8  # distance of a state from a jump, as a share of a step: 1e-10 rad of steps of half a degree, 100 times what counts as rest
BESIDE_TURN = 1e-4  # the same of a dead centre of the slide, nearer to which its height does not change in floating point
FOUND = 1e-6  # share of this distance to which a jump is located
NEARER = (1 / 8, 1 / 64)  # shares of a step beside the last parabola's vertex at which the states of the next one are
BETWEEN = 32  # states that at least are between two jumps: a load may act over less than a step
AT_DEAD_CENTRE = 1e-3  # share of a step from a dead centre within which a load's height is passed there, or by rounding alone
CONSTANT = 1e-9  # share of its size by which a quantity that is constant changes by rounding
JUMP = 1e-6  # share of the largest process force from which a change of it across a jump is no rounding


class PeakStates(NamedTuple):
    """The reactions in a motion's states and in those at which they jump or are largest.

    Attributes:
        reactions: in all these states, in the order of time.
        remarks: for each of them what is there, as "where the load begins"; mostly empty.
        weight: (n,) share of the period or of the states for which each stands, in sums; 0 of those that parabolas found.
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
    """The states of reactions with those at which quantities (n,) jump or are largest or smallest.

    States that stand for no motion in time, several drivers that move as a table says, and loads given as arrays leave nothing to be found
    between the states; these are then returned alone.
    """
    motion = reactions.motion
    count = len(motion.crank_angle)
    as_given = PeakStates(reactions, ("",) * count, np.full(count, 1.0 / max(count, 1)))
    way = _Way.of(reactions)
    if way is None:
        return as_given
    passed, turns = _passed(reactions, way)
    events = reactions.motion.jumps if isinstance(reactions.motion, Simulated) else None
    jumps = np.concatenate([passed, [] if events is None else events, turns])
    beside = way.step * np.repeat([BESIDE, BESIDE_TURN], [len(jumps) - len(turns), len(turns)])
    sides = way.within(np.concatenate([jumps - beside, jumps + beside]))
    known = np.union1d(way.times[:count], np.concatenate([sides, _between(way, np.union1d(passed, turns))]))
    smooth = _vertices(way, known, quantities, BESIDE * way.step)
    if len(known) + len(smooth) == count:
        return as_given
    nearest = known[np.searchsorted(known, smooth).clip(0, len(known) - 1)], known[(np.searchsorted(known, smooth) - 1).clip(0)]
    clear = np.abs(np.subtract(nearest, smooth)).min(axis=0) > BESIDE * way.step
    times = np.union1d(known, smooth[clear])
    found = in_other_states(reactions, way.at(times))
    places = np.searchsorted(known, times).clip(0, len(known) - 1)
    weight = np.where(known[places] == times, _weights(way, known)[places], 0.0)
    return PeakStates(found, _remarks(found, times, jumps, beside), weight)


@dataclass(frozen=True, eq=False)
class _Way:
    """A motion that is known between its states.

    Attributes:
        reactions: to the motion.
        times: (n,) of its states, over a `cycle` with the end of the period behind [s].
        angle: driver's angle, speed and acceleration at these times, (3, n).
        closed: whether the end is the beginning again.
    """

    reactions: Reactions
    times: Array
    driver: Array
    closed: bool

    @staticmethod
    def of(reactions: Reactions) -> _Way | None:
        """The way of a motion; None where nothing is known between its states."""
        motion, closed = reactions.motion, is_cycle(reactions.motion)
        if any(isinstance(load, str) or (isinstance(load, PointForce) and not _is_one(load)) for load in reactions.loads):
            return None
        if motion._time is None or len(motion.time) < 3 or not np.all(np.diff(motion.time) > 0):
            return None
        if motion.jumps is None if isinstance(motion, Simulated) else len(motion.drivers) > 1:
            return None
        driver = np.array([motion.crank_angle, motion.crank_speed, motion.crank_acceleration])
        times = motion.time
        if closed:
            times = np.append(times, 2 * times[-1] - times[-2])
            end = driver[:, 0] + [np.copysign(2 * np.pi * (motion.period_turns or 1), driver[0, -1] - driver[0, 0]), 0.0, 0.0]
            driver = np.column_stack([driver, end])
        return _Way(reactions, times, driver, closed)

    @property
    def step(self) -> float:
        """Mean step [s]."""
        return float(self.times[-1] - self.times[0]) / (len(self.times) - 1)

    def within(self, times: Array) -> Array:
        """Times that are in the motion; over a `cycle` others are a period away."""
        first, last = self.times[0], self.times[-1]
        if self.closed:
            return np.asarray(first + (times - first) % (last - first))
        return np.asarray(times[(times >= first) & (times <= last)])

    def at(self, times: Array) -> Motion:
        """The motion at rising times (m,)."""
        motion, press = self.reactions.motion, self.reactions._press
        if isinstance(motion, Simulated):
            return motion.at_times(times)
        angle, speed, acceleration = self._driven(times)
        return moved(press, press.branch_through_change_points, angle, speed, acceleration, times, self.reactions.engine)

    def _driven(self, times: Array) -> Array:
        """Angle, speed and acceleration (3, m) of the driver, which between two states are those of the quintic through both."""
        place = (np.searchsorted(self.times, times, side="right") - 1).clip(0, len(self.times) - 2)
        angle, speed, acceleration = self.driver
        through = quintics(np.diff(self.times), angle, speed, acceleration)[:, place]
        since = times - self.times[place]
        derivatives = [np.polynomial.polynomial.polyder(through, order) for order in range(3)]
        return np.array([polynomial_values(each, since) for each in derivatives])


def _is_one(load: PointForce) -> bool:
    """Whether a force is the same in all states."""
    return not callable(load.force) and np.ndim(load.force) == 1


# ----------------------------------------------------------------------------------------------------------------------------------- jumps


Passing = Callable[[Motion], tuple[Array, Array]]
"""A function along a motion at whose roots quantities may jump: its values and its slopes in time (n,)."""


def _passed(reactions: Reactions, way: _Way) -> tuple[Array, Array]:
    """Times at which loads and friction may jump, and those of them at which the slide turns back, rising [s]."""
    press, count = reactions._press, len(reactions.motion.crank_angle)
    processes = [load for load in reactions.loads if not isinstance(load, PointForce | SpringDamper | TimeForce)]
    found = [np.array(load.edges) for load in reactions.loads if isinstance(load, TimeForce)]
    motion, nodes, back = reactions.motion, way.times[:count], np.zeros(0)
    rates = [_rate_of(press.joints.index(name)) for name in reactions.friction if name in press.joints]
    found += [_roots(way, rate, nodes, *rate(motion)) for rate in rates]
    if processes:
        back = np.unique(way.within(_roots(way, _slide_rate, nodes, *_slide_rate(motion))))
        if len(back):  # between these the slide goes one way
            nodes = np.union1d(nodes, back)
            motion = way.at(nodes)
        for level in {level for load in processes for level in _levels(load, reactions)}:
            passing = _height_above(level)
            edges = _roots(way, passing, nodes, *passing(motion))
            found.append(edges[np.abs(np.subtract.outer(edges, back)).min(axis=1, initial=np.inf) > AT_DEAD_CENTRE * way.step])
    return np.unique(way.within(np.concatenate([np.zeros(0), *found]))), back


def _between(way: _Way, jumps: Array) -> Array:
    """Times (m,) of more states between two jumps that are fewer than `BETWEEN` steps from each other."""
    near = [(one, other) for one, other in itertools.pairwise(jumps) if other - one < BETWEEN * way.step]
    return np.concatenate([np.zeros(0), *(np.linspace(*pair, BETWEEN + 2)[1:-1] for pair in near)])


def _slide_rate(motion: Motion) -> tuple[Array, Array]:
    return motion.slide_velocity, motion.slide_acceleration


def _rate_of(joint: int) -> Passing:
    return lambda motion: (motion.v[:, joint], motion.a[:, joint])


def _height_above(level: float) -> Passing:
    return lambda motion: (motion.slide_position - level, motion.slide_velocity)


def _levels(load: object, reactions: Reactions) -> Iterator[float]:
    """Slide positions at which a process load begins or ends [m]."""
    assert isinstance(load, ProcessLoad)
    asked = caller_laws.asked_load(load)
    intervals = intervals_of(asked)
    if intervals:
        zero = datum(load, reactions._press)
        yield from (zero + end for _, each in intervals for end in (each.lower, each.upper) if np.isfinite(end))


def _roots(way: _Way, passing: Passing, nodes: Array, value: Array, _: Array) -> Array:
    """Times (m,) at which a function passes zero between nodes at which it has these values."""
    if way.closed:
        nodes, value = np.append(nodes, way.times[-1]), np.append(value, value[0])
    steps = np.flatnonzero(np.signbit(value[:-1]) != np.signbit(value[1:]))
    if not len(steps):
        return np.zeros(0)
    low, high = nodes[steps], nodes[steps + 1]

    return bracketed_roots(lambda times: passing(way.at(times)), low, high, absolute=FOUND * BESIDE * way.step)


def _remarks(reactions: Reactions, times: Array, jumps: Array, beside: Array) -> tuple[str, ...]:
    """For each of the states at these times what is there."""
    words, force = [""] * len(times), reactions.process_force
    least = JUMP * float(np.abs(force).max(initial=0.0))
    for jump, off in zip(jumps, beside, strict=True):
        before, after = (int(np.abs(times - side).argmin()) for side in (jump - off, jump + off))
        change = abs(force[after]) - abs(force[before])
        if abs(change) > least:
            words[before] = words[after] = "where the load begins" if change > 0 else "where the load ends"
    return tuple(words)


# ----------------------------------------------------------------------------------------------------------------------------- smooth peaks


def _vertices(way: _Way, known: Array, quantities: Callable[[Reactions], Iterable[Array]], beside: float) -> Array:
    """Times (m,) at which quantities are largest or smallest, by three parabolas each, from states at ``known`` times."""

    def values(times: Array) -> Array:
        return np.array(list(quantities(in_other_states(way.reactions, way.at(times)))))

    at_known = values(known)
    times = known
    for nearer in NEARER:
        vertex = _turns(way, times, at_known, beside)
        place = np.searchsorted(times, vertex).clip(1, len(times) - 1)
        step = nearer * (times[place] - times[place - 1])
        trial = np.setdiff1d(way.within(np.concatenate([vertex - step, vertex, vertex + step])), times)
        if not len(trial):
            break
        times, order = np.unique(np.concatenate([times, trial]), return_index=True)
        at_known = np.hstack([at_known, values(trial)])[:, order]
    best = times[np.concatenate([at_known.argmax(axis=1), at_known.argmin(axis=1)])]
    vertices = np.unique(np.concatenate([best, _turns(way, times, at_known, beside)]))
    return vertices[np.diff(vertices, prepend=-np.inf) > beside]


def _turns(way: _Way, times: Array, values: Array, beside: float) -> Array:
    """Vertices (m,) of the parabolas through three states each that are above the largest or below the smallest of values (quantities, n)
    [s]; none reaches over a jump."""
    if way.closed:
        period = way.times[-1] - way.times[0]
        times = np.concatenate([[times[-1] - period], times, [times[0] + period]])
        values = np.column_stack([values[:, -1], values, values[:, 0]])
    apart = np.diff(times) > 3 * beside
    slopes, left, right = np.diff(values) / np.diff(times), np.diff(times)[:-1], np.diff(times)[1:]
    with np.errstate(all="ignore"):
        bend = np.diff(slopes) / (left + right)
        tilt = (slopes[:, :-1] * right + slopes[:, 1:] * left) / (left + right)
        offset = -0.5 * tilt / bend
        peak = values[:, 1:-1] + 0.5 * tilt * offset
    changes = np.ptp(values, axis=1) > CONSTANT * np.abs(values).max(axis=1)
    met = changes[:, None] & (offset > -left) & (offset < right) & apart[:-1] & apart[1:]
    vertex, found = times[1:-1] + offset, [np.zeros(0)]
    for sign in (1, -1):
        beyond = met & (sign * bend < 0) & (sign * peak >= (sign * values[:, 1:-1]).max(axis=1, keepdims=True))
        height = np.where(beyond, sign * peak, -np.inf)
        # of peaks of nearly one height the parabolas do not tell the highest; of rounding there are as many as states
        highest = np.argsort(height, axis=1)[:, -3:]
        found.append(np.take_along_axis(vertex, highest, axis=1)[np.take_along_axis(beyond, highest, axis=1)])
    return way.within(np.unique(np.concatenate(found)))


def _weights(way: _Way, known: Array) -> Array:
    """Shares (n,) of the states at known times in sums: of the period, by trapezoids, where the motion is one; else of the states."""
    count = len(way.times) - way.closed
    if not way.closed:
        return np.where(np.isin(known, way.times), 1.0 / count, 0.0)
    steps = np.diff(np.append(known, way.times[-1] - way.times[0] + known[0]))
    return np.asarray(0.5 * (steps + np.roll(steps, 1)) / steps.sum())
