"""The plain numbers of a table by which a press changes: its parameters, and the places and lengths of its pins.

They are found with their places in the file's text, so that a table with other numbers is the same text, comments and all, in which only
these are replaced. What is a formula stays a formula, and what a ``base`` says stays there.
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
    """A plain number that stands in a table.

    Attributes:
        path: the keys that lead to it, from the top; places in a list are counted from 1.
        kind: "length", "coordinate", "angle" [deg], or "parameter", whose meaning only the table's formulas know.
        value: as it is written, lengths and coordinates in the table's unit.
        comment: what stands behind it in its line; of parameters alone.
        start: index of its first character in the text.
        end: index behind its last character.
    """

    path: Path
    kind: str
    value: float
    comment: str
    start: int
    end: int


def numbers_of(text: str) -> tuple[TableNumber, ...]:
    """The numbers of a table's own text that it makes a press of, in their order there.

    Args:
        text: of a file that `read_table` takes.
    """
    top = yaml.compose(text, Loader=yaml.BaseLoader)
    found = []
    for key, value in _items(top):
        if key == "parameters":
            found += [each for name, node in _items(value) for each in _plain(text, node, (key, name), "parameter")]
        if key == "pins":
            found += [each for name, node in _items(value) for each in _of_pin(text, node, (key, name))]
    return tuple(sorted(found, key=lambda each: each.start))


def with_numbers(table: Entry, values: Mapping[Path, float]) -> Entry:
    """A table with other numbers.

    Args:
        table: as it was read.
        values: the numbers by the keys that lead to them.
    """
    for path, value in values.items():
        table = _with(table, path, written(value))
    return table


def rewritten(text: str, numbers: Sequence[TableNumber], values: Mapping[Path, float]) -> str:
    """The text of a table in which those numbers are replaced that have other values; all else stays as it is."""
    for each in sorted(numbers, key=lambda each: -each.start):
        value = values.get(each.path, each.value)
        if value != each.value:
            text = text[: each.start] + written(value) + text[each.end :]
    return text


def written(value: float) -> str:
    """A number as a table has it.

    Raises:
        PinpressError: it is not finite.
    """
    if not math.isfinite(value):
        raise PinpressError(f"{value} is no number of a table: give a finite one")
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
    """The number that a node is; nothing where it is a formula, or has an anchor by which it stands elsewhere too."""
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
    """Keys and values of a mapping; nothing of another node."""
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            yield str(key.value), value


def _with(entry: Entry, path: Path, value: str) -> Entry:
    """An entry with another value at the end of a path."""
    if not path:
        return replace(entry, value=value)
    first, rest = path[0], path[1:]
    if isinstance(entry.value, Mapping) and first in entry.value:
        return replace(entry, value={**entry.value, first: _with(entry.value[first], rest, value)})
    if isinstance(entry.value, tuple) and first.isdigit() and 0 < int(first) <= len(entry.value):
        place = int(first) - 1
        return replace(entry, value=(*entry.value[:place], _with(entry.value[place], rest, value), *entry.value[place + 1 :]))
    return entry.refuse(f"there is no {first}", "give the keys of a number that stands in the table")
