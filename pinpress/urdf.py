"""Reading and checking a linkage's URDF before Pinocchio sees it.

Pinocchio drops much of what it cannot read and carries on: a misspelt ``<axis>`` becomes the x axis, a mass "2,5" no inertia at all. So
everything that enters the mechanics is checked here, and what passes is a file that Pinocchio reads in full.
"""

from __future__ import annotations

import html
import math
import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .errors import UrdfError, suggestion

if TYPE_CHECKING:
    from lxml.etree import _Element as Element

LOOP_TYPES = ("spherical",)
RESERVED_LOOP_TYPES = ("revolute", "fixed")
JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed")
UNSUPPORTED_JOINT_TYPES = {
    "planar": "write two prismatic joints and a revolute one, with links between them",
    "floating": "write the joints that guide the link, or close it with <loop_joint>",
}

# What may stand in each element, in the notation of a DTD: one, "?" for at most one, "*" for any number. Anything else is a misspelling.
# An element without an entry is not looked into.
_CHILDREN = {
    "robot": "link* joint* loop_joint* material* transmission*",
    "link": "inertial? visual* collision*",
    "inertial": "origin? mass inertia",
    "visual": "origin? geometry material?",
    "collision": "origin? geometry",
    "geometry": "box? cylinder? sphere? mesh?",
    "material": "color? texture?",
    "joint": "origin? parent child axis? limit? dynamics? calibration? safety_controller? mimic?",
    "loop_joint": "link1 link2",
}
# The same of attributes; the digit is how many numbers it holds, none means a text.
_ATTRIBUTES = {
    "origin": "xyz3? rpy3?",
    "parent": "link",
    "child": "link",
    "link1": "link xyz3? rpy3?",
    "link2": "link xyz3? rpy3?",
    "axis": "xyz3",
    "mass": "value1",
    "inertia": "ixx1 ixy1 ixz1 iyy1 iyz1 izz1",
    "limit": "lower1? upper1? effort1 velocity1",
    "dynamics": "damping1? friction1?",
    "calibration": "rising1? falling1? reference_position1?",
    "safety_controller": "k_velocity1 k_position1? soft_lower_limit1? soft_upper_limit1?",
    "box": "size3",
    "cylinder": "radius1 length1",
    "sphere": "radius1",
    "mesh": "filename scale3?",
    "color": "rgba4",
    "texture": "filename",
}
# What other programs (ROS, Gazebo, Bullet, MuJoCo) write and Pinocchio does not read; so is all that has a namespace prefix.
_FOREIGN = {
    "robot": "gazebo ros2_control mujoco sensor fixed_frame",
    "link": "sensor self_collision_checking verbose velocity contact audio_source",
    "collision": "verbose contact_coefficients",
    "joint": "joint_properties sensor",
    "limit": "acceleration deceleration jerk",
}
_OPEN_TO_ATTRIBUTES = ("dynamics", "calibration", "safety_controller", "mesh", "color", "texture")  # nothing here enters the mechanics

# Pinocchio's parser takes neither "1_0" nor "nan" nor digits of other scripts, all of which Python's float() does.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_MARKUP = re.compile(r"<!--.*?-->|<!\[CDATA\[.*?\]\]>|<\?.*?\?>|<([^/!?](?:[^\"'>]|\"[^\"]*\"|'[^']*')*)>", re.DOTALL)
_QUOTED = re.compile(r"([^\s=]+)\s*=\s*(?:\"([^\"]*)\"|'([^']*)')")

# A problem without its file: the element at fault, what is wrong, what to write.
_Problem = tuple["Element", str, str]


@dataclass(frozen=True)
class LoopEnd:
    """One side of a loop: a frame on a link, xyz [m] and rpy [rad] in the link's frame."""

    link: str
    xyz: tuple[float, float, float]
    rpy: tuple[float, float, float]


@dataclass(frozen=True)
class Loop:
    """A ``<loop_joint>``: the bearing that closes a loop of the linkage."""

    name: str
    type: str
    link1: LoopEnd
    link2: LoopEnd
    line: int


@dataclass(frozen=True)
class Joint:
    """A ``<joint>`` of the tree."""

    name: str
    type: str
    parent: str
    child: str
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


