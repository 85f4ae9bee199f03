"""Dimensions of a press from a table in CSV or YAML: a row for each dimension, in the terms and units of a drawing.

    dimension,       tolerance, unit, shape,   cost, smallest, largest
    length E F,      0.05,      mm,   normal,  12,   0.02,     0.2
    position A x,    0.1
    angle C D E,     0.01,      deg,  uniform

The same in YAML is a list, ``- {dimension: length E F, tolerance: 0.05, cost: 12}``. Only the first two columns are needed.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..common import files
from ..common.arguments import typed
from ..common.errors import PinpressError, shown, suggestion
from ..common.reading.columns import Wanted, read_columns
from ..common.results import Tabular
from ..common.tables import Column
from ..linkage.linkage import Linkage
from .dimensions import Dimension, check_dimensions, link_length, pin_angle, pin_position

HEADS = ("dimension", "tolerance", "unit", "shape", "sd", "name", "cost", "smallest", "largest")
LENGTHS = {"mm": 1e3, "um": 1e6, "µm": 1e6, "m": 1.0}  # units per metre: 50 / 1e6 is exactly 5e-05, 50 * 1e-6 is not
ANGLES = {"deg": 180 / math.pi, "rad": 1.0}
WORDS = "write 'length E F', 'angle C D E', 'position A x', or 'position E x rocker' for a pin that is not in the frame"
OF_TABLE = "or one word, a number of the press's pin table, such as 'r'"
OfTable = Callable[..., Dimension]
"""The dimension of a number of the press's pin table by its name, tolerance [m or rad], unit, name in results, shape and sd."""


@dataclass(frozen=True, eq=False, repr=False)
class DimensionTable(Tabular):
    """The dimensions of a table, with their costs and bounds.

    Attributes:
        parts: the dimensions, for `bottom_dead_centre`.
        costs: name of a dimension -> its cost at this tolerance, for `allocate`; without the dimensions that have no cost.
        bounds: name of a dimension -> its smallest and largest tolerance [m, of an angle rad]; without the dimensions that have no bounds.
    """

    parts: tuple[Dimension, ...]
    costs: Mapping[str, float]
    bounds: Mapping[str, tuple[float, float]]

    @property
    def title(self) -> str:
        return f"DimensionTable: {len(self.parts)} dimensions, {len(self.costs)} with a cost, {len(self.bounds)} with bounds"

    def columns(self) -> dict[str, Column]:
        """The dimensions with tolerance, unit and shape as (k,) columns."""
        return {
            "dimension": [part.name for part in self.parts],
            "tolerance": np.array([part.tolerance for part in self.parts]),
            "unit": [part.unit for part in self.parts],
            "shape": [part.shape if isinstance(part.shape, str) else "measured" for part in self.parts],
        }


@typed
def read_dimensions(press: Linkage, path: str | os.PathLike[str], of_table: OfTable | None = None) -> DimensionTable:
    """Read the dimensions of a CSV or YAML file (.yaml, .yml) with these columns or keys, of which the first two are required:

        dimension  ``length E F``: `link_length`; ``angle C D E``: `pin_angle`; ``position A x``: `pin_position` in the frame,
                   ``position E x rocker`` in another link; one word, such as ``r``: a number of the press's pin table
        tolerance  half-width +/- of the tolerance
        unit       unit of tolerance, sd, smallest and largest: mm (default of lengths), um, m; deg (default of angles), rad
        shape      normal (default), uniform or truncated
        sd         standard deviation of a normal or truncated dimension
        name       name in results, instead of the default
        cost       cost at this tolerance, for `allocate`
        smallest, largest  smallest and largest tolerance that can be made, for `allocate`

    Args:
        press: the press.
        path: of the file.
        of_table: `pin_table.dimension` with the press's draft, ``partial(pp.pin_table.dimension, drawn)``; None: the press has no table.

    Raises:
        PinpressError: the file cannot be read, does not have these columns, or a row is not a dimension of this press; the message names
            the row.
    """
    name = files.path_of("path", path)
    rows = _yaml_rows(name) if name.lower().endswith((".yaml", ".yml")) else _csv_rows(name)
    return dimensions_of(press, rows, name, of_table)


