"""Tables: columns of numbers and words in files, in other programs and in notebooks, and rows as lines of text.

A column is an array (n,), or a sequence with None, or a masked array, where there is no value. Its name carries the unit: "force [N]".
"""

import html as markup
import io
import itertools
import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from . import files
from .errors import PinpressError
from .quantities import Array, ShownUnit, grouped, quantity

if TYPE_CHECKING:
    import pandas

    DataFrame: TypeAlias = pandas.DataFrame

Column: TypeAlias = NDArray[Any] | Sequence[object]
Columns: TypeAlias = Mapping[str, Column]

MOST_ROWS, MOST_COLUMNS = 20, 20  # most rows and columns of a table in a notebook
GAP = "..."  # stands for what is left out of a long table
_NAME, _NUMBER, _UNIT = 26, 12, 7  # widths of the columns of an `entry`

_DIGITS = 5  # of the largest number of a table

# A 0 with a minus sign as a separate word. If there are blanks before the sign, another one takes its place.
_PADDED_MINUS, _MINUS = (re.compile(before + r"-(?=0(?:\.0*)?(?![\w.]))") for before in ("(?<=  )", r"(?<![^\s(\[])"))

T = TypeVar("T")


def by_driver(heads: Sequence[tuple[str, str]], values: Array, drivers: Sequence[str]) -> dict[str, Array]:
    """A column (n,) under its name; of several drivers (n, drivers), one each. ``heads``: name and unit, by driver."""
    if values.ndim == 1:
        name, unit = heads[0]
        return {f"{name} [{unit}]": values}
    named = enumerate(zip(drivers, heads, strict=True))
    return {f"{name}_{driver} [{unit}]": values[:, i] for i, (driver, (name, unit)) in named}


def by_axis(name: str, unit: str, vector: Array) -> dict[str, Array]:
    """The columns of a vector (n, 3) along the world's axes."""
    return {f"{name}_{axis} [{unit}]": vector[:, i] for i, axis in enumerate("xyz")}


def write_csv(path: str | os.PathLike[str], columns: Columns) -> None:
    """Write columns with their names as header, numbers to full precision; what has no value is left empty. A file whose name ends with
    .gz is compressed.

    Raises:
        PinpressError: a number that is not finite, or the file cannot be written.
    """
    import csv  # to save start-up time: a millisecond

    _refuse_not_finite(columns)
    lines: list[str] = []
    # With this line end the writer quotes texts with either of the characters that can end a line.
    rows = itertools.chain([columns], zip(*map(_values, columns.values()), strict=True))
    csv.writer(SimpleNamespace(write=lines.append), lineterminator="\r\n").writerows(rows)
    content = "".join(f"{line[:-2]}\n" for line in lines).encode()
    with files.refused(path):
        compressed = os.fspath(path).lower().endswith(".gz")
    if compressed:
        import gzip  # to save start-up time

        content = gzip.compress(content, mtime=0)  # no time: equal tables make equal files
    files.write(path, content)


def write_mat(path: str | os.PathLike[str], columns: Columns) -> None:
    """Write a MATLAB file: a vector for a column of numbers, NaN where there is no value, and a cell array of texts for one of words.

    Units are dropped and names made MATLAB's: "force_A_x [N]" becomes force_A_x. Where two become the same, the later one gets a number:
    "force_A-1_x" and "force_A 1_x" become force_A_1_x and force_A_1_x_2.

    Raises:
        PinpressError: a number that is not finite, or the file cannot be written.
    """
    _refuse_not_finite(columns)
    from scipy.io import savemat  # to save start-up time

    taken: dict[str, NDArray[Any]] = {}
    for name, values in columns.items():
        plain = "".join(c if c.isascii() and c.isalnum() else "_" for c in name.rsplit(" [", 1)[0])
        number = next(k for k in itertools.count(1) if (plain if k == 1 else f"{plain}_{k}") not in taken)
        taken[plain if number == 1 else f"{plain}_{number}"] = _for_matlab(values)
    content = io.BytesIO()
    savemat(content, taken, long_field_names=True, oned_as="column")
    files.write(path, content.getvalue())


