"""Results beside the motion in a report: their numbers on the page against the results, and every kind in a real browser."""

import importlib
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support import texts
from support.generators.hostile import NAMES, load_hostile
from support.generators.small_linkages import two_cranks
from support.in_browser import chart, curves, data_in, floats, sections
from support.refused_commands import one_line

import pinpress as pp
from pinpress.cli.main import main
from pinpress.common.outlets import described
from pinpress.common.quantities import quantity
from pinpress.dynamics.extremes import at_peaks
from pinpress.visual.reports.drawn import Line, covered, section

SPEED = 70 * pp.RPM
LOAD = pp.loads.Blanking(1e6, 0.006, 0.002)
MOTOR = pp.drives.Geared(pp.drives.InductionMotor(75e3, 1485 * pp.RPM, inertia=1.2), 20.7, efficiency=0.95)
UNITS = {"N": 1.0, "kN": 1e3, "MN": 1e6, "N m": 1.0, "kN m": 1e3, "J": 1.0, "kJ": 1e3}


def test_the_docstring_names_every_result_that_has_a_section() -> None:
    rooms = ("balancing", "elasticity", "foundation", "ratings", "servo", "simulation", "tolerances")
    kinds = [kind.__name__ for room in rooms for kind in importlib.import_module(f"pinpress.{room}.described").SECTIONS]
    assert [kind for kind in kinds if f"`{kind}`" not in str(pp.report.__doc__)] == []


def figures(section: Any) -> dict[str, str]:
    return {figure["name"]: figure["value"] for block in section["blocks"] for figure in block.get("figures", ())}


@pytest.fixture(scope="module")
def press() -> Any:
    return texts.shipped("zxn2_3000b")


@pytest.fixture(scope="module")
def loaded(press: Any) -> Any:
    friction = {"A": pp.loads.Friction(0.05, 0.06), "D": pp.loads.Friction(0.05, 0.06)}
    return pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=180), [LOAD], friction)


@pytest.fixture(scope="module")
def ratings(press: Any) -> Any:
    return pp.ratings.rate(
        press, SPEED, pp.ratings.Capacities(3e6, nominal_height=0.013, flywheel_inertia=2000.0, speed_drop=0.2), points=31
    )


@pytest.fixture(scope="module")
def steady(press: Any) -> Any:
    return pp.steady_state(press, SPEED, drive=MOTOR, flywheel=pp.drives.Flywheel(6000.0), loads=[LOAD])


