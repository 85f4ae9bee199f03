"""A URDF with ``<loop_joint>`` as a mechanism, for writers of other formats. The text has no errors: a linkage was loaded from it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import pinocchio as pin

from ...common.arguments import LARGEST
from ...common.errors import PinpressError, caution
from ...common.quantities import Array
from .. import description
from ..document import Document, Origin
from ..element import Element
from ..linkage import Linkage
from ..text import MOMENTS
from .mechanism import Follow, Inertia, Joint, Link, Loop, Mechanism, Relation, Shape, Spring


def mechanism_of(document: Document) -> Mechanism:
    """The mechanism that a URDF says."""
    robot, read = document.robot, document.description
    springs = {each.joint: Spring(each.stiffness, each.reference, each.damping) for each in read.joint_springs}
    colours = {material.get("name"): _colour(material) for material in robot.all("material")}
    return Mechanism(
        read.name,
        tuple(_link(link, colours) for link in robot.all("link")),
        tuple(
            _joint(element, joint, springs.get(joint.name), read.armature.get(joint.name, 0.0))
            for element, joint in zip(robot.all("joint"), read.joints, strict=True)
        ),
        tuple(_loop(loop) for loop in read.loops),
        tuple((name, _origin(document.robot)) for name in read.drivers),
        (),
        _origin(robot),
        relations=tuple(_relation(relation) for relation in robot.all("relation")),
    )


def with_machine_elements(mechanism: Mechanism, press: Linkage) -> Mechanism:
    """The mechanism of a linkage that is closed where its joints are at zero, with the relations that its machine elements keep."""
    elements = [(contact.name, press.relations[contact.relation]) for contact in press.contacts if contact.name]
    relations = (
        Relation(name, {press.joints[joint]: value for joint, value in relation.coefficients.items()}, 0.0, mechanism.origin)
        for name, relation in elements
    )
    return replace(mechanism, relations=(*mechanism.relations, *relations))


def doubt_machine_elements(press: Linkage, program: str) -> None:
    """Warn of machine elements that become mere ratios of joints in a program; raises PinpressError for cams."""
    if curves := [relation.name for relation in press.relations if relation.curve is not None]:
        raise PinpressError(f"{press.name}: {program} has no cams, such as {curves[0]!r}: remove it before writing")
    if names := [contact.name for contact in press.contacts if contact.name]:
        problem = f"{program} has no teeth and threads: {', '.join(names)} became ratios of joints, with the same motion and driving torque"
        caution(f"{press.name}: {problem}; only pinpress has their losses and their forces on bearings")


def _origin(element: Element) -> Origin:
    return Origin(str(element), element.line)


def _link(link: Element, colours: Mapping[str, tuple[float, ...] | None]) -> Link:
    inertia = next((inertia_of(inertial) for inertial in link.all("inertial")), None)
    return Link(link.get("name"), inertia, tuple(_shapes(link, colours)), _origin(link))


def inertia_of(inertial: Element) -> Inertia:
    """The inertia that an ``<inertial>`` says."""
    moments = inertial.all("inertia")[0]
    tensor = np.zeros((3, 3))
    for name, i, j in MOMENTS:
        tensor[i, j] = tensor[j, i] = moments.number(name, 0.0)
    return Inertia(inertial.all("mass")[0].number("value", 0.0), place_of(inertial), tensor, _origin(inertial))


def _shapes(link: Element, colours: Mapping[str, tuple[float, ...] | None]) -> Iterator[Shape]:
    for visual in link.all("visual"):
        colour = None
        for material in visual.all("material"):
            colour = _colour(material) or colours.get(material.get("name"))
        for geometry in visual.all("geometry"):
            for shape in geometry.children:
                yield Shape(place_of(visual), shape.tag, shape.attributes, colour)


def _colour(material: Element) -> tuple[float, ...] | None:
    return next((numbers for colour in material.all("color") if (numbers := colour.numbers("rgba"))), None)


def _joint(element: Element, joint: description.Joint, spring: Spring | None, armature: float) -> Joint:
    axis = np.array(next((numbers for each in element.all("axis") if (numbers := each.numbers("xyz"))), (1.0, 0.0, 0.0)))
    limit = {name: each.number(name, np.inf) for each in element.all("limit") for name in ("effort", "velocity")}
    effort, velocity = (value if (value := limit.get(name, np.inf)) < LARGEST else None for name in ("effort", "velocity"))
    dynamics = {name: each.number(name, 0.0) for each in element.all("dynamics") for name in ("damping", "friction")}
    followed = joint.mimic
    mimic = None if followed is None else Follow(followed.leader, followed.multiplier, followed.offset, _origin(element))
    return Joint(
        joint.name,
        "revolute" if joint.type == "continuous" else joint.type,
        joint.parent,
        joint.child,
        place_of(element),
        axis / np.linalg.norm(axis),
        _origin(element),
        joint.limits,
        effort,
        velocity,
        dynamics.get("damping", 0.0),
        dynamics.get("friction", 0.0),
        mimic,
        spring,
        armature,
    )


def _loop(loop: description.Loop) -> Loop:
    ends = [(end.link, _pose(np.array(end.xyz), np.array(end.rpy))) for end in (loop.link1, loop.link2)]
    axis = np.array(loop.axis) if loop.type == "revolute" else None
    origin = Origin(f'<loop_joint name="{loop.name}">', loop.line)
    return Loop(loop.name, loop.type, (ends[0], ends[1]), axis if axis is None else axis / np.linalg.norm(axis), origin)


def _relation(relation: Element) -> Relation:
    coefficients = {joint.get("name"): joint.number("coefficient", 1.0) for joint in relation.all("joint")}
    return Relation(relation.get("name"), coefficients, relation.number("offset", 0.0), _origin(relation))


def place_of(element: Element) -> pin.SE3:
    """The pose in the ``<origin>`` of an element."""
    xyz, rpy = (
        np.array(next((numbers for origin in element.all("origin") if (numbers := origin.numbers(name))), (0.0, 0.0, 0.0)))
        for name in ("xyz", "rpy")
    )
    return _pose(xyz, rpy)


def _pose(xyz: Array, rpy: Array) -> pin.SE3:
    return pin.SE3(pin.rpy.rpyToMatrix(rpy), xyz)
