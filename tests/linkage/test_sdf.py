"""SDF: poses, axes, frames, the choice of the tree, gearboxes; what is refused, each by its name and line; and the loops of Drake in it."""

import re
import warnings
from importlib.metadata import files
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.oracles import cassie

import pinpress as pp
from pinpress.common.errors import PinpressWarning, UrdfError
from pinpress.linkage.formats.free_bodies import with_base
from pinpress.linkage.formats.mechanism import Edge, spanning_tree
from pinpress.linkage.loading import build, parse

MODEL = """<sdf version="{version}">
  <model name="slider">
    {pose}
    <link name="frame"/>
    <link name="crank">
      <pose>0 0 0.4 0 0.3 0</pose>
      <inertial><pose>0.03 0 0 0 0 0.1</pose><mass>20</mass><inertia><ixx>0.05</ixx><iyy>0.1</iyy><izz>0.06</izz></inertia></inertial>
    </link>
    <link name="rod">
      <pose>0.1 0 0.3 0 0.9 0</pose>
      <inertial><mass>15</mass><inertia><ixx>0.01</ixx><iyy>0.2</iyy><izz>0.2</izz></inertia></inertial>
    </link>
    <link name="slide">
      <pose>0.2 0 0 0 0 0</pose>
      <inertial><mass>100</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>
    </link>
    <joint name="O" type="revolute"><parent>frame</parent><child>crank</child><pose>0.01 0 0.02 0 0 0</pose>{axis}</joint>
    <joint name="P" type="revolute"><parent>crank</parent><child>rod</child><axis><xyz>0 -1 0</xyz></axis></joint>
    <joint name="slide_guide" type="prismatic"><parent>frame</parent><child>slide</child><axis><xyz>0 0 1</xyz></axis></joint>
    <joint name="W" type="revolute"><parent>rod</parent><child>slide</child><axis><xyz>0 -1 0</xyz></axis></joint>
    {more}
  </model>
</sdf>
"""
AXIS = "<axis><xyz>0 -1 0</xyz></axis>"


def file(version="1.9", pose="", axis=AXIS, more="", edit=("", "")):
    return texts.file(MODEL.format(version=version, pose=pose, axis=axis, more=more).replace(*edit), "slider.sdf")


def robot(**of):
    return parse(file(**of)).robot


def gearbox(parent, child, reference, ratio, axis="0 -1 0", of="gear"):
    """A gearbox whose parent turns about an axis, and its child about -y."""
    ends = f"<parent>{parent}</parent><child>{child}</child><gearbox_ratio>{ratio!r}</gearbox_ratio>"
    axes = f"<axis><xyz>{axis}</xyz></axis><axis2><xyz>0 -1 0</xyz></axis2>"
    return f'<joint name="{of}" type="gearbox">{ends}<gearbox_reference_body>{reference}</gearbox_reference_body>{axes}</joint>'


def bushing(frame, torque, force, damping="0 0 0"):
    """An elastic bushing of Drake between a frame and the slide."""
    values = {"torque_stiffness": torque, "torque_damping": damping, "force_stiffness": force, "force_damping": damping}
    inside = "".join(f"<drake:bushing_{name}>{value}</drake:bushing_{name}>" for name, value in values.items())
    ends = f"<drake:bushing_frameA>{frame}</drake:bushing_frameA><drake:bushing_frameC>slide</drake:bushing_frameC>"
    return f"<drake:linear_bushing_rpy>{ends}{inside}</drake:linear_bushing_rpy>"


def joint(robot, name):
    return next(each for each in robot.all("joint") if each.get("name") == name)


def axis(robot, name):
    return joint(robot, name).all("axis")[0].numbers("xyz")