def read(path: str | os.PathLike[str]) -> Urdf:
    """Reads a URDF; raises UrdfError on its first problem."""
    file, text, robot = _parse(path)
    for problem in _problems(robot):
        raise _error(file, *problem)
    links = tuple(link.get("name") for link in _children(robot, "link"))
    joints = tuple(Joint(joint.get("name"), joint.get("type"), *_ends(joint), joint.sourceline) for joint in _children(robot, "joint"))
    loops = tuple(
        Loop(loop.get("name"), loop.get("type"), _loop_end(loop, "link1"), _loop_end(loop, "link2"), loop.sourceline)
        for loop in _children(robot, "loop_joint")
    )
    drivers = tuple(dict.fromkeys(joint.get("name") for joint in _driven(robot)))
    return Urdf(file, text, robot.get("name"), _roots(robot)[0], links, joints, loops, drivers)


def problems(path: str | os.PathLike[str]) -> Iterator[UrdfError]:
    """Every problem of a URDF, the one that ``read`` raises first; a file that is no XML has just that one."""
    try:
        file, _, robot = _parse(path)
    except UrdfError as error:
        yield error
        return
    for problem in _problems(robot):
        yield _error(file, *problem)


def _parse(path: str | os.PathLike[str]) -> tuple[str, bytes, Element]:
    from lxml import etree  # here, because importing pinpress should not wait for it

    file = os.fspath(path)
    try:
        with open(path, "rb") as stream:
            text = stream.read()
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        reason = getattr(error, "strerror", None) or str(error)
        raise UrdfError(file, None, None, f"cannot be read: {reason}", "give the path of a URDF file") from error
    try:
        document = text.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        line = text.count(b"\n", 0, error.start) + 1
        raise UrdfError(file, None, line, f"is not UTF-8 text (byte {error.start})", "save it in the UTF-8 encoding") from error
    if not document.strip():
        raise UrdfError(file, None, None, "is empty", "write a <robot> element")

    # Recovering, because Pinocchio knows no namespaces and so takes <drake:...> without its xmlns:drake; every other error ends here.
    # The encoding is given, because Pinocchio reads UTF-8 whatever the XML declaration says.
    parser = etree.XMLParser(encoding="utf-8", resolve_entities=False, no_network=True, huge_tree=False, recover=True)
    robot = etree.fromstring(document.encode(), parser)
    for entry in parser.error_log:
        if entry.domain_name != "NAMESPACE":
            raise UrdfError(file, None, entry.line, f"is not well-formed XML: {entry.message}", "correct the XML at this line")
    if robot.getroottree().docinfo.doctype:
        raise UrdfError(file, None, None, "has a document type declaration", "remove <!DOCTYPE ...> and write its entities out")
    body = re.match(r"(\s*<\?.*?\?>)*", document, re.DOTALL)
    for markup in _MARKUP.finditer(document, body.end() if body else 0):
        if markup[0].startswith("<?"):  # Pinocchio's parser takes it for a misplaced XML declaration
            line = document.count("\n", 0, markup.start()) + 1
            raise UrdfError(file, None, line, "has a processing instruction after its first element or comment", f"remove {markup[0]}")
    if _tag(robot) != "robot":
        raise _error(file, robot, "the root element is not <robot>", "give a URDF file")
    for element in robot.iter("*"):
        if re.match(r"\{[^}]*xacro/?\}|xacro:", element.tag):
            raise _error(file, element, "is xacro, not URDF", "expand the file first: xacro press.urdf.xacro > press.urdf")
    _restore_source(robot, document)
    return file, text, robot


def _restore_source(robot: Element, document: str) -> None:
    """Gives elements the line on which their tag starts, not ends, and attributes their tabs and line breaks.

    XML reads those as spaces, but Pinocchio's parser does not, and fails on or drops a number with a line break in it.
    """
    line, start = 1, 0
    tags = (markup for markup in _MARKUP.finditer(document) if markup[1])
    for tag, element in zip(tags, robot.iter("*"), strict=True):
        line, start = line + document.count("\n", start, tag.start()), tag.start()
        if line < 65536:  # all that lxml can set
            element.sourceline = line
        for name, double, single in _QUOTED.findall(tag[1]):
            value = double or single
            if ":" not in name and ("\n" in value or "\t" in value):
                element.set(name, html.unescape(value))


