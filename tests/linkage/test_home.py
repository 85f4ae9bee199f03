"""A linkage is put together in its home pose, and everything counts from the zeros of its file."""

import dataclasses
import pickle
import re

import numpy as np
import pytest
from numpy.testing import assert_allclose
from reference.robots.cases import FOLDER
from support import texts
from support.generators.malformed_linkages import GOES, TRANSMISSION, changed
from support.generators.other_zeros import with_other_zeros

import pinpress as pp
from pinpress.linkage.linkage import is_same_press

ANGLES = np.linspace(0.3, 2.0, 5)
OPEN, FLAT = FOLDER / "14_open_pose.urdf", FOLDER / "15_flat_zero_pose.urdf"
WARNED = pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")


# ------------------------------------------------------------------------------------- the same numbers with the zeros elsewhere


def forces(press, begin, engine="auto"):
    motion = pp.servo_cycle(press, ANGLES + begin, speed=3.0, engine=engine)
    reactions = pp.inverse_dynamics(press, motion, engine=engine)
    return np.hstack([reactions.driving_torque, *(reactions.bearing_force[name].ravel() for name in press.bearings)])


def elastic(press):
    stiffness = pp.elasticity.Stiffness(bearings=dict.fromkeys(press.bearings, 1e9), moments={"slide_guide": 1e8})
    return pp.elasticity.Elastic(stiffness=stiffness, damping_ratio=0.02)


def of_longer_rod(press, begin):
    pivots = pp.derivatives.pivot_positions(press)
    *_, end = pivots
    longer = pp.derivatives.reshaped(press, {end: 1.02 * pivots[end]})
    return pp.servo_cycle(longer, ANGLES + begin, speed=3.0).slide_position


def derivatives(press, begin):
    *_, end = pp.derivatives.pivot_positions(press)
    (found,) = pp.derivatives.motion_derivatives(press, pp.servo_cycle(press, ANGLES + begin, speed=3.0), [{end: (1.0, 0.0, 0.0)}])
    return np.hstack([found.slide_position, found.slide_acceleration])


def dead_centres(press, begin):
    ends = pp.dead_centres(press)
    return [ends.stroke, np.remainder(ends.top_angle - begin + 0.1, 2 * np.pi), np.remainder(ends.bottom_angle - begin + 0.1, 2 * np.pi)]


QUANTITIES = {
    "forces in the plane": forces,
    "forces in space": lambda press, begin: forces(press, begin, "space"),
    "forces by Pinocchio": lambda press, begin: forces(press, begin, "pinocchio"),
    "far away": lambda press, begin: pp.servo_cycle(press, ANGLES * 1e4 + begin, speed=3.0).slide_position,
    "dead centres": dead_centres,
    "drawn elsewhere": lambda press, begin: pp.cycle(press.drawn_at(0.5 + begin), 3.0, points=9).slide_position,
    "drawn at home": lambda press, begin: pp.servo_cycle(press.drawn_at_home(), ANGLES, speed=3.0).slide_position,
    "a run": lambda press, begin: pp.simulate(press, 0.2, angle=1.0 + begin, speed=3.0).slide_position,
    "a run from home": lambda press, begin: pp.simulate(press, 0.2, speed=3.0).slide_position,
    "runs at once": lambda press, begin: pp.simulate_batch(press, 0.2, speed=np.array([3.0, 4.0])).crank_angle - begin,
    "a longer rod": of_longer_rod,
    "derivatives": derivatives,
    "on springs": lambda press, begin: pp.simulate(press, 0.005, speed=3.0, elastic=elastic(press)).slide_position,
    "frequencies": lambda press, begin: pp.elasticity.natural_frequencies(press, elastic(press), angle=ANGLES + begin).natural_frequency,
    "pickled": lambda press, begin: forces(pickle.loads(pickle.dumps(press)), begin),
}


@pytest.mark.one_in(8)
@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize("name", ["crank_slide", pytest.param("zxn2_3000b", marks=pytest.mark.exhaustive)])
def test_results_do_not_depend_on_where_the_zeros_are(name, quantity):
    press = texts.shipped(name)
    offsets = np.random.default_rng(0).uniform(-0.8, 0.8, press.model.nv) * np.where([axis.turns for axis in press.axes], 1.0, 0.3)
    moved = with_other_zeros(press, offsets)
    value = np.asarray(QUANTITIES[quantity](press, 0.0))
    assert_allclose(QUANTITIES[quantity](moved, offsets[press.driver_indices[0]]), value, rtol=1e-7, atol=1e-9 * np.abs(value).max())
    assert not is_same_press(press, moved)


