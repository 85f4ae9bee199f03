"""Presses that repeat themselves only after several turns of their driver, against states all over these turns, at crank angles given one
by one; and a crank-slider that its motor turns through a gear pair, against the crank-slider alone."""

from functools import cache

import numpy as np
import pytest
from support import texts
from support.generators import period_presses
from support.generators.machine_elements import GEARED, LEVER_GEAR
from support.generators.period_presses import TURNS
from support.generators.pin_tables import crank_slide
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.dynamics.extremes import extremes
from pinpress.elasticity import Stiffness, compliance, dead_centre_shift
from pinpress.kinematics import measures
from pinpress.loads import ConstantForce
from pinpress.loads.process import datum
from pinpress.ratings import Capacities, rate, speed_limit
from pinpress.simulation.driven_press import _process_force

SPEED = 31.0
FINE = 3600  # states of a turn
PARABOLA = 1e-9  # of slide positions [m]
LATER = 0.4  # of a step, by which the states are off those that the library takes


@pytest.fixture(scope="module", params=rest_exhaustive(("half", "third", "geared_down", "one_and_a_half"), "half", "geared_down"))
def name(request):
    return request.param


@pytest.fixture(scope="module")
def press(name):
    return period_presses.repeating(name)


@pytest.fixture(scope="module")
def driven():
    return period_presses.geared_down()


@cache
def everywhere(press, speed=SPEED, states=FINE):
    """Reactions all over the period, away from the angles that the library looks at, and far from its first turn."""
    turns = period_turns(press)
    angles = 2 * np.pi * (LATER + np.arange(states * turns)) / states
    return pp.inverse_dynamics(press, pp.servo_cycle(press, speed=speed, angle=angles))


def period_turns(press):
    """By the gear ratio alone."""
    (coupling,) = press.couplings
    return next(turns for turns in range(1, 20) if abs(turns * coupling.multiplier - round(turns * coupling.multiplier)) < 1e-9)


def peak(curve):
    """Largest of values at equal steps of a period, by the parabola through the largest and its neighbours: right to `PARABOLA`."""
    k = int(np.argmax(curve))
    before, at, after = curve[k - 1], curve[k], curve[(k + 1) % len(curve)]
    bend = 2 * at - before - after
    return at + (after - before) ** 2 / (8 * bend) if bend else at


def at(press, angle, speed=SPEED):
    return pp.inverse_dynamics(press, pp.servo_cycle(press, speed=speed, angle=np.atleast_1d(angle)))


# The period and the motion over it


def test_turns_of_a_period(press, name):
    assert press.period_turns == period_turns(press) == TURNS[name]
    assert pp.cycle(press, SPEED).period_turns == TURNS[name]
    assert pp.simulate(press, 0.05, speed=SPEED, flywheel=pp.drives.Flywheel(1.0)).period_turns == TURNS[name]
    assert pp.simulate(press, 0.05, speed=SPEED, flywheel=pp.drives.Flywheel(1.0), method="constraint").period_turns == TURNS[name]


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_cycle_is_one_period(press, name, way):
    motion = pp.cycle(press, way * SPEED)
    states = 360 * TURNS[name]
    np.testing.assert_allclose(motion.crank_angle, way * np.arange(states) * np.pi / 180, atol=1e-12)
    np.testing.assert_allclose(motion.time, np.arange(states) * np.pi / 180 / SPEED, atol=1e-12)
    few = pp.cycle(press, way * SPEED, points=50)
    np.testing.assert_allclose(few.crank_angle, way * np.arange(50) * 2 * np.pi * TURNS[name] / 50, atol=1e-12)
    whole = 360.0 * TURNS[name]
    shown = pp.servo_cycle(press, speed=SPEED, angle=np.radians([10.0, whole - 10.0, whole + 10.0, -10.0, 3 * whole + 20.0])).shown_position
    np.testing.assert_allclose(shown, [10.0, whole - 10.0, 10.0, whole - 10.0, 20.0], atol=1e-9)
    back = [pp.servo_cycle(press, speed=SPEED, angle=[1.0 + 2 * np.pi * turn]).slide_position[0] for turn in range(TURNS[name] + 1)]
    assert abs(back[-1] - back[0]) < 1e-13
    assert np.abs(np.array(back[1:-1]) - back[0]).min() > 1e-3