def test_the_crank_slide_of_an_sdf_moves():
    with pytest.warns(PinpressWarning) as said:
        press = pp.load(file(), driver="O")
    assert [re.sub(r"^\S* ", "", str(each.message)).split(",")[0].split(";")[0] for each in said] == [
        "<link name=\"frame\">: no joint connects the model to the world: link 'frame' is held where it is drawn",
        '<joint name="O">: it turns only from -102.496 to 210.401 deg',
    ]
    assert (press.name, press.slide, press.bearings) == ("slider", "slide", ("O", "P", "slide_guide", "W"))
    assert [(loop.name, loop.type) for loop in press.loops] == [("W", "revolute")]
    model, data = press.model, press.model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    assert data.oMf[model.getFrameId("crank", pin.BODY)].translation == pytest.approx(
        pin.rpy.rpyToMatrix(0, 0.3, 0) @ [0.01, 0, 0.02] + [0, 0, 0.4], abs=1e-15
    )  # of the joint
    centre = data.oMi[1].act(model.inertias[1].lever)
    assert centre == pytest.approx(pin.rpy.rpyToMatrix(0, 0.3, 0) @ [0.03, 0, 0] + [0, 0, 0.4], abs=1e-15)
    moved = pp.servo_cycle(press, np.linspace(-0.5, 0.5, 5), speed=1.0)
    assert moved.closure_error.max() < 1e-12


@pytest.mark.parametrize(
    ("version", "written", "expected"),
    [
        ("1.9", "<xyz>0 -2 0</xyz>", (0, -1, 0)),
        ("1.9", '<xyz expressed_in="__model__">1 0 0</xyz>', pin.rpy.rpyToMatrix(0, 0.3, 0).T @ [1, 0, 0]),
        ("1.9", '<xyz expressed_in="rod">1 0 0</xyz>', pin.rpy.rpyToMatrix(0, 0.6, 0) @ [1, 0, 0]),
        ("1.6", "<xyz>1 0 0</xyz>", (1, 0, 0)),
        ("1.6", "<xyz>1 0 0</xyz><use_parent_model_frame>1</use_parent_model_frame>", pin.rpy.rpyToMatrix(0, 0.3, 0).T @ [1, 0, 0]),
        ("1.4", "<xyz>1 0 0</xyz>", pin.rpy.rpyToMatrix(0, 0.3, 0).T @ [1, 0, 0]),
        ("1.6", "", (0, 0, 1)),
    ],
)
def test_an_axis_is_in_the_frame_that_its_version_says(version, written, expected):
    assert axis(robot(version=version, axis=f"<axis>{written}</axis>"), "O") == pytest.approx(tuple(expected), abs=1e-15)


@pytest.mark.parametrize(
    "pose",
    [
        '<pose relative_to="held">0.1 0 0 0 0 0</pose>',
        '<pose relative_to="crank" degrees="true">-0.1 0 0.4 0 -17.188733853924695 0</pose>',
        '<pose rotation_format="quat_xyzw">0.2 0 0 0 0 0 2</pose>',
    ],
)
def test_a_pose_is_relative_to_the_frame_that_it_names(pose):
    more = '<frame name="held" attached_to="frame"><pose relative_to="__model__">0.1 0 0 0 0 0</pose></frame>'
    press = build(parse(file(more=more, edit=("<pose>0.2 0 0 0 0 0</pose>", pose))), "O", None)
    place = press.model.jointPlacements[press.model.getJointId("slide_guide")]
    expected = pin.rpy.rpyToMatrix(0, 0.3, 0) @ [-0.1, 0, 0.4] + [0, 0, 0.4] if "crank" in pose else [0.2, 0, 0]
    assert place.translation == pytest.approx(expected, abs=1e-15)
    assert np.abs(place.rotation - np.eye(3)).max() < 1e-15


def test_the_model_stands_in_the_world_where_it_is_posed():
    press = build(with_base(parse(file(pose="<pose>1 2 3 0 0 1.5708</pose>")), "fixed"), "O", None)
    place = press.model.jointPlacements[1]
    assert place.translation == pytest.approx(
        [1, 2 + 0.01 * np.cos(0.3) + 0.02 * np.sin(0.3), 3.4 + 0.02 * np.cos(0.3) - 0.01 * np.sin(0.3)]
    )
    assert press.root == "world"


def test_the_pose_of_a_model_is_that_of_its_placement_frame():
    """The slide, which the file draws at x = 0.2 of the model, stands where the model's pose is, a quarter turn about z."""
    named = ('<model name="slider">', '<model name="slider" placement_frame="slide">')
    press = build(parse(file(pose="<pose>1 2 3 0 0 1.5708</pose>", edit=named)), "O", None)
    model, data = press.model, press.model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    place = data.oMf[model.getFrameId("slide", pin.BODY)]
    np.testing.assert_allclose(place.translation, [1, 2, 3], atol=1e-14)
    np.testing.assert_allclose(place.rotation, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-14)


