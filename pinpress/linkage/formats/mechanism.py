"""Links, joints and loops as readers take them from other formats, the choice of a tree, and the URDF that says the same.

Every part knows its origin: the element from which it was read.

The frame of a link is that of the joint which carries it, as URDF has it. Joints count from the zeros of the file. ``home`` is the pose in
which the linkage is put together, if that is not the pose with all joints at zero.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ...common.quantities import Array
from ..document import Document, Finding, Origin
from ..text import MOMENTS, as_text, opening, tag

# What a URDF asks of every limited joint, where the other format has no such limit. Nothing here is computed with.
_X = np.array([1.0, 0.0, 0.0])
UNLIMITED = 1000.0  # limit of position and velocity that is written where there is none [rad or m], [rad/s or m/s]


# Types of loops by those of joints in URDF+ and SDF.
TYPES_OF_LOOPS = {"spherical": "spherical", "ball": "spherical", "revolute": "revolute", "continuous": "revolute", "fixed": "fixed"}


@dataclass(frozen=True, eq=False)
class Inertia:
    """The mass [kg] of a link, and its tensor (3, 3) about the centre of mass [kg m2], in the axes of ``place`` in the link's frame."""

    mass: float
    place: pin.SE3
    tensor: Array
    origin: Origin


@dataclass(frozen=True, eq=False)
class Shape:
    """What is drawn of a link: an element of URDF ("box", "cylinder", "sphere" or "mesh") at a place in the link's frame."""

    place: pin.SE3
    tag: str
    attributes: Mapping[str, str]
    colour: Sequence[float] | None = None  # red, green, blue and opacity from 0 to 1


@dataclass(frozen=True, eq=False)
class Link:
    """A body."""

    name: str
    inertia: Inertia | None
    shapes: tuple[Shape, ...]
    origin: Origin


class Follow(NamedTuple):
    """A gear pair: the joint's coordinate is multiplier x coordinate of the leader + offset [rad or m]."""

    leader: str
    multiplier: float
    offset: float
    origin: Origin


class Spring(NamedTuple):
    """A spring and damper in a joint: effort = -stiffness (coordinate - reference) - damping x rate."""

    stiffness: float  # [N m/rad or N/m]
    reference: float  # [rad or m]
    damping: float  # [N m s/rad or N s/m]


class Relation(NamedTuple):
    """An equation between joints: the sum of coefficient x coordinate is the offset [rad or m]; it determines the first joint."""

    name: str
    coefficients: Mapping[str, float]
    offset: float
    origin: Origin


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint of the tree, "revolute", "prismatic", "fixed" or "floating"."""

    name: str
    type: str
    parent: str
    child: str
    place: pin.SE3  # in the parent's frame; the child's frame in the drawn pose
    axis: Array  # (3,) of length 1 in that frame
    origin: Origin
    limits: tuple[float, float] | None = None  # [rad or m]
    effort: float | None = None  # largest [N m or N]; None: without limit
    velocity: float | None = None  # largest [rad/s or m/s]; None: without limit
    damping: float = 0.0  # [N m s/rad or N s/m]
    friction: float = 0.0  # [N m or N]
    follow: Follow | None = None
    spring: Spring | None = None
    armature: float = 0.0  # inertia of a motor that turns with the joint [kg m2 or kg]


@dataclass(frozen=True, eq=False)
class Loop:
    """A bearing that closes a loop, "spherical", "revolute" or "fixed": the two links, and its place in the frame of each."""

    name: str
    type: str
    ends: tuple[tuple[str, pin.SE3], tuple[str, pin.SE3]]
    axis: Array | None  # (3,) of a revolute one, in the frames of both ends
    origin: Origin


@dataclass(frozen=True, eq=False)
class Mechanism:
    """All parts of a file that make a linkage; joints and loops in the file's order."""

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    loops: tuple[Loop, ...]
    drivers: tuple[tuple[str, Origin], ...]  # names of joints
    remarks: tuple[Finding, ...]
    origin: Origin
    balls: tuple[tuple[str, ...], ...] = ()  # names of the revolute joints that make each ball joint of the tree, from parent to child
    relations: tuple[Relation, ...] = ()
    # Coordinates of joints where the linkage is put together [rad or m]; by the first joint of a ball the (3, 3) rotation of the ball.
    home: Mapping[str, float | Array] = field(default_factory=dict)


