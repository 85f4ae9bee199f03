"""Teeth and threads of a linkage in the drawn pose: which joints they relate, and how the bodies push on each other.

Two gears turn relative to the link that carries both centres: z1 (th1 - thc) + z2 (th2 - thc) stays constant. Here z < 0 for an internal
gear, and the angles th are sums of joint coordinates from the frame. A rack rolls on the pitch circle, s = r th, a nut runs along a
thread, s = L/(2 pi) th, both relative to the same link. So each element is a row of coefficients of joints. The multiplier of the row is
an effort on the joint that the row determines.

The real action is a force at the pitch point. Its part along the motion follows from virtual work, its other parts from pressure angle,
helix and friction. Seen from the carrier this force keeps its direction, so it is computed once, in the drawn pose.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pinocchio as pin

from ..common.errors import UrdfError
from ..common.frozen import Frozen
from ..common.quantities import Array
from ..engines.constraints import LoopJoint, Relation
from ..engines.contacts import ZERO, Contact, Planets, Rubbing, UnitWrench
from ..engines.pinocchio.equations import cross
from ..engines.structure import axes, drawn_placements, joints_between
from .description import MACHINE_ELEMENTS, GearMesh, MachineElement, Rack, Screw, Worm
from .document import Document

TAGS = {kind: tag for tag, kind in MACHINE_ELEMENTS.items()}
WORDS = {"gears": "gear mesh", "rack": "rack", "screw": "screw", "worm": "worm", "cam": "cam"}
"""What messages call a contact, by its kind."""

COINCIDE = 1e-6  # points of one axis are apart by less, as files round them [lengths of the linkage]
DEVIATE = 1e-3  # the same in a linkage whose lengths deviate
SHIFTED = 1.5  # most by which profile shift moves axes, of both gears together, before teeth become pointed or are cut away [modules]
ALIGNED = 1e-6  # sine of the angle up to which axes count as parallel or at a right angle


@dataclass(frozen=True, eq=False, repr=False)
class Mesh(Frozen):
    """Two bodies that mesh by teeth or a thread, and the place where they touch.

    Attributes:
        name: of the element.
        kind: "gears", "rack", "screw" or "worm", by the class.
        links: names of its two links, in the order of the element.
        carrier: name of the link in which the pitch point stands still.
        ratio: speed of the second link / speed of the first link, relative to the carrier: of gears about the same axis [rad/rad], of a
            worm about the axes of both joints, of a rack along its guide and of a nut along the screw's axis [m/rad].
        pitch_point: (3,) where they touch, in the carrier's link frame [m].
        centres: (2, 3) points on the axes of the two, each in its link's frame [m]; of a rack the point of the pitch line as drawn.
        axes: (2, 3) unit vectors of these axes, each in its link's frame; of a rack the direction of its guide.
        on_carrier: (2, 3) points of both axes on the carrier, in the world as drawn [m].
        radii: radii of the pitch circles: two of gears and worms, one of a pinion, none of a screw [m].
    """

    kind: ClassVar[str]
    name: str
    links: tuple[str, str]
    carrier: str
    ratio: float
    pitch_point: Array
    centres: Array
    axes: Array
    on_carrier: Array
    radii: tuple[float, ...]

    def __repr__(self) -> str:
        return f"<{WORDS[self.kind]} {self.name!r}: {' - '.join(self.links)} on {self.carrier}, {', '.join(self._words())}>"

    def _words(self) -> Iterator[str]:
        yield f"ratio {self.ratio:.6g}"


@dataclass(frozen=True, eq=False, repr=False)
class Gears(Mesh):
    """Two gears that mesh.

    Attributes:
        teeth: numbers of teeth, negative of an internal gear.
        module: of the normal section [m]; without one in the file that of the drawn centre distance.
        pressure_angle: at the pitch point, in the plane across the axes [rad]; with a module in the file the working one.
        helix: angle of the teeth at the pitch circles [rad].
        efficiency: power passed on / power that rolls through the teeth.
        planets: number of equal planets for which the drawn one stands.
    """

    kind = "gears"
    teeth: tuple[int, int]
    module: float
    pressure_angle: float
    helix: float
    efficiency: float
    planets: int

    def _words(self) -> Iterator[str]:
        yield f"teeth {self.teeth[0]} and {self.teeth[1]}, ratio {self.ratio:.6g}"
        yield f"module {1e3 * self.module:.6g} mm, pressure angle {math.degrees(self.pressure_angle):.6g} deg"


@dataclass(frozen=True, eq=False, repr=False)
class RackAndPinion(Mesh):
    """A pinion and its rack.

    Attributes:
        side: of the rack on which the pinion lies, "left" or "right".
        pressure_angle: in the plane across the pinion's axis [rad].
        helix: angle of the teeth [rad].
        efficiency: power that goes on by the power that rolls through the teeth.
    """

    kind = "rack"
    side: str
    pressure_angle: float
    helix: float
    efficiency: float

    def _words(self) -> Iterator[str]:
        yield f"radius {1e3 * self.radii[0]:.6g} mm, pinion {self.side} of the rack"


@dataclass(frozen=True, eq=False, repr=False)
class Threaded(Mesh):
    """Two bodies of which one has a thread, which rubs as a wedge does. Efficiencies are those of the thread alone.

    Attributes:
        lead_angle: of the thread at its mean diameter, of a worm at its pitch circle [rad]; pi/2 for a screw without a diameter.
        efficiency: where the screw or worm drives.
        efficiency_backward: where the nut or wheel drives; 0 or less if the thread locks itself.
    """

    lead_angle: float
    efficiency: float
    efficiency_backward: float

    @property
    def self_locking(self) -> bool:
        """Whether the second body cannot drive the first one."""
        return self.efficiency_backward <= 0.0

    def _words(self) -> Iterator[str]:
        yield f"efficiency {self.efficiency:.4g}"
        yield "locks itself" if self.self_locking else f"backward {self.efficiency_backward:.4g}"


@dataclass(frozen=True, eq=False, repr=False)
class ScrewAndNut(Threaded):
    """A screw and its nut.

    Attributes:
        lead: travel in one turn [m].
        friction_angle: in the thread, with its flanks [rad].
    """

    kind = "screw"
    lead: float
    friction_angle: float

    def _words(self) -> Iterator[str]:
        yield f"lead {1e3 * self.lead:.6g} mm"
        yield from super()._words()


@dataclass(frozen=True, eq=False, repr=False)
class WormAndWheel(Threaded):
    """A worm and its wheel.

    Attributes:
        starts: of the worm.
        teeth: of the wheel.
        module: axial one of the worm [m].
    """

    kind = "worm"
    starts: int
    teeth: int
    module: float

    def _words(self) -> Iterator[str]:
        yield f"starts {self.starts}, teeth {self.teeth}"
        yield from super()._words()


class Placed(NamedTuple):
    """An element in the drawing.

    Attributes:
        mesh: what it is.
        row: coefficients by the indices of joints in v: their sum with the coordinates stays zero.
        contact: what acts where the multiplier of this row is 1; its relation is not known yet.
    """

    mesh: Mesh
    row: Mapping[int, float]
    contact: Contact


class _MeshError(Exception):
    """A problem and its remedy; the element comes first, if it does not fit other elements."""


# ------------------------------------------------------------------------------------------------------------- relations and contacts


def placed(document: Document, model: pin.Model, loops: Sequence[LoopJoint], deviating: bool = False) -> tuple[Placed, ...]:
    """The elements of a URDF in the drawing of its model; raises UrdfError if they cannot mesh. ``deviating``: whether lengths have
    tolerances, by which pins on one axis, and the two centre distances of a planet, differ a little."""
    elements = document.description.machine_elements
    if not elements:
        return ()
    drawing, result = _Drawing(model, loops, DEVIATE if deviating else COINCIDE), []
    for element in elements:
        try:
            result.append(_PLACES[type(element)](element, drawing))
        except _MeshError as fault:
            raise _refusal(document, element, *fault.args) from None
    try:
        result = list(_with_planets(elements, result))
        if not deviating:
            _refuse_unfit_teeth(elements, result)
    except _MeshError as fault:
        raise _refusal(document, *fault.args) from None
    return tuple(result)


def relations_of(
    document: Document,
    elements: Sequence[Placed],
    model: pin.Model,
    loops: Sequence[LoopJoint],
    drivers: Collection[int],
    others: Sequence[Relation],
) -> tuple[Relation, ...]:
    """The relations of elements. Each relation determines a joint that no driver moves and no other relation determines, if possible a
    joint on no loop. A redundant relation, such as that of a second planet, determines a joint that another relation determines too.

    Args:
        document: of the linkage, for messages.
        elements: of the linkage, as `placed`.
        model: of its tree.
        loops: of the linkage.
        drivers: indices of the drivers in v.
        others: other relations of the file.

    Raises:
        UrdfError: two joints that turn together already.
    """
    parents = [int(parent) - 1 for parent in list(model.parents)[1:]]
    on_loops = {joint for loop in loops for joint in joints_between(parents, loop.joint1 - 1, loop.joint2 - 1)}
    related = {frozenset(other.coefficients): f"joint {other.name!r}" for other in others if other.is_pair}
    for element, each in zip(document.description.machine_elements, elements, strict=True):
        pair = frozenset(each.row)
        if len(pair) == 2 and pair in related:
            names = " and ".join(repr(model.names[joint + 1]) for joint in sorted(pair))
            problem = f"joints {names} are related already, by {related[pair]}"
            remedy = "remove one of the two: teeth have both the ratio and its forces"
            raise _refusal(document, element, problem, remedy)
        related[pair] = f"{WORDS[each.mesh.kind]} {each.mesh.name!r}"
    taken = {*drivers, *(other.joint for other in others)}
    wanted = [sorted(each.row, key=lambda joint: (joint in taken, joint in on_loops)) for each in elements]
    chosen = _matched([[joint for joint in joints if joint not in taken] for joints in wanted])
    relations = []
    for k, (element, each) in enumerate(zip(document.description.machine_elements, elements, strict=True)):
        first = chosen.get(k, wanted[k][0])
        row = {first: each.row[first], **each.row}
        relations.append(Relation(element.name, {joint: by / row[first] for joint, by in row.items()}, 0.0, element.line))
    return tuple(relations)


def contacts_of(elements: Sequence[Placed], relations: Sequence[Relation]) -> tuple[Contact, ...]:
    """The contacts of elements, whose relations are among these by their names."""
    indices = {relation.name: k for k, relation in enumerate(relations)}
    contacts = []
    for each in elements:
        k = indices[each.mesh.name]
        by = 1.0 / each.row[relations[k].joint]  # multiplier of the row by the effort on this joint
        contact = _changed(each.contact, partial(np.multiply, by), partial(np.multiply, abs(by)))
        contacts.append(replace(contact, relation=k))
    return tuple(contacts)


def _changed(contact: Contact, change: Callable[[Array], Array], change_push: Callable[[Array], Array]) -> Contact:
    """A contact with other forces and couples, and other forces that push its bodies apart."""
    rubbing = tuple(
        rubs._replace(
            force=change(rubs.force),
            couple=change(rubs.couple),
            push_backward=None if rubs.push_backward is None else change_push(rubs.push_backward),
        )
        for rubs in contact.rubbing
    )
    point, force, couple, push = contact.unit
    return replace(contact, unit=UnitWrench(point, change(force), change(couple), change_push(push)), rubbing=rubbing)


def _matched(choices: Sequence[Sequence[int]]) -> dict[int, int]:
    """Give as many places as possible one of their choices, no choice twice (a matching of a bipartite graph). Earlier places come
    first."""
    holders: dict[int, int] = {}  # choice -> place

    def find(place: int, seen: set[int]) -> bool:
        for choice in choices[place]:
            if choice not in seen:
                seen.add(choice)
                if choice not in holders or find(holders[choice], seen):
                    holders[choice] = place
                    return True
        return False

    for place in range(len(choices)):
        find(place, set())
    return {place: choice for choice, place in holders.items()}


def _refusal(document: Document, element: MachineElement, problem: str, remedy: str) -> UrdfError:
    return UrdfError(document.file, document.called(TAGS[type(element)], element.name), element.line, problem, remedy)


# ------------------------------------------------------------------------------------------------------------------------ the drawing


class _Pin(NamedTuple):
    """A joint or loop about which two bodies can turn: Pinocchio joints of both, its point on each, and its axis (None for a ball), in the
    drawn pose in world axes. The points differ where a loop is drawn open."""

    name: str
    bodies: tuple[int, int]
    points: tuple[Array, Array]
    axis: Array | None

    def seen_from(self, body: int) -> Iterator[tuple[Array, int, Array]]:
        """Its point on a body of its own, the other body and its point there."""
        for this in (0, 1):
            if self.bodies[this] == body:
                yield self.points[this], self.bodies[1 - this], self.points[1 - this]


class _Centre(NamedTuple):
    """A centre of a gear: a point and the direction of its axis in the drawn pose, the pins there, and the points on the axis by the bodies
    that hold it."""

    point: Array
    axis: Array
    pins: tuple[str, ...]
    holders: Mapping[int, Array]


class _Drawing:
    """The tree of a linkage as drawn, in world axes."""

    def __init__(self, model: pin.Model, loops: Sequence[LoopJoint], near: float) -> None:
        self.model, self.places, self.axes = model, drawn_placements(model), axes(model)
        self.parents = [int(parent) - 1 for parent in list(model.parents)[1:]]
        self.directions: list[Array] = [self.places[j].rotation @ axis.direction for j, axis in enumerate(self.axes, 1)]
        self.pins = [
            _Pin(model.names[j], (self.parents[j - 1] + 1, j), (place.translation, place.translation), self.directions[j - 1])
            for j, (place, axis) in enumerate(zip(self.places[1:], self.axes, strict=True), 1)
            if axis.turns
        ]
        for loop in loops:
            one, other = self.places[loop.joint1], self.places[loop.joint2]
            if loop.type != "fixed":
                turning = one.rotation @ loop.rotation1[:, 0] if loop.type == "revolute" else None
                ends = one.act(loop.point1), other.act(loop.point2)
                self.pins.append(_Pin(loop.name, (loop.joint1, loop.joint2), ends, turning))
        turning_first = (direction for direction, axis in zip(self.directions, self.axes, strict=True) if axis.turns)
        self.plane = next(turning_first, np.array([0.0, -1.0, 0.0]))  # the axis of balls, which close loops of a plane
        points = np.array([point for pin_ in self.pins for point in pin_.points] or [np.zeros(3)])
        self.near = near * (float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0)

    def body(self, link: str) -> int:
        """Pinocchio joint of the body that a link is of."""
        return int(self.model.frames[self._frame(link)].parentJoint)

    def place(self, link: str) -> pin.SE3:
        """Placement of a link in the world."""
        frame = self.model.frames[self._frame(link)]
        return self.places[frame.parentJoint] * frame.placement

    def link(self, body: int) -> str:
        """The first link of a body."""
        frames = (frame for frame in self.model.frames if frame.type == pin.BODY and frame.parentJoint == body)
        return next((str(frame.name) for frame in frames if frame.name != "universe"), "the frame")

    def _frame(self, link: str) -> int:
        return int(self.model.getFrameId(link, pin.BODY))

    def centres(self, link: str, at: Sequence[float] | None = None) -> list[_Centre]:
        """Where the axis of a gear may be: at the pins of its body, or at a point ``at`` in the frame of its link alone."""
        body = self.body(link)
        centres: list[_Centre] = []
        wanted = None if at is None else self.place(link).act(np.array(at))
        pins = [(point, self.plane if pin_.axis is None else pin_.axis, pin_) for pin_ in self.pins for point, *_ in pin_.seen_from(body)]
        for point, axis, _ in pins:
            listed = any(_apart(point, other.point, axis) < self.near and _across(axis, other.axis) < ALIGNED for other in centres)
            if not listed and (wanted is None or _apart(point, wanted, axis) < self.near):
                centres.append(self._centre(body, point, axis))
        if wanted is not None and not centres:
            away, nearest = min(((float(np.linalg.norm(point - wanted)), pin_.name) for point, _, pin_ in pins), default=(0.0, ""))
            near = f"{nearest!r} is {1e3 * away:.4g} mm away" if nearest else "it has none at all"
            centre = ", ".join(f"{value:.6g}" for value in at or ())
            problem = f"no pin of link {link!r} is at the centre ({centre}) of its gear: {near}"
            raise _MeshError(problem, "give the place of one of its pins, in the axes of the link")
        return centres

    def _centre(self, body: int, point: Array, axis: Array) -> _Centre:
        """The centre of a gear, with all bodies that pins on its axis join to it, one by one."""
        holders, reached, names = {body: point}, [body], []
        for this in reached:  # grows as it goes
            for pin_ in self.pins:
                for here, other, there in pin_.seen_from(this):
                    coaxial = pin_.axis is None or _across(pin_.axis, axis) < ALIGNED
                    if coaxial and _apart(here, holders[this], axis) < self.near:
                        names.append(pin_.name)
                        if other not in holders:
                            holders[other] = there
                            reached.append(other)
        return _Centre(point, axis, tuple(dict.fromkeys(names)), holders)

    def turn(self, carrier: int, body: int, axis: Array, what: str) -> dict[int, float]:
        """Coefficients of joints whose sum is the angle of a body relative to its carrier, about an axis."""
        result = {}
        for joint, sign in joints_between(self.parents, carrier - 1, body - 1).items():
            if self.axes[joint].turns:
                if _across(self.directions[joint], axis) > ALIGNED:
                    name = self.model.names[joint + 1]
                    problem = f"joint {name!r}, between {what} and the link that carries it, turns about another axis"
                    raise _MeshError(problem, "let a <joint> hold it on that link, and close the loop elsewhere by <loop_joint>")
                result[joint] = sign * float(np.sign(self.directions[joint] @ axis))
        return result

    def way(self, one: int, other: int, axis: Array) -> dict[int, float]:
        """Coefficients of joints whose sum is the travel of a body relative to another one, along an axis to which all guides are
        parallel."""
        between = joints_between(self.parents, one - 1, other - 1).items()
        return {j: sign * float(np.sign(self.directions[j] @ axis)) for j, sign in between if not self.axes[j].turns}

    def guide(self, carrier: int, body: int) -> Array | None:
        """Axis of the guide of a body that moves along a line relative to a carrier, directly or through other bodies; None if it does
        not."""
        between = list(joints_between(self.parents, carrier - 1, body - 1))
        first = next((joint for joint in between if body in (joint + 1, self.parents[joint] + 1)), None)
        if first is None or any(self.axes[j].turns or _across(self.directions[j], self.directions[first]) > ALIGNED for j in between):
            return None
        return self.directions[first]


def _apart(point: Array, other: Array, axis: Array) -> float:
    """Distance of a point from the line through another one along an axis [m]."""
    return math.hypot(*cross(point - other, axis))


def _across(axis: Array, other: Array) -> float:
    """Sine of the angle between two unit vectors."""
    return math.hypot(*cross(axis, other))


def _sum(*parts: tuple[float, Mapping[int, float]]) -> dict[int, float]:
    """The sum of rows of coefficients, each multiplied by its factor; zero coefficients are left out."""
    total: dict[int, float] = {}
    for by, row in parts:
        for joint, coefficient in row.items():
            total[joint] = total.get(joint, 0.0) + by * coefficient
    return {joint: by for joint, by in total.items() if by}


# ------------------------------------------------------------------------------------------------------------------------------ gears


class _Shafts(NamedTuple):
    """The axes of two bodies that mesh, and their carrier: points of both axes on the carrier and the axes, in the world as drawn, the
    points on the bodies themselves, and whether the first one may be a planet about the second."""

    carrier: int
    centres: tuple[Array, Array]
    axes: tuple[Array, Array]
    points: tuple[Array, Array]
    first_is_planet: bool = False


def _shafts(drawing: _Drawing, links: tuple[str, str], named: str, centres: Sequence[list[_Centre]], crossed: bool) -> _Shafts:
    """The axes of two links, parallel or ``crossed`` at a right angle, that one carrier holds apart; ``named``: the carrier's link."""
    bodies = tuple(map(drawing.body, links))
    wanted = drawing.body(named) if named else None
    shafts: dict[int, _Shafts] = {}
    coaxial, skew = False, 0.0
    for one in centres[0]:
        for other in centres[1]:
            off = abs(float(one.axis @ other.axis)) if crossed else _across(one.axis, other.axis)
            common = [body for body in one.holders if body in other.holders and body not in bodies and wanted in (None, body)]
            if common and off > ALIGNED:
                skew = max(skew, off)
                continue
            for body in common:
                ends = one.holders[body], other.holders[body]
                if not crossed and _apart(*ends, one.axis) < drawing.near:
                    coaxial = True
                    continue
                # A planet is held by its carrier alone, a sun or ring also by what the carrier turns on.
                first_is_planet = len(one.holders) == 2 < len(other.holders)
                shafts.setdefault(body, _Shafts(body, ends, (one.axis, other.axis), (one.point, other.point), first_is_planet))
    if len(shafts) > 1:
        carriers = " and ".join(repr(drawing.link(body)) for body in shafts)
        raise _MeshError(
            f"links {carriers} hold both centres", f'name one of them as the carrier: carrier="{drawing.link(next(iter(shafts)))}"'
        )
    if shafts:
        return next(iter(shafts.values()))
    if coaxial:
        problem = f"the centres of {links[0]!r} and {links[1]!r} are in one point: their distance is 0"
        raise _MeshError(problem, "write <mimic>, in a table gears:, for a belt, a chain or a coupling, or correct the centre")
    if crossed and skew:
        raise _MeshError("the axes of worm and wheel are not at a right angle", "turn one of them: other worms are not supported")
    if skew > 0.5:
        raise _MeshError("the axes of the two gears are not parallel", "a worm is for axes that cross; bevel gears are not supported")
    if skew:
        raise _MeshError("the axes of the two gears are not parallel", "write angles in full, 1.5707963267948966 for a quarter turn")
    carried = [_carried(drawing, link, of) for link, of in zip(links, centres, strict=True)]
    holding = f"link {named!r} does not hold both" if named else "no link holds both"
    problem = f"{carried[0]}, {carried[1]}: {holding}, so that the teeth would part"
    raise _MeshError(problem, "let one link carry both axes, or name the gears that mesh")


