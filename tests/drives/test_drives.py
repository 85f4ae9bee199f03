"""Drives: their torque curves against closed forms, nameplates and printed formulas; gears by their power; servo and clutch in motion."""

import dataclasses
import itertools
import math
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from support.exploring import examples

import pinpress as pp
from pinpress.drives.motors import ConstantTorque, InductionMotor, InverterMotor, ServoMotor
from pinpress.drives.protocol import Drive, corners_of
from pinpress.drives.slip_clutch import SlipClutchMotor
from pinpress.drives.transmission import Flywheel, Geared, PrescribedSpeed

RPM = pp.RPM
ROUNDING = 1e-12  # relative: a few operations on numbers near each other

# Kong 2025: the motor of the ZXN2-3000(B), on the mains and on its inverter.
KONG = InductionMotor(75e3, 1485 * RPM, inertia=0.7)
CONVERTED = InverterMotor(482.0, 1485 * RPM, 40.0)
# Zhang 2007, table 4-1: YCT280-4A. It does not print the speed of the driving half: 1470 r/min, of a usual 30 kW motor, is ours.
YCT = SlipClutchMotor(189.0, 1470 * RPM, 1320 * RPM, 900 * RPM)
LAGGING = dataclasses.replace(YCT, lag=0.2)
SERVO = ServoMotor((0.0, 0.5, 1.5, 2.0), (0.0, 3.0, 5.0, 4.0), 2000.0, 90.0, 700.0, rated_torque=250.0)

BY_SPEED = {
    "constant": ConstantTorque(567.0),
    "induction": KONG,
    "inverter": CONVERTED,
    "weakened": dataclasses.replace(CONVERTED, frequency=100.0),
    "clutch": YCT,
    "geared": Geared(KONG, 20.0, 3.0),
    "geared_lossy": Geared(KONG, 20.0, 3.0, 0.9),
    "geared_backwards": Geared(CONVERTED, -20.0, 3.0, 0.9),
    "geared_twice": Geared(Geared(CONVERTED, 4.0, efficiency=0.95), -5.0, 3.0, 0.9),
    "geared_lossy_behind": Geared(Geared(KONG, 4.0), 5.0, 3.0, 0.9),
    "geared_clutch": Geared(YCT, 3.0, efficiency=0.9),
}
DRIVES: dict[str, Any] = BY_SPEED | {
    "lagging": LAGGING,
    "servo": SERVO,
    "geared_lagging": Geared(LAGGING, 3.0),
    "geared_servo": Geared(SERVO, -8.0, 1.0, 0.8),
}


@pytest.fixture(params=DRIVES)
def drive(request):
    return DRIVES[request.param]


@pytest.fixture(params=BY_SPEED)
def steady(request):
    return BY_SPEED[request.param]


# ------------------------------------------------------------------------------------------------------------------- what all drives share


def test_every_drive_is_one(drive):
    assert isinstance(drive, Drive)
    at = itertools.product((0.01, 0.5), (0.0, 0.5), [tuple(c for _ in drive.state) for c in (0.3, 0.6)])
    assert drive.timed == (len({drive.torque(0.1, *depends) for depends in at}) > 1)  # on angle, time or state
    assert len(drive.rates(1.0, 0.0, 0.0, drive.state)) == len(drive.state)
    assert not (drive.timed and set(drive.corners) - {0.0})  # where losses of gears jump


def test_what_has_no_torque_is_no_drive():
    assert not isinstance(Flywheel(1.0), Drive)
    assert not isinstance(PrescribedSpeed(1.0), Drive)


def test_a_class_of_the_users_own_can_drive():
    class Fan:
        inertia, state, timed, rated_torque, corners = 2.0, (), False, 10.0, (0.0,)

        def torque(self, speed, angle=0.0, time=0.0, state=()):
            return -0.1 * speed * abs(speed)

        def rates(self, speed, angle=0.0, time=0.0, state=()):
            return ()

        def motor_speed(self, speed):
            return speed

        motor_torque = torque

    geared = Geared(Fan(), 3.0)
    assert isinstance(Fan(), Drive)
    assert geared.torque(2.0) == pytest.approx(-3 * 0.1 * 36, rel=ROUNDING)
    assert (geared.inertia, geared.rated_torque, geared.corners) == (18.0, 10.0, (0.0,))


@examples(100)
@given(st.sampled_from(sorted(DRIVES)), st.floats(-1e100, 1e100), st.floats(-1e6, 1e6), st.floats(0, 1e6), st.floats(0, 1))
def test_finite_at_every_speed(name, speed, angle, time, current):
    drive = DRIVES[name]
    state = tuple(current for _ in drive.state)
    for given_speed in (speed, np.array([speed])):
        results = [drive.torque(given_speed, angle, time, state), drive.motor_torque(given_speed, angle, time, state)]
        assert np.all(np.isfinite([*results, *drive.rates(given_speed, angle, time, state)]))


