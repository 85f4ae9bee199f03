"""Servo motions from any part of them: what is missing is derived as exactly as the states allow, what contradicts is refused."""

import re
import warnings
from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support import texts
from support.exploring import examples
from support.generators.small_linkages import two_cranks

import pinpress as pp
from pinpress.kinematics.sampled_column import SampledColumn

TURN = 2 * np.pi


@pytest.fixture(scope="module")
def press():
    return texts.shipped("zxn2_3000b")


def rest_to_rest(time):
    """One turn in a second from rest to rest."""
    return {
        "angle": TURN * time - np.sin(TURN * time),
        "speed": TURN * (1 - np.cos(TURN * time)),
        "acceleration": TURN**2 * np.sin(TURN * time),
        "time": time,
    }


def swaying(time):
    """One turn in a second, never at rest, and unlike itself backwards."""
    a, b = TURN * time, 2 * TURN * time + 1.0
    return {
        "angle": 0.4 + a + 0.3 * np.sin(a) + 0.1 * np.cos(b),
        "speed": TURN * (1 + 0.3 * np.cos(a) - 0.2 * np.sin(b)),
        "acceleration": TURN**2 * (-0.3 * np.sin(a) - 0.4 * np.cos(b)),
        "time": time,
    }


def pendulum(time):
    """To and fro, through crank angle 3."""
    return {"angle": 3 + np.sin(5 * time), "speed": 5 * np.cos(5 * time), "acceleration": -25 * np.sin(5 * time), "time": time}


MOTIONS = {"rest to rest": rest_to_rest, "swaying": swaying, "pendulum": pendulum}


def even(states):
    """Times from 0 to 1 in equal steps."""
    return np.linspace(0.0, 1.0, states)


def uneven(states):
    """And in others, up to twice and three times as long as the shortest."""
    return even(states) + 0.05 * np.sin(3 * np.pi * even(states))


def moved(press, given, *names, **others):
    return pp.servo_cycle(press, **{name: given[name] for name in names}, **others)


def errors(motion, given):
    """Largest errors of angle, speed and acceleration, relative to their largest values."""
    found = {"angle": motion.crank_angle, "speed": motion.crank_speed, "acceleration": motion.crank_acceleration}
    return {name: np.abs(values - given[name]).max() / np.abs(given[name]).max() for name, values in found.items()}


# --------------------------------------------------------------------------------------------------------------- what is missing is derived

PARTS = {
    "angle": (("angle", "time"), {"speed": 5.0, "acceleration": 4.0}),
    "angle and speed": (("angle", "speed", "time"), {"acceleration": 5.0}),
    "angle and acceleration": (("angle", "acceleration", "time"), {"speed": 5.0}),
    "speed": (("speed", "time"), {"angle": 6.0, "acceleration": 5.0}),
    "acceleration": (("acceleration", "time"), {"angle": 6.0, "speed": 6.0}),
}


def start_of(whole, part):
    """What a part does not determine."""
    start = {} if part.startswith("angle") else {"angle": whole["angle"][0]}
    return start | ({"speed": whole["speed"][0]} if part == "acceleration" else {})


@pytest.mark.parametrize("times", [even, uneven])
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("part", PARTS)
def test_what_is_missing_converges_with_the_order_that_is_said(press, part, motion, times):
    names, orders = PARTS[part]
    missed = []
    for states in (90, 180):
        whole = MOTIONS[motion](times(states))
        missed.append(errors(moved(press, whole, *names, **start_of(whole, part)), whole))
    for name, order in orders.items():
        coarse, fine = (error[name] for error in missed)
        assert fine < 1e-3
        assert coarse > 2 ** (order - (0.4 if times is even else 1.0)) * fine or fine < 1e-12


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("states", [32, 33])
@pytest.mark.parametrize("repeated", [False, True])
def test_a_closed_motion_in_equal_steps_is_derived_to_rounding(press, part, states, repeated):
    """Also to and fro, and backwards."""
    names, _ = PARTS[part]
    time = np.linspace(0.0, 1.0, states + repeated, endpoint=repeated)
    backwards = {name: values if name == "time" else -values for name, values in swaying(time).items()}
    for whole, period in ((swaying(time), 1.0), (backwards, 1.0), (pendulum(time * TURN / 5), TURN / 5)):
        motion = moved(press, whole, *names, **start_of(whole, part), period=period)
        assert max(errors(motion, whole).values()) < 1e-11
        assert len(motion.time) == states + repeated


