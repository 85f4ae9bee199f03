"""Plain shapes of the links of a planar linkage, made up from their bearings and masses.

Links are bars, plates, webs, discs and blocks. Each link has a separate layer along the normal, so that links can pass each other. From
back to front the layers are: the frame, links on pins of the frame, other links, and slides in their gibs. Lengths are true, except for the
offsets of the layers along the normal, which are near the true heights of the links.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property

import numpy as np

from ...common.quantities import Array
from ...linkage.writing import STEEL
from .ballast import besides, outside, plane_counterweight, slide_block
from .bearing_layout import Ballast, BearingLayout, PlacedBearing, tree
from .solids import Box, Cylinder, MadeUpSolid, Plate, rounded_plate

# lengths in widths of a bar
THICKNESS = 0.5
EYE, EYE_LENGTH = 0.72, 0.62  # radius and length of a bar's eye
DISC = 1.25  # least radius of a disc
WEB_END = 0.85  # radius of a crank's web about its crank pin
BLOCK = 1.15  # distance from the outermost bearing of a slide to the end of its block along the guide
COLLAR = 2.4  # length of a collar


class PlanarLinks:
    """A planar linkage with its links in layers.

    Attributes:
        layout: bearings and masses in the drawn pose.
        normal: (3,) normal of the linkage, towards the viewer.
        width: width of a bar [m].
        down: (3,) unit vector in the plane that points as far down as possible.
    """

    def __init__(self, layout: BearingLayout, normal: Array) -> None:
        self.layout, self.normal, self.width = layout, normal, layout.width
        down = np.array([0.0, 0.0, -1.0]) if abs(normal[2]) < 0.9 else np.array([0.0, -1.0, 0.0])
        self.down = down - (down @ normal) * normal
        self.down /= np.linalg.norm(self.down)
        self.moving = [link for link in layout.links if link not in layout.on_frame]
        self._nodes = {link: layout.nodes(link) for link in layout.links}
        self._collars = {
            link: bearing
            for link in self.moving
            for bearing, side in layout.ends(link)
            if bearing.kind == "guide" and side == 1 and not bearing.on_frame[0]
        }
        own = sorted((link for link in self.moving if not self._rides(link)), key=self._rank)
        middle = (len(own) - 1) / 2
        offsets = {link: (k - middle) * 0.85 * self.width for k, link in enumerate(own)}
        self._offsets = {link: offsets[self._carrier(link)] for link in self.moving}

    def link(self, link: str) -> list[MadeUpSolid]:
        """Solids of a moving link, in world axes in the drawn pose: its body, counterweight and pins."""
        return [*self._bodies[link], *self.pins(link)]

    @cached_property
    def _bodies(self) -> dict[str, list[MadeUpSolid]]:
        """Solids of moving links without their pins."""
        solids = {}
        for link in self.moving:
            body = list(self._body(link))
            solids[link] = body + list(self._counterweights(link, body))
        return solids

    # Layers

    def _rides(self, link: str) -> bool:
        """Whether a link is only a collar on another link; then both share a layer."""
        return link in self._collars and len(self._nodes[link]) == 1 and self._collars[link].links[0] is not None

    def _carrier(self, link: str) -> str:
        while self._rides(link):
            link = str(self._collars[link].links[0])
        return link

    def _rank(self, link: str) -> int:
        """Order of the layers: links on pins of the frame are behind, links in its guides are in front."""
        kinds = {bearing.kind for bearing, side in self.layout.ends(link) if bearing.on_frame[1 - side]}
        return 2 if "guide" in kinds else 0 if "pin" in kinds else 1

    def guide(self, link: str) -> PlacedBearing | None:
        """The guide between a link and the frame."""
        return next((b for b, side in self.layout.ends(link) if b.kind == "guide" and side == 1 and b.on_frame[0]), None)

    @cached_property
    def back(self) -> float:
        """Height of the middle of the frame along the normal, behind all moving links [m]."""
        depths = [self.depth(solid)[0] for solids in self._bodies.values() for solid in solids]
        true = [float(point @ self.normal) for bearing in self.layout.bearings for point in bearing.points]
        return min([*depths, *true]) - 0.68 * self.width

    def depth(self, solid: MadeUpSolid) -> tuple[float, float]:
        """Lowest and highest point of a solid along the normal [m]."""
        shape, middle = solid.shape, float(solid.placement[:3, 3] @ self.normal)
        half = shape.size[2] / 2 if isinstance(shape, Box) else shape.thickness / 2 if isinstance(shape, Plate) else 0.0
        half = shape.length / 2 if isinstance(shape, Cylinder) else half
        return middle - half, middle + half

    def height(self, bearing: PlacedBearing, side: int) -> float:
        """Height at which a link meets its bearing; the true height if the link has visuals."""
        link, height = bearing.links[side], float(bearing.points[side] @ self.normal)
        if link is None:
            return height
        if bearing.on_frame[side]:
            return self.back
        if self.guide(link):
            return height + self._offsets[link]
        return self._middle(link)

    def _middle(self, link: str) -> float:
        carrier = self._carrier(link)
        heights = [bearing.points[side] @ self.normal for bearing, side in self.layout.ends(carrier)]
        return float(np.mean(heights)) + self._offsets[carrier]

    # Bodies of links

    def _body(self, link: str) -> Iterator[MadeUpSolid]:
        """A bar with eyes, a plate, web or disc, or a slide; collars and the bars of guides."""
        w, nodes, guide = self.width, self._nodes[link], self.guide(link)
        if guide is not None:
            yield from self._slide(link, guide)
        elif (guide_on_link := self._collars.get(link)) is not None:  # a block around the bar, and a rod to the rest of the link
            on, size = self.height(guide_on_link, 0), (COLLAR * w, 1.9 * w, 0.92 * w)
            yield self.box(guide_on_link.points[1], guide_on_link.axis, on, size)
            if not self._rides(link):
                yield self._between(guide_on_link.points[1], on, self._middle(link), EYE * w)
        if guide is None and not self._rides(link) and len(nodes):
            yield from self._bars(link, nodes)
        for bearing, side in self.layout.ends(link):
            if bearing.kind == "guide" and side == 0 and guide is None:
                (low, high), more = self.travelled(bearing), 0.5 * COLLAR * w * bearing.axis
                yield self._bar(low - more, high + more, self.height(bearing, 0), 0.9 * w)

    def travelled(self, bearing: PlacedBearing) -> list[Array]:
        """Both ends of the travel of a guide; for other bearings the same place twice."""
        return [self.layout.flat(bearing.points[0]) + at * bearing.axis for at in bearing.travel]

    def _bars(self, link: str, nodes: Array) -> Iterator[MadeUpSolid]:
        w, height, pivot = self.width, self._middle(link), self._pivot(link)
        guides = [self.layout.flat(b.points[0]) for b, side in self.layout.ends(link) if b.kind == "guide" and side == 0]
        others = [self.layout.flat(b.points[side]) for b, side in self.layout.ends(link) if b.kind != "guide" or side == 1]
        reach = max(float(np.linalg.norm(node - pivot)) for node in nodes)
        if self._hangs(link):
            nodes = nodes[:1]  # the other node is the centre of mass, which the counterweight shows
        elif reach < 1.5 * w and link not in self._collars:  # a compact link is a disc
            disc = self.layout.disc_radius(link, self.normal, DISC * w) if len(nodes) == 1 else DISC * w
            radius = max(reach + 0.9 * w, disc)
            yield self.cylinder(pivot, height, radius, THICKNESS * w)
            if len(nodes) == 1:  # so that its rotation is visible
                yield self.cylinder(pivot + 0.7 * radius * self.down, height, 0.14 * radius, EYE_LENGTH * w, steel=True)
        elif link in self.layout.cranks and not guides and len(nodes) == 2:
            yield self._web(link, pivot, reach, nodes)
        elif len(nodes) > 2 and not guides and link not in self._collars:
            yield self._plate(nodes, np.full(len(nodes), EYE * w), height)
        else:
            for a, b in tree(nodes):
                yield self._bar(a, b, height, w)
        for node in nodes:
            if self._near(node, guides) and not self._near(node, others):
                continue  # the bar continues at a weld, so it has no eye there
            yield self.cylinder(node, height, EYE * w, EYE_LENGTH * w)

    def _near(self, node: Array, points: list[Array]) -> bool:
        return any(np.linalg.norm(node - point) < 1e-3 * self.width for point in points)

    def _pivot(self, link: str) -> Array:
        """The place about which a link turns on its parent; without such a place, its first place."""
        ends = self.layout.ends(link)
        at = next((b.points[1] for b, side in ends if side == 1 and b.kind == "pin"), None)
        return self._nodes[link][0] if at is None else self.layout.flat(at)

    def _web(self, link: str, pivot: Array, reach: float, nodes: Array) -> MadeUpSolid:
        """A crank: a disc about its shaft, if a disc that contains the crank pin has the same inertia; otherwise a web."""
        w, height, body = self.width, self._middle(link), self.layout.masses.get(link)
        if body is not None:
            away = self.layout.flat(body.centre) - pivot
            radius = math.sqrt(2 * max(float(self.normal @ body.gyration @ self.normal + away @ away), 0.0))
            if radius > reach + WEB_END * w:
                return self.cylinder(pivot, height, min(radius, reach + 2.5 * w), THICKNESS * w)
        near = np.linalg.norm(nodes - pivot, axis=1) < 1e-3 * w
        return self._plate(nodes, np.where(near, 1.2, WEB_END) * w, height)

    def _plate(self, nodes: Array, radii: Array, height: float) -> MadeUpSolid:
        """The convex plate around circles in the plane."""
        middle = nodes.mean(axis=0)
        along = nodes[np.argmax(np.linalg.norm(nodes - nodes[0], axis=1))] - nodes[0]
        along /= np.linalg.norm(along)
        inside = (nodes - middle) @ np.array([along, np.cross(self.normal, along)]).T
        return MadeUpSolid(rounded_plate(inside, radii, THICKNESS * self.width), self._placed(middle, along, height))

    # Slides and collars

    def _slide(self, link: str, guide: PlacedBearing) -> Iterator[MadeUpSolid]:
        """A block that contains all bearings of the link, and a block of its mass on the side away from the linkage."""
        (low, high), across = self._holding(link, guide)
        sideways = (across[0] + across[1]) / 2 * self.across(guide)
        heights = [self.height(bearing, side) for bearing, side in self.layout.ends(link)]
        middle, thick = (max(heights) + min(heights)) / 2, np.ptp(heights) + THICKNESS * self.width
        yield self.box(guide.points[1] + (low + high) / 2 * guide.axis + sideways, guide.axis, middle, (high - low, np.ptp(across), thick))
        if (block := self._block(link, guide)) is not None:
            size, at = block
            yield self.box(guide.points[1] + at * guide.axis + sideways, guide.axis, middle, size)

    def _block(self, link: str, guide: PlacedBearing) -> tuple[tuple[float, float, float], float] | None:
        """Size of the block of a slide's mass along the guide, across it and along the normal, and its place along the guide [m]; None if
        the block with the bearings already has about this mass."""
        (low, high), across = self._holding(link, guide)
        heights = [self.height(bearing, side) for bearing, side in self.layout.ends(link)]
        wide, thick = float(np.ptp(across)), float(np.ptp(heights)) + THICKNESS * self.width
        own = (high - low) * wide * thick
        body = self.layout.masses.get(link)
        if body is None or not (mass := body.mass - STEEL * own) > 0.2 * STEEL * own:
            return None
        size = slide_block(mass, wide, thick, self.layout.size)
        side = self.away(link, guide)
        end = high if side > 0 else low
        return size, float(end + side * (size[0] / 2 - 0.3 * self.width))

    def away(self, link: str, guide: PlacedBearing) -> float:
        """1 if the rest of the linkage is behind a guided link along its guide's axis, -1 if it is in front."""
        joined = [b.points[side] for b, side in self.layout.ends(link) if b is not guide]
        pivots = [b.points[0] for b in self.layout.bearings if b.kind != "guide" and any(b.on_frame)]
        if pivots:
            ahead = float((np.mean([guide.points[1], *joined], axis=0) - np.mean(pivots, axis=0)) @ guide.axis)
            if abs(ahead) > self.width:
                return math.copysign(1.0, ahead)
        upwards = -self.down if self.layout.upwards is None else self.layout.upwards
        return -1.0 if guide.axis @ upwards >= 0 else 1.0

    def across(self, guide: PlacedBearing) -> Array:
        """(3,) unit vector across a guide in the plane."""
        return np.cross(self.normal, guide.axis)

    def extent(self, link: str | None, guide: PlacedBearing) -> tuple[Array, Array]:
        """(2,) ends of all blocks of a guided link along its guide, and (2,) across it, from the guide's point [m]."""
        along, across = self._holding(link, guide)
        block = None if link is None else self._block(link, guide)
        if block is None:
            return along, across
        (high, wide, _), at = block
        middle = float(across.mean())
        ends = min(along[0], at - high / 2), max(along[1], at + high / 2)
        return np.array(ends), np.array([min(across[0], middle - wide / 2), max(across[1], middle + wide / 2)])

    def _holding(self, link: str | None, guide: PlacedBearing) -> tuple[Array, Array]:
        """(2,) ends of the block that contains all bearings of a link along its guide, and (2,) across it, from the guide's point [m]."""
        nodes = [self.layout.flat(guide.points[1])]
        if link is not None:
            nodes += [
                *self._nodes[link],
                *(end for carried, side in self.layout.ends(link) if side == 0 for end in self.travelled(carried)),
            ]
        w, places = self.width, (np.array(nodes) - guide.points[1]) @ np.array([guide.axis, self.across(guide)]).T
        (low, left), (high, right) = places.min(axis=0), places.max(axis=0)
        wider = max(1.45 * w, 0.3 * (high - low))
        return np.array([low - BLOCK * w, high + BLOCK * w]), np.array([left - wider, right + wider])

    # Counterweights and pins

    def _counterweights(self, link: str, body: list[MadeUpSolid]) -> Iterator[MadeUpSolid]:
        """An added counterweight; if the centre of mass is outside the pins, also a steel solid that explains this."""
        weights = [self.layout.added[link]] if link in self.layout.added else []
        mass = self.layout.masses.get(link)
        if mass is not None and self.guide(link) is None and link not in self._collars:
            if self._hangs(link):
                weights.append(Ballast(mass.mass, mass.centre))
            elif outside(self.layout.flat(mass.centre), self._places(link), self._directions) > self.width:
                weights.append(besides(mass, body))
        for weight in weights:
            yield from self._counterweight(link, weight)

    def _counterweight(self, link: str, weight: Ballast) -> Iterator[MadeUpSolid]:
        pivot, centre = self._pivot(link), self.layout.flat(weight.centre)
        arm = float(np.linalg.norm(centre - pivot))
        shape, thickness = plane_counterweight(weight.mass, arm, self.width, link in self.layout.cranks)
        height = self._middle(link) + ((THICKNESS - 0.06) * self.width - thickness) / 2  # nearly flush: links pass in front
        along = (centre - pivot) / arm if arm > 0 else self.down
        yield MadeUpSolid(shape, self._placed(pivot if isinstance(shape, Plate) else centre, along, height), darker=True)
        nearest = min(self._places(link), key=lambda place: float(np.linalg.norm(place - centre)))
        if isinstance(shape, Cylinder) and np.linalg.norm(centre - nearest) > shape.radius:
            yield self._bar(nearest, centre, self._middle(link), self.width)

    def _hangs(self, link: str) -> bool:
        """Whether a link has all its bearings in one place, and its centre of mass elsewhere."""
        return (
            link not in self.layout.welded
            and len(self._nodes[link]) > 1
            and bool(np.ptp(self._places(link), axis=0).max() < 1e-3 * self.width)
        )

    def _places(self, link: str) -> Array:
        """(k, 3) places of the bearings of a link in the plane."""
        return np.array([self.layout.flat(bearing.points[side]) for bearing, side in self.layout.ends(link)])

    @cached_property
    def _directions(self) -> Array:
        """(d, 3) directions in the plane."""
        angle = np.linspace(0.0, 2 * math.pi, 72, endpoint=False)
        return np.asarray(np.outer(np.cos(angle), self.down) + np.outer(np.sin(angle), np.cross(self.normal, self.down)))

    def pins(self, link: str) -> Iterator[MadeUpSolid]:
        """Pins of a link: those of which it is the parent."""
        for bearing, side in self.layout.ends(link):
            if bearing.kind == "pin" and (side == 0 or bearing.links[0] is None):
                heights = sorted((self.height(bearing, 0), self.height(bearing, 1)))
                stub = 0.42 * self.width
                yield self._between(bearing.points[side], heights[0] - stub, heights[1] + stub, 0.34 * self.width, steel=True)

    # Solids

    def _bar(self, a: Array, b: Array, height: float, width: float) -> MadeUpSolid:
        length = float(np.linalg.norm(b - a))
        return self.box((a + b) / 2, (b - a) / length, height, (length, width, THICKNESS * self.width))

    def box(self, centre: Array, along: Array, height: float, size: tuple[float, float, float]) -> MadeUpSolid:
        """A box with its sides along a direction in the plane, across it, and along the normal."""
        return MadeUpSolid(Box((float(size[0]), float(size[1]), float(size[2]))), self._placed(centre, along, height))

    def cylinder(self, centre: Array, height: float, radius: float, length: float, steel: bool = False) -> MadeUpSolid:
        """A cylinder along the normal."""
        return MadeUpSolid(Cylinder(radius, length), self._placed(centre, self.down, height), steel)

    def _between(self, centre: Array, low: float, high: float, radius: float, steel: bool = False) -> MadeUpSolid:
        return self.cylinder(centre, (low + high) / 2, radius, abs(high - low), steel)

    def _placed(self, centre: Array, along: Array, height: float) -> Array:
        placement = np.eye(4)
        placement[:3, 0], placement[:3, 1], placement[:3, 2] = along, np.cross(self.normal, along), self.normal
        placement[:3, 3] = self.layout.flat(centre) + height * self.normal
        return placement
