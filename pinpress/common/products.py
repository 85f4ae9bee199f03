"""Products of matrices that wake no threads of BLAS, whatever the user has set.

On matrices of few rows or few columns threads gain next to nothing, and on a busy machine they wait for each other, many milliseconds
each time. Products are therefore taken in pieces that OpenBLAS computes in one thread.
"""

from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from .quantities import Array, ComplexArray

# Numbers up to which OpenBLAS stays in one thread:
SERIAL = 262_144  # multiplications of a product of real matrices
SERIAL_COMPLEX = 65_536  # of complex matrices
SERIAL_COMPLEX_VECTOR = 4_095  # of complex ones, one of them a single row or column, which OpenBLAS takes for a vector


@overload
def product(rows: Array, columns: Array) -> Array: ...
@overload
def product(rows: ComplexArray, columns: Array | ComplexArray) -> ComplexArray: ...
@overload
def product(rows: Array, columns: ComplexArray) -> ComplexArray: ...
def product(rows: NDArray[Any], columns: NDArray[Any]) -> NDArray[Any]:
    """``rows`` (m, k) or (k,) times ``columns`` (k, n), or a short vector (k,)."""
    height, count = 1 if rows.ndim == 1 else len(rows), columns.shape[1] if columns.ndim == 2 else 1
    if rows.dtype.kind != "c" and columns.dtype.kind != "c":
        most = SERIAL
    else:
        most = SERIAL_COMPLEX if height > 1 and count > 1 else SERIAL_COMPLEX_VECTOR
    if rows.size * count <= most or columns.ndim == 1 or height == count == 1:
        return np.asarray(rows.dot(columns))  # `@` takes half a microsecond longer
    result = np.empty((*rows.shape[:-1], count), np.result_type(rows, columns))
    step = max(1, most // (columns.size if height > count else rows.size))
    for start in range(0, max(height, count), step):
        s = slice(start, start + step)
        some, others, out = (rows[s], columns, result[s]) if height > count else (rows, columns[:, s], result[..., s])
        if most == SERIAL_COMPLEX and 1 in out.shape:  # the last piece is a vector
            out[...] = product(some, others)
        else:
            np.matmul(some, others, out=out)
    return result
