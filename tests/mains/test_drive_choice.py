"""The choice of motor and flywheel against an independent NumPy script in maximal coordinates (10 and 4 printed digits), closed forms of a
linear motor under a rectangular load, and a start integrated by SciPy."""

import dataclasses
from functools import cache

import numpy as np
import pytest
from scipy.integrate import quad
from support.generators.small_linkages import disc

import pinpress as pp
from pinpress.common.numerics import sign_change
from pinpress.mains.motors import start

LOAD = pp.loads.ForceStroke([0.005, 0.030], [1e5, 1e5])
CATALOGUE = {  # rated power [kW], rated speed [r/min], inertia [kg m2]
    name: pp.drives.InductionMotor(power * 1e3, speed * pp.RPM, breakdown_ratio=2.5, inertia=inertia)
    for name, power, speed, inertia in (
        ("4 kW", 4.0, 1455, 0.011),
        ("5.5 kW", 5.5, 1455, 0.018),
        ("7.5 kW", 7.5, 1455, 0.028),
        ("11 kW", 11.0, 1465, 0.055),
    )
}
ASKED = {"ratios": [15], "flywheels": (0.4, 1.6), "speeds": (90 * pp.RPM, 105 * pp.RPM), "speed_drop": 0.06, "reserve": 1.1}
CSV = "motor, rated power [kW], rated speed [r/min], breakdown ratio, inertia [kg m2], frequency [Hz]\n"


def steady(motor, inertia):
    drive = pp.drives.Geared(motor, 15.0)
    flywheel = pp.drives.Flywheel(inertia * 15.0**2)
    return pp.steady_state(pp.load("crank_slide"), motor.synchronous_speed / 15, drive=drive, flywheel=flywheel, loads=[LOAD])


def swing(duty):
    """Highest less lowest speed by the mean of both, as the script has it."""
    return 2 * (duty.highest_speed - duty.lowest_speed) / (duty.highest_speed + duty.lowest_speed)


def choose(motors=CATALOGUE, loads=(LOAD,), **changes):
    return pp.mains.choose_drive(pp.load("crank_slide"), motors, list(loads), **(ASKED | changes))


@cache
def chosen():
    return choose()


def test_steady_state_of_a_press_that_passes_the_breakdown_torque():
    motor = pp.drives.InductionMotor(5.5e3, 1485 * pp.RPM, breakdown_ratio=2.5, inertia=0.04)
    run = steady(motor, 0.8)
    duty = pp.measures.duty_cycle(run)
    assert run.time[-1] == pytest.approx(0.6109916979, abs=5e-11)
    assert duty.highest_speed == pytest.approx(10.4994326634, abs=5e-11)  # above the synchronous 10.4720: the weight drives
    assert duty.lowest_speed == pytest.approx(9.4553204827, abs=5e-11)
    assert duty.motor_rms == pytest.approx(45.24412504, abs=5e-9)
    assert motor.rated_torque == pytest.approx(35.36776513, abs=5e-9)
    assert float(motor.torque(15 * duty.lowest_speed)) == pytest.approx(70.18050146, abs=5e-9)
    assert duty.motor_peak == pytest.approx(motor.breakdown_torque, rel=1e-9)  # on the way to the lowest speed
    assert duty.load_work == pytest.approx(2500.0, rel=1e-9)


def test_catalogue():
    table = {
        "4 kW": [(1.4994, 0.2588), (1.3048, 0.1204), (1.1220, 0.0603)],
        "5.5 kW": [(1.2680, 0.2339), (1.0825, 0.1132), (0.8843, 0.0581)],
        "7.5 kW": [(1.0699, 0.2033), (0.9058, 0.1044), (0.7182, 0.0557)],
        "11 kW": [(0.8880, 0.1495), (0.7752, 0.0847), (0.6227, 0.0492)],
    }
    for name, rows in table.items():
        for inertia, expected in zip((0.4, 0.8, 1.6), rows, strict=True):
            duty = pp.measures.duty_cycle(steady(CATALOGUE[name], inertia))
            assert (duty.utilisation, swing(duty)) == pytest.approx(expected, abs=5.001e-5)


