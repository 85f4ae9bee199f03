"""What a URDF without errors says: its links, joints, loops and drivers, and how they hang together."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from .element import Element

Point = tuple[float, float, float]


@dataclass(frozen=True)
class LoopEnd:
    """One side of a loop: a frame on a link.

    Attributes:
        link: name of the link.
        xyz: position in the link's frame [m].
        rpy: roll, pitch and yaw in the link's frame [rad].
    """

    link: str
    xyz: Point
    rpy: Point


@dataclass(frozen=True)
class Loop:
    """A ``<loop_joint>``: the bearing that closes a loop of the linkage.

    Attributes:
        name: of the loop.
        type: "spherical", "revolute" or "fixed".
        link1: its first side.
        link2: its second side.
        axis: axis of a revolute loop in the frames of both sides.
        line: line of the element.
    """

    name: str
    type: str
    link1: LoopEnd
    link2: LoopEnd
    axis: Point
    line: int


@dataclass(frozen=True)
class Mimic:
    """A gear pair, ``<mimic>``: the joint's coordinate is multiplier x coordinate of the leader + offset.

    Attributes:
        leader: name of the joint that is followed.
        multiplier: ratio of the coordinates.
        offset: [rad or m].
        line: line of the element.
    """

    leader: str
    multiplier: float
    offset: float
    line: int


@dataclass(frozen=True)
class Joint:
    """A ``<joint>`` of the tree.

    Attributes:
        name: of the joint.
        type: "continuous", "revolute", "prismatic" or "fixed".
        parent: name of the parent link.
        child: name of the child link.
        xyz: position of its origin in the frame of the parent link [m].
        mimic: its gear pair, None where it has none.
        line: line of the element.
    """

    name: str
    type: str
    parent: str
    child: str
    xyz: Point
    mimic: Mimic | None
    line: int


@dataclass(frozen=True)
class Description:
    """The contents of a URDF without errors.

    Attributes:
        name: the robot's name.
        root: name of the link that is no joint's child, the frame.
        links: names of the links, in document order.
        joints: the joints of the tree, in document order.
        loops: the loop joints, in document order.
        drivers: names of the joints in ``<transmission>`` elements, each once.
        bodies: see `bodies_of`.
    """

    name: str
    root: str
    links: tuple[str, ...]
    joints: tuple[Joint, ...]
    loops: tuple[Loop, ...]
    drivers: tuple[str, ...]
    bodies: dict[str, str]

    @cached_property
    def carriers(self) -> dict[str, Joint]:
        """The joint that carries each link but the frame."""
        return {joint.child: joint for joint in self.joints}

    @cached_property
    def pins(self) -> dict[str, list[Point]]:
        """Places of each link's joints and loops in its own frame [m]."""
        pins: dict[str, list[Point]] = {link: [(0.0, 0.0, 0.0)] for link in self.links}
        for joint in self.joints:
            pins[joint.parent].append(joint.xyz)
        for loop in self.loops:
            for end in (loop.link1, loop.link2):
                pins[end.link].append(end.xyz)
        return pins

    @cached_property
    def turning(self) -> set[str]:
        """Names of the links that a joint may turn."""
        links: set[str] = set()
        for link in self.bodies:  # the frame first, every link behind the one that carries it
            joint = self.carriers.get(link)
            if joint is not None and (joint.type in ("revolute", "continuous") or joint.parent in links):
                links.add(link)
        return links

    def moves(self, link: str) -> bool:
        """Whether a link is not welded to the frame."""
        return self.bodies[link] != self.root

    def is_on_frame(self, link: str) -> bool:
        """Whether the joint that lets a link move stands on the frame."""
        return self.bodies[self.carriers[self.bodies[link]].parent] == self.root


def describe(robot: Element) -> Description:
    """The contents of a URDF, given its root element."""
    links = tuple(link.get("name") for link in robot.all("link"))
    joints = tuple(_joint(joint) for joint in robot.all("joint"))
    loops = tuple(_loop(loop) for loop in robot.all("loop_joint"))
    bodies = bodies_of(robot)
    drivers = [joint.get("name") for transmission in robot.all("transmission") for joint in transmission.all("joint")]
    return Description(robot.get("name"), next(iter(bodies)), links, joints, loops, tuple(dict.fromkeys(drivers)), bodies)


def bodies_of(robot: Element) -> dict[str, str]:
    """For each link that joints connect to the root, root first, the first link of its body: of those welded together by fixed joints.

    The URDF may have errors.
    """
    joints: dict[str, list[tuple[str, bool]]] = {}
    for joint in robot.all("joint"):
        parent, child = ends_of(joint, "parent", "child")
        joints.setdefault(parent, []).append((child, joint.get("type") == "fixed"))
    children = {child for carried in joints.values() for child, _ in carried}
    reached = [link for link in names(robot, "link") if link not in children][:1]
    bodies = {root: root for root in reached}
    for parent in reached:  # grows as it goes
        for child, fixed in joints.get(parent, ()):
            if child not in bodies:
                bodies[child] = bodies[parent] if fixed else child
                reached.append(child)
    return bodies


def ends_of(element: Element, tag1: str, tag2: str) -> tuple[str, str]:
    """Names of the links that a joint or loop connects, empty where missing."""
    end1, end2 = element.all(tag1), element.all(tag2)
    return end1[0].get("link") if end1 else "", end2[0].get("link") if end2 else ""


def names(robot: Element, tag: str) -> list[str]:
    """Names of the elements with a tag that have one."""
    return [name for element in robot.all(tag) if (name := element.get("name"))]


def _joint(joint: Element) -> Joint:
    parent, child = ends_of(joint, "parent", "child")
    mimic = next((_mimic(element) for element in joint.all("mimic")), None)
    return Joint(joint.get("name"), joint.get("type"), parent, child, _point(joint.all("origin"), "xyz"), mimic, joint.line)


def _mimic(mimic: Element) -> Mimic:
    (multiplier,), (offset,) = mimic.numbers("multiplier") or (1.0,), mimic.numbers("offset") or (0.0,)
    return Mimic(mimic.get("joint"), multiplier, offset, mimic.line)


def _loop(loop: Element) -> Loop:
    axis = _point(loop.all("axis"), "xyz", (1.0, 0.0, 0.0))  # the default of URDF's <axis>
    end1, end2 = (_loop_end(loop.all(tag)[0]) for tag in ("link1", "link2"))
    return Loop(loop.get("name"), loop.get("type"), end1, end2, axis, loop.line)


def _loop_end(end: Element) -> LoopEnd:
    return LoopEnd(end.get("link"), _point([end], "xyz"), _point([end], "rpy"))


def _point(elements: Iterable[Element], name: str, default: Point = (0.0, 0.0, 0.0)) -> Point:
    """Three numbers of the first of the elements; the default where there is none, or it does not say them."""
    x, y, z = next((element.numbers(name) for element in elements), ()) or default
    return x, y, z
