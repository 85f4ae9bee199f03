"""Loops and gears as other programs write them into a URDF, turned into elements of ours in its text; everything else stays to the byte.

Read are
- Drake's ``<drake:ball_constraint>`` and ``<drake:linear_bushing_rpy>`` (Drake's multibody/parsing/parsing_doxygen.h, "Drake Extensions"),
  which `sdf` reads by the same functions: URDF has their values in attributes, SDF as texts,
- ``<loop>`` of URDF+ and ``<constraint>``, as its parser writes it, and ``<coupling>`` (Chignoli, Slotine, Wensing, Kim: URDF+, arXiv
  2411.19753),
- ``<gazebo><joint>``: a joint of SDF, which Gazebo adds to the tree,
- pairs of links ``closing_NAME_1`` and ``closing_NAME_2``, as onshape-to-robot writes them: a ball, with ``closing_NAME_1_z`` a hinge,
- ``<loop_joint>`` with two ``<link1>``, as generators of Isaac Gym's models write it,
- a link ``world`` that is not declared, or to which no joint leads.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator
from dataclasses import replace

import numpy as np
import pinocchio as pin

from ...common.quantities import Array
from ..description import MOST, Description, names
from ..document import Document, Finding, Origin
from ..element import Element, tree
from ..text import Text, tag
from .elements import (
    ALONE,
    direction,
    find_child,
    make_unique,
    need_child,
    numbers,
    origin_of,
    pose_of,
    refuse,
    refuse_unknown,
    refuse_unknown_attributes,
    remark,
    take,
)
from .mechanism import TYPES_OF_LOOPS, Loop, Relation, loop_element, placements, relation_element

BALL, BUSHING, SPRING = "drake:ball_constraint", "drake:linear_bushing_rpy", "drake:linear_spring_damper"
Said = Callable[[Element], str]
"""Returns the name or the numbers in an element, as text."""

_MODEL = "__model__"
_LOOPS = (BALL, BUSHING, "loop", "constraint")
_REFUSED = {
    "drake:joint": "write revolute, continuous, prismatic or fixed joints, or a loop: Pinocchio does not read this element",
    "drake:tendon_constraint": "write a gear pair, <mimic>, where two joints move together",
}


def plain(document: Document) -> Document:
    """The same URDF with loops and gears of other dialects written as ours; the document itself where it has none."""
    robot, file = document.robot, document.file
    for element in robot.all(*_REFUSED):
        refuse(file, element, "cannot be read", _REFUSED[element.tag])
    gazebo = [joint for part in robot.all("gazebo") if not part.attributes for joint in part.all("joint")]
    foreign = [*robot.all(*_LOOPS), *gazebo]
    remarks = (*document.remarks, *_remarks(robot))
    if len(foreign) > MOST["loop_joint"]:
        refuse(file, foreign[MOST["loop_joint"]], f"there are {len(foreign)} loops, more than {MOST['loop_joint']}", ALONE)
    worded = {}
    if gazebo:
        with_text = tree(file, document.text.decode("utf-8-sig").encode(), with_text=True)
        worded = {element.start: element for part in with_text.all("gazebo") for element in part.all("joint")}
    text, taken = Text(document), {*names(robot, "joint"), *names(robot, "loop_joint")}
    origins = dict(document.origins)
    remarks_of_loops = [*_second_ends(robot, text), *_world(document, text, origins)]
    joined = {end.get("link") for loop in robot.all("loop_joint") for end in loop.all("link1", "link2")}
    for element, relation in _couplings(document):
        text.replace(element, relation_element(relation))
        origins[element.line, "relation"] = relation.origin
    for element in foreign:
        if element.tag == "joint":
            loop = _gazebo_joint(file, robot, worded[element.start], taken)
            text.replace(element, f"</gazebo>{loop_element(loop)}<gazebo>")
        else:
            reader = _drake_loop if element.tag in (BALL, BUSHING) else _urdf_plus_loop
            loop = reader(file, robot, element, taken)
            text.replace(element, loop_element(loop))
        if element.tag == BUSHING:
            remarks_of_loops.append(bushing_remark(loop.origin))
        taken.add(loop.name)
        joined |= {link for link, _ in loop.ends}
        origins[element.line, "loop_joint"] = loop.origin
    for link, loop in _closing_frames(file, robot, joined, taken):
        text.insert(link, loop_element(loop))
        origins[link.line, "loop_joint"] = loop.origin
    edited, remarks = text.edited(), (*remarks, *remarks_of_loops)
    return document if (edited, remarks) == (document.text, document.remarks) else Document(file, edited, origins, remarks)


def _remarks(robot: Element) -> Iterator[Finding]:
    for element in robot.all(SPRING):
        yield spring_remark(element)
    for transmission in robot.all("transmission"):
        for actuator in transmission.all("actuator"):
            for element in actuator.all("drake:rotor_inertia"):
                if any(element.numbers("value")):
                    remedy = "give the motor's inertia as a flywheel: flywheel=Flywheel(inertia=...)"
                    yield remark("warning", element, "the inertia of the rotor is not read", remedy)


# ------------------------------------------------------------------------------------------------------------------------------------ Drake


def _drake_loop(file: str, robot: Element, element: Element, taken: set[str]) -> Loop:
    """Drake's loops in URDF, whose names and numbers are attributes; a ``<frame>`` is a place on a link, whose own frame has its name."""
    places = {}
    for frame in robot.all("frame"):
        refuse_unknown_attributes(file, frame, ("name", "link", "xyz", "rpy"))
        places[frame.get("name")] = frame.get("link"), _pose(file, frame)

    def place(end: Element) -> tuple[str, pin.SE3]:
        name = end.get("name")
        return places.get(name, (name, pin.SE3.Identity())) if element.tag == BUSHING else (name, pin.SE3.Identity())

    loop = drake_loop(file, element, lambda number: number.get("value"), place, taken)
    return replace(loop, origin=_origin_of(element, loop.name))


