"""Equations of motion of a press on springs with its drive and its loads.

The loads are those of `driven_press`. Each acts along a path; which of its intervals acts is the same all through a segment of the motion:
`Segment`. A blank that is cut through stays cut until the press has turned, even where the slide rises again through the same heights while
the links ring, so that the direction of travel is that of the rigid press.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...common.quantities import Array
from ...loads.process import ForceInterval
from ..driven_press import DrivenPress, GeneralizedForce
from .panels import Indices, Linearised
from .press.drive import DriveTrain, TrainEvent, TrainMode
from .press.friction import BearingFriction
from .press.geometry import BodyState, VaryingInertia
from .press.paths import LoadPath, PathMotion
from .press.sprung_press import SpringForces, SprungPress, some_of
from .strokes import CRANK_ANGLE, INSTANT, MotionEvent, Release, Segment, TimeSpan


@dataclass(frozen=True, eq=False)
class HeldCrank:
    """A crank that turns at a constant speed.

    Attributes:
        angle: at time 0 [rad].
        speed: [rad/s].
    """

    angle: float
    speed: float


@dataclass(frozen=True, eq=False)
class ElasticEquations:
    """Equations of motion over the segments of a motion; see `panels.EquationsOfMotion`.

    Attributes:
        sprung: the press.
        driven: its drive and loads.
        paths: along which the loads act, by the rows of `DrivenPress.coordinates`.
        crank: its prescribed motion; None: it turns freely, under the drive.
        train: of a free crank; None: the crank is held.
        segments: the forces that act in each segment.
        modes: of the drive train in each segment; (): it is engaged all the time.
        events: what happens at the knots whose times are free.
        contacts: of pins with clearance, then of members of preloaded joints; they come after the loads.
        friction: of the bearings; None: they have none.
        direction: 1 where the crank turns forwards, else -1.
        lost: laws of contacts whose bodies are not apart yet, but part too fast to push each other, by the numbers of their forces.
    """

    sprung: SprungPress
    driven: DrivenPress
    paths: tuple[LoadPath, ...]
    crank: HeldCrank | None
    train: DriveTrain | None = None
    segments: tuple[Segment, ...] = ()
    modes: tuple[TrainMode, ...] = ()
    events: Mapping[int, MotionEvent] | None = None
    contacts: tuple[GeneralizedForce, ...] = ()
    friction: BearingFriction | None = None
    direction: int = 1
    lost: Mapping[int, ForceInterval] = field(default_factory=dict)

    @property
    def all_forces(self) -> tuple[GeneralizedForce, ...]:
        """All loads, then the contacts."""
        return self.driven.forces + self.contacts

    @property
    def size(self) -> int:
        """Number of unknown coordinates: those of the drive train, those of the bodies, and the crank's angle where it is free."""
        return self.sprung.free - 1 if self.train is None else self.train.count + self.sprung.free

    @property
    def body_start(self) -> int:
        """Number of the first coordinate of the bodies: those of the drive train come before."""
        return 0 if self.train is None else self.train.count

    @property
    def integrals(self) -> Sequence[int]:
        """Coordinates on which nothing depends, but on their rates: those of the drive's states."""
        return range(0 if self.train is None else len(self.train.scale))

    @property
    def unsprung(self) -> Sequence[int]:
        """Coordinates of a frame on its mounts: it begins where it stands under its weight, whatever shakes it."""
        last = self.body_start + self.sprung.free - 1
        return range(last - 3, last) if self.sprung.geometry.base is not None else ()

    @cached_property
    def mass(self) -> Array:
        """(size, size) mass matrix in the mode of the first segment; motions whose mode changes are solved segment by segment."""
        if self.train is None:
            return self.sprung.mass[: self.size, : self.size]
        return self.train.mass(self.sprung.mass, self.mode(0))

    @cached_property
    def whole_mass(self) -> Array:
        """Mass matrix of all unknown coordinates and the crank's angle, with flywheel and drive."""
        return self.sprung.mass if self.train is None else self.train.mass(self.sprung.mass)

    def mode(self, segment: int) -> TrainMode:
        """Mode of the drive train in a segment."""
        assert self.train is not None
        return self.modes[segment] if self.modes else self.train.engaged

    def whole(self, time: Array, y: Array, v: Array) -> tuple[Array, Array]:
        """Free coordinates and rates (n, f) of the bodies, that of the crank last, of the unknown ones (n, size)."""
        if self.crank is None:
            return y[:, self.body_start :], v[:, self.body_start :]
        angle, speed = self.crank.angle + self.crank.speed * time, np.full(len(time), self.crank.speed)
        return np.column_stack([y, angle]), np.column_stack([v, speed])

    def state(self, time: Array, y: Array, v: Array) -> Any:
        """The bodies at unknown coordinates and rates (n, size)."""
        return self.sprung.state(*self.whole(time, y, v))

    def places(self, time: Array, y: Array, v: Array) -> tuple[Array, Array]:
        """Values and rates (n, paths) of all paths."""
        state = self.state(time, y, v)
        motions = [path.over(self.sprung, state) for path in self.paths]
        return np.stack([path.value for path in motions], axis=1), np.stack([path.rate for path in motions], axis=1)

    def linearised(self, time: Array, y: Array, v: Array, a: Array, segments: Indices) -> Linearised:
        state, n, start = self.state(time, y, v), self.size, self.body_start
        forces = self._forces(time, y, v, segments, self.body_forces(time, segments, state))
        by_time = self._by_time(time, y, v, segments, state, forces)
        left, mass = forces.force[:, :n] - a @ self.mass, self.mass
        stiffness, damping = forces.stiffness[:, :n, :n], forces.damping[:, :n, :n]
        varying = self._varying_inertia(state, a)
        if varying is not None:
            bodies, whole = n - start, ((0, 0), (start, 0), (start, 0))  # the drive train's coordinates have constant inertia
            by_place, by_rate, by_acceleration = (np.pad(matrix[:, :bodies, :bodies], whole) for matrix in varying[1:])
            left = left - np.pad(varying.force[:, :bodies], whole[:2])
            stiffness, damping, mass = stiffness + by_place, damping + by_rate, mass + by_acceleration
            if self.crank is not None:
                by_time = by_time - varying.by_place[:, :bodies, -1] * self.crank.speed
        return Linearised(left, stiffness, damping, mass, by_time)

    def _varying_inertia(self, state: BodyState, a: Array) -> VaryingInertia | None:
        """Inertia forces of the bodies' free coordinates that the mass matrix leaves out, those of a held crank too."""
        if self.sprung.geometry.constant_mass:
            return None
        of_crank = np.zeros((len(a), self.sprung.free - self.size + self.body_start))  # a held crank has no acceleration
        return self.sprung.varying_inertia(state, np.concatenate([a[:, self.body_start :], of_crank], axis=1))

    def _by_time(self, time: Array, y: Array, v: Array, segments: Indices, state: BodyState, forces: SpringForces) -> Array:
        """Derivative (n, size) of the forces by time."""
        if self.crank is not None:
            return np.asarray(-forces.stiffness[:, : self.size, -1] * self.crank.speed)
        assert self.train is not None
        by_time = np.zeros_like(y)
        if self.train.timed:
            for mode, rows in self._by_mode(segments):
                states = y[rows], v[rows]
                before, after = (self.train.pushes(mode, time[rows] + step, *states) for step in (-INSTANT, INSTANT))
                by_time[rows] += (after - before) / (2 * INSTANT)
        for number, law in enumerate(self.driven.forces):
            if law.time is not None:
                path = self.paths[law.row].over(self.sprung, state)
                before, after = (self._law_values(law, number, segments, time + step, path)[0] for step in (-INSTANT, INSTANT))
                by_time[:, self.body_start :] += (after - before)[:, None] / (2 * INSTANT) * path.gradient
        return by_time

    def _forces(self, time: Array, y: Array, v: Array, segments: Indices, bodies: SpringForces, held: bool = True) -> SpringForces:
        """Forces on all unknown coordinates, and on that of a held crank, of those of the bodies; where not ``held``, those that act on
        sides that hold each other, too."""
        if self.train is None:
            return bodies
        count, (force, stiffness, damping) = self.body_start, (np.zeros((len(y), *(self.size,) * (part.ndim - 1))) for part in bodies)
        force[:, count:], stiffness[:, count:, count:], damping[:, count:, count:] = bodies
        for mode, rows in self._by_mode(segments):
            parts = (force[rows], stiffness[rows], damping[rows])
            self.train.add(mode, time[rows], y[rows], v[rows], parts, held=held)
            force[rows], stiffness[rows], damping[rows] = parts
        return SpringForces(force, stiffness, damping)

    def _by_mode(self, segments: Indices) -> list[tuple[TrainMode, Any]]:
        """The modes of the drive train at n states in segments, and which of the states are in each."""
        if len(self.modes) <= 1:
            return [(self.mode(0), slice(None))]
        segments_of: dict[TrainMode, list[int]] = {}
        for segment in np.unique(segments):
            segments_of.setdefault(self.mode(segment), []).append(segment)
        return [(mode, np.flatnonzero(np.isin(segments, of_mode))) for mode, of_mode in segments_of.items()]

    def body_forces(self, time: Array, segments: Indices, state: BodyState, derivatives: bool = True) -> SpringForces:
        """Forces on all free coordinates of the bodies, the crank's last; without those of the drive train."""
        force, stiffness, damping = self.sprung.spring_forces(state, derivatives)
        if self.friction is not None:
            rubbing = self.friction.forces(state, derivatives)
            force += rubbing.force
            if derivatives:
                stiffness += rubbing.stiffness
                damping += rubbing.damping
        seen: dict[tuple[int, tuple[int, ...]], tuple[Indices, BodyState, PathMotion]] = {}  # members of a joint have one path
        for number, law in enumerate(self.all_forces):
            on = tuple(int(segment) for segment in np.unique(segments) if self.segments[segment][number] is not None)
            if not on:
                continue
            if (law.row, on) not in seen:
                rows = np.flatnonzero(np.isin(segments, on))
                part = state if len(rows) == len(segments) else some_of(state, rows)
                seen[law.row, on] = rows, part, self.paths[law.row].over(self.sprung, part)
            rows, part, path = seen[law.row, on]
            values, by_place, by_rate = self._law_values(law, number, segments[rows], time[rows], path)
            force[rows] += values[:, None] * path.gradient
            if not derivatives:
                continue
            outer = path.gradient[:, :, None] * path.gradient[:, None, :]
            stiffness[rows] -= by_place[:, None, None] * outer + values[:, None, None] * path.bend
            if by_rate.any():
                rates = self.sprung.free_rates(part.rates)
                turned = np.matmul(path.bend, rates[:, :, None]).transpose(0, 2, 1)
                stiffness[rows] -= by_rate[:, None, None] * path.gradient[:, :, None] * turned
                damping[rows] -= by_rate[:, None, None] * outer
        return SpringForces(force, stiffness, damping)

    def path_forces(self, time: Array, segments: Indices, state: BodyState) -> list[tuple[Array, Array]]:
        """Of each load, then of each contact, the force along its path (n,) [N], and the rate of the path (n,) [m/s]."""
        forces = []
        for number, law in enumerate(self.all_forces):
            path = self.paths[law.row].over(self.sprung, state)
            forces.append((self._law_values(law, number, segments, time, path)[0], path.rate))
        return forces

    def _law_values(
        self, law: GeneralizedForce, number: int, segments: Indices, time: Array, path: PathMotion
    ) -> tuple[Array, Array, Array]:
        """Force (n,) of a load where its path is so, and its slopes by place and rate."""
        values, by_place, by_rate = np.zeros(len(segments)), np.zeros(len(segments)), np.zeros(len(segments))
        for segment in np.unique(segments):
            interval = self.segments[segment][number]
            if interval is None:
                continue
            rows = segments == segment
            if isinstance(interval, TimeSpan):
                assert law.time is not None
                # At the span's ends rounding would tell otherwise: the force is asked on its own side of them.
                values[rows] = law.time(np.clip(time[rows], interval.begin + INSTANT, interval.end - INSTANT))
                continue
            values[rows], by_place[rows], by_rate[rows] = _values(interval, path.value[rows] - law.datum, path.rate[rows])
            if interval.one_sided and not 0 <= number - len(self.driven.forces) < len(self.sprung.open_pins):
                for part in (by_place, by_rate, values):
                    part[rows] *= interval.sense * values[rows] > 0
        return values, by_place, by_rate

    def event(self, knot: int, time: float, y: Array, v: Array) -> tuple[float, Array, float]:
        assert self.events is not None
        event = self.events[knot]
        if isinstance(event, Release):
            return self._contact_force(event.force, knot, time, y, v)
        if isinstance(event, TrainEvent):
            times = time + INSTANT * np.arange(-1.0, 2.0)
            margin, gradient = self.train_margin(event, self.mode(knot - 1), times, np.tile(y, (3, 1)), np.tile(v, (3, 1)))
            return float(margin[1]), gradient[1], float(margin[2] - margin[0]) / (2 * INSTANT)
        path, value = event
        if path == CRANK_ANGLE:
            gradient = np.zeros(2 * self.size)
            gradient[self.size - 1] = 1.0
            return float(y[-1] - value), gradient, 0.0
        motion = self.paths[path].over(self.sprung, self.state(np.array([time]), y[None], v[None]))
        gradient = np.concatenate([self._of_unknowns(motion.gradient[0]), np.zeros(self.size)])
        return float(motion.value[0] - value), gradient, self._with_the_crank(motion.gradient[0])

    def _of_unknowns(self, gradient: Array) -> Array:
        """A gradient (size,) by the unknown coordinates, of that (f,) by the bodies' free ones."""
        return np.concatenate([np.zeros(self.body_start), gradient])[: self.size]

    def _with_the_crank(self, gradient: Array) -> float:
        """Derivative by time of what has this gradient (f,) by the free coordinates, where the crank goes its prescribed way."""
        return 0.0 if self.crank is None else float(gradient[-1] * self.crank.speed)

    def _contact_force(self, number: int, knot: int, time: float, y: Array, v: Array) -> tuple[float, Array, float]:
        """Force of a contact that acts before a knot, or comes back there, its gradient (2 size,) by state and rate, and its derivative
        by time."""
        law = self.all_forces[number]
        free, rates = self.whole(np.array([time]), y[None], v[None])
        path = self.paths[law.row].over(self.sprung, self.sprung.state(free, rates))
        interval, place = self.lost.get(number, self.segments[knot - 1][number]), path.value - law.datum
        if interval is None:  # lost before, in a motion of several segments
            interval = next((interval for interval in law.rising if interval.lower < place[0] <= interval.upper), law.rising[0])
        assert isinstance(interval, ForceInterval)
        value, by_place, by_rate = _values(interval, place, path.rate)
        gradient = by_place[0] * path.gradient[0] + by_rate[0] * (path.bend[0] @ rates[0])
        by_state = np.concatenate([self._of_unknowns(gradient), self._of_unknowns(by_rate[0] * path.gradient[0])])
        return float(value[0]), by_state, self._with_the_crank(gradient)

    # ---------------------------------------------------------------------------------------------------------------------- drive train

    def train_margin(self, event: TrainEvent, mode: TrainMode, time: Array, y: Array, v: Array) -> tuple[Array, Array]:
        """How far (n,) an event of the drive train is away, positive in the mode, and its gradient (n, 2 size) by state and rate."""
        assert self.train is not None
        if event.kind != "slips":
            slopes, constant = self.train.margin(event, mode, self.direction, self.size)
            return np.concatenate([y, v], axis=1) @ slopes + constant, np.tile(slopes, (len(y), 1))
        coupling, (torque, by_place, by_rate) = self.train.coupling(event.side), self.held_torque(event, time, y, v)
        assert coupling is not None
        gradient = -np.sign(torque)[:, None] * np.concatenate([by_place, by_rate], axis=1)
        return np.asarray(mode.coupling(event.side).capacity(coupling, time) - np.abs(torque)), gradient

    def held_torque(self, event: TrainEvent, time: Array, y: Array, v: Array) -> tuple[Array, Array, Array]:
        """Torque (n,) on the crank of the coupling that holds and may slip [N m], in the mode of the only segment, and its derivatives
        (n, size) by coordinates and rates."""
        assert self.train is not None
        segments = np.zeros(len(time), dtype=int)
        bodies = self.body_forces(time, segments, self.state(time, y, v))
        force, stiffness, damping = self._forces(time, y, v, segments, bodies)
        inverse = np.linalg.inv(self.mass)
        acceleration = [force @ inverse, -np.matmul(inverse, stiffness), -np.matmul(inverse, damping)]
        if event.side == "clutch":
            torque, inertia = self.train.torque(self.mode(0), time, y, v), self.train.inertia
            slopes = self.train.torque_slopes(self.mode(0), time, y, v)
            by_inertia = [inertia * acceleration[0][:, -1], inertia * acceleration[1][:, -1], inertia * acceleration[2][:, -1]]
            return torque - by_inertia[0], slopes.by_place - by_inertia[1], slopes.by_rate - by_inertia[2]
        force, stiffness, damping = self._forces(time, y, v, segments, bodies, held=False)
        row = self.whole_mass[-1]
        return (
            acceleration[0] @ row - force[:, -1],
            np.matmul(row, acceleration[1]) + stiffness[:, -1],
            np.matmul(row, acceleration[2]) + damping[:, -1],
        )

    def shaft_speed(self, time: Array, y: Array, v: Array) -> Array:
        """(n,) speed of the shaft with flywheel and drive [rad/s]."""
        return self.whole(time, y, v)[1][:, -1] if self.train is None else self.train.shaft_speed(v)

    def driving(self, time: Array, y: Array, v: Array, a: Array, segments: Indices, state: BodyState) -> Driving:
        """What turns the crank, at n states."""
        if self.train is None:
            varying = self._varying_inertia(state, a)
            torque = np.asarray(a @ self.whole_mass[-1, :-1] - self.body_forces(time, segments, state, derivatives=False).force[:, -1])
            torque = torque if varying is None else torque + varying.force[:, -1]
            assert self.crank is not None
            return Driving(torque, torque, np.full(len(time), self.crank.speed), np.zeros(len(time)))
        torque, motor, lost = np.zeros((3, len(time)))
        for mode, rows in self._by_mode(segments):
            states = time[rows], y[rows], v[rows]
            torque[rows], motor[rows] = self.train.torque(mode, *states), self.train.motor_torque(mode, *states)
            lost[rows] = self.train.lost(mode, time[rows], v[rows])
        return Driving(torque, motor, self.train.shaft_speed(v), lost)

    def drive_states(self, v: Array) -> Array:
        """(k, n) the drive's own states, of rates (n, size)."""
        return np.array(() if self.train is None else self.train.states(v)).reshape(-1, len(v))


