"""What a URDF says: its links, joints, loops and drivers, and which links make one body.

The URDF may have errors, which `checks.elements` finds: what is missing or no number has its default here, and names of links and joints
that are not written are empty.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from functools import cached_property
from typing import Any

from ..common.arguments import LARGEST
from ..common.parameters import Checked, parameter
from ..common.quantities import Values
from ..engines.machine_elements.cams import CamPoint
from .element import Element

# Limits of a URDF: the largest that comes with pinpress has 13 joints and 4 loops.
MOST = dict.fromkeys(("link", "joint", "relation", "joint_spring", "armature", "material"), 1000) | dict.fromkeys(
    ("loop_joint", "transmission", "gear_mesh", "rack", "screw", "worm", "cam"), 500
)
DEEPEST_JOINTS = 500  # most joints from the root to a link: Pinocchio's parser calls itself for each, and ends the process after 2000

FREE = ("_x", "_y", "_z", "_rz", "_ry", "_rx")
"""Ends of the names of the six joints of a free body: three slides, then turns about z, y and x, each about the axis that the turns before
have reached."""

Point = tuple[float, float, float]


@dataclass(frozen=True)
class LoopEnd:
    """One side of a loop: a frame on a link, by its position [m] and its roll, pitch and yaw [rad]."""

    link: str
    xyz: Point
    rpy: Point


@dataclass(frozen=True)
class Loop:
    """A ``<loop_joint>``, "spherical", "revolute" or "fixed": the bearing that closes a loop of the linkage."""

    name: str
    type: str
    link1: LoopEnd
    link2: LoopEnd
    axis: Point  # of a revolute loop in the frames of both sides
    line: int


@dataclass(frozen=True)
class Mimic:
    """A gear pair, ``<mimic>``: the joint's coordinate is multiplier x coordinate of the leader + offset [rad or m]."""

    leader: str
    multiplier: float
    offset: float
    line: int


@dataclass(frozen=True)
class Joint:
    """A ``<joint>`` of the tree, "continuous", "revolute", "prismatic" or "fixed"."""

    name: str
    type: str
    parent: str
    child: str
    xyz: Point  # of its origin in the frame of the parent link [m]
    limits: tuple[float, float] | None  # of a revolute or prismatic joint, 0 where one is not written [rad or m]
    mimic: Mimic | None
    line: int


@dataclass(frozen=True)
class Relation:
    """A ``<relation>``: the sum of coefficient x coordinate of its joints is the offset [unit of the first joint: rad or m]. It determines
    the first joint."""

    name: str
    joints: tuple[str, ...]
    coefficients: tuple[float, ...]
    offset: float
    line: int


@dataclass(frozen=True)
class JointSpring(Checked):
    """A spring and a damper in a joint: ``<joint_spring>`` of a URDF.

    The effort on the joint along its axis is -stiffness x (coordinate - reference) - damping x rate [N m; of a joint that slides N].

    Attributes:
        joint: name of the joint.
        stiffness: [N m/rad; of a joint that slides N/m].
        reference: coordinate of the joint at which the spring is slack [rad or m].
        damping: [N m s/rad; of a joint that slides N s/m].

    Raises:
        PinpressError: stiffness or damping is negative, or a number is not finite.
    """

    joint: str
    stiffness: float = field(default=0.0, metadata=parameter("N m/rad", "not negative"))
    reference: float = field(default=0.0, metadata=parameter("rad"))
    damping: float = field(default=0.0, metadata=parameter("N m s/rad", "not negative"))

    def effort(self, coordinate: Values, rate: Values) -> Values:
        """The effort at a coordinate [rad or m] and its rate [rad/s or m/s]: numbers or (n,) [N m; of a joint that slides N]."""
        return self.stiffness * (self.reference - coordinate) - self.damping * rate


@dataclass(frozen=True)
class GearMesh:
    """A ``<gear_mesh>``: two gears, named by their links, whose centres one link carries. Attributes are those of the element.

    An internal gear has a negative number of teeth. ``carrier`` is the link that holds both centres; if empty, it is found. ``hand`` is the
    hand of the helix of gear 1. Angles are in degrees, ``module`` is that of the normal section [m]; 0: it follows from the drawn centre
    distance. ``center1`` and ``center2`` are points in the frames of the gears' links [m], None for a pin of the gear.
    """

    name: str
    gear1: str
    gear2: str
    teeth1: float
    teeth2: float
    carrier: str = ""
    pressure_angle: float = 20.0
    helix: float = 0.0
    hand: str = "right"
    double_helical: bool = False
    module: float = 0.0
    efficiency: float = 1.0
    planets: float = 1.0
    center1: Point | None = None
    center2: Point | None = None
    line: int = 0


