"""Turns that must take their time: a crank that never rests and makes a stroke every T seconds.

That a cycle takes at most T is convex, that it takes T is not. Mostly it is the same, for less time costs more. But where nothing limits
the speed, a faster turn stores more energy and needs less heat for each stroke. Then the best motion that takes T is looked for here.

It is found by tangents: the time, convex in b, is nowhere below its tangent at the last motion, so that each program's motion takes at
least T, and the next is no worse. A coarse path is the first, from an even speed and from the motion that the proof leaves; finer ones
begin with what it found. The crank is nowhere slower than a tenth of its mean speed, or of the limit there: without that, it would all but
rest wherever resting costs nothing, and a `Stop` is the better question.

It is proved by the mean speed: a turn that takes T has it somewhere, since its speed goes on steadily, and comes back to where it was. So
in some segment it falls from the mean speed, or above, to it, or below. For each segment of the coarse path the best motion within T that
does so there is a convex program, and the least of their bounds is one for all turns that take T.
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
from .local_limits import LocalLimits, tangents, words_of
from .motion_problem import Affine, Bounded, MotionProblem, segment_times
from .program import Sizes, Solution, first_sizes, sizes_of, solve

SHORT = 1e-5  # share by which a cycle may be shorter than asked for
LATE, TOO_LATE = 1e-5, 1e-4  # shares by which a cycle is longer than asked for that end the rounds, and that are refused after them
SETTLED, NEARLY = 1e-4, 1e-3  # relative changes of the value that end the rounds, and above which the motion is said not to be settled
SLOWEST = 0.1  # least speed of the crank, in its mean speed or the limit of speed there
NO_HURRY = 10.0  # share by which a program may be late
ROUGH, FINE, CLOSE = 1e-5, 1e-7, 1e-9  # tolerances of programs of the proof, whose bounds are far apart anyhow, and of rounds of tangents
COARSE, FINER = 36, 4  # segments of the coarse path, and how many times as many the next one has
MANY_ROUNDS, SOME_ROUNDS, FEW_ROUNDS = (
    40,
    12,
    3,
)  # of tangents on the coarse path, the next one and the last; more while the time is not met


class NoTurnError(PinpressError):
    """No turn that takes its time was found."""


class TimedTurn(NamedTuple):
    """A motion that takes its time.

    Attributes:
        answer: the last program's solution.
        limited: this program's problem.
        change: relative change of the value in the last round.
    """

    answer: Solution
    limited: MotionProblem
    change: float

    @property
    def as_motion(self) -> PathMotion:
        return PathMotion(self.limited.coefficients.grid.way_gone, self.answer.b)


def is_shorter(problem: MotionProblem, b: Array, time: float) -> bool:
    """Whether a motion takes less than this time [s]."""
    return bool(segment_times(problem.coefficients, b).sum() < time * (1.0 - SHORT))


class CoarseTurn(NamedTuple):
    """A motion that takes its time on a coarse path, which every finer path begins with.

    Attributes:
        turn: the motion.
        gap: share by which another turn on this path may be better at most; infinite where no bound was found [-].
    """

    turn: TimedTurn
    gap: float


def coarse_turn(coarse: MotionProblem, faster: float, limits: LocalLimits) -> CoarseTurn:
    """The best motion found that takes the problem's time on a coarse path, with a bound for all that do.

    Args:
        coarse: the problem.
        faster: time that the best turn takes if it may be faster [s].
        limits: limits that are not convex beside the time.

    Raises:
        NoTurnError: none was found.
    """
    assert coarse.time is not None
    bound, passing = _passing_the_mean_speed(_never_resting(coarse))
    found = None
    starts = [_even(coarse), *([] if passing is None else [passing])]
    if limits.power is not None or limits.rate is not None or coarse.rms is not None:  # an even speed may be far from what they allow
        cool = coarse if coarse.rms is None else replace(coarse, rms=None, weights={"heat": 1.0})
        with contextlib.suppress(NoTurnError):
            starts.append(_rounds(cool, starts[0], LocalLimits(None, None, False), MANY_ROUNDS).answer.b)
    for start in starts:
        try:
            turn = _rounds(coarse, start, limits, MANY_ROUNDS)
        except NoTurnError:
            continue
        found = turn if found is None or turn.answer.value < found.answer.value else found
    if found is None:
        raise NoTurnError(
            f"no turn that takes {coarse.time:.6g} s was found, which does not prove that there is none; a faster one needs least, of"
            f" {faster:.6g} s: give this time, wider limits, or path=servo.Stop(), which pauses"
        )
    if bound > found.answer.value + FINE * abs(found.answer.value):  # a program was said to have no motion, and has one
        bound = -np.inf
    return CoarseTurn(found, max(0.0, (found.answer.value - bound) / abs(found.answer.value)))


def turn_in_time(
    problem: MotionProblem,
    free: Solution,
    limits: LocalLimits,
    coarse: CoarseTurn,
    at: Callable[[int | None, PathMotion | None], MotionProblem],
) -> tuple[Solution, MotionProblem, list[str]]:
    """The best motion found that takes the problem's time, with a bound for all that do.

    Args:
        problem: the problem, with the most time of a cycle.
        free: its optimum, a faster turn.
        limits: limits that are not convex beside the time.
        coarse: the motion on a coarse path.
        at: makes the problem anew with so many segments, or its own number, for motions about this one.

    Returns:
        as `within_local_limits`.

    Raises:
        NoTurnError: none was found.
    """
    size, found = len(problem.coefficients.grid.step), coarse.turn
    if size > 2 * FINER * COARSE:
        found = _refined(at(FINER * COARSE, found.as_motion), found, limits, SOME_ROUNDS)
    if size > 2 * COARSE:
        found = _refined(at(None, found.as_motion), found, limits, FEW_ROUNDS)
    _refuse_late(problem, found)
    answer, gap = found.answer, coarse.gap
    share = answer.value - gap * abs(answer.value)
    answer = replace(answer, bound=max(share, free.bound) if np.isfinite(share) else free.bound)
    segments = len(coarse.turn.limited.coefficients.grid.step)
    proof = f"proved on a path of {segments} segments" if answer.bound > free.bound else "which the faster one proves"
    return answer, found.limited, [_in_words(problem, free, found, answer.gap, limits, proof)]


def turn_near(problem: MotionProblem, free: Solution, limits: LocalLimits, start: Array) -> tuple[Solution, MotionProblem, list[str]]:
    """The best motion that takes the problem's time near one (N + 1,) that does about, with the bound of faster turns.

    Args and errors are those of `turn_in_time`.
    """
    found = _rounds(problem, start, limits, FEW_ROUNDS)
    _refuse_late(problem, found)
    answer = replace(found.answer, bound=free.bound)
    note = (
        f"a turn that takes {problem.time:.6g} s is not convex: the motion is the best near it; a faster one, of"
        f" {segment_times(problem.coefficients, free.b).sum():.4g} s, would need {100 * answer.gap:.2g} % less a stroke"
    )
    return answer, found.limited, [note]


def _rounds(problem: MotionProblem, b: Array, limits: LocalLimits, rounds: int) -> TimedTurn:
    """The motion by tangents, from one that is about the one looked for."""
    assert problem.time is not None
    whole, found, value, least_late = _never_resting(problem), None, np.inf, np.inf
    b = _in_time(problem, b)
    for k in range(max(3 * rounds, MANY_ROUNDS)):  # beyond `rounds` while the time is not met
        rows = [_time_tangent(problem, b, problem.time), *tangents(problem, b, limits)]
        limited = replace(whole, bounds=(*whole.bounds, *rows))
        answer = _solved(replace(_with_end(limited), rolled_at=b), sizes_of(problem, b), FINE)
        if not isinstance(answer, Solution):
            break
        turn = TimedTurn(answer, replace(limited, time=None), abs(value - answer.value) / abs(answer.value))
        value = answer.value
        late = float(segment_times(problem.coefficients, answer.b).sum()) / problem.time - 1.0
        if late <= max(LATE, least_late):  # where the rounds leave the time again, the one that has met it best counts
            found, least_late = turn, late
        if late <= LATE and (turn.change <= SETTLED or k + 1 >= rounds):
            break
        b = _in_time(problem, answer.b)
    if found is None:
        raise NoTurnError(
            f"no turn that takes {problem.time:.6g} s was found, which does not prove that there is none: give another time, wider limits,"
            " or path=servo.Stop(), which pauses"
        )
    return found


def _with_end(problem: MotionProblem) -> MotionProblem:
    """The problem of a turn that takes at least its time, with an end of it where one is needed.

    A feed window is what a cycle leaves over, and a mean torque is one over a cycle, for which a turn could wait if its time had no end.
    Time outside the window, and heat, are the same wherever this end is.
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


