"""Charts of elastic presses show the numbers they are given."""

from dataclasses import replace

import numpy as np
import pytest
from support import texts
from support.in_browser import data_in

import pinpress as pp
from pinpress.elasticity.breakthrough import snap_through
from pinpress.elasticity.slide_under_load import dead_centre_shift
from pinpress.elasticity.springs import Stiffness
from pinpress.elasticity.unit_load import compliance

PRESS = texts.shipped("zxn2_3000b")
STIFFNESS = Stiffness(dict.fromkeys("ABCDEF", 2000000000.0), shaft=3e7, frame=4e9)


def test_parts_are_stacked_to_the_whole():
    found = compliance(PRESS, STIFFNESS, angle=np.linspace(0.0, 6.0, 25))
    axes = pp.plots.draw(found, "compliance").axes[0]
    top = axes.collections[-1].get_paths()[0].vertices[:, 1].max()
    assert top == pytest.approx(1e9 * found.compliance.max(), rel=1e-12)
    assert {text.get_text() for text in axes.get_legend().get_texts()} <= {*found.parts, "others"}


@pytest.mark.one_in(2)
@pytest.mark.parametrize("names", [("P", "W"), ("W", "P")])
def test_rounding_does_not_choose_the_order(names):
    """Of parts that yield alike, in the text and in the chart, the one that was given first comes first."""
    found = compliance(texts.shipped("crank_slide"), Stiffness(dict.fromkeys(names, 1e9)), angle=np.linspace(0.0, 6.0, 25))
    half = 0.5 * found.compliance
    alike = dict(zip(names, (half, half * (1 + 1e-13)), strict=True))
    found = replace(found, parts=alike, bottom_shares=dict(zip(names, (0.5, 0.5 * (1 + 1e-13)), strict=True)))
    lines = str(found).splitlines()
    assert [line.split()[0] for line in lines[-2:]] == list(names)
    assert [text.get_text() for text in pp.plots.draw(found, "compliance").axes[0].get_legend().get_texts()] == list(names)


@pytest.mark.parametrize("seed", range(3))
def test_plot_and_report_rank_the_parts_alike(tmp_path, seed):
    """Stiffnesses over a decade: the plot's legend, from the top, and the report's curves have the parts in one order."""
    rng = np.random.default_rng(seed)
    stiffness = Stiffness({name: 10 ** rng.uniform(8.8, 9.8) for name in PRESS.bearings}, shaft=3e7)
    found = compliance(PRESS, stiffness, angle=np.linspace(0.0, 6.0, 25))
    legend = [text.get_text() for text in pp.plots.draw(found, "compliance").axes[0].get_legend().get_texts()]
    pp.report(PRESS, pp.cycle(PRESS, speed=7.0, points=12), tmp_path / "report.html", results=[found])
    (section,) = [each for each in data_in(tmp_path / "report.html")["report"]["sections"] if each["title"] == "Elastic press"]
    (chart,) = [block for block in section["blocks"] if block.get("title", "").startswith("Compliance")]
    reported = [curve["name"] for curve in chart["curves"] if curve["name"] != "others"]
    assert legend[: len(reported)] == reported


def test_curves():
    shift = dead_centre_shift(PRESS, STIFFNESS, speed=np.array([7.0, 2.0, 5.0]))
    x, y = pp.plots.draw({"six-bar": shift}, "shift").axes[0].lines[0].get_data()
    np.testing.assert_allclose(x, np.array([2.0, 5.0, 7.0]) / pp.RPM)
    np.testing.assert_allclose(y, 1e6 * shift.shift[[1, 2, 0]])
    response = snap_through(1e6, 6e8, mass=3e3, damping_ratio=0.05)
    line = pp.plots.draw({"a": response}, "spring_share").axes[0].lines[0]
    np.testing.assert_allclose(line.get_ydata(), response.spring_force / 1e6)


def test_a_chart_of_nothing_is_refused():
    with pytest.raises(pp.PinpressError, match="there is nothing to draw"):
        pp.plots.draw({}, "shift")


def test_elastic_motion_and_resonances():
    press, speed = texts.shipped("crank_slide"), 30.0
    elastic = pp.elasticity.Elastic(Stiffness(dict.fromkeys(press.bearings, 2e8), moments={"slide_guide": 2e7}))
    run = pp.steady_state(press, speed, drive=pp.drives.PrescribedSpeed(speed), elastic=elastic, points=25)
    assert isinstance(run, pp.ElasticRun)
    top, bottom = pp.plots.draw(run, "beside_rigid", "forces").axes
    beside = run.slide_position - run.rigid_slide_position
    factor = {"length [mm]": 1e3, "length [µm]": 1e6}[top.get_ylabel()]
    np.testing.assert_allclose(top.lines[0].get_ydata(), factor * beside)
    drawn = {text.get_text(): line for text, line in zip(bottom.get_legend().get_texts(), bottom.lines, strict=True)}
    factor = {"force [N]": 1.0, "force [kN]": 1e-3}[bottom.get_ylabel()]
    np.testing.assert_allclose(drawn["W"].get_ydata(), factor * np.linalg.norm(run.bearing_force["W"], axis=1))
    diagram = pp.elasticity.campbell(press, elastic, speeds=[100.0, 500.0], orders=3)
    *_, dots = pp.plots.draw(diagram, "campbell").axes[0].lines
    meeting = [[each.speed / pp.RPM, each.order * each.speed / (2 * np.pi)] for each in diagram.resonances if 100 <= each.speed <= 500]
    assert meeting
    np.testing.assert_allclose(dots.get_xydata(), meeting)
