"""What must hold of every run, whatever led to it; the list stands in `pinpress.simulation`.

The starts at which the energy equation over the angle once settled at speeds that no state had are among those tried here: a crank at
rest, or nearly, under an induction motor and a flywheel.
"""

import numpy as np
import pytest
from support import texts
from support.oracles import run_by_inverse_dynamics as oracle

import pinpress as pp
from pinpress.common.numerics import gauss_rule
from pinpress.simulation.driven_press import driven_press
from pinpress.simulation.over_angle import collocation, refinement
from pinpress.simulation.over_angle.forces import Forces
from pinpress.simulation.over_angle.mesh import build_mesh, mesh_borders
from pinpress.simulation.over_time.time_solver import TimeSegment
from pinpress.simulation.run import BETWEEN

RPM = np.pi / 30
MOTOR = pp.drives.Geared(pp.drives.InductionMotor(75e3, 1485 * RPM, inertia=1.2), ratio=20.7)
AT_THE_CRANK = 1.2 * 20.7**2  # inertia of the motor [kg m2]


@pytest.fixture(scope="module")
def press():
    return texts.shipped("zxn2_3000b")


def began(driven, angle, speed, direction=1):
    """A mesh over a period and the kinetic energies at its start."""
    mesh = build_mesh(driven, angle, direction, mesh_borders(driven, angle, direction, driven.model.period))
    return mesh, 0.5 * (mesh.inertia_ends[0] + driven.inertia) * np.square(np.atleast_1d(speed))


SLOW = np.array([0.05, 0.15, 0.4, 1.0, 2.0, 5.0])  # the first ones stop [rad/s]


@pytest.fixture(scope="module", params=["motor", "motor and load", "friction"])
def case(press, request):
    """A driven press, a mesh, and energies at its start of which some do not last for a period."""
    loads = [] if request.param == "motor" else [pp.loads.ElasticDie(0.05, 1e6, 1e5)]
    friction = {"A": pp.loads.Friction(0.05, 0.1)} if request.param == "friction" else {}
    driven = driven_press(press, MOTOR, pp.drives.Flywheel(1500.0), loads, None, None, friction)
    return (driven, *began(driven, np.radians(130), SLOW))


# ------------------------------------------------------------------------------------------------------------------- energy over the angle


@pytest.mark.one_in(3)
def test_all_forces_are_those_at_the_speed_that_the_energy_gives(case):
    """On every panel that counts as solved. Elsewhere the speed follows from the energy too, never from a limit."""
    driven, mesh, energy = case
    solution = collocation.solve(driven, mesh, energy)
    assert solution.settled.min() < len(mesh.kinds)
    assert solution.settled.max() == len(mesh.kinds)
    inertia = mesh.inertia[:, :, None] + driven.inertia
    speed = np.sqrt(2 * np.maximum(solution.energy, 0.0) / inertia)
    np.testing.assert_allclose(solution.speed, speed, rtol=1e-14, atol=1e-100)
    again = Forces(driven.drive, mesh, inertia, speed.shape)
    force = again.at(speed) + mesh.weight[:, :, None]
    solved = np.arange(len(mesh.kinds))[:, None] < solution.settled
    assert (solution.energy > 0)[:, solved].all()
    scale = np.abs(force[:, solved]).max()
    np.testing.assert_allclose(solution.force[:, solved], force[:, solved], rtol=0, atol=1e-8 * scale)
    gained = np.einsum("q,qps->ps", gauss_rule().weights, force * mesh.measure[:, :, None])  # the work of these forces
    np.testing.assert_allclose(np.diff(solution.ends, axis=0)[solved], gained[solved], rtol=0, atol=1e-9 * solution.ends[0].max())


