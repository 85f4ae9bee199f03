"""Error against run time of our engines and methods for a press.

Every error is against a reference on which two independent methods agree; `Group.certificate` says how closely. Run times can be compared
because contestants take turns, so that other work of the machine slows all of them.
"""

from __future__ import annotations

import gc
import itertools
import math
import os
import platform
import textwrap
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pinocchio as pin

from ..common import tables
from ..common.arguments import LARGEST, SMALLEST, number, positive, typed, whole_number
from ..common.errors import PinpressError, shown
from ..common.quantities import RPM, Array
from ..common.results import Record, Records, Tabular
from ..common.tables import Column
from ..drives.transmission import Flywheel
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.cycle import MOST_POINTS, cycle, motion_through_change_points
from ..linkage.linkage import Linkage
from ..linkage.memo import keep_all_but
from ..plots.style import COLOURS, GREY, SMALL, grid, panels, plain
from ..simulation.reduced_model import reduced_model_of
from ..simulation.run import Run
from ..simulation.simulate import simulate
from ..simulation.solvers import LEAST_TOLERANCE
from .scenes import FREE_RUN, SCENES, SPEED_LAW, Scene, build_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INVERSE_DYNAMICS = "inverse dynamics"
METHODS = ("reduced", "implicit", "constraint")
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
STEPS = (40, 80, 160, 320, 640)  # steps of the classical Runge-Kutta method per turn
STATES = 121  # states of the reference in which forces have their peaks; the first one, in which a stiff drive gives a blow, does not count
UNSTABLE = f"fixed steps are left out in the {SPEED_LAW}: they are stable only below the time in which it forgets"
# Processor time of this thread: neither other programs nor waiting threads of BLAS count. Some systems know it to 16 ms only.
CLOCK = time.thread_time if time.get_clock_info("thread_time").resolution < 1e-6 else time.perf_counter
WIDTH = 98  # longest line of the text
MARKERS = "osD^vP*X<>dhp1234x+"

# ------------------------------------------------------------------------------------------------------------------------------- results


@dataclass(frozen=True, repr=False)
class Measurement(Record, units={"seconds": "s", "loop_gap": "m"}):
    """One method with one setting. A quantity that it does not have is None.

    Attributes:
        group: name of the group, "inverse dynamics" or a scene.
        method: "plane", "reduced", ...
        setting: the setting as text.
        number: the setting as a number: a tolerance, a step [s] or a number of crank angles.
        seconds: least run time; `Group.time` says of what [s].
        error: largest error; `Group.error` says of what.
        force_error: largest error of a bearing force, as a share of the largest peak of any [-].
        loop_gap: largest distance between the two sides of a loop [m].
        energy_error: error of the power balance, as a share of the peak power, or of the energy at the end, as a share of the kinetic
            energy at the start [-].
        evaluations: number of crank angles, or of evaluations of the equation of motion.
        problem: message of the method if it has no error; else empty.
    """

    group: str
    method: str
    setting: str
    number: float | None
    seconds: float
    error: float | None
    force_error: float | None = None
    loop_gap: float | None = None
    energy_error: float | None = None
    evaluations: int | None = None
    problem: str = ""


@dataclass(frozen=True)
class Group:
    """What is computed in a group of measurements.

    Attributes:
        words: the scene as text; empty for a turn at constant speed.
        time: what the run time is of.
        error: what the error is of.
        certificate: difference of the two independent methods whose agreement makes the reference, in the unit of the error.
        certified_by: names of these two methods.
        drawn: "error", or "force_error" if the bearing forces are the error that counts.
    """

    words: str
    time: str
    error: str
    certificate: float
    certified_by: str
    drawn: str = "error"


