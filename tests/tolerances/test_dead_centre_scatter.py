"""The scatter of dead centres: every press of a sample is the reshaped one, first order is exact, numbers of a six-bar press hold."""

import re
from pathlib import Path

import numpy as np
import pytest
from support import texts
from support.generators.spatial_crank_slide import SPATIAL
from support.presses.sliding_presses import TOGGLE
from support.presses.two_servos import TWO_SERVOS

import pinpress as pp
from pinpress.derivatives import pivot_positions, reshaped
from pinpress.derivatives.motion import directed
from pinpress.kinematics.servo_motion import angle_on_flank
from pinpress.tolerances.dead_centre_scatter import dead_centre_gradients
from pinpress.tolerances.sets_of_lengths.endings import Ending, follow_to_end
from pinpress.tolerances.sets_of_lengths.planar_shapes import PlanarShapes
from pinpress.tolerances.sets_of_lengths.spatial_shapes import SpatialShapes

tol = pp.tolerances
SLIDING = "a toggle that a screw moves"
IN_SPACE = "a crank-slide through space"
LATE = 30_001  # a press of a sample that is worked through in many pieces


def six_bar(press, shape="normal"):
    """The tolerances of a drawing of zxn2_3000b."""
    lengths = {"AB": 5e-5, "BC": 1e-4, "DC": 5e-5, "DE": 5e-5, "EF": 5e-5}
    return [
        *(tol.link_length(press, *pins, T, shape=shape) for pins, T in lengths.items()),
        *(tol.pin_position(press, pin, axis, 1e-4, shape=shape) for pin, axis in (("A", "x"), ("A", "z"), ("slide_guide", "x"))),
        tol.pin_angle(press, "C", "D", "E", np.radians(0.01), shape=shape),
    ]


def all_pivots(press, tolerance):
    """A dimension for each pivot along each axis of the plane; of a press in space along all three."""
    return [
        tol.pin_position(press, bearing, axis, tolerance, link=link, name=f"{bearing} {axis} {link}")
        for bearing, link in pivot_positions(press)
        for axis in ("xz" if len(press.engine().directions) == 2 or len(press.drivers) > 1 else "xyz")
    ]


def moved_pivots(press, parts, deviations):
    """Where the pivots of a press stand whose dimensions deviate."""
    at = pivot_positions(press)
    for part, deviation in zip(parts, deviations, strict=True):
        for key, vector in part.direction.items():
            at[key] = at[key] + deviation * np.asarray(vector)
    return at


def built(press, found, k):
    """Press k of a sample, made anew."""
    return reshaped(press, moved_pivots(press, found.parts, found.deviations[:, k]))


@pytest.fixture(scope="module")
def press():
    return texts.shipped("zxn2_3000b")


@pytest.fixture(scope="module")
def found(press):
    return tol.bottom_dead_centre(press, six_bar(press), forces={0.006: 3e6}, speeds={0.05: 7.0, 0.1: -7.0}, samples=40_000)


def test_a_crank_slide_by_hand():
    press = texts.shipped("crank_slide")
    parts = [tol.link_length(press, "O", "P", 3e-5), tol.link_length(press, "P", "W", 4e-5), tol.pin_position(press, "O", "z", 1e-5)]
    found = tol.bottom_dead_centre(press, parts, samples=2000)
    assert found.gradient == pytest.approx([-1, -1, 1], abs=1e-12)
    assert found.top.gradient == pytest.approx([1, -1, 1], abs=1e-12)
    assert found.stroke.gradient == pytest.approx([2, 0, 0], abs=1e-12)
    assert found.share == pytest.approx(np.array([9, 16, 1]) / 26)
    assert found.worst_case == pytest.approx(8e-5)
    assert found.height.corners == pytest.approx([-8e-5, 8e-5], abs=1e-15)
    assert found.height.deviation == pytest.approx([-1, -1, 1] @ found.deviations, abs=1e-15)
    assert found.stroke.deviation == pytest.approx(2 * found.deviations[0], abs=1e-15)


