"""Power balance of a planar linkage at all crank angles at once, apart from the recursion that gives the torque."""

from collections.abc import Sequence

import numpy as np

from ...common.arrays import Array, ComplexArray
from ..constant_rows import product
from ..forces import AppliedForce
from .bodies import Bodies
from .inverse_dynamics import PIECE
from .kinematics import basis_acceleration, basis_velocity
from .model import Plane, flat


def power_balance(
    plane: Plane, bodies: Bodies, at: ComplexArray, v: Array, a: Array, loads: Sequence[AppliedForce]
) -> tuple[Array, Array, Array]:
    """Power of the loads less the rate of kinetic and potential energy, and what it is small beside, both (n,) [W]: the sum of the absolute
    powers, and of those that there would be were all forces along the velocities.

    The energy's rate is taken body by body from velocities and accelerations: it shares nothing with the recursion that gave the torque.
    """
    balance, total, apparent = np.empty(v.shape[1]), np.empty(v.shape[1]), np.empty(v.shape[1])
    for start in range(0, v.shape[1], PIECE):
        s = slice(start, start + PIECE)
        powers, apparent[s] = _powers(plane, bodies, at[:, s], v[:, s], a[:, s], [load.part(s) for load in loads])
        balance[s], total[s] = powers.sum(axis=0), np.abs(powers).sum(axis=0)
    return balance, total, apparent


def _powers(plane: Plane, bodies: Bodies, at: ComplexArray, v: Array, a: Array, loads: Sequence[AppliedForce]) -> tuple[Array, Array]:
    """Every term (terms, n) of the balance, and the sum (n,) of forces times velocities, whatever their directions."""
    first, second = basis_velocity(plane, at, v), basis_acceleration(plane, at, v, a)
    count = len(plane.parents)
    second[0] = 1.0
    resisting = product(bodies.forces[:count], second)
    velocities = product(plane.origins + plane.centers, first)
    turning = (bodies.inertia @ a) * (plane.spin @ v)
    terms = list(-(velocities.conj() * resisting).real - turning)
    apparent = (np.abs(velocities) * np.abs(resisting) + np.abs(turning)).sum(axis=0)
    for load in loads:
        if load.joint:
            row = plane.point(load.joint - 1, complex(*(plane.frames[load.joint - 1] @ load.point)[:2]))
            velocity, force = product(row[None], first)[0], flat(plane, load.force)
            terms.append((velocity.conj() * force).real)
            apparent += np.abs(velocity) * np.abs(force)
    return np.array(terms), apparent
