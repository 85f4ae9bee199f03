"""Carry out the work of a sweep in this process or by workers of an executor: pieces one by one, or several in a task."""

import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar
from uuid import uuid4

Result = TypeVar("Result")

TASK = 0.1  # length of a task [s]; sending one costs a tenth of a millisecond with processes, and some milliseconds with a cluster
LONGEST_TASK = 2 * TASK  # after this time a task returns the pieces it has done [s]
LEAVE_TIME = 1.0  # time in which finished tasks may arrive after one has failed [s]


@dataclass(frozen=True)
class Work(Generic[Result]):
    """Numbered pieces of work, such as the points of a sweep.

    Attributes:
        call: function of the number and the argument of a piece; it can be sent to other processes.
        argument: number of a piece -> its argument; called in the process of the sweep when the piece is sent.
        killed: number of a piece -> its result if the piece ends the process in which it runs.
    """

    call: Callable[[int, Any], Result]
    argument: Callable[[int], Any]
    killed: Callable[[int], Result]


class TaskError(Exception):
    """The executor could not carry out a task. The cause is the executor's exception."""


class Apart(Executor):
    """Pools of one process each, which replace a broken pool: if a process dies, only its own task is lost."""

    def __init__(self, broken: ProcessPoolExecutor) -> None:
        # Only private attributes have the arguments of the broken pool.
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


def carry_out(work: Work[Result], numbers: Sequence[int], executor: Executor | None, in_flight: int) -> Generator[list[Result], None, None]:
    """Yield the results of pieces of work when they are finished: one after the other in this process, or as an executor returns them.

    A task of an executor has pieces for about `TASK` seconds: first one piece, then up to twice as many from task to task. A task that
    takes longer returns early, and its remaining pieces are submitted again. If a worker dies, the pieces of all tasks that may have killed
    it are repeated one by one. A piece that kills its worker while no other task runs has the result ``work.killed``. The death of a
    worker breaks a process pool; then the work continues in pools of one process. If a task fails for another reason, its pieces are
    submitted once more, one by one.

    Args:
        work: the work.
        numbers: numbers of the pieces to be done.
        executor: the executor; None: this process.
        in_flight: number of tasks submitted at a time.

    Raises:
        TaskError: the executor failed twice to carry out a task. The results of other finished tasks come before.
    """
    if executor is None:
        for number in numbers:
            yield [work.call(number, work.argument(number))]
        return
    tasks = _Tasks(executor, work, numbers, in_flight)
    try:
        while tasks.unfinished:
            yield from tasks.next()
    finally:
        tasks.close()