def test_the_numbers_of_a_six_bar_press(found):
    """Our prototypes', each by its own calculation: sums over pivots, and one press after the other."""
    assert 3 * found.height.first_order_sd == pytest.approx(72.0e-6, abs=0.05e-6)
    assert 3 * found.top.first_order_sd == pytest.approx(361e-6, abs=0.5e-6)
    assert 3 * found.stroke.first_order_sd == pytest.approx(348e-6, abs=0.5e-6)
    assert (found.worst_case, found.stroke.worst_case) == (pytest.approx(132.6e-6, abs=0.1e-6), pytest.approx(916e-6, abs=0.5e-6))
    assert found.height.corners == pytest.approx([-132.0e-6, 133.2e-6], abs=0.05e-6)
    assert found.gradient[3:5] == pytest.approx([-0.9986, -1.0005], abs=1e-4)
    shares = dict(zip([part.name for part in found.parts], found.share, strict=True))
    assert (shares["EF"], shares["DE"]) == (pytest.approx(0.48, abs=0.005), pytest.approx(0.48, abs=0.005))
    by_stroke = dict(zip(shares, found.stroke.share, strict=True))
    assert [by_stroke[name] for name in ("BC", "A x", "angle CDE")] == pytest.approx([0.33, 0.27, 0.11], abs=0.005)
    assert found.within(50e-6) == pytest.approx(0.9628, abs=0.004)
    assert found.height.sd == pytest.approx(24.0e-6, rel=0.01)
    torque = found.torques[0.006]
    assert (torque.nominal, torque.first_order_sd) == (pytest.approx(75_990, abs=5), pytest.approx(20.24, abs=0.01))
    assert torque.sd == pytest.approx(20.24, rel=0.01)


def test_first_order_is_that_of_the_sample(found):
    """Regression of the sample on the deviations gives the gradients; the closed form of second order leaves little else."""
    for each in found.quantities:
        slopes = np.linalg.lstsq(found.deviations.T, each.deviation, rcond=None)[0]
        tolerances = np.array([part.tolerance for part in found.parts])
        assert np.abs((slopes - each.gradient) * tolerances).max() < 2e-3 * each.worst_case


@pytest.mark.filterwarnings("ignore:.*does not move the slide at a dead centre:pinpress.PinpressWarning")  # a guide along itself
@pytest.mark.parametrize("name", ["crank_slide", "jf75g_125_plain", "thin_wall", "zxn2_3000b", SLIDING, IN_SPACE])
def test_every_press_is_the_reshaped_one(name):
    press = texts.load({SLIDING: TOGGLE, IN_SPACE: SPATIAL}[name]) if name in (SLIDING, IN_SPACE) else texts.shipped(name)
    found = tol.bottom_dead_centre(press, all_pivots(press, 1e-3), samples=40, seed=1)
    for k in (0, 27):
        ends = pp.dead_centres(built(press, found, k))
        assert found.height.nominal + found.height.deviation[k] == pytest.approx(ends.bottom_position, abs=1e-12)
        assert found.top.nominal + found.top.deviation[k] == pytest.approx(ends.top_position, abs=1e-12)


BALLS = """
press: link_drive_with_balls
units: mm
frame: O D
pins:
  O: {x: 0, y: 0, z: 0, axis: y}
  A: {x: 120, y: 0, z: 0, axis: y}
  B: {x: 430, y: 0, z: -150, joint: ball}
  C: {x: 60, y: 0, z: -420, joint: ball}
  D: {x: 560, y: 120, z: 300, joint: ball}
  E: {x: 0, y: -60, z: -1290, joint: ball}
links:
  crank: {pins: O A, mass: 350}
  plate: {pins: A B C, mass: 900}
  rocker: {pins: D B, mass: 300}
  rod: {pins: C E, mass: 500}
  slide: {pins: E, guide: up, mass: 6000}
drive: O
"""


