"""Columns of numbers to files and frames that other programs read."""

import io
import itertools
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from types import SimpleNamespace
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from . import files
from .arrays import Array
from .errors import PinpressError

if TYPE_CHECKING:
    import pandas

    DataFrame: TypeAlias = pandas.DataFrame


def by_driver(name: str, unit: str, values: Array, drivers: Sequence[str]) -> dict[str, Array]:
    """A column (n,) under its name; of several drivers (n, drivers), one each."""
    if values.ndim == 1:
        return {f"{name} [{unit}]": values}
    return {f"{name}_{driver} [{unit}]": values[:, i] for i, driver in enumerate(drivers)}


def write_csv(path: str | os.PathLike[str], columns: Mapping[str, Array | Sequence[object]]) -> None:
    """Write columns (n,) with their names as header: numbers, to full precision, or words; None is left empty.

    Raises:
        PinpressError: a number that is not finite, or the file cannot be written.
    """
    _refuse_not_finite(columns)
    lists = (column.astype(float).tolist() if isinstance(column, np.ndarray) else column for column in columns.values())
    lines = csv_lines(itertools.chain([columns], zip(*lists, strict=True)))
    files.write(path, "".join(f"{line}\n" for line in lines).encode())


def _refuse_not_finite(columns: Mapping[str, Array | Sequence[object]]) -> None:
    """Raise PinpressError where a column holds numbers that other programs would read as words, or not at all."""
    for name, column in columns.items():
        if isinstance(column, np.ndarray):
            bad = ~np.isfinite(column)
        else:
            bad = np.array([isinstance(each, float) and not math.isfinite(each) for each in column])
        if bad.any():
            raise PinpressError(f"{name} is not finite in row {np.argwhere(bad)[0][0]}, counted from 0: it cannot be written")


def csv_lines(rows: Iterable[Iterable[object]]) -> list[str]:
    """Rows as lines of a CSV, without their ends. One has line feeds in it where a text has."""
    import csv

    written: list[str] = []
    # with the end that it writes here the writer puts both characters that can end a line into quotes
    csv.writer(SimpleNamespace(write=written.append), lineterminator="\r\n").writerows(rows)
    return [line[:-2] for line in written]


def write_mat(path: str | os.PathLike[str], columns: Mapping[str, Array]) -> None:
    """Write a MATLAB file; units are dropped and names made MATLAB's: "force_A_x [N]" becomes force_A_x. Where two become the
    same, the later one gets a number: "force_A-1_x" and "force_A 1_x" become force_A_1_x and force_A_1_x_2.

    Raises:
        PinpressError: a number that is not finite, or the file cannot be written.
    """
    _refuse_not_finite(columns)
    from scipy.io import savemat  # its import takes longer than all else here

    taken: dict[str, Array] = {}
    for name, values in columns.items():
        plain = "".join(c if c.isascii() and c.isalnum() else "_" for c in name.rsplit(" [", 1)[0])
        number = next(k for k in itertools.count(1) if (plain if k == 1 else f"{plain}_{k}") not in taken)
        taken[plain if number == 1 else f"{plain}_{number}"] = values
    content = io.BytesIO()
    savemat(content, taken, long_field_names=True, oned_as="column")
    files.write(path, content.getvalue())


def frame(columns: Mapping[str, Array | Sequence[object]]) -> "DataFrame":
    """The columns as a pandas DataFrame.

    Raises:
        PinpressError: pandas is not installed.
    """
    try:
        import pandas
    except ImportError:
        raise PinpressError("pandas is not installed: pip install 'pinpress[tables]'") from None
    return pandas.DataFrame(dict(columns))
