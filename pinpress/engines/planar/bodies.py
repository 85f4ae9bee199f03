"""What a planar linkage weighs and how its inertia acts: constants of its bodies, the forces of its open tree, energies and power balance.

How bearings share what acts out of the plane depends on no configuration either, and stands here too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from ...common.quantities import Array, ComplexArray
from ..engine import PIECE, ClosedStates, EnergyRates, PowerBalance
from ..forces import AppliedForce, Objective, lexicographic_least_squares
from ..joints import Matrix, compressed, matrix, plain, product, stacked, weighted, with_column
from .kinematics import basis_acceleration, basis_velocity, known_basis
from .model import Plane, to_complex

ROUNDING = 1e-13  # relative size below which an offset from the plane is rounding


@dataclass(frozen=True, eq=False, repr=False)
class Bodies:
    """Inertial constants of a planar linkage, and the rows that give forces and arms from the basis.

    Attributes:
        mass: (nv,) [kg].
        gravity: (3,) in world axes [m/s2].
        axial_weight: (nv,) m g along the normal [N].
        inertia: (nv, nv) d/dt of the angular momentum about every centre of mass from joint accelerations.
        products: (nv,) products of inertia with the normal, I_1n + i I_2n, in the drawn pose [kg m2].
        uncrossed: (nv, nl) minus `Plane.incidence`, what the joints are relieved of by the loop forces.
        forces: (2 nv, nb) on the second derivative of the basis: inertia force m a less weight of every body, then of all that hang on a
            joint. The first column is the weight; the basis' own first row does not move, so 1 is put there.
        reduced: (nb - 1, nb) on the same: work of all inertia forces less weights on every function of the basis but the first.
        spins: (nv, nv) joint accelerations to the effort of the links' inertia against turning in every joint.
        arms: on the basis: centres of mass from their joints; `Plane.closure`, its columns times i, alone in ``closure``;
            ``inner`` joints from their parents; directions of the prismatic joints; ``guided`` loops from the joint.
        inner: joints whose parent is not the frame, tips first.
        guided: (prismatic joint, loop) pairs: the loop's force turns the joint's link.
        geared: joints that turn and are coupled.
        in_one_plane: whether everything moves and acts in one plane.
    """

    plane: Plane
    mass: Array
    gravity: Array
    axial_weight: Array
    inertia: Matrix
    products: ComplexArray
    minus_incidence: Matrix
    forces: Matrix
    reduced: Matrix
    spins: Matrix
    arms: Matrix
    closure: Matrix
    inner: tuple[int, ...]
    guided: tuple[tuple[int, int], ...]
    geared: frozenset[int]
    in_one_plane: bool

    @cached_property
    def force_sharing(self) -> LoadSharing:
        """How bearings share forces along the normal, without compliances."""
        return share_forces(self.plane, None)

    @cached_property
    def moment_sharing(self) -> LoadSharing:
        """How they share tilting moments."""
        return share_moments(self.plane)


def build_bodies(plane: Plane, model: pin.Model) -> Bodies:
    """Inertial constants of a linkage, read once from the Pinocchio model."""
    count, loops = model.nv, len(plane.loop_heights)
    inertias = [model.inertias[j + 1] for j in range(count)]
    gravity = model.gravity.linear
    mass = np.array([y.mass for y in inertias])
    tensors = np.array([f @ y.inertia @ f.T for f, y in zip(plane.frames, inertias, strict=True)])
    products = tensors[:, 0, 2] + 1j * tensors[:, 1, 2]
    products[np.abs(products) <= ROUNDING * np.abs(tensors).max(axis=(1, 2))] = 0.0
    axial_weight = mass * float(gravity @ plane.normal)
    centers = plane.origins + plane.centers
    body_forces = with_column(weighted(centers, mass), 0, -mass * complex(*(plane.axes @ gravity)))
    inner = tuple(j for j in reversed(range(count)) if plane.parents[j] >= 0)
    guided = tuple((j, k) for j in plane.prismatic for k in plane.loops_of_joint[j])
    arms = stacked(
        [
            plane.centers,
            plane.closure[:loops],
            1j * plane.closure[loops:],
            plane.origins[list(inner)] - plane.origins[[plane.parents[j] for j in inner]],
            plane.directions,
            plane.loop_points[[k for _, k in guided]] - plane.origins[[j for j, _ in guided]],
        ]
    )
    heights = np.concatenate([plane.heights, plane.center_heights, plane.loop_heights])
    inertia = weighted(plane.spin, tensors[:, 2, 2])
    return Bodies(
        plane=plane,
        mass=mass,
        gravity=gravity.copy(),
        axial_weight=axial_weight,
        inertia=inertia,
        products=products,
        minus_incidence=-plane.incidence.astype(complex),
        forces=stacked([body_forces, compressed(plane.subtree @ body_forces)]),
        reduced=compressed(centers.conj().T)[1:] @ body_forces,
        spins=compressed(plane.spin.T @ inertia),
        arms=arms,
        closure=arms[count : count + plane.closure.shape[0]],
        inner=inner,
        guided=guided,
        geared=frozenset(j for gear in plane.coupling_rows for j in gear if plane.sense[j]),
        in_one_plane=bool(
            np.all(np.ptp(heights) <= ROUNDING * np.abs(plane.origins).max())
            and not products.any()
            and np.all(np.abs(axial_weight) <= ROUNDING * mass * np.linalg.norm(gravity))
        ),
    )


class OpenTree(NamedTuple):
    """The tree with all loops open, at n configurations.

    Attributes:
        own: (nv, n) inertia force less weight of every body.
        subtree_force: of all that hang on a joint, loads taken off.
        centers: (nv, n) arms of the centres of mass from their joints.
        closure: rows of `Plane.closure`, its columns times i.
        passive: (nv, n) efforts that the joints would have to transmit.
        turning: for every prismatic joint the moment (n,) that it would have to transmit about the normal.
        guided: arms (n,) of the ``guided`` loops of `Bodies`.
    """

    own: ComplexArray
    subtree_force: ComplexArray
    centers: ComplexArray
    closure: ComplexArray
    joint_efforts: Array
    turning: dict[int, Array]
    guided: ComplexArray


@dataclass(frozen=True, eq=False, repr=False)
class LoadSharing:
    """What all bearings carry of what joints do with all loops open, some of the loops sharing in it. Configurations do not matter.

    Attributes:
        alone: (bearings, nv) what joints would carry with all loops open.
        response: (bearings, shares) what a unit of each share adds.
        every: (bearings, nv) both together, worked out; None of a large linkage, where its entries would be too many.
    """

    alone: Matrix
    response: Matrix
    every: Array | None

    def shared(self, own: Any, kept: slice | list[int]) -> Any:
        """Of ``own`` (nv, n) of the joints with all loops open, what the ``kept`` bearings carry (kept, n): the least squares of all."""
        if self.every is not None:
            return product(self.every[kept].astype(own.dtype), own)
        from scipy.sparse.linalg import splu  # its import takes longer than loading a small press

        squares = splu((self.response.T @ self.response).tocsc())
        unshared = self.alone @ own
        across = self.response.T @ unshared
        parts = [across.real, across.imag] if np.iscomplexobj(across) else [across]
        shares = [squares.solve(np.ascontiguousarray(part)) for part in parts]
        return (unshared - self.response @ (shares[0] + 1j * shares[1] if len(shares) > 1 else shares[0]))[kept]


def share_forces(plane: Plane, compliance: Array | None) -> LoadSharing:
    """Of forces along the normal, in which all loops share."""
    return _load_sharing(plane, list(range(len(plane.loop_heights))), compliance)


def share_moments(plane: Plane) -> LoadSharing:
    """Of tilting moments, in which the loops that hold their links upright share."""
    return _load_sharing(plane, [int(k) for k in np.flatnonzero(plane.resists_tilting)], None)


def _load_sharing(plane: Plane, sharing: list[int], compliance: Array | None) -> LoadSharing:
    count, loops = len(plane.parents), len(plane.loop_heights)
    large = not isinstance(plane.incidence, np.ndarray)
    size = count if large else 0
    alone = matrix([{k: 1.0} if k < count else {} for k in range(count + loops)], count, size, float)
    response = stacked([-plane.incidence, matrix([{k: 1.0} for k in range(loops)], loops, size, float)])[:, sharing]
    if large and compliance is None:
        return LoadSharing(alone, response, None)
    alone, response, every = plain(alone), plain(response), np.eye(count + loops)  # the shares of a unit of each
    objectives = [Objective(response, every, 1.0)]
    if compliance is not None:
        weights = np.sqrt(compliance)
        objectives.insert(0, Objective(weights[:, None] * response, weights * every, float(weights.max())))
    found = alone + response @ lexicographic_least_squares(objectives).T @ alone if sharing else alone
    return LoadSharing(alone, response, found)


def energies(bodies: Bodies, basis: ComplexArray, v: Array) -> EnergyRates:
    """Of states with basis ``basis`` (nb, n) and joint rates (nv, n)."""
    plane, mass = bodies.plane, bodies.mass
    rows = plane.origins + plane.centers
    rate = basis_velocity(plane, basis, v)
    velocity = rows @ rate
    kinetic = 0.5 * (mass @ (velocity.real**2 + velocity.imag**2) + ((bodies.inertia @ v) * (plane.spin @ v)).sum(axis=0))
    lifted = -(mass @ rows) * complex(*(plane.axes @ bodies.gravity)).conjugate()
    return EnergyRates(kinetic, (lifted @ basis).real, (lifted @ rate).real)


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
    plane, basis = bodies.plane, known_basis(states)
    first, second = basis_velocity(plane, basis, states.v), basis_acceleration(plane, basis, states.v, states.a)
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
            velocity, force = product(row[None], first)[0], to_complex(plane, load.force)
            terms.append((velocity.conj() * force).real)
            apparent += np.abs(velocity) * np.abs(force)
    return np.array(terms), apparent
