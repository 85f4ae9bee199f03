"""Sweeps: call a function at every point of a grid, on one machine or a cluster, resume after a stop, and make a table of results."""

from __future__ import annotations

import inspect
import os
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import is_whole_number, typed, whole_number
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.files import path_of
from ..common.frozen import FrozenMapping, read_only
from ..common.results import Record, Records, Tabular
from .execution import TaskError, Work, carry_out
from .grid import Grid, Scalar, fingerprint, make_grid
from .points import KILLS, Function, Results, call_at_point, call_at_points, fail
from .store import Contents, Store, open_file, store_path

Column = NDArray[Any]

POINTS_AT_ONCE = 1000  # with more of them `simulate_batch` makes hardly more runs a second
MOST_AT_ONCE = 1_000_000


@typed
def sweep(
    function: Function,
    grid: Mapping[str, object],
    *,
    to: str | os.PathLike[str] | None = None,
    at_once: bool | int = False,
    executor: Executor | None = None,
    paired: bool = False,
    retry_failed: bool = False,
    in_flight: int = 64,
    progress: Callable[[float], None] | None = None,
) -> Sweep:
    """Call a function at every point of a grid, and collect the results.

    Args:
        function: function that takes the axes' names as keyword arguments and returns a mapping of names to numbers, texts or bools, with
            the same names and kinds of values at every point. A point fails if the function raises (anything except KeyboardInterrupt),
            returns a number that is not finite, or ends its process; then the sweep continues.
        grid: name -> sequence of numbers or texts, or mapping of labels (numbers or texts) to any objects, such as loads. The results
            contain the labels. The points are all combinations; the last axis changes fastest.
        to: SQLite file for the results, with a name that ends with ``.sqlite``. Every finished point is written at once. After Ctrl-C, a
            crash or a kill repeat the call: it computes the missing points; after the end it reads the file. The file identifies the
            sweep by the names of the function and the axes and by the labels, not by the function's code. Checksums detect changes and
            damage, and such a file is refused. `read` makes a table of an unfinished file.
        at_once: whether the function takes many points at once, or their number (True: 1000). Then it takes an array (n,) of values for
            each axis, with labels of one kind, and returns an array (n,) or a list for each name. It may also return ``"error"``: n errors
            (exceptions or texts; None for a point that succeeded). If it raises, halves of the points are tried, until only the points
            that raise remain: these have failed.
        executor: an executor of `concurrent.futures`, such as ``ProcessPoolExecutor()``, or ``distributed.Client(...).get_executor()`` of a
            Dask cluster; it stays open. None: point by point in this process. If a worker of a process pool dies, the pool breaks; then the
            sweep continues with pools of one process each, made with the pool's arguments.
        paired: whether the axes are columns of equal length, so that point k has value k of each axis.
        retry_failed: whether to repeat points that failed in an earlier run.
        in_flight: number of tasks submitted at once; on a cluster at least twice its threads. A task is at least one call of the function
            and takes about a tenth of a second, which is lost if its worker is killed.
        progress: function called with the share of finished points, 0 to 1, including points of earlier runs.

    Raises:
        PinpressError: an argument is not as described, the function cannot be sent to other processes, the file belongs to another sweep,
            is damaged, in use, or cannot be written, results differ in names or kinds or make no table, or the executor has stopped. The
            file contains all finished points.
    """
    if executor is not None and not isinstance(executor, Executor):
        raise PinpressError(
            f"executor is {shown(executor)}: give an executor of concurrent.futures, such as ProcessPoolExecutor(), or get_executor() of a"
            " Dask client"
        )
    whole_number("in_flight", in_flight, 1, MOST_AT_ONCE)
    together = _points_at_once(at_once)
    points = make_grid(grid, paired)
    _check_call(function, points)
    if together:
        points.refuse_mixed_labels()
    if isinstance(executor, ProcessPoolExecutor):
        _check_sendable(function, points)
    name = name_of(function)
    with open_file(store_path(to), fingerprint(points, name)) as store:
        if retry_failed:
            store.forget_failed()
        finished = store.contents().done
        if not finished.all():
            store.begin()
        try:
            # A part whose process ends is repeated point by point, so that only the points that end it fail.
            for length in (together, 1) if together else (0,):
                _run(function, points, length, finished, store, executor, in_flight, progress)
        except TaskError as error:
            raise _report_lost_executor(error, int(finished.sum()), len(points), to) from error.__cause__
        return _sweep(name, points, store.contents())


