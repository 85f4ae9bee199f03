"""Links of a pin table that stretch, with their stiffness from the sections by which the table gives their masses."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..common import plausibility
from ..common.arguments import expect, positive, typed
from ..common.errors import PinpressError
from ..elasticity.straight_beam import STEEL
from ..simulation.elastic.description import Rod
from .building import DrawnPress
from .links import STEEL as STEEL_DENSITY
from .links import Link

LIKE_STEEL = 0.05  # by which share the densities of steels differ


@typed
def rods(drawn: DrawnPress, *, modulus: float | None = None) -> list[Rod]:
    """The rods of a press, for `elasticity.Stiffness`: E A / l of every link that has a section and only two pins.

    Other links get no stiffness: those with three or more pins, links on or with a guide, driven and geared links, links that mesh, and all
    links of a press in space. The overhang beyond the pins and the eyes of a rod do not count.

    Args:
        drawn: the press of `draft`.
        modulus: modulus of elasticity of all sections [Pa]; None: that of steel.

    Raises:
        PinpressError: without a modulus, a rod has another density than steel.
    """
    expect("drawn", drawn, DrawnPress, "pin_table.draft")
    young = STEEL if modulus is None else positive("modulus", modulus, "Pa")
    plausibility.modulus(young)
    if any(pin.in_space for pin in drawn.parts.pins.values()):
        return []
    return [rod for link in drawn.parts.links for rod in _rod(drawn, link, young, modulus is None)]


def _rod(drawn: DrawnPress, link: Link, young: float, steel: bool) -> Iterator[Rod]:
    """The link as a rod; nothing if it is none."""
    tree, section = drawn.tree, link.section
    own = [bearing for bearing in (*tree.joints, *tree.loops) if link.name in (bearing.link1, bearing.link2)]
    moved = {*tree.drivers, *tree.gears, *(leader for leader, _ in tree.gears.values())}
    meshing = {body for element in drawn.parts.elements for body in element.bodies}
    at = {pin: [bearing.name for bearing in own if bearing.pin == pin] for pin in link.pins}
    ends = sorted(at.values(), key=len, reverse=True)  # a bearing that is alone on its pin carries the whole force of the rod
    if section is None or len(link.pins) != 2 or len(ends[1]) != 1 or link.name in meshing:
        return
    if any(bearing.pin is None or bearing.name in moved for bearing in own):
        return
    if steel and abs(section.density / STEEL_DENSITY - 1.0) > LIKE_STEEL:
        raise PinpressError(
            f"link {link.name} has a density of {section.density:g} kg/m3, so its section is not of steel: give modulus, such as 70 GPa"
        )
    one, other = (drawn.parts.pins[name].point for name in link.pins)
    length = float(np.linalg.norm(other - one))
    size = f"{1e3 * section.height:g} x {1e3 * section.width:g} mm"
    stiffness = young * section.height * section.width / length
    yield Rod(link.name, (ends[0][0], ends[1][0]), stiffness, f"{size} and {1e-9 * young:g} GPa")
