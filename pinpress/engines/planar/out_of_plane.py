"""Forces of a planar linkage along the normal of its plane, and moments that tilt its links.

They come from links in parallel planes, products of inertia, and gravity or loads out of the plane. Rigid mechanics does not decide how the
loops share a force along the normal, nor how several bearings of a link share its tilting moment: they are shared as `engines.forces` says,
and `Reactions.indeterminate` marks them.

With the axes of `Plane`, normal x f is i f, and r x normal is -i r, for complex f and r.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...common.quantities import Array, ComplexArray
from ..engine import ClosedStates
from ..forces import RANK, AppliedForce, Wrenches
from ..joints import product
from .bodies import Bodies, OpenTree, share_forces
from .kinematics import basis_at, known_basis
from .model import Plane, to_complex, to_world


def is_flat(plane: Plane, load: AppliedForce) -> bool:
    """Whether a load acts in the plane of its link, or on the frame, where it loads no bearing."""
    if load.joint == 0:
        return True
    height = (plane.frames[load.joint - 1] @ load.point)[2]  # above the plane of its link
    return bool(height == 0.0 and not np.any(load.force @ plane.normal))


def forces(bodies: Bodies, loads: Sequence[AppliedForce], compliance: Array | None, n: int) -> Array:
    """Forces (bearings, n) of all bearings along the normal [N]; ``compliance`` as in `AppliedConditions`, ``n`` states."""
    plane = bodies.plane
    axial = np.zeros((len(plane.parents), n)) - bodies.axial_weight[:, None]
    for load in loads:
        if load.joint:
            axial[load.joint - 1] -= load.force @ plane.normal
    spread = bodies.force_sharing if compliance is None else share_forces(plane, compliance)
    return np.asarray(spread.shared(plane.subtree @ axial, slice(None)))


def add(
    bodies: Bodies,
    states: ClosedStates,
    open_tree: OpenTree,
    pins: ComplexArray,
    loads: Sequence[AppliedForce],
    axial: Array,
    wanted: Sequence[int],
    result: Wrenches,
) -> None:
    """Add the axial forces and tilting moments of the wanted bearings to a result that holds their forces and moments in the plane.

    Args:
        bodies: inertial constants of the linkage.
        states: closed states with their basis.
        open_tree: its forces with all loops open.
        pins: (loops, n) complex forces of the loops in the plane [N].
        loads: forces on links.
        axial: (bearings, n) what `forces` returned [N].
        wanted: indices of the wanted bearings.
        result: wrenches of these bearings.
    """
    kept = slice(None) if len(wanted) == len(axial) else list(wanted)
    tilting = bodies.moment_sharing.shared(_tilting_moments(bodies, states, open_tree, pins, loads, axial), kept)
    axial = axial[kept]
    for i, (along, first, second) in enumerate(zip(bodies.plane.normal, *bodies.plane.axes, strict=True)):
        # most presses stand in a coordinate plane: axes without a component there cost nothing
        if along:
            result.force[..., i] += along * axial
        if first:
            result.moment[..., i] += first * tilting.real
        if second:
            result.moment[..., i] += second * tilting.imag


def _tilting_moments(
    bodies: Bodies, states: ClosedStates, open_tree: OpenTree, pins: ComplexArray, loads: Sequence[AppliedForce], axial: Array
) -> ComplexArray:
    """Tilting moments (nv, n) that the joints would have to carry if no loop carried any [N m]. Arguments as of `add`."""
    plane, basis = bodies.plane, known_basis(states)
    count = len(plane.parents)
    spin, acceleration = plane.spin @ states.v, plane.spin @ states.a
    rotors = basis[list(plane.rotors)]
    weight = -bodies.axial_weight[:, None]
    tilt: ComplexArray = (acceleration + 1j * spin**2) * bodies.products[:, None] * rotors
    own, centers = product(bodies.forces, open_tree.second), product(plane.centers, basis)
    tilt += 1j * (plane.center_heights - plane.heights)[:, None] * own - 1j * centers * weight
    for load in loads:
        if load.joint:
            joint = load.joint - 1
            x, y, height = plane.frames[joint] @ load.point
            tilt[joint] -= 1j * height * to_complex(plane, load.force) - 1j * complex(x, y) * rotors[joint] * (load.force @ plane.normal)
    hanging = axial[:count] + plane.incidence @ axial[count:]
    origins = plane.origins @ basis
    for j in reversed(range(count)):
        p = plane.parents[j]
        if p >= 0:
            tilt[p] += (
                tilt[j]
                + 1j * (plane.heights[j] - plane.heights[p]) * open_tree.subtree_force[j]
                - 1j * (origins[j] - origins[p]) * hanging[j]
            )
    points = plane.loop_points @ basis
    for j in range(count):
        for k, sign in plane.loops_of_joint[j].items():
            arm = points[k] - origins[j]
            tilt[j] -= sign * (1j * (plane.loop_heights[k] - plane.heights[j]) * pins[k] - 1j * arm * axial[count + k])
    return tilt


def indeterminate(plane: Plane, position: Array, axes: Array) -> NDArray[np.bool_]:
    """Force and moment components (bearings, 6), along the rows of ``axes`` (3, 3), that rigid mechanics leaves open in any of the
    positions (nv, n); see `Reactions.indeterminate`.

    This is for a linkage without redundant equations in the plane. There the joints of the tree could carry everything along the normal
    alone, so that each loop may take any part of it, and any tilting moment if its bearing resists tilting.
    """
    count = len(plane.parents)
    basis = basis_at(plane, position)
    origins, points = product(plane.origins, basis), product(plane.loop_points, basis)
    along = [np.abs(axes @ each) > RANK for each in (plane.normal, *plane.axes)]
    tilting = along[1] | along[2]
    marks = np.zeros((count + len(plane.loop_heights), 6), dtype=bool)
    marks[count:, :3] = along[0]
    marks[count:, 3:] = plane.resists_tilting[:, None] & tilting
    for joint, loops in enumerate(plane.loops_of_joint):
        for loop in loops:
            marks[joint, :3] |= along[0]
            if plane.resists_tilting[loop]:
                marks[joint, 3:] |= tilting
            else:
                moments = to_world(plane, -1j * (points[loop] - origins[joint])) @ axes.T
                marks[joint, 3:] |= np.abs(moments).max(axis=0) > RANK * plane.size
    return marks
