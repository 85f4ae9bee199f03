"""Plain shapes for links without visuals, made up from their bearings.

Links of a planar linkage are bars, discs and blocks, each in a layer of its own along the normal, so that they pass each other. The frame
stands behind, then come the links that it carries on pins, then the others, and in front the slides in their rails. Lengths are true,
except for the offsets of the layers along the normal; these are about the true heights of the links.

Links of a linkage in space are rods between bushes on the axes of their bearings; guides are rods with a sleeve on them.
"""

from collections.abc import Collection, Iterator

import numpy as np

from ...common.quantities import Array
from ...linkage.linkage import Linkage
from .bearing_layout import BearingLayout, PlacedBearing, lay_out_bearings, tree
from .solids import Box, Cylinder, MadeUpSolid, Part, Shape, Sphere, part

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
DARKER = 0.68  # factor of every further round of colours

# Of planar links, in widths of a bar.
THICKNESS = 0.5
LAYER = 0.85
EYE, EYE_LENGTH = 0.72, 0.62  # radius and length
PIN, STUB = 0.34, 0.42  # radius, and how far it stands out of the middle of the outermost link
DISC = 1.25  # least radius
COMPACT = 1.5  # a link shorter than this is a disc
BLOCK, BLOCK_WIDTH = 1.15, 1.45  # distance of its outermost place from its ends along the guide, and across
BLOCK_SHAPE = 0.3  # half the least width of a long block, as a share of its length
COLLAR, COLLAR_WIDTH, COLLAR_THICKNESS = 2.4, 1.9, 0.92
RAIL, CLEARANCE = 0.7, 0.1

# Of links in space, in widths of a bar. Where two links meet, the outer bush is the shorter one, so that both are seen, and the pin too.
ROD = 0.30  # radius
BUSHES = ((0.62, 1.7), (0.80, 1.1))  # radius and length: of the parent's or link1's, of the other's
ROD_PIN, ROD_PIN_LENGTH = 0.36, 2.3
BALLS = (0.95, 0.72)
END = 0.5
ROD_DISC = 1.4  # least radius
SLEEVE, SLEEVE_LENGTH = 1.5, 2.4
GUIDE = 0.38


def plain_parts(press: Linkage, travel: Array, drawn: Collection[str]) -> dict[str, tuple[Part, ...]]:
    """Parts of links that need plain shapes, by the links' names; none for a link that has no bearing of its own.

    Args:
        press: the linkage.
        travel: (2, nv) lowest and highest positions of the joints [rad or m].
        drawn: links that have visuals.
    """
    layout = lay_out_bearings(press, travel, drawn)
    solids = _rod_solids(layout) if layout.normal is None else _layered_solids(layout, layout.normal)
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


def _layered_solids(layout: BearingLayout, normal: Array) -> dict[str, list[MadeUpSolid]]:
    """Solids of the links of a planar linkage, in world axes in the drawn pose."""
    layers = _Layers(layout, normal)
    return {link: list(layers.frame(link) if link in layout.on_frame else layers.link(link)) for link in layout.links}


