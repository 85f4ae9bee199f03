"""Large sweeps: millions of points in parts, on a cluster, each part a Parquet file in a folder; nobody holds all points at once."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Mapping
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..common import tables
from ..common.arguments import typed, whole_number
from ..common.errors import PinpressError
from ..common.files import path_of
from ..common.results import Tabular
from ..common.tables import Column
from .execution import KILLS, Function, TaskError, Work, done
from .folder import PartFolder, damaged, footer, part_folder, parts_in
from .grid import gridded
from .parts import ClashError, Division, Found, Part, Points, computed, encoded, found_at_once, found_one_by_one, joined
from .sweeping import check_arguments, check_call, check_sendable, executor_is_gone, name_of

MOST_A_PART = 1_000_000


@typed
def sweep_to_parquet(
    function: Function,
    grid: Mapping[str, object],
    *,
    to: str | os.PathLike[str],
    points_a_part: int = 1000,
    at_once: bool = False,
    executor: Executor | None = None,
    paired: bool = False,
    in_flight: int = 64,
    progress: Callable[[float], None] | None = None,
) -> ParquetSweep:
    """Call a function at every point of a grid of any size, and write the results to a folder of Parquet files.

    The points are divided into parts of consecutive points. A worker computes a part and sends it back as the content of a file, which this
    process writes. It holds no more than the parts that are under way. Parts are the same whoever computes them, byte by byte.

    Args:
        function: as in `sweep`; or with ``at_once`` a function that takes for each axis an array (n,) of its values at n points, as many as
            a part has, and returns for each name an array (n,), or a list. It may also return ``"error"``, n errors (exceptions or words;
            None where there is none) of points that failed. Where it raises, halves of the points are tried, down to those at which it
            raises: these have failed.
        grid: as in `sweep`; the labels of an axis are of one kind: numbers, bools or words.
        to: folder for the results, one of its own. Repeat the call after Ctrl-C, a crash or a kill, and it does the parts that are missing.
            To do a part again, delete its file. The folder knows the sweep by the names of the function and the axes and by the labels, not
            by the function's code.
        points_a_part: points of a part. A worker that dies loses the part that it was working on, which is done again.
        at_once: whether the function takes all points of a part at once.
        executor: as in `sweep`. With a Dask cluster the workers need pyarrow too.
        paired: as in `sweep`.
        in_flight: number of tasks submitted at once; on a cluster at least twice its threads. A task has as many parts as take a tenth of a
            second, but at least one.
        progress: as in `sweep`.

    Returns:
        The parts in the folder. Results that are numbers are 64-bit floats there. Points that failed are null, with their errors beside
        them.

    Raises:
        PinpressError: an argument is not as described, the function cannot be sent to other processes, the folder is of another sweep, has
            other files, is damaged, or cannot be written, results differ in names or kinds or make no table, pyarrow is not installed, or
            the executor is gone. The folder has all parts that were finished.
    """
    check_arguments(function, executor, in_flight, progress)
    length = whole_number("points_a_part", points_a_part, 1, MOST_A_PART)
    division = Division(gridded(grid, paired), length)
    check_call(function, division.grid)
    if isinstance(executor, ProcessPoolExecutor):
        check_sendable(function, division.grid)
    path = Path(path_of("to", to))
    tables.needs_pyarrow()
    folder = part_folder(path, name_of(function), at_once, division)
    try:
        with closing(_parts(function, at_once, division, folder, executor, in_flight)) as parts:
            for part in parts:
                folder.add(part)
                if progress is not None:
                    progress(folder.points / len(division.grid))
    except TaskError as error:
        raise executor_is_gone(error, folder.points, len(division.grid), to) from error.__cause__
    finally:
        folder.write_held()
    return ParquetSweep(
        folder=os.fspath(path),
        function=name_of(function),
        axes=tuple(division.grid.axes),
        results=tuple(folder.kinds),
        points=len(division.grid),
        failed=sum(folder.known.values()),
        parts=len(division),
    )


@dataclass(frozen=True, repr=False)
class ParquetSweep(Tabular):
    """A finished sweep in a folder of Parquet files, with n points. The columns are read from there when they are asked for.

    Attributes:
        folder: path of the folder.
        function: name of the function.
        axes: names of the axes.
        results: names of the results.
        points: number of points.
        failed: number of points that failed.
        parts: number of parts, each a file.
    """

    folder: str
    function: str
    axes: tuple[str, ...]
    results: tuple[str, ...]
    points: int
    failed: int
    parts: int

    @property
    def title(self) -> str:
        return (
            f"ParquetSweep of {self.function}: {self.points} points in {self.parts} parts, {self.failed} of which failed, in {self.folder}"
        )

    def columns(self) -> dict[str, Column]:
        """A row for each point: its number, labels, results, masked where it failed, and the error. All n rows are read.

        Raises:
            PinpressError: a part is damaged or missing.
        """
        import pyarrow  # optional, and slow to import
        import pyarrow.parquet

        pieces = []
        for file in self._files():
            try:
                pieces.append(pyarrow.parquet.read_table(file, page_checksum_verification=True))
            except (OSError, pyarrow.ArrowException) as error:
                raise damaged(file, error) from error
        table = pyarrow.concat_tables(pieces)
        return {name: _column(table[name]) for name in table.column_names}

    def __str__(self) -> str:
        """The smallest and the largest value of each axis and result, from the ends of the files."""
        ends: dict[str, list[Any]] = {name: [] for name in (*self.axes, *self.results)}
        for file in self._files():
            group = footer(file).row_group(0)
            for k in range(group.num_columns):
                column = group.column(k)
                if column.path_in_schema in ends and column.statistics is not None and column.statistics.has_min_max:
                    ends[column.path_in_schema] += [column.statistics.min, column.statistics.max]
        rows = [
            [name, tables.cell(_shown(min(values))), tables.cell(_shown(max(values)))] if values else [name]
            for name, values in ends.items()
        ]
        width = 4 + max(map(len, ends))
        return "\n".join([self.title, *tables.table([["", "smallest", "largest"]], [width, 14]), *tables.table(rows, [width, 14])])

    def _files(self) -> list[Path]:
        """The files of all parts, in order."""
        found = [file for _, file in parts_in(Path(self.folder))]
        if len(found) != self.parts:
            raise PinpressError(
                f"{self.folder} has {len(found)} parts, not {self.parts}: call the sweep again, which does those that are missing"
            )
        return found


def _parts(
    function: Function, at_once: bool, division: Division, folder: PartFolder, executor: Executor | None, in_flight: int
) -> Generator[Part, None, None]:
    """The parts that the folder does not have, as they are finished."""
    missing = [number for number in range(len(division)) if number not in folder.known]
    killed: list[int] = []

    def kills(number: int) -> Part:
        killed.append(number)
        return Part(number, b"", {}, 0)

    for parts in done(Work(partial(computed, function, at_once, folder.checksum), division.stretch, kills), missing, executor, in_flight):
        yield from (part for part in parts if part.content or part.clash)
    for number in killed:
        yield _point_by_point(function, at_once, division.stretch(number).points(), number, folder.checksum, executor, in_flight)


def _point_by_point(
    function: Function, at_once: bool, points: Points, number: int, sweep: str, executor: Executor | None, in_flight: int
) -> Part:
    """A part that ends its process: a task for each point, so that only those fail that do so."""
    found: dict[int, Found] = {}
    work = Work(
        partial(_alone, found_at_once if at_once else found_one_by_one, function),
        lambda k: points.between(k, k + 1),
        lambda k: (k, Found({}, [KILLS])),
    )
    for pieces in done(work, range(len(points)), executor, in_flight):
        found |= {k: piece for k, piece in pieces if isinstance(piece, Found)}
        for clash in (piece for _, piece in pieces if isinstance(piece, str)):
            return Part(number, b"", {}, 0, clash)
    try:
        return encoded(number, points, joined([found[k] for k in range(len(points))]), sweep)
    except ClashError as error:
        return Part(number, b"", {}, 0, str(error))


def _alone(find: Callable[[Function, Points], Found], function: Function, k: int, points: Points) -> tuple[int, Found | str]:
    """One point, the k-th of its part; or why what the function returned makes no table."""
    try:
        return k, find(function, points)
    except ClashError as error:
        return k, str(error)


def _column(column: Any) -> Column:
    """A column of Arrow: an array, masked where there is no value, or a list of words."""
    if str(column.type) == "string":
        return column.to_pylist()  # type: ignore[no-any-return]
    masked = column.is_null().to_numpy()
    values = column.fill_null(False if str(column.type) == "bool" else 0).to_numpy()
    return np.ma.MaskedArray(values, masked) if masked.any() else np.asarray(values)


def _shown(value: Any) -> object:
    """A number as a float, for a cell."""
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else value
