"""Turns that must take exactly their time: a crank that never rests and makes a stroke every T seconds.

The condition "a cycle takes at most T" is convex; "a cycle takes exactly T" is not. Usually both have the same optimum, because less time
costs more. But if nothing limits the speed, a faster turn may store more energy and need less heat for each stroke. Then this module
searches the best motion that takes T.

The search uses tangents. The time is convex in b, so it is nowhere below its tangent at the last motion. Each program's motion therefore
takes at least T, and no motion is worse than the one before. The search starts on a coarse path, from a constant speed and from the motion
of the proof. Finer paths start from the result of the coarser path. The crank is nowhere slower than a tenth of its mean speed, or of the
limit there. Without this floor the crank would almost rest where resting costs nothing, and a `Stop` describes that better.

The proof uses the mean speed. The speed of a turn is continuous and periodic, so a turn that takes T has its mean speed somewhere. In at
least one segment the speed falls from the mean speed (or above) to the mean speed (or below). For each segment of the coarse path, a convex
program finds the best motion within T whose speed falls in this way there. The least of their bounds is a bound for all turns that take T.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...common.conic_program import InfeasibleError, UnsolvedError
from ...common.errors import PinpressError
from ...common.quantities import Array
from .coefficients import PathMotion
from .local_limits import tangents, words_of
from .motion_problem import Affine, Bounded, MotionProblem, segment_times
from .optimum import optimum
from .program import Solution, first_sizes, sizes_of, solve

SHORT = 1e-5  # share by which a cycle may be shorter than the given time
LATE, TOO_LATE = 1e-5, 1e-4  # a smaller excess of the time ends the rounds; a larger excess after the rounds is refused
SETTLED, NEARLY = 1e-4, 1e-3  # a smaller change of the value ends the rounds; a note reports a larger change after the rounds
SLOWEST = 0.1  # least speed of the crank, as a share of its mean speed or of the limit of speed there
NO_HURRY = 10.0  # share by which a program may exceed the time; in practice no limit
COARSE, FINER = 36, 4  # segments of the coarse path, and the factor for the next path
MANY_ROUNDS, SOME_ROUNDS, FEW_ROUNDS = 40, 12, 3  # of tangents on the coarse path, the next one and the last; more if the time is not met


class NoTurnError(PinpressError):
    """The search found no turn that takes its time."""


class TimedTurn(NamedTuple):
    """A motion that takes its time."""

    answer: Solution  # the last program's solution
    limited: MotionProblem  # this program's problem
    change: float  # relative change of the value in the last round

    @property
    def as_motion(self) -> PathMotion:
        return PathMotion(self.limited.coefficients.grid.way_gone, self.answer.b)

    @property
    def time(self) -> float:
        """Time of the turn [s]."""
        return time_of(self.limited, self.answer.b)


class CoarseTurn(NamedTuple):
    """A motion that takes its time on a coarse path, the start for every finer path."""

    turn: TimedTurn  # the motion
    gap: float  # no turn on this path is better by more than this share [-]; infinite if no bound was found


def time_of(problem: MotionProblem, b: Array) -> float:
    """Time of a turn [s]."""
    return float(segment_times(problem.coefficients, b).sum())


def is_shorter(problem: MotionProblem, b: Array) -> bool:
    """Whether a motion takes less than the problem's time."""
    return problem.time is not None and time_of(problem, b) < problem.time * (1.0 - SHORT)


def coarse_turn(coarse: MotionProblem, faster: float) -> CoarseTurn:
    """The best motion found that takes the problem's time on a coarse path, with a bound for all motions that take this time.

    Args:
        coarse: the problem.
        faster: time of the best turn if it may be faster [s].

    Raises:
        NoTurnError: the search found no such turn.
    """
    bound, passing = _bound_past_mean_speed(_never_resting(coarse))
    starts = [_even(coarse), *([] if passing is None else [passing])]
    if coarse.drive.power is not None or coarse.rate is not None or coarse.rms is not None:  # these limits may not allow a constant speed
        cool = replace(coarse, drive=replace(coarse.drive, power=None), limits=(), rms=None)
        cool = cool if coarse.rms is None else replace(cool, weights={"heat": 1.0})
        with contextlib.suppress(NoTurnError):
            starts.append(_rounds(cool, starts[0], MANY_ROUNDS).answer.b)
    turns = []
    for start in starts:
        with contextlib.suppress(NoTurnError):
            turns.append(_rounds(coarse, start, MANY_ROUNDS))
    if not turns:
        raise NoTurnError(
            f"no turn that takes {coarse.time:.6g} s was found, though one may exist; a faster turn of {faster:.6g} s needs less: give"
            " this time, wider limits, or path=servo.Stop(), which pauses"
        )
    best = min(turns, key=lambda turn: turn.answer.value)
    if bound > best.answer.value + 1e-7 * abs(best.answer.value):  # the bound contradicts a motion that exists, so the solver was wrong
        bound = -np.inf
    return CoarseTurn(best, max(0.0, (best.answer.value - bound) / abs(best.answer.value)))