@pytest.mark.one_in(3)
def test_a_guess_changes_no_answer(case):
    """It may change the number of rounds. What is solved stays the same too."""
    driven, mesh, energy = case
    right = collocation.solve(driven, mesh, energy)
    solved = np.arange(len(mesh.kinds))[:, None] < right.settled
    shape = right.energy.shape
    for share in (1e-2, 1.0, 1e2, 1e6):
        for guess in (share * np.maximum(right.energy, 1e-3 * energy), np.broadcast_to(share * energy, shape)):
            other = collocation.solve(driven, mesh, energy, guess)
            np.testing.assert_array_equal(other.settled, right.settled)
            np.testing.assert_allclose(other.energy[:, solved], right.energy[:, solved], rtol=1e-9)


@pytest.mark.one_in(3)
def test_what_follows_a_panel_does_not_change_it(case):
    driven, mesh, energy = case
    whole = collocation.solve(driven, mesh, energy)
    for count in (1, len(mesh.kinds) // 2, len(mesh.kinds) - 1):
        part = collocation.solve(driven, build_mesh(driven, mesh.start, 1, mesh.borders[: count + 1]), energy)
        np.testing.assert_array_equal(part.settled, np.minimum(whole.settled, count))
        solved = np.arange(count)[:, None] < part.settled
        np.testing.assert_allclose(part.energy[:, solved], whole.energy[:, :count][:, solved], rtol=1e-10)


@pytest.mark.one_in(3)
def test_panels_that_are_not_solved_hand_over_the_energy_at_the_start(case):
    driven, mesh, energy = case
    solution = collocation.solve(driven, mesh, energy)
    finer = build_mesh(driven, mesh.start, 1, np.sort(np.concatenate([mesh.borders, 0.5 * (mesh.borders[:-1] + mesh.borders[1:])])))
    guess = refinement.interpolate_onto(solution, finer)
    assert guess is not None
    solved = np.arange(len(finer.kinds))[:, None] < 2 * solution.settled
    for k, start in enumerate(energy):
        assert (guess[:, ~solved[:, k], k] == start).all()
    right = collocation.solve(driven, finer, energy).energy[:, solved]
    np.testing.assert_allclose(guess[:, solved], right, rtol=0, atol=1e-2 * energy.max())


# --------------------------------------------------------------------------------------------------------------------------- whole runs


def holds_as_a_run(run, motors_speed=None):
    """The path, the order of times, finite torques, and energies that are not negative."""
    times = np.union1d(np.linspace(0.0, run.time[-1], 3001), run.trajectory.borders)
    sample = run.trajectory.at(times, complete=False)
    angle, speed = sample.position[0], np.abs(sample.speed[0])
    reach = np.maximum(speed[1:], speed[:-1]) * np.diff(times)
    swung = np.sign(sample.speed[0][1:]) != np.sign(sample.speed[0][:-1])
    assert (np.abs(np.diff(angle)) <= reach * np.where(swung, 2.0, 1.01) + 1e-9).all()
    assert (np.diff(run.trajectory.borders) > 0).all()
    assert np.isfinite(sample.drive_torque).all()
    assert np.isfinite(sample.motor_torque).all()
    assert speed.max() <= run.trajectory.fastest * BETWEEN  # between the ends of steps it may be a little larger
    if motors_speed is not None:
        assert speed.max() <= motors_speed


STARTS = ((1500, 130), (1500, 135), (1500, 290), (1500, 320), (2500, 100), (2500, 330), (3500, 90), (3500, 335), (4500, 80), (4500, 265))
ONE_OF_THEM = (1500, 290)


@pytest.mark.parametrize(
    ("wheel", "degrees"), [pytest.param(*ONE_OF_THEM), *(pytest.param(*s, marks=pytest.mark.exhaustive) for s in STARTS)]
)
def test_a_start_from_rest_ends_where_inverse_dynamics_leads(press, wheel, degrees):
    run = pp.simulate(press, 0.5, angle=np.radians(degrees), drive=MOTOR, flywheel=pp.drives.Flywheel(float(wheel)))
    torque = oracle.kloss(75e3, 1485, 20.7)
    right = oracle.run(press, run.time[::60], np.radians(degrees), 0.0, wheel + AT_THE_CRANK, torque)
    np.testing.assert_allclose(run.crank_angle[::60], right[0], rtol=0, atol=2e-8)
    np.testing.assert_allclose(run.crank_speed[::60], right[1], rtol=0, atol=2e-7)
    holds_as_a_run(run, 50 * np.pi / 20.7 * 1.001)


def test_a_call_repeated_is_equal_in_every_bit(press):
    asked = {"angle": 1.0, "drive": MOTOR, "flywheel": pp.drives.Flywheel(1500.0)}
    first = pp.simulate(press, 0.5, **asked)
    pp.simulate(press, 0.5, speed=3.0, tolerance=1e-6, **asked)
    second = pp.simulate(press, 0.5, **asked)
    for name in ("crank_angle", "crank_speed", "crank_acceleration", "drive_torque", "drive_work", "lost"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_a_call_repeated_is_equal_in_every_bit_over_time_and_in_a_steady_state(press):
    clutch, brake = pp.drives.Clutch(9e4, pp.drives.SwitchPoint(time=0.05)), pp.drives.Brake(5e4, opens=pp.drives.SwitchPoint(time=0.05))
    parts = {"drive": MOTOR, "loads": [pp.loads.Blanking(2e5, 0.01, 0.004)]}
    wheel = pp.drives.Flywheel(1500.0, speed=7.0)

    def runs():
        yield pp.simulate(press, 0.4, angle=1.0, clutch=clutch, brake=brake, flywheel=wheel, **parts)
        yield pp.steady_state(press, 7.3, flywheel=pp.drives.Flywheel(1500.0), **parts)

    for first, second in zip(list(runs()), list(runs()), strict=True):
        for name in ("time", "crank_angle", "crank_speed", "crank_acceleration", "drive_torque", "drive_work", "lost"):
            np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


RESTS = {
    "brake": {"angle": 1.0, "speed": 5.0, "brake": pp.drives.Brake(300.0, pp.drives.SwitchPoint(time=0.05))},
    "load behind a clutch": {
        "angle": -1.0,
        "drive": pp.drives.ConstantTorque(100.0),
        "clutch": pp.drives.Clutch(50.0),
        "loads": [pp.loads.DeepDrawing(1e5, 0.1)],
    },
    "friction": {"angle": 0.1, "speed": 1.0, "friction": {"slide_guide": pp.loads.Friction(0.3, preload=3e5)}},
    "gears with losses": {
        "angle": 0.8,
        "speed": 0.5,
        "drive": pp.drives.Geared(pp.drives.ConstantTorque(10.0), 30.0, efficiency=0.2),
    },
}


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")  # of a press that stands at the end, and of loads without a stroke
@pytest.mark.parametrize("name", RESTS)
def test_at_rest_the_torque_needed_lies_within_what_holds(name):
    """The crank would start neither forward nor back, whatever holds it, at the beginning, in the middle and at the end of each rest."""
    run = pp.simulate(texts.shipped("crank_slide"), 1.5, flywheel=pp.drives.Flywheel(5.0), **RESTS[name])
    rests = 0
    for segment in run.trajectory.segments:
        if not isinstance(segment, TimeSegment):
            continue
        for begin, end, mode, piece in zip(segment.borders, segment.times, segment.modes, segment.pieces, strict=False):
            if not mode.rests:
                continue
            rests += 1
            for time in (begin, 0.5 * (begin + end), end):
                y, system = piece(time), segment.system
                rising = system.tending(system.starting(mode, y, 1), time, y)
                falling = -system.tending(system.starting(mode, y, -1), time, y)
                assert max(rising, falling) <= system.holding(rising, falling)
                assert system.rates(mode, time, y)[1] == 0.0
    assert rests
