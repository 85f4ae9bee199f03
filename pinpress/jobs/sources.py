"""Where the entries of a job come from: a file over its base, files that sections name, a variant, and changes on top of all.

The later one wins: base, file, variant, changes of a command line, arguments of a call.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn, TypeAlias

from ..common.errors import PinpressError, shown, suggestion
from ..common.files import path_of
from ..common.reading.entries import Entry, entry_of_text, given_entries, read_entries
from ..common.reading.filling import Around, Named
from ..linkage.loading import presses, shipped_table
from ..pin_table.building import KEYS as OF_TABLE
from ..pin_table.building import DrawnPress, drawn_from
from ..pin_table.reading import PIN_TABLE, read_table
from ..pin_table.templates import TEMPLATES
from .grammar import JOB, SECTIONS

CALL = "job(...)"  # in place of a file's name where a call gives an entry
TABLES = (".yaml", ".yml")
Refuse: TypeAlias = Callable[[str, str], NoReturn]  # takes the problem and the remedy
NEEDED = ("pins", "links")  # keys that only a table of pins has


@dataclass(frozen=True)
class Change:
    """An entry that a variant, a command line or a call has changed.

    Attributes:
        path: names that lead to it, with points between them.
        before: what stood there; empty: nothing.
        now: what stands there; empty: it was removed.
    """

    path: str
    before: str
    now: str


@dataclass(frozen=True)
class Source:
    """The entries of a job.

    Attributes:
        file: as it was given; of a call alone "job(...)".
        items: the entries by their keys, those of the table among them.
        below: the entries before all changes.
        changes: what was changed on top of the file.
        files: the files in YAML that were read, its bases among them.
        variant: name of the variant; empty: none.
    """

    file: str
    items: Mapping[str, Entry]
    below: Mapping[str, Entry]
    changes: tuple[Change, ...]
    files: tuple[Path, ...]
    variant: str = ""

    @property
    def table(self) -> Entry | None:
        """The table of pins; None if the press comes from another file."""
        own = {key: _of_table(each) for key, each in self.items.items() if key in OF_TABLE}
        return None if "file" in self.items else Entry(own, self.file, None, (), PIN_TABLE)

    def drawn(self) -> DrawnPress | None:
        """The press as its table draws it, with the parameters that were changed; None if the press comes from another file."""
        given = {each.path.partition(".")[2]: each.now for each in self.changes if each.path.startswith("parameters.")}
        drawn = None if self.table is None else drawn_from(self.table)
        return drawn and replace(drawn, _given=tuple(f"{name}={value}" for name, value in given.items()))

    @property
    def model(self) -> str | Path:
        """The file of a press that is no table: its path, or the name of a shipped press."""
        named = self.items["file"].text("a file")
        path = self.items["file"].folder / named
        return named if named in presses() and not path.exists() else path

    def press_sections(self) -> dict[str, Any]:
        """What stands in the sections that make the press."""
        return {name: SECTIONS[name].value.read(self.items[name], Around()) for name in OF_PRESS if name in self.items}


OF_PRESS = ("file", "drivers", "slide", "floating", "pose", "gravity", "zero")  # sections that make the press


def source(file: str | os.PathLike[str] | None, variant: str | None, words: Sequence[str], changes: Mapping[str, Any]) -> Source:
    """Gather the entries of a job.

    Args:
        file: a job or table in YAML, a URDF, SDF or MJCF file, or the name of a shipped press; None: the changes are all there is.
        variant: name of one of its variants.
        words: changes as texts, "loads.draw.force=1200 kN".
        changes: changes by their paths, as numbers in SI units, texts, mappings or parts.

    Raises:
        FileEntryError: a file cannot be read, or a key is not known; with file and line.
        PinpressError: there is no such variant, or a change changes nothing.
    """
    top = _top(file)
    items = dict(top.items("keys with values"))
    for key, each in items.items():
        if key not in SECTIONS and key not in OF_TABLE:
            top.refuse_key(key, each, (*SECTIONS, *OF_TABLE))
        if key in SECTIONS and key != "file" and isinstance(each.value, str) and each.value.lower().endswith(TABLES):
            items[key] = replace(read_entries(each.folder / each.value, JOB), path=(key,), line=1)
    found = Source(str(top.file), items, items, (), tuple(_files(Entry(items, "", None, (), JOB))))
    return changed(found if variant is None else of_variant(found, variant), words, changes)


def _files(entry: Entry) -> dict[Path, None]:
    """The files in which an entry and all below it stand, each once."""
    below = entry.value.values() if isinstance(entry.value, Mapping) else entry.value if isinstance(entry.value, tuple) else ()
    own: dict[Path, None] = {} if entry.line is None else {Path(entry.file): None}
    return own | {path: None for each in below if isinstance(each, Entry) for path in _files(each)}


def of_variant(found: Source, variant: str) -> Source:
    """The entries of a file with one of its variants, and without any other change; raises PinpressError if it has none of this name."""
    below = found.below
    named = below["variants"].items("variants: {long_stroke: {r: 150}}") if "variants" in below else {}
    if not isinstance(variant, str):
        raise PinpressError(f"variant is {shown(variant)}: give the name of one of the job's variants")
    if variant not in named:
        there = f"there are {', '.join(named)}" if named else "the job has no variants"
        raise PinpressError(f"{found.file}: variants: no variant {variant!r}{suggestion(variant, named)}; {there}")
    items = dict(below)
    done = [_change(items, path, value, value.refuse) for path, value in named[variant].items("{r: 150}").items()]
    return replace(found, items=items, changes=tuple(done), variant=variant)


def changed(found: Source, words: Sequence[str], changes: Mapping[str, Any]) -> Source:
    """The entries with changes on top, see `source`."""
    items, done = dict(found.items), list(found.changes)
    if not (isinstance(words, list | tuple) and all(isinstance(text, str) for text in words)):
        raise PinpressError(f'set is {shown(words)}: give a list of texts, set=["r=150", "speed=60 r/min"]')
    for text in words:
        path, equals, value = text.partition("=")
        if not (path.strip() and equals and value.strip()):
            raise PinpressError(f"--set {text}: write a name and its value, such as --set loads.draw.force=1200kN or --set r=150")
        entry = entry_of_text(value.strip(), f"--set {text}", tuple(path.strip().split(".")), JOB)
        done.append(_change(items, path.strip(), entry, replace(entry, path=()).refuse))
    for path, value in changes.items():
        entry = given_entries({path: value}, CALL, JOB).items("values")[path]
        done.append(_change(items, path, entry, replace(entry, path=(path,)).refuse))
    return replace(found, items=items, changes=tuple(done))


def with_loads(found: Source, specs: Sequence[str]) -> Source:
    """The entries with one more load for each text such as ``drawing:force=1500kN,start=40mm``, named as its kind."""
    items, done = dict(found.items), list(found.changes)
    for words in specs:
        kind, _, rest = words.partition(":")
        pairs = [part.partition("=") for part in rest.split(",")] if rest else []
        if any(not equals for _, equals, _ in pairs):
            raise PinpressError(f"--load {words}: write key=value behind the kind, such as --load drawing:force=1500kN,start=40mm")
        loads = items["loads"].items("loads") if "loads" in items else {}
        name = next(each for each in itertools.chain([kind], (f"{kind}_{k}" for k in itertools.count(2))) if each not in loads)
        value = {"kind": kind, **{key.strip(): text.strip() for key, _, text in pairs}}
        called = f"--load {words}"
        entry = given_entries({"loads": {name: value}}, called, JOB).items("loads")["loads"]
        items["loads"] = replace(items["loads"], value={**loads, **entry.items("loads")}) if loads else entry
        done.append(Change(f"loads.{name}", "", _written(entry.items("loads")[name])))
    return replace(found, items=items, changes=tuple(done))


def _top(file: str | os.PathLike[str] | None) -> Entry:
    """The entries of a file, or one that names it."""
    if file is None:
        return given_entries({}, CALL, JOB)
    path = path_of("file", file)
    if path.lower().endswith(TABLES) or (path in TEMPLATES and not os.path.exists(path)):  # reading says how to make a template
        return replace(_as_job(read_table(path)), line=1)
    return Entry({"file": Entry(path, path, None, ("file",), JOB)}, path, None, (), JOB)


def _as_job(entry: Entry) -> Entry:
    return _of_kind(entry, JOB)


def _of_table(entry: Entry) -> Entry:
    return _of_kind(entry, PIN_TABLE)


def _of_kind(entry: Entry, kind: Any) -> Entry:
    """An entry and all below it as those of another kind of file."""
    if isinstance(entry.value, Mapping):
        return replace(entry, kind=kind, value={key: _of_kind(each, kind) for key, each in entry.value.items()})
    if isinstance(entry.value, tuple):
        return replace(entry, kind=kind, value=tuple(_of_kind(each, kind) for each in entry.value))
    return replace(entry, kind=kind)


# ------------------------------------------------------------------------------------------------------------------------------ changes


def _change(items: dict[str, Entry], path: str, value: Entry, refuse: Refuse) -> Change:
    """Change the entry of a path in place; ``refuse`` names where the change stands."""
    key = _longest(items, path)
    if key is None and (parameter := _parameter(items, path)) is not None:
        key, path = "parameters", f"parameters.{parameter}"
    if key is None:
        key = _begun(items, path, refuse)
    before = items.get(key)
    rest = path[len(key) + 1 :]
    after = _removed(value) if not rest else _below(before, rest, value, key, refuse)
    if not rest and before is None and after is None:
        refuse(f"there is no {key} to remove", "leave it out")
    old = before if not rest else _at(before, rest)
    if after is None:
        del items[key]
    else:
        items[key] = after
    return Change(path, _written(old), "" if _removed(value) is None else _written(value))


def _parameter(items: dict[str, Entry], path: str) -> str | None:
    """The parameter of a table that a path names; a shipped press becomes its table."""
    if path in SECTIONS or "." in path:
        return None
    if "parameters" not in items and "file" in items and items["file"].value in presses():
        name = items["file"].text("a file")
        if not os.path.exists(name) and shipped_table(name) is not None:
            table = dict(_as_job(read_table(name)).items("a table"))
            if path in (table["parameters"].items("names with numbers") if "parameters" in table else {}):
                del items["file"]
                items.update(table)
    known = items["parameters"].items("names with numbers") if "parameters" in items else {}
    return path if path in known else None


def _begun(items: dict[str, Entry], path: str, refuse: Refuse) -> str:
    """The section that a path begins, or that it makes as a whole."""
    key, point, rest = path.partition(".")
    if key not in SECTIONS:
        parameters = list(items["parameters"].items("names with numbers")) if "parameters" in items else []
        known = [*parameters, *items, *SECTIONS]
        of_table = f" or one of the parameters {', '.join(parameters)}" if parameters else ", such as loads.draw.force"
        what = f"name a section{of_table}"
        refuse(f"there is no {path!r}{suggestion(path, known)}", what)
    if point and not SECTIONS[key].by_keys:
        refuse(f"there is no {key} whose {rest} could change", f"write all of it, such as {SECTIONS[key].example}")
    return key


def _below(entry: Entry | None, path: str, value: Entry, section: str, refuse: Refuse, depth: int = 1) -> Entry:
    """An entry in which that of a path is changed."""
    if entry is None:
        return Entry({path: value}, value.file, None, (section,), JOB)
    if not isinstance(entry.value, Mapping):
        refuse(f"{section} is {_written(entry)}, which has no {path}", f"write all of it, such as {SECTIONS[section].example}")
    items = dict(entry.value)
    key = _longest(items, path)
    if key is not None and key != path:
        return replace(entry, value={**items, key: _below(items[key], path[len(key) + 1 :], value, section, refuse, depth + 1)})
    named = section in SECTIONS and isinstance(SECTIONS[section].value, Named) and depth == 1
    if key is None and (named or "." in path or _removed(value) is None):
        name, point, rest = path.partition(".")
        if section == "bearings" and point:  # of the press, which knows their names
            return replace(entry, value={**items, name: Entry({rest: value}, value.file, None, (section, name), JOB)})
        if not (named and not point and isinstance(value.value, Mapping)):
            known = [key for key in items if key != "all"] or list(items)
            refuse(f"{section} has no {name}{suggestion(name, items)}", f"name one of {', '.join(known)}")
    if _removed(value) is None:
        items.pop(path)
    else:
        items[path] = value
    return replace(entry, value=items)


def _longest(items: Mapping[str, Entry], path: str) -> str | None:
    """The longest key with which a path begins: names may have points in them."""
    return max((key for key in items if path == key or path.startswith(f"{key}.")), key=len, default=None)


def _removed(value: Entry) -> Entry | None:
    return None if value.value is None or value.value == "none" else value


def _at(entry: Entry | None, path: str) -> Entry | None:
    while entry is not None and path and isinstance(entry.value, Mapping):
        key = _longest(entry.value, path)
        entry, path = (None, "") if key is None else (entry.value[key], path[len(key) + 1 :])
    return entry


def _written(entry: Entry | None) -> str:
    """An entry as it stands in a file, in braces."""
    if entry is None or entry.value is None:
        return ""
    if isinstance(entry.value, Mapping):
        return "{" + ", ".join(f"{key}: {_written(each)}" for key, each in entry.value.items()) + "}"
    if isinstance(entry.value, tuple):
        return "[" + ", ".join(_written(each) for each in entry.value) + "]"
    return f"{entry.value:g}" if isinstance(entry.value, float) else str(entry.value)
