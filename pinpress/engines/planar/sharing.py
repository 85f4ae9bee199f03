"""How the bearings of a planar linkage share idle forces in its plane, see `engines.sharing`."""

from __future__ import annotations

import numpy as np

from ...common.quantities import Array, ComplexArray
from ..sharing import Objective, lexicographic_least_squares


def shares_of_idle_forces(parts: ComplexArray, compliance: Array | None) -> Array:
    """Multiples (k, n) of k idle forces that are added to the forces of the bearings.

    Args:
        parts: (k + 1, bearings, n) what every idle force adds to all bearings, then the forces of the bearings without idle forces [N].
        compliance: (bearings,) as in `AppliedConditions`.
    """
    if compliance is None:
        return _of_least_squares(parts)
    forces = np.concatenate([parts.real, parts.imag], axis=1).transpose(2, 1, 0)  # (n, 2 bearings, k + 1)
    weights = np.tile(np.sqrt(compliance), 2)[:, None]
    objectives = ((weights * forces, float(weights.max())), (forces, 1.0))
    return np.asarray(lexicographic_least_squares(Objective(each[:, :, :-1], each[:, :, -1], scale) for each, scale in objectives).T)


def _of_least_squares(parts: ComplexArray) -> Array:
    """The multiples with which the sum of squared bearing forces is least."""
    # The normal equations are good enough: every idle force loads pins of its own, so that their matrix is far from singular.
    count, n = len(parts) - 1, parts.shape[2]
    real, products = parts.view(float), np.empty((count, len(parts), n))
    for k, a in enumerate(real[:count]):
        summed = np.add.reduce(a * real[k:], axis=1)
        products[k, k:] = summed[:, ::2] + summed[:, 1::2]
        products[k + 1 :, k] = products[k, k + 1 : count]
    if count == 1:
        return np.asarray(-products[0, 1] / products[0, 0])[None, :]
    if count == 2:  # by Cramer's rule, which takes a tenth of the time
        (a11, a12, b1), (_, a22, b2) = products
        return np.asarray(np.array([a12 * b2 - a22 * b1, a12 * b1 - a11 * b2]) / (a11 * a22 - a12 * a12))
    return np.asarray(-np.linalg.solve(products[:, :count].transpose(2, 0, 1), products[:, count].T[:, :, None])[:, :, 0].T)
