"""Sweeps: a function at every point of a grid, on one machine or a cluster, resumed where it was stopped; and its table of results."""

from __future__ import annotations

import inspect
import os
import pickle
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common import tables
from ..common.arguments import is_whole_number, typed
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.files import path_of
from ..common.frozen import read_only
from ..common.results import Record, Records, Tabular
from .execution import Function, Outcome, TaskError, done, points_of
from .grid import Grid, Scalar, gridded
from .store import Results, opened, results

Column = NDArray[Any]


@typed
def sweep(
    function: Function,
    grid: Mapping[str, object],
    *,
    to: str | os.PathLike[str] | None = None,
    executor: Executor | None = None,
    paired: bool = False,
    retry_failed: bool = False,
    in_flight: int = 64,
    progress: Callable[[float], None] | None = None,
) -> SweepTable:
    """Call a function at every point of a grid, and collect the results.

    Args:
        function: function that takes the axes' names as keyword arguments and returns a mapping of names to numbers, words or bools, with
            equal names and kinds of values at every point. Where it raises (anything but KeyboardInterrupt), returns a number that is not
            finite, or ends the executor's process that it runs in, the point counts as failed, and the sweep goes on.
        grid: name -> sequence of numbers or words, or mapping of labels (numbers or words) to any objects, such as loads. The labels stand
            in the results. The points are all combinations, the last axis fastest.
        to: SQLite file for the results, with a name that ends with ``.sqlite``. Every finished point is in it at once. Repeat the call
            after Ctrl-C, a crash or a kill, and it does the missing points; after the end it reads the file. The file knows the sweep by
            the names of the function and the axes and by the labels, not by the function's code. Checksums find what was changed or
            damaged, which is refused. `read` makes a table of an unfinished file.
        executor: an executor of `concurrent.futures`, such as ``ProcessPoolExecutor()``, or ``distributed.Client(...).get_executor()`` of a
            Dask cluster; it stays open. None: point by point in this process. When a worker of a process pool dies, the pool is broken, and
            the sweep goes on with pools of one process each, made with the pool's arguments.
        paired: whether the axes are columns of equal length, so that point k has value k of each.
        retry_failed: whether to repeat points that failed in an earlier run.
        in_flight: number of tasks submitted at once; on a cluster at least twice its threads. A task has so many points that it takes about
            a tenth of a second, which is lost when its worker is killed.
        progress: function called with the share of points done, 0 to 1, those of earlier runs included.

    Raises:
        PinpressError: an argument is not as described, the function cannot be sent to other processes, the file is of another sweep, is
            damaged, in use, or cannot be written, results differ in names or kinds, or the executor is gone. The file has all that was
            finished.
    """
    check_arguments(function, executor, in_flight, progress)
    points = gridded(grid, paired)
    check_call(function, points)
    if isinstance(executor, ProcessPoolExecutor):
        check_sendable(function, points)
    name = name_of(function)
    with results(points, name, to, retry_failed) as kept:
        _run(function, points, kept, executor, in_flight, progress, to)
        return table(name, points, kept.kinds, kept.known)


@typed
def read(path: str | os.PathLike[str]) -> SweepTable:
    """Read the file of a sweep, finished or stopped. Results of points that failed or are not done yet are masked.

    Args:
        path: the file that `sweep` has written, its argument ``to``.

    Raises:
        PinpressError: there is no such file, it is damaged, or a sweep is writing it.
    """
    file = Path(path_of("path", path))
    if not file.exists():
        raise PinpressError(f"there is no file {file}: give the one that sweep has written by to=")
    with opened(file) as found:
        said = found.description
        axes = {name: tuple(labels) for name, labels in said["axes"].items()}
        return table(said["function"], Grid(axes, axes, said["paired"]), found.kinds, found.outcomes())


@dataclass(frozen=True, eq=False, repr=False)
class SweepTable(Tabular):
    """Results at all n points of a sweep, in the order of the grid (last axis fastest). All arrays are read-only.

    Attributes:
        function: name of the function.
        axes: name -> labels of each axis.
        paired: whether the axes run side by side.
        shape: lengths of the axes; (n,) where they run side by side.
        values: name -> (n,) labels of each axis, then values of each result, as masked arrays with a mask at points that failed or are
            missing.
        failed: the points that failed, with their errors.
        missing: numbers of the points that are not done yet, where `read` reads a sweep that was stopped; else empty.
    """

    function: str
    axes: Mapping[str, tuple[Scalar, ...]]
    paired: bool
    shape: tuple[int, ...]
    values: Mapping[str, Column]
    failed: Records[FailedPoint]
    missing: tuple[int, ...] = ()

    @property
    def title(self) -> str:
        return f"SweepTable of {self.function}: {self._size} points, {self._not_there}"

    def __str__(self) -> str:
        over = " side by side" if self.paired else ""
        lines = [f"{self.function} at {self._size} points, {self._not_there}; axes{over}"]
        lines += tables.table(([name, f"{len(labels):6} values, {_ends(labels)}"] for name, labels in self.axes.items()), [26, 0])
        lines += ["", *tables.table([["Results", "smallest", "largest"]], [28, 14], indent="")]
        lines += tables.ranges({name: self.values[name] for name in self._results}, 26)
        lines += ["", "Failed"] if self.failed else []
        lines += [f"  {', '.join(f'{k}={v}' for k, v in bad.point.items())}: {bad.error.splitlines()[0]}" for bad in self.failed[:5]]
        lines += [f"  and {len(self.failed) - 5} more"] if len(self.failed) > 5 else []
        return "\n".join(lines)

    def columns(self) -> dict[str, Column | list[str]]:
        """A row for each point: labels, results, and the error where it failed."""
        errors = [""] * self._size
        for bad in self.failed:
            errors[bad.number] = bad.error
        return dict(self.values) | {"error": errors}

    def grid(self, name: str) -> Column:
        """A result as an array with the axes' lengths as its shape, masked at points that failed.

        Raises:
            UnknownNameError: there is no such result.
        """
        if name not in self.values:
            raise UnknownNameError("result", name, self._results)
        return self.values[name].reshape(self.shape)

    @property
    def _size(self) -> int:
        return int(np.prod(self.shape))

    @property
    def _not_there(self) -> str:
        return f"{len(self.failed)} of which failed" + (f", {len(self.missing)} are not done" if self.missing else "")

    @property
    def _results(self) -> list[str]:
        return [name for name in self.values if name not in self.axes]


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


