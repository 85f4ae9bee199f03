"""The engine of any linkage by Pinocchio's own algorithms, one configuration at a time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..body_motion import BodyMotion
from ..engine import ClosedStates
from ..spatial.engine import EngineInSpace
from ..structure import configuration, data_of
from .equations import one_by_one

if TYPE_CHECKING:
    from ..spatial.equations import Kinematics
    from ..spatial.inverse_dynamics import Method


class PinocchioEngine(EngineInSpace):
    """Pinocchio's engine for one linkage; see `Engine`."""

    name = "pinocchio"

    def _kinematics(self) -> Kinematics:
        return one_by_one(self.structure)

    def _method(self) -> Method:
        from .inverse_dynamics import by_pinocchio  # not needed to load

        return by_pinocchio(self.structure)

    def body_motion(self, states: ClosedStates, joints: Sequence[int], accelerations: bool = True) -> BodyMotion:
        count, n = len(joints), states.v.shape[1]
        rotation, vectors = np.empty((count, 3, 3, n)), np.empty((5, count, 3, n))
        data, q = data_of(self.structure.model), configuration(self.structure.slots, states.position)
        for i in range(n):
            pin.forwardKinematics(self.structure.model, data, np.ascontiguousarray(q[:, i]), states.v[:, i].copy(), states.a[:, i].copy())
            for k, joint in enumerate(joints):
                velocity, acceleration = data.v[joint], data.a[joint]
                rotation[k, ..., i] = turn = data.oMi[joint].rotation
                vectors[0, k, :, i] = data.oMi[joint].translation
                local = velocity.linear, velocity.angular, pin.classicAcceleration(velocity, acceleration), acceleration.angular
                vectors[1:, k, :, i] = np.array(local) @ turn.T
        return BodyMotion(rotation, *vectors)
