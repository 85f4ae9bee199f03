"""Reads the items of docstrings as they are written here: several names before a colon, and several items in a line.

    crank_angle, crank_speed: (n,) of the driver joint.
    linkage: its name. drivers: its driver joints.

The parser of Google's style takes the first line's second name for a type and the second line for one item. An extension of griffe, see
mkdocs.yml.
"""

import re
from typing import Any

import griffe

SECTION = re.compile(r"^(Args|Attributes):\n((?:(?: +.*)?\n?)*)", flags=re.MULTILINE)
NAMES = r"\*{0,2}\w+(?:, \*{0,2}\w+)*"
NO_BREAK = "\u00a0"  # a space that does not end a name


class Items(griffe.Extension):
    """Rewrites docstrings once a package has been read."""

    def on_package(self, *, pkg: griffe.Module, **_: Any) -> None:
        _rewrite(pkg)


def _rewrite(within: griffe.Module | griffe.Class) -> None:
    for member in within.members.values():
        if member.is_alias or not isinstance(member, griffe.Module | griffe.Class | griffe.Function):
            continue
        if member.docstring is not None and not member.is_module:
            member.docstring.value = itemised(member.docstring.value, _types(member))
        if not isinstance(member, griffe.Function):
            _rewrite(member)


def _types(of: Any) -> dict[str, str]:
    """Names that its docstring may describe, with their types."""
    known = of.parameters if isinstance(of, griffe.Function) else of.all_members.values()
    return {each.name: str(getattr(each, "annotation", None) or "") for each in known}


def itemised(docstring: str, types: dict[str, str]) -> str:
    """The docstring with an item a line, names of one item joined; only names of which a type is known begin an item within a line."""

    def split(match: re.Match[str]) -> str:
        names = match[1].replace("*", "").split(", ")
        return f".\n    {match[1]}: " if types.keys() >= set(names) else match[0]

    def join(match: re.Match[str]) -> str:
        of_each = [types.get(name, "") for name in match[1].replace("*", "").split(", ")]
        of_all = ", ".join(dict.fromkeys(filter(None, of_each)))
        return f"    {match[1].replace(' ', NO_BREAK)}" + (f" ({of_all}):" if of_all else ":")

    def section(match: re.Match[str]) -> str:
        lines = re.sub(rf"\.\s+({NAMES}): ", split, match[2])
        return f"{match[1]}:\n" + re.sub(rf"^ {{4}}({NAMES}):", join, lines, flags=re.MULTILINE)

    return SECTION.sub(section, docstring)
