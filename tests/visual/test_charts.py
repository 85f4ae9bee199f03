"""What charts show, the harmonics and the table of extremes: against closed forms, quadrature and the raw arrays."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import texts
from support.exploring import examples
from support.generators.small_linkages import bolted, hybrid
from support.generators.spatial_linkages import bennett
from support.oracles import cassie

import pinpress as pp
from pinpress.common.outlets.described import charts_of
from pinpress.common.quantities import quantity as row_of
from pinpress.dynamics import described as charts
from pinpress.dynamics.extremes import at_peaks, extremes, held_moments
from pinpress.dynamics.harmonics import harmonics, last_period
from pinpress.kinematics.described import along_motion
from pinpress.kinematics.motion import is_cycle
from pinpress.visual.recording import key_frames

MASS, RADIUS, SPEED = 3.0, 0.2, 31.0
ROTOR = f"""
<robot name="rotor">
  <link name="frame"/>
  <link name="disc"><inertial><origin xyz="{RADIUS} 0 0"/><mass value="{MASS}"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  MORE
  <joint name="O" type="continuous"><parent link="frame"/><child link="disc"/><axis xyz="0 -1 0"/></joint>
  <transmission name="drive"><joint name="O"/></transmission>
</robot>
"""
SHAFT = """
  <link name="shaft"><inertial><origin xyz="0.1 0 0"/><mass value="2"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <joint name="G" type="continuous"><parent link="frame"/><child link="shaft"/><origin xyz="0.6 0 0"/><axis xyz="0 -1 0"/>
    <mimic joint="O" multiplier="RATIO"/></joint>
