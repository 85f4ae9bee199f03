"""Reports, opened in a real browser with the network off: charts that show what was computed and follow the recording."""

import importlib.util
import itertools
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support import texts
from support.generators.hostile import NAMES, load_hostile
from support.generators.small_linkages import two_cranks
from support.generators.spatial_linkages import bennett
from support.in_browser import data_in, floats, seek, wait

import pinpress as pp

SPEED = 70 * pp.RPM
HEIGHT = "Slide height above bottom dead centre"
WIDE, SMALL = (1000, 500), (700, 300)  # windows, the press beside the charts and above them; the larger one takes longer to draw
CURVES = """() => Object.fromEntries([...document.querySelectorAll('.chart')].filter(box => box.querySelector('.plot')).map(box => [
    box.querySelector('h3').textContent,
    box.querySelector('.plot').data.map(({ name, x, y }) => ({ name, x: [...x], y: [...y] })),
]))"""
CURSOR = """title => {
    const box = [...document.querySelectorAll('.chart')].find(box => box.querySelector('h3')?.textContent.startsWith(title));
    const { xaxis } = box.querySelector('.plot')._fullLayout, left = parseFloat(box.querySelector('.cursor').style.left);
    return { x: xaxis.p2l(left - xaxis._offset), values: [...box.querySelectorAll('.legend output')].map(value => value.textContent) };
}"""


def shown(text: str) -> float:
    return float(text.replace("\u2212", "-"))


@pytest.fixture(scope="module")
def press() -> Any:
    return texts.shipped("zxn2_3000b")


@pytest.fixture(scope="module")
def result(press: Any) -> Any:
    return pp.inverse_dynamics(press, pp.cycle(press, speed=SPEED, points=180))


