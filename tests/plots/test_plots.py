"""Static plots: what is drawn against the numbers, names as they are, files to the byte, and nothing left of a failure."""

import io
import os
import subprocess
import sys
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from support import texts
from support.oracles import cassie
from support.sampling import rest_exhaustive

import pinpress as pp

matplotlib = pytest.importorskip("matplotlib")

from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.colors import to_rgb  # noqa: E402
from PIL import Image  # noqa: E402

from pinpress import plots  # noqa: E402
from pinpress.common.outlets.described import charts_of  # noqa: E402
from pinpress.dynamics.harmonics import harmonics  # noqa: E402
from pinpress.plots.style import WIDTH  # noqa: E402

NAMES = ("_P", "a$b_c^{$", "<W & co>")  # of bearings: left out of legends, broken mathematics, markup
ALL = ["torque", "bearings", "polar", "shaking"]


def in_order(reactions):
    """Bearing forces by name in the order of the drawing."""
    return {name: reactions.bearing_force[name] for name in reactions._press.bearings_as_drawn}


@pytest.fixture(scope="module")
def result():
    return turn("zxn2_3000b", 70)


@pytest.fixture(scope="module")
def balanced():
    return turn("zxn2_3000b_balanced", 70)


@pytest.fixture(scope="module")
def torque(result):
    """To be looked at and saved: to lay it out takes longer than that."""
    return plots.draw(result, "torque")


@pytest.fixture(scope="module")
def comparison(result, balanced):
    return compared(result, balanced)


@pytest.fixture(scope="module")
def run():
    press = texts.shipped("crank_slide")
    loads = [pp.loads.DeepDrawing(force=2e4, start=0.05)]
    motor = pp.drives.InductionMotor(10e3, 95 * pp.RPM, frequency=10 / 3)
    motion = pp.simulate(press, 2.0, speed=90 * pp.RPM, drive=motor, flywheel=pp.drives.Flywheel(20.0), loads=loads)
    return pp.inverse_dynamics(press, motion, loads=loads)


@pytest.fixture(scope="module")
def legs():
    press = texts.load(cassie.urdf())
    time, legs = np.linspace(0, 1, 20), np.ones(12)
    angle, speed, acceleration = (
        np.multiply.outer(law, legs) for law in (0.05 * np.sin(6 * time), 0.3 * np.cos(6 * time), -1.8 * np.sin(6 * time))
    )
    return pp.inverse_dynamics(press, pp.servo_cycle(press, speed=speed, angle=angle, acceleration=acceleration, time=time))


@pytest.fixture(scope="module")
def oddly_named():
    """The crank-slider with names that a URDF may have and Matplotlib would read as something else."""
    text = texts.shipped("crank_slide").text.decode()
    for old, new in zip(('"P"', '"O"', '"W"'), ("_P", "a$b_c^{$", "&lt;W &amp; co>"), strict=True):
        assert f"name={old}" in text
        text = text.replace(f"name={old}", f'name="{new}"')
    press = texts.load(text)
    return pp.inverse_dynamics(press, pp.cycle(press, 7.0, points=36))


def compared(before, after):
    """Torque, shaking force and peaks of two presses over each other."""
    return plots.draw(after, "torque", "shaking", "peaks", before=before)


def turn(name, speed=70.0, **more):
    press = texts.shipped(name)
    made_by = pp.servo_cycle if "angle" in more else pp.cycle
    return pp.inverse_dynamics(press, made_by(press, speed=speed * pp.RPM, **more))


def legend(owner):
    found = owner.get_legend() if hasattr(owner, "get_legend") else owner.legends[0]
    return [text.get_text() for text in found.get_texts()]


def picture(figure, tmp_path, name="plot.png"):
    plots.save(figure, tmp_path / name)
    return np.asarray(Image.open(tmp_path / name).convert("RGB"), dtype=float) / 255


def on_screen(figure):
    """Its pixels without a file, a ninth as many."""
    figure.set_dpi(100)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3] / 255


def drawn(image, colour):
    """How many pixels have a colour."""
    return int(np.count_nonzero(np.abs(image - to_rgb(colour)).max(axis=2) < 0.02))


# What is drawn


