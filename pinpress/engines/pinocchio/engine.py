"""Pinocchio's engine: any linkage, one configuration at a time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...common.quantities import Array
from ..engine import PIECE, CloseDrivers, ClosedStates, Closure, EnergyRates, JointRates, PowerBalance
from ..wrenches import AppliedConditions, AppliedForce, BearingLoads, Wrenches
from . import kinematics
from .model import SpatialModel

if TYPE_CHECKING:
    from ..spatial.equations import Loops


@dataclass(frozen=True, eq=False, repr=False)
class PinocchioEngine:
    """Pinocchio's engine for one linkage; see `Engine`.

    Attributes:
        spatial: constants of the linkage.
    """

    spatial: SpatialModel

    name = "pinocchio"

    @cached_property
    def loops(self) -> Loops:
        """Constants of the equations, as of the engine in space."""
        from ..spatial.equations import build_loops  # slow to import, and not needed to load

        return build_loops(self.spatial)

    @property
    def piece(self) -> int:
        return PIECE

    @property
    def tolerance(self) -> float:
        return self.spatial.tolerance

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

        kinematics = one_by_one(self.spatial)

        def close(drivers: Array, along: Array, guess: Array) -> Closure:
            return closing.close(self.loops, drivers, along, guess, True, kinematics)

        return close

    def rates(self, position: Array, speed: Array, acceleration: Array) -> JointRates:
        from ..spatial import closing  # as above
        from .equations import one_by_one

        return closing.rates(self.loops, position, speed, acceleration, one_by_one(self.spatial))

    def gaps(self, position: Array) -> Array:
        equations = self.spatial.equations()
        return np.array([equations.widest(equations.at(x).gaps) for x in position.T])

    def redundant(self, x: Array) -> bool:
        return kinematics.redundant(self.spatial, x)

    def closing_order(self) -> Iterator[tuple[int, Sequence[int]]]:
        loops, couplings = self.spatial.joints_of_loop, self.spatial.couplings
        yield from enumerate([*map(tuple, loops), *((pair.follower, pair.leader) for pair in couplings)])

    # -------------------------------------------------------------------------------------------------------------------- motion

    def point_motion(self, states: ClosedStates, joint: int, point: Array) -> tuple[Array, Array]:
        return kinematics.point_motion(self.spatial, states, joint, point)

    def point_accelerations(self, states: ClosedStates, joint: int, points: Array) -> tuple[Array, Array]:
        return kinematics.point_accelerations(self.spatial, states, joint, points)

    # ------------------------------------------------------------------------------------------------------------------ dynamics

    def inverse_dynamics(self, states: ClosedStates, conditions: AppliedConditions, bearings: bool = True) -> Wrenches:
        from ..spatial.inverse_dynamics import inverse_dynamics  # slow to import, and not needed to load
        from .inverse_dynamics import by_pinocchio

        return inverse_dynamics(self.loops, states, conditions, bearings, by_pinocchio(self.spatial))

    def bearing_loads(self, states: ClosedStates, loads: Sequence[AppliedForce], efforts: Array, rates: Array) -> BearingLoads:
        from ..spatial.inverse_dynamics import bearing_loads  # slow to import, and not needed to load
        from .inverse_dynamics import by_pinocchio

        return bearing_loads(self.loops, states, loads, efforts, rates, by_pinocchio(self.spatial))

    def indeterminate(self, position: Array, axes: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        from ..spatial.inverse_dynamics import indeterminate  # slow to import, and not needed to load
        from .inverse_dynamics import by_pinocchio

        return indeterminate(self.loops, position, axes, by_pinocchio(self.spatial))

    def power_balance(self, states: ClosedStates, loads: Sequence[AppliedForce]) -> PowerBalance:
        return kinematics.power_balance(self.spatial, states, loads)

    def energies(self, states: ClosedStates) -> EnergyRates:
        return kinematics.energies(self.spatial, states)
