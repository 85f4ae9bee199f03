"""Every result is a table: written and read back it is what it was, and shown it says its numbers with their units."""

import csv
import dataclasses
import math
import pickle
import re
import xml.etree.ElementTree as ET

import numpy as np
import pyarrow.parquet
import pytest
from scipy.io import loadmat
from support import every_result

import pinpress as pp
from pinpress.common.outlets.described import Chart, charts_of
from pinpress.common.results import Record, Records, Tabular

RETURNED = every_result.returned()
KINDS = sorted({kind for kind in every_result.public() | RETURNED if issubclass(kind, Tabular)}, key=lambda kind: kind.__name__)
UNIT = r"\d (N m|N|m/s2|m/s|m|r/min|rad/s|rad|deg|s|Hz|kg|Pa|J|W|kW)\b"
OF_CALLERS = {
    "ActiveBound",
    "ActiveConstraint",
    "BoundedQuantity",
    "DesignTradeOff",
    "FailedPoint",
    "Sweep",
    "SynthesisResult",
}
OF_WORDS = {"CheckResult", "Facts", "Finding", "Place", "Proposal"}
OF_SHARES = {"MotionLaw"}  # of a stroke of 1 in a time of 1
OF_ROWS = {
    "PressTable",  # whose rows have units of their own
    "AllocatedTolerances",
    "DimensionTable",
    "FittedMounts",
    "IdentifiableParameters",
    "IdentifiedParameter",
    "IdentifiedPress",
    "LearntParameter",
}


@pytest.fixture(params=KINDS, ids=lambda kind: kind.__name__)
def result(request):
    return next(value for value in every_result.made() if type(value) is request.param)


def plain(column):
    """A column as a list of numbers and words, None where there is no value."""
    return column.tolist() if isinstance(column, np.ndarray) else list(column)


def same(one, other):
    return one == other or (one in (None, "") and other in (None, "")) or (other is None and isinstance(one, float) and math.isnan(one))


def test_what_public_functions_return_is_a_table():
    assert len(KINDS) > 40
    assert {kind.__name__ for kind in RETURNED} - {kind.__name__ for kind in KINDS} == {
        "Group",  # what a group of measurements of accuracy is about, beside their table
        *("GuideSurface", "Gibs", "PreloadedJoint", "Rod"),  # what a caller describes, many at once
        "LiveView",  # a window
        *("TableState", "Quantity", "Panels"),  # one state, and what a table consists of
        *("Accelerometer", "ProcessForceSensor", "VibrationRun"),  # what is measured with
        *("Attachment", "Rotor"),  # what stands and spins on a frame
    }


def test_columns_have_one_length_and_names_of_their_own(result):
    columns = result.columns()
    assert len({len(column) for column in columns.values()}) == 1
    assert all(isinstance(name, str) and name == name.strip() for name in columns)


def test_csv(tmp_path, result):
    result.to_csv(tmp_path / "table.csv")
    with open(tmp_path / "table.csv", newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    columns = result.columns()
    assert header == list(columns)
    for column, words in zip(columns.values(), zip(*rows, strict=True), strict=True):
        for value, word in zip(plain(column), words, strict=True):
            assert word == "" if value is None else (float(word) == value if type(value) is float else word == str(value))


def test_frame(result):
    frame, columns = result.to_frame(), result.columns()
    assert list(frame.columns) == list(columns)
    for name, column in columns.items():
        assert all(map(same, frame[name].tolist(), plain(column)))


def test_parquet(tmp_path, result):
    result.to_parquet(tmp_path / "table.parquet")
    read, columns = pyarrow.parquet.read_table(tmp_path / "table.parquet").to_pydict(), result.columns()
    assert list(read) == list(columns)
    for name, column in columns.items():
        assert all(map(same, read[name], plain(column)))


def test_mat(tmp_path, result):
    result.to_mat(tmp_path / "table.mat")
    read = [values[:, 0] for name, values in loadmat(tmp_path / "table.mat").items() if not name.startswith("__")]
    for column, values in zip(result.columns().values(), read, strict=False):
        found = ["".join(cell) if isinstance(cell, np.ndarray) else cell for cell in values]
        assert all(map(same, found, plain(column)))


def test_shown_in_a_line(result):
    text = repr(result)
    assert text.startswith(f"<{type(result).__name__}")
    assert text.endswith(">")
    assert "\n" not in text
    assert len(text) < 600
    assert type(result).__name__ in OF_CALLERS | OF_WORDS | OF_SHARES | OF_ROWS or re.search(UNIT, text), text


def test_printed(result):
    assert all(line == line.rstrip() or line.startswith(" ") for line in str(result).splitlines())
    assert len(str(result).splitlines()) > 1 or type(result).__name__ in ("SnapThroughResponse", "DeflectedSlide")


def test_shown_in_a_notebook(result):
    shown = ET.fromstring(result._repr_html_())
    table = shown if shown.tag == "table" else shown.find("table")
    assert table.findtext("caption") == result.title
    heads = [head.text for head in table.findall("thead/tr/th")]
    rows = [[cell.text for cell in row.findall("td")] for row in table.findall("tbody/tr")]
    columns = result.columns()
    assert len(heads) == min(len(columns), 21)
    assert heads[:10] == list(columns)[:10]
    assert {len(row) for row in rows} == {len(heads)}
    assert len(rows) == min(len(plain(next(iter(columns.values())))), 21)


def test_main_curves_are_shown_as_pictures(result):
    names, charts = result._pictured, charts_of(result.described())
    assert set(names) <= set(result.columns())
    drawn = any(isinstance(chart, Chart) for chart in charts.values()) if charts else bool(names)
    assert ("<svg" in result._repr_html_()) == (drawn or type(result).__name__ == "DrawnPress")


def test_what_is_shown_is_escaped():
    assert "&lt;b&gt;" in Named("<b>", 1.0)._repr_html_()


@dataclasses.dataclass(frozen=True, repr=False)
class Named(Record, units={"length": "m"}):
    """A record for these tests."""

    name: str
    length: float
    width: float | None = None


def test_records_are_a_tuple_and_a_table(tmp_path):
    found = Records(Named, [Named("a", 1.0), Named("b", 2.5)])
    assert isinstance(found, tuple)
    assert found[1].length == 2.5
    assert found.columns() == {"name": ["a", "b"], "length [m]": [1.0, 2.5]}
    assert repr(found) == "(<Named: name a, length 1 m>, <Named: name b, length 2.5 m>)"
    assert str(found) == "2 x Named\n  name  length [m]\n  a              1\n  b            2.5"
    assert str(found[0]) == "Named\n  name                                   a\n  length                                 1 m"
    found.to_csv(tmp_path / "table.csv")
    assert (tmp_path / "table.csv").read_text() == "name,length [m]\na,1.0\nb,2.5\n"


def test_no_records_keep_their_names():
    assert Records(Named, ()).columns() == {"name": [], "length [m]": [], "width": []}
    assert Records(Named, ()) == ()


def test_records_travel():
    sent = pickle.loads(pickle.dumps(pp.measures.extremes(every_result.reactions())))
    assert sent == pp.measures.extremes(every_result.reactions())
    assert sent.kind is type(sent[0])
