"""A simulated motion: its states, and how accurate they are."""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ..common import tables
from ..common.arguments import whole_number
from ..common.errors import PinpressError
from ..common.quantities import Array
from ..common.results import Record
from ..drives.protocol import Drive
from ..dynamics import inputs
from ..dynamics.reactions import Reactions
from ..kinematics.cycle import motion_through_change_points
from ..kinematics.motion import Motion, of_states
from ..linkage.linkage import Linkage
from ..loads.caller_laws import as_given
from . import reduced_model as reduced
from .driven_press import DrivenPress, JointPosition
from .failures import failure
from .law_trials import confirm_torques
from .trajectory import DRIVE_WORK, INTEGRALS, LOAD_WORK, LOST, Sample, Trajectory

if TYPE_CHECKING:  # reports know runs, and need no solvers
    from .over_time.equations_of_motion import ConstraintSolution, FullDynamics
    from .over_time.time_solver import TimeSegment
    from .solvers import SimulationProblem

BETWEEN = 1.1  # by which the crank may be faster between the ends of long steps than there


@dataclass(frozen=True, repr=False)
class Stats(Record, units={"wall_time": "s", "closure_error": "m"}):
    """The cost of a run, and its accuracy.

    Attributes:
        method: "reduced", "implicit", "constraint" or "elastic", see `simulate`.
        solvers: what solved them, in the order of use: over the crank "angle"; over time "explicit" (DOP853), "implicit" (Radau IIA) or by
            a "fixed step"; "repetition" of a swing; "standstill".
        steps: number of panels over the crank angle and steps over time.
        evaluations: of the equation of motion.
        wall_time: duration of the whole call [s].
        closure_error: largest gap of a loop in the states returned [m].
        energy_error: largest difference between the energy of the states returned, computed body by body, and the works of drive and loads,
            as a share of the largest of the kinetic energy, the works and 1e-6 of the potential energy.
        sensitivity: factor by which the crank angle moves more than the start, moved by an angle, or by a speed times the duration, where
            the run passes close to an unstable rest; None if it does not.
    """

    method: str
    solvers: tuple[str, ...]
    steps: int
    evaluations: int
    wall_time: float
    closure_error: float
    energy_error: float
    sensitivity: float | None = None


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Run(Motion):
    """A simulated motion: a `Motion` of n states at equal intervals of time, both ends included, with torques and works.

    Attributes:
        stats: cost and accuracy.
        drive_torque: (n,) of the drive, at the driver joint [N m], positive along its axis; (n, drivers) where there are several drivers.
        drive_speed: (n,) of the shaft on which the drive acts, before the clutch if there is one, at the driver joint [rad/s]; (n, drivers)
            where there are several drivers.
        drive_work: (n,) work of the drive since the start [J].
        load_work: (n,) work against the loads since the start [J].
        lost: (n,) energy lost in clutch and brake, and in the friction of bearings and guides, since the start [J].
        motor_squared: (n,) integral of the motor torque squared over time since the start [N2 m2 s].
        problem: what was simulated.
        trajectory: the whole solution; ``trajectory.at(times)`` gives the states at any times (m,).
        constraint_solution: which algorithm found the accelerations, why, and its settings; None if the crank alone was integrated.
    """

    stats: Stats
    drive_torque: Array
    drive_speed: Array
    drive_work: Array
    load_work: Array
    lost: Array
    motor_squared: Array
    problem: SimulationProblem
    trajectory: Trajectory
    constraint_solution: ConstraintSolution | None = None

    def at_times(self, times: Array) -> Run:
        """The same run in the states at other times (n,), rising, from 0 to its end [s]."""
        driven, sample = self.problem.driven, self.trajectory.at(times)
        motion = _close_loops(driven.press, times, sample)
        return _run_of(self.problem, self.trajectory, motion, self.stats, _with_torques(driven, motion, sample, self.trajectory))

    @property
    def jumps(self) -> Array | None:
        """Instants within the run at which a load or the drive may not be smooth [s]; None if only its states are known."""
        jumps = self.trajectory.jumps
        return np.asarray(jumps[(jumps > 0.0) & (jumps < self.time[-1])])

    @property
    def smooth_between(self) -> Array:
        """Rising times, start and end among them, between which the run is smooth [s]."""
        borders = self.trajectory.borders
        return np.asarray(np.union1d(borders[(borders > 0.0) & (borders < self.time[-1])], [0.0, self.time[-1]]))

    @property
    def title(self) -> str:
        by = "" if self.constraint_solution is None else f" by {self.constraint_solution.algorithm}"
        return f"Run of {self.linkage}: {len(self.crank_angle)} states, {self.time[-1]:.6g} s, method {self.stats.method!r}{by}"

    def columns(self) -> dict[str, Array]:
        """The motion's columns, followed by torque, speed and work of the drive, work of the loads, and losses."""
        columns = super().columns()
        efforts = [(f"drive_{coordinate.effort}", coordinate.effort_unit) for coordinate in self.driver_coordinates]
        speeds = [("drive_speed", coordinate.heads[1][1]) for coordinate in self.driver_coordinates]
        columns |= tables.by_driver(efforts, self.drive_torque, self.drivers) | tables.by_driver(speeds, self.drive_speed, self.drivers)
        columns |= {"drive_work [J]": self.drive_work, "load_work [J]": self.load_work}
        return columns | ({"lost [J]": self.lost} if self.lost.any() else {})


