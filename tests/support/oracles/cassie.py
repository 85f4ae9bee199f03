"""Cassie, the biped of Agility Robotics, as URDF text: read from an SDF of the package example-robot-data, pelvis held.

In an SDF a link is posed in the model, a joint in its child link, its axis in its own frame, and a link may be the child of two joints.
Here revolute joints make the tree, and the four ball joints close it. In the pose of the SDF the linkage of each foot is stretched, where
two assemblies meet; it is drawn in another one, nearly closed.
"""

from importlib.metadata import files
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

SIDES = {"left": 1.0, "right": -1.0}
DRAWN = {  # joint positions of each leg, from the pose of the SDF [rad]; roll and yaw are mirrored
    "roll-op": 0.1,
    "yaw-op": -0.15,
    "pitch-op": 0.3,
    "knee-op": -0.2,
    "shin-tarsus-joint": 0.06,
    "tarsus-spring-joint": 0.2,
    "achilles-spring-joint": -0.27,
    "tarsus-crank-joint": -1.5,
    "crank-rod-joint": 1.5,
    "foot-op": -1.5,
}
MOTORS = ("roll-op", "yaw-op", "pitch-op", "knee-op", "foot-op")
DRIVERS = tuple(f"{side}-{joint}" for side in SIDES for joint in (*MOTORS, "knee-shin-joint"))  # the last is a spring


def urdf():
    """The text. Every link's frame is that of the joint which carries it."""
    model = sdf()
    links, joints = {link.get("name"): link for link in model.findall("link")}, model.findall("joint")
    given = {name: _pose(link) for name, link in links.items()}
    at = {joint: given[joint.findtext("child")] * _pose(joint) for joint in joints}
    tree = {joint.findtext("child"): joint for joint in joints if joint.get("type") == "revolute"}
    frame = given | {child: at[joint] for child, joint in tree.items()}
    lines = ['<robot name="cassie">']
    for name, link in links.items():
        lines += [f'  <link name="{name}">', *_inertial(link.find("inertial"), frame[name].actInv(given[name])), "  </link>"]
    for child, joint in tree.items():
        name, parent = joint.get("name"), joint.findtext("parent")
        axis = _numbers(joint.find("axis").findtext("xyz"))
        origin = frame[parent].actInv(frame[child]) * pin.SE3(pin.exp3(drawn(name) * axis), np.zeros(3))
        lines += [
            f'  <joint name="{name}" type="continuous">',
            f'    <parent link="{parent}"/><child link="{child}"/>{_origin(origin)}<axis xyz="{_text(axis)}"/>',
            "  </joint>",
        ]
    for joint in joints:
        if joint.get("type") == "ball":
            ends = [(link, frame[link].actInv(at[joint].translation)) for link in (joint.findtext("parent"), joint.findtext("child"))]
            written = "".join(f'<link{k} link="{link}" xyz="{_text(point)}"/>' for k, (link, point) in enumerate(ends, 1))
            lines.append(f'  <loop_joint name="{joint.get("name")}" type="spherical">{written}</loop_joint>')
    lines += [f'  <transmission name="{name}"><joint name="{name}"/></transmission>' for name in DRIVERS]
    return "\n".join([*lines, "</robot>", ""])


def sdf():
    """The SDF's <model>."""
    path = next(path.locate() for path in files("example-robot-data") if path.name == "cassie_v2.sdf")
    return ElementTree.parse(path).getroot().find("model")


def drawn(joint):
    """Position of a joint in the URDF's pose, from that of the SDF [rad]."""
    side, _, kind = joint.partition("-")
    return DRAWN.get(kind, 0.0) * (SIDES[side] if kind in ("roll-op", "yaw-op") else 1.0)


def _pose(element):
    """Placement in the parent element. The file writes quarter turns as 1.5708, which sets axes that are meant to be parallel 1e-7 rad
    apart, and a planar four-bar with such axes does not move: they are quarter turns here."""
    numbers = _numbers(element.findtext("pose", "0 0 0 0 0 0"))
    quarters = np.round(numbers[3:] / (np.pi / 2)) * (np.pi / 2)
    angles = np.where(np.abs(numbers[3:] - quarters) < 1e-5, quarters, numbers[3:])
    return pin.SE3(pin.rpy.rpyToMatrix(angles), numbers[:3])


def _inertial(inertial, placement):
    moments = " ".join(f'{moment.tag}="{moment.text}"' for moment in inertial.find("inertia"))
    yield f"    <inertial>{_origin(placement * _pose(inertial))}"
    yield f'      <mass value="{inertial.findtext("mass")}"/><inertia {moments}/></inertial>'


def _origin(placement):
    return f'<origin xyz="{_text(placement.translation)}" rpy="{_text(pin.rpy.matrixToRpy(placement.rotation))}"/>'


def _numbers(text):
    return np.array(text.split(), dtype=float)


def _text(numbers):
    return " ".join(repr(float(number)) for number in numbers)
