"""Energies of a linkage, and the balance of its powers, from the motion of its bodies: independent of inverse dynamics."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common.quantities import Array
from .body_motion import BodyMotion, PointMotion, by_constants, cross, turned, turned_back
from .engine import ClosedStates, Engine
from .wrenches import AppliedForce


class EnergyRates(NamedTuple):
    """Energies of states.

    Attributes:
        kinetic: (n,) kinetic energy of all links, and of the rotors that the model's armature stands for [J].
        potential: (n,) potential energy of their weights [J]; zero with all centres of mass at the world origin.
        lifting: (n,) rate of the potential energy [W].
    """

    kinetic: Array
    potential: Array
    lifting: Array


class PowerBalance(NamedTuple):
    """The balance of all powers but those of drives and friction, and the scales by which an error of it is judged.

    Attributes:
        balance: (n,) power of the loads less the rate of kinetic and potential energy [W].
        total: (n,) sum of the absolute values of these powers [W].
        apparent: (n,) sum of the powers as if every force acted along the velocity of its point [W].
    """

    balance: Array
    total: Array
    apparent: Array


class _Masses(NamedTuple):
    """Masses (nv,) [kg], centres of mass (nv, 3) [m] and moments of inertia about these (nv, 3, 3) [kg m2] in the frames of the joints, and
    weights (nv, 3) [N]."""

    mass: Array
    lever: Array
    inertia: Array
    weight: Array


def energies(engine: Engine, states: ClosedStates) -> EnergyRates:
    """Kinetic and potential energy of closed states."""
    masses, bodies, centers = _moving_masses(engine, states, accelerations=False)
    spin = turned_back(bodies.rotation, bodies.spin)
    turning = (spin * by_constants(masses.inertia, spin)).sum(axis=(0, 1))
    kinetic = 0.5 * (masses.mass @ (centers.velocity * centers.velocity).sum(axis=1) + turning)
    if engine.structure.model.armature.any():
        kinetic += 0.5 * engine.structure.model.armature @ states.v**2
    potential, lifting = (-np.einsum("ki,kin->n", masses.weight, vectors) for vectors in (centers.place, centers.velocity))
    return EnergyRates(kinetic, potential, lifting)


def power_balance(engine: Engine, states: ClosedStates, loads: Sequence[AppliedForce]) -> PowerBalance:
    """The power balance of loads and links, summed body by body."""
    pieces = (slice(start, start + engine.piece) for start in range(0, states.v.shape[1], engine.piece))
    parts = [_power_balance(engine, states.part(s), [load.part(s) for load in loads if load.joint]) for s in pieces]
    return PowerBalance(*(np.concatenate(values) for values in zip(*parts, strict=True)))


def _power_balance(engine: Engine, states: ClosedStates, loads: Sequence[AppliedForce]) -> PowerBalance:
    masses, bodies, centers = _moving_masses(engine, states, accelerations=True)
    spin, turning = turned_back(bodies.rotation, bodies.spin), turned_back(bodies.rotation, bodies.turning)
    momentum_rate = cross(spin, by_constants(masses.inertia, spin)) + by_constants(masses.inertia, turning)
    pairs = [
        (masses.weight[:, :, None], centers.velocity),
        (-masses.mass[:, None, None] * centers.acceleration, centers.velocity),
        (-turned(bodies.rotation, momentum_rate), bodies.spin),
    ]
    for load in loads:
        body = engine.body_motion(states, [load.joint], accelerations=False)
        pairs.append((load.force.T[None], body.points(load.point[None]).velocity))
        if load.moment is not None:
            pairs.append((load.moment.T[None], body.spin))
    powers = np.concatenate([(force * motion).sum(axis=1) for force, motion in pairs])
    sizes = [np.sqrt((force * force).sum(axis=1) * (motion * motion).sum(axis=1)) for force, motion in pairs]
    return PowerBalance(powers.sum(axis=0), np.abs(powers).sum(axis=0), np.concatenate(sizes).sum(axis=0))


def _moving_masses(engine: Engine, states: ClosedStates, accelerations: bool) -> tuple[_Masses, BodyMotion, PointMotion]:
    """Masses of all bodies, their motion, and that of their centres of mass."""
    model: pin.Model = engine.structure.model
    inertias = list(model.inertias)[1:]
    mass = np.array([inertia.mass for inertia in inertias])
    lever, tensors = np.array([inertia.lever for inertia in inertias]), np.array([inertia.inertia for inertia in inertias])
    bodies = engine.body_motion(states, range(1, model.njoints), accelerations)
    return _Masses(mass, lever, tensors, mass[:, None] * model.gravity.linear), bodies, bodies.points(lever)
