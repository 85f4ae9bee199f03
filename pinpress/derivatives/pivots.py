"""Where the pivots of a linkage are in its links, how far given positions move them, and how the planar equations follow.

The rows of a planar linkage (see `Plane`) are sums of the vectors from pivot to pivot, so they change in proportion to the displacements of
its pivots: one function, `shift`, gives what a finite change adds and the derivative in a direction.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..common.arguments import typed
from ..common.arrays import Array, ComplexArray
from ..common.checks import finite_numbers
from ..common.errors import PinpressError, UnknownNameError, shown
from ..engines.planar.model import Plane
from ..linkage.linkage import Linkage

Pivots = Mapping[tuple[str, str], ArrayLike]
"""(bearing, link) -> position (3,) of that bearing in the link's own frame [m]."""


class Displacements(NamedTuple):
    """How far pivots are moved [m]. The frame of a body is that of its Pinocchio joint.

    Attributes:
        joints: (nv, 3), in the frames of the bodies that carry the joints.
        ends: (loops, 2, 3), in the frames of the bodies at both ends of the loops.
    """

    joints: Array
    ends: Array

    def less(self, other: Displacements) -> Displacements:
        """How far these displacements go beyond others."""
        return Displacements(self.joints - other.joints, self.ends - other.ends)


def nowhere(press: Linkage) -> Displacements:
    """All displacements zero."""
    return Displacements(np.zeros((press.model.nv, 3)), np.zeros((len(press.loops), 2, 3)))


@typed
def pivot_positions(press: Linkage) -> dict[tuple[str, str], Array]:
    """The position of every bearing in the links in which it can be moved.

    Of links that are welded together the first is named; the others may be named as well where pivots are given.

    Returns:
        (bearing, link) -> (3,) in the link's own frame [m].
    """
    positions = {}
    for j, name in enumerate(press.joints, 1):
        positions[name, _links(press, press.model.parents[j])[0]] = press.model.jointPlacements[j].translation
    for loop in press.loops:
        for joint, point in ((loop.joint1, loop.point1), (loop.joint2, loop.point2)):
            positions[loop.name, _links(press, joint)[0]] = point
    return {(name, link): _placement(press, link).actInv(point) for (name, link), point in positions.items()}


def displaced(press: Linkage, pivots: Pivots) -> Displacements:
    """How far given positions move the pivots of a linkage.

    Raises:
        UnknownNameError: a bearing or link that it does not have.
        PinpressError: a link that the bearing is not on, or in which it cannot be moved; a position that is not three finite numbers.
    """
    moved = nowhere(press)
    for key, position in _vectors(pivots):
        place, before = _pivot(press, *key)
        (moved.joints if len(place) == 1 else moved.ends)[place] = _placement(press, key[1]).act(position) - before
    return moved


def directed(press: Linkage, direction: Pivots) -> Displacements:
    """Displacements per unit of a direction, which gives (bearing, link) -> (3,) derivative of the position.

    Raises:
        PinpressError, UnknownNameError: as `displaced` does.
    """
    moved = nowhere(press)
    for key, derivative in _vectors(direction):
        place, _ = _pivot(press, *key)
        (moved.joints if len(place) == 1 else moved.ends)[place] = _placement(press, key[1]).rotation @ derivative
    return moved


def _vectors(pivots: Pivots) -> Iterator[tuple[tuple[str, str], Array]]:
    """Check pivots, and give every pair of names with its vector."""
    if not isinstance(pivots, Mapping):
        raise PinpressError("pivots is no mapping: give {(bearing, link): (x, y, z)}, in the links' own frames [m]")
    for key, values in pivots.items():
        if not (isinstance(key, tuple) and len(key) == 2):
            raise PinpressError(f"pivots: {shown(key)} is no pair of names: write (bearing, link)")
        vector = finite_numbers(values)
        if vector is None or vector.shape != (3,):
            raise PinpressError(f"pivots: {shown(key)} is {shown(values)}: give three finite numbers, in the link's own frame [m]")
        yield key, vector


def _pivot(press: Linkage, bearing: str, link: str) -> tuple[tuple[int, ...], Array]:
    """The place of a pivot in `Displacements`, and where it is, in the frame of the joint that carries the link."""
    if bearing not in press.bearings:
        raise UnknownNameError("bearing", bearing, press.bearings)
    if link not in press.links:
        raise UnknownNameError("link", link, press.links)
    body, index = _body(press, link), press.bearings.index(bearing)
    if index < len(press.joints):
        parent = press.model.parents[index + 1]
        if body == parent:
            return (index,), press.model.jointPlacements[index + 1].translation
        if body == index + 1:
            others = " or ".join(repr(key) for key in pivot_positions(press) if _body(press, key[1]) == body)
            raise PinpressError(
                f"bearing {shown(bearing)} is the origin of link {shown(link)}'s frame and cannot be moved in it: move the link's"
                " other pivots" + (f", {others}," if others else "") + " instead"
            )
        ends = [parent, index + 1]
    else:
        loop = press.loops[index - len(press.joints)]
        ends = [loop.joint1, loop.joint2]
        if body in ends:
            side = ends.index(body)
            return (index - len(press.joints), side), (loop.point1, loop.point2)[side]
    joined = " and ".join(repr(_links(press, end)[0]) for end in ends)
    raise PinpressError(f"bearing {shown(bearing)} is not on link {shown(link)}: it joins {joined}")


def _placement(press: Linkage, link: str) -> pin.SE3:
    return press.model.frames[press.model.getFrameId(link, pin.BODY)].placement


def _body(press: Linkage, link: str) -> int:
    return int(press.model.frames[press.model.getFrameId(link, pin.BODY)].parentJoint)


def _links(press: Linkage, joint: int) -> list[str]:
    """The links that are welded together on the body of a Pinocchio joint."""
    return [link for link in press.links if _body(press, link) == joint]


# ---------- equations of a planar linkage

IN_PLANE = 1e-12  # displacement along the normal that is rounding, beside the others


class Shift(NamedTuple):
    """What displacements add to the rows of a `Plane`.

    Attributes:
        closure: of `Plane.closure`.
        origins: of `Plane.origins`.
        loop_points: of `Plane.loop_points`.
    """

    closure: ComplexArray
    origins: ComplexArray
    loop_points: ComplexArray

    def times(self, share: float) -> Shift:
        """What a share of the displacements adds."""
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
