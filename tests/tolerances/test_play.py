"""Where the slide stands in its clearances: against displaced pins, by hand, and where forces reverse."""

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators.spatial_crank_slide import CRANK_AXIS, SPATIAL
from support.presses.two_servos import TWO_SERVOS

import pinpress as pp
from pinpress import tolerances
from pinpress.derivatives import pivot_positions, reshaped
from pinpress.kinematics.poses import poses
from pinpress.tolerances.virtual_work import unit_forces

RPM = pp.RPM
PINS = dict.fromkeys("ABCDEF", 50e-6)


@pytest.fixture(scope="module")
def six_bar():
    return texts.shipped("zxn2_3000b")


@pytest.fixture(scope="module")
def light():
    """A crank-slide whose rod and crank weigh nothing, so that all forces of its pins are along the rod."""
    return texts.load(texts.without_mass(texts.shipped("crank_slide").text.decode(), "rod", "crank"))


def at_bottom(press, load=0.0):
    """The press at standstill at bottom dead centre, and a force up on the slide."""
    motion = pp.servo_cycle(press, [pp.dead_centres(press).bottom_angle], speed=0.0)
    return motion, [pp.loads.PointForce("slide", (0.0, 0.0, load))]


def with_displaced_pins(press, motion, clearance, loads):
    """The press of other lengths in which every child's pin stands off its parent's against the force, in the first state of a motion."""
    reactions, at, where = pp.inverse_dynamics(press, motion, loads), poses(press, motion.joint_position), pivot_positions(press)
    ends = {joint: int(press.model.parents[j]) for j, joint in enumerate(press.joints, 1)} | {
        loop.name: loop.joint1 for loop in press.loops
    }
    moved = {}
    for name, width in clearance.items():
        force = reactions.bearing_force[name][0] * [1, 0, 1]
        link = next(link for bearing, link in where if bearing == name and body(press, link) == ends[name])
        off = -width * force / np.linalg.norm(force)
        own = at.rotation[ends[name]][0] @ press.model.frames[press.model.getFrameId(link, pin.BODY)].placement.rotation
        moved[name, link] = where[name, link] + own.T @ off
    return reshaped(press, moved)


def body(press, link):
    return press.model.frames[press.model.getFrameId(link, pin.BODY)].parentJoint


@pytest.mark.parametrize(("load", "offset"), [(0.0, -0.1597), (1e5, 0.0671), (3e6, 0.1594)])
def test_pins_displaced_in_the_linkage_move_bottom_dead_centre_as_the_formula_says(six_bar, load, offset):
    motion, loads = at_bottom(six_bar, load)
    found = tolerances.play(six_bar, motion, PINS, loads)
    displaced = pp.dead_centres(with_displaced_pins(six_bar, motion, PINS, loads)).bottom_position
    exact = displaced - pp.dead_centres(six_bar).bottom_position
    assert found.offset[0] == pytest.approx(exact, abs=1.2e-7)  # of second order in clearances of 0.05 mm
    assert found.bottom_shift == pytest.approx(1e-3 * offset, abs=2e-6)
    assert found.offset == pytest.approx(sum(found.by_bearing.values()))


def test_offset_of_a_crank_slide_is_the_clearance_along_its_rod(light):
    clearance = {"O": 2e-5, "P": 3e-5, "W": 1e-5}
    angle = np.linspace(0.0, 2 * np.pi, 7)[:-1]
    along = np.sqrt(1 - (0.25 * np.sin(angle)) ** 2)
    motion = pp.servo_cycle(light, angle, speed=0.0)
    for force, sign in ((0.0, -1), (2000.0, 1)):  # the slide weighs 981 N
        found = tolerances.play(light, motion, clearance, [pp.loads.PointForce("slide", (0.0, 0.0, force))])
        assert found.offset == pytest.approx(sign * 6e-5 / along)
        assert found.by_bearing["P"] == pytest.approx(sign * 3e-5 / along)
        assert not found.reversals


