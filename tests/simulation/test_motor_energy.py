"""What the motor of a run takes from the mains: energy to rounding, temperature against closed forms and SciPy, batch against single."""

import dataclasses
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import pinpress as pp
from pinpress.drives import Brake, Clutch, Flywheel, Geared, InductionMotor, InverterMotor, SlipClutchMotor, SwitchPoint

RPM = pp.RPM
YCT = {"rated_torque": 189.0, "primary_speed": 1470 * RPM, "top_speed": 1320 * RPM, "set_speed": 900 * RPM}
DATA = {"load_loss": 1500.0, "constant_loss": 900.0, "rated_rise": 80.0, "thermal_time": 1800.0}
MAINS = InductionMotor(11e3, 1450 * RPM, **DATA)
MOTORS: dict[str, Any] = {
    "mains": Geared(MAINS, 5.0, efficiency=0.94),
    "inverter": Geared(InverterMotor(200.0, 1450 * RPM, 45.0, inverter_efficiency=0.97, **DATA), 5.0),
    "slip clutch": Geared(SlipClutchMotor(**YCT, excitation_power=100.0, **DATA), 3.0, efficiency=0.96),
    "slip clutch with states": Geared(SlipClutchMotor(**YCT, lag=0.1, integral_time=0.5, **DATA), 3.0),
}
RATIO = 5.0
PROGRAM = np.linspace(0.0, 0.6, 31)
SERVO = pp.drives.ServoMotor(
    PROGRAM,
    RATIO * 12.0 * (PROGRAM / 0.6 - np.sin(2 * np.pi * PROGRAM / 0.6) / (2 * np.pi)),  # from rest to 40 rad/s, and to rest again
    stiffness=4e3,
    damping=400.0,
    peak_torque=4e4,
    inertia=0.3,
    rated_torque=400.0,
    copper=0.02,
    iron=0.01,
    constant_loss=250.0,
    regeneration=0.4,
    rated_rise=80.0,
    thermal_time=1500.0,
)


@dataclasses.dataclass(frozen=True)
class Hydraulic(pp.drives.SpeedTorqueDrive):
    """A drive of one's own: a straight line of torque, with an efficiency that a table has over speed and torque."""

    standstill: float = dataclasses.field(metadata=pp.drives.parameter("N m", "positive"))
    idle: float = dataclasses.field(metadata=pp.drives.parameter("rad/s", "positive"))
    inertia: float = 0.0
    rated_torque: float | None = None
    thermal_time: float = 900.0
    thermal_resistance: float = 0.02

    def torque(self, speed, angle=0.0, time=0.0, state=()):
        return self.standstill * (1.0 - speed / self.idle)

    def power(self, speed, angle=0.0, time=0.0, state=()):
        shaft = self.torque(speed) * speed
        efficiency = np.interp(np.abs(speed), [0.0, 20.0, 40.0], [0.3, 0.8, 0.85])
        return pp.drives.MotorPower(shaft, load=np.where(shaft > 0, shaft * (1 / efficiency - 1), 0.0), constant=150.0)


MOTORS |= {"servo": Geared(SERVO, RATIO, efficiency=0.97), "of one's own": Geared(Hydraulic(8e3, 32.0), 1.0)}
LOSSES = ("slip", "load", "constant", "gears", "inverter", "resistor")
BLANKING = [pp.loads.Blanking(force=400e3, start=0.006, end=0.003)]


def press():
    return pp.load("jf75g_125")


def stored(run):
    """Kinetic energy of press, flywheel and motor, and potential energy, at all states [J]: by Pinocchio, body by body."""
    import pinocchio as pin

    loaded, driven, found = press(), run.problem.driven, []
    data = loaded.model.createData()
    for q, v, own in zip(run.q, run.v, run.drive_speed, strict=True):
        kinetic = pin.computeKineticEnergy(loaded.model, data, q, v)
        found.append(kinetic + pin.computePotentialEnergy(loaded.model, data, q) + 0.5 * driven.inertia * own**2)
    return np.array(found)