def test_the_smallest_motor_with_its_smallest_flywheel():
    best = chosen().best
    assert [row.motor for row in chosen().tried if not row.remark] == ["5.5 kW", "7.5 kW", "11 kW"]
    assert best.motor == "5.5 kW"
    assert best.flywheel < 1.6
    assert best.speed_drop == pytest.approx(0.06, rel=1e-6)
    assert best.speed_drop <= 0.06
    run = pp.steady_state(pp.load("crank_slide"), best.mean_speed, drive=chosen().drive, flywheel=chosen().flywheel, loads=[LOAD])
    again = pp.measures.duty_cycle(run)
    assert (again.speed_drop, again.motor_rms) == pytest.approx((best.speed_drop, best.rms_torque), rel=1e-9)
    assert chosen().tried[0].remark == "too warm, speed drops too much"
    assert chosen().tried[0].flywheel == 1.6
    assert "5.5 kW" in str(chosen())


def test_each_limit_decides_in_its_turn():
    motors = {"7.5 kW": CATALOGUE["7.5 kW"]}
    warm = choose({"5.5 kW": CATALOGUE["5.5 kW"]}, speed_drop=0.5).best
    assert warm.thermal == pytest.approx(1.0, rel=1e-6)
    pulled = choose(motors, speed_drop=0.5, reserve=1.5).best
    assert pulled.peak == pytest.approx(1 / 1.5, rel=1e-6)
    assert choose(motors, speed_drop=0.5, reserve=1.01, flywheels=(1.5, 1.6)).best.flywheel == 1.5  # the smallest of the range
    narrow = {"flywheels": (1.5, 1.6)}
    slow = choose(motors, start_time=1.0, **narrow)
    assert (slow.best, slow.drive, slow.tried[0].remark) == (None, None, "starts too slowly")
    assert "1.5 to 1.6 kg m2" in slow.title
    weak = pp.drives.InductionMotor(1.5e3, 1400 * pp.RPM, inertia=0.003)
    remarks = [row.remark for row in choose({"1.5 kW": weak, **motors}, ratios=[14, 17], **narrow).tried]
    assert remarks == ["too weak", "too weak", "too fast", "too slow"]


@pytest.mark.exhaustive
def test_a_motor_without_a_steady_state_stalls():
    choice = choose({"5.5 kW": CATALOGUE["5.5 kW"]}, flywheels=(0.01, 0.02))
    assert (choice.tried[0].remark, choice.tried[0].rms_torque) == ("stalls", None)


def test_backwards_is_the_same_press_mirrored():
    backwards = choose({"7.5 kW": CATALOGUE["7.5 kW"]}, speeds=(-105 * pp.RPM, -90 * pp.RPM))
    assert backwards.best.flywheel == pytest.approx(chosen().tried[2].flywheel, rel=1e-6)
    assert backwards.drive.ratio == -15


@dataclasses.dataclass(frozen=True)
class Linear(pp.drives.SpeedTorqueDrive):
    inertia: float = 0.0
    slope: float = 12.0
    synchronous: float = 157.08
    rated_torque: float = 30.0

    def torque(self, speed, angle=0.0, time=0.0, state=()):
        return self.slope * (self.synchronous - speed)


def closed_form(inertia, motor=Linear(), loads=(150.0, 8.0), times=(0.12, 0.6)):
    """Highest and lowest speed, and rms torque, of a linear motor under a load that is a rectangle over time."""
    high, low = (motor.synchronous - load / motor.slope for load in loads)
    a, b = (np.exp(-time * motor.slope / inertia) for time in times)
    fast = (low * (1 - b) + high * b * (1 - a)) / (1 - a * b)
    slow = high + (fast - high) * a
    square, tau = 0.0, inertia / motor.slope
    for load, settled, begin, time in zip(loads, (high, low), (fast, slow), times, strict=True):
        c = motor.slope * (begin - settled)  # the torque is load - c exp(-t / tau)
        square += load**2 * time - 2 * load * c * tau * (1 - np.exp(-time / tau)) + c**2 * tau / 2 * (1 - np.exp(-2 * time / tau))
    return fast, slow, np.sqrt(square / sum(times))


@pytest.mark.parametrize(
    ("inertia", "expected"),
    [
        (0.5, (156.4133271078, 145.2442610107, 51.9801819488)),
        (1.0, (156.4065907036, 147.3820476283, 44.9832512550)),
        (2.0, (156.2451477239, 150.2580369707, 37.9703931828)),
        (4.0, (155.7448886210, 152.3694784741, 33.7714342752)),
    ],
)
def test_linear_motor(inertia, expected):
    assert closed_form(inertia) == pytest.approx(expected, abs=5.1e-11)
    speed, square = expected[0], 0.0
    for load, time in ((150.0, 0.12), (8.0, 0.6)):
        own = float(disc().model.inertias[1].inertia[1, 1])
        parts = {
            "drive": Linear(),
            "flywheel": pp.drives.Flywheel(inertia - own),
            "loads": [pp.loads.PointMoment("disc", [0.0, load, 0.0])],
        }
        duty = pp.measures.duty_cycle(pp.simulate(disc(), time, speed=speed, tolerance=1e-12, **parts))
        speed = duty.lowest_speed if load > 100 else duty.highest_speed
        square += duty.motor_rms**2 * time
        assert speed == pytest.approx(expected[1 if load > 100 else 0], rel=1e-10)
    assert np.sqrt(square / 0.72) == pytest.approx(expected[2], rel=1e-10)


