"""Best motions of servo presses on one machine in one run: how long a proved motion takes, and other solvers beside it.

python tests/benchmarks/benchmark_servo.py

Times are those of the process's CPU, one thread, the median of several runs; everything from the press to the proved motion is in them,
with the check by full inverse dynamics. SLSQP (SciPy) gets the same nodes and coefficients, made before its clock starts, and exact
gradients. toppra (`pip install toppra`) finds the least time of one press with a torque and a speed limit, which is what it can do of
these: it knows no heat, energy, root mean square or window of time.
"""

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import importlib.util
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from support.oracles import servo_by_hand

import pinpress as pp
from pinpress import servo

REPEATED = 7
FULL = 2 * np.pi


def seconds(work: Callable[[int], object]) -> float:
    """Median CPU time of a call; each gets its number, so that nothing is kept from the last one."""
    work(-1)
    found = []
    for k in range(REPEATED):
        start = time.process_time()
        work(k)
        found.append(time.process_time() - start)
    return median(found)


def task(name: str) -> tuple[pp.Linkage, servo.ServoDrive, list[pp.loads.DeepDrawing], float]:
    """A shipped press that draws over a fifth of its stroke, once a second, with a drive of about its own inertia."""
    press = pp.load(name)
    stroke, slide = pp.dead_centres(press).stroke, press.model.inertias[press.slide_guide.joint + 1].mass
    loads = [pp.loads.DeepDrawing(200.0 * slide, 0.2 * stroke)]
    motion = pp.cycle(press, FULL, points=60)
    torque = np.abs(pp.inverse_dynamics(press, motion, loads, bearings=()).driving_torque).max()
    return press, servo.ServoDrive(inertia=0.3 * torque / FULL**2), loads, 0.6 * np.abs(motion.slide_velocity).max()


def all_presses() -> None:
    print("least heat, 720 segments, coefficients and check included")
    for name in pp.presses():
        press, drive, loads, speed = task(name)
        heights = (0.2 * pp.dead_centres(press).stroke, 0.0)

        def best(k: int) -> servo.MotionOptimum:
            limits = [servo.SlideSpeed(speed * (1.0 + 1e-4 * k), heights)]  # noqa: B023  called before the next press
            return servo.best_motion(press, drive, loads, time=1.0, limits=limits)  # noqa: B023

        taken, found = seconds(best), best(-1)
        print(f"  {name:24}{1e3 * taken:7.0f} ms, gap {found.gap:.1e}, heat between nodes {found.deviation:+.1e}")


def trade_off() -> None:
    press, loads = pp.load("zxn2_3000b"), [pp.loads.DeepDrawing(1.5e6, 0.06)]
    drive, limits = servo.ServoDrive(inertia=800), [servo.SlideSpeed(0.2, (0.06, 0.0))]
    start = time.process_time()
    servo.trade_off(press, drive, loads, times=np.linspace(2.0, 4.0, 20), limits=limits)
    print(f"20 times of a cycle, zxn2_3000b, 720 segments: {time.process_time() - start:.2f} s")


def beside_slsqp() -> None:
    print("least heat of zxn2_3000b, 60 segments, beside SLSQP")
    press, loads = pp.load("zxn2_3000b"), [pp.loads.DeepDrawing(1.5e6, 0.06)]
    drive, limits = servo.ServoDrive(inertia=800), [servo.SlideSpeed(0.2, (0.06, 0.0))]

    def best(k: int) -> servo.MotionOptimum:
        return servo.best_motion(press, drive, loads, time=2.4 + 1e-4 * (k + 1), limits=limits, points=60)

    found = best(-1)
    hand = servo_by_hand.Press(press, 800.0, loads)
    height, travel = hand.slide(found.angle[:-1])
    inside = (height <= 0.06 + 1e-9) & (travel < -1e-9)
    most = np.where(inside, (0.2 / np.where(inside, travel, 1.0)) ** 2, np.inf)
    inner = np.repeat([[0.5 - 0.5 / 3**0.5], [0.5 + 0.5 / 3**0.5]], len(height), axis=1)
    start = time.process_time()
    _, heat = servo_by_hand.least_heat(hand, found.angle, inner, 2.4, most, np.minimum(np.full(len(height), 9.9), 0.9 * most))
    slsqp = time.process_time() - start
    print(f"  proved {1e3 * seconds(best):7.0f} ms, gap {found.gap:.1e}")
    print(f"  SLSQP  {1e3 * slsqp:7.0f} ms, heat {heat / found.value - 1:+.1e} of the proved one, no bound")


def beside_toppra() -> None:
    if importlib.util.find_spec("toppra") is None:
        print("toppra is not installed: pip install toppra")
        return
    import toppra
    from toppra import algorithm, constraint

    toppra.setup_logging("ERROR")
    press, inertia, torque, fastest = pp.load("zxn2_3000b"), 800.0, 1.5e5, 8.0
    top = pp.dead_centres(press).top_angle
    nodes = top + np.linspace(0.0, FULL, 721)
    mass, slope, fixed = servo_by_hand.Press(press, inertia).at(nodes)

    def needed(q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        m, dm, g = (np.interp(q[0], nodes, values) for values in (mass, slope, fixed))
        return np.array([m * qdd[0] + 0.5 * dm * qd[0] ** 2 + g])

    path = toppra.SplineInterpolator([0.0, FULL], [[top], [top + FULL]])
    limits = [
        constraint.JointVelocityConstraint(np.array([[-fastest, fastest]])),
        constraint.JointTorqueConstraint(needed, np.array([[-torque, torque]]), np.zeros(1)),
    ]

    def by_toppra(k: int) -> float:
        found = algorithm.TOPPRA(limits, path, gridpoints=nodes - top, solver_wrapper="seidel").compute_trajectory(0, 0)
        return float(found.duration)

    drive = servo.ServoDrive(inertia=inertia, peak_torque=torque, top_speed=fastest)

    def best(k: int) -> float:
        return servo.best_motion(press, drive, minimise="time", path=servo.Stop()).value

    exact = servo.best_motion(press, drive, minimise="time", path=servo.Stop(), points=5760).value
    print("least time of zxn2_3000b from rest to rest, torque and speed limited, 720 segments; error against 5760 segments")
    for name, work in (("pinpress", best), ("toppra", by_toppra)):
        print(f"  {name:9}{1e3 * seconds(work):7.0f} ms, {work(-1):.6f} s, {work(-1) / exact - 1:+.1e}")


def main() -> None:
    all_presses()
    trade_off()
    beside_slsqp()
    beside_toppra()


if __name__ == "__main__":
    main()