@pytest.mark.parametrize(
    ("word", "quarter"), [("1.5708", True), ("-3.14159", True), ("1.571", False), ("1.5709", False), ("1.570796", True)]
)
def test_an_angle_that_is_a_quarter_turn_to_all_its_digits_is_read_as_one(word, quarter):
    document = parse(file(edit=("<pose>0.2 0 0 0 0 0</pose>", f"<pose>0.2 0 0 0 0 {word}</pose>")))
    rotation = build(document, "O", None).model.jointPlacements[3].rotation
    off = np.abs(np.abs(rotation) - np.round(np.abs(rotation))).max()
    assert (off < 1e-15) == quarter
    assert any("quarter turns" in remark.problem for remark in document.remarks) == quarter


def test_a_gearbox_is_a_gear_pair_with_the_sign_of_its_axes():
    more = """<link name="wheel"><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>
    <joint name="S" type="revolute"><parent>frame</parent><child>wheel</child><axis><xyz>0 1 0</xyz></axis></joint>
    <joint name="gear" type="gearbox"><parent>crank</parent><child>wheel</child><gearbox_ratio>2.5</gearbox_ratio>
      <gearbox_reference_body>frame</gearbox_reference_body><axis><xyz>0 -1 0</xyz></axis><axis2><xyz>0 -1 0</xyz></axis2></joint>"""
    (mimic,) = joint(robot(more=more), "S").all("mimic")
    assert (mimic.get("joint"), mimic.numbers("multiplier")) == ("O", (2.5,))  # theta2 = -2.5 theta1 about -y, and S turns about +y
    mimicked = more.replace(
        "<xyz>0 1 0</xyz>", '<xyz>0 1 0</xyz><mimic joint="O"><multiplier>-2</multiplier><reference>0.1</reference></mimic>'
    )
    mimicked = re.sub('<joint name="gear".*</joint>', "", mimicked, flags=re.DOTALL)
    (mimic,) = joint(robot(more=mimicked), "S").all("mimic")
    assert mimic.numbers("multiplier") + mimic.numbers("offset") == (-2, 0.2)


INERTIAL = "<inertial><mass>1</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>"
WHEEL = f"""<link name="{{0}}"><pose>{{1}} 0 0 0 0 0</pose>{INERTIAL}</link>
    <joint name="{{2}}" type="revolute"><parent>{{3}}</parent><child>{{0}}</child><axis><xyz>0 {{4}} 0</xyz></axis></joint>"""


@pytest.mark.parametrize(("sun", "planet"), [(-1, -1), (1, -1), (-1, 1)])
def test_a_gearbox_in_a_moving_body_is_a_relation_of_the_joints_between(sun, planet):
    """A planetary whose arm carries the planet: teeth 20, 30 and 80, so that the sun turns five times as fast as the arm (Willis)."""
    links = (
        WHEEL.format("arm", 0, "A", "world", -1)
        + WHEEL.format("sun", 0, "S", "world", sun)
        + WHEEL.format("planet", 0.25, "P", "arm", planet)
    )
    gears = gearbox("sun", "planet", "arm", 20 / 30, of="sun_planet") + gearbox("planet", "world", "arm", -30 / 80, of="ring")
    text = f'<sdf version="1.9"><model name="planetary">{links}{gears}</model></sdf>'
    press = pp.load(texts.file(text, "planetary.sdf"), "S")
    angles = np.linspace(0.0, 2.0, 5)
    motion = pp.servo_cycle(press, angles, speed=1.0, acceleration=0.0)
    turned = dict(zip(press.joints, motion.joint_position.T, strict=True))
    np.testing.assert_allclose(turned["A"], -sun * angles / 5, atol=1e-14)
    np.testing.assert_allclose(-planet * turned["P"] + turned["A"], sun * angles / 3, atol=1e-14)  # of the planet, absolute
    with pytest.raises(pp.PinpressError, match="SDF has no element for relation 'sun_planet'"):
        pp.write_sdf(press, texts.file("", "planetary.sdf"))


