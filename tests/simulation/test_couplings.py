"""Clutch, brake, loads of one direction and gears with losses, where the crank comes to rest: against the equation of the textbook press,
integrated from one decision to the next by `support.oracles.coupled_crank`, and methods against each other."""

import math
from typing import Any

import numpy as np
import pytest
from support import texts
from support.oracles.coupled_crank import Coupled, Load, kloss
from support.oracles.textbook_crank_slide import height, inertia, lever, potential, slope

import pinpress as pp

pytestmark = pytest.mark.usefixtures("time_limit")

At, Brake, Clutch, Flywheel = pp.drives.SwitchPoint, pp.drives.Brake, pp.drives.Clutch, pp.drives.Flywheel
METHODS = ("auto", "implicit", "constraint")


@pytest.fixture(scope="module")
def press():
    return texts.shipped("crank_slide")


def drawing(force, start):
    return pp.loads.DeepDrawing(force, start), Load(start, 0.0, lambda h: force * math.sin(math.pi * (start - h) / start))


def blanking(force, start, end):
    return pp.loads.Blanking(force, start, end), Load(start, end, lambda h: force * math.sin(0.5 * math.pi * (start - h) / (start - end)))


def always(torque):
    return lambda time: torque


def from_on(torque, start):
    return lambda time: torque * (time >= start)


def until(torque, end):
    return lambda time: torque * (time < end)


def lossy(torque, efficiency):
    """A constant torque before gears of ratio 10 with losses."""
    return lambda speed, side: torque * (efficiency if torque * (speed or side) >= 0 else 1 / efficiency)


DRAWING, NOTHING, PUNCH, DEEP = drawing(100.0, 0.05), blanking(0.0, 0.05, 0.02), blanking(100.0, 0.05, 0.02), drawing(1e5, 0.1)
INDUCTION = pp.drives.Geared(pp.drives.InductionMotor(2.2e3, 1430 * pp.RPM), 15.0, efficiency=0.95)
CONSTANT = pp.drives.Geared(pp.drives.ConstantTorque(-0.7705), 10.0, efficiency=0.8)

