"""The table of extremes of a page."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ...common.quantities import quantity
from ...dynamics.extremes import ExtremeValues, extremes
from .drawn import table
from .shown import Shown

HEIGHT = "slide height"
DIGITS = {"deg": 1, "mm": 1, "s": 4}  # digits after the decimal point, by unit
SI = ("N", "N m")  # all values of a kind share the prefix of these units


def _extremes(shown: Shown) -> list[ExtremeValues]:
    """The extremes, with the slide's height above bottom dead centre in place of its position."""
    values = []
    for value in extremes(shown.reactions):
        if value.quantity == "slide position" and shown.bottom is not None:
            height = 1e3 * (shown.motion.slide_position - shown.bottom)
            smallest, largest = (1e3 * (1e-3 * each - shown.bottom) for each in (value.smallest, value.largest))
            rms = float(np.sqrt(np.mean(height**2)))
            value = replace(value, quantity=HEIGHT, smallest=smallest, largest=largest, rms=rms)
        values.append(value)
    return values


def table_of_extremes(shown: Shown, before: Shown | None) -> dict[str, Any]:
    """Extremes over all states, with one unit for each kind, and the ranges of the press before."""
    values = _extremes(shown)
    known = {} if before is None else {value.quantity: value for value in _extremes(before)}
    at = f"at [{values[0].units['smallest_at']}]"
    heads = ["", "smallest", at, "largest", at, "range", *([] if before is None else ["before", "change"]), "rms"]
    largest: dict[str, float] = {}
    for value in values:
        largest[_kind(value)] = max(largest.get(_kind(value), 0.0), abs(value.smallest), abs(value.largest))
    rows = []
    for value in values:
        unit, factor = value.unit, 1.0
        if unit in SI:
            prefixed = quantity(unit).scale([largest[_kind(value)]])
            unit, factor = prefixed.unit, prefixed.factor
        others = [] if before is None or value.quantity not in known else [known[value.quantity].range]
        own = [factor * each for each in (value.smallest, value.largest, value.range, value.rms, *others)]
        scale = quantity("-").scale(own, digits=5)
        numbers = [scale.shown(each) for each in own]
        beside = [] if before is None else [*numbers[4:], _change(value, *others)] if others else ["", ""]
        digits = DIGITS[value.units["smallest_at"]]
        places = (f"{value.smallest_at:.{digits}f}", f"{value.largest_at:.{digits}f}")
        rows.append([f"{value.quantity} [{unit}]", numbers[0], places[0], numbers[1], places[1], numbers[2], *beside, numbers[3]])
    return {"title": "Extremes", "note": "", "blocks": [table("", heads, rows)]}


def _kind(value: ExtremeValues) -> str:
    """The kind of values that share a unit: forces in all bearings, components of one vector, torques of all drivers."""
    name = value.quantity.rpartition(", ")[0] or value.quantity.partition(" of ")[0]
    return name.partition(" in ")[0] + value.unit


def _change(value: ExtremeValues, before: float) -> str:
    """Change of a range, as text."""
    return f"{100 * (value.range / before - 1):+.2f} %" if before else ""
