"""A text as XML elements, each with its line and the numbers in its attributes."""

from __future__ import annotations

import math
import re
from typing import TypeVar
from xml.parsers import expat

from ..common.errors import UrdfError, shown

# The largest URDF that comes with pinpress has 30 kB and 200 elements. These limits are far beyond any press, and small enough for another
# kind of file to be refused at once.
MOST_BYTES = 20_000_000
MOST_ELEMENTS = 100_000
MOST_ATTRIBUTES = 100  # most attributes of one element
MOST_CHARACTERS = 1000  # most characters of a name or value
DEEPEST_ELEMENTS = 200  # most levels of elements; Pinocchio's parser stops at 500

START_TAG = re.compile(rb"<(?:[^\"'>]|\"[^\"]*\"|'[^']*')*>")
_REFERENCE = re.compile(r"&(?:#x([0-9a-fA-F]+)|#([0-9]+)|(\w+));")
_ENTITIES = {"lt": "<", "gt": ">", "amp": "&", "quot": '"', "apos": "'"}
_ATTRIBUTE = re.compile(r"([^\s=\"']+)\s*=\s*(?:\"([^\"]*)\"|'([^']*)')")

# Attributes that hold no numbers; those of `_COUNTS` hold several, all others one.
_OF_MESHES = ("gear1", "gear2", "pinion", "rack", "screw", "nut", "worm", "wheel", "carrier", "hand", "side", "double_helical")
_OF_CAMS = "cam", "follower", "kind", "law"
_TEXTS = ("link", "joint", "filename", "name", "type", "version", "independent", *_OF_MESHES, *_OF_CAMS)
_COUNTS = {"xyz": 3, "rpy": 3, "size": 3, "scale": 3, "rgba": 4, "center": 3, "center1": 3, "center2": 3}
# Pinocchio's parser takes neither "1_0" nor "nan" nor digits of other scripts, all of which Python's float() does.
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


_Default = TypeVar("_Default", float, None)


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
        """The text of an attribute, empty if it is missing."""
        return self.attributes.get(name, "")

    def all(self, *tags: str) -> list[Element]:
        """The children with these tags."""
        return [child for child in self.children if child.tag in tags]

    def numbers(self, name: str) -> tuple[float, ...]:
        """The numbers of an attribute; none if it is missing or has a `fault`."""
        return () if name not in self.attributes or self.fault(name) else tuple(map(float, self.get(name).split()))

    def number(self, name: str, default: _Default) -> float | _Default:
        """The number of an attribute; the default where it is missing or has a `fault`."""
        return next(iter(self.numbers(name)), default)

    def of_child(self, tag: str, name: str) -> str:
        """The text of an attribute of the first child with a tag, empty if either is missing."""
        return next((child.get(name) for child in self.all(tag)), "")

    def says_the_same_as(self, other: Element) -> bool:
        """Whether both have the same tag, attributes, text and children."""
        same = (self.tag, self.attributes, self.text.split()) == (other.tag, other.attributes, other.text.split())
        return same and len(self.children) == len(other.children) and all(map(Element.says_the_same_as, self.children, other.children))

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


def tree(file: str, document: bytes, with_text: bool = False) -> Element:
    """The root element of an XML document in UTF-8.

    Args:
        file: path of the file, for errors.
        document: the text.
        with_text: whether the elements keep the characters in them.

    Raises:
        UrdfError: the document is too large, or no XML.
    """
    # The encoding is given, because Pinocchio reads UTF-8 whatever the XML declaration says. Expat ignores namespaces here, as Pinocchio
    # does, and so accepts <drake:...> without its xmlns:drake.
    parser = expat.ParserCreate("utf-8")
    opened: list[Element] = []
    roots: list[Element] = []
    count = 0

    def forbid(problem: str, remedy: str, element: Element | None = None) -> None:
        raise UrdfError(file, None if element is None else str(element), parser.CurrentLineNumber, problem, remedy)

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        longest, superfluous = max((tag, *attributes, *attributes.values()), key=len), "remove what does not belong to the press"
        if count > MOST_ELEMENTS:
            forbid(f"has more than {MOST_ELEMENTS} elements", superfluous)
        if len(attributes) > MOST_ATTRIBUTES:
            forbid(f"an element has {len(attributes)} attributes, more than {MOST_ATTRIBUTES}", superfluous)
        if len(longest) > MOST_CHARACTERS:
            forbid(f"a name or value of {len(longest)} characters, more than {MOST_CHARACTERS}: {shown(longest[:40])}...", superfluous)
        attributes |= _with_line_breaks(document, parser.CurrentByteIndex)
        element = Element(tag, attributes, parser.CurrentLineNumber, opened[-1] if opened else None, parser.CurrentByteIndex)
        if tag.startswith("xacro:"):
            forbid("is xacro, not URDF", "expand the file first: xacro press.urdf.xacro > press.urdf", element)
        if tag.endswith(":include"):
            forbid("is XInclude, which Pinocchio does not read", "write what it includes in its place", element)
        if len(opened) > DEEPEST_ELEMENTS:
            forbid("is nested too deeply", "remove it", element)
        (opened[-1].children if opened else roots).append(element)
        opened.append(element)

    def end(_: str) -> None:
        opened.pop().end = parser.CurrentByteIndex

    def characters(text: str) -> None:
        opened[-1].text += text

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    if with_text:
        parser.CharacterDataHandler = characters
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


def _with_line_breaks(document: bytes, start: int) -> dict[str, str]:
    """Those attributes of the tag at byte ``start`` that contain tabs or line breaks, with these.

    XML reads them as spaces. Pinocchio's parser does not: it fails on a number with a line break in it, or drops it.
    """
    tag = START_TAG.match(document, start)
    if tag is None or not re.search(rb"[\t\r\n]", tag[0]):
        return {}

    def character(reference: re.Match[str]) -> str:  # that &#10; or &lt; stands for
        hexadecimal, decimal, name = reference.groups()
        return _ENTITIES[name] if name else chr(int(hexadecimal, 16) if hexadecimal else int(decimal))

    values = {name: double or single for name, double, single in _ATTRIBUTE.findall(tag[0].decode())}
    return {
        name: _REFERENCE.sub(character, re.sub(r"\r\n?|\n\r", "\n", value))
        for name, value in values.items()
        if re.search(r"[\t\r\n]", value)
    }