@dataclass(frozen=True)
class Rack:
    """A ``<rack>``: a pinion and a rack, named by their links; a link carries the pinion's axis and guides the rack.

    ``radius`` is that of the pinion's pitch circle [m]; 0 where ``module`` [m] and ``teeth`` say it. The pinion lies on the ``side`` of the
    rack, "left" or "right", seen with the rack's guide pointing up (a horizontal one along its axis) and the pinion's axis towards the
    viewer; empty where the drawing says it. ``hand`` is that of the pinion's helix. Angles are in degrees.
    """

    name: str
    pinion: str
    rack: str
    radius: float = 0.0
    module: float = 0.0
    teeth: float = 0.0
    side: str = ""
    carrier: str = ""
    pressure_angle: float = 20.0
    helix: float = 0.0
    hand: str = "right"
    efficiency: float = 1.0
    line: int = 0


@dataclass(frozen=True)
class Screw:
    """A ``<screw>``: a screw and its nut, named by their links.

    ``lead`` is the travel in one turn [m]. A right-handed screw moves along an axis, against its nut, where it turns positively about that
    axis. ``diameter`` is the mean one of the thread [m], ``flank`` the angle between flank and the plane across the axis [deg], and
    ``friction`` the coefficient there. The collar, between screw and the link that carries its axis, has a mean ``collar_diameter`` [m].
    """

    name: str
    screw: str
    nut: str
    lead: float
    diameter: float = 0.0
    flank: float = 15.0
    friction: float = 0.0
    hand: str = "right"
    collar_friction: float = 0.0
    collar_diameter: float = 0.0
    line: int = 0


@dataclass(frozen=True)
class Worm:
    """A ``<worm>``: a worm and its wheel, named by their links, with axes at a right angle that one link carries.

    ``quotient`` is the pitch diameter of the worm by the axial ``module`` [m]. One of the two may be 0: it then follows from the drawn
    centre distance.
    """

    name: str
    worm: str
    wheel: str
    starts: float
    teeth: float
    module: float = 0.0
    quotient: float = 0.0
    carrier: str = ""
    pressure_angle: float = 20.0
    friction: float = 0.0
    hand: str = "right"
    line: int = 0


@dataclass(frozen=True)
class Cam:
    """A ``<cam>``: a cam and the follower that its roller moves, named by their links.

    One link carries the axis of the cam, and guides the follower or carries the pivot of its arm. ``radius`` is the distance of the
    roller's centre from the axis of the cam at the lift 0 [m], ``offset`` that of the guide, positive to the right with the lift upwards
    and positive angles of the cam counter-clockwise [m]; ``arm`` the length from the pivot to the roller's centre [m]. In place of offset
    or arm, ``center`` may be the roller's centre in the frame of the follower's link [m]; the lift then leads away from the cam, else along
    the follower's coordinate. ``drawn_at`` is the angle of the law in the drawn pose [deg].

    ``points`` are ``<point>`` elements, the law over a turn, or ``<row>`` elements, a table of lifts: ``angle`` [deg], ``lift`` [m; of an
    arm deg], ``law`` of the piece that leads to the point, or ``slope`` and ``bend``, the derivatives of the lift by the angle in rad.
    """

    name: str
    cam: str
    follower: str
    radius: float
    roller_radius: float
    roller_width: float
    offset: float | None = None
    arm: float | None = None
    center: Point | None = None
    kind: str = "open"
    drawn_at: float | None = None
    points: tuple[CamPoint, ...] = ()
    tabulated: bool = False
    line: int = 0


MachineElement = GearMesh | Rack | Screw | Worm
MACHINE_ELEMENTS: dict[str, type[MachineElement]] = {"gear_mesh": GearMesh, "rack": Rack, "screw": Screw, "worm": Worm}
"""What the elements of teeth and threads are, by their tags."""


