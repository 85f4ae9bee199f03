"""The events that end a mode of a `HybridSystem`: each with its margin and with the mode that follows.

A margin is positive in the mode; the event occurs where it falls below zero.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from ..common.quantities import Array
from ..drives.transmission import SwitchPoint
from ..loads.process import ForceInterval
from .coupling import HOLDING, OPEN, Side
from .failures import failure
from .hybrid_system import (
    ForceMode,
    HybridSystem,
    Mode,
    Snapshot,
    force_mode,
)
from .trajectory import INTEGRALS

SHAFT = -len(INTEGRALS) - 1  # place of the speed of a clutch's driving side in the vector
SIDES: tuple[Side, ...] = ("clutch", "brake")


class Event(ABC):
    """An event that ends a mode.

    Attributes:
        rank: of events at the same instant that with the lowest comes first. At rest the stop of the crank decides what happens.
    """

    rank: ClassVar[int] = 3

    @abstractmethod
    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
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
    found: list[Event] = []
    if not mode.rests:
        for k, place in enumerate(mode.forces):
            if place is not None:
                found += _force_events(system, k, place)
    with_crank = mode.way is not None and mode.clutch.grip is HOLDING  # the shaft passes standstill as the crank stops
    for k, (corner, side) in enumerate(zip(system.driven.corners, mode.sides, strict=True)):
        if corner or not with_crank:
            found.append(CornerPassed(k, corner, side))
    for side in SIDES:
        switch = mode.coupling(side).next_switch(getattr(system.driven, side))
        if switch is not None:
            found.append(CouplingSwitched(side, switch, mode.coupling(side).way))
        if side == "clutch" and system.driven.clutch is not None and mode.clutch.grip is not OPEN:
            found.append(ClutchSlips() if mode.clutch.grip is HOLDING else ClutchGrips())
    if mode.way is not None:
        found.append(PressStarts(system.starting(mode, y, 1), system.starting(mode, y, -1)) if mode.rests else CrankStops())
    return tuple(found)


def margins_of(events: Sequence[Event], system: HybridSystem, mode: Mode, time: float, y: Array) -> list[float]:
    """The margins of events at a time and vector."""
    at = system.at(y)
    return [event.margin(system, mode, time, y, at) for event in events]


def _force_events(system: HybridSystem, k: int, place: ForceMode) -> list[Event]:
    force, found = system.driven.forces[k], list[Event]()
    if math.isfinite(place.low):
        found.append(BorderPassed(k, force.row, place.low, upwards=False))
    if math.isfinite(place.high):
        found.append(BorderPassed(k, force.row, place.high, upwards=True))
    if force.rising is not force.falling:
        found.append(CoordinateTurns(k, force.row, place.rising))
    if place.interval is not None and place.interval.one_sided:
        found.append(ContactChanges(k, force.row, force.datum, place.interval, place.pushing))
    return found


# ------------------------------------------------------------------------------------------------------------------------- forces and drive


@dataclass(frozen=True, eq=False, slots=True)
class BorderPassed(Event):
    """The coordinate of a force leaves the interval between two of its borders.

    Attributes:
        force: index of the force.
        row: of its coordinate.
        border: value of the coordinate that is passed [m].
        upwards: whether it is passed with a rising coordinate.
    """

    force: int
    row: int
    border: float
    upwards: bool

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        value: float = at.linkage.coordinates[self.row][0]
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
    """The coordinate of a force that depends on its direction turns back: at a dead centre, or where the crank itself stops.

    Attributes:
        force: index of the force.
        row: of its coordinate.
        rising: whether the coordinate has risen so far.
    """

    rank = 2
    force: int
    row: int
    rising: bool

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        rate: float = at.linkage.coordinates[self.row][1]
        return rate if self.rising else -rate

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        force, place, (value, rate) = system.driven.forces[self.force], mode.forces[self.force], system.at(y).linkage.coordinates[self.row]
        assert place is not None
        inside = 0.5 * (max(place.low, value - 1.0) + min(place.high, value + 1.0))
        return mode.with_force(self.force, force_mode(force, inside, not place.rising, value, rate)), y


@dataclass(frozen=True, eq=False, slots=True)
class ContactChanges(Event):
    """A one-sided force would begin to pull, or begins to push again.

    Attributes:
        force: index of the force.
        row: of its coordinate.
        datum: value of the coordinate from which the interval counts [m].
        interval: that acts.
        pushing: whether the force has pushed so far.
    """

    force: int
    row: int
    datum: float
    interval: ForceInterval
    pushing: bool

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        value, rate = at.linkage.coordinates[self.row]
        law = self.interval.sense * float(self.interval.force(value - self.datum, rate))
        return law if self.pushing else -law

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        place = mode.forces[self.force]
        assert place is not None
        return mode.with_force(self.force, place._replace(pushing=not place.pushing)), y


@dataclass(frozen=True, eq=False, slots=True)
class CornerPassed(Event):
    """The drive's shaft passes a speed at which its torque is not smooth.

    Attributes:
        corner: index of the corner.
        speed: of the shaft there [rad/s].
        side: +1 where the shaft has been faster so far, else -1.
    """

    corner: int
    speed: float
    side: int

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        return self.side * (at.shaft_speed - self.speed)

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        return mode._replace(sides=tuple(-side if k == self.corner else side for k, side in enumerate(mode.sides))), y


# ------------------------------------------------------------------------------------------------------------------------- clutch and brake


@dataclass(frozen=True, eq=False, slots=True)
class CouplingSwitched(Event):
    """A clutch or brake closes, or opens for good, at its time or angle.

    Attributes:
        side: which of the two.
        when: its time or angle.
        way: +1 or -1, direction in which the crank has to pass that angle.
    """

    side: Side
    when: SwitchPoint
    way: int

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        past = time - self.when.time if self.when.time is not None else (at.linkage.angle - (self.when.angle or 0.0)) * self.way
        return -past

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        at, opens = system.at(y), getattr(system.driven, self.side).opens
        relative = (at.shaft_speed if self.side == "clutch" else 0.0) - at.linkage.speed
        way = 1 if opens is None or opens.angle is None or opens.angle > at.linkage.angle else -1
        switched = mode.coupling(self.side).switched(relative, time, way)
        return system.going_on(mode.with_coupling(self.side, switched), time, y), y


@dataclass(frozen=True, eq=False, slots=True)
class ClutchGrips(Event):
    """Both sides of a slipping clutch have come to the same speed."""

    rank = 1

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        return float(mode.clutch.sign * (at.shaft_speed - at.linkage.speed))

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        y = y.copy()
        y[SHAFT] = system.at(y).linkage.speed
        return system.going_on(mode._replace(clutch=mode.clutch._replace(grip=HOLDING)), time, y), y


@dataclass(frozen=True, eq=False, slots=True)
class ClutchSlips(Event):
    """A holding clutch would have to transmit more than it can."""

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        return system.clutch_reserve(mode, time, at)

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        return system.clutch_slips(mode, time, y), y


# ------------------------------------------------------------------------------------------------------------------------ rest of the crank


@dataclass(frozen=True, eq=False, slots=True)
class CrankStops(Event):
    """The crank comes to rest: it rests, starts again or turns back."""

    rank = 0

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        return (mode.way or 0) * float(at.linkage.speed)

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
    """What holds the crank at rest is overcome in one direction.

    Attributes:
        forward: mode in which it starts forward.
        back: mode in which it starts back.
    """

    forward: Mode
    back: Mode

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        rising, falling = system.tending(self.forward, time, y), -system.tending(self.back, time, y)
        return system.holding(rising, falling) - max(rising, falling)

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        rising, falling = system.tending(self.forward, time, y), -system.tending(self.back, time, y)
        return self.forward if rising > falling else self.back, y