SPEEDS = np.concatenate([np.linspace(-400, 400, 41), [0.0, -1e-300, 1e9, -1e9]])


def test_arrays_against_numbers(drive):
    """The same operations, so the same digits: only NumPy's root and powers may round otherwise."""
    angles, times = np.linspace(-1, 9, len(SPEEDS)), np.linspace(-0.3, 2.5, len(SPEEDS))
    states = tuple(np.linspace(0, 1, len(SPEEDS)) for _ in drive.state)
    at = [
        (float(w), float(a), float(t), tuple(float(s[i]) for s in states))
        for i, (w, a, t) in enumerate(zip(SPEEDS, angles, times, strict=True))
    ]
    for method in (drive.torque, drive.motor_torque):
        one_by_one = [method(*arguments) for arguments in at]
        assert all(type(torque) is float for torque in one_by_one)
        np.testing.assert_allclose(method(SPEEDS, angles, times, states), one_by_one, rtol=1e-15)
    np.testing.assert_allclose(
        drive.torque(SPEEDS[:, None], 0.3, 0.4, drive.state)[:, 0], drive.torque(SPEEDS, 0.3, 0.4, drive.state), rtol=1e-15
    )
    for index, rate in enumerate(drive.rates(SPEEDS, angles, times, states)):
        np.testing.assert_allclose(rate, [drive.rates(*arguments)[index] for arguments in at], rtol=1e-15)


def test_smooth_between_corners(steady):
    """Second differences shrink with the square of the step where the curve is smooth, with the step at a kink, not at all at a jump."""
    corners = sorted(steady.corners)
    for low, high in itertools.pairwise([-400.0, *[c for c in corners if abs(c) < 400], 400.0]):
        inside = (high - low) * 1e-6
        coarse, fine = (np.abs(np.diff(steady.torque(np.linspace(low + inside, high - inside, n)), 2)).max() for n in (20001, 40001))
        scale = np.abs(steady.torque(np.linspace(low, high, 1001))).max()
        assert fine <= max(coarse / 3.5, 1e-10 * scale)  # below that: rounding of differences


def test_kinks_at_corners(steady):
    """Torque goes on through each corner, but for the jump of a lossy gear at standstill; its slope or curvature does not."""
    for corner in steady.corners:
        h = 1e-4
        before, at, after = (float(steady.torque(corner + k)) for k in (-1e-9, 0.0, 1e-9))
        if corner == 0.0:
            assert abs(after - before) > 0.1 * abs(at)
            continue
        scale = np.abs(steady.torque(np.linspace(-400.0, 400.0, 101))).max()
        assert abs(after - before) < 1e-6 * scale
        left, right = (np.diff(steady.torque(corner + sign * h * np.arange(1, 4)), 2)[0] / h**2 for sign in (-1, 1))
        slopes = [(float(steady.torque(corner + sign * h)) - at) / (sign * h) for sign in (-1, 1)]
        assert abs(slopes[1] - slopes[0]) > 1e-3 * max(map(abs, slopes)) or abs(left - right) > 1e-3 * max(abs(left), abs(right))


def test_scipy_is_imported_only_by_a_servo():
    program = "import sys, pinpress.drives; assert not [m for m in sys.modules if m.split('.')[0] == 'scipy'], 'scipy'"
    subprocess.run([sys.executable, "-c", program], check=True)


# ------------------------------------------------------------------------------------------------------ flywheel, constant torque and speed


def test_flywheel_and_prescribed_speed():
    assert (Flywheel(136).inertia, Flywheel(136).speed, Flywheel(0.0, -3).speed) == (136.0, None, -3.0)
    several = Flywheel([100, 136, 200])
    np.testing.assert_array_equal(several.inertia, [100.0, 136.0, 200.0])
    with pytest.raises(ValueError, match="read-only"):
        several.inertia[0] = 1.0
    assert PrescribedSpeed(-7).speed == -7.0


def test_constant_torque():
    assert ConstantTorque(567).torque(31.4) == 567.0
    assert ConstantTorque(-5.0).torque(np.zeros((4, 2))).shape == (4, 2)
    assert ConstantTorque(-5.0).inertia == 0.0
    np.testing.assert_array_equal(ConstantTorque([1.0, 2.0]).torque(np.zeros((3, 2))), [[1.0, 2.0]] * 3)
    np.testing.assert_array_equal(ConstantTorque([1.0, 2.0]).torque(7.0), [1.0, 2.0])


# ------------------------------------------------------------------------------------------------------------------------- induction motor


