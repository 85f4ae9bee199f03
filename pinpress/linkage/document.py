"""A URDF: its text, its elements and what they say; and findings about it."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

from ..common import files
from ..common.errors import PinpressError, UrdfError
from ..common.results import Record
from .description import Description, describe
from .element import MOST_BYTES, Element, tree

SEVERITIES = ("error", "warning", "note")


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
    """An error, a warning or a note about a URDF or its linkage: `load` raises the first error, `check` lists all findings.

    Attributes:
        severity: "error" (the linkage is not loaded), "warning" (it is loaded, but probably a mistake) or "note" (worth knowing).
        element: the XML element, e.g. ``<joint name="A">``; None if the finding is about the file as a whole.
        line: line of this element in the file; None if it has no line.
        problem: what is wrong, odd or worth knowing.
        remedy: what to write or to do; empty if nothing need be done.
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
        origins: elements of such a file from which those of the text were written, by line in the text and tag of the element under
            ``<robot>`` that they are or are in ("robot" for the root).
        remarks: warnings and notes about what such a file says and a URDF cannot.
        estimated: names of links whose moments of inertia were worked out from masses and lengths.
    """

    file: str
    text: bytes
    origins: Mapping[tuple[int, str], Origin] = field(default_factory=dict)
    remarks: tuple[Finding, ...] = ()
    estimated: frozenset[str] = frozenset()

    @cached_property
    def robot(self) -> Element:
        """The root element; raises UrdfError if the text is no XML, or too large."""
        root = tree(self.file, self.text.decode("utf-8-sig").encode())
        if self.origins:
            _name_origins(root, self.origins, root.tag)
        return root

    @cached_property
    def description(self) -> Description:
        """What the elements say."""
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
    """The text of a file, UTF-8, perhaps with a byte order mark; raises UrdfError if it is not UTF-8, or cannot be read."""
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


def refuse_errors(findings: Iterable[Finding], command: str) -> None:
    """Raise the first error among findings. Its message says how many more there are, and that ``command`` lists them."""
    errors = [finding.error for finding in findings if finding.error is not None]
    if len(errors) > 1:
        errors[0].args = (f"{errors[0]} ({len(errors) - 1} more: {command} lists them)",)
    if errors:
        raise errors[0]


def check_command(file: str, drivers: Sequence[str] = (), slide: str | None = None, parameters: Sequence[str] = ()) -> str:
    """The command that lists what is found in a file; ``parameters``: of a pin table, as ``r=150``."""
    import shlex  # only on the way to an error

    options = [f"drivers={' '.join(drivers)}"] if drivers else []
    options += ([] if slide is None else [f"slide={slide}"]) + list(parameters)
    return shlex.join(["pinpress", "check", file, *(word for option in options for word in ("--set", option))])


def _name_origins(element: Element, origins: Mapping[tuple[int, str], Origin], tag: str) -> None:
    """Give an element and all that it contains the lines and names of their origins; ``tag``: see `Document.origins`."""
    origin = origins.get((element.line, tag))
    if origin is not None:
        element.origin, element.line = origin
    for child in element.children:
        _name_origins(child, origins, child.tag if element.parent is None else tag)
