"""Measures of a slide's motion against closed forms, searches by brute force, and difference quotients."""

import functools

import numpy as np
import pytest
import scipy.optimize
from hypothesis import given
from hypothesis import strategies as st
from support import texts
from support.exploring import examples
from support.oracles.closed_form_slides import crank_slide, four_bar, guide_bar, scotch_yoke, turn

import pinpress as pp
from pinpress.kinematics import measures
from pinpress.kinematics.slide_path import slide_path

SPEED = 7.54
RADIUS, ROD, OFFSET = 0.1, 0.4, 0.02

ALL = {
    "stroke": measures.stroke,
    "quick_return_ratio": measures.quick_return_ratio,
    "speed_ratio": measures.speed_ratio,
    "speed_ratio of the return": functools.partial(measures.speed_ratio, downwards=False),
    "speed_variation": functools.partial(measures.speed_variation, length=0.06),
    "speed_variation of the return": functools.partial(measures.speed_variation, length=0.12, downwards=False),
    "speed_at": functools.partial(measures.speed_at, height=0.03),
    "mechanical_advantage": functools.partial(measures.mechanical_advantage, height=0.03),
    "speed_at of the return": functools.partial(measures.speed_at, height=0.03, downwards=False),
    "dwell_angle": functools.partial(measures.dwell_angle, tolerance=1e-3),
    "dwell_time": functools.partial(measures.dwell_time, tolerance=1e-3),
}
FAMILIES = {
    "crank_slide": (crank_slide, {"radius": RADIUS, "rod": ROD, "offset": OFFSET}),
    "guide_bar": (guide_bar, {"crank": 0.108, "bar": 0.648, "coupler": 0.22, "pivot": 0.35, "guide": 0.63}),
}


def of(states, points=360, speed=SPEED, begin=0.0):
    return turn(states, points, speed, begin)


@functools.cache
def changed_by(family, parameter, change):
    """The motion of a slide with one parameter changed."""
    made, values = FAMILIES[family]
    return of(made(**values | {parameter: values[parameter] + change}))


def derivative(measure, family, parameter, by=1e-30):
    """By the complex step."""
    changed = measure(changed_by(family, parameter, 1j * by))
    assert isinstance(changed, complex)
    return changed.imag / by


def offset_crank_slide():
    """Stroke and ratio of times of the crank-slider, from the triangles at its dead centres."""
    outer, inner = ROD + RADIUS, ROD - RADIUS
    stroke = np.sqrt(outer**2 - OFFSET**2) - np.sqrt(inner**2 - OFFSET**2)
    bottom, top = -np.arcsin(OFFSET / outer), np.pi - np.arcsin(OFFSET / inner)  # crank and rod in line, on one side of the pivot or both
    working = bottom + 2 * np.pi - top
    return stroke, working / (2 * np.pi - working)


# Closed forms. 1e-12: with 360 points the quintics miss these motions by less than that.


def test_stroke_and_quick_return_of_an_offset_crank_slide():
    stroke, ratio = offset_crank_slide()
    motion = of(crank_slide())
    np.testing.assert_allclose(measures.stroke(motion), stroke, rtol=1e-12)
    np.testing.assert_allclose(measures.quick_return_ratio(motion), ratio, rtol=1e-12)
    np.testing.assert_allclose(measures.quick_return_ratio(motion, downwards=False), 1 / ratio, rtol=1e-12)


def test_a_crank_that_turns_backwards_returns_as_quickly_as_it_worked():
    forwards, backwards = of(crank_slide()), of(crank_slide(), speed=-SPEED)
    np.testing.assert_allclose(measures.quick_return_ratio(backwards), 1 / measures.quick_return_ratio(forwards), rtol=1e-12)
    for name in ("stroke", "dwell_angle", "dwell_time"):
        np.testing.assert_allclose(ALL[name](backwards), ALL[name](forwards), rtol=1e-12)
    for name in ("speed_ratio", "speed_variation", "speed_at"):  # the way down is the way up in a mirror
        np.testing.assert_allclose(ALL[name](backwards), ALL[name](forwards, downwards=False), rtol=1e-11)


