"""Links, joints, loops and drivers of a URDF, and errors in its elements.

Pinocchio drops much of what it cannot read and carries on: a misspelt ``<axis>`` becomes the x axis, a mass "2,5" no inertia at all.
Therefore `element_checks` first checks everything that enters the mechanics, so that Pinocchio then reads all of a file that passes.
"""

import itertools
import os
from dataclasses import dataclass

from ...common.errors import UrdfError
from . import element_checks
from .document import Document, Element, Finding, check_command, parse, refuse_errors

MOST_ERRORS = 100  # most errors that are listed: each may compare a name with all others, which takes time


@dataclass(frozen=True)
class LoopEnd:
    """One side of a loop: a frame on a link.

    Attributes:
        link: name of the link.
        xyz: position in the link's frame [m].
        rpy: roll, pitch and yaw in the link's frame [rad].
    """

    link: str
    xyz: tuple[float, float, float]
    rpy: tuple[float, float, float]


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
    axis: tuple[float, float, float]
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
        mimic: its gear pair, None where it has none.
        line: line of the element.
    """

    name: str
    type: str
    parent: str
    child: str
    mimic: Mimic | None
    line: int


@dataclass(frozen=True)
class Urdf:
    """The contents of a URDF without errors.

    Attributes:
        file: path of the file.
        text: the file as read, UTF-8, perhaps with a byte order mark.
        name: the robot's name.
        root: name of the link that is no joint's child.
        links: names of the links, in document order.
        joints: the joints of the tree, in document order.
        loops: the loop joints, in document order.
        drivers: names of the joints in ``<transmission>`` elements, each once.
    """

    file: str
    text: bytes
    name: str
    root: str
    links: tuple[str, ...]
    joints: tuple[Joint, ...]
    loops: tuple[Loop, ...]
    drivers: tuple[str, ...]


def read(path: str | os.PathLike[str]) -> Urdf:
    """Read a URDF; raises UrdfError for the first error in it."""
    return describe(checked(path))


def checked(path: str | os.PathLike[str]) -> Document:
    """The elements of a URDF without errors; raises UrdfError for the first error in it."""
    document = parse(path)
    refuse_errors(errors(document), check_command(document.file))
    return document


def errors(document: Document) -> list[Finding]:
    """Errors in the elements of a URDF, before its links are assembled: all of them, or the first `MOST_ERRORS`."""
    robot = document.robot
    problems = list(element_checks.size_problems(robot))
    if not problems:  # checking everything in a file that is too large would take long
        every = itertools.chain(element_checks.problems(robot), element_checks.link_problems(robot))
        problems = list(itertools.islice(every, MOST_ERRORS))
    return [Finding.of(UrdfError(document.file, str(element), element.line, *said)) for element, *said in problems]


def describe(document: Document) -> Urdf:
    """The contents of a URDF without errors."""
    robot = document.robot
    links = tuple(link.get("name") for link in robot.all("link"))
    joints = tuple(_joint(joint) for joint in robot.all("joint"))
    loops = tuple(_loop(loop) for loop in robot.all("loop_joint"))
    children = {joint.child for joint in joints}
    root = next(link for link in links if link not in children)
    drivers = [joint.get("name") for transmission in robot.all("transmission") for joint in transmission.all("joint")]
    return Urdf(document.file, document.text, robot.get("name"), root, links, joints, loops, tuple(dict.fromkeys(drivers)))


def _joint(joint: Element) -> Joint:
    parent, child = joint.all("parent")[0].get("link"), joint.all("child")[0].get("link")
    mimic = next((_mimic(element) for element in joint.all("mimic")), None)
    return Joint(joint.get("name"), joint.get("type"), parent, child, mimic, joint.line)


def _mimic(mimic: Element) -> Mimic:
    (multiplier,), (offset,) = mimic.numbers("multiplier") or (1.0,), mimic.numbers("offset") or (0.0,)
    return Mimic(mimic.get("joint"), multiplier, offset, mimic.line)


def _loop(loop: Element) -> Loop:
    x, y, z = next((axis.numbers("xyz") for axis in loop.all("axis")), (1.0, 0.0, 0.0))  # the default of URDF's <axis>
    return Loop(loop.get("name"), loop.get("type"), _loop_end(loop.all("link1")[0]), _loop_end(loop.all("link2")[0]), (x, y, z), loop.line)


def _loop_end(end: Element) -> LoopEnd:
    (x, y, z), (roll, pitch, yaw) = (end.numbers(name) or (0.0, 0.0, 0.0) for name in ("xyz", "rpy"))
    return LoopEnd(end.get("link"), (x, y, z), (roll, pitch, yaw))