def turn_in_time(
    problem: MotionProblem, free: Solution, coarse: CoarseTurn, at: Callable[[int | None, PathMotion], MotionProblem]
) -> tuple[Solution, MotionProblem, list[str]]:
    """The best motion found that takes the problem's time, with a bound for all motions that take this time.

    Args:
        problem: the problem, with the most time of a cycle.
        free: the optimum of this problem, a faster turn.
        coarse: the motion on a coarse path.
        at: makes the problem again with this number of segments (None: unchanged), for motions near this one.

    Returns:
        As `within_local_limits`.

    Raises:
        NoTurnError: the search found no such turn.
    """
    size, turn = len(problem.coefficients.grid.step), coarse.turn
    if size > 2 * FINER * COARSE:
        turn = _refine(at(FINER * COARSE, turn.as_motion), turn, SOME_ROUNDS)
    if size > 2 * COARSE:
        problem = at(None, turn.as_motion)
        turn = _refine(problem, turn, FEW_ROUNDS)
        free = optimum(problem)  # a bound holds only for values of the same coefficients
    _refuse_late(problem, turn)
    bound, proof = free.bound, "proved by the faster turn"
    carried = turn.answer.value - coarse.gap * abs(turn.answer.value)
    if carried > bound:
        rough = coarse.turn.answer.value / turn.answer.value
        where = f", where the objective is {rough:.3g} times as large," if size > 2 * COARSE else ""
        bound = carried
        proof = (
            f"proved on a path of {len(coarse.turn.limited.coefficients.grid.step)} segments{where} for all turns that pass their mean"
            " speed in one segment and may be faster in all others"
        )
    answer = replace(turn.answer, bound=bound)
    return answer, turn.limited, [_in_words(problem, free, turn, answer.gap, proof)]


def turn_near(problem: MotionProblem, free: Solution, start: Array) -> tuple[Solution, MotionProblem, list[str]]:
    """The best motion that takes the problem's time, near b (N + 1,) of an approximate motion, with the bound of faster turns.

    Args and errors are those of `turn_in_time`.
    """
    turn = _rounds(problem, start, FEW_ROUNDS)
    _refuse_late(problem, turn)
    answer = replace(turn.answer, bound=free.bound)
    note = (
        f"a turn that takes {problem.time:.6g} s is not convex: the motion is the best of its neighbours; a faster turn of"
        f" {time_of(problem, free.b):.4g} s would need {100 * answer.gap:.2g} % less a stroke"
    )
    return answer, turn.limited, [note]


def _rounds(problem: MotionProblem, b: Array, rounds: int) -> TimedTurn:
    """Find the motion by tangents, starting from an approximate motion."""
    assert problem.time is not None
    whole, best, value, least_late = _never_resting(problem), None, np.inf, np.inf
    for k in range(max(3 * rounds, MANY_ROUNDS)):  # more than `rounds` only while the time is not met
        b = _scale_to_time(problem, b)
        limited = replace(whole, bounds=(*whole.bounds, _time_tangent(problem, b, problem.time), *tangents(problem, b)))
        try:
            answer = solve(replace(_with_end(limited), rolled_at=b), sizes_of(problem, b))
        except (InfeasibleError, UnsolvedError):
            break
        turn = TimedTurn(answer, replace(limited, time=None), abs(value - answer.value) / abs(answer.value))
        b, value, late = answer.b, answer.value, turn.time / problem.time - 1.0
        if late <= max(LATE, least_late):  # a later round may miss the time again: keep the round that met it best
            best, least_late = turn, late
        if late <= LATE and (turn.change <= SETTLED or k + 1 >= rounds):
            break
    if best is None:
        raise NoTurnError(
            f"no turn that takes {problem.time:.6g} s was found, though one may exist: give another time, wider limits, or"
            " path=servo.Stop(), which pauses"
        )
    return best


def _with_end(problem: MotionProblem) -> MotionProblem:
    """The problem of a turn that takes at least its time, with an upper limit of the time if one is needed.

    A feed window and an rms torque refer to the time of the cycle. Without an upper limit of this time a turn could keep both by waiting.
    The limits of the time outside the window and of the heat keep their values: they do not depend on this upper limit.
    """
    assert problem.time is not None
    if problem.below is None and problem.rms is None:
        return replace(problem, time=None, time_name="")
    return replace(
        problem,
        time=problem.time * (1.0 + NO_HURRY),
        time_name="",
        feed_time=problem.feed_time + NO_HURRY * problem.time,
        rms=None if problem.rms is None else problem.rms / np.sqrt(1.0 + NO_HURRY),
    )


def _refuse_late(problem: MotionProblem, turn: TimedTurn) -> None:
    if problem.time is not None and abs(turn.time / problem.time - 1.0) > TOO_LATE:
        raise NoTurnError(
            f"no turn that takes {problem.time:.6g} s was found, though one may exist; a turn of {turn.time:.6g} s was found: give this"
            " time, or path=servo.Stop(), which pauses"
        )


def _refine(problem: MotionProblem, turn: TimedTurn, most: int) -> TimedTurn:
    """The motion on a finer path."""
    way, b = turn.as_motion
    return _rounds(problem, np.interp(problem.coefficients.grid.way_gone, way, b), most)