def test_measures_of_a_scotch_yoke():
    """Speed proportional to sin q: its window of a length L begins at cos q = L / (2 r)."""
    motion = of(scotch_yoke(RADIUS))
    np.testing.assert_allclose(measures.stroke(motion), 2 * RADIUS, rtol=1e-12)
    np.testing.assert_allclose(measures.quick_return_ratio(motion), 1.0, rtol=1e-12)
    np.testing.assert_allclose(measures.speed_ratio(motion), np.pi / 2, rtol=1e-12)
    np.testing.assert_allclose(measures.speed_variation(motion, 0.07), 1 - np.sqrt(1 - (0.07 / (2 * RADIUS)) ** 2), rtol=1e-11)
    np.testing.assert_allclose(measures.speed_at(motion, 0.03), SPEED * np.sqrt(RADIUS**2 - 0.07**2), rtol=1e-12)
    np.testing.assert_allclose(measures.dwell_angle(motion, 0.002), 2 * np.arccos(1 - 0.002 / RADIUS), rtol=1e-12)
    np.testing.assert_allclose(measures.dwell_time(motion, 0.002), 2 * np.arccos(1 - 0.002 / RADIUS) / SPEED, rtol=1e-12)


def test_dwell_and_contact_speed_of_a_centred_crank_slide():
    """From the triangle of crank, rod and the distance between pivot and slide."""
    motion = of(crank_slide(offset=0.0))

    def angle(height):
        distance = ROD + RADIUS - height
        return np.arccos((distance**2 + RADIUS**2 - ROD**2) / (2 * RADIUS * distance))

    for height in (1e-6, 1e-3, 0.05, 0.1999):  # 1e-9 for the least: the position's last digit moves the angle by that
        np.testing.assert_allclose(measures.dwell_angle(motion, height), 2 * angle(height), rtol=1e-9 if height < 1e-5 else 1e-11)
        speed = SPEED * crank_slide(offset=0.0)(angle(height))[1]
        np.testing.assert_allclose(measures.speed_at(motion, height), speed, rtol=1e-9 if height < 1e-5 else 1e-11)
        np.testing.assert_allclose(measures.mechanical_advantage(motion, height), SPEED / speed, rtol=1e-9 if height < 1e-5 else 1e-11)


@pytest.mark.parametrize("name", ["thin_wall", "zxn2_3000b", "crank_slide", "jf75g_125"])
def test_the_stroke_of_a_press_is_that_between_its_dead_centres(name):
    """These are found on the closed linkage itself. 1e-10 is asked for; at 360 points the quintics are better."""
    press = texts.shipped(name)
    ends, motion = pp.dead_centres(press), pp.cycle(press, speed=SPEED)
    np.testing.assert_allclose(measures.stroke(motion), ends.stroke, rtol=1e-12)
    down = (ends.bottom_angle - ends.top_angle) % (2 * np.pi)
    np.testing.assert_allclose(measures.quick_return_ratio(motion), down / (2 * np.pi - down), rtol=1e-11)
    assert type(measures.stroke(motion)) is float


# Between the states


def test_the_quintics_miss_the_path_by_the_sixth_power_of_the_step():
    """Halving the step divides by 2^6 = 64; the share of the next term is a few per cent with 45 points."""
    places = np.linspace(0.0, 1.0, 1001)[:-1]

    def missed(points):
        path = slide_path(of(crank_slide(), points))
        return np.abs(path.at(places * points)[0].real - crank_slide()(2 * np.pi * places)[0]).max()

    errors = np.array([missed(points) for points in (45, 90, 180)])
    np.testing.assert_allclose(errors[:-1] / errors[1:], 64, rtol=0.1)
    assert errors[-1] < 1e-12 * 0.2
    assert missed(360) < 1e-14  # 10 times rounding


