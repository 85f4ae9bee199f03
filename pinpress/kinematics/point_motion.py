"""Where a point of a link is, and how fast, over a motion."""

from typing import TYPE_CHECKING

import numpy as np

from ..common.arrays import Array

if TYPE_CHECKING:
    from ..linkage.linkage import Linkage
    from .motion import Motion


def point_motion(press: "Linkage", motion: "Motion", joint: int, point: Array) -> tuple[Array, Array]:
    """World position [m] and velocity [m/s], (n, 3) each, of a point (3,) fixed to the body of a Pinocchio joint (0: the frame)."""
    n = len(motion.crank_angle)
    if joint == 0:
        return np.broadcast_to(point, (n, 3)), np.zeros((n, 3))
    return press.engine().point_motion(motion.states(press), joint, point)
