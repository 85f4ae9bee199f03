"""Masses and inertias of a planar linkage as constant matrices: the forces of its open tree.

How bearings share forces out of the plane depends on no configuration, and stands here too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from ...common.quantities import Array, ComplexArray
from ..sharing import Objective, lexicographic_least_squares
from .model import Plane

ROUNDING = 1e-13  # relative size below which an offset from the plane is rounding


@dataclass(frozen=True, eq=False, repr=False)
class Bodies:
    """Inertial constants of a planar linkage, and the rows that give forces and arms from the basis.

    Attributes:
        plane: constants of the linkage's geometry.
        mass: (nv,) of the bodies [kg].
        gravity: (3,) in world axes [m/s2].
        axial_weight: (nv,) weights along the normal [N].
        inertia: (nv, nv) joint accelerations to the rate of every body's angular momentum about its centre of mass [kg m2].
        products: (nv,) products of inertia with the normal, I_1n + i I_2n, in the drawn pose [kg m2].
        centers: (nv, nb) centres of mass.
        forces: (nv, nb) second derivative of the basis to the inertia force less weight, m (a - g), of every body. The first column is the
            weight: callers put 1 in the first row of the second derivative, which is zero.
        rotor_inertia: (nb - 1, nb) moments of inertia of the links with the rotors that turn them [kg m2].
        geared: joints that turn and are coupled.
        in_one_plane: whether all masses move, and all weights act, in one plane.
    """

    plane: Plane
    mass: Array
    gravity: Array
    axial_weight: Array
    inertia: Array
    products: ComplexArray
    centers: ComplexArray
    forces: ComplexArray
    rotor_inertia: ComplexArray
    geared: frozenset[int]
    in_one_plane: bool

    @cached_property
    def subtree_forces(self) -> ComplexArray:
        """(nv, nb) second derivative of the basis, as for ``forces``, to the sum of the forces of all bodies that a joint carries."""
        return np.asarray(self.plane.subtree @ self.forces)

    @cached_property
    def reduced(self) -> ComplexArray:
        """(nb - 1, nb) likewise to the work of these forces on every function of the basis but the first, conj(function) times force; the
        moments of inertia of the links stand with their rotors, as masses at the radius 1 round them would."""
        return np.asarray(self.centers.conj().T[1:] @ self.forces + self.rotor_inertia)

    @cached_property
    def force_sharing(self) -> Array:
        """(bearings, nv) how bearings share forces along the normal where no compliances are given."""
        return share_forces(self.plane, None)

    @cached_property
    def moment_sharing(self) -> Array:
        """(bearings, nv) how bearings share tilting moments, which the loops that resist tilting can carry."""
        return _share(self.plane, np.flatnonzero(self.plane.resists_tilting).tolist(), None)

    @cached_property
    def along_normal(self) -> bool:
        """Whether weights act along the normal."""
        return bool(np.any(np.abs(self.axial_weight) > ROUNDING * self.mass * np.linalg.norm(self.gravity)))

    @cached_property
    def tilting(self) -> ComplexArray:
        """(nv, nb) second derivative of the basis to the tilting moments that the joints would have to carry with all loops open, where
        nothing acts along the normal."""
        plane = self.plane
        steps = np.array([height - plane.heights[p] if p >= 0 else 0.0 for p, height in zip(plane.parents, plane.heights, strict=True)])
        own = 1j * self.forces * (plane.center_heights - plane.heights)[:, None]
        for row, rotor, products in zip(own, plane.rotors, self.products, strict=True):
            if rotor:
                row[rotor] -= 1j * products
        hanging = 1j * self.subtree_forces * steps[:, None]
        return np.asarray(plane.subtree @ (own + hanging) - hanging)

    @cached_property
    def tilting_by_pins(self) -> Array:
        """(nv, nl) forces of the loops in the plane to minus i times what they add to these moments."""
        return np.asarray(self.plane.incidence * (self.plane.heights[:, None] - self.plane.loop_heights))


def build_bodies(plane: Plane, model: pin.Model) -> Bodies:
    """Inertial constants of a linkage from its Pinocchio model."""
    count = model.nv
    inertias = [model.inertias[j + 1] for j in range(count)]
    gravity = model.gravity.linear
    mass = np.array([y.mass for y in inertias])
    tensors = np.array([f @ y.inertia @ f.T for f, y in zip(plane.frames, inertias, strict=True)])
    products = tensors[:, 0, 2] + 1j * tensors[:, 1, 2]
    products[np.abs(products) <= ROUNDING * np.abs(tensors).max(axis=(1, 2))] = 0.0
    axial_weight = mass * float(gravity @ plane.normal)
    centers = plane.origins + plane.centers
    body_forces = centers * mass[:, None]
    body_forces[:, 0] = -mass * complex(*(plane.axes @ gravity))
    heights = np.concatenate([plane.heights, plane.center_heights, plane.loop_heights])
    about_normal = tensors[:, 2, 2]
    rotor_inertia: ComplexArray = np.zeros((count, 1 + count), complex)
    for rotor, inertia in zip(plane.rotors, about_normal, strict=True):
        if rotor:
            rotor_inertia[rotor - 1, rotor] += inertia
    return Bodies(
        plane=plane,
        mass=mass,
        gravity=gravity.copy(),
        axial_weight=axial_weight,
        inertia=plane.spin * about_normal[:, None],
        products=products,
        centers=centers,
        forces=body_forces,
        rotor_inertia=rotor_inertia,
        geared=frozenset(j for gear in plane.relation_rows for j in gear if plane.sense[j]),
        in_one_plane=bool(
            np.all(np.ptp(heights) <= ROUNDING * np.abs(plane.origins).max())
            and not products.any()
            and np.all(np.abs(axial_weight) <= ROUNDING * mass * np.linalg.norm(gravity))
        ),
    )


def share_forces(plane: Plane, compliance: Array | None) -> Array:
    """How bearings share forces along the normal, which all loops can carry; see `_share`."""
    return _share(plane, range(len(plane.loop_heights)), compliance)


def _share(plane: Plane, loops: Sequence[int], compliance: Array | None) -> Array:
    """(bearings, nv) loads of the joints with all loops open to the loads of all bearings, of which these ``loops`` take a share by least
    squares; it depends on no configuration."""
    count, bearings = len(plane.parents), len(plane.parents) + len(plane.loop_heights)
    alone, every = np.eye(bearings, count), np.eye(bearings)
    response = np.concatenate([-plane.incidence, np.eye(len(plane.loop_heights))])[:, list(loops)]  # of all bearings to a unit in each loop
    objectives = [Objective(response, every, 1.0)]
    if compliance is not None:
        weights = np.sqrt(compliance)
        objectives.insert(0, Objective(weights[:, None] * response, weights * every, float(weights.max())))
    return alone + response @ lexicographic_least_squares(objectives).T @ alone if len(loops) else alone