def test_a_closed_motion_in_unequal_steps_has_no_ends(press):
    """There the periodic spline errs no more than elsewhere, other than one that is not closed."""
    whole = swaying(uneven(81)[:-1])
    closed, open_ended = (moved(press, whole, "angle", "time", **more) for more in ({"period": 1.0}, {}))
    ends = np.r_[0:3, -3:0]
    missed = [np.abs(motion.crank_acceleration - whole["acceleration"])[ends].max() for motion in (closed, open_ended)]
    assert missed[0] < 0.1 * missed[1]
    np.testing.assert_allclose(closed.crank_acceleration, open_ended.crank_acceleration, atol=2e-3 * np.ptp(whole["acceleration"]))


def test_a_corner_in_a_closed_motion_stays_where_it_is(press):
    """A speed of ramps: the trigonometric polynomial would swing in all states, the spline swings about its corners."""
    time = np.arange(200) / 200
    ramps = TURN - 1 + np.interp(time, [0.0, 0.2, 0.5, 0.7, 1.0], [0.0, 2.0, 2.0, 0.0, 0.0])
    slopes = np.where(time < 0.2, 10.0, 0.0) - np.where((time > 0.5) & (time < 0.7), 10.0, 0.0)
    motion = pp.servo_cycle(press, 0.0, speed=ramps, time=time, period=1.0)
    far = np.min([np.abs((time - corner + 0.5) % 1 - 0.5) for corner in (0.0, 0.2, 0.5, 0.7)], axis=0) > 0.05
    np.testing.assert_allclose(motion.crank_acceleration[far], slopes[far], atol=0.01)


def test_a_missing_acceleration_gives_the_true_torque_and_work(press):
    """Taken as 0 it would give a peak of 35.9 instead of 40.9 kN m, and a power balance as exact."""
    whole = rest_to_rest(np.linspace(0.0, 1.0, 201))
    derived, given, left_out = (
        pp.inverse_dynamics(press, motion)
        for motion in (
            moved(press, whole, "angle", "speed", "time"),
            moved(press, whole, "angle", "speed", "acceleration", "time"),
            moved(press, whole, "angle", "speed", acceleration=0.0),
        )
    )
    peaks = [np.abs(result.driving_torque).max() for result in (derived, given, left_out)]
    np.testing.assert_allclose(peaks, [40877.9, 40877.9, 35853.3], atol=0.1)
    np.testing.assert_allclose(derived.driving_torque, given.driving_torque, atol=1e-6 * peaks[0])
    works = [np.mean(result.driving_torque[:-1] * whole["speed"][:-1]) for result in (derived, left_out)]
    largest = np.abs(derived.driving_torque * whole["speed"]).max()
    assert abs(works[0]) < 1e-8 * largest < 1e-3 * abs(works[1])  # from rest to rest drive and weight do no work


