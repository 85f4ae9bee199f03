"""From a `Linkage` back to a URDF: the text from which it was read, in which only the numbers that have changed are replaced.

The text is loaded again before it replaces the file, and refused if a number is not what it should be, but for the rounding of Pinocchio,
which multiplies a centre of mass by the mass and divides by it again.

A counterweight is a number too, the inertia of its link. So that it is seen, a ball of steel of its mass is written as ``<visual
name="added_ballast">`` where it is; read again, it tells what was added to the link.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common import files
from ..common.arguments import truth_value, typed
from ..common.errors import AssemblyError, PinpressError, shown
from ..common.files import path_of
from ..common.quantities import Array
from ..engines.constraints import Coupling, LoopJoint, Relation
from ..engines.structure import Axis, Slot, axes, slots
from . import description, loading
from .checks import assembly as assembly_checks
from .checks import elements as element_checks
from .description import JointSpring
from .document import Document, Finding
from .driving.drivers import settle
from .element import Element
from .formats.mechanism import home_element
from .formats.urdf import inertia_of
from .formats.urdf_writer import DIALECTS, in_dialect
from .home import closed_as_drawn, mount
from .linkage import Linkage
from .text import MOMENTS, Text, as_text, tag

ACCEPTED = 1e-12  # relative difference from the linkage that is accepted of a text: a hundred times the rounding error of turned frames

BALLAST = "added_ballast"  # name of visuals that stand for counterweights
STEEL = 7850.0  # density [kg/m3]
SEEN = 1e-3  # a mass that was added to a link is shown from this share of the link's mass,
FARTHEST = 2.0  # no farther from the link's centre of mass than this, as a share of the linkage's size,
ASIDE = 1e-6  # and written into a file from this share on: a link that is only heavier has no counterweight


@typed
def write_urdf(press: Linkage, path: str | os.PathLike[str], *, home: bool = False, dialect: str = "pinpress") -> Path:
    """Write a linkage, perhaps a changed one, as a URDF that loads to the same numbers, and return its path.

    The text from which the linkage was read is kept to the byte (visuals, comments, elements of other programs), except for the numbers in
    which ``press`` differs: inertias, placements of joints, of welded links and of loops, axes, limits, gear pairs, drivers, the name. A
    changed linkage is made by ``dataclasses.replace(press, model=..., loops=...)``. A revolute loop keeps its ``<axis>``: the frames of its
    ends turn.

    A link whose mass has grown aside of its centre of mass, as by a counterweight, gets a ball of steel of that mass as ``<visual
    name="added_ballast">``, in place of one that it has of before. Pinpress draws a counterweight of this mass there.

    All numbers load to 1e-12 of their sizes, or the file is not written. Masses, positions and limits load to the last bit, or nearly;
    Pinocchio computes centres of mass, inertia tensors, turned frames and sums over links that are welded together from what it reads, and
    rounds them to some 1e-15. Of limits of effort, velocity and friction the upper ones are written.

    Welded links are one body. Where its inertia has changed, the heaviest link takes the difference and the others keep what the text says.
    If no body could have the inertia that is then left for the heaviest, the next one takes the difference; if that is so for each of them,
    the heaviest takes all and the others lose their ``<inertial>``.

    A URDF does not say gravity, nor which link is the slide: give `load` both again. The file is replaced only once it is complete.

    Args:
        press: the linkage.
        path: of the file.
        home: whether joints are at zero in the closed home pose, for programs that start there, and not where the file of the linkage has
            their zeros.
        dialect: how loops, gears and drivers are written: "pinpress", ``<loop_joint>``, or in place of it "urdf+", ``<loop>``,
            ``<coupling>`` and ``independent``; "gazebo", ``<gazebo><joint>``, always in the home pose; "drake",
            ``<drake:ball_constraint>``.

    Raises:
        PinpressError: links, joints, loops or gear pairs are others than in the text; a URDF cannot hold a change (rotorInertia); the
            dialect has no element for a loop or gear; the path cannot be written.
        UrdfError: `load` would refuse the file.
        AssemblyError: `load` would refuse the file.
        SingularityError: `load` would refuse the file.
    """
    if not isinstance(dialect, str) or dialect not in DIALECTS:
        raise PinpressError(f"dialect is {shown(dialect)}: write one of {', '.join(DIALECTS)}")
    if truth_value("home", home) or dialect == "gazebo":
        press = press.drawn_at_home()
    unwritten = f"{path_of('path', path)} (not written)"  # the file's name in errors
    template = press.document
    before = loading.build(template, press.motors, press.slide)
    _check(press, before)
    if not press.home and not closed_as_drawn(press):
        press = replace(press, home=tuple(press.closed.tolist()))
    text = edit_text(template, before, press)
    document = Document(unwritten, text)
    _raise_first(element_checks.errors(document))
    reached = loading.build(document, None, press.slide)
    for what, gap in _gaps(press, reached).items():
        if not gap <= ACCEPTED:
            raise PinpressError(f"{unwritten}: a URDF cannot hold the changed {what} of {press.name}; leave it as in {press.file}")
    if not press.assembly.closes:
        problem = f"{unwritten}: the loops of {press.name} do not close at its home pose; give another, replace(press, home=...)"
        raise AssemblyError(problem, 0.0, float(press.assembly.drawn.gap[0]), press.assembly.drawn.iterations)
    _raise_first(assembly_checks.errors(settle(mount(reached))[0]))
    return files.write(path, in_dialect(reached, dialect))


def drawn_text(press: Linkage) -> bytes:
    """The URDF of a linkage, perhaps a changed one, drawn in its home pose, in which all joints are at zero."""
    before = loading.build(press.document, press.motors, press.slide)
    _check(press, before)
    return edit_text(press.document, before, press.drawn_at_home())


@dataclass(frozen=True, eq=False)
class AddedBallast:
    """What was added to the mass of a body, as a counterweight.

    Attributes:
        before: inertia of the body without it, in the frame of its joint.
        mass: mass [kg].
        centre: (3,) its centre, in that frame [m].
    """

    before: pin.Inertia
    mass: float
    centre: Array


def added_ballasts(press: Linkage) -> dict[int, AddedBallast]:
    """What was added to the masses of a linkage, as `balance` does, by the joint that carries the body: since it was read, and what its
    file says was added before."""
    try:
        before = loading.build(press.document, press.motors, press.slide)
    except PinpressError:  # of a text that was exchanged
        return {}
    if list(before.model.names) != list(press.model.names):
        return {}
    was, now, balls, size = before.model.inertias, press.model.inertias, _balls(press.document, before.model), press.size
    all_added = ((joint, _find_added(_without_balls(was[joint], balls.get(joint, ())), now[joint], size)) for joint in range(len(now)))
    return {joint: added for joint, added in all_added if added is not None}


def _find_added(was: pin.Inertia, now: pin.Inertia, size: float) -> AddedBallast | None:
    """What was added to a body of a linkage of this size [m]; None for less than is `SEEN`."""
    mass = now.mass - was.mass
    if not mass > SEEN * now.mass:
        return None
    centre = (now.mass * now.lever - was.mass * was.lever) / mass
    return AddedBallast(was, mass, centre) if np.linalg.norm(centre - was.lever) < FARTHEST * size else None


def _balls(document: Document, model: pin.Model) -> dict[int, list[tuple[float, pin.SE3]]]:
    """The balls that stand for counterweights, by the joints whose bodies carry them: radius [m], and placement in the joint's frame."""
    found: dict[int, list[tuple[float, pin.SE3]]] = {}
    for link in document.robot.all("link"):
        for visual in filter(is_ballast, link.all("visual")):
            frame = model.frames[model.getFrameId(link.get("name"), pin.BODY)]
            (radius,) = visual.all("geometry")[0].children[0].numbers("radius")
            at = next((place for origin in visual.all("origin") if (place := origin.numbers("xyz"))), (0.0, 0.0, 0.0))
            found.setdefault(frame.parentJoint, []).append((radius, frame.placement * pin.SE3(np.eye(3), np.array(at))))
    return found


