"""What motions, their measures and tables of them refuse, each with its message: a table of (call, message)."""

import dataclasses
import math
from functools import cache

import numpy as np
import pytest
from support import texts
from support.generators.malformed_linkages import GOES
from support.generators.period_presses import of_two_motors
from support.generators.small_linkages import two_cranks
from support.generators.spatial_linkages import bennett
from support.oracles.closed_form_slides import crank_slide, four_bar, scotch_yoke, turn
from support.presses.sliding_presses import BELL, TOGGLE

import pinpress as pp
from pinpress.kinematics import measures

PRESS = texts.shipped("crank_slide")
LENGTHS = {"length": measures.speed_variation, "height": measures.speed_at, "tolerance": measures.dwell_angle}
MEASURES = [
    measures.stroke,
    measures.quick_return_ratio,
    measures.speed_ratio,
    *(lambda motion, measure=measure: measure(motion, 0.03) for measure in (*LENGTHS.values(), measures.mechanical_advantage)),
    lambda motion: measures.dwell_time(motion, 1e-3),
]


def servo(press=PRESS, **given):
    return pp.servo_cycle(press, **({"angle": [0.0, 1.0], "speed": 1.0} | given))


def nine(**given):
    """A motion of nine states over 8 s."""
    return servo(**({"angle": np.arange(9.0), "time": np.arange(9.0)} | given))


def heights(**given):
    return pp.servo_cycle(PRESS, **({"height": np.linspace(0.1, 0.15, 9), "flank": "down", "time": np.arange(9.0)} | given))


@cache
def yoke(radius=0.05, points=90):
    return turn(scotch_yoke(radius), points, 7.54, 0.0)


@cache
def thin_wall():
    return pp.cycle(texts.shipped("thin_wall"), 7.54, points=720)


def of(states, points=360):
    return turn(states, points, 7.54, 0.0)


def halved(q):
    """A slide that repeats itself after two turns."""
    return -np.cos(q / 2), np.sin(q / 2) / 2, np.cos(q / 2) / 4


def pushed(driven, other, axis=(0, 0, 1)):
    return measures.pressure_angle(yoke(), driven, other, axis)


def still():
    """A crank-slide whose crank has no length."""
    text = PRESS.text.decode().replace('<origin xyz="0.100 0 0"/><axis', '<origin xyz="1e-16 0 0"/><axis')
    return texts.load(text.replace('xyz="0 0 -0.500"/>', 'xyz="0 0 -0.400"/>'))


def read(text, press=None):
    return pp.read_motion(press or of_two_motors(), texts.file(text, "m.csv"))


