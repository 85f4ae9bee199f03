"""`pinpress simulate`: what it prints and writes is what the library gives; every word it takes; what it says of wrong ones."""

import csv
import dataclasses
import inspect
import io
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import texts
from support.generators.period_presses import of_two_motors
from support.refused_commands import one_line

import pinpress as pp
from pinpress.cli import main, simulate
from pinpress.cli.words import part_specs
from pinpress.common.quantities import CRANK
from pinpress.drives.motors import InductionMotor, InverterMotor, ServoMotor
from pinpress.drives.slip_clutch import SlipClutchMotor
from pinpress.drives.transmission import Geared, PrescribedSpeed
from pinpress.dynamics.extremes import at_peaks
from pinpress.loads.contacts import Impact, TwoSidedStop
from pinpress.loads.hydraulics import HydraulicCushion, ImpactDamper
from pinpress.loads.link import PointForce
from pinpress.loads.pneumatics import BalanceCylinder, PneumaticCushion
from pinpress.loads.process import Blanking, ConstantForce, DeepDrawing, ElasticDie, ForceStroke, Idle
from pinpress.loads.shearing import RateSensitiveBlanking

ROOT = Path(__file__).resolve().parents[2]
MOTOR = "induction:rated_power=75e3,rated_speed=1400,inertia=1.2,ratio=20.7,efficiency=0.95"
BLANKING = "blanking:force=2e6,start=0.006,end=0.002"
PRESSING = ["zxn2_3000b", "--speed", "70", "--flywheel", "2000", "--motor", MOTOR, "--load", BLANKING]
DIGITS = 5.1e-5  # five digits of the largest number of a section


def motor() -> Geared:
    return Geared(InductionMotor(75e3, 1400 * pp.RPM, inertia=1.2), 20.7, efficiency=0.95)


