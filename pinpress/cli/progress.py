"""Show the progress of long work and the remaining time: a bar on a terminal, elsewhere (as in a log) a line a minute."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

LEFT = "{percentage:3.0f} % |{bar}| {remaining} to go"
SHORT = 1.0  # shorter work gets no bar [s]
MINUTE = 60.0  # between two lines [s]
STEADY = 0.03  # tqdm's weight of the newest speed: what comes in parts, one now and two then, goes at the speed of some thirty of them
WIDTH = 80  # of a line


@contextmanager
def progress(total: float, shape: str = LEFT) -> Iterator[Callable[[float], None]]:
    """Show progress on standard error.

    The first call may report work of an earlier run: the remaining time follows from the later calls.

    Args:
        total: amount of work at the end.
        shape: tqdm's ``bar_format``.

    Yields:
        A function that takes the amount of work done.
    """
    if not sys.stderr.isatty():
        yield _line_a_minute(total, shape)
        return
    from tqdm import tqdm  # seldom needed

    with tqdm(total=total, file=sys.stderr, delay=SHORT, miniters=0, smoothing=STEADY, leave=False, bar_format=shape) as bar:

        def tell(reached: float) -> None:
            if not bar.n:
                bar.initial = bar.n = bar.last_print_n = reached
            bar.update(reached - bar.n)

        yield tell


def _line_a_minute(total: float, shape: str) -> Callable[[float], None]:
    first, begun, last = 0.0, 0.0, 0.0

    def tell(reached: float) -> None:
        nonlocal first, begun, last
        now = time.monotonic()
        if not first:
            first, begun, last = reached, now, now
        elif now - last >= MINUTE:
            from tqdm import tqdm  # seldom needed

            last = now
            words = tqdm.format_meter(reached, total, now - begun, ncols=WIDTH, initial=first, bar_format=shape, ascii=True)
            print(words, file=sys.stderr, flush=True)

    return tell
