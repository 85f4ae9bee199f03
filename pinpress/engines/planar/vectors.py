"""Vectors of a plane put into arrays of world vectors.

Most presses stand in a coordinate plane: zeros cost nothing.
"""

import numpy as np

from ...common.arrays import Array, ComplexArray
from .model import Plane


def put(plane: Plane, vectors: ComplexArray, out: Array) -> None:
    """Fill ``out`` (..., 3), zero so far, with complex vectors (...)."""
    for i, (first, second) in enumerate(plane.axes.T):
        if first:
            np.multiply(vectors.real, first, out=out[..., i])
        if second and first:
            out[..., i] += second * vectors.imag
        elif second:
            np.multiply(vectors.imag, second, out=out[..., i])


def put_normal(plane: Plane, values: Array, out: Array) -> None:
    """Fill ``out`` (n, 3), zero so far, with vectors of lengths (n,) along the normal."""
    for i, share in enumerate(plane.normal):
        if share:
            np.multiply(values, share, out=out[:, i])
