"""The events that end a mode of a `HybridSystem`: each with its margin and with the mode that follows.

A margin is positive in the mode; the event occurs where it falls below zero.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

from ..common.quantities import Array
from ..drives.transmission import Coupling, SwitchPoint
from ..loads.process import ForceInterval
from .hybrid_system import HOLDING, OPEN, SLIPPING, CouplingMode, ForceMode, HybridSystem, Mode, Side, Snapshot, force_mode, sign_of
from .trajectory import INTEGRALS

STARTS = 1e-9  # a press that stands starts with this share of the acceleration by the loads that hold it
AT_REST = 1e-9  # share of the run's largest crank speed: a slower crank has stopped


class Event(ABC):
    """An event that ends a mode."""

    @abstractmethod
    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        """How far the event is away: positive in the mode, below zero once it has occurred."""

    @abstractmethod
    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
        """Mode and vector after the event.

        Args:
            system: in which it occurs.
            mode: that it ends.
            time: at which it occurs [s].
            y: the vector at this time.
            fastest: largest crank speed of the run so far [rad/s].

        Raises:
            SimulationError: the press stalls.
        """


def ending_events(system: HybridSystem, mode: Mode) -> tuple[Event, ...]:
    """All events that may end a mode."""
    couplings = [*_coupling_events(system, "clutch", mode.clutch), *_coupling_events(system, "brake", mode.brake)]
    if mode.standing:
        starts = () if mode.brake.grip is HOLDING else (PressStarts(1), PressStarts(-1))
        return (*couplings, *starts)
    found: list[Event] = []
    for k, place in enumerate(mode.forces):
        if place is not None:
            found += _force_events(system, k, place)
    if mode.way and mode.brake.grip is not HOLDING:
        found.append(CrankStops())
    found += [CornerPassed(k, corner, side) for k, (corner, side) in enumerate(zip(system.driven.corners, mode.sides, strict=True))]
    return (*found, *couplings)


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


def _coupling_events(system: HybridSystem, side: Side, mode: CouplingMode) -> list[Event]:
    coupling, found = getattr(system.driven, side), list[Event]()
    if coupling is None:
        return found
    is_open = mode.grip is OPEN
    at = coupling.closes if is_open and not mode.spent else coupling.opens if not is_open else None
    if at is not None:
        found.append(CouplingSwitched(side, at, mode.way, closes=is_open))
    if mode.grip is SLIPPING:
        found.append(CouplingGrips(side, mode.sign))
    elif mode.grip is HOLDING:
        found.append(CouplingSlips(side, mode, coupling))
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

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
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

    force: int
    row: int
    rising: bool

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        rate: float = at.linkage.coordinates[self.row][1]
        return rate if self.rising else -rate

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
        linkage = system.at(y).linkage
        if abs(linkage.speed) <= AT_REST * fastest and system.dynamics.alone:
            return _at_rest(system, mode, time, y)
        force, place, (value, rate) = system.driven.forces[self.force], mode.forces[self.force], linkage.coordinates[self.row]
        assert place is not None
        inside = 0.5 * (max(place.low, value - 1.0) + min(place.high, value + 1.0))
        return mode.with_force(self.force, force_mode(force, inside, not place.rising, value, rate)), y


@dataclass(frozen=True, eq=False, slots=True)
class CrankStops(Event):
    """A crank whose bearings have friction comes to rest: it stands, or turns back."""

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        return mode.way * float(at.linkage.speed)

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
        return _at_rest(system, mode, time, y)


def _at_rest(system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
    """Mode and vector of a crank that has come to rest."""
    if mode.brake.grip is SLIPPING:  # at rest the brake decides what happens
        return CouplingGrips("brake", mode.brake.sign).after(system, mode, time, y, 0.0)
    n, rest = system.dynamics.size, y.copy()
    rest[n : 2 * n] = 0.0
    mode = system.placed(mode, time, rest)
    return mode, rest if mode.standing or mode.way else y


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

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
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

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
        return mode._replace(sides=tuple(-side if k == self.corner else side for k, side in enumerate(mode.sides))), y


# ------------------------------------------------------------------------------------------------------------------------- clutch and brake


@dataclass(frozen=True, eq=False, slots=True)
class CouplingSwitched(Event):
    """A clutch or brake closes, or opens for good, at its time or angle.

    Attributes:
        side: which of the two.
        when: its time or angle.
        way: +1 or -1, direction in which the crank has to pass that angle.
        closes: whether it closes.
    """

    side: Side
    when: SwitchPoint
    way: int
    closes: bool

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        past = time - self.when.time if self.when.time is not None else (at.linkage.angle - (self.when.angle or 0.0)) * self.way
        return -past

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
        at = system.at(y)
        if not self.closes:
            return _released(system, self.side, mode.with_coupling(self.side, CouplingMode(OPEN, spent=True)), time, y, at)
        opens, relative = getattr(system.driven, self.side).opens, _relative_speed(self.side, at)
        way = 1 if opens is None or opens.angle is None or opens.angle > at.linkage.angle else -1
        grip, sign = (SLIPPING, sign_of(relative)) if relative else (HOLDING, 0)
        return mode.with_coupling(self.side, CouplingMode(grip, sign, time, way=way)), y


@dataclass(frozen=True, eq=False, slots=True)
class CouplingGrips(Event):
    """Both sides of a slipping coupling have come to the same speed.

    Attributes:
        side: which coupling.
        sign: of its torque on the crank so far.
    """

    side: Side
    sign: int

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        return self.sign * _relative_speed(self.side, at)

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
        n, linkage, y = system.dynamics.size, system.at(y).linkage, y.copy()
        if self.side == "clutch":
            y[-len(INTEGRALS) - 1] = linkage.speed
        else:
            system.dynamics.stands(linkage, time)
            y[n : 2 * n] = 0.0
        coupling: CouplingMode = getattr(mode, self.side)._replace(grip=HOLDING)
        mode = mode.with_coupling(self.side, coupling)
        held = system.holding_torque(self.side, mode, time, y, system.at(y))
        if abs(held) > coupling.capacity(getattr(system.driven, self.side), time):  # it cannot hold, and slips on the other way
            mode = mode.with_coupling(self.side, coupling._replace(grip=SLIPPING, sign=sign_of(held)))
        return mode, y


@dataclass(frozen=True, eq=False, slots=True)
class CouplingSlips(Event):
    """A holding coupling would have to transmit more than it can.

    Attributes:
        side: which coupling.
        mode: of the coupling.
        coupling: the coupling.
    """

    side: Side
    mode: CouplingMode
    coupling: Coupling

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        return self.mode.capacity(self.coupling, time) - abs(system.holding_torque(self.side, mode, time, y, at))

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
        at = system.at(y)
        held = system.holding_torque(self.side, mode, time, y, at)
        mode = mode.with_coupling(self.side, self.mode._replace(grip=SLIPPING, sign=sign_of(held)))
        return _released(system, self.side, mode, time, y, at)


@dataclass(frozen=True, eq=False, slots=True)
class PressStarts(Event):
    """The drive overcomes what holds a standing press in one direction.

    Attributes:
        way: +1 or -1, the direction.
    """

    way: int

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        forward, back = (self._tending(system, mode, time, y, way) for way in (1, -1))
        return STARTS * abs(back - forward) - self.way * (forward if self.way > 0 else back)

    def _tending(self, system: HybridSystem, mode: Mode, time: float, y: Array, way: int) -> float:
        """Acceleration with which the crank would start in one direction [rad/s2]."""
        tried = system.starting(mode, y[: system.dynamics.size], way)
        return system.acceleration(tried, time, system.at(y))  # computed again: `starting` has moved the linkage

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
        return system.starting(mode, y[: system.dynamics.size], self.way)._replace(standing=False), y


def _relative_speed(side: Side, at: Snapshot) -> float:
    """Speed of a coupling's other side relative to the crank."""
    return at.shaft_speed - at.linkage.speed if side == "clutch" else -at.linkage.speed  # type: ignore[no-any-return]


def _released(system: HybridSystem, side: Side, mode: Mode, time: float, y: Array, at: Snapshot) -> tuple[Mode, Array]:
    """Mode and vector after a coupling has released: a press that a brake held at rest starts, or is held by its loads."""
    return system.placed(mode, time, y) if side == "brake" and not at.linkage.speed else mode, y
