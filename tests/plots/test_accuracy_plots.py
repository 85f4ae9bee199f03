"""Charts of a slide's accuracy show the numbers they are given, and so do the sections of a report."""

import base64

import numpy as np
import pytest
from matplotlib.patches import Rectangle
from support import texts
from support.in_browser import data_in

import pinpress as pp

tol = pp.tolerances


def block(section, title):
    return next(each for each in section["blocks"] if each.get("title") == title)


def curve(section, title, name):
    """The values of a curve as the page has them."""
    values = next(each["y"] for each in block(section, title)["curves"] if each["name"] == name)
    return np.frombuffer(base64.b64decode(values), "<f4").astype(float)


@pytest.fixture(scope="module")
def press():
    return texts.shipped("crank_slide")


@pytest.fixture(scope="module")
def played(press):
    return tol.play(press, pp.cycle(press, 15.0, points=72), {"W": 5e-5, "slide_guide": tol.GuideClearance(2e-5, 0.2)})


@pytest.fixture(scope="module")
def budget(press):
    springs = pp.elasticity.Stiffness({"W": 1e9})
    warm = tol.Temperatures({"rod": 10.0})
    machining = tol.bottom_dead_centre(press, [tol.link_length(press, "P", "W", 1e-5)], samples=5000)
    return tol.budget(
        press, speeds=[1.0, 15.0], clearance={"W": 5e-5}, stiffness=springs, temperatures=warm, process=2e4, machining=machining
    )


def test_play_draws_offset_band_and_reversals(played):
    top, bottom = pp.plots.draw(played, "offset", "by_bearing").axes
    offset, dots = top.lines
    assert offset.get_ydata() == pytest.approx(1e6 * np.append(played.offset, played.offset[0]))
    assert dots.get_xdata() == pytest.approx([np.degrees(each.crank_angle) for each in played.reversals])
    assert bottom.lines[0].get_ydata()[:-1] == pytest.approx(1e6 * played.by_bearing["W"])
    assert len(bottom.lines) == 2


def test_budget_draws_parts_and_their_sum(budget):
    axes = pp.plots.draw(budget, "parts").axes[0]
    widths = np.array([bar.get_width() for bar in axes.patches if isinstance(bar, Rectangle)]).reshape(3, -1)
    for row, part in zip(widths, ("clearances", "springs", "heat"), strict=True):
        assert row == pytest.approx([1e6 * getattr(each, part) for each in budget.conditions])
    assert axes.lines[0].get_xdata() == pytest.approx([1e6 * each.shift for each in budget.conditions])


def test_sections_of_a_report(press, played, budget, tmp_path):
    over, warm = tol.play_over_speeds(press, {"W": 5e-5}, speed=[5.0, 15.0]), tol.heat(press, tol.Temperatures({"rod": -10.0}))
    page = pp.report(press, played.motion, tmp_path / "page.html", results=[played, over, warm, budget])
    found = {section["title"]: section for section in data_in(page)["report"]["sections"]}
    closed = np.append(played.offset, played.offset[0])  # the turn ends where it began
    assert curve(found["Slide in its clearances"], "Slide in its clearances", "slide") == pytest.approx(1e6 * closed, rel=1e-5)
    rows = block(found["Slide in its clearances"], "Forces that reverse")["rows"]
    assert [row[:2] for row in rows] == [[each.bearing, each.side] for each in played.reversals]
    tops = curve(found["Dead centres in the clearances over the speed"], "Dead centres", "top dead centre")
    assert tops == pytest.approx(1e6 * over.top_shift, rel=1e-5)
    assert found["Heat"]["blocks"][1]["rows"][0][1:3] == ["-10.000", "48.000"]
    accuracy = found["Accuracy of bottom dead centre"]
    rise = curve(accuracy, "Rise of bottom dead centre", "process, warm")
    assert rise == pytest.approx([1e3 * each.rise for each in budget.conditions if each.condition == "process, warm"], rel=1e-5)
    assert block(accuracy, "")["rows"][0][:2] == ["9.55", "idle"]
    assert block(accuracy, "Parts of bottom dead centre")["bars"]["heat"][-1] == pytest.approx(-48)


