"""What the readers of all formats need: numbers, directions, poses and single children of elements, and errors and remarks about them."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from typing import NoReturn

import numpy as np
import pinocchio as pin

from ...common.arguments import LARGEST
from ...common.errors import UrdfError, shown, suggestion
from ...common.quantities import Array
from ..document import Finding, Origin
from ..element import NUMBER, Element

ALONE = "write the linkage of the press alone"


def refuse(file: str, element: Element | Origin, problem: str, remedy: str) -> NoReturn:
    """Raise the UrdfError of an element."""
    name, line = origin_of(element)
    raise UrdfError(file, name, line, problem, remedy)


def remark(severity: str, element: Element | Origin, problem: str, remedy: str) -> Finding:
    """A warning or note of an element."""
    name, line = origin_of(element)
    return Finding(severity, name, line, problem, remedy)


def origin_of(element: Element | Origin) -> Origin:
    """Line of an element, and its name in messages: its own, or with that of the next element around it which has one."""
    if isinstance(element, Origin):
        return element
    named: Element | None = element
    while named is not None and not named.get("name"):
        named = named.parent
    whole = named is None or (named.parent is None and named is not element)  # what is under <robot> is not said to be of it
    shown = "" if named is None or whole else f'<{named.tag} name="{named.get("name")}">'
    return Origin(shown if named is element else " of ".join(filter(None, (f"<{element.tag}>", shown))), element.line)


def numbers(file: str, element: Element, text: str, count: int) -> Array:
    """(count,) the numbers in a text of an element; raises UrdfError if they are more or fewer, not finite, or out of range."""
    words = text.split()
    for word in words:
        if not NUMBER.fullmatch(word) or not math.isfinite(float(word)):
            refuse(file, element, f"{shown(word)} is not a finite number", "write plain numbers, decimals after a point, spaces in between")
        if abs(float(word)) > LARGEST:
            refuse(file, element, f"{word} is out of range", f"write SI units; {LARGEST:g} is the largest number")
    if len(words) != count:
        refuse(file, element, f"{len(words)} numbers, not {count}", f"write {count} numbers, spaces in between")
    return np.array([float(word) for word in words])


def direction(file: str, element: Element, text: str) -> Array:
    """(3,) the direction in a text of an element, of length 1; raises UrdfError if it is zero."""
    axis = numbers(file, element, text, 3)
    length = float(np.linalg.norm(axis))
    if length == 0:
        refuse(file, element, "the axis is zero", "write its direction, for example 0 -1 0")
    return axis / length if abs(length - 1) > 1e-15 else axis


def find_child(file: str, element: Element, tag: str) -> Element | None:
    """The only child with this tag, or the first of equal ones; None if there is none; raises UrdfError if there are two that differ."""
    children = element.all(tag)
    for other in children[1:]:
        if not other.says_the_same_as(children[0]):
            refuse(file, other, f"a second <{tag}> in one <{element.tag}>, which says something else", "keep one of them")
    return children[0] if children else None


def need_child(file: str, element: Element, tag: str) -> Element:
    """The only child with this tag; raises UrdfError if there is none, or two."""
    child = find_child(file, element, tag)
    if child is None:
        refuse(file, element, f"has no <{tag}>", f"write <{tag}> in this <{element.tag}>")
    return child


def refuse_unknown(file: str, element: Element, known: Iterable[str]) -> None:
    """Raise UrdfError for a child whose tag is not among these, and has no namespace prefix."""
    words = list(known)
    for child in element.children:
        if child.tag not in words and ":" not in child.tag:
            problem = f"unknown element <{child.tag}>{suggestion(child.tag, words)}"
            refuse(file, child, problem, f"in <{element.tag}> write one of: {', '.join(words)}")


def refuse_unknown_attributes(file: str, element: Element, known: Iterable[str]) -> None:
    """Raise UrdfError for an attribute that is not among these, and has no namespace prefix."""
    words = list(known)
    for name in element.attributes:
        if name not in words and ":" not in name and name != "xmlns":
            problem = f"unknown attribute {name!r}{suggestion(name, words)}"
            refuse(file, element, problem, f"in <{element.tag}> write: {', '.join(words)}" if words else "remove it")


def make_unique(name: str, taken: Collection[str]) -> str:
    """This name, or with a number behind it if it is taken."""
    free, count = name, 1
    while free in taken:
        count += 1
        free = f"{name}_{count}"
    return free


def take(name: str, taken: set[str]) -> str:
    """This name, or with a number behind it, which is taken from now on."""
    name = make_unique(name, taken)
    taken.add(name)
    return name


def pose_of(file: str, element: Element) -> pin.SE3:
    """The pose in an element's ``<pose>``, identity if it has none."""
    pose = find_child(file, element, "pose")
    return pin.SE3.Identity() if pose is None else pose_and_rounding(file, pose)[0]


def pose_and_rounding(file: str, pose: Element) -> tuple[pin.SE3, bool]:
    """The pose in a ``<pose>``, and whether it has angles that were read as quarter turns."""
    count = 7 if pose.get("rotation_format") == "quat_xyzw" else 6
    if not pose.text.strip():
        return pin.SE3.Identity(), False
    values = numbers(file, pose, pose.text, count)
    if count == 7:
        if not np.linalg.norm(values[3:]):
            refuse(file, pose, "the quaternion is zero", "write 0 0 0 1 for no turn")
        return pin.SE3(pin.Quaternion(values[3:] / np.linalg.norm(values[3:])).matrix(), values[:3]), False
    if pose.get("degrees").lower() in ("1", "true"):
        return pin.SE3(pin.rpy.rpyToMatrix(np.radians(values[3:])), values[:3]), False
    angles = np.array([_quarter_turns(word) for word in pose.text.split()[3:]])
    return pin.SE3(pin.rpy.rpyToMatrix(angles), values[:3]), bool((angles != values[3:]).any())


def _quarter_turns(word: str) -> float:
    """An angle [rad]; one that equals a multiple of a quarter turn to half of its last digit is that multiple."""
    value, decimals = float(word), len(word.partition(".")[2])
    if "e" in word.lower() or decimals < 4:  # the shortest is 1.5708
        return value
    quarters = round(value / (math.pi / 2)) * (math.pi / 2)
    return quarters if quarters and abs(value - quarters) <= 0.501 * 10.0**-decimals else value