def _carried(drawing: _Drawing, link: str, centres: Sequence[_Centre]) -> str:
    """What carries the axes of a gear, as text."""
    body = drawing.body(link)
    if not centres:
        return f"link {link!r} has no pin about which it turns"
    pins = (f"{centre.pins[0]!r} by {' and '.join(repr(drawing.link(b)) for b in centre.holders if b != body)}" for centre in centres)
    return f"the axis of {link!r} is carried at {', '.join(pins)}"


def _gears(element: GearMesh, drawing: _Drawing) -> Placed:
    """Two gears."""
    links, z1, z2 = (element.gear1, element.gear2), element.teeth1, element.teeth2
    centres = [drawing.centres(element.gear1, element.center1), drawing.centres(element.gear2, element.center2)]
    shafts = _shafts(drawing, links, element.carrier, centres, crossed=False)
    carrier, (c1, c2), (axis, _) = shafts[:3]
    bodies = drawing.body(element.gear1), drawing.body(element.gear2)
    between = c2 - c1 - ((c2 - c1) @ axis) * axis
    distance = float(np.linalg.norm(between))
    along = between / distance
    r1 = distance * z1 / (z1 + z2)
    point = c1 + r1 * along + 0.5 * ((c2 - c1) @ axis) * axis  # in the middle of the teeth, halfway between the two
    helix, normal, hand = math.radians(element.helix), math.radians(element.pressure_angle), 1.0 if element.hand == "right" else -1.0
    pressure = math.atan(math.tan(normal) / math.cos(helix))
    module = 2 * distance * math.cos(helix) / abs(z1 + z2)
    if element.module:
        module = element.module
        nominal = 0.5 * module * abs(z1 + z2) / math.cos(helix)
        cosine = nominal * math.cos(pressure) / distance
        if cosine >= 1.0 or abs(distance - nominal) > SHIFTED * module:
            raise _MeshError(*_wrong_distance(module, nominal, distance))
        pressure, helix = math.acos(cosine), math.atan(math.tan(helix) * distance / nominal)
    across = cross(axis, along)
    tangential = -(z1 + z2) / distance * across  # of gear 1 on gear 2 where the multiplier of the row is 1
    thrust = 0.0 if element.double_helical else -hand * math.copysign(1.0, r1) * math.tan(helix)
    # Teeth push the external gear of a pair to its own centre.
    to_external = -math.copysign(1.0, r1) * along if z1 > 0 else math.copysign(1.0, distance - r1) * along
    size = abs(z1 + z2) / distance
    push = size * math.tan(pressure) * (-to_external if z1 > 0 else to_external)
    force = tangential + (tangential @ across) * thrust * axis
    arm = (1.0 - element.efficiency) * abs(r1 * z2 / (z1 + z2))
    rubbing = (Rubbing(*bodies, ZERO, size * axis, arm, arm),) if arm else ()
    row = _sum((z1, drawing.turn(carrier, bodies[0], axis, "gear 1")), (z2, drawing.turn(carrier, bodies[1], axis, "gear 2")))
    planet, pin_of, center = (bodies[0], c1, c2) if shafts.first_is_planet else (bodies[1], c2, c1)
    unit, count = UnitWrench(point, force, ZERO, push), round(element.planets)
    teeth: dict[str, Any] = {"teeth": (round(z1), round(z2)), "module": module, "pressure_angle": pressure, "helix": helix}
    teeth |= {"links": links, "ratio": -z1 / z2, "radii": (abs(r1), abs(distance - r1)), "efficiency": element.efficiency, "planets": count}
    planets = Planets(count, planet, pin_of, center, axis)
    return _element(drawing, element, Gears, shafts, row, unit, rubbing, teeth, planets)