@pytest.fixture(scope="module")
def written(press: Any, loaded: Any, ratings: Any, steady: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("results") / "out.html"
    return pp.report(press, loaded.motion, path, reactions=loaded, results=[ratings, steady])


def test_what_was_computed_is_stated(written: Path) -> None:
    rows = dict(data_in(written)["report"]["inputs"][0]["rows"])
    assert rows["motion"] == "one period at 70 r/min, 180 states"
    assert rows["load"].startswith("blanking: force = 1000 kN")
    assert "SHA-256" in rows["file"]
    assert rows["nominal force"] == "3000 kN"
    assert rows["motor"].startswith("geared: ratio = ")
    assert rows["flywheel"] == "inertia = 6000 kg m2"
    assert "0.05" in rows["friction"]


def test_energy_of_a_stroke(written: Path, loaded: Any) -> None:
    """What the drive gives is what process and friction take."""
    bars = chart(sections(written)["Drive"], "Energy of a stroke")
    work = dict(zip(bars["places"], UNITS[bars["unit"]] * np.array(bars["bars"]["work"]), strict=True))
    assert work["process"] == pytest.approx(loaded.process_work)
    assert work["friction"] > 0
    assert work["drive"] == pytest.approx(work["process"] + work["friction"], rel=1e-7)


def test_permissible_force_and_its_limits(written: Path, loaded: Any, ratings: Any) -> None:
    section = sections(written)["Ratings"]
    found = chart(section, "Permissible force near")
    drawn = curves(found)
    for name, force in {"permissible force": ratings.force, **ratings.limits}.items():
        assert_allclose(drawn[name][0], 1e3 * ratings.height, rtol=1e-6, atol=1e-6)
        assert_allclose(UNITS[found["unit"]] * drawn[name][1], force, rtol=1e-6)
    (process,) = [floats(curve["at_frames"]).reshape(-1, 2) for curve in found["curves"] if curve["name"] == "process force"]
    assert_allclose(UNITS[found["unit"]] * process[:-1, 1], loaded.process_force, rtol=1e-6)
    most = float(ratings.utilisation(loaded).max())
    assert figures(section)["of the permissible force"] == f"{100 * most:.5g} %"
    share = loaded.process_work / ratings.energies["flywheel energy"]
    assert figures(section)["of the flywheel energy"] == f"{100 * share:.5g} %"


def test_motor_beside_its_curve(written: Path, steady: Any) -> None:
    section = sections(written)["Steady state under the motor"]
    found = curves(chart(section, "Motor torque over its speed"))
    speed, torque = found["run"]
    assert_allclose(speed, 20.7 * steady.drive_speed / pp.RPM, rtol=1e-6)
    assert_allclose(torque, MOTOR.motor_torque(steady.drive_speed), rtol=1e-5, atol=1e-3)
    along, curve = found["motor's curve"]
    assert_allclose(curve, MOTOR.drive.torque(along * pp.RPM), rtol=1e-4, atol=0.1)
    assert_allclose(found["rated torque"][1], MOTOR.rated_torque, rtol=1e-6)
    duty = pp.measures.duty_cycle(steady)
    assert figures(section)["motor, use"] == f"{100 * duty.utilisation:.5g} %"
    assert chart(section, "Energy of the period")["places"] == ["drive", "loads"]  # nothing is stored in a period
    bars = chart(section, "Energy from the mains")
    work = dict(zip(bars["places"], UNITS[bars["unit"]] * np.array(bars["bars"]["work"]), strict=True))
    mains = work.pop("from the mains")
    assert mains == pytest.approx(duty.mains_work)
    assert sum(work.values()) == pytest.approx(mains, rel=1e-6)
    assert work["slip"] == pytest.approx(duty.slip_loss)
    assert figures(section)["mean power from the mains"].startswith(f"{duty.mains_work / duty.duration / 1e3:.4g}"[:4])
    x, y = curves(chart(section, "Crank speed"))["crank speed"]
    assert_allclose(y, steady.crank_speed / pp.RPM, rtol=1e-6)
    assert 0 <= x.min() < 1
    assert x.max() <= 361


def test_energy_of_a_run_that_speeds_up(press: Any, tmp_path: Path) -> None:
    run = pp.simulate(press, 0.5, speed=SPEED, drive=pp.drives.ConstantTorque(2e3), flywheel=pp.drives.Flywheel(2000.0), points=40)
    bars = chart(sections(pp.report(press, run, tmp_path / "out.html"))["Run"], "Energy of the run")
    work = dict(zip(bars["places"], UNITS[bars["unit"]] * np.array(bars["bars"]["work"]), strict=True))
    assert work == pytest.approx({"drive": run.drive_work[-1], "stored in speed and height": run.drive_work[-1]})


def test_several_drivers_run_beside_the_motion(tmp_path: Path) -> None:
    press = two_cranks()
    run = pp.simulate(press, 0.02, points=5, method="constraint", drive={press.drivers[0]: pp.drives.ConstantTorque(2.0)})
    found = sections(pp.report(press, run, tmp_path / "out.html", results=[run]))
    assert list(curves(chart(found["Drive"], "Crank speed"))) == list(press.drivers)
    section = found["Run"]
    assert [block["title"] for block in section["blocks"] if "title" in block] == ["Drivers", "Energy of the run"]


def test_extremes_in_the_units_of_the_charts(written: Path, press: Any, loaded: Any) -> None:
    (table,) = sections(written)["Extremes"]["blocks"]
    rows = {row[0]: row[1:] for row in table["rows"]}
    assert_allclose([float(rows["slide height [mm]"][k]) for k in (0, 2)], [0.0, 1e3 * pp.dead_centres(press).stroke], atol=0.005)
    torque = at_peaks(loaded).reactions.driving_torque / 1e3
    assert_allclose([float(rows["driving torque [kN m]"][k]) for k in (0, 2)], [torque.min(), torque.max()], atol=5e-4)
    assert not any("[N]" in name for name in rows)


def test_curves_that_lie_on_each_other_are_told_apart() -> None:
    x = np.linspace(0, 1, 50)
    looks = {"a": np.sin(6 * x), "b": np.cos(6 * x), "c": np.sin(6 * x) + 1e-3, "d": np.sin(6 * x), "e": x}
    lines = [Line(name, "line", y, x if name == "e" else None) for name, y in looks.items()]
    assert covered(lines) == {2: 0, 3: 0}


@pytest.fixture(scope="module")
def elastic(press: Any) -> Any:
    return pp.elasticity.Stiffness(bearings={"A": 3e9, "E": 6e9, "F": 6e9}, frame=4e9)


def test_elastic_press(press: Any, loaded: Any, elastic: Any, tmp_path: Path) -> None:
    compliance = pp.elasticity.compliance(press, elastic, angle=np.linspace(0, 6, 24))
    shift = pp.elasticity.dead_centre_shift(press, elastic, speed=np.array([40.0, 60.0]) * pp.RPM)
    snap = pp.elasticity.snap_through(1e6, compliance.bottom_stiffness, 5e3, damping_ratio=0.04)
    deflected = pp.elasticity.slide_deflection(press, loaded.motion, elastic, loads=[LOAD])
    path = pp.report(press, loaded.motion, tmp_path / "out.html", reactions=loaded, results=[compliance, deflected, shift, snap])
    found = sections(path)
    parts = curves(chart(found["Elastic press"], "Compliance"))
    assert_allclose(sum(part for _, part in parts.values()), 1e9 * compliance.compliance, rtol=1e-5)
    bars = chart(found["Elastic press"], "Shares")
    assert dict(zip(bars["places"], bars["bars"]["share"], strict=True)) == pytest.approx(
        {name: 100 * share for name, share in compliance.bottom_shares.items()}
    )
    deflection = curves(chart(found["Deflection under load, weight and inertia"], "Deflection"))["all"][1]
    assert_allclose(deflection[:-1], 1e3 * deflected.deflection, rtol=1e-5, atol=1e-7)
    assert_allclose(curves(chart(found["Bottom dead centre over the speed"], "Shift"))["shift"][1], 1e6 * shift.shift, rtol=1e-5)
    force = chart(found["Break-through"], "Force on the linkage")
    assert_allclose(UNITS[force["unit"]] * curves(force)["force of the spring"][1], snap.spring_force, rtol=1e-5, atol=1)
    assert "A: 3000 kN/mm" in dict(data_in(path)["report"]["inputs"][0]["rows"])["elastic parts"]


def mounted(press: Any) -> Any:
    mounts = [pp.foundation.Mount((x, y, -1.5), (5e7, 5e7, 2e8), loss_factor=0.1) for x in (-0.8, 0.8) for y in (-0.5, 0.5)]
    return pp.foundation.mounted(press, pp.foundation.Frame(3e4, (0, 0, 0), (3e4, 3e4, 1e4)), mounts)


def test_press_on_its_mounts(press: Any, tmp_path: Path) -> None:
    idle = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=180))
    system, crown = mounted(press), {"crown": (0, 0, 1.5)}
    steady, modes = pp.foundation.steady_response(system, idle, points=crown), pp.foundation.modes(system)
    over = pp.foundation.over_speeds(system, np.linspace(30, 90, 7) * pp.RPM, points=crown)
    results = [system, modes, steady, over]
    found = sections(pp.report(press, idle.motion, tmp_path / "out.html", reactions=idle, results=results))
    table, *_ = found["On its mounts at rest"]["blocks"]
    assert_allclose([float(row[5]) for row in table["rows"]], 100 * system.load_share, atol=0.005)
    (table,) = found["Modes on the mounts"]["blocks"]
    assert_allclose([float(row[1]) for row in table["rows"]], modes.natural_frequency / (2 * np.pi), atol=5e-4)
    acceleration = chart(found["Vibration on the mounts"], "Acceleration along z")
    assert acceleration["follows"] == "time"
    assert_allclose(curves(acceleration)["crown"][1][:-1], steady.acceleration["crown"][:, 2], rtol=1e-5, atol=1e-6)
    hop = pp.loads.PointForce(press.root, lambda motion: np.outer(np.sin(motion.crank_angle), [0, 0, 6e5]))
    lifted = pp.foundation.lifting_response(system, pp.inverse_dynamics(press, idle.motion, loads=[hop]), points=crown)
    spinning = pp.foundation.mounted(press, system.frame, system.mounts, rotors=[pp.foundation.Rotor(900, (0, 1, 0))])
    diagram = pp.foundation.whirl(spinning, [0.0, 5.0, 10.0])
    more = sections(pp.report(press, idle.motion, tmp_path / "more.html", reactions=idle, results=[lifted, diagram]))
    table = chart(more["Vibration on mounts that only press"], "Feet that lift off")
    assert [int(row[1]) for row in table["rows"]] == [int((lifted.mount == k).sum()) for k in np.unique(lifted.mount)]
    drawn = curves(chart(more["Modes while the rotors spin"], "Natural frequency"))
    assert_allclose(drawn["mode 6"][1], diagram.frequency[:, 5] / (2 * np.pi), rtol=1e-6)
    rms = curves(chart(found["Vibration over the speed"], "Acceleration"))["crown"][1]
    assert_allclose(rms, np.linalg.norm(over.rms["crown"], axis=1), rtol=1e-5)