class _Tasks(Generic[Result]):
    """The pieces of work that an executor carries out; see `carry_out`."""

    def __init__(self, executor: Executor, work: Work[Result], numbers: Sequence[int], in_flight: int) -> None:
        self._executor, self._work, self._in_flight = executor, work, in_flight
        # Pieces to be submitted: several in a task; each in a separate task; each in a separate task while no other task runs.
        self._waiting, self._alone, self._suspected = deque(numbers), deque[int](), deque[int]()
        self._pending: dict[Future[tuple[list[Result], float]], list[int]] = {}
        self._finished: SimpleQueue[Future[tuple[list[Result], float]]] = SimpleQueue()
        self._repeated: set[int] = set()  # pieces of tasks that have failed once
        self._judged: int | None = None  # the suspected piece that runs
        self._size = 1  # pieces of the next task

    @property
    def unfinished(self) -> bool:
        return bool(self._pending or self._waiting or self._alone or self._suspected)

    def next(self) -> Iterator[list[Result]]:
        """Results of the next task that ends, and of other finished tasks if it has broken the pool."""
        numbers: list[int] = []
        carried_out = False
        try:
            while len(self._pending) < self._in_flight and (numbers := self._taken()):
                self._submit(numbers)
            future = self._finished.get()
            numbers, carried_out = self._pending.pop(future), True
            results, seconds = future.result()
        except Exception as error:  # a pool that is broken or shut down, a cluster that is gone, a function that cannot be sent
            yield from self._after(error, numbers, carried_out)
            return
        self._judged = None
        self._waiting.extendleft(reversed(numbers[len(results) :]))
        self._size = max(1, min(2 * self._size, int(TASK * len(results) / max(seconds, 1e-9))))
        yield results

    def close(self) -> None:
        """Cancel all tasks that have not begun."""
        for future in self._pending:
            future.cancel()
        if isinstance(self._executor, Apart):
            self._executor.close()

    def _taken(self) -> list[int]:
        """Pieces of the next task; none while a suspected piece runs, or waits until no other task runs."""
        if self._judged is not None:
            return []
        if self._alone:
            return [self._alone.popleft()]
        if self._waiting:
            return [self._waiting.popleft() for _ in range(min(self._size, len(self._waiting)))]
        if self._suspected and not self._pending:
            self._judged = self._suspected.popleft()
            return [self._judged]
        return []

    def _submit(self, numbers: list[int]) -> None:
        # Dask identifies a call by its arguments, and answers an equal call with its earlier error. Therefore each call has a number.
        pieces = [(number, self._work.argument(number)) for number in numbers]
        future = self._executor.submit(run_task, self._work.call, pieces, uuid4().hex)
        self._pending[future] = numbers
        future.add_done_callback(self._finished.put)

    def _after(self, error: Exception, numbers: list[int], carried_out: bool) -> Iterator[list[Result]]:
        """Handle the exception of a task with these pieces, or of its submission."""
        apart = isinstance(self._executor, Apart) or numbers == [self._judged]
        self._judged = None
        if type(self._executor) is ProcessPoolExecutor and isinstance(error, BrokenProcessPool):
            yield from self._leave_broken_pool(self._executor, numbers)
        elif carried_out and _killed(error) and len(numbers) > 1:
            self._alone.extend(numbers)
        elif carried_out and _killed(error) and not apart:
            # Dask accuses every task that it had given to a worker when it died, not only the one that ran.
            self._suspected.extend(numbers)
        elif carried_out and _killed(error):
            yield [self._work.killed(numbers[0])]
        elif carried_out and not self._repeated.issuperset(numbers):
            # Dask loses the result of a task whose worker dies while it is fetched: "not enough values to unpack".
            self._repeated.update(numbers)
            self._alone.extend(numbers)
        else:
            yield from _left(self._finished, len(self._pending))
            raise TaskError from error

    def _leave_broken_pool(self, pool: ProcessPoolExecutor, numbers: list[int]) -> Iterator[list[Result]]:
        """Yield the finished results of the pool, and mark its other pieces to be done one by one in pools of one process."""
        wait(self._pending, timeout=LEAVE_TIME)
        for future, others in self._pending.items():
            good = future.done() and not future.cancelled() and future.exception() is None
            results = future.result()[0] if good else []
            self._alone.extend(others[len(results) :])
            yield from [results] if good else []
        self._alone.extend(numbers)
        self._pending, self._finished = {}, SimpleQueue()
        self._executor = apart = Apart(pool)
        self._in_flight = min(self._in_flight, apart.workers)


def run_task(call: Callable[[int, Any], Result], pieces: Sequence[tuple[int, Any]], _submission: str) -> tuple[list[Result], float]:
    """One task: the results of its pieces, or of the first few if they take long, and their time [s]."""
    results, start = [], time.perf_counter()
    for number, argument in pieces:
        results.append(call(number, argument))
        if (seconds := time.perf_counter() - start) > LONGEST_TASK:
            break
    return results, seconds


def _left(finished: "SimpleQueue[Future[tuple[list[Result], float]]]", count: int) -> Iterator[list[Result]]:
    """Results of other tasks that finish soon after a task has failed. In a broken pool all tasks fail at once."""
    until = time.monotonic() + LEAVE_TIME
    for _ in range(count):
        try:
            future = finished.get(timeout=max(0.0, until - time.monotonic()))
        except Empty:
            return
        if not future.cancelled() and future.exception() is None:
            yield future.result()[0]


def _killed(error: Exception) -> bool:
    """Whether a task has killed its worker in a pool, or several workers of a Dask cluster, which then stops repeating the task."""
    return isinstance(error, BrokenProcessPool) or type(error).__name__ == "KilledWorker"
