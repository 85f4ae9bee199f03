"""Linkages that are written well and do not go together: edits of one that does, drawn with its crank 40 deg above the x axis."""

import math

from support.generators.malformed_urdf import INERTIAL

CRANK_LENGTH, ROD_LENGTH, ANGLE = 0.1, 0.4, math.radians(40)
PIN = CRANK_LENGTH * math.cos(ANGLE), CRANK_LENGTH * math.sin(ANGLE)
SLIDE = PIN[1] - math.sqrt(ROD_LENGTH**2 - PIN[0] ** 2)
LEANING = math.atan2(SLIDE - PIN[1], -PIN[0])  # angle of the rod

AXIS = '<axis xyz="0 -1 0"/>'
SIDEWAYS = '<axis xyz="1 0 0"/>'
ORIGIN_O = f'<origin rpy="0 {-ANGLE!r} 0"/>'
ORIGIN_P = f'<origin xyz="{CRANK_LENGTH!r} 0 0" rpy="0 {ANGLE - LEANING!r} 0"/>'
ORIGIN_GUIDE = f'<origin xyz="0 0 {SLIDE!r}"/>'
GEAR = '<mimic joint="O" multiplier="-2"/>'
ROD_END = f'<link1 link="rod" xyz="{ROD_LENGTH!r} 0 0"/>'
SLIDE_END = f'<link2 link="slide" rpy="0 {-LEANING!r} 0"/>'
OPENING_W = '<loop_joint name="W" type="spherical">'
TRANSMISSION = '<transmission name="drive"><joint name="O"/></transmission>'
GOES = f"""<robot name="goes">
  <link name="frame"/>
  <link name="crank">{INERTIAL}</link>
  <link name="rod">{INERTIAL}</link>
  <link name="slide">{INERTIAL}</link>
  <link name="wheel">{INERTIAL}</link>
  <joint name="O" type="continuous"><parent link="frame"/><child link="crank"/>{ORIGIN_O}{AXIS}</joint>
  <joint name="P" type="continuous"><parent link="crank"/><child link="rod"/>{ORIGIN_P}{AXIS}<!-- P --></joint>
  <joint name="G" type="continuous"><parent link="frame"/><child link="wheel"/><origin xyz="0.5 0 0"/>{AXIS}{GEAR}</joint>
  <joint name="guide" type="prismatic"><parent link="frame"/><child link="slide"/>{ORIGIN_GUIDE}<axis xyz="0 0 1"/><!-- guide -->
    <limit lower="-1" upper="1" effort="1e6" velocity="20"/></joint>
  {OPENING_W}{ROD_END}{SLIDE_END}</loop_joint>
  {TRANSMISSION}
</robot>
"""
LINE_GUIDE, LINE_W, LINE_V = 10, 12, 14  # V is a loop that is added
ROBOT, LOOP_W, LOOP_V = '<robot name="goes">', '<loop_joint name="W">', '<loop_joint name="V">'
PENDULUM = f'<link name="bob">{INERTIAL}</link><joint name="L" type="continuous"><parent link="frame"/><child link="bob"/>{AXIS}</joint>'


def changed(*edits: tuple[str, str]) -> str:
    """GOES with texts replaced at their first place, where each must occur."""
    text = GOES
    for old, new in edits:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text


def with_element(element: str) -> str:
    return changed(("</robot>", element + "</robot>"))


def pinned(kind: str, end1: str, end2: str, inside: str = "") -> str:
    """GOES with a second loop V between links."""
    return with_element(f'<loop_joint name="V" type="{kind}"><link1 {end1}/><link2 {end2}/>{inside}</loop_joint>')


STAYS = "mobility is 0, but one joint drives"
AT_PIN = f'xyz="{PIN[0]!r} 0 {PIN[1]!r}"'

# Text, then the problem of the first error, which is a UrdfError of the linkage as a whole. Of one that stays, all who are to blame.
MOBILITIES = [
    # too many degrees of freedom
    (
        changed((f"{OPENING_W}{ROD_END}{SLIDE_END}</loop_joint>", "")),
        "mobility is 3, but one joint drives: with joint 'O' held still, joints 'P', 'guide' can move",
    ),
    (changed((GEAR, "")), "mobility is 2, but one joint drives: with joint 'O' held still, joint 'G' can move"),
    (with_element(PENDULUM), "mobility is 2, but one joint drives: with joint 'O' held still, joint 'L' can move"),
    # too few
    (with_element('<transmission><joint name="P"/></transmission>'), "mobility is 1, but 2 joints drive"),
    (
        with_element('<transmission><joint name="G"/></transmission>'),
        "mobility is 1, but 2 joints drive: gear pair of joint 'G' contradicts the others",
    ),
    (pinned("spherical", 'link="crank" xyz="0.1 0 0"', f'link="frame" {AT_PIN}'), f"{STAYS}: loop 'V' contradicts the others"),
    (pinned("fixed", 'link="crank"', f'link="frame" rpy="0 {-ANGLE!r} 0"'), f"{STAYS}: loop 'V' contradicts the others"),
    (
        pinned("revolute", 'link="crank"', 'link="wheel" xyz="-0.5 0 0"', AXIS),
        f"{STAYS}: loop 'V' or gear pair of joint 'G' contradicts the others",
    ),
    (
        changed(("<!-- guide -->", '<mimic joint="G" multiplier="0.1"/>')),
        f"{STAYS}: gear pair of joint 'G' or gear pair of joint 'guide' contradicts the others",
    ),
    (changed(('"spherical"', '"fixed"')), f"{STAYS}: held by loop 'W'"),
    (changed(('name="P" type="continuous"', 'name="P" type="fixed"')), f"{STAYS}: held by loop 'W'"),
    (changed(("<!-- P -->", '<mimic joint="O" multiplier="-1"/>')), f"{STAYS}: gear pair of joint 'P' contradicts the others"),
    (changed(("<!-- guide -->", '<mimic joint="O" multiplier="0.1"/>')), f"{STAYS}: gear pair of joint 'guide' contradicts the others"),
    (changed((f"{ORIGIN_O}{AXIS}", f"{ORIGIN_O}{SIDEWAYS}")), f"{STAYS}: held by loop 'W'"),
    # axes that are not parallel
    (changed(('xyz="0.1 0 0" rpy="0 ', 'xyz="0.1 0 0" rpy="0.1 ')), f"{STAYS}: held by loop 'W'"),
    (changed(('<axis xyz="0 0 1"/>', '<axis xyz="0 0.1 0.99498743710662"/>')), f"{STAYS}: held by loop 'W'"),
]