@pytest.fixture(scope="module")
def balanced(press: Any) -> Any:
    motion = pp.cycle(press, SPEED, points=60)
    regions = [pp.balancing.CounterweightRegion("crank", radius=0.3)]
    limits = {pp.balancing.Range("shaking_force", "x"): 1000.0}
    return pp.balancing.balance(press, motion, regions=regions, minimise=pp.balancing.Range("shaking_force", "z"), limits=limits)


def test_balance(press: Any, balanced: Any, tmp_path: Path) -> None:
    motion = balanced.conditions[0].motion
    section = sections(pp.report(press, motion, tmp_path / "out.html", results=[balanced]))["Balancing"]
    (weight,) = balanced.counterweights
    (row,) = chart(section, "Counterweights")["rows"]
    assert row[0] == "crank"
    assert float(row[1]) == pytest.approx(weight.mass, rel=1e-5)
    assert_allclose([float(cell) for cell in row[2:5]], 1e3 * np.array(weight.position), atol=1e-3)
    shaking = chart(section, "Shaking force before and after")
    for words, reactions in (("before", balanced.reactions_before[0]), ("after", balanced.reactions_after[0])):
        drawn = UNITS[shaking["unit"]] * curves(shaking)[f"z, {words}"][1]
        assert_allclose(drawn[:-1], reactions.shaking_force[:, 2], rtol=1e-5)
        assert drawn[-1] == drawn[0]  # the turn is closed
    (change,) = [row for row in chart(section, "Criteria")["rows"] if "force, z" in row[0]]
    assert chart(section, "Criteria")["heads"][3] == "change [%]"
    assert float(change[3].replace("\u2212", "-")) == pytest.approx(100 * balanced.changes[0].change, rel=1e-4)


def test_a_map_has_the_numbers_at_their_places(loaded: Any, tmp_path: Path) -> None:
    """Of a grid, of words that stand for places, and of rays, whose numbers the page repeats between their places."""
    crank = texts.shipped("crank_slide")
    speeds, forces = np.array([14.0, 7.0, 10.0]), np.array([0.0, 2e4])
    points = pp.sweeps.operating_points(crank, speeds, forces=forces, unit_load=pp.loads.ConstantForce(1.0, 0.02))
    amplitude = np.arange(1.0, 13.0).reshape(3, 4, 1)
    orders = pp.measured.OrderSpectra(("Ax",), np.array([10.0, 15.0, 20.0]), np.array([0.5, 1.0, 1.5, 2.0]), amplitude, 2)
    page = pp.report(crank, pp.cycle(crank, 7.0, points=24), tmp_path / "out.html", results=[points, orders])
    maps = {block["title"]: block for section in sections(page).values() for block in section["blocks"] if block["kind"] == "map"}
    torque = next(found for title, found in maps.items() if title.lower() == "largest driving torque")
    assert (torque["across"], torque["up"], torque["unit"]) == ("force [kN]", "speed [r/min]", "N m")
    assert torque["x"] == pytest.approx(1e-3 * forces)
    assert torque["y"] == pytest.approx(np.sort(speeds) / pp.RPM)
    assert_allclose(np.array(torque["values"]), points.grid("largest_driving_torque")[[1, 2, 0]], rtol=1e-12)
    rays = maps["Ax"]
    assert (rays["across"], rays["up"], rays["unit"]) == ("crank speed [r/min]", "frequency [Hz]", "m/s²")
    assert_allclose(rays["x"], orders.speed / pp.RPM)
    grid = np.array(rays["values"], dtype=float)
    for ray, speed in enumerate(orders.speed):
        for order, value in zip(orders.order, amplitude[ray, :, 0], strict=True):
            assert grid[np.abs(2 * np.pi * np.array(rays["y"]) - order * speed).argmin(), ray] == value
        assert np.isnan(grid[2 * np.pi * np.array(rays["y"]) > 2.001 * speed, ray]).all()
    theirs, ours = (described.Along("", "frequency", np.array(values)) for values in ([30.0, 40.0, 50.0], [31.0, 39.0]))
    mac = np.array([[1.0, 0.25, np.nan], [0.0, 0.5, 0.75]])
    agreement = described.Map("mac", "Agreement", "number", theirs, ours, mac, written=True)
    (written,) = section(described.Section("", blocks=[agreement]), loaded)["blocks"]
    assert (written["x"], written["y"], written["unit"], written["written"]) == (["4.775", "6.366", "7.958"], ["4.934", "6.207"], "", True)
    assert written["values"] == [[1.0, 0.25, None], [0.0, 0.5, 0.75]]


def results_of(press: Any) -> list[Any]:
    """A result of each room, of a press made from `TABLE`."""
    speed, stiffness = 2.0, pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 1e9), moments={"slide_guide": 1e7})
    elastic, motion = pp.elasticity.Elastic(stiffness), pp.cycle(press, speed, points=24)
    parts = [pp.tolerances.link_length(press, "P", "W", 1e-5)]
    regions = [pp.balancing.CounterweightRegion("crank", radius=0.3)]
    mounts = [pp.foundation.Mount((x, y, -0.9), (4e6, 5e6, 3e7)) for x in (-0.5, 0.5) for y in (-0.4, 0.4)]
    return [
        pp.elasticity.natural_frequencies(press, elastic, angle=[0.0, 1.0]),
        pp.elasticity.compliance(press, stiffness, angle=[0.0, 1.0]),
        pp.ratings.rate(press, speed, pp.ratings.Capacities(1e6, nominal_height=0.01), points=11),
        pp.simulate(press, 0.1, speed=speed, drive=pp.drives.ConstantTorque(10.0)),
        pp.tolerances.bottom_dead_centre(press, parts, samples=100),
        pp.tolerances.allocate(press, parts, None, {"height": 2e-5}),
        pp.tolerances.heat(press, pp.tolerances.Temperatures({"rod": 10.0})),
        pp.servo.best_motion(press, pp.servo.ServoDrive(inertia=1.0), time=2.0, points=24),
        pp.balancing.balance(press, motion, regions=regions, minimise=pp.balancing.Range("shaking_force", "z")),
        pp.foundation.modes(pp.foundation.mounted(press, pp.foundation.Frame(1000.0, (0, 0, -0.5), (200, 200, 200)), mounts)),
    ]


