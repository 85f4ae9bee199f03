"""Malformed URDF files, each with one fault, and what is to be said of it. `malformed_linkages` has more."""

import re

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


def loop_axis(kind: str, axis: str) -> str:
    return edited(('"spherical"', f'"{kind}"'), ("</loop_joint>", f'<axis xyz="{axis}"/></loop_joint>'))


def gears(words: str) -> str:
    """VALID with gear pairs, written as "P mimics O by -1 + 0.5, ..."."""
    text = VALID
    for follower, leader, multiplier, offset in re.findall(r"(\w+) mimics (\w+) by (\S+?)(?: \+ (\S+?))?(?:,|$)", words):
        mimic = f'<mimic joint="{leader}" multiplier="{multiplier}" offset="{offset or 0}"/>'
        text = re.sub(rf'(<joint name="{follower}".*?)(</joint>)', rf"\1{mimic}\2", text, count=1, flags=re.DOTALL)
    return text


def welded(link: str, parent: str, content: str) -> str:
    joint = f'<joint name="weld" type="fixed"><parent link="{parent}"/><child link="{link}"/></joint>'
    return added(f'<link name="{link}">{content}</link>{joint}')


def of(child: str, element: str) -> str:
    return f"<{child}> of <{element}>"


LINK, ROD_LINK, JOINT_O, JOINT_P, LOOP = 'link name="crank"', 'link name="rod"', 'joint name="O"', 'joint name="P"', 'loop_joint name="W"'


XACRO = '<robot name="press" xmlns:xacro="http://www.ros.org/wiki/xacro">'

BOMB = "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 10))  # 10 ** 9 times what a0 says

# Text, then element, line and problem of the first error.
FILES = [
    (b"", None, None, "is empty"),
    (b" \n\n", None, None, "is empty"),
    (VALID.encode("utf-16"), None, 1, "not UTF-8"),
    (b"<robot>\n\xff</robot>", None, 2, "not UTF-8"),
    (VALID[:-20], None, DRIVE, "not well-formed XML"),
    (edited(('<link name="rod">', '<link name="rod>')), None, 11, "not well-formed XML"),
    (VALID + "<robot/>", None, END + 1, "not well-formed XML"),
    (f'<!DOCTYPE robot [<!ENTITY a0 "ha">{BOMB}]><robot name="&a9;"/>', None, 1, "document type declaration"),
    ('<!DOCTYPE robot SYSTEM "file:///etc/passwd">\n' + VALID[22:], None, 1, "document type declaration"),
    ('<!DOCTYPE robot [<!ENTITY m SYSTEM "file:///etc/passwd">]>' + VALID[22:].replace("20", "&m;"), None, 1, "document type declaration"),
    (edited(('value="20"', 'value="&mass;"')), None, CRANK_MASS, "not well-formed XML: undefined entity"),
    (edited(('value="20"', "value=20")), None, CRANK_MASS, "not well-formed XML"),
    (edited(('value="20"', 'value="20" value="20"')), None, CRANK_MASS, "not well-formed XML: duplicate attribute"),
    (edited(('name="rod"', 'name="rod & cap"')), None, 10, "not well-formed XML"),
    (edited(('name="rod"', 'name="<rod>"')), None, 10, "not well-formed XML"),
    (edited(("</inertial>", "</Inertial>")), None, CRANK_MASS, "not well-formed XML: mismatched tag"),
    (edited(('name="rod"', 'name="ro\x01d"')), None, 10, "not well-formed XML"),
    (VALID.encode("utf-16-le"), None, 1, "not UTF-8 text (byte 1)"),
    (VALID.encode("utf-32"), None, 1, "not UTF-8"),
    (VALID.replace("press", "Pre\u00dfe").encode("latin-1"), None, 2, "not UTF-8"),
    ('<?xml version="1.0" encoding="ISO-8859-1"?>\n<robot name="Pre\u00dfe"/>'.encode("latin-1"), None, 2, "not UTF-8"),
    (VALID.encode().replace(b'"20"', b'"20\0"'), None, CRANK_MASS, "not UTF-8"),
    (VALID.encode() + b"\0", None, END + 1, "not UTF-8"),
    (bytes(range(256)) * 4, None, 2, "not UTF-8"),
    (b"\x7fELF\x02\x01\x01" + bytes(60), None, 1, "not UTF-8"),
    (b"PK\x03\x04" + bytes(26), None, 1, "not UTF-8"),
    ("name,mass\ncrank,20\n", None, 1, "not well-formed XML"),
    ("<robot>" + "<gazebo>" * 10_000, "<gazebo> of <gazebo>", 1, "is nested too deeply"),
    ('<mujoco model="press"/>', '<mujoco model="press">', None, "no driver"),
    ('<sdf version="1.7"><model name="press"/></sdf>', '<model name="press">', 1, "has no <link>"),
    ('<Robot name="press"/>', '<Robot name="press">', 1, "root element is not <robot>"),
    ('<urdf:robot name="press"/>', '<urdf:robot name="press">', 1, "root element is not <robot>"),
    ('<!DOCTYPE robot [<!ENTITY m "20">]>' + VALID[22:], None, 1, "document type declaration"),
    (edited(('<robot name="press">', XACRO + '<xacro:property name="r" value="1"/>')), '<xacro:property name="r">', 2, "is xacro"),
    (added("<?tool x?>"), None, END, "processing instruction"),
    (VALID.replace("<robot", "<?xml-model href='urdf.rng'?><robot"), None, 2, "processing instruction"),
    (added("<xacro:x/>"), "<xacro:x>", END, "is xacro"),
    (added('<xi:include href="frame.urdf"/>'), "<xi:include>", END, "is XInclude"),
    (added("<gazebo>" + "<a>" * 500 + "</a>" * 500 + "</gazebo>"), "<a> of <gazebo>", END, "is nested too deeply"),
]

