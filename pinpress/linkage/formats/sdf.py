"""SDF, the format of Gazebo: models of links and joints that need not be a tree (sdformat.org/spec, versions 1.4 to 1.12).

A link may be the child of several joints: the joints of the tree are chosen here, and the others close loops. Names of links and joints
are kept. SDF is read here because the bindings of its own library on PyPI are for Python 3.11 alone, and Pinocchio's wheels are built
without it (`WITH_SDFORMAT`). Elements that make a linkage are read, those that say nothing of its mechanics are passed over, and all others
are refused by name.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from ...common.arguments import LARGEST
from ...common.errors import suggestion
from ...common.quantities import Array
from ..description import DEEPEST_JOINTS, MOST
from ..document import Document, Finding, Origin
from ..element import NUMBER, Element, tree
from .dialects import BALL, BUSHING, SPRING, bushing_remark, drake_loop, spring_remark
from .elements import (
    ALONE,
    direction,
    find_child,
    make_unique,
    need_child,
    numbers,
    origin_of,
    pose_and_rounding,
    refuse,
    refuse_unknown,
    refuse_unknown_attributes,
    remark,
    take,
)
from .mechanism import (
    TYPES_OF_LOOPS,
    Edge,
    Follow,
    Inertia,
    Joint,
    Link,
    Loop,
    Mechanism,
    Relation,
    Shape,
    Spring,
    as_document,
    capsule,
    in_series,
    spanning_tree,
)

WORLD = "world"
# Elements of a joint in SDF of ours, which other programs skip: of one that closes a loop, and the inertia of its rotor [kg m2 or kg].
CLOSES, ARMATURE = "pinpress:closes_loop", "pinpress:armature"
_MODEL = "__model__"

_KNOWN = {  # elements that are read or say nothing of the mechanics
    "sdf": "model world light actor",
    "world": "model include physics light scene gravity magnetic_field atmosphere spherical_coordinates gui audio wind plugin frame"
    " actor road population state",
    "model": "static self_collide allow_auto_disable enable_wind pose link joint frame plugin include model gripper",
    "link": "gravity enable_wind self_collide kinematic must_be_base_link velocity_decay pose inertial collision visual sensor projector"
    " audio_sink audio_source battery light particle_emitter",
    "inertial": "pose mass inertia density auto_inertia_params fluid_added_mass",
    "inertia": "ixx ixy ixz iyy iyz izz",
    "joint": "pose parent child axis axis2 gearbox_ratio gearbox_reference_body thread_pitch screw_thread_pitch physics sensor",
    "axis": "xyz use_parent_model_frame initial_position dynamics limit mimic",
    "dynamics": "damping friction spring_reference spring_stiffness",
    "limit": "lower upper effort velocity stiffness dissipation",
    "mimic": "multiplier offset reference",
}
_ATTRIBUTES = {  # attributes of elements that are read
    "model": "name canonical_link placement_frame",
    "link": "name",
    "joint": "name type",
    "frame": "name attached_to",
    "pose": "relative_to frame degrees rotation_format",
    "inertial": "auto",
    "axis": "",
    "axis2": "",
    "xyz": "expressed_in",
    "mimic": "joint axis",
}
_UNSEARCHED = ("plugin", "sensor", "collision", "physics")  # say nothing of the mechanics
_TURNING = ("revolute", "continuous")
_CHAINS = {"ball": 3, "universal": 2, "revolute2": 2}  # numbers of revolute joints that make such a joint of the tree
_SCREW = "screw"  # a revolute joint, and a prismatic one that follows it


def read(document: Document) -> Document:
    """The URDF that says the same as an SDF; raises UrdfError if that is no linkage."""
    root = tree(document.file, document.text.decode("utf-8-sig").encode(), with_text=True)
    return as_document(document.file, _Reader(document.file, root).mechanism(), f"SDF {root.get('version')}")


@dataclass(frozen=True, eq=False)
class _Bearing:
    """A ``<joint>`` of the file: its name and type in SDF, names of its parent and child links, and its pose in the model."""

    element: Element
    name: str
    type: str
    parent: str
    child: str
    place: pin.SE3


class _Reader:
    """Reads the one model of a file that moves."""

    def __init__(self, file: str, root: Element) -> None:
        self.file = file
        major, _, minor = root.get("version").partition(".")
        if not (major.isdecimal() and minor.isdecimal() and int(major) == 1):
            refuse(file, root, f"unknown version {root.get('version')!r} of SDF", 'write version="1.6" or another from 1.4 on')
        self.version = int(major), int(minor)
        self.remarks: list[Finding] = []
        self.balls: list[tuple[str, ...]] = []
        self.model = self._only_model(root)
        refuse_unknown(file, self.model, _KNOWN["model"].split())
        self._refuse_attributes(self.model)
        for tag, remedy in (("include", "write the model that it names in its place"), ("model", "write its links and joints in this one")):
            for element in self.model.all(tag):
                refuse(file, element, f"<{tag}> in a <model> cannot be read", remedy)
        for element in self.model.all("gripper"):
            refuse(file, element, "a gripper cannot be read", "write a fixed joint")
        if self._true(self.model, "static"):
            refuse(file, self.model.all("static")[0], "a static model does not move", "remove <static>")
        self.links = self._by_name("link")
        self.joints = self._by_name("joint")
        self.frames = self._by_name("frame")
        self.taken = {*self.links, *self.joints}  # names that no part made here may have
        self.posed: dict[str, pin.SE3] = {}
        self.searched: list[str] = []  # names whose poses are being searched
        self.model_place = self._model_place()

    # ------------------------------------------------------------------------------------------------------------------------- the file

    def _only_model(self, root: Element) -> Element:
        refuse_unknown(self.file, root, _KNOWN["sdf"].split())
        models = list(root.all("model"))
        for world in root.all("world"):
            refuse_unknown(self.file, world, _KNOWN["world"].split())
            models += world.all("model")
            for element in world.all("include"):
                self.remarks.append(remark("warning", element, "<include> is not read", "write the model in its place, if it is the press"))
            for element in world.all("gravity"):
                gravity = numbers(self.file, element, element.text, 3)
                if abs(gravity - [0.0, 0.0, -9.81]).max() > 0.02:  # -9.8 is Gazebo's own
                    remedy = f"load(..., gravity=({', '.join(f'{part:g}' for part in gravity)}))"
                    self.remarks.append(remark("warning", element, "the gravity of the world is not read", remedy))
        moving = [model for model in models if not self._true(model, "static")]
        if len(moving) != 1:
            where = moving[1] if moving else root
            refuse(self.file, where, f"there are {len(moving) or 'no'} models that move", "write the one <model> that is the press")
        return moving[0]

    def _refuse_attributes(self, element: Element) -> None:
        """Raise UrdfError if an element, or one in it, has an attribute that is none of SDF."""
        if element.tag in _ATTRIBUTES:
            refuse_unknown_attributes(self.file, element, _ATTRIBUTES[element.tag].split())
        for child in element.children:
            if child.tag not in _UNSEARCHED and ":" not in child.tag:
                self._refuse_attributes(child)

    def _by_name(self, tag: str) -> dict[str, Element]:
        named: dict[str, Element] = {}
        elements, most = self.model.all(tag), MOST["joint"]
        if len(elements) > most:
            refuse(self.file, elements[most], f"there are {len(elements)} <{tag}>, more than {most}", ALONE)
        for element in elements:
            name = element.get("name")
            if not name:
                refuse(self.file, element, "has no name", f'write <{tag} name="...">')
            if name in named:
                problem = f"the name is already that of the <{tag}> on line {named[name].line}"
                refuse(self.file, element, problem, f"give each <{tag}> its own name")
            named[name] = element
        return named

    def _true(self, element: Element, tag: str) -> bool:
        child = find_child(self.file, element, tag)
        return child is not None and child.text.strip().lower() in ("1", "true")

    def _number(self, element: Element | None, tag: str, default: float) -> float:
        """The number in a child; the default if there is no child, or an empty one."""
        child = None if element is None else find_child(self.file, element, tag)
        return default if child is None or not child.text.strip() else float(numbers(self.file, child, child.text, 1)[0])

    # --------------------------------------------------------------------------------------------------------------------------- places

    def _pose(self, element: Element) -> pin.SE3:
        """The pose of an element, in the frame to which it is relative."""
        pose = find_child(self.file, element, "pose")
        if pose is None:
            return pin.SE3.Identity()
        place, rounded = pose_and_rounding(self.file, pose)
        if rounded and not any("quarter turn" in each.problem for each in self.remarks):
            problem = "angles such as 1.5708 are read as quarter turns, which they are to all their digits"
            self.remarks.append(remark("note", pose, problem, "write 1.5707963267948966, or an angle that is none"))
        return place

    def _model_place(self) -> pin.SE3:
        """The pose of the model in the world. Its ``<pose>`` may be that of another frame in it, its ``placement_frame``."""
        for pose in self.model.all("pose"):
            named = pose.get("relative_to") or pose.get("frame")
            if named not in ("", WORLD):
                refuse(self.file, pose, f"the pose of the model is relative to {named!r}, which is not read", "write its pose in the world")
        frame, pose = self.model.get("placement_frame"), self._pose(self.model)
        if not frame:
            return pose
        self.searched.append(WORLD)
        place = pose * self.place(frame, self.model).inverse()
        self.searched.pop()
        return place

    def place(self, name: str, at: Element) -> pin.SE3:
        """The pose of a link, joint or frame in the model, by its name; ``at``: the element that names it."""
        if name in (_MODEL, ""):
            return pin.SE3.Identity()
        if name == WORLD:
            if WORLD in self.searched:
                problem = (
                    f"its placement_frame {self.model.get('placement_frame')!r} stands in the world, so that it does not place the model"
                )
                refuse(self.file, self.model, problem, "name a frame of the model")
            return self.model_place.inverse()
        if name not in self.posed:
            element = self.links.get(name) or self.frames.get(name) or self.joints.get(name)
            if element is None:
                names = [*self.links, *self.joints, *self.frames]
                refuse(self.file, at, f"no frame {name!r}{suggestion(name, names)}", "name a link, joint or frame of this model")
            if name in self.searched:
                refuse(self.file, element, "its pose is relative to itself", "let the poses lead back to the model")
            if len(self.searched) > DEEPEST_JOINTS:
                refuse(self.file, element, f"its pose is more than {DEEPEST_JOINTS} frames away from the model's", ALONE)
            self.searched.append(name)
            pose = self._pose(element)
            self.posed[name] = self.place(self._relative_to(element), element) * pose
            self.searched.pop()
        return self.posed[name]

    def _relative_to(self, element: Element) -> str:
        """Name of the frame to which the pose of an element is relative."""
        for pose in element.all("pose"):
            if pose.get("frame"):
                refuse(self.file, pose, "frame=... of SDF 1.5 and 1.6 has no meaning that programs agree on", "leave it out, or use 1.7")
            if pose.get("relative_to"):
                return pose.get("relative_to")
        if element.tag == "joint":
            return need_child(self.file, element, "child").text.strip()
        return element.get("attached_to") if element.tag == "frame" else _MODEL

    def _link_of(self, name: str, at: Element) -> str:
        """Name of the link to which a frame is fixed; ``at``: the element that names it."""
        seen: list[str] = []
        while name not in self.links and name not in (WORLD, *seen):
            seen.append(name)
            if name in self.frames:
                name = self.frames[name].get("attached_to") or next(iter(self.links), WORLD)
            elif name in self.joints:
                name = need_child(self.file, self.joints[name], "child").text.strip()
        if name not in (WORLD, *self.links):
            refuse(self.file, at, f"no link {name!r}{suggestion(name, self.links)}", "name a <link> of this model")
        return name

    # ------------------------------------------------------------------------------------------------------------------------ mechanism

    def mechanism(self) -> Mechanism:
        if not self.links:
            refuse(self.file, self.model, "has no <link>", "write the links and joints of the linkage")
        bearings = {name: self._bearing(name, element) for name, element in self.joints.items()}
        geared = {name: bearing for name, bearing in bearings.items() if bearing.type == "gearbox"}
        holding = [bearing for name, bearing in bearings.items() if name not in geared]
        root, held = self._root(holding)
        names = [WORLD, *self.links] if root == WORLD else list(self.links)
        chosen = spanning_tree(root, names, [Edge(b.parent, b.child, _rank(b)) for b in holding])
        if chosen.lost:
            lost = self.links[chosen.lost[0]]
            refuse(self.file, lost, f"no joint connects it to {root!r}", "connect it with a <joint>")
        carried: dict[str, _Bearing] = {}
        turned_round: set[str] = set()
        for k, child in chosen.tree.items():
            carried[child] = holding[k]
            if child != holding[k].child:
                turned_round.add(holding[k].name)
        frames = {name: self._frame(name, carried.get(name)) for name in self.links} | {WORLD: self.place(WORLD, self.model)}
        links, joints, chains = [], [held] if held else [], []
        if root == WORLD or held:
            links.append(Link(WORLD, None, (), origin_of(self.model)))
        for name, element in self.links.items():
            links.append(self._link(name, element, frames[name].inverse() * self.place(name, element)))
        order = {id(bearing): k for k, bearing in enumerate(holding)}
        for child, bearing in sorted(carried.items(), key=lambda pair: order[id(pair[1])]):
            parent = bearing.parent if child == bearing.child else bearing.child
            made, between = self._joint(bearing, parent, child, frames, bearing.name in turned_round)
            joints += made
            chains += between
        loops = [self._loop(bearing, frames) for bearing in holding if bearing not in carried.values()]
        loops += self._drake_loops(frames)
        joints, relations = self._with_gears(joints, geared, carried, frames)
        for name in sorted(turned_round):
            bearing = bearings[name]
            problem = f"the tree reaches {bearing.parent!r} through {bearing.child!r}: its force is that of {bearing.child!r} on the other"
            self.remarks.append(remark("note", bearing.element, problem, "exchange <parent> and <child> for the other sign"))
        drivers = tuple(self._drivers({joint.name for joint in joints}))
        name, origin = self.model.get("name") or "press", origin_of(self.model)
        balls, remarks = tuple(self.balls), tuple(self.remarks)
        return Mechanism(name, (*links, *chains), tuple(joints), tuple(loops), drivers, remarks, origin, balls, tuple(relations))

    def _root(self, bearings: Sequence[_Bearing]) -> tuple[str, Joint | None]:
        """Name of the root link, and the joint that holds it: the world, if joints connect it, without such a joint; else the link that is
        no joint's child, with a free joint if it is not at the origin."""
        if any(WORLD in (bearing.parent, bearing.child) for bearing in bearings):
            return WORLD, None
        children = {bearing.child for bearing in bearings}
        free = [name for name in self.links if name not in children]
        first = free[0] if free else next(iter(self.links))
        place = self.model_place * self.place(first, self.links[first])
        name = make_unique(f"{first}_held", {*self.joints})
        if np.array_equal(place.homogeneous, np.eye(4)):
            problem = f"no joint connects the model to the world: link {first!r} is held where it is drawn"
            self.remarks.append(remark("warning", self.links[first], problem, "write a fixed joint whose parent is world"))
            return first, None
        return first, Joint(name, "floating", WORLD, first, place, np.array([1.0, 0.0, 0.0]), origin_of(self.links[first]))

    def _bearing(self, name: str, element: Element) -> _Bearing:
        refuse_unknown(self.file, element, _KNOWN["joint"].split())
        kind = element.get("type")
        types = [*_TURNING, "prismatic", "fixed", "gearbox", _SCREW, *_CHAINS]
        if kind not in types:
            remedies = {
                "planar": "write two prismatic joints and a revolute one, with links between them",
                "floating": "write the joints that guide the link",
            }
            remedy = remedies.get(kind, f"write one of: {', '.join(types)}")
            refuse(self.file, element, f"joint type {kind!r} cannot be read{suggestion(kind, types)}", remedy)
        parent, child = (need_child(self.file, element, end) for end in ("parent", "child"))
        ends = [self._link_of(end.text.strip(), end) for end in (parent, child)]
        if ends[0] == ends[1]:
            refuse(self.file, element, f"parent and child are the same link {ends[0]!r}", "write the two links that it connects")
        return _Bearing(element, name, kind, ends[0], ends[1], self.place(name, element))

    def _frame(self, link: str, carrier: _Bearing | None) -> pin.SE3:
        """The frame of a link as URDF has it: that in the file, with its origin moved to that of the joint about which it turns."""
        place = self.place(link, self.links[link])
        if carrier is None or carrier.type not in (*_TURNING, _SCREW, *_CHAINS):
            return place
        return pin.SE3(place.rotation, carrier.place.translation)

    def _axis(self, bearing: _Bearing, tag: str = "axis") -> Array:
        """(3,) axis of a joint in the model's frame."""
        element = need_child(self.file, bearing.element, tag)
        refuse_unknown(self.file, element, _KNOWN["axis"].split())
        xyz = find_child(self.file, element, "xyz")
        if xyz is None:
            return np.asarray(bearing.place.rotation[:, 2])
        axis = direction(self.file, xyz, xyz.text)
        in_model = self.version < (1, 5) or self._true(element, "use_parent_model_frame")
        if in_model and self.version < (1, 7):
            return axis
        named = xyz.get("expressed_in")
        rotation = self.place(named, xyz).rotation if named else bearing.place.rotation
        return np.asarray(rotation @ axis)

    def _joint(
        self, bearing: _Bearing, parent: str, child: str, frames: Mapping[str, pin.SE3], turned_round: bool
    ) -> tuple[list[Joint], list[Link]]:
        """A joint of the tree. One that turns about several axes becomes a joint for each, with links without mass between them."""
        place, origin = frames[parent].inverse() * frames[child], origin_of(bearing.element)
        sign = -1.0 if turned_round else 1.0
        if bearing.type == "fixed":
            return [Joint(bearing.name, "fixed", parent, child, place, np.array([1.0, 0.0, 0.0]), origin)], []
        to_child = frames[child].rotation.T
        if bearing.type in _CHAINS:
            axes = np.eye(3) if bearing.type == "ball" else np.array([to_child @ self._axis(bearing, tag) for tag in ("axis", "axis2")])
            if turned_round:
                axes = -axes[::-1]
            return self._chain(bearing, parent, child, place, axes)
        element = need_child(self.file, bearing.element, "axis")
        axis = sign * (to_child @ self._axis(bearing))
        dynamics, limit = find_child(self.file, element, "dynamics"), find_child(self.file, element, "limit")
        for part in (dynamics, limit):
            if part is not None:
                refuse_unknown(self.file, part, _KNOWN[part.tag].split())
        stiffness, reference, damping = (self._number(dynamics, name, 0.0) for name in ("spring_stiffness", "spring_reference", "damping"))
        effort, velocity = (self._limit(limit, name) for name in ("effort", "velocity"))
        made = Joint(
            bearing.name,
            "prismatic" if bearing.type == "prismatic" else "revolute",
            parent,
            child,
            place,
            axis,
            origin,
            limits=self._limits(bearing, limit),
            effort=effort if 0 <= effort < math.inf else None,
            velocity=velocity if 0 <= velocity < math.inf else None,
            damping=damping,
            friction=self._number(dynamics, "friction", 0.0),
            follow=self._mimic(bearing, element),
            spring=Spring(stiffness, reference, damping) if stiffness else None,
            armature=self._number(bearing.element, ARMATURE, 0.0),
        )
        return self._screw(bearing, made) if bearing.type == _SCREW else ([made], [])

    def _screw(self, bearing: _Bearing, turning: Joint) -> tuple[list[Joint], list[Link]]:
        """The joints of a screw: the one that turns, and one that slides with it. The lead [m a turn] of a right-hand thread is above 0."""
        lead, classic = (self._number(bearing.element, tag, 0.0) for tag in ("screw_thread_pitch", "thread_pitch"))
        if not lead and not classic:
            refuse(self.file, bearing.element, "has no pitch", "write <screw_thread_pitch>, in m a turn, above zero if it is right-handed")
        per_radian = lead / (2 * math.pi) if lead else -1 / classic  # <thread_pitch> is -2 pi / lead
        name, place = take(f"{bearing.name}_slide", self.taken), pin.SE3.Identity()
        follow = Follow(turning.name, per_radian, 0.0, turning.origin)
        sliding = Joint(name, "prismatic", "", "", place, turning.axis, turning.origin, follow=follow)
        problem = f"a screw joint is made of two: {turning.name}, which turns, and {name}, which slides with it"
        self.remarks.append(remark("note", bearing.element, problem, ""))
        return in_series([turning, sliding], turning.parent, turning.child, [take(f"{bearing.name}_1", self.taken)])

    def _limits(self, bearing: _Bearing, limit: Element | None) -> tuple[float, float] | None:
        lower, upper = self._limit(limit, "lower", -1.0), self._limit(limit, "upper")
        if bearing.type == "continuous" or (math.isinf(lower) and math.isinf(upper)):
            return None
        if lower > upper:
            refuse(self.file, limit or bearing.element, f"lower ({lower!r}) is above upper ({upper!r})", "exchange them")
        return max(lower, -1e9), min(upper, 1e9)

    def _limit(self, limit: Element | None, tag: str, sign: float = 1.0) -> float:
        """A limit, infinite in the direction of ``sign`` if there is none: not written, infinite, or larger than all numbers that enter
        computations, as are the 1e16 of the format itself and the largest number of a computer, which some programs write."""
        child = None if limit is None else find_child(self.file, limit, tag)
        word = "" if child is None else child.text.strip()
        value = float(word) if NUMBER.fullmatch(word) or word.lower().lstrip("+-") == "inf" else 0.0
        return sign * math.inf if not word or sign * value > LARGEST else self._number(limit, tag, 0.0)

    def _chain(self, bearing: _Bearing, parent: str, child: str, place: pin.SE3, axes: Array) -> tuple[list[Joint], list[Link]]:
        """Revolute joints in place of one that turns about several axes, and the links between them."""
        origin, here = origin_of(bearing.element), pin.SE3.Identity()
        between = [take(f"{bearing.name}_{k}", self.taken) for k in range(1, len(axes))]
        names = [take(f"{bearing.name}_{letter}", self.taken) for letter in "xyz"[: len(axes)]]
        single = [Joint(name, "revolute", "", "", here if k else place, axes[k], origin) for k, name in enumerate(names)]
        joints, links = in_series(single, parent, child, between)
        if bearing.type == "ball":
            self.balls.append(tuple(names))
        problem = f"a {bearing.type} joint of the tree is made of revolute joints: {', '.join(names)}"
        self.remarks.append(remark("note", bearing.element, problem, ""))
        return joints, links

    def _loop(self, bearing: _Bearing, frames: Mapping[str, pin.SE3]) -> Loop:
        if bearing.type not in TYPES_OF_LOOPS:
            problem = f"a {bearing.type} joint cannot close a loop here, and the tree has no place for it"
            refuse(self.file, bearing.element, problem, "close the loop at a revolute or ball joint")
        kind, place, axis = TYPES_OF_LOOPS[bearing.type], bearing.place, None
        if kind == "revolute":
            element = need_child(self.file, bearing.element, "axis")
            for mimic in (*element.all("mimic"), *bearing.element.all("drake:mimic")):
                refuse(self.file, mimic, "the joint closes a loop, and cannot follow another", "let another joint close the loop")
            axis = place.rotation.T @ self._axis(bearing)
        if kind == "spherical":
            place = pin.SE3(frames[bearing.parent].rotation, place.translation)
        ends = [(link, frames[link].inverse() * place) for link in (bearing.parent, bearing.child)]
        if kind == "spherical":  # its frames have no direction
            ends = [(link, pin.SE3(np.eye(3), end.translation)) for link, end in ends]
        return Loop(bearing.name, kind, (ends[0], ends[1]), axis, origin_of(bearing.element))

    # ------------------------------------------------------------------------------------------------------------------------ gear pairs

    def _mimic(self, bearing: _Bearing, axis: Element) -> Follow | None:
        """The gear pair of a joint: ``<mimic>`` of SDF 1.11, multiplier (leader - reference) + offset; or ``<drake:mimic joint multiplier
        offset>``."""
        mimic = find_child(self.file, axis, "mimic")
        if mimic is not None:
            refuse_unknown(self.file, mimic, _KNOWN["mimic"].split())
            if mimic.get("axis") not in ("", "axis"):
                refuse(self.file, mimic, "it follows a second axis", "let it follow a revolute or prismatic joint")
            multiplier, offset, reference = (self._number(mimic, name, 0.0) for name in ("multiplier", "offset", "reference"))
            return Follow(mimic.get("joint"), multiplier, offset - multiplier * reference, origin_of(mimic))
        mimic = find_child(self.file, bearing.element, "drake:mimic")
        if mimic is None:
            return None
        texts = mimic.attributes.get("multiplier", "1"), mimic.attributes.get("offset", "0")
        multiplier, offset = (float(numbers(self.file, mimic, text, 1)[0]) for text in texts)
        return Follow(mimic.get("joint"), multiplier, offset, origin_of(mimic))

    def _with_gears(
        self, joints: list[Joint], geared: Mapping[str, _Bearing], carried: Mapping[str, _Bearing], frames: Mapping[str, pin.SE3]
    ) -> tuple[list[Joint], list[Relation]]:
        """The joints with the gear pairs of gearboxes, and the relations of those whose reference body turns against joints of the tree.

        The angle of the child about axis2 is -ratio times that of the parent about axis, both relative to the reference body.
        """
        by_name, relations = {joint.name: joint for joint in joints}, []
        determined = {joint.name for joint in joints if joint.follow}
        for gearbox in geared.values():
            ratio, origin = self._number(gearbox.element, "gearbox_ratio", 1.0), origin_of(gearbox.element)
            body = need_child(self.file, gearbox.element, "gearbox_reference_body")
            reference = self._link_of(body.text.strip(), body)
            terms: dict[str, float] = {}
            for link, tag, factor in ((gearbox.child, "axis2", 1.0), (gearbox.parent, "axis", ratio)):
                axis = self._axis(gearbox, tag)
                turned, held = _carriers(link, carried), _carriers(reference, carried)
                own = {name: factor for name in turned if name not in held} | {name: -factor for name in held if name not in turned}
                for name, sign in own.items():
                    bearing, carries = (turned | held)[name]
                    if bearing.type in ("prismatic", "fixed"):
                        continue
                    if bearing.type not in (*_TURNING, _SCREW):
                        problem = f"joint {name!r}, which carries its gears, is {bearing.type}"
                        refuse(self.file, gearbox.element, problem, "write a revolute one")
                    along = float(frames[carries].rotation @ by_name[name].axis @ axis)
                    if abs(abs(along) - 1) > 1e-6:
                        refuse(self.file, gearbox.element, f"its {tag} is not along that of joint {name!r}", "give them one direction")
                    terms[name] = terms.get(name, 0.0) + math.copysign(sign, sign * along)
            terms = {joint: value for joint, value in terms.items() if abs(value) > 1e-9 * max(1.0, abs(ratio))}
            free = [joint for joint in terms if joint not in determined]
            if len(terms) < 2 or not free:
                problem = f"no turn of {gearbox.parent!r} or {gearbox.child!r} against {reference!r} is left for it to determine"
                refuse(self.file, gearbox.element, problem, "write revolute joints between the reference body and both, one gear pair each")
            first, determined = free[0], {*determined, free[0]}
            ordered = {first: 1.0} | {joint: value / terms[first] for joint, value in terms.items() if joint != first}
            if len(ordered) > 2:
                relations.append(Relation(gearbox.name, ordered, 0.0, origin))
            else:
                ((leader, value),) = list(ordered.items())[1:]
                by_name[first] = replace(by_name[first], follow=Follow(leader, -value, 0.0, origin))
        return list(by_name.values()), relations

    # ---------------------------------------------------------------------------------------------------------------------------- links

    def _link(self, name: str, element: Element, inside: pin.SE3) -> Link:
        """A link; ``inside``: pose of its frame in the file, in the frame that it has here."""
        refuse_unknown(self.file, element, _KNOWN["link"].split())
        if self._true(element, "kinematic"):
            refuse(self.file, element.all("kinematic")[0], "a kinematic link does not obey mechanics", "remove <kinematic>")
        for gravity in element.all("gravity"):
            if gravity.text.strip().lower() in ("0", "false"):
                refuse(self.file, gravity, "gravity acts on all links or none", "remove it; load(..., gravity=(0, 0, 0)) has none")
        inertial = find_child(self.file, element, "inertial")
        inertia = None if inertial is None else self._inertia(inertial, inside, name)
        shapes = [shape for visual in element.all("visual") for shape in self._shapes(visual, inside, name)]
        return Link(name, inertia, tuple(shapes), origin_of(element))

    def _inertia(self, element: Element, inside: pin.SE3, link: str) -> Inertia:
        refuse_unknown(self.file, element, _KNOWN["inertial"].split())
        if element.get("auto").lower() in ("1", "true"):
            refuse(self.file, element, "inertia from collision shapes is not computed", "write <mass> and <inertia>")
        for added in element.all("fluid_added_mass"):
            refuse(self.file, added, "added mass of a fluid cannot be read", "remove it")
        mass, moments = need_child(self.file, element, "mass"), need_child(self.file, element, "inertia")
        refuse_unknown(self.file, moments, _KNOWN["inertia"].split())
        for name in ("ixx", "iyy", "izz"):
            if not need_child(self.file, moments, name).text.strip():
                refuse(self.file, moments, f"<{name}> is empty", "write moments of inertia in kg m2")
        xx, xy, xz, yy, yz, zz = (self._number(moments, name, 0.0) for name in _KNOWN["inertia"].split())
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        for pose in element.all("pose"):
            if {pose.get("relative_to"), pose.get("frame")} - {"", link}:
                refuse(self.file, pose, "the pose of an <inertial> is in the frame of its link", "leave out the name of the frame")
        kilograms = float(numbers(self.file, mass, mass.text, 1)[0])
        return Inertia(kilograms, inside * self._pose(element), tensor, origin_of(element))

    def _shapes(self, visual: Element, inside: pin.SE3, link: str) -> Iterator[Shape]:
        geometry = find_child(self.file, visual, "geometry")
        for pose in visual.all("pose"):
            if {pose.get("relative_to"), pose.get("frame")} - {"", link}:
                geometry = None
        if geometry is None:
            return
        place, colour = inside * self._pose(visual), None
        for material in visual.all("material"):
            for part in material.all("diffuse", "ambient")[:1]:
                words = numbers(self.file, part, part.text, len(part.text.split()))
                colour = tuple(words) if len(words) == 4 else (*words[:3], 1.0) if len(words) == 3 else None
        for shape in geometry.children:
            text = {child.tag: " ".join(child.text.split()) for child in shape.children}
            if shape.tag == "box" and "size" in text:
                yield Shape(place, "box", {"size": text["size"]}, colour)
            elif shape.tag == "sphere" and "radius" in text:
                yield Shape(place, "sphere", {"radius": text["radius"]}, colour)
            elif shape.tag == "cylinder" and {"radius", "length"} <= text.keys():
                yield Shape(place, "cylinder", {"radius": text["radius"], "length": text["length"]}, colour)
            elif shape.tag == "capsule" and {"radius", "length"} <= text.keys():
                yield from capsule(place, self._number(shape, "radius", 0.0), self._number(shape, "length", 0.0), colour)
            elif shape.tag == "mesh" and "uri" in text:
                scale = {"scale": text["scale"]} if "scale" in text else {}
                yield Shape(place, "mesh", {"filename": text["uri"].replace("model://", "package://")} | scale, colour)
            elif shape.tag != "empty":
                self.remarks.append(remark("note", visual, f"a shape of kind <{shape.tag}> is not drawn", ""))

    # ------------------------------------------------------------------------------------------------------------- everything else in it

    def _drake_loops(self, frames: Mapping[str, pin.SE3]) -> Iterator[Loop]:
        """Drake's ball constraints and bushings, whose names and numbers are texts in SDF."""
        taken = {*self.joints}
        for element in self.model.all("drake:joint", "drake:tendon_constraint"):
            refuse(self.file, element, "cannot be read", "write joints of SDF")
        self.remarks += [spring_remark(element) for element in self.model.all(SPRING)]

        def place(end: Element) -> tuple[str, pin.SE3]:
            name = end.text.strip()
            link = self._link_of(name, end)
            return link, frames[link].inverse() * self.place(name if element.tag == BUSHING else link, end)

        for element in (*self.model.all(BALL), *self.model.all(BUSHING)):
            loop = drake_loop(self.file, element, lambda number: number.text.strip(), place, taken)
            taken.add(loop.name)
            if element.tag == BUSHING:
                self.remarks.append(bushing_remark(loop.origin))
            yield loop

    def _drivers(self, joints: set[str]) -> Iterator[tuple[str, Origin]]:
        """Joints that a plugin of Gazebo moves, because SDF itself has no drivers."""
        seen: set[str] = set()
        for plugin in self.model.all("plugin"):
            for element in plugin.all("joint_name"):
                name = element.text.strip()
                if name in joints and name not in seen and "state" not in (plugin.get("name") + plugin.get("filename")).lower():
                    seen.add(name)
                    yield name, origin_of(element)


def _rank(bearing: _Bearing) -> int:
    """Rank in which the tree takes a joint: first those that cannot close a loop, then those that hold more, balls, last those that close
    loops as a file of ours says."""
    if bearing.element.all(CLOSES):
        return 4
    return {"prismatic": 0, _SCREW: 0, "universal": 0, "revolute2": 0, "fixed": 1, "ball": 3}.get(bearing.type, 2)


def _carriers(link: str, carried: Mapping[str, _Bearing]) -> dict[str, tuple[_Bearing, str]]:
    """The joints of the tree that carry a link, by their names, and the link at the outer end of each, from the link to the root."""
    chain = {}
    while link in carried:
        bearing = carried[link]
        chain[bearing.name] = bearing, link
        link = bearing.parent if link == bearing.child else bearing.child
    return chain
