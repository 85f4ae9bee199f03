"""Inverse dynamics of a planar linkage at all crank angles at once: forces of the open tree, their balance, friction and moments.

Forces and moments out of the plane are computed in `out_of_plane`, and only where something acts there.

Signs: forces and moments of a joint are the action of parent on child, of a loop the action of link1 on link2.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...common.products import product
from ...common.quantities import Array, ComplexArray
from ..engine import LOOSEST, ClosedStates, other_linkage
from ..friction import FrictionLaw
from ..wrenches import AppliedConditions, BearingLoads, Idle, Wrenches
from . import out_of_plane
from .balance import (
    IdleForces,
    OpenTree,
    Statics,
    add_idle_forces,
    balance,
    direction_of,
    efforts_by_rows,
    idle_forces,
    open_tree,
)
from .equations import Configurations, configurations_at
from .guide_moments import add_moments_of_guides
from .kinematics import basis_acceleration, basis_at, gaps, known_basis
from .model import Plane, put_normal


class Moving(NamedTuple):
    """A linkage in motion, over a piece of it.

    Attributes:
        configurations: the configurations.
        second: (rows, n) conjugate second derivatives of the functions, 1 in the rows of ones.
        basis: (nb, n) the basis.
    """

    configurations: Configurations
    second: ComplexArray
    basis: ComplexArray


def inverse_dynamics(statics: Statics, states: ClosedStates, conditions: AppliedConditions, bearings: bool) -> Wrenches:
    """Driving torque, and with ``bearings`` the wrenches of joints and loops; raises as `Engine.inverse_dynamics`.

    Args:
        statics: constants of the linkage.
        states: closed states with their basis.
        conditions: loads, friction and compliances.
        bearings: whether to find forces and moments of the bearings, too.
    """
    plane, law = statics.plane, conditions.law
    n = states.v.shape[1]
    # In memory the states are next to each other: components along one axis are filled in, and read, at once.
    force, moment = (make((3, statics.bearing_count if bearings else 0, n)).transpose(1, 2, 0) for make in (np.empty, np.zeros))
    result = Wrenches(np.empty((1, n)), np.zeros((len(plane.offsets), n)), np.zeros((statics.bearing_count, n)), force, moment)
    speeds = None if law is None else law.moving(_bearing_speeds(plane, states.v))
    for start in range(0, n, statics.piece):
        s = slice(start, min(start + statics.piece, n))
        part, acting, filled = (states, conditions, result) if n <= statics.piece else (states.part(s), conditions.part(s), result.part(s))
        friction = None if law is None or speeds is None else FrictionState(law, speeds[:, s], states.position[plane.driver, s])
        _fill(statics, _moving(statics, part), acting, friction, bearings, filled)
    return result


def _moving(statics: Statics, states: ClosedStates) -> Moving:
    plane, basis = statics.plane, known_basis(states)
    second = basis_acceleration(plane, basis, states.v, states.a)
    second[0] = 1.0
    second = second.take(statics.functions.places, axis=0)
    return Moving(configurations_at(statics.equations, basis, states.position), np.conjugate(second, second), basis)


def _fill(
    statics: Statics,
    moving: Moving,
    conditions: AppliedConditions,
    friction: FrictionState | None,
    bearings: bool,
    result: Wrenches,
) -> None:
    """Fill in the result of a piece of the motion."""
    plane, bodies, loads = statics.plane, statics.bodies, conditions.loads
    configurations, multipliers = moving.configurations, result.relations
    tree = open_tree(statics, configurations, moving.second, loads)
    needed = bearings or friction is not None
    flat = not needed or not out_of_plane.is_loaded(bodies, loads)
    axial = None if flat else out_of_plane.forces(bodies, loads, conditions.compliance, moving.second.shape[1])
    idle = idle_forces(statics, configurations) if needed else None
    balanced = Balanced(statics, configurations, idle, conditions.compliance, conditions.efforts)
    friction_efforts = conditions.friction
    if friction is not None:
        friction_efforts = _friction(balanced, friction, tree, axial)
        result.friction[:] = -friction_efforts * friction.speeds
    torque = balanced.torque(tree, multipliers, friction_efforts)
    result.torque[0] = torque
    if bearings:
        forces = tree.array[statics.functions.count :]
        _put_forces(plane, forces, result.force)
        moments = _moments_about_normal(statics, multipliers, torque, friction_efforts, conditions.efforts)
        add_moments_of_guides(
            plane, statics.guided, configurations.functions, configurations.ways, moving.second, tree.forces, loads, moments
        )
        for bearing, values in moments.items():
            put_normal(plane, values, result.moment[bearing])
        if not flat:
            pins = forces[len(plane.parents) :].conj()
            second = moving.second.take(statics.functions.order, axis=0)
            np.conjugate(second, second)
            out_of_plane.add(bodies, moving.basis, second, pins, loads, axial, result.force, result.moment)
    if len(multipliers):
        multipliers *= plane.relation_units[:, None]  # so that they are efforts on the joints that the relations determine


class Balanced(NamedTuple):
    """What balances forces at n configurations, also with friction.

    Attributes:
        statics: constants of the linkage.
        configurations: the configurations.
        idle: their idle forces, which are shared; None if there are none, or no bearings are asked for.
        compliance: (bearings,) as in `AppliedConditions`.
        efforts: (nv, n) as in `AppliedConditions`.
    """

    statics: Statics
    configurations: Configurations
    idle: IdleForces | None
    compliance: Array | None
    efforts: Array | None = None

    def torque(self, tree: OpenTree, multipliers: Array, bearing_efforts: Array | None) -> Array:
        """Fill in the forces of the tree and the ``multipliers`` (relations, n), and return the driving torque (n,).

        Efforts (bearings, n) of friction, and those in the joints, supply a part of what the joints need.
        """
        supplied, plane = self.efforts, self.statics.plane
        if bearing_efforts is not None:
            count = len(plane.parents)
            of_joints = bearing_efforts[:count] + plane.sense[:, None] * product(plane.incidence, bearing_efforts[count:])
            supplied = of_joints if supplied is None else supplied + of_joints
        efforts = None if supplied is None else efforts_by_rows(self.statics, -supplied)
        torque = balance(self.statics, self.configurations, tree, multipliers, efforts)
        if self.idle is not None:
            add_idle_forces(self.idle, tree.array[self.statics.functions.count :], multipliers, self.compliance)
        return torque

    def pressing(self, tree: OpenTree, bearing_efforts: Array | None) -> tuple[ComplexArray, Array]:
        """Conjugate forces (bearings, n) with these efforts of friction, and the multipliers (relations, n); the tree is kept."""
        count, plane = self.statics.functions.count, self.statics.plane
        copied = OpenTree.of(tree.array.copy(), count)
        multipliers = np.zeros((len(plane.offsets), tree.array.shape[1]))
        self.torque(copied, multipliers, bearing_efforts)
        return copied.array[count:], multipliers


class FrictionState(NamedTuple):
    """Friction over a piece of the motion.

    Attributes:
        law: of the bearings.
        speeds: (bearings, n) speeds of the bearings [rad/s or m/s].
        angle: (n,) crank angles [rad], of a driver that slides its positions [m].
    """

    law: FrictionLaw
    speeds: Array
    angle: Array


def _friction(balanced: Balanced, friction: FrictionState, tree: OpenTree, axial: Array | None) -> Array:
    """Efforts (bearings, n) of friction: those of joints are along their axes, those of loops about the normal."""
    plane = balanced.statics.plane
    slides = {joint: direction_of(balanced.statics, balanced.configurations, joint) for joint in plane.prismatic}

    def radial(friction_efforts: Array) -> Array:
        forces, _ = balanced.pressing(tree, friction_efforts)
        sizes = np.abs(forces)
        for joint, direction in slides.items():
            sizes[joint] = np.abs((direction * forces[joint]).imag)
            if axial is not None:
                sizes[joint] = np.hypot(sizes[joint], axial[joint])
        return sizes

    return friction.law.efforts(friction.speeds, radial, lambda state: plane.coordinate.at(float(friction.angle[state])))


def bearing_loads(statics: Statics, states: ClosedStates, conditions: AppliedConditions, rates: Array) -> BearingLoads:
    """See `Engine.bearing_loads`; the states have their basis."""
    plane, bodies, n = statics.plane, statics.bodies, states.v.shape[1]
    loads, compliance = conditions.loads, conditions.compliance
    moving = _moving(statics, states)
    balanced = Balanced(statics, moving.configurations, idle_forces(statics, moving.configurations), compliance, conditions.efforts)
    forces, multipliers = balanced.pressing(open_tree(statics, moving.configurations, moving.second, loads), conditions.friction)
    radial = np.stack([forces.real, -forces.imag, np.zeros(forces.shape)], axis=2)
    axial = out_of_plane.forces(bodies, loads, compliance, n) if out_of_plane.is_loaded(bodies, loads) else None
    for joint in plane.prismatic:
        radial[joint, :, 0], radial[joint, :, 1] = -(direction_of(statics, moving.configurations, joint) * forces[joint]).imag, 0.0
        if axial is not None:
            radial[joint, :, 2] = axial[joint]
    return BearingLoads(_bearing_speeds(plane, rates), radial, plane.relation_units[:, None] * multipliers)


def idle_wrenches(statics: Statics, states: ClosedStates) -> Idle:
    """See `Engine.idle`; the states have their basis."""
    plane, moving = statics.plane, _moving(statics, states)
    found, n = idle_forces(statics, moving.configurations), states.v.shape[1]
    if found is None:
        return Idle(np.zeros((0, len(plane.offsets), n)), *np.zeros((2, 0, statics.bearing_count, n, 3)))
    force, moment = np.zeros((2, *found.bearings.shape, 3))
    functions, still, without = moving.configurations, np.zeros_like(moving.second), np.zeros(n)
    for k, (forces, multipliers) in enumerate(zip(found.bearings, found.multipliers, strict=True)):
        _put_forces(plane, forces, force[k])
        moments = _moments_about_normal(statics, multipliers, without, None, None)
        add_moments_of_guides(plane, statics.guided, functions.functions, functions.ways, still, list(forces), (), moments)
        for bearing, values in moments.items():
            put_normal(plane, values, moment[k, bearing])
        out_of_plane.add_idle(statics.bodies, forces[len(plane.parents) :].conj(), moment[k])
    return Idle(plane.relation_units[:, None] * found.multipliers, force, moment)


def _bearing_speeds(plane: Plane, rates: Array) -> Array:
    """Speeds (bearings, n) of all bearings at joint rates (nv, n), those of loops about the normal."""
    return np.concatenate([rates, plane.incidence.T @ (plane.sense[:, None] * rates)])


def closed_basis(plane: Plane, position: Array) -> ComplexArray:
    """The basis (nb, n) of joint coordinates (nv, n).

    Raises:
        AssemblyError: the coordinates do not close the loops of this linkage.
    """
    basis = basis_at(plane, position)
    widest = gaps(plane, position, basis)
    if not widest.max() <= LOOSEST * plane.size:
        worst = int(widest.argmax())
        angle = float(position[plane.driver, worst])
        raise other_linkage(angle, float(widest[worst]), plane.coordinate.at(angle))
    return basis


def _moments_about_normal(
    statics: Statics, multipliers: Array, torque: Array, friction_efforts: Array | None, joint_efforts: Array | None
) -> dict[int, Any]:
    """Moments (n,) about the normal, by bearing, of all that transmit one but guides: the driver, geared joints, all with friction, springs
    or rotors.

    Args:
        statics: constants of the linkage.
        multipliers: (nr, n) multipliers of the relations.
        torque: (n,) driving torque [N m].
        friction_efforts: (bearings, n) efforts of friction, None for none.
        joint_efforts: (nv, n) efforts in the joints, None for none.
    """
    plane = statics.plane
    moments: dict[int, Any] = {}
    if plane.sense[plane.driver]:  # the force of a driver that slides is part of its bearing force
        moments[plane.driver] = plane.sense[plane.driver] * torque
    for relation, coefficients in enumerate(plane.relation_rows):
        for joint, by in coefficients.items():
            if plane.sense[joint]:
                moments[joint] = moments.get(joint, 0.0) + plane.sense[joint] * by * multipliers[relation]
    if friction_efforts is not None:
        for bearing, effort in enumerate(friction_efforts):
            if bearing >= len(plane.parents):
                moments[bearing] = effort
            elif plane.sense[bearing]:
                moments[bearing] = moments.get(bearing, 0.0) + plane.sense[bearing] * effort
    for joint, effort in enumerate(() if joint_efforts is None else joint_efforts):
        if plane.sense[joint]:
            moments[joint] = moments.get(joint, 0.0) + plane.sense[joint] * effort
    return moments


def _put_forces(plane: Plane, forces: ComplexArray, out: Array) -> None:
    """Fill ``out`` (k, n, 3) with forces whose conjugates (k, n) are given."""
    for i, first, second, _ in plane.world_components:
        if not (first or second):
            out[..., i] = 0.0
        if first == 1.0:  # most presses stand in a coordinate plane
            out[..., i] = forces.real
        elif first:
            np.multiply(forces.real, first, out=out[..., i])
        if second and first:
            out[..., i] -= second * forces.imag
        elif second == 1.0:
            np.negative(forces.imag, out=out[..., i])
        elif second == -1.0:
            out[..., i] = forces.imag
        elif second:
            np.multiply(forces.imag, -second, out=out[..., i])
