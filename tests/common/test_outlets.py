"""What a result shows is described once: units and digits are chosen by the outlets, and by them alone."""

import inspect
import re
from pathlib import Path

import numpy as np
import pytest
from support import every_result

import pinpress as pp
from pinpress.common.outlets import text
from pinpress.common.outlets.described import Chart, Column, Figure, Section, Table, charts_of
from pinpress.common.quantities import quantity
from pinpress.common.results import Tabular

ROOT = Path(pp.__file__).parent
DESCRIBED = sorted(ROOT.glob("*/described.py"))


@pytest.mark.parametrize(
    ("key", "values", "shown"),
    [
        ("N", [3e6], "3000 kN"),  # as presses are rated
        ("N", [9999.0], "9999 N"),
        ("N", [1.2e7], "12.0 MN"),
        ("m", [5e-5], "50.0 µm"),
        ("m", [0.301261], "301 mm"),
        ("m", [0.0], "0 mm"),
        ("height", [0.0123456], "12.346 mm"),
        ("rad", [np.pi / 7], "25.714 deg"),
        ("rad/s", [70 * pp.RPM], "70.0 r/min"),
        ("frequency", [2 * np.pi * 12.5], "12.5 Hz"),
        ("share", [0.3333], "33.3 %"),
        ("N/m", [3e9], "3000 kN/mm"),
        ("Pa", [2.5e6], "2.50 MPa"),
        ("s", [0.0031], "3.10 ms"),
        ("kg/m3", [7850.0], "7850 kg/m3"),
        ("a unit of nobody", [1.0], "1.00 a unit of nobody"),
    ],
)
def test_units_are_chosen_by_size(key, values, shown):
    assert quantity(key).text(values[0]) == shown


def test_a_number_that_is_nothing_next_to_its_kind_is_zero():
    scale = quantity("N").scale([1e5, 0.05], reference=1e5)
    assert [scale.shown(value) for value in (1e5, 0.05, -0.05)] == ["100", "0", "0"]


def test_columns_have_one_unit_and_figures_that_of_their_limit():
    table = Table("t", "", [Column("name", ["a", "b"]), Column("force", [2e5, 1.0], "N"), Column("count", [3, None])])
    heads, rows = text.cells(table, digits=3)
    assert heads == ["name", "force [kN]", "count"]
    assert rows == [["a", "200", "3"], ["b", "0", ""]]
    figure = Figure("torque", 9e3, "N m", "at 30 deg", limit=2e4)
    assert (figure.use, text.value(figure, 3), text.remark(figure, 3)) == (0.45, ("9.0", "kN m"), "of 20.0 kN m, at 30 deg")
    assert Figure("load", 50.0, "N", limit=100.0, least=True).use == 2.0
    written = text.written([Section("Drive", [figure], [table], note="A remark.")])
    assert written.splitlines()[:3] == ["Drive", f"  torque{'9.000':>32} kN m   of 20.000 kN m, at 30 deg", "  A remark."]


def test_rows_of_one_name_have_one_unit():
    names, before, after = ["force", "force", "moment"], [2958.0, 11840.0, 40.5], [119.06, None, 41.0]
    columns = [Column("", names), Column("before", before), Column("after", after), Column("change", [-0.5, 0.25, 0.0], "share")]
    heads, rows = text.cells(Table("criteria", "", columns, quantities=["N", "N", "N m"]))
    assert heads == ["", "before", "after", "change [%]"]
    assert rows == [
        ["force [kN]", "2.958", "0.119", "-50.000"],
        ["force [kN]", "11.840", "", "25.000"],
        ["moment [N m]", "40.500", "41.000", "0"],
    ]


@pytest.mark.parametrize("path", DESCRIBED, ids=lambda path: path.parent.name)
def test_descriptions_scale_nothing(path):
    """No factor of a prefix and no division by a unit outside the words of notes; a threshold that is compared is no factor."""
    code = re.sub(r'f"[^"]*"', "", path.read_text(encoding="utf-8"))
    assert re.findall(r"(?<![\w.])(?<![<>] )(?<![<>]= )1e-?[369] \*|/ RPM\b", code) == []


def test_every_described_result_has_finite_charts_of_one_length():
    """Of every class whose room says how it is described, one result of the tests' list."""
    found = {type(result): result for result in every_result.made() if isinstance(result, Tabular)}
    described = {kind: result.described() for kind, result in found.items()}
    count = 0
    for kind, sections in described.items():
        for name, chart in charts_of(sections).items():
            assert name, kind
            if isinstance(chart, Chart):
                for curve in chart.curves:
                    x = chart.along.values if curve.x is None else curve.x
                    assert x is not None, (kind, name)
                    assert x.shape == curve.y.shape, (kind, name, curve.name)
                    assert np.isfinite(curve.y).all(), (kind, name, curve.name)
                    count += 1
    assert count > 100


def test_the_names_of_a_result_are_known_to_its_room():
    import importlib

    for path in DESCRIBED:
        room = importlib.import_module(f"pinpress.{path.parent.name}.described")
        assert all(inspect.isclass(kind) and issubclass(kind, Tabular) for kind in room.SECTIONS)