@pytest.mark.exhaustive
def test_a_link_drive_with_ball_joints_and_its_torque_and_speed(tmp_path):
    """Each press made anew; slopes of the sample are the gradients; an angle of the plate is that between its arms."""
    (tmp_path / "balls.yaml").write_text(BALLS)
    press = pp.build(tmp_path / "balls.yaml")
    arms = "B", "C_cross"
    angle = tol.pin_angle(press, arms[0], "A", arms[1], 1e-4)
    parts = [
        angle,
        tol.link_length(press, "O", "A", 1e-5),
        tol.link_length(press, "C", "E", 2e-5),
        tol.pin_position(press, "O", "y", 2e-5),
        tol.pin_position(press, "slide_guide", (1, 1, 0), 3e-5),
    ]
    found = tol.bottom_dead_centre(press, parts, forces={0.02: 1e5}, speeds={0.05: 6.0}, samples=300)
    tolerances = np.array([part.tolerance for part in parts])
    for each in found.quantities:
        slopes = np.linalg.lstsq(found.deviations.T, each.deviation, rcond=None)[0]
        assert np.abs((slopes - each.gradient) * tolerances).max() < 1e-3 * each.worst_case
    other = built(press, found, 299)
    low = pp.dead_centres(other)
    assert found.height.nominal + found.height.deviation[299] == pytest.approx(low.bottom_position, abs=1e-12)
    angles = np.array([angle_on_flank(other, low, height, down=True) for height in (0.02, 0.05)])
    state = pp.servo_cycle(other, angles, speed=1.0, acceleration=0.0)
    assert found.torques[0.02].nominal + found.torques[0.02].deviation[299] == pytest.approx(-1e5 * state.slide_velocity[0], rel=1e-11)
    assert found.speeds[0.05].nominal + found.speeds[0.05].deviation[299] == pytest.approx(-6.0 * state.slide_velocity[1], rel=1e-11)

    def between(press):
        one, two = (pivot_positions(press)[name, "plate"] for name in arms)
        return np.arctan2(np.linalg.norm(np.cross(one, two)), one @ two)

    at = {key: pivot_positions(press)[key] + 1e-6 * np.asarray(vector) for key, vector in angle.direction.items()}
    assert between(reshaped(press, at)) - between(press) == pytest.approx(1e-6, rel=1e-5)
    on_the_line = BALLS.replace("x: 60, y: 0, z: -420", "x: 182, y: 0, z: -30").replace("mass: 900", "section: 100 x 60")
    (tmp_path / "straight.yaml").write_text(on_the_line)
    with pytest.raises(pp.PinpressError, match="the arms A-B and A-C_cross are in one line"):
        tol.pin_angle(pp.build(tmp_path / "straight.yaml"), "B", "A", "C_cross", 1e-4)


@pytest.mark.exhaustive
def test_two_servos_and_a_crank_that_turns_back_stand_where_their_path_is_lowest(press, tmp_path):
    (tmp_path / "servos.yaml").write_text(TWO_SERVOS)
    servos, phase = pp.build(tmp_path / "servos.yaml"), np.linspace(0.0, 2 * np.pi, 24)
    angles = np.column_stack([0.6 * np.sin(phase), 0.5 * np.cos(phase)])
    rates = np.column_stack([0.6 * np.cos(phase), -0.5 * np.sin(phase)])
    crank = np.linspace(0.3, 2.0, 24)
    for linkage, angle, path in [
        (servos, angles, pp.servo_cycle(servos, angles, speed=rates)),
        (press, crank, pp.servo_cycle(press, crank, speed=1.0)),
    ]:
        parts = all_pivots(linkage, 1e-3)[:6]
        found = tol.bottom_dead_centre(linkage, parts, motion=path, samples=20)
        ends = [path.slide_position.argmin(), path.slide_position.argmax()]
        assert (found.height.nominal, found.top.nominal) == tuple(path.slide_position[ends])
        slide = pp.servo_cycle(built(linkage, found, 19), angle[ends], speed=0.0).slide_position
        assert found.height.nominal + found.height.deviation[19] == pytest.approx(slide[0], abs=1e-12)
        assert found.top.nominal + found.top.deviation[19] == pytest.approx(slide[1], abs=1e-12)
        small = [tol.Dimension(part.name, part.direction, 1e-7) for part in parts]
        near = tol.bottom_dead_centre(linkage, small, motion=path, samples=20)
        assert near.height.deviation == pytest.approx(near.gradient @ near.deviations, abs=1e-12)
        cheapest = tol.allocate(linkage, parts, None, {"height": found.height.first_order_sd}, motion=path)
        assert cheapest.reached["height"] == pytest.approx(found.height.first_order_sd, rel=1e-5)
    both = pp.servo_cycle(servos, angles, speed=rates)
    warm = tol.heat(servos, tol.Temperatures({"rod": 10.0}), motion=both)
    longer = tol.bottom_dead_centre(servos, [tol.link_length(servos, "D", "S", 1e-5)], motion=both, samples=2)
    assert warm.bottom_shift == pytest.approx(12e-5 * 0.3 * longer.gradient[0])