@pytest.mark.exhaustive
def test_two_drivers():
    press, whole = two_cranks(), swaying(np.linspace(0.0, 1.0, 80))
    both = {name: values if name == "time" else np.stack([values, -0.1 * values], axis=1) for name, values in whole.items()}
    derived = (
        moved(press, both, "angle", "time"),
        moved(press, both, "angle", "speed", "time"),
        moved(press, both, "angle", "speed"),
        moved(press, both, "speed", "time", angle=both["angle"][0]),
        moved(press, both, "acceleration", "time", angle=both["angle"][0], speed=both["speed"][0]),
    )
    for motion in derived:
        assert max(errors(motion, both).values()) < 2e-4
    period = swaying(np.linspace(0.0, 1.0, 48, endpoint=False))
    closed = pp.servo_cycle(press, np.stack([period["angle"], np.cos(2 * TURN * period["time"])], axis=1), time=period["time"], period=1.0)
    np.testing.assert_allclose(closed.crank_acceleration[:, 0], period["acceleration"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(closed.crank_acceleration[:, 1], -4 * TURN**2 * np.cos(2 * TURN * period["time"]), rtol=0, atol=1e-9)
    contrary = both | {"speed": both["speed"] * [1.0, 1.02]}
    with pytest.raises(pp.PinpressError, match=r"^angle and speed do not fit together over time: .* of driver slow speed is"):
        pp.servo_cycle(press, **contrary)


@pytest.mark.exhaustive
@examples(15)
@given(
    harmonics=st.lists(st.floats(-0.3, 0.3), min_size=6, max_size=6),
    turns=st.integers(-1, 1),
    states=st.integers(70, 120),
    period=st.floats(0.2, 20.0),
)
def test_random_smooth_motions(harmonics, turns, states, period):
    press, rate = texts.shipped("crank_slide"), TURN / period
    time = np.linspace(0.0, period, states)
    orders = np.array([1, 2, 3])
    phases = np.multiply.outer(time * rate, orders)
    sines, cosines = np.array(harmonics[:3]) / orders**2, np.array(harmonics[3:]) / orders**2
    assume(abs(turns) + np.abs(harmonics).max() > 0.05)
    whole = {
        "angle": turns * rate * time + np.sin(phases) @ sines + np.cos(phases) @ cosines,
        "speed": turns * rate + rate * (np.cos(phases) @ (orders * sines) - np.sin(phases) @ (orders * cosines)),
        "acceleration": -(rate**2) * (np.sin(phases) @ (orders**2 * sines) + np.cos(phases) @ (orders**2 * cosines)),
        "time": time,
    }
    scale = {name: max(np.abs(whole[name]).max(), 1e-2 * rate**k) for k, name in enumerate(("angle", "speed", "acceleration"))}
    pp.servo_cycle(press, **whole)  # fits
    for more, bound in (({}, 1e-2), ({"period": period}, 1e-10)):
        for names in (("angle", "time"), ("angle", "speed", "time")):
            motion = moved(press, whole, *names, **more)
            assert np.abs(motion.crank_speed - whole["speed"]).max() < bound * scale["speed"]
            assert np.abs(motion.crank_acceleration - whole["acceleration"]).max() < bound * max(scale["acceleration"], rate**2)
    for name in ("speed", "acceleration"):
        if np.ptp(whole[name]) > 0.1 * scale[name]:
            with pytest.raises(pp.PinpressError, match=f"{name} do not fit together over time: at "):
                pp.servo_cycle(press, **(whole | {name: 1.05 * whole[name]}))


# ----------------------------------------------------------------------------------------------------------------------- angle and speed


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_acceleration_by_speed_over_angle(press, direction):
    """w dw/dangle, with the time in which the crank gets there."""
    for states, bound in ((40, 2e-4), (80, 5e-6)):
        angle = direction * np.linspace(0.0, TURN, states)
        speed = direction * (7 + 2 * np.cos(angle))
        motion = pp.servo_cycle(press, angle, speed=speed)
        expected = -2 * np.sin(angle) * speed * direction
        np.testing.assert_allclose(motion.crank_acceleration, expected, atol=bound * np.abs(expected).max())
        np.testing.assert_allclose(motion.time[-1], TURN / np.sqrt(45.0), rtol=bound)  # of the integral of 1 / (7 + 2 cos)


@pytest.mark.parametrize(
    ("time", "angle", "speed", "acceleration"),
    [
        pytest.param(np.linspace(0.0, 1.0, 40), lambda t: 5 * t**2, lambda t: 10 * t, lambda t: 10 + 0 * t, id="from rest"),
        pytest.param(np.linspace(-0.73, 1.2, 60), np.cos, lambda t: -np.sin(t), lambda t: -np.cos(t), id="turning back"),
    ],
)
def test_standstill_in_an_instant_is_no_obstacle(press, time, angle, speed, acceleration):
    motion = pp.servo_cycle(press, angle(time), speed=speed(time))
    np.testing.assert_allclose(motion.crank_acceleration, acceleration(time), atol=2e-8 * np.abs(acceleration(time)).max())
    np.testing.assert_allclose(motion.time, time - time[0], atol=1e-9)


@pytest.mark.parametrize(
    ("angle", "speed", "said"),
    [
        pytest.param([0.0, 0.1, 0.3, 0.3, 0.4, 0.8, 1.3], [1.0, 2.0, 0.0, 0.0, 1.0, 3.0, 4.0], "from state 2 to 3", id="dwell"),
        pytest.param(np.linspace(0, 1, 9), -np.linspace(1, 2, 9), "from state 0 to 1 .* no definite time", id="against the speed"),
        pytest.param([-0.4, -0.3, -0.2, -0.1, 0.0, 5e-324, 0.1, 0.2], np.linspace(1, 2, 8), "from state 4 to 5 .* no definite", id="twice"),
        pytest.param([0.3, 0.1, 0.7, 0.2, 0.8, 0.1, 0.0], [1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 1.0], "from state 0 to 1", id="no succession"),
        pytest.param(np.linspace(0, 1, 40) ** 3, 3 * np.linspace(0, 1, 40) ** 2, "state 0, at 0 deg, has a speed of 0", id="soft start"),
        pytest.param(np.linspace(0, 1, 9), [1, 1, 1, 1, 9, 1, 1, 1, 1], "do(es)? not", id="a peak"),
    ],
)
def test_an_acceleration_that_is_not_determined_is_refused(press, angle, speed, said):
    with pytest.raises(pp.PinpressError, match=f"angle and speed do not .*{said}"):
        pp.servo_cycle(press, angle, speed=speed)
    found = pp.servo_cycle(press, angle, speed=speed, acceleration=0.0)  # as said
    assert not found.crank_acceleration.any()


def test_states_that_stand_each_by_itself(press):
    angle = np.linspace(0.0, 1.0, 12)
    fits = pp.servo_cycle(press, angle, speed=2 + angle, acceleration=2 + angle)
    np.testing.assert_allclose(fits.time[-1], np.log(1.5), rtol=1e-8)
    for speed, acceleration in ((2 + angle, -(2 + angle)), (5.0, 3.0), (np.cos(40 * angle), np.sin(30 * angle))):
        states = pp.servo_cycle(press, angle, speed=speed, acceleration=acceleration)
        np.testing.assert_array_equal(states.crank_acceleration, np.broadcast_to(acceleration, 12))
        with pytest.raises(pp.PinpressError, match="no motion in time"):
            _ = states.time


def test_zero_acceleration_is_taken_at_its_word(press):
    whole = rest_to_rest(np.linspace(0.0, 1.0, 50))
    with pytest.warns(pp.PinpressWarning, match=r"the speed varies over time, from 0 to .* and acceleration=0.0 leaves out") as caught:
        states = moved(press, whole, "angle", "speed", "time", acceleration=0.0)
    assert [warning.filename for warning in caught] == [__file__]
    assert not states.crank_acceleration.any()
    assert not pp.servo_cycle(press, whole["angle"], speed=3.0).crank_acceleration.any()


# -------------------------------------------------------------------------------------------------------------- what contradicts is refused


@pytest.mark.parametrize(("motion", "points"), [("rest to rest", 5), *((motion, points) for motion in MOTIONS for points in (9, 30, 1000))])
def test_columns_that_fit_are_accepted(press, motion, points):
    whole = MOTIONS[motion](np.linspace(0.0, 1.0, points))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pp.servo_cycle(press, **whole)
        if points > 9:
            whole["speed"] = np.gradient(whole["angle"], whole["time"])
            whole["acceleration"] = np.gradient(whole["speed"], whole["time"])
        pp.servo_cycle(press, **whole)


ANGLE, ACCELERATION = "angle and speed do not fit together over time: at ", "speed and acceleration do not fit together over time: at "


@pytest.mark.parametrize("points", [9, 30, 1000])
@pytest.mark.parametrize(
    ("column", "factor", "said"),
    [
        pytest.param("angle", 180 / np.pi, ANGLE, id="degrees"),
        pytest.param("speed", 60 / TURN, ANGLE, id="r/min"),
        pytest.param("speed", -1.0, ANGLE, id="backwards"),
        pytest.param("speed", 0.0, ANGLE, id="at rest"),
        pytest.param("time", 1e3, "do not fit together over time", id="ms"),
        pytest.param("acceleration", 60 / TURN, ACCELERATION, id="r/min/s"),
        pytest.param("acceleration", -1.0, ACCELERATION, id="turned round"),
        pytest.param("acceleration", 0.0, ACCELERATION, id="none"),
    ],
)
def test_columns_that_are_not_each_others_derivatives_are_refused(press, points, column, factor, said):
    whole = rest_to_rest(np.linspace(0.0, 1.0, points))
    whole[column] = factor * whole[column]
    with pytest.raises(pp.PinpressError, match=said):
        pp.servo_cycle(press, **whole)


def test_few_states_that_do_not_fit_are_warned_of(press):
    """They may be too far apart."""
    whole = rest_to_rest(np.linspace(0.0, 1.0, 5))
    whole["angle"] = -whole["angle"]
    with pytest.warns(pp.PinpressWarning, match=ANGLE):
        pp.servo_cycle(press, **whole)


def test_a_contradiction_is_named_with_instant_and_both_values(press):
    whole = swaying(np.linspace(0.0, 1.0, 201))
    whole["speed"] = 1.01 * whole["speed"]
    with pytest.raises(pp.PinpressError) as caught:
        pp.servo_cycle(press, **whole)
    found = re.fullmatch(
        r"angle and speed do not fit together over time: at (\S+) s \(state (\d+), crank angle (\S+) deg\) speed is (\S+) rad/s, but"
        r" the derivative of angle is (\S+) rad/s, give or take (\S+);"
        r" give speed \[rad/s\] as the derivative of angle \[rad\] by time \[s\], or leave it out: it is derived",
        str(caught.value),
    )
    assert found is not None
    time, state, degrees, speed, derived, bound = map(float, found.groups())
    k = int(state)
    np.testing.assert_allclose(
        [time, np.radians(degrees), speed, derived],
        [whole["time"][k], whole["angle"][k], whole["speed"][k], whole["speed"][k] / 1.01],
        rtol=1e-5,
    )
    assert 0 < bound < 0.01 * abs(speed)


@pytest.mark.parametrize("column", ["angle", "speed", "acceleration"])
def test_a_wrong_number_is_found_where_it_stands_and_a_late_column_by_name(press, column):
    whole = swaying(np.linspace(0.0, 1.0, 201))
    wrong = whole[column] + 0.01 * np.abs(whole[column]).max() * (np.arange(201) == 77)
    with pytest.raises(pp.PinpressError, match=r"\(state 7[678], ") as caught:
        pp.servo_cycle(press, **whole | {column: wrong})
    assert ("angle and" in str(caught.value)) == (column != "acceleration")
    if column != "angle":
        with pytest.raises(pp.PinpressError, match=f"{column} do not fit together"):
            pp.servo_cycle(press, **whole | {column: np.concatenate([whole[column][:1], whole[column][:-1]])})


def test_corners_and_jumps_are_no_contradictions(press):
    """Ramps of speed, in all positions of their corners between the states, with the acceleration of either side."""
    for corner in np.linspace(0.4, 0.41, 11):
        time = np.linspace(0.0, 1.0, 101)
        since = np.maximum(time - corner, 0.0)
        for side in (time > corner, time >= corner):
            pp.servo_cycle(press, 4 * time + 10 * since**2, speed=4 + 20 * since, acceleration=20.0 * side, time=time)


def test_a_crank_that_stands_for_a_while(press):
    """A dwell between two smooth strokes; and one at rest all the time."""
    time = np.linspace(0.0, 1.0, 401)
    before, after = 1 - np.minimum(time / 0.4, 1.0), np.maximum(time - 0.6, 0.0) / 0.4
    whole = {"angle": 1 - before**4 + after**4, "time": time}
    motion = pp.servo_cycle(press, **whole)
    still = (time > 0.42) & (time < 0.58)
    assert np.abs(motion.crank_speed[still]).max() < 1e-4 * np.abs(motion.crank_speed).max()
    assert np.abs(motion.crank_acceleration[still]).max() < 1e-3 * np.abs(motion.crank_acceleration).max()
    pp.servo_cycle(press, **whole, speed=motion.crank_speed, acceleration=motion.crank_acceleration)
    resting = pp.servo_cycle(press, np.full(9, 0.7), time=np.arange(9.0))
    assert not resting.crank_speed.any()
    assert not resting.crank_acceleration.any()


def test_an_angle_that_begins_anew_after_a_turn(press):
    time = np.linspace(0.0, 1.0, 200)
    angle = 4 + TURN * time
    for wrapped in (np.mod(angle, TURN), (angle + np.pi) % TURN - np.pi):
        with pytest.raises(
            pp.PinpressError, match=r"angle jumps from .* to .* deg between states (\d+) and (\d+): .*numpy.unwrap\(angle\)"
        ):
            pp.servo_cycle(press, wrapped, time=time)
    assert np.ptp(pp.servo_cycle(press, np.unwrap(np.mod(angle, TURN)), time=time).crank_speed) < 1e-9


def test_runs_are_accepted_as_servo_motions():
    """With a load that breaks off, and a friction that turns round."""
    press = texts.shipped("jf75g_125_plain")
    run = pp.simulate(
        press,
        0.4,
        speed=300 * pp.RPM,
        drive=pp.drives.InductionMotor(30e3, 295 * pp.RPM, poles=20),
        flywheel=pp.drives.Flywheel(20.0),
        loads=[pp.loads.Blanking(force=2e5, start=0.004, end=0.002)],
        points=700,
    )
    given = {"angle": run.crank_angle, "speed": run.crank_speed, "acceleration": run.crank_acceleration, "time": run.time}
    pp.servo_cycle(press, **given)
    given["acceleration"] = -given["acceleration"]
    with pytest.raises(pp.PinpressError, match=ACCELERATION):
        pp.servo_cycle(press, **given)


# ----------------------------------------------------------------------------------------------------------------------------------- noise


@cache
def measured(counts):
    """Angles of an encoder of so many counts a turn."""
    whole = rest_to_rest(np.linspace(0.0, 1.0, 1001))
    return whole | {"angle": np.round(whole["angle"] / TURN * counts) / counts * TURN}


def test_an_acceleration_that_is_noise_is_warned_of(press):
    with pytest.warns(
        pp.PinpressWarning, match=r"the acceleration derived from the angle over time is dominated by noise, to about \d+ %: smooth"
    ) as caught:
        moved(press, measured(4096), "angle", "time")
    assert [warning.filename for warning in caught] == [__file__]
    fine = measured(2**24)
    assert errors(moved(press, fine, "angle", "time"), fine)["acceleration"] < 0.05


def test_too_few_states_are_warned_of(press):
    time = np.linspace(0.0, 1.0, 9)
    with pytest.warns(pp.PinpressWarning, match="is uncertain: the states are too far apart"):
        pp.servo_cycle(press, np.sin(4 * TURN * time + 0.3), time=time)


@pytest.mark.exhaustive
def test_noise_does_not_contradict_but_what_is_larger_does(press):
    random = np.random.default_rng(3)
    whole = rest_to_rest(np.linspace(0.0, 1.0, 1001))
    for _ in range(20):
        noisy = whole | {
            "angle": whole["angle"] + 1e-4 * random.normal(size=1001),
            "speed": whole["speed"] + 0.02 * random.normal(size=1001),
        }
        pp.servo_cycle(press, **noisy)
    noisy["speed"] *= 1.05
    with pytest.raises(pp.PinpressError, match=ANGLE):
        pp.servo_cycle(press, **noisy)


@pytest.mark.one_in(12)
@pytest.mark.parametrize("digits", [2, 3, 4, 6])
@pytest.mark.parametrize("states", [50, 1000, 5000])
@pytest.mark.parametrize("motion", [*MOTIONS, "constant"])
def test_numbers_as_they_are_printed_do_not_contradict(press, motion, states, digits):
    """Of a step of 0.0014 rad three digits are left, or none."""
    time = even(states)
    whole = MOTIONS[motion](time) if motion in MOTIONS else {"angle": 7 * time, "speed": 7.0 + 0 * time, "acceleration": 0 * time}
    printed = {name: np.round(whole[name], digits) for name in ("angle", "speed", "acceleration")}
    pp.servo_cycle(press, **printed, time=time)
    degrees = np.radians(np.round(np.degrees(whole["angle"]), digits))
    pp.servo_cycle(press, **(printed | {"angle": degrees}), time=time)


@pytest.mark.exhaustive
def test_speeds_of_ramps_at_random(press):
    """Corners in any places, of states in unequal steps too."""
    random = np.random.default_rng(7)
    for k in range(60):
        states = int(random.integers(60, 800))
        time = even(states) + (k % 2) * random.uniform(-0.3, 0.3, states) / states
        corners = np.concatenate([[-0.1], 0.17 * np.arange(1, 6) + random.uniform(-0.05, 0.05, 5), [1.1]])
        slopes = 15 * random.normal(size=6)
        speeds = random.normal() + np.concatenate([[0.0], np.cumsum(slopes * np.diff(corners))])
        angles = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(corners) * (speeds[1:] + speeds[:-1]))])
        piece = np.searchsorted(corners, time, side="left" if k % 3 else "right") - 1
        since = time - corners[piece]
        whole = {
            "angle": angles[piece] + since * speeds[piece] + 0.5 * slopes[piece] * since**2,
            "speed": speeds[piece] + slopes[piece] * since,
            "acceleration": slopes[piece],
            "time": time,
        }
        pp.servo_cycle(press, **whole)


