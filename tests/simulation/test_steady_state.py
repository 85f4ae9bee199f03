"""The steady state of a press, found directly, and what motor and flywheel bear: against the exact equation of the JF75G-125 in plain
formulas (`crank_slide_equation`), closed forms, a period map of its own for the textbook crank-slider, long runs and the constraint method.

Bounds: a steady state comes back to 1e-10 of its speed, and each step's error is near 1e-11 of the run's sizes.
"""

import dataclasses
import itertools
import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import simpson, solve_ivp
from scipy.optimize import brentq
from support import texts
from support.generators.random_linkages import four_bar
from support.generators.small_linkages import disc, two_discs
from support.oracles import crank_slide_equation as equation
from support.oracles.crank_slide_by_scipy import angle_of
from support.oracles.crank_slide_equation import Window
from support.oracles.textbook_crank_slide import acceleration, height, lever
from support.sampling import rest_exhaustive
from support.time_limit import LIMIT, within

import pinpress as pp

pytestmark = pytest.mark.usefixtures("time_limit")

RPM = pp.RPM
J0, SPEED = 136.0, 300 * RPM  # Zhang 2007, 4.3: flywheel and speed of the JF75G-125
WHEEL = pp.drives.Flywheel(J0)
BLANK = pp.loads.Blanking(1.25e6, 0.010, 0.005)
WORK = 2 / math.pi * 1.25e6 * 0.005  # of a quarter sine
ENERGY = 0.5 * J0 * SPEED**2


@pytest.fixture(scope="module")
def press():
    return texts.shipped("jf75g_125", gravity=(0, 0, -9.80665))


@pytest.fixture(scope="module")
def textbook():
    return texts.shipped("crank_slide", gravity=(0, 0, -9.80665))


WARM = {"rated_rise": 80.0, "thermal_time": 1800.0}


def slip_clutch(lag=0.0, ratio=3.0):
    return pp.drives.Geared(pp.drives.SlipClutchMotor(189.0, 1470 * RPM, 1320 * RPM, 900 * RPM, lag=lag, **WARM), ratio)


def induction(power=3e4, ratio=5.0, inertia=0.2, efficiency=1.0):
    return pp.drives.Geared(pp.drives.InductionMotor(power, 1465 * RPM, inertia=inertia, **WARM), ratio, 0.0, efficiency)


def inverter():
    return pp.drives.Geared(pp.drives.InverterMotor(200.0, 1450 * RPM, 45.0), 5.0)


@pytest.fixture(scope="module")
def steady(press):
    return pp.steady_state(press, SPEED, drive=slip_clutch(), flywheel=WHEEL, loads=[BLANK])


@pytest.fixture(scope="module")
def long_run(press):
    with within(2 * LIMIT):
        return pp.simulate(press, 15.0, speed=SPEED, drive=slip_clutch(), flywheel=WHEEL, loads=[BLANK])


def comes_back(run, work=0.0, turn=2 * math.pi):
    """Angle a turn on, speed the same, the drive's work that of the loads; and this a closed form, where there is one."""
    assert abs(abs(run.crank_angle[-1] - run.crank_angle[0]) - turn) < 1e-9  # over time the end is located to 1e-10
    assert abs(run.crank_speed[-1] / run.crank_speed[0] - 1) < 1e-10
    energy = 0.5 * run.problem.driven.inertia * run.crank_speed[0] ** 2 + run.load_work[-1]
    assert abs(run.drive_work[-1] - run.load_work[-1]) < 1e-9 * energy
    if work:
        assert abs(run.load_work[-1] / work - 1) < 1e-9
    assert run.stats.energy_error < 1e-9


@pytest.fixture(scope="module")
def strokes(long_run):
    with within(2 * LIMIT):
        return pp.measures.stroke_duties(long_run)


# ------------------------------------------------------------------------------------------ the exact equation of the JF75G-125


def clutch_torque(speed, current):
    """Zhang 2007, 4.3.1, n = n0 - K T^2 / I^4, behind gears of ratio 3; K from 189 N m at 1320 r/min and full current."""
    k = (1470 - 1320) * RPM / 189.0**2
    return 3 * current**2 * math.sqrt((1470 * RPM - 3 * speed) / k)


DROP = 0.025 * 900 * RPM
GAIN = (150 / (570 + 0.025 * 900)) ** 0.25 / DROP  # so that 189 N m are reached at the set speed less the drop


def wanted(speed):
    return min(max(GAIN * (900 * RPM - 3 * speed), 0.0), 1.0)


def kloss(speed, efficiency):
    synchronous, rated = 50 * math.pi, 1465 * RPM
    s, sb = 1 - 5 * speed / synchronous, (1 - rated / synchronous) * (2.5 + math.sqrt(2.5**2 - 1))
    torque = 2 * 2.5 * 3e4 / rated * s / sb / (1 + (s / sb) ** 2)
    return 5 * torque * (efficiency if torque > 0 else 1 / efficiency)


def inverter_torque(speed):
    slope = 200.0 / (50 * math.pi - 1450 * RPM)
    return 5 * min(max(slope * (45 * math.pi - 5 * speed), -300.0), 300.0)


