"""Limits that are not convex in b: the largest power of the motor, and the largest rate of its torque.

Another is a curve of torque that falls with the speed (`torque_curve`). The module finds a motion within the limits, and a bound for all
motions.

The motion comes from convex programs. At the speeds of a segment's ends the power P allows the torque 2 P / (v_i + v_{i+1}). This is convex
in b, so its tangent at the last motion is below it. Each program's motion therefore keeps the limit, and no motion is worse than the one
before. The rate allows a change of torque proportional to the time between two segments, which is convex too.

The bound for the power comes from programs that allow the power over the relaxed time 2 h d of a segment, which is at least its time. This
bound alone is weak, because a program may give a segment more time than its speeds need. So the programs enclose b at the nodes under load:
they compute the least and the largest b of all motions that are no worse than the motion found. Within this range 1 / v is below its chord,
which limits d. The next round starts with these narrower ranges.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.conic_program import InfeasibleError, UnsolvedError
from ...common.errors import PinpressError
from ...common.quantities import Array
from .motion_problem import Affine, Bounded, MotionProblem, RelaxedPower, segment_times
from .program import Sizes, Solution, sizes_of, solve
from .torque_curve import curve_tangents, curve_use

MOST_ROUNDS, FEW_ROUNDS = 40, 3  # rounds of tangents; few if loads depend on the speed, because those have separate rounds
SETTLED = 1e-8  # relative change of the value that ends the rounds
KEPT = 1e-9  # share by which a motion may exceed the power
ENCLOSED = 8  # most rounds that enclose b
PROVED = 5e-4  # a gap below this ends the rounds
MOST_WORK = 5000  # above this product of loaded nodes and segments b is not enclosed: each node takes two programs a round
NARROW = 1.02  # a range of b whose ends have a smaller ratio is not narrowed further
NEAR = 0.97  # a segment that uses more than this share of the power counts as loaded
SLOWER = 0.8, 0.7, 0.6, 0.5, 0.3  # factors of b, tried in turn if tangents at b leave no motion
RATE = "a rate of torque of {:.6g} N m/s"
NAME = "power of the motor of {:.6g} W"


class LocalLimits(NamedTuple):
    """Limits that are not convex.

    Attributes:
        power: largest power [W], or None.
        rate: largest rate of the torque at the crank [N m/s], or None.
        proved: whether to compute a bound for all motions within the power.
    """

    power: float | None
    rate: float | None
    proved: bool = True


def within_local_limits(
    problem: MotionProblem,
    free: Solution,
    limits: LocalLimits,
    optimum: Callable[[MotionProblem], Solution],
    start: Array | None = None,
) -> tuple[Solution, MotionProblem, list[str]]:
    """Find a motion within limits that are not convex, with a bound for all motions within them.

    Args:
        problem: the problem without these limits.
        free: the optimum of this problem.
        limits: the limits.
        optimum: solves a convex problem; raises PinpressError if there is no solution.
        start: (N + 1,) b of the motion at which the first tangents touch, or None.

    Returns:
        The motion with the bound, the last convex problem, and notes on the proof.

    Raises:
        PinpressError: no motion within the power or the rate was found.
    """
    power, proved = limits.power, limits.proved
    powerful = power is not None and powers(problem, free.b).max() > power * (1.0 + KEPT)
    if not exceeds_limits(problem, free.b, limits):
        return free, problem, []
    words = words_of(problem, limits, free.b)
    them, are = ("them", "are") if len(words) > 1 else ("it", "is")
    answer, limited, settled = _by_tangents(problem, free, limits, optimum, " and ".join(words), start)
    if not powerful or power is None or not proved:
        gap = (answer.value - free.bound) / abs(answer.value)
        note = (
            f"{' and '.join(words)} {are} not convex: the motion keeps {them} and is the best of its neighbours; no motion, even without"
            f" {them}, is better by more than {100 * gap:.2g} %{settled}"
        )
        return replace(answer, bound=free.bound), limited, [note]
    bound, rounds, loaded = _bound(problem, free, answer, power)
    gap = (answer.value - bound) / abs(answer.value)
    how = f"by {rounds} rounds of enclosing the speeds of {loaded} nodes" if rounds else "by one relaxed program"
    more = "; fewer points= give a smaller gap" if loaded and not rounds and gap > PROVED else ""
    note = (
        f"{' and '.join(words)} {are} not convex: the motion keeps {them} and is the best of its neighbours; no motion is better by more"
        f" than {100 * gap:.2g} %, proved {how}{more}{settled}"
    )
    return replace(answer, bound=bound), limited, [note]


def _by_tangents(
    problem: MotionProblem,
    free: Solution,
    limits: LocalLimits,
    optimum: Callable[[MotionProblem], Solution],
    words: str,
    start: Array | None,
) -> tuple[Solution, MotionProblem, str]:
    """The best motion of its neighbours within the limits, its last convex problem, and a text if the rounds did not converge."""
    b = start if start is not None else free.b if limits.power is None else _slower(problem, free.b, limits.power)
    answer, limited, value, slower = None, problem, np.inf, 0
    settled = "" if start is not None else f"; {MOST_ROUNDS} rounds of tangents did not converge, so a neighbour may be better"
    for _ in range(MOST_ROUNDS if start is None else FEW_ROUNDS):
        limited = replace(problem, bounds=(*problem.bounds, *tangents(problem, b, limits)))
        try:
            answer = optimum(limited)
        except PinpressError as error:
            slower += 1
            if answer is None and slower <= len(SLOWER):
                b = SLOWER[slower - 1] * b  # the tangents touch a motion far above the limits
                continue
            raise PinpressError(
                f"no motion within {words} was found, though one may exist; without this limit the motor has a power of"
                f" {powers(problem, free.b).max():.6g} W, and its torque changes by"
                f" {torque_rates(problem, free.b).max() / problem.drive.ratio:.6g} N m/s: give a larger limit, or more time"
            ) from error
        b = answer.b
        if abs(value - answer.value) <= SETTLED * abs(answer.value):
            settled = ""
            break
        value = answer.value
    if answer is None:
        raise PinpressError(
            f"no motion within {words} was found near the last motion, though one may exist: give a larger limit, or more time"
        )
    return answer, limited, settled


def tangents(problem: MotionProblem, b: Array, limits: LocalLimits) -> list[Bounded]:
    """Convex limits that lie within these limits, by tangents at a motion."""
    rows = [] if problem.drive.curve_torque is None else curve_tangents(problem, b)
    rows += [] if limits.power is None else _power_tangents(problem, b, limits.power)
    return rows + ([] if limits.rate is None else _rate_tangents(problem, b, limits.rate))


def exceeds_limits(problem: MotionProblem, b: Array, limits: LocalLimits) -> bool:
    """Whether a motion exceeds one of the limits."""
    return bool(words_of(problem, limits, b))


def words_of(problem: MotionProblem, limits: LocalLimits, b: Array | None = None) -> list[str]:
    """The limits as text; with b only the limits that this motion exceeds."""
    power, rate, drive = limits.power, limits.rate, problem.drive
    texts = []
    if power is not None and (b is None or powers(problem, b).max() > power * (1.0 + KEPT)):
        texts.append(f"a power of {power:.6g} W")
    if drive.curve_torque is not None and (b is None or curve_use(problem, b).max() > 1.0 + KEPT):
        texts.append("a torque below the motor's curve")
    if rate is not None and (b is None or torque_rates(problem, b).max() > rate * (1.0 + KEPT)):
        texts.append(RATE.format(rate / problem.drive.ratio))
    return texts


def powers(problem: MotionProblem, b: Array) -> Array:
    """(N,) largest absolute mean torque of each segment times its mean speed [W]."""
    speed = 0.5 * (np.sqrt(b[1:]) + np.sqrt(b[:-1]))
    torque = problem.mean_torque().at(b) + problem.drive.crank_drag * problem.coefficients.grid.way * speed
    return np.abs(torque) * speed


def torque_rates(problem: MotionProblem, b: Array) -> Array:
    """(N,) absolute change of mean torque from a segment to the next / time between their middles [N m/s]; 0 over rests."""
    pairs = _Pairs(problem)
    times = segment_times(problem.coefficients, b)
    torque = problem.mean_torque().at(b)
    change = np.abs(torque[pairs.second] - torque[pairs.first]) / (0.5 * (times[pairs.first] + times[pairs.second]))
    return np.asarray(np.append(change, 0.0))


class _Pairs:
    """Segments that follow one another without a dwell between them."""

    def __init__(self, problem: MotionProblem) -> None:
        grid = problem.coefficients.grid
        n = len(grid.step)
        first = np.arange(n if grid.legs.closed else n - 1)
        second = (first + 1) % n
        kept = (grid.leg[first] == grid.leg[second]) | (grid.legs.dwells[grid.leg[first]] == 0)
        self.first, self.second = first[kept], second[kept]


def _rate_tangents(problem: MotionProblem, b: Array, rate: float) -> list[Bounded]:
    """Changes of torque below the tangent of rate x time between the middles of two segments, which is convex in b."""
    pairs, mean, grid = _Pairs(problem), problem.mean_torque(), problem.coefficients.grid
    speed, h = np.sqrt(b), np.abs(grid.step)
    total = speed[1:] + speed[:-1]
    times = 2.0 * h / total
    with np.errstate(divide="ignore"):  # at a rest b is no variable
        slopes = [np.where(each > 0, -h / (total**2 * each), 0.0) for each in (speed[:-1], speed[1:])]
    first, second, bounds = pairs.first, pairs.second, []
    half = 0.5 * rate
    level = half * sum(times[k] - slopes[0][k] * b[k] - slopes[1][k] * b[k + 1] for k in (first, second))
    for sign in (1.0, -1.0):
        before = -sign * mean.before[first] - half * slopes[0][first]
        middle = sign * (mean.before[second] - mean.after[first]) - half * (slopes[1][first] + slopes[0][second])
        after = sign * mean.after[second] - half * slopes[1][second]
        quantity = Affine(before, middle, sign * (mean.fixed[second] - mean.fixed[first]), first, after, second + 1)
        bounds.append(Bounded(RATE.format(rate / problem.drive.ratio), level, rate / problem.drive.ratio, "N m/s", quantity))
    return bounds


def _slower(problem: MotionProblem, b: Array, power: float) -> Array:
    """The motion at which the first tangents touch: as fast as the power allows at the torques of the free motion."""
    over = np.maximum(powers(problem, b) / power, 1.0)
    nodes = np.maximum(np.append(over, 1.0), np.append(1.0, over))
    return np.where(problem.coefficients.grid.rest, 0.0, b / nodes)


def _power_tangents(problem: MotionProblem, b: Array, power: float) -> list[Bounded]:
    """Limits of driving and braking torque by the tangent of the torque that the power allows; with the drive's drag at the speed of b."""
    speed = np.sqrt(b)
    total = speed[1:] + speed[:-1]
    allowed = 2.0 * power / total
    with np.errstate(divide="ignore"):  # at a rest b is no variable
        slopes = [np.where(each > 0, -power / (total**2 * each), 0.0) for each in (speed[:-1], speed[1:])]
    level = allowed - slopes[0] * b[:-1] - slopes[1] * b[1:]
    mean, bounds = problem.mean_torque(), []
    drag = 0.5 * problem.drive.crank_drag * problem.coefficients.grid.way * total
    for sign in (1.0, -1.0):
        before, after = sign * mean.before - slopes[0], sign * mean.after - slopes[1]
        quantity = Affine(before, after, sign * (mean.fixed + drag), mean.segments)
        bounds.append(Bounded(NAME.format(power), level, power, "W", quantity))
    return bounds


