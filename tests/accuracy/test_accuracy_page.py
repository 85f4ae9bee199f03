"""The page of what is measured: its numbers against the measurements, and that names stay text in a real browser."""

import base64
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support.in_browser import data_in

import pinpress as pp
from pinpress.common.results import Records

NAME = "<script>alert(1)</script>{{plotly}}"
ROWS = [
    ("inverse dynamics", "plane", "", 1e-3, 2e-15),
    ("inverse dynamics", NAME, "", 2e-1, 1e-14),
    ("free run", "reduced", "tolerance 1e-06", 2e-2, 1e-6),
    ("free run", "reduced", "tolerance 1e-08", 3e-2, 1e-8),
    ("free run", "implicit", "tolerance 1e-06", 4e-2, None),
]


@pytest.fixture
def measured() -> Any:
    made = [
        pp.accuracy.Measurement(
            group,
            method,
            setting,
            None,
            seconds,
            error,
            problem="" if error else "not finite",
            cannot="linkages in space" if method == "plane" else "",
        )
        for group, method, setting, seconds, error in ROWS
    ]
    known, by = {"free run": 3e-12, "inverse dynamics": 1e-15}, dict.fromkeys(("free run", "inverse dynamics"), "two methods")
    records = Records(pp.accuracy.Measurement, made)
    return pp.accuracy.WorkPrecision(NAME, "70 r/min", "a computer", {"free run": "from rest"}, known, by, records, ("one is skipped",))


def numbers(packed: str) -> Any:
    return np.frombuffer(base64.b64decode(packed), "<f4").astype(float)


def test_page_of_measurements(measured: Any, tmp_path: Path) -> None:
    report = data_in(pp.accuracy.report(measured, tmp_path / "out.html"))["report"]
    inputs = report["inputs"][0]["rows"]
    assert [row[0] for row in inputs] == ["press", "scene", "computer", "free run", "left out", "computed by"]
    sections = {section["title"]: section["blocks"] for section in report["sections"]}
    assert list(sections) == ["Inverse dynamics", "Free run", "Limits"]
    chart, table = sections["Free run"]
    curves = {curve["name"]: (numbers(curve["x"]), numbers(curve["y"])) for curve in chart["curves"]}
    assert list(curves) == ["reference known to", "reduced"]  # a method without an error has no line
    assert_allclose(curves["reduced"], [[20, 30], [1e-6, 1e-8]], rtol=1e-6)
    assert_allclose(curves["reference known to"][1], 3e-12, rtol=1e-6)
    (limits,) = sections["Limits"]
    assert limits["rows"] == [["plane", "linkages in space"]]
    assert [row[:4] for row in table["rows"]] == [
        ["reduced", "tolerance 1e-06", "20", "1.0e-06"],
        ["reduced", "tolerance 1e-08", "30", "1.0e-08"],
        ["implicit", "tolerance 1e-06", "40", "not finite"],
    ]


@pytest.mark.exhaustive
def test_the_page_in_a_browser(measured: Any, view: Callable[..., Any], tmp_path: Path) -> None:
    page = view(pp.accuracy.report(measured, tmp_path / "out.html"), "", (900, 600))
    assert page.title() == page.inner_text("h1") == f"{NAME}: error against run time"
    assert page.locator(".plot .main-svg").count() > 1
    assert page.locator("article script, article img").count() == 0
    assert NAME in page.inner_text(".table >> nth=0")
    assert page.evaluate("document.documentElement.scrollWidth") <= 900


def test_a_long_problem_does_not_widen_the_table() -> None:
    """It stands at the end of its line, and the line is broken where it is too long."""
    problem = "a program does not keep this press together, whatever its step is: give a shorter step, or another program"
    rows = [
        pp.accuracy.Measurement("free run", "reduced", f"step {k} ms", k, 0.01, None if k else 1e-3, 1e-3, problem=problem[: k * 99])
        for k in (0, 1, 2)
    ]
    told = pp.accuracy.WorkPrecision(
        "press", "", "", {}, {"free run": 0.1}, {"free run": "two"}, Records(pp.accuracy.Measurement, rows), ()
    )
    lines = str(told).split("\n")
    assert max(map(len, lines)) <= 98
    assert "               time [ms]    error  force error" in lines
    assert problem in " ".join(" ".join(lines).split())
