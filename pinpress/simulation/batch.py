"""Many scenarios at once, which differ in their speeds and in parameters of drives, flywheels and loads that are declared with scenarios.

All scenarios of a press run over the same crank angles, so that one period of all of them is solved as one array (see `collocation`). A
scenario is simulated on its own if it stops, depends on more than angle and speed, passes a corner of its drive's torque under a fine
tolerance, or does not balance its energy this way.
"""

from __future__ import annotations

import time as clock
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.arguments import in_unit, is_whole_number, number, suitable_numbers, typed
from ..common.errors import PinpressError, SimulationError, UnknownScenarioError
from ..common.frozen import read_only
from ..common.numerics import gauss_rule, polynomial_values, running_sums, values_and_slopes
from ..common.parameters import pick_scenarios, scenario_lengths
from ..common.quantities import Array
from ..common.results import Tabular
from ..drives.protocol import Drive
from ..drives.transmission import Flywheel, PrescribedSpeed
from ..dynamics.inverse_dynamics import NONE_GIVEN
from ..kinematics.cycle import doubt_speeds, motion_through_change_points
from ..linkage.assembly import refuse_far
from ..linkage.linkage import Linkage
from ..loads.caller_laws import LawError
from ..loads.link import Friction, Load
from .driven_press import DrivenPress, driven_press
from .failures import failure
from .law_trials import tried
from .over_angle.angle_solver import MOST_PERIODS
from .over_angle.collocation import CollocationSolution, panel_integrals
from .over_angle.mesh import Indices, build_mesh, mesh_borders
from .over_angle.refinement import cuts, passed_corners, solve_period, stopping_panels, unsettled_panels
from .over_angle.segment import nearly_at_rest, place_at, torques_at_speeds
from .reduced_model import COORDINATES, INERTIA, energies, reduced_model_of
from .run import Run, allowed_error, energy_error, state_count
from .simulate import doubt_motor, is_reducible, simulate
from .solvers import checked_tolerance, refuse_many_turns

Mask = NDArray[np.bool_]

AT_ONCE = 334  # scenarios in one array: more make it no faster, but take more memory
MOST_CUTS = 24  # most rounds of cutting panels; scenarios that need more are run alone
MOST_PANELS = 100_000  # panels beyond those of the model times scenarios: with more, runs alone are faster, and take less memory
FINE = 5e-11  # with a smaller tolerance of panels, halving them until they resolve every corner may take longer than runs alone


@dataclass(frozen=True, eq=False, repr=False)
class RunBatch(Tabular):
    """S simulated scenarios of a press, n states each at the same times; ``runs[k]`` is scenario k as a `Run`. Arrays are read-only.

    Attributes:
        time: (n,) [s].
        crank_angle: (n, S) [rad]; a scenario that stalls rests where it stopped.
        crank_speed: (n, S) [rad/s].
        drive_work: (S,) of the drive over the whole run [J].
        load_work: (S,) against the loads over the whole run [J].
        lost: (S,) in the friction of the bearings over the whole run [J].
        energy_error: (S,) as in `Stats`, from the states at start and end.
        errors: (S,) errors of scenarios that stalled or could not go on; None for all others.
        wall_time: of the whole call [s].
    """

    time: Array
    crank_angle: Array
    crank_speed: Array
    drive_work: Array
    load_work: Array
    lost: Array
    energy_error: Array
    errors: tuple[SimulationError | None, ...]
    wall_time: float
    _scenarios: _Scenarios

    @cached_property
    def slide_position(self) -> Array | None:
        """(n, S) along the guide's axis [m]; None if there is no slide."""
        press = self._scenarios.press
        if press.slide is None:
            return None
        position: Array = reduced_model_of(press).at(self.crank_angle)[0][COORDINATES].copy()
        return read_only(position)

    def columns(self) -> dict[str, Array]:
        """All states, scenario by scenario, as (n S,) columns under their names with units."""
        count = len(self)
        return {
            "scenario": np.repeat(np.arange(count), len(self.time)),
            "time [s]": np.tile(self.time, count),
            "crank_angle [rad]": self.crank_angle.T.ravel(),
            "crank_speed [rad/s]": self.crank_speed.T.ravel(),
            **({} if self.slide_position is None else {"slide_position [m]": self.slide_position.T.ravel()}),
        }

    def __len__(self) -> int:
        return len(self.errors)

    def __getitem__(self, k: int) -> Run:
        """Scenario k as a `Run`, for which it is simulated again. Raises the error that stopped it."""
        if not is_whole_number(k) or not -len(self) <= k < len(self):
            raise UnknownScenarioError(k, len(self))
        return self._scenarios.alone(int(k) % len(self))

    def __iter__(self) -> Iterator[Run]:
        """The runs one after the other. Raises the error that stopped one."""
        return (self[k] for k in range(len(self)))

    @property
    def title(self) -> str:
        stalled = sum(error is not None for error in self.errors)
        said = f", {stalled} stalled" if stalled else ""
        return f"RunBatch of {self._scenarios.press.name}: {len(self)} scenarios, {len(self.time)} states each, {self.time[-1]:.6g} s{said}"