def _problems(robot: Element) -> Iterator[_Problem]:
    if not robot.get("name"):
        yield robot, "has no name", 'write <robot name="press">'
    if robot.get("version", "1.0") not in ("1.0", "1.1"):
        yield robot, f"unknown URDF version {robot.get('version')!r}", 'write version="1.0", or no version'
    yield from _content_problems(robot)
    yield from _name_problems(robot)
    for joint in _children(robot, "joint"):
        yield from _joint_problems(joint)
    yield from _tree_problems(robot)
    yield from _inertia_problems(robot)
    yield from _loop_problems(robot)
    yield from _transmission_problems(robot)


def _content_problems(element: Element) -> Iterator[_Problem]:
    """Elements and attributes that are unknown, missing, twice there, or not the numbers they should be."""
    tag = _tag(element)
    if tag in _ATTRIBUTES:
        yield from _attribute_problems(element)
    if tag not in _CHILDREN:
        return
    words = _CHILDREN[tag].split()
    known, foreign = [word.rstrip("?*") for word in words], _FOREIGN.get(tag, "").split()
    counts = dict.fromkeys(known, 0)
    for child in _children(element):
        name = _tag(child)
        if name in known:
            counts[name] += 1
            if counts[name] == 2 and f"{name}*" not in words:
                yield child, f"a second <{name}> in one <{tag}>", "keep one of them"
            yield from _content_problems(child)
        elif ":" not in name and name not in foreign:
            yield child, f"unknown element <{name}>{suggestion(name, known)}", f"in <{tag}> write one of: {', '.join(known)}"
    for name in known:
        if name in words and counts[name] == 0:
            yield element, f"has no <{name}>", f"write <{name}> in this <{tag}>"
    if tag == "geometry" and sum(counts.values()) != 1:
        yield element, f"has {sum(counts.values())} shapes", f"write just one of: {', '.join(known)}"
    if tag == "material" and element.get("name") is None:
        yield element, "has no name", 'write <material name="...">'


def _attribute_problems(element: Element) -> Iterator[_Problem]:
    tag = _tag(element)
    words = _ATTRIBUTES[tag].split()
    known, foreign = [word.rstrip("?1234") for word in words], _FOREIGN.get(tag, "").split()
    for name, text in element.attrib.items():
        count = _count(tag, name)
        fault = _fault(text, count) if count else None
        if fault:
            plural = f"{count} numbers with spaces between them" if count > 1 else "one number without spaces"
            yield element, f"{name}={text!r}: {fault}", f"write {plural}; decimals after a point"
        elif name not in known and name not in foreign and tag not in _OPEN_TO_ATTRIBUTES and not re.search("[:}]", name):
            yield element, f"unknown attribute {name!r}{suggestion(name, known)}", f"in <{tag}> write: {', '.join(known)}"
        elif name in ("size", "radius", "length") and min(_numbers(element, name) or (1.0,)) <= 0:
            yield element, f"{name}={text!r} is not positive", "write the size in metres"
        elif name == "rgba" and not all(0 <= part <= 1 for part in _numbers(element, name) or ()):
            yield element, f"rgba={text!r} is not from 0 to 1", 'write, for example, rgba="0.5 0.5 0.5 1"'
    for name, word in zip(known, words, strict=True):
        if not word.endswith("?") and element.get(name) in (None, "" if not _count(tag, name) else None):
            yield element, f"has no {name}", f'write <{tag} {name}="..."/>'
    if tag == "dynamics" and element.get("damping") is None and element.get("friction") is None:
        yield element, "has neither damping nor friction", "write one of them, or remove <dynamics>"


