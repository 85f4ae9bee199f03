"""Columns of numbers and words in tables of all kinds: CSV, Parquet, MATLAB's files and MDF4.

A column has the name and the unit of its head, "crank [deg]" or "crank (deg)". CSV files may have commas, semicolons or tabs between their
cells, with the latter two decimal commas too, text in UTF-8, UTF-16 or Latin-1, and units in a line below the names. A file whose name ends
with .gz is compressed.

`read_columns` reads the columns that a caller wants, in the caller's units. `read_channels` reads records, whose columns the user names.
"""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .. import files
from ..arguments import unit_factor
from ..errors import PinpressError, UnknownNameError, said, shown, suggestion
from ..frozen import FrozenMapping
from ..quantities import Array, quantity

LARGEST_FILE = 2 * 10**9  # bytes
LARGEST_TABLE = 10**8  # of a table that people write [bytes]
TIMES = ("time", "t", "zeit", "timestamp", "timestamps")  # names of the column of the time, without its unit
SEPARATORS = ";\t,"  # the first of them in the first line is between the cells
_DECIMAL_COMMA = re.compile(r"([+-]?\d*),(\d+(?:[eE][+-]?\d+)?)")
_UNIT = re.compile(r"^(.*?)\s*(?:\[([^\]]*)\]|\(([^)]*)\))\s*$")
_WIDE = (b"\xff\xfe", b"\xfe\xff")  # byte order marks of UTF-16


@dataclass(frozen=True)
class Wanted:
    """A column that a caller wants.

    Attributes:
        quantity: unit in which the numbers are returned, usually the SI unit of their quantity; None for words.
        bare: unit of numbers whose head has none; empty: such a head is refused.
        needed: whether the file must have the column, with a number in every row. Else a number that is left out is NaN.
        names: other names that the column may have.
    """

    quantity: str | None = None
    bare: str = ""
    needed: bool = True
    names: tuple[str, ...] = ()

    def head(self, name: str) -> str:
        """A head for a column of this name, with a unit if it needs one."""
        return name if self.quantity is None or self.bare == "-" else f"{name} [{self.bare or self.usual_unit}]"

    @property
    def usual_unit(self) -> str:
        """The unit in which the quantity is shown."""
        row = quantity(self.quantity or "-")
        return row.shown[0][0] if row.shown else row.unit


class Columns(NamedTuple):
    """Columns as `read_columns` returns them, with n rows.

    Attributes:
        file: path of the file.
        values: name -> (n,) numbers in the unit wanted, or n words; without optional columns that the file does not have.
        lines: n lines of a CSV file, from 1; in other formats the numbers of the rows.
        units: of the columns of numbers, as their heads have them; empty if there is none.
    """

    file: str
    values: Mapping[str, Any]
    lines: Sequence[int]
    units: Mapping[str, str]

    def rows(self) -> list[tuple[int, dict[str, Any]]]:
        """The line of every row, and its values by their names."""
        columns = {name: column.tolist() if isinstance(column, np.ndarray) else column for name, column in self.values.items()}
        return [(line, {name: column[k] for name, column in columns.items()}) for k, line in enumerate(self.lines)]


class Row(NamedTuple):
    """A row of a CSV file that is not empty.

    Attributes:
        line: its line in the file, from 1.
        cells: its cells, without blanks around them. If commas are not between them, a decimal comma has become a point.
    """

    line: int
    cells: list[str]


class Column(NamedTuple):
    """A column of a file.

    Attributes:
        values: (n,).
        unit: as the file or the caller writes it; empty where nobody does.
    """

    values: Array
    unit: str


class Channels(NamedTuple):
    """All columns of numbers of a file.

    Attributes:
        file: its path.
        columns: by their names in the file, the units apart.
        units: of the columns, as far as the file has them.
        time: (n,) times that the format itself keeps [s]; None if they are a column.
        words: columns of words, by their names.
    """

    file: str
    columns: Mapping[str, Array]
    units: Mapping[str, str]
    time: Array | None = None
    words: Mapping[str, list[str]] = FrozenMapping({})

    def column(self, head: str) -> Column:
        """The column of a name with its unit.

        Raises:
            PinpressError: the file has another unit.
            UnknownNameError: it has no such column.
        """
        name, unit = split_head(head)
        if name not in self.columns:
            raise UnknownNameError(f"column in {self.file} of the name", name, self.columns)
        unit_there = self.units.get(name, "")
        if unit and unit_there and not _same_unit(unit, unit_there):
            raise PinpressError(f"{self.file}: column {name!r} is in {unit_there}, not in {unit}: write {name!r}, or mend the file")
        return Column(self.columns[name], unit_there or unit)