@pytest.mark.parametrize("motor", [KONG, InductionMotor(30e3, 960 * RPM, 50.0, 6, 2.1), InductionMotor(1e3, 2900 * RPM, 60.0, 2, 1.05)])
def test_nameplate(motor):
    rated = motor.torque(motor.rated_speed)
    assert rated == pytest.approx(motor.rated_torque, rel=1e-11)  # the slip is a small difference of speeds
    assert rated * motor.rated_speed == pytest.approx(motor.rated_power, rel=1e-11)
    assert motor.synchronous_speed == pytest.approx(motor.frequency * 60 / (motor.poles / 2) * RPM, rel=ROUNDING)
    assert motor.torque(motor.synchronous_speed) == 0.0
    assert motor.torque(motor.breakdown_speed) == pytest.approx(motor.breakdown_ratio * motor.rated_torque, rel=ROUNDING)
    assert motor.torque(motor.breakdown_speed) == pytest.approx(motor.breakdown_torque, rel=ROUNDING)
    assert motor.torque(np.linspace(-500.0, 800.0, 100001)).max() <= motor.breakdown_torque * (1 + ROUNDING)


def test_kong_rated_torque():
    """Kong 2025 prints 482 N m beside 75 kW at 1485 r/min."""
    assert round(KONG.rated_torque) == 482


def test_kloss_formula_as_printed():
    """T = 2 Tb / (s / sb + sb / s), with sb found by a root search instead of the quadratic: through the rated point, stable side."""
    synchronous = 1500 * RPM
    rated_slip, rated, breakdown = 15 / 1500, 75e3 / (1485 * RPM), 2.5 * 75e3 / (1485 * RPM)
    breakdown_slip = brentq(lambda sb: 2 * breakdown / (rated_slip / sb + sb / rated_slip) - rated, rated_slip, 1.0, xtol=1e-16)
    speed = np.array([-1500.0, -10.0, 0.0, 700.0, 1430.0, 1499.0, 1501.0, 1570.0, 4000.0]) * RPM
    slip = (synchronous - speed) / synchronous
    np.testing.assert_allclose(KONG.torque(speed), 2 * breakdown / (slip / breakdown_slip + breakdown_slip / slip), rtol=1e-11)


def test_generator_and_plugging():
    off = np.linspace(0.0, 500.0, 51)
    synchronous = KONG.synchronous_speed
    np.testing.assert_allclose(KONG.torque(synchronous + off), -KONG.torque(synchronous - off), rtol=1e-11)
    assert np.all(KONG.torque(np.linspace(-500.0, -1.0, 9)) > 0)  # against the motion


def test_motor_sizes_as_scenarios():
    powers = np.array([55e3, 75e3, 90e3])
    motors = InductionMotor(powers, 1485 * RPM, inertia=[0.5, 0.7, 0.9])
    singles = [InductionMotor(power, 1485 * RPM) for power in powers]
    speed = np.linspace(1400.0, 1520.0, 12).reshape(4, 3) * RPM
    np.testing.assert_allclose(motors.torque(speed), np.stack([m.torque(speed[:, i]) for i, m in enumerate(singles)], axis=-1), rtol=1e-15)
    np.testing.assert_allclose(motors.torque(1480 * RPM), [m.torque(1480 * RPM) for m in singles], rtol=1e-15)
    np.testing.assert_allclose(motors.rated_torque, [m.rated_torque for m in singles], rtol=1e-15)
    geared = Geared(motors, -20.0, [1.0, 2.0, 3.0], 0.9)
    np.testing.assert_allclose(geared.inertia, 400 * np.array([0.5, 0.7, 0.9]) + [1.0, 2.0, 3.0], rtol=ROUNDING)
    alone = [Geared(m, -20.0, efficiency=0.9).torque(speed[:, i] / 20) for i, m in enumerate(singles)]
    np.testing.assert_allclose(geared.torque(speed / 20), np.stack(alone, axis=-1), rtol=1e-15)


# -------------------------------------------------------------------------------------------------------------------------- inverter motor


def inverter(frequency, **more):
    return InverterMotor(482.0, 1485 * RPM, frequency, **more)


def test_on_the_mains_frequency_it_is_the_straightened_induction_motor():
    """At 50 Hz: rated torque at rated speed; beside Kloss's curve of the same motor its slope at synchronous speed is that of the chord."""
    motor, synchronous = inverter(50.0), 1500 * RPM
    assert motor.torque(1485 * RPM) == pytest.approx(482.0, rel=1e-11)
    assert motor.torque(synchronous) == pytest.approx(0.0, abs=1e-9)
    lag = 3 * RPM  # a fifth of the rated slip, where Kloss's curve is 2.5 * 2 x / (1 + x^2), x = s / sb
    x = 0.2 * (2.5 - math.sqrt(2.5**2 - 1))
    assert KONG.torque(synchronous - lag) / motor.torque(synchronous - lag) == pytest.approx(
        25 * x / (1 + x * x) * KONG.rated_torque / 482.0, rel=1e-11
    )


