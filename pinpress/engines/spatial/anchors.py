"""Pinocchio's constraint models of the loops, and the points at which loops are held.

A spherical loop is held at its point; a revolute one at two points of its axis, as Pinocchio has no constraint of a pin in space; a fixed
one as a frame, or at three points. Further points are as far away as the linkage is long.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from ...common.quantities import Array
from ..joints import LoopJoint, configuration, data_of
from .model import SpatialModel

PointPair = tuple[int, pin.SE3, int, pin.SE3]
"""Two points that a loop holds together: joint and place in its frame, of either side."""


def constraint_models(spatial: SpatialModel, closed: Array) -> tuple[pin.PointAnchorConstraintModel | pin.FrameAnchorConstraintModel, ...]:
    """See `Linkage.constraint_models`; ``closed``: (nv,) joint coordinates of the closed drawn pose."""
    model = spatial.model
    rotations: Sequence[Array] = ()
    if any(loop.held_rotations for loop in spatial.loops):
        data = data_of(model)
        pin.forwardKinematics(model, data, configuration(spatial.slots, closed))
        rotations = [placement.rotation for placement in data.oMi]
    found = []
    for loop in spatial.loops:
        if loop.type == "fixed":
            ends = pin.SE3(loop.rotation1, loop.point1), pin.SE3(loop.rotation2, loop.point2)
            anchors = [pin.FrameAnchorConstraintModel(model, loop.joint1, ends[0], loop.joint2, ends[1])]
        else:
            anchors = [
                pin.PointAnchorConstraintModel(
                    model, joint1, pin.SE3(loop.rotation1, place1.translation), joint2, pin.SE3(loop.rotation2, place2.translation)
                )
                for joint1, place1, joint2, place2 in held_points(loop, rotations, spatial.size)
            ]
        for anchor in anchors:
            anchor.name = loop.name
        found += anchors
    return tuple(found)


def held_points(loop: LoopJoint, rotations: Sequence[Array], size: float) -> list[PointPair]:
    """The points at which a loop is held; ``rotations`` of Pinocchio's joints in the closed pose, ``size`` of the linkage."""
    result = [(loop.joint1, pin.SE3(np.eye(3), loop.point1), loop.joint2, pin.SE3(np.eye(3), loop.point2))]
    for axis in range({0: 0, 2: 1, 3: 2}[loop.held_rotations]):
        along1, along2 = loop.rotation1[:, axis], loop.rotation2[:, axis]
        worlds = rotations[loop.joint1] @ along1, rotations[loop.joint2] @ along2
        turned = float(np.sign(worlds[0] @ worlds[1]))  # the axes of a revolute loop may point against each other
        places = (pin.SE3(np.eye(3), point) for point in (loop.point1 + size * along1, loop.point2 + turned * size * along2))
        result.append((loop.joint1, next(places), loop.joint2, next(places)))
    return result
