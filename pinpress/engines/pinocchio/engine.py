"""Pinocchio's engine: any linkage, one configuration at a time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ...common.quantities import Array
from ..body_motion import BodyMotion
from ..engine import PIECE, CloseDrivers, ClosedStates, Closure, JointRates
from ..structure import Structure, configuration, data_of
from ..wrenches import AppliedConditions, AppliedForce, BearingLoads, Wrenches

if TYPE_CHECKING:
    from ..spatial.equations import Loops


@dataclass(frozen=True, eq=False, repr=False)
class PinocchioEngine:
    """Pinocchio's engine for one linkage; see `Engine`.

    Attributes:
        structure: constants of the linkage.
    """

    structure: Structure

    name = "pinocchio"

    @cached_property
    def loops(self) -> Loops:
        """Constants of the equations, as of the engine in space."""
        from ..spatial.equations import build_loops  # slow to import, and not needed to load

        return build_loops(self.structure)

    @property
    def piece(self) -> int:
        return PIECE

    @property
    def tolerance(self) -> float:
        return self.structure.tolerance

    @property
    def directions(self) -> Array:
        return np.eye(3)

    def turning_axes(self, joint: int = 0) -> Array:
        return np.eye(3)

    # ----------------------------------------------------------------------------------------------------------------- equations

    def close(self, angle: Array, guess: Array, with_margins: bool = False) -> Closure:
        return self.closing_function()(angle[None], np.ones((1, len(angle))), guess)

    def closing_function(self) -> CloseDrivers:
        from ..spatial import closing  # its engine stands on this one
        from .equations import one_by_one

        kinematics = one_by_one(self.structure)

        def close(drivers: Array, along: Array, guess: Array) -> Closure:
            return closing.close(self.loops, drivers, along, guess, True, kinematics)

        return close

    def rates(self, position: Array, speed: Array, acceleration: Array) -> JointRates:
        from ..spatial import closing  # as above
        from .equations import one_by_one

        return closing.rates(self.loops, position, speed, acceleration, one_by_one(self.structure))

    def gaps(self, position: Array) -> Array:
        from .equations import OneConfiguration  # as above

        equations = OneConfiguration(self.structure)
        return np.array([equations.widest(equations.at(x).gaps) for x in position.T])

    def redundant(self, x: Array) -> bool:
        from .equations import redundant  # as above

        return redundant(self.structure, x)

    def closing_order(self) -> Iterator[tuple[int, Sequence[int]]]:
        return enumerate(self.structure.joints_of_constraints)

    # -------------------------------------------------------------------------------------------------------------------- motion

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

    # ------------------------------------------------------------------------------------------------------------------ dynamics

    def inverse_dynamics(self, states: ClosedStates, conditions: AppliedConditions, bearings: bool = True) -> Wrenches:
        from ..spatial.inverse_dynamics import inverse_dynamics  # slow to import, and not needed to load
        from .inverse_dynamics import by_pinocchio

        return inverse_dynamics(self.loops, states, conditions, bearings, by_pinocchio(self.structure))

    def bearing_loads(self, states: ClosedStates, loads: Sequence[AppliedForce], efforts: Array, rates: Array) -> BearingLoads:
        from ..spatial.inverse_dynamics import bearing_loads  # slow to import, and not needed to load
        from .inverse_dynamics import by_pinocchio

        return bearing_loads(self.loops, states, loads, efforts, rates, by_pinocchio(self.structure))

    def indeterminate(self, position: Array, axes: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        from ..spatial.inverse_dynamics import indeterminate  # slow to import, and not needed to load
        from .inverse_dynamics import by_pinocchio

        return indeterminate(self.loops, position, axes, by_pinocchio(self.structure))
