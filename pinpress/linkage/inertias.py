"""Whether inertias are those of bodies, however a linkage was made or changed."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

ROUNDED = (
    4e-6  # of the largest principal moment: files may round each link's by 1e-6, and the largest of links welded is a third of their sum
)


def first_unphysical(inertias: Sequence[pin.Inertia]) -> tuple[int, str] | None:
    """The first of some inertias that no body has, by its index, and why; None if bodies have all of them.

    No body has a mass below zero, or principal moments that break I1 + I2 >= I3 >= 0. Masses and moments of zero pass, of links without
    mass and of points.
    """
    masses, levers, tensors = map(np.array, zip(*((inertia.mass, inertia.lever, inertia.inertia) for inertia in inertias), strict=True))
    finite = np.isfinite(masses + levers.sum(axis=1) + tensors.sum(axis=(1, 2)))
    if not finite.all():
        return int(np.argmin(finite)), "a mass, centre of mass or moment of inertia that is not finite"
    moments = np.linalg.eigvalsh(tensors)
    least = np.minimum(moments[:, 0], moments[:, 0] + moments[:, 1] - moments[:, 2])
    wrong = np.flatnonzero((masses < 0.0) | (least < -ROUNDED * np.abs(moments).max(axis=1)))
    if not len(wrong):
        return None
    k = int(wrong[0])
    if masses[k] < 0.0:
        return k, f"a mass of {masses[k]:g} kg"
    low, middle, high = moments[k]
    return k, f"principal moments of inertia of {low:g}, {middle:g} and {high:g} kg m2, which no body has"