def _without_balls(inertia: pin.Inertia, balls: Iterable[tuple[float, pin.SE3]]) -> pin.Inertia:
    """The inertia of a body as its text loads, without the balls that stand for counterweights."""
    for radius, place in balls:
        mass = 4 / 3 * np.pi * min(radius, 1e6) ** 3 * STEEL  # [m]: its cube can be taken
        if SEEN * inertia.mass < mass < inertia.mass:  # else it is none of ours
            inertia = _rest(inertia, [(_body(mass, np.zeros(3), 0.4 * mass * radius**2 * np.eye(3)), place)], pin.SE3.Identity())
    return inertia


def is_ballast(visual: Element) -> bool:
    """Whether a visual is a ball that stands for a counterweight."""
    shapes = [shape for geometry in visual.all("geometry") for shape in geometry.children]
    return (
        visual.get("name") == BALLAST
        and [shape.tag for shape in shapes] == ["sphere"]
        and min(shapes[0].numbers("radius"), default=0.0) > 0
    )


def _ball(added: AddedBallast, link: pin.SE3) -> str:
    """The visual of an added mass, in a link with this placement."""
    radius = (0.75 * added.mass / (np.pi * STEEL)) ** (1 / 3)
    shape = tag("geometry", {}, tag("sphere", {"radius": as_text([radius])}))
    return tag("visual", {"name": BALLAST}, tag("origin", {"xyz": as_text(link.inverse().act(added.centre))}) + shape)


