"""Runs beside an unstable rest: what the start does not determine to the tolerance is said, and only that.

The judge is the textbook crank-slider's equation, written out in `test_simulation_extremes`, integrated by SciPy; its rest at the top is
unstable, with errors that grow as exp(26 t).
"""

import math
import warnings

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support import texts
from support.oracles.textbook_crank_slide import acceleration, inertia, potential

import pinpress as pp

pytestmark = pytest.mark.usefixtures("time_limit")


@pytest.fixture(scope="module")
def press():
    return texts.shipped("crank_slide")


def reference(times, speed, angle):
    def rates(_, y):
        q, w = y.tolist()
        return w, acceleration(q, w, 0.0, 0.0)

    return solve_ivp(rates, (0.0, times[-1]), (angle, speed), "DOP853", times, rtol=3e-14, atol=1e-16).y[0]


def heard(press, duration, **arguments):
    """A run and the messages of its warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = pp.simulate(press, duration, **arguments)
    assert all(issubclass(warning.category, pp.PinpressWarning) for warning in caught)
    assert all(warning.filename == __file__ for warning in caught)
    return run, [str(warning.message) for warning in caught]


def test_a_run_that_is_not_determined_says_so(press, method):
    """1e-9 rad/s at the top: the run is wrong, though its energy is right, and says by how much it may be."""
    run, said = heard(press, 2.5, speed=1e-9, angle=math.pi, method=method)
    assert run.stats.energy_error < 1e-9
    wrong = np.abs(run.crank_angle - reference(run.time, 1e-9, math.pi)).max()
    astray = float(said[0].partition("leads ")[2].partition(" rad")[0])
    assert wrong > 1e-3
    assert astray > 0.3 * wrong
    assert len(said) == 1
    assert "not determined to its tolerance" in said[0]
    assert run.stats.sensitivity > 1e6


@pytest.mark.exhaustive
def test_how_far_astray(press):
    """From 1e-5 rad beside the top, at a tolerance of 1e-8: as far as the equation leads that starts as much farther."""
    run, said = heard(press, 1.2, angle=math.pi + 1e-5, tolerance=1e-8)
    expected = np.abs(np.subtract(*(reference(run.time, 0.0, math.pi + off) for off in (1e-5, 1e-5 + 1e-8)))).max()
    astray = float(said[0].partition("leads ")[2].partition(" rad")[0])
    assert expected > 1e-4
    assert 0.5 * expected < astray < 10 * expected  # a start moved by a speed of 1e-8 x 20 rad/s does as much


CLEAR = {
    "a third of a turn": {"angle": 2.0},
    "over the top": {"angle": math.pi, "speed": 0.5},
    "at rest at the bottom": {},
    "swinging": {"speed": 2.0},
    "with a flywheel": {"speed": 20.0, "flywheel": pp.drives.Flywheel(20.0)},
    "started from the top by a motor": {"angle": math.pi, "drive": pp.drives.ConstantTorque(300.0), "flywheel": pp.drives.Flywheel(20.0)},
    "held at the top by a servo": {
        "angle": math.pi,
        "drive": pp.drives.ServoMotor((0.0, 0.2, 0.4), (math.pi, math.pi, 4.0), 1e4, 1e3, 1e4, inertia=1.0),
    },
    "held at the top by a brake": {"angle": math.pi, "brake": pp.drives.Brake(500.0)},
    "stopped by a brake": {
        "speed": 8.0,
        "flywheel": pp.drives.Flywheel(5.0),
        "brake": pp.drives.Brake(2000.0, pp.drives.SwitchPoint(time=0.05)),
    },
    "on a die": {"speed": 8.0, "flywheel": pp.drives.Flywheel(5.0), "loads": [pp.loads.ElasticDie(0.02, 1e5)]},
}


@pytest.mark.one_in(9)
@pytest.mark.parametrize("name", CLEAR)
def test_runs_that_keep_clear_of_it_are_not_made_again(press, method, name):
    run, said = heard(press, 0.4, method=method, **CLEAR[name])
    assert said == []
    assert run.stats.sensitivity is None


def test_at_rest_on_the_top(press):
    """A definite answer, but an unstable one: it stays."""
    run, said = heard(press, 1.0, angle=math.pi)
    assert np.ptp(run.crank_angle) == 0.0
    assert len(said) == 1
    assert "the press rests at an unstable equilibrium from 0 s on, at crank angle 180 deg" in said[0]


def test_dry_friction_holds_it_on_the_top(press):
    class Friction(pp.drives.SpeedTorqueDrive):
        inertia, rated_torque, corners = 0.0, None, (0.0,)

        def torque(self, speed, angle=0.0, time=0.0, state=()):
            return -50.0 * np.sign(speed)

    run, said = heard(press, 1.0, angle=math.pi, drive=Friction())
    assert np.ptp(run.crank_angle) == 0.0
    assert said == []


@pytest.mark.exhaustive
def test_scenarios_beside_it_are_run_alone(press):
    """One that creeps away from the top, beside one that runs fast."""
    with pytest.warns(pp.PinpressWarning, match="not determined"):
        runs = pp.simulate_batch(press, 0.6, speed=[1e-5, 20.0], angle=math.pi, points=21)
    assert runs.errors == (None, None)
    assert runs.crank_angle[-1, 1] > 2 * math.pi


def test_a_scenario_that_barely_gets_over_the_top(press):
    """Of those that turn: its kinetic energy at the top is 1e-7 of that at the bottom."""
    rise = potential(math.pi) - potential(0.0)
    speed = math.sqrt(2 * rise * (1 + 1e-7) / inertia(0.0))
    with pytest.warns(pp.PinpressWarning, match="not determined"):
        runs = pp.simulate_batch(press, 1.0, speed=[speed, 2.0 + speed], points=21)
    assert runs.crank_angle[-1, 0] > math.pi
