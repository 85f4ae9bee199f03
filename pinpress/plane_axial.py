"""What a planar linkage carries out of its plane: forces along the normal, and moments that tilt the links.

They come from links in parallel planes, products of inertia, gravity or loads across the plane. How the loops share a force along the
normal, or where several bearings of a link hold it upright its tilting moment, is not decided by rigid mechanics: it is shared as `sharing`
says, and `Reactions.indeterminate` names it.

With the axes of `Plane`, normal x f is i f and r x normal is -i r for complex f and r.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from .coordinates import Array, ComplexArray
from .forces import AppliedForce
from .plane import Plane, flat, in_space
from .sharing import Objective, least
from .wrenches import Wrenches

Values = TypeVar("Values", Array, ComplexArray)

if TYPE_CHECKING:
    from .plane_dynamics import Bodies, OpenTree


def is_flat(plane: Plane, load: AppliedForce) -> bool:
    """Whether a load stays in the plane of the linkage, or acts on the frame, where it reaches no bearing."""
    if load.joint == 0:
        return True
    height = (plane.frames[load.joint - 1] @ load.point)[2]  # over the plane of its link
    return bool(height == 0.0 and not np.any(load.force @ plane.normal))


def forces(plane: Plane, bodies: "Bodies", loads: Sequence[AppliedForce], compliance: Array | None, n: int) -> Array:
    """Forces (bearings, n) of all bearings along the normal."""
    axial = np.zeros((len(plane.parents), n)) - bodies.axial_weight[:, None]
    for load in loads:
        if load.joint:
            axial[load.joint - 1] -= load.force @ plane.normal
    axial = plane.carried @ axial
    return _with_loops(plane, axial, range(len(plane.loop_points)), compliance)


def add(
    plane: Plane,
    bodies: "Bodies",
    at: ComplexArray,
    v: Array,
    a: Array,
    tree: "OpenTree",
    pins: ComplexArray,
    loads: Sequence[AppliedForce],
    axial: Array,
    result: Wrenches,
) -> None:
    """Add the axial forces and tilting moments to a result that has the plane's.

    Args:
        at: basis; v, a: joint rates and accelerations; tree: with its loops open; pins: loop forces; axial: what `forces` returned.
    """
    count = len(plane.parents)
    spin, acceleration = plane.spin @ v, plane.spin @ a
    rotors = at[[plane.rotor(j) for j in range(count)]]
    weight = -bodies.axial_weight[:, None]
    tilt = (acceleration + 1j * spin**2) * bodies.products[:, None] * rotors
    tilt += 1j * (plane.center_heights - plane.heights)[:, None] * tree.own - 1j * tree.centers * weight
    for load in loads:
        if load.joint:
            joint = load.joint - 1
            x, y, height = plane.frames[joint] @ load.point
            tilt[joint] -= 1j * height * flat(plane, load.force) - 1j * complex(x, y) * rotors[joint] * (load.force @ plane.normal)
    hanging = axial[:count] + plane.crossed @ axial[count:]
    origins = plane.origins @ at
    for j in reversed(range(count)):
        p = plane.parents[j]
        if p >= 0:
            tilt[p] += tilt[j] + 1j * (plane.heights[j] - plane.heights[p]) * tree.carried[j] - 1j * (origins[j] - origins[p]) * hanging[j]
    points = plane.loop_points @ at
    for j in range(count):
        for k in np.flatnonzero(plane.crossed[j]):
            arm = points[k] - origins[j]
            tilt[j] -= plane.crossed[j, k] * (1j * (plane.loop_heights[k] - plane.heights[j]) * pins[k] - 1j * arm * axial[count + k])
    tilting = _with_loops(plane, tilt, [int(k) for k in np.flatnonzero(plane.holding)], None)

    result.force[:] += axial[:, :, None] * plane.normal
    result.moment[:] += in_space(plane, tilting)


def _with_loops(plane: Plane, joints: Values, sharing: Sequence[int], compliance: Array | None) -> Values:
    """Forces, or moments, of all bearings from those (nv, n) of the joints with all loops open, some of which share in them."""
    count, loops = len(joints), len(plane.loop_points)
    response = np.concatenate([-plane.crossed[:, sharing], np.eye(loops)[:, sharing]])
    start: Values = np.concatenate([joints, np.zeros((loops, joints.shape[1]))])
    if not len(sharing):
        return start
    every = np.eye(count + loops)  # the shares of a unit of each, as they do not depend on the configuration
    objectives = [Objective(response, every, 1.0)]
    if compliance is not None:
        weights = np.sqrt(compliance)
        objectives.insert(0, Objective(weights[:, None] * response, weights * every, float(weights.max())))
    shared: Values = start + response @ (least(objectives).T @ start)
    return shared
