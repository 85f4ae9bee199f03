"""Machine elements in pictures: gears as their pitch circles, racks with teeth, screws with a thread, cams with their rollers.

They are symbols, of true radii and leads. Those of a planar linkage are in one plane in front of its links, as gears that mesh are. A gear
has a spoke, an internal one a mark outside, so that its rotation is visible.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
import pinocchio as pin

from ...common.frozen import read_only
from ...common.quantities import Array
from ...engines.machine_elements.cams import CamContact
from ...linkage.linkage import Linkage
from ...linkage.machine_elements import Gears, RackAndPinion, ScrewAndNut, WormAndWheel
from .bearing_layout import BearingLayout
from .solids import Box, Cylinder, MadeUpSolid, TriangleMesh, standing

# lengths in widths of a bar
THICK, CLEAR = 0.22, 0.12  # thickness of a pitch circle, and its distance from the links behind it
SPINDLE = 0.5  # radius of a screw without a diameter
HUB, SHAFT = 0.9, 0.36  # largest radii of hub and shaft of a gear
# shares of a radius
RING, HUB_SHARE = 0.07, 0.3  # width of a pitch circle, and radius of the hub of a small one
BORE = 0.6  # radius of the bore of a cam, through which its link is seen
AROUND = 96  # corners of a circle
TEETH = 18  # teeth of a rack within a turn of its pinion: it may have no module
MOST_TURNS = 40  # of a thread that is drawn; a finer one is drawn coarser
ROUND_TURN = 24  # corners of a turn of a thread

_Shift: TypeAlias = Callable[[Array], Array]


class _Circle(NamedTuple):
    """A pitch circle of a link in world axes: centre (3,), axis (3,), radius [m], whether it is internal, and a direction (3,) to its
    mesh."""

    link: str
    centre: Array
    axis: Array
    radius: float
    internal: bool
    towards: Array


def element_solids(press: Linkage, layout: BearingLayout, shown: Sequence[Array]) -> Iterator[tuple[str, MadeUpSolid]]:
    """Links and their solids, in world axes in the drawn pose.

    Args:
        press: the linkage.
        layout: of its bearings.
        shown: (k, 3) corners of every other solid of links that move, wherever guides let them go.
    """
    circles = _circles(press, layout)
    cams = [contact for contact in press.contacts if isinstance(contact, CamContact)]
    reaches = [(circle.centre, circle.radius) for circle in circles]
    for cam in cams:
        rollers = np.abs(cam.at(np.linspace(0.0, 2 * np.pi, AROUND)).roller)
        reaches.append((_on_body(press, layout, cam.carrier, cam.origin), float(rollers.max()) + cam.roller_radius))
    height = _height(layout, reaches, shown)

    def in_front(point: Array) -> Array:
        return point if layout.normal is None or height is None else np.asarray(layout.flat(point) + height * layout.normal)

    for circle in circles:
        for solid in _gear(circle, in_front(circle.centre), layout.width):
            yield circle.link, solid
    for circle in _other_planets(press, layout, circles):
        yield circle.link, _ring(circle, in_front(circle.centre), layout.width)
    for mesh in press.meshes.values():
        if isinstance(mesh, RackAndPinion):
            yield mesh.links[1], _rack(mesh, layout, in_front)
        elif isinstance(mesh, ScrewAndNut):
            yield from _screw_and_nut(mesh, layout)
        elif isinstance(mesh, WormAndWheel):
            yield from _worm(mesh, layout)
    for cam in cams:
        yield from _cam(press, cam, layout, in_front)


def _circles(press: Linkage, layout: BearingLayout) -> list[_Circle]:
    """The pitch circles, each once: a planet has one with the sun and the ring."""
    circles: list[_Circle] = []
    for mesh in press.meshes.values():
        touching = _placed(layout, mesh.carrier, mesh.pitch_point)
        for k, radius in enumerate(mesh.radii):
            if isinstance(mesh, WormAndWheel) and k == 0:
                continue
            centre, axis = _placed(layout, mesh.links[k], mesh.centres[k]), _turned(layout, mesh.links[k], mesh.axes[k])
            towards = touching - centre
            towards = towards - (towards @ axis) * axis
            internal = isinstance(mesh, Gears) and mesh.teeth[k] < 0
            circle = _Circle(mesh.links[k], centre, axis, radius, internal, towards / np.linalg.norm(towards))
            known = (c for c in circles if c.link == circle.link and c.internal == internal and abs(c.radius - radius) < 1e-6 * radius)
            if not any(np.linalg.norm(np.cross(c.centre - centre, axis)) < 1e-6 * radius for c in known):
                circles.append(circle)
    return circles


def _other_planets(press: Linkage, layout: BearingLayout, circles: Sequence[_Circle]) -> Iterator[_Circle]:
    """Pitch circles of the planets for which a drawn one stands, on their carrier: they have no link whose rotation could be shown."""
    for planet, contact in {contact.planets.planet: contact for contact in press.contacts if contact.planets is not None}.items():
        assert contact.planets is not None
        pin_, centre = (_on_body(press, layout, contact.carrier, point) for point in (contact.planets.pin, contact.planets.center))
        axis = _on_body(press, layout, contact.carrier, contact.planets.center + contact.planets.axis) - centre
        for circle in (each for each in circles if press.frame_of(each.link).parentJoint == planet and not each.internal):
            for k in range(1, contact.planets.number):
                turned = pin.exp3(2 * math.pi * k / contact.planets.number * axis)
                yield circle._replace(link=press.link_of(contact.carrier), centre=centre + turned @ (pin_ - centre))


def _height(layout: BearingLayout, reaches: Sequence[tuple[Array, float]], shown: Sequence[Array]) -> float | None:
    """Height along the normal of the plane of all elements of a planar linkage: in front of the solids that come near them [m]."""
    if layout.normal is None or not reaches:
        return None
    tops = [float(centre @ layout.normal) for centre, _ in reaches]
    for corners in shown:
        low, high = layout.flat(corners).min(axis=0), layout.flat(corners).max(axis=0)
        if any(np.all((layout.flat(centre) > low - radius) & (layout.flat(centre) < high + radius)) for centre, radius in reaches):
            tops.append(float((corners @ layout.normal).max()))
    return max(tops) + (CLEAR + THICK / 2) * layout.width


def _gear(circle: _Circle, centre: Array, width: float) -> Iterator[MadeUpSolid]:
    """A pitch circle with its spoke, hub and shaft; of an internal gear with a mark."""
    radius, wide, thick = circle.radius, _wide(circle, width), THICK * width
    ring = _ring(circle, centre, width)
    placement = ring.placement
    yield ring
    if circle.internal:
        yield MadeUpSolid(Box((wide, wide, thick)), _shifted(placement, 1.5 * wide + radius), darker=True)
        return
    yield MadeUpSolid(Box((radius - wide, wide, 0.8 * thick)), _shifted(placement, (radius - wide) / 2), darker=True)
    hub = min(HUB * width, HUB_SHARE * radius)
    yield MadeUpSolid(Cylinder(hub, thick), placement, darker=True)
    if (back := float(np.linalg.norm(centre - circle.centre))) > thick:
        yield standing(Cylinder(SHAFT / HUB * hub, back), (centre + circle.centre) / 2, circle.axis, steel=True)


def _ring(circle: _Circle, centre: Array, width: float) -> MadeUpSolid:
    """A pitch circle as a band, inside the circle, of an internal gear outside it."""
    wide, thick = _wide(circle, width), THICK * width
    radii = (circle.radius, circle.radius + wide) if circle.internal else (circle.radius - wide, circle.radius)
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    band = _swept([_section(at, radii, (-thick / 2, thick / 2)) for at in angle], closed=True)
    return MadeUpSolid(band, _axes(centre, circle.towards, circle.axis))


def _wide(circle: _Circle, width: float) -> float:
    return min(max(RING * circle.radius, 0.1 * width), 1.2 * width)


def _rack(mesh: RackAndPinion, layout: BearingLayout, in_front: _Shift) -> MadeUpSolid:
    """A strip whose teeth end at the pitch line, as long as the rack travels."""
    pinion, rack = mesh.links
    along, point, radius = _turned(layout, rack, mesh.axes[1]), _placed(layout, rack, mesh.centres[1]), mesh.radii[0]
    away, axis = _placed(layout, pinion, mesh.centres[0]) - point, _turned(layout, pinion, mesh.axes[0])
    point = point + (away @ along) * along
    towards = away - (away @ along) * along - (away @ axis) * axis
    pitch = 2 * math.pi * radius / TEETH
    low, high = _travel(layout, rack, along, (-radius, radius))
    first, last = math.floor((-high - radius) / pitch), math.ceil((-low + radius) / pitch)
    corners = [
        ((k + part) * pitch, -deep * pitch) for k in range(first, last) for part, deep in ((0.1, 0.0), (0.4, 0.0), (0.6, 0.6), (0.9, 0.6))
    ]
    thick = THICK * layout.width / 2
    sections = [np.array([[x, top, -thick], [x, top, thick], [x, -1.4 * pitch, thick], [x, -1.4 * pitch, -thick]]) for x, top in corners]
    across = np.cross(along, towards / np.linalg.norm(towards))
    return MadeUpSolid(_swept(sections, closed=False), _axes(in_front(point), along, across))


def _screw_and_nut(mesh: ScrewAndNut, layout: BearingLayout) -> Iterator[tuple[str, MadeUpSolid]]:
    """A spindle with its thread, from its bearing as far as the nut travels on it; and the nut."""
    screw, nut = mesh.links
    axis, on_axis = _turned(layout, screw, mesh.axes[0]), _placed(layout, screw, mesh.centres[0])
    at = on_axis + ((_placed(layout, nut, mesh.centres[1]) - on_axis) @ axis) * axis
    diameter = mesh.lead / (math.pi * math.tan(mesh.lead_angle))
    radius = diameter / 2 if diameter > 1e-6 * layout.size else SPINDLE * layout.width
    (low, high), (back, ahead) = (_travel(layout, link, axis, (0.0, 0.0)) for link in (nut, screw))
    bearing = float((on_axis - at) @ axis)
    ends = min(low - ahead - radius, bearing), max(high - back + radius, bearing)
    for solid in _threaded(at, axis, radius, ends, mesh.ratio):
        yield screw, solid
    yield screw, standing(Cylinder(1.7 * radius, 0.4 * radius), on_axis, axis)  # its collar
    yield nut, standing(Cylinder(1.4 * radius, 1.6 * radius), at, axis)


def _worm(mesh: WormAndWheel, layout: BearingLayout) -> Iterator[tuple[str, MadeUpSolid]]:
    (worm, wheel), radius = mesh.links, mesh.radii[0]
    (centre, axis), (other, about) = (
        (_placed(layout, link, mesh.centres[k]), _turned(layout, link, mesh.axes[k])) for k, link in enumerate((worm, wheel))
    )
    touching = _placed(layout, mesh.carrier, mesh.pitch_point)
    middle = centre + ((touching - centre) @ axis) * axis
    along = mesh.ratio * float(np.cross(about, touching - other) @ axis)  # speed of the teeth along the worm that turns at 1 rad/s
    for solid in _threaded(middle, axis, radius, (-2 * radius, 2 * radius), along):
        yield worm, solid


def _threaded(at: Array, axis: Array, radius: float, ends: tuple[float, float], rate: float) -> Iterator[MadeUpSolid]:
    """A spindle between two ends along its axis, from a point on it, whose thread moves a nut by ``rate`` [m/rad] as it turns."""
    length, middle = ends[1] - ends[0], standing(Cylinder(0.88 * radius, ends[1] - ends[0]), at + sum(ends) / 2 * axis, axis, steel=True)
    yield middle
    lead = 2 * math.pi * abs(rate)
    lead *= math.ceil(length / lead / MOST_TURNS)
    wide = 0.25 * min(lead, radius)  # of the thread, along the axis
    turns = (length - 2 * wide) / lead
    angle = np.linspace(0.0, 2 * np.pi * turns, max(2, math.ceil(ROUND_TURN * turns)))
    height = np.linspace(wide - length / 2, length / 2 - wide, len(angle))
    hand = -math.copysign(1.0, rate)  # a thread that moves its nut backwards as it turns forwards is right-handed
    sections = [_section(hand * a, (0.8 * radius, 1.05 * radius), (z - wide / 2, z + wide / 2)) for a, z in zip(angle, height, strict=True)]
    yield MadeUpSolid(_swept(sections, closed=False), middle.placement, darker=True)


def _cam(press: Linkage, cam: CamContact, layout: BearingLayout, in_front: _Shift) -> Iterator[tuple[str, MadeUpSolid]]:
    """The plate of a cam, and the roller with its arm."""
    links = press.link_of(cam.first), press.link_of(cam.second)
    origin = _on_body(press, layout, cam.carrier, cam.origin)
    real, imaginary = (_on_body(press, layout, cam.carrier, cam.origin + each) - origin for each in cam.axes)
    drawn = cam.angle(press.closed[:, None])[0]
    thick = THICK * layout.width
    turn = 2 * np.pi * np.arange(4 * AROUND) / (4 * AROUND)
    states = cam.at(drawn + turn)
    # the profile is where the roller touches; turned back, as the cam sees it
    profile = (states.roller - cam.roller_radius * states.normal) * np.exp(-1j * turn)
    angle, radius = np.angle(profile), np.abs(profile)
    bore = BORE * radius.min()
    placement = _axes(in_front(origin), real, np.cross(real, imaginary))
    sections = [_section(a, (bore, r), (-thick / 2, thick / 2)) for a, r in zip(angle, radius, strict=True)]
    yield links[0], MadeUpSolid(_swept(sections, closed=True), placement)
    roller = in_front(origin + states.roller[0].real * real + states.roller[0].imag * imaginary)
    yield links[1], MadeUpSolid(Cylinder(cam.roller_radius, 1.3 * thick), _axes(roller, real, np.cross(real, imaginary)), steel=True)
    if cam.arm:
        along = in_front(origin + cam.distance * real) - roller
        bar = Box((cam.arm, cam.roller_radius, thick))
        yield links[1], MadeUpSolid(bar, _axes(roller + along / 2 + 1.2 * thick * placement[:3, 2], along / cam.arm, placement[:3, 2]))


# ------------------------------------------------------------------------------------------------------------------------------- places


def _placed(layout: BearingLayout, link: str, point: Array) -> Array:
    """A point (3,) of a link in world axes."""
    return np.asarray(layout.placements[link][:3, :3] @ point + layout.placements[link][:3, 3])


def _turned(layout: BearingLayout, link: str, direction: Array) -> Array:
    """A direction (3,) of a link in world axes."""
    return np.asarray(layout.placements[link][:3, :3] @ direction)


def _on_body(press: Linkage, layout: BearingLayout, joint: int, point: Array) -> Array:
    """A point (3,) in the frame of a Pinocchio joint in world axes."""
    link = press.link_of(joint)
    return _placed(layout, link, press.frame_of(link).placement.actInv(point))


def _travel(layout: BearingLayout, link: str, along: Array, unguided: tuple[float, float]) -> tuple[float, float]:
    """Ends of the travel of a link along a direction, from its drawn pose [m]; ``unguided`` if it is in no guide along it."""
    for bearing in layout.bearings:
        if bearing.kind == "guide" and bearing.links[1] == link and abs(bearing.axis @ along) > 0.5:
            low, high = sorted(float(bearing.axis @ along) * end for end in bearing.travel)
            return low, high
    return unguided


def _axes(centre: Array, x: Array, z: Array) -> Array:
    """A placement (4, 4) with these axes."""
    placement = np.eye(4)
    placement[:3, 0], placement[:3, 1], placement[:3, 2], placement[:3, 3] = x, np.cross(z, x), z, centre
    return placement


def _shifted(placement: Array, along: float) -> Array:
    """A placement (4, 4) that is moved along its x axis."""
    moved = placement.copy()
    moved[:3, 3] += along * placement[:3, 0]
    return moved


# ------------------------------------------------------------------------------------------------------------------------------- solids


def _section(angle: float, radii: tuple[float, float], heights: tuple[float, float]) -> Array:
    """(4, 3) corners of a rectangle in the half plane through the z axis at an angle."""
    radius = np.array([radii[0], radii[1], radii[1], radii[0]])
    return np.column_stack([radius * math.cos(angle), radius * math.sin(angle), np.repeat(heights, 2)])


def _swept(sections: Sequence[Array], closed: bool) -> TriangleMesh:
    """The solid that sections (4, 3) form one after the other; a ring where it is ``closed``."""
    n, m = len(sections), 4
    vertices = np.concatenate(sections)
    here = np.arange(n if closed else n - 1)[:, None] * m + np.arange(m)
    beside = np.roll(here, -1, axis=1)
    after, across = (here + m) % (n * m), (beside + m) % (n * m)
    sides = np.concatenate([np.stack([here, beside, across], axis=-1), np.stack([here, across, after], axis=-1)]).reshape(-1, 3)
    end = (n - 1) * m
    caps = [[0, 2, 1], [0, 3, 2], [end, end + 1, end + 2], [end, end + 2, end + 3]]
    faces = sides if closed else np.concatenate([sides, caps])
    a, b, c = vertices[faces].transpose(1, 0, 2)
    outwards = np.sum(a * np.cross(b, c)) > 0
    return TriangleMesh(read_only(vertices), read_only(faces if outwards else faces[:, ::-1].copy()))
