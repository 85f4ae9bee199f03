"""How the equations of a planar linkage follow its pivots.

The rows of a planar linkage (see `plane`) are sums of the vectors from pivot to pivot, so they change in proportion to the displacements of
its pivots: the same function gives what a finite change adds, and the derivative in a direction.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..common.arrays import Array, ComplexArray
from ..common.errors import PinpressError, shown
from ..engines.planar.model import Plane
from ..linkage.linkage import Linkage
from .pivots import Displacements

IN_PLANE = 1e-12  # displacement along the normal that is rounding, beside the others


class Shift(NamedTuple):
    """What displacements add to `Plane.closure`, `Plane.origins` and `Plane.loop_points`."""

    closure: ComplexArray
    origins: ComplexArray
    loop_points: ComplexArray

    def times(self, share: float) -> "Shift":
        """The same of a share of the displacements."""
        return Shift(*(share * rows for rows in self))


def shift(press: Linkage, plane: Plane, moved: Displacements) -> Shift:
    """What displacements add to the rows of a planar linkage.

    Raises:
        PinpressError: a displacement out of the plane.
    """
    origins, points, closure = (np.zeros_like(rows) for rows in (plane.origins, plane.loop_points, plane.closure))
    for j, parent in enumerate(plane.parents):  # parents come before their children in Pinocchio
        if parent >= 0:
            origins[j] = origins[parent]
        origins[j, plane.rotor(parent)] += _across(plane, parent, moved.joints[j], press.joints[j])
    row = len(press.loops)
    for k, loop in enumerate(press.loops):
        sides = []
        for joint, displacement in ((loop.joint1 - 1, moved.ends[k, 0]), (loop.joint2 - 1, moved.ends[k, 1])):
            side = origins[joint].copy() if joint >= 0 else np.zeros(closure.shape[1], complex)
            side[plane.rotor(joint)] += _across(plane, joint, displacement, loop.name)
            sides.append(side)
        points[k], closure[k] = sides[0], sides[1] - sides[0]
        for joint in map(int, np.flatnonzero(plane.crossed[:, k])):  # in the order of `Plane.closure`
            if joint in plane.revolute:
                crossed = plane.crossed[joint, k]
                closure[row] = 1j * plane.sense[joint] * crossed * (sides[1 if crossed > 0 else 0] - origins[joint])
            row += 1
    return Shift(closure, origins, points)


def shifted(plane: Plane, by: Shift) -> Plane:
    """The plane of the linkage with its pivots moved, in the drawn pose of the one before."""
    closure = plane.closure + by.closure
    loops, turning = len(plane.loop_points), len(plane.revolute)
    size = float(np.abs(closure[:loops, : 1 + turning]).sum(axis=1).max(initial=0.0)) or plane.size
    return replace(plane, closure=closure, origins=plane.origins + by.origins, loop_points=plane.loop_points + by.loop_points, size=size)


def _across(plane: Plane, joint: int, displacement: Array, name: str) -> complex:
    """A displacement in a body's frame, in the plane's axes of the drawn pose."""
    x, y, along = (plane.frames[joint] if joint >= 0 else np.array([*plane.axes, plane.normal])) @ displacement
    if abs(along) > IN_PLANE * max(plane.size, abs(x), abs(y)):
        raise PinpressError(f"bearing {shown(name)} is moved {along:.3g} m out of the plane of the linkage: move it within the plane")
    return complex(x, y)
