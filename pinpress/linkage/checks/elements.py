"""Checks of the elements of a URDF, before its links are put together: `errors`, and `remarks` about what is allowed, but probably a
mistake or without effect.

Every check yields the elements at fault and goes on, so that all problems of a file can be listed together. Therefore no check may rely on
another one having passed.
"""

import itertools
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from decimal import Decimal

import numpy as np

from ...common.arguments import LARGEST
from ...common.errors import UrdfError, odd_character, suggestion
from ..description import DEEPEST_JOINTS, MACHINE_ELEMENTS, MOST, Description, Joint, has_mass, names
from ..document import Document, Finding
from ..element import Element
from . import cams, grammar, machine_elements
from .grammar import Problem, warning

CONTACTS = (*MACHINE_ELEMENTS, "cam")  # tags of elements through which bodies push on each other


def errors(document: Document) -> list[Finding]:
    """Errors in the elements of a URDF, before its links are put together: all of them, or the first hundred.

    Pinocchio drops much of what it cannot read and carries on: a misspelt ``<axis>`` becomes the x axis, a mass "2,5" no inertia at all.
    Therefore everything that enters the mechanics is checked, so that Pinocchio then reads all of a file that passes.
    """
    robot, description = document.robot, document.description
    problems = list(_size_problems(robot, description))
    if not problems:  # checking everything in a file that is too large would take long
        checks = (
            _robot_problems(robot),
            grammar.problems(robot),
            _name_problems(robot),
            _type_problems(robot),
            _ignored_problems(robot),
            _mimic_problems(robot, description),
            _spring_problems(robot, description),
            _relation_problems(robot, description),
            machine_elements.problems(robot, description),
            cams.problems(robot, description),
            _transmission_problems(robot, description),
            _home_problems(robot, description),
            _tree_problems(robot, description),
            _inertia_problems(robot, description),
            _loop_problems(robot, description),
        )
        # Each error may compare a name with all others, which takes time.
        problems = list(itertools.islice(itertools.chain(*checks), 100))
    return [Finding.of(UrdfError(document.file, str(element), element.line, *said)) for element, *said in problems]


def _robot_problems(robot: Element) -> Iterator[Problem]:
    if not robot.get("name"):
        yield robot, "has no name", 'write <robot name="press">'
    elif odd := odd_character(robot.get("name"), with_control=False):
        yield robot, _odd_name(robot, odd), "give it another name"
    if robot.attributes.get("version", "1.0") not in ("1.0", "1.1"):
        yield robot, f"unknown URDF version {robot.get('version')!r}", 'write version="1.0", or no version'


def _name_problems(robot: Element) -> Iterator[Problem]:
    joints = set(names(robot, "joint"))
    bearings = joints | set(names(robot, "loop_joint"))
    for tags in ("link",), ("joint",), ("loop_joint",), ("relation",), CONTACTS, ("material",):
        first: dict[str, Element] = {}
        for element in robot.all(*tags):
            tag = element.tag
            name = element.get("name")
            if not name and tag != "material":
                yield element, "has no name", f'write <{tag} name="...">'
            elif name in first:
                yield element, f"the name is already that of the <{first[name].tag}> on line {first[name].line}", "give each its own name"
            elif (tag == "loop_joint" and name in joints) or (tag in CONTACTS and name in bearings):
                other = "joint" if name in joints else "loop_joint"
                yield element, f"the name is already that of a <{other}>", "give all that transmit forces names of their own"
            elif tag == "joint" and name == "universe":
                yield element, "the name 'universe' is Pinocchio's own, for the world", "give the joint another name"
            elif odd := odd_character(name, with_control=False):
                yield element, _odd_name(element, odd), "give it another name"
            elif tag == "material" and not element.all("color", "texture"):
                yield element, "has neither a colour nor a texture", 'write <color rgba="0.5 0.5 0.5 1"/> in it'
            first.setdefault(name, element)


def _odd_name(element: Element, odd: str) -> str:
    return f"its name {element.get('name')!a} has the character {odd}, which no line shows as it is"


