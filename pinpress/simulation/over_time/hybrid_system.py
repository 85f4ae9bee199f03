"""A driven press as equations over time that switch: its modes, the rates in a mode, and how it stands.

In a mode everything is smooth: each force keeps its interval, each coupling its grip, and the drive its side of every corner of its torque,
even where an integrator looks beyond the end of the mode. Modes end at `events`. A brake is a coupling to the frame, whose speed is zero.

At rest all that depends on the direction of motion can give the torque needed: the brake, friction, loads that act one way, and gears with
losses. The crank rests as long as it would not start in either direction. Every stop of the crank and every change of a coupling ends in
`HybridSystem.going_on`, which decides that.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...common.errors import PinpressError, SimulationError
from ...common.quantities import Array
from ...drives.protocol import corners_of
from ...loads.caller_laws import LawError
from ...loads.process import ForceInterval
from ..coupling import HOLDING, OPEN, SLIPPING, CouplingMode, Side, coupling_at_start, sign_of
from ..driven_press import DrivenPress, GeneralizedForce
from ..failures import failure
from ..trajectory import INTEGRALS
from .equations_of_motion import Dynamics, FullDynamics

AHEAD = 1e-9  # time looked ahead to see into which interval a force goes, with several drivers, and what a clutch that closes does [s]
LITTLE = 1e-7  # crank angle looked ahead to see into which interval a force goes [rad]
# What holds at its limit lets go beyond this share more: without it rounding would decide, and it would hold and let go without end.
LETS_GO = 1e-9


class Snapshot(NamedTuple):
    """A state as forces see it."""

    linkage: Any  # as `Dynamics.at` returns it
    shaft_speed: float  # of the drive's shaft [rad/s]
    states: tuple[float, ...]  # of the drive


# ------------------------------------------------------------------------------------------------------------------------------- modes


class ForceMode(NamedTuple):
    """Mode of a force."""

    low: float  # value of its coordinate at which the mode ends [m]
    high: float  # the same above [m]
    rising: bool  # whether the coordinate rises
    interval: ForceInterval | None  # that acts there; None if none does
    pushing: bool = True  # whether the force pushes; False where a contact is lost


class Mode(NamedTuple):
    """Everything that switches."""

    clutch: CouplingMode  # mode of the clutch; a press without one has one that holds
    brake: CouplingMode  # mode of the brake, `SLIPPING` while it is closed, at rest too; a press without one has one that is open
    forces: tuple[ForceMode | None, ...]  # mode of every force; None of a force in time
    # for each corner of the drive's torque +1 where its shaft is faster, -1 where it is slower, 0 where it rests there
    sides: tuple[int, ...] = ()
    way: int | None = None  # +1 or -1, direction in which the crank turns, or starts; 0: it rests; None: nothing depends on the direction

    @property
    def rests(self) -> bool:
        return self.way == 0

    def coupling(self, side: Side) -> CouplingMode:
        return self.clutch if side == "clutch" else self.brake

    def with_coupling(self, side: Side, mode: CouplingMode) -> "Mode":
        if side == "clutch":
            return self._replace(clutch=mode)
        return self._replace(brake=mode._replace(grip=SLIPPING) if mode.grip is HOLDING else mode)

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
    if value in (low, high):  # where a stop is touched its force is zero, and rounding would tell whether it pushes
        value += 1e-6 * (inside - value)
    pushing = interval is None or not interval.one_sided or interval.pushes(float(interval.force(value - force.datum, rate)))
    return ForceMode(low, high, rising, interval, pushing)


# ------------------------------------------------------------------------------------------------------------------------------ system


@dataclass(frozen=True, eq=False)
class HybridSystem:
    """A driven press that is integrated over time.

    Its vector holds positions (size,), speeds (size,), the drive's states, the speed of a clutch's driving side if there is a clutch, and
    the integrals (4,).

    Attributes:
        dynamics: the linkage, as its crank alone or as all its joints.
        driven: the press with its parts.
    """

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
        clutch = coupling_at_start(driven.clutch, angle, turning, shaft - turning, missing=HOLDING)
        brake = coupling_at_start(driven.brake, angle, turning, -turning, missing=OPEN)
        y = np.concatenate([position, speed, states, integrals])
        forces = tuple(None if force.time is not None else ForceMode(-math.inf, math.inf, True, None) for force in driven.forces)
        mode = Mode(clutch, CouplingMode(OPEN), forces).with_coupling("brake", brake)
        return self.going_on(self.place_forces(self.past_corner(mode, y), time, y), time, y), y

    def at(self, y: Array) -> Snapshot:
        """The state of a vector."""
        n = self.dynamics.size
        linkage = self.dynamics.at(y[:n], y[n : 2 * n])
        states = tuple(y[2 * n : -len(INTEGRALS)].tolist())
        return Snapshot(linkage, linkage.speed, states) if self.driven.clutch is None else Snapshot(linkage, states[-1], states[:-1])

    def project(self, time: float, y: Array) -> Array:
        """The vector with closed loops; the same vector where no loop can be open."""
        n = self.dynamics.size
        try:
            closed = self.dynamics.project(y[:n], y[n : 2 * n])
        except PinpressError as error:
            raise failure("loops open", time, error=error) from error
        return y if closed is None else np.concatenate([*closed, y[2 * n :]])

    def cannot_go_on(self, time: float, y: Array, message: str | None = None) -> SimulationError:
        """The error of an integration that cannot go on from a vector."""
        angle = float(self.at(y).linkage.angle)
        return failure("cannot go on", time, angle if math.isfinite(angle) else None, message=message or "values are not finite")

    def driving(self, times: Array, columns: Array, modes: Sequence[Mode]) -> tuple[Array, Array, Array]:
        """Torque of the drive, torque of its motor at its own shaft [N m], and speed of the drive's side of the clutch [rad/s], (n,) each.

        Args:
            times: (n,) [s].
            columns: (len(y), n) vectors at these times.
            modes: at these times.
        """
        n, drive, crank = self.dynamics.size, self.driven.drive, self.dynamics.crank
        speeds = columns[n + crank] if self.driven.clutch is None else columns[-len(INTEGRALS) - 1]
        if drive is None:
            return np.zeros(len(times)), np.zeros(len(times)), speeds
        states = self.drive_states(columns).T.tolist()
        on_side = [self._on_side(mode, speed) for mode, speed in zip(modes, speeds.tolist(), strict=True)]
        arguments = list(zip(on_side, columns[crank].tolist(), times.tolist(), map(tuple, states), strict=True))
        torque, motor = (np.array([float(np.ravel(law(*row))[0]) for row in arguments]) for law in (drive.torque, drive.motor_torque))
        return torque, motor, speeds

    def drive_states(self, columns: Array) -> Array:
        """(k, n) the drive's own states of vectors (len(y), n)."""
        return columns[2 * self.dynamics.size : -len(INTEGRALS) - (self.driven.clutch is not None)]

    def past_corner(self, mode: Mode, y: Array) -> Mode:
        """The mode in which the drive has passed to the other side of the corner that its shaft has reached; at the start each side is set
        by the speed."""
        corners = self.driven.corners
        if not corners:
            return mode
        shaft_speed = self.at(y).shaft_speed
        sides = mode.sides or (0,) * len(corners)
        near = min(range(len(corners)), key=lambda k: abs(shaft_speed - corners[k]))
        return mode._replace(
            sides=tuple(
                -side if side and k == near else side or (1 if shaft_speed >= corner else -1)
                for k, (corner, side) in enumerate(zip(corners, sides, strict=True))
            )
        )

    # Rates

    def rates(self, mode: Mode, time: float, y: Array) -> Array:
        """dy/dt (len(y),)."""
        try:
            return self._rates(mode, time, y)
        except LawError as error:
            raise error.within(time, float(self.at(y).linkage.angle)) from error.__cause__

    def _rates(self, mode: Mode, time: float, y: Array) -> Array:
        n, driven = self.dynamics.size, self.driven
        linkage, shaft_speed, states = snapshot = self.at(y)
        torque = self.drive_torque(mode, time, snapshot)
        forces, load_power, put_in, squared = self._forces(mode, time, linkage)
        through, braking = self._coupling_torques(mode, time)
        rigid, result, accelerated, rubbing = mode.clutch.grip is HOLDING, np.zeros(len(y)), 0.0, 0.0
        if not mode.rests:
            if driven.held:
                accelerations, holding = self._all_joints.holding(linkage, forces)
                put_in += float(holding.dot(y[n : 2 * n][self._all_joints.held]))
            else:
                accelerations, rubbing = self._accelerations(mode, linkage, torque if rigid else through, braking, forces)
            result[:n], result[n : 2 * n] = y[n : 2 * n], accelerations
            accelerated = self.dynamics.of_crank(accelerations)
        if driven.drive is not None and states:
            result[2 * n : 2 * n + len(states)] = driven.drive.rates(shaft_speed, linkage.angle, time, states)
        if driven.clutch is not None:
            result[2 * n + len(states)] = accelerated if rigid else (torque - through) / driven.inertia
        motor = 0.0 if driven.drive is None else driven.drive.motor_torque(self._on_side(mode, shaft_speed), linkage.angle, time, states)
        lost = through * (shaft_speed - linkage.speed) - (braking + rubbing) * linkage.speed
        result[-len(INTEGRALS) :] = (torque * shaft_speed + put_in, load_power, motor * motor + squared, lost)
        return result

    def held_efforts(self, mode: Mode, time: float, y: Array) -> Array:
        """Efforts (held,) that hold the speeds of motors."""
        linkage = self.at(y).linkage
        return self._all_joints.holding(linkage, self._forces(mode, time, linkage)[0])[1]

    @property
    def _all_joints(self) -> FullDynamics:
        """The linkage as all its joints, which is how one with several drivers is integrated."""
        assert isinstance(self.dynamics, FullDynamics)
        return self.dynamics

    def _coupling_torques(self, mode: Mode, time: float) -> tuple[float, float]:
        """Friction torques on the crank of a clutch that slips, and of a brake while the crank turns [N m]."""
        clutch, brake = self.driven.clutch, self.driven.brake
        through = 0.0 if clutch is None or mode.clutch.grip is not SLIPPING else mode.clutch.sign * mode.clutch.capacity(clutch, time)
        braking = 0.0 if brake is None or mode.brake.grip is OPEN else -(mode.way or 0) * mode.brake.capacity(brake, time)
        return through, braking

    def _accelerations(self, mode: Mode, linkage: Any, torque: float, braking: float, forces: Sequence[float]) -> tuple[Any, float]:
        """Accelerations (size,) of the linkage where its crank is free to turn, and the torque of the bearings' friction on the crank;
        ``torque``: of the drive, or of a clutch that does not hold."""
        inertia = self.driven.inertia if mode.clutch.grip is HOLDING else 0.0
        rubbing = self._bearing_friction(mode, linkage, torque + braking, forces, inertia)
        return self.dynamics.accelerations(linkage, torque + braking + rubbing, forces, inertia), rubbing

    def _bearing_friction(self, mode: Mode, linkage: Any, torque: float, forces: Sequence[float], inertia: float) -> float:
        """Torque of the bearings' friction on the crank; other arguments as of `Dynamics.accelerations`."""
        bearings, way = self.driven.bearing_model, mode.way
        if bearings is None or not way:
            return 0.0
        total = linkage.inertia + inertia
        net = torque - linkage.weight - 0.5 * linkage.inertia_slope * linkage.speed * linkage.speed
        net += sum(force * lever for force, lever in zip(forces, linkage.levers, strict=False))
        if not math.isfinite(net) or not total > 0:  # makes an integrator that looks ahead try a shorter step
            return math.nan
        return bearings.torque_at(linkage.angle, way, linkage.speed, net, total, forces)

    def _forces(self, mode: Mode, time: float, linkage: Any) -> tuple[list[float], float, float, float]:
        """The forces along every coordinate, the power taken by loads, the power of further drives, and the sum of the squares of these
        drives' motor torques."""
        forces, load_power, put_in, squared = [0.0] * len(linkage.coordinates), 0.0, 0.0, 0.0
        for force, place in zip(self.driven.forces, mode.forces, strict=True):
            value, rate = linkage.coordinates[force.row]
            if force.drive is not None:
                size = float(force.drive.torque(rate, value, time))
            elif force.time is not None:
                size = float(force.time(time))
            elif place is None or place.interval is None or not place.pushing:
                size = 0.0
            else:
                size = float(place.interval.force(value - force.datum, rate))
            forces[force.row] += size
            if force.drive is None:
                load_power -= size * rate
            else:
                put_in += size * rate
                squared += float(force.drive.motor_torque(rate, value, time)) ** 2
        if (law := self.driven.law) is not None:
            for row, effort in zip(law.rows, law.among(time, linkage.coordinates).tolist(), strict=True):
                forces[row] += effort
                put_in += effort * linkage.coordinates[row][1]
                squared += effort**2
        return forces, load_power, put_in, squared

    def drive_torque(self, mode: Mode, time: float, snapshot: Snapshot) -> Any:
        """Torque of the drive at the driver joint [N m]."""
        if self.driven.drive is None:
            return 0.0
        speed = self._on_side(mode, snapshot.shaft_speed)
        return self.driven.drive.torque(speed, snapshot.linkage.angle, time, snapshot.states)

    def _on_side(self, mode: Mode, speed: float) -> float:
        """A speed of the drive's shaft [rad/s], limited to the mode's side of those at which the torque jumps."""
        for k, corner in self._jumps:
            side = mode.sides[k]
            if side:
                # At the speed of a jump rounding would choose the side: the torque is asked this share of the speed, or
                # rad/s at rest, away from it.
                beside = corner + side * 1e-12 * (abs(corner) or 1.0)
                speed = max(speed, beside) if side > 0 else min(speed, beside)
        return speed

    @cached_property
    def _jumps(self) -> tuple[tuple[int, float], ...]:
        """Places and speeds of the corners at which the drive's torque jumps. Gears with losses name standstill as a plain corner."""
        drive, corners = self.driven.drive, self.driven.corners
        return () if drive is None else tuple((k, corners[k]) for k, (_, jump) in enumerate(corners_of(drive)) if jump or not corners[k])

    def acceleration(self, mode: Mode, time: float, snapshot: Snapshot) -> float:
        """Acceleration of the crank where it is free to turn [rad/s2]."""
        forces = self._forces(mode, time, snapshot.linkage)[0]
        through, braking = self._coupling_torques(mode, time)
        torque = self.drive_torque(mode, time, snapshot) if mode.clutch.grip is HOLDING else through
        return self.dynamics.of_crank(self._accelerations(mode, snapshot.linkage, torque, braking, forces)[0])

    # Standstill

    def place_forces(self, mode: Mode, time: float, y: Array) -> Mode:
        """The mode with every force in its interval; at rest that of the direction in which the crank starts, or in which it rests.

        Raises:
            SimulationError: loads alone hold a crank in both directions, and nothing that depends on time can change that.
        """
        n, driven = self.dynamics.size, self.driven
        position, speed = y[:n], y[n : 2 * n]
        linkage = self.dynamics.at(position, speed)
        if not self.dynamics.alone:  # the first crank's rest is not the linkage's
            return self._place_forces_at(mode, position + AHEAD * speed, speed, moving=True)
        if linkage.speed:
            mode = self.turning(mode, sign_of(linkage.speed))
            return self._place_forces_at(mode, position + LITTLE / abs(linkage.speed) * speed, speed, moving=True)
        forward, back = tried = self.starting(mode, y, 1), self.starting(mode, y, -1)
        if forward == back:  # neither a force nor a direction matters
            return forward
        start = self.start(*tried, time, y)
        if start is not None:
            return start
        loads_hold = any(
            a is not None and b is not None and a.interval is not b.interval for a, b in zip(forward.forces, back.forces, strict=True)
        )
        may_start_later = self.varies or driven.clutch is not None or driven.brake is not None
        strikes = driven.press.advancing.any()  # the slide of a screw or rack comes to rest in every blow
        if loads_hold and driven.friction is None and not (may_start_later or strikes):
            raise failure("stalls", time, linkage.angle)
        return mode._replace(way=0, sides=self._sides_of_crank(mode, 0))

    def start(self, forward: Mode, back: Mode, time: float, y: Array) -> Mode | None:
        """Which of the modes in which the crank may start from rest it does; None: neither, it rests."""
        rising, falling = self.tending(forward, time, y), -self.tending(back, time, y)
        if rising == falling == 0.0 and not self.varies:  # an equilibrium in which nothing holds it
            return forward
        if max(rising, falling) > self.holding(rising, falling):
            return forward if rising > falling else back
        return None

    def holding(self, rising: float, falling: float) -> float:
        """Acceleration that what holds a crank at rest withstands, from those with which it would start forward and back [rad/s2]."""
        return max(LETS_GO * abs(rising + falling), self._rounding)

    @cached_property
    def _rounding(self) -> float:
        """Acceleration that rounding of the weights leaves at a dead centre [rad/s2]. It must not choose the way of a press that a drive or
        a force will move in time."""
        if not self.varies:
            return 0.0
        press = self.driven.press
        arm = press.size if press.driver_coordinates[0].turns else 1.0
        return 100 * float(np.finfo(float).eps * np.linalg.norm(press.model.gravity.linear)) / arm

    def going_on(self, mode: Mode, time: float, y: Array) -> Mode:
        """The mode after a stop of the crank or a change of a coupling. Raises as `place_forces`."""
        snapshot = self.at(y)
        mode = self.turning(mode, sign_of(snapshot.linkage.speed)) if snapshot.linkage.speed else self.place_forces(mode, time, y)
        if mode.clutch.grip is HOLDING and self.clutch_reserve(mode, *self._rising(mode, time, y)) < 0:
            return self.clutch_slips(mode, time, y)
        if 0 in mode.sides and mode.clutch.grip is not HOLDING:  # the shaft leaves its rest without the crank
            way = sign_of(float(self.drive_torque(mode, time, snapshot)) - self._coupling_torques(mode, time)[0])
            mode = mode._replace(sides=tuple(side or way for side in mode.sides))
        return mode

    def clutch_slips(self, mode: Mode, time: float, y: Array) -> Mode:
        """The mode after a clutch that holds has let go. Raises as `place_forces`."""
        clutch = mode.clutch.slipping(self._clutch_torque(mode, *self._rising(mode, time, y)))
        return self.going_on(mode._replace(clutch=clutch), time, y)

    def _rising(self, mode: Mode, time: float, y: Array) -> tuple[float, Snapshot]:
        """Time and state at which to decide whether a clutch holds: a little later where its torque only begins to rise. The one that it
        has to transmit may be zero there too, but for rounding."""
        clutch = self.driven.clutch
        if clutch is not None and not mode.clutch.capacity(clutch, time):
            time, y = time + AHEAD, y + AHEAD * self.rates(mode, time, y)
        return time, self.at(y)

    @cached_property
    def varies(self) -> bool:
        """Whether the drive or a force changes with time, other than where a clutch or brake is switched."""
        drive = self.driven.drive
        return (drive is not None and drive.timed) or any(force.time is not None for force in self.driven.forces)

    def starting(self, mode: Mode, y: Array, way: int) -> Mode:
        """The mode in which the crank of a vector starts from rest; ``way``: +1 or -1, the direction."""
        mode = self.turning(mode, way)
        return (
            self._place_forces_at(mode, *self.dynamics.move_crank(y[: self.dynamics.size], way * LITTLE), moving=False)
            if mode.forces
            else mode
        )

    def turning(self, mode: Mode, way: int) -> Mode:
        """The mode of a crank that turns in a direction, +1 or -1; forces stay in their intervals."""
        directed = self._has_direction or mode.brake.grip is not OPEN
        return mode._replace(way=way, sides=self._sides_of_crank(mode, way)) if directed else mode._replace(way=None)

    @cached_property
    def _has_direction(self) -> bool:
        """Whether a load, friction or the drive depends on the direction in which the crank turns."""
        driven = self.driven
        one_way = any(force.rising is not force.falling for force in driven.forces)
        return self.dynamics.alone and (one_way or driven.friction is not None or 0.0 in driven.corners)

    def _sides_of_crank(self, mode: Mode, way: int) -> tuple[int, ...]:
        """The sides of the corners of the drive's torque, where its shaft passes standstill with the crank."""
        if mode.clutch.grip is not HOLDING:
            return mode.sides
        return tuple(side if corner else way for corner, side in zip(self.driven.corners, mode.sides, strict=True))

    def _place_forces_at(self, mode: Mode, position: Array, speed: Array, moving: bool) -> Mode:
        """The mode in which every force is in its interval at a state a little ahead."""
        linkage = self.dynamics.at(position, speed)
        places = []
        for force, place in zip(self.driven.forces, mode.forces, strict=True):
            value, rate = linkage.coordinates[force.row]
            places.append(None if place is None else force_mode(force, value, rate > 0, value, rate if moving else 0.0))
        return mode._replace(forces=tuple(places))

    def tending(self, mode: Mode, time: float, y: Array) -> float:
        """Acceleration with which a crank at rest would start in a mode [rad/s2]."""
        snapshot = self.at(y)  # computed again: `starting` has moved the linkage
        try:
            return self.acceleration(mode, time, snapshot)
        except LawError as error:
            raise error.within(time, float(snapshot.linkage.angle)) from error.__cause__

    def clutch_reserve(self, mode: Mode, time: float, snapshot: Snapshot) -> float:
        """By how much the torque at which a clutch that holds lets go is larger than the one that it has to transmit [N m]."""
        clutch = self.driven.clutch
        if clutch is None:
            return math.inf
        return float((1 + LETS_GO) * mode.clutch.capacity(clutch, time) - abs(self._clutch_torque(mode, time, snapshot)))

    def _clutch_torque(self, mode: Mode, time: float, snapshot: Snapshot) -> float:
        """Torque on the crank that the clutch has to transmit to hold [N m]."""
        torque = float(self.drive_torque(mode, time, snapshot))
        return torque if mode.rests else torque - self.driven.inertia * self.acceleration(mode, time, snapshot)
