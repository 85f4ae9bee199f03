"""The URDF reader: every check has a file that breaks just it."""

import re
from pathlib import Path

import pinocchio
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from pinpress import urdf
from pinpress.errors import UrdfError

SHIPPED = Path(__file__).parent.parent / "urdf"

VALID = """<?xml version="1.0"?>
<robot name="press">
  <material name="steel"><color rgba="0.5 0.5 0.5 1"/></material>
  <link name="frame">
    <visual><geometry><box size="1 1 0.1"/></geometry><material name="steel"/></visual>
  </link>
  <link name="crank">
    <inertial><origin xyz="0.03 0 0"/><mass value="20"/><inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="1"/></inertial>
  </link>
  <link name="rod">
    <inertial><mass value="15"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="2" iyz="0" izz="2"/></inertial>
  </link>
  <link name="slide">
    <inertial><mass value="100"/><inertia ixx="3" ixy="0" ixz="0" iyy="3" iyz="0" izz="3"/></inertial>
  </link>
  <joint name="O" type="continuous"><parent link="frame"/><child link="crank"/><axis xyz="0 -1 0"/></joint>
  <joint name="P" type="revolute">
    <parent link="crank"/><child link="rod"/><origin xyz="0.1 0 0"/><axis xyz="0 -1 0"/>
    <limit lower="-4" upper="4" effort="1e6" velocity="50"/>
  </joint>
  <joint name="guide" type="prismatic">
    <parent link="frame"/><child link="slide"/><origin xyz="0 0 -0.5"/><axis xyz="0 0 1"/>
    <limit lower="-0.1" upper="0.3" effort="1e6" velocity="20"/>
  </joint>
  <loop_joint name="W" type="spherical"><link1 link="rod" xyz="0.4 0 0"/><link2 link="slide" rpy="0 0.5 0"/></loop_joint>
  <transmission name="drive"><joint name="O"/><actuator name="motor"/></transmission>
</robot>
"""
CRANK_MASS, CRANK, ROD, LINE_O, LINE_P, GUIDE, LINE_W, DRIVE = 8, 7, 10, 16, 17, 21, 25, 26  # lines in VALID
END = len(VALID.splitlines())  # line of </robot>, where added elements go

INERTIAL = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
CRANK_INERTIAL = VALID.splitlines()[CRANK_MASS - 1]
CRANK_INERTIA = 'ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="1"'
P_LIMIT = '<limit lower="-4" upper="4" effort="1e6" velocity="50"/>'
BOX = '<geometry><box size="1 1 0.1"/></geometry>'


def edited(*edits: tuple[str, str]) -> str:
    """VALID with texts replaced at their first place, where each must occur."""
    text = VALID
    for old, new in edits:
        assert old in text
        text = text.replace(old, new, 1)
    return text


def added(element: str) -> str:
    return edited(("</robot>", element + "</robot>"))


def in_joint(name: str, element: str) -> str:
    return re.sub(rf'(<joint name="{name}".*?)(</joint>)', lambda match: match[1] + element + match[2], VALID, count=1, flags=re.DOTALL)


def welded(link: str, parent: str, content: str) -> str:
    joint = f'<joint name="weld" type="fixed"><parent link="{parent}"/><child link="{link}"/></joint>'
    return added(f'<link name="{link}">{content}</link>{joint}')


@pytest.fixture
def file(tmp_path):
    return tmp_path / "press.urdf"


def first_problem(file: Path, text: str | bytes) -> UrdfError:
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(UrdfError) as caught:
        urdf.read(file)
    assert caught.value.file == str(file)
    assert caught.value.remedy
    return caught.value


def test_valid_file(file):
    file.write_text(VALID)
    assert urdf.read(file) == urdf.Urdf(
        file=str(file),
        text=VALID.encode(),
        name="press",
        root="frame",
        links=("frame", "crank", "rod", "slide"),
        joints=(
            urdf.Joint("O", "continuous", "frame", "crank", LINE_O),
            urdf.Joint("P", "revolute", "crank", "rod", LINE_P),
            urdf.Joint("guide", "prismatic", "frame", "slide", GUIDE),
        ),
        loops=(
            urdf.Loop("W", "spherical", urdf.LoopEnd("rod", (0.4, 0, 0), (0, 0, 0)), urdf.LoopEnd("slide", (0, 0, 0), (0, 0.5, 0)), LINE_W),
        ),
        drivers=("O",),
    )
    assert list(urdf.problems(file)) == []


