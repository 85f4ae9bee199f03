"""Read values of parts of the command line: numbers, instants, points and tables of a file.

Every reader raises ValueError with the fault of the text.
"""

import contextlib
import math
import re

from ...common.arguments import read_quantity
from ...common.errors import PinpressError
from ...common.quantities import DriverCoordinate, readable
from ...common.reading.columns import Wanted, read_columns, split_head
from ...drives.transmission import SwitchPoint

LARGEST_FILE = 10**8  # largest file of a table with two columns [bytes]


def speed(text: str, driver: DriverCoordinate) -> float:
    """Read a speed of a driver in SI units from a number in r/min or mm/s."""
    unit, size = driver.shown_speed
    return read_quantity(text, unit) * size


def whole_number(text: str) -> int:
    """Read a whole number."""
    try:
        return int(text)
    except ValueError:
        raise ValueError("no whole number") from None


def numbers(text: str, unit: str) -> tuple[float, ...]:
    """Read numbers with a slash between them."""
    return tuple(read_quantity(part, unit) for part in text.split("/"))


def truth(text: str) -> bool:
    """ "yes" or "no"."""
    if text not in ("yes", "no"):
        raise ValueError("neither yes nor no")
    return text == "yes"


def instant(text: str) -> SwitchPoint:
    """Read a time, ``0.1s``, or a crank angle, ``180deg``."""
    with contextlib.suppress(ValueError, PinpressError):
        if text.endswith(tuple(readable("deg"))):
            return SwitchPoint(angle=math.radians(read_quantity(text, "deg")))
        if text.endswith(tuple(readable("s"))):
            return SwitchPoint(time=read_quantity(text, "s"))
    raise ValueError("neither a time as 0.1s nor a crank angle as 180deg")


def vector(text: str, unit: str) -> tuple[float, ...]:
    """Read three numbers with slashes between them."""
    parts = re.split(r"/(?=\s*[-+.\d])", text)  # the slash of a unit, as in 50MN/m, is followed by no number
    if len(parts) != 3:
        raise ValueError("not x/y/z as 0/0/-0.2")
    return tuple(read_quantity(part, unit) for part in parts)


def pairs_of_file(path: str, columns: tuple[str, str]) -> list[tuple[float, float]]:
    """Read a CSV file of two columns in these units. A first line without numbers is a header, which may name other units."""
    heads = [split_head(column) for column in columns]
    try:
        table = read_columns(path, {name: Wanted(unit, bare=unit) for name, unit in heads}, by_order=True)
    except PinpressError as error:
        fault = str(error).removeprefix(path).lstrip(",: ")
        raise ValueError(f"{'in' if fault.startswith('line') else 'where' if 'column ' in fault[:10] else 'which'} {fault}") from None
    return list(zip(*(column.tolist() for column in table.values.values()), strict=True))
