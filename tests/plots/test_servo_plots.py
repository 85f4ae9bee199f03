"""Charts of servo motions show the numbers they are given."""

import numpy as np
import pytest

import pinpress as pp
from pinpress.servo import CatalogueMotor, ServoDrive, Stop

MOTOR = CatalogueMotor("short", 0.5, [0.0, 100.0, 200.0], [300.0, 280.0, 140.0], [800.0, 800.0, 400.0])


def test_curves_and_limits():
    press = pp.load("crank_slide")
    motion = pp.servo.motion_by_law(
        press, ServoDrive(inertia=2.0, ratio=5.0, peak_torque=500.0, top_speed=90.0), "cubic", time=1.0, path=Stop()
    )
    even = pp.servo.constant_crank_speed(press, ServoDrive(inertia=2.0, ratio=5.0), time=1.0)
    height, speed, torque, power = pp.plots.servo({"cubic": motion, "even": even}).axes
    for axes, values in (
        (height, 1e3 * motion.height),
        (speed, motion.speed / pp.RPM),
        (torque, motion.motor_torque),
        (power, 1e-3 * motion.power),
    ):
        assert np.array_equal(axes.lines[0].get_xydata(), np.column_stack([motion.time, values]))
    assert [line.get_ydata()[0] for line in speed.lines[2:]] == pytest.approx([18.0 / pp.RPM])
    assert [line.get_ydata()[0] for line in torque.lines[2:]] == [500.0, -500.0]
    assert len(power.lines) == 2


def test_torque_is_below_the_curves_of_the_motor():
    motion = pp.servo.constant_crank_speed(pp.load("crank_slide"), MOTOR.drive(10.0), time=1.0)
    torque, dot, peak, rated = pp.plots.torque_over_speed({"even": motion}, MOTOR).axes[0].lines
    assert torque.get_ydata() == pytest.approx(np.abs(motion.motor_torque))
    assert dot.get_xydata()[0] == pytest.approx([10 * 60.0, motion.rms_motor_torque])
    assert (peak.get_ydata()[0], peak.get_ydata()[-1], rated.get_ydata()[0], rated.get_ydata()[-1]) == (800.0, 400.0, 300.0, 140.0)
    assert peak.get_xdata()[-1] == pytest.approx(200.0 / pp.RPM)


def test_without_a_motor_the_drives_own_curve_is_drawn():
    motion = pp.servo.constant_crank_speed(pp.load("crank_slide"), MOTOR.drive(10.0), time=1.0)
    _, _, peak, rated = pp.plots.torque_over_speed({"even": motion}).axes[0].lines
    assert peak.get_ydata() == pytest.approx(MOTOR.peak_torque_at(peak.get_xdata() * pp.RPM))
    assert (peak.get_xdata()[-1], set(rated.get_ydata())) == (pytest.approx(200.0 / pp.RPM), {300.0})
