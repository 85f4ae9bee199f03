"""Where a point of a link is, and how fast, over a motion."""

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..common.arrays import Array
from ..engines.coordinates import data_of
from ..engines.planar.kinematics import basis, basis_velocity
from ..engines.planar.model import Plane, in_space

if TYPE_CHECKING:
    from ..linkage.linkage import Linkage
    from .motion import Motion


def point_motion(press: "Linkage", motion: "Motion", joint: int, point: Array) -> tuple[Array, Array]:
    """World position [m] and velocity [m/s], (n, 3) each, of a point (3,) fixed to the body of a Pinocchio joint (0: the frame)."""
    n = len(motion.crank_angle)
    if joint == 0:
        return np.broadcast_to(point, (n, 3)), np.zeros((n, 3))
    if press.plane is not None:
        return _in_plane(press.plane, motion, joint - 1, point)
    position, velocity = np.empty((n, 3)), np.empty((n, 3))
    data = data_of(press.model)
    for i, (q, v) in enumerate(zip(np.array(motion.q), np.array(motion.v), strict=True)):
        pin.forwardKinematics(press.model, data, q, v)
        speed = data.v[joint]
        position[i] = data.oMi[joint].act(point)
        velocity[i] = data.oMi[joint].rotation @ (speed.linear + np.cross(speed.angular, point))
    return position, velocity


def _in_plane(plane: Plane, motion: "Motion", joint: int, point: Array) -> tuple[Array, Array]:
    at = basis(plane, motion.joint_position.T)
    x, y, height = plane.frames[joint] @ point
    row = plane.point(joint, complex(x, y))
    position, velocity = row @ at, row @ basis_velocity(plane, at, motion.v.T)
    return in_space(plane, position) + (plane.heights[joint] + height) * plane.normal, in_space(plane, velocity)