TABLE: dict[str, Any] = {
    "press": "table",
    "units": "mm",
    "frame": "O",
    "pins": {"O": [0, 0], "P": {"from": "O", "length": 100, "angle": -90}, "W": {"P": 400, "x": 0, "side": "down"}},
    "links": {"crank": {"pins": "O P", "mass": 20}, "rod": {"pins": "P W", "mass": 15}, "slide": {"pins": "W", "guide": "up", "mass": 90}},
    "drive": "O",
}


@pytest.mark.exhaustive
def test_results_of_a_press_of_the_same_name_are_refused(tmp_path: Path) -> None:
    """Lengths and masses of the press count: a longer rod, a heavier slide. A press made again of the same table is the same press."""
    press, again = pp.build(**TABLE), pp.build(**TABLE)
    longer = pp.build(**TABLE | {"pins": TABLE["pins"] | {"W": {"P": 450, "x": 0, "side": "down"}}})
    heavier = pp.build(**TABLE | {"links": TABLE["links"] | {"slide": {"pins": "W", "guide": "up", "mass": 95}}})
    another = texts.shipped("crank_slide")
    turns = {other: pp.cycle(other, 2.0, points=24) for other in (longer, heavier, again, another)}
    for result in results_of(press):
        for other in (longer, heavier):
            with pytest.raises(pp.PinpressError, match="is of a table with other lengths, masses or zero, the page of table"):
                pp.report(other, turns[other], tmp_path / "out.html", results=[result])
        with pytest.raises(pp.PinpressError, match="is of table, the page of crank_slide"):
            pp.report(another, turns[another], tmp_path / "out.html", results=[result])
        assert list(tmp_path.iterdir()) == []
        pp.report(again, turns[again], tmp_path / "out.html", results=[result]).unlink()


def test_what_has_no_section_is_refused_by_name(press: Any, loaded: Any, tmp_path: Path) -> None:
    harmonics = pp.measures.harmonics(loaded.motion, loaded.shaking_force)
    with pytest.raises(pp.PinpressError, match=r"a report has no section for .*; give results that have some"):
        pp.report(press, loaded.motion, tmp_path / "out.html", reactions=loaded, results=[harmonics])


def reported(folder: Path, text: str, *words: str) -> Path:
    """The page of a job with this text."""
    job, page = folder / "job.yaml", folder / "page.html"
    job.write_text(text, encoding="utf-8")
    assert main(["report", str(job), "--out", str(page), *words]) == 0
    return page


ALL = """\
file: zxn2_3000b
speed: 70 r/min
points: 90
zero: bdc
loads: {blank: {kind: blanking, force: 1000 kN, start: 6 mm, end: 2 mm}}
motor: {kind: induction, rated_power: 75 kW, rated_speed: 1485 r/min, inertia: 1.2 kg m2, ratio: 20.7}
flywheel: 6000 kg m2
capacities: {nominal_force: 3000 kN, nominal_height: 13 mm, speed_drop: 20 %}
bearings: {all: {stiffness: 3 GN/m, moment_stiffness: 200 MN m/rad}, E: {stiffness: 6 GN/m}}
elastic: {}
balance: {regions: {crank: {radius: 300 mm}}, minimise: {kind: range, quantity: shaking_force, axis: z}}
"""


@pytest.mark.exhaustive
def test_the_command_makes_all_of_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = reported(tmp_path, ALL)
    assert capsys.readouterr().out.endswith(f"\nwrote {page}\n")
    data = data_in(page)["report"]
    titles = [section["title"] for section in data["sections"]]
    assert titles[5:-1] == [
        "Checks",
        "Ratings",
        "Steady state under the motor",
        "Elastic press",
        "Deflection under load, weight and inertia",
        "Balancing",
    ]
    assert data["over"]["quantity"] == "crank angle from bottom dead centre"
    assert floats(data["heights"])[0] == pytest.approx(0, abs=0.1)


ON_FOUR_MOUNTS = """\
file: zxn2_3000b
speed: 70 r/min
points: 180
foundation:
  frame: {mass: 30 t, centre: 0 0 100 mm, inertia: 30000 30000 10000 kg m2}
  mounts:
    points: [-0.8 -0.5 -1.5 m, -0.8 0.5 -1.5 m, 0.8 -0.5 -1.5 m, 0.8 0.5 -1.5 m]
    stiffness: 50 50 200 MN/m
    damping: 10 10 20 kN s/m
    loss_factor: 10 %
    area: 400 cm2
"""
PLACES = [(-0.8, -0.5, -1.5), (-0.8, 0.5, -1.5), (0.8, -0.5, -1.5), (0.8, 0.5, -1.5)]


def test_the_command_with_mounts(press: Any, tmp_path: Path) -> None:
    page = reported(tmp_path, ON_FOUR_MOUNTS)
    mounts = [pp.foundation.Mount(place, (5e7, 5e7, 2e8), (1e4, 1e4, 2e4), loss_factor=0.1, area=0.04) for place in PLACES]
    idle = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=180))
    system = pp.foundation.mounted(press, pp.foundation.Frame(3e4, (0, 0, 0.1), (3e4, 3e4, 1e4)), mounts)
    vibration = pp.foundation.steady_response(system, idle, points={"centre of the frame": (0, 0, 0.1)})
    results = [system, pp.foundation.modes(system), vibration]
    expected = sections(pp.report(press, idle.motion, tmp_path / "python.html", reactions=idle, results=results))
    found = sections(page)
    assert list(found) == list(expected)
    inputs = dict(data_in(page)["report"]["inputs"][0]["rows"])
    assert inputs["frame"] == "mass = 30 t, centre = (0, 0, 100) mm, inertia = (30000, 30000, 10000) kg m2"
    spring = "50 / 50 / 200 kN/mm along x, y, z, damping 10 / 10 / 20 kN s/m, loss factor 0.1, area 0.04 m²"
    assert inputs["mounts"] == f"4 at (-0.8, -0.5, -1.5), (-0.8, 0.5, -1.5), (0.8, -0.5, -1.5), (0.8, 0.5, -1.5) m: {spring}"
    assert list(inputs)[-1] == "computed by"
    for title in ("On its mounts at rest", "Modes on the mounts", "Vibration on the mounts"):
        assert found[title] == expected[title]


