"""The N-four-bar benchmark (see `n_four_bar`), from URDF through the public API: 10 s, through ten poses in which it is singular."""

import numpy as np
import pytest
from numpy.polynomial.chebyshev import chebvander
from scipy.integrate import solve_ivp
from support import texts
from support.oracles import n_four_bar

import pinpress as pp
from pinpress.engines.change_points import INNER, PLACES, _fitted
from pinpress.kinematics.cycle import motion_through_change_points

# Of the state after 10 s, relative to its angle. `reduced` is at rounding that the falls make grow; of `constraint` every step may be off
# by 1e-11.
BOUNDS = {"reduced": 1e-11, "constraint": 1e-9}

# Loops of 4 m are closed to 8 eps of that; beside singular poses to five times as much, see `test_closed_at_singular_poses` [m].
ROUNDING = 5 * 8 * float(np.finfo(float).eps) * 4.0


def loaded(count):
    return texts.load(n_four_bar.urdf(count))


@pytest.fixture(scope="module")
def double():
    return loaded(2)


def exact(count, times):
    """Angle and speed by SciPy, from the exact equation."""
    factor = n_four_bar.moment(count) * n_four_bar.GRAVITY / n_four_bar.inertia(count)
    solved = solve_ivp(
        lambda _, y: (y[1], factor * np.sin(y[0])), (0, times[-1]), (0.0, 1.0), "DOP853", times, rtol=1e-13, atol=1e-13, max_step=0.05
    )
    return solved.y


@pytest.mark.parametrize("method", BOUNDS)
@pytest.mark.parametrize("count", [1, 2])
def test_ten_seconds(count, method):
    run = pp.simulate(loaded(count), 10.0, speed=n_four_bar.SPEED, points=11, method=method)
    for second, (angle, speed) in n_four_bar.EXACT[count].items():
        assert abs(run.crank_angle[second] / angle - 1) < BOUNDS[method]
        assert abs(run.crank_speed[second] - speed) < BOUNDS[method] * 10 * 7  # of 10 s at up to 7 rad/s
    assert run.stats.energy_error < 1e-9
    assert run.stats.closure_error < ROUNDING


@pytest.mark.parametrize("count", [1, 2, 5])
def test_closed_at_singular_poses(count):
    """Beside a pose with all rods in one line the loops do not say where the rods are: joints come from polynomials through poses on both
    sides of it, and rounding of those grows as the polynomials reach into the gap. The exact angles are those of a parallelogram."""
    press = loaded(count)
    lebesgue = (
        np.abs(_fitted(PLACES, np.eye(len(PLACES))).T @ chebvander(np.linspace(-INNER, INNER, 101), len(PLACES) - 1).T).sum(axis=0).max()
    )
    for point in press.branch_through_change_points.change_points:
        angles = point.angle + point.inner * np.linspace(-0.999, 0.999, 101)
        motion = motion_through_change_points(press, angles, 1.0)
        off = np.abs(np.abs(motion.joint_position) - angles[:, None]).max()
        assert off <= lebesgue * 0.5 * np.spacing(angles.max())
        assert motion.closure_error.max() < ROUNDING


@pytest.mark.exhaustive
@pytest.mark.parametrize(("count", "method", "duration"), [(40, "reduced", 10.0), (12, "constraint", 3.0)])
def test_many_windows(count, method, duration):
    """40 windows, as the benchmark was first written: 81 joints, 40 loops that all lose their rank at once."""
    run = pp.simulate(loaded(count), duration, speed=n_four_bar.SPEED, points=61, method=method)
    angle, speed = exact(count, run.time)
    np.testing.assert_allclose(run.crank_angle, angle, rtol=0, atol=1e-8)  # SciPy's own error over 10 s, falls of 1e-12 grow by 1e3
    np.testing.assert_allclose(run.crank_speed, speed, rtol=0, atol=1e-8)
    assert run.stats.energy_error < 1e-9
    assert run.stats.closure_error < 1e-14


def test_the_tables_are_the_equations():
    """The reference itself, by SciPy, and against the published positions."""
    for count, table in n_four_bar.EXACT.items():
        angle, speed = exact(count, np.arange(11.0))
        for second, (expected, rate) in table.items():
            assert abs(angle[second] - expected) < 1e-9
            assert abs(speed[second] - rate) < 1e-9
    assert abs(np.sin(n_four_bar.EXACT[2][10][0]) - n_four_bar.EXTRAPOLATED) < 2e-8  # the extrapolation's own error


@pytest.mark.exhaustive
@pytest.mark.parametrize("method", BOUNDS)
def test_it_stays_a_parallelogram(double, method):
    """At all times, those at which it is singular and those beside them among them: all rods upright alike, the others level."""
    run = pp.simulate(double, 8.0, speed=n_four_bar.SPEED, points=4001, method=method)
    upright = run.joint_position[:, [run.joints.index(f"A{k}") for k in range(3)]]
    level = run.joint_position[:, [run.joints.index(f"B{k}") for k in range(2)]]
    np.testing.assert_allclose(upright, upright[:, :1] * np.ones(3), atol=1e-12)
    np.testing.assert_allclose(level, -upright[:, :2], atol=1e-12)
    for name, rate in (("v", run.crank_speed), ("a", run.crank_acceleration)):
        values = getattr(run, name)[:, [run.joints.index(f"A{k}") for k in range(3)]]
        np.testing.assert_allclose(values, rate[:, None] * np.ones(3), atol=1e-9 * np.abs(rate).max())
    passed = np.interp(n_four_bar.IN_LINE, run.time, run.crank_angle)
    np.testing.assert_allclose(np.cos(passed), 0.0, atol=1e-5)  # of the interpolation


def test_forces_beside_the_singular_poses(double):
    """Newton's second law of the whole, to rounding of forces that grow as 1 / distance and cancel; the power balance too."""
    run = pp.simulate(double, 1.0, speed=n_four_bar.SPEED, points=501)
    result = pp.inverse_dynamics(double, run)
    angle, speed, acceleration = run.crank_angle, run.crank_speed, run.crank_acceleration
    lever = n_four_bar.moment(2)
    along = lever * (acceleration * np.cos(angle) - speed**2 * np.sin(angle))
    upwards = lever * (-acceleration * np.sin(angle) - speed**2 * np.cos(angle)) + 5 * n_four_bar.GRAVITY
    largest = max(np.abs(force).max() for force in result.bearing_force.values())
    np.testing.assert_allclose(-result.shaking_force[:, 0], along, atol=1e-11 * largest)
    np.testing.assert_allclose(-result.shaking_force[:, 2], upwards, atol=1e-11 * largest)
    assert np.abs(result.driving_torque).max() < 1e-9 * largest
    assert np.abs(result.power_residual).max() < 1e-12
