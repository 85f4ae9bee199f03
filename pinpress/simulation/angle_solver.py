"""One press solved over the crank angle, period after period. Where it stops and no force depends on its speed, it is followed back."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.numerics import gauss_rule, horner, polynomial_root, polynomial_values, values_and_slopes
from ..common.quantities import Array
from ..drives.protocol import Drive
from ..loads.caller_laws import LawError
from . import collocation
from .collocation import (
    SAME,
    STEADY,
    TO_REST,
    CollocationSolution,
    Indices,
    Mesh,
    angle_to,
    build_mesh,
    cuts,
    interpolate_onto,
    mesh_borders,
    range_ahead,
    stopping_panels,
)
from .driven_press import DrivenPress
from .failures import failure
from .reduced_model import COORDINATES, INERTIA, WEIGHT, lock_reached
from .trajectory import INTEGRALS, RepetitionSegment, Sample, Segment, State, Trajectory

SMALL = 1e-2  # shorter swings are followed over time: their forces are small differences [rad]
REST = 0.2  # angle before a stop that is solved over its square root [rad]
NOTHING = 3e-11  # share of the range of the potential energy a radian: a smaller force does not move a crank at rest
LITTLE = 1e-7  # share of the range of the potential energy: a start with less kinetic energy is followed over time
USED_UP = 1e-9  # share of the largest kinetic energy on the way: what is left at a stop is rounding below it
MOST_PERIODS = 200_000  # most periods of one run: each takes some memory
NOTICED = 1e-6  # share of a swing: two stops further apart are different places
MOST_CUTS = 40  # most rounds of cutting panels
MOST_KEPT = 150  # panels beyond those of the model that are taken over into the next period
# A crank is nearly at rest where its kinetic energy, and what the potential energy may still rise, are below this share of the latter's
# range.
NEAR = 1e-5


# --------------------------------------------------------------------------------------------------------------------- from stop to stop


class Stop(NamedTuple):
    """Why a run over the angle ended.

    Attributes:
        state: in which it ended.
        at_rest: whether the press is at rest there, and no force depends on its speed.
    """

    state: State
    at_rest: bool


class AngleSolver:
    """Follows a press that turns, from a state to a time or to a place where it may stop.

    Attributes:
        segments: found so far, one for each period.
        state: of the press at their end.
    """

    def __init__(self, driven: DrivenPress, begin: State, until: float, tolerance: float) -> None:
        """Begin with a state.

        Args:
            driven: what is simulated.
            begin: the state.
            until: time at which the run ends [s].
            tolerance: last terms of a panel's polynomials that are accepted, as a share of the whole.
        """
        self.driven, self.model, self.until, self.tolerance = driven, driven.model, until, tolerance
        self.segments: list[Segment] = []
        self.state = begin
        self.before: CollocationSolution | None = None  # of the period before: its panels and speeds are a good guess
        self.swings = _Swings(driven)
        if not begin.speed:
            self.swings.repetition(self.segments, begin, until)
        # Growing angles would be rounded differently in each period, and a period must begin with exactly what the one before ended with.
        # The equation is therefore solved over the same angles from the ``anchor`` on, and the crank's own angle is counted separately.
        self.anchor, self.first, self.periods = begin.angle, begin.angle, 0

    def run(self, progress: Callable[[float], None] | None = None) -> Stop | None:
        """Add segments up to the end, or to a place where the press may stop. Returns why it ended there, None at the end.

        Args:
            progress: called with the time reached [s] after every period.

        Raises:
            SimulationError: the press runs against a lock.
        """
        while self.state.time < self.until:
            if len(self.segments) == MOST_PERIODS:
                raise failure("too many periods", self.state.time, self.state.angle, most=MOST_PERIODS)
            direction = _direction(self.driven, self.state)
            if direction == 0:
                return Stop(self.state, at_rest=True)
            try:
                found = self._period(direction)
            except LawError as error:
                raise error.within(self.state.time, self.state.angle) from error.__cause__
            if found is None:
                return Stop(self.state, at_rest=False)
            self._append(*found)
            if progress is not None:
                progress(min(self.state.time, self.until))
            if not self._goes_on(*found):
                return Stop(self.state, at_rest=False)
        return None

    def _append(self, solution: CollocationSolution, count: int) -> None:
        """Add the segment of the first ``count`` panels of a solution, and go to its end."""
        own = replace(solution, mesh=replace(solution.mesh, start=self.state.angle))
        segment = angle_segment(self.driven, own, count, self.state)
        self.segments.append(segment)
        self.state = segment.last()
        if self.model.period is not None and segment.travelled == self.model.period:
            self.periods += 1
            self.state = self.state._replace(angle=self.first + solution.mesh.direction * self.periods * self.model.period)
        else:
            self.anchor += solution.mesh.direction * segment.travelled
            self.first, self.periods = self.state.angle, 0

    def _goes_on(self, solution: CollocationSolution, count: int) -> bool:
        """Prepare the next period, and return whether there is one. Where the press swings for ever, add the repetition up to the end."""
        kinds, self.before = solution.mesh.kinds, None
        if not solution.speed_free:
            self.swings.stops.clear()
        if kinds[count - 1] == TO_REST:
            self.state = self.state._replace(speed=0.0)
            repetition = self.swings.repetition(self.segments, self.state, self.until)
            if repetition is not None:
                self.segments.append(repetition)
                self.state = self.state._replace(time=self.until)
        elif count < len(kinds) and self.state.time < self.until:
            return False
        elif self.model.period is None and self.state.time < self.until:
            raise lock_reached(self.model, self.state.angle, self.state.time)
        elif kinds[0] == STEADY and len(kinds) < len(self.model.borders) + MOST_KEPT:
            self.before = solution
        return True

    def _period(self, direction: int) -> tuple[CollocationSolution, int] | None:
        """The solution of a period from the anchor on, or of a shorter range up to a stop, and how many of its panels are right.

        None where the crank would stop, or has to start, under a force that depends on its speed.
        """
        driven, model, anchor = self.driven, self.model, self.anchor
        extent = range_ahead(model, anchor, direction)
        if extent <= 2 * SAME:
            raise lock_reached(model, self.state.angle, self.state.time)
        energy = self._energy()
        if 0 < energy[0] < LITTLE * model.potential_range:
            return None
        if self.before is not None:
            return self._resolved(self.before.mesh, energy, self.before.energy)
        borders = mesh_borders(driven, anchor, direction, extent)
        return self._resolved(build_mesh(driven, anchor, direction, borders, (self.state.speed == 0, False)), energy, None)

    def _resolved(self, mesh: Mesh, energy: Array, guess: Array | None) -> tuple[CollocationSolution, int] | None:
        """Solve a period over a mesh, and cut that where it is too coarse. Returns as `_period`.

        Args:
            mesh: to begin with.
            energy: (1,) kinetic energy at the start [J].
            guess: (q, p, 1) kinetic energy at the nodes of the mesh [J]; None: unknown.
        """
        driven, anchor, direction = self.driven, self.anchor, mesh.direction
        from_rest, to_rest = self.state.speed == 0, False
        for _ in range(MOST_CUTS):
            if guess is None and from_rest:
                guess = _any_energy(driven, mesh)
            solution = collocation.solve(driven, mesh, energy, guess)
            if (from_rest and not solution.speed_free) or (to_rest and not _comes_to_rest(solution)):
                return None
            count, stopping = _before_stop(solution, self.state.time, self.until)
            stops = stopping and solution.speed_free and not to_rest
            if count == 0 and not stops:
                return None
            coarse = cuts(solution, count, self.tolerance, driven.corners) if count else np.zeros(0)
            if len(coarse):
                borders = np.sort(np.concatenate([mesh.borders, coarse]))
            elif stops:  # only from panels that are right it is known where it stops
                borders = _with_rest(solution, count, angle_to(self.model, driven.switch_angles, anchor, direction), from_rest)
                to_rest = True
                if borders[-1] < SMALL:
                    return None
            else:
                return solution, count
            mesh = build_mesh(driven, anchor, direction, borders, (from_rest, to_rest))
            guess = interpolate_onto(solution, mesh)
        # some panels are still not resolved: there the crank nearly stops, or the drive switches again and again
        right = 0 if to_rest or not len(coarse) else int(mesh.borders.searchsorted(coarse.min())) - 1
        return (solution, right) if right > 0 else None

    def _energy(self) -> Array:
        """(1,) kinetic energy of the state [J]."""
        inertia = float(self.model.at(np.array([self.anchor]))[0][INERTIA, 0]) + self.driven.inertia
        if not inertia > 0:
            raise failure("no inertia", self.state.time, self.state.angle, inertia=inertia)
        return np.array([0.5 * inertia * self.state.speed**2])


class _Swings:
    """Remembers the stops of a press. Where no force depends on its speed and it stops in the same place again, it repeats that swing for
    ever."""

    def __init__(self, driven: DrivenPress) -> None:
        self.stops: list[tuple[int, float, float]] = []  # segments before, time, crank angle
        self.same_both_ways = all(force.rising is force.falling for force in driven.forces)

    def repetition(self, segments: Sequence[Segment], stop: State, until: float) -> RepetitionSegment | None:
        """The repetition of the swing that ends with this stop; None where none does."""
        self.stops.append((len(segments), stop.time, stop.angle))
        if len(self.stops) < 3 or not self.same_both_ways:
            return None
        (count, first, at), (_, _, beyond) = self.stops[-3:-1]
        if abs(stop.angle - at) > NOTICED * abs(beyond - at) or not first < stop.time < until:
            return None
        return RepetitionSegment(Trajectory(segments[count:]), first, stop.time, until)


def _direction(driven: DrivenPress, state: State) -> int:
    """Direction in which the crank turns, or starts from rest; 0 where it stays at rest."""
    model = driven.model
    if state.speed:
        return 1 if state.speed > 0 else -1
    scale = np.abs(model.coefficients[:, WEIGHT, 0]).max() + model.potential_range
    for direction in (1, -1):
        ends = np.array([0.0, 1e-6])
        if model.period is None and not model.borders[0] <= state.angle + direction * 1e-6 <= model.borders[-1]:
            continue
        beside = build_mesh(driven, state.angle, direction, ends, (True, False))
        force = collocation.solve(driven, beside, np.zeros(1), _any_energy(driven, beside)).force
        if force[0, 0, 0] > NOTHING * scale:
            return direction
    return 0


def _any_energy(driven: DrivenPress, mesh: Mesh) -> Array:
    """(q, p, 1) kinetic energy at 1 rad/s: a first guess where there is no better one [J]."""
    return np.asarray(0.5 * (mesh.inertia[:, :, None] + driven.inertia))


def _comes_to_rest(solution: CollocationSolution) -> bool:
    """Whether the crank comes to rest at the end of the panels: no force depends on its speed, and all its energy is used up."""
    left = float(solution.ends[0, 0] + (gauss_rule().weights @ (solution.force[:, :, 0] * solution.mesh.measure)).sum())
    return solution.speed_free and abs(left) <= USED_UP * float(solution.ends.max())


def _before_stop(solution: CollocationSolution, time: float, until: float) -> tuple[int, bool]:
    """Number of panels up to a stop, or up to and with that in which the time ``until`` is reached, and whether a stop ends them."""
    stopping = stopping_panels(solution)[:, 0]
    right = int(np.argmax(stopping)) if stopping.any() else len(stopping)
    if right:
        slowness = solution.mesh.measure[:, :right] / solution.speed[:, :right, 0]
        reached = time + (gauss_rule().weights @ slowness).cumsum() >= until
        if reached.any():
            return int(np.argmax(reached)) + 1, False
    return right, right < len(stopping)


def _with_rest(solution: CollocationSolution, panel: int, edges: Array, from_rest: bool) -> Array:
    """Borders up to the stop in a ``panel``. The last of the new panels runs over the square root of the angle; it begins at the last of
    the ``edges`` before the stop, which are angles travelled, or later."""
    mesh = solution.mesh
    stop = float(mesh.travelled(np.array([panel]), np.array([_stop_in(solution, panel)]))[0][0])
    edges = edges[edges < stop - SAME]
    begin = max(stop - REST, float(edges.max(initial=0.0)))
    if from_rest:
        begin = max(begin, min(float(mesh.borders[1]), 0.5 * stop))
    return np.concatenate([mesh.borders[mesh.borders < begin - SAME], [begin, stop]]) if begin > 0 else np.array([0.0, stop])


def _stop_in(solution: CollocationSolution, panel: int) -> float:
    """Place x, from -1 to 1, at which the kinetic energy is used up on a panel."""
    rule, mesh = gauss_rule(), solution.mesh
    polynomial = rule.integral(solution.force[:, panel, 0] * mesh.measure[:, panel]).tolist()
    polynomial[0] += float(solution.ends[panel, 0])
    samples = np.append(rule.nodes, 1.0)
    first = int(np.argmax(np.append(solution.energy[:, panel, 0], solution.ends[panel + 1, 0]) <= 0))
    low = -1.0 if first == 0 else float(samples[first - 1])
    # a stop on the border itself may not show: W is rounding there
    return polynomial_root(polynomial, low, float(samples[first])) if horner(polynomial[::-1], low) > 0 else low


# ------------------------------------------------------------------------------------------------------------------------------ in time


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
        evaluations: see `CollocationSolution`.
        slow: crank angles at which the crank is `nearly_at_rest` [rad].
    """

    driven: DrivenPress
    mesh: Mesh
    count: int
    begin: State
    times: Array
    elapsed: Array
    summed: Array
    integrals: Array
    final_speed: float
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
        return Sample(angle[None], speed[None], acceleration[None], torque, motor, speed, integrals)

    def _dynamics(self, panel: Indices, angle: Array, speed: Array) -> tuple[Array, Array]:
        """Torque of the drive and acceleration of the crank (n,) at states on panels (n,)."""
        values, slopes = self.driven.model.at(angle)
        torque = np.zeros_like(speed)
        if self.driven.drive is not None:
            torque = torque + self.driven.drive.torque(speed)
        total = torque - values[WEIGHT] - 0.5 * slopes[INERTIA] * speed**2
        along: dict[int, Array] = {}
        for force in self.mesh.forces:
            mine = np.flatnonzero(np.isin(panel, force.panels))
            if len(mine):
                lever = slopes[COORDINATES + force.row, mine]
                size = force.interval.force(values[COORDINATES + force.row, mine] - force.datum, lever * speed[mine])
                size = np.maximum(size, 0.0) if force.interval.one_sided else size
                total[mine] += lever * size
                along.setdefault(force.row, np.zeros_like(speed))[mine] += size
        inertia = values[INERTIA] + self.driven.inertia
        if self.driven.bearing_model is not None:
            way, held = self.mesh.direction, self.driven.prescribed is not None
            columns = {row: force[:, None] for row, force in along.items()}
            resisting = np.full_like(inertia, np.inf) if held else inertia
            bearings = self.driven.bearing_model.at(angle)
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
    elapsed = rule.integral(measure / speed)
    driving, motor = _drive_torques(driven, solution, count)
    rates = [driving, -solution.resisting[:, :count, 0], motor * motor / speed]
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
        evaluations=solution.evaluations,
        slow=mesh.angle[:, :count][nearly],
    )