def test_slide(result):
    figure, motion = plots.draw(result, "height", "velocity", "acceleration"), result.motion
    height, velocity, acceleration = figure.axes
    titles = [axes.get_title("left") for axes in figure.axes]
    assert titles == ["Slide height above bottom dead centre", "Slide velocity", "Slide acceleration"]
    assert [axes.get_ylabel() for axes in figure.axes] == ["length [mm]", "speed [m/s]", "acceleration [m/s²]"]
    assert acceleration.get_xlabel() == "crank angle [deg]"
    x, y = height.lines[0].get_data()
    assert (x[0], x[-1]) == (0.0, pytest.approx(360.0))  # closed, though the cycle leaves its end out
    above = motion.slide_position - pp.dead_centres(texts.shipped("zxn2_3000b")).bottom_position
    np.testing.assert_allclose(y, 1e3 * np.append(above, above[0]), rtol=1e-12, atol=1e-9)
    np.testing.assert_array_equal(velocity.lines[0].get_ydata()[:-1], motion.slide_velocity)
    figure.canvas.draw()
    np.testing.assert_array_equal([x for x in acceleration.get_xticks() if 0 <= x <= 360], np.arange(9) * 45.0)
    assert [text.get_text().strip() for text in height.texts] == ["TDC", "BDC"]


def test_bearings(result):
    (axes,) = plots.draw(result, "bearings").axes
    assert legend(axes) == ["A", "B", "D", "C", "E", "slide_guide", "F"]  # in the order of the drawing
    assert axes.get_ylabel() == "force [kN]"
    for line, force in zip(axes.lines, in_order(result).values(), strict=True):
        np.testing.assert_allclose(1e3 * line.get_ydata()[:-1], np.linalg.norm(force, axis=1), rtol=1e-12)
    looks = {(line.get_color(), line.get_linestyle()) for line in axes.lines}
    assert len(looks) == len(axes.lines)


@pytest.mark.exhaustive
def test_two_halves_are_one_curve():
    (axes,) = plots.draw(turn("jf75g_125_symmetric", 300), "bearings").axes
    assert len(axes.lines) == 6
    assert legend(axes)[:2] == ["O_left,\nO_right", "P2_left,\nP2_right"]


@pytest.mark.exhaustive
def test_moments_below_the_forces():
    _, moment = plots.draw(turn("thin_wall", 72), "bearings", "moments").axes
    assert moment.get_ylabel() == "torque [N m]"
    assert len(moment.lines) == 1  # of the slot


@pytest.mark.exhaustive
def test_a_run(run):
    figure = plots.draw(run, "speed")
    assert figure.axes[0].get_title("left") == "Crank speed"
    assert (figure.axes[0].get_ylabel(), figure.axes[0].get_xlabel()) == ("rotational speed [r/min]", "time [s]")
    (axes,) = plots.draw(run, "torque").axes
    assert legend(axes) == ["driving torque", "drive"]
    np.testing.assert_allclose(axes.lines[1].get_xdata()[[0, -1]], run.motion.time[[0, -1]])
    assert "Mean: x" in charts_of(run.described())["harmonics"].note


def test_shaking(result):
    top, bottom = plots.draw(result, "shaking", "harmonics").axes
    assert legend(top) == ["x", "z"]
    found = harmonics(result.motion, result.shaking_force)
    heights = [[bar.get_height() for bar in bars] for bars in bottom.containers]
    np.testing.assert_allclose(heights, 1e-3 * found.amplitude[1:, [0, 2]].T, rtol=1e-14)
    assert charts_of(result.described())["harmonics"].note == "Mean: x 0 kN, z −113 kN."
    assert bottom.get_ylabel() == "force [kN]"


def test_shaking_of_less_than_a_turn():
    press = texts.shipped("crank_slide")
    motion = pp.servo_cycle(press, speed=7.0, angle=np.linspace(0, 3, 40))
    assert "harmonics" not in charts_of(pp.inverse_dynamics(press, motion).described())


@pytest.mark.exhaustive
def test_polar(result):
    figure = plots.draw(result, "polar")
    diagrams = [axes for axes in figure.axes if axes.get_title()]
    assert [axes.get_title().strip() for axes in diagrams] == list(in_order(result))
    figure.canvas.draw()
    for axes, (name, force) in zip(diagrams, in_order(result).items(), strict=True):
        across, up = axes.transData.transform([(1.0, 0.0), (0.0, 1.0)]) - axes.transData.transform((0.0, 0.0))
        assert across[0] == pytest.approx(up[1], rel=1e-9)  # a circle is round
        paths = {line.get_linestyle(): line.get_xydata() for line in axes.lines if len(line.get_xdata()) == 361}
        np.testing.assert_allclose(1e3 * paths["-"][:-1], force[:, [0, 2]], rtol=1e-12, atol=1e-6)
        assert ("--" in paths) == (charts_of(result.described())[f"polar {name}"].link != "slide")  # the slide does not turn
        assert np.hypot(*paths["-"].T).max() <= axes.get_xlim()[1] / 1.15
        words = [text.get_text() for text in axes.texts]
        assert "x" in words
        assert "z" in words
        assert any(word.endswith(" kN") for word in words)


