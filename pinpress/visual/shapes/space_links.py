"""Plain shapes of the links of a linkage in space: rods and plates between bushes and balls on the axes of their bearings.

A guide is a rod with a sleeve on it. A slide has a block of its mass below its sleeve, and a bolster below the end of its travel.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ...common.quantities import Array
from ...linkage.writing import STEEL
from .ballast import EVERYWHERE, ball, besides, outside, slide_block
from .bearing_layout import BearingLayout, PlacedBearing, tree
from .solids import Box, Cylinder, MadeUpSolid, Sphere, rounded_plate, standing

# lengths in widths of a bar
ROD = 0.30  # radius of a rod
END = 0.5  # radius of a ball at the end of a rod
SLEEVE, SLEEVE_LENGTH = 1.5, 2.4
GUIDE = 0.38
BOLSTER, AROUND = 1.2, 0.8  # height of the bolster, and its overhang beyond the slide


def space_solids(layout: BearingLayout, link: str) -> list[MadeUpSolid]:
    """Solids of a link of a linkage in space, in world axes in the drawn pose."""
    w, nodes, ends = layout.width, layout.nodes(link), layout.ends(link)
    body = list(_body(layout, link, nodes))
    solids = list(body)
    for bearing, side in ends:
        solids += _end(bearing, side, w)
    pin = next(((bearing, side) for bearing, side in ends if bearing.kind == "pin"), None)
    if len(nodes) == 1 and link not in layout.on_frame and pin is not None:  # the link is shown as a disc of its inertia
        bearing, side = pin
        solids.append(_cylinder(bearing.points[side], bearing.axis, layout.disc_radius(link, bearing.axis, 1.4 * w), 0.5 * w))
    for bearing, side in ends:
        if bearing.kind == "guide" and bearing.on_frame[0]:
            size = _block_size(layout, bearing)
            if side == 0:
                solids += _bolster(layout, bearing, size)
            elif size is not None:
                high, wide, deep = size
                away, reach = _lowest(layout, bearing)
                solids.append(standing(Box((wide, deep, high)), bearing.points[1] + (reach + high / 2) * away, bearing.axis))
    if len(nodes):
        solids += _counterweights(layout, link, nodes, body)
    for bearing, side in ends:
        if bearing.kind == "pin" and (side == 0 or bearing.links[0] is None):
            solids.append(_cylinder(bearing.points[side], bearing.axis, 0.36 * w, 2.3 * w, steel=True))
    return solids


def _body(layout: BearingLayout, link: str, nodes: Array) -> Iterator[MadeUpSolid]:
    """A plate between three places that are not on a line; otherwise rods."""
    w = layout.width
    for a, b in tree(nodes):
        yield _cylinder((a + b) / 2, b - a, ROD * w, float(np.linalg.norm(b - a)))
    for node in nodes:
        yield standing(Sphere(END * w), node)
    if len(nodes) == 3 and link not in layout.on_frame:
        normal = np.cross(nodes[1] - nodes[0], nodes[2] - nodes[0])
        longest = max(float(np.linalg.norm(nodes[i] - nodes[j])) for i, j in ((0, 1), (0, 2), (1, 2)))
        if np.linalg.norm(normal) > w * longest:
            middle = nodes.mean(axis=0)
            flat = standing(Sphere(w), middle, normal).placement
            inside = (nodes - middle) @ flat[:3, :2]
            yield MadeUpSolid(rounded_plate(inside, np.full(3, END * w), 0.36 * w), flat)


def _counterweights(layout: BearingLayout, link: str, nodes: Array, body: list[MadeUpSolid]) -> Iterator[MadeUpSolid]:
    """Balls of steel: an added counterweight, and if the centre of mass is outside the bearings, a weight that explains this."""
    w, mass = layout.width, layout.masses.get(link)
    weights = [layout.added[link]] if link in layout.added else []
    guided = any(bearing.kind == "guide" for bearing, _ in layout.ends(link))
    if mass is not None and not guided and len(nodes) > 1 and outside(mass.centre, nodes, EVERYWHERE) > 2.0 * w:
        weights.append(besides(mass, body))
    for weight in weights:
        nearest = min(nodes, key=lambda node: float(np.linalg.norm(node - weight.centre)))
        way = weight.centre - nearest
        yield MadeUpSolid(ball(weight.mass), standing(Sphere(w), weight.centre).placement, darker=True)
        if np.linalg.norm(way) > 0:
            yield _cylinder(nearest + way / 2, way, ROD * w, float(np.linalg.norm(way)))


def _lowest(layout: BearingLayout, guide: PlacedBearing) -> tuple[Array, float]:
    """The direction along a guide away from the linkage, and the end of the guided link in this direction, from the guide's point [m]."""
    pivots = [bearing.points[0] for bearing in layout.bearings if bearing.kind != "guide" and any(bearing.on_frame)]
    ahead = float((guide.points[1] - np.mean(pivots, axis=0)) @ guide.axis) if pivots else 0.0
    if abs(ahead) < layout.width and layout.upwards is not None:
        ahead = -float(guide.axis @ layout.upwards)
    away = math.copysign(1.0, ahead) * guide.axis
    link = guide.links[1]
    nodes = guide.points[1:] if link is None else layout.nodes(link)
    return away, max(float(((nodes - guide.points[1]) @ away).max()), SLEEVE_LENGTH / 2 * layout.width)