def read_columns(
    path: str | os.PathLike[str], wanted: Mapping[str, Wanted], *, by_order: bool = False, others: bool = True, most: int = LARGEST_TABLE
) -> Columns:
    """The columns of a table that a caller wants, in the units that the caller wants.

    Args:
        path: a .parquet, .mat or .mf4 file; any other name is that of a CSV file.
        wanted: name of a column -> what it is.
        by_order: whether the columns of a CSV file are the wanted ones in their order. Its first line may then have numbers; otherwise its
            heads may name units.
        others: whether the file may have other columns.
        most: largest file [bytes].

    Raises:
        PinpressError: the file cannot be read, lacks a column or a unit, or a cell is no number; with the line, the column and the remedy.
    """
    file = files.path_of("path", path)
    needed, optional = ([column.head(name) for name, column in wanted.items() if column.needed is must] for must in (True, False))
    beside = f" and, if wanted, {', '.join(optional)}" if optional else ""
    remedy = f"give a CSV file with the {'columns' if by_order else 'heads'} {', '.join(needed)}{beside}"
    content = _content(file, most, f"; {remedy}")
    if reader := _READERS.get(_ending(file)):
        channels = reader(file, content, [] if _ending(file) != ".mf4" else [name for name, column in wanted.items() if column.needed])
        heads = [f"{name} [{unit}]" if (unit := channels.units.get(name, "")) else name for name in (*channels.columns, *channels.words)]
        below: Sequence[Any] = [*channels.columns.values(), *channels.words.values()]
        lines: Sequence[int] = range(1, 1 + len(below[0]) if below else 1)
    else:
        heads, below, lines = _cells(file, content, wanted, by_order, remedy)
    places = _places(file, heads, wanted, others, remedy)
    values: dict[str, Any] = {}
    for name, place in places.items():
        column = wanted[name]
        if column.quantity is None:
            values[name] = list(below[place])
        else:
            numbers = below[place] if isinstance(below[place], np.ndarray) else _numbers(file, name, below[place], lines, column.needed)
            values[name] = numbers * _factor(file, name, heads[place], column, remedy)
    units = {name: split_head(heads[place])[1] for name, place in places.items() if wanted[name].quantity is not None}
    return Columns(file, values, lines, units)


def read_channels(file: str | os.PathLike[str], wanted: Iterable[str]) -> Channels:
    """The columns of a record by its ending: .csv and .txt, .parquet, .mat, .mf4; with .gz after it, it is compressed.

    Args:
        file: its path.
        wanted: names of columns that are needed; only of an MDF4 file, which may have thousands, all others are left out.

    Raises:
        PinpressError: the file cannot be read, is of none of these kinds, or of one whose package is not installed.
    """
    path = files.path_of("file", file)
    readers = {".csv": _csv, ".txt": _csv, **_READERS}
    ending = _ending(path)
    if ending not in readers:
        raise PinpressError(f"{path} ends in {ending or 'nothing'}: columns are read from {', '.join(readers)}; export it as one of these")
    return readers[ending](path, _content(path, LARGEST_FILE), [split_head(name)[0] for name in wanted])


def _ending(path: str) -> str:
    return Path(path.removesuffix(".gz")).suffix.lower()


def _content(path: str, most: int, remedy: str = "") -> bytes:
    try:
        return files.uncompressed(path, files.read(path, most), most)
    except (OSError, ValueError) as error:
        raise PinpressError(f"{path} cannot be read: {files.reason(error)}{remedy}") from None


# ------------------------------------------------------------------------------------------------------------------------------ CSV files


def split_head(name: str) -> tuple[str, str]:
    """Name and unit of "crank [deg]" or "crank (deg)"; the unit is empty if there is none."""
    match = _UNIT.match(name.strip())
    return (match[1].strip(), (match[2] or match[3] or "").strip()) if match and match[1].strip() else (name.strip(), "")