"""


@pytest.fixture(scope="module")
def legs():
    return texts.load(cassie.urdf())


def rotor(more=""):
    return texts.load(ROTOR.replace("MORE", more))


def turn(name, speed=70.0, **more):
    press = texts.shipped(name)
    made_by = pp.servo_cycle if "angle" in more else pp.cycle
    return pp.inverse_dynamics(press, made_by(press, speed=speed * pp.RPM, **more))


BLANKING = {
    "drive": pp.drives.InductionMotor(30e3, 295 * pp.RPM, frequency=10.0),
    "flywheel": pp.drives.Flywheel(20.0),
    "loads": [pp.loads.Blanking(force=2e5, start=0.004, end=0.002)],
}


@cache
def loaded_run():
    """A press that blanks: the load breaks off in a jump."""
    press = texts.shipped("jf75g_125_plain")
    run = pp.steady_state(press, 300 * pp.RPM, **BLANKING)
    return pp.inverse_dynamics(press, run, loads=BLANKING["loads"])


def finer(result, points):
    """The same run in more states."""
    run, press = result.motion, texts.shipped("jf75g_125_plain")
    again = pp.simulate(press, run.time[-1], speed=run.crank_speed[0], angle=run.crank_angle[0], points=points, **BLANKING)
    assert abs(again.crank_angle[-1] - run.crank_angle[-1]) < 1e-8  # its period was found to 1e-10
    return pp.inverse_dynamics(press, again, loads=BLANKING["loads"])


def raw(chart):
    return {curve.name: curve.y for curve in chart.curves}


def named(result):
    """All charts of reactions, or of a motion alone, by their names."""
    return charts_of(result.described())


def series(found, angle):
    """The sum of the harmonics (n, 3) at crank angles."""
    phases = found.orders[:, None, None] * angle[None, :, None] + found.phase[:, None, :]
    return np.sum(found.amplitude[:, None, :] * np.cos(phases), axis=0)


# Harmonics


def test_a_rotating_unbalance_has_one_order():
    press = rotor()
    motion = pp.cycle(press, SPEED, points=24)
    found = harmonics(motion, pp.inverse_dynamics(press, motion).shaking_force)
    force = MASS * RADIUS * SPEED**2
    np.testing.assert_array_equal(found.orders, np.arange(12))  # 24 states carry 11 orders
    np.testing.assert_allclose(found.amplitude[1], [force, 0, force], rtol=1e-13)
    np.testing.assert_allclose(found.phase[1, [0, 2]], [0, -np.pi / 2], atol=1e-13)  # outwards: cos along x, sin along z
    np.testing.assert_allclose(found.amplitude[0], [0, 0, -9.81 * MASS], atol=1e-11)
    assert found.amplitude[2:].max() < 1e-12 * force


def test_textbook_series_of_the_crank_slide():
    """Masses of crank-slider.urdf; a rod's forces are those of masses at its ends, and the slide's acceleration is the series in lambda."""
    result = turn("crank_slide", 300)
    found = harmonics(result.motion, result.shaking_force)
    speed, lam, r = 300 * pp.RPM, 0.25, 0.1
    rotating, reciprocating = 20 * 0.03 / r + 7.5, 107.5
    second = lam + lam**3 / 4 + 15 * lam**5 / 128
    fourth = lam**3 / 4 + 3 * lam**5 / 16
    unit = r * speed**2
    np.testing.assert_allclose(found.amplitude[1, [0, 2]], np.array([rotating, rotating + reciprocating]) * unit, rtol=1e-12)
    np.testing.assert_allclose(found.amplitude[2, 2], reciprocating * second * unit, rtol=1e-4)
    np.testing.assert_allclose(found.amplitude[4, 2], reciprocating * fourth * unit, rtol=2e-2)  # the next term is 35/256 lambda^7 more
    assert found.amplitude[[3, 5], 2].max() < 1e-11 * unit
    np.testing.assert_allclose(found.amplitude[0, 2], -135 * 9.81, rtol=1e-12)


@pytest.mark.parametrize("speed", [72.0, -72.0])
def test_the_sum_is_the_force(speed):
    """As many orders as an odd number of states carries: the sum goes through all of them."""
    result = turn("thin_wall", speed, points=25)
    found = harmonics(result.motion, result.shaking_force)
    force = result.shaking_force
    np.testing.assert_allclose(series(found, result.motion.crank_angle), force, rtol=0, atol=1e-12 * np.abs(force).max())


def test_a_cycle_against_quadrature():
    result = turn("thin_wall", points=360)
    found = harmonics(result.motion, result.shaking_force)
    fine = turn("thin_wall", points=20_000)
    angle = np.append(fine.motion.crank_angle, 2 * np.pi)
    force = np.concatenate([fine.shaking_force, fine.shaking_force[:1]])
    for order in (1, 2, 7):
        sums = np.trapezoid(force * np.exp(-1j * order * angle)[:, None], angle, axis=0) / np.pi
        amplitude = found.amplitude[order] * np.exp(1j * found.phase[order])
        np.testing.assert_allclose(amplitude[[0, 2]], sums[[0, 2]], rtol=0, atol=1e-9 * np.abs(force).max())


@pytest.mark.parametrize("start", [0.0, 1.3])
def test_turns_of_other_states(start):
    """A servo motion of uneven steps over one and a half turns at constant speed: the harmonics are those of the cycle."""
    press = texts.shipped("thin_wall")
    angle = start + 3 * np.pi * (np.linspace(0, 1, 400) + 0.02 * np.sin(np.linspace(0, 25, 400)))
    motion = pp.servo_cycle(press, speed=7.0, angle=angle)
    expected = turn("thin_wall", 7.0 / pp.RPM)
    expected = harmonics(expected.motion, expected.shaking_force)
    force = pp.inverse_dynamics(press, motion).shaking_force
    assert not is_cycle(motion)
    for case in ((motion, force), (pp.servo_cycle(press, speed=7.0, angle=angle[::-1]), force[::-1])):
        found = harmonics(*case)
        a, b = (h.amplitude * np.exp(1j * h.phase) for h in (found, expected))
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-5 * np.abs(force).max())


@pytest.mark.exhaustive
def test_a_run_under_a_load_that_breaks_off():
    """Against the integral over time, dt = d(angle) / speed, of ten times as many states."""
    found = loaded_run()
    fine = finer(found, 1_201)
    for name in ("P4", "O"):
        got = harmonics(found.motion, found.bearing_force[name])
        motion, force = fine.motion, fine.bearing_force[name]
        for order in range(1, 7):
            weight = np.exp(-1j * order * motion.crank_angle) * motion.crank_speed
            sums = np.trapezoid(force * weight[:, None], motion.time, axis=0) / np.pi
            sums *= np.sign(motion.crank_speed[0])
            amplitude = got.amplitude[order] * np.exp(1j * got.phase[order])
            # the jump is taken for the middle of its step, and lies up to half of 2 pi / 120 beside it, of which 1 / pi is in the amplitude
            np.testing.assert_allclose(amplitude, sums, rtol=0, atol=np.abs(force).max() / 120)


def test_orders_are_those_the_states_carry():
    result = turn("crank_slide", points=7)
    assert len(harmonics(result.motion, result.shaking_force).orders) == 4  # 0 to 3
    result = turn("crank_slide", points=8)
    assert len(harmonics(result.motion, result.shaking_force).orders) == 4  # the fourth has no phase
    assert len(harmonics(result.motion, result.shaking_force, orders=0).orders) == 1


def test_no_full_turn(legs):
    press = texts.shipped("crank_slide")

    def of(motion):
        return harmonics(motion, np.zeros((len(motion.crank_angle), 3)))

    assert of(pp.servo_cycle(press, speed=7.0, angle=np.linspace(0, 6.28, 50))) is None
    assert of(pp.servo_cycle(press, speed=7.0, angle=np.linspace(0, 2 * np.pi, 50))) is not None
    assert of(pp.servo_cycle(press, speed=7.0, angle=np.linspace(0, 2 * np.pi, 50, endpoint=False))) is not None
    assert of(pp.servo_cycle(press, speed=7.0, angle=4 + 4 * np.sin(np.linspace(0, 6, 50)))) is None  # back and forth
    assert of(pp.servo_cycle(press, speed=0.0, angle=np.linspace(0, 7, 50))) is None  # a crank that stands has made none
    assert of(pp.servo_cycle(legs, angle=np.zeros((4, 12)), speed=0.0)) is None


@pytest.mark.parametrize(("ratio", "turns"), [("0.5", 2), ("-2", 1), ("1.2", 5), ("3", 1)])
def test_a_geared_shaft_is_back_after_whole_turns(ratio, turns):
    """The shaft's unbalance, at the speed of its own, is of the order of its ratio, a fraction too; so are those of the disc and of a run
    through two periods, whose last one counts."""
    press = rotor(SHAFT.replace("RATIO", ratio))
    motion = pp.cycle(press, SPEED, points=90 * turns)
    assert is_cycle(motion)
    longer = pp.servo_cycle(press, speed=SPEED, angle=np.linspace(0.0, 4 * np.pi * turns, 180 * turns + 1))
    for some, rtol in ((motion, 1e-12), (longer, 1e-5)):  # the second by splines
        found = harmonics(some, pp.inverse_dynamics(press, some).shaking_force)
        np.testing.assert_allclose(found.orders, np.arange(12 * turns + 1) / turns, rtol=1e-15)
        order = abs(float(ratio))
        size = dict(zip((found.orders * turns).round().astype(int), found.amplitude[:, 0], strict=True))
        np.testing.assert_allclose(size.pop(round(order * turns)), 2 * 0.1 * (order * SPEED) ** 2, rtol=rtol)
        np.testing.assert_allclose(size.pop(turns), MASS * RADIUS * SPEED**2, rtol=rtol)
        assert max(size.values()) < rtol * MASS * RADIUS * SPEED**2
    assert harmonics(pp.servo_cycle(press, speed=SPEED, angle=np.linspace(0.0, 2 * np.pi * turns - 0.1, 90)), np.zeros((90, 3))) is None


def test_an_unbalanced_shaft_that_is_never_back_has_no_period():
    """With 1001 turns to 1000; balanced it does not matter where it is."""
    shaft = SHAFT.replace("RATIO", "1.001")
    with pytest.raises(pp.PinpressError, match="rotor has no period: an unbalanced shaft"):
        pp.cycle(rotor(shaft), SPEED)
    somewhere = pp.servo_cycle(rotor(shaft), speed=SPEED, angle=np.linspace(0.0, 7.0, 50))
    assert somewhere.period_turns is None
    assert harmonics(somewhere, np.zeros((50, 3))) is None
    balanced = pp.cycle(rotor(shaft.replace('"0.1 0 0"', '"0 0.1 0"')), SPEED)
    assert balanced.period_turns == 1
    uneven = rotor(shaft.replace('"0.1 0 0"', '"0 0.1 0"').replace('izz="0.1"', 'izz="0.15"'))
    with pytest.raises(pp.PinpressError, match="rotor has no period"):
        pp.cycle(uneven, SPEED)


@pytest.mark.parametrize("name", pp.presses())
@pytest.mark.parametrize("points", [12, 360])
def test_every_press_comes_back(name, points):
    assert last_period(turn(name, points=points).motion) == 0


@pytest.mark.parametrize(
    ("force", "orders", "message"),
    [
        (np.zeros((8, 2)), 3, r"force has shape \(8, 2\): give one of \(8, 3\)"),
        (np.where(np.arange(24).reshape(8, 3) == 13, np.inf, 1.0), 3, "harmonics: force is not finite"),
        (np.zeros((8, 3)), -1, "orders is -1"),
        (np.zeros((8, 3)), 2.5, "orders is 2.5"),
    ],
)
def test_harmonics_of_nonsense_are_refused(force, orders, message):
    with pytest.raises(pp.PinpressError, match=message):
        harmonics(pp.cycle(texts.shipped("crank_slide"), 7.0, points=8), force, orders)


# Abscissa


def over(motion):
    found = along_motion(motion)
    scale = row_of(found.quantity).scale([])
    return found.name, scale.unit, found.values * scale.factor


def test_abscissa(legs):
    press = texts.shipped("crank_slide")
    cases = [
        (pp.cycle(press, 7.0, points=8), "crank angle", np.arange(8) * 45.0),
        (pp.cycle(press, -7.0, points=8), "crank angle", np.arange(8) * -45.0),
        (pp.servo_cycle(press, speed=7.0, angle=np.linspace(1, 1 + 2 * np.pi, 5)), "crank angle", np.degrees(1) + np.arange(5) * 90.0),
        (pp.servo_cycle(press, speed=7.0, angle=[0.0, 3.5, 7.0]), "time", [0.0, 0.5, 1.0]),  # more than a turn
        (pp.servo_cycle(press, speed=[1.0, 3.0], angle=[0.0, 2.0], acceleration=2.0), "time", [0.0, 1.0]),  # faster and faster
        (
            pp.servo_cycle(press, speed=[1.0, -3.0], angle=[0.0, 2.0], acceleration=0.0),
            "crank angle",
            np.degrees([0.0, 2.0]),
        ),  # not in time, but one way
        (pp.servo_cycle(press, speed=0.0, angle=[0.0, 2.0, 1.0]), "state", [0.0, 1.0, 2.0]),
        (pp.servo_cycle(legs, angle=np.zeros((3, 12)), speed=0.0, time=[0.0, 0.1, 0.3]), "time", [0.0, 0.1, 0.3]),
        (pp.servo_cycle(legs, angle=np.zeros((3, 12)), speed=0.0), "state", [0.0, 1.0, 2.0]),
    ]
    for motion, quantity, values in cases:
        found = over(motion)
        assert found[:2] == (quantity, {"crank angle": "deg", "time": "s", "state": ""}[quantity])
        np.testing.assert_allclose(found[2], values, atol=1e-10)
        assert not along_motion(motion).values.flags.writeable


# Charts


def test_values_are_those_of_the_arrays():
    result = turn("zxn2_3000b")
    motion, slide, all_charts = result.motion, [*named(result.motion).values()], named(result)
    assert [(c.title, c.quantity) for c in slide] == [("Slide position", "m"), ("Slide velocity", "m/s"), ("Slide acceleration", "m/s2")]
    np.testing.assert_array_equal(slide[0].curves[0].y, motion.slide_position)
    np.testing.assert_array_equal(slide[2].curves[0].y, motion.slide_acceleration)
    bottom = pp.dead_centres(texts.shipped("zxn2_3000b")).bottom_position
    np.testing.assert_array_equal(all_charts["height"].curves[0].y, motion.slide_position - bottom)
    np.testing.assert_allclose(raw(all_charts["torque"])["driving torque"], result.driving_torque, rtol=1e-15)
    for name, values in raw(all_charts["bearings"]).items():
        np.testing.assert_allclose(values, np.linalg.norm(result.bearing_force[name], axis=1), rtol=1e-12)
    for chart, vector in (
        (all_charts["components D"], result.bearing_force["D"]),
        (all_charts["shaking"], result.shaking_force),
        (all_charts["shaking_moment"], result.shaking_moment),
    ):
        shown = raw(chart)
        assert list(shown) == (["y"] if "moment" in chart.title else ["x", "z"])  # a planar press; what is left out is zero
        for axis, values in shown.items():
            np.testing.assert_allclose(values, vector[:, "xyz".index(axis)], rtol=1e-14)
    assert "speed" not in all_charts


@pytest.mark.parametrize(("size", "unit"), [(0.0, "N"), (5e4, "kN"), (1e8, "MN")])
def test_units_by_size(size, unit):
    press = texts.shipped("crank_slide")
    load = pp.loads.PointForce("slide", (0.0, 0.0, 900.0 - size))  # it almost bears the slide of 981 N
    result = pp.inverse_dynamics(press, pp.cycle(press, 0.1, points=12), loads=[load])
    chart = named(result)["components W"]
    assert row_of(chart.quantity).scale(np.abs(result.bearing_force["W"][:, 2])).unit == unit
    np.testing.assert_allclose(raw(chart)["z"], result.bearing_force["W"][:, 2], rtol=1e-14)


@pytest.mark.exhaustive
def test_a_run_has_its_drive_and_speed():
    result = loaded_run()
    found = named(result)
    assert [curve.name for curve in found["torque"].curves] == ["driving torque", "drive"]
    drawn: Any = charts.drawn_states(result).motion  # a Run
    np.testing.assert_allclose(raw(found["torque"])["drive"], drawn.drive_torque, rtol=1e-14)
    assert row_of(found["speed"].quantity).scale([1.0]).unit == "r/min"
    np.testing.assert_allclose(raw(found["speed"])["crank speed"], drawn.crank_speed, rtol=1e-14)


def test_drivers_of_two_kinds_have_charts_of_their_own():
    """A press whose crank turns and whose ram slides: torques and forces, r/min and m/s, and peaks by the time."""
    time = np.linspace(0.0, 1.0, 40, endpoint=False)
    places = np.column_stack([2 * np.pi * time + 0.2 * np.sin(2 * np.pi * time), 0.04 * np.sin(2 * np.pi * time)])
    press = hybrid()
    result = pp.inverse_dynamics(press, pp.servo_cycle(press, places, time=time, period=1.0))
    turning, sliding = (named(result)[name] for name in ("torque", "driving_force"))
    assert [(c.title, c.quantity) for c in (turning, sliding)] == [("Driving torque", "N m"), ("Driving force", "N")]
    np.testing.assert_allclose(raw(turning)["A"], result.driving_torque[:, 0], rtol=1e-14)
    np.testing.assert_allclose(raw(sliding)["ram_guide"], result.driving_torque[:, 1], rtol=1e-14)
    assert [named(result)[name].title for name in ("speed", "driver_speed")] == ["Crank speed", "Driver speed"]
    table = {row.quantity: row for row in extremes(result)}
    row = table["driving force of ram_guide"]
    assert (row.unit, row.units["largest_at"]) == ("N", "s")
    assert row.largest_at == time[result.driving_torque[:, 1].argmax()]
    frames = key_frames(press, result.motion)
    assert frames.time[-1] == pytest.approx(1.0)  # the first state comes again, and the page plays in a loop
    half = pp.servo_cycle(press, places[:20], time=time[:20])
    assert len(key_frames(press, half).time) == 20


def test_several_drivers(legs):
    run = pp.simulate(legs, 0.01, points=5, method="constraint", drive={legs.drivers[3]: pp.drives.ConstantTorque(2.0)})
    result = pp.inverse_dynamics(legs, run)
    shown = raw(named(result)["torque"])
    assert list(shown) == [*legs.drivers, *(f"drive of {name}" for name in legs.drivers)]
    np.testing.assert_array_equal(shown[f"drive of {legs.drivers[3]}"], 2.0)
    np.testing.assert_allclose(shown[legs.drivers[3]], result.driving_torque[:, 3], rtol=1e-15)
    assert [curve.name for curve in named(result)["speed"].curves] == list(legs.drivers)
    assert "velocity" not in named(result)
    table = {row.quantity: row for row in extremes(result)}
    assert table[f"drive torque of {legs.drivers[3]}"].smallest == 2.0


def test_rounding_is_zero():
    """Guides of the symmetric press carry nothing; its floor feels no moment, and no force but the upright one."""
    result = turn("jf75g_125_symmetric", 300)
    assert np.abs(result.bearing_force["slide_guide"]).max() > 0.0  # but for rounding
    found = named(result)
    shown = raw(found["bearings"])
    assert not shown["slide_guide"].any()
    assert not shown["counterweight_guide"].any()
    assert shown["O_left"].all()
    assert list(raw(found["shaking"])) == ["z"]
    moment = raw(found["shaking_moment"])
    assert list(moment) == ["x", "y", "z"]
    assert not np.any(list(moment.values()))
    assert not found["polar slide_guide"].own.any()


def test_held_moments():
    """A load beside the pin tilts the slide: the guide holds force times lever. The crank's holds none, its torque is the drive's."""
    press = texts.shipped("crank_slide")
    motion = pp.cycle(press, 7.0)
    assert "moments" not in named(pp.inverse_dynamics(press, motion))
    result = pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce("slide", (0.0, 0.0, -5e5), (0.03, 0.0, 0.0))])
    assert np.abs(result.bearing_moment["O"]).max() > 1e4
    chart = named(result)["moments"]
    assert [curve.name for curve in chart.curves] == ["slide_guide"]
    np.testing.assert_allclose(raw(chart)["slide_guide"], 5e5 * 0.03, rtol=1e-9)
    result = pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce("slide", (0.0, 0.0, -5e5), (0.0, 0.02, 0.0))])
    held = held_moments(result)  # beside the plane: about x, and nowhere about the axes that turn
    np.testing.assert_allclose(np.abs(sum(held.values())).max(axis=0) > 1.0, [True, False, False])


def test_a_pin_in_space_holds_all_moments_but_the_one_about_its_axis():
    """Of a loop's pin too: without friction there is none about its axis, so that nothing is left out."""
    press = texts.load(bennett())
    result = pp.inverse_dynamics(press, pp.cycle(press, 9.0, points=12))
    (loop,) = press.loops
    moment = result.bearing_moment[loop.name]
    assert loop.type == "revolute"
    assert np.all(np.abs(moment).max(axis=0) > 1e-3 * np.abs(moment).max())
    np.testing.assert_allclose(held_moments(result)[loop.name], moment, rtol=0, atol=1e-9 * np.abs(moment).max())


