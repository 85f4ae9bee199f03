"""Solvers of balancing problems on one machine in one run: Clarabel, which `pinpress.balancing.balance` uses, HiGHS, and a step-by-step
search.

python tests/benchmarks/speed/balancing.py

All get the same series, made before the clock starts. HiGHS (SciPy) solves linear programs, so circles are polygons to it; its program has
all states. The search, SciPy's SLSQP from the start of Zhang 2007, Table 5-1, minimises the range as that does: by its slope.
"""

import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.optimize import linprog, minimize

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks.stopwatch import least as least_seconds

import pinpress as pp
from pinpress.balancing.problem import BalancingProblem, build_problem
from pinpress.balancing.program import objective_value, solve
from pinpress.common.conic_program import AT_MOST, CONE

SIDES = 64  # of a circle
REPEATED = 7


def problems() -> dict[str, tuple[BalancingProblem, pp.balancing.Range]]:
    vertical, horizontal = pp.balancing.Range("shaking_force", "z"), pp.balancing.Range("shaking_force", "x")
    crank_press, six_bar = pp.load("jf75g_125"), pp.load("zxn2_3000b")
    fast, slow = pp.cycle(crank_press, 300 * pp.RPM, points=720), pp.cycle(six_bar, 70 * pp.RPM, points=720)
    masses = [
        pp.balancing.CounterweightRegion("auxiliary_rod", replaces=True),
        pp.balancing.CounterweightRegion("counterweight", replaces=True),
    ]
    points = [
        pp.balancing.CounterweightRegion("crank", at=(-0.1428, 0, 0), mass=(0, 700)),
        pp.balancing.CounterweightRegion("rod", at=(-0.0456, 0, 0), mass=(0, 700)),
    ]
    circles = [
        pp.balancing.CounterweightRegion("crank", radius=0.1428, mass=(0, 700)),
        pp.balancing.CounterweightRegion("rod", radius=0.0456, mass=(0, 700)),
    ]
    return {
        "JF75G-125, two masses": (build_problem(crank_press, [pp.balancing.OperatingCondition(fast)], masses, [vertical]), vertical),
        "ZXN2, two points": (build_problem(six_bar, [pp.balancing.OperatingCondition(slow)], points, [horizontal]), horizontal),
        "ZXN2, two circles": (build_problem(six_bar, [pp.balancing.OperatingCondition(slow)], circles, [horizontal]), horizontal),
    }


def by_highs(problem: BalancingProblem) -> np.ndarray:
    """Largest less smallest value of the one signal as a linear program over all states; circles from inside."""
    (signal,) = problem.signals
    effects, fixed, count = signal.effects[:, 0], signal.fixed[:, 0], signal.effects.shape[2]
    ones = np.ones((len(fixed), 1))
    above, right = [np.hstack([effects, -ones, 0 * ones]), np.hstack([-effects, 0 * ones, ones])], [-fixed, fixed]
    for part in problem.rows:
        matrix, bound = part.matrix, part.bound
        if part.kind == CONE:  # mass, and the two mass moments
            corners = 2 * np.pi * np.arange(SIDES) / SIDES
            inside = math.cos(np.pi / SIDES)
            matrix = np.array([inside * matrix[0] - math.cos(c) * matrix[1] - math.sin(c) * matrix[2] for c in corners])
            bound = np.zeros(SIDES)
        else:
            assert part.kind == AT_MOST
        above.append(np.hstack([matrix, np.zeros((len(matrix), 2))]))
        right.append(bound)
    cost = np.append(np.zeros(count), [1.0, -1.0])
    found = linprog(cost, np.concatenate(above), np.concatenate(right), bounds=[(None, None)] * len(cost))
    assert found.success, found.message
    return np.asarray(found.x[:count])


def by_search(problem: BalancingProblem) -> tuple[np.ndarray, int]:
    """SLSQP on the range itself, from 100 and 1000 kg; and how often it asked for the range."""
    (signal,) = problem.signals
    u = np.array([100.0, 1000.0]) / problem.mass[0]

    def slope(u: np.ndarray) -> np.ndarray:
        series = signal.at(u)[:, 0]
        return np.asarray(signal.effects[series.argmax(), 0] - signal.effects[series.argmin(), 0])

    found = minimize(lambda u: float(np.ptp(signal.at(u))), u, jac=slope, method="SLSQP", options={"ftol": 1e-15, "maxiter": 1000})
    return found.x, found.nfev


QUICK = {"REPEATED": 1}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    print(f"{'':24}{'solver':>12}{'range [N]':>16}{'proven bound':>16}{'time [ms]':>11}{'ratio':>8}")
    for name, (problem, measure) in problems().items():
        size, asked = problem.signals[0].size, {measure: 1.0}
        design = solve(problem, asked, {})
        solvers: dict[str, Callable[[], np.ndarray]] = {
            "pinpress": lambda: solve(problem, asked, {}).variables,  # noqa: B023 (all are called within the loop)
            "HiGHS": lambda: by_highs(problem),  # noqa: B023
        }
        if "JF75G" in name:
            solvers["search"] = lambda: by_search(problem)[0]  # noqa: B023
        times = least_seconds(list(solvers.values()), REPEATED)
        for (solver, found), seconds in zip(solvers.items(), times, strict=True):
            value, bound = size * objective_value(problem, asked, found()), f"{size * design.bound:.8g}" if solver == "pinpress" else ""
            print(f"{name:24}{solver:>12}{value:16.8g}{bound:>16}{1e3 * seconds:11.2f}{seconds / times[0]:8.2f}")
        if "JF75G" in name:
            u, asked_for = by_search(problem)
            masses = ", ".join(f"{mass:.4f} kg" for mass in problem.mass[0] * u)
            print(f"{'':24}the search stops at {masses} after {asked_for} ranges")


if __name__ == "__main__":
    main()
