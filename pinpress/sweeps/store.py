"""Store the results of a sweep as they arrive: an SQLite database in a file or in memory that gets every point at once.

Points are committed to a write-ahead log. A kill (-9) at any instant leaves each commit in it whole or absent. No commit waits for the
disk: SQLite waits only when it copies the log into the database. So after a power cut the last points may be missing, but the database is
whole. (A rollback journal is as quick only with ``synchronous=OFF``, where a power cut may destroy the file.) The process that sweeps locks
the database, and the lock ends with the process. A sweep that ends or is interrupted leaves one file and no log.

Every result is a separate column, which other programs can read. SQLite does not notice changes by hand or by a faulty disk: so the
description of the sweep and every point have a checksum. Only the description contains the labels of the points, once for each axis.
"""

from __future__ import annotations

import json
import os
import sqlite3
import struct
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common import files
from ..common.errors import PinpressError
from .grid import Grid, differences, list_kinds
from .points import Results, Values, axis_name_taken

SUFFIX = ".sqlite"
PAGE = 1024  # bytes of a page of the database; a commit writes at least one
MOST_RESULTS = 1900  # SQLite allows 2000 columns
COLUMNS = {"point": "INTEGER", "error": "TEXT", "checksum": "INTEGER"}  # before those of the results
TYPES = {"number": "REAL", "bool": "BOOLEAN", "word": "TEXT"}


class Contents(NamedTuple):
    """The results in a database, of a sweep with n points.

    Attributes:
        done: (n,) whether a point is done.
        columns: name of a result -> (n,) values: NaN or None at points that failed or are missing.
        errors: number of a point that failed -> its error.
    """

    done: NDArray[np.bool_]
    columns: dict[str, Values]
    errors: dict[int, str]


