"""What can be wrong with the elements of a URDF: the checks of `urdf.read`, from the single number to the tree as a whole.

Every check yields the elements at fault and goes on, so that a file's problems can be listed together; none may therefore rely on another
having passed.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .errors import suggestion

if TYPE_CHECKING:
    from .urdf import Element

LOOP_TYPES = ("spherical", "revolute", "fixed")
_JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed")
_UNSUPPORTED_JOINT_TYPES = {
    "planar": "write two prismatic joints and a revolute one, with links between them",
    "floating": "write the joints that guide the link, or close it with <loop_joint>",
}

# What may stand in each element: one, "?" for at most one, "*" for any number. Anything else is a misspelling. An element without an entry
# is not looked into.
_CHILDREN = {
    "robot": "link* joint* loop_joint* material* transmission*",
    "link": "inertial? visual* collision*",
    "inertial": "origin? mass inertia",
    "visual": "origin? geometry material?",
    "collision": "origin? geometry",
    "geometry": "box? cylinder? sphere? mesh?",
    "material": "color? texture?",
    "joint": "origin? parent child axis? limit? dynamics? calibration? safety_controller? mimic?",
    "loop_joint": "link1 link2 axis?",
}
# The same of attributes.
_ATTRIBUTES = {
    "origin": "xyz? rpy?",
    "parent": "link",
    "child": "link",
    "link1": "link xyz? rpy?",
    "link2": "link xyz? rpy?",
    "axis": "xyz",
    "mass": "value",
    "inertia": "ixx ixy ixz iyy iyz izz",
    "limit": "lower? upper? effort velocity",
    "mimic": "joint multiplier? offset?",
    "dynamics": "damping? friction?",
    "calibration": "rising? falling? reference_position?",
    "safety_controller": "k_velocity k_position? soft_lower_limit? soft_upper_limit?",
    "box": "size",
    "cylinder": "radius length",
    "sphere": "radius",
    "mesh": "filename scale?",
    "color": "rgba",
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

Problem = tuple["Element", str, str]
"""The element at fault, what is wrong, what to write."""


def problems(robot: "Element") -> Iterator[Problem]:
    """All problems of a URDF."""
    if not robot.get("name"):
        yield robot, "has no name", 'write <robot name="press">'
    if robot.attributes.get("version", "1.0") not in ("1.0", "1.1"):
        yield robot, f"unknown URDF version {robot.get('version')!r}", 'write version="1.0", or no version'
    yield from _content_problems(robot)
    yield from _name_problems(robot)
    for joint in robot.all("joint"):
        yield from _type_problems(joint, "joint", _JOINT_TYPES, _UNSUPPORTED_JOINT_TYPES)
        yield from _joint_problems(joint)
    yield from _tree_problems(robot)
    yield from _inertia_problems(robot)
    for loop in robot.all("loop_joint"):
        yield from _type_problems(loop, "loop", LOOP_TYPES, {})
        yield from _end_problems(loop, "link1", "link2", _names(robot, "link"))
        if loop.get("type") == "revolute":
            yield from _axis_problems(loop)
        elif loop.all("axis"):
            yield loop.all("axis")[0], f"a {loop.get('type')} loop has no axis", 'remove <axis>, or write type="revolute"'
    yield from _mimic_problems(robot)
    yield from _transmission_problems(robot)


def _content_problems(element: "Element") -> Iterator[Problem]:
    """Elements and attributes that are unknown, missing, twice there, or not the numbers they should be."""
    tag = element.tag
    if tag in _ATTRIBUTES:
        yield from _attribute_problems(element)
    if tag not in _CHILDREN:
        return
    words = _CHILDREN[tag].split()
    known, foreign = [word.rstrip("?*") for word in words], _FOREIGN.get(tag, "").split()
    for child in element.children:
        if child.tag in known:
            yield from _content_problems(child)
        elif ":" not in child.tag and child.tag not in foreign:
            yield child, f"unknown element <{child.tag}>{suggestion(child.tag, known)}", f"in <{tag}> write one of: {', '.join(known)}"
    for name, word in zip(known, words, strict=True):
        found = element.all(name)
        if len(found) > 1 and not word.endswith("*"):
            yield found[1], f"a second <{name}> in one <{tag}>", "keep one of them"
        if not found and name == word:
            yield element, f"has no <{name}>", f"write <{name}> in this <{tag}>"
    if tag == "geometry" and len(element.all(*known)) != 1:
        yield element, f"has {len(element.all(*known))} shapes", f"write just one of: {', '.join(known)}"
    if tag == "material" and "name" not in element.attributes:
        yield element, "has no name", 'write <material name="...">'


def _attribute_problems(element: "Element") -> Iterator[Problem]:
    tag = element.tag
    words = _ATTRIBUTES[tag].split()
    known, foreign = [word.rstrip("?") for word in words], _FOREIGN.get(tag, "").split()
    for name, text in element.attributes.items():
        if name not in known:
            if name not in foreign and tag not in _OPEN_TO_ATTRIBUTES and ":" not in name and name != "xmlns":
                yield element, f"unknown attribute {name!r}{suggestion(name, known)}", f"in <{tag}> write: {', '.join(known)}"
        elif fault := element.fault(name):
            yield element, f"{name}={text!r}: {fault}", "write plain numbers, decimals after a point, spaces in between"
        elif name in ("size", "radius", "length") and min(element.numbers(name)) <= 0:
            yield element, f"{name}={text!r} is not positive", "write the size in metres"
        elif name == "rgba" and not all(0 <= part <= 1 for part in element.numbers(name)):
            yield element, f"rgba={text!r} is not from 0 to 1", 'write, for example, rgba="0.5 0.5 0.5 1"'
    for name, word in zip(known, words, strict=True):
        if name == word and not element.get(name):
            yield element, f"has no {name}", f'write <{tag} {name}="..."/>'
    if tag == "dynamics" and not {"damping", "friction"} & element.attributes.keys():
        yield element, "has neither damping nor friction", "write one of them, or remove <dynamics>"


def _name_problems(robot: "Element") -> Iterator[Problem]:
    for tag in ("link", "joint", "loop_joint", "material"):
        first: dict[str, Element] = {}
        for element in robot.all(tag):
            name = element.get("name")
            if not name and tag != "material":
                yield element, "has no name", f'write <{tag} name="...">'
            elif name in first:
                yield element, f"the name is already that of the <{tag}> on line {first[name].line}", f"give each <{tag}> its own name"
            elif tag == "loop_joint" and name in _names(robot, "joint"):
                yield element, "the name is already that of a <joint>", "give each bearing, joint or loop, its own name"
            elif tag == "joint" and name == "universe":
                yield element, "the name 'universe' is Pinocchio's own, for the world", "give the joint another name"
            elif tag == "material" and not element.all("color", "texture"):
                yield element, "has neither a colour nor a texture", 'write <color rgba="0.5 0.5 0.5 1"/> in it'
            first.setdefault(name, element)


def _type_problems(element: "Element", word: str, types: Sequence[str], unsupported: Mapping[str, str]) -> Iterator[Problem]:
    kind, remedy = element.get("type"), f"write one of: {', '.join(types)}"
    if not kind:
        yield element, "has no type", remedy
    elif kind in unsupported:
        yield element, f"{word} type {kind!r} is not supported yet", unsupported[kind]
    elif kind not in types:
        yield element, f"unknown {word} type {kind!r}{suggestion(kind, types)}", remedy


def _joint_problems(joint: "Element") -> Iterator[Problem]:
    kind, limits = joint.get("type"), joint.all("limit")
    if kind in ("revolute", "prismatic") and not limits:
        remedy = 'write <limit lower="..." upper="..." effort="..." velocity="..."/>'
        yield joint, f"a {kind} joint needs a <limit>", f'{remedy} or type="continuous"' if kind == "revolute" else remedy
    for limit in limits:
        for name in ("effort", "velocity"):
            if any(value < 0 for value in limit.numbers(name)):
                yield limit, f"{name} is negative", "write how large it may be, in SI units"
        lower, upper = limit.numbers("lower") or (0.0,), limit.numbers("upper") or (0.0,)
        if kind in ("revolute", "prismatic") and lower > upper:
            yield limit, f"lower ({lower[0]!r}) is above upper ({upper[0]!r})", "exchange them (either is 0 where it is missing)"
    if kind != "fixed":
        yield from _axis_problems(joint)


def _axis_problems(joint: "Element") -> Iterator[Problem]:
    for element in joint.all("axis"):
        axis = element.numbers("xyz")
        length = math.hypot(*axis)
        if axis and length == 0:
            yield element, "the axis is zero", 'write its direction, for example xyz="0 -1 0"'
        elif axis and abs(length - 1) > 1e-6:
            unit = " ".join(repr(part / length + 0.0) for part in axis)  # + 0.0: no "-0.0"
            yield element, f"the axis has length {length:.9g}, not 1", f'write xyz="{unit}"'


def _tree_problems(robot: "Element") -> Iterator[Problem]:
    links = _names(robot, "link")
    if not links:
        yield robot, "has no <link>", "write the links and joints of the linkage"
        return
    carriers: dict[str, str] = {}
    unsound = False
    for joint in robot.all("joint"):
        ends = list(_end_problems(joint, "parent", "child", links))
        yield from ends
        _, child = _ends(joint)
        unsound = unsound or bool(ends) or not all(_ends(joint))
        if not ends and child in carriers:
            remedy = "a link has one parent; write the second joint as a <loop_joint>"
            yield joint, f"its child {child!r} is already the child of joint {carriers[child]!r}", remedy
        carriers.setdefault(child, joint.get("name"))
    if unsound:
        return  # what the joints connect is not known

    elements = {link.get("name"): link for link in robot.all("link")}
    roots, bodies = [link for link in links if link not in carriers], _bodies(robot)
    lost = [link for link in links if link not in bodies]
    if not roots:
        yield robot, "has no root link: every link is some joint's child", "let one link, the frame, be no joint's child"
    elif len(roots) > 1:
        yield elements[roots[1]], f"there are {len(roots)} root links: {', '.join(roots)}", "connect all but one with a <joint>"
    elif lost:
        remedy = "write one joint of the cycle as a <loop_joint>"
        yield elements[lost[0]], f"a cycle of joints, not connected to the root: {', '.join(lost)}", remedy


def _inertia_problems(robot: "Element") -> Iterator[Problem]:
    bodies = _bodies(robot)
    frame = next(iter(bodies), None)
    heavy = {bodies.get(link.get("name")) for link in robot.all("link") if link.all("inertial")}
    for link in robot.all("link"):
        name = link.get("name")
        moving = bodies.get(name, frame) != frame
        if moving and bodies[name] == name and name not in heavy:
            yield link, "it moves, but has no <inertial>, nor has any link welded to it", "write <inertial> with <mass> and <inertia>"
        for inertial in link.all("inertial"):
            for element in inertial.all("mass"):
                for mass in element.numbers("value"):
                    if moving and mass <= 0:
                        yield element, f"the mass {mass!r} of a moving link is not positive", "write it in kg, or remove <inertial>"
                    elif mass < 0:
                        yield element, f"the mass {mass!r} is negative", "write it in kg"
            for element in inertial.all("inertia"):
                if problem := _tensor_problem(element):
                    yield element, problem, "write the moments about the centre of mass [kg m2], products with the sign of -integral xy dm"


def _tensor_problem(inertia: "Element") -> str | None:
    """Why no distribution of mass has this inertia tensor; None if one has.

    Principal moments obey I1 + I2 >= I3 >= 0. The tolerance, 1e-6 of the largest, lets the rounded figures of a CAD printout pass.
    All zeros, a point mass, pass too.
    """
    moments = [value for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz") for value in inertia.numbers(name)]
    if len(moments) != 6:
        return None  # said elsewhere
    xx, xy, xz, yy, yz, zz = moments
    scale = max(map(abs, moments)) or 1.0  # so that nothing overflows
    principal = np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) / scale)
    tolerance = 1e-6 * abs(principal).max()
    shown = ", ".join(f"{float(moment) * scale:.6g}" for moment in principal)
    if principal[0] < -tolerance:
        return f"a principal moment of inertia is negative ({shown})"
    if principal[2] > principal[0] + principal[1] + tolerance:
        return f"the largest principal moment of inertia exceeds the sum of the other two ({shown})"
    return None


def _mimic_problems(robot: "Element") -> Iterator[Problem]:
    types = {joint.get("name"): joint.get("type") for joint in robot.all("joint")}
    for joint in robot.all("joint"):
        for mimic in joint.all("mimic"):
            leader = mimic.get("joint")
            if joint.get("type") == "fixed":
                yield mimic, "the joint is fixed and cannot follow another", "remove <mimic>, or let the joint move"
            if leader and leader not in types:
                yield mimic, f"no joint {leader!r}{suggestion(leader, types)}", "name a <joint> of this file"
            elif leader and leader == joint.get("name"):
                yield mimic, "the joint mimics itself", "name the joint that it is geared to"
            elif leader and types[leader] == "fixed":
                yield mimic, f"joint {leader!r} is fixed: nothing to follow", "name a joint that moves"
            if mimic.numbers("multiplier") == (0.0,):
                yield mimic, "multiplier is 0, which locks the joint", 'write the ratio of the gear pair, or type="fixed"'


def _transmission_problems(robot: "Element") -> Iterator[Problem]:
    types = {joint.get("name"): joint.get("type") for joint in robot.all("joint")}
    for transmission in robot.all("transmission"):
        if not transmission.all("joint"):
            yield transmission, "names no <joint>", 'write <joint name="..."/> in it, the driver'
        for joint in transmission.all("joint"):
            name = joint.get("name")
            if not name:
                yield joint, "has no name", 'write <joint name="..."/>, the driver'
            elif name not in types:
                yield joint, f"no joint {name!r}{suggestion(name, types)}", "name a <joint> of this file"
            elif types[name] == "fixed":
                yield joint, f"joint {name!r} is fixed and cannot drive", "name a revolute, continuous or prismatic joint"


def _end_problems(element: "Element", tag1: str, tag2: str, links: Sequence[str]) -> Iterator[Problem]:
    """Of the two links that a joint or loop connects."""
    for end in element.all(tag1, tag2):
        name = end.get("link")
        if name and name not in links:
            yield end, f"no link {name!r}{suggestion(name, links)}", "name a <link> of this file"
    name1, name2 = _ends(element, tag1, tag2)
    if name1 and name1 == name2:
        yield element, f"{tag1} and {tag2} are the same link {name1!r}", "write the two links that it connects"


def _bodies(robot: "Element") -> dict[str, str]:
    """For each link that joints connect to the root, root first, the first link of its body: of those welded together by fixed joints."""
    joints: dict[str, list[tuple[str, bool]]] = {}
    for joint in robot.all("joint"):
        parent, child = _ends(joint)
        joints.setdefault(parent, []).append((child, joint.get("type") == "fixed"))
    children = {child for carried in joints.values() for child, _ in carried}
    reached = [link for link in _names(robot, "link") if link not in children][:1]
    bodies = {root: root for root in reached}
    for parent in reached:  # grows as it goes
        for child, fixed in joints.get(parent, ()):
            if child not in bodies:
                bodies[child] = bodies[parent] if fixed else child
                reached.append(child)
    return bodies


def _names(robot: "Element", tag: str) -> list[str]:
    return [name for element in robot.all(tag) if (name := element.get("name"))]


def _ends(element: "Element", tag1: str = "parent", tag2: str = "child") -> tuple[str, str]:
    """Names of the links that a joint or loop connects, empty where missing."""
    end1, end2 = element.all(tag1), element.all(tag2)
    return end1[0].get("link") if end1 else "", end2[0].get("link") if end2 else ""