@pytest.mark.parametrize("name", MOTORS)
def test_mains_are_work_and_losses_and_what_is_stored(name):
    """At every state of a run that is not steady: an error of 1e-9 of the largest work."""
    at_rest = name == "servo"  # where its program begins: from another speed its torque would be limited, with a kink
    run = pp.simulate(press(), 0.5, speed=0.0 if at_rest else 28.0, drive=MOTORS[name], flywheel=Flywheel(136.0), loads=BLANKING)
    energy = pp.measures.motor_energy(run)
    work, bodies = energy.work, stored(run)
    missing = work["mains"] - (run.load_work + run.lost + bodies - bodies[0] + sum(work[each] for each in LOSSES))
    assert np.abs(missing).max() < 1e-9 * bodies.max()
    assert np.abs(work["drive"] - run.drive_work).max() < 1e-9 * bodies.max()
    assert energy.power["mains"] == pytest.approx(energy.power["drive"] + sum(energy.power[each] for each in LOSSES), rel=1e-9, abs=1e-6)
    duty = pp.measures.duty_cycle(run)
    assert duty.mains_work == pytest.approx(work["mains"][-1], rel=1e-9)
    assert name != "servo" or work["resistor"][-1] > 0.05 * work["mains"][-1]
    assert duty.slip_loss == pytest.approx(work["slip"][-1], rel=1e-9)
    assert duty.efficiency == pytest.approx(run.drive_work[-1] / work["mains"][-1], rel=1e-8)
    assert duty.settled_rise == pytest.approx(energy.settled_rise, rel=1e-3)


def test_clutch_and_brake_have_their_own_losses():
    """The motor works on while the crank stands: what is lost in clutch and brake is no loss of the motor."""
    drive, closes = MOTORS["slip clutch with states"], SwitchPoint(time=0.1)
    couplings = {"clutch": Clutch(4e3, closes=closes, rise=0.05), "brake": Brake(5e3, opens=closes)}
    wheel = Flywheel(136.0, speed=30.0)
    run = pp.simulate(press(), 0.4, speed=0.0, drive=drive, flywheel=wheel, **couplings)
    assert run.lost[-1] > 100
    work = pp.measures.motor_energy(run).work
    gained = stored(run) - stored(run)[0]
    missing = work["mains"] - (run.lost + gained + sum(work[each] for each in LOSSES))
    assert np.abs(missing).max() < 1e-9 * stored(run).max()


def test_all_joints_agree_with_the_crank_alone():
    at = {"speed": 28.0, "drive": MOTORS["slip clutch"], "flywheel": Flywheel(136.0), "loads": BLANKING}
    crank, joints = (pp.measures.motor_energy(pp.simulate(press(), 0.1, method=m, **at)) for m in ("reduced", "constraint"))
    assert joints.work["mains"] == pytest.approx(crank.work["mains"], rel=1e-7, abs=1e-6)


@pytest.mark.exhaustive
def test_stiff_springs_agree_with_the_rigid_press():
    at = {"speed": 28.0, "drive": MOTORS["slip clutch"], "flywheel": Flywheel(136.0), "loads": BLANKING}
    crank = pp.measures.motor_energy(pp.simulate(press(), 0.1, **at))
    guides = dict.fromkeys(("slide_guide", "counterweight_guide"), 1e10)
    stiff = pp.elasticity.Elastic(pp.elasticity.Stiffness(dict.fromkeys(press().bearings, 1e12), moments=guides))
    on_springs = pp.measures.motor_energy(pp.simulate(press(), 0.1, elastic=stiff, **at))
    assert on_springs.work["mains"][-1] == pytest.approx(crank.work["mains"][-1], rel=1e-3)


# ---------------------------------------------------------------------------------------------------------------------- temperature