def _wrong_distance(module: float, nominal: float, drawn: float) -> tuple[str, str]:
    """The problem of axes that are not as far apart as module and teeth say, and its remedy."""
    problem = f"module {1e3 * module:.6g} mm makes a centre distance of {1e3 * nominal:.6g} mm, and the axes are {1e3 * drawn:.6g} mm apart"
    return problem, "correct the module, the teeth or the pins; without a module it follows from the pins"


def _element(
    drawing: _Drawing,
    element: MachineElement,
    kind: type[Mesh],
    shafts: _Shafts,
    row: Mapping[int, float],
    unit: UnitWrench,
    rubbing: Sequence[Rubbing],
    attributes: Mapping[str, Any],
    planets: Planets | None = None,
) -> Placed:
    """An element from points and directions in the world as drawn; ``attributes``: those of its mesh that the drawing does not say."""
    carrier, on_carrier, axes, points, _ = shafts
    links, link = attributes["links"], getattr(element, "carrier", "") or drawing.link(carrier)
    frames, frame = [drawing.place(name) for name in links], drawing.places[carrier]
    centres = np.array([place.actInv(point) for place, point in zip(frames, points, strict=True)])
    directions = np.array([place.rotation.T @ axis for place, axis in zip(frames, axes, strict=True)])
    touching = drawing.place(link).actInv(unit.point)
    mesh = kind(
        element.name, carrier=link, pitch_point=touching, centres=centres, axes=directions, on_carrier=np.array(on_carrier), **attributes
    )

    def turned(vector: Array) -> Array:
        return np.asarray(frame.rotation.T @ vector)

    if planets is not None:
        planets = planets._replace(pin=frame.actInv(planets.pin), center=frame.actInv(planets.center), axis=turned(planets.axis))
    unit, (first, second) = unit._replace(point=frame.actInv(unit.point)), map(drawing.body, links)
    contact = Contact(element.name, kind.kind, -1, first, second, carrier, unit, tuple(rubbing), planets)
    return Placed(mesh, row, _changed(contact, turned, turned))