# Polar diagrams


@pytest.mark.parametrize("yaw", [0.4, 1.2, 2.0, 2.8, -0.4, -1.2, -2.0, -2.8])
@pytest.mark.parametrize("roll", [0.5, 2.5])
def test_locus_in_an_inclined_plane(roll, yaw):
    """The press's plane, x-z of its frame, leans: axes are its horizontal, along its larger component, and its slope."""
    press = bolted(texts.shipped("crank_slide"), f"{roll} 0 {yaw}")
    result = pp.inverse_dynamics(press, pp.cycle(press, 7.0, points=12))
    found = named(result)["polar P"]
    slope = np.array([np.sin(yaw) * np.sin(roll), -np.cos(yaw) * np.sin(roll), np.cos(roll)])  # the frame's z in the world
    slope *= np.sign(np.cos(roll))
    horizontal = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    horizontal *= np.sign(horizontal[np.abs(horizontal).argmax()])
    force = result.bearing_force["P"] @ np.column_stack([horizontal, slope])
    assert found.axes == ("h", "u")
    np.testing.assert_allclose(found.world, force, rtol=0, atol=1e-9 * np.abs(force).max())


@pytest.mark.parametrize(("rpy", "axes"), [("1.5707963267948966 0 0", ("x", "y")), ("0 0 1.5707963267948966", ("y", "z"))])
def test_locus_in_a_plane_of_world_axes(rpy, axes):
    press = bolted(texts.shipped("crank_slide"), rpy)
    assert named(pp.inverse_dynamics(press, pp.cycle(press, 7.0, points=12)))["polar P"].axes == axes