@dataclass(frozen=True)
class Description:
    """The contents of a URDF, in document order.

    Drivers are as `_drivers` finds them, each once; armature is the inertia of motors that turn with joints, by the names of these [kg m2
    or kg]; home are the joint coordinates in ``<home>`` [rad or m]."""

    name: str
    links: tuple[str, ...]
    joints: tuple[Joint, ...]
    loops: tuple[Loop, ...]
    drivers: tuple[str, ...]
    joint_springs: tuple[JointSpring, ...] = ()
    armature: Mapping[str, float] = field(default_factory=dict)
    relations: tuple[Relation, ...] = ()
    home: Mapping[str, float] = field(default_factory=dict)
    machine_elements: tuple[MachineElement, ...] = ()
    cams: tuple[Cam, ...] = ()

    @cached_property
    def elements(self) -> tuple[MachineElement | Cam, ...]:
        """All machine elements."""
        return (*self.machine_elements, *self.cams)

    @cached_property
    def types(self) -> dict[str, str]:
        """The type of each joint."""
        return {joint.name: joint.type for joint in self.joints}

    @cached_property
    def carriers(self) -> dict[str, Joint]:
        """The joint that carries each link that joints connect to the root, each link behind the one that carries it."""
        below: dict[str, list[Joint]] = {}
        for joint in self.joints:
            below.setdefault(joint.parent, []).append(joint)
        carriers: dict[str, Joint] = {}
        reached = [self.root] if self.root else []
        for link in reached:  # grows as it goes
            for joint in below.get(link, ()):
                if joint.child not in carriers and joint.child != self.root:
                    carriers[joint.child] = joint
                    reached.append(joint.child)
        return carriers

    @cached_property
    def root(self) -> str:
        """Name of the first link that is no joint's child, the frame; empty if every link is one."""
        children = {joint.child for joint in self.joints}
        return next((link for link in self.links if link and link not in children), "")

    @cached_property
    def bodies(self) -> dict[str, str]:
        """For each link connected to the root, root first: the first link of its body, of those that fixed joints weld together."""
        bodies = {self.root: self.root} if self.root else {}
        for link, joint in self.carriers.items():
            bodies[link] = bodies[joint.parent] if joint.type == "fixed" else link
        return bodies

    @cached_property
    def bases(self) -> dict[str, tuple[str, ...]]:
        """Names of the six joints of every free body, by the name that they share."""
        chains: dict[str, tuple[str, ...]] = {}
        by_name = {joint.name: joint for joint in self.joints}
        for name in (joint.name.removesuffix(FREE[0]) for joint in self.joints if joint.name.endswith(FREE[0])):
            chain = [by_name.get(name + free) for free in FREE]
            if all(below and above and below.parent == above.child for above, below in itertools.pairwise(chain)):
                chains[name] = tuple(name + free for free in FREE)
        return chains

    @cached_property
    def guided(self) -> dict[str, str]:
        """The links that prismatic joints guide on the frame, and names of these joints, except the slides of free bodies."""
        free = {joint for chain in self.bases.values() for joint in chain}
        prismatic = (joint for joint in self.joints if joint.type == "prismatic" and joint.name not in free)
        joints = (joint for joint in prismatic if self.bodies[joint.parent] == self.root)
        return {joint.child: joint.name for joint in joints}

    @cached_property
    def pins(self) -> dict[str, list[Point]]:
        """Places of each link's joints and loops in its own frame [m]."""
        pins: dict[str, list[Point]] = {link: [(0.0, 0.0, 0.0)] for link in self.links}
        for joint in self.joints:
            pins[joint.parent].append(joint.xyz)
        for loop in self.loops:
            for end in (loop.link1, loop.link2):
                pins[end.link].append(end.xyz)
        return pins

    @cached_property
    def turning(self) -> set[str]:
        """Names of the links that a joint may turn."""
        links: set[str] = set()
        for link, joint in self.carriers.items():
            if joint.type in ("revolute", "continuous") or joint.parent in links:
                links.add(link)
        return links

    def moves(self, link: str) -> bool:
        """Whether joints connect a link to the frame and it is not welded to that."""
        return self.bodies.get(link, self.root) != self.root

    def is_on_frame(self, link: str) -> bool:
        """Whether the joint that lets a link move stands on the frame."""
        return self.bodies[self.carriers[self.bodies[link]].parent] == self.root


def describe(robot: Element) -> Description:
    """The contents of a URDF, given its root element."""
    links = tuple(link.get("name") for link in robot.all("link"))
    joints = tuple(_joint(joint) for joint in robot.all("joint"))
    loops = tuple(_loop(loop) for loop in robot.all("loop_joint"))
    drivers = tuple(dict.fromkeys(_drivers(robot)))
    springs = tuple(_joint_spring(spring) for spring in robot.all("joint_spring"))
    armature = {element.get("joint"): element.number("inertia", 0.0) for element in robot.all("armature")}
    relations = tuple(_relation(relation) for relation in robot.all("relation"))
    home = {joint.get("name"): joint.number("position", 0.0) for home in robot.all("home") for joint in home.all("joint")}
    elements = tuple(_contents(element, MACHINE_ELEMENTS[element.tag]) for element in robot.all(*MACHINE_ELEMENTS))
    cams = tuple(map(_cam, robot.all("cam")))
    return Description(robot.get("name"), links, joints, loops, drivers, springs, armature, relations, home, elements, cams)