@pytest.mark.parametrize(
    ("name", "loops", "driver"),
    [("crank_slide", ["W"], "O"), ("zxn2_3000b", ["C", "F"], "A"), ("zxn2_3000b_balanced", ["C", "F"], "A")],
)
def test_shipped_files(name, loops, driver):
    press = urdf.read(SHIPPED / f"{name}.urdf")
    assert press.name == name
    assert press.root == "frame"
    assert [loop.name for loop in press.loops] == loops
    assert press.drivers == (driver,)


XACRO = '<robot name="press" xmlns:xacro="http://www.ros.org/wiki/xacro">'


@pytest.mark.parametrize(
    ("text", "element", "line", "problem"),
    [
        (b"", None, None, "is empty"),
        (b" \n\n", None, None, "is empty"),
        (VALID.encode("utf-16"), None, 1, "not UTF-8"),
        (b"<robot>\n\xff</robot>", None, 2, "not UTF-8"),
        (VALID[:-20], None, DRIVE, "not well-formed XML"),
        (edited(('<link name="rod">', '<link name="rod>')), None, 11, "not well-formed XML"),
        (VALID + "<robot/>", None, END + 1, "not well-formed XML"),
        ('<mujoco model="press"/>', "<mujoco>", 1, "root element is not <robot>"),
        ('<!DOCTYPE robot [<!ENTITY m "20">]>' + VALID[22:], None, 1, "document type declaration"),
        (edited(('<robot name="press">', XACRO + '<xacro:property name="r" value="1"/>')), '<xacro:property name="r">', 2, "is xacro"),
        (added("<?tool x?>"), None, END, "processing instruction"),
        (VALID.replace("<robot", "<?xml-model href='urdf.rng'?><robot"), None, 2, "processing instruction"),
        (added("<xacro:x/>"), "<xacro:x>", END, "is xacro"),
        (added("<gazebo>" + "<a>" * 500 + "</a>" * 500 + "</gazebo>"), "<a> of <gazebo>", END, "is nested too deeply"),
    ],
)
def test_file_as_a_whole(file, text, element, line, problem):
    error = first_problem(file, text)
    assert (error.element, error.line) == (element, line)
    assert problem in error.problem
    assert [str(each) for each in urdf.problems(file)] == [str(error)]


def test_missing_file_and_directory(tmp_path):
    for path, problem in ((tmp_path / "none.urdf", "No such file"), (tmp_path, "directory"), ("a\0b", "null")):
        with pytest.raises(UrdfError, match=problem) as caught:
            urdf.read(path)
        assert (caught.value.file, caught.value.element, caught.value.line) == (str(path), None, None)


def of(child: str, element: str) -> str:
    return f"<{child}> of <{element}>"


LINK, ROD_LINK, JOINT_O, JOINT_P, LOOP = 'link name="crank"', 'link name="rod"', 'joint name="O"', 'joint name="P"', 'loop_joint name="W"'


