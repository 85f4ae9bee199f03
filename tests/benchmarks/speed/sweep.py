"""Operating points a second, beside a loop over inverse dynamics; and runs a second, one by one and at once. CPU time of one core."""

from typing import Any

import numpy as np
from benchmarks.stopwatch import least, table
from support import press_strokes

import pinpress as pp

UNIT_LOAD = pp.loads.DeepDrawing(force=1.0, start=0.020)
SPEEDS, FORCES = np.linspace(10, 100, 1000) * pp.RPM, np.linspace(0, 3e6, 1000)


def main(quick: bool = False) -> None:
    """Print the tables."""
    press, repeats, step = pp.load("zxn2_3000b"), 1 if quick else 3, 250 if quick else 1
    speeds, forces = SPEEDS[::step], FORCES[::step]
    size, looped = len(speeds) * len(forces), 4 if quick else 200
    rows = []
    for name, how in (
        ("torque and shaking force", {"bearings": ()}),
        ("and peaks of all 7 bearings", {}),
        ("and the crank angles of extremes", {"angles": True}),
    ):
        alone = {} if "angles" in how else how
        (mapped,) = least([lambda how=how: pp.sweeps.operating_points(press, speeds, forces=forces, unit_load=UNIT_LOAD, **how)], repeats)
        (loop,) = least([lambda alone=alone: one_by_one(press, looped, **alone)], repeats)
        rows.append((name, f"{size / mapped:.3g}", f"{looped / loop:.3g}"))
    print(table((f"{press.name}, {len(speeds)} speeds x {len(forces)} amplitudes, 360 crank angles", "points/s", "by loop"), rows))

    points = [each.ravel() for each in np.meshgrid(*press_strokes.grid(1000).values(), indexing="ij")]
    few = [each[:: 500 if quick else 50] for each in points]
    (single,) = least([lambda: [press_strokes.strokes(*point) for point in zip(*few, strict=True)]], repeats)
    single /= len(few[0])
    rows = [("one by one", f"{1 / single:.3g}", "1")]
    for count in (10, 100, 1000):
        together = [each[:: len(each) // count][:count] for each in points]
        (seconds,) = least([lambda together=together: press_strokes.strokes_at_once(*together)], repeats)
        rows.append((f"{count} at once", f"{count / seconds:.3g}", f"{single * count / seconds:.3g}"))
    print("\n" + table(("JF75G-125, ten strokes under motor, flywheel and blanking", "runs/s", "ratio"), rows))


def one_by_one(press: pp.Linkage, count: int, **how: Any) -> None:
    """The same at some points, by inverse dynamics of each."""
    for speed, force in zip(np.linspace(SPEEDS[0], SPEEDS[-1], count), np.linspace(FORCES[0], FORCES[-1], count), strict=True):
        load = pp.loads.DeepDrawing(force=force, start=UNIT_LOAD.start)
        turn = pp.inverse_dynamics(press, pp.cycle(press, speed), [load], **how)
        turn.driving_torque.max(), turn.driving_torque.min(), np.ptp(turn.shaking_force, axis=0)
        for vector in turn.bearing_force.values():
            np.linalg.norm(vector, axis=1).max()
