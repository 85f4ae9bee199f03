"""Exact derivatives of a planar linkage's reactions by the positions of its pivots, at fixed crank angle, speed and acceleration.

The tangent of a force balance is a force balance. For every body, forces F at arms r from the origin of its joint,

    sum F = m a                     sum F' = (m a)'
    sum r x F + M = h    gives      sum r x F' + M' = h' - sum r' x F

with ' for the derivative in a direction of the pivots: the unknown derivatives are balanced by the same equations as the forces
(`plane_statics`), against other right-hand sides, in which the forces themselves are known. Inertias stay as they are in the frames of
their links. Complex numbers and signs as in `plane_dynamics`.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..common.arrays import Array, ComplexArray
from ..engines.constant_rows import product
from ..engines.planar import statics as plane_statics
from ..engines.planar.bodies import Bodies
from .geometry_shift import Shift
from .loads import Push
from .motion import Rates, States, Tangent


class Balanced(NamedTuple):
    """The states whose reactions are known.

    Attributes:
        bodies: inertial constants of the linkage. mass: (nv,) [kg]. forces: (bearings, n) complex. sides: the
            bodies that every loop joins, -1 for the frame.
    """

    states: States
    rates: Rates
    bodies: Bodies
    mass: Array
    forces: ComplexArray
    sides: Sequence[tuple[int, int]]


class ReactionTangent(NamedTuple):
    """Derivatives of reactions in one direction.

    Attributes:
        torque: (n,) of the driver, along its axis. forces: (bearings, n) complex, moments: (bearings, n) about the normal, both None where
            bearings share forces that rigid mechanics leaves open.
        shaking_force: (n,) complex. shaking_moment: (n,) about the world origin and the normal.
    """

    torque: Array
    forces: ComplexArray | None
    moments: Array | None
    shaking_force: ComplexArray
    shaking_moment: Array


def tangent(known: Balanced, moved: Tangent, by: Shift, pushes: Sequence[Push]) -> ReactionTangent:
    """Derivatives of reactions, from those of the states and what the direction adds to the rows; ``pushes``: loads on moving links."""
    plane, at, bodies = known.states.plane, known.states.at, known.bodies
    count = len(plane.parents)
    origins, centers = product(plane.origins, at), product(plane.centers, at)
    origins_turned = product(plane.origins, moved.basis) + product(by.origins, at)
    centers_turned = product(plane.centers, moved.basis)
    second = known.rates.second.copy()
    second[0] = 1.0  # so that the first column of the rows is the weight
    own = product(bodies.forces[:count], second)
    own_turned = product(bodies.forces[:count], moved.second) + known.mass[:, None] * product(by.origins, known.rates.second)
    spin = bodies.inertia @ moved.a

    moment = _cross(centers_turned, own) + _cross(centers, own_turned) + spin
    _add_bearings(known, moved, by, origins_turned, moment)
    carried = plane.carried @ own_turned
    shaking_force = -own_turned.sum(axis=0)
    shaking_moment = -(_cross(origins_turned + centers_turned, own) + _cross(origins + centers, own_turned) + spin).sum(axis=0)
    for push in pushes:
        arm, arm_turned = (push.arm * rotor[plane.rotor(push.body)] for rotor in (at, moved.basis))
        moment[push.body] -= _cross(arm_turned, push.force) + _cross(arm, push.turned)
        carried[plane.carriers(push.body)] -= push.turned
        if not push.braced:
            shaking_force += push.turned
            shaking_moment += _cross(origins_turned[push.body] + arm_turned, push.force)
            shaking_moment += _cross(origins[push.body] + arm, push.turned)
    torque, forces, moments = _balanced(known, moved, origins, carried, moment)
    return ReactionTangent(torque, forces, moments, shaking_force, shaking_moment)


def _add_bearings(known: Balanced, moved: Tangent, by: Shift, origins_turned: ComplexArray, moment: Array) -> None:
    """Add to every body's moment what the known forces of its bearings do at arms that change; its own joint's has none."""
    plane, at = known.states.plane, known.states.at
    count, loops = len(plane.parents), len(plane.loop_points)
    for joint, parent in enumerate(plane.parents):
        if parent >= 0:
            moment[parent] += _cross(origins_turned[joint] - origins_turned[parent], known.forces[joint])
    first = product(plane.loop_points, moved.basis) + product(by.loop_points, at)
    second = first + product(plane.closure[:loops], moved.basis) + product(by.closure[:loops], at)
    for k, (body1, body2) in enumerate(known.sides):
        if body1 >= 0:
            moment[body1] += _cross(first[k] - origins_turned[body1], known.forces[count + k])
        if body2 >= 0:
            moment[body2] -= _cross(second[k] - origins_turned[body2], known.forces[count + k])


def _balanced(
    known: Balanced, moved: Tangent, origins: ComplexArray, carried: ComplexArray, moment: Array
) -> tuple[Array, ComplexArray | None, Array | None]:
    """Torque, forces and moments of the bearings that balance forces (nv, n), summed over all that hangs on a joint, and moments (nv, n) of
    the bodies: as `plane_dynamics` does, from the tips of the tree to the frame."""
    plane, at, bodies = known.states.plane, known.states.at, known.bodies
    count = len(plane.parents)
    for joint in bodies.inner:
        parent = plane.parents[joint]
        moment[parent] += moment[joint] + _cross(origins[joint] - origins[parent], carried[joint])
    passive = plane.sense[:, None] * moment
    slides, slides_turned = product(plane.directions, at), product(plane.directions, moved.basis)
    for joint, slide, turned in zip(plane.prismatic, slides, slides_turned, strict=True):
        passive[joint] = (slide.conj() * carried[joint]).real + (turned.conj() * known.forces[joint]).real
    closure, gears = product(bodies.closure, at), np.zeros((len(plane.offsets), at.shape[1]))
    bearings = np.empty((count + len(plane.loop_points), at.shape[1]), complex)
    if plane.redundant:
        plane_statics.transmit(plane, closure, passive, bearings[count:], gears)
        return passive[plane.driver], None, None
    plane_statics.balance(plane_statics.build(plane, closure, carried, bodies.uncrossed, at, None), passive, gears, bearings)
    moments = np.zeros(bearings.shape)
    points = product(plane.loop_points, at)
    for joint in plane.prismatic:
        moments[joint] = moment[joint] - sum(
            plane.crossed[joint, k] * _cross(points[k] - origins[joint], bearings[count + k]) for k in np.flatnonzero(plane.crossed[joint])
        )
    moments[plane.driver] = plane.sense[plane.driver] * passive[plane.driver]
    for joint in bodies.geared:
        moments[joint] += plane.sense[joint] * (plane.coupled[:, joint] @ gears)
    return passive[plane.driver], bearings, moments


def _cross(arm: ComplexArray, force: ComplexArray) -> Array:
    """Moment about the normal."""
    return np.asarray((arm.conj() * force).imag)
