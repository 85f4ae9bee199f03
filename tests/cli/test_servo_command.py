"""`pinpress servo`: what it prints and writes is what the library gives; every word it takes; what it says of wrong ones."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.in_browser import data_in
from support.refused_commands import one_line
from support.texts import shipped

import pinpress as pp
from pinpress.cli.main import main
from pinpress.cli.servo import LIMITS, PATHS, SERVO_DRIVE, limit, servo_path
from pinpress.cli.words.part_specs import part

ROOT = Path(__file__).resolve().parents[2]
TASK = ["zxn2_3000b", "--time", "60/25", "--load", "drawing:force=1500kN,start=60mm", "--points", 360]
SLIDE = ["--limit", "slide-speed:speed=0.2,heights=60mm/0"]
DRIVE = ["--drive", "inertia=1.5,ratio=60,gear_inertia=50,copper=0.0048"]
DRAWING, LIMIT = pp.loads.DeepDrawing(1.5e6, 0.06), pp.servo.SlideSpeed(0.2, (0.06, 0.0))


def printed(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    assert main(["servo", *map(str, arguments)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    return one_line(capsys, "servo", *arguments)


def best(**more: Any) -> pp.servo.MotionOptimum:
    """What the command is asked for, by the library."""
    drive = pp.servo.ServoDrive(inertia=1.5, ratio=60.0, gear_inertia=50.0, copper=0.0048)
    return pp.servo.best_motion(shipped("zxn2_3000b"), drive, [DRAWING], time=2.4, limits=[LIMIT], points=360, **more)


def test_it_prints_the_best_motion_beside_others_and_writes_nothing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    out, expected = printed(capsys, *TASK, *SLIDE, *DRIVE), best()
    assert out.startswith(f"{expected}\n\nMotionComparison for zxn2_3000b: 4 motions, least rms torque")
    assert f"\n\n{pp.servo.capacitor(expected.motion)}\n\nInputs\n" in out
    assert "two speeds" in out
    assert not list(tmp_path.iterdir())


def test_files(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out, expected = tmp_path / "made" / "out", best()
    printed(capsys, *TASK, *SLIDE, *DRIVE, "--step", "10ms", "--out", out, "--report")
    assert sorted(path.name for path in out.iterdir()) == ["angle.csv", "comparison.csv", "height.csv", "report.html", "servo.csv"]
    angles = np.loadtxt(out / "angle.csv", delimiter=",", skiprows=1)
    assert angles[:, 1] == pytest.approx(pp.servo.controller_table(expected.motion, step=0.01).values, abs=1e-9)
    with (out / "comparison.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == ["least heat", "constant crank speed", "two speeds", "constant slide speed"]
    assert float(rows[0]["rms_torque [N m]"]) == pytest.approx(expected.motion.rms_motor_torque, rel=1e-9)
    titles = [section["title"] for section in data_in(out / "report.html")["report"]["sections"]]
    assert {"Servo drive", "Motions beside one another", "Mains and capacitor"} <= set(titles)


def test_the_angles_that_it_writes_drive_a_simulation(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    printed(capsys, "crank_slide", "--time", 1, "--drive", "inertia=1", "--path", "stop", "--points", 60, "--out", tmp_path)
    motor = f"servo:program={tmp_path / 'angle.csv'},stiffness=1e5,damping=2e3,peak_torque=1e5,inertia=1"
    assert main(["simulate", "crank_slide", "--motor", motor, "--duration", "0.2", "--speed", "0", "--flywheel", "1"]) == 0
    assert "crank" in capsys.readouterr().out


@pytest.mark.exhaustive
def test_the_smallest_motor_of_a_catalogue(capsys: pytest.CaptureFixture[str]) -> None:
    catalogue = ["--motors", ROOT / "docs/servo_motors.csv", "--ratios", "60,80", "--gear-inertia", 50, "--points", 120]
    out = printed(capsys, *TASK, *SLIDE, *catalogue)
    assert out.startswith("MotorChoice for zxn2_3000b: example 800, ratio 60, ")
    assert main(["servo", *map(str, [*TASK, *SLIDE, *catalogue[:2], "--ratios", 200])]) == 2
    table, said = capsys.readouterr()
    assert "too warm" in table
    assert "no motor is sufficient" in said


def test_every_kind_of_path_and_limit_makes_its_part() -> None:
    for name, kind in PATHS.items():
        assert type(servo_path(f"{name}:{kind.example}")) is kind.made
    for name, kind in LIMITS.items():
        assert type(limit(f"{name}:{kind.example}")) is kind.made
    assert limit("slide-speed:speed=200mm/s,heights=60mm/0,flank=up,constant=no") == pp.servo.SlideSpeed(0.2, (0.06, 0.0), "up")
    assert limit("crank-speed:speed=60") == pp.servo.CrankSpeed(2 * np.pi)
    assert servo_path("turn:backwards=yes") == pp.servo.Turn(backwards=True)
    assert part("--drive", SERVO_DRIVE, "inertia=1,top_speed=3000,power=90kW").top_speed == pytest.approx(3000 * pp.RPM)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([*TASK], "give --drive or --motors, one of them"),
        ([*TASK, *DRIVE, "--motors", "a.csv"], "give --drive or --motors, one of them"),
        (["crank_slide", *DRIVE], "--time of a cycle is missing"),
        ([*TASK, "--motors", "a.csv"], "--motors needs the gear ratios"),
        ([*TASK, "--motors", "a.csv", "--ratios", "3", "--minimise", "time"], "--motors chooses the motor by its heat"),
        ([*TASK, *DRIVE, "--gear-inertia", 3], "--gear-inertia goes with --motors: --drive has it as a key"),
        ([*TASK, *DRIVE, "--pause", 3], "--pause goes with --motors: leave it out"),
        ([*TASK, *DRIVE, "--report"], "--report needs a folder"),
        ([*TASK, *DRIVE, "--limit", "slide-speed:speed=0.2,heights=60mm"], "heights is"),
        ([*TASK, *DRIVE, "--limit", "slide-sped:speed=0.2"], "no kind 'slide-sped', did you mean 'slide-speed'?"),
        ([*TASK, *DRIVE, "--path", "turn:backwards=maybe"], "backwards is 'maybe', neither yes nor no"),
        ([*TASK, *DRIVE, "--motors", "missing.csv"], "one of them"),
        ([*TASK, "--motors", "missing.csv", "--ratios", 3], "missing.csv cannot be read"),
    ],
)
def test_wrong_words_are_refused(capsys: pytest.CaptureFixture[str], words: list[object], said: str) -> None:
    assert said in refused(capsys, *words)


@pytest.mark.parametrize(("option", "words"), [("--time", "60/0"), ("--time", "soon"), ("--ratios", "3;4")])
def test_what_is_no_number_is_refused(capsys: pytest.CaptureFixture[str], option: str, words: str) -> None:
    with pytest.raises(SystemExit):
        main(["servo", "crank_slide", option, words])
    assert repr(words) in capsys.readouterr().err