# what the press is given; what the oracle is; angle, speed, speed of the flywheel, duration
SCENES: dict[str, tuple[dict[str, Any], Coupled, tuple[float, float, float | None, float]]] = {
    "a weak brake and drawing": (
        {"brake": Brake(4.0), "loads": [DRAWING[0]], "flywheel": Flywheel(3.0)},
        Coupled(3.0, brake=always(4.0), loads=[DRAWING[1]]),
        (1.5, 5.0, None, 1.0),
    ),
    "a brake that closes on the way up": (
        {"brake": Brake(4.0, closes=At(time=0.1)), "loads": [DRAWING[0]], "flywheel": Flywheel(3.0)},
        Coupled(3.0, brake=from_on(4.0, 0.1), breaks=[0.1], loads=[DRAWING[1]]),
        (1.5, 5.0, None, 1.0),
    ),
    "a load of no force": (
        {"brake": Brake(4.0), "loads": [NOTHING[0]], "flywheel": Flywheel(3.0)},
        Coupled(3.0, brake=always(4.0), loads=[NOTHING[1]]),
        (1.5, 5.0, None, 1.0),
    ),
    "a stronger brake and blanking": (
        {"brake": Brake(30.0), "loads": [PUNCH[0]], "flywheel": Flywheel(3.0)},
        Coupled(3.0, brake=always(30.0), loads=[PUNCH[1]]),
        (1.5, 5.0, None, 1.0),
    ),
    "from rest against a brake": (
        {"brake": Brake(4.0), "loads": [DRAWING[0]], "flywheel": Flywheel(3.0)},
        Coupled(3.0, brake=always(4.0), loads=[DRAWING[1]]),
        (1.5, 0.0, None, 1.0),
    ),
    "a load holds, the clutch slips": (
        {"drive": pp.drives.ConstantTorque(100.0), "clutch": Clutch(50.0), "loads": [DEEP[0]], "flywheel": Flywheel(5.0)},
        Coupled(5.0, lambda speed, side: 100.0, always(50.0), loads=[DEEP[1]]),
        (-1.0, 0.0, None, 0.5),
    ),
    "a load holds until the brake lets the weights start": (
        {"brake": Brake(60.0, opens=At(time=0.2)), "loads": [DRAWING[0]], "flywheel": Flywheel(3.0)},
        Coupled(3.0, brake=until(60.0, 0.2), breaks=[0.2], loads=[DRAWING[1]]),
        (1.0, 3.0, None, 0.9),
    ),
    "clutch and brake slip": (
        {
            "clutch": Clutch(30.0, closes=At(time=0.05)),
            "brake": Brake(20.0, closes=At(time=0.2)),
            "loads": [DRAWING[0]],
            "flywheel": Flywheel(2.0, speed=6.0),
        },
        Coupled(2.0, clutch=from_on(30.0, 0.05), brake=from_on(20.0, 0.2), breaks=[0.05, 0.2], loads=[DRAWING[1]]),
        (1.0, 0.0, 6.0, 0.7),
    ),
    "clutch and brake hold a crank that a drive pulls": (
        {
            "drive": pp.drives.ConstantTorque(70.0),
            "clutch": Clutch(40.0),
            "brake": Brake(150.0, opens=At(time=0.3)),
            "loads": [PUNCH[0]],
            "flywheel": Flywheel(5.0),
        },
        Coupled(5.0, lambda speed, side: 70.0, always(40.0), until(150.0, 0.3), [0.3], [PUNCH[1]]),
        (0.8, 0.0, None, 0.6),
    ),
    "a motor behind clutch and gears with losses": (
        {
            "drive": INDUCTION,
            "clutch": Clutch(60.0),
            "brake": Brake(25.0, opens=At(time=0.2)),
            "loads": [DRAWING[0]],
            "flywheel": Flywheel(2.0, speed=-2.0),
        },
        Coupled(2.0, kloss(2.2e3, 1430 * np.pi / 30, 15.0, 0.95), always(60.0), until(25.0, 0.2), [0.2], [DRAWING[1]]),
        (-1.2, 0.0, -2.0, 0.4),
    ),
    "gears with losses, a brake that opens": (
        {"drive": CONSTANT, "brake": Brake(5.334, opens=At(time=0.364)), "flywheel": Flywheel(0.4638)},
        Coupled(0.4638, lossy(-7.705, 0.8), brake=until(5.334, 0.364), breaks=[0.364]),
        (-1.654, 0.0, None, 0.6),
    ),
    "gears with losses hold the crank": (
        {"drive": pp.drives.Geared(pp.drives.ConstantTorque(9.5), 10.0, efficiency=0.8), "flywheel": Flywheel(3.0)},
        Coupled(3.0, lossy(95.0, 0.8)),
        (1.2, 4.0, None, 0.8),
    ),
}


@pytest.mark.one_in(18)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.filterwarnings("ignore:the press stands from", "ignore:the slide turns down again")
def test_couplings_loads_and_losses_at_rest(press, scene, method):
    parts, oracle, (angle, speed, own, duration) = SCENES[scene]
    run = pp.simulate(press, duration, angle=angle, speed=speed, points=3, method=method, tolerance=1e-10, **parts)
    q, w, wheel = oracle.run(duration, angle, speed, own)
    assert run.crank_angle[-1] == pytest.approx(q, abs=1e-7)
    assert run.crank_speed[-1] == pytest.approx(w, abs=1e-6)
    assert run.drive_speed[-1] == pytest.approx(wheel, abs=1e-6)