@pytest.mark.parametrize("name", pp.presses())
def test_locus_in_axes_of_the_link(name):
    """In the plane a link's axes are turned by the sum of the joint angles on the way to it; turned back, the force is the frame's."""
    result = turn(name, points=36)
    press, motion = texts.shipped(name), result.motion
    spin = press.engine("plane").plane.spin @ motion.joint_position.T  # about the normal
    normal = press.engine("plane").plane.normal[1]  # +-1: of the x-z plane
    for bearing in press.bearings:
        found = named(result)[f"polar {bearing}"]
        assert found.axes == ("x", "z")
        joint = press.model.frames[press.model.getFrameId(found.link)].parentJoint
        angle = -normal * (spin[joint - 1] if joint else np.zeros(36))  # from x towards z
        back = np.stack(
            [
                np.cos(angle) * found.own[:, 0] - np.sin(angle) * found.own[:, 1],
                np.sin(angle) * found.own[:, 0] + np.cos(angle) * found.own[:, 1],
            ],
            axis=1,
        )
        scale = max(1e-3, np.abs(found.world).max())
        np.testing.assert_allclose(back, found.world, rtol=0, atol=1e-12 * scale)
        np.testing.assert_allclose(found.world, result.bearing_force[bearing][:, [0, 2]], atol=1e-8 * 1e5)


