"""Presses in other formats than ours, written from the elements of their URDF by XML and NumPy alone."""

from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

DRAKE = 'xmlns:drake="http://drake.mit.edu"'


@dataclass
class Body:
    name: str
    mass: float | None
    centre: np.ndarray
    tensor: np.ndarray  # about the centre of mass, in the link's axes


@dataclass
class Bearing:
    name: str
    type: str
    parent: str
    child: str
    place: np.ndarray  # (4, 4) in the parent's frame
    axis: np.ndarray
    mimic: tuple[str, float] | None


@dataclass
class Pin:
    name: str
    link1: str
    point1: np.ndarray
    link2: str
    point2: np.ndarray


class Press:
    """What the elements of a URDF say, its pins moved on link1 to where they are drawn on link2, so that all loops are closed."""

    def __init__(self, text):
        self.robot = ElementTree.fromstring(text)
        self.name = self.robot.get("name")
        self.bodies = [_body(link) for link in self.robot.findall("link")]
        self.bearings = [_bearing(joint) for joint in self.robot.findall("joint")]
        self.drivers = [joint.get("name") for joint in self.robot.findall("transmission/joint")]
        children = {bearing.child for bearing in self.bearings}
        self.root = next(body.name for body in self.bodies if body.name not in children)
        self.places = {self.root: np.eye(4)}
        left = list(self.bearings)
        while left:
            bearing = next(each for each in left if each.parent in self.places)
            self.places[bearing.child] = self.places[bearing.parent] @ bearing.place
            left.remove(bearing)
        self.pins = [self._pin(loop) for loop in self.robot.findall("loop_joint")]

    def _pin(self, loop):
        assert loop.get("type") == "spherical"
        link1, link2 = (loop.find(end).get("link") for end in ("link1", "link2"))
        point2 = _numbers(loop.find("link2").get("xyz", "0 0 0"))
        there = self.places[link2] @ [*point2, 1.0]
        return Pin(loop.get("name"), link1, (np.linalg.inv(self.places[link1]) @ there)[:3], link2, point2)

    def urdf(self):
        """The same press in our own format."""
        for loop, pin in zip(self.robot.findall("loop_joint"), self.pins, strict=True):
            loop.find("link1").set("xyz", _text(pin.point1))
        return ElementTree.tostring(self.robot, encoding="unicode")

    # ------------------------------------------------------------------------------------------------------------- dialects of URDF

    def drake(self):
        """With ball constraints, as Drake writes them."""
        return self._with_loops(
            lambda pin: (
                f'<drake:ball_constraint name="{pin.name}">\n  <drake:ball_constraint_body_A name="{pin.link1}"/>\n'
                f'  <drake:ball_constraint_p_AP value="{_text(pin.point1)}"/>\n  <drake:ball_constraint_body_B name="{pin.link2}"/>\n'
                f'  <drake:ball_constraint_p_BQ value="{_text(pin.point2)}"/>\n</drake:ball_constraint>'
            )
        )

    def bushings(self):
        """With bushings of Drake that hold no torque."""
        return self._with_loops(
            lambda pin: (
                f'<frame name="{pin.name}_A" link="{pin.link1}" xyz="{_text(pin.point1)}" rpy="0 0 0"/>\n'
                f'<frame name="{pin.name}_C" link="{pin.link2}" xyz="{_text(pin.point2)}" rpy="0 0 0"/>\n'
                f'<drake:linear_bushing_rpy name="{pin.name}"><drake:bushing_frameA name="{pin.name}_A"/>'
                f'<drake:bushing_frameC name="{pin.name}_C"/><drake:bushing_torque_stiffness value="0 0 0"/>'
                '<drake:bushing_torque_damping value="0 0 0"/><drake:bushing_force_stiffness value="1e9 1e9 1e9"/>'
                '<drake:bushing_force_damping value="1e3 1e3 1e3"/></drake:linear_bushing_rpy>'
            )
        )

    def urdf_plus(self):
        return self._with_loops(
            lambda pin: (
                f'<loop name="{pin.name}" type="spherical">'
                f'<predecessor link="{pin.link1}"><origin xyz="{_text(pin.point1)}"/></predecessor>'
                f'<successor link="{pin.link2}"><origin xyz="{_text(pin.point2)}"/></successor></loop>'
            )
        )

    def gazebo(self):
        return self._with_loops(
            lambda pin: (
                f'<gazebo>\n<joint name="{pin.name}" type="ball"><parent>{pin.link1}</parent><child>{pin.link2}</child>'
                f"<pose>{_text(pin.point2)} 0 0 0</pose></joint>\n</gazebo>"
            )
        )

    def _with_loops(self, written):
        text = self.urdf().replace("<robot ", f"<robot {DRAKE} ", 1)
        for loop in self.robot.findall("loop_joint"):
            pin = next(pin for pin in self.pins if pin.name == loop.get("name"))
            was = ElementTree.tostring(loop, encoding="unicode").strip()
            assert was in text
            text = text.replace(was, written(pin))
        return text

    # -------------------------------------------------------------------------------------------------------------------------- MJCF

    def mjcf(self, by_sites=True):
        """``by_sites``: connect sites, or anchors in body1, whose place in body2 MuJoCo works out."""
        lines = [
            f'<mujoco model="{self.name}">',
            '<compiler angle="radian"/>',
            "<worldbody>",
            *self._nested(self.root, by_sites),
            "</worldbody>",
        ]
        lines.append("<equality>")
        for pin in self.pins:
            where = f'site1="{pin.name}_1" site2="{pin.name}_2"'
            if not by_sites:
                where = f'body1="{pin.link1}" body2="{pin.link2}" anchor="{_text(pin.point1)}"'
            lines.append(f'<connect name="{pin.name}" {where}/>')
        for bearing in self.bearings:
            if bearing.mimic:
                leader, ratio = bearing.mimic
                lines.append(f'<joint joint1="{bearing.name}" joint2="{leader}" polycoef="0 {ratio!r} 0 0 0"/>')
        lines += ["</equality>", "<actuator>", *(f'<motor joint="{driver}"/>' for driver in self.drivers), "</actuator>", "</mujoco>"]
        return "\n".join(lines)

    def _nested(self, name, by_sites):
        body = next(body for body in self.bodies if body.name == name)
        carrier = next((bearing for bearing in self.bearings if bearing.child == name), None)
        place = np.eye(4) if carrier is None else carrier.place
        yield f'<body name="{name}" pos="{_text(place[:3, 3])}" quat="{_text(_quaternion(place[:3, :3]))}">'
        if body.mass is not None:
            t = body.tensor
            moments = _text([t[0, 0], t[1, 1], t[2, 2], t[0, 1], t[0, 2], t[1, 2]])
            yield f'<inertial pos="{_text(body.centre)}" mass="{body.mass!r}" fullinertia="{moments}"/>'
        if carrier is not None and carrier.type != "fixed":
            kind = "slide" if carrier.type == "prismatic" else "hinge"
            yield f'<joint name="{carrier.name}" type="{kind}" axis="{_text(carrier.axis)}"/>'
        for pin in self.pins if by_sites else ():
            for k, link, point in ((1, pin.link1, pin.point1), (2, pin.link2, pin.point2)):
                if link == name:
                    yield f'<site name="{pin.name}_{k}" pos="{_text(point)}"/>'
        for bearing in self.bearings:
            if bearing.parent == name:
                yield from self._nested(bearing.child, by_sites)
        yield "</body>"

    # --------------------------------------------------------------------------------------------------------------------------- SDF

    def sdf(self, version="1.11"):
        """In 1.6 all links are posed in the model, in later versions each in its parent."""
        lines = [f'<sdf version="{version}">', f'<model name="{self.name}">']
        for body in self.bodies:
            lines.append(f'<link name="{body.name}">')
            carrier = next((bearing for bearing in self.bearings if bearing.child == body.name), None)
            if carrier is not None:
                old = version < "1.7"
                place = self.places[body.name] if old else carrier.place
                relative = "" if old else f' relative_to="{carrier.parent}"'
                lines.append(f"<pose{relative}>{_text(place[:3, 3])} {_text(_rpy(place[:3, :3]))}</pose>")
            if body.mass is not None:
                moments = "".join(
                    f"<i{'xyz'[i]}{'xyz'[j]}>{float(body.tensor[i, j])!r}</i{'xyz'[i]}{'xyz'[j]}>" for i in range(3) for j in range(i, 3)
                )
                centre = f"<pose>{_text(body.centre)} 0 0 0</pose>"
                lines.append(f"<inertial>{centre}<mass>{body.mass!r}</mass><inertia>{moments}</inertia></inertial>")
            lines.append("</link>")
        lines.append(f'<joint name="to_world" type="fixed"><parent>world</parent><child>{self.root}</child></joint>')
        for bearing in self.bearings:
            lines.append(f'<joint name="{bearing.name}" type="{bearing.type}">')
            lines.append(f"<parent>{bearing.parent}</parent><child>{bearing.child}</child>")
            mimic = ""
            if bearing.mimic:
                mimic = f'<mimic joint="{bearing.mimic[0]}"><multiplier>{bearing.mimic[1]!r}</multiplier></mimic>'
            if bearing.type != "fixed":
                lines.append(f"<axis><xyz>{_text(bearing.axis)}</xyz>{mimic}</axis>")
            lines.append("</joint>")
        for pin in self.pins:
            lines.append(f'<joint name="{pin.name}" type="ball"><pose>{_text(pin.point2)} 0 0 0</pose>')
            lines.append(f"<parent>{pin.link1}</parent><child>{pin.link2}</child></joint>")
        names = "".join(f"<joint_name>{driver}</joint_name>" for driver in self.drivers)
        lines.append(f'<plugin filename="gz-sim-joint-controller-system" name="gz::sim::systems::JointController">{names}</plugin>')
        return "\n".join([*lines, "</model>", "</sdf>"])


