"""Rows of evidence: a number that a document prints, ours next to it, and the tables of a page that are made of them."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

from support.markdown import table

from pinpress.common.errors import PinpressError

FORMULA, SOLVER = "formula", "solver"  # sources of numbers that the document does not print itself
REPRODUCED, PARTLY, NOT = "reproduced", "partly reproduced", "not reproducible"
CONFIRMED, UNPRINTED = "formulas confirmed, no printed numbers", "no printed numbers"
DATA, FINDINGS, BEYOND = "data", "findings only", "not in the document"
HEADS = ("document", "formula or solver", "pinpress", "deviation", "tolerance")  # of the columns behind the quantity
VERDICTS = (REPRODUCED, PARTLY, NOT, CONFIRMED, UNPRINTED, DATA, FINDINGS, BEYOND)
BLOCK = re.compile(r"(<!-- rows: [^\n]* -->\n).*(<!-- end of rows -->)", re.DOTALL)  # what `fill` replaces in a page


@dataclass(frozen=True)
class Row:
    """One number of a document, and ours.

    Attributes:
        quantity: name of the quantity, with its unit.
        printed: the number as its source has it; empty if there is none.
        ours: function that computes our number, or words.
        within: largest deviation [%] that counts as reproduced; 0 where the source has zero and ours must be zero; None if nothing is
            claimed.
        source: empty for the document itself, else `FORMULA` (of the document, evaluated here) or `SOLVER` (a program that shares no code
            with pinpress and was given the same data).
        places: decimals of our number; None for as many as are printed.
    """

    quantity: str
    printed: str
    ours: Callable[[], float | str]
    within: float | None = None
    source: str = ""
    places: int | None = None

    def __post_init__(self) -> None:
        if self.within is not None and (self.number is None or (self.number == 0) != (self.within == 0)):
            raise PinpressError(f"{self.quantity}: a tolerance needs a printed number; it is 0 where that number is zero, and only there")

    @cached_property
    def value(self) -> float | str:
        """Our number, computed once."""
        value = self.ours()
        if self.within is not None and isinstance(value, str):
            raise PinpressError(f"{self.quantity}: a tolerance needs a number of ours, not {value!r}")
        return value if isinstance(value, str) else float(value)

    @property
    def number(self) -> float | None:
        """The printed number; None if it is no number."""
        try:
            return float(self.printed.replace(" ", ""))
        except ValueError:
            return None

    @property
    def deviation(self) -> float | None:
        """Deviation of our number from the printed one, in percent of the printed one; None if it is not defined."""
        if not self.number or isinstance(self.value, str):
            return None
        return 100 * (self.value - self.number) / abs(self.number)

    @property
    def holds(self) -> bool | None:
        """Whether the deviation is within the tolerance; None without a tolerance."""
        if self.within is None:
            return None
        return self.value == 0.0 if self.deviation is None else abs(self.deviation) <= self.within

    def cells(self) -> tuple[str, ...]:
        """Quantity, number of the document, number of a formula or solver, ours, deviation, tolerance."""
        document, reference = ("", f"{self.printed} ({self.source})") if self.source else (self.printed, "")
        places = len(self.printed.partition(".")[2]) if self.places is None else self.places
        ours = self.value if isinstance(self.value, str) else f"{round(self.value, places) + 0.0:.{places}f}"
        deviation = "" if self.deviation is None else f"{round(self.deviation, 2) + 0.0:+.2f} %".replace("+0.00", "0.00")
        tolerance = "" if self.within is None else f"{self.within:g} %" if self.within else "rounding"
        return self.quantity, document, reference, ours, deviation, tolerance


@dataclass(frozen=True)
class Table:
    """Results of ours with columns of their own, where a number a row would be hard to read."""

    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def __post_init__(self) -> None:
        if any(len(row) != len(self.heads) for row in self.rows):
            raise PinpressError(f"a row has another number of cells than the {len(self.heads)} heads {self.heads}")


@dataclass(frozen=True)
class Part:
    """One table or figure of a document, several of a kind, or a question that the document leaves open.

    Attributes:
        title: its number in the document and what it shows.
        verdict: one of `VERDICTS`.
        rows: its numbers.
        note: what a reader needs next to the rows: assumptions, signs.
        tables: functions that compute further tables.
    """

    title: str
    verdict: str
    rows: Sequence[Row] = ()
    note: str = ""
    tables: Sequence[Callable[[], Table]] = ()

    def markdown(self) -> str:
        """Heading, verdict, note and tables."""
        blocks = [f"### {self.title}", f"{self.verdict[0].upper()}{self.verdict[1:]}. {self.note}".strip()]
        if self.rows:
            blocks.append(table_of([row.cells() for row in self.rows], ("", *HEADS)))
        computed = [compute() for compute in self.tables]
        return "\n\n".join(blocks + [table(each.heads, each.rows) for each in computed])


def unclaimed(names: Iterable[str], places: int) -> Iterator[tuple[Any, ...]]:
    """Rows of results that no document prints, as `rows_from` takes them."""
    return ((name, "", None, "", places) for name in names)


def rows_from(compute: Callable[[], Sequence[float | str]], *rows: tuple[Any, ...]) -> Iterator[Row]:
    """Rows whose numbers are computed together, in the order of the rows: (quantity, printed, within, source, places) each, the last
    three as `Row` has them."""
    values = cache(compute)
    for place, (quantity, printed, *rest) in enumerate(rows):
        yield Row(quantity, printed, lambda place=place: values()[place], *rest)


def rows_of(parts: Iterable[Part]) -> list[Row]:
    """All rows of the parts."""
    return [row for part in parts for row in part.rows]


def table_of(cells: Sequence[Sequence[str]], heads: Sequence[str]) -> str:
    """A table of rows in Markdown, without the columns that are empty."""
    kept = [k for k, head in enumerate(heads) if not head or any(row[k] for row in cells)]
    return table([heads[k] for k in kept], [[row[k] for k in kept] for row in cells])


def counted(parts: Sequence[Part]) -> str:
    """How many numbers agree within their tolerances, as a sentence."""
    agreeing = [row for row in rows_of(parts) if row.holds]
    printed = sum(not row.source for row in agreeing)
    return (
        f"{printed} printed numbers agree within the tolerance next to them, and so do {len(agreeing) - printed} numbers of formulas and of"
        " solvers that share no code with pinpress. Rows without a tolerance claim nothing."
    )


def fill(page: str, parts: Sequence[Part], main: Mapping[str, Sequence[str]]) -> str:
    """The text of a page with its main table between its marks.

    Args:
        page: text of the page.
        parts: all parts of the document.
        main: quantities of the table by the number of their part; an empty sequence takes all rows of the part.
    """
    by_number = {part.title.partition(": ")[0]: part.rows for part in parts}
    chosen = []
    for number, names in main.items():
        if missing := [name for name in names if [row.quantity for row in by_number[number]].count(name) != 1]:
            raise PinpressError(f"{number} must have each of these quantities once: {', '.join(missing)}")
        chosen += [(number, row) for row in by_number[number] if not names or row.quantity in names]
    main_table = table_of([(number, *row.cells()) for number, row in chosen], ("place", "", *HEADS))
    text, replaced = BLOCK.subn(lambda marks: f"{marks[1]}\n{counted(parts)}\n\n{main_table}\n\n{marks[2]}", page)
    if replaced != 1:
        raise PinpressError("the page needs a line <!-- rows: ... --> and behind it a line <!-- end of rows -->, once")
    return text


def complete(name: str, parts: Sequence[Part], no_results: str) -> str:
    """The text of the file that has all rows of a document."""
    head = (
        f"# All rows of {name}\n\nWritten by `python tests/validation/validate.py {name} --write`. Causes, errata and the main rows are in"
        f" [docs/{name}.md](../../docs/{name}.md).\n\nWithout results: {no_results}."
    )
    return "\n\n".join([head, counted(parts), *(part.markdown() for part in parts)]) + "\n"