@typed
def read(path: str | os.PathLike[str]) -> Sweep:
    """Read the file of a finished or stopped sweep. Results of failed and missing points are masked.

    Args:
        path: the file of `sweep` (its argument ``to``).

    Raises:
        PinpressError: there is no such file, it is damaged, or a sweep is writing it.
    """
    file = Path(path_of("path", path))
    if not file.exists():
        raise PinpressError(f"there is no file {file}: give the one that sweep has written by to=")
    with open_file(file) as store:
        description = store.description
        axes = {name: tuple(labels) for name, labels in description["axes"].items()}
        return _sweep(description["function"], Grid(axes, axes, description["paired"]), store.contents())


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(Tabular):
    """Results at all n points of a sweep, in the order of the grid (the last axis changes fastest). All arrays are read-only.

    Attributes:
        function: name of the function.
        axes: name -> labels of each axis.
        paired: whether the axes run side by side.
        results: name -> (n,) values of each result, as masked arrays with a mask at failed and missing points. Numbers are floats, with
            0.0 in place of -0.0.
        errors: number of a failed point -> type and text of the exception.
        missing: numbers of the missing points if `read` reads a stopped sweep; else empty.
    """

    function: str
    axes: Mapping[str, tuple[Scalar, ...]]
    paired: bool
    results: Mapping[str, Column]
    errors: Mapping[int, str]
    missing: tuple[int, ...] = ()

    @property
    def title(self) -> str:
        missing = f", {len(self.missing)} are not done" if self.missing else ""
        return f"Sweep of {self.function}: {len(self._grid)} points, {len(self.errors)} of which failed{missing}"

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes; (n,) if the axes are paired."""
        return self._grid.shape

    @property
    def failed(self) -> Records[FailedPoint]:
        """The points that failed, with their labels and errors."""
        points = (FailedPoint(k, dict(zip(self.axes, self._grid.labels(k), strict=True)), self.errors[k]) for k in sorted(self.errors))
        return Records(FailedPoint, points)

    def columns(self) -> dict[str, Column | list[str]]:
        """A row for each point: labels, results, and the error of a failed point."""
        errors = [self.errors.get(number, "") for number in range(len(self._grid))]
        return {**self._grid.columns(), **self.results, "error": errors}

    def column(self, name: str) -> Column:
        """Read an axis' labels or a result of all points (n,); results are masked at failed and missing points.

        Raises:
            UnknownNameError: there is no such axis or result.
        """
        if name in self.results:
            return self.results[name]
        if name in self.axes:
            return read_only(self._grid.columns()[name])
        raise UnknownNameError("result", name, [*self.results])

    def grid(self, name: str) -> Column:
        """Read an axis' labels or a result as an array with the axes' lengths as its shape.

        Raises:
            UnknownNameError: there is no such axis or result.
        """
        return self.column(name).reshape(self.shape)

    @property
    def _grid(self) -> Grid:
        return Grid(self.axes, self.axes, self.paired)


@dataclass(frozen=True, repr=False)
class FailedPoint(Record):
    """A point at which the function failed.

    Attributes:
        number: number of the point in the order of the grid.
        point: name of every axis -> label.
        error: type and text of the exception.
    """

    number: int
    point: Mapping[str, Scalar]
    error: str

    def row(self) -> dict[str, object]:
        return {"number": self.number, **self.point, "error": self.error}


def _sweep(function: str, grid: Grid, contents: Contents) -> Sweep:
    failed = ~contents.done
    failed[list(contents.errors)] = True
    return Sweep(
        function=function,
        axes=FrozenMapping(dict(grid.axes)),
        paired=grid.paired,
        results=read_only({name: np.ma.MaskedArray(values, failed.copy()) for name, values in contents.columns.items()}),
        errors=FrozenMapping(contents.errors),
        missing=tuple(np.flatnonzero(~contents.done).tolist()),
    )


def _points_at_once(at_once: object) -> int:
    """Number of points in a call; 0: the function takes one point."""
    if isinstance(at_once, bool | np.bool_):
        return POINTS_AT_ONCE if at_once else 0
    if not is_whole_number(at_once) or not 1 <= at_once <= MOST_AT_ONCE:
        raise PinpressError(f"at_once is {shown(at_once)}: give True, False, or the number of points, from 1 to {MOST_AT_ONCE}")
    return int(at_once)


def _check_call(function: Function, grid: Grid) -> None:
    """Refuse a function that does not take the axes; otherwise it would fail at every point."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # some functions written in C have no signature
        return
    try:
        signature.bind(**grid.point(0))
    except TypeError as error:
        raise PinpressError(f"{name_of(function)} does not take the axes {', '.join(grid.axes)}: {error}") from None


