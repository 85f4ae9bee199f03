"""Runs of screws and racks, whose slide is not back after a turn of the driver.

Right are closed forms: a slide that falls freely until it meets a die and is then a harmonic oscillator, and constant accelerations.
"""

import numpy as np
import pytest

import pinpress as pp

GRAVITY = 9.81
LEAD, INERTIA, MASS, STIFFNESS, START = 0.02, 25.0, 450.0, 1.5e8, -0.2  # lead [m/rad]
METHODS = ("auto", "implicit", "constraint")


@pytest.fixture(scope="module")
def screw():
    return pp.build(
        units="mm",
        frame="S",
        pins={"S": {"x": 0, "y": 0, "z": 0, "axis": "z"}, "Q": {"x": 0, "y": 0, "z": 1e3 * START, "axis": "z"}},
        links={
            "flywheel": {"pins": "S", "mass": 300, "com": "S", "inertia": [15, 15, INERTIA]},
            "slide": {"pins": "Q", "guide": "up", "mass": MASS},
        },
        gears={"slide_guide": f"{LEAD} * S"},
        drive="S",
    )


RADIUS, PINION, RACK = 0.03, 2.0, 8.0


@pytest.fixture(scope="module")
def rack():
    return pp.build(
        units="mm",
        frame="O",
        pins={"O": [0, 0], "Q": [30, 0]},
        links={"pinion": {"pins": "O", "mass": PINION, "disc": "30 x 40"}, "slide": {"pins": "Q", "guide": "up", "mass": RACK}},
        gears={"slide_guide": "0.03 * O"},
        drive="O",
    )


FALL = -RACK * GRAVITY * RADIUS / (0.5 * PINION * RADIUS**2 + RACK * RADIUS**2)
"""Acceleration of the pinion [rad/s2]."""


def stroke_onto_a_die(speed, die, times):
    """Speeds (n,) of the screw [rad/s] and its slide's positions (n,) [m]: free fall to the die, then a harmonic about where it carries the
    weight."""
    moving = INERTIA + MASS * LEAD**2
    fall = -MASS * GRAVITY * LEAD / moving
    hit = (die - START) / LEAD
    met = (-speed - np.sqrt(speed**2 + 2 * fall * hit)) / fall
    rate = LEAD * np.sqrt(STIFFNESS / moving)
    middle, arrives = fall / rate**2, speed + fall * met
    size, phase = np.hypot(middle, arrives / rate), np.arctan2(arrives / rate, -middle)
    since = times - met
    falling = speed + fall * times, START + LEAD * (speed * times + 0.5 * fall * times**2)
    swinging = -size * rate * np.sin(rate * since - phase), die + LEAD * (middle + size * np.cos(rate * since - phase))
    return tuple(np.where(since < 0, one, other) for one, other in zip(falling, swinging, strict=True))


@pytest.mark.one_in(3)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("speed", "die", "duration"), [(-30.0, -0.45, 0.45), (-22.0, -0.3, 0.262), (-60.0, -1.7, 1.25)])
def test_a_screw_press_meets_its_die(screw, speed, die, duration, method):
    """In the turn in which it is there, and in no other one: the last stroke goes through twelve turns."""
    load = pp.loads.ElasticDie(height=0.0, stiffness=STIFFNESS, datum=die)
    run = pp.simulate(screw, duration, speed=speed, loads=[load], method=method)
    right = stroke_onto_a_die(speed, die, run.time)
    np.testing.assert_allclose(run.crank_speed, right[0], rtol=0, atol=1e-6 * abs(speed))
    np.testing.assert_allclose(run.slide_position, right[1], rtol=0, atol=1e-8)
    np.testing.assert_allclose(run.slide_position, START + LEAD * run.crank_angle, rtol=0, atol=1e-12)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("angle", "speed", "duration"), [(6.1, 25.0, 0.03), (-6.2, -25.0, 0.02), (12.5, 12.0, 0.04), (0.0, 40.0, 0.2), (-9000.0, -90.0, 2.0)]
)
def test_a_rack_falls_freely(rack, angle, speed, duration, method):
    """From any turn through any others; the last run goes through 30 turns, more than a thousand away from the drawn pose."""
    run = pp.simulate(rack, duration, speed=speed, angle=angle, method=method)
    travelled = speed * run.time + 0.5 * FALL * run.time**2
    np.testing.assert_allclose(run.crank_angle - angle, travelled, rtol=0, atol=1e-9 * np.abs(travelled).max() + 1e-11)
    np.testing.assert_allclose(run.crank_speed, speed + FALL * run.time, rtol=0, atol=1e-9 * abs(speed))
    np.testing.assert_allclose(run.slide_position - run.slide_position[0], RADIUS * travelled, rtol=0, atol=1e-8)


def test_scenarios_are_their_runs(rack):
    """Their heights too, though the turns differ."""
    speeds = np.array([40.0, -25.0, 90.0])
    batch = pp.simulate_batch(rack, 0.3, speed=speeds, angle=6.1)
    travelled = speeds * batch.time[:, None] + 0.5 * FALL * batch.time[:, None] ** 2
    np.testing.assert_allclose(batch.crank_angle - 6.1, travelled, rtol=0, atol=1e-9)
    np.testing.assert_allclose(batch.slide_position - batch.slide_position[0], RADIUS * travelled, rtol=0, atol=1e-9)
    assert batch.errors == (None, None, None)


