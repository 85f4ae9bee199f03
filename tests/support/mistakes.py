"""Everyday mistakes in a pin table and in a URDF: what stands there, what is written instead, and words of what is said to it."""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pinpress as pp

TABLE = """\
units: mm
frame: A D
pins:
  D: [0, 0]
  A: [1250, -200]
  B: {from: A, length: 143, angle: 0}
  C: {B: 1243, D: 375, side: up}
  E: {from: D C, length: 480, angle: -135}
  F: {E: 480, x: 0, side: down}
links:
  crank:   {pins: A B,   mass: 1009.16, com: [56.7, 0],    inertia: 31.5}
  coupler: {pins: B C,   mass: 290.57}
  rocker:  {pins: D C E, mass: 2871.07, com: [-8.6, -3.8], inertia: 183}
  rod:     {pins: E F,   section: 200 x 120, overhang: 90}
  slide:   {pins: F, guide: up, mass: 7073.87}
drive: A
"""
COUPLER = "coupler: {pins: B C,   mass: 290.57}"


class InTable(NamedTuple):
    """A mistake in `TABLE`: a text there, once, what is written instead, the line that is named, words of what is said, and a text that
    is taken out as well."""

    old: str
    new: str
    line: int | None
    words: str
    removed: str = ""


IN_TABLES = {
    "no units": InTable("units: mm\n", "", None, "say the unit of all lengths: units: mm"),
    "unknown unit": InTable("units: mm", "units: mmm", 1, "did you mean 'mm'?"),
    "decimal comma in a point": InTable("A: [1250, -200]", "A: [1250,5, -200]", 5, "a point is [x, z], 3 numbers found"),
    "decimal comma in a mass": InTable("mass: 290.57", "mass: 290,57", 12, "write decimals after a point, not after a comma"),
    "unit of a mass": InTable("mass: 290.57", "mass: 290.57 kg", 12, "leave the unit out"),
    "unit of an angle": InTable("angle: 0}", "angle: 0°}", 6, "leave the unit out"),
    "brackets forgotten": InTable("A: [1250, -200]", "A: 1250, -200", 5, "'1250, -200' is a text; write a place: [x, z]"),
    "commas between pins": InTable("pins: E F", "pins: E, F", 14, "separate names by blanks, as in pins: A B"),
    "another usual word": InTable("mass: 290.57", "weight: 290.57", 12, "did you mean 'mass'?"),
    "misspelt key": InTable("inertia: 31.5", "inertai: 31.5", 11, "did you mean 'inertia'?"),
    "misspelt section of the table": InTable("links:", "link:", 10, "did you mean 'links'?"),
    "no space after a colon": InTable("length: 143", "length:143", 6, "write a space after the colon"),
    "tab": InTable("  C: {B", "\tC: {B", 7, "indent with blanks"),
    "key twice": InTable("  E: {from", "  D: {from", 8, "D stands there twice"),
    "pin in lower case": InTable("pins: B C", "pins: B c", 12, "did you mean 'C'?"),
    "commas between names": InTable("pins: D C E", "pins: 'D, C, E'", 13, "separate names by blanks"),
    "reserved name": InTable("  E: {from", "  side: {from", 8, "'side' cannot name a pin"),
    "no side": InTable(", side: up}", "}", 7, "two places fit, (157.9, -340.1) and (247.2, 282); say side"),
    "side does not decide": InTable("F: {E: 480, x: 0, side: down}", "F: {E: 480, x: 0, side: left}", 9, "say up or down"),
    "unknown side": InTable("side: up", "side: upp", 7, "did you mean 'up'?"),
    "lengths too short": InTable("B: 1243, D: 375", "B: 700, D: 375", 7, "700 and 375 do not meet: B and D are 1407.28 apart"),
    "line not reached": InTable("F: {E: 480, x: 0", "F: {E: 20, x: 0", 9, "20 from E does not reach x = 0: 31.4"),
    "placed in a circle": InTable(
        "B: {from: A, length: 143, angle: 0}", "B: {C: 1243, A: 143, side: up}", 6, "placed by one another: B - C - B"
    ),
    "rod of length zero": InTable("F: {E: 480, x: 0, side: down}", "F: E", 14, "E and F are one point"),
    "three pins on a line": InTable(
        "length: 480, angle: -135}", "length: 480, angle: 180}", 13, "on a line", ", com: [-8.6, -3.8], inertia: 183"
    ),
    "no mass": InTable(COUPLER, "coupler: {pins: B C}", 12, "give mass, section, box or disc; or say masses: none"),
    "negative mass": InTable("mass: 290.57", "mass: -290.57", 12, "a mass of -290.57"),
    "inertia about a wrong point": InTable("inertia: 31.5}", "inertia: {D: 31.5}}", 11, "less than its mass there would have"),
    "frame pin forgotten": InTable("frame: A D", "frame: A", None, "mobility is"),
    "guide forgotten": InTable("guide: up, ", "", 15, "it hangs by pin F alone and swings freely; give a slide its guide: up"),
    "a link drives": InTable("drive: A", "drive: crank", 16, "crank is a link; name its bearing: A"),
    "the slide drives": InTable("drive: A", "drive: slide", 16, "slide is a link; name its bearing: slide_guide"),
    "unknown driver": InTable("drive: A", "drive: Z", 16, "no pin or guide Z"),
    "link in the air": InTable("pins: E F", "pins: F", 14, "a section of a link with one pin"),
    "an empty list of pins": InTable("pins: E F", "pins: []", 14, "names of pins"),
    "no pins": InTable("pins: F, guide", "guide", 15, "no pins"),
    "empty": InTable(TABLE, "", None, "it is empty"),
    "not a table": InTable(TABLE, "hello", 1, "'hello' is a text; write keys"),
    "bracket left open": InTable("A: [1250, -200]", "A: [1250, -200", None, "it is no YAML"),
    "formula of an unknown name": InTable("length: 143", "length: r", 6, "'r' in 'r' is no parameter"),
    "formula without value": InTable("length: 143", "length: 1 / 0", 6, "has no finite value"),
    "mm taken for m": InTable("units: mm", "units: m", 3, "is it units: mm?"),
    "two sorts of mass": InTable("section: 200 x 120", "section: 200 x 120, disc: 20 x 30", 14, "give one of them"),
    "section of one number": InTable("section: 200 x 120", "section: 200", 14, "height x width"),
    "guide of one pin": InTable("guide: up", "guide: A", 15, "name two points, up, down, left, right or an angle"),
}