@typed
def simulate_batch(
    press: Linkage,
    duration: float,
    *,
    speed: ArrayLike = 0.0,
    angle: float | None = None,
    drive: Drive | None = None,
    flywheel: Flywheel | None = None,
    loads: Sequence[Load] = (),
    friction: Mapping[str, Friction] = NONE_GIVEN,
    points: int | None = None,
    tolerance: float = 1e-11,
) -> RunBatch:
    """Let a press with one driver run in S scenarios at once.

    ``speed``, and the parameters of drive, flywheel and loads that may differ between scenarios, are (S,), or one number for all. Your own
    drive, flywheel or load declares such fields with `parameter` (``scenarios=True``).

    Args:
        press: the linkage.
        duration: [s].
        speed: of the crank at the start [rad/s], one number or (S,).
        angle: of the crank at the start, the same in all scenarios [rad]; by default that of the home pose, as a rule 0.
        drive: what turns the crank, see `pinpress.drives`; None: nothing.
        flywheel: its inertia stands at the driver joint; None: none.
        loads: process loads of `pinpress.loads`, constant forces on links, springs and dampers.
        friction: as in `simulate`, the same in all scenarios.
        points: number of states returned; by default 121.
        tolerance: error accepted of a step, relative to 1 rad and to the speeds of the crank.

    Returns:
        The batch. A scenario that stalls has its error in ``errors``, and rests where it stopped.

    Raises:
        PinpressError: an argument makes no sense, or arrays are for different numbers of scenarios.
        SimulationError: the crank would make too many turns.
    """
    began = clock.perf_counter()
    press.refuse_several_drivers("scenarios are those of a press with one; call simulate for each")
    press.refuse_sliding_driver("scenarios are those of a crank; call simulate for each")
    until, tolerance = number("duration", duration, "s", positive=True), checked_tolerance(tolerance)
    states = state_count(points, 0.0)
    loads = list(loads)  # of what is gone through once, too
    unit = press.driver_coordinates[0].unit
    angle = float(press.closed[press.driver_indices[0]]) if angle is None else in_unit("angle", angle, unit)
    speed = in_unit("speed", speed, f"{unit}/s")
    if not _is_number(angle):
        raise PinpressError("angle is an array: scenarios start from the same crank angle; give one number [rad]")
    speeds, start = _speeds(speed, (drive, flywheel, *loads)), number("angle", angle)
    refuse_far("angle", np.array(start), press.driver_coordinates)
    drive, loads = tried(drive, loads, float(np.abs(speeds).max()))
    if isinstance(drive, PrescribedSpeed):
        raise PinpressError("a drive that prescribes the speed leaves nothing to simulate in scenarios: use simulate")
    refuse_many_turns(speeds, until, start)
    doubt_speeds(press, speeds)
    doubt_motor(press, drive, speeds)
    scenarios = _Scenarios(press, until, start, speeds, (drive, flywheel, *loads), friction, states, tolerance)
    with np.errstate(all="ignore"):  # what is not finite is refused where it arises
        return _solve(scenarios, began)


