"""The process force over height from torque and angle, against loads that are known."""

import warnings
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from support.texts import shipped

import pinpress as pp
from pinpress import RPM, PinpressError, PinpressWarning, measured
from pinpress.loads import Blanking, DeepDrawing, ForceStroke
from pinpress.measured import stroke_force

NAME = "zxn2_3000b"
SPEED = 50 * RPM
KNOTS = np.array([0.0, 1.0, 4.0, 10.0, 20.0]) * 1e-3
DRAWING = DeepDrawing(1e6, start=0.009, end=0.001)
TABLE = ForceStroke(KNOTS, [2e5, 9e5, 6e5, 1e5, 4e4])


@cache
def sensor(inertia=0.0):
    return measured.force_sensor(shipped(NAME), KNOTS, drive_inertia=inertia)


@cache
def torque(load, start=0.0, strokes=1.0, friction=False, wave=0.0):
    """Times, angles and torque at 1000 Hz, the crank at a speed that may swing a little."""
    press = shipped(NAME)
    time = np.arange(round(1000 * strokes * 2 * np.pi / SPEED)) / 1000
    swing = 1.7 * SPEED
    angle = pp.dead_centres(press).top_angle + start + SPEED * time + wave * np.sin(swing * time)
    speed, rate = SPEED + wave * swing * np.cos(swing * time), -wave * swing**2 * np.sin(swing * time)
    motion = pp.servo_cycle(press, angle, speed=speed, acceleration=rate)
    laws = RUBBING if friction else {}
    loads = [load] if load else []
    return time, angle, rate, pp.inverse_dynamics(press, motion, loads=loads, friction=laws, bearings=()).driving_torque


RUBBING = {name: pp.loads.Friction(0.03, radius=0.05) for name in "ABDECF"} | {"slide_guide": pp.loads.Friction(0.05)}


def recorded(load=DRAWING, noise=0.0, counts=None, inertia=0.0, seed=0, **more):
    """A run with noise on the torque, and on the angle that of an encoder of so many counts."""
    rng = np.random.default_rng(seed)
    time, angle, rate, needed = torque(load, **more)
    if counts:
        angle = angle + 2 * np.pi / counts / np.sqrt(12) * rng.normal(size=len(angle))
    return measured.MeasuredRun(time, angle, needed + inertia * rate + noise * rng.normal(size=len(time)))


def test_a_force_that_is_linear_between_heights_is_found():
    """The crank's speed swings by a tenth; what is left are steps in time of 1 ms, over which the force is summed."""
    found = sensor(300.0).force(recorded(TABLE, inertia=300.0, wave=0.05))
    np.testing.assert_allclose(found.force, TABLE.forces, atol=0.01 * 9e5)
    assert found.work == pytest.approx(np.trapezoid(TABLE.forces, KNOTS), rel=2e-3)


def test_a_force_on_a_press_that_turns_backwards_is_found():
    """The way down is told by the slide's speed, not by its travel over the angle."""
    press, time = shipped(NAME), np.arange(1200) / 1000
    angle = pp.dead_centres(press).top_angle - SPEED * time
    motion = pp.servo_cycle(press, angle, speed=-SPEED)
    needed = pp.inverse_dynamics(press, motion, loads=[TABLE], bearings=()).driving_torque
    found = sensor().force(measured.MeasuredRun(time, angle, needed))
    np.testing.assert_allclose(found.force, TABLE.forces, atol=0.01 * 9e5)


def test_noise_of_a_coarse_encoder_is_that_of_its_steps():
    """Even within a count: a step by the root of 12, where most samples in a row are alike, so that their differences hide it."""
    time, step = np.arange(4000) / 1000, 2 * np.pi / 512
    angle = step * np.round((0.9 * time + 0.1 * np.sin(time)) / step)
    run = measured.MeasuredRun(time, angle, 2.0 + np.cos(angle))
    assert run.resolution == pytest.approx(step)
    assert stroke_force._smooth(run).noise == pytest.approx(step / np.sqrt(12), rel=1e-6)


def test_an_idle_press_has_no_force():
    found = sensor().force(recorded(None, wave=0.05))
    assert np.abs(found.force).max() < 50
    assert "MeasuredForce" in str(found)


