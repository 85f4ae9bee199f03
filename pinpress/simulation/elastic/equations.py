"""Equations of motion of a press on springs with its drive and its loads.

The loads are those of `driven_press`. Each acts along a path; which of its intervals acts is the same all through a segment of the motion:
`Segment`. A blank that is cut through stays cut until the press has turned, even where the slide rises again through the same heights while
the links ring, so that the direction of travel is that of the rigid press.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...common.quantities import Array
from ...loads.process import ForceInterval
from ..driven_press import DrivenPress, GeneralizedForce
from .load_paths import LoadPath
from .panels import Indices, VaryingInertia
from .press_on_springs import PathMotion
from .sprung_press import SprungPress

SLOW = 1e-3  # [m/s] speed below which the slope of a law by the speed is found with steps for this speed
STEP = 1e-6  # share of a load's extent, or of the size of a speed, by which its slope is found
INSTANT = 1e-9  # [s] with which slopes by time are found, and within which two times are one
CRANK_ANGLE = -1  # in place of a path's number


class TimeSpan(NamedTuple):
    """Times between which a force in time is smooth [s]."""

    begin: float
    end: float


Segment = tuple[ForceInterval | TimeSpan | None, ...]
"""The interval of each force that acts; None where none does."""


class Event(NamedTuple):
    """What ends a segment at a time that is not known before: a path reaches a border.

    Attributes:
        path: its number; `CRANK_ANGLE` for the angle of the crank.
        value: at the border [m or rad].
    """

    path: int
    value: float


class Release(NamedTuple):
    """What ends a contact: its force vanishes; or what brings it back before its bodies are apart.

    Attributes:
        force: number of the contact among all forces.
    """

    force: int


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
        segments: the forces that act in each segment.
        events: what happens at the knots whose times are free.
        contacts: of pins with clearance; they come after the loads.
        lost: laws of contacts whose bodies are not apart yet, but part too fast to push each other, by the numbers of their forces.
    """

    sprung: SprungPress
    driven: DrivenPress
    paths: tuple[LoadPath, ...]
    crank: HeldCrank | None
    segments: tuple[Segment, ...] = ()
    events: Mapping[int, Event | Release] | None = None
    contacts: tuple[GeneralizedForce, ...] = ()
    lost: Mapping[int, ForceInterval] = field(default_factory=dict)

    @property
    def all_forces(self) -> tuple[GeneralizedForce, ...]:
        """All loads, then the contacts."""
        return self.driven.forces + self.contacts

    @property
    def size(self) -> int:
        """Number of unknown coordinates."""
        return self.sprung.free - (self.crank is not None)

    @property
    def mass(self) -> Array:
        return self.whole_mass[: self.size, : self.size]

    @property
    def whole_mass(self) -> Array:
        """(f, f) mass matrix with flywheel and drive."""
        found = self.sprung.mass.copy()
        found[-1, -1] += float(self.driven.inertia)
        return found

    def varying_inertia(self, time: Array, y: Array, v: Array, a: Array) -> VaryingInertia | None:
        return None

    def whole(self, time: Array, y: Array, v: Array) -> tuple[Array, Array]:
        """Free coordinates and rates (n, f), that of the crank last, of the unknown ones (n, size)."""
        if self.crank is None:
            return y, v
        angle, speed = self.crank.angle + self.crank.speed * time, np.full(len(time), self.crank.speed)
        return np.column_stack([y, angle]), np.column_stack([v, speed])

    def forces(self, time: Array, y: Array, v: Array, segments: Indices) -> tuple[Array, Array, Array, Array]:
        force, stiffness, damping = self.whole_forces(time, y, v, segments)
        n = self.size
        return force[:, :n], stiffness[:, :n, :n], damping[:, :n, :n], self._by_time(time, y, v, segments, stiffness)

    def _by_time(self, time: Array, y: Array, v: Array, segments: Indices, stiffness: Array) -> Array:
        """Derivative (n, size) of the forces by time."""
        if self.crank is not None:
            return np.asarray(-stiffness[:, : self.size, -1] * self.crank.speed)
        drive, timed = self.driven.drive, any(law.time is not None for law in self.driven.forces)
        if not timed and (drive is None or not drive.timed):
            return np.zeros_like(y)
        before, _, _ = self.whole_forces(time - INSTANT, y, v, segments)
        after, _, _ = self.whole_forces(time + INSTANT, y, v, segments)
        return np.asarray((after - before) / (2 * INSTANT))

    def whole_forces(self, time: Array, y: Array, v: Array, segments: Indices) -> tuple[Array, Array, Array]:
        """Forces (n, f) on all free coordinates, the crank's last, and minus their derivatives by these coordinates and rates."""
        free, rates = self.whole(time, y, v)
        coordinates, all_rates = self.sprung.all_coordinates(free), rates @ self.sprung.carry.T
        force, stiffness, damping = self.sprung.spring_forces(coordinates, all_rates)
        assert stiffness is not None
        assert damping is not None
        for number, law in enumerate(self.all_forces):
            on = [segment for segment in np.unique(segments) if self.segments[segment][number] is not None]
            if not on:
                continue
            some = np.flatnonzero(np.isin(segments, on))
            path = self.paths[law.row].over(self.sprung, coordinates[some], all_rates[some])
            values, by_place, by_rate = self._law_values(law, number, segments[some], time[some], path)
            force[some] += values[:, None] * path.gradient
            outer = path.gradient[:, :, None] * path.gradient[:, None, :]
            stiffness[some] -= by_place[:, None, None] * outer + values[:, None, None] * path.bend
            if by_rate.any():
                turned = np.matmul(path.bend, rates[some, :, None]).transpose(0, 2, 1)
                stiffness[some] -= by_rate[:, None, None] * path.gradient[:, :, None] * turned
                damping[some] -= by_rate[:, None, None] * outer
        if self.crank is None:
            self._add_drive(rates[:, -1], free[:, -1], time, force, stiffness, damping)
        return force, stiffness, damping

    def load_forces(self, time: Array, segments: Indices, coordinates: Array, rates: Array) -> list[tuple[Array, Array]]:
        """Of each load its force along its path (n,) [N], and the rate of the path (n,) [m/s]."""
        found = []
        for number, law in enumerate(self.all_forces):
            path = self.paths[law.row].over(self.sprung, coordinates, rates)
            found.append((self._law_values(law, number, segments, time, path)[0], path.rate))
        return found

    def _law_values(
        self, law: GeneralizedForce, number: int, segments: Indices, time: Array, path: PathMotion
    ) -> tuple[Array, Array, Array]:
        """Force (n,) of a load where its path is so, and its slopes by place and rate."""
        values, by_place, by_rate = np.zeros(len(segments)), np.zeros(len(segments)), np.zeros(len(segments))
        for segment in np.unique(segments):
            interval = self.segments[segment][number]
            if interval is None:
                continue
            there = segments == segment
            if isinstance(interval, TimeSpan):
                values[there] = _at_time(law, interval, time[there])
                continue
            values[there], by_place[there], by_rate[there] = _values(interval, path.value[there] - law.datum, path.rate[there])
            if interval.one_sided and number < len(self.driven.forces):
                for each in (by_place, by_rate, values):
                    each[there] *= values[there] > 0
        return values, by_place, by_rate

    def _add_drive(self, speed: Array, angle: Array, time: Array, force: Array, stiffness: Array, damping: Array) -> None:
        drive = self.driven.drive
        if drive is None:
            return
        force[:, -1] += np.broadcast_to(drive.torque(speed, angle, time), speed.shape)
        damping[:, -1, -1] -= _slope(lambda w: drive.torque(w, angle, time), speed, float(np.abs(speed).max()) or 1.0)
        if drive.timed:
            stiffness[:, -1, -1] -= _slope(lambda at: drive.torque(speed, at, time), angle, 1.0)

    def event(self, knot: int, time: float, y: Array, v: Array) -> tuple[float, Array, float]:
        assert self.events is not None
        event = self.events[knot]
        if isinstance(event, Release):
            return self._contact_force(event.force, time, y, v)
        path, value = event
        if path == CRANK_ANGLE:
            gradient = np.zeros(2 * self.size)
            gradient[self.size - 1] = 1.0
            return float(y[-1] - value), gradient, 0.0
        free, rates = self.whole(np.array([time]), y[None], v[None])
        at = self.paths[path].over(self.sprung, self.sprung.all_coordinates(free), rates @ self.sprung.carry.T)
        gradient = np.concatenate([at.gradient[0, : self.size], np.zeros(self.size)])
        return float(at.value[0] - value), gradient, self._with_the_crank(at.gradient[0])

    def _with_the_crank(self, gradient: Array) -> float:
        """Derivative by time of what has this gradient (f,) by the free coordinates, where the crank goes its prescribed way."""
        return 0.0 if self.crank is None else float(gradient[-1] * self.crank.speed)

    def _contact_force(self, number: int, time: float, y: Array, v: Array) -> tuple[float, Array, float]:
        """Force of a contact that acts before an event, its gradient (2 size,) by state and rate, and its derivative by time."""
        law = self.all_forces[number]
        free, rates = self.whole(np.array([time]), y[None], v[None])
        path = self.paths[law.row].over(self.sprung, self.sprung.all_coordinates(free), rates @ self.sprung.carry.T)
        interval = self.lost.get(number, self.segments[-1][number])
        assert isinstance(interval, ForceInterval)
        value, by_place, by_rate = _values(interval, path.value - law.datum, path.rate)
        gradient = by_place[0] * path.gradient[0] + by_rate[0] * (path.bend[0] @ rates[0])
        by_state = np.concatenate([gradient[: self.size], by_rate[0] * path.gradient[0, : self.size]])
        return float(value[0]), by_state, self._with_the_crank(gradient)

    def crank_torque(self, time: Array, y: Array, v: Array, a: Array, segments: Indices) -> Array:
        """Torque (n,) on the crank that holds its speed, or that of the drive [N m]."""
        force, _, _ = self.whole_forces(time, y, v, segments)
        if self.crank is None:
            drive = self.driven.drive
            return np.zeros(len(time)) if drive is None else np.broadcast_to(drive.torque(v[:, -1], y[:, -1], time), time.shape)
        return np.asarray(a @ self.whole_mass[-1, :-1] - force[:, -1])


