"""Where the power of motors goes: against nameplates, closed forms and equivalent circuits; the slip clutch's control and its limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from support.exploring import examples

import pinpress as pp
from pinpress.drives import Geared, InductionMotor, InverterMotor, SlipClutchMotor

RPM = pp.RPM
YCT = {"rated_torque": 189.0, "primary_speed": 1470 * RPM, "top_speed": 1320 * RPM, "set_speed": 900 * RPM}
NAMEPLATE = {"rated_power": 75e3, "rated_speed": 1485 * RPM}
SIEMENS = {"rated_torque": 482.0, "rated_speed": 1485 * RPM}
LOSSES = {"load_loss": 3500.0, "constant_loss": 1200.0}
speeds = st.floats(-200.0, 400.0)


def motors():
    return [
        InductionMotor(75e3, 1485 * RPM, **LOSSES),
        InverterMotor(**SIEMENS, frequency=80.0, inverter_efficiency=0.97, **LOSSES),
        InverterMotor(**SIEMENS, frequency=30.0, inverter_efficiency=0.97, feeds_back=True, **LOSSES),
        SlipClutchMotor(**YCT, excitation_power=120.0, **LOSSES),
        SlipClutchMotor(**YCT, lag=0.2, integral_time=1.0, residual_current=0.1, excitation_power=120.0, **LOSSES),
    ]


@pytest.mark.parametrize("motor", motors(), ids=["mains", "field weakening", "feeds back", "slip clutch", "with states"])
@given(speed=speeds, current=st.floats(0.0, 1.0), integral=st.floats(-1.0, 1.0))
@examples(15)
def test_no_loss_is_negative_and_the_shaft_has_the_torque(motor, speed, current, integral):
    state = (current, integral)[: len(motor.state)]
    power = motor.power(speed, state=state)
    losses = (power.slip, power.load, power.constant, power.inverter, power.resistor)
    assert all(loss >= 0 for loss in losses)
    torque = motor.torque(speed, state=state)
    assert power.shaft == pytest.approx(torque * speed, rel=1e-12, abs=1e-9)
    assert power.mains - power.shaft == pytest.approx(sum(losses), rel=1e-9, abs=1e-6)
    among_others = motor.power(np.array([speed, 1.0]), state=tuple(np.array([each, 0.5]) for each in state))
    assert [float(np.ravel(part)[0]) for part in among_others] == pytest.approx([float(part) for part in power], rel=1e-12, abs=1e-9)


def test_the_efficiencies_of_a_data_sheet_come_back():
    """75 kW, 94.0 % at full load and 93.9 % at half load: the losses as the module says, and from them the efficiencies again."""
    full, half = 75e3 * (1 / 0.940 - 1), 37.5e3 * (1 / 0.939 - 1)
    load = 4 * (full - half) / 3
    motor = InductionMotor(75e3, 1485 * RPM, load_loss=load, constant_loss=full - load)
    power = motor.power(1485 * RPM)
    assert power.shaft / power.mains == pytest.approx(0.940, rel=1e-12)
    speed = brentq(lambda w: motor.torque(w) * w - 37.5e3, 1485 * RPM, motor.synchronous_speed)
    power = motor.power(speed)
    # Kloss's slip is not quite proportional to the torque, nor the torque to the power
    assert power.shaft / power.mains == pytest.approx(0.939, abs=1e-3)


def test_slip_and_windings_are_the_heat_of_one_current():
    """Of the equivalent circuit without leakage in the stator: R2 / s takes the power of the air gap, R1 and R2 carry the same current."""
    synchronous, r1, r2, leakage, voltage = 50 * np.pi, 0.05, 0.04, 0.3, 230.0
    pull_out = r2 / leakage

    def circuit(slip):
        current = voltage / np.hypot(r2 / slip, leakage)  # behind the drop in R1, as Kloss's formula has it
        return 3 * current**2 * r2 / slip / synchronous, 3 * current**2 * r2, 3 * current**2 * r1

    rated_slip = 0.02
    torque, rotor, stator = circuit(rated_slip)
    rated_speed = synchronous * (1 - rated_slip)
    ratio = circuit(pull_out)[0] / torque
    motor = InductionMotor(torque * rated_speed, rated_speed, breakdown_ratio=ratio, load_loss=rotor + stator)
    for slip in (0.005, 0.02, 0.1, pull_out, 0.5, 1.0):  # up to standstill, where the torque is small and the current large
        wanted, power = circuit(slip), motor.power(synchronous * (1 - slip))
        assert (power.slip, power.load) == pytest.approx(wanted[1:], rel=1e-9)


def test_a_weakened_field_takes_more_current():
    below, above = (InverterMotor(**SIEMENS, frequency=f, **LOSSES) for f in (50.0, 75.0))
    torque = 300.0
    powers = [motor.power(brentq(lambda w, m=motor: m.torque(w) - torque, 0.0, motor.synchronous_speed)) for motor in (below, above)]
    assert powers[1].slip / powers[0].slip == pytest.approx(1.5**2, rel=1e-9)
    assert powers[1].load / powers[0].load == pytest.approx(1.5**2, rel=1e-9)
    assert below.power(1485 * RPM).heat == pytest.approx(below.rated_heat, rel=1e-12)


def test_limited_torque_slips_no_more():
    """The inverter lowers its frequency: at standstill the rotor is warmed by the current of the torque, not by the whole speed."""
    motor = InverterMotor(**SIEMENS, frequency=50.0, overload=1.5)
    assert motor.power(0.0).slip == pytest.approx(1.5**2 * motor.rated_slip_loss, rel=1e-12)


def test_a_driving_motor_takes_its_terminals_power_by_the_inverters_efficiency():
    for back in (True, False):
        power = InverterMotor(**SIEMENS, frequency=50.0, inverter_efficiency=0.8, **LOSSES, feeds_back=back).power(1485 * RPM)
        assert power.mains == pytest.approx((power.shaft + power.heat) / 0.8, rel=1e-12)
        assert power.resistor == 0.0


def test_braking_feeds_the_mains_or_the_resistor():
    speed = 1515 * RPM
    for motor in (InverterMotor(**SIEMENS, frequency=50.0, inverter_efficiency=0.96, **LOSSES, feeds_back=back) for back in (True, False)):
        power = motor.power(speed)
        terminals = -(power.shaft + power.heat)
        assert terminals > 0
        assert power.mains == pytest.approx(-0.96 * terminals if motor.feeds_back else 0.0, abs=1e-9)
        assert power.resistor == pytest.approx(0.0 if motor.feeds_back else terminals, rel=1e-12)
    direct = InductionMotor(75e3, 1485 * RPM)
    assert direct.power(speed).mains == pytest.approx(-direct.synchronous_speed * abs(direct.torque(speed)), rel=1e-12)


# ------------------------------------------------------------------------------------------------------------------------ slip clutch


def test_the_clutch_passes_its_torque_and_burns_the_slip():
    """Zhang 2007, (4.3.1): T in, T out, T (w_in - w_out) lost."""
    motor = SlipClutchMotor(**YCT)
    for speed in np.linspace(-50.0, 1469.0, 40) * RPM:
        power, torque = motor.power(speed), motor.torque(speed)
        assert power.mains == pytest.approx(torque * motor.primary_speed, rel=1e-12)
        assert power.slip == pytest.approx(torque * (motor.primary_speed - speed), rel=1e-12)
    assert motor.power(1320 * RPM).shaft == pytest.approx(0.0)  # above the set speed
    full = SlipClutchMotor(**YCT | {"set_speed": 1320 * RPM}, excitation_power=120.0, **LOSSES)
    rated = full.power(1320 * RPM * (1 - 1e-9))
    assert rated.shaft < 1e-3 * full.rated_heat  # the set speed is that without torque
    assert full.rated_heat == pytest.approx(189 * 150 * RPM + 3500 + 1200 + 120, rel=1e-12)


def test_natural_speed_is_4_3_1():
    motor = SlipClutchMotor(**YCT, feedback=0.0, amplification=0.4 / (900 * RPM))
    factor = 150 * RPM / 189**2  # K
    for torque in (10.0, 25.0, 60.0):
        wanted = 1470 * RPM - factor * torque**2 / 0.4**4
        assert motor.speed_under(torque, 0.4) == pytest.approx(wanted, rel=1e-12)
        assert motor.torque(wanted) == pytest.approx(torque, rel=1e-9)  # the loop is open: the current is 0.4 at every speed
    assert motor.speed_under(np.array([0.0, 189.0])) == pytest.approx([1470 * RPM, 1320 * RPM])
    for bad in ((-1.0, 1.0), (1.0, 0.0), (1.0, 1.1), (np.nan, 1.0)):
        with pytest.raises(pp.PinpressError, match=r"speed_under: .*give"):
            motor.speed_under(*bad)


@given(torque=st.floats(1.0, 600.0), feedback=st.floats(0.4, 1.2), residual=st.floats(0.0, 0.5))
@examples(40)
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
def test_control_is_lost_where_the_current_is_at_its_limits(torque, feedback, residual):
    """The speed under a load by bisection: where the current is full or least, the speed is that of (4.3.1), whatever is set."""
    motor = SlipClutchMotor(**YCT, feedback=feedback, residual_current=residual)
    speed = brentq(lambda w: motor.torque(w) - torque, -1e5, motor.primary_speed)
    low, high = motor.control_speeds
    least, most = motor.controllable_torque(speed)
    if low < speed < high:
        assert least <= torque * (1 + 1e-9)
        assert torque <= most * (1 + 1e-9)
    else:  # without control the set speed does not matter
        current = 1.0 if speed <= low else residual
        assert speed == pytest.approx(motor.speed_under(torque, current), rel=1e-6, abs=1e-3)
        assert motor.excitation(speed) == pytest.approx(current, rel=1e-9)


def test_the_residual_current_ends_the_control_draws_its_torque_and_takes_its_power():
    """A tenth of the current from the second of the control's speeds on: a hundredth of the torque and of the power."""
    motor = SlipClutchMotor(**YCT, feedback=0.9, residual_current=0.1, excitation_power=120.0)
    full, least = motor.control_speeds
    assert [motor.excitation(speed) for speed in (full, 0.5 * (full + least), least)] == pytest.approx([1.0, 0.55, 0.1], rel=1e-9)
    assert motor.controllable_torque(1320 * RPM) == pytest.approx((1.89, 189.0), rel=1e-12)
    assert motor.power(1320 * RPM).load == pytest.approx(1.2, rel=1e-12)