@pytest.mark.parametrize(("drop", "inertia"), [(0.05, 1.3832440311), (0.03, 2.7947456756), (0.02, 4.4180607510)])
def test_inertia_of_a_swing(drop, inertia):
    def excess(j):
        fast, slow, _ = closed_form(j)
        return 1.0 - drop * (fast + slow) / (2 * (fast - slow))

    assert sign_change(excess, 0.2, 20.0, 1e-12) == pytest.approx(inertia, abs=5.1e-11)


def test_start():
    motor, inertia = CATALOGUE["5.5 kW"], 1.2
    time, _ = quad(lambda speed: inertia / motor.torque(speed), 0.0, motor.rated_speed)
    heat, _ = quad(lambda speed: inertia * (motor.synchronous_speed - speed), 0.0, motor.synchronous_speed)
    assert start(motor, inertia) == pytest.approx((time, heat), rel=1e-10)


def test_catalogue_file(tmp_path):
    file = tmp_path / "motors.csv"
    file.write_text(CSV + "132S-4, 5.5, 1455, 2.5, 0.018, 50\n160-6, 7.5, 1170, 2.8, 0.09, 60\nno frequency, 3, 960, 2.2, 0.01,\n")
    motors = pp.mains.read_motors(file)
    assert motors["132S-4"] == CATALOGUE["5.5 kW"]
    assert [motor.synchronous_speed / pp.RPM for motor in motors.values()] == pytest.approx([1500, 1200, 1000])


def test_watts_under_kilowatts(tmp_path):
    file = tmp_path / "motors.csv"
    file.write_text(CSV + "132S-4, 5500, 1455, 2.5, 0.018, 50\n")
    with pytest.warns(pp.PinpressWarning, match="132S-4: its rated torque turns its own rotor up to speed in 8e-05 s"):
        pp.mains.read_motors(file)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("", "has no row"),
        (", 5.5, 1455, 2.5, 0.018, 50\n", "line 2: the row does not name a motor"),
        ("a, 5.5, 1455, 2.5, 0.018, 50\na, 5.5, 1455, 2.5, 0.018, 50\n", "line 3: a is there twice"),
        ("a, 5.5, 3000, 2.5, 0.018, 50\n", "rated speed is 314.159 rad/s; give one below that of two poles"),
        ("a, 5.5, 1500, 2.5, 0.018, 50\n", "a: InductionMotor: rated_speed is 1500 r/min, the synchronous speed"),
        ("a, 5.5, 1455, 0.9, 0.018, 50\n", "a: InductionMotor: breakdown_ratio is 0.9"),
    ],
)
def test_refused_catalogues(tmp_path, rows, message):
    file = tmp_path / "motors.csv"
    file.write_text(CSV + rows)
    with pytest.raises(pp.PinpressError, match=message):
        pp.mains.read_motors(file)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"motors": {}}, "give InductionMotors by their names"),
        ({"ratios": []}, "one or more positive gear ratios"),
        ({"speeds": (-1.0, 2.0)}, "two speeds in one direction"),
        ({"speeds": (11.0, 9.0)}, "the lower one first"),
        (
            {"speeds": (3.0, 4.0)},
            "no ratio of 15 brings a motor into 28.65 to 38.2 r/min of the crank: give a ratio of 38.1 to 50.8 for 4 kW",
        ),
        ({"flywheels": (1.6, 1.6)}, "the smallest and the largest inertia"),
        ({"speed_drop": 6.0}, "give a share below 1"),
        ({"reserve": 0.9}, "breakdown torque / largest torque, above 1"),
        ({"efficiency": 1.2}, "efficiency"),
        (
            {"loads": [pp.loads.ForceStroke([0.005, 0.030], [1e6, 1e6])]},
            "takes 37.5 kW at 90 r/min, and the largest motor has 11 kW",
        ),
    ],
)
def test_refused_choices(changes, message):
    with pytest.raises(pp.PinpressError, match=message):
        choose(**changes)
