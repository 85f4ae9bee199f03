"""`pinpress identify`: what it prints and writes is what the library gives; what it says of wrong words."""

from pathlib import Path

import pytest
from support.texts import shipped

import pinpress as pp
from pinpress.cli.main import main

RECORDS = [Path(__file__).resolve().parents[3] / "docs" / "records" / f"{strokes}.csv" for strokes in (21, 42, 63)]
COLUMNS = ["--angle", "crank [deg]", "--torque", "motor [N m]", "--ratio", "20.7"]


@pytest.mark.exhaustive
def test_it_prints_and_writes_what_the_library_gives(capsys, tmp_path):
    """The slide of these records has 7640 kg, 8 % more than described."""
    press = shipped("zxn2_3000b")
    arguments = [*map(str, RECORDS), *COLUMNS, "--friction", "crank,gibs", "--cylinder", "--prior", "0.15"]
    arguments += ["--known", "total mass=12100,100", "--out", str(tmp_path / "out")]
    assert main(["measured", "identify", "zxn2_3000b", *arguments]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    runs = [pp.measured.record(file, "crank [deg]", "motor [N m]", ratio=20.7) for file in RECORDS]
    options = {"prior": 0.15, "friction": ("crank", "gibs"), "cylinder": True, "known": {"total mass": (12100.0, 100.0)}}
    found = pp.measured.identify(press, runs, **options)
    for part in (found, pp.measured.identifiability(press, runs, **options), *(run.title for run in runs), "restarts"):
        assert str(part) in out
    low, high = found.intervals["slide mass"]
    assert low < 7640 < high
    assert (tmp_path / "out" / "parameters.csv").read_text().startswith("name,unit,before")
    again = pp.load(tmp_path / "out" / "identified.urdf")
    joint = again.joints.index("slide_guide") + 1
    assert again.model.inertias[joint].mass == pytest.approx(found.values["slide mass"], rel=1e-9)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--friction", "pin"], "did you mean 'pins'"),
        (["--torque", "engine"], "no column in"),
        (["--added", "22.csv:slide=200kg"], "names no record: write RECORD:LINK=MASS, as in --added 21.csv:slide=200kg"),
        (["--added", "21.csv:slide=heavy"], "'heavy' is no number"),
        (["--known", "slide mass=2200"], "write NAME=VALUE,SD, as in --known 'slide mass=2200,5'"),
        (["--known", "slid mass=2200,5"], "did you mean 'slide mass'"),
    ],
)
def test_wrong_words(capsys, words, said):
    assert main(["measured", "identify", "zxn2_3000b", str(RECORDS[0]), *COLUMNS, *words]) == 2
    out, err = capsys.readouterr()
    assert said in err
    assert out == ""
