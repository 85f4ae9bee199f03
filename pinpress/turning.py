"""One press over the crank angle: period after period, and where it stops and no force depends on its speed, back again."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from . import over_angle, panels, resolution
from .coordinates import Array
from .drives import PrescribedSpeed
from .errors import SimulationError
from .over_angle import Flow
from .panels import STEADY, TO_REST, Grid, Indices
from .path import LEDGERS, Reading
from .reduced import COORDINATES, INERTIA, POTENTIAL, WEIGHT, Table, beyond, horner, root, rule
from .scene import Scene, not_positive

SMALL = 1e-2  # swings shorter than this are followed over time: their forces are small differences [rad]
REST = 0.2  # angle before a stop that is run through over its square root [rad]
NOTHING = 3e-11  # force on a crank at rest, beside the range of the potential energy a radian, that is none
LITTLE = 1e-7  # kinetic energy, beside the range of the potential one, from which a start is followed over time
MOST_PERIODS = 200_000  # in one run; each takes some memory
MOST_CUTS = 40  # rounds of cutting panels
MOST_KEPT = 150  # panels more than the table's, that are taken over into the next period


def too_long(time: float, angle: float) -> SimulationError:
    """A run has more periods than are kept."""
    return SimulationError(f"more than {MOST_PERIODS} periods of the press: simulate in parts", time, angle)


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
    """

    scene: Scene
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

    @property
    def start(self) -> float:
        return self.begin.time

    @property
    def end(self) -> float:
        return float(self.times[-1])

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
        drive = self.scene.drive
        geared = drive is not None and not isinstance(drive, PrescribedSpeed)
        motor = drive.motor_torque(speed) + np.zeros_like(speed) if geared else torque  # type: ignore[union-attr]
        return Reading(angle[None], speed[None], acceleration[None], torque, motor, speed, ledgers)

    def _dynamics(self, panel: Indices, angle: Array, speed: Array) -> tuple[Array, Array]:
        """Torque of the drive and acceleration of the crank (n,) at states on panels (n,)."""
        values, slopes = self.table.at(angle)
        scene = self.scene
        torque = np.zeros_like(speed)
        if scene.drive is not None and not isinstance(scene.drive, PrescribedSpeed):
            torque = torque + scene.drive.torque(speed)
        force = torque - values[WEIGHT] - 0.5 * slopes[INERTIA] * speed**2
        for push in self.grid.pushes:
            mine = np.flatnonzero(np.isin(panel, push.panels))
            if len(mine):
                lever = slopes[COORDINATES + push.row, mine]
                size = push.stretch.force(values[COORDINATES + push.row, mine] - push.datum, lever * speed[mine])
                force[mine] += lever * (np.maximum(size, 0.0) if push.stretch.one_sided else size)
        if isinstance(scene.drive, PrescribedSpeed):
            return -force, np.zeros_like(force)
        return torque, force / (values[INERTIA] + scene.inertia)

    def last(self) -> State:
        """The state at the end."""
        angle = self.grid.start + self.grid.direction * float(self.grid.borders[self.count])
        ledgers = self.begin.ledgers.copy()
        ledgers[:3] += self.ledgers[:, -1]
        return State(self.end, angle, self.final_speed, ledgers)


def turned(scene: Scene, table: Table, flow: Flow, count: int, begin: State) -> Turned:
    """The first ``count`` panels of a flow of one scenario in time."""
    r, g = rule(), flow.grid
    measure, speed = g.measure[:, :count], flow.speed[:, :count, 0]
    elapsed = r.integral @ (measure / speed)
    if scene.drive is None:
        motor = np.zeros_like(speed)
    elif isinstance(scene.drive, PrescribedSpeed):
        motor = flow.driving[:, :count, 0]
    else:
        motor = np.asarray(scene.drive.motor_torque(g.direction * speed))
    # once more at the speeds that came out of it: so the energy balance tells whether these are right
    driving = flow.driving[:, :count, 0]
    if scene.drive is not None and not isinstance(scene.drive, PrescribedSpeed):
        driving = g.direction * scene.drive.torque(g.direction * speed) + np.zeros_like(speed)
    rates = [driving, -flow.resisting[:, :count, 0], motor * motor / speed]
    summed = np.array([r.integral @ (rate * measure) for rate in rates])
    return Turned(
        scene=scene,
        table=table,
        grid=g,
        count=count,
        begin=begin,
        times=np.concatenate([[begin.time], begin.time + elapsed.sum(axis=0).cumsum()]),  # x = 1: the sum of the coefficients
        elapsed=elapsed,
        summed=summed,
        ledgers=np.concatenate([np.zeros((3, 1)), summed.sum(axis=1).cumsum(axis=1)], axis=1),
        final_speed=g.direction * math.sqrt(2 * max(0.0, float(flow.ends[count, 0])) / (float(g.inertia_ends[count]) + scene.inertia)),
        evaluations=flow.evaluations,
    )