ON_RUBBER = """\
file: zxn2_3000b
speed: 70 r/min
points: 180
foundation:
  frame: {mass: 30 t, centre: 0 0 0, inertia: 30000 30000 10000 kg m2}
  mounts:
    points: [-0.8 -0.5 -1.5 m, -0.8 0.5 -1.5 m, 0.8 -0.5 -1.5 m, 0.8 0.5 -1.5 m]
    pad: {length: 200 mm, width: 20 cm, thickness: 10 mm, shear_modulus: 1.2 MPa}
  points: {"a:b": 0 0 1.5 m}
  speed_range: [30 r/min, 1.5 Hz]
"""


@pytest.mark.exhaustive
def test_the_command_on_rubber_over_the_speed(press: Any, tmp_path: Path) -> None:
    page = reported(tmp_path, ON_RUBBER)
    pad = pp.foundation.RubberPad(0.2, 0.2, 0.01, shear_modulus=1.2e6)
    frame = pp.foundation.Frame(3e4, (0, 0, 0), (3e4, 3e4, 1e4))
    system = pp.foundation.mounted(press, frame, [pp.foundation.pad_mount(place, pad) for place in PLACES])
    over = pp.foundation.over_speeds(system, np.linspace(30, 90, 61) * pp.RPM, points={"a:b": (0, 0, 1.5)})
    found = curves(chart(sections(page)["Vibration over the speed"], "Acceleration"))
    assert_allclose(found["a:b"][0], over.speed / pp.RPM, rtol=1e-6)
    assert_allclose(found["a:b"][1], np.linalg.norm(over.rms["a:b"], axis=1), rtol=1e-5)
    springs = [pp.foundation.Mount((x, y, 0), (1e6, 1e6, 1e6), loss_factor=0.05) for x, y, _ in PLACES]
    soft = pp.foundation.isolate(press, system.frame, springs, speeds=over.speed, transmitted=0.9)
    page = pp.report(press, pp.cycle(press, SPEED, points=36), tmp_path / "isolation.html", results=[soft])
    force = curves(chart(sections(page)["The stiffest mounts that isolate"], "Force on the floor by shaking force"))
    assert_allclose(force["transmitted"][1], 100 * soft.transmitted, rtol=1e-5)


FRAME_FILE = """\
frame: {mass: 15 t, centre: 0 100 -350 mm, inertia: 9000 8000 4000 kg m2}
mounts:
  points: [-0.55 -0.5 -1.3 m, -0.55 0.6 -1.3 m, 0.55 -0.5 -1.3 m, 0.55 0.6 -1.3 m]
  stiffness: 8 8 40 MN/m
attached: {motor: {mass: 450 kg, centre: 0 900 950 mm, inertia: 20 10 20 kg m2}}
rotors: {inertia: 136 kg m2, axis: 0 -1 0}
"""
LIFTING = """\
file: jf75g_125
speed: 350 r/min
points: 180
loads: {lifting: {kind: point-force, link: slide, force: 0 0 185 kN}}
foundation:
  points: {foot: 0.55 0.6 -1.3 m}
  lift_off: 2
"""


def indented(text: str) -> str:
    return "".join(f"  {line}\n" for line in text.splitlines())


@pytest.mark.exhaustive
def test_the_command_with_feet_that_lift_off(tmp_path: Path) -> None:
    """The motor aside, the flywheel's whirl and feet that lift off: numbers of the page are those of Python."""
    page, file = reported(tmp_path, LIFTING + indented(FRAME_FILE)), tmp_path / "frame.yaml"
    file.write_text(FRAME_FILE)
    found = sections(page)
    press, speed = texts.shipped("jf75g_125"), 350 * pp.RPM
    system = pp.foundation.read_mounted(press, file)
    lifting = pp.loads.PointForce("slide", (0, 0, 1.85e5))
    reactions = pp.inverse_dynamics(press, pp.cycle(press, speed, points=180), [lifting])
    points = {"centre of the frame": (0, 0.1, -0.35), "motor": ("motor", (0, 0.9, 0.95)), "foot": (0.55, 0.6, -1.3)}
    lifted = pp.foundation.lifting_response(system, reactions, points=points, strokes=2)
    shown = found["Vibration on mounts that only press"]
    rows = chart(shown, "Feet that lift off")["rows"]
    assert [int(row[1]) for row in rows] == [int((lifted.mount == k).sum()) for k in np.unique(lifted.mount)]
    loads = curves(chart(shown, "Force on each mount"))
    total = system.mount_load[:, 2] + lifted.motion.mount_force[:, :, 2]
    for k in range(4):
        assert_allclose(1e3 * loads[f"mount {k + 1}"][1], total[:, k], rtol=1e-5, atol=1.0)
    assert total.min() == 0.0  # at the first state too, at which the linear motion pulls
    acceleration = curves(chart(shown, "Acceleration along z"))
    assert list(acceleration) == list(points)
    for name, (_, values) in acceleration.items():
        assert_allclose(values, lifted.motion.acceleration[name][:, 2], rtol=1e-4, atol=1e-4)
    diagram = pp.foundation.whirl(system, np.linspace(0, speed, 61))
    whirling = curves(chart(found["Modes while the rotors spin"], "Natural frequency"))
    assert_allclose(whirling["mode 1"][1], diagram.frequency[:, 0] / (2 * np.pi), rtol=1e-5)
    inputs = dict(data_in(page)["report"]["inputs"][0]["rows"])
    assert inputs["rotor 1"].startswith("rotor: inertia = 136 kg m2")
    assert inputs["motor"].startswith("frame: mass = 450 kg")


