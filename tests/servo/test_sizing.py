"""Motors of a catalogue and what a motion uses of them; capacitors."""

from pathlib import Path

import numpy as np
import pytest

import pinpress as pp
from pinpress.servo import CatalogueMotor, ServoDrive

CATALOGUE = Path(__file__).parents[2] / "docs/servo_motors.csv"
MOTOR = CatalogueMotor("short", 0.5, [0.0, 100.0, 200.0], [300.0, 280.0, 140.0], [800.0, 800.0, 400.0], 0.01)


def turning(drive, time=1.0, swing=0.4, states=4001):
    """A light press whose crank swings in speed about a mean turn, so that the torque is that of the rotor alone."""
    press = pp.load("crank_slide")
    t = np.linspace(0.0, time, states)
    rate = 2 * np.pi / time
    return pp.servo.evaluate(
        press,
        drive,
        time=t,
        angle=rate * t - swing * np.sin(rate * t),
        speed=rate - swing * rate * np.cos(rate * t),
        acceleration=swing * rate**2 * np.sin(rate * t),
    )


def test_use_of_a_motor_is_that_of_its_curves():
    drive = ServoDrive(inertia=0.5, ratio=10.0, gear_inertia=1e8)
    rate, swing = 2 * np.pi, 0.4
    motor = CatalogueMotor("great", 0.5, [0.0, 100.0, 200.0], [3e9, 2.8e9, 1.4e9], [8e9, 8e9, 4e9])
    use = pp.servo.motor_use(motor, turning(drive), pause=0.5)
    torque = drive.crank_inertia * swing * rate**2 / 10.0
    assert use.rms_torque == pytest.approx(torque / np.sqrt(2) * np.sqrt(1 / 1.5), rel=1e-5)
    assert use.mean_speed == pytest.approx(10 * rate / 1.5, rel=1e-6)
    assert use.thermal == pytest.approx(use.rms_torque / (3e9 - 2e6 * use.mean_speed), rel=1e-12)
    assert use.peak == pytest.approx(torque / 8e9, rel=1e-5)
    assert use.speed == pytest.approx(10 * 1.4 * rate / 200.0, rel=1e-6)
    assert use.suffices


def test_the_peak_is_looked_for_over_the_whole_curve():
    torque = np.interp(150.0, [100.0, 200.0], [800.0, 400.0])
    assert MOTOR.peak_torque_at([-150.0, 150.0, 0.0]).tolist() == [torque, torque, 800.0]
    assert MOTOR.rated_torque_at(50.0) == pytest.approx(290.0)
    assert MOTOR.rated_power == 28e3


def test_a_limited_drive_is_below_the_curve():
    whole, part, most = MOTOR.drive(20.0), MOTOR.drive(20.0, up_to=150.0), MOTOR.drive(20.0, up_to=900.0)
    assert (whole.top_speed, whole.peak_torque) == (200.0, 800.0)
    assert (part.top_speed, part.peak_torque) == (150.0, 600.0)
    assert (most.top_speed, most.peak_torque) == (200.0, 400.0)
    assert (part.inertia, part.copper, part.rated_torque) == (0.5, 0.01, 300.0)


def test_capacitor_of_a_rotor_that_swings():
    # power = J w' w, whose energy is J w^2/2: the swing is that of the kinetic energy
    drive = ServoDrive(inertia=1e7)
    found = pp.servo.capacitor(turning(drive), 700.0, 500.0)
    rate = 2 * np.pi
    swing = 0.5 * 1e7 * rate**2 * (1.4**2 - 0.6**2)
    assert found.energy_swing == pytest.approx(swing, rel=1e-5)
    assert found.capacitance == pytest.approx(2 * swing / (700.0**2 - 500.0**2), rel=1e-5)
    assert found.mean_power == pytest.approx(0.0, abs=1e-4 * found.peak_power)


def test_the_example_catalogue_is_read():
    motors = pp.servo.read_motors(CATALOGUE)
    assert [motor.name for motor in motors] == [f"example {size}" for size in (150, 300, 500, 800, 1200, 1800)]
    assert motors[3].speed == pytest.approx([0.0, 1200 * pp.RPM, 2000 * pp.RPM])
    assert (motors[3].inertia, motors[3].copper, motors[3].rated_torque[1], motors[3].peak_torque[2]) == (1.5, 0.0048, 720.0, 1150.0)
    powers = [motor.rated_power for motor in motors]
    assert powers == sorted(powers)