def _name_problems(robot: Element) -> Iterator[_Problem]:
    joint_names = [joint.get("name") for joint in _children(robot, "joint")]
    for tag in ("link", "joint", "loop_joint", "material"):
        first: dict[str, Element] = {}
        for element in _children(robot, tag):
            name = element.get("name")
            if not name and tag != "material":
                yield element, "has no name", f'write <{tag} name="...">'
            elif name in first:
                problem = f"the name is already that of the <{tag}> on line {first[name].sourceline}"
                yield element, problem, f"give each <{tag}> its own name"
            elif tag == "loop_joint" and name in joint_names:
                yield element, "the name is already that of a <joint>", "give each bearing, joint or loop, its own name"
            elif tag == "joint" and name == "universe":
                yield element, "the name 'universe' is Pinocchio's own, for the world", "give the joint another name"
            elif tag == "material" and not _children(element, "color") and not _children(element, "texture"):
                yield element, "has neither a colour nor a texture", 'write <color rgba="0.5 0.5 0.5 1"/> in it'
            first.setdefault(name, element)


def _joint_problems(joint: Element) -> Iterator[_Problem]:
    kind, known = joint.get("type"), ", ".join(JOINT_TYPES)
    if not kind:
        yield joint, "has no type", f"write one of: {known}"
    elif kind in UNSUPPORTED_JOINT_TYPES:
        yield joint, f"joint type {kind!r} is not supported", UNSUPPORTED_JOINT_TYPES[kind]
    elif kind not in JOINT_TYPES:
        yield joint, f"unknown joint type {kind!r}{suggestion(kind, JOINT_TYPES)}", f"write one of: {known}"
    for mimic in _children(joint, "mimic"):
        yield mimic, "gear pairs are not supported yet", "remove <mimic>, or close the motion with <loop_joint>"

    limits = _children(joint, "limit")
    if kind in ("revolute", "prismatic") and not limits:
        remedy = 'write <limit lower="..." upper="..." effort="..." velocity="..."/>'
        yield joint, f"a {kind} joint needs a <limit>", f'{remedy} or type="continuous"' if kind == "revolute" else remedy
    for limit in limits:
        for name in ("effort", "velocity"):
            if (_numbers(limit, name) or (0.0,)) < (0.0,):
                yield limit, f"{name} is negative", "write how large it may be, in SI units"
        lower, upper = _numbers(limit, "lower", (0.0,)), _numbers(limit, "upper", (0.0,))
        if kind in ("revolute", "prismatic") and lower and upper and lower > upper:
            yield limit, f"lower ({lower[0]!r}) is above upper ({upper[0]!r})", "exchange them (either is 0 where it is missing)"

    for element in _children(joint, "axis") if kind in ("revolute", "continuous", "prismatic") else ():
        axis = _numbers(element, "xyz")
        if axis is None:
            continue
        largest = max(map(abs, axis))
        if largest == 0:
            yield element, "the axis is zero", 'write its direction, for example xyz="0 -1 0"'
        elif abs(math.hypot(*axis) - 1) > 1e-6:
            scaled = [part / largest for part in axis]  # so that no length overflows
            unit = " ".join(repr(part / math.hypot(*scaled) + 0.0) for part in scaled)
            yield element, f"the axis has length {math.hypot(*axis):.9g}, not 1", f'write xyz="{unit}"'


def _tree_problems(robot: Element) -> Iterator[_Problem]:
    links = [link.get("name") for link in _children(robot, "link")]
    if not links:
        yield robot, "has no <link>", "write the links and joints of the linkage"
    carriers: dict[str, str] = {}
    sound = True
    for joint in _children(robot, "joint"):
        parent, child = _ends(joint)
        unknown = list(_unknown_links(joint, ("parent", "child"), links))
        yield from unknown
        sound = sound and not unknown and bool(parent and child)
        if parent and parent == child:
            sound = False
            yield joint, f"its parent and its child are the same link {parent!r}", "write two links"
        elif child in carriers:
            remedy = "a link has one parent; write the second joint as a <loop_joint>"
            yield joint, f"its child {child!r} is already the child of joint {carriers[child]!r}", remedy
        elif child:
            carriers[child] = joint.get("name")
    if not sound:
        return  # what the joints connect is not known

    roots, bodies = _roots(robot), _bodies(robot)
    lost = [link for link in links if link not in bodies]
    if links and not roots:
        yield robot, "has no root link: every link is some joint's child", "let one link, the frame, be no joint's child"
    elif len(roots) > 1:
        element = next(link for link in _children(robot, "link") if link.get("name") == roots[1])
        yield element, f"there are {len(roots)} root links: {', '.join(roots)}", "connect all but one with a <joint>"
    elif lost and links:
        element = next(link for link in _children(robot, "link") if link.get("name") == lost[0])
        yield element, f"a cycle of joints, not connected to the root: {', '.join(lost)}", "write one joint of the cycle as a <loop_joint>"