ELEMENTS = [
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
    (added('<include xmlns="http://www.w3.org/2001/XInclude" href="x.urdf"/>'), "<include>", END, "unknown element <include>"),
    (added('<Link name="x"/>'), '<Link name="x">', END, "unknown element <Link>, did you mean 'link'?"),
    (added('<robot name="x"/>'), '<robot name="x">', END, "unknown element <robot>"),
    (in_joint("O", "<loop_joint/>"), of("loop_joint", JOINT_O), LINE_O, "unknown element <loop_joint>"),
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
    *(
        (edited(('value="20"', f'value="{text}"')), of("mass", LINK), CRANK_MASS, f"{text!r} is not a finite number")
        for text in ("-inf", "NAN", "0x14", "1e999", "2e", "--20", "+-20", "2.0.0", "20d0", "20 20", "1/2", "\uff12\uff10", "twenty", "1e-")
    ),
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
    # its six joints have other names
    (edited(('"continuous"', '"floating"')), '<joint name="O"> of <transmission name="drive">', 26, "no joint 'O', did you mean 'O_x'"),
    (edited(('"continuous"', '"continous"')), '<joint name="O">', LINE_O, "unknown joint type 'continous', did you mean 'continuous'?"),
    # gear pairs
    (in_joint("P", "<mimic/>"), of("mimic", JOINT_P), 20, "has no joint"),
    (in_joint("P", '<mimic joint="Q"/>'), of("mimic", JOINT_P), 20, "no joint 'Q'"),
    (in_joint("P", '<mimic joint="W"/>'), of("mimic", JOINT_P), 20, "no joint 'W'"),
    (in_joint("P", '<mimic joint="P"/>'), of("mimic", JOINT_P), 20, "the joint mimics itself"),
    (in_joint("P", '<mimic joint="O" multiplier="0"/>'), of("mimic", JOINT_P), 20, "multiplier is 0, which locks the joint"),
    (in_joint("P", '<mimic joint="O" multiplier="-0.0"/>'), of("mimic", JOINT_P), 20, "multiplier is 0"),
    (in_joint("P", '<mimic joint="O" multiplier="-1e-9"/>'), of("mimic", JOINT_P), 20, "multiplier is 1e-09, as good as 0, which locks"),
    (in_joint("P", '<mimic joint="O" multiplier="1e9"/>'), of("mimic", JOINT_P), 20, "multiplier is 1e+09, which locks joint 'O'"),
    (in_joint("P", '<mimic joint="O" ratio="2"/>'), of("mimic", JOINT_P), 20, "unknown attribute 'ratio'"),
    (in_joint("P", '<mimic joint="O" multiplier="1:2"/>'), of("mimic", JOINT_P), 20, "'1:2' is not a finite number"),
    (in_joint("P", '<mimic joint="O"/><mimic joint="guide"/>'), of("mimic", JOINT_P), 20, "a second <mimic>"),
    (gears("P mimics guide by 2, guide mimics P by 2"), of("mimic", JOINT_P), 20, "one turn comes back as 4 turns, 0 further"),
    (gears("P mimics guide by 2 + 1, guide mimics P by 0.5"), of("mimic", JOINT_P), 20, "one turn comes back as 1 turns, 1 further"),
    (gears("O mimics P by 1, P mimics guide by 1, guide mimics P by -1"), of("mimic", JOINT_P), 20, "P mimics guide mimics P"),
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
    (edited(('value="20"', 'value="0"')), of("mass", LINK), CRANK_MASS, "the mass 0.0 of a moving link is not positive"),
    (edited(('value="20"', 'value="-20"')), of("mass", LINK), CRANK_MASS, "the mass -20.0 of a moving link is not positive"),
    (welded("cap", "rod", INERTIAL.replace('"1"', '"0"', 1)), of("mass", 'link name="cap"'), END, "of a moving link is not positive"),
    (welded("cap", "frame", INERTIAL.replace('"1"', '"-1"', 1)), of("mass", 'link name="cap"'), END, "the mass -1.0 is negative"),
    (edited(('iyy="2"', 'iyy="2.00001"')), of("inertia", LINK), CRANK_MASS, "exceeds the sum of the other two"),
    (edited(('iyy="2"', 'iyy="-2"')), of("inertia", LINK), CRANK_MASS, "a principal moment of inertia is negative (-2, 1, 1)"),
    (edited(('ixy="0"', 'ixy="5"')), of("inertia", LINK), CRANK_MASS, "a principal moment of inertia is negative"),
    (edited(('ixx="1"', 'ixx="1e11"')), of("inertia", LINK), CRANK_MASS, "exceeds the sum of the other two"),
    (edited(('ixx="1"', 'ixx="1e308"')), of("inertia", LINK), CRANK_MASS, "ixx='1e308' is out of range"),
    (edited(('value="20"', 'value="1e13"')), of("mass", LINK), CRANK_MASS, "value='1e13' is out of range"),
    (edited(('xyz="0.4 0 0"', 'xyz="0.4 -1e300 0"')), of("link1", LOOP), LINE_W, "xyz='0.4 -1e300 0' is out of range"),
    (in_joint("P", '<mimic joint="O" multiplier="1e99"/>'), of("mimic", JOINT_P), 20, "multiplier='1e99' is out of range"),
    # loops
    (edited((' type="spherical"', "")), '<loop_joint name="W">', LINE_W, "has no type"),
    (loop_axis("revolute", "0 0 0"), of("axis", LOOP), LINE_W, "the axis is zero"),
    (loop_axis("revolute", "0 -2 0"), of("axis", LOOP), LINE_W, "the axis has length 2, not 1"),
    (loop_axis("revolute", "0 -1 0 0"), of("axis", LOOP), LINE_W, "4 numbers, not 3"),
    (loop_axis("spherical", "0 -1 0"), of("axis", LOOP), LINE_W, "a spherical loop has no axis"),
    (loop_axis("fixed", "0 -1 0"), of("axis", LOOP), LINE_W, "a fixed loop has no axis"),
    (edited(('"spherical"', '"sperical"')), '<loop_joint name="W">', LINE_W, "unknown loop type 'sperical', did you mean 'spherical'?"),
    (edited(('link1 link="rod"', 'link1 link="rood"')), of("link1", LOOP), LINE_W, "no link 'rood', did you mean 'rod'?"),
    (edited(('link2 link="slide"', 'link2 link="slider"')), of("link2", LOOP), LINE_W, "no link 'slider', did you mean 'slide'?"),
    (edited(('link2 link="slide"', 'link2 link="rod"')), '<loop_joint name="W">', LINE_W, "the same link 'rod'"),
    (
        welded("cap", "rod", "").replace('link2 link="slide"', 'link2 link="cap"'),
        '<loop_joint name="W">',
        LINE_W,
        "'rod' and 'cap' are welded together",
    ),
    (
        welded("base", "frame", "").replace('link1 link="rod"', 'link1 link="frame"').replace('link2 link="slide"', 'link2 link="base"'),
        '<loop_joint name="W">',
        LINE_W,
        "'frame' and 'base' are welded together",
    ),
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
]
