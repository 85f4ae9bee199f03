"""Dialects of robot files beyond the small files with right values: what is passed over, warned of, and refused in one line each."""

import re
import warnings
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from reference.robots.cases import FOLDER
from support.generators import large_linkages

import pinpress as pp
from pinpress.linkage.loading import parse

PLAIN = (FOLDER / "27_drawn_outside_limits.urdf").read_text()
BODY = large_linkages.BODY


def loaded(folder, text, companion=None, name="robot.urdf"):
    """The linkage of a text, and the warnings with which it is loaded."""
    path = folder / name
    path.write_text(text)
    if companion is not None:
        path.with_suffix(".yaml").write_text(companion)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        return pp.load(path), [str(each.message) for each in caught]


def swapped(text, *pairs):
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return text


def _added(elements):
    return [("</robot>", f"{elements}</robot>")]


# ------------------------------------------------------------------------------------------------------------------------- leniency

PASSED = {  # edits, and what is warned of, or noted by `check`
    "origin in link": (
        [('<link name="rod_a">', '<link name="rod_a"><origin xyz="0 0 0" rpy="0 0 0"/>')],
        "an <origin> of a <link> is not read",
    ),
    "equal twice": ([('<axis xyz="0 -1 0"/>', '<axis xyz="0 -1 0"/><axis xyz="0 -1 0"/>')], None),
    "two of one axis": ([('ixx="5e-05" iyy="0.004004166667" izz="0.004004166667"', 'ixx="0" iyy="0.004" izz="0"')], "about two axes are 0"),
    "unlimited": (
        [('type="continuous"', 'type="revolute"'), ("</joint>", '<limit lower="-1e30" upper="1e16" effort="1" velocity="1"/></joint>')],
        None,
    ),
}


@pytest.mark.parametrize("case", PASSED)
def test_what_programs_write_without_meaning_is_passed_over(tmp_path, case):
    edits, said = PASSED[case]
    text = re.sub(r'<limit lower="0.4".*?/>', "", PLAIN).replace('type="revolute"', 'type="continuous"')
    press, warned = loaded(tmp_path, swapped(text, *edits))
    assert press.mobility == 2
    listed = [finding.problem for finding in pp.check(tmp_path / "robot.urdf").findings if finding.severity != "error"]
    assert said is None or any(said in problem for problem in listed)
    assert not [message for message in warned if "outside the limits" in message]


TURN = '<joint name="turn_a"/>'
REFUSED = [
    ([('<link name="rod_a">', '<link name="rod_a"><origin xyz="0 0 1"/>')], "xyz='0 0 1' of an <origin> in a <link> is read by no program"),
    ([('<axis xyz="0 -1 0"/>', '<axis xyz="0 -1 0" rpy="0 0 1"/>')], "rpy='0 0 1' of an <axis> in a <joint> is read by no program"),
    ([('<axis xyz="0 -1 0"/>', '<axis xyz="0 -1 0"/><axis xyz="0 1 0"/>')], "a second <axis> in one <joint>, which says something else"),
    ([('<joint name="turn_a"', '<joint independent="yes" name="turn_a"')], "independent='yes' is not true or false"),
    (_added('<ros2_control><joint name="turn_c"><command_interface/></joint></ros2_control>'), "no joint 'turn_c', did you mean"),
    (_added('<relation name="r"/>'), "names no <joint>"),
    (_added('<relation name="r"><joint name="turn_c"/></relation>'), "no joint 'turn_c', did you mean"),
    (_added(f'<relation name="r">{TURN}{TURN}</relation>'), "names a joint twice"),
    (_added(f'<relation name="r">{TURN}<joint name="knee_a" coefficient="0"/></relation>'), "coefficient is 0"),
    (_added('<relation name="r"><joint name="turn_a" coefficent="2"/></relation>'), "unknown attribute 'coefficent'"),
    (_added(2 * f'<relation name="r">{TURN}</relation>'), "the name is already that of the <relation>"),
    (
        _added(f'<relation name="r">{TURN}</relation><relation name="s">{TURN}</relation>'),
        "it determines joint 'turn_a', as does relation 'r'",
    ),
]


@pytest.mark.parametrize(("edits", "problem"), REFUSED)
def test_what_would_mean_something_is_refused(tmp_path, edits, problem):
    with pytest.raises(pp.UrdfError, match=re.escape(problem)) as caught:
        loaded(tmp_path, swapped(PLAIN, *edits))
    assert "\n" not in str(caught.value)
    assert caught.value.remedy


