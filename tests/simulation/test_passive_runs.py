"""Runs of linkages of which motors move a part: energy, momentum, and the accelerations of inverse dynamics."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import pinpress as pp
from pinpress.linkage.description import JointSpring

ROBOTS = Path(__file__).parents[1] / "reference" / "robots"
BASE = ("root_x", "root_y", "root_z", "root_rz", "root_ry", "root_rx")


def five_bar(motors: int, *springs: JointSpring) -> pp.Linkage:
    """The five-bar with two motors, one, or none."""
    press = pp.load(ROBOTS / "19_no_driver.urdf", drivers=["turn_a", "turn_b"])
    return replace(press, passive=press.drivers[motors:], joint_springs=springs)


def test_without_a_motor_energy_is_kept():
    press = five_bar(0, JointSpring("knee_a", 12.0, 0.1), JointSpring("turn_b", 5.0, -0.4))
    run = pp.simulate(press, 2.0, angle=[0.2, -0.1], speed=[1.0, -1.0], points=60)
    kinetic, potential = np.zeros((2, 60))
    data = press.model.createData()
    for k, (q, v) in enumerate(zip(run.q, run.v, strict=True)):
        kinetic[k], potential[k] = (pin.computeKineticEnergy(press.model, data, q, v), pin.computePotentialEnergy(press.model, data, q))
    for spring in press.joint_springs:
        potential += 0.5 * spring.stiffness * (run.joint_position[:, press.joints.index(spring.joint)] - spring.reference) ** 2
    energy = kinetic + potential
    assert np.ptp(kinetic) > 1.0
    np.testing.assert_allclose(energy, energy[0], atol=1e-9 * kinetic.max())


def test_a_motor_and_a_damped_spring_move_as_inverse_dynamics_says():
    press = five_bar(1, JointSpring("knee_a", 12.0, 0.1, 0.02))
    model = press.model.copy()
    model.armature[press.driver_indices[0]] = 0.01
    press = replace(press, model=model)
    run = pp.simulate(press, 0.5, angle=[0.25], speed=[0.3], drive={"turn_a": pp.drives.ConstantTorque(0.5)}, points=20)
    forces = pp.inverse_dynamics(press, run)
    np.testing.assert_allclose(forces.driving_torque, np.tile([0.5, 0.0], (20, 1)), atol=1e-10)
    np.testing.assert_allclose(forces.motion.a, run.a, atol=1e-10 * np.abs(run.a).max())
    assert run.stats.energy_error < 1e-9


def test_a_motor_that_is_held_at_a_speed_takes_the_torque_of_inverse_dynamics():
    press = five_bar(1, JointSpring("knee_a", 12.0, 0.1, 0.02))
    run = pp.simulate(press, 0.6, angle=[0.2], drive={"turn_a": pp.drives.PrescribedSpeed(-1.5)}, points=13)
    np.testing.assert_allclose(run.crank_angle[:, 0], 0.2 - 1.5 * run.time, atol=1e-9)
    forces = pp.inverse_dynamics(press, run)
    np.testing.assert_allclose(run.drive_torque, forces.driving_torque, atol=1e-8)
    np.testing.assert_allclose(run.a, forces.motion.a, atol=1e-9 * np.abs(run.a).max())
    assert run.stats.energy_error < 1e-10
    with pytest.raises(pp.PinpressError, match=r"speed of turn_a is 2, but its drive prescribes -1\.5"):
        pp.simulate(press, 0.6, speed=[2.0], drive={"turn_a": pp.drives.PrescribedSpeed(-1.5)})


def test_a_floating_linkage_keeps_its_momentum():
    press = pp.load(ROBOTS / "18_floating_base.urdf", base="floating", gravity=(0, 0, 0), drivers=["turn_a", "turn_b", *BASE])
    press = replace(press, passive=BASE)
    run = pp.simulate(press, 0.3, speed=[1.0, -2.0], drive={"turn_a": pp.drives.ConstantTorque(0.02)}, points=12)
    data, momenta = press.model.createData(), []
    for q, v in zip(run.q, run.v, strict=True):
        momenta.append(pin.computeCentroidalMomentum(press.model, data, q, v).vector.copy())
    np.testing.assert_allclose(momenta, np.tile(momenta[0], (12, 1)), atol=1e-9)
    assert np.abs(run.joint_position[-1, press.joints.index("root_ry")]) > 0.01


def test_armature_and_springs_of_one_driver_by_both_methods():
    press = pp.load("crank_slide")
    model = press.model.copy()
    model.armature[:] = 0.5
    press = replace(press, model=model, joint_springs=(JointSpring(press.joints[1], 300.0, 0.2, 5.0),))
    runs = [pp.simulate(press, 0.6, speed=3.0, method=method, points=20) for method in ("reduced", "constraint")]
    np.testing.assert_allclose(runs[0].crank_angle, runs[1].crank_angle, atol=1e-8)


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({"drive": {"turn_b": pp.drives.ConstantTorque(1.0)}}, "no driver 'turn_b'"),
        ({"friction": {"knee_a": pp.loads.Friction(0.1, 0.01)}}, "friction"),
    ],
)
def test_what_passive_runs_do_not_take_is_refused(given, reason):
    with pytest.raises(pp.PinpressError, match=reason):
        pp.simulate(five_bar(1), 0.1, **given)