def _block_size(layout: BearingLayout, guide: PlacedBearing) -> tuple[float, float, float] | None:
    """Height, width and depth of the block of a slide's mass; None if the slide is not much heavier than its sleeve."""
    w, body = layout.width, layout.masses.get(guide.links[1] or "")
    sleeve = SLEEVE**2 * SLEEVE_LENGTH * w**3
    if body is None or body.mass < 1.5 * STEEL * sleeve:
        return None
    return slide_block(body.mass - STEEL * sleeve, SLEEVE * w, SLEEVE * w, layout.size)


def _bolster(layout: BearingLayout, guide: PlacedBearing, block: tuple[float, float, float] | None) -> Iterator[MadeUpSolid]:
    """The bolster below the slide, at the end of its guide; ``block``: height, width and depth of the slide's block."""
    if guide.links[1] is None or guide.links[1] != layout.slide:
        return
    w = layout.width
    high, wide, deep = (0.0, SLEEVE * w, SLEEVE * w) if block is None else block
    away, reach = _lowest(layout, guide)
    travel = max(float(at * guide.axis @ away) for at in guide.travel)
    stroke = guide.travel[1] - guide.travel[0]
    table = guide.points[0] + (reach + high + travel + 0.5 * w + 0.12 * stroke) * away  # below the slide's lowest position
    end = guide.points[0] + travel * away
    yield _cylinder((table + end) / 2, away, GUIDE * w, float(np.linalg.norm(table - end)))
    yield standing(Box((wide + 2 * AROUND * w, deep + 2 * AROUND * w, BOLSTER * w)), table + BOLSTER * w / 2 * away, guide.axis)


def _end(bearing: PlacedBearing, side: int, w: float) -> Iterator[MadeUpSolid]:
    """The solid of a link at a bearing."""
    point, axis = bearing.points[side], bearing.axis
    if bearing.kind == "pin":
        radius, length = ((0.62, 1.7), (0.80, 1.1))[side]  # the outer bush is shorter, so that both bushes and the pin are visible
        yield _cylinder(point, axis, radius * w, length * w)
    elif bearing.kind == "ball":
        yield standing(Sphere((0.95, 0.72)[side] * w), point)
    elif bearing.kind == "guide" and side == 1:
        yield standing(Box((SLEEVE * w, SLEEVE * w, SLEEVE_LENGTH * w)), point, axis)
    elif bearing.kind == "guide":
        low, high = bearing.travel
        yield _cylinder(point + (low + high) / 2 * axis, axis, GUIDE * w, high - low + 1.5 * SLEEVE_LENGTH * w)


def _cylinder(centre: Array, along: Array, radius: float, length: float, steel: bool = False) -> MadeUpSolid:
    return standing(Cylinder(radius, length), centre, along, steel=steel)