def as_run(problem: SimulationProblem, trajectory: Trajectory, points: int | None, began: float, sensitivity: float | None = None) -> Run:
    """The run of a trajectory, with closed loops, after its path and its energy balance were checked. With fixed steps any energy error is
    accepted.

    Args:
        problem: what was simulated.
        trajectory: its solution.
        points: number of states; None: by the turns of the crank.
        began: time of the clock at which the call began [s].
        sensitivity: see `Stats`.
    """
    driven = problem.driven
    times = np.linspace(0.0, problem.until, state_count(points, trajectory.turns))
    sample = trajectory.at(times)
    if problem.step is None:
        _refuse_jumps(problem, times, sample, trajectory.fastest)
    motion = _close_loops(driven.press, times, sample)
    _refuse_beyond_travel(driven.press, motion)
    error = _audit(problem, motion, sample, trajectory.steps)
    if len(driven.inertias) == 1:
        confirm_torques(driven.drive, times, motion.crank_angle, sample.drive_speed, sample.drive_torque)
    stats = Stats(
        method=problem.method,
        solvers=trajectory.solvers,
        steps=trajectory.steps,
        evaluations=trajectory.evaluations,
        wall_time=clock.perf_counter() - began,
        closure_error=float(motion.closure_error.max()),
        energy_error=error,
        sensitivity=sensitivity,
    )
    return _run_of(problem, trajectory, motion, stats, _with_torques(driven, motion, sample, trajectory))


def _with_torques(driven: DrivenPress, motion: Motion, sample: Sample, trajectory: Trajectory) -> Sample:
    """A sample with the torques and speeds of all drives, where there are several."""
    if len(driven.inertias) == 1:
        return sample
    speeds = _driver_speeds(driven, sample)
    torques = np.zeros_like(speeds)
    for k, drive in _several_drives(driven):
        torques[k] = drive.torque(speeds[k], motion.crank_angle[:, k], motion.time)
    if driven.held:
        rows = [driven.press.drivers.index(name) for name in driven.held]
        torques[rows] = cast("TimeSegment", trajectory.segments[0]).held_efforts(motion.time)
    if (law := driven.law) is not None:
        motors = len(law.rows)
        states = zip(motion.time.tolist(), motion.crank_angle[:, :motors], motion.crank_speed[:, :motors], strict=True)
        torques[:motors] = np.transpose([law.efforts(*state) for state in states])
    return sample._replace(drive_torque=torques.T.copy(), drive_speed=speeds.T.copy())


def _close_loops(press: Linkage, times: Array, sample: Sample) -> Motion:
    """The motion of a sample at times (n,), with its loops closed."""
    position, speed, acceleration = sample.position, sample.speed, sample.acceleration
    if len(position) == 1:
        return motion_through_change_points(press, position[0], speed[0], acceleration[0], times)
    return of_states(press, position, speed, acceleration, press.engine().gaps(position), times, press.turns_until_back)


def _refuse_jumps(problem: SimulationProblem, times: Array, sample: Sample, fastest: float) -> None:
    """Raise SimulationError where the first driver is farther from its state before than its speed allows; ``fastest``: largest size of
    that where it was solved."""
    joint = problem.driven.press.driver_indices[0] if len(sample.position) > 1 else 0
    travel, span = np.abs(np.diff(sample.position[joint])), np.diff(times)
    fastest = max(fastest, float(np.abs(sample.speed[joint]).max()))
    error = problem.tolerance * max(1.0, float(np.abs(sample.position[joint]).max()))  # of a state's angle: a crank at rest may move by it
    beyond = travel > BETWEEN * fastest * span + error
    if beyond.any():
        k = int(np.argmax(beyond))
        angle = float(sample.position[joint, k])
        raise failure("jumps", float(times[k]), angle, travel=float(travel[k]), span=float(span[k]), fastest=fastest)