class Driving(NamedTuple):
    """What turns the crank, at n states.

    Attributes:
        torque: (n,) on the crank that holds its speed, or that of the drive [N m].
        motor: (n,) at the motor's own shaft [N m].
        speed: (n,) of the drive's shaft [rad/s].
        lost: (n,) power lost in clutch and brake [W].
    """

    torque: Array
    motor: Array
    speed: Array
    lost: Array


def _values(interval: ForceInterval, place: Array, rate: Array) -> tuple[Array, Array, Array]:
    """Force (n,) of an interval, and its slopes by place and rate."""
    force, extent = interval.force, interval.upper - interval.lower
    by_place = _slope(lambda places: force(places, rate), place, extent if np.isfinite(extent) else 1e-3)
    by_rate = np.zeros(len(rate))
    if interval.heeds_velocity:  # its slope is found with steps for 1 mm/s at least
        by_rate = _slope(lambda rates: force(place, rates), rate, max(1e-3, float(np.abs(rate).max())))
    return np.broadcast_to(force(place, rate), place.shape), by_place, by_rate


def _slope(law: Callable[[Array], Any], places: Array, size: float) -> Array:
    """Slope of a law by a central difference."""
    step = 1e-6 * size
    return np.asarray((np.asarray(law(places + step)) - np.asarray(law(places - step))) / (2 * step) + 0.0 * places)
