"""Scenarios as arrays: each equals the run of its own values, made one by one, and obeys the energy equation in plain formulas.

Bounds: a run keeps each step's error near 1e-11 of its sizes; all scenarios share panels that resolve the worst of them, so that a scenario
and its own run differ by rounding and that. 1e-9 rad is a hundred times as much.
"""

import dataclasses
import math
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import texts
from support.exploring import examples
from support.generators import small_linkages
from support.oracles import crank_slide_equation as equation
from support.time_limit import LIMIT, within

import pinpress as pp
from pinpress.simulation import batch
from pinpress.simulation.batch import RunBatch
from pinpress.simulation.over_angle import collocation

pytestmark = pytest.mark.usefixtures("time_limit")

RPM = pp.RPM
WHEEL = pp.drives.Flywheel(136.0)  # Zhang 2007, 4.3
BLANK = pp.loads.Blanking(1.25e6, 0.010, 0.005)
BOUND = 1e-9


@pytest.fixture(scope="module")
def press():
    return texts.shipped("jf75g_125", gravity=(0, 0, -9.80665))


@pytest.fixture(scope="module")
def textbook():
    return texts.shipped("crank_slide", gravity=(0, 0, -9.80665))


@pytest.fixture
def none_alone(monkeypatch):
    """No scenario may be run on its own: that would put right whatever goes wrong where all are solved together."""

    def refuse(*given, **named):
        raise AssertionError("a scenario is run alone")

    monkeypatch.setattr(batch, "simulate", refuse)


def alike(linkage, duration, build, values, which=None, **options):
    """Runs of arrays of values, compared with the runs of single values. ``build``: values by name to arguments of `simulate`; ``values``:
    (S,) by name. Where a single run raises, the scenario must have its error, and rest where it stopped."""
    runs = pp.simulate_batch(linkage, duration, **build(**{name: np.asarray(v, dtype=float) for name, v in values.items()}), **options)
    size = len(next(iter(values.values())))
    assert isinstance(runs, RunBatch)
    assert len(runs) == len(runs.errors) == size
    n = len(runs.time)
    assert runs.crank_angle.shape == runs.crank_speed.shape == (n, size)
    assert runs.drive_work.shape == runs.load_work.shape == (size,)
    for k in range(size) if which is None else which:
        single = build(**{name: float(v[k]) for name, v in values.items()})
        try:
            run = pp.simulate(linkage, duration, points=n, **single, **{name: v for name, v in options.items() if name != "points"})
        except pp.SimulationError as error:
            rests_where_it_stalled(runs, k, error)
        else:
            assert runs.errors[k] is None
            same(runs, k, run)
    return runs


def same(runs, k, run):
    np.testing.assert_array_equal(runs.time, run.time)
    fastest = max(1.0, float(np.abs(run.crank_speed).max()))
    np.testing.assert_allclose(runs.crank_angle[:, k], run.crank_angle, rtol=0, atol=BOUND)
    np.testing.assert_allclose(runs.crank_speed[:, k], run.crank_speed, rtol=0, atol=BOUND * fastest)
    if run.slide_position is not None:
        np.testing.assert_allclose(runs.slide_position[:, k], run.slide_position, rtol=0, atol=BOUND)
    for name in ("drive_work", "load_work"):
        works = getattr(run, name)
        assert getattr(runs, name)[k] == pytest.approx(works[-1], rel=BOUND, abs=BOUND * max(1.0, float(np.abs(works).max())))


def rests_where_it_stalled(runs, k, error):
    found = runs.errors[k]
    assert isinstance(found, pp.SimulationError)
    if error.time is None:
        return
    assert found.time == pytest.approx(error.time, rel=1e-8)
    assert found.crank_angle == pytest.approx(error.crank_angle, abs=1e-8)
    after = runs.time > error.time * (1 + 1e-8)
    np.testing.assert_allclose(runs.crank_angle[after, k], error.crank_angle, rtol=0, atol=1e-8)
    assert np.all(runs.crank_speed[after, k] == 0)


# ------------------------------------------------------------------------------------------------------------- what may be an array


def blanked(press, **change):
    return {"speed": 31.0, "flywheel": WHEEL, "drive": pp.drives.ConstantTorque(567.0), "loads": [BLANK]} | change


