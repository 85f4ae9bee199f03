"""What the solvers over angle and time do for accuracy, each for itself: a run as a whole would hide its lack behind smaller steps."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.kinematics.cycle import motion_through_change_points
from pinpress.simulation.batch import BatchSolver
from pinpress.simulation.driven_press import driven_press
from pinpress.simulation.over_angle import angle_solver, collocation, refinement
from pinpress.simulation.over_angle.mesh import build_mesh, mesh_borders
from pinpress.simulation.over_angle.segment import angle_segment
from pinpress.simulation.over_time import time_solver
from pinpress.simulation.over_time.equations_of_motion import ReducedDynamics
from pinpress.simulation.over_time.events import CoordinateTurns, CrankStops, EventFinder
from pinpress.simulation.over_time.hybrid_system import HybridSystem
from pinpress.simulation.reduced_model import energies
from pinpress.simulation.trajectory import INTEGRALS, State

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


def test_the_works_of_drive_and_loads_are_those_at_the_speeds_found(press):
    """Not those of the torques from which these were found: the energy balance would hold of whatever speeds come of a wrong one."""
    driven = driven_press(press, MOTOR, pp.drives.Flywheel(5.0), [pp.loads.ElasticDie(0.05, 1e4, 1e3)], None, None)
    solution = solved(driven, 5.0)
    wrong = dataclasses.replace(solution, driving=1.1 * solution.driving, resisting=1.1 * solution.resisting)
    start, count = State(0.0, 0.0, 5.0, np.zeros(len(INTEGRALS))), len(solution.mesh.kinds)
    right, asked_again = (angle_segment(driven, one, count, start).last().integrals[:2] for one in (solution, wrong))
    np.testing.assert_array_equal(right, asked_again)
    assert right.all()
    alone = BatchSolver(driven, 0.0, np.array([5.0]), np.array([0.0, 1.0]))
    for (_, torque), (_, same) in zip(*(alone.drive_and_loads(one) for one in (solution, wrong)), strict=True):
        np.testing.assert_array_equal(torque, same)


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


@pytest.mark.filterwarnings("ignore:.*it begins with a jump")
def test_the_stop_of_the_crank_comes_before_all_else_that_happens_at_rest(press):
    """Where a brake brings it to rest a load of one direction turns too, and the motor's gears start to lose the other way."""
    motor = pp.drives.Geared(pp.drives.ConstantTorque(0.1), 20.0, efficiency=0.9)
    load = pp.loads.Blanking(1e2, 0.3, 0.01, stripping=1e1)
    driven = driven_press(press, motor, pp.drives.Flywheel(5.0), [load], None, pp.drives.Brake(500.0))
    system = HybridSystem(ReducedDynamics(driven.model), driven)
    mode, y = system.begin(0.0, np.ones(1), np.array([2.0]), np.zeros(4))
    finder = EventFinder(system, mode, 0.0, y)
    assert {CoordinateTurns, CrankStops} <= set(map(type, finder.events))
    assert not isinstance(finder.events[0], CrankStops)
    slowing = np.array([0.0, -20.0, 0.0, 0.0, 0.0, 0.0])  # at rest after 0.1 s
    event, when = finder.first(lambda t: y + t * slowing, 0.0, 0.2)
    assert isinstance(event, CrankStops)
    assert when == pytest.approx(0.1, rel=1e-12)


PERIODIC = {"motor": (True, False), "stiff motor": (False, True), "damper": (True, False), "friction": (False, True)}


