"""Pages of results: the numbers and figures of a document, ours beside them, and why they differ."""

import io
import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pinpress.common.errors import PinpressError
from pinpress.common.files import make_folder, write
from pinpress.common.quantities import Array
from pinpress.plots.style import COLOURS, GREY, LINES, STYLE, above, drawing, grid, plain

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

REPRODUCED = "reproduced"  # every printed number, within the tolerance beside it
FORMULAS = "formulas confirmed, no printed numbers"  # ours beside what the document's formulas give
CURVES = "no printed numbers"  # ours instead, beside independent solvers where there are any
PARTLY = "partly reproduced"  # those with a tolerance
NOT = "not reproducible"  # the reason stands beside it
DATA = "data"  # numbers that the model takes over: no result
FINDINGS = "findings only"  # words, no numbers
BEYOND = "not in the document"
NO_RESULT = "not a result"  # a photograph, a scheme, a drawing, a screenshot
KINDS = (REPRODUCED, FORMULAS, CURVES, PARTLY, NOT, DATA, FINDINGS, BEYOND, NO_RESULT)
DOTS = 110  # per inch of the pages' figures


@dataclass(frozen=True)
class Row:
    """One number of a document, and ours.

    Attributes:
        quantity: name of the quantity, with its unit.
        theirs: the number as it is printed; empty where none is.
        ours: our number or words; None where it is not defined.
        within: largest deviation [%] that counts as reproduced, 0 where theirs is zero and ours must be; None where the number is not
            claimed to be reproduced.
        places: decimals of ours; None for as many as are printed.
        source: origin of theirs where it is not the document: "formula", "independent solver".
    """

    quantity: str
    theirs: str
    ours: float | str | None
    within: float | None = None
    places: int | None = None
    source: str = ""

    def __post_init__(self) -> None:
        if self.within is not None and (
            self.number is None or not isinstance(self.ours, float) or (self.number == 0) != (self.within == 0)
        ):
            raise PinpressError(f"{self.quantity}: a tolerance needs a number on both sides; it is 0 where theirs is zero, and only there")

    @property
    def number(self) -> float | None:
        """Theirs as a number; None where it is none."""
        try:
            return float(self.theirs.replace(" ", ""))
        except ValueError:
            return None

    @property
    def deviation(self) -> float | None:
        """Deviation of ours from theirs, in percent of theirs; None where it is not defined."""
        if self.number is None or self.number == 0.0 or self.ours is None or isinstance(self.ours, str):
            return None
        return 100 * (self.ours - self.number) / abs(self.number)

    @property
    def holds(self) -> bool | None:
        """Whether the deviation is within the tolerance; None without one."""
        if self.within is None:
            return None
        return self.ours == 0.0 if self.deviation is None else abs(self.deviation) <= self.within

    def cells(self) -> tuple[str, str, str, str, str]:
        """Cells of the row in a table: quantity, theirs, ours, deviation, tolerance."""
        theirs = f"{self.theirs} ({self.source})" if self.source else self.theirs
        deviation = "" if self.deviation is None else f"{round(self.deviation, 2) + 0.0:+.2f} %".replace("+0.00", "0.00")
        return (
            self.quantity,
            theirs,
            self._ours(),
            deviation,
            "" if self.within is None else f"{self.within:g} %" if self.within else "rounding",
        )

    def _ours(self) -> str:
        if self.ours is None or isinstance(self.ours, str):
            return self.ours or ""
        places = len(self.theirs.partition(".")[2]) if self.places is None else self.places
        return f"{round(self.ours, places) + 0.0:.{places}f}"


@dataclass(frozen=True)
class Grid:
    """Results of ours in a table with columns of its own, where a number a row would be hard to read.

    Attributes:
        heads: names of the columns, with units.
        rows: their cells.
    """

    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def __post_init__(self) -> None:
        if any(len(row) != len(self.heads) for row in self.rows):
            raise PinpressError(f"a row has another number of cells than the {len(self.heads)} heads {self.heads}")


