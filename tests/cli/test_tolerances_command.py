"""`pinpress tolerances`: what it prints and writes is what the library gives; what it says of wrong words."""

import importlib.util

import pytest
from support.refused_commands import one_line
from support.texts import shipped

import pinpress as pp
from pinpress.cli.main import main

TABLE = "dimension, tolerance, unit, cost\nlength D E, 50, um, 3\nlength E F, 0.05\nangle C D E, 0.01\n"


@pytest.fixture
def asked(tmp_path):
    (tmp_path / "table.csv").write_text(TABLE)
    return ["zxn2_3000b", "--dimensions", tmp_path / "table.csv", "--samples", "4000", "--seed", "2"]


def printed(capsys, *arguments):
    assert main(["tolerances", *map(str, arguments)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def refused(capsys, *arguments):
    return one_line(capsys, "tolerances", *arguments)


def test_it_prints_what_the_library_gives(capsys, asked, tmp_path):
    press = shipped("zxn2_3000b")
    table = pp.tolerances.read_dimensions(press, tmp_path / "table.csv")
    found = pp.tolerances.bottom_dead_centre(press, table.parts, forces={0.006: 3e6}, speeds={0.05: 70 * pp.RPM}, samples=4000, seed=2)
    cheapest = pp.tolerances.allocate(press, table.parts, table.costs, {"height": 4e-5, "stroke": 6e-5}, table.bounds)
    more = ["--within", "50um", "--force", "6mm=3000kN", "--speed", "0.05=70", "--target", "height=40um", "--target", "stroke=6e-5"]
    text, inputs = printed(capsys, *asked, *more).split("\n\nInputs\n")
    within = f"\n  within 50 um at bottom dead centre: {100 * found.within(5e-5):.4g} % of the presses\n"
    assert text == f"{found}{within}\n{cheapest}"
    assert "3 of " in inputs
    assert "4000 presses, seed 2" in inputs
    assert "height=40um, stroke=6e-5" in inputs


def test_files(capsys, asked, tmp_path, monkeypatch):
    known = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *more: None if name == "matplotlib" else known(name, *more))
    text = printed(capsys, *asked, "--target", "height=40um", "--out", tmp_path / "out")
    assert "pip install 'pinpress[plots]'" in text
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["allocated.csv", "dimensions.csv"]
    assert (tmp_path / "out" / "dimensions.csv").read_text().splitlines()[1].startswith("DE,5e-05,m,-0.998")


def test_the_accuracy_budget_is_that_of_the_library(capsys, asked, tmp_path):
    press = shipped("zxn2_3000b")
    table = pp.tolerances.read_dimensions(press, tmp_path / "table.csv")
    found = pp.tolerances.budget(
        press,
        speeds=[10 * pp.RPM, 70 * pp.RPM],
        clearance={"F": 5e-5, "E": 4e-5},
        stiffness=pp.elasticity.Stiffness({"E": 3e9}),
        temperatures=pp.tolerances.Temperatures({"rod": 10.0, "frame": -2.0}, 1.1e-5, table=-1.9),
        process=5e5,
        machining=pp.tolerances.bottom_dead_centre(press, table.parts, samples=4000, seed=2),
    )
    more = ["--budget", "10,70", "--clearance", "F=50um", "--clearance", "E=0.04mm", "--stiffness", "E=3e9", "--warm", "rod=10"]
    more += ["--warm", "frame=-2K", "--table", "-1.9", "--expansion", "1.1e-5", "--process", "500kN", "--out", tmp_path / "out"]
    text, inputs = printed(capsys, *asked, *more).split("\n\nInputs\n")
    assert text.endswith(str(found))
    assert "F=50um, E=0.04mm" in inputs
    assert len((tmp_path / "out" / "budget.csv").read_text().splitlines()) == 7


@pytest.mark.exhaustive
def test_the_picture(capsys, asked, tmp_path):
    pytest.importorskip("matplotlib")
    assert "tolerances.png" in printed(capsys, *asked, "--out", tmp_path / "out")
    assert (tmp_path / "out" / "tolerances.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--clearance", "F=50um"], "--clearance can only be used with the accuracy budget: also give its speeds"),
        (["--budget", "10;70"], "--budget 10;70 is no number"),
        (["--budget", "10", "--warm", "rod"], "--warm rod: write it as in --warm rod=10; a link, and kelvins"),
        (["--budget", "10", "--clearance", "F=5"], "clearance of 'F' is 5 m: give the radial clearance in m"),
        (["--budget", "10"], "give clearance, stiffness or temperatures"),
        (["--force", "6mm"], "--force 6mm: write it as in --force 6mm=3000kN"),
        (["--force", "6mm=3m"], "write it as in"),
        (["--speed", "6deg=3"], "write it as in --speed 50mm=70rpm"),
        (["--force", "6mm=3e6", "--force", "0.006=2e6"], "0.006 is given twice"),
        (["--force", "400mm=3e6"], "is not within the stroke of 301.261 mm"),
        (["--target", "hight=50um"], "there are height (bottom dead centre), top (top dead centre), stroke (the stroke)"),
        (["--target", "height=1um"], "misses its target of 1 um by"),
    ],
)
def test_what_it_refuses(capsys, asked, more, words):
    assert words in refused(capsys, *asked, *more)