SERVO = [
    ({"angle": [[0.0, 1.0]]}, r"angle has shape \(1, 2\)"),
    ({"angle": 1.0}, r"angle has shape \(\)"),
    ({"angle": []}, r"angle has shape \(0,\)"),
    ({"angle": [0.0, math.nan]}, "angle is not finite at point 1"),
    ({"angle": [0.0, "x"]}, "angle is not a number"),
    ({"angle": [[0.0], [1.0, 2.0]]}, "angle is not a number"),
    ({"speed": [1.0, 2.0, 3.0]}, r"speed has shape \(3,\), but angle has \(2,\)"),
    ({"speed": [1.0]}, r"speed has shape \(1,\), but angle has \(2,\)"),
    ({"speed": [1.0, math.inf]}, "speed is not finite at point 1"),
    ({"acceleration": [1.0]}, "acceleration has shape"),
    ({"acceleration": math.nan}, "acceleration is not finite"),
    ({"time": 0.0}, r"time has shape \(\)"),
    ({"time": [0.0]}, "time has shape"),
    ({"time": [0.0, math.nan]}, "time is not finite at point 1"),
    ({"time": [1.0, 1.0]}, "time does not rise"),
    ({"angle": [0.0, 1.0, 2.0], "time": [0.0, 2.0, 1.0]}, "time does not rise"),
    ({"angle": None}, "give angle"),
    ({"angle": None, "time": [0.0, 1.0]}, "give angle, .* or height"),
    ({"speed": None}, "servo_cycle needs the speed of the driver .*, or time"),
    ({"angle": 1.0, "speed": None, "time": [0.0, 1.0]}, "angle is that at the start alone: give speed too"),
    ({"speed": None, "time": [0.0, 1.0]}, "2 states are too few to find speed and acceleration: give 6 or more"),
    ({"speed": [1.0, 2.0]}, "2 states are too few to find the acceleration"),
    ({"period": 1.0}, "period is given, but no time"),
    ({"angle": [0.0, 1.0, 2.0], "time": [0.0, 1.0, 2.0], "period": 3.0}, "2 states are too few to find a closed motion"),
    ({"flank": "up"}, "flank is given, but no height"),
    ({"height": [0.1, 0.1], "flank": "up"}, "height and angle are given: .* leave angle out"),
    ({"angle": None, "speed": None, "height": [0.1, 0.1], "flank": "up"}, "height is given, but no time"),
    ({"angle": None, "speed": None, "height": [0.1], "time": [0.0, 1.0], "flank": "up"}, "time has shape .*, but height has"),
    ({"engine": "mujoco"}, "unknown engine 'mujoco': write 'auto', 'plane', 'space' or 'pinocchio'"),
    ({"engine": None}, "unknown engine None"),
]
HEIGHTS = [
    ({"flank": 5}, "flank is 5: give"),
    ({"height": np.linspace(0.1, 0.25, 9)}, r"height is 0.25 m in state 8, which the slide does not reach: .* the stroke of 0.2 m"),
    ({"height": np.linspace(0.1, -0.001, 9)}, "height is -0.001 m in state 8, which the slide does not reach"),
    ({"flank": "left"}, "flank is 'left': give \"down\""),
    ({"flank": ["down"] * 3}, "one of both for each of the 9 states"),
    ({"flank": None}, "flank is None"),
    ({"height": np.ones((9, 2))}, r"height has shape \(9, 2\)"),
    ({"height": ["high"] * 9}, "height is not"),
]
SPEEDS = [
    *((speed, "speed is not finite") for speed in (math.nan, math.inf)),
    *((speed, "speed is 0") for speed in (0, -0.0)),
    *((speed, "speed is an array") for speed in ([1.0, 2.0], np.array([7.0]))),
    *((speed, "speed is not a number") for speed in ("fast", 1 + 2j)),
    (None, "cycle needs the speed of the driver"),
]
TABLES = [  # of two motors
    ("time [s],O [deg]\n0,1\n1,2\n", r"no column for driver 'P' of geared_five_bar: call it P \[deg\]; there are: time, O"),
    ("O [deg],P [deg]\n0,1\n1,2\n", r"m.csv.* has no column of time: call it time \[s\]; there are: O, P"),
    ("time,O,P\n0,1,2\n1,2,2\n", r"column 'O' has no unit: write it behind the name, O \[deg\]"),
    ("time [s],O [mm],P [deg]\n0,1,2\n1,2,2\n", "column 'O' is in 'mm', which is none of deg, rad, °"),
    ("time [kg],O [deg],P [deg]\n0,1,2\n1,2,2\n", "column 'time' is in 'kg', which is none of s, ms"),
    ("time [s],O [deg],P [deg]\n0,1,2\n0,2,2\n", "m.csv: time does not rise"),
    ("time [s],O [deg],P [deg]\n0,1,2\n1,x,2\n", "m.csv, line 3, O: 'x' is no number"),
    ("time [s],O [deg],O [rad]\n0,1,2\n1,2,2\n", "m.csv.* two columns are called 'O'"),
]
ONE_DRIVER = [  # what is refused of two
    (lambda press: pp.cycle(press, 1.0), "give their angles over time to pp.servo_cycle(press, angle, time=time), angle (n, 2)"),
    (pp.dead_centres, "see the lowest state of their motion"),
    (lambda press: pp.steady_state(press, 1.0, drive=pp.drives.ConstantTorque(1.0)), "let it run with simulate"),
    (lambda press: pp.simulate_batch(press, 1.0, speed=[1.0, 2.0]), "call simulate for each"),
    (lambda press: pp.ratings.rate(press, 1.0, pp.ratings.Capacities(1e6)), "rate_motion finds the force along their motion"),
    (lambda press: pp.inverse_dynamics(press, resting(press), [pp.loads.Blanking(1e5, 0.004, 0.002)]), "give datum=, a slide position [m]"),
    (lambda press: pp.measures.driving_energy(pp.inverse_dynamics(press, resting(press))), "driving_torque * crank_speed"),
    (lambda press: pp.measures.duty_cycle(pp.simulate(press, 1e-3, speed=[1.0, 0.5])), "see drive_torque, drive_speed and drive_work"),
]