def table(function: str, grid: Grid, kinds: Mapping[str, str], known: Mapping[int, Outcome]) -> SweepTable:
    """The table of a sweep from the outcomes that are known, by the numbers of their points."""
    nothing = Outcome(-1, {}, "")
    values = [known.get(number, nothing).values for number in range(len(grid))]
    masked = np.array([not found for found in values])
    columns: dict[str, Column] = {name: _column(labels) for name, labels in grid.columns().items()}
    columns |= {
        name: np.ma.MaskedArray(_filled([found.get(name) for found in values], kind), masked.copy()) for name, kind in kinds.items()
    }
    return SweepTable(
        function=function,
        axes=dict(grid.axes),
        paired=grid.paired,
        shape=grid.shape,
        values=read_only(columns),
        failed=Records(
            FailedPoint,
            (
                FailedPoint(number, dict(zip(grid.axes, grid.labels(number), strict=True)), known[number].error)
                for number in sorted(known)
                if known[number].error
            ),
        ),
        missing=tuple(number for number in range(len(grid)) if number not in known),
    )


def check_arguments(function: object, executor: object, in_flight: object, progress: object) -> None:
    if not callable(function):
        raise PinpressError(f"function is {shown(function)}: give a function that takes the axes' names and returns a mapping")
    if executor is not None and not isinstance(executor, Executor):
        raise PinpressError(
            f"executor is {shown(executor)}: give one of concurrent.futures, such as ProcessPoolExecutor(), or get_executor() of a"
            " Dask client"
        )
    if not is_whole_number(in_flight) or in_flight < 1:
        raise PinpressError(f"in_flight is {shown(in_flight)}: give a whole number of tasks, at least 1")
    if progress is not None and not callable(progress):
        raise PinpressError(f"progress is {shown(progress)}: give a function of the share done")


def check_call(function: Function, grid: Grid) -> None:
    """Refuse a function that does not take the axes, before it fails at every point."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # some functions written in C have no signature
        return
    try:
        signature.bind(**grid.point(0))
    except TypeError as error:
        raise PinpressError(f"{name_of(function)} does not take the axes {', '.join(grid.axes)}: {error}") from None


def check_sendable(function: Function, grid: Grid) -> None:
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


def _run(
    function: Function,
    grid: Grid,
    kept: Results,
    executor: Executor | None,
    in_flight: int,
    progress: Callable[[float], None] | None,
    to: str | os.PathLike[str] | None,
) -> None:
    """Call the function at the points that are missing.

    Raises:
        PinpressError: the executor is gone, or as `Results.add`.
    """
    numbers = [number for number in range(len(grid)) if number not in kept.known]
    work = done(points_of(function, grid), numbers, executor, in_flight)
    try:
        for found in work:
            kept.add(found)
            if progress is not None:
                progress(len(kept.known) / len(grid))
    except TaskError as error:
        raise executor_is_gone(error, len(kept.known), len(grid), to) from error.__cause__
    finally:
        work.close()  # nothing more is begun


def executor_is_gone(error: TaskError, known: int, points: int, to: str | os.PathLike[str] | None) -> PinpressError:
    """The error of a sweep whose executor could not do its work, when so many of its points were known."""
    cause = error.__cause__
    where = "which are lost: give to=, a file that keeps them" if to is None else f"which are in {os.fspath(to)}"
    again = "" if to is None else "; call the same sweep again, with a new executor, to do the others"
    said = f"{type(cause).__name__}: {cause}".removesuffix(": ")
    return PinpressError(f"the executor could not do its work ({said}) after {known} of {points} points, {where}{again}")


def _column(labels: list[Scalar]) -> Column:
    """Labels as an array; labels of different kinds as objects, because NumPy would turn all into words."""
    kinds = {str if isinstance(label, str) else bool if isinstance(label, bool) else float for label in labels}
    return np.array(labels) if len(kinds) == 1 else np.array(labels, dtype=object)


def _filled(values: list[Scalar | None], kind: str) -> Column:
    """Results as an array. The mask hides NaN or None, so that nothing passes for a result where the mask is taken off."""
    if kind != "number":
        return np.array(values, dtype=object if None in values else None)
    if None in values:
        return np.array([np.nan if value is None else value for value in values], dtype=float)
    return np.array(values)


def _ends(labels: tuple[Scalar, ...]) -> str:
    first, last = (f"{label:.6g}" if isinstance(label, float) else f"{label}" for label in (labels[0], labels[-1]))
    return first if len(labels) == 1 else f"{first} to {last}" if len(labels) > 2 else f"{first}, {last}"


def name_of(function: object) -> str:
    """Name of a function; for a partial that of the function it calls."""
    inner = function.func if isinstance(function, partial) else function
    return str(getattr(inner, "__qualname__", type(inner).__qualname__))
