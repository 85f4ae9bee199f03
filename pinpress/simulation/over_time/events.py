"""The events that end a mode of a `HybridSystem`: each with its margin and with the mode that follows, and which comes first.

A margin is positive in the mode; the event occurs where it falls below zero.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np
from scipy.optimize import brentq

from ...common.quantities import Array
from ...drives.transmission import SwitchPoint
from ...loads.process import ForceInterval
from ..coupling import HOLDING, OPEN, Side
from ..failures import failure
from ..trajectory import INTEGRALS
from .hybrid_system import HybridSystem, Mode, Snapshot, force_mode

SHAFT = -len(INTEGRALS) - 1  # place of the speed of a clutch's driving side in the vector


class Event(ABC):
    """An event that ends a mode.

    Attributes:
        rank: of events at the same instant that with the lowest comes first. At rest the stop of the crank decides what happens.
    """

    rank: ClassVar[int] = 3

    @abstractmethod
    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, snapshot: Snapshot) -> float:
        """How far the event is away: positive in the mode, below zero once it has occurred."""

    @abstractmethod
    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        """Mode and vector after the event.

        Args:
            system: in which it occurs.
            mode: that it ends.
            time: at which it occurs [s].
            y: the vector at this time.

        Raises:
            SimulationError: the press stalls.
        """


def ending_events(system: HybridSystem, mode: Mode, y: Array) -> tuple[Event, ...]:
    """All events that may end a mode which begins with a vector."""
    events: list[Event] = []
    for k, (force, place) in enumerate(zip(system.driven.forces, mode.forces, strict=True)):
        if mode.rests or place is None:
            continue
        if math.isfinite(place.low):
            events.append(BorderPassed(k, force.row, place.low, upwards=False))
        if math.isfinite(place.high):
            events.append(BorderPassed(k, force.row, place.high, upwards=True))
        if force.rising is not force.falling:
            events.append(CoordinateTurns(k, force.row, place.rising))
        if place.interval is not None and place.interval.one_sided:
            events.append(ContactChanges(k, force.row, force.datum, place.interval, place.pushing))
    with_crank = mode.way is not None and mode.clutch.grip is HOLDING  # the shaft passes standstill as the crank stops
    for k, (corner, above) in enumerate(zip(system.driven.corners, mode.sides, strict=True)):
        if corner or not with_crank:
            events.append(CornerPassed(k, corner, above))
    sides: tuple[Side, ...] = ("clutch", "brake")
    for side in sides:
        switch = mode.coupling(side).next_switch(getattr(system.driven, side))
        if switch is not None:
            events.append(CouplingSwitched(side, switch, mode.coupling(side).way))
        if side == "clutch" and system.driven.clutch is not None and mode.clutch.grip is not OPEN:
            events.append(ClutchSlips() if mode.clutch.grip is HOLDING else ClutchGrips())
    if mode.way is not None:
        events.append(PressStarts(system.starting(mode, y, 1), system.starting(mode, y, -1)) if mode.rests else CrankStops())
    return tuple(events)


# ------------------------------------------------------------------------------------------------------------------------- forces and drive


@dataclass(frozen=True, eq=False, slots=True)
class BorderPassed(Event):
    """The coordinate of a force leaves the interval between two of its borders."""

    force: int  # index of the force
    row: int  # of its coordinate
    border: float  # value of the coordinate that is passed [m]
    upwards: bool  # whether it is passed with a rising coordinate

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, snapshot: Snapshot) -> float:
        value: float = snapshot.linkage.coordinates[self.row][0]
        return self.border - value if self.upwards else value - self.border

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        force, place = system.driven.forces[self.force], mode.forces[self.force]
        assert place is not None
        if self.upwards:
            following = min((b for b in force.borders() if b > self.border), default=self.border + 1.0)
        else:
            following = max((b for b in force.borders() if b < self.border), default=self.border - 1.0)
        rate = system.at(y).linkage.coordinates[self.row][1]
        place = force_mode(force, 0.5 * (self.border + following), place.rising, self.border, rate)
        return mode.with_force(self.force, place), y


@dataclass(frozen=True, eq=False, slots=True)
class CoordinateTurns(Event):
    """The coordinate of a force that depends on its direction turns back: at a dead centre, or where the crank itself stops."""

    rank = 2
    force: int  # index of the force
    row: int  # of its coordinate
    rising: bool  # whether the coordinate has risen so far

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, snapshot: Snapshot) -> float:
        rate: float = snapshot.linkage.coordinates[self.row][1]
        return rate if self.rising else -rate

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        force, place, (value, rate) = system.driven.forces[self.force], mode.forces[self.force], system.at(y).linkage.coordinates[self.row]
        assert place is not None
        inside = 0.5 * (max(place.low, value - 1.0) + min(place.high, value + 1.0))
        return mode.with_force(self.force, force_mode(force, inside, not place.rising, value, rate)), y


@dataclass(frozen=True, eq=False, slots=True)
class ContactChanges(Event):
    """A one-sided force would begin to pull, or begins to push again."""

    force: int  # index of the force
    row: int  # of its coordinate
    datum: float  # value of the coordinate from which the interval counts [m]
    interval: ForceInterval  # that acts
    pushing: bool  # whether the force has pushed so far

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, snapshot: Snapshot) -> float:
        value, rate = snapshot.linkage.coordinates[self.row]
        law = self.interval.sense * float(self.interval.force(value - self.datum, rate))
        return law if self.pushing else -law

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        place = mode.forces[self.force]
        assert place is not None
        return mode.with_force(self.force, place._replace(pushing=not place.pushing)), y


@dataclass(frozen=True, eq=False, slots=True)
class CornerPassed(Event):
    """The drive's shaft passes a speed at which its torque is not smooth."""

    corner: int  # index of the corner
    speed: float  # of the shaft there [rad/s]
    side: int  # +1 where the shaft has been faster so far, else -1

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, snapshot: Snapshot) -> float:
        return self.side * (snapshot.shaft_speed - self.speed)

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        return mode._replace(sides=tuple(-side if k == self.corner else side for k, side in enumerate(mode.sides))), y


