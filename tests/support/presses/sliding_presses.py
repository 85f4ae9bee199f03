"""URDFs of presses whose driver slides, and their closed forms.

A hydraulic cylinder G-K that swings between two pins turns a bell crank O, by the law of cosines. The nut of a ball screw pushes the lower
end of the upper one of two equal toggle links, through a slot, so that the slide hangs at the third side of an isosceles triangle.
"""

import math

import numpy as np

ARM, RETRACTED = 0.3, 0.5  # O to K; G to K as drawn [m]
G = np.array([-0.5, 0.3])
LEVER = np.array([0.2, 0.1])  # centre of mass of the bell crank as drawn [m]
MASSES = {"barrel": 20.0, "piston": 10.0, "lever": 40.0}
CENTRES = {"barrel": 0.2, "piston": -0.1}  # from G, from K, along the cylinder [m]

BELL = """<robot name="bell_crank">
<link name="frame"/>
<link name="barrel"><inertial><origin xyz="0.2 0 0"/><mass value="20"/>
  <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.5" iyz="0" izz="0.5"/></inertial></link>
<link name="piston"><inertial><origin xyz="-0.1 0 0"/><mass value="10"/>
  <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.2"/></inertial></link>
<link name="lever"><inertial><origin xyz="0.2 0 0.1"/><mass value="40"/>
  <inertia ixx="1" ixy="0" ixz="0" iyy="1.5" iyz="0" izz="1"/></inertial></link>
<joint name="G" type="continuous"><parent link="frame"/><child link="barrel"/><origin xyz="-0.5 0 0.3"/><axis xyz="0 -1 0"/></joint>
<joint name="cylinder" type="prismatic"><parent link="barrel"/><child link="piston"/><origin xyz="0.5 0 0"/><axis xyz="1 0 0"/>
  <limit lower="-0.1" upper="0.15" effort="1e6" velocity="1"/></joint>
<joint name="O" type="continuous"><parent link="frame"/><child link="lever"/><axis xyz="0 -1 0"/></joint>
<loop_joint name="K" type="spherical"><link1 link="piston"/><link2 link="lever" xyz="0 0 0.3"/></loop_joint>
<transmission name="drive"><joint name="cylinder"/></transmission>
</robot>"""

UPPER = LOWER = 0.4
NUT = 0.1  # how far the nut stands beside the line of the toggle as drawn [m]

# A horizontal screw pushes the knee of a toggle between the frame's pin U and the slide, by a link of no length: the nut carries a slot.
TOGGLE = f"""<robot name="screw_toggle">
<link name="frame"/>
<link name="nut"><inertial><mass value="15"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<link name="block"><inertial><mass value="2"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
<link name="upper"><inertial><origin xyz="0 0 -0.2"/><mass value="12"/>
  <inertia ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.01"/></inertial></link>
<link name="lower"><inertial><origin xyz="0 0 -0.2"/><mass value="12"/>
  <inertia ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.01"/></inertial></link>
<link name="slide"><inertial><mass value="300"/><inertia ixx="5" ixy="0" ixz="0" iyy="5" iyz="0" izz="5"/></inertial></link>
<joint name="screw" type="prismatic"><parent link="frame"/><child link="nut"/><axis xyz="1 0 0"/>
  <origin xyz="{-NUT} 0 -0.3872983346207417"/><limit lower="-0.15" upper="0.09" effort="1e6" velocity="1"/></joint>
<joint name="slot" type="prismatic"><parent link="nut"/><child link="block"/><axis xyz="0 0 1"/>
  <limit lower="-1" upper="1" effort="1e6" velocity="1"/></joint>
<joint name="U" type="continuous"><parent link="frame"/><child link="upper"/>
  <origin rpy="0 {math.asin(NUT / UPPER)!r} 0"/><axis xyz="0 -1 0"/></joint>
<joint name="K" type="continuous"><parent link="upper"/><child link="lower"/>
  <origin xyz="0 0 {-UPPER}" rpy="0 {-2 * math.asin(NUT / UPPER)!r} 0"/><axis xyz="0 -1 0"/></joint>
<joint name="slide_guide" type="prismatic"><parent link="frame"/><child link="slide"/><origin xyz="0 0 -0.7745966692414834"/>
  <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1e6" velocity="10"/></joint>
<loop_joint name="N" type="spherical"><link1 link="block"/><link2 link="lower"/></loop_joint>
<loop_joint name="S" type="spherical"><link1 link="lower" xyz="0 0 {-LOWER}"/><link2 link="slide"/></loop_joint>
<transmission name="drive"><joint name="screw"/></transmission>
</robot>"""


def lever_angle(travel):
    """Angle of the bell crank from the drawn pose, positive counter-clockwise (x towards z), by the law of cosines."""
    frame = np.linalg.norm(G)
    at_o = np.arccos((frame**2 + ARM**2 - (RETRACTED + travel) ** 2) / (2 * frame * ARM))
    return -(at_o - np.arccos((frame**2 + ARM**2 - RETRACTED**2) / (2 * frame * ARM)))


def potential(travel):
    """Potential energy of the cylinder's and the crank's weights [J]."""
    angle = lever_angle(travel)
    knee = ARM * np.array([-np.sin(angle), np.cos(angle)])
    along = (knee - G[:, None]) / (RETRACTED + travel)
    lever = np.sin(angle) * LEVER[0] + np.cos(angle) * LEVER[1]
    heights = {"barrel": G[1] + CENTRES["barrel"] * along[1], "piston": knee[1] + CENTRES["piston"] * along[1], "lever": lever}
    return 9.81 * sum(MASSES[name] * height for name, height in heights.items())


def slide_position(travel):
    """Position of the slide of the toggle [m]."""
    return -2 * np.sqrt(UPPER**2 - (travel - NUT) ** 2)
