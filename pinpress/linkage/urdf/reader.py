"""Reading a linkage's URDF: the file, its XML elements, and what they say of links, joints, loops and drivers.

Pinocchio drops much of what it cannot read and carries on: a misspelt ``<axis>`` becomes the x axis, a mass "2,5" no inertia at all. So
everything that enters the mechanics is checked first, by `urdf_checks`, and what passes is a file that Pinocchio reads in full.
"""

import itertools
import math
import os
import re
from dataclasses import dataclass, field
from xml.parsers import expat

from ...common import regular_files
from ...common.errors import UrdfError, shown
from . import element_checks as urdf_checks
from . import limits as urdf_limits
from . import link_checks as body_checks
from .findings import Finding, command, refuse

_TEXTS = ("link", "joint", "filename")  # attributes that hold no numbers; all others that are asked for hold one, but
_COUNTS = {"xyz": 3, "rpy": 3, "size": 3, "scale": 3, "rgba": 4}
# Pinocchio's parser takes neither "1_0" nor "nan" nor digits of other scripts, all of which Python's float() does.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_START_TAG = re.compile(rb"<(?:[^\"'>]|\"[^\"]*\"|'[^']*')*>")
_REFERENCE = re.compile(r"&(?:#x([0-9a-fA-F]+)|#([0-9]+)|(\w+));")
_ENTITIES = {"lt": "<", "gt": ">", "amp": "&", "quot": '"', "apos": "'"}
_ATTRIBUTE = re.compile(r"([^\s=\"']+)\s*=\s*(?:\"([^\"]*)\"|'([^']*)')")


@dataclass(frozen=True)
class LoopEnd:
    """One side of a loop: a frame on a link, xyz [m] and rpy [rad] in the link's frame."""

    link: str
    xyz: tuple[float, float, float]
    rpy: tuple[float, float, float]


@dataclass(frozen=True)
class Loop:
    """A ``<loop_joint>``: the bearing that closes a loop of the linkage. ``axis`` of a revolute one: in the frames of both ends."""

    name: str
    type: str
    link1: LoopEnd
    link2: LoopEnd
    axis: tuple[float, float, float]
    line: int


@dataclass(frozen=True)
class Mimic:
    """A ``<mimic>``: the joint's coordinate is ``multiplier`` times that of the joint named ``leader``, plus ``offset`` [rad or m]."""

    leader: str
    multiplier: float
    offset: float
    line: int


@dataclass(frozen=True)
class Joint:
    """A ``<joint>`` of the tree."""

    name: str
    type: str
    parent: str
    child: str
    mimic: Mimic | None
    line: int


@dataclass(frozen=True)
class Urdf:
    """A URDF without problems.

    Attributes:
        text: the file as read, UTF-8, perhaps with a byte order mark.
        root: the link that is no joint's child.
        links: in document order, as are joints and loops.
        drivers: joints named by ``<transmission>`` elements, each once.
    """

    file: str
    text: bytes
    name: str
    root: str
    links: tuple[str, ...]
    joints: tuple[Joint, ...]
    loops: tuple[Loop, ...]
    drivers: tuple[str, ...]


@dataclass(eq=False)
class Element:
    """An XML element as Pinocchio's parser sees it: namespace prefixes are part of names.

    ``line`` and ``start`` are the line and the byte where its tag starts, ``end`` is the byte where its end tag does.
    """

    tag: str
    attributes: dict[str, str]
    line: int
    parent: "Element | None"
    children: list["Element"] = field(default_factory=list)
    start: int = 0
    end: int = 0

    def get(self, name: str) -> str:
        """The attribute, empty where it is missing."""
        return self.attributes.get(name, "")

    def all(self, *tags: str) -> list["Element"]:
        """The children with these tags."""
        return [child for child in self.children if child.tag in tags]

    def numbers(self, name: str) -> tuple[float, ...]:
        """The numbers of an attribute; none where it is missing or not what it should be."""
        return () if name not in self.attributes or self.fault(name) else tuple(map(float, self.get(name).split()))

    def fault(self, name: str) -> str | None:
        """Why an attribute does not hold its numbers, in the way that Pinocchio's parser reads them; None if it does."""
        if name in _TEXTS:
            return None
        count = _COUNTS.get(name, 1)
        words = [word for word in self.get(name).split(" ") if word] if count > 1 else [self.get(name)]
        for word in words:
            if not _NUMBER.fullmatch(word) or not math.isfinite(float(word)):
                return f"{shown(word)} is not a finite number"
        return None if len(words) == count else f"{len(words)} numbers, not {count}"

    def __str__(self) -> str:
        """``<link name="crank">``, or ``<mass> of <link name="crank">``."""
        shown = f'<{self.tag} name="{self.get("name")}">' if "name" in self.attributes else f"<{self.tag}>"
        above = self.parent
        while above is not None and above.parent is not None and above.parent.parent is not None:
            above = above.parent
        return shown if above is None or above.parent is None else f"{shown} of {above}"


@dataclass(frozen=True, eq=False)
class Document:
    """A file that is XML, and whose root is <robot>: its path, its content and its root element."""

    file: str
    text: bytes
    robot: Element


