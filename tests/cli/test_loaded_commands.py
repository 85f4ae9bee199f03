"""Loads, springs, friction and stiffnesses of the command line do what they do in Python, with every command that takes them."""

import csv
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import texts
from support.in_browser import data_in

import pinpress as pp
from pinpress.cli.main import main
from pinpress.dynamics.extremes import at_peaks

BLANKING, BLANK = "blanking:force=1000kN,start=6mm,end=2mm", pp.loads.Blanking(1e6, 0.006, 0.002)
SPRING = "link1=frame,link2=slide,stiffness=200kN/m,damping=500,free_length=0.4,point1=0/0/500mm"
CYLINDER = pp.loads.SpringDamper("frame", "slide", 2e5, 500.0, 0.4, point1=(0.0, 0.0, 0.5))
RATINGS = ["ratings", "zxn2_3000b", "--speed", "70", "--nominal-force", "3000kN"]
ANALYSE = ["analyse", "zxn2_3000b", "--speed", "70", "--points", "90"]


def table(path: Path) -> dict[str, Any]:
    with path.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    return dict(zip(header, np.array(rows, dtype=float).T, strict=True))


def shipped(name: str = "zxn2_3000b", points: int = 90) -> tuple[pp.Linkage, pp.Motion]:
    press = texts.shipped(name)
    return press, pp.cycle(press, 70 * pp.RPM, points=points)


