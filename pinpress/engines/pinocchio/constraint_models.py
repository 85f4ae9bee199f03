"""Pinocchio's constraint models of the loops, for users of Pinocchio.

A spherical loop is held at its point; a revolute one at two points of its axis, because Pinocchio has no constraint of a pin in space; a
fixed one as a frame. `ForwardDynamics` holds a fixed loop at three points.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from ...common.quantities import Array
from ..constraints import LoopJoint
from ..structure import Structure, configuration, data_of

PointPair = tuple[int, pin.SE3, int, pin.SE3]
"""Two points that a loop holds together: joint and place in its frame, of either side."""


def constraint_models(structure: Structure, closed: Array) -> tuple[pin.PointAnchorConstraintModel | pin.FrameAnchorConstraintModel, ...]:
    """See `Linkage.constraint_models`; ``closed``: (nv,) joint coordinates of the closed drawn pose."""
    model = structure.model
    rotations: Sequence[Array] = ()
    if any(loop.held_rotations for loop in structure.loops):
        data = data_of(model)
        pin.forwardKinematics(model, data, configuration(structure.slots, closed))
        rotations = [placement.rotation for placement in data.oMi]
    models = []
    for loop in structure.loops:
        if loop.type == "fixed":
            ends = pin.SE3(loop.rotation1, loop.point1), pin.SE3(loop.rotation2, loop.point2)
            anchors = [pin.FrameAnchorConstraintModel(model, loop.joint1, ends[0], loop.joint2, ends[1])]
        else:
            anchors = [
                pin.PointAnchorConstraintModel(
                    model, joint1, pin.SE3(loop.rotation1, place1.translation), joint2, pin.SE3(loop.rotation2, place2.translation)
                )
                for joint1, place1, joint2, place2 in held_points(loop, rotations, structure.size)
            ]
        for anchor in anchors:
            anchor.name = loop.name
        models += anchors
    return tuple(models)


def held_points(loop: LoopJoint, rotations: Sequence[Array], size: float) -> list[PointPair]:
    """The points at which a loop is held: one of a spherical loop, two of a revolute and three of a fixed one.

    Args:
        loop: the loop.
        rotations: rotations of Pinocchio's joints in the closed pose; empty where no loop prevents rotations.
        size: length of the linkage, by which further points are away from the loop's own [m].
    """
    result = [(loop.joint1, pin.SE3(np.eye(3), loop.point1), loop.joint2, pin.SE3(np.eye(3), loop.point2))]
    for axis in range({0: 0, 2: 1, 3: 2}[loop.held_rotations]):
        along1, along2 = loop.rotation1[:, axis], loop.rotation2[:, axis]
        worlds = rotations[loop.joint1] @ along1, rotations[loop.joint2] @ along2
        turned = float(np.sign(worlds[0] @ worlds[1]))  # the axes of a revolute loop may point against each other
        places = (pin.SE3(np.eye(3), point) for point in (loop.point1 + size * along1, loop.point2 + turned * size * along2))
        result.append((loop.joint1, next(places), loop.joint2, next(places)))
    return result