def test_a_crank_slide_reverses_at_top_dead_centre_from_the_speed_of_free_fall_on(light):
    free_fall = np.sqrt(9.81 / (0.1 * (1 - 0.25)))
    found = tolerances.play_over_speeds(light, {"W": 1e-5, "P": 1e-5}, speed=[0.99 * free_fall, 1.02 * free_fall])
    assert found.reversing_speed == {"W": pytest.approx(free_fall, rel=1e-6), "P": pytest.approx(free_fall, rel=1e-6)}
    assert found.reversals.tolist() == [0, 4]
    assert found.top_shift == pytest.approx([-2e-5, 2e-5])
    assert found.bottom_shift == pytest.approx(-2e-5)


def test_a_force_that_reverses_moves_the_slide_by_twice_its_clearance_and_leaves_a_band_around(light):
    found = tolerances.play(light, pp.cycle(light, 15.0), {"W": 1e-5})
    up, down = found.reversals
    assert [up.side, down.side] == ["pressed", "hanging"]
    state = round(up.crank_angle / np.radians(1.0))
    slope = 1 / np.sqrt(1 - (0.25 * np.sin(up.crank_angle)) ** 2)
    assert up.change == pytest.approx(2e-5 * slope, rel=1e-5)
    assert down.change == pytest.approx(-up.change)
    assert (found.offset[state - 3], found.offset[state + 3]) == pytest.approx((-1e-5 * slope, 1e-5 * slope), rel=0.02)
    assert found.undetermined["W"][state]
    assert (found.lowest[state], found.highest[state]) == pytest.approx((-1e-5 * slope, 1e-5 * slope), rel=1e-3)
    sure = ~found.undetermined["W"]
    assert np.array_equal(found.lowest[sure], found.offset[sure])
    parts = 9.81, found.motion.slide_acceleration  # by which the force is m (g + a)
    assert np.array_equal(found.undetermined["W"], np.abs(sum(parts)) <= 0.05 * (9.81 + np.abs(parts[1])))


def test_a_force_reverses_between_two_states_and_between_the_last_state_of_a_turn_and_the_first(light):
    """Twice the slide's weight holds it up in the first state, four times its weight in the ninth: the pin is free at 1/2, 1/4, 3/4 and
    1/2 of the steps around them."""
    motion = pp.cycle(light, 1e-3, points=60)
    weight = -pp.inverse_dynamics(light, pp.servo_cycle(light, [0.0], speed=0.0)).shaking_force[0, 2]
    upwards = np.zeros((60, 3))
    upwards[[0, 8], 2] = 2.0 * weight, 4.0 * weight
    found = tolerances.play(light, motion, {"W": 1e-5}, [pp.loads.PointForce("slide", lambda motion: upwards[: len(motion.v)])])
    angles = np.radians([3.0, 43.5, 52.5, 357.0])
    assert [each.crank_angle for each in found.reversals] == pytest.approx(angles, abs=3e-4)
    assert [each.side for each in found.reversals] == ["hanging", "pressed", "hanging", "pressed"]
    slopes = 1 / np.sqrt(1 - (0.25 * np.sin(angles)) ** 2)
    assert [each.change for each in found.reversals] == pytest.approx([-2e-5, 2e-5, -2e-5, 2e-5] * slopes, rel=3e-4)


def test_speed_and_a_balance_cylinder_move_dead_centres_of_a_six_bar_press(six_bar):
    slow, fast = (tolerances.play(six_bar, pp.cycle(six_bar, speed * RPM), PINS) for speed in (50.0, 70.0))
    assert not slow.reversals
    rod = [(each.bearing, each.side, round(np.degrees(each.crank_angle))) for each in fast.reversals if each.bearing == "F"]
    assert rod == [("F", "pressed", 124), ("F", "hanging", 189)]
    assert (fast.top_shift, fast.bottom_shift) == pytest.approx((0.6e-3, -0.16e-3), abs=3e-6)
    cylinder = pp.loads.PointForce("slide", (0.0, 0.0, 1.2 * 9.81 * 7073.87))
    balanced = tolerances.play(six_bar, pp.cycle(six_bar, 10 * RPM), PINS, [cylinder])
    assert balanced.bottom_shift == pytest.approx(0.048e-3, abs=1e-6)
    assert balanced.by_bearing["D"][np.argmin(balanced.motion.slide_position)] < 0  # it still carries the rocker