def test_constant_loss_warms_exponentially():
    """A press that is held at a speed by a motor without load: R P (1 - exp(-t / T)), in a run of several time constants."""
    quick = dataclasses.replace(MAINS, constant_loss=2e3, thermal_time=0.3)
    run = pp.simulate(pp.load("crank_slide", gravity=(0, 0, 0)), 1.5, speed=0.0, drive=Geared(quick, 5.0), flywheel=Flywheel(1e9))
    energy = pp.measures.motor_energy(run, initial_rise=5.0)
    heat = energy.power["heat"]
    assert np.ptp(heat) < 1e-3 * heat[0]  # the wheel is so heavy that it stands
    settled = 80.0 / quick.rated_heat * heat[0]
    wanted = settled + (5.0 - settled) * np.exp(-run.time / 0.3)
    assert energy.temperature_rise == pytest.approx(wanted, rel=2e-3)


@pytest.mark.exhaustive
def test_a_start_warms_the_rotor_by_the_energy_of_what_it_starts():
    """A wheel J from rest to w: slip J (n0 w - w^2 / 2), the windings by the ratio of their resistance to the rotor's."""
    motor = InductionMotor(11e3, 1450 * RPM, load_loss=1200.0)
    wheel, drive = Flywheel(400.0), Geared(motor, 5.0)
    run = pp.simulate(pp.load("crank_slide", gravity=(0, 0, 0)), 25.0, speed=0.0, drive=drive, flywheel=wheel)
    work, end, synchronous = pp.measures.motor_energy(run, initial_rise=None).work, run.crank_speed[-1], 50 * np.pi / 5
    assert end > 0.5 * synchronous
    wanted = 400.0 * (synchronous * end - end**2 / 2)
    assert work["slip"][-1] == pytest.approx(wanted, rel=3e-3)  # the linkage's inertia is so much of the wheel's
    assert work["load"][-1] / work["slip"][-1] == pytest.approx(1200.0 / motor.rated_slip_loss - 1, rel=1e-9)
    assert not work["gears"].any()


@pytest.mark.parametrize("name", ["inverter", pytest.param("slip clutch with states", marks=pytest.mark.exhaustive)])
def test_temperature_against_scipy(name):
    """T d(rise)/dt = R heat - rise, with a time constant as short as the stroke, so that the rise follows the load."""
    given = MOTORS[name]
    drive = dataclasses.replace(given, drive=dataclasses.replace(given.drive, thermal_time=0.2))
    run = pp.simulate(press(), 0.4, speed=28.0, drive=drive, flywheel=Flywheel(136.0), loads=BLANKING, points=2001)
    energy = pp.measures.motor_energy(run, initial_rise=12.0)
    resistance = 80.0 / drive.drive.rated_heat

    def warming(t, rise):
        return (resistance * np.interp(t, run.time, energy.power["heat"]) - rise) / 0.2

    found = solve_ivp(warming, (0.0, 0.4), [12.0], t_eval=[0.1, 0.25, 0.4], rtol=1e-9, atol=1e-9, max_step=4e-3)
    ours = np.interp(found.t, run.time, energy.temperature_rise)
    assert ours == pytest.approx(found.y[0], rel=1e-5)  # of the straight lines between the states


@pytest.mark.exhaustive
def test_a_time_constant_far_below_a_stroke_or_above_a_life():
    """Far below, the rise is the thermal resistance times the heat of the instant; far above, the mean heat's."""
    given = MOTORS["inverter"]
    run = pp.simulate(press(), 0.1, speed=28.0, drive=given, flywheel=Flywheel(136.0), points=11)
    for constant in (1e-5, 1e12):
        motor = dataclasses.replace(given.drive, thermal_time=constant)
        problem = dataclasses.replace(run.problem, driven=dataclasses.replace(run.problem.driven, drive=Geared(motor, 5.0)))
        energy = pp.measures.motor_energy(dataclasses.replace(run, problem=problem))
        heat = energy.power["heat"] if constant < 1 else np.full(11, energy.work["heat"][-1] / 0.1)
        assert energy.temperature_rise[1:] == pytest.approx(80.0 / motor.rated_heat * heat[1:], rel=1e-3)
    motor = dataclasses.replace(given.drive, thermal_time=1e-9)
    problem = dataclasses.replace(run.problem, driven=dataclasses.replace(run.problem.driven, drive=Geared(motor, 5.0)))
    with pytest.raises(pp.PinpressError, match=r"thermal_time is 1e-09 s, and the run lasts 0\.1 s: give"):
        pp.measures.motor_energy(dataclasses.replace(run, problem=problem))


