"""Operating points a second, beside a loop over inverse dynamics; and what a sweep adds to each of its points.

Run `python tests/benchmarks/features/sweep.py`. pytest does not collect this file. CPU time of one core for operating points, wall time
for sweeps.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from support.sweep_points import product

import pinpress as pp
from pinpress.sweeps.operating_map import operating_points
from pinpress.sweeps.sweeping import sweep

START = 0.020  # m above bottom dead centre
SPEEDS, FORCES = np.linspace(10, 100, 1000) * pp.RPM, np.linspace(0, 3e6, 1000)
REPEATS = 3
POINTS = 10_000


def cpu(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Least CPU time of a call [s]."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def one_by_one(press: pp.Linkage, count: int, **how: Any) -> None:
    """The same at some points, by inverse dynamics of each."""
    for speed, force in zip(np.linspace(SPEEDS[0], SPEEDS[-1], count), np.linspace(FORCES[0], FORCES[-1], count), strict=True):
        load = pp.loads.DeepDrawing(force=force, start=START)
        found = pp.inverse_dynamics(press, pp.cycle(press, speed), [load], **how)
        found.driving_torque.max(), found.driving_torque.min(), np.ptp(found.shaking_force, axis=0)
        for vector in found.bearing_force.values():
            np.linalg.norm(vector, axis=1).max()


def points() -> None:
    press, load = pp.load("zxn2_3000b"), pp.loads.DeepDrawing(force=1.0, start=START)
    size = len(SPEEDS) * len(FORCES)
    print(f"{press.name}, {len(SPEEDS)} speeds x {len(FORCES)} amplitudes, 360 crank angles, one core")
    print(f"{'':44}{'points/s':>12}{'by loop':>12}")
    for name, how in (
        ("torque and shaking force", {"bearings": ()}),
        ("and peaks of all 7 bearings", {}),
        ("and the crank angles of extremes", {"angles": True}),
    ):
        alone = {} if "angles" in how else how
        rate = size / cpu(lambda how=how: operating_points(press, SPEEDS, forces=FORCES, unit_load=load, **how))
        loop = 200 / cpu(lambda alone=alone: one_by_one(press, 200, **alone))
        print(f"  {name:42}{rate:12.3g}{loop:12.3g}")


def overhead(name: str, executor: Executor | None, folder: Path) -> None:
    cells = []
    for suffix in (None, "sqlite"):
        best = float("inf")
        for k in range(REPEATS):
            to = None if suffix is None else folder / f"{name.replace(' ', '_')}{k}.{suffix}"
            start = time.perf_counter()
            sweep(product, {"a": range(100), "b": range(POINTS // 100)}, to=to, executor=executor)
            best = min(best, time.perf_counter() - start)
        cells.append(f"{1e6 * best / POINTS:12.1f}")
    print(f"  {name:42}{''.join(cells)}")


def main() -> None:
    points()
    print(f"\nwhat a sweep of {POINTS} points that do nothing takes, us a point\n{'':44}{'no file':>12}{'file':>12}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        overhead("serial", None, folder)
        with ProcessPoolExecutor(2) as pool:
            overhead("2 processes", pool, folder)
        from distributed import Client, LocalCluster

        with (
            LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, local_directory=name) as cluster,
            Client(cluster) as client,
        ):
            overhead("Dask, 2 worker processes", client.get_executor(), folder)


if __name__ == "__main__":
    main()