def test_too_little_feedback_is_told():
    with pytest.warns(pp.PinpressWarning, match=r"feedback 0\.5 it has its full current up to primary_speed.*give more than 0\.59"):
        motor = SlipClutchMotor(**YCT, feedback=0.5)
    assert motor.control_speeds[0] > motor.primary_speed
    assert motor.torque(1400 * RPM) == pytest.approx(189 * np.sqrt(70 / 150), rel=1e-12)
    edge = (900 * RPM - 1 / motor.gain) / (1470 * RPM)
    assert SlipClutchMotor(**YCT, feedback=edge * (1 + 1e-9)).control_speeds[0] < motor.primary_speed


def test_the_amplification_replaces_the_regulation():
    derived = SlipClutchMotor(**YCT)
    given_ = SlipClutchMotor(**YCT, amplification=derived.gain)
    assert given_.torque(880 * RPM) == derived.torque(880 * RPM)
    assert SlipClutchMotor(**YCT, amplification=2 * derived.gain).excitation(890 * RPM) == pytest.approx(2 * derived.excitation(890 * RPM))


@pytest.mark.parametrize("lag", [0.0, 0.15])
def test_integral_control_against_scipy(lag):
    """A shaft under a load that jumps: the equations as printed beside it, with the integral that stops at the current's limits."""
    motor = SlipClutchMotor(**YCT, lag=lag, integral_time=0.6, amplification=0.05, inertia=12.0)
    gain, set_speed, primary, factor = 0.05, 900 * RPM, 1470 * RPM, 150 * RPM / 189**2

    def printed(t, y):
        speed, integral = y[0], y[-1]
        error = set_speed - speed
        demanded = min(max(gain * error + integral, 0.0), 1.0)
        current = y[1] if lag else demanded
        torque = np.sqrt((primary - speed) * current**4 / factor)
        load = 40.0 if t < 2.0 else 150.0
        change = gain * error / 0.6 + (demanded - (gain * error + integral)) / 0.6
        return [(torque - load) / 12.0, *([(demanded - current) / lag] if lag else []), change]

    def ours(t, y):
        state = tuple(y[1:])
        load = 40.0 if t < 2.0 else 150.0
        return [(motor.torque(y[0], state=state) - load) / 12.0, *motor.rates(y[0], state=state)]

    start = [880 * RPM, *motor.state]
    ends = []
    for law in (printed, ours):
        y = np.array(start)
        for since, until in ((0.0, 2.0), (2.0, 12.0)):
            y = solve_ivp(law, (since, until), y, method="LSODA", rtol=1e-10, atol=1e-12).y[:, -1]
        ends.append(y)
    assert ends[0] == pytest.approx(ends[1], rel=1e-7)
    assert ends[0][0] == pytest.approx(set_speed, rel=1e-3)  # an integral leaves no error behind
    assert motor.torque(float(ends[1][0]), state=tuple(ends[1][1:])) == pytest.approx(150.0, rel=1e-2)


