"""Pages in which a press swings in its vibrations, and links drawn on their springs."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from support.in_browser import data_in, floats, wait
from support.texts import shipped

import pinpress as pp
from pinpress.elasticity import Elastic, ElasticModes, Stiffness, flexible_beam, natural_frequencies
from pinpress.kinematics.poses import poses
from pinpress.pin_table.templates import template
from pinpress.visual.deflected import SEEN, displaced, magnification
from pinpress.visual.swinging import on_springs


def modes_of(angle: Any) -> ElasticModes:
    press = shipped("jf75g_125_plain")
    stiffness = Stiffness(dict.fromkeys(press.bearings, 2e9), moments={"slide_guide": 2e8})
    rod = flexible_beam(press, "main_rod", ("P2", "P4"), area=0.01, second_moment=4e-8, modes=1)
    return natural_frequencies(press, Elastic(stiffness, flexible_links=[rod]), angle=angle)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, ElasticModes]:
    modes = modes_of(np.linspace(0, 2 * np.pi, 12, endpoint=False))
    path = tmp_path_factory.mktemp("modes") / "modes.html"
    return pp.record_modes(shipped("jf75g_125_plain"), modes, path, lowest=3), modes


def test_modes_over_the_turn(recorded: tuple[Path, ElasticModes]) -> None:
    """Frequencies of each mode in turn; the rod's line is straight between swings, and bends out of itself where the rod does."""
    path, modes = recorded
    data = data_in(path)
    frequency = modes.natural_frequency[:, :3] / (2 * np.pi)
    found = np.array(data["frequency"]).reshape(3, -1)
    np.testing.assert_allclose(found[:, :-1:40].T, frequency, rtol=1e-5)
    np.testing.assert_allclose(found[:, -1], frequency[0], rtol=1e-5)  # a turn ends as it began
    assert [mode["name"] for mode in data["modes"]] == ["mode 1", "mode 2", "mode 3"]
    assert [data["time"][k * found.shape[1]] for k in range(3)] == pytest.approx([mode["start"] for mode in data["modes"]])
    line = floats(data["bends"][0]["nodes"]).reshape(3, found.shape[1], 9, 3)
    sag = np.linalg.norm(line[:, :, 4] - 0.5 * (line[:, :, 0] + line[:, :, 8]), axis=2)
    np.testing.assert_allclose(sag[:, ::12], 0.0, atol=1e-6)
    bending = int(modes.strain_energy["main_rod"][0, :3].argmax())
    length = np.linalg.norm(line[:, 0, 8] - line[:, 0, 0], axis=1)
    np.testing.assert_allclose(length, 0.3, rtol=1e-5)
    size = shipped("jf75g_125_plain").size
    assert SEEN * size < sag[bending].max() < 2 * SEEN * size  # as large as any displacement, beside that of the ends


def test_at_one_angle_the_press_stands(tmp_path: Path) -> None:
    path = pp.record_modes(shipped("jf75g_125_plain"), modes_of(1.0), tmp_path / "modes.html", lowest=1)
    data = data_in(path)
    np.testing.assert_allclose(data["crank"], np.degrees(1.0), rtol=1e-8)
    assert data["time"][-1] == 4.0
    assert "yields: " in data["modes"][0]["words"]


def test_a_link_that_turns_about_its_centre_alone(tmp_path: Path) -> None:
    """The slide of this press turns in its guide, and nothing moves: magnified by displacements alone it would turn without bounds."""
    press = pp.build(
        units="mm",
        frame="O",
        pins={"O": [0, 0], "P": {"from": "O", "length": 100, "angle": -90}, "W": {"P": 400, "x": 0, "side": "down"}},
        links={
            "crank": {"pins": "O P", "mass": 20},
            "rod": {"pins": "P W", "mass": 18},
            "slide": {"pins": "W", "guide": "up", "mass": 300},
        },
        drive="O",
    )
    modes = natural_frequencies(press, Elastic(Stiffness(dict.fromkeys(press.bearings, 1e9), moments={"slide_guide": 1e6})), angle=[1.0])
    assert not modes.shapes[0, 0, :, :2].any()
    data = data_in(pp.record_modes(press, modes, tmp_path / "modes.html", lowest=1))
    assert "yields: slide_guide turning 100 %" in data["modes"][0]["words"]
    for place in data["places"]:
        assert np.abs(np.ptp(floats(place, 3), axis=0)).max() < 1e-6


