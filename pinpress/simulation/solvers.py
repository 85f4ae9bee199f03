"""The two methods of simulation, from a state to a time."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.arrays import Array
from ..common.errors import SimulationError
from ..drives.driveline import Brake, Clutch, Driveline, Mode
from ..drives.transmission import Drive, Flywheel, PrescribedSpeed
from ..kinematics.motion import carried, cycle
from ..linkage.linkage import Linkage
from ..loads.caller_laws import LawError
from ..loads.link import Load
from . import angle_segments as turned
from . import angle_solver as turning
from . import mesh_refinement as resolution
from . import reduced_model as reduced
from . import system as scene
from .angle_segments import Resting, State
from .force_coordinates import JointAngle
from .protocol_checks import check_drive
from .reduced_model import COORDINATES, INERTIA, POTENTIAL, Table, tabulated
from .system import Scene
from .trajectory import LEDGERS, Path, Segment

if TYPE_CHECKING:
    from .hybrid_system import Machine
    from .time_solver import Stepped

AGAIN = 4.0  # times the kinetic energy at which the crank stopped turning for sure, from which it is followed over its angle again

BESIDE = 1e-7  # share of a speed to both sides of it
JUMP = 1e-3  # change of the torque within that, beside its size nearby, that is one
CLOSER = 4  # steps of Newton's method to the end of a period
PATIENCE = 20.0  # times as long as a period should take, that it may
LITTLE = 1e-4  # kinetic energy, beside the range of the potential one, below which the crank is not followed over its angle

Progress = Callable[[float], None]


@dataclass(frozen=True, eq=False)
class Plan:
    """A scene with its driveline; where there are several drivers, what flywheels and drives add to the inertia of each (drivers,)."""

    scene: Scene
    line: Driveline
    inertia: Array

    @property
    def timed(self) -> bool:
        """Whether anything depends on more than crank angle and speed."""
        line = self.line
        switched = line.clutch is not None or line.brake is not None or any(force.time is not None for force in self.scene.forces)
        drive = self.scene.drive
        return switched or (drive is not None and not isinstance(drive, PrescribedSpeed) and (drive.timed or _jumps(drive)))

    @cached_property
    def table(self) -> Table:
        """The press over its crank angle, with the scene's coordinates."""
        press, coordinates = self.scene.press, self.scene.coordinates
        if len(coordinates) == (press.slide is not None):
            return tabulated(press)
        return reduced.build(press, [partial(coordinate.over, press) for coordinate in coordinates])

    @cached_property
    def edges(self) -> tuple[Array, ...]:
        """Crank angles in the table's range at which a force is not smooth: borders of its stretches, turns of its coordinate."""
        found = []
        for force in self.scene.forces:
            row, borders = COORDINATES + force.row, force.borders()
            found += [reduced.roots(self.table, row, border) for border in borders]
            if borders:
                found.append(reduced.roots(self.table, row, 0.0, slope=True))
        return tuple(found)

    @cached_property
    def breaks(self) -> tuple[float, ...]:
        """Instants at which something is not smooth."""
        breaks = [edge for force in self.scene.forces for edge in force.edges]
        for friction in (self.line.clutch, self.line.brake):
            for at in () if friction is None else (friction.closes, friction.opens):
                if friction is not None and at is not None and at.time is not None:
                    breaks += [at.time, at.time + friction.rise]
        return tuple(breaks)


def _jumps(drive: Drive) -> bool:
    """Whether the torque jumps at a corner, other than at rest: that is not for a solution of a whole period at once."""
    for corner in drive.corners:
        at = np.asarray(corner, dtype=float)
        far, below, above, beyond = (np.asarray(drive.torque(at + by * np.abs(at))) for by in (-0.01, -BESIDE, BESIDE, 0.01))
        size = np.maximum(np.maximum(np.abs(far), np.abs(beyond)), np.maximum(np.abs(below), np.abs(above)))
        if np.any((at != 0) & (np.abs(above - below) > JUMP * size)):
            return True
    return False


