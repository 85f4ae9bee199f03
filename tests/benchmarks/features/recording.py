"""Time and size of recordings and reports of the six-bar press, 360 frames, as the Markdown table in docs/recording.md.

python tests/benchmarks/features/recording.py
"""

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import pinpress as pp

REPEATS = 5


def main() -> None:
    press = pp.load("zxn2_3000b")
    result = pp.inverse_dynamics(press, pp.cycle(press, speed=70 * pp.RPM, points=360))
    print("| the six-bar, 360 frames (`python tests/benchmarks/features/recording.py`) | time | size |")
    print("|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        for name, write in (
            ("`record` without forces", lambda: pp.record(press, result.motion, page)),
            ("`record` with arrows", lambda: pp.record(press, result.motion, page, reactions=result)),
            ("`report`", lambda: pp.report(press, result.motion, page, reactions=result)),
        ):
            first, later = taken(write), statistics.median(taken(write) for _ in range(REPEATS))
            print(f"| {name} | {later:.3f} s (first {first:.3f} s) | {page.stat().st_size / 1e6:.2f} MB |")


def taken(write: Callable[[], object]) -> float:
    """How long it takes [s]."""
    start = time.perf_counter()
    write()
    return time.perf_counter() - start


if __name__ == "__main__":
    main()