@pytest.mark.parametrize("frequency", [5.0, 24.6, 40.0, 50.0])
def test_constant_flux(frequency):
    """The same torque at the same lag behind the synchronous speed, whatever the frequency."""
    motor = inverter(frequency)
    assert motor.synchronous_speed == pytest.approx(30 * frequency * RPM, rel=ROUNDING)
    assert motor.torque((30 * frequency - 15) * RPM) == pytest.approx(482.0, rel=1e-11)
    assert motor.torque((30 * frequency + 15) * RPM) == pytest.approx(-482.0, rel=1e-11)
    assert motor.torque_limit(frequency) == 1.5 * 482.0
    assert sorted(motor.corners) == pytest.approx([(30 * frequency - 22.5) * RPM, (30 * frequency + 22.5) * RPM], rel=1e-11)


def test_range_of_the_press():
    """Kong 2025: 724.9 to 1450 r/min. Under rated torque those speeds take 24.66 and 48.83 Hz, within constant flux."""
    for speed in (724.9, 1450.0):
        assert inverter((speed + 15) / 30).torque(speed * RPM) == pytest.approx(482.0, rel=1e-11)


def test_field_weakening():
    """Twice the rated frequency: a quarter of the slope; permanent torque that falls with 1 / f would be rated power."""
    motor = inverter(100.0, overload=1.0)
    assert motor.torque((3000 - 15) * RPM) == pytest.approx(482.0 / 4, rel=1e-11)
    assert motor.torque_limit(100.0) == pytest.approx(241.0, rel=ROUNDING)
    assert motor.torque_limit(100.0) * 3000 == pytest.approx(482.0 * 1500, rel=ROUNDING)
    assert motor.torque(0.0) == 241.0
    assert motor.torque(1e6) == -241.0
    assert motor.corners[0] == pytest.approx((3000 - 30) * RPM, rel=1e-11)  # half the torque at a quarter of the slope: twice the lag


def test_torque_limit_over_frequency():
    motor = inverter(50.0)
    frequency = np.array([1.0, 25.0, 50.0, 60.0, 80.0, 83.3333333333333, 90.0, 100.0, 200.0])
    overload, breakdown = 1.5 * 482 * 50 / frequency, 2.5 * 482 * (50 / frequency) ** 2  # meet at 50 x 2.5 / 1.5 = 83.3 Hz
    expected = np.where(frequency <= 50, 723.0, np.where(frequency < 83.33, overload, breakdown))
    np.testing.assert_allclose(motor.torque_limit(frequency), expected, rtol=1e-12)
    assert type(motor.torque_limit(60.0)) is float
    assert inverter(50.0, overload=4.0).torque_limit(50.0) == 2.5 * 482.0  # more than the motor can do
    for f in frequency:
        assert inverter(f).torque(-1e3) == pytest.approx(motor.torque_limit(f), rel=ROUNDING)


def test_catalogue_curve():
    curve = [(5, 400), (50, 482.0), (100.0, 200.0)]
    motor = inverter(75.0, curve=curve)
    assert motor.torque_limit(75.0) == 341.0
    assert motor.torque_limit(5.0) == 400.0
    assert motor.torque_limit(100) == 200.0
    np.testing.assert_allclose(motor.torque_limit(np.array([27.5, 50.0])), [441.0, 482.0], rtol=ROUNDING)
    assert motor.torque(0.0) == 341.0
    assert motor.torque((75 * 30 - 9) * RPM) == pytest.approx(482 / 15 * 9 * (2 / 3) ** 2, rel=1e-11)  # the slope is that of the flux
    with pytest.raises(pp.PinpressError, match=r"off its curve, which spans 5 to 100 Hz"):
        motor.torque_limit(101.0)


# -------------------------------------------------------------------------------------------------------------------------- slip clutch


@pytest.mark.parametrize("set_speed", [132.0, 400.0, 900.0, 1320.0])
def test_slip_clutch(set_speed):
    """Formula (4.3.1) of Zhang 2007 at every speed with torque, K from the top of the speed range; regulation met; it never brakes."""
    motor = dataclasses.replace(YCT, set_speed=set_speed * RPM)
    K = (1470 - 1320) * RPM / 189.0**2
    speed = np.linspace(-500.0, set_speed - 0.01, 500) * RPM
    current, torque = motor.excitation(speed), motor.torque(speed)
    assert np.all((current > 0) & (current <= 1))
    np.testing.assert_allclose(1470 * RPM - K * torque**2 / current**4, speed, rtol=1e-11, atol=1e-10)
    assert motor.torque(set_speed * (1 - 0.025) * RPM) == pytest.approx(189.0, rel=1e-11)
    above = np.linspace(set_speed, 3000.0, 50) * RPM
    assert np.all(np.abs(motor.torque(above)) <= 1e-20)  # the set speed itself may round either way
    assert np.all(motor.torque(above[1:]) == 0.0)


