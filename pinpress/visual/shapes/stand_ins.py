"""Plain shapes for links without visuals: bars, pins, blocks and rails, made up from the bearings of a link."""

from collections.abc import Collection, Iterator

import numpy as np

from ...common.arrays import Array
from ...linkage.linkage import Linkage
from . import planar_stand_ins as layered_shapes
from . import spatial_stand_ins as rod_shapes
from .bearing_layout import skeleton
from .solids import Part, part

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


def plain_parts(press: Linkage, travel: Array, drawn: Collection[str]) -> dict[str, tuple[Part, ...]]:
    """Parts of the links that need plain shapes, by their names; none for a link that has no bearing of its own.

    Args:
        travel: (2, nv) lowest and highest positions of the joints [rad or m].
        drawn: links that have visuals.
    """
    found = skeleton(press, travel, drawn)
    solids = rod_shapes.solids(found) if found.normal is None else layered_shapes.solids(found, found.normal)
    moving = (link for link in press.links if link not in found.on_frame)
    colours = dict.fromkeys(found.on_frame, FRAME) | dict(zip(moving, _colours(), strict=False))
    parts: dict[str, tuple[Part, ...]] = {}
    for link, made in solids.items():
        into = np.linalg.inv(found.placements[link])
        parts[link] = tuple(part(solid.shape, into @ solid.placement, (*(STEEL if solid.steel else colours[link]), 1.0)) for solid in made)
    return parts


def _colours() -> Iterator[Colour]:
    shade = 1.0
    while True:
        yield from ((shade * red, shade * green, shade * blue) for red, green, blue in COLOURS)
        shade *= DARKER