def test_locus_of_an_unbalance_stands_still_in_the_link():
    press = rotor()
    motion = pp.cycle(press, 9e3 * pp.RPM, points=60)
    found = named(pp.inverse_dynamics(press, motion))["polar O"]
    assert found.link == "disc"
    pull = MASS * RADIUS * (9e3 * pp.RPM) ** 2
    weight = 9.81 * MASS
    np.testing.assert_allclose(found.own, np.broadcast_to([-pull, 0.0], (60, 2)), rtol=0, atol=1.0001 * weight)
    np.testing.assert_allclose(np.hypot(*(found.own - [-pull, 0.0]).T), weight, rtol=1e-6)
    np.testing.assert_allclose(found.world[15], [0.0, weight - pull], atol=1e-9 * pull)  # a quarter later the mass is at the top


def test_locus_in_space(legs):
    """Of a spatial linkage: the two axes of largest range; the link is the one the force acts on. The first joint carries a weight at rest:
    its force ranges along no axis but by rounding, which must not choose the axes."""
    angle = 0.05 * np.sin(np.linspace(0, 6, 20))[:, None] * np.ones(12)
    result = pp.inverse_dynamics(legs, pp.servo_cycle(legs, angle=angle, speed=0.0))
    ranges = {name: np.ptp(result.bearing_force[name], axis=0) for name in (legs.joints[0], legs.loops[0].name)}
    still, moved = ranges.values()
    assert still.max() < 1e-12 * np.abs(result.bearing_force[legs.joints[0]]).max()
    assert np.diff(np.sort(moved)).min() > 0.1 * moved.max()
    for name, axes in zip(ranges, ({"x", "z"}, {"xyz"[i] for i in np.argsort(moved)[1:]}), strict=True):
        found = named(result)[f"polar {name}"]
        assert set(found.axes) == axes
        assert found.link in legs.links


