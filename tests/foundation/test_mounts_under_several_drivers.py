"""A frame on its mounts under a press with two motors: beside the same press with gears in their place, and beside steps over time."""

import numpy as np
import pytest
from support.generators.frames import uneven
from support.generators.period_presses import five_bar, of_two_motors

import pinpress as pp
from pinpress import foundation

SPEED, STATES = 12.0, 720
PERIOD = 4 * np.pi / SPEED  # the right crank, half as fast, is back after two turns of the left one
POINTS = {"top": (0.3, 0.2, 1.5)}


@pytest.fixture(scope="module")
def geared():
    """The press with gears on its mounts, and its forces over a period."""
    press = five_bar(0.5)
    return foundation.mounted(press, *uneven()), pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=STATES))


@pytest.fixture(scope="module")
def motors():
    """The same motion by two motors."""
    press, time = of_two_motors(), PERIOD * np.arange(STATES) / STATES
    speed = np.array([SPEED, 0.5 * SPEED])
    motion = pp.servo_cycle(press, np.outer(time, speed), time=time, period=PERIOD)
    return foundation.mounted(press, *uneven(), motion=motion), pp.inverse_dynamics(press, motion)


@pytest.mark.exhaustive
def test_two_motors_shake_the_frame_as_their_gears_do(geared, motors):
    np.testing.assert_allclose(motors[0].mass, geared[0].mass, rtol=0, atol=1e-6)  # over 180 and over 720 states
    one = foundation.steady_response(*geared, points=POINTS)
    two = foundation.steady_response(*motors, points=POINTS, period=PERIOD)
    assert two.period == pytest.approx(one.period, rel=1e-14)
    for name in ("floor_force", "floor_moment", "shaking_force"):
        expected = getattr(one, name)
        np.testing.assert_allclose(getattr(two, name), expected, rtol=0, atol=1e-6 * np.abs(expected).max())
    lifted = foundation.lifting_response(*motors, points=POINTS, period=PERIOD, strokes=2)
    again = foundation.lifting_response(*geared, points=POINTS, strokes=2)
    np.testing.assert_allclose(lifted.motion.floor_force, again.motion.floor_force, rtol=0, atol=1e-6 * np.abs(one.floor_force).max())


@pytest.mark.exhaustive
def test_a_servo_motion_settles_into_its_steady_response():
    """Of one driver, whose speed changes: steps over many periods from rest end in it, by 1 / STATES^2."""
    press = of_two_motors()
    time = 0.5 * np.arange(40 * 360 + 1) / 360
    turned = 4 * np.pi * time
    angles = np.column_stack([turned + 0.3 * np.sin(turned), turned])
    motion = pp.servo_cycle(press, angles, time=time)
    frame, mounts = uneven()
    stiff = [foundation.Mount(m.point, m.stiffness, tuple(8 * np.array(m.damping))) for m in mounts]
    once = pp.servo_cycle(press, angles[:360], time=time[:360], period=0.5)
    system = foundation.mounted(press, frame, stiff, motion=once)
    marched = foundation.time_response(system, pp.inverse_dynamics(press, motion), points=POINTS)
    steady = foundation.steady_response(system, pp.inverse_dynamics(press, once), points=POINTS, period=0.5)
    expected = steady.displacement["top"]
    np.testing.assert_allclose(marched.displacement["top"][-361:-1], expected, rtol=0, atol=1e-3 * np.abs(expected).max())


def test_flywheels_of_two_motors_turn_the_frame_back(motors):
    press, time = of_two_motors(), np.linspace(0.0, 1.0, 201)
    angles = np.column_stack([0.2 * time**2, -0.3 * time**2])
    motion = pp.servo_cycle(press, angles, time=time)
    wheels = {"O": pp.drives.Flywheel(5.0), "P": pp.drives.Flywheel(7.0)}
    moment = foundation.flywheel_moment(press, motion, wheels)
    np.testing.assert_allclose(moment[20:-20], np.tile([0.0, 5.0 * 0.4 - 7.0 * 0.6, 0.0], (161, 1)), atol=1e-6)  # axes (0, -1, 0)
    reactions = pp.inverse_dynamics(press, motion)
    system = motors[0]
    with_wheels = foundation.time_response(system, reactions, points=POINTS, flywheel=wheels)
    without = foundation.time_response(system, reactions, points=POINTS)
    assert np.abs(with_wheels.floor_moment - without.floor_moment).max() > 0.1
