"""A planar linkage taken apart into bodies on springs: `sprung_press`.

A bearing is two springs across each other, a guide a spring across its axis and one against turning.

A rod yields along the line of its two pins, in series with them: the pins at its ends are softer along that line, by half of the rod's
compliance each. Where another rod ends at a pin too, all of it is at the other pin. An arm of a link with more bearings yields at its end.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ....common import plausibility
from ....common.arguments import positive
from ....common.errors import PinpressError, shown
from ....common.quantities import Array
from ....engines.planar.model import Plane, to_complex
from ....kinematics.motion import Motion
from ....linkage.linkage import Linkage
from ..contact import Clearance, OpenPin
from ..description import Elastic, Rod
from ..flexible_link import FlexibleBody, FlexibleLink, RigidInertia, flexible_body
from ..preloaded_joint import JointSpring, PreloadedJoint
from ..yielding import (
    FRAME,
    LIGHTEST,
    SHAFT,
    bearing_number,
    by_bearing,
    dampers_by_bearing,
    doubt_stiffness,
    link_joint,
    part_stiffness,
    refuse_meeting,
    rod_ends,
    rods_of,
)
from .assembly_in_space import press_in_space
from .geometry import LinearSprings, Springs, in_columns
from .mounts import on_mounts
from .plane import DrawnBodies, Lines, PlaneGeometry
from .sprung_press import SprungPress, reference_motion


def sprung_press(press: Linkage, elastic: Elastic) -> SprungPress:
    """A press on its springs and dampers, planar or in space.

    Raises:
        UnknownNameError: the linkage has no such bearing or link.
        PinpressError: the press has several drivers, a driver that slides, or no slide; see also `press_in_plane` and `press_in_space`.
    """
    if not isinstance(elastic, Elastic):
        raise PinpressError(f"elastic is {shown(elastic)}: give an Elastic(Stiffness(bearings={{...}}, moments={{...}}))")
    press.refuse_several_drivers("elastic motion is that of a press with one; see slide_deflection of their motion")
    press.refuse_sliding_driver("elastic motion is that of a press with a crank")
    press.refuse_joint_springs("elastic motion has SpringDamper loads and preloaded joints instead")
    press.refuse_contacts("elastic motion does not compute their forces on yielding bearings; write only their ratios, gears or <relation>")
    _ = press.slide_guide
    build = press_in_plane if "plane" in press.engines else press_in_space
    sprung = build(press, elastic, reference_motion(press))
    doubt_stiffness(press, elastic.stiffness)
    if elastic.crown_mass is not None:
        plausibility.crown(float(elastic.crown_mass), sum(float(body.mass) for body in press.model.inertias))
    return sprung


def opening_press(press: Linkage, elastic: Elastic) -> SprungPress:
    """The `sprung_press` of a run, whose preloaded joints may open."""
    return sprung_press(press, elastic).with_opening_joints()


def press_in_plane(press: Linkage, elastic: Elastic, reference: Motion) -> SprungPress:
    """A planar press on its springs and dampers, with its `SprungPress.reference`.

    Raises:
        UnknownNameError: the linkage has no such bearing or link.
        PinpressError: a link has no mass, a bearing has no stiffness, a gear pair slides, a loop is welded, or a rod is not as described.
    """
    drawn = DrawnBodies(press)
    bodies = _bodies(press, drawn, elastic)
    stiff = _with_springs(drawn, bodies, elastic, reference)
    bending = _with_flexible_links(drawn, stiff, elastic) if len(elastic.flexible_links) else stiff
    closed = bending.with_dampers(elastic.damping_ratio, dampers_by_bearing(press, elastic.dampers))
    if elastic.mounted_frame is not None:
        return on_mounts(closed, elastic.mounted_frame, elastic.mounts)
    return _with_clearances(drawn, closed, elastic) if elastic.clearances else closed


# ---------------------------------------------------------------------------------------------------------------------------------- bodies


def _bodies(press: Linkage, drawn: DrawnBodies, elastic: Elastic) -> PlaneGeometry:
    """The bodies, with no springs yet."""
    model, plane, count = press.model, drawn.plane, press.model.nv
    mass = np.array([model.inertias[j + 1].mass for j in range(count)])
    moment = np.array([frame[2] @ model.inertias[j + 1].inertia @ frame[2] for j, frame in enumerate(plane.frames)])
    for j in range(count):
        if not mass[j] > LIGHTEST * mass.max() or not moment[j] > 0:
            raise PinpressError(
                f"link {shown(press.link_of(j + 1))} of {press.name} has no mass or no moment of inertia about the plane's normal, so that"
                " nothing says how it moves on its springs: give it those of the real part"
            )
    crown = count if elastic.crown_mass is not None else None
    rotor = count + (crown is not None) if elastic.stiffness.shaft is not None else None
    bodies = count + (crown is not None) + (rotor is not None)
    inertia, weight, gravity = np.zeros(3 * bodies + 3), np.zeros(3 * bodies + 3), complex(to_complex(plane, model.gravity.linear))
    inertia[: 3 * count : 3] = inertia[1 : 3 * count : 3] = mass
    inertia[2 : 3 * count : 3] = moment
    weight[: 3 * count : 3], weight[1 : 3 * count : 3] = mass * gravity.real, mass * gravity.imag
    if crown is not None:
        inertia[3 * crown : 3 * crown + 2] = positive("Elastic: crown_mass", elastic.crown_mass, "kg")
    return PlaneGeometry(
        press=press,
        centers=np.concatenate([drawn.centers, np.zeros(bodies - count + 1)]),
        inertia=inertia,
        weight=weight,
        lines=Lines(*np.zeros((6, 0))),
        shapes=np.zeros((2, 0, 0), dtype=complex),
        crown=crown,
        rotor=rotor,
    )


def _conditions(geometry: PlaneGeometry) -> tuple[Array, Array]:
    """``carry`` and ``drawn`` of `SprungPress`: the crank's angle and the gear pairs are conditions on the links' angles."""
    press, plane, size, crown, rotor = geometry.press, geometry.plane, geometry.rigid_size, geometry.crown, geometry.rotor
    count = press.model.nv
    turns = [axis.turns for axis in press.axes]
    if not all(turns[joint] for relation in press.relations for joint in relation.joints):
        raise PinpressError(f"a gear pair of {press.name} slides: elastic motion takes gears that turn")
    rows, constants, by_angle, eliminated = [], [], [], []
    if rotor is None:
        rows, constants, by_angle, eliminated = [_angle_row(plane, plane.driver, size)], [0.0], [1.0], [3 * plane.driver + 2]
    for relation in press.relations:
        rows.append(np.sum([by * _angle_row(plane, joint, size) for joint, by in relation.coefficients.items()], axis=0))
        constants.append(relation.offset)
        by_angle.append(0.0)
        eliminated.append(3 * relation.joint + 2)
    free = [i for i in range(3 * count) if i not in eliminated]
    carry, rest = np.zeros((size, len(free) + (crown is not None) + 1)), np.zeros(size)
    carry[free, np.arange(len(free))] = 1.0
    if rows:
        matrix = np.array(rows)
        inverse = np.linalg.inv(matrix[:, eliminated])
        carry[eliminated, : len(free)], carry[eliminated, -1] = -inverse @ matrix[:, free], inverse @ by_angle
        rest[eliminated] = inverse @ constants
    if crown is not None:
        along = complex(to_complex(plane, press.slide_direction))
        carry[3 * crown : 3 * crown + 2, len(free)] = along.real, along.imag
    if rotor is not None:
        if plane.parents[plane.driver] >= 0:
            raise PinpressError(f"the crank of {press.name} is not carried by the frame: a shaft that twists is one on the frame")
        carry[3 * rotor + 2, -1] = plane.sense[plane.driver]
    return carry, rest


def _angle_row(plane: Plane, joint: int, size: int) -> Array:
    """(size,) all coordinates to the angle of a joint that turns."""
    row, parent = np.zeros(size), plane.parents[joint]
    row[3 * joint + 2] = plane.sense[joint]
    if parent >= 0:
        row[3 * parent + 2] -= plane.sense[joint]
    return row


# --------------------------------------------------------------------------------------------------------------------------------- springs


class _Softer(NamedTuple):
    """A pin that yields more along a rod that ends there: outwards in the drawn pose, as one of ``ends`` pins that share its elongation."""

    name: str
    body: int
    along: complex
    stiffness: float | PreloadedJoint
    ends: int

    @property
    def compliance(self) -> float:
        """Of the rod at this pin, with a closed joint [m/N]."""
        return 1 / part_stiffness(f"rod {shown(self.name)}", self.stiffness) / self.ends


def _with_springs(drawn: DrawnBodies, bare: PlaneGeometry, elastic: Elastic, reference: Motion) -> SprungPress:
    press, stiffness, frame = drawn.press, elastic.stiffness, len(bare.centers) - 1
    carry, rest = _conditions(bare)
    words = {
        "holds_none": "no guide and holds no moment in the plane",
        "yields": ": in an elastic motion every bearing yields, and every guide also against turning",
    }
    radial = by_bearing(press, "bearings", stiffness.bearings, "N/m", range(len(press.bearings)), **words)
    guides = list(drawn.plane.prismatic)
    turning = by_bearing(press, "moments", stiffness.moments, "N m/rad", guides, **words)
    softer = _rods(drawn, rods_of(stiffness))
    parts = {-1: (FRAME, stiffness.frame)} | {press.bearings.index(name): (name, value) for name, value in stiffness.bearings.items()}
    joints = [JointSpring(name, place, value) for place, (name, value) in parts.items() if isinstance(value, PreloadedJoint)]
    for place, rod in softer.items():
        if isinstance(rod.stiffness, PreloadedJoint):
            joints.append(JointSpring(rod.name, place, rod.stiffness, rod.ends, radial[place]))
    lines: list[tuple[int, int, complex, complex, complex, float]] = []
    springs: list[tuple[float, float, float, int, float]] = []

    def body(link: int) -> int:
        """A link, or what carries the bearings on the frame."""
        return link if link >= 0 else frame if bare.crown is None else bare.crown

    def add(
        first: int, one: complex, second: int, two: complex, along: complex, turns: bool, value: float, number: int, sign: float
    ) -> None:
        arms = one - bare.centers[first], two - bare.centers[second]
        lines.append((first, second, *arms, along, float(turns)))
        springs.append((value, 0.0, 0.0, number, sign))

    for place in range(len(press.bearings)):
        link1, one, link2, two = drawn.bearing(place)
        first, second = body(link1), body(link2)
        if place in drawn.directions:
            add(first, one, second, two, 1j * drawn.directions[place], True, radial[place], place, 1.0)
        elif place in softer:
            rod = softer[place]
            soft = 1 / (1 / radial[place] + rod.compliance)
            ends, sign = ((first, one, second, two), 1.0) if rod.body == first else ((second, two, first, one), -1.0)
            add(*ends, rod.along, True, soft, place, sign)
            add(*ends, 1j * rod.along, True, radial[place], place, sign)
        else:
            for across in (1.0 + 0j, 1j):
                add(first, one, second, two, across, False, radial[place], place, 1.0)
    if bare.crown is not None:
        along = complex(to_complex(drawn.plane, press.slide_direction))
        add(frame, 0j, bare.crown, 0j, along, False, part_stiffness("the frame", stiffness.frame), -1, 1.0)
    turns = [(f"{press.bearings[j]} turning", body(drawn.plane.parents[j]), j, turning[j]) for j in guides]
    if bare.rotor is not None:
        turns.append((SHAFT, bare.rotor, drawn.plane.driver, part_stiffness("the shaft", stiffness.shaft, "N m/rad")))
    geometry = replace(bare, lines=in_columns(Lines, lines), shapes=np.zeros((2, len(lines), 0), dtype=complex))
    return SprungPress(
        press=press,
        elastic=elastic,
        geometry=geometry,
        springs=in_columns(Springs, springs),
        linear=_against_turning(turns, len(rest)),
        carry=carry,
        drawn=rest,
        reference=reference,
        alike=tuple(range(len(press.bearings))),
        joints=tuple(joints),
    )


def _against_turning(turns: Sequence[tuple[str, int, int, float]], size: int) -> LinearSprings:
    """Springs against the turning of one body against another, of parts, both bodies, and stiffnesses."""
    rows = np.zeros((len(turns), size))
    for row, (_, first, second, _) in zip(rows, turns, strict=True):
        row[3 * first + 2], row[3 * second + 2] = -1.0, 1.0
    stiffness = np.array([value for *_, value in turns], dtype=float)
    return LinearSprings(rows, stiffness, np.zeros(len(turns)), np.ones(len(turns)), tuple(part for part, *_ in turns))


def _rods(drawn: DrawnBodies, rods: Sequence[Rod]) -> dict[int, _Softer]:
    """By the number of a pin what it yields more along the rod that ends there."""
    press = drawn.press
    ends = [_rod_ends(drawn, rod) for rod in rods]
    used = [number for _, pins, _ in ends for number in pins]
    softer: dict[int, _Softer] = {}
    for rod, (body, pins, along) in zip(rods, ends, strict=True):
        alone = [number for number in pins if used.count(number) == 1] or [number for number in pins if number not in softer][:1]
        if not alone:
            raise PinpressError(f"rod {shown(rod.name)}: other rods end at both of its pins; give one of them to the stiffness of the pin")
        for pin_number in alone:
            if pin_number in softer:
                raise PinpressError(
                    f"rod {shown(rod.name)}: another rod yields at its pin {shown(press.bearings[pin_number])}; give one of them to the"
                    " stiffness of the pin"
                )
            outwards = along if press.bearings[pin_number] == rod.between[1] else -along
            softer[pin_number] = _Softer(rod.name, body, outwards, rod.stiffness, len(alone))
    return softer


def _rod_ends(drawn: DrawnBodies, rod: Rod) -> tuple[int, list[int], complex]:
    """Link of a rod, the pins at which it may yield, and its direction in the drawn pose."""
    press = drawn.press
    joint, ends, of_link = rod_ends(press, rod)
    body, places = joint - 1, []
    for place in ends:
        if place in drawn.directions:
            names = ", ".join(press.bearings[i] for i in of_link if i not in drawn.directions)
            raise PinpressError(f"rod of {shown(rod.link)}: {shown(press.bearings[place])} is no pin on that link; there are: {names}")
        link1, one, _, two = drawn.bearing(place)
        places.append(one if link1 == body else two)
    line = places[1] - places[0]
    refuse_meeting(press, rod.name, abs(line))
    return body, list(ends if len(of_link) == 2 else ends[1:]), line / abs(line)


# ------------------------------------------------------------------------------------------------------------------------- flexible links


def rigid_inertia(drawn: DrawnBodies, body: int) -> RigidInertia:
    """A link as a rigid body in the plane."""
    inertia, normal = drawn.press.model.inertias[body + 1], drawn.plane.frames[body][2]
    return RigidInertia(float(inertia.mass), complex(drawn.centers[body]), float(normal @ inertia.inertia @ normal))


def pins_of(drawn: DrawnBodies, link: str) -> tuple[int, dict[str, complex]]:
    """Number of a link that has pins alone, and their names and places in the drawn pose.

    Raises:
        UnknownNameError: the linkage has no such moving link.
        PinpressError: it slides, carries a guide or a gear, or is the crank.
    """
    press, plane = drawn.press, drawn.plane
    body = link_joint(press, link) - 1
    geared = {joint for relation in press.relations for end in relation.joints for joint in (end, plane.parents[end])}
    for why, is_so in (
        ("it is the crank, which its drive holds", body == plane.driver),
        ("it carries the crank", body == plane.parents[plane.driver]),
        ("it slides in a guide", body in drawn.directions),
        ("it carries a guide", any(plane.parents[joint] == body for joint in drawn.directions)),
        ("it carries a gear", body in geared),
    ):
        if is_so:
            raise PinpressError(f"link {shown(link)} of {press.name} cannot bend: {why}; flexible links are joined by pins alone")
    pins = {}
    for place, name in enumerate(press.bearings):
        link1, one, link2, two = drawn.bearing(place)
        if body in (link1, link2):
            pins[name] = one if link1 == body else two
    return body, pins


def _with_flexible_links(drawn: DrawnBodies, rigid: SprungPress, elastic: Elastic) -> SprungPress:
    """The press whose flexible links have coordinates of their own, after those of all bodies."""
    press, size, geometry, bodies = drawn.press, len(rigid.drawn), rigid.geometry, list[FlexibleBody]()
    first = size
    for link in elastic.flexible_links:
        if not isinstance(link, FlexibleLink):
            raise PinpressError(f"flexible_links has {shown(link)}: give FlexibleLinks, as flexible_beam and read_flexible_link return")
        body, places = pins_of(drawn, link.link)
        if any(bent.body == body for bent in bodies) or any(rod.link == link.link for rod in elastic.stiffness.rods):
            raise PinpressError(f"link {shown(link.link)} of {press.name} yields twice: give it one FlexibleLink, and no Rod")
        pins = {press.bearings.index(name): (name, place) for name, place in places.items()}
        bodies.append(flexible_body(link, body, first, pins, rigid_inertia(drawn, body)))
        first = bodies[-1].columns.stop
    more = first - size
    carry = np.zeros((first, rigid.free + more))
    carry[:size, : rigid.free - 1], carry[:size, -1] = rigid.carry[:, :-1], rigid.carry[:, -1]
    carry[size:, rigid.free - 1 : -1] = np.eye(more)
    shapes = np.zeros((2, len(geometry.lines.first), more), dtype=complex)
    for bent in bodies:
        columns = slice(bent.columns.start - size, bent.columns.stop - size)
        for spring, bearing in enumerate(rigid.springs.bearing):
            for side, ends in enumerate((geometry.lines.first, geometry.lines.second)):
                if ends[spring] == bent.body:
                    shapes[side, spring, columns] = bent.at_bearing[int(bearing)]
    linear, nothing = rigid.linear, np.zeros(more)
    return replace(
        rigid,
        geometry=replace(
            geometry,
            inertia=np.concatenate([geometry.inertia, *(np.full(len(bent.stiffness), bent.mass) for bent in bodies)]),
            weight=np.append(geometry.weight, nothing),
            flexible=tuple(bodies),
            shapes=shapes,
        ),
        linear=LinearSprings(
            np.vstack([np.pad(linear.rows, ((0, 0), (0, more))), np.eye(more, first, size)]),
            np.concatenate([linear.stiffness, *(bent.stiffness for bent in bodies)]),
            np.concatenate([linear.damping, *(bent.damping for bent in bodies)]),
            np.append(linear.shared, nothing),
            (*linear.parts, *(bent.name for bent in bodies for _ in bent.stiffness)),
        ),
        drawn=np.append(rigid.drawn, nothing),
        carry=carry,
    )


# ------------------------------------------------------------------------------------------------------------------------------ clearances


def _with_clearances(drawn: DrawnBodies, closed: SprungPress, elastic: Elastic) -> SprungPress:
    """The press with clearance in some of its pins."""
    press, pins = drawn.press, []
    if not isinstance(elastic.clearances, Mapping):
        raise PinpressError(f"clearances is {shown(elastic.clearances)}: give a mapping, name of a pin: Clearance(...)")
    for name, clearance in elastic.clearances.items():
        place = bearing_number(press, name)
        if not isinstance(clearance, Clearance):
            raise PinpressError(f"clearance of {shown(name)} is {shown(clearance)}: give a Clearance(radial)")
        lines, springs = closed.geometry.lines, closed.springs
        of_pin = np.flatnonzero(springs.bearing == place)
        if place in drawn.directions or lines.turning[of_pin].any():
            raise PinpressError(f"clearance of {shown(name)}: it is a guide, or a rod yields there; give clearance to other pins")
        if any(place in bent.at_bearing for bent in closed.geometry.flexible):
            raise PinpressError(f"clearance of {shown(name)}: a flexible link is joined there; give clearance to other pins")
        k = int(of_pin[0])
        bodies, arms = (int(lines.first[k]), int(lines.second[k])), (complex(lines.arm1[k]), complex(lines.arm2[k]))
        pins.append(OpenPin(place, bodies, arms, clearance, float(springs.stiffness[k]), float(springs.damping[k])))
    stiff = ~np.isin(closed.springs.bearing, [open_pin.bearing for open_pin in pins])
    springs = Springs._make(column[stiff] for column in closed.springs)
    return replace(closed, geometry=closed.geometry.with_lines(stiff), springs=springs, open_pins=tuple(pins), closed=closed)