@pytest.mark.parametrize("measure", ALL)
def test_every_measure_converges_with_the_states(measure):
    """Worst of three first states. Speeds are missed by the fifth power of the step, 4^5 = 1024 from 45 to 180 points; 4^4 leaves room for
    where the dead centres are among the states. 1e-10 with 360 points: of the measure, of the highest speed for a drop of it."""
    for states in (crank_slide(), guide_bar()):
        exact = ALL[measure](of(states, 1440))

        def error(points, states=states, exact=exact):
            begins = np.array([0.0, 0.3, 0.6]) * 2 * np.pi / points
            scale = 1.0 if "speed_variation" in measure else exact
            return max(abs(ALL[measure](of(states, points, begin=begin)) - exact) / scale for begin in begins)

        assert error(180) < error(45) / 4**4
        assert error(360) < 1e-10


@examples(8)
@given(st.lists(st.floats(-1, 1), min_size=7, max_size=7), st.floats(0.05, 0.6))
def test_flatness_is_the_least_drop_of_any_window(coefficients, share):
    """Speeds with several humps, against a search over windows on a grid: 1e-4 is the grid's step."""
    assert_least(humps(coefficients), share)


# What the evenest window of some is like: its ends are equally fast; it lies on a flank; it begins as fast as a hollow within it is.
WINDOWS = {
    "equal ends": ([0.6, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0], 0.3),
    "on a flank": ([0.0, -0.22, 0.96, -0.83, -0.65, 0.27, -0.78], 0.34),
    "from a level": ([0.88, 0.97, -0.24, -0.91, 0.27, 0.91, 0.91], 0.49),
}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("kind", WINDOWS)
def test_every_kind_of_evenest_window_is_found_and_differentiated(kind):
    """By the complex step, by the first hump, against central differences: 1e-8, of their step squared."""
    coefficients, share = WINDOWS[kind]
    assert_least(humps(coefficients), share)
    length, step = share * measures.stroke(of(humped(humps(coefficients)))), 1e-30

    def speed_variation(change):
        return measures.speed_variation(of(humped(humps(coefficients) + change * np.eye(7)[0]), points=720), length, downwards=False)

    quotient = (speed_variation(1e-5) - speed_variation(-1e-5)) / 2e-5
    assert abs(speed_variation(1j * step).imag / step - quotient) < 1e-8


def humps(coefficients):
    """Seven, small enough together that the slide does not turn back among them."""
    size = np.abs(coefficients).sum()
    return np.array(coefficients) * (min(1.0, 0.8 / size) if size else 1.0)


def humped(coefficients):
    """A slide that rises from 0 to pi with the speed sin q (1 + humps), and falls the other half."""
    angle = np.arange(32) * np.pi / 16
    waves = [np.cos(k * angle) for k in (1, 2, 3, 4)] + [np.sin(k * angle) for k in (2, 3, 4)]  # none whose mean speed is not zero
    rate = np.sin(angle) * (1 + coefficients @ np.array(waves))
    orders = np.arange(1, 6)
    cosines, sines = (rate @ wave(np.multiply.outer(angle, orders)) / 16 for wave in (np.cos, np.sin))

    def states(angle):
        cosine, sine = np.cos(np.multiply.outer(angle, orders)), np.sin(np.multiply.outer(angle, orders))
        return (
            sine @ (cosines / orders) - cosine @ (sines / orders),
            cosine @ cosines + sine @ sines,
            cosine @ (sines * orders) - sine @ (cosines * orders),
        )

    return states


def assert_least(coefficients, share):
    slide = humped(coefficients)
    motion = of(slide, points=720)
    length = share * measures.stroke(motion)
    assert abs(measures.speed_variation(motion, length, downwards=False) - searched(slide, length)) < 1e-4