def _text(file: str, content: bytes) -> str:
    """The text of a file in UTF-8, in UTF-16 with its mark, or in Latin-1."""
    try:
        return content.decode("utf-16" if content.startswith(_WIDE) else "utf-8-sig")
    except UnicodeDecodeError:
        if content.startswith(_WIDE) or re.search(rb"[\x00-\x08\x0e-\x1f]", content):
            raise PinpressError(f"{file} is no text in UTF-8; save it in this encoding") from None
        return content.decode("latin-1")


def _rows(file: str, content: bytes, comments: bool) -> tuple[list[Row], str]:
    """The rows of a CSV file, and what is between their cells. Lines above the heads that begin with # or % are left out; with ``comments``
    those below them too."""
    lines = _text(file, content).splitlines()
    kept = [(k, line) for k, line in enumerate(lines, 1) if line.strip()]
    first = next((k for k, (_, line) in enumerate(kept) if not line.lstrip().startswith(("#", "%"))), len(kept))
    kept = [(k, line) for k, line in kept[first:] if not comments or not line.lstrip().startswith(("#", "%"))]
    separator = next((sign for sign in SEPARATORS if kept and sign in kept[0][1]), ",")
    try:
        cells = csv.reader([line for _, line in kept], delimiter=separator, skipinitialspace=True)
        rows = [Row(kept[cells.line_num - 1][0], [_cell(cell, separator) for cell in row]) for row in cells]
    except csv.Error as error:
        raise PinpressError(f"{file} is no table: {error}") from None
    return [row for row in rows if any(row.cells)], separator


def _cell(text: str, separator: str) -> str:
    text = text.strip()
    if separator != "," and (match := _DECIMAL_COMMA.fullmatch(text)):
        return f"{match[1]}.{match[2]}"
    return text


def _cells(
    file: str, content: bytes, wanted: Mapping[str, Wanted], by_order: bool, remedy: str
) -> tuple[list[str], list[list[str]], list[int]]:
    """Heads, cells by column, and the line of every row."""
    rows, _ = _rows(file, content, comments=all(column.quantity is not None for column in wanted.values()))
    if not rows:
        raise PinpressError(f"{file} is empty: {remedy}")
    heads, below = rows[0].cells, rows[1:]
    if by_order:
        plain = all(map(_is_number, heads))
        units = ["" if plain else split_head(head)[1] for head in heads]
        below = rows if plain else below
        heads = [f"{name} [{unit}]" if unit else name for name, unit in zip([*wanted, *heads[len(wanted) :]], units, strict=False)]
    elif below and _are_units(heads, below[0].cells) and any(column.quantity is not None for column in wanted.values()):
        heads, below = _with_units(heads, below[0].cells), below[1:]
    for line, cells in below:
        if len(cells) > len(heads) or (by_order and len(cells) != len(wanted)):
            count = len(wanted) if by_order else len(heads)
            raise PinpressError(f"{file}, line {line}: {len(cells)} cells for {count} columns: write decimals after a point; {remedy}")
    return heads, [[row.cells[k] if k < len(row.cells) else "" for row in below] for k in range(len(heads))], [row.line for row in below]


def _are_units(names: Sequence[str], cells: Sequence[str]) -> bool:
    """Whether the line below the names is one of units."""
    return len(cells) == len(names) and not any(_is_number(cell) or not cell for cell in cells)


def _with_units(names: Sequence[str], units: Sequence[str]) -> list[str]:
    return [f"{name} [{unit.strip('[]() ')}]" if unit.strip("[]() -") else name for name, unit in zip(names, units, strict=True)]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _places(file: str, heads: Sequence[str], wanted: Mapping[str, Wanted], others: bool, remedy: str) -> dict[str, int]:
    """Name of a wanted column -> its place in the file. A head of words is taken as it is: a unit in it would be overlooked."""
    called = {name: column for first, column in wanted.items() for name in (first, *column.names)}
    names = [head if (short := split_head(head)[0]) in called and called[short].quantity is None else short for head in heads]
    unknown = next((name for name in names if name and name not in called), None)
    hint = "" if unknown is None else f"column {unknown!r} is unknown{suggestion(unknown, called)}; "
    if not others and unknown is not None:
        raise PinpressError(f"{file}: {hint}{remedy}")
    places = {}
    for name, column in wanted.items():
        places_of_name = [k for k, head in enumerate(names) if head in (name, *column.names)]
        if len(places_of_name) > 1:
            raise PinpressError(f"{file}: two columns are called {names[places_of_name[1]]!r}: rename one")
        if places_of_name:
            places[name] = places_of_name[0]
        elif column.needed:
            raise PinpressError(f"{file}: no column {column.head(name)!r}; {hint}{remedy}")
    return places


