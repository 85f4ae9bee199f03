"""A simulated motion: its states, and how good they are."""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..common.arrays import Array
from ..common.checks import whole_number
from ..common.errors import PinpressError
from ..drives.protocol import Drive
from ..kinematics.motion import Motion, motion_through_change_points, of_states
from . import law_trials as laws
from . import reduced_model as reduced
from .driven_press import DrivenPress, JointPosition
from .failures import failure
from .solvers import SimulationProblem
from .trajectory import DRIVE_WORK, INTEGRALS, LOAD_WORK, LOST, Sample, Trajectory

POINTS = 120  # states returned per turn of the crank, and at least
MOST_POINTS = 1_000_000  # by default
LOOSE = 1e3  # energy error, in tolerances, that is none
BALANCED = 1e-6  # energy error of a run, steps by error, that is none; more where a large tolerance is asked for
ROUNDED = 1e-6  # of the potential energy
ROUNDINGS, EPS = 8.0, float(np.finfo(float).eps)  # of a stiff drive's angle and speed, that the energy may tell


@dataclass(frozen=True)
class Stats:
    """What a run took, and how good it is.

    Attributes:
        method: the equations solved, "reduced" or "constraint". solvers: what solved them, in the order in which they came: over the crank
            "angle"; over time "explicit" (DOP853), "implicit" (Radau IIA) or by a "fixed step"; "repetition" of a swing; "standstill".
        steps: of integration: panels over the crank angle, steps over time.
        evaluations: of the equation of motion. wall_time: of the whole call [s].
        closure_error: largest gap of a loop in the states returned [m].
        sensitivity: by how much more the crank angle goes astray than the start is moved, by an angle, or by a speed times the time, where
            the run passes close to an unstable rest; None where it does not.
        energy_error: largest difference of kinetic and potential energy, worked out body by body from the states returned, and what drive
            and loads have put in, as a part of the largest of the kinetic energy, the works and 1e-6 of the potential energy.
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
    """A simulated motion: a `Motion` of n states at equal intervals of time, both ends included, and what happened besides.

    Attributes:
        stats: see `Stats`.
        drive_torque: (n,) of the drive, at the driver joint [N m]; positive along its axis. drive_speed: (n,) of the shaft it acts on,
            before the clutch if there is one, at the driver joint [rad/s]. Both (n, drivers) where there are several drivers.
        drive_work: (n,) work of the drive since the start [J]. load_work: (n,) work against the loads. lost: (n,) energy lost in clutch and
            brake.
        motor_squared: (n,) motor torque squared, summed up over time [N2 m2 s].
        problem, trajectory: what was simulated, and the whole of its solution, which can be asked for at any time.
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

    @property
    def title(self) -> str:
        return f"Run of {self.linkage}: {len(self.crank_angle)} states, {self.time[-1]:.6g} s, method {self.stats.method!r}"

    def columns(self) -> dict[str, Array]:
        """The motion's columns, then torque and speed of the drive, its work, that of the loads, and what clutch and brake have lost."""
        columns = super().columns()
        columns |= {"drive_torque [N m]": self.drive_torque, "drive_speed [rad/s]": self.drive_speed}
        columns |= {"drive_work [J]": self.drive_work, "load_work [J]": self.load_work}
        return columns | ({"lost [J]": self.lost} if self.lost.any() else {})


def as_run(problem: SimulationProblem, trajectory: Trajectory, points: int | None, began: float, sensitivity: float | None = None) -> Run:
    """The states of a trajectory, closed and checked; those of fixed steps may have any energy error."""
    driven = problem.driven
    press, several = driven.press, len(driven.inertias) > 1
    allowed = None if problem.step is not None else allowed_error(problem.tolerance)
    times = np.linspace(0.0, problem.until, count_of(points, trajectory.turns))
    sample = trajectory.at(times)
    position, speed, acceleration = sample.position, sample.speed, sample.acceleration
    if len(position) == 1:
        motion = motion_through_change_points(press, position[0], speed[0], acceleration[0], times)
    else:
        motion = of_states(press, position, speed, acceleration, press.engine().gaps(position), times, press.turns_until_back)
    kinetic, potential = reduced.energies(press, motion)
    turning = speed[list(press.driver_indices)] if several else sample.drive_speed[None]
    kinetic = kinetic + 0.5 * driven.inertias @ turning**2
    works = sample.integrals[[DRIVE_WORK, LOAD_WORK, LOST]]
    error = energy_error(kinetic, potential, *works)
    if not math.isfinite(float(error.max()) + float(acceleration.sum())):
        raise PinpressError(f"the motion of {press.name} is too fast for floating point: lower speeds and forces")
    size = energy_size(kinetic, potential, *works)
    if (
        allowed is not None
        and error.max() > allowed
        and error.max() > allowed + _rounding(driven, times, motion, sample.drive_speed) / size
    ):
        worst = int(error.argmax())
        raise failure("unbalanced", float(times[worst]), float(np.ravel(motion.crank_angle[worst])[0]))
    if several:
        torque = _torques(driven, turning)
        sample = sample._replace(drive_torque=torque.T.copy(), drive_speed=turning.T.copy())
    else:
        laws.confirm(driven.drive, times, motion.crank_angle, sample.drive_speed, sample.drive_torque)
    stats = Stats(
        method=problem.equations,
        solvers=trajectory.solvers,
        steps=trajectory.steps,
        evaluations=trajectory.evaluations,
        wall_time=clock.perf_counter() - began,
        closure_error=float(motion.closure_error.max()),
        energy_error=float(error.max()),
        sensitivity=sensitivity,
    )
    return _with(problem, trajectory, motion, stats, sample)