def _speeds(speed: ArrayLike, parts: Sequence[Any]) -> Array:
    """(S,) speeds at the start [rad/s]. S is the length of the arrays that are given, 1 where none is given."""
    wanted = "one finite number, or (S,) of them [rad/s]"
    speeds = suitable_numbers("speed", speed, wanted, None, lambda values: values.ndim < 2 and values.size)
    counts = {} if speeds.ndim == 0 else {"speed": len(speeds)}
    for part in parts:
        counts |= scenario_lengths(part)
    if len(set(counts.values())) > 1:
        raise PinpressError(f"arrays for different numbers of scenarios: {', '.join(f'{name} {size}' for name, size in counts.items())}")
    return np.broadcast_to(speeds, (next(iter(counts.values()), 1),)).copy()


def _is_number(value: Any) -> bool:
    """Whether a value is not an array, whatever else it may be."""
    return isinstance(value, str) or not hasattr(value, "__len__") or (isinstance(value, np.ndarray) and value.ndim == 0)


@dataclass(frozen=True, eq=False)
class _Scenarios:
    """The scenarios to simulate."""

    press: Linkage
    until: float  # end [s]
    angle: float  # of the crank at the start [rad]
    speeds: Array  # (S,) of the crank at the start [rad/s]
    parts: tuple[Any, ...]  # drive, flywheel and loads, with the values of all scenarios
    friction: Mapping[str, Friction]  # of the bearings, by their names
    points: int  # states of a run
    tolerance: float  # as in `simulate`

    def together(self, block: Indices) -> DrivenPress:
        """The press of the scenarios with these indices, as one array."""
        drive, flywheel, *loads = (pick_scenarios(part, block) for part in self.parts)
        return driven_press(self.press, drive, flywheel, loads, None, None, self.friction)

    def alone(self, k: int, end: float | None = None) -> Run:
        """Simulate scenario k to the end with all states, or with two states up to the time ``end``."""
        drive, flywheel, *loads = (pick_scenarios(part, k) for part in self.parts)
        until, points = (self.until, self.points) if end is None else (end, 2)
        return simulate(
            self.press,
            until,
            speed=float(self.speeds[k]),
            angle=self.angle,
            drive=drive,
            flywheel=flywheel,
            loads=loads,
            friction=self.friction,
            points=points,
            tolerance=self.tolerance,
        )


def _solve(scenarios: _Scenarios, began: float) -> RunBatch:
    """Solve the scenarios, as many as possible together and the others one by one."""
    count, times = len(scenarios.speeds), np.linspace(0.0, scenarios.until, scenarios.points)
    angles, speeds, works = np.empty((len(times), count)), np.empty((len(times), count)), np.zeros((3, count))
    errors: list[SimulationError | None] = [None] * count
    missing = np.zeros(count)
    reducible = is_reducible(scenarios.together(np.arange(count)))
    left = list(np.flatnonzero(scenarios.speeds == 0)) if reducible else list(range(count))
    for block in _blocks(scenarios.speeds) if reducible else ():
        solver = BatchSolver(scenarios.together(block), scenarios.angle, scenarios.speeds[block], times)
        solver.run(0.1 * scenarios.tolerance)
        missing[block] = error = solver.energy_error()
        solver.alone |= ~(error <= allowed_error(scenarios.tolerance))
        angles[:, block], speeds[:, block], works[:, block] = solver.angle, solver.speed, solver.works
        left += list(block[solver.alone])
    for k in map(int, left):
        angles[:, k], speeds[:, k], works[:, k], missing[k], errors[k] = _solve_alone(scenarios, k, times)
    took = clock.perf_counter() - began
    return RunBatch(times, angles, speeds, works[0], works[1], works[2], missing, tuple(errors), took, scenarios)


