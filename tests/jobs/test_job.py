"""Jobs: what stands in a file computes what the same numbers in Python do; changes, variants and files lie over each other."""

import hashlib
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from support.in_browser import data_in
from support.presses.sliding_presses import TOGGLE
from support.texts import shipped

import pinpress as pp
from pinpress.common.reading.entries import entry_of_text
from pinpress.common.reading.filling import Around, Number, OneOf, Part
from pinpress.jobs import kinds
from pinpress.jobs.grammar import JOB, SECTIONS
from pinpress.jobs.job import before_of, results_of
from pinpress.pin_table.reading import BESIDE

PRESS = Path(__file__).with_name("press_job.yaml")  # the six-bar with all that acts on it
SERVO = """\
file: zxn2_3000b
loads: {draw: {kind: drawing, force: 1500 kN, start: 60 mm}}
servo:
  strokes_per_minute: 25
  minimise: heat
  points: 120
  drive: {inertia: 1.5 kg m2, ratio: 60, gear_inertia: 50 kg m2, peak_torque: 2100 N m, rated_torque: 800 N m, top_speed: 2000 r/min}
  path: {kind: turn}
  limits:
    - {kind: slide-speed, speed: 200 mm/s, heights: 60 0 mm}
    - {kind: feed-window, height: 150 mm, time: 0.8 s}
"""


@pytest.fixture(scope="module")
def job() -> pp.Job:
    return pp.job(PRESS)


def by_hand() -> tuple[pp.Linkage, dict]:
    """The press of `PRESS` and what acts on it, from Python."""
    text = PRESS.read_text(encoding="utf-8").partition("\nspeed:")[0]
    table = PRESS.parent / "by_hand.yaml"
    drawn = pp.build(**__import__("yaml").safe_load(text))
    assert not table.exists()
    press = drawn.drawn_at(pp.dead_centres(drawn).top_angle, "top dead centre")
    loads = [pp.loads.DeepDrawing(1.5e6, 0.04), pp.loads.BalanceCylinder(0.25, 6e5, 0.3, count=2)]
    friction = {name: pp.loads.Friction(0.05, 0.1) for name in press.bearings}
    friction |= {"A": pp.loads.Friction(0.05, 0.15), "slide_guide": pp.loads.Friction(0.05)}
    motor = pp.drives.InductionMotor(75e3, 1485 * pp.RPM, inertia=1.2)
    return press, {"loads": loads, "friction": friction, "motor": pp.drives.Geared(motor, 20.7, efficiency=0.95)}


def stroke(press: pp.Linkage) -> float:
    return pp.dead_centres(press).stroke


def test_a_job_computes_what_python_does() -> None:
    job = pp.job(PRESS, points=90)
    press, acting = by_hand()
    motion = pp.cycle(press, 70 * pp.RPM, points=90)
    reactions = pp.inverse_dynamics(press, motion, acting["loads"], acting["friction"])
    assert_array_equal(job.reactions().driving_torque, reactions.driving_torque)
    for name in press.bearings:
        assert_array_equal(job.reactions().bearing_force[name], reactions.bearing_force[name])
    wheel = pp.drives.Flywheel(6000)
    run = pp.steady_state(
        press, 70 * pp.RPM, drive=acting["motor"], flywheel=wheel, loads=acting["loads"], friction=acting["friction"], points=90
    )
    assert_array_equal(job.steady_state().crank_speed, run.crank_speed)
    capacities = pp.ratings.Capacities(3e6, 0.013, bearings={"A": 2e6}, flywheel_inertia=6000, speed_drop=0.15)
    assert_array_equal(job.rate().force, pp.ratings.rate(press, 70 * pp.RPM, capacities, friction=acting["friction"]).force)
    assert job.brake == pp.drives.Brake(60e3, closes=pp.drives.SwitchPoint(angle=np.radians(350)), rise=0.05)


