"""Presses on springs whose crank turns freely: rigid limit, energy, marched strokes, a shaft as a torsion pendulum, forces in time."""

import pickle
from functools import cache
from typing import Any

import numpy as np
import pytest
from support import texts
from support.presses.presses_on_springs import BLANK, RPM, SPEED, WHEEL, induction, jf75g, pendulum, springs

import pinpress as pp
from pinpress.simulation.elastic import period, simulate_elastic


@cache
def steady(stiffness=2e9, loads=(BLANK,), drive=None, **more):
    press, rigid = jf75g(), stiffness is None
    elastic = None if rigid else springs(press, stiffness)
    return pp.steady_state(press, SPEED, drive=drive or induction(), flywheel=WHEEL, loads=loads, elastic=elastic, points=121, **more)


def test_steady_state_becomes_that_of_the_rigid_press():
    """What the springs change goes with 1 / stiffness."""
    rigid = pp.measures.duty_cycle(steady(None, ()))
    errors = []
    for stiffness in (1e10, 2e10, 4e10):
        run = steady(stiffness, ())
        duty = pp.measures.duty_cycle(run)
        errors.append((np.abs(run.crank_speed - steady(None, ()).crank_speed).max(), abs(duty.motor_rms - rigid.motor_rms)))
    np.testing.assert_allclose(np.divide(errors[:2], errors[1:]), 2.0, rtol=0.03)
    assert errors[-1][0] < 1e-6 * SPEED


@pytest.mark.exhaustive
def test_blanking_under_a_motor():
    """The energy balances over the stroke, and within it; the press slows down as it must, and a marched run repeats the stroke."""
    run, rigid = steady(), steady(None)
    assert run.stats.energy_error < 1e-10
    assert run.drive_work[-1] == pytest.approx(run.load_work[-1] + run.lost[-1], rel=1e-10)
    assert run.load_work[-1] == pytest.approx(rigid.load_work[-1], rel=1e-9)  # the whole blank is cut
    assert run.crank_speed[[0, -1]] == pytest.approx(run.crank_speed[0], rel=1e-12)
    assert run.time[-1] > rigid.time[-1]  # the springs lose energy
    assert run.decay_per_stroke < 1
    later: Any = pp.simulate(jf75g(), 0.7, speed=run.crank_speed[0], drive=induction(), flywheel=WHEEL, loads=[BLANK], elastic=run.elastic)
    assert later.stats.energy_error < 1e-10
    begins = np.array([time for time, _, height in later.events if height == pytest.approx(run.events[0][2], abs=1e-9)])
    angles = np.array([angle for _, angle, height in later.events if height == pytest.approx(run.events[0][2], abs=1e-9)])
    beside = np.abs(np.diff(begins) - run.time[-1])
    assert (beside[1:] < 0.5 * beside[:-1]).all()
    assert beside[-1] < 5e-4 * run.time[-1]
    assert angles[-1] - 4 * np.pi == pytest.approx(run.events[0][1], abs=1e-3)
    assert len(pp.measures.stroke_duties(later)) == 3


@pytest.mark.exhaustive
def test_steady_state_from_another_angle():
    """It is the same stroke; gears with losses give the torque a corner at the motor's synchronous speed."""
    drive = induction(efficiency=0.9)
    first, second = (steady(2e9, (BLANK,), drive, angle=angle) for angle in (0.0, 4.0))
    assert first.time[-1] == pytest.approx(second.time[-1], rel=1e-9)
    assert first.lost[-1] == pytest.approx(second.lost[-1], rel=1e-9)
    for run in (first, second):
        assert run.stats.energy_error < 1e-8
    assert second.crank_angle[[0, -1]] == pytest.approx((4.0, 4.0 + 2 * np.pi), abs=1e-9)


def test_shaft_as_a_torsion_pendulum():
    """Between a held rotor, or one of 300 kg m2, and a crank of 100 kg m2: frequency and decay in closed form."""
    press, stiffness, speed, ratio = pendulum(0.3), 1e6, 50.0, 0.02
    elastic = springs(press, 1e9, shaft=stiffness)
    alone = np.sqrt(stiffness / 100.0)  # the damper is 2 ratio stiffness / alone
    held: Any = pp.steady_state(press, speed, drive=pp.drives.PrescribedSpeed(speed), elastic=elastic)
    assert held.decay_per_stroke == pytest.approx(np.exp(-ratio * alone * held.time[-1]), rel=1e-4)
    motor = pp.drives.InductionMotor(10.0, 49.0, frequency=50 / (2 * np.pi), poles=2)
    free: Any = pp.steady_state(press, speed, drive=motor, flywheel=pp.drives.Flywheel(300.0), elastic=elastic)
    values = np.linalg.eigvals(free.trajectory.segments[0].solution.panels.passage)
    swing = values[np.abs(values.imag).argmax()]
    square = stiffness * (1 / 100 + 1 / 300)
    decay = ratio * square / alone
    assert abs(swing) == pytest.approx(np.exp(-decay * free.time[-1]), rel=1e-3)
    turned = np.sqrt(square - decay**2) * free.time[-1]
    assert abs(np.angle(swing)) == pytest.approx(abs((turned + np.pi) % (2 * np.pi) - np.pi), abs=1e-3)


