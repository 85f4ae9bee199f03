"""Time of finding masses and friction from two minutes of record at 1 kHz: processor time of one process, the least of several calls.

python tests/benchmarks/benchmark_identification.py
"""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import numpy as np
from support.measured_presses import columns, drawn, drive, press_of, run

from pinpress import measured

TIMES = 3
STROKES = {"zxn2_3000b": (30, 50, 70), "jf75g_125": (100, 200, 300), "rssp": (40, 80, 120)}
KINDS = {"crank and gibs, cylinder": (("crank", "gibs"), True), "crank, pins and guide, cylinder": (("crank", "pins", "slide_guide"), True)}


def records(name: str) -> list[measured.MeasuredRun]:
    """Three runs of 40 s at 1 kHz."""
    rng, runs = np.random.default_rng(0), []
    masses = drawn(name, rng)
    for strokes in STROKES[name]:
        torque = columns(name, strokes, (), False, 40.0, 1000.0) @ masses
        runs.append(run(drive(strokes, 40.0, 1000.0), torque + 0.02 * np.abs(torque).max(), rng, 0.01 * np.abs(torque).max(), 8192))
    return runs


def main() -> None:
    for name in STROKES:
        press, runs = press_of(name), records(name)
        for words, (friction, cylinder) in KINDS.items():
            found = []
            for _ in range(TIMES):
                begin = time.process_time()
                measured.identify(press, runs, friction=friction, cylinder=cylinder)
                found.append(time.process_time() - begin)
            print(f"{name:12} {words:34} {min(found):6.2f} s")


if __name__ == "__main__":
    main()