def open_by(text: str, millimetres: float, element: str = LOOP_W, line: int = LINE_W) -> tuple[str, str, int, str]:
    return text, element, line, f"does not close: {millimetres:.3g} mm apart as drawn"


# Text, then element, line and problem of the first error, an AssemblyError.
OPEN = [
    open_by(changed((ROD_END, ROD_END.replace("0.4 0 0", "0.4 0.02 0"))), 20),
    open_by(changed((ORIGIN_GUIDE, ORIGIN_GUIDE.replace('xyz="0 ', 'xyz="0.9 '))), 900),
    open_by(changed((ORIGIN_GUIDE, ORIGIN_GUIDE.replace('xyz="0 0 ', 'xyz="0 0.03 '))), 30),
    open_by(changed((ROD_END, ROD_END.replace('"rod"', '"wheel"'))), 958),
    open_by(pinned("spherical", 'link="wheel" xyz="0 0 0.1"', 'link="frame" xyz="0.5 0 0.13"').replace(GEAR, ""), 30, LOOP_V, LINE_V),
    (
        changed(('"spherical"', '"revolute"'), ('"slide" rpy="0 ', '"slide" rpy="0.1 '), ("</loop_joint>", f"{AXIS}</loop_joint>")),
        LOOP_W,
        LINE_W,
        "does not close: 5.73 deg apart as drawn",
    ),
]


# Text, then element, line and problem of the first error, a UrdfError.
DRIVERS = [
    (
        changed((TRANSMISSION, TRANSMISSION.replace('"O"', '"guide"')), ('lower="-1"', 'lower="1"')),
        '<joint name="guide">',
        LINE_GUIDE,
        "the driver slides from 1 to 1 m, the <limit> of its joint, and so not at all",
    ),
]

# GOES with axes that are nearly parallel or a point nearly in the plane, and by how much they miss [rad or m].
ROUNDED = [
    (changed((ORIGIN_P, ORIGIN_P.replace('rpy="0 ', 'rpy="1e-4 '))), 1e-4),
    (changed((ORIGIN_O, ORIGIN_O.replace('rpy="0 ', 'rpy="3.7e-6 '))), 3.7e-6),
    (changed(('<axis xyz="0 0 1"/>', '<axis xyz="0 0.001 0.9999995"/>')), 1e-3),
    (changed((ROD_END, ROD_END.replace("0.4 0 0", "0.4 1e-6 0"))), 1e-6),
    (changed((ORIGIN_GUIDE, ORIGIN_GUIDE.replace("/>", ' rpy="3e-10 0 0"/>'))), 3e-10),
    (changed(('"spherical"', '"revolute"'), ("</loop_joint>", '<axis xyz="0 -1 2e-11"/></loop_joint>')), 2e-11),
    (changed((ORIGIN_P, ORIGIN_P.replace('rpy="0 ', 'rpy="5e-12 '))), 5e-12),
]

# Text, then the problem of the first error, a SingularityError.
DEAD = [
    # the rod lies across the guide
    (
        changed(
            (ORIGIN_P, f'<origin xyz="{CRANK_LENGTH!r} 0 0" rpy="0 {ANGLE!r} 0"/>'),
            (ORIGIN_GUIDE, f'<origin xyz="{PIN[0] + ROD_LENGTH!r} 0 {PIN[1]!r}"/>'),
        ),
        "joint 'O' does not determine the drawn pose",
    ),
    # the rod turns about itself, and holds the crank
    (changed((f"{ORIGIN_P}{AXIS}", f"{ORIGIN_P}{SIDEWAYS}")), "joint 'O' does not determine the drawn pose"),
    # the driver is held, beside a pendulum
    (
        changed((GEAR, ""), ('name="P" type="continuous"', 'name="P" type="fixed"')),
        "joint 'O' does not determine the drawn pose",
    ),
]
