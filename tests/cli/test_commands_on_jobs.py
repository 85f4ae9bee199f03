"""Commands on a job: what they print and write is what its results in Python are."""

import csv
import importlib.util
import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.in_browser import data_in
from support.refused_commands import one_line
from support.texts import shipped

import pinpress as pp
from pinpress.cli.main import COMMANDS, _parser, main

ROOT = Path(__file__).resolve().parents[2]
PRESS = ROOT / "tests" / "jobs" / "press_job.yaml"
BAR = "file: zxn2_3000b\nspeed: 70 r/min\npoints: 90\n"
BALANCE = """\
balance:
  regions: {crank: {radius: 300 mm}, rod: {radius: 300 mm, mass: 0 200 kg}}
  minimise: {kind: range, quantity: shaking_force, axis: z}
  limits: [{kind: range, quantity: shaking_force, axis: x, most: 1000 N}, {kind: added-mass, most: 400 kg}]
"""
SERVO = """\
file: zxn2_3000b
loads: {draw: {kind: drawing, force: 1500 kN, start: 60 mm}}
servo:
  strokes_per_minute: 25
  drive: {inertia: 1.5 kg m2, ratio: 60, gear_inertia: 50 kg m2, copper: 0.0048 W/(N m)2}
  limits: {kind: slide-speed, speed: 200 mm/s, heights: 60 0 mm}
  points: 360
  step: 10 ms
"""
TOLERANCES = """\
file: zxn2_3000b
tolerances:
  dimensions: {length D E: {tolerance: 50 um, cost: 3}, length E F: 0.05 mm, angle C D E: 0.01 deg}
  samples: 4000
  seed: 2
  within: 50 um
  targets: {height: 40 um, stroke: 60 um}
  forces: {height: 6 mm, force: 3000 kN}
  speeds: {height: 50 mm, speed: 70 r/min}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def printed(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    assert main([*map(str, arguments)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def file(text: str, name: str = "job.yaml") -> str:
    Path(name).write_text(text, encoding="utf-8")
    return name


def read(path: Path) -> dict[str, list[str]]:
    with path.open(encoding="utf-8", newline="") as opened:
        header, *rows = csv.reader(opened)
    return {name: list(column) for name, column in zip(header, zip(*rows, strict=True), strict=True)}


def columns_are(path: Path, expected: dict[str, Any]) -> None:
    found = read(path)
    for name, values in expected.items():
        np.testing.assert_array_equal(np.array(found[name], dtype=float), values, err_msg=name)


def test_a_job_alone_prints_everything_and_writes_its_page(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, PRESS, "--set", "points=90")
    job = pp.job(PRESS, points=90)
    for each in (job.reactions(), job.rate(), job.steady_state()):
        assert each.title in text
    assert re.search(r"read +\S+press_job\.yaml, SHA-256 [0-9a-f]{64}\n", text)
    assert "\nwrote press_job.html\n" in text
    first = (folder / "press_job.html").read_bytes()
    assert main([str(PRESS), "--variant", "hard_steel", "--set", "r=150", "--set", "points=90"]) == 0  # over a page of its own
    assert re.search(r"changed +loads\.draw\.force: 1500 kN -> 1900 kN\n", capsys.readouterr().out)
    assert (folder / "press_job.html").read_bytes() != first
    (folder / "press_job.html").write_text("<p>mine</p>")
    assert "pinpress did not write it: give another name by --out" in one_line(capsys, PRESS)


def test_a_shipped_press_needs_no_file(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "zxn2_3000b", "--speed", "70r/min", "--load", "drawing:force=1500kN,start=40mm", "--out", "page.html")
    press = shipped("zxn2_3000b")
    motion = pp.cycle(press, 70 * pp.RPM, points=720)
    assert pp.inverse_dynamics(press, motion, [pp.loads.DeepDrawing(1.5e6, 0.04)]).title in text


def test_analysis_writes_what_it_says(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "analyse", PRESS, "--set", "points=90", "--set", "traces={coupler: 0.6 0 0.1 m}", "--out", "made/out")
    names = ["cycle.csv", "recording.html", "report.html", "pins.csv", "ratings.csv", "ratings.png"]
    assert {path.name for path in (folder / "made/out").iterdir()} == set(names)
    for word in ("Steady state under the motor near 70 r/min", "of the permissible force", "inertia it takes", "time taken"):
        assert word in text
    job = pp.job(PRESS, points=90)
    columns_are(folder / "made/out/cycle.csv", dict(job.reactions().columns()))
    data = data_in(folder / "made/out/report.html")
    assert [trace["name"] for trace in data["traces"]] == ["slide", "coupler (0.6, 0, 0.1)"]


@pytest.mark.exhaustive
def test_numbers_of_a_bare_press(capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "analyse", "zxn2_3000b", "--speed", "70 r/min")
    for line in (
        "  stroke                         301.261 mm",
        "  70 strokes/min, A turns counter-clockwise at 70 r/min",
        "  top dead centre                155.497 deg    at 0.370231 s",
        "  fastest, working stroke         1.4697 m/s    at 209.977 deg, 178.758 mm",
        "  largest power                   140.24 kW     at 73.421 deg",
    ):
        assert line in text
    backwards = printed(capsys, "analyse", "zxn2_3000b", "--speed", "-70r/min")
    assert "A turns clockwise at 70 r/min" in backwards
    row = next(
        line for line in printed(capsys, "analyse", "jf75g_125_symmetric", "--speed", "70r/min").splitlines() if "slide_guide " in line
    )
    assert row.split() == ["slide_guide", "0", "-", "-", "0", "0", "0"]  # which carries nothing: rounding is no number


@pytest.mark.parametrize(("zero", "words"), [("tdc", "top dead centre"), ("bdc", "bottom dead centre")])
def test_crank_angles_count_from_a_dead_centre(folder: Path, capsys: pytest.CaptureFixture[str], zero: str, words: str) -> None:
    text = printed(capsys, "analyse", "zxn2_3000b", "--speed", "70r/min", "--set", f"zero={zero}", "--out", ".")
    assert re.search(rf"^  {words} +0\.000 deg +at 0\.000000 s$", text, flags=re.MULTILINE)
    table = {name: np.array(column, dtype=float) for name, column in read(folder / "cycle.csv").items()}
    ends = pp.dead_centres(shipped("zxn2_3000b"))
    angle = table[f"crank_angle_from_{words.replace(' ', '_')} [rad]"] + (ends.top_angle if zero == "tdc" else ends.bottom_angle)
    motion = pp.servo_cycle(shipped("zxn2_3000b"), angle=angle, speed=70 * pp.RPM, acceleration=0.0)
    torque = pp.inverse_dynamics(shipped("zxn2_3000b"), motion).driving_torque
    np.testing.assert_allclose(table["driving_torque [N m]"], torque, atol=1e-12 * np.abs(torque).max())


@pytest.mark.exhaustive
def test_a_variant_beside_the_job(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    printed(capsys, PRESS, "--variant", "long_stroke", "--set", "report.before=hard_steel", "--set", "points=36", "--out", "page.html")
    assert "dashed: variant hard_steel of zxn2_3000b" in data_in(folder / "page.html")["report"]["subtitle"]


def by_library(*speeds: float, points: int = 90) -> pp.balancing.BalancedPress:
    press, balancing = shipped("zxn2_3000b"), pp.balancing
    cases = [balancing.OperatingCondition(pp.cycle(press, speed * pp.RPM, points=points)) for speed in speeds]
    regions = [balancing.CounterweightRegion("crank", radius=0.3), balancing.CounterweightRegion("rod", (0, 200), radius=0.3)]
    limits = {balancing.Range("shaking_force", "x"): 1000.0, balancing.AddedMass(): 400.0}
    return balancing.balance(press, cases, regions=regions, minimise=balancing.Range("shaking_force", "z"), limits=limits)


def test_balance(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It prints the library's balance; the balanced press that it writes has the forces that stand in its table."""
    text, expected = printed(capsys, "balance", file(BAR + BALANCE), "--out", "out"), by_library(70)
    assert text.startswith(f"{expected}\n\nInputs\n")
    assert sorted(os.listdir("out")) == ["balance.csv", "balanced.urdf", "counterweights.csv", "report.html"]
    weights = read(folder / "out/counterweights.csv")
    assert [float(mass) for mass in weights["mass [kg]"]] == [weight.mass for weight in expected.counterweights]
    press = pp.load(folder / "out/balanced.urdf")
    forces = pp.inverse_dynamics(press, pp.cycle(press, 70 * pp.RPM, points=90)).shaking_force
    table = read(folder / "out/balance.csv")
    after = dict(zip(table["criterion"], map(float, table["after"]), strict=True))
    assert after["range of the shaking force, z"] == pytest.approx(np.ptp(forces[:, 2]), rel=1e-10)
    assert "dashed: zxn2_3000b, crank at 70 r/min" in data_in(folder / "out/report.html")["report"]["subtitle"]


