"""The planar engine: a planar linkage at all crank angles at once, block by block."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...common.frozen import read_only
from ...common.quantities import Array, ComplexArray
from ..body_motion import BodyMotion
from ..engine import CloseDrivers, ClosedStates, Closure, JointRates
from ..structure import Structure
from ..wrenches import AppliedConditions, BearingLoads, Idle, Wrenches
from . import closing, kinematics
from .bodies import Bodies, build_bodies
from .equations import Equations
from .model import Plane, build_plane

if TYPE_CHECKING:
    from .balance import Statics


@dataclass(frozen=True, eq=False, repr=False)
class PlanarEngine:
    """The planar engine of a linkage; see `Engine`.

    Attributes:
        plane: constants of the linkage.
        structure: constants of Pinocchio's engine, by which it is found what redundant equations leave open.
    """

    plane: Plane
    structure: Structure

    name = "plane"

    @staticmethod
    def of(structure: Structure, one_block: bool) -> PlanarEngine | None:
        """The engine of a linkage with one driver; None if the linkage is not planar. ``one_block``: solve all equations together."""
        plane = build_plane(structure, one_block)
        return None if plane is None else PlanarEngine(plane, structure)

    @cached_property
    def equations(self) -> Equations:
        """The equations of loops and relations in absolute coordinates."""
        return Equations.of(self.plane)

    @cached_property
    def bodies(self) -> Bodies:
        """Inertial constants of the linkage."""
        return read_only(build_bodies(self.plane, self.structure.model))

    @property
    def tolerance(self) -> float:
        return self.plane.tolerance

    @property
    def piece(self) -> int:
        return self.plane.piece

    @property
    def directions(self) -> Array:
        return self.plane.axes

    def turning_axes(self, joint: int = 0) -> Array:
        return self.plane.frames[joint - 1][2:] if joint else self.plane.normal[None]

    # ----------------------------------------------------------------------------------------------------------------- equations

    def close(self, angle: Array, guess: Array, with_margins: bool = False) -> Closure:
        return closing.close(self.equations, angle, guess, with_margins)

    def closing_function(self) -> CloseDrivers:
        def close(drivers: Array, along: Array, guess: Array) -> Closure:
            closure, rate = closing.close(self.equations, drivers[0], guess, with_margins=True), along[0]
            return closure if np.all(rate == 1.0) else replace(closure, first=rate * closure.first, second=rate**2 * closure.second)

        return close

    def rates(self, position: Array, speed: Array, acceleration: Array) -> JointRates:
        basis = kinematics.basis_at(self.plane, position)
        first, second = closing.influence(self.equations, basis, position)
        return JointRates(first * speed, first * acceleration + second * speed**2, kinematics.gaps(self.plane, position, basis))

    def gaps(self, position: Array) -> Array:
        return kinematics.gaps(self.plane, position, kinematics.basis_at(self.plane, position))

    def redundant(self, x: Array) -> bool:
        return self.plane.redundant

    def closing_order(self) -> Iterator[tuple[int, Sequence[int]]]:
        for block in self.plane.blocks:
            for k in (*block.loops, *(len(self.structure.loops) + relation for relation in block.relations)):
                yield k, block.joints

    # -------------------------------------------------------------------------------------------------------------------- motion

    def body_motion(self, states: ClosedStates, joints: Sequence[int], accelerations: bool = True) -> BodyMotion:
        return kinematics.body_motion(self.plane, self._basis(states), states, [joint - 1 for joint in joints], accelerations)

    def _basis(self, states: ClosedStates) -> ComplexArray:
        return kinematics.basis_at(self.plane, states.position) if states.basis is None else states.basis

    # ------------------------------------------------------------------------------------------------------------------ dynamics

    def inverse_dynamics(self, states: ClosedStates, conditions: AppliedConditions, bearings: bool = True) -> Wrenches:
        from .inverse_dynamics import inverse_dynamics  # slow to import, and not needed to load

        return inverse_dynamics(self._statics, self._closed(states), conditions, bearings)

    @cached_property
    def _statics(self) -> Statics:
        from .balance import build_statics  # slow to import, and not needed to load

        return build_statics(self.bodies, self.equations)

    def bearing_loads(self, states: ClosedStates, conditions: AppliedConditions, rates: Array) -> BearingLoads:
        from .inverse_dynamics import bearing_loads  # slow to import, and not needed to load

        return bearing_loads(self._statics, self._closed(states), conditions, rates)

    def idle(self, states: ClosedStates) -> Idle:
        from .inverse_dynamics import idle_wrenches  # slow to import, and not needed to load

        return idle_wrenches(self._statics, self._closed(states))

    def indeterminate(self, position: Array, axes: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        # slow to import, and not needed to load
        from ..pinocchio.engine import PinocchioEngine
        from .out_of_plane import indeterminate

        if self.plane.redundant:
            return PinocchioEngine(self.structure).indeterminate(position, axes)
        return indeterminate(self.plane, position, axes), np.zeros(len(self.structure.relations), dtype=bool)

    def _closed(self, states: ClosedStates) -> ClosedStates:
        """The states with their basis; raises AssemblyError where they leave the loops open."""
        if states.basis is not None:
            return states
        from .inverse_dynamics import closed_basis  # slow to import, and not needed to load

        return ClosedStates(states.position, states.v, states.a, closed_basis(self.plane, states.position))
