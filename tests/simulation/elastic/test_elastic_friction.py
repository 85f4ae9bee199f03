"""Friction in the bearings and guides of presses on springs: against inverse dynamics, the rigid press under its motor, and energy."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from support.presses.presses_on_springs import SPEED, induction, jf75g, springs

import pinpress as pp

FRICTION = {"O": pp.loads.Friction(0.05, 0.05), "P2": pp.loads.Friction(0.03, 0.06, 2.0), "P4": pp.loads.Friction(0.05, 0.05)}
FRICTION |= {"slide_guide": pp.loads.Friction(0.08, viscous=500.0)}


@cache
def stroke(stiffness):
    held = pp.drives.PrescribedSpeed(SPEED)
    return pp.steady_state(
        jf75g(), SPEED, drive=held, friction=FRICTION, elastic=replace(springs(jf75g(), stiffness), damping_ratio=0.3), points=121
    )


def test_friction_becomes_that_of_the_rigid_press():
    """Torque, forces and the work of friction, but near the reversals: what the springs change goes with 1 / stiffness."""
    motion = pp.cycle(jf75g(), SPEED, points=120)
    rigid, errors = pp.inverse_dynamics(jf75g(), motion, friction=FRICTION), []
    fine = pp.inverse_dynamics(jf75g(), pp.cycle(jf75g(), SPEED, points=3600), friction=FRICTION).driving_torque
    beside = motion.crank_angle - pp.dead_centres(jf75g()).bottom_angle
    clear = np.abs(np.sin(2 * beside)) > 0.7  # slide and rod turn back at 0 and 90 degrees, and ring
    for stiffness in (1e10, 2e10):
        run: Any = stroke(stiffness)
        assert run.stats.energy_error < 1e-11
        torque = np.abs(run.drive_torque[:-1] - rigid.driving_torque)[clear].max()
        force = max(np.abs(run.bearing_force[name][:-1, [0, 2]] - rigid.bearing_force[name][:, [0, 2]])[clear].max() for name in FRICTION)
        errors.append((torque, force, abs(run.lost[-1] - 2 * np.pi * fine.mean())))
    assert clear.sum() > 40
    np.testing.assert_allclose(np.divide(*errors), 2.0, rtol=0.1)


@pytest.mark.exhaustive
def test_a_press_with_friction_under_its_motor():
    given: Any = {"drive": induction(), "flywheel": pp.drives.Flywheel(40.0), "friction": FRICTION, "points": 121}
    rigid = pp.steady_state(jf75g(), SPEED, **given)
    run: Any = pp.steady_state(jf75g(), SPEED, elastic=springs(jf75g(), 2e10), **given)
    assert run.time[-1] == pytest.approx(rigid.time[-1], rel=1e-5)
    assert run.lost[-1] == pytest.approx(rigid.lost[-1], rel=1e-3)
    assert run.drive_work[-1] == pytest.approx(run.lost[-1], rel=1e-10)
    run = pp.simulate(jf75g(), 0.05, speed=SPEED, elastic=springs(jf75g(), 2e10), **given)
    rigid = pp.simulate(jf75g(), 0.05, speed=SPEED, **given)
    np.testing.assert_allclose(run.crank_speed, rigid.crank_speed, rtol=1e-4)
    assert run.stats.energy_error < 1e-11


def with_gibs(stiffness, preload):
    """The press on springs whose guide has two equal gibs, each pressed on by half of the preload."""
    bare = springs(jf75g(), stiffness)
    gibs = pp.elasticity.PreloadedJoint(0.5 * stiffness, 0.5 * stiffness, 0.5 * preload)
    return replace(bare, stiffness=replace(bare.stiffness, bearings={**bare.stiffness.bearings, "slide_guide": gibs}))


def test_gibs_rub_by_their_preload():
    """Two equal gibs rub as a preload that is given, and as that of the rigid press: mu P twice the stroke in a turn."""
    held, preload = pp.drives.PrescribedSpeed(SPEED), 20e3
    given: Any = {"drive": held, "points": 121}
    told = {"slide_guide": pp.loads.Friction(0.08, preload=preload)}
    by_law: Any = pp.steady_state(jf75g(), SPEED, friction=told, elastic=springs(jf75g(), 2e9), **given)
    by_gibs: Any = pp.steady_state(
        jf75g(), SPEED, friction={"slide_guide": pp.loads.Friction(0.08)}, elastic=with_gibs(2e9, preload), **given
    )
    np.testing.assert_allclose(
        by_gibs.drive_torque, by_law.drive_torque, rtol=0, atol=1e-7 * np.abs(by_law.drive_torque).max()
    )  # steps differ
    assert by_gibs.stats.energy_error < 1e-11
    expected = 0.08 * preload * 2 * pp.dead_centres(jf75g()).stroke
    rigid = pp.simulate(jf75g(), 2 * np.pi / SPEED, friction=told, **given)
    assert rigid.lost[-1] == pytest.approx(expected, rel=1e-9)
    assert by_law.lost[-1] == pytest.approx(expected, rel=5e-3)  # creeping at the reversals
    with pytest.raises(pp.PinpressError, match="'slide_guide': its gibs are a PreloadedJoint, whose forces rub: leave preload out"):
        pp.steady_state(jf75g(), SPEED, friction=told, elastic=with_gibs(2e9, preload), **given)


@pytest.mark.parametrize("kind", ["net force", "preload", "gibs"])
def test_derivatives_of_friction(kind):
    """Closed-form Jacobians against differences."""
    from pinpress.simulation.elastic.press.assembly import sprung_press
    from pinpress.simulation.elastic.press.friction import bearing_friction

    press, rng = jf75g(), np.random.default_rng(1)
    sprung: Any = sprung_press(press, with_gibs(2e8, 2e5) if kind == "gibs" else springs(press, 2e8))
    sprung = sprung.with_opening_joints() if kind == "gibs" else sprung
    given = FRICTION | {"slide_guide": pp.loads.Friction(0.08, viscous=500.0, preload=2e5 if kind == "preload" else 0.0)}
    friction = bearing_friction(sprung, pp.loads.link.law(given, press), 100.0)
    free = sprung.free_coordinates(sprung.geometry.rigid(pp.servo_cycle(press, angle=[0.3, 2.0, 4.0], speed=1.0))[0])
    free, rates = free + 1e-3 * rng.normal(size=free.shape), 0.1 * rng.normal(size=free.shape)

    def forces(free, rates):
        return friction.forces(sprung.state(free, rates))

    _, stiffness, damping = forces(free, rates)
    for given, by_rate in ((stiffness, False), (damping, True)):
        for k in range(sprung.free):
            step = 1e-7 * np.eye(sprung.free)[k]
            ends = [forces(free + (0 if by_rate else s) * step, rates + (s if by_rate else 0) * step)[0] for s in (1, -1)]
            np.testing.assert_allclose(given[:, :, k], -(ends[0] - ends[1]) / 2e-7, atol=1e-5 * np.abs(given).max())


def test_friction_in_a_pin_with_clearance_is_refused():
    worn = replace(springs(jf75g()), clearances={"P4": pp.elasticity.Clearance(1e-4)})
    held = pp.drives.PrescribedSpeed(SPEED)
    with pytest.raises(pp.PinpressError, match="'P4' has clearance: give it no friction"):
        pp.simulate(jf75g(), 0.1, drive=held, friction=FRICTION, elastic=worn)