def _inertia_problems(robot: Element) -> Iterator[_Problem]:
    bodies = _bodies(robot)
    links = _children(robot, "link")
    frame = _roots(robot)[:1]
    heavy = {bodies.get(link.get("name")) for link in links if _children(link, "inertial")}
    for link in links:
        name = link.get("name")
        moving = name in bodies and bodies[name] not in frame
        if moving and bodies[name] == name and name not in heavy:
            yield link, "it moves, but has no <inertial>, nor has any link welded to it", "write <inertial> with <mass> and <inertia>"
        for inertial in _children(link, "inertial"):
            for element in _children(inertial, "mass"):
                mass = _numbers(element, "value")
                if mass and moving and mass[0] <= 0:
                    yield element, f"the mass {mass[0]!r} of a moving link is not positive", "write it in kg, or remove <inertial>"
                elif mass and mass[0] < 0:
                    yield element, f"the mass {mass[0]!r} is negative", "write it in kg"
            for element in _children(inertial, "inertia"):
                problem = _tensor_problem(element)
                if problem:
                    yield element, problem, "write the moments about the centre of mass [kg m2], products with the sign of -integral xy dm"


def _tensor_problem(inertia: Element) -> str | None:
    """Why no distribution of mass has this inertia tensor; None if one has.

    Principal moments obey I1 + I2 >= I3 >= 0. The tolerance, 1e-6 of the largest, lets the rounded figures of a CAD printout pass.
    All zeros, a point mass, pass too.
    """
    import numpy as np

    moments = [_numbers(inertia, name) for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")]
    if None in moments:
        return None
    xx, xy, xz, yy, yz, zz = (moment[0] for moment in moments if moment)
    scale = max(map(abs, (xx, xy, xz, yy, yz, zz))) or 1.0  # so that nothing overflows
    principal = np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) / scale)
    tolerance = 1e-6 * abs(principal).max()
    shown = ", ".join(f"{float(moment) * scale:.6g}" for moment in principal)
    if principal[0] < -tolerance:
        return f"a principal moment of inertia is negative ({shown})"
    if principal[2] > principal[0] + principal[1] + tolerance:
        return f"the largest principal moment of inertia exceeds the sum of the other two ({shown})"
    return None


def _loop_problems(robot: Element) -> Iterator[_Problem]:
    links = [link.get("name") for link in _children(robot, "link")]
    for loop in _children(robot, "loop_joint"):
        kind, known = loop.get("type"), ", ".join(LOOP_TYPES)
        if not kind:
            yield loop, "has no type", f"write one of: {known}"
        elif kind in RESERVED_LOOP_TYPES:
            yield loop, f"loop type {kind!r} is not supported yet", f"write one of: {known}"
        elif kind not in LOOP_TYPES:
            yield loop, f"unknown loop type {kind!r}{suggestion(kind, LOOP_TYPES)}", f"write one of: {known}"
        yield from _unknown_links(loop, ("link1", "link2"), links)
        ends = {end.get("link") for tag in ("link1", "link2") for end in _children(loop, tag)[:1]}
        if len(ends) == 1 and _children(loop, "link1") and _children(loop, "link2"):
            yield loop, f"link1 and link2 are the same link {ends.pop()!r}", "write the two links that the bearing connects"


def _transmission_problems(robot: Element) -> Iterator[_Problem]:
    types = {joint.get("name"): joint.get("type") for joint in _children(robot, "joint")}
    for transmission in _children(robot, "transmission"):
        if not _children(transmission, "joint"):
            yield transmission, "names no <joint>", 'write <joint name="..."/> in it, the driver'
    for joint in _driven(robot):
        name = joint.get("name")
        if not name:
            yield joint, "has no name", 'write <joint name="..."/>, the driver'
        elif name not in types:
            yield joint, f"no joint {name!r}{suggestion(name, filter(None, types))}", "name a <joint> of this file"
        elif types[name] == "fixed":
            yield joint, f"joint {name!r} is fixed and cannot drive", "name a revolute, continuous or prismatic joint"


