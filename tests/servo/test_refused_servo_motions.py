"""What motions, motors and tables of servo presses refuse, each with its message: a table of (call, message)."""

import dataclasses
from functools import cache

import pinocchio as pin
import pytest

import pinpress as pp
from pinpress import servo
from pinpress.servo import CatalogueMotor, ServoDrive, SlideSpeed, Stop, Turn

DRIVE = ServoDrive(inertia=800.0, copper=1e-5, regeneration=0.0)
LIMIT = SlideSpeed(0.2, heights=(0.06, 0.0))
MOTOR = CatalogueMotor("short", 0.5, [0.0, 100.0, 200.0], [300.0, 280.0, 140.0], [800.0, 800.0, 400.0], 0.01)


@cache
def press(name):
    return pp.load(name)


@cache
def even(name):
    """A motion at constant crank speed, whose drive has a rotor of 3 kg m2."""
    return servo.constant_crank_speed(press(name), ServoDrive(inertia=3.0), time=1.0)


def even_of_a_heavier_press():
    model = press("thin_wall").model.copy()
    model.inertias[1] = pin.Inertia(2 * model.inertias[1].mass, model.inertias[1].lever, model.inertias[1].inertia)
    return servo.constant_crank_speed(dataclasses.replace(press("thin_wall"), model=model), ServoDrive(inertia=3.0), time=1.0)


def two_speed(limit=LIMIT, **options):
    return servo.two_speed(press("zxn2_3000b"), DRIVE, limit=limit, **{"time": 2.4, **options})


def cubic(path):
    return servo.motion_by_law(press("zxn2_3000b"), DRIVE, "cubic", time=2.4, path=path)


REFUSALS = [
    (lambda: two_speed(path=Stop()), "path has rests"),
    (lambda: two_speed(time=6.0), r"at constant crank speed the slide reaches at most 0\.13"),
    (lambda: two_speed(time=0.5), r"the window of heights alone takes 0\.9"),
    (
        lambda: servo.constant_slide_speed(press("zxn2_3000b"), DRIVE, time=0.2, limit=LIMIT),
        r"the window of heights alone takes 0\.3 s",
    ),
    (lambda: two_speed(SlideSpeed(0.2, (0.5, 0.4))), r"above the stroke of 0\.301261 m"),
    (lambda: two_speed(SlideSpeed(0.2, flank="up")), "limit holds on the way up"),
    (lambda: cubic(Turn()), "the laws go from rest to rest"),
    (lambda: cubic(Stop(bottom=3.0)), "the path rests for 3 s"),
    (lambda: servo.vdi_law("bestehorn"), "no motion law 'bestehorn', did you mean 'Bestehorn'"),
    (lambda: servo.vdi_law("cubic").position(1.5), r"time is 1\.5: give times from 0 to 1"),
    (lambda: servo.compare_motions({}), "no motions to compare"),
    (lambda: servo.compare_motions({"one": even("crank_slide"), "other": even("thin_wall")}), "belong to several presses"),
    (lambda: servo.compare_motions({"one": even("thin_wall"), "other": even_of_a_heavier_press()}), "belong to several presses"),
    (lambda: servo.controller_table(even("crank_slide"), "depth"), "give 'angle' or 'height'"),
    (lambda: servo.controller_table(even("crank_slide"), step=1e-9), "would have 999999999 rows"),
    (lambda: servo.motor_use(MOTOR, even("crank_slide")), r"whose rotor has 3 kg m2, but short has 0\.5"),
    (lambda: servo.capacitor(even("crank_slide"), 400.0, 500.0), "not above the lower_voltage"),
    (lambda: servo.read_motors("missing.csv"), r"missing\.csv cannot be read"),
    (
        lambda: servo.choose_motor(press("crank_slide"), [MOTOR], ratios=[10.0], time=0.1, limits=[servo.CrankSpeed(10.0)], points=60),
        "no motion of crank_slide keeps the",
    ),
    (lambda: ServoDrive(inertia=0.0), "inertia is 0"),
    (lambda: ServoDrive(inertia=1.0, regeneration=1.5), "a share from 0 to 1"),
    (lambda: ServoDrive(1.0, curve_speed=[0.0, 9.0]), "one torque for each speed"),
    (lambda: ServoDrive(1.0, curve_speed=[0.0, 9.0], curve_torque=[1.0, 2.0]), "torques in curve_torque that do not rise"),
    (lambda: ServoDrive(1.0, curve_speed=[0.0, 9.0], curve_torque=[2.0, 1.0], top_speed=10.0), "extend the curve to top_speed"),
    (lambda: SlideSpeed(0.0), "positive"),
    (lambda: SlideSpeed(0.1, (0.1, 0.1)), "two different heights"),
    (lambda: SlideSpeed(0.1, flank="left"), 'give "down", "up" or "both"'),
    (lambda: servo.Pulse((0.01, 0.02)), "falling heights"),
    (lambda: servo.Stop(bottom=-1.0), "not negative"),
]


@pytest.mark.parametrize(("call", "message"), REFUSALS, ids=[message for _, message in REFUSALS])
def test_refusals(call, message):
    with pytest.raises(pp.PinpressError, match=message):
        call()
