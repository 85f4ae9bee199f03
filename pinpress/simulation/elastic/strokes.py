"""Which interval of each load acts, from one event to the next, while the links yield.

A load that acts one way alone, such as blanking, begins again with every stroke: it waits, acts between its borders, and once the slide has
passed the last of them it is through, even if the slide swings back. Its stroke ends where the rigid press turns. A load that acts both
ways, such as a cushion, acts wherever the slide is between its borders.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.quantities import Array
from ...loads.process import ForceInterval
from ..driven_press import DrivenPress, GeneralizedForce
from ..reduced_model import COORDINATES
from .press.drive import TrainEvent, TrainMode

INSTANT = 1e-9  # [s] with which slopes by time are found, and within which two times are one
AT_START = 1e-9  # angle from the start within which an event belongs to the start [rad]
CRANK_ANGLE = -1  # in place of a path's number


class TimeSpan(NamedTuple):
    """Times between which a force in time is smooth [s]."""

    begin: float
    end: float


Segment = tuple[ForceInterval | TimeSpan | None, ...]
"""The interval of each force that acts; None if none does."""


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


MotionEvent = Event | Release | TrainEvent
"""What ends a segment at a time that is not known before."""


@dataclass(frozen=True)
class Phase:
    """What acts, and what is over.

    Attributes:
        rising: whether the rigid slide rises.
        through: for each force, whether its stroke is over.
    """

    rising: bool
    through: tuple[bool, ...]


@dataclass(frozen=True, eq=False)
class Strokes:
    """The loads of a press over its turns.

    Attributes:
        driven: the press with its loads.
        direction: 1 where the crank turns forwards, else -1.
        contacts: of pins with clearance and of members of preloaded joints, on paths after those of the driven press, which the rigid
            press does not leave.
    """

    driven: DrivenPress
    direction: int
    contacts: tuple[GeneralizedForce, ...] = ()

    @property
    def forces(self) -> tuple[GeneralizedForce, ...]:
        """All forces, the contacts last."""
        return self.driven.forces + self.contacts

    @cached_property
    def one_way(self) -> tuple[bool, ...]:
        """For each force, whether it acts one way alone."""
        return tuple(force.rising is not force.falling for force in self.forces)

    @cached_property
    def borders(self) -> tuple[Event, ...]:
        """All places at which a force is not smooth."""
        borders = {Event(force.row, value) for force in self.forces for value in force.borders()}
        return tuple(sorted(borders))

    @cached_property
    def turnings(self) -> Array:
        """(k,) crank angles in a period at which the rigid slide turns; () where all loads act both ways."""
        return np.array([]) if self._row is None else np.sort(self.driven.model.roots(COORDINATES + self._row, slope=True))

    @cached_property
    def _row(self) -> int | None:
        """The path of the loads that act one way: that of the slide."""
        return next((force.row for force, one_way in zip(self.forces, self.one_way, strict=True) if one_way), None)

    def places(self, angle: float) -> Array:
        """(paths,) values of the paths of the rigid press at a crank angle [m]."""
        others = max((contact.row + 1 - len(self.driven.coordinates) for contact in self.contacts), default=0)
        return np.concatenate([self.driven.model.at(np.array(angle))[0][COORDINATES:], np.zeros(others)])

    def begin(self, angle: float) -> Phase:
        """The phase of a stroke in which nothing has happened yet, at a crank angle."""
        slope = 0.0 if self._row is None else float(self.driven.model.at(np.array(angle))[1][COORDINATES + self._row])
        return Phase(slope * self.direction > 0, (False,) * len(self.forces))

    def active(self, phase: Phase, places: Array, time: float = 0.0) -> Segment:
        """The intervals that act where the paths have the values ``places`` (paths,), from a time on [s]; see `Segment`."""
        return tuple(
            _span(force, time)
            if force.time is not None
            else None
            if over
            else _interval(force, phase.rising, float(places[force.row]) - force.datum)
            for force, over in zip(self.forces, phase.through, strict=True)
        )

    def interval_at(self, number: int, phase: Phase, places: Array) -> ForceInterval | None:
        """The interval of a force in which its path has its value of ``places`` (paths,), whether it pushes there or not."""
        force = self.forces[number]
        return _interval(force, phase.rising, float(places[force.row]) - force.datum)

    def advance(self, phase: Phase, places: Array) -> Phase:
        """The phase once the paths have the values ``places`` (paths,): loads whose last border is passed are through, and contacts that
        were lost can be struck again once their bodies are apart."""
        through = []
        for force, one_way, over in zip(self.forces, self.one_way, phase.through, strict=True):
            place = float(places[force.row]) - force.datum
            passed = _passed(force, phase.rising, place) if one_way else over and _interval(force, phase.rising, place) is not None
            through.append(over or passed if one_way else passed)
        return Phase(phase.rising, tuple(through))

    def release(self, phase: Phase, number: int) -> Phase:
        """The phase once the force of a contact vanishes, or comes back before its bodies are apart."""
        return Phase(phase.rising, tuple(over != (k == number) for k, over in enumerate(phase.through)))

    def along(self, start: float, places: Array, turned: Mapping[int, float]) -> list[Segment]:
        """The intervals that act at successive rows of places (n, paths), of a stroke that begins at a crank angle; ``turned``: the rows
        before which the rigid slide has turned, with crank angles past that."""
        phase, segments = self.begin(start), []
        for row, values in enumerate(places):
            phase = self.advance(self.begin(turned[row]) if row in turned else phase, values)
            segments.append(self.active(phase, values))
        return segments

    def plan(self, start: float) -> Plan:
        """The segments of a period of the rigid press from a crank angle on, at which it turns or no load acts."""
        period = self.driven.model.period
        assert period is not None
        stops: list[tuple[float, Event | None]] = [(ahead, None) for ahead in self.turnings_ahead(start)]
        for border in self.borders:
            if border.path < len(self.driven.coordinates):
                angles = self.driven.model.roots(COORDINATES + border.path, border.value)
                stops += [(self._ahead(angle, start), border) for angle in angles]
        stops = sorted((stop for stop in stops if AT_START < stop[0] < period - AT_START), key=lambda stop: stop[0])
        ends = np.array([0.0, *(ahead for ahead, _ in stops), period])
        middles = start + 0.5 * self.direction * (ends[:-1] + ends[1:])
        turned = {row: middles[row] for row, (_, border) in enumerate(stops, 1) if border is None}
        segments = self.along(middles[0], np.array([self.places(middle) for middle in middles]), turned)
        changes = [row for row in range(1, len(segments)) if segments[row] != segments[row - 1]]
        events: dict[int, MotionEvent] = {}
        for knot, row in enumerate(changes, 1):
            ahead, met = stops[row - 1]
            events[knot] = Event(CRANK_ANGLE, start + self.direction * ahead) if met is None else met
        return Plan(tuple(segments[row] for row in (0, *changes)), events, ends[[0, *changes, -1]])

    def crossed(self, places: Array) -> NDArray[np.bool_]:
        """(n,) whether a path passes a border on its way to a row of places (n, paths) from the one before."""
        paths, values = [border.path for border in self.borders], [border.value for border in self.borders]
        beyond = places[:, paths] > np.array(values)
        return np.append(False, (beyond[1:] != beyond[:-1]).any(axis=1))

    def turnings_ahead(self, start: float) -> Array:
        """How far the crank turns from ``start`` to each turning of a period, rising; one at the start itself is left out [rad]."""
        ahead = np.sort([self._ahead(angle, start) for angle in self.turnings])
        period = self.driven.model.period or np.inf
        return np.asarray(ahead[(ahead > AT_START) & (ahead < period - AT_START)])

    def _ahead(self, angle: float, start: float) -> float:
        """How far the crank turns from ``start`` to an angle of the period [rad]."""
        assert self.driven.model.period is not None
        return float((self.direction * (angle - start)) % self.driven.model.period)


class Plan(NamedTuple):
    """Segments between knots, and what happens there.

    Attributes:
        segments: the forces that act in each.
        events: what happens at each knot but the first and the last one.
        knots: how far the crank has turned at the knots [rad].
        modes: of the drive train in each segment; (): it is engaged all the time, and its torque does not jump.
    """

    segments: tuple[Segment, ...]
    events: Mapping[int, MotionEvent]
    knots: Array
    modes: tuple[TrainMode, ...] = ()

    @property
    def jumps(self) -> bool:
        """Whether the torque of the drive jumps."""
        return any(isinstance(event, TrainEvent) for event in self.events.values())


def crossing(before: float, after: float) -> float | None:
    """Share of the way at which what goes evenly from one value to another is zero; None if it is not."""
    return None if before * after > 0 or before == after else before / (before - after)


def _span(force: GeneralizedForce, time: float) -> TimeSpan:
    """The span between its edges in which a force in time acts from a time on."""
    borders = (-np.inf, *force.edges, np.inf)
    after = int(np.searchsorted(borders, time + INSTANT, side="right"))
    return TimeSpan(borders[after - 1], borders[after])


def _interval(force: GeneralizedForce, rising: bool, place: float) -> ForceInterval | None:
    return next((interval for interval in force.intervals(rising) if interval.lower < place <= interval.upper), None)


def _passed(force: GeneralizedForce, rising: bool, place: float) -> bool:
    """Whether a place lies beyond the last border of a force that acts one way."""
    intervals = force.intervals(rising)
    if not intervals:
        return False
    return place > max(interval.upper for interval in intervals) if rising else place <= min(interval.lower for interval in intervals)