def test_shapes_in_space_of_a_planar_press_are_those_in_its_plane():
    """A crank-slide whose rod turns about a pin in the slide: rows of rotations that the bearing prevents are redundant there."""
    text = texts.shipped("crank_slide").text.decode().replace('name="W" type="spherical">', 'name="W" type="revolute"><axis xyz="0 -1 0"/>')
    press = texts.load(text)
    moved = [directed(press, part.direction) for part in all_pivots(press, 1e-3)]
    deviations = np.random.default_rng(1).normal(0.0, 1e-3, (len(moved), 7))
    for angle in (0.0, 1.0):
        state = pp.servo_cycle(press, [angle], speed=1.0)
        plane, space = PlanarShapes.of(press, moved), SpatialShapes.of(press, moved)
        for one, other in zip(*(each.slide_slopes(state.joint_position[0], state.v[0]) for each in (plane, space)), strict=True):
            assert one == pytest.approx(other, abs=1e-12)
        ending = Ending(state.joint_position[0], np.zeros(len(moved)), "held")
        ends = [follow_to_end(each, deviations, ending) for each in (plane, space)]
        assert ends[0].position == pytest.approx(ends[1].position, abs=1e-13)
        assert ends[0].rate == pytest.approx(ends[1].rate, abs=1e-12)
        assert all(each.sound.all() for each in ends)


KNEE = """
press: knee
units: mm
frame: A D
pins:
  D: [0, 0]
  A: [500, -300]
  B: {from: A, length: 50, angle: 90}
  C: {B: 500, D: 300, side: left}
  F: {C: 300, x: 0, side: down}
links:
  crank: {pins: A B, mass: 10}
  coupler: {pins: B C, mass: 10}
  upper: {pins: D C, mass: 10}
  lower: {pins: C F, mass: 10}
  slide: {pins: F, guide: up, mass: 100}
drive: A
"""


@pytest.mark.filterwarnings("ignore:.*does not move the slide at a dead centre:pinpress.PinpressWarning")
def test_of_several_turning_points_the_outermost_of_each_press_counts(tmp_path):
    """The knee of a toggle swings through: two bottoms are equally low, and which of two tops 12 um apart is higher differs."""
    (tmp_path / "knee.yaml").write_text(KNEE)
    press = pp.build(tmp_path / "knee.yaml")
    found = tol.bottom_dead_centre(press, all_pivots(press, 2e-4), samples=8, seed=4)
    nominal, near_second = pp.dead_centres(press), 0
    for k in range(8):
        ends = pp.dead_centres(built(press, found, k))
        assert found.height.nominal + found.height.deviation[k] == pytest.approx(ends.bottom_position, abs=1e-12)
        assert found.top.nominal + found.top.deviation[k] == pytest.approx(ends.top_position, abs=1e-12)
        near_second += abs(ends.top_angle - nominal.top_angle) > 1.0
    assert 0 < near_second < 8


def test_a_turning_point_may_become_the_outermost_one_where_one_dimension_alone_deviates(tmp_path):
    """The shaft's place shifts the two tops against each other; its smallest deviation in the sample does nothing."""
    (tmp_path / "knee.yaml").write_text(KNEE)
    press = pp.build(tmp_path / "knee.yaml")
    found = tol.bottom_dead_centre(press, [tol.pin_position(press, "A", "x", 1e-3)], samples=30)
    order, nominal = np.argsort(found.deviations[0]), pp.dead_centres(press)
    ends = [pp.dead_centres(built(press, found, int(k))) for k in order[[0, -1]]]
    assert sum(abs(each.top_angle - nominal.top_angle) > 1.0 for each in ends) == 1
    assert found.top.nominal + found.top.deviation[order[[0, -1]]] == pytest.approx([each.top_position for each in ends], abs=1e-12)
    assert found.height.gradient == found.height.share == found.height.first_order_sd == 0.0  # the straight knee does not ask for the shaft
    assert "Bottom dead centre: no dimension changes it to first order." in str(found)


