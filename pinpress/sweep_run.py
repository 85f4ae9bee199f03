"""The work of a sweep: the function at point after point, here or by the workers of an executor."""

import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future
from queue import Empty, SimpleQueue
from typing import NamedTuple

from .sweep_grid import LONGEST, RESERVED, Grid, Scalar, scalar

Function = Callable[..., Mapping[str, object]]

TASK = 0.1  # work that is sent at once [s]: a task costs a tenth of a millisecond with processes, some with a cluster
LONGEST_TASK = 2 * TASK
LEAVE_TIME = 1.0  # for finished tasks to arrive after one has failed [s]


class Outcome(NamedTuple):
    """What the function returned at a point; of one that failed no values, and the exception's type and text."""

    number: int
    values: dict[str, Scalar]
    error: str


Task = Future[tuple[list[Outcome], float]]


class TaskError(Exception):
    """A task that the executor could not carry out; the cause is its exception."""


def serially(function: Function, grid: Grid, numbers: Sequence[int]) -> Generator[list[Outcome], None, None]:
    """Outcomes of points, one after the other in this process."""
    for number in numbers:
        yield [outcome(function, number, grid.point(number))]


def in_parallel(
    executor: Executor, function: Function, grid: Grid, numbers: Sequence[int], in_flight: int
) -> Generator[list[Outcome], None, None]:
    """Outcomes of points as they come, of tasks submitted to an executor, so many at a time.

    A task has as many points as take about `TASK`, at first one, and at most doubling from task to task. One that takes longer leaves
    points undone, which are submitted again.

    Raises:
        TaskError: a task was not carried out; after what others had finished has been given.
    """
    finished: SimpleQueue[Task] = SimpleQueue()
    pending: dict[Task, list[int]] = {}
    waiting, size = deque(numbers), 1
    try:
        while pending or waiting:
            try:
                while waiting and len(pending) < in_flight:
                    some = [waiting.popleft() for _ in range(min(size, len(waiting)))]
                    future = executor.submit(outcomes, function, [(number, grid.point(number)) for number in some])
                    pending[future] = some
                    future.add_done_callback(finished.put)
                future = finished.get()
                some = pending.pop(future)
                found, seconds = future.result()
            except Exception as error:  # a pool that is broken or shut down, a cluster that is gone, a function that cannot be sent
                yield from _left(finished, len(pending))
                raise TaskError from error
            waiting.extendleft(reversed(some[len(found) :]))
            size = max(1, min(2 * size, int(TASK * len(found) / max(seconds, 1e-9))))
            yield found
    finally:
        for future in pending:
            future.cancel()


def outcomes(function: Function, points: Sequence[tuple[int, Mapping[str, object]]]) -> tuple[list[Outcome], float]:
    """One task: the outcomes of numbered points, of the first few where they take long, and how long they took [s]."""
    found, start = [], time.perf_counter()
    for number, point in points:
        found.append(outcome(function, number, point))
        if (seconds := time.perf_counter() - start) > LONGEST_TASK:
            break
    return found, seconds


def outcome(function: Function, number: int, point: Mapping[str, object]) -> Outcome:
    """The function at one point."""
    try:
        return Outcome(number, _checked(function(**point)), "")
    except Exception as error:  # whatever it is, the other points go on
        text = f"{type(error).__name__}: {error}".encode("utf-8", "backslashreplace").decode().replace("\0", "\\0")
        return Outcome(number, {}, text[:LONGEST])


def _checked(returned: object) -> dict[str, Scalar]:
    """What the function returned, as a table takes it."""
    if not isinstance(returned, Mapping) or not returned:
        raise TypeError(f"the function returned {_short(returned)}; return a mapping of names to numbers, {{'peak_torque': 1.0}}")
    values = {}
    for name, value in returned.items():
        if not isinstance(name, str) or not name or name in RESERVED:
            raise TypeError(f"the function returned a value under {name!r}; name it by a word other than {' and '.join(RESERVED)}")
        try:
            scalar(name)
            values[name] = scalar(value)
        except ValueError as error:
            raise ValueError(f"the function returned under {name!r} {error}") from None
    return values


def _left(finished: "SimpleQueue[Task]", count: int) -> Iterator[list[Outcome]]:
    """What tasks have finished beside one that failed; those of a broken pool fail at once, too."""
    until = time.monotonic() + LEAVE_TIME
    for _ in range(count):
        try:
            future = finished.get(timeout=max(0.0, until - time.monotonic()))
        except Empty:
            return
        if not future.cancelled() and future.exception() is None:
            yield future.result()[0]


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."