@pytest.mark.parametrize(("pitch", "rise"), [("screw_thread_pitch>0.2</screw_", 0.2), ("screw_thread_pitch>-0.2</screw_", -0.2)])
def test_a_screw_joint_turns_and_slides(pitch, rise):
    """A right-handed screw goes along its axis where it turns about it; thread_pitch counts -2 pi radians by lead."""
    screw = """<link name="spindle"><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>
    <joint name="S" type="screw"><parent>world</parent><child>spindle</child><{}thread_pitch><axis><xyz>0 0 1</xyz></axis></joint>"""
    classic = f"thread_pitch>{-2 * np.pi / rise!r}</"
    for said in (pitch, classic):
        text = f'<sdf version="1.9"><model name="screw">{screw.format(said)}</model></sdf>'
        press = pp.load(texts.file(text, "screw.sdf"), "S")
        motion = pp.servo_cycle(press, [0.0, 2 * np.pi], speed=1.0, acceleration=0.0)
        assert press.joints == ("S", "S_slide")
        np.testing.assert_allclose(motion.joint_position[:, 1], [0.0, rise], atol=1e-15)


def test_loops_of_drake_in_an_sdf_are_read():
    loop = MODEL[MODEL.index('    <joint name="W"') : MODEL.index("    {more}")]
    ball = """<drake:ball_constraint><drake:ball_constraint_body_A>rod</drake:ball_constraint_body_A>
      <drake:ball_constraint_p_AP>0.1 0 0.2</drake:ball_constraint_p_AP><drake:ball_constraint_body_B>slide</drake:ball_constraint_body_B>
      <drake:ball_constraint_p_BQ>0 0 0.01</drake:ball_constraint_p_BQ></drake:ball_constraint>"""
    (loop1,) = parse(file(edit=(loop, ball))).robot.all("loop_joint")
    assert (loop1.get("name"), loop1.get("type")) == ("ball_rod_slide", "spherical")
    assert [end.numbers("xyz") for end in loop1.children] == [(0.1, 0, 0.2), (0, 0, 0.01)]
    at = '<frame name="at" attached_to="rod"><pose>0.1 0 0.2 0 0 0</pose></frame>'
    document = parse(file(edit=(loop, at + bushing("at", "1e4 0 1e4", "1e6 1e6 1e6", "1 0 1"))))
    (loop2,) = document.robot.all("loop_joint")
    assert (loop2.get("type"), loop2.all("axis")[0].numbers("xyz")) == ("revolute", (0, 1, 0))
    assert [remark.severity for remark in document.remarks if "rigid bearing" in remark.problem] == ["warning"]


def test_a_joint_that_the_tree_takes_the_other_way_round_keeps_its_angle():
    more = '<joint name="weld" type="fixed"><parent>world</parent><child>slide</child></joint>'
    other = "<parent>frame</parent><child>slide</child>"
    document = parse(file(more=more, edit=(other, other)))
    guide = joint(document.robot, "slide_guide")
    assert (guide.all("parent")[0].get("link"), axis(document.robot, "slide_guide")) == ("slide", (0, 0, -1))
    assert any("exchange <parent> and <child>" in remark.remedy for remark in document.remarks)


def test_a_ball_joint_of_the_tree_is_three_revolute_joints():
    found = robot(edit=('<joint name="P" type="revolute"', '<joint name="P" type="ball"'))
    loops = [loop.get("name") for loop in found.all("loop_joint")]
    assert loops == ["P"]  # where another joint can carry the rod, that does
    assert [end.get("link") for end in joint(found, "W").all("parent", "child")] == ["slide", "rod"]
    loop = MODEL[MODEL.index('    <joint name="W"') : MODEL.index("    {more}")]
    ball = '<joint name="W" type="ball"><parent>world</parent><child>frame</child></joint>'
    found = robot(edit=(loop, ball))
    assert [each.get("name") for each in found.all("joint")][-3:] == ["W_x", "W_y", "W_z"]
    massless = [link for link in found.all("link") if link.get("name").startswith("W_")]
    assert [link.all("inertial")[0].all("mass")[0].numbers("value") for link in massless] == [(0.0,), (0.0,)]