def test_dead_centres(press):
    found, positions = pp.dead_centres(press), everywhere(press).motion.slide_position
    assert found.turns == period_turns(press)
    for angle, position in ((found.top_angle, found.top_position), (found.bottom_angle, found.bottom_position)):
        there = pp.servo_cycle(press, speed=1.0, angle=[angle])
        assert abs(there.slide_position[0] - position) < 1e-15
        assert abs(there.slide_velocity[0]) < 1e-12
        assert 0.0 <= angle < 2 * np.pi * period_turns(press)
    assert abs(found.top_position - peak(positions)) < PARABOLA
    lowest, load = -peak(-positions), ConstantForce(1e5, 0.1)
    assert abs(found.bottom_position - lowest) < PARABOLA
    assert abs(datum(load, press) - lowest) < PARABOLA  # heights of process loads, in simulations too, are above it
    assert _process_force(press, load).datum == datum(load, press)


def test_of_equal_dead_centres_the_first(driven):
    """The two halves of this linkage are one; what is geared to it comes back after two turns, the slide after one. And of a press that is
    geared down they are those of the press alone."""
    found, alone = pp.dead_centres(driven), pp.dead_centres(texts.shipped("crank_slide"))
    np.testing.assert_allclose([found.top_angle, found.bottom_angle], [3 * np.pi, 0.0], atol=1e-12)
    np.testing.assert_allclose([found.top_position, found.bottom_position], [alone.top_position, alone.bottom_position], atol=1e-15)
    shaft = '<link name="cam"><inertial><origin xyz="0.1 0 0"/><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    joint = '</inertial></link><joint name="G" type="continuous"><parent link="frame"/><child link="cam"/><origin xyz="0.6 0 0"/>'
    text = texts.shipped("crank_slide").text.decode()
    text = text.replace("</robot>", f'{shaft}{joint}<axis xyz="0 -1 0"/><mimic joint="O" multiplier="0.5"/></joint></robot>')
    press = texts.load(text)
    assert press.period_turns == 2
    found = pp.dead_centres(press)
    assert found.turns == 1
    np.testing.assert_allclose([found.top_angle, found.bottom_angle], [np.pi, 0.0], atol=1e-12)
    twice = pp.cycle(press, SPEED)  # the cam's weight differs in the second turn, the slide's way does not
    torque = pp.inverse_dynamics(press, twice).driving_torque
    assert np.abs(torque[360:] - torque[:360]).max() > 1.0
    np.testing.assert_allclose(twice.slide_position[360:], twice.slide_position[:360], atol=1e-14)


# What is read off the states


@pytest.mark.exhaustive
def test_extremes_and_peaks(press):
    whole = 360.0 * period_turns(press)
    some = {one.quantity: one for one in extremes(pp.inverse_dynamics(press, pp.cycle(press, SPEED)))}
    truth = {one.quantity: one for one in extremes(everywhere(press))}
    assert some.keys() == truth.keys()
    for quantity, one in some.items():
        other = truth[quantity]
        tolerance = 2e-3 * max(other.range, 1e-6 * abs(other.largest))
        assert abs(one.largest - other.largest) <= tolerance
        if not quantity.endswith("magnitude"):  # smallest in a sharp corner
            assert abs(one.smallest - other.smallest) <= tolerance
        assert 0.0 <= one.largest_at < whole
    slide = pp.servo_cycle(press, speed=SPEED, angle=np.radians([some["slide position"].largest_at, some["slide position"].smallest_at]))
    np.testing.assert_allclose(1e3 * slide.slide_position, [some["slide position"].largest, some["slide position"].smallest], rtol=1e-12)


