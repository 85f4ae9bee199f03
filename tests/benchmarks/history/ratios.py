"""Ratios of run times from commit to commit, for asv (`asv.conf.json`): pinpress of each commit beside peers that stay.

Times are those of the processor with BLAS in one thread, the least of many turns, which both sides take one after the other. Such a ratio
is nearly the same on a fast, a slow and a busy machine. Less is faster.
"""

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy is imported

import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import pinpress as pp  # that of the commit: the tests below put the checkout in front of it, too late for what is there

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

TURN, CONTEST = 0.005, 5.0  # least time of a turn, time of all turns together [s]
SPEED = 70 * 2 * np.pi / 60  # [rad/s]
ANGLES = 2 * np.pi * np.arange(360) / 360


def _ratio(ours: Callable[[], object], peer: Callable[[], object]) -> float:
    """Time of one of our calls by that of one of the peer's."""
    calls, least = {}, {}
    for work in (ours, peer):
        work()
        start = time.process_time()
        work()
        calls[work], least[work] = max(1, round(TURN / (time.process_time() - start))), math.inf
    end = time.process_time() + CONTEST
    while math.isinf(max(least.values())) or time.process_time() < end:
        for work, count in calls.items():
            start = time.process_time()
            for _ in range(count):
                work()
            least[work] = min(least[work], (time.process_time() - start) / count)
    return least[ours] / least[peer]


def _forces(engine: str) -> Callable[[], object]:
    """Torque and all bearing forces of the six-bar at about 360 crank angles, another number of them in each call."""
    import itertools

    press, sizes = pp.load("zxn2_3000b"), itertools.cycle(range(356, 364))

    def work() -> object:
        result = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=next(sizes), engine=engine), engine=engine)
        return result.driving_torque, [(result.bearing_force[name], result.bearing_moment[name]) for name in press.bearings]

    return work


def _script() -> object:
    from support.oracles.six_bar_script import six_bar, world_forces

    return world_forces(six_bar(ANGLES, SPEED, 0.0))


def track_forces_at_new_angles() -> float:
    """Torque and all bearing forces of the six-bar at 360 crank angles / the script derived by hand."""
    return _ratio(_forces("plane"), _script)


def track_forces_by_the_engine_in_space() -> float:
    """The same by the engine for linkages in space / the script derived by hand."""
    return _ratio(_forces("space"), _script)


def track_forces_by_pinocchio() -> float:
    """The same by the engine on Pinocchio's algorithms / a plain loop with Pinocchio."""
    from support.oracles.pinocchio_loop import PinocchioLoop, inverse_dynamics

    loop = PinocchioLoop()
    return _ratio(_forces("pinocchio"), lambda: inverse_dynamics(ANGLES, SPEED, 0.0, loop))


def track_free_run() -> float:
    """A free run of the six-bar over 2 s / a plain loop of 200 Runge-Kutta steps with Pinocchio."""
    from support.oracles.pinocchio_run import free_run

    press, angle, flywheel = pp.load("zxn2_3000b"), math.radians(154.0), pp.drives.Flywheel(500.0)
    return _ratio(
        lambda: pp.simulate(press, 2.0, speed=SPEED, angle=angle, flywheel=flywheel), lambda: free_run(angle, SPEED, 500.0, 2.0, 200)
    )


def track_operating_point() -> float:
    """A thousand operating points of a map, torque and all bearings / one by inverse dynamics."""
    from benchmarks.speed import sweep

    press, speeds = pp.load("zxn2_3000b"), sweep.SPEEDS[::100]  # 10, by 1000 forces
    mapped = _ratio(
        lambda: pp.sweeps.operating_points(press, speeds, forces=sweep.FORCES, unit_load=sweep.UNIT_LOAD),
        lambda: sweep.one_by_one(press, 1),
    )
    return mapped / 10


def track_balancing() -> float:
    """The proved optimum of two masses on the JF75G-125 / HiGHS on the same linear program."""
    from scipy.optimize import linprog

    from pinpress.balancing.problem import build_problem
    from pinpress.balancing.program import solve

    press, measure = pp.load("jf75g_125"), pp.balancing.Range("shaking_force", "z")
    masses = [pp.balancing.CounterweightRegion(link, replaces=True) for link in ("auxiliary_rod", "counterweight")]
    turn = pp.balancing.OperatingCondition(pp.cycle(press, 300 * pp.RPM, points=720))
    problem = build_problem(press, [turn], masses, [measure])
    (signal,) = problem.signals
    effects, fixed = signal.effects[:, 0], signal.fixed[:, 0]
    ones, masses_alone = np.ones((len(fixed), 1)), [np.hstack([part.matrix, np.zeros((len(part.matrix), 2))]) for part in problem.rows]
    rows = np.concatenate([np.hstack([effects, -ones, 0 * ones]), np.hstack([-effects, 0 * ones, ones]), *masses_alone])
    bounds = np.concatenate([-fixed, fixed, *(part.bound for part in problem.rows)])
    cost = np.append(np.zeros(effects.shape[1]), [1.0, -1.0])  # the largest less the smallest value
    return _ratio(
        lambda: solve(problem, {measure: 1.0}, {}), lambda: linprog(cost, rows, bounds, bounds=[(None, None)] * len(cost), method="highs")
    )


for _track in [value for name, value in list(globals().items()) if name.startswith("track_")]:
    _track.unit, _track.version = "ratio", "1"  # another version, where what is measured changes: results of the old one end
