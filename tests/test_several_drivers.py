"""Forward dynamics of a linkage with several drivers: Cassie's legs, 12 drivers, 12 equations of rank 10."""

import cassie
import numpy as np
import pytest
import texts

import pinpress as pp


@pytest.fixture(scope="module")
def legs(tmp_path_factory):
    file = tmp_path_factory.mktemp("cassie") / "cassie.urdf"
    file.write_text(cassie.urdf(), encoding="utf-8")
    return pp.load(file)


def test_a_free_fall(legs):
    """The legs fall from rest: energy is kept, loops stay closed, and the joints' accelerations are those that need no torque."""
    run = pp.simulate(legs, 0.05, method="constraint")
    assert run.stats.energy_error < 1e-9
    assert run.closure_error.max() < 1e-10
    assert run.crank_angle.shape == run.drive_torque.shape == (121, 12)
    torque = pp.inverse_dynamics(legs, run).driving_torque
    weight = pp.inverse_dynamics(legs, pp.cycle(legs, angle=run.crank_angle[:1], speed=0.0)).driving_torque
    assert np.abs(torque).max() < 1e-9 * np.abs(weight).max()


def test_drives_and_flywheels(legs):
    """Two drives and a flywheel by the names of their joints: the torques that the motion needs are those, less the flywheel's."""
    first, second = legs.drivers[0], legs.drivers[5]
    motor = pp.drives.Geared(pp.drives.InductionMotor(100.0, 1440 * pp.RPM, inertia=1e-4), 50.0)
    drive, flywheel = {first: pp.ConstantTorque(2.0), second: motor}, {first: pp.Flywheel(0.1)}
    run = pp.simulate(legs, 0.05, method="constraint", drive=drive, flywheel=flywheel)
    needed = np.zeros_like(run.drive_torque)
    needed[:, 0] = 2.0 - 0.1 * run.crank_acceleration[:, 0]
    needed[:, 5] = motor.torque(run.crank_speed[:, 5]) - motor.inertia * run.crank_acceleration[:, 5]
    torque = pp.inverse_dynamics(legs, run).driving_torque
    np.testing.assert_allclose(torque, needed, rtol=0, atol=1e-8 * np.abs(needed).max())
    np.testing.assert_array_equal(run.drive_torque[:, 5], motor.torque(run.crank_speed[:, 5]))
    assert run.stats.energy_error < 1e-8


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"method": "reduced"}, "method='constraint' simulates it"),
        ({"drive": pp.ConstantTorque(1.0)}, r"give drive as \{joint: Drive\}"),
        ({"drive": {"elbow": pp.ConstantTorque(1.0)}}, "no driver 'elbow'"),
        ({"drive": {"left-roll-op": 5.0}}, "drive of 'left-roll-op' is 5.0"),
        ({"drive": {"left-roll-op": pp.drives.ServoMotor([0, 1], [0, 1], 1.0, 1.0, 1.0)}}, "torque depends on speed alone"),
        ({"speed": [1.0, 2.0]}, "one of each of the 12 drivers"),
        ({"brake": pp.Brake(5.0)}, "clutch and brake are for one"),
    ],
)
def test_wrong_arguments(legs, arguments, message):
    with pytest.raises(pp.PinpressError, match=message):
        pp.simulate(legs, 0.01, **{"method": "constraint", **arguments})


@pytest.mark.parametrize("more", [{"step": 1e-3}, {"loads": [pp.loads.TimeForce(lambda t: 1e5 + 0 * np.asarray(t))]}])
def test_a_prescribed_speed_leaves_nothing_to_integrate(more):
    with pytest.raises(pp.PinpressError, match="leaves nothing to integrate"):
        pp.simulate(texts.shipped("jf75g_125"), 0.3, drive=pp.drives.PrescribedSpeed(31.0), **more)