def test_the_summary_says_where(press, name):
    for way in (1.0, -1.0):
        motion = pp.cycle(press, way * SPEED)
        lines = str(pp.inverse_dynamics(press, motion)).splitlines()
        for words in ("top dead centre", "bottom dead centre"):
            (line,) = (line for line in lines if line.strip().startswith(words))
            degrees, time = line.split(words)[1].removesuffix(" s").split(" deg    at ")
            place = pp.dead_centres(press).top_position if words.startswith("top") else pp.dead_centres(press).bottom_position
            angle = way * SPEED * float(time)
            for there in (np.radians(float(degrees)), angle):
                assert abs(1e3 * (pp.servo_cycle(press, speed=1.0, angle=[there]).slide_position[0] - place)) < 2e-3
        line = next(line for line in lines if line.strip().startswith("largest torque "))
        torque, unit = line.split("N m ")[0].removeprefix("  largest torque").split(" ")[-2:]
        degrees = line.split(" at ")[1].split()[0]
        expected = at(press, np.radians(float(degrees)), way * SPEED).driving_torque[0]
        np.testing.assert_allclose(expected, float(torque) * (1e3 if unit == "k" else 1.0), rtol=1e-4)


def test_harmonics(press, name):
    """They are the force, all over the period."""
    motion = pp.servo_cycle(press, speed=SPEED, angle=np.linspace(1.0, 1.0 + 2 * np.pi * TURNS[name], 400, endpoint=False))
    found = pp.measures.harmonics(motion, pp.inverse_dynamics(press, motion).shaking_force, orders=60)
    np.testing.assert_allclose(found.orders, np.arange(len(found.orders)) / TURNS[name], rtol=1e-15)
    truth = everywhere(press)
    phases = found.orders[:, None, None] * truth.motion.crank_angle[None, ::50, None] + found.phase[:, None, :]
    force = np.sum(found.amplitude[:, None, :] * np.cos(phases), axis=0)
    assert np.abs(force - truth.shaking_force[::50]).max() < 1e-9 * np.abs(truth.shaking_force).max()
    one_turn = pp.servo_cycle(press, speed=SPEED, angle=np.linspace(0.0, 2 * np.pi, 90))
    assert pp.measures.harmonics(one_turn, np.zeros((90, 3))) is None


# Measures


def test_stroke_and_dwell(press):
    motion, truth = pp.cycle(press, SPEED), everywhere(press).motion
    ends = pp.dead_centres(press)
    assert abs(measures.stroke(motion) - ends.stroke) < 1e-8
    tolerance = 0.02 * ends.stroke
    near = truth.slide_position < ends.bottom_position + tolerance
    away = np.flatnonzero(~near)
    dwelling = np.diff(np.append(away, away[0] + len(near))).max() - 1  # states in the one stretch about the bottom
    lasting = dwelling * 2 * np.pi / FINE
    if press.name == "geared_five_bar":
        assert abs(measures.dwell_angle(motion, tolerance) - lasting) < 2 * np.pi / FINE
    assert abs(measures.dwell_time(motion, tolerance) * SPEED - measures.dwell_angle(motion, tolerance)) < 1e-12


def test_link_angles(press, name):
    motion = pp.cycle(press, SPEED)
    pins, truth = measures.bearing_positions(press, motion), measures.bearing_positions(press, everywhere(press).motion)
    upper, lower = ("C", "S") if press.name == "geared_five_bar" else ("P", "W")
    rod = truth[lower] - truth[upper]
    sine = np.abs(rod[:, 0]) / np.linalg.norm(rod, axis=1)
    assert abs(measures.pressure_angle(motion, pins[lower], pins[upper], (0, 0, 1)) - np.arcsin(peak(sine))) < 1e-8
    if press.name == "geared_five_bar":
        left, right = truth["A"] - truth["C"], truth["B"] - truth["C"]
        cosine = np.abs(np.sum(left * right, axis=1)) / np.linalg.norm(left, axis=1) / np.linalg.norm(right, axis=1)
        assert abs(measures.transmission_angle(motion, pins["C"], pins["A"], pins["B"]) - np.arccos(peak(cosine))) < 1e-8