# ------------------------------------------------------------------------------------------------------------------------ closed motions


def test_a_motion_that_does_not_close_is_refused(press):
    whole = swaying(np.linspace(0.0, 1.0, 41))
    with pytest.raises(pp.PinpressError, match=r"period is 1 s, but the states take 0.75 s"):
        pp.servo_cycle(press, whole["angle"][:-10], time=whole["time"][:-10], period=1.0)
    slower = whole | {"angle": 0.9 * whole["angle"], "speed": 0.9 * whole["speed"]}
    with pytest.raises(pp.PinpressError, match="after the period of 1 s the angle is 36 deg beside where it began"):
        moved(press, slower, "angle", "time", period=1.0)
    without_end = {name: values[:-1] for name, values in slower.items()}
    with pytest.raises(pp.PinpressError, match=r"the angle is not back: it goes on to 32[0-9.]* deg from its start"):
        moved(press, without_end, "angle", "time", period=1.0)
    faster = whole["speed"] + whole["time"]
    with pytest.raises(pp.PinpressError, match=r"after the period of 1 s the (angle|speed) is"):
        pp.servo_cycle(press, 0.0, speed=faster, time=whole["time"], period=1.0)


@pytest.mark.parametrize("states", [12, 40, 41])
def test_derivative_and_integral_of_a_column_undo_each_other(states):
    time = np.linspace(0.0, 3.0, states, endpoint=False)
    values = np.cos(TURN * time / 3 + 0.4) + 0.3 * np.sin(2 * TURN * time / 3)
    column = SampledColumn(time, values, 3.0)
    again = SampledColumn(time, column.derivative(1), 3.0).integral
    np.testing.assert_allclose(again, values - values[0], atol=1e-13)
    np.testing.assert_allclose(SampledColumn(time, column.derivative(1), 3.0).derivative(1), column.derivative(2), atol=1e-10)