def _values(interval: ForceInterval, place: Array, rate: Array) -> tuple[Array, Array, Array]:
    """Force (n,) of an interval, and its slopes by place and rate."""
    force = interval.force
    by_place = _slope(partial(_by_place, force, rate), place, _extent(interval))
    by_rate = _slope(partial(force, place), rate, max(SLOW, float(np.abs(rate).max()))) if interval.heeds_velocity else np.zeros(len(rate))
    return np.broadcast_to(force(place, rate), place.shape), by_place, by_rate


def _slope(law: Callable[[Any], Any], at: Array, size: float) -> Array:
    """Slope of a law by a central difference."""
    step = STEP * size
    return np.asarray((np.asarray(law(at + step)) - np.asarray(law(at - step))) / (2 * step) + 0.0 * at)


def _at_time(law: GeneralizedForce, span: TimeSpan, time: Array) -> Array:
    """Force (n,) in time, on its own side of the span's ends where rounding would tell otherwise."""
    assert law.time is not None
    return np.asarray(law.time(np.clip(time, span.begin + INSTANT, span.end - INSTANT)) + 0.0 * time)


def _by_place(force: Callable[[Array, Array], Array], rate: Array, place: Array) -> Array:
    return force(place, rate)


def _extent(interval: ForceInterval) -> float:
    extent = interval.upper - interval.lower
    return float(extent) if np.isfinite(extent) else 1e-3
