"""A pin table as entries that know where they stand: read from YAML, or from the arguments of a call; laid over another table.

Scalars are read as text: a pin may be called NO or 1, and 290,57 is not read as something else. What is a number is decided where a number
is wanted.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import yaml

from ..common.arguments import is_number, number
from ..common.errors import PinTableError, caution, shown, suggestion
from ..common.files import path_of, read, reason

CALL = "build(...)"  # in place of a file's name, of a table or values that a call gives
LARGEST_FILE = 1 << 20  # [bytes]
MOST_ENTRIES = 20_000  # aliases of YAML may multiply them
DEEPEST = 12  # most levels of mappings and lists in each other
MOST_BASES = 20
USUAL_WORDS = {  # what else keys are called, in lower case
    "radius": "length",
    "l": "length",
    "len": "length",
    "weight": "mass",
    "m": "mass",
    "cog": "com",
    "centre": "com",
    "center": "com",
    "j": "inertia",
    "i": "inertia",
    "material": "density",
    "rho": "density",
    "slot": "guide",
    "cylinder": "guide",
    "driver": "drive",
    "name": "press",
    "unit": "units",
}


@dataclass(frozen=True)
class Entry:
    """A value of a table.

    Attributes:
        value: text, a number or a truth value given in a call, several entries, entries by their keys, or None for nothing.
        file: the table's file, or how the table is called.
        line: in the file; None where there is none.
        path: keys that lead to it, from the top.
    """

    value: str | float | bool | tuple[Entry, ...] | Mapping[str, Entry] | None
    file: str
    line: int | None
    path: tuple[str, ...]

    def refuse(self, problem: str, remedy: str) -> NoReturn:
        """Raise PinTableError: what is wrong here, and what to write."""
        raise PinTableError(self.file, self.line, ": ".join(self.path), problem, remedy)

    def doubt(self, said: str) -> None:
        """Warn of what is hardly meant here."""
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        caution(f"{place}: {': '.join(self.path)}: {said}")

    def text(self, what: str) -> str:
        """The value as one text."""
        if isinstance(self.value, str):
            return self.value
        if isinstance(self.value, float):
            return f"{self.value:.17g}"
        return self.refuse(self.described(), f"write {what}")

    def names(self, what: str) -> list[str]:
        """Names, separated by blanks or in a list."""
        listed = isinstance(self.value, tuple)
        names = [each.text(what) for each in self.list(what)] if listed else self.text(what).split()
        if not names:
            self.refuse("it is empty", f"write {what}")
        for name in names:
            if name.strip(",;") != name:
                self.refuse(f"{self.value!r}", f"separate names by blanks: {' '.join(each.strip(',;') for each in names)}")
        return names

    def items(self, what: str) -> Mapping[str, Entry]:
        """Entries by their keys."""
        if isinstance(self.value, Mapping):
            return self.value
        if isinstance(self.value, str) and ":" in self.value:
            self.refuse(f"{self.value!r} is one text", "write a space after the colon")
        return self.refuse(self.described(), f"write {what}")

    def list(self, what: str) -> tuple[Entry, ...]:
        """Several entries."""
        return self.value if isinstance(self.value, tuple) else self.refuse(self.described(), f"write {what}")

    def known(self, keys: Sequence[str], what: str) -> Mapping[str, Entry]:
        """Entries by their keys, all of which are known ones."""
        items = self.items(f"{what}: {{{keys[0]}: ...}}")
        for key, entry in items.items():
            if key not in keys:
                self.refuse_key(key, entry, keys)
        return items

    def refuse_key(self, key: str, entry: Entry, keys: Sequence[str]) -> NoReturn:
        """Raise PinTableError: a key that is none of those allowed here."""
        where = replace(entry, path=self.path)
        if ":" in key:
            where.refuse(f"{key!r} is no key here", "write a space after the colon")
        if key.isdigit() and entry.value is None:
            where.refuse(f"{key!r} is no key here", "write decimals after a point, not after a comma")
        if entry.value is None and "pins" in keys:
            where.refuse(f"{key!r} is no key here", "separate names by blanks, as in pins: A B")
        usual = USUAL_WORDS.get(key.lower())
        meant = f", did you mean {usual!r}?" if usual in keys else suggestion(key, keys)
        where.refuse(f"{key!r} is no key here{meant}", f"write some of {', '.join(keys)}")

    def described(self) -> str:
        """What kind of value this is, in words."""
        if self.value is None:
            return "there is nothing"
        if isinstance(self.value, str):
            return f"{shown(self.value)} is a text"
        kinds = {tuple: "a list", bool: "True or False"}
        return next(
            (words for kind, words in kinds.items() if isinstance(self.value, kind)),
            "keys with values" if isinstance(self.value, Mapping) else "a number",
        )


def read_table(path: str | os.PathLike[str]) -> Entry:
    """The table of a YAML file, laid over the one that it names as its ``base``.

    Raises:
        PinTableError: the file cannot be read, is no YAML, or has a key twice; with the line.
    """
    return _with_bases(Path(path_of("path", path)), ())


def given_table(values: Mapping[str, Any]) -> Entry:
    """The table of a call's arguments: numbers, texts, lists and mappings as they would stand in a file."""
    return _given(values, CALL, ())


def overlaid(below: Entry, above: Entry) -> Entry:
    """A table laid over another: its pins, parameters, gears and keys of links replace those below; ``none`` removes them."""
    return _overlaid(below, above, 0)