def test_moving_links_without_mass_are_named_once(tmp_path):
    _, warned = loaded(tmp_path, re.sub(r'(<link name="(?:rod|crank)_a">)<inertial>.*?</inertial>', r"\1", PLAIN))
    (said,) = [message for message in warned if "<inertial>" in message]
    assert '<link name="crank_a">: 2 links move without an <inertial>, as if of no mass: crank_a, rod_a;' in said


def test_a_linkage_without_any_mass_is_refused(tmp_path):
    with pytest.raises(pp.UrdfError, match="moves without a mass, as do all links that move with it"):
        loaded(tmp_path, re.sub(r"<inertial>.*?</inertial>", "", PLAIN))


def test_a_leaf_without_mass_is_refused(tmp_path):
    text = large_linkages.gear_train(1)
    with pytest.raises(pp.UrdfError, match="it moves on one bearing alone, but has no <inertial>"):
        loaded(tmp_path, text.replace(BODY, "", 1))
    rotor = BODY.replace('<mass value="1"/>', '<mass value="0"/>')
    press, _ = loaded(tmp_path, text.replace(BODY, rotor))
    motion = pp.servo_cycle(press, [0.3], speed=0.0, acceleration=[2.0])
    np.testing.assert_allclose(pp.inverse_dynamics(press, motion).driving_torque, 0.4, rtol=1e-14)  # two rotors of 0.1 kg m2 at 2 rad/s2


def test_a_root_beside_a_world_that_carries_nothing_floats(tmp_path):
    """A world that carries what moves does not: there a link has lost its joint."""
    floor = '<link name="floor"/><joint name="weld" type="fixed"><parent link="world"/><child link="floor"/></joint>'
    press, warned = loaded(tmp_path, PLAIN.replace('<link name="frame"/>', f'<link name="frame"/>{floor}'))
    assert (press.root, press.mobility) == ("world", 2)
    assert any("it leaves link 'frame' free; here it holds it" in message for message in warned)
    with pytest.raises(pp.UrdfError, match="there are 2 root links"):
        loaded(tmp_path, swapped(PLAIN, ('"frame"', '"world"'), ("</robot>", '<link name="lost"/></robot>')))


# -------------------------------------------------------------------------------------------------------------------------- companion

OPEN = (FOLDER / "09_companion_yaml_3d" / "robot.urdf").read_text()
WRONG = [
    ('closed_loop: [["end_a", "end_c"]]\ntype: ["3d"]', "robot.yaml:1: closed_loop: 1: 2: .* has no link 'end_c', did you mean 'end_"),
    ("closed_loop: [[end_a, end_b]]\ntype: [5d]", "robot.yaml:2: type: 1: unknown type of a loop '5d'; write 3d"),
    ("closed_loop: [[end_a, end_b]]\ntype: [3d, 3d]", "robot.yaml:2: type: closed_loop has 1 entries, and type has 2; write one of type"),
    ("closed_loop: [[end_a, end_b]]", "robot.yaml:1: closed_loop: there is no type; write type"),
    ("closed_loop: [[end_a]]\ntype: [3d]", "robot.yaml:1: closed_loop: 1: a loop joins 2 links, not 1"),
    ("closed_loop: end_a\ntype: 3d", "robot.yaml:1: closed_loop: 'end_a' is a text; write a list"),
    ("closed_loop: []\ntype: []\njoint_name: [knee]\njoint_type: [FIXED]", "joint_name: 1: .* has no joint 'knee', did you mean 'knee_a'"),
    ("closed_loop: []\ntype: []\njoint_name: [knee_a]\njoint_type: [UJOINT_XX]", "joint_type: 1: unknown type of a joint 'UJOINT_XX'"),
    ("closed_loop: []\ntype: []\njoint_name: [knee_a, knee_a]\njoint_type: [FIXED, FIXED]", "joint 'knee_a' stands there twice"),
    ("closed_loop: [[end_a, end_b]\ntype: [3d]", "robot.yaml:.*: it is no YAML"),
]


@pytest.mark.parametrize(("companion", "message"), WRONG)
def test_a_wrong_companion_is_refused_in_one_line(tmp_path, companion, message):
    with pytest.raises(pp.UrdfError, match=message) as caught:
        loaded(tmp_path, OPEN, companion)
    assert "\n" not in str(caught.value)
    assert caught.value.remedy