def is_as_read(press: Linkage) -> bool:
    """Whether a linkage is still the one that its URDF describes, perhaps drawn at another crank angle."""
    before = loading.build(press.document, press.motors, press.slide)
    try:
        _check(press, before)
    except PinpressError:
        return False
    of_pose = {"placement of joints and links", "directions of joints and links", "lowerPositionLimit", "upperPositionLimit", "gear pairs"}
    return not set(_gaps(press, before)) - (of_pose if press.zero else set())


def _raise_first(findings: Iterable[Finding]) -> None:
    """Raise the first error as it is: no command lists the others of a file that is not written."""
    for finding in findings:
        if finding.error is not None:
            raise finding.error


# ------------------------------------------------------------------------------------------------------------------ two linkages compared


def _check(press: Linkage, before: Linkage) -> None:
    """Raise PinpressError if a linkage differs from that ``before`` in more than numbers, or has numbers that are not finite."""
    was = _structure(before)
    for what, now in _structure(press).items():
        if now != was[what]:
            raise PinpressError(
                f"{press.name} has other {what} than {press.file}: write_urdf changes numbers alone; edit that file instead"
            )
    for what, numbers, size in _contents(press):
        if size and not np.all(np.isfinite(numbers)):
            raise PinpressError(f"{press.name}: {what}: not finite; write plain numbers, in SI units")


def _structure(press: Linkage) -> dict[str, object]:
    """All that `write_urdf` cannot change, by name."""
    model = press.model
    links = [link for link in press.links if model.existFrame(link, pin.BODY)]
    return {
        "joints": (tuple(model.names), tuple(model.parents)),
        "joint types": [(joint.shortname()[:11], joint.nq) for joint in model.joints],  # JointModelR, JointModelP; not which axis
        "links": [(link, model.frames[model.getFrameId(link, pin.BODY)].parentJoint) for link in links],
        "loops": [(loop.name, loop.joint1, loop.joint2) for loop in press.loops],
        "gear pairs": [(relation.name, relation.joint) for relation in _written(press) if relation.is_pair],
        "relations": [(relation.name, tuple(relation.coefficients)) for relation in _written(press) if not relation.is_pair],
        "machine elements": [relation.name for relation in press.relations if relation.name in _of_elements(press)],
    }


def _gaps(press: Linkage, reached: Linkage) -> dict[str, float]:
    """Quantities in which linkages of one structure differ, and by how much, relative to the sizes of these quantities."""
    gaps = {}
    for (what, values, size), (_, values_reached, _) in zip(_contents(press), _contents(reached), strict=True):
        if not np.array_equal(values, values_reached):
            gaps[what] = float(np.abs(values - values_reached).max()) / size if size else np.inf
    return gaps