def _type_problems(robot: Element) -> Iterator[Problem]:
    """Problems of joints and loops by themselves: types, limits and axes."""
    for joint in robot.all("joint"):
        yield from _unknown_type(joint, "joint", ("revolute", "continuous", "prismatic", "fixed"))
        if joint.attributes.get("independent", "true").lower() not in ("true", "false"):
            yield joint, f"independent={joint.get('independent')!r} is not true or false", 'write independent="true" for a driver'
        kind, limits = joint.get("type"), joint.all("limit")
        if kind in ("revolute", "prismatic") and not limits:
            remedy = 'write <limit lower="..." upper="..." effort="..." velocity="..."/>'
            yield joint, f"a {kind} joint needs a <limit>", f'{remedy} or type="continuous"' if kind == "revolute" else remedy
        for limit in limits:
            for name in ("effort", "velocity"):
                if limit.number(name, 0.0) < 0:
                    yield limit, f"{name} is negative", "write how large it may be, in SI units"
            lower, upper = limit.number("lower", 0.0), limit.number("upper", 0.0)
            if kind in ("revolute", "prismatic") and lower > upper:
                yield limit, f"lower ({lower!r}) is above upper ({upper!r})", "exchange them (either is 0 where it is missing)"
        if kind != "fixed":
            yield from _axis_problems(joint)
    for loop in robot.all("loop_joint"):
        yield from _unknown_type(loop, "loop", ("spherical", "revolute", "fixed"))
        if loop.get("type") == "revolute":
            yield from _axis_problems(loop)
        elif loop.all("axis"):
            yield loop.all("axis")[0], f"a {loop.get('type')} loop has no axis", 'remove <axis>, or write type="revolute"'


def _ignored_problems(robot: Element) -> Iterator[Problem]:
    """Problems of places that some programs write, always as zeros, and that no program reads."""
    ignored = [(link, origin, "its joint") for link in robot.all("link") for origin in link.all("origin")]
    ignored += [(joint, axis, "the joint") for joint in robot.all("joint", "loop_joint") for axis in joint.all("axis")]
    for around, element, placed in ignored:
        names = ("rpy",) if element.tag == "axis" else ("xyz", "rpy")
        for name in names:
            if element.tag == "origin" and name in element.attributes and (fault := element.fault(name)):
                yield element, f"{name}={element.get(name)!r}: {fault}", "write zeros, or remove it"
            elif any(element.numbers(name)):
                problem = f"{name}={element.get(name)!r} of an <{element.tag}> in a <{around.tag}> is read by no program"
                yield element, problem, f"write it in the <origin> of {placed}, and zeros here"


def _unknown_type(element: Element, word: str, types: Sequence[str]) -> Iterator[Problem]:
    kind, remedy = element.get("type"), f"write one of: {', '.join(types)}"
    unsupported = {
        "planar": "write two prismatic joints and a revolute one, with links between them",
        "floating": "hang the link on one that carries it, by the joint there (a ball is three hinges), and close the others by"
        " <loop_joint>",
    }
    if not kind:
        yield element, "has no type", remedy
    elif word == "joint" and kind in unsupported:
        yield element, f"{word} type {kind!r} is not supported", unsupported[kind]
    elif kind not in types:
        yield element, f"unknown {word} type {kind!r}{suggestion(kind, types)}", remedy


def _axis_problems(joint: Element) -> Iterator[Problem]:
    for element in joint.all("axis"):
        axis = element.numbers("xyz")
        length = math.hypot(*axis)
        if axis and length == 0:
            yield element, "the axis is zero", 'write its direction, for example xyz="0 -1 0"'
        elif axis and abs(length - 1) > max(1e-6, _rounding_of_length(element.get("xyz").split())):
            unit = " ".join(repr(part / length + 0.0) for part in axis)  # + 0.0: no "-0.0"
            yield element, f"the axis has length {length:.9g}, not 1", f'write xyz="{unit}"'


def _rounding_of_length(parts: Sequence[str]) -> float:
    """How far the length of a unit vector is from 1, if its parts are rounded to three or more decimals, as exporters write them."""
    large = [part for part in parts if abs(float(part)) >= 0.1]  # small ones have more decimals where digits are counted, as by %g
    decimals = max((-int(Decimal(part).as_tuple().exponent) for part in large), default=0)
    return math.sqrt(3) / 2 * 10.0**-decimals if decimals >= 3 else 0.0


