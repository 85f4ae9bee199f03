"""The stopwatch of all benchmarks: contestants take turns, and the least time counts.

It is time of the processor, unless the caller gives another clock: work in other processes or on a disk needs `time.perf_counter`.
"""

import time
from collections.abc import Callable, Sequence

from pinpress.accuracy.work_precision import CLOCK, least_seconds


def least(works: Sequence[Callable[[], object]], repeats: int, clock: Callable[[], float] = CLOCK) -> list[float]:
    """Least seconds of a call of each piece of work, in turn, again and again."""
    return least_seconds(works, repeats, clock=clock)


def once(work: Callable[[], object], clock: Callable[[], float] = time.process_time) -> float:
    """Seconds of the one call of some work that cannot be repeated, such as a first call, or that takes minutes."""
    begin = clock()
    work()
    return clock() - begin
