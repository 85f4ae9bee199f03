"""`pinpress simulate`: what it prints and writes is what the library gives; every word it takes; what it says of wrong ones."""

import csv
import dataclasses
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import texts
from support.generators.period_presses import of_two_motors

import pinpress as pp
from pinpress.cli.main import main
from pinpress.drives.motors import InductionMotor
from pinpress.drives.transmission import Geared, PrescribedSpeed
from pinpress.dynamics.extremes import at_peaks
from pinpress.loads.process import Blanking

PRESSING = """\
file: zxn2_3000b
speed: 70 r/min
flywheel: 2000 kg m2
motor: {kind: induction, rated_power: 75 kW, rated_speed: 1400 r/min, inertia: 1.2 kg m2, ratio: 20.7, efficiency: 0.95}
loads: {blank: {kind: blanking, force: 2 MN, start: 6 mm, end: 2 mm}}
"""
PRESCRIBED = "file: crank_slide\nmotor: {kind: prescribed, speed: 60 r/min}\n"
DIGITS = 5.1e-5  # five digits of the largest number of a section


def motor() -> Geared:
    return Geared(InductionMotor(75e3, 1400 * pp.RPM, inertia=1.2), 20.7, efficiency=0.95)


def printed(capsys: pytest.CaptureFixture[str], folder: Path, job: str, out: Path | None = None) -> str:
    """What the command prints of a job; with ``out``: it also writes its files there."""
    file = folder / "job.yaml"
    file.write_text(job, encoding="utf-8")
    assert main(["simulate", str(file), *([] if out is None else ["--out", str(out)])]) == 0
    said, err = capsys.readouterr()
    assert err == ""
    return said


PREFIXES = {"k": 1e3, "M": 1e6}


def value(text: str, section: str, name: str) -> float:
    """The number behind a name in a section of the summary, in SI units or r/min, degrees and percent."""
    start = text.index(f"\n{section}\n")
    body = text[start:].split("\n\n", 1 if start else 0)[0]
    body = text[start:] if section == "Bearings and guides" else body
    ((number, prefix),) = re.findall(rf"^  {re.escape(name)} {{2,}}(\S+)(?: ([kM])(?:N m|J|N|W)\b)?", body, flags=re.MULTILINE)
    return float(number) * PREFIXES.get(prefix, 1.0)


def peak(text: str, bearing: str) -> float:
    """The peak force of a bearing in the table [N]."""
    (unit,) = re.findall(r"peak force \[([kM]?)N\]", text)
    return value(text, "Bearings and guides", bearing) * PREFIXES.get(unit, 1.0)


