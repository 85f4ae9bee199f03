"""Quantities of pint are taken wherever numbers with a unit are, turned into SI units; those of another dimension are refused by name."""

import re

import numpy as np
import pint
import pytest
from numpy.testing import assert_allclose
from support import texts
from support.presses import sliding_presses

import pinpress as pp
from pinpress.balancing import CounterweightRegion
from pinpress.common.arguments import in_unit, read_quantity
from pinpress.common.quantities import QUANTITIES, quantity
from pinpress.dynamics.inputs import described

u = pint.UnitRegistry()
RPM = 2 * np.pi / 60


@pytest.fixture(scope="module")
def press():
    return texts.shipped("crank_slide")


def test_a_motion_in_units(press):
    turn = pp.cycle(press, 70 * u.rpm, points=12)
    assert_allclose(turn.slide_velocity, pp.cycle(press, 70 * RPM, points=12).slide_velocity, rtol=1e-12)
    states = pp.servo_cycle(press, angle=np.array([0, 90, 200]) * u.deg, speed=(1 * u.rpm, 1.0 * u.deg / u.ms, 2.0), acceleration=0.0)
    assert_allclose(states.crank_angle, np.radians([0, 90, 200]))
    assert_allclose(states.crank_speed, [RPM, np.radians(1e3), 2.0])
    assert_allclose(press.configuration(0.25 * u.turn), press.configuration(np.pi / 2))


def test_a_run_in_units(press):
    loads = [pp.loads.DeepDrawing(10 * u.kN, 20 * u.mm), pp.loads.PointForce("slide", (0 * u.N, 0, -1 * u.kN))]
    run = pp.simulate(
        press, 300 * u.ms, speed=60 * u.rpm, angle=15 * u.deg, flywheel=pp.drives.Flywheel(2e3 * u.kg * u.m**2), loads=loads, points=4
    )
    plain = pp.simulate(
        press,
        0.3,
        speed=60 * RPM,
        angle=np.radians(15),
        flywheel=pp.drives.Flywheel(2e3),
        loads=[pp.loads.DeepDrawing(1e4, 0.02), pp.loads.PointForce("slide", (0.0, 0.0, -1e3))],
        points=4,
    )
    assert_allclose(run.slide_position, plain.slide_position, rtol=1e-9)


MADE = {
    "load": (lambda: pp.loads.Blanking(1 * u.MN, 0.8 * u.cm, 3 * u.mm), pp.loads.Blanking(1e6, 0.008, 0.003)),
    "spring": (
        lambda: pp.loads.SpringDamper("frame", "slide", 10 * u.N / u.mm, point1=(0, 0, 5 * u.mm)),
        pp.loads.SpringDamper("frame", "slide", 1e4, point1=(0.0, 0.0, 0.005)),
    ),
    "friction": (lambda: pp.loads.Friction(0.1, 30 * u.mm), pp.loads.Friction(0.1, 0.03)),
    "switch point": (lambda: pp.drives.SwitchPoint(angle=90 * u.deg), pp.drives.SwitchPoint(angle=np.pi / 2)),
    "motor": (lambda: pp.drives.Flywheel(1200 * u.kg * u.m**2, 150 * u.rpm), pp.drives.Flywheel(1200.0, 150 * RPM)),
    "capacities": (
        lambda: pp.ratings.Capacities(4000 * u.kN, 12 * u.mm, bearings={"A": 2 * u.MN}),
        pp.ratings.Capacities(4e6, 0.012, bearings={"A": 2e6}),
    ),
    "region": (
        lambda: CounterweightRegion("crank", (0, 200 * u.lb), at=(10 * u.cm, 0, 0)),
        CounterweightRegion("crank", (0, 200 * 0.45359237), at=(0.1, 0.0, 0.0)),
    ),
    "frame": (
        lambda: pp.foundation.Frame(2 * u.tonne, np.array([0, 0, 900]) * u.mm, np.array([1, 1, 1]) * u.kg * u.m**2),
        pp.foundation.Frame(2e3, (0.0, 0.0, 0.9), (1.0, 1.0, 1.0)),
    ),
}


@pytest.mark.parametrize("name", MADE)
def test_parts_in_units(name):
    made, plain = MADE[name][0](), MADE[name][1]
    for field in vars(plain):
        first, second = getattr(made, field), getattr(plain, field)
        if isinstance(second, int | float | tuple | np.ndarray) and not isinstance(second, bool) and np.size(second):
            assert_allclose(np.asarray(first, dtype=float), second, rtol=1e-12)
        else:
            assert first == second


def test_tables_take_arrays_with_a_unit():
    table = pp.loads.ForceStroke(np.array([0, 10, 20]) * u.mm, [0 * u.kN, 1 * u.kN, 500 * u.N])
    assert_allclose(table.heights, [0, 0.01, 0.02])
    assert_allclose(table.forces, [0, 1000, 500])


TABLE = """units: mm
frame: O
parameters: {r: 100, m: 20, a: 0}
pins: {O: [0, 0], P: {from: O, length: r, angle: a}, W: {P: 400, x: 0, side: down}}
links: {crank: {pins: O P, mass: m}, rod: {pins: P W, mass: 15}, slide: {pins: W, guide: up, mass: 100}}
drive: O
"""


