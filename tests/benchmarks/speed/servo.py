"""Best motions of servo presses on one machine in one run: how long a proved motion takes, and other solvers beside it.

python tests/benchmarks/speed/servo.py

Times are those of the process's CPU, one thread, the least of several runs; everything from the press to the proved motion is in them,
with the check by full inverse dynamics. SLSQP (SciPy) gets the same nodes and coefficients, made before its clock starts, and exact
gradients. toppra (`pip install 'pinpress[peers]'`) finds the least time of one press with a torque and a speed limit, which is what it can
do of these: it knows no heat, energy, root mean square or window of time. To it the press is a robot of one joint, whose reduced inertia,
with the weights, was made before its clock starts. Torques of both motions are looked at between the nodes too.
"""

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import importlib.util
import itertools
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks import stopwatch
from support.oracles import servo_by_energies, servo_by_hand

import pinpress as pp
from pinpress import servo

REPEATED = 7
FULL = 2 * np.pi
PRESSES = pp.presses()
SEGMENTS = (180, 360, 720, 1440)  # of the turn whose time is least


def seconds(work: Callable[[int], object]) -> float:
    """Least CPU time of a call; each gets its number, so that nothing is kept from the last one."""
    number = itertools.count(-1)
    return stopwatch.least([lambda: work(next(number))], REPEATED)[0]


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
    for name in PRESSES:
        press, drive, loads, speed = task(name)
        heights = (0.2 * pp.dead_centres(press).stroke, 0.0)

        def best(k: int) -> servo.MotionOptimum:
            limits = [servo.SlideSpeed(speed * (1.0 + 1e-4 * k), heights)]  # noqa: B023  called before the next press
            return servo.best_motion(press, drive, loads, time=1.0, limits=limits)  # noqa: B023

        taken, found = seconds(best), best(-1)
        print(f"  {name:24}{1e3 * taken:7.0f} ms, gap {found.gap:.1e}, error of the nodes {found.node_error:.1e}")


def trade_off() -> None:
    press, loads = pp.load("zxn2_3000b"), [pp.loads.DeepDrawing(1.5e6, 0.06)]
    drive, limits = servo.ServoDrive(inertia=800), [servo.SlideSpeed(0.2, (0.06, 0.0))]
    _, taken = stopwatch.once(lambda: servo.trade_off(press, drive, loads, times=np.linspace(2.0, 4.0, 20), limits=limits))
    print(f"20 times of a cycle, zxn2_3000b, 720 segments: {taken:.2f} s")


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
    first = np.minimum(np.full(len(height), 9.9), 0.9 * most)
    (_, heat), slsqp = stopwatch.once(lambda: servo_by_hand.least_heat(hand, found.angle, inner, 2.4, most, first))
    print(f"  proved {1e3 * seconds(best):7.0f} ms, gap {found.gap:.1e}")
    print(f"  SLSQP  {1e3 * slsqp:7.0f} ms, heat {heat / found.value - 1:+.1e} of the proved one, no bound")


def beside_toppra() -> None:
    if importlib.util.find_spec("toppra") is None:
        print("toppra is not installed: pip install 'pinpress[peers]'")
        return
    import toppra
    from toppra import algorithm, constraint

    toppra.setup_logging("ERROR")
    press, inertia, torque, fastest = pp.load("zxn2_3000b"), 800.0, 1.5e5, 8.0
    hand, top = servo_by_hand.Press(press, inertia), pp.dead_centres(press).top_angle
    exact = in_phase_plane(press, inertia, torque, fastest)
    drive = servo.ServoDrive(inertia=inertia, peak_torque=torque, top_speed=fastest)
    print(f"least time of zxn2_3000b from rest to rest, torque and speed limited; {exact:.6f} s in the phase plane with 16 000 segments")
    for count in SEGMENTS:
        nodes = top + np.linspace(0.0, FULL, count + 1)
        mass, slope, fixed = hand.at(nodes)

        def needed(q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
            m, dm, g = (np.interp(q[0], nodes, values) for values in (mass, slope, fixed))  # noqa: B023  called before the next count
            return np.array([m * qdd[0] + 0.5 * dm * qd[0] ** 2 + g])

        path = toppra.SplineInterpolator([0.0, FULL], [[top], [top + FULL]])
        limits = [
            constraint.JointVelocityConstraint(np.array([[-fastest, fastest]])),
            constraint.JointTorqueConstraint(needed, np.array([[-torque, torque]]), np.zeros(1)),
        ]

        def by_toppra(k: int) -> np.ndarray:
            found = algorithm.TOPPRA(limits, path, gridpoints=nodes - top, solver_wrapper="seidel")  # noqa: B023
            return np.asarray(found.compute_parameterization(0, 0)[1]) ** 2

        def best(k: int) -> servo.MotionOptimum:
            return servo.best_motion(press, drive, minimise="time", path=servo.Stop(), points=count)  # noqa: B023

        found = best(-1)
        for name, work, angle, b in (("pinpress", best, found.angle, found.speed**2), ("toppra", by_toppra, nodes, by_toppra(-1))):
            taken = float(np.sum(2.0 * np.diff(angle) / (np.sqrt(b[1:]) + np.sqrt(b[:-1]))))
            above = largest_torque(hand, angle, b) / torque - 1.0
            said = f", gap {found.gap:.1e}" if name == "pinpress" else ""
            print(f"  {name:9}{count:5} {1e3 * seconds(work):7.0f} ms, time {taken / exact - 1:+.1e}, torque {100 * above:+.2f} %{said}")


def in_phase_plane(press: pp.Linkage, inertia: float, torque: float, fastest: float) -> float:
    """Least time of a turn from rest to rest, by another method, with many nodes."""
    hand = servo_by_energies.Press(press)
    turns = [hand.top, hand.top + FULL]
    way = servo_by_energies.Way(hand, inertia, servo_by_energies.nodes(hand, turns, 400, [], False), turns)
    return servo_by_energies.least_time(way, torque, np.full(len(way.angle), fastest**2))


def largest_torque(hand: servo_by_hand.Press, angle: np.ndarray, b: np.ndarray) -> float:
    """Largest torque at five places of each segment, between whose ends b is linear."""
    share = np.linspace(0.02, 0.98, 5)
    at = (angle[:-1, None] + share * np.diff(angle)[:, None]).ravel()
    square = (b[:-1, None] + share * np.diff(b)[:, None]).ravel()
    mass, slope, fixed = hand.at(at)
    return float(np.abs(mass * np.repeat(0.5 * np.diff(b) / np.diff(angle), len(share)) + 0.5 * slope * square + fixed).max())


QUICK = {"REPEATED": 1, "PRESSES": ["zxn2_3000b"], "SEGMENTS": [180]}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    all_presses()
    trade_off()
    beside_slsqp()
    beside_toppra()


if __name__ == "__main__":
    main()
