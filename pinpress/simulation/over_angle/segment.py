"""Panels of a solution over the crank angle, as functions of time."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...common.numerics import gauss_rule, polynomial_values, values_and_slopes
from ...common.quantities import Array
from ..driven_press import DrivenPress
from ..reduced_model import COORDINATES, INERTIA, WEIGHT
from ..trajectory import INTEGRALS, Sample, State
from .collocation import CollocationSolution
from .forces import Forces
from .mesh import AngleMesh, Indices

# A crank is nearly at rest where its kinetic energy, and what the potential energy may still rise, are below this share of the latter's
# range.
NEAR = 1e-5


@dataclass(frozen=True, eq=False, repr=False)
class AngleSegment:
    """Panels of a `CollocationSolution` of one scenario, as functions of time.

    Attributes:
        driven: what is simulated.
        mesh: of the solution.
        count: number of panels that are right.
        begin: the state at the start.
        times: (count + 1,) at the borders [s].
        elapsed: (q + 1, count) coefficients in x of the time since a panel's start.
        summed: (k, q + 1, count) coefficients in x of the first `INTEGRALS` since a panel's start: three, with friction all four.
        integrals: (k, count + 1) the same since the segment's start, at the borders.
        final_speed: of the crank at the end, from its kinetic energy: the polynomial of the time is less exact [rad/s].
        fastest: largest size of the crank's speed at the nodes [rad/s].
        evaluations: see `CollocationSolution`.
        slow: crank angles at which the crank is `nearly_at_rest` [rad].
    """

    driven: DrivenPress
    mesh: AngleMesh
    count: int
    begin: State
    times: Array
    elapsed: Array
    summed: Array
    integrals: Array
    final_speed: float
    fastest: float
    evaluations: int
    slow: Array
    solvers = ("angle",)
    standing = None

    @property
    def start(self) -> float:
        return self.begin.time

    @property
    def end(self) -> float:
        return float(self.times[-1])

    @property
    def borders(self) -> Array:
        return self.times

    jumps = borders

    @property
    def steps(self) -> int:
        return self.count

    @property
    def travelled(self) -> float:
        return float(self.mesh.borders[self.count])

    def at(self, times: Array, complete: bool = True) -> Sample:
        mesh = self.mesh
        panel = np.clip(self.times.searchsorted(times, side="right") - 1, 0, self.count - 1)
        elapsed = self.elapsed[:, panel]
        x = place_at(elapsed, times - self.times[panel], self.times[panel + 1] - self.times[panel])
        _, slope = values_and_slopes(elapsed, x)
        travelled, measure = mesh.travelled(panel, x)
        integrals = np.zeros((len(INTEGRALS), len(times)))
        integrals[: len(self.summed)] = self.integrals[:, panel] + polynomial_values(self.summed[:, :, panel], x)
        integrals += self.begin.integrals[:, None]
        angle, speed = mesh.start + mesh.direction * travelled, mesh.direction * measure / slope
        torque, acceleration = self._dynamics(panel, angle, speed)
        drive = self.driven.drive
        motor = torque if drive is None else np.asarray(drive.motor_torque(speed) + np.zeros_like(speed))
        return Sample(angle[None], speed[None], acceleration[None], torque, motor, speed, np.zeros((0, len(times))), integrals)

    def _dynamics(self, panel: Indices, angle: Array, speed: Array) -> tuple[Array, Array]:
        """Torque of the drive and acceleration of the crank (n,) at states on panels (n,)."""
        values, slopes = self.driven.model.at(angle)
        torque = np.zeros_like(speed)
        if self.driven.drive is not None:
            torque = torque + self.driven.drive.torque(speed)
        total = torque - values[WEIGHT] - 0.5 * slopes[INERTIA] * speed**2
        along: dict[int, Array] = {}
        for force in self.mesh.forces:
            places = np.flatnonzero(np.isin(panel, force.panels))
            if len(places):
                lever = slopes[COORDINATES + force.row, places]
                size = force.interval.force(values[COORDINATES + force.row, places] - force.datum, lever * speed[places])
                size = force.interval.acting(size)
                total[places] += lever * size
                along.setdefault(force.row, np.zeros_like(speed))[places] += size
        inertia = values[INERTIA] + self.driven.inertia
        if self.driven.bearing_model is not None:
            way = self.mesh.direction
            columns = {row: force[:, None] for row, force in along.items()}
            resisting = inertia if self.driven.prescribed is None else np.full_like(inertia, np.inf)
            bearings = self.driven.bearing_model.states(angle)
            total += way * bearings.torque(way, way * speed[:, None], way * total[:, None], resisting[:, None], columns)[0][:, 0]
        if self.driven.prescribed is not None:
            return -total, np.zeros_like(total)
        return torque, total / inertia

    def last(self) -> State:
        """The state at the end."""
        angle = self.mesh.start + self.mesh.direction * float(self.mesh.borders[self.count])
        integrals = self.begin.integrals.copy()
        integrals[: len(self.summed)] += self.integrals[:, -1]
        return State(self.end, angle, self.final_speed, integrals)


def angle_segment(driven: DrivenPress, solution: CollocationSolution, count: int, begin: State) -> AngleSegment:
    """The first ``count`` panels of a solution of one scenario, as functions of time."""
    rule, mesh = gauss_rule(), solution.mesh
    measure, speed = mesh.measure[:, :count], solution.speed[:, :count, 0]
    elapsed = rule.integral(solution.slowness[:, :count, 0])
    driving, resisting = (torque[:, :count, 0] for torque in torques_at_speeds(driven, solution))
    motor = driving if driven.drive is None else np.asarray(driven.drive.motor_torque(mesh.direction * speed))
    rates = [driving, -resisting, motor * motor / speed]
    rates += [] if solution.friction_torque is None else [-solution.friction_torque[:, :count, 0]]
    summed = np.array([rule.integral(rate * measure) for rate in rates])
    final_inertia = float(mesh.inertia_ends[count]) + driven.inertia
    nearly = nearly_at_rest(solution.energy[:, :count, 0], solution.force[:, :count, 0], driven.model.potential_range)
    return AngleSegment(
        driven=driven,
        mesh=mesh,
        count=count,
        begin=begin,
        times=np.concatenate([[begin.time], begin.time + elapsed.sum(axis=0).cumsum()]),  # x = 1: the sum of the coefficients
        elapsed=elapsed,
        summed=summed,
        integrals=np.concatenate([np.zeros((len(summed), 1)), summed.sum(axis=1).cumsum(axis=1)], axis=1),
        final_speed=mesh.direction * math.sqrt(2 * max(0.0, float(solution.ends[count, 0])) / final_inertia),
        fastest=float(speed.max()),
        evaluations=solution.evaluations,
        slow=mesh.angle[:, :count][nearly],
    )


def torques_at_speeds(driven: DrivenPress, solution: CollocationSolution) -> tuple[Array, Array]:
    """Torques (q, p, S) of drive and loads along the travel at the speeds of a solution. They are computed again from these speeds, so that
    the energy balance tells whether these are right."""
    forces = Forces(driven.drive, solution.mesh, solution.energy, solution.speed.shape)
    driving = solution.driving if driven.prescribed is not None else forces.driving_at(solution.speed)
    return driving, forces.resisting_at(solution.speed)


def nearly_at_rest(energy: Array, force: Array, span: float) -> NDArray[np.bool_]:
    """Whether cranks are nearly at rest.

    Args:
        energy: kinetic energies (...) [J].
        force: net torques (...) on the cranks [N m].
        span: range of the potential energy [J].
    """
    nearly = np.asarray(energy < NEAR * span)
    return nearly & (energy + force**2 / (2 * span) < NEAR * span) if nearly.any() else nearly


def place_at(elapsed: Array, since: Array, took: Array) -> Array:
    """Places x (n,), from -1 to 1 on n panels, at given times.

    Args:
        elapsed: (k, n) coefficients in x of the time since a panel's start.
        since: (n,) times since the panels' starts [s].
        took: (n,) durations of the panels [s].
    """
    x = 2 * np.clip(since / took, 0.0, 1.0) - 1
    for _ in range(8):
        value, slope = values_and_slopes(elapsed, x)
        step = (value - since) / slope
        x = np.clip(x - step, -1.0, 1.0)
        # Newton's method squares the error: after a step of 1e-8 the next one would be rounding.
        if np.abs(step).max(initial=0.0) < 1e-8:
            break
    return np.where(since > 0, x, -1.0)  # a press that starts from rest stands still there, without rounding