def test_a_press_under_a_motor_with_a_flywheel():
    """A run of `simulate`: the flywheel gives the force as it slows down, the motor's torque hardly changes."""
    press = shipped("jf75g_125_plain")
    load = DeepDrawing(3e5, start=0.006)
    wheel, speed = pp.drives.Flywheel(136.0), 200 * RPM
    run = pp.simulate(press, 0.3, speed=speed, flywheel=wheel, drive=pp.drives.ConstantTorque(150.0), loads=[load], points=3001)
    record = measured.MeasuredRun(run.time, run.crank_angle, np.full(len(run.time), 150.0) + 1e-3 * np.sin(1e4 * run.time))
    heights = np.linspace(0, 0.007, 15)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PinpressWarning)  # without noise every corner of the force is an edge
        found = measured.process_force(press, record, heights, drive_inertia=136.0)
    expected = np.where(heights < 0.006, 3e5 * np.sin(np.pi * (0.006 - heights) / 0.006), 0.0)
    np.testing.assert_allclose(found.force[2:], expected[2:], atol=0.02 * 3e5)
    assert found.work == pytest.approx(3e5 * 0.006 * 2 / np.pi, rel=0.01)


def test_deviations_are_those_of_the_field():
    """Of 3 MN at 10, 4, 1 and 0 mm 7.6, 13.5, 31 and 114 kN with 1 % noise of torque, 1.38 kN m; behind a flywheel more by an encoder of
    8192 counts, hardly more by one of 131 072."""
    load = DeepDrawing(1e5, start=0.009)
    direct, coarse, sharp = (
        sensor(inertia).force(recorded(load, noise=1380.0, counts=counts, inertia=inertia)).deviation
        for inertia, counts in ((0.0, None), (2000.0, 8192), (2000.0, 131_072))
    )
    np.testing.assert_allclose(direct[[3, 2, 1, 0]], [7.6e3, 13.5e3, 31e3, 114e3], rtol=0.12)
    assert (coarse > 1.2 * direct).all()
    np.testing.assert_allclose(sharp, direct, rtol=0.12)


@pytest.mark.exhaustive
@pytest.mark.parametrize(("inertia", "counts"), [(0.0, None), (2000.0, 8192), (2000.0, 131_072)])
def test_bands_hold(inertia, counts):
    """300 runs: 95 % intervals hold the force at 92 to 98 %, and so do those of the work."""
    expected = np.array(TABLE.forces)
    inside = []
    for seed in range(300):
        found = sensor(inertia).force(recorded(TABLE, noise=1380.0, counts=counts, inertia=inertia, seed=seed, start=1e-3 * (seed % 10)))
        work = abs(found.work - np.trapezoid(expected, KNOTS)) < 1.96 * found.work_deviation
        inside.append([*((found.interval[:, 0] < expected) & (expected < found.interval[:, 1])), work])
    assert 0.92 < np.mean(inside) < 0.98
    assert np.mean(inside, axis=0).min() > 0.88


def test_edges_between_heights_are_said():
    """A blank that breaks at 3 mm: with heights 5 mm apart the residuals say so, with close ones they do not."""
    load = Blanking(1.5e6, start=0.008, end=0.003)
    with pytest.warns(PinpressWarning, match="the force has edges between heights 5 mm apart"):
        wide = measured.process_force(shipped(NAME), recorded(load, noise=2000.0), np.arange(0, 0.021, 0.005))
    assert wide.edges
    assert "set them closer" in str(wide)
    close = np.concatenate([[0, 0.0015], np.linspace(0.0028, 0.0032, 3), np.linspace(0.004, 0.009, 6)])
    found = measured.process_force(shipped(NAME), recorded(load, noise=2000.0), close)
    assert not found.edges


UP = np.array([0.0, 2.0, 5.0, 9.0]) * 1e-3
STRIPPING = np.array([-2e4, -9e4, -4e4, 0.0])  # holds the slide back, most at 2 mm


