"""Read a pin table from YAML or from the arguments of a call, and lay it over another table. Entries know their line."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..common.errors import PinTableError
from ..common.files import path_of
from ..common.reading.entries import Entry as Entry
from ..common.reading.entries import FileKind, given_entries, read_entries
from ..linkage.loading import shipped_table
from .templates import TEMPLATES

CALL = "build(...)"  # stands for the file's name if a call gives the table or values
SYNONYMS = {  # key -> other words that people write for it, in lower case
    "length": "radius l len",
    "mass": "weight m",
    "com": "cog centre center",
    "inertia": "j i",
    "density": "material rho",
    "guide": "slot cylinder",
    "drive": "driver",
    "press": "name",
    "units": "unit",
}
USUAL_WORDS = {word: key for key, words in SYNONYMS.items() for word in words.split()}
PIN_TABLE = FileKind(
    "pin table", PinTableError, "units, frame, pins, links and drive", USUAL_WORDS, {"pins": "separate names by blanks, as in pins: A B"}
)

BESIDE = {  # sections of a job that may stand in a table -> levels at which they are laid over those of a base
    **dict.fromkeys(("loads", "bearings"), 2),
    **dict.fromkeys(("slide", "gravity", "zero", "speed", "points"), 0),
    **dict.fromkeys(("motion", "motor", "flywheel", "clutch", "brake", "capacities", "stopping", "fe", "cam_table", "feed"), 1),
    **dict.fromkeys(("elastic", "foundation", "balance", "tolerances", "servo", "mains", "run", "traces", "report", "variants"), 1),
}
LEVELS = {  # the same of the sections of a table
    **dict.fromkeys(("parameters", "pins", "gears"), 1),
    **dict.fromkeys(("links", "meshes", "racks", "screws", "worms", "cams"), 2),
    **BESIDE,
}


def read_table(path: str | os.PathLike[str]) -> Entry:
    """Read the table of a YAML file or of a shipped press, and lay it over the table that it names as its ``base``.

    Raises:
        PinTableError: the file cannot be read, is not YAML, or has a key twice (with the line); or only a template has this name.
    """
    given = path_of("path", path)
    shipped = None if os.path.exists(given) else shipped_table(given)
    if shipped is None and given.lower().endswith((".urdf", ".sdf", ".xml", ".mjcf")):
        raise PinTableError(given, None, "", "this is not a pin table", "pp.load(path) and pinpress check read URDF, SDF and MJCF files")
    if shipped is None and not os.path.exists(given) and (name := Path(given).stem) in TEMPLATES:
        remedy = f"make one of the template of this name: pinpress new {name}.yaml --template {name}, then give {name}.yaml"
        raise PinTableError(given, None, "", "no such file", remedy)
    return _with_bases(Path(given) if shipped is None else shipped, ())


def given_table(values: Mapping[str, Any]) -> Entry:
    """Make a table of a call's arguments: numbers, texts, lists and mappings as in a file."""
    return given_entries(values, CALL, PIN_TABLE)


def overlaid(below: Entry, above: Entry, depth: int = 0) -> Entry:
    """Lay a table over another: pins, parameters, gears, keys of links and of machine elements replace those below; ``none`` removes."""
    merged_levels = LEVELS.get(above.path[0] if above.path else "", 0)
    if not (isinstance(below.value, Mapping) and isinstance(above.value, Mapping)) or depth > merged_levels:
        return above  # deeper entries are replaced as a whole
    merged = dict(below.value)
    for key, entry in above.value.items():
        if entry.value == "none" and (depth or key != "masses"):
            merged.pop(key, None)
        else:
            merged[key] = overlaid(merged[key], entry, depth + 1) if key in merged else entry
    return replace(above, value=merged)


def _with_bases(path: Path, above: tuple[Path, ...]) -> Entry:
    table = read_entries(path, PIN_TABLE)
    if not (isinstance(table.value, Mapping) and "base" in table.value):
        return table
    base = table.value["base"]
    if path.resolve() in above or len(above) == 20:
        base.refuse("the tables name each other as base", "name a base that does not lead back to this table")
    named = base.text("the file of another table, or the name of a shipped press")
    file = path.parent / named
    shipped = None if os.path.exists(file) else shipped_table(named)
    below = _with_bases(shipped or file, (*above, path.resolve()))
    return overlaid(below, replace(table, value={key: entry for key, entry in table.value.items() if key != "base"}))