def dimensions_of(
    press: Linkage, rows: Sequence[tuple[str, Mapping[str, str]]], name: str, of_table: OfTable | None = None
) -> DimensionTable:
    """The dimensions of rows: their place, and their cells as text by the heads of `read_dimensions`; ``name``: of all, for messages.

    Raises:
        PinpressError: as `read_dimensions`.
    """
    if not rows:
        raise PinpressError(f"{name} has no dimension: {WORDS}, each with its tolerance")
    parts, costs, bounds = [], {}, {}
    for place, row in rows:
        try:
            part, per = _dimension(press, row, of_table)
            if row.get("cost"):
                costs[part.name] = _number(row, "cost")
            ends = [_number(row, end) / per for end in ("smallest", "largest") if row.get(end)]
            if len(ends) == 1:
                raise PinpressError("only one of smallest and largest is given: give both, or neither")
            if ends:
                bounds[part.name] = (ends[0], ends[1])
        except PinpressError as error:
            raise PinpressError(f"{name}, {place}: {error}") from None
        parts.append(part)
    try:
        return DimensionTable(check_dimensions(press, parts), costs, bounds)
    except PinpressError as error:
        raise PinpressError(f"{name}: {error}") from None


def _csv_rows(name: str) -> list[tuple[str, dict[str, str]]]:
    """Every row with its place, and its cells by their heads. Numbers stay text here, because another cell has their unit."""
    table = read_columns(name, {head: Wanted(needed=head in HEADS[:2]) for head in HEADS}, others=False)
    return [(f"line {line}", row) for line, row in table.rows()]


def _yaml_rows(name: str) -> list[tuple[str, dict[str, str]]]:
    """Every entry of a list in YAML, with its place and its values as text."""
    import yaml  # only tables in this format need it

    remedy = "give a list of entries, - {dimension: length E F, tolerance: 0.05}"
    try:
        listed = yaml.load(files.read(name, 1 << 20).decode("utf-8-sig"), Loader=yaml.BaseLoader)
    except (OSError, ValueError, RecursionError, yaml.YAMLError) as error:
        reason = files.reason(error) if isinstance(error, OSError) else "it is not YAML"
        raise PinpressError(f"{name} cannot be read ({reason}): {remedy}") from None
    if not isinstance(listed, list):
        raise PinpressError(f"{name} does not have a list: {remedy}")
    rows = []
    for k, entry in enumerate(listed, 1):
        if not isinstance(entry, dict) or not all(isinstance(cell, str) for cell in (*entry, *entry.values())):
            raise PinpressError(f"{name}, entry {k} is not a mapping of texts and numbers: {remedy}")
        for key in entry:
            if key not in HEADS:
                unknown = f"key {shown(key)} is unknown{suggestion(key, HEADS)}"
                raise PinpressError(f"{name}, entry {k}: {unknown}; write some of {', '.join(HEADS)}")
        for key in HEADS[:2]:
            if key not in entry:
                raise PinpressError(f"{name}, entry {k}: key {key!r} is missing: every entry needs a dimension and a tolerance")
        rows.append((f"entry {k}", {key: cell.strip() for key, cell in entry.items()}))
    return rows


def _dimension(press: Linkage, row: Mapping[str, str], of_table: OfTable | None) -> tuple[Dimension, float]:
    """The dimension of a row, and the number of its units in 1 m or 1 rad."""
    kind, *names = row["dimension"].split() or [""]
    units = ANGLES if kind == "angle" or kind.endswith(".angle") else LENGTHS
    unit = row.get("unit") or next(iter(units))
    if not names and unit in ANGLES:  # a parameter may be either
        units = ANGLES
    if unit not in units:
        what = "an angle" if units is ANGLES else "a length"
        raise PinpressError(f"unit {unit!r} is not a unit of {what}: write one of {', '.join(units)}")
    per = units[unit]
    tolerance, sd = _number(row, "tolerance") / per, _number(row, "sd") / per if row.get("sd") else None
    options: dict[str, Any] = {"name": row.get("name") or None, "shape": row.get("shape") or "normal", "sd": sd}
    if kind == "length" and len(names) == 2:
        return link_length(press, names[0], names[1], tolerance, **options), per
    if kind == "angle" and len(names) == 3:
        return pin_angle(press, names[0], names[1], names[2], tolerance, **options), per
    if kind == "position" and len(names) in (2, 3):
        return pin_position(press, names[0], names[1], tolerance, link=names[2] if len(names) == 3 else None, **options), per
    if of_table is not None and kind and not names:
        return of_table(kind, tolerance, unit="rad" if units is ANGLES else "m", **options), per
    words = WORDS if of_table is None else f"{WORDS}, {OF_TABLE}"
    raise PinpressError(f"{shown(row['dimension'])} is not a dimension: {words}")


def _number(row: Mapping[str, str], head: str) -> float:
    try:
        value = float(row.get(head, ""))
    except ValueError:
        remedy = "write a decimal point" if "," in row.get(head, "") else "write a number, with its unit in the column unit"
        raise PinpressError(f"{head} {row.get(head, '')!r} is not a number: {remedy}") from None
    if not math.isfinite(value) or value <= 0.0:
        raise PinpressError(f"{head} is {row[head]}: give a positive number")
    return value
