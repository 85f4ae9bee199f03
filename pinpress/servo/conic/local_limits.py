"""Limits that are not convex in b: the largest power of the motor, and the largest rate of its torque.

A curve of torque that falls with the speed is not convex either (`torque_curve`). This module finds a motion within the limits, and a bound
for all motions.

The motion comes from convex programs. At the speeds of a segment's ends the power P allows the torque 2 P / (v_i + v_{i+1}). This is convex
in b, so its tangent at the last motion is below it. Each program's motion therefore keeps the limit, and no motion is worse than the one
before. The rate allows a change of torque proportional to the time between two segments, which is convex too.

The bound for the power comes from programs that allow the power over the relaxed time 2 h d of a segment, which is at least its time. This
bound alone is weak, because a program may give a segment more time than its speeds need. So the programs enclose b at the nodes under load:
they compute the least and the largest b of all motions that are no worse than the motion found. Within this range 1 / v is below its chord,
which limits d. The next round starts with these narrower ranges.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...common.conic_program import InfeasibleError, UnsolvedError
from ...common.errors import PinpressError
from ...common.quantities import Array
from .motion_problem import Affine, Bounded, Index, MotionProblem, RelaxedPower, below_tangents, segment_times
from .optimum import optimum
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


def within_local_limits(
    problem: MotionProblem, free: Solution, proved: bool = True, start: Array | None = None
) -> tuple[Solution, MotionProblem, list[str]]:
    """Find a motion within limits that are not convex, with a bound for all motions within them.

    Args:
        problem: the problem without these limits.
        free: the optimum of this problem.
        proved: whether to compute a bound for all motions within the power.
        start: (N + 1,) b of the motion at which the first tangents touch, or None.

    Returns:
        The motion with the bound, the last convex problem, and notes on the proof.

    Raises:
        PinpressError: no motion within the power or the rate was found.
    """
    words, power = words_of(problem, free.b), problem.drive.power
    if not words:
        return free, problem, []
    them, are = ("them", "are") if len(words) > 1 else ("it", "is")
    answer, limited, settled = _by_tangents(problem, free, " and ".join(words), start)
    kept = f"{' and '.join(words)} {are} not convex: the motion keeps {them} and is the best of its neighbours; no motion"
    if not proved or power is None or not exceeds_power(problem, free.b):
        answer = replace(answer, bound=free.bound)
        return answer, limited, [f"{kept}, even without {them}, is better by more than {100 * answer.gap:.2g} %{settled}"]
    bound, rounds, loaded = _bound(problem, free, answer, power)
    answer = replace(answer, bound=bound)
    how = f"by {rounds} rounds of enclosing the speeds of {loaded} nodes" if rounds else "by one relaxed program"
    more = "; fewer points= give a smaller gap" if loaded and not rounds and answer.gap > PROVED else ""
    return answer, limited, [f"{kept} is better by more than {100 * answer.gap:.2g} %, proved {how}{more}{settled}"]


def _by_tangents(problem: MotionProblem, free: Solution, words: str, start: Array | None) -> tuple[Solution, MotionProblem, str]:
    """The best motion of its neighbours within the limits, its last convex problem, and a text if the rounds did not converge."""
    b = start if start is not None else free.b if problem.drive.power is None else _slower(problem, free.b, problem.drive.power)
    answer, limited, value, slower = None, problem, np.inf, 0
    settled = "" if start is not None else f"; {MOST_ROUNDS} rounds of tangents did not converge, so a neighbour may be better"
    for _ in range(MOST_ROUNDS if start is None else FEW_ROUNDS):
        limited = replace(problem, bounds=(*problem.bounds, *tangents(problem, b)))
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


def tangents(problem: MotionProblem, b: Array) -> list[Bounded]:
    """Convex limits that lie within the limits of power, curve of torque and rate of torque, by tangents at a motion."""
    drive, (torque, speed) = problem.drive, problem.with_drag(b)
    first, last = (np.divide(0.25, root, out=np.zeros_like(root), where=root > 0) for root in (np.sqrt(b[:-1]), np.sqrt(b[1:])))
    rows = [] if drive.curve_torque is None else curve_tangents(drive, torque, speed, (first, last))
    rows += [] if drive.power is None else power_tangents(drive.power, torque, speed, (first, last))
    return rows + ([] if problem.rate is None else _rate_tangents(problem, b, problem.rate))


def power_tangents(power: float, torque: Affine, speed: Array, slopes: tuple[Array, Array]) -> list[Bounded]:
    """Torques below tangents of power / speed; for ``speed`` and ``slopes`` see `below_tangents`."""
    return below_tangents(torque, power / speed, power / speed**2, speed, slopes, (f"power of the motor of {power:.6g} W", power, "W"))


def words_of(problem: MotionProblem, b: Array | None = None) -> list[str]:
    """The limits that are not convex as text; with b only the limits that this motion exceeds."""
    drive, texts = problem.drive, []
    if drive.power is not None and (b is None or exceeds_power(problem, b)):
        texts.append(f"a power of {drive.power:.6g} W")
    if drive.curve_torque is not None and (b is None or curve_use(problem, b).max() > 1.0 + KEPT):
        texts.append("a torque below the motor's curve")
    if problem.rate is not None and (b is None or torque_rates(problem, b).max() > problem.rate * (1.0 + KEPT)):
        texts.append(RATE.format(problem.rate / drive.ratio))
    return texts


def exceeds_power(problem: MotionProblem, b: Array) -> bool:
    """Whether a motion exceeds the largest power of the drive."""
    return problem.drive.power is not None and bool(powers(problem, b).max() > problem.drive.power * (1.0 + KEPT))


def powers(problem: MotionProblem, b: Array) -> Array:
    """(N,) largest absolute mean torque of each segment times its mean speed [W]."""
    torque, speed = problem.with_drag(b)
    return np.abs(torque.at(b)) * speed


def torque_rates(problem: MotionProblem, b: Array) -> Array:
    """(N,) absolute change of mean torque from a segment to the next / time between their middles [N m/s]; 0 over rests."""
    first, second = _pairs(problem)
    times, torque = segment_times(problem.coefficients, b), problem.mean_torque().at(b)
    return np.asarray(np.append(np.abs(torque[second] - torque[first]) / (0.5 * (times[first] + times[second])), 0.0))


def _pairs(problem: MotionProblem) -> tuple[Index, Index]:
    """Segments that follow one another without a dwell between them."""
    grid = problem.coefficients.grid
    n = len(grid.step)
    first = np.arange(n if grid.legs.closed else n - 1)
    second = (first + 1) % n
    kept = (grid.leg[first] == grid.leg[second]) | (grid.legs.dwells[grid.leg[first]] == 0)
    return first[kept], second[kept]


def _rate_tangents(problem: MotionProblem, b: Array, rate: float) -> list[Bounded]:
    """Changes of torque below the tangent of rate x time between the middles of two segments, which is convex in b."""
    (first, second), mean, grid = _pairs(problem), problem.mean_torque(), problem.coefficients.grid
    speed, h = np.sqrt(b), np.abs(grid.step)
    total = speed[1:] + speed[:-1]
    times = 2.0 * h / total
    with np.errstate(divide="ignore"):  # at a rest b is zero and not an unknown
        slopes = [np.where(each > 0, -h / (total**2 * each), 0.0) for each in (speed[:-1], speed[1:])]
    bounds, half = [], 0.5 * rate
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
    nodes[:-1] |= nodes[1:]  # also the neighbours, because the relaxed program would stretch their time next
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