@dataclass(frozen=True)
class PageEntry:
    """One table or figure of a document, several of one kind, or a claim of its text.

    Attributes:
        numbers: numbers of the document, such as "Table 2".
        title: what they show.
        kind: one of `KINDS`.
        rows: the numbers.
        reason: why it is not reproduced, or other remarks.
        figure: name of our figure; empty where there is none.
        draw: function that draws our figure.
        caption: text below the figure.
        grids: tables of results of ours, below the numbers.
    """

    numbers: tuple[str, ...]
    title: str
    kind: str
    rows: tuple[Row, ...] = ()
    reason: str = ""
    figure: str = ""
    draw: "Callable[[], Figure] | None" = None
    caption: str = ""
    grids: tuple[Grid, ...] = ()

    @property
    def label(self) -> str:
        """Its numbers in one line."""
        return ", ".join(self.numbers)

    def markdown(self, folder: str) -> str:
        """Heading, reason, table and figure; ``folder`` is the folder of the figures."""
        parts = [f"### {self.label}: {self.title}", f"{self.kind[0].upper()}{self.kind[1:]}. {self.reason}".strip()]
        if self.rows:
            parts.append(_of_numbers([row.cells() for row in self.rows]))
        parts += [table(grid.heads, grid.rows) for grid in self.grids]
        if self.draw is not None:
            parts.append(f"![{self.label}]({folder}/{self.figure}.png)\n\n{self.caption}".strip())
        return "\n\n".join(parts)


@dataclass(frozen=True)
class Erratum:
    """A mistake of a document.

    Attributes:
        place: the equation, table or passage.
        wrong: what is printed.
        right: what is right.
    """

    place: str
    wrong: str
    right: str


@dataclass(frozen=True)
class Page:
    """All tables and figures of a document.

    Attributes:
        name: name of the page's file, without its suffix.
        title: title of the page.
        introduction: what the document is, and which presses come from it.
        entries: its tables and figures, in their order.
        errata: its mistakes.
        second: label of the entry with which a second page begins, and the title of that page; None for one page.
    """

    name: str
    title: str
    introduction: str
    entries: tuple[PageEntry, ...]
    errata: tuple[Erratum, ...]
    second: tuple[str, str] | None = None

    @property
    def rows(self) -> tuple[Row, ...]:
        """Rows of all entries."""
        return tuple(row for entry in self.entries for row in entry.rows)

    def markdown(self, folder: str = "figures") -> str:
        """All as Markdown; ``folder`` is the folder of the figures, as seen from the page."""
        return "\n".join(self.files(folder).values())

    def files(self, folder: str = "figures") -> dict[str, str]:
        """The page in Markdown, and the second one, by the names of their files; ``folder`` as of `markdown`."""
        shown = [entry for entry in self.entries if entry.kind != NO_RESULT]
        labels = [entry.label for entry in shown]
        first = len(shown) if self.second is None else labels.index(self.second[0])
        held = [row for row in self.rows if row.holds]
        printed = sum(not row.source for row in held)
        count = (
            f"{printed} printed numbers are reproduced within the tolerance beside them, and so are {len(held) - printed} numbers marked as"
            " those of a formula or of an independent solver (a program that shares no code with pinpress and was given the same data). A"
            " number without a tolerance is not claimed to be reproduced."
        )
        parts = [
            f"# {self.title}",
            self.introduction,
            count,
            "## All tables and figures",
            table(("number", "what it shows", ""), ((entry.label, entry.title, entry.kind) for entry in self.entries)),
            "## One by one",
            *(entry.markdown(folder) for entry in shown[:first]),
        ]
        files = {f"{self.name}.md": parts}
        if self.second is not None:
            title, file = self.second[1], f"{self.name}_2.md"
            parts += [f"[{title}]({file}) goes on from here."]
            parts = [f"# {title}", f"The second page of [{self.title}]({self.name}.md), which lists all tables and figures."]
            files[file] = parts
            parts += [entry.markdown(folder) for entry in shown[first:]]
        parts += [
            "## Errata of the document",
            table(("place", "what is printed", "what is right"), ((e.place, e.wrong, e.right) for e in self.errata)),
        ]
        return {name: "\n\n".join(each) + "\n" for name, each in files.items()}

    def write(self, out: str | os.PathLike[str]) -> tuple[Path, ...]:
        """Write the pages and their figures into a folder, and return the files written.

        Raises:
            PinpressError: Matplotlib is not installed, or a file cannot be written.
        """
        folder = Path(out)
        make_folder(folder / "figures")
        written = [write(folder / name, text.encode()) for name, text in self.files().items()]
        for entry in self.entries:
            if entry.draw is not None:
                written.append(write(folder / "figures" / f"{entry.figure}.png", _small(entry.draw())))
        return tuple(written)


