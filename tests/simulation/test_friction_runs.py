"""Runs with friction in bearings: against a press written out by hand, inverse dynamics of the run that is found, and energy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support import texts
from support.generators.spatial_crank_slide import SPATIAL
from support.oracles import friction_script
from support.presses import sliding_presses
from support.texts import shipped

import pinpress as pp
from pinpress.drives import Brake, Clutch, ConstantTorque, Flywheel, Geared, InductionMotor, PrescribedSpeed, SwitchPoint
from pinpress.loads.link import Friction, PointForce, SpringDamper
from pinpress.loads.process import DeepDrawing, ElasticDie

MOTOR, RATIO = InductionMotor(rated_power=75e3, rated_speed=1485 * pp.RPM, inertia=1.2), 20.7
GEARED, FLYWHEEL = Geared(MOTOR, ratio=RATIO), Flywheel(inertia=6000.0)
INERTIA = 6000.0 + 1.2 * RATIO**2
DRAWING = DeepDrawing(1e6, 0.010)
CYLINDER = SpringDamper("frame", "slide", 1.4e5, 500.0, point1=(0.0, 0.0, -0.3))


def rubbing(press, coefficient=0.05, viscous=0.0):
    turns = [*(axis.turns for axis in press.axes), *[True] * len(press.loops)]
    radius = 0.1 * press.size
    return {name: Friction(coefficient, radius if turning else None, viscous) for name, turning in zip(press.bearings, turns, strict=True)}


def missing(press, run, loads, friction, inertia):
    """(n,) what inverse dynamics of a run says of the torque on its crank besides that of the run, as a share of the largest."""
    needed = pp.inverse_dynamics(press, run, loads, friction).driving_torque
    return (needed - (run.drive_torque - inertia * run.crank_acceleration)) / np.abs(needed).max()


@pytest.mark.exhaustive
@pytest.mark.parametrize("method", ["reduced", "implicit"])
@pytest.mark.parametrize("loads", [pytest.param([], marks=pytest.mark.exhaustive), [DRAWING, CYLINDER]], ids=["idle", "loaded"])
def test_inverse_dynamics_gives_the_motor_torque_back(method, loads):
    press = shipped("zxn2_3000b")
    friction = rubbing(press, viscous=20.0)
    more = {"drive": GEARED, "flywheel": FLYWHEEL, "loads": loads, "friction": friction}
    duration = 0.9 if method == "reduced" else 0.1
    run = pp.simulate(press, duration, speed=70 * pp.RPM, angle=4.5, method=method, points=91, **more)
    assert np.abs(missing(press, run, loads, friction, INERTIA)).max() < 1e-9
    assert run.stats.energy_error < 1e-10
    bare = pp.simulate(press, duration, speed=70 * pp.RPM, angle=4.5, method=method, points=91, **more | {"friction": {}})
    assert run.lost[-1] > 0.0 == bare.lost[-1]


def others():
    return {
        "thin_wall": (shipped("thin_wall"), 7.0),  # a block in a slot of a link that turns
        "jf75g_125_symmetric": (shipped("jf75g_125_symmetric"), -20.0),  # gear pair, several guides, redundant loops; backwards
        "spatial": (texts.load(SPATIAL), 5.0),
        "toggle": (texts.load(sliding_presses.TOGGLE), 0.3),  # its driver slides
    }


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["thin_wall", "jf75g_125_symmetric", "toggle", pytest.param("spatial", marks=pytest.mark.exhaustive)])
def test_other_presses(name):
    press, speed = others()[name]
    friction, inertia = rubbing(press), 0.0 if name == "toggle" else 5.0
    push = PointForce(press.links[1], (30.0, 0.0, -50.0), (0.05, 0.0, 0.0))
    flywheel, drive = (Flywheel(inertia), None) if inertia else (None, ConstantTorque(-300.0))
    run = pp.simulate(press, 0.05, speed=speed, flywheel=flywheel, drive=drive, loads=[push], friction=friction, points=31)
    assert np.abs(missing(press, run, [push], friction, inertia)).max() < 1e-9
    assert run.stats.energy_error < 1e-9
    assert run.lost[-1] > 0.0


@pytest.mark.parametrize("method", ["reduced", "implicit"])
def test_viscous_friction_alone(method):
    """In the crank's bearing it is a torque c w on the crank: without weight the balanced disc slows down exponentially."""
    disc = texts.load(
        '<robot name="disc"><link name="frame"/><link name="disc"><inertial><mass value="3"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="1"/></inertial></link><joint name="O" type="continuous">'
        '<parent link="frame"/><child link="disc"/><axis xyz="0 -1 0"/></joint>'
        '<transmission name="t"><joint name="O"/></transmission></robot>'
    )
    run = pp.simulate(disc, 1.0, speed=5.0, flywheel=Flywheel(2.0), friction={"O": Friction(viscous=8.0)}, method=method, points=11)
    np.testing.assert_allclose(run.crank_speed, 5.0 * np.exp(-2.0 * run.time), rtol=1e-9)