def drake_loop(file: str, element: Element, said: Said, place: Callable[[Element], tuple[str, pin.SE3]], taken: Collection[str]) -> Loop:
    """The loop that a ball constraint or a bushing closes.

    Args:
        file: path of the file, for errors.
        element: the ball constraint (P of body A coincides with Q of body B) or bushing (between frames A and C).
        said: returns the numbers in an element, as text.
        place: returns the link and the place on it of the body or frame that an element names.
        taken: names that the loop may not have.

    Raises:
        UrdfError: an element is missing or faulty, or the bushing is neither a pin nor a ball joint.
    """
    axis = None
    if element.tag == BALL:
        ends = []
        for body, point in (("A", "AP"), ("B", "BQ")):
            link, frame = place(need_child(file, element, f"{BALL}_body_{body}"))
            xyz = need_child(file, element, f"{BALL}_p_{point}")
            ends.append((link, pin.SE3(np.eye(3), frame.act(numbers(file, xyz, said(xyz), 3)))))
    else:
        ends = [place(need_child(file, element, f"drake:bushing_frame{side}")) for side in ("A", "C")]
        axis = _bushing_axis(file, element, said)
    name = element.get("name") or make_unique(f"{'ball' if element.tag == BALL else 'bushing'}_{ends[0][0]}_{ends[1][0]}", taken)
    return Loop(name, "spherical" if axis is None else "revolute", (ends[0], ends[1]), axis, origin_of(element))


def _bushing_axis(file: str, element: Element, said: Said) -> Array | None:
    """(3,) axis of the pin that a bushing stands for, in its frames; None for a ball joint; raises UrdfError if it is neither.

    Torques are about x, y, z (roll, pitch, yaw), forces along them. A pin holds all three directions and two rotations, a ball joint no
    rotation; a rotation without stiffness and damping is not held.
    """
    names = ("torque_stiffness", "torque_damping", "force_stiffness", "force_damping")
    elements = [need_child(file, element, f"drake:bushing_{name}") for name in names]
    torque, damping, force, _ = (numbers(file, of, said(of), 3) for of in elements)
    resisted = [axis for axis in range(3) if torque[axis] or damping[axis]]
    if force.min() > 0 and not resisted:
        return None
    if force.min() > 0 and len(resisted) == 2 and torque[resisted].min() > 0:
        return np.asarray(np.eye(3)[next(axis for axis in range(3) if axis not in resisted)])
    problem = "a bushing is elastic, and this one is neither a pin (held but for the turn about one axis) nor a ball joint (no torques)"
    remedy = "write a <loop_joint> for a rigid bearing; for elastic ones give pp.elasticity.Stiffness"
    refuse(file, element, problem, remedy)


