"""How times grow with the linkage: chains of dyads (see `n_four_bar`) and rows of geared shafts, by either engine.

Run `python tests/benchmarks/benchmark_sizes.py`; `--quick` for fewer sizes. pytest does not collect this file. Every step is timed with
what it needs
already there: `load` from the file, the branch walked once, then motion and inverse dynamics at 360 crank angles; of the Pinocchio engine,
at 9. The exponents are those of the times between each size and the one before, so 1 is linear.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.generators import large_linkages
from support.oracles import n_four_bar

import pinpress as pp
from pinpress.accuracy.contests import least_seconds

KINDS: dict[str, Callable[[int], str]] = {"dyads": n_four_bar.urdf, "gear pairs": large_linkages.gear_train}
SIZES = {"plane": (25, 50, 100, 200, 400), "pinocchio": (5, 10, 20, 40, 80)}
ANGLES = {"plane": 360, "pinocchio": 9}
REPEATS = 5


def seconds(text: str, engine: str) -> dict[str, float]:
    """Of every step, by its name."""
    large_linkages.load(text)  # imports what loading needs
    start = time.perf_counter()
    press = large_linkages.load(text)
    found = {"load": time.perf_counter() - start}
    start = time.perf_counter()
    _ = press.branch
    found["branch"] = time.perf_counter() - start
    angles = np.linspace(0.05, 1.2, ANGLES[engine])

    def motion() -> pp.Motion:
        return pp.servo_cycle(press, angle=angles, speed=7.0, engine=engine)

    states = motion()
    works: dict[str, Callable[[], object]] = {
        "cycle": motion,
        "inverse dynamics": lambda: pp.inverse_dynamics(press, states, engine=engine),
        "torque alone": lambda: pp.inverse_dynamics(press, states, engine=engine, bearings=()),
    }
    return found | dict(zip(works, least_seconds(list(works.values()), REPEATS), strict=True))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="the three smallest sizes alone")
    quick = parser.parse_args().quick
    for engine, sizes in SIZES.items():
        for kind, urdf in KINDS.items():
            print(f"\n{kind}, engine {engine!r}, {ANGLES[engine]} crank angles: ms, and the exponent of their growth")
            before: tuple[int, dict[str, float]] | None = None
            for count in sizes[:3] if quick else sizes:
                found = seconds(urdf(count), engine)
                if before is None:
                    print("".join([f"{kind:>12}", *(f"{name:>24}" for name in found)]))
                line = f"{count:12}"
                for name, took in found.items():
                    exponent = "" if before is None else f"{math.log(took / before[1][name]) / math.log(count / before[0]):.2f}"
                    line += f"{1e3 * took:17.2f}{exponent:>7}"
                print(line, flush=True)
                before = count, found


if __name__ == "__main__":
    main()