BUILDS = {
    "speeds": (lambda speed: blanked(None, speed=speed), {"speed": [20.0, 25.0, 31.4, 40.0, 55.0]}),
    "flywheels": (lambda j: blanked(None, flywheel=pp.drives.Flywheel(j)), {"j": [60.0, 136.0, 400.0, 2000.0]}),
    "torques": (lambda m: blanked(None, drive=pp.drives.ConstantTorque(m)), {"m": [-300.0, 0.0, 567.0, 2000.0]}),
    "motors": (
        lambda power, j: blanked(
            None, speed=29.0, drive=pp.drives.Geared(pp.drives.InductionMotor(power, 1465 * RPM, inertia=j), 5.0, 1.0)
        ),
        {"power": [5e3, 1e4, 3e4, 9e4], "j": [0.05, 0.1, 0.2, 0.8]},
    ),
    "lossy motors": (
        lambda power: blanked(None, drive=pp.drives.Geared(pp.drives.InductionMotor(power, 1465 * RPM), 5.0, efficiency=0.9)),
        {"power": [1.5e4, 3e4]},
    ),
    "gears": (lambda j: blanked(None, drive=pp.drives.Geared(pp.drives.InductionMotor(3e4, 1465 * RPM), 5.0, j)), {"j": [0.0, 2.0, 50.0]}),
    "inverters": (
        lambda j: blanked(None, speed=28.0, drive=pp.drives.Geared(pp.drives.InverterMotor(200.0, 1450 * RPM, 45.0, inertia=j), 5.0)),
        {"j": [0.0, 0.5]},
    ),
    "slip clutches": (
        lambda speed: blanked(
            None, speed=speed, drive=pp.drives.Geared(pp.drives.SlipClutchMotor(189.0, 1470 * RPM, 1320 * RPM, 900 * RPM), 3.0)
        ),
        {"speed": [28.0, 31.0, 33.0]},
    ),
    "slip clutches with a lag": (
        lambda j: blanked(
            None,
            flywheel=pp.drives.Flywheel(j),
            drive=pp.drives.Geared(pp.drives.SlipClutchMotor(189.0, 1470 * RPM, 1320 * RPM, 900 * RPM, lag=0.1), 3.0),
        ),
        {"j": [100.0, 200.0]},
    ),
    "forces": (lambda f: blanked(None, loads=[pp.loads.Blanking(f, 0.010, 0.005)]), {"f": [0.0, 1e5, 1.25e6, 2e6]}),
    "stripping": (
        lambda f, s: blanked(None, loads=[pp.loads.Blanking(f, 0.010, 0.005, stripping=s)]),
        {"f": [1e6, 1e6, 0.0], "s": [0.0, 2e5, 1e5]},
    ),
    "drawing": (lambda f: blanked(None, loads=[pp.loads.DeepDrawing(f, 0.012, 0.001)]), {"f": [1e5, 8e5]}),
    "piling": (lambda f: blanked(None, loads=[pp.loads.ConstantForce(f, 5e-5)]), {"f": [0.0, 1e5, 2e6]}),
    "dies": (lambda k: blanked(None, loads=[pp.loads.ElasticDie(0.002, k)]), {"k": [1e6, 1e8, 1e9]}),
    "damped dies": (lambda k, c: blanked(None, loads=[pp.loads.ElasticDie(0.002, k, c)]), {"k": [1e7, 1e8], "c": [1e4, 2e5]}),
    "several loads": (
        lambda f, p: blanked(
            None, loads=[pp.loads.Blanking(f, 0.010, 0.005), pp.loads.ConstantForce(p, 0.002), pp.loads.ElasticDie(0.001, 1e7)]
        ),
        {"f": [0.0, 1e6], "p": [1e5, 1e4]},
    ),
    "all at once": (
        lambda speed, j, m, f: {
            "speed": speed,
            "flywheel": pp.drives.Flywheel(j),
            "drive": pp.drives.Geared(pp.drives.ConstantTorque(m), 2.0, efficiency=0.95),
            "loads": [pp.loads.Blanking(f, 0.010, 0.005)],
        },
        {"speed": [30.0, 25.0, 40.0], "j": [100.0, 136.0, 80.0], "m": [100.0, 300.0, 0.0], "f": [1e6, 1e5, 5e5]},
    ),
    "a force in time": (
        lambda j: blanked(None, flywheel=pp.drives.Flywheel(j), loads=[pp.loads.TimeForce(lambda t: 1e5 * np.sin(30 * t))]),
        {"j": [50.0, 136.0]},
    ),
}

ALONE = ("damped dies", "slip clutches", "slip clutches with a lag", "a force in time")
"""Those of which some or all scenarios are run on their own: for their states, their time, corners that only some of them pass."""


@pytest.mark.one_in(13)
@pytest.mark.parametrize("name", BUILDS)
def test_each_is_its_own_run(press, name, request):
    build, values = BUILDS[name]
    if name not in ALONE:
        request.getfixturevalue("none_alone")
    runs = alike(press, 0.7, build, values)
    assert runs.errors == (None,) * len(runs)
    spread = max(np.ptp(runs.crank_angle[-1]), np.ptp(runs.load_work), np.ptp(runs.drive_work))
    assert spread > 1e-3  # the scenarios do differ


@pytest.mark.parametrize("size", [1, 3])
def test_tables_of_force(press, size):
    """(n, S) forces; S = 1 too. One falling table, a load that pulls, and heights with no force."""
    heights = [0.012, 0.008, 0.004, 0.0]
    forces = np.array([[0.0, 1e5, 0.0], [8e5, 2e5, -1e4], [1e6, 3e5, 5e5], [0.0, 0.0, 1e6]])[:, :size]
    runs = pp.simulate_batch(press, 0.7, **blanked(press, loads=[pp.loads.ForceStroke(heights, forces)]))
    assert len(runs) == size
    for k in range(size):
        same(runs, k, pp.simulate(press, 0.7, points=121, **blanked(press, loads=[pp.loads.ForceStroke(heights, forces[:, k])])))


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"speed": [31.0]},
        {"flywheel": pp.drives.Flywheel(np.array([136.0]))},
        {"drive": pp.drives.ConstantTorque(np.array([567.0]))},
        {"loads": [pp.loads.Blanking(np.array([1.25e6]), 0.010, 0.005)]},
    ],
    ids=["none", "speed", "flywheel", "drive", "load"],
)
def test_one_scenario_is_still_an_array(press, change):
    runs = pp.simulate_batch(press, 0.5, **blanked(press) | change)
    assert isinstance(runs, RunBatch)
    assert runs.crank_angle.shape == (121, 1)
    same(runs, 0, pp.simulate(press, 0.5, points=121, **blanked(press)))