@dataclasses.dataclass
class Case:
    """A drive, its inertia at the crank, and its torque and corners over the crank's speed."""

    drive: Any
    inertia: float
    torque: Any
    corners: tuple = ()


CASES = {
    "slip_clutch": lambda: Case(slip_clutch(), 0.0, lambda w: clutch_torque(w, wanted(w)), (300 * RPM, 300 * RPM - 1 / GAIN / 3)),
    "induction": lambda: Case(induction(), 5.0, lambda w: kloss(w, 1.0)),
    "lossy_induction": lambda: Case(induction(efficiency=0.9), 5.0, lambda w: kloss(w, 0.9), (10 * math.pi,)),
    "inverter": lambda: Case(
        inverter(), 0.0, inverter_torque, tuple((45 * math.pi - side * 300 * (50 * math.pi - 1450 * RPM) / 200) / 5 for side in (1, -1))
    ),
}
PRESSED = {
    "blanking": (BLANK, [Window(0.010, 0.005, -1, lambda h, v: 1.25e6 * math.sin(math.pi / 2 * (0.010 - h) / 0.005))], WORK),
    "stripping": (
        pp.loads.Blanking(6e5, 0.010, 0.005, stripping=1.5e5),
        [
            Window(0.010, 0.005, -1, lambda h, v: 6e5 * math.sin(math.pi / 2 * (0.010 - h) / 0.005)),
            Window(0.010, 0.005, 1, lambda h, v: -1.5e5),
        ],
        2 / math.pi * 6e5 * 0.005 + 1.5e5 * 0.005,
    ),
}


@pytest.mark.parametrize("load", PRESSED)
@pytest.mark.parametrize("name", CASES)
def test_the_exact_equation_comes_back(press, name, load):
    """Integrated by SciPy from the steady state's first state on, it comes back to it after that time, and is the same between."""
    case, (given, windows, work) = CASES[name](), PRESSED[load]
    run = pp.steady_state(press, SPEED, drive=case.drive, flywheel=WHEEL, loads=[given], points=31)
    comes_back(run, work)
    solution = equation.solve(
        run.time,
        float(run.crank_speed[0]),
        J0 + case.inertia,
        torque=lambda t, q, w, s: case.torque(w),
        windows=windows,
        corners=[lambda t, q, w, s, at=at: w - at for at in case.corners],
    )
    assert abs(solution.angle[-1] - 2 * math.pi) < 1e-9
    assert abs(solution.speed[-1] / solution.speed[0] - 1) < 1e-9
    np.testing.assert_allclose(run.crank_angle, solution.angle, rtol=0, atol=1e-9)
    np.testing.assert_allclose(run.crank_speed, solution.speed, rtol=1e-9)
    np.testing.assert_allclose(run.drive_work, solution.drive_work, rtol=0, atol=1e-9 * ENERGY)
    np.testing.assert_allclose(run.load_work, solution.load_work, rtol=0, atol=1e-9 * ENERGY)
    assert solution.load_work[-1] == pytest.approx(work, rel=1e-9)


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("lag", "guess"),
    [(0.02, 30.3), (0.2, 30.4)],
)
def test_the_exact_equation_comes_back_with_a_lag(press, lag, guess):
    """Then the excitation current too comes back. Its first value stands in the drive's torque."""
    run = pp.steady_state(press, guess, drive=slip_clutch(lag), flywheel=WHEEL, loads=[BLANK], points=31)
    comes_back(run, WORK)
    speed = float(run.crank_speed[0])
    current = math.sqrt(run.drive_torque[0] / clutch_torque(speed, 1.0))
    solution = equation.solve(
        run.time,
        speed,
        J0,
        states=(current,),
        rates=lambda t, q, w, s: [(wanted(w) - s[0]) / lag],
        torque=lambda t, q, w, s: clutch_torque(w, s[0]),
        corners=[lambda t, q, w, s: w - 300 * RPM, lambda t, q, w, s: w - 300 * RPM + 1 / GAIN / 3],
        windows=PRESSED["blanking"][1],
    )
    assert abs(solution.angle[-1] - 2 * math.pi) < 1e-9
    assert abs(solution.speed[-1] / speed - 1) < 1e-9
    assert abs(solution.states[0, -1] / current - 1) < 1e-8  # its slope by speed is some 3 of its size by 1 % of the speed
    np.testing.assert_allclose(run.crank_speed, solution.speed, rtol=1e-9)
    np.testing.assert_allclose(run.drive_work, solution.drive_work, rtol=0, atol=1e-9 * ENERGY)


# --------------------------------------------------------------------------------------------------------------------- long runs


@pytest.mark.exhaustive
def test_a_long_run_ends_in_the_steady_state(long_run, strokes, steady):
    """More than seventy strokes, each of which leaves a fifth of what the speed was off: period, speed along it, works."""
    assert len(strokes) == math.floor(long_run.crank_angle[-1] / 2 / math.pi) > 70
    last = strokes[-1]
    read = long_run.trajectory.at(last.start + steady.time * (last.duration / steady.time[-1]))
    np.testing.assert_allclose(read.speed[0], steady.crank_speed, rtol=1e-7)
    np.testing.assert_allclose(read.position[0] - read.position[0, 0], steady.crank_angle, rtol=0, atol=1e-7)
    assert last.duration == pytest.approx(steady.time[-1], rel=1e-7)
    assert last.drive_work == pytest.approx(steady.drive_work[-1], rel=1e-6)
    assert last.load_work == pytest.approx(WORK, rel=1e-9)


