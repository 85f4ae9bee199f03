"""The plain numbers of a table are found where they stand, and only they are replaced."""

from pathlib import Path

import pytest

import pinpress as pp
from pinpress.pin_table.building import drawn_from
from pinpress.pin_table.numbers import numbers_of, rewritten, with_numbers
from pinpress.pin_table.reading import read_table

TABLES = sorted((Path(pp.__file__).parent / "pin_table" / "templates").glob("*.yaml"))
TEXT = """\
units: mm
parameters: {r: 100, l: 4 * r, half: &h 50}   # of the crank
pins:
  O: [0, -1.5e1]
  P: {from: O, length: r, angle: 90}
  Q: {from: O, at: [*h, +20]}
  W: {P: 400.0, x: 0, side: down, near: [1, 2]}
links: {crank: {mass: 20}}
"""


def test_they_are_those_of_parameters_and_pins() -> None:
    found = {".".join(each.path): (each.kind, each.value, each.comment) for each in numbers_of(TEXT)}
    assert found == {
        "parameters.r": ("parameter", 100, ""),  # the line's comment is not its own
        "pins.O.1": ("coordinate", 0, ""),
        "pins.O.2": ("coordinate", -15, ""),
        "pins.P.angle": ("angle", 90, ""),
        "pins.Q.at.2": ("coordinate", 20, ""),
        "pins.W.P": ("length", 400, ""),
        "pins.W.x": ("coordinate", 0, ""),
    }


def test_all_else_of_the_text_stays() -> None:
    numbers = numbers_of(TEXT)
    changed = rewritten(TEXT, numbers, {("pins", "O", "2"): 7.25, ("pins", "W", "P"): 380, ("parameters", "r"): 100})
    assert changed == TEXT.replace("-1.5e1", "7.25").replace("400.0", "380")
    assert rewritten(TEXT, numbers, {}) == TEXT


@pytest.mark.parametrize("path", TABLES, ids=lambda path: path.stem)
def test_a_table_read_again_is_the_table_with_other_numbers(path: Path, tmp_path: Path) -> None:
    text = path.read_text()
    numbers = numbers_of(text)
    values = {each.path: each.value * 1.001 for each in numbers}
    other = tmp_path / path.name
    other.write_text(rewritten(text, numbers, values))
    there, again = drawn_from(with_numbers(read_table(path), values)), drawn_from(read_table(other))
    assert there.columns().keys() == again.columns().keys()
    for name, column in there.columns().items():
        assert list(column) == list(again.columns()[name])
