"""Plain shapes for links without visuals, made up from their bearings: bars, pins, blocks and rails of a planar linkage, in layers, and in
space rods between bushes on the axes of the bearings. There guides are rods with a sleeve on them.
"""

from collections.abc import Collection, Iterator

import numpy as np

from ...common.quantities import Array
from ...linkage.linkage import Linkage
from .bearing_layout import Bearing, BearingLayout, lay_out_bearings, tree
from .planar_stand_ins import layered_solids
from .solids import Box, Cylinder, Part, Shape, Solid, Sphere, part

Colour = tuple[float, float, float]

FRAME: Colour = (0.44, 0.48, 0.53)
STEEL: Colour = (0.90, 0.91, 0.92)  # of pins
COLOURS: tuple[Colour, ...] = (  # of links, in document order: red-orange, blue, green, amber, violet, teal, pink, brown
    (0.86, 0.30, 0.18),
    (0.16, 0.44, 0.75),
    (0.18, 0.60, 0.38),
    (0.93, 0.70, 0.13),
    (0.56, 0.36, 0.66),
    (0.10, 0.62, 0.66),
    (0.85, 0.42, 0.60),
    (0.58, 0.40, 0.24),
)
DARKER = 0.68  # every further round of colours

# Of rods, beside the width of a bar. Where two links meet, the outer bush is the shorter one, so that both are seen, and the pin in them.
ROD = 0.30  # radius
BUSHES = ((0.62, 1.7), (0.80, 1.1))  # radius and length: of the parent's or link1's, of the other's
PIN, PIN_LENGTH = 0.36, 2.3
BALLS = (0.95, 0.72)
END = 0.5
DISC = 1.4  # least radius
SLEEVE, SLEEVE_LENGTH = 1.5, 2.4
GUIDE = 0.38


def plain_parts(press: Linkage, travel: Array, drawn: Collection[str]) -> dict[str, tuple[Part, ...]]:
    """Parts of the links that need plain shapes, by their names; none for a link that has no bearing of its own.

    Args:
        press: the linkage.
        travel: (2, nv) lowest and highest positions of the joints [rad or m].
        drawn: links that have visuals.
    """
    layout = lay_out_bearings(press, travel, drawn)
    solids = _rod_solids(layout) if layout.normal is None else layered_solids(layout, layout.normal)
    moving = (link for link in press.links if link not in layout.on_frame)
    colours = dict.fromkeys(layout.on_frame, FRAME) | dict(zip(moving, _colours(), strict=False))
    parts: dict[str, tuple[Part, ...]] = {}
    for link, made in solids.items():
        into = np.linalg.inv(layout.placements[link])
        parts[link] = tuple(part(solid.shape, into @ solid.placement, (*(STEEL if solid.steel else colours[link]), 1.0)) for solid in made)
    return parts


def _colours() -> Iterator[Colour]:
    shade = 1.0
    while True:
        yield from ((shade * red, shade * green, shade * blue) for red, green, blue in COLOURS)
        shade *= DARKER


def _rod_solids(layout: BearingLayout) -> dict[str, list[Solid]]:
    """Solids of the links of a linkage in space, in world axes in the drawn pose."""
    return {link: list(_rods(layout, link)) for link in layout.links}


def _rods(layout: BearingLayout, link: str) -> Iterator[Solid]:
    w, nodes, ends = layout.width, layout.nodes(link), layout.ends(link)
    for a, b in tree(nodes):
        yield _cylinder((a + b) / 2, b - a, ROD * w, float(np.linalg.norm(b - a)))
    for node in nodes:
        yield _solid(Sphere(END * w), node)
    for bearing, side in ends:
        yield from _end(bearing, side, w)
    if len(nodes) == 1 and link not in layout.on_frame:
        yield from _disc(layout, link, ends)
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


def _disc(layout: BearingLayout, link: str, ends: list[tuple[Bearing, int]]) -> Iterator[Solid]:
    """Of a link that goes nowhere: about its pin, with its inertia, within reason."""
    w, pin = layout.width, next(((b, side) for b, side in ends if b.kind == "pin"), None)
    if pin is None:
        return
    bearing, side = pin
    yield _cylinder(bearing.points[side], bearing.axis, layout.disc_radius(link, bearing.axis, DISC * w), 0.5 * w)


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