@dataclass(frozen=True, repr=False)
class WorkPrecision(Tabular):
    """Error against run time of everything that is offered for a press, measured in one run.

    Attributes:
        press_name: name of the press.
        scene: what was computed, as text.
        machine: the computer, as text.
        groups: name of a group -> what is computed in it.
        measurements: all measurements, group by group.
        skipped: a line for each method or scene that could not be measured, with the reason.
    """

    press_name: str
    scene: str
    machine: str
    groups: Mapping[str, Group]
    measurements: Records[Measurement]
    skipped: tuple[str, ...]

    def of(self, group: str, method: str | None = None) -> Records[Measurement]:
        """The measurements of a group, or of one method in it."""
        return Records(Measurement, (m for m in self.measurements if m.group == group and method in (None, m.method)))

    def fastest(self, group: str, error: float) -> Records[Measurement]:
        """The fastest measurement of each method of a group that reaches an error, the fastest first."""
        best: dict[str, Measurement] = {}
        for m in sorted(self.of(group), key=lambda m: m.seconds):
            if m.error is not None and m.error <= error:
                best.setdefault(m.method, m)
        return Records(Measurement, best.values())

    @property
    def title(self) -> str:
        fastest = min(measurement.seconds for measurement in self.measurements)
        return f"WorkPrecision of {self.press_name}: {len(self.measurements)} measurements, {self.scene}, the fastest {fastest:.4g} s"

    def columns(self) -> dict[str, Column]:
        """The measurements as columns, None if there is no value."""
        return self.measurements.columns()

    def __str__(self) -> str:
        lines = [f"{self.press_name}: {self.scene}", self.machine]
        for name, group in self.groups.items():
            lines += ["", f"{name[0].upper()}{name[1:]}: time {group.time}; error {group.error}"]
            lines += [f"  {group.words}"] if group.words else []
            lines += [f"  reference: {group.certified_by} agree to {group.certificate:.1e}", *_table(self.of(name))]
        lines += ["", *self.skipped] if self.skipped else []
        return "\n".join(part for line in lines for part in (_wrapped(line) if len(line) > WIDTH else [line]))


def _wrapped(line: str) -> list[str]:
    return textwrap.wrap(line, WIDTH, subsequent_indent="  " + " " * (len(line) - len(line.lstrip())))


def _table(rows: Sequence[Measurement]) -> list[str]:
    """A table of a group: a method a line if all have one setting, else a method and below it a setting a line."""
    heads = ("", "time [ms]", "error", "force error", "loop gap [m]", "energy error", "evaluations")
    alike = len({row.setting for row in rows}) == 1
    cells = [(rows[0].setting if alike else "", *heads[1:]), *(_cells(row, row.method if alike else f"  {row.setting}") for row in rows)]
    kept = [k for k in range(len(heads)) if k < 3 or any(line[k] for line in cells[1:])]
    first, *lines = tables.fitted([[line[k] for k in kept] for line in cells])
    listed = [first.rstrip()]
    for k, (row, line) in enumerate(zip(rows, lines, strict=True)):
        if not alike and (k == 0 or row.method != rows[k - 1].method):
            listed.append(f"  {row.method}")
        listed.append(f"{line.rstrip()}  {row.problem}".rstrip())
    return listed


def _cells(row: Measurement, name: str) -> tuple[str, ...]:
    errors = ("" if value is None else f"{value:.1e}" for value in (row.error, row.force_error, row.loop_gap, row.energy_error))
    return name, f"{1e3 * row.seconds:.4g}", *errors, "" if row.evaluations is None else str(row.evaluations)


# ------------------------------------------------------------------------------------------------------------------------------- compare


