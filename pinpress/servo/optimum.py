"""The best motion of a servo press, with the proof that none is better: the public call and its result."""

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
NODE_ERROR = 1e-3  # share of the value that finer nodes may change, unless the number of nodes is given
ORDERLY = 90  # nodes from which on errors fall as their order has it; by fewer they do not, which random presses show
NODES_SAID = 1e-4  # share from which on a note says so, beside the gap
ROUGHLY, LEAST_ROUGH = 4, 16  # a first motion has so many times fewer segments, but at least so many
PROVED = 1e-7  # gap above which the program is scaled anew by the motion found
FAR = 1e-3  # gap of a convex program that is no answer
SETTLED, MOST_ROUNDS = 1e-8, 30  # relative change of the value that ends rounds of loads that feel the speed
SAME_TORQUE = 1e-9  # relative change of the torques below which they are those of the motion
NEARLY_SETTLED = 1e-5  # the same where the program itself is not convex
NEGATIVE = 1e-6  # gap below 0 that is no rounding
ABSURD = 1e3  # torque, in that of a motion at an even speed, that no press is meant to have
SLACK = 1e-5  # share of the cycle that counts as a pause
PAUSED = 1e-4  # share of the cycle from which on a turn cannot do without it
PEAK_WITH_HEAT = 0.1  # weight of the heat beside the peak: alone the peak leaves open how fast the crank is elsewhere
EXCEEDED = 5e-4  # share by which torque or power may be exceeded between nodes
MOST_AMENDED, AMENDED = 5, 1e-4  # most rounds that amend it, and relative change of the value that ends them


class NoMotionError(PinpressError):
    """No motion keeps the limits, and it was not asked why."""


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
    """What more strokes a minute cost: the best motion at each of several times, each proved.

    Args:
        press: the press, whose crank turns fully.
        drive: the drive.
        loads: as of `best_motion`.
        times: (m,) times of a cycle, in any order [s].
        minimise: as of `best_motion`.
        path: as of `best_motion`.
        limits: as of `best_motion`.
        friction: as of `best_motion`.
        points: as of `best_motion`.

    Returns:
        A point for each time. Limits of torque and power hold between the nodes too, as of `best_motion`. Of a turn that would need less if
        it were faster, the gap is that to the faster one; `best_motion` of one time has it more closely.

    Raises:
        PinpressError: as `best_motion`; not where no motion keeps the limits at a time.
    """
    wanted = "a list of positive times [s], e.g. numpy.linspace(2, 4, 20)"
    given = suitable_numbers(
        "times", in_unit("times", times, "s"), wanted, (None,), lambda t: len(t) > 0 and np.all((t >= 1e-9) & (t <= 1e9))
    )
    asked = _asked(press, drive, loads, minimise, float(given.max()), path, limits, friction, points)
    caution_flank(press, asked.limits, loads)
    found, near = [], None
    for time in given.tolist():
        strokes = 60.0 * asked.coefficients.grid.legs.strokes / time
        try:
            solved = replace(asked, time=time, explained=False).solved(drive, near)
        except (NoMotionError, NoTurnError):
            found.append(TradeOffPoint(time, strokes, None, None, None, None, None, None))
            continue
        near = solved.answer.b if solved.problem.time != time else None
        solved, node_error = solved.task.on_enough_nodes(solved, points is None)
        problem, answer = solved.problem, solved.answer
        cost = figures(problem, answer.b)
        rms = np.sqrt(cost.heat / cycle_time(problem, cost)) / drive.ratio
        peak = cost.peak / drive.ratio
        power = float(powers(problem, answer.b).max())
        found.append(TradeOffPoint(time, strokes, float(rms), peak, power, cost.energy, answer.gap, node_error))
    return Records(TradeOffPoint, found)


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
    """The motion with the least heat, time, energy or peak torque within limits, proved to be the best.

    With b, the square of the crank's speed over its angle, the problem is convex: a second-order-cone program, whose dual cost bounds all
    motions. The drive's peak torque, top speed and power are limits always; its rated torque is one where `RmsTorque` is.

    Args:
        press: the press, whose crank turns fully.
        drive: the drive.
        loads: as of `inverse_dynamics`, but forces in time.
        minimise: "heat", "time", "energy" (drawn from the mains) or "peak" (torque, with a tenth of heat); or weights of several of them,
            each relative to its value in the motion with the least heat.
        time: time of a cycle, rests and pauses included [s]; of a `Pendulum` a cycle is two strokes. A path with a rest may take less and
            pause there; a `Turn` takes this time, which is not convex where a faster one would need less (see the notes). None only where
            the time is minimised, else it is the most.
        path: where the crank goes; None: a `Turn`, or a `Stop` at top dead centre where a faster turn would need less than one in this
            time, and the stop does too.
        limits: limits beside those of the drive.
        friction: friction of bearings and guides, by their names.
        ratios: gear ratios to try, each proved, of which the best is taken; None: that of the drive.
        points: number of segments of the path; None: 720, or twice as many until `MotionOptimum.node_error` is below 0.001, at most 20 000.
            The error of the nodes falls with the square of this number, and with the number itself where a torque is limited or its peak
            is minimised.

    Raises:
        PinpressError: no motion keeps the limits: the message names those that contradict one another, and what would do; arguments do not
            fit together; the program was not solved.
        UnknownNameError: a bearing that the press does not have.
    """
    asked = _asked(press, drive, loads, minimise, time, path, limits, friction, points)
    if ratios is not None and len(asked.wanted) > 1:
        raise PinpressError("ratios are compared by one quantity: minimise heat, time or energy, or give one ratio")
    caution_flank(press, asked.limits, loads)
    drives = [drive] if ratios is None else [replace(drive, ratio=ratio) for ratio in _ratios(ratios)]
    stopping = cache(lambda: _asked(press, drive, loads, minimise, time, Stop(), limits, friction, points)) if path is None else None
    tried: dict[float, float] = {}
    best: _Solved | None = None
    failed: PinpressError | None = None
    for each in drives:
        try:
            answer = asked.solved(each) if stopping is None else _turning_or_stopping(asked, stopping, each)
        except PinpressError as error:
            tried[each.ratio], failed = np.inf, error
            continue
        tried[each.ratio] = answer.answer.value / (each.ratio**2 if "heat" in asked.wanted else 1.0)
        best = answer if tried[each.ratio] <= min(tried.values()) else best
    if best is None:
        assert failed is not None
        raise failed
    return best.task.result(best, tried if ratios is not None else {}, points is None)


