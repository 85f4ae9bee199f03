"""A disc, or two; two shafts on one frame, geared or each with a drive of its own, with visuals; presses bolted down askew; a press with
crank and ram."""

from typing import Any

from support import texts

import pinpress as pp

GEARED = """<robot name="geared">
  <link name="frame"><visual><geometry><box size="0.5 0.02 0.2"/></geometry></visual></link>
  {links}
  <joint name="fast" type="continuous"><parent link="frame"/><child link="pinion"/><origin xyz="-0.1 0 0"/><axis xyz="0 -1 0"/></joint>
  <joint name="slow" type="continuous"><parent link="frame"/><child link="wheel"/><origin xyz="0.1 0 0"/><axis xyz="0 -1 0"/>{mimic}</joint>
  {drives}
</robot>
"""
LINK = """<link name="{0}"><inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><origin xyz="0.04 -0.03 0"/><geometry><box size="0.1 0.02 0.02"/></geometry></visual></link>"""


DISC = """<robot name="disc">
  <link name="frame"/>
  {discs}
</robot>
"""
TURNED = """<link name="{name}">
    <inertial><origin xyz="{x} 0 0"/><mass value="40"/><inertia ixx="2" ixy="0" ixz="0" iyy="3" iyz="0" izz="2"/></inertial>
  </link>
  <joint name="{joint}" type="continuous"><parent link="frame"/><child link="{name}"/><origin xyz="0.1 0 0.4"/><axis xyz="0 -1 0"/></joint>
  <transmission name="drive_{joint}"><joint name="{joint}"/></transmission>"""


def disc(eccentricity: float = 0.0) -> Any:
    """A disc of 40 kg and 3 kg m2 about its centre of mass, which may be off its shaft [m]."""
    return texts.load(DISC.format(discs=TURNED.format(name="disc", joint="O", x=eccentricity)))


def two_discs() -> Any:
    """Each turned by its driver."""
    return texts.load(
        DISC.format(discs="".join(TURNED.format(name=name, joint=joint, x=0.0) for name, joint in (("disc", "O"), ("other", "P"))))
    )


def geared(mimic: str, *drivers: str) -> Any:
    drives = "".join(f'<transmission name="drive_{name}"><joint name="{name}"/></transmission>' for name in drivers)
    return texts.load(GEARED.format(links=LINK.format("pinion") + LINK.format("wheel"), mimic=mimic, drives=drives))


def two_cranks() -> Any:
    """Both driven."""
    return geared("", "fast", "slow")


def bolted(press: Any, rpy: str, **more: Any) -> Any:
    """A shipped press whose frame is fixed to a floor at these angles [rad]."""
    bolts = f'<joint name="bolts" type="fixed"><parent link="floor"/><child link="frame"/><origin xyz="0 0 0" rpy="{rpy}"/></joint>'
    text = press.text.decode().replace('<link name="frame">', '<link name="floor"/>' + bolts + '<link name="frame">')
    return texts.load(text, **more)


def hybrid() -> Any:
    """A crank press whose rod a second driver, a ram, leads sideways."""
    return pp.build(
        units="mm",
        frame="A",
        pins={"A": [0, 0], "C": [0, 100], "B": [500, -300], "E": [100, -400], "W": {"E": 600, "x": 0, "side": "down"}},
        links={
            "crank": {"pins": "A C", "mass": 60},
            "coupler": {"pins": "C E", "mass": 20},
            "rod": {"pins": "E W", "mass": 30},
            "slide": {"pins": "W", "guide": "up", "mass": 800},
            "ram": {"pins": "B", "guide": "right", "travel": [-100, 100], "mass": 50},
            "arm": {"pins": "B E", "mass": 5},
        },
        drive="A ram_guide",
    )