def test_friction_of_the_gibs_decides_where_a_balanced_slide_stands(light):
    """A cylinder carries all that weighs something: the slide stands behind its pins, low on the way up and high on the way down."""
    angle = np.array([0.6, 2.0, 3.5, 5.5])
    motion, weight = pp.servo_cycle(light, angle, speed=0.01), [pp.loads.PointForce("slide", (0.0, 0.0, 981.0))]
    drag = {"slide_guide": pp.loads.Friction(viscous=1e6)}
    found = tolerances.play(light, motion, {"O": 2e-5, "P": 3e-5, "W": 1e-5}, weight, friction=drag)
    along = np.sqrt(1 - (0.25 * np.sin(angle)) ** 2)
    assert found.offset == pytest.approx(-np.sign(motion.slide_velocity) * 6e-5 / along)
    assert not found.undetermined["W"].any()
    assert tolerances.play(light, motion, {"W": 1e-5}, weight).undetermined["W"].all()
    weak = {"slide_guide": pp.loads.Friction(viscous=8e4)}  # some 6 % of weight and cylinder together: no more than they are known to
    assert tolerances.play(light, motion, {"W": 1e-5}, weight, friction=weak, known_to=0.07).undetermined["W"].all()
    over = tolerances.play_over_speeds(light, {"W": 1e-5}, speed=0.01, loads=weight, friction=drag)
    assert (over.bottom_shift[0], over.reversals[0], over.reversing_speed) == (pytest.approx(0.0, abs=1e-5), 2, {})


def test_contacts_of_pins_with_friction_may_lean_to_either_side(six_bar):
    """By the angle whose sine is the coefficient, each contact turned by hand."""
    angle, mu, width = np.array([0.4, 1.9, 4.0]), 0.3, 5e-5
    motion, friction = pp.servo_cycle(six_bar, angle, speed=5.0), {"C": pp.loads.Friction(mu, radius=0.1)}
    found = tolerances.play(six_bar, motion, {"C": width, "E": width}, friction=friction, known_to=0.0)
    forces = pp.inverse_dynamics(six_bar, motion, friction=friction).bearing_force
    unit = unit_forces(six_bar, motion).force["C"][:, [0, 2]]
    along = forces["C"][:, [0, 2]] / np.linalg.norm(forces["C"][:, [0, 2]], axis=1)[:, None]
    assert found.by_bearing["C"] == pytest.approx(width * np.einsum("nk,nk->n", unit, along))
    cosine, leaning = np.sqrt(1 - mu * mu), []
    for sine in (mu, -mu):
        turned = along @ np.array([[cosine, sine], [-sine, cosine]])
        leaning.append(width * np.einsum("nk,nk->n", unit, turned) - found.by_bearing["C"])
    assert found.highest - found.offset == pytest.approx(np.abs(leaning).max(axis=0))
    assert found.offset - found.lowest == pytest.approx(np.abs(leaning).max(axis=0))
    rigid = motion.slide_position
    assert found.bottom_band == pytest.approx([(rigid + edge).min() - rigid.min() for edge in (found.lowest, found.highest)])
    assert np.abs(forces["C"] - pp.inverse_dynamics(six_bar, motion).bearing_force["C"]).max() > 100.0  # the forces are those with friction


