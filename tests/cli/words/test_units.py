"""Numbers of the command line with units: the same run as without; what is wrong with them is said."""

import contextlib
import math
import re

import pytest
from support.presses import sliding_presses

import pinpress as pp
from pinpress.cli.main import main
from pinpress.cli.words import part_specs
from pinpress.common.arguments import read_quantity, unit_factor
from pinpress.common.quantities import CRANK, QUANTITIES, RAM, readable
from pinpress.drives.motors import ConstantTorque, ServoMotor
from pinpress.drives.transmission import Geared, PrescribedSpeed


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("12mm", "m", 0.012),
        ("12 mm", "m", 0.012),
        ("1.5e3kN", "N", 1.5e6),
        ("-70rpm", "r/min", -70),
        ("7.5rad/s", "r/min", 7.5 * 30 / math.pi),
        ("420deg/s", "r/min", 70),
        ("0.5rad", "deg", math.degrees(0.5)),
        ("20%", "-", 0.2),
        ("1e3", "N", 1000),
        (".5", "m", 0.5),
        ("inf", "m", math.inf),
        ("120kN/mm", "N/m", 1.2e8),
        ("50µm", "m", 5e-5),
        ("50\u03bcm", "m", 5e-5),
        ("-30°", "deg", -30),
        ("5 kN m", "N m", 5000),
        ("3 kN m/rad", "N m/rad", 3000),
        ("60 1/min", "r/min", 60),
    ],
)
def test_quantities(text, unit, value):
    assert read_quantity(text, unit) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("12kn", "did you mean 'kN'"),
        ("12mm", "none of N, kN"),
        ("1,5", "after a point"),
        ("", "no number"),
        ("x", "no"),
        ("3€", "in '€', which"),
        ("601/min", "no number"),  # 60 1/min, or 601 of something
    ],
)
def test_what_is_none(text, said):
    with pytest.raises(ValueError, match=said):
        read_quantity(text, "N")


def test_units_of_columns():
    assert unit_factor("1/min", "r/min") == unit_factor("rpm", "r/min") == 1.0
    with pytest.raises(ValueError, match="in '1/min', which is none of deg"):
        unit_factor("1/min", "deg")


def test_first_units_are_those_that_help_names():
    for unit in {unit for each in QUANTITIES for unit in each.sizes()}:
        assert next(iter(readable(unit).items())) == (unit, 1.0)


SAID_ELSE = ("time taken", "flywheel  ", "drawing:")  # the words as they were given


def figures(capsys, *words):
    assert main([*words]) == 0
    return [line for line in capsys.readouterr().out.splitlines() if not any(word in line for word in SAID_ELSE)]


