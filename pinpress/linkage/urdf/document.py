"""The text of a URDF as XML elements, each with its line, and findings about them: what reading, checking, showing and rewriting a linkage
start from.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple
from xml.parsers import expat

from ...common import files
from ...common.errors import PinpressError, UrdfError, shown
from ...common.results import Record
from .description import Description, describe
from .element import Element

SEVERITIES = ("error", "warning", "note")

# The largest URDF that comes with pinpress has 30 kB and 200 elements. These limits are far beyond any press, and small enough for a file
# that is none to be refused at once.
MOST_BYTES = 20_000_000
MOST_ELEMENTS = 100_000
MOST_ATTRIBUTES = 100  # most attributes of one element
MOST_CHARACTERS = 1000  # most characters of a name or value
DEEPEST_ELEMENTS = 200  # most levels of elements; Pinocchio's parser stops at 500

START_TAG = re.compile(rb"<(?:[^\"'>]|\"[^\"]*\"|'[^']*')*>")
_REFERENCE = re.compile(r"&(?:#x([0-9a-fA-F]+)|#([0-9]+)|(\w+));")
_ENTITIES = {"lt": "<", "gt": ">", "amp": "&", "quot": '"', "apos": "'"}
_ATTRIBUTE = re.compile(r"([^\s=\"']+)\s*=\s*(?:\"([^\"]*)\"|'([^']*)')")


class Origin(NamedTuple):
    """An element of another format, or of another dialect, from which elements of a URDF were written.

    Attributes:
        element: its name in messages, e.g. ``<body name="crank">``.
        line: its line in its file.
    """

    element: str
    line: int


@dataclass(frozen=True, repr=False)
class Finding(Record):
    """One thing found in a URDF, or in its linkage: `load` raises the first error, `check` lists all findings.

    Attributes:
        severity: "error" (the linkage is not loaded), "warning" (it is loaded, but hardly meant so) or "note" (worth knowing).
        element: the XML element, e.g. ``<joint name="A">``; None where the finding is about the file as a whole.
        line: line of this element in the file; None where there is none.
        problem: what was found.
        remedy: what to write or to do; empty where nothing need be done.
        error: the exception that `load` raises if this is the first error; None of warnings and notes.
    """

    severity: str
    element: str | None
    line: int | None
    problem: str
    remedy: str
    error: PinpressError | None = field(default=None, compare=False, repr=False)

    def message(self, file: str) -> str:
        """The whole finding in the form of a UrdfError's message."""
        place = file if self.line is None else f"{file}:{self.line}"
        return f"{place}: {self.element}: {self.problem}; {self.remedy}"

    @staticmethod
    def of(error: UrdfError) -> Finding:
        return Finding("error", error.element, error.line, error.problem, error.remedy, error)


@dataclass(frozen=True, eq=False)
class Document:
    """A URDF's text. Its elements are read when they are first asked for, and not pickled.

    Attributes:
        file: path of the file.
        text: its content as read, UTF-8, perhaps with a byte order mark; of a file in another format, the URDF made from it.
        origins: of such a file, from which of its elements those of the text were written, by line in the text and tag of the element under
            ``<robot>`` that they are or are in ("robot" for the root).
        remarks: warnings and notes about what such a file says and a URDF cannot.
        estimated: names of links whose moments of inertia nobody wrote: they were worked out from masses and lengths.
    """

    file: str
    text: bytes
    origins: Mapping[tuple[int, str], Origin] = field(default_factory=dict)
    remarks: tuple[Finding, ...] = ()
    estimated: frozenset[str] = frozenset()

    @cached_property
    def robot(self) -> Element:
        """The root element; raises UrdfError where the text is no XML, or too large."""
        root = tree(self.file, self.text.decode("utf-8-sig").encode())
        if self.origins:
            _name_origins(root, self.origins, root.tag)
        return root

    @cached_property
    def description(self) -> Description:
        """What the elements say, of a URDF without errors."""
        return describe(self.robot)

    def find(self, tag: str, name: str | None) -> Element:
        """The first element under ``<robot>`` with this tag and name."""
        return next(element for element in self.robot.all(tag) if element.get("name") == name)

    def called(self, tag: str, name: str) -> str:
        """Name in messages of the element under ``<robot>`` with this tag and name, or of ``<robot>`` itself."""
        if self.origins:
            for element in (self.robot, *self.robot.all(tag)):
                if element.tag == tag and element.get("name") == name and element.origin is not None:
                    return element.origin
        return f'<{tag} name="{name}">'

    def __getstate__(self) -> dict[str, Any]:
        return {"file": self.file, "text": self.text, "origins": self.origins, "remarks": self.remarks, "estimated": self.estimated}