def test_a_place_that_one_dimension_hardly_moves_may_be_passed_by_another():
    """A cylinder drives a toggle from one end of its travel through the stretched pose to the other end, which is 0.02 mm less high. The
    trunnion is moved square to the cylinder's line at the first end, where that does nothing."""
    beside, trunnion = (-0.15, 0.14998), np.array([-0.6, 0.3])
    knees = [np.array([x, -np.sqrt(0.3**2 - x * x)]) for x in beside]
    one, other = (knee - trunnion for knee in knees)
    drawn = np.linalg.norm(np.array([-0.05, -np.sqrt(0.3**2 - 0.05**2)]) - trunnion)
    low, high = (1e3 * (np.linalg.norm(each) - drawn) for each in (one, other))
    press = pp.build(
        units="mm",
        frame="U G",
        pins={"U": [0, 0], "K": [-50, float(-1e3 * np.sqrt(0.3**2 - 0.05**2))], "S": {"K": 340, "x": 0, "side": "down"}, "G": [-600, 300]},
        links={
            "upper": {"pins": "U K", "mass": 20},
            "lower": {"pins": "K S", "mass": 20},
            "barrel": {"pins": "G", "mass": 95, "com": [250, 0], "inertia": 4.2},
            "piston": {
                "pins": "K",
                "guide": {"cylinder": "barrel G K"},
                "travel": [low, high],
                "mass": 40,
                "com": [-300, 0],
                "inertia": 1.4,
            },
            "slide": {"pins": "S", "guide": "up", "mass": 1400},
        },
        drive="cylinder",
    )
    square = np.array([-one[1], one[0]]) / np.linalg.norm(one)
    part = tol.pin_position(press, "G", (square[0], 0.0, square[1]), 2e-3)
    found = tol.bottom_dead_centre(press, [part], samples=40)
    assert abs(found.top.gradient[0]) < 1e-9
    ends = [pp.dead_centres(built(press, found, k)) for k in range(8)]
    assert 0 < sum(each.top_angle > 0.0 for each in ends) < 8
    assert found.top.nominal + found.top.deviation[:8] == pytest.approx([each.top_position for each in ends], abs=1e-12)


def test_a_guide_whose_axis_points_down_changes_nothing():
    text = texts.shipped("crank_slide").text.decode()
    down = texts.load(text.replace('<axis xyz="0 0 1"/>', '<axis xyz="0 0 -1"/>'))
    assert (texts.load(text).slide_guide.sign, down.slide_guide.sign) == (1.0, -1.0)
    found = [
        tol.bottom_dead_centre(press, [tol.link_length(press, "P", "W", 1e-3)], forces={0.05: 1e5}, speeds={0.05: -7.0}, samples=50)
        for press in (texts.load(text), down)
    ]
    for one, other in zip(*(each.quantities for each in found), strict=True):
        assert other.nominal + other.deviation == pytest.approx(one.nominal + one.deviation, rel=1e-12)
        assert other.gradient == pytest.approx(one.gradient, rel=1e-10)


KNUCKLE = """
units: mm
frame: A O
pins:
  A: [0, 0]
  O: [600, -300]
  P: {{from: O, length: 100, angle: 60}}
  K: {{A: 300, P: {rod}, side: left}}
  S: {{K: 400, x: 0, side: down}}
links:
  crank: {{pins: O P, mass: 20}}
  rod: {{pins: P K, mass: 10}}
  upper: {{pins: A K, mass: 10}}
  lower: {{pins: K S, mass: 10}}
  slide: {{pins: S, guide: up, mass: 100}}
drive: O
"""


