"""Balance cylinders and cushions on air: their law against the state of a gas, work over a turn, and a falling mass by SciPy."""

import math
import warnings

import numpy as np
import pytest
from scipy.integrate import quad
from support.oracles import crank_slide_by_scipy
from support.texts import shipped

import pinpress as pp
from pinpress.loads import BalanceCylinder, PneumaticCushion

BAR, P0 = 1e5, 101325.0
SPEED = 300 * pp.RPM
STROKE = 0.030  # of the JF75G-125 [m]
CYLINDER = BalanceCylinder(bore=0.12, pressure=6 * BAR, volume=0.010, rod=0.04, count=2)
CUSHION = PneumaticCushion(bore=0.2, pressure=5 * BAR, volume=0.004, height=0.012, exponent=1.2)


def gas(exponent, area, volume, pressure, travel):
    """Force of a gas after a travel of the piston that widens it: p V^n is constant, the air around on the other side."""
    constant = (pressure + P0) * volume**exponent
    return area * (constant / (volume + area * travel) ** exponent - P0)


def test_force_is_that_of_a_polytropic_gas():
    area = 2 * math.pi / 4 * (0.12**2 - 0.04**2)
    assert CYLINDER.area == pytest.approx(area, rel=1e-15)
    heights = np.linspace(-0.001, STROKE, 9)
    (both,) = CYLINDER.intervals(True)
    assert CYLINDER.intervals(False)[0] is both
    assert (both.upper, both.lower) == (math.inf, -math.inf)
    expected = gas(1.4, area, 0.010, 6 * BAR, heights)
    assert both.force(heights, 0.0 * heights) == pytest.approx(expected, rel=1e-14)
    assert [both.force(float(h), 0.1) for h in heights] == pytest.approx(expected, rel=1e-14)
    assert CYLINDER.pressure_at(heights) * area == pytest.approx(expected, rel=1e-14)
    (below,) = CUSHION.intervals(True)
    assert (below.upper, below.lower) == (0.012, -math.inf)
    expected = gas(1.2, CUSHION.area, 0.004, 5 * BAR, heights - 0.012)
    assert below.force(heights, 0.0 * heights) == pytest.approx(expected, rel=1e-14)
    assert CUSHION.pressure_at([0.5, 0.012, 0.0]) == pytest.approx([5 * BAR, 5 * BAR, below.force(0.0, 0.0) / CUSHION.area])


def test_between_isothermal_and_adiabatic():
    """Isothermal p V is constant; a tank without end keeps the force; work of compression is the closed integral of each."""
    area, volume, down = 0.01, 0.002, 0.05
    bore = math.sqrt(4 * area / math.pi)
    isothermal, adiabatic = (BalanceCylinder(bore, 5 * BAR, volume, exponent=n) for n in (1.0, 1.4))
    (soft,), (stiff,) = isothermal.intervals(True), adiabatic.intervals(True)
    left = volume - area * down
    works = [quad(lambda h, law=law: law.force(h, 0.0), -down, 0.0, epsabs=1e-9)[0] + P0 * area * down for law in (soft, stiff)]
    total = 5 * BAR + P0
    closed = [total * volume * math.log(volume / left), total * volume / 0.4 * ((volume / left) ** 0.4 - 1)]
    assert works == pytest.approx(closed, rel=1e-11)
    assert stiff.force(-down, 0.0) > soft.force(-down, 0.0) > soft.force(0.0, 0.0) == pytest.approx(5 * BAR * area)
    (tank,) = BalanceCylinder(bore, 5 * BAR, 49.0).intervals(True)
    assert tank.force(-down, 0.0) == pytest.approx(5 * BAR * area, rel=3e-5)
    # stiffness at the filling height: n (p + p0) A^2 / V
    slope = (stiff.force(-1e-6, 0.0) - stiff.force(1e-6, 0.0)) / 2e-6
    assert slope == pytest.approx(1.4 * total * area**2 / volume, rel=1e-8)


@pytest.mark.parametrize("load", [CYLINDER, CUSHION])
def test_no_work_is_lost_over_a_turn(load):
    press = shipped("jf75g_125")
    motion = pp.cycle(press, SPEED, points=720)
    loaded, idle = (pp.inverse_dynamics(press, motion, loads=given) for given in ([load], []))
    torque = loaded.driving_torque - idle.driving_torque
    smooth = load is CYLINDER  # the trapezium rule over a turn is exact for smooth functions; the cushion begins with a jump
    assert abs(torque.mean()) < (1e-12 if smooth else 2e-3) * np.abs(torque).max()
    assert np.abs(loaded.power_residual).max() < 1e-12
    assert np.abs(loaded.shaking_force - idle.shaking_force).max() < 1e-12 * np.abs(idle.shaking_force).max()  # between slide and frame


