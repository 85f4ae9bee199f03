"""What a result shows, described once for pages, plots, texts and notebooks.

Numbers are in SI units, arrays have the shape (n,), and NaN is a gap. Nothing is scaled or rounded here: the outlets choose units and
digits by the table of `quantities`. A ``quantity`` is a key of that table, an SI unit ("N m") or a name ("frequency"). The ``name`` of a
chart, curve or column is short and public: equal names in two results are the same thing, so that two results can be drawn over each other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np

from ..quantities import Array

Look = Literal["line", "marked", "strong", "points", "limit", "guide"]
"""How a curve is drawn: thin, thin with a dot at each of its points, wide below the others, as points alone, as a limit of other curves, or
pale as a help for the eye."""


@dataclass(frozen=True, eq=False)
class Along:
    """What a chart runs along.

    Attributes:
        name: what it is, as in "crank angle".
        quantity: of its values.
        values: (n,) at the states of curves that have no ``x`` of their own.
        of: the motion whose states these are; None for none. A page that shows this motion moves a cursor along the chart.
        marks: names of places -> place, as "BDC".
        shaded: ends of a part that is shaded, as the working stroke.
        period: length after which the curves repeat themselves, with the sign of the way; they are closed by their first state. None for no
            period.
    """

    name: str
    quantity: str
    values: Array | None = None
    of: object = None
    marks: Mapping[str, float] = field(default_factory=dict)
    shaded: tuple[float, float] | None = None
    period: float | None = None


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve of a `Chart`.

    Attributes:
        name: its name.
        y: (n,) values.
        x: (n,) places; None for the values of the chart's `Along`.
        band: (n, 2) ends of a band around it; None for none.
        look: how it is drawn.
    """

    name: str
    y: Array
    x: Array | None = None
    band: Array | None = None
    look: Look = "line"


@dataclass(frozen=True)
class Mark:
    """A straight line across a chart, or the room between two of them.

    Attributes:
        name: its name; may be empty.
        at: value, or two values.
        axis: on which they are, "x" or "y".
    """

    name: str
    at: float | tuple[float, float]
    axis: Literal["x", "y"] = "y"


@dataclass(frozen=True, eq=False)
class Chart:
    """Curves of one quantity.

    Attributes:
        name: its name.
        title: its title.
        quantity: of all curves.
        along: what it runs along.
        curves: its curves.
        marks: lines across it.
        reach: ends of what is shown along it; None for the ends of the curves.
        stacked: whether the curves stand on each other.
        square: whether both axes have one scale.
        logarithmic: axes with a logarithmic scale, "", "y" or "xy".
        reference: largest value of this kind; 1e-6 of it is nothing.
        note: a remark; empty for none.
        detail: whether it is of one part among many; drawn if asked for by name.
    """

    name: str
    title: str
    quantity: str
    along: Along
    curves: Sequence[Curve]
    marks: Sequence[Mark] = ()
    reach: tuple[float | None, float | None] = (None, None)
    stacked: bool = False
    square: bool = False
    logarithmic: Literal["", "y", "xy"] = ""
    reference: float = 0.0
    note: str = ""
    detail: bool = False


@dataclass(frozen=True, eq=False)
class Bars:
    """Bars side by side, or on each other.

    Attributes:
        name: its name.
        title: its title.
        quantity: of all bars.
        places: numbers or words under the bars.
        series: name -> (n,) values.
        across: what the places are; empty for words that speak for themselves.
        stacked: whether the bars of a place stand on each other; negative ones go down.
        band: (n, 2) ends of the sum of each place; None for none.
        note: a remark; empty for none.
    """

    name: str
    title: str
    quantity: str
    places: Sequence[float] | Sequence[str]
    series: Mapping[str, Array]
    across: str = ""
    stacked: bool = False
    band: Array | None = None
    note: str = ""


@dataclass(frozen=True, eq=False)
class Polar:
    """The path of the tip of a vector in a plane.

    Attributes:
        name: "polar" and the name of the bearing.
        title: name of the bearing.
        link: link on which the force acts.
        axes: names of the two axes.
        quantity: of the components.
        world: (n, 2) components in world axes.
        own: (n, 2) components in axes that are fixed to the link and are those of the world in the drawn pose.
        of: the motion whose states these are.
        closed: whether the path is that of a period, which ends where it begins.
        note: a remark; empty for none.
    """

    name: str
    title: str
    link: str
    axes: tuple[str, str]
    quantity: str
    world: Array
    own: Array
    of: object
    closed: bool = False
    note: str = ""