TORQUES = [(drive, clutch, brake) for drive in (-90.0, 20.0, 90.0) for clutch in (None, 15.0, 200.0) for brake in (None, 10.0, 70.0)]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.filterwarnings("ignore:the press stands from")
def test_the_crank_rests_where_its_torques_lie_within_what_holds(press, method):
    """Drive or clutch pull at the crank, the weights too; the load resists on the way down, and the brake up to its own torque both ways.
    Else the crank starts with the acceleration of `textbook_crank_slide`, with the flywheel if the clutch can take that along."""
    angle, flywheel, force = -1.0, 50.0, 400.0
    at, weights, carried = height(angle, math), -slope(potential, angle), inertia(angle, math)
    load = pp.loads.Blanking(force, 0.2, 0.0)
    falling = force * math.sin(0.5 * math.pi * (0.2 - at) / 0.2) * lever(angle, math)  # forwards is the way down here
    for drive, clutch, brake in TORQUES:
        holds = brake or 0.0

        def start(torque, mass, holds=holds):
            """Acceleration of a mass with the crank, 0 where it rests."""
            forward, back = torque + weights + falling - holds, torque + weights + holds
            return (forward if forward > 0 else min(back, 0.0)) / (carried + mass)

        together = start(drive, flywheel)
        through = drive - flywheel * together
        slips = clutch is not None and abs(through) > clutch
        crank = start(math.copysign(clutch, through), 0.0) if slips else together
        wheel = (drive - math.copysign(clutch, through)) / flywheel if slips else together
        parts: dict[str, Any] = {"brake": brake and Brake(brake), "clutch": clutch and Clutch(clutch), "loads": [load]}
        given = {"angle": angle, "drive": pp.drives.ConstantTorque(drive), "flywheel": Flywheel(flywheel), "method": method, **parts}
        if crank == 0.0 and clutch is None and brake is None:
            with pytest.raises(pp.SimulationError, match="stalls"):
                pp.simulate(press, 1e-3, **given)
            continue
        run = pp.simulate(press, 1e-3, points=3, **given)
        assert run.crank_acceleration[0] == pytest.approx(crank, rel=1e-8)
        assert (run.crank_speed == 0.0).all() == (crank == 0.0)
        assert run.drive_speed[-1] == pytest.approx(1e-3 * wheel, rel=1e-2, abs=1e-15)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.filterwarnings("ignore:Clutch is")
def test_a_crank_that_moves_by_rounding_alone_makes_no_jump(press, method):
    """At bottom dead centre a clutch of 6e-14 N m pulls at a crank until 0.2 s, after which it turns by 1e-14 rad."""
    clutch = Clutch(6.442196776035303e-14, opens=At(time=0.2))
    drive = pp.drives.Geared(pp.drives.ConstantTorque(-1.0), 10.0, efficiency=0.8)
    given: dict[str, Any] = {"drive": drive, "clutch": clutch, "flywheel": Flywheel(20.0), "loads": [pp.loads.ConstantForce(1000.0, 0.2)]}
    run = pp.simulate(press, 0.5, method=method, points=3, tolerance=1e-9, **given)
    assert np.abs(run.crank_angle).max() < 1e-9
    assert run.drive_speed[-1] == pytest.approx(-0.2, rel=1e-12)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("angle", [0.0, math.pi])
def test_a_clutch_whose_torque_rises_between_sides_that_coast_alike(press, angle, method):
    """At a dead centre it has to transmit nothing at first, and has no torque yet. One of 5 kN m can hold what comes; the other slips."""
    closes, wheel = At(angle=angle), Flywheel(20.0)
    for torque, holds in ((5e3, True), (50.0, False)):
        run = pp.simulate(
            press, 0.3, angle=angle, speed=2.0, flywheel=wheel, clutch=Clutch(torque, closes=closes, rise=0.05), method=method
        )
        oracle = Coupled(20.0, clutch=lambda time, torque=torque: torque * min(1.0, time / 0.05), breaks=[0.05])
        q, w, own = oracle.run(0.3, angle, 2.0)
        assert (run.crank_angle[-1], run.crank_speed[-1], run.drive_speed[-1]) == pytest.approx((q, w, own), abs=1e-6)
        assert (run.crank_speed[-1] == pytest.approx(run.drive_speed[-1], abs=1e-6)) == holds


@pytest.mark.exhaustive
def test_a_slide_that_swings_back_on_its_work_is_warned_of(press):
    """The brake lets the weights go: the slide comes up from below the load, does not reach its start, and comes down on it again."""
    given: dict[str, Any] = {
        "angle": -1.2,
        "speed": 2.0,
        "flywheel": Flywheel(0.5),
        "loads": [pp.loads.DeepDrawing(100.0, 0.19)],
        "brake": Brake(1.0),
    }
    for method in METHODS:
        with pytest.warns(pp.PinpressWarning, match="turns down again at .* within the heights of a load"):
            pp.simulate(press, 1.5, method=method, **given)
    pp.simulate(press, 0.3, **given)  # it has not turned yet


