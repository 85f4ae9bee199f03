"""Best motions of servo presses: how long a proved motion takes, and toppra's least time beside ours.

Everything from the press to the proved motion is in the times, with the check by full inverse dynamics. toppra (`pip install
'pinpress[peers]'`) finds the least time of one press with a torque and a speed limit, which is what it can do of these: it knows no heat,
energy, root mean square or window of time. To it the press is a robot of one joint, whose reduced inertia, with the weights, was made
before its clock starts. Torques of both motions are checked between the nodes too.
"""

import importlib.util
import itertools
from collections.abc import Callable

import numpy as np
from benchmarks.stopwatch import least, ms, table
from support.oracles import servo_by_energies, servo_by_hand

import pinpress as pp
from pinpress import servo
from pinpress.common.quantities import Array

FULL = 2 * np.pi


def main(quick: bool = False) -> None:
    """Print the tables."""
    repeats = 1 if quick else 7
    least_heat(pp.presses()[:1] if quick else pp.presses(), repeats)
    if importlib.util.find_spec("toppra") is None:
        print("toppra is not installed: pip install 'pinpress[peers]'")
    else:
        least_time((180,) if quick else (180, 360, 720, 1440), repeats)


def seconds(work: Callable[[int], object], repeats: int) -> float:
    """Least CPU time of a call; each gets its number, so that nothing is kept from the last one."""
    number = itertools.count()
    return least([lambda: work(next(number))], repeats)[0]


def least_heat(names: list[str], repeats: int) -> None:
    """A shipped press that draws over a fifth of its stroke, once a second, with a drive of about its own inertia."""
    rows = []
    for name in names:
        press = pp.load(name)
        stroke, slide = pp.dead_centres(press).stroke, press.model.inertias[press.slide_guide.joint + 1].mass
        loads, motion = [pp.loads.DeepDrawing(200.0 * slide, 0.2 * stroke)], pp.cycle(press, FULL, points=60)
        torque = np.abs(pp.inverse_dynamics(press, motion, loads, bearings=()).driving_torque).max()
        drive, speed = servo.ServoDrive(inertia=0.3 * torque / FULL**2), 0.6 * np.abs(motion.slide_velocity).max()

        def best(k: int) -> servo.MotionOptimum:
            limits = [servo.SlideSpeed(speed * (1.0 + 1e-4 * k), (0.2 * stroke, 0.0))]  # noqa: B023  called before the next press
            return servo.best_motion(press, drive, loads, time=1.0, limits=limits)  # noqa: B023

        optimum = best(0)
        rows.append((name, ms(seconds(best, repeats)), f"{optimum.gap:.1e}", f"{optimum.node_error:.1e}"))
    print(table(("least heat, 720 segments", "ms", "gap", "error of the nodes"), rows))


def least_time(segments: tuple[int, ...], repeats: int) -> None:
    """The least time of the six-bar from rest to rest."""
    import toppra
    from toppra import algorithm, constraint

    toppra.setup_logging("ERROR")
    press, inertia, torque, fastest = pp.load("zxn2_3000b"), 800.0, 1.5e5, 8.0
    drive = servo.ServoDrive(inertia=inertia, peak_torque=torque, top_speed=fastest)
    hand, top, rows = servo_by_hand.Press(press, inertia), pp.dead_centres(press).top_angle, []
    phase_plane = servo_by_energies.Press(press)  # another method, with 16 000 segments
    turns = [phase_plane.top, phase_plane.top + FULL]
    way = servo_by_energies.Way(phase_plane, inertia, servo_by_energies.nodes(phase_plane, turns, 400, [], False), turns)
    exact = servo_by_energies.least_time(way, torque, np.full(len(way.angle), fastest**2))
    for count in segments:
        nodes = top + np.linspace(0.0, FULL, count + 1)
        reduced = hand.at(nodes)

        def needed(q: Array, qd: Array, qdd: Array) -> Array:
            mass, slope, fixed = (np.interp(q[0], nodes, values) for values in reduced)  # noqa: B023  called before the next count
            return np.array([mass * qdd[0] + 0.5 * slope * qd[0] ** 2 + fixed])

        path = toppra.SplineInterpolator([0.0, FULL], [[top], [top + FULL]])
        limits = [
            constraint.JointVelocityConstraint(np.array([[-fastest, fastest]])),
            constraint.JointTorqueConstraint(needed, np.array([[-torque, torque]]), np.zeros(1)),
        ]

        def by_toppra(k: int) -> Array:
            motion = algorithm.TOPPRA(limits, path, gridpoints=nodes - top, solver_wrapper="seidel")  # noqa: B023
            return np.asarray(motion.compute_parameterization(0, 0)[1]) ** 2

        def best(k: int) -> servo.MotionOptimum:
            return servo.best_motion(press, drive, minimise="time", path=servo.Stop(), points=count)  # noqa: B023

        ours = best(0)
        for name, work, angle, square in (("pinpress", best, ours.angle, ours.speed**2), ("toppra", by_toppra, nodes, by_toppra(0))):
            taken = float(np.sum(2.0 * np.diff(angle) / (np.sqrt(square[1:]) + np.sqrt(square[:-1]))))
            above = 100 * (largest_torque(hand, angle, square) / torque - 1.0)
            rows.append((name, count, ms(seconds(work, repeats)), f"{taken / exact - 1:+.1e}", f"{above:+.2f} %"))
    print(
        f"\nLeast time of zxn2_3000b from rest to rest, limited torque and speed; {exact:.6f} s in the phase plane with 16 000 segments\n"
    )
    print(table(("", "segments", "ms", "time", "torque"), rows))


def largest_torque(hand: servo_by_hand.Press, angle: Array, square: Array) -> float:
    """Largest torque at five places of each segment, between whose ends the squared speed is linear."""
    share = np.linspace(0.02, 0.98, 5)
    between = (angle[:-1, None] + share * np.diff(angle)[:, None]).ravel()
    squares = (square[:-1, None] + share * np.diff(square)[:, None]).ravel()
    mass, slope, fixed = hand.at(between)
    return float(np.abs(mass * np.repeat(0.5 * np.diff(square) / np.diff(angle), len(share)) + 0.5 * slope * squares + fixed).max())
