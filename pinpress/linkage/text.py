"""Edits of a URDF's text that leave the rest of it unchanged to the byte, and elements as text."""

from __future__ import annotations

import codecs
import html
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from xml.parsers import expat

from .document import Document
from .element import START_TAG, Element

MOMENTS = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
"""Attributes of ``<inertia>``, and their rows and columns in the tensor."""

_ATTRIBUTE = re.compile(rb"([^\s=\"'<>/]+)\s*=\s*(\"[^\"]*\"|'[^']*')")
_SPACE = re.compile(rb"\s*")


class Text:
    """A document and edits of it. The elements do not change; `edited` returns the changed text."""

    def __init__(self, document: Document) -> None:
        self.robot = document.robot
        self._mark = codecs.BOM_UTF8 if document.text.startswith(codecs.BOM_UTF8) else b""
        self._text = document.text[len(self._mark) :]
        self._edits: list[tuple[int, int, str]] = []

    @cached_property
    def _spans(self) -> dict[Element, tuple[int, int, int]]:
        """Where elements begin, where their first tags end, and where they end."""
        return dict(zip(_elements(self.robot), _spans(self._text), strict=True))

    def set(self, element: Element, attributes: Mapping[str, str]) -> None:
        """Give an element these attributes, which replace those of the same names."""
        start, opened, _ = self._spans[element]
        present = {match[1].decode(): match.span(2) for match in _ATTRIBUTE.finditer(self._text, start, opened)}
        for name, value in attributes.items():
            if name in present:
                first, last = present[name]
                self._edits.append((first + 1, last - 1, html.escape(value)))
            else:
                end = self._last_of_tag(opened)
                self._edits.append((end, end, _attributes({name: value})))

    def set_child(self, element: Element, child: str, attributes: Mapping[str, str]) -> None:
        """Give the one child with this tag these attributes; add it where there is none and attributes are given."""
        if element.all(child):
            self.set(element.all(child)[0], attributes)
        elif attributes:
            self.append(element, tag(child, attributes))

    def append(self, parent: Element, element: str) -> None:
        """Add an element behind the last child of its parent, on a line of its own if the first child has one."""
        _, opened, end = self._spans[parent]
        if opened == end:  # <link name="a"/>
            self._edits.append((self._last_of_tag(opened), end, f">{element}</{parent.tag}>"))
        else:
            space = _SPACE.match(self._text, opened)
            place = self._spans[parent.children[-1]][2] if parent.children else opened
            self._edits.append((place, place, (space[0].decode() if space and parent.children else "") + element))

    def remove(self, element: Element) -> None:
        """Remove an element with the white space before it."""
        start, _, end = self._spans[element]
        self._edits.append((len(self._text[:start].rstrip()), end, ""))

    def replace(self, element: Element, new: str) -> None:
        """Replace an element, with as many line breaks behind the new one as the old one had, so that line numbers stay."""
        start, _, end = self._spans[element]
        self._edits.append((start, end, new + "\n" * self._text.count(b"\n", start, end)))

    def insert(self, element: Element, new: str) -> None:
        """Add elements before this one, on its line."""
        start, _, _ = self._spans[element]
        self._edits.append((start, start, new))

    def edited(self) -> bytes:
        """The text with all edits."""
        pieces, done = [self._mark], 0
        for start, end, new in sorted(self._edits, key=lambda edit: edit[:2]):
            pieces += [self._text[done:start], new.encode(errors="replace")]
            done = end
        return b"".join([*pieces, self._text[done:]])

    def _last_of_tag(self, opened: int) -> int:
        """Byte at which the last attribute of a start tag ends; ``opened``: byte at which the tag ends."""
        return len(self._text[:opened].removesuffix(b">").removesuffix(b"/").rstrip())


def tag(name: str, attributes: Mapping[str, str], content: str = "") -> str:
    """An element as text."""
    return f"<{name}{_attributes(attributes)}" + (f">{content}</{name}>" if content else "/>")


def opening(name: str, attributes: Mapping[str, str]) -> str:
    """A start tag as text."""
    return f"<{name}{_attributes(attributes)}>"


def in_series(joints: Sequence[tuple[Mapping[str, str], str]], parent: str, child: str, between: Sequence[str], place: str) -> str:
    """The joints, by their attributes and contents, that stand for one joint at a place, ``<origin>``, from its parent to its child; and
    the links without mass between them, which have these names."""
    massless = tag("mass", {"value": "0"}) + tag("inertia", {moment: "0" for moment, _, _ in MOMENTS})
    elements = [tag("link", {"name": name}, tag("inertial", {}, massless)) for name in between]
    ends = [parent, *between, child]
    for k, (attributes, content) in enumerate(joints):
        joined = tag("parent", {"link": ends[k]}) + tag("child", {"link": ends[k + 1]})
        elements.append(tag("joint", attributes, joined + ("" if k else place) + content))
    return "".join(elements)


def as_text(numbers: Iterable[float]) -> str:
    """Numbers as the text of an attribute, to full precision."""
    return " ".join(repr(float(number) + 0.0) for number in numbers)  # + 0.0: no "-0.0"


def _attributes(attributes: Mapping[str, str]) -> str:
    return "".join(f' {name}="{html.escape(value)}"' for name, value in attributes.items())


def _elements(element: Element) -> Iterator[Element]:
    """An element and all that it contains, in the order of their start tags."""
    yield element
    for child in element.children:
        yield from _elements(child)


def _spans(document: bytes) -> list[tuple[int, int, int]]:
    """For each element, in the order of start tags: bytes at which its start tag begins and ends, and at which the element ends."""
    parser = expat.ParserCreate("utf-8")
    spans: list[tuple[int, int, int]] = []
    open_elements: list[int] = []

    def start(*ignored: object) -> None:
        tag = START_TAG.match(document, parser.CurrentByteIndex)
        last = tag.end() if tag else 0
        open_elements.append(len(spans))
        spans.append((parser.CurrentByteIndex, last, last))

    def end(*ignored: object) -> None:
        k = open_elements.pop()
        first, last, _ = spans[k]
        if not document.endswith(b"/>", first, last):
            spans[k] = (first, last, document.index(b">", parser.CurrentByteIndex) + 1)

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.Parse(document, True)
    return spans