@pytest.mark.exhaustive
def test_power_balances_in_a_long_run(long_run, strokes):
    """Each stroke takes the load's work, the drive more or less of it until the state is steady."""
    np.testing.assert_allclose([stroke.load_work for stroke in strokes], WORK, rtol=1e-6)
    assert abs(strokes[0].drive_work / WORK - 1) > 0.5
    assert abs(strokes[-1].drive_work / WORK - 1) < 1e-6
    assert long_run.stats.energy_error < 1e-6
    speeds = long_run.trajectory.at(np.array([stroke.start for stroke in strokes])).speed[0]
    gained = 0.5 * (J0 + equation.coefficients(0.0).inertia) * np.diff(speeds**2)
    balance = [stroke.drive_work - stroke.load_work for stroke in strokes[:-1]]
    np.testing.assert_allclose(gained, balance, rtol=0, atol=1e-9 * ENERGY)


TEXTBOOK_MOTOR = pp.drives.Geared(pp.drives.InductionMotor(7.5e3, 1440 * RPM, inertia=0.02), 20.0)
THIN = pp.loads.Blanking(2e5, 0.05, 0.04)
LASTING = {
    "corner of a torque": ("jf75g_125", SPEED, slip_clutch(), J0, BLANK, 8.0, 2e-10),
    "lag": ("jf75g_125", 30.0, slip_clutch(0.05), J0, BLANK, 2.5, 1e-9),  # a stroke is four time constants: it settles in 2 s
    "lag, backwards": ("jf75g_125", -SPEED, slip_clutch(0.05, -3.0), J0, BLANK, 3.0, 1e-8),
    "lag, stripping": ("jf75g_125", SPEED, slip_clutch(0.05), J0, pp.loads.Blanking(1.25e6, 0.010, 0.005, stripping=1.5e5), 3.0, 1e-8),
    "lag, die": ("jf75g_125", SPEED, slip_clutch(0.05), J0, pp.loads.ElasticDie(0.003, 2e8, 1e5), 10.0, 1e-8),
    **{name: ("jf75g_125", SPEED, CASES[name]().drive, J0, BLANK, 9.0, 1e-8) for name in ("induction", "lossy_induction", "inverter")},
    "no flywheel": ("jf75g_125", SPEED, induction(), 0.0, pp.loads.Blanking(2e5, 0.010, 0.005), 5.0, 1e-8),
    "no flywheel, slip clutch": ("jf75g_125", SPEED, slip_clutch(), 0.0, pp.loads.Blanking(2e5, 0.010, 0.005), 5.0, 1e-8),
    "quick return": ("thin_wall", 72 * RPM, induction(7.5e4, 20.0, 0.6), 500.0, THIN, 10.0, 1e-8),
    "quick return, backwards": ("thin_wall", -7.5, induction(7.5e3, -20.0, 0.0), 500.0, THIN, 10.0, 1e-8),
    "textbook": ("crank_slide", 72 * RPM, TEXTBOOK_MOTOR, 50.0, pp.loads.Blanking(2e4, 0.05, 0.02), 10.0, 1e-8),
}


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", LASTING)
def test_the_last_stroke_of_a_long_run_is_that_of_the_steady_state(name):
    """Of stiff motors, which settle by a factor of 2 and more each stroke, of lags, both ways round, and with little inertia."""
    press, speed, drive, inertia, load, duration, bound = LASTING[name]
    press, parts = (
        texts.shipped(press, gravity=(0, 0, -9.80665)),
        {"drive": drive, "flywheel": pp.drives.Flywheel(inertia), "loads": [load]},
    )
    run, found = pp.simulate(press, duration, speed=0.95 * speed, **parts), pp.steady_state(press, speed, **parts)
    comes_back(found)
    last = pp.measures.stroke_duties(run)[-1]
    assert last.duration == pytest.approx(found.time[-1], rel=bound)
    assert float(run.trajectory.at(np.array([last.start])).speed[0, 0]) == pytest.approx(found.crank_speed[0], rel=bound)


# ------------------------------------------------------------------------------------------------------------------- other presses

PRESSES = {
    "zxn2_3000b": (70 * RPM, induction(7.5e4, 20.0, 0.6), 2000.0, pp.loads.DeepDrawing(1e6, 0.05), 2 / math.pi * 1e6 * 0.05),
    "zxn2_3000b_balanced": (70 * RPM, induction(7.5e4, 20.0, 0.6), 2000.0, pp.loads.DeepDrawing(1e6, 0.05), 2 / math.pi * 1e6 * 0.05),
    "thin_wall": (70 * RPM, induction(7.5e3, 20.0, 0.0), 500.0, THIN, 2 / math.pi * 2e5 * 0.01),
    "jf75g_125_symmetric": (SPEED, induction(), J0, BLANK, WORK),
    "jf75g_125_two_point": (SPEED, induction(), J0, BLANK, WORK),
    "crank_slide": (75 * RPM, TEXTBOOK_MOTOR, 50.0, pp.loads.Blanking(2e4, 0.05, 0.02), 2 / math.pi * 2e4 * 0.03),
}