def _with_planets(elements: Sequence[MachineElement], places: Sequence[Placed]) -> Iterator[Placed]:
    """The elements; a mesh of a planet gets the number of planets that the planet's other mesh has."""
    for element, each in zip(elements, places, strict=True):
        if isinstance(each.mesh, Gears) and each.contact.planets is not None:
            others = [its for its in places if _on_one_planet(each, its)]
            number = max(its.mesh.planets for its in (each, *others) if isinstance(its.mesh, Gears))
            if each.mesh.planets not in (1, number):
                problem = f"planets is {each.mesh.planets}, and {number} at the planet's other mesh"
                raise _MeshError(element, problem, "write the same number in both")
            drawn = each.contact.planets._replace(number=number)
            if any(drawn.planet not in (its.contact.first, its.contact.second) for its in others):
                planet = each.contact.first if drawn.planet == each.contact.second else each.contact.second
                drawn = drawn._replace(planet=planet, pin=drawn.center, center=drawn.pin)
            each = each._replace(mesh=replace(each.mesh, planets=number), contact=replace(each.contact, planets=drawn))
        yield each


def _shared(one: Placed, other: Placed) -> list[tuple[int, int]]:
    """Places of the bodies that two meshes on one carrier share, in the first and in the second one."""
    ends = [(each.contact.first, each.contact.second) for each in (one, other)]
    same = one is not other and one.contact.carrier == other.contact.carrier and {one.mesh.kind, other.mesh.kind} == {"gears"}
    return [(i, j) for i in (0, 1) for j in (0, 1) if same and ends[0][i] == ends[1][j]]


