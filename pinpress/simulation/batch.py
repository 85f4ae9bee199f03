"""Many scenarios at once: speeds, and the declared parameters of drives, flywheels and loads, as arrays, one value a scenario.

All scenarios of a press run over the same crank angles, so that one period of all of them is solved as one array (see `over_angle`). A
scenario that stops, that depends on more than angle and speed, or whose energy does not balance so, is simulated on its own.
"""

import time as clock
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.arrays import Array
from ..common.errors import PinpressError, SimulationError, UnknownScenarioError, shown
from ..common.gauss import gauss_rule, polynomial_values
from ..common.results import Tabular
from ..common.scenario_fields import lengths
from ..kinematics.motion import carried
from ..loads.caller_laws import LawError
from . import collocation
from .angle_solver import MOST_PERIODS, drive_torque, nearly_at_rest, place_at, too_long
from .collocation import CollocationSolution, cuts, interpolate_onto, panel_integrals, stopping_panels
from .driven_press import DrivenPress, GeneralizedForce
from .mesh import Indices, build_mesh, mesh_borders
from .reduced_model import COORDINATES, INERTIA, energies, tabulated
from .run import energy_error

Mask = NDArray[np.bool_]

AT_ONCE = 128  # scenarios in one array: what is in flight stays in the cache
MOST_KEPT = 24  # panels more than the table's, that are taken over into the next period
MOST_CUTS = 12  # rounds of cutting panels; scenarios that need more are run alone


@dataclass(frozen=True, eq=False, repr=False)
class RunBatch(Tabular):
    """S simulated scenarios of a press, n states each at the same times. Arrays are read-only; ``runs[k]`` is scenario k as a `Run`.

    Attributes:
        time: (n,) [s].
        crank_angle, crank_speed: (n, S) [rad, rad/s]. Of one that stalls: at rest where it did.
        drive_work, load_work: (S,) over the whole run [J].
        energy_error: (S,) as of `Stats`, from the states at start and end.
        errors: (S,) why a scenario stalled or could not go on, None of all others.
        wall_time: of the whole call [s].
    """

    time: Array
    crank_angle: Array
    crank_speed: Array
    drive_work: Array
    load_work: Array
    energy_error: Array
    errors: tuple[SimulationError | None, ...]
    wall_time: float
    _alone: Callable[[int], Any]
    _driven: DrivenPress

    @cached_property
    def slide_position(self) -> Array | None:
        """(n, S) along the guide's axis [m]; None where there is no slide."""
        press = self._driven.press
        if press.slide is None:
            return None
        position: Array = tabulated(press).at(self.crank_angle)[0][COORDINATES].copy()
        position.setflags(write=False)
        return position

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

    def __getitem__(self, k: int) -> Any:
        """Scenario k, simulated once more with all that a `Run` has. Raises what stopped it."""
        if isinstance(k, bool | np.timedelta64) or not isinstance(k, int | np.integer) or not -len(self) <= k < len(self):
            raise UnknownScenarioError(k, len(self))
        return self._alone(int(k) % len(self))

    def __iter__(self) -> Iterator[Any]:
        """The runs one after the other. Raises what stopped one."""
        return (self[k] for k in range(len(self)))

    @property
    def title(self) -> str:
        stalled = sum(error is not None for error in self.errors)
        said = f", {stalled} stalled" if stalled else ""
        return f"RunBatch of {self._driven.press.name}: {len(self)} scenarios, {len(self.time)} states each, {self.time[-1]:.6g} s{said}"


def count(speed: Any, angle: Any, drive: Any, flywheel: Any, loads: Any) -> int | None:
    """Number of scenarios, None where nothing is an array.

    Raises:
        PinpressError: arrays of different lengths; several crank angles to start from.
    """
    if not _is_number(angle):
        raise PinpressError("angle is an array: scenarios start from the same crank angle; give one number [rad]")
    found = {} if _is_number(speed) else {"speed": _of_speed(speed)}
    for item in (drive, flywheel, *(loads if isinstance(loads, Sequence) else ())):
        found |= lengths(item)
    if len(set(found.values())) > 1:
        raise PinpressError(f"arrays for different numbers of scenarios: {', '.join(f'{name} {size}' for name, size in found.items())}")
    return next(iter(found.values()), None)


def _is_number(value: Any) -> bool:
    """Whether a value is not an array, whatever else it may be."""
    return isinstance(value, str) or not hasattr(value, "__len__") or (isinstance(value, np.ndarray) and value.ndim == 0)


def _of_speed(speed: Any) -> int:
    try:
        array = np.array(speed)
    except ValueError:
        array = np.array("x")
    if array.ndim != 1 or not array.size or array.dtype.kind not in "iuf":
        raise PinpressError(f"speed is {shown(speed)}: give one number, or (S,) of them [rad/s]")
    return len(array)