MOTORS = [
    pp.drives.InductionMotor(2.2e3, 1430 * pp.RPM, inertia=0.01),
    pp.drives.InverterMotor(15.0, 1430 * pp.RPM, 45.0, inertia=0.01),
    pp.drives.SlipClutchMotor(15.0, 1450 * pp.RPM, 1320 * pp.RPM, 1200 * pp.RPM, inertia=0.01),
]


@pytest.mark.one_in(3)
@pytest.mark.parametrize("motor", MOTORS, ids=lambda motor: type(motor).__name__)
def test_a_motor_that_turns_the_other_way(press, motor):
    """Its rotating field has one direction. Against that it brakes at every speed, so that there is no steady state; a run may begin so."""
    wheel, speed = Flywheel(20.0), -8.0
    given: dict[str, Any] = {"drive": pp.drives.Geared(motor, 15.0), "flywheel": wheel}
    with pytest.raises(
        pp.SimulationError, match=r"the motor turns the other way: .* steady state near -76\.3944 r/min; .* write ratio=-15"
    ):
        pp.steady_state(press, speed, **given)
    warned = r"the motor turns the other way: .* begins with -76\.3944 r/min, .* write ratio=-15"
    with pytest.warns(pp.PinpressWarning, match=warned):
        run = pp.simulate(press, 0.2, speed=speed, **given)
    assert run.crank_speed[-1] > speed
    with pytest.warns(pp.PinpressWarning, match=warned):
        pp.simulate_batch(press, 0.02, speed=[1.0, speed], **given)
    pp.simulate(press, 0.02, speed=0.1 * speed, **given)  # swinging back a little
    # without a load the slip clutch gives no torque in a range of speeds, each of which repeats itself
    turned = {"drive": pp.drives.Geared(motor, -15.0), "flywheel": wheel}
    mirrored = pp.steady_state(press, speed, **turned).crank_speed.mean()
    assert mirrored == pytest.approx(-pp.steady_state(press, -speed, **given).crank_speed.mean(), rel=1e-5)


@pytest.mark.parametrize("method", ["reduced", "implicit", "constraint"])
def test_a_run_names_its_method(press, method):
    run = pp.simulate(press, 0.01, speed=5.0, method=method)
    assert run.stats.method == method
    assert f"method {method!r}" in str(run)


def test_a_brake_that_catches_a_crank_at_once():
    """The crank moves 0.13 mrad before the brake holds it. Errors are compared with the energy of a press in motion, by every method."""
    press, motor = texts.shipped("zxn2_3000b"), pp.drives.InductionMotor(75e3, 1485 * pp.RPM, inertia=1.2)
    given: dict[str, Any] = {"angle": 5.8262, "drive": pp.drives.Geared(motor, 20.7), "flywheel": Flywheel(4750.0)}
    brake = Brake(6260.0, closes=At(time=0.0232))
    ends = [pp.simulate(press, 0.5, brake=brake, method=method, tolerance=1e-9, **given).crank_angle[-1] for method in METHODS]
    assert np.ptp(ends) < 1e-9
    assert 1e-4 < ends[0] - 5.8262 < 2e-4


@pytest.mark.parametrize("coupled", [False, True], ids=["brake alone", "with a clutch"])
@pytest.mark.parametrize(("share", "rests"), [(1.0, True), (1.0 - 1e-6, False)])
@pytest.mark.filterwarnings("ignore:the press stands from")
def test_rounding_does_not_decide_whether_a_brake_holds(press, share, rests, coupled):
    """A brake of just the torque of the weights holds them; one that is weaker by a millionth does not."""
    clutch = Clutch(20.0, closes=At(time=9.0)) if coupled else None
    brake = Brake(share * slope(potential, 1.0))
    for loads in ([], [pp.loads.Blanking(0.0, 0.3, 0.0)]):
        run = pp.simulate(press, 0.01, angle=1.0, flywheel=Flywheel(3.0), clutch=clutch, brake=brake, loads=loads, points=3)
        assert (run.crank_speed[-1] == 0.0) == rests
