"""How times and memory grow: with the linkage, from one loop to hundreds, and with crank angles, scenarios and duration.

Run `python tests/benchmarks/speed/sizes.py`; `--quick` for the smaller half of the sizes. pytest does not collect this file. Linkages
are chains of dyads (see `n_four_bar`), with ball joints or hinges for loops, rows of geared shafts, of links that hang on each other,
chains of four-bars in space and of five-bars with a gear pair each, and rows of links tied to the frame. Every step is timed with what it
needs already there: `load` from the file, the branch walked once, then motion and inverse dynamics at some crank angles, and both
together; the table of a free run, the next run, a URDF and a report. Times are those of the processor, BLAS in one thread; memory is the
most that Python and NumPy hold of the linkage while it moves and all forces are found. The exponent is the slope of log time over log
size, fitted to all sizes, and to the upper half of them: 1 is linear. At last, motion and forces with as many BLAS threads as cores beside
those with one, in alternated processes.
"""

from __future__ import annotations

import argparse
import gc
import itertools
import os
import subprocess
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy is imported

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks import stopwatch
from support.generators import large_linkages
from support.oracles import n_four_bar

import pinpress as pp

REPEATS = 3
THREADED = (20, 50)  # sizes at which threads are compared
LONGEST = 1.0  # what takes longer is not repeated [s]


class Kind(NamedTuple):
    """Linkages that grow.

    Attributes:
        title: what they are.
        urdf: text of one, by its size.
        sizes: numbers of loops or pairs.
        engine: place of the engine in `Linkage.engines`.
        angles: number of crank angles.
        highest: last crank angle [rad].
    """

    title: str
    urdf: Callable[[int], str]
    sizes: tuple[int, ...]
    engine: int
    angles: int
    highest: float = 1.2

    def crank_angles(self, count: int, step: int) -> np.ndarray:
        """``count`` crank angles, other ones with each ``step`` [rad]."""
        return np.linspace(0.05, self.highest, count) + 1e-4 * step


KINDS = (
    Kind("dyads", n_four_bar.urdf, (1, 2, 5, 10, 25, 50, 100, 200), 0, 360),
    Kind("gear pairs", large_linkages.gear_train, (1, 2, 5, 10, 25, 50, 100, 200), 0, 360),
    Kind("open links in a row", large_linkages.open_row, (10, 25, 50, 100, 150, 200), 0, 360),
    Kind("loops in space", large_linkages.spatial_chain, (1, 2, 5, 10, 20, 35, 50), 0, 36),
    Kind("dyads", n_four_bar.urdf, (5, 10, 20, 35, 50, 65), 1, 36),
    Kind("hinges", lambda count: large_linkages.hinged(n_four_bar.urdf(count)), (5, 10, 20, 35, 50, 65), 1, 36),
    Kind("geared five-bars", large_linkages.geared_chain, (5, 10, 20, 35, 65), 1, 36, 0.8),  # it locks at 0.907 rad
    Kind("ties, short loops", lambda count: large_linkages.tied_row(count, short=True), (5, 10, 20, 35), 0, 36),
    Kind("ties, long loops", lambda count: large_linkages.tied_row(count, short=False), (5, 10, 20, 35), 0, 36),
)