def _refuse_beyond_travel(press: Linkage, motion: Motion) -> None:
    """Raise SimulationError where a driver that slides goes beyond the limits of its joint, which the equations of all joints do not
    know."""
    columns = motion.crank_angle.reshape(len(motion.time), -1).T
    for k, (joint, coordinate) in enumerate(zip(press.driver_indices, press.driver_coordinates, strict=True)):
        if coordinate.turns:
            continue
        place, home = press.slots[joint].start, float(press.closed[joint])
        low = min(float(press.model.lowerPositionLimit[place]), home)
        high = max(float(press.model.upperPositionLimit[place]), home)
        # Less than this share of the size of the linkage is rounding.
        beyond = np.maximum(low - columns[k], columns[k] - high) > 1e-9 * press.size
        if beyond.any():
            first = int(np.argmax(beyond))
            ends = {"low": f"{low * coordinate.scale:.6g}", "high": coordinate.shown(high)}
            raise failure("runs against an end", float(motion.time[first]), None if k else float(columns[k, first]), **ends)


def _driver_speeds(driven: DrivenPress, sample: Sample) -> Array:
    """(drivers, n) speeds of the shafts on which the drives act [rad/s]."""
    return sample.speed[list(driven.press.driver_indices)] if len(driven.inertias) > 1 else sample.drive_speed[None]


def _audit(problem: SimulationProblem, motion: Motion, sample: Sample, steps: int) -> float:
    """Check the energy balance of a motion that was found in so many steps, and return its energy error.

    Raises:
        PinpressError: the energy is not finite.
        SimulationError: the energy does not balance.
    """
    driven, press = problem.driven, problem.driven.press
    kinetic, potential = reduced.energies(press, motion)
    kinetic = kinetic + 0.5 * driven.inertias @ _driver_speeds(driven, sample) ** 2
    works = sample.integrals[[DRIVE_WORK, LOAD_WORK, LOST]]
    error = energy_error(kinetic, potential, *works)
    largest = float(error.max())
    if not math.isfinite(largest + float(sample.acceleration.sum())):
        raise PinpressError(f"the motion of {press.name} is too fast for floating point: lower speeds and forces")
    allowed = math.inf if problem.step is not None else allowed_error(problem.tolerance)
    # Loops that contradict each other a little do as much work; `load` has warned of it.
    allowed = max(allowed, 10 * press.assembly.misfit / press.size)
    if largest > allowed:
        unsure = _rounding(driven, motion.time, motion, sample.drive_speed)
        if len(driven.inertias) == 1:  # in each step kinetic energy and works may each err by the tolerance
            unsure += (1 + len(works)) * steps * problem.tolerance * driven.motion_sizes(float(problem.speed[0]))[1]
        if largest > allowed + unsure / float(energy_size(kinetic, potential, *works)):
            worst = int(error.argmax())
            raise failure("unbalanced", float(motion.time[worst]), float(np.ravel(motion.crank_angle[worst])[0]))
    return largest


def energy_error(kinetic: Array, potential: Array, drive_work: Array, load_work: Array, lost: Array) -> Array:
    """Energy that is missing at n states, as a share of `energy_size`. Arrays are (n,), or (n, S) for scenarios [J]; works count from the
    first state."""
    missing = np.abs(kinetic + potential - (kinetic[0] + potential[0]) - (drive_work - load_work - lost))
    return np.asarray(missing / energy_size(kinetic, potential, drive_work, load_work, lost))


def energy_size(kinetic: Array, potential: Array, *works: Array) -> Any:
    """The largest of kinetic energy, works and a share of the potential energy [J]. Arrays are (n,), or (n, S) for scenarios [J]."""
    size = kinetic.max(axis=0)
    for work in works:
        size = np.maximum(size, np.abs(work).max(axis=0))
    size = np.maximum(size, 1e-6 * np.abs(potential).max(axis=0))  # at rest all that is missing is rounding of the potential energy
    return np.where(size > 0, size, 1.0)


def _rounding(driven: DrivenPress, times: Array, motion: Motion, speeds: Array) -> float:
    """Work of a drive that is uncertain, because its torque changes with the rounding of angle and speed [J]; ``speeds``: (n,) of its shaft
    [rad/s]."""
    drive = driven.drive
    if not isinstance(drive, Drive) or drive.state:
        return 0.0
    powers, few_roundings = [], 8 * float(np.finfo(float).eps)
    for speed, angle, time in zip(speeds.tolist(), motion.crank_angle.tolist(), times.tolist(), strict=True):
        below, above = (drive.torque(speed * share, angle * share, time) for share in (1 - few_roundings, 1 + few_roundings))
        powers.append(abs(float(np.ravel(above - below)[0]) * speed))
    return float(np.trapezoid(powers, times))


