"""Search for the best motion of a servo press, with the proof that no motion is better."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import in_unit, numbers, suitable_numbers, typed
from ..common.errors import PinpressError, caution, shown
from ..common.frozen import FrozenMapping
from ..common.results import Records
from ..dynamics.inverse_dynamics import NONE_GIVEN
from ..linkage.linkage import Linkage
from ..loads.link import Friction, Load
from .between_nodes import full_motion, largest_excess
from .conic.bounds import caution_flank, contradiction, motion_problem, speed_times
from .conic.coefficients import feels_speed
from .conic.local_limits import powers
from .conic.motion_problem import Figures, MotionProblem, cycle_time, figures
from .conic.never_resting import NoTurnError
from .conic.optimum import PROVED, NoMotionError, loses_by_speed, optimum
from .conic.program import Solution
from .drive import ServoDrive
from .limits import Limit
from .motion_optimum import UNITS, ActiveLimit, MotionOptimum, TradeOffPoint
from .paths import Path, Stop
from .task import NODE_ERROR, Task, TaskSolution, make_task

SLACK = 1e-5  # a longer rest, as a share of the cycle, counts as a pause


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
    task = make_task(press, drive, loads, minimise, float(cycle_times.max()), path, limits, friction, points)
    caution_flank(press, task.limits, loads)
    curve, near = [], None
    for time in cycle_times.tolist():
        strokes = 60.0 * task.coefficients.grid.legs.strokes / time
        try:
            solution = replace(task, time=time).solve(drive, near)
        except (NoMotionError, NoTurnError):
            curve.append(TradeOffPoint(time, strokes, None, None, None, None, None, None))
            continue
        near = solution.answer.b if solution.problem.time != time else None
        solution, node_error = solution.on_enough_nodes(points is None)
        problem, answer = solution.problem, solution.answer
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
    task = make_task(press, drive, loads, minimise, time, path, limits, friction, points)
    if ratios is not None and len(task.wanted) > 1:
        raise PinpressError("ratios cannot be compared by several quantities: minimise one of heat, time and energy, or give one ratio")
    caution_flank(press, task.limits, loads)
    drives = [drive] if ratios is None else [replace(drive, ratio=ratio) for ratio in _ratios(ratios)]
    stopping = cache(lambda: make_task(press, drive, loads, minimise, time, Stop(), limits, friction, points)) if path is None else None
    tried: dict[float, float] = {}
    best: TaskSolution | None = None
    failed: PinpressError | None = None
    for candidate in drives:
        try:
            answer = task.solve(candidate) if stopping is None else _turn_or_stop(task, stopping, candidate)
        except PinpressError as error:
            tried[candidate.ratio], failed = np.inf, error
            continue
        tried[candidate.ratio] = answer.answer.value / (candidate.ratio**2 if "heat" in task.wanted else 1.0)
        best = answer if tried[candidate.ratio] <= min(tried.values()) else best
    if best is None:
        assert failed is not None
        raise failed
    return _result(best, tried if ratios is not None else {}, points is None)


def least_heat(
    press: Linkage, drive: ServoDrive, loads: Sequence[Load], time: float, path: Path | None, limits: Sequence[Limit], points: int
) -> float:
    """A lower bound of the heat of all motions within a time, by one program of the convex limits; 0 if loads depend on the speed.

    Args and errors are those of `best_motion`.
    """
    task = make_task(press, drive, loads, "heat", time, path, limits, NONE_GIVEN, points)
    if feels_speed(loads, NONE_GIVEN):
        return 0.0
    problem = motion_problem(task.coefficients, drive, task.limits, {"heat": 1.0}, task.time)
    try:
        return optimum(problem).bound
    except NoMotionError:
        raise contradiction(problem) from None


def _turn_or_stop(turning: Task, stopping: Callable[[], Task], drive: ServoDrive) -> TaskSolution:
    """The best turn; or a stop at top dead centre, if the best turn would be faster than the time and the stop needs less than the turn."""
    try:
        turn = turning.solve(drive)
    except NoTurnError as error:
        try:
            return _chosen(stopping().solve(drive), "the search found no turn that keeps the limits in this time without a rest")
        except PinpressError:
            raise error from None
    if turn.problem.time == turning.time:
        return turn
    try:
        stop = stopping().solve(drive)
    except PinpressError:  # the drive is too weak for a stop
        return turn
    more = turn.answer.value / stop.answer.value - 1.0
    quantities = " and ".join(turning.wanted)
    if more <= 0:
        return _chosen(
            turn, f"a stop at top dead centre, path=servo.Stop(), would need {100 * (1 / (1 + more) - 1):.2g} % more {quantities}"
        )
    return _chosen(
        stop,
        f"the crank rests at top dead centre: the best turn found without a rest needs {100 * more:.2g} % more {quantities} in this time;"
        " path=servo.Turn() gives that turn",
    )


def _chosen(solution: TaskSolution, note: str) -> TaskSolution:
    """A solution, with a note on the choice of its path."""
    return solution._replace(choice=(note,))


def _ratios(ratios: object) -> list[float]:
    values = numbers("ratios", ratios, (None,))
    if not len(values) or not np.all((values > 0) & (values < 1e9)):
        raise PinpressError(f"ratios is {shown(ratios)}: give one or more positive gear ratios")
    return list(dict.fromkeys(values.tolist()))


def _result(solution: TaskSolution, tried: Mapping[float, float], refined: bool) -> MotionOptimum:
    """The result: the motion by full inverse dynamics, its proof and its active limits."""
    raw_gap, task = solution.answer.gap, solution.task
    solution, error = solution.on_enough_nodes(refined)
    problem, answer = solution.problem, solution.answer
    full = solution.full or full_motion(task.press, task.loads, task.friction, problem, answer.b)
    motion, cost, grid = full.motion, figures(problem, answer.b), problem.coefficients.grid
    _caution_absurd(problem, answer, cost)
    notes = [*solution.notes, *solution.choice]
    pause, faster = cycle_time(problem, cost) - cost.time, (problem.time or 0.0) - cost.time
    needed = "time" in task.wanted
    if pause > SLACK * cost.time:
        why = "limits require it" if needed else "a slower motion would cost more"
        notes.append(f"a pause of {pause:.4g} s remains at the end of the cycle, in which a brake holds the press: {why}")
    elif faster > SLACK * cost.time and not needed:
        notes.append(f"the motion is {faster:.4g} s faster than the given time: a slower motion would cost more")
    missed = largest_excess(problem, task.time, full, answer.b)
    if raw_gap > PROVED and loses_by_speed(problem):
        notes.append(
            "losses that grow with the speed are not convex if the crank could be slower at no cost: another motion may be better by up"
            f" to {100 * answer.gap:.2g} %"
        )
    if missed > 1e-3:
        notes.append(f"between nodes the motion exceeds limits by up to {100 * missed:.2g} %: give more points=")
    deviation = motion.heat / cost.heat - 1.0 if cost.heat else 0.0
    if abs(deviation) > 1e-3:
        notes.append(f"the heat with states between nodes differs from the program's by {100 * deviation:+.2g} %: give more points=")
    if error > 1e-4:
        more = ": give more points=" if error > NODE_ERROR else ""
        notes.append(f"finer nodes may change the objective by {100 * error:.2g} %{more}")
    return MotionOptimum(
        _press=task.press,
        minimise=FrozenMapping(dict(task.wanted)),
        path=task.path,
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
        time=full.time,
        motion=motion,
        reactions=full.reactions,
        by_ratio=FrozenMapping(dict(tried)),
        _stiff=float(np.max(problem.coefficients.inertia)) + problem.inertia,
    )


def _caution_absurd(problem: MotionProblem, answer: Solution, cost: Figures) -> None:
    """Caution if the numbers show that almost no motion keeps the limits: a bound above the value, or an enormous torque."""
    c, moving = problem.coefficients, cost.time - problem.resting
    length = float(np.abs(c.grid.step).sum())
    square = (length / moving) ** 2
    even = c.inner_torque + 0.5 * c.inner_slope * square
    usual = np.sqrt(np.mean(even**2) + ((float(np.mean(c.inertia)) + problem.inertia) * square / length) ** 2)
    rms = np.sqrt(cost.heat / cost.time)
    absurd = rms > 1e3 * usual
    if not (absurd or answer.gap < -1e-6):
        return
    what = f"a torque of {rms:.3g} N m rms at the crank, {rms / usual:.2g} times the torque at an even speed"
    what = what if absurd else f"a bound above its value (gap {answer.gap:.1e}), so its proof fails"
    taken = speed_times(problem)
    why = f": its limits of speed alone take {taken.least:.6g} s, {taken.words}" if taken.by_limit else ""
    caution(f"the best motion of {c.press_name}, {cost.time:.6g} s a cycle, has {what}{why}; give more time, or wider limits")


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