def test_the_drawing_of_a_frame_of_beams(tmp_path: Path) -> None:
    """Its walk comes by every node of the model and jumps over none; feet and motor stand where they are."""
    press = texts.shipped("jf75g_125")
    system = pp.foundation.read_mounted(press, Path(__file__).parents[2] / "docs" / "jf75g_125_frame.yaml")
    page = pp.report(press, pp.cycle(press, SPEED, points=12), tmp_path / "page.html", results=[system])
    standing = sections(page)["On its mounts at rest"]
    for where, across in (("front", 0), ("side", 1)):
        view = chart(standing, f"The frame from the {where}")
        size = {"mm": 1e-3, "m": 1.0}[view["unit"]]
        drawn = {name: size * np.array(places).T for name, places in curves(view).items()}
        assert_allclose(drawn["mounts"], np.array([mount.point for mount in system.mounts])[:, [across, 2]], atol=1e-6)
        assert_allclose(drawn["motor, centre"], [[(0.0, 0.9)[across], 0.95]], atol=1e-6)
        nodes = system.frame.places[:, [across, 2]]
        for some, others in ((nodes, drawn["frame"]), (drawn["frame"], nodes)):
            assert np.linalg.norm(some[:, None] - others, axis=2).min(axis=1).max() < 1e-6
        assert np.linalg.norm(np.diff(drawn["frame"], axis=0), axis=1).max() < 0.2


BENDING = Path(__file__).parents[2] / "docs" / "jf75g_125_frame.yaml"


@pytest.mark.exhaustive
def test_points_and_modes_of_a_frame_that_bends(tmp_path: Path) -> None:
    """Points are interfaces, move with them or with the motor; the page of modes is that of Python."""
    shown = tmp_path / "modes.html"
    asked = "points={upper left: upper left, top: crown, fan: {on: motor, at: 0 0.9 1.3 m}}"
    job = f"file: jf75g_125\nspeed: 350 r/min\npoints: 180\nfoundation: {BENDING}\n"
    page = reported(tmp_path, job, "--modes", str(shown), "--set", f"foundation.{asked}")
    press = texts.shipped("jf75g_125")
    system = pp.foundation.read_mounted(press, BENDING)
    reactions = pp.inverse_dynamics(press, pp.cycle(press, 350 * pp.RPM, points=180))
    points = {"upper left": "upper left", "top": "crown", "fan": ("motor", (0, 0.9, 1.3))}
    wanted = pp.foundation.steady_response(system, reactions, points=points)
    acceleration = curves(chart(sections(page)["Vibration on the mounts"], "Acceleration along x"))
    for name in points:
        values = wanted.acceleration[name][:, 0]
        assert_allclose(acceleration[name][1], np.append(values, values[0]), rtol=1e-4, atol=1e-6)
    diagram = pp.foundation.whirl(system, np.linspace(0, 350 * pp.RPM, 61))
    assert shown.read_text() == pp.record_modes(press, diagram, tmp_path / "python.html", lowest=24).read_text()


CROWN = """\
crown: {mass: 7 t, centre: 0 0 0.6 m, inertia: 4000 3000 4000 kg m2}
uprights: {points: [-0.4 -0.5 0 m, -0.4 0.5 0 m, 0.4 -0.5 0 m, 0.4 0.5 0 m], stiffness: 300 300 2400 MN/m}
"""


def test_the_crown_of_a_frame_in_two_parts_is_shown(tmp_path: Path) -> None:
    (tmp_path / "frame.yaml").write_text(FRAME_FILE + CROWN)
    page = reported(tmp_path, "file: jf75g_125\nspeed: 300 r/min\npoints: 90\nfoundation: frame.yaml\n")
    shown = curves(chart(sections(page)["Vibration on the mounts"], "Acceleration along x"))
    assert list(shown) == ["centre of the bed", "centre of the crown", "motor"]