# ----------------------------------------------------------------------------------------------------------- from the heights of the slide

SLIDES = ["zxn2_3000b", "crank_slide", "jf75g_125", "thin_wall"]


@cache
def flanks(name):
    """Crank angles of top dead centre, the bottom dead centre after it, and the top after that."""
    ends = pp.dead_centres(texts.shipped(name))
    top, bottom = ends.top_angle, ends.bottom_angle
    return top, bottom + TURN * (bottom < top), top + TURN


def heights(press, angle, exact=()):
    """Heights at crank angles, those at the states of dead centres without rounding."""
    ends = pp.dead_centres(press)
    above = pp.servo_cycle(press, angle, speed=1.0).slide_position - ends.bottom_position
    for state in exact:
        above[state] = 0.0 if above[state] < 0.5 * ends.stroke else ends.stroke
    return above


def same_turn(angle, expected):
    return angle - TURN * np.round((angle[0] - expected[0]) / TURN)


@pytest.mark.parametrize("name", SLIDES)
@pytest.mark.parametrize("flank", ["down", "up"])
def test_heights_on_either_flank(name, flank):
    press, (top, bottom, after) = texts.shipped(name), flanks(name)
    low, high = (top, bottom) if flank == "down" else (bottom, after)
    time = np.linspace(0.0, 1.0, 161)
    angle = low + (high - low) * (0.5 + 0.35 * np.sin(TURN * time + 0.3))
    motion = pp.servo_cycle(press, height=heights(press, angle), flank=flank, time=time)
    np.testing.assert_allclose(same_turn(motion.crank_angle, angle), angle, atol=1e-12)
    assert 0 <= motion.crank_angle[0] < TURN
    true = pp.servo_cycle(press, angle, time=time)
    np.testing.assert_allclose(motion.slide_velocity, true.slide_velocity, atol=1e-8 * np.abs(true.slide_velocity).max())
    np.testing.assert_allclose(motion.slide_acceleration, true.slide_acceleration, atol=1e-6 * np.abs(true.slide_acceleration).max())