def test_a_steady_stroke_comes_back_to_its_temperature():
    drive = dataclasses.replace(MOTORS["slip clutch"], drive=SlipClutchMotor(**YCT, rated_rise=80.0, thermal_time=0.5))
    steady = pp.steady_state(press(), 30.0, drive=drive, flywheel=Flywheel(136.0), loads=BLANKING)
    rise = pp.measures.motor_energy(steady).temperature_rise
    assert rise[0] == pytest.approx(rise[-1], rel=1e-12)
    assert np.ptp(rise) > 1.0
    mean = np.trapezoid(rise, steady.time) / steady.time[-1]
    # over a period the mean of the equation leaves R x mean heat
    work = pp.measures.motor_energy(steady).work["heat"][-1]
    assert mean == pytest.approx(80.0 / drive.drive.rated_heat * work / steady.time[-1], rel=1e-4)
    again = pp.measures.motor_energy(steady, initial_rise=float(rise[0])).temperature_rise
    assert again == pytest.approx(rise, rel=1e-12)


@pytest.mark.exhaustive
@pytest.mark.parametrize("feedback", [0.95, pytest.param(1.0, marks=pytest.mark.exhaustive)])
def test_an_integral_keeps_the_mean_speed(feedback):
    """Over a steady stroke the integral comes back, so that the mean speed is that set, to the share that is fed back."""
    motor = SlipClutchMotor(**YCT, integral_time=0.4, amplification=0.02, feedback=feedback)
    steady = pp.steady_state(press(), 30.0, drive=Geared(motor, 3.0), flywheel=Flywheel(136.0), loads=BLANKING)
    mean = 2 * np.pi / steady.time[-1]
    assert mean == pytest.approx(300 * RPM / feedback, rel=1e-8)


# ---------------------------------------------------------------------------------------------------------------------------- around


def test_batch_is_single():
    inertias = np.array([60.0, 136.0])
    drive = MOTORS["slip clutch"]
    many = pp.simulate_batch(press(), 0.5, speed=28.0, drive=drive, flywheel=Flywheel(inertias), loads=BLANKING)
    for k, inertia in enumerate(inertias):
        alone = pp.simulate(press(), 0.5, speed=28.0, drive=drive, flywheel=Flywheel(float(inertia)), loads=BLANKING)
        one, other = (pp.measures.motor_energy(run).work["mains"][-1] for run in (many[k], alone))
        assert one == pytest.approx(other, rel=1e-8)


def test_strokes_hours_and_columns():
    steady = pp.steady_state(press(), 30.0, drive=MOTORS["mains"], flywheel=Flywheel(136.0), loads=BLANKING)
    energy = pp.measures.motor_energy(steady)
    assert energy.strokes == pytest.approx(1.0)
    assert energy.work_per_stroke == pytest.approx(energy.mean_power * steady.time[-1])
    assert energy.efficiency == pytest.approx(pp.measures.duty_cycle(steady).efficiency)
    assert str(energy.title).startswith("EnergyFlow of jf75g_125: ")
    columns = energy.columns()
    assert {"mains_power [W]", "slip_loss [W]", "mains_work [J]", "temperature_rise [K]"} < set(columns)
    swing = pp.simulate(press(), 0.05, speed=28.0, drive=MOTORS["mains"], flywheel=Flywheel(136.0), points=7)
    assert pp.measures.motor_energy(swing).strokes < 1
    strokes = pp.measures.stroke_duties(pp.simulate(press(), 0.5, speed=28.0, drive=MOTORS["mains"], flywheel=Flywheel(136.0)))
    assert all(each.mains_work > 0 for each in strokes)