# ------------------------------------------------------------------------------------------------------------------------- clutch and brake


@dataclass(frozen=True, eq=False, slots=True)
class CouplingSwitched(Event):
    """A clutch or brake closes, or opens for good, at its time or angle."""

    side: Side  # which of the two
    when: SwitchPoint  # its time or angle
    way: int  # +1 or -1, direction in which the crank has to pass that angle

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, snapshot: Snapshot) -> float:
        past = time - self.when.time if self.when.time is not None else (snapshot.linkage.angle - (self.when.angle or 0.0)) * self.way
        return -past

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        snapshot, opens = system.at(y), getattr(system.driven, self.side).opens
        relative = (snapshot.shaft_speed if self.side == "clutch" else 0.0) - snapshot.linkage.speed
        way = 1 if opens is None or opens.angle is None or opens.angle > snapshot.linkage.angle else -1
        switched = mode.coupling(self.side).switched(relative, time, way)
        return system.going_on(mode.with_coupling(self.side, switched), time, y), y


@dataclass(frozen=True, eq=False, slots=True)
class ClutchGrips(Event):
    """Both sides of a slipping clutch have come to the same speed."""

    rank = 1

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, snapshot: Snapshot) -> float:
        return float(mode.clutch.sign * (snapshot.shaft_speed - snapshot.linkage.speed))

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        y = y.copy()
        y[SHAFT] = system.at(y).linkage.speed
        return system.going_on(mode._replace(clutch=mode.clutch._replace(grip=HOLDING)), time, y), y


@dataclass(frozen=True, eq=False, slots=True)
class ClutchSlips(Event):
    """A holding clutch would have to transmit more than it can."""

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, snapshot: Snapshot) -> float:
        return system.clutch_reserve(mode, time, snapshot)

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        return system.clutch_slips(mode, time, y), y


# ------------------------------------------------------------------------------------------------------------------------ rest of the crank


@dataclass(frozen=True, eq=False, slots=True)
class CrankStops(Event):
    """The crank comes to rest: it rests, starts again or turns back."""

    rank = 0

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, snapshot: Snapshot) -> float:
        return (mode.way or 0) * float(snapshot.linkage.speed)

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        linkage = system.at(y).linkage
        if not system.dynamics.stands(linkage):  # at a lock the links go on, and take the crank back
            if mode.brake.grip is not OPEN:
                raise failure("stops at a lock", time, linkage.angle)
            return system.turning(mode, -(mode.way or 0)), y
        n, rest = system.dynamics.size, y.copy()
        rest[n : 2 * n] = 0.0
        if system.driven.clutch is not None and mode.clutch.grip is HOLDING:
            rest[SHAFT] = 0.0
        return system.going_on(mode, time, rest), rest


@dataclass(frozen=True, eq=False, slots=True)
class PressStarts(Event):
    """What holds the crank at rest is overcome in one direction."""

    forward: Mode  # mode in which it starts forward
    back: Mode  # mode in which it starts back

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, snapshot: Snapshot) -> float:
        rising, falling = system.tending(self.forward, time, y), -system.tending(self.back, time, y)
        return system.holding(rising, falling) - max(rising, falling)

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        rising, falling = system.tending(self.forward, time, y), -system.tending(self.back, time, y)
        return self.forward if rising > falling else self.back, y


