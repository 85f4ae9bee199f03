"""A file in YAML as entries that know where they stand, so that messages name file, line and keys; JSON is YAML too.

Scalars are read as text: a name may be NO or 1, and 290,57 is not read as something else. What is a number is decided where a number is
wanted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, is_dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import yaml

from ..arguments import is_number, number
from ..errors import FileEntryError, caution, shown, suggestion
from ..files import read, reason

LARGEST_FILE = 1 << 20  # [bytes]
MOST_ENTRIES = 20_000  # aliases of YAML may multiply them
DEEPEST = 12  # most levels of mappings and lists in each other


@dataclass(frozen=True)
class FileKind:
    """A kind of file, for messages.

    Attributes:
        name: what such a file is called.
        error: what is raised where one is wrong.
        top: keys of the top, for one that is empty.
        usual: what else keys are called, in lower case.
        bare: a key -> what to write where a key that has no value stands beside it.
    """

    name: str
    error: type[FileEntryError]
    top: str
    usual: Mapping[str, str] = field(default_factory=dict)
    bare: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Entry:
    """A value of a file.

    Attributes:
        value: text, a number or a truth value given in a call, several entries, entries by their keys, or None for nothing.
        file: the file, or how what was given is called.
        line: in the file; None if there is none.
        path: keys that lead to it, from the top.
        kind: what kind of file it stands in.
        file_text: of the whole file, in its topmost entry; empty elsewhere.
    """

    value: str | float | bool | tuple[Entry, ...] | Mapping[str, Entry] | None
    file: str
    line: int | None
    path: tuple[str, ...]
    kind: FileKind = field(repr=False)
    file_text: str = field(default="", repr=False)

    @property
    def folder(self) -> Path:
        """Where the files are that it names: beside its file, or the current folder where it stands in none."""
        return Path() if self.line is None else Path(self.file).parent

    def refuse(self, problem: str, remedy: str) -> NoReturn:
        """Raise the kind's error: what is wrong here, and what to write."""
        raise self.kind.error(self.file, self.line, ": ".join(self.path), problem, remedy)

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
        self.refuse_unknown(items, keys)
        return items

    def refuse_unknown(self, items: Mapping[str, Entry], keys: Sequence[str]) -> None:
        """Raise the kind's error where one of these entries has a key that is none of those allowed here."""
        before = ""
        for key, entry in items.items():
            if key not in keys:
                self.refuse_key(key, entry, keys, before)
            before = f"{key}: {entry.value}" if isinstance(entry.value, str) else ""

    def refuse_key(self, key: str, entry: Entry, keys: Sequence[str], before: str = "") -> NoReturn:
        """Raise the kind's error: a key that is none of those allowed here; ``before``: what stands before it."""
        where = replace(entry, path=self.path)
        if ":" in key:
            where.refuse(f"{key!r} is no key here", "write a space after the colon")
        if key[:1].isdigit() and entry.value is None:
            decimals = f": {before}.{key}" if before else ", not after a comma"
            where.refuse(f"{key!r} is no key here", f"write decimals after a point{decimals}")
        bare = next((remedy for known, remedy in self.kind.bare.items() if known in keys), None)
        if entry.value is None and bare is not None:
            where.refuse(f"{key!r} is no key here", bare)
        usual = self.kind.usual.get(key.lower())
        meant = f", did you mean {usual!r}?" if usual in keys else suggestion(key, keys)
        where.refuse(f"{key!r} is no key here{meant}", f"write some of {', '.join(keys)}")

    def described(self) -> str:
        """What kind of value this is, as text."""
        if self.value is None:
            return "there is nothing"
        if isinstance(self.value, str):
            return f"{shown(self.value)} is a text"
        kinds = {tuple: "a list", bool: "True or False"}
        return next(
            (words for kind, words in kinds.items() if isinstance(self.value, kind)),
            "keys with values" if isinstance(self.value, Mapping) else "a number",
        )


def read_entries(path: Path, kind: FileKind) -> Entry:
    """The entries of a file.

    Raises:
        FileEntryError: that of the kind: the file cannot be read, is no YAML, or has a key twice; with the line.
    """
    file = str(path)

    def wrong(line: int | None, problem: str, remedy: str) -> FileEntryError:
        return kind.error(file, line, "", problem, remedy)

    try:
        text = read(path, LARGEST_FILE).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise wrong(None, "it is not UTF-8", "save it as UTF-8") from error
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        raise wrong(None, f"it cannot be read: {reason(error)}", f"give the path of a {kind.name}") from error
    try:
        node = _nodes(text)
    except yaml.MarkedYAMLError as error:
        raise wrong(*_syntax_error(text, error)) from error
    except yaml.YAMLError as error:
        raise wrong(None, f"it is no YAML: {' '.join(str(error).split())}", "write keys and values as in the manual") from error
    except RecursionError as error:
        raise wrong(None, "it is nested too deeply", "write keys and values as in the manual") from error
    if node is None:
        raise wrong(None, "it is empty", f"write {kind.top}")
    return replace(_Composer(file, kind).entry(node, ()), file_text=text)


def entry_of_text(text: str, called: str, path: tuple[str, ...], kind: FileKind) -> Entry:
    """The entry of a text in YAML that stands in no file, such as "{kind: die, height: 1 mm}".

    Args:
        text: as behind a colon in a file.
        called: in place of a file's name.
        path: keys that lead to the entry.
        kind: kind of file in which it would stand.

    Raises:
        FileEntryError: that of the kind: it is no YAML.
    """
    try:
        node = yaml.compose(text, Loader=yaml.BaseLoader)
    except (yaml.YAMLError, RecursionError) as error:
        raise kind.error(called, None, "", f"{text!r} is no YAML", "write it as behind a colon in a file, {kind: ..., ...}") from error
    entry = Entry(None, called, None, path, kind) if node is None else _Composer(called, kind).entry(node, path)
    return _without_lines(entry)