@pytest.mark.exhaustive
def test_balance_over_speeds_dies_and_settings(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "balance", file(BAR + BALANCE + "  speeds: 70 -50 r/min\n"))
    assert text.startswith(f"{by_library(70, -50)}\n")
    job = pp.job(file(BAR + BALANCE + "  dies: 0 300 kg\n"))
    assert [each.name for each in job.balance().conditions] == ["die of 0 kg", "die of 300 kg"]
    heavier = pp.balancing.with_counterweights(
        shipped("zxn2_3000b"), [pp.balancing.Counterweight("slide", 300.0, tuple(shipped("zxn2_3000b").model.inertias[-1].lever))]
    )
    assert len(job.balance().presses) == 2
    assert heavier.model.inertias[-1].mass == job.balance().conditions[1].press.model.inertias[-1].mass


@pytest.mark.exhaustive
def test_strokes_are_settings_of_a_balance(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By the radius of its cranks: another mass of both blocks, in proportion, and none at its own radius."""
    blocks = ", ".join(f"{side}: {{link: crank_{side}, at: -150 0 0 mm, mass: -100 100 kg, reset: mass}}" for side in ("left", "right"))
    job = f"""\
base: eccentric_blocks
speed: 300 r/min
points: 72
balance:
  regions: {{{blocks}}}
  minimise: {{kind: range, quantity: shaking_force, axis: z}}
  limits: {{kind: range, quantity: shaking_force, axis: x, most: 1 N}}
  settings: [{{r: 10}}, {{r: 15}}, {{r: 20}}]
"""
    text = printed(capsys, "balance", file(job), "--out", ".")
    assert re.search(r"  r=10 +300 r/min of joint O_left, 72 states\n  r=15 +300 r/min", text)
    for number, radius in ((0, 10), (2, 20)):
        masses = np.array(read(folder / f"counterweights_{number}.csv")["mass [kg]"], float)
        np.testing.assert_allclose(masses, 232.974 / 2 * (radius / 15 - 1), atol=0.05)
    assert len((folder / "counterweights_1.csv").read_text(encoding="utf-8").splitlines()) == 1
    both = job.replace("  settings: [{r: 10}, {r: 15}, {r: 20}]", "  settings: [{r: 10}, {r: 15}]\n  dies: 0 400 kg")
    assert re.search(r"  r=15, die of 400 kg +300 r/min", printed(capsys, "balance", file(both)))


def test_servo(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "servo", file(SERVO), "--out", "out")
    drive = pp.servo.ServoDrive(inertia=1.5, ratio=60.0, gear_inertia=50.0, copper=0.0048)
    limit, draw = pp.servo.SlideSpeed(0.2, (0.06, 0.0)), pp.loads.DeepDrawing(1.5e6, 0.06)
    best = pp.servo.best_motion(shipped("zxn2_3000b"), drive, [draw], time=2.4, limits=[limit], points=360)
    assert text.startswith(f"{best}\n\nMotionComparison for zxn2_3000b: 4 motions, least rms torque")
    assert f"\n\n{pp.servo.capacitor(best.motion)}\n\nInputs\n" in text
    assert sorted(os.listdir("out")) == ["angle.csv", "comparison.csv", "height.csv", "report.html", "servo.csv"]
    angles = np.loadtxt(folder / "out/angle.csv", delimiter=",", skiprows=1)
    assert angles[:, 1] == pytest.approx(pp.servo.controller_table(best.motion, step=0.01).values, abs=1e-9)
    run = {"motor": {"kind": "servo", "program": "out/angle.csv", "stiffness": 1e5, "damping": 2e3, "peak_torque": 1e5, "inertia": 1.0}}
    driven = pp.job("zxn2_3000b", **run, flywheel=1.0, run={"duration": 0.05}).simulate()  # the table drives a simulation
    assert np.isfinite(driven.crank_speed).all()


@pytest.mark.exhaustive
def test_the_smallest_motor_of_a_catalogue(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drive = re.search(r"  drive: .*\n", SERVO)
    assert drive is not None
    catalogue = f"  motors: {ROOT / 'docs/servo_motors.csv'}\n  ratios: 60 80\n  gear_inertia: 50 kg m2\n"
    text = SERVO.replace(drive[0], catalogue).replace("points: 360", "points: 120")
    assert printed(capsys, "servo", file(text)).startswith("MotorChoice for zxn2_3000b: example 800, ratio 60, ")
    assert main(["servo", file(text.replace("ratios: 60 80", "ratios: 200"))]) == 2
    table, said = capsys.readouterr()
    assert "too warm" in table
    assert "no motor is sufficient" in said


def test_tolerances(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    press, tolerances = shipped("zxn2_3000b"), pp.tolerances
    Path("table.csv").write_text("dimension, tolerance, unit, cost\nlength D E, 50, um, 3\nlength E F, 0.05\nangle C D E, 0.01\n")
    table = tolerances.read_dimensions(press, "table.csv")
    found = tolerances.bottom_dead_centre(press, table.parts, forces={0.006: 3e6}, speeds={0.05: 70 * pp.RPM}, samples=4000, seed=2)
    cheapest = tolerances.allocate(press, table.parts, table.costs, {"height": 4e-5, "stroke": 6e-5}, table.bounds)
    text, inputs = printed(capsys, "tolerances", file(TOLERANCES), "--out", "out").split("\n\nInputs\n")
    within = f"\n  within 50 um at bottom dead centre: {100 * found.within(5e-5):.4g} % of the presses\n"
    assert text == f"{found}{within}\n{cheapest}"
    assert "4000 presses, seed 2" in inputs
    assert sorted(os.listdir("out")) == ["allocated.csv", "dimensions.csv", "tolerances.png"]
    from_file = TOLERANCES.replace("{length D E: {tolerance: 50 um, cost: 3}, length E F: 0.05 mm, angle C D E: 0.01 deg}", "table.csv")
    assert printed(capsys, "tolerances", file(from_file)).startswith(text)


def test_the_accuracy_budget(folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    known = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *more: None if name == "matplotlib" else known(name, *more))
    job = (
        "file: zxn2_3000b\nbearings: {F: {clearance: 50 um}, E: {clearance: 40 um, stiffness: 3 GN/m}}\n"
        "tolerances: {dimensions: {length E F: 0.05 mm}, samples: 4000, budget: {speeds: 10 70 r/min, warm: {rod: 10 K, frame: -2 K},"
        " expansion: 11e-6 1/K, table: -1900 mm, process: 500 kN}}\n"
    )
    text = printed(capsys, "tolerances", file(job), "--out", "out")
    press, tolerances = shipped("zxn2_3000b"), pp.tolerances
    found = tolerances.budget(
        press,
        speeds=[10 * pp.RPM, 70 * pp.RPM],
        clearance={"F": 5e-5, "E": 4e-5},
        stiffness=pp.elasticity.Stiffness({"E": 3e9}),
        temperatures=tolerances.Temperatures({"rod": 10.0, "frame": -2.0}, 1.1e-5, table=-1.9),
        process=5e5,
        machining=tolerances.bottom_dead_centre(press, [tolerances.link_length(press, "E", "F", 5e-5)], samples=4000),
    )
    assert f"\n\n{found}\n\nInputs\n" in text
    assert "pip install 'pinpress[plots]'" in text
    assert sorted(os.listdir("out")) == ["budget.csv", "dimensions.csv"]


@pytest.mark.exhaustive
def test_a_press_on_springs_on_its_mounts(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = """\
file: crank_slide
speed: 60 r/min
motor: {kind: prescribed, speed: 60 r/min}
bearings: {all: {stiffness: 50 MN/m, moment_stiffness: 1 MN m/rad}, P: {stiffness: 60 MN/m}}
elastic: {damping_ratio: 2 %}
foundation:
  frame: {mass: 2 t, centre: 0 0 300 mm, inertia: 400 500 300 kg m2}
  mounts: [{points: [400 0 -800 mm, -400 0 -800 mm], stiffness: 4 4 9 MN/m, damping: 40 40 80 kN s/m}]
run: {duration: 20 ms, points: 12}
"""
    text = printed(capsys, "simulate", file(job), "--out", "out")
    stiffness = pp.elasticity.Stiffness({"O": 5e7, "P": 6e7, "slide_guide": 5e7, "W": 5e7}, moments={"slide_guide": 1e6})
    mounts = [pp.foundation.Mount((x, 0.0, -0.8), (4e6, 4e6, 9e6), (4e4, 4e4, 8e4)) for x in (0.4, -0.4)]
    frame = pp.foundation.Frame(2000.0, (0.0, 0.0, 0.3), (400.0, 500.0, 300.0))
    elastic = pp.elasticity.Elastic(stiffness, mounted_frame=frame, mounts=mounts)
    speed, press = 60 * pp.RPM, pp.load("crank_slide")
    run = pp.simulate(press, 0.02, speed=speed, drive=pp.drives.PrescribedSpeed(speed), elastic=elastic, points=12)
    columns_are(folder / "out/simulation.csv", {name: values for name, values in run.columns().items() if isinstance(values, np.ndarray)})
    assert "2 at (0.4, 0, -0.8), (-0.4, 0, -0.8) m: 4 / 4 / 9 kN/mm along x, y, z" in text
    said = one_line(capsys, "simulate", file(job.replace("stiffness: 50 MN/m, moment", "moment")))
    assert (
        "job.yaml:5: elastic: O, slide_guide, W have no stiffness, and in an elastic motion all are elastic; write stiffness: 2 GN/m"
        in said
    )
    rotors = "  rotors: [{inertia: 3 kg m2, axis: 0 1 0}]\nrun:"
    assert "a press on springs stands on one rigid frame, without rotors" in one_line(capsys, "simulate", file(job.replace("run:", rotors)))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["missing.urdf"], "missing.urdf"),
        (["analyse", "zxn2", "--speed", "70r/min"], "zxn2_3000b"),
        (["analyse", "zxn2_3000b", "--speed", "0"], "speed is 0"),
        (["analyse", "zxn2_3000b"], "the job has no speed; write speed: 70 r/min"),
        (["analyse", "zxn2_3000b", "--speed", "70r/min", "--set", "points=1"], "points is 1"),
        (["analyse", "zxn2_3000b", "--speed", "70r/min", "--set", "drivers=Q"], "no moving joint 'Q'"),
        (["analyse", "zxn2_3000b", "--speed", "70r/min", "--set", "slide=rod"], "'rod' is not guided"),
        (
            ["analyse", "zxn2_3000b", "--speed", "70r/min", "--set", "traces={rodd: 0 0 0}", "--out", "nowhere"],
            "no link 'rodd', did you mean",
        ),
        (
            ["zxn2_3000b", "--speed", "70r/min", "--load", "drawing:force=1500"],
            "--load drawing:force=1500: loads: drawing: start is missing",
        ),
        (["simulate", "zxn2_3000b"], "the job has no run; write it, such as run: {duration: 3 s}"),
        (["simulate", "zxn2_3000b", "--set", "run.speed=70r/min"], "it says neither duration nor steady"),
        (["simulate", "zxn2_3000b", "--set", "run={steady: yes}"], "the job has no motor; write it, such as motor: {kind: induction"),
        (["balance", "zxn2_3000b", "--speed", "70r/min"], "the job has no balance"),
        (["servo", "zxn2_3000b"], "the job has no servo"),
        (["tolerances", "zxn2_3000b"], "the job has no tolerances"),
        (["record", "zxn2_3000b", "--speed", "70r/min"], "nothing to write: give --out page.html"),
        (["build", "zxn2_3000b"], "is no table of pins"),
        (["report", "zxn2_3000b", "--speed", "70r/min", "--out", "a.pdf"], "--out writes a web page: give --pdf a.pdf"),
        (["zxn2_3000b", "--speed", "70r/min", "--modes", "m.html"], "write a foundation into the job"),
    ],
)
def test_what_is_wrong_is_one_line(folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    assert said in one_line(capsys, *words)
    assert not list(folder.iterdir())


@pytest.mark.parametrize("words", [[], ["analyse"], ["analyze", "zxn2_3000b"], ["analyse", "zxn2_3000b", "--motor", "constant"]])
def test_usage_errors_exit_with_2(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    assert capsys.readouterr().err


@pytest.mark.parametrize("command", _parser()[1])
def test_help_fits_a_screen_and_shows_a_job(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Forty lines of a wide terminal; the commands that take a job say how one looks or where it is written."""
    with pytest.raises(SystemExit, match=r"^0$"):
        main([command, "--help"])
    shown = capsys.readouterr().out
    assert len(shown.splitlines()) <= 48, len(shown.splitlines())
    assert command in ("measured", "check", "new") or "press.yaml" in shown or "accuracy" in shown


def test_there_are_few_commands_and_options() -> None:
    commands = _parser()[1]
    assert len(COMMANDS) == 14
    assert sorted(commands) == sorted(
        [
            "new",
            "build",
            "check",
            "convert",
            "export",
            "report",
            "analyse",
            "simulate",
            "balance",
            "servo",
            "tolerances",
            "record",
            "view",
            "measured",
            "accuracy",
        ]
    )