def test_a_job_of_a_servo_press_finds_the_best_motion(tmp_path: Path) -> None:
    (tmp_path / "servo.yaml").write_text(SERVO)
    servo, press = pp.servo, shipped("zxn2_3000b")
    drive = servo.ServoDrive(inertia=1.5, ratio=60, gear_inertia=50, peak_torque=2100, rated_torque=800, top_speed=2000 * pp.RPM)
    limits = [servo.SlideSpeed(0.2, heights=(0.06, 0.0)), servo.FeedWindow(0.15, 0.8)]
    best = servo.best_motion(press, drive, [pp.loads.DeepDrawing(1.5e6, 0.06)], time=60 / 25, path=servo.Turn(), limits=limits, points=120)
    assert pp.job(tmp_path / "servo.yaml").best_motion().value == best.value


def parts() -> list[tuple[str, Part]]:
    """Every part that a job can name, but for those whose numbers stand in a file."""
    found = [
        (f"{name}: {kind}", part) for name, value in vars(kinds).items() if isinstance(value, OneOf) for kind, part in value.kinds.items()
    ]
    found += [(name, value) for name, value in vars(kinds).items() if isinstance(value, Part)]
    return [(name, part) for name, part in found if ".csv" not in part.example]


@pytest.mark.parametrize(("name", "part"), parts(), ids=[name for name, _ in parts()])
def test_examples_make_their_parts(name: str, part: Part, tmp_path: Path) -> None:
    """The example of each part is read, and the part has the numbers that stand there, in SI units."""
    around = Around(drivers={"A": shipped("zxn2_3000b").driver_coordinates[0]})
    entry = entry_of_text(part.example, "example", (), JOB)
    items = {key: each for key, each in entry.items("keys").items() if key != "kind"}
    given = {"link": entry_of_text("crank", "", (), JOB), **items} if part is kinds.REGION else items
    made = part.of(entry, given, around)
    made = made[0] if isinstance(made, tuple) else made
    inner = made.drive if isinstance(made, pp.drives.Geared) else made
    assert isinstance(inner, part.made)
    for key, value in part.values.items():
        if key in items and type(value) is Number and "^" not in value.unit:
            holder = inner if hasattr(inner, key) else made
            if hasattr(holder, key):
                assert getattr(holder, key) == value.read(items[key], around), key


def test_sections_of_tables_are_those_of_jobs() -> None:
    """A table of pins leaves all sections of a job alone, and refuses no other ones than those that name a press from elsewhere."""
    assert set(BESIDE) == set(SECTIONS) - {"file", "drivers", "floating", "pose"}


def test_pins_of_a_job_are_those_of_the_library_and_all_says_nothing_to_guides() -> None:
    rolling = {"rating": 8e5, "kind": "ball", "count": 2}
    job = pp.job("crank_slide", speed=5.0, bearings={"all": {"diameter": 0.1, "width": 0.08}, "O": {"rolling": rolling}})
    plain = pp.ratings.PlainBearing(0.1, 0.08)
    by_library = pp.ratings.pins(job.reactions(), {"P": plain, "W": plain, "O": pp.ratings.RollingBearing(8e5, "ball", 2)})
    assert dict(job.pins().uses) == dict(by_library.uses)
    assert [type(each).__name__ for each in results_of(job)] == ["PinRatings"]
    with pytest.raises(pp.PinpressError, match="no bearing has diameter and width, or rolling; write bearings"):
        pp.job("crank_slide", speed=5.0).pins()


def test_guides_of_a_job_are_those_of_the_library() -> None:
    sizes = {"slide_guide": {"length": "300 mm", "width": "100 mm", "middle": "60 mm", "pressure": "2 MPa"}}
    job = pp.job("crank_slide", speed=10.0, points=36, bearings={**sizes, "all": {"diameter": "80 mm", "pressure": "40 MPa"}})
    gibs = pp.ratings.Gibs(0.3, 0.1, middle=0.06, pressure=2e6)
    assert dict(job.pins().uses) == dict(pp.ratings.pins(job.reactions(), {"slide_guide": gibs}).uses)
    assert "largest pressure on a guide" in str(job.pins())
    for bearings, message in (
        ({"slide_guide": {"diameter": "80 mm"}}, "slide_guide: diameter, but slide_guide is a guide; write length: 400 mm, width: 120 mm"),
        ({"slide_guide": {"rolling": {"rating": "1 kN"}}}, "slide_guide: rolling, but slide_guide is a guide; write length"),
        ({"slide_guide": {"width": "80 mm"}}, "slide_guide: the pressure on a guide needs its length and its width; add length: 400 mm"),
        ({"slide_guide": {"length": "80 mm"}}, "the pressure on a guide needs its length and its width; add width: 120 mm"),
        ({"W": {"length": "80 mm"}}, "W: length, but W is a pin; write diameter: 80 mm, width: 80 mm"),
    ):
        with pytest.raises(pp.PinpressError, match=message):
            pp.job("crank_slide", speed=10.0, bearings=bearings)