@pytest.mark.exhaustive
@pytest.mark.parametrize("regeneration", [0.4, 1.0])
def test_a_servo_motor_takes_what_the_planned_motion_takes(regeneration):
    """The run's own motion through inverse dynamics and the drive of servo presses: another way to torque, losses and energy drawn."""
    drawing = [pp.loads.DeepDrawing(force=400e3, start=0.006)]  # without a jump, for the trapezoids of the plan
    motor = dataclasses.replace(SERVO, constant_loss=0.0, regeneration=regeneration)
    run = pp.simulate(press(), 0.45, speed=0.0, drive=Geared(motor, RATIO), loads=drawing, points=801)
    at = {"time": run.time, "angle": run.crank_angle, "speed": run.crank_speed, "acceleration": run.crank_acceleration}
    drive = pp.servo.ServoDrive(0.3, RATIO, copper=motor.copper, iron=motor.iron, regeneration=regeneration)
    planned, energy = pp.servo.evaluate(press(), drive, drawing, **at), pp.measures.motor_energy(run)
    assert planned.mains_power.min() < -1e4
    trapezoids = 1e-4 * planned.weight @ np.abs(planned.mains_power)  # their error
    assert energy.work["mains"][-1] == pytest.approx(planned.energy_drawn, abs=trapezoids)
    assert energy.work["load"][-1] == pytest.approx(planned.weight @ (motor.copper * planned.motor_torque**2), rel=5e-4)
    assert energy.work["constant"][-1] == pytest.approx(planned.weight @ (motor.iron * planned.motor_speed**2), rel=1e-5)
    rest = energy.power["mains"] - np.where(planned.mains_power > 0, 1.0, regeneration) * planned.mains_power
    assert np.median(np.abs(rest)) < 1e-6 * np.abs(planned.mains_power).max()


# -------------------------------------------------------------------------------------------------------------- direct-current link


LINK = pp.drives.DirectCurrentLink(capacitance=0.1, lower_voltage=450.0, charged_voltage=560.0, upper_voltage=750.0)


@cache
def servo_run():
    """From rest to rest, with hard braking."""
    motor = Geared(dataclasses.replace(SERVO, regeneration=0.9), RATIO, efficiency=0.97)
    return pp.simulate(press(), 0.6, speed=0.0, drive=motor, flywheel=Flywheel(136.0), loads=BLANKING)


@pytest.mark.exhaustive
@pytest.mark.parametrize("voltage", [None, 700.0])
@pytest.mark.parametrize("mains_power", [None, 1.55e6])
def test_with_a_link_mains_are_work_losses_and_what_bodies_and_capacitor_store(voltage, mains_power):
    run, link = servo_run(), dataclasses.replace(LINK, mains_power=mains_power)
    energy = pp.measures.motor_energy(run, link=link, initial_voltage=voltage)
    work, bodies = energy.work, stored(run)
    in_capacitor = 0.5 * link.capacitance * (energy.voltage**2 - energy.voltage[0] ** 2)
    missing = work["mains"] - (run.load_work + run.lost + bodies - bodies[0] + in_capacitor + sum(work[each] for each in LOSSES))
    assert np.abs(missing).max() < 1e-9 * bodies.max()
    powers = sum(energy.power[each] for each in ("drive", "capacitor", *LOSSES))
    assert energy.power["mains"] == pytest.approx(powers, rel=1e-9, abs=1e-6)
    assert energy.power["mains"].min() >= 0
    assert energy.voltage.max() <= 750.0 * (1 + 1e-12)
    assert work["resistor"][-1] > 1.05 * pp.measures.motor_energy(run).work["resistor"][-1]  # more than the converter loses
    assert energy.voltage[0] == pytest.approx(energy.voltage[-1] if voltage is None else 700.0, rel=1e-10)


