"""Cells of CSV files, as spreadsheets and programs of all countries save them."""

from __future__ import annotations

import csv
import os
import re
from typing import NamedTuple

from .. import files
from ..arguments import unit_factor
from ..quantities import readable

SEPARATORS = ";\t,"  # the first of them in the first line parts the cells
_DECIMAL_COMMA = re.compile(r"([+-]?\d*),(\d+(?:[eE][+-]?\d+)?)")
_UNIT = re.compile(r"^(.*?)\s*(?:\[([^\]]*)\]|\(([^)]*)\))\s*$")
_WIDE = (b"\xff\xfe", b"\xfe\xff")  # byte order marks of UTF-16


class Row(NamedTuple):
    """A row that is not empty.

    Attributes:
        line: its line in the file, from 1.
        cells: its cells, without blanks around them. Where commas do not part them, a decimal comma has become a point.
    """

    line: int
    cells: list[str]


def read_rows(path: str | os.PathLike[str], most: int) -> list[Row]:
    """The rows of a CSV file of at most ``most`` bytes, whose cells are parted by commas, semicolons or tabs.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is no such text; `files.reason` puts both in words.
    """
    lines = text_of(files.read(path, most)).splitlines()
    separator = separator_of(next((line for line in lines if line.strip()), ""))
    try:
        rows = [
            Row(k, [_cell(cell, separator) for cell in row])
            for k, row in enumerate(csv.reader(lines, delimiter=separator, skipinitialspace=True), 1)
        ]
    except csv.Error as error:
        raise ValueError(f"no table: {error}") from None
    return [row for row in rows if any(row.cells)]


def text_of(content: bytes) -> str:
    """The text of a file in UTF-8, or in UTF-16 with its mark; raises ValueError where it is neither."""
    try:
        return content.decode("utf-16" if content.startswith(_WIDE) else "utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError("no text in UTF-8; save it in this encoding") from None


def separator_of(line: str) -> str:
    """What parts the cells of a line."""
    return next((each for each in SEPARATORS if each in line), ",")


def parted(name: str) -> tuple[str, str]:
    """Name and unit of "crank [deg]" or "crank (deg)"; the unit is empty where there is none."""
    found = _UNIT.match(name.strip())
    return (found[1].strip(), (found[2] or found[3] or "").strip()) if found and found[1].strip() else (name.strip(), "")


def factor_to(unit: str, head: str) -> float:
    """The factor to ``unit`` of the numbers under a head, by the unit in it, as in "x [mm]"; 1 where there is none.

    Raises:
        ValueError: the unit is none of this kind.
    """
    _, given = parted(head)
    try:
        return unit_factor(given, unit) if given else 1.0
    except ValueError:
        raise ValueError(f"{given!r} in {head!r} is none of {', '.join(readable(unit))}") from None


def _cell(text: str, separator: str) -> str:
    text = text.strip()
    if separator != "," and (found := _DECIMAL_COMMA.fullmatch(text)):
        return f"{found[1]}.{found[2]}"
    return text
