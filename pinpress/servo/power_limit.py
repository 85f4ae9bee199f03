"""A largest power of the motor: torque x speed is no convex function of b. Found is a motion that keeps it, and a bound for all motions.

A motion within the limit comes from convex programs: 2 P / (v_i + v_{i+1}), the torque that the power allows at the speeds of a segment's
ends, is convex in b, so that its tangent at the last motion is below it; each program's motion keeps the limit, and the next is no worse.
The bound comes from a program that allows the power over the relaxed time 2 h d of a segment, which is at least its time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..common.errors import PinpressError
from ..common.quantities import Array
from .motion_problem import Affine, Bounded, MotionProblem
from .program import Solution

MOST_ROUNDS = 40
SETTLED = 1e-9  # relative change of the value that ends the rounds
KEPT = 1e-9  # share by which the power may be exceeded
NAME = "power of the motor of {:.6g} W"


def within_power(
    problem: MotionProblem, free: Solution, power: float, optimum: Callable[[MotionProblem], Solution]
) -> tuple[Solution, MotionProblem, list[str]]:
    """A motion that keeps the power, with the bound of the program without it.

    Args:
        problem: the problem without the power.
        free: its optimum.
        power: largest power [W].
        optimum: solves a convex problem; raises PinpressError where it has no solution.

    Raises:
        PinpressError: no motion within the power was found.
    """
    if powers(problem, free.b).max() <= power * (1.0 + KEPT):
        return free, problem, []
    b, answer, limited = _slower(problem, free.b, power), None, problem
    value = np.inf
    for _ in range(MOST_ROUNDS):
        limited = replace(problem, bounds=(*problem.bounds, *_tangents(problem, b, power)))
        try:
            answer = optimum(limited)
        except PinpressError as error:
            raise PinpressError(
                f"no motion within a power of {power:.6g} W was found, which does not prove that there is none; without that limit the"
                f" motor needs {powers(problem, free.b).max():.6g} W: give more power or time ({error})"
            ) from error
        b = answer.b
        if abs(value - answer.value) <= SETTLED * abs(answer.value):
            break
        value = answer.value
    assert answer is not None
    gap = (answer.value - free.bound) / abs(answer.value)
    note = (
        f"power is not convex: the motion keeps {power:.6g} W, and is the best near it; of all motions, none is better by more than"
        f" {100 * gap:.3g} %"
    )
    return replace(answer, bound=free.bound), limited, [note]


def powers(problem: MotionProblem, b: Array) -> Array:
    """(N,) largest size of the mean torque of each segment times the mean speed [W]."""
    speed = 0.5 * (np.sqrt(b[1:]) + np.sqrt(b[:-1]))
    torque = problem.mean_torque().at(b) + problem.drive.crank_drag * problem.coefficients.grid.way * speed
    return np.abs(torque) * speed


def _slower(problem: MotionProblem, b: Array, power: float) -> Array:
    """A motion about which the first tangents are drawn: as fast as the power allows at the torques of the free motion."""
    over = np.maximum(powers(problem, b) / power, 1.0)
    nodes = np.maximum(np.append(over, 1.0), np.append(1.0, over))
    return np.where(problem.coefficients.grid.rest, 0.0, b / nodes)


def _tangents(problem: MotionProblem, b: Array, power: float) -> list[Bounded]:
    """Driving and braking torque below the tangent of what the power allows; the drag of the drive counts at the speed of b."""
    speed = np.sqrt(b)
    total = speed[1:] + speed[:-1]
    allowed = 2.0 * power / total
    with np.errstate(divide="ignore"):  # at a rest b is no variable
        slopes = [np.where(each > 0, -power / (total**2 * each), 0.0) for each in (speed[:-1], speed[1:])]
    level = allowed - slopes[0] * b[:-1] - slopes[1] * b[1:]
    mean, found = problem.mean_torque(), []
    drag = 0.5 * problem.drive.crank_drag * problem.coefficients.grid.way * total
    for sign in (1.0, -1.0):
        before, after = sign * mean.before - slopes[0], sign * mean.after - slopes[1]
        quantity = Affine(before, after, sign * (mean.fixed + drag), mean.segments)
        found.append(Bounded(NAME.format(power), level, power, "W", quantity))
    return found