def test_gears_pass_the_new_states_on():
    motor = SlipClutchMotor(**YCT, lag=0.1, integral_time=0.6)
    assert Geared(motor, 3.0).rates(30.0, state=(0.4, 0.2)) == motor.rates(90.0, state=(0.4, 0.2))


@pytest.mark.parametrize(
    ("kind", "words", "message"),
    [
        (SlipClutchMotor, {**YCT, "residual_current": 1.0}, r"residual_current is 1\.0; give a share of the largest below 1"),
        (SlipClutchMotor, {**YCT, "integral_time": 0.0}, r"integral_time is 0\.0; give"),
        (SlipClutchMotor, {**YCT, "amplification": -1.0}, r"amplification is -1\.0; give"),
        (SlipClutchMotor, {**YCT, "feedback": -0.1}, r"feedback is -0\.1; give"),
        (SlipClutchMotor, {**YCT, "excitation_power": -1.0}, r"excitation_power is -1\.0; give"),
        (
            InductionMotor,
            {**NAMEPLATE, "load_loss": 700.0},
            r"load_loss is 700\.0; give at least 757\.576",
        ),
        (InverterMotor, {**SIEMENS, "frequency": 50.0, "load_loss": 10.0}, r"load_loss is 10\.0; give at least 757\.124 W"),
        (InverterMotor, {**SIEMENS, "frequency": 50.0, "inverter_efficiency": 1.1}, r"inverter_efficiency is 1\.1; give a share"),
        (InverterMotor, {**SIEMENS, "frequency": 50.0, "feeds_back": 1}, r"feeds_back is 1: give True or False"),
        (InductionMotor, {**NAMEPLATE, "rated_rise": 0.0}, r"rated_rise is 0\.0; give"),
        (InductionMotor, {**NAMEPLATE, "thermal_time": -1.0}, r"thermal_time is -1\.0; give"),
        (InductionMotor, {**NAMEPLATE, "constant_loss": -1.0}, r"constant_loss is -1\.0; give"),
    ],
)
def test_losses_that_make_no_sense_are_refused(kind, words, message):
    with pytest.raises(pp.PinpressError, match=rf"^{kind.__name__}: {message}"):
        kind(**words)
