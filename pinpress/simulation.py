"""Forward dynamics: a press under motor, flywheel and process load.

    run = pp.simulate(press, duration=2.0, speed=70 * pp.RPM, flywheel=pp.Flywheel(inertia=2000.0))

Two methods give the same run. ``"reduced"`` integrates the one-degree-of-freedom equation (see `reduced`): over the crank angle, all of a
period at once, while the crank turns, and over time where it may stop, or where a clutch, a drive's own states or forces in time demand it.
``"constraint"`` integrates all joints by Pinocchio's constraint dynamics, with the loops closed again after every step: any linkage.
"""

import math
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import reduced, scene, turning
from .coordinates import Array
from .driveline import Brake, Clutch, Driveline
from .drives import Drive, Flywheel, PrescribedSpeed
from .errors import PinpressError, SimulationError
from .forces import Load
from .linkage import Linkage
from .motion import Motion, cycle
from .path import DRIVE_WORK, LEDGERS, LOAD_WORK, LOST, Path, Reading, Segment
from .reduced import COORDINATES, POTENTIAL, Table
from .scene import Scene, SlidePosition

POINTS = 180  # states returned per turn of the crank, and at least
MOST_POINTS = 100_000  # by default
AGAIN = 4.0  # times the kinetic energy at which the crank stopped turning for sure, from which it is followed over its angle again


@dataclass(frozen=True)
class Stats:
    """What a run took, and how good it is.

    Attributes:
        method: "reduced" or "constraint". steps: of integration: panels over the crank angle, steps over time.
        evaluations: of the equation of motion. wall_time: of the whole call [s].
        closure_error: largest gap of a loop in the states returned [m].
        energy_error: largest difference of kinetic and potential energy, worked out body by body from the states returned, and what drive and
            loads have put in, beside the largest kinetic energy.
    """

    method: str
    steps: int
    evaluations: int
    wall_time: float
    closure_error: float
    energy_error: float


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Run(Motion):
    """A simulated motion: a `Motion` of n states at equal intervals of time, both ends included, and what happened besides.

    Attributes:
        stats: see `Stats`.
        drive_torque: (n,) of the drive, at the driver joint [N m]; positive along its axis. drive_speed: (n,) of the shaft it acts on, before
            the clutch if there is one, at the driver joint [rad/s].
        drive_work: (n,) work of the drive since the start [J]. load_work: (n,) work against the loads. lost: (n,) energy lost in clutch and
            brake.
        motor_squared: (n,) motor torque squared, summed up over time [N2 m2 s].
    """

    stats: Stats
    drive_torque: Array
    drive_speed: Array
    drive_work: Array
    load_work: Array
    lost: Array
    motor_squared: Array

    def __repr__(self) -> str:
        return f"<Run of {self.linkage}: {len(self.crank_angle)} states, {self.time[-1]:.6g} s, {self.stats.method}>"

    def columns(self) -> dict[str, Array]:
        """The motion's columns, then torque and speed of the drive, its work, that of the loads, and what clutch and brake have lost."""
        columns = super().columns()
        columns |= {"drive_torque [N m]": self.drive_torque, "drive_speed [rad/s]": self.drive_speed}
        columns |= {"drive_work [J]": self.drive_work, "load_work [J]": self.load_work}
        return columns | ({"lost [J]": self.lost} if self.lost.any() else {})


def simulate(
    press: Linkage,
    duration: float,
    speed: ArrayLike = 0.0,
    angle: ArrayLike = 0.0,
    drive: Drive | PrescribedSpeed | None = None,
    flywheel: Flywheel | None = None,
    loads: Sequence[Load] = (),
    method: str = "reduced",
    clutch: Clutch | None = None,
    brake: Brake | None = None,
    points: int | None = None,
    step: float | None = None,
    tolerance: float = 1e-10,
    progress: Callable[[float], None] | None = None,
) -> Run:
    """Let a press run.

    Args:
        duration: [s]. speed, angle: of the crank at the start [rad/s, rad].
        drive: what turns the crank, see `pinpress.drives`; None: nothing. flywheel: its inertia at the driver joint.
        loads: process loads of `pinpress.loads`, constant forces on links, springs and dampers.
        method: "reduced" or "constraint", see the module.
        clutch: between flywheel and crank; brake: on the crank.
        points: number of states returned; by default 180 a turn.
        step: fixed step of the classical Runge-Kutta method over time [s]; None: steps by error.
        tolerance: of the error of a step, beside 1 rad, and the crank's speed.
        progress: called with the time reached [s], now and then.

    Raises:
        PinpressError: an argument that makes no sense.
        SimulationError: the press stalls, runs against a lock, or has no inertia: the error says when and where.
    """
    began = clock.perf_counter()
    if method not in ("reduced", "constraint"):
        raise PinpressError(f"unknown method {method!r}: write 'reduced' or 'constraint'")
    until = _number("duration", duration, positive=True)
    start = turning.State(0.0, _number("angle", angle), _number("speed", speed), np.zeros(len(LEDGERS)))
    tolerance = _number("tolerance", tolerance, positive=True)
    fixed = None if step is None else _number("step", step, positive=True)
    plan = _plan(press, drive, flywheel, loads, clutch, brake)
    if method == "reduced":
        path = _reduced(plan, start, until, tolerance, fixed, progress)
    else:
        path = _constraint(plan, start, until, tolerance, fixed, progress)
    return _run(plan, path, method, until, points, began)