@pytest.mark.parametrize("name", PRESSES)
def test_other_presses_by_the_constraint_method(name):
    """Pinocchio's constraint dynamics, which share no equation with the reduced ones, come back to the steady state too."""
    speed, drive, inertia, load, work = PRESSES[name]
    linkage, wheel = texts.shipped(name), pp.drives.Flywheel(inertia)
    run = pp.steady_state(linkage, speed, drive=drive, flywheel=wheel, loads=[load], points=41)
    comes_back(run, work)
    period, first = float(run.time[-1]), float(run.crank_speed[0])
    other = pp.simulate(linkage, period, speed=first, drive=drive, flywheel=wheel, loads=[load], method="constraint", points=41)
    np.testing.assert_allclose(other.crank_angle, run.crank_angle, rtol=0, atol=1e-8)
    np.testing.assert_allclose(other.crank_speed, run.crank_speed, rtol=1e-8)
    assert other.drive_work[-1] == pytest.approx(run.drive_work[-1], rel=1e-8)
    assert other.motor_squared[-1] == pytest.approx(run.motor_squared[-1], rel=1e-7)


def test_a_spring_that_is_damped(textbook):
    """The drive makes up for what the damper takes: c v^2, by quadrature over the states."""
    spring = pp.loads.SpringDamper("frame", "slide", stiffness=2e3, damping=400, free_length=0.4, point1=(0, 0, -1.0))
    run = pp.steady_state(
        textbook, 75 * RPM, drive=induction(7.5e3, 20.0, 0.02), flywheel=pp.drives.Flywheel(20.0), loads=[spring], points=2001
    )
    comes_back(run)
    taken = simpson(400 * run.slide_velocity**2, x=run.time)
    assert taken > 50
    assert run.drive_work[-1] == pytest.approx(taken, rel=1e-9)  # the rule's error: 1e-12, h^4


# ------------------------------------------------------------------------------------------------------- symmetries of the solution


@pytest.mark.parametrize("angle", [5.9, -40.0])
@pytest.mark.parametrize("name", CASES)
@pytest.mark.exhaustive
def test_the_start_does_not_matter(press, name, angle):
    """The same orbit from any crank angle: period, works, and the speed at each angle."""
    drive = CASES[name]().drive
    there, here = (pp.steady_state(press, SPEED, drive=drive, flywheel=WHEEL, loads=[BLANK], angle=a) for a in (0.0, angle))
    comes_back(here, WORK)
    assert here.crank_angle[0] == pytest.approx(angle, rel=1e-14)
    assert here.time[-1] == pytest.approx(there.time[-1], rel=1e-10)
    assert here.motor_squared[-1] == pytest.approx(there.motor_squared[-1], rel=1e-8)
    passed = brentq(
        lambda t: float(there.trajectory.at(np.array([t])).position[0, 0]) - angle % (2 * math.pi), 0.0, there.time[-1], xtol=1e-15
    )
    assert here.crank_speed[0] == pytest.approx(float(there.trajectory.at(np.array([passed])).speed[0, 0]), rel=1e-10)


@pytest.mark.parametrize("guess", [0.4, 1.3, 3.0])
@pytest.mark.parametrize("name", CASES)
@pytest.mark.exhaustive
def test_the_guess_does_not_matter(press, name, guess):
    drive = CASES[name]().drive
    found, steady = (pp.steady_state(press, share * SPEED, drive=drive, flywheel=WHEEL, loads=[BLANK]) for share in (guess, 1.0))
    np.testing.assert_allclose(found.crank_speed, steady.crank_speed, rtol=1e-10)


@pytest.mark.parametrize("lag", [0.0, 0.05])
def test_backwards(press, lag):
    """The JF75G-125 is its own mirror image."""
    one, other = (pp.steady_state(press, way * 30.3, drive=slip_clutch(lag, way * 3.0), flywheel=WHEEL, loads=[BLANK]) for way in (1, -1))
    comes_back(other, WORK)
    assert other.crank_angle[-1] == pytest.approx(-2 * math.pi, rel=1e-9)
    np.testing.assert_allclose(other.crank_speed, -one.crank_speed, rtol=1e-9)
    np.testing.assert_allclose(other.drive_torque, -one.drive_torque, rtol=0, atol=1e-6)  # steep: 1000 N m s/rad
    np.testing.assert_allclose(other.drive_work, one.drive_work, rtol=0, atol=1e-8 * ENERGY)


def test_a_coarser_tolerance_is_kept(textbook):
    """With fewer panels, the errors stay below it."""
    fine, coarse = (
        pp.steady_state(
            textbook,
            75 * RPM,
            drive=TEXTBOOK_MOTOR,
            flywheel=pp.drives.Flywheel(50.0),
            loads=[pp.loads.Blanking(2e4, 0.05, 0.02)],
            tolerance=tolerance,
        )
        for tolerance in (1e-11, 1e-5)
    )
    np.testing.assert_allclose(coarse.crank_speed, fine.crank_speed, rtol=1e-5)
    assert coarse.stats.steps < fine.stats.steps


