"""What can be wrong with the links of a URDF as bodies: how joints and loops connect them, and their inertia. See `element_checks`."""

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from ...common.errors import suggestion
from .document import Element
from .element_checks import Problem, names


def problems(robot: Element) -> Iterator[Problem]:
    """All problems of the bodies of a URDF."""
    yield from _tree_problems(robot)
    yield from _inertia_problems(robot)
    yield from _loop_problems(robot)


def _tree_problems(robot: Element) -> Iterator[Problem]:
    links = names(robot, "link")
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
    roots, bodies = [link for link in links if link not in carriers], bodies_of(robot)
    lost = [link for link in links if link not in bodies]
    if not roots:
        yield robot, "has no root link: every link is some joint's child", "let one link, the frame, be no joint's child"
    elif len(roots) > 1:
        yield elements[roots[1]], f"there are {len(roots)} root links: {', '.join(roots)}", "connect all but one with a <joint>"
    elif lost:
        remedy = "write one joint of the cycle as a <loop_joint>"
        yield elements[lost[0]], f"a cycle of joints, not connected to the root: {', '.join(lost)}", remedy


def _inertia_problems(robot: Element) -> Iterator[Problem]:
    bodies = bodies_of(robot)
    frame = next(iter(bodies), None)
    heavy = {bodies.get(link.get("name")) for link in robot.all("link") if link.all("inertial")}
    connected = _connected(robot, bodies)
    for link in robot.all("link"):
        name = link.get("name")
        moving = bodies.get(name, frame) != frame
        if moving and bodies[name] == name and name not in heavy:
            yield link, "it moves, but has no <inertial>, nor has any link welded to it", "write <inertial> with <mass> and <inertia>"
        for inertial in link.all("inertial"):
            for element in inertial.all("mass"):
                for mass in element.numbers("value"):
                    if moving and (mass < 0 or (mass == 0 and not _idealised(inertial, bodies[name], connected))):
                        remedy = (
                            "write it in kg, or remove <inertial>; a link between two bearings may have none, without moments of inertia"
                        )
                        yield element, f"the mass {mass!r} of a moving link is not positive", remedy
                    elif mass < 0:
                        yield element, f"the mass {mass!r} is negative", "write it in kg"
            for element in inertial.all("inertia"):
                if problem := _tensor_problem(element):
                    yield element, problem, "write the moments about the centre of mass [kg m2], products with the sign of -integral xy dm"


def _connected(robot: Element, bodies: dict[str, str]) -> Counter[str]:
    """How many bearings, of joints and loops, every body has."""
    found: Counter[str] = Counter()
    for element in robot.all("joint", "loop_joint"):
        if element.get("type") != "fixed" or element.tag == "loop_joint":
            ends = _ends(element, "link1", "link2") if element.tag == "loop_joint" else _ends(element)
            found.update(bodies[link] for link in ends if link in bodies)
    return found


def _idealised(inertial: Element, body: str, connected: Counter[str]) -> bool:
    """Whether an inertia of no mass is that of a link meant to have none: of a cross piece or rod between two bearings."""
    return connected[body] > 1 and not any(principal_moments(tensor) != (0.0, 0.0, 0.0) for tensor in inertial.all("inertia"))


def _loop_problems(robot: Element) -> Iterator[Problem]:
    links, bodies = names(robot, "link"), bodies_of(robot)
    for loop in robot.all("loop_joint"):
        yield from _end_problems(loop, "link1", "link2", links)
        name1, name2 = _ends(loop, "link1", "link2")
        if name1 != name2 and name1 in bodies and bodies[name1] == bodies.get(name2):
            yield loop, f"{name1!r} and {name2!r} are welded together by fixed joints", "write links of the two bodies that it connects"


def principal_moments(inertia: Element) -> tuple[float, ...]:
    """The three principal moments [kg m2], smallest first; none where the six components are not numbers."""
    moments = [value for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz") for value in inertia.numbers(name)]
    if len(moments) != 6:
        return ()
    xx, xy, xz, yy, yz, zz = moments
    scale = max(map(abs, moments)) or 1.0  # so that nothing overflows
    return tuple(float(moment) * scale for moment in np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) / scale))


def _tensor_problem(inertia: Element) -> str | None:
    """Why no distribution of mass has this inertia tensor; None if one has.

    Principal moments obey I1 + I2 >= I3 >= 0. The tolerance, 1e-6 of the largest, lets the rounded figures of a CAD printout pass.
    All zeros, a point mass, pass too.
    """
    principal = principal_moments(inertia)
    if not principal:
        return None  # said elsewhere
    tolerance = 1e-6 * max(map(abs, principal))
    shown = ", ".join(f"{moment:.6g}" for moment in principal)
    if principal[0] < -tolerance:
        return f"a principal moment of inertia is negative ({shown})"
    if principal[2] > principal[0] + principal[1] + tolerance:
        return f"the largest principal moment of inertia exceeds the sum of the other two ({shown})"
    return None


def _end_problems(element: Element, tag1: str, tag2: str, links: Sequence[str]) -> Iterator[Problem]:
    """Of the two links that a joint or loop connects."""
    for end in element.all(tag1, tag2):
        name = end.get("link")
        if name and name not in links:
            yield end, f"no link {name!r}{suggestion(name, links)}", "name a <link> of this file"
    name1, name2 = _ends(element, tag1, tag2)
    if name1 and name1 == name2:
        yield element, f"{tag1} and {tag2} are the same link {name1!r}", "write the two links that it connects"


def bodies_of(robot: Element) -> dict[str, str]:
    """For each link that joints connect to the root, root first, the first link of its body: of those welded together by fixed joints."""
    joints: dict[str, list[tuple[str, bool]]] = {}
    for joint in robot.all("joint"):
        parent, child = _ends(joint)
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


def _ends(element: Element, tag1: str = "parent", tag2: str = "child") -> tuple[str, str]:
    """Names of the links that a joint or loop connects, empty where missing."""
    end1, end2 = element.all(tag1), element.all(tag2)
    return end1[0].get("link") if end1 else "", end2[0].get("link") if end2 else ""
