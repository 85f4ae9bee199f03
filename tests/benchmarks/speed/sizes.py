"""How times and memory grow with the linkage, from one loop to hundreds.

Linkages are chains of dyads (see `n_four_bar`), with ball joints or hinges for loops, rows of geared shafts, of links that hang on each
other, chains of four-bars in space and of five-bars with a gear pair each, and rows of links tied to the frame. Every step is timed with
what it needs already there: `load` from the file, the branch walked once, then motion and inverse dynamics at some crank angles, and both
together; the table of a free run, the next run, a URDF and a report. Memory is the most that Python and NumPy hold of the linkage while it
moves and all forces are found. The exponent is the slope of log time over log size, fitted to all sizes, and to the upper half of them: 1
is linear.
"""

import gc
import itertools
import tempfile
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from benchmarks.stopwatch import once, table
from support.generators import large_linkages
from support.oracles import n_four_bar

import pinpress as pp


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


def main(quick: bool = False) -> None:
    """Print a table for each kind, a size a row, and exponents; ``quick``: of every third kind, small."""
    for kind in KINDS[::3] if quick else KINDS:
        sizes = (2, 3) if quick else kind.sizes
        engine = large_linkages.load(kind.urdf(1)).engines[kind.engine]
        costs = [costs_of(kind, size, engine, 1 if quick else 3) for size in sizes]
        rows = [(size, *(f"{each:.2f}" for each in row.values())) for size, row in zip(sizes, costs, strict=True)]
        for words, part in (("exponent", slice(None)), ("exponent of the upper half", slice(-max(2, len(sizes) // 2), None))):
            slopes = (np.polyfit(np.log(sizes[part]), np.log([row[name] for row in costs[part]]), 1)[0] for name in costs[0])
            rows.append((words, *(f"{slope:.2f}" for slope in slopes)))
        print(f"\n{kind.title}, engine {engine!r}, {kind.angles} crank angles: ms; MB\n")
        print(table((kind.title, *costs[0]), rows), flush=True)


def costs_of(kind: Kind, size: int, engine: str, repeats: int) -> dict[str, float]:
    """Of every step by its name: its time [ms]; the memory of them all [MB]."""
    text, steps = kind.urdf(size), itertools.count()

    def motion(press: pp.Linkage) -> pp.Motion:  # at other crank angles each time
        angles = np.linspace(0.05, kind.highest, kind.angles) + 1e-4 * next(steps)
        return pp.servo_cycle(press, angle=angles, speed=7.0, engine=engine)

    def run(press: pp.Linkage) -> pp.Run:
        return pp.simulate(press, 0.1, speed=7.0, angle=0.05 + 1e-4 * next(steps))

    def milliseconds(work: Callable[[], object]) -> float:
        best = np.inf
        for _ in range(repeats):
            best = min(best, 1e3 * once(work)[1])
            if best > 1e3:  # what takes longer than a second is not repeated
                break
        return best

    gc.collect()
    tracemalloc.start()
    press = large_linkages.load(text)
    tracemalloc.reset_peak()
    pp.inverse_dynamics(press, motion(press), engine=engine)
    memory = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    fresh = [large_linkages.load(text) for _ in range(repeats)]
    states = motion(press)
    costs = {
        "load": milliseconds(lambda: large_linkages.load(text)),
        "branch": milliseconds(lambda: fresh.pop().branch),
        "cycle": milliseconds(lambda: motion(press)),
        "inverse dynamics": milliseconds(lambda: pp.inverse_dynamics(press, states, engine=engine)),
        "torque alone": milliseconds(lambda: pp.inverse_dynamics(press, states, engine=engine, bearings=())),
        "at new angles": milliseconds(lambda: pp.inverse_dynamics(press, motion(press), engine=engine)),
    }
    if engine == press.engines[0]:
        costs["its table"] = 1e3 * once(lambda: run(press))[1]
        costs["free run"] = milliseconds(lambda: run(press))
        with tempfile.TemporaryDirectory() as folder:
            forces, page = pp.inverse_dynamics(press, states), Path(folder) / "report.html"
            costs["write_urdf"] = milliseconds(lambda: pp.write_urdf(press, Path(folder) / "written.urdf"))
            costs["report"] = milliseconds(lambda: pp.report(press, states, page, reactions=forces))
    return costs | {"memory": memory}
