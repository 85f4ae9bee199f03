"""Cams of a pin table: the roller, and the law of the lift over a turn or a table of lifts."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace

from ..common.errors import suggestion
from ..common.motion_laws import SINE, VDI_LAWS
from .formulas import Numbers
from .reading import Entry

LAW = "law: [[0, 0], [200, 0], {modified sine: [290, 40]}, [300, 40], {3-4-5: [350, 0]}]"
ROWS = "lifts: [[0, 0], [10, 0.4], ...], with slopes and second derivatives behind the lifts if they are known"
Point = tuple[str, Mapping[str, float | str]]
"""A child of a ``<cam>``: its tag, and its attributes."""


def roller(entry: Entry, numbers: Numbers) -> dict[str, float | str]:
    """Radius and width of a roller, of which the table gives diameter x width."""
    parts = (
        entry.value if isinstance(entry.value, tuple) else [replace(entry, value=part) for part in re.split("[x×]", entry.text("40 x 30"))]
    )
    if len(parts) != 2:
        entry.refuse(f"{len(parts)} lengths", "write diameter x width of the roller: roller: 40 x 30")
    diameter, width = (numbers.above_zero(part, "a length of the roller") * numbers.unit for part in parts)
    return {"roller_radius": diameter / 2, "roller_width": width}


def points(items: Mapping[str, Entry], guided: bool, numbers: Numbers) -> Iterator[Point]:
    """The points of a law, or the rows of a table of lifts.

    Args:
        items: key -> entry of a cam.
        guided: whether the follower is in a guide: lifts are lengths, else angles in degrees.
        numbers: reads the table's numbers.
    """
    unit = numbers.unit if guided else 1.0
    for each in items["law"].list(LAW) if "law" in items else ():
        named = each.value if isinstance(each.value, Mapping) else {"": each}
        if len(named) != 1:
            each.refuse(f"a piece with {len(named)} laws", f"write one of them, as in {LAW}")
        ((law, point),) = named.items()
        if law and law not in (known := (*VDI_LAWS, SINE)):
            each.refuse(f"no motion law {law!r}{suggestion(law, known)}", f"write one of {', '.join(known)}")
        angle, lift = _numbers(point, numbers, (2,), LAW)
        yield "point", {"angle": angle, "lift": unit * lift} | ({"law": law} if law else {})
    for each in items["lifts"].list(ROWS) if "lifts" in items else ():
        angle, *lifts = _numbers(each, numbers, (2, 4), ROWS)
        yield "row", {"angle": angle} | dict(zip(("lift", "slope", "bend"), (unit * lift for lift in lifts), strict=False))


def _numbers(entry: Entry, numbers: Numbers, counts: tuple[int, ...], example: str) -> list[float]:
    parts = entry.list(example)
    if len(parts) not in counts:
        entry.refuse(f"{len(parts)} numbers", f"write angle and lift, as in {example}")
    return [numbers.number(part) for part in parts]