def write_parquet(path: str | os.PathLike[str], columns: Columns) -> None:
    """Write a Parquet file; missing values are null. Whole numbers among others become floats, numbers among words become words.

    Raises:
        PinpressError: the file cannot be written, or pyarrow is not installed.
    """
    try:
        import pyarrow  # optional, and slow to import
        import pyarrow.parquet
    except ImportError:
        raise PinpressError("pyarrow is not installed: pip install 'pinpress[sweeps]'") from None

    with pyarrow.BufferOutputStream() as stream:
        pyarrow.parquet.write_table(pyarrow.table({name: pyarrow.array(_of_one_type(column)) for name, column in columns.items()}), stream)
        content = stream.getvalue().to_pybytes()
    files.write(path, content)


def frame(columns: Columns) -> "DataFrame":
    """The columns as a pandas DataFrame.

    Raises:
        PinpressError: pandas is not installed.
    """
    try:
        import pandas  # optional, and slow to import
    except ImportError:
        raise PinpressError("pandas is not installed: pip install 'pinpress[tables]'") from None
    return pandas.DataFrame({name: column if _is_of_floats(column) else _values(column) for name, column in columns.items()})


def html(title: str, columns: Columns) -> str:
    """A table for a notebook; long ones are shortened in the middle."""
    across, rows = shortened(list(columns), MOST_COLUMNS), []
    for row in shortened(range(max(map(len, columns.values()), default=0)), MOST_ROWS):
        rows.append([GAP if row is None or name is None else cell(_value(columns[name][row])) for name in across])

    def line(tag: str, cells: Iterable[str]) -> str:
        return f"<tr>{''.join(f'<{tag}>{markup.escape(cell)}</{tag}>' for cell in cells)}</tr>"

    head = line("th", (GAP if name is None else name for name in across))
    body = "".join(line("td", row) for row in rows)
    return f"<table><caption>{markup.escape(title)}</caption><thead>{head}</thead><tbody>{body}</tbody></table>"


def ends(column: Column) -> list[str]:
    """Smallest and largest number of a column as cells, or how many different words it has."""
    if isinstance(column, np.ndarray) and column.dtype.kind == "f":
        column = np.ma.compressed(column)
        return [cell(float(column.min())), cell(float(column.max()))] if len(column) else []
    values = [value for value in _values(column) if value is not None]
    numbers = [value for value in values if isinstance(value, int | float) and not isinstance(value, bool)]
    if numbers and len(numbers) == len(values):
        return [cell(float(min(numbers))), cell(float(max(numbers)))]
    return [f"{len(set(values))} different"]


def _value(cell: object) -> object:
    """A cell as Python's own number or word, None if it is masked."""
    return None if cell is np.ma.masked else cell.item() if isinstance(cell, np.generic) else cell


def _values(column: Column) -> Sequence[object]:
    """A column as a list of Python's own numbers and words, None if there is no value."""
    found: list[object] = column.tolist() if isinstance(column, np.ndarray) else list(column)
    return found


def _is_of_floats(column: Column) -> bool:
    return isinstance(column, np.ndarray) and column.dtype.kind == "f" and not isinstance(column, np.ma.MaskedArray)


def _refuse_not_finite(columns: Columns) -> None:
    """Raise PinpressError if a column holds numbers that other programs would read as words, or not at all."""
    for name, column in columns.items():
        if isinstance(column, np.ndarray) and _is_of_floats(column):
            bad = ~np.isfinite(column)
        else:
            bad = np.array([isinstance(each, float) and not math.isfinite(each) for each in _values(column)])
        if bad.any():
            raise PinpressError(f"{name} is not finite in row {np.argwhere(bad)[0][0]}, counted from 0: it cannot be written")