@pytest.mark.usefixtures("none_alone")
@pytest.mark.parametrize("name", ["zxn2_3000b", "thin_wall", "jf75g_125_symmetric", "jf75g_125_two_point"])
def test_other_presses(name):
    press = texts.shipped(name)
    fast = 30.0 if name.startswith("jf") else 7.0
    alike(
        press,
        9.0 / fast,
        lambda speed, f: {
            "speed": speed,
            "angle": 0.4,
            "flywheel": pp.drives.Flywheel(1000.0),
            "drive": pp.drives.ConstantTorque(500.0),
            "loads": [pp.loads.ConstantForce(f, 0.004)],
        },
        {"speed": [fast, 1.1 * fast, -fast], "f": [1e4, 1e5, 3e4]},
    )


INVERTER = pp.drives.Geared(pp.drives.InverterMotor(480.0, 1450 * pp.RPM, 45.0, inertia=1.2), 20.7)
STRONG = pp.drives.Geared(pp.drives.InverterMotor(200.0, 1450 * pp.RPM, 45.0, inertia=0.1), 20.0)
LOSSY = pp.drives.Geared(pp.drives.InductionMotor(75e3, 1485 * pp.RPM, inertia=1.2), 20.7, efficiency=0.95)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("name", "motor", "speed", "least"),
    [
        ("zxn2_3000b", INVERTER, 70 * pp.RPM, 5e3),
        ("zxn2_3000b", LOSSY, 70 * pp.RPM, 5e3),
        ("crank_slide", STRONG, 6.0, 40.0),
    ],
    ids=["inverter", "gears_with_losses", "light_press"],
)
def test_drives_whose_torque_has_corners_are_solved_together_at_looser_tolerances(name, motor, speed, least, monkeypatch):
    """A motor that meets its limits, and gears whose motor drives and brakes, each scenario at other angles; in a light press so many of
    them that Newton's method does not settle on the first panels."""
    press, inertias = texts.shipped(name), np.linspace(least, 1.4 * least, 5)
    force = 1e6 if name == "zxn2_3000b" else 1e3
    how = {"speed": speed, "drive": motor, "loads": [pp.loads.DeepDrawing(force, 0.010)], "points": 30}
    judges = {k: pp.simulate(press, 1.5, flywheel=pp.drives.Flywheel(float(inertias[k])), **how) for k in (0, 4)}
    monkeypatch.setattr(batch, "simulate", None)  # none may be run alone
    runs = pp.simulate_batch(press, 1.5, flywheel=pp.drives.Flywheel(inertias), tolerance=1e-8, **how)
    speeds = runs.crank_speed
    assert any(speeds.min() < corner < speeds.max() for corner in motor.corners)
    for k, judge in judges.items():
        np.testing.assert_allclose(runs.crank_angle[:, k], judge.crank_angle, rtol=0, atol=2e-8)


@pytest.mark.usefixtures("none_alone")
def test_more_than_fit_at_once(press):
    """130 scenarios, three arrays of panels: each sixteenth is compared, and their order is kept."""
    rng = np.random.default_rng(3)
    values = {"speed": rng.uniform(25, 40, 130), "j": rng.uniform(100, 300, 130), "f": rng.uniform(0, 1.5e6, 130)}
    values["speed"][::3] *= -1
    build = lambda speed, j, f: blanked(None, speed=speed, flywheel=pp.drives.Flywheel(j), loads=[pp.loads.Blanking(f, 0.010, 0.005)])  # noqa: E731
    runs = alike(press, 0.4, build, values, which=[*range(0, 130, 16), 63, 64, 127, 129])
    np.testing.assert_allclose(runs.crank_speed[0], values["speed"], rtol=1e-11)
    np.testing.assert_array_equal(np.sign(runs.crank_angle[-1]), np.sign(values["speed"]))
    # work of the blank: a quarter sine, one or two strokes forwards; whoever passed 5 mm above bottom dead centre
    assert np.all(runs.load_work[values["f"] > 0] > 0)


@pytest.mark.usefixtures("none_alone")
def test_neither_order_nor_company_matters(press):
    values = np.array([33.0, -28.0, 41.0, 25.0, -35.0, 30.0])
    whole = pp.simulate_batch(press, 0.6, **blanked(press, speed=values))
    order = np.array([4, 2, 0, 5, 1, 3])
    turned = pp.simulate_batch(press, 0.6, **blanked(press, speed=values[order]))
    part = pp.simulate_batch(press, 0.6, **blanked(press, speed=values[:2]))
    twice = pp.simulate_batch(press, 0.6, **blanked(press, speed=np.repeat(values, 2)))
    for name in ("crank_angle", "crank_speed", "slide_position", "drive_work", "load_work"):
        of = getattr(whole, name)
        bound = BOUND * max(1.0, float(np.abs(of).max()))
        np.testing.assert_allclose(getattr(turned, name), of[..., order], rtol=0, atol=bound)
        np.testing.assert_allclose(getattr(part, name), of[..., :2], rtol=0, atol=bound)
        np.testing.assert_allclose(getattr(twice, name), np.repeat(of, 2, axis=-1), rtol=0, atol=bound)


# ------------------------------------------------------------------------------------------------------------------ plain formulas


