"""Where the bodies, bearings and points of a linkage are, over many states at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..common.arrays import Array
from ..linkage.linkage import Linkage
from .motion import Motion


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses of the bodies of all Pinocchio joints (0: the frame) in n states, in world axes.

    Attributes:
        rotation: (joints + 1, n, 3, 3) rotation matrices of the joints' frames.
        position: (joints + 1, n, 3) positions of the joints' frames [m].
    """

    rotation: Array
    position: Array

    def points(self, joint: int, point: Array) -> Array:
        """(n, 3) world position of a point (3,) fixed to the body of a joint, in that joint's frame [m]."""
        return np.asarray(self.rotation[joint] @ point + self.position[joint])


def poses(press: Linkage, joint_position: Array) -> Poses:
    """Poses of all bodies at joint coordinates (n, nv), from the placements of the model's joints."""
    model, n = press.model, len(joint_position)
    rotation, position = np.empty((model.njoints, n, 3, 3)), np.empty((model.njoints, n, 3))
    rotation[0], position[0] = np.eye(3), 0.0
    for j, (axis, moved) in enumerate(zip(press.axes, joint_position.T, strict=True), 1):
        parent, place = model.parents[j], model.jointPlacements[j]
        rotation[j] = rotation[parent] @ place.rotation
        position[j] = position[parent] + rotation[parent] @ place.translation
        if axis.turns:
            rotation[j] = rotation[j] @ _turned(axis.direction, moved)
        else:
            position[j] += moved[:, None] * (rotation[j] @ axis.direction)
    return Poses(rotation, position)


def bearing_points(press: Linkage, at: Poses) -> Array:
    """(bearings, n, 3) where the bearings' forces act, in the order of `Linkage.bearings`, world axes [m]: the origin of the child's
    joint frame, of a loop its point."""
    joints = [at.position[j] for j in range(1, press.model.njoints)]
    return np.array([*joints, *(at.points(loop.joint1, loop.point1) for loop in press.loops)])


def point_motion(press: Linkage, motion: Motion, joint: int, point: Array) -> tuple[Array, Array]:
    """World position [m] and velocity [m/s], (n, 3) each, of a point (3,) fixed to the body of a Pinocchio joint (0: the frame)."""
    n = len(motion.crank_angle)
    if joint == 0:
        return np.broadcast_to(point, (n, 3)), np.zeros((n, 3))
    return press.engine().point_motion(motion.states(press), joint, point)


def loaded_bodies(press: Linkage) -> tuple[int, ...]:
    """The Pinocchio joints of the bodies on which the bearings' forces act: child, link2 of a loop."""
    return (*range(1, press.model.njoints), *(loop.joint2 for loop in press.loops))


def _turned(axis: Array, angle: Array) -> Array:
    """(n, 3, 3) rotations by angles (n,) about an axis, by Rodrigues' formula."""
    across = pin.skew(axis)
    return np.asarray(np.eye(3) + np.multiply.outer(np.sin(angle), across) + np.multiply.outer(1.0 - np.cos(angle), across @ across))
