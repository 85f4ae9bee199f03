"""Tables of dimensions: CSV and YAML give what the calls give; mistakes are named with their row."""

import numpy as np
import pytest
from support import texts

import pinpress as pp

tol = pp.tolerances
CSV = """dimension, tolerance, unit, shape, sd, name, cost, smallest, largest
length E F, 0.05, , , 0.02, rod, 12, 0.02, 0.2

position A x, 100, um, uniform
position E z rocker, 0.1
angle C D E, 0.01
"""
YAML = """
- {dimension: length E F, tolerance: 0.05, sd: 0.02, name: rod, cost: 12, smallest: 0.02, largest: 0.2}
- {dimension: position A x, tolerance: 100, unit: um, shape: uniform}
- {dimension: position E z rocker, tolerance: 0.1}
- dimension: angle C D E
  tolerance: 0.01
"""


@pytest.fixture(scope="module")
def press():
    return texts.shipped("zxn2_3000b")


def read(press, folder, text, name="table.csv"):
    (folder / name).write_text(text, encoding="utf-8")
    return tol.read_dimensions(press, folder / name)


@pytest.mark.parametrize(("name", "text"), [("table.csv", CSV), ("table.yaml", YAML)])
def test_a_table_gives_what_the_calls_give(press, tmp_path, name, text):
    found = read(press, tmp_path, text, name)
    wanted = [
        tol.link_length(press, "E", "F", 5e-5, name="rod", sd=2e-5),
        tol.pin_position(press, "A", "x", 1e-4, shape="uniform"),
        tol.pin_position(press, "E", "z", 1e-4, link="rocker"),
        tol.pin_angle(press, "C", "D", "E", np.radians(0.01)),
    ]
    for part, expected in zip(found.parts, wanted, strict=True):
        assert (part.name, part.shape, part.unit) == (expected.name, expected.shape, expected.unit)
        assert part.tolerance == pytest.approx(expected.tolerance, rel=1e-15)
        assert (part.sd or 0.0) == pytest.approx(expected.sd or 0.0)
        assert {key: tuple(vector) for key, vector in part.direction.items()} == {
            key: tuple(vector) for key, vector in expected.direction.items()
        }
    assert dict(found.costs) == {"rod": 12.0}
    assert found.bounds["rod"] == pytest.approx((2e-5, 2e-4))
    assert "4 dimensions, 1 with a cost, 1 with bounds" in str(found)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty: give a CSV file with the heads dimension, tolerance"),
        ("dimension, tolerance\n", "has no dimension"),
        ("dimension, tolerence\n", "column 'tolerence' is unknown, did you mean 'tolerance'"),
        ("dimension, tolerance [um]\nlength E F, 50\n", "column 'tolerance \\[um\\]' is unknown, did you mean 'tolerance'"),
        ("dimension, unit\n", "no column 'tolerance'; give a CSV file with the heads dimension, tolerance and"),
        ("dimension, tolerance, dimension\n", "two columns are called 'dimension': rename one"),
        ("dimension, tolerance\nlength E F, 0.05\nlength E G, 0.05\n", "line 3: no bearing 'G'"),
        ("dimension, tolerance\nlength E F, 0,05\n", "line 2: 3 cells for 2 columns: write decimals after a point"),
        ('dimension, tolerance\nlength E F, "0,05"\n', "tolerance '0,05' is not a number: write a decimal point"),
        ("dimension, tolerance\nlength E F, 0.05 mm\n", "with its unit in the column unit"),
        ("dimension, tolerance\nlength E F, -0.05\n", "tolerance is -0.05: give a positive number"),
        ("dimension, tolerance, unit\nlength E F, 0.05, deg\n", "unit 'deg' is not a unit of a length: write one of mm, um"),
        ("dimension, tolerance\nwidth E F, 0.05\n", "'width E F' is not a dimension: write 'length E F'"),
        ("dimension, tolerance, smallest\nlength E F, 0.05, 0.01\n", "only one of smallest and largest is given"),
        ("dimension, tolerance\nlength E F, 0.05\nlength E F, 0.04\n", "given twice: EF"),
    ],
)
def test_mistakes_are_named_with_their_row(press, tmp_path, text, said):
    with pytest.raises(pp.PinpressError, match=said):
        read(press, tmp_path, text)


def test_odd_yaml_is_refused(press, tmp_path):
    for text, said in [
        ("a: b", "does not have a list"),
        ("- [1, 2]", "entry 1 is not a mapping"),
        ("- {dimension: length E F, tolerance: [1]}", "entry 1 is not a mapping"),
        ("- {dimension: length E F, tolerance: 0.05, size: 2}", "entry 1: key 'size' is unknown"),
        ("- {dimension: [", "it is not YAML"),
    ]:
        with pytest.raises(pp.PinpressError, match=said):
            read(press, tmp_path, text, "table.yml")