@typed
def compare(
    press: Linkage,
    speed: float,
    *,
    flywheel: Flywheel | None = None,
    duration: float | None = None,
    points: int = 360,
    repeats: int = 3,
    scenes: Sequence[str] = SCENES,
    progress: Callable[[float], None] | None = None,
) -> WorkPrecision:
    """Measure all engines and methods for a press.

    It measures inverse dynamics of a period at constant speed by all engines, and simulations by all methods over tolerances and fixed
    steps. The simulations are a free run from crank angle 0 with weights; a start by a clutch under a motor, and a blank; a stiff elastic
    die under a motor; and a drive that holds the speed so hard that the equation is stiff. Run times are the least of several rounds in
    which all take turns.

    Args:
        press: a linkage with one driver.
        speed: speed of the crank, in the period and at the start of the runs [rad/s].
        flywheel: flywheel of the runs; by default with 4 times the largest reduced inertia of the linkage.
        duration: length of the runs; by default the time of two turns at that speed [s].
        points: number of crank angles in the period.
        repeats: number of rounds of timing.
        scenes: scenes to simulate, among "free run", "clutch and blanking", "elastic die" and "stiff speed law".
        progress: function called with the share done, 0 to 1.

    Raises:
        PinpressError: an argument is not as described, or the linkage has several drivers.
        SingularityError: the crank does not turn fully.
        SimulationError: a run does not reach its end.
    """
    speed = _checked(press, speed, points, repeats, scenes)
    inertia = flywheel_inertia(press, flywheel)
    lasting = 2 * 2 * math.pi / abs(speed) if duration is None else positive("duration", duration, "s")
    contests, skipped = [inverse_dynamics_contest(press, speed, points)], []
    for name in (scene for scene in SCENES if scene in scenes):
        try:
            scene = build_scene(press, name, speed, inertia, lasting)
        except PinpressError as error:
            skipped.append(f"{name} is skipped: {error}")
            continue
        contests.append(simulation_contest(press, scene))
        skipped += [UNSTABLE] if name == SPEED_LAW else []
    described = f"{speed / RPM:g} r/min; runs of {lasting:.4g} s with a flywheel of {inertia:.4g} kg m2"
    return hold(press, described, contests, skipped, repeats, progress)


def hold(
    press: Linkage,
    scene: str,
    contests: Sequence[Contest],
    skipped: Sequence[str],
    repeats: int,
    progress: Callable[[float], None] | None = None,
) -> WorkPrecision:
    """Hold contests: judge every contestant once and time all of a contest in turn."""
    total, done = (repeats + 1) * sum(len(contest.contestants) for contest in contests), 0

    def one_done() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done / total)

    versions = f"Python {platform.python_version()}, NumPy {np.__version__}, Pinocchio {pin.__version__}"
    machine = f"{versions}; {platform.system()} {platform.machine()}, {os.cpu_count()} cores"
    rows = [m for contest in contests for m in measure(contest.contestants, repeats, one_done)]
    groups = {contest.name: contest.group for contest in contests if contest.contestants}
    return WorkPrecision(press.name, scene, machine, groups, Records(Measurement, rows), tuple(skipped))


def _checked(press: Linkage, speed: object, points: object, repeats: object, scenes: Sequence[str]) -> float:
    """The speed as a number, after all arguments are checked [rad/s]."""
    press.refuse_several_drivers("accuracy is measured of a linkage with one")
    press.refuse_sliding_driver("accuracy is measured of a crank that turns under a flywheel")
    turning = number("speed", speed)
    if not SMALLEST <= abs(turning) <= LARGEST:
        raise PinpressError(f"speed is {turning:g}: give the speed of the crank [rad/s], e.g. 70 * pinpress.RPM")
    whole_number("points", points, 2, MOST_POINTS)
    whole_number("repeats", repeats, 1, 1000)
    if isinstance(scenes, str) or not all(isinstance(scene, str) and scene in SCENES for scene in scenes):
        raise PinpressError(f"scenes are {shown(scenes)}: give some of {', '.join(map(repr, SCENES))}")
    return turning


def flywheel_inertia(press: Linkage, flywheel: Flywheel | None = None) -> float:
    """Moment of inertia of the flywheel of the runs [kg m2]; four times the linkage's own keeps it turning."""
    if flywheel is None:
        table = reduced_model_of(press)
        return 4.0 * float(table.at(table.borders)[0][0].max())
    return number("the flywheel's inertia", flywheel.inertia)


# ------------------------------------------------------------------------------------------------------------------------------ contests


class Errors(NamedTuple):
    """Errors of an answer, as in `Measurement`."""

    error: float
    force_error: float | None = None
    loop_gap: float | None = None
    energy_error: float | None = None
    evaluations: int | None = None


@dataclass(frozen=True)
class Contestant:
    """A method with a setting: work that is timed, and the errors of its answer. A `PinpressError` raised by either is an answer too.

    Attributes:
        group: name of the group.
        method: name of the method.
        setting: the setting as text.
        number: the setting as a number; None if it has none.
        work: function that is timed.
        errors: function that judges what the work returns.
    """

    group: str
    method: str
    setting: str
    number: float | None
    work: Callable[[], Any]
    errors: Callable[[Any], Errors]