@pytest.mark.one_in(12)
@pytest.mark.parametrize("short", [0.0, 0.01, 1.0, -0.01, -1.0])
@pytest.mark.parametrize("tolerance", [1e-5, 1e-3])
def test_a_knuckle_that_some_presses_stretch_and_others_do_not(short, tolerance, tmp_path):
    """Crank and rod in line reach the stretched knuckle, or they do not: two circles tell where the slide is then lowest. The rod of the
    nominal press is ``short`` of it [mm]."""
    (tmp_path / "knuckle.yaml").write_text(KNUCKLE.format(rod=500 - short))
    press = pp.build(tmp_path / "knuckle.yaml")
    parts = [tol.link_length(press, "O", "P", tolerance), tol.link_length(press, "P", "K_lower", tolerance)]
    found = tol.bottom_dead_centre(press, parts, samples=3000)
    reach = 0.6 - 1e-3 * short + found.deviations.sum(axis=0)
    aside = np.arcsin((0.54 - reach**2) / np.hypot(0.36, 0.18)) - np.arctan2(0.18, 0.36)  # crank and rod in line
    aside = np.maximum(aside, 0.0)  # beyond it the knuckle passes through the stretched pose
    lowest = -0.3 * np.cos(aside) - np.sqrt(0.4**2 - (0.3 * np.sin(aside)) ** 2)
    assert found.height.nominal + found.height.deviation == pytest.approx(lowest, abs=2e-15)


@pytest.mark.filterwarnings("ignore:.*does not move the slide at a dead centre:pinpress.PinpressWarning")
def test_a_toggle_whose_screw_passes_the_stretched_pose_in_some_presses():
    """Its lower place is the limit of the screw, or a turning point just short of it."""
    press = pp.build(Path(pp.__file__).parent / "pin_table" / "templates" / "toggle.yaml")
    found = tol.bottom_dead_centre(press, all_pivots(press, 0.003 * press.size), samples=200)
    tolerances, inside = np.array([part.tolerance for part in found.parts]), 0
    corners = np.sign(found.gradient) * tolerances
    for k, deviations in enumerate([-corners, corners, *found.deviations[:, :6].T]):
        found_here = found.height.corners[k] if k < 2 else found.height.deviation[k - 2]
        ends = pp.dead_centres(reshaped(press, moved_pivots(press, found.parts, deviations)))
        inside += ends.bottom_angle < press.branch.angles[-1] - 1e-3
        assert found.height.nominal + found_here == pytest.approx(ends.bottom_position, abs=1e-13)
    assert 0 < inside < 8


def test_a_dimension_that_moves_the_slide_at_one_end_alone_is_not_doubted():
    """The guide beside a crank-slide that stands in its bottom dead centre; the suite takes warnings for errors."""
    press = texts.shipped("crank_slide")
    guide = tol.pin_position(press, "slide_guide", "x", 1e-4)
    found = tol.bottom_dead_centre(press, [guide], motion=pp.servo_cycle(press, [0.0, 1.0], speed=0.0), samples=50)
    assert found.gradient == pytest.approx([0.0], abs=1e-12)
    assert abs(found.top.gradient[0]) > 0.1
    along = tol.pin_position(press, "slide_guide", "z", 1e-4)
    with pytest.warns(pp.PinpressWarning, match="'slide_guide z' does not move the slide at a dead centre"):
        tol.bottom_dead_centre(press, [guide, along], samples=50)


def test_torque_and_speed_are_those_of_the_reshaped_press(press, found):
    """At the height above its own bottom dead centre, found among the states of one turn."""
    other = built(press, found, LATE)
    low = pp.dead_centres(other)
    for height, sense, quantity, factor in [
        (0.006, 1.0, found.torques[0.006], -3e6),
        (0.05, 1.0, found.speeds[0.05], -7.0),
        (0.1, -1.0, found.speeds[0.1], -7.0),
    ]:
        near = low.bottom_angle - sense * np.linspace(0.01, 2.0, 400)
        above = pp.servo_cycle(other, speed=1.0, angle=near[::-1] if sense > 0 else near).slide_position - low.bottom_position
        angle = np.interp(height, np.sort(above), near)
        for _ in range(4):
            state = pp.servo_cycle(other, speed=1.0, angle=[angle])
            angle -= (state.slide_position[0] - low.bottom_position - height) / state.slide_velocity[0]
        state = pp.servo_cycle(other, speed=sense, angle=[angle])
        value = factor * state.slide_velocity[0]
        assert quantity.nominal > 0
        assert quantity.nominal + quantity.deviation[LATE] == pytest.approx(value, rel=1e-11)