def bushing_remark(origin: Origin) -> Finding:
    """The warning that a bushing is read as a rigid bearing."""
    problem = "it is read as a rigid bearing: its stiffness and damping are not"
    return remark("warning", origin, problem, "write a ball constraint or <loop_joint>, if that is meant")


def spring_remark(element: Element) -> Finding:
    """The warning that a spring between bodies is not read."""
    return remark("warning", element, "a spring between bodies is not read", "give it as a load: loads=[SpringDamper(...)]")


# ------------------------------------------------------------------------------------------------------------------------------------ URDF+


def _urdf_plus_loop(file: str, robot: Element, element: Element, taken: set[str]) -> Loop:
    """A loop of URDF+: its frame is given in both links, ``type`` is that of a joint, and ``axis`` is given in that frame."""
    kind = TYPES_OF_LOOPS.get(element.get("type"))
    if kind is None:
        problem = f"type {element.get('type')!r} closes no loop here" if element.get("type") else "has no type"
        refuse(file, element, problem, "write revolute, continuous, spherical or fixed; make a prismatic joint one of the tree")
    ends = []
    refuse_unknown(file, element, ("predecessor", "successor", "axis", "limit", "dynamics"))
    for side in ("predecessor", "successor"):
        end = need_child(file, element, side)
        refuse_unknown(file, end, ("origin",))
        ends.append((end.get("link"), pose_of_origin(file, end)))
    axis = None
    if kind == "revolute":
        written = find_child(file, element, "axis")
        axis = np.array([1.0, 0.0, 0.0]) if written is None else direction(file, written, written.get("xyz"))
    name = element.get("name") or make_unique(f"loop_{ends[0][0]}_{ends[1][0]}", taken)
    return Loop(name, kind, (ends[0], ends[1]), axis, _origin_of(element, name))


def _couplings(document: Document) -> Iterator[tuple[Element, Relation]]:
    """Gears of URDF+: the sum of the coordinates of the joints that carry the successor is ratio times that of those which carry the
    predecessor, both from the nearest link that carries both on."""
    file, description = document.file, document.description
    determined = {joint.name for joint in description.joints if joint.mimic}
    determined |= {relation.joints[0] for relation in description.relations if relation.joints}
    for element in document.robot.all("coupling"):
        refuse_unknown(file, element, ("predecessor", "successor", "ratio"))
        ends = [need_child(file, element, side) for side in ("predecessor", "successor")]
        chains = [joints_below(description, end.get("link")) for end in ends]
        for end in ends:
            if end.get("link") not in description.bodies:
                refuse(file, end, f"no link {end.get('link')!r} that joints connect to the root", "name a <link> of this file")
        common = set(chains[0]) & set(chains[1])
        before, behind = ([joint for joint in chain if joint not in common] for chain in chains)
        ratio = need_child(file, element, "ratio")
        value = float(numbers(file, ratio, ratio.get("value"), 1)[0])
        if not before or not behind or not value:
            problem = "its ratio is 0" if not value else "no moving joint is between its links on one of their sides"
            refuse(file, element, problem, "name links of two bodies that turn against a third, and their ratio")
        free = [joint for joint in (*behind, *before) if joint not in determined]
        first = next((joint for joint in free if joint not in description.drivers), (free or behind)[0])
        determined.add(first)
        coefficients = dict.fromkeys(behind, 1.0) | dict.fromkeys(before, -value)
        ordered = {first: coefficients.pop(first)} | coefficients
        name = element.get("name") or f"coupling_{first}"
        yield element, Relation(name, ordered, 0.0, _origin_of(element, name))