@pytest.mark.parametrize(
    ("text", "element", "line", "problem"),
    [
        # the robot and what stands in it
        (edited((' name="press"', "")), "<robot>", 2, "has no name"),
        (edited((' name="press"', ' name="press" version="2.0"')), '<robot name="press">', 2, "unknown URDF version '2.0'"),
        (added('<lnik name="x"/>'), '<lnik name="x">', END, "unknown element <lnik>, did you mean 'link'?"),
        (
            edited(("<inertial>", "<inertail>"), ("</inertial>", "</inertail>")),
            of("inertail", LINK),
            CRANK_MASS,
            "did you mean 'inertial'?",
        ),
        (edited(("<axis", "<axsi")), of("axsi", JOINT_O), LINE_O, "unknown element <axsi>, did you mean 'axis'?"),
        (edited(("<mass", "<mas")), of("mas", LINK), CRANK_MASS, "did you mean 'mass'?"),
        (edited(("<link1", "<link3")), of("link3", LOOP), LINE_W, "unknown element <link3>"),
        (edited((BOX, "<geom/>" + BOX)), of("geom", 'link name="frame"'), 5, "unknown element <geom>"),
        # names
        (added("<link/>"), "<link>", END, "has no name"),
        (added('<link name=""/>'), '<link name="">', END, "has no name"),
        (added('<link name="rod"/>'), '<link name="rod">', END, f"already that of the <link> on line {ROD}"),
        (edited(('<joint name="P" ', "<joint ")), "<joint>", LINE_P, "has no name"),
        (edited(('"P"', '"O"')), '<joint name="O">', LINE_P, f"already that of the <joint> on line {LINE_O}"),
        (edited(('"P"', '"universe"')), '<joint name="universe">', LINE_P, "Pinocchio's own"),
        (edited((' name="W"', "")), "<loop_joint>", LINE_W, "has no name"),
        (added(VALID.splitlines()[LINE_W - 1]), '<loop_joint name="W">', END, f"already that of the <loop_joint> on line {LINE_W}"),
        (edited(('"W"', '"O"')), '<loop_joint name="O">', LINE_W, "already that of a <joint>"),
        # what must be there just once
        (edited(('<axis xyz="0 -1 0"/>', '<axis xyz="0 -1 0"/><axis xyz="1 0 0"/>')), of("axis", JOINT_O), LINE_O, "a second <axis>"),
        (in_joint("P", '<origin xyz="0 0 0"/>'), of("origin", JOINT_P), 20, "a second <origin>"),
        (in_joint("O", '<child link="rod"/>'), of("child", JOINT_O), LINE_O, "a second <child>"),
        (edited((CRANK_INERTIAL, CRANK_INERTIAL + INERTIAL)), of("inertial", LINK), CRANK_MASS, "a second <inertial>"),
        (edited(('<mass value="20"/>', '<mass value="20"/><mass value="2"/>')), of("mass", LINK), CRANK_MASS, "a second <mass>"),
        (edited(("<link1 ", '<link1 link="crank"/><link1 ')), of("link1", LOOP), LINE_W, "a second <link1>"),
        (edited(('<mass value="20"/>', "")), of("inertial", LINK), CRANK_MASS, "has no <mass>"),
        (edited((f"<inertia {CRANK_INERTIA}/>", "")), of("inertial", LINK), CRANK_MASS, "has no <inertia>"),
        (edited(('<parent link="frame"/>', "")), '<joint name="O">', LINE_O, "has no <parent>"),
        (edited(('<child link="crank"/>', "")), '<joint name="O">', LINE_O, "has no <child>"),
        (edited(('<link1 link="rod" xyz="0.4 0 0"/>', "")), '<loop_joint name="W">', LINE_W, "has no <link1>"),
        (edited(('<link2 link="slide" rpy="0 0.5 0"/>', "")), '<loop_joint name="W">', LINE_W, "has no <link2>"),
        # attributes
        (edited((' link="frame"', "")), of("parent", JOINT_O), LINE_O, "has no link"),
        (edited((' link="crank"', ' link=""')), of("child", JOINT_O), LINE_O, "has no link"),
        (edited(('link1 link="rod"', "link1")), of("link1", LOOP), LINE_W, "has no link"),
        (edited((' xyz="0 -1 0"', "")), of("axis", JOINT_O), LINE_O, "has no xyz"),
        (edited((' value="20"', "")), of("mass", LINK), CRANK_MASS, "has no value"),
        (edited((' iyz="0"', "")), of("inertia", LINK), CRANK_MASS, "has no iyz"),
        (edited((' effort="1e6"', "")), of("limit", JOINT_P), 19, "has no effort"),
        (edited((' velocity="50"', "")), of("limit", JOINT_P), 19, "has no velocity"),
        (edited(('xyz="0.1', 'xzy="0.1')), of("origin", JOINT_P), 18, "unknown attribute 'xzy', did you mean 'xyz'?"),
        (edited(('xyz="0.1', 'rpy_deg="0.1')), of("origin", JOINT_P), 18, "unknown attribute 'rpy_deg'"),
        (edited(('xyz="0.1', 'quat_xyzw="0 0 0 1" xyz="0.1')), of("origin", JOINT_P), 18, "unknown attribute 'quat_xyzw'"),
        (edited(("lower=", "lowr=")), of("limit", JOINT_P), 19, "did you mean 'lower'?"),
        (edited(("<parent link", '<parent lnik="x" link')), of("parent", JOINT_O), LINE_O, "did you mean 'link'?"),
        (edited(('xyz="0.4 ', 'xzy="0.4 ')), of("link1", LOOP), LINE_W, "did you mean 'xyz'?"),
        (edited(('value="20"', 'value="20" unit="kg"')), of("mass", LINK), CRANK_MASS, "unknown attribute 'unit'"),
        (edited((CRANK_INERTIA, CRANK_INERTIA + ' iyx="0"')), of("inertia", LINK), CRANK_MASS, "unknown attribute 'iyx'"),
        # numbers
        (edited(('value="20"', 'value="3,5"')), of("mass", LINK), CRANK_MASS, "'3,5' is not a finite number"),
        (edited(('value="20"', 'value="20kg"')), of("mass", LINK), CRANK_MASS, "'20kg' is not a finite number"),
        (edited(('value="20"', 'value=" 20"')), of("mass", LINK), CRANK_MASS, "' 20' is not a finite number"),
        (edited(('value="20"', 'value="nan"')), of("mass", LINK), CRANK_MASS, "'nan' is not a finite number"),
        (edited(('value="20"', 'value="1e400"')), of("mass", LINK), CRANK_MASS, "'1e400' is not a finite number"),
        (edited(('value="20"', 'value="2_0"')), of("mass", LINK), CRANK_MASS, "'2_0' is not a finite number"),
        (edited(('value="20"', 'value="\u0662"')), of("mass", LINK), CRANK_MASS, "is not a finite number"),
        (edited(('value="20"', 'value=""')), of("mass", LINK), CRANK_MASS, "'' is not a finite number"),
        (edited(('ixx="1"', 'ixx="abc"')), of("inertia", LINK), CRANK_MASS, "'abc' is not a finite number"),
        (edited(('xyz="0.03 0 0"', 'xyz="0.03 0"')), of("origin", LINK), CRANK_MASS, "2 numbers, not 3"),
        (edited(('xyz="0.03 0 0"', 'rpy=""')), of("origin", LINK), CRANK_MASS, "0 numbers, not 3"),
        (edited(('xyz="0.03 0 0"', 'xyz="0.03\n0 0"')), of("origin", LINK), CRANK_MASS, "is not a finite number"),
        (edited(('xyz="0.03 0 0"', 'xyz="0.03\t0 0"')), of("origin", LINK), CRANK_MASS, "is not a finite number"),
        (edited(('xyz="0 -1 0"', 'xyz="0 -1 0 0"')), of("axis", JOINT_O), LINE_O, "4 numbers, not 3"),
        (edited(('upper="4"', 'upper="inf"')), of("limit", JOINT_P), 19, "'inf' is not a finite number"),
        (edited(('xyz="0.4 0 0"', 'xyz="0.4 0,0 0"')), of("link1", LOOP), LINE_W, "'0,0' is not a finite number"),
        (edited(('rpy="0 0.5 0"', 'rpy="0 90deg 0"')), of("link2", LOOP), LINE_W, "'90deg' is not a finite number"),
        # joints
        (edited((' type="continuous"', "")), '<joint name="O">', LINE_O, "has no type"),
        (edited(('"continuous"', '"planar"')), '<joint name="O">', LINE_O, "joint type 'planar' is not supported"),
        (edited(('"continuous"', '"floating"')), '<joint name="O">', LINE_O, "joint type 'floating' is not supported"),
        (edited(('"continuous"', '"continous"')), '<joint name="O">', LINE_O, "unknown joint type 'continous', did you mean 'continuous'?"),
        (in_joint("P", '<mimic joint="O"/>'), of("mimic", JOINT_P), 20, "gear pairs are not supported yet"),
        (edited((P_LIMIT, "")), '<joint name="P">', LINE_P, "a revolute joint needs a <limit>"),
        (edited(('"continuous"', '"prismatic"')), '<joint name="O">', LINE_O, "a prismatic joint needs a <limit>"),
        (edited(('effort="1e6"', 'effort="-1"')), of("limit", JOINT_P), 19, "effort is negative"),
        (edited(('velocity="50"', 'velocity="-1"')), of("limit", JOINT_P), 19, "velocity is negative"),
        (edited(('lower="-4"', 'lower="5"')), of("limit", JOINT_P), 19, "lower (5.0) is above upper (4.0)"),
        (in_joint("O", "<dynamics/>"), of("dynamics", JOINT_O), LINE_O, "neither damping nor friction"),
        (in_joint("O", '<dynamics damping="x"/>'), of("dynamics", JOINT_O), LINE_O, "'x' is not a finite number"),
        (in_joint("O", '<safety_controller k_position="1"/>'), of("safety_controller", JOINT_O), LINE_O, "has no k_velocity"),
        (in_joint("O", '<calibration rising="x"/>'), of("calibration", JOINT_O), LINE_O, "'x' is not a finite number"),
        (edited(('xyz="0 -1 0"', 'xyz="0 0 0"')), of("axis", JOINT_O), LINE_O, "the axis is zero"),
        (edited(('xyz="0 -1 0"', 'xyz="0 -1.00001 0"')), of("axis", JOINT_O), LINE_O, "the axis has length 1.00001, not 1"),
        (edited(('xyz="0 0 1"', 'xyz="0 0 2"')), of("axis", 'joint name="guide"'), 22, "the axis has length 2, not 1"),
        # the tree
        ('<robot name="empty"/>', '<robot name="empty">', 1, "has no <link>"),
        (
            edited(('<parent link="frame"/>', '<parent link="fram"/>')),
            of("parent", JOINT_O),
            LINE_O,
            "no link 'fram', did you mean 'frame'?",
        ),
        (edited(('<child link="rod"/>', '<child link="rad"/>')), of("child", JOINT_P), 18, "no link 'rad', did you mean 'rod'?"),
        (edited(('<child link="rod"/>', '<child link="crank"/>')), '<joint name="P">', LINE_P, "the same link 'crank'"),
        (
            edited(('<child link="slide"/>', '<child link="rod"/>')),
            '<joint name="guide">',
            GUIDE,
            "'rod' is already the child of joint 'P'",
        ),
        (added('<link name="table"/>'), '<link name="table">', END, "2 root links: frame, table"),
        (
            edited(('<parent link="frame"/>', '<parent link="rod"/>')),
            '<link name="crank">',
            CRANK,
            "a cycle of joints, not connected to the root: crank, rod",
        ),
        (
            added('<joint name="Q" type="fixed"><parent link="rod"/><child link="frame"/></joint>'),
            '<robot name="press">',
            2,
            "has no root link",
        ),
        # inertia
        (edited((CRANK_INERTIAL, "")), '<link name="crank">', CRANK, "it moves, but has no <inertial>"),
        (edited(('value="20"', 'value="0"')), of("mass", LINK), CRANK_MASS, "the mass 0.0 of a moving link is not positive"),
        (edited(('value="20"', 'value="-20"')), of("mass", LINK), CRANK_MASS, "the mass -20.0 of a moving link is not positive"),
        (welded("cap", "rod", INERTIAL.replace('"1"', '"0"', 1)), of("mass", 'link name="cap"'), END, "of a moving link is not positive"),
        (welded("cap", "frame", INERTIAL.replace('"1"', '"-1"', 1)), of("mass", 'link name="cap"'), END, "the mass -1.0 is negative"),
        (edited(('iyy="2"', 'iyy="2.00001"')), of("inertia", LINK), CRANK_MASS, "exceeds the sum of the other two"),
        (edited(('iyy="2"', 'iyy="-2"')), of("inertia", LINK), CRANK_MASS, "a principal moment of inertia is negative (-2, 1, 1)"),
        (edited(('ixy="0"', 'ixy="5"')), of("inertia", LINK), CRANK_MASS, "a principal moment of inertia is negative"),
        (edited(('ixx="1"', 'ixx="1e308"')), of("inertia", LINK), CRANK_MASS, "exceeds the sum of the other two"),
        # loops
        (edited((' type="spherical"', "")), '<loop_joint name="W">', LINE_W, "has no type"),
        (edited(('"spherical"', '"revolute"')), '<loop_joint name="W">', LINE_W, "loop type 'revolute' is not supported yet"),
        (edited(('"spherical"', '"fixed"')), '<loop_joint name="W">', LINE_W, "loop type 'fixed' is not supported yet"),
        (edited(('"spherical"', '"sperical"')), '<loop_joint name="W">', LINE_W, "unknown loop type 'sperical', did you mean 'spherical'?"),
        (edited(('link1 link="rod"', 'link1 link="rood"')), of("link1", LOOP), LINE_W, "no link 'rood', did you mean 'rod'?"),
        (edited(('link2 link="slide"', 'link2 link="slider"')), of("link2", LOOP), LINE_W, "no link 'slider', did you mean 'slide'?"),
        (edited(('link2 link="slide"', 'link2 link="rod"')), '<loop_joint name="W">', LINE_W, "the same link 'rod'"),
        # transmissions
        (edited(('<joint name="O"/>', "")), '<transmission name="drive">', DRIVE, "names no <joint>"),
        (edited(('<joint name="O"/>', "<joint/>")), of("joint", 'transmission name="drive"'), DRIVE, "has no name"),
        (
            edited(('<joint name="O"/>', '<joint name="guid"/>')),
            '<joint name="guid"> of <transmission name="drive">',
            DRIVE,
            "no joint 'guid', did you mean 'guide'?",
        ),
        (
            welded("cap", "rod", "").replace('<joint name="O"/>', '<joint name="weld"/>'),
            '<joint name="weld"> of <transmission name="drive">',
            DRIVE,
            "is fixed and cannot drive",
        ),
        # what is drawn; Pinocchio's parser prints and drops the shape, or stops
        (edited((BOX, "")), of("visual", 'link name="frame"'), 5, "has no <geometry>"),
        (edited((BOX, "<geometry/>")), of("geometry", 'link name="frame"'), 5, "has 0 shapes"),
        (edited(("<box", '<sphere radius="1"/><box')), of("geometry", 'link name="frame"'), 5, "has 2 shapes"),
        (edited(('size="1 1 0.1"', 'size="1 1"')), of("box", 'link name="frame"'), 5, "2 numbers, not 3"),
        (edited(('size="1 1 0.1"', 'size="1 1 -0.1"')), of("box", 'link name="frame"'), 5, "is not positive"),
        (edited(('<box size="1 1 0.1"', '<cylinder radius="1"')), of("cylinder", 'link name="frame"'), 5, "has no length"),
        (edited(('<box size="1 1 0.1"', "<mesh")), of("mesh", 'link name="frame"'), 5, "has no filename"),
        (edited(("0.5 0.5 0.5 1", "255 0 0 1")), of("color", 'material name="steel"'), 3, "is not from 0 to 1"),
        (edited(('<material name="steel"/>', "<material/>")), of("material", 'link name="frame"'), 5, "has no name"),
        (edited(('<color rgba="0.5 0.5 0.5 1"/>', "")), '<material name="steel">', 3, "neither a colour nor a texture"),
        (
            added('<material name="steel"><color rgba="0 0 0 1"/></material>'),
            '<material name="steel">',
            END,
            "already that of the <material> on line 3",
        ),
    ],
)
def test_problem(file, text, element, line, problem):
    error = first_problem(file, text)
    assert (error.element, error.line) == (element, line)
    assert problem in error.problem