def _mimic_problems(robot: Element, description: Description) -> Iterator[Problem]:
    types = description.types
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
            ratio = abs(mimic.number("multiplier", 1.0))
            if ratio < 1e-7:  # [-, m/rad of a rack]: one this small would count as rounding, in the rank of the equations
                size = "0" if ratio == 0 else f"{ratio:g}, as good as 0"
                yield mimic, f"multiplier is {size}, which locks the joint", 'write the ratio of the gear pair, or type="fixed"'
            elif 1e7 < ratio <= LARGEST:
                yield mimic, f"multiplier is {ratio:g}, which locks joint {leader!r}", "write the ratio of the gear pair"
    yield from _gear_ring_problems(robot, description)


def _spring_problems(robot: Element, description: Description) -> Iterator[Problem]:
    """Problems of springs and rotors in joints."""
    armed: set[str] = set()
    for element in robot.all("joint_spring", "armature"):
        name = element.get("joint")
        yield from _named_joint(element, description, "is fixed and does not move", "joint")
        for quantity in ("stiffness", "damping", "inertia"):
            if element.number(quantity, 0.0) < 0:
                yield element, f"{quantity} is negative", "write it as a positive number, in SI units"
        if element.tag == "armature" and name in armed:
            yield element, f"a second <armature> of joint {name!r}", "write their sum in one"
        armed |= {name} if element.tag == "armature" else set()


def _gear_ring_problems(robot: Element, description: Description) -> Iterator[Problem]:
    """Problems of joints that mimic each other in a ring: the turn of a joint must come back to it unchanged."""
    mimics = {joint.name: joint.mimic for joint in description.joints if joint.mimic is not None}
    seen: set[str] = set()
    for name in mimics:
        path: list[str] = []
        while name in mimics and name not in seen and name not in path:
            path.append(name)
            name = mimics[name].leader
        seen.update(path)
        ring = path[path.index(name) :] if name in path else []
        if len(ring) < 2:
            continue  # a joint that mimics itself is reported by `_mimic_problems`
        multiplier, offset = 1.0, 0.0
        for follower in reversed(ring):  # at the end, the first one = multiplier x itself + offset
            mimic = mimics[follower]
            multiplier, offset = mimic.multiplier * multiplier, mimic.multiplier * offset + mimic.offset
        if abs(multiplier - 1) > 1e-9 or abs(offset) > 1e-9:
            problem = f"a ring of gear pairs that locks: {' mimics '.join([*ring, ring[0]])}; one turn comes back as {multiplier:.9g}"
            first = next(joint for joint in robot.all("joint") if joint.get("name") == ring[0] and joint.all("mimic"))
            yield first.all("mimic")[0], f"{problem} turns, {offset:.9g} further", "remove one <mimic> of the ring"


def _relation_problems(robot: Element, description: Description) -> Iterator[Problem]:
    """Problems of relations. None determines a joint that another one, or a gear pair, determines: results are listed by these joints."""
    determined = {joint.name: f"the <mimic> of joint {joint.name!r}" for joint in description.joints if joint.mimic}
    for element, relation in zip(robot.all("relation"), description.relations, strict=True):
        if not relation.joints:
            yield element, "names no <joint>", 'write <joint name="..." coefficient="..."/> in it'
            continue
        for joint, coefficient in zip(element.all("joint"), relation.coefficients, strict=True):
            yield from _named_joint(joint, description, "is fixed and has no coordinate")
            if not 1e-7 < abs(coefficient / (relation.coefficients[0] or 1.0)) < 1e7:  # as of `_mimic_problems`
                problem = f"coefficient is {coefficient:g}, and that of the first joint {relation.coefficients[0]:g}"
                yield joint, problem, "write coefficients whose ratio is between 1e-7 and 1e7, or leave out the joint"
        if len(set(relation.joints)) < len(relation.joints):
            yield element, "names a joint twice", "add the coefficients, and name it once"
        if relation.joints[0] in determined:
            problem = f"it determines joint {relation.joints[0]!r}, as does {determined[relation.joints[0]]}"
            yield element, problem, "write another joint first, or remove one of the two"
        determined[relation.joints[0]] = f"relation {relation.name!r}"