def potential(q):
    """Of the JF75G-125's weights [J]: crank and balance weight, and each side's rod and slide."""
    total = -equation.G * (equation.M1 * equation.RHO1 - equation.M4 * equation.RHO3) * np.cos(q)
    for side in equation.SIDES:
        upright = np.sqrt(1 - (side.r / side.length * np.sin(q)) ** 2)
        rod = side.r * np.cos(q) + (side.length - side.rho) * upright
        total -= equation.G * side.sign * (side.rod * rod + side.slide * (side.r * np.cos(q) + side.length * upright))
    return total


@pytest.mark.usefixtures("none_alone")
def test_energy_in_plain_formulas(press):
    """(I + J) w^2 / 2 + V of all states is what the torque has put in, less a quarter sine a stroke; I from `crank_slide_equation`."""
    rng = np.random.default_rng(5)
    speed, wheel, torque, force = (rng.uniform(*limits, 12) for limits in ((20, 45), (80, 300), (-200, 800), (0, 1e6)))
    runs = pp.simulate_batch(
        press,
        1.0,
        speed=speed,
        drive=pp.drives.ConstantTorque(torque),
        flywheel=pp.drives.Flywheel(wheel),
        loads=[pp.loads.Blanking(force, 0.010, 0.005)],
        points=51,
    )
    assert runs.errors == (None,) * 12
    angle = runs.crank_angle
    inertia = np.vectorize(lambda q: equation.coefficients(q).inertia)(angle) + wheel
    first, second = (2 * math.pi - equation.angle_of(height) for height in (0.010, 0.005))
    turns, within_turn = np.divmod(angle, 2 * math.pi)
    height = np.vectorize(lambda q: equation.coefficients(q).height)(angle)
    share = np.where(within_turn < first, 0.0, np.where(within_turn > second, 1.0, 1 - np.cos(math.pi / 2 * (0.010 - height) / 0.005)))
    work = force * 2 / math.pi * 0.005 * (turns + share)
    energy = 0.5 * inertia * runs.crank_speed**2 + potential(angle)
    fastest = 0.5 * wheel * runs.crank_speed.max(axis=0) ** 2
    assert np.all(np.abs(energy - energy[0] - torque * angle + work) < 1e-9 * fastest)
    np.testing.assert_allclose(runs.drive_work, torque * angle[-1], rtol=0, atol=1e-9 * fastest.max())
    np.testing.assert_allclose(runs.load_work, work[-1], rtol=0, atol=1e-9 * fastest.max())
    # and time: a path whose rate is its speed, by Simpson's rule over 2000 intervals (its error 1e-9)
    fine = pp.simulate_batch(
        press, 1.0, speed=speed, drive=pp.drives.ConstantTorque(torque), flywheel=pp.drives.Flywheel(wheel), points=2001
    )
    w = fine.crank_speed
    travelled = (w[0] + w[-1] + 4 * w[1:-1:2].sum(axis=0) + 2 * w[2:-1:2].sum(axis=0)) / 6000
    np.testing.assert_allclose(travelled, fine.crank_angle[-1], rtol=1e-8)


@pytest.mark.usefixtures("none_alone")
def test_many_motors_by_scipy(press):
    """Kloss's torque behind gears, and a blank with its stripping, for 2 of 70 scenarios."""
    power, speed, force = np.linspace(1e4, 4e4, 70), np.linspace(28.0, 31.0, 70), np.linspace(1e6, 4e5, 70)
    motor = pp.drives.Geared(pp.drives.InductionMotor(power, 1465 * RPM, inertia=0.1), 5.0)
    loads = [pp.loads.Blanking(force, 0.010, 0.005, stripping=0.2 * force)]
    runs = pp.simulate_batch(press, 0.45, speed=speed, angle=0.2, drive=motor, flywheel=WHEEL, loads=loads, points=10)
    synchronous = 50 * math.pi
    for k in (1, 69):

        def torque(t, q, w, states, k=k):
            slip, most = 1 - 5 * w / synchronous, (1 - 1465 * RPM / synchronous) * (2.5 + math.sqrt(2.5**2 - 1))
            return 5 * 2 * 2.5 * power[k] / (1465 * RPM) / (slip / most + most / slip)

        windows = [
            equation.Window(0.010, 0.005, -1, lambda h, v, k=k: force[k] * math.sin(math.pi / 2 * (0.010 - h) / 0.005)),
            equation.Window(0.010, 0.005, 1, lambda h, v, k=k: -0.2 * force[k]),
        ]
        solution = equation.solve(runs.time, speed[k], WHEEL.inertia + 2.5, 0.2, torque, windows=windows)
        np.testing.assert_allclose(runs.crank_angle[:, k], solution.angle, rtol=0, atol=1e-9)
        np.testing.assert_allclose(runs.crank_speed[:, k], solution.speed, rtol=1e-9)
        most = np.abs(solution.load_work).max()
        assert abs(runs.drive_work[k] - solution.drive_work[-1]) < 1e-9 * most
        assert abs(runs.load_work[k] - solution.load_work[-1]) < 1e-9 * most
        assert solution.angle[-1] > 4 * math.pi  # two strokes


# ----------------------------------------------------------------------------------------------- both ways, from rest, swings, stalls


