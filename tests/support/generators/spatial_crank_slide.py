"""A crank-slider through space: its crank axis and its guide are skew, and neither is square to anything."""

import numpy as np

CRANK_AXIS = np.array([0.2, -0.9, 0.3]) / np.linalg.norm([0.2, -0.9, 0.3])
GUIDE_AXIS = np.array([0.1, -0.2, 0.9]) / np.linalg.norm([0.1, -0.2, 0.9])
PIN_P = np.array([0.02, -0.05, -0.1])  # crank pin from the crank's pivot (the world origin), drawn [m]
PIN_W = np.array([0.06, 0.08, -0.5])  # slide's pin, drawn [m]
CROSS_AXIS = np.cross(CRANK_AXIS, [0.0, 0.0, 1.0]) / np.linalg.norm(
    np.cross(CRANK_AXIS, [0.0, 0.0, 1.0])
)  # of the cross, square to the crank's
LENGTH = np.linalg.norm(PIN_W - PIN_P)


def text(numbers):
    return " ".join(repr(float(x)) for x in numbers)


def inertial(mass, centre, moments):
    ixx, ixy, ixz, iyy, iyz, izz = moments
    return (
        f'<inertial><origin xyz="{text(centre)}"/><mass value="{mass}"/>'
        f'<inertia ixx="{ixx}" ixy="{ixy}" ixz="{ixz}" iyy="{iyy}" iyz="{iyz}" izz="{izz}"/></inertial>'
    )


SPATIAL = f"""<robot name="spatial">
  <link name="frame">{inertial(40.0, [0.1, 0.2, -0.3], [1, 0, 0, 1, 0, 1])}</link>
  <link name="crank">{inertial(6.0, [0.01, 0.02, -0.03], [0.05, 0.01, 0.0, 0.06, -0.01, 0.04])}</link>
  <link name="cross">{inertial(0.5, [0.002, 0.0, 0.001], [0.0005, 0.0, 0.0, 0.0006, 0.0, 0.0004])}</link>
  <link name="rod">{inertial(3.0, 0.45 * (PIN_W - PIN_P), [0.05, 0.0, 0.004, 0.05, 0.006, 0.01])}</link>
  <link name="slide">{inertial(20.0, [0.03, -0.02, -0.05], [0.2, 0.0, 0.0, 0.2, 0.0, 0.2])}</link>
  <joint name="O" type="continuous"><parent link="frame"/><child link="crank"/><axis xyz="{text(CRANK_AXIS)}"/></joint>
  <joint name="P" type="continuous">
    <parent link="crank"/><child link="cross"/><origin xyz="{text(PIN_P)}"/><axis xyz="{text(CRANK_AXIS)}"/>
  </joint>
  <joint name="Q" type="revolute">
    <parent link="cross"/><child link="rod"/><axis xyz="{text(CROSS_AXIS)}"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="guide" type="prismatic">
    <parent link="frame"/><child link="slide"/><origin xyz="{text(PIN_W)}"/><axis xyz="{text(GUIDE_AXIS)}"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <loop_joint name="W" type="spherical"><link1 link="rod" xyz="{text(PIN_W - PIN_P)}"/><link2 link="slide"/></loop_joint>
  <transmission name="drive"><joint name="O"/></transmission>
</robot>
"""
