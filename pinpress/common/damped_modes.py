"""Frequencies and damping ratios of damped modes, each with the undamped mode to which it belongs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .quantities import Array, ComplexArray


class DampedModes(NamedTuple):
    """Damped modes, in the order of the undamped ones.

    Attributes:
        frequency: (n,) frequencies at which they swing, 0 for those that creep [rad/s].
        ratio: (n,) damping ratios: the mean rate of decay by the root of the product of the two eigenvalues [-].
        eigenvalues: (2 n,) of the system in first order [rad/s].
    """

    frequency: Array
    ratio: Array
    eigenvalues: ComplexArray


def damped_modes(frequency: Array, damping: Array) -> DampedModes:
    """Damped modes of a system in its undamped modes of modal mass 1.

    A mode swings with a pair of conjugate eigenvalues, or creeps with two real ones. Each pair, then each real one, goes to the undamped
    mode that takes most part in its motion.

    Args:
        frequency: (n,) undamped frequencies [rad/s].
        damping: (n, n) modal damping [1/s].
    """
    from scipy.optimize import linear_sum_assignment  # slow to import

    count = len(frequency)
    matrix = np.block([[np.zeros((count, count)), np.eye(count)], [-np.diag(frequency**2), -damping]])
    values, vectors = np.linalg.eig(matrix)
    values, moved = values.astype(complex), np.abs(vectors[:count]) ** 2
    part = moved / moved.sum(axis=0)  # (n, 2 n)
    swinging, creeping = np.flatnonzero(values.imag > 0), np.flatnonzero(values.imag == 0)
    modes, chosen = linear_sum_assignment(part[:, swinging], maximize=True)
    pairs = np.empty((count, 2), dtype=complex)
    pairs[modes] = np.stack([values[swinging[chosen]], values[swinging[chosen]].conj()], axis=1)
    crept = np.setdiff1d(np.arange(count), modes)
    chosen = linear_sum_assignment(np.repeat(part[crept], 2, axis=0)[:, creeping], maximize=True)[1]
    pairs[crept] = values[creeping[chosen]].reshape(-1, 2)
    product, fastest = pairs.prod(axis=1).real, np.abs(pairs).max(axis=1)
    # a slow rate that rounding hides is that of the undamped frequency, whose square is the product
    size = np.where(product > count * np.finfo(float).eps * fastest**2, np.sqrt(np.maximum(product, 0.0)), frequency)
    return DampedModes(pairs[:, 0].imag.copy(), -pairs.sum(axis=1).real / (2.0 * size), values)