def test_a_press_with_parallel_rods_moves_as_one_with_a_single_rod():
    one, two = texts.shipped("jf75g_125"), texts.shipped("jf75g_125_two_point")
    single = tolerances.play(one, pp.cycle(one, 30.0), {"P4": 1e-5, "P5": 1e-5})
    double = tolerances.play(two, pp.cycle(two, 30.0), {"P4_front": 1e-5, "P4_back": 1e-5})
    assert double.offset == pytest.approx(single.offset, rel=1e-6)
    assert not single.by_bearing["P5"].any() or np.abs(single.by_bearing["P5"]).max() < 1e-12  # the counterweight's rod does not carry it
    assert {each.bearing for each in single.reversals} == {"P4"}
    over = tolerances.play_over_speeds(one, dict.fromkeys(("O", "P2", "P4"), 1e-5), speed=[200 * RPM, 300 * RPM])
    assert (over.top_shift, over.bottom_shift) == (pytest.approx([-3e-5, 1e-5], rel=0.01), pytest.approx(-3e-5, rel=1e-3))
    assert over.reversing_speed["P4"] == pytest.approx(np.sqrt(9.81 / (0.015 * (1 - 0.015 / 0.3))), rel=1e-3)


@pytest.mark.parametrize("beside", [0.0, 0.4])
def test_a_slide_stands_askew_in_its_guide_where_the_load_is_beside_its_axis(light, beside):
    angle, length, middle = 1.0, 0.2, -0.05
    motion = pp.servo_cycle(light, [angle], speed=0.0)
    load = pp.loads.PointForce("slide", (0.0, 0.0, 1e4), (beside, 0.0, 0.0))
    found = tolerances.play(light, motion, {"slide_guide": tolerances.GuideClearance(1e-5, length, middle)}, [load])
    reactions = pp.inverse_dynamics(light, motion, [load])
    across, moment = reactions.bearing_force["slide_guide"][0, 0], reactions.bearing_moment["slide_guide"][0, 1]
    lower, upper = middle - length / 2, middle + length / 2
    ends = np.linalg.solve([[1, 1], [upper, lower]], [across, moment])  # a force to x above the origin turns about y
    at_ends = -1e-5 * np.sign(ends)
    assert found.shift[0] == pytest.approx([at_ends.mean(), 0, 0])
    assert found.rotation[0] == pytest.approx([0, (at_ends[0] - at_ends[1]) / length, 0])
    assert bool(found.rotation.any()) == (beside > 0)
    assert found.columns()["shift_x [m]"] == pytest.approx(found.shift[:, 0])
    assert found.columns()["rotation_y [rad]"] == pytest.approx(found.rotation[:, 1])
    pin_moved = found.shift[0, 0] - middle * found.rotation[0, 1]
    place = pivot_positions(light)["slide_guide", "frame"]
    moved = reshaped(light, {("slide_guide", "frame"): place + np.array([1e-3 * np.sign(pin_moved), 0, 0])})
    slope = (pp.servo_cycle(moved, [angle], speed=0.0).slide_position[0] - motion.slide_position[0]) / 1e-3
    assert found.offset[0] == pytest.approx(abs(pin_moved) * slope, rel=0.01)


def test_a_ball_joint_in_space_displaced_in_the_linkage_moves_the_slide_as_the_formula_says():
    press = texts.load(SPATIAL)
    motion = pp.servo_cycle(press, [0.7], speed=0.0)
    found = tolerances.play(press, motion, {"W": 5e-5, "P": 2e-5})
    force = pp.inverse_dynamics(press, motion).bearing_force["W"][0]
    own = poses(press, motion.joint_position).rotation[press.joints.index("Q") + 1][0]
    place = pivot_positions(press)["W", "rod"] - 5e-5 * own.T @ force / np.linalg.norm(force)
    moved = pp.servo_cycle(reshaped(press, {("W", "rod"): place}), [0.7], speed=0.0)
    assert found.by_bearing["W"][0] == pytest.approx(moved.slide_position[0] - motion.slide_position[0], rel=1e-3)
    push = pp.inverse_dynamics(press, motion).bearing_force["P"][0]
    push = push - (push @ CRANK_AXIS) * CRANK_AXIS  # what acts along the pin is carried by its shoulders
    own = poses(press, motion.joint_position).rotation[press.joints.index("O") + 1][0]
    place = pivot_positions(press)["P", "crank"] - 2e-5 * own.T @ push / np.linalg.norm(push)
    moved = pp.servo_cycle(reshaped(press, {("P", "crank"): place}), [0.7], speed=0.0)
    assert found.by_bearing["P"][0] == pytest.approx(moved.slide_position[0] - motion.slide_position[0], rel=1e-3)
    with pytest.raises(pp.PinpressError, match="is not planar: give the clearance of guide"):
        tolerances.play(press, motion, {"guide": tolerances.GuideClearance(1e-5, 0.2)})


