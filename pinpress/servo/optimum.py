"""Search for the best motion of a servo press, with the proof that no motion is better."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.arguments import expect, in_unit, numbers, suitable_numbers, typed, whole_number
from ..common.conic_program import InfeasibleError, UnsolvedError
from ..common.errors import PinpressError, caution, shown
from ..common.frozen import FrozenMapping
from ..common.quantities import Array
from ..common.results import Records
from ..dynamics.inverse_dynamics import NONE_GIVEN, inverse_dynamics
from ..kinematics.cycle import moved
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage
from ..loads.link import Friction, Load
from . import limits as limits_
from .between_nodes import Excess, FullMotion, excess_of, full_motion, largest_excess, limits_at_states
from .conic.bounds import (
    bearings_of,
    caution_flank,
    contradiction,
    limit_heights,
    motion_problem,
    refuse_heights,
    refuse_short,
    speed_times,
)
from .conic.coefficients import Coefficients, PathMotion, coefficients, feels_speed, load_heights, path_grid
from .conic.local_limits import LocalLimits, powers, within_local_limits
from .conic.motion_problem import Figures, MotionProblem, cycle_time, figures, needed_time, segment_times
from .conic.never_resting import COARSE, CoarseTurn, NoTurnError, coarse_turn, is_shorter, turn_in_time, turn_near
from .conic.program import REMEDY, Solution, first_sizes, sizes_of, solve
from .drive import ServoDrive
from .limits import Limit
from .motion_optimum import UNITS, ActiveLimit, MotionOptimum, TradeOffPoint
from .paths import Path, Stop, Turn, legs_of

POINTS, FEWEST_POINTS, MOST_POINTS = 720, 8, 20_000
NODE_ERROR = 1e-3  # largest node error, as a share of the value, if the user does not give the number of nodes
ORDERLY = 90  # with fewer nodes the errors of random presses did not yet fall with the order of the method
NODES_SAID = 1e-4  # a note reports a larger node error
ROUGHLY, LEAST_ROUGH = 4, 16  # the first, rough motion has a quarter of the segments, but at least 16
PROVED = 1e-7  # with a larger gap the program is solved again, scaled by its last motion
FAR = 1e-3  # a convex program with a larger gap counts as not solved
SETTLED, MOST_ROUNDS = 1e-8, 30  # a smaller relative change of the value ends the rounds for loads that depend on the speed
SAME_TORQUE = 1e-9  # torques that differ by a smaller share count as equal
NEARLY_SETTLED = 1e-5  # as SETTLED, where the program itself is not convex
NEGATIVE = 1e-6  # a gap further below 0 is no rounding error
ABSURD = 1e3  # a torque of more than 1000 times the torque at an even speed is probably a mistake
SLACK = 1e-5  # a longer rest, as a share of the cycle, counts as a pause
PAUSED = 1e-4  # a turn that would need a longer pause, as a share of the cycle, is refused
PEAK_WITH_HEAT = 0.1  # weight of the heat next to the peak torque: the peak alone does not determine the speed elsewhere
EXCEEDED = 5e-4  # share by which the motion may exceed torque or power between nodes
MOST_AMENDED, AMENDED = 5, 1e-4  # most rounds that correct such an excess, and the relative change of the value that ends them


class NoMotionError(PinpressError):
    """No motion keeps the limits. The message does not say why, because the caller did not ask for it."""


@typed
def trade_off(
    press: Linkage,
    drive: ServoDrive,
    loads: Sequence[Load] = (),
    *,
    times: ArrayLike,
    minimise: str | Mapping[str, float] = "heat",
    path: Path | None = None,
    limits: Sequence[Limit] = (),
    friction: Mapping[str, Friction] = NONE_GIVEN,
    points: int | None = None,
) -> Records[TradeOffPoint]:
    """Compute what more strokes a minute cost: the best motion, with its proof, for each of several times of a cycle.

    Args:
        press: the press, whose crank turns fully.
        drive: the drive.
        loads: as in `best_motion`.
        times: (m,) times of a cycle, in any order [s].
        minimise: as in `best_motion`.
        path: as in `best_motion`.
        limits: as in `best_motion`.
        friction: as in `best_motion`.
        points: as in `best_motion`.

    Returns:
        A point for each time. Limits of torque and power hold between the nodes too, as in `best_motion`. If a faster turn would need less,
        the gap is the gap to the faster turn; `best_motion` computes a smaller gap for one time.

    Raises:
        PinpressError: as `best_motion`, except that a time at which no motion keeps the limits raises no error.
    """
    expected = "a list of positive times [s], e.g. numpy.linspace(2, 4, 20)"
    cycle_times = suitable_numbers(
        "times", in_unit("times", times, "s"), expected, (None,), lambda t: len(t) > 0 and np.all((t >= 1e-9) & (t <= 1e9))
    )
    task = _make_task(press, drive, loads, minimise, float(cycle_times.max()), path, limits, friction, points)
    caution_flank(press, task.limits, loads)
    curve, near = [], None
    for time in cycle_times.tolist():
        strokes = 60.0 * task.coefficients.grid.legs.strokes / time
        try:
            solved = replace(task, time=time, explained=False).solved(drive, near)
        except (NoMotionError, NoTurnError):
            curve.append(TradeOffPoint(time, strokes, None, None, None, None, None, None))
            continue
        near = solved.answer.b if solved.problem.time != time else None
        solved, node_error = solved.task.on_enough_nodes(solved, points is None)
        problem, answer = solved.problem, solved.answer
        cost = figures(problem, answer.b)
        rms = np.sqrt(cost.heat / cycle_time(problem, cost)) / drive.ratio
        peak = cost.peak / drive.ratio
        power = float(powers(problem, answer.b).max())
        curve.append(TradeOffPoint(time, strokes, float(rms), peak, power, cost.energy, answer.gap, node_error))
    return Records(TradeOffPoint, curve)


@typed
def best_motion(
    press: Linkage,
    drive: ServoDrive,
    loads: Sequence[Load] = (),
    *,
    minimise: str | Mapping[str, float] = "heat",
    time: float | None = None,
    path: Path | None = None,
    limits: Sequence[Limit] = (),
    friction: Mapping[str, Friction] = NONE_GIVEN,
    ratios: Sequence[float] | None = None,
    points: int | None = None,
) -> MotionOptimum:
    """Find the motion with the least heat, time, energy or peak torque within limits, and prove that no motion is better.

    The unknown is b, the square of the crank's speed, over the crank angle. In b the problem is convex: a second-order-cone program, whose
    dual cost is a bound for all motions. The drive's peak torque, top speed and power are always limits. Its rated torque is a limit only
    with `RmsTorque`.

    Args:
        press: the press, whose crank turns fully.
        drive: the drive.
        loads: as in `inverse_dynamics`, without forces in time.
        minimise: "heat", "time", "energy" (drawn from the mains) or "peak" (peak torque, with a tenth of heat), or quantity -> weight,
            relative to the quantity's value in the motion with the least heat [-].
        time: largest time of a cycle, rests and pauses included [s]; a cycle of a `Pendulum` is two strokes. On a path with a rest the
            crank may be faster and pause there. A `Turn` takes exactly this time, which is not convex if a faster turn would need less
            (see the notes). None is possible only if the time is minimised.
        path: where the crank goes; None: a `Turn`, or a `Stop` at top dead centre if a faster turn and the stop both need less than the
            turn in this time.
        limits: limits in addition to those of the drive.
        friction: name of a bearing or guide -> its friction.
        ratios: gear ratios to try [-]; the result has the best of them. None: the ratio of the drive.
        points: number of segments of the path; None: 720, doubled until `MotionOptimum.node_error` is below 0.001, at most 20 000. The node
            error falls with the square of this number; with the number itself if a torque is limited or the peak is minimised.

    Raises:
        PinpressError: no motion keeps the limits (the message names the limits that contradict one another, and a remedy), arguments
            contradict one another, or the program was not solved.
        UnknownNameError: the press does not have a bearing with this name.
    """
    task = _make_task(press, drive, loads, minimise, time, path, limits, friction, points)
    if ratios is not None and len(task.wanted) > 1:
        raise PinpressError("ratios cannot be compared by several quantities: minimise one of heat, time and energy, or give one ratio")
    caution_flank(press, task.limits, loads)
    drives = [drive] if ratios is None else [replace(drive, ratio=ratio) for ratio in _ratios(ratios)]
    stopping = cache(lambda: _make_task(press, drive, loads, minimise, time, Stop(), limits, friction, points)) if path is None else None
    tried: dict[float, float] = {}
    best: _TaskSolution | None = None
    failed: PinpressError | None = None
    for candidate in drives:
        try:
            answer = task.solved(candidate) if stopping is None else _turn_or_stop(task, stopping, candidate)
        except PinpressError as error:
            tried[candidate.ratio], failed = np.inf, error
            continue
        tried[candidate.ratio] = answer.answer.value / (candidate.ratio**2 if "heat" in task.wanted else 1.0)
        best = answer if tried[candidate.ratio] <= min(tried.values()) else best
    if best is None:
        assert failed is not None
        raise failed
    return best.task.result(best, tried if ratios is not None else {}, points is None)


def least_heat(
    press: Linkage, drive: ServoDrive, loads: Sequence[Load], time: float, path: Path | None, limits: Sequence[Limit], points: int
) -> float:
    """A lower bound of the heat of all motions within a time, by one program of the convex limits; 0 if loads depend on the speed.

    Args and errors are those of `best_motion`.
    """
    task = _make_task(press, drive, loads, "heat", time, path, limits, NONE_GIVEN, points)
    if feels_speed(loads, NONE_GIVEN):
        return 0.0
    return _optimum(motion_problem(task.coefficients, drive, task.limits, {"heat": 1.0}, task.time), press.name, True).bound


def _make_task(
    press: Linkage,
    drive: ServoDrive,
    loads: Sequence[Load],
    minimise: str | Mapping[str, float],
    time: float | None,
    path: Path | None,
    limits: Sequence[Limit],
    friction: Mapping[str, Friction],
    points: int | None,
) -> _Task:
    """The task with checked arguments and the coefficients of the press; arguments and errors as in `best_motion`."""
    expect("drive", drive, ServoDrive, "servo.ServoDrive")
    press.refuse_sliding_driver("servo motions need a crank")
    legs = legs_of(Turn() if path is None else path, press)
    checked = limits_.checked(limits)
    weights = _objective(minimise)
    most = None if time is None else float(_positive("time", time, "s"))
    if most is not None:
        plausibility.stroke_time("time", most)
    count = POINTS if points is None else whole_number("points", points, FEWEST_POINTS, MOST_POINTS)
    _refuse_open(drive, weights, most, checked, legs.dwell, legs.closed)
    refuse_heights(press, checked, dead_centres(press).stroke)
    bearings = bearings_of(press, checked)
    grid = path_grid(press, legs, [*load_heights(press, loads), *limit_heights(checked)], count)
    speed = float(np.abs(grid.step).sum()) / (most - legs.dwell if most else 1.0)
    like = None
    if count >= ROUGHLY * LEAST_ROUGH and ("time" not in weights or any(isinstance(limit, limits_.RmsTorque) for limit in checked)):
        rough = path_grid(press, legs, [*load_heights(press, loads), *limit_heights(checked)], count // ROUGHLY)
        of_press = coefficients(press, rough, loads, friction, speed, bearings)
        like = _rough_motion(motion_problem(of_press, drive, checked, weights, most), press.name)
    of_path = coefficients(press, grid, loads, friction, speed, bearings, like)
    return _Task(press, loads, friction, Turn() if path is None else path, of_path, checked, weights, most)


def _turn_or_stop(turning: _Task, stopping: Callable[[], _Task], drive: ServoDrive) -> _TaskSolution:
    """The best turn; or a stop at top dead centre, if the best turn would be faster than the time and the stop needs less than the turn."""
    try:
        turn = turning.solved(drive)
    except NoTurnError as error:
        try:
            return stopping().solved(drive).with_choice("the search found no turn that keeps the limits in this time without a rest")
        except PinpressError:
            raise error from None
    if turn.problem.time == turning.time:
        return turn
    try:
        stop = stopping().solved(drive)
    except PinpressError:  # the drive is too weak for it
        return turn
    more = turn.answer.value / stop.answer.value - 1.0
    quantities = " and ".join(turning.wanted)
    if more <= 0:
        return turn.with_choice(
            f"a stop at top dead centre, path=servo.Stop(), would need {100 * (1 / (1 + more) - 1):.2g} % more {quantities}"
        )
    return stop.with_choice(
        f"the crank rests at top dead centre: the best turn found without a rest needs {100 * more:.2g} % more {quantities} in this time;"
        " path=servo.Turn() gives that turn"
    )


def _rough_motion(problem: MotionProblem, press_name: str) -> PathMotion | None:
    """A motion with few nodes, which decides at which places the torque is evaluated; None if no motion was found."""
    weights = problem.weights if len(problem.weights) == 1 else {"heat": 1.0}
    try:
        return PathMotion(problem.coefficients.grid.way_gone, _optimum(replace(problem, weights=weights), press_name, False).b)
    except PinpressError:
        return None


def _objective(minimise: object) -> dict[str, float]:
    """Quantity -> its weight in the objective."""
    if isinstance(minimise, str) and minimise in UNITS:
        return {"peak": 1.0, "heat": PEAK_WITH_HEAT} if minimise == "peak" else {minimise: 1.0}
    if isinstance(minimise, Mapping) and minimise and all(isinstance(name, str) and name in UNITS for name in minimise):
        weights = {name: float(_positive(f"minimise: weight of {name}", value, "-")) for name, value in minimise.items()}
        if set(weights) == {"peak"}:
            raise PinpressError('minimise has only "peak", which does not determine the speed elsewhere: give "heat" a weight too')
        return weights
    raise PinpressError(f'minimise is {shown(minimise)}: give "heat", "time", "energy" or "peak", or a mapping of these names to weights')


def _positive(name: str, value: object, unit: str) -> Array:
    expected = f"a positive number [{unit}]"
    return suitable_numbers(name, in_unit(name, value, unit), expected, suits=lambda given: (given >= 1e-9) & (given <= 1e9))


def _ratios(ratios: object) -> list[float]:
    values = numbers("ratios", ratios, (None,))
    if not len(values) or not np.all((values > 0) & (values < 1e9)):
        raise PinpressError(f"ratios is {shown(ratios)}: give one or more positive gear ratios")
    return list(dict.fromkeys(values.tolist()))


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
class _Task:
    """A task of `best_motion`, whose arguments are the attributes, with the coefficients of the press.

    ``explained``: whether an error names the contradicting limits, which takes some more programs. ``proved``: whether more programs than
    one tighten the bound. ``turns``: coarse turns, which are the same for all numbers of nodes. ``levels``: number of segments ->
    coefficients.
    """

    press: Linkage
    loads: Sequence[Load]
    friction: Mapping[str, Friction]
    path: Path
    coefficients: Coefficients
    limits: tuple[Limit, ...]
    wanted: Mapping[str, float]
    time: float | None
    explained: bool = True
    proved: bool = True
    turns: dict[object, CoarseTurn] = field(default_factory=dict)
    levels: dict[int, Coefficients] = field(default_factory=dict)

    def solved(self, drive: ServoDrive, start: Array | None = None) -> _TaskSolution:
        """Solve the task with this drive; ``start``: b of a motion near the solution."""
        feels = feels_speed(self.loads, self.friction)
        of_press, value, last = self.coefficients, np.inf, start
        for rounds in range(1, MOST_ROUNDS + 1):
            problem, answer, notes = self._once(of_press, drive, last)
            last = answer.b
            if not feels:
                break
            change, value = abs(answer.value - value), answer.value
            if change <= (SETTLED if problem.time == self.time else NEARLY_SETTLED) * abs(value):
                notes = [*notes, _fixed_point(feels, rounds)]
                break
            of_press = self._with_speeds(problem, answer.b)
            if _same_torque(of_press, problem.coefficients):  # as of preloaded gibs, whose friction is one force at all speeds
                notes = [*notes, _fixed_point(feels, rounds)]
                break
        else:
            raise PinpressError(
                f"the best motion of {self.press.name} was not found: with {' and '.join(feels)} the search does not converge within"
                f" {MOST_ROUNDS} rounds; make these loads smaller, or remove them"
            )
        return _TaskSolution(self, problem, answer, tuple(notes))

    def _once(self, found: Coefficients, drive: ServoDrive, last: Array | None) -> tuple[MotionProblem, Solution, list[str]]:
        """Solve one program with fixed loads; ``last``: b of the motion at whose speeds the loads were taken."""
        weights = dict(self.wanted)
        try:
            refuse_short(motion_problem(found, drive, self.limits, weights, self.time), self.limits, self.press.name)
        except PinpressError as error:
            raise (error if self.explained else NoMotionError(str(error))) from None
        if len(weights) > 1:
            least = _optimum(motion_problem(found, drive, self.limits, {"heat": 1.0}, self.time), self.press.name, self.explained)
            cost = figures(motion_problem(found, drive, self.limits, {"heat": 1.0}, self.time), least.b)
            sizes = {"heat": cost.heat, "time": cost.time, "energy": max(cost.energy, 1e-9), "peak": cost.peak}
            weights = {name: weight / sizes[name] for name, weight in weights.items()}
        problem = motion_problem(found, drive, self.limits, weights, self.time)
        answer = _optimum(problem, self.press.name, self.explained)
        notes: list[str] = []
        answer, problem, notes = self._within_local_limits(problem, answer, last)
        return problem, answer, notes

    def _within_local_limits(
        self, problem: MotionProblem, answer: Solution, last: Array | None
    ) -> tuple[Solution, MotionProblem, list[str]]:
        """The motion within the limits that are not convex, its problem, and notes on its proof."""
        rates = [each.rate * problem.drive.ratio for each in self.limits if isinstance(each, limits_.TorqueRate)]
        local = LocalLimits(problem.drive.power, min(rates, default=None), self.proved)
        closed, cost = problem.coefficients.grid.legs.closed, figures(problem, answer.b)

        def optimum(problem: MotionProblem) -> Solution:
            return _optimum(problem, self.press.name, False)

        if closed and "time" in self.wanted and needed_time(problem, cost) > cost.time * (1.0 + PAUSED):
            raise NoTurnError(
                f"no turn was found that keeps all limits of {self.press.name}: a turn of {cost.time:.6g} s would need a pause of"
                f" {needed_time(problem, cost) - cost.time:.4g} s, but a turn never rests; give path=servo.Stop(), which pauses, or a time"
            )
        never_rests = closed and "time" not in self.wanted
        if not (never_rests and problem.time is not None and is_shorter(problem, answer.b, problem.time)):
            return within_local_limits(problem, answer, local, optimum, last)
        if last is not None:
            return turn_near(problem, answer, local, last)

        def at(segments: int | None, like: PathMotion | None) -> MotionProblem:
            return motion_problem(self._coefficients(segments, like), problem.drive, self.limits, dict(problem.weights), problem.time)

        fine = len(problem.coefficients.grid.step) > 2 * COARSE
        key = fine or problem, problem.drive, self.time, *problem.weights.items()
        if key not in self.turns:
            faster = float(segment_times(problem.coefficients, answer.b).sum())
            self.turns[key] = coarse_turn(at(COARSE, None) if fine else problem, faster, local)
        return turn_in_time(problem, answer, local, self.turns[key], at, optimum)

    def _coefficients(self, segments: int | None, like: PathMotion | None) -> Coefficients:
        """Coefficients of the path with this number of segments (None: unchanged), for motions near this one."""
        grid, speed = self.coefficients.grid, float(np.abs(self.coefficients.grid.step).sum()) / (self.time or 1.0)
        if segments is not None:
            grid = path_grid(self.press, grid.legs, [*load_heights(self.press, self.loads), *limit_heights(self.limits)], segments)
        elif feels_speed(self.loads, self.friction):
            return self.coefficients
        return coefficients(self.press, grid, self.loads, self.friction, speed, bearings_of(self.press, self.limits), like)

    def _keep_between_nodes(self, problem: MotionProblem, answer: Solution) -> tuple[MotionProblem, Solution, FullMotion, list[str]]:
        """The motion with torque and power limited between nodes too, if it exceeds them there; the bound does not change."""
        full = full_motion(self.press, self.loads, self.friction, problem, answer.b)
        first = excess_of(problem, full)
        if first.share <= EXCEEDED:
            return problem, answer, full, []
        last = best = problem, answer, full
        chosen, least = first, first.share
        for _ in range(MOST_AMENDED):
            try:
                narrow, new = self._limit_at_states(*last, chosen)
            except PinpressError:
                break
            last = narrow, new, full_motion(self.press, self.loads, self.friction, narrow, new.b)
            now = excess_of(narrow, last[2])
            chosen = now.join_segments(chosen)
            # tangents at the motion that exceeded the power are far off; the next ones are better
            gained = best[1].value - new.value if least <= EXCEEDED else np.inf
            if now.share < max(least, EXCEEDED) and gained > 0:
                best, least = last, now.share
            if now.share <= EXCEEDED and not (chosen.power.any() and gained > AMENDED * abs(new.value)):
                break
        if best[2] is full:
            return *best, []
        amended = replace(best[1], bound=answer.bound)
        note = (
            f"torque or power was up to {100 * first.share:.2g} % above its limit between nodes and is now limited there too; compared with"
            f" all motions whose mean values from node to node keep the limit, this motion costs at most {100 * amended.gap:.2g} % more"
        )
        return best[0], amended, best[2], [note]

    def _limit_at_states(
        self, problem: MotionProblem, answer: Solution, full: FullMotion, chosen: Excess
    ) -> tuple[MotionProblem, Solution]:
        """The best motion that keeps limits of torque and power within the chosen segments too, by tangents at the last motion."""
        feels = feels_speed(self.loads, self.friction)
        of_press = self._with_speeds(problem, answer.b) if feels else problem.coefficients
        whole = motion_problem(of_press, problem.drive, self.limits, dict(problem.weights), self.time)
        narrow = replace(whole, bounds=(*whole.bounds, *limits_at_states(whole, full, answer.b, chosen)))
        new = _optimum(narrow, self.press.name, False)
        new, narrow, _ = replace(self, proved=False)._within_local_limits(narrow, new, answer.b)
        return narrow, new

    def _with_speeds(self, problem: MotionProblem, b: Array) -> Coefficients:
        """The coefficients with the torque of loads and friction at the speeds of a motion."""
        c, grid = problem.coefficients, problem.coefficients.grid
        angle = (grid.angle[:-1] + c.inner * grid.step).ravel()
        speed = (grid.way * np.sqrt(b[:-1] + c.inner * np.diff(b))).ravel()
        motion = moved(self.press, self.press.branch, angle, speed, np.tile(0.5 * np.diff(b) / grid.step, 2), None, "auto")
        reactions = inverse_dynamics(self.press, motion, self.loads, self.friction, bearings=None)
        torque = (reactions.driving_torque + problem.inertia * motion.crank_acceleration).reshape(2, -1)
        by_speed = torque - np.stack([each.at(b) for each in problem.inner_torques()])
        rate, square = (values.reshape(2, -1, 1) for values in (motion.crank_acceleration, speed**2))
        bearings = {}
        for name, part in c.bearings.items():
            force = reactions.bearing_force[name].reshape(2, -1, 3)
            bearings[name] = replace(part, fixed=force - part.by_acceleration * rate - part.by_square * square)
        return replace(c, inner_torque=c.inner_torque + by_speed, mean_torque=c.mean_torque + by_speed.mean(axis=0), bearings=bearings)

    def on_enough_nodes(self, found: _TaskSolution, refined: bool) -> tuple[_TaskSolution, float]:
        """The motion with limits between nodes too, and its node error.

        The error follows from the same task with half of the nodes and, if there are many, a quarter.

        Args:
            found: the motion.
            refined: whether the number of nodes is doubled until their error is small.
        """
        found = found.keep_between_nodes()
        count, drive, values = len(self.coefficients.grid.step), found.problem.drive, [found.answer.value]
        for coarser in (count // 2, count // 4) if count >= 4 * ORDERLY else (count // 2,):
            try:
                level = replace(self._on(coarser, found), proved=False, explained=False).solved(drive)
                values.insert(0, level.keep_between_nodes().answer.value)
            except PinpressError:  # so few nodes leave no motion
                break
        error = node_error(values)
        while len(values) == 1 or (refined and error > NODE_ERROR and 2 * count <= MOST_POINTS):
            finer = self._on(2 * count, found).solved(drive)._replace(choice=found.choice).keep_between_nodes()
            values.append(finer.answer.value)
            error = node_error(values)
            if not refined:  # the user chose the number of nodes
                return found, error + abs(1.0 - finer.answer.value / found.answer.value)
            found, count = finer, 2 * count
        return found, error

    def _on(self, segments: int, found: _TaskSolution) -> _Task:
        """The task with this number of segments, for motions near the one found."""
        if segments not in self.levels:
            like = PathMotion(found.problem.coefficients.grid.way_gone, found.answer.b)
            self.levels[segments] = self._coefficients(segments, like)
        return replace(self, coefficients=self.levels[segments])

    def result(self, found: _TaskSolution, tried: Mapping[float, float], refined: bool) -> MotionOptimum:
        """The result: the motion by full inverse dynamics, its proof and its active limits."""
        raw_gap = found.answer.gap
        found, error = self.on_enough_nodes(found, refined)
        problem, answer = found.problem, found.answer
        full = found.full or full_motion(self.press, self.loads, self.friction, problem, answer.b)
        motion, reactions, time = full.motion, full.reactions, full.time
        cost = figures(problem, answer.b)
        self._caution_absurd(problem, answer, cost)
        notes = [*found.notes, *found.choice]
        pause, faster = cycle_time(problem, cost) - cost.time, (problem.time or 0.0) - cost.time
        if pause > SLACK * cost.time:
            notes.append(_pause_in_words(pause, "time" in self.wanted))
        elif faster > SLACK * cost.time and "time" not in self.wanted:
            notes.append(f"the motion is {faster:.4g} s faster than the given time: a slower motion would cost more")
        missed = largest_excess(problem, self.limits, self.time, full, answer.b)
        if raw_gap > PROVED and _loses_by_speed(problem):
            notes.append(
                "losses that grow with the speed are not convex if the crank could be slower at no cost: another motion may be better by up"
                f" to {100 * answer.gap:.2g} %"
            )
        if missed > 1e-3:
            notes.append(f"between nodes the motion exceeds limits by up to {100 * missed:.2g} %: give more points=")
        deviation = motion.heat / cost.heat - 1.0 if cost.heat else 0.0
        if abs(deviation) > 1e-3:
            notes.append(f"the heat with states between nodes differs from the program's by {100 * deviation:+.2g} %: give more points=")
        if error > NODES_SAID:
            more = ": give more points=" if error > NODE_ERROR else ""
            notes.append(f"finer nodes may change the objective by {100 * error:.2g} %{more}")
        grid = problem.coefficients.grid
        return MotionOptimum(
            _press=self.press,
            minimise=FrozenMapping(dict(self.wanted)),
            path=self.path,
            drive=problem.drive,
            value=answer.value,
            bound=answer.bound,
            limits=_active(problem, answer),
            missed=missed,
            deviation=deviation,
            node_error=error,
            notes=tuple(notes),
            angle=grid.angle,
            speed=np.append(grid.way, grid.way[-1]) * np.sqrt(answer.b),
            time=time,
            motion=motion,
            reactions=reactions,
            by_ratio=FrozenMapping(dict(tried)),
            _stiff=float(np.max(problem.coefficients.inertia)) + problem.inertia,
        )

    def _caution_absurd(self, problem: MotionProblem, answer: Solution, cost: Figures) -> None:
        """Caution if the numbers show that almost no motion keeps the limits: a bound above the value, or an enormous torque."""
        c, moving = problem.coefficients, cost.time - problem.resting
        length = float(np.abs(c.grid.step).sum())
        square = (length / moving) ** 2
        even = c.inner_torque + 0.5 * c.inner_slope * square
        usual = np.sqrt(np.mean(even**2) + ((float(np.mean(c.inertia)) + problem.inertia) * square / length) ** 2)
        rms = np.sqrt(cost.heat / cost.time)
        absurd = rms > ABSURD * usual
        if not (absurd or answer.gap < -NEGATIVE):
            return
        what = f"a torque of {rms:.3g} N m rms at the crank, {rms / usual:.2g} times the torque at an even speed"
        what = what if absurd else f"a bound above its value (gap {answer.gap:.1e}), so its proof fails"
        taken = speed_times(problem, self.limits)
        why = f": its limits of speed alone take {taken.least:.6g} s, {taken.words}" if taken.by_limit else ""
        caution(f"the best motion of {self.press.name}, {cost.time:.6g} s a cycle, has {what}{why}; give more time, or wider limits")


class _TaskSolution(NamedTuple):
    """The solution of the last convex program of a task, with notes on its proof and on the choice of its path."""

    task: _Task
    problem: MotionProblem
    answer: Solution
    notes: tuple[str, ...]
    choice: tuple[str, ...] = ()
    full: FullMotion | None = None

    def with_choice(self, note: str) -> _TaskSolution:
        """This motion, with a note on the choice of its path."""
        return self._replace(choice=(*self.choice, note))

    def keep_between_nodes(self) -> _TaskSolution:
        """This motion, with the drive's torque and power limited between nodes too."""
        if self.problem.drive.peak_torque is None and self.problem.drive.power is None:
            return self
        problem, answer, full, notes = self.task._keep_between_nodes(self.problem, self.answer)
        return self._replace(problem=problem, answer=answer, full=full, notes=(*self.notes, *notes))


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