URDF = """\
<robot name="press">
  <link name="frame"/>
  <link name="crank">
    <inertial>
      <origin xyz="0.03 0 0"/><mass value="20"/>
      <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.05"/>
    </inertial>
  </link>
  <link name="rod">
    <inertial>
      <origin xyz="0 0 -0.2"/><mass value="15"/>
      <inertia ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.01"/>
    </inertial>
  </link>
  <link name="slide">
    <inertial>
      <mass value="100"/>
      <inertia ixx="0.8" ixy="0" ixz="0" iyy="0.8" iyz="0" izz="0.8"/>
    </inertial>
  </link>
  <joint name="O" type="continuous">
    <parent link="frame"/><child link="crank"/>
    <axis xyz="0 -1 0"/>
  </joint>
  <joint name="P" type="continuous">
    <parent link="crank"/><child link="rod"/>
    <origin xyz="0.1 0 0"/><axis xyz="0 -1 0"/>
  </joint>
  <joint name="slide_guide" type="prismatic">
    <parent link="frame"/><child link="slide"/>
    <origin xyz="0.1 0 -0.4"/><axis xyz="0 0 1"/>
    <limit lower="-0.3" upper="0.3" effort="1e6" velocity="20"/>
  </joint>
  <loop_joint name="W" type="spherical">
    <link1 link="rod" xyz="0 0 -0.4"/><link2 link="slide"/>
  </loop_joint>
  <transmission name="drive"><joint name="O"/></transmission>
</robot>
"""

Edits = tuple[tuple[str, str], ...]
ROD_END, PIN = '<link1 link="rod" xyz="0 0 -0.4"/>', '<origin xyz="0.1 0 0"/>'
LOOP = URDF[URDF.index("  <loop_joint") : URDF.index("  <transmission")]
IN_MM: Edits = (
    ('xyz="0.03 0 0"', 'xyz="30 0 0"'),
    ('xyz="0 0 -0.2"', 'xyz="0 0 -200"'),
    ('xyz="0.1 0 0"', 'xyz="100 0 0"'),
    ('xyz="0.1 0 -0.4"', 'xyz="100 0 -400"'),
    ('xyz="0 0 -0.4"', 'xyz="0 0 -400"'),
)


