"""Screw presses: blows of a flywheel with friction in the thread, friction drives, servo screws, and screws that lock themselves.

Slide and flywheel turn into each other by r = lead/2pi, and the thread by d2/2 tan(g +- rho), so that the slide moves as a mass of
J/(r d2/2 tan(g +- rho)) + m: + where the screw drives the nut, - where the nut drives the screw. Between two changes of that it is a
falling mass or a harmonic oscillator.
"""

import numpy as np
import pytest
from scipy.optimize import brentq
from support.presses import machine_presses

import pinpress as pp

GRAVITY, FLYWHEEL, SLIDE, DIAMETER = 9.81, 25.0, 450.0, 0.3
DIE, STIFFNESS, TOP = -0.7, 2e8, -0.5
RADIUS = machine_presses.LEAD / (2 * np.pi)
METHODS = {"auto": None, "implicit": 1e-10}


def arm(friction, way):
    """Torque of the thread by its force: way 1 where the screw drives the nut, -1 where the nut drives the screw."""
    pitch = np.arctan(RADIUS / (DIAMETER / 2))
    rho = np.arctan(friction / np.cos(np.arctan(np.tan(np.radians(15.0)) * np.cos(pitch))))
    return DIAMETER / 2 * np.tan(pitch + way * rho)


def moving_mass(friction, way):
    """Mass as which the slide moves."""
    return FLYWHEEL / (RADIUS * arm(friction, way)) + SLIDE


def fallen(speed, height, friction):
    """Speed of the slide after it has fallen from a height, its weight driving the screw."""
    return np.sqrt(speed**2 + 2 * GRAVITY * height * SLIDE / moving_mass(friction, -1))


def struck(speed, friction):
    """Depth of a blow on the elastic die at this speed, and the speed at which the slide is back where the die carries its weight."""
    forwards, backwards = moving_mass(friction, 1), moving_mass(friction, -1)
    carried = SLIDE * GRAVITY / STIFFNESS
    there = np.sqrt(speed**2 + (2 * SLIDE * GRAVITY * carried - STIFFNESS * carried**2) / backwards)
    further = there * np.sqrt(forwards / STIFFNESS)
    return carried + further, further * np.sqrt(STIFFNESS / backwards), carried


def energy(run, press):
    """Of flywheel and slide (n,) [J]."""
    turning = 0.5 * (FLYWHEEL + SLIDE * RADIUS**2) * run.crank_speed**2
    return turning + SLIDE * GRAVITY * run.slide_position


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("friction", [0.0, 0.06])
def test_a_blow_on_an_elastic_die(friction, method):
    press = machine_presses.spindle(friction)
    die = pp.loads.ElasticDie(0.0, STIFFNESS, datum=DIE)
    run = pp.simulate(press, 0.2, speed=40.0, loads=[die], points=401, method=method, tolerance=METHODS[method])
    depth, back, carried = struck(fallen(40.0 * RADIUS, TOP - DIE, friction), friction)

    def state(time):
        return run.at_times(np.array([time]))

    first = int(np.argmax(run.crank_speed < 0))
    turned = brentq(lambda time: state(time).crank_speed[0], *run.time[[first - 1, first]], xtol=1e-15)
    assert state(turned).slide_position[0] - DIE == pytest.approx(-depth, rel=1e-9)
    leaves = brentq(lambda time: state(time).slide_position[0] - DIE + carried, turned, turned + 0.025, xtol=1e-15)
    assert RADIUS * state(leaves).crank_speed[0] == pytest.approx(-back, rel=1e-9)
    stored = 0.5 * STIFFNESS * np.minimum(run.slide_position - DIE, 0.0) ** 2
    whole = energy(run, press) + stored + run.lost
    np.testing.assert_allclose(whole, whole[0], rtol=1e-9 if method == "auto" else 1e-7)
    assert (run.lost[-1] > 0) == (friction > 0)


@pytest.mark.parametrize("friction", [0.0, 0.06])
def test_a_blow_that_forms_for_good_takes_the_energy_of_the_flywheel(friction):
    """It rests on the part where its weight does not turn it, and is driven up again."""
    press, force = machine_presses.spindle(friction), 4e5
    part = pp.loads.ForceStroke([0.0, 0.2], [force, force], datum=DIE - 0.2)
    run = pp.simulate(press, 0.25, speed=40.0, loads=[part], points=401)
    speed = fallen(40.0 * RADIUS, TOP - DIE, friction)
    depth = 0.5 * moving_mass(friction, 1) * speed**2 / (force - SLIDE * GRAVITY)
    formed = run.slide_position <= DIE - depth * (1 - 1e-9)
    assert formed.any()
    taken = energy(run, press)[0] - energy(run, press) - run.lost
    np.testing.assert_allclose(taken[formed][0], force * depth, rtol=1e-9)
    np.testing.assert_allclose(run.load_work[formed][0], force * depth, rtol=1e-9)


