"""Results of a sweep as they arrive, and their file: an SQLite database to which every point is written as soon as it is finished.

Points are committed to a write-ahead log. A kill (-9) at any instant leaves each commit in it whole or absent. No commit waits for the
disk: SQLite waits only when it copies the log into the database. So after a power cut the last points may be missing, but the database is
whole. (A rollback journal is as quick only with ``synchronous=OFF``, where a power cut may destroy the file.) The process that sweeps locks
the database, and the lock ends with the process. A sweep that ends or is interrupted leaves one file and no log.

SQLite does not notice changes by hand or by a faulty disk: so the description of the sweep and every point have a checksum.
"""

from __future__ import annotations

import json
import os
import sqlite3
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ..common import files
from ..common.errors import PinpressError
from .execution import Outcome
from .grid import Grid, differences, fingerprint, kind, listed

SUFFIX = ".sqlite"
PAGE = 1024  # bytes of a page of the database; a commit writes at least one
TABLES = [
    "CREATE TABLE sweep (description TEXT, checksum INTEGER)",
    "CREATE TABLE points (number INTEGER PRIMARY KEY, results TEXT, error TEXT, checksum INTEGER)",
]


class Results:
    """Outcomes of a sweep by the numbers of their points, and where there is a file, also in it.

    Attributes:
        known: number of a point -> its outcome.
        kinds: name of a result -> "number", "bool" or "word", for all points.
    """

    def __init__(self, grid: Grid, file: SweepFile | None = None) -> None:
        self._grid, self._file = grid, file
        self.known: dict[int, Outcome] = {} if file is None else file.outcomes()
        self.kinds: Mapping[str, str] = {} if file is None else file.kinds

    def add(self, found: Sequence[Outcome]) -> None:
        """Keep outcomes. When this returns they are in the file, safe against the death of the process.

        Raises:
            PinpressError: a result differs in names or kinds from earlier ones (the outcomes before it are kept), or the file cannot be
                written.
        """
        fitting: list[Outcome] = []
        try:
            for outcome in found:
                self._check(outcome)
                fitting.append(outcome)
        finally:
            self.known |= {outcome.number: outcome for outcome in fitting}
            if self._file is not None and fitting:
                self._file.add(fitting, self.kinds)

    def _check(self, outcome: Outcome) -> None:
        """Raise PinpressError where a result has other names or kinds than the first one."""
        if outcome.error:
            return
        kinds = {name: kind(value) for name, value in outcome.values.items()}
        if not self.kinds:
            taken = [name for name in kinds if name in self._grid.axes]
            if taken:
                raise PinpressError(f"the function returns {taken[0]!r}, which is the name of an axis: give the result another name")
            self.kinds = kinds
        elif kinds != self.kinds:
            point = dict(zip(self._grid.axes, self._grid.labels(outcome.number), strict=True))
            raise PinpressError(
                f"the function returned {listed(kinds)} at {point}, but {listed(self.kinds)} before:"
                " return the same names with values of the same kind at every point"
            )


@contextmanager
def results(grid: Grid, function: str, to: str | os.PathLike[str] | None, retry_failed: bool) -> Iterator[Results]:
    """The results of a sweep, with those of earlier runs in its file.

    Raises:
        PinpressError: as `opened`, or ``to`` is no name for such a file.
    """
    if to is None:
        yield Results(grid)
        return
    with files.refused(to):
        path = Path(to)
    if path.suffix != SUFFIX:
        raise PinpressError(
            f"to is {os.fspath(to)!r}: give a file whose name ends with {SUFFIX}; a CSV or Parquet file is written from the result, by"
            " to_csv or to_parquet"
        )
    with opened(path, fingerprint(grid, function)) as file:
        if retry_failed:
            file.forget_failed()
        kept = Results(grid, file)
        if len(kept.known) < len(grid):
            file.begin()
        yield kept


