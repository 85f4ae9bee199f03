"""What readers ask of the elements of a file: numbers in their text, the one child of a name; and how they refuse and remark on them."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable
from typing import NoReturn

import numpy as np

from ...common.errors import UrdfError, shown, suggestion
from ...common.quantities import Array
from ..urdf.document import Element, Origin
from ..urdf.findings import Finding

LARGEST = 1e12  # that is computed with
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def refuse(file: str, element: Element | Origin, problem: str, remedy: str) -> NoReturn:
    """Raise the UrdfError of an element."""
    name, line = origin_of(element)
    raise UrdfError(file, name, line, problem, remedy)


def remark(severity: str, element: Element | Origin, problem: str, remedy: str) -> Finding:
    """A warning or note of an element."""
    name, line = origin_of(element)
    return Finding(severity, name, line, problem, remedy)


def origin_of(element: Element | Origin) -> Origin:
    """Where an element of a file is, and what messages call it: by its own name, or by that of the next element around it which has one."""
    if isinstance(element, Origin):
        return element
    named: Element | None = element
    while named is not None and not named.get("name"):
        named = named.parent
    whole = named is None or (named.parent is None and named is not element)  # what is under <robot> is not said to be of it
    shown = "" if named is None or whole else f'<{named.tag} name="{named.get("name")}">'
    return Origin(shown if named is element else " of ".join(filter(None, (f"<{element.tag}>", shown))), element.line)


def numbers(file: str, element: Element, text: str, count: int) -> Array:
    """(count,) the numbers in a text of an element; refused where it has not as many, or they are not finite and of a sensible size."""
    words = text.split()
    for word in words:
        if not _NUMBER.fullmatch(word) or not math.isfinite(float(word)):
            refuse(file, element, f"{shown(word)} is not a finite number", "write plain numbers, decimals after a point, spaces in between")
        if abs(float(word)) > LARGEST:
            refuse(file, element, f"{word} is out of range", f"write SI units; {LARGEST:g} is the largest number")
    if len(words) != count:
        refuse(file, element, f"{len(words)} numbers, not {count}", f"write {count} numbers, spaces in between")
    return np.array([float(word) for word in words])


def optional(file: str, element: Element, tag: str) -> Element | None:
    """The one child with this tag, None where there is none; a second is refused."""
    found = element.all(tag)
    if len(found) > 1:
        refuse(file, found[1], f"a second <{tag}> in one <{element.tag}>", "keep one of them")
    return found[0] if found else None


def needed(file: str, element: Element, tag: str) -> Element:
    """The one child with this tag."""
    found = optional(file, element, tag)
    if found is None:
        refuse(file, element, f"has no <{tag}>", f"write <{tag}> in this <{element.tag}>")
    return found


def refuse_unknown(file: str, element: Element, known: Iterable[str]) -> None:
    """Refuse a child that is none of these, and has no namespace prefix."""
    words = list(known)
    for child in element.children:
        if child.tag not in words and ":" not in child.tag:
            problem = f"unknown element <{child.tag}>{suggestion(child.tag, words)}"
            refuse(file, child, problem, f"in <{element.tag}> write one of: {', '.join(words)}")


def unused(name: str, taken: Collection[str]) -> str:
    """A name like this that is not taken."""
    found, count = name, 1
    while found in taken:
        count += 1
        found = f"{name}_{count}"
    return found