def _drive_torques(driven: DrivenPress, solution: CollocationSolution, count: int) -> tuple[Array, Array]:
    """Torque of the drive along the travel, and of its motor at the motor's own shaft, (q, count) each, of one scenario [N m]."""
    drive, driving = driven.drive, solution.driving[:, :count, 0]
    if drive is not None:
        motor = np.asarray(drive.motor_torque(solution.mesh.direction * solution.speed[:, :count, 0]))
        return drive_torque(drive, solution)[:, :count, 0], motor
    return driving, np.zeros_like(driving) if driven.prescribed is None else driving


def drive_torque(drive: Drive, solution: CollocationSolution) -> Array:
    """Torque (q, p, S) of a drive along the travel at the speeds of a solution. It is computed again from these speeds, so that the energy
    balance tells whether they are right."""
    direction, speed = solution.mesh.direction, solution.speed
    return np.asarray(direction * drive.torque(direction * speed) + np.zeros_like(speed))


def nearly_at_rest(energy: Array, force: Array, span: float) -> NDArray[np.bool_]:
    """Whether cranks are nearly at rest.

    Args:
        energy: kinetic energies (...) [J].
        force: net torques (...) on the cranks [N m].
        span: range of the potential energy [J].
    """
    found = np.asarray(energy < NEAR * span)
    return found & (energy + force**2 / (2 * span) < NEAR * span) if found.any() else found


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
        if np.abs(step).max(initial=0.0) < 1e-13:
            break
    return np.where(since > 0, x, -1.0)  # a press that starts from rest stands still there, without rounding
