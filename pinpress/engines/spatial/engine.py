"""The engine of linkages in space: all crank angles at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...common.quantities import Array
from ..engine import PIECE, CloseDrivers, ClosedStates, Closure, EnergyRates, JointRates, PowerBalance
from ..pinocchio.kinematics import redundant
from ..structure import Structure
from ..wrenches import AppliedConditions, AppliedForce, BearingLoads, Wrenches
from . import bodies, closing, equations
from .equations import AT_ONCE, Loops, build_loops


@dataclass(frozen=True, eq=False, repr=False)
class SpatialEngine:
    """The engine of a linkage in space; see `Engine`.

    Attributes:
        structure: of the linkage.
    """

    structure: Structure

    name = "space"

    @cached_property
    def loops(self) -> Loops:
        """Constants of the linkage."""
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
        return closing.close(self.loops, angle[None], np.ones((1, len(angle))), guess, with_margins, AT_ONCE)

    def closing_function(self) -> CloseDrivers:
        def close(drivers: Array, along: Array, guess: Array) -> Closure:
            return closing.close(self.loops, drivers, along, guess, True, AT_ONCE)

        return close

    def rates(self, position: Array, speed: Array, acceleration: Array) -> JointRates:
        return closing.rates(self.loops, position, speed, acceleration, AT_ONCE)

    def gaps(self, position: Array) -> Array:
        return equations.gaps(self.loops, position)

    def redundant(self, x: Array) -> bool:
        return redundant(self.structure, x)

    def closing_order(self) -> Iterator[tuple[int, Sequence[int]]]:
        return enumerate(self.structure.joints_of_constraints)

    # -------------------------------------------------------------------------------------------------------------------- motion

    def point_motion(self, states: ClosedStates, joint: int, point: Array) -> tuple[Array, Array]:
        placed = bodies.placements(self.loops.bodies, states.position)
        moved = bodies.velocities(self.loops.bodies, bodies.motion_axes(self.loops.bodies, placed), states.v)
        at = placed.point(joint, point)
        return at.T, moved.of_point(joint, at).T

    def point_accelerations(self, states: ClosedStates, joint: int, points: Array) -> tuple[Array, Array]:
        constants = self.loops.bodies
        placed = bodies.placements(constants, states.position)
        axes = bodies.motion_axes(constants, placed)
        moved = bodies.velocities(constants, axes, states.v)
        changed = bodies.accelerations(constants, axes, moved, states.v, states.a)
        at = [placed.point(joint, point) for point in points]
        shape = (len(points), states.v.shape[1], 3)
        return (
            np.array([place.T for place in at]).reshape(shape),
            np.array([changed.of_point(moved, joint, place).T for place in at]).reshape(shape),
        )

    # ------------------------------------------------------------------------------------------------------------------ dynamics

    def inverse_dynamics(self, states: ClosedStates, conditions: AppliedConditions, bearings: bool = True) -> Wrenches:
        from .inverse_dynamics import IN_SPACE, inverse_dynamics  # not needed to load

        return inverse_dynamics(self.loops, states, conditions, bearings, IN_SPACE)

    def bearing_loads(self, states: ClosedStates, loads: Sequence[AppliedForce], efforts: Array, rates: Array) -> BearingLoads:
        from .inverse_dynamics import IN_SPACE, bearing_loads  # not needed to load

        return bearing_loads(self.loops, states, loads, efforts, rates, IN_SPACE)

    def indeterminate(self, position: Array, axes: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        from .inverse_dynamics import IN_SPACE, indeterminate  # not needed to load

        return indeterminate(self.loops, position, axes, IN_SPACE)

    def power_balance(self, states: ClosedStates, loads: Sequence[AppliedForce]) -> PowerBalance:
        return bodies.power_balance(self.loops.bodies, states, loads)

    def energies(self, states: ClosedStates) -> EnergyRates:
        return bodies.energies(self.loops.bodies, states)
