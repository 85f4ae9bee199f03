"""Forces of a planar linkage along the normal of its plane, and moments that tilt its links.

They come from links in parallel planes, products of inertia, and gravity or loads out of the plane. Rigid mechanics does not decide how the
loops share a force along the normal, nor how several bearings of a link share its tilting moment: they are shared as `engines.sharing`
says, and `Reactions.indeterminate` marks them.

With the axes of `Plane`, normal x f is i f, and r x normal is -i r, for complex f and r.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...common.products import product
from ...common.quantities import Array, ComplexArray
from ..structure import ZERO
from ..wrenches import AppliedForce
from .bodies import Bodies, share_forces
from .kinematics import basis_at
from .model import Plane, to_complex, to_world


def is_flat(plane: Plane, load: AppliedForce) -> bool:
    """Whether a load acts in the plane of its link, or on the frame, where it loads no bearing."""
    if load.joint == 0:
        return True
    height = (plane.frames[load.joint - 1] @ load.point)[2]  # above the plane of its link
    return bool(height == 0.0 and not np.any(load.force @ plane.normal)) and (
        load.moment is None or not to_complex(plane, load.moment).any()
    )


def is_loaded(bodies: Bodies, loads: Sequence[AppliedForce]) -> bool:
    """Whether anything acts out of the plane."""
    return not bodies.in_one_plane or any(not is_flat(bodies.plane, load) for load in loads)


def forces(bodies: Bodies, loads: Sequence[AppliedForce], compliance: Array | None, n: int) -> Array | None:
    """Forces (bearings, n) of all bearings along the normal [N]; None if nothing acts along it. ``compliance`` as in
    `AppliedConditions`, ``n`` states."""
    plane = bodies.plane
    along = [(load.joint - 1, load.force @ plane.normal) for load in loads if load.joint]
    if not bodies.along_normal and not any(np.any(force) for _, force in along):
        return None
    axial = np.zeros((len(plane.parents), n)) - bodies.axial_weight[:, None]
    for joint, force in along:
        axial[joint] -= force
    spread = bodies.force_sharing if compliance is None else share_forces(plane, compliance)
    return np.asarray(product(spread, plane.subtree @ axial))


def add(
    bodies: Bodies,
    basis: ComplexArray,
    second: ComplexArray,
    pins: ComplexArray,
    loads: Sequence[AppliedForce],
    axial: Array | None,
    force: Array,
    moment: Array,
) -> None:
    """Add the axial forces and tilting moments of all bearings to their forces and moments in the plane.

    Args:
        bodies: inertial constants of the linkage.
        basis: (nb, n) of the states.
        second: (nb, n) second derivative of the basis by time, its first row 1.
        pins: (loops, n) complex forces of the loops in the plane [N].
        loads: forces on links.
        axial: what `forces` returned [N].
        force: (bearings, n, 3) forces of the bearings, to be added to [N].
        moment: (bearings, n, 3) their moments, to be added to [N m].
    """
    plane = bodies.plane
    moments = _tilting_moments(bodies, second, pins, loads)
    if axial is not None:
        moments += _moments_of_axial_forces(bodies, basis, loads, axial)
    if axial is not None:
        for i, along in enumerate(plane.normal):
            if along:
                force[..., i] += along * axial
    _share_tilting(bodies, moments, moment)


def add_idle(bodies: Bodies, pins: ComplexArray, moment: Array) -> None:
    """Add the tilting moments that idle forces of the loops (loops, n) bring to the moments (bearings, n, 3) of the bearings."""
    if not bodies.in_one_plane:
        _share_tilting(bodies, 1j * (bodies.tilting_by_pins @ pins), moment)


def _share_tilting(bodies: Bodies, moments: ComplexArray, moment: Array) -> None:
    """Add what bearings take of `_tilting_moments` (nv, n) to their moments (bearings, n, 3)."""
    tilting = product(bodies.moment_sharing.astype(complex), moments)
    for i, (first, other) in enumerate(zip(*bodies.plane.axes, strict=True)):
        # most presses stand in a coordinate plane: axes without a component there cost nothing
        if first:
            moment[..., i] += first * tilting.real
        if other:
            moment[..., i] += other * tilting.imag


def _tilting_moments(bodies: Bodies, second: ComplexArray, pins: ComplexArray, loads: Sequence[AppliedForce]) -> ComplexArray:
    """Tilting moments (nv, n) that the joints would have to carry if no loop carried any, without those of forces along the normal [N m].
    Arguments as of `add`."""
    plane = bodies.plane
    tilt: ComplexArray = product(bodies.tilting, second)
    tilt += 1j * (bodies.tilting_by_pins @ pins)
    for load in loads:
        if load.joint:
            joint, force = load.joint - 1, 1j * to_complex(plane, load.force)
            height = plane.heights[joint] + (plane.frames[joint] @ load.point)[2]
            moment = 0.0 if load.moment is None else to_complex(plane, load.moment)
            for carrier in plane.carriers(joint):
                tilt[carrier] -= (height - plane.heights[carrier]) * force + moment
    return tilt


def _moments_of_axial_forces(bodies: Bodies, basis: ComplexArray, loads: Sequence[AppliedForce], axial: Array) -> ComplexArray:
    """What forces along the normal add to the moments of `_tilting_moments`. ``axial``: (bearings, n) of all bearings [N]."""
    plane, count = bodies.plane, len(bodies.plane.parents)
    origins, points = product(plane.origins, basis), product(plane.loop_points, basis)
    tilt: ComplexArray = product(plane.centers, basis) * (1j * bodies.axial_weight[:, None])
    for load in loads:
        if load.joint:
            joint = load.joint - 1
            x, y, _ = plane.frames[joint] @ load.point
            tilt[joint] += 1j * complex(x, y) * basis[plane.rotors[joint]] * (load.force @ plane.normal)
    hanging = axial[:count] + product(plane.incidence, axial[count:])
    for j in reversed(range(count)):
        p = plane.parents[j]
        if p >= 0:
            tilt[p] += tilt[j] - 1j * (origins[j] - origins[p]) * hanging[j]
    for j in range(count):
        for k, sign in plane.loops_of_joint[j].items():
            tilt[j] += sign * 1j * (points[k] - origins[j]) * axial[count + k]
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
    along = [np.abs(axes @ each) > ZERO for each in (plane.normal, *plane.axes)]
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
                marks[joint, 3:] |= np.abs(moments).max(axis=0) > ZERO * plane.size
    return marks