def stripped(noise=0.0, seed=0):
    """A stroke that forms on its way down, and strips on its way up."""
    press, (time, angle, _, needed) = shipped(NAME), torque(TABLE)
    motion = pp.servo_cycle(press, angle, speed=SPEED, acceleration=0.0)
    height = motion.slide_position - pp.dead_centres(press).bottom_position
    force = np.interp(height, UP, STRIPPING, right=0.0) * (motion.slide_velocity > 0)
    pulled = pp.loads.PointForce("slide", force[:, None] * [0.0, 0.0, 1.0])
    more = pp.inverse_dynamics(press, motion, loads=[pulled], bearings=()).driving_torque
    more = more - pp.inverse_dynamics(press, motion, bearings=()).driving_torque
    return measured.MeasuredRun(time, angle, needed + more + noise * np.random.default_rng(seed).normal(size=len(time)))


def test_a_force_on_the_way_up_is_found():
    """Down and up have their own heights; the work is that of both, and a stripper takes work from the slide too."""
    found = measured.process_force(shipped(NAME), stripped(), KNOTS, heights_up=UP, stiffness=4e9)
    np.testing.assert_allclose(found.force, TABLE.forces, atol=0.01 * 9e5)
    np.testing.assert_allclose(found.force_up, STRIPPING, atol=0.02 * 9e4)
    np.testing.assert_allclose(found.slide_height_up, UP + found.force_up / 4e9)
    assert found.work == pytest.approx(np.trapezoid(TABLE.forces, KNOTS) - np.trapezoid(STRIPPING, UP), rel=2e-3)
    assert "  up          2.000" in str(found)
    assert found.columns()["way"] == ["down"] * 5 + ["up"] * 4
    with pytest.warns(PinpressWarning, match="without process force the torque differs"):
        measured.process_force(shipped(NAME), stripped(20.0), KNOTS)


@pytest.mark.exhaustive
def test_bands_hold_on_the_way_up():
    inside = []
    for seed in range(200):
        found = measured.process_force(shipped(NAME), stripped(1380.0, seed), KNOTS, heights_up=UP)
        inside.append([*((found.interval_up[:, 0] < STRIPPING) & (found.interval_up[:, 1] > STRIPPING))])
    assert 0.92 < np.mean(inside) < 0.98
    assert np.mean(inside, axis=0).min() > 0.88


@pytest.mark.exhaustive
def test_the_encoders_zero_of_an_identified_press_is_taken_off():
    """The press is known to stand 3 degrees elsewhere than its encoder says; forces are as if it stood right."""
    press, rng = shipped("crank_slide"), np.random.default_rng(4)
    time = np.arange(6000) / 1000
    angle = 7.0 * time + 1.2 * np.sin(2.9 * time)
    state = pp.servo_cycle(press, angle, speed=7.0 + 3.48 * np.cos(2.9 * time), acceleration=-10.092 * np.sin(2.9 * time))
    heights = np.array([0.0, 6.0, 12.0, 18.0, 24.0]) * 1e-3
    load = ForceStroke(heights, [1e4, 2e4, 1.5e4, 5e3, 0.0])
    idle, pressing = (pp.inverse_dynamics(press, state, each).driving_torque + 0.5 * rng.normal(size=6000) for each in ((), [load]))
    sensors = []
    for zero in (0.0, np.radians(3)):
        found = measured.identify(press, [measured.MeasuredRun(time, angle + zero, idle)], friction=())
        sensors.append(measured.force_sensor(found, heights).force(measured.MeasuredRun(time, angle + zero, pressing)))
    np.testing.assert_allclose(sensors[1].force, sensors[0].force, atol=0.01 * 2e4)
    assert sensors[0].force.max() == pytest.approx(2e4, rel=0.03)


def test_friction_under_the_force_is_taken():
    """The bearings rub under the process force itself; a press without friction would give more force than there is."""
    run = recorded(TABLE, friction=True, noise=100.0)
    found = measured.process_force(shipped(NAME), run, KNOTS, friction=RUBBING)
    np.testing.assert_allclose(found.force, TABLE.forces, atol=0.02 * 9e5)
    with pytest.warns(PinpressWarning, match="the torque differs from that of the described press"):
        without = sensor().force(run)
    assert without.work > 1.02 * found.work