@examples(20)
@given(ranges=st.permutations([0.0, 1.0, 2.0]), equal=st.booleans(), seed=st.integers(0, 99))
def test_axes_of_a_locus_do_not_hang_on_rounding(ranges, equal, seed):
    """The axis of least range is left out; where all ranges are alike, that of the smaller force, and y of equal ones."""
    turned = np.cos(np.linspace(0, 6, 30))[:, None]
    force = 100.0 * (np.ones((30, 3)) if equal else turned * ranges)
    noise = 1e-12 * np.random.default_rng(seed).uniform(-1, 1, force.shape)
    assert charts._least_moved(force + noise, 1e-7) == (1 if equal else ranges.index(0.0))
    force[:, 2] += 50.0 * equal
    assert charts._least_moved(force + noise, 1e-7) == (1 if equal else ranges.index(0.0))


def test_an_unknown_bearing_is_refused():
    result = turn("crank_slide", points=8)
    with pytest.raises(pp.UnknownNameError, match="no bearing 'Q'"):
        charts.loci(result, ["Q"])


# Extremes


def test_extremes_against_the_columns():
    given = turn("zxn2_3000b")
    result = at_peaks(given).reactions  # in more states than were given
    press, columns, states = texts.shipped("zxn2_3000b"), result.columns(), given.columns()
    table = {row.quantity: row for row in extremes(given)}
    angle = np.degrees(result.motion.crank_angle)
    places = {"driving torque": "driving_torque [N m]", "slide velocity": "slide_velocity [m/s]", "force in A, x": "force_A_x [N]"}
    places |= {"shaking force, z": "shaking_force_z [N]", "shaking moment, y": "shaking_moment_y [N m]"}
    for quantity, column in places.items():
        row, values = table[quantity], columns[column]
        assert (row.smallest, row.largest) == (values.min(), values.max())
        assert (row.smallest_at, row.largest_at) == (angle[values.argmin()], angle[values.argmax()])
        assert row.range == pytest.approx(np.ptp(values), rel=1e-14)
        assert states[column].min() >= row.smallest > states[column].min() - 1e-3 * row.range
        assert states[column].max() <= row.largest < states[column].max() + 1e-3 * row.range
        assert row.rms == pytest.approx(np.sqrt(np.mean(states[column] ** 2)), rel=1e-13)
        assert row.unit in column
    assert table["slide position"].range == pytest.approx(1e3 * pp.dead_centres(press).stroke, rel=1e-9)
    assert table["force in A, magnitude"].largest == np.linalg.norm(result.bearing_force["A"], axis=1).max()
    for absent in ("force in A, y", "shaking force, y", "moment in A, magnitude", "crank speed", "drive torque"):
        assert absent not in table
    assert {f"force in {name}, magnitude" for name in press.bearings} <= table.keys()


