"""Where the pivots of a linkage are in its links, and how far given positions move them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..common.arguments import typed
from ..common.arrays import Array
from ..common.checks import finite_numbers
from ..common.errors import PinpressError, UnknownNameError, shown
from ..linkage.linkage import Linkage

Pivots = Mapping[tuple[str, str], ArrayLike]
"""(bearing, link) -> position (3,) of that bearing in the link's own frame [m]."""


class Displacements(NamedTuple):
    """How far pivots are moved: of joints (nv, 3) in the frames of the bodies that carry them, of both ends of loops (loops, 2, 3) in the
    frames of theirs [m]. A body's frame is that of its Pinocchio joint."""

    joints: Array
    ends: Array

    def less(self, other: Displacements) -> Displacements:
        """How far these go beyond others."""
        return Displacements(self.joints - other.joints, self.ends - other.ends)


def nowhere(press: Linkage) -> Displacements:
    """No displacement."""
    return Displacements(np.zeros((press.model.nv, 3)), np.zeros((len(press.loops), 2, 3)))


@typed
def pivot_positions(press: Linkage) -> dict[tuple[str, str], Array]:
    """Where every bearing that can be moved in a link is: (bearing, link) -> (3,) in the link's own frame [m].

    Of links that are welded together the first is named; the others may be named as well where pivots are given.
    """
    positions = {}
    for j, name in enumerate(press.joints, 1):
        positions[name, _links(press, press.model.parents[j])[0]] = press.model.jointPlacements[j].translation
    for loop in press.loops:
        for joint, point in ((loop.joint1, loop.point1), (loop.joint2, loop.point2)):
            positions[loop.name, _links(press, joint)[0]] = point
    return {(name, link): _placement(press, link).actInv(point) for (name, link), point in positions.items()}


def displaced(press: Linkage, pivots: Pivots) -> Displacements:
    """How far these positions move the pivots of a linkage.

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
    """Displacements per unit of a direction: (bearing, link) -> (3,) derivative of the position. Raises as `displaced`."""
    moved = nowhere(press)
    for key, derivative in _vectors(direction):
        place, _ = _pivot(press, *key)
        (moved.joints if len(place) == 1 else moved.ends)[place] = _placement(press, key[1]).rotation @ derivative
    return moved


def _vectors(pivots: Pivots) -> Iterator[tuple[tuple[str, str], Array]]:
    """Every pair of names, with its vector."""
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