@pytest.mark.parametrize(
    ("plain", "named"),
    [
        (("analyse", "crank_slide", "--speed", "60"), ("analyse", "crank_slide", "--speed", "1Hz")),
        (
            ("ratings", "crank_slide", "--speed", "60", "--nominal-force", "1e5", "--nominal-height", "0.01", "--bearing", "W=2e5"),
            ("ratings", "crank_slide", "--speed", "60rpm", "--nominal-force", "100kN", "--nominal-height", "10mm", "--bearing", "W=200kN"),
        ),
        (
            (
                "simulate",
                "crank_slide",
                "--speed",
                "60",
                "--duration",
                "0.2",
                "--flywheel",
                "2000",
                "--load",
                "drawing:force=1e5,start=0.05",
            ),
            (
                "simulate",
                "crank_slide",
                "--speed",
                "60spm",
                "--duration",
                "200ms",
                "--flywheel",
                "2000kgm2",
                "--load",
                "drawing:force=100kN,start=50mm",
            ),
        ),
    ],
)
def test_commands_take_them(capsys, plain, named):
    assert figures(capsys, *named) == figures(capsys, *plain)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("analyse", "crank_slide", "--speed", "60mm"), "'60mm' is in 'mm', which is none of r/min"),
        (("analyse", "crank_slide", "--speed", "60,5"), "write decimals after a point"),
        (("simulate", "crank_slide", "--duration", "1", "--load", "drawing:force=100km,start=50mm"), "in 'km', which is none of N"),
        (("ratings", "crank_slide", "--speed", "60", "--nominal-force", "1e5", "--bearing", "W=2mm"), "it needs NAME=N"),
    ],
)
def test_wrong_units_are_refused(capsys, words, said):
    with contextlib.suppress(SystemExit):
        assert main([*words]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.exhaustive
def test_a_driver_that_slides_takes_speeds_in_mm_per_second(tmp_path, capsys):
    path = tmp_path / "toggle.urdf"
    path.write_text(sliding_presses.TOGGLE)
    for speed in ("100", "100mm/s", "0.1m/s"):
        assert main(["analyse", str(path), "--speed", speed, "--points", "12"]) == 0
        assert "screw slides there and back, harmonically, at up to 100 mm/s" in capsys.readouterr().out
    assert main(["analyse", str(path), "--speed", "70rpm"]) != 0
    assert "'70rpm' does not go with a driver that slides" in capsys.readouterr().err
    assert main(["analyse", "crank_slide", "--speed", "70mm/s"]) != 0
    assert "'70mm/s' does not go with a driver that turns" in capsys.readouterr().err
    assert main(["simulate", str(path), "--duration", "0.05", "--angle=-0.1m", "--motor", "constant:value=20"]) == 0
    said = capsys.readouterr().out
    assert "simulated from driver position -100 mm at 0 m/s" in said
    assert " 0 m/s to 0.435" in next(line for line in said.splitlines() if line.startswith("  speed drop "))
    assert "ConstantTorque(value=20 N)" in said


def test_motors_take_forces_on_a_driver_that_slides(tmp_path):
    program = tmp_path / "program.csv"
    program.write_text("0,0\n1,100\n")
    servo = f"servo:program={program},stiffness=2kN/mm,damping=9kNs/m,peak_torque=50kN"
    expected = {
        "constant:value=20kN": ConstantTorque(20e3),
        "constant:value=2kNm,ratio=600": Geared(ConstantTorque(2e3), 600.0),
        "prescribed:speed=100": PrescribedSpeed(0.1),
        servo: ServoMotor((0.0, 1.0), (0.0, 0.1), 2e6, 9e3, 50e3),
    }
    for words, drive in expected.items():
        assert part_specs.motor(words, RAM) == drive


@pytest.mark.parametrize(
    ("words", "coordinate", "said"),
    [
        ("constant:value=20kNm", RAM, "value is '20kNm', in 'kNm', which is none of N, kN, MN, tf"),
        ("constant:value=20kN,ratio=3", RAM, "in 'kN', which is none of N m"),
        ("constant:value=20kN", CRANK, "in 'kN', which is none of N m"),
        ("prescribed:speed=70rpm", RAM, "in 'rpm', which is none of mm/s"),
    ],
)
def test_motors_refuse_units_of_the_other_drivers(words, coordinate, said):
    with pytest.raises(pp.PinpressError, match=re.escape(said)):
        part_specs.motor(words, coordinate)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("analyse", "--speed", "100", "--zero", "tdc"), "its positions are 0 in the drawn pose; leave out --zero tdc"),
        (
            ("analyse", "--speed", "100", "--motor", "constant:value=20kN"),
            "need a crank that keeps turning; pinpress simulate takes --motor",
        ),
        (("simulate", "--speed", "100", "--motor", "constant:value=20kN", "--steady"), "give --duration in its place"),
    ],
)
def test_what_is_of_cranks_alone_says_what_to_give(tmp_path, capsys, words, said):
    path = tmp_path / "toggle.urdf"
    path.write_text(sliding_presses.TOGGLE)
    assert main([words[0], str(path), *words[1:]]) == 2
    assert said in capsys.readouterr().err
