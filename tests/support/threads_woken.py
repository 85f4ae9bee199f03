"""How often threads other than the main one are switched to while pinpress works: a program, which prints a line for each work."""

import re
import sys
import threading
import time
from pathlib import Path

import numpy as np

import pinpress as pp
from pinpress.common.products import product


def switches() -> tuple[int, int]:
    """How many other threads there are, and how often they were switched to."""
    others = [task for task in Path("/proc/self/task").iterdir() if int(task.name) != threading.get_native_id()]
    return len(others), sum(
        int(number) for task in others for number in re.findall(r"ctxt_switches:\s+(\d+)", (task / "status").read_text())
    )


press = pp.load("jf75g_125")
motion, speeds = pp.cycle(press, speed=30.0, points=3600), np.linspace(28.0, 32.0, 500)
drive, blanking = pp.drives.Geared(pp.drives.InductionMotor(45e3, 1465 * pp.RPM), 4.9), [pp.loads.Blanking(2e5, 0.010, 0.005)]
springs = pp.elasticity.Elastic(
    pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 2e9), moments={"slide_guide": 1e8, "counterweight_guide": 1e8}),
    damping_ratio=0.05,
)
dimension = pp.tolerances.link_length(press, "P4", "P2", tolerance=1e-5)
wide = np.ones((14, 30_000))

WORKS = {
    "product": lambda: (product(np.ones((14, 14)), wide), product(wide.T, np.ones((14, 14))), product(np.ones((2, 14), complex), wide)),
    "inverse dynamics": lambda: pp.inverse_dynamics(press, motion).driving_torque,
    "harmonics": lambda: pp.measures.harmonics(motion, pp.inverse_dynamics(press, motion).shaking_force),
    "scenarios": lambda: (
        pp.simulate_batch(press, 1.0, speed=speeds, flywheel=pp.drives.Flywheel(136.0), drive=drive, loads=blanking).crank_angle
    ),
    "springs": lambda: pp.steady_state(press, 30.0, drive=pp.drives.PrescribedSpeed(30.0), loads=blanking, elastic=springs).slide_position,
    "tolerances": lambda: pp.tolerances.bottom_dead_centre(press, [dimension], samples=20_000),
    "wakes": lambda: np.ones((600, 600)) @ np.ones((600, 600)),
}
for name, work in WORKS.items():
    work()
    found = []
    for _ in range(3):  # the least counts: now and then a thread that has nothing to do looks whether there is anything
        time.sleep(0.5)  # threads that have worked look for more work for a while, and are counted once they sleep
        threads, before = switches()
        work()
        time.sleep(0.5)
        found.append(switches()[1] - before)
    sys.stdout.write(f"{name},{min(found)},{max(found)},{threads}\n")