def test_modes_in_space(tmp_path: Path) -> None:
    """Bodies of a linkage in space stand as its shapes say: those of a mode, magnified by one factor, at the height of a swing."""
    path = tmp_path / "rssp.yaml"
    path.write_bytes(template("rssp"))
    press = pp.build(path)
    moments = dict.fromkeys(("O", "B_cross", "B", "slide_guide"), 1e8)
    modes = natural_frequencies(press, Elastic(Stiffness(dict.fromkeys(press.bearings, 1e9), moments=moments)), angle=[1.0])
    assert modes.shapes.shape[-1] == 6
    data = data_in(pp.record_modes(press, modes, tmp_path / "modes.html", lowest=2))
    keys = len(data["crank"]) // 2
    np.testing.assert_allclose(np.array(data["frequency"]).reshape(2, keys)[:, 0], modes.natural_frequency[0, :2] / (2 * np.pi), rtol=1e-5)
    _, (one, two) = on_springs(press, modes, 2)
    for film, shape in ((one.at, modes.shapes[0, 0]), (two.at, modes.shapes[0, 1])):
        lever = [press.model.inertias[body + 1].lever for body in range(press.model.nv)]
        moved = [film.points(body + 1, lever[body]) - film.points(body + 1, lever[body])[0] for body in range(press.model.nv)]
        height = np.array([each[6] for each in moved])  # a quarter of the first swing
        factor = (height * shape[:, :3]).sum() / (shape[:, :3] ** 2).sum()
        np.testing.assert_allclose(height, factor * shape[:, :3], atol=1e-9 * press.size)
        turns = np.array([pin.log3(film.rotation[body + 1][6] @ film.rotation[body + 1][0].T) for body in range(press.model.nv)])
        np.testing.assert_allclose(turns, factor * shape[:, 3:], atol=1e-9)
        assert np.abs(height).max() <= SEEN * press.size * (1 + 1e-9)


def test_other_presses_are_refused(tmp_path: Path) -> None:
    with pytest.raises(pp.PinpressError, match="the modes are of jf75g_125_plain"):
        pp.record_modes(shipped("crank_slide"), modes_of(1.0), tmp_path / "modes.html")
    press = shipped("jf75g_125_plain")
    model = press.model.copy()
    model.inertias[1] = pin.Inertia(2 * model.inertias[1].mass, model.inertias[1].lever, model.inertias[1].inertia)
    with pytest.raises(pp.PinpressError, match="the modes are of a jf75g_125_plain with other lengths, masses or zero"):
        pp.record_modes(replace(press, model=model), modes_of(1.0), tmp_path / "modes.html")
    with pytest.raises(pp.PinpressError, match="lowest"):
        pp.record_modes(shipped("jf75g_125_plain"), modes_of(1.0), tmp_path / "modes.html", lowest=0)


MOUNTS = [pp.foundation.Mount((x, y, -0.9), (4e6, 5e6, 3e7), (1e4, 1e4, 2e4)) for x in (-0.5, 0.5) for y in (-0.4, 0.6)]
RAILS = [pp.foundation.Mount((x, 0.7, 0.8), (4e6, 4e6, 8e6)) for x in (-0.3, 0.3)] + [pp.foundation.Mount((0, 0.9, 0.8), (4e6, 4e6, 8e6))]
ASIDE = {
    "motor": pp.foundation.Attachment(pp.foundation.Frame(450, (0, 0.8, 0.95), (20, 10, 20)), RAILS),
    "cabinet": pp.foundation.Attachment(pp.foundation.Frame(90, (0.7, 0, 0.2), (5, 5, 5))),
}