def test_rms_of_an_unbalance():
    press = texts.load(ROTOR.replace("MORE", ""), gravity=(0.0, 0.0, 0.0))
    result = pp.inverse_dynamics(press, pp.cycle(press, -SPEED, points=16))
    table = {row.quantity: row for row in extremes(result)}
    force = MASS * RADIUS * SPEED**2
    row = table["shaking force, x"]
    assert (row.largest_at, row.smallest_at) == (0.0, 180.0)
    np.testing.assert_allclose([row.largest, row.smallest, row.range, row.rms], [force, -force, 2 * force, force / np.sqrt(2)])
    assert table["shaking force, z"].largest_at == pytest.approx(90.0)  # the crank turns backwards: 270 deg before
    assert table["shaking force, magnitude"].range < 1e-12 * force


@pytest.mark.exhaustive
def test_extremes_of_a_run():
    result = loaded_run()
    table = {row.quantity: row for row in extremes(result)}
    assert table["crank speed"].unit == "r/min"
    finer = result.motion.at_times(np.linspace(0.0, result.motion.time[-1], 20001))  # peaks lie between the states
    assert table["crank speed"].largest == pytest.approx(finer.crank_speed.max() / pp.RPM)
    assert table["drive torque"].largest == pytest.approx(finer.drive_torque.max(), rel=1e-4)