def _for_matlab(column: Column) -> NDArray[Any]:
    """A column as MATLAB's files hold it: an array of numbers, or a cell array of texts."""
    if _is_of_floats(column):
        return np.asarray(column)
    values = _values(column)
    if all(isinstance(value, int | float | None) for value in values):  # truth values are numbers in MATLAB's files
        return np.array([math.nan if value is None else value for value in values], dtype=float)
    words = np.empty(len(values), dtype=object)  # made empty: NumPy would make a table of texts of equal length
    words[:] = ["" if value is None else str(value) for value in values]
    return words


def _of_one_type(column: Column) -> Column:
    """A column of one type, as Parquet wants it."""
    if isinstance(column, np.ndarray) and column.dtype.kind in "fib":
        return column
    values = _values(column)
    types = {type(value) for value in values} - {type(None)}
    if len(types) < 2:
        return values
    to = float if types == {int, float} else str
    return [None if value is None else to(value) for value in values]  # type: ignore[arg-type]  # numbers are what becomes a float


# ---------------------------------------------------------------------------------------------------------------------------- lines of text


def table(rows: Iterable[Sequence[str]], widths: Sequence[int], indent: str = "  ") -> list[str]:
    """Lines of a table, its first column flush left and all others flush right.

    Args:
        rows: cells of each line.
        widths: letters of every column; a longer cell moves those after it. The last one counts for all columns that follow.
        indent: what each line begins with.
    """
    lines = []
    for row in rows:
        first, *others = without_minus(row)
        places = (widths[min(k, len(widths) - 1)] for k in range(1, len(row)))
        lines.append(indent + first.ljust(widths[0]) + "".join(cell.rjust(width) for cell, width in zip(others, places, strict=True)))
    return lines


def fitted(rows: Sequence[Sequence[str]], words: Sequence[bool] | None = None, indent: str = "  ", gap: int = 2) -> list[str]:
    """Lines of a table whose columns are as wide as their longest cell.

    Args:
        rows: cells of each line.
        words: whether each column is flush left; the others are flush right. None: only the first one is flush left.
        indent: start of each line.
        gap: letters between two columns.
    """
    rows = [without_minus(row) for row in rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    left = [True, *(False for _ in widths[1:])] if words is None else words
    lines = []
    for row in rows:
        cells = [cell.ljust(width) if flush else cell.rjust(width) for cell, width, flush in zip(row, widths, left, strict=False)]
        lines.append((indent + (gap * " ").join(cells)).rstrip())
    return lines


def fitted_words(rows: Sequence[Sequence[str]], indent: str = "  ") -> list[str]:
    """Lines of a table of words: all columns flush left, three letters apart."""
    return fitted(rows, [True for _ in rows[0]] if rows else None, indent, gap=3)


def entry(name: str, number: str, unit: str = "", remark: str = "") -> str:
    """A line with one number, its unit and a remark. All such lines have the same columns."""
    _, number, remark = without_minus([name, number, remark])
    return f"  {name:{_NAME}}{number:>{_NUMBER}} {unit:{_UNIT}}{remark}".rstrip()


def scale(unit: str, values: Iterable[float], least: float = 0.0) -> ShownUnit:
    """How values with five digits of the largest are written under each other; see `Quantity.scale`."""
    shown = quantity("height" if unit == "m" else unit or "-").scale(values, digits=_DIGITS)
    return shown._replace(least=max(shown.least, least, 0.0))


def shortened(items: Sequence[T], most: int) -> list[T | None]:
    """What is shown of rows or columns: all up to ``most``, else the first and last ones with None for those between."""
    half = most // 2
    return [*items] if len(items) <= most else [*items[:half], None, *items[-half:]]


def cell(value: object) -> str:
    """A value as a cell: six digits of a number, thousands apart as in `ShownUnit.shown`, words in one line, nothing for None."""
    if value is None:
        return ""
    return grouped(value, ".6g") if isinstance(value, float) else " ".join(str(value).splitlines())


def without_minus(row: Sequence[str]) -> list[str]:
    """The cells of a line, those behind its name without the minus sign of a 0."""
    return [*row[:1], *(_MINUS.sub("", _PADDED_MINUS.sub(" ", cell)) for cell in row[1:])]
