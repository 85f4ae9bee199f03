"""Pages in which a press swings in its vibrations."""

import base64
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.in_browser import data_in, wait
from support.texts import shipped

import pinpress as pp
from pinpress.elasticity import Elastic, ElasticModes, Stiffness, flexible_beam, natural_frequencies
from pinpress.visual.deflected import SEEN


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
    line = np.frombuffer(base64.b64decode(data["bends"][0]["nodes"]), "<f4").reshape(3, found.shape[1], 9, 3)
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


def test_other_presses_are_refused(tmp_path: Path) -> None:
    with pytest.raises(pp.PinpressError, match="the modes are of jf75g_125_plain"):
        pp.record_modes(shipped("crank_slide"), modes_of(1.0), tmp_path / "modes.html")
    with pytest.raises(pp.PinpressError, match="lowest"):
        pp.record_modes(shipped("jf75g_125_plain"), modes_of(1.0), tmp_path / "modes.html", lowest=0)


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
