"""Constant matrices with few entries a row, from joints, loops and functions of the configuration: plain arrays where a linkage is small,
SciPy's sparse ones where it is large, so that time and memory grow with the entries.

Both take ``matrix @ columns``, slices of rows and transposition; for the rest there are the functions here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..common.arrays import Array, ComplexArray

LARGE = 33  # joints from which sparse matrices are the faster ones
SERIAL = 65_536  # scalar multiplications up to which OpenBLAS makes a complex product in one thread
SERIAL_ROW = 4_095  # the same of one row, which is a vector to it

Matrix = Any
"""A NumPy array or a SciPy `csr_array`."""

Entries = Mapping[int, complex]
"""A row: its entries by their columns."""


def matrix(rows: Sequence[Entries], width: int, joints: int, dtype: type = complex) -> Matrix:
    """The matrix (rows, width) with these entries, of a linkage with so many ``joints``."""
    if joints < LARGE:
        filled: Array = np.zeros((len(rows), width), dtype)
        for place, row in enumerate(rows):
            for column, entry in row.items():
                filled[place, column] = entry
        return filled
    from scipy.sparse import csr_array  # its import takes longer than loading a small press

    ends = np.cumsum([0, *map(len, rows)])
    columns = np.array([column for row in rows for column in row], dtype=int)
    entries: Array = np.array([entry for row in rows for entry in row.values()], dtype)
    found = csr_array((entries, columns, ends), shape=(len(rows), width))
    found.sort_indices()
    return found


def product(rows: Matrix, columns: Any) -> Any:
    """``rows @ columns`` for any rows and many columns; of a plain array in pieces so small that BLAS keeps to one thread.

    Its threads are no gain here, and where the machine has other work to do they wait milliseconds for each other.
    """
    if not isinstance(rows, np.ndarray):
        return np.asarray(rows @ columns)
    step = max(1, (SERIAL if len(rows) > 1 else SERIAL_ROW) // max(1, rows.size))
    if columns.shape[1] <= step:
        return np.asarray(rows @ columns)
    result = np.empty((len(rows), columns.shape[1]), np.result_type(rows, columns))
    for start in range(0, columns.shape[1], step):
        np.matmul(rows, columns[:, start : start + step], out=result[:, start : start + step])
    return result


def plain(rows: Matrix) -> Any:
    """The matrix as a NumPy array."""
    return rows if isinstance(rows, np.ndarray) else rows.toarray()


def stacked(parts: Sequence[Matrix]) -> Matrix:
    """The rows of all parts, one below the other."""
    if isinstance(parts[0], np.ndarray):
        return np.concatenate(parts)
    from scipy.sparse import vstack  # see `matrix`

    return vstack(parts, format="csr")


def weighted(rows: Matrix, weights: Array) -> Matrix:
    """Every row times its weight."""
    return rows * weights[:, None] if isinstance(rows, np.ndarray) else rows.multiply(weights[:, None]).tocsr()


def compressed(rows: Matrix) -> Matrix:
    """A product or transpose of such matrices in the form of one of them again."""
    return rows if isinstance(rows, np.ndarray) else rows.tocsr()


def with_column(rows: Matrix, column: int, entries: ComplexArray) -> Matrix:
    """The matrix with one column replaced."""
    changed = rows.copy() if isinstance(rows, np.ndarray) else rows.tolil()
    changed[:, [column]] = entries[:, None]
    return compressed(changed)
