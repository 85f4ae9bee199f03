"""The sections of a job as a JSON Schema, by which editors complete keys, show their units and mark mistakes, and as tables of the manual.

Both are made from the values that read a job, so that neither says anything else. What a schema cannot know, such as names of bearings,
`pinpress check` judges.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import is_dataclass
from functools import singledispatch
from typing import Any

import numpy as np

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
from ..drives.transmission import Geared
from ..pin_table.building import KEYS, NEEDED, SENSES
from ..pin_table.links import KEYS as OF_LINKS
from ..pin_table.machine_elements import SECTIONS as MACHINE_ELEMENTS
from ..pin_table.placement import UNITS
from .grammar import SECTIONS, OfDriver, OfDrivers, Place
from .kinds import Bound, Instant

FILE = "pinpress.schema.json"
LINE = f"# yaml-language-server: $schema={FILE}\n"
_NUMBER = r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?"
Schema = dict[str, Any]

SAID: Mapping[str, Mapping[str, str]] = {  # of keys that are no fields of a class
    "motion": {
        "file": "a table with a column of time, and one for each driver",
        "period": "after which the motion repeats itself; left out: it does not",
    },
    "loads": {"file": "a table of height and force"},
    "bearings": {"viscous": "viscous torque by angular speed; in a guide viscous force by speed, such as 800 N s/m"},
    "motor": {"program": "a table of time and angle", "curve": "a table of frequency and largest torque"},
    "capacities": {
        "nominal_force": "largest process force at any height",
        "nominal_height": "height above bottom dead centre from which downwards the torque permits the nominal force",
        "torque": "at the driver, in place of the nominal height; of several drivers by their names",
        "speed_drop": "largest drop of the flywheel's speed in a stroke, by the speed; with a flywheel",
        "motor_power": "that restores the energy from stroke to stroke; left out: single strokes",
        "slide_acceleration": "largest that tool and feed allow",
        "shaking_force": "largest force on the foundation, weight excluded",
        "contact_height": "at which the tool meets the work; left out: the nominal height",
        "dwell_tolerance": "distance from bottom dead centre that counts as dwell; left out: a hundredth of the stroke",
        "at_speed": "whether torque and bearings also carry weights and inertia forces; left out: no, as catalogues have it",
    },
    "elastic": {
        "damping_ratio": "of the first mode at bottom dead centre",
        "shaft": "stiffness of the crankshaft against torsion",
        "frame": "stiffness of the columns below the crown, or their preloaded joint",
        "crown_mass": "mass of the crown on its columns; with frame",
        "modulus": "modulus of elasticity of the sections in the table of pins; left out: that of steel",
        "rods": "stiffness of a link between its two bearings, in place of its section, or rigid",
    },
    "foundation": {
        "frame": "the frame in one part, of beams, or of matrices; with crown its lower part",
        "mounts": "between floor and frame",
        "crown": "upper part of the frame",
        "uprights": "columns between bed and crown",
        "attached": "what stands on the frame, by names",
        "rotors": "what spins on the frame",
        "points": "whose vibration is shown, by names",
        "speed_range": "lowest and highest speed that is shown",
        "lift_off": "number of strokes in which feet may lift off",
    },
    "balance": {
        "regions": "where counterweights may be, by the names of their links",
        "minimise": "one criterion, or several with weights",
        "limits": "criteria, each with most",
        "dies": "masses of dies on the slide",
        "settings": "values of parameters of the table",
        "speeds": "of the driver; left out: speed",
    },
    "foundation: frame": {
        "matrices": "a file of the reduced mass and stiffness matrices",
        "interfaces": "names of the nodes where something stands",
        "bed": "name of the place on which the loads on the frame act",
        "carrier": "name of the place that carries crank and guides, and the mass of the links",
        "bearings": "name of a bearing or guide on the frame, and the place that carries it; left out: all on carrier",
        "modes": "number of vibrations with all places held that are kept",
        "loss_factor": "loss of the frame's material and joints",
        "lines": "a table of pairs of nodes, between which the frame is drawn",
    },
    "foundation: frame: beams": {"between": "pairs of places"},
    "balance: minimise": {
        "quantity": "whose range, rms or peak it is",
        "axis": "x, y, z or a direction in world axes",
        "bearing": "name of the bearing of a bearing force or moment",
        "about": "point of the plane about which the shaking moment is",
        "weight": "among several criteria to minimise; left out: 1",
        "most": "largest value, of a limit",
    },
    "foundation: points": {"on": "part of the frame", "at": "place in world axes"},
    "foundation: attached": {"mass": "of the body", "centre": "centre of mass in world axes", "inertia": "about the centre of mass"},
    "foundation: mounts": {"points": "places of mounts that are alike", "pad": "a rubber pad, in place of a stiffness"},
    "tolerances: forces": {"height": "above bottom dead centre", "force": "of the process on the slide"},
    "tolerances: speeds": {"height": "above bottom dead centre", "speed": "of the crank"},
    "tolerances": {
        "dimensions": "tolerances of dimensions by their names, or a table of them",
        "within": "of bottom dead centre: the share of presses within it is printed",
        "targets": "what the cheapest tolerances have to keep",
        "forces": "process forces at heights, for the scatter of the torque",
        "speeds": "crank speeds at heights, for the scatter of the slide's speed",
        "samples": "number of presses; left out: 100000",
        "seed": "of the random numbers; left out: 0",
        "budget": "shifts by speed, clearance, springs, heat and process",
    },
    "tolerances: targets": {"height": "of bottom dead centre", "top": "of top dead centre", "stroke": "of the stroke"},
    "tolerances: budget": {
        "speeds": "the press is set at the first",
        "warm": "temperature rise of links",
        "expansion": "of the material; left out: that of steel",
        "table": "height of the table's face in the world",
        "face": "of the slide's face below its pin",
        "process": "force at bottom dead centre",
    },
    "servo": {
        "strokes_per_minute": "how many at least",
        "time": "of a cycle, in place of it",
        "minimise": "left out: heat",
        "drive": "one motor",
        "motors": "a catalogue, in place of drive: the smallest sufficient motor is chosen",
        "ratios": "gear ratios to try",
        "gear_inertia": "of gears at the crank, with motors",
        "pause": "after each cycle, with motors",
        "path": "where the crank goes; left out: a turn or a stop, whichever is better",
        "limits": "in addition to those of the drive",
        "points": "segments of the path; left out: as many as it takes",
        "step": "of the tables for a controller",
    },
    "feed": {
        "above": "height above bottom dead centre above which the strip can be fed",
        "time": "time that the feeder needs",
        "bars": "crank angles at which something begins and ends, by its name: an ejector, a blank holder, the muting of a light curtain",
    },
    "cam_table": {
        "height": "tolerance of a table of the slide's height above bottom dead centre",
        "angle": "tolerance of a table of the crank's angle; for a driver that slides, of its position",
        "layout": "layout of the file; left out: xyva",
    },
    "mains": {
        "motors": "a catalogue of induction motors",
        "ratios": "gear ratios to try",
        "flywheels": "smallest and largest inertia on the motor's shaft",
        "speeds": "band of the crank's mean speed",
        "speed_drop": "(highest - lowest) / mean speed, at most",
        "reserve": "breakdown torque / largest torque, at least; left out: 1.25",
        "start_time": "to the rated speed with the clutch open, at most; left out: any time",
        "efficiency": "of the gear; left out: 1",
    },
    "stopping": {
        "delay": "from the signal until the brake begins to close; torque and rise are those of brake",
        "control": "response time of the control",
        "device": "response time of the protective device",
        "monitor": "how much longer a stop may last before the brake monitor reports it",
        "inertia": "of brake disc, driven plate of the clutch, and all else that stays on the crank and is not in the press's file",
        "edition": "edition with the formula for the safety distance; left out: no distance",
        "resolution": "detection capability of the curtain, at a right angle to the approach",
        "reach": "D_DS of ISO 13855:2024",
        "supplement": "Z of ISO 13855:2024",
        "two_hand": "whether the device is a two-hand control",
    },
    "fe": {
        "link": "link whose load cases are written",
        "at": "extremes, states, peak torque, peak NAME of a bearing, or angles such as 30 60 deg; left out: extremes",
        "mesh": "input file of CalculiX or Abaqus with the link's mesh in mm, in the link's axes",
        "nodes": "node of the mesh at which each force acts",
    },
    "run": {
        "duration": "of the run",
        "steady": "yes: the period that repeats itself, in place of a duration",
        "speed": "of the driver at the start; left out: speed",
        "angle": "of the driver at the start; left out: 0",
        "method": "left out: auto",
        "step": "a fixed one; left out: steps by error",
        "tolerance": "error accepted of a step",
        "points": "states returned; left out: 120 a turn",
    },
    "report": {
        "title": "heading of the page in place of the press's name",
        "company": "whose page it is",
        "drawing": "number of the drawing",
        "author": "who made the page",
        "revision": "of the page",
        "date": "as it is to be shown",
        "notes": "any text",
        "before": "a variant, or the file of a press, that is drawn dashed",
        "logo": "a PNG, JPEG or SVG file of at most 1 MB",
        "language": "of the page",
    },
}


def schema_text() -> bytes:
    """The schema of a job as a file."""
    return json.dumps(schema(), ensure_ascii=False).encode()


def schema() -> Schema:
    """The JSON Schema (draft 7) of a job."""
    sections = {name: {**_of(section.value), "description": f"{section.said} E.g. {section.example}"} for name, section in SECTIONS.items()}
    for name, words in SAID.items():
        for key, properties in sections.get(name, {}).get("properties", {}).items():
            if key in words:
                properties["description"] = words[key]
    for name in ("foundation", "loads", "bearings", "balance", "tolerances", "servo", "report"):  # a file of their own may hold them
        described = sections[name].pop("description")
        sections[name] = {"description": described, "anyOf": [sections[name], {"type": "string", "pattern": r"\.ya?ml$"}]}
    table = _of_table()
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "A pinpress job",
        "type": "object",
        "properties": table | {name: {"description": each["description"], **_or_none(each)} for name, each in sections.items()},
        "additionalProperties": False,
        "anyOf": [{"required": ["file"]}, {"required": ["base"]}, {"required": [key for key in NEEDED if key != "frame"]}],
    }


def _of_table() -> Schema:
    """The keys of a table of pins."""
    free: Schema = {key: {} for key in KEYS}
    link = {"type": "object", "properties": {key: {} for key in OF_LINKS}, "additionalProperties": False}
    named = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}
    for section, of in MACHINE_ELEMENTS.items():
        element = {"type": "object", "properties": {key: {} for key in of.keys}, "additionalProperties": False}
        free[section] = {"type": "object", "description": f"{section} by their names.".capitalize(), "additionalProperties": element}
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


@_of.register
def _(value: Place) -> Schema:
    return {"anyOf": [_of(Number("rad")), _of(Number("m"))]}


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
    return {"type": "object", "additionalProperties": _or_none(_of(value.each))}


def _or_none(schema: Schema) -> Schema:
    """The schema of an entry that may remove one of its base; in this form an editor shows what is wrong inside of the entry."""
    return {"if": {"const": "none"}, "else": schema}


@_of.register
def _(value: OfDriver) -> Schema:
    return _of(value.each)


@_of.register
def _(value: OfDrivers) -> Schema:
    one = _of(value.each)
    return {"anyOf": [one, {"type": "object", "additionalProperties": one}]}


# ------------------------------------------------------------------------------------------------------------------------------ manual


def described(made: Any) -> Mapping[str, str]:
    """What a docstring says of attributes or arguments, without the SI units, as in a file each number has its own."""
    text = getattr(made, "__doc__", None) or ""
    block = re.split(r"^ *(?:Attributes|Args):\n", text, maxsplit=1, flags=re.MULTILINE)[-1].partition("\n\n")[0]
    indent = re.match(r" *", block)
    margin = "" if indent is None else indent[0]
    rows: dict[str, str] = {}
    name = ""
    for line in block.splitlines():
        head = re.match(rf"{margin}(\w+): (.*)", line)
        if head is not None:
            name = head[1]
            rows[name] = head[2]
        elif name and line.startswith(f"{margin}    "):
            rows[name] += f" {line.strip()}"
    return {name: _of_file(words) for name, words in rows.items()}


def _of_file(words: str) -> str:
    """Words about a field as those about a key: no SI units, no scenarios, and what is not given is left out."""
    for python, file in ((r" *\[[^\]\[]*\]", ""), (r",? or \(S,\)( for S scenarios)?", ""), (r"``|`", ""), (r"\bNone: ", "left out: ")):
        words = re.sub(python, file, words)
    words = re.sub(r"^\((\w+, ?)?\d*\) *|, or None\b", "", words).strip(" .,;")
    return words.replace(". left out", ". Left out")


def manual() -> Iterator[str]:
    """The sections and their keys as Markdown, for the page on jobs."""
    listed: dict[int, str] = {}
    for name, section in SECTIONS.items():
        yield f"### `{name}`\n\n{section.said}\n\n```yaml\n{section.example}\n```\n"
        yield from _keys(_inner(section.value), name, listed)


def _inner(value: Any) -> Any:
    while isinstance(value, OfDriver | OfDrivers | Named | Listed):
        value = value.each
    return value.part if isinstance(value, Either) else getattr(value, "part", value)


def _keys(value: Any, path: str, listed: dict[int, str]) -> Iterator[str]:
    """The keys of a value at a path, and below them those of what stands at them; ``listed`` are the paths of values so far."""
    if isinstance(value, OneOf):
        kind_of_row: dict[str, str] = {}
        for kind, part in value.kinds.items():
            summary = _of_file((part.made.__doc__ or "").partition("\n")[0])
            yield f"**`kind: {kind}`** {summary}.\n"
            rows = _rows(part, path)
            yield _table(row for row in rows.values() if row not in kind_of_row)
            repeated: dict[str, list[str]] = {}
            for name, row in rows.items():
                if row in kind_of_row:
                    repeated.setdefault(kind_of_row[row], []).append(f"`{name}`")
            if repeated:
                yield "; ".join(f"{', '.join(names)} as of `{earlier}`" for earlier, names in repeated.items()) + ".\n"
            kind_of_row = {**dict.fromkeys(rows.values(), kind), **kind_of_row}
            yield from _below(part, path, listed)
    elif isinstance(value, Whichever):
        for part in value.parts.values():
            yield f"**`{part.example}`**\n"
            yield from _keys(part, path, listed)
    elif isinstance(value, Part):
        yield _table(_rows(value, path).values())
        yield from _below(value, path, listed)


def _below(part: Part[Any], path: str, listed: dict[int, str]) -> Iterator[str]:
    """The keys of the values of a part that have keys."""
    for name, each in part.values.items():
        inner = _inner(each)
        if not isinstance(inner, Part | OneOf | Whichever):
            continue
        below = f"{path}: {name}"
        before = listed.setdefault(id(inner), below)
        if before != below:
            yield f"`{below}`: as `{before}`.\n"
        else:
            yield f"`{below}`\n"
            yield from _keys(inner, below, listed)


def _table(rows: Iterable[str]) -> str:
    lines = "\n".join(rows)
    return f"| key | unit, default | |\n|---|---|---|\n{lines}\n" if lines else ""


def _rows(part: Part[Any], path: str) -> dict[str, str]:
    """The keys of a part, each as a row of a table."""
    said = {**(described(Geared) if "efficiency" in part.values else {}), **described(part.made), **SAID.get(path, {})}
    defaults = {each.name: each.default for each in in_signature(part.made)} if is_dataclass(part.made) else {}
    rows = {}
    for name, each in part.values.items():
        default = "needed" if name in part.required else _default(defaults.get(name), each)
        with_unit = isinstance(each, Number) and " " in default
        stands = default if with_unit else ", ".join(filter(None, (in_words(each), default)))
        rows[name] = f"| `{name}` | {stands} | {said.get(name, '')} |"
    return rows


def _default(default: Any, value: Value) -> str:
    """The value of a key that is left out, as it would stand there."""
    if isinstance(default, bool):
        return "yes" if default else "no"
    if not isinstance(default, float | int | tuple):
        return default if isinstance(default, str) else ""
    numbers = " ".join(f"{each:g}" for each in np.atleast_1d(default))
    unit = getattr(value, "unit", "-")
    return numbers if unit in PURE or not np.any(default) else f"{numbers} {unit}"


def in_words(value: Any) -> str:
    """What stands at a key, in words."""
    value = value.each if isinstance(value, OfDriver | OfDrivers) else value
    units = "" if not isinstance(value, Number | Numbers | Rows) else "number" if value.unit in PURE else usual_units(value.unit)[0]
    if isinstance(value, Rows):
        return f"points, {units}"
    if isinstance(value, Numbers):
        return "numbers" if value.unit in PURE else f"numbers, {units}"
    if isinstance(value, Bound):
        return "in the unit of the criterion"
    if isinstance(value, Number):
        return units
    if isinstance(value, Instant):
        return "`0.1 s` or `350 deg`"
    if isinstance(value, Text) and hasattr(value, "part"):
        return f"`{value.part.example}`"
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
        return "one of those below"
    return next((words for kind, words in names.items() if isinstance(value, kind)), "")