def test_axis_remedy_is_accepted(file):
    error = first_problem(file, edited(('xyz="0 -1 0"', 'xyz="3e300 -4e300 0"')))
    assert 'xyz="0.6' in error.remedy
    file.write_text(edited(('xyz="0 -1 0"', error.remedy.removeprefix("write "))))
    assert urdf.read(file).name == "press"


@pytest.mark.parametrize(
    "text",
    [
        "\ufeff" + VALID,
        VALID.replace("\n", "\r\n"),
        edited(("<link ", "<!-- <link name='x' --><link ")),
        edited(('<robot name="press">', XACRO)),
        edited(('<robot name="press">', '<robot name="press" xmlns="http://www.ros.org" version="1.1">')),
        edited(('<robot name="press">', '<robot name="press" xmlns:drake="http://drake.mit.edu"><drake:x/>')),
        added('<drake:declare_convex/><gazebo reference="crank"><mu1>0,2</mu1></gazebo><ros2_control/><mujoco/><sensor/><fixed_frame/>'),
        in_joint("P", '<drake:damping value="1"/><dynamics damping="0.1" spring_stiffness="0"/>'),
        edited(('effort="1e6"', 'effort="1e6" acceleration="5" drake:acceleration="5"')),
        edited((CRANK_INERTIAL, CRANK_INERTIAL + "<contact/><verbose/><self_collision_checking/><sensor/>")),
        edited((CRANK_INERTIAL, f'{CRANK_INERTIAL}<collision><geometry><mesh filename="package://a/b.stl"/></geometry></collision>')),
        edited(('<transmission name="drive">', '<transmission name="drive" type="pr2"><leftActuator name="l"/><joint name="O"/>')),
        edited((VALID.splitlines()[DRIVE - 1], "")),
        edited(('<material name="steel"/>', '<material name=""><color rgba="1 0 0 1"/></material>')),
        edited(('xyz="0.1 0 0"', 'xyz="  +.1   0 0e-5 " rpy="0 0 0"')),
        edited(('<axis xyz="0 -1 0"/>', "")),
        edited((CRANK_INERTIA, 'ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"')),
        edited(('iyy="2"', 'iyy="2.000001"')),
        edited(('<origin xyz="0.03 0 0"/>', '<origin xyz="0.03 0 0" rpy="0.1 0.2 0.3"/>')),
        welded("cap", "rod", ""),
        welded("cap", "rod", INERTIAL),
        welded("base", "frame", INERTIAL.replace('"1"', '"0"')),
        edited((CRANK_INERTIAL, ""), ("</robot>", '<link name="web">' + INERTIAL + "</link></robot>")).replace(
            "</robot>", '<joint name="weld" type="fixed"><parent link="crank"/><child link="web"/></joint></robot>'
        ),
        VALID.replace('"crank"', '"&lt;script&gt; &quot;曲柄&quot;"').replace('"O"', '"&lt;b&gt;"'),
        VALID.replace('"crank"', '"cra\nnk"'),
    ],
)
def test_passes_and_pinocchio_reads_it_without_a_word(file, text, capfd):
    file.write_bytes(text.encode())
    press = urdf.read(file)
    model = pinocchio.buildModelFromXML(press.text.decode())
    assert all(model.existFrame(link, pinocchio.FrameType.BODY) for link in press.links)
    assert set(model.names) - {"universe"} == {joint.name for joint in press.joints if joint.type != "fixed"}
    assert capfd.readouterr().err == ""