def _same_torque(found: Coefficients, before: Coefficients) -> bool:
    """Whether torques and bearing forces equal those of the round before, so that another round changes nothing."""
    pairs = [
        (found.inner_torque, before.inner_torque),
        *((part.fixed, before.bearings[name].fixed) for name, part in found.bearings.items()),
    ]
    return all(np.abs(new - old).max() <= SAME_TORQUE * np.abs(new).max() for new, old in pairs)


def _fixed_point(feels: Sequence[str], rounds: int) -> str:
    counted = "1 round" if rounds == 1 else f"{rounds} rounds"
    return (
        f"{' and '.join(feels)}: the torque is that of the last motion, {counted}; the proof holds for this torque, but another motion"
        " with other torques may be better"
    )


def _pause_in_words(pause: float, needed: bool) -> str:
    words = f"a pause of {pause:.4g} s remains at the end of the cycle, in which a brake holds the press"
    return f"{words}: limits require it" if needed else f"{words}: a slower motion would cost more"


def _optimum(problem: MotionProblem, press_name: str, explained: bool) -> Solution:
    """The optimum of a convex problem; after a bad proof the program is solved again, scaled by its last motion."""
    answer, fault = None, ""
    sizes = first_sizes(problem)
    for _ in range(3):
        try:
            new = solve(problem, sizes)
        except InfeasibleError:
            if answer is None:
                raise (contradiction(problem, press_name) if explained else NoMotionError("no motion keeps the limits")) from None
            break
        except UnsolvedError as error:
            fault = str(error)
            sizes = sizes.with_torques(3.0)
            continue
        if answer is None or abs(new.gap) < abs(answer.gap):
            answer = new
        if abs(answer.gap) <= PROVED:
            break
        sizes = sizes_of(problem, answer.b)
    if answer is None or not (abs(answer.gap) <= FAR or _loses_by_speed(problem) or (answer.gap < 0 and problem.drive.curve_torque)):
        fault = fault if answer is None else f"value and bound differ by {answer.gap:.1e}; {REMEDY}"
        raise PinpressError(f"the best motion of {press_name} was not found: {fault}")
    return _with_losses(problem, answer) if answer.gap > PROVED and _loses_by_speed(problem) else answer


