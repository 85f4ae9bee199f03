"""Plain shapes of the frame of a planar linkage: a press's columns, beams, gibs, bed and bolster, or pedestals if no link is guided.

The frame is behind all moving links, so it hides none of them. Its columns are parallel to the slide's guide, in any direction of the
guide; beams connect them to the pivots. The bolster is below the end of the slide's travel, where the slide presses.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...common.quantities import Array
from .bearing_layout import PlacedBearing
from .planar_links import PlanarLinks
from .solids import MadeUpSolid

# lengths in widths of a bar
RAIL, RAIL_DEPTH = 0.7, 0.9  # width and depth of a gib
BRACKET = 0.9  # length of the brackets at the ends of a gib, along the gib
COLUMN, BEAM, DEPTH = 1.8, 1.4, 0.9  # widths in the plane, and depth along the normal
SAME_BEAM = 1.2  # pivots with a smaller distance along the guide share a beam
BOLSTER, BED = 0.8, 2.2  # heights of bolster and bed
AROUND = 0.4  # overhang of the bolster beyond the slide, and of the bed beyond the bolster


def frame_solids(links: PlanarLinks, frame: str) -> list[MadeUpSolid]:
    """Solids of a link that is the frame or fixed to it, in world axes in the drawn pose, with its pins."""
    return [*_Frame(links, frame).solids(), *links.pins(frame)]


@dataclass(frozen=True)
class _Span:
    """Both ends of a solid along a direction [m]."""

    low: float
    high: float

    @property
    def middle(self) -> float:
        return (self.low + self.high) / 2

    @property
    def length(self) -> float:
        return self.high - self.low


class _Frame:
    """The frame, or a link that is fixed to it."""

    def __init__(self, links: PlanarLinks, frame: str) -> None:
        self.links, self.layout, self.width = links, links.layout, links.width
        ends = self.layout.ends(frame)
        self.guides = [bearing for bearing, side in ends if bearing.kind == "guide" and side == 0]
        self.pivots = [self.layout.flat(bearing.points[side]) for bearing, side in ends if bearing.kind != "guide"]
        slide = (guide for guide in self.guides if guide.links[1] is not None and guide.links[1] == self.layout.slide)
        self.main = next(slide, self.guides[0] if self.guides else None)

    def solids(self) -> Iterator[MadeUpSolid]:
        for at in self.pivots:
            yield self.links.cylinder(at, self.links.back, self.width, 1.2 * self.width)
        for guide in self.guides:
            yield from self._gibs(guide)
        yield from self._pedestals() if self.main is None else self._press(self.main)

    def _pedestals(self) -> Iterator[MadeUpSolid]:
        w, down, back = self.width, self.links.down, self.links.back
        for at in self.pivots:
            yield self.links.box(at + 1.0 * w * down, down, back, (2.0 * w, 1.7 * w, 0.6 * w))
            yield self.links.box(at + 2.1 * w * down, down, back, (0.5 * w, 3.6 * w, 0.9 * w))

    # Gibs

    def _gibs(self, guide: PlacedBearing) -> Iterator[MadeUpSolid]:
        """Rails on both sides of a guided link over its whole travel, and brackets at their ends."""
        w, back, height = self.width, self.links.back, self.links.height(guide, 1)
        along = self._swept(guide)
        for place in self._sides(guide):
            yield self.links.box(place + along.middle * guide.axis, guide.axis, height, (along.length, RAIL * w, RAIL_DEPTH * w))
            deep = height - RAIL_DEPTH * w / 2 - back
            for end in (along.low + BRACKET * w / 2, along.high - BRACKET * w / 2):
                if deep > 0:
                    yield self.links.box(place + end * guide.axis, guide.axis, back + deep / 2, (BRACKET * w, RAIL * w, deep))

    def _swept(self, guide: PlacedBearing) -> _Span:
        """Span that a guided link sweeps along its guide, from the guide's point on the frame."""
        (low, high), _ = self.links.extent(guide.links[1], guide)
        return _Span(float(low + guide.travel[0]), float(high + guide.travel[1]))

    def _sides(self, guide: PlacedBearing) -> list[Array]:
        """Middles of both gibs across the guide."""
        _, across = self.links.extent(guide.links[1], guide)
        away = (RAIL / 2 + 0.1) * self.width
        return [guide.points[0] + (edge + side * away) * self.links.across(guide) for side, edge in zip((-1, 1), across, strict=True)]

    # Columns, beams and bed of a press. Places in its plane are measured along `right` and along `up`, from bed to crown.

    def _press(self, main: PlacedBearing) -> Iterator[MadeUpSolid]:
        w, back = self.width, self.links.back
        side = 1.0 if main.links[1] is None else self.links.away(main.links[1], main)
        up = -side * main.axis
        right = np.cross(up, self.links.normal)
        parallel = [guide for guide in self.guides if abs(guide.axis @ up) > 1 - 1e-6]
        sides = np.array([place @ right for guide in parallel for place in self._sides(guide)])
        columns = _Span(float(sides.min()), float(sides.max()))
        ends = [self._along(guide, up) for guide in parallel]
        levels = sorted(float(at @ up) for at in self.pivots)
        bed = self._bed(main, up, right, columns)
        low = min([span.low for span in ends] + [level - BEAM * w / 2 for level in levels] + ([] if bed is None else [bed[0]]))
        high = max([span.high for span in ends] + [level + BEAM * w / 2 for level in levels])

        def box(across: _Span, along: _Span, height: float, depth: float) -> MadeUpSolid:
            return self.links.box(across.middle * right + along.middle * up, up, height, (along.length, across.length, depth))

        for at in (columns.low, columns.high):
            yield box(_Span(at - COLUMN * w / 2, at + COLUMN * w / 2), _Span(low, high), back, DEPTH * w)
        for along, across in self._beams(up, right, columns, high):
            yield box(across, along, back, 0.9 * DEPTH * w)
        if bed is not None:
            yield from bed[1]

    def _along(self, guide: PlacedBearing, up: Array) -> _Span:
        """Span that a guided link sweeps, measured upwards."""
        swept, start, sense = self._swept(guide), float(guide.points[0] @ up), float(np.sign(guide.axis @ up))
        return _Span(*sorted((start + sense * swept.low, start + sense * swept.high)))

    def _beams(self, up: Array, right: Array, columns: _Span, high: float) -> Iterator[tuple[_Span, _Span]]:
        """Spans of the beams along and across the guide. The beams connect the columns and reach all pivots. The highest beam is the
        crown."""
        w = self.width
        groups: list[list[tuple[float, float]]] = []
        for level, across in sorted((float(at @ up), float(at @ right)) for at in self.pivots):
            if groups and level - groups[-1][0][0] < SAME_BEAM * w:
                groups[-1].append((level, across))
            else:
                groups.append([(level, across)])
        if not groups or groups[-1][-1][0] < high - SAME_BEAM * w:
            groups.append([(high - BEAM * w / 2, columns.middle)])
        for group in groups:
            levels, places = [level for level, _ in group], [across for _, across in group]
            along = _Span(min(levels) - BEAM * w / 2, max(levels) + BEAM * w / 2)
            yield along, _Span(min([columns.low, *places]) - COLUMN * w / 2, max([columns.high, *places]) + COLUMN * w / 2)

    def _bed(self, main: PlacedBearing, up: Array, right: Array, columns: _Span) -> tuple[float, list[MadeUpSolid]] | None:
        """The bed's lowest point, the bolster and the bed; None if the slide presses towards the linkage, or a pivot is in the way."""
        w, slide, upwards = self.width, main.links[1], self.layout.upwards
        if slide is None or slide != self.layout.slide or upwards is None or (up @ upwards < 0 and abs(upwards[2]) > 0.5):
            return None
        stroke = main.travel[1] - main.travel[0]
        table = self._along(main, up).low - 0.5 * w - 0.12 * stroke
        middle, half = columns.middle, columns.length / 2 + COLUMN * w / 2
        if any(at @ up < table + BEAM * w and abs(at @ right - middle) < half + w for at in self.pivots):
            return None
        blocks = [self.links.depth(solid) for solid in self.links.link(slide) if not solid.steel]
        back, front = self.links.back - DEPTH * w / 2, max(high for _, high in blocks) + AROUND * w
        behind = min(low for low, _ in blocks)

        def box(half_width: float, top: float, high: float, behind: float, front: float) -> MadeUpSolid:
            at, size = middle * right + (top - high / 2) * up, (high, 2 * half_width, front - behind)
            return self.links.box(at, up, (front + behind) / 2, size)

        bolster = box(columns.length / 2 - RAIL * w / 2, table, BOLSTER * w, behind, front)
        bed = box(half, table - BOLSTER * w, BED * w, back, front + AROUND * w)
        return table - (BOLSTER + BED) * w, [bolster, bed]