def _blocks(speeds: Array) -> Iterator[Indices]:
    """Groups of scenarios that are solved together: of one direction of travel, and not too many."""
    for direction in (1, -1):
        alike = np.flatnonzero(np.sign(speeds) == direction)
        alike = alike[np.abs(speeds[alike]).argsort(kind="stable")]  # those of a group come to their end in about the same period
        for start in range(0, len(alike), AT_ONCE):
            yield alike[start : start + AT_ONCE]


Alone = tuple[Array, Array, tuple[float, float, float], float, SimulationError | None]
"""Angles and speeds (n,) of a scenario, the works of its drive, loads and friction, its energy error, and why it stalled."""


def _solve_alone(scenarios: _Scenarios, k: int, times: Array) -> Alone:
    """A scenario on its own. One that stalls is at rest from there on, with works and energy error up to there."""
    try:
        run = scenarios.alone(k)
    except SimulationError as error:
        return _run_to_stall(error, scenarios, k, times)
    return run.crank_angle, run.crank_speed, _works(run), run.stats.energy_error, None


def _works(run: Run) -> tuple[float, float, float]:
    """Works of drive, loads and friction over a run [J]."""
    return float(run.drive_work[-1]), float(run.load_work[-1]), float(run.lost[-1])


def _run_to_stall(error: SimulationError, scenarios: _Scenarios, k: int, times: Array) -> Alone:
    """Scenario k up to its error, and at rest afterwards."""
    end = 0.0 if error.time is None else error.time * (1 - 1e-9)
    stopped = scenarios.angle if error.crank_angle is None else error.crank_angle
    angles, speeds = np.full(len(times), stopped), np.zeros(len(times))
    before = times < end
    if not before.any():
        return angles, speeds, (0.0, 0.0, 0.0), 0.0, error
    try:
        run = scenarios.alone(k, end)
    except SimulationError:  # it does not get that far again: at rest from the start
        return np.full(len(times), scenarios.angle), speeds, (0.0, 0.0, 0.0), 0.0, error
    sample = run.trajectory.at(times[before])
    angles[before], speeds[before] = sample.position[0], sample.speed[0]
    return angles, speeds, _works(run), run.stats.energy_error, error


# ----------------------------------------------------------------------------------------------------------------------- solved together