def printed(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    assert main.main(["simulate", *map(str, arguments)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    return one_line(capsys, "simulate", *arguments)


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


def test_prints_what_the_library_gives(capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, *PRESSING, "--duration", 2)
    assert "raise --points" not in text  # peaks are found between the states
    press, load = texts.shipped("zxn2_3000b"), Blanking(2e6, 0.006, 0.002)
    run = pp.simulate(press, 2.0, speed=70 * pp.RPM, drive=motor(), flywheel=pp.drives.Flywheel(2000.0), loads=[load])
    agree(text, press, run, [load])
    assert "drive         Geared(drive=InductionMotor(rated_power=75 kW, rated_speed=1400 r/min, " in text
    assert "load          Blanking(force=2000 kN, start=6 mm, end=2 mm, stripping=0 N)\n" in text
    assert "time taken" in text
    # a quarter sine of 2 MN over 4 mm takes 2 / pi x 2 MN x 4 mm a stroke
    assert value(text, "Run", "work of the loads") == pytest.approx(2 * 2 / np.pi * 2e6 * 0.004, rel=DIGITS)


def test_flywheel_alone_against_a_separate_integration(capsys: pytest.CaptureFixture[str]) -> None:
    """2000 kg m2 on the crank, 70 r/min, 2 s: by a solver that shares no code with this one 13.0853886242 rad, 7.1703212858 rad/s."""
    text = printed(capsys, "zxn2_3000b", "--speed", 70, "--flywheel", 2000, "--duration", 2)
    assert value(text, "Run", "crank angle at the end") == pytest.approx(np.degrees(13.0853886242), abs=6e-4)  # three decimals
    assert value(text, "Run", "crank speed at the end") == pytest.approx(7.1703212858 / pp.RPM, rel=DIGITS)
    assert "\n  motor" not in text


def test_many_strokes_are_listed_in_part(capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "crank_slide", "--duration", 14, "--motor", "prescribed:speed=60", "--points", 100)
    press = texts.shipped("crank_slide")
    agree(text, press, pp.simulate(press, 14.0, drive=PrescribedSpeed(60 * pp.RPM), points=100), [])
    assert "\n  ...\n" in text
    assert "crank angle 0 deg at 60 r/min" in text  # the drive's, as no other was given


def test_few_strokes_or_none(capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "crank_slide", "--duration", 8, "--motor", "prescribed:speed=60", "--points", 100)
    assert "..." not in text
    assert stroke_rows(text)[1][-1][0] == "8"
    assert "does not get through a period" in printed(capsys, "crank_slide", "--duration", 0.5, "--speed", 60, "--flywheel", 50)


def test_files(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "made" / "out"
    text = printed(capsys, *PRESSING, "--duration", 2, "--points", 200, "--out", out)
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


def test_strokes_without_rated_torque(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """There is no utilisation then, neither in the summary nor in the file; and of no stroke there is the header."""
    text = printed(capsys, "crank_slide", "--duration", 0.1, "--motor", "prescribed:speed=60", "--out", tmp_path)
    assert "motor, use" not in text
    assert len((tmp_path / "strokes.csv").read_text().splitlines()) == 1
    printed(capsys, "crank_slide", "--duration", 1.1, "--motor", "prescribed:speed=60", "--out", tmp_path)
    strokes = read(tmp_path / "strokes.csv")
    assert "utilisation [-]" not in strokes
    assert strokes["mean_speed [rad/s]"].tolist() == pytest.approx([2 * np.pi], rel=1e-9)


def read(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    with path.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    return dict(zip(header, np.array(rows, dtype=float).T, strict=True))


def test_steady(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    text = printed(capsys, *PRESSING, "--steady", "--angle", 30, "--out", tmp_path)
    press, load = texts.shipped("zxn2_3000b"), Blanking(2e6, 0.006, 0.002)
    run = pp.steady_state(
        press, 70 * pp.RPM, drive=motor(), flywheel=pp.drives.Flywheel(2000.0), loads=[load], angle=np.radians(30), points=720
    )
    agree(text, press, run, [load])
    assert "raise --points" not in text
    assert "one period, which repeats itself" in text
    assert value(text, "Steady state under the motor", "crank angle at the end") == 390
    assert value(text, "Steady state under the motor", "from lowest to highest") == pytest.approx(
        pp.measures.duty_cycle(run).recovery_time, rel=DIGITS
    )
    drive, loads = (value(text, "Steady state under the motor", f"work of the {name}") for name in ("drive", "loads"))
    assert drive == pytest.approx(loads, rel=DIGITS)  # or it were not steady
    assert len(read(tmp_path / "strokes.csv")["start [s]"]) == 1


@pytest.mark.exhaustive
def test_clutch_and_brake(capsys: pytest.CaptureFixture[str]) -> None:
    """A stroke from rest, as a press in single-stroke operation does it."""
    text = printed(
        capsys,
        *("zxn2_3000b", "--duration", 1.5, "--flywheel", "inertia=2000,speed=70", "--motor", MOTOR),
        *("--clutch", "torque=6e4,rise=0.1,closes=0.2s,opens=250deg", "--brake", "torque=4e4,closes=250deg"),
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


def test_every_option_reaches_the_simulation(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[dict[str, Any]] = []

    def spy(*args: Any, **kwargs: Any) -> Any:
        calls.append(inspect.signature(pp.simulate).bind(*args, **kwargs).arguments)
        return pp.simulate(*args, **kwargs)

    monkeypatch.setattr(simulate, "simulate", spy)
    printed(
        capsys,
        *("crank_slide", "--duration", 0.2, "--speed", 120, "--angle", 90, "--flywheel", 10, "--load", "idle"),
        *("--load", "die:height=0.001,stiffness=1e6", "--method", "constraint", "--step", 0.001, "--tolerance", 1e-9),
        *("--points", 17, "--gravity", 1.6),
    )
    (call,) = calls
    press = call.pop("press")
    np.testing.assert_array_equal(press.model.gravity.linear, [0, 0, -1.6])
    assert callable(call.pop("progress"))
    assert [type(load) for load in call.pop("loads")] == [Idle, ElasticDie]
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


@pytest.mark.exhaustive
def test_driver_and_slide(capsys: pytest.CaptureFixture[str]) -> None:
    """Driven at the rocker's pivot the six-bar is another machine."""
    text = printed(capsys, "zxn2_3000b", "--driver", "D", "--slide", "slide", "--duration", 0.05, "--flywheel", 5000, "--speed", 3)
    press = pp.load("zxn2_3000b", driver="D")
    agree(text, press, pp.simulate(press, 0.05, speed=3 * pp.RPM, flywheel=pp.drives.Flywheel(5000.0)), [])
    assert "no moving joint 'Q'" in refused(capsys, "zxn2_3000b", "--driver", "Q", "--duration", 1)
    assert "'rod' is not guided" in refused(capsys, "zxn2_3000b", "--slide", "rod", "--duration", 1)


@pytest.fixture
def files(tmp_path: Path) -> dict[str, Path]:
    """CSV files, as spreadsheets write them: with header or without, a byte order mark, empty lines."""
    texts = {
        "curve": "\ufefffrequency [Hz],torque [N m]\n10,600\n50,700\n",
        "program": "time [s],angle [deg]\n0,0\n\n1,180\n2,360\n",
        "force": "0.02,0\n0.001,5e5\n0,6e5\n",
    }
    for name, text in texts.items():
        (tmp_path / f"{name}.csv").write_text(text, encoding="utf-8")
    return {name: tmp_path / f"{name}.csv" for name in texts}


def test_every_kind_of_drive(files: dict[str, Path]) -> None:
    rpm = pp.RPM
    cases = {
        "constant:value=-567": pp.drives.ConstantTorque(-567.0),
        "constant:value=567,ratio=3,gear_inertia=2,efficiency=0.9": Geared(pp.drives.ConstantTorque(567.0), 3.0, 2.0, 0.9),
        "induction:rated_power=75e3,rated_speed=985,poles=6": InductionMotor(75e3, 985 * rpm, poles=6),
        MOTOR: motor(),
        f"inverter:rated_torque=482,rated_speed=1485,frequency=40,curve={files['curve']}": InverterMotor(
            482.0, 1485 * rpm, 40.0, curve=((10.0, 600.0), (50.0, 700.0))
        ),
        "inverter:rated_torque=482,rated_speed=1485,frequency=40,overload=2": InverterMotor(482.0, 1485 * rpm, 40.0, overload=2.0),
        "slip-clutch:rated_torque=189,primary_speed=1470,top_speed=1320,set_speed=900,lag=0.2,ratio=-3": Geared(
            SlipClutchMotor(189.0, 1470 * rpm, 1320 * rpm, 900 * rpm, lag=0.2), -3.0
        ),
        f"servo:program={files['program']},stiffness=2e4,damping=900,peak_torque=5e3,rated_torque=2e3": ServoMotor(
            (0.0, 1.0, 2.0), tuple(np.radians([0.0, 180.0, 360.0]).tolist()), 2e4, 900.0, 5e3, rated_torque=2e3
        ),
        "prescribed:speed=-70": PrescribedSpeed(-70 * rpm),
    }
    assert {words.partition(":")[0] for words in cases} == set(part_specs.MOTORS)
    for words, drive in cases.items():
        assert part_specs.motor(words, CRANK) == drive


def test_every_kind_of_load(files: dict[str, Path]) -> None:
    cases = {
        "idle": Idle(),
        "idle:datum=0.1": Idle(0.1),
        "constant-force:force=1e6,height=0.0005": ConstantForce(1e6, 0.0005),
        "blanking:force=1e6,start=0.006,end=0.002,stripping=3e4,datum=-0.9": Blanking(1e6, 0.006, 0.002, 3e4, -0.9),
        "drawing:force=5e5,start=0.05": DeepDrawing(5e5, 0.05),
        f"table:file={files['force']}": ForceStroke([0.02, 0.001, 0.0], [0.0, 5e5, 6e5]),
        "die:height=0.001,stiffness=1e9,damping=1e4": ElasticDie(0.001, 1e9, 1e4),
        "shearing:force=6e5,start=4mm,end=2mm,sensitivity=0.05,reference_speed=1mm/s,peak=3mm,remaining=50%": RateSensitiveBlanking(
            6e5, 0.004, 0.002, 0.05, 1e-3, 0.003, 0.5
        ),
        "impact-damper:heights=0/5mm/8mm,coefficients=2e6/1e6/0,exponent=1.5": ImpactDamper([0.0, 0.005, 0.008], [2e6, 1e6, 0.0], 1.5),
        "hydraulic-cushion:force=300kN,height=60mm,rise=1mm,return_force=20kN": HydraulicCushion(3e5, 0.06, 1e-3, 2e4),
        "impact:height=1mm,stiffness=1e10,damping=1e5,depth=0.1mm": Impact(0.001, 1e10, 1.5, 1e5, 1e-4),
        "stops:lower=-1mm,upper=32mm,stiffness=1e10,exponent=2": TwoSidedStop(-0.001, 0.032, 1e10, 2.0),
        "balance-cylinder:bore=160mm,pressure=6bar,volume=80l,count=2,exponent=1.2": BalanceCylinder(
            0.16, 6e5, 0.08, count=2, exponent=1.2
        ),
        "air-cushion:bore=200mm,pressure=5bar,volume=40l,height=12mm": PneumaticCushion(0.2, 5e5, 0.04, 0.012),
        "point-force:link=rod,force=0/-2kN/5,point=1mm/0/0.1": PointForce("rod", (0.0, -2e3, 5.0), (0.001, 0.0, 0.1)),
    }
    assert {words.partition(":")[0] for words in cases} == set(part_specs.LOADS)
    for words, load in cases.items():
        found = part_specs.load(words)
        assert type(found) is type(load)
        for field in dataclasses.fields(load):
            np.testing.assert_array_equal(getattr(found, field.name), getattr(load, field.name))


def test_units_in_the_header_of_a_file(tmp_path: Path) -> None:
    file = tmp_path / "stroke.csv"
    file.write_text("height [mm], force [kN]\n2,0\n1,300\n0,1600\n", encoding="utf-8")
    found = part_specs.load(f"table:file={file}")
    assert isinstance(found, ForceStroke)
    np.testing.assert_allclose(np.transpose([found.heights, found.forces]), [[0.0, 1.6e6], [0.001, 3e5], [0.002, 0.0]], rtol=1e-15)
    file.write_text("height [mm], force [lbf]\n2,0\n", encoding="utf-8")
    with pytest.raises(pp.PinpressError, match="in 'lbf', which is none of N, kN, MN, tf"):
        part_specs.load(f"table:file={file}")
    file.write_text("height [mm];force [kN]\r\n2,5;0\r\n0;1600\r\n", encoding="utf-16")  # as a spreadsheet in German saves it
    found = part_specs.load(f"table:file={file}")
    assert isinstance(found, ForceStroke)
    np.testing.assert_allclose(np.transpose([found.heights, found.forces]), [[0.0, 1.6e6], [0.0025, 0.0]], rtol=1e-15)
    file.write_text("height, force\n2,0\n1;0\n", encoding="utf-8")
    with pytest.raises(
        pp.PinpressError, match=r"in line 3: 1 cells for 2 columns: .* give a CSV file with the columns height \[m\], force \[N\]"
    ):
        part_specs.load(f"table:file={file}")


@pytest.mark.exhaustive
def test_each_kind_runs(capsys: pytest.CaptureFixture[str], files: dict[str, Path]) -> None:
    """By the example that the help gives, on a press small enough for all of them. A servo's program begins at rest."""
    bare = ("crank_slide", "--angle", 30, "--duration", 0.05, "--points", 20, "--speed")
    swap = {"motion.csv": files["program"], "stroke.csv": files["force"]}
    for option, kinds in (("--motor", part_specs.MOTORS), ("--load", part_specs.LOADS)):
        for name, kind in kinds.items():
            words = re.sub(r"\w+\.csv", lambda match: str(swap[match[0]]), f"{name}:{kind.example}")
            speed = 0 if kind.made is pp.drives.ServoMotor else 70
            text = printed(capsys, *bare, speed, "--flywheel", 500, option, words)
            assert re.search(
                rf"^  {option[2:].replace('motor', 'drive')} +(Geared\(drive=)?{kind.made.__name__}\(", text, flags=re.MULTILINE
            )
    for option, kind in (("--clutch", part_specs.CLUTCH), ("--brake", part_specs.BRAKE)):
        printed(capsys, *bare, 70, "--flywheel", 500, option, kind.example)
    printed(capsys, *bare, 70, "--flywheel", part_specs.FLYWHEEL.example)


def test_help_lists_every_field(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match=r"^0$"):
        main.main(["simulate", "--help"])
    shown = capsys.readouterr().out
    lines = shown.splitlines()
    for name, kind in (*part_specs.MOTORS.items(), *part_specs.LOADS.items()):
        line = next(line for line in lines if line.startswith(f"  {name}:"))
        from_file = () if kind.table is None else kind.table.into
        for field in dataclasses.fields(kind.made):
            assert field.name in from_file or re.search(rf"\b{field.name}\b", line)
        assert kind.table is None or f"{kind.table.key}=FILE" in line
        assert ("[ratio]" in line) == kind.geared
    assert "r/min" in shown
    assert "closes=0.1s|180deg" in shown


DURATION = ["zxn2_3000b", "--duration", "1"]


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--motor", "motor:value=3"], ["no kind 'motor'", "constant, induction, inverter", "--motor constant:value=567"]),
        (["--motor", "inductoin:x=3"], ["did you mean 'induction'?"]),
        (["--motor", "constant:torque=3"], ["no key 'torque'", "it takes value [ratio]", "--motor constant:value=567"]),
        (["--motor", "induction:rated_pwr=3"], ["did you mean 'rated_power'?", "rated_speed=RPM", "speeds in r/min"]),
        (["--motor", "induction"], ["--motor induction: rated_power and rated_speed are missing"]),
        (["--motor", "constant:value=1,efficiency=0.9"], ["ratio is missing"]),
        (["--motor", "constant:value=7,5"], ["'5' is not key=value"]),
        (["--motor", "constant:value=1,value=2"], ["value is given twice"]),
        (["--motor", "constant:value="], ["value is '', no number"]),
        (["--motor", "constant:value=nan"], ["finite number [N m]"]),
        (["--motor", "induction:rated_power=1,rated_speed=1600"], ["1600 r/min", "give a rated_speed below it"]),
        (["--motor", "induction:rated_power=1,rated_speed=985,poles=5.5"], ["poles is '5.5', no whole number"]),
        (["--motor", "prescribed:speed=70,ratio=2"], ["no key 'ratio'"]),
        (["--motor", "prescribed:speed=70", "--speed", "60"], ["the drive prescribes"]),
        (["--motor", "servo:program=none.csv,stiffness=1,damping=1,peak_torque=1"], ["none.csv", "time [s], angle [deg]"]),
        (
            ["--motor", "inverter:rated_torque=1,rated_speed=1485,frequency=40,curve=README.md"],
            ["curve is 'README.md', in line ", "frequency [Hz], torque [N m]"],
        ),
        (["--load", "press:force=1"], ["no kind 'press'", "idle, constant-force, blanking, drawing, table, die"]),
        (["--load", "table:"], ["--load table: file is missing"]),
        (["--load", "table:file=viz/zxn2_3000b.png"], ["no text in UTF-8; save it in this encoding"]),
        (["--load", "die:height=x,stiffness=1"], ["height is 'x', no number", "--load die:height=0.001"]),
        (["--load", "blanking:force=1,start=0,end=1"], ["start is 0, not above end, 1"]),
        (["--flywheel", "heavy"], ["inertia is 'heavy', no number", "--flywheel inertia=2000"]),
        (["--flywheel", "inertia=1,mass=2"], ["no key 'mass'", "it takes inertia [speed=RPM]"]),
        (["--flywheel=-1e6"], ["the inertia of linkage, flywheel and drive at the crank is"]),
        (["--clutch", "torque=5,closes=3"], ["closes is '3', neither a time as 0.1s nor a crank angle as 180deg"]),
        (["--clutch", "torque=5,closes=nans"], ["closes is 'nans'"]),
        (["--clutch", "torque=6e4,closes=0.2s"], ["a clutch needs an inertia on its driving side"]),
        (["--brake", "rise=0.1"], ["torque is missing", "--brake torque=4e4"]),
        (["--tolerance", "1"], ["tolerance is 1"]),
        (["--points", "1"], ["points is 1"]),
        (["--gravity", "inf"], ["gravity"]),
        (["--speed", "nan"], ["speed is nan"]),
        (["--out", "README.md"], ["README.md"]),
    ],
)
def test_errors_list_what_there_is(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, arguments: list[str], says: list[str]
) -> None:
    monkeypatch.chdir(ROOT)
    error = refused(capsys, *DURATION, *arguments)
    for words in says:
        assert words in error


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--speed", "70"], "--steady needs a --motor"),
        (["--motor", "constant:value=5"], "the approximate speed of the press, not 0"),
        (["--speed", "70", "--motor", "constant:value=5"], "no steady state is found"),
        (["--speed", "70", "--motor", "prescribed:speed=70"], "needs a motor"),
        (["--speed", "70", "--motor", MOTOR, "--clutch", "torque=5"], "--clutch does not go with --steady"),
        (["--speed", "70", "--motor", MOTOR, "--brake", "torque=5"], "--brake does not go with --steady"),
        (["--speed", "70", "--motor", MOTOR, "--step", "0.1"], "--step does not go with --steady"),
        (["--speed", "70", "--motor", MOTOR, "--method", "constraint"], "--method does not go with --steady"),
    ],
)
def test_errors_of_the_steady_state(capsys: pytest.CaptureFixture[str], arguments: list[str], says: str) -> None:
    assert says in refused(capsys, "zxn2_3000b", "--steady", *arguments)


@pytest.mark.parametrize(
    "arguments", [[], ["--duration", "1", "--steady"], ["--duration", "soon"], ["--duration", "1", "--method", "best"]]
)
def test_usage_errors_exit_with_2(capsys: pytest.CaptureFixture[str], arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main.main(["simulate", "zxn2_3000b", *arguments])
    assert stop.value.code == 2
    assert "usage: pinpress simulate" in capsys.readouterr().err


def test_several_drivers(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    press, file = of_two_motors(), tmp_path / "motors.urdf"
    file.write_bytes(press.text)
    words = ["--speed", "O=60", "--speed", "P=-30rpm", "--angle", "P=20deg", "--motor", "O:constant:value=40", "--flywheel", "P:0.5"]
    text = printed(capsys, file, "--duration", 0.2, *words, "--out", tmp_path / "out")
    drive, flywheel = {"O": pp.drives.ConstantTorque(40.0)}, {"P": pp.drives.Flywheel(0.5)}
    start = {"speed": [60 * pp.RPM, -30 * pp.RPM], "angle": [0.0, np.radians(20.0)]}
    run = pp.simulate(press, 0.2, drive=drive, flywheel=flywheel, **start)
    for k, driver in enumerate("OP"):
        row = next(line.split() for line in text.splitlines() if line.startswith(f"  {driver} "))
        assert row[1:5:2] == [f"{np.degrees(run.crank_angle[end, k]):.3f}" for end in (0, -1)]
    assert "drive of O, largest" in text
    assert "drive of P" not in text
    assert "flywheels and drives   inertia 0 kg m2 at O, 0.5 kg m2 at P" in text
    columns = np.genfromtxt(tmp_path / "out" / "simulation.csv", delimiter=",", names=True)
    np.testing.assert_allclose(columns["crank_angle_P_rad"], run.crank_angle[:, 1], rtol=1e-12)
    assert not (tmp_path / "out" / "strokes.csv").exists()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--speed", "60"], "--speed needs the name of one of the 2 drivers of geared_five_bar: write e.g. --speed O=30"),
        (
            ["--motor", "constant:value=4"],
            "--motor needs the name of one of the 2 drivers of geared_five_bar: write e.g. --motor O:constant:value=567",
        ),
        (["--speed", "O=6", "--speed", "O=7"], "--speed of O is given twice"),
        (["--angle", "Q=6"], "no driver 'Q'"),
        (["--clutch", "torque=60,closes=0.1s"], "clutch and brake are for one; leave them out"),
        (["--stiffness", "all=1e9", "--moment-stiffness", "all=1e6"], "elastic motion is that of"),
    ],
)
def test_wrong_words_for_several_drivers(words: list[str], says: str, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "motors.urdf"
    file.write_bytes(of_two_motors().text)
    assert says in refused(capsys, file, "--duration", 0.1, *words)


def test_several_drivers_have_no_steady_state(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "motors.urdf"
    file.write_bytes(of_two_motors().text)
    assert "give --duration in place of --steady" in refused(capsys, file, "--steady", "--speed", "O=60", "--motor", "O:constant:value=4")


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_progress_is_what_the_simulation_reports(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """A short run on a terminal reports, but shows nothing: neither bar nor remains of one."""
    reached: list[float] = []
    original = simulate.simulate  # type: ignore[attr-defined]

    def spy(*args: Any, progress: Any, **kwargs: Any) -> Any:
        def both(time: float) -> None:
            reached.append(time)
            progress(time)

        return original(*args, progress=both, **kwargs)

    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(simulate, "simulate", spy)
    assert main.main(["simulate", "crank_slide", "--speed", "60", "--duration", "3", "--flywheel", "50"]) == 0
    assert reached[-1] == pytest.approx(3.0)
    assert terminal.getvalue() == ""


@pytest.mark.exhaustive
def test_as_a_user_runs_it(tmp_path: Path) -> None:
    def run(*arguments: object) -> subprocess.CompletedProcess[str]:
        words = [sys.executable, "-m", "pinpress", "simulate", *map(str, arguments)]
        return subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, timeout=60)

    done = run(*PRESSING, "--duration", 1, "--out", "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["recording.html", "simulation.csv", "strokes.csv"]
    wrong = run("zxn2_3000b", "--duration", 1, "--flywheel=-1e6")
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert wrong.stderr.startswith("pinpress: the inertia of linkage, flywheel and drive")
    assert wrong.stderr.count("\n") == 1