def _check_sendable(function: Function, grid: Grid) -> None:
    try:
        pickle.dumps(function)
    except Exception as error:  # pickling may raise anything
        raise PinpressError(
            f"{name_of(function)} cannot be sent to other processes ({error}): define it with def at the top level of a module"
        ) from error
    for name, objects in grid.objects.items():
        for label, value in zip(grid.axes[name], objects, strict=True):
            if value is label:
                continue
            try:
                pickle.dumps(value)
            except Exception as error:
                raise PinpressError(f"{shown(label)} of axis {shown(name)} cannot be sent to other processes ({error})") from error


def _work(function: Function, grid: Grid, missing: NDArray[np.intp], length: int) -> tuple[Sequence[int], Work[Results]]:
    """Numbers of the pieces of work, and the work. A piece is a point, or the missing ones of ``length`` consecutive points."""
    if not length:
        return missing.tolist(), Work(partial(call_at_point, function), grid.point, lambda number: fail([number], KILLS))
    parts, arguments = list(_parts(missing, length)), grid.arguments()
    killed = (lambda k: fail(parts[k], KILLS)) if length == 1 else (lambda _: fail([], KILLS))
    return range(len(parts)), Work(partial(call_at_points, function), lambda k: (parts[k], arguments(parts[k])), killed)


def _parts(missing: NDArray[np.intp], length: int) -> Iterator[Sequence[int]]:
    """The missing points, divided at multiples of the length: after a stop the function gets the same points together as before it."""
    for part in np.split(missing, np.flatnonzero(np.diff(missing // length)) + 1) if len(missing) else ():
        first, last = int(part[0]), int(part[-1]) + 1
        yield range(first, last) if last - first == len(part) else part.tolist()


def _run(
    function: Function,
    grid: Grid,
    length: int,
    finished: NDArray[np.bool_],
    store: Store,
    executor: Executor | None,
    in_flight: int,
    progress: Callable[[float], None] | None,
) -> None:
    """Call the function at the missing points, and mark these points as finished.

    Raises:
        TaskError: the executor is gone.
        PinpressError: as `Store.add`.
    """
    numbers, work = _work(function, grid, np.flatnonzero(~finished), length)
    count = int(finished.sum())
    arriving = carry_out(work, numbers, executor, in_flight)
    try:
        for arrived in arriving:
            store.add(arrived)
            for results in arrived:
                finished[list(results.numbers)] = True
                count += len(results.numbers)
            if progress is not None:
                progress(count / len(finished))
    finally:
        arriving.close()  # nothing more is begun


def _report_lost_executor(error: TaskError, finished: int, points: int, to: str | os.PathLike[str] | None) -> PinpressError:
    """The error of a sweep whose executor stopped after this number of finished points."""
    cause = error.__cause__
    where = "which are lost: give to=, a file that keeps them" if to is None else f"which are in {os.fspath(to)}"
    again = "" if to is None else "; call the same sweep again, with a new executor, to do the others"
    said = f"{type(cause).__name__}: {cause}".removesuffix(": ")
    return PinpressError(f"the executor could not do its work ({said}) after {finished} of {points} points, {where}{again}")


def name_of(function: object) -> str:
    """Name of a function; for a partial that of the function it calls."""
    inner = function.func if isinstance(function, partial) else function
    return str(getattr(inner, "__qualname__", type(inner).__qualname__))
