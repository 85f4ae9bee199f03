"""The work of a sweep: calls of the function at all points, in this process or by the workers of an executor."""

import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any, NamedTuple

from ..common.errors import shown
from .grid import LONGEST, RESERVED, Grid, Scalar, scalar

Function = Callable[..., Mapping[str, object]]

TASK = 0.1  # length of a task [s]; sending one costs a tenth of a millisecond with processes, and some milliseconds with a cluster
LONGEST_TASK = 2 * TASK  # after this time a task returns the points it has done [s]
LEAVE_TIME = 1.0  # time in which finished tasks may arrive after one has failed [s]


class Outcome(NamedTuple):
    """The outcome of a point.

    Attributes:
        number: number of the point.
        values: values that the function returned, by name; empty where it failed.
        error: type and text of the exception where it failed; else empty.
    """

    number: int
    values: dict[str, Scalar]
    error: str


Task = Future[tuple[list[Outcome], float]]

KILLS = (
    "BrokenProcessPool: the function ends the process that it runs in, by os._exit, a crash of compiled code, or because it takes too much"
    " memory"
)


class TaskError(Exception):
    """The executor could not carry out a task; the cause is its exception."""


class Apart(Executor):
    """Pools of one process each, in place of a pool that broke: when a process dies, only its own task is lost."""

    def __init__(self, broken: ProcessPoolExecutor) -> None:
        # The arguments of the broken pool are in its private attributes alone.
        self._pool = partial(ProcessPoolExecutor, 1, broken._mp_context, broken._initializer, broken._initargs)
        self.workers: int = broken._max_workers  # type: ignore[attr-defined]
        self._idle: list[ProcessPoolExecutor] = []

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **named: Any) -> "Future[Any]":
        """Submit a task; at most ``workers`` tasks may run at a time.

        Raises:
            BrokenProcessPool: no process can be started.
        """
        if self._idle:
            pool = self._idle.pop()
        else:
            pool = self._pool()
            pool.submit(int).result()
        future = pool.submit(function, *arguments, **named)
        future.add_done_callback(partial(self._end, pool))
        return future

    def _end(self, pool: ProcessPoolExecutor, future: "Future[Any]") -> None:
        if future.cancelled() or not isinstance(future.exception(), BrokenProcessPool):
            self._idle.append(pool)  # a broken pool has ended by itself; from Python 3.13 on it holds its lock during this call

    def close(self) -> None:
        for pool in self._idle:
            pool.shutdown(wait=False)


def serially(function: Function, grid: Grid, numbers: Sequence[int]) -> Generator[list[Outcome], None, None]:
    """Outcomes of points, computed one after the other in this process."""
    for number in numbers:
        yield [outcome(function, number, grid.point(number))]


def in_parallel(
    executor: Executor, function: Function, grid: Grid, numbers: Sequence[int], in_flight: int
) -> Generator[list[Outcome], None, None]:
    """Outcomes of points as they arrive from an executor.

    A task has as many points as take about `TASK`: at first one, then at most twice as many from task to task. A task that takes longer
    returns early, and its remaining points are submitted again. When a worker dies, the points of all tasks that may have killed it are
    done one by one; a point that kills its worker then counts as failed. A process pool breaks by such a death; its work goes on in pools
    of one process. The points of a task that otherwise fails are submitted once more, one by one.

    Args:
        executor: the executor.
        function: the function of the sweep.
        grid: its grid.
        numbers: numbers of the points to be done.
        in_flight: number of tasks submitted at a time.

    Raises:
        TaskError: a task was not carried out, twice. It is raised after the outcomes of other finished tasks.
    """
    work = _Tasks(executor, function, grid, numbers, in_flight)
    try:
        while work.unfinished:
            yield from work.next()
    finally:
        work.close()