def _contents(press: Linkage) -> Iterator[tuple[str, Array, float]]:
    """All numbers that a URDF holds of a linkage: names, arrays, and sizes to which rounding is relative; 0 where nothing is rounded."""
    model = press.model
    places = [*model.jointPlacements, *(_placement(model, link) for link in press.links)]
    lengths = {
        "placement of joints and links": [place.translation for place in places],
        "centres of mass": [inertia.lever if inertia.mass else np.zeros(3) for inertia in model.inertias],
        "loop ends": [end for loop in press.loops for end in (loop.point1, loop.point2)],
    }
    turned = {
        "directions of joints and links": [place.rotation for place in places],
        "directions of loop ends": [end for loop in press.loops for end in (loop.rotation1, loop.rotation2)],
        "joint axes": [axis.direction for axis in axes(model)],
    }
    size = float(np.abs(np.concatenate([np.ravel(values) for values in lengths.values()])).max()) or 1.0
    yield from ((what, np.array(values), size) for what, values in lengths.items())
    yield from ((what, np.array(values), 1.0) for what, values in turned.items())
    for name, inertia in zip(model.names, model.inertias, strict=True):
        yield f"mass on joint {name!r}", np.array(inertia.mass), inertia.mass
        yield f"inertia tensor on joint {name!r}", inertia.inertia, float(np.abs(inertia.inertia).max())
    without_element = "rotorInertia", "rotorGearRatio"  # in URDF
    springs = [(press.joints.index(each.joint), each.stiffness, each.reference, each.damping) for each in press.joint_springs]
    yield "springs in joints", np.array(springs), 0.0
    for name in ("armature", *POSITION_LIMITS.values(), *LIMITS.values(), *DYNAMICS.values(), *without_element):
        yield name, getattr(model, name), 0.0
    yield "loop types", np.array([loop.type for loop in press.loops]), 0.0
    pairs = [Coupling.of(relation) for relation in _written(press) if relation.is_pair]
    yield "gear pairs", np.array([(pair.leader, pair.multiplier, pair.offset) for pair in pairs]), 0.0
    longer = [relation for relation in _written(press) if not relation.is_pair]
    yield "relations", np.array([value for each in longer for value in (*each.coefficients.values(), each.offset)]), 0.0
    yield "teeth and threads", np.array([_row(each, model.nv) for each in press.relations if each.name in _of_elements(press)]), 1.0
    yield "drivers", np.array(press.motors), 0.0
    yield "name", np.array(press.name), 0.0


def _of_elements(press: Linkage) -> set[str]:
    """Names of the machine elements of a linkage, whose relations follow from the drawing."""
    return {each.name for each in press.document.description.elements}


def _written(press: Linkage) -> list[Relation]:
    """The relations whose numbers stand in the text: those of ``<mimic>``, then those of ``<relation>``."""
    return [relation for relation in press.relations if relation.name not in _of_elements(press)]


def _row(relation: Relation, width: int) -> list[float]:
    """Coefficients and offset of a relation, whichever joint it determines, and where its curve starts."""
    by, start = relation.coefficients[min(relation.coefficients)], 0.0 if relation.curve is None else relation.curve.start
    return [relation.coefficients.get(joint, 0.0) / by for joint in range(width)] + [relation.offset / by, start]


# Arrays of the model, by the attributes that they are read from.
POSITION_LIMITS = {"lower": "lowerPositionLimit", "upper": "upperPositionLimit"}
LIMITS = {"effort": "upperEffortLimit", "velocity": "upperVelocityLimit"}
DYNAMICS = {"damping": "damping", "friction": "upperDryFrictionLimit"}
_FIRST = (1.0, 0.0, 0.0)  # axis of a loop's end about which the loop turns