def _with_losses(problem: MotionProblem, answer: Solution) -> Solution:
    """The best motion found if losses grow with the speed and the program underestimates them; the bound remains the program's.

    These losses are concave in b, because they follow its root, so they lie below their tangent at any motion. A program with the tangent
    in place of the losses finds a motion that is no worse than the motion at which the tangent touches. The rounds start at the program's
    motion, and again at the best motion of a drive without losses.
    """
    without = replace(problem, drive=replace(problem.drive, viscous=0.0, iron=0.0))
    starts, best = [answer.b], answer
    with contextlib.suppress(InfeasibleError, UnsolvedError):
        starts.append(solve(without, sizes_of(problem, answer.b)).b)
    for b in starts:
        value = np.inf
        for _ in range(MOST_ROUNDS):
            try:
                new = solve(replace(problem, rolled_at=b), sizes_of(problem, b))
            except (InfeasibleError, UnsolvedError):
                break
            best = new if new.value < best.value else best
            if not new.value < value - NEARLY_SETTLED * abs(new.value):
                break
            b, value = new.b, new.value
    return replace(best, bound=answer.bound)


def _loses_by_speed(problem: MotionProblem) -> bool:
    """Whether losses of the drive grow with its speed. Then the program may underestimate them, and the gap is not only rounding."""
    return bool(problem.drive.viscous or (problem.drive.iron and "energy" in problem.weights))


def _active(problem: MotionProblem, answer: Solution) -> Records[ActiveLimit]:
    grid = problem.coefficients.grid
    unit = UNITS[next(iter(problem.weights))] if len(problem.weights) == 1 else "-"
    units: dict[str, Any] = {each.name: each.unit for each in problem.bounds}
    active = []
    for name, price in answer.prices.items():
        gain = answer.parts[name] / max(abs(answer.value), 1e-300)
        if gain <= 1e-6:
            continue
        active_places = np.flatnonzero(answer.where[name])
        whole = name in (problem.time_name, problem.rms_name, problem.feed_name)
        first, last = (0, len(grid.angle) - 1) if whole or not len(active_places) else (active_places[0], active_places[-1])
        of = units.get(name, "N m" if name == problem.rms_name else "s")
        active.append(ActiveLimit(name, price, f"{unit} per {of}", gain, float(grid.angle[first]), float(grid.angle[last])))
    return Records(ActiveLimit, sorted(active, key=lambda each: -each.gain))