def test_measures_of_the_working_stroke(press):
    """One press has one stroke in its two turns, another one in three; of the others there is none that is the working one."""
    motion, truth = pp.cycle(press, SPEED), everywhere(press).motion
    backwards = np.signbit(truth.slide_velocity)
    if np.sum(backwards != np.roll(backwards, 1)) > 2:
        with pytest.raises(pp.PinpressError, match=r"turns back \d+ times a period"):
            measures.quick_return_ratio(motion)
        return
    down = 2 * np.pi * backwards.sum() / FINE
    whole = 2 * np.pi * period_turns(press)
    ratio = down / (whole - down)
    assert abs(measures.quick_return_ratio(motion) / ratio - 1) < 3 * 2 * np.pi / FINE / down
    ends = pp.dead_centres(press)
    height = 0.3 * ends.stroke
    k = np.flatnonzero(backwards & (truth.slide_position < ends.bottom_position + height))[0]
    near = pp.servo_cycle(press, speed=SPEED, angle=truth.crank_angle[k] - np.linspace(0.0, 2 * np.pi / FINE, 2000))
    speed = abs(near.slide_velocity[np.abs(near.slide_position - ends.bottom_position - height).argmin()])
    assert abs(measures.speed_at(motion, height) / speed - 1) < 1e-5
    assert abs(measures.mechanical_advantage(motion, height) / (SPEED / speed) - 1) < 1e-5
    fastest = peak(-truth.slide_velocity)
    assert abs(measures.speed_ratio(motion) / (fastest * down / SPEED / ends.stroke) - 1) < 3 * 2 * np.pi / FINE / down


def test_a_part_of_the_period_is_none(press, name):
    one_turn = pp.servo_cycle(press, speed=SPEED, angle=np.radians(np.arange(360.0)))
    with pytest.raises(pp.PinpressError, match=f"the motion is not a period, {TURNS[name]} turns of the crank"):
        measures.stroke(one_turn)
    several = pp.servo_cycle(texts.shipped("crank_slide"), speed=SPEED, angle=np.radians(np.arange(720.0)))
    with pytest.raises(pp.PinpressError, match="the motion is not one turn of the crank"):
        measures.stroke(several)


# Ratings


def largest(press, item, speed=SPEED):
    result = everywhere(press, speed)
    if item == "torque":
        return peak(np.abs(result.driving_torque))
    if item == "slide acceleration":
        return peak(np.abs(result.motion.slide_acceleration))
    return peak(np.linalg.norm(result.bearing_force[item.removeprefix("bearing ")], axis=1))


@pytest.mark.parametrize("item", ["torque", "slide acceleration", "bearing O", "bearing guide"])
def test_speed_limit(name, press, item):
    """The capacity is what the item comes to at some speed, in whatever turn: that speed is found."""
    if press.name == "crank_slide":
        item = item.replace("guide", "slide_guide")
    amount = largest(press, item)
    kind, _, bearing = item.partition(" ") if item.startswith("bearing") else (item.replace(" ", "_"), "", "")
    capacities = Capacities(1e6, bearings={bearing: amount}) if kind == "bearing" else Capacities(1e6, **{kind: amount})
    limit = speed_limit(press, capacities)
    assert limit.limited_by == item
    assert abs(limit.speed / SPEED - 1) < 1e-7
    strokes_per_turn = 1.5 if name == "one_and_a_half" else 1 / period_turns(press)
    assert abs(limit.strokes_per_minute * pp.RPM - strokes_per_turn * limit.speed) < 1e-12
    assert 0.0 <= limit.crank_angle < 2 * np.pi * period_turns(press)
    there = at(press, limit.crank_angle, limit.speed)
    sizes = {"torque": abs(there.driving_torque[0]), "slide acceleration": abs(there.motion.slide_acceleration[0])}
    size = sizes[item] if item in sizes else np.linalg.norm(there.bearing_force[bearing])
    assert abs(size / amount - 1) < 1e-9