def test_both_ways_and_from_rest(press):
    """The JF75G-125 is its own mirror image, and from rest the torque alone decides."""
    build = lambda speed, m: blanked(None, speed=speed, drive=pp.drives.ConstantTorque(m), loads=[])  # noqa: E731
    values = {"speed": [30.0, -30.0, 0.0, 0.0, 25.0, -25.0], "m": [567.0, -567.0, 567.0, -567.0, 0.0, 0.0]}
    runs = alike(press, 0.7, build, values)
    np.testing.assert_allclose(runs.crank_angle[:, 1::2], -runs.crank_angle[:, ::2], rtol=0, atol=BOUND)


def test_some_swing_back(textbook):
    """By their energy at bottom dead centre: that to lift slide and rod by 0.2 m and the crank's centre of mass by 0.06 m, or less."""
    inertia = 0.1 + 20 * 0.03**2 + 15 * 0.05**2 + 0.2 * 0.25**2 + 4.0  # crank, rod's middle at half the pin's speed, its turning, flywheel
    least = math.sqrt(2 * 9.80665 * (20 * 0.06 + 15 * 0.2 + 100 * 0.2) / inertia)
    speed = least * np.array([0.05, 0.3, -0.9, 0.99, 1.01, -1.1, 2.0])
    runs = alike(textbook, 1.5, lambda speed: {"speed": speed, "flywheel": pp.drives.Flywheel(4.0)}, {"speed": speed})
    np.testing.assert_array_equal(np.abs(runs.crank_angle).max(axis=0) > math.pi, np.abs(speed) > least)
    assert np.all((runs.crank_speed[:, :4].min(axis=0) < 0) & (runs.crank_speed[:, :4].max(axis=0) > 0))


def test_some_stall(press):
    """Their errors are those of their own runs; they rest where they stopped, with the works done up to there; the others go on."""
    build = lambda speed, m: {  # noqa: E731
        "speed": speed,
        "flywheel": pp.drives.Flywheel(50.0),
        "drive": pp.drives.ConstantTorque(m),
        "loads": [BLANK],
    }
    values = {"speed": [3.0, 31.0, 10.0, -4.0], "m": [100.0, 200.0, 300.0, -100.0]}
    runs = alike(press, 2.0, build, values)
    assert [error is not None for error in runs.errors] == [True, False, True, True]
    assert "3 stalled" in repr(runs)
    for k in (0, 2, 3):
        error = runs.errors[k]
        assert runs.drive_work[k] == pytest.approx(values["m"][k] * error.crank_angle, rel=1e-8)
        before = runs.time < error.time
        cut = pp.simulate(press, error.time * 0.999, points=2, **build(values["speed"][k], values["m"][k]))
        at = np.flatnonzero(before)[-1]
        assert abs(runs.crank_angle[at, k]) < abs(error.crank_angle)
        assert abs(cut.crank_angle[-1] - error.crank_angle) < 0.1
        with pytest.raises(pp.SimulationError) as raised:
            runs[k]
        assert str(raised.value) == str(error)
    assert np.isfinite(runs.crank_angle).all()
    assert np.isfinite(runs.slide_position).all()


def test_before_a_stall_it_is_the_run(press):
    """The states before it are those of a run that ends before it."""
    options = {"flywheel": pp.drives.Flywheel(50.0), "drive": pp.drives.ConstantTorque(300.0), "loads": [BLANK]}
    runs = pp.simulate_batch(press, 2.0, speed=np.array([10.0, 31.0]), points=201, **options)
    assert runs.errors[0].time > 1.5
    run = pp.simulate(press, 1.5, speed=10.0, points=151, **options)
    np.testing.assert_allclose(runs.crank_angle[:151, 0], run.crank_angle, rtol=0, atol=1e-8)
    np.testing.assert_allclose(runs.crank_speed[:151, 0], run.crank_speed, rtol=0, atol=1e-7)


@st.composite
def sets(draw):
    size = draw(st.integers(1, 6))
    column = lambda low, high: np.array(draw(st.lists(st.floats(low, high).map(lambda x: round(x, 3)), min_size=size, max_size=size)))  # noqa: E731
    speed = column(-40.0, 40.0)
    speed[np.abs(speed) < 0.5] = 0.0  # creeping runs take long, one by one as well
    return {"speed": speed, "j": column(20.0, 500.0), "m": column(-800.0, 800.0), "f": column(0.0, 2e6), "s": column(0.0, 3e5)}


@pytest.mark.exhaustive
@examples(6)
@given(values=sets(), angle=st.sampled_from([0.0, 1.0, -2.5, 9.0]))
def test_random_sets(press, values, angle):
    def build(speed, j, m, f, s):
        load = pp.loads.Blanking(f, 0.010, 0.005, stripping=s)
        return {"speed": speed, "angle": angle, "flywheel": pp.drives.Flywheel(j), "drive": pp.drives.ConstantTorque(m), "loads": [load]}

    alike(press, 0.4, build, values, points=31)


# --------------------------------------------------------------------------------------------------------------------- what comes back


@pytest.fixture(scope="module")
def three(press):
    return pp.simulate_batch(press, 0.5, **blanked(press, speed=[25.0, 30.0, -35.0]), points=41)


def test_a_scenario_is_a_full_run(press, three):
    """With forces, duty and all that a run has."""
    for k, speed in ((0, 25.0), (1, 30.0), (2, -35.0), (-1, -35.0), (np.int64(1), 30.0)):
        run = three[k]
        assert isinstance(run, pp.Run)
        single = pp.simulate(press, 0.5, **blanked(press, speed=speed), points=41)
        np.testing.assert_array_equal(run.crank_angle, single.crank_angle)
        np.testing.assert_array_equal(run.drive_work, single.drive_work)
        same(three, int(k) % 3, run)
    assert run.stats.energy_error < 1e-9
    assert pp.measures.duty_cycle(run).drive_work == pytest.approx(run.drive_work[-1], rel=1e-12)
    assert pp.inverse_dynamics(press, run).driving_torque.shape == (41,)