@dataclass(frozen=True)
class Contest:
    """Contestants of a group, and what is computed in it."""

    name: str
    group: Group
    contestants: tuple[Contestant, ...]


def measure(contestants: Sequence[Contestant], repeats: int, done: Callable[[], None] = lambda: None) -> list[Measurement]:
    """Judge every contestant once and time all in turn; ``done`` is called after every piece of work."""
    judged: list[tuple[Contestant, Errors, str]] = []
    for contestant in contestants:
        try:
            judged.append((contestant, contestant.errors(contestant.work()), ""))
        except PinpressError as error:
            judged.append((contestant, Errors(math.nan), str(error).split(":")[0]))
        done()
    seconds = least_seconds([_catch_errors(contestant.work) for contestant in contestants], repeats, done)
    return [_measurement(*each, least) for each, least in zip(judged, seconds, strict=True)]


def least_seconds(
    works: Sequence[Callable[[], object]],
    repeats: int,
    done: Callable[[], None] = lambda: None,
    clock: Callable[[], float] = CLOCK,
) -> list[float]:
    """Least time of a call of each piece of work [s].

    Args:
        works: functions without arguments, called in turn.
        repeats: number of rounds, without the garbage collector.
        done: function called after every turn.
        clock: function that gives the time [s].
    """
    best, spent = [float("inf")] * len(works), [0.0] * len(works)
    collecting = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        for _ in range(repeats):
            for k, work in enumerate(works):
                end = clock() + 0.02  # a turn lasts longer than a call: the first one does not find data and code in the cache
                while spent[k] < 2.0:  # whoever has been timed so long gets no more turns
                    start = clock()
                    work()
                    now = clock()
                    best[k], spent[k] = min(best[k], now - start), spent[k] + now - start
                    if now > end:
                        break
                done()
    finally:
        if collecting:
            gc.enable()
    return best


def _catch_errors(work: Callable[[], Any]) -> Callable[[], None]:
    def caught() -> None:
        with suppress(PinpressError):
            work()

    return caught


def _measurement(contestant: Contestant, errors: Errors, problem: str, seconds: float) -> Measurement:
    """A measurement; an error that is not finite becomes a problem."""
    error, force, gap, energy, evaluations = (None if value is None or not math.isfinite(value) else value for value in errors)
    return Measurement(
        group=contestant.group,
        method=contestant.method,
        setting=contestant.setting,
        number=contestant.number,
        seconds=seconds,
        error=error,
        force_error=force,
        loop_gap=gap,
        energy_error=None if energy is None else abs(energy),
        evaluations=None if evaluations is None else int(evaluations),
        problem=problem or ("not finite" if error is None else ""),
    )


def force_error(forces: Mapping[str, Array], expected: Reactions, peak: float) -> float:
    """Largest distance of a bearing's force (n, 3) from the expected one, as a share of a peak force [-]."""
    return max(float(np.linalg.norm(forces[name] - force, axis=1).max()) for name, force in expected.bearing_force.items()) / peak


def peak_force(forces: Mapping[str, Array]) -> float:
    """Largest force of any bearing (n, 3) in any state [N]; 1 if there is none."""
    return max(float(np.linalg.norm(force, axis=1).max()) for force in forces.values()) or 1.0


def peak_of(values: Array) -> float:
    """The largest magnitude among values; 1 if all are zero, as no error can be relative to zero."""
    return float(np.abs(values).max()) or 1.0


# --------------------------------------------------------------------------------------------------------- a turn, from angles to forces


