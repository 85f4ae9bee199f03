"""Lines of text: tables, whose first column is flush left and all others flush right, and single numbers under each other."""

from collections.abc import Iterable, Sequence
from typing import TypeVar

T = TypeVar("T")

_NAME, _NUMBER, _UNIT = 26, 12, 7  # letters of an `entry`
GAP = "..."  # stands for what is left out of a long table


def table(rows: Iterable[Sequence[str]], widths: Sequence[int], indent: str = "  ") -> list[str]:
    """Lines of a table.

    Args:
        rows: cells of each line.
        widths: letters of every column; a longer cell moves those after it. The last one counts for all columns that follow.
        indent: what each line begins with.
    """
    return [indent + "".join(_cell(k, cell, widths[min(k, len(widths) - 1)]) for k, cell in enumerate(row)) for row in rows]


def fitted(rows: Sequence[Sequence[str]], indent: str = "  ") -> list[str]:
    """Lines of a table whose columns are as wide as their longest cell, two letters apart."""
    longest = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return table(rows, [longest[0], *(2 + width for width in longest[1:])] if longest else [0], indent)


def words(rows: Sequence[Sequence[str]], indent: str = "  ") -> list[str]:
    """Lines of a table of words: all columns flush left and as wide as their longest cell, three letters apart."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [(indent + "   ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))).rstrip() for row in rows]


def entry(name: str, number: str, unit: str = "", remark: str = "") -> str:
    """A line with one number, its unit and what is said of it; those of a page stand below each other."""
    return f"  {name:{_NAME}}{number:>{_NUMBER}} {unit:{_UNIT}}{remark}".rstrip()


def shortened(items: Sequence[T], most: int) -> list[T | None]:
    """What is shown of rows or columns: all up to ``most``, else the first and last ones with None for those between."""
    half = most // 2
    return [*items] if len(items) <= most else [*items[:half], None, *items[-half:]]


def number(value: object) -> str:
    """A value as tables show it: six digits of a number, words in one line, nothing for None."""
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else " ".join(str(value).splitlines())


def _cell(place: int, cell: str, width: int) -> str:
    return cell.rjust(width) if place else cell.ljust(width)
