"""`--zero`: crank angles that are given, printed and written count from a dead centre, in every command alike."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from support import texts
from support.in_browser import data_in

import pinpress as pp
from pinpress.cli.main import main

PRESS, SPEED = "zxn2_3000b", "70"


def printed(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    assert main(list(map(str, arguments))) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize(("zero", "words"), [("TDC", "top dead centre"), ("bdc", "bottom dead centre")])
def test_analyse(capsys: pytest.CaptureFixture[str], tmp_path: Path, zero: str, words: str) -> None:
    """Dead centre at 0; peaks as much later as the dead centre is; the column's name says where it counts from."""
    text = printed(capsys, "analyse", PRESS, "--speed", SPEED, "--zero", zero, "--out", tmp_path)
    assert re.search(rf"^  {words} +0\.000 deg +at 0\.000000 s$", text, flags=re.MULTILINE)
    assert f"; 720 crank angles from {words}, engine 'plane'" in text
    assert "as drawn" not in text
    assert f"counted from {words}" in text
    assert "was changed" not in text
    ends = pp.dead_centres(texts.shipped(PRESS))
    shift = ends.top_angle if zero == "TDC" else ends.bottom_angle
    with (tmp_path / "cycle.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert header[1] == f"crank_angle_from_{words.replace(' ', '_')} [rad]"
    table = np.array(rows, dtype=float)
    motion = pp.servo_cycle(texts.shipped(PRESS), angle=table[:, 1] + shift, speed=70 * pp.RPM, acceleration=0.0)
    torque = pp.inverse_dynamics(texts.shipped(PRESS), motion).driving_torque
    np.testing.assert_allclose(table[:, header.index("driving_torque [N m]")], torque, atol=1e-12 * np.abs(torque).max())


@pytest.mark.exhaustive
def test_pages(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """Charts and the moving press count from there, and so does the press beside it."""
    words = ("analyse", PRESS, "--speed", SPEED, "--zero", "tdc", "--points", 60, "--before", "zxn2_3000b_balanced")
    printed(capsys, *words, "--out", tmp_path, "--report")
    data = data_in(tmp_path / "report.html")
    assert data["report"]["over"] == {"quantity": "crank angle from top dead centre", "unit": "deg"}
    assert data["driver"] == {"name": "crank from TDC", "unit": "°"}
    assert data["height"][0] == max(data["height"])


def test_simulate(capsys: pytest.CaptureFixture[str]) -> None:
    """The angle at the start, those of a clutch and those that are printed."""
    start = ("simulate", PRESS, "--flywheel", "inertia=2000,speed=70", "--motor", "constant:value=0", "--duration", 0.7)
    shift = float(np.degrees(pp.dead_centres(texts.shipped(PRESS)).top_angle))

    def ran(at: float, closes: float, *zero: str) -> str:
        return printed(capsys, *start, "--angle", at, "--clutch", f"torque=6e4,rise=0.1,closes={closes!r}deg", "--speed", 70, *zero)

    drawn, counted = ran(10 + shift, 60 + shift), ran(10, 60, "--zero", "tdc")
    assert "crank angle 10 deg from top dead centre" in counted
    ends = [float(re.search(r"^  crank angle at the end +(\S+) deg", text, flags=re.MULTILINE)[1]) for text in (drawn, counted)]
    assert ends[0] - ends[1] == pytest.approx(shift, abs=2e-3)
    peaks = [re.findall(r"^  D +(\S+)", text[text.index("Bearings") :], flags=re.MULTILINE) for text in (drawn, counted)]
    assert peaks[0] == peaks[1]


def test_ratings(capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(
        capsys, "ratings", PRESS, "--speed", SPEED, "--nominal-force", "3000kN", "--nominal-height", "13mm", "--zero", "tdc", "--points", 7
    )
    assert "counted from top dead centre" in text
    rows = [line.split() for line in text[text.index("Permissible force") :].splitlines()[2:] if line.strip()]
    assert float(rows[0][1]) == 0.0
    assert float(rows[0][0]) == pytest.approx(301.261)


def test_balance_writes_the_pose_that_the_file_draws(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = ("balance", PRESS, "--speed", SPEED, "--region", "crank:radius=0.3", "--minimise", "range:shaking_force:z", "--points", 60)
    for zero in ("drawn", "tdc"):
        printed(capsys, *words, "--zero", zero, "--out", tmp_path / zero)
    one, other = (pp.load(tmp_path / zero / "balanced.urdf") for zero in ("drawn", "tdc"))
    assert list(one.model.jointPlacements) == list(other.model.jointPlacements)
    np.testing.assert_allclose(
        [inertia.mass for inertia in one.model.inertias], [inertia.mass for inertia in other.model.inertias], rtol=1e-3
    )


def test_record_takes_the_picture_there(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """0.25 of a turn behind top dead centre, by the time of the page."""
    times: list[float] = []
    monkeypatch.setattr("pinpress.visual.film.image", lambda page, png, time, **size: times.append(time))
    words = ("record", PRESS, "--speed", SPEED, "--png", tmp_path / "x.png", "--points", 40, "--no-forces")
    printed(capsys, *words, "--at", 90, "--zero", "tdc")
    assert times == [pytest.approx(0.25 * 60 / 70)]


def test_a_press_without_dead_centres(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["analyse", PRESS, "--speed", SPEED, "--driver", "D", "--zero", "tdc"]) == 2
    assert "locks" in capsys.readouterr().err