def edit_text(document: Document, before: Linkage, now: Linkage) -> bytes:
    """The URDF's text with the numbers of ``now`` wherever they differ from those ``before``, of the linkage as the text loads."""
    text, read = Text(document), document.description
    old_model, new_model, place_of = before.model, now.model, {name: j for j, name in enumerate(before.joints)}
    if now.name != before.name:
        text.set(text.robot, {"name": now.name})
    joints = list(zip(read.joints, text.robot.all("joint"), strict=True))
    movable = list(zip(axes(old_model), axes(new_model), slots(new_model), strict=True))
    for joint, element in joints:
        j = place_of.get(joint.name, -1)
        text.set_child(element, "origin", _attributes_of_place(_origin(old_model, joint, j), _origin(new_model, joint, j)))
        if joint.type != "fixed":
            _edit_joint(text, element, j, old_model, new_model, *movable[j])
    mimics = [element.all("mimic")[0] for joint, element in joints if joint.mimic]
    count = len(mimics)
    was_related, related = _written(before), _written(now)
    for mimic, *pairs in zip(mimics, was_related[:count], related[:count], strict=True):
        old, pair = map(Coupling.of, pairs)
        text.set(mimic, _attributes_of_changes({"multiplier": (old.multiplier, pair.multiplier), "offset": (old.offset, pair.offset)}))
        if pair.leader != old.leader:
            text.set(mimic, {"joint": now.joints[pair.leader]})
    starts = [{each.name: each.curve.start for each in press.relations if each.curve} for press in (before, now)]
    for cam in text.robot.all("cam"):
        old_start, start = (of[cam.get("name")] for of in starts)
        text.set(cam, {"drawn_at": as_text([math.degrees(start)])} if start != old_start else {})
    for element, was, relation in zip(text.robot.all("relation"), was_related[count:], related[count:], strict=True):
        if (relation.coefficients, relation.offset) != (was.coefficients, was.offset):
            text.set(element, {"offset": as_text([relation.offset])})
            for term, (place, coefficient) in zip(element.all("joint"), relation.coefficients.items(), strict=True):
                text.set(term, {"name": now.joints[place], "coefficient": as_text([coefficient])})
    _edit_springs(text, read.joint_springs, now.joint_springs)
    _edit_rotors(text, before, now)
    for k, (loop, element) in enumerate(zip(read.loops, text.robot.all("loop_joint"), strict=True)):
        _edit_loop(text, element, loop, (old_model, before.loops[k]), (new_model, now.loops[k]))
    _edit_drivers(text, read.drivers, now.motors)
    _edit_home(text, read.home, dict(zip(now.joints, now.home, strict=False)))
    bodies: dict[int, list[_Link]] = {}
    balls = _balls(document, old_model)
    for link, element in zip(now.links, text.robot.all("link"), strict=True):
        carrier = int(new_model.frames[new_model.getFrameId(link, pin.BODY)].parentJoint)
        inertia = next(map(_inertia, element.all("inertial")), None)
        bodies.setdefault(carrier, []).append(_Link(element, _placement(old_model, link), _placement(new_model, link), inertia))
    for carrier, links in bodies.items():
        old, new = old_model.inertias[carrier], new_model.inertias[carrier]
        if new != old or any(link.now != link.before for link in links):
            ball = ""
            if new != old:
                for visual in (visual for link in links for visual in filter(is_ballast, link.element.all("visual"))):
                    text.remove(visual)
                added = _find_added(_without_balls(old, balls.get(carrier, ())), new, now.size)
                if added is not None and np.linalg.norm(added.centre - added.before.lever) > ASIDE * now.size:
                    ball = _ball(added, links[0].now)
            _edit_body(text, links, old, new, ball)
    return text.edited()


def _placement(model: pin.Model, link: str) -> pin.SE3:
    """Placement of a link in the frame of the joint that carries it."""
    return model.frames[model.getFrameId(link, pin.BODY)].placement


# --------------------------------------------------------------------------------------------------------------- joints, loops and drivers


def _origin(model: pin.Model, joint: description.Joint, j: int) -> pin.SE3:
    """Placement of a joint in the frame of its parent link; ``j``: its index in v, of a joint that moves."""
    place = _placement(model, joint.child) if joint.type == "fixed" else model.jointPlacements[j + 1]
    return _placement(model, joint.parent).inverse() * place


def _edit_joint(text: Text, element: Element, j: int, before: pin.Model, now: pin.Model, was: Axis, axis: Axis, slot: Slot) -> None:
    if not np.array_equal(axis.direction, was.direction):
        text.set_child(element, "axis", {"xyz": as_text(axis.direction)})
    for child, names, at in (("limit", POSITION_LIMITS, slot.start), ("limit", LIMITS, j), ("dynamics", DYNAMICS, j)):
        limits = {name: (getattr(before, array)[at], getattr(now, array)[at]) for name, array in names.items()}
        text.set_child(element, child, _attributes_of_changes(limits))