def energy_error(kinetic: Array, potential: Array, drive_work: Array, load_work: Array, lost: Array) -> Array:
    """What is missing of the energy, beside the largest of energy and works, at n states: arrays (n,), or (n, S) of scenarios [J]; the
    works are those since the first state."""
    missing = np.abs(kinetic + potential - (kinetic[0] + potential[0]) - (drive_work - load_work - lost))
    return np.asarray(missing / energy_size(kinetic, potential, drive_work, load_work, lost))


def energy_size(kinetic: Array, potential: Array, *works: Array) -> Any:
    """The largest of energy and works (n,), or (n, S) of scenarios [J]."""
    size = kinetic.max(axis=0)
    for work in works:
        size = np.maximum(size, np.abs(work).max(axis=0))
    size = np.maximum(size, ROUNDED * np.abs(potential).max(axis=0))  # at rest all of it is the rounding of the potential energy
    return np.where(size > 0, size, 1.0)


def _rounding(driven: DrivenPress, times: Array, motion: Motion, own: Array) -> float:
    """Work of a stiff drive that is not known, as rounding of its angle and speed (n,) makes its torque [J]."""
    drive = driven.drive
    if not isinstance(drive, Drive) or drive.state:
        return 0.0
    changed = []
    for at in zip(own.tolist(), motion.crank_angle.tolist(), times.tolist(), strict=True):
        below, above = (drive.torque(at[0] * share, at[1] * share, at[2]) for share in (1 - ROUNDINGS * EPS, 1 + ROUNDINGS * EPS))
        changed.append(abs(float(np.ravel(above - below)[0]) * at[0]))
    return float(np.trapezoid(changed, times))


def _torques(driven: DrivenPress, speed: Array) -> Array:
    """Torques (drivers, n) of several drives at the drivers' speeds (drivers, n)."""
    press, torque = driven.press, np.zeros_like(speed)
    rows = {joint: k for k, joint in enumerate(press.driver_indices)}
    for force in driven.forces:
        coordinate = driven.coordinates[force.row]
        if force.drive is not None and isinstance(coordinate, JointPosition):
            k = rows[coordinate.joint]
            torque[k] = force.drive.torque(speed[k])
    return torque


def _with(problem: SimulationProblem, trajectory: Trajectory, motion: Motion, stats: Stats, sample: Sample) -> Run:
    kept = {field.name: getattr(motion, field.name) for field in fields(Motion) if field.init}
    integrals = dict(zip(INTEGRALS, sample.integrals, strict=True))
    for array in (sample.drive_torque, sample.drive_speed, *integrals.values()):
        array.setflags(write=False)
    run = Run(
        **kept,
        stats=stats,
        drive_torque=sample.drive_torque,
        drive_speed=sample.drive_speed,
        **integrals,
        problem=problem,
        trajectory=trajectory,
    )
    object.__setattr__(run, "_closed_as", motion._closed_as)
    return run


def allowed_error(tolerance: float) -> float:
    """Energy error of a run with steps by error that is none."""
    return max(BALANCED, LOOSE * tolerance)


def count_of(points: int | None, turns: float) -> int:
    """States to return, from those asked for or from the turns."""
    if points is None:
        return int(min(MOST_POINTS, max(POINTS, math.ceil(POINTS * turns)))) + 1
    return whole_number("points", points, 2, 10**7)
