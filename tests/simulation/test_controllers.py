"""Runs under a function of the state of all motors: a controller that knows the mechanism leaves the error that its gains say."""

import numpy as np
import pytest
from reference.robots.cases import FOLDER
from support import texts

import pinpress as pp

FIVE_BAR = FOLDER / "09_companion_yaml_3d" / "robot.urdf"
WAY, RATE = np.array([0.5, -0.4]), 2 * np.pi  # of both motors [rad, rad/s]
POLE = 40.0  # of the error [1/s]


@pytest.fixture(scope="module")
def arm():
    return pp.load(FIVE_BAR)


def wanted(time):
    """Positions, speeds and accelerations of both motors."""
    return WAY * (1 - np.cos(RATE * time)), WAY * RATE * np.sin(RATE * time), WAY * RATE**2 * np.cos(RATE * time)


def computed_torque(arm):
    def efforts(time, position, speed):
        at, rate, acceleration = wanted(time)
        corrected = acceleration + 2 * POLE * (rate - speed) + POLE**2 * (at - position)
        motion = pp.servo_cycle(arm, [position], speed=[speed], acceleration=[corrected])
        return pp.inverse_dynamics(arm, motion, bearings=()).driving_torque[0]

    return efforts


def test_computed_torque_leaves_the_error_of_a_double_pole(arm):
    """The error decays by (1 + p t) exp(-p t), whatever the mechanism does."""
    start = np.array([0.05, -0.03])
    run = pp.simulate(arm, 0.1, drive=computed_torque(arm), angle=start, tolerance=1e-8, points=16)
    decay = (1 + POLE * run.time) * np.exp(-POLE * run.time)
    followed = np.array([wanted(time)[0] for time in run.time])
    np.testing.assert_allclose(run.crank_angle - followed, np.outer(decay, start), rtol=0, atol=2e-8)
    torque = pp.inverse_dynamics(arm, run).driving_torque
    np.testing.assert_allclose(run.drive_torque, torque, rtol=0, atol=1e-6)
    assert run.stats.energy_error < 1e-7


def test_a_law_of_all_motors_is_that_of_each(arm):
    """Torques that do not depend on the other motor are those of two drives."""

    class Braked(pp.drives.ConstantTorque):
        def torque(self, speed, angle=0.0, time=0.0, state=()):
            return self.value - 0.3 * speed

        heeds_speed = True

    both = pp.simulate(arm, 0.3, drive=lambda time, position, speed: np.array([-1.0, 1.2]) - 0.3 * speed)
    each = pp.simulate(arm, 0.3, drive={"turn_a": Braked(-1.0), "turn_b": Braked(1.2)})
    np.testing.assert_allclose(both.crank_angle, each.crank_angle, rtol=0, atol=1e-9)
    np.testing.assert_allclose(both.drive_torque, each.drive_torque, rtol=0, atol=1e-9)
    np.testing.assert_allclose(both.drive_work, each.drive_work, rtol=0, atol=1e-9)


def test_a_coupled_law_holds_the_motors_together(arm):
    """A stiff spring between both motors, which only a law of both can be."""
    stiff = lambda time, position, speed: np.array([-1.0, -1.0]) * (8000.0 * position.sum() + 80.0 * speed.sum())  # noqa: E731
    run = pp.simulate(arm, 0.5, drive=stiff, tolerance=1e-7)
    assert np.abs(run.crank_angle.sum(axis=1)).max() < 0.001 * np.ptp(run.crank_angle[:, 0])


def test_a_single_motor_takes_a_function_too():
    press = texts.shipped("crank_slide")
    stiffness, damping = 2e4, 1e3
    follow = lambda time, position, speed: stiffness * (7.0 * time - position) + damping * (7.0 - speed)  # noqa: E731
    run = pp.simulate(press, 0.5, drive=follow, speed=7.0)
    np.testing.assert_allclose(
        run.drive_torque, stiffness * (7.0 * run.time - run.crank_angle) + damping * (7.0 - run.crank_speed), atol=1e-6
    )
    assert 0 < np.abs(run.crank_angle - 7.0 * run.time).max() < 0.05


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (lambda time, position, speed: [1.0], r"drive gives efforts of shape \(1,\); give \(2,\), one for each motor"),
        (lambda time, position, speed: 1 / 0, r"drive at time 0 s cannot be worked out: ZeroDivisionError"),
        (lambda time, position, speed: [np.nan, 1.0], r"drive at time 0 s.* is nan; give finite numbers"),
    ],
)
def test_a_law_that_fails_is_refused(arm, law, message):
    with pytest.raises(pp.PinpressError, match=message):
        pp.simulate(arm, 0.1, drive=law)