@pytest.mark.filterwarnings("ignore:the acceleration derived from the angle")  # where forward and return take unlike times it jumps
@pytest.mark.parametrize("name", SLIDES)
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_table_goes_through_the_dead_centres_that_it_reaches(name, way):
    """Two turns and a half, forwards and backwards, with states in all dead centres."""
    press, (top, bottom, after) = texts.shipped(name), flanks(name)
    corners = np.array([top, bottom, after, bottom + TURN, after + TURN, bottom + 2 * TURN])
    angle = np.interp(np.arange(101) / 20, np.arange(6), corners)
    angle = angle if way > 0 else angle[::-1]
    above = heights(press, angle, exact=range(0, 101, 20))
    # Both begin between a top and the bottom after it: backwards in that bottom, from where the slide rises.
    motion = pp.servo_cycle(press, height=above, flank="down", time=np.arange(101.0))
    np.testing.assert_allclose(same_turn(motion.crank_angle, angle), angle, atol=1e-9)
    np.testing.assert_allclose(motion.slide_position - pp.dead_centres(press).bottom_position, above, atol=1e-14)


def test_a_stroke_through_bottom_dead_centre_is_smooth_there():
    """To and fro through the bottom: the crank's speed is that of the crank, though the slide's is 0."""
    press = texts.shipped("zxn2_3000b")
    _, bottom, _ = flanks("zxn2_3000b")
    time = np.linspace(0.0, 2.0, 241)
    angle = bottom + 0.5 * np.cos(np.pi * time)
    motion = pp.servo_cycle(press, height=heights(press, angle, exact=(60, 180)), flank="up", time=time, period=2.0)
    expected = -0.5 * np.pi * np.sin(np.pi * time)
    np.testing.assert_allclose(motion.crank_speed, expected, atol=1e-9)