def _unknown_links(element: Element, tags: Iterable[str], links: list[str]) -> Iterator[_Problem]:
    for tag in tags:
        for end in _children(element, tag):
            name = end.get("link")
            if name and name not in links:
                yield end, f"no link {name!r}{suggestion(name, filter(None, links))}", "name a <link> of this file"


def _roots(robot: Element) -> list[str]:
    """Links that are no joint's child."""
    children = {_ends(joint)[1] for joint in _children(robot, "joint")}
    return [name for link in _children(robot, "link") if (name := link.get("name")) and name not in children]


def _bodies(robot: Element) -> dict[str, str]:
    """For each link that joints connect to the root, the first link of its body: the links welded together by fixed joints."""
    joints: dict[str, list[Element]] = {}
    for joint in _children(robot, "joint"):
        joints.setdefault(_ends(joint)[0], []).append(joint)
    bodies = {root: root for root in _roots(robot)[:1]}
    reached = list(bodies)
    for parent in reached:  # grows as it goes
        for joint in joints.get(parent, ()):
            child = _ends(joint)[1]
            if child not in bodies:
                bodies[child] = bodies[parent] if joint.get("type") == "fixed" else child
                reached.append(child)
    return bodies


def _driven(robot: Element) -> list[Element]:
    """The ``<joint>`` elements of all transmissions."""
    return [joint for transmission in _children(robot, "transmission") for joint in _children(transmission, "joint")]


def _ends(joint: Element) -> tuple[str, str]:
    """Names of a joint's parent and child link, empty where missing."""
    parent, child = (next((end.get("link", "") for end in _children(joint, tag)), "") for tag in ("parent", "child"))
    return parent, child


def _loop_end(loop: Element, tag: str) -> LoopEnd:
    end = _children(loop, tag)[0]
    (x, y, z), (roll, pitch, yaw) = (_numbers(end, name, (0.0, 0.0, 0.0)) or () for name in ("xyz", "rpy"))
    return LoopEnd(end.get("link"), (x, y, z), (roll, pitch, yaw))


def _numbers(element: Element, name: str, default: tuple[float, ...] | None = None) -> tuple[float, ...] | None:
    """The numbers of an attribute; the default where it is missing, None where it is not what it should be."""
    text = element.get(name)
    if text is None:
        return default
    return None if _fault(text, _count(_tag(element), name)) else tuple(map(float, text.split()))


def _fault(text: str, count: int) -> str | None:
    """Why an attribute does not hold that many numbers, in the way that Pinocchio's parser reads them; None if it does."""
    words = [word for word in text.split(" ") if word] if count > 1 else [text]
    for word in words:
        if not _NUMBER.fullmatch(word) or not math.isfinite(float(word)):
            return f"{word!r} is not a finite number"
    return None if len(words) == count else f"{len(words)} numbers, not {count}"


def _count(tag: str, name: str) -> int:
    """How many numbers an attribute holds; 0 for a text or an unknown attribute."""
    found = re.search(rf"\b{re.escape(name)}(\d)", _ATTRIBUTES[tag])
    return int(found[1]) if found else 0


def _children(element: Element, tag: str | None = None) -> list[Element]:
    """Child elements, without comments and processing instructions."""
    return [child for child in element if isinstance(child.tag, str) and (tag is None or _tag(child) == tag)]


def _tag(element: Element) -> str:
    """The tag as Pinocchio's parser, which knows no namespaces, reads it: with the prefix, if there is one."""
    name: str = element.tag.rpartition("}")[2]
    return f"{element.prefix}:{name}" if element.prefix else name


def _error(file: str, element: Element, problem: str, remedy: str) -> UrdfError:
    """The problem with its place: ``<link name="crank">``, or ``<mass> of <link name="crank">``."""

    def shown(element: Element) -> str:
        name = element.get("name")
        return f"<{_tag(element)}>" if name is None else f'<{_tag(element)} name="{name}">'

    named = [ancestor for ancestor in element.iterancestors() if _tag(ancestor) != "robot"]
    place = f"{shown(element)} of {shown(named[-1])}" if named else shown(element)
    return UrdfError(file, place, element.sourceline, problem, remedy)