def resting(press):
    return pp.servo_cycle(press, np.zeros((1, 2)), speed=0.0, acceleration=0.0)


NO_TURN = [
    (lambda: pp.servo_cycle(PRESS, angle=np.linspace(0, 1, 50), speed=1.0), "not one turn"),
    (lambda: dataclasses.replace(pp.cycle(PRESS, speed=1.0), crank_speed=np.linspace(1, 2, 360)), "constant speed"),
    (lambda: 3, "no Motion"),
]
HERE, THERE = np.zeros((90, 3)), np.ones((90, 3))
REFUSALS = [
    *((lambda given=given: servo(**given), message) for given, message in SERVO),
    *((lambda given=given: heights(**given), message) for given, message in HEIGHTS),
    *((lambda speed=speed: pp.cycle(PRESS, speed), message) for speed, message in SPEEDS),
    *(
        (lambda points=points: pp.cycle(PRESS, 7.0, points=points), "points is .*: give a whole number from 2 to 10000000")
        for points in (0, 1, -3, 2.5, 4.0, True, "360", np.array([3]), np.float64(4), 10**15, 10**30)
    ),
    *((lambda period=period: nine(period=period), f"period is {period} s, but the states take 8 s") for period in (7, 11)),
    (lambda: nine(period="a second"), "period is 'a second'"),
    (lambda: servo(texts.load(bennett()), engine="plane"), r"not a planar linkage.*: use engine='space'"),
    *(
        (lambda speed=speed: servo(speed=speed, angle=[1.0, 0.5], acceleration=0.0).time, "pass time= to servo_cycle")
        for speed in (1.0, [1.0, -1.0], [0.0, 0.0])
    ),
    (lambda: pp.servo_cycle(two_cranks(), height=np.ones(9), flank="down", time=np.arange(9.0)), "has 2 drivers"),
    *(
        (
            lambda shape=shape: pp.servo_cycle(two_cranks(), np.zeros(shape), speed=0.0, acceleration=0.0),
            r"angle has shape \(.*\): give \(n, 2\), the angles of all drivers \[rad\]",
        )
        for shape in [(5, 3), (5,), (5, 1), (0, 2), (5, 2, 1), ()]
    ),
    # tables
    *((lambda text=text: read(text), message) for text, message in TABLES),
    (
        lambda: read("t [s],crank [deg]\n0,0\n1,1\n", texts.shipped("zxn2_3000b")),
        r"call it A \[deg\] or angle \[deg\]; there are: t, crank",
    ),
    # drivers that slide
    (
        lambda: pp.servo_cycle(texts.load(BELL), [0.0, 0.16], speed=0.1, acceleration=0.0),
        "the driver slides from -100 mm to 150 mm only: keep the motion inside, or widen the <limit> of its joint",
    ),
    (lambda: texts.load(BELL).period_turns, "driver 'cylinder' of bell_crank slides to and fro: it has no period"),
    (lambda: pp.cycle(texts.load(BELL)), r"speed of the driver \[m/s\]: give one number for a period, cycle\(press, 0.1\)"),
    (lambda: pp.cycle(texts.load(BELL), 0.0), "the travel never ends"),
    (
        lambda: pp.servo_cycle(texts.load(TOGGLE), height=[0.01, 0.02], time=[0.0, 1.0], flank="down"),
        "flank is given, but the driver of screw_toggle slides",
    ),
    (
        lambda: pp.servo_cycle(
            texts.load(TOGGLE.replace('upper="0.09"', 'upper="0.17"')), height=np.linspace(0.01, 0.02, 8), time=np.linspace(0, 1, 8)
        ),
        "turns back within the driver's travel, so that a height belongs to several positions",
    ),
    # measures
    *((lambda measure=measure, motion=motion: measure(motion()), message) for motion, message in NO_TURN for measure in MEASURES),
    (lambda: pp.dead_centres(still()), "it has no dead centres"),
    (lambda: measures.stroke(of(lambda q: (np.ones_like(q), np.zeros_like(q), np.zeros_like(q)), 90)), "does not turn back"),
    (lambda: measures.stroke(pp.cycle(dataclasses.replace(PRESS, slide=None), speed=1.0)), "no slide"),
    (lambda: measures.stroke(dataclasses.replace(yoke(), slide_velocity=np.where(np.arange(90) > 14, np.nan, 1.0))), "not finite"),
    (lambda: measures.stroke(of(crank_slide(), 9)), "9 states do not resolve the slide's position"),
    (lambda: measures.stroke(of(halved)), "elsewhere after it"),
    (
        lambda: measures.pressure_angle(
            yoke(points=12), *four_bar(crank=0.5, coupler=1.0, rocker=1.0)(yoke(points=12).crank_angle)[1::-1], axis=(1, 0, 0)
        ),
        "12 states do not resolve the pressure angle",
    ),
    *(
        (lambda measure=measure, value=value: measure(yoke(), value), f"{name} is .*: give a distance between 0 and the stroke of 0.1 m")
        for name, measure in LENGTHS.items()
        for value in (0.0, -0.01, 0.2, 1.0, float("nan"), float("inf"), True, "a", None)
    ),
    *(
        (lambda length=length: pp.measures.phases(thin_wall(), length), message)
        for length, message in (
            *((length, "between 0 and the stroke") for length in (0.0, 0.4, -1.0)),
            *((length, "but for rounding") for length in (1e-300, 1e-20)),
        )
    ),
    *(
        (lambda variation=variation: measures.even_length(thin_wall(), variation), "variation")
        for variation in (0.0, 1.0, -0.1, float("nan"), 1e-14, 1 - 1e-12)
    ),
    (lambda: pushed(HERE, HERE), "one place"),
    (lambda: pushed(HERE.T, THERE), r"driven has shape \(3, 90\)"),
    (lambda: pushed(HERE, THERE, (0, 0, 0)), "axis"),
    *(
        (lambda measure=measure: measure(texts.shipped("thin_wall"), pp.cycle(PRESS, speed=1.0)), "other joints")
        for measure in (measures.bearing_positions, pp.measures.transmission_angle_curves)
    ),
    (lambda: pp.measures.least_transmission_angles(texts.load(bennett())), "planar linkages with one driver"),
    # check
    (lambda: pp.check(texts.file(GOES), driver="Q"), "no moving joint 'Q'"),
    (lambda: pp.check(texts.file(GOES), driver=("O", "O")), "twice"),
    (lambda: pp.check(texts.file(GOES), slide="rod"), "'rod' is not guided"),
    *((lambda name=name: pp.check(name), "no such file|No such file|null") for name in ("missing.urdf", "missing", "a\0b.urdf")),
]