def test_a_table_that_turns_back_above_the_bottom_turns_the_crank_back():
    press = texts.shipped("crank_slide")
    time = np.linspace(0.0, 1.0, 101)
    above = 0.06 + 0.05 * np.cos(TURN * time)
    motion = pp.servo_cycle(press, height=above, flank="down", time=time)
    np.testing.assert_allclose(motion.crank_angle, motion.crank_angle[::-1], atol=1e-9)
    np.testing.assert_allclose(motion.slide_velocity, -0.05 * TURN * np.sin(TURN * time), atol=1e-6)


def test_flanks_state_by_state():
    """They say that the crank goes through bottom dead centre between the states, or that it turns back in it."""
    press = texts.shipped("crank_slide")
    bottom = flanks("crank_slide")[1]
    angle = bottom + np.linspace(-0.65, 0.55, 12)
    above, time = heights(press, angle), np.arange(12.0)
    with pytest.raises(pp.PinpressError, match=r"turns back in state 6 at .* m from bottom dead centre and less than a step: .* flank="):
        pp.servo_cycle(press, height=above, flank="down", time=time)
    motion = pp.servo_cycle(press, height=above, flank=["down"] * 6 + ["up"] * 6, time=time)
    np.testing.assert_allclose(same_turn(motion.crank_angle, angle), angle, atol=1e-12)
    angle = bottom - 0.6 * np.linspace(-1, 1, 13) ** 2
    motion = pp.servo_cycle(press, height=heights(press, angle, exact=[6]), flank=["down"] * 13, time=np.arange(13.0))
    np.testing.assert_allclose(same_turn(motion.crank_angle, angle), angle, atol=1e-12)


