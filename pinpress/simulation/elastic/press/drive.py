"""What turns the free crank of a press on springs: its drive with states of its own, flywheel, clutch and brake, and how they switch.

It has coordinates of its own, which stand before those of the bodies. A state of the drive is the rate of one of them, so that its
equation is one of second order too. Where there is a clutch, the slip is how far its driving side has turned ahead of the crank. With the
speeds w of the crank and s of the slip, the flywheel's inertia I turns with w + s; the drive's torque T and the clutch's torque C have the
power T (w + s) - C s. Sides that hold each other keep their speed: the row of the slip (of the crank, where the brake holds it) then has no
other acceleration in it and no force, so that a slip of zero stays zero.

In a mode everything is smooth: couplings are open, slip or hold, and the drive stays on its side of the speeds at which its torque jumps.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np

from ....common.quantities import Array
from ....drives.protocol import Drive, corners_of
from ....drives.transmission import Coupling
from ...coupling import HOLDING, OPEN, SLIPPING, CouplingMode, Side, coupling_at_start
from ...driven_press import DrivenPress

STEP = 1e-6  # share of a speed, angle or state by which slopes of the drive are found
BESIDE = 1e-12  # share of a speed: so far from a jump of its torque a drive is asked, on the side of the mode
SIDES: tuple[Side, ...] = ("clutch", "brake")


class TrainMode(NamedTuple):
    """Everything of a drive train that switches.

    Attributes:
        clutch: mode of the clutch; a press without one has one that holds.
        brake: mode of the brake; a press without one has one that is open.
        faster: for each speed at which the drive's torque jumps, whether its shaft is faster.
    """

    clutch: CouplingMode
    brake: CouplingMode
    faster: tuple[bool, ...] = ()

    def coupling(self, side: Side) -> CouplingMode:
        return self.clutch if side == "clutch" else self.brake

    def with_coupling(self, side: Side, mode: CouplingMode) -> TrainMode:
        return self._replace(clutch=mode) if side == "clutch" else self._replace(brake=mode)


class TrainEvent(NamedTuple):
    """What ends a mode.

    Attributes:
        kind: a coupling is switched at its angle, its sides come to the same speed, it begins to slip, or the drive's shaft passes a speed
            at which its torque jumps.
        side: which coupling.
        number: of that speed.
    """

    kind: Literal["switches", "grips", "slips", "jumps"]
    side: Side = "clutch"
    number: int = 0


class Slopes(NamedTuple):
    """Derivatives of a quantity at n states by all coordinates and rates.

    Attributes:
        by_place: (n, size).
        by_rate: (n, size).
    """

    by_place: Array
    by_rate: Array


@dataclass(frozen=True, eq=False)
class DriveTrain:
    """The drive train of a press whose crank turns freely.

    Attributes:
        driven: the press with drive, flywheel, clutch and brake.
        scale: of each state of the drive, the rate of its coordinate by it.
    """

    driven: DrivenPress
    scale: tuple[float, ...] = ()

    @property
    def drive(self) -> Drive | None:
        return self.driven.drive

    @property
    def count(self) -> int:
        """Number of its coordinates."""
        return len(self.scale) + (self.driven.clutch is not None)

    @property
    def slip(self) -> int | None:
        """Number of the slip among its coordinates; None if there is no clutch."""
        return None if self.driven.clutch is None else len(self.scale)

    @property
    def inertia(self) -> float:
        """Of flywheel and drive, at the crank [kg m2]."""
        return float(self.driven.inertia)

    @cached_property
    def jumps(self) -> tuple[float, ...]:
        """Speeds of the drive's shaft at which its torque jumps [rad/s]."""
        corners = () if self.drive is None else corners_of(self.drive)
        return tuple(float(speed) for speed, jump in corners if jump and speed)

    @cached_property
    def switch_times(self) -> Array:
        """Times at which a coupling is switched [s], rising."""
        couplings = [coupling for coupling in map(self.coupling, SIDES) if coupling is not None]
        points = [point for coupling in couplings for point in (coupling.closes, coupling.opens) if point is not None]
        return np.unique([point.time for point in points if point.time is not None])

    def risen(self, mode: TrainMode) -> list[float]:
        """Times at which closed couplings have their whole torque [s]."""
        parts = [(self.coupling(side), mode.coupling(side)) for side in SIDES]
        return [state.since + part.rise for part, state in parts if part is not None and part.rise and np.isfinite(state.since)]

    def coupling(self, side: Side) -> Coupling | None:
        return self.driven.clutch if side == "clutch" else self.driven.brake

    @property
    def timed(self) -> bool:
        """Whether its torques depend on time."""
        couplings = [self.coupling(side) for side in SIDES]
        return (self.drive is not None and self.drive.timed) or any(coupling is not None and coupling.rise > 0 for coupling in couplings)

    # ------------------------------------------------------------------------------------------------------------------------- equations

    def begun(self, angle: float, speed: float) -> tuple[TrainMode, Array]:
        """Mode and rates (count,) at the start, with the crank at an angle and speed."""
        flywheel = self.driven.flywheel
        shaft = speed if flywheel is None or flywheel.speed is None or self.driven.clutch is None else flywheel.speed
        clutch = coupling_at_start(self.driven.clutch, angle, speed, shaft - speed, missing=HOLDING)
        brake = coupling_at_start(self.driven.brake, angle, speed, -speed, missing=OPEN)
        states = () if self.drive is None else self.drive.state
        rates = [scale * state for scale, state in zip(self.scale, states, strict=True)]
        if self.driven.clutch is not None:
            rates.append(shaft - speed)
        return TrainMode(clutch, brake, tuple(shaft >= speed for speed in self.jumps)), np.array(rates)

    @cached_property
    def engaged(self) -> TrainMode:
        """The mode of a press that runs with its drive."""
        return TrainMode(CouplingMode(HOLDING), CouplingMode(OPEN))

    def mass(self, bodies: Array, mode: TrainMode | None = None) -> Array:
        """(count + f, count + f) mass matrix, with that of the bodies (f, f): in a mode for its equations, without one for the energy."""
        n = self.count
        matrix = np.zeros((n + len(bodies),) * 2)
        matrix[n:, n:] = bodies
        matrix[np.arange(n), np.arange(n)] = 1.0
        matrix[-1, -1] += self.inertia
        if self.slip is not None:
            matrix[self.slip, self.slip] = matrix[self.slip, -1] = matrix[-1, self.slip] = self.inertia
        if mode is not None:
            for row in self._held(mode):
                diagonal = matrix[row, row]
                matrix[row] = matrix[:, row] = 0.0
                matrix[row, row] = diagonal
        return matrix

    def _held(self, mode: TrainMode) -> list[int]:
        """Coordinates whose rates a mode holds."""
        slip = [] if self.slip is None or mode.clutch.grip is not HOLDING else [self.slip]
        return [*slip, *([-1] if mode.brake.grip is HOLDING else [])]

    def add(self, mode: TrainMode, time: Array, y: Array, v: Array, to: tuple[Array, Array, Array], held: bool = True) -> None:
        """Add its forces ``to`` those of all coordinates (n, size), and minus their derivatives (n, size, size); where ``held``, no force
        acts on what the mode holds."""
        force, stiffness, damping = to
        force += self.pushes(mode, time, y, v)
        torque = self.torque_slopes(mode, time, y, v)
        rows = [(row, torque) for row in ([-1] if self.slip is None else [-1, self.slip])]
        for row, (by_place, by_rate) in [*rows, *enumerate(self._state_slopes(time, y, v))]:
            stiffness[:, row] -= by_place
            damping[:, row] -= by_rate
        for row in self._held(mode) if held else ():
            force[:, row], stiffness[:, row], damping[:, row] = 0.0, 0.0, 0.0

    def pushes(self, mode: TrainMode, time: Array, y: Array, v: Array) -> Array:
        """Its forces (n, size) on all coordinates."""
        forces, torque = np.zeros_like(y), self.torque(mode, time, y, v)
        forces[:, -1] = torque + self.friction(mode, "brake", time)
        if self.slip is not None:
            forces[:, self.slip] = torque - self.friction(mode, "clutch", time)
        if self.drive is not None and self.scale:
            rates = self.drive.rates(self.shaft_speed(v), y[:, -1], time, self.states(v))
            for row, (scale, rate) in enumerate(zip(self.scale, rates, strict=True)):
                forces[:, row] = scale * rate
        return forces

    def friction(self, mode: TrainMode, side: Side, time: Array) -> Array:
        """Torque (n,) of a coupling on the crank while it slips; else zero [N m]."""
        coupling, state = self.coupling(side), mode.coupling(side)
        if coupling is None or state.grip is not SLIPPING:
            return np.zeros(len(time))
        return np.asarray(state.sign * (state.capacity(coupling, time) + np.zeros(len(time))))

    def shaft_speed(self, v: Array) -> Array:
        """(n,) speed of the drive's shaft [rad/s], of rates (n, size)."""
        return v[:, -1] if self.slip is None else np.asarray(v[:, -1] + v[:, self.slip])

    def states(self, v: Array) -> tuple[Array, ...]:
        """(n,) each of the drive's states, of rates (n, size)."""
        return tuple(v[:, k] / scale for k, scale in enumerate(self.scale))

    def torque(self, mode: TrainMode, time: Array, y: Array, v: Array) -> Array:
        """Torque (n,) of the drive [N m]."""
        if self.drive is None:
            return np.zeros(len(time))
        torque = self.drive.torque(self._on_side(mode, self.shaft_speed(v)), y[:, -1], time, self.states(v))
        return np.broadcast_to(torque, time.shape)

    def torque_slopes(self, mode: TrainMode, time: Array, y: Array, v: Array) -> Slopes:
        """Derivatives of the drive's torque."""
        drive = self.drive
        if drive is None:
            return Slopes(np.zeros(y.shape), np.zeros(y.shape))
        return self._slopes(lambda speed, angle, states: drive.torque(self._on_side(mode, speed), angle, time, states), y, v)

    def motor_torque(self, mode: TrainMode, time: Array, y: Array, v: Array) -> Array:
        """(n,) at the motor's own shaft [N m]."""
        if self.drive is None:
            return np.zeros(len(time))
        torque = self.drive.motor_torque(self._on_side(mode, self.shaft_speed(v)), y[:, -1], time, self.states(v))
        return np.broadcast_to(torque, time.shape)

    def _on_side(self, mode: TrainMode, speed: Array) -> Array:
        """Speeds (n,) on the mode's side of those at which the torque jumps."""
        for jump, faster in zip(self.jumps, mode.faster, strict=False):
            beside = jump + (1 if faster else -1) * BESIDE * abs(jump)
            speed = np.maximum(speed, beside) if faster else np.minimum(speed, beside)
        return speed

    def _state_slopes(self, time: Array, y: Array, v: Array) -> list[Slopes]:
        drive, slopes = self.drive, []
        for k, scale in enumerate(self.scale):

            def law(speed: Array, angle: Array, states: tuple[Array, ...], k: int = k, scale: float = scale) -> Array:
                assert drive is not None
                return scale * np.asarray(drive.rates(speed, angle, time, states)[k])

            slopes.append(self._slopes(law, y, v))
        return slopes

    def _slopes(self, law: Any, y: Array, v: Array) -> Slopes:
        """Central differences of a law of the shaft's speed, the crank's angle and the drive's states."""
        speed, angle, states = self.shaft_speed(v), y[:, -1], self.states(v)
        by_place, by_rate = np.zeros(y.shape), np.zeros(v.shape)
        step = STEP * (float(np.abs(speed).max()) or 1.0)
        slope = (np.asarray(law(speed + step, angle, states)) - law(speed - step, angle, states)) / (2 * step)
        by_rate[:, -1] = slope
        if self.slip is not None:
            by_rate[:, self.slip] = slope
        if self.drive is not None and self.drive.timed:
            by_place[:, -1] = (np.asarray(law(speed, angle + STEP, states)) - law(speed, angle - STEP, states)) / (2 * STEP)
        for k, scale in enumerate(self.scale):
            step = STEP * (float(np.abs(states[k]).max()) or 1.0)
            ends = [law(speed, angle, (*states[:k], states[k] + way * step, *states[k + 1 :])) for way in (1, -1)]
            by_rate[:, k] = (np.asarray(ends[0]) - ends[1]) / (2 * step * scale)
        return Slopes(by_place, by_rate)

    def lost(self, mode: TrainMode, time: Array, v: Array) -> Array:
        """(n,) power lost in clutch and brake [W]."""
        power = -self.friction(mode, "brake", time) * v[:, -1]
        return power if self.slip is None else power + self.friction(mode, "clutch", time) * v[:, self.slip]

    # ------------------------------------------------------------------------------------------------------------------------- switching

    def due(self, mode: TrainMode, time: float, v: Array) -> TrainMode:
        """The mode after the couplings have been switched whose time it is; ``v``: rates (size,)."""
        for side in SIDES:
            point = mode.coupling(side).next_switch(self.coupling(side))
            if point is not None and point.time is not None and time >= point.time - BESIDE * max(1.0, abs(point.time)):
                mode = self._switched(mode, side, time, v)
        return mode

    def _switched(self, mode: TrainMode, side: Side, time: float, v: Array) -> TrainMode:
        return mode.with_coupling(side, mode.coupling(side).switched(float(self._relative(side, v[None])[0]), time))

    def _relative(self, side: Side, v: Array) -> Array:
        """(n,) speed of a coupling's other side relative to the crank, of rates (n, size)."""
        if side == "brake":
            return -v[:, -1]
        assert self.slip is not None
        return v[:, self.slip]

    def events(self, mode: TrainMode, direction: int, angle: float) -> list[TrainEvent]:
        """What may end a mode except for what happens at a given time; the crank is at an angle and turns in a direction."""
        events = [TrainEvent("jumps", number=k) for k in range(len(mode.faster))]
        for side in SIDES:
            state = mode.coupling(side)
            point = state.next_switch(self.coupling(side))
            if point is not None and point.angle is not None and (point.angle - angle) * direction > 0:
                events.append(TrainEvent("switches", side))
            if self.coupling(side) is not None and state.grip is not OPEN:
                events.append(TrainEvent("slips" if state.grip is HOLDING else "grips", side))
        return events

    def margin(self, event: TrainEvent, mode: TrainMode, direction: int, size: int) -> tuple[Array, float]:
        """How far an event is away that needs no accelerations, positive in the mode: its derivative (2 size,) by coordinates and rates, in
        which it is linear, and what it is where these are zero."""
        slopes = np.zeros(2 * size)
        if event.kind == "jumps":
            sign = 1.0 if mode.faster[event.number] else -1.0
            slopes[[-1] if self.slip is None else [-1, size + self.slip]] = sign
            return slopes, -sign * self.jumps[event.number]
        coupling = mode.coupling(event.side)
        if event.kind == "switches":
            point = coupling.next_switch(self.coupling(event.side))
            assert point is not None
            assert point.angle is not None
            slopes[size - 1] = -direction
            return slopes, direction * point.angle
        if event.side == "brake":
            slopes[-1] = -coupling.sign
        else:
            assert self.slip is not None
            slopes[size + self.slip] = coupling.sign
        return slopes, 0.0

    def after(self, event: TrainEvent, mode: TrainMode, time: float, v: Array, held: float) -> tuple[TrainMode, Array]:
        """Mode and rates (size,) after an event; ``held``: torque on the crank of a coupling that has held [N m]."""
        v = v.copy()
        if event.kind == "jumps":
            faster = tuple(above != (k == event.number) for k, above in enumerate(mode.faster))
            return mode._replace(faster=faster), v
        if event.kind == "switches":
            return self._switched(mode, event.side, time, v), v
        state = mode.coupling(event.side)
        if event.kind == "slips":
            return mode.with_coupling(event.side, state.slipping(held)), v
        if event.side == "clutch":
            v[self.slip] = 0.0
        else:
            if self.slip is not None and mode.clutch.grip is not HOLDING:  # its driving side turns on
                v[self.slip] += v[-1]
            v[-1] = 0.0
        return mode.with_coupling(event.side, state._replace(grip=HOLDING)), v