def of_linkages(kind: Kind, quick: bool) -> None:
    """Print a row for each size, and one of exponents."""
    sizes = kind.sizes[: -(len(kind.sizes) // 2)] if quick else kind.sizes
    engine = large_linkages.load(kind.urdf(1)).engines[kind.engine]
    print(f"\n{kind.title}, engine {engine!r}, {kind.angles} crank angles: ms; MB")
    table(kind.title, sizes, [costs(kind, size, engine) for size in sizes])


def costs(kind: Kind, size: int, engine: str) -> dict[str, float]:
    """Of every step by its name: its time [ms]; the memory of them all [MB]."""
    text, steps = kind.urdf(size), itertools.count()

    def motion(press: pp.Linkage) -> pp.Motion:
        return pp.servo_cycle(press, angle=kind.crank_angles(kind.angles, next(steps)), speed=7.0, engine=engine)

    def run(press: pp.Linkage) -> pp.Run:
        return pp.simulate(press, 0.1, speed=7.0, angle=0.05 + 1e-4 * next(steps))

    gc.collect()
    tracemalloc.start()
    press = large_linkages.load(text)
    tracemalloc.reset_peak()
    pp.inverse_dynamics(press, motion(press), engine=engine)
    memory = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    found = {"load": milliseconds(lambda: large_linkages.load(text))}
    fresh = [large_linkages.load(text) for _ in range(REPEATS)]
    found["branch"] = milliseconds(lambda: fresh.pop().branch)
    states = motion(press)
    found["cycle"] = milliseconds(lambda: motion(press))
    found["inverse dynamics"] = milliseconds(lambda: pp.inverse_dynamics(press, states, engine=engine))
    found["torque alone"] = milliseconds(lambda: pp.inverse_dynamics(press, states, engine=engine, bearings=()))
    found["at new angles"] = milliseconds(lambda: pp.inverse_dynamics(press, motion(press), engine=engine))
    if engine == press.engines[0]:
        found["its table"] = 1e3 * stopwatch.once(lambda: run(press))[1]
        found["free run"] = milliseconds(lambda: run(press))
        with tempfile.TemporaryDirectory() as folder:
            forces, page = pp.inverse_dynamics(press, states), Path(folder) / "report.html"
            found["write_urdf"] = milliseconds(lambda: pp.write_urdf(press, Path(folder) / "written.urdf"))
            found["report"] = milliseconds(lambda: pp.report(press, states, page, reactions=forces))
    return found | {"memory": memory}


def of_threads(quick: bool) -> None:
    """Print processor times of motion and forces where BLAS may use all cores, over those where it may use one, in alternated processes."""
    sizes = [size // 4 for size in THREADED] if quick else THREADED
    print(f"\nProcessor time with as many BLAS threads as cores ({os.cpu_count()}), over that with one")
    for number, kind in enumerate(KINDS):
        for size in sizes:
            best = {"1": np.inf, "": np.inf}
            for _ in range(REPEATS):
                for threads in best:
                    settings = {**os.environ, "OPENBLAS_NUM_THREADS": threads or str(os.cpu_count())}
                    command = [sys.executable, __file__, "--child", str(number), str(size)]
                    found = subprocess.run(command, env=settings, capture_output=True, text=True, check=True, timeout=300)
                    best[threads] = min(best[threads], float(found.stdout))
            print(
                f"{kind.title:>20} of {size:3}, engine in place {kind.engine}: {best['1']:8.1f} ms, ratio {best[''] / best['1']:5.2f}",
                flush=True,
            )


def print_one(kind: Kind, size: int) -> None:
    """Print the processor time of motion and forces at 360 new crank angles [ms]."""
    press = large_linkages.load(kind.urdf(size))
    engine, steps = press.engines[kind.engine], itertools.count()

    def work() -> None:
        motion = pp.servo_cycle(press, angle=kind.crank_angles(360, next(steps)), speed=7.0, engine=engine)
        pp.inverse_dynamics(press, motion, engine=engine)

    work()
    time.sleep(0.5)  # threads that SciPy's import has started look for work for a while
    print(milliseconds(work))


def of_lengths(quick: bool) -> None:
    """Print how times grow with crank angles, scenarios and duration."""
    press, spatial = pp.load("zxn2_3000b"), large_linkages.load(large_linkages.spatial_chain(1))
    speeds, flywheel, steps = np.linspace(6.0, 8.0, 10_000), pp.drives.Flywheel(500.0), itertools.count()

    def forces(linkage: pp.Linkage, count: int, middle: float) -> float:
        def work() -> None:  # other angles each time
            angles = np.linspace(middle - 0.5, middle + 0.5, count) + 1e-4 * next(steps)
            pp.inverse_dynamics(linkage, pp.servo_cycle(linkage, angle=angles, speed=7.0))

        return milliseconds(work)

    works: dict[str, tuple[tuple[int, ...], Callable[[int], float]]] = {
        "crank angles of the six-bar": ((360, 3600, 36_000, 360_000), lambda size: forces(press, size, 0.6)),
        "crank angles of a four-bar in space": ((36, 360, 3600, 36_000), lambda size: forces(spatial, size, 0.6)),
        "scenarios": (
            (10, 100, 1000, 10_000),
            lambda size: milliseconds(lambda: pp.simulate_batch(press, 0.2, speed=speeds[:size], flywheel=flywheel)),
        ),
        "seconds": ((1, 10, 100, 1000), lambda size: milliseconds(lambda: pp.simulate(press, float(size), speed=7.0))),
    }
    for title, (sizes, work) in works.items():
        wanted = sizes[:2] if quick else sizes
        print()
        table(title, wanted, [{"ms": work(size)} for size in wanted])


def milliseconds(work: Callable[[], object]) -> float:
    """The least processor time of some calls, as many as `REPEATS`; what takes longer than a second is not repeated."""
    best = np.inf
    for _ in range(REPEATS):
        best = min(best, stopwatch.once(work)[1])
        if best > LONGEST:
            break
    return 1e3 * best


def table(title: str, sizes: Sequence[int], found: Sequence[Mapping[str, float]]) -> None:
    """Print costs by size, and their exponents."""
    names = list(found[0])
    print("".join([f"{title:>36}", *(f"{name:>18}" for name in names)]))
    for size, row in zip(sizes, found, strict=True):
        print("".join([f"{size:36}", *(f"{row[name]:18.2f}" for name in names)]))
    for title, some in (("exponent", slice(None)), ("exponent of the upper half", slice(-max(2, len(sizes) // 2), None))):
        slopes = [np.polyfit(np.log(sizes[some]), np.log([row[name] for row in found[some]]), 1)[0] for name in names]
        print("".join([f"{title:>36}", *(f"{slope:18.2f}" for slope in slopes)]), flush=True)


QUICK = {"KINDS": tuple(kind._replace(sizes=(2, 3, 4)) for kind in KINDS), "THREADED": (8,), "REPEATS": 1}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--child", nargs=2, type=int, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        print_one(KINDS[given.child[0]], given.child[1])
        return
    for kind in KINDS:
        of_linkages(kind, quick)
    of_lengths(quick)
    of_threads(quick)


if __name__ == "__main__":
    main()