def _on_one_planet(one: Placed, other: Placed) -> bool:
    """Whether two pairs of gears share a planet: their other gears are on one axis of the carrier."""
    apart = [float(np.linalg.norm(one.mesh.on_carrier[1 - i] - other.mesh.on_carrier[1 - j])) for i, j in _shared(one, other)]
    return len(apart) == 1 and apart[0] < 1e-3 * sum(one.mesh.radii)


def _hand(element: GearMesh, gear: int) -> str:
    """Hand of the helix of the first (0) or the second (1) gear; empty without one, or with both."""
    if not element.helix or element.double_helical:
        return ""
    same = gear == 0 or element.teeth1 * element.teeth2 < 0
    return element.hand if same else "left" if element.hand == "right" else "right"


def _refuse_unfit_teeth(elements: Sequence[MachineElement], places: Sequence[Placed]) -> None:
    """Raise `_MeshError` for a gear that has two modules or two hands, and for planets that do not fit."""
    pairs = zip(elements, places, strict=True)
    gears = [(element, each, each.mesh) for element, each in pairs if isinstance(element, GearMesh) and isinstance(each.mesh, Gears)]
    for (other, its, before), (element, each, mesh) in itertools.combinations(gears, 2):
        for i, j in _shared(each, its):
            same = mesh.teeth[i] == before.teeth[j] and bool(element.module) == bool(other.module)
            if same and abs(mesh.module - before.module) > 1e-6 * before.module:
                its_own = f"module {1e3 * mesh.module:.6g} mm, in gear mesh {before.name!r} {1e3 * before.module:.6g} mm"
                remedy = "correct teeth or centre distance: one gear has one module"
                raise _MeshError(element, f"gear {mesh.links[i]!r} has {its_own}", remedy)
            hands = _hand(element, i), _hand(other, j)
            if mesh.teeth[i] == before.teeth[j] and all(hands) and hands[0] != hands[1]:
                problem = f"the helix of gear {mesh.links[i]!r} is {hands[0]}, in gear mesh {before.name!r} {hands[1]}"
                remedy = "correct one hand, that of the first gear: two gears side by side have different hands, a ring that of its pinion"
                raise _MeshError(element, problem, remedy)
            ring, sun = sorted((mesh.teeth[1 - i], before.teeth[1 - j]))
            if same and ring < 0 < sun and _on_one_planet(each, its) and (sun - ring) % mesh.planets:
                problem = f"{mesh.planets} planets do not fit between sun and ring: ({sun} + {-ring})/{mesh.planets} is not whole"
                raise _MeshError(element, problem, "change teeth or planets")


