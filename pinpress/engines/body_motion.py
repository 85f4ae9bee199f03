"""How the bodies of a linkage and points of them move, and products of vectors, at all states at once.

Arrays have the states last: rotations (..., 3, 3, n), vectors (..., 3, n). In memory the components come first, so that one component of
all bodies is one row of numbers: products of vectors then take a third of the time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..common.quantities import Array

NOTHING = np.empty(0)


class BodyMotion(NamedTuple):
    """Motion of k bodies in n states, world axes.

    Attributes:
        rotation: (k, 3, 3, n) from the frames of their joints to the world.
        origin: (k, 3, n) positions of the origins of these frames [m].
        velocity: (k, 3, n) of the origins [m/s].
        spin: (k, 3, n) angular velocities [rad/s].
        acceleration: (k, 3, n) of the origins [m/s2]; empty if accelerations were left out.
        turning: (k, 3, n) angular accelerations [rad/s2]; empty as well.
    """

    rotation: Array
    origin: Array
    velocity: Array
    spin: Array
    acceleration: Array = NOTHING
    turning: Array = NOTHING

    def points(self, points: Array) -> PointMotion:
        """Motion of a point of every body, (k, 3) in the frames of their joints, or of any number of points (p, 3) of a single body."""
        return self.at_arms(np.einsum("kijn,kj->kin", self.rotation, points))

    def at_arms(self, arm: Array) -> PointMotion:
        """Motion of the points that are away from the origins by vectors (k, 3, n) in world axes [m]."""
        turning = cross(self.spin, arm)
        place, velocity = arm + self.origin, turning + self.velocity
        if not self.turning.size:
            return PointMotion(place, velocity)
        return PointMotion(place, velocity, self.acceleration + cross(self.turning, arm) + cross(self.spin, turning))


class PointMotion(NamedTuple):
    """Motion of p points in n states: (p, 3, n) positions [m], velocities [m/s] and, as in `BodyMotion`, accelerations [m/s2] in world
    axes."""

    place: Array
    velocity: Array
    acceleration: Array = NOTHING


def cross(one: Array, other: Array) -> Array:
    """The vector product of vectors (..., 3, n)."""
    shape = np.broadcast_shapes(one.shape, other.shape)
    result = np.empty(shape) if len(shape) == 2 else components_first(shape[-3], shape[-1], *shape[:-3])
    less = np.empty((*shape[:-2], shape[-1]))
    for row, first, second in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        own = result[..., row, :]
        np.multiply(one[..., first, :], other[..., second, :], out=own)
        np.multiply(one[..., second, :], other[..., first, :], out=less)
        own -= less
    return result


def turned(rotation: Array, vectors: Array) -> Array:
    """Rotations (..., 3, 3, n) times vectors (..., 3, n)."""
    return np.asarray(np.einsum("...ijn,...jn->...in", rotation, vectors))


def turned_back(rotation: Array, vectors: Array) -> Array:
    """Inverse rotations (..., 3, 3, n) times vectors (..., 3, n)."""
    return np.asarray(np.einsum("...jin,...jn->...in", rotation, vectors))


def components_first(count: int, n: int, *before: int) -> Array:
    """Room for vectors (..., count, 3, n), in memory with their components first."""
    return np.empty((*before, 3, count, n)).swapaxes(-3, -2)


def by_constants(matrices: Array, vectors: Array) -> Array:
    """Constant matrices (k, 3, 3) of bodies times vectors (k, 3, n)."""
    return np.asarray(np.matmul(matrices, vectors, out=components_first(*vectors.shape[::2])))