@WARNED
def test_a_written_home_is_read_again(tmp_path):
    press = texts.shipped("crank_slide")
    moved = with_other_zeros(press, 0.3 * np.arange(1.0, 1.0 + press.model.nv))
    again = pp.load(pp.write_urdf(moved, tmp_path / "again.urdf"))
    assert again.home == moved.home
    assert again.assembly.how.startswith("the <home> of the file")
    assert pp.load(pp.write_urdf(again, tmp_path / "twice.urdf")).text == again.text
    back = pp.load(pp.write_urdf(again.drawn_at_home(), tmp_path / "back.urdf"))
    assert (back.home, back.assembly.how) == ((), "as drawn")
    assert b"<home>" not in back.text


@pytest.mark.exhaustive
def test_a_driver_that_slides_begins_at_home():
    """Between the limits of its joint, and from home where that is outside."""
    press = texts.load(changed((TRANSMISSION, TRANSMISSION.replace('"O"', '"guide"'))))
    guide = press.driver_indices[0]
    offsets = np.zeros(press.model.nv)
    offsets[guide] = 0.25
    moved = with_other_zeros(press, offsets)
    assert_allclose(moved.branch.angles[[0, -1]], press.branch.angles[[0, -1]] + 0.25, atol=1e-12)
    model = press.model.copy()
    model.lowerPositionLimit[press.slots[guide].start] = 4e-11
    assert dataclasses.replace(press, model=model).branch.angles[0] == 0.0


def test_several_drivers_are_followed_from_home():
    with pytest.warns(pp.PinpressWarning, match="121 mm apart as drawn"):
        press = pp.load(OPEN)
    offsets = np.array([0.4, -0.7, 0.2, 1.1])
    moved = with_other_zeros(dataclasses.replace(press, home=press.home), offsets)
    drivers = list(press.driver_indices)
    positions = press.closed[drivers] + [[0.1, -0.1], [0.3, -0.2]]
    found = [
        pp.servo_cycle(of, at, speed=np.ones((2, 2))).joint_position
        for of, at in ((press, positions), (moved, positions + offsets[drivers]))
    ]
    assert_allclose(found[1], found[0] + offsets, atol=1e-9)


@WARNED
def test_made_up_shapes_are_those_of_the_closed_linkage():
    """A rod reaches from pin to pin, though the loop is drawn open."""
    press = pp.load(OPEN)

    def shapes(of):
        return [
            np.hstack([each.parentJoint, each.placement.homogeneous.ravel(), each.geometry.aabb_radius])
            for each in pp.visual_model(of).geometryObjects
            if each.geometry.computeLocalAABB() is None
        ]

    assert_allclose(shapes(press), shapes(press.drawn_at_home()), atol=1e-9)


# ------------------------------------------------------------------------------------------------------------------------ the ladder


@WARNED
@pytest.mark.parametrize(
    ("pose", "knee_b", "how"),
    [
        (None, -0.2552323, "the drawn pose with the drivers held"),
        ({"knee_b": 3.0}, 3.0, "pose= as it stands"),
        ({"turn_a": 0.0, "turn_b": 0.0, "knee_b": 3.0}, 3.048512, "pose= with the drivers held"),
        ({"turn_a": 0.2, "turn_b": -0.1, "knee_a": 0.3, "knee_b": 0.4}, None, "pose= with the drivers held"),
    ],
)
def test_a_pose_chooses_the_assembly(pose, knee_b, how):
    press = pp.load(OPEN, pose=pose)
    assert press.assembly.closes
    assert press.assembly.how == how
    position = dict(zip(press.joints, press.closed, strict=True))
    if knee_b is not None:
        assert position["knee_b"] == pytest.approx(knee_b, abs=1e-6)
    assert press.assembly.moved == pytest.approx({name: value for name, value in position.items() if value})
    assert press.assembly.gap_drawn == pytest.approx(0.121, abs=5e-4)