def test_drivers_of_a_companion_that_are_absent_are_warned_of(tmp_path):
    companion = "closed_loop: [[end_a, end_b]]\ntype: [3D]\nname_mot: [turn_a, turn_b, turn_c]\nname_mott: []"
    press, warned = loaded(tmp_path, OPEN, companion)
    assert (press.drivers, press.loops[0].name) == (("turn_a", "turn_b"), "end")
    assert ["name_mott: it is not read" in warned[0], "'turn_c' does not drive" in warned[1]] == [True, True]


def test_other_yaml_files_beside_a_urdf_are_left_alone(tmp_path):
    assert loaded(tmp_path, PLAIN, "pins: {A: 0 0}\nlinks: {crank: A B}")[0].mobility == 2


def test_joints_of_a_companion_turn_in_the_order_of_their_letters(tmp_path):
    """UJOINT_ZX: about z of the joint, then about x; SPHERICAL: any rotation; limits of hinges and zero limits of drivers are dropped."""
    text = f"""<robot name="r"><link name="base"/><link name="a">{BODY}</link><link name="b">{BODY}</link><link name="c">{BODY}</link>
      <joint name="j" type="revolute"><parent link="base"/><child link="a"/><origin xyz="0 0 1" rpy="0.2 0.3 0.4"/><axis xyz="0 1 0"/>
      <limit lower="0" upper="0.1" effort="1" velocity="1"/></joint>
      <joint name="k" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/></joint>
      <joint name="s" type="prismatic"><parent link="base"/><child link="c"/><axis xyz="0 1 0"/>
      <limit lower="0" upper="0" effort="1" velocity="1"/></joint></robot>"""
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    path.with_suffix(".yaml").write_text("closed_loop: []\ntype: []\nname_mot: [s]\njoint_name: [j, k]\njoint_type: [ujoint_zx, SPHERICAL]")
    document = parse(path)
    assert document.description.drivers == ("s",)
    model = pin.buildModelFromXML(document.text.decode())
    data, q = model.createData(), pin.neutral(model)
    for name, angle in {"j_Z": 0.5, "j_X": -0.7}.items():
        index = model.joints[model.getJointId(name)].idx_q
        q[index : index + 2] = np.cos(angle), np.sin(angle)
    pin.framesForwardKinematics(model, data, q)
    z, x = (pin.exp3(angle * np.array(axis)) for angle, axis in ((0.5, [0.0, 0.0, 1.0]), (-0.7, [1.0, 0.0, 0.0])))
    expected = pin.rpy.rpyToMatrix(0.2, 0.3, 0.4) @ z @ x
    np.testing.assert_allclose(data.oMf[model.getFrameId("a")].rotation, expected, atol=1e-15)
    assert {"k_x", "k_y", "k_z"} < set(model.names)
    slide = next(joint for joint in document.description.joints if joint.name == "s")
    assert slide.limits == (-1000.0, 1000.0)


# -------------------------------------------------------------------------------------------------------------- loops, gears, drivers


def test_closing_frames_turned_against_each_other_close_a_hinge(tmp_path):
    """About the line through both points of a side, whichever way its frame is turned."""
    text = (FOLDER / "08_closing_frames_hinge.urdf").read_text()
    turned = swapped(text, ('<origin xyz="0.29 0 0" rpy="-1.5707963267948966 0 0"/>', '<origin xyz="0.29 0 0" rpy="0.3 0.5 -0.2"/>'))
    press, _ = loaded(tmp_path, turned)
    assert (press.loops[0].type, press.loops[0].name) == ("revolute", "tip")
    for rotation in (press.loops[0].rotation1, press.loops[0].rotation2):
        np.testing.assert_allclose(rotation[:, 0], [0.0, 1.0, 0.0], atol=1e-15)


CHAINS = f"""<robot name="chains"><link name="base"/>
  <link name="a">{BODY}</link><link name="b">{BODY}</link><link name="c">{BODY}</link>
  <joint name="ja" type="continuous" independent="TRUE"><parent link="base"/><child link="a"/><axis xyz="0 -1 0"/></joint>
  <joint name="jb" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0.3 0 0"/><axis xyz="0 -1 0"/></joint>
  <joint name="jc" type="continuous" independent="true"><parent link="base"/><child link="c"/>
  <origin xyz="0 0.1 0"/><axis xyz="0 -1 0"/></joint>
  <coupling name="belt"><predecessor link="c"/><successor link="b"/><ratio value="3"/></coupling></robot>"""