def agree(text: str, press: pp.Linkage, run: pp.Run, loads: list[Any]) -> None:
    """Every number of the summary is the library's."""
    whole, result = pp.measures.duty_cycle(run), at_peaks(pp.inverse_dynamics(press, run, loads=loads)).reactions
    run_section = "Steady state under the motor" if "\nSteady state under the motor\n" in text else "Run"
    expected = {
        (run_section, "crank angle at the end"): np.degrees(run.crank_angle[-1]),
        (run_section, "crank speed at the end"): run.crank_speed[-1] / pp.RPM,
        (run_section, "mean speed"): whole.mean_speed / pp.RPM,
        (run_section, "speed drop"): 100 * whole.speed_drop,
        (run_section, "work of the drive"): whole.drive_work,
        (run_section, "work of the loads"): whole.load_work,
        (run_section, "work of the flywheel"): whole.flywheel_work,
        (run_section, "lost"): whole.lost,
        ("Drive", "largest torque"): result.driving_torque.max(),
        ("Drive", "smallest torque"): result.driving_torque.min(),
        ("Checks", "steps"): run.stats.steps,
    }
    if run.problem.driven.drive is not None:
        expected |= {(run_section, "motor, rms"): whole.motor_rms, (run_section, "motor, peak"): whole.motor_peak}
    if whole.utilisation is not None:
        expected[(run_section, "motor, use")] = 100 * whole.utilisation
    largest = max(abs(whole.drive_work), abs(whole.load_work))
    for (section, name), number in expected.items():
        rounding = 6e-4 if "angle" in name else max(1e-9 * largest, 1e-9) if "work" in name or name == "lost" else 1e-9
        allowed = max(DIGITS * abs(number), rounding)
        assert value(text, section, name) == pytest.approx(number, abs=allowed), (section, name)
    ends = re.search(r"speed drop .*, (\S+) r/min to (\S+) r/min", text)
    assert [float(end) for end in ends.groups()] == pytest.approx([whole.lowest_speed / pp.RPM, whole.highest_speed / pp.RPM], rel=DIGITS)
    peaks = {name: np.linalg.norm(force, axis=1).max() for name, force in result.bearing_force.items()}
    for name, force in peaks.items():
        assert peak(text, name) == pytest.approx(force, rel=DIGITS, abs=1e-4 * max(peaks.values()))
    strokes = pp.measures.stroke_duties(run)
    heads, rows = stroke_rows(text)
    kept = [
        k for k in range(len(strokes)) if len(strokes) <= MOST_STROKES or k < MOST_STROKES // 2 or k >= len(strokes) - MOST_STROKES // 2
    ]
    assert [row[0] for row in rows if row[0] != "..."] == [str(k + 1) for k in kept]
    shown = np.array([[float(cell) for cell in row] for row in rows if row[0] != "..."]).reshape(-1, 8)
    sizes = [{"ms": 1e-3, "r/min": pp.RPM, "kJ": 1e3, "kN m": 1e3}.get(unit, 1.0) for unit in re.findall(r"\[(.*?)\]", heads)]
    names = ("start", "duration", "mean_speed", "lowest_speed", "drive_work", "load_work", "motor_rms")
    for column, name, size in zip(shown[:, 1:].T, names, sizes, strict=True):
        values = np.array([getattr(strokes[k], name) for k in kept])
        np.testing.assert_allclose(size * column, values, rtol=0, atol=DIGITS * np.abs(values).max(initial=1e-6), err_msg=name)


MOST_STROKES = 12  # of which all are listed


def stroke_rows(text: str) -> tuple[str, list[list[str]]]:
    """The head and the rows of the table of strokes."""
    part = next((part for part in text.split("\n\n") if part.startswith("  Strokes")), "\n")
    lines = part.split("\n")
    return (lines[1], [line.split() for line in lines[2:] if line.split()]) if len(lines) > 2 else ("[s][s][r/min][r/min][J][J][N m]", [])


