"""A press that loads hold at rest, while a drive in time goes on: it stands until the drive overcomes them, and starts again.

The reference is the textbook crank-slider's equation, written out in `test_simulation_extremes`, from stop to stop: between these it is
integrated by SciPy, and while it stands the time at which it starts is that at which the torque equals what holds it.
"""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from support import texts
from support.generators import random_scenes
from support.oracles.textbook_crank_slide import acceleration, lever, potential, slope

import pinpress as pp
from pinpress.loads.process import ForceInterval
from pinpress.simulation.reduced_model import INERTIA, WEIGHT

pytestmark = pytest.mark.usefixtures("time_limit")

FRICTION, FLYWHEEL, ANGLE = 500.0, 20.0, 1.0


@pytest.fixture(scope="module")
def press():
    return texts.shipped("crank_slide")


class Guide:
    """Dry friction of the slide, whichever way it goes."""

    datum = None

    def intervals(self, downwards):
        return (ForceInterval(math.inf, -math.inf, lambda h, v: (FRICTION if downwards else -FRICTION) + 0.0 * h),)


class Rocking(pp.drives.SpeedTorqueDrive):
    """A torque in time about the one that balances the weights."""

    inertia, rated_torque, timed = 0.0, None, True

    def torque(self, speed, angle=0.0, time=0.0, state=()):
        return slope(potential, ANGLE) + 120.0 * math.sin(4.0 * time)


def reference(times):
    """Angles and speeds (n,), and the times at which it starts and stops."""
    torque, q, t, found, events = Rocking().torque, ANGLE, 0.0, [], []
    while t < times[-1]:
        excess = lambda at, q=q: torque(0.0, 0.0, at) - slope(potential, q)  # noqa: E731
        holds = FRICTION * abs(lever(q))
        fine = np.linspace(t, times[-1], 20001)
        over = np.flatnonzero(np.abs([excess(at) for at in fine]) > holds * (1 + 1e-9))
        if not len(over):
            found.append((t, times[-1], lambda at, q=q: (q + 0.0 * at, 0.0 * at)))
            break
        k = int(over[0])
        start = t if k == 0 else brentq(lambda at: abs(excess(at)) - holds, fine[k - 1], fine[k], xtol=1e-15)  # noqa: B023
        way = math.copysign(1.0, excess(fine[k]))

        def rates(t, y, way=way):
            push = -way * FRICTION * abs(lever(y[0], math))
            return y[1], acceleration(y[0], y[1], torque(0.0, 0.0, t) + push, FLYWHEEL)

        def stopped(t, y, way=way, start=start):
            return way * y[1] if t > start + 1e-3 else 1.0

        stops: Any = stopped
        stops.terminal, stops.direction = True, -1
        solved = solve_ivp(
            rates, (start, times[-1]), [q, 0.0], method="DOP853", rtol=1e-12, atol=1e-13, events=stops, dense_output=True, max_step=0.01
        )
        found += [(t, start, lambda at, q=q: (q + 0.0 * at, 0.0 * at)), (start, solved.t[-1], solved.sol)]
        t, q = float(solved.t[-1]), float(solved.y[0, -1])
        events += [start, t]
    angle, speed = np.empty(len(times)), np.empty(len(times))
    for low, high, state in found:
        mine = (times >= low) & (times <= high)
        angle[mine], speed[mine] = state(times[mine])
    return angle, speed, events


@pytest.fixture(scope="module")
def known():
    """Times, and what the reference has there."""
    times = np.linspace(0.0, 2.0, 401)
    return times, *reference(times)


@pytest.mark.exhaustive
def test_stick_and_slip(press, method, known):
    run = pp.simulate(
        press, 2.0, angle=ANGLE, drive=Rocking(), flywheel=pp.drives.Flywheel(FLYWHEEL), loads=[Guide()], points=401, method=method
    )
    time, angle, speed, events = known
    np.testing.assert_allclose(run.time, time, rtol=0, atol=1e-15)
    assert len(events) > 4  # it starts and stops several times, both ways
    assert speed.min() < 0 < speed.max()
    assert (speed == 0.0).sum() > 20
    np.testing.assert_allclose(run.crank_angle, angle, rtol=0, atol=1e-7)
    np.testing.assert_allclose(run.crank_speed, speed, rtol=0, atol=1e-6)
    np.testing.assert_array_equal(run.crank_speed[(speed == 0.0) & (run.time > 0.0)], 0.0)


