"""Plain shapes for links without visuals, made up from their bearings and masses.

A planar linkage has bars, plates and blocks in layers in front of a press's frame. A linkage in space has rods and plates between bushes
and balls.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ...common.quantities import Array
from ...linkage.linkage import Linkage
from ...linkage.writing import AddedBallast, added_ballasts
from .ballast import ball, flywheel_disc, plane_counterweight
from .bearing_layout import BearingLayout, lay_out_bearings
from .machine_elements import element_solids
from .planar_links import PlanarLinks
from .press_frame import frame_solids
from .solids import Cylinder, MadeUpSolid, Part, Plate, corners, part, standing
from .space_links import space_solids

Colour = tuple[float, float, float]

FRAME: Colour = (0.44, 0.48, 0.53)
STEEL: Colour = (0.90, 0.91, 0.92)  # colour of pins
COLOURS: tuple[Colour, ...] = (  # of links, in document order; distinguishable for colour-blind readers too
    (0.76, 0.24, 0.08),
    (0.08, 0.33, 0.79),
    (0.11, 0.62, 0.41),
    (0.93, 0.58, 0.08),
    (0.56, 0.36, 0.66),
    (0.25, 0.79, 0.88),
    (0.95, 0.67, 0.64),
    (0.49, 0.30, 0.19),
)


@dataclass(frozen=True)
class ShaftFlywheel:
    """A flywheel on the shaft of a driver that turns.

    Attributes:
        driver: name of the driver.
        inertia: moment of inertia of the flywheel [kg m2].
        coupled: whether it always turns with the driver; with a clutch in between it may not.
    """

    driver: str
    inertia: float
    coupled: bool = True


def made_up_parts(
    press: Linkage, travel: Array, drawn: Mapping[str, tuple[Part, ...]], flywheels: Sequence[ShaftFlywheel]
) -> tuple[dict[str, tuple[Part, ...]], list[tuple[Part, ...]]]:
    """Name of a link -> its parts; and the parts of flywheels, in the frames of the links that they drive.

    Links without visuals have plain shapes, or no shapes if they have no bearing. Links with visuals have the counterweights that were
    added to them, see `linkage.writing`.

    Args:
        press: the linkage.
        travel: (2, nv) lowest and highest positions of the joints [rad or m].
        drawn: parts of links that have visuals.
        flywheels: on the shafts of drivers.
    """
    added = added_ballasts(press)
    layout = lay_out_bearings(press, travel, drawn, added)
    if layout.normal is None:
        solids = {link: space_solids(layout, link) for link in layout.links}
    else:
        links = PlanarLinks(layout, layout.normal)
        solids = {link: frame_solids(links, link) if link in layout.on_frame else links.link(link) for link in layout.links}
    moving = (link for link in press.links if link not in layout.on_frame)
    colours = dict.fromkeys(layout.on_frame, FRAME) | dict(zip(moving, _colours(), strict=False))
    for link, weights in _weights_on_drawn(press, layout, drawn, added).items():
        solids[link] = weights
        colours[link] = Counter(tuple(each.rgba[:3].tolist()) for each in drawn[link]).most_common(1)[0][0]
    parts = {link: _in_frame(layout.placements[link], made, colours[link]) for link, made in solids.items()}
    for link, made in _elements(press, layout, solids, drawn).items():
        of_visual = Counter(tuple(each.rgba[:3].tolist()) for each in drawn.get(link, ())).most_common(1)
        colour = colours.get(link) or (of_visual[0][0] if of_visual else STEEL)
        parts[link] = (*parts.get(link, ()), *_in_frame(layout.placements[link], made, colour))
    if not flywheels:
        return parts, []
    shown = [layout.placements[link] @ each.placement @ _homogeneous(corners(each.shape)) for link, its in drawn.items() for each in its]
    shown += [solid.placement @ _homogeneous(corners(solid.shape)) for made in solids.values() for solid in made]
    points, placed, wheels = np.hstack(shown)[:3].T, list[tuple[Array, float, Array]](), []
    for each in flywheels:
        at, radius = layout.bearings[press.joints.index(each.driver)].points[1], flywheel_disc(each.inertia, layout.size).radius
        before = [corner for other, its, corner in placed if np.linalg.norm(layout.flat(other - at)) < radius + its]
        wheel = _flywheel(press, layout, each, np.vstack([points, *before]))  # behind other wheels that it would intersect
        placed.append((at, radius, (wheel[0].placement @ _homogeneous(corners(wheel[0].shape)))[:3].T))
        wheels.append(_in_frame(layout.placements[_driven_link(press, each.driver)], wheel, FRAME))
    return parts, wheels


def _elements(
    press: Linkage, layout: BearingLayout, solids: Mapping[str, Sequence[MadeUpSolid]], drawn: Mapping[str, tuple[Part, ...]]
) -> dict[str, list[MadeUpSolid]]:
    """Solids of gears, racks, screws and cams by their links, in front of the links that move."""
    if not press.contacts:
        return {}
    travelled = {b.links[1]: [end * b.axis for end in b.travel] for b in layout.bearings if b.kind == "guide" and b.on_frame[0]}
    moving = [(link, solid.placement, solid.shape) for link, made in solids.items() if link not in layout.on_frame for solid in made]
    moving += [(link, layout.placements[link] @ each.placement, each.shape) for link, its in drawn.items() for each in its]
    shown = []
    for link, placement, shape in moving:
        places = (placement @ _homogeneous(corners(shape)))[:3].T
        shown.append(np.vstack([places + way for way in travelled.get(link, [np.zeros(3)])]))
    elements: dict[str, list[MadeUpSolid]] = {}
    for link, solid in element_solids(press, layout, shown):
        elements.setdefault(link, []).append(solid)
    return elements


def _in_frame(placement: Array, solids: Sequence[MadeUpSolid], colour: Colour) -> tuple[Part, ...]:
    """Solids in world axes as parts in a link's frame; counterweights are darker than the link."""
    into, (red, green, blue) = np.linalg.inv(placement), colour
    shade = (0.66 * red, 0.66 * green, 0.66 * blue)
    return tuple(
        part(solid.shape, into @ solid.placement, (*(STEEL if solid.steel else shade if solid.darker else colour), 1.0)) for solid in solids
    )