def test_the_smallest_motor_that_suffices_is_chosen():
    drawing, limit = pp.loads.DeepDrawing(1.5e6, 0.06), pp.servo.SlideSpeed(0.2, (0.06, 0.0))
    asked = {"ratios": [50.0, 60.0], "time": 2.4, "limits": [limit], "gear_inertia": 50.0, "points": 180}
    small, middle, large = pp.servo.read_motors(CATALOGUE)[2:5]
    found = pp.servo.choose_motor(pp.load("zxn2_3000b"), [large, middle, small], [drawing], **asked)
    assert found.motor is middle
    assert found.use.ratio == 60.0
    assert [(each.motor, each.ratio) for each in found.tried] == [(m.name, i) for m in (small, middle) for i in (50.0, 60.0)]
    assert [each.remark for each in found.tried[:2]] == ["too warm", "too warm"]
    assert found.use == pp.servo.motor_use(middle, found.best.motion)
    assert found.use.suffices
    assert "MotorChoice for zxn2_3000b: example 800, ratio 60, 60" in str(found)
    none = pp.servo.choose_motor(pp.load("zxn2_3000b"), [small], [drawing], **asked)
    assert none.motor is none.best is none.use is None
    assert "none of the motors suffices" in str(none)
    rested = pp.servo.choose_motor(pp.load("zxn2_3000b"), [small], [drawing], pause=6.0, **asked | {"ratios": [80.0]})
    assert rested.tried[0].thermal < 1


HEAD = "motor,inertia [kg m2],copper loss [W/(N m)2],speed [r/min],rated torque [N m],peak torque [N m]\n"


@pytest.mark.parametrize(("speed", "torque", "by", "times"), [("rpm", "Nm", 1.0, 1.0), ("rad/s", "kNm", 2 * np.pi / 60, 1e-3)])
def test_a_catalogue_is_read_in_any_unit(speed, torque, by, times, tmp_path):
    rows = "".join(f"x,0.25,0.012,{by * n},{times * 280},{times * 700}\n" for n in (0.0, 1500.0))
    head = f"motor,inertia (kg m2),copper loss [W/(N m)2],speed [{speed}],rated torque [{torque}],peak torque ({torque})\n"
    (tmp_path / "motors.csv").write_text(head + rows)
    (motor,) = pp.servo.read_motors(tmp_path / "motors.csv")
    np.testing.assert_allclose(motor.speed, [0.0, 1500 * pp.RPM])
    np.testing.assert_allclose([*motor.rated_torque, *motor.peak_torque], [280.0, 280.0, 700.0, 700.0])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "is empty"),
        ("motor,speed\n", r"no column 'inertia \[kg m2\]'"),
        (HEAD.replace("speed [r/min]", "sped [r/min]"), r"no column 'speed \[r/min\]'; column 'sped' is unknown, did you mean 'speed'"),
        (HEAD.replace(" [r/min]", ""), r"column 'speed' has no unit: write e\.g\. 'speed \[r/min\]'"),
        (HEAD.replace("[r/min]", "[m/s]"), r"column 'speed' is in 'm/s', which is none of rad/s, r/min, rpm"),
        (HEAD, "has no row under its heads"),
        (HEAD + "a,1,0,0,10,20\na,1,0,zero,10,20\n", r"line 3, speed: 'zero' is no number"),
        (HEAD + "a,1,0,0,10,20\na,2,0,100,10,20\n", "a has several values of its inertia"),
        (HEAD + "a,1,0,0,30,20\na,1,0,100,10,20\n", "at 0 r/min the rated torque is above the peak torque"),
        (HEAD + "a,1,0,5,10,20\na,1,0,100,10,20\n", "speeds do not rise from 0"),
        (HEAD + "a,1,0,0,10,20\n", "two or more speeds"),
        (HEAD + "a,1,0,0,9,9\na,1,0,9,9,9\nb,1,0,0,9,9\nb,1,0,9,9,9\na,1,0,0,9,9\na,1,0,9,9,9\n", "other rows separate the rows of"),
        (HEAD + ",1,0,0,10,20\n", "line 2: the row does not name a motor"),
    ],
)
def test_what_is_no_catalogue_is_refused(content, words, tmp_path):
    path = tmp_path / "motors.csv"
    path.write_text(content)
    with pytest.raises(pp.PinpressError, match=words):
        pp.servo.read_motors(path)
