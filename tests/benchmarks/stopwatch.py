"""The stopwatch and the table of all benchmarks.

Contestants take turns, so that whatever else the machine does meets all of them, and the least time counts. It is time of the processor,
unless the caller gives another clock: work in other processes or on a disk needs `time.perf_counter`.
"""

import os
import subprocess
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TypeVar

from support import markdown

from pinpress.accuracy.work_precision import CLOCK, least_seconds

Result = TypeVar("Result")
Work = Callable[[], object]


def least(works: Sequence[Work], repeats: int, clock: Callable[[], float] = CLOCK) -> list[float]:
    """Least seconds of a call of each piece of work, in turn, again and again."""
    return least_seconds(works, repeats, clock=clock)


def once(work: Callable[[], Result], clock: Callable[[], float] = CLOCK) -> tuple[Result, float]:
    """Result and seconds of the one call of some work that cannot be repeated, or that takes long."""
    begin = clock()
    result = work()
    return result, clock() - begin


def in_new_process(code: str) -> str:
    """What some code prints in a new process, which may keep compiled modules, as where the package is installed."""
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=environment)
    if run.returncode:
        raise SystemExit(f"{code}\n{run.stderr}")
    return run.stdout


def ms(seconds: float) -> str:
    """A time in milliseconds."""
    return f"{1e3 * seconds:.3g}" if seconds < 0.0995 else f"{1e3 * seconds:.0f}"


def table(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table in Markdown, numbers to the right."""
    return markdown.table(heads, rows, len(heads))


def compared(works: dict[str, Work], repeats: int) -> str:
    """A table of works: milliseconds, and ratios to the first."""
    seconds = least(list(works.values()), repeats)
    return table(["", "ms", "ratio"], [(name, ms(each), f"{each / seconds[0]:.2f}") for name, each in zip(works, seconds, strict=True)])