def _refuse_late(problem: MotionProblem, found: TimedTurn) -> None:
    taken = float(segment_times(problem.coefficients, found.answer.b).sum())
    if problem.time is not None and abs(taken / problem.time - 1.0) > TOO_LATE:
        raise NoTurnError(
            f"no turn that takes {problem.time:.6g} s was found, which does not prove that there is none, but one of {taken:.6g} s: give"
            " this time, or path=servo.Stop(), which pauses"
        )


def _refined(problem: MotionProblem, found: TimedTurn, limits: LocalLimits, most: int) -> TimedTurn:
    """The motion on a finer path."""
    way, b = found.as_motion
    return _rounds(problem, np.interp(problem.coefficients.grid.way_gone, way, b), limits, most)


def _in_time(problem: MotionProblem, b: Array) -> Array:
    """A motion as slow or as fast everywhere as takes its time."""
    assert problem.time is not None
    return b * (float(segment_times(problem.coefficients, b).sum()) / problem.time) ** 2


def _mean_square(problem: MotionProblem) -> float:
    """Square of the mean speed [rad2/s2]."""
    assert problem.time is not None
    return float((np.abs(problem.coefficients.grid.step).sum() / problem.time) ** 2)


def _most(problem: MotionProblem) -> Array:
    """(N + 1,) b that limits of speed leave at the nodes, at both ends of a turn alike; infinite where there is none."""
    most = np.full(len(problem.coefficients.grid.angle), np.inf)
    for each in problem.bounds:
        if each.quantity is None:
            most[each.nodes] = np.minimum(most[each.nodes], each.most)
    most[[0, -1]] = most[[0, -1]].min()
    return most