def test_prints_what_the_library_gives(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    text = printed(capsys, tmp_path, PRESSING + "run: {duration: 2 s}\n")
    assert "raise run.points" not in text  # peaks are found between the states
    press, load = texts.shipped("zxn2_3000b"), Blanking(2e6, 0.006, 0.002)
    run = pp.simulate(press, 2.0, speed=70 * pp.RPM, drive=motor(), flywheel=pp.drives.Flywheel(2000.0), loads=[load])
    agree(text, press, run, [load])
    assert "drive         geared: ratio = " in text
    assert "load          blanking: force = 2000 kN, start = 6 mm, end = 2 mm, stripping = 0 N\n" in text
    assert "time taken" in text
    # a quarter sine of 2 MN over 4 mm takes 2 / pi x 2 MN x 4 mm a stroke
    assert value(text, "Run", "work of the loads") == pytest.approx(2 * 2 / np.pi * 2e6 * 0.004, rel=DIGITS)


def test_flywheel_alone_against_a_separate_integration(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """2000 kg m2 on the crank, 70 r/min, 2 s: by a solver that shares no code with this one 13.0853886242 rad, 7.1703212858 rad/s."""
    text = printed(capsys, tmp_path, "file: zxn2_3000b\nspeed: 70 r/min\nflywheel: 2000 kg m2\nrun: {duration: 2 s}\n")
    assert value(text, "Run", "crank angle at the end") == pytest.approx(np.degrees(13.0853886242), abs=6e-4)  # three decimals
    assert value(text, "Run", "crank speed at the end") == pytest.approx(7.1703212858 / pp.RPM, rel=DIGITS)
    assert "\n  motor" not in text


@pytest.mark.exhaustive
def test_many_strokes_are_listed_in_part(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    text = printed(capsys, tmp_path, PRESCRIBED + "run: {duration: 14 s, points: 100}\n")
    press = texts.shipped("crank_slide")
    agree(text, press, pp.simulate(press, 14.0, drive=PrescribedSpeed(60 * pp.RPM), points=100), [])
    assert "\n  ...\n" in text
    assert "crank angle 0 deg at 60 r/min" in text  # the drive's, as no other was given


def test_few_strokes_or_none(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    text = printed(capsys, tmp_path, PRESCRIBED + "run: {duration: 8 s, points: 100}\n")
    assert "..." not in text
    assert stroke_rows(text)[1][-1][0] == "8"
    assert "does not get through a period" in printed(
        capsys, tmp_path, "file: crank_slide\nflywheel: 50 kg m2\nrun: {duration: 0.5 s, speed: 60 r/min}\n"
    )


@pytest.mark.exhaustive
def test_files(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "made" / "out"
    text = printed(capsys, tmp_path, PRESSING + "run: {duration: 2 s, points: 200}\n", out)
    assert all(str(out / name) in text for name in ("simulation.csv", "strokes.csv", "recording.html"))
    press, load = texts.shipped("zxn2_3000b"), Blanking(2e6, 0.006, 0.002)
    run = pp.simulate(press, 2.0, speed=70 * pp.RPM, drive=motor(), flywheel=pp.drives.Flywheel(2000.0), loads=[load], points=200)
    result = pp.inverse_dynamics(press, run, loads=[load])
    simulation = read(out / "simulation.csv")
    assert len(simulation["time [s]"]) == 200
    for name, values in {
        "time [s]": run.time,
        "crank_speed [rad/s]": run.crank_speed,
        "drive_torque [N m]": run.drive_torque,
        "load_work [J]": run.load_work,
        "driving_torque [N m]": result.driving_torque,
        "force_E_z [N]": result.bearing_force["E"][:, 2],
    }.items():
        np.testing.assert_array_equal(simulation[name], values)
    strokes, found = read(out / "strokes.csv"), pp.measures.stroke_duties(run)
    known = [field.name for field in dataclasses.fields(pp.measures.MotorDuty) if getattr(found[0], field.name) is not None]
    assert [name.partition(" [")[0] for name in strokes] == known
    for name, column in strokes.items():
        assert column.tolist() == [getattr(stroke, name.partition(" [")[0]) for stroke in found]
    page = (out / "recording.html").read_text(encoding="utf-8")
    assert 300_000 < len(page) < 600_000


@pytest.mark.exhaustive
def test_strokes_without_rated_torque(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """There is no utilisation then, neither in the summary nor in the file; and of no stroke there is the header."""
    text = printed(capsys, tmp_path, PRESCRIBED + "run: {duration: 0.1 s}\n", tmp_path)
    assert "motor, use" not in text
    assert len((tmp_path / "strokes.csv").read_text().splitlines()) == 1
    printed(capsys, tmp_path, PRESCRIBED + "run: {duration: 1.1 s}\n", tmp_path)
    strokes = read(tmp_path / "strokes.csv")
    assert "utilisation [-]" not in strokes
    assert strokes["mean_speed [rad/s]"].tolist() == pytest.approx([2 * np.pi], rel=1e-9)


def read(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    with path.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    return dict(zip(header, np.array(rows, dtype=float).T, strict=True))


@pytest.mark.exhaustive
def test_steady(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    text = printed(capsys, tmp_path, PRESSING + "run: {steady: yes, angle: 30 deg}\n", tmp_path)
    press, load = texts.shipped("zxn2_3000b"), Blanking(2e6, 0.006, 0.002)
    run = pp.steady_state(
        press, 70 * pp.RPM, drive=motor(), flywheel=pp.drives.Flywheel(2000.0), loads=[load], angle=np.radians(30), points=720
    )
    agree(text, press, run, [load])
    assert "raise run.points" not in text
    assert "one period, which repeats itself" in text
    assert value(text, "Steady state under the motor", "crank angle at the end") == 390
    assert value(text, "Steady state under the motor", "from lowest to highest") == pytest.approx(
        pp.measures.duty_cycle(run).recovery_time, rel=DIGITS
    )
    drive, loads = (value(text, "Steady state under the motor", f"work of the {name}") for name in ("drive", "loads"))
    assert drive == pytest.approx(loads, rel=DIGITS)  # or it were not steady
    assert len(read(tmp_path / "strokes.csv")["start [s]"]) == 1


@pytest.mark.exhaustive
def test_clutch_and_brake(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A stroke from rest, as a press in single-stroke operation does it."""
    text = printed(
        capsys,
        tmp_path,
        PRESSING.partition("loads:")[0].replace("speed: 70 r/min\n", "").replace("2000 kg m2", "{inertia: 2000 kg m2, speed: 70 r/min}")
        + "clutch: {torque: 60 kN m, rise: 0.1 s, closes: 0.2 s, opens: 250 deg}\nbrake: {torque: 40 kN m, closes: 250 deg}\n"
        + "run: {duration: 1.5 s}\n",
    )
    press, angle = texts.shipped("zxn2_3000b"), np.radians(250)
    run = pp.simulate(
        press,
        1.5,
        drive=motor(),
        flywheel=pp.drives.Flywheel(2000.0, speed=70 * pp.RPM),
        clutch=pp.drives.Clutch(6e4, pp.drives.SwitchPoint(time=0.2), pp.drives.SwitchPoint(angle=angle), rise=0.1),
        brake=pp.drives.Brake(4e4, pp.drives.SwitchPoint(angle=angle)),
    )
    agree(text, press, run, [])
    assert value(text, "Run", "lost") > 1000
    assert value(text, "Run", "crank speed at the end") == 0


def test_every_key_of_a_run_reaches_the_simulation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[dict[str, Any]] = []

    def spy(*args: Any, **given: Any) -> Any:
        calls.append(given | dict(zip(("press", "duration"), args, strict=True)))
        return pp.simulate(*args, **given)

    monkeypatch.setattr("pinpress.jobs.job.simulate", spy)
    run = {
        "duration": 0.2,
        "speed": "120 r/min",
        "angle": "90 deg",
        "method": "constraint",
        "step": "1 ms",
        "tolerance": 1e-9,
        "points": "17",
    }
    job = pp.job("crank_slide", gravity=1.6, flywheel=10.0, loads={"die": {"kind": "die", "height": 0.001, "stiffness": 1e6}}, run=run)
    told: list[float] = []
    job.simulate(told.append)
    (call,) = calls
    np.testing.assert_array_equal(call.pop("press").model.gravity.linear, [0, 0, -1.6])
    assert call.pop("progress") == told.append
    assert [type(load) for load in call.pop("loads")] == [pp.loads.ElasticDie]
    assert call == {
        "duration": 0.2,
        "friction": {},
        "speed": 120 * pp.RPM,
        "angle": np.radians(90),
        "drive": None,
        "flywheel": pp.drives.Flywheel(10.0),
        "method": "constraint",
        "clutch": None,
        "brake": None,
        "points": 17,
        "step": 0.001,
        "tolerance": 1e-9,
    }


def test_several_drivers_have_motors_and_speeds_by_their_names(tmp_path: Path) -> None:
    press = shipped_five_bar(tmp_path)
    first, second = press.drivers
    motors = {first: {"kind": "constant", "value": 5.0}, second: {"kind": "constant", "value": -5.0}}
    job = pp.job(tmp_path / "press.urdf", motor=motors, run={"duration": 0.02, "speed": {first: "30 r/min", second: "-30 r/min"}})
    drives = {first: pp.drives.ConstantTorque(5.0), second: pp.drives.ConstantTorque(-5.0)}
    run = pp.simulate(press, 0.02, speed=[30 * pp.RPM, -30 * pp.RPM], drive=drives)
    np.testing.assert_array_equal(job.simulate().crank_angle, run.crank_angle)
    with pytest.raises(
        pp.PinpressError, match=r"the press has 2 drivers, .*, and one value does not say how they move together; write motion:"
    ):
        pp.job(tmp_path / "press.urdf", speed="30 r/min")


def shipped_five_bar(folder: Path) -> pp.Linkage:
    (folder / "press.urdf").write_bytes(of_two_motors().text)
    return pp.load(folder / "press.urdf")