@pytest.mark.parametrize(("call", "message"), REFUSALS, ids=[message[:40] for _, message in REFUSALS])
def test_refusals(call, message):
    with pytest.raises(pp.PinpressError, match=message):
        call()


@pytest.mark.parametrize(("ask", "remedy"), ONE_DRIVER)
def test_what_one_driver_has_is_refused_of_two_with_a_remedy(ask, remedy):
    with pytest.raises(pp.PinpressError, match="geared_five_bar has 2 drivers") as refused:
        ask(of_two_motors())
    assert remedy in str(refused.value)


@pytest.mark.parametrize(
    "given", [{"speed": 1e200}, {"speed": 1e-320}, {"speed": 1e200, "angle": [0.1, 0.2]}], ids=["turn", "time", "servo"]
)
@pytest.mark.filterwarnings("ignore:.*r/min:pinpress.PinpressWarning")
def test_motions_out_of_floating_points_range_are_refused(engine, given):
    """They are not handed back as inf or nan."""
    with pytest.raises(pp.PinpressError):
        (pp.servo_cycle if "angle" in given else pp.cycle)(PRESS, engine=engine, **given)


def test_points_are_not_clipped_and_arrays_stay_the_callers():
    for points in (2, np.int64(3), 100_003):
        assert pp.cycle(PRESS, 7.0, points=points).crank_angle.shape == (points,)
    angle, speed = np.array([0.0, 0.5]), np.array([1.0, 1.0])
    states = pp.servo_cycle(PRESS, speed=speed, angle=angle)
    angle[0] = speed[0] = 9.0
    assert (states.crank_angle[0], states.crank_speed[0]) == (0.0, 1.0)