def test_polar_marks(result):
    """Dots of the quarters lie on the path at these crank angles, each nearer to its label than to another's."""
    (axes,) = plots.draw(result, "polar A").axes
    dots = np.array([line.get_xydata()[0] for line in axes.lines if len(line.get_xdata()) == 1 and line.get_color() == "#0072B2"])
    np.testing.assert_allclose(1e3 * dots, result.bearing_force["A"][::90, [0, 2]], rtol=1e-12)
    labels = {text.get_text(): text.xy for text in axes.texts if text.get_color() == "#0072B2"}  # type: ignore[attr-defined]
    assert list(labels) == ["0", "90", "180", "270"]
    away = np.linalg.norm(dots[:, None] - np.array(list(labels.values())), axis=2)
    np.testing.assert_array_equal(away.argmin(axis=0), [0, 1, 2, 3])


@pytest.mark.exhaustive
def test_polar_of_a_run_is_its_last_turn(run):
    figure = plots.draw(run, "polar O")
    paths = [line for line in figure.axes[0].lines if line.get_color() == "#0072B2" and len(line.get_xdata()) > 20]
    angle = run.motion.crank_angle
    inside = np.count_nonzero(angle > angle[-1] - 2 * np.pi)
    assert abs(len(paths[0].get_xdata()) - inside) <= 1


def test_charts_that_a_result_does_not_have_are_refused(result, legs):
    for shown, charts, message in ((result, ("polar A", "polar Z"), "no chart 'polar Z'"), (legs, ("velocity",), "no chart 'velocity'")):
        with pytest.raises(pp.UnknownNameError, match=message):
            plots.draw(shown, *charts)


@pytest.mark.exhaustive
def test_comparison(result, balanced, comparison):
    """The changes are those of tests/dynamics/test_reference.py's paper: docs/kong2025.md."""
    torque, shaking, bars = comparison.axes
    assert torque.get_title("left") == "Driving torque, range −1.7 %"
    assert legend(shaking) == ["x", "z"]
    curves = shaking.lines  # that before in front of each
    for line, reactions, axis in zip(curves, (result, balanced) * 2, (0, 0, 2, 2), strict=True):
        np.testing.assert_allclose(1e3 * line.get_ydata()[:-1], reactions.shaking_force[:, axis], rtol=1e-12, atol=1e-9)
    peaks = [[1e-3 * np.linalg.norm(force, axis=1).max() for force in in_order(r).values()] for r in (result, balanced)]
    np.testing.assert_allclose([[bar.get_width() for bar in group] for group in bars.containers], peaks, rtol=1e-3)  # between the states
    assert [text.get_text() for text in bars.get_yticklabels()] == list(in_order(result))
    widths = [[bar.get_width() for bar in group] for group in bars.containers]
    assert bars.texts[0].get_text() == f"{100 * (widths[1][0] / widths[0][0] - 1):+.1f} %"


@pytest.mark.exhaustive
def test_comparison_has_the_peaks_at_a_step_of_the_load():
    """The peaks of one press under one load do not depend on the states: 99.570 kN in W, where the load begins."""
    press = texts.shipped("crank_slide")
    loads = [pp.loads.ConstantForce(1e5, 0.03)]
    coarse, fine = (pp.inverse_dynamics(press, pp.cycle(press, 10.0, points=points), loads) for points in (72, 720))
    bars = compared(coarse, fine).axes[-1]
    widths = [[bar.get_width() for bar in group] for group in bars.containers]
    largest = {each.quantity: each.largest for each in pp.measures.extremes(fine)}
    expected = [1e-3 * largest[f"force in {name}, magnitude"] for name in in_order(fine)]
    np.testing.assert_allclose(widths, [expected, expected], rtol=1e-6)