def test_analysis_under_everything(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--load", BLANKING, "--load", "point-force:link=rod,force=0/0/-5kN,point=0.1/0/0", "--spring", SPRING]
    words += ["--friction", "all:coefficient=5%,radius=60mm", "--friction", "A:coefficient=0.08,radius=0.12,viscous=50"]
    words += ["--stiffness", "A=1e9", "--stiffness", "D=2GN/m"]
    assert main([*ANALYSE, *words, "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().err == ""
    press, motion = shipped()
    pin, guide = pp.loads.Friction(0.05, 0.06), pp.loads.Friction(0.05)
    expected = pp.inverse_dynamics(
        press,
        motion,
        [BLANK, pp.loads.PointForce("rod", (0.0, 0.0, -5e3), (0.1, 0.0, 0.0)), CYLINDER],
        dict.fromkeys(press.bearings, pin) | {"slide_guide": guide, "A": pp.loads.Friction(0.08, 0.12, 50.0)},
        {"A": 1e9, "D": 2e9},
    )
    found = table(tmp_path / "cycle.csv")
    for name, values in expected.columns().items():
        np.testing.assert_array_equal(found[name], values, err_msg=name)
    assert np.ptp(expected.driving_torque - pp.inverse_dynamics(press, motion).driving_torque) > 1e3


def test_stiffness_of_all_bearings_but_one(tmp_path: Path) -> None:
    """The lower pin of the front rod is twice as stiff: with the upper one, the rods share as 1 / (1 + 1/2) and 1 / (1 + 1)."""
    words = ["analyse", "jf75g_125_two_point", "--speed", "70", "--points", "36", "--load", "drawing:force=100kN,start=10mm"]
    assert main([*words, "--stiffness", "all=1GN/m", "--stiffness", "P4_front=2GN/m", "--out", str(tmp_path)]) == 0
    press, motion = shipped("jf75g_125_two_point", 36)
    stiffness = dict.fromkeys(press.bearings, 1e9) | {"P4_front": 2e9}
    expected = pp.inverse_dynamics(press, motion, [pp.loads.DeepDrawing(1e5, 0.01)], stiffness=stiffness)
    found = table(tmp_path / "cycle.csv")
    for name, values in expected.columns().items():
        np.testing.assert_array_equal(found[name], values, err_msg=name)
    front, back = (np.linalg.norm(expected.bearing_force[name], axis=1).max() for name in ("P4_front", "P4_back"))
    assert 1.3 < front / back < 1.4  # 4/3 of a force from the slide


@pytest.mark.exhaustive
def test_process_beside_what_is_permitted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    limits = ["--nominal-force", "3000kN", "--nominal-height", "13mm", "--out", str(tmp_path), "--report"]
    assert main([*ANALYSE, "--load", BLANKING, *limits]) == 0
    text = capsys.readouterr().out
    section = text.split("\nProcess\n")[1].split("\nDrive")[0] + text.split("\nProcess by")[1].split("\n\n")[0]
    numbers = [float(number) for number in re.findall(r"^  [a-z ]+? +([\d.]+) (?:kN|J|%)", section, flags=re.MULTILINE)]
    # at the blank's upper edge the whole 1000 kN act, where 3000 kN are permitted
    assert numbers == pytest.approx([1000.0, 1e6 * 0.004 * 2 / np.pi, 100 / 3], rel=2e-4)  # as printed, with two decimals
    assert "  nominal height   13 mm" in text
    data = data_in(tmp_path / "report.html")["report"]
    assert ["nominal force", "3000 kN"] in data["inputs"][0]["rows"]
    (chart,) = [block for section in data["sections"] for block in section["blocks"] if block.get("title") == "Force over the height"]
    assert [curve["name"] for curve in chart["curves"]] == ["process force", "permissible force"]


def printed_numbers(section: str) -> dict[str, float]:
    """By their names, in SI units."""
    factors = {"kJ": 1e3, "kN m": 1e3, "kW": 1e3, "kN": 1.0, "%": 0.01, "r/min": pp.RPM}
    rows = re.findall(r"^  ([a-z, ]+?) {2,}([-\d.]+) (kJ|J|kN m|N m|kN|kW|%|kg m2|r/min)(?: |$)", section, flags=re.MULTILINE)
    return {name: float(number) * factors.get(unit, 1.0) for name, number, unit in rows}


MOTOR = "induction:rated_power=75kW,rated_speed=1400,inertia=1.2,ratio=20.7"
WEAK = "induction:rated_power=7e3,rated_speed=1400,ratio=20.7"


@pytest.mark.exhaustive
def test_ratings_beside_a_process(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    limits = [
        "--nominal-force",
        "3000kN",
        "--nominal-height",
        "13mm",
        "--flywheel",
        "2000kgm2",
        "--speed-drop",
        "20%",
        "--motor-power",
        "75kW",
    ]
    words = ["ratings", "zxn2_3000b", "--speed", "70", *limits, "--load", BLANKING, "--out", str(tmp_path)]
    assert main(words) == 0
    text = capsys.readouterr().out
    press, motion = shipped(points=720)
    reactions = pp.inverse_dynamics(press, motion, [BLANK])
    capacities = pp.ratings.Capacities(3e6, nominal_height=0.013, flywheel_inertia=2000.0, speed_drop=0.2, motor_power=75e3)
    ratings = pp.ratings.rate(press, 70 * pp.RPM, capacities)
    work = 1e6 * 0.004 * 2 / np.pi
    assert printed_numbers(text.split("\nProcess\n")[1].split("\n\nInputs")[0]) == pytest.approx(
        {
            "largest process force": reactions.process_force.max() / 1e3,  # its unit is kN
            "work of the process": work,
            "of the permissible force": ratings.utilisation(reactions).max(),
            "of the flywheel energy": work / ratings.energies["flywheel energy"],
            "of the motor energy": work / ratings.energies["motor energy"],
        },
        rel=1e-3,
    )
    assert "load               Blanking(force=1000 kN, start=6 mm, end=2 mm, stripping=0 N)" in text
    assert (tmp_path / "ratings.png").stat().st_size > 10_000


def test_a_flywheel_that_is_too_small_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*ANALYSE, "--points", "90", "--load", BLANKING, "--flywheel", "20"]) == 0
    assert "with 20 kg m2: it holds only 537.35 J at this speed, and the press stops" in capsys.readouterr().out


def test_flywheel_and_motor(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--load", BLANKING, "--flywheel", "20000", "--speed-drop", "10%", "--motor", MOTOR]
    assert main([*ANALYSE, *words]) == 0
    text = capsys.readouterr().out
    press, motion = shipped()
    energy = pp.measures.driving_energy(pp.inverse_dynamics(press, motion, [BLANK]))
    assert printed_numbers(text.split("\nFlywheel (")[1].split("\n\n")[0]) == pytest.approx(
        {
            "work of the drive": energy.work,
            "mean torque": energy.mean_torque,
            "mean power": energy.mean_power,
            "energy that it stores": energy.stored,
            "speed drop": energy.speed_drop(2e4),
            "inertia it takes": energy.inertia(0.1),
        },
        rel=3e-4,  # five digits of the larger of two energies
    )
    drive = pp.drives.Geared(pp.drives.InductionMotor(75e3, 1400 * pp.RPM, inertia=1.2), 20.7)
    run = pp.steady_state(press, 70 * pp.RPM, drive=drive, flywheel=pp.drives.Flywheel(2e4), loads=[BLANK])
    duty = pp.measures.duty_cycle(run)
    steady = printed_numbers(text.split("\nSteady state under the motor")[1].split("\n\nInputs")[0])
    steady = {name: number for name, number in steady.items() if name != "lost"}
    assert steady == pytest.approx(
        {
            "mean speed": duty.mean_speed,
            "speed drop": duty.speed_drop,
            "motor, rms": duty.motor_rms,
            "motor, peak": duty.motor_peak,
            "motor, use": duty.utilisation,
            "work of the drive": duty.drive_work,
            "work of the loads": duty.load_work,
            "work of the flywheel": duty.flywheel_work,
            "crank speed at the end": run.crank_speed[-1],
            "from the mains": duty.mains_work,
            "lost by slip": duty.slip_loss,
            "mean power from the mains": duty.mains_work / duty.duration,
        },
        rel=3e-4,
    )
    assert "flywheel      Flywheel(inertia=20000 kg m2)" in text
    assert "motor         Geared(drive=InductionMotor(" in text


def test_the_rise_of_a_motor_stands_beside_that_at_its_rated_point(capsys: pytest.CaptureFixture[str]) -> None:
    words = f"{MOTOR},load_loss=10kW,rated_rise=80,thermal_time=45min"
    assert main([*ANALYSE, "--load", BLANKING, "--flywheel", "20000", "--motor", words]) == 0
    text = capsys.readouterr().out
    motor = pp.drives.InductionMotor(75e3, 1400 * pp.RPM, inertia=1.2, load_loss=1e4, rated_rise=80.0, thermal_time=2700.0)
    at = {"drive": pp.drives.Geared(motor, 20.7), "flywheel": pp.drives.Flywheel(2e4), "loads": [BLANK]}
    duty = pp.measures.duty_cycle(pp.steady_state(shipped()[0], 70 * pp.RPM, **at))
    (line,) = [line for line in text.splitlines() if "settled rise" in line]
    assert f"{duty.settled_rise:.4g}"[:4] in line
    assert "of 80.00" in line  # that at its rated point


@pytest.mark.exhaustive
def test_a_motor_that_is_too_weak_and_friction(capsys: pytest.CaptureFixture[str]) -> None:
    words = [
        "--load",
        "drawing:force=1500kN,start=40mm",
        "--friction",
        "A:viscous=10",
        "--motor",
        "induction:rated_power=7e3,rated_speed=1400,ratio=20.7",
    ]
    assert main([*ANALYSE, *words]) == 0
    text = capsys.readouterr().out
    assert "  none: no steady state is found near 7.33038 rad/s (70 r/min): the drive is too weak" in text


def test_the_press_before_is_under_the_same(tmp_path: Path) -> None:
    words = ["--load", BLANKING, "--friction", "A:coefficient=0.1,radius=0.1", "--before", "zxn2_3000b_balanced", "--report"]
    assert main([*ANALYSE, *words, "--out", str(tmp_path)]) == 0
    press, motion = shipped("zxn2_3000b_balanced")
    other = pp.inverse_dynamics(press, motion, [BLANK], {"A": pp.loads.Friction(0.1, 0.1)})
    rows = {row[0]: row for row in data_in(tmp_path / "report.html")["report"]["sections"][-1]["blocks"][0]["rows"]}
    (before,) = [row[-3] for name, row in rows.items() if name == "driving torque [kN m]"]
    assert 1e3 * float(before) == pytest.approx(np.ptp(at_peaks(other).reactions.driving_torque), rel=1e-4)


def test_recording_shows_the_loaded_press(tmp_path: Path) -> None:
    page = tmp_path / "press.html"
    words = ["--points", "90", "--load", BLANKING, "--spring", SPRING, "--friction", "all:coefficient=0.1,radius=60mm"]
    assert main(["record", "zxn2_3000b", "--speed", "70", *words, "--out", str(page)]) == 0
    press, motion = shipped()
    pins = {name: pp.loads.Friction(0.1, None if name == "slide_guide" else 0.06) for name in press.bearings}
    loaded = pp.inverse_dynamics(press, motion, [BLANK, CYLINDER], pins)
    assert page.read_bytes() == pp.record(press, motion, tmp_path / "same.html", reactions=loaded).read_bytes()


def test_balancing_under_a_spring(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["balance", "crank_slide", "--speed", "70", "--region", "crank:radius=0.1,mass=0/50", "--minimise", "peak:bearing_force:O"]
    force = []
    for spring in ([], ["--spring", SPRING]):
        assert main([*words, "--points", "36", *spring]) == 0
        heading = r"^  peak of the bearing force of O, before +(\S+) (k?)N$"
        ((before, kilo),) = re.findall(heading, capsys.readouterr().out, flags=re.MULTILINE)
        force.append(float(before) * (1e3 if kilo else 1.0))
    press, motion = shipped("crank_slide", 36)
    for found, loads in zip(force, ([], [CYLINDER]), strict=True):
        expected = np.linalg.norm(pp.inverse_dynamics(press, motion, loads).bearing_force["O"], axis=1).max()
        assert found == pytest.approx(expected, rel=6e-5)


def test_simulation_under_a_spring(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["simulate", "crank_slide", "--speed", "70", "--duration", "0.3", "--flywheel", "50", "--spring", SPRING]
    assert main(words) == 0
    text = capsys.readouterr().out
    press = texts.shipped("crank_slide")
    run = pp.simulate(press, 0.3, speed=70 * pp.RPM, flywheel=pp.drives.Flywheel(50.0), loads=[CYLINDER])
    (angle,) = re.findall(r"^  crank angle at the end +(\S+)", text, flags=re.MULTILINE)
    assert float(angle) == pytest.approx(np.degrees(run.crank_angle[-1]), abs=6e-4)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([*ANALYSE, "--friction", "0.1"], "it names no bearing; write e.g. --friction all:coefficient=0.08,radius=60mm"),
        ([*ANALYSE, "--friction", "Q:coefficient=0.1"], "no bearing 'Q'"),
        ([*ANALYSE, "--friction", "A:coefficient=0.1"], "its radius is missing"),
        ([*ANALYSE, "--friction", "slide_guide:coefficient=0.1,radius=0.1"], "a guide has no radius"),
        ([*ANALYSE, "--friction", "A:mu=0.1"], "no key 'mu'; it takes [coefficient=0] [radius] [viscous=0] [preload=0]"),
        ([*ANALYSE, "--friction", "all:preload=20kN"], "preload is the force of a guide's gibs; give it for each guide by name"),
        ([*ANALYSE, "--friction", "all:viscous=3"], "give it for each by name"),
        ([*ANALYSE, "--friction", "A:viscous=3", "--friction", "A:viscous=4"], "the friction of A is given twice"),
        ([*ANALYSE, "--spring", "link1=frame,link2=slid,stiffness=1"], "no link 'slid'"),
        ([*ANALYSE, "--spring", "link1=frame"], "link2 is missing"),
        ([*ANALYSE, "--spring", "link1=frame,link2=slide,point1=1/2"], "point1 is '1/2', not x/y/z as 0/0/-0.2"),
        ([*ANALYSE, "--spring", "link1=frame,link2=slide,stiffness=-1"], "stiffness is -1"),
        ([*ANALYSE, "--load", "point-force:link=slide,force=5kN"], "force is '5kN', not x/y/z"),
        ([*ANALYSE, "--flywheel", "inertia=5,speed=70"], "at constant speed the flywheel turns with the crank"),
        ([*ANALYSE, "--motor", "prescribed:speed=70"], "needs a motor"),
        ([*ANALYSE, "--speed-drop", "-1"], "speed_drop is -1"),
        ([*ANALYSE, "--nominal-height", "13mm"], "also give --nominal-force"),
        ([*ANALYSE, "--stiffness", "A"], "it needs NAME=N/m, a positive stiffness [N/m]; write e.g. --stiffness A=1e9"),
        ([*ANALYSE, "--stiffness", "Q=1e9"], "no bearing 'Q'"),
        ([*RATINGS, "--load", "point-force:link=slide,force=0/0/1"], "also give at_speed=True (--at-speed)"),
        ([*RATINGS, "--friction", "A:viscous=1"], "viscous friction depends on the speed"),
        ([*RATINGS, "--friction", "slide_guide:coefficient=0.05,preload=20kN"], "preloaded gibs have friction without a process force"),
        ([*RATINGS, "--motor", "constant:value=5"], "give --motor-power"),
        (["record", "zxn2_3000b", "--speed", "70", "--out", "x.html", "--no-forces", "--load", BLANKING], "--no-forces hides"),
        (["record", "zxn2_3000b", "--speed", "70", "--motor", "constant:value=5"], "--motor: record needs a given motion"),
        (["simulate", "zxn2_3000b", "--duration", "1", "--friction", "A:viscous=1", "--method", "constraint"], "knows no friction"),
        (["balance", "zxn2_3000b", "--speed", "70", "--friction", "A:viscous=1"], "--friction: balancing needs forces that are linear"),
    ],
)
def test_wrong_words(arguments: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 2
    out, error = capsys.readouterr()
    assert out == ""
    assert says in error
    assert error.count("\n") == 1


def test_part_of_an_option_is_no_other_option(capsys: pytest.CaptureFixture[str]) -> None:
    """``--drive`` began ``--driver``."""
    with pytest.raises(SystemExit, match="2"):
        main(["simulate", "crank_slide", "--duration", "1", "--drive", "O"])
    assert "unrecognized arguments: --drive" in capsys.readouterr().err


@pytest.mark.exhaustive
def test_the_frame_under_a_blank_that_breaks_through(tmp_path: Path) -> None:
    """Its jump of the force needs more states than a page has: the report takes as many by itself, and tells what twice as many do."""
    file = Path(__file__).resolve().parents[2] / "docs" / "jf75g_125_frame.yaml"
    page = tmp_path / "report.html"
    words = ["report", "jf75g_125", "--speed", "350", "--load", "blanking:force=700kN,start=3mm,end=1mm", "--frame", str(file)]
    assert main([*words, "--out", str(page)]) == 0
    (section,) = [section for section in data_in(page)["report"]["sections"] if section["title"] == "Vibration on the mounts"]
    figures = {figure["name"]: figure["value"].split() for figure in section["blocks"][0]["figures"]}
    shown = [figures[name] for name in ("shaking force, rms", "force on the floor, rms", "least load on a mount")]
    press = pp.load("jf75g_125")
    reactions = pp.inverse_dynamics(
        press, pp.cycle(press, 350 * pp.RPM, points=40000), loads=[pp.loads.Blanking(7e5, start=0.003, end=0.001)]
    )
    found = pp.foundation.steady_response(pp.foundation.read_mounted(press, file), reactions, points={})
    forces = [*(np.sqrt((force.var(axis=0)).sum()) for force in (found.shaking_force, found.floor_force)), found.least_load.min()]
    factors = {"N": 1.0, "kN": 1e3}
    assert [float(value) * factors[unit] for value, unit in shown] == pytest.approx(forces, rel=2e-3)


@pytest.mark.exhaustive
def test_a_preloaded_frame_yields_under_the_process(tmp_path: Path) -> None:
    """More than one without preload whose members both hold, once its uprights have lifted off."""
    page = tmp_path / "report.html"
    words = ["report", "jf75g_125", "--speed", "350", "--load", "blanking:force=700kN,start=3mm,end=1mm", "--out", str(page)]
    assert main([*words, "--stiffness", "P4=4e9", "--preloaded-joint", "frame:loaded=2GN/m,relieved=6GN/m,preload=300kN"]) == 0
    sections = {section["title"]: section for section in data_in(page)["report"]["sections"]}
    shown = {figure["name"]: figure["value"] for figure in sections["Deflection under load, weight and inertia"]["blocks"][0]["figures"]}
    press = pp.load("jf75g_125")
    rods = pp.elasticity.PreloadedJoint(loaded=2e9, relieved=6e9, preload=3e5)
    motion, load = pp.cycle(press, 350 * pp.RPM, points=720), pp.loads.Blanking(7e5, start=0.003, end=0.001)
    yielding, closed = (
        pp.elasticity.slide_deflection(press, motion, pp.elasticity.Stiffness({"P4": 4e9}, frame=frame), loads=[load]).deflection.max()
        for frame in (rods, rods.stiffness)
    )
    assert yielding > 1.2 * closed
    assert shown["pushed up by at most"] == f"{1e3 * yielding:.5g} mm"