@pytest.mark.exhaustive
def test_links_without_bounds_are_the_shares_that_are_used_again():
    """A huge capacitor uses all again, a tiny one nothing."""
    run, link = servo_run(), dataclasses.replace(LINK, capacitance=1e3)
    plain = pp.measures.motor_energy(run)
    huge = pp.measures.motor_energy(run, link=link)
    assert huge.work["mains"][-1] == pytest.approx(plain.work["mains"][-1], rel=1e-9)
    tiny = pp.measures.motor_energy(run, link=dataclasses.replace(LINK, capacitance=1e-9))
    braking = plain.work["mains"][-1] - tiny.work["mains"][-1]
    points = np.linspace(0.0, 0.6, 20_001)
    power = np.interp(points, plain.time, plain.power["mains"])
    assert braking == pytest.approx(np.trapezoid(np.minimum(power, 0.0), points), rel=1e-2)
    assert tiny.work["resistor"][-1] - plain.work["resistor"][-1] == pytest.approx(-braking, rel=1e-6)


@pytest.mark.exhaustive
def test_the_capacitor_of_a_planned_motion_just_suffices():
    """The mains give the mean alone, and the voltage goes from one end to the other: `pinpress.servo.capacitor`, by trapezoids."""
    run = servo_run()
    plain = pp.measures.motor_energy(run)
    taken = plain.work["mains"]
    mean = float(taken[-1] / run.time[-1])
    deviation = taken - mean * run.time
    capacitance = 2 * float(np.ptp(deviation)) / (750.0**2 - 450.0**2)
    link = pp.drives.DirectCurrentLink(1.002 * capacitance, 450.0, 750.0, 750.0, mains_power=1.001 * mean)
    energy = pp.measures.motor_energy(run, link=link)
    assert 450.0 <= energy.voltage.min() < 456.0
    assert energy.voltage.max() == pytest.approx(750.0)
    assert energy.power["mains"].max() == pytest.approx(1.001 * mean)


@pytest.mark.exhaustive
def test_links_that_cannot_be_are_named():
    run = servo_run()
    energy = pp.measures.motor_energy
    with pytest.raises(pp.PinpressError, match=r"at crank angle .* J are missing to hold its lower_voltage of 450 V"):
        energy(run, link=dataclasses.replace(LINK, mains_power=5e5))
    with pytest.raises(pp.PinpressError, match="more than its mains_power of 100 W: the voltage falls from stroke to stroke"):
        energy(run, link=dataclasses.replace(LINK, mains_power=100.0))
    with pytest.raises(pp.PinpressError, match="initial_voltage is 500 V: give one from 560 to 750 V"):
        energy(run, link=LINK, initial_voltage=500.0)
    with pytest.raises(pp.PinpressError, match="initial_voltage is of a direct-current link"):
        energy(run, initial_voltage=600.0)
    others = {"the InductionMotor is on the mains": "mains", "give it feeds_back=True": "inverter", "SlipClutchMotor": "slip clutch"}
    for said, name in others.items():
        with pytest.raises(pp.PinpressError, match=said):
            energy(pp.simulate(press(), 0.01, speed=28.0, drive=MOTORS[name], flywheel=Flywheel(136.0)), link=LINK)
    burning = Geared(dataclasses.replace(SERVO, regeneration=0.0), RATIO)
    with pytest.raises(pp.PinpressError, match="has regeneration=0"):
        energy(pp.simulate(press(), 0.01, speed=0.0, drive=burning), link=LINK)
    with pytest.warns(pp.PinpressWarning, match="the capacitor does nothing"):
        energy(pp.simulate(press(), 0.05, speed=0.0, drive=Geared(SERVO, RATIO), flywheel=Flywheel(136.0)), link=LINK)


