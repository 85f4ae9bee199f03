"""Results: tables that can be printed, written to files and shown in notebooks.

Every result class is a `Tabular`: it defines its `title` and its `columns`. What it shows, its numbers, charts and tables, is described
once in the module ``described`` of its room (`Tabular.described`), for report pages, `plots.draw`, texts and notebooks. A result that is
not described is printed as the ranges of its columns; one with a main curve names the columns of its small picture in `_pictured`. A
result of a single row is a `Record`, which only declares the units of its fields; several of them are `Records`.
"""

import importlib
import importlib.util
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from . import tables
from .errors import PinpressError
from .frozen import Frozen, FrozenMapping
from .tables import Column, Columns

if TYPE_CHECKING:
    from .outlets.described import Section


_PACKAGE = __name__.partition(".")[0]


class Tabular(Frozen):
    """Base of results: columns of equal length, whose names carry the units, as in "slide_velocity [m/s]"."""

    @property
    def title(self) -> str:
        """One line: the kind of result, the press, and the main numbers with their units."""
        raise NotImplementedError

    def columns(self) -> Columns:
        """All quantities as columns (n,) under their names with units."""
        raise NotImplementedError

    def described(self, page: Any = None) -> "tuple[Section, ...]":
        """What pages, plots, texts and notebooks show of the result; empty if there is nothing but its columns.

        Args:
            page: reactions of the press of the result to the motion that a page shows; None for no page.

        Raises:
            PinpressError: the result is of another press than these reactions, or a value is not finite.
        """
        for kind in type(self).__mro__:
            package, _, rest = kind.__module__.partition(".")
            name = f"{_PACKAGE}.{rest.partition('.')[0]}.described"
            if package != _PACKAGE or (name not in sys.modules and importlib.util.find_spec(name) is None):
                continue
            if describe := importlib.import_module(name).SECTIONS.get(kind):
                sections: tuple[Section, ...] = describe(self, page)
                return sections
        return ()

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write a CSV file: the names of the columns, then one line for each row, to full precision. Missing values are left empty.

        Raises:
            PinpressError: a number is not finite, or the file cannot be written.
        """
        tables.write_csv(path, self.columns())

    def to_frame(self) -> "tables.DataFrame":
        """The columns as a pandas DataFrame.

        Raises:
            PinpressError: pandas is not installed.
        """
        return tables.frame(self.columns())

    def to_mat(self, path: str | os.PathLike[str]) -> None:
        """Write a MATLAB file with one vector for each column, under its name without the unit.

        Raises:
            PinpressError: a number is not finite, or the file cannot be written.
        """
        tables.write_mat(path, self.columns())

    def to_parquet(self, path: str | os.PathLike[str]) -> None:
        """Write a Parquet file, in which missing values are null. Needs pyarrow.

        Raises:
            PinpressError: the file cannot be written, or pyarrow is not installed.
        """
        tables.write_parquet(path, self.columns())

    def __repr__(self) -> str:
        return f"<{self.title}>"

    def __str__(self) -> str:
        if sections := self._sections():
            from .outlets.text import written  # to save start-up time

            if words := written(sections):
                return f"{self.title}\n\n{words}"
        columns = self.columns()
        width = 4 + max(map(len, columns), default=0)
        ranges = [["", "smallest", "largest"], *([name, *tables.ends(column)] for name, column in columns.items())]
        return "\n".join([self.title, *tables.table(ranges, [width, 14])])

    def _sections(self) -> "tuple[Section, ...]":
        """The sections; empty if a value is not finite or bearings are left out, which the columns show."""
        try:
            return self.described()
        except PinpressError:
            return ()

    @property
    def _pictured(self) -> tuple[str, ...]:
        """Names of the columns that a notebook shows as a small picture: the abscissa, then curves in one unit. Empty for no picture."""
        return ()

    def _repr_html_(self) -> str:
        if sections := self._sections():
            from .outlets.notebook import notebook  # to save start-up time

            return notebook(self.title, sections, self.columns())
        columns, pictured = self.columns(), self._pictured
        table = tables.html(self.title, columns)
        if not pictured:
            return table
        from .outlets.sparkline import sparkline  # to save start-up time

        return f"<div>{sparkline(columns, pictured)}{table}</div>"


class Record(Tabular):
    """Base of results of one row: a dataclass of numbers and words, in which each field is a column. Fields without a value, or without
    ``repr``, are left out.

    Args:
        units: argument of the class: field -> unit, for fields that have one.
        parts: argument of the class: field -> endings of its columns' names, for fields that are vectors or complex numbers.
    """

    units: ClassVar[Mapping[str, str]]
    parts: ClassVar[Mapping[str, Sequence[str]]]

    def __init_subclass__(
        cls, units: Mapping[str, str] = FrozenMapping({}), parts: Mapping[str, Sequence[str]] = FrozenMapping({}), **others: Any
    ) -> None:
        super().__init_subclass__(**others)
        cls.units, cls.parts = units, parts

    @classmethod
    def heads(cls) -> tuple[str, ...]:
        """Names of the columns with units."""
        return tuple(head for name in _shown(cls) for head in cls._heads_of(name))

    def row(self) -> dict[str, object]:
        """Name of a column with its unit -> number or words; None if there is no value."""
        found: dict[str, object] = {}
        for name in _shown(type(self)):
            value = getattr(self, name)
            found.update(zip(self._heads_of(name), _parts(value) if name in self.parts else [_words(value)], strict=True))
        return found

    @classmethod
    def _heads_of(cls, name: str) -> list[str]:
        unit = f" [{cls.units[name]}]" if name in cls.units else ""
        return [f"{name}_{part}{unit}" for part in cls.parts[name]] if name in cls.parts else [name + unit]

    @property
    def title(self) -> str:
        """The name of the class, and all fields with their units."""
        return f"{type(self).__name__}: {', '.join(f'{name} {value} {unit}'.rstrip() for name, value, unit in self._cells())}"

    def columns(self) -> dict[str, Column]:
        """The fields as columns of one row."""
        return Records(type(self), [self]).columns()

    def __str__(self) -> str:
        lines = tables.table(([name.replace("_", " "), value, f" {unit}"] for name, value, unit in self._cells()), [26, 14, 0])
        return "\n".join([type(self).__name__, *(line.rstrip() for line in lines)])

    def _cells(self) -> list[tuple[str, str, str]]:
        """Name, value and unit of every field that has a value."""
        split = ((*head.removesuffix("]").partition(" [")[::2], value) for head, value in self.row().items())
        return [(name, tables.cell(value), "" if unit == "-" else unit) for name, unit, value in split if value is not None]


def _shown(kind: type[Record]) -> list[str]:
    """Names of the fields that are columns."""
    return [each.name for each in fields(kind) if each.repr]  # type: ignore[arg-type]  # a dataclass


def _parts(value: Any) -> list[float]:
    return [value.real, value.imag] if isinstance(value, complex) else [float(part) for part in value]


def _words(value: object) -> object:
    """A field as one cell; several words have commas between them."""
    return ", ".join(value) if isinstance(value, tuple) else value


R = TypeVar("R", bound=Record)


class Records(Tabular, tuple[R, ...]):
    """A tuple of records of one kind, as a table with one row for each.

    Attributes:
        kind: class of the records.
    """

    kind: type[R]

    def __new__(cls, kind: type[R], records: Iterable[R]) -> "Records[R]":
        made = super().__new__(cls, records)
        made.kind = kind
        return made

    def __getnewargs__(self) -> tuple[type[R], tuple[R, ...]]:  # to be copied and pickled
        return self.kind, tuple(self)

    @property
    def title(self) -> str:
        """The number of records, and their kind."""
        return f"{len(self)} x {self.kind.__name__}"

    def columns(self) -> dict[str, Column]:
        """The fields as columns (n,) under their names with units. Fields that have no value in any record are left out."""
        rows = [record.row() for record in self]
        if not rows:
            return {head: [] for head in self.kind.heads()}
        columns = {head: [row[head] for row in rows] for head in rows[0]}
        return {head: values for head, values in columns.items() if any(value is not None for value in values)}

    def __repr__(self) -> str:
        return tuple.__repr__(self)

    def __str__(self) -> str:
        columns = self.columns()
        rows = zip(*columns.values(), strict=True)
        return "\n".join([self.title, *tables.fitted([list(columns), *([tables.cell(value) for value in row] for row in rows)])])