@pytest.mark.parametrize("load", [CYLINDER, CUSHION])
def test_runs_keep_their_energy_by_both_methods(load):
    """The crank swings freely: what the air takes it gives back, and both sets of equations agree."""
    press = shipped("jf75g_125")
    given = {"speed": 12.0, "angle": 2.5, "flywheel": pp.drives.Flywheel(20.0), "loads": [load], "points": 101}
    reduced, joints = (pp.simulate(press, 0.7, method=method, **given) for method in ("reduced", "constraint"))
    assert reduced.stats.energy_error < 1e-11
    assert joints.stats.energy_error < 1e-9
    assert np.abs(joints.crank_angle - reduced.crank_angle).max() < 1e-8
    high = reduced.slide_position[0]
    assert high - reduced.slide_position.min() > 0.01
    (law,), zero = load.intervals(True), pp.dead_centres(press).bottom_position
    work = [
        quad(lambda h: law.force(h, 0.0) * (h <= law.upper), z - zero, high - zero, points=[0.012])[0] for z in reduced.slide_position[::20]
    ]
    assert reduced.load_work[::20] == pytest.approx(np.array(work), abs=1e-7 * max(work))


def test_a_press_that_swings_on_air_is_that_of_scipy():
    press = shipped("crank_slide")
    zero = pp.dead_centres(press).bottom_position
    cylinder = BalanceCylinder(bore=0.16, pressure=0.7 * BAR, volume=0.004, height=0.1, exponent=1.3, datum=zero)
    wheel = pp.drives.Flywheel(5.0)
    run = pp.simulate(press, 0.5, angle=1.2, speed=2.0, flywheel=wheel, loads=[cylinder], points=26)
    expected = crank_slide_by_scipy.run(lambda height, _: gas(1.3, cylinder.area, 0.004, 0.7 * BAR, height - 0.1), 1.2, 2.0, 5.0, run.time)
    assert run.crank_angle == pytest.approx(expected[0], abs=1e-6)
    assert run.crank_speed == pytest.approx(expected[1], abs=1e-5)


def test_scenarios_are_runs_one_by_one():
    press = shipped("jf75g_125")
    pressures, volumes = np.array([4e5, 6e5, 8e5]), np.array([0.01, 0.02, 0.03])
    given = {"speed": SPEED, "flywheel": pp.drives.Flywheel(136.0), "points": 11}
    many = pp.simulate_batch(press, 0.3, loads=[BalanceCylinder(0.12, pressures, volumes)], **given)
    for k in range(3):
        one = pp.simulate(press, 0.3, loads=[BalanceCylinder(0.12, float(pressures[k]), float(volumes[k]))], **given)
        assert many[k].crank_angle == pytest.approx(one.crank_angle, abs=1e-10)
    assert BalanceCylinder(0.12, pressures, volumes).pressure_at([0.0, 0.03]).shape == (2, 3)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"pressure": 6.0}, "pressure is 6 Pa: if bar are meant, write 6e5; if MPa, 6e6"),
        ({"bore": 120.0, "volume": 49.0}, "bore is 120 m: if mm are meant, write 120e-3"),
        ({"volume": 80.0}, "volume is 80 m3: if litres are meant, write 80e-3"),
    ],
)
def test_other_units_are_warned_of(given, said):
    for made in (BalanceCylinder, PneumaticCushion):
        with pytest.warns(pp.PinpressWarning, match=said) as caught:
            made(**({"bore": 0.12, "pressure": 6e5, "volume": 0.08} | given), **({"height": 0.01} if made is PneumaticCushion else {}))
        assert {warning.filename for warning in caught} == {__file__}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        BalanceCylinder(0.12, 6e5, 0.08)


def test_ratings_and_dead_centres_know_balance_cylinders():
    """The permissible force just needs the torque capacity, weights, inertia and cylinder with it; at the rigid bottom dead centre the
    deflection is that of the cylinder's force there."""
    press, speed, air = shipped("zxn2_3000b"), 70 * pp.RPM, BalanceCylinder(0.2, 5.5e5, 0.25, count=4)
    rated = pp.ratings.rate(press, speed, pp.ratings.Capacities(3e6, nominal_height=6e-3), loads=[air], at_speed=True, points=36)
    table = rated.columns()
    height, force, angle = (table[next(name for name in table if name.startswith(word))] for word in ("height", "force", "crank_angle"))
    k = int(np.argmin(force))
    assert 0.02 < height[k] < 0.28
    motion = pp.servo_cycle(press, angle=[angle[k]], speed=speed)
    pressed = pp.inverse_dynamics(press, motion, loads=[air, pp.loads.PointForce("slide", (0.0, 0.0, force[k]))])
    assert abs(pressed.driving_torque[0]) == pytest.approx(rated.torque_capacity, rel=1e-9)
    stiffness = pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 4e9))
    lift = pp.loads.PointForce("slide", (0.0, 0.0, air.area * 5.5e5))
    shifts = [pp.elasticity.dead_centre_shift(press, stiffness, speed=speed, loads=[load]).at_rigid_angle for load in (air, lift)]
    assert shifts[0] == pytest.approx(shifts[1], rel=1e-9)
