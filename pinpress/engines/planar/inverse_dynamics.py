"""Inverse dynamics of a planar linkage at all crank angles at once.

Newton-Euler from the tips of the tree to the frame, the loops open; then the forces of loops and gear pairs (`statics`); then every
joint's force and moment. A lever arm r and a force f, both complex, make the moment Im(conj(r) f) about the normal. What acts out of the
plane is computed in `out_of_plane`, and only where there is something.

Signs: forces and moments of a joint are the action of parent on child, of a loop the action of link1 on link2.

Where few bearing forces are wanted, the efforts of the open tree's joints come from virtual work, without the forces that pass from link to
link. Every point is a row of constants times the basis (see `model`), so the inertia forces of all links do work on the basis functions:
m conj(c) c'' summed over all centres of mass c is one small matrix of constants times the second derivative of the basis. Loops and gear
pairs then act as in `statics`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common.errors import AssemblyError
from ...common.quantities import Array, ComplexArray
from ..engine import PIECE, ClosedStates
from ..forces import AppliedConditions, AppliedForce, FrictionLaw, Wrenches
from ..joints import product
from . import out_of_plane, statics
from .bodies import Bodies, OpenTree
from .kinematics import basis, basis_acceleration, gaps, known_basis
from .model import Plane, flat, put, put_normal

LOOSEST = 1e-6  # gap, in lengths of the linkage, beyond which a motion is another linkage's


def inverse_dynamics(bodies: Bodies, states: ClosedStates, under: AppliedConditions, wanted: Sequence[int]) -> Wrenches:
    """Driving torque and the wrenches of joints and loops.

    Args:
        bodies: of the linkage.
        states: with their basis.
        under: what acts on it.
        wanted: the bearings whose wrenches are wanted, rising. Friction, and what is shared, needs all of them first.
    """
    plane, law, n = bodies.plane, under.law, states.v.shape[1]
    result = Wrenches.zeros(1, len(plane.offsets), len(plane.parents) + len(plane.loop_heights), n, len(wanted))
    some = len(wanted) < len(result.friction)
    few = some and law is None and _needs_torque_alone(plane, wanted, under.gears)
    speeds = None if law is None else law.moving(np.concatenate([states.v, plane.crossed.T @ (plane.sense[:, None] * states.v)]))
    for start in range(0, n, PIECE):
        s = slice(start, start + PIECE)
        piece, conditions, filled = (states, under, result) if n <= PIECE else (states.part(s), under.part(s), result.part(s))
        rubbing = None if law is None or speeds is None else Rubbing(law, speeds[:, s], states.position[plane.driver, s])
        if few and not (wanted and _across(bodies, conditions.loads)):
            _fill_torque_alone(bodies, piece, conditions.loads, wanted, filled)
        else:
            _piece(bodies, piece, conditions, rubbing, wanted, filled)
    return result


class Rubbing(NamedTuple):
    """Friction of a piece: the law, the speeds (bearings, n) and the crank angles (n,)."""

    law: FrictionLaw
    speeds: Array
    angle: Array


def closed_basis(plane: Plane, position: Array) -> ComplexArray:
    """The basis (nb, n) of joint coordinates (nv, n).

    Raises:
        AssemblyError: they do not close the loops of this linkage.
    """
    at = basis(plane, position)
    widest = gaps(plane, position, at)
    if not widest.max() <= LOOSEST * plane.size:
        worst = int(widest.argmax())
        angle = float(position[plane.driver, worst])
        raise AssemblyError("the motion leaves the loops of this linkage open: it is another one's", angle, float(widest[worst]), 0)
    return at


def _piece(
    bodies: Bodies, states: ClosedStates, under: AppliedConditions, rubbing: Rubbing | None, wanted: Sequence[int], result: Wrenches
) -> None:
    """Fill in the result of a piece of the motion."""
    plane, at, n = bodies.plane, known_basis(states), states.v.shape[1]
    tree = _open_tree(bodies, states, under.loads)
    across = out_of_plane.forces(bodies, under.loads, under.compliance, n) if _across(bodies, under.loads) else None
    system = statics.build(plane, tree.closure, tree.subtree_force, bodies.uncrossed, at, under.compliance)
    efforts, passive = None, tree.passive
    if rubbing is not None:
        efforts = _friction(plane, system, rubbing, passive, at, across)
        result.friction[:] = -efforts * rubbing.speeds
        passive -= _resisted(plane, efforts)
    count, gears = len(plane.parents), result.coupling
    bearings = np.empty((count + len(plane.loop_heights), n), complex)
    statics.balance(system, passive, gears, bearings)
    result.torque[0] = passive[plane.driver]
    if wanted:
        put(plane, bearings if len(wanted) == len(bearings) else bearings[list(wanted)], result.force)
        places = {bearing: place for place, bearing in enumerate(wanted)}
        for bearing, moment in _about_normal(bodies, tree, bearings[count:], passive[plane.driver], gears, efforts).items():
            if bearing in places:
                put_normal(plane, moment, result.moment[places[bearing]])
        if across is not None:
            out_of_plane.add(bodies, states, tree, bearings[count:], under.loads, across, wanted, result)
    statics.torques(plane, gears)


def _across(bodies: Bodies, loads: Sequence[AppliedForce]) -> bool:
    """Whether anything acts out of the plane."""
    return not (bodies.flat and all(out_of_plane.is_flat(bodies.plane, load) for load in loads))


def _open_tree(bodies: Bodies, states: ClosedStates, loads: Sequence[AppliedForce]) -> OpenTree:
    """Newton's and Euler's equations from the tips to the frame."""
    plane, at = bodies.plane, known_basis(states)
    count = len(plane.parents)
    second = basis_acceleration(plane, at, states.v, states.a)
    second[0] = 1.0
    forces = product(bodies.forces, second)
    own, subtree_force = forces[:count], forces[count:]
    arms = product(bodies.arms, at)
    closure, row = arms[count : count + plane.closure.shape[0]], count + plane.closure.shape[0]

    moment = (arms[:count].conj() * own).imag
    moment += bodies.inertia @ states.a
    for load in loads:
        if load.joint:
            _take_load(plane, at, subtree_force, moment, load)
    for j in bodies.inner:
        moment[plane.parents[j]] += moment[j] + (arms[row].conj() * subtree_force[j]).imag
        row += 1
    turning = {j: moment[j].copy() for j in plane.prismatic}
    passive = moment  # from here on: efforts
    for j in plane.prismatic:
        passive[j] = (arms[row].conj() * subtree_force[j]).real
        row += 1
    for j in plane.revolute:
        if plane.sense[j] < 0:
            np.negative(passive[j], out=passive[j])
    return OpenTree(own, subtree_force, arms[:count], closure, passive, turning, arms[row:])


def _about_normal(
    bodies: Bodies, tree: OpenTree, pins: ComplexArray, torque: Array, gears: Array, efforts: Array | None
) -> dict[int, Array]:
    """Moments (n,) about the normal of the bearings that transmit one: guides, the driver, geared joints, all that have friction.

    ``torque`` (n,) of the driver; ``gears`` (nc, n) multipliers of the couplings; ``efforts`` (bearings, n) of friction.
    """
    plane, moments = bodies.plane, tree.turning
    for (j, k), arm in zip(bodies.guided, tree.guided, strict=True):
        moments[j] -= plane.round_loops[j][k] * (arm.conj() * pins[k]).imag
    moments[plane.driver] = plane.sense[plane.driver] * torque
    if bodies.geared:
        meshed = plane.coupled.T @ gears
        for j in bodies.geared:
            moments[j] = moments.get(j, 0.0) + plane.sense[j] * meshed[j]
    if efforts is not None:
        count = len(plane.parents)
        of_loops = plane.crossed @ efforts[count:]
        for j in range(count):
            rubbing = plane.sense[j] * efforts[j] if plane.sense[j] else -of_loops[j]
            moments[j] = moments.get(j, 0.0) + rubbing
        moments |= dict(enumerate(efforts[count:], count))
    return moments


def _take_load(plane: Plane, at: ComplexArray, subtree_force: ComplexArray, moment: Array, load: AppliedForce) -> None:
    """Relieve the joints that carry the loaded link; its own joint of the moment too, the others get theirs in the recursion."""
    joint = load.joint - 1
    force = flat(plane, load.force)
    arm = complex(*(plane.frames[joint] @ load.point)[:2]) * at[plane.rotor(joint)]
    moment[joint] -= (arm.conj() * force).imag
    subtree_force[plane.carriers(joint)] -= force


def _friction(plane: Plane, system: statics.Statics, rubbing: Rubbing, passive: Array, at: ComplexArray, across: Array | None) -> Array:
    """Efforts (bearings, n) of friction: of joints along their axes, of loops about the normal."""
    count = len(plane.parents)
    bearings = np.empty((count + len(plane.loop_heights), passive.shape[1]), complex)
    gears = np.zeros((len(plane.offsets), passive.shape[1]))
    slides = product(plane.directions, at).conj()

    def radial(efforts: Array) -> Array:
        statics.balance(system, passive - _resisted(plane, efforts), gears, bearings)
        sizes = np.abs(bearings)
        for joint, direction in zip(plane.prismatic, slides, strict=True):
            sizes[joint] = np.abs((direction * bearings[joint]).imag)
            if across is not None:
                sizes[joint] = np.hypot(sizes[joint], across[joint])
        return sizes

    return rubbing.law.efforts(rubbing.speeds, radial, rubbing.angle)


def _resisted(plane: Plane, efforts: Array) -> Array:
    """What friction (bearings, n) takes over of the efforts (nv, n) of the joints."""
    count = len(plane.parents)
    return np.asarray(efforts[:count] + plane.sense[:, None] * (plane.crossed @ efforts[count:]))


def _needs_torque_alone(plane: Plane, wanted: Sequence[int], gears: bool) -> bool:
    """Whether ``wanted`` bearings, and the torques of ``gears``, can be had without the others, where nothing rubs and nothing leaves the
    plane.

    A guide's moment is that of all that hangs on it. What is shared among bearings and gears depends on all of them; the driving torque
    does not depend on how.
    """
    if any(j in plane.prismatic for j in wanted):
        return False
    return not plane.redundant or not (wanted or (gears and len(plane.offsets)))


def _fill_torque_alone(
    bodies: Bodies, states: ClosedStates, loads: Sequence[AppliedForce], wanted: Sequence[int], result: Wrenches
) -> None:
    """Fill in a result with bearings that `_needs_torque_alone` allows. Arguments as of `inverse_dynamics`."""
    plane, at = bodies.plane, known_basis(states)
    second = basis_acceleration(plane, at, states.v, states.a)
    second[0] = 1.0
    passive = _efforts(bodies, at, states.a, second, loads)
    pins = np.empty((len(plane.loop_heights), at.shape[1]), complex)
    statics.transmit(plane, product(bodies.closure, at), passive, pins, result.coupling)
    result.torque[0] = passive[plane.driver]
    if wanted:
        put(plane, _forces(bodies, second, loads, pins, wanted), result.force)
        for place, moment in _moments(bodies, wanted, result).items():
            put_normal(plane, moment, result.moment[place])
    statics.torques(plane, result.coupling)


def _efforts(bodies: Bodies, at: ComplexArray, a: Array, second: ComplexArray, loads: Sequence[AppliedForce]) -> Array:
    """Efforts (nv, n) that the joints would have to transmit with all loops open."""
    plane = bodies.plane
    work: ComplexArray = product(bodies.reduced, second)
    for load in loads:
        if load.joint:
            joint, force = load.joint - 1, flat(plane, load.force)
            point = plane.point(joint, complex(*(plane.frames[joint] @ load.point)[:2]))
            for k in np.flatnonzero(point[1:]):
                work[k] -= point[k + 1].conj() * force
    turning = len(plane.revolute)
    turned = (at[1:].conj() * work).imag
    for row, rotor in enumerate(plane.guide_rotors, turning):
        if rotor:
            turned[rotor - 1] += turned[row]
    efforts: Array = plane.turn.T @ turned[:turning] + bodies.spins @ a
    for row, (joint, rotor) in enumerate(zip(plane.prismatic, plane.guide_rotors, strict=True), turning):
        efforts[joint] = (at[rotor].conj() * work[row]).real if rotor else work[row].real
    return efforts


def _forces(bodies: Bodies, second: ComplexArray, loads: Sequence[AppliedForce], pins: ComplexArray, wanted: Sequence[int]) -> ComplexArray:
    """Complex forces (wanted, n)."""
    plane = bodies.plane
    count = len(plane.parents)
    joints = [j for j in wanted if j < count]
    forces = np.empty((len(wanted), pins.shape[1]), complex)
    forces[len(joints) :] = pins[[k - count for k in wanted if k >= count]]
    if joints:
        subtree_force = product(bodies.forces[[count + j for j in joints]], second)
        for load in loads:
            if load.joint:
                subtree_force[[place for place, j in enumerate(joints) if j in plane.carriers(load.joint - 1)]] -= flat(plane, load.force)
        np.add(product(bodies.uncrossed[joints], pins), subtree_force, out=forces[: len(joints)])
    return forces


def _moments(bodies: Bodies, wanted: Sequence[int], result: Wrenches) -> dict[int, Array]:
    """Those about the normal that are not zero, (n,) each, by place among the wanted; ``result`` has multipliers of the gear pairs."""
    plane, moments = bodies.plane, {}
    meshed = plane.coupled.T @ result.coupling if any(j in bodies.geared for j in wanted) else result.coupling
    for place, j in enumerate(wanted):
        if j == plane.driver:
            moments[place] = plane.sense[j] * result.torque[0]
        if j in bodies.geared:
            moments[place] = moments.get(place, 0.0) + plane.sense[j] * meshed[j]
    return moments