def _numbers(file: str, name: str, cells: Sequence[str], lines: Sequence[int], needed: bool) -> Array:
    """Cells as numbers; those of an optional column may be empty."""
    numbers = np.full(len(cells), np.nan)
    for k, cell in enumerate(cells):
        if not cell and not needed:
            continue
        try:
            numbers[k] = float(cell)
        except ValueError:
            raise PinpressError(_no_number(file, lines[k], name, cell)) from None
    return numbers


def _no_number(file: str, line: int, name: str, cell: str) -> str:
    remedy = "write decimals after a point" if "," in cell else "give a number, or leave out the row"
    return f"{file}, line {line}, {name}: {shown(cell)} is no number; {remedy}"


def _factor(file: str, name: str, head: str, wanted: Wanted, remedy: str) -> float:
    """Size of the unit in a head [SI unit]."""
    unit = split_head(head)[1] or wanted.bare
    if not unit:
        raise PinpressError(f"{file}: column {name!r} has no unit: write e.g. '{wanted.head(name)}'")
    try:
        return unit_factor(unit, wanted.quantity or "-")
    except ValueError as error:
        raise PinpressError(f"{file}: column {name!r} is {error}; {remedy}") from None


# ---------------------------------------------------------------------------------------------------------------------- records by format


def name_columns(file: str, columns: Mapping[str, Array], time: Array | None = None, units: Mapping[str, str] | None = None) -> Channels:
    """Columns whose names may carry units; raises PinpressError where two have one name."""
    apart = {name: split_head(name) for name in columns}
    plain = {apart[name][0]: values for name, values in columns.items()}
    if len(plain) < len(columns):
        names = [short for short, _ in apart.values()]
        double = next(name for name in names if names.count(name) > 1)
        raise PinpressError(f"{file}: two columns are called {double!r}: rename one")
    with_units = {short: unit for short, unit in apart.values() if unit} | {name: unit for name, unit in (units or {}).items() if unit}
    return Channels(file, plain, with_units, time)


def _csv(file: str, content: bytes, wanted: list[str]) -> Channels:
    lines = [line for line in _text(file, content).splitlines() if line.strip() and not line.lstrip().startswith(("#", "%"))]
    if len(lines) < 2:
        raise PinpressError(f"{file}: no table: write a line with the names of the columns, and below it the numbers")
    (heads, *_), separator = _rows(file, lines[0].encode(), comments=True)
    names = heads.cells
    if len(names) < 2:
        raise PinpressError(f"{file}: one column only in the first line, {shown(lines[0])}: part columns by commas, semicolons or tabs")
    if all(map(_is_number, names)):
        raise PinpressError(f"{file}: the first line has numbers, no names: write the names of the columns above them, such as crank [rad]")
    below = [_cell(cell, separator) for cell in next(csv.reader(lines[1:2], delimiter=separator, skipinitialspace=True))]
    names, first = (_with_units(names, below), 2) if _are_units(names, below) else (names, 1)
    rows = lines[first:] if separator == "," else [row.replace(",", ".") for row in lines[first:]]  # the decimal comma
    if len({*names}) < len(names):
        raise PinpressError(f"{file}: two columns are called {next(name for name in names if names.count(name) > 1)!r}: rename one")
    try:
        table = np.loadtxt(io.StringIO("\n".join(rows)), delimiter=separator, ndmin=2)
    except ValueError:  # cell by cell, which takes longer
        return name_columns(file, _columns_of_numbers(file, content, names, first, wanted))
    if table.shape[1] != len(names):
        raise PinpressError(f"{file}: {len(names)} names of columns above {table.shape[1]} numbers: write as many names as numbers")
    return name_columns(file, {name: np.ascontiguousarray(table[:, k]) for k, name in enumerate(names)})