def test_heights_that_are_rounded_tell_little_near_a_dead_centre():
    """0.01 mm there are 0.01 rad, of which the second derivative is many times the true acceleration."""
    press, time = texts.shipped("crank_slide"), even(201)
    top = flanks("crank_slide")[0]
    angle = top + TURN * time - 0.5 * np.sin(TURN * time)
    above = heights(press, angle, exact=(0, 100, 200))
    found = pp.servo_cycle(press, height=above, flank="down", time=time, period=1.0)
    np.testing.assert_allclose(same_turn(found.crank_angle, angle), angle, atol=1e-12)
    assert np.abs(found.crank_acceleration - 0.5 * TURN**2 * np.sin(TURN * time)).max() < 1e-5
    with pytest.warns(pp.PinpressWarning, match=r"is uncertain at .* s \(state .* as heights near a dead centre"):
        pp.servo_cycle(press, height=np.round(above, 5), flank="down", time=time, period=1.0)


@examples(20)
@given(name=st.sampled_from(SLIDES), parts=st.lists(st.floats(0.0, 1.0), min_size=6, max_size=30), down=st.booleans())
def test_any_heights_are_found_again(name, parts, down):
    """Those within a dead centre by rounding too."""
    press = texts.shipped(name)
    ends = pp.dead_centres(press)
    above = np.sort(parts) * ends.stroke
    motion = pp.servo_cycle(press, height=above, flank="down" if down else "up", time=np.arange(len(parts)) / 10)
    np.testing.assert_allclose(motion.slide_position - ends.bottom_position, above, atol=1.01e-9 * ends.stroke)
    assert np.all(np.diff(motion.crank_angle) * (-1 if down else 1) > -1e-7)