def _overlaid(below: Entry, above: Entry, depth: int) -> Entry:
    if not (isinstance(below.value, Mapping) and isinstance(above.value, Mapping)) or depth > _MERGED.get(
        above.path[0] if above.path else "", 0
    ):
        return above
    merged = dict(below.value)
    for key, entry in above.value.items():
        if entry.value == "none" and (depth or key != "masses"):
            merged.pop(key, None)
        else:
            merged[key] = _overlaid(merged[key], entry, depth + 1) if key in merged else entry
    return replace(above, value=merged)


_MERGED = {"parameters": 1, "pins": 1, "links": 2, "gears": 1}  # how deep entries are merged; below they are replaced as a whole


def _with_bases(path: Path, above: tuple[Path, ...]) -> Entry:
    table = _parsed(path)
    if not (isinstance(table.value, Mapping) and "base" in table.value):
        return table
    base = table.value["base"]
    if path.resolve() in above or len(above) == MOST_BASES:
        base.refuse("the tables are each other's base", "name a base that does not lead back here")
    below = _with_bases(path.parent / base.text("the file of another table"), (*above, path.resolve()))
    own = replace(table, value={key: entry for key, entry in table.value.items() if key != "base"})
    return overlaid(below, own)


def _parsed(path: Path) -> Entry:
    file = str(path)
    try:
        text = read(path, LARGEST_FILE).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise PinTableError(file, None, "", "it is not UTF-8", "save it as UTF-8") from error
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        raise PinTableError(file, None, "", f"it cannot be read: {reason(error)}", "give the path of a pin table") from error
    try:
        node = yaml.compose(text, Loader=yaml.BaseLoader)
    except yaml.MarkedYAMLError as error:
        raise _syntax_error(file, text, error) from error
    except yaml.YAMLError as error:
        raise PinTableError(
            file, None, "", f"it is no YAML: {' '.join(str(error).split())}", "write keys and values as in the manual"
        ) from error
    except RecursionError as error:
        raise PinTableError(file, None, "", "it is nested too deeply", "write keys and values as in the manual") from error
    if node is None:
        raise PinTableError(file, None, "", "it is empty", "write units, frame, pins, links and drive")
    return _Composer(file).entry(node, ())


def _syntax_error(file: str, text: str, error: yaml.MarkedYAMLError) -> PinTableError:
    mark = error.problem_mark or error.context_mark
    line = None if mark is None else mark.line + 1
    said = " ".join(part for part in (error.context, error.problem) if part)
    written = text.splitlines()[line - 1] if line is not None and line <= len(text.splitlines()) else ""
    if "\t" in written[: len(written) - len(written.lstrip())]:
        return PinTableError(file, line, "", "there is a tab before the text", "indent with blanks")
    return PinTableError(file, line, "", f"it is no YAML: {said}", "see that brackets close, and that a space follows each colon")


class _Composer:
    """From YAML's nodes to entries."""

    def __init__(self, file: str) -> None:
        self.file, self.count = file, 0

    def entry(self, node: yaml.Node, path: tuple[str, ...]) -> Entry:
        line = node.start_mark.line + 1
        self.count += 1
        if self.count > MOST_ENTRIES or len(path) > DEEPEST:
            raise PinTableError(
                self.file,
                line,
                ": ".join(path[:DEEPEST]),
                "the table is too large",
                f"write at most {MOST_ENTRIES} entries, {DEEPEST} deep",
            )
        if isinstance(node, yaml.MappingNode):
            return Entry(self._mapping(node, path), self.file, line, path)
        if isinstance(node, yaml.SequenceNode):
            items = tuple(self.entry(each, (*path, str(k + 1))) for k, each in enumerate(node.value))
            return Entry(items, self.file, line, path)
        empty = node.value == "" and node.style is None
        return Entry(None if empty else node.value, self.file, line, path)

    def _mapping(self, node: yaml.MappingNode, path: tuple[str, ...]) -> Mapping[str, Entry]:
        items: dict[str, Entry] = {}
        for key, value in node.value:
            line = key.start_mark.line + 1
            if not isinstance(key, yaml.ScalarNode):
                raise PinTableError(self.file, line, ": ".join(path), "a key is no single word", "write a name before the colon")
            entry = self.entry(value, (*path, key.value))
            if key.value in items:
                raise PinTableError(self.file, line, ": ".join((*path, key.value)), f"{key.value} stands there twice", "remove one of them")
            items[key.value] = replace(entry, line=line)
        return items


def _given(value: Any, file: str, path: tuple[str, ...]) -> Entry:
    if len(path) > DEEPEST:
        raise PinTableError(file, None, ": ".join(path), "the table is too deep", "write it as in the manual")
    if isinstance(value, Mapping):
        return Entry({str(key): _given(each, file, (*path, str(key))) for key, each in value.items()}, file, None, path)
    if isinstance(value, str | bool) or value is None:
        return Entry(value, file, None, path)
    if is_number(value):
        return Entry(number(": ".join(path), value), file, None, path)
    if isinstance(value, np.ndarray) and value.ndim and type(value) is np.ndarray:
        value = value.tolist()
    if isinstance(value, list | tuple) and len(value) <= MOST_ENTRIES:
        return Entry(tuple(_given(each, file, (*path, str(k + 1))) for k, each in enumerate(value)), file, None, path)
    raise PinTableError(
        file, None, ": ".join(path), f"{shown(value)} is a {type(value).__name__}", "give numbers, texts, lists and mappings"
    )