@pytest.mark.exhaustive
def test_ratings_of_a_press_that_is_geared_down(driven):
    """Its motor turns three times as fast as the crank, with a third of the torque."""
    alone = texts.shipped("crank_slide")
    given = {"bearings": {"W": 2e5}, "flywheel_inertia": 8.0, "speed_drop": 0.1, "motor_power": 2e3}
    slow, fast = Capacities(1e5, torque=6e3, **given), Capacities(1e5, torque=2e3, **given | {"flywheel_inertia": 8.0 / 9})
    for at_speed, way in ((False, 1.0), (True, -1.0)):
        mine = rate(driven, way * 3 * SPEED, fast, at_speed=at_speed, contact_height=0.02)
        theirs = rate(alone, way * SPEED, slow, at_speed=at_speed, contact_height=0.02)
        np.testing.assert_allclose(mine.crank_angle, 3 * theirs.crank_angle, atol=1e-7)
        for quantity in ("height", "force", "slide_velocity", "work"):
            scale = np.abs(getattr(theirs, quantity)).max()
            np.testing.assert_allclose(getattr(mine, quantity), getattr(theirs, quantity), atol=1e-7 * scale)
        assert mine.limited_by == theirs.limited_by
        for quantity in ("stroke", "quick_return_ratio", "contact_speed", "dwell_time"):
            np.testing.assert_allclose(getattr(mine, quantity), getattr(theirs, quantity), rtol=1e-9)
        np.testing.assert_allclose(mine.contact_advantage, 3 * theirs.contact_advantage, rtol=1e-8)
        np.testing.assert_allclose(mine.energies["motor energy"], theirs.energies["motor energy"], rtol=1e-15)
        np.testing.assert_allclose(mine.speed_limit.strokes_per_minute, theirs.speed_limit.strokes_per_minute, rtol=1e-7)
        assert str(mine).splitlines()[0] == str(theirs).splitlines()[0]  # as many strokes a minute


def test_ratings_of_a_stroke_over_two_turns():
    """Forces all the way down against inverse dynamics: what is permitted there just reaches a capacity."""
    press = period_presses.repeating("half")
    found = rate(press, SPEED, Capacities(1e6, torque=800.0, bearings={"S": 5e5}), at_speed=True, points=21)
    ends = pp.dead_centres(press)
    np.testing.assert_allclose(found.crank_angle[[0, -1]], [ends.top_angle, ends.bottom_angle], atol=1e-12)
    assert abs(found.height[0] - ends.stroke) < 1e-14
    for k in (5, 12, 17):
        loads = [ConstantForce(float(found.force[k]), ends.stroke)]
        there = pp.inverse_dynamics(press, pp.servo_cycle(press, speed=SPEED, angle=found.crank_angle[k : k + 1]), loads)
        reached = {"torque": abs(there.driving_torque[0]) / 800.0, "bearing S": np.linalg.norm(there.bearing_force["S"]) / 5e5}
        assert abs(max(reached.values()) - 1) < 1e-9


def test_an_overload_in_any_turn_is_refused():
    """Of a slow press, on the return stroke in the second turn: more than ever else."""
    press, slow = period_presses.repeating("half"), 3.0
    result = everywhere(press, slow)
    sizes = np.linalg.norm(result.bearing_force["O"], axis=1)
    since_top = (result.motion.crank_angle - pp.dead_centres(press).top_angle) % (4 * np.pi)
    others = sizes[(since_top < 2 * np.pi) | (result.motion.slide_velocity < 0)].max()
    assert sizes.max() > 1.3 * others
    with pytest.raises(pp.PinpressError, match="the force in bearing 'O' of the idle press") as refused:
        rate(press, slow, Capacities(1e6, bearings={"O": 0.999 * sizes.max()}), at_speed=True)
    angle = float(str(refused.value).split("at crank angle ")[1].split(" deg")[0])
    assert abs(np.linalg.norm(at(press, np.radians(angle), slow).bearing_force["O"][0]) / sizes.max() - 1) < 1e-3