def _even(problem: MotionProblem) -> Array:
    """An even speed, where limits of speed allow it; a faster one outside a feed window that it would not keep, and a slower one inside."""
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
    """The tangent of the time, which is convex in b and so nowhere below it, is at least this time."""
    speed, h = np.sqrt(b), np.abs(problem.coefficients.grid.step)
    total = speed[1:] + speed[:-1]
    slopes = [-h / (total**2 * each) for each in (speed[:-1], speed[1:])]
    level = 2.0 * h / total - slopes[0] * b[:-1] - slopes[1] * b[1:]
    quantity = Affine(-slopes[0], -slopes[1], 2.0 * time / len(h) - level, np.arange(len(h)))
    return Bounded("", np.full(len(h), time), time, "s", quantity, total=True)


def _passing_the_mean_speed(problem: MotionProblem) -> tuple[float, Array | None]:
    """The least bound of all motions within the time whose speed falls past the mean speed in some segment, and the motion that has it."""
    mean, most, sizes = _mean_square(problem), _most(problem), first_sizes(problem)
    least, motion = np.inf, None
    for k in np.flatnonzero(most[:-1] >= mean * (1.0 - 1e-9)).tolist():
        before = Affine(np.array([-1.0 / mean]), np.zeros(1), np.array([2.0]), np.array([k]))
        rows = Bounded("", np.ones(1), 1.0, "", before), Bounded("", np.array([mean]), 1.0, "", nodes=np.array([k + 1]))
        passing = replace(problem, bounds=(*problem.bounds, *rows))
        found = _solved(passing, sizes, ROUGH)
        if not isinstance(found, Solution):  # that there is none is believed at a close tolerance alone
            found = _solved(passing, first_sizes(problem), CLOSE)
        if found is None:
            continue
        if isinstance(found, UnsolvedError):
            return -np.inf, motion
        sizes = sizes_of(problem, found.b)
        if found.bound < least:
            least, motion = found.bound, found.b
    return (least, motion) if motion is not None else (-np.inf, None)


def _solved(problem: MotionProblem, sizes: Sizes, tolerance: float) -> Solution | UnsolvedError | None:
    """The optimum; None where the solver proved that there is none."""
    failed: UnsolvedError | None = None
    for times in (1.0, 3.0):
        try:
            return solve(problem, sizes.with_torques(times), tolerance=tolerance)
        except InfeasibleError:
            return None
        except UnsolvedError as error:
            failed = error
    return failed


def _in_words(problem: MotionProblem, free: Solution, found: TimedTurn, gap: float, limits: LocalLimits, proof: str) -> str:
    b, faster = found.answer.b, segment_times(problem.coefficients, free.b).sum()
    beside = words_of(problem, limits)
    kept = f", with {' and '.join(beside)}," if beside else ""
    slow = int(b.argmin())
    floor = (
        f"; it is slowest at crank angle {np.degrees(found.limited.coefficients.grid.angle[slow]):.4g} deg, a tenth of its mean speed or of"
        " the limit there, below which a turn counts as a rest"
        if b[slow] < 1.01 * SLOWEST**2 * _mean_square(problem)
        else ""
    )
    settled = "" if found.change <= NEARLY else f"; rounds of tangents did not settle to less than {100 * found.change:.2g} %"
    less = 100 * (1.0 - free.value / found.answer.value)
    return (
        f"a turn that takes {problem.time:.6g} s{kept} is not convex, since a faster one, of {faster:.4g} s, would need {less:.2g} % less"
        f" a stroke: the motion is the best near it; of all turns in this time none is better by more than {100 * gap:.2g} %, {proof}"
        f"{floor}{settled}"
    )
