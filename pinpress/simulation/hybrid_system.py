"""A press with its driveline and forces as equations over time: right-hand sides, and the functions whose zeros switch them.

Between switchings everything is smooth: each force keeps to its interval, clutch and brake to their mode, also where an integrator looks
beyond.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..common.arrays import Array
from ..common.errors import SimulationError
from ..drives.couplings import Brake, Clutch
from ..loads.caller_laws import LawError
from ..loads.process import ForceInterval
from .driven_press import DrivenPress, GeneralizedForce
from .trajectory import INTEGRALS

AHEAD = 1e-9  # time looked ahead, where there are several drivers [s]
LITTLE = 1e-7  # of a turn of the crank, looked ahead to see into which interval a force goes [rad]
STARTS = 1e-9  # acceleration of a press that stands, beside that by the loads that hold it, with which it starts
AT_REST = 1e-9  # crank speed, beside the run's largest, at which a stop is one
STALLED = "the press stalls: it comes to rest, and the load holds it there against the drive"

OPEN, SLIPPING, HOLDING = "open", "slipping", "holding"

Split = tuple[Any, float, tuple[float, ...]]
"""The instant, speed of the drive's shaft, the drive's states."""


class Dynamics(Protocol):
    """The linkage as it is integrated: its crank alone, or all its joints. ``size``: of position and speed; ``crank``: its place there;
    ``alone``: whether it is the only driver, so that the linkage rests where it does."""

    size: int
    crank: int
    alone: bool

    def at(self, position: Array, speed: Array) -> Any:
        """What forces need of a state: an object with the crank's ``angle`` and ``speed``, and the ``coordinates``, (value, rate) each."""

    def accelerations(self, instant: Any, torque: float, forces: Sequence[float], inertia: float) -> Any:
        """Accelerations (size,) at an instant under a torque on the crank and forces along the coordinates, with inertia added to the
        crank."""

    def of_crank(self, accelerations: Any) -> float:
        """The crank's acceleration among these."""

    def stands(self, instant: Any, time: float) -> None:
        """Raise where the crank rests and the links do not."""

    def moved(self, position: Array, angle: float) -> tuple[Array, Array]:
        """Positions a small angle of the crank away, and speeds that lead there."""

    def project(self, position: Array, speed: Array) -> tuple[Array, Array] | None:
        """The nearest state with closed loops; None where none can be open."""

    def closed(self, position: Array, speed: Array) -> tuple[Array, Array]:
        """States (size, n) with their loops closed."""


class Grip(NamedTuple):
    """State of a clutch or brake.

    Attributes:
        state: `OPEN`, `SLIPPING` or `HOLDING`. sign: of the torque while it slips. since: when it closed [s].
        spent: opened for good. way: +1 or -1, in which the crank has to pass the angle that switches it.
    """

    state: str
    sign: int = 0
    since: float = -math.inf
    spent: bool = False
    way: int = 1

    def capacity(self, friction: Clutch | Brake, time: float) -> float:
        """Torque that it can transmit [N m]."""
        return friction.torque * min(1.0, max(0.0, (time - self.since) / friction.rise)) if friction.rise else friction.torque


class Mode(NamedTuple):
    """Mode of a driveline."""

    clutch: Grip
    brake: Grip


class Place(NamedTuple):
    """Where a force is: between two values of its coordinate, which rises or falls; the interval that acts there; whether that pushes."""

    low: float
    high: float
    rising: bool
    interval: ForceInterval | None
    pushing: bool = True


class Modes(NamedTuple):
    """All that is switched: the driveline's mode, the place of every force (None of one in time), and on which side of the corners of its
    torque the drive runs; whether the press is ``standing``, held by loads that resist either way."""

    line: Mode
    places: tuple[Place | None, ...]
    sides: tuple[int, ...] = ()
    standing: bool = False


