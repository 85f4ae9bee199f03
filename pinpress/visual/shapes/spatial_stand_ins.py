"""Links of a linkage in space as plain solids: rods between bushes on the axes of their bearings. Guides are rods with a sleeve on them."""

import math
from collections.abc import Iterator

import numpy as np

from ...common.arrays import Array
from .bearing_layout import Bearing, Skeleton, tree
from .solids import Box, Cylinder, Shape, Solid, Sphere

# All beside the width of a bar. Where two links meet, the outer bush is the shorter one, so that both are seen, and the pin in them.
ROD = 0.30  # radius
BUSHES = ((0.62, 1.7), (0.80, 1.1))  # radius and length: of the parent's or link1's, of the other's
PIN, PIN_LENGTH = 0.36, 2.3
BALLS = (0.95, 0.72)
END = 0.5
DISC = 1.4  # least radius, the largest being
LARGEST_DISC = 0.1  # of the size
SLEEVE, SLEEVE_LENGTH = 1.5, 2.4
GUIDE = 0.38


def solids(skeleton: Skeleton) -> dict[str, list[Solid]]:
    """Solids of the links, in world axes in the drawn pose."""
    return {link: list(_solids(skeleton, link)) for link in skeleton.links}


def _solids(skeleton: Skeleton, link: str) -> Iterator[Solid]:
    w, nodes, ends = skeleton.width, skeleton.nodes(link), skeleton.ends(link)
    for a, b in tree(nodes):
        yield _cylinder((a + b) / 2, b - a, ROD * w, float(np.linalg.norm(b - a)))
    for node in nodes:
        yield _solid(Sphere(END * w), node)
    for bearing, side in ends:
        yield from _end(bearing, side, w)
    if len(nodes) == 1 and link not in skeleton.on_frame:
        yield from _disc(skeleton, link, ends)
    for bearing, side in ends:
        if bearing.kind == "pin" and (side == 0 or bearing.links[0] is None):
            yield _cylinder(bearing.points[side], bearing.axis, PIN * w, PIN_LENGTH * w, steel=True)


def _end(bearing: Bearing, side: int, w: float) -> Iterator[Solid]:
    """What a link has at a bearing."""
    point, axis = bearing.points[side], bearing.axis
    if bearing.kind == "pin":
        radius, length = BUSHES[side]
        yield _cylinder(point, axis, radius * w, length * w)
    elif bearing.kind == "ball":
        yield _solid(Sphere(BALLS[side] * w), point)
    elif bearing.kind == "guide" and side == 1:
        yield _solid(Box((SLEEVE * w, SLEEVE * w, SLEEVE_LENGTH * w)), point, axis)
    elif bearing.kind == "guide":
        low, high = bearing.travel
        yield _cylinder(point + (low + high) / 2 * axis, axis, GUIDE * w, high - low + 1.5 * SLEEVE_LENGTH * w)


def _disc(skeleton: Skeleton, link: str, ends: list[tuple[Bearing, int]]) -> Iterator[Solid]:
    """Of a link that goes nowhere: about its pin, with its inertia, within reason."""
    w, pin = skeleton.width, next(((b, side) for b, side in ends if b.kind == "pin"), None)
    if pin is None:
        return
    bearing, side = pin
    radius = DISC * w
    if link in skeleton.masses:
        gyration = float(bearing.axis @ skeleton.masses[link][1] @ bearing.axis)
        radius = float(np.clip(math.sqrt(2 * max(gyration, 0.0)), radius, LARGEST_DISC * skeleton.size))
    yield _cylinder(bearing.points[side], bearing.axis, radius, 0.5 * w)


def _cylinder(centre: Array, along: Array, radius: float, length: float, steel: bool = False) -> Solid:
    return _solid(Cylinder(radius, length), centre, along, steel)


def _solid(shape: Shape, centre: Array, along: Array | None = None, steel: bool = False) -> Solid:
    """A shape with its z axis along a direction."""
    placement = np.eye(4)
    placement[:3, 3] = centre
    if along is not None:
        z = along / np.linalg.norm(along)
        x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
        x /= np.linalg.norm(x)
        placement[:3, 0], placement[:3, 1], placement[:3, 2] = x, np.cross(z, x), z
    return Solid(shape, placement, steel)
