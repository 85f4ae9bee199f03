"""Driving torque of a planar linkage at all crank angles at once, and the forces of few bearings, without what the others carry.

The efforts of the open tree's joints come from virtual work, without the forces that pass from link to link. Every point is a row of
constants times the basis (see `model`), so the inertia forces of all links do work on the basis functions: m conj(c) c'' summed over all
centres of mass c is one small matrix of constants times the second derivative of the basis. Loops and gear pairs then act as in
`statics`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...common.arrays import Array, ComplexArray
from ..constant_rows import product
from ..engine import ClosedStates
from ..forces import AppliedForce, Wrenches
from . import statics
from .bodies import Bodies
from .kinematics import basis_acceleration, known_basis
from .model import Plane, flat, put, put_normal


def suffices(plane: Plane, wanted: Sequence[int], gears: bool) -> bool:
    """Whether ``wanted`` bearings, and the torques of ``gears``, can be had without the others, where nothing rubs and nothing leaves the
    plane.

    A guide's moment is that of all that hangs on it. What is shared among bearings and gears depends on all of them; the driving torque
    does not depend on how.
    """
    if any(j in plane.prismatic for j in wanted):
        return False
    return not plane.redundant or not (wanted or (gears and len(plane.offsets)))


def fill(bodies: Bodies, states: ClosedStates, loads: Sequence[AppliedForce], wanted: Sequence[int], result: Wrenches) -> None:
    """Fill in a result with bearings that `suffices` allows. Arguments as of `inverse_dynamics`."""
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
