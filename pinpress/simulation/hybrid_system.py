"""A driven press as equations over time that switch: its rates in a mode, and the events that end the mode.

In a mode everything is smooth: each force keeps to its interval, each coupling to its grip, the drive to one side of every corner of its
torque, also where an integrator looks beyond. An `Event` has a margin, positive in the mode; where it falls below zero the event says which
mode comes after. A brake is a coupling to the frame, whose speed is zero.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np

from ..common.quantities import Array
from ..drives.transmission import Coupling, SwitchPoint
from ..loads.caller_laws import LawError
from ..loads.process import ForceInterval
from .driven_press import DrivenPress, GeneralizedForce
from .equations_of_motion import Dynamics
from .failures import failure
from .trajectory import INTEGRALS

AHEAD = 1e-9  # time looked ahead, where there are several drivers [s]
LITTLE = 1e-7  # of a turn of the crank, looked ahead to see into which interval a force goes [rad]
STARTS = 1e-9  # acceleration of a press that stands, beside that by the loads that hold it, with which it starts
AT_REST = 1e-9  # crank speed, beside the run's largest, at which a stop is one


class Snapshot(NamedTuple):
    """A state as forces see it: what `Dynamics.at` gives, speed of the drive's shaft, the drive's states."""

    linkage: Any
    shaft_speed: float
    states: tuple[float, ...]


# ------------------------------------------------------------------------------------------------------------------------------- modes

Side = Literal["clutch", "brake"]
"""Which coupling: a field of `Mode` and of `DrivenPress`."""


class Grip(Enum):
    """What a clutch or brake does."""

    OPEN = "open"
    SLIPPING = "slipping"
    HOLDING = "holding"


OPEN, SLIPPING, HOLDING = Grip


class CouplingMode(NamedTuple):
    """Mode of a clutch or brake.

    Attributes:
        grip: what it does.
        sign: of its torque on the crank while it slips.
        since: when it closed [s].
        spent: whether it has opened for good.
        way: +1 or -1, in which the crank has to pass the angle that switches it.
    """

    grip: Grip
    sign: int = 0
    since: float = -math.inf
    spent: bool = False
    way: int = 1

    def capacity(self, coupling: Coupling, time: float) -> float:
        """Torque that it can transmit [N m]."""
        return coupling.torque * min(1.0, max(0.0, (time - self.since) / coupling.rise)) if coupling.rise else coupling.torque

    def torque(self, coupling: Coupling | None, time: float) -> float:
        """Friction torque on the crank, while it slips [N m]."""
        return self.sign * self.capacity(coupling, time) if coupling is not None and self.grip is SLIPPING else 0.0


class ForceMode(NamedTuple):
    """Where a force is: between two values of its coordinate, which rises or falls; the interval that acts there; whether that pushes."""

    low: float
    high: float
    rising: bool
    interval: ForceInterval | None
    pushing: bool = True


class Mode(NamedTuple):
    """All that is switched.

    Attributes:
        clutch: its mode; of one that is missing: holding.
        brake: its mode; of one that is missing: open.
        forces: of every force; None of one in time.
        sides: +1 or -1, on which side of the corners of its torque the drive runs.
        standing: whether the press stands, held by loads that resist either way.
    """

    clutch: CouplingMode
    brake: CouplingMode
    forces: tuple[ForceMode | None, ...]
    sides: tuple[int, ...] = ()
    standing: bool = False

    def with_coupling(self, side: Side, mode: CouplingMode) -> "Mode":
        return self._replace(clutch=mode) if side == "clutch" else self._replace(brake=mode)

    def with_force(self, k: int, mode: ForceMode) -> "Mode":
        return self._replace(forces=(*self.forces[:k], mode, *self.forces[k + 1 :]))


def force_mode(force: GeneralizedForce, inside: float, rising: bool, value: float, rate: float) -> ForceMode:
    """Mode of a force at a value of its coordinate.

    Args:
        force: along the coordinate.
        inside: a value near that of the coordinate which is on no border.
        rising: whether the coordinate rises.
        value: of the coordinate.
        rate: of the coordinate.
    """
    borders = force.borders()
    low = max((b for b in borders if b < inside), default=-math.inf)
    high = min((b for b in borders if b >= inside), default=math.inf)
    interval = next((s for s in force.intervals(rising) if s.lower < inside - force.datum <= s.upper), None)
    pushing = interval is None or not interval.one_sided or float(interval.force(value - force.datum, rate)) >= 0
    return ForceMode(low, high, rising, interval, pushing)


def _at_start(coupling: Coupling | None, angle: float, speed: float, relative: float, missing: Grip) -> CouplingMode:
    """Mode at the start, at a speed ``relative`` to the crank; one that is ``missing`` is as if it did that for good."""
    if coupling is None:
        return CouplingMode(missing)
    at = coupling.closes or coupling.opens
    way = 1 if at is None or at.angle is None or at.angle > angle or (at.angle == angle and speed >= 0) else -1
    if coupling.closes is not None:
        return CouplingMode(OPEN, way=way)
    return CouplingMode(SLIPPING, _sign(relative), way=way) if relative else CouplingMode(HOLDING, way=way)


def _sign(value: float) -> int:
    return 1 if value > 0 else -1


# ------------------------------------------------------------------------------------------------------------------------------ system


@dataclass(frozen=True, eq=False)
class HybridSystem:
    """The integrated vector holds positions (size,), speeds (size,), the drive's states, the speed of a clutch's driving side where there
    is a clutch, and the integrals (4,)."""

    dynamics: Dynamics
    driven: DrivenPress

    def begin(
        self, time: float, position: Array, speed: Array, integrals: Array, states: tuple[float, ...] | None = None
    ) -> tuple[Mode, Array]:
        """Mode and vector at the start.

        Args:
            time: [s].
            position: (size,) [rad or m].
            speed: (size,) [rad/s or m/s].
            integrals: (4,) the `INTEGRALS` so far.
            states: of the drive; None: those that it starts with.

        Raises:
            SimulationError: the press stalls there.
        """
        driven, crank = self.driven, self.dynamics.crank
        angle, turning = float(position[crank]), float(speed[crank])
        if states is None:
            states = () if driven.drive is None else tuple(driven.drive.state)
        shaft = turning
        if driven.clutch is not None:
            if driven.flywheel is not None and driven.flywheel.speed is not None:
                shaft = driven.flywheel.speed
            states = (*states, shaft)
        clutch = _at_start(driven.clutch, angle, turning, shaft - turning, missing=HOLDING)
        brake = _at_start(driven.brake, angle, turning, -turning, missing=OPEN)
        y = np.concatenate([position, speed, states, integrals])
        forces = tuple(None if force.time is not None else ForceMode(-math.inf, math.inf, True, None) for force in driven.forces)
        return self.placed(self.past_corner(Mode(clutch, brake, forces), y), time, y), y

    def at(self, y: Array) -> Snapshot:
        """The state of a vector."""
        n = self.dynamics.size
        linkage = self.dynamics.at(y[:n], y[n : 2 * n])
        states = tuple(y[2 * n : -len(INTEGRALS)].tolist())
        return Snapshot(linkage, linkage.speed, states) if self.driven.clutch is None else Snapshot(linkage, states[-1], states[:-1])

    def driving(self, times: Array, columns: Array) -> tuple[Array, Array, Array]:
        """Torque of the drive, and of its motor at its own shaft [N m], and the speed of the drive's side of the clutch [rad/s], (n,) each,
        of vectors (len(y), n) at times (n,)."""
        n, drive, crank = self.dynamics.size, self.driven.drive, self.dynamics.crank
        own = columns[n + crank] if self.driven.clutch is None else columns[-len(INTEGRALS) - 1]
        if drive is None:
            return np.zeros(len(times)), np.zeros(len(times)), own
        states = columns[2 * n : -len(INTEGRALS) - (self.driven.clutch is not None)].T.tolist()
        at = list(zip(own.tolist(), columns[crank].tolist(), times.tolist(), map(tuple, states), strict=True))
        torque, motor = (np.array([float(np.ravel(law(*one))[0]) for one in at]) for law in (drive.torque, drive.motor_torque))
        return torque, motor, own

    # Rates

    def rates(self, mode: Mode, time: float, y: Array) -> Array:
        """dy/dt (len(y),)."""
        try:
            return self._coasting(y) if self._free else self._rates(mode, time, y)
        except LawError as error:
            raise error.within(time, float(self.at(y).linkage.angle)) from error.__cause__

    @cached_property
    def _free(self) -> bool:
        """Whether there are no forces but inertia and weight."""
        driven = self.driven
        return driven.drive is None and driven.clutch is None and driven.brake is None and not driven.forces

    def _coasting(self, y: Array) -> Array:
        n = self.dynamics.size
        result = np.zeros(len(y))
        result[:n] = speed = y[n : 2 * n]
        linkage = self.dynamics.at(y[:n], speed)
        result[n : 2 * n] = self.dynamics.accelerations(linkage, 0.0, (), self.driven.inertia)
        return result

    def _rates(self, mode: Mode, time: float, y: Array) -> Array:
        n, driven = self.dynamics.size, self.driven
        linkage, shaft_speed, states = at = self.at(y)
        torque = self.drive_torque(time, at)
        forces, taken, put_in, squared = self._forces(mode, time, linkage)
        through = 0.0 if driven.clutch is None else mode.clutch.torque(driven.clutch, time)
        braking = 0.0 if driven.brake is None else mode.brake.torque(driven.brake, time)
        rigid, result, accelerated = mode.clutch.grip is HOLDING, np.zeros(len(y)), 0.0
        if mode.brake.grip is not HOLDING and not mode.standing:
            on_crank, inertia = (torque, driven.inertia) if rigid else (through, 0.0)
            result[:n] = y[n : 2 * n]
            result[n : 2 * n] = accelerations = self.dynamics.accelerations(linkage, on_crank + braking, forces, inertia)
            accelerated = self.dynamics.of_crank(accelerations)
        if driven.drive is not None and states:
            result[2 * n : 2 * n + len(states)] = driven.drive.rates(shaft_speed, linkage.angle, time, states)
        if driven.clutch is not None:
            result[2 * n + len(states)] = accelerated if rigid else (torque - through) / driven.inertia
        motor = 0.0 if driven.drive is None else driven.drive.motor_torque(shaft_speed, linkage.angle, time, states)
        lost = through * (shaft_speed - linkage.speed) - braking * linkage.speed
        result[-len(INTEGRALS) :] = (torque * shaft_speed + put_in, taken, motor * motor + squared, lost)
        return result

    def _forces(self, mode: Mode, time: float, linkage: Any) -> tuple[list[float], float, float, float]:
        """The forces along every coordinate, the power that they take, that of further drives, and the square of these motors' torque."""
        forces, taken, put_in, squared = [0.0] * len(linkage.coordinates), 0.0, 0.0, 0.0
        for force, place in zip(self.driven.forces, mode.forces, strict=True):
            value, rate = linkage.coordinates[force.row]
            if force.time is not None:
                size = float(force.time(time))
            elif place is None or place.interval is None or not place.pushing:
                size = 0.0
            else:
                size = float(place.interval.force(value - force.datum, rate))
            forces[force.row] += size
            if force.drive is None:
                taken -= size * rate
            else:
                put_in += size * rate
                squared += float(force.drive.motor_torque(rate)) ** 2
        return forces, taken, put_in, squared

    def drive_torque(self, time: float, at: Snapshot) -> Any:
        """Torque of the drive at the driver joint [N m]."""
        drive = self.driven.drive
        return 0.0 if drive is None else drive.torque(at.shaft_speed, at.linkage.angle, time, at.states)

    def acceleration(self, mode: Mode, time: float, at: Snapshot, more: float = 0.0) -> float:
        """Acceleration of a crank that is free to turn, under so much more torque."""
        driven = self.driven
        forces = self._forces(mode, time, at.linkage)[0]
        rigid = mode.clutch.grip is HOLDING
        on_crank, inertia = (self.drive_torque(time, at), driven.inertia) if rigid else (mode.clutch.torque(driven.clutch, time), 0.0)
        torque = on_crank + mode.brake.torque(driven.brake, time) + more
        return self.dynamics.of_crank(self.dynamics.accelerations(at.linkage, torque, forces, inertia))

    def heeds_speed(self, mode: Mode, time: float, y: Array) -> bool:
        """Whether anything but angle and speed of the crank counts, or forces in this state depend on its speed or way."""
        n, driven = self.dynamics.size, self.driven
        if n > 1 or len(y) > 2 + len(INTEGRALS) or driven.clutch is not None or driven.brake is not None:
            return True
        if any(force.time is not None or force.rising is not force.falling for force in driven.forces):
            return True
        found = []
        for share in (1.0, 0.5, 0.0, -1.0):
            linkage = self.dynamics.at(y[:n], share * y[n : 2 * n])
            torque = float(np.ravel(self.drive_torque(time, Snapshot(linkage, linkage.speed, ())))[0])
            found.append((*self._forces(mode, time, linkage)[0], torque))
        return found.count(found[0]) < len(found)

    # Events

    def events(self, mode: Mode) -> "tuple[Event, ...]":
        """All that ends a mode."""
        couplings = [*self._coupling_events("clutch", mode.clutch), *self._coupling_events("brake", mode.brake)]
        if mode.standing:
            starts = () if mode.brake.grip is HOLDING else (PressStarts(1), PressStarts(-1))
            return (*couplings, *starts)
        found: list[Event] = []
        for k, place in enumerate(mode.forces):
            if place is not None:
                found += self._force_events(k, place)
        found += [CornerPassed(k, corner, side) for k, (corner, side) in enumerate(zip(self.driven.corners, mode.sides, strict=True))]
        return (*found, *couplings)

    def _force_events(self, k: int, place: ForceMode) -> "list[Event]":
        force, found = self.driven.forces[k], list[Event]()
        if math.isfinite(place.low):
            found.append(BorderPassed(k, force.row, place.low, upwards=False))
        if math.isfinite(place.high):
            found.append(BorderPassed(k, force.row, place.high, upwards=True))
        if force.rising is not force.falling:
            found.append(CoordinateTurns(k, force.row, place.rising))
        if place.interval is not None and place.interval.one_sided:
            found.append(ContactChanges(k, force.row, force.datum, place.interval, place.pushing))
        return found

    def _coupling_events(self, side: Side, mode: CouplingMode) -> "list[Event]":
        coupling, found = getattr(self.driven, side), list[Event]()
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

    def margins(self, events: "Sequence[Event]", mode: Mode, time: float, y: Array) -> list[float]:
        """How far each of the events is away: positive in this mode; where one falls below zero the mode ends."""
        at = self.at(y)
        return [event.margin(self, mode, time, y, at) for event in events]

    def past_corner(self, mode: Mode, y: Array) -> Mode:
        """The mode with the drive on the side of every corner to which its speed tends."""
        corners = self.driven.corners
        if not corners:
            return mode
        own = self.at(y).shaft_speed
        sides = mode.sides or (0,) * len(corners)
        near = min(range(len(corners)), key=lambda k: abs(own - corners[k]))
        return mode._replace(
            sides=tuple(
                -side if side and k == near else side or (1 if own >= corner else -1)
                for k, (corner, side) in enumerate(zip(corners, sides, strict=True))
            )
        )

    # Standstill

    def placed(self, mode: Mode, time: float, y: Array) -> Mode:
        """The mode with every force put where it is; at rest the way is that in which the crank starts.

        Raises:
            SimulationError: the loads hold the press from both sides, and nothing that depends on time can change that.
        """
        mode = mode._replace(standing=False)
        n = self.dynamics.size
        position, speed = y[:n], y[n : 2 * n]
        linkage = self.dynamics.at(position, speed)
        if not self.driven.forces or all(place is None for place in mode.forces):
            return mode
        if not self.dynamics.alone:  # the first crank's rest is not the linkage's
            return self._placed_at(mode, position + AHEAD * speed, speed, moving=True)
        if linkage.speed:
            return self._placed_at(mode, position + LITTLE / abs(linkage.speed) * speed, speed, moving=True)
        still: Mode | None = None
        for way in (1.0, -1.0):
            tried = self.starting(mode, position, way)
            acceleration = self.dynamics.of_crank(self.rates(tried, time, y)[n : 2 * n])
            if acceleration * way > 0 or mode.brake.grip is HOLDING:
                return tried
            still = tried if acceleration == 0.0 else still
        if still is not None:
            return still
        if self._may_start_later:
            return mode._replace(standing=True)
        raise failure("stalls", time, linkage.angle)

    @cached_property
    def _may_start_later(self) -> bool:
        """Whether a press at rest may be started later: by the drive, a force in time, clutch or brake."""
        driven = self.driven
        drives = (driven.drive is not None and driven.drive.timed) or driven.clutch is not None or driven.brake is not None
        return drives or any(force.time is not None for force in driven.forces)

    def starting(self, mode: Mode, position: Array, way: float) -> Mode:
        """The mode with every force put where it is when the crank starts from rest, one way or the other."""
        return self._placed_at(mode, *self.dynamics.moved(position, way * LITTLE), moving=False)

    def _placed_at(self, mode: Mode, position: Array, speed: Array, moving: bool) -> Mode:
        """The mode with every force put where it is at a state a little ahead."""
        linkage = self.dynamics.at(position, speed)
        places = []
        for force, place in zip(self.driven.forces, mode.forces, strict=True):
            value, rate = linkage.coordinates[force.row]
            places.append(None if place is None else force_mode(force, value, rate > 0, value, rate if moving else 0.0))
        return mode._replace(forces=tuple(places))

    def holding_torque(self, side: Side, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        """Torque on the crank that a coupling has to transmit to hold [N m]."""
        if side == "clutch":
            free, torque = self.acceleration(mode, time, at), float(self.drive_torque(time, at))
            return torque if mode.brake.grip is HOLDING else torque - self.driven.inertia * free
        needed = []
        ways = (1.0, -1.0) if any(force.rising is not force.falling for force in self.driven.forces) else (0.0,)
        for way in ways:
            tried = self.starting(mode, y[: self.dynamics.size], way) if way else mode
            here = self.at(y)  # anew: looking elsewhere has moved the linkage
            free, pushed = self.acceleration(tried, time, here), self.acceleration(tried, time, here, more=1.0)
            needed.append(-free / (pushed - free))  # the torque that leaves the crank at rest
        # at rest a load of one direction takes anything up to its force: it is the least that the brake has to hold
        return 0.0 if min(needed) <= 0 <= max(needed) else min(needed, key=abs)


# ------------------------------------------------------------------------------------------------------------------------------ events


class Event(ABC):
    """What ends a mode."""

    @abstractmethod
    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        """How far it is away: positive in the mode, below zero once it has come."""

    @abstractmethod
    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
        """Mode and vector after it.

        Args:
            system: to which it happens.
            mode: that it ends.
            time: at which it comes [s].
            y: the vector then.
            fastest: largest crank speed of the run so far [rad/s].

        Raises:
            SimulationError: the press stalls.
        """


@dataclass(frozen=True, eq=False, slots=True)
class BorderPassed(Event):
    """The coordinate of a force leaves the interval between two of its borders."""

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
    """The coordinate of a force, which depends on its way, turns back: at a dead centre, or where the crank itself stops."""

    force: int
    row: int
    rising: bool

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        rate: float = at.linkage.coordinates[self.row][1]
        return rate if self.rising else -rate

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
        linkage = system.at(y).linkage
        if abs(linkage.speed) <= AT_REST * fastest and system.dynamics.alone:
            return self._at_rest(system, mode, time, y)
        force, place, (value, rate) = system.driven.forces[self.force], mode.forces[self.force], linkage.coordinates[self.row]
        assert place is not None
        inside = 0.5 * (max(place.low, value - 1.0) + min(place.high, value + 1.0))
        return mode.with_force(self.force, force_mode(force, inside, not place.rising, value, rate)), y

    def _at_rest(self, system: HybridSystem, mode: Mode, time: float, y: Array) -> tuple[Mode, Array]:
        if mode.brake.grip is SLIPPING:  # what happens at rest is for the brake to decide
            return CouplingGrips("brake", mode.brake.sign).after(system, mode, time, y, 0.0)
        n, rest = system.dynamics.size, y.copy()
        rest[n : 2 * n] = 0.0
        mode = system.placed(mode, time, rest)
        return mode, rest if mode.standing else y


@dataclass(frozen=True, eq=False, slots=True)
class ContactChanges(Event):
    """A one-sided force would pull, or pushes again."""

    force: int
    row: int
    datum: float
    interval: ForceInterval
    pushing: bool

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        value, rate = at.linkage.coordinates[self.row]
        law = float(self.interval.force(value - self.datum, rate))
        return law if self.pushing else -law

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
        place = mode.forces[self.force]
        assert place is not None
        return mode.with_force(self.force, place._replace(pushing=not place.pushing)), y


@dataclass(frozen=True, eq=False, slots=True)
class CornerPassed(Event):
    """The drive's shaft passes a speed at which its torque is not smooth."""

    corner: int
    speed: float
    side: int

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        return self.side * (at.shaft_speed - self.speed)

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
        return mode._replace(sides=tuple(-side if k == self.corner else side for k, side in enumerate(mode.sides))), y


@dataclass(frozen=True, eq=False, slots=True)
class CouplingSwitched(Event):
    """A clutch or brake closes, or opens for good, at its time or angle."""

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
        grip, sign = (SLIPPING, _sign(relative)) if relative else (HOLDING, 0)
        return mode.with_coupling(self.side, CouplingMode(grip, sign, time, way=way)), y


@dataclass(frozen=True, eq=False, slots=True)
class CouplingGrips(Event):
    """Both sides of a slipping coupling have come to the same speed."""

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
        if abs(held) > coupling.capacity(getattr(system.driven, self.side), time):  # it cannot hold: it slips on, the other way
            mode = mode.with_coupling(self.side, coupling._replace(grip=SLIPPING, sign=_sign(held)))
        return mode, y


@dataclass(frozen=True, eq=False, slots=True)
class CouplingSlips(Event):
    """A holding coupling would have to transmit more than it can."""

    side: Side
    mode: CouplingMode
    coupling: Coupling

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        return self.mode.capacity(self.coupling, time) - abs(system.holding_torque(self.side, mode, time, y, at))

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
        at = system.at(y)
        held = system.holding_torque(self.side, mode, time, y, at)
        mode = mode.with_coupling(self.side, self.mode._replace(grip=SLIPPING, sign=_sign(held)))
        return _released(system, self.side, mode, time, y, at)


@dataclass(frozen=True, eq=False, slots=True)
class PressStarts(Event):
    """The drive overcomes what resists a standing press one way."""

    way: int

    def margin(self, system: HybridSystem, mode: Mode, time: float, y: Array, at: Snapshot) -> float:
        forward, back = (self._tending(system, mode, time, y, way) for way in (1, -1))
        return STARTS * abs(back - forward) - self.way * (forward if self.way > 0 else back)

    def _tending(self, system: HybridSystem, mode: Mode, time: float, y: Array, way: int) -> float:
        """Acceleration with which the crank would start one way."""
        tried = system.starting(mode, y[: system.dynamics.size], way)
        return system.acceleration(tried, time, system.at(y))  # seen anew: looking elsewhere has moved the linkage

    def after(self, system: HybridSystem, mode: Mode, time: float, y: Array, fastest: float) -> tuple[Mode, Array]:
        return system.starting(mode, y[: system.dynamics.size], self.way)._replace(standing=False), y


def _relative_speed(side: Side, at: Snapshot) -> float:
    """Speed of a coupling's other side, beside the crank's."""
    return at.shaft_speed - at.linkage.speed if side == "clutch" else -at.linkage.speed  # type: ignore[no-any-return]


def _released(system: HybridSystem, side: Side, mode: Mode, time: float, y: Array, at: Snapshot) -> tuple[Mode, Array]:
    """Mode after a coupling holds no longer: a press that a brake held at rest starts, or stands by its loads."""
    return system.placed(mode, time, y) if side == "brake" and not at.linkage.speed else mode, y
