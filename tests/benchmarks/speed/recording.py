"""Time and size of recordings and reports of the six-bar press, 360 frames, as the Markdown table in docs/recording.md.

python tests/benchmarks/speed/recording.py
"""

import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks import stopwatch

import pinpress as pp

REPEATS = 5


QUICK = {"REPEATS": 1}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    press = pp.load("zxn2_3000b")
    result = pp.inverse_dynamics(press, pp.cycle(press, speed=70 * pp.RPM, points=360))
    print("| the six-bar, 360 frames (`python tests/benchmarks/speed/recording.py`) | time | size |")
    print("|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        for name, write in (
            ("`record` without forces", lambda: pp.record(press, result.motion, page)),
            ("`record` with arrows", lambda: pp.record(press, result.motion, page, reactions=result)),
            ("`report`", lambda: pp.report(press, result.motion, page, reactions=result)),
        ):
            (_, first), (later,) = stopwatch.once(write, time.perf_counter), stopwatch.least([write], REPEATS, time.perf_counter)
            print(f"| {name} | {later:.3f} s (first {first:.3f} s) | {page.stat().st_size / 1e6:.2f} MB |")


if __name__ == "__main__":
    main()