def test_slip_clutch_amplifier():
    """A straight line from nothing at the set speed, with the gain that the regulation asks for, to the largest current."""
    rated_drop = 0.025 * 900 * RPM
    rated_current = (150 / (1470 - 900 * 0.975)) ** 0.25
    assert YCT.gain == pytest.approx(rated_current / rated_drop, rel=ROUNDING)
    saturated, idle = YCT.corners
    assert idle == 900 * RPM
    assert saturated == pytest.approx(900 * RPM - rated_drop / rated_current, rel=ROUNDING)
    assert YCT.excitation(saturated) == pytest.approx(1.0, rel=ROUNDING)
    assert YCT.excitation(saturated - 1.0) == 1.0
    assert YCT.excitation((saturated + idle) / 2) == pytest.approx(0.5, rel=ROUNDING)
    assert YCT.excitation(idle + 1.0) == 0.0


def test_slip_clutch_at_standstill_and_at_full_excitation():
    assert YCT.torque(0.0) == pytest.approx(189.0 * math.sqrt(1470 / 150), rel=ROUNDING)
    assert LAGGING.torque(1320 * RPM, state=(1.0,)) == pytest.approx(189.0, rel=1e-11)
    assert LAGGING.torque(1320 * RPM, state=(0.5,)) == pytest.approx(189.0 / 4, rel=1e-11)
    assert LAGGING.torque(1470 * RPM, state=(1.0,)) == 0.0
    assert LAGGING.torque(1600 * RPM, state=(1.0,)) == 0.0


def test_slip_power():
    """What the driving motor gives, T n0, is shaft power and slip power; at 1320 r/min under rated torque the shaft has 1320/1470 of it."""
    motor = dataclasses.replace(YCT, set_speed=1320 * RPM)
    speed = np.linspace(0.0, 1320.0, 12) * RPM
    np.testing.assert_allclose(motor.slip_power(speed) + motor.torque(speed) * speed, motor.torque(speed) * 1470 * RPM, rtol=ROUNDING)
    assert LAGGING.slip_power(1320 * RPM, state=(1.0,)) == pytest.approx(189.0 * 150 * RPM, rel=1e-11)


def test_lag_of_the_excitation():
    """Shaft held below the saturated corner: the current rises as 1 - exp(-t / lag), and settles where the motor without a lag is."""
    assert LAGGING.timed
    assert LAGGING.state == (0.0,)
    for speed in (0.0, 890 * RPM):
        end = LAGGING.excitation(speed)
        times = np.linspace(0.0, 4.0, 41)
        run = solve_ivp(
            lambda t, y, w=speed: LAGGING.rates(w, 0.0, t, (y[0],)), (0, 4.0), LAGGING.state, t_eval=times, rtol=1e-10, atol=1e-12
        )
        np.testing.assert_allclose(run.y[0], end * (1 - np.exp(-times / 0.2)), atol=1e-8)  # of the integration
        assert LAGGING.torque(speed, state=(run.y[0, -1],)) == pytest.approx(YCT.torque(speed), rel=1e-7)  # exp(-20), twice
        assert LAGGING.torque(speed) == YCT.torque(speed)


def test_current_that_lags_drives_on_above_the_set_speed():
    """It dies away with the same time constant; meanwhile the clutch pulls, but never backwards."""
    speed = 950 * RPM
    assert LAGGING.rates(speed, state=(0.6,)) == (pytest.approx(-3.0, rel=ROUNDING),)
    assert LAGGING.torque(speed, state=(0.6,)) > 0


# -------------------------------------------------------------------------------------------------------------------------------- servo


def test_program_of_two_points_is_the_cubic_step():
    """Standing still at both ends, one piece: a + (b - a)(3 u^2 - 2 u^3)."""
    motor = ServoMotor([1.0, 3.0], [-2.0, 4.0], 1.0, 0.0, 1.0)
    for time in (1.0, 1.3, 2.0, 2.9, 3.0):
        u = (time - 1.0) / 2.0
        assert motor.program(time) == pytest.approx((-2 + 6 * (3 * u**2 - 2 * u**3), 18 * (u - u**2)), abs=1e-14)
    assert motor.program(0.0) == motor.program(-5.0) == (-2.0, 0.0)
    assert motor.program(3.5) == motor.program(1e6) == (4.0, 0.0)


def test_program_goes_through_its_points_without_jumps():
    before, after = np.array(SERVO.times) - 1e-9, np.array(SERVO.times) + 1e-9
    np.testing.assert_allclose(SERVO.program(np.array(SERVO.times))[0], SERVO.angles, atol=1e-14)
    for left, right in zip(SERVO.program(before), SERVO.program(after), strict=True):
        np.testing.assert_allclose(left, right, atol=1e-7)  # 2e-9 s at some 20 rad/s2
    dt = 1e-6
    times = np.linspace(-0.5, 2.5, 301) + 1e-4
    numeric = (SERVO.program(times + dt)[0] - SERVO.program(times - dt)[0]) / (2 * dt)
    np.testing.assert_allclose(SERVO.program(times)[1], numeric, atol=1e-8)
    assert SERVO.program(0.7) == pytest.approx([float(v[0]) for v in SERVO.program(np.array([0.7]))], rel=1e-15)


