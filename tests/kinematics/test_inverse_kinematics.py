"""Inverse kinematics: random places that can be reached are reached, and others are refused with the distance that is left."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from reference.robots.cases import FOLDER
from support import texts

import pinpress as pp
from pinpress.engines.mounting import within

DOCS = Path(__file__).resolve().parents[2] / "docs" / "robots"
FIVE_BAR = FOLDER / "09_companion_yaml_3d" / "robot.urdf"
# file, frame, and how far its drivers are moved
ROBOTS = {
    "five-bar": (FIVE_BAR, "rod_a", 0.6),
    "rod": (FOLDER / "10_companion_yaml_6d_types" / "robot.urdf", "rocker", 0.5),
    "tripod": (FOLDER / "17_legs_between_two_balls.urdf", "plate", 0.03),
    "leg": (DOCS / "leg.urdf", "foot", 0.8),
    "platform": (DOCS / "platform.urdf", "tool", 0.08),
}


loaded = cache(pp.load)  # linkages are read-only: tests share them and what they have found out


def reachable(press, reach, count, seed=3):
    """Random driver positions (n, drivers) within the limits of all joints."""
    positions = np.random.default_rng(seed).uniform(-reach, reach, (3 * count, len(press.drivers)))
    motion = pp.servo_cycle(press, positions if len(press.drivers) > 1 else positions[:, 0], speed=0.0)
    inside = [within(press.structure, x).all() for x in motion.joint_position]
    return positions[inside][:count]


@pytest.mark.one_in(7)
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")  # of the files
@pytest.mark.parametrize("oriented", [False, True])
@pytest.mark.parametrize("name", ROBOTS)
def test_random_places_within_reach_are_reached(name, oriented):
    file, frame, reach = ROBOTS[name]
    press = loaded(file)
    positions = reachable(press, reach, 15)
    one = len(press.drivers) == 1
    places = press.placements(frame, positions[:, 0] if one else positions)
    found = pp.inverse_kinematics(press, frame, places if oriented else places[:, :3, 3])
    assert found.shape == (len(positions),) if one else positions.shape
    reached = press.placements(frame, found)
    size = press.size if oriented else 1.0
    rows = slice(None) if oriented else (slice(None), slice(3), 3)
    np.testing.assert_allclose(reached[rows], places[rows], rtol=0, atol=1e-8 * max(1.0, size))
    if oriented and name != "rod":  # the drivers are as before where they determine the place one to one
        np.testing.assert_allclose(found, positions, rtol=0, atol=1e-6)


def test_a_line_of_the_hand_is_followed():
    """The knee of a five-bar on a circle about its pin: the crank's angle is that of the circle."""
    press = loaded(FIVE_BAR)
    turned = np.linspace(0.0, 0.5, 20)
    begin = press.placements("rod_a", [0.0, 0.0])[:3, 3]
    centre = press.placements("crank_a", [0.0, 0.0])[:3, 3]
    arm = begin - centre
    cos, sin = np.cos(turned), np.sin(turned)
    places = centre + np.column_stack([cos * arm[0] - sin * arm[2], 0 * turned, sin * arm[0] + cos * arm[2]])
    found = pp.inverse_kinematics(press, "rod_a", places)
    np.testing.assert_allclose(found[:, 0], turned, rtol=0, atol=1e-9)  # axis 0 -1 0
    assert np.abs(np.diff(found, axis=0)).max() < 0.1


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")  # of a base that is held
def test_a_floating_base_rests():
    """The motors of an arm on a floating base are those of the arm on the ground."""
    held, floating = (pp.load(FOLDER / "18_floating_base.urdf", base=base) for base in ("fixed", "floating"))
    positions = reachable(held, 0.4, 5)
    places = held.placements("rod_a", positions)
    found = pp.inverse_kinematics(floating, "rod_a", places)
    np.testing.assert_allclose(found, positions, rtol=0, atol=1e-8)
    np.testing.assert_allclose(pp.servo_cycle(floating, found, speed=0.0).crank_angle[:, :2], positions, rtol=0, atol=1e-8)


def test_what_is_out_of_reach_is_named_with_its_distance():
    press = loaded(FIVE_BAR)
    centre = press.placements("crank_a", [0.0, 0.0])[:3, 3]
    far = centre + np.array([0.0, 0.0, 0.6])
    with pytest.raises(pp.PinpressError, match=r"'rod_a' of .* does not reach place 0, .*: the nearest pose that was found is 390 mm away"):
        pp.inverse_kinematics(press, "rod_a", [far])
    leg = loaded(DOCS / "leg.urdf")
    home = leg.placements("foot", np.zeros(2))
    lifted = home.copy()
    lifted[2, 3] += 0.2
    with pytest.raises(pp.PinpressError, match=r"does not reach place 1, .* mm and .* deg away, at hip .* within the limits"):
        pp.inverse_kinematics(leg, "foot", [home, lifted])


@pytest.mark.exhaustive
def test_places_of_the_other_assembly_are_refused():
    """The coupler of a parallelogram, which in the other assembly turns."""
    file = FOLDER / "15_flat_zero_pose.urdf"
    parallel, crossed = (pp.load(file, pose={"crank_turn": 0.6, "rocker_turn": rocker}) for rocker in (0.6, -0.6))
    places = crossed.placements("coupler", [0.6, 0.8])
    np.testing.assert_allclose(pp.inverse_kinematics(crossed, "coupler", places), [0.6, 0.8], rtol=0, atol=1e-9)
    with pytest.raises(pp.PinpressError, match=r"reaches place 0, .* no straight way of the drivers leads there from the home pose"):
        pp.inverse_kinematics(parallel, "coupler", places)