class InUrdf(NamedTuple):
    """A mistake in `URDF`: texts there with what is written instead, and words of what is said."""

    edits: Edits
    words: str


def one(old: str, new: str, words: str) -> InUrdf:
    return InUrdf(((old, new),), words)


IN_URDFS = {
    "all lengths in mm": InUrdf(IN_MM, "write lengths in metres, 0.001 for a millimetre"),
    "one length in mm": one(ROD_END, ROD_END.replace("0.4", "400"), "the linkage is 400 m long; write lengths in metres"),
    "a centre of mass in mm": one('xyz="0 0 -0.2"', 'xyz="0 0 -200"', "the centre of mass is 200 m from the nearest pin"),
    "masses in g": InUrdf((('"20"', '"20000"'), ('"15"', '"15000"'), ('"100"', '"100000"')), "write masses in kg"),
    "moments of inertia in kg mm2": one(
        'ixx="0.05" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.05"',
        'ixx="5e4" ixy="0" ixz="0" iyy="1e5" iyz="0" izz="5e4"',
        "the radius of gyration is 70.7 m, of a linkage of 0.412 m; write moments of inertia in kg m2",
    ),
    "moments of inertia in t m2": one(
        'ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.01"',
        'ixx="2e-4" ixy="0" ixz="0" iyy="2e-4" iyz="0" izz="1e-5"',
        "its density is at least 3e+07 kg/m3",
    ),
    "an angle in degrees": one(PIN, '<origin xyz="0.1 0 0" rpy="0 90 0"/>', "it seems to be in degrees"),
    "a rounded quarter turn": InUrdf(
        (
            (f'{PIN}<axis xyz="0 -1 0"/>', '<origin xyz="0.1 0 0" rpy="1.5708 0 0"/><axis xyz="0 0 1"/>'),
            (ROD_END, '<link1 link="rod" xyz="0 -0.4 0"/>'),
        ),
        "write angles in full, 1.5707963267948966 for a quarter turn",
    ),
    "no axis of the crank": one('    <axis xyz="0 -1 0"/>\n', "", "joint 'O' (line 21) has no <axis>, which means x: write its <axis>"),
    "an axis in the plane": one(
        f'{PIN}<axis xyz="0 -1 0"/>', f'{PIN}<axis xyz="1 0 0"/>', "mobility is 0, but one joint drives: held by loop 'W'"
    ),
    "an axis that is no unit vector": one('    <axis xyz="0 -1 0"/>\n', '    <axis xyz="0 -2 0"/>\n', 'write xyz="0.0 -1.0 0.0"'),
    "the slide's axis downwards": one('<axis xyz="0 0 1"/>', '<axis xyz="0 0 -1"/>', "count upwards all the same"),
    "link1 and link2 exchanged": InUrdf(
        ((ROD_END, '<link1 link="slide" xyz="0 0 -0.4"/>'), ('<link2 link="slide"/>', '<link2 link="rod"/>')),
        "loop 'W': link1 and link2 are exchanged: write each point with the link",
    ),
    "a loop's point in world axes": one(ROD_END, '<link1 link="rod" xyz="0.1 0 -0.4"/>', "apart as drawn"),
    "a point that is a little off": one(ROD_END, ROD_END.replace("0.4", "0.39"), "it is 10 mm apart as drawn; draw it closed"),
    "a rod that is too short": one(ROD_END, ROD_END.replace("0.4", "0.08"), "loop 'W' does not close near the drawn pose"),
    "a crank longer than the rod": InUrdf(
        ((ROD_END, ROD_END.replace("0.4", "0.09")), ('xyz="0.1 0 -0.4"', 'xyz="0.1 0 -0.09"')), "turns only from"
    ),
    "no loop": one(LOOP, "", "a <loop_joint> is missing, a link hangs free, or a driver is missing"),
    "a loop as a second joint": one(
        LOOP,
        '  <joint name="W" type="continuous"><parent link="rod"/><child link="slide"/></joint>\n',
        "write the second joint as a <loop_joint>",
    ),
    "a loop with the name of a joint": one('<loop_joint name="W"', '<loop_joint name="P"', "the name is already that of a <joint>"),
    "a name twice": one('<link name="rod">', '<link name="crank">', "the name is already that of the <link>"),
    "a link in upper case": one('<child link="rod"/>', '<child link="Rod"/>', "no link 'Rod', did you mean 'rod'?"),
    "a link that nothing holds": one(
        URDF[URDF.index('  <joint name="P"') : URDF.index('  <joint name="slide_guide"')],
        "",
        "there are 2 root links: frame, rod; connect all but one with a <joint>",
    ),
    "a misspelt element": one('<mass value="20"/>', '<mas value="20"/>', "unknown element <mas>, did you mean 'mass'?"),
    "a misspelt attribute": one('<mass value="20"/>', '<mass vaule="20"/>', "unknown attribute 'vaule', did you mean 'value'?"),
    "a decimal comma": one('"0.05"', '"0,05"', "write plain numbers, decimals after a point"),
    "a negative mass": one('"20"', '"-20"', "the mass -20.0 of a moving link is not positive"),
    "moments of inertia that no body has": one(
        'iyy="0.1"', 'iyy="0.2"', "the largest principal moment of inertia exceeds the sum of the other two"
    ),
    "no moments of inertia": one('      <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.05"/>\n', "", "has no <inertia>"),
    "an unknown joint type": one('"prismatic"', '"slider"', "unknown joint type 'slider'"),
    "an unknown loop type": one('"spherical"', '"ball"', "unknown loop type 'ball'"),
    "limits exchanged": one('lower="-0.3" upper="0.3"', 'lower="0.3" upper="-0.3"', "is above upper"),
    "a guide without limits": one(
        '    <limit lower="-0.3" upper="0.3" effort="1e6" velocity="20"/>\n', "", "a prismatic joint needs a <limit>"
    ),
    "no driver": one('  <transmission name="drive"><joint name="O"/></transmission>\n', "", "no driver"),
    "an unknown driver": one('<joint name="O"/></tr', '<joint name="A"/></tr', "no joint 'A'"),
    "a link that drives": one('<joint name="O"/></tr', '<joint name="crank"/></tr', "no joint 'crank'"),
    "a gear pair that locks": one('<origin xyz="0.1 0 0"/>', '<origin xyz="0.1 0 0"/><mimic joint="O" multiplier="0"/>', "multiplier is 0"),
    "a gear pair too many": one(
        '<origin xyz="0.1 0 0"/>',
        '<origin xyz="0.1 0 0"/><mimic joint="O" multiplier="-2"/>',
        "gear pair of joint 'P' contradicts the others",
    ),
    "a bracket left open": one('<axis xyz="0 0 1"/>', '<axis xyz="0 0 1">', "not well-formed XML"),
    "xacro": one('<link name="frame"/>', '<link name="frame"/><xacro:property name="r" value="0.1"/>', "is xacro"),
}


def table_with(mistake: InTable) -> str:
    """`TABLE` with a mistake."""
    assert TABLE.count(mistake.old) == 1
    return TABLE.replace(mistake.old, mistake.new).replace(mistake.removed or "\0", "")


def with_mistake(text: str, edits: Edits) -> str:
    """A text with edits, each of which is made where its old text first stands."""
    for old, new in edits:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text


def said_to_table(file: Path, text: str) -> list[str]:
    """What `build` says to a table, a line each: its error, or else its warnings. The file is written."""
    return _said(pp.build, file, text)


def said_to_urdf(file: Path, text: str) -> list[str]:
    """What is said to a URDF, a line each: the error of `load`, or else its warnings, or else the notes of `check`. The file is written."""
    said = _said(pp.load, file, text)
    return said or [f"note: {note.message(str(file))}" for note in pp.check(file).notes if "redundant" not in note.problem]


def _said(read: Callable[[Path], object], file: Path, text: str) -> list[str]:
    file.write_text(text, encoding="utf-8")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            read(file)
        except pp.PinpressError as error:
            return [f"error: {error}"]
    return [f"warning: {warning.message}" for warning in caught]
