"""A sweep of many short simulations, run as a program so that it can be killed: `python tests/sweep_10000.py FILE LOG SPEEDS [WORKERS]`.

Every execution of the function is logged by one line, appended in one step, which outlives the process. Of a crank-slide, 50 ms of
`pinpress.simulate` take 3 ms, as little as a simulation takes.
"""

import os
import sys
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from functools import partial

import numpy as np

import pinpress as pp
from pinpress.sweeping import sweep

PRESS = pp.load("crank_slide")
INERTIAS = np.linspace(5.0, 50.0, 25)


def stroke(speed, inertia, log):
    descriptor = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    os.write(descriptor, f"{speed!r},{inertia!r}\n".encode())
    os.close(descriptor)
    run = pp.simulate(PRESS, 0.05, speed=speed, flywheel=pp.Flywheel(inertia), points=2)
    return {"angle": run.crank_angle[-1], "speed_after": run.crank_speed[-1]}


def grid(speeds):
    return {"speed": np.linspace(2.0, 20.0, speeds), "inertia": INERTIAS}


if __name__ == "__main__":
    to, log, speeds, workers = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    with ProcessPoolExecutor(workers) if workers else nullcontext() as executor:
        sweep(partial(stroke, log=log), grid(speeds), to=to, executor=executor)