SLIDE = "<pose>0.2 0 0 0 0 0</pose>"
REFUSED = [
    ({"version": "2.0"}, r":1: <sdf>: unknown version '2.0' of SDF"),
    ({"edit": ('"O" type="revolute"', '"O" type="planar"')}, r':17: <joint name="O">: joint type \'planar\' cannot be read'),
    ({"edit": ('"O" type="revolute"', '"O" type="screw"')}, r':17: <joint name="O">: has no pitch; write <screw_thread_pitch>'),
    ({"more": gearbox("crank", "rod", "frame", 2.0, "1 0 0")}, r':21: <joint name="gear">: its axis is not along that of joint \'O\''),
    ({"more": gearbox("crank", "frame", "frame", 2.0)}, "no turn of 'crank' or 'frame' against 'frame' is left for it to determine"),
    ({"edit": ('"O" type="revolute"', '"O" type="revolut"')}, "did you mean 'revolute'"),
    ({"axis": "<axxis/>"}, r":17: <axxis> of <joint name=.O.>: unknown element <axxis>, did you mean 'axis'"),
    (
        {"edit": (SLIDE, '<pose relatve_to="rod">0 0 0 0 0 0</pose>')},
        r":14: <pose> of <link name=.slide.>: unknown attribute 'relatve_to', did you mean 'relative_to'",
    ),
    ({"axis": '<axis xyz="0 -1 0"/>'}, r":17: <axis> of <joint name=.O.>: unknown attribute 'xyz'; remove it"),
    ({"edit": ("<ixx>0.05</ixx>", "<Ixx>0.05</Ixx>")}, "unknown element <Ixx>"),
    ({"edit": ("<mass>15</mass>", "")}, r':11: <inertial> of <link name="rod">: has no <mass>'),
    ({"edit": ("<mass>15</mass>", "<mass>1,5</mass>")}, r"<mass> of <link name=.rod.>: '1,5' is not a finite number"),
    ({"edit": ("<mass>15</mass>", "<mass>-15</mass>")}, r':11: <inertial> of <link name="rod">: the mass -15.0'),
    ({"edit": ("<ixx>1</ixx>", "<ixx>5</ixx>")}, r':15: <inertial> of <link name="slide">: the largest principal'),
    ({"axis": "<axis><xyz>0 0 0</xyz></axis>"}, "the axis is zero"),
    ({"axis": "<axis><xyz>0 1</xyz></axis>"}, "2 numbers, not 3"),
    ({"edit": ("<child>rod</child>", "<child>rot</child>")}, "no frame 'rot', did you mean 'rod'|no link 'rot'"),
    ({"edit": (SLIDE, '<pose relative_to="slide">0 0 0 0 0 0</pose>')}, "relative to itself"),
    ({"edit": (SLIDE, '<pose relative_to="x">0 0 0 0 0 0</pose>')}, "no frame 'x'"),
    ({"pose": '<pose relative_to="table">0 0 1 0 0 0</pose>'}, "the pose of the model is relative to 'table'"),
    (
        {"edit": ('<model name="slider">', '<model name="slider" placement_frame="w">'), "more": '<frame name="w" attached_to="world"/>'},
        ":2: <model name=.slider.>: its placement_frame 'w' stands in the world",
    ),
    ({"edit": (SLIDE, '<pose frame="rod">0 0 0 0 0 0</pose>')}, "frame=... of SDF 1.5 and 1.6"),
    ({"more": "<include><uri>model://x</uri></include>"}, ":21: <include> of <model name=.slider.>: <include> in a <model>"),
    ({"more": '<model name="inner"/>'}, ':21: <model name="inner">: <model> in a <model> cannot be read'),
    ({"more": "<static>1</static>"}, "a static model does not move|no models that move"),
    ({"more": '<link name="apart"/>'}, ':21: <link name="apart">: no joint connects it'),
    ({"more": '<link name="rod"/>'}, "the name is already that of the <link> on line 9"),
    (
        {"more": '<joint name="X" type="prismatic"><parent>frame</parent><child>slide</child><axis/></joint>'},
        r'<joint name="X">: a prismatic joint cannot close a loop here',
    ),
    ({"edit": (SLIDE, "<gravity>0</gravity>")}, "gravity acts on all links or none"),
    ({"more": '<drake:joint name="x"/>'}, '<drake:joint name="x">: cannot be read'),
    (
        {"more": bushing("rod", "1 0 0", "1 1 1")},
        "a bushing is elastic, and this one is neither a pin",
    ),
]