def _without_lines(entry: Entry) -> Entry:
    if isinstance(entry.value, Mapping):
        return replace(entry, line=None, value={key: _without_lines(each) for key, each in entry.value.items()})
    if isinstance(entry.value, tuple):
        return replace(entry, line=None, value=tuple(map(_without_lines, entry.value)))
    return replace(entry, line=None)


def given_entries(values: Mapping[str, Any], called: str, kind: FileKind) -> Entry:
    """Entries of a call's arguments: numbers, texts, lists and mappings as they would stand in a file.

    Args:
        values: the arguments.
        called: in place of a file's name.
        kind: kind of file in which they would stand.

    Raises:
        FileEntryError: that of the kind: a value is anything else.
    """
    return _given(values, called, (), kind)


@lru_cache(maxsize=4)  # a sweep over the parameters of a table reads its file at every point, a fifth of the time to build the press
def _nodes(text: str) -> yaml.Node | None:
    return yaml.compose(text, Loader=yaml.BaseLoader)


def _syntax_error(text: str, error: yaml.MarkedYAMLError) -> tuple[int | None, str, str]:
    """Line, problem and remedy."""
    mark = error.problem_mark or error.context_mark
    line = None if mark is None else mark.line + 1
    said = " ".join(part for part in (error.context, error.problem) if part)
    written = text.splitlines()[line - 1] if line is not None and line <= len(text.splitlines()) else ""
    if "\t" in written[: len(written) - len(written.lstrip())]:
        return line, "there is a tab before the text", "indent with blanks"
    if mark is not None and "got ':'" in said and ":" in written[: mark.column]:  # the first colon of a line follows an open bracket
        return line, "there is a colon in a text", 'write the text in quotes, title: "Press 3: plant 7"'
    return line, f"it is no YAML: {said}", "see that brackets close, and that a space follows each colon"


class _Composer:
    """From YAML's nodes to entries."""

    def __init__(self, file: str, kind: FileKind) -> None:
        self.file, self.kind, self.count = file, kind, 0

    def entry(self, node: yaml.Node, path: tuple[str, ...]) -> Entry:
        line = node.start_mark.line + 1
        self.count += 1
        if self.count > MOST_ENTRIES or len(path) > DEEPEST:
            raise self.kind.error(
                self.file,
                line,
                ": ".join(path[:DEEPEST]),
                f"the {self.kind.name} is too large",
                f"write at most {MOST_ENTRIES} entries, {DEEPEST} deep",
            )
        if isinstance(node, yaml.MappingNode):
            return Entry(self._mapping(node, path), self.file, line, path, self.kind)
        if isinstance(node, yaml.SequenceNode):
            items = tuple(self.entry(each, (*path, str(k + 1))) for k, each in enumerate(node.value))
            return Entry(items, self.file, line, path, self.kind)
        empty = node.value == "" and node.style is None
        return Entry(None if empty else self._characters(node.value, line, path), self.file, line, path, self.kind)

    def _characters(self, text: str, line: int, path: tuple[str, ...]) -> str:
        """A text whose characters are whole: JSON escapes an emoji as two halves."""
        try:
            return text.encode("utf-16", "surrogatepass").decode("utf-16")
        except UnicodeDecodeError:
            place = ": ".join(path)
            raise self.kind.error(self.file, line, place, f"{shown(text)} has half a character", "write all of it") from None

    def _mapping(self, node: yaml.MappingNode, path: tuple[str, ...]) -> Mapping[str, Entry]:
        items: dict[str, Entry] = {}
        for key, value in node.value:
            line = key.start_mark.line + 1
            if not isinstance(key, yaml.ScalarNode):
                raise self.kind.error(self.file, line, ": ".join(path), "a key is no single word", "write a name before the colon")
            name = self._characters(key.value, line, path)
            entry = self.entry(value, (*path, name))
            if name in items:
                raise self.kind.error(self.file, line, ": ".join((*path, name)), f"{name} stands there twice", "remove one of them")
            items[name] = replace(entry, line=line)
        return items


def _given(value: Any, file: str, path: tuple[str, ...], kind: FileKind) -> Entry:
    if len(path) > DEEPEST:
        raise kind.error(file, None, ": ".join(path), f"the {kind.name} is too deep", "write it as in the manual")
    if isinstance(value, Mapping):
        return Entry({str(key): _given(each, file, (*path, str(key)), kind) for key, each in value.items()}, file, None, path, kind)
    if isinstance(value, str | bool) or value is None:
        return Entry(value, file, None, path, kind)
    if is_number(value):
        return Entry(number(": ".join(path), value), file, None, path, kind)
    if isinstance(value, np.ndarray) and value.ndim and type(value) is np.ndarray:
        value = value.tolist()
    if is_dataclass(value) and not isinstance(value, type):  # a part that is made already
        return Entry(value, file, None, path, kind)  # type: ignore[arg-type]
    if isinstance(value, list | tuple) and len(value) <= MOST_ENTRIES:
        return Entry(tuple(_given(each, file, (*path, str(k + 1)), kind) for k, each in enumerate(value)), file, None, path, kind)
    raise kind.error(file, None, ": ".join(path), f"{shown(value)} is a {type(value).__name__}", "give numbers, texts, lists and mappings")