FORMATS = {
    "drake": (Press.drake, "urdf"),
    "bushings": (Press.bushings, "urdf"),
    "urdf_plus": (Press.urdf_plus, "urdf"),
    "gazebo": (Press.gazebo, "urdf"),
    "mjcf": (Press.mjcf, "xml"),
    "mjcf_anchors": (lambda press: press.mjcf(by_sites=False), "mjcf"),
    "sdf": (Press.sdf, "sdf"),
    "sdf_1_6": (lambda press: press.sdf("1.6"), "sdf"),
}
"""How a press is written in each, and the ending of the file."""


def _body(link):
    inertial = link.find("inertial")
    if inertial is None:
        return Body(link.get("name"), None, np.zeros(3), np.zeros((3, 3)))
    place = _place(inertial.find("origin"))
    moments = {name: float(value) for name, value in inertial.find("inertia").attrib.items()}
    tensor = np.array([[moments["i" + "".join(sorted((a, b)))] for b in "xyz"] for a in "xyz"])
    turned = place[:3, :3]
    return Body(link.get("name"), float(inertial.find("mass").get("value")), place[:3, 3], turned @ tensor @ turned.T)


def _bearing(joint):
    parent, child = (joint.find(end).get("link") for end in ("parent", "child"))
    axis, mimic = joint.find("axis"), joint.find("mimic")
    follows = None if mimic is None else (mimic.get("joint"), float(mimic.get("multiplier", "1")))
    direction = _numbers("1 0 0" if axis is None else axis.get("xyz"))
    return Bearing(joint.get("name"), joint.get("type"), parent, child, _place(joint.find("origin")), direction, follows)