def test_operating_points(press):
    points = pp.sweeps.operating_points(press, [0.5 * SPEED, SPEED], angles=True)
    for k, speed in enumerate((0.5 * SPEED, SPEED)):
        for bearing in press.bearings:
            truth = largest(press, f"bearing {bearing}", speed)
            found, angle = points.grid(f"peak_force_{bearing}")[k, 0], points.angles[f"peak_force_{bearing}"][k, 0]
            assert abs(found - truth) <= 1e-3 * truth
            np.testing.assert_allclose(np.linalg.norm(at(press, angle, speed).bearing_force[bearing][0]), found, rtol=1e-9)
        truth = everywhere(press, speed).driving_torque
        np.testing.assert_allclose(points.grid("largest_driving_torque")[k, 0], truth.max(), atol=1e-3 * np.ptp(truth))
        np.testing.assert_allclose(points.grid("smallest_driving_torque")[k, 0], truth.min(), atol=1e-3 * np.ptp(truth))


# Elasticity


def test_elasticity(press):
    rods = ("A", "B", "C", "S") if press.name == "geared_five_bar" else ("P", "W")
    stiffness = Stiffness(dict.fromkeys(rods, 1e8), shaft=1e6)
    found = compliance(press, stiffness)
    np.testing.assert_allclose(found.crank_angle, np.radians(np.arange(360.0 * period_turns(press))), atol=1e-12)
    positions = everywhere(press).motion.slide_position
    bottom = everywhere(press).motion.crank_angle[positions.argmin()]
    there = compliance(press, stiffness, angle=[bottom])
    assert abs(found.bottom_stiffness * there.compliance[0] - 1) < 1e-3
    assert abs(there.height[0]) < 1e-6
    assert found.height.min() > -1e-15
    shift = dead_centre_shift(press, stiffness, speed=[SPEED])
    assert abs(shift.rigid_position - positions.min()) < 1e-6
    assert abs(shift.position[0] - shift.rigid_position) < 1e-3


# --------------------------------------------------------------------------------------------------------------------- many turns away


@pytest.mark.parametrize("turns", [2, 30, 2001, 100_001])
def test_an_unbalanced_shaft_far_away_stands_where_its_gears_have_turned_it(turns):
    """A shaft on no loop, which is back only after two turns of the crank."""
    table = crank_slide(frame="O Q") | {"gears": {"Q": "-1.5 * O"}}
    table["pins"] |= {"Q": [-600, 0]}
    table["links"] |= {"balancer": {"pins": "Q", "mass": 50, "com": [100, 0], "inertia": 0.1}}
    press = pp.build(**table)
    near, far = (
        pp.inverse_dynamics(press, pp.servo_cycle(press, [2 * np.pi * at + 0.3], speed=1.0, acceleration=0.0)) for at in (turns % 2, turns)
    )
    np.testing.assert_allclose(far.driving_torque, near.driving_torque, rtol=1e-7)
    np.testing.assert_allclose(far.bearing_force["Q"], near.bearing_force["Q"], rtol=0, atol=1e-5)


@pytest.mark.parametrize("turns", [200, 3000, 8000])
def test_the_planet_of_a_lever_gear_meshes_far_away(turns):
    """Gears on a crank that are back after eight turns of the driver."""
    press = pp.build(**LEVER_GEAR | {"meshes": {"teeth": {"gears": "rod ring", "teeth": "21 35"}}})
    near, far = (pp.servo_cycle(press, [2 * np.pi * at + 0.3], speed=1.0, acceleration=0.0) for at in (0, turns))
    assert press.period_turns == 8
    np.testing.assert_allclose(far.slide_position, near.slide_position, rtol=0, atol=1e-9)


def test_a_wheel_of_prime_teeth_is_back_after_as_many_turns_of_its_pinion():
    press = pp.build(**GEARED | {"meshes": {"teeth": {"gears": "pinion crank", "teeth": "19 97"}}})
    assert press.period_turns == 97
    motion = pp.cycle(press, speed=-SPEED, points=72 * 97)
    alone = pp.cycle(pp.load("crank_slide"), speed=SPEED * 19 / 97, points=72 * 97)
    np.testing.assert_allclose(motion.slide_position[::19], alone.slide_position[np.arange(0, 72 * 97, 19) * 19 % (72 * 97)], atol=1e-11)