def inverse_dynamics_contest(press: Linkage, speed: float, points: int) -> Contest:
    """All engines over a turn.

    Pinocchio's engine judges the others, and the fastest one judges it: in the plane they share no equation. The torque of a press in space
    is judged by forward dynamics, which gives the accelerations back under it.
    """
    engines, planar = press.engines, press.engines[0] == "plane"
    answers = {engine: solve_turn(press, speed, points, engine) for engine in engines}
    spatial, first = answers["pinocchio"], answers[engines[0]]
    peak_torque, largest_force = peak_of(spatial.driving_torque), peak_force(spatial.bearing_force)
    returned = {} if planar else {engine: _accelerations_off(press, answer) for engine, answer in answers.items()}

    def errors(judge: Reactions, answer: Reactions) -> Errors:
        torque = float(np.abs(answer.driving_torque - judge.driving_torque).max()) / peak_torque
        return Errors(
            torque if planar else returned[answer.engine],
            force_error(answer.bearing_force, judge, largest_force),
            float(answer.motion.closure_error.max()),
            float(np.abs(answer.power_residual).max()),
            points,
        )

    entries = [
        Contestant(
            INVERSE_DYNAMICS,
            engine,
            f"{points} crank angles",
            points,
            _solve_other_turns(press, speed, points, engine),
            partial(errors, first if answer is spatial else spatial),
        )
        for engine, answer in answers.items()
    ]
    agreement = errors(spatial, first)
    certificate = max(agreement.error, agreement.force_error or 0.0) if planar else max(returned.values())
    certified_by = "engines plane and pinocchio" if planar else "torque and forward dynamics under it"
    group = Group("", "of a turn", "of the driving torque, of its peak", certificate, certified_by)
    return Contest(INVERSE_DYNAMICS, group, tuple(entries))


def solve_turn(press: Linkage, speed: float, points: int, engine: str) -> Reactions:
    """Reactions over a turn by an engine."""
    return inverse_dynamics(press, cycle(press, speed=speed, points=points, engine=engine), engine=engine)


def _solve_other_turns(press: Linkage, speed: float, points: int, engine: str) -> Callable[[], Reactions]:
    """A function that solves ``points`` crank angles when it is first called, and then a few more, another number each time, so that memory
    is not laid out for one number alone."""
    counts = itertools.chain([points], itertools.cycle(range(points + 1, points + 9)))
    return lambda: solve_turn(press, speed, next(counts), engine)