# ----------------------------------------------------------------------------------------------------------------------- first crossing


class EventFinder:
    """Finds the first event in the steps of a mode, one step after the other."""

    def __init__(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> None:
        self.system, self.mode = system, mode
        self.events = ending_events(system, mode, y)
        self.margins = self._margins(time, y) if self.events else []

    def _margins(self, time: float, y: Array) -> list[float]:
        snapshot = self.system.at(y)
        return [event.margin(self.system, self.mode, time, y, snapshot) for event in self.events]

    def first(self, piece: Callable[[float], Array], start: float, end: float) -> tuple[Event | None, float]:
        """The first event of a step and its time; None and the step's end where there is none. `margins` are then those at the last place
        that was checked."""
        if not self.events:
            return None, end
        since = start
        for share in (0.25, 0.5, 0.75, 1.0):
            time = end if share == 1.0 else start + share * (end - start)
            before, self.margins = self.margins, self._margins(time, piece(time))
            fallen = [k for k, margin in enumerate(self.margins) if margin < 0]
            if fallen:
                first, when = self._first_of(piece, since, before, time, fallen)
                return self.events[first], when
            since = time
        return None, end

    def _first_of(
        self, piece: Callable[[float], Array], since: float, before: list[float], until: float, fallen: list[int]
    ) -> tuple[int, float]:
        """Index and time of the first of the events whose margins have fallen below zero within a part of a step.

        Args:
            piece: the vector over the step.
            since: start of the part [s].
            before: margins there.
            until: end of the part [s].
            fallen: indices of the events whose margins are below zero there.
        """

        def margins(t: float) -> list[float]:  # with the loops closed, as the run goes on from there: a stiff force needs all digits
            return self._margins(t, self.system.project(t, piece(t)))

        def margin(k: int, t: float) -> float:
            y = self.system.project(t, piece(t))
            size = self.events[k].margin(self.system, self.mode, t, y, self.system.at(y))
            if math.isnan(size):
                raise self.system.cannot_go_on(t, y)
            return size

        first, rounding = (fallen[0], until), 8 * float(np.finfo(float).eps) * max(abs(until), abs(since))
        for _ in range(len(self.events) + 1):
            crossings = [(_crossing(partial(margin, k), since, first[1], before[k]), k) for k in fallen]
            when, which = min(crossings, key=lambda crossing: crossing[0])
            which = min((k for time, k in crossings if time <= when + rounding), key=lambda k: (self.events[k].rank, k != which))
            if when > first[1] - rounding and first[1] != until:
                break
            first = which, when
            # an event whose margin fell and rose again within the step shows only at the other events; where two come at once, as where
            # an elastic force ends with its interval, the margin of one that has just switched is below zero by rounding
            fallen = [k for k, after in enumerate(margins(when)) if after < 0 and k != which and before[k] > 0]
            if when <= since or not fallen:
                break
        return self._contact_before(margin, since, before, first)

    def _contact_before(
        self, margin: Callable[[int, float], float], since: float, before: list[float], first: tuple[int, float]
    ) -> tuple[int, float]:
        """Index and time of a contact that changes shortly before the border at which it ends; of the ``first`` event where none does.

        At such a border the law is zero, so that a change near it shows at no place that was checked: a stop's spring may push
        again over the last depth, where its damper grows with a higher power of it, or the other way round. Other arguments as of
        `_first_of`.
        """
        which, when = first
        passed = self.events[which]
        if not isinstance(passed, BorderPassed):
            return first
        for k, event in enumerate(self.events):
            if isinstance(event, ContactChanges) and event.force == passed.force and before[k] > 0:
                looks = (when - 0.5**n * (when - since) for n in range(1, 24))
                changed = next((time for time in looks if margin(k, time) < 0), None)
                if changed is not None:
                    return k, _crossing(partial(margin, k), since, changed, before[k])
        return first


def _crossing(value: Callable[[float], float], since: float, until: float, low: float) -> float:
    """Time at which a function falls below zero that is ``low`` at the time ``since`` and negative at the time ``until``."""
    if low <= 0 or value(since) <= 0:  # it begins at zero: does it rise in between?
        shares = [0.5**k for k in range(1, 40)]
        risen = next((share for share in shares if value(since + share * (until - since)) > 0), None)
        if risen is None:
            return since
        since, until = since + risen * (until - since), since + 2 * risen * (until - since)
    if value(until) >= 0:
        return until
    # a smooth margin takes ten steps; where one is flat at its zero, as the force of an orifice is at rest, it takes hundreds
    return float(brentq(value, since, until, xtol=4e-16 * abs(until) + 1e-300, rtol=1e-15, maxiter=10_000))