def read(path: str | os.PathLike[str]) -> Urdf:
    """Reads a URDF; raises UrdfError on its first problem."""
    return describe(checked(path))


def checked(path: str | os.PathLike[str]) -> Document:
    """The elements of a URDF without errors; raises UrdfError on its first problem."""
    document = parse(path)
    refuse(errors(document), command(document.file))
    return document


def errors(document: Document) -> list[Finding]:
    """What is wrong with a URDF before its links are put together: all of it, or the first hundred."""
    robot = document.robot
    problems = list(urdf_limits.problems(robot))
    if not problems:  # checking all of what is too large would take long
        every = itertools.chain(urdf_checks.problems(robot), body_checks.problems(robot))
        problems = list(itertools.islice(every, urdf_limits.MOST_ERRORS))
    return [Finding.of(UrdfError(document.file, str(element), element.line, *said)) for element, *said in problems]


def describe(document: Document) -> Urdf:
    """What a URDF without errors says."""
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


def parse(path: str | os.PathLike[str]) -> Document:
    """The elements of a URDF; raises UrdfError where it is no URDF at all."""
    file = regular_files.path_of("path", path)
    try:
        text = regular_files.read(path, urdf_limits.MOST_BYTES)
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        raise UrdfError(file, None, None, f"cannot be read: {regular_files.reason(error)}", "give the path of a URDF file") from error
    try:
        document = text.decode("utf-8-sig")
        odd = text.find(0)  # a null character, as in UTF-16, which Expat would read
    except UnicodeDecodeError as error:
        odd = error.start
    if odd >= 0:
        line = text.count(b"\n", 0, odd) + 1
        raise UrdfError(file, None, line, f"is not UTF-8 text (byte {odd})", "save it in the UTF-8 encoding")
    if not document.strip():
        raise UrdfError(file, None, None, "is empty", "write a <robot> element")
    robot = tree(file, document.encode())
    if robot.tag != "robot":
        raise UrdfError(file, str(robot), robot.line, "the root element is not <robot>", "give a URDF file")
    return Document(file, text, robot)


def tree(file: str, document: bytes) -> Element:
    """The root element of an XML document, UTF-8; raises UrdfError, with ``file`` in its message, where it is too large or no XML."""
    # The encoding is given, because Pinocchio reads UTF-8 whatever the XML declaration says. Expat as it is here knows no namespaces, as
    # Pinocchio does not, and so takes <drake:...> without its xmlns:drake.
    parser = expat.ParserCreate("utf-8")
    opened: list[Element] = []
    roots: list[Element] = []
    count = 0

    def forbid(problem: str, remedy: str, element: str | None = None) -> None:
        raise UrdfError(file, element, parser.CurrentLineNumber, problem, remedy)

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if problem := urdf_limits.too_large(count, tag, attributes):
            forbid(problem, "remove what does not belong to the press")
        attributes |= _broken(document, parser.CurrentByteIndex)
        element = Element(tag, attributes, parser.CurrentLineNumber, opened[-1] if opened else None)
        element.start = parser.CurrentByteIndex
        if tag.startswith("xacro:"):
            forbid("is xacro, not URDF", "expand the file first: xacro press.urdf.xacro > press.urdf", str(element))
        if tag.endswith(":include"):
            forbid("is XInclude, which Pinocchio does not read", "write what it includes in its place", str(element))
        if len(opened) > urdf_limits.DEEPEST_ELEMENTS:
            forbid("is nested too deeply", "remove it", str(element))
        (opened[-1].children if opened else roots).append(element)
        opened.append(element)

    def end(_: str) -> None:
        opened.pop().end = parser.CurrentByteIndex

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.StartDoctypeDeclHandler = lambda *_: forbid(
        "has a document type declaration", "write its entities out, and remove <!DOCTYPE ...>"
    )
    parser.ProcessingInstructionHandler = lambda name, _: forbid("has a processing instruction", f"remove <?{name} ...?>")
    try:
        parser.Parse(document, True)
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        raise UrdfError(file, None, error.lineno, f"is not well-formed XML: {reason}", "correct the XML at this line") from error
    return roots[0]


def _broken(document: bytes, start: int) -> dict[str, str]:
    """The attributes of the tag that starts there which have tabs or line breaks in them, with these.

    XML reads those as spaces, but Pinocchio's parser does not, and fails on or drops a number with a line break in it.
    """
    tag = _START_TAG.match(document, start)
    found = _ATTRIBUTE.findall(tag[0].decode()) if tag and re.search(rb"[\t\r\n]", tag[0]) else ()
    values = {name: double or single for name, double, single in found}
    return {
        name: _REFERENCE.sub(_meant, re.sub(r"\r\n?|\n\r", "\n", value)) for name, value in values.items() if re.search(r"[\t\r\n]", value)
    }


def _meant(reference: re.Match[str]) -> str:
    """The character that a reference such as ``&#10;`` or ``&lt;`` means."""
    hexadecimal, decimal, name = reference.groups()
    return _ENTITIES[name] if name else chr(int(hexadecimal, 16) if hexadecimal else int(decimal))