def drive_train(driven: DrivenPress, speed: float, period: float, displacement: float) -> DriveTrain:
    """The drive train of a press.

    Args:
        driven: the press.
        speed: of the crank, about [rad/s].
        period: in which a state of the drive, as large as it becomes, changes its coordinate by ``displacement`` [s].
        displacement: to which errors of coordinates are compared [m or rad].
    """
    if driven.drive is None:
        return DriveTrain(driven)
    sizes = _state_sizes(driven.drive, speed, period)
    return DriveTrain(driven, tuple(displacement / (size * period) for size in sizes))


def _state_sizes(drive: Drive, speed: float, period: float) -> list[float]:
    """About how large the states of a drive become: as at its start, or where they settle at some speeds, or in a period."""
    state, sizes = tuple(map(float, drive.state)), [abs(value) for value in drive.state]
    for share in (0.0, 0.5, 1.0):
        rates = drive.rates(share * speed, 0.0, 0.0, state)
        for k in range(len(sizes)):
            step = STEP * (abs(state[k]) or 1.0)
            beside = drive.rates(share * speed, 0.0, 0.0, (*state[:k], state[k] + step, *state[k + 1 :]))
            pace = max(abs(float(beside[k]) - float(rates[k])) / step, 1 / period)
            sizes[k] = max(sizes[k], abs(float(rates[k])) / pace)
    return [size or 1.0 for size in sizes]