@dataclass(frozen=True, eq=False, repr=False)
class Resting:
    """A press that stands, from a state on until a time."""

    at: State
    end: float

    @property
    def start(self) -> float:
        return self.at.time

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


class Stop(NamedTuple):
    """Why a run over the angle ended: ``at`` the state reached; ``held``: it is at rest there, and no force depends on speed."""

    at: State
    held: bool


def run(
    scene: Scene,
    table: Table,
    edges: Sequence[Array],
    begin: State,
    until: float,
    tolerance: float,
    progress: Callable[[float], None] | None = None,
) -> "tuple[list[Turned], Stop | None]":
    """Follow a press that turns, from a state on, up to a time or to where it may stop.

    Raises:
        SimulationError: it runs against a lock, or comes to rest where forces hold it from both sides.
    """
    segments: list[Turned] = []
    state, before = begin, None
    while state.time < until:
        if len(segments) == MOST_PERIODS:
            raise too_long(state.time, state.angle)
        direction = _direction(scene, table, state)
        if direction == 0:
            return segments, Stop(state, held=True)
        found = _period(scene, table, edges, state, direction, until, tolerance, before)
        if found is None:
            return segments, Stop(state, held=False)
        flow, count = found
        solved = turned(scene, table, flow, count, state)
        segments.append(solved)
        state = solved.last()
        if progress is not None:
            progress(min(state.time, until))
        before = None
        if flow.grid.kinds[count - 1] == TO_REST:
            state = state._replace(speed=0.0)
        elif count < len(flow.grid.kinds) and state.time < until:
            return segments, Stop(state, held=False)
        elif table.period is None and state.time < until:
            raise beyond(table, state.angle, state.time)
        elif flow.grid.kinds[0] == STEADY and len(flow.grid.kinds) < len(table.borders) + MOST_KEPT:
            before = flow
    return segments, None


def _direction(scene: Scene, table: Table, state: State) -> int:
    """Way in which the crank turns, or starts from rest; 0 where it stays."""
    if state.speed:
        return 1 if state.speed > 0 else -1
    scale = np.abs(table.coefficients[:, WEIGHT, 0]).max() + np.ptp(table.coefficients[:, POTENTIAL, 0])
    for direction in (1, -1):
        ends = np.array([0.0, 1e-6])
        if table.period is None and not table.borders[0] <= state.angle + direction * 1e-6 <= table.borders[-1]:
            continue
        beside = panels.grid(scene, table, state.angle, direction, ends, (True, False))
        force = over_angle.flow(scene, beside, np.zeros(1), _any_energy(scene, beside)).force
        if force[0, 0, 0] > NOTHING * scale:
            return direction
    return 0


def _any_energy(scene: Scene, grid: Grid) -> Array:
    """Kinetic energy at 1 rad/s (q, p, 1): where to start from, when there is none yet."""
    return np.asarray(0.5 * (grid.inertia[:, :, None] + scene.inertia))