def with_hinges(loops: Iterable[Loop]) -> tuple[list[Loop], list[tuple[Loop, Loop]]]:
    """The loops, in which two balls between the same two bodies whose points are equally far apart in both are one hinge; and the pairs of
    balls that were."""
    kept: list[Loop] = []
    pairs: list[tuple[Loop, Loop]] = []
    for loop in loops:
        for k, first in enumerate(kept):
            if (first.type, loop.type) != ("spherical", "spherical") or [end[0] for end in first.ends] != [end[0] for end in loop.ends]:
                continue
            ways = [second.translation - start.translation for (_, start), (_, second) in zip(first.ends, loop.ends, strict=True)]
            apart = [float(np.linalg.norm(way)) for way in ways]
            if min(apart) > 0 and abs(apart[1] - apart[0]) <= 1e-9 * max(apart):  # else rounded points: a joint that yields a little
                one, two = (
                    (link, pin.SE3(pin.Quaternion.FromTwoVectors(_X, way).matrix(), place.translation))
                    for (link, place), way in zip(first.ends, ways, strict=True)
                )
                kept[k] = replace(first, type="revolute", ends=(one, two), axis=_X)
                pairs.append((first, loop))
                break
        else:
            kept.append(loop)
    return kept, pairs


class Edge(NamedTuple):
    """A joint that the tree may take, by the names of its parent and child link; it takes joints of low rank before others."""

    parent: str
    child: str
    rank: int


class SpanningTree(NamedTuple):
    """The link that each joint of the tree carries, by the joint's index, from the root outwards; and links that no joint reaches."""

    tree: Mapping[int, str]
    lost: tuple[str, ...]


def spanning_tree(root: str, links: Sequence[str], edges: Sequence[Edge]) -> SpanningTree:
    """A tree with as many joints of the lowest ranks as there can be, in which joints carry their children.

    Where a joint is the only one of its rank that could carry a link, and has it for its parent, it carries its parent.
    """
    groups = {link: {link} for link in links}
    taken: list[int] = []
    carried: set[str] = {root}
    for rank, as_written in itertools.product(sorted({edge.rank for edge in edges}), (True, False)):
        for k, (parent, child, own) in enumerate(edges):
            if own != rank or groups[parent] is groups[child] or (as_written and child in carried):
                continue
            carried.add(child)
            taken.append(k)
            joined = groups[parent] | groups[child]
            groups.update(dict.fromkeys(joined, joined))
    around: dict[str, list[tuple[int, str]]] = {}
    for k in sorted(taken):
        around.setdefault(edges[k].parent, []).append((k, edges[k].child))
        around.setdefault(edges[k].child, []).append((k, edges[k].parent))
    tree: dict[int, str] = {}
    reached = [root]
    for link in reached:  # grows as it goes
        for k, other in around.get(link, ()):
            if k not in tree:
                tree[k] = other
                reached.append(other)
    return SpanningTree(tree, tuple(link for link in links if link not in reached))


def _with_axes_of_balls(mechanism: Mechanism) -> Iterator[Joint]:
    """The joints, those of balls with `ball_axes`."""
    joints = {joint.name: joint for joint in mechanism.joints}
    carriers = {joint.child: joint for joint in mechanism.joints}
    for names in mechanism.balls:
        ball = [joints[name] for name in names]
        child, carrier = ball[-1].child, carriers.get(ball[0].parent)
        others = [joint.place for joint in mechanism.joints if joint.parent == child]
        others += [place for loop in mechanism.loops for link, place in loop.ends if link == child]
        along = np.mean([place.translation for place in others], axis=0) if others else np.zeros(3)
        turns = ball[0].place.rotation.T @ carrier.axis if carrier is not None and carrier.type == "revolute" else None
        axes = ball_axes(along, turns) if along.any() else [joint.axis for joint in ball]
        joints.update({joint.name: replace(joint, axis=axis) for joint, axis in zip(ball, axes, strict=True)})
    yield from joints.values()


def ball_axes(along: Array, turns: Array | None) -> Array:
    """(3, 3) axes, as rows, of the three hinges that make a ball joint, from its parent to its child.

    The first axis is that about which the parent turns, so that the child follows whole turns of a crank; the last one lies along the
    child, which can spin idly about it where a ball is at its other end; the second one is across both. They lock where a rod lies along
    the axis of its crank, in which the crank does not move it.

    Args:
        along: (3,) from the ball to the other bearings of its child, in the ball's frame; zeros if the child has no others.
        turns: (3,) axis about which the parent turns, in the same frame; None if it does not turn.
    """
    if not np.linalg.norm(along):
        return np.eye(3)
    along = along / np.linalg.norm(along)
    first = np.eye(3)[np.abs(along).argmin()]
    # An axis within 6 degrees of the link would hardly turn it.
    first = first if turns is None or np.linalg.norm(np.cross(along, turns)) < 0.1 else turns
    across = np.cross(along, first)
    return np.array([first, across / np.linalg.norm(across), along])


