"""The functions of a planar linkage (see `model`) and their derivatives by time, and what they leave open."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...common.products import product
from ...common.quantities import Array, ComplexArray
from ..body_motion import BodyMotion
from ..engine import ClosedStates
from .model import Plane, to_world


def basis_at(plane: Plane, x: Array) -> ComplexArray:
    """The basis (nb, n) of joint coordinates (nv, n)."""
    turning = len(plane.revolute)
    basis = np.empty((1 + len(x), x.shape[1]), complex)
    basis[0] = 1.0
    absolute, rotors = product(plane.turn, x), basis[1 : 1 + turning]
    np.cos(absolute, out=rotors.real)
    np.sin(absolute, out=rotors.imag)
    for row, joint, rotor in plane.guides:
        basis[row] = x[joint] * basis[rotor] if rotor else x[joint]
    return basis


def known_basis(states: ClosedStates) -> ComplexArray:
    """The basis (nb, n) of states that carry it."""
    assert states.basis is not None
    return states.basis


def openings(plane: Plane, x: Array) -> Array:
    """Gaps (nl, 3) of the loops at joint coordinates (nv,), point 2 less point 1 in world axes [m]."""
    return to_world(plane, product(plane.gap_rows, basis_at(plane, x[:, None]))[:, 0])


def gaps(plane: Plane, x: Array, basis: ComplexArray) -> Array:
    """Largest gap (n,) of a loop or relation at joint coordinates (nv, n) with their basis (nb, n) [m]."""
    widest: Array = np.abs(product(plane.gap_rows, basis)).max(axis=0, initial=0.0)
    return np.asarray(np.maximum(widest, np.abs(product(plane.relation_slopes, x) - plane.offsets[:, None]).max(axis=0, initial=0.0)))


def basis_velocity(plane: Plane, basis: ComplexArray, v: Array) -> ComplexArray:
    """First time derivative (nb, n) of the basis at joint rates (nv, n)."""
    turning = len(plane.revolute)
    rate = np.empty_like(basis)
    rate[0] = 0.0
    spin = product(plane.turn, v)
    np.multiply(basis[1 : 1 + turning], 1j * spin, out=rate[1 : 1 + turning])
    for row, joint, rotor in plane.guides:
        rate[row] = v[joint] * basis[rotor] + 1j * spin[rotor - 1] * basis[row] if rotor else v[joint]
    return rate


def basis_acceleration(plane: Plane, basis: ComplexArray, v: Array, a: Array | None) -> ComplexArray:
    """Second time derivative (nb, n) of the basis at joint rates and accelerations (nv, n); without ``a`` only its centripetal and Coriolis
    part."""
    turning = slice(1, 1 + len(plane.revolute))
    result = np.empty(basis.shape, complex)
    result[0] = 0.0
    spin, factor = product(plane.turn, v), result[turning]
    np.multiply(spin, -spin, out=factor.real)
    factor.imag = 0.0 if a is None else product(plane.turn, a)
    for row, joint, rotor in plane.guides:
        along = 0.0 if a is None else a[joint]
        if rotor:
            result[row] = (along + 2j * spin[rotor - 1] * v[joint]) * basis[rotor] + factor[rotor - 1] * basis[row]
        else:
            result[row] = along
    factor *= basis[turning]
    return result


def body_motion(plane: Plane, basis: ComplexArray, states: ClosedStates, bodies: Sequence[int], accelerations: bool) -> BodyMotion:
    """Motion of some bodies, counted from 0, in states with this basis (nb, n)."""
    origins, spin, normal = plane.origins[bodies], plane.spin[bodies], plane.normal[:, None]

    def in_world(vectors: ComplexArray) -> Array:
        return np.asarray(plane.axes[0][:, None] * vectors.real[:, None] + plane.axes[1][:, None] * vectors.imag[:, None])

    # a vector with components x, y and h in the drawn pose is x + iy times the rotor in the plane, and h along the normal
    x, y, h = plane.frames[bodies].transpose(1, 0, 2)[..., None, :]
    (first, second), rotor = plane.axes[..., None], basis[[plane.rotors[body] for body in bodies]][:, None, None]
    along, across, fixed = first * x + second * y, second * x - first * y, normal * h
    motion = BodyMotion(
        rotation=along[..., None] * rotor.real + across[..., None] * rotor.imag + fixed[..., None],
        origin=in_world(product(origins, basis)) + plane.heights[bodies][:, None, None] * normal,
        velocity=in_world(product(origins, basis_velocity(plane, basis, states.v))),
        spin=product(spin, states.v)[:, None] * normal,
    )
    if not accelerations:
        return motion
    second_derivative = basis_acceleration(plane, basis, states.v, states.a)
    return motion._replace(acceleration=in_world(product(origins, second_derivative)), turning=product(spin, states.a)[:, None] * normal)