ON_SPRINGS = """\
file: crank_slide
speed: 70 r/min
foundation:
  frame: {mass: 1 t, centre: 0 0 0, inertia: 100 100 100 kg m2}
  mounts: {points: [-1 -1 0 m, -1 1 0 m, 1 -1 0 m, 1 1 0 m], stiffness: 1 1 1 MN/m}
"""


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("foundation.lift_off=0", "strokes is 0: give a whole number from 1"),
        ("foundation.speed_range=90 30 r/min", "foundation: speed_range: 90 30 r/min; write two speeds, the lower one first"),
        ("foundation.speed_range=30 r/min", "foundation: speed_range: 30 r/min; write two speeds, the lower one first"),
        ("foundation.points={a: b}", "point 'a' is 'b': give x, y, z [m] under a name"),
        ("foundation.frame.inertia=1 1 9 kg m2", "no body has this inertia"),
        ("foundation.mounts={points: [0 0 0], pad: {length: 1 m}}", "width and thickness are missing"),
        ("foundation.mounts={points: [0 0], stiffness: 1 1 1 MN/m}", "give x, y, z [m], finite"),
        ("foundation=frame.yaml", "frame.yaml"),
    ],
)
def test_foundations_that_cannot_be(change: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job, page = tmp_path / "job.yaml", tmp_path / "page.html"
    job.write_text(ON_SPRINGS)
    assert message in one_line(capsys, "report", job, "--out", page, "--set", change)
    assert list(tmp_path.iterdir()) == [job]


CURSORS = """() => [...document.querySelectorAll('.chart')].filter(box => box.querySelector('.cursor:not([hidden])')).map(box => {
    const plot = box.querySelector('.plot'), { xaxis } = plot._fullLayout, left = parseFloat(plot.querySelector('.cursor').style.left);
    return [box.querySelector('h3').textContent, xaxis.p2l(left - xaxis._offset)];
})"""


@pytest.mark.exhaustive
def test_every_kind_in_a_browser(
    press: Any, loaded: Any, ratings: Any, steady: Any, elastic: Any, balanced: Any, view: Callable[..., Any], tmp_path: Path
) -> None:
    """Charts over the height, over the crank angle and over time have the cursor where the press is; nothing goes wrong in the page."""
    system, crown = mounted(press), {"crown": (0, 0, 1.5)}
    snap = pp.elasticity.snap_through(1e6, 1e9, 5e3, damping_ratio=0.04)
    results = [
        ratings,
        steady,
        pp.elasticity.compliance(press, elastic),
        pp.elasticity.slide_deflection(press, loaded.motion, elastic),
        pp.elasticity.dead_centre_shift(press, elastic, speed=[4.0, 6.0]),
        snap,
        system,
        pp.foundation.modes(system),
        pp.foundation.steady_response(system, loaded, points=crown),
        pp.foundation.over_speeds(system, [4.0, 6.0], points=crown),
        balanced,
    ]
    page = view(pp.report(press, loaded.motion, tmp_path / "out.html", reactions=loaded, results=results), "#t=0", (1000, 500))
    state = 40
    page.evaluate("t => { setPlaying(false); seek(t); }", float(loaded.motion.time[state]))
    cursors = {title.split(" [")[0]: place for title, place in page.evaluate(CURSORS)}
    height = 1e3 * (loaded.motion.slide_position[state] - pp.dead_centres(press).bottom_position)
    assert cursors["Permissible force"] == pytest.approx(height, abs=0.5)
    assert cursors["Crank speed"] == pytest.approx(80, abs=0.5)
    assert cursors["Compliance at the slide, by parts"] == pytest.approx(80, abs=0.5)
    assert cursors["Acceleration along z"] == pytest.approx(loaded.motion.time[state], abs=2e-3)
    assert page.locator("h2").count() > 12
    rows = page.evaluate("[...document.querySelectorAll('.table')].map(box => box.scrollWidth - box.clientWidth)")
    assert max(rows) <= 0  # no column is clipped


@pytest.mark.exhaustive
def test_hostile_names_stay_text_in_every_kind(view: Callable[..., Any], tmp_path: Path) -> None:
    press = load_hostile(tmp_path)
    motion = pp.cycle(press, SPEED, points=36)
    reactions = pp.inverse_dynamics(press, motion, [pp.loads.ConstantForce(1e3, 0.02)])
    stiffness = pp.elasticity.Stiffness(bearings=dict.fromkeys(press.bearings, 1e9))
    capacities = pp.ratings.Capacities(1e5, bearings=dict.fromkeys(press.bearings, 1e6))
    region = pp.balancing.CounterweightRegion(NAMES["rod"], radius=0.1)
    results = [
        pp.ratings.rate(press, SPEED, capacities, points=31),
        pp.elasticity.compliance(press, stiffness),
        pp.balancing.balance(press, motion, regions=[region], minimise=pp.balancing.Range("shaking_force", "z")),
    ]
    page = view(pp.report(press, motion, tmp_path / "out.html", reactions=reactions, results=results), "#t=0.1", (1000, 500))
    assert page.locator("article script, article img, article b b, main script, main img").count() == 0
    for name in ("P", "W"):
        assert NAMES[name] in page.inner_text("#charts")


def test_same_results_same_bytes(press: Any, loaded: Any, ratings: Any, steady: Any, written: Path, tmp_path: Path) -> None:
    again = pp.report(press, replace(loaded).motion, tmp_path / "out.html", reactions=loaded, results=[ratings, steady])
    assert again.read_bytes() == written.read_bytes()


def test_press_on_its_springs(tmp_path: Path) -> None:
    """The run is drawn with magnified displacements, its forces stand beside the rigid press's, and so do its vibrations."""
    small, speed = texts.shipped("crank_slide"), 300 * pp.RPM
    elastic = pp.elasticity.Elastic(pp.elasticity.Stiffness(dict.fromkeys(small.bearings, 2e8), moments={"slide_guide": 2e7}))
    loads = [pp.loads.Blanking(1e5, 0.02, 0.01)]
    run = pp.steady_state(small, speed, drive=pp.drives.PrescribedSpeed(speed), loads=loads, elastic=elastic, points=73)
    assert isinstance(run, pp.ElasticRun)
    reactions = pp.inverse_dynamics(small, run, loads=loads)
    modes = pp.elasticity.natural_frequencies(small, elastic)
    diagram = pp.elasticity.campbell(small, elastic, speeds=np.array([200.0, 400.0]) * pp.RPM)
    strokes = pp.elasticity.over_speeds(small, elastic, speeds=np.array([200.0, 300.0]) * pp.RPM)
    path = pp.report(small, run, tmp_path / "out.html", reactions=reactions, results=[modes, diagram, strokes])
    found = sections(path)
    own = found["On its springs"]
    beside = curves(chart(own, "Slide next to the rigid press"))["slide"][1]
    size = {"µm": 1e-6, "mm": 1e-3}[chart(own, "Slide next to the rigid press")["unit"]]
    assert_allclose(size * beside, run.slide_position - run.rigid_slide_position, rtol=1e-5, atol=1e-9)
    forces = chart(own, "Force in W")
    assert_allclose(UNITS[forces["unit"]] * curves(forces)["on its springs"][1], np.linalg.norm(run.bearing_force["W"], axis=1), rtol=1e-5)
    assert_allclose(UNITS[forces["unit"]] * curves(forces)["rigid"][1], np.linalg.norm(reactions.bearing_force["W"], axis=1), rtol=1e-5)
    x, near = curves(chart(own, "Slide near bottom dead centre"))["rigid"]
    assert_allclose(near[np.abs(x).argmin()], 0.0, atol=1e-3 * np.abs(near).max())
    assert len(chart(own, "Where loads begin and end")["rows"]) == len(run.events) == 2
    assert figures(own)["deepest point"] == quantity("m").text(run.deepest - pp.dead_centres(small).bottom_position, 5)
    lowest = curves(chart(found["Vibrations on its springs"], "Natural frequencies"))["mode 1"][1]
    assert_allclose(lowest, modes.natural_frequency[:, 0] / (2 * np.pi), rtol=1e-6)
    assert_allclose(curves(chart(found["Strokes over the speed"], "Depth"))["slide"][1], 1e3 * strokes.depth, rtol=1e-5)
    assert "Resonances over the speed" in found
    assert data_in(path)["magnified"] > 1
    assert "slide_guide, W: 200 kN/mm" in dict(data_in(path)["report"]["inputs"][0]["rows"])["elastic parts"]


def test_journal_in_its_bearing(press: Any, loaded: Any, tmp_path: Path) -> None:
    """The orbit is drawn to one scale beside the circle of the clearance, with a row a turn."""
    orbit = np.array([[1.0e-4, 0.0], [0.0, -1.1e-4], [3e-5, 2e-5]])
    found = pp.elasticity.ImpactsByTurn(
        _press=press,
        bearing="F",
        radial=1e-4,
        start=np.array([0, 0]),
        turn=np.array([0, 1]),
        peak=np.array([6e4, 8e4]),
        depth=np.array([1e-5, 8e-6]),
        impacts=np.array([3, 4]),
        flight=np.array([0.1, 0.2]),
        orbit=orbit,
    )
    path = pp.report(press, loaded.motion, tmp_path / "journal.html", reactions=loaded, results=[found])
    section = sections(path)["Journal in F"]
    picture = chart(section, "Orbit of the journal")
    assert picture["square"]
    drawn = {curve["name"]: np.stack([floats(curve["x"]), floats(curve["y"])]) for curve in picture["curves"]}
    size = {"µm": 1e6, "mm": 1e3}[picture["unit"]]
    assert picture["across"] == f"across [{picture['unit']}]"
    assert_allclose(drawn["journal"], size * orbit.T, rtol=1e-6)
    assert_allclose(np.hypot(*drawn["bearing, by the clearance"]), 1e-4 * size, rtol=1e-6)
    assert figures(section)["largest force of a turn"].startswith("70")
    table = next(block for block in section["blocks"] if block.get("title") == "Turn by turn")
    assert [row[0:2] for row in table["rows"]] == [["1", "1"], ["1", "2"]]


def test_servo_motions(tmp_path: Path) -> None:
    press, drawing, limit = texts.shipped("zxn2_3000b"), pp.loads.DeepDrawing(1.5e6, 0.06), pp.servo.SlideSpeed(0.2, (0.06, 0.0))
    motors = pp.servo.read_motors(Path(__file__).parents[2] / "docs/servo_motors.csv")[3:4]
    choice = pp.servo.choose_motor(press, motors, [drawing], ratios=[60.0], time=2.4, limits=[limit], gear_inertia=50.0, points=360)
    best = choice.best
    assert best is not None
    motion = best.motion.motion
    ready = pp.servo.ready_motions(press, best.drive, [drawing], time=2.4, limits=[limit], points=90)
    compared = pp.servo.compare_motions({"least heat": best.motion, **ready}, [limit])
    results = [choice, best, compared, pp.servo.capacitor(best.motion)]
    reactions = pp.inverse_dynamics(press, motion, [drawing])
    found = sections(pp.report(press, motion, tmp_path / "out.html", reactions=reactions, results=results))
    servo = found["Servo drive"]
    assert "No motion" not in servo["note"]
    assert "no motion along these nodes that keeps the limits is better" in servo["note"]
    speed = curves(chart(servo, "Crank speed over its angle"))["best"]
    assert_allclose(speed[1].max(), best.motion.speed.max() / pp.RPM, rtol=1e-5)
    assert [row[0] for row in chart(servo, "What limits where")["rows"]] == [each.limit for each in best.limits]
    drawn = curves(chart(found["Motions beside one another"], "Slide speed on the way down"))
    assert list(drawn) == [*compared.motions, "limit"]
    assert_allclose(drawn["limit"], [[0.0, 60.0], [0.2, 0.2]])
    plane = curves(chart(found["Choice of the motor"], "Torque over speed"))
    assert plane["peak torque"][1].max() <= motors[0].peak_torque[0] * (1 + 1e-6)
    assert chart(found["Choice of the motor"], "Motors tried, the smallest first")["rows"][0][1] == "suffices"
    assert [figure["name"] for figure in found["Mains and capacitor"]["blocks"][0]["figures"]][-1] == "capacitor"


@pytest.mark.exhaustive
def test_all_charts_of_a_press_that_turns_backwards_run_from_0_down(tmp_path: Path) -> None:
    """Angles fall as time goes on, on all axes alike; values stay at their angles."""
    path = tmp_path / "table.yaml"
    path.write_text(json.dumps(TABLE))
    press = pp.build(path)
    stiffness = pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 1e9), moments={"slide_guide": 1e7})
    motion = pp.cycle(press, -2.0, points=72)
    loaded = pp.inverse_dynamics(press, motion, [pp.loads.ConstantForce(1e4, 0.02)])
    angle = np.linspace(0.0, 2 * np.pi, 37)
    compliance = pp.elasticity.compliance(press, stiffness, angle=angle)
    play = pp.tolerances.play(
        press, pp.cycle(press, -2.0, points=48), dict.fromkeys(("P", "W"), 1e-4), loads=[pp.loads.ConstantForce(1e4, 0.02)]
    )
    drive = pp.drives.Geared(pp.drives.InductionMotor(5500.0, 1485 * pp.RPM, inertia=0.04), -70.0)
    run = pp.steady_state(press, speed=-2.0, drive=drive, flywheel=pp.drives.Flywheel(50.0))
    page = pp.report(press, motion, tmp_path / "out.html", reactions=loaded, results=[compliance, play, run])
    data = data_in(page)["report"]
    assert data["period"] == -360.0
    seen = []
    for part in data["sections"]:
        for block in part["blocks"]:
            if block["kind"] == "lines" and block["follows"] == "position":
                for x, _ in curves(block).values():
                    seen.append(block["title"])
                    assert x[0] == pytest.approx(0.0, abs=1e-3)
                    assert x[-1] == pytest.approx(-360.0, abs=1e-3)
                    assert np.all(np.diff(x) < 0)
    assert {"Compliance at the slide, by parts", "Slide in its clearances", "Crank speed"} <= set(seen)
    parts = curves(chart(sections(page)["Elastic press"], "Compliance at the slide"))
    x, y = next(iter(parts.values()))
    _, values = next(iter(compliance.largest_parts(6)))
    np.testing.assert_allclose(y, 1e9 * np.interp(np.radians(x) % (2 * np.pi), angle, values), rtol=1e-5)
    forwards = pp.tolerances.play(press, pp.cycle(press, 2.0, points=48), {"P": 1e-4}, loads=[pp.loads.ConstantForce(1e4, 0.02)])
    spread = 1e-6 * np.arange(1, 49)
    forwards = replace(forwards, lowest=forwards.offset - spread, highest=forwards.offset + 2 * spread)
    page = pp.report(press, motion, tmp_path / "out.html", reactions=loaded, results=[forwards])
    offset = chart(sections(page)["Slide in its clearances"], "Slide in its clearances")
    (curve,), size = offset["curves"], {"µm": 1e6, "mm": 1e3}[offset["unit"]]
    low, high = (floats(end) for end in curve["band"])
    assert np.all(np.diff(floats(curve["x"])) < 0)
    np.testing.assert_allclose([low[1:], high[1:]], size * np.array([forwards.lowest[::-1], forwards.highest[::-1]]), rtol=1e-5, atol=1e-3)
