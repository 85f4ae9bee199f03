"""Packages that pages contain, with their licences.

Pages contain Meshcat's viewer and Plotly's charts. Each is one script into which many packages were bundled. Meshcat has an incomplete list
of them, Plotly has none. The missing entries are in ``templates/licences.json``, which ``python docs/make.py page_licences`` writes.
Licences are SPDX expressions.
"""

import functools
import importlib.resources
import itertools
import json
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Part:
    """A package that is in a script of a page.

    Attributes:
        name: its name in its registry.
        version: empty if the bundle does not state it.
        licence: SPDX expression.
        notice: the copyright notice of the package; empty if it is in ``text``.
        text: the licence.
    """

    name: str
    version: str
    licence: str
    notice: str
    text: str


@functools.cache
def of_meshcat(script: Path) -> tuple[Part, ...]:
    """The packages in Meshcat's viewer, ``script``: those of the list next to it, and those that are missing in it or have no text."""
    listed = json.loads(script.with_name(f"{script.name}.THIRD_PARTY_LICENSES.json").read_text("utf-8"))
    parts = {part.name: part for part in map(_part, _known()["meshcat"])}
    for each in listed:
        if each["licenseText"] or each["name"] not in parts:
            parts[each["name"]] = Part(each["name"], each["version"], each["license"], "", (each["licenseText"] or each["license"]).strip())
    return tuple(part for _, part in sorted(parts.items()))


@functools.cache
def of_plotly(version: str) -> tuple[Part, ...]:
    """The packages in a version of plotly.js; for an unknown version, the packages in all known versions."""
    return tuple(_part(entry) for entry in _known()["plotly"] if version in entry["in"] or version not in examined())


def plotly_version(head: str) -> str:
    """The version in the comment in front of plotly.js; empty if there is none."""
    version = re.search(r"plotly\.js v([\w.-]+)", head)
    return version[1] if version else ""


def examined() -> tuple[str, ...]:
    """The versions of plotly.js whose parts are known."""
    return tuple(sorted({version for each in _known()["plotly"] for version in each["in"]}))


def together(title: str, parts: Iterable[Part]) -> str:
    """Notices and licences of the parts of a script. Each text appears once."""
    passages = [title]
    by_text = sorted(parts, key=lambda part: (part.licence, part.text, part.name))
    for text, same in itertools.groupby(by_text, key=lambda part: part.text):
        holders = [" ".join(filter(None, (part.name, part.version))) + (f": {part.notice}" if part.notice else "") for part in same]
        passages.append("\n".join(holders) + "\n\n" + text)
    return "\n\n".join(passages)


def _part(entry: dict[str, Any]) -> Part:
    text = _known()["texts"].get(entry["text"], entry["text"])
    return Part(entry["name"], entry["version"], entry["licence"], entry["notice"], text)


@functools.cache
def _known() -> dict[str, Any]:
    """The list of ``templates/licences.json``."""
    text = (importlib.resources.files(__package__) / "templates" / "licences.json").read_text("utf-8")
    return dict(json.loads(text))
