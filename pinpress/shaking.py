"""What the machine exerts on its foundation: all that its links, loads and weight put on the frame."""

import numpy as np

from .coordinates import Array
from .forces import AppliedForce
from .linkage import Linkage
from .motion import Motion


def shaking(press: Linkage, motion: Motion, force: Array, moment: Array, loads: list[AppliedForce]) -> tuple[Array, Array]:
    """Shaking force and shaking moment about the world origin, (n, 3) each, world axes [N, N m].

    Args:
        force, moment: (bearings, n, 3) of `Linkage.bearings`, parent on child, link1 on link2.
        loads: those on the frame are passed on, those on other links are in the bearings' forces.
    """
    model, count = press.model, len(press.joints)
    total = np.zeros((2, len(motion.crank_angle), 3))

    def put(on_frame: Array, about: Array | float, point: Array) -> None:
        total[0] += on_frame
        total[1] += np.cross(point, on_frame) + about

    frame = model.inertias[0]
    put(frame.mass * model.gravity.linear, 0.0, frame.lever)
    for j in range(count):
        if model.parents[j + 1] == 0:
            place = model.jointPlacements[j + 1]
            point = place.translation
            axis = press.spatial.axes[j]
            if not axis.turns:
                point = point + motion.joint_position[:, j, None] * (place.rotation @ axis.direction)
            put(-force[j], -moment[j], point)
    for k, loop in enumerate(press.loops, count):
        if loop.joint1 == 0:
            put(-force[k], -moment[k], loop.point1)
        if loop.joint2 == 0:
            put(force[k], moment[k], loop.point2)
    for load in loads:
        if load.joint == 0:
            put(load.force, 0.0, load.point)
    return total[0], total[1]