def test_force_in_time():
    """The impulse of a force between its edges is what the crank and the links gain; a crank of great inertia turns on."""
    force = pp.loads.TimeForce(lambda time: 1e5 * (np.asarray(time) > 0.02) * (np.asarray(time) <= 0.03), edges=(0.02, 0.03))
    run: Any = pp.simulate(
        jf75g(), 0.05, speed=SPEED, flywheel=pp.drives.Flywheel(1e9), loads=[force], elastic=springs(jf75g()), points=501
    )
    assert run.stats.energy_error < 1e-10
    assert [time for time, _, _ in run.events] == pytest.approx([0.02, 0.03], abs=1e-12)
    moved = run.slide_position[[200, 300]]
    assert -run.load_work[-1] == pytest.approx(1e5 * (moved[1] - moved[0]), rel=1e-9)


def test_run_without_a_drive():
    """A press that nothing drives loses what its dampers take."""
    run = pp.simulate(jf75g(), 0.2, speed=SPEED, flywheel=WHEEL, elastic=springs(jf75g(), 2e8))
    assert run.stats.energy_error < 1e-10
    assert not run.drive_torque.any()
    assert run.lost[-1] > 0
    with pytest.raises(pp.SimulationError, match="crank comes to rest"):
        pp.simulate(jf75g(), 1.0, speed=SPEED, loads=[BLANK], elastic=springs(jf75g()))


@pytest.mark.exhaustive
def test_events_of_a_stroke_are_planned_by_its_own_motion(monkeypatch):
    """Drawing ends where the rigid six-bar turns; on its springs the slide passes that height before. Nothing is marched."""
    press, speed = texts.shipped("zxn2_3000b"), 70 * RPM
    monkeypatch.setattr(period, "march", None)
    drawing, drive = pp.loads.DeepDrawing(1.5e6, 0.05), pp.drives.PrescribedSpeed(speed)
    run: Any = pp.steady_state(press, speed, drive=drive, loads=[drawing], elastic=springs(press), tolerance=1e-4)
    bottom = pp.dead_centres(press)
    assert [height - bottom.bottom_position for _, _, height in run.events] == pytest.approx([0.05, 0.0], abs=1e-9)
    assert run.events[1][1] < bottom.bottom_angle - 0.1
    assert run.deepest < bottom.bottom_position
    assert run.stats.energy_error < 1e-8


@pytest.mark.filterwarnings("ignore:Stiffness")
def test_too_soft_and_unstable(monkeypatch):
    """Stiffnesses in N/mm are told; a stroke to which the press does not come is none."""
    given: Any = {"drive": pp.drives.PrescribedSpeed(SPEED), "loads": [BLANK]}
    with pytest.raises(pp.PinpressError, match="are too soft"):
        pp.steady_state(jf75g(), SPEED, elastic=springs(jf75g(), 2e6), **given)
    monkeypatch.setattr(simulate_elastic, "STABLE", 0.05)
    with pytest.raises(pp.SimulationError, match="a disturbance of the links grows"):
        pp.steady_state(jf75g(), SPEED, elastic=springs(jf75g()), **given)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"speed": 0.0}, "crank that turns"),
        ({"method": "implicit"}, "leave out method"),
        ({"step": 1e-3}, "leave out method and step"),
        ({"flywheel": None, "elastic": "shaft"}, "inertia on its drive's side"),
    ],
)
def test_drives_that_an_elastic_run_cannot_have_are_refused(change, message):
    given = {"speed": SPEED, "flywheel": WHEEL, "elastic": springs(jf75g())} | change
    if given["elastic"] == "shaft":
        given["elastic"] = springs(jf75g(), shaft=1e7)
    with pytest.raises(pp.PinpressError, match=message):
        pp.simulate(jf75g(), 0.1, **given)


@pytest.mark.exhaustive
def test_inverse_dynamics_and_sweeps_of_elastic_runs():
    """Reactions to such a run are those of the rigid press at the same crank angles; sweeps take its numbers, other processes the run."""
    run, motion = steady(), pp.cycle(jf75g(), SPEED, points=120)
    held: Any = pp.steady_state(jf75g(), SPEED, drive=pp.drives.PrescribedSpeed(SPEED), elastic=run.elastic, points=121)
    rigid, reactions = (pp.inverse_dynamics(jf75g(), each, loads=[BLANK]) for each in (motion, held))
    np.testing.assert_allclose(reactions.driving_torque[:-1], rigid.driving_torque, atol=1e-9 * np.abs(rigid.driving_torque).max())
    assert pickle.loads(pickle.dumps(run)).peaks == run.peaks

    def stroke(stiffness):
        found = pp.steady_state(jf75g(), SPEED, drive=pp.drives.PrescribedSpeed(SPEED), elastic=springs(jf75g(), stiffness), points=121)
        return {"deepest": found.deepest, "peak": found.peaks["O"]}

    table = pp.sweeps.sweep(stroke, {"stiffness": [1e9, 2e9]})
    assert table.columns()["deepest"][1] == held.deepest