class Switch(NamedTuple):
    """What a switching function is of: a force ("low", "high", "turn", "contact"), the drive ("corner"), a clutch or brake ("grips",
    "slips", "closes", "opens"), or a press that stands ("starts", +1 or -1)."""

    what: str
    of: int | str


def place_of(force: GeneralizedForce, inside: float, rising: bool, value: float, rate: float) -> Place:
    """Place of a force at a value of its coordinate; ``inside`` is a value near it that is on no border."""
    borders = force.borders()
    low = max((b for b in borders if b < inside), default=-math.inf)
    high = min((b for b in borders if b >= inside), default=math.inf)
    interval = next((s for s in force.intervals(rising) if s.lower < inside - force.datum <= s.upper), None)
    pushing = interval is None or not interval.one_sided or float(interval.force(value - force.datum, rate)) >= 0
    return Place(low, high, rising, interval, pushing)


def begin(driven: DrivenPress, angle: float, speed: float) -> tuple[Mode, tuple[float, ...]]:
    """Mode of the couplings and states at the start: the drive's own, and of a clutch's driving side the speed."""
    states = () if driven.drive is None else tuple(driven.drive.state)
    own = speed
    if driven.clutch is not None:
        if driven.flywheel is not None and driven.flywheel.speed is not None:
            own = driven.flywheel.speed
        states = (*states, own)
    clutch, brake = _grip(driven.clutch, angle, speed, own - speed, HOLDING), _grip(driven.brake, angle, speed, speed, OPEN)
    return Mode(clutch, brake), states


def _grip(friction: Clutch | Brake | None, angle: float, speed: float, relative: float, missing: str) -> Grip:
    """State at the start, at a relative speed of the two sides; one that is ``missing`` is as if it did that for good."""
    if friction is None:
        return Grip(missing)
    at = friction.closes or friction.opens
    way = 1 if at is None or at.angle is None or at.angle > angle or (at.angle == angle and speed >= 0) else -1
    if friction.closes is not None:
        return Grip(OPEN, way=way)
    return Grip(SLIPPING, 1 if relative > 0 else -1, way=way) if relative else Grip(HOLDING, way=way)


