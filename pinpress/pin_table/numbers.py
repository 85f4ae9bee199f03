"""The plain numbers of a table that change the press: its parameters, and the coordinates and lengths of its pins.

Each number keeps its place in the file's text. So a table with other numbers is the same text with the same comments: only the numbers
are replaced. Formulas and the entries of a ``base`` are not changed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import yaml

from ..common.errors import PinpressError
from .placement import RESERVED
from .reading import Entry

Path = tuple[str, ...]


@dataclass(frozen=True)
class TableNumber:
    """A plain number in a table.

    Attributes:
        path: the keys that lead to it, from the top; items of a list are counted from 1.
        kind: "length", "coordinate", "angle" [deg] or "parameter" (only the table's formulas show its meaning).
        value: as written; lengths and coordinates in the table's unit.
        comment: the comment behind it in its line; only parameters have one.
        start: index of its first character in the text.
        end: index after its last character.
    """

    path: Path
    kind: str
    value: float
    comment: str
    start: int
    end: int


def numbers_of(text: str) -> tuple[TableNumber, ...]:
    """List the numbers in a table's text that determine the press, in the order of the text.

    Args:
        text: text of a file that `read_table` reads.
    """
    numbers: list[TableNumber] = []
    for key, value in _items(yaml.compose(text, Loader=yaml.BaseLoader)):
        for name, node in _items(value) if key in ("parameters", "pins") else ():
            numbers += _plain(text, node, (key, name), "parameter") if key == "parameters" else _of_pin(text, node, (key, name))
    return tuple(sorted(numbers, key=lambda each: each.start))


def with_numbers(table: Entry, values: Mapping[Path, float]) -> Entry:
    """Replace numbers of a table by what their `rewritten` text has, 12 digits.

    Args:
        table: the table as `read_table` returns it.
        values: path of keys -> new number.
    """
    return with_exact_numbers(table, {path: float(written(value)) for path, value in values.items()})


def with_exact_numbers(table: Entry, values: Mapping[Path, float]) -> Entry:
    """Replace numbers of a table by all their digits, which differences need; arguments as of `with_numbers`."""
    for path, value in values.items():
        table = _with(table, path, value)
    return table


def rewritten(text: str, numbers: Sequence[TableNumber], values: Mapping[Path, float]) -> str:
    """Replace the numbers of a table's text that have new values; the rest of the text stays as it is."""
    for each in sorted(numbers, key=lambda each: -each.start):
        value = values.get(each.path, each.value)
        if value != each.value:
            text = text[: each.start] + written(value) + text[each.end :]
    return text


def written(value: float) -> str:
    """Format a number for a table.

    Raises:
        PinpressError: the number is not finite.
    """
    if not math.isfinite(value):
        raise PinpressError(f"{value} is not a number for a table: give a finite number")
    return f"{value:.12g}"


def _of_pin(text: str, node: yaml.Node, path: Path) -> Iterator[TableNumber]:
    """The numbers of a pin: its coordinates, or the lengths and the angle that place it."""
    if isinstance(node, yaml.SequenceNode):
        yield from _pair(text, node, path)
    for key, value in _items(node):
        here = (*path, key)
        if key == "at":
            yield from _pair(text, value, here)
        elif key == "angle":
            yield from _plain(text, value, here, "angle")
        elif key in ("x", "y", "z"):
            yield from _plain(text, value, here, "coordinate")
        elif key == "length" or key not in RESERVED:
            yield from _plain(text, value, here, "length")


def _pair(text: str, node: yaml.Node, path: Path) -> Iterator[TableNumber]:
    for place, each in enumerate(node.value if isinstance(node, yaml.SequenceNode) else (), 1):
        yield from _plain(text, each, (*path, str(place)), "coordinate")


def _plain(text: str, node: yaml.Node, path: Path, kind: str) -> Iterator[TableNumber]:
    """The number of a node; nothing if the node is a formula, or has an anchor that repeats it elsewhere."""
    start, end = node.start_mark.index, node.end_mark.index
    if not isinstance(node, yaml.ScalarNode) or text[start:end] != node.value:
        return
    try:
        value = float(node.value)
    except ValueError:
        return
    if math.isfinite(value):
        line = text[end:].partition("\n")[0]
        comment = line.partition("#")[2].strip() if kind == "parameter" and line.partition("#")[0].strip() == "" else ""
        yield TableNumber(path, kind, value, comment, start, end)


def _items(node: yaml.Node | None) -> Iterator[tuple[str, yaml.Node]]:
    """Keys and values of a mapping; nothing for any other node."""
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            yield str(key.value), value


def _with(entry: Entry, path: Path, value: float) -> Entry:
    """Replace the value at the end of a path."""
    if not path:
        return replace(entry, value=value)
    first, *rest = path
    items = {str(k): each for k, each in enumerate(entry.value, 1)} if isinstance(entry.value, tuple) else entry.value
    if not isinstance(items, Mapping) or first not in items:
        entry.refuse(f"there is no {first}", "give the keys of a number in the table")
    changed = {**items, first: _with(items[first], tuple(rest), value)}
    return replace(entry, value=tuple(changed.values()) if isinstance(entry.value, tuple) else changed)