def test_a_run_by_hand():
    """Crank-slide from its equations written out by hand, the acceleration found so that the torque balances, by DOP853 of SciPy."""
    press, inertia, lift = shipped("crank_slide"), 20.0, -2e3
    friction = rubbing(press, 0.08, 3.0)
    coulomb = {name: each.coefficient * (each.radius or 1.0) for name, each in friction.items()}
    viscous = {name: each.viscous for name, each in friction.items()}

    def torque(state, acceleration):
        angle, speed = state
        moved = friction_script.crank_slide(np.array([angle]), np.array([speed]), np.array([acceleration]))
        return float(friction_script.solve(moved, np.array([lift]), coulomb, viscous)["torque"][0]) + inertia * acceleration

    def rates(time, state):
        first, second = 0.0, 10.0
        low, high = torque(state, first), torque(state, second)
        for _ in range(4):  # the residual is nearly linear
            first, second = second, second - high * (second - first) / (high - low)
            if abs(second - first) < 1e-11:
                break
            low, high = high, torque(state, second)
        return state[1], second

    by_hand = solve_ivp(rates, (0.0, 0.12), (0.4, 8.0), method="DOP853", rtol=1e-10, atol=1e-12)
    push = PointForce("slide", (0.0, 0.0, lift))
    run = pp.simulate(press, 0.12, angle=0.4, speed=8.0, flywheel=Flywheel(inertia), loads=[push], friction=friction)
    np.testing.assert_allclose((run.crank_angle[-1], run.crank_speed[-1]), by_hand.y[:, -1], rtol=1e-9)


@pytest.mark.parametrize("method", ["reduced", pytest.param("implicit", marks=pytest.mark.exhaustive)])
def test_preloaded_gibs_in_a_run(method):
    """Where the preload is never reached, the gibs take mu P of every metre; where it is in a part of the turn, inverse dynamics agrees."""
    press = texts.shipped("crank_slide")
    given = {"speed": 12.0, "angle": 0.3, "flywheel": Flywheel(60.0), "method": method, "points": 91}
    strong = {"slide_guide": Friction(0.05, preload=1e5)}
    run = pp.simulate(press, 1.0, friction=strong, **given)
    path = np.abs(np.diff(pp.simulate(press, 1.0, friction=strong, **given | {"points": 40001}).slide_position)).sum()
    assert run.lost[-1] == pytest.approx(0.05 * 1e5 * path, rel=1e-6)
    mixed = rubbing(press, viscous=20.0) | {"slide_guide": Friction(0.05, preload=400.0)}
    run = pp.simulate(press, 1.0, friction=mixed, **given)
    across = np.abs(pp.inverse_dynamics(press, run, friction=mixed).bearing_force["slide_guide"][:, 0])
    assert 10 < (across > 400.0).sum() < 80
    assert np.abs(missing(press, run, [], mixed, 60.0)).max() < 1e-9