@pytest.mark.parametrize(("changed", "message"), REFUSED)
def test_what_is_no_linkage_is_refused_by_name_and_line(changed, message):
    with pytest.raises(UrdfError, match=message):
        pp.load(file(**changed), driver="O")
    assert pp.check(file(**changed), driver="O").errors


@pytest.mark.parametrize(
    ("each", "count", "message"),
    [
        ('<frame name="f{}"/>', 1001, "there are 1001 <frame>, more than 1000"),
        ('<frame name="f{}" attached_to="f{next}"/>', 999, "its pose is more than 500 frames away"),
    ],
)
def test_a_file_that_is_too_large_is_refused(each, count, message):
    more = "".join(each.format(k, next=k + 1) for k in range(count)) + f'<frame name="f{count}"/>'
    guide = '<joint name="slide_guide" type="prismatic">'
    with pytest.raises(UrdfError, match=message):
        parse(file(more=more.replace('<frame name="f1001"/>', ""), edit=(guide, guide + '<pose relative_to="f0"/>')))


def test_a_spanning_tree_takes_joints_as_they_are_written_where_it_can():
    edges = [Edge("a", "b", 0), Edge("c", "b", 0), Edge("a", "d", 0), Edge("d", "c", 0)]
    assert spanning_tree("a", "abcd", edges) == ({0: "b", 2: "d", 3: "c"}, ())
    assert spanning_tree("a", "abcd", edges[:2]) == ({0: "b", 1: "c"}, ("d",))  # c hangs by a joint of which it is the parent
    assert spanning_tree("a", "abc", [Edge("a", "b", 1), Edge("c", "b", 0), Edge("a", "c", 2)]).tree == {0: "b", 1: "c"}


def test_an_inertial_may_name_the_frame_of_its_own_link_only(tmp_path):
    path = pp.write_sdf(pp.load("crank_slide"), tmp_path / "press.sdf")
    text, pose = path.read_text(encoding="utf-8"), r'(<link name="rod">.*?<inertial>\s*<pose)'
    path.write_text(re.sub(pose, r'\1 relative_to="rod"', text, count=1, flags=re.DOTALL), encoding="utf-8")
    assert 'relative_to="rod"' in path.read_text(encoding="utf-8")
    mass = [inertia.toDynamicParameters() for inertia in pp.load(path).model.inertias]
    path.write_text(text, encoding="utf-8")
    np.testing.assert_array_equal(mass, [inertia.toDynamicParameters() for inertia in pp.load(path).model.inertias])
    path.write_text(re.sub(pose, r'\1 relative_to="crank"', text, count=1, flags=re.DOTALL), encoding="utf-8")
    with pytest.raises(UrdfError, match="the pose of an <inertial> is in the frame of its link"):
        pp.load(path)


# ------------------------------------------------------------------------------------------------------------------------- public robots

CASSIE = [f"{side}-{joint}" for side in ("left", "right") for joint in (*cassie.MOTORS, "knee-shin-joint")]
ROBOTS = {  # the files of example-robot-data with loops: mobility and passive joints where they load, else why they do not
    "cassie_v2.sdf": (12, ()),
    "cassie_simple.sdf": (11, ("static",)),  # a slide on the frame that carries the robot
    "cassie_reduced.sdf": (11, ("static",)),
    "cassie_wo_gearbox_spring.sdf": (13, ("static",)),
    "cassie.sdf": '<link name="left-foot-reference">: the largest principal moment of inertia exceeds the sum',
    "cassie.world": "is not well-formed XML",
}


def shipped(name):
    return next(path.locate() for path in files("example-robot-data") if path.name == name)


@pytest.mark.parametrize("name", ROBOTS)
def test_robots_with_loops_load_or_are_refused_in_words(name):
    found = ROBOTS[name]
    if isinstance(found, str):
        with pytest.raises(UrdfError, match=re.escape(found)):
            pp.load(shipped(name), driver=CASSIE)
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PinpressWarning)
        press = pp.load(shipped(name), driver=CASSIE)
    assert (press.mobility, press.passive) == found
    assert (len(press.loops), len(press.joint_springs)) == (4, 4)