class BatchSolver:
    """Solves scenarios of one direction of travel as one array, period by period.

    Attributes:
        angle: (n, S) of the crank at the times [rad].
        speed: (n, S) of the crank at the times [rad/s].
        works: (3, S) works of the drive, works against the loads, and losses by friction [J].
        alone: (S,) whether a scenario has to be run on its own.
    """

    def __init__(self, driven: DrivenPress, angle: float, speed: Array, times: Array) -> None:
        """Begin at a crank angle [rad] with speeds (S,), all of one sign [rad/s]; ``times``: (n,) of the states wanted [s]."""
        self.driven, self.times = driven, times
        self.direction = 1 if speed[0] > 0 else -1
        self.first, self.begin = angle, speed
        self.angle, self.speed = np.empty((len(times), len(speed))), np.empty((len(times), len(speed)))
        self.works = np.zeros((3, len(speed)))
        self.alone = np.zeros(len(speed), dtype=bool)
        self.before: CollocationSolution | None = None
        self.anchor = self.at = angle  # where periods begin: in the equation, and counted on
        self.clock = np.zeros(len(speed))
        self.energy = 0.5 * (driven.model.at(np.array([angle]))[0][INERTIA, 0] + driven.inertia) * speed**2

    def run(self, tolerance: float) -> None:
        """Run all scenarios to the last of the times, or mark them as ``alone``."""
        until, period = float(self.times[-1]), self.driven.model.period
        repeats = self.driven.model.repeats
        if self.driven.timed or not np.all(self.energy > 0) or self._contacts_heed_velocity or period is None or not repeats:
            self.alone[:] = True
            return
        periods = 0
        while (going := ~self.alone & (self.clock < until)).any():
            periods += 1
            if periods > MOST_PERIODS:
                raise failure("too many periods", float(self.clock.max()), self.at, most=MOST_PERIODS)
            try:
                solution = self._period(period, going, until, tolerance)
            except LawError as error:
                raise error.within(float(self.clock[going].min()), self.at) from error.__cause__
            if solution is None:
                break
            passed = running_sums(self.clock, solution.durations)
            # those that come nearly to rest are run alone, which shows whether that rest is unstable
            slow = nearly_at_rest(solution.energy, solution.force, self.driven.model.potential_range)
            self.alone |= going & (slow & (passed[:-1] < until)).any(axis=(0, 1))
            self._advance(solution, passed, going & ~self.alone, until)
            self.at = self.anchor + self.direction * periods * period

    @property
    def _contacts_heed_velocity(self) -> bool:
        """Whether there is a contact with a damper: where it is lost differs between scenarios."""
        intervals = (interval for force in self.driven.forces for interval in force.rising + force.falling)
        return any(interval.one_sided and interval.heeds_velocity for interval in intervals)

    def _advance(self, solution: CollocationSolution, passed: Array, going: Mask, until: float) -> None:
        """Store the states and works of a period, and go to its end."""
        forces = [(k, force, panel_integrals(solution, force)) for k, force in self.drive_and_loads(solution)]
        self._fill(solution, passed, going, until, forces)
        through = going & (passed[-1] < until)
        for k, _, over_panels in forces:
            self.works[k] += np.where(through, over_panels.sum(axis=0), 0.0)
        # a mesh with many more panels than the model, cut for this period alone, would cost every later one
        self.before = solution if len(solution.mesh.kinds) < len(self.driven.model.borders) + 24 else None
        self.clock = np.where(going, passed[-1], self.clock)
        self.energy = np.where(going, solution.ends[-1], self.energy)

    def _period(self, period: float, going: Mask, until: float, tolerance: float) -> CollocationSolution | None:
        """A period, resolved for all scenarios that are ``going``; None, and all of them are run alone, where that takes too many
        panels."""
        driven, nearby = self.driven, self.before
        if nearby is not None:
            mesh = nearby.mesh
        else:
            mesh = build_mesh(driven, self.anchor, self.direction, mesh_borders(driven, self.anchor, self.direction, period))
        places = partial(self._coarse, going=going, until=until, tolerance=tolerance)
        solved = solve_period(driven, mesh, self.energy, places, nearby=nearby, most=MOST_CUTS)
        if solved is None or len(solved.coarse):
            self.alone |= going
            return None
        return solved.solution

    def _coarse(self, solution: CollocationSolution, going: Mask, until: float, tolerance: float) -> Array | None:
        """Where to cut panels that are too coarse for a scenario; None: into too many. Those that stop are marked as ``alone``."""
        driven, mesh = self.driven, solution.mesh
        passed = running_sums(self.clock, solution.durations)
        unfit = stopping_panels(solution)
        wild = unsettled_panels(solution, unfit, going & ~self.alone)
        if tolerance >= FINE and len(wild):  # on narrower panels Newton's method gets past a corner
            places = 0.5 * (mesh.borders[wild] + mesh.borders[wild + 1])
        else:
            if tolerance < FINE and driven.drive is not None:
                unfit |= passed_corners(solution, driven.drive)
            # what follows the end of the run does not matter
            self.alone |= going & (unfit & (passed[:-1] < until)).any(axis=0)
            which = np.flatnonzero(going & ~self.alone)
            if not len(which):
                return np.zeros(0)
            upto = int((passed[:-1, which] < until).any(axis=1).sum())
            places = cuts(solution, upto, tolerance, driven.drive, slice(None) if len(which) == len(going) else which)
        too_many = (len(mesh.kinds) + len(places) - len(driven.model.borders)) * len(going) > MOST_PANELS
        return None if len(places) and too_many else places

    def drive_and_loads(self, solution: CollocationSolution) -> list[tuple[int, Array]]:
        """Forces of the drive along the travel, and of loads and friction against it, if there are any, each with its row in ``works``."""
        driven = self.driven
        driving, resisting = torques_at_speeds(driven, solution)
        parts = [(0, driving)] * (driven.drive is not None) + [(1, -resisting)] * bool(driven.forces)
        return parts + ([] if solution.friction_torque is None else [(2, -solution.friction_torque)])

    def _fill(
        self, solution: CollocationSolution, passed: Array, going: Mask, until: float, forces: list[tuple[int, Array, Array]]
    ) -> None:
        """Fill in the states within a period, and for scenarios that end in it the work up to their end; ``forces``: rows in ``works``,
        forces (q, p, S), and their integrals over the panels (p, S)."""
        rule, mesh = gauss_rule(), solution.mesh
        scenario, place = self._within(passed, going, until)
        time = self.times[place]
        panel = np.clip((passed.take(scenario, axis=1) <= time).sum(axis=0) - 1, 0, len(mesh.kinds) - 1)
        flat = panel * len(going) + scenario  # places among panels and scenarios
        slowness = solution.slowness.reshape(len(rule.nodes), -1).take(flat, axis=1)
        since = time - passed[:-1].ravel().take(flat)
        elapsed = rule.integral(slowness)
        x = place_at(elapsed, since, passed[1:].ravel().take(flat) - passed[:-1].ravel().take(flat))
        along, measure = mesh.travelled(panel, x)
        self.angle[place, scenario] = self.at + self.direction * along
        self.speed[place, scenario] = self.direction * measure / values_and_slopes(elapsed, x)[1]
        ending = np.flatnonzero(place == len(self.times) - 1)
        if not len(ending):
            return
        scenario, panel = scenario[ending], panel[ending]
        for k, force, over_panels in forces:
            before = running_sums(0.0, over_panels)[panel, scenario]
            within = polynomial_values(rule.integral(force[:, panel, scenario] * mesh.measure[:, panel]), x[ending])
            self.works[k, scenario] += before + within

    def _within(self, passed: Array, going: Mask, until: float) -> tuple[Indices, Indices]:
        """Scenarios (m,), and places (m,) among the times, of all m states within a period."""
        first = self.times.searchsorted(passed[0])
        last = np.where(passed[-1] >= until, len(self.times), self.times.searchsorted(passed[-1]))
        counts = np.where(going, last - first, 0)
        scenario = np.repeat(np.arange(len(counts)), counts)
        return scenario, np.arange(len(scenario)) - np.repeat(counts.cumsum() - counts, counts) + first[scenario]

    def energy_error(self) -> Array:
        """(S,) energy errors of those scenarios that are not ``alone``, from their states at start and end."""
        press, count = self.driven.press, len(self.begin)
        angle, speed = np.concatenate([self.angle[[0, -1]], self.speed[[0, -1]]]).reshape(2, 2, count)
        angle, speed = np.where(self.alone, self.first, angle), np.where(self.alone, self.begin, speed)
        motion = motion_through_change_points(press, angle.ravel(), speed.ravel())
        kinetic, potential = (energy.reshape(2, count) for energy in energies(press, motion))
        works = np.concatenate([np.zeros((3, 1, count)), self.works[:, None]], axis=1)
        return np.asarray(energy_error(kinetic + 0.5 * self.driven.inertia * speed**2, potential, *works)[-1])