def standing(bends: bool) -> pp.foundation.MountedPress:
    """The press on its mounts, a motor on rails beside it: a rigid frame, or one of two beams."""
    places = {f"foot {k}": mount.point for k, mount in enumerate(MOUNTS)} | {"head": (0, 0.1, 0.8)}
    beams = [pp.foundation.FrameBeam(f"foot {k}", "head", 0.3, 0.3, (0.1, 1, 0)) for k in range(4)]
    frame = pp.foundation.Frame(9000, (0, 0.1, 0.0), (5000, 4000, 3000))
    more: dict[str, Any] = {"attached": ASIDE, "rotors": [pp.foundation.Rotor(136, (0, 1, 0))]}
    if bends:
        bent = pp.foundation.beam_frame(places, beams, bed="foot 0", carrier="head", elements=2)
        return pp.foundation.mounted(shipped("jf75g_125_plain"), bent, MOUNTS, **more)
    return pp.foundation.mounted(shipped("jf75g_125_plain"), frame, MOUNTS, **more)


def bent_lines(data: Any, keys: int) -> dict[str, list[np.ndarray]]:
    """Nodes (modes, keys, k, 3) of the lines of a page, by their names."""
    found: dict[str, list[np.ndarray]] = {}
    for each in data["bends"]:
        found.setdefault(each["link"], []).append(floats(each["nodes"]).reshape(len(data["modes"]), keys, -1, 3))
    return found


@pytest.mark.parametrize("bends", [False, True])
def test_a_frame_swings_on_its_mounts(bends: bool, tmp_path: Path) -> None:
    """Feet move as the mode's shape says, the floor does not; the largest displacement is that share of the picture's size."""
    system = standing(bends)
    modes = pp.foundation.modes(system)
    data = data_in(pp.record_modes(system.press, modes, tmp_path / "modes.html", lowest=2))
    keys = len(data["time"]) // 2
    lines = bent_lines(data, keys)
    assert {"frame", "motor", "cabinet", "mount 1", "mount 4"} <= set(lines)
    np.testing.assert_allclose(data["frequency"][::keys], modes.natural_frequency[:2] / (2 * np.pi), rtol=1e-12)
    assert modes.motion[0] in data["modes"][0]["words"]
    for mode in (0, 1):
        at_most = 6  # a quarter of a vibration after its start
        foot = np.array([lines[f"mount {k + 1}"][0][mode, :, 0] - MOUNTS[k].point for k in range(4)])
        floor = lines["mount 1"][0][mode, :, 1]
        np.testing.assert_allclose(floor - floor[0], 0.0, atol=1e-7)
        np.testing.assert_allclose(foot[:, 0], 0.0, atol=1e-6)
        expected = system.mount_rows @ modes.shapes[:, mode]
        factor = (foot[:, at_most] * expected).sum() / (expected**2).sum()
        np.testing.assert_allclose(foot[:, at_most], factor * expected, atol=1e-5)
    moved = [np.linalg.norm(each - each[:, :1], axis=3).max() for some in lines.values() for each in some]
    nodes = np.vstack([each[0, 0] for some in lines.values() for each in some])
    size = max(system.press.size, *np.ptp(nodes, axis=0))
    assert 0.9 * SEEN * size < max(moved) < 1.1 * SEEN * size