def test_it_is_a_run(press, steady):
    """120 states by default; a `Motion` for inverse dynamics, whose torque is that of drive and inertia."""
    assert len(steady.time) == 121
    assert steady.stats.method == "reduced"
    assert len(pp.measures.stroke_duties(steady)) == 1
    motion = pp.servo_cycle(press, angle=steady.crank_angle, speed=steady.crank_speed, acceleration=steady.crank_acceleration)
    acting = pp.inverse_dynamics(press, motion)
    idle = np.array([loads_of(steady, k) for k in range(121)])
    given = steady.drive_torque - J0 * steady.crank_acceleration
    np.testing.assert_allclose(given, acting.driving_torque + idle, rtol=0, atol=1e-5)


def loads_of(run, k):
    """Torque on the crank that the blank takes in a state, by the formula of the load and of the lever."""
    at = equation.coefficients(float(run.crank_angle[k]))
    way = -1 if at.lever > 0 else 1
    inside = way > 0 and 0.005 < at.height <= 0.010
    return -at.lever * 1.25e6 * math.sin(math.pi / 2 * (0.010 - at.height) / 0.005) if inside else 0.0


# --------------------------------------------------------------------------------------------------------------------- closed forms


@dataclasses.dataclass(frozen=True)
class Own(pp.drives.SpeedTorqueDrive):
    """A drive of one's own: a - b w - c w |w|."""

    a: float
    b: float
    c: float = 0.0
    inertia = 0.0
    rated_torque = None

    def torque(self, speed, angle=0.0, time=0.0, state=()):
        return self.a - self.b * speed - self.c * speed * abs(speed)


class Wavering(Own):
    """A drive of one's own without torque at three speeds close together, of which a disc leaves the middle one when it is disturbed."""

    def torque(self, speed, angle=0.0, time=0.0, state=()):
        return -self.a * (speed - 30.5) * (speed - 31.5) * (speed - 32.5)


@pytest.mark.parametrize("way", [1, -1])
def test_a_disc_does_not_stay_at_a_speed_that_it_leaves(way):
    drive, press = Wavering(0.2, 0.0), disc()
    for speed in (30.0, 30.4):
        run = pp.steady_state(press, way * speed, drive=drive if way > 0 else pp.drives.Geared(drive, -1.0))
        assert min(abs(abs(run.crank_speed[0]) - stays) for stays in (30.5, 32.5)) < 1e-8


def test_constant_inertia_and_a_linear_drive():
    """w = a / b, and nothing else."""
    run = pp.steady_state(disc(), 10.0, drive=Own(60.0, 5.0), flywheel=pp.drives.Flywheel(4.0))
    np.testing.assert_allclose(run.crank_speed, 12.0, rtol=1e-11)
    assert run.time[-1] == pytest.approx(2 * math.pi / 12, rel=1e-11)
    assert abs(run.drive_work[-1]) < 1e-8


@pytest.mark.parametrize("angle", [0.0, 2.0])
def test_an_eccentric_disc_and_a_quadratic_drive(angle):
    """With the torque a - c w^2 the energy W = I w^2 / 2 obeys W' = a - k W - m g e cos q, k = 2 c / I, exactly:
    W = a / k - m g e (k cos q + sin q) / (1 + k^2)."""
    e, a, c = 0.12, 400.0, 1.5
    inertia = 3.0 + 40 * e**2 + 2.0
    run = pp.steady_state(disc(e), 15.0, drive=Own(a, 0.0, c), flywheel=pp.drives.Flywheel(2.0), angle=angle, points=61)
    k, q = 2 * c / inertia, run.crank_angle
    energy = a / k - 40 * 9.81 * e * (k * np.cos(q) + np.sin(q)) / (1 + k * k)
    np.testing.assert_allclose(0.5 * inertia * run.crank_speed**2, energy, rtol=1e-10)
    assert np.ptp(run.crank_speed) > 0.5