def _accelerations_off(press: Linkage, reactions: Reactions) -> float:
    """Largest difference of the accelerations that forward dynamics gives under the driving torque, divided by their peak [-]."""
    dynamics, motion, crank = press.forward_dynamics(np.zeros(press.model.nv)), reactions.motion, press.driver_indices[0]
    sample = np.arange(0, len(motion.v), max(1, len(motion.v) // 48))
    efforts = np.zeros((len(sample), press.model.nv))
    efforts[:, crank] = reactions.driving_torque[sample]
    states = zip(motion.joint_position[sample].copy(), motion.v[sample].copy(), efforts, strict=True)
    accelerations = np.array([dynamics.acceleration(*state) for state in states])
    return float(np.abs(accelerations - motion.a[sample]).max()) / peak_of(motion.a[sample])


# ------------------------------------------------------------------------------------------------------------------------------ runs


class EndOfRun(NamedTuple):
    """A run and the reactions in its last state."""

    run: Run
    last: Reactions


@dataclass(frozen=True, eq=False)
class Reference:
    """The reference end of a scene, by which all runs are judged. No error counts as less than the difference of its two methods.

    Attributes:
        last: reactions in the last state.
        angle: crank angle in the last state, unwrapped [rad].
        peak: largest force of any bearing in the run [N].
        certificate: difference of the two methods' crank angles [rad].
        force_certificate: largest difference of their bearing forces, divided by the peak [-].
    """

    last: Reactions
    angle: float
    peak: float
    certificate: float
    force_certificate: float

    def judge(self, end: EndOfRun) -> Errors:
        """Errors of a run."""
        stats = end.run.stats
        angle, force = self.errors(float(end.run.crank_angle[-1]), force_error(end.last.bearing_force, self.last, self.peak))
        return Errors(angle, force, stats.closure_error, stats.energy_error, stats.evaluations)

    def errors(self, angle: float, force: float) -> tuple[float, float]:
        """Errors of a crank angle [rad] and of forces, of which `force_error` is known."""
        return max(abs(angle - self.angle), self.certificate), max(force, self.force_certificate)


def reference_of(press: Linkage, scene: Scene) -> Reference:
    """A run of all joints with the least tolerance, which the reduced equation must confirm: they share no equation of motion."""
    truth, other = (end_of_run(press, scene, method, tolerance=LEAST_TOLERANCE) for method in scene.certifying)
    whole = inverse_dynamics(press, run_scene(press, scene, scene.certifying[1], points=STATES))
    peak = peak_force({name: force[1:] for name, force in whole.bearing_force.items()})
    angle = float(truth.run.crank_angle[-1])
    certificate = max(abs(float(other.run.crank_angle[-1]) - angle), float(np.spacing(abs(angle))))
    return Reference(truth.last, angle, peak, certificate, force_error(other.last.bearing_force, truth.last, peak))


def simulation_contest(press: Linkage, scene: Scene, reference: Reference | None = None) -> Contest:
    """All methods over tolerances and fixed steps."""
    reference = reference_of(press, scene) if reference is None else reference
    names = {"constraint": "all joints", "reduced": "the reduced equation", "implicit": "the reduced equation by Radau IIA"}
    group = Group(
        scene.words,
        "of the run and the forces at its end",
        "of the crank angle at its end [rad]",
        reference.certificate,
        " and ".join(names[method] for method in scene.certifying),
        "force_error" if scene.group == SPEED_LAW else "error",  # this drive fixes the crank angle
    )
    entries = (*_adaptive_runs(press, scene, reference), *_fixed_step_runs(press, scene, reference))
    return Contest(scene.group, group, entries)


def _adaptive_runs(press: Linkage, scene: Scene, reference: Reference) -> Iterator[Contestant]:
    """Runs with steps chosen by their error."""

    def toleranced(method: str, tolerance: float, setting: str) -> Contestant:
        work = partial(end_of_run, press, scene, method, tolerance=tolerance)
        return Contestant(scene.group, method, setting, tolerance, work, reference.judge)

    for method in METHODS:
        if method == "reduced" and _knows_no_tolerance(press, scene):
            yield toleranced(method, 1e-11, "any tolerance")
        else:
            yield from (toleranced(method, tolerance, f"tolerance {tolerance:.0e}") for tolerance in TOLERANCES)
    if scene.group == FREE_RUN:
        method, setting = "reduced, its table anew", "tolerance 1e-11"
        yield Contestant(scene.group, method, setting, 1e-11, lambda: end_of_run(without_table(press), scene, "reduced"), reference.judge)


def _fixed_step_runs(press: Linkage, scene: Scene, reference: Reference) -> Iterator[Contestant]:
    """Runs with fixed steps, which are stable in all scenes except the one with a stiff law."""
    if scene.group == SPEED_LAW:
        return
    for method in ("reduced", "constraint"):
        for step in (scene.turn / count for count in STEPS):
            work = partial(end_of_run, press, scene, method, step=step)
            yield Contestant(scene.group, f"{method}, Runge-Kutta 4", f"step {1e3 * step:.3g} ms", step, work, reference.judge)


def _knows_no_tolerance(press: Linkage, scene: Scene) -> bool:
    """Whether runs by the reduced equation do not depend on their tolerance, so that one row stands for all."""
    loose, tight = (run_scene(press, scene, "reduced", points=2, tolerance=tolerance) for tolerance in (TOLERANCES[0], TOLERANCES[-1]))
    return loose.crank_angle[-1] == tight.crank_angle[-1] and loose.stats.evaluations == tight.stats.evaluations


def end_of_run(press: Linkage, scene: Scene, method: str, **how: float) -> EndOfRun:
    """A run of a scene by a method, and the reactions in its last state."""
    run = run_scene(press, scene, method, points=2, **how)
    last = motion_through_change_points(press, run.crank_angle[-1:], run.crank_speed[-1:], run.crank_acceleration[-1:])
    return EndOfRun(run, inverse_dynamics(press, last))


def run_scene(press: Linkage, scene: Scene, method: str, **how: Any) -> Run:
    """A run of a scene by a method."""
    run = simulate(
        press,
        scene.duration,
        speed=scene.speed,
        angle=scene.angle,
        drive=scene.drive,
        flywheel=scene.flywheel,
        loads=scene.loads,
        method=method,
        clutch=scene.clutch,
        **how,
    )
    assert isinstance(run, Run)
    return run


def without_table(press: Linkage) -> Linkage:
    """The linkage without its reduced table, with everything else that is derived from it."""
    same = replace(press)
    keep_all_but(reduced_model_of, same, press)
    return same


# --------------------------------------------------------------------------------------------------------------------------------- plot


@typed
def plot(measured: WorkPrecision, *, ax: Axes | Iterable[Axes] | None = None) -> Figure:
    """Draw error against run time, a panel for each group.

    The error of a scene is that of the crank angle at its end, or of the bearing forces if `Group.drawn` says so. Errors of torque and
    forces are shares of their peaks. Grey lines show how closely the reference is known.

    Args:
        measured: result of `compare`.
        ax: the caller's axes, as many as groups; by default those of a new figure.

    Raises:
        PinpressError: it is no `WorkPrecision`, Matplotlib is not installed, or ``ax`` are too few or too many.
    """
    count = len(measured.groups)
    looks = _looks(measured)
    rows, columns = -(-count // 2), min(count, 2)

    def laid_out(figure: Figure) -> list[Axes]:
        return [figure.add_subplot(rows, columns, place) for place in range(1, count + 1)]  # an odd number leaves no empty axes

    with panels(ax, count, 2.0 + 6.0 * rows, laid_out) as drawn:
        lines: dict[str, Any] = {}
        for axes, (name, group) in zip(drawn.axes, measured.groups.items(), strict=True):
            for method in dict.fromkeys(m.method for m in measured.of(name)):
                points = [(1e3 * m.seconds, getattr(m, group.drawn)) for m in measured.of(name, method) if getattr(m, group.drawn)]
                if points:
                    line = axes.loglog(*zip(*points, strict=True), markersize=4.0, linewidth=1.0, **looks[method])[0]
                    lines.setdefault(method, line)
            axes.axhline(group.certificate, color=GREY, linewidth=0.8, zorder=0)
            what = "bearing forces" if group.drawn == "force_error" else "the torque" if name == INVERSE_DYNAMICS else "the end"
            _name_axes(axes, name[0].upper() + name[1:], f"error of {what}")
        drawn.legend(list(lines.values()), list(lines), loc="outside upper center", ncols=3)
        if drawn.own:
            plain(drawn.figure.supxlabel(f"{measured.press_name}: {measured.scene}", fontsize=SMALL, color=GREY))
    return drawn.figure


def _looks(measured: WorkPrecision) -> dict[str, dict[str, Any]]:
    """A colour for each family of methods, a marker for each method, and dashes for fixed steps."""
    families: dict[str, str] = {}
    looks: dict[str, dict[str, Any]] = {}
    for method in dict.fromkeys(m.method for m in measured.measurements):
        first = method.split(",")[0].split(" ")[0]
        family = {"plane": "reduced", "space": "reduced", "implicit": "reduced", "elastic": "reduced", "pinocchio": "constraint"}.get(
            first, first
        )
        colour = families.setdefault(family, COLOURS[len(families)] if len(families) < len(COLOURS) else GREY)
        fixed = "Runge-Kutta" in method or "mj_step" in method
        looks[method] = {"color": colour, "marker": MARKERS[len(looks) % len(MARKERS)], "linestyle": (0, (4, 1.5)) if fixed else "-"}
    return looks


def _name_axes(axes: Axes, title: str, upwards: str) -> None:
    from matplotlib.ticker import LogFormatterSciNotation, LogLocator  # optional, and slow to import

    grid(axes, upwards)
    if math.isfinite(axes.xaxis.get_minpos()):  # an axis without measurements has no range for ticks
        axes.xaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))  # within one decade these are named; more names would overlap
        axes.xaxis.set_minor_formatter(LogFormatterSciNotation(minor_thresholds=(1.0, 1.0)))
    axes.margins(x=0.08, y=0.08)
    axes.set_xlabel("time [ms]")
    axes.set_title(title, loc="left")