class Store:
    """The database of one sweep; `open_file` makes it.

    Attributes:
        description: description of the sweep, see `grid.fingerprint`.
        kinds: name of a result -> "number", "bool" or "word"; empty until a point has succeeded.
    """

    def __init__(self, name: str, connection: sqlite3.Connection) -> None:
        """Read the description. ``name``: of the file, for messages.

        Raises:
            sqlite3.DatabaseError: the file is no database.
            ValueError: the database is not that of a sweep, or is damaged.
        """
        if connection.execute("PRAGMA quick_check").fetchall() != [("ok",)]:
            raise ValueError("its structure is broken")
        if connection.execute("SELECT name FROM sqlite_master ORDER BY rowid").fetchall() != [("sweep",), ("points",)]:
            raise ValueError("it does not have the tables of a sweep")
        rows = connection.execute("SELECT description, checksum FROM sweep").fetchall()
        if len(rows) != 1 or rows[0][1] != zlib.crc32(str(rows[0][0]).encode()):
            raise ValueError("the checksum of its description does not fit")
        self.description: dict[str, Any] = json.loads(rows[0][0])
        self._name, self._connection = name, connection
        self._seed = zlib.crc32(json.dumps({**self.description, "results": {}}).encode())
        self.kinds: dict[str, str] = {}
        self._name_results(self.description.pop("results"))
        columns = [row[1:3] for row in connection.execute("PRAGMA table_info(points)")]
        if columns != [*COLUMNS.items(), *((name, TYPES[kind]) for name, kind in zip(self._names, self.kinds.values(), strict=True))]:
            raise ValueError("its table of points does not have the columns that its description names")

    def contents(self) -> Contents:
        """All that is in the database.

        Raises:
            PinpressError: a point was changed or damaged.
        """
        axes = [len(labels) for labels in self.description["axes"].values()]
        size = axes[0] if self.description["paired"] else int(np.prod(axes))
        done, errors = np.zeros(size, dtype=bool), {}
        values = [np.full(size, np.nan if kind == "number" else None) for kind in self.kinds.values()]
        names = "".join(f", {_quote(name)}" for name in self._names)
        with _name_in_errors(self._name):
            rows = self._connection.execute(f"SELECT point, error{names}, checksum FROM points ORDER BY point")
            while piece := rows.fetchmany(500):  # half as long as with 10 000, which no cache holds
                self._refuse_changed(piece)
                done[[row[0] for row in piece]] = True
                errors.update({row[0]: row[1] for row in piece if row[1]})
                if good := [row for row in piece if not row[1]]:
                    numbers, _, *new, _ = zip(*good, strict=True)
                    places = np.array(numbers)
                    for column, arrived in zip(values, new, strict=True):
                        column[places] = arrived
        columns = {
            name: column if kind != "bool" else np.array([None if value is None else bool(value) for value in column])
            for (name, kind), column in zip(self.kinds.items(), values, strict=True)
        }
        return Contents(done, columns, errors)

    def begin(self) -> None:
        """Prepare for adding results, which go to a log."""
        with _name_in_errors(self._name):
            self._connection.execute("PRAGMA journal_mode=WAL")
            self._connection.execute("PRAGMA synchronous=NORMAL")

    def add(self, arrived: Sequence[Results]) -> None:
        """Write results, in one commit. When this returns they are safe against the death of the process.

        Raises:
            PinpressError: results differ in names or kinds from earlier ones (those before them are kept), or the file cannot be written.
        """
        kinds, fitting = self.kinds, list[Results]()
        try:
            for results in arrived:
                kinds = self._agreed(kinds, results)
                fitting.append(results)
        finally:
            if fitting:
                self._write(fitting, kinds)

    def forget_failed(self) -> None:
        """Delete the points that have failed."""
        with self._commit():
            self._connection.execute("DELETE FROM points WHERE error IS NOT NULL")

    def _agreed(self, kinds: Mapping[str, str], results: Results) -> dict[str, str]:
        """Names and kinds of the results; raises PinpressError if they differ from those of earlier results."""
        if results.clash:
            raise PinpressError(results.clash)
        if not results.kinds or results.kinds == kinds:
            return dict(kinds)
        if kinds:
            first = next(number for number, error in zip(results.numbers, results.errors, strict=True) if not error)
            raise PinpressError(
                f"the function returned {list_kinds(results.kinds)} at {self._point(first)}, but {list_kinds(kinds)} before:"
                " return the same names with values of the same kind at every point"
            )
        for name in results.kinds:
            if name in self.description["axes"]:
                raise PinpressError(axis_name_taken(name))
        if len(results.kinds) > MOST_RESULTS:
            raise PinpressError(f"the function returns {len(results.kinds)} values: return at most {MOST_RESULTS}")
        return dict(results.kinds)

    def _write(self, arrived: Sequence[Results], kinds: dict[str, str]) -> None:
        with self._commit():
            if kinds != self.kinds:
                self._name_results(kinds)
                for name, kind in zip(self._names, kinds.values(), strict=True):
                    self._connection.execute(f"ALTER TABLE points ADD COLUMN {_quote(name)} {TYPES[kind]}")
                self._connection.execute("UPDATE sweep SET description = ?, checksum = ?", _describe(self.description, kinds))
            marks = ", ?" * len(kinds)
            for results in arrived:
                self._connection.executemany(f"INSERT OR REPLACE INTO points VALUES (?, ?, ?{marks})", self._rows(results))

    def _rows(self, results: Results) -> list[tuple[object, ...]]:
        """Rows of the table of points."""
        if not results.kinds:
            nothing = [None] * len(self.kinds)
            rows = [(number, error, *nothing) for number, error in zip(results.numbers, results.errors, strict=True)]
        else:
            columns = dict(zip(results.kinds, results.columns, strict=True))
            plain = [_plain(columns[name]) for name in self.kinds]
            if any(results.errors):
                plain = [[None if error else value for error, value in zip(results.errors, values, strict=True)] for values in plain]
            rows = list(zip(results.numbers, results.errors, *plain, strict=True))
        return [
            (number, error or None, checksum, *values)
            for (number, error, *values), checksum in zip(rows, self._checksums(rows), strict=True)
        ]

    def _name_results(self, kinds: dict[str, str]) -> None:
        """Choose names of columns. SQLite takes x and X for one name, so a name that is taken is lengthened."""
        taken = set(COLUMNS)
        self.kinds, self._names = kinds, list[str]()
        for name in kinds:
            while name.lower() in taken:
                name += "_"
            taken.add(name.lower())
            self._names.append(name)
        self._pack = struct.Struct(f"<q{len(kinds)}d").pack

    def _refuse_changed(self, rows: Sequence[tuple[Any, ...]]) -> None:
        if [row[-1] for row in rows] == list(self._checksums(rows)):
            return
        number = next(row[0] for row, checksum in zip(rows, self._checksums(rows), strict=True) if row[-1] != checksum)
        raise PinpressError(
            f"{self._name}: point {number} is damaged or was changed: its checksum does not fit. To compute it again, delete"
            f" it: DELETE FROM points WHERE point = {number}"
        )

    def _checksums(self, rows: Iterable[tuple[Any, ...]]) -> Iterator[int]:
        """The checksums of points: of numbers as they are in memory, and of the checksums of words; -1 for a value of a wrong type."""
        pack, seed, end = self._pack, self._seed, 2 + len(self.kinds)
        words = "word" in self.kinds.values()
        for row in rows:
            if row[1]:
                yield zlib.crc32(f"{row[0]} {row[1]}".encode(), seed)
                continue
            values: Iterable[Any] = row[2:end]
            if words:
                values = (zlib.crc32(value.encode()) if isinstance(value, str) else value for value in values)
            try:
                yield zlib.crc32(pack(row[0], *values), seed)
            except struct.error:
                yield -1

    def _point(self, number: int) -> dict[str, object]:
        axes = self.description["axes"]
        grid = Grid(axes, axes, self.description["paired"])
        return dict(zip(axes, grid.labels(number), strict=True))

    @contextmanager
    def _commit(self) -> Iterator[None]:
        """Write everything in the block, or nothing."""
        with _name_in_errors(self._name), self._connection:
            self._connection.execute("BEGIN")
            yield