def read(path: str | os.PathLike[str]) -> bytes:
    """The text of a file, UTF-8, perhaps with a byte order mark; raises UrdfError where it is not UTF-8, or cannot be read."""
    file = files.path_of("path", path)
    try:
        text = files.read(path, MOST_BYTES)
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        raise UrdfError(file, None, None, f"cannot be read: {files.reason(error)}", "give the path of a URDF file") from error
    try:
        document = text.decode("utf-8-sig")
        odd = text.find(0)  # a null character, as in UTF-16, which Expat would read
    except UnicodeDecodeError as error:
        odd = error.start
    if odd >= 0:
        line = text.count(b"\n", 0, odd) + 1
        raise UrdfError(file, None, line, f"is not UTF-8 text (byte {odd})", "save it in the UTF-8 encoding")
    if not document.strip():
        raise UrdfError(file, None, None, "is empty", "write a <robot> element")
    return text


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

    def forbid(problem: str, remedy: str, element: str | None = None) -> None:
        raise UrdfError(file, element, parser.CurrentLineNumber, problem, remedy)

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if problem := _too_large(count, tag, attributes):
            forbid(problem, "remove what does not belong to the press")
        attributes |= _broken(document, parser.CurrentByteIndex)
        element = Element(tag, attributes, parser.CurrentLineNumber, opened[-1] if opened else None, parser.CurrentByteIndex)
        if tag.startswith("xacro:"):
            forbid("is xacro, not URDF", "expand the file first: xacro press.urdf.xacro > press.urdf", str(element))
        if tag.endswith(":include"):
            forbid("is XInclude, which Pinocchio does not read", "write what it includes in its place", str(element))
        if len(opened) > DEEPEST_ELEMENTS:
            forbid("is nested too deeply", "remove it", str(element))
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


def refuse_errors(findings: Iterable[Finding], command: str) -> None:
    """Raise the first error among findings. Its message says how many more there are, and that ``command`` lists them."""
    errors = [finding.error for finding in findings if finding.error is not None]
    if len(errors) > 1:
        errors[0].args = (f"{errors[0]} ({len(errors) - 1} more: {command} lists them)",)
    if errors:
        raise errors[0]


def check_command(file: str, drivers: Iterable[str] = (), slide: str | None = None, parameters: Iterable[str] = ()) -> str:
    """The command that lists what is found in a file; ``parameters``: of a pin table, as ``r=150``."""
    import shlex  # only on the way to an error

    options = [word for driver in drivers for word in ("--driver", driver)] + ([] if slide is None else ["--slide", slide])
    options += [word for parameter in parameters for word in ("--set", parameter)]
    return shlex.join(["pinpress", "check", file, *options])


def _name_origins(element: Element, origins: Mapping[tuple[int, str], Origin], tag: str) -> None:
    """Give an element and all that it contains the lines and names of their origins; ``tag``: see `Document.origins`."""
    origin = origins.get((element.line, tag))
    if origin is not None:
        element.origin, element.line = origin
    for child in element.children:
        _name_origins(child, origins, child.tag if element.parent is None else tag)


def _broken(document: bytes, start: int) -> dict[str, str]:
    """Those attributes of the tag at byte ``start`` that contain tabs or line breaks, with these.

    XML reads them as spaces. Pinocchio's parser does not: it fails on a number with a line break in it, or drops it.
    """
    tag = START_TAG.match(document, start)
    found = _ATTRIBUTE.findall(tag[0].decode()) if tag and re.search(rb"[\t\r\n]", tag[0]) else ()
    values = {name: double or single for name, double, single in found}
    return {
        name: _REFERENCE.sub(_meant, re.sub(r"\r\n?|\n\r", "\n", value)) for name, value in values.items() if re.search(r"[\t\r\n]", value)
    }


def _meant(reference: re.Match[str]) -> str:
    """The character that a reference such as ``&#10;`` or ``&lt;`` stands for."""
    hexadecimal, decimal, name = reference.groups()
    return _ENTITIES[name] if name else chr(int(hexadecimal, 16) if hexadecimal else int(decimal))


def _too_large(count: int, tag: str, attributes: Mapping[str, str]) -> str | None:
    """What is too large in the ``count``th element of a file; None where nothing is."""
    if count > MOST_ELEMENTS:
        return f"has more than {MOST_ELEMENTS} elements"
    if len(attributes) > MOST_ATTRIBUTES:
        return f"an element has {len(attributes)} attributes, more than {MOST_ATTRIBUTES}"
    longest = max((tag, *attributes, *attributes.values()), key=len)
    if len(longest) > MOST_CHARACTERS:
        return f"a name or value of {len(longest)} characters, more than {MOST_CHARACTERS}: {shown(longest[:40])}..."
    return None