def test_servo_torque_and_its_limit():
    assert SERVO.torque(0.25, 3.9, 9.0) == pytest.approx(2000 * 0.1 - 90 * 0.25, rel=1e-11)
    assert SERVO.torque(0.0, 0.0, 9.0) == 700.0
    assert SERVO.torque(0.0, 9.0, 9.0) == -700.0
    assert (SERVO.timed, SERVO.corners, SERVO.state, SERVO.rated_torque) == (True, (), (), 250.0)


def test_servo_moves_an_inertia():
    """A critically damped servo on an inertia J, one cubic piece of acceleration alpha(t) = A (1 - 2 u): the angle error e follows
    e'' + 2 w e' + w^2 e = alpha, so e = p + q t + (c1 + c2 t) exp(-w t), w^2 = stiffness / J."""
    J, w, T, lift = 3.0, 25.0, 0.8, 2.0
    motor = ServoMotor([0.0, T], [0.0, lift], J * w**2, 2 * J * w, 1e9)
    run = solve_ivp(
        lambda t, y: (y[1], motor.torque(y[1], y[0], t) / J), (0.0, T), (0.0, 0.0), t_eval=np.linspace(0, T, 30), rtol=1e-10, atol=1e-12
    )
    t, A = run.t, 6 * lift / T**2
    q = -2 * A / T / w**2
    p = (A - 2 * w * q) / w**2
    c1 = -p
    c2 = w * c1 - q
    u = t / T
    expected = lift * (3 * u**2 - 2 * u**3) - (p + q * t + (c1 + c2 * t) * np.exp(-w * t))
    np.testing.assert_allclose(run.y[0], expected, atol=1e-7)  # of the integration
    assert np.abs(expected - lift * (3 * u**2 - 2 * u**3)).max() > 1e-3  # there is an error to follow


def test_servo_reaches_the_last_angle_within_its_peak_torque():
    motor = dataclasses.replace(SERVO, peak_torque=60.0)  # too weak to follow, J alpha is up to 100 N m; strong enough to come to rest
    torques = []

    def rate(t, y):
        torques.append(motor.torque(y[1], y[0], t))
        return y[1], torques[-1] / 3.0

    run = solve_ivp(rate, (0.0, 8.0), (0.0, 0.0), rtol=1e-8, atol=1e-10, max_step=0.05)
    assert max(np.abs(torques)) == 60.0
    assert run.y[:, -1] == pytest.approx([4.0, 0.0], abs=1e-6)


# ------------------------------------------------------------------------------------------------------------------------------- gears


@pytest.mark.parametrize("ratio", [20.0, -20.0, 0.5])
@pytest.mark.parametrize("motor", [KONG, CONVERTED, YCT, ConstantTorque(-40.0)])
def test_power_through_gears(motor, ratio):
    """Power in x efficiency is power out, whichever way it flows."""
    geared = Geared(motor, ratio, efficiency=0.9)
    for speed in np.linspace(-2000.0, 2000.0, 81) * RPM / ratio:
        before, behind = geared.motor_torque(speed) * geared.motor_speed(speed), geared.torque(speed) * speed
        assert geared.motor_speed(speed) == ratio * speed
        assert geared.motor_torque(speed) == motor.torque(ratio * speed)
        assert behind == pytest.approx(0.9 * before if before > 0 else before / 0.9, rel=ROUNDING, abs=1e-300)


def test_gears_at_standstill_start():
    assert Geared(ConstantTorque(40.0), 5.0, efficiency=0.8).torque(0.0) == pytest.approx(160.0, rel=ROUNDING)
    assert Geared(ConstantTorque(40.0), -5.0, efficiency=0.8).torque(np.zeros(2)) == pytest.approx([-160.0, -160.0], rel=ROUNDING)


def test_inertia_behind_gears_has_the_kinetic_energy_of_its_parts():
    geared = Geared(KONG, -20.0, 3.0)
    w = 7.0
    assert geared.inertia * w**2 / 2 == pytest.approx(0.7 * geared.motor_speed(w) ** 2 / 2 + 3.0 * w**2 / 2, rel=ROUNDING)


def corner_speeds(drive):
    return sorted(np.ravel([speed for speed, _ in corners_of(drive)]).tolist())