def _named_joint(element: Element, description: Description, fixed: str, attribute: str = "name") -> Iterator[Problem]:
    """Problems of an element with an attribute that names a moving joint; ``fixed``: what is said of a joint that is fixed."""
    name, types = element.get(attribute), description.types
    if name and name not in types:
        yield element, f"no joint {name!r}{suggestion(name, types)}", "name a <joint> of this file"
    elif name and types[name] == "fixed":
        yield element, f"joint {name!r} {fixed}", "name a revolute, continuous or prismatic joint"


def _transmission_problems(robot: Element, description: Description) -> Iterator[Problem]:
    for part in robot.all("ros2_control"):
        for joint in part.all("joint"):
            yield from _named_joint(joint, description, "is fixed and cannot drive") if joint.all("command_interface") else ()
    for transmission in robot.all("transmission"):
        if not transmission.all("joint"):
            yield transmission, "names no <joint>", 'write <joint name="..."/> in it, the driver'
        for joint in transmission.all("joint"):
            if not joint.get("name"):
                yield joint, "has no name", 'write <joint name="..."/>, the driver'
            yield from _named_joint(joint, description, "is fixed and cannot drive")


def _home_problems(robot: Element, description: Description) -> Iterator[Problem]:
    moving = [name for name, kind in description.types.items() if kind != "fixed"]
    for joint in (joint for home in robot.all("home") for joint in home.all("joint")):
        if (name := joint.get("name")) and name not in moving:
            yield joint, f"no moving joint {name!r}{suggestion(name, moving)}", "name a moving <joint> of this file"


def _size_problems(robot: Element, description: Description) -> Iterator[Problem]:
    """Problems of a URDF that has too many elements, or joints too far from its root."""
    remedy = "write the linkage of the press alone"
    for tag, most in MOST.items():
        elements = robot.all(tag)
        if len(elements) > most:
            yield elements[most], f"there are {len(elements)} <{tag}>, more than {most}", remedy
    depths = {description.root: 0}
    for link, joint in description.carriers.items():
        depths[link] = depths[joint.parent] + 1
        if depths[link] > DEEPEST_JOINTS:
            element = robot.all("joint")[description.joints.index(joint)]
            yield element, f"it is more than {DEEPEST_JOINTS} joints away from the root link", "weld links together, and " + remedy
            return


def _tree_problems(robot: Element, description: Description) -> Iterator[Problem]:
    links, bodies = names(robot, "link"), description.bodies
    if not links:
        yield robot, "has no <link>", "write the links and joints of the linkage"
        return
    carriers: dict[str, Joint] = {}
    unsound = False
    for element, joint in zip(robot.all("joint"), description.joints, strict=True):
        problems = list(_end_problems(element, "parent", "child", joint.parent, joint.child, links))
        yield from problems
        unsound = unsound or bool(problems) or not (joint.parent and joint.child)
        if not problems and joint.child in carriers:
            remedy = "a link has one parent; write the second joint as a <loop_joint>"
            yield element, f"its child {joint.child!r} is already the child of joint {carriers[joint.child].name!r}", remedy
        carriers.setdefault(joint.child, joint)
    if unsound:
        return  # it is not clear what the joints connect

    elements = {link.get("name"): link for link in robot.all("link")}
    roots = [link for link in links if link not in carriers]
    lost = [link for link in links if link not in bodies]
    if not roots:
        yield robot, "has no root link: every link is some joint's child", "let one link, the frame, be no joint's child"
    elif len(roots) > 1:
        yield elements[roots[1]], f"there are {len(roots)} root links: {', '.join(roots)}", "connect all but one with a <joint>"
    elif lost:
        remedy = "write one joint of the cycle as a <loop_joint>"
        yield elements[lost[0]], f"a cycle of joints, not connected to the root: {', '.join(lost)}", remedy