def test_a_drive_of_ones_own_that_tells_its_power_wrongly_is_named():
    """Its message says what; a drive with another member of that name runs as before."""

    def run(power):
        kind = dataclasses.dataclass(frozen=True)(type("Own", (Hydraulic,), {"power": power}))
        return pp.simulate(press(), 0.05, speed=28.0, drive=kind(8e3, 32.0), points=5)

    told = pp.drives.MotorPower
    for power, message in (
        (lambda self, *at: at[0], "Own: power is array.*give a pinpress.drives.MotorPower"),
        (lambda self, *at: told(0.9 * self.torque(at[0]) * at[0]), "Own: shaft of its power is .* where its torque has .*torque x speed"),
        (lambda self, *at: told(self.torque(at[0]) * at[0], load=np.nan), "Own: load of its power is nan"),
        (lambda self, *at: told(self.torque(at[0]) * at[0], slip=[1.0, 2.0]), r"Own: slip of its power has shape \(2,\)"),
        (lambda self, *at: 1 / 0, "Own: power cannot be worked out: ZeroDivisionError"),
    ):
        with pytest.raises(pp.PinpressError, match=message):
            pp.measures.motor_energy(run(power))
    assert pp.measures.duty_cycle(run(7.5e3)).mains_work is None
    slow = pp.simulate(press(), 0.05, speed=28.0, drive=dataclasses.replace(Hydraulic(8e3, 32.0), thermal_time="long"), points=5)
    with pytest.raises(pp.PinpressError, match="thermal_time is 'long'"):
        pp.measures.motor_energy(slow)


def test_what_makes_no_servo_motor_is_named():
    for words, message in (({"regeneration": 1.1}, "regeneration is 1.1; give a share"), ({"copper": 0.0}, "rated_rise is by the heat")):
        with pytest.raises(pp.PinpressError, match=message):
            dataclasses.replace(SERVO, **words)


def test_what_is_not_known_is_said():
    constant = pp.simulate(press(), 0.1, speed=28.0, drive=pp.drives.ConstantTorque(10.0), flywheel=Flywheel(136.0))
    assert pp.measures.duty_cycle(constant).mains_work is None
    with pytest.raises(pp.PinpressError, match="no motor whose power from the mains is known: give an InductionMotor"):
        pp.measures.motor_energy(constant)
    plain = pp.simulate(press(), 0.1, speed=28.0, drive=Geared(InductionMotor(11e3, 1450 * RPM), 5.0), flywheel=Flywheel(136.0))
    assert pp.measures.motor_energy(plain).temperature_rise is None
    assert pp.measures.duty_cycle(plain).settled_rise is None
    with pytest.raises(pp.PinpressError, match="initial_rise: the motor's temperature is not known: give the motor a rated_rise"):
        pp.measures.motor_energy(plain, initial_rise=20.0)
    for words, message in (({"load_loss": 1e308}, "losses .* too large"), ({"rated_rise": 1e308, "thermal_time": 1e-3}, "rated_rise")):
        drive = Geared(InductionMotor(11e3, 1400 * RPM, **words), 5.0)
        with pytest.raises(pp.PinpressError, match=message):
            pp.measures.motor_energy(pp.simulate(press(), 0.1, speed=10.0, drive=drive, flywheel=Flywheel(136.0)))
    with pytest.raises(pp.PinpressError, match="initial_rise is nan"):
        pp.measures.motor_energy(plain, initial_rise=np.nan)


def test_a_servo_motor_that_holds_its_permanent_torque_has_its_rated_rise():
    """At standstill, half a radian behind a program that stands too; losses of the controller are part of what the rise was measured by."""
    motor = pp.drives.ServoMotor(
        [0.0, 1.0], [0.5, 0.5], 400.0, 1.0, 1e3, rated_torque=200.0, copper=0.05, iron=0.3, constant_loss=150.0, rated_rise=80.0
    )
    power = motor.power(0.0, 0.0, 0.5)
    assert power.shaft == 0
    assert power.heat * motor.thermal_resistance == pytest.approx(80.0, rel=1e-12)
