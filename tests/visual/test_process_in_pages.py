"""Process loads in recordings and reports: the arrow on the slide, force over height, work, and the inputs that a page states."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support import texts
from support.in_browser import chart, curves, data_in, floats, sections

import pinpress as pp
from pinpress.simulation.run import inputs_of

SPEED = 70 * pp.RPM
LOAD = pp.loads.DeepDrawing(1.5e6, 0.04, 0.002)
VALUE = """([time, title]) => {
    seek(time);
    const box = [...document.querySelectorAll('.chart')].find(box => box.querySelector('h3')?.textContent.startsWith(title));
    return box.querySelector('.legend output').textContent;
}"""
ARROW = """time => {
    setPlaying(false);
    seek(time);
    const { group, parts: [,, shaft, head] } = arrows.at(-1), along = new THREE.Vector3(0, 1, 0).applyQuaternion(group.quaternion);
    const tip = group.position.clone().addScaledVector(along, shaft.scale.y + head.scale.y);
    return { shown: group.visible, foot: group.position.toArray(), tip: tip.toArray() };
}"""


@pytest.fixture(scope="module")
def press() -> Any:
    return texts.shipped("zxn2_3000b")


@pytest.fixture(scope="module")
def pressed(press: Any) -> Any:
    return pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=180), [LOAD])


@pytest.fixture(scope="module")
def ratings(press: Any) -> Any:
    return pp.ratings.rate(press, SPEED, pp.ratings.Capacities(3e6, nominal_height=0.013))


@pytest.fixture(scope="module")
def written(press: Any, pressed: Any, ratings: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    idle = pp.inverse_dynamics(press, pressed.motion)
    path = tmp_path_factory.mktemp("report") / "out.html"
    return pp.report(press, pressed.motion, path, reactions=pressed, before=idle, results=[ratings])


def height(press: Any, motion: Any) -> Any:
    """[mm]"""
    return 1e3 * (motion.slide_position - pp.dead_centres(press).bottom_position)


def test_the_force_acts_on_the_slide(press: Any, pressed: Any, tmp_path: Path) -> None:
    data = data_in(pp.record(press, pressed.motion, tmp_path / "out.html", reactions=pressed))
    force, place = (floats(data["process"][name], 3) for name in ("force", "place"))
    assert_allclose(force[:-1], np.outer(pressed.process_force, [0, 0, 1]), rtol=1e-6)
    assert_allclose(place[:-1, 2], pressed.motion.slide_position, rtol=1e-6)
    others = [*pressed.bearing_force.values(), pressed.shaking_force]
    assert data["peak"] == max(*(np.linalg.norm(other, axis=1).max() for other in others), pressed.process_force.max())
    idle = pp.inverse_dynamics(press, pressed.motion)
    assert data_in(pp.record(press, idle.motion, tmp_path / "idle.html", reactions=idle))["process"] is None


@pytest.mark.exhaustive
def test_the_arrow_pushes_the_slide_up(written: Path, shared_view: Callable[..., Any], pressed: Any) -> None:
    page = shared_view(written, (1000, 500))
    most = int(pressed.process_force.argmax())
    arrow = page.evaluate(ARROW, float(pressed.motion.time[most]))
    assert arrow["shown"]
    assert_allclose(arrow["tip"][2], pressed.motion.slide_position[most], atol=1e-5)
    assert arrow["foot"][2] < arrow["tip"][2] - 0.1
    assert "process force" in page.inner_text("#labels")
    assert not page.evaluate(ARROW, 0.0)["shown"]  # on the way up
    assert "process force" not in page.inner_text("#labels")


def test_force_over_height_work_and_inputs(written: Path, press: Any, pressed: Any, ratings: Any) -> None:
    report = data_in(written)["report"]
    over_height = chart(sections(written)["Process"], "Force over the height")
    assert over_height["unit"] == "kN"
    drawn = curves(over_height)
    assert_allclose(drawn["process force"][0][:-1], height(press, pressed.motion), rtol=1e-5, atol=1e-4)
    assert_allclose(drawn["process force"][1][:-1], pressed.process_force / 1e3, rtol=1e-6)
    assert_allclose(drawn["permissible force"][0], 1e3 * ratings.height, rtol=1e-6)
    assert_allclose(drawn["permissible force"][1], ratings.force / 1e3, rtol=1e-6)
    (process,) = chart(sections(written)["Process"], "Process force")["curves"]
    assert process["before"] is None  # the idle press has none to be dashed
    figures = {figure["name"]: figure["value"] for figure in report["figures"]}
    assert figures["work of the process"] == f"{pressed.process_work / 1e3:.3f} kJ"
    stated = {inputs["title"]: dict(inputs["rows"]) for inputs in report["inputs"]}
    assert stated[""] == dict(inputs_of(pressed)) | {"nominal force": "3000 kN", "nominal height": "13 mm"}
    assert stated[""]["load"] == "deep drawing: force = 1500 kN, start = 40 mm, end = 2 mm"
    assert stated["Dashed curves, where they differ"]["loads"] == "none but weight"


def test_a_run_states_its_motor_and_flywheel(press: Any, tmp_path: Path) -> None:
    """Without a browser; work of several strokes is that of the whole run."""
    motor = pp.drives.Geared(pp.drives.InductionMotor(75e3, 1485 * pp.RPM, inertia=1.2), 20.7)
    run = pp.simulate(press, 1.8, speed=SPEED, drive=motor, flywheel=pp.drives.Flywheel(2000.0), loads=[LOAD])
    loaded = pp.inverse_dynamics(press, run, [LOAD])
    report = data_in(pp.report(press, run, tmp_path / "run.html", reactions=loaded))["report"]
    rows = dict(report["inputs"][0]["rows"])
    assert rows["flywheel"] == "inertia = 2000 kg m2"
    assert rows["drive"].startswith("geared: ratio = ")
    (card,) = [card for card in report["figures"] if card["name"] == "work of the process"]
    assert (card["value"], card["at"]) == (f"{run.load_work[-1] / 1e3:.3f} kJ", "over the motion")


def test_utilisation(press: Any, pressed: Any, ratings: Any) -> None:
    found = ratings.utilisation(pressed)
    at = int(found.argmax())
    motion = pp.servo_cycle(press, pressed.motion.crank_angle[at : at + 1], speed=SPEED)
    torque = pp.ratings.rate(press, SPEED, ratings.capacities, points=2001).torque_capacity
    permissible = torque * SPEED / abs(motion.slide_velocity[0])  # above the nominal height by virtual work
    assert height(press, motion)[0] > 13
    assert found[at] == pytest.approx(pressed.process_force[at] / permissible, rel=1e-3)
    other = texts.shipped("crank_slide")
    idle = pp.inverse_dynamics(other, pp.cycle(other, SPEED, points=12))
    for refused in (lambda: ratings.utilisation(idle), lambda: pp.report(other, idle.motion, "x.html", reactions=idle, results=[ratings])):
        with pytest.raises(
            pp.PinpressError, match=r"belong to crank_slide, but the ratings to zxn2_3000b|is of zxn2_3000b, the page of crank_slide"
        ):
            refused()


@pytest.fixture(scope="module")
def stepped() -> Any:
    crank = texts.shipped("crank_slide")
    return pp.inverse_dynamics(crank, pp.cycle(crank, 10.0, points=360), [pp.loads.ConstantForce(1e5, 0.03)])


@pytest.fixture(scope="module")
def steps(stepped: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    crank = texts.shipped("crank_slide")
    rated = pp.ratings.rate(crank, 10.0, pp.ratings.Capacities(2e5, nominal_height=0.006))
    along = pp.ratings.rate_motion(crank, stepped.motion, pp.ratings.Capacities(2e5, torque=1e4))
    path = tmp_path_factory.mktemp("steps") / "out.html"
    return pp.report(crank, stepped.motion, path, reactions=stepped, before=stepped, results=[rated, along])


def test_a_step_of_the_load_is_drawn_as_a_step(steps: Path, stepped: Any) -> None:
    """Both values at the edge, by the closed form of the reference press: -159.084 and 7661.827 N m at 318.96 deg."""
    report = data_in(steps)["report"]
    charts = [block for section in report["sections"] for block in section["blocks"]]
    charts += [bearing["components"] for block in charts if block["kind"] == "bearings" for bearing in block["bearings"]]
    lines = [(chart, curve) for chart in charts if chart["kind"] == "lines" and chart["follows"] == "frames" for curve in chart["curves"]]
    drawn = {(chart["title"], curve["name"]): (floats(curve["x"]), floats(curve["y"])) for chart, curve in lines if curve["x"]}
    x, torque = drawn["Driving torque", "driving torque"]
    ends, edge = np.flatnonzero((np.diff(x) < 1e-4) & (np.abs(np.diff(torque)) > 1.0))
    assert x[edge : edge + 2] == pytest.approx(318.9603436797, abs=1e-4)
    assert torque[edge : edge + 2] == pytest.approx([-159.084, 7661.827], abs=2e-3)
    assert_allclose(np.delete(torque, [ends, ends + 1, edge, edge + 1])[:360], stepped.driving_torque, rtol=1e-5, atol=1e-2)
    for title, name in drawn:
        assert np.all(np.diff(drawn[title, name][0]) >= 0), title
        assert len(drawn[title, name][0]) == len(x), title
    assert drawn["Process force", "process force"][1][edge : edge + 2].tolist() == [0.0, 100.0]
    uses = [block for block in charts if block.get("title") == "Process force by permissible force"]
    assert len(uses) == 2
    for use in uses:
        assert floats(use["curves"][0]["y"])[edge] == 0.0 < floats(use["curves"][0]["y"])[edge + 1]
    for over_height in (block for block in charts if block.get("follows") == "height"):
        for curve in (curve for curve in over_height["curves"] if curve["name"] == "process force"):
            height, force = floats(curve["x"]), floats(curve["y"])
            step = np.flatnonzero(np.diff(force))
            assert height[[*step, *step + 1]] == pytest.approx(30.0, abs=1e-4)
    assert_allclose(floats(report["before"]), x)
    for _, curve in lines:
        if curve["before"]:
            assert np.array_equal(floats(curve["before"]), floats(curve["y"])), curve["name"]


@pytest.mark.exhaustive
def test_cursors_follow_curves_with_steps(steps: Path, stepped: Any, shared_view: Callable[..., Any]) -> None:
    page = shared_view(steps, (1000, 500))
    for state in (0, 100, 318, 319, 359):
        shown = page.evaluate(VALUE, [float(stepped.motion.time[state]), "Driving torque"])
        assert float(shown.replace("\u2212", "-")) == pytest.approx(stepped.driving_torque[state], abs=0.6)
    assert page.evaluate(VALUE, [10.0, "Driving torque"])  # at the end too


def test_loads_without_steps_keep_the_key_frames(written: Path) -> None:
    """Deep drawing begins and ends without force; its curves have no abscissa of their own."""
    charts = [block for section in data_in(written)["report"]["sections"] for block in section["blocks"]]
    curves = [curve for chart in charts if chart["kind"] == "lines" and chart["follows"] == "frames" for curve in chart["curves"]]
    assert curves
    assert [curve["name"] for curve in curves if curve["x"]] == []