def test_gears_in_a_row():
    row, one = Geared(Geared(KONG, 4.0, 0.2, 0.95), -5.0, 3.0, 0.9), Geared(KONG, -20.0, 25 * 0.2 + 3.0, 0.95 * 0.9)
    speed = np.linspace(-100.0, 100.0, 41)
    np.testing.assert_allclose(row.torque(speed), one.torque(speed), rtol=1e-11)
    assert row.inertia == pytest.approx(one.inertia, rel=ROUNDING)
    assert (row.motor_speed(2.0), row.motor_torque(2.0)) == pytest.approx((-40.0, KONG.torque(-40.0)), rel=ROUNDING)
    assert row.rated_torque == KONG.rated_torque
    assert sorted(set(np.round(corner_speeds(row), 9))) == pytest.approx(corner_speeds(one))


def test_corners_behind_gears():
    assert Geared(KONG, 20.0).corners == ()
    assert corner_speeds(Geared(KONG, 20.0, efficiency=0.9)) == pytest.approx([0.0, 75 * RPM])
    fast = corner_speeds(CONVERTED)
    assert corner_speeds(Geared(CONVERTED, -10.0)) == pytest.approx([-fast[1] / 10, -fast[0] / 10])
    assert Geared(LAGGING, 3.0, efficiency=0.9).corners == (0.0,)


def test_angle_time_and_state_go_through_gears():
    servo, clutch = Geared(SERVO, -8.0), Geared(LAGGING, 3.0)
    wanted = SERVO.torque(2.4, 3.5, 0.6)
    assert 1.0 < abs(wanted) < 699.0  # within the limit, where it depends on all three
    assert servo.torque(-0.3, -0.4375, 0.6) == -8.0 * wanted
    assert servo.motor_torque(-0.3, -0.4375, 0.6) == wanted
    assert (clutch.state, clutch.timed) == ((0.0,), True)
    assert clutch.torque(30.0, 0.0, 0.0, (0.4,)) == 3.0 * LAGGING.torque(90.0, state=(0.4,))
    assert clutch.rates(31.0, 0.0, 0.0, (0.4,)) == LAGGING.rates(93.0, state=(0.4,))


# --------------------------------------------------------------------------------------------------------------------------- bad input

NUMBERS = [math.nan, math.inf, "1", None, True, 1j, [[1.0]], []]
GOOD: dict[Any, dict[str, Any]] = {
    Flywheel: {"inertia": 1.0},
    PrescribedSpeed: {"speed": 1.0},
    ConstantTorque: {"value": 1.0},
    InductionMotor: {"rated_power": 75e3, "rated_speed": 1485 * RPM},
    InverterMotor: {"rated_torque": 482.0, "rated_speed": 1485 * RPM, "frequency": 40.0},
    SlipClutchMotor: {"rated_torque": 189.0, "primary_speed": 1470 * RPM, "top_speed": 1320 * RPM, "set_speed": 900 * RPM},
    ServoMotor: {"times": (0.0, 1.0), "angles": (0.0, 2.0), "stiffness": 1.0, "damping": 1.0, "peak_torque": 1.0},
    Geared: {"drive": KONG, "ratio": 20.0},
}
SIGNS = {"finite": (), "other than zero": (0.0,), "positive": (0.0, -1.0), "not negative": (-1.0,)}
FIELDS = [
    (Flywheel, "inertia", "finite"),
    (PrescribedSpeed, "speed", "other than zero"),
    (ConstantTorque, "value", "finite"),
    *((InductionMotor, f, "positive") for f in ("rated_power", "rated_speed", "frequency", "breakdown_ratio")),
    *(
        (InverterMotor, f, "positive")
        for f in ("rated_torque", "rated_speed", "frequency", "rated_frequency", "overload", "breakdown_ratio")
    ),
    *((SlipClutchMotor, f, "positive") for f in ("rated_torque", "primary_speed", "top_speed", "set_speed", "regulation")),
    (SlipClutchMotor, "lag", "not negative"),
    *((ServoMotor, f, "positive") for f in ("stiffness", "peak_torque")),
    (ServoMotor, "damping", "not negative"),
    *((kind, "inertia", "not negative") for kind in (InductionMotor, InverterMotor, SlipClutchMotor, ServoMotor)),
    (Geared, "ratio", "other than zero"),
    (Geared, "gear_inertia", "not negative"),
    (Geared, "efficiency", "positive"),
]
BY_SCENARIO = {"inertia", "gear_inertia", "value", "rated_power"}


@pytest.mark.parametrize(("kind", "field", "sign"), FIELDS)
def test_numbers_that_make_no_sense(kind, field, sign):
    for bad in [
        *NUMBERS,
        *SIGNS[sign],
        [1.0, math.nan],
        [1.0, [2.0]],
        *([[2.0, s] for s in SIGNS[sign]] if field in BY_SCENARIO else ([1.0, 2.0],)),
    ]:
        with pytest.raises(pp.PinpressError, match=rf"^{kind.__name__}: {field}.* give "):
            kind(**GOOD[kind] | {field: bad})