def joints_below(description: Description, link: str) -> list[str]:
    """Names of the moving joints that carry a link, from it to the root."""
    chain = []
    while joint := description.carriers.get(link):
        chain += [joint.name] if joint.type != "fixed" else []
        link = joint.parent
    return chain


# ------------------------------------------------------------------------------------------------------------- onshape-to-robot, Isaac Gym


def _closing_frames(file: str, robot: Element, ends: Collection[str], taken: set[str]) -> Iterator[tuple[Element, Loop]]:
    """The loops that pairs of links ``closing_NAME_1``, ``closing_NAME_2`` close, each with the first of them: a ball at their origins; a
    hinge, if links ``closing_NAME_1_z``, ``closing_NAME_2_z`` stand on its axis. Links that other loops join, the ``ends``, close none."""
    links = {link.get("name"): link for link in robot.all("link")}
    places: dict[str, pin.SE3] = {}
    for name, link in links.items():
        found = re.fullmatch(r"closing_(.+)_([12])(_z)?", name)
        if found is None or found[3] or name in ends:
            continue
        pair = [f"closing_{found[1]}_{k}" for k in (1, 2)]
        if any(end not in links for end in pair):
            lost = next(end for end in pair if end not in links)
            refuse(file, link, f"it is the one side of a loop, of which the other, link {lost!r}, is missing", "write both, or rename it")
        if found[2] == "2" or pair[1] in ends:
            continue
        places = places or _places(file, robot)
        loop = take(found[1], taken)
        hinge = all(f"{end}_z" in places and end in places for end in pair)
        frames = [pin.SE3.Identity()] * 2
        if hinge:
            along = [(places[end].inverse() * places[f"{end}_z"]).translation for end in pair]
            if not all(map(np.linalg.norm, along)):
                refuse(file, link, f"link '{name}_z' is at the same place, and gives no axis", "move it along the axis of the hinge")
            z = np.array([0.0, 0.0, 1.0])
            turned = [pin.Quaternion.FromTwoVectors(z, direction / np.linalg.norm(direction)).matrix() for direction in along]
            frames = [pin.SE3(rotation, np.zeros(3)) for rotation in turned]
        sides = (pair[0], frames[0]), (pair[1], frames[1])
        yield link, Loop(loop, "revolute" if hinge else "spherical", sides, z if hinge else None, origin_of(link))


def _second_ends(robot: Element, text: Text) -> list[Finding]:
    """Let the second of two ``<link1>`` in a ``<loop_joint>`` be its ``<link2>``."""
    twice = [loop for loop in robot.all("loop_joint") if len(loop.all("link1")) == 2 and not loop.all("link2")]
    for loop in twice:
        second = loop.all("link1")[1]
        text.replace(second, tag("link2", second.attributes))
    count = f"; so are those of {len(twice) - 1} more loops" if len(twice) > 1 else ""
    return [remark("note", loop, f"its second <link1> is read as <link2>{count}", "write <link2>") for loop in twice[:1]]


# ---------------------------------------------------------------------------------------------------------------------------- the world


def _world(document: Document, text: Text, origins: dict[tuple[int, str], Origin]) -> list[Finding]:
    """Declare a link ``world`` that carries joints; and let the one other root float in a world that carries nothing which moves: what that
    means is decided later."""
    robot, joints, links = document.robot, document.description.joints, document.description.links
    children = {joint.child for joint in joints}
    carried = [joint for joint in joints if joint.parent == "world"]
    roots = [link for link in links if link not in children and link != "world"]
    if "world" in children or not ("world" in links or carried):
        return []
    if "world" not in links:
        text.append(robot, tag("link", {"name": "world"}))
    for joint in carried:  # grows as it goes
        carried += [other for other in joints if other.parent == joint.child and other not in carried]
    if len(roots) != 1 or any(joint.type != "fixed" for joint in carried):
        return []
    root = document.find("link", roots[0])
    ends = tag("parent", {"link": "world"}) + tag("child", {"link": roots[0]})
    text.insert(root, tag("joint", {"name": make_unique(f"world_{roots[0]}", {*names(robot, "joint")}), "type": "floating"}, ends))
    origins[root.line, "joint"] = origin_of(root)
    return [remark("note", root, "it floats in link 'world', to which no joint connects it", "write a fixed joint if it stands there")]