def newton_case(press, name):
    """A press near the speed at which a stroke repeats itself, on panels that resolve it."""
    power, inertia, loads, friction = {
        "motor": (2e3, 500.0, [pp.loads.Blanking(2e3, 0.03, 0.01)], {}),
        "stiff motor": (1e6, 500.0, [], {}),
        "damper": (2e3, 50.0, [pp.loads.ElasticDie(0.05, 1e4, 1e3)], {}),
        "friction": (2e3, 50.0, [pp.loads.ConstantForce(300.0, 0.05)], {"P": pp.loads.Friction(0.05, 0.02)}),
    }[name]
    drive = pp.drives.Geared(pp.drives.InductionMotor(power, 1485 * pp.RPM), 20.0)
    driven = driven_press(press, drive, pp.drives.Flywheel(inertia), loads, None, None, friction)
    borders = mesh_borders(driven, 0.3, 1, driven.model.period)
    return driven, build_mesh(driven, 0.3, 1, np.sort(np.concatenate([borders, borders[1:] - 0.5 * np.diff(borders)])))


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("name", "periodic"),
    [(name, way) for name, ways in PERIODIC.items() for way in ways],
)
def test_each_round_of_newtons_method_squares_the_error(press, name, periodic, monkeypatch):
    """Else it would get there too, later. Many at once are what one is; work and forces are those of the speeds found; and a disturbance
    grows as two solutions tell."""
    driven, mesh = newton_case(press, name)
    start = 0.5 * (mesh.inertia_ends[0] + driven.inertia) * (7.8 + 0.01 * np.cos(np.arange(70))) ** 2
    alone = collocation.solve(driven, mesh, start[:1], periodic=periodic)
    weights = 0.5 * np.polynomial.legendre.leggauss(len(mesh.angle))[1][:, None] * np.diff(mesh.borders)
    for count in (1, 8, 70):
        solution = collocation.solve(driven, mesh, start[:count], periodic=periodic)
        assert 3 * solution.energy.size <= solution.evaluations <= 12 * solution.energy.size  # in six rounds for forces and slopes
        assert solution.stiffness.any() == (name == "stiff motor")
        assert (solution.settled == len(mesh.kinds)).all()
        np.testing.assert_allclose(solution.energy[:, :, 0], alone.energy[:, :, 0], rtol=1e-12)
        # work and forces
        np.testing.assert_allclose(np.diff(solution.ends, axis=0), np.einsum("qp,qps->ps", weights, solution.force), atol=1e-10 * start[0])
        wanted = solution.ends[-1] if periodic else start[:count]
        np.testing.assert_allclose(solution.ends[0], wanted, rtol=1e-12)
        friction_torque = 0.0 if solution.friction_torque is None else solution.friction_torque
        assert (solution.friction_torque is not None) == (name == "friction")
        rest = solution.resisting + friction_torque + mesh.weight[:, :, None]
        scale = np.abs(solution.force).max()
        np.testing.assert_allclose(solution.driving + rest, solution.force, rtol=0, atol=1e-12 * scale)
        np.testing.assert_allclose(solution.driving, driven.drive.torque(solution.speed), rtol=0, atol=1e-9 * scale)
        kinetic = 0.5 * (mesh.inertia[:, :, None] + driven.inertia) * solution.speed**2
        np.testing.assert_allclose(kinetic, solution.energy, rtol=1e-12)
        # how a disturbance grows
        others = {share: collocation.solve(driven, mesh, solution.ends[0] * (1 + share)) for share in (-1e-3, 1e-4)}
        if periodic and name == "motor":
            few = others[1e-4].ends - solution.ends
            np.testing.assert_allclose(np.exp(solution.exponent), few[-1] / few[0], rtol=2e-3)
        if name != "stiff motor":
            for share, other in others.items():
                about = solution.start_with(other.ends[0])
                assert np.abs(about - other.energy).max() < 1e-2 * abs(share) * start[0]
        with monkeypatch.context() as context:
            context.setattr(collocation, "SETTLED", np.inf)  # one round
            first, second = (
                np.abs(collocation.solve(driven, mesh, solution.ends[0], guess, periodic=periodic).energy / solution.energy - 1).max()
                for guess in (solution.energy * (1 + share * np.sin(mesh.angle)[:, :, None]) for share in (1e-3, 1e-4))
            )
        assert second < first / 60 + 1e-10
        assert first < 1e-1 * 1e-3


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("count", [1, 70])
def test_where_no_force_depends_on_speed_one_integral_is_exact(press, count, way):
    """The work of torque and load, less the potential energy gained, at each node; computed once at each."""
    torque, force, start = np.linspace(150.0, 90.0, count), np.linspace(2e3, 4e3, count), np.linspace(1000.0, 1500.0, count)
    drive, loads = pp.drives.ConstantTorque(way * torque), [pp.loads.ConstantForce(force, 0.05)]
    driven = driven_press(press, drive, pp.drives.Flywheel(50.0), loads, None, None)
    mesh = build_mesh(driven, 0.3, way, mesh_borders(driven, 0.3, way, driven.model.period))
    solution = collocation.solve(driven, mesh, start)
    motion = motion_through_change_points(press, np.append(0.3, mesh.angle), 1.0)
    kinetic, potential = energies(press, motion)  # at 1 rad/s
    pushed = np.minimum(motion.slide_position + 0.5, 0.05)  # the load has lifted the slide so far
    gained, pushed = ((values[1:] - values[0]).reshape(*mesh.angle.shape, 1) for values in (potential, pushed))
    travelled = way * (mesh.angle - 0.3)[:, :, None]
    np.testing.assert_allclose(solution.energy, start + torque * travelled - gained + force * pushed, rtol=1e-11)
    inertia = 2 * kinetic[1:].reshape(*mesh.angle.shape, 1) + 50.0
    np.testing.assert_allclose(solution.speed, np.sqrt(2 * solution.energy / inertia), rtol=1e-11)
    assert solution.driving.shape == solution.resisting.shape == solution.energy.shape
    np.testing.assert_array_equal(solution.driving, np.broadcast_to(torque, solution.energy.shape))
    np.testing.assert_allclose(
        solution.force, solution.driving + solution.resisting + mesh.weight[:, :, None], rtol=0, atol=1e-11 * force[0]
    )
    weights = 0.5 * np.polynomial.legendre.leggauss(len(mesh.angle))[1][:, None] * np.diff(mesh.borders)
    np.testing.assert_allclose(np.diff(solution.ends, axis=0), np.einsum("qp,qps->ps", weights, solution.force), atol=1e-9 * start[0])
    assert solution.speed_free
    assert not solution.stiffness.any()
    assert solution.evaluations == solution.energy.size


@pytest.mark.parametrize("count", [1, 3])
def test_an_inertia_that_is_not_positive_is_told_with_its_worst_crank_angle(press, count):
    """A flywheel of less than nothing that outweighs the press in a part of the turn, where the slide nearly rests: of one scenario, and of
    one among others."""
    driven = driven_press(press, None, pp.drives.Flywheel(1.0), [], None, None)
    mesh = build_mesh(driven, 0.0, 1, mesh_borders(driven, 0.0, 1, driven.model.period))
    added = np.r_[np.full(count - 1, 5.0), -(mesh.inertia.min() + 1e-3)]
    less = dataclasses.replace(driven, inertia=added if count > 1 else float(added[0]))
    with pytest.raises(pp.SimulationError, match=r"at the crank is -0\.001 kg m2") as raised:
        collocation.solve(less, mesh, np.full(count, 1e3))
    assert raised.value.crank_angle == mesh.angle.ravel()[mesh.inertia.argmin()]