@dataclass(frozen=True, eq=False)
class HybridSystem:
    """The integrated vector holds positions (size,), speeds (size,), the drive's states, the speed of a clutch's driving side where there
    is a clutch, and the integrals (4,)."""

    dynamics: Dynamics
    driven: DrivenPress

    def begin(self, position: Array, speed: Array, states: tuple[float, ...], integrals: Array) -> Array:
        """The vector at the start."""
        return np.concatenate([position, speed, states, integrals])

    def split(self, y: Array) -> Split:
        """The instant, speed of the drive's shaft, the drive's states."""
        n = self.dynamics.size
        instant = self.dynamics.at(y[:n], y[n : 2 * n])
        states = tuple(y[2 * n : -len(INTEGRALS)].tolist())
        return (instant, instant.speed, states) if self.driven.clutch is None else (instant, states[-1], states[:-1])

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

    def rates(self, modes: Modes, time: float, y: Array) -> Array:
        """dy/dt (len(y),)."""
        try:
            return self._rates(modes, time, y)
        except LawError as error:
            raise error.within(time, float(self.split(y)[0].angle)) from error.__cause__

    def _rates(self, modes: Modes, time: float, y: Array) -> Array:
        n, driven = self.dynamics.size, self.driven
        if self.free:
            return self._coasting(y)
        instant, own, states = self.split(y)
        torque = self._drive_torque(own, instant.angle, time, states)
        forces, taken, put_in, squared = self._forces(modes, time, instant)
        through, braking = self._transmitted(modes.line, time, instant.speed, own)
        result, accelerated = np.zeros(len(y)), 0.0
        if modes.line.brake.state != HOLDING and not modes.standing:
            rigid = modes.line.clutch.state == HOLDING
            on_crank, inertia = (torque, driven.inertia) if rigid else (through, 0.0)
            result[:n] = y[n : 2 * n]
            result[n : 2 * n] = accelerations = self.dynamics.accelerations(instant, on_crank - braking, forces, inertia)
            accelerated = self.dynamics.of_crank(accelerations)
        if driven.drive is not None and states:
            result[2 * n : 2 * n + len(states)] = driven.drive.rates(own, instant.angle, time, states)
        if driven.clutch is not None:
            result[2 * n + len(states)] = accelerated if modes.line.clutch.state == HOLDING else (torque - through) / driven.inertia
        motor = 0.0 if driven.drive is None else driven.drive.motor_torque(own, instant.angle, time, states)
        lost = through * (own - instant.speed) + braking * instant.speed
        result[-len(INTEGRALS) :] = (torque * own + put_in, taken, motor * motor + squared, lost)
        return result

    @cached_property
    def free(self) -> bool:
        """Whether there are no forces but inertia and weight."""
        driven = self.driven
        return driven.drive is None and driven.clutch is None and driven.brake is None and not self.driven.forces

    def _coasting(self, y: Array) -> Array:
        n = self.dynamics.size
        result = np.zeros(len(y))
        result[:n] = speed = y[n : 2 * n]
        instant = self.dynamics.at(y[:n], speed)
        result[n : 2 * n] = self.dynamics.accelerations(instant, 0.0, (), self.driven.inertia)
        return result

    def _forces(self, modes: Modes, time: float, instant: Any) -> tuple[list[float], float, float, float]:
        """The forces along every coordinate, the power that they take, that of further drives, and the square of these motors' torque."""
        forces, taken, driven, squared = [0.0] * len(instant.coordinates), 0.0, 0.0, 0.0
        for force, place in zip(self.driven.forces, modes.places, strict=True):
            value, rate = instant.coordinates[force.row]
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
                driven += size * rate
                squared += float(force.drive.motor_torque(rate)) ** 2
        return forces, taken, driven, squared

    def heeds_speed(self, modes: Modes, time: float, y: Array) -> bool:
        """Whether anything but angle and speed of the crank counts, or forces in this state depend on its speed or way."""
        n, driven = self.dynamics.size, self.driven
        if n > 1 or len(y) > 2 + len(INTEGRALS) or driven.clutch is not None or driven.brake is not None:
            return True
        if any(force.time is not None or force.rising is not force.falling for force in self.driven.forces):
            return True
        found = []
        for share in (1.0, 0.5, 0.0, -1.0):
            instant = self.dynamics.at(y[:n], share * y[n : 2 * n])
            found.append(
                (*self._forces(modes, time, instant)[0], float(np.ravel(self._drive_torque(instant.speed, instant.angle, time, ()))[0]))
            )
        return found.count(found[0]) < len(found)

    def _transmitted(self, mode: Mode, time: float, speed: float, own: float) -> tuple[float, float]:
        """Friction torques on the crank of a slipping clutch, along, and of a slipping brake, against the positive direction."""
        through = braking = 0.0
        if self.driven.clutch is not None and mode.clutch.state == SLIPPING:
            through = mode.clutch.sign * mode.clutch.capacity(self.driven.clutch, time)
        if self.driven.brake is not None and mode.brake.state == SLIPPING:
            braking = mode.brake.sign * mode.brake.capacity(self.driven.brake, time)
        return through, braking

    def _drive_torque(self, speed: float, angle: float, time: float, states: tuple[float, ...]) -> Any:
        """Torque of the drive at the driver joint, at its own side's speed [N m]."""
        return 0.0 if self.driven.drive is None else self.driven.drive.torque(speed, angle, time, states)

    # Switching

    def switches(self, modes: Modes, time: float, y: Array) -> dict[Switch, float]:
        """Switching functions: positive in these modes; where one falls below zero the modes change."""
        state = instant, own, _ = self.split(y)
        found: dict[Switch, float] = {}
        if modes.standing:
            return found | self._line_switches(modes, time, y, state) | self._starts(modes, time, y)
        for k, (force, place) in enumerate(zip(self.driven.forces, modes.places, strict=True)):
            if place is None:
                continue
            value, rate = instant.coordinates[force.row]
            if math.isfinite(place.low):
                found[Switch("low", k)] = value - place.low
            if math.isfinite(place.high):
                found[Switch("high", k)] = place.high - value
            if force.rising is not force.falling:
                found[Switch("turn", k)] = rate if place.rising else -rate
            if place.interval is not None and place.interval.one_sided:
                law = float(place.interval.force(value - force.datum, rate))
                found[Switch("contact", k)] = law if place.pushing else -law
        for k, (corner, side) in enumerate(zip(self.corners, modes.sides, strict=True)):
            found[Switch("corner", k)] = side * (own - corner)
        return found | self._line_switches(modes, time, y, state)

    def _line_switches(self, modes: Modes, time: float, y: Array, state: Split) -> dict[Switch, float]:
        """Switching functions of clutch and brake; ``state``: the vector, split."""
        instant, own, _ = state
        found: dict[Switch, float] = {}
        for which, friction, grip, relative in (
            ("clutch", self.driven.clutch, modes.line.clutch, own - instant.speed),
            ("brake", self.driven.brake, modes.line.brake, instant.speed),
        ):
            if friction is None:
                continue
            at = friction.closes if grip.state == OPEN and not grip.spent else friction.opens if grip.state != OPEN else None
            if at is not None:
                along = time - at.time if at.time is not None else (instant.angle - (at.angle or 0.0)) * grip.way
                found[Switch("closes" if grip.state == OPEN else "opens", which)] = -along
            if grip.state == SLIPPING:
                found[Switch("grips", which)] = grip.sign * relative
            elif grip.state == HOLDING:
                found[Switch("slips", which)] = grip.capacity(friction, time) - abs(self._held(modes, time, y, which, state))
        return found

    def _starts(self, modes: Modes, time: float, y: Array) -> dict[Switch, float]:
        """Switching functions of a press that stands: it starts either way once the drive overcomes what resists that way."""
        if modes.line.brake.state == HOLDING:
            return {}
        n, free = self.dynamics.size, {}
        for way in (1, -1):
            free[way] = self._accelerated(
                self._looking(modes, *self.dynamics.moved(y[:n], way * LITTLE), moving=False), time, self.split(y)
            )[0]
        more = STARTS * abs(free[-1] - free[1])
        return {Switch("starts", 1): more - free[1], Switch("starts", -1): more + free[-1]}

    def _held(self, modes: Modes, time: float, y: Array, which: str, state: Split) -> float:
        """Torque that a holding clutch or brake transmits: the clutch to the crank along, the brake against the positive direction."""
        instant, own, states = state
        torque = float(self._drive_torque(own, instant.angle, time, states))
        if which == "clutch":
            free, _ = self._accelerated(modes, time, state)
            return torque if modes.line.brake.state == HOLDING else torque - self.driven.inertia * free
        n, needed = self.dynamics.size, []
        ways = (1.0, -1.0) if any(force.rising is not force.falling for force in self.driven.forces) else (0.0,)
        for way in ways:
            tried = self._looking(modes, *self.dynamics.moved(y[:n], way * LITTLE), moving=False) if way else modes
            free, pushed = self._accelerated(tried, time, self.split(y))  # anew: looking elsewhere has moved the linkage
            needed.append(free / (pushed - free))  # the torque that leaves the crank at rest
        # at rest a load of one direction takes anything up to its force: it is the least that the brake has to hold
        return 0.0 if min(needed) <= 0 <= max(needed) else min(needed, key=abs)

    def _accelerated(self, modes: Modes, time: float, state: Split) -> tuple[float, float]:
        """The crank's acceleration, and that under 1 N m more."""
        instant, own, states = state
        forces = self._forces(modes, time, instant)[0]
        through, braking = self._transmitted(modes.line, time, instant.speed, own)
        rigid = modes.line.clutch.state == HOLDING
        torque = self._drive_torque(own, instant.angle, time, states)
        on_crank, inertia = (torque, self.driven.inertia) if rigid else (through, 0.0)
        both = [self.dynamics.accelerations(instant, on_crank - braking + more, forces, inertia) for more in (0.0, 1.0)]
        return self.dynamics.of_crank(both[0]), self.dynamics.of_crank(both[1])

    def initial(self, time: float, y: Array, line: Mode) -> Modes:
        """Modes of a state, at the start of a run or after a standstill."""
        places = tuple(None if force.time is not None else Place(-math.inf, math.inf, True, None) for force in self.driven.forces)
        return self.placed(self.past_corner(Modes(line, places), y), time, y)

    @property
    def corners(self) -> tuple[float, ...]:
        """Speeds at which the drive's torque is not smooth."""
        return self.driven.corners

    def past_corner(self, modes: Modes, y: Array) -> Modes:
        """The modes with the drive on the side of every corner to which its speed tends."""
        if not self.corners:
            return modes
        own = self.split(y)[1]
        sides = modes.sides or (0,) * len(self.corners)
        near = min(range(len(self.corners)), key=lambda k: abs(own - self.corners[k]))
        return modes._replace(
            sides=tuple(
                -side if side and k == near else side or (1 if own >= corner else -1)
                for k, (corner, side) in enumerate(zip(self.corners, sides, strict=True))
            )
        )

    def placed(self, modes: Modes, time: float, y: Array) -> Modes:
        """The modes with every force put where it is; at rest the way is that in which the crank starts.

        Raises:
            SimulationError: the loads hold the press from both sides, and nothing that depends on time can change that.
        """
        modes = modes._replace(standing=False)
        n = self.dynamics.size
        speed = y[n : 2 * n]
        instant = self.dynamics.at(y[:n], speed)
        if not self.driven.forces or all(place is None for place in modes.places):
            return modes
        if not self.dynamics.alone:  # the first crank's rest is not the linkage's
            return self._looking(modes, y[:n] + AHEAD * speed, speed, moving=True)
        if instant.speed:
            return self._looking(modes, y[:n] + LITTLE / abs(instant.speed) * speed, speed, moving=True)
        still: Modes | None = None
        for way in (1.0, -1.0):
            ahead = self.dynamics.moved(y[:n], way * LITTLE)
            tried = self._looking(modes, *ahead, moving=False)
            result = self.rates(tried, time, y)
            acceleration = self.dynamics.of_crank(result[n : 2 * n])
            if acceleration * way > 0 or modes.line.brake.state == HOLDING:
                return tried
            still = tried if acceleration == 0.0 else still
        if still is not None:
            return still
        if self.waits:
            return modes._replace(standing=True)
        raise SimulationError(STALLED, time, instant.angle)

    @cached_property
    def waits(self) -> bool:
        """Whether a press at rest may be started later: by the drive, a force in time, clutch or brake."""
        driven = self.driven
        drives = (driven.drive is not None and driven.drive.timed) or driven.clutch is not None or driven.brake is not None
        return drives or any(force.time is not None for force in self.driven.forces)

    def _looking(self, modes: Modes, position: Array, speed: Array, moving: bool) -> Modes:
        """The modes with every force put where it is at a state a little ahead."""
        instant = self.dynamics.at(position, speed)
        places = []
        for force, place in zip(self.driven.forces, modes.places, strict=True):
            value, rate = instant.coordinates[force.row]
            places.append(None if place is None else place_of(force, value, rate > 0, value, rate if moving else 0.0))
        return modes._replace(places=tuple(places))

    def after(self, switch: Switch, modes: Modes, time: float, y: Array, fastest: float) -> tuple[Modes, Array]:
        """Modes and vector after a switching.

        Raises:
            SimulationError: the press stalls.
        """
        if switch.what == "corner":
            sides = tuple(-side if k == switch.of else side for k, side in enumerate(modes.sides))
            return modes._replace(sides=sides), y
        instant = self.split(y)[0]
        stops = switch.what == "turn" and abs(instant.speed) <= AT_REST * fastest and self.dynamics.alone
        if stops and modes.line.brake.state == SLIPPING:  # what happens at rest is for the brake to decide
            return self._line_switched(Switch("grips", "brake"), "brake", modes, time, y)
        n = self.dynamics.size
        if switch.what == "starts":
            way = float(switch.of)
            return self._looking(modes, *self.dynamics.moved(y[:n], way * LITTLE), moving=False)._replace(standing=False), y
        if isinstance(switch.of, int):
            modes = self._force_switched(switch, switch.of, modes, time, y, fastest)
            if modes.standing:
                y = y.copy()
                y[n : 2 * n] = 0.0
            return modes, y
        return self._line_switched(switch, str(switch.of), modes, time, y)

    def _force_switched(self, switch: Switch, k: int, modes: Modes, time: float, y: Array, fastest: float) -> Modes:
        place, force = modes.places[k], self.driven.forces[k]
        assert place is not None
        instant, _, _ = self.split(y)
        value, rate = instant.coordinates[force.row]
        if switch.what == "contact":
            place = place._replace(pushing=not place.pushing)
        elif switch.what == "turn":
            if abs(instant.speed) <= AT_REST * fastest and self.dynamics.alone:  # not a dead centre: the crank itself stops
                n = self.dynamics.size
                rest = y.copy()
                rest[n : 2 * n] = 0.0
                return self.placed(modes, time, rest)
            inside = 0.5 * (max(place.low, value - 1.0) + min(place.high, value + 1.0))
            place = place_of(force, inside, not place.rising, value, rate)
        else:
            border = place.low if switch.what == "low" else place.high
            if switch.what == "low":
                following = max((b for b in force.borders() if b < border), default=border - 1.0)
            else:
                following = min((b for b in force.borders() if b > border), default=border + 1.0)
            place = place_of(force, 0.5 * (border + following), place.rising, border, rate)
        return modes._replace(places=(*modes.places[:k], place, *modes.places[k + 1 :]))

    def _line_switched(self, switch: Switch, which: str, modes: Modes, time: float, y: Array) -> tuple[Modes, Array]:
        n = self.dynamics.size
        instant, own, _ = self.split(y)
        relative = own - instant.speed if which == "clutch" else instant.speed
        friction: Clutch | Brake | None = self.driven.clutch if which == "clutch" else self.driven.brake
        assert friction is not None
        grip: Grip = getattr(modes.line, which)
        if switch.what == "opens":
            grip = Grip(OPEN, spent=True)
        elif switch.what == "closes":
            way = 1 if friction.opens is None or friction.opens.angle is None or friction.opens.angle > instant.angle else -1
            grip = Grip(SLIPPING, 1 if relative > 0 else -1, time, way=way) if relative else Grip(HOLDING, 0, time, way=way)
        elif switch.what == "grips":
            y = y.copy()
            if which == "clutch":
                y[2 * n + len(y[2 * n : -len(INTEGRALS)]) - 1] = instant.speed
            else:
                self.dynamics.stands(instant, time)
                y[n : 2 * n] = 0.0
            grip = grip._replace(state=HOLDING)
        else:
            held = self._held(modes, time, y, which, self.split(y))
            grip = grip._replace(state=SLIPPING, sign=1 if held > 0 else -1)
        modes = modes._replace(line=modes.line._replace(**{which: grip}))
        if switch.what == "grips":
            held = self._held(modes, time, y, which, self.split(y))
            if abs(held) > grip.capacity(friction, time):  # it cannot hold: it slips on, the other way
                grip = grip._replace(state=SLIPPING, sign=1 if held > 0 else -1)
                modes = modes._replace(line=modes.line._replace(**{which: grip}))
        if which == "brake" and switch.what in ("opens", "slips") and not instant.speed:
            modes = self.placed(modes, time, y)
        return modes, y