def _inertia_problems(robot: Element, description: Description) -> Iterator[Problem]:
    bodies = description.bodies
    connected = Counter(bodies.get(link) for joint in description.joints if joint.type != "fixed" for link in (joint.parent, joint.child))
    connected.update(bodies.get(end.link) for loop in description.loops for end in (loop.link1, loop.link2))
    weighed = {bodies.get(link.get("name")) for link in robot.all("link") if has_mass(link)}
    for link in _without_inertial(robot, description):
        if connected[link.get("name")] < 2:  # nothing would resist its motion, nor move it
            remedy = "write <inertial> with <mass> and <inertia>; a link between two bearings may have none"
            yield link, "it moves on one bearing alone, but has no <inertial>, nor has any link welded to it", remedy
    for link in robot.all("link"):
        name = link.get("name")
        moving = description.moves(name)
        for inertial in link.all("inertial"):
            for element in inertial.all("mass"):
                for mass in element.numbers("value"):
                    # A cross piece or rod between two bearings may be modelled without mass and moments of inertia.
                    between = moving and (connected[bodies[name]] > 1 or bodies[name] in weighed)
                    nothing = all(principal_moments(tensor) == (0.0, 0.0, 0.0) for tensor in inertial.all("inertia"))
                    # The rotor of a motor may have moments of inertia alone: its mass is counted with the link that carries it.
                    idealised = between if nothing else connected[bodies.get(name)] == 1
                    if moving and (mass < 0 or (mass == 0 and not idealised)):
                        remedy = (
                            "write it in kg, or remove <inertial>; a link between two bearings may have none, without moments of inertia"
                        )
                        yield element, f"the mass {mass!r} of a moving link is not positive", remedy
                    elif mass < 0:
                        yield element, f"the mass {mass!r} is negative", "write it in kg"
            for element in inertial.all("inertia"):
                if problem := _tensor_problem(element):
                    yield element, problem, "write the moments about the centre of mass [kg m2], products with the sign of -integral xy dm"


def _without_inertial(robot: Element, description: Description) -> list[Element]:
    """The first links of moving bodies that have no ``<inertial>`` at all."""
    bodies = description.bodies
    heavy = {bodies.get(link.get("name")) for link in robot.all("link") if link.all("inertial")}
    bare = (link for link in robot.all("link") if description.moves(link.get("name")) and link.get("name") not in heavy)
    return [link for link in bare if bodies.get(link.get("name")) == link.get("name")]


def _loop_problems(robot: Element, description: Description) -> Iterator[Problem]:
    links, bodies = names(robot, "link"), description.bodies
    for element, loop in zip(robot.all("loop_joint"), description.loops, strict=True):
        name1, name2 = loop.link1.link, loop.link2.link
        yield from _end_problems(element, "link1", "link2", name1, name2, links)
        if name1 != name2 and name1 in bodies and bodies[name1] == bodies.get(name2):
            yield element, f"{name1!r} and {name2!r} are welded together by fixed joints", "write links of the two bodies that it connects"


def _end_problems(element: Element, tag1: str, tag2: str, name1: str, name2: str, links: Sequence[str]) -> Iterator[Problem]:
    """Problems of the two links that a joint or loop connects."""
    for end in element.all(tag1, tag2):
        name = end.get("link")
        if name and name not in links:
            yield end, f"no link {name!r}{suggestion(name, links)}", "name a <link> of this file"
    if name1 and name1 == name2:
        yield element, f"{tag1} and {tag2} are the same link {name1!r}", "write the two links that it connects"


def principal_moments(inertia: Element) -> tuple[float, ...]:
    """The three principal moments [kg m2], smallest first; none if the six components are not numbers."""
    moments = [value for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz") for value in inertia.numbers(name)]
    if len(moments) != 6:
        return ()
    xx, xy, xz, yy, yz, zz = moments
    scale = max(map(abs, moments)) or 1.0  # so that nothing overflows
    return tuple(float(moment) * scale for moment in np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) / scale))


def _tensor_problem(inertia: Element) -> str | None:
    """Why no distribution of mass has this inertia tensor; None if one has.

    Principal moments obey I1 + I2 >= I3 >= 0. The tolerance, 1e-6 of the largest, lets the rounded figures of a CAD printout pass.
    All zeros, a point mass, pass too, and two zeros: a link of which only the moment about the axis of its motion is written.
    """
    principal = principal_moments(inertia)
    if not principal or _is_of_one_axis(principal):
        return None  # of less than six numbers, which the grammar reports
    tolerance = 1e-6 * max(map(abs, principal))
    shown = ", ".join(f"{moment:.6g}" for moment in principal)
    if principal[0] < -tolerance:
        return f"a principal moment of inertia is negative ({shown})"
    if principal[2] > principal[0] + principal[1] + tolerance:
        return f"the largest principal moment of inertia exceeds the sum of the other two ({shown})"
    return None