class SweepFile:
    """The database of one sweep; `opened` makes it.

    Attributes:
        description: description of the sweep, see `grid.fingerprint`.
        kinds: name of a result -> "number", "bool" or "word"; empty until a point has succeeded.
    """

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        """Read the description.

        Raises:
            sqlite3.DatabaseError: The file is no database.
            ValueError: it is no database of a sweep, or is damaged.
        """
        if connection.execute("PRAGMA quick_check").fetchall() != [("ok",)]:
            raise ValueError("its structure is broken")
        if [table for (table,) in connection.execute("SELECT sql FROM sqlite_master ORDER BY rowid")] != TABLES:
            raise ValueError("it does not have the tables of a sweep")
        rows = connection.execute("SELECT description, checksum FROM sweep").fetchall()
        if len(rows) != 1 or rows[0][1] != _checksum(rows[0][0]):
            raise ValueError("the checksum of its description does not fit")
        self.description: dict[str, Any] = json.loads(rows[0][0])
        self.kinds: dict[str, str] = self.description.pop("results")
        self._path, self._connection, self._seed = path, connection, _checksum(json.dumps(self.description))

    def outcomes(self) -> dict[int, Outcome]:
        """The outcomes in the file, by the numbers of their points.

        Raises:
            PinpressError: one of them was changed or damaged.
        """
        known = {}
        with _reported(self._path):
            for number, values, error, checksum in self._connection.execute("SELECT * FROM points ORDER BY number"):
                if checksum != _checksum((number, values, error), self._seed):
                    raise PinpressError(
                        f"{self._path}: point {number} is damaged or was changed, its checksum does not fit; to compute it again, delete"
                        f" it: DELETE FROM points WHERE number = {number}"
                    )
                known[number] = Outcome(number, {} if error else dict(zip(self.kinds, json.loads(values), strict=True)), error or "")
        return known

    def begin(self) -> None:
        """Prepare for adding outcomes, which go to a log."""
        with _reported(self._path):
            self._connection.execute("PRAGMA journal_mode=WAL")
            self._connection.execute("PRAGMA synchronous=NORMAL")

    def add(self, found: Sequence[Outcome], kinds: Mapping[str, str]) -> None:
        """Commit outcomes and the kinds of their results, all or none."""
        rows = [(number, None if error else json.dumps([values[name] for name in kinds]), error or None) for number, values, error in found]
        with _reported(self._path), self._connection:
            if kinds != self.kinds:
                self.kinds = dict(kinds)
                self._connection.execute("UPDATE sweep SET description = ?, checksum = ?", _described(self.description, kinds))
            self._connection.executemany(
                "INSERT OR REPLACE INTO points VALUES (?, ?, ?, ?)", [(*row, _checksum(row, self._seed)) for row in rows]
            )

    def forget_failed(self) -> None:
        """Delete the points that have failed."""
        with _reported(self._path), self._connection:
            self._connection.execute("DELETE FROM points WHERE error IS NOT NULL")


@contextmanager
def opened(path: Path, description: Mapping[str, Any] | None = None) -> Iterator[SweepFile]:
    """Open the file of a sweep, or make it, and lock it until the end of the block.

    Args:
        path: path of the file.
        description: description of the sweep that the file must be of, see `grid.fingerprint`; None: of any sweep, for reading alone.

    Raises:
        PinpressError: the file cannot be opened or written, is in use, is damaged, or is of another sweep.
    """
    if path.is_dir():
        raise PinpressError(
            f"{path} is a folder, not the file of a sweep. pandas.read_parquet reads the Parquet files of a large sweep; the call that"
            " wrote them returns them again"
        )
    if path.exists() and not path.is_file():
        raise PinpressError(f"{path} is no regular file: a sweep is kept in one of its own; give another name")
    with _reported(path):
        connection = sqlite3.connect(path, timeout=0.0)
    try:
        with _reported(path):
            connection.text_factory = lambda text: text.decode(errors="replace")  # damaged text is found by its checksum
            connection.execute(f"PRAGMA page_size={PAGE}")
            connection.execute("PRAGMA locking_mode=EXCLUSIVE")
            with connection:
                connection.execute("BEGIN" if description is None else "BEGIN EXCLUSIVE")
                if description is not None and not connection.execute("SELECT * FROM sqlite_master").fetchall():
                    for table in TABLES:
                        connection.execute(table)
                    connection.execute("INSERT INTO sweep VALUES (?, ?)", _described(description, {}))
                file = SweepFile(path, connection)
        if description is not None and (differ := "; ".join(differences(file.description, description))):
            raise PinpressError(f"{path} is of another sweep: {differ}. Give another file, or repeat the sweep that it is of")
        yield file
    finally:
        with suppress(sqlite3.Error):  # on a full disk the log stays beside the file, and is copied into it when it is opened next
            connection.execute("PRAGMA journal_mode=DELETE")
        connection.close()


@contextmanager
def _reported(path: Path) -> Iterator[None]:
    """Turn errors of SQLite into a PinpressError that names the file."""
    try:
        yield
    except sqlite3.OperationalError as error:
        if "locked" in str(error):
            raise PinpressError(
                f"{path} is in use, by another sweep or a program that shows databases: wait for its end, or give another file"
            ) from None
        raise PinpressError(f"cannot write {path}: {error}; give a file in a directory you can write to") from error
    except (sqlite3.DatabaseError, ValueError) as error:
        raise PinpressError(f"{path} is damaged, or no file of a sweep ({error}): give another file, or delete it") from error


def _described(description: Mapping[str, Any], kinds: Mapping[str, str]) -> tuple[str, int]:
    """Description and kinds as text, and its checksum."""
    text = json.dumps({**description, "results": kinds})
    return text, _checksum(text)


def _checksum(value: object, seed: int = 0) -> int:
    return zlib.crc32(repr(value).encode(), seed)
