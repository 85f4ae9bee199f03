"""Outcomes of a sweep as the lines of a CSV: number of the point, labels, results, error."""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from .errors import PinpressError
from .sweep_grid import Grid, Scalar, scalar
from .sweep_run import Outcome


def header(grid: Grid, kinds: Mapping[str, str]) -> bytes:
    """The first line."""
    return _csv([_names(grid, kinds)])


def lines(grid: Grid, kinds: Mapping[str, str], found: Iterable[Outcome]) -> bytes:
    """A line for each outcome."""
    return _csv(
        [
            str(number),
            *map(_text, grid.labels(number)),
            *("" if error else _text(values[name]) for name in kinds),
            error,
        ]
        for number, values, error in found
    )


def read(path: Path, grid: Grid, kinds: Mapping[str, str]) -> tuple[list[Outcome], bool]:
    """The outcomes in a file, and whether it ends as it should; a last line that is torn is left out.

    Raises:
        PinpressError: it cannot be read, or has a line that is not of this sweep.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise PinpressError(f"cannot read {path}: {error.strerror}") from error
    rows, torn = _rows(content)
    short = _names(grid, {})  # of a file in which all points have failed as yet
    if rows and rows[0] not in (_names(grid, kinds), short):
        raise PinpressError(f"{path}: its first line is not that of this sweep, {','.join(_names(grid, kinds))}; give another file")
    columns = {} if rows and rows[0] == short else kinds
    found = []
    for line, row in enumerate(rows[1:], start=2):
        try:
            found.append(_outcome(row, grid, columns))
        except (ValueError, IndexError):
            raise PinpressError(
                f"{path}: row {line} is not of this sweep ({','.join(row)[:80]}); put it right, or delete it to do its point anew"
            ) from None
    return found, bool(rows) and not torn


def _rows(content: bytes) -> tuple[list[list[str]], bool]:
    """The rows of a CSV that end as they should, and whether something after them does not."""
    torn = not content.endswith(b"\n")
    try:
        text = content.decode()
    except UnicodeDecodeError as error:  # torn within a character
        text, torn = content[: error.start].decode(), True
    rows: list[list[str]] = []
    try:
        for row in csv.reader(io.StringIO(text, newline=""), strict=True):
            rows.append(row)
    except csv.Error:  # a quotation that does not end: its row has not been given
        return rows, True
    return (rows[:-1], True) if torn else (rows, False)


def _outcome(row: Sequence[str], grid: Grid, kinds: Mapping[str, str]) -> Outcome:
    """The outcome in a row; ValueError where it is none of this grid."""
    number, axes = int(row[0]), len(grid.axes)
    if not 0 <= number < len(grid) or len(row) != 2 + axes + len(kinds):
        raise ValueError
    if row[1 : 1 + axes] != list(map(_text, grid.labels(number))):
        raise ValueError
    if row[-1]:
        return Outcome(number, {}, row[-1])
    if not kinds:
        raise ValueError
    values = {name: _value(kind, word) for (name, kind), word in zip(kinds.items(), row[1 + axes : -1], strict=True)}
    return Outcome(number, values, "")


def _names(grid: Grid, kinds: Mapping[str, str]) -> list[str]:
    return ["point", *grid.axes, *kinds, "error"]


def _text(value: Scalar) -> str:
    return value if isinstance(value, str) else repr(value)


def _value(kind: str, word: str) -> Scalar:
    if kind == "word":
        return word
    if kind == "bool":
        if word not in ("True", "False"):
            raise ValueError(word)
        return word == "True"
    try:
        return int(word)
    except ValueError:
        return scalar(float(word))


def _csv(rows: Iterable[Sequence[str]]) -> bytes:
    text = io.StringIO(newline="")
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode()