@pytest.fixture(scope="module")
def written(press: Any, result: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pp.report(press, result.motion, tmp_path_factory.mktemp("report") / "out.html", reactions=result)


@pytest.fixture
def page(written: Path, shared_view: Callable[..., Any]) -> Any:
    """The report, open at its beginning."""
    return shared_view(written, WIDE)


def in_rows(blocks: Any, result: Any) -> None:
    """Of more bearings than curves that one chart can tell apart each has its curve in its row of the table."""
    (table,) = (block for block in blocks if block["kind"] == "table" and block.get("curves"))
    assert [row[0] for row in table["rows"]] == [name for name in result._press.bearings_as_drawn if name in result.bearing_force]
    for row, curve in zip(table["rows"], table["curves"], strict=True):
        size = np.linalg.norm(result.bearing_force[row[0]], axis=1)
        assert_allclose(floats(curve), [*size, size[0]], rtol=1e-6, atol=1e-6 * size.max())


def test_a_press_has_its_charts(page: Any, result: Any) -> None:
    """Curves of the page against the arrays; the view's fixture sees to it that nothing went wrong in the page."""
    motion = result.motion
    curves = page.evaluate(CURVES)
    in_rows(page.evaluate("report.sections.flatMap(section => section.blocks)"), result)
    drawn = page.evaluate("[...document.querySelectorAll('.small polyline')].map(line => line.getAttribute('points').split(' ').length)")
    assert drawn == [len(motion.time) + 1] * len(result.bearing_force)
    (velocity,) = next(some for title, some in curves.items() if title.startswith("Slide velocity"))
    assert_allclose(velocity["x"], np.linspace(0, 360, len(motion.time) + 1), atol=1e-3)
    assert_allclose(velocity["y"][:-1], motion.slide_velocity, atol=1e-6)
    titles = " ".join(curves)
    for word in (HEIGHT, "Slide acceleration", "Driving torque", "Polar diagram, world axes", "Harmonics"):
        assert word in titles
    assert page.locator("tbody tr").count() > 10


def test_charts_follow_the_recording(page: Any, result: Any) -> None:
    motion = result.motion
    for i in (0, 33, 120, 179):
        page.evaluate("t => seek(t)", motion.time[i])
        for title, values in (
            ("Slide velocity", [motion.slide_velocity]),
            ("Driving torque", [result.driving_torque / 1e3]),
            ("Force in A", [result.bearing_force["A"][:, 0] / 1e3, result.bearing_force["A"][:, 2] / 1e3]),
            ("Shaking force", [result.shaking_force[:, 0] / 1e3, result.shaking_force[:, 2] / 1e3]),
        ):
            cursor = page.evaluate(CURSOR, title)
            assert cursor["x"] == pytest.approx(2 * i, abs=0.05)
            assert_allclose([shown(text) for text in cursor["values"]], [value[i] for value in values], atol=6e-4 * np.abs(values).max())
    page.locator(".chart .plot").first.scroll_into_view_if_needed()
    before = seek(page, motion.time[20])[:, 500:]
    assert np.count_nonzero(np.abs(seek(page, motion.time[60])[:, 500:] - before).max(axis=2) > 60) > 200  # cursors have moved


@pytest.mark.exhaustive
def test_the_press_stays_in_sight(page: Any) -> None:
    """However far the charts are scrolled, in a wide window and in a narrow one."""
    for width, height in (WIDE, (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        for share in (0.5, 1.0):
            page.evaluate("share => window.scrollTo(0, share * document.body.scrollHeight)", share)
            page.wait_for_timeout(50)
            box = page.evaluate("(({ left, top, right, bottom }) => [left, top, right, bottom])(element('view').getBoundingClientRect())")
            assert page.evaluate("window.scrollY") > 500
            assert box[0] >= 0
            assert box[2] <= width
            assert box[3] - box[1] > 0.28 * height
            assert page.evaluate("element('player').getBoundingClientRect().top") == pytest.approx(0, abs=1)
            assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.set_viewport_size({"width": WIDE[0], "height": WIDE[1]})
    page.wait_for_timeout(500)  # until the charts have their width again


@pytest.mark.exhaustive
def test_a_click_on_a_chart_seeks(page: Any) -> None:
    page.locator(".chart .plot").first.scroll_into_view_if_needed()
    box = page.locator(".chart .plot .nsewdrag").first.bounding_box()
    place = (box["x"] + box["width"] / 4, box["y"] + box["height"] / 2)
    page.mouse.move(*place)
    wait(page, "document.querySelectorAll('.hoverlayer text').length > 0")
    page.mouse.dblclick(*place)  # which takes a zoom back
    page.wait_for_timeout(600)
    assert page.evaluate("now") == 0
    page.mouse.click(*place)
    wait(page, "now > 0")
    assert page.evaluate("now / duration") == pytest.approx(0.25, abs=0.01)
    assert not page.evaluate("playing")


def test_nothing_is_sent_anywhere(page: Any) -> None:
    """Plotly can upload charts; here its buttons save a picture and zoom."""
    titles = page.evaluate("[...document.querySelectorAll('.modebar-btn')].map(button => button.dataset.title)")
    assert {title.lower() for title in titles} == {"download plot as a png", "zoom", "pan", "reset axes"}
    assert page.locator("a[href]").count() == 0


@pytest.mark.exhaustive
def test_zoom_takes_the_cursor_along(page: Any) -> None:
    page.evaluate("t => seek(t)", 0.3 * 60 / 70)
    page.evaluate("Plotly.relayout(document.querySelector('.plot'), { 'xaxis.range': [90, 180] })")
    assert page.evaluate(CURSOR, "Slide height")["x"] == pytest.approx(108, abs=0.1)
    page.evaluate("seek(0)")
    assert page.evaluate("document.querySelector('.plot .cursor').offsetParent") is None  # it is outside what is shown
    page.evaluate("Plotly.relayout(document.querySelector('.plot'), { 'xaxis.range': [0, 360] })")


@pytest.mark.exhaustive
def test_polar_diagrams_of_the_chosen_bearing(page: Any, press: Any, result: Any) -> None:
    page.select_option("#bearing", label="B")
    curves = page.evaluate(CURVES)
    assert "Force in B [kN]" in curves
    assert "Force in A [kN]" not in curves
    force = result.bearing_force["B"][:, [0, 2]] / 1e3
    (world,) = curves["Polar diagram, world axes [kN]"]
    assert_allclose(np.column_stack([world["x"], world["y"]])[:-1], force, atol=1e-4)
    (own,) = curves["Polar diagram, axes of coupler [kN]"]
    turn = result.motion.joint_position[:, [press.joints.index("A"), press.joints.index("B")]].sum(axis=1)  # of the coupler, x towards z
    expected = (force[:, 0] + 1j * force[:, 1]) * np.exp(-1j * turn)
    assert_allclose(np.array(own["x"])[:-1] + 1j * np.array(own["y"])[:-1], expected, atol=1e-4)
    for i in (10, 100):
        page.evaluate("t => seek(t)", result.motion.time[i])
        tip = page.evaluate(
            """() => {
                const plot = document.querySelector('.plot.square'), { xaxis, yaxis } = plot._fullLayout;
                const { left, top } = plot.querySelector('.tip').style;
                return [xaxis.p2l(parseFloat(left) - xaxis._offset), yaxis.p2l(parseFloat(top) - yaxis._offset)];
            }"""
        )
        assert_allclose(tip, force[i], atol=1e-2 * np.abs(force).max())
    scale = page.evaluate("(({ xaxis, yaxis }) => [xaxis._m, -yaxis._m])(document.querySelector('.plot.square')._fullLayout)")
    assert scale[0] == pytest.approx(scale[1], rel=1e-6)  # circles are round
    page.select_option("#bearing", label="A")


def test_legend_hides_a_curve(page: Any) -> None:
    for visible in (False, True):
        page.evaluate("document.querySelector('.legend button').click()")
        assert page.evaluate("document.querySelector('.plot').data[0].visible") is visible


@pytest.mark.exhaustive
def test_table_of_extremes(page: Any, result: Any) -> None:
    rows = page.evaluate("[...document.querySelectorAll('tbody tr')].map(row => [...row.children].map(cell => cell.textContent))")
    table = {row[0]: row[1:] for row in rows}
    smallest, _, largest, at, width, rms = table["driving torque [kN m]"]
    torque = result.driving_torque / 1e3  # in states 2 deg apart; the table's extremes are between them
    assert_allclose([shown(t) for t in (smallest, largest, width)], [torque.min(), torque.max(), np.ptp(torque)], rtol=5e-4)
    assert shown(at) == pytest.approx(2 * torque.argmax(), abs=1.0)
    assert shown(rms) == pytest.approx(np.sqrt(np.mean(torque**2)), rel=1e-4)
    figures = page.inner_text(".verdict")
    assert "301.261 mm" in figures
    assert f"{float(max(shown(largest), -shown(smallest))):.5g} kN m" in figures


def test_a_press_of_many_links_has_its_charts(tmp_path: Path) -> None:
    """From its motion alone: what the page is given; the tests above see that it shows it."""
    press = texts.shipped("thin_wall")
    result = pp.inverse_dynamics(press, pp.cycle(press, speed=SPEED, points=60))
    report = data_in(pp.report(press, result.motion, tmp_path / "out.html"))["report"]
    blocks = [block for section in report["sections"] for block in section["blocks"]]
    charts = {block["title"]: block for block in blocks if block["kind"] == "lines"}
    assert {HEIGHT, "Slide velocity", "Slide acceleration", "Driving torque", "Shaking force"} <= set(charts)
    motion, given = result.motion, {}
    for title, chart in charts.items():
        for curve in chart["curves"]:
            given[title, curve["name"]] = {"N": 1.0, "kN": 1e3, "MN": 1e6}.get(chart["unit"], 1.0) * floats(curve["y"])
    peak = max(np.linalg.norm(force, axis=1).max() for force in result.bearing_force.values())
    in_rows(blocks, result)
    assert_allclose(given["Slide velocity", "velocity"][:-1], motion.slide_velocity, atol=1e-6)
    (bearings,) = (block["bearings"] for block in blocks if block["kind"] == "bearings")
    assert [bearing["name"] for bearing in bearings] == list(press.bearings_as_drawn)
    for bearing in bearings:
        force = result.bearing_force[bearing["name"]]
        unit = {"N": 1.0, "kN": 1e3, "MN": 1e6}[bearing["unit"]]
        assert_allclose(unit * floats(bearing["frame"], 2)[:-1], force[:, [0, 2]], atol=1e-6 * peak)
    assert len(blocks[-1]["rows"]) > 10


@pytest.mark.exhaustive
def test_before_and_after_backwards(press: Any, result: Any, view: Callable[..., Any], tmp_path: Path) -> None:
    """The plain press beside the balanced one, at another number of states. Time runs to the right, though the crank turns backwards."""
    plain = pp.inverse_dynamics(press, pp.cycle(press, speed=-SPEED, points=60))
    balanced = texts.shipped("zxn2_3000b_balanced")
    after = pp.inverse_dynamics(balanced, pp.cycle(balanced, speed=-SPEED, points=90))
    with pytest.raises(pp.PinpressError, match="turns the other way"):
        pp.report(balanced, after.motion, tmp_path / "out.html", reactions=after, before=result)
    page = view(pp.report(balanced, after.motion, tmp_path / "out.html", reactions=after, before=plain), "#t=0", SMALL)
    curves = page.evaluate(CURVES)
    names = [curve["name"] for curve in curves["Shaking force [kN]"]]
    assert names == ["x", "x, before", "z", "z, before"]
    for curve, states in zip(curves["Shaking force [kN]"], (after, plain), strict=False):
        assert_allclose(curve["y"][:-1], states.shaking_force[:, 0] / 1e3, atol=1e-4)
        assert_allclose(curve["x"], np.linspace(0, -360, len(states.motion.time) + 1), atol=1e-3)
    assert len(curves["Polar diagram, world axes [kN]"]) == 2
    heads = [head.inner_text() for head in page.locator(".verdict thead th").all()]
    assert heads[1:4] == ["zxn2_3000b", "here", "change"]
    torque = [cell.inner_text() for cell in page.locator(".verdict tr", has_text="largest torque").locator("th, td").all()]
    then, now = (float(text.replace("\u2212", "-").split()[0]) for text in torque[1:3])
    assert float(torque[3].replace("\u2212", "-").removesuffix(" %")) == pytest.approx(100 * (now / then - 1), abs=0.06)
    assert "dashed: zxn2_3000b, crank at −70 r/min" in page.inner_text("#subtitle")
    rows = page.evaluate("[...document.querySelectorAll('tbody tr')].map(row => [...row.children].map(cell => cell.textContent))")
    row = next(row for row in rows if row[0] == "shaking force, x [kN]")
    finer = [pp.inverse_dynamics(each, pp.cycle(each, speed=-SPEED, points=3600)).shaking_force[:, 0] for each in (balanced, press)]
    change = 100 * (np.ptp(finer[0]) / np.ptp(finer[1]) - 1)  # the peaks, which lie between the pages' states
    assert shown(row[-2].removesuffix(" %")) == pytest.approx(change, abs=0.006)
    assert shown(row[-3]) == pytest.approx(np.ptp(finer[1]) / 1e3, rel=1e-4)
    page.evaluate("t => seek(t)", after.motion.time[30])
    assert page.evaluate(CURSOR, "Slide height")["x"] == pytest.approx(-120, abs=0.1)
    place = "parseFloat(document.querySelector('.cursor').style.left)"
    left = page.evaluate(place)
    page.evaluate("t => seek(t)", after.motion.time[45])
    assert page.evaluate(place) > left
    assert page.inner_text("#crank") == "crank −180.0°"


@pytest.mark.exhaustive
def test_run_is_over_time(view: Callable[..., Any], tmp_path: Path) -> None:
    press = texts.shipped("jf75g_125")
    load = pp.loads.Blanking(1e6, 0.006, 0.002)
    run = pp.simulate(
        press, 0.3, speed=300 * pp.RPM, flywheel=pp.drives.Flywheel(30.0), drive=pp.drives.ConstantTorque(900.0), loads=[load]
    )
    result = pp.inverse_dynamics(press, run, loads=[load])
    page = view(pp.report(press, run, tmp_path / "out.html", reactions=result), "#t=0.15", SMALL)
    curves = page.evaluate(CURVES)
    assert "Crank speed [r/min]" in curves
    torque = curves["Driving torque [N m]"]
    assert [curve["name"] for curve in torque] == ["driving torque", "drive"]
    x, y = (np.array(torque[0][name]) for name in "xy")
    states = np.abs(np.subtract.outer(run.time, x)).argmin(axis=1)  # others are at both sides of the blank's break-through
    assert_allclose(x[states], run.time, atol=1e-6)
    assert_allclose(y[states], result.driving_torque, atol=1e-5 * np.abs(result.driving_torque).max())
    assert page.evaluate(CURSOR, "Driving torque")["x"] == pytest.approx(0.15, abs=3e-4)
    height = np.interp(0.15, run.time, run.slide_position) - pp.dead_centres(press).bottom_position
    assert float(page.inner_text("#slide").removeprefix("above BDC ")[:-3]) == pytest.approx(1e3 * height, abs=0.1)
    assert "simulated run of 0.3 s" in page.inner_text("#subtitle")


@pytest.mark.exhaustive
def test_hostile_names_are_text(tmp_path: Path, view: Callable[..., Any]) -> None:
    press = load_hostile(tmp_path)
    page = view(pp.report(press, pp.cycle(press, speed=SPEED, points=36), tmp_path / "out.html"), "#t=0.1", WIDE)
    texts = page.inner_text("body")
    for name in NAMES.values():
        assert name in texts or name in page.title()
    assert page.locator("article script, article img, article b b, main script, main img, main b b").count() == 0
    assert page.inner_text("h1") == page.title() == NAMES["crank_slide"]
    assert NAMES["rod"] in page.inner_text("#legend")
    assert NAMES["P"] in page.inner_text("#labels")
    assert page.evaluate("viewer.scene_tree.find(['press']).object.children.length") == 4
    assert {HEIGHT, "Driving torque", "Shaking force"} <= {title.split(" [")[0] for title in page.evaluate(CURVES)}
    page.select_option("#bearing", label=NAMES["P"])
    page.mouse.move(800, 400)
    page.wait_for_timeout(100)
    assert f"Force in {NAMES['P']}" in page.inner_text("#charts")


def test_what_cannot_be_compared(press: Any, result: Any, tmp_path: Path) -> None:
    run = pp.simulate(press, 1.0, speed=SPEED, flywheel=pp.drives.Flywheel(2000.0))
    with pytest.raises(pp.PinpressError, match="before is over time, the motion over crank angle"):
        pp.report(press, result.motion, tmp_path / "out.html", reactions=result, before=pp.inverse_dynamics(press, run))
    assert list(tmp_path.iterdir()) == []


def test_what_rigid_mechanics_leaves_open_is_said(tmp_path: Path) -> None:
    two_rods, one_rod = texts.shipped("jf75g_125_two_point"), texts.shipped("jf75g_125")
    for press, expected in ((two_rods, True), (one_rod, False)):
        motion = pp.cycle(press, speed=SPEED, points=24)
        sections = data_in(pp.report(press, motion, tmp_path / "out.html"))["report"]["sections"]
        bearings = [bearing for section in sections for block in section["blocks"] for bearing in block.get("bearings", ())]
        assert any("force" in bearing["open"] for bearing in bearings) is expected


def test_run_under_loads_needs_its_reactions(tmp_path: Path) -> None:
    press = texts.shipped("crank_slide")
    run = pp.simulate(press, 0.5, speed=SPEED, flywheel=pp.drives.Flywheel(50.0), loads=[pp.loads.Blanking(1e3, 0.02, 0.01)])
    with pytest.raises(pp.PinpressError, match=r"the run has loads: give its reactions with them, inverse_dynamics\(press, run, loads="):
        pp.report(press, run, tmp_path / "out.html")
    idle = pp.simulate(press, 0.5, speed=SPEED, flywheel=pp.drives.Flywheel(50.0), drive=pp.drives.ConstantTorque(5.0))
    assert pp.report(press, idle, tmp_path / "out.html").exists()


@pytest.mark.exhaustive
def test_linkage_in_space_without_slide(tmp_path: Path, view: Callable[..., Any]) -> None:
    (tmp_path / "bennett.urdf").write_text(bennett(), encoding="utf-8")
    press = pp.load(tmp_path / "bennett.urdf")
    result = pp.inverse_dynamics(press, pp.cycle(press, speed=SPEED, points=60))
    page = view(pp.report(press, result.motion, tmp_path / "out.html"), "#t=0.1", SMALL)
    curves = page.evaluate(CURVES)
    assert not any(title.startswith("Slide") for title in curves)
    assert page.evaluate("[data.front.length, data.slide]") == [0, None]
    (unit,) = (title.split("[")[1][:-1] for title in curves if title.startswith("Shaking force"))
    scale = {"N": 1.0, "kN": 1e3}[unit]
    for curve, force in zip(curves[f"Shaking force [{unit}]"], result.shaking_force.T, strict=True):
        assert_allclose(scale * np.array(curve["y"])[:-1], force, atol=1e-5 * np.abs(result.shaking_force).max())
    page.click("#show-names")
    page.click("#show-forces")
    see_movement(page, result.motion.time[[0, 20, 40]], 125)


def see_movement(page: Any, times: Any, least: int) -> None:
    """At the times [s] the press is seen in poses that differ in `least` pixels or more."""
    bottom = int(page.evaluate("element('view').getBoundingClientRect().bottom"))
    pictures = [seek(page, time)[:bottom] for time in times]
    for before, after in itertools.pairwise(pictures):
        assert np.count_nonzero(np.abs(after - before).max(axis=2) > 30) > least


@pytest.mark.exhaustive
def test_several_drivers(tmp_path: Path, view: Callable[..., Any]) -> None:
    """Two cranks on one frame: a curve of torque for each, over time."""
    press = two_cranks()
    time = np.linspace(0, 1, 30)
    motion = pp.servo_cycle(press, angle=np.stack([time, -3 * time], axis=1), speed=[[1.0, -3.0]] * 30, time=time)
    result = pp.inverse_dynamics(press, motion)
    page = view(pp.report(press, motion, tmp_path / "out.html"), "#t=0.5", SMALL)
    curves = page.evaluate(CURVES)
    (torque,) = (some for title, some in curves.items() if title.startswith("Driving torque"))
    assert [curve["name"] for curve in torque] == ["fast", "slow"]
    for curve, values in zip(torque, result.driving_torque.T, strict=True):
        assert_allclose(curve["x"], time, atol=1e-8)
        assert_allclose(curve["y"], values, atol=1e-6 * np.abs(result.driving_torque).max())
    see_movement(page, [0.1, 0.9], 0)


def test_states_that_are_not_in_time(press: Any, tmp_path: Path) -> None:
    motion = pp.servo_cycle(press, angle=[0.0, 1.0, 0.5], speed=1.0)
    with pytest.raises(pp.PinpressError, match="no motion in time"):
        pp.report(press, motion, tmp_path / "out.html")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("missing", "extra"), [("plotly", "report"), ("meshcat", "recording")])
def test_without_an_extra(missing: str, extra: str, press: Any, result: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == missing else find(name))
    with pytest.raises(pp.PinpressError, match=re.escape(f"pip install 'pinpress[{extra}]'")):
        pp.report(press, result.motion, tmp_path / "out.html", reactions=result)
    assert list(tmp_path.iterdir()) == []


def test_recording_is_in_the_report(written: Path, press: Any, result: Any, tmp_path: Path) -> None:
    recording = data_in(pp.record(press, result.motion, tmp_path / "recording.html", reactions=result))
    report = data_in(written)
    assert {name: report[name] for name in recording} == recording