def test_load_cases_of_a_job_are_those_of_the_library(tmp_path: Path) -> None:
    job = pp.job("crank_slide", speed=5.0, fe={"link": "rod", "at": "30 60 deg"})
    by_library = pp.fe.load_cases(job.press, job.reactions(), "rod", np.radians([30.0, 60.0]))
    assert_array_equal(job.load_cases().force["W"], by_library.force["W"])
    assert [type(each).__name__ for each in results_of(job.with_(**{"fe.at": "peak W"}))] == ["LinkLoads"]
    with pytest.raises(pp.PinpressError, match="no link 'bar'"):
        job.with_(**{"fe.link": "bar"}).load_cases()


def test_drive_of_a_job_is_that_of_the_library(tmp_path: Path) -> None:
    file = tmp_path / "motors.csv"
    file.write_text("motor, rated power [kW], rated speed [r/min], breakdown ratio, inertia [kg m2]\nlarge, 7.5, 1455, 2.5, 0.028\n")
    load = pp.loads.ForceStroke([0.005, 0.030], [1e5, 1e5])
    given = {"ratios": [15.0], "flywheels": [1.0, 2.0], "speeds": [9.0, 11.0], "speed_drop": 0.06}
    job = pp.job("crank_slide", speed=10.0, loads={"draw": load}, mains={"motors": str(file), **given})
    by_library = pp.mains.choose_drive(job.press, pp.mains.read_motors(file), [load], **given)
    assert job.choose_drive().best == by_library.best
    assert [type(each).__name__ for each in results_of(job)] == ["DriveChoice"]
    with pytest.raises(pp.PinpressError, match=r"mains: reserve is 0\.5; give breakdown torque"):
        job.with_(**{"mains.reserve": 0.5}).choose_drive()


@pytest.mark.exhaustive
def test_stops_of_a_job_are_those_of_the_library_with_the_loads_that_always_act() -> None:
    stop = {"delay": 0.02, "inertia": 1.0, "control": 0.01, "edition": "ANSI B11.19", "resolution": 0.02}
    loads = {"up": pp.loads.PointForce("slide", (0.0, 0.0, 100.0)), "draw": pp.loads.ConstantForce(1e4, 0.01)}
    job = pp.job("crank_slide", speed=5.0, loads=loads, brake={"torque": 500.0, "rise": 0.03}, stopping=stop)
    by_library = pp.ratings.stopping(job.press, 5.0, 500.0, 0.02, 0.03, control=0.01, inertia=1.0, loads=[loads["up"]])
    assert job.stopping().worst == by_library.worst
    assert job.safety_distance().addends == by_library.distance("ANSI B11.19", resolution=0.02).addends
    assert [type(each).__name__ for each in results_of(job)] == ["StoppingTimes", "SafetyDistance"]
    with pytest.raises(pp.PinpressError, match=r"the job has no brake; write brake: \{torque: 25 kN m"):
        job.with_(brake=None).stopping()
    with pytest.raises(pp.PinpressError, match="it has no edition; write edition: ISO 13855:2010"):
        job.with_(**{"stopping.edition": None}).safety_distance()


def test_tables_of_parts_come_from_beside_their_file(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "stroke.csv").write_text("height [mm],force [kN]\n0,100\n5,50\n")
    (tmp_path / "job.yaml").write_text("file: zxn2_3000b\nspeed: 70 r/min\nloads: {t: {kind: table, file: sub/stroke.csv}}\n")
    load = pp.job(tmp_path / "job.yaml").loads["t"]
    assert_array_equal(load.heights, [0, 0.005])
    assert_array_equal(load.forces, [1e5, 5e4])