@pytest.mark.exhaustive
def test_no_other_robot_of_the_package_has_loops():
    every = [path for path in files("example-robot-data") if path.suffix in (".urdf", ".sdf", ".world")]
    assert len(every) > 50
    assert {path.name for path in every if path.suffix != ".urdf"} == {*ROBOTS}
    for path in every:
        if path.suffix == ".urdf":
            assert not parse(path.locate()).robot.all("loop_joint")


def test_cassie_weighs_and_is_placed_as_an_independent_reader_has_it(tmp_path):
    """The oracle draws another pose: what both share is the mass of every link, and its place where joints are as in the SDF."""
    document = with_base(parse(shipped("cassie_v2.sdf")), "fixed")
    ours, theirs = pin.buildModelFromXML(document.text.decode()), pin.buildModelFromXML(cassie.urdf())
    assert {*theirs.names} == {*ours.names}
    data, other = ours.createData(), theirs.createData()
    q = pin.neutral(theirs)
    for name in list(theirs.names)[1:]:  # back from its drawn pose to that of the SDF
        slot = theirs.joints[theirs.getJointId(name)]
        q[slot.idx_q : slot.idx_q + 2] = np.cos(-cassie.drawn(name)), np.sin(-cassie.drawn(name))
    pin.forwardKinematics(ours, data, pin.neutral(ours))
    pin.forwardKinematics(theirs, other, q)
    held = pin.SE3(np.eye(3), np.array([0.0, 0.0, 1.01]))  # the pelvis, which is the oracle's world
    for name in list(ours.names)[1:]:
        j, k = ours.getJointId(name), theirs.getJointId(name)
        assert ours.inertias[j].mass == theirs.inertias[k].mass
        one, two = data.oMi[j].act(ours.inertias[j].lever), held.act(other.oMi[k].act(theirs.inertias[k].lever))
        assert one == pytest.approx(two, abs=1e-12), name


def test_the_manual_names_the_robots_that_load():
    manual = (Path(__file__).parents[2] / "docs" / "describe.md").read_text(encoding="utf-8")
    loads = [name for name, found in ROBOTS.items() if not isinstance(found, str)]
    assert [name for name in ROBOTS if f"`{name}`" in manual] == loads


BODY = '<link name="{}"><inertial><mass>2</mass><inertia><ixx>.02</ixx><iyy>.02</iyy><izz>.02</izz></inertia></inertial></link>'
HINGE = '<joint name="{}" type="{}"><parent>{}</parent><child>{}</child><axis><xyz>0 1 0</xyz><limit>{}</limit></axis></joint>'


def arm(*elements, driver):
    text = f'<sdf version="1.9"><model name="arm">{"".join(elements)}</model></sdf>'
    return texts.load(text, name="arm.sdf", driver=driver)


@pytest.mark.parametrize("none", ["1e16", "1e+16", "inf", "1.79769e+308", "1e13"])
def test_limits_beyond_all_numbers_are_none(none):
    """SDF's own words for no limit, and what programs write for it; ``effort`` and ``velocity`` too."""
    limits = f"<lower>-{none}</lower><upper>{{}}</upper><effort>{none}</effort><velocity>{none}</velocity>"
    joints = HINGE.format("A", "revolute", "world", "crank", limits.format(none))
    joints += HINGE.format("B", "prismatic", "crank", "arm", limits.format("0.5"))
    press = arm(BODY.format("crank"), BODY.format("arm"), joints, driver=("A", "B"))
    assert press.slots[0].unbounded
    assert press.model.upperPositionLimit[press.slots[1].start] == 0.5
    assert press.model.lowerPositionLimit[press.slots[1].start] <= -1e9


@pytest.mark.parametrize(("tag", "text"), [("lower", "1e16"), ("lower", "inf"), ("upper", "-inf"), ("upper", "nan")])
def test_limits_that_leave_no_way_are_refused(tag, text):
    joint = HINGE.format("A", "revolute", "world", "crank", f"<{tag}>{text}</{tag}>")
    with pytest.raises(pp.PinpressError, match=f"<{tag}> of <joint name=.A.>"):
        arm(BODY.format("crank"), joint, driver="A")
