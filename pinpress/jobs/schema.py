"""The sections of a job as a JSON Schema, by which editors complete keys, show their units and mark mistakes, and as tables of the manual.

Both are made from the values that read a job, so that neither says anything else. What a schema cannot know, such as names of bearings,
`pinpress check` judges.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, is_dataclass
from functools import singledispatch
from typing import Any

from ..common.parameters import in_signature
from ..common.quantities import RAM, readable
from ..common.reading.filling import (
    PURE,
    DataColumns,
    DataFile,
    Either,
    Listed,
    Named,
    Names,
    Number,
    Numbers,
    OneOf,
    Part,
    Rows,
    Text,
    Truth,
    Value,
    Whichever,
    Whole,
    usual_units,
)
from ..pin_table.building import KEYS, NEEDED, SENSES
from ..pin_table.links import KEYS as OF_LINKS
from ..pin_table.placement import UNITS
from .grammar import SECTIONS, OfDriver, OfDrivers
from .kinds import Bound, Instant

FILE = "pinpress.schema.json"
LINE = f"# yaml-language-server: $schema={FILE}\n"
_NUMBER = r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?"
Schema = dict[str, Any]


def schema_text() -> bytes:
    """The schema of a job as a file."""
    return json.dumps(schema(), ensure_ascii=False).encode()


def schema() -> Schema:
    """The JSON Schema (draft 7) of a job."""
    sections = {name: {**_of(section.value), "description": f"{section.said} E.g. {section.example}"} for name, section in SECTIONS.items()}
    for name in ("foundation", "loads", "bearings", "balance", "tolerances", "servo", "report"):  # a file of their own may hold them
        described = sections[name].pop("description")
        sections[name] = {"description": described, "anyOf": [sections[name], {"type": "string", "pattern": r"\.ya?ml$"}]}
    table = _of_table()
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "A pinpress job",
        "type": "object",
        "properties": table | sections,
        "additionalProperties": False,
        "anyOf": [{"required": ["file"]}, {"required": ["base"]}, {"required": list(NEEDED)}],
    }


def _of_table() -> Schema:
    """The keys of a table of pins."""
    free: Schema = {key: {} for key in KEYS}
    link = {"type": "object", "properties": {key: {} for key in OF_LINKS}, "additionalProperties": False}
    named = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}
    return free | {
        "press": {"type": ["string", "number"], "description": "Name of the press."},
        "units": {
            "enum": list(UNITS),
            "description": "Unit of every length of the table. Masses are in kg, angles in degrees, inertias in kg m2.",
        },
        "parameters": {
            "type": "object",
            "description": "Numbers by names, for formulas, sliders and --set.",
            "additionalProperties": {"type": ["number", "string"]},
        },
        "frame": {**named, "description": "Pins that are fixed in the frame, with blanks between them."},
        "pins": {"type": "object", "description": "Places of the pins: [x, z], or lengths and angles from other pins."},
        "links": {
            "type": "object",
            "description": "Links by their pins, with mass, or a section of which it follows.",
            "additionalProperties": link,
        },
        "drive": {**named, "description": "The pin or guide that is driven."},
        "turns": {"enum": list(SENSES), "description": "Which way a positive angle turns in the picture."},
        "base": {"type": "string", "description": "Another table or shipped press over which this one is laid."},
        "note": {"description": "A remark."},
    }


@singledispatch
def _of(value: Value) -> Schema:
    """The schema of a value."""
    raise TypeError(f"{value} has no schema")


@_of.register
def _(value: Number) -> Schema:
    return _number(value.unit, f"a number with a unit, such as 1.5 {usual_units(value.unit)[0]}")


def _number(unit: str, said: str) -> Schema:
    if unit in PURE:
        return {
            "anyOf": [{"type": "number"}, {"type": "string", "pattern": rf"^{_NUMBER}\s*%$|^[-+]?inf$"}],
            "description": "a number, or per cent",
        }
    return {
        "anyOf": [{"const": 0}, {"type": "string", "pattern": f"^({_NUMBER}|inf)\\s*({_units(unit)})$|^0$"}],
        "description": said,
    }


def _units(unit: str) -> str:
    """The names of a unit as a pattern, those along the axis of a driver that slides too; blanks between their parts may be left out."""
    units = [unit, RAM.in_place_of(unit)]
    names = dict.fromkeys(name for each in units for name in readable(re.sub(r"\^e", "^1.5", each)))
    parts = ("[ .*·]*".join(map(re.escape, name.split())) for name in sorted(names, key=len, reverse=True))
    return "|".join(parts) if "^" not in unit else r".*"


@_of.register
def _(value: Numbers) -> Schema:
    return _several(value.unit)


@_of.register
def _(value: Rows) -> Schema:
    one = _several(value.unit)
    return {"anyOf": [one, {"type": "array", "items": one}], "description": one["description"]}


def _several(unit: str) -> Schema:
    tail = "" if unit in PURE else f"\\s*({_units(unit)})"
    example = "1 0 0" if unit in PURE else f"0 100 -350 {usual_units(unit)[0]}"
    pattern = f"^({_NUMBER}|[-+]?inf)(\\s+({_NUMBER}|[-+]?inf))*{tail}$"
    entry = {"type": ["number", "string", "array"]}
    return {
        "anyOf": [{"type": "string", "pattern": pattern}, {"type": "number"}, {"type": "array", "items": entry}],
        "description": f"numbers, such as {example}",
    }


@_of.register
def _(value: Text) -> Schema:
    part = getattr(value, "part", None)
    if part is not None:
        return {"anyOf": [{"type": ["string", "number"]}, _of(part), {"type": "array"}]}
    if type(value) is not Text:
        return {"type": ["string", "number", "array"]}
    return {"enum": list(value.choices)} if value.choices else {"type": ["string", "number"]}


@_of.register
def _(value: Instant) -> Schema:
    return {"type": "string", "pattern": f"^{_NUMBER}\\s*({_units('s')}|{_units('rad')})$", "description": "0.1 s, or 350 deg of the crank"}


@_of.register
def _(value: Names) -> Schema:
    return {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}


@_of.register
def _(value: Whole) -> Schema:
    return {"type": "integer"}


@_of.register
def _(value: Truth) -> Schema:
    return {"enum": [True, False, "yes", "no"]}


@_of.register
def _(value: Bound) -> Schema:
    return {"type": ["string", "number"], "description": "in the unit of the criterion"}


@_of.register(DataFile)
@_of.register(DataColumns)
def _(value: Value) -> Schema:
    return {"type": ["string", "object"], "description": "a file, by its path from the file in which it stands"}


@_of.register
def _(value: Part) -> Schema:  # type: ignore[type-arg]
    return _of_part(value)


def _of_part(part: Part[Any], kind: str | None = None) -> Schema:
    said = described(part.made)
    properties: Schema = {}
    for name, value in part.values.items():
        properties[name] = _of(value)
        if name in said:
            properties[name] = {**properties[name], "description": said[name]}
    required = list(part.required)
    if kind is not None:
        properties, required = {"kind": {"const": kind}, **properties}, ["kind", *required]
    return {
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": False,
        "description": f"e.g. {part.example}",
    }


@_of.register
def _(value: OneOf) -> Schema:
    kinds = [_of_part(part, name) for name, part in value.kinds.items()]
    return {
        "type": "object",
        "properties": {"kind": {"enum": list(value.kinds)}},
        "required": ["kind"],
        "allOf": [
            {
                "if": {"properties": {"kind": {"const": name}}},
                "then": {key: each[key] for key in ("properties", "required", "additionalProperties")},
            }
            for name, each in zip(value.kinds, kinds, strict=True)
        ],
    }


@_of.register
def _(value: Whichever) -> Schema:
    return {"anyOf": [_of(part) for part in value.parts.values()]}


@_of.register
def _(value: Either) -> Schema:
    return {"anyOf": [_of(value.alone), _of(value.part)]}


@_of.register
def _(value: Listed) -> Schema:
    return {"anyOf": [{"type": "array", "items": _of(value.each)}, _of(value.each)]}


@_of.register
def _(value: Named) -> Schema:
    return {"type": "object", "additionalProperties": _of(value.each)}


@_of.register
def _(value: OfDriver) -> Schema:
    return _of(value.each)


@_of.register
def _(value: OfDrivers) -> Schema:
    one = _of(value.each)
    return {"anyOf": [one, {"type": "object", "additionalProperties": one}]}


# ------------------------------------------------------------------------------------------------------------------------------ manual


def described(made: Any) -> Mapping[str, str]:
    """What the docstring of a dataclass says of its attributes."""
    text = getattr(made, "__doc__", None) or ""
    block = text.partition("Attributes:\n")[2].partition("\n\n")[0]
    found: dict[str, str] = {}
    name = ""
    for line in block.splitlines():
        head = re.match(r" {8}(\w+): (.*)", line)
        if head is not None:
            name = head[1]
            found[name] = head[2]
        elif name and line.startswith(" " * 12):
            found[name] += f" {line.strip()}"
    return found


def manual() -> Iterator[str]:
    """The sections and their keys as Markdown, for the page on jobs."""
    for name, section in SECTIONS.items():
        yield f"### `{name}`\n\n{section.said}\n\n```yaml\n{section.example}\n```\n"
        yield from _keys(_inner(section.value))


def _inner(value: Any) -> Any:
    while isinstance(value, OfDriver | OfDrivers | Named | Listed):
        value = value.each
    return value.part if isinstance(value, Either) else value


def _keys(value: Any) -> Iterator[str]:
    if isinstance(value, OneOf):
        for kind, part in value.kinds.items():
            summary = (part.made.__doc__ or "").partition("\n")[0]
            yield f"**`{kind}`**: {summary}\n"
            yield from _keys(part)
    elif isinstance(value, Part):
        said, defaults = described(value.made), {}
        if is_dataclass(value.made):
            defaults = {each.name: each.default for each in in_signature(value.made) if each.default is not MISSING}
        rows = [
            f"| `{name}` | {in_words(each)} | {_default(name, value, defaults)} | {said.get(name, '')} |"
            for name, each in value.values.items()
        ]
        if rows:
            yield "| key | value | default | |\n|---|---|---|---|\n" + "\n".join(rows) + "\n"


def _default(name: str, part: Part[Any], defaults: Mapping[str, Any]) -> str:
    if name in part.required:
        return "needed"
    value = defaults.get(name)
    if value is None:
        return ""
    return (
        ("yes" if value else "no")
        if isinstance(value, bool)
        else f"{value:g}"
        if isinstance(value, float | int)
        else f"{value}".strip("()")
    )


def in_words(value: Any) -> str:
    """What stands at a key, in words."""
    value = value.each if isinstance(value, OfDriver | OfDrivers) else value
    units = "" if not isinstance(value, Number | Numbers | Rows) else "number" if value.unit in PURE else usual_units(value.unit)[0]
    if isinstance(value, Rows):
        return f"points, {units}"
    if isinstance(value, Numbers):
        return f"numbers, {units}"
    if isinstance(value, Number):
        return units
    if isinstance(value, Text) and type(value) is Text and value.choices:
        return ", ".join(value.choices)
    names = {Whole: "whole number", Truth: "yes or no", DataFile: "file", DataColumns: "CSV file", Names: "names", Text: "text"}
    if isinstance(value, Part):
        return f"`{value.example}`"
    if isinstance(value, Either):
        return f"{in_words(value.alone)}, or {in_words(value.part)}"
    if isinstance(value, Listed):
        return f"list of {in_words(value.each)}"
    if isinstance(value, Named):
        return f"`{value.example}`"
    if isinstance(value, OneOf):
        return f"kind: {', '.join(value.kinds)}"
    if isinstance(value, Whichever):
        return " or ".join(in_words(part) for part in value.parts.values())
    return next((words for kind, words in names.items() if isinstance(value, kind)), "")
