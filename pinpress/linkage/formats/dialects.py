"""Loops as other programs write them into a URDF, turned into ``<loop_joint>`` in its text; everything else stays to the byte.

Read are
- Drake's ``<drake:ball_constraint>`` and ``<drake:linear_bushing_rpy>`` (Drake's multibody/parsing/parsing_doxygen.h, "Drake Extensions"),
  which `sdf` reads by the same functions: URDF has their values in attributes, SDF as texts,
- ``<loop>`` of URDF+ and ``<constraint>``, as its parser writes it (Chignoli, Slotine, Wensing, Kim: URDF+, arXiv 2411.19753),
- ``<gazebo><joint>``: a joint of SDF, which Gazebo adds to the tree.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import replace

import numpy as np
import pinocchio as pin

from ...common.quantities import Array
from ..description import MOST, names
from ..document import Document, Finding, Origin
from ..element import Element, tree
from ..text import Text
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
)
from .mechanism import TYPES_OF_LOOPS, Loop, loop_element

BALL, BUSHING, SPRING = "drake:ball_constraint", "drake:linear_bushing_rpy", "drake:linear_spring_damper"
Said = Callable[[Element], str]
"""Returns the name or the numbers in an element, as text."""

_LOOPS = (BALL, BUSHING, "loop", "constraint")
_REFUSED = {
    "drake:joint": "write revolute, continuous, prismatic or fixed joints, or a loop: Pinocchio does not read this element",
    "drake:tendon_constraint": "write a gear pair, <mimic>, where two joints move together",
    "coupling": 'write <mimic joint="..." multiplier="..."/> in the driven joint',
}


def plain(document: Document) -> Document:
    """The same URDF with loops of other dialects written as ``<loop_joint>``; the document itself where it has none."""
    robot, file = document.robot, document.file
    for element in robot.all(*_REFUSED):
        refuse(file, element, "cannot be read", _REFUSED[element.tag])
    gazebo = [joint for part in robot.all("gazebo") if not part.attributes for joint in part.all("joint")]
    foreign = [*robot.all(*_LOOPS), *gazebo]
    remarks = tuple(_remarks(robot))
    if not foreign:
        return Document(file, document.text, remarks=remarks) if remarks else document
    if len(foreign) > MOST["loop_joint"]:
        refuse(file, foreign[MOST["loop_joint"]], f"there are {len(foreign)} loops, more than {MOST['loop_joint']}", ALONE)
    with_text = tree(file, document.text.decode("utf-8-sig").encode(), with_text=True)
    worded = {element.start: element for part in with_text.all("gazebo") for element in part.all("joint")}
    text, taken = Text(document), {*names(robot, "joint"), *names(robot, "loop_joint")}
    origins: dict[tuple[int, str], Origin] = {}
    remarks_of_loops: list[Finding] = []
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
        origins[element.line, "loop_joint"] = loop.origin
    return Document(file, text.edited(), origins, (*remarks, *remarks_of_loops))


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
        ends.append((end.get("link"), _pose_of_origin(file, end)))
    axis = None
    if kind == "revolute":
        written = find_child(file, element, "axis")
        axis = np.array([1.0, 0.0, 0.0]) if written is None else direction(file, written, written.get("xyz"))
    name = element.get("name") or make_unique(f"loop_{ends[0][0]}_{ends[1][0]}", taken)
    return Loop(name, kind, (ends[0], ends[1]), axis, _origin_of(element, name))


# ----------------------------------------------------------------------------------------------------------------------------------- Gazebo


def _gazebo_joint(file: str, robot: Element, joint: Element, taken: set[str]) -> Loop:
    """A joint of SDF as a loop: its pose is that in the frame of the child, and it is closed as drawn."""
    kind = TYPES_OF_LOOPS.get(joint.get("type"))
    if kind is None:
        problem = f"a {joint.get('type')} joint closes no loop here" if joint.get("type") else "has no type"
        refuse(file, joint, problem, "write revolute, ball or fixed; make a prismatic joint one of the tree")
    parent, child = (need_child(file, joint, end).text.strip() for end in ("parent", "child"))
    places = _places(file, robot)
    if parent not in places or child not in places:
        lost = parent if parent not in places else child
        refuse(file, joint, f"no link {lost!r} that joints connect to the root", "name a <link> of this file")
    place = places[child] * pose_of(file, joint)
    axis = None
    if kind == "revolute":
        element = need_child(file, joint, "axis")
        axis = direction(file, element, need_child(file, element, "xyz").text)
        in_model = find_child(file, element, "use_parent_model_frame")
        if in_model is not None and in_model.text.strip() in ("1", "true"):
            axis = place.rotation.T @ axis
    ends = tuple((link, places[link].inverse() * place) for link in (parent, child))
    name = joint.get("name") or make_unique(f"loop_{parent}_{child}", taken)
    return Loop(name, kind, (ends[0], ends[1]), axis, origin_of(joint))


def _places(file: str, robot: Element) -> dict[str, pin.SE3]:
    """Placements of the links in the root's frame, joints at zero, by their names."""
    joints: dict[str, list[tuple[str, pin.SE3]]] = {}
    for joint in robot.all("joint"):
        for parent, child in zip(joint.all("parent"), joint.all("child"), strict=False):
            joints.setdefault(parent.get("link"), []).append((child.get("link"), _pose_of_origin(file, joint)))
    children = {child for carried in joints.values() for child, _ in carried}
    places = {link: pin.SE3.Identity() for link in names(robot, "link") if link not in children}
    reached = list(places)
    for link in reached:  # grows as it goes
        for below, place in joints.get(link, ()):
            if below not in places:
                places[below] = places[link] * place
                reached.append(below)
    return places


def _pose_of_origin(file: str, element: Element) -> pin.SE3:
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