# ------------------------------------------------------------------------------------------------------------- a bound for all motions


def _bound(problem: MotionProblem, free: Solution, best: Solution, power: float) -> tuple[float, int, int]:
    """A bound of the objective of all motions within the power, the rounds that it took, and the number of nodes under load."""
    grid, sizes = problem.coefficients.grid, sizes_of(problem, best.b)
    relaxed = RelaxedPower(power, np.zeros(len(grid.angle)), np.full(len(grid.angle), np.inf))
    bound, found = free.bound, _solved(replace(problem, power=relaxed), sizes)
    if found is None:
        return bound, 0, 0
    bound = max(bound, found.bound)
    loaded = _loaded_nodes(problem, found.b, best.b, power)
    if len(loaded) * len(grid.step) > MOST_WORK:
        return bound, 0, len(loaded)
    rounds, scale = 0, abs(best.value)
    ceiling = best.value + 1e-7 * scale
    while rounds < ENCLOSED and best.value - bound > PROVED * scale:
        for node in loaded:  # every node uses the ranges computed so far
            relaxed = _enclose(replace(problem, power=relaxed, ceiling=ceiling), relaxed, sizes, int(node))
        rounds += 1
        found = _solved(replace(problem, power=relaxed), sizes)
        if found is None:
            break
        before, bound = bound, max(bound, found.bound)
        loaded = np.union1d(loaded, _loaded_nodes(problem, found.b, best.b, power))
        if len(loaded) * len(grid.step) > MOST_WORK:
            break
        if rounds > 3 and bound - before < 0.05 * (best.value - before):
            break
    return min(bound, best.value), rounds, len(loaded)