@pytest.fixture(scope="module")
def knuckle():
    return pp.load(TOUR)


TOUR = Path(__file__).parents[2] / "docs" / "tour" / "knuckle.urdf"
HEIGHTS, FORCES = [0.0, 0.002, 0.004], [1.2e6, 4e5, 0.0]


@pytest.mark.filterwarnings("ignore:the slide turns down again")
def test_a_servo_press_that_dwells_on_its_work(knuckle, method):
    """The program turns back beside bottom dead centre; the table holds the slide on its way down until the servo overcomes it."""
    aim = pp.dead_centres(knuckle).bottom_angle - 0.2
    servo = pp.drives.ServoMotor((0.0, 0.6, 2.2, 2.8), (0.0, aim, aim, 2 * np.pi), 1e5, 5e3, 2e5, inertia=50.0)
    coining = pp.loads.ForceStroke(HEIGHTS, FORCES)
    run = pp.simulate(knuckle, 1.1, drive=servo, flywheel=pp.drives.Flywheel(10.0), loads=[coining], points=551, method=method)
    still = np.flatnonzero((run.crank_speed == 0.0) & (run.time > 0.1))
    assert len(still) > 20
    assert run.stats.energy_error < 1e-9
    assert run.crank_angle[-1] < run.crank_angle[still[0]] - 0.1  # on its way back
    # what the table holds lies between nothing, as on the way up, and its force on the way down: it starts as that is reached
    at = run.crank_angle[still]
    lever = pp.servo_cycle(knuckle, angle=at, speed=np.ones(len(still))).slide_velocity
    weight = pp.inverse_dynamics(knuckle, pp.servo_cycle(knuckle, angle=at, speed=np.zeros(len(still)))).driving_torque
    held = (weight - run.drive_torque[still]) / lever
    largest = np.interp(run.slide_position[still] - pp.dead_centres(knuckle).bottom_position, HEIGHTS, FORCES)
    assert np.all((held > -1e-3) & (held < largest + 1e-3))
    assert np.all(np.diff(held) > 0)
    assert held[-1] > 0.9 * largest[-1]


def test_a_press_that_stands_to_the_end_says_so(press, method):
    servo = pp.drives.ServoMotor([-0.2, 1.0], [2.0, 9.0], 1e4, 1e2, 5e3, inertia=2.0)
    with pytest.warns(pp.PinpressWarning, match=r"the press stands from 0\.\d+ s to the end, at crank angle .* deg"):
        run = pp.simulate(
            press,
            1.0,
            speed=5.0,
            angle=3.0,
            drive=servo,
            flywheel=pp.drives.Flywheel(5.0),
            loads=[pp.loads.Blanking(1e6, 0.05, 0.02)],
            method=method,
        )
    assert run.crank_speed[-1] == 0.0
    assert np.ptp(run.crank_angle[run.time > 0.9]) == 0.0


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@pytest.mark.parametrize("seed", [516, 558, 656, 728, 776, 826])
@pytest.mark.parametrize("method", ["auto", "implicit"])
def test_rounding_does_not_choose_the_torque_behind_lossy_gears_at_a_start_from_rest(seed, method):
    """The torque of the drive jumps at rest. In every state it is what the law of motion needs for the acceleration."""
    scene = random_scenes.scene(seed)
    run = pp.simulate(scene.press, scene.duration, points=61, method=method, **scene.given)
    driven = run.problem.driven
    assert not driven.forces
    values, slopes = driven.model.at(run.crank_angle)
    gained = run.a[:, scene.press.driver_indices[0]]
    needed = (values[INERTIA] + driven.inertia) * gained + 0.5 * slopes[INERTIA] * run.crank_speed**2 + values[WEIGHT]
    np.testing.assert_allclose(run.drive_torque, needed, rtol=0, atol=1e-8 * np.abs(needed).max())
