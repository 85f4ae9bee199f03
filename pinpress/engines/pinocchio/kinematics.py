"""Rank of the equations and motions of bodies by Pinocchio, one configuration at a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from ...common.quantities import Array
from ..body_motion import BodyMotion
from ..engine import ClosedStates
from ..rank import rank
from ..structure import Structure, configuration, data_of
from .equations import OneConfiguration


def redundant(structure: Structure, x: Array) -> bool:
    """Whether some of the equations are redundant at joint coordinates (nv,)."""
    rows = OneConfiguration(structure).at(x)
    return rank(rows.columns) < len(rows.gaps)


def body_motion(structure: Structure, states: ClosedStates, joints: Sequence[int]) -> BodyMotion:
    """Motion of the bodies of these joints."""
    count, n = len(joints), states.v.shape[1]
    rotation, vectors = np.empty((count, 3, 3, n)), np.empty((5, count, 3, n))
    data, q = data_of(structure.model), configuration(structure.slots, states.position)
    for i in range(n):
        pin.forwardKinematics(structure.model, data, np.ascontiguousarray(q[:, i]), states.v[:, i].copy(), states.a[:, i].copy())
        for k, joint in enumerate(joints):
            velocity, acceleration = data.v[joint], data.a[joint]
            rotation[k, ..., i] = turn = data.oMi[joint].rotation
            vectors[0, k, :, i] = data.oMi[joint].translation
            local = velocity.linear, velocity.angular, pin.classicAcceleration(velocity, acceleration), acceleration.angular
            vectors[1:, k, :, i] = np.array(local) @ turn.T
    return BodyMotion(rotation, *vectors)