def searched(slide, length):
    """The least drop over windows that begin on a grid, then on finer ones around the best, which are not all in one place."""
    angle = np.linspace(0, np.pi, 4001)
    position, speed = slide(angle)[:2]

    def drops(starts):
        ends = np.interp(np.interp(starts, angle, position) + length, position, angle)
        inside = (angle >= starts[:, None]) & (angle <= ends[:, None])
        own = np.stack([slide(starts)[1], slide(ends)[1]])
        lowest = np.minimum(np.where(inside, speed, np.inf).min(axis=1), own.min(axis=0))
        return 1 - lowest / np.maximum(np.where(inside, speed, -np.inf).max(axis=1), own.max(axis=0))

    last = np.interp(position[-1] - length, position, angle)
    starts, step = np.linspace(0.0, last, 400), last / 399
    for _ in range(2):
        best = starts[np.argsort(drops(starts))[:20]]
        starts = np.clip(np.linspace(best - step, best + step, 21).ravel(), 0.0, last)
        step /= 10
    return drops(starts).min()


# Derivatives by the complex step


@pytest.mark.one_in(8)
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("measure", ALL)
def test_the_complex_step_differentiates_every_measure(measure, family):
    """Against central differences of fourth order with steps of 1e-3 of a length: these are right to about 1e-10 of measure by length,
    1e-8 of the derivative where that is no smaller."""
    for parameter, value in FAMILIES[family][1].items():
        step = 1e-3 * 0.1

        def at(shift, parameter=parameter):
            return ALL[measure](changed_by(family, parameter, shift))

        quotient = (8 * (at(step) - at(-step)) - (at(2 * step) - at(-2 * step))) / (12 * step)
        scale = abs(at(0.0)) / value
        assert abs(derivative(ALL[measure], family, parameter) - quotient) <= 1e-8 * max(abs(quotient), scale), parameter


def test_derivatives_of_closed_forms():
    """2 r of a scotch yoke's stroke, and all that follow from its sine: 1e-10, a little more than what the measures miss."""
    step, length = 1e-30, 0.07
    motion = of(scotch_yoke(RADIUS + 1j * step))
    np.testing.assert_allclose(measures.stroke(motion).imag / step, 2.0, rtol=1e-12)
    assert abs(measures.quick_return_ratio(motion).imag / step) < 1e-10
    assert abs(measures.speed_ratio(motion).imag / step) < 1e-10
    even = np.sqrt(1 - (length / (2 * RADIUS)) ** 2)
    np.testing.assert_allclose(measures.speed_variation(motion, length).imag / step, -(length**2) / (4 * RADIUS**3 * even), rtol=1e-10)
    height = 0.03
    at_height = SPEED * height / np.sqrt(2 * RADIUS * height - height**2)
    np.testing.assert_allclose(measures.speed_at(motion, height).imag / step, at_height, rtol=1e-10)
    cosine = 1 - height / RADIUS
    dwell = -2 / np.sqrt(1 - cosine**2) * height / RADIUS**2
    np.testing.assert_allclose(measures.dwell_angle(motion, height).imag / step, dwell, rtol=1e-10)


def test_derivatives_by_the_crank_speed():
    """Speeds are proportional to it, times inversely, all else does not know it: 1e-12, rounding."""
    step = 1e-30
    motion = of(crank_slide(), speed=SPEED + 1j * step)
    powers = {"speed_at": 1, "dwell_time": -1}
    for name in (*powers, "dwell_angle", "mechanical_advantage", "stroke", "speed_variation", "speed_ratio"):
        power = powers.get(name, 0)
        value = ALL[name](motion)
        assert abs(value.imag / step - power * value.real / SPEED) <= 1e-12 * value.real


def test_a_real_motion_and_a_complex_one_have_the_same_measures():
    real, plain = of(crank_slide()), of(crank_slide(rod=ROD + 0j))
    for name, measure in ALL.items():
        assert (type(measure(real)), measure(plain)) == (float, measure(real)), name


# Angles between links


