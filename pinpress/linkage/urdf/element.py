"""An XML element of a URDF, with its line and the numbers in its attributes."""

from __future__ import annotations

import math
import re

from ...common.errors import shown

_TEXTS = ("link", "joint", "filename", "name")  # attributes that hold no numbers; all others that are asked for hold one, but
_COUNTS = {"xyz": 3, "rpy": 3, "size": 3, "scale": 3, "rgba": 4}
# Pinocchio's parser takes neither "1_0" nor "nan" nor digits of other scripts, all of which Python's float() does.
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


class Element:
    """An XML element as Pinocchio's parser sees it: namespace prefixes are part of names.

    Attributes:
        tag: its name.
        attributes: their texts by their names.
        line: line in which its start tag begins.
        parent: the element that contains it; None of the root.
        children: the elements that it contains.
        start: byte at which its start tag begins.
        end: byte at which its end tag begins.
        text: the characters directly in it, if `tree` was asked for them.
        origin: its name in messages, if it was written from an element of another format; else None.
    """

    def __init__(self, tag: str, attributes: dict[str, str], line: int, parent: Element | None, start: int) -> None:
        self.tag, self.attributes, self.line, self.parent, self.start = tag, attributes, line, parent, start
        self.children: list[Element] = []
        self.end = start
        self.text = ""
        self.origin: str | None = None

    def get(self, name: str) -> str:
        """The text of an attribute, empty where it is missing."""
        return self.attributes.get(name, "")

    def all(self, *tags: str) -> list[Element]:
        """The children with these tags."""
        return [child for child in self.children if child.tag in tags]

    def numbers(self, name: str) -> tuple[float, ...]:
        """The numbers of an attribute; none where it is missing or has a `fault`."""
        return () if name not in self.attributes or self.fault(name) else tuple(map(float, self.get(name).split()))

    def fault(self, name: str) -> str | None:
        """Why an attribute does not hold as many numbers as it should, as Pinocchio's parser reads them; None if it does."""
        if name in _TEXTS:
            return None
        count = _COUNTS.get(name, 1)
        words = [word for word in self.get(name).split(" ") if word] if count > 1 else [self.get(name)]
        for word in words:
            if not NUMBER.fullmatch(word) or not math.isfinite(float(word)):
                return f"{shown(word)} is not a finite number"
        return None if len(words) == count else f"{len(words)} numbers, not {count}"

    def __str__(self) -> str:
        """``<link name="crank">``, or ``<mass> of <link name="crank">``; if it was written from another format, its ``origin``."""
        if self.origin is not None:
            return self.origin
        shown = f'<{self.tag} name="{self.get("name")}">' if "name" in self.attributes else f"<{self.tag}>"
        above = self.parent
        while above is not None and above.parent is not None and above.parent.parent is not None:
            above = above.parent
        return shown if above is None or above.parent is None else f"{shown} of {above}"