def _period(
    scene: Scene,
    table: Table,
    edges: Sequence[Array],
    state: State,
    direction: int,
    until: float,
    tolerance: float,
    before: Flow | None,
) -> tuple[Flow, int] | None:
    """A period of the table, or less up to a stop or the time ``until``, and how many of its panels are right.

    ``before`` is the period before: its panels and its speeds are a good start. None where the crank would stop, or has to start, under a
    force that depends on its speed.
    """
    extent = panels.extent(table, state.angle, direction)
    if extent <= 2 * panels.SAME:
        raise beyond(table, state.angle, state.time)
    from_rest, to_rest = state.speed == 0, False
    inertia = float(table.at(np.array([state.angle]))[0][INERTIA, 0]) + scene.inertia
    if not inertia > 0:
        raise not_positive(inertia, state.time, state.angle)
    energy = np.array([0.5 * inertia * state.speed**2])
    if 0 < energy[0] < LITTLE * np.ptp(table.coefficients[:, POTENTIAL, 0]):
        return None
    corners: tuple[float, ...] = ()
    if scene.drive is not None and not isinstance(scene.drive, PrescribedSpeed):
        corners = tuple(float(np.ravel(corner)[0]) for corner in scene.drive.corners)
    if before is not None:
        grid, guess = replace(before.grid, start=state.angle), before.energy
    else:
        ends = panels.borders(table, edges, state.angle, direction, extent)
        grid, guess = panels.grid(scene, table, state.angle, direction, ends, (from_rest, to_rest)), None
    for _ in range(MOST_CUTS):
        if guess is None and from_rest:
            guess = _any_energy(scene, grid)
        flow = over_angle.flow(scene, grid, energy, guess)
        if from_rest and not flow.held:
            return None
        count, stopping = _before_stop(flow, state.time, until)
        ends = grid.borders
        if stopping and flow.held and not to_rest:
            ends = _with_rest(flow, count, ends, panels.on_the_way(table, edges, state.angle, direction), from_rest)
            to_rest = True
            if ends[-1] < SMALL:
                return None
        elif count == 0:
            return None
        else:
            cuts = resolution.unresolved(flow, count, tolerance, corners)
            if not len(cuts):
                return flow, count
            ends = np.sort(np.concatenate([ends, cuts]))
        grid = panels.grid(scene, table, state.angle, direction, ends, (from_rest, to_rest))
        guess = resolution.carried(flow, grid)
    # what still is not resolved: there the crank all but stops, or the drive switches again and again
    right = int(grid.borders.searchsorted(cuts.min())) - 1
    return (flow, right) if right > 0 and not to_rest else None


def _before_stop(flow: Flow, time: float, until: float) -> tuple[int, bool]:
    """Panels up to a stop, or to the one in which the time ``until`` is reached; whether it was a stop that ended them."""
    stopping = resolution.stopping(flow)[:, 0]
    right = int(np.argmax(stopping)) if stopping.any() else len(stopping)
    if right:
        times = time + (rule().weights @ (flow.grid.measure[:, :right] / flow.speed[:, :right, 0])).cumsum()
        reached = times >= until
        if reached.any():
            return int(np.argmax(reached)) + 1, False
    return right, right < len(stopping)


def _with_rest(flow: Flow, panel: int, ends: Array, hard: Array, from_rest: bool) -> Array:
    """Borders up to the stop in a ``panel``, the last of them over the square root of the angle; it starts at ``hard`` borders at the
    latest."""
    grid, r = flow.grid, rule()
    polynomial = (r.integral @ (flow.force[:, panel, 0] * grid.measure[:, panel])).tolist()
    polynomial[0] += float(flow.ends[panel, 0])
    samples = np.append(r.nodes, 1.0)
    first = int(np.argmax(np.append(flow.energy[:, panel, 0], flow.ends[panel + 1, 0]) <= 0))
    low = -1.0 if first == 0 else float(samples[first - 1])
    # a stop on the border itself may show as none: W is rounding there
    x = root(polynomial, low, float(samples[first])) if horner(polynomial[::-1], low) > 0 else low
    stop = float(panels.travelled(grid, np.array([panel]), np.array([x]))[0][0])
    hard = hard[hard < stop - panels.SAME]
    begin = max(stop - REST, float(hard.max(initial=0.0)))
    if from_rest:
        begin = max(begin, min(float(ends[1]), 0.5 * stop))
    return np.concatenate([ends[ends < begin - panels.SAME], [begin, stop]]) if begin > 0 else np.array([0.0, stop])


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