class BatchSolver:
    """Scenarios of one direction of travel, that are solved as one array; filled period by period."""

    def __init__(self, driven: DrivenPress, angle: float, speed: Array, times: Array) -> None:
        """``speed`` (S,) at the start, none of them zero; ``times`` (n,) of the states to be returned."""
        self.driven, self.times = driven, times
        self.direction = 1 if speed[0] > 0 else -1
        self.first, self.begin = angle, speed
        self.angle, self.speed = np.empty((len(times), len(speed))), np.empty((len(times), len(speed)))
        self.works = np.zeros((2, len(speed)))
        self.alone = np.zeros(len(speed), dtype=bool)
        self.before: CollocationSolution | None = None
        self.anchor = self.at = angle  # where periods begin: in the equation, and counted on
        self.clock = np.zeros(len(speed))
        self.energy = 0.5 * (driven.model.at(np.array([angle]))[0][INERTIA, 0] + driven.inertia) * speed**2

    def run(self, tolerance: float) -> None:
        """Run all to the last of the times, or mark them as ``alone``."""
        until = float(self.times[-1])
        if self.driven.timed or not np.all(self.energy > 0) or any(_sticks(force) for force in self.driven.forces):
            self.alone[:] = True
            return
        periods = 0
        while (going := ~self.alone & (self.clock < until)).any():
            periods += 1
            if periods > MOST_PERIODS:
                raise too_long(float(self.clock.max()), self.at)
            extent = self.driven.model.period
            if extent is None:
                self.alone |= going
                return
            try:
                solution, passed = self._period(extent, going, until, tolerance)
            except LawError as error:
                raise error.within(float(self.clock[going].min()), self.at) from error.__cause__
            self.alone |= going & self._beside_rest(solution, passed, until)
            going &= ~self.alone
            parts = self._parts(solution)
            self._read(solution, passed, going, until, parts)
            through = going & (passed[-1] < until)
            for k, part in parts:
                self.works[k] += np.where(through, panel_integrals(solution, part).sum(axis=0), 0.0)
            self.before = solution if len(solution.mesh.kinds) < len(self.driven.model.borders) + MOST_KEPT else None
            self.clock = np.where(going, passed[-1], self.clock)
            self.energy = np.where(going, solution.ends[-1], self.energy)
            self.at = self.anchor + self.direction * periods * extent

    def _period(self, extent: float, going: Mask, until: float, tolerance: float) -> tuple[CollocationSolution, Array]:
        """The period solved well enough for all that are ``going``, and the times (p + 1, S) at its borders."""
        driven, guess = self.driven, None
        if self.before is not None:
            mesh, guess = self.before.mesh, self.before.energy
        else:
            ends = mesh_borders(driven, self.anchor, self.direction, extent)
            mesh = build_mesh(driven, self.anchor, self.direction, ends)
        for _ in range(MOST_CUTS):
            solution = collocation.solve(driven, mesh, self.energy, guess)
            passed = np.concatenate([self.clock[None], panel_integrals(solution, 1 / solution.speed)]).cumsum(axis=0)
            stopping = stopping_panels(solution)
            # what comes after the end of the run does not matter
            self.alone |= going & (stopping & (passed[:-1] < until)).any(axis=0)
            which = np.flatnonzero(going & ~self.alone)
            if not len(which):
                return solution, passed
            upto = int((passed[:-1, which] < until).any(axis=1).sum())
            coarse = cuts(solution, upto, tolerance, which=which)
            if not len(coarse):
                return solution, passed
            ends = np.sort(np.concatenate([mesh.borders, coarse]))
            mesh = build_mesh(driven, self.anchor, self.direction, ends)
            guess = interpolate_onto(solution, mesh)
        self.alone |= going
        return solution, passed

    def _beside_rest(self, solution: CollocationSolution, passed: Array, until: float) -> Mask:
        """Scenarios (S,) that come nearly to rest: whether that is an unstable one is seen when they are run alone."""
        span = self.driven.model.potential_range
        return np.asarray((nearly_at_rest(solution.energy, solution.force, span) & (passed[:-1] < until)).any(axis=(0, 1)))

    def _read(self, solution: CollocationSolution, passed: Array, going: Mask, until: float, parts: "list[tuple[int, Array]]") -> None:
        """Fill in the states within a period."""
        r, mesh = gauss_rule(), solution.mesh
        first = self.times.searchsorted(passed[0])
        last = np.where(passed[-1] >= until, len(self.times), self.times.searchsorted(passed[-1]))
        counts = np.where(going, last - first, 0)
        scenario = np.repeat(np.arange(len(counts)), counts)
        place = np.arange(len(scenario)) - np.repeat(counts.cumsum() - counts, counts) + first[scenario]
        time = self.times[place]
        panel = np.clip((passed[:, scenario] <= time).sum(axis=0) - 1, 0, len(mesh.kinds) - 1)
        slowness = (mesh.measure[:, :, None] / solution.speed)[:, panel, scenario]
        since = time - passed[panel, scenario]
        x = place_at(r.integral(slowness), since, passed[panel + 1, scenario] - passed[panel, scenario])
        along, measure = mesh.travelled(panel, x)
        self.angle[place, scenario] = self.at + self.direction * along
        self.speed[place, scenario] = self.direction * measure / polynomial_values(r.polynomial(slowness), x)
        # of those that end here, the work up to the end
        ending = np.flatnonzero(place == len(self.times) - 1)
        of, at = scenario[ending], panel[ending]
        for k, part in parts:
            before = np.concatenate([np.zeros((1, len(going))), panel_integrals(solution, part).cumsum(axis=0)])[at, of]
            within = polynomial_values(r.integral((part * mesh.measure[:, :, None])[:, at, of]), x[ending])
            self.works[k, of] += before + within

    def _parts(self, solution: CollocationSolution) -> "list[tuple[int, Array]]":
        """Forces of the drive along the travel, and of the loads against it, where there are any; each with its row in ``works``."""
        driven = self.driven
        parts = [(0, drive_torque(driven.drive, solution))] if driven.drive is not None else []
        return parts + ([(1, -solution.resisting)] if driven.forces else [])

    def energy_error(self) -> Array:
        """(S,) of those that are not ``alone``, from their states at start and end."""
        press, count = self.driven.press, len(self.begin)
        at, speed = np.concatenate([self.angle[[0, -1]], self.speed[[0, -1]]]).reshape(2, 2, count)
        at, speed = np.where(self.alone, self.first, at), np.where(self.alone, self.begin, speed)
        motion = carried(press, at.ravel(), speed.ravel())
        kinetic, potential = (energy.reshape(2, count) for energy in energies(press, motion))
        driven, taken = np.concatenate([np.zeros((2, 1, count)), self.works[:, None]], axis=1)
        found: Array = energy_error(kinetic + 0.5 * self.driven.inertia * speed**2, potential, driven, taken, np.zeros_like(taken))[-1]
        return found


