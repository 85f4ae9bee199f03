"""`pinpress force`: what it prints and writes is what the library gives; what it says of wrong words."""

import csv
from pathlib import Path

import numpy as np
import pytest
from support.refused_commands import refused
from support.texts import shipped

import pinpress as pp
from pinpress.cli.main import main

RECORDS = Path(__file__).resolve().parents[3] / "docs" / "records"
IDLE = [RECORDS / f"{strokes}.csv" for strokes in (21, 42, 63)]
COLUMNS = ["--angle", "crank [deg]", "--torque", "motor [N m]", "--ratio", "20.7"]
HEIGHTS = ["--heights", "0 1 2 3 4 5 6 7 8 9 10 11 mm", "--heights-up", "0 2 5 9 mm"]


@pytest.mark.exhaustive
def test_it_prints_and_writes_what_the_library_gives(capsys, tmp_path):
    """These strokes draw with at most 1.4, 1.5 and 1.6 MN, and strip with up to 90 kN."""
    arguments = [str(RECORDS / "stroke.csv"), *COLUMNS, *HEIGHTS, "--friction", "crank,gibs", "--cylinder", "--out", str(tmp_path / "out")]
    for file in IDLE:
        arguments += ["--idle", str(file)]
    assert main(["measured", "force", "zxn2_3000b", *arguments]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    *idle, run = (pp.measured.record(file, "crank [deg]", "motor [N m]", ratio=20.7) for file in (*IDLE, RECORDS / "stroke.csv"))
    found = pp.measured.identify(shipped("zxn2_3000b"), idle, friction=("crank", "gibs"), cylinder=True)
    sensor = pp.measured.force_sensor(found, np.arange(12) * 1e-3, heights_up=[0.0, 0.002, 0.005, 0.009])
    strokes = list(sensor.strokes(run))
    assert found.title in out
    assert f"stroke 3:\n{strokes[2]}\n" in out
    for each, largest in zip(strokes, (1.4e6, 1.5e6, 1.6e6), strict=True):
        low, high = each.interval[5]
        assert low < largest < high
        assert each.interval_up[1, 0] < -9e4 < each.interval_up[1, 1]
    rows = list(csv.DictReader((tmp_path / "out" / "stroke_force.csv").read_text().splitlines()))
    assert [row["stroke"] for row in rows] == ["1"] * 16 + ["2"] * 16 + ["3"] * 16
    assert float(rows[37]["force [N]"]) == pytest.approx(strokes[2].force[5])
    table = list(csv.DictReader((tmp_path / "out" / "stroke_strokes.csv").read_text().splitlines()))
    assert [float(row["work [J]"]) for row in table] == pytest.approx([each.work for each in strokes])
    assert (tmp_path / "out" / "force.png").stat().st_size > 5000


def test_one_stroke_of_a_press_as_described(capsys, tmp_path):
    """A record of little more than a stroke; the warning is that the press is not as described."""
    lines = (RECORDS / "stroke.csv").read_text().splitlines()
    (tmp_path / "one.csv").write_text("\n".join(lines[:613]) + "\n")
    with pytest.warns(pp.PinpressWarning, match="identify the press from a run without a blank"):
        assert main(["measured", "force", "zxn2_3000b", str(tmp_path / "one.csv"), *COLUMNS, "--heights", "0 4 8 12 mm"]) == 0
    assert capsys.readouterr().out.startswith("MeasuredForce one.csv: at most")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--heights", "0 4 inches"], "is in 'inches', which is none of m"),
        (["--heights", "0 4 m"], "give heights within its stroke, in m"),
        (["--heights", "0 4"], "4 has no unit; write 4 mm or 4 m, whichever it is"),
        (["--heights", "0 4 mm", "--cylinder"], "also give them, --idle 30.csv --idle 60.csv"),
        ([str(RECORDS / "stroke.csv"), "--heights", "0 4 mm"], "two records are called stroke"),
        (["--heights", "0 4 mm", "--torque", "force"], "no column in"),
    ],
)
def test_wrong_words(capsys, words, said):
    assert said in refused(capsys, "measured", "force", *COLUMNS, "zxn2_3000b", str(RECORDS / "stroke.csv"), *words)