def test_two_servos_that_move_together_and_their_clearances(tmp_path):
    """The slide hangs from its pin, then a force that grows lifts it; it stands where a linkage with this pin displaced has it."""
    (tmp_path / "servos.yaml").write_text(TWO_SERVOS)
    press = pp.build(tmp_path / "servos.yaml")
    angles = np.column_stack([np.linspace(-0.3, 0.3, 25), np.zeros(25)])
    motion = pp.servo_cycle(press, angles, speed=0.0)
    rising = pp.loads.PointForce("slide", lambda motion: np.outer(np.linspace(0.0, 1e4, 25), [0.0, 0.0, 1.0]))  # the slide weighs 4.9 kN
    found = tolerances.play(press, motion, {"S": 5e-5}, [rising])
    (reversal,) = found.reversals
    assert (reversal.bearing, reversal.side) == ("S", "pressed")
    assert np.degrees(reversal.crank_angle) == pytest.approx(
        np.degrees(np.interp(4905.0, np.linspace(0.0, 1e4, 25), angles[:, 0])), abs=0.5
    )
    force = pp.inverse_dynamics(press, motion, [rising]).bearing_force["S"][0] * [1, 0, 1]
    turned = poses(press, motion.joint_position[:1]).rotation[press.loops[press.bearings.index("S") - len(press.joints)].joint1][0]
    place = pivot_positions(press)["S", "rod"] - 5e-5 * turned.T @ force / np.linalg.norm(force)
    moved = pp.servo_cycle(reshaped(press, {("S", "rod"): place}), angles[:1], speed=0.0)
    assert found.offset[0] == pytest.approx(moved.slide_position[0] - motion.slide_position[0], abs=1e-8)


def test_clearances_in_millimetres_have_a_warning(light):
    motion = pp.cycle(light, 9.0, points=8)
    with pytest.warns(pp.PinpressWarning, match=r"is 0\.05 m \(50 mm\), .*Is it 0\.05 mm\? Write 5e-05"):
        tolerances.play(light, motion, {"W": 0.05})


@pytest.mark.exhaustive
def test_a_simulated_press_with_clearance_and_impacts_stands_where_play_has_it():
    """But where the journal bounces, up to 80 deg behind each reversal."""
    press, speed, width = texts.shipped("crank_slide"), 12.0, 2e-4
    springs = pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 2e8), moments={"slide_guide": 2e7})
    elastic = pp.elasticity.Elastic(springs, damping_ratio=0.1, clearances={"P": pp.elasticity.Clearance(width)})
    run = pp.simulate(press, 4 * np.pi / speed, drive=pp.drives.PrescribedSpeed(speed), elastic=elastic, points=400)
    found = tolerances.play(press, run, {"P": width})
    bent = pp.elasticity.slide_deflection(press, run, springs).deflection
    settled = run.time > 2 * np.pi / speed
    error = np.abs(run.slide_position - run.rigid_slide_position - found.offset - bent)[settled]
    turned = (np.degrees(run.crank_angle[settled]) + 180.0) % 360.0 - 180.0
    assert error[(turned > -50.0) & (turned < 100.0)].max() < 1e-6
    at_top = np.cos(run.crank_angle[settled]) < np.cos(np.radians(160.0))
    assert np.median((run.slide_position - run.rigid_slide_position)[settled][at_top]) == pytest.approx(width, rel=0.2)
    assert len(found.reversals) == 4