def test_parallelism_in_a_report(tmp_path):
    press = texts.shipped("jf75g_125_two_point")
    rods = {point: [tol.link_length(press, point.replace("4", "2"), point, 2e-5)] for point in ("P4_front", "P4_back")}
    found = tol.parallelism(press, rods, samples=1000)
    page = pp.report(press, pp.cycle(press, 30.0, points=24), tmp_path / "page.html", results=[found])
    section = next(each for each in data_in(page)["report"]["sections"] if each["title"] == "Parallelism on 2 points")
    three = curve(section, "Three standard deviations over the turn", "slope along (0, 1, 0)")
    assert three == pytest.approx(3e6 * np.append(found.slope_sd[:, 1], found.slope_sd[0, 1]), rel=1e-5)
    low, high = (f"{1e6 * end:.2f}" for end in found.slopes[1].band(0.95))
    assert section["blocks"][0]["figures"][0] == {
        "name": "slope along (0, 1, 0)",
        "value": f"{low} to {high} µm/m",
        "at": "95 % of presses",
    }
    presses = pp.plots.draw(found.slopes[1].with_limit(5e-5), "presses").axes[0]
    assert presses.get_xlabel() == "deviation of slope along (0, 1, 0) [µm/m]"
    assert max(np.max(line.get_xdata()) for line in presses.lines) == pytest.approx(1e6 * found.slopes[1].worst_case)
    other = texts.shipped("crank_slide")
    with pytest.raises(pp.PinpressError, match="the SlideParallelism is of jf75g_125_two_point, the page of crank_slide"):
        pp.report(other, pp.cycle(other, 7.0, points=24), tmp_path / "other.html", results=[found])


@pytest.fixture(scope="module")
def scattered(press):
    parts = [tol.link_length(press, "O", "P", 2e-5), tol.link_length(press, "P", "W", 4e-5)]
    return tol.bottom_dead_centre(press, parts, samples=4000)


def widths(axes):
    return [bar.get_width() for bar in axes.patches if isinstance(bar, Rectangle)]


def test_tolerances_draw_shares_and_presses(scattered):
    shares, presses = pp.plots.draw(scattered.height.with_limit(3e-5), "shares", "presses").axes
    assert widths(shares) == pytest.approx([80.0, 20.0])  # the longer rod first
    sample, *lines = presses.lines
    assert sample.get_ydata()[::2].sum() == pytest.approx(100.0)
    ends = sorted(1e6 * end for end in (*scattered.height.band(0.9973), *scattered.height.corners, -3e-5, 3e-5))
    assert sorted(end for line in lines for end in set(np.asarray(line.get_xdata()).tolist())) == pytest.approx(ends)
    assert widths(pp.plots.draw(scattered.stroke, "shares").axes[0])[0] == pytest.approx(100.0)  # the crank alone


def test_tolerances_in_a_report(press, scattered, tmp_path):
    cheapest = tol.allocate(press, scattered.parts, None, {"height": 2e-5})
    motion = pp.cycle(press, 7.0, points=24)
    page = pp.report(press, motion, tmp_path / "page.html", results=[scattered, cheapest])
    found = {section["title"]: section for section in data_in(page)["report"]["sections"]}
    scatter, allocated = found["Dead centres and tolerances"], found["Cheapest tolerances"]
    assert "4000 presses with lengths of their own. Bottom dead centre: PW makes 80 % of the variance" in scatter["note"]
    bars = block(scatter, "Shares of the variance")
    assert (bars["places"], bars["bars"]["bottom dead centre"]) == (["PW", "OP"], pytest.approx([80.0, 20.0]))
    assert curve(scatter, "Presses of the sample", "presses")[::2].sum() == pytest.approx(100.0, rel=1e-5)
    low, high = (f"{1e6 * end:.2f}" for end in scattered.height.band())
    assert scatter["blocks"][0]["figures"][0]["value"] == f"{low} to {high} µm"
    assert allocated["blocks"][1]["rows"][0][:2] == ["OP", f"{1e3 * cheapest.tolerances[0]:.4g} mm"]
    other = texts.shipped("zxn2_3000b")
    for result, said in ((scattered, "the DeadCentreScatter is of crank_slide"), (cheapest, "the AllocatedTolerances is of crank_slide")):
        with pytest.raises(pp.PinpressError, match=said):
            pp.report(other, pp.cycle(other, 7.0, points=24), tmp_path / "other.html", results=[result])