class _Tasks:
    """The points of a sweep in the hands of an executor; see `in_parallel`."""

    def __init__(self, executor: Executor, function: Function, grid: Grid, numbers: Sequence[int], in_flight: int) -> None:
        self._executor, self._function, self._grid, self._in_flight = executor, function, grid, in_flight
        self._waiting, self._alone = deque(numbers), deque[int]()  # points to be submitted: several a task, and each by itself
        self._pending: dict[Task, list[int]] = {}
        self._finished: SimpleQueue[Task] = SimpleQueue()
        self._repeated: set[int] = set()  # points of tasks that have failed once
        self._size = 1  # points of the next task

    @property
    def unfinished(self) -> bool:
        return bool(self._pending or self._waiting or self._alone)

    def next(self) -> Iterator[list[Outcome]]:
        """Outcomes of the next task that ends, and of others where it has broken the pool."""
        points: list[int] = []
        carried_out = False
        try:
            while (self._waiting or self._alone) and len(self._pending) < self._in_flight:
                points = self._taken()
                self._submit(points)
            future = self._finished.get()
            points, carried_out = self._pending.pop(future), True
            found, seconds = future.result()
        except Exception as error:  # a pool that is broken or shut down, a cluster that is gone, a function that cannot be sent
            yield from self._after(error, points, carried_out)
            return
        self._waiting.extendleft(reversed(points[len(found) :]))
        self._size = max(1, min(2 * self._size, int(TASK * len(found) / max(seconds, 1e-9))))
        yield found

    def close(self) -> None:
        """Cancel all tasks that have not begun."""
        for future in self._pending:
            future.cancel()
        if isinstance(self._executor, Apart):
            self._executor.close()

    def _taken(self) -> list[int]:
        if self._alone:
            return [self._alone.popleft()]
        return [self._waiting.popleft() for _ in range(min(self._size, len(self._waiting)))]

    def _submit(self, points: list[int]) -> None:
        future = self._executor.submit(outcomes, self._function, [(number, self._grid.point(number)) for number in points])
        self._pending[future] = points
        future.add_done_callback(self._finished.put)

    def _after(self, error: Exception, points: list[int], carried_out: bool) -> Iterator[list[Outcome]]:
        """Handle the exception of a task with these points, or of its submission."""
        if type(self._executor) is ProcessPoolExecutor and isinstance(error, BrokenProcessPool):
            yield from self._leave_broken_pool(self._executor, points)
        elif carried_out and _killed(error) and len(points) == 1:
            yield [Outcome(points[0], {}, KILLS)]
        elif carried_out and _killed(error):
            self._alone.extend(points)
        elif carried_out and not self._repeated.issuperset(points):
            # Dask loses the result of a task whose worker dies while it is fetched: "not enough values to unpack".
            self._repeated.update(points)
            self._alone.extend(points)
        else:
            yield from _left(self._finished, len(self._pending))
            raise TaskError from error

    def _leave_broken_pool(self, pool: ProcessPoolExecutor, points: list[int]) -> Iterator[list[Outcome]]:
        """Give the outcomes that the pool has finished, and mark all its other points to be done one by one, by pools of one process."""
        wait(self._pending, timeout=LEAVE_TIME)
        for future, others in self._pending.items():
            good = future.done() and not future.cancelled() and future.exception() is None
            found = future.result()[0] if good else []
            self._alone.extend(others[len(found) :])
            yield from [found] if good else []
        self._alone.extend(points)
        self._pending, self._finished = {}, SimpleQueue()
        self._executor = apart = Apart(pool)
        self._in_flight = min(self._in_flight, apart.workers)


def outcomes(function: Function, points: Sequence[tuple[int, Mapping[str, object]]]) -> tuple[list[Outcome], float]:
    """One task: the outcomes of numbered points (of the first few where they take long), and the time that they took [s]."""
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
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # after any error, SystemExit too, the other points go on
        return Outcome(number, {}, _described(error))


def _described(error: BaseException) -> str:
    """Type and text of an exception, as a table takes them."""
    try:
        said = str(error)
    except Exception as other:
        said = f"its text cannot be had ({type(other).__name__})"
    text = f"{type(error).__name__}: {said}".encode("utf-8", "backslashreplace").decode().replace("\0", "\\0")
    return text[:LONGEST]


def _checked(returned: object) -> dict[str, Scalar]:
    """The values that the function returned, as a table takes them.

    Raises:
        TypeError: it returned no mapping of names to values.
        ValueError: a table cannot hold a value.
    """
    if not isinstance(returned, Mapping) or not returned:
        raise TypeError(f"the function returned {_short(returned)}; return a mapping of names to numbers, {{'peak_torque': 1.0}}")
    values = {}
    for name, value in returned.items():
        if not isinstance(name, str) or not name or name in RESERVED:
            raise TypeError(f"the function returned a value under {shown(name)}; name it by a word other than {', '.join(RESERVED)}")
        try:
            scalar(name)
            values[name] = scalar(value)
        except ValueError as error:
            raise ValueError(f"the function returned under {shown(name)} {error}") from None
    return values


def _left(finished: "SimpleQueue[Task]", count: int) -> Iterator[list[Outcome]]:
    """Outcomes of other tasks that finish soon after one has failed; in a broken pool all fail at once."""
    until = time.monotonic() + LEAVE_TIME
    for _ in range(count):
        try:
            future = finished.get(timeout=max(0.0, until - time.monotonic()))
        except Empty:
            return
        if not future.cancelled() and future.exception() is None:
            yield future.result()[0]


def _killed(error: Exception) -> bool:
    """Whether a task has killed its worker: one of a pool, or several of a Dask cluster, which then gives the task up."""
    return isinstance(error, BrokenProcessPool) or type(error).__name__ == "KilledWorker"


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."
