"""Results of a sweep on disk as they come.

Three files: the results, ``.sweep`` beside them with what tells this sweep from another, and while it runs ``.lock``. Finished points are
appended to a CSV, a line each, complete or, after a kill, torn: a last line without its end is dropped. It is the file of results itself,
or for Parquet, which cannot be appended to, ``.csv`` beside it. At the end, all are written in the order of the grid, in one step. All that
is read has a checksum: of each line, and in ``.sweep`` of itself and of a Parquet file.
"""

import json
import os
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from ..common import files
from ..common.errors import PinpressError
from . import csv_lines as sweep_lines
from .execution import Outcome
from .grid import Grid, Scalar, differences, fingerprint

SUFFIXES = (".csv", ".parquet")


class Results:
    """Outcomes of a sweep by the numbers of their points; on disk too where there is a file.

    Attributes:
        known: point number -> outcome. kinds: names of the results -> "number", "bool" or "word", the same at all points.
    """

    def __init__(self, grid: Grid, function: str, path: Path | None) -> None:
        self.known: dict[int, Outcome] = {}
        self.kinds: dict[str, str] = {}
        self._grid, self._print, self._path, self._descriptor = grid, fingerprint(grid, function), path, -1
        self._checksum: object = None  # of the Parquet file

    def add(self, found: Sequence[Outcome]) -> None:
        """Keep outcomes, on disk before this returns (safe against the death of the process, not of the machine).

        Raises:
            PinpressError: the file cannot be written, or a result differs in names or kinds from earlier ones.
        """
        fresh = not self.kinds
        try:
            good = 0
            for outcome in found:
                self._check(outcome)
                good += 1
        finally:
            kept = found[:good]
            self.known.update((outcome.number, outcome) for outcome in kept)
            if self._path is not None and kept:
                if fresh and self.kinds:  # only now it is known what the columns are
                    self._begin()
                else:
                    self._append(sweep_lines.lines(self._grid, self.kinds, kept))

    def open(self, retry_failed: bool) -> None:
        """Read what earlier runs have left in the file, and begin to add to it."""
        assert self._path is not None
        side, target = self._side, self._path
        if side.exists():
            self._read_side(side)
        elif target.exists() or self._running.exists():
            raise PinpressError(f"{target} is there, but not {side.name} beside it, which says of what sweep it is: give another file")
        found: Iterable[Outcome] = ()
        whole = False
        if self._running.exists():  # which has all that was known when it was begun
            found, whole = sweep_lines.read(self._running, self._grid, self.kinds)
        elif target.exists():
            from .parquet import read

            found = read(target, self.kinds, self._checksum)
        self.known.update((outcome.number, outcome) for outcome in found)
        before = len(self.known)
        if retry_failed:
            self.known = {number: outcome for number, outcome in self.known.items() if not outcome.error}
        complete = len(self.known) == before == len(self._grid)
        if target.suffix == ".csv":
            finished = whole and list(self.known) == sorted(self.known)
        else:
            finished = target.exists() and not self._running.exists()
        if not (complete and finished):
            self._begin()

    def finish(self) -> None:
        """All points are known: write them in the order of the grid."""
        if self._path is None or self._descriptor < 0:
            return
        self.known = dict(sorted(self.known.items()))
        if self._path.suffix == ".parquet":
            from .parquet import write

            self._checksum = write(self._path, self._grid, self.kinds, list(self.known.values()))
            self._write_side()
            self.close()
            self._running.unlink()
        else:
            self._begin()

    def close(self) -> None:
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1

    @property
    def _side(self) -> Path:
        assert self._path is not None
        return self._path.with_name(self._path.name + ".sweep")

    @property
    def _running(self) -> Path:
        """The CSV that lines are appended to."""
        assert self._path is not None
        return self._path if self._path.suffix == ".csv" else self._path.with_name(self._path.name + ".csv")

    def _check(self, outcome: Outcome) -> None:
        """Raise where a result has other names or kinds than those before; the first decides."""
        if outcome.error:
            return
        kinds = {name: _kind(value) for name, value in outcome.values.items()}
        if not self.kinds:
            taken = [name for name in kinds if name in self._grid.axes]
            if taken:
                raise PinpressError(f"the function returns {taken[0]!r}, which is the name of an axis: give the result another name")
            self.kinds = kinds
        elif kinds != self.kinds:
            point = dict(zip(self._grid.axes, self._grid.labels(outcome.number), strict=True))
            raise PinpressError(
                f"the function returned {_listed(kinds)} at {point}, but {_listed(self.kinds)} before:"
                " return the same names with values of the same kind at every point"
            )

    def _begin(self) -> None:
        """Write all that is known anew, in one step, and open it to add lines."""
        self.close()
        self._write_side()
        rows = sweep_lines.lines(self._grid, self.kinds, self.known.values())
        files.write(self._running, sweep_lines.header(self._grid, self.kinds) + rows)
        with files.refused(self._running):
            self._descriptor = os.open(self._running, os.O_WRONLY | os.O_APPEND | os.O_CLOEXEC)

    def _append(self, content: bytes) -> None:
        with files.refused(self._running):
            while content:
                content = content[os.write(self._descriptor, content) :]

    def _write_side(self) -> None:
        said = {**self._print, "results": self.kinds, "parquet": self._checksum}
        side = json.dumps({**said, "checksum": zlib.crc32(json.dumps(said, allow_nan=False).encode())}, allow_nan=False)
        if not self._side.exists() or self._side.read_text("utf-8") != side:
            files.write(self._side, side.encode())

    def _read_side(self, side: Path) -> None:
        """Take over the kinds of the results; raise where the file is of another sweep."""
        try:
            before = json.loads(side.read_text("utf-8"))
            checksum = before.pop("checksum")
            if zlib.crc32(json.dumps(before).encode()) != checksum:
                raise ValueError("it is damaged or was changed, its checksum does not fit")
            self.kinds, self._checksum = before["results"], before["parquet"]
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise PinpressError(f"{side} cannot be read ({error}): give another file, or delete it with its results") from error
        if differ := "; ".join(differences(before, self._print)):
            raise PinpressError(f"{self._path} is of another sweep: {differ}. Give another file, or call the sweep that it is of")


@contextmanager
def results(grid: Grid, function: str, to: str | os.PathLike[str] | None, retry_failed: bool) -> Iterator[Results]:
    """The results of a sweep, those of earlier runs in the file among them; nobody else writes to the file meanwhile."""
    if to is None:
        yield Results(grid, function, None)
        return
    with files.refused(to):
        path = Path(to)
    if path.exists() and not path.is_file():
        raise PinpressError(f"{path} is no regular file: a sweep is kept in one of its own; give another name")
    if path.suffix not in SUFFIXES:
        raise PinpressError(f"to is {os.fspath(to)!r}: give a file whose name ends with {' or '.join(SUFFIXES)}")
    if path.suffix == ".parquet":
        from .parquet import installed

        installed()
    try:
        from .lock import locked
    except ImportError:  # of the locks
        raise PinpressError("a sweep to a file needs the locks of Linux or macOS: leave to= out, and write the table at the end") from None
    with locked(path):
        kept = Results(grid, function, path)
        try:
            kept.open(retry_failed)
            yield kept
        finally:
            kept.close()


def _kind(value: Scalar) -> str:
    return "bool" if isinstance(value, bool) else "word" if isinstance(value, str) else "number"


def _listed(kinds: Mapping[str, str]) -> str:
    return ", ".join(f"{name} ({kind})" for name, kind in kinds.items())
