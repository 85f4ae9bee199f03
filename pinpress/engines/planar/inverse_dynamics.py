"""Inverse dynamics of a planar linkage at all crank angles at once.

There are three steps: the efforts of the open tree's joints; the forces of loops and gear pairs (`statics`); the force and moment of every
joint. A lever arm r and a force f, both complex, make the moment Im(conj(r) f) about the normal. Forces and moments out of the plane are
computed in `out_of_plane`, and only where something acts there.

Signs: forces and moments of a joint are the action of parent on child, of a loop the action of link1 on link2.

The efforts follow from virtual work. Every point is a row of constants times the basis (see `model`), so that the inertia forces of all
links do work on the basis functions: the sum of m conj(c) c'' over all centres of mass c is one small matrix of constants times the second
derivative of the basis. A link's moment of inertia J adds J u'' for its rotor u: Im(conj(u) J u'') is J times the angular acceleration.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ...common.products import product
from ...common.quantities import Array, ComplexArray
from ..engine import LOOSEST, ClosedStates, other_linkage
from ..forces import AppliedConditions, AppliedForce, BearingLoads, FrictionLaw, Wrenches
from . import out_of_plane, statics
from .bodies import Bodies, OpenTree, forces_of_tree, work_of_tree
from .chain import Chain, ChainStates
from .chain_forces import ChainBodies, chain_forces
from .kinematics import basis_acceleration, basis_at, gaps, known_basis, known_jacobian
from .model import Plane, put_in_plane, put_normal, to_complex

OnChain = Callable[[Chain], ChainBodies]


def inverse_dynamics(
    bodies: Bodies, states: ClosedStates, conditions: AppliedConditions, bearings: bool, on_chain: OnChain | None = None
) -> Wrenches:
    """Driving torque and the wrenches of joints and loops; raises as `Engine.inverse_dynamics`.

    Args:
        bodies: inertial constants of the linkage.
        states: closed states with their basis.
        conditions: loads, friction and compliances.
        bearings: whether forces and moments of the bearings are found.
        on_chain: inertial constants of a chain of dyads, where the states are of one.
    """
    if (
        isinstance(states, ChainStates)
        and on_chain is not None
        and conditions.law is None
        and (conditions.compliance is None or (not bodies.plane.redundant and not out_of_plane.is_loaded(bodies, conditions.loads)))
    ):
        return chain_forces(on_chain(states.closure.chain), states, conditions.loads, bearings)
    return _by_blocks(bodies, states, conditions, bearings)


def _by_blocks(bodies: Bodies, states: ClosedStates, conditions: AppliedConditions, bearings: bool) -> Wrenches:
    """`inverse_dynamics`, in pieces, from the states alone."""
    plane, law, n = bodies.plane, conditions.law, states.v.shape[1]
    result = Wrenches.zeros(1, len(plane.offsets), len(plane.parents) + len(plane.loop_heights), n, bearings)
    speeds = None if law is None else law.moving(_bearing_speeds(plane, states.v))
    angle = states.closure.angle if isinstance(states, ChainStates) else states.position[plane.driver]
    for start in range(0, n, plane.piece):
        s = slice(start, start + plane.piece)
        piece, acting, filled = (states, conditions, result) if n <= plane.piece else (states.part(s), conditions.part(s), result.part(s))
        friction = None if law is None or speeds is None else FrictionState(law, speeds[:, s], angle[s])
        if bearings or friction is not None:
            _fill(bodies, piece, acting, friction, bearings, filled)
        else:
            _fill_torques(bodies, piece, acting.loads, filled)
    return result


def _bearing_speeds(plane: Plane, rates: Array) -> Array:
    """Speeds (bearings, n) of all bearings at joint rates (nv, n), those of loops about the normal."""
    return np.concatenate([rates, plane.incidence.T @ (plane.sense[:, None] * rates)])


def bearing_loads(bodies: Bodies, states: ClosedStates, loads: Sequence[AppliedForce], efforts: Array, rates: Array) -> BearingLoads:
    """See `Engine.bearing_loads`; the states have their basis."""
    plane, basis, n = bodies.plane, known_basis(states), states.v.shape[1]
    open_tree = _solve_open_tree(bodies, states, loads)
    system = _statics(bodies, states, open_tree, None)
    forces, coupling_multipliers = np.empty((len(efforts), n), complex), np.zeros((len(plane.offsets), n))
    statics.balance(system, open_tree.joint_efforts - _resisted(plane, efforts), coupling_multipliers, forces)
    slides = product(plane.directions, basis).conj()
    _push_by_teeth(plane, slides, coupling_multipliers, forces)
    radial = np.stack([forces.real, forces.imag, np.zeros(forces.shape)], axis=2)
    axial = out_of_plane.forces(bodies, loads, None, n) if out_of_plane.is_loaded(bodies, loads) else None
    for joint, direction in zip(plane.prismatic, slides, strict=True):
        radial[joint, :, 0], radial[joint, :, 1] = (direction * forces[joint]).imag, 0.0
        if axial is not None:
            radial[joint, :, 2] = axial[joint]
    return BearingLoads(_bearing_speeds(plane, rates), radial)


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


def _fill(
    bodies: Bodies,
    states: ClosedStates,
    conditions: AppliedConditions,
    friction: FrictionState | None,
    bearings: bool,
    result: Wrenches,
) -> None:
    """Fill in the result of a piece of the motion, by way of all bearing forces."""
    plane, basis, n, loads = bodies.plane, known_basis(states), states.v.shape[1], conditions.loads
    open_tree = _solve_open_tree(bodies, states, loads)
    flat = not out_of_plane.is_loaded(bodies, loads)
    axial = None if flat else out_of_plane.forces(bodies, loads, conditions.compliance, n)
    system = _statics(bodies, states, open_tree, conditions.compliance)
    friction_efforts, joint_efforts = None, open_tree.joint_efforts
    if friction is not None:
        friction_efforts = _friction(plane, system, friction, joint_efforts, basis, axial)
        result.friction[:] = -friction_efforts * friction.speeds
        joint_efforts -= _resisted(plane, friction_efforts)
    count, coupling_multipliers = len(plane.parents), result.coupling
    forces = np.empty((count + len(plane.loop_heights), n), complex)
    statics.balance(system, joint_efforts, coupling_multipliers, forces)
    result.torque[0] = joint_efforts[plane.driver]
    if bearings:
        put_in_plane(plane, forces, result.force)
        pins, torque = forces[count:], joint_efforts[plane.driver]
        for bearing, moment in _moments_about_normal(bodies, open_tree, pins, torque, coupling_multipliers, friction_efforts).items():
            put_normal(plane, moment, result.moment[bearing])
        if not flat:
            out_of_plane.add(bodies, lambda: basis, open_tree.second, pins, loads, axial, result.force, result.moment)
    statics.torques(plane, coupling_multipliers)


def _fill_torques(bodies: Bodies, states: ClosedStates, loads: Sequence[AppliedForce], result: Wrenches) -> None:
    """Fill in the torques of a piece of the motion without friction; they need no forces of the joints."""
    plane, basis = bodies.plane, known_basis(states)
    second = basis_acceleration(plane, basis, states.v, states.a)
    second[0] = 1.0
    joint_efforts = _efforts(bodies, basis, work_of_tree(bodies, second), loads)
    rows, factors = known_jacobian(plane, states)
    pins = np.empty((len(plane.loop_heights), basis.shape[1]), complex)
    statics.transmit(plane, rows, factors, joint_efforts, pins, result.coupling)
    result.torque[0] = joint_efforts[plane.driver]
    statics.torques(plane, result.coupling)


def _solve_open_tree(bodies: Bodies, states: ClosedStates, loads: Sequence[AppliedForce]) -> OpenTree:
    """Forces and efforts of the open tree."""
    plane, basis = bodies.plane, known_basis(states)
    second = basis_acceleration(plane, basis, states.v, states.a)
    second[0] = 1.0
    on_guides = 2 * len(bodies.on_guides)
    work, subtree_force, own = forces_of_tree(bodies, second)
    arms = product(bodies.arms, basis if bodies.arms_turn else basis[:, :1])
    for load in loads:
        if load.joint:
            subtree_force[plane.carriers(load.joint - 1)] -= to_complex(plane, load.force)
    efforts = _efforts(bodies, basis, work, loads)
    turning = _turning(bodies, arms[:on_guides], own, subtree_force, states.a, basis, loads) if on_guides else {}
    return OpenTree(second, subtree_force, efforts, turning, arms[on_guides:])


def _turning(
    bodies: Bodies,
    arms: ComplexArray,
    own: ComplexArray,
    subtree_force: ComplexArray,
    a: Array,
    basis: ComplexArray,
    loads: Sequence[AppliedForce],
) -> dict[int, Array]:
    """Moments (n,) about the normal that the prismatic joints would have to transmit, from the tips of the tree to them.

    Args:
        bodies: inertial constants of the linkage.
        arms: (2 k, n) of the k joints on guides the centres of mass from the joint, then its origin from that of its parent [m]; (2 k, 1)
            where they do not turn.
        own: (k, n) inertia forces less weights of their bodies [N].
        subtree_force: (nv, n) as in `OpenTree`.
        a: (nv, n) joint accelerations.
        basis: (nb, n) of the states.
        loads: forces on links.
    """
    plane, joints = bodies.plane, bodies.on_guides
    moments = (arms[: len(joints)].conj() * own).imag
    places = {joint: place for place, joint in enumerate(joints)}
    for joint, place in places.items():
        if plane.rotors[joint]:
            moments[place] += (bodies.inertia[[joint]] @ a)[0]
    for load in loads:
        joint = load.joint - 1
        if joint in places:
            arm = complex(*(plane.frames[joint] @ load.point)[:2]) * basis[plane.rotor(joint)]
            moments[places[joint]] -= (arm.conj() * to_complex(plane, load.force)).imag
    for joint, place in places.items():
        parent = places.get(plane.parents[joint])
        if parent is not None:
            moments[parent] += moments[place] + (arms[len(joints) + place].conj() * subtree_force[joint]).imag
    return {joint: moments[places[joint]] for joint in plane.prismatic}


def _statics(bodies: Bodies, states: ClosedStates, open_tree: OpenTree, compliance: Array | None) -> statics.Statics:
    """The equations of loops and gear pairs; ``compliance`` as in `AppliedConditions`."""
    plane, basis, (rows, factors) = bodies.plane, known_basis(states), known_jacobian(bodies.plane, states)
    return statics.build(plane, rows, factors, open_tree.subtree_force, bodies.minus_incidence, basis, compliance)


def _moments_about_normal(
    bodies: Bodies, open_tree: OpenTree, pins: ComplexArray, torque: Array, coupling_multipliers: Array, friction_efforts: Array | None
) -> dict[int, Array]:
    """Moments (n,) about the normal, by bearing, of all that transmit one: guides, the driver, geared joints, all with friction.

    Args:
        bodies: inertial constants of the linkage.
        open_tree: its forces with all loops open.
        pins: (nl, n) complex forces of the loops [N].
        torque: (n,) driving torque [N m].
        coupling_multipliers: (nc, n) multipliers of the couplings.
        friction_efforts: (bearings, n) efforts of friction, None for none.
    """
    plane, moments = bodies.plane, open_tree.turning
    for (j, k), arm in zip(bodies.guided, open_tree.guided, strict=True):
        moments[j] -= plane.loops_of_joint[j][k] * (arm.conj() * pins[k]).imag
    if plane.sense[plane.driver]:  # the force of a driver that slides is part of its bearing force
        moments[plane.driver] = plane.sense[plane.driver] * torque
    if bodies.geared:
        meshed = plane.coupled.T @ coupling_multipliers
        for j in bodies.geared:
            moments[j] = moments.get(j, 0.0) + plane.sense[j] * meshed[j]
    if friction_efforts is not None:
        count = len(plane.parents)
        of_loops = plane.incidence @ friction_efforts[count:]
        for j in range(count):
            by_friction = plane.sense[j] * friction_efforts[j] if plane.sense[j] else -of_loops[j]
            moments[j] = moments.get(j, 0.0) + by_friction
        moments |= dict(enumerate(friction_efforts[count:], count))
    return moments


def _friction(
    plane: Plane, system: statics.Statics, friction: FrictionState, joint_efforts: Array, basis: ComplexArray, axial: Array | None
) -> Array:
    """Efforts (bearings, n) of friction: those of joints are along their axes, those of loops about the normal."""
    count = len(plane.parents)
    bearings = np.empty((count + len(plane.loop_heights), joint_efforts.shape[1]), complex)
    coupling_multipliers = np.zeros((len(plane.offsets), joint_efforts.shape[1]))
    slides = product(plane.directions, basis).conj()

    def radial(friction_efforts: Array) -> Array:
        statics.balance(system, joint_efforts - _resisted(plane, friction_efforts), coupling_multipliers, bearings)
        _push_by_teeth(plane, slides, coupling_multipliers, bearings)
        sizes = np.abs(bearings)
        for joint, direction in zip(plane.prismatic, slides, strict=True):
            sizes[joint] = np.abs((direction * bearings[joint]).imag)
            if axial is not None:
                sizes[joint] = np.hypot(sizes[joint], axial[joint])
        return sizes

    return friction.law.efforts(friction.speeds, radial, lambda state: plane.coordinate.at(float(friction.angle[state])))


def _push_by_teeth(plane: Plane, slides: ComplexArray, coupling_multipliers: Array, bearings: ComplexArray) -> None:
    """Add the forces between teeth to those of the shafts' bearings, as `engines.racks` says; ``slides``: (np, n) conjugate directions of
    the prismatic joints."""
    for rack in plane.racks:
        push = plane.coupling_rows[rack.coupling][rack.slide] * coupling_multipliers[rack.coupling]
        bearings[rack.shaft] += push * slides[plane.prismatic.index(rack.slide)].conj()


def _resisted(plane: Plane, friction_efforts: Array) -> Array:
    """The part (nv, n) of the joints' efforts that friction efforts (bearings, n) supply."""
    count = len(plane.parents)
    return np.asarray(friction_efforts[:count] + plane.sense[:, None] * (plane.incidence @ friction_efforts[count:]))