# ------------------------------------------------------------------------------------------------------------- racks, screws, worms


def _rack(element: Rack, drawing: _Drawing) -> Placed:
    """A pinion and its rack."""
    pinion, rack = drawing.body(element.pinion), drawing.body(element.rack)
    wanted = drawing.body(element.carrier) if element.carrier else None
    centres = drawing.centres(element.pinion)
    able = [(centre, body) for centre in centres for body in centre.holders if body != pinion and wanted in (None, body)]
    guided = [(centre, body, guide) for centre, body in able if (guide := drawing.guide(body, rack)) is not None]
    if not guided:
        problem = f"{_carried(drawing, element.pinion, centres)}, and no link that carries the pinion guides {element.rack!r}"
        raise _MeshError(problem, "let one link carry the pinion and guide the rack along a line")
    (centre, carrier, guide), *_ = guided
    axis, middle = centre.axis, centre.holders[carrier]
    if abs(axis @ guide) > ALIGNED:
        raise _MeshError("the rack is not guided across the pinion's axis", "turn the axis of its guide, or that of the pinion")
    helix, hand = math.radians(element.helix), 1.0 if element.hand == "right" else -1.0
    radius = element.radius or 0.5 * element.module * element.teeth / math.cos(helix)
    # The viewer sees x to the right and z up, or what is left of them: the pinion's axis points towards him.
    towards = axis * np.array([1.0, -1.0, 1.0])
    depth = int(np.argmax(np.abs(towards)))
    viewer = axis * np.sign(towards[depth])
    left = cross(viewer, -guide if guide[1 if depth == 2 else 2] < -ALIGNED else guide)  # seen upwards, wherever the guide points
    side = element.side
    if not side:
        points = [drawing.place(element.rack).translation, *(point for pin_ in drawing.pins for point, _, _ in pin_.seen_from(rack))]
        off = next((off for point in points if rack and abs(off := float((middle - point) @ left)) > drawing.near), 0.0)
        if not off:
            raise _MeshError("the drawing does not say on which side of the rack the pinion lies", 'write side="left" or side="right"')
        side = "left" if off > 0.0 else "right"
    outward = -left if side == "left" else left  # from the pinion to the rack
    way = float(cross(axis, outward) @ guide)  # 1: the rack goes along its guide where the pinion turns positively about its axis
    point = middle + radius * outward
    pressure = math.atan(math.tan(math.radians(element.pressure_angle)) / math.cos(helix))
    force = guide - hand * way * math.tan(helix) * axis
    arm = (1.0 - element.efficiency) * radius
    rubbing = (Rubbing(pinion, rack, ZERO, axis, arm, arm),) if arm else ()
    row = _sum((1.0, drawing.way(carrier, rack, guide)), (-way * radius, drawing.turn(carrier, pinion, axis, "the pinion")))
    shafts = _Shafts(carrier, (middle, point), (axis, guide), (centre.point, point))
    unit = UnitWrench(point, force, ZERO, math.tan(pressure) * outward)
    teeth: dict[str, Any] = {"side": side, "pressure_angle": pressure, "helix": helix, "efficiency": element.efficiency}
    teeth |= {"links": (element.pinion, element.rack), "ratio": way * radius, "radii": (radius,)}
    return _element(drawing, element, RackAndPinion, shafts, row, unit, rubbing, teeth)