# ----------------------------------------------------------------------------------------------------------------------------------- Gazebo


def _gazebo_joint(file: str, robot: Element, joint: Element, taken: set[str]) -> Loop:
    """A joint of SDF as a loop: its pose is that in the frame of the child unless it says otherwise, and it is closed as drawn."""
    kind = TYPES_OF_LOOPS.get(joint.get("type"))
    if kind is None:
        problem = f"a {joint.get('type')} joint closes no loop here" if joint.get("type") else "has no type"
        refuse(file, joint, problem, "write revolute, ball or fixed; make a prismatic joint one of the tree")
    parent, child = (need_child(file, joint, end).text.strip() for end in ("parent", "child"))
    places = _places(file, robot)
    if parent not in places or child not in places:
        lost = parent if parent not in places else child
        refuse(file, joint, f"no link {lost!r} that joints connect to the root", "name a <link> of this file")
    place = places[child]
    for pose in joint.all("pose"):
        refuse_unknown_attributes(file, pose, ("relative_to", "degrees", "rotation_format"))
        place = _frame(file, robot, pose, pose.get("relative_to") or child, places) * pose_of(file, joint)
    axis = None
    if kind == "revolute":
        element = need_child(file, joint, "axis")
        xyz, in_model = need_child(file, element, "xyz"), find_child(file, element, "use_parent_model_frame")
        refuse_unknown_attributes(file, xyz, ("expressed_in",))
        axis = direction(file, element, xyz.text)
        frame = _MODEL if in_model is not None and in_model.text.strip() in ("1", "true") else xyz.get("expressed_in")
        if frame:
            axis = place.rotation.T @ _frame(file, robot, xyz, frame, places).rotation @ axis
    ends = tuple((link, places[link].inverse() * place) for link in (parent, child))
    name = joint.get("name") or make_unique(f"loop_{parent}_{child}", taken)
    return Loop(name, kind, (ends[0], ends[1]), axis, origin_of(joint))


def _frame(file: str, robot: Element, at: Element, name: str, places: dict[str, pin.SE3]) -> pin.SE3:
    """The placement of the frame of a link or joint, or of the model, which is that of the root; ``at``: the element that names it."""
    if name == _MODEL:
        return pin.SE3.Identity()
    for joint in robot.all("joint"):
        if joint.get("name") == name:
            name = need_child(file, joint, "child").get("link")
    if name not in places:
        refuse(file, at, f"no frame {name!r}", "name a link or joint of this file")
    return places[name]


def _places(file: str, robot: Element) -> dict[str, pin.SE3]:
    """Placements of the links in the root's frame, joints at zero, by their names."""
    joints = [
        (parent.get("link"), child.get("link"), pose_of_origin(file, joint))
        for joint in robot.all("joint")
        for parent, child in zip(joint.all("parent"), joint.all("child"), strict=False)
    ]
    children = {child for _, child, _ in joints}
    return placements((link for link in names(robot, "link") if link not in children), joints)


def pose_of_origin(file: str, element: Element) -> pin.SE3:
    """The pose in the ``<origin>`` of an element, identity if it has none."""
    origin = find_child(file, element, "origin")
    if origin is None:
        return pin.SE3.Identity()
    refuse_unknown_attributes(file, origin, ("xyz", "rpy"))
    return _pose(file, origin)


def _pose(file: str, element: Element) -> pin.SE3:
    """The pose in the attributes ``xyz`` and ``rpy`` of an element."""
    xyz, rpy = (numbers(file, element, element.attributes.get(name, "0 0 0"), 3) for name in ("xyz", "rpy"))
    return pin.SE3(pin.rpy.rpyToMatrix(rpy), xyz)


def _origin_of(element: Element, name: str) -> Origin:
    """The origin of an element; one without a name gets that of its loop."""
    return Origin(f'<{element.tag} name="{element.get("name")}">' if element.get("name") else f"<{element.tag}> {name}", element.line)