REFUSALS = [
    (Flywheel, {"speed": math.nan}, r"Flywheel: speed is nan; give a finite number \[rad/s\]$"),
    (InductionMotor, {"rated_speed": 1500 * RPM}, r"the synchronous speed at 50 Hz with 4 poles 1500 r/min; give"),
    (InductionMotor, {"rated_speed": 1485.0}, r".* 1500 r/min; give a rated_speed below it \[rad/s\]; if 1485 r/min .* 1485 \* pp\.RPM$"),
    (InductionMotor, {"poles": 6}, r"rated_speed is 1485 r/min, .* 1000 r/min"),
    *((InductionMotor, {"poles": bad}, "InductionMotor: poles.* give the number of poles: 2, 4") for bad in (0, -2, 3, 4.0, True, None)),
    (InductionMotor, {"breakdown_ratio": 1.0}, r"breakdown_ratio is 1\.0; give breakdown by rated torque, above 1"),
    (InductionMotor, {"rated_power": [1e3, 2e3], "inertia": [1, 2, 3]}, r"2, 3; give one value of each"),
    (InverterMotor, {"rated_speed": 1501 * RPM}, r"InverterMotor: rated_speed is 1501 r/min, .* at 50 Hz .* below it \[rad/s\]$"),
    (InverterMotor, {"poles": 5}, "InverterMotor: poles is 5; give"),
    (InverterMotor, {"breakdown_ratio": 0.9}, r"InverterMotor: breakdown_ratio is 0\.9; give"),
    *(
        (InverterMotor, {"curve": bad}, "InverterMotor: curve.* give two or more pairs")
        for bad in (
            [],
            [(50, 482)],
            [50, 482],
            [(1, 2, 3), (4, 5, 6)],
            [(0, 482), (50, 482)],
            [(1, -1), (50, 482)],
            "fig. 1",
            [(1, math.nan), (50, 1)],
        )
    ),
    (InverterMotor, {"curve": [(50, 482), (5, 482)]}, r"frequencies of its curve are \[50\.0, 5\.0\]; give them rising"),
    (InverterMotor, {"curve": [(45, 482), (60, 300)]}, r"frequency is 40\.0, off its curve, which spans 45 to 60 Hz; give"),
    (SlipClutchMotor, {"regulation": 1.0}, r"regulation is 1\.0; give a share of the set speed below 1"),
    (SlipClutchMotor, {"top_speed": 1470 * RPM}, r"top_speed is 1470 r/min, primary_speed 1470 r/min; give"),
    (SlipClutchMotor, {"set_speed": 1330 * RPM}, r"set_speed is 1330 r/min, top_speed 1320 r/min; give a set_speed of at most"),
    *(
        (ServoMotor, {"times": bad}, r"ServoMotor: times.* give two or more finite numbers \[s\]")
        for bad in (*NUMBERS, [1.0], [0.0, math.nan])
    ),
    *((ServoMotor, {"angles": bad}, r"ServoMotor: angles.* give two or more .* \[rad\]") for bad in (*NUMBERS, [1.0], [0.0, math.nan])),
    (ServoMotor, {"angles": (0.0, 1.0, 2.0)}, "2 times and 3 angles; give an angle at each time"),
    (ServoMotor, {"times": (0.0, 0.0)}, "times go from 0 to 0 s; give them rising"),
    (ServoMotor, {"rated_torque": 0.0}, r"ServoMotor: rated_torque is 0\.0; give"),
    *(
        (Geared, {"drive": bad}, "Geared: drive.* give one with a torque")
        for bad in (Flywheel(1.0), PrescribedSpeed(1.0), 5.0, InductionMotor)
    ),
    (Geared, {"efficiency": 1.01}, r"efficiency is 1\.01; give a share of at most 1"),
    (
        Geared,
        {"drive": InductionMotor(1e3, 140.0, inertia=[1, 2]), "gear_inertia": [1, 2, 3]},
        r"gear_inertia has shape \(3,\), .* \(2,\); give",
    ),
]


@pytest.mark.filterwarnings("ignore:.*rad/s, .* r/min:pinpress.PinpressWarning")
@pytest.mark.parametrize(("kind", "changed", "message"), REFUSALS)
def test_drives_that_make_no_sense_are_refused(kind, changed, message):
    with pytest.raises(pp.PinpressError, match=message):
        kind(**GOOD[kind] | changed)


@pytest.mark.parametrize("frequency", [0.0, -5.0, math.nan, math.inf, np.array([50.0, 0.0]), "50", None])
def test_torque_limit_of_no_frequency(frequency):
    with pytest.raises(pp.PinpressError, match=r"InverterMotor: frequency.* give a positive number \[Hz\]"):
        CONVERTED.torque_limit(frequency)


def test_what_is_good_is_taken():
    for kind, arguments in GOOD.items():
        assert kind(**arguments) == kind(
            **{name: value if isinstance(value, Drive) else np.array(value)[()] for name, value in arguments.items()}
        )
