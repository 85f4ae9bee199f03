"""Small pictures of curves: what is drawn against the numbers, gaps, many states, names as they are."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from pinpress.common.outlets.sparkline import HEIGHT, LEFT, TOP, WIDTH, sparkline

SVG = "{http://www.w3.org/2000/svg}"


def drawn(columns, names):
    """The curves' points on the sheet, with NaN between pieces, and all texts."""
    root = ET.fromstring(sparkline(columns, names))
    paths = [each.get("d") for each in root.iter(f"{SVG}path") if each.get("stroke").startswith("#")]
    points = [[(piece, float(x), float(y)) for piece, x, y in re.findall(r"([ML])([-\d.]+) ([-\d.]+)", path)] for path in paths]
    return points, [text.text for text in root.iter(f"{SVG}text")]


def test_a_curve_is_where_its_numbers_are():
    (points,), texts = drawn({"time [s]": np.array([0.0, 1.0, 4.0]), "force [N]": np.array([-2.0, 6.0, 0.0])}, ("time [s]", "force [N]"))
    places = [(x - LEFT, TOP + HEIGHT - y) for _, x, y in points]
    assert places == [(0, 0), (WIDTH / 4, HEIGHT), (WIDTH, HEIGHT / 4)]
    assert texts == ["force [N]", "6", "-2", "0", "4", "time [s]"]


def test_missing_numbers_are_gaps():
    values = np.ma.masked_array([1.0, 2.0, 3.0, 2.0, 1.0], mask=[0, 0, 1, 0, 0])
    (points, others), _ = drawn({"x": [0, 1, 2, 3, 4], "y": values, "z": [None, 1.0, 1.0, 1.0, 1.0]}, ("x", "y", "z"))
    assert [piece for piece, *_ in points] == ["M", "L", "M", "L"]
    assert len(others) == 4


@pytest.mark.parametrize("columns", [{"x": [1.0, 1.0], "y": [0.0, 1.0]}, {"x": [1.0, 2.0], "y": [None, 1.0]}, {"x": [], "y": []}])
def test_nothing_to_draw(columns):
    assert sparkline(columns, ("x", "y")) == ""


def test_of_many_states_no_peak_is_lost():
    values = np.zeros(100_000)
    values[61_803], values[70_001] = 1.0, -1.0
    (points,), _ = drawn({"x": np.arange(100_000.0), "y": values}, ("x", "y"))
    assert len(points) <= 4 * WIDTH
    assert {TOP, TOP + HEIGHT} <= {y for _, _, y in points}


def test_equal_and_huge_numbers():
    (points,), _ = drawn({"x": [0.0, 1.0], "y": [5.0, 5.0]}, ("x", "y"))
    assert {y for _, _, y in points} == {TOP + HEIGHT / 2}
    (points,), _ = drawn({"x": [0.0, 1.0], "y": [-1.7e308, 1.7e308]}, ("x", "y"))
    assert [y for _, _, y in points] == [TOP + HEIGHT, TOP]


def test_names_are_text():
    name = '<script>"&\n force [N]'
    picture = sparkline({"x": [0.0, 1.0], name: [0.0, 1.0]}, ("x", name))
    assert "<script" not in picture
    assert '<script>"& force [N]' in drawn({"x": [0.0, 1.0], name: [0.0, 1.0]}, ("x", name))[1]