def test_pin_tables_in_units(tmp_path):
    """Lengths come in the table's unit, angles in degrees."""
    path = tmp_path / "press.yaml"
    path.write_text(TABLE, encoding="utf-8")
    with_units = pp.build(path, r=0.15 * u.m, m=20000 * u.g, a=0.5 * u.rad, gravity=(0, 0, -981) * u.cm / u.s**2)
    plain = pp.build(path, r=150, m=20, a=float(np.degrees(0.5)))
    assert with_units.text == plain.text
    assert_allclose(with_units.model.gravity.linear, [0, 0, -9.81])
    links = {
        "crank": {"pins": "O P", "mass": 20 * u.kg},
        "rod": {"pins": "P W", "mass": 15},
        "slide": {"pins": "W", "guide": "up", "mass": 1},
    }
    pins = {"O": [0, 0], "P": [0, 10 * u.cm], "W": {"P": 400 * u.mm, "x": 0, "side": "down"}}
    assert_allclose(pp.dead_centres(pp.build(units="mm", frame="O", pins=pins, links=links, drive="O")).stroke, 0.2)
    with pytest.raises(pp.PinpressError, match=r"a table cannot hold .*: give lengths, angles, masses"):
        pp.build(path, r=1 * u.N)


WRONG = {
    "a length for a speed": (lambda press: pp.cycle(press, 70 * u.mm), "speed is 70 millimeter: give it in rad/s"),
    "a frequency for a speed": (
        lambda press: pp.cycle(press, 1 * u.Hz),
        "speed is 1 hertz, which says no angle: give it in rad/s, or in rev",
    ),
    "a bare 1/min": (lambda press: pp.simulate(press, 1.0, speed=70 / u.min), "speed is 70 / minute, which says no angle"),
    "a mass for a force": (
        lambda _: pp.loads.DeepDrawing(100 * u.tonne, 0.01),
        "DeepDrawing: force is 100 metric_ton: give it in N, or in a mu",
    ),
    "a length for a number": (lambda _: pp.loads.Friction(1 * u.mm), "Friction: coefficient is 1 millimeter: give it without a unit"),
    "kg for m": (lambda _: pp.loads.PointForce("slide", (0, 0, 1 * u.kg)), "PointForce: force is 1 kilogram: give it in N"),
    "a stiffness": (lambda _: pp.foundation.Mount((0, 0, 0) * u.m, (1, 1, 1) * u.N), "Mount: stiffness is [1 1 1] newton: give it in N/m"),
}


@pytest.mark.parametrize("name", WRONG)
def test_other_dimensions_are_refused_by_name(press, name):
    ask, said = WRONG[name]
    with pytest.raises(pp.PinpressError, match=re.escape(said)):
        ask(press)


def test_what_a_driver_stands_has_the_unit_of_its_effort(press):
    crank, ram = pp.ratings.Capacities(1e6, torque=2 * u.kN * u.m), pp.ratings.Capacities(1e6, torque=20 * u.kN)
    assert (crank.torque, ram.torque) == (2e3, 2e4)
    toggle = texts.load(sliding_presses.TOGGLE)
    assert pp.ratings.rate(press, 60 * RPM, crank, points=3).torque_capacity == 2e3
    assert pp.ratings.rate(toggle, 0.1, ram, points=3).torque_capacity == 2e4
    for turned_round in (lambda: pp.ratings.rate(press, 60 * RPM, ram), lambda: pp.ratings.speed_limit(press, ram)):
        with pytest.raises(pp.PinpressError, match="torque is given in N, but the driver turns: give it in N m"):
            turned_round()
    with pytest.raises(pp.PinpressError, match="torque is given in N m, but the driver slides: give it in N"):
        pp.ratings.rate(toggle, 0.1, crank)
    with pytest.raises(pp.PinpressError, match="torque is 3 meter: give it in N m"):
        pp.ratings.Capacities(1e6, torque=3 * u.m)
    plain = pp.ratings.speed_limit(press, pp.ratings.Capacities(1e6), torque=2e3)
    assert pp.ratings.speed_limit(press, pp.ratings.Capacities(1e6), torque=2 * u.kN * u.m) == plain


@pytest.mark.parametrize(
    ("unit", "same"),
    [
        *(("m", "m"), ("kg m2", "kg*m**2"), ("m/s2", "m/s**2"), ("rad/s", "radian/s"), ("N m/rad", "N*m/rad"), ("N s/m", "N*s/m")),
        *(("N m s/rad", "N*m*s/rad"), ("m2", "m**2"), ("Pa", "Pa"), ("W", "W"), ("Hz", "Hz"), ("kg/m3", "kg/m**3"), ("-", "")),
    ],
)
def test_units_by_their_names(unit, same):
    assert in_unit("a value", u.Quantity(2.5, same), unit) == 2.5


def test_what_is_no_quantity_stays_as_it_is(press):
    values = [1.0, (2.0, [3])]
    assert in_unit("a value", values, "m") is values
    with pytest.raises(pp.PinpressError, match=r"force is not a number .*, but a quantity with a unit"):  # N or N m, or anything
        pp.measures.harmonics(pp.cycle(press, 7.0, points=24), np.ones(24) * u.N)


def test_lengths_in_mm_are_read_in_all_units_of_length():
    assert read_quantity("1cm", "mm") == pytest.approx(10.0)
    assert read_quantity("1in", "mm") == pytest.approx(25.4)


def test_a_unit_that_is_no_si_unit_has_the_numbers_of_its_row():
    """Values are in the unit that is asked for: 50 in Hz are 50 Hz, of whose row the SI unit is rad/s."""
    for row in QUANTITIES:
        for unit, size in row.sizes().items():
            asked = quantity(unit)
            if asked.name == row.name:
                assert asked.text(12.0, 6) == row.text(12.0 * size, 6), unit
    motor = pp.drives.InductionMotor(3e4, 1465 * pp.RPM)
    assert "frequency = 50 Hz" in described(motor)