def test_escaped_names_are_text(file):
    file.write_text(VALID.replace('"crank"', '"&lt;script&gt;"'))
    assert urdf.read(file).links[1] == "<script>"


def test_line_is_where_the_tag_starts(file):
    file.write_text(edited(('<link name="rod">', '<link\n  name="rod"\n>'), (' type="spherical"', ' type="spherical"\n\n ')))
    assert urdf.read(file).loops[0].line == LINE_W + 2
    assert first_problem(file, file.read_text().replace('"spherical"', '"ball"')).line == LINE_W + 2


def test_driver_named_twice_is_one(file):
    file.write_text(added('<transmission><joint name="guide"/><joint name="O"/></transmission>'))
    assert urdf.read(file).drivers == ("O", "guide")


def test_problems_lists_all_and_read_raises_the_first(file):
    text = edited(('value="20"', 'value="3,5"'), ('"spherical"', '"revolute"'), ('xyz="0 -1 0"', 'xyz="0 2 0"'))
    error = first_problem(file, text)
    found = list(urdf.problems(file))
    assert [each.line for each in found] == [CRANK_MASS, LINE_O, LINE_W]
    assert str(found[0]) == str(error)


MUTATION = st.tuples(
    st.integers(0, len(VALID.encode())), st.integers(0, 8), st.binary(max_size=4) | st.sampled_from([b"<", b'"', b"-", b"9"])
)


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(MUTATION, max_size=3), st.integers(0, 400))
@example([], 0)
def test_damaged_file_reads_or_raises_urdf_error(tmp_path, mutations, cut):
    text = VALID.encode()
    for place, length, new in mutations:
        text = text[:place] + new + text[place + length :]
    file = tmp_path / "damaged.urdf"
    file.write_bytes(text[: len(text) - cut] if cut < 200 else text)
    found = list(urdf.problems(file))
    if found:
        with pytest.raises(UrdfError, match=re.escape(str(found[0]))):
            urdf.read(file)
    else:
        pinocchio.buildModelFromXML(urdf.read(file).text.decode())
