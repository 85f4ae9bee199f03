"""Energies and power balance of a planar linkage at all crank angles at once, apart from the recursion that gives the torque."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...common.arrays import Array, ComplexArray
from ..closure import PIECE
from ..constant_rows import product
from ..engine import ClosedStates, EnergyRates, PowerBalance
from ..forces import AppliedForce
from .bodies import Bodies
from .kinematics import basis_acceleration, basis_velocity, known_basis
from .model import flat


def energies(bodies: Bodies, at: ComplexArray, v: Array) -> EnergyRates:
    """Of states with basis ``at`` (nb, n) and joint rates (nv, n)."""
    plane, mass = bodies.plane, bodies.mass
    rows = plane.origins + plane.centers
    rate = basis_velocity(plane, at, v)
    velocity = rows @ rate
    kinetic = 0.5 * (mass @ (velocity.real**2 + velocity.imag**2) + ((bodies.inertia @ v) * (plane.spin @ v)).sum(axis=0))
    lifted = -(mass @ rows) * complex(*(plane.axes @ bodies.gravity)).conjugate()
    return EnergyRates(kinetic, (lifted @ at).real, (lifted @ rate).real)


def power_balance(bodies: Bodies, states: ClosedStates, loads: Sequence[AppliedForce]) -> PowerBalance:
    """The energy's rate is taken body by body from velocities and accelerations: it shares nothing with the recursion that gave the
    torque."""
    n = states.v.shape[1]
    balance, total, apparent = np.empty(n), np.empty(n), np.empty(n)
    for start in range(0, n, PIECE):
        s = slice(start, start + PIECE)
        powers, apparent[s] = _powers(bodies, states.part(s), [load.part(s) for load in loads])
        balance[s], total[s] = powers.sum(axis=0), np.abs(powers).sum(axis=0)
    return PowerBalance(balance, total, apparent)


def _powers(bodies: Bodies, states: ClosedStates, loads: Sequence[AppliedForce]) -> tuple[Array, Array]:
    """Every term (terms, n) of the balance, and the sum (n,) of forces times velocities, whatever their directions."""
    plane, at = bodies.plane, known_basis(states)
    first, second = basis_velocity(plane, at, states.v), basis_acceleration(plane, at, states.v, states.a)
    count = len(plane.parents)
    second[0] = 1.0
    resisting = product(bodies.forces[:count], second)
    velocities = product(plane.origins + plane.centers, first)
    turning = (bodies.inertia @ states.a) * (plane.spin @ states.v)
    terms = list(-(velocities.conj() * resisting).real - turning)
    apparent = (np.abs(velocities) * np.abs(resisting) + np.abs(turning)).sum(axis=0)
    for load in loads:
        if load.joint:
            row = plane.point(load.joint - 1, complex(*(plane.frames[load.joint - 1] @ load.point)[:2]))
            velocity, force = product(row[None], first)[0], flat(plane, load.force)
            terms.append((velocity.conj() * force).real)
            apparent += np.abs(velocity) * np.abs(force)
    return np.array(terms), apparent