def plan(
    press: Linkage,
    drive: Drive | PrescribedSpeed | None,
    flywheel: Flywheel | None,
    loads: Sequence[Load],
    clutch: Clutch | None = None,
    brake: Brake | None = None,
) -> Plan:
    """What is to be simulated, of a press with one driver. Raises as `scene.build`."""
    found = scene.build(press, drive, flywheel, loads)
    turning_drive = None if isinstance(drive, PrescribedSpeed) else drive
    return Plan(found, Driveline(turning_drive, flywheel, clutch, brake, found.inertia), np.array([found.inertia]))


def plan_of_several(press: Linkage, drives: Mapping[str, Drive], flywheels: Mapping[str, Flywheel], loads: Sequence[Load]) -> Plan:
    """What is to be simulated, of a linkage with several drivers; drives and flywheels by their names."""
    found = scene.build(press, None, None, loads)
    inertia = np.zeros(len(press.drivers))
    coordinates, acting = list(found.coordinates), list(found.forces)
    for k, (name, joint) in enumerate(zip(press.drivers, press.driver_indices, strict=True)):
        if name in flywheels:
            inertia[k] += flywheels[name].inertia
        if name in drives:
            check_drive(drives[name])
            inertia[k] += drives[name].inertia
            acting.append(scene.driving(len(coordinates), drives[name]))
            coordinates.append(JointAngle(joint))
    found = Scene(press, None, 0.0, tuple(coordinates), tuple(acting))
    return Plan(found, Driveline(None, None, None, None, float(inertia[0])), inertia)


def _least_inertia(plan: Plan) -> tuple[float, float]:
    """The least inertia at the crank [kg m2], and the crank angle [rad]."""
    inertia, angle = plan.table.lightest
    return inertia + plan.line.inertia, angle


def by_crank(
    plan: Plan, state: State, until: float, tolerance: float, step: float | None, progress: Progress | None, implicit: bool = False
) -> Path:
    """The reduced equation from a state to a time: over the crank angle where that serves, else over time; ``implicit``: by Radau IIA."""
    least, where = _least_inertia(plan)
    if plan.line.clutch is None and plan.line.inertia < 0 and not least > 0:
        raise scene.not_positive(least, None, where)
    prescribed = isinstance(plan.scene.drive, PrescribedSpeed)
    over_time_alone = plan.timed or step is not None or (implicit and not prescribed)
    over_angle_too = not over_time_alone and least > 0  # without mass it may stay between dead centres
    segments: list[Segment] = []
    if over_angle_too:
        found, stop = turning.run(plan.scene, plan.table, plan.edges, state, until, 0.1 * tolerance, progress)
        segments += found
        if stop is None:
            return Path(segments)
        state = stop.at
        if stop.held and not plan.scene.forces:  # in equilibrium, if an unstable one
            return Path([*segments, Resting(state, until)])
    # Only where the crank does not simply turn: SciPy's integrators take long to import.
    from . import time_solver as over_time
    from .hybrid_system import Machine
    from .reduced_dynamics import CrankAlone

    machine = Machine(CrankAlone(plan.table), plan.line, plan.scene.forces)
    mode, states = plan.line.begin(state.angle, state.speed)
    before: Sequence[Any] = (state, *(segment.last() for segment in segments if isinstance(segment, turned.Turned)))
    fastest = max(_energy(plan, s.angle, s.speed) for s in before)
    threshold = max(AGAIN * resolution.LEAST * fastest, LITTLE * float(np.ptp(plan.table.coefficients[:, POTENTIAL, 0])))
    swings, solver = True, over_time.IMPLICIT if implicit else over_time.BY_STIFFNESS
    while True:
        y = machine.begin(np.array([state.angle]), np.array([state.speed]), states, state.ledgers)
        followed = _Followed(plan, threshold, state.speed, swings) if over_angle_too else None
        modes = machine.initial(state.time, y, mode)
        try:
            stepped, y = over_time.run(
                machine,
                modes,
                state.time,
                y,
                until,
                tolerance,
                _scale(plan, y),
                step,
                plan.breaks,
                solver,
                followed,
                progress,
            )
        except SimulationError as error:
            if least > 0 or isinstance(error, LawError):
                raise
            raise scene.not_positive(least, error.time, where if error.crank_angle is None else error.crank_angle) from error
        segments.append(stepped)
        if stepped.end >= until:
            return Path(segments)
        state = State(stepped.end, float(y[0]), float(y[1]), y[-len(LEDGERS) :])
        if followed is not None and followed.swung:
            swinging = None if stepped.heeds_speed() else _swinging(plan, machine, stepped, mode, tolerance, until)
            if swinging is not None:
                return Path([*segments, *swinging])
            swings = False
            continue
        found, stop = turning.run(plan.scene, plan.table, plan.edges, state, until, 0.1 * tolerance, progress)
        segments += found
        if stop is None:
            return Path(segments)
        if not found:  # too early
            threshold *= AGAIN
        state = stop.at


