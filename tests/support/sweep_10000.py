"""A sweep of 10 000 short simulations, run as a program so that it can be killed: `python tests/support/sweep_10000.py FILE LOG SPEEDS
[WORKERS]`.

Every execution of the function is logged by one line, appended in one step, which outlives the process. The simulations of one speed are
solved at once, as scenarios: 25 of 50 ms of a crank-slider take as long as one alone, 3 ms.
"""

import os
import sys
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from functools import lru_cache, partial

import numpy as np

import pinpress as pp
from pinpress.sweeps import execution as sweep_run
from pinpress.sweeps.sweeping import sweep

PRESS = pp.load("crank_slide")
INERTIAS = np.linspace(5.0, 50.0, 25)
DURATION = 0.05
TASK = 0.01  # [s]; with the usual tenth of a second the workers would have all in hand


def stroke(speed, inertia, log):
    descriptor = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    os.write(descriptor, f"{speed!r},{inertia!r}\n".encode())
    os.close(descriptor)
    runs, k = strokes(speed), int(np.flatnonzero(inertia == INERTIAS)[0])
    return {"angle": runs.crank_angle[-1, k], "speed_after": runs.crank_speed[-1, k]}


@lru_cache(maxsize=1)
def strokes(speed):
    return pp.simulate_batch(PRESS, DURATION, speed=speed, flywheel=pp.drives.Flywheel(INERTIAS), points=2)


def grid(speeds):
    return {"speed": np.linspace(2.0, 20.0, speeds), "inertia": INERTIAS}


if __name__ == "__main__":
    to, log, speeds, workers = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    sweep_run.TASK = TASK
    with ProcessPoolExecutor(workers) if workers else nullcontext() as executor:
        sweep(partial(stroke, log=log), grid(speeds), to=to, executor=executor)