def _columns_of_numbers(file: str, content: bytes, names: Sequence[str], first: int, wanted: Sequence[str]) -> dict[str, Array]:
    """The columns of a CSV file that are wanted, and those without a cell that is no number."""
    rows, _ = _rows(file, content, comments=True)
    for line, cells in rows[first:]:
        if len(cells) != len(names):
            raise PinpressError(f"{file}, line {line}: {len(cells)} cells, the names are {len(names)}: mend or leave out the row")
    columns = {}
    for k, name in enumerate(names):
        cells, short = [row.cells[k] for row in rows[first:]], split_head(name)[0]
        if short in wanted or name in wanted or all(map(_is_number, cells)):
            columns[name] = _numbers(file, short, cells, [row.line for row in rows[first:]], needed=True)
    return columns


def _parquet(file: str, content: bytes, _: list[str]) -> Channels:
    try:
        import pyarrow  # optional, and slow to import
        import pyarrow.parquet
    except ImportError:
        raise PinpressError("pyarrow is not installed: pip install 'pinpress[sweeps]'") from None
    try:
        table = pyarrow.parquet.read_table(pyarrow.BufferReader(content))
    except (pyarrow.ArrowException, OSError) as error:
        raise PinpressError(f"{file} is no Parquet file that can be read: {said(error)}") from None
    numbers = [name for name in table.column_names if pyarrow.types.is_integer(table.schema.field(name).type)]
    numbers += [name for name in table.column_names if pyarrow.types.is_floating(table.schema.field(name).type)]
    words = [name for name in table.column_names if pyarrow.types.is_string(table.schema.field(name).type)]
    channels = name_columns(file, {name: np.array(table[name].to_numpy(), dtype=float) for name in numbers})
    return channels._replace(words={name: [word or "" for word in table[name].to_pylist()] for name in words})


def _mat(file: str, content: bytes, _: list[str]) -> Channels:
    from scipy.io import loadmat  # to save start-up time

    try:
        variables: dict[str, Any] = loadmat(io.BytesIO(content), squeeze_me=True)
    except NotImplementedError:
        raise PinpressError(f"{file} is a MATLAB file of version 7.3: write it with save(..., '-v7')") from None
    except Exception as error:  # whatever SciPy's reader meets in a damaged file
        raise PinpressError(f"{file} is no MATLAB file that can be read: {said(error)}") from None
    vectors = {
        name: value for name, value in variables.items() if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "iuf"
    }
    if not vectors:
        raise PinpressError(
            f"{file} holds no vectors of numbers: save each channel as a vector of its own, save('run.mat', 'time', 'crank')"
        )
    return name_columns(file, {name: np.array(value, dtype=float) for name, value in vectors.items()})


def _mdf(file: str, _: bytes, wanted: list[str]) -> Channels:
    try:
        from asammdf import MDF  # optional, and slow to import
        from asammdf.blocks.utils import MdfException
    except ImportError:
        raise PinpressError("asammdf is not installed: pip install 'pinpress[records]'") from None
    try:
        with MDF(file) as opened:
            names = [name for name in opened.channels_db if name not in TIMES]
            missing = next((name for name in wanted if name not in opened.channels_db), None)
            signals = [] if missing else opened.select(wanted)
    except (MdfException, OSError, ValueError) as error:
        raise PinpressError(f"{file} is no MDF4 file that can be read: {said(error)}") from None
    if missing is not None:
        raise UnknownNameError(f"channel in {file} of the name", missing, names)
    time = signals[0].timestamps
    late = next((signal for signal in signals if not np.array_equal(signal.timestamps, time)), None)
    if late is not None:
        raise PinpressError(
            f"{file}: channels {signals[0].name!r} and {late.name!r} were sampled at different times: resample the file to one raster,"
            " MDF(file).resample(raster=0.001).save(...)"
        )
    columns = {signal.name: np.array(signal.samples, dtype=float) for signal in signals}
    return name_columns(file, columns, np.array(time, dtype=float), {signal.name: signal.unit for signal in signals})


def _same_unit(first: str, second: str) -> bool:
    """Whether two texts are one unit, however it is spelt."""
    plain = [re.sub(r"[\s.·*^]", "", unit).replace("²", "2").lower() for unit in (first, second)]
    return plain[0] == plain[1]


_READERS = {".parquet": _parquet, ".mat": _mat, ".mf4": _mdf}
