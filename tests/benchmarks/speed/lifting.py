"""Feet that lift off: error against processor time, our exact steps beside the solvers of simulations.

Run `OMP_NUM_THREADS=1 python tests/benchmarks/speed/lifting.py`; else waiting threads of BLAS count as processor time. pytest does not
collect this file. One stroke of the JF75G-125 at 350 strokes/min under a drawing force of 1.2 MN, on a frame of two rigid parts (12
coordinates) and on one of beams (80). Each method is given the forces at so many states of the stroke: ours takes them as linear in
between, the solvers as a cubic spline. DOP853 and Radau IIA with events stand in `tests/support/oracles/feet_by_solver.py`; all begin in
the linear steady state, which is part of the time. The error is that of the height of the feet, by the largest, against DOP853 at 1e-13
with 11520 states. Times are processor times, the least of three where they are short, by that of our exact steps for one stroke with 720
states. What takes minutes is left out.
"""

import sys
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
import numpy as np
from benchmarks import stopwatch
from scipy.interpolate import CubicSpline
from support.oracles import feet_by_solver

import pinpress as pp
from pinpress import foundation
from pinpress.foundation.response import frame_wrench

STATES, REPEATS, LONG, SPEED, STROKE, COMMON, STROKES = 11520, 3, 10.0, 350 * pp.RPM, 60 / 350, 360, 5
EXACT = 1e-13  # tolerance of what errors are against
METHODS = (("explicit", 1e-6, "DOP853, 1e-6"), ("explicit", 1e-9, "DOP853, 1e-9"), ("implicit", 1e-4, "Radau IIA, 1e-4"))
MOUNTS = [foundation.Mount((x, y, -1.3), (2e7, 2e7, 1.2e9), (2e4, 2e4, 6e5)) for x in (-0.55, 0.55) for y in (-0.5, 0.6)]
LOADS = [pp.loads.DeepDrawing(1.2e6, 0.003)]


def of_two_parts(press):
    uprights = [foundation.Mount((x, y, 0), (4e8, 4e8, 3e9), (2e5, 2e5, 1e6)) for x in (-0.4, 0.4) for y in (-0.4, 0.5)]
    bed, crown = foundation.Frame(7000, (0, 0.1, -0.9), (2500, 2400, 2600)), foundation.Frame(5000, (0, 0.1, 0.5), (1500, 1400, 1600))
    return foundation.mounted(press, bed, MOUNTS, crown=crown, uprights=uprights)


def of_beams(press):
    """The frame of the manual, on mounts without loss factors."""
    read = foundation.read_mounted(press, Path(__file__).resolve().parents[3] / "docs" / "jf75g_125_frame.yaml")
    frame = foundation.ElasticFrame(**{**vars(read.frame), "loss_factor": 0.0})
    return foundation.mounted(press, frame, MOUNTS)


def given(press, system, states):
    """The reactions at so many states, and the forces on the coordinates as a spline of time that goes on."""
    reactions = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=states), LOADS, bearings=())
    wrench = frame_wrench(system, reactions, None)
    spline = CubicSpline(np.arange(states + 1) * STROKE / states, np.vstack([wrench, wrench[:1]]), bc_type="periodic")
    return reactions, spline


def by_solver(system, reactions, spline, strokes, *, method, tolerance, longest):
    states = len(reactions.motion.crank_angle)
    steady = foundation.steady_response(system, reactions, points={}).coordinates
    spectrum = np.fft.rfft(steady, axis=0) * (2j * np.pi / STROKE * np.arange(states // 2 + 1))[:, None]
    begin = np.concatenate([steady[0], np.fft.irfft(spectrum, states, axis=0)[0]])
    times = np.arange(strokes * COMMON + 1) * STROKE / COMMON
    found, _ = feet_by_solver.motion(system, spline, begin, times, method=method, tolerance=tolerance, longest=longest)
    return found[:, : len(system.mass)]


def by_steps(system, reactions, strokes):
    motion = foundation.lifting_response(system, reactions, points={}, strokes=strokes).motion
    return motion.coordinates[:: len(reactions.motion.crank_angle) // COMMON]


def timed(work):
    """What some work gives, and its least processor time [s]."""
    return work(), stopwatch.least([work], REPEATS)[0]


QUICK = {"STATES": 720, "REPEATS": 1, "STROKES": 1, "METHODS": (), "EXACT": 1e-6}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    press = pp.load("jf75g_125")
    print("| frame | states of the stroke | method | error | one stroke | five strokes |\n|---|---|---|---|---|---|")
    for name, system in (("two rigid parts", of_two_parts(press)), ("beams", of_beams(press))):
        heights, unit = system.mount_rows[:, 2].T, 0.0
        known = by_solver(system, *given(press, system, STATES), 1, method="explicit", tolerance=EXACT, longest=STROKE / 720) @ heights
        for states in (720, 2880):
            reactions, spline = given(press, system, states)
            rows = {"exact steps": partial(by_steps, system, reactions)}
            for method, tolerance, words in METHODS if states == 720 else METHODS[:1]:
                rows[words] = partial(by_solver, system, reactions, spline, method=method, tolerance=tolerance, longest=STROKE / 90)
            for words, work in rows.items():
                found, one = timed(lambda work=work: work(1))
                unit = unit or one
                several = f"{timed(lambda work=work: work(STROKES))[1] / unit:.3g}" if one < LONG else ""
                error = np.abs(found @ heights - known).max() / np.abs(known).max()
                print(f"| {name}, {len(system.mass)} | {states} | {words} | {error:.1e} | {one / unit:.3g} | {several} |", flush=True)


if __name__ == "__main__":
    main()