def _place(origin):
    place = np.eye(4)
    if origin is not None:
        roll, pitch, yaw = _numbers(origin.get("rpy", "0 0 0"))
        place[:3, :3] = _about(2, yaw) @ _about(1, pitch) @ _about(0, roll)
        place[:3, 3] = _numbers(origin.get("xyz", "0 0 0"))
    return place


def _about(axis, angle):
    turned, i, j = np.eye(3), (axis + 1) % 3, (axis + 2) % 3
    turned[i, i] = turned[j, j] = np.cos(angle)
    turned[j, i], turned[i, j] = np.sin(angle), -np.sin(angle)
    return turned


def _rpy(turned):
    across = np.hypot(turned[0, 0], turned[1, 0])
    pitch = np.arctan2(-turned[2, 0], across)
    if across < 1e-12:
        return np.array([0.0, pitch, np.arctan2(-turned[0, 1], turned[1, 1])])
    return np.array([np.arctan2(turned[2, 1], turned[2, 2]), pitch, np.arctan2(turned[1, 0], turned[0, 0])])


def _quaternion(turned):
    """w first, by Shepperd's method."""
    products = np.array([np.trace(turned), *np.diag(turned)])
    k = int(np.argmax(products))
    if k == 0:
        parts = [1 + products[0], turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]]
    else:
        i, j, m = (k - 1) % 3, k % 3, (k + 1) % 3
        parts = [turned[m, j] - turned[j, m], 0.0, 0.0, 0.0]
        parts[1 + i] = 1 + turned[i, i] - turned[j, j] - turned[m, m]
        parts[1 + j] = turned[i, j] + turned[j, i]
        parts[1 + m] = turned[i, m] + turned[m, i]
    return np.array(parts) / np.linalg.norm(parts)


def _numbers(text):
    return np.array(text.split(), dtype=float)


def _text(numbers):
    return " ".join(repr(float(number)) for number in numbers)