def _small(figure: "Figure") -> bytes:
    """A figure as PNG for a screen, while `plots.save` writes for print. The same figure gives the same bytes."""
    from matplotlib import style  # optional, and slow to import

    content = io.BytesIO()
    with style.context(["default", STYLE]):
        figure.savefig(content, format="png", dpi=DOTS, metadata={"Software": None})
    return content.getvalue()


def figures(chapter: int, first: int, last: int) -> tuple[str, ...]:
    """The numbers of consecutive figures of a chapter, as a document prints them."""
    return tuple(f"Fig. {chapter}-{k}" for k in range(first, last + 1))


def _of_numbers(rows: Sequence[tuple[str, ...]]) -> str:
    """The table of an entry's numbers, without columns that are empty."""
    heads = ("", "document", "pinpress", "deviation", "tolerance")
    kept = [k for k, head in enumerate(heads) if not head or any(row[k] for row in rows)]
    return table(tuple(heads[k] for k in kept), [tuple(row[k] for k in kept) for row in rows])


def table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    """A table in Markdown."""
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    lines += [f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |" for row in rows]
    return "\n".join(lines)


@dataclass(frozen=True, eq=False)
class Panel:
    """One pair of axes.

    Attributes:
        label: label of the upright axis, with its unit.
        curves: name -> (x, y), both (n,).
        levels: values of the upright axis that the document prints.
        points: points (x, y) that the document prints.
        logarithmic: whether the upright axis is logarithmic.
    """

    label: str
    curves: dict[str, tuple[Array, Array]]
    levels: Sequence[float] = ()
    points: Sequence[tuple[float, float]] = ()
    logarithmic: bool = False


def draw(across: str, panels: Sequence[Panel], high: float = 4.2, columns: int = 1) -> "Figure":
    """Draw our curves in the axes of a document's figure, with its printed numbers as grey dashes and crosses.

    Args:
        across: label of the axis that all panels share.
        panels: the panels, row by row.
        high: height of each panel [cm].
        columns: number of panels in a row.
    """
    rows = -(-len(panels) // columns)
    with drawing(1.0 + high * rows) as figure:
        places = figure.subplots(rows, columns, sharex=True, squeeze=False)
        for k, panel in enumerate(panels):
            axes = places[k // columns, k % columns]
            grid(axes, panel.label)
            lines: list[Artist] = []
            for i, (x, y) in enumerate(panel.curves.values()):
                lines += axes.plot(x, y, color=COLOURS[i % len(COLOURS)], linestyle=LINES[i % len(LINES)])
            for level in panel.levels:
                axes.axhline(level, color=GREY, linestyle=(0, (2, 2)), linewidth=0.9)
            if panel.points:
                axes.plot(*np.transpose(panel.points), color=GREY, marker="x", markersize=5.0, linestyle="none", clip_on=False)
            if panel.logarithmic:
                axes.set_yscale("log")
            if len(lines) > 1 and (k < columns or list(panel.curves) != list(panels[k - columns].curves)):
                above(axes, lines, list(panel.curves))
            if k // columns == rows - 1:
                plain(axes.set_xlabel(across))
        figure.align_ylabels()
    return figure
