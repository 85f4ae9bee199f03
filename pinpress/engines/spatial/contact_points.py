"""Loops as points that Pinocchio's constraints hold together: one of a spherical loop, two of the axis of a revolute one, three of a fixed
one, the further ones as far away as the linkage is long, so that every gap is a length."""

from typing import Any

import numpy as np
import pinocchio as pin

from ...common.arrays import Array
from ..joints import LoopJoint

End = tuple[int, pin.SE3, int, pin.SE3]
"""Two points that a loop holds together: joint and place in its frame, of either side."""


def ends_of(loop: LoopJoint, data: pin.Data, size: float) -> list[End]:
    """The points of a loop; ``data`` has the closed pose."""
    result = [(loop.joint1, pin.SE3(np.eye(3), loop.point1), loop.joint2, pin.SE3(np.eye(3), loop.point2))]
    for axis in range({0: 0, 2: 1, 3: 2}[loop.held]):
        along1, along2 = loop.rotation1[:, axis], loop.rotation2[:, axis]
        worlds = data.oMi[loop.joint1].rotation @ along1, data.oMi[loop.joint2].rotation @ along2
        turned = float(np.sign(worlds[0] @ worlds[1]))  # the axes of a revolute loop are aligned whichever way round
        places = (pin.SE3(np.eye(3), point) for point in (loop.point1 + size * along1, loop.point2 + turned * size * along2))
        result.append((loop.joint1, next(places), loop.joint2, next(places)))
    return result


def contacts(model: pin.Model, ends: list[End]) -> tuple[Any, Any]:
    """Pinocchio's models and data of the points, for `constraintDynamics`."""
    kind = pin.ContactType.CONTACT_3D
    points = pin.StdVec_RigidConstraintModel([pin.RigidConstraintModel(kind, model, *end, pin.LOCAL) for end in ends])
    return points, pin.StdVec_RigidConstraintData([point.createData() for point in points])


def contact_rows(model: pin.Model, data: pin.Data, points: Any, data_of_points: Any, x: Array) -> Array:
    """Jacobian (3 points, nv) as `constraintDynamics` has it: in open states it differs from that of the anchors."""
    pin.computeJointJacobians(model, data, x)
    for point, datum in zip(points, data_of_points, strict=True):
        point.calc(model, data, datum)
    return np.array(pin.getConstraintsJacobian(model, data, points, data_of_points)).reshape(-1, model.nv)