def test_a_motor_lifts_a_screw(screw):
    """The work of the motor is weight and speed; through many turns, and as the implicit method has it."""
    motor = pp.drives.Geared(pp.drives.InductionMotor(15e3, 1450 * pp.RPM, inertia=0.05), ratio=5.0)
    run, other = (pp.simulate(screw, 1.5, method=method, points=201, drive=motor) for method in ("auto", "implicit"))
    assert run.crank_angle[-1] > 4 * np.pi
    np.testing.assert_allclose(run.crank_angle, other.crank_angle, rtol=0, atol=1e-8)
    lifted = MASS * GRAVITY * LEAD * run.crank_angle[-1]
    moving = 0.5 * (INERTIA + MASS * LEAD**2 + 0.05 * 25.0) * run.crank_speed[-1] ** 2
    assert run.drive_work[-1] == pytest.approx(lifted + moving, rel=1e-9)


def test_friction_in_the_bearing_of_a_pinion_over_many_turns(rack):
    asked = {"speed": 40.0, "friction": {"O": pp.loads.Friction(0.1, radius=0.02)}, "points": 201}
    run, other = (pp.simulate(rack, 0.6, method=method, **asked) for method in ("auto", "implicit"))
    assert np.ptp(run.crank_angle) > 4 * np.pi
    assert run.lost[-1] > 0
    np.testing.assert_allclose(run.crank_angle, other.crank_angle, rtol=0, atol=1e-8)


def test_a_spring_that_does_not_grow_evenly_is_followed_with_all_joints(rack):
    """Its length is no multiple of the angle. An oscillator about the pinion's side: energy tells its speed."""
    spring = pp.loads.SpringDamper("frame", "slide", 500.0, 0.0, 0.0, point1=(0.13, 0.0, 0.0))
    run = pp.simulate(rack, 0.4, speed=30.0, loads=[spring])
    assert run.stats.method == "constraint"
    raised = run.slide_position - run.slide_position[0]
    moving = 0.5 * PINION * RADIUS**2 + RACK * RADIUS**2
    ends = 0.1**2 + np.array([raised, 0.0 * raised]) ** 2  # the rack's pin stands 30 mm beside the pinion
    energy = 0.5 * moving * run.crank_speed**2 + RACK * GRAVITY * raised + 250.0 * (ends[0] - ends[1])
    np.testing.assert_allclose(energy, energy[0], rtol=1e-8)
    batch = pp.simulate_batch(rack, 0.4, speed=[30.0, -20.0], loads=[spring])
    np.testing.assert_allclose(batch.crank_angle[-1, 0], run.crank_angle[-1], rtol=0, atol=1e-9)
    with pytest.raises(pp.SimulationError, match="does not come back after a turn"):
        pp.simulate(rack, 0.4, speed=30.0, loads=[spring], method="reduced")


def test_what_needs_a_period_is_refused_by_name(screw, rack):
    motor = pp.drives.Geared(pp.drives.InductionMotor(15e3, 1450 * pp.RPM), ratio=5.0)
    for press, gained in ((screw, 125.664), (rack, 188.496)):
        with pytest.raises(pp.PinpressError, match=f"'slide_guide' slides on by {gained} mm in every turn"):
            pp.cycle(press, speed=1.0)
        with pytest.raises(pp.PinpressError, match="does not turn back within its period: it has no dead centres"):
            pp.dead_centres(press)
        with pytest.raises(pp.PinpressError, match=r"does not come back after a turn, .* no steady state"):
            pp.steady_state(press, 20.0, drive=motor)
        run = pp.simulate(press, 1.0, speed=30.0, drive=motor)
        assert run.period_turns is None
        assert not len(pp.measures.stroke_duties(run))
        assert pp.measures.motor_energy(run).strokes is None


@pytest.mark.exhaustive
def test_a_feeder_beside_a_press_takes_no_period_from_it():
    """A rack along the frame that the crank drives on: the press is the same after a turn, and the forces are."""
    parts = {
        "units": "mm",
        "frame": "O",
        "links": {
            "crank": {"pins": "O A", "mass": 20},
            "rod": {"pins": "A B", "mass": 30},
            "slide": {"pins": "B", "guide": "up", "mass": 100},
            "feeder": {"pins": "F", "guide": "right", "mass": 5},
        },
        "drive": "O",
    }
    pins = {"O": [0, 0], "A": [0, 50], "B": [0, -200], "F": [300, 0]}
    press = pp.build(**parts, pins=pins, gears={"feeder_guide": "0.02 * O"}, slide="slide")
    assert press.period_turns == 1
    steady = pp.cycle(press, speed=10.0)
    later = pp.servo_cycle(press, steady.crank_angle + 8 * np.pi, speed=10.0, acceleration=0.0)
    torques = [pp.inverse_dynamics(press, motion).driving_torque for motion in (steady, later)]
    np.testing.assert_allclose(torques[1], torques[0], rtol=0, atol=1e-9 * np.abs(torques[0]).max())
    run = pp.simulate(press, 2.0, speed=10.0, points=201)
    other = pp.simulate(press, 2.0, speed=10.0, points=201, method="constraint")
    np.testing.assert_allclose(run.crank_angle, other.crank_angle, rtol=0, atol=1e-8)
