"""Engines of linkages in space, which solve all crank angles at once; `SpatialEngine` also computes the equations at all of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...common.quantities import Array
from ..body_motion import BodyMotion
from ..engine import PIECE, CloseDrivers, ClosedStates, Closure, JointRates
from ..pinocchio.equations import redundant
from ..structure import Structure
from ..wrenches import AppliedConditions, BearingLoads, Idle, Wrenches
from . import bodies, closing, equations
from .equations import AT_ONCE, Kinematics, Loops, build_loops

if TYPE_CHECKING:
    from .inverse_dynamics import Method


@dataclass(frozen=True, eq=False, repr=False)
class EngineInSpace(ABC):
    """What the engines of linkages in space have in common; see `Engine`.

    Attributes:
        structure: of the linkage.
    """

    structure: Structure

    @abstractmethod
    def _kinematics(self) -> Kinematics:
        """How the equations are computed, for use within one call."""

    @abstractmethod
    def _method(self) -> Method:
        """How equations and forces of the open tree are computed, for use within one call."""

    @cached_property
    def loops(self) -> Loops:
        """Constants of the equations."""
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
        return closing.close(self.loops, angle[None], np.ones((1, len(angle))), guess, with_margins, self._kinematics())

    def closing_function(self) -> CloseDrivers:
        kinematics = self._kinematics()

        def close(drivers: Array, along: Array, guess: Array) -> Closure:
            return closing.close(self.loops, drivers, along, guess, True, kinematics)

        return close

    def rates(self, position: Array, speed: Array, acceleration: Array) -> JointRates:
        return closing.rates(self.loops, position, speed, acceleration, self._kinematics())

    def gaps(self, position: Array) -> Array:
        return equations.gaps(self.loops, position, self._kinematics())

    def redundant(self, x: Array) -> bool:
        return redundant(self.structure, x)

    def closing_order(self) -> Iterator[tuple[int, Sequence[int]]]:
        return enumerate(self.structure.joints_of_constraints)

    # ------------------------------------------------------------------------------------------------------------------ dynamics

    def inverse_dynamics(self, states: ClosedStates, conditions: AppliedConditions, bearings: bool = True) -> Wrenches:
        from .inverse_dynamics import inverse_dynamics  # not needed to load

        return inverse_dynamics(self.loops, states, conditions, bearings, self._method())

    def bearing_loads(self, states: ClosedStates, conditions: AppliedConditions, rates: Array) -> BearingLoads:
        from .inverse_dynamics import bearing_loads  # not needed to load

        return bearing_loads(self.loops, states, conditions, rates, self._method())

    def idle(self, states: ClosedStates) -> Idle:
        from .inverse_dynamics import idle_forces  # not needed to load

        return idle_forces(self.loops, states.position, self._method())

    def indeterminate(self, position: Array, axes: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        from .inverse_dynamics import indeterminate  # not needed to load

        return indeterminate(self.loops, position, axes, self._method())


class SpatialEngine(EngineInSpace):
    """The engine in space for one linkage; see `Engine`."""

    name = "space"

    def _kinematics(self) -> Kinematics:
        return AT_ONCE

    def _method(self) -> Method:
        from .inverse_dynamics import IN_SPACE  # not needed to load

        return IN_SPACE

    def body_motion(self, states: ClosedStates, joints: Sequence[int], accelerations: bool = True) -> BodyMotion:
        motion, rows = bodies.body_motion(self.loops.bodies, states, accelerations), [joint - 1 for joint in joints]
        return BodyMotion(*(values[rows] if values.size else values for values in motion))
