"""The task of a best motion, and its solution: rounds for loads that depend on the speed, limits between nodes, and the number of nodes.

A `Task` has checked arguments and the coefficients of the press. A convex program solves the task; further programs keep the limits that
are not convex. Then the drive's torque and power are limited between nodes too, and the nodes are refined.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common import plausibility
from ..common.arguments import expect, in_unit, suitable_numbers, whole_number
from ..common.errors import PinpressError, shown
from ..common.quantities import Array
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..kinematics.cycle import moved
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage
from ..loads.link import Friction, Load
from . import limits as limits_
from .between_nodes import FullMotion, excess_of, full_motion, limits_at_states
from .conic.bounds import bearings_of, contradiction, limit_heights, motion_problem, refuse_heights, refuse_short
from .conic.coefficients import Coefficients, PathGrid, PathMotion, coefficients, feels_speed, load_heights, path_grid, path_marks
from .conic.local_limits import within_local_limits
from .conic.motion_problem import MotionProblem, figures, needed_time
from .conic.never_resting import COARSE, CoarseTurn, NoTurnError, coarse_turn, is_shorter, time_of, turn_in_time, turn_near
from .conic.optimum import NoMotionError, optimum
from .conic.program import Solution
from .drive import ServoDrive
from .limits import Limit
from .motion_optimum import UNITS
from .paths import Path, Turn, legs_of

POINTS, FEWEST_POINTS, MOST_POINTS = 720, 8, 20_000
NODE_ERROR = 1e-3  # largest node error, as a share of the value, if the user does not give the number of nodes
EXCEEDED = 5e-4  # share by which the motion may exceed torque or power between nodes
SETTLED, NEARLY_SETTLED = 1e-8, 1e-5  # smaller relative changes of the value end the rounds: of convex programs, and of others
MOST_ROUNDS, MOST_AMENDED = 30, 5  # rounds for loads that depend on the speed, and for limits between nodes


def make_task(
    press: Linkage,
    drive: ServoDrive,
    loads: Sequence[Load],
    minimise: str | Mapping[str, float],
    time: float | None,
    path: Path | None,
    limits: Sequence[Limit],
    friction: Mapping[str, Friction],
    points: int | None,
) -> Task:
    """The task with checked arguments and the coefficients of the press; arguments and errors as in `best_motion`."""
    expect("drive", drive, ServoDrive, "servo.ServoDrive")
    press.refuse_sliding_driver("servo motions need a crank")
    legs = legs_of(Turn() if path is None else path, press)
    checked = limits_.checked(limits)
    weights = _objective(minimise)
    most = None if time is None else _positive("time", time, "s")
    if most is not None:
        plausibility.stroke_time("time", most)
    count = POINTS if points is None else whole_number("points", points, FEWEST_POINTS, MOST_POINTS)
    _refuse_open(drive, weights, most, checked, legs.dwell, legs.closed)
    refuse_heights(press, checked, dead_centres(press).stroke)
    bearings_of(press, checked)
    marks = path_marks(press, legs, [*load_heights(press, loads), *limit_heights(checked)])

    def at(segments: int, like: PathMotion | None) -> Coefficients:
        return _coefficients(press, path_grid(legs, marks, segments), loads, friction, checked, most, like)

    like = None
    if count >= 64 and ("time" not in weights or any(isinstance(limit, limits_.RmsTorque) for limit in checked)):
        rough = motion_problem(at(count // 4, None), drive, checked, weights if len(weights) == 1 else {"heat": 1.0}, most)
        with contextlib.suppress(PinpressError):  # a rough motion decides at which places the torque is evaluated
            like = PathMotion(rough.coefficients.grid.way_gone, optimum(rough).b)
    return Task(press, loads, friction, Turn() if path is None else path, at(count, like), checked, weights, most)


def _coefficients(
    press: Linkage,
    grid: PathGrid,
    loads: Sequence[Load],
    friction: Mapping[str, Friction],
    limits: Sequence[Limit],
    time: float | None,
    like: PathMotion | None,
) -> Coefficients:
    speed = float(np.abs(grid.step).sum()) / (time - grid.legs.dwell if time else 1.0)
    return coefficients(press, grid, loads, friction, speed, bearings_of(press, limits), like)


def _objective(minimise: object) -> dict[str, float]:
    """Quantity -> its weight in the objective."""
    if isinstance(minimise, str) and minimise in UNITS:
        return {"peak": 1.0, "heat": 0.1} if minimise == "peak" else {minimise: 1.0}  # a peak alone leaves the speed elsewhere open
    if isinstance(minimise, Mapping) and minimise and all(isinstance(name, str) and name in UNITS for name in minimise):
        weights = {name: _positive(f"minimise: weight of {name}", value, "-") for name, value in minimise.items()}
        if set(weights) == {"peak"}:
            raise PinpressError('minimise has only "peak", which does not determine the speed elsewhere: give "heat" a weight too')
        return weights
    raise PinpressError(f'minimise is {shown(minimise)}: give "heat", "time", "energy" or "peak", or a mapping of these names to weights')


def _positive(name: str, value: object, unit: str) -> float:
    expected = f"a positive number [{unit}]"
    return float(suitable_numbers(name, in_unit(name, value, unit), expected, suits=lambda given: (given >= 1e-9) & (given <= 1e9)))


def _refuse_open(
    drive: ServoDrive, wanted: Mapping[str, float], time: float | None, limits: Sequence[Limit], dwell: float, closed: bool
) -> None:
    """Raise PinpressError if nothing limits the time or the speed, or if the time is shorter than rests or the feed window."""
    if time is None and "time" not in wanted:
        raise PinpressError('time is missing: give the time of a cycle [s], e.g. time=60 / 25; or minimise="time"')
    if time is not None and not time > dwell:
        raise PinpressError(f"time is {time:g} s, but the path rests for {dwell:g} s: give a longer time")
    feeding = max((limit.time for limit in limits if isinstance(limit, limits_.FeedWindow)), default=0.0)
    if time is not None and not time > feeding:
        raise PinpressError(f"time is {time:g} s, but the FeedWindow alone takes {feeding:g} s: give a longer time, or a shorter window")
    if time is None and len(wanted) > 1:
        raise PinpressError("time is missing: weights refer to the motion with the least heat within a time; give the time of a cycle [s]")
    if wanted != {"time": 1.0}:
        return
    speeds = limits_.SlideSpeed, limits_.CrankSpeed, limits_.SlideAcceleration, limits_.BearingForce, limits_.FeedWindow
    fast = drive.top_speed or any(isinstance(limit, speeds) for limit in limits)
    if closed and not fast:
        raise PinpressError(
            "nothing limits the speed: a crank that never rests can turn arbitrarily fast with almost no torque; give the drive a"
            " top_speed, or limits=[servo.CrankSpeed(...)], or path=servo.Stop()"
        )
    torques = limits_.RmsTorque, limits_.CrankAcceleration
    if not (fast or drive.peak_torque or drive.power or any(isinstance(limit, torques) for limit in limits)):
        raise PinpressError("nothing limits the speed: give the drive a peak_torque or top_speed, or limits=[servo.RmsTorque(...)]")


@dataclass(frozen=True, eq=False)
class Task:
    """A task of `best_motion`, whose arguments are the attributes, with the coefficients of the press.

    ``proved``: whether several programs tighten the bound. ``turns``: turns on the coarse path, the same for all numbers of nodes.
    ``levels``: number of segments -> coefficients.
    """

    press: Linkage
    loads: Sequence[Load]
    friction: Mapping[str, Friction]
    path: Path
    coefficients: Coefficients
    limits: tuple[Limit, ...]
    wanted: Mapping[str, float]
    time: float | None
    proved: bool = True
    turns: dict[object, CoarseTurn] = field(default_factory=dict)
    levels: dict[int, Coefficients] = field(default_factory=dict)

    def solve(self, drive: ServoDrive, start: Array | None = None) -> TaskSolution:
        """Solve the task with this drive; ``start``: b of a motion near the solution."""
        feels = feels_speed(self.loads, self.friction)
        of_press, value, last = self.coefficients, np.inf, start
        for rounds in range(1, MOST_ROUNDS + 1):
            problem, answer, notes = self._solve_once(of_press, drive, last)
            if not feels:
                return TaskSolution(self, problem, answer, tuple(notes))
            last, change, value = answer.b, abs(answer.value - value), answer.value
            settled = change <= (SETTLED if problem.time == self.time else NEARLY_SETTLED) * abs(value)
            of_press = of_press if settled else self._with_speeds(problem, answer.b)
            # the friction of preloaded gibs is one force at all speeds
            if settled or _same_torque(of_press, problem.coefficients):
                note = (
                    f"{' and '.join(feels)}: the torque is that of the last motion, {rounds} round{'s' if rounds > 1 else ''}; the proof"
                    " holds for this torque, but another motion with other torques may be better"
                )
                return TaskSolution(self, problem, answer, (*notes, note))
        raise PinpressError(
            f"the best motion of {self.press.name} was not found: with {' and '.join(feels)} the search does not converge within"
            f" {MOST_ROUNDS} rounds; make these loads smaller, or remove them"
        )

    def _solve_once(self, of_press: Coefficients, drive: ServoDrive, last: Array | None) -> tuple[MotionProblem, Solution, list[str]]:
        """Solve one program with fixed loads; ``last``: b of the motion at whose speeds the loads were taken."""
        problem = motion_problem(of_press, drive, self.limits, self.wanted, self.time)
        refuse_short(problem)
        try:
            if len(self.wanted) > 1:
                heat = replace(problem, weights={"heat": 1.0})
                cost = figures(heat, optimum(heat).b)
                sizes = {"heat": cost.heat, "time": cost.time, "energy": max(cost.energy, 1e-9), "peak": cost.peak}
                problem = replace(problem, weights={name: weight / sizes[name] for name, weight in self.wanted.items()})
            answer = optimum(problem)
        except NoMotionError:
            raise contradiction(problem) from None
        answer, problem, notes = self._within_local_limits(problem, answer, last)
        return problem, answer, notes

    def _within_local_limits(
        self, problem: MotionProblem, answer: Solution, last: Array | None
    ) -> tuple[Solution, MotionProblem, list[str]]:
        """The motion within the limits that are not convex, its problem, and notes on its proof."""
        closed, cost = problem.coefficients.grid.legs.closed, figures(problem, answer.b)
        pause = needed_time(problem, cost) - cost.time
        if closed and "time" in self.wanted and pause > 1e-4 * cost.time:
            raise NoTurnError(
                f"no turn was found that keeps all limits of {self.press.name}: a turn of {cost.time:.6g} s would need a pause of"
                f" {pause:.4g} s, but a turn never rests; give path=servo.Stop(), which pauses, or a time"
            )
        if not closed or "time" in self.wanted or not is_shorter(problem, answer.b):
            return within_local_limits(problem, answer, self.proved, last)
        if last is not None:
            return turn_near(problem, answer, last)

        def at(segments: int | None, like: PathMotion | None) -> MotionProblem:
            of_press = problem.coefficients
            if segments is not None or not feels_speed(self.loads, self.friction):
                of_press = self._on(segments, like)
            return motion_problem(of_press, problem.drive, self.limits, problem.weights, problem.time)

        fine = len(problem.coefficients.grid.step) > 2 * COARSE
        key = fine or problem, problem.drive, self.time, *problem.weights.items()
        if key not in self.turns:
            self.turns[key] = coarse_turn(at(COARSE, None) if fine else problem, time_of(problem, answer.b))
        return turn_in_time(problem, answer, self.turns[key], at)

    def _on(self, segments: int | None, like: PathMotion | None) -> Coefficients:
        """Coefficients of the path with this number of segments (None: unchanged), for motions near this one."""
        grid = self.coefficients.grid
        grid = grid if segments is None else path_grid(grid.legs, grid.marks, segments)
        return _coefficients(self.press, grid, self.loads, self.friction, self.limits, self.time, like)

    def _with_speeds(self, problem: MotionProblem, b: Array) -> Coefficients:
        """The coefficients with the torque of loads and friction at the speeds of a motion."""
        c, grid = problem.coefficients, problem.coefficients.grid
        angle = (grid.angle[:-1] + c.inner * grid.step).ravel()
        speed = (grid.way * np.sqrt(b[:-1] + c.inner * np.diff(b))).ravel()
        motion = moved(self.press, self.press.branch, angle, speed, np.tile(0.5 * np.diff(b) / grid.step, 2), None, "auto")
        reactions = inverse_dynamics(self.press, motion, self.loads, self.friction, bearings=None)
        torque = (reactions.driving_torque + problem.inertia * motion.crank_acceleration).reshape(2, -1)
        by_speed = torque - np.stack([inner.at(b) for inner in problem.inner_torques()])
        rate, square = (values.reshape(2, -1, 1) for values in (motion.crank_acceleration, speed**2))
        bearings = {}
        for name, part in c.bearings.items():
            force = reactions.bearing_force[name].reshape(2, -1, 3)
            bearings[name] = replace(part, fixed=force - part.by_acceleration * rate - part.by_square * square)
        return replace(c, inner_torque=c.inner_torque + by_speed, mean_torque=c.mean_torque + by_speed.mean(axis=0), bearings=bearings)

    def limit_at_states(
        self, problem: MotionProblem, answer: Solution, full: FullMotion, chosen: NDArray[np.bool_]
    ) -> tuple[MotionProblem, Solution]:
        """The best motion that keeps limits of torque and power within the chosen segments too, by tangents at the last motion."""
        feels = feels_speed(self.loads, self.friction)
        of_press = self._with_speeds(problem, answer.b) if feels else problem.coefficients
        whole = motion_problem(of_press, problem.drive, self.limits, problem.weights, self.time)
        narrow = replace(whole, bounds=(*whole.bounds, *limits_at_states(whole, full, answer.b, chosen)))
        new, narrow, _ = replace(self, proved=False)._within_local_limits(narrow, optimum(narrow), answer.b)
        return narrow, new


class TaskSolution(NamedTuple):
    """The solution of the last convex program of a task, with notes on its proof and on the choice of its path."""

    task: Task
    problem: MotionProblem
    answer: Solution
    notes: tuple[str, ...]
    choice: tuple[str, ...] = ()
    full: FullMotion | None = None

    def on_enough_nodes(self, refined: bool) -> tuple[TaskSolution, float]:
        """This motion with limits between nodes too, and its node error.

        The error follows from the same task with half of the nodes and, if there are many, a quarter.

        Args:
            refined: whether the number of nodes is doubled until their error is small.
        """
        best = self._keep_between_nodes()
        count, values = len(self.task.coefficients.grid.step), [best.answer.value]
        # with fewer than 90 nodes the errors of random presses did not yet fall with the order of the method
        for coarser in (count // 2, count // 4) if count >= 360 else (count // 2,):
            try:
                values.insert(0, best._with_nodes(coarser, proved=False).answer.value)
            except PinpressError:  # with so few nodes no motion keeps the limits
                break
        error = node_error(values)
        while len(values) == 1 or (refined and error > NODE_ERROR and 2 * count <= MOST_POINTS):
            finer = best._with_nodes(2 * count)
            values.append(finer.answer.value)
            error = node_error(values)
            if not refined:  # the user chose the number of nodes
                return best, error + abs(1.0 - finer.answer.value / best.answer.value)
            best, count = finer, 2 * count
        return best, error

    def _with_nodes(self, segments: int, proved: bool = True) -> TaskSolution:
        """The solution of the same task with another number of segments."""
        task, levels = self.task, self.task.levels
        if segments not in levels:
            levels[segments] = task._on(segments, PathMotion(self.problem.coefficients.grid.way_gone, self.answer.b))
        finer = replace(task, coefficients=levels[segments], proved=proved).solve(self.problem.drive)
        return finer._replace(choice=self.choice)._keep_between_nodes()

    def _keep_between_nodes(self) -> TaskSolution:
        """This motion with torque and power limited between nodes too, if it exceeds them there; the bound does not change."""
        task, problem, answer = self.task, self.problem, self.answer
        if problem.drive.peak_torque is None and problem.drive.power is None:
            return self
        full = full_motion(task.press, task.loads, task.friction, problem, answer.b)
        first, chosen = excess_of(problem, full)
        last = best = problem, answer, full
        least = first
        for _ in range(MOST_AMENDED if first > EXCEEDED else 0):
            try:
                narrow, new = task.limit_at_states(*last, chosen)
            except PinpressError:
                break
            last = narrow, new, full_motion(task.press, task.loads, task.friction, narrow, new.b)
            excess, near = excess_of(narrow, last[2])
            chosen = near | chosen
            # tangents at the motion that exceeded the power are far off; the next ones are better
            gained = best[1].value - new.value if least <= EXCEEDED else np.inf
            if excess < max(least, EXCEEDED) and gained > 0:
                best, least = last, excess
            if excess <= EXCEEDED and not (chosen[1].any() and gained > 1e-4 * abs(new.value)):
                break
        if best[2] is full:
            return self._replace(full=full)
        amended = replace(best[1], bound=answer.bound)
        note = (
            f"torque or power was up to {100 * first:.2g} % above its limit between nodes and is now limited there too; compared with"
            f" all motions whose mean values from node to node keep the limit, this motion costs at most {100 * amended.gap:.2g} % more"
        )
        return self._replace(problem=best[0], answer=amended, full=best[2], notes=(*self.notes, note))


def node_error(values: Sequence[float]) -> float:
    """Estimated error of the last of two or more values, as a share of it. Each value has twice the nodes of the value before.

    Doubling the nodes divides the error by 2 (first order) to 4 (second order). Three values show the order only roughly, so the estimate
    is 1.5 times the computed error.
    """
    if len(values) < 2:
        return np.inf
    change = abs(values[-1] - values[-2])
    before = abs(values[-2] - values[-3]) if len(values) > 2 else change
    change = max(change, before / 4.0)
    if change == 0.0:
        return 0.0
    falls_by = min(max(before / change, 2.0), 4.0)
    return 1.5 * change / (falls_by - 1.0) / max(abs(values[-1]), 1e-300)


def _same_torque(now: Coefficients, before: Coefficients) -> bool:
    """Whether torques and bearing forces equal those of the round before, so that another round changes nothing."""
    pairs = [
        (now.inner_torque, before.inner_torque),
        *((part.fixed, before.bearings[name].fixed) for name, part in now.bearings.items()),
    ]
    return all(np.abs(new - old).max() <= 1e-9 * np.abs(new).max() for new, old in pairs)
