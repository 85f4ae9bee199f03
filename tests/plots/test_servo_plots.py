"""Charts of servo motions show the numbers they are given."""

import numpy as np
import pytest

import pinpress as pp
from pinpress.common.quantities import quantity as quantity_of
from pinpress.servo import CatalogueMotor, ServoDrive, Stop

MOTOR = CatalogueMotor("short", 0.5, [0.0, 100.0, 200.0], [300.0, 280.0, 140.0], [800.0, 800.0, 400.0])


CHARTS = "height", "crank_speed", "torque", "power"


def factor(axes, quantity):
    """Shown units in one SI unit, by the label of the axis."""
    return 1 / quantity_of(quantity).sizes()[axes.get_ylabel().partition("[")[2].strip("]")]


def test_curves_and_limits():
    press = pp.load("crank_slide")
    motion = pp.servo.motion_by_law(
        press, ServoDrive(inertia=2.0, ratio=5.0, peak_torque=500.0, top_speed=90.0), "cubic", time=1.0, path=Stop()
    )
    even = pp.servo.constant_crank_speed(press, ServoDrive(inertia=2.0, ratio=5.0), time=1.0)
    height, speed, torque, power = pp.plots.draw({"cubic": motion, "even": even}, *CHARTS).axes
    for axes, values, quantity in (
        (height, motion.height, "length"),
        (speed, motion.speed, "rotational speed"),
        (torque, motion.motor_torque, "torque"),
        (power, motion.power, "power"),
    ):
        x, y = axes.lines[0].get_xydata().T
        assert np.array_equal(x, motion.time)
        np.testing.assert_allclose(y, factor(axes, quantity) * values, rtol=1e-12)
        assert np.array_equal(axes.lines[1].get_xdata(), even.time)
    assert [line.get_ydata()[0] for line in speed.lines[2:]] == pytest.approx([18.0 / pp.RPM])
    assert [line.get_ydata()[0] for line in torque.lines[2:]] == [500.0, -500.0]
    assert len(power.lines) == 2


def test_torque_is_below_the_curves_of_the_drive():
    motion = pp.servo.constant_crank_speed(pp.load("crank_slide"), MOTOR.drive(10.0), time=1.0)
    torque, dot, peak, rated = pp.plots.draw(motion, "plane").axes[0].lines
    assert torque.get_ydata() == pytest.approx(np.abs(motion.motor_torque))
    assert dot.get_xydata()[0] == pytest.approx([10 * 60.0, motion.rms_motor_torque])
    assert peak.get_ydata() == pytest.approx(MOTOR.peak_torque_at(peak.get_xdata() * pp.RPM))
    assert (peak.get_xdata()[-1], set(rated.get_ydata())) == (pytest.approx(200.0 / pp.RPM), {300.0})


def test_torque_is_below_the_curves_of_the_chosen_motor():
    chosen = pp.servo.choose_motor(pp.load("crank_slide"), [MOTOR], ratios=[10.0], time=1.0, points=60)
    assert chosen.motor is not None
    _, dot, peak, rated = pp.plots.draw(chosen, "plane").axes[0].lines
    assert dot.get_ydata()[0] == pytest.approx(chosen.best.motion.rms_motor_torque)
    assert (peak.get_ydata()[0], peak.get_ydata()[-1], rated.get_ydata()[0], rated.get_ydata()[-1]) == (800.0, 400.0, 300.0, 140.0)
    assert peak.get_xdata()[-1] == pytest.approx(200.0 / pp.RPM)