class _Layers:
    """A linkage with its links in layers."""

    def __init__(self, layout: BearingLayout, normal: Array) -> None:
        self.layout, self.normal, self.width = layout, normal, layout.width
        down = np.array([0.0, 0.0, -1.0]) if abs(normal[2]) < 0.9 else np.array([0.0, -1.0, 0.0])
        self.down = down - (down @ normal) * normal
        self.down /= np.linalg.norm(self.down)
        self.nodes = {link: layout.nodes(link) for link in layout.links}
        moving = [link for link in layout.links if link not in layout.on_frame]
        self.collars = {link: bearing for link in moving for bearing, side in layout.ends(link) if self._is_collar(bearing, side)}
        own = sorted((link for link in moving if not self._rides(link)), key=self._rank)
        middle = (len(own) - 1) / 2
        offsets = {link: (k - middle) * LAYER * self.width for k, link in enumerate(own)}
        self.offsets = {link: offsets[self._carrier(link)] for link in moving}
        self.back = -(middle + 1.3) * LAYER * self.width

    def _is_collar(self, bearing: PlacedBearing, side: int) -> bool:
        return bearing.kind == "guide" and side == 1 and not bearing.on_frame[0]

    def _rides(self, link: str) -> bool:
        """Whether a link is only a collar on another link, whose layer it shares."""
        return link in self.collars and len(self.nodes[link]) == 1 and self.collars[link].links[0] is not None

    def _carrier(self, link: str) -> str:
        while self._rides(link):
            link = str(self.collars[link].links[0])
        return link

    def _rank(self, link: str) -> int:
        held = {bearing.kind for bearing, side in self.layout.ends(link) if bearing.on_frame[1 - side]}
        return 2 if "guide" in held else 0 if "pin" in held else 1

    def _guide(self, link: str) -> PlacedBearing | None:
        """The guide of a link on the frame."""
        return next((b for b, side in self.layout.ends(link) if b.kind == "guide" and side == 1 and b.on_frame[0]), None)

    def _height(self, bearing: PlacedBearing, side: int) -> float:
        """Height at which a link meets its bearing; where the link has visuals, the true one."""
        link, height = bearing.links[side], float(bearing.points[side] @ self.normal)
        if link is None:
            return height
        if bearing.on_frame[side]:
            return height + self.back
        if self._guide(link):
            return height + self.offsets[link]
        return self._middle(link)

    def _middle(self, link: str) -> float:
        carrier = self._carrier(link)
        heights = [bearing.points[side] @ self.normal for bearing, side in self.layout.ends(carrier)]
        return float(np.mean(heights)) + self.offsets[carrier]

    # Moving links

    def link(self, link: str) -> Iterator[MadeUpSolid]:
        """A bar with eyes, a disc, or a block; collars; pins."""
        w, nodes, guide = self.width, self.nodes[link], self._guide(link)
        if guide is not None:
            yield self._block(link, guide)
        elif link in self.collars:
            yield from self._collar(link, self.collars[link])
        if guide is None and not self._rides(link) and len(nodes):
            yield from self._bars(link, nodes)
        for bearing, side in self.layout.ends(link):
            if bearing.kind == "guide" and side == 0 and guide is None:
                (low, high), more = self._ends(bearing), 0.5 * COLLAR * w * bearing.axis
                yield self._bar(low - more, high + more, self._height(bearing, 0), 0.9 * w)
        yield from self._pins(link)

    def _ends(self, bearing: PlacedBearing) -> list[Array]:
        """Ends of the travel of a guide; for other bearings the same place twice."""
        return [self.layout.flat(bearing.points[0]) + at * bearing.axis for at in bearing.travel]

    def _bars(self, link: str, nodes: Array) -> Iterator[MadeUpSolid]:
        w, height = self.width, self._middle(link)
        pivot = self._pivot(link)
        reach = max(float(np.linalg.norm(node - pivot)) for node in nodes)
        if reach < COMPACT * w and link not in self.collars:
            radius = max(reach + 0.9 * w, self._disc(link, nodes))
            yield self._cylinder(pivot, height, radius, THICKNESS * w)
            if len(nodes) == 1:  # so that its turning is seen
                yield self._cylinder(pivot + 0.7 * radius * self.down, height, 0.14 * radius, EYE_LENGTH * w, steel=True)
        else:
            for a, b in tree(nodes):
                yield self._bar(a, b, height, w)
        guides = [self.layout.flat(b.points[0]) for b, side in self.layout.ends(link) if b.kind == "guide" and side == 0]
        others = [self.layout.flat(b.points[side]) for b, side in self.layout.ends(link) if b.kind != "guide" or side == 1]
        for node in nodes:
            if self._near(node, guides) and not self._near(node, others):
                continue  # the bar goes on there, nothing turns
            yield self._cylinder(node, height, EYE * w, EYE_LENGTH * w)

    def _near(self, node: Array, points: list[Array]) -> bool:
        return any(np.linalg.norm(node - point) < 1e-3 * self.width for point in points)

    def _pivot(self, link: str) -> Array:
        """The place about which a link turns on its parent, else its first place."""
        ends = self.layout.ends(link)
        at = next((b.points[1] for b, side in ends if side == 1 and b.kind == "pin"), None)
        return self.nodes[link][0] if at is None else self.layout.flat(at)

    def _disc(self, link: str, nodes: Array) -> float:
        """Radius of the disc that stands for a compact link, by its inertia, within limits [m]."""
        if len(nodes) > 1:
            return DISC * self.width
        return self.layout.disc_radius(link, self.normal, DISC * self.width)

    def _block(self, link: str, guide: PlacedBearing) -> MadeUpSolid:
        """A block that holds all that the link joins."""
        (low, high), across = self._extent(link, guide)
        centre = guide.points[1] + (low + high) / 2 * guide.axis + (across[0] + across[1]) / 2 * self._across(guide)
        heights = [self._height(bearing, side) for bearing, side in self.layout.ends(link)]
        size = high - low, across[1] - across[0], np.ptp(heights) + THICKNESS * self.width
        return self._box(centre, guide.axis, (max(heights) + min(heights)) / 2, size)

    def _across(self, guide: PlacedBearing) -> Array:
        return np.cross(self.normal, guide.axis)

    def _extent(self, link: str | None, guide: PlacedBearing) -> tuple[Array, Array]:
        """(2,) ends of a block along its guide, and (2,) across it, from the guide's point [m]."""
        nodes = [self.layout.flat(guide.points[1])]
        if link is not None:
            nodes += [*self.nodes[link], *(end for carried, side in self.layout.ends(link) if side == 0 for end in self._ends(carried))]
        w, places = self.width, (np.array(nodes) - guide.points[1]) @ np.array([guide.axis, self._across(guide)]).T
        (low, left), (high, right) = places.min(axis=0), places.max(axis=0)
        wider = max(BLOCK_WIDTH * w, BLOCK_SHAPE * (high - low))
        return np.array([low - BLOCK * w, high + BLOCK * w]), np.array([left - wider, right + wider])

    def _collar(self, link: str, guide: PlacedBearing) -> Iterator[MadeUpSolid]:
        """A block about the bar on which it slides, and a rod to the rest of the link in another layer."""
        w, on = self.width, self._height(guide, 0)
        yield self._box(guide.points[1], guide.axis, on, (COLLAR * w, COLLAR_WIDTH * w, COLLAR_THICKNESS * w))
        if not self._rides(link):
            yield self._between(guide.points[1], on, self._middle(link), EYE * w)

    def _pins(self, link: str) -> Iterator[MadeUpSolid]:
        for bearing, side in self.layout.ends(link):
            if bearing.kind == "pin" and (side == 0 or bearing.links[0] is None):
                heights = sorted((self._height(bearing, 0), self._height(bearing, 1)))
                stub = STUB * self.width
                yield self._between(bearing.points[side], heights[0] - stub, heights[1] + stub, PIN * self.width, steel=True)

    # The frame

    def frame(self, link: str) -> Iterator[MadeUpSolid]:
        """Pedestals and rails."""
        w = self.width
        for bearing, side in self.layout.ends(link):
            if bearing.kind == "guide":
                yield from self._rails(bearing) if side == 0 else ()
                continue
            at, height = bearing.points[side], self._height(bearing, side)
            yield self._cylinder(at, height, 1.0 * w, 0.9 * w)
            yield self._box(at + 1.0 * w * self.down, self.down, height, (2.0 * w, 1.7 * w, 0.6 * w))
            yield self._box(at + 2.1 * w * self.down, self.down, height, (0.5 * w, 3.6 * w, 0.9 * w))
        yield from self._pins(link)

    def _rails(self, guide: PlacedBearing) -> Iterator[MadeUpSolid]:
        w, height = self.width, self._height(guide, 1)
        along, across = self._extent(guide.links[1], guide)
        low, high = along[0] + guide.travel[0], along[1] + guide.travel[1]
        for side, edge in zip((-1, 1), across, strict=True):
            place = guide.points[0] + (low + high) / 2 * guide.axis + (edge + side * (RAIL / 2 + CLEARANCE) * w) * self._across(guide)
            yield self._box(place, guide.axis, height, (high - low, RAIL * w, 0.9 * w))

    # Solids

    def _bar(self, a: Array, b: Array, height: float, width: float) -> MadeUpSolid:
        length = float(np.linalg.norm(b - a))
        return self._box((a + b) / 2, (b - a) / length, height, (length, width, THICKNESS * self.width))

    def _box(self, centre: Array, along: Array, height: float, size: tuple[float, float, float]) -> MadeUpSolid:
        """A box with its sides along a direction in the plane, across it, and along the normal."""
        return MadeUpSolid(Box((float(size[0]), float(size[1]), float(size[2]))), self._placed(centre, along, height))

    def _cylinder(self, centre: Array, height: float, radius: float, length: float, steel: bool = False) -> MadeUpSolid:
        return MadeUpSolid(Cylinder(radius, length), self._placed(centre, self.down, height), steel)

    def _between(self, centre: Array, low: float, high: float, radius: float, steel: bool = False) -> MadeUpSolid:
        return self._cylinder(centre, (low + high) / 2, radius, abs(high - low), steel)

    def _placed(self, centre: Array, along: Array, height: float) -> Array:
        placement = np.eye(4)
        placement[:3, 0], placement[:3, 1], placement[:3, 2] = along, np.cross(self.normal, along), self.normal
        placement[:3, 3] = self.layout.flat(centre) + height * self.normal
        return placement