def test_the_later_word_wins(tmp_path: Path) -> None:
    """Base, file, variant, change as text, argument of the call."""
    (tmp_path / "base.yaml").write_text(PRESS.read_text())
    above = "base: base.yaml\nloads: {draw: {force: 1600 kN}, balance: none}\nvariants: {hard: {loads.draw.force: 1700 kN}}\n"
    (tmp_path / "job.yaml").write_text(above)
    read = lambda **more: pp.job(tmp_path / "job.yaml", **more).loads["draw"].force  # noqa: E731
    assert pp.job(tmp_path / "base.yaml").loads["draw"].force == 1.5e6
    assert read() == 1.6e6
    assert pp.job(tmp_path / "job.yaml").loads.keys() == {"draw"}
    assert read(variant="hard") == 1.7e6
    assert read(variant="hard", set=["loads.draw.force=1800 kN"]) == 1.8e6
    assert read(variant="hard", set=["loads.draw.force=1800 kN"], **{"loads.draw.force": 1.9e6}) == 1.9e6


def test_changes_are_told_and_stay_on_top(job: pp.Job) -> None:
    hard = job.variant("hard_steel")
    assert [(each.path, each.before, each.now) for each in hard.changed] == [
        ("loads.draw.force", "1500 kN", "1900 kN"),
        ("capacities.speed_drop", "15 %", "20 %"),
    ]
    slower = hard.with_(speed=60 * pp.RPM)
    assert slower.loads["draw"].force == 1.9e6
    assert slower.speed == 60 * pp.RPM
    assert len(slower.changed) == 3
    assert job.speed == 70 * pp.RPM
    assert stroke(job.with_(r=150).press) > stroke(job.press)
    assert job.with_(brake=None).brake is None
    die = pp.loads.ElasticDie(0.001, 1e9)
    assert job.with_(loads={"die": die}).loads == {"die": die}


def test_a_job_without_a_file_and_one_of_a_shipped_press_with_another_radius() -> None:
    job = pp.job(file="zxn2_3000b", speed="70 r/min", loads={"draw": {"kind": "drawing", "force": 1.5e6, "start": 0.04}})
    assert_array_equal(
        job.reactions().driving_torque,
        pp.inverse_dynamics(
            shipped("zxn2_3000b"), pp.cycle(shipped("zxn2_3000b"), 70 * pp.RPM, points=720), [pp.loads.DeepDrawing(1.5e6, 0.04)]
        ).driving_torque,
    )
    changed = pp.job("eccentric_blocks", set=["r=10", "speed=60 r/min"])
    assert changed.parameters == {"r": "10"}
    assert stroke(changed.press) == stroke(pp.build("eccentric_blocks", r=10))


def test_drivers_that_slide_have_forces_and_speeds_along_their_axis(tmp_path: Path) -> None:
    file = tmp_path / "toggle.urdf"
    file.write_text(TOGGLE)
    job = pp.job(file, speed="80 mm/s", motor={"kind": "constant", "value": "20 kN"})
    assert job.speed == 0.08
    assert job.motor == pp.drives.ConstantTorque(20e3)
    with pytest.raises(pp.PinpressError, match=r"'70 r/min' is in 'r/min', which is none of m/s"):
        pp.job(file, speed="70 r/min")
    geared = pp.job(file, speed="80 mm/s", motor={"kind": "constant", "value": "200 N m", "ratio": 300.0})
    assert geared.motor == pp.drives.Geared(pp.drives.ConstantTorque(200), 300.0)