def test_a_period_map_of_ones_own():
    """A root of what a turn makes of the speed, over the crank angle, from edge to edge of the load by SciPy."""
    a, b, wheel, force = 900.0, 90.0, 20.0, 8e3
    edge = [2 * math.pi - angle_of(h) for h in (0.05, 0.02)]
    legs = [(0.0, edge[0], 0.0), (edge[0], edge[1], force), (edge[1], 2 * math.pi, 0.0)]

    def turn(speed):
        y = np.array([speed, 0.0, 0.0, 0.0])
        for low, high, pushed in legs:

            def rates(q, y, pushed=pushed):
                drive, w = a - b * y[0], y[0]
                push = pushed * math.sin(math.pi / 2 * (0.05 - height(q, math)) / 0.03)
                change = acceleration(q, w, drive + push * lever(q, math), wheel) / w
                return [change, 1 / w, drive, drive * drive / w]

            y = solve_ivp(rates, (low, high), y, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        return y

    speed = brentq(lambda w: turn(w)[0] - w, 8.0, 12.0, xtol=1e-13, rtol=1e-14)
    _, period, work, squared = turn(speed)
    loads = [pp.loads.Blanking(force, 0.05, 0.02)]
    run = pp.steady_state(texts.shipped("crank_slide"), 10.0, drive=Own(a, b), flywheel=pp.drives.Flywheel(wheel), loads=loads)
    comes_back(run, 2 / math.pi * force * 0.03)
    assert run.crank_speed[0] == pytest.approx(speed, rel=1e-10)
    assert run.time[-1] == pytest.approx(period, rel=1e-10)
    assert run.drive_work[-1] == pytest.approx(work, abs=1e-9 * 0.5 * wheel * speed**2)
    assert run.motor_squared[-1] == pytest.approx(squared, rel=1e-8)
    assert np.ptp(run.crank_speed) > 0.5


# ------------------------------------------------------------------------------------------------------------------ no steady state

NONE = {
    "constant_torque": (pp.drives.ConstantTorque(567.0), BLANK),
    "no_torque": (pp.drives.ConstantTorque(0.0), BLANK),
    "brakes": (pp.drives.ConstantTorque(-50.0), pp.loads.Idle()),
    "weak_motor": (induction(1.5e3), BLANK),
    "beyond_breakdown": (induction(), pp.loads.Blanking(1.25e7, 0.010, 0.005)),
    "far_beyond": (inverter(), pp.loads.Blanking(1.25e8, 0.010, 0.005)),
    "turns_the_other_way": (slip_clutch(ratio=-3.0), BLANK),
    "weak_clutch": (slip_clutch(), pp.loads.Blanking(8e6, 0.010, 0.005)),
    "lag_stalls": (slip_clutch(0.05), pp.loads.Blanking(1.25e8, 0.010, 0.005)),
}
LONG = {"turns_the_other_way", "weak_motor"}  # half the time of all


@pytest.mark.one_in(10)
@pytest.mark.parametrize("name", rest_exhaustive(NONE, *NONE.keys() - LONG))
def test_no_steady_state(press, name):
    """At once, with the reason. Beyond breakdown the loads take 4 kJ a turn of a motor that gives 0.8 kJ at most, 40 kJ of one of 15 kJ."""
    drive, load = NONE[name]
    with within(LIMIT), pytest.raises(pp.SimulationError, match=r"no steady state|stalls|does not get through") as raised:
        pp.steady_state(press, SPEED, drive=drive, flywheel=WHEEL, loads=[load])
    if name == "constant_torque":
        for words in ("31.4159 rad/s", "too weak", "constant torque", "simulate"):
            assert words in str(raised.value)


BAD = {
    "no speed": ({"speed": 0.0}, "speed is 0"),
    "speed NaN": ({"speed": math.nan}, "speed is nan"),
    "speeds": ({"speed": [7.0, 8.0]}, "speed is"),
    "angles": ({"angle": [0.0, 1.0]}, "angle is"),
    "no drive": ({"drive": None}, "needs a motor"),
    "prescribed": ({"drive": pp.drives.PrescribedSpeed(7.0)}, "needs a motor"),
    "one load": ({"loads": BLANK}, "give a list"),
    "tolerance": ({"tolerance": 1e-30}, "tolerance"),
    "a program in time": ({"drive": pp.drives.ServoMotor([0, 1.0], [0, 6.0], 1e5, 1e3, 1e4)}, "time"),
    "a force in time": ({"loads": [pp.loads.TimeForce(lambda t: 0 * t)]}, "time"),
    "negative inertia": ({"flywheel": pp.drives.Flywheel(-1e3)}, "inertia"),
    "flywheels": ({"flywheel": pp.drives.Flywheel(np.array([50.0, 60.0]))}, "inertia"),
    "drives": ({"drive": induction(np.array([7.5e3, 8e3]), 20.0)}, "rated_power"),
    "loads": ({"loads": [pp.loads.Blanking(np.array([1e3, 2e3]), 0.05, 0.02)]}, "force"),
}


@pytest.mark.parametrize("name", BAD)
def test_arguments_that_make_no_sense_are_refused(textbook, name):
    change, message = BAD[name]
    good = {"press": textbook, "speed": 7.8, "drive": induction(7.5e3, 20.0), "flywheel": pp.drives.Flywheel(50.0), "loads": []}
    with pytest.raises(pp.PinpressError, match=message):
        pp.steady_state(**good | change)


@pytest.mark.parametrize(
    ("make", "message"),
    [(lambda: texts.load(four_bar(1.0, 0.8, 0.3, 0.7, 0.9).urdf("O")), "does not turn fully"), (two_discs, "a press with one")],
    ids=["double rocker", "two drivers"],
)
def test_presses_without_a_steady_state(make, message):
    with pytest.raises(pp.PinpressError, match=message):
        pp.steady_state(make(), 3.0, drive=Own(10.0, 1.0), flywheel=pp.drives.Flywheel(1.0))


# ------------------------------------------------------------------------------------------------------------------ duty and strokes


@pytest.mark.parametrize("name", ["slip_clutch", "lossy_induction"])
def test_duty_of_a_stroke(press, name):
    """From a finer grid in time, works and means by Simpson's rule."""
    case = CASES[name]()
    run = pp.steady_state(press, SPEED, drive=case.drive, flywheel=WHEEL, loads=[BLANK])
    fine = pp.steady_state(press, SPEED, drive=case.drive, flywheel=WHEEL, loads=[BLANK], points=40001)
    duty, ratio = pp.measures.duty_cycle(run), case.drive.ratio
    assert (duty.start, duty.duration) == (0.0, run.time[-1])
    speed = fine.crank_speed
    assert duty.mean_speed == pytest.approx(2 * math.pi / run.time[-1], rel=1e-12)
    assert duty.mean_speed == pytest.approx(simpson(speed, x=fine.time) / fine.time[-1], rel=1e-9)
    # the speed is highest where it is smooth, and lowest at break-through, on an edge: 720 states and this grid miss 1e-5
    highest, lowest = duty.highest_speed, duty.lowest_speed
    assert speed.max() * (1 - 1e-5) < highest <= speed.max() * (1 + 1e-9)
    assert speed.min() * (1 - 1e-5) < lowest <= speed.min()
    assert duty.speed_drop == pytest.approx((highest - lowest) / duty.mean_speed, rel=1e-12)
    assert duty.flywheel_work == pytest.approx(0.5 * (J0 + case.inertia) * (highest**2 - lowest**2), rel=1e-10)
    recovery = (fine.time[speed.argmax()] - fine.time[speed.argmin()]) % run.time[-1]
    assert duty.recovery_time == pytest.approx(recovery, abs=run.time[-1] / 1440 + 1e-5)
    assert duty.drive_work == pytest.approx(simpson(fine.drive_torque * fine.crank_speed, x=fine.time), rel=1e-7)  # corners: h^2 there
    assert duty.load_work == pytest.approx(WORK, rel=1e-9)
    assert duty.lost == 0.0
    own = case.drive.motor_torque(fine.crank_speed)
    if name == "slip_clutch":
        np.testing.assert_allclose(own, fine.drive_torque / ratio, rtol=0, atol=1e-9)
    assert duty.motor_rms == pytest.approx(math.sqrt(simpson(own**2, x=fine.time) / fine.time[-1]), rel=1e-6)
    peak = np.abs(own).max()
    assert peak * (1 - 1e-5) < duty.motor_peak < peak * (1 + 2e-3)  # on the same edge; near it a stiff motor's torque is steep
    rated = 189.0 if name == "slip_clutch" else 3e4 / (1465 * RPM)
    assert duty.utilisation == pytest.approx(duty.motor_rms / rated, rel=1e-12)


def test_duty_of_a_constant_torque(press):
    """Its rms and its peak are the torque, whatever the part of the run; rms and work have closed forms."""
    run = pp.simulate(press, 1.0, speed=29.0, drive=pp.drives.Geared(pp.drives.ConstantTorque(-100.0), -5.0), flywheel=WHEEL, loads=[BLANK])
    for start, end in ((0.0, None), (0.3, 0.35), (0.123, 0.987)):
        duty = pp.measures.duty_cycle(run, start, end)
        assert duty.motor_rms == pytest.approx(100.0, rel=1e-9)
        assert duty.motor_peak == pytest.approx(100.0, rel=1e-12)
        assert duty.utilisation is None
        turned = np.diff(run.trajectory.at(np.array([start, 1.0 if end is None else end])).position[0])[0]
        assert duty.drive_work == pytest.approx(500 * turned, rel=1e-9)
        assert duty.mean_speed == pytest.approx(turned / duty.duration, rel=1e-12)


@pytest.mark.exhaustive
def test_strokes_make_up_the_run(long_run, strokes):
    """Each a turn long, one after the other; with what is left at the end their sums are the run's."""
    ends = np.array([stroke.start + stroke.duration for stroke in strokes])
    np.testing.assert_allclose([stroke.start for stroke in strokes[1:]], ends[:-1], rtol=1e-14)
    np.testing.assert_allclose(long_run.trajectory.at(ends).position[0], 2 * math.pi * np.arange(1, len(ends) + 1), rtol=0, atol=1e-9)
    rest = pp.measures.duty_cycle(long_run, float(ends[-1]))
    parts = [*strokes, rest]
    assert sum(part.duration for part in parts) == pytest.approx(long_run.time[-1], rel=1e-12)
    assert sum(part.drive_work for part in parts) == pytest.approx(long_run.drive_work[-1], rel=1e-11)
    assert sum(part.load_work for part in parts) == pytest.approx(long_run.load_work[-1], rel=1e-11)
    assert sum(part.motor_rms**2 * part.duration for part in parts) == pytest.approx(long_run.motor_squared[-1], rel=1e-10)
    whole = pp.measures.duty_cycle(long_run)
    assert whole.drive_work == pytest.approx(long_run.drive_work[-1], rel=1e-12)
    assert whole.motor_rms == pytest.approx(math.sqrt(long_run.motor_squared[-1] / long_run.time[-1]), rel=1e-12)
    assert whole.highest_speed >= max(stroke.highest_speed for stroke in strokes) * (1 - 1e-5)  # 720 states a turn, shifted


@pytest.mark.parametrize("drive", [slip_clutch(), induction(efficiency=0.9)])
def test_strokes_of_both_methods(press, drive):
    """Also where the run begins at another angle, and runs backwards."""
    runs = [
        pp.simulate(press, 0.7, speed=29.0, angle=0.7, drive=drive, flywheel=WHEEL, loads=[BLANK], method=method)
        for method in ("reduced", "constraint")
    ]
    reduced, constraint = (pp.measures.stroke_duties(run) for run in runs)
    assert len(reduced) == len(constraint) == 3
    for one, other in zip(reduced, constraint, strict=True):
        for field in dataclasses.fields(one):
            a, b = getattr(one, field.name), getattr(other, field.name)
            if field.name == "recovery_time":  # to the next of 720 states
                assert a == pytest.approx(b, abs=1.01 * one.duration / 720)
            else:
                assert a == pytest.approx(b, rel=1e-6, abs=1e-9)


def test_strokes_backwards(press):
    """The mirror image of those forwards."""
    runs = [
        pp.simulate(press, 0.7, speed=way * 29.0, drive=slip_clutch(ratio=way * 3.0), flywheel=WHEEL, loads=[BLANK], angle=way * 0.4)
        for way in (1, -1)
    ]
    for one, other in zip(*map(pp.measures.stroke_duties, runs), strict=True):
        assert one.mean_speed > 0
        for field in dataclasses.fields(one):
            assert getattr(one, field.name) == pytest.approx(getattr(other, field.name), rel=1e-8)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("points", [2, 7, 500])
def test_strokes_do_not_depend_on_the_states_returned(press, points):
    strokes = [
        pp.measures.stroke_duties(pp.simulate(press, 1.0, speed=29.0, drive=slip_clutch(), flywheel=WHEEL, points=n))
        for n in (points, 5000)
    ]
    assert len(strokes[0]) == len(strokes[1]) == 4
    for one, other in zip(*strokes, strict=True):
        assert one.start == pytest.approx(other.start, rel=1e-11, abs=1e-12)
        assert one.drive_work == pytest.approx(other.drive_work, rel=1e-9, abs=1e-9)


def test_a_run_that_swings_has_no_strokes(textbook):
    run = pp.simulate(textbook, 3.0, speed=5.0)
    assert run.crank_speed.min() < 0 < run.crank_speed.max()
    assert np.ptp(run.crank_angle) < 2 * math.pi
    assert pp.measures.stroke_duties(run) == ()


def test_a_run_that_stands_still(textbook):
    run = pp.simulate(textbook, 1.0, angle=0.0)
    duty = pp.measures.duty_cycle(run)
    assert pp.measures.stroke_duties(run) == ()
    assert (duty.mean_speed, duty.speed_drop, duty.flywheel_work, duty.drive_work, duty.motor_rms) == (0.0, 0.0, 0.0, 0.0, 0.0)


def test_duty_of_a_brake_and_a_clutch(press):
    """What a clutch loses as it joins flywheel and press stands in the duty of that part."""
    run = pp.simulate(
        press,
        1.0,
        flywheel=pp.drives.Flywheel(J0, speed=30.0),
        clutch=pp.drives.Clutch(4e3, closes=pp.drives.SwitchPoint(time=0.2)),
        points=401,
    )
    before, after = pp.measures.duty_cycle(run, 0.0, 0.2), pp.measures.duty_cycle(run, 0.2)
    assert before.lost == 0.0
    assert after.lost == pytest.approx(run.lost[-1], rel=1e-12)
    assert run.lost[-1] > 100
    # the flywheel's, not the crank's
    assert after.flywheel_work == pytest.approx(0.5 * J0 * (30.0**2 - run.drive_speed.min() ** 2), rel=1e-3)


def test_duty_of_no_part_is_refused(press):
    run, within_run = pp.simulate(press, 1.0, speed=29.0, flywheel=WHEEL), "times within the run"
    parts = [(0.5, 0.2), (0.5, 0.5), (-0.1, 0.5), (0.0, 1.1), (math.nan, 0.5), (0.0, math.nan), (1.0, None), (0.0, math.inf)]
    for part, message in [*((part, within_run) for part in parts), (("a",), None), (([0.0],), None), ((None,), None)]:
        with pytest.raises(pp.PinpressError, match=message):
            pp.measures.duty_cycle(run, *part)


def test_duty_of_several_drivers():
    run = pp.simulate(two_discs(), 0.5, speed=np.array([3.0, 4.0]), method="constraint")
    for function in (pp.measures.duty_cycle, pp.measures.stroke_duties):
        with pytest.raises(pp.PinpressError, match="a press with one"):
            function(run)


def test_strokes_of_a_run_that_turns_back(press):
    """4.9 turns forwards, then 18 back, past the start: each stroke is a turn long, no two overlap."""
    run = pp.simulate(press, 6.0, speed=30.0, flywheel=WHEEL, drive=pp.drives.ConstantTorque(-2000.0), points=2001)
    assert 4 < run.crank_angle.max() / (2 * math.pi) < 5
    assert run.crank_angle[-1] < -12 * 2 * math.pi
    strokes = pp.measures.stroke_duties(run)
    assert len(strokes) >= 4
    for one in strokes:
        start, end = run.trajectory.at(np.array([one.start, one.start + one.duration])).position[0]
        assert abs(abs(end - start) - 2 * math.pi) < 1e-8
    assert all(b.start >= a.start + a.duration - 1e-12 for a, b in itertools.pairwise(strokes))
