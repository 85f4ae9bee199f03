"""Run times that can be compared: contestants take turns, so that whatever else the machine does meets all of them."""

import gc
import time
from collections.abc import Callable, Sequence

TURN = 0.02  # of calls before the next one's turn: the first call after another contestant finds its data and code evicted [s]
PATIENCE = 2.0  # after which a contestant, once timed, has had its turns [s]


def least_seconds(works: Sequence[Callable[[], object]], repeats: int, done: Callable[[], None] = lambda: None) -> list[float]:
    """The least time of a call of each [s], in ``repeats`` rounds without the garbage collector; ``done`` is called after every turn."""
    best, spent = [float("inf")] * len(works), [0.0] * len(works)
    collecting = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        for _ in range(repeats):
            for k, work in enumerate(works):
                end = time.perf_counter() + TURN
                while spent[k] < PATIENCE:
                    start = time.perf_counter()
                    work()
                    now = time.perf_counter()
                    best[k], spent[k] = min(best[k], now - start), spent[k] + now - start
                    if now > end:
                        break
                done()
    finally:
        if collecting:
            gc.enable()
    return best
