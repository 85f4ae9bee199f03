"""The engine of linkages in space: all crank angles at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...common.quantities import Array
from ..body_motion import BodyMotion
from ..engine import PIECE, CloseDrivers, ClosedStates, Closure, JointRates
from ..pinocchio.equations import redundant
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

    def body_motion(self, states: ClosedStates, joints: Sequence[int], accelerations: bool = True) -> BodyMotion:
        motion, rows = bodies.body_motion(self.loops.bodies, states, accelerations), [joint - 1 for joint in joints]
        return BodyMotion(*(values[rows] if values.size else values for values in motion))

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
