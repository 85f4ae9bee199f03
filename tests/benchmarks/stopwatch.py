"""The stopwatch of all benchmarks: contestants take turns, and the least time counts.

It is time of the processor, unless the caller gives another clock: work in other processes or on a disk needs `time.perf_counter`.
"""

from collections.abc import Callable, Sequence
from typing import TypeVar

from pinpress.accuracy.work_precision import CLOCK, least_seconds

Result = TypeVar("Result")


def least(works: Sequence[Callable[[], object]], repeats: int, clock: Callable[[], float] = CLOCK) -> list[float]:
    """Least seconds of a call of each piece of work, in turn, again and again."""
    return least_seconds(works, repeats, clock=clock)


def once(work: Callable[[], Result], clock: Callable[[], float] = CLOCK) -> tuple[Result, float]:
    """Result and seconds of the one call of some work that cannot be repeated, such as a first call, or that takes long."""
    begin = clock()
    result = work()
    return result, clock() - begin