def test_a_scenario_keeps_its_own_values(press):
    """Of drive, flywheel and load, also inside a gear."""
    power, wheel, force = np.array([1e4, 3e4]), np.array([100.0, 200.0]), np.array([1e5, 5e5])
    drive = pp.drives.Geared(pp.drives.InductionMotor(power, 1465 * RPM), 5.0)
    runs = pp.simulate_batch(
        press, 0.3, speed=29.0, drive=drive, flywheel=pp.drives.Flywheel(wheel), loads=[pp.loads.Blanking(force, 0.010, 0.005)]
    )
    for k in range(2):
        run = runs[k]
        assert run.problem.driven.inertia == wheel[k]
        assert run.problem.driven.drive.drive.rated_power == power[k]
    np.testing.assert_array_equal(power, [1e4, 3e4])


def test_states_of_a_batch(three):
    """Even times, starts as given, read-only arrays; its runs one after the other."""
    np.testing.assert_allclose(three.time, np.linspace(0, 0.5, 41), rtol=1e-15)
    np.testing.assert_allclose(three.crank_angle[0], 0.0, atol=1e-13)
    np.testing.assert_allclose(three.crank_speed[0], [25.0, 30.0, -35.0], rtol=1e-11)
    for name in ("time", "crank_angle", "crank_speed", "drive_work", "load_work"):
        assert not getattr(three, name).flags.writeable
    assert repr(three) == "<RunBatch of jf75g_125: 3 scenarios, 41 states each, 0.5 s>"
    assert [float(run.crank_speed[0]) for run in three] == pytest.approx([25.0, 30.0, -35.0], rel=1e-11)


@pytest.mark.parametrize("k", [3, -4, 1.0, "0", None, True])
def test_no_such_scenario(three, k):
    with pytest.raises(pp.PinpressError, match="3 scenarios"):
        three[k]


@pytest.fixture
def disc():
    return small_linkages.disc()


def test_a_press_without_a_slide(disc):
    torque, speed = np.array([-2.0, 0.0, 5.0]), np.array([4.0, 5.0, 6.0])
    began = time.perf_counter()
    runs = pp.simulate_batch(disc, 2.0, speed=speed, drive=pp.drives.ConstantTorque(torque), flywheel=pp.drives.Flywheel(2.0), points=21)
    assert 0 < runs.wall_time <= time.perf_counter() - began
    assert runs.slide_position is None
    t = runs.time[:, None]
    np.testing.assert_allclose(runs.crank_speed, speed + torque / 5 * t, rtol=1e-10)
    np.testing.assert_allclose(runs.crank_angle, speed * t + torque / 10 * t**2, rtol=1e-10, atol=1e-10)
    table = runs.columns()
    assert list(table) == ["scenario", "time [s]", "crank_angle [rad]", "crank_speed [rad/s]"]
    for k in range(3):
        mine = table["scenario"] == k
        np.testing.assert_array_equal(table["time [s]"][mine], runs.time)
        np.testing.assert_array_equal(table["crank_speed [rad/s]"][mine], runs.crank_speed[:, k])


def test_more_periods_than_may_be_are_an_error(press, monkeypatch):
    """Told with the time and angle reached; a drive may turn a press further than its first speed says."""
    monkeypatch.setattr(batch, "MOST_PERIODS", 2)
    with pytest.raises(pp.SimulationError, match="period") as raised:
        pp.simulate_batch(press, 1.0, speed=[30.0, 28.0], flywheel=WHEEL)
    assert raised.value.crank_angle == pytest.approx(4 * math.pi)
    assert raised.value.time == pytest.approx(4 * math.pi / 28.0, rel=0.05)


# ----------------------------------------------------------------------------------------------------------------------- bad arguments

BAD = {
    "lengths": ({"speed": [30.0, 31.0], "flywheel": pp.drives.Flywheel(np.array([1.0, 2.0, 3.0]))}, "speed 2.*inertia 3"),
    "one and three": ({"speed": [30.0], "flywheel": pp.drives.Flywheel(np.array([1.0, 2.0, 3.0]))}, "speed 1.*inertia 3"),
    "lengths of loads": (
        {"drive": pp.drives.ConstantTorque(np.ones(2)), "loads": [pp.loads.ConstantForce(np.ones(3), 0.01)]},
        "value 2.*force 3",
    ),
    "angles": ({"speed": 30.0, "angle": [0.0, 1.0]}, "angle is an array"),
    "one angle in an array": ({"angle": np.array([0.0])}, "angle is an array"),
    "far": ({"angle": 1e12}, "turns away"),
    "a table": ({"speed": [[30.0, 31.0]]}, "speed is"),
    "tolerance": ({"tolerance": 1e-30}, "tolerance is"),
    "one load": ({"loads": BLANK}, "give a list"),
    "a prescribed speed": ({"drive": pp.drives.PrescribedSpeed(30.0)}, "prescribes"),
    "loads at a prescribed speed": (
        {"drive": pp.drives.PrescribedSpeed(30.0), "speed": 30.0, "loads": [pp.loads.ConstantForce(np.ones(2), 0.01)]},
        "prescribes",
    ),
    "too many turns": ({"duration": 1e6}, "turns"),
    "too fast": ({"speed": [1e150, 31.0], "duration": 1.0}, "turns|too fast"),
}


