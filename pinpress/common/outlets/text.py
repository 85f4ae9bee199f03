"""Sections of results as text: numbers with units and places, and tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from .. import tables
from ..quantities import quantity
from .described import Column, Figure, Section, Table

DIGITS = 5  # of numbers in texts; pictures have three
NAME, NUMBER, UNIT = 26, 12, 7  # least widths of the columns of figures


def written(sections: Sequence[Section], digits: int = DIGITS) -> str:
    """Sections as text: figures line by line, tables, and remarks; charts are left out."""
    parts = [part for section in sections if (part := _section(section, digits))]
    return "\n\n".join("\n".join(part) for part in parts)


def _section(section: Section, digits: int) -> list[str]:
    body = entries(section.figures, digits)
    body += [f"  {section.note}"] if section.note else []
    for table in section.blocks:
        if isinstance(table, Table):
            title = table.title.removeprefix(section.title).strip()
            body += [*([""] if body else []), *([f"  {table.title}"] if title else []), *(lines(table, digits) if table.columns else [])]
    return [section.title, *body] if body else []


def entries(figures: Sequence[Figure], digits: int = DIGITS) -> list[str]:
    """Lines with a figure each: name, number, unit and place in columns."""
    rows = [(figure.name, *value(figure, digits), remark(figure, digits)) for figure in figures]
    wide = max([NAME, *(len(name) + 1 for name, *_ in rows)])
    found = []
    for name, number, unit, words in rows:
        name, number, words = tables.without_minus([name, number, words])
        if not unit and isinstance(number, str) and len(number) > NUMBER:  # words in place of a number
            found.append(f"  {name:{wide}}{number}  {words}".rstrip())
        else:
            found.append(f"  {name:{wide}}{number:>{NUMBER}} {unit:{UNIT}}{words}".rstrip())
    return found


def value(figure: Figure, digits: int) -> tuple[str, str]:
    """Number and unit of a figure, or its words; with a limit both numbers are in one unit."""
    if isinstance(figure.value, str):
        return figure.value, ""
    known = [figure.value] if figure.limit is None else [figure.value, figure.limit]
    scale = quantity(figure.quantity).scale(known, digits=digits)
    return scale.shown(figure.value), scale.unit


def remark(figure: Figure, digits: int) -> str:
    """The words after a number: its limit and its place."""
    if figure.limit is None or isinstance(figure.value, str):
        return figure.where
    scale = quantity(figure.quantity).scale([figure.value, figure.limit], digits=digits)
    bound = "at least " if figure.least else ""
    limit = f"of {bound}{scale.shown(figure.limit)} {scale.unit}".rstrip()
    return ", ".join(filter(None, (limit, figure.where)))


def lines(table: Table, digits: int = DIGITS) -> list[str]:
    """Lines of a table, words flush left and numbers flush right, and its remark."""
    heads, rows = cells(table, digits)
    words = [all(cell is None or isinstance(cell, str) for cell in column.cells) for column in table.columns]
    shown = tables.shortened(rows, table.most)
    found = tables.fitted(([heads] if any(heads) else []) + [row for row in shown if row is not None], words)
    if None in shown:
        found.insert(len(found) - table.most // 2, f"  {tables.GAP}")
    return [*found, *([f"  {table.note}"] if table.note else [])]


def cells(table: Table, digits: int = DIGITS) -> tuple[list[str], list[list[str]]]:
    """Heads with units and rows of cells as text: one unit and one number of decimals for each column, or for each row."""
    columns = [_column(column, digits) for column in (_with_units_of_rows(table, digits) if table.quantities else table.columns)]
    return [head for head, _ in columns], [list(row) for row in zip(*(column for _, column in columns), strict=True)]


def _with_units_of_rows(table: Table, digits: int) -> list[Column]:
    """The columns of a table whose rows have quantities, with numbers as text. Rows of one name have one unit and number of decimals."""
    first, *others = table.columns
    numbers: dict[object, list[float]] = {name: [] for name in first.cells}
    for column in others:
        if column.quantity is None:
            for name, cell in zip(first.cells, column.cells, strict=True):
                numbers[name] += [float(cell)] if isinstance(cell, int | float) else []
    scales = [quantity(row).scale(numbers[name], digits=digits) for name, row in zip(first.cells, table.quantities, strict=True)]
    names = [f"{name} [{scale.unit}]" if scale.unit else name for name, scale in zip(first.cells, scales, strict=True)]
    shown = [replace(first, cells=names)]
    for column in others:
        if column.quantity is None:
            pairs = zip(column.cells, scales, strict=True)
            column = replace(column, cells=[scale.shown(float(cell)) if isinstance(cell, int | float) else cell for cell, scale in pairs])
        shown.append(column)
    return shown


def _column(column: Column, digits: int) -> tuple[str, list[str]]:
    if column.quantity is None:
        return column.name, [tables.cell(cell) for cell in column.cells]
    numbers = [float(cell) for cell in column.cells if isinstance(cell, int | float)]
    scale = quantity(column.quantity).scale([*numbers, *column.beside], column.reference, digits)
    shown = [scale.shown(float(cell)) if isinstance(cell, int | float) else tables.cell(cell) for cell in column.cells]
    return f"{column.name} [{scale.unit}]".lstrip() if scale.unit else column.name, shown
