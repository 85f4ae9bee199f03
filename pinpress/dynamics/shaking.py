"""What the machine exerts on its foundation: all that its links, loads and weight put on the frame."""

from collections.abc import Mapping

import numpy as np

from ..common.arrays import Array
from ..engines.forces import AppliedForce
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage


def on_frame(press: Linkage) -> tuple[int, ...]:
    """Indices of the bearings on the frame in `Linkage.bearings`."""
    joints = [j for j, parent in enumerate(list(press.model.parents)[1:]) if parent == 0]
    return (*joints, *(k for k, loop in enumerate(press.loops, len(press.joints)) if 0 in (loop.joint1, loop.joint2)))


def shaking(
    press: Linkage, motion: Motion, force: Mapping[int, Array], moment: Mapping[int, Array], loads: list[AppliedForce]
) -> tuple[Array, Array]:
    """Shaking force and shaking moment about the world origin, (n, 3) each, world axes [N, N m].

    Args:
        press: The press.
        motion: Its motion.
        force: (n, 3) by the bearing's index, of all that are `on_frame`: parent on child, link1 on link2 [N].
        moment: (n, 3) by the bearing's index, of the same [N m].
        loads: Those on the frame are passed on, those on other links are in the bearings' forces.
    """
    model, axes, count = press.model, press.axes, len(press.joints)
    total = np.zeros((2, len(motion.crank_angle), 3))

    def put(on_frame: Array, about: Array | float, point: Array) -> None:
        total[0] += on_frame
        for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):  # np.cross takes several times as long
            total[1, :, i] += point[..., j] * on_frame[..., k] - point[..., k] * on_frame[..., j]
        total[1] += about

    frame = model.inertias[0]
    put(frame.mass * model.gravity.linear, 0.0, frame.lever)
    for k in on_frame(press):
        if k < count:
            place = model.jointPlacements[k + 1]
            point = place.translation
            if not axes[k].turns:
                point = point + motion.joint_position[:, k, None] * (place.rotation @ axes[k].direction)
            put(-force[k], -moment[k], point)
            continue
        loop = press.loops[k - count]
        if loop.joint1 == 0:
            put(-force[k], -moment[k], loop.point1)
        if loop.joint2 == 0:
            put(force[k], moment[k], loop.point2)
    for load in loads:
        if load.joint == 0:
            put(load.force, 0.0, load.point)
    return total[0], total[1]