@pytest.mark.exhaustive
def test_a_pose_that_does_not_close_is_warned_of():
    with pytest.warns(pp.PinpressWarning, match="no closed pose was found with the joints where pose= puts them"):
        press = pp.load(OPEN, pose={"turn_a": 1.5, "turn_b": -2.5})
    assert press.assembly.closes
    with pytest.raises(pp.SingularityError, match="two assemblies meet"):
        pp.load(FLAT, pose={"crank_turn": 0.0, "pin": 0.0, "rocker_turn": 0.0})


@WARNED
def test_other_assemblies_are_told_by_poses_that_choose_them():
    press = pp.load(OPEN)
    (other,) = press.assembly.others
    chosen = pp.load(OPEN, pose={"turn_a": 0.0, "turn_b": 0.0, **other})
    assert_allclose(chosen.closed[list(press.driver_indices)], 0.0)
    assert [list(each.values()) for each in chosen.assembly.others] == [
        pytest.approx([press.closed[press.joints.index(name)]]) for name in other
    ]
    assert "other assemblies there have knee_b 3.05" in str(pp.check(OPEN))


@pytest.mark.exhaustive
def test_where_assemblies_meet_the_message_lists_poses_that_choose_one():
    with pytest.raises(pp.SingularityError, match="two assemblies meet in the drawn pose") as caught:
        pp.load(FLAT)
    poses = [dict(re.findall(r"'(\w+)': (-?[\d.]+)", text)) for text in re.findall(r"\{.*?\}", str(caught.value))]
    found = [pp.load(FLAT, pose={name: float(value) for name, value in pose.items()}).closed for pose in poses]
    assert len(found) == 2
    for (crank, pin, rocker), crossed in zip(found, (False, True), strict=True):
        assert crank == pytest.approx(0.3)
        assert (rocker == pytest.approx(crank)) != crossed
        assert pin == pytest.approx(rocker if crossed else -rocker)
    assert pp.load(FLAT, pose={"rocker_turn": 0.6}).closed == pytest.approx([0.6, -0.6, 0.6])


@pytest.mark.parametrize(
    ("pose", "error", "message"),
    [
        ({"knee": 0.1}, pp.UnknownNameError, "no moving joint 'knee', did you mean 'knee_a'"),
        ({"knee_a": np.nan}, pp.PinpressError, "pose of joint 'knee_a' is nan: give a finite number"),
        ({"knee_a": "0.1"}, pp.PinpressError, "pose of joint 'knee_a' is '0.1'"),
    ],
)
def test_refused_poses(pose, error, message):
    with pytest.raises(error, match=message):
        pp.load(OPEN, pose=pose)


def test_a_home_of_joints_that_the_file_lacks_is_refused():
    for home, message in (
        ('<joint name="wheel" position="0"/>', "no moving joint 'wheel'"),
        ('<joint name="P" position="half"/>', "'half' is not a finite number"),
        ('<joint name="P"/>', "has no position"),
    ):
        with pytest.raises(pp.UrdfError, match=message):
            texts.load(GOES.replace("</robot>", f"<home>{home}</home></robot>"))


def test_a_linkage_outside_its_limits_at_home_is_warned_of():
    with pytest.warns(pp.PinpressWarning, match="knee_b.*put together with it at 0 rad .0 deg., outside its limits 0.4 to 2.4"):
        press = pp.load(FOLDER / "27_drawn_outside_limits.urdf")
    assert press.home == ()


@WARNED
def test_limits_choose_the_assembly_of_an_open_drawing(tmp_path):
    """The nearer one is outside the limits of a knee."""
    text = OPEN.read_text().replace(
        'name="knee_b" type="continuous">', 'name="knee_b" type="revolute"><limit lower="0.5" upper="3.1" effort="1" velocity="1"/>'
    )
    (tmp_path / "limited.urdf").write_text(text)
    press = pp.load(tmp_path / "limited.urdf")
    assert 0.5 - 1e-9 <= press.closed[press.joints.index("knee_b")] <= 3.1


def test_a_pose_far_from_any_assembly_is_warned_of():
    with pytest.warns(pp.PinpressWarning, match="with joint 'rocker_turn' at -?[0-9.]+ rad, far from -2.5 of pose="):
        pp.load(FLAT, pose={"crank_turn": 0.6, "rocker_turn": -2.5})