def _efforts(bodies: Bodies, basis: ComplexArray, work: ComplexArray, loads: Sequence[AppliedForce]) -> Array:
    """Efforts (nv, n) that the joints would have to transmit with all loops open.

    Args:
        bodies: inertial constants of the linkage.
        basis: (nb, n) of the states.
        work: (nb - 1, n) of inertia and weights on every function of the basis but the first, see `Bodies.reduced`; that of loads is
            subtracted here.
        loads: forces on links.
    """
    plane, revolute = bodies.plane, len(bodies.plane.revolute)
    for load in loads:
        if load.joint:
            joint, force = load.joint - 1, to_complex(plane, load.force)
            point = plane.point(joint, complex(*(plane.frames[joint] @ load.point)[:2]))
            for k in np.flatnonzero(point[1:]):
                work[k] -= point[k + 1].conj() * force
    turned = 1 + (len(work) if any(plane.guide_rotors) else revolute)
    rotor_moments = (basis[1:turned].conj() * work[: turned - 1]).imag
    for row, rotor in enumerate(plane.guide_rotors, revolute):
        if rotor:
            rotor_moments[rotor - 1] += rotor_moments[row]
    efforts = np.asarray(plane.turn.T.dot(rotor_moments[:revolute]))
    for row, joint, rotor in plane.guides:
        efforts[joint] = (basis[rotor].conj() * work[row - 1]).real if rotor else work[row - 1].real
    return efforts