@pytest.mark.parametrize("name", BAD)
def test_arguments_that_make_no_sense_are_refused(press, name):
    change, message = BAD[name]
    good = {"press": press, "duration": 0.1, "speed": [30.0, 31.0], "flywheel": WHEEL}
    with within(LIMIT), pytest.raises(pp.PinpressError, match=message):
        pp.simulate_batch(**good | change)


def test_no_inertia_in_one(press):
    """Only that one has an error."""
    runs = pp.simulate_batch(press, 0.2, speed=30.0, flywheel=pp.drives.Flywheel(np.array([100.0, -100.0])))
    assert runs.errors[0] is None
    assert "inertia" in str(runs.errors[1])
    assert runs.drive_work[1] == runs.load_work[1] == runs.lost[1] == runs.energy_error[1] == 0
    assert not runs.crank_angle[:, 1].any()
    assert not runs.crank_speed[:, 1].any()


@pytest.mark.filterwarnings("ignore:.*of the weight of the slide")
def test_arrays_that_are_no_scenarios(press):
    """Vectors of forces and points, curves and programs are one value, however they are written."""
    point = np.array([0.0, 0.0, -0.1])
    spring = pp.loads.SpringDamper("frame", "slide", stiffness=1e4, damping=10.0, free_length=0.4, point1=point)
    for load in (pp.loads.PointForce("slide", np.array([0.0, 0.0, -100.0]), point=point), spring):
        run = pp.simulate(press, 0.1, speed=30.0, flywheel=WHEEL, loads=[load])
        assert isinstance(run, pp.Run)
    table = pp.loads.ForceStroke(np.array([0.0, 0.01]), np.array([1e3, 0.0]))
    motor = pp.drives.Geared(pp.drives.InverterMotor(200.0, 1450 * RPM, 45.0, curve=np.array([[10.0, 300.0], [60.0, 250.0]])), 5.0)
    assert isinstance(pp.simulate(press, 0.1, speed=28.0, flywheel=WHEEL, drive=motor, loads=[table]), pp.Run)
    runs = pp.simulate_batch(press, 0.1, speed=[28.0, 29.0], flywheel=WHEEL, drive=motor, loads=[table, spring])
    assert len(runs) == 2


# ------------------------------------------------------------------------------------------------- what a caller's own class declares


@dataclasses.dataclass(frozen=True)
class Curve(pp.drives.SpeedTorqueDrive):
    """A caller's own drive: torque over the crank's speed, straight between points."""

    speeds: np.ndarray
    torques: np.ndarray
    inertia: float = 0.0
    rated_torque = None

    @property
    def corners(self):
        return tuple(self.speeds)

    def torque(self, speed, angle=0.0, time=0.0, state=()):
        return np.interp(speed, self.speeds, self.torques)


@dataclasses.dataclass(frozen=True)
class Burst(Curve):
    """A rotor that does not stand more than 62 rad/s, which is more than twice the speeds at which a run tries it first."""

    def torque(self, speed, angle=0.0, time=0.0, state=()):
        if np.any(speed > 62.0):
            raise ValueError("the rotor bursts")
        return super().torque(speed)


def test_a_law_that_raises_is_told_with_where(press):
    """At the start of the period in which it raises; what it raised is the cause."""
    drive = Burst(np.array([0.0, 100.0]), np.array([2500.0, 2500.0]))
    with pytest.raises(pp.SimulationError, match=r"Burst.*the rotor bursts") as raised:
        pp.simulate_batch(press, 4.0, speed=[29.0, 30.0], drive=drive, flywheel=WHEEL)
    assert isinstance(raised.value.__cause__, ValueError)
    turns = raised.value.crank_angle / (2 * math.pi)
    assert turns == pytest.approx(round(turns))
    assert turns >= 1
    assert 2 * math.pi * turns / 62 < raised.value.time < 2 * math.pi * turns / 29


@pytest.mark.parametrize("way", [1, -1])
def test_a_torque_that_is_constant_but_near_rest(disc, way):
    """It brakes with 5 N m down to 1 rad/s, and below with less, in proportion: constant at all speeds before, it would stop the crank.

    With 5 kg m2: w = w0 - t down to 1, then exp(-t)."""
    drive = Curve(np.array([-100.0, -1.0, 1.0, 100.0]), np.array([5.0, 5.0, -5.0, -5.0]))
    first = np.array([4.0, 5.0, 3.0])
    runs = pp.simulate_batch(disc, 6.0, speed=way * first, drive=drive, flywheel=pp.drives.Flywheel(2.0), points=31)
    assert runs.errors == (None, None, None)
    t = runs.time[:, None]
    late = np.maximum(t - (first - 1), 0.0)
    early = t - late
    np.testing.assert_allclose(way * runs.crank_speed, (first - early) * np.exp(-late), rtol=1e-8)
    np.testing.assert_allclose(way * runs.crank_angle, first * early - early**2 / 2 + 1 - np.exp(-late), rtol=1e-8, atol=1e-9)