@pytest.mark.exhaustive
def test_an_identified_press_is_its_own_sensor():
    """A press 20 % heavier than described, that rubs: identified from an idle run its force comes out, else it does not."""
    described = shipped(NAME)
    heavy = described.with_inertias([pin.Inertia(1.2 * each.mass, each.lever, 1.2 * each.inertia) for each in described.model.inertias])

    def measure(strokes, wave, loads, seed):
        time = np.arange(round(1000 * strokes * 2 * np.pi / SPEED)) / 1000
        swing, rng = SPEED / 2.6, np.random.default_rng(seed)
        angle = pp.dead_centres(heavy).top_angle + SPEED * time - wave * SPEED / swing * (np.cos(swing * time) - 1)
        speed, rate = SPEED * (1 + wave * np.sin(swing * time)), wave * SPEED * swing * np.cos(swing * time)
        motion = pp.servo_cycle(heavy, angle, speed=speed, acceleration=rate)
        needed = pp.inverse_dynamics(heavy, motion, loads=loads, bearings=()).driving_torque + 1500.0 + 150.0 * speed
        return measured.MeasuredRun(time, angle, needed + 300.0 * rng.normal(size=len(time)))

    found = measured.identify(described, [measure(13.0, 0.3, [], 1)], friction=("crank",))
    stroke = measure(1.0, 0.0, [TABLE], 2)
    force = measured.process_force(found, stroke, KNOTS)
    assert (np.abs(force.force - TABLE.forces) < 4 * force.deviation).all()
    with pytest.warns(PinpressWarning, match="differs from that of the described press"):
        off = sensor().force(stroke)
    assert abs(off.work - force.work) > 10 * force.work_deviation
    with pytest.raises(PinpressError, match="the identified press contains its friction"):
        measured.force_sensor(found, KNOTS, friction=RUBBING)


def test_stroke_by_stroke():
    """Three strokes and another way down: three forces, each that of its stroke alone; the press springs by force / stiffness."""
    run = recorded(TABLE, strokes=3.6, noise=1000.0)
    soft = measured.force_sensor(shipped(NAME), KNOTS, stiffness=2e9)
    found = list(soft.strokes(run))
    assert len(found) == 3
    for each in found:
        assert (np.abs(each.force - TABLE.forces) < 5 * each.deviation).all()
        np.testing.assert_allclose(each.slide_height - KNOTS, each.force / 2e9)
    together = soft.force(run)
    np.testing.assert_allclose(together.deviation, np.mean([each.deviation for each in found], axis=0) / np.sqrt(4), rtol=0.1)


@pytest.mark.exhaustive
def test_a_press_that_springs():
    """A stroke of elastic motion: the work is that of the force, which holds at heights higher by force / stiffness."""
    press, speed = shipped("jf75g_125_plain"), 100 * RPM
    springs = pp.elasticity.Stiffness({"O": 3e9, "P2": 4e9, "P4": 4e9, "slide_guide": 2e9}, moments={"slide_guide": 2e8}, frame=3e9)
    yielding = pp.elasticity.Elastic(springs, damping_ratio=0.1, crown_mass=4000)
    held, load = pp.drives.PrescribedSpeed(speed), DeepDrawing(4e5, start=0.006)
    run = pp.steady_state(press, speed, drive=held, loads=[load], elastic=yielding, points=2001)
    height = run.slide_position - pp.dead_centres(press).bottom_position
    force = 4e5 * np.sin(np.pi * (0.006 - height) / 0.006) * ((height < 0.006) & (run.slide_velocity < 0))
    most = force.argmax()
    stiffness = force[most] / (run.slide_position - run.rigid_slide_position)[most]
    noisy = run.drive_torque + 50 * np.random.default_rng(0).normal(size=len(run.time))
    record = measured.MeasuredRun(run.time, run.crank_angle, noisy)
    found = measured.process_force(press, record, np.arange(0, 0.0071, 0.0005), stiffness=stiffness)
    assert found.work == pytest.approx(4e5 * 0.006 * 2 / np.pi, rel=5e-3)
    middle = slice(1, 8)
    expected, rigid = (4e5 * np.sin(np.pi * (0.006 - at[middle]) / 0.006) for at in (found.slide_height, found.heights))
    np.testing.assert_allclose(found.force[middle], expected, atol=0.03 * 4e5)  # what rings is left
    assert np.abs(found.force[middle] - rigid).max() > 0.1 * 4e5