def store_path(to: str | os.PathLike[str] | None) -> Path | None:
    """The path of the file for the results of a sweep; raises PinpressError if its name does not end with `SUFFIX`."""
    if to is None:
        return None
    with files.refused(to):
        path = Path(to)
    if path.suffix != SUFFIX:
        name = path.with_suffix(SUFFIX) if path.name else f"runs{SUFFIX}"
        raise PinpressError(
            f"to is {os.fspath(to)!r}: a sweep is kept in an SQLite file, so write {os.fspath(name)!r}; a CSV or Parquet file is"
            " written from the result, by to_csv or to_parquet"
        )
    return path


@contextmanager
def open_file(path: Path | None, description: Mapping[str, Any] | None = None) -> Iterator[Store]:
    """Open the database of a sweep, or make it, and lock it until the end of the block.

    Args:
        path: path of the file; None: a database in memory.
        description: description of the sweep to which the file must belong, see `grid.fingerprint`; None: any sweep, to read it.

    Raises:
        PinpressError: the file cannot be opened or written, is in use, is damaged, or is of another sweep.
    """
    name = "the database in memory" if path is None else str(path)
    if path is not None and path.is_dir():
        raise PinpressError(f"{path} is a folder, not the file of a sweep: give the file, whose name ends with {SUFFIX}")
    if path is not None and path.exists() and not path.is_file():
        raise PinpressError(f"{path} is not a regular file: a sweep needs a separate file; give another name")
    with _name_in_errors(name):
        connection = sqlite3.connect(":memory:" if path is None else path, timeout=0.0, isolation_level=None)
    try:
        with _name_in_errors(name):
            connection.text_factory = lambda text: text.decode(errors="replace")  # damaged text is found by its checksum
            connection.execute(f"PRAGMA page_size={PAGE}")
            connection.execute("PRAGMA locking_mode=EXCLUSIVE")
            with connection:
                connection.execute("BEGIN" if description is None else "BEGIN EXCLUSIVE")
                if description is not None and not connection.execute("SELECT * FROM sqlite_master").fetchall():
                    connection.execute("CREATE TABLE sweep (description TEXT, checksum INTEGER)")
                    connection.execute("CREATE TABLE points (point INTEGER PRIMARY KEY, error TEXT, checksum INTEGER)")
                    connection.execute("INSERT INTO sweep VALUES (?, ?)", _describe(description, {}))
                database = Store(name, connection)
        if description is not None and (differ := "; ".join(differences(database.description, description))):
            raise PinpressError(f"{path} belongs to another sweep: {differ}. Give another file, or repeat the sweep of this file")
        yield database
    finally:
        with suppress(
            sqlite3.Error
        ):  # on a full disk the log stays next to the file; SQLite copies it into the file when this is opened again
            connection.execute("PRAGMA journal_mode=DELETE")
        connection.close()


@contextmanager
def _name_in_errors(name: str) -> Iterator[None]:
    """Turn errors of SQLite into a PinpressError that names the file."""
    try:
        yield
    except sqlite3.OperationalError as error:
        if "locked" in str(error):
            raise PinpressError(
                f"{name} is in use, by another sweep or a program that shows databases: wait for its end, or give another file"
            ) from None
        raise PinpressError(f"cannot write {name}: {error}; give a file in a directory you can write to") from error
    except (sqlite3.DatabaseError, ValueError) as error:
        raise PinpressError(f"{name} is damaged, or is not the file of a sweep ({error}): give another file, or delete it") from error


def _describe(description: Mapping[str, Any], kinds: Mapping[str, str]) -> tuple[str, int]:
    """Description and kinds as text, and its checksum."""
    text = json.dumps({**description, "results": kinds})
    return text, zlib.crc32(text.encode())


def _plain(values: Sequence[Any] | Values) -> list[Any]:
    """Values for SQLite: numbers and bools as floats, 0.0 in place of -0.0."""
    if isinstance(values, np.ndarray) and values.dtype != object:
        return (values + 0.0).tolist()  # type: ignore[no-any-return]
    return [value if isinstance(value, str) else value + 0.0 for value in values]


def _quote(name: str) -> str:
    """A name in SQL."""
    doubled = name.replace('"', '""')
    return f'"{doubled}"'