def test_sections_may_stand_in_files_of_their_own(tmp_path: Path) -> None:
    """Their paths are relative to the file in which they stand, and the SHA-256 of all of them is kept."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "loads.yaml").write_text("t: {kind: table, file: stroke.csv}\n")
    (tmp_path / "parts" / "stroke.csv").write_text("0,1e5\n0.005,5e4\n")
    (tmp_path / "job.yaml").write_text("file: zxn2_3000b\nspeed: 70 r/min\nloads: parts/loads.yaml\n")
    job = pp.job(tmp_path / "job.yaml")
    assert_array_equal(job.loads["t"].forces, [1e5, 5e4])
    for name in ("job.yaml", "parts/loads.yaml", "parts/stroke.csv"):
        assert job.files[tmp_path / name] == hashlib.sha256((tmp_path / name).read_bytes()).hexdigest()


def test_what_is_said_of_all_bearings_holds_of_those_that_say_nothing_else(job: pp.Job) -> None:
    assert job.bearings["A"].diameter == 0.3
    assert job.bearings["B"].diameter == 0.2
    assert job.bearings["slide_guide"].diameter is None
    assert job.friction["slide_guide"] == pp.loads.Friction(0.05)
    assert job.capacities.bearings == {"A": 2e6}


def test_the_page_has_the_header_the_inputs_and_the_sections_of_the_job(tmp_path: Path) -> None:
    logo = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 4 1"><path d="M0 0h4v1H0z"/></svg>'
    (tmp_path / "logo.svg").write_text(logo)
    file = tmp_path / "press.yaml"
    text = PRESS.read_text(encoding="utf-8")
    file.write_text(text.replace("revision: B,", "revision: B, logo: logo.svg, before: long_stroke,"), encoding="utf-8")
    page = pp.job(file, variant="hard_steel", points=24).write_report(tmp_path / "press.html")
    report = data_in(page)["report"]
    assert "<title>Press 3 for plant 7</title>" in page.read_text("utf-8")
    assert report["header"]["company"] == "Muster AG"
    assert report["header"]["rows"] == [["Drawing", "4711-03"], ["Revision", "B"], ["Author", "J. Doe"]]
    assert report["header"]["logo"].startswith("data:image/svg+xml;base64,")
    assert report["subtitle"].endswith("dashed: variant long_stroke of zxn2_3000b, crank at 70 r/min")
    rows, dashed = ([tuple(row) for row in given["rows"]] for given in report["inputs"])
    assert ("variant", f"hard_steel of {file}") in rows
    assert ("changed", "loads.draw.force: 1500 kN -> 1900 kN") in rows
    for path in (file, tmp_path / "logo.svg"):
        assert ("read", f"{path}, SHA-256 {hashlib.sha256(path.read_bytes()).hexdigest()}") in rows
    assert ("variant", f"long_stroke of {file}") in dashed
    assert ("changed", "parameters.r: 143 -> 150") in dashed
    assert {"Foundation", "Ratings", "Steady state under the motor"} < {each["title"] for each in report["sections"]}


def test_the_file_of_a_press_is_among_the_files_read(tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_bytes(shipped("crank_slide").text)
    file = tmp_path / "press.yaml"
    file.write_text("file: robot.urdf\nspeed: 60 r/min\n")
    assert [*pp.job(file).files] == [file, tmp_path / "robot.urdf"]


def test_a_page_compares_with_a_press_beside_the_job(tmp_path: Path) -> None:
    """It moves and is loaded as that of the job, but for what its own file says; its path is that from the job's file."""
    (tmp_path / "motion.csv").write_text("time [s],A [deg]\n" + "".join(f"{k / 24},{15 * k}\n" for k in range(25)))
    table = PRESS.read_text(encoding="utf-8").partition("\nspeed:")[0].replace("{r: 143}", "{r: 120}")
    (tmp_path / "old.yaml").write_text(table, encoding="utf-8")
    file = tmp_path / "press.yaml"
    for motion in ("speed: 60 r/min\npoints: 24\n", "motion: {file: motion.csv, period: 1 s}\n"):
        file.write_text(
            f"file: zxn2_3000b\n{motion}loads: {{draw: {{kind: drawing, force: 1 MN, start: 40 mm}}}}\nreport: {{before: old.yaml}}\n"
        )
        before, name, other = before_of(pp.job(file))
        assert before is not None
        assert other is not None
        assert not name
        assert before.motion.crank_speed.max() == pytest.approx(60 * pp.RPM, rel=1e-3)
        assert stroke(before._press) == stroke(pp.build(tmp_path / "old.yaml")) != stroke(pp.job(file).press)
    (tmp_path / "old.yaml").write_text(f"{table}\nspeed: 30 r/min\npoints: 24\n", encoding="utf-8")
    before, *_ = before_of(pp.job(file, motion=None, speed=1.0))
    assert before is not None
    assert before.motion.crank_speed[0] == pytest.approx(30 * pp.RPM)


