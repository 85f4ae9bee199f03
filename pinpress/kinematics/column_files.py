"""Columns of numbers in the files that drives and recorders write: CSV, Parquet, MATLAB's and MDF4.

A column is asked for by its name with its unit, "crank [deg]". It is the column of this very name, or the one called "crank": in the unit
that the file has for it, else in the one that was asked for.
"""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..common import files
from ..common.errors import PinpressError, UnknownNameError, said, shown
from ..common.quantities import Array
from ..common.reading.cells import parted, separator_of, text_of

LARGEST_FILE = 2 * 10**9  # bytes
TIMES = ("time", "t", "zeit", "timestamp", "timestamps")  # names of the column of the time, without its unit


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
        time: (n,) times that the format itself keeps [s]; None where they are a column.
    """

    file: str
    columns: Mapping[str, Array]
    units: Mapping[str, str]
    time: Array | None = None

    def column(self, asked: str) -> Column:
        """The column of a name with its unit.

        Raises:
            PinpressError: the file has another unit.
            UnknownNameError: it has no such column.
        """
        name, unit = parted(asked)
        if name not in self.columns:
            raise UnknownNameError(f"column in {self.file} of the name", name, self.columns)
        there = self.units.get(name, "")
        if unit and there and _plain(unit) != _plain(there):
            raise PinpressError(f"{self.file}: column {name!r} is in {there}, not in {unit}: write {name!r}, or mend the file")
        return Column(self.columns[name], there or unit)


def read(file: str | os.PathLike[str], wanted: Iterable[str]) -> Channels:
    """The columns of a file by its ending: .csv and .txt, .parquet, .mat, .mf4; with .gz after it, it is compressed.

    Args:
        file: its path.
        wanted: names of columns that are needed; only of an MDF4 file, which may have thousands, all others are left out.

    Raises:
        PinpressError: the file cannot be read, is of none of these kinds, or of one whose package is not installed.
    """
    path = files.path_of("file", file)
    readers = {".csv": _csv, ".txt": _csv, ".parquet": _parquet, ".mat": _mat, ".mf4": _mdf}
    ending = Path(path.removesuffix(".gz")).suffix.lower()
    if ending not in readers:
        raise PinpressError(f"{path} ends in {ending or 'nothing'}: columns are read from {', '.join(readers)}; export it as one of these")
    try:
        content = files.uncompressed(path, files.read(path, LARGEST_FILE), LARGEST_FILE)
    except (OSError, ValueError) as error:
        raise PinpressError(f"{path} cannot be read: {files.reason(error)}") from None
    return readers[ending](path, content, [parted(name)[0] for name in wanted])


def named_columns(file: str, columns: Mapping[str, Array], time: Array | None = None, units: Mapping[str, str] | None = None) -> Channels:
    """Columns whose names may carry units; raises PinpressError where two have one name."""
    apart = {name: parted(name) for name in columns}
    plain = {apart[name][0]: values for name, values in columns.items()}
    if len(plain) < len(columns):
        names = [short for short, _ in apart.values()]
        double = next(name for name in names if names.count(name) > 1)
        raise PinpressError(f"{file}: two columns are called {double!r}: rename one")
    known = {short: unit for short, unit in apart.values() if unit} | {name: unit for name, unit in (units or {}).items() if unit}
    return Channels(file, plain, known, time)


def _csv(file: str, content: bytes, _: list[str]) -> Channels:
    try:
        text = text_of(content)
    except ValueError:
        text = content.decode("latin-1")
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith(("#", "%"))]
    if len(lines) < 2:
        raise PinpressError(f"{file}: no table: write a line with the names of the columns, and below it the numbers")
    separator = separator_of(lines[0])
    if separator not in lines[0]:
        raise PinpressError(f"{file}: one column only in the first line, {shown(lines[0])}: part columns by commas, semicolons or tabs")
    names, below = csv.reader(lines[:2], delimiter=separator, skipinitialspace=True)
    if all(_is_number(cell, separator) for cell in names):
        raise PinpressError(f"{file}: the first line has numbers, no names: write the names of the columns above them, such as crank [rad]")
    first = 1
    if len(below) == len(names) and not any(_is_number(cell, separator) for cell in below):  # a line of units
        names = [f"{name} [{unit.strip('[]() ')}]" if unit.strip("[]() -") else name for name, unit in zip(names, below, strict=True)]
        first = 2
    rows = lines[first:]
    if separator != ",":
        rows = [row.replace(",", ".") for row in rows]  # the decimal comma
    try:
        table = np.loadtxt(io.StringIO("\n".join(rows)), delimiter=separator, ndmin=2, converters=None)
    except ValueError:
        raise PinpressError(_amiss(file, rows, names, separator)) from None
    if table.shape[1] != len(names):
        raise PinpressError(f"{file}: {len(names)} names of columns above {table.shape[1]} numbers: write as many names as numbers")
    plain = [name.strip() for name in names]
    if len({*plain}) < len(plain):
        raise PinpressError(f"{file}: two columns are called {next(name for name in plain if plain.count(name) > 1)!r}: rename one")
    return named_columns(file, {name: np.ascontiguousarray(table[:, k]) for k, name in enumerate(plain)})


def _is_number(cell: str, separator: str) -> bool:
    try:
        float(cell if separator == "," else cell.replace(",", "."))
    except ValueError:
        return not cell.strip()
    return True


def _amiss(file: str, rows: list[str], names: list[str], separator: str) -> str:
    """Which row of a CSV file is not made of numbers."""
    for k, row in enumerate(rows, 1):
        cells = row.split(separator)
        if len(cells) != len(names):
            return f"{file}: row {k} of the numbers has {len(cells)} cells, the names are {len(names)}: mend or leave out the row"
        for name, cell in zip(names, cells, strict=True):
            if not cell.strip() or not _is_number(cell, separator):
                return f"{file}: row {k} of the numbers has {shown(cell.strip())} as {name.strip()}: give a number, or leave out the row"
    return f"{file}: the rows cannot be read as numbers"


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
    return named_columns(file, {name: np.array(table[name].to_numpy(), dtype=float) for name in numbers})


def _mat(file: str, content: bytes, _: list[str]) -> Channels:
    from scipy.io import loadmat  # to save start-up time

    try:
        found: dict[str, Any] = loadmat(io.BytesIO(content), squeeze_me=True)
    except NotImplementedError:
        raise PinpressError(f"{file} is a MATLAB file of version 7.3: write it with save(..., '-v7')") from None
    except Exception as error:  # whatever SciPy's reader meets in a damaged file
        raise PinpressError(f"{file} is no MATLAB file that can be read: {said(error)}") from None
    vectors = {
        name: value for name, value in found.items() if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "iuf"
    }
    if not vectors:
        raise PinpressError(
            f"{file} holds no vectors of numbers: save each channel as a vector of its own, save('run.mat', 'time', 'crank')"
        )
    return named_columns(file, {name: np.array(value, dtype=float) for name, value in vectors.items()})


def _mdf(file: str, _: bytes, wanted: list[str]) -> Channels:
    try:
        from asammdf import MDF  # optional, and slow to import
        from asammdf.blocks.utils import MdfException
    except ImportError:
        raise PinpressError("asammdf is not installed: pip install 'pinpress[records]'") from None
    try:
        with MDF(file) as opened:
            known = [name for name in opened.channels_db if name not in TIMES]
            missing = next((name for name in wanted if name not in opened.channels_db), None)
            signals = [] if missing else opened.select(wanted)
    except (MdfException, OSError, ValueError) as error:
        raise PinpressError(f"{file} is no MDF4 file that can be read: {said(error)}") from None
    if missing is not None:
        raise UnknownNameError(f"channel in {file} of the name", missing, known)
    time = signals[0].timestamps
    other = next((each for each in signals if not np.array_equal(each.timestamps, time)), None)
    if other is not None:
        raise PinpressError(
            f"{file}: channels {signals[0].name!r} and {other.name!r} were sampled at different times: resample the file to one raster,"
            " MDF(file).resample(raster=0.001).save(...)"
        )
    columns = {signal.name: np.array(signal.samples, dtype=float) for signal in signals}
    return named_columns(file, columns, np.array(time, dtype=float), {signal.name: signal.unit for signal in signals})


def _plain(unit: str) -> str:
    """A unit without what people write in different ways."""
    return re.sub(r"[\s.·*^]", "", unit).replace("²", "2").lower()