def test_pressure_angle_of_presses():
    """Chen 2002: sin = (l3 - h) / l4, with the bar upright; a centred crank-slider: sin = r / l, with the crank square to the guide. A
    smooth periodic function is known from few states: 1e-9 with 45, where its harmonics have fallen to that, rounding with 360."""
    for name, driven, other, axis, sine in (
        ("thin_wall", "E", "D", (1, 0, 0), (0.648 - 0.630) / 0.220),
        ("crank_slide", "W", "P", (0, 0, 2), 0.1 / 0.4),
    ):
        press = texts.shipped(name)
        for points, tolerance in ((45, 1e-9), (360, 1e-12)):
            motion = pp.cycle(press, speed=SPEED, points=points)
            at = measures.bearing_positions(press, motion)
            angle = measures.pressure_angle(motion, at[driven], at[other], axis)
            np.testing.assert_allclose(angle, np.arcsin(sine), rtol=tolerance)


def transmission_of_kong(crank=0.143):
    """The least angle between coupler and rocker is that with the crank in line with the frame, towards D or away from it."""
    frame = np.hypot(1.25, 0.2)
    cosines = [(1.243**2 + 0.375**2 - (frame + side * crank) ** 2) / (2 * 1.243 * 0.375) for side in (-1, 1)]
    return np.arccos(max(cosines, key=abs))


def test_transmission_angle_of_a_crank_rocker():
    """Kong 2025, at the pin of coupler and rocker. 1e-10: the lengths of its file are rounded at 15 digits, the angles closed to 1e-13."""
    press = texts.shipped("zxn2_3000b")
    motion = pp.cycle(press, speed=SPEED)
    at = measures.bearing_positions(press, motion)
    np.testing.assert_allclose(measures.transmission_angle(motion, at["C"], at["B"], at["D"]), transmission_of_kong(), rtol=1e-10)
    assert measures.transmission_angle(motion, at["B"], at["A"], at["C"]) == 0.0  # the crank passes the coupler's line


def test_angles_are_differentiated_by_the_complex_step():
    """By the crank's length. Against difference quotients of the closed form, 1e-8, their rounding, and of sin = r / l itself."""
    step, turned = 1e-30, of(scotch_yoke())
    pins = four_bar(crank=0.143 + 1j * step)(turned.crank_angle)
    angle = measures.transmission_angle(turned, pins[1], pins[0], pins[2])
    np.testing.assert_allclose(angle.real, transmission_of_kong(), rtol=1e-12)
    quotient = (transmission_of_kong(0.143 + 1e-6) - transmission_of_kong(0.143 - 1e-6)) / 2e-6
    np.testing.assert_allclose(angle.imag / step, quotient, rtol=1e-8)

    radius, q, zero = RADIUS + 1j * step, turned.crank_angle, np.zeros(360)
    crank_pin = np.stack([radius * np.sin(q), zero, -radius * np.cos(q)], axis=1)
    slide_pin = np.stack([zero, zero, crank_slide(radius, offset=0.0)(q)[0]], axis=1)
    angle = measures.pressure_angle(turned, slide_pin, crank_pin, (0, 0, 1))
    np.testing.assert_allclose(angle.imag / step, 1 / np.sqrt(ROD**2 - RADIUS**2), rtol=1e-11)


def test_a_link_that_turns_over_has_a_pressure_angle_of_a_right_angle():
    motion = of(scotch_yoke())
    tip = np.stack([np.sin(motion.crank_angle), np.zeros(360), np.cos(motion.crank_angle)], axis=1)
    assert measures.pressure_angle(motion, tip, np.zeros((360, 3)), (0, 0, 1)) == 0.5 * np.pi
    assert measures.pressure_angle(motion, np.tile([0.0, 0.0, 1.0], (360, 1)), np.zeros((360, 3)), (0, 0, 1)) == 0.0