def _several_drives(driven: DrivenPress) -> list[tuple[int, Drive]]:
    """The drives of a press with several drivers, each behind the number of its driver."""
    rows, drives = {joint: k for k, joint in enumerate(driven.press.driver_indices)}, []
    for force in driven.forces:
        coordinate = driven.coordinates[force.row]
        if force.drive is not None and isinstance(coordinate, JointPosition):
            drives.append((rows[coordinate.joint], force.drive))
    return drives


def _run_of(problem: SimulationProblem, trajectory: Trajectory, motion: Motion, stats: Stats, sample: Sample) -> Run:
    """The run of a motion that is closed and checked."""
    of_motion = {field.name: getattr(motion, field.name) for field in fields(Motion) if field.init}
    integrals = dict(zip(INTEGRALS, sample.integrals, strict=True))
    solution = None
    if problem.method == "constraint":
        segment = cast("TimeSegment", trajectory.segments[0])
        solution = cast("FullDynamics", segment.system.dynamics).solution()
    run = Run(
        **of_motion,
        stats=stats,
        drive_torque=sample.drive_torque,
        drive_speed=sample.drive_speed,
        **integrals,
        problem=problem,
        trajectory=trajectory,
        constraint_solution=solution,
    )
    vars(run)["_closed_for"] = motion._closed_for
    return run


def allowed_error(tolerance: float) -> float:
    """Largest energy error accepted of a run with steps by error."""
    return max(1e-6, 1e3 * tolerance)  # at a loose tolerance the errors of a thousand steps may add up


def state_count(points: int | None, turns: float) -> int:
    """Number of states to return: that asked for, or by the turns of the crank, up to a million."""
    if points is None:
        return int(min(1_000_000, max(120, math.ceil(120 * turns)))) + 1
    return whole_number("points", points, 2, 10**7)


# ----------------------------------------------------------------------------------------------------------------------------------- inputs


def inputs_of(reactions: Reactions) -> inputs.Inputs:
    """What reactions were computed from, as text, see `dynamics.inputs`; of a run with its start, drives and method."""
    run = reactions.motion
    if not isinstance(run, Run):
        return inputs.inputs(reactions)
    driven, stats = run.problem.driven, run.stats
    coordinates, begins = run.driver_coordinates, []
    for name, coordinate, place, rate in zip(
        run.drivers, coordinates, np.ravel(run.crank_angle[0]), np.ravel(run.crank_speed[0]), strict=True
    ):
        where = f"{name} {coordinate.shown(float(place))}" if len(run.drivers) > 1 else coordinate.at(float(place) + 0.0)
        begins.append(f"{where} at {inputs.written(float(rate) + 0.0, f'{coordinate.unit}/s')}")
    start = f"simulated from {', '.join(begins)}, {run.time[-1]:.6g} s, {len(run.time)} states"
    several = _several_drives(driven)
    parts = {"drive": driven.drive or driven.prescribed, "flywheel": driven.flywheel, "clutch": driven.clutch, "brake": driven.brake}
    described = [inputs.row(name, as_given(part), coordinates[0]) for name, part in parts.items() if part is not None]
    described += [(f"drive at {run.drivers[k]}", inputs.described(as_given(drive), coordinates[k])) for k, drive in several]
    described += [(f"drive at {name}", inputs.described(part, coordinates[run.drivers.index(name)])) for name, part in driven.held.items()]
    if len(driven.inertias) > 1 and driven.inertias.any():
        units = (coordinate.in_place_of("kg m2") for coordinate in coordinates)
        inertias = (f"{inertia:.9g} {unit} at {name}" for inertia, unit, name in zip(driven.inertias, units, run.drivers, strict=True))
        described.append(("flywheels and drives", f"inertia {', '.join(inertias)}"))
    if driven.law is not None:
        described.insert(0, ("drive", f"function {getattr(driven.law.law.call, '__name__', 'of the caller')} of the state of all motors"))
    elif not (several or driven.held) and parts["drive"] is None:
        described.insert(0, ("drive", "none"))
    by = stats.solvers if run.constraint_solution is None else (*stats.solvers, run.constraint_solution.algorithm)
    how = f", method {stats.method!r} by {', '.join(by)}, " + (
        f"tolerance {run.problem.tolerance:g}" if run.problem.step is None else f"step {run.problem.step:g} s"
    )
    return inputs.inputs(reactions, start, described, how)
