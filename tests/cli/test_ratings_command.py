"""`pinpress ratings`: what it prints and writes is what the library gives."""

import importlib.util
from pathlib import Path

import pytest
from support.refused_commands import one_line
from support.texts import shipped

import pinpress as pp
from pinpress.cli.main import main
from pinpress.ratings.permissible_force import Capacities
from pinpress.ratings.rating import rate

ASKED = ["zxn2_3000b", "--speed", "70", "--nominal-force", "3000e3", "--nominal-height", "0.013", "--points", "31"]
MORE = ["--flywheel", "2000", "--speed-drop", "0.2", "--bearing", "A=2e6", "--bearing", "slide_guide=1e6", "--motor-power", "75e3"]


def library(at_speed=False, **more):
    return rate(shipped("zxn2_3000b"), 70 * pp.RPM, Capacities(3000e3, nominal_height=0.013, **more), at_speed=at_speed, points=31)


def printed(capsys, *arguments):
    assert main(["ratings", *map(str, arguments)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def refused(capsys, *arguments):
    return one_line(capsys, "ratings", *arguments)


def test_it_prints_the_ratings_and_writes_nothing(capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    found, inputs = printed(capsys, *ASKED).split("\n\nInputs\n")
    assert found == str(library())
    for words in (
        "press            zxn2_3000b,",
        "speed            70 r/min, without weights",
        "nominal force    3000 kN",
        f"pinpress {pp.__version__}",
    ):
        assert words in inputs
    bearings = {"A": 2e6, "slide_guide": 1e6}
    more = library(at_speed=True, flywheel_inertia=2000.0, speed_drop=0.2, bearings=bearings, motor_power=75e3)
    found, inputs = printed(capsys, *ASKED, *MORE, "--at-speed").split("\n\nInputs\n")
    assert found == str(more)
    for words in (
        "with weights",
        "flywheel inertia      2000 kg m2",
        "speed drop            0.2",
        "motor power           75 kW",
        "bearing A             2000 kN",
    ):
        assert words in inputs
    assert not list(tmp_path.iterdir())


@pytest.mark.exhaustive
def test_files(capsys, tmp_path):
    out = tmp_path / "made" / "out"
    text = printed(capsys, *ASKED, *MORE, "--out", out)
    assert text.endswith(f"\nwrote {out / 'ratings.csv'} and {out / 'ratings.png'}\n")
    library(flywheel_inertia=2000.0, speed_drop=0.2, bearings={"A": 2e6, "slide_guide": 1e6}, motor_power=75e3).to_csv(tmp_path / "1.csv")
    assert (out / "ratings.csv").read_bytes() == (tmp_path / "1.csv").read_bytes()
    assert (out / "ratings.png").read_bytes().startswith(b"\x89PNG")


def test_without_matplotlib_it_writes_the_table(capsys, monkeypatch, tmp_path):
    known = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *more: None if name == "matplotlib" else known(name, *more))
    assert "pip install 'pinpress[plots]'" in printed(capsys, *ASKED, "--out", tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["ratings.csv"]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--bearing", "A"], "--bearing A: it needs NAME=N"),
        (["--bearing", "A=much"], "it needs NAME=N"),
        (["--bearing", "A=-1"], "it needs NAME=N"),
        (["--bearing", "A=1e6", "--bearing", "A=2e6"], "given twice"),
        (["--bearing", "Q=1e6"], "no bearing 'Q'"),
        (["--speed-drop", "0.2"], "the energy of a flywheel needs --flywheel and --speed-drop"),
        (["--torque", "1e5"], "leave one out"),
        (["--dwell-tolerance", "7"], "between 0 and the stroke"),
    ],
)
def test_what_it_refuses(capsys, more, words):
    assert words in refused(capsys, *ASKED, *more)


def test_it_writes_nothing_where_it_cannot(capsys, tmp_path):
    (tmp_path / "file").write_text("")
    assert "cannot make the folder" in refused(capsys, *ASKED, "--out", tmp_path / "file" / "out")
    assert Path(tmp_path / "file").is_file()