# Values that are not finite


def spoiled(values, at):
    values = np.array(values)
    values[at] = np.nan
    return values


def test_not_finite():
    result = turn("crank_slide", points=8)
    motion = result.motion
    cases = [
        (lambda: replace(motion, v=spoiled(motion.v, 3)).described(), "Slide velocity is not finite at index 3"),
        (lambda: along_motion(replace(motion, crank_angle=spoiled(motion.crank_angle, 5))), "crank angle is not finite at index 5"),
        (
            lambda: along_motion(replace(motion, crank_speed=np.arange(8.0), _time=spoiled(motion.time, 5))),
            "time is not finite at index 5",
        ),
        (replace(motion, crank_speed=spoiled(motion.crank_speed, 2)).described, "crank speed is not finite at index 2"),
    ]
    bad = replace(result, driving_torque=spoiled(result.driving_torque, 4))
    cases += [(lambda: bad.described(), "driving torque is not finite at index 4")]
    cases += [(lambda: extremes(bad), "driving torque is not finite at index 4")]
    force = {name: spoiled(values, 6) if name == "P" else values for name, values in result.bearing_force.items()}
    worse = replace(result, bearing_force=force)
    cases += [(worse.described, "force in P is not finite at index 6")]
    cases += [(lambda: charts.loci(worse, ["O"]), "force in P is not finite at index 6")]
    for make, message in cases:
        with pytest.raises(pp.PinpressError, match=message):
            make()