@dataclasses.dataclass(frozen=True)
class Scaled(Curve):
    """The same with a gain, one for each scenario."""

    inertia: float = dataclasses.field(default=0.0, metadata=pp.drives.parameter("kg m2", "not negative", scenarios=True))

    def torque(self, speed, angle=0.0, time=0.0, state=()):
        return super().torque(speed) * (1.0 + 0.01 * self.inertia)


POINTS = np.array([0.0, 10.0, 20.0, 28.0, 31.0, 40.0])
TORQUES = np.array([900.0, 950.0, 1000.0, 900.0, 500.0, -500.0])


def test_a_torque_curve_of_six_points_is_one_drive(press):
    """What an array means is what its class says, never its shape."""
    run = pp.simulate(press, 0.3, **blanked(press, drive=Curve(POINTS, TORQUES)))
    assert isinstance(run, pp.Run)
    expected = pp.simulate(press, 0.3, **blanked(press, drive=Curve(tuple(POINTS), tuple(TORQUES))))
    np.testing.assert_array_equal(run.crank_angle, expected.crank_angle)
    assert isinstance(
        pp.steady_state(press, 30.0, drive=Curve(POINTS, TORQUES), flywheel=WHEEL, loads=[pp.loads.Blanking(1e5, 0.010, 0.005)]), pp.Run
    )


def test_a_drive_that_declares_its_scenarios(press):
    build = lambda j: blanked(None, drive=pp.drives.Geared(Scaled(POINTS, TORQUES, j), 1.2))  # noqa: E731
    runs = alike(press, 0.3, build, {"j": [0.0, 5.0, 50.0]})
    assert np.ptp(runs.drive_work) > 10.0


def test_a_declared_field_of_another_shape(press):
    with pytest.raises(pp.PinpressError, match=r"Scaled: inertia has shape \(2, 2\); give a finite number that is not negative \[kg m2\]"):
        pp.simulate_batch(press, 0.1, **blanked(press, drive=Scaled(POINTS, TORQUES, np.ones((2, 2)))))


SEVERAL = {
    "speed": ({"speed": [30.0, 31.0]}, "speed has 2 scenarios"),
    "drive": ({"drive": pp.drives.Geared(pp.drives.ConstantTorque(np.ones(3)), 2.0)}, "ConstantTorque.value has 3 scenarios"),
    "flywheel": ({"flywheel": pp.drives.Flywheel(np.ones(2))}, "Flywheel.inertia has 2 scenarios"),
    "load": ({"loads": [pp.loads.ConstantForce(np.ones(2), 0.01)]}, "ConstantForce.force has 2 scenarios"),
}


@pytest.mark.parametrize("what", SEVERAL)
def test_several_scenarios_are_asked_for_in_words(press, what):
    change, message = SEVERAL[what]
    with pytest.raises(pp.PinpressError, match=f"{message}, and simulate takes one: .* simulate_batch"):
        pp.simulate(press, 0.1, **blanked(press) | change)


@pytest.mark.parametrize("count", [2, 3])
def test_one_of_several_dies_is_resolved_alone(textbook, count):
    """Contacts are lost in one scenario alone, whose panels are cut while the others are settled."""
    height, masses = 0.006, sum(body.mass for body in textbook.model.inertias)
    energy = 0.5 * 5 * masses * 0.2**2 * 10.0**2
    speeds, stiffness = 10.0 * np.linspace(0.9, 1.1, count), 10 * 0.6 * energy / height**2 * np.linspace(0.3, 1.0, count)
    wheel = pp.drives.Flywheel(5 * masses * 0.2**2)
    runs = pp.simulate_batch(textbook, 1.0, speed=speeds, flywheel=wheel, loads=[pp.loads.ElasticDie(height, stiffness)])
    for place, (speed, hard) in enumerate(zip(speeds, stiffness, strict=True)):
        own = pp.simulate(textbook, 1.0, speed=float(speed), flywheel=wheel, loads=[pp.loads.ElasticDie(height, float(hard))])
        assert runs.crank_angle[-1, place] == pytest.approx(own.crank_angle[-1], abs=BOUND)


# ---------------------------------------------------------------------------------------------------------------------- energy audit


def test_every_scenario_keeps_its_energy(press):
    """Of those solved together, and of those that stall, which run alone, up to there."""
    options = {"flywheel": pp.drives.Flywheel(50.0), "drive": pp.drives.ConstantTorque(np.array([300.0, 200.0, -300.0])), "loads": [BLANK]}
    runs = pp.simulate_batch(press, 1.8, speed=[10.0, 31.0, 4.0], **options)
    assert [error is None for error in runs.errors] == [False, True, False]
    assert runs.energy_error.shape == (3,)
    assert np.all((runs.energy_error > 0) & (runs.energy_error < 1e-9))


def test_a_scenario_whose_energy_does_not_balance_is_refused(press, monkeypatch):
    """Newton's method given up too early: torques that belong to other speeds, in one scenario much, in one a little. Alone they fare no
    better."""
    drive = pp.drives.Geared(pp.drives.InductionMotor(np.array([1e4, 3e4]), 1465 * RPM, inertia=0.1), 5.0)
    monkeypatch.setattr(collocation, "SETTLED", 1.0)
    runs = pp.simulate_batch(press, 0.5, **blanked(press, speed=10.0, drive=drive, loads=[]))
    assert runs.errors[0] is None
    assert 1e-8 < runs.energy_error[0] < 1e-6
    assert "energy does not balance" in str(runs.errors[1])
    assert runs.errors[1].time is not None