@dataclass(frozen=True, eq=False)
class Map:
    """Values over two quantities as colours.

    Attributes:
        name: its name.
        title: its title.
        quantity: of the values.
        across: along the horizontal axis; its values are (m,) or, with rays, (n, m).
        up: along the vertical axis; its values are (n,) or (n, m).
        values: (n, m).
        written: whether each value is written in its place.
        decades: how many decades of size the colours show; 0 for a linear scale.
        marks: lines across it.
        curves: points over the colours; their ``x`` and ``y`` are those of across and up.
        note: a remark; empty for none.
        detail: whether it is of one part among many; drawn if asked for by name.
    """

    name: str
    title: str
    quantity: str
    across: Along
    up: Along
    values: Array
    written: bool = False
    decades: float = 0.0
    marks: Sequence[Mark] = ()
    curves: Sequence[Curve] = ()
    note: str = ""
    detail: bool = False


@dataclass(frozen=True, eq=False)
class Column:
    """A column of a `Table`.

    Attributes:
        name: its head, without a unit.
        cells: words, or numbers; None for an empty cell.
        quantity: of the numbers; None for words and plain numbers.
        reference: largest value of this kind; 1e-6 of it is nothing.
        curves: (n,) values of a small picture in each row; None for none.
        beside: numbers of all columns that are written in one unit with these, as parts and their sum.
    """

    name: str
    cells: Sequence[object]
    quantity: str | None = None
    reference: float = 0.0
    curves: Sequence[Array] | None = None
    beside: Sequence[float] = ()


@dataclass(frozen=True, eq=False)
class Table:
    """A table.

    Attributes:
        name: its name.
        title: its title; empty if the section says it.
        columns: its columns.
        note: a remark; empty for none.
        most: rows that are shown; of more the first and the last ones.
        quantities: quantity of each row; the numbers of columns that have no quantity are then in one unit for all rows of one name, which
            stands behind this name, the first cell. Empty if numbers without a quantity are plain.
    """

    name: str
    title: str
    columns: Sequence[Column]
    note: str = ""
    most: int = 24
    quantities: Sequence[str] = ()


@dataclass(frozen=True)
class Figure:
    """A number that is looked for first, or words in its place.

    Attributes:
        name: what it is.
        value: the number, or words.
        quantity: of the number.
        where: where or of what it is; may be empty.
        limit: what it may be; None for no limit.
        least: whether the limit is the smallest allowed value, not the largest.
        kind: "force", "torque", "energy", "motor", "bearing", "floor" or "accuracy" of what a reader looks for first; empty for all else.
    """

    name: str
    value: float | str
    quantity: str = "-"
    where: str = ""
    limit: float | None = None
    least: bool = False
    kind: str = ""

    @property
    def use(self) -> float | None:
        """Share of the limit that is used up; None without a limit."""
        if self.limit is None or isinstance(self.value, str):
            return None
        above, below = (self.limit, self.value) if self.least else (self.value, self.limit)
        return above / below if below else np.inf


Block: TypeAlias = Chart | Bars | Polar | Map | Table


@dataclass(frozen=True, eq=False)
class Section:
    """A part of what a result shows, under its own title.

    Attributes:
        title: its title.
        figures: numbers that are looked for first.
        blocks: charts and tables from top to bottom.
        inputs: names and words of what it was computed from, next to the press.
        note: a remark; empty for none.
        press: the press that the result is of; None for none. A page of another press refuses the result.
        of: what the result is of, for the message of that refusal: "rating".
    """

    title: str
    figures: Sequence[Figure] = ()
    blocks: Sequence[Block] = ()
    inputs: Sequence[tuple[str, str]] = ()
    note: str = ""
    press: object = None
    of: str = "result"


def charts_of(sections: Sequence[Section]) -> dict[str, Chart | Bars | Polar | Map]:
    """All charts of sections by their names, in their order."""
    return {block.name: block for section in sections for block in section.blocks if not isinstance(block, Table)}
