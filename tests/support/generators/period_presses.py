"""Presses that repeat themselves only after several turns of their driver: five-bars whose two cranks are geared, and the textbook
crank-slider, whose crank a motor turns by a gear pair."""

from typing import Any

from support import texts

LINK = """<link name="{0}"><inertial><origin xyz="{1} 0 {2}"/><mass value="{3}"/>
    <inertia ixx="{4}" ixy="0" ixz="0" iyy="{4}" iyz="0" izz="{4}"/></inertial></link>"""
LINKS = (
    ("left_crank", 0.02, 0.0, 5),
    ("right_crank", 0.0, -0.02, 6),
    ("left_rod", 0.05, -0.17, 4),
    ("right_rod", -0.07, -0.14, 4),
    ("rod", 0.0, -0.15, 3),
    ("slide", 0.0, 0.0, 20),
)
# Two cranks, 50 mm at O and 70 mm at P, whose rods meet at C; from there a rod drives the slide. The left crank is the driver.
FIVE_BAR = """<robot name="geared_five_bar">
  <link name="frame"/>
  {links}
  <joint name="O" type="continuous"><parent link="frame"/><child link="left_crank"/><origin xyz="-0.15 0 0"/><axis xyz="0 -1 0"/></joint>
  <joint name="P" type="continuous"><parent link="frame"/><child link="right_crank"/><origin xyz="0.15 0 0"/><axis xyz="0 -1 0"/>
    <mimic joint="O" multiplier="{ratio}"/></joint>
  <joint name="A" type="continuous"><parent link="left_crank"/><child link="left_rod"/><origin xyz="0.05 0 0"/><axis xyz="0 -1 0"/></joint>
  <joint name="B" type="continuous"><parent link="right_crank"/><child link="right_rod"/><origin xyz="0 0 -0.07"/>
    <axis xyz="0 -1 0"/></joint>
  <joint name="C" type="continuous"><parent link="left_rod"/><child link="rod"/><origin xyz="0.1 0 -0.35"/><axis xyz="0 -1 0"/></joint>
  <joint name="guide" type="prismatic"><parent link="frame"/><child link="slide"/><origin xyz="0 0 -0.65"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1e9" velocity="1e9"/></joint>
  <loop_joint name="D" type="spherical"><link1 link="left_rod" xyz="0.1 0 -0.35"/><link2 link="right_rod" xyz="-0.15 0 -0.28"/></loop_joint>
  <loop_joint name="S" type="spherical"><link1 link="rod" xyz="0 0 -0.3"/><link2 link="slide" xyz="0 0 0"/></loop_joint>
  <transmission name="drive"><joint name="O"/></transmission>
</robot>
"""
RATIOS = {"half": 0.5, "third": 1 / 3, "one_and_a_half": 1.5}
TURNS = {"half": 2, "third": 3, "one_and_a_half": 2, "geared_down": 3}
"""Name of a press -> turns of its driver in one period."""


def repeating(name: str) -> Any:
    """A press of `TURNS`, by its name."""
    return geared_down() if name == "geared_down" else five_bar(RATIOS[name])


def five_bar(ratio: float) -> Any:
    """The right crank turns ``ratio`` times as fast as the left one."""
    return texts.load(FIVE_BAR.format(links="".join(LINK.format(*link, 0.02) for link in LINKS), ratio=repr(ratio)))


def of_two_motors() -> Any:
    """The five-bar without its gears: a motor on each crank. Where the right one turns ``ratio`` times as fast, it moves as `five_bar`, and
    the left crank of that takes torque O + ratio x torque P."""
    text = FIVE_BAR.format(links="".join(LINK.format(*link, 0.02) for link in LINKS), ratio=1)
    mimic, drive = '<mimic joint="O" multiplier="1"/>', '<transmission name="drive"><joint name="O"/></transmission>'
    assert text.count(mimic) == text.count(drive) == 1
    return texts.load(text.replace(mimic, "").replace(drive, f'{drive}<transmission name="other"><joint name="P"/></transmission>'))


def geared_down() -> Any:
    """The shipped crank-slider, its crank turned by a motor, the driver, three times as fast, whose rotor weighs next to nothing."""
    text = texts.shipped("crank_slide").text.decode()
    axis = '<axis xyz="0 -1 0"/>'
    motor = LINK.format("rotor", 0, 0, 1e-9, 1e-12) + '<joint name="M" type="continuous"><parent link="frame"/><child link="rotor"/>'
    for old, new in (
        ('<link name="crank">', motor + f'<origin xyz="0.4 0 0"/>{axis}</joint><link name="crank">'),
        (f'0 1.5707963267948966 0"/>{axis}', f'0 1.5707963267948966 0"/>{axis}<mimic joint="M" multiplier="{1 / 3!r}"/>'),
        ('<joint name="O"><hardware', '<joint name="M"><hardware'),
    ):
        assert text.count(old) == 1
        text = text.replace(old, new)
    return texts.load(text)