def _enclose(problem: MotionProblem, relaxed: RelaxedPower, sizes: Sizes, node: int) -> RelaxedPower:
    """The ranges of b, after two programs have narrowed the range at a node."""
    if relaxed.most[node] < NARROW * relaxed.least[node]:
        return relaxed
    low, high = _solved(problem, sizes, (node, 1.0)), _solved(problem, sizes, (node, -1.0))
    if low is None or high is None or not low.bound < -high.bound:
        return relaxed
    least, most = relaxed.least.copy(), relaxed.most.copy()
    same = [0, -1] if node == 0 and problem.coefficients.grid.legs.closed else [node]
    least[same], most[same] = max(least[node], low.bound), min(most[node], -high.bound)
    return RelaxedPower(relaxed.power, least, most)


def _loaded_nodes(problem: MotionProblem, relaxed: Array, best: Array, power: float) -> NDArray[np.intp]:
    """Nodes of segments that use the power in the best or the relaxed motion, and the nodes next to them."""
    segments = (powers(problem, relaxed) > power * (1.0 + 1e-6)) | (powers(problem, best) > NEAR * power)
    nodes = np.append(segments, False) | np.append(False, segments)
    nodes[:-1] |= nodes[1:]  # one more on each side, where a relaxed time would be stretched next
    nodes[1:] |= nodes[:-1].copy()
    if problem.coefficients.grid.legs.closed:
        nodes[0] |= nodes[-1]
        nodes[-1] = False
    return np.flatnonzero(nodes & ~problem.coefficients.grid.rest)


def _solved(problem: MotionProblem, sizes: Sizes, extreme: tuple[int, float] | None = None) -> Solution | None:
    try:
        return solve(problem, sizes, extreme=extreme)
    except (InfeasibleError, UnsolvedError):
        return None
