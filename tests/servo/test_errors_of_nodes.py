"""What finer nodes change of a best motion, losses by the speed, and turns that take their time."""

import numpy as np
import pytest
from support import texts
from support.oracles.servo_by_hand import weightless

import pinpress as pp
from pinpress import RPM, servo
from pinpress.servo.task import node_error

FULL = 2 * np.pi
HEAVY = 1e9  # inertia compared with which that of a linkage is nothing [kg m2]
THIN = [pp.loads.DeepDrawing(20e3, 0.15)]
SLOW_DRAWING = [servo.SlideSpeed(0.8, heights=(0.15, 0.0))]


@pytest.mark.parametrize(("points", "most"), [(30, 6.0), (60, 6.0), (480, 3.0)])
def test_the_error_of_the_nodes_holds_the_closed_form(points, most):
    """Least heat from rest to rest, 12 J² L² / T³: the error that is told is one to three times the true one, with few nodes more."""
    exact = 12.0 * HEAVY**2 * FULL**2 / 2.0**3
    best = servo.best_motion(weightless("crank_slide"), servo.ServoDrive(inertia=HEAVY), time=2.0, path=servo.Stop(), points=points)
    assert best.value >= exact * (1.0 - 1e-9)
    assert 1.0 < best.node_error / (best.value / exact - 1.0) < most
    assert len(best.angle) == points + 1
    assert f"error of the nodes {best.node_error:.1e}" in str(best)


@pytest.mark.parametrize("order", [1, 2])
def test_errors_of_both_orders_are_half_more_than_by_extrapolation(order):
    values = [5.0 + 0.3 * h**order for h in (1.0, 0.5, 0.25)]
    assert node_error(values) == pytest.approx(1.5 * 0.3 * 0.25**order / values[-1])


def swinging(**more):
    """A press with a heavy gear that swings nearly freely, so that its torque is small and its motion has to be known closely."""
    press, speed = texts.shipped("zxn2_3000b"), 55 * RPM
    stroke, energy = pp.dead_centres(press).stroke, 0.5 * 2600.0 * speed**2
    load = [pp.loads.Blanking(0.15 * energy / stroke, 0.2 * stroke, 0.1 * stroke)]
    drive = servo.ServoDrive(inertia=0.01, ratio=20.0, gear_inertia=130.0)
    return servo.best_motion(press, drive, load, time=1.6, path=servo.Stop(), **more)


@pytest.mark.exhaustive
def test_nodes_are_refined_until_their_error_is_small():
    """With 720 nodes the heat is 5 % above that of 5760, which is told; without a number of nodes they are refined."""
    told, best = swinging(points=720), swinging()
    assert best.node_error < 1e-3
    assert len(best.angle) > 5000
    assert told.value / best.value - 1.0 == pytest.approx(0.049, abs=0.002)  # of the nodes, whatever the gap is
    assert told.value * (1.0 - told.gap - told.node_error) < best.value
    assert any("finer nodes may change the objective by" in note for note in told.notes)


@pytest.mark.exhaustive
def test_a_least_peak_is_held_between_nodes():
    """In full inverse dynamics many segments reach the largest torque, and no state between two nodes exceeds it."""
    press, drive = texts.shipped("thin_wall"), servo.ServoDrive(inertia=2.0)
    best = servo.best_motion(press, drive, THIN, minimise="peak", time=60 / 72, path=servo.Turn(), limits=SLOW_DRAWING, points=360)
    torque = np.abs(best.motion.torque).reshape(-1, 4)
    largest = np.sort(torque.max(axis=1))
    assert largest[-10] > largest[-1] * (1.0 - 1e-3)
    assert torque[:, 1:3].max() <= torque.max() * (1.0 + 1e-9)
    finer = servo.best_motion(press, drive, THIN, minimise="peak", time=60 / 72, path=servo.Turn(), limits=SLOW_DRAWING, points=1440)
    assert best.value * (1.0 - best.node_error - best.gap) < finer.value <= best.value


@pytest.mark.exhaustive
@pytest.mark.parametrize(("drag", "least"), [(18.0, 879.0313262), (19.0, 882.7709463), (20.5, 888.4724784)])
@pytest.mark.parametrize("path", [servo.Turn(), None])
def test_drag_of_the_motor_leaves_the_motion_without_it_possible(drag, least, path):
    """The rms torque is not above that of the motion without drag when the drag acts on it, by inverse dynamics; the time is met."""
    drive = servo.ServoDrive(inertia=2.0, top_speed=60.0, viscous=drag)
    best = servo.best_motion(texts.shipped("thin_wall"), drive, THIN, time=60 / 70, path=path, limits=SLOW_DRAWING, points=360)
    assert best.motion.duration == pytest.approx(60 / 70, rel=1e-6)
    assert best.motion.rms_torque < least
    assert -1e-9 < best.gap < 2e-3


@pytest.mark.exhaustive
def test_points_of_a_trade_off_tell_the_error_of_their_nodes():
    press, drive = texts.shipped("thin_wall"), servo.ServoDrive(inertia=2.0)
    times = [60 / 72, 1.0]
    rough, fine = (servo.trade_off(press, drive, THIN, times=times, limits=SLOW_DRAWING, points=n) for n in (90, 720))
    for one, other in zip(rough, fine, strict=True):
        assert abs(one.rms_motor_torque**2 / other.rms_motor_torque**2 - 1.0) < one.gap + one.node_error < 0.05
