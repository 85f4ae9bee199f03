"""What a planar linkage carries out of its plane: forces along the normal, and moments that tilt the links.

They come from links in parallel planes, products of inertia, gravity or loads across the plane. How the loops share a force along the
normal is not decided by rigid mechanics (a pin's third row is redundant there): the share with the least sum of squared bearing forces is
given, and `Reactions.indeterminate` names it.

With the axes of `Plane`, normal x f is i f and r x normal is -i r for complex f and r.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .coordinates import Array, ComplexArray
from .loads import AppliedForce
from .plane import Plane, flat
from .wrenches import Wrenches

if TYPE_CHECKING:
    from .plane_dynamics import Bodies

ROUNDING = 1e-12  # a component of the normal below it is none


def is_flat(plane: Plane, load: AppliedForce) -> bool:
    """Whether a load stays in the plane of the linkage, or acts on the frame, where it reaches no bearing."""
    if load.joint == 0:
        return True
    height = (plane.frames[load.joint - 1] @ load.point)[2]  # over the plane of its link
    return bool(height == 0.0 and not np.any(load.force @ plane.normal))


def indeterminate(plane: Plane) -> NDArray[np.bool_]:
    """Components (bearings, 6) that depend on how the loops share forces along the normal; see `Reactions.indeterminate`."""
    along, across = np.abs(plane.normal) > ROUNDING, 1.0 - np.abs(plane.normal) > ROUNDING
    arms = [
        any(np.abs(plane.loop_points[k] - plane.origins[j]).any() for k in np.flatnonzero(crossed))
        for j, crossed in enumerate(plane.crossed)
    ]
    joints = [np.concatenate([along & bool(crossed.any()), across & arm]) for crossed, arm in zip(plane.crossed, arms, strict=True)]
    return np.array(joints + [np.concatenate([along, np.zeros(3, bool)])] * len(plane.loop_points))


def add(
    plane: Plane,
    bodies: "Bodies",
    at: ComplexArray,
    v: Array,
    a: Array,
    own: ComplexArray,
    carried: ComplexArray,
    centers: ComplexArray,
    pins: ComplexArray,
    loads: Sequence[AppliedForce],
    result: Wrenches,
) -> None:
    """Add the axial forces and tilting moments to a result that has the plane's.

    Args:
        at: basis; v, a: joint rates and accelerations; own: inertia force less weight of every body; carried: of all that hang on a joint,
            loads taken off; centers: arms of the centres of mass from their joints; pins: loop forces.
    """
    count = len(plane.parents)
    axial = np.zeros((count, v.shape[1])) - bodies.axial_weight[:, None]
    spin, acceleration = plane.spin @ v, plane.spin @ a
    rotors = at[[plane.rotor(j) for j in range(count)]]
    tilt = (acceleration + 1j * spin**2) * bodies.products[:, None] * rotors
    tilt += 1j * (plane.center_heights - plane.heights)[:, None] * own - 1j * centers * axial
    for load in loads:
        if load.joint:
            joint = load.joint - 1
            x, y, height = plane.frames[joint] @ load.point
            across = load.force @ plane.normal
            axial[joint] -= across
            tilt[joint] -= 1j * height * flat(plane, load.force) - 1j * complex(x, y) * rotors[joint] * across
    axial = plane.carried @ axial
    origins = plane.origins @ at
    for j in reversed(range(count)):
        p = plane.parents[j]
        if p >= 0:
            tilt[p] += tilt[j] + 1j * (plane.heights[j] - plane.heights[p]) * carried[j] - 1j * (origins[j] - origins[p]) * axial[j]
    shared = np.linalg.solve(np.eye(len(pins)) + plane.crossed.T @ plane.crossed, plane.crossed.T @ axial)
    points = plane.loop_points @ at
    for j in range(count):
        for k in np.flatnonzero(plane.crossed[j]):
            arm = points[k] - origins[j]
            tilt[j] -= plane.crossed[j, k] * (1j * (plane.loop_heights[k] - plane.heights[j]) * pins[k] - 1j * arm * shared[k])
    axial = np.concatenate([axial - plane.crossed @ shared, shared])

    result.force[:] += axial[:, :, None] * plane.normal
    result.moment[:count] += _tilting(plane, tilt)


def _tilting(plane: Plane, moment: ComplexArray) -> Array:
    return np.asarray(moment.real[..., None] * plane.axes[0] + moment.imag[..., None] * plane.axes[1])
