"""What the solvers over angle and time do for accuracy, each for itself: a run as a whole would hide its lack behind smaller steps."""

import math
import string
from typing import Any

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.kinematics.cycle import motion_through_change_points
from pinpress.simulation import failures
from pinpress.simulation.driven_press import driven_press
from pinpress.simulation.over_angle import angle_solver, collocation, refinement
from pinpress.simulation.over_angle.mesh import build_mesh, mesh_borders
from pinpress.simulation.over_time import time_solver
from pinpress.simulation.over_time.equations_of_motion import ReducedDynamics
from pinpress.simulation.over_time.hybrid_system import HybridSystem
from pinpress.simulation.reduced_model import energies

MOTOR = pp.drives.Geared(pp.drives.InverterMotor(200.0, 1450 * pp.RPM, 45.0, inertia=0.1), 20.0)
"""Its torque reaches its limit at a speed of the crank of about 6.6 rad/s."""


@pytest.fixture(scope="module")
def press():
    return texts.shipped("crank_slide")


def solved(driven, speed, borders=None):
    """A period over the angle from crank angle 0 on."""
    borders = mesh_borders(driven, 0.0, 1, driven.model.period) if borders is None else borders
    mesh = build_mesh(driven, 0.0, 1, borders)
    return collocation.solve(driven, mesh, 0.5 * (mesh.inertia_ends[:1] + driven.inertia) * speed**2)


def test_weights_put_in_the_difference_of_their_potential_energy(press):
    """And not the integral of their force, which on panels this wide is far off: energy is lost in no turn."""
    solution = solved(driven_press(press, None, pp.drives.Flywheel(5.0), [], None, None), 8.0, np.array([0.0, 2.0, 2 * np.pi]))
    angles = np.append(0.0, solution.mesh.angle)
    potential = energies(press, motion_through_change_points(press, angles, 1.0))[1]
    gained = solution.energy.ravel() - solution.ends[0, 0]
    np.testing.assert_allclose(gained, potential[0] - potential[1:], atol=1e-10 * np.ptp(potential))
    assert solution.ends[-1, 0] == pytest.approx(solution.ends[0, 0], rel=1e-15)


def test_a_panel_is_cut_where_the_crank_passes_a_corner_of_the_torque(press):
    """Though its polynomials may resolve speed and time to the tolerance as they are."""
    driven = driven_press(press, MOTOR, pp.drives.Flywheel(50.0), [], None, None)
    corner = min(driven.corners)
    solution = solved(driven, 0.9 * corner)
    assert solution.speed.min() < corner < solution.speed.max()
    count = len(solution.mesh.kinds)
    assert not len(refinement.cuts(solution, count, 1.0))
    passed = refinement.cuts(solution, count, 1.0, driven.drive)
    assert len(passed)
    along = solution.mesh.angle.T.ravel()
    np.testing.assert_allclose(np.interp(passed, along, solution.speed[:, :, 0].T.ravel()), corner, rtol=1e-3)


def test_the_rounding_of_a_motors_slope_does_not_enter_the_solution(press):
    """K is a difference of torques that nearly cancel. Where its last digits moved the energy from node to node, panels would be cut in
    vain: a solution found again from itself has the same force to rounding."""
    motor = pp.drives.Geared(pp.drives.InductionMotor(2e3, 1485 * pp.RPM), 20.0)
    driven = driven_press(press, motor, pp.drives.Flywheel(500.0), [], None, None)
    first = solved(driven, 7.6)
    again = collocation.solve(driven, first.mesh, first.ends[0], first.energy)
    beside = collocation.solve(driven, first.mesh, first.ends[0], nearby=solved(driven, 7.601))
    for other in (again, beside):
        np.testing.assert_allclose(other.force, first.force, rtol=0, atol=2e-13 * np.abs(first.force).max())


@pytest.mark.exhaustive
def test_each_tolerance_holds_and_looser_ones_take_fewer_panels(press):
    """Against a run of all joints over time, which knows no table."""
    motor = pp.drives.Geared(pp.drives.InverterMotor(200.0, 1450 * pp.RPM, 45.0, inertia=0.1), 20.0)
    loads = [pp.loads.Blanking(1e3, 0.03, 0.01)]
    how: dict[str, Any] = {"speed": 6.0, "drive": motor, "flywheel": pp.drives.Flywheel(50.0), "loads": loads, "points": 50}
    judge = pp.simulate(press, 1.1, tolerance=1e-10, method="constraint", **how)
    steps = []
    for tolerance in (1e-2, 1e-4, 1e-6, 1e-8, 1e-11):
        run = pp.simulate(press, 1.1, tolerance=tolerance, **how)
        assert np.abs(run.crank_angle - judge.crank_angle).max() < 0.5 * tolerance + 1e-9
        assert np.abs(run.slide_position - judge.slide_position).max() < 0.5 * tolerance + 1e-9
        steps.append(run.stats.steps)
    assert steps == sorted(steps)
    assert steps[0] < 0.8 * steps[-1]


@pytest.mark.parametrize("loads", [[], [pp.loads.Blanking(1e3, 0.03, 0.01)]])
def test_several_periods_at_once_are_those_one_by_one(press, loads, monkeypatch):
    """Backwards too, and with fewer periods than were solved together at the end."""
    how: dict[str, Any] = {"angle": 1.0, "speed": -9.0, "flywheel": pp.drives.Flywheel(20.0), "loads": loads, "points": 300}
    together = pp.simulate(press, 9.0, **how)
    assert len(together.trajectory.segments) == 2
    monkeypatch.setattr(angle_solver, "AT_ONCE", 1)
    alone = pp.simulate(press, 9.0, **how)
    assert len(alone.trajectory.segments) == math.ceil(alone.trajectory.turns) < 14
    np.testing.assert_allclose(together.crank_angle, alone.crank_angle, rtol=0, atol=1e-11)
    np.testing.assert_allclose(together.load_work, alone.load_work, rtol=1e-11, atol=1e-11)
    assert together.stats.energy_error < 1e-12


@pytest.mark.parametrize("method", [time_solver.EXPLICIT, time_solver.IMPLICIT])
def test_a_step_over_time_ends_at_a_corner_of_the_torque(press, method):
    """It is not one that ran over the corner, cut off there."""
    driven = driven_press(press, MOTOR, pp.drives.Flywheel(5.0), [], None, None)
    system = HybridSystem(ReducedDynamics(driven.model), driven)
    mode, y = system.begin(0.0, np.zeros(1), np.array([3.0]), np.zeros(4))
    settings = time_solver.Settings(1e-9, np.array([1.0, 10.0, 1e3, 1e3, np.inf, 1e3]), method=method)
    segment, _ = time_solver.integrate(system, mode, 0.0, y, 1.0, settings)
    passed = [k for k in range(1, len(segment.modes)) if segment.modes[k].sides != segment.modes[k - 1].sides]
    assert passed
    for k in passed:
        assert min(abs(segment.speeds[k] - corner) for corner in driven.corners) < 1e-6
        step: Any = segment.pieces[k - 1]
        assert step.t == segment.times[k - 1]


@pytest.mark.parametrize("reason", failures.REASONS)
def test_every_failure_says_which_it_is(reason):
    fields = [name for _, name, _, _ in string.Formatter().parse(failures.REASONS[reason]) if name]
    error = failures.failure(reason, 0.5, 1.0, **dict.fromkeys(fields, 7.0))
    assert error.reason == reason
    assert "time 0.5 s" in str(error)