@pytest.mark.parametrize(
    ("places", "message"),
    [
        ([0.1, 0.2, 0.3], r"places has shape \(3,\): give \(n, 3\) positions"),
        ([[[2.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]], r"places\[0\] is not a placement"),
        ([np.diag([1.0, 1.0, -1.0, 1.0])], r"places\[0\] is not a placement"),
        ([[0.1, np.nan, 0.3]], "places is not finite"),
    ],
)
def test_what_is_no_place_is_refused(places, message):
    with pytest.raises(pp.PinpressError, match=message):
        pp.inverse_kinematics(loaded(FIVE_BAR), "rod_a", places)
    assert pp.inverse_kinematics(loaded(FIVE_BAR), "rod_a", np.empty((0, 3))).shape == (0, 2)


# ----------------------------------------------------------------------------------------------------- states that are not reached


def knees_apart(press, positions):
    """Distance of the knees of the five-bar (n,), which two rods of 0.31 and 0.29 m join [m]."""
    model = press.model
    ends = []
    for joint, sign in (("turn_a", 0.21), ("turn_b", 0.19)):
        place = model.jointPlacements[model.getJointId(joint)]
        angle = positions[:, press.drivers.index(joint)]
        along = np.column_stack([np.cos(angle), 0 * angle, np.sin(angle)])  # about 0 -1 0
        ends.append(place.translation + sign * along @ place.rotation.T)
    return np.linalg.norm(ends[0] - ends[1], axis=1)


@pytest.mark.exhaustive
def test_states_that_are_not_reached_are_gaps():
    """Where the knees come nearer to each other than the rods differ in length, the linkage locks. The first motion turns back there, the
    second one goes through, to states that no straight way leads to; it comes back later."""
    press, turn = loaded(FIVE_BAR), np.linspace(0.0, 2 * np.pi, 400)
    way = np.array([-1.8, 1.5])
    narrowest = 1e-3 * int(np.argmin(knees_apart(press, 1e-3 * np.outer(np.arange(1000), way))))
    time = np.linspace(0.0, 1.0, 400)
    for most in (narrowest, 1.0):
        positions = most * np.outer(np.sin(turn) ** 2, way)
        motion = pp.servo_cycle(press, positions, time=time, on_singular="nan")
        reached = knees_apart(press, positions) > 0.02
        reached &= positions[:, 0] > narrowest * way[0]
        np.testing.assert_array_equal(motion.valid, reached)
        assert len(motion.reasons) == 2
    with pytest.raises(pp.SingularityError) as caught:
        pp.servo_cycle(press, positions, time=time)
    assert motion.reasons[0] == str(caught.value)
    np.testing.assert_array_equal(motion.crank_angle, positions)
    free = [press.joints.index(name) for name in ("knee_a", "knee_b")]
    for values in (motion.joint_position, motion.v, motion.a):
        np.testing.assert_array_equal(np.isnan(values[:, free]).any(axis=1), ~motion.valid)
        np.testing.assert_array_equal(np.isnan(values[:, free]).all(axis=1), ~motion.valid)
    first = int(np.argmin(motion.valid))
    before = pp.servo_cycle(press, positions[:first], speed=motion.crank_speed[:first], acceleration=motion.crank_acceleration[:first])
    np.testing.assert_allclose(motion.joint_position[:first], before.joint_position, rtol=0, atol=1e-9)
    load = pp.loads.PointForce("rod_a", [3.0, 0.0, -5.0])
    reactions, wanted = pp.inverse_dynamics(press, motion, [load]), pp.inverse_dynamics(press, before, [load])
    results = {
        "torque": reactions.driving_torque,
        "force": reactions.bearing_force["knee_a"],
        "moment": reactions.bearing_moment["turn_a"],
        "shaking": reactions.shaking_force,
        "balance": reactions.power_residual,
        "friction": reactions.friction_power["end"],
    }
    for name, values in results.items():
        gaps = np.isnan(values.reshape(len(values), -1))
        np.testing.assert_array_equal(gaps.any(axis=1), ~motion.valid, err_msg=name)
        np.testing.assert_array_equal(gaps.all(axis=1), ~motion.valid, err_msg=name)
    np.testing.assert_allclose(reactions.driving_torque[: first - 5], wanted.driving_torque[: first - 5], rtol=1e-6)
    assert np.nanmax(reactions.power_residual) < 1e-9
    np.testing.assert_array_equal(reactions.motion.valid, motion.valid)


@pytest.mark.exhaustive
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")  # of the file
def test_a_single_driver_leaves_gaps_too_and_a_limit_stays_an_error():
    rod = loaded(ROBOTS["rod"][0])
    angle = np.linspace(-2.5, 1.0, 50)
    motion = pp.servo_cycle(rod, angle, speed=1.0, on_singular="nan")
    np.testing.assert_array_equal(motion.valid, (angle > np.radians(-108.079)) & (angle < np.radians(30.0154)))
    assert len(motion.reasons) == 2
    assert all("the driver turns only from -108.079 to 30.0154 deg" in reason for reason in motion.reasons)
    np.testing.assert_array_equal(np.isnan(pp.inverse_dynamics(rod, motion).driving_torque), ~motion.valid)
    press = texts.shipped("thin_wall")
    assert pp.servo_cycle(press, np.linspace(0, 1, 8), speed=1.0, on_singular="nan").valid.all()
    five = loaded(FIVE_BAR)
    with pytest.raises(pp.PinpressError, match='on_singular is \'zero\': write "error" or "nan"'):
        pp.servo_cycle(five, [[0.0, 0.0]], speed=0.0, on_singular="zero")
    platform = loaded(DOCS / "platform.urdf")
    with pytest.raises(pp.PinpressError, match="slides from -120 mm to 120 mm only"):
        pp.servo_cycle(platform, np.full((3, 6), 0.13), speed=0.0, on_singular="nan")