def test_slow_cranks_turn_forwards_too(press):
    """Half a radian a second; the speed on the way down is another one where the crank turns backwards."""
    rod = [tol.link_length(press, "E", "F", 5e-5)]
    slow, fast, back = (tol.bottom_dead_centre(press, rod, speeds={0.2: speed}, samples=2).speeds[0.2] for speed in (0.5, 2.0, -2.0))
    assert slow.nominal == pytest.approx(fast.nominal / 4)
    assert abs(back.nominal / fast.nominal - 1.0) > 0.02


def test_torques_of_a_crank_that_turns_backwards(press):
    """From the power of the force on the slide of a cycle that goes backwards; so where all speeds are negative."""
    rod = [tol.link_length(press, "E", "F", 5e-5)]
    forwards, mixed, back = (
        tol.bottom_dead_centre(press, rod, forces={0.2: 1e6}, speeds=speeds, samples=2).torques[0.2]
        for speeds in ({}, {0.1: 2.0, 0.2: -2.0}, {0.1: -2.0, 0.2: -2.0})
    )
    assert mixed.nominal == forwards.nominal > 0 > back.nominal
    cycle = pp.cycle(press, speed=-1.0, points=7200)
    above = cycle.slide_position - pp.dead_centres(press).bottom_position
    down = np.flatnonzero((cycle.slide_velocity < 0) & (above > 0.19) & (above < 0.21))[::-1]
    assert back.nominal == pytest.approx(1e6 * np.interp(0.2, above[down], cycle.slide_velocity[down]), rel=1e-4)


def test_presses_that_close_in_another_assembly_are_refused(press):
    """A crank of 0.143 m that is 0.42 m shorter would point the other way, with a length of -0.277 m."""
    crank = tol.link_length(press, "A", "B", 0.01, shape=[-0.42, 0.001])
    with pytest.raises(pp.PinpressError, match=r"in the assembly of zxn2_3000b; the first of them deviates by -0\.42 "):
        tol.bottom_dead_centre(press, [crank], samples=50)


def test_lengths_scale(press):
    """All pivots moved in proportion to their places move the slide in proportion: dz/dp . p is z itself."""
    swollen = tol.Dimension("all lengths", pivot_positions(press), 1e-6)
    ends = pp.dead_centres(press)
    assert np.array(dead_centre_gradients(press, [swollen])).ravel() == pytest.approx([ends.bottom_position, ends.top_position], rel=1e-12)


def test_bands_are_quantiles(press):
    """Of uniform dimensions, two of which count, the band is narrower than three standard deviations say."""
    found = tol.bottom_dead_centre(press, six_bar(press, "uniform"), samples=40_000)
    low, high = found.height.band(0.9973)
    assert (low, high) == (pytest.approx(-101e-6, abs=2e-6), pytest.approx(101e-6, abs=2e-6))
    assert 3 * found.height.sd == pytest.approx(125e-6, abs=1.5e-6)
    assert found.height.within(low, high) == pytest.approx(0.9973, abs=1e-4)
    with pytest.raises(pp.PinpressError, match=r"leaves 2 of 40000 presses at each end.*samples=100000 or more"):
        found.height.band(0.9999)


def test_correlated_lengths(press):
    """Rods from one batch, as long or as short as each other, double their deviations; opposite ones cancel."""
    parts = [tol.link_length(press, *pins, 5e-5) for pins in ("DE", "EF")]
    sd = {}
    for coefficient in (1.0, 0.0, -1.0):
        found = tol.bottom_dead_centre(press, parts, correlation={("DE", "EF"): coefficient}, samples=4000)
        sd[coefficient] = found.height.first_order_sd
        assert found.height.sd == pytest.approx(sd[coefficient], rel=0.04, abs=1e-9)
        assert found.share.sum() == pytest.approx(1.0)
    assert sd[1.0] == pytest.approx(5e-5 / 3 * np.abs(found.gradient).sum())
    assert sd[0.0] == pytest.approx(5e-5 / 3 * np.linalg.norm(found.gradient))
    assert sd[-1.0] == pytest.approx(5e-5 / 3 * abs(found.gradient[0] - found.gradient[1]))


def test_a_text_says_what_decides(found):
    text = str(found)
    assert "EF, DE make 96 % of the variance: half as wide, the standard deviation falls to 53 %" in text
    assert "-0.1320 and 0.1332 mm" in text
    assert re.search(r"angle CDE +0.01 deg", text)