@pytest.mark.exhaustive
def test_comparison_in_one_unit():
    """Slowly, the crank-slider shakes with 200 N along x, at speed with kilonewtons; a force that was nothing has no percentage."""
    slow, fast = turn("crank_slide", 10), turn("crank_slide", 400)
    axes = compared(slow, fast).axes[1]
    assert axes.get_ylabel() == "force [kN]"
    x = [line for line in axes.lines if line.get_color() == axes.lines[0].get_color()]
    for line, reactions in zip(x, (slow, fast), strict=True):  # below 10 kN the one, above it the other
        np.testing.assert_allclose(1e3 * line.get_ydata()[:-1], reactions.shaking_force[:, 0], rtol=1e-12, atol=1e-9)
    first, second = (turn(name, 300) for name in ("jf75g_125", "jf75g_125_symmetric"))
    bars = compared(first, second).axes[-1]
    assert [label.get_text() for label in bars.get_yticklabels()] == ["slide_guide", "counterweight_guide"]
    assert [text.get_text() for text in bars.texts] == ["−100.0 %"] * 2
    assert [text.get_text() for text in compared(second, first).axes[-1].texts] == ["0 before"] * 2


@pytest.mark.exhaustive
def test_nothing_to_compare(result, legs, run):
    with pytest.raises(pp.PinpressError, match="no place of peak bearing forces of one name: there is nothing to compare"):
        plots.draw(result, "peaks", before=legs)
    with pytest.raises(pp.PinpressError, match="drawn over time, the other over crank angle: compare two cycles, or two runs"):
        compared(turn("crank_slide"), run)
    with pytest.raises(pp.PinpressError, match="one motion turns forwards, the other backwards"):
        compared(turn("crank_slide"), turn("crank_slide", -70.0))


@pytest.mark.exhaustive
def test_several_drivers(legs):
    (axes,) = plots.draw(legs, "torque").axes
    assert legend(axes) == list(legs.motion.drivers)
    assert len({(line.get_color(), str(line._dash_pattern)) for line in axes.lines}) == 12  # type: ignore[attr-defined]
    polar = (f"polar {name}" for name in list(legs.bearing_force)[:2])
    for figure in (compared(legs, legs), plots.draw(legs, *polar), plots.draw(legs, "shaking"), plots.draw(legs, "bearings")):
        assert on_screen(figure).min() < 0.5


@pytest.mark.parametrize("angle", [[0.3], [0.0, 2.0, 1.0], np.linspace(6.0, 0.5, 30)])
@pytest.mark.exhaustive
def test_states_of_any_kind(angle):
    """One state; states not in time; a crank that turns backwards, whose time runs to the right."""
    press = texts.shipped("crank_slide")
    reactions = pp.inverse_dynamics(press, pp.servo_cycle(press, speed=-1.0, angle=angle))
    figures = [plots.draw(reactions, name) for name in ALL]
    for figure in figures:
        assert drawn(on_screen(figure), "#0072B2") > 20
    left, right = figures[ALL.index("torque")].axes[0].get_xlim()
    assert len(angle) != 30 or left > right


# Names


@pytest.mark.parametrize("plot", [*ALL, "height", "peaks"])
@pytest.mark.exhaustive
def test_names_are_text(oddly_named, plot, tmp_path):
    assert set(NAMES) < set(oddly_named.bearing_force)
    figure = plots.draw(oddly_named, plot)
    for suffix in (".svg", ".png", ".pdf") if plot == "bearings" else (".svg",):
        plots.save(figure, tmp_path / f"plot{suffix}")  # raises where a "$" is mathematics
    ElementTree.parse(tmp_path / "plot.svg")
    shown = [
        text for text in figure.findobj(matplotlib.text.Text) if set(text.get_text().split()) & {"_P", "a$b_c^{$"} and text.get_visible()
    ]
    assert not any(text.get_parse_math() for text in shown)
    assert bool(shown) == (plot in ("bearings", "polar", "peaks"))


@pytest.mark.exhaustive
def test_a_name_that_begins_with_an_underscore_is_in_the_legend(oddly_named):
    (axes,) = plots.draw(oddly_named, "bearings").axes
    assert set(legend(axes)) == set(oddly_named.bearing_force)
    figure = io.BytesIO()
    axes.figure.savefig(figure, format="png")
    assert all(text.get_window_extent().width > 5 for text in axes.get_legend().get_texts())


# Files


STYLE = {"font.size": 20, "lines.linewidth": 9, "axes.grid": False, "figure.dpi": 40, "svg.fonttype": "none"}  # the caller's own


@pytest.fixture(scope="module")
def twice(balanced):
    """One plot, made in the default style and in another."""
    first = plots.draw(balanced, "polar A", "polar B")
    with matplotlib.rc_context(STYLE):
        return first, plots.draw(balanced, "polar A", "polar B")