@pytest.mark.exhaustive
def test_the_noise_of_an_angle_is_found_whatever_the_crank_does():
    """Third differences of white noise are sqrt(20) times as large, and of a smooth angle nearly nothing."""
    time, angle, _, needed = torque(DRAWING, strokes=3.0, wave=0.05)
    noise = 2e-4 * np.random.default_rng(0).normal(size=len(angle))
    assert stroke_force._smooth(measured.MeasuredRun(time, angle + noise, needed)).noise == pytest.approx(2e-4, rel=0.05)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: measured.force_sensor(shipped(NAME), [0.0, 10.0]), r"within its stroke, in m"),
        (lambda: measured.force_sensor(shipped(NAME), [0.01, 0.0]), "rising heights"),
        (lambda: measured.force_sensor(shipped(NAME), KNOTS, heights_up=[0.0, 9.0]), "heights_up reach from 0 to 9 m"),
        (lambda: measured.force_sensor(shipped(NAME), KNOTS, heights_up=[0.0]), "heights_up is"),
        (lambda: measured.force_sensor(shipped(NAME), KNOTS, drive_inertia=-1.0), "drive_inertia is -1"),
        (lambda: measured.force_sensor(shipped(NAME), KNOTS, stiffness=0.0), "stiffness is 0"),
        (lambda: measured.force_sensor(shipped("crank_slide"), [0.0, 0.01]).force(None), "run is a NoneType, no MeasuredRun"),
        (lambda: sensor().force(measured.MeasuredRun(np.arange(900) / 1e3, np.arange(900) * 0.005)), "no torque was measured"),
        (
            lambda: measured.process_force(shipped(NAME), recorded(), np.arange(0, 0.01, 1e-5)),
            "no samples on the way down between the heights",
        ),
        (lambda: sensor().force(recorded().between(0.7, 1.1)), "no samples on the way down between the heights around 0 m"),
        (
            lambda: measured.process_force(shipped(NAME), recorded(), KNOTS, heights_up=np.arange(0, 0.01, 1e-5)),
            r"no samples on the way up between the heights around 0\.000\d+ m",
        ),
    ],
)
def test_what_cannot_be_measured_is_named(make, says):
    with pytest.raises(PinpressError, match=says):
        make()


@pytest.mark.exhaustive
def test_deviations_hold_the_error_of_straight_lines_between_heights():
    """A force of half a sine over heights h apart: lines miss it by h^2 F'' / 12, which is many deviations of the noise."""
    press, top, start, heights = shipped("crank_slide"), 2.5e4, 0.044, np.arange(0, 0.0561, 0.002)
    bottom, mean, time = pp.dead_centres(press).bottom_position, 55 * RPM, np.arange(0, 6, 0.001)
    wave = mean * time + 0.6
    angle, speed, rate = mean * time + 0.05 * np.sin(wave), mean * (1 + 0.05 * np.cos(wave)), -(mean**2) * 0.05 * np.sin(wave)
    motion = pp.servo_cycle(press, angle, speed=speed, acceleration=rate)
    height = motion.slide_position - bottom
    force = np.where((height < start) & (motion.slide_velocity < 0), top * np.sin(np.pi * (start - height) / start), 0.0)
    needed = pp.inverse_dynamics(press, motion, bearings=()).driving_torque - force * motion.slide_velocity / speed
    runs = [measured.MeasuredRun(time, angle, needed + 1.5 * np.random.default_rng(k).normal(size=len(time))) for k in range(4)]
    found = [measured.process_force(press, run, heights) for run in runs]
    middle = (heights > 0.010) & (heights < 0.034)
    curve = 0.002**2 / 12 * top * (np.pi / start) ** 2 * np.sin(np.pi * (start - heights) / start)
    error = np.mean([each.force for each in found], axis=0) - top * np.sin(np.pi * (start - heights) / start)
    np.testing.assert_allclose(error[middle], curve[middle], rtol=0.3)
    np.testing.assert_allclose(np.mean([each.deviation for each in found], axis=0)[middle], curve[middle], rtol=0.3)
    assert (np.sqrt(np.diag(found[0].covariance))[middle] < 0.3 * curve[middle]).all()
