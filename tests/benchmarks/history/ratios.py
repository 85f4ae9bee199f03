"""Ratios of run times from commit to commit, for asv (`asv.conf.json`): pinpress of each commit beside peers that stay, by the functions of
the other benchmarks as they are today.

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

import pinpress as pp  # that of the commit: the benchmarks below put the checkout in front of it, too late for what is there

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

TURN, CONTEST = 0.005, 5.0  # least time of a turn, time of all turns together [s]


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


def _turn(ours: str, peer: str) -> float:
    """The ratio of two contestants of inverse dynamics at 360 crank angles."""
    from benchmarks.speed.inverse_dynamics import contestants

    work = {name[1]: call for name, _, call, _ in contestants(360)}
    return _ratio(work[ours], work[peer])


def track_forces_at_new_angles() -> float:
    """Torque and all bearing forces of the six-bar at 360 crank angles / the script derived by hand."""
    return _turn("c", "a")


def track_forces_by_the_engine_in_space() -> float:
    """The same by the engine for linkages in space / the script derived by hand."""
    return _turn("d", "a")


def track_forces_by_pinocchio() -> float:
    """The same by the engine on Pinocchio's algorithms / a plain loop with Pinocchio."""
    return _turn("e", "b")


def track_free_run() -> float:
    """A free run of the six-bar over 2 s / a plain loop of 200 Runge-Kutta steps with Pinocchio."""
    from benchmarks.speed import simulation
    from support.oracles.pinocchio_run import free_run

    press = pp.load("zxn2_3000b")
    plain = (simulation.ANGLE, simulation.SPEED, simulation.FLYWHEEL.inertia, simulation.DURATION, 200)
    return _ratio(lambda: simulation.six_bar(press), lambda: free_run(*plain))


def track_operating_point() -> float:
    """A thousand operating points of a map, torque and all bearings / one by inverse dynamics."""
    from benchmarks.speed import sweep

    press, load = pp.load("zxn2_3000b"), pp.loads.DeepDrawing(force=1.0, start=sweep.START)
    speeds = sweep.SPEEDS[::100]  # 10, by 1000 forces
    return (
        _ratio(lambda: pp.sweeps.operating_points(press, speeds, forces=sweep.FORCES, unit_load=load), lambda: sweep.one_by_one(press, 1))
        / 10
    )


def track_balancing() -> float:
    """The proved optimum of two masses on the JF75G-125 / HiGHS on the same linear program."""
    from benchmarks.speed import balancing

    from pinpress.balancing.program import solve

    problem, measure = next(iter(balancing.problems().values()))
    return _ratio(lambda: solve(problem, {measure: 1.0}, {}), lambda: balancing.by_highs(problem))


for _track in [value for name, value in list(globals().items()) if name.startswith("track_")]:
    _track.unit, _track.version = "ratio", "1"  # another version, where what is measured changes: results of the old one end