def test_a_frame_whirls(tmp_path: Path) -> None:
    """A complex shape circles: it is not at rest at the start of its vibration, and back after a whole one."""
    system = standing(False)
    diagram = pp.foundation.whirl(system, [10.0, 60.0])
    data = data_in(pp.record_modes(system.press, diagram, tmp_path / "whirl.html", lowest=3))
    lines = bent_lines(data, len(data["time"]) // 3)
    assert "damping ratio" in data["modes"][0]["words"]
    assert diagram.motion(int(diagram.frequency[-1].argmin())) in data["modes"][0]["words"]
    np.testing.assert_allclose(lines["motor"][0][:, 24], lines["motor"][0][:, 0], atol=1e-6)
    assert len(data["frequency"]) == len(data["time"])
    with pytest.raises(pp.PinpressError, match="the modes are of jf75g_125_plain"):
        pp.record_modes(shipped("crank_slide"), diagram, tmp_path / "modes.html")


def test_a_frame_without_lines_is_drawn_by_its_interfaces(tmp_path: Path) -> None:
    """One line from the middle to each of five."""
    with_lines = standing(True)
    assert isinstance(with_lines.frame, pp.foundation.ElasticFrame)
    bare = replace(with_lines.frame, lines=np.zeros((0, 2), dtype=int))
    system = pp.foundation.mounted(with_lines.press, bare, MOUNTS)
    data = data_in(pp.record_modes(system.press, pp.foundation.modes(system), tmp_path / "modes.html", lowest=1))
    lines = bent_lines(data, len(data["time"]))["frame"]
    np.testing.assert_allclose([line[0, 0, 1] for line in lines], list(bare.nodes.values()), atol=1e-6)


@pytest.mark.exhaustive
def test_a_mode_is_chosen_and_repeated(recorded: tuple[Path, ElasticModes], shared_view: Callable[..., Any]) -> None:
    path, modes = recorded
    page = shared_view(path, (480, 400))
    page.select_option("#mode", "2")
    hertz = modes.natural_frequency[:, 2] / (2 * np.pi)
    assert page.inner_text("#words").startswith(f"{hertz.min():.4g} to {hertz.max():.4g} Hz")
    page.evaluate("seek(data.modes[2].end - 0.05)")
    page.evaluate("setPlaying(true)")
    wait(page, "now < data.modes[2].start + 15")  # it began again
    page.evaluate("setPlaying(false)")
    assert page.evaluate("[modeAt(now), Number(element('slider').min)]") == [2, 42]
    assert page.inner_text("#time").startswith("mode 3")


def test_displacements_put_links_where_they_are() -> None:
    """Without magnification the slide's origin is at the elastic slide position, and a bearing is as wide open as its force says."""
    press, speed, stiffness = shipped("jf75g_125_plain"), 300 * pp.RPM, 2e7
    elastic = pp.elasticity.Elastic(pp.elasticity.Stiffness(dict.fromkeys(press.bearings, stiffness), moments={"slide_guide": 2e6}), 0.0)
    run = pp.steady_state(press, speed, drive=pp.drives.PrescribedSpeed(speed), elastic=elastic, points=25)
    assert isinstance(run, pp.ElasticRun)
    at = displaced(press, poses(press, run.joint_position), run.displacement)
    slide = press.model.frames[press.model.getFrameId("slide")]
    np.testing.assert_allclose(at.points(slide.parentJoint, slide.placement.translation)[:, 2], run.slide_position, rtol=0, atol=1e-12)
    crank, rod = (press.joints.index(name) + 1 for name in ("O", "P2"))
    gap = at.points(rod, np.zeros(3)) - at.points(crank, press.model.jointPlacements[rod].translation)
    np.testing.assert_allclose(run.bearing_force["P2"], -stiffness * gap, rtol=0, atol=1e-6 * stiffness * np.abs(gap).max())


@pytest.mark.parametrize(("share", "factor"), [(1e-3, 50.0), (0.011, 2.0), (0.2, 1.0), (0.0, 1.0), (3e-6, 10000.0)])
def test_magnification_is_a_round_number(share: float, factor: float) -> None:
    press = shipped("crank_slide")
    assert magnification(press, np.full((3, 3, 3), share * press.size)) == factor