@pytest.mark.one_in(3)
@pytest.mark.parametrize("suffix", [".svg", ".png", ".pdf"])
def test_same_bytes(suffix, twice, tmp_path):
    """Also saved twice, and where the caller has a style of his own."""
    first, second = twice
    for name in ("a", "b"):
        assert plots.save(first, tmp_path / f"{name}{suffix}") == tmp_path / f"{name}{suffix}"
    with matplotlib.rc_context(STYLE):
        plots.save(second, tmp_path / f"c{suffix}")
    contents = {(tmp_path / f"{name}{suffix}").read_bytes() for name in "abc"}
    assert len(contents) == 1
    assert sorted(os.listdir(tmp_path)) == [f"{name}{suffix}" for name in "abc"]


@pytest.mark.parametrize("figure", rest_exhaustive(["torque", "comparison"], "torque"))
def test_a_picture_for_a_column(request, figure, tmp_path):
    image = picture(request.getfixturevalue(figure), tmp_path)
    assert image.shape[1] == int(16 / 2.54 * 300)
    assert drawn(image, "#0072B2") > 5000
    assert drawn(image, "#b0b0b0") > 5000 or figure == "torque"  # of what was before
    assert drawn(image, "white") > 0.5 * image.shape[0] * image.shape[1]
    border = np.concatenate([image[0], image[-1], image[:, 0], image[:, -1]])
    assert (border == 1.0).mean() > 0.99  # nothing is cut off


def test_svg_has_the_curve(torque, tmp_path):
    plots.save(torque, tmp_path / "torque.svg")
    root = ElementTree.parse(tmp_path / "torque.svg").getroot()
    assert root.get("width") == f"{16 / 2.54 * 72:.6f}pt"
    paths = [path.get("d") for path in root.iter("{http://www.w3.org/2000/svg}path") if "#0072b2" in (path.get("style") or "").lower()]
    assert any(path.count("L") > 100 for path in paths)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("plot.xyz", r"plot.xyz: end its name in \.svg, \.png, \.pdf"),
        ("plot", "end its name in"),
        ("gone/plot.svg", "cannot write .*gone/plot.svg"),
    ],
)
def test_paths_that_cannot_be_written(torque, path, message, tmp_path):
    with pytest.raises(pp.PinpressError, match=message):
        plots.save(torque, tmp_path / path)
    assert not list(tmp_path.iterdir())


def test_a_failure_leaves_the_file_as_it_was(torque, tmp_path, monkeypatch):
    file = tmp_path / "plot.svg"
    file.write_text("before")
    monkeypatch.setattr(torque, "savefig", lambda content, **_: content.write(b"<svg") and 1 / 0)
    with pytest.raises(ZeroDivisionError):
        plots.save(torque, file)
    assert file.read_text() == "before"
    assert list(tmp_path.iterdir()) == [file]


# Around it


def test_a_curve_that_is_not_finite_is_refused(result):
    torque = np.array(result.driving_torque)
    torque[7] = np.inf
    with pytest.raises(pp.PinpressError, match="driving torque is not finite at index 7"):
        plots.draw(replace(result, driving_torque=torque), "torque")


def test_without_matplotlib(result, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(pp.PinpressError, match=r"pip install 'pinpress\[plots\]'"):
        plots.draw(result, "torque")


@pytest.mark.exhaustive
def test_no_global_state(tmp_path):
    """Importing takes no Matplotlib, drawing no pyplot, and the caller's style is as it was."""
    code = """
import sys
import pinpress as pp
from pinpress import plots
from pinpress.dynamics import harmonics
from pinpress.dynamics import described
from pinpress.dynamics import extremes
assert "matplotlib" not in sys.modules
import matplotlib
def style():  # but for the backend, as asking for it imports pyplot
    return {name: matplotlib.rcParams[name] for name in matplotlib.rcParams if name != "backend"}
before = style()
press = pp.load("crank_slide")
result = pp.inverse_dynamics(press, pp.cycle(press, 7.0, points=24))
for figure in (plots.draw(result, "polar O"), plots.draw(result, "torque", before=result)):
    figure.savefig(sys.argv[1], dpi=50)
assert "matplotlib.pyplot" not in sys.modules
assert style() == before
"""
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "plot.png")], check=True, timeout=120)


def test_a_notebook_shows_a_plot_as_a_picture_without_pyplot(torque):
    formatters = pytest.importorskip("IPython.core.formatters")
    shown, _ = formatters.DisplayFormatter().format(torque)
    width, _ = Image.open(io.BytesIO(shown["image/png"])).size
    assert width == pytest.approx(110 * WIDTH / 2.54, abs=1)
