"""Charts of results of all rooms, drawn and in reports, show the numbers of these results."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support import every_result, texts
from support.in_browser import chart, curves, sections

import pinpress as pp
from pinpress.common.outlets.described import Bars, Chart, charts_of
from pinpress.common.quantities import quantity as quantity_of
from pinpress.common.results import Tabular

pytest.importorskip("matplotlib")
from matplotlib.patches import Rectangle

tol = pp.tolerances


def widths(axes):
    return [bar.get_width() for bar in axes.patches if isinstance(bar, Rectangle)]


# Whatever is described


def sizes(axes):
    """Lengths of bars, of either direction."""
    return np.abs([length for bar in axes.patches if isinstance(bar, Rectangle) for length in (bar.get_width(), bar.get_height())])


@pytest.mark.exhaustive
def test_every_curve_and_bar_of_every_result_is_drawn_as_it_is_described():
    """In the unit of the axis; the numbers that results describe are tested on pages, in `tests/visual/test_report_results.py`."""
    count = 0
    for result in {type(each): each for each in every_result.made() if isinstance(each, Tabular)}.values():
        for name, described in charts_of(result.described()).items():
            if not isinstance(described, Chart | Bars) or described.stacked:
                continue
            axes = pp.plots.draw(result, name).axes[0]
            label = axes.get_xlabel() if "[" in axes.get_xlabel() and isinstance(described, Bars) else axes.get_ylabel()
            unit = factor(label, described.quantity)
            curves_drawn = [np.asarray(line.get_ydata(), float) for line in axes.lines]
            for curve in described.curves if isinstance(described, Chart) else ():
                y, n = unit * curve.y, len(curve.y)  # a turn is closed by its first state
                assert any(
                    len(other) >= n and np.allclose(other[:n], y, atol=1e-9 * np.abs(y).max(), equal_nan=True) for other in curves_drawn
                )
                count += 1
            for values in described.series.values() if isinstance(described, Bars) else ():
                lengths = unit * np.abs(values)
                assert np.nanmax(np.abs(lengths[:, None] - sizes(axes)).min(axis=1)) <= 1e-9 * np.nanmax(lengths)
                count += 1
    assert count > 200


# Maps


def test_a_map_has_the_values_at_their_places():
    press = texts.shipped("crank_slide")
    speeds, forces = np.array([14.0, 7.0, 10.0]), np.array([0.0, 2e4])
    found = pp.sweeps.operating_points(press, speeds, forces=forces, unit_load=pp.loads.ConstantForce(1.0, 0.02))
    axes = pp.plots.draw(found, "map largest_driving_torque").axes[0]
    mesh: Any = axes.collections[0]
    assert len(axes.collections) == 1
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("force [kN]", "speed [r/min]")
    places = np.asarray(mesh.get_coordinates())
    assert places[:, 0, 1] == pytest.approx(np.sort(speeds) / pp.RPM)
    assert places[0, :, 0] == pytest.approx(1e-3 * forces)
    values = np.asarray(mesh.get_array()).reshape(3, 2)
    assert values == pytest.approx(found.grid("largest_driving_torque")[[1, 2, 0]], rel=1e-12)
    alone = pp.sweeps.operating_points(press, [7.0], forces=forces, unit_load=pp.loads.ConstantForce(1.0, 0.02))
    with pytest.raises(pp.PinpressError, match="has no charts"):
        pp.plots.draw(alone)


@pytest.mark.exhaustive
def test_each_result_has_a_map():
    found = pp.sweeps.operating_points(
        texts.shipped("crank_slide"), [7.0, 14.0], forces=[0.0, 2e4], unit_load=pp.loads.ConstantForce(1.0, 0.02)
    )
    assert len(pp.plots.draw(found, "map").axes) == len(found.results)


def test_a_map_has_the_singular_poses_over_its_colours():
    reach = every_result.workspace()
    axes = pp.plots.draw(reach, "map frame").axes[0]
    (points,) = axes.lines
    assert len(reach.dead_points) >= 5
    assert np.column_stack(points.get_data()) == pytest.approx(np.degrees(reach.dead_points))
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("hip [deg]", "crank [deg]")
    mesh: Any = axes.collections[0]
    values = np.asarray(mesh.get_array()).reshape(5, 5)
    assert values == pytest.approx(reach.frame_margin.T)


def test_orders_stand_next_to_calculated_frequencies():
    orders, modes = every_result.vibrations().order_spectra(3), pp.foundation.modes(every_result.mounted())
    axes = pp.plots.draw(orders.with_modes(modes), "orders Ax").axes[0]
    highest = orders.order[-1] * orders.speed[-1]
    expected = [w / (2 * np.pi) for w in modes.natural_frequency if w < highest]
    assert expected
    assert [line.get_ydata()[0] for line in axes.lines] == pytest.approx(expected)
    with pytest.raises(pp.PinpressError, match="modes is a int, no VibrationModes"):
        orders.with_modes(3)


# Accuracy of the slide, and tolerances


@pytest.fixture(scope="module")
def crank():
    return texts.shipped("crank_slide")


@pytest.fixture(scope="module")
def played(crank):
    return tol.play(crank, pp.cycle(crank, 15.0, points=72), {"W": 5e-5, "slide_guide": tol.GuideClearance(2e-5, 0.2)})


@pytest.fixture(scope="module")
def budget(crank):
    springs = pp.elasticity.Stiffness({"W": 1e9})
    warm = tol.Temperatures({"rod": 10.0})
    machining = tol.bottom_dead_centre(crank, [tol.link_length(crank, "P", "W", 1e-5)], samples=5000)
    return tol.budget(
        crank, speeds=[1.0, 15.0], clearance={"W": 5e-5}, stiffness=springs, temperatures=warm, process=2e4, machining=machining
    )


def test_sections_of_a_report(crank, played, budget, tmp_path):
    over, warm = tol.play_over_speeds(crank, {"W": 5e-5}, speed=[5.0, 15.0]), tol.heat(crank, tol.Temperatures({"rod": -10.0}))
    found = sections(pp.report(crank, played.motion, tmp_path / "page.html", results=[played, over, warm, budget]))
    closed = np.append(played.offset, played.offset[0])  # the turn ends where it began
    assert curves(chart(found["Slide in its clearances"], "Slide in its clearances"))["slide"][1] == pytest.approx(1e6 * closed, rel=1e-5)
    rows = chart(found["Slide in its clearances"], "Forces that reverse")["rows"]
    assert [row[:2] for row in rows] == [[each.bearing, each.side] for each in played.reversals]
    tops = curves(chart(found["Dead centres in the clearances over the speed"], "Dead centres"))["top dead centre"][1]
    assert tops == pytest.approx(1e6 * over.top_shift, rel=1e-5)
    assert found["Heat"]["blocks"][1]["rows"][0][1:3] == ["-10.000", "48.000"]
    accuracy = found["Accuracy of bottom dead centre"]
    rise = curves(chart(accuracy, "Rise of bottom dead centre"))["process, warm"][1]
    assert rise == pytest.approx([1e3 * each.rise for each in budget.conditions if each.condition == "process, warm"], rel=1e-5)
    (table,) = [block for block in accuracy["blocks"] if block.get("title") == ""]
    assert table["rows"][0][:2] == ["9.55", "idle"]
    assert chart(accuracy, "Parts of bottom dead centre")["bars"]["heat"][-1] == pytest.approx(-48)


@pytest.mark.exhaustive
def test_parallelism_in_a_report(tmp_path):
    press = texts.shipped("jf75g_125_two_point")
    rods = {point: [tol.link_length(press, point.replace("4", "2"), point, 2e-5)] for point in ("P4_front", "P4_back")}
    found = tol.parallelism(press, rods, samples=1000)
    page = pp.report(press, pp.cycle(press, 30.0, points=24), tmp_path / "page.html", results=[found])
    section = sections(page)["Parallelism on 2 points"]
    three = curves(chart(section, "Three standard deviations over the turn"))["slope along (0, 1, 0)"][1]
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


@pytest.fixture(scope="module")
def scattered(crank):
    parts = [tol.link_length(crank, "O", "P", 2e-5), tol.link_length(crank, "P", "W", 4e-5)]
    return tol.bottom_dead_centre(crank, parts, samples=4000)


def test_tolerances_in_a_report(crank, scattered, tmp_path):
    cheapest = tol.allocate(crank, scattered.parts, None, {"height": 2e-5})
    motion = pp.cycle(crank, 7.0, points=24)
    found = sections(pp.report(crank, motion, tmp_path / "page.html", results=[scattered, cheapest]))
    scatter, allocated = found["Dead centres and tolerances"], found["Cheapest tolerances"]
    assert "4000 presses with lengths of their own. Bottom dead centre: PW makes 80 % of the variance" in scatter["note"]
    bars = chart(scatter, "Shares of the variance")
    assert (bars["places"], bars["bars"]["bottom dead centre"]) == (["PW", "OP"], pytest.approx([80.0, 20.0]))
    assert curves(chart(scatter, "Presses of the sample"))["presses"][1][::2].sum() == pytest.approx(100.0, rel=1e-5)
    low, high = (f"{1e6 * end:.2f}" for end in scattered.height.band())
    assert scatter["blocks"][0]["figures"][0]["value"] == f"{low} to {high} µm"
    assert allocated["blocks"][1]["rows"][0][:2] == ["OP", f"{1e3 * cheapest.tolerances[0]:.4g} mm"]


# Parameters that records reveal


def test_bars_end_at_the_doubts():
    press, time = pp.load("crank_slide"), np.linspace(0, 4, 801)
    run = pp.measured.MeasuredRun(time, 8 * time + np.sin(2.5 * time))
    found = pp.measured.identifiability(press, [run], friction=("crank",))
    figure = pp.plots.draw(found, "doubt")
    assert widths(figure.axes[0]) == pytest.approx(
        [each.torque for each in found.parameters] + [each.shaking for each in found.parameters], abs=1e-12
    )
    assert figure.axes[0].get_yticklabels()[0].get_text() == found.parameters[0].name
    with pytest.raises(pp.PinpressError, match="Give runs"):
        pp.plots.draw(pp.measured.identifiability(press))


# Ratings


@pytest.fixture(scope="module")
def rated():
    capacities = pp.ratings.Capacities(3e6, nominal_height=0.013, bearings={"A": 2e6}, flywheel_inertia=4000.0, speed_drop=0.3)
    return pp.ratings.rate(texts.shipped("zxn2_3000b"), 70 * pp.RPM, capacities, points=61)


@pytest.fixture(scope="module")
def figure(rated):
    return pp.plots.draw(rated, "force", "near_bottom", "work")


def named(axes):
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    return dict(zip(names, [line for line in axes.get_lines() if line.get_linewidth() > 0.7], strict=True))


def test_hyperbolas_are_of_one_energy(figure):
    for axes in figure.axes[:2]:
        guides = [line for line in axes.get_lines() if line.get_linewidth() < 0.7]
        assert len(guides) == 4
        for line in guides:
            energy = line.get_xdata() * line.get_ydata()
            np.testing.assert_allclose(energy, energy[0], rtol=1e-12)


@pytest.mark.exhaustive
def test_the_process_is_drawn_beside_what_is_permitted(rated):
    press = texts.shipped("zxn2_3000b")
    reactions = pp.inverse_dynamics(press, pp.cycle(press, 70 * pp.RPM, points=90), [pp.loads.DeepDrawing(1e6, 0.04)])
    figure = pp.plots.draw(rated, "force", page=reactions)
    line = named(figure.axes[0])["process force"]
    np.testing.assert_allclose(line.get_ydata()[:-1], reactions.process_force / 1e3)
    np.testing.assert_allclose(line.get_xdata()[:-1], 1e3 * (reactions.motion.slide_position - pp.dead_centres(press).bottom_position))
    other = pp.inverse_dynamics(texts.shipped("crank_slide"), pp.cycle(texts.shipped("crank_slide"), 7.0, points=12))
    with pytest.raises(pp.PinpressError, match="the reactions belong to crank_slide, but the ratings to zxn2_3000b"):
        pp.plots.draw(rated, page=other)


@pytest.mark.exhaustive
def test_a_press_that_only_its_nominal_force_limits():
    rated = pp.ratings.rate(texts.shipped("crank_slide"), 9.0, pp.ratings.Capacities(1e5), points=11)
    assert pp.plots.draw(rated, "force").axes[0].get_xlim() == (0.0, pytest.approx(200.0))


# Servo motions

MOTOR = pp.servo.CatalogueMotor("short", 0.5, [0.0, 100.0, 200.0], [300.0, 280.0, 140.0], [800.0, 800.0, 400.0])
CHARTS = "height", "crank_speed", "torque", "power"


def factor(label, quantity):
    """Shown units in one SI unit, by the label of an axis; 1 of a plain number."""
    unit = label.partition("[")[2].strip("]")
    return 1 / quantity_of(quantity).sizes()[unit] if unit else 1.0


@pytest.mark.exhaustive
def test_curves_and_limits():
    press = pp.load("crank_slide")
    motion = pp.servo.motion_by_law(
        press, pp.servo.ServoDrive(inertia=2.0, ratio=5.0, peak_torque=500.0, top_speed=90.0), "cubic", time=1.0, path=pp.servo.Stop()
    )
    even = pp.servo.constant_crank_speed(press, pp.servo.ServoDrive(inertia=2.0, ratio=5.0), time=1.0)
    height, speed, torque, power = pp.plots.draw({"cubic": motion, "even": even}, *CHARTS).axes
    for axes, values, quantity in (
        (height, motion.height, "length"),
        (speed, motion.speed, "rotational speed"),
        (torque, motion.motor_torque, "torque"),
        (power, motion.power, "power"),
    ):
        x, y = axes.lines[0].get_xydata().T
        assert np.array_equal(x, motion.time)
        np.testing.assert_allclose(y, factor(axes.get_ylabel(), quantity) * values, rtol=1e-12)
        assert np.array_equal(axes.lines[1].get_xdata(), even.time)
    assert [line.get_ydata()[0] for line in speed.lines[2:]] == pytest.approx([18.0 / pp.RPM])
    assert [line.get_ydata()[0] for line in torque.lines[2:]] == [500.0, -500.0]
    assert len(power.lines) == 2


def test_torque_is_below_the_curves_of_the_drive():
    motion = pp.servo.constant_crank_speed(pp.load("crank_slide"), MOTOR.drive(10.0), time=1.0)
    torque, dot, peak, rated = pp.plots.draw(motion, "plane").axes[0].lines
    assert torque.get_ydata() == pytest.approx(np.abs(motion.motor_torque))
    assert dot.get_xydata()[0] == pytest.approx([10 * 60.0, motion.rms_motor_torque])
    assert peak.get_ydata() == pytest.approx(MOTOR.peak_torque_at(peak.get_xdata() * pp.RPM))
    assert (peak.get_xdata()[-1], set(rated.get_ydata())) == (pytest.approx(200.0 / pp.RPM), {300.0})


# Presses on springs

PRESS = texts.shipped("zxn2_3000b")
STIFFNESS = pp.elasticity.Stiffness(dict.fromkeys("ABCDEF", 2000000000.0), shaft=3e7, frame=4e9)


def test_parts_are_stacked_to_the_whole():
    found = pp.elasticity.compliance(PRESS, STIFFNESS, angle=np.linspace(0.0, 6.0, 25))
    axes = pp.plots.draw(found, "compliance").axes[0]
    top = axes.collections[-1].get_paths()[0].vertices[:, 1].max()
    assert top == pytest.approx(1e9 * found.compliance.max(), rel=1e-12)
    assert {text.get_text() for text in axes.get_legend().get_texts()} <= {*found.parts, "others"}


@pytest.mark.parametrize("names", [("P", "W"), ("W", "P")])
def test_rounding_does_not_choose_the_order(names):
    """Of parts that yield alike, in the text and in the chart, the one that was given first comes first."""
    found = pp.elasticity.compliance(
        texts.shipped("crank_slide"), pp.elasticity.Stiffness(dict.fromkeys(names, 1e9)), angle=np.linspace(0.0, 6.0, 25)
    )
    half = 0.5 * found.compliance
    alike = dict(zip(names, (half, half * (1 + 1e-13)), strict=True))
    found = replace(found, parts=alike, bottom_shares=dict(zip(names, (0.5, 0.5 * (1 + 1e-13)), strict=True)))
    lines = str(found).splitlines()
    assert [line.split()[0] for line in lines[-2:]] == list(names)
    assert [text.get_text() for text in pp.plots.draw(found, "compliance").axes[0].get_legend().get_texts()] == list(names)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", range(3))
def test_plot_and_report_rank_the_parts_alike(tmp_path, seed):
    """Stiffnesses over a decade: the plot's legend, from the top, and the report's curves have the parts in one order."""
    rng = np.random.default_rng(seed)
    stiffness = pp.elasticity.Stiffness({name: 10 ** rng.uniform(8.8, 9.8) for name in PRESS.bearings}, shaft=3e7)
    found = pp.elasticity.compliance(PRESS, stiffness, angle=np.linspace(0.0, 6.0, 25))
    legend = [text.get_text() for text in pp.plots.draw(found, "compliance").axes[0].get_legend().get_texts()]
    pp.report(PRESS, pp.cycle(PRESS, speed=7.0, points=12), tmp_path / "report.html", results=[found])
    reported = [name for name in curves(chart(sections(tmp_path / "report.html")["Elastic press"], "Compliance")) if name != "others"]
    assert legend[: len(reported)] == reported


def test_a_chart_of_nothing_is_refused():
    with pytest.raises(pp.PinpressError, match="there is nothing to draw"):
        pp.plots.draw({}, "shift")


def test_resonances_are_dots_of_a_campbell_diagram():
    press = texts.shipped("crank_slide")
    elastic = pp.elasticity.Elastic(pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 2e8), moments={"slide_guide": 2e7}))
    diagram = pp.elasticity.campbell(press, elastic, speeds=[100.0, 500.0], orders=3)
    *_, dots = pp.plots.draw(diagram, "campbell").axes[0].lines
    meeting = [[each.speed / pp.RPM, each.order * each.speed / (2 * np.pi)] for each in diagram.resonances if 100 <= each.speed <= 500]
    assert meeting
    np.testing.assert_allclose(dots.get_xydata(), meeting)
