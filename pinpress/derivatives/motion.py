"""Exact derivatives of a planar linkage's motion by the positions of its pivots, at fixed crank angle, speed and acceleration.

A loop's gap is C b(x): constant rows C, which follow the pivots (`pivots.shift`), times the basis b of the joint coordinates x
(see `Plane`). It is zero whatever the pivots, and so are its first and second derivative by time. Differentiated in a direction of the
pivots, written ', these three say

    J x' = - C' b          J v' = - C' db/dt - C (db/dt)'          J a' = - C' d2b/dt2 - C (d2b/dt2)'

with the Jacobian J of the loops, and on the right what does not hold the unknown on the left: the implicit function theorem. Each is solved
block by block, as the loops themselves are. Nothing is approximated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..common.arguments import typed
from ..common.arrays import Array, ComplexArray
from ..common.errors import PinpressError
from ..common.frozen import Frozen
from ..engines.constant_rows import product
from ..engines.planar.kinematics import basis, basis_acceleration, basis_velocity, factored, solve
from ..engines.planar.model import Plane
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from .pivots import Pivots, Shift, directed, shift

STEP = 1e-30  # of a complex step: its square is nothing beside a number
CONTRADICTED = 1e-9  # of the displacement: what redundant equations may leave open by rounding


@dataclass(frozen=True, eq=False, repr=False)
class MotionSensitivity(Frozen):
    """Derivatives of a motion of n states in one direction of the pivots.

    They are those of the attributes of `Motion` with the same names, per metre or whatever unit the direction is given per. All arrays are
    read-only.

    Attributes:
        joint_position: (n, nv), counted from the pose that the changed linkage is drawn in, closed at crank angle 0.
        v: (n, nv) of the joint rates.
        a: (n, nv) of the joint accelerations.
        slide_position: (n,); None where the linkage has no slide.
        slide_velocity: (n,); None where the linkage has no slide.
        slide_acceleration: (n,); None where the linkage has no slide.
    """

    joint_position: Array
    v: Array
    a: Array
    slide_position: Array | None
    slide_velocity: Array | None
    slide_acceleration: Array | None


@typed
def motion_derivatives(press: Linkage, motion: Motion, directions: Sequence[Pivots]) -> tuple[MotionSensitivity, ...]:
    """Exact derivatives of a motion by the positions of pivots, at the same crank angles.

    They say to first order how `cycle` of the `reshaped` linkage differs.

    Args:
        press: a planar linkage.
        motion: of this linkage.
        directions: mappings (bearing, link) -> (3,) derivative of the bearing's position in the link's own frame. A direction may move
            several pivots, as one dimension of a press often does.

    Returns:
        The derivatives in every direction.

    Raises:
        PinpressError: the linkage is not planar, the motion is of another one, a direction leads out of its plane, or bearings that hold
            each other cannot stay closed in it.
        UnknownNameError: a bearing or link that the linkage does not have.
    """
    plane = planar(press)
    if motion.joints != press.joints or motion.drivers != press.drivers:
        raise PinpressError(f"the motion is of {motion.linkage} with other joints than {press.name}: make it with cycle(press, ...)")
    states, drawn = States.of(plane, motion.joint_position.T), States.of(plane, press.closed[:, None])
    rates = Rates.of(states, motion.v.T, motion.a.T)
    result = []
    for direction in directions:
        by = shift(press, plane, directed(press, direction))
        tangent = Tangent.of(states, rates, by)
        slide: list[Array | None] = [None, None, None]
        if press.slide is not None:
            guide = press.slide_guide[0]
            slide = [tangent.position[guide] + guide_shift(plane, by, guide), tangent.v[guide], tangent.a[guide]]
        arrays = [(tangent.position - drawn.slope(by)).T, tangent.v.T, tangent.a.T, *slide]
        result.append(MotionSensitivity(*arrays))  # type: ignore[arg-type]
    return tuple(result)


def planar(press: Linkage) -> Plane:
    """The planar engine's constants of a linkage.

    Raises:
        PinpressError: it is not planar.
    """
    return press.plane_or_refuse(
        f"exact derivatives are those of planar linkages with one driver and pins for loops, which {press.name} is not"
    ).dense


def guide_shift(plane: Plane, by: Shift, guide: int) -> float:
    """How far a guide on the frame is moved along its axis [m], which no joint coordinate shows."""
    along = plane.directions[plane.prismatic.index(guide), 0]
    return float((along.conjugate() * by.origins[guide, 0]).real)


class States(NamedTuple):
    """Closed configurations of a planar linkage, ready for their derivatives.

    Attributes:
        plane: the constants of the linkage.
        at: (nb, n) the basis, see `Plane`.
        rows: (closure, n) gaps and columns of the loop Jacobian.
        factors: of the blocks of the Jacobian.
    """

    plane: Plane
    at: ComplexArray
    rows: ComplexArray
    factors: list[Any]

    @staticmethod
    def of(plane: Plane, position: Array) -> States:
        """The states of closed joint coordinates (nv, n)."""
        at = basis(plane, position)
        rows = product(plane.closure, at)
        return States(plane, at, rows, factored(plane, rows))

    def solve(self, opened: ComplexArray) -> Array:
        """The rates (nv, n) of the joints, the driver's zero, that close loops which open at rates (loops, n)."""
        result = np.zeros((len(self.plane.parents), self.at.shape[1]))
        solve(self.plane, self.rows, self.factors, [*-opened, *[None] * len(self.plane.offsets)], result)
        return result

    def slope(self, by: Shift) -> Array:
        """The derivative (nv, n) of the joint coordinates at fixed crank angle."""
        return self.solve(product(by.closure[: len(self.plane.loop_points)], self.at))