@dataclass(frozen=True, eq=False)
class Plan:
    """A scene with its driveline, and its table over the crank angle with the angles at which a force is not smooth."""

    scene: Scene
    line: Driveline
    table: Table
    edges: tuple[Array, ...]

    @property
    def timed(self) -> bool:
        """Whether anything depends on more than crank angle and speed."""
        line = self.line
        switched = line.clutch is not None or line.brake is not None
        return switched or (line.drive is not None and line.drive.timed) or any(force.time is not None for force in self.scene.forces)


def _plan(
    press: Linkage,
    drive: Drive | None,
    flywheel: Flywheel | None,
    loads: Sequence[Load],
    clutch: Clutch | None,
    brake: Brake | None,
) -> Plan:
    tables: list[tuple[Any, Table]] = []

    def bottom(slide: SlidePosition) -> float:
        tables.append(((slide,), _table(press, (slide,))))
        table = tables[0][1]
        turning_points = table.at(reduced.roots(table, COORDINATES, 0.0, slope=True))[0][COORDINATES]
        if table.period is None or not len(turning_points):
            raise PinpressError(f"{press.name} has no bottom dead centre to measure heights from: give datum=, a slide position [m]")
        return float(turning_points.min())

    found = scene.build(press, drive, flywheel, loads, bottom, None)
    table = next((table for of, table in tables if of == found.coordinates), None) or _table(press, found.coordinates)
    edges = []
    for force in found.forces:
        borders = force.borders()
        edges += [reduced.roots(table, COORDINATES + force.row, border) for border in borders]
        if borders:
            edges.append(reduced.roots(table, COORDINATES + force.row, 0.0, slope=True))
    return Plan(found, Driveline(drive, flywheel, clutch, brake, float(found.inertia)), table, tuple(edges))


def _table(press: Linkage, coordinates: Sequence[scene.Coordinate]) -> Table:
    return reduced.build(press, [lambda motion, c=c: c.over(press, motion) for c in coordinates])  # type: ignore[misc]


def _reduced(
    plan: Plan, state: turning.State, until: float, tolerance: float, step: float | None, progress: Callable[[float], None] | None
) -> Path:
    from .crank_alone import CrankAlone  # these two only where the crank does not simply turn: SciPy's integrators take long to import

    segments: list[Segment] = []
    if not plan.timed and step is None:
        found, stop = turning.run(plan.scene, plan.table, plan.edges, state, until, 0.1 * tolerance)
        segments += found
        if stop is None:
            return Path(segments)
        state = stop.at
    from . import over_time
    from .machine import Machine

    machine = Machine(CrankAlone(plan.table), plan.line, plan.scene.forces)
    mode, states = plan.line.begin(state.angle, state.speed)
    y = machine.begin(np.array([state.angle]), np.array([state.speed]), states, state.ledgers)
    modes = machine.initial(state.time, y, mode)
    breaks = _breaks(plan)
    threshold = AGAIN * turning.LEAST * max(_kinetic(plan, s) for s in (state, *(s.last() for s in segments)))
    while True:
        goes_on = None if plan.timed or step is not None else lambda y: _energy(plan, y) > threshold
        stepped, modes, y = over_time.run(machine, modes, state.time, y, until, tolerance, _scale(plan, y), step, breaks, goes_on, progress)
        segments.append(stepped)
        if stepped.end >= until:
            return Path(segments)
        state = turning.State(stepped.end, float(y[0]), float(y[1]), y[-len(LEDGERS) :])
        found, stop = turning.run(plan.scene, plan.table, plan.edges, state, until, 0.1 * tolerance)
        segments += found
        if stop is None:
            return Path(segments)
        if not found:
            threshold *= AGAIN
        state = stop.at
        y = machine.begin(np.array([state.angle]), np.array([state.speed]), (), state.ledgers)
        modes = machine.initial(state.time, y, mode)


def _breaks(plan: Plan) -> list[float]:
    """Instants at which something is not smooth."""
    breaks = [edge for force in plan.scene.forces for edge in force.edges]
    for friction in (plan.line.clutch, plan.line.brake):
        if friction is not None:
            for at in (friction.closes, friction.opens):
                if at is not None and at.time is not None:
                    breaks += [at.time, at.time + friction.rise]
    return breaks