def test_viscous_friction_has_the_unit_of_its_bearing() -> None:
    bearings = {"A": {"viscous": "30 N m s/rad"}, "slide_guide": {"friction": 0.05, "viscous": "0.8 kN s/m"}}
    friction = pp.job("zxn2_3000b", bearings=bearings).friction
    assert friction == {"A": pp.loads.Friction(0.0, None, 30.0), "slide_guide": pp.loads.Friction(0.05, viscous=800.0)}
    with pytest.raises(pp.PinpressError, match=r"bearings: A: viscous: '30 N s/m' is in 'N s/m', which is none of N m s/rad"):
        pp.job("zxn2_3000b", bearings={"A": {"viscous": "30 N s/m"}})
    with pytest.raises(pp.PinpressError, match=r"slide_guide: viscous: '30 N m s/rad' is in 'N m s/rad', which is none of N s/m"):
        pp.job("zxn2_3000b", bearings={"slide_guide": {"viscous": "30 N m s/rad"}})


def test_parts_without_a_stiffness_are_rigid_in_a_deflection() -> None:
    """A run needs all stiffnesses, as an elastic motion does; a deflection has those that are given."""
    sections = {"speed": "70 r/min", "points": "36", "elastic": {}, "bearings": {"E": {"stiffness": "4 GN/m"}}}
    loads = {"draw": {"kind": "drawing", "force": 1e6, "start": 0.04}}
    found = [*results_of(pp.job("zxn2_3000b", **sections, loads=loads))]
    press = shipped("zxn2_3000b")
    motion, draw = pp.cycle(press, 70 * pp.RPM, points=36), pp.loads.DeepDrawing(1e6, 0.04)
    expected = pp.elasticity.slide_deflection(press, motion, pp.elasticity.Stiffness({"E": 4e9}), loads=[draw])
    assert str(found[-1]) == str(expected)
    with pytest.raises(pp.PinpressError, match="have no stiffness, and in an elastic motion all are elastic"):
        pp.job("zxn2_3000b", **sections, run={"duration": 0.1})


def test_a_motor_that_is_too_weak_leaves_the_rest_of_the_page(tmp_path: Path) -> None:
    motor = {"kind": "induction", "rated_power": "5 kW", "rated_speed": "1485 r/min", "ratio": 20.7}
    loads = {"draw": {"kind": "drawing", "force": "1500 kN", "start": "40 mm"}}
    job = pp.job("zxn2_3000b", speed="70 r/min", points=36, loads=loads, motor=motor, flywheel="1000 kg m2")
    with pytest.raises(pp.SimulationError) as failure:
        job.steady_state()
    (none,) = results_of(job)
    assert str(none) == f"Steady state under the motor: none\n\nSteady state under the motor\n  None: {failure.value}"
    assert job.write_report(tmp_path / "press.html").exists()


def test_tolerances_of_a_call_are_in_si_units() -> None:
    written = {"length E F": "0.05 mm", "angle C D E": {"tolerance": "0.0001 rad", "sd": "0.00003 rad", "cost": 2}}
    numbers = {"length E F": 5e-5, "angle C D E": {"tolerance": 1e-4, "sd": 3e-5, "cost": 2.0}}
    first, second = (pp.job("zxn2_3000b", tolerances={"dimensions": each}).dimensions for each in (written, numbers))
    assert [part.tolerance for part in first.parts] == pytest.approx([part.tolerance for part in second.parts], rel=1e-12)
    assert second.parts[0].tolerance == 5e-5
    assert first.costs == second.costs


def test_a_page_of_a_run_alone_shows_it_once(tmp_path: Path) -> None:
    job = pp.job("crank_slide", flywheel=50.0, run={"duration": 0.1, "speed": "60 r/min", "points": 20})
    titles = [part["title"] for part in data_in(job.write_report(tmp_path / "run.html"))["report"]["sections"]]
    assert titles.count("Run") == 1
