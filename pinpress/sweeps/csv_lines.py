"""Outcomes of a sweep as the lines of a CSV: number of the point, labels, results, error, and a checksum of all these."""

import csv
import io
import zlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from ..common.errors import PinpressError
from ..common.tables import csv_lines
from .execution import Outcome
from .grid import LONGEST, Grid, Scalar, scalar

SUM = 9  # bytes of a comma and a checksum at the end of a line


def header(grid: Grid, kinds: Mapping[str, str]) -> bytes:
    """The first line."""
    (line,) = csv_lines([["point", *grid.axes, *kinds, "error", "checksum"]])
    return f"{line}\n".encode()


def lines(grid: Grid, kinds: Mapping[str, str], found: Iterable[Outcome]) -> bytes:
    """A line for each outcome, more where a text has lines of its own."""
    rows = (
        [str(number), *map(_text, grid.labels(number)), *("" if error else _text(values[name]) for name in kinds), error]
        for number, values, error in found
    )
    start = _start(grid, kinds)
    return b"".join(b"%s,%08x\n" % (row, zlib.crc32(row, start)) for row in map(str.encode, csv_lines(rows)))


def read(path: Path, grid: Grid, kinds: Mapping[str, str]) -> tuple[list[Outcome], bool]:
    """The outcomes in a file, and whether it ends as it should; a last line that is torn is left out.

    Raises:
        PinpressError: it cannot be read, is of another sweep, or is damaged.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise PinpressError(f"cannot read {path}: {error.strerror}") from error
    if header(grid, kinds).startswith(content):
        return [], content == header(grid, kinds)
    # in the second one all points have failed as yet
    columns = next((columns for columns in (kinds, {}) if content.startswith(header(grid, columns))), None)
    if columns is None:
        first = header(grid, kinds).decode().rstrip("\n")
        raise PinpressError(f"{path}: its first line is not that of this sweep, {first}; give another file")
    first_line = header(grid, columns)
    *pieces, torn = content.removeprefix(first_line).split(b"\n")
    start, begin, found = _start(grid, columns), 0, []
    while (end := _end(pieces, begin, start)) is not None:
        try:
            found.append(_outcome(b"\n".join(pieces[begin:end])[:-SUM], grid, columns))
        except (ValueError, IndexError, csv.Error):
            raise PinpressError(f"{path}: row {_row(first_line, begin)} is not of this sweep; give another file") from None
        begin = end
    if _damaged([*pieces, torn], begin, start, (2 + len(grid.axes) + len(columns)) * (4 * LONGEST + 3)):
        raise PinpressError(
            f"{path}: row {_row(first_line, begin)} is damaged or was changed, its checksum does not fit;"
            " put it right, or delete it to do its point anew"
        )
    return found, begin == len(pieces) and not torn


def _end(pieces: Sequence[bytes], begin: int, start: int) -> int | None:
    """Where a row ends that begins with a piece: after the first one whose checksum fits; None where none does."""
    total = start
    for k in range(begin, len(pieces)):
        piece = pieces[k]
        if piece[-SUM:] == b",%08x" % zlib.crc32(piece[:-SUM], total):
            return k + 1
        total = zlib.crc32(piece + b"\n", total)
    return None


def _damaged(pieces: Sequence[bytes], begin: int, start: int, longest: int) -> bool:
    """Whether what is left from a piece on is more than a row that was not written to its end: longer than any, or with rows after it."""
    if sum(map(len, pieces[begin:])) > longest:
        return True
    return any(pieces[k][:1].isdigit() and _end(pieces, k, start) is not None for k in range(begin + 1, len(pieces)))


def _row(first_line: bytes, piece: int) -> int:
    return first_line.count(b"\n") + piece + 1


def _start(grid: Grid, kinds: Mapping[str, str]) -> int:
    """What checksums begin with: the names of the axes, and names and kinds of the results."""
    return zlib.crc32(repr((list(grid.axes), kinds)).encode())


def _outcome(row: bytes, grid: Grid, kinds: Mapping[str, str]) -> Outcome:
    """The outcome in a row; ValueError where it is none of this grid."""
    words = next(csv.reader(io.StringIO(row.decode(), newline=""), strict=True))
    number, axes = int(words[0]), len(grid.axes)
    if not 0 <= number < len(grid) or words[1 : 1 + axes] != list(map(_text, grid.labels(number))):
        raise ValueError
    if words[-1]:
        return Outcome(number, {}, words[-1])
    values = {name: _value(kind, word) for (name, kind), word in zip(kinds.items(), words[1 + axes : -1], strict=True)}
    return Outcome(number, values, "")


def _text(value: Scalar) -> str:
    return value if isinstance(value, str) else repr(value)


def _value(kind: str, word: str) -> Scalar:
    if kind == "word":
        return word
    if kind == "bool":
        return word == "True"
    try:
        return int(word)
    except ValueError:
        return scalar(float(word))