def as_document(file: str, mechanism: Mechanism, source: str) -> Document:
    """The URDF of a mechanism that was read from this file; ``source``: the name of its format."""
    lines = [
        ("<?xml version='1.0'?>", "robot", mechanism.origin),
        (opening("robot", {"name": mechanism.name}), "robot", mechanism.origin),
        (f"  <!-- Written by pinpress from {source}. Joints count from the zeros of that file. SI units. -->", "", mechanism.origin),
    ]
    joints = list(_with_axes_of_balls(mechanism))
    lines += [(line, "link", origin) for link in mechanism.links for line, origin in _link(link)]
    lines += [(line, "joint", origin) for joint in joints for line, origin in _joint(joint)]
    lines += [(f"  {line}", name, origin) for joint in joints for line, name, origin in _spring_and_armature(joint)]
    lines += [(f"  {relation_element(relation)}", "relation", relation.origin) for relation in mechanism.relations]
    lines += [(f"  {loop_element(loop)}", "loop_joint", loop.origin) for loop in mechanism.loops]
    if home := _home(mechanism, joints):
        lines.append((f"  {home_element(home)}", "home", mechanism.origin))
    for name, origin in mechanism.drivers:
        lines.append((f"  {tag('transmission', {'name': f'{name}_drive'}, tag('joint', {'name': name}))}", "transmission", origin))
    lines.append(("</robot>", "", mechanism.origin))
    text = "\n".join(line for line, _, _ in lines) + "\n"
    return Document(file, text.encode(), {(k, top): origin for k, (_, top, origin) in enumerate(lines, 1)}, mechanism.remarks)


Line = tuple[str, Origin]


def _link(link: Link) -> Iterator[Line]:
    if link.inertia is None and not link.shapes:
        yield f"  {tag('link', {'name': link.name})}", link.origin
        return
    yield f"  {opening('link', {'name': link.name})}", link.origin
    if link.inertia is not None:
        inertia, moments = link.inertia, link.inertia.tensor
        values = {name: as_text([moments[i, j]]) for name, i, j in MOMENTS}
        content = _origin(inertia.place) + tag("mass", {"value": as_text([inertia.mass])}) + tag("inertia", values)
        yield f"    {tag('inertial', {}, content)}", inertia.origin
    for shape in link.shapes:
        content = _origin(shape.place) + tag("geometry", {}, tag(shape.tag, shape.attributes))
        if shape.colour is not None:
            rgba = " ".join(f"{min(max(part, 0.0), 1.0):.6g}" for part in shape.colour)
            content += tag("material", {"name": f"rgba {rgba}"}, tag("color", {"rgba": rgba}))
        yield f"    {tag('visual', {}, content)}", link.origin
    yield "  </link>", link.origin


def _joint(joint: Joint) -> Iterator[Line]:
    kind = "continuous" if joint.type == "revolute" and joint.limits is None else joint.type
    yield f"  {opening('joint', {'name': joint.name, 'type': kind})}", joint.origin
    yield f"    {tag('parent', {'link': joint.parent})}{tag('child', {'link': joint.child})}{_origin(joint.place)}", joint.origin
    if joint.type not in ("fixed", "floating"):
        yield f"    {tag('axis', {'xyz': as_text(joint.axis)})}", joint.origin
        if kind != "continuous" or joint.effort is not None or joint.velocity is not None:
            lower, upper = joint.limits or (-UNLIMITED, UNLIMITED)
            effort = 1e9 if joint.effort is None else joint.effort  # [N m or N]: of no limit
            velocity = UNLIMITED if joint.velocity is None else joint.velocity
            travel = {} if kind == "continuous" else {"lower": lower, "upper": upper}
            values = travel | {"effort": effort, "velocity": velocity}
            yield f"    {tag('limit', {name: as_text([value]) for name, value in values.items()})}", joint.origin
        if joint.damping or joint.friction:
            values = {"damping": joint.damping, "friction": joint.friction}
            yield f"    {tag('dynamics', {name: as_text([value]) for name, value in values.items()})}", joint.origin
    if joint.follow is not None:
        follow = joint.follow
        ratio = {"multiplier": as_text([follow.multiplier]), "offset": as_text([follow.offset])}
        yield f"    {tag('mimic', {'joint': follow.leader} | ratio)}", follow.origin
    yield "  </joint>", joint.origin