def _edit_springs(text: Text, before: Sequence[JointSpring], now: Sequence[JointSpring]) -> None:
    elements = text.robot.all("joint_spring")
    for element, was, spring in zip(elements, before, now, strict=False):
        if spring != was:
            text.set(element, _attributes_of_spring(spring))
    for element in elements[len(now) :]:
        text.remove(element)
    for spring in now[len(elements) :]:
        text.append(text.robot, tag("joint_spring", _attributes_of_spring(spring)))


def _attributes_of_spring(spring: JointSpring) -> dict[str, str]:
    numbers = {"stiffness": spring.stiffness, "reference": spring.reference, "damping": spring.damping}
    return {"joint": spring.joint} | {name: as_text([number]) for name, number in numbers.items()}


def _edit_rotors(text: Text, before: Linkage, now: Linkage) -> None:
    elements = {element.get("joint"): element for element in text.robot.all("armature")}
    for joint, was, inertia in zip(now.joints, before.model.armature, now.model.armature, strict=True):
        if inertia != was and joint in elements:
            text.set(elements[joint], {"inertia": as_text([inertia])})
        elif inertia != was:
            text.append(text.robot, tag("armature", {"joint": joint, "inertia": as_text([inertia])}))


def _edit_loop(
    text: Text, element: Element, loop: description.Loop, before: tuple[pin.Model, LoopJoint], now: tuple[pin.Model, LoopJoint]
) -> None:
    (old_model, old), (new_model, new), axis = before, now, loop.axis
    if new.type != old.type:
        axis = _FIRST
        text.set(element, {"type": new.type})
        for only_of_revolute in element.all("axis"):
            text.remove(only_of_revolute)
    for end, was, place in zip(("link1", "link2"), _ends(old_model, loop, old, loop.axis), _ends(new_model, loop, new, axis), strict=True):
        text.set(element.all(end)[0], _attributes_of_place(was, place))


def _ends(model: pin.Model, loop: description.Loop, bearing: LoopJoint, axis: tuple[float, float, float]) -> tuple[pin.SE3, pin.SE3]:
    """Placements of a loop's ends in the frames of their links; ``axis``: of the ends, about which the loop turns."""
    turned = pin.Quaternion.FromTwoVectors(np.array(_FIRST), np.array(axis)).matrix()  # as `load` turns it
    end1, end2 = pin.SE3(bearing.rotation1 @ turned.T, bearing.point1), pin.SE3(bearing.rotation2 @ turned.T, bearing.point2)
    return _placement(model, loop.link1.link).inverse() * end1, _placement(model, loop.link2.link).inverse() * end2


def _edit_drivers(text: Text, before: Sequence[str], now: Sequence[str]) -> None:
    """Let the transmissions, which keep their places and contents, name the drivers one after the other."""
    if tuple(now) == tuple(before):
        return
    transmissions = text.robot.all("transmission")
    named = [joint for transmission in transmissions for joint in transmission.all("joint")]
    for joint, driver in zip(named, now, strict=False):
        text.set(joint, {"name": driver})
    kept = named[: len(now)]
    for transmission in transmissions:
        joints = transmission.all("joint")
        idle = [joint for joint in joints if joint not in kept]
        for element in idle if len(idle) < len(joints) else [transmission]:
            text.remove(element)
    for driver in now[len(named) :]:
        text.append(text.robot, tag("transmission", {"name": f"{driver}_drive"}, tag("joint", {"name": driver})))


def _edit_home(text: Text, before: Mapping[str, float], now: Mapping[str, float]) -> None:
    """Write the home pose of a linkage that is not at home as drawn."""
    if dict(now) == dict(before):
        return
    for element in text.robot.all("home"):
        text.remove(element)
    if now:
        text.append(text.robot, home_element(now))


# ------------------------------------------------------------------------------------------------------------------------------- inertias


class _Link(NamedTuple):
    """A ``<link>``, its placement in its body as the text loads and as it shall be, and its inertia in the text, in the link's frame."""

    element: Element
    before: pin.SE3
    now: pin.SE3
    inertia: pin.Inertia  # None if the text gives it none