class Rates(NamedTuple):
    """Joint rates and accelerations of states, and what they do to the basis.

    Attributes:
        v: (nv, n) joint rates.
        a: (nv, n) joint accelerations.
        first: (nb, n) first derivative of the basis by time.
        second: (nb, n) second derivative of the basis by time.
    """

    v: Array
    a: Array
    first: ComplexArray
    second: ComplexArray

    @staticmethod
    def of(states: States, v: Array, a: Array) -> Rates:
        return Rates(v, a, basis_velocity(states.plane, states.at, v), basis_acceleration(states.plane, states.at, v, a))


class Tangent(NamedTuple):
    """Derivatives of states in one direction of the pivots.

    Attributes:
        position: (nv, n) of the joint coordinates.
        v: (nv, n) of the joint rates.
        a: (nv, n) of the joint accelerations.
        basis: (nb, n) of the basis.
        second: (nb, n) of the second derivative of the basis by time.
    """

    position: Array
    v: Array
    a: Array
    basis: ComplexArray
    second: ComplexArray

    @staticmethod
    def of(states: States, rates: Rates, by: Shift) -> Tangent:
        """Differentiate states in a direction of the pivots.

        Raises:
            PinpressError: redundant bearings cannot stay closed in this direction.
        """
        plane = states.plane
        loops = len(plane.loop_points)
        moved, rows = by.closure[:loops], plane.closure[:loops]
        opened = product(moved, states.at)
        position = states.solve(opened)
        turned = basis_velocity(plane, states.at, position)
        if plane.redundant:
            _refuse_contradiction(opened + product(rows, turned), by)
        still = np.zeros_like(position)
        v = states.solve(product(moved, rates.first) + product(rows, _first_turned(plane, states, rates, turned, still)))
        a = states.solve(product(moved, rates.second) + product(rows, _second_turned(plane, states, rates, turned, v, still)))
        return Tangent(position, v, a, turned, _second_turned(plane, states, rates, turned, v, a))


def _first_turned(plane: Plane, states: States, rates: Rates, turned: ComplexArray, v: Array) -> ComplexArray:
    """Derivative (nb, n) of the first derivative of the basis by time.

    Args:
        turned: (nb, n) derivative of the basis.
        v: (nv, n) derivative of the joint rates.
    """
    turning = len(plane.revolute)
    spin, spin_turned = plane.turn @ rates.v, plane.turn @ v
    result = np.zeros_like(turned)
    result[1 : 1 + turning] = 1j * (spin * turned[1 : 1 + turning] + spin_turned * states.at[1 : 1 + turning])
    for row, (joint, rotor) in enumerate(zip(plane.prismatic, plane.guide_rotors, strict=True), 1 + turning):
        result[row] = v[joint] * states.at[rotor]
        if rotor:
            result[row] += rates.v[joint] * turned[rotor]
            result[row] += 1j * (spin[rotor - 1] * turned[row] + spin_turned[rotor - 1] * states.at[row])
    return result


def _second_turned(plane: Plane, states: States, rates: Rates, turned: ComplexArray, v: Array, a: Array) -> ComplexArray:
    """Derivative (nb, n) of the second derivative of the basis by time.

    Args:
        turned: (nb, n) derivative of the basis.
        v: (nv, n) derivative of the joint rates.
        a: (nv, n) derivative of the joint accelerations.
    """
    turning = len(plane.revolute)
    spin, spin_turned = plane.turn @ rates.v, plane.turn @ v
    factor = 1j * (plane.turn @ rates.a) - spin * spin
    factor_turned = 1j * (plane.turn @ a) - 2 * spin * spin_turned
    result = np.zeros_like(turned)
    result[1 : 1 + turning] = factor * turned[1 : 1 + turning] + factor_turned * states.at[1 : 1 + turning]
    for row, (joint, rotor) in enumerate(zip(plane.prismatic, plane.guide_rotors, strict=True), 1 + turning):
        if not rotor:
            result[row] = a[joint]
            continue
        k = rotor - 1
        along = rates.a[joint] + 2j * spin[k] * rates.v[joint]
        along_turned = a[joint] + 2j * (spin_turned[k] * rates.v[joint] + spin[k] * v[joint])
        result[row] = along * turned[rotor] + along_turned * states.at[rotor]
        result[row] += factor[k] * turned[row] + factor_turned[k] * states.at[row]
    return result


def _refuse_contradiction(left: ComplexArray, by: Shift) -> None:
    """Raise PinpressError where loops open in spite of all joints: redundant equations of the linkage contradict each other."""
    worst = np.abs(left).max(axis=1)
    if worst.max() > CONTRADICTED * np.abs(by.closure).max():
        raise PinpressError("bearings that hold each other do not stay closed in this direction: move the pivots of all of them alike")