def _drivers(robot: Element) -> list[str]:
    """Names of the joints in ``<transmission>``; if there is none, of those with a ``<command_interface>`` in ``<ros2_control>``; if there
    is none either, of those that URDF+ calls ``independent="true"``."""
    joints = [joint for transmission in robot.all("transmission") for joint in transmission.all("joint")]
    joints = joints or [joint for part in robot.all("ros2_control") for joint in part.all("joint") if joint.all("command_interface")]
    independent = (joint for joint in robot.all("joint") if joint.get("independent").lower() == "true" and joint.get("type") != "fixed")
    return [joint.get("name") for joint in joints or independent]


def names(robot: Element, tag: str) -> list[str]:
    """Names of the elements with a tag that have one."""
    return [name for element in robot.all(tag) if (name := element.get("name"))]


def has_mass(link: Element) -> bool:
    """Whether a link has a mass of its own."""
    return any(mass.number("value", 0.0) > 0.0 for inertial in link.all("inertial") for mass in inertial.all("mass"))


def _joint(joint: Element) -> Joint:
    kind, limits, mimic = joint.get("type"), None, None
    for limit in joint.all("limit") if kind in ("revolute", "prismatic") else ():
        limits = limit.number("lower", 0.0), limit.number("upper", 0.0)
        # Some programs write 1e16, 1e30 or the largest number of a computer where there is no limit.
        limits = None if limits[0] <= -LARGEST and limits[1] >= LARGEST else limits
    for element in joint.all("mimic")[:1]:
        mimic = Mimic(element.get("joint"), element.number("multiplier", 1.0), element.number("offset", 0.0), element.line)
    parent, child = joint.of_child("parent", "link"), joint.of_child("child", "link")
    return Joint(joint.get("name"), kind, parent, child, _point(joint, "origin", "xyz"), limits, mimic, joint.line)


def _joint_spring(spring: Element) -> JointSpring:
    stiffness, damping = (max(spring.number(name, 0.0), 0.0) for name in ("stiffness", "damping"))
    return JointSpring(spring.get("joint"), stiffness, spring.number("reference", 0.0), damping)


def _relation(relation: Element) -> Relation:
    joints = relation.all("joint")
    coefficients = tuple(joint.number("coefficient", 1.0) for joint in joints)
    name, offset = relation.get("name"), relation.number("offset", 0.0)
    return Relation(name, tuple(joint.get("name") for joint in joints), coefficients, offset, relation.line)


def _contents(element: Element, kind: type, **contents: Any) -> Any:
    """What an element says, read by the types of the fields of a class; ``contents``: fields that are no attributes."""
    for each in fields(kind):
        default = None if each.default is MISSING else each.default
        if each.name == "line":
            contents["line"] = element.line
        elif each.type.startswith("Point"):
            contents[each.name] = element.numbers(each.name) or None
        elif each.type.startswith("float"):
            contents[each.name] = element.number(each.name, 0.0 if each.default is MISSING else default)
        elif each.type == "bool" and each.name not in contents:
            contents[each.name] = element.get(each.name).lower() == "true"
        elif each.type == "str":
            contents[each.name] = element.get(each.name) or default or ""
    return kind(**contents)


def _cam(element: Element) -> Cam:
    """A cam; its points are in the units of the file."""
    points = (
        CamPoint(
            each.number("angle", 0.0), each.number("lift", 0.0), each.get("law"), each.number("slope", None), each.number("bend", None)
        )
        for each in element.all("point", "row")
    )
    cam: Cam = _contents(element, Cam, points=tuple(points), tabulated=bool(element.all("row")))
    return cam


def _loop(loop: Element) -> Loop:
    end1, end2 = (LoopEnd(loop.of_child(end, "link"), _point(loop, end, "xyz"), _point(loop, end, "rpy")) for end in ("link1", "link2"))
    axis = _point(loop, "axis", "xyz", (1.0, 0.0, 0.0))  # the default of URDF's <axis>
    return Loop(loop.get("name"), loop.get("type"), end1, end2, axis, loop.line)


def _point(element: Element, tag: str, name: str, default: Point = (0.0, 0.0, 0.0)) -> Point:
    """Three numbers of the first child with a tag."""
    x, y, z = next((child.numbers(name) for child in element.all(tag)), ()) or default
    return x, y, z