def test_a_guide_whose_force_is_rounding():
    """In a symmetric press the guide carries nothing: without a preload it takes nothing, with one mu P of every metre."""
    press, given = texts.shipped("jf75g_125_symmetric"), {"speed": 30.0, "flywheel": Flywheel(136.0), "points": 11}
    bare = pp.simulate(press, 0.2, **given)
    unloaded = pp.simulate(press, 0.2, friction={"slide_guide": Friction(0.05)}, **given)
    np.testing.assert_allclose(unloaded.crank_speed, bare.crank_speed, rtol=1e-12)
    run = pp.simulate(press, 0.2, friction={"slide_guide": Friction(0.05, preload=1e5)}, **given)
    turns = run.crank_angle[-1] / (2 * np.pi)
    path = 4 * 0.015 * np.floor(turns) + (0.03 if turns % 1 > 0.5 else 0.0)  # strokes that are over, then what is left of one
    height = run.slide_position[-1] - pp.dead_centres(press).bottom_position
    path += (0.03 - height) if turns % 1 > 0.5 else height
    assert run.lost[-1] == pytest.approx(0.05 * 1e5 * path, rel=1e-9)


def test_no_friction_is_no_friction():
    press = shipped("zxn2_3000b")
    more = {"speed": 70 * pp.RPM, "drive": GEARED, "flywheel": FLYWHEEL, "loads": [DRAWING]}
    none, zero = (pp.simulate(press, 0.3, friction=friction, **more) for friction in ({}, rubbing(press, 0.0)))
    assert np.array_equal(none.crank_angle, zero.crank_angle)
    assert np.array_equal(none.crank_acceleration, zero.crank_acceleration)


@pytest.mark.parametrize("speed", [7.0, -7.0])
def test_torque_at_constant_speed(speed):
    """A drive that holds the speed gives the torque of inverse dynamics, and its work is that against loads and friction."""
    press = shipped("zxn2_3000b")
    friction = rubbing(press, viscous=5.0)
    run = pp.simulate(press, 2 * np.pi / 7.0, drive=PrescribedSpeed(speed), loads=[DRAWING], friction=friction, points=61)
    needed = pp.inverse_dynamics(press, run, [DRAWING], friction).driving_torque
    assert np.abs(run.drive_torque - needed).max() < 1e-9 * np.abs(needed).max()
    assert run.drive_work[-1] == pytest.approx(run.load_work[-1] + run.lost[-1], rel=1e-10)


def test_the_motor_supplies_what_is_lost_in_steady_state():
    press = shipped("crank_slide")
    friction, drive = rubbing(press), Geared(InductionMotor(rated_power=3e3, rated_speed=1440 * pp.RPM, inertia=0.01), ratio=16.0)
    run = pp.steady_state(press, 90 * pp.RPM, drive=drive, flywheel=Flywheel(40.0), friction=friction, points=241)
    assert abs(run.crank_speed[-1] / run.crank_speed[0] - 1) < 1e-9
    assert run.drive_work[-1] == pytest.approx(run.lost[-1], rel=1e-8)
    power = sum(pp.inverse_dynamics(press, run, friction=friction).friction_power.values())
    assert run.lost[-1] == pytest.approx(np.trapezoid(power, run.time), rel=1e-3)
    assert np.abs(missing(press, run, [], friction, 40.0 + 0.01 * 16.0**2)).max() < 1e-9


# Rest


def held(press, friction, angle):
    """Torques (2,) that would turn a crank at rest slowly forwards and backwards: the limits between which friction holds it."""
    return [
        float(pp.inverse_dynamics(press, pp.servo_cycle(press, np.array([angle]), speed=way * 1e-6), friction=friction).driving_torque[0])
        for way in (1.0, -1.0)
    ]


