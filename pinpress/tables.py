"""Columns of numbers to files and frames that other programs read."""

import io
import itertools
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from . import files
from .coordinates import Array
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
        PinpressError: the file cannot be written.
    """
    lists = (column.astype(float).tolist() if isinstance(column, np.ndarray) else column for column in columns.values())
    files.write(path, csv_text(itertools.chain([columns], zip(*lists, strict=True))).encode())


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Rows as a CSV, a line each."""
    import csv

    text = _Lines(newline="")
    csv.writer(text, lineterminator="\r\n").writerows(rows)
    return text.getvalue()


class _Lines(io.StringIO):
    """Lines of a CSV with their ends as Unix has them: a writer puts what could end a line into quotes only where its own lines end so."""

    def write(self, line: str) -> int:
        return super().write(line[:-2] + "\n")


def write_mat(path: str | os.PathLike[str], columns: Mapping[str, Array]) -> None:
    """Write a MATLAB file; units are dropped and names made MATLAB's: "force_A_x [N]" becomes force_A_x. Where two become the
    same, the later one gets a number: "force_A-1_x" and "force_A 1_x" become force_A_1_x and force_A_1_x_2.

    Raises:
        PinpressError: the file cannot be written.
    """
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
