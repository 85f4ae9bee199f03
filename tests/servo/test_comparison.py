"""Motions beside one another, and as tables for a controller."""

import dataclasses
import re
from functools import cache

import numpy as np
import pytest

import pinpress as pp
from pinpress.servo import CrankAcceleration, CrankSpeed, FeedWindow, RmsTorque, ServoDrive, SlideAcceleration, SlideSpeed, Stop

DRIVE = ServoDrive(inertia=2.0, ratio=5.0, peak_torque=300.0)


@cache
def ready():
    press = pp.load("crank_slide")
    return {
        "even": pp.servo.constant_crank_speed(press, DRIVE, time=1.0),
        "smooth": pp.servo.motion_by_law(press, DRIVE, "3-4-5", time=1.0, path=Stop()),
    }


def test_a_row_has_what_the_motion_says():
    found = pp.servo.compare_motions(ready())
    for row in found.rows:
        motion = ready()[row.name]
        assert (row.rms_torque, row.peak_torque, row.cycle) == (motion.rms_motor_torque, motion.peak_motor_torque, motion.duration)
        assert row.top_speed == pytest.approx(5 * np.abs(motion.speed).max())
    assert list(found.motions) == ["even", "smooth"]


def test_a_motion_that_breaks_a_limit_is_not_the_least():
    press, free = pp.load("crank_slide"), ServoDrive(inertia=2.0, ratio=5.0)
    even = pp.servo.constant_crank_speed(press, free, time=1.0)
    smooth = pp.servo.motion_by_law(press, free, "3-4-5", time=1.0, path=Stop())
    height = 0.5 * float(even.height.max())
    above = [float(motion.weight @ (motion.height >= height)) for motion in (even, smooth)]
    assert above[0] < above[1]
    found = pp.servo.compare_motions({"even": even, "smooth": smooth}, [FeedWindow(height, 0.5 * sum(above))])
    assert found.rows[0].breaks.startswith("feed window of ")
    assert found.rows[0].breaks.endswith(f": {above[0]:.4g} s")
    assert (found.rows[1].breaks, found.rows[1].more_than_least) == ("", 0.0)
    assert found.rows[0].more_than_least < 0
    assert "least rms torque of the motor" in found.title
    assert re.search(r"^  even .* breaks feed window", str(found), flags=re.MULTILINE)


@pytest.mark.parametrize(
    ("limit", "value"),
    [
        (SlideSpeed(0.001), lambda m: -m.motion.slide_velocity.min()),
        (SlideSpeed(0.001, flank="up"), lambda m: m.motion.slide_velocity.max()),
        (CrankSpeed(0.1), lambda m: np.abs(m.speed).max()),
        (SlideAcceleration(1e-3), lambda m: np.abs(m.motion.slide_acceleration).max()),
        (CrankAcceleration(0.1), lambda m: np.abs(m.acceleration).max()),
        (RmsTorque(1e-3), lambda m: m.rms_motor_torque),
    ],
)
def test_limits_that_are_broken_are_named_with_what_they_come_to(limit, value):
    smooth = ready()["smooth"]
    (row,) = pp.servo.compare_motions({"smooth": smooth}, [limit]).rows
    assert f": {value(smooth):.4g}" in row.breaks


def test_limits_that_states_do_not_tell_are_said_not_to_be_looked_at():
    limits = [pp.servo.BearingForce("slide_guide", 1.0), pp.servo.TorqueRate(1.0)]
    found = pp.servo.compare_motions({"smooth": ready()["smooth"]}, limits)
    assert "Not looked at: force of 1 N in slide_guide; rate of torque of 1 N m/s." in str(found)
    with pytest.raises(pp.PinpressError, match="RmsTorque has no torque"):
        pp.servo.compare_motions(ready(), [RmsTorque()])


def test_a_pause_at_top_counts_for_the_feed_window():
    """A brake holds it, so that it has no weight in the heat."""
    press, window = pp.load("crank_slide"), FeedWindow(0.1, 15.0)
    best = pp.servo.best_motion(press, ServoDrive(inertia=2.0), time=20.0, path=Stop(), limits=[window], points=60)
    assert any("a pause of" in note for note in best.notes)
    assert not pp.servo.compare_motions({"best": best.motion}, [window]).rows[0].breaks


def test_a_drive_that_is_too_weak_is_named():
    (row,) = pp.servo.compare_motions({"smooth": ready()["smooth"]}).rows
    assert row.breaks.startswith("peak torque of 300 N m: ")


@pytest.mark.exhaustive
def test_best_motions_keep_their_limits_between_nodes():
    """What `compare_motions` takes for kept is what `best_motion` keeps: torque, its curve and power at their limits."""
    press, load = pp.load("zxn2_3000b"), [pp.loads.DeepDrawing(1.5e6, 0.06)]
    limits = [SlideSpeed(0.2, (0.06, 0.0))]
    free = pp.servo.best_motion(press, ServoDrive(inertia=800.0), load, time=2.4, limits=limits, points=180).motion
    curve = {"curve_speed": [0.0, 2.5, 4.5], "curve_torque": [1.2e5, 1.2e5, 4e4]}
    for limited in ({"peak_torque": 0.9 * free.peak_torque}, {"power": 0.9 * free.peak_power}, curve):
        drive = ServoDrive(inertia=800.0, **limited)
        best = pp.servo.best_motion(press, drive, load, time=2.4, limits=limits, points=180)
        broken = dataclasses.replace(free, drive=drive)
        rows = pp.servo.compare_motions({"best": best.motion, "free": broken}, limits).rows
        assert rows[0].breaks == ""
        assert rows[1].breaks


def test_a_controller_gets_the_law_itself():
    table = pp.servo.controller_table(ready()["smooth"], step=0.01)
    law = pp.servo.vdi_law("3-4-5")
    start = np.degrees(ready()["smooth"].angle[0])
    assert table.time == pytest.approx(0.01 * np.arange(101), abs=1e-15)
    assert table.values == pytest.approx(start + 360 * law.position(0.01 * np.arange(101)), abs=1e-5)
    assert list(table.columns()) == ["time [s]", "angle [deg]"]


def test_heights_are_those_of_the_press_and_the_last_step_is_shorter():
    press, table = pp.load("crank_slide"), pp.servo.controller_table(ready()["even"], "height", step=0.03)
    assert table.time[-2:] == pytest.approx([0.99, 1.0])
    motion = pp.servo_cycle(press, ready()["even"].angle[0] + 2 * np.pi * table.time, speed=2 * np.pi, acceleration=0.0)
    assert table.values == pytest.approx(1e3 * (motion.slide_position - pp.dead_centres(press).bottom_position), abs=1e-6)
