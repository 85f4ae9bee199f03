"""The optimum of a convex problem of motion, proved by its dual cost."""

from __future__ import annotations

import contextlib
from dataclasses import replace

import numpy as np

from ...common.conic_program import InfeasibleError, UnsolvedError
from ...common.errors import PinpressError
from .motion_problem import MotionProblem
from .program import REMEDY, Solution, first_sizes, sizes_of, solve

PROVED = 1e-7  # with a larger gap the program is solved again, scaled by its last motion
FAR = 1e-3  # a convex program with a larger gap counts as not solved


class NoMotionError(PinpressError):
    """No motion keeps the limits."""


def optimum(problem: MotionProblem) -> Solution:
    """The optimum of a convex problem; after a bad proof the program is solved again, scaled by its last motion.

    Raises:
        NoMotionError: no motion keeps the limits.
        PinpressError: the program was not solved.
    """
    name, best, sizes = problem.coefficients.press_name, None, first_sizes(problem)
    for _ in range(3):
        try:
            new = solve(problem, sizes)
        except InfeasibleError:
            if best is None:
                raise NoMotionError(f"no motion of {name} keeps the limits") from None
            break
        except UnsolvedError as error:
            if best is None:
                raise PinpressError(f"the best motion of {name} was not found: {error}") from None
            break
        if best is None or abs(new.gap) < abs(best.gap):
            best = new
        if abs(best.gap) <= PROVED:
            return best
        sizes = sizes_of(problem, best.b)
    assert best is not None
    if loses_by_speed(problem):
        return _with_losses(problem, best) if best.gap > PROVED else best
    if not (abs(best.gap) <= FAR or (best.gap < 0 and problem.drive.curve_torque)):
        raise PinpressError(f"the best motion of {name} was not found: value and bound differ by {best.gap:.1e}; {REMEDY}")
    return best


def loses_by_speed(problem: MotionProblem) -> bool:
    """Whether losses of the drive grow with its speed. Then the program may underestimate them, and the gap is larger than rounding
    errors."""
    return bool(problem.drive.viscous or (problem.drive.iron and "energy" in problem.weights))


def _with_losses(problem: MotionProblem, answer: Solution) -> Solution:
    """The best motion found if losses grow with the speed and the program underestimates them; the bound remains the program's.

    These losses are concave in b, because they follow its root, so they lie below their tangent at any motion. A program with the tangent
    in place of the losses finds a motion that is no worse than the motion at which the tangent touches. The rounds start from the program's
    motion, and a second time from the best motion of a drive without losses.
    """
    without = replace(problem, drive=replace(problem.drive, viscous=0.0, iron=0.0))
    starts, best = [answer.b], answer
    with contextlib.suppress(InfeasibleError, UnsolvedError):
        starts.append(solve(without, sizes_of(problem, answer.b)).b)
    for b in starts:
        value = np.inf
        for _ in range(30):
            try:
                new = solve(replace(problem, rolled_at=b), sizes_of(problem, b))
            except (InfeasibleError, UnsolvedError):
                break
            best = new if new.value < best.value else best
            if not new.value < value - 1e-5 * abs(new.value):
                break
            b, value = new.b, new.value
    return replace(best, bound=answer.bound)
