"""Columns of numbers to files and frames that other programs read."""

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from .coordinates import Array
from .errors import PinpressError

if TYPE_CHECKING:
    import pandas

    DataFrame: TypeAlias = pandas.DataFrame


def write_csv(path: str | os.PathLike[str], columns: Mapping[str, Array]) -> None:
    """Write (n,) columns with their names as header, numbers to full precision.

    Raises:
        PinpressError: the file cannot be written.
    """
    import csv

    try:
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows(np.column_stack(list(columns.values())).tolist())
    except OSError as error:
        raise PinpressError(f"cannot write {os.fspath(path)}: {error.strerror}; choose another place") from None


def write_mat(path: str | os.PathLike[str], columns: Mapping[str, Array]) -> None:
    """Write a MATLAB file; units are dropped and names made MATLAB's ("force_A_x [N]" becomes force_A_x).

    Raises:
        PinpressError: the file cannot be written.
    """
    from scipy.io import savemat  # its import takes longer than all else here

    names = {name: "".join(c if c.isascii() and c.isalnum() else "_" for c in name.split(" [")[0]) for name in columns}
    try:
        savemat(path, {names[name]: values for name, values in columns.items()}, appendmat=False, long_field_names=True, oned_as="column")
    except OSError as error:
        raise PinpressError(f"cannot write {os.fspath(path)}: {error.strerror}; choose another place") from None


def frame(columns: Mapping[str, Array]) -> "DataFrame":
    """The columns as a pandas DataFrame.

    Raises:
        PinpressError: pandas is not installed.
    """
    try:
        import pandas
    except ImportError:
        raise PinpressError("pandas is not installed: pip install 'pinpress[tables]'") from None
    return pandas.DataFrame(dict(columns))
