"""How large a URDF may be: far beyond any press, and small enough for a file that is none to be refused at once.

The largest URDF that comes with pinpress has 30 kB, 200 elements, 13 joints and 4 loops.
"""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from ...common.errors import shown

if TYPE_CHECKING:
    from .element_checks import Problem
    from .reader import Element

MOST_BYTES = 20_000_000
MOST_ELEMENTS = 100_000
MOST_ATTRIBUTES = 100  # of one element
MOST_CHARACTERS = 1000  # of a name or value
MOST_ERRORS = 100  # listed: each may compare its name with all others
DEEPEST_ELEMENTS = 200  # levels of elements; Pinocchio's parser stops at 500
MOST = {"link": 1000, "joint": 1000, "loop_joint": 500, "transmission": 500, "material": 1000}
DEEPEST_JOINTS = 500  # from the root on; Pinocchio's parser calls itself for each, and at 2 kB of stack a call ends the process after 2000


def too_large(count: int, tag: str, attributes: Mapping[str, str]) -> str | None:
    """What there is too much of in the ``count``th element of a file; None where it is not."""
    if count > MOST_ELEMENTS:
        return f"has more than {MOST_ELEMENTS} elements"
    if len(attributes) > MOST_ATTRIBUTES:
        return f"an element has {len(attributes)} attributes, more than {MOST_ATTRIBUTES}"
    longest = max((tag, *attributes, *attributes.values()), key=len)
    if len(longest) > MOST_CHARACTERS:
        return f"a name or value of {len(longest)} characters, more than {MOST_CHARACTERS}: {shown(longest[:40])}..."
    return None


def problems(robot: "Element") -> Iterator["Problem"]:
    """What there is too much of in a URDF."""
    remedy = "write the linkage of the press alone"
    for tag, most in MOST.items():
        found = robot.all(tag)
        if len(found) > most:
            yield found[most], f"there are {len(found)} <{tag}>, more than {most}", remedy
    for joint in _too_deep(robot.all("joint")):
        yield joint, f"it is more than {DEEPEST_JOINTS} joints away from the root link", "weld links together, and " + remedy
        return


def _too_deep(joints: "list[Element]") -> "Iterator[Element]":
    """Joints that too many others are above."""
    below: dict[str, list[tuple[str, Element]]] = {}
    for joint in joints:
        for parent in joint.all("parent")[:1]:
            below.setdefault(parent.get("link"), []).extend((end.get("link"), joint) for end in joint.all("child")[:1])
    children = {child for carried in below.values() for child, _ in carried}
    depth = {link: 0 for link in below if link not in children}
    reached = list(depth)
    for link in reached:  # grows as it goes
        for child, joint in below.get(link, []):
            if child not in depth:
                depth[child] = depth[link] + 1
                reached.append(child)
                if depth[child] > DEEPEST_JOINTS:
                    yield joint