def _sticks(force: GeneralizedForce) -> bool:
    """Whether a force is a contact with a damper: where it is lost differs between scenarios."""
    for interval in force.rising + force.falling:
        if interval.one_sided:
            height = interval.upper if np.isfinite(interval.upper) else 0.0
            if np.any(interval.force(height, 1.0) != interval.force(height, 2.0)):
                return True
    return False


def simulate(
    speed: Array,
    angle: float,
    times: Array,
    tolerance: float,
    driven: Callable[[Indices], DrivenPress],
    alone: Callable[..., Any],
    allowed: float,
) -> RunBatch:
    """Run S scenarios.

    Args:
        speed: (S,) at the start [rad/s]. times: (n,) of the states [s].
        driven: the press of the scenarios with these indices, as one array.
        alone: the `Run` of one scenario, with these n states; or up to a time.
        allowed: energy error from which a scenario is run alone, with finer panels of its own.
    """
    began, count = clock.perf_counter(), len(speed)
    angles, speeds, works = np.empty((len(times), count)), np.empty((len(times), count)), np.zeros((2, count))
    errors: list[SimulationError | None] = [None] * count
    missing = np.zeros(count)
    left = list(np.flatnonzero(speed == 0))
    for direction in (1, -1):
        ones = np.flatnonzero(np.sign(speed) == direction)
        for start in range(0, len(ones), AT_ONCE):
            some = ones[start : start + AT_ONCE]
            together = BatchSolver(driven(some), angle, speed[some], times)
            together.run(tolerance)
            missing[some] = found = together.energy_error()
            together.alone |= ~(found <= allowed)
            angles[:, some], speeds[:, some], works[:, some] = together.angle, together.speed, together.works
            left += list(some[together.alone])
    for k in map(int, left):
        try:
            run = alone(k)
        except SimulationError as error:
            errors[k] = error
            angles[:, k], speeds[:, k], works[:, k], missing[k] = _up_to(error, angle, speed[k], times, partial(alone, k))
            continue
        angles[:, k], speeds[:, k], works[:, k] = run.crank_angle, run.crank_speed, (run.drive_work[-1], run.load_work[-1])
        missing[k] = run.stats.energy_error
    for array in (angles, speeds, works, missing):
        array.setflags(write=False)
    took = clock.perf_counter() - began
    return RunBatch(times, angles, speeds, works[0], works[1], missing, tuple(errors), took, alone, driven(np.arange(1)))


def _up_to(
    error: SimulationError, angle: float, speed: float, times: Array, alone: Callable[[float], Any]
) -> tuple[Array, Array, tuple[float, float], float]:
    """Angles and speeds (n,) of a scenario that stalls, at rest from there on, the works of its drive and loads and the energy error up to
    there."""
    end = 0.0 if error.time is None else error.time * (1 - 1e-9)
    stopped = angle if error.crank_angle is None else error.crank_angle
    angles, speeds, works = np.full(len(times), stopped), np.zeros(len(times)), (0.0, 0.0)
    missing = 0.0
    before = times < end
    if before.any():
        try:
            run = alone(end)
        except SimulationError:  # it does not even get there: at rest from the start
            return np.full(len(times), angle), speeds, works, missing
        sample = run.trajectory.at(times[before])
        angles[before], speeds[before] = sample.position[0], sample.speed[0]
        works, missing = (float(run.drive_work[-1]), float(run.load_work[-1])), run.stats.energy_error
    return angles, speeds, works, missing