def _spring_and_armature(joint: Joint) -> Iterator[tuple[str, str, Origin]]:
    """The elements of ours that say what of a joint a URDF does not hold, each with its tag."""
    if joint.spring is not None:
        values = {name: as_text([value]) for name, value in joint.spring._asdict().items()}
        yield tag("joint_spring", {"joint": joint.name} | values), "joint_spring", joint.origin
    if joint.armature:
        yield tag("armature", {"joint": joint.name, "inertia": as_text([joint.armature])}), "armature", joint.origin


def _home(mechanism: Mechanism, joints: Sequence[Joint]) -> dict[str, float]:
    """Coordinates of the joints at home; a ball's rotation is split into turns about its three axes."""
    axes, balls = {joint.name: joint.axis for joint in joints}, {names[0]: names for names in mechanism.balls}
    home: dict[str, float] = {}
    for name, position in mechanism.home.items():
        if name in balls:
            if not np.array_equal(position, np.eye(3)):  # else its angles would be rounding errors
                from scipy.spatial.transform import Rotation  # its import takes longer than reading a file

                turned = Rotation.from_matrix(position)
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # where two of the axes are parallel, one of the angles is chosen
                    angles = turned.as_davenport([axes[each] for each in balls[name]], "intrinsic")
                home |= zip(balls[name], map(float, angles), strict=True)
        else:
            home[name] = float(position)
    return home if any(home.values()) else {}


def home_element(home: Mapping[str, float]) -> str:
    """The ``<home>`` of coordinates by the names of joints."""
    return tag("home", {}, "".join(tag("joint", {"name": name, "position": as_text([position])}) for name, position in home.items()))


def relation_element(relation: Relation) -> str:
    """Its ``<relation>``."""
    joints = (tag("joint", {"name": name, "coefficient": as_text([value])}) for name, value in relation.coefficients.items())
    return tag("relation", {"name": relation.name, "offset": as_text([relation.offset])}, "".join(joints))


def loop_element(loop: Loop) -> str:
    """Its ``<loop_joint>``."""
    content = "".join(tag(f"link{k}", {"link": link} | attributes_of_pose(place)) for k, (link, place) in enumerate(loop.ends, 1))
    if loop.axis is not None:
        content += tag("axis", {"xyz": as_text(loop.axis)})
    return tag("loop_joint", {"name": loop.name, "type": loop.type}, content)


def _origin(place: pin.SE3) -> str:
    return tag("origin", attributes_of_pose(place))


def attributes_of_pose(place: pin.SE3) -> dict[str, str]:
    turned = not np.array_equal(place.rotation, np.eye(3))
    return {"xyz": as_text(place.translation)} | ({"rpy": as_text(pin.rpy.matrixToRpy(place.rotation))} if turned else {})


def in_series(joints: Sequence[Joint], parent: str, child: str, between: Sequence[str]) -> tuple[list[Joint], list[Link]]:
    """The joints that stand for one joint with several coordinates, from its parent to its child, and the links without mass between them,
    which have these names."""
    ends = [parent, *between, child]
    made = [replace(joint, parent=one, child=other) for joint, one, other in zip(joints, ends[:-1], ends[1:], strict=True)]
    origins = [joint.origin for joint in joints[:-1]]
    nothing = pin.SE3.Identity(), np.zeros((3, 3))
    links = [Link(name, Inertia(0.0, *nothing, origin), (), origin) for name, origin in zip(between, origins, strict=True)]
    return made, links


def placements(roots: Iterable[str], joints: Iterable[tuple[str, str, pin.SE3]]) -> dict[str, pin.SE3]:
    """Placements of roots, the identity, and of the links that joints carry from there at zero; joints by parent, child and place."""
    carried: dict[str, list[tuple[str, pin.SE3]]] = {}
    for parent, child, place in joints:
        carried.setdefault(parent, []).append((child, place))
    places = {root: pin.SE3.Identity() for root in roots}
    reached = list(places)
    for link in reached:  # grows as it goes
        for child, place in carried.get(link, ()):
            if child not in places:
                places[child] = places[link] * place
                reached.append(child)
    return places


def capsule(place: pin.SE3, radius: float, length: float, colour: Sequence[float] | None) -> tuple[Shape, ...]:
    """The shapes of a capsule, which URDF has not; ``length``: between the centres of its spherical ends, along z."""
    ends = (place * pin.SE3(np.eye(3), np.array([0.0, 0.0, side * length / 2])) for side in (-1, 1))
    size = {"radius": as_text([radius])}
    return (
        Shape(place, "cylinder", size | {"length": as_text([length])}, colour),
        *(Shape(end, "sphere", size, colour) for end in ends),
    )
