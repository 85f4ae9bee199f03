"""`pinpress convert`: the same linkage in another format, by the ending of its name."""

import re
import shutil

import numpy as np
import pytest
from support import texts
from support.generators.spatial_linkages import four_bar
from support.refused_commands import one_line

import pinpress as pp
from pinpress.cli.main import main


def torque(press):
    return pp.inverse_dynamics(press, pp.cycle(press, speed=3.0, points=8)).driving_torque


@pytest.mark.parametrize("name", ["press.urdf", "press.sdf", "press.xml", "press.urdf --home", "press.urdf --dialect urdf+"])
def test_a_press_is_written_in_the_format_of_the_ending(name, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    out, *options = name.split()
    if out.endswith(".xml"):
        pytest.importorskip("mujoco")
    assert main(["convert", "crank_slide", out, *options]) == 0
    words = rf"wrote {out}: \d links, 3 moving joints, 1 loops, 1 drivers; mobility 1\n"
    assert re.fullmatch(words, capsys.readouterr().out)
    expected = torque(pp.load("crank_slide"))
    np.testing.assert_allclose(torque(pp.load(out)), expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_drivers_may_be_named(tmp_path, capsys):
    file = texts.file(re.sub("<transmission.*?</transmission>", "", four_bar("spherical"), flags=re.DOTALL))
    assert main(["convert", str(file), str(tmp_path / "out.sdf"), "--set", "drivers=D"]) == 0
    assert pp.load(tmp_path / "out.sdf").drivers == ("D",)
    assert "1 drivers" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("out", "options", "message"),
    [
        ("out.txt", [], "out.txt has none of the endings .urdf, .sdf, .xml: its ending says the format"),
        ("out.sdf", ["--home"], "out.sdf is SDF: --home and --dialect are of a URDF; SDF starts in the closed pose in any case"),
        ("out.xml", ["--home"], "out.xml is MJCF: --home and --dialect are of a URDF"),
        ("press.urdf", [], "press.urdf is the file to convert: give another name"),
        ("out.urdf", ["--dialect", "drake"], "loop 'C' is revolute: Drake's URDF has no rigid constraint but a ball"),
    ],
)
def test_what_cannot_be_written_is_refused(out, options, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(texts.file(four_bar("revolute")), "press.urdf")
    assert message in one_line(capsys, "convert", "press.urdf", out, *options)


def test_what_a_format_does_not_hold_is_said(tmp_path):
    text = pp.load("crank_slide").text.decode().replace("</robot>", '<armature joint="O" inertia="2"/></robot>')
    with pytest.warns(pp.PinpressWarning, match="Gazebo knows no armature: that of O is in <pinpress:armature>"):
        main(["convert", str(texts.file(text)), str(tmp_path / "out.sdf")])