def _homogeneous(points: Array) -> Array:
    return np.column_stack([points, np.ones(len(points))]).T


def _colours() -> Iterator[Colour]:
    shade = 1.0
    while True:
        yield from ((shade * red, shade * green, shade * blue) for red, green, blue in COLOURS)
        shade *= 0.68


def _weights_on_drawn(
    press: Linkage, layout: BearingLayout, drawn: Collection[str], added: Mapping[int, AddedBallast]
) -> dict[str, list[MadeUpSolid]]:
    """Counterweights that were added to links with visuals; for links that are welded together, the first link has them."""
    weights = {}
    for joint, weight in added.items():
        frames = [f for f in press.model.frames if f.type == pin.BODY and f.parentJoint == joint and f.name in drawn]
        if frames:
            link = str(frames[0].name)
            of_joint = pin.SE3(layout.placements[link]) * frames[0].placement.inverse()
            weights[link] = [_weight(layout, weight.mass, of_joint.act(weight.centre), of_joint.translation, joint in layout.turning)]
    return weights


def _weight(layout: BearingLayout, mass: float, centre: Array, pivot: Array, turns: bool) -> MadeUpSolid:
    """A counterweight at its true place."""
    if layout.normal is None:
        return standing(ball(mass), centre, darker=True)
    away = layout.flat(centre - pivot)
    arm = float(np.linalg.norm(away))
    shape, _ = plane_counterweight(mass, arm, layout.width, turns)
    along = away / arm if arm > 0 else np.cross(layout.normal, np.eye(3)[np.argmin(np.abs(layout.normal))])
    along /= np.linalg.norm(along)
    placement = np.eye(4)
    placement[:3, :3] = np.column_stack([along, np.cross(layout.normal, along), layout.normal])
    placement[:3, 3] = centre - away if isinstance(shape, Plate) else centre
    return MadeUpSolid(shape, placement, darker=True)


def _driven_link(press: Linkage, driver: str) -> str:
    joint = press.model.getJointId(driver)
    return next(str(frame.name) for frame in press.model.frames if frame.type == pin.BODY and frame.parentJoint == joint)


def _flywheel(press: Linkage, layout: BearingLayout, flywheel: ShaftFlywheel, shown: Array) -> list[MadeUpSolid]:
    """A flywheel: behind all shown points (n, 3) of a planar linkage; in space, behind the crank's bearing."""
    bearing = layout.bearings[press.joints.index(flywheel.driver)]
    at, w, disc = bearing.points[1], layout.width, flywheel_disc(flywheel.inertia, layout.size)
    if layout.normal is None:
        link = _driven_link(press, flywheel.driver)
        ahead = np.sum([b.points[side] - at for b, side in layout.ends(link)], axis=0) @ bearing.axis if link in layout.links else 0.0
        towards = bearing.axis if ahead >= 0 else -bearing.axis
        behind = at - 2.0 * w * towards
    else:
        towards = layout.normal
        behind = at + (float((shown @ towards).min()) - float(at @ towards)) * towards
    centre = behind - (0.4 * w + disc.length / 2) * towards
    wheel, shaft = standing(disc, centre, towards), centre - at
    solids = [wheel, standing(Cylinder(0.4 * w, float(np.linalg.norm(shaft))), at + shaft / 2, towards, steel=True)]
    for angle in np.linspace(0.0, 2 * np.pi, 5, endpoint=False) if flywheel.coupled else ():  # recesses, which make its rotation visible
        place = 0.62 * disc.radius * np.array([np.cos(angle), np.sin(angle)])
        recess = Cylinder(0.16 * disc.radius, 1.02 * disc.length)
        solids.append(standing(recess, centre + wheel.placement[:3, :2] @ place, towards, darker=True))
    return solids