def _screw(element: Screw, drawing: _Drawing) -> Placed:
    """A screw and its nut."""
    screw, nut = drawing.body(element.screw), drawing.body(element.nut)
    between = joints_between(drawing.parents, screw - 1, nut - 1)  # the first of them stands on the carrier
    turning = [joint for joint in between if drawing.axes[joint].turns]
    sliding = [joint for joint in between if not drawing.axes[joint].turns]
    if len(turning) != 1 or len(sliding) != 1:
        problem = f"between screw and nut are {len(turning)} joints that turn and {len(sliding)} that slide"
        raise _MeshError(
            problem, "let one of the two turn in a <joint>, and let the other one, or its carrier, slide in a <joint> along the same axis"
        )
    joint = turning[0]
    axis, way = drawing.directions[joint], drawing.directions[sliding[0]]
    if _across(axis, way) > ALIGNED:
        raise _MeshError(
            "the nut is not guided along the axis of the screw", "turn the axis of its guide, or of the screw; a pinion has a <rack>"
        )
    per_radian = element.lead / (2 * math.pi) * (1.0 if element.hand == "right" else -1.0)
    ends = drawing.parents[joint] + 1, joint + 1
    turns = screw if screw in ends else nut
    holder = ends[1 - ends.index(turns)] if turns in ends else ends[0]
    origin = drawing.places[joint + 1].translation
    point = origin + ((drawing.place(element.nut).translation - origin) @ axis) * axis
    driving = math.copysign(1.0, per_radian) * axis  # so that a positive effort at a positive speed is the screw that drives
    lead, rho = _thread(element)
    if element.friction and lead + rho >= 0.5 * math.pi:
        raise _MeshError("its thread is so steep that friction locks it where the screw drives", "correct lead, diameter or friction")
    forward, backward = math.tan(lead + rho), math.tan(lead - rho)
    half = 0.5 * element.diameter
    rubbing = []
    if element.friction:
        rubbing.append(Rubbing(screw, nut, ZERO, driving, half * (forward - math.tan(lead)), half * (math.tan(lead) - backward)))
    if element.collar_friction:
        arm = 0.5 * element.collar_friction * element.collar_diameter
        rubbing.append(Rubbing(turns, holder, ZERO, axis, arm, arm))
    row = _sum((1.0, drawing.way(screw, nut, axis)), (-per_radian, {joint: between[joint]}))
    shafts = _Shafts(drawing.parents[min(between)] + 1, (origin, point), (axis, axis), (origin, point))
    unit = UnitWrench(point, axis, -per_radian * axis)
    efficiency, back = (math.tan(lead) / forward, backward / math.tan(lead)) if element.friction else (1.0, 1.0)
    thread: dict[str, Any] = {"lead": element.lead, "lead_angle": lead, "friction_angle": rho}
    thread |= {"efficiency": efficiency, "efficiency_backward": back}
    thread |= {"links": (element.screw, element.nut), "ratio": -per_radian, "radii": ()}
    return _element(drawing, element, ScrewAndNut, shafts, row, unit, rubbing, thread)