def _edit_body(text: Text, links: list[_Link], before: pin.Inertia, now: pin.Inertia, visual: str) -> None:
    """Let the inertias of one link, or of links that are welded together, have the sum ``now``, in the joint's frame; ``visual``: what else
    the first of them gets."""
    heavy = sorted((link for link in links if link.inertia), key=lambda link: -link.inertia.mass)
    if not heavy:
        text.append(links[0].element, _inertial(_move(now, links[0].now.inverse())) + visual)
        return
    if visual:
        text.append(links[0].element, visual)
    for carrier in heavy:
        others = [link for link in heavy if link is not carrier]
        new = _rest(now, [(link.inertia, link.now) for link in others], carrier.now)
        if not others or _is_physical(new):
            break
    else:
        carrier, *dropped = heavy
        new = _move(now, carrier.now.inverse())
        for link in dropped:
            text.remove(link.element.all("inertial")[0])
    others = [link for link in heavy if link is not carrier]
    old = _rest(before, [(link.inertia, link.before) for link in others], carrier.before)
    _edit_inertial(text, carrier.element.all("inertial")[0], old, new)


def _edit_inertial(text: Text, inertial: Element, old: pin.Inertia, new: pin.Inertia) -> None:
    text.set(inertial.all("mass")[0], _attributes_of_changes({"value": (old.mass, new.mass)}))
    origin = {} if np.array_equal(old.lever, new.lever) else {"xyz": as_text(new.lever)}
    if not np.array_equal(old.inertia, new.inertia):
        turned = any(any(element.numbers("rpy")) for element in inertial.all("origin"))
        origin |= {"rpy": "0 0 0"} if turned else {}
        moments = {name: (np.nan if turned else old.inertia[i, j], new.inertia[i, j]) for name, i, j in MOMENTS}
        text.set(inertial.all("inertia")[0], _attributes_of_changes(moments))
    text.set_child(inertial, "origin", origin)


def _inertial(inertia: pin.Inertia) -> str:
    origin, mass = tag("origin", {"xyz": as_text(inertia.lever)}), tag("mass", {"value": as_text([inertia.mass])})
    return tag("inertial", {}, origin + mass + tag("inertia", {name: as_text([inertia.inertia[i, j]]) for name, i, j in MOMENTS}))


def _inertia(inertial: Element) -> pin.Inertia:
    """The inertia of an ``<inertial>``, in the link's frame."""
    read = inertia_of(inertial)
    return _move(_body(read.mass, np.zeros(3), read.tensor), read.place)


def _rest(total: pin.Inertia, others: Iterable[tuple[pin.Inertia, pin.SE3]], place: pin.SE3) -> pin.Inertia:
    """The inertia that is left for the link with this ``place``, in its frame: the ``total`` of the body less ``others``, given with
    theirs."""
    for inertia, at in others:
        total = total - _move(inertia, at)
    return _move(total, place.inverse())


def _move(inertia: pin.Inertia, place: pin.SE3) -> pin.Inertia:
    """``place.act(inertia)``, but exact where the place is the identity."""
    return _body(inertia.mass, place.act(inertia.lever), place.rotation @ inertia.inertia @ place.rotation.T)


def _body(mass: float, lever: Array, tensor: Array) -> pin.Inertia:
    body = pin.Inertia.Zero()  # Pinocchio's constructor would refuse the rounded tensor of a thin rod; here the reader judges it
    body.mass, body.lever, body.inertia = mass, lever, (tensor + tensor.T) / 2
    return body


def _is_physical(inertia: pin.Inertia) -> bool:
    """Whether a body can have this inertia, within a rounding error of which the reader accepts a thousand times as much."""
    smallest, middle, largest = np.linalg.eigvalsh(inertia.inertia)
    return bool(inertia.mass > 0 and smallest + middle >= (1 - 1e-9) * largest)  # so the smallest is not negative either


# -------------------------------------------------------------------------------------------------------------------------------- numbers


def _attributes_of_place(old: pin.SE3, new: pin.SE3) -> dict[str, str]:
    """The attributes of a placement that have changed, as text."""
    xyz = {} if np.array_equal(old.translation, new.translation) else {"xyz": as_text(new.translation)}
    return xyz if np.array_equal(old.rotation, new.rotation) else xyz | {"rpy": as_text(pin.rpy.matrixToRpy(new.rotation))}


def _attributes_of_changes(numbers: Mapping[str, tuple[float, float]]) -> dict[str, str]:
    """The attributes whose old and new numbers differ, as text of the new ones."""
    return {name: as_text([new]) for name, (old, new) in numbers.items() if old != new}