def test_a_disc_that_slips_on_the_flywheel_drives_it():
    """A friction drive: the disc's wheel turns on, pressed to the flywheel until it is lifted off. What it loses is heat where it slips."""
    press, torque, disc = machine_presses.spindle(0.06), 300.0, pp.drives.Flywheel(60.0, speed=90.0)
    clutch = pp.drives.Clutch(torque, opens=pp.drives.SwitchPoint(time=0.4))
    run = pp.simulate(press, 0.5, speed=0.0, flywheel=disc, clutch=clutch, points=101)
    speed_up = (torque / arm(0.06, -1) + SLIDE * GRAVITY) / moving_mass(0.06, -1)
    assert speed_up < GRAVITY  # the nut hangs, and drives the screw
    held = run.time <= 0.4
    np.testing.assert_allclose(RADIUS * run.crank_speed[held], speed_up * run.time[held], rtol=1e-9, atol=1e-12)
    turned = disc.speed * run.time - 0.5 * torque / disc.inertia * run.time**2  # of the disc
    np.testing.assert_allclose((energy(run, press) - energy(run, press)[0] + run.lost)[held], torque * turned[held], rtol=1e-9, atol=1e-7)


JACK = {"lead": 0.009, "diameter": 0.0555, "friction": 0.12}


@pytest.mark.parametrize(("way", "torque"), [(-1, -491.10473131), (1, 200.193181)])
def test_a_servo_screw_lifts_and_lowers_by_the_torque_of_its_thread(way, torque):
    """100 kN at constant speed, against the formula of the thread. A positive turn of the right-handed screw lowers the nut."""
    press = machine_presses.jack(1e5 / GRAVITY, **JACK)
    run = pp.simulate(press, 0.2, drive=pp.drives.PrescribedSpeed(way * 10.0), points=11)
    np.testing.assert_allclose(run.drive_torque, torque, rtol=1e-8)
    other = pp.servo_cycle(press, run.crank_angle, speed=way * 10.0, acceleration=0.0)
    np.testing.assert_allclose(pp.inverse_dynamics(press, other).driving_torque, torque, rtol=1e-8)


def test_a_servo_screw_presses_and_returns():
    """A position drive on the screw, against a part: its work is that of the part, of the weights, of what moves, and of the thread."""
    press = machine_presses.spindle(0.06)
    motor = pp.drives.ServoMotor((0.0, 0.4, 0.6, 1.0), (0.0, 8.0, 8.0, 1.0), 2e5, 8e3, 1e5)
    part = pp.loads.ForceStroke([0.0, 0.2], [2e5, 2e5], datum=DIE - 0.2)
    run = pp.simulate(press, 1.0, speed=0.0, drive=motor, loads=[part], points=201)
    assert run.slide_position.min() < DIE - 0.04
    assert run.crank_angle[-1] < 2.0
    given = energy(run, press) - energy(run, press)[0] + run.load_work + run.lost
    np.testing.assert_allclose(run.drive_work, given, rtol=1e-9, atol=1e-9 * np.abs(given).max())


@pytest.mark.parametrize("method", METHODS)
def test_a_screw_that_locks_itself_stays_where_it_is(method):
    press = machine_presses.jack(1e3, **JACK)
    assert press.meshes["thread"].self_locking
    still = {"method": method, "tolerance": METHODS[method], "points": 21, "speed": 0.0}
    with pytest.warns(pp.PinpressWarning, match="the friction holds it there"):
        run = pp.simulate(press, 0.5, drive=pp.drives.ConstantTorque(0.5), **still)
    assert not run.crank_speed.any()
    assert pp.simulate(press, 0.5, **still).crank_speed[-1] == 0.0
    die = pp.loads.ElasticDie(0.0, 2e8, datum=-0.51)  # it strikes, and stays wedged
    struck = pp.simulate(press, 1.0, **{**still, "speed": 60.0}, loads=[die])
    assert struck.crank_speed[-1] == 0.0
    assert struck.slide_position[-1] == struck.slide_position.min() < -0.51


def test_a_screw_that_does_not_lock_itself_falls():
    press = machine_presses.spindle(0.06)
    run = pp.simulate(press, 0.5, speed=0.0, points=21)
    falls = SLIDE * GRAVITY / moving_mass(0.06, -1)
    np.testing.assert_allclose(RADIUS * run.crank_speed, falls * run.time, rtol=1e-10, atol=1e-13)


def test_scenarios_strike_as_their_runs():
    press, die = machine_presses.spindle(0.06), pp.loads.ElasticDie(0.0, STIFFNESS, datum=DIE)
    speeds = np.array([40.0, 20.0])
    batch = pp.simulate_batch(press, 0.2, speed=speeds, loads=[die])
    for k, speed in enumerate(speeds):
        run = pp.simulate(press, 0.2, speed=float(speed), loads=[die])
        assert batch.crank_angle[-1, k] == pytest.approx(run.crank_angle[-1], abs=1e-9)
        assert batch.lost[k] == pytest.approx(run.lost[-1], rel=1e-9)
