"""Operating points a second, beside a loop over inverse dynamics; and what a sweep adds to each of its points.

Run `python tests/benchmarks/speed/sweep.py`; `--cluster 1000000` for that many simulations on a Dask cluster of two worker processes,
into an SQLite file (10 000 without a number; `--to` keeps it); `--store 1000000` for that many small points in a file, and read back.
pytest does not collect this file. CPU time of one core for operating points, wall time for sweeps.
"""

from __future__ import annotations

import argparse
import os
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks import stopwatch
from support import press_strokes
from support.dask_processes import dask_processes
from support.sweep_points import product

import pinpress as pp
from pinpress.sweeps import execution
from pinpress.sweeps.operating_map import operating_points
from pinpress.sweeps.sweeping import read, sweep

START = 0.020  # m above bottom dead centre
SPEEDS, FORCES = np.linspace(10, 100, 1000) * pp.RPM, np.linspace(0, 3e6, 1000)
REPEATS = 3
POINTS = 10_000


def cpu(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Least CPU time of a call [s]."""
    return stopwatch.least([work], repeats, time.process_time)[0]


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
            work = partial(sweep, product, {"a": range(100), "b": range(POINTS // 100)}, to=to, executor=executor)
            best = min(best, stopwatch.once(work, time.perf_counter)[1])
        cells.append(f"{1e6 * best / POINTS:12.1f}")
    print(f"  {name:42}{''.join(cells)}")


def both_ways() -> None:
    """Runs a second, one by one and at once."""
    axes = press_strokes.grid(1000)
    columns = [each.ravel() for each in np.meshgrid(*axes.values(), indexing="ij")]
    alone = cpu(lambda: [press_strokes.strokes(*point) for point in zip(*(each[::50] for each in columns), strict=True)]) / 20
    print("\nJF75G-125, ten strokes under motor, flywheel and blanking, one core\n  one by one" + f"{1 / alone:12.3g} runs/s")
    for count in (10, 100, 1000):
        seconds = cpu(lambda count=count: press_strokes.strokes_at_once(*(each[:: len(each) // count][:count] for each in columns))) / count
        print(f"  {count:4} at once{1 / seconds:12.3g} runs/s, {alone / seconds:.3g} times as many")


def large(points: int, to: Path | None) -> None:
    """So many simulations on a Dask cluster of two worker processes; before that as many points that do nothing, and small tasks."""
    from distributed import Client

    usual = execution.TASK
    with tempfile.TemporaryDirectory() as name, dask_processes(name) as (address, processes), Client(scheduler_file=str(address)) as client:
        client.wait_for_workers(2)
        for said, function, task, count, length, file in (
            ("nothing to do", press_strokes.nothing, usual, points, 1000, Path(name, "nothing.sqlite")),
            ("nothing to do, each part of ten points a task", press_strokes.nothing, 0.0, points // 50, 10, Path(name, "small.sqlite")),
            ("ten strokes", press_strokes.strokes_at_once, usual, points, 1000, to or Path(name, "runs.sqlite")),
        ):
            execution.TASK = task
            print(f"\n{said}")
            on_cluster(client, processes[0].pid, function, count, length, file)


def on_cluster(client: Any, scheduler: int, function: Callable[..., Any], points: int, length: int, file: Path) -> None:
    """A sweep, what it takes and what travels."""
    import cloudpickle
    import psutil

    executor = client.get_executor()
    tasks: list[int] = []
    submit = executor.submit

    def counted(*arguments: Any, **named: Any) -> Any:
        tasks.append(len(cloudpickle.dumps(arguments)))
        return submit(*arguments, **named)

    executor.submit = counted
    started = client.run(time.process_time)
    start, own, before = time.perf_counter(), time.process_time(), sum(psutil.Process(scheduler).cpu_times()[:2])
    found = sweep(function, press_strokes.grid(points), to=file, at_once=length, executor=executor)
    count = found.column("force").size
    seconds, own = time.perf_counter() - start, time.process_time() - own
    sorting = sum(psutil.Process(scheduler).cpu_times()[:2]) - before
    working = sum(spent - started[worker] for worker, spent in client.run(time.process_time).items())
    size = file.stat().st_size
    print(f"  {count} points in {len(tasks)} tasks, {len(found.failed)} points failed")
    print(f"  {seconds:.4g} s, {count / seconds:.4g} points/s, {1e6 * seconds / count:.4g} us a point")
    print(f"  CPU: workers {working:.4g} s, scheduler {sorting:.4g} s, this process {own:.4g} s")
    print(f"  a task: scheduler {1e3 * sorting / len(tasks):.3g} ms, this process {1e3 * own / len(tasks):.3g} ms")
    print(f"  sent {sum(tasks) / len(tasks):.4g} bytes a task; file {size / 1e6:.4g} MB, {size / count:.3g} bytes a point")
    print(f"  most memory of this process {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3:.4g} MB", flush=True)


def stored(points: int) -> None:
    """Small points in a file: six results at once, written, read back and exported; and one by one, each with a commit of its own."""
    count = round(points**0.5)
    grid = {"a": range(count), "b": range(count)}

    def six(a: Any, b: Any) -> dict[str, Any]:
        return {f"x{k}": a * 1.1 + b * k for k in range(6)}

    with tempfile.TemporaryDirectory() as name:
        file, single, exported = Path(name, "r.sqlite"), Path(name, "single.sqlite"), Path(name, "r.parquet")
        few = {"a": range(count // 10), "b": range(count // 10)}
        print(f"{count**2} points with six results: processor time, and time by the clock [s]")
        for said, work in (
            ("written, 1000 points a call", lambda: sweep(six, grid, to=file, at_once=True)),
            ("the same without a file", lambda: sweep(six, grid, at_once=True)),
            ("read", lambda: read(file)),
            ("read, and exported to Parquet", lambda: read(file).to_parquet(exported)),
            ("a hundredth of them, one point a call", lambda: sweep(six, few, to=single)),
        ):
            clock = time.perf_counter()
            spent = cpu(work, 1)
            print(f"  {said:42}{spent:8.2f}{time.perf_counter() - clock:8.2f}")
        print(f"  file {file.stat().st_size / 1e6:.3g} MB, Parquet {exported.stat().st_size / 1e6:.3g} MB")


QUICK = {"SPEEDS": SPEEDS[::250], "FORCES": FORCES[::250], "REPEATS": 1, "POINTS": 100}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cluster", nargs="?", type=int, const=10_000, metavar="POINTS", help="simulations on a Dask cluster, and no more")
    parser.add_argument("--to", type=Path, help="SQLite file for the results of these simulations")
    parser.add_argument("--store", nargs="?", type=int, const=10_000, metavar="POINTS", help="small points in a file, and no more")
    options = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    if options.cluster:
        large(options.cluster, options.to)
        return
    if options.store:
        stored(options.store)
        return
    points()
    both_ways()
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
