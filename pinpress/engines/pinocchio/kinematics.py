"""Motions of points, energies and powers by Pinocchio, one configuration at a time."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from ...common.quantities import Array
from ..engine import ClosedStates, EnergyRates, PowerBalance
from ..rank import rank
from ..structure import Structure, configuration, data_of
from ..wrenches import AppliedForce
from .equations import OneConfiguration, cross


def redundant(structure: Structure, x: Array) -> bool:
    """Whether some of the equations are redundant at joint coordinates (nv,)."""
    rows = OneConfiguration(structure).at(x)
    return rank(rows.columns) < len(rows.gaps)


def point_motion(structure: Structure, states: ClosedStates, joint: int, point: Array) -> tuple[Array, Array]:
    """See `Engine`."""
    position, velocity = np.empty((states.v.shape[1], 3)), np.empty((states.v.shape[1], 3))
    data, q = data_of(structure.model), configuration(structure.slots, states.position)
    for i in range(states.v.shape[1]):
        pin.forwardKinematics(structure.model, data, np.ascontiguousarray(q[:, i]), states.v[:, i].copy())
        speed = data.v[joint]
        position[i] = data.oMi[joint].act(point)
        velocity[i] = data.oMi[joint].rotation @ (speed.linear + np.cross(speed.angular, point))
    return position, velocity


def point_accelerations(structure: Structure, states: ClosedStates, joint: int, points: Array) -> tuple[Array, Array]:
    """See `Engine`."""
    position = np.empty((len(points), states.v.shape[1], 3))
    acceleration, data, q = np.empty_like(position), data_of(structure.model), configuration(structure.slots, states.position)
    for i in range(states.v.shape[1]):
        pin.forwardKinematics(structure.model, data, np.ascontiguousarray(q[:, i]), states.v[:, i].copy(), states.a[:, i].copy())
        body, velocity = data.oMi[joint], data.v[joint]
        rate = pin.classicAcceleration(velocity, data.a[joint])
        spin, turning = velocity.angular, data.a[joint].angular
        for p, point in enumerate(points):
            position[p, i] = body.act(point)
            acceleration[p, i] = body.rotation @ (rate + np.cross(turning, point) + np.cross(spin, np.cross(spin, point)))
    return position, acceleration


def energies(structure: Structure, states: ClosedStates) -> EnergyRates:
    """See `Engine`."""
    model, data = structure.model, data_of(structure.model)
    q, n = configuration(structure.slots, states.position), states.v.shape[1]
    kinetic, potential, lifting = np.empty(n), np.empty(n), np.empty(n)
    for i in range(n):
        at, v = np.ascontiguousarray(q[:, i]), states.v[:, i].copy()
        kinetic[i], potential[i] = pin.computeKineticEnergy(model, data, at, v), pin.computePotentialEnergy(model, data, at)
        lifting[i] = float(pin.computeGeneralizedGravity(model, data, at) @ v)
    return EnergyRates(kinetic, potential, lifting)


def power_balance(structure: Structure, states: ClosedStates, loads: Sequence[AppliedForce]) -> PowerBalance:
    """See `Engine`. The powers are summed body by body."""
    n = states.v.shape[1]
    model, data = structure.model, data_of(structure.model)
    gravity, q = model.gravity.linear, configuration(structure.slots, states.position)
    balance, total, apparent = np.empty(n), np.empty(n), np.zeros(n)
    for i in range(n):
        pin.forwardKinematics(model, data, np.ascontiguousarray(q[:, i]), states.v[:, i].copy(), states.a[:, i].copy())
        powers = []
        for j in range(1, model.njoints):
            inertia, velocity = model.inertias[j], data.v[j]
            momentum_rate = inertia * data.a[j] + velocity.cross(inertia * velocity)
            lifted = data.oMi[j].rotation @ (velocity.linear + cross(velocity.angular, inertia.lever))
            powers += [inertia.mass * float(gravity @ lifted), -momentum_rate.dot(velocity)]
            pairs = ((inertia.mass * gravity, lifted), (momentum_rate.linear, velocity.linear), (momentum_rate.angular, velocity.angular))
            apparent[i] += sum(math.sqrt((force @ force) * (moved @ moved)) for force, moved in pairs)
        for load in loads:
            if load.joint:
                velocity = data.v[load.joint]
                moved = data.oMi[load.joint].rotation @ (velocity.linear + np.cross(velocity.angular, load.point))
                powers.append(float(load.force[i] @ moved))
                apparent[i] += math.sqrt((load.force[i] @ load.force[i]) * (moved @ moved))
        balance[i], total[i] = np.sum(powers), np.sum(np.abs(powers))
    return PowerBalance(balance, total, apparent)