def _is_of_one_axis(principal: Sequence[float]) -> bool:
    """Whether two moments are 0, as they are where only that about the axis of motion is written."""
    return principal[2] > 0.0 and not any(principal[:2])


def warnings(document: Document) -> Iterator[Finding]:
    """The warnings with which `load` reads a URDF, each once for all elements that it is about."""
    robot, description = document.robot, document.description
    yield from once(grammar.find_unknown(robot))
    if bare := _without_inertial(robot, description):
        names = ", ".join(link.get("name") for link in bare[:12]) + (" and others" if len(bare) > 12 else "")
        problem = f"{'it moves' if len(bare) == 1 else f'{len(bare)} links move'} without an <inertial>, as if of no mass: {names}"
        yield warning(bare[0], problem, "write <inertial> with <mass> and <inertia>; zeros say that it is meant")
    one_axis = "moments of inertia about two axes are 0, which no body has"
    moments = (inertia for link in robot.all("link") for inertial in link.all("inertial") for inertia in inertial.all("inertia"))
    flat = (inertia for inertia in moments if (principal := principal_moments(inertia)) and _is_of_one_axis(principal))
    yield from once(warning(inertia, one_axis, "write all three, unless the link turns about this one axis alone") for inertia in flat)


def once(findings: Iterable[Finding]) -> Iterator[Finding]:
    """One finding in place of all that say the same: the first, with how many there are."""
    same: dict[tuple[str, str], list[Finding]] = {}
    for finding in findings:
        same.setdefault((finding.problem, finding.remedy), []).append(finding)
    for first, *others in same.values():
        yield replace(first, problem=f"{first.problem} ({len(others)} more of this kind)") if others else first


def remarks(document: Document) -> Iterator[Finding]:
    """Warnings and notes of a URDF; it may have errors too."""
    robot, description = document.robot, document.description
    yield from warnings(document)
    origins = [origin for link in robot.all("link") for origin in link.all("origin")]
    yield from once(Finding("note", str(each), each.line, "an <origin> of a <link> is not read", "remove it") for each in origins)
    yield from _names(robot, "link")
    yield from _names(robot, "joint", "loop_joint")
    yield from _massless(robot, description)
    damped = {spring.joint for spring in description.joint_springs if spring.damping}
    for joint in robot.all("joint"):
        unread = ("friction",) if joint.get("name") in damped else ("damping", "friction")
        for dynamics in joint.all("dynamics"):
            values = [f"{name}={dynamics.get(name)!r}" for name in unread if any(dynamics.numbers(name))]
            if values:
                problem = f"inverse dynamics does not read {' and '.join(values)}"
                remedy = f"give it friction={{{joint.get('name')!r}: Friction(...)}}"
                yield Finding("note", str(dynamics), dynamics.line, problem, remedy)


def _names(robot: Element, *tags: str) -> Iterator[Finding]:
    first: dict[str, Element] = {}
    for element in robot.all(*tags):
        name = element.get("name")
        if name != name.strip():
            yield warning(element, f"the name {name!r} has spaces around it", f'write name="{name.strip()}" here and where it is used')
        alike = first.setdefault(" ".join(name.split()).casefold(), element)
        if alike.get("name") != name:  # a name that is there twice is an error
            said = f"{alike.get('name')!r} on line {alike.line}"
            yield warning(element, f"the name {name!r} differs from {said} only in case or spaces", "give one of them another name")


def _massless(robot: Element, description: Description) -> Iterator[Finding]:
    """Bodies with a mass and no moment of inertia at all."""
    tensors: dict[str, list[Element]] = {}
    for link in robot.all("link"):
        for inertial in link.all("inertial"):
            if any(any(mass.numbers("value")) for mass in inertial.all("mass")):
                tensors.setdefault(description.bodies.get(link.get("name"), description.root), []).extend(inertial.all("inertia"))
    for body, inertias in tensors.items():
        moments = principal_moments(inertias[0]) if len(inertias) == 1 else ()
        if body != description.root and moments and not any(moments):
            yield warning(inertias[0], "all moments of inertia are 0: a point mass, which resists no turning", "write them in kg m2")