def _swinging(plan: Plan, machine: "Machine", stepped: "Stepped", mode: Mode, tolerance: float, until: float) -> "list[Segment] | None":
    """A crank that swings to and fro under forces that do not depend on its speed: a whole swing, to a tolerance in its own measure, and
    its repetition. None where it does not come back."""
    from . import time_solver as over_time

    begin, turn, again = stepped.stops()[-3:]
    reading = stepped.read(np.array([begin, turn]), whole=False)
    at, beyond = reading.position[0]
    if at == beyond:  # it stands, but for rounding
        return None
    y = machine.begin(reading.position[:, 0], np.zeros(1), (), reading.ledgers[:, 0])
    scale = _scale(plan, y)
    scale[:2] = abs(beyond - at), abs(beyond - at) * 2 * np.pi / (again - begin)
    followed = _Followed(plan, np.inf, 0.0, swings=True)
    swing, _ = over_time.run(
        machine,
        machine.initial(begin, y, mode),
        begin,
        y,
        begin + 2 * (again - begin),
        tolerance,
        scale,
        None,
        (),
        over_time.IMPLICIT,
        followed,
    )
    stops = swing.stops()
    return [swing, turned.Repeated(Path([swing]), begin, stops[2], until)] if len(stops) > 2 else None


class _Followed:
    """Whether a crank has been followed over time for long enough: it turns, or has swung to and fro once."""

    def __init__(self, plan: Plan, threshold: float, speed: float, swings: bool) -> None:
        """``threshold``: kinetic energy from which it turns [J]; ``speed`` at the start [rad/s]; ``swings``: whether a swing counts."""
        self.plan, self.threshold, self.speed = plan, threshold, speed
        self.left = (2 if speed == 0 else 3) if swings else -1  # stops before a whole swing is over
        self.swung = False

    def __call__(self, y: Array) -> bool:
        if y[1] * self.speed < 0:
            self.left -= 1
        self.speed, self.swung = float(y[1]) or self.speed, self.left == 0
        return self.swung or _energy(self.plan, y[0], y[1]) > self.threshold


def by_joints(
    plan: Plan, angle: Array, speed: Array, until: float, tolerance: float, step: float | None, progress: Progress | None
) -> Path:
    """All joints at once, from angles and speeds (drivers,) at time 0 to a time."""
    from . import time_solver as over_time
    from .full_dynamics import AllJoints
    from .hybrid_system import Machine

    press = plan.scene.press
    if plan.line.inertia < 0:
        least, where = _least_inertia(plan)
        if not least > 0:
            raise scene.not_positive(least, None, where)
    joints = AllJoints(press, plan.scene.coordinates, plan.inertia)
    machine = Machine(joints, plan.line, plan.scene.forces)
    several = len(press.drivers) > 1
    first = cycle(press, angle=angle[None], speed=speed[None]) if several else carried(press, angle, speed)
    mode, states = plan.line.begin(float(angle[0]), float(speed[0]))
    y = machine.begin(first.joint_position[0], first.v[0], states, np.zeros(len(LEDGERS)))
    # sizes: of angles 1, of the speed that gravity gives them; travels count in lengths of the linkage
    rate = max(float(np.abs(speed).max()), math.sqrt(float(np.linalg.norm(press.model.gravity.linear)) / press.size)) or 1.0
    lengths = np.array([1.0 if axis.turns else press.size for axis in press.axes])
    energy = joints.energy(np.concatenate([first.joint_position[0], rate * np.ones(joints.size)]))
    scale = np.concatenate([lengths, lengths * rate, _of_states(plan, len(states), rate), [energy, energy, np.inf, energy]])
    stepped, _ = over_time.run(
        machine,
        machine.initial(0.0, y, mode),
        0.0,
        y,
        until,
        tolerance,
        scale,
        step,
        plan.breaks,
        over_time.BY_STIFFNESS,
        progress=progress,
    )
    return Path([stepped])