@pytest.mark.exhaustive
def test_a_press_that_runs_down_stands_where_friction_holds_it():
    press = shipped("crank_slide")
    friction = rubbing(press, 0.1)
    run = pp.simulate(press, 3.0, speed=3.0, flywheel=Flywheel(5.0), friction=friction)
    assert run.crank_speed[-1] == run.crank_acceleration[-1] == 0.0
    assert run.trajectory.standing is not None
    forwards, backwards = held(press, friction, run.crank_angle[-1])
    assert backwards < 0.0 < forwards
    moving = run.crank_speed != 0
    assert np.abs(missing(press, run, [], friction, 5.0)[moving]).max() < 1e-9
    assert run.stats.energy_error < 1e-8


@pytest.mark.exhaustive
@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_drive_overcomes_friction_or_not(share):
    press, angle = shipped("crank_slide"), 1.2
    friction = rubbing(press, 0.1)
    drive = ConstantTorque(share * held(press, friction, angle)[0])
    more = {"angle": angle, "flywheel": Flywheel(5.0), "drive": drive, "friction": friction}
    if share < 1.0:
        with pytest.warns(pp.PinpressWarning, match="stands from 0 s to the end, at crank angle 68.7549 deg: the friction holds it"):
            run = pp.simulate(press, 0.5, **more)
        assert np.ptp(run.crank_angle) == 0.0
    else:
        run = pp.simulate(press, 0.05, **more)
        assert run.crank_angle[-1] > angle
        assert run.crank_speed[-1] > 0.0


@pytest.mark.exhaustive
def test_clutch_brake_and_a_die():
    """A single stroke with a contact that may be lost; the energy balance, which every run keeps, has all losses in it."""
    press = shipped("crank_slide")
    friction = rubbing(press)
    parts = {
        "flywheel": Flywheel(30.0, speed=9.0),
        "clutch": Clutch(2e3, closes=SwitchPoint(time=0.02), opens=SwitchPoint(time=0.3)),
        "brake": Brake(800.0, closes=SwitchPoint(time=0.35)),
        "loads": [ElasticDie(0.004, 2e6, 2e3)],
    }
    run = pp.simulate(press, 0.9, angle=np.pi, friction=friction, **parts)
    bare = pp.simulate(press, 0.9, angle=np.pi, **parts)
    assert run.crank_speed[-1] == 0.0
    assert run.stats.energy_error < 1e-8
    assert run.crank_angle[-1] < bare.crank_angle[-1]


def test_scenarios_are_runs():
    press = shipped("crank_slide")
    speeds, friction = np.array([60.0, 90.0]) * pp.RPM, rubbing(press)
    flywheel = Flywheel(np.array([40.0, 60.0]))
    batch = pp.simulate_batch(press, 0.3, speed=speeds, flywheel=flywheel, friction=friction, points=11)
    for k, run in enumerate(batch):
        np.testing.assert_allclose(batch.crank_angle[:, k], run.crank_angle, rtol=0, atol=1e-9)
        assert batch.lost[k] == pytest.approx(run.lost[-1], rel=1e-9)
    assert batch.energy_error.max() < 1e-9


@pytest.mark.filterwarnings("ignore:friction of.*its (coefficient|radius) is")  # so large on purpose
@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"friction": {"O": Friction(0.1, 0.05)}, "method": "constraint"}, "method='constraint' has no friction in bearings"),
        ({"friction": {"Q": Friction(0.1, 0.05)}}, "no bearing 'Q'"),
        ({"friction": {"O": Friction(0.1)}}, "its radius is missing"),
        ({"friction": {"O": Friction(0.1, 0.05, preload=1e3)}}, "preload is that of the gibs of a guide; leave it out"),
        ({"friction": [0.1]}, "friction is a list: give a mapping"),
        ({"friction": {"slide_guide": Friction(6.0)}}, "friction locks the linkage, or nearly so"),
        ({"friction": {"slide_guide": Friction(6.0)}, "method": "implicit"}, "friction locks the linkage, or nearly so"),
    ],
)
def test_what_is_refused(given, words):
    with pytest.raises(pp.PinpressError, match=words):
        pp.simulate(shipped("crank_slide"), 0.5, speed=8.0, flywheel=Flywheel(5e3), **given)