def _thread(element: Screw) -> tuple[float, float]:
    """Lead angle at the mean diameter and angle of friction of a thread [rad]."""
    lead = math.atan2(element.lead, math.pi * element.diameter)
    flank = math.atan(math.tan(math.radians(element.flank)) * math.cos(lead))  # in the section across the thread
    return lead, math.atan(element.friction / math.cos(flank))


def _worm(element: Worm, drawing: _Drawing) -> Placed:
    """A worm and its wheel."""
    links = element.worm, element.wheel
    bodies = drawing.body(element.worm), drawing.body(element.wheel)
    centres = [drawing.centres(link) for link in links]
    shafts = _shafts(drawing, links, element.carrier, centres, crossed=True)
    carrier, (c1, c2), (axis1, axis2) = shafts[:3]
    along = cross(axis1, axis2)
    along *= math.copysign(1.0, (c2 - c1) @ along)
    distance = float((c2 - c1) @ along)
    if distance < drawing.near:
        raise _MeshError("the axes of worm and wheel meet: their distance is 0", "draw them apart; bevel gears are not supported")
    z1, z2 = element.starts, element.teeth
    module = element.module or 2 * distance / (element.quotient + z2)
    r2 = 0.5 * module * z2
    r1 = distance - r2
    if not r1 > 0.0 or (element.quotient and abs(r1 - 0.5 * module * element.quotient) > SHIFTED * module):
        nominal = 0.5 * module * (element.quotient + z2)
        raise _MeshError(*_wrong_distance(module, nominal, distance))
    lead = math.atan(0.5 * module * z1 / r1)
    # The pitch point is where both axes are nearest to each other.
    point = c1 + ((c2 - c1) @ axis1) * axis1 + r1 * along
    hand = 1.0 if element.hand == "right" else -1.0
    wheel = math.copysign(1.0, cross(axis2, -along) @ axis1)  # 1: the wheel's teeth go along the worm's axis as it turns positively
    around = cross(axis1, along)  # the way of the worm's teeth
    normal = math.radians(element.pressure_angle)
    by_wheel = z2 / r2  # force along the worm's axis by the multiplier of the row

    def across(friction: float) -> tuple[float, float]:
        """Forces around the worm and apart / force along its axis; friction is negative where the wheel drives."""
        d = math.cos(normal) * math.cos(lead) - friction * math.sin(lead)
        if d <= 0.0:
            raise _MeshError("its thread is so steep that friction locks it where the worm drives", "correct starts, quotient or friction")
        return (math.cos(normal) * math.sin(lead) + friction * math.cos(lead)) / d, math.sin(normal) / d

    (forward, push), (backward, push_back) = across(element.friction), across(-element.friction)
    ideal = math.tan(lead)
    rubbing: tuple[Rubbing, ...] = ()
    if element.friction:
        driving = hand * by_wheel * around  # so that a positive effort at a positive speed is the worm that drives
        rubbing = (Rubbing(*bodies, driving, ZERO, forward - ideal, ideal - backward, by_wheel * push_back * along),)
    row = _sum(
        (hand * z1, drawing.turn(carrier, bodies[0], axis1, "the worm")), (wheel * z2, drawing.turn(carrier, bodies[1], axis2, "the wheel"))
    )
    unit = UnitWrench(point, by_wheel * (axis1 - hand * ideal * around), ZERO, by_wheel * push * along)
    teeth: dict[str, Any] = {"links": links, "ratio": -hand * wheel * z1 / z2, "radii": (r1, r2), "lead_angle": lead}
    teeth |= {"efficiency": ideal / forward, "efficiency_backward": backward / ideal}
    teeth |= {"starts": round(z1), "teeth": round(z2), "module": module}
    return _element(drawing, element, WormAndWheel, shafts, row, unit, rubbing, teeth)


_PLACES: dict[type[MachineElement], Callable[..., Placed]] = {GearMesh: _gears, Rack: _rack, Screw: _screw, Worm: _worm}
