"""How forces that rigid mechanics leaves open are shared: by least squares, one objective after the other.

A linkage with more constraints than it needs can carry idle forces, which move nothing: any multiple y of them may be added to a solution.
Of all y the one is taken that makes the first objective least, of those that do so the one that makes the second least, and so on:

    elastic energy, where stiffnesses are given (bearings without one count as rigid)
    sum of squared bearing forces
    sum of squared bearing moments

Efforts about or along the axis in which a joint is free, those of drives, gear pairs and friction, carry no weight. What is open even then
(torques in a ring of gears) is taken as small as possible.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..common.arrays import Array
from ..common.checks import number
from ..common.errors import PinpressError, UnknownNameError, shown

RANK = 1e-9  # singular values below this share of the largest are zero, columns scaled to unit length

WELL = 1e-3  # the same of squared ones, from which on normal equations lose no digits to speak of


class Objective(NamedTuple):
    """|A y + b| is to be least: A (..., m, k), b (..., m). What is small beside ``scale``, a unit of A, is rounding."""

    matrix: Array
    start: Array
    scale: float


def lexicographic_least_squares(objectives: Iterable[Objective]) -> Array:
    """y (..., k) that makes the first objective least, of those that do so the one that makes the second least, and so on; the shortest of
    those left open."""
    share, free = None, None
    for matrix, start, scale in objectives:
        if share is None or free is None:
            squares = matrix.swapaxes(-1, -2) @ matrix
            values = np.linalg.eigvalsh(squares)
            if np.all(values[..., 0] > WELL * np.maximum(values[..., -1], scale**2)):
                # nothing is left open: the normal equations serve, and cost a third
                return np.asarray(-np.linalg.solve(squares, matrix.swapaxes(-1, -2) @ start[..., None])[..., 0])
            share = np.zeros((*start.shape[:-1], matrix.shape[-1], 1))
            free = np.broadcast_to(np.eye(matrix.shape[-1]), (*start.shape[:-1], matrix.shape[-1], matrix.shape[-1]))
        left, values, right = np.linalg.svd(matrix @ free, full_matrices=False)
        # measured by the whole matrix: where an earlier objective left nothing free, all values are rounding
        kept = values > RANK * np.maximum(np.linalg.norm(matrix, axis=(-2, -1)), scale)[..., None]
        inverse = right.swapaxes(-1, -2) * np.where(kept, 1.0 / np.where(kept, values, 1.0), 0.0)[..., None, :] @ left.swapaxes(-1, -2)
        share = share - inverse @ (matrix @ share + start[..., None])
        free = free - inverse @ (matrix @ free)
        if np.abs(free).max(initial=0.0) < 1e-6:
            break
    assert share is not None
    return share[..., 0]


def compliances(stiffness: Mapping[str, float], bearings: Sequence[str]) -> Array | None:
    """(bearings,) of the linkage with bearings of these names [m/N], zero where no stiffness is given; None where none is given at all.

    Raises:
        UnknownNameError: a bearing that the linkage does not have.
        PinpressError: a stiffness that is not a positive finite number.
    """
    if not isinstance(stiffness, Mapping):
        raise PinpressError("stiffness is no mapping: give {name of a bearing: stiffness [N/m]}")
    if not stiffness:
        return None
    result = np.zeros(len(bearings))
    for name, value in stiffness.items():
        if name not in bearings:
            raise UnknownNameError("bearing", name, bearings)
        result[bearings.index(name)] = 1 / number(f"stiffness of {shown(name)} [N/m]", value, positive=True)
    return result