def test_a_coupling_of_chains_against_pinocchio(tmp_path):
    """The angles of a and b add up to three times that of c: by the multiplier of this one equation."""
    press, _ = loaded(tmp_path, CHAINS)
    assert (press.drivers, press.mobility, press.couplings) == (("ja", "jc"), 2, ())
    at, speed, acceleration = np.array([0.4, -0.2]), np.array([1.5, 0.7]), np.array([-2.0, 3.0])
    joints = {name: press.joints.index(name) for name in ("ja", "jb", "jc")}
    q, v, a = (np.zeros(3) for _ in range(3))
    for values, drivers in ((q, at), (v, speed), (a, acceleration)):
        values[[joints["ja"], joints["jc"]]] = drivers
        values[joints["jb"]] = 3 * drivers[1] - drivers[0]
    data, turned = press.model.createData(), np.empty(press.model.nq)
    turned[0::2], turned[1::2] = np.cos(q), np.sin(q)
    free = pin.rnea(press.model, data, turned, v, a)
    multiplier = free[joints["jb"]]
    expected = [free[joints["ja"]] - multiplier, free[joints["jc"]] + 3 * multiplier]
    for engine in ("space", "pinocchio"):
        motion = pp.servo_cycle(press, [at], speed=[speed], acceleration=[acceleration], engine=engine)
        np.testing.assert_allclose(motion.joint_position[0], q, atol=1e-15)
        np.testing.assert_allclose(pp.inverse_dynamics(press, motion, engine=engine).driving_torque[0], expected, rtol=1e-12)


def test_relations_are_written_back(tmp_path):
    press, _ = loaded(tmp_path, CHAINS)
    (relation,) = press.relations
    changed = replace(relation, coefficients=dict(zip(relation.coefficients, (1.0, 0.7, -2.1), strict=True)), offset=0.25)
    again = pp.load(pp.write_urdf(replace(press, relations=(changed,)), tmp_path / "again.urdf"))
    assert (dict(again.relations[0].coefficients), again.relations[0].offset) == (dict(changed.coefficients), 0.25)
    assert pp.write_urdf(press, tmp_path / "same.urdf").read_bytes() == press.text


def test_a_relation_that_locks_is_named(tmp_path):
    """A third coupling of joints that the two others already tie together."""
    more = '<relation name="one"><joint name="jb"/><joint name="jc" coefficient="2"/></relation>'
    more += '<relation name="other"><joint name="ja"/><joint name="jc" coefficient="3"/></relation>'
    with pytest.raises(pp.PinpressError, match="nothing can move"):
        loaded(tmp_path, swapped(CHAINS, ("</robot>", f"{more}</robot>"), ('independent="TRUE"', "")))


def test_the_parts_of_a_split_ball_have_names_of_their_own(tmp_path):
    """In SDF, with a joint and a link that have the names which they would have."""
    text = (FOLDER / "25_empty_numbers.sdf").read_text()
    link = '<link name="{}"><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>'
    more = link.format("b_1") + link.format("arm")
    more += '<joint name="b" type="ball"><parent>world</parent><child>arm</child></joint>'
    more += '<joint name="b_x" type="revolute"><parent>world</parent><child>b_1</child><axis><xyz>0 1 0</xyz></axis></joint>'
    path = tmp_path / "robot.sdf"
    path.write_text(swapped(text, ("</model>", f"{more}</model>")))
    description = parse(path).description
    names = [joint.name for joint in description.joints]
    assert len(set(names)) == len(names)
    assert len(set(description.links)) == len(description.links)
    assert {"b_x", "b_x_2", "b_y", "b_z"} <= set(names)


@pytest.mark.parametrize("lower", ["-1e30", "-1e16"])
def test_limits_that_are_none_do_not_lead_away_from_home(tmp_path, lower):
    """An open drawing of which one joint has no lower limit, as it is written where there is none, closes as without limits."""
    text = (FOLDER / "14_open_pose.urdf").read_text()
    limited = re.sub(
        r'(<joint name="knee_a" type=)"continuous"(.*?)</joint>',
        rf'\1"revolute"\2<limit lower="{lower}" upper="1.5" effort="1" velocity="1"/></joint>',
        text,
    )
    assert limited != text
    (free, _), (press, _) = loaded(tmp_path, text), loaded(tmp_path, limited)
    np.testing.assert_allclose(press.closed, free.closed, atol=1e-12)
    assert pp.check(tmp_path / "robot.urdf").errors == ()