def least_heat(
    press: Linkage, drive: ServoDrive, loads: Sequence[Load], time: float, path: Path | None, limits: Sequence[Limit], points: int
) -> float:
    """A bound of the heat of all motions within a time, by one program without limits that are not convex; 0 where there is no such.

    Args and errors are those of `best_motion`.
    """
    asked = _asked(press, drive, loads, "heat", time, path, limits, NONE_GIVEN, points)
    if feels_speed(loads, NONE_GIVEN):
        return 0.0
    return _optimum(motion_problem(asked.coefficients, drive, asked.limits, {"heat": 1.0}, asked.time), press.name, True).bound


def _asked(
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
    """What is asked for, checked, with the coefficients of the press; arguments and errors as of `best_motion`."""
    expect("drive", drive, ServoDrive, "servo.ServoDrive")
    press.refuse_sliding_driver("servo motions are those of a crank")
    legs = legs_of(Turn() if path is None else path, press)
    chosen = limits_.checked(limits)
    wanted = _objective(minimise)
    most = None if time is None else float(_positive("time", time, "s"))
    if most is not None:
        plausibility.stroke_time("time", most)
    count = POINTS if points is None else whole_number("points", points, FEWEST_POINTS, MOST_POINTS)
    _refuse_open(drive, wanted, most, chosen, legs.dwell, legs.closed)
    refuse_heights(press, chosen, dead_centres(press).stroke)
    bearings = bearings_of(press, chosen)
    grid = path_grid(press, legs, [*load_heights(press, loads), *limit_heights(chosen)], count)
    speed = float(np.abs(grid.step).sum()) / (most - legs.dwell if most else 1.0)
    like = None
    if count >= ROUGHLY * LEAST_ROUGH and ("time" not in wanted or any(isinstance(each, limits_.RmsTorque) for each in chosen)):
        rough = path_grid(press, legs, [*load_heights(press, loads), *limit_heights(chosen)], count // ROUGHLY)
        of_press = coefficients(press, rough, loads, friction, speed, bearings)
        like = _roughly(motion_problem(of_press, drive, chosen, wanted, most), press.name)
    found = coefficients(press, grid, loads, friction, speed, bearings, like)
    return _Task(press, loads, friction, Turn() if path is None else path, found, chosen, wanted, most)


def _turning_or_stopping(turning: _Task, stopping: Callable[[], _Task], drive: ServoDrive) -> _Solved:
    """A turn; or a stop at top dead centre, where a turn within its time would be faster and one that takes it needs more than the stop."""
    try:
        turn = turning.solved(drive)
    except NoTurnError as error:
        try:
            return stopping().solved(drive).saying("no turn was found that never rests and keeps the limits in this time")
        except PinpressError:
            raise error from None
    if turn.problem.time == turning.time:
        return turn
    try:
        stop = stopping().solved(drive)
    except PinpressError:  # the drive is too weak for it
        return turn
    more = turn.answer.value / stop.answer.value - 1.0
    wanted = " and ".join(turning.wanted)
    if more <= 0:
        return turn.saying(f"a stop at top dead centre, path=servo.Stop(), would need {100 * (1 / (1 + more) - 1):.2g} % more {wanted}")
    return stop.saying(
        f"the crank rests at top dead centre: the best turn found that never rests and takes this time needs {100 * more:.2g} % more"
        f" {wanted}; path=servo.Turn() gives it"
    )


def _roughly(problem: MotionProblem, press_name: str) -> PathMotion | None:
    """A motion with few nodes, by which the places are chosen at which the torque is looked at; None where there is none."""
    weights = problem.weights if len(problem.weights) == 1 else {"heat": 1.0}
    try:
        return PathMotion(problem.coefficients.grid.way_gone, _optimum(replace(problem, weights=weights), press_name, False).b)
    except PinpressError:
        return None


def _objective(minimise: object) -> dict[str, float]:
    """The weights of what is minimised."""
    if isinstance(minimise, str) and minimise in UNITS:
        return {"peak": 1.0, "heat": PEAK_WITH_HEAT} if minimise == "peak" else {minimise: 1.0}
    if isinstance(minimise, Mapping) and minimise and all(isinstance(name, str) and name in UNITS for name in minimise):
        weights = {name: float(_positive(f"minimise: weight of {name}", value, "-")) for name, value in minimise.items()}
        if set(weights) == {"peak"}:
            raise PinpressError('minimise is the peak alone, which leaves open how fast the crank is elsewhere: give "heat" a weight too')
        return weights
    raise PinpressError(f'minimise is {shown(minimise)}: give "heat", "time", "energy" or "peak", or a mapping of such to weights')


def _positive(name: str, value: object, unit: str) -> Array:
    wanted = f"a positive number [{unit}]"
    return suitable_numbers(name, in_unit(name, value, unit), wanted, suits=lambda given: (given >= 1e-9) & (given <= 1e9))


def _ratios(ratios: object) -> list[float]:
    given = numbers("ratios", ratios, (None,))
    if not len(given) or not np.all((given > 0) & (given < 1e9)):
        raise PinpressError(f"ratios is {shown(ratios)}: give one or more positive gear ratios")
    return list(dict.fromkeys(given.tolist()))


def _refuse_open(
    drive: ServoDrive, wanted: Mapping[str, float], time: float | None, limits: Sequence[Limit], dwell: float, closed: bool
) -> None:
    """Raise PinpressError where nothing ends the search."""
    if time is None and "time" not in wanted:
        raise PinpressError('time is missing: give the time of a cycle [s], e.g. time=60 / 25; or minimise="time"')
    if time is not None and not time > dwell:
        raise PinpressError(f"time is {time:g} s, and the path rests for {dwell:g} s: give a longer time")
    feeding = max((each.time for each in limits if isinstance(each, limits_.FeedWindow)), default=0.0)
    if time is not None and not time > feeding:
        raise PinpressError(f"time is {time:g} s, and the FeedWindow asks for {feeding:g} s of it: give a longer time, or a shorter window")
    if time is None and len(wanted) > 1:
        raise PinpressError("time is missing: weights are relative to the motion with the least heat, which takes a time; give one")
    if wanted != {"time": 1.0}:
        return
    speeds = limits_.SlideSpeed, limits_.CrankSpeed, limits_.SlideAcceleration, limits_.BearingForce, limits_.FeedWindow
    fast = drive.top_speed or any(isinstance(each, speeds) for each in limits)
    if closed and not fast:
        raise PinpressError(
            "nothing limits the speed: a crank that never rests can be as fast as ever with hardly a torque; give the drive a top_speed, or"
            " limits=[servo.CrankSpeed(...)], or path=servo.Stop()"
        )
    torques = limits_.RmsTorque, limits_.CrankAcceleration
    if not (fast or drive.peak_torque or drive.power or any(isinstance(each, torques) for each in limits)):
        raise PinpressError("nothing limits the speed: give the drive a peak_torque or top_speed, or limits=[servo.RmsTorque(...)]")


@dataclass(frozen=True, eq=False)
class _Task:
    """What is asked for, with the coefficients of the press; attributes as the arguments of `best_motion`.

    ``explained``: whether an error says what contradicts what, which takes some more programs. ``proved``: whether a bound is looked for
    beyond that of one program. ``turns``: coarse turns that were found, which are the same on all nodes. ``levels``:
    coefficients on other numbers of segments.
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

    def solved(self, drive: ServoDrive, start: Array | None = None) -> _Solved:
        """The problem with this drive, its solution, and what is to be said of the proof; ``start``: b of a motion that is about it."""
        feels = feels_speed(self.loads, self.friction)
        found, value, last = self.coefficients, np.inf, start
        for rounds in range(1, MOST_ROUNDS + 1):
            problem, answer, notes = self._once(found, drive, last)
            last = answer.b
            if not feels:
                break
            change, value = abs(answer.value - value), answer.value
            if change <= (SETTLED if problem.time == self.time else NEARLY_SETTLED) * abs(value):
                notes = [*notes, _fixed_point(feels, rounds)]
                break
            found = self._with_speeds(problem, answer.b)
            if _same_torque(found, problem.coefficients):  # as of preloaded gibs, whose friction is one force at all speeds
                notes = [*notes, _fixed_point(feels, rounds)]
                break
        else:
            raise PinpressError(
                f"the best motion of {self.press.name} was not found: with {' and '.join(feels)} it does not settle within {MOST_ROUNDS}"
                " rounds; make these smaller, or leave them out"
            )
        return _Solved(self, problem, answer, tuple(notes))

    def _once(self, found: Coefficients, drive: ServoDrive, last: Array | None) -> tuple[MotionProblem, Solution, list[str]]:
        """One program, where loads are given; ``last``: b of the motion before, by whose speeds they were found."""
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
        """The motion with limits that are not convex, and what is to be said of it."""
        rates = [each.rate * problem.drive.ratio for each in self.limits if isinstance(each, limits_.TorqueRate)]
        local = LocalLimits(problem.drive.power, min(rates, default=None), self.proved)
        closed, cost = problem.coefficients.grid.legs.closed, figures(problem, answer.b)
        if closed and "time" in self.wanted and needed_time(problem, cost) > cost.time * (1.0 + PAUSED):
            raise NoTurnError(
                f"no turn was found that keeps all limits of {self.press.name}: one of {cost.time:.6g} s would have to pause for"
                f" {needed_time(problem, cost) - cost.time:.4g} s, and a turn never rests: give path=servo.Stop(), which pauses, or a time"
            )
        never_rests = closed and "time" not in self.wanted
        if not (never_rests and problem.time is not None and is_shorter(problem, answer.b, problem.time)):
            return within_local_limits(problem, answer, local, lambda each: _optimum(each, self.press.name, False), last)
        if last is not None:
            return turn_near(problem, answer, local, last)

        def at(segments: int | None, like: PathMotion | None) -> MotionProblem:
            return motion_problem(self._coefficients(segments, like), problem.drive, self.limits, dict(problem.weights), problem.time)

        fine = len(problem.coefficients.grid.step) > 2 * COARSE
        key = fine or problem, problem.drive, self.time, *problem.weights.items()
        if key not in self.turns:
            faster = float(segment_times(problem.coefficients, answer.b).sum())
            self.turns[key] = coarse_turn(at(COARSE, None) if fine else problem, faster, local)
        return turn_in_time(problem, answer, local, self.turns[key], at)

    def _coefficients(self, segments: int | None, like: PathMotion | None) -> Coefficients:
        """Coefficients of the path with so many segments, or its own, for motions about this one."""
        grid, speed = self.coefficients.grid, float(np.abs(self.coefficients.grid.step).sum()) / (self.time or 1.0)
        if segments is not None:
            grid = path_grid(self.press, grid.legs, [*load_heights(self.press, self.loads), *limit_heights(self.limits)], segments)
        elif feels_speed(self.loads, self.friction):
            return self.coefficients
        return coefficients(self.press, grid, self.loads, self.friction, speed, bearings_of(self.press, self.limits), like)

    def _kept_between_nodes(self, problem: MotionProblem, answer: Solution) -> tuple[MotionProblem, Solution, FullMotion, list[str]]:
        """The motion with torque and power limited between nodes too, where they are exceeded there; the bound stays as it is."""
        full = full_motion(self.press, self.loads, self.friction, problem, answer.b)
        first = excess_of(problem, full)
        if first.share <= EXCEEDED:
            return problem, answer, full, []
        last = best = problem, answer, full
        chosen, least = first, first.share
        for _ in range(MOST_AMENDED):
            try:
                narrow, new = self._limited_at_states(*last, chosen)
            except PinpressError:
                break
            last = narrow, new, full_motion(self.press, self.loads, self.friction, narrow, new.b)
            now = excess_of(narrow, last[2])
            chosen = now.with_those_of(chosen)
            # tangents at the motion that exceeded the power are far off; the next ones are better
            gained = best[1].value - new.value if least <= EXCEEDED else np.inf
            if now.share < max(least, EXCEEDED) and gained > 0:
                best, least = last, now.share
            if now.share <= EXCEEDED and not (chosen.power.any() and gained > AMENDED * abs(new.value)):
                break
        if best[2] is full:
            return *best, []
        found = replace(best[1], bound=answer.bound)
        note = (
            f"torque or power was up to {100 * first.share:.2g} % above its limit between nodes, and is limited there too; no motion that"
            f" keeps it in the mean from node to node is better than this one by more than {100 * found.gap:.2g} %"
        )
        return best[0], found, best[2], [note]

    def _limited_at_states(
        self, problem: MotionProblem, answer: Solution, full: FullMotion, chosen: Excess
    ) -> tuple[MotionProblem, Solution]:
        """The best motion that keeps limits of torque and power at states within these segments too, by tangents at the last motion."""
        feels = feels_speed(self.loads, self.friction)
        found = self._with_speeds(problem, answer.b) if feels else problem.coefficients
        whole = motion_problem(found, problem.drive, self.limits, dict(problem.weights), self.time)
        narrow = replace(whole, bounds=(*whole.bounds, *limits_at_states(whole, full, answer.b, chosen)))
        new = _optimum(narrow, self.press.name, False)
        new, narrow, _ = replace(self, proved=False)._within_local_limits(narrow, new, answer.b)
        return narrow, new

    def _with_speeds(self, problem: MotionProblem, b: Array) -> Coefficients:
        """The coefficients with the torque that loads and friction take at the speeds of a motion."""
        c, grid = problem.coefficients, problem.coefficients.grid
        angle = (grid.angle[:-1] + c.inner * grid.step).ravel()
        speed = (grid.way * np.sqrt(b[:-1] + c.inner * np.diff(b))).ravel()
        motion = moved(self.press, self.press.branch, angle, speed, np.tile(0.5 * np.diff(b) / grid.step, 2), None, "auto")
        reactions = inverse_dynamics(self.press, motion, self.loads, self.friction, bearings=None)
        torque = (reactions.driving_torque + problem.inertia * motion.crank_acceleration).reshape(2, -1)
        other = torque - np.stack([each.at(b) for each in problem.inner_torques()])
        rate, square = (values.reshape(2, -1, 1) for values in (motion.crank_acceleration, speed**2))
        bearings = {}
        for name, part in c.bearings.items():
            force = reactions.bearing_force[name].reshape(2, -1, 3)
            bearings[name] = replace(part, fixed=force - part.by_acceleration * rate - part.by_square * square)
        return replace(c, inner_torque=c.inner_torque + other, mean_torque=c.mean_torque + other.mean(axis=0), bearings=bearings)

    def on_enough_nodes(self, found: _Solved, refined: bool) -> tuple[_Solved, float]:
        """The motion kept between nodes, and the error of its nodes, by the same task on half and, of many, a quarter of them.

        Args:
            found: the motion.
            refined: whether more nodes are taken until their error is small.
        """
        found = found.kept_between_nodes()
        count, drive, values = len(self.coefficients.grid.step), found.problem.drive, [found.answer.value]
        for coarser in (count // 2, count // 4) if count >= 4 * ORDERLY else (count // 2,):
            try:
                level = replace(self._on(coarser, found), proved=False, explained=False).solved(drive)
                values.insert(0, level.kept_between_nodes().answer.value)
            except PinpressError:  # so few nodes leave no motion
                break
        error = node_error(values)
        while len(values) == 1 or (refined and error > NODE_ERROR and 2 * count <= MOST_POINTS):
            finer = self._on(2 * count, found).solved(drive)._replace(choice=found.choice).kept_between_nodes()
            values.append(finer.answer.value)
            error = node_error(values)
            if not refined:  # of the nodes that were asked for
                return found, error + abs(1.0 - finer.answer.value / found.answer.value)
            found, count = finer, 2 * count
        return found, error

    def _on(self, segments: int, found: _Solved) -> _Task:
        """The task on so many segments, for motions about one that was found."""
        if segments not in self.levels:
            like = PathMotion(found.problem.coefficients.grid.way_gone, found.answer.b)
            self.levels[segments] = self._coefficients(segments, like)
        return replace(self, coefficients=self.levels[segments])

    def result(self, found: _Solved, tried: Mapping[float, float], refined: bool) -> MotionOptimum:
        """The motion by full inverse dynamics, with its limits."""
        raw_gap = found.answer.gap
        found, error = self.on_enough_nodes(found, refined)
        problem, answer = found.problem, found.answer
        full = found.full or full_motion(self.press, self.loads, self.friction, problem, answer.b)
        motion, reactions, time = full.motion, full.reactions, full.time
        cost = figures(problem, answer.b)
        self._caution_absurd(problem, answer, cost)
        said = [*found.notes, *found.choice]
        pause, faster = cycle_time(problem, cost) - cost.time, (problem.time or 0.0) - cost.time
        if pause > SLACK * cost.time:
            said.append(_pause_in_words(pause, "time" in self.wanted))
        elif faster > SLACK * cost.time and "time" not in self.wanted:
            said.append(f"the motion is {faster:.4g} s faster than the time given: slower would cost more")
        missed = largest_excess(problem, self.limits, self.time, full, answer.b)
        if raw_gap > PROVED and _loses_by_speed(problem):
            said.append(
                "losses that grow with the speed are not convex where the crank could be slower at no cost: no motion is better by more"
                f" than {100 * answer.gap:.2g} %"
            )
        if missed > 1e-3:
            said.append(f"between nodes limits are exceeded by up to {100 * missed:.2g} %: give more points=")
        deviation = motion.heat / cost.heat - 1.0 if cost.heat else 0.0
        if abs(deviation) > 1e-3:
            said.append(f"the heat between nodes is off that of the program by {100 * deviation:+.2g} %: give more points=")
        if error > NODES_SAID:
            more = ": give more points=" if error > NODE_ERROR else ""
            said.append(f"finer nodes may change the objective by {100 * error:.2g} %{more}")
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
            notes=tuple(said),
            angle=grid.angle,
            speed=np.append(grid.way, grid.way[-1]) * np.sqrt(answer.b),
            time=time,
            motion=motion,
            reactions=reactions,
            by_ratio=FrozenMapping(dict(tried)),
            _stiff=float(np.max(problem.coefficients.inertia)) + problem.inertia,
        )

    def _caution_absurd(self, problem: MotionProblem, answer: Solution, cost: Figures) -> None:
        """Say where numbers show that hardly any motion keeps the limits: a bound above the value, or a torque beyond all measure."""
        c, moving = problem.coefficients, cost.time - problem.resting
        length = float(np.abs(c.grid.step).sum())
        square = (length / moving) ** 2
        even = c.inner_torque + 0.5 * c.inner_slope * square
        usual = np.sqrt(np.mean(even**2) + ((float(np.mean(c.inertia)) + problem.inertia) * square / length) ** 2)
        rms = np.sqrt(cost.heat / cost.time)
        absurd = rms > ABSURD * usual
        if not (absurd or answer.gap < -NEGATIVE):
            return
        what = f"a torque of {rms:.3g} N m rms at the crank, {rms / usual:.2g} times as much as at an even speed"
        what = what if absurd else f"a bound above its value (gap {answer.gap:.1e}), so that it is not proved"
        found = speed_times(problem, self.limits)
        why = f": its limits of speed alone take {found.least:.6g} s, {found.words}" if found.by_limit else ""
        caution(f"the best motion of {self.press.name}, {cost.time:.6g} s a cycle, has {what}{why}; give more time, or wider limits")


class _Solved(NamedTuple):
    """The motion of a task.

    Attributes:
        task: the task.
        problem: its last convex program's problem.
        answer: this program's solution, with the bound of all motions.
        notes: what is to be said of the proof.
        choice: what is to be said of the path that was chosen.
        full: the motion by full inverse dynamics, or None.
    """

    task: _Task
    problem: MotionProblem
    answer: Solution
    notes: tuple[str, ...]
    choice: tuple[str, ...] = ()
    full: FullMotion | None = None

    def saying(self, note: str) -> _Solved:
        """The same with a note on the path that was chosen."""
        return self._replace(choice=(*self.choice, note))

    def kept_between_nodes(self) -> _Solved:
        """The same with the drive's torque and power limited between nodes too."""
        if self.problem.drive.peak_torque is None and self.problem.drive.power is None:
            return self
        problem, answer, full, notes = self.task._kept_between_nodes(self.problem, self.answer)
        return self._replace(problem=problem, answer=answer, full=full, notes=(*self.notes, *notes))


def node_error(values: Sequence[float]) -> float:
    """By how much finer nodes may change the last of two or more values, each with twice as many nodes as the one before, as a share of it.

    Their error falls by two to four, to first or second order; of which order it is, three values show, but roughly: half more is told.
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
    """Whether torques and bearing forces are those with which a motion was found, so that another round changes nothing."""
    pairs = [
        (found.inner_torque, before.inner_torque),
        *((part.fixed, before.bearings[name].fixed) for name, part in found.bearings.items()),
    ]
    return all(np.abs(new - old).max() <= SAME_TORQUE * np.abs(new).max() for new, old in pairs)


def _fixed_point(feels: Sequence[str], rounds: int) -> str:
    counted = "1 round" if rounds == 1 else f"{rounds} rounds"
    return (
        f"{' and '.join(feels)}: the torque was taken from the last motion, {counted}; each program is proved, not that no other"
        " motion agrees with its own torques"
    )


def _pause_in_words(pause: float, needed: bool) -> str:
    words = f"a pause of {pause:.4g} s is left at the end of the cycle, in which a brake holds"
    return f"{words}: limits ask for it" if needed else f"{words}: a slower motion would cost more"


def _optimum(problem: MotionProblem, press_name: str, explained: bool) -> Solution:
    """The optimum of a convex problem; where it is proved badly, again with the sizes of the motion found."""
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
    """The best motion found where the program counts on smaller losses by the speed than its own motion has; the bound is the program's.

    Losses by the root of b are concave in b, and below their tangent at any motion: the motion of a program with the tangent in their place
    is no worse than the one at which it is drawn. Rounds begin at the program's motion and at the best one of a drive without losses.
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
    """Whether losses of the drive grow with its speed. Its program may then make them smaller than they are, and the gap is no rounding."""
    return bool(problem.drive.viscous or (problem.drive.iron and "energy" in problem.weights))


def _active(problem: MotionProblem, answer: Solution) -> Records[ActiveLimit]:
    grid = problem.coefficients.grid
    unit = UNITS[next(iter(problem.weights))] if len(problem.weights) == 1 else "-"
    units: dict[str, Any] = {each.name: each.unit for each in problem.bounds}
    found = []
    for name, price in answer.prices.items():
        gain = answer.parts[name] / max(abs(answer.value), 1e-300)
        if gain <= 1e-6:
            continue
        at = np.flatnonzero(answer.where[name])
        whole = name in (problem.time_name, problem.rms_name, problem.feed_name)
        first, last = (0, len(grid.angle) - 1) if whole or not len(at) else (at[0], at[-1])
        of = units.get(name, "N m" if name == problem.rms_name else "s")
        found.append(ActiveLimit(name, price, f"{unit} per {of}", gain, float(grid.angle[first]), float(grid.angle[last])))
    return Records(ActiveLimit, sorted(found, key=lambda each: -each.gain))