def _rod_solids(layout: BearingLayout) -> dict[str, list[MadeUpSolid]]:
    """Solids of the links of a linkage in space, in world axes in the drawn pose."""
    return {link: list(_rods(layout, link)) for link in layout.links}


def _rods(layout: BearingLayout, link: str) -> Iterator[MadeUpSolid]:
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
            yield _cylinder(bearing.points[side], bearing.axis, ROD_PIN * w, ROD_PIN_LENGTH * w, steel=True)


def _end(bearing: PlacedBearing, side: int, w: float) -> Iterator[MadeUpSolid]:
    """The solid of a link at a bearing."""
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


def _disc(layout: BearingLayout, link: str, ends: list[tuple[PlacedBearing, int]]) -> Iterator[MadeUpSolid]:
    """The disc that stands for a link with one place, about its pin, by its inertia, within limits."""
    w, pin = layout.width, next(((b, side) for b, side in ends if b.kind == "pin"), None)
    if pin is None:
        return
    bearing, side = pin
    yield _cylinder(bearing.points[side], bearing.axis, layout.disc_radius(link, bearing.axis, ROD_DISC * w), 0.5 * w)


def _cylinder(centre: Array, along: Array, radius: float, length: float, steel: bool = False) -> MadeUpSolid:
    return _solid(Cylinder(radius, length), centre, along, steel)


def _solid(shape: Shape, centre: Array, along: Array | None = None, steel: bool = False) -> MadeUpSolid:
    """A shape with its z axis along a direction."""
    placement = np.eye(4)
    placement[:3, 3] = centre
    if along is not None:
        z = along / np.linalg.norm(along)
        x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
        x /= np.linalg.norm(x)
        placement[:3, 0], placement[:3, 1], placement[:3, 2] = x, np.cross(z, x), z
    return MadeUpSolid(shape, placement, steel)
