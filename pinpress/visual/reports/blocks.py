"""What a report shows, apart from how a page draws it: sections of charts, tables and figures.

Whatever has a report makes `Section`s of its results. ``as_json`` of a block is what `templates/report.js` draws.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np

from ...common.quantities import Array
from ..pages import packed

SAME = 4e-3  # share of a chart's range: curves that nowhere differ by more lie on each other, to the width of a line

Follows = Literal["frames", "position", "height", "time", "nothing"]
"""What of the recording a chart's cursor follows: its key frames, the driver's position within the period [deg or mm], the slide's height
[mm], the time [s], or nothing."""


class Block(Protocol):
    """What can stand in a section."""

    def as_json(self) -> dict[str, Any]:
        """The block as a page is given it; raises `PinpressError` where a number is not finite."""
        ...


@dataclass(frozen=True, eq=False)
class Section:
    """A part of a report under its own title.

    Attributes:
        title: Title of the section.
        blocks: What stands in it, from top to bottom.
        inputs: What it was computed from beside the press: names and words, which stand at the top of the page.
        note: A remark under the title; empty for none.
    """

    title: str
    blocks: Sequence[Block]
    inputs: Sequence[tuple[str, str]] = ()
    note: str = ""

    def as_json(self) -> dict[str, Any]:
        """The section as a page is given it."""
        return {"title": self.title, "note": self.note, "blocks": [block.as_json() for block in self.blocks]}


@dataclass(frozen=True, eq=False)
class Line:
    """A curve of a `LineChart`.

    Attributes:
        name: Name of the curve.
        y: (m,) values in the chart's unit.
        x: (m,) values along the chart; None: those of the key frames.
        before: (b,) values of the press before, over its own abscissa, drawn dashed; None for none.
        at_frames: (k, 2) x and y at the key frames, for a curve that is no function of x; None: the value is read off the curve.
        points: Whether it is drawn as points without a line.
        marked: Whether it is drawn with a dot at each of its points.
        strong: Whether it is drawn wide, below the others.
        pale: Whether it is drawn thin and grey, as a help for the eye.
        limit: Whether it is a limit of others, drawn with dashes.
        band: (m, 2) ends of a band around it; None for none.
    """

    name: str
    y: Array
    x: Array | None = None
    before: Array | None = None
    at_frames: Array | None = None
    points: bool = False
    marked: bool = False
    strong: bool = False
    pale: bool = False
    limit: bool = False
    band: Array | None = None


@dataclass(frozen=True, eq=False)
class LineChart:
    """Curves of one unit.

    Attributes:
        title: Title of the chart.
        unit: Unit of all curves; empty for none.
        lines: Its curves.
        across: Quantity along the chart with its unit, "speed [r/min]"; empty: that of the key frames.
        follows: What its cursor follows.
        reach: Ends of what is shown along the chart; None: all.
        logarithmic: Axes with a logarithmic scale, "", "y" or "xy".
        stacked: Whether curves stand on each other as areas.
        square: Whether both axes have one scale, as in a picture of a place.
        note: A remark under the chart; empty for none.
        marks: Straight lines across it: name, axis "x" or "y", and one value or two in the units of the axes.
    """

    title: str
    unit: str
    lines: Sequence[Line]
    across: str = ""
    follows: Follows = "frames"
    reach: tuple[float, float] | None = None
    logarithmic: Literal["", "y", "xy"] = ""
    stacked: bool = False
    square: bool = False
    note: str = ""
    marks: Sequence[tuple[str, str, Sequence[float]]] = ()

    def as_json(self) -> dict[str, Any]:
        """The chart as a page is given it, with curves that lie on an earlier one marked."""
        under = {} if self.stacked else covered(self.lines)
        above: dict[int, list[str]] = {}
        for upper, lower in under.items():
            above.setdefault(lower, []).append(self.lines[upper].name)
        words = []
        for lower, names in above.items():
            lie, are = ("lies", "is") if len(names) == 1 else ("lie", "are")
            words.append(f"{', '.join(names)} {lie} on {self.lines[lower].name} and {are} dotted")
        return {
            "kind": "lines",
            "title": self.title,
            "unit": self.unit,
            "across": self.across,
            "follows": self.follows,
            "reach": None if self.reach is None else list(self.reach),
            "logarithmic": self.logarithmic,
            "stacked": self.stacked,
            "square": self.square,
            "note": "; ".join([*([self.note] if self.note else []), *words]),
            "marks": [{"name": name, "axis": axis, "at": list(at)} for name, axis, at in self.marks],
            "curves": [self._curve(k, line, k in under, k in under.values()) for k, line in enumerate(self.lines)],
        }

    def _curve(self, k: int, line: Line, dotted: bool, wide: bool) -> dict[str, Any]:
        what = f"{self.title}, {line.name}"
        looks = {"dotted": dotted, "strong": line.strong, "pale": line.pale, "limit": line.limit, "marked": line.marked, "wide": wide}
        optional = {"x": line.x, "before": line.before, "at_frames": line.at_frames}
        return {
            "name": line.name,
            "y": packed(line.y, what),
            **{name: None if values is None else packed(values, what) for name, values in optional.items()},
            "points": line.points,
            "band": None if line.band is None else [packed(end, what) for end in line.band.T],
            "look": next((word for word, so in looks.items() if so), ""),
        }


def covered(lines: Sequence[Line]) -> dict[int, int]:
    """Places of curves that lie on an earlier one, and the place of the first one there; curves of zeros count too."""
    width = float(np.ptp(np.concatenate([line.y for line in lines])))
    found: dict[int, int] = {}
    for k, upper in enumerate(lines):
        for i, lower in enumerate(lines[:k]):
            if i not in found and len(upper.y) and _along_the_same(upper, lower) and np.abs(upper.y - lower.y).max() <= SAME * width:
                found[k] = i
                break
    return found


def _along_the_same(one: Line, other: Line) -> bool:
    if len(one.y) != len(other.y) or one.points or other.points:
        return False
    return (one.x is None and other.x is None) or (one.x is not None and other.x is not None and np.array_equal(one.x, other.x))


@dataclass(frozen=True, eq=False)
class BarChart:
    """Bars side by side.

    Attributes:
        title: Title of the chart.
        unit: Unit of all bars.
        places: What stands under each place: numbers, or words.
        bars: Name of a series -> a value at each place.
        before: The same of the press before, drawn pale; None for none.
        across: What the places are; empty for words that speak for themselves.
        note: A remark under the chart; empty for none.
        stacked: Whether the bars of a place stand on each other.
        band: (n, 2) ends of the sum of each place; None for none.
    """

    title: str
    unit: str
    places: Sequence[float] | Sequence[str]
    bars: Mapping[str, Sequence[float]]
    before: Mapping[str, Sequence[float]] | None = None
    across: str = ""
    note: str = ""
    stacked: bool = False
    band: Array | None = None

    def as_json(self) -> dict[str, Any]:
        """The chart as a page is given it."""
        return {
            "kind": "bars",
            "stacked": self.stacked,
            "band": None if self.band is None else self.band.tolist(),
            "title": self.title,
            "unit": self.unit,
            "places": list(self.places),
            "bars": {name: list(map(float, values)) for name, values in self.bars.items()},
            "before": None if self.before is None else {name: list(map(float, values)) for name, values in self.before.items()},
            "across": self.across,
            "note": self.note,
        }


@dataclass(frozen=True, eq=False)
class ColourMap:
    """Values over two quantities as colours.

    Attributes:
        title: Title of the chart.
        unit: Unit of the values.
        across: Quantity along the horizontal axis with its unit.
        up: Quantity along the vertical axis with its unit.
        x: (m,) places along the horizontal axis.
        y: (n,) places along the vertical axis.
        values: (n, m), NaN for a gap.
        written: Whether each value is written in its place.
        note: A remark under the chart; empty for none.
    """

    title: str
    unit: str
    across: str
    up: str
    x: Sequence[float] | Sequence[str]
    y: Sequence[float] | Sequence[str]
    values: Array
    written: bool = False
    note: str = ""

    def as_json(self) -> dict[str, Any]:
        """The map as a page is given it."""
        values = [[None if np.isnan(value) else float(value) for value in row] for row in self.values]
        words = {"title": self.title, "unit": self.unit, "across": self.across, "up": self.up, "note": self.note}
        return {"kind": "map", **words, "x": list(self.x), "y": list(self.y), "values": values, "written": self.written}


@dataclass(frozen=True, eq=False)
class Table:
    """A table of words and numbers as they are to be read.

    Attributes:
        title: Title of the table; empty where the section's says it.
        heads: Heads of the columns.
        rows: Cells of each row.
        words: Number of columns of words at the left, which are flush left; the others are flush right.
        note: A remark under the table; empty for none.
    """

    title: str
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    words: int = 1
    note: str = ""

    def as_json(self) -> dict[str, Any]:
        """The table as a page is given it."""
        cells = [list(row) for row in self.rows]
        return {"kind": "table", "title": self.title, "heads": list(self.heads), "rows": cells, "words": self.words, "note": self.note}


@dataclass(frozen=True)
class Figure:
    """A number that is looked for first.

    Attributes:
        name: What it is.
        value: The number with its unit.
        remark: Where or of what it is; may be empty.
    """

    name: str
    value: str
    remark: str = ""

    def as_json(self) -> dict[str, str]:
        """The figure as a page is given it."""
        return {"name": self.name, "value": self.value, "at": self.remark}


@dataclass(frozen=True, eq=False)
class Figures:
    """Numbers that are looked for first, side by side.

    Attributes:
        figures: The numbers.
    """

    figures: Sequence[Figure]

    def as_json(self) -> dict[str, Any]:
        """The numbers as a page is given them."""
        return {"kind": "figures", "figures": [figure.as_json() for figure in self.figures]}
