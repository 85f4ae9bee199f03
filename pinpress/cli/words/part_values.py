"""Values of the parts that the command line describes: texts as numbers, instants, points and tables of a file.

Every reader raises ValueError with what is wrong with the text.
"""

import contextlib
import math
import re

from ...common import files
from ...common.arguments import read_quantity, unit_factor
from ...common.errors import PinpressError
from ...common.quantities import DriverCoordinate, readable
from ...common.reading.cells import read_rows
from ...drives.transmission import SwitchPoint

LARGEST_FILE = 10**8  # of a table of two columns [bytes]


def speed(text: str, driver: DriverCoordinate) -> float:
    """A speed of a driver in SI units, from one in the unit in which its speeds are shown."""
    unit, size = driver.shown_speed
    return read_quantity(text, unit) * size


def whole_number(text: str) -> int:
    """A whole number."""
    try:
        return int(text)
    except ValueError:
        raise ValueError("no whole number") from None


def numbers(text: str, unit: str) -> tuple[float, ...]:
    """Numbers with a slash between them."""
    return tuple(read_quantity(part, unit) for part in text.split("/"))


def truth(text: str) -> bool:
    """ "yes" or "no"."""
    if text not in ("yes", "no"):
        raise ValueError("neither yes nor no")
    return text == "yes"


def instant(text: str) -> SwitchPoint:
    """A time, ``0.1s``, or a crank angle, ``180deg``."""
    with contextlib.suppress(ValueError, PinpressError):
        if text.endswith(tuple(readable("deg"))):
            return SwitchPoint(angle=math.radians(read_quantity(text, "deg")))
        if text.endswith(tuple(readable("s"))):
            return SwitchPoint(time=read_quantity(text, "s"))
    raise ValueError("neither a time as 0.1s nor a crank angle as 180deg")


def vector(text: str, unit: str) -> tuple[float, ...]:
    """Three numbers with slashes between them."""
    parts = re.split(r"/(?=\s*[-+.\d])", text)  # the slash of a unit, as in 50MN/m, is followed by no number
    if len(parts) != 3:
        raise ValueError("not x/y/z as 0/0/-0.2")
    return tuple(read_quantity(part, unit) for part in parts)


def pairs_of_file(path: str, columns: tuple[str, str]) -> list[tuple[float, float]]:
    """The rows of a CSV file of two columns, in their units; a first line without numbers is its header, which may name other units."""
    wanted = f"a CSV file of two columns, {columns[0]} and {columns[1]}, with a comma between them"
    try:
        rows = read_rows(path, LARGEST_FILE)
    except (OSError, ValueError) as error:
        raise ValueError(f"which cannot be read ({files.reason(error)}): give {wanted}") from None
    pairs, factors = list[tuple[float, float]](), (1.0, 1.0)
    for number, row in rows:
        try:
            first, second = map(float, row)
        except ValueError:
            if pairs or number > rows[0].line:
                raise ValueError(f"whose row {number} is {','.join(row)!r}: give {wanted}") from None
            factors = _units_of_header(row, columns)
        else:
            pairs.append((first * factors[0], second * factors[1]))
    return pairs


def _units_of_header(row: list[str], columns: tuple[str, str]) -> tuple[float, float]:
    """Factors to the columns' own units of what a header names in brackets, as in ``height [mm], force [kN]``."""
    first, second = (
        1.0 if (given := re.search(r"\[(.+?)\]", cell)) is None else unit_factor(given[1].strip(), column.partition("[")[2][:-1])
        for cell, column in zip([*row, "", ""][:2], columns, strict=True)
    )
    return first, second
