"""Rank of equations by their singular values, and their solutions in the least-squares sense.

The columns of a Jacobian are scaled to unit length first, so that angles and travels count alike.

The rank of a linkage that moves does not change: the drivers determine its passive joints, whose columns have full rank. A walk ends
where their smallest singular value falls below `Structure.smallest_margin`, which is `Structure.rank_tolerance` or more. So equations that
contradict each other a little are fulfilled in the least-squares sense, at every position in the same way.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.quantities import Array
from .structure import ZERO, Structure


def unit_columns(columns: Array, tolerance: float = ZERO) -> tuple[Array, Array]:
    """Columns (..., rows, k) scaled to unit length, and the lengths (..., k) that they had; of those that are zero 0 and 1."""
    lengths = np.sqrt((columns * columns).sum(axis=-2))
    still = lengths <= tolerance * lengths.max(axis=-1, initial=0.0)[..., None]  # these joints move nothing here
    lengths = np.where(still, 1.0, lengths)
    return np.where(still[..., None, :], 0.0, columns / lengths[..., None, :]), lengths


def singular_values(columns: Array, tolerance: float = ZERO) -> Array:
    """Singular values (..., k) of Jacobians (..., rows, columns) whose columns are scaled to unit length, largest first."""
    return np.asarray(np.linalg.svd(unit_columns(columns, tolerance)[0], compute_uv=False))


def rank(columns: Array, tolerance: float) -> int:
    """Rank of a Jacobian (rows, columns) of the equations; ``tolerance``: `Structure.rank_tolerance`."""
    return int(ranks(singular_values(columns, tolerance), tolerance))


def ranks(values: Array, tolerance: float = ZERO) -> NDArray[np.intp]:
    """Ranks (...) by singular values (..., k): rounding grows with the largest, what a misfit lifts from zero does not."""
    return np.asarray(np.count_nonzero(values > np.maximum(tolerance, ZERO * values.max(axis=-1, initial=0.0))[..., None], axis=-1))


class PassiveJacobian:
    """The columns of the passive joints in a Jacobian (rows, nv), scaled to unit length, by their singular value decomposition."""

    def __init__(self, columns: Array, structure: Structure) -> None:
        self.joints, self.count, tolerance = list(structure.passive_joints), columns.shape[1], structure.rank_tolerance
        self.scaled, self.lengths = unit_columns(columns[:, self.joints], tolerance)
        self.left, self.values, self.right = np.linalg.svd(self.scaled, full_matrices=True)
        self.rank = int(ranks(self.values, tolerance))

    def rates(self, target: Array) -> Array:
        """Joint rates (nv,), those of drivers zero, that change the gaps by ``target`` (rows,) in the least-squares sense."""
        r = self.rank
        result = np.zeros(self.count)
        result[self.joints] = self.right[:r].T @ ((self.left[:, :r].T @ target) / self.values[:r]) / self.lengths
        return result

    @property
    def idle(self) -> Array:
        """Orthonormal basis (rows, k) of the idle multipliers, which balance each other on the passive joints."""
        return np.asarray(self.left[:, self.rank :])


class Decomposition(NamedTuple):
    """Singular value decompositions of some of the configurations, of one rank r.

    Attributes:
        states: which configurations, m of them.
        rank: their rank.
        left: (m, rows, rows) singular vectors.
        inverse: (m, columns, r) from components along the first of them to the shortest combination of the columns.
    """

    states: NDArray[np.intp]
    rank: int
    left: Array
    inverse: Array


class Decomposed:
    """Columns (n, rows, k) at n configurations, scaled to unit length, by their singular value decompositions; ``tolerance``:
    `Structure.rank_tolerance`.

    Attributes:
        parts: the configurations by their rank.
    """

    def __init__(self, columns: Array, tolerance: float) -> None:
        scaled, lengths = unit_columns(columns, tolerance)
        self.lengths = lengths.T
        left, values, right = np.linalg.svd(scaled, full_matrices=True)
        found = ranks(values, tolerance)
        self.parts = []
        for r in np.unique(found).tolist():
            some = np.flatnonzero(found == r)
            self.parts.append(Decomposition(some, r, left[some], right[some, :r].swapaxes(1, 2) / values[some, None, :r]))

    def rates(self, target: Array) -> Array:
        """Rates (k, n) that change the gaps by ``target`` (rows, n) in the least-squares sense."""
        found = np.empty_like(self.lengths)
        for part in self.parts:
            wanted = target[:, part.states].T[:, :, None]
            found[:, part.states] = (part.inverse @ (part.left[:, :, : part.rank].swapaxes(1, 2) @ wanted))[:, :, 0].T
        return found / self.lengths

    def multipliers(self, effort: Array) -> Array:
        """Multipliers (rows, n) of least norm that balance the efforts (k, n)."""
        wanted, found = effort / self.lengths, np.empty((self.parts[0].left.shape[1], effort.shape[1]))
        for part in self.parts:
            along = part.inverse.swapaxes(1, 2) @ wanted[:, part.states].T[:, :, None]
            found[:, part.states] = (part.left[:, :, : part.rank] @ along)[:, :, 0].T
        return found