def _scale_to_time(problem: MotionProblem, b: Array) -> Array:
    """b, scaled so that the motion takes its time."""
    assert problem.time is not None
    return b * (time_of(problem, b) / problem.time) ** 2


def _mean_square(problem: MotionProblem) -> float:
    """Square of the mean speed [rad2/s2]."""
    assert problem.time is not None
    return float((np.abs(problem.coefficients.grid.step).sum() / problem.time) ** 2)


def _most(problem: MotionProblem) -> Array:
    """(N + 1,) largest b within limits of speed at the nodes, equal at both ends of a turn; infinite without a limit."""
    most = np.full(len(problem.coefficients.grid.angle), np.inf)
    for each in problem.bounds:
        if each.quantity is None:
            most[each.nodes] = np.minimum(most[each.nodes], each.most)
    most[[0, -1]] = most[[0, -1]].min()
    return most


def _even(problem: MotionProblem) -> Array:
    """A constant speed within limits of speed; if it does not keep the feed window, faster outside the window and slower inside."""
    mean = np.full(len(problem.coefficients.grid.angle), _mean_square(problem))
    below = problem.below
    if below is not None:
        assert problem.time is not None
        times, rest = segment_times(problem.coefficients, mean), problem.time - problem.feed_time
        if times[below].sum() > rest > 0.0:
            outside = np.append(below, False) | np.append(False, below)
            slower = times[~below].sum() / problem.feed_time
            mean *= np.where(outside, times[below].sum() / rest, slower) ** 2
            mean[[0, -1]] = mean[[0, -1]].min()
    return np.asarray(np.minimum(_most(problem), mean))


def _never_resting(problem: MotionProblem) -> MotionProblem:
    """The problem with the least speed of a crank that never rests."""
    n = len(problem.coefficients.grid.step)
    least = SLOWEST**2 * np.minimum(_most(problem), _mean_square(problem))[:-1]
    floor = Affine(-1.0 / least, np.zeros(n), np.full(n, 2.0), np.arange(n))
    return replace(problem, bounds=(*problem.bounds, Bounded("", np.ones(n), 1.0, "", floor)))


def _time_tangent(problem: MotionProblem, b: Array, time: float) -> Bounded:
    """The limit that the tangent of the time is at least this time; the time is convex in b, so it is nowhere below its tangent."""
    speed, h = np.sqrt(b), np.abs(problem.coefficients.grid.step)
    total = speed[1:] + speed[:-1]
    slopes = [-h / (total**2 * each) for each in (speed[:-1], speed[1:])]
    level = 2.0 * h / total - slopes[0] * b[:-1] - slopes[1] * b[1:]
    quantity = Affine(-slopes[0], -slopes[1], 2.0 * time / len(h) - level, np.arange(len(h)))
    return Bounded("", np.full(len(h), time), time, "s", quantity, total=True)


def _bound_past_mean_speed(problem: MotionProblem) -> tuple[float, Array | None]:
    """The least bound of all motions within the time whose speed falls past the mean speed in a segment, and the motion of this bound."""
    mean, most, sizes = _mean_square(problem), _most(problem), first_sizes(problem)
    least, motion = np.inf, None
    for k in np.flatnonzero(most[:-1] >= mean * (1.0 - 1e-9)).tolist():
        before = Affine(np.array([-1.0 / mean]), np.zeros(1), np.array([2.0]), np.array([k]))
        rows = Bounded("", np.ones(1), 1.0, "", before), Bounded("", np.array([mean]), 1.0, "", nodes=np.array([k + 1]))
        passing = replace(problem, bounds=(*problem.bounds, *rows))
        try:
            best = solve(passing, sizes)
        except InfeasibleError:
            continue
        except UnsolvedError:
            return -np.inf, motion
        sizes = sizes_of(problem, best.b)
        if best.bound < least:
            least, motion = best.bound, best.b
    return (least, motion) if motion is not None else (-np.inf, None)


def _in_words(problem: MotionProblem, free: Solution, turn: TimedTurn, gap: float, proof: str) -> str:
    b, faster = turn.answer.b, time_of(problem, free.b)
    beside = words_of(problem)
    kept = f", with {' and '.join(beside)}," if beside else ""
    slow = int(b.argmin())
    floor = (
        f"; the crank is slowest at {np.degrees(problem.coefficients.grid.angle[slow]):.4g} deg, at a tenth of its mean speed or of"
        " the limit there; a slower crank would count as a rest"
        if b[slow] < 1.01 * SLOWEST**2 * _mean_square(problem)
        else ""
    )
    settled = "" if turn.change <= NEARLY else f"; the last round of tangents still changed the value by {100 * turn.change:.2g} %"
    less = 100 * (1.0 - free.value / turn.answer.value)
    return (
        f"a turn that takes {problem.time:.6g} s{kept} is not convex, since a faster turn of {faster:.4g} s would need {less:.2g} % less"
        f" a stroke: the motion is the best of its neighbours; no turn in this time is better by more than {100 * gap:.2g} %, {proof}"
        f"{floor}{settled}"
    )
