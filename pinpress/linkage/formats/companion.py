"""The YAML file beside a URDF that says where its loops close: FILE.yaml beside FILE.urdf, as in a public set of parallel robots.

    closed_loop: [[left_tip, right_tip]]    # pairs of links, which fixed joints place on the two sides
    type: [6d]                              # 3d: their origins coincide; 6d: their axes do too
    name_mot: [hip, knee]                   # joints that drive
    joint_name: [foot]                      # joints of the URDF that are written as one hinge, but are
    joint_type: [UJOINT_XY]                 # two hinges about x and then y of the joint's frame; or SPHERICAL, or FIXED

It becomes part of the URDF's text, without a change of line numbers. Any other YAML file of this name, such as a pin table, is left alone.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import takewhile
from pathlib import Path

import numpy as np

from ...common.errors import FileEntryError, UrdfError, suggestion
from ...common.files import read
from ...common.quantities import Array
from ...common.reading.entries import LARGEST_FILE, Entry, FileKind, read_entries
from ..description import names
from ..document import Document, Finding, Origin
from ..element import Element
from ..text import Text, as_text, in_series, tag
from .dialects import pose_of_origin
from .elements import take
from .mechanism import UNLIMITED, ball_axes

_KEYS = ("closed_loop", "type", "name_mot", "joint_name", "joint_type")
_KIND = FileKind("companion of a URDF", FileEntryError, ", ".join(_KEYS))
_LOOPS = {"3d": "spherical", "6d": "fixed"}


def joined(document: Document) -> Document:
    """The URDF with what the YAML file beside it says; the document itself if there is no such file.

    Raises:
        UrdfError: the file is no YAML, names a frame or joint that the URDF lacks, or an unknown type, or has lists of different lengths.
    """
    path = Path(document.file).with_suffix(".yaml")
    try:
        if not path.is_file() or not re.search(rb"^[{\s\"']*closed_loop[\"']?\s*:", read(path, LARGEST_FILE), re.MULTILINE):
            return document
    except (OSError, ValueError):  # of a file that is too large, or must not be read
        return document
    try:
        return _Companion(document, read_entries(path, _KIND)).document()
    except FileEntryError as error:
        raise UrdfError(error.file, error.element or None, error.line, error.problem, error.remedy) from error


class _Companion:
    """Lays the entries of the YAML file over the text of the URDF."""

    def __init__(self, document: Document, top: Entry) -> None:
        self.before, self.robot, self.text = document, document.robot, Text(document)
        self.top, self.entries = top, top.items("keys with values")
        self.links = {link.get("name"): link for link in self.robot.all("link")}
        self.joints = {joint.get("name"): joint for joint in self.robot.all("joint")}
        self.taken = {*self.links, *self.joints, *names(self.robot, "loop_joint")}
        self.origins: dict[tuple[int, str], Origin] = {}
        self.split: list[str] = []  # joints that are made of several, and these
        unknown = ((key, entry) for key, entry in self.entries.items() if key not in _KEYS)
        self.remarks = [self._remark(entry, "it is not read" + suggestion(key, _KEYS)) for key, entry in unknown]

    def document(self) -> Document:
        retyped: set[str] = set()
        for entry, kind in zip(*self._lists("joint_name", "joint_type"), strict=True):
            joint = self._named(entry, self.joints, "joint")
            if joint.get("name") in retyped:
                entry.refuse(f"joint {joint.get('name')!r} stands there twice", "remove one of them")
            retyped.add(joint.get("name"))
            self._retype(joint, kind)
        if self.split:
            listed = "; ".join(self.split[:12]) + ("; and others" if len(self.split) > 12 else "")
            self.remarks.append(self._remark(self.entries["joint_type"], f"joints made of revolute joints: {listed}", "note", ""))
        for pair, kind in zip(*self._lists("closed_loop", "type"), strict=True):
            self._close(pair, kind)
        self._drive(retyped)
        return Document(self.before.file, self.text.edited(), self.origins, (*self.before.remarks, *self.remarks))

    def _remark(self, entry: Entry, problem: str, severity: str = "warning", remedy: str = "correct or remove it") -> Finding:
        return Finding(severity, f"{Path(entry.file).name}:{entry.line}: {': '.join(entry.path)}", None, problem, remedy)

    def _lists(self, first: str, second: str) -> tuple[Sequence[Entry], Sequence[Entry]]:
        """Two lists that belong together; empty if the first is not written."""
        if first not in self.entries:
            return (), ()
        if second not in self.entries:
            self.entries[first].refuse(f"there is no {second}", f"write {second}: [...] with one word for each of {first}")
        one, other = (self.entries[key].list("a list: [...]") for key in (first, second))
        if len(one) != len(other):
            problem = f"{first} has {len(one)} entries, and {second} has {len(other)}"
            self.entries[second].refuse(problem, f"write one of {second} for each of {first}")
        return one, other

    def _named(self, entry: Entry, elements: dict[str, Element], what: str) -> Element:
        name = entry.text(f"the name of a {what}")
        if name not in elements:
            entry.refuse(f"{self.before.file} has no {what} {name!r}{suggestion(name, elements)}", f"name a <{what}> of the URDF")
        return elements[name]

    # --------------------------------------------------------------------------------------------------------------------------- loops

    def _close(self, pair: Entry, kind: Entry) -> None:
        ends = pair.list("two links: [one, other]")
        if len(ends) != 2:
            pair.refuse(f"a loop joins 2 links, not {len(ends)}", "write two links: [one, other]")
        first, second = (self._named(end, self.links, "link") for end in ends)
        word = kind.text("3d or 6d").lower()
        if word not in _LOOPS:
            kind.refuse(f"unknown type of a loop {kind.value!r}", "write 3d where points coincide, 6d where axes do too")
        frames = first.get("name"), second.get("name")
        common = "".join(one for one, _ in takewhile(lambda pair: pair[0] == pair[1], zip(*frames, strict=False)))
        name = take(common.rstrip("_-. ") or "_".join(frames), self.taken)
        content = "".join(tag(f"link{k}", {"link": frame}) for k, frame in enumerate(frames, 1))
        self.text.insert(first, tag("loop_joint", {"name": name, "type": _LOOPS[word]}, content))
        self.origins[first.line, "loop_joint"] = Origin(f"<loop_joint name={name!r}> of {Path(pair.file).name}:{pair.line}", first.line)

    # -------------------------------------------------------------------------------------------------------------------------- joints

    def _retype(self, joint: Element, kind: Entry) -> None:
        word = kind.text("a type of joint").upper()
        hinges = re.fullmatch(r"UJOINT_([XYZ])([XYZ])", word)
        if word == "FIXED":
            self.text.set(joint, {"type": "fixed"})
            return
        if joint.all("mimic"):
            kind.refuse(f"joint {joint.get('name')!r} follows another joint, and cannot be made of hinges", "remove its <mimic>")
        if word == "SPHERICAL":
            self._split(joint, "xyz", self._ball_axes(joint))
        elif hinges and hinges[1] != hinges[2]:
            self._split(joint, hinges[1] + hinges[2], np.eye(3)[["XYZ".index(letter) for letter in hinges.groups()]])
        else:
            kind.refuse(f"unknown type of a joint {kind.value!r}", "write SPHERICAL, FIXED, or UJOINT_XY with any two of X, Y and Z")

    def _split(self, joint: Element, letters: str, axes: Array) -> None:
        """Write a hinge for each axis (k, 3) in place of a joint, with massless links between them."""
        name, parent, child = joint.get("name"), joint.of_child("parent", "link"), joint.of_child("child", "link")
        placed = "".join(tag("origin", origin.attributes) for origin in joint.all("origin")[:1])
        hinges = [take(f"{name}_{letter}", self.taken) for letter in letters]
        between = [take(f"{name}_{k}", self.taken) for k in range(1, len(hinges))]
        single = [
            ({"name": hinge, "type": "continuous"}, tag("axis", {"xyz": as_text(axis)})) for hinge, axis in zip(hinges, axes, strict=True)
        ]
        self.text.replace(joint, in_series(single, parent, child, between, placed))
        origin = Origin(str(joint), joint.line)
        self.origins |= {(joint.line, "joint"): origin, (joint.line, "link"): origin}
        self.split.append(f"{name} ({', '.join(hinges)})")

    def _ball_axes(self, joint: Element) -> Array:
        """(3, 3) axes, as rows in the joint's frame, about which a ball does not lock where it turns on."""
        child, parent = joint.of_child("child", "link"), joint.of_child("parent", "link")
        file, joints = self.before.file, self.joints.values()
        pins = [pose_of_origin(file, other).translation for other in joints if other.of_child("parent", "link") == child]
        carrier = next((other for other in joints if other.of_child("child", "link") == parent), None)
        turns = None
        if carrier is not None and carrier.get("type") in ("revolute", "continuous"):
            axis = next((each.numbers("xyz") for each in carrier.all("axis")), ()) or (1.0, 0.0, 0.0)
            turns = pose_of_origin(file, joint).rotation.T @ np.array(axis)
        return ball_axes(np.mean(pins, axis=0) if pins else np.zeros(3), turns)

    # ------------------------------------------------------------------------------------------------------------------------- drivers

    def _drive(self, retyped: set[str]) -> None:
        """Let the joints of ``name_mot`` drive, if the URDF names no drivers. Limits from 0 to 0 are those of programs that know none."""
        listed = self.entries["name_mot"].list("a list of joints: [...]") if "name_mot" in self.entries else ()
        named: set[str] = set()
        for entry in () if self.before.description.drivers else listed:
            name = entry.text("the name of a joint")
            if name in named:
                continue
            named.add(name)
            if name not in self.joints or name in retyped:
                reason = "there is no such joint in the URDF" if name not in self.joints else "this joint is not a single hinge"
                self.remarks.append(self._remark(entry, f"{name!r} does not drive: {reason}{suggestion(name, self.joints)}"))
                continue
            joint = self.joints[name]
            self.text.insert(joint, tag("transmission", {"name": f"{name}_drive"}, tag("joint", {"name": name})))
            for limit in joint.all("limit"):
                if limit.number("lower", 0.0) == limit.number("upper", 0.0) == 0.0:
                    self.text.set(limit, {"lower": as_text([-UNLIMITED]), "upper": as_text([UNLIMITED])})
