"""Columns as a Parquet file."""

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..common import files
from ..common.errors import PinpressError


def installed() -> Any:
    """pyarrow.

    Raises:
        PinpressError: it is not installed.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise PinpressError("pyarrow is not installed: pip install 'pinpress[sweeps]'") from None
    return pyarrow


def write_columns(path: str | os.PathLike[str], columns: Mapping[str, Any]) -> None:
    """Write columns (n,), numbers or words, None where there is no value, in one step.

    Raises:
        PinpressError: the file cannot be written, or pyarrow is not installed.
    """
    files.write(path, _content(columns))


def _content(columns: Mapping[str, Any]) -> bytes:
    pyarrow = installed()
    with pyarrow.BufferOutputStream() as stream:
        pyarrow.parquet.write_table(pyarrow.table({name: pyarrow.array(_alike(values)) for name, values in columns.items()}), stream)
        content: bytes = stream.getvalue().to_pybytes()
    return content


def _alike(values: Any) -> Any:
    """A column of one type, as Parquet wants it: whole numbers beside others become floats, numbers beside words become words."""
    if isinstance(values, np.ndarray):
        return values
    types = {type(value) for value in values} - {type(None)}
    if len(types) < 2:
        return values
    to = float if types == {int, float} else str
    return [None if value is None else to(value) for value in values]
