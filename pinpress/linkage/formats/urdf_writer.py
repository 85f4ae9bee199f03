"""From our URDF, with ``<loop_joint>``, to the dialects of other programs: other elements for loops, gears and drivers in the same text."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from html import escape
from typing import NoReturn

from ...common.errors import PinpressError
from ..description import MACHINE_ELEMENTS
from ..document import Document
from ..linkage import Linkage
from ..text import Text, as_text, tag
from .dialects import BALL, joints_below
from .mechanism import Loop, Mechanism, Relation, attributes_of_pose
from .urdf import doubt_machine_elements, mechanism_of, with_machine_elements

DIALECTS = ("pinpress", "urdf+", "gazebo", "drake")


def in_dialect(press: Linkage, dialect: str) -> bytes:
    """The text of a linkage's URDF in one of `DIALECTS`; all else in it stays to the byte. Other programs skip ``<relation>`` and machine
    elements, apart from "urdf+".

    - "urdf+": ``<loop>``, ``<coupling>``, also of machine elements, and joints with ``independent="true"`` or "false".
    - "gazebo": ``<gazebo><joint>``. The loops are those of the pose in which joints are at zero, which has to be closed.
    - "drake": ``<drake:ball_constraint>``, for spherical loops alone.

    Raises:
        PinpressError: the dialect does not know an element of the linkage, which the message names.

    Warns:
        PinpressWarning: machine elements, which become couplings or are skipped.
    """
    document = press.document
    text, mechanism = Text(document), with_machine_elements(mechanism_of(document), press)
    if dialect != "pinpress":
        doubt_machine_elements(press, f"the dialect {dialect}")
    writers: Mapping[str, Callable[[Loop], str]] = {"urdf+": _urdf_plus_loop, "gazebo": _gazebo_loop, "drake": _drake_loop}
    for element, loop in zip(text.robot.all("loop_joint"), mechanism.loops if dialect in writers else (), strict=False):
        text.replace(element, writers[dialect](loop))
    if dialect == "drake":
        text.set(text.robot, {"xmlns:drake": "http://drake.mit.edu"})
    if dialect == "urdf+":
        _write_couplings(text, document, mechanism)
        drivers = {name for name, _ in mechanism.drivers}
        for joint in text.robot.all("joint"):
            if joint.get("type") != "fixed":
                text.set(joint, {"independent": "true" if joint.get("name") in drivers else "false"})
    return text.edited()


def _urdf_plus_loop(loop: Loop) -> str:
    ends = zip(("predecessor", "successor"), loop.ends, strict=True)
    content = "".join(tag(side, {"link": link}, tag("origin", attributes_of_pose(place))) for side, (link, place) in ends)
    axis = "" if loop.axis is None else tag("axis", {"xyz": as_text(loop.axis)})
    return tag("loop", {"name": loop.name, "type": loop.type}, content + axis)


def _gazebo_loop(loop: Loop) -> str:
    (parent, _), (child, place) = loop.ends
    rpy = attributes_of_pose(place).get("rpy", "0 0 0")
    axis = "" if loop.axis is None else f"<axis><xyz>{as_text(loop.axis)}</xyz></axis>"
    kind = "ball" if loop.type == "spherical" else loop.type
    pose = f"<pose>{as_text(place.translation)} {rpy}</pose>"
    content = f"<parent>{escape(parent)}</parent><child>{escape(child)}</child>{pose}{axis}"
    return f"<gazebo>{tag('joint', {'name': loop.name, 'type': kind}, content)}</gazebo>"


def _drake_loop(loop: Loop) -> str:
    if loop.type != "spherical":
        raise PinpressError(
            f"loop {loop.name!r} is {loop.type}: Drake's URDF has no rigid constraint but a ball; write SDF or another dialect"
        )
    content = ""
    for body, point, (link, place) in zip("AB", ("AP", "BQ"), loop.ends, strict=True):
        content += tag(f"{BALL}_body_{body}", {"name": link}) + tag(f"{BALL}_p_{point}", {"value": as_text(place.translation)})
    return tag(BALL, {"name": loop.name}, content)


def _write_couplings(text: Text, document: Document, mechanism: Mechanism) -> None:
    """Gears as ``<coupling>``: the joints between two links and the nearest one that carries both, and the ratio of their sums."""
    geared = [(joint.name, joint.follow) for joint in mechanism.joints if joint.follow]
    relations = [Relation(name, {name: 1.0, by.leader: -by.multiplier}, by.offset, by.origin) for name, by in geared]
    elements = [element for joint in text.robot.all("joint") for element in joint.all("mimic")]
    elements += [*text.robot.all("relation"), *text.robot.all(*MACHINE_ELEMENTS)]
    for element, relation in zip(elements, (*relations, *mechanism.relations), strict=True):
        text.remove(element)
        text.append(text.robot, _coupling(document, relation))


def _coupling(document: Document, relation: Relation) -> str:
    def refuse(why: str) -> NoReturn:
        raise PinpressError(f"gear {relation.name!r} has no <coupling> in URDF+: {why}; write another format")

    description, by = document.description, relation.coefficients
    if abs(relation.offset) > 1e-15:
        refuse("it has an offset; write the closed pose as zero (home)")
    first = next(iter(by))
    sides = [[name for name in by if (by[name] == by[first] and len(by) > 2) or name == first]]
    sides.append([name for name in by if name not in sides[0]])
    children = {joint.name: joint.child for joint in description.joints}
    chains = {name: joints_below(description, children[name]) for name in by}
    ends = [max(side, key=lambda name: len(chains[name]), default=first) for side in sides]
    common = set(chains[ends[0]]) & set(chains[ends[1]])
    for side, end in zip(sides, ends, strict=True):
        if set(chains[end]) - common != set(side) or len({by[name] for name in side}) != 1:
            refuse("its joints are not those between two links and the nearest one that carries both")
    ratio = tag("ratio", {"value": as_text([-by[ends[1]] / by[first]])})
    content = tag("predecessor", {"link": children[ends[1]]}) + tag("successor", {"link": children[ends[0]]}) + ratio
    return tag("coupling", {"name": f"{relation.name}_gear"}, content)