def _energy(plan: Plan, angle: float, speed: float) -> float:
    """Kinetic energy of a crank angle and speed [J]."""
    inertia = float(plan.table.at(np.array([angle]))[0][INERTIA, 0]) + plan.line.inertia
    return 0.5 * inertia * speed**2


def _scale(plan: Plan, y: Array) -> Array:
    """Sizes of the entries of the crank's vector."""
    inertia, potential = plan.table.coefficients[:, INERTIA, 0] + plan.line.inertia, plan.table.coefficients[:, POTENTIAL, 0]
    least = max(float(inertia.min()), float(np.finfo(float).tiny))
    speed = max(abs(float(y[1])), math.sqrt(2 * float(np.ptp(potential)) / least)) or 1.0
    energy = 0.5 * float(np.abs(inertia).max()) * speed**2
    return np.array([1.0, speed, *_of_states(plan, len(y) - 2 - len(LEDGERS), speed), energy, energy, np.inf, energy])


def _of_states(plan: Plan, count: int, speed: float) -> list[float]:
    """Sizes of a drive's states, and behind them of the speed of a clutch's driving side."""
    own = [] if plan.line.clutch is None else [speed]
    return [1.0] * (count - len(own)) + own


def one_period(plan: Plan, angle: float, start: Array, tolerance: float) -> tuple[Path, Array]:
    """A period of the table over time, from a crank angle with speed and states of the drive (k,): its path, and these at its end.

    Raises:
        SimulationError: the crank does not get that far.
    """
    from . import time_solver as over_time
    from .hybrid_system import Machine
    from .reduced_dynamics import CrankAlone

    assert plan.table.period is not None
    machine = Machine(CrankAlone(plan.table), plan.line, plan.scene.forces)
    direction = 1.0 if start[0] > 0 else -1.0
    target, patience = angle + direction * plan.table.period, PATIENCE * plan.table.period / abs(float(start[0]))
    y = machine.begin(np.array([angle]), start[:1], tuple(start[1:].tolist()), np.zeros(len(LEDGERS)))
    mode, _ = plan.line.begin(angle, float(start[0]))

    def beyond(y: Array) -> bool:
        return bool((y[0] - target) * direction >= 0)

    stepped, y = over_time.run(
        machine,
        machine.initial(0.0, y, mode),
        0.0,
        y,
        patience,
        tolerance,
        _scale(plan, y),
        None,
        plan.breaks,
        over_time.BY_STIFFNESS,
        beyond,
    )
    if not beyond(y):
        raise scene.too_slow(float(patience), float(y[0]))
    # the end by steps that meet it: the integrator's interpolation is less exact than its steps
    begin, modes, at, end = stepped.before(lambda y: float((y[0] - target) * direction))
    segments, y = [stepped], at
    for _ in range(CLOSER):
        if end <= begin:  # an event has ended the step before, just there
            break
        last, y = over_time.run(machine, modes, begin, at, end, tolerance, _scale(plan, at), None, plan.breaks, over_time.BY_STIFFNESS)
        segments = [stepped, last]
        end += float((target - y[0]) / y[1])
    return Path(segments), y[1 : -len(LEDGERS)]
