"""Parts of a run over the crank angle, readable at any time: panels in time, and a standstill."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.arrays import Array
from ..drives.transmission import Drive
from . import mesh as panels
from .collocation import Flow
from .driven_press import DrivenPress
from .mesh import Grid, Indices
from .reduced_model import COORDINATES, INERTIA, POTENTIAL, WEIGHT, Table, rule
from .trajectory import LEDGERS, MOTOR_SQUARED, Path, Reading

NEAR = 1e-5  # of the range of the potential energy: kinetic energy, and that by which the potential may still rise, beside a rest


class State(NamedTuple):
    """Where a run has come to: time [s], crank angle [rad], crank speed [rad/s], the ledgers (4,)."""

    time: float
    angle: float
    speed: float
    ledgers: Array


@dataclass(frozen=True, eq=False, repr=False)
class Turned:
    """Panels of a `Flow` in time, of one scenario.

    Attributes:
        grid: of the flow. count: panels that are right.
        begin: the state at its start. times: (count + 1,) at the borders [s].
        elapsed: (q + 1, count) coefficients of the time since a panel's start. summed: (3, q + 1, count) of the ledgers.
        ledgers: (3, count + 1) at the borders. final_speed: of the crank, from its kinetic energy: the time's polynomial is less exact.
        slow: crank angles at which it is `slow`.
    """

    driven: DrivenPress
    table: Table
    grid: Grid
    count: int
    begin: State
    times: Array
    elapsed: Array
    summed: Array
    ledgers: Array
    final_speed: float
    evaluations: int
    slow: Array

    @property
    def start(self) -> float:
        return self.begin.time

    @property
    def end(self) -> float:
        return float(self.times[-1])

    @property
    def solvers(self) -> tuple[str, ...]:
        return ("angle",)

    @property
    def standing(self) -> None:
        return None

    @property
    def steps(self) -> int:
        return self.count

    @property
    def travelled(self) -> float:
        return float(self.grid.borders[self.count])

    def read(self, times: Array, whole: bool = True) -> Reading:
        g = self.grid
        panel = np.clip(self.times.searchsorted(times, side="right") - 1, 0, self.count - 1)
        elapsed = self.elapsed[:, panel]
        x = place_at(elapsed, times - self.times[panel], self.times[panel + 1] - self.times[panel])
        _, slope = _with_slope(elapsed, x)
        travelled, measure = panels.travelled(g, panel, x)
        ledgers = np.zeros((len(LEDGERS), len(times)))
        ledgers[:3] = self.ledgers[:, panel] + values(self.summed[:, :, panel], x)
        ledgers += self.begin.ledgers[:, None]
        angle, speed = g.start + g.direction * travelled, g.direction * measure / slope
        torque, acceleration = self._dynamics(panel, angle, speed)
        drive = self.driven.drive
        motor = torque if drive is None else drive.motor_torque(speed) + np.zeros_like(speed)
        return Reading(angle[None], speed[None], acceleration[None], torque, motor, speed, ledgers)

    def _dynamics(self, panel: Indices, angle: Array, speed: Array) -> tuple[Array, Array]:
        """Torque of the drive and acceleration of the crank (n,) at states on panels (n,)."""
        values, slopes = self.table.at(angle)
        driven = self.driven
        torque = np.zeros_like(speed)
        if driven.drive is not None:
            torque = torque + driven.drive.torque(speed)
        force = torque - values[WEIGHT] - 0.5 * slopes[INERTIA] * speed**2
        for push in self.grid.pushes:
            mine = np.flatnonzero(np.isin(panel, push.panels))
            if len(mine):
                lever = slopes[COORDINATES + push.row, mine]
                size = push.stretch.force(values[COORDINATES + push.row, mine] - push.datum, lever * speed[mine])
                force[mine] += lever * (np.maximum(size, 0.0) if push.stretch.one_sided else size)
        if driven.prescribed is not None:
            return -force, np.zeros_like(force)
        return torque, force / (values[INERTIA] + driven.inertia)

    def last(self) -> State:
        """The state at the end."""
        angle = self.grid.start + self.grid.direction * float(self.grid.borders[self.count])
        ledgers = self.begin.ledgers.copy()
        ledgers[:3] += self.ledgers[:, -1]
        return State(self.end, angle, self.final_speed, ledgers)


def turned(driven: DrivenPress, table: Table, flow: Flow, count: int, begin: State) -> Turned:
    """The first ``count`` panels of a flow of one scenario in time."""
    r, g = rule(), flow.grid
    measure, speed = g.measure[:, :count], flow.speed[:, :count, 0]
    elapsed = r.integral(measure / speed)
    if driven.drive is not None:
        motor = np.asarray(driven.drive.motor_torque(g.direction * speed))
    else:
        motor = np.zeros_like(speed) if driven.prescribed is None else flow.driving[:, :count, 0]
    driving = flow.driving[:, :count, 0]
    if driven.drive is not None:
        driving = torque_along(driven.drive, flow)[:, :count, 0]
    rates = [driving, -flow.resisting[:, :count, 0], motor * motor / speed]
    summed = np.array([r.integral(rate * measure) for rate in rates])
    nearly = slow(flow.energy[:, :count, 0], flow.force[:, :count, 0], float(np.ptp(table.coefficients[:, POTENTIAL, 0])))
    return Turned(
        driven=driven,
        table=table,
        grid=g,
        count=count,
        begin=begin,
        times=np.concatenate([[begin.time], begin.time + elapsed.sum(axis=0).cumsum()]),  # x = 1: the sum of the coefficients
        elapsed=elapsed,
        summed=summed,
        ledgers=np.concatenate([np.zeros((3, 1)), summed.sum(axis=1).cumsum(axis=1)], axis=1),
        final_speed=g.direction * math.sqrt(2 * max(0.0, float(flow.ends[count, 0])) / (float(g.inertia_ends[count]) + driven.inertia)),
        evaluations=flow.evaluations,
        slow=g.angle[:, :count][nearly],
    )


def slow(energy: Array, force: Array, span: float) -> NDArray[np.bool_]:
    """Whether cranks with these kinetic energies, under these net torques, are nearly at rest; ``span``: range of the potential energy."""
    found = np.asarray(energy < NEAR * span)
    return found & (energy + force**2 / (2 * span) < NEAR * span) if found.any() else found


def torque_along(drive: Drive, flow: Flow) -> Array:
    """Torque of a drive along the travel (q, p, S), once more at the speeds that came out of it: so the energy balance tells whether these
    are right."""
    g = flow.grid
    return np.asarray(g.direction * drive.torque(g.direction * flow.speed) + np.zeros_like(flow.speed))


@dataclass(frozen=True, eq=False, repr=False)
class Resting:
    """A press that stands, from a state on until a time."""

    at: State
    end: float

    @property
    def start(self) -> float:
        return self.at.time

    @property
    def solvers(self) -> tuple[str, ...]:
        return ("standstill",)

    @property
    def standing(self) -> None:
        return None

    @property
    def steps(self) -> int:
        return 0

    @property
    def evaluations(self) -> int:
        return 0

    @property
    def travelled(self) -> float:
        return 0.0

    def read(self, times: Array, whole: bool = True) -> Reading:
        none = np.zeros((1, len(times)))
        return Reading(none + self.at.angle, none, none, none[0], none[0], none[0], self.at.ledgers[:, None] + none)


@dataclass(frozen=True, eq=False, repr=False)
class Repeated:
    """A press that swings to and fro between two stops under forces that do not depend on its speed: what it did once, until a time.

    Attributes:
        swing: segments that have a whole swing in them. first, start: when the crank stopped in one place, and in the same place again [s];
            from the latter on the swing is repeated. end: of the repetition [s].
    """

    swing: Path
    first: float
    start: float
    end: float

    @property
    def solvers(self) -> tuple[str, ...]:
        return ("repetition",)

    @property
    def standing(self) -> None:
        return None

    @property
    def steps(self) -> int:
        return 0

    @property
    def evaluations(self) -> int:
        return 0

    @property
    def travelled(self) -> float:
        swings = (self.end - self.start) / (self.start - self.first)
        return swings * sum(segment.travelled for segment in self.swing.segments)

    def read(self, times: Array, whole: bool = True) -> Reading:
        period = self.start - self.first
        swings = np.floor((times - self.first) / period)
        within = np.clip(times - swings * period, self.first, self.start)
        order = np.argsort(within, kind="stable")
        back = np.argsort(order, kind="stable")
        found = Reading(*(rows[..., back] for rows in self.swing.read(within[order], whole)))
        squared = self.swing.read(np.array([self.first, self.start]), whole=False).ledgers[MOTOR_SQUARED]
        found.ledgers[MOTOR_SQUARED] += swings * (squared[1] - squared[0])  # all work is given back
        return found


def place_at(elapsed: Array, since: Array, took: Array) -> Array:
    """Places x (n,), from -1 to 1, at times ``since`` (n,) the starts of panels that took so long; ``elapsed`` (k, n) their polynomials."""
    x = 2 * np.clip(since / took, 0.0, 1.0) - 1
    for _ in range(8):
        value, slope = _with_slope(elapsed, x)
        step = (value - since) / slope
        x = np.clip(x - step, -1.0, 1.0)
        if np.abs(step).max(initial=0.0) < 1e-13:
            break
    return x


def values(coefficients: Array, x: Array) -> Array:
    """Values (..., n) of polynomials, coefficients (..., k, n) of rising powers."""
    value = coefficients[..., -1, :].copy()
    for k in range(coefficients.shape[-2] - 2, -1, -1):
        value *= x
        value += coefficients[..., k, :]
    return value


def _with_slope(coefficients: Array, x: Array) -> tuple[Array, Array]:
    """Values (n,) and derivatives of polynomials, coefficients (k, n) of rising powers."""
    value, slope = coefficients[-1].copy(), np.zeros_like(x)
    for k in range(len(coefficients) - 2, -1, -1):
        slope = slope * x + value
        value = value * x + coefficients[k]
    return value, slope