def _kinetic(plan: Plan, state: turning.State) -> float:
    return _energy(plan, np.array([state.angle, state.speed]))


def _energy(plan: Plan, y: Array) -> float:
    inertia = float(plan.table.at(y[:1])[0][0, 0]) + plan.line.inertia
    return 0.5 * inertia * float(y[1]) ** 2


def _scale(plan: Plan, y: Array) -> Array:
    """Sizes of the entries of the crank's vector."""
    inertia, potential = plan.table.coefficients[:, 0, 0] + plan.line.inertia, plan.table.coefficients[:, POTENTIAL, 0]
    least = max(float(inertia.min()), 1e-300)
    speed = max(abs(float(y[1])), math.sqrt(2 * float(np.ptp(potential)) / least)) or 1.0
    energy = 0.5 * float(inertia.max()) * speed**2
    states = len(y) - 2 - len(LEDGERS)
    return np.array([1.0, speed, *([speed if plan.line.clutch is not None else 1.0] * states), energy, energy, np.inf, energy])


def _constraint(
    plan: Plan, state: turning.State, until: float, tolerance: float, step: float | None, progress: Callable[[float], None] | None
) -> Path:
    from . import over_time
    from .all_joints import AllJoints
    from .machine import Machine

    press = plan.scene.press
    joints = AllJoints(press, plan.scene.coordinates, np.array([plan.line.inertia]))
    machine = Machine(joints, plan.line, plan.scene.forces)
    first = cycle(press, angle=[state.angle], speed=[state.speed])
    mode, states = plan.line.begin(state.angle, state.speed)
    y = machine.begin(first.joint_position[0], first.v[0], states, state.ledgers)
    crank = _scale(plan, np.array([state.angle, state.speed, *states, *state.ledgers]))
    lengths = np.array([1.0 if axis.turns else press.spatial.size for axis in press.spatial.axes])
    scale = np.concatenate([lengths, lengths * crank[1], crank[2:]])
    stepped, _, _ = over_time.run(
        machine, machine.initial(0.0, y, mode), 0.0, y, until, tolerance, scale, step, _breaks(plan), None, progress
    )
    return Path([stepped])


def _run(plan: Plan, path: Path, method: str, until: float, points: int | None, began: float) -> Run:
    press = plan.scene.press
    count = _count(points, path, until)
    times = np.linspace(0.0, until, count)
    reading = path.read(times)
    crank = press.spatial.drivers[0] if len(reading.position) > 1 else 0
    motion = cycle(press, angle=reading.position[crank], speed=reading.speed[crank], acceleration=reading.acceleration[crank], time=times)
    kinetic, potential = reduced.energies(press, motion)
    kinetic = kinetic + 0.5 * plan.line.inertia * reading.own**2
    ledgers = reading.ledgers
    gained = ledgers[DRIVE_WORK] - ledgers[LOAD_WORK] - ledgers[LOST]
    residual = np.abs(kinetic + potential - (kinetic[0] + potential[0]) - gained).max()
    stats = Stats(
        method=method,
        steps=path.steps,
        evaluations=path.evaluations + plan.table.evaluations,
        wall_time=clock.perf_counter() - began,
        closure_error=float(motion.closure_error.max()),
        energy_error=float(residual / (kinetic.max() or 1.0)),
    )
    return _as_run(motion, stats, reading)


def _count(points: int | None, path: Path, until: float) -> int:
    if points is None:
        return int(min(MOST_POINTS, max(POINTS, math.ceil(POINTS * path.turns))))
    if isinstance(points, bool) or not isinstance(points, int | np.integer) or not 2 <= points <= MOST_POINTS * 1000:
        raise PinpressError(f"points is {points!r}: give a whole number of states, at least 2")
    return int(points)


def _as_run(motion: Motion, stats: Stats, reading: Reading) -> Run:
    from dataclasses import fields

    kept = {field.name: getattr(motion, field.name) for field in fields(Motion) if field.init}
    arrays = {
        "drive_torque": reading.torque,
        "drive_speed": reading.own,
        **{name: reading.ledgers[k] for k, name in enumerate(LEDGERS)},
    }
    for array in arrays.values():
        array.setflags(write=False)
    run = Run(**kept, stats=stats, **arrays)
    object.__setattr__(run, "_closed_as", motion._closed_as)
    return run


def _number(name: str, value: ArrayLike, positive: bool = False) -> float:
    try:
        number = float(np.asarray(value, dtype=float))
    except (TypeError, ValueError):
        raise PinpressError(f"{name} is {value!r}: give one number") from None
    if not math.isfinite(number) or (positive and number <= 0):
        raise PinpressError(f"{name} is {value!r}: give a finite number{', positive' if positive else ''}")
    return number