def test_bearing_positions_are_where_pinocchio_has_them():
    import pinocchio as pin

    press = texts.shipped("zxn2_3000b")
    motion = pp.cycle(press, speed=SPEED, points=5)
    at = measures.bearing_positions(press, motion)
    assert tuple(at) == press.bearings
    data = press.model.createData()
    pin.forwardKinematics(press.model, data, np.array(motion.q[3]))
    np.testing.assert_allclose(at["B"][3], data.oMi[press.joints.index("B") + 1].translation, atol=1e-14)
    loop = press.loops[0]
    np.testing.assert_allclose(at[loop.name][3], data.oMi[loop.joint2].act(loop.point2), atol=1e-12)  # the loop's other side
    with pytest.raises(pp.UnknownNameError, match="no bearing 'Q'"):
        at["Q"]


@pytest.mark.parametrize("after", [0.5, 2.0, 4.0])
def test_dwell_up_to_a_hump_between_states(after):
    """The slide has two bottoms with a low hump between them: it leaves the deeper one where the hump begins to rise above the tolerance,
    which may be between two states, behind the deepest point of the turn or before it."""

    def path(y):
        return -np.cos(y) + 0.45 * np.cos(2 * y) + 0.05 * np.sin(y)

    hump = scipy.optimize.minimize_scalar(lambda y: -path(y), bounds=(-0.5, 0.5), method="bounded", options={"xatol": 1e-12}).x
    deepest = scipy.optimize.minimize_scalar(path, bounds=(-1.5, -0.5), method="bounded", options={"xatol": 1e-12}).x
    states = 72
    begin = (round(after * states / (2 * np.pi)) + 0.5) * 2 * np.pi / states - hump  # the hump is in the middle between two states

    def moved(q):
        y = q - begin
        first, second = np.sin(y) - 0.9 * np.sin(2 * y) + 0.05 * np.cos(y), np.cos(y) - 1.8 * np.cos(2 * y) - 0.05 * np.sin(y)
        return path(y), first, second

    beside = path(hump + np.pi / states)
    tolerance = 0.5 * (path(hump) + max(beside, path(hump - np.pi / states))) - path(deepest)
    level = path(deepest) + tolerance
    leaves = scipy.optimize.brentq(lambda y: path(y) - level, deepest, hump)
    comes = scipy.optimize.brentq(lambda y: path(y) - level, -3.0, deepest)
    assert measures.dwell_angle(of(moved, points=states), tolerance) == pytest.approx(leaves - comes, rel=1e-6)


def test_equal_strokes_are_measured_and_others_have_no_one_working_stroke():
    """A slide goes down and up twice a turn, harmonically; a little harmonic of half the frequency makes the strokes differ."""
    twice = of(lambda q: (-np.cos(2 * q), 2 * np.sin(2 * q), 4 * np.cos(2 * q)))
    np.testing.assert_allclose(measures.stroke(twice), 2.0, rtol=1e-12)
    np.testing.assert_allclose(measures.dwell_angle(twice, 0.5), np.arccos(0.5), rtol=1e-11)
    np.testing.assert_allclose(measures.speed_ratio(twice), np.pi / 2, rtol=1e-9)
    np.testing.assert_allclose(measures.quick_return_ratio(twice), 1.0, rtol=1e-12)
    differing = of(lambda q: (-np.cos(2 * q) - 0.1 * np.cos(q), 2 * np.sin(2 * q) + 0.1 * np.sin(q), 4 * np.cos(2 * q) + 0.1 * np.cos(q)))
    with pytest.raises(pp.PinpressError, match="4 times a period"):
        measures.speed_ratio(differing)


@pytest.mark.exhaustive
def test_distances_next_to_the_limits_are_measured_or_refused():
    """Never a number that is not finite or outside its range, and no crash."""
    motion = of(crank_slide())
    stroke = measures.stroke(motion)
    for share in (1e-15, 1e-12, 1e-6, 1 - 1e-6, 1 - 1e-12, 1 - 2e-16):
        for measure, least, most in ((measures.speed_variation, 0, 1), (measures.speed_at, 0, 2), (measures.dwell_angle, 0, 2 * np.pi)):
            try:
                value = measure(motion, share * stroke)
            except pp.PinpressError:
                continue
            assert least <= value <= most
