"""The plan of a planar press, and the press that a plan describes.

In a plan everything has its place in the world, in the closed drawn pose, so that parts can be added, shifted and mirrored without regard
to what carries what. The new press is written as a URDF and loaded from that.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ...common.arrays import Array
from ...common.errors import PinpressError
from ...kinematics.poses import poses
from ...linkage import loading
from ...linkage.linkage import Linkage
from ...linkage.urdf import findings, reader
from ...linkage.urdf.document import Document
from ...linkage.urdf.text_edits import tag

BELOW_ROUNDING = 1e-15  # of a quantity's size: what turned frames leave of a zero
_MOMENTS = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))


@dataclass(frozen=True, eq=False, repr=False)
class PlanBody:
    """A link and the joint that carries it, both with the same frame.

    Attributes:
        link: Name of the link.
        place: Place of the frame in the world.
        inertia: Inertia of the link in the frame.
        joint: Name of the joint.
        parent: Name of the link that the joint is fixed to.
        axis: (3,) axis of the joint in the frame.
        limits: Of a joint that slides: lower and upper [m], effort [N], velocity [m/s]; empty for a joint that turns.
        leader: Name of the joint that this joint mimics by -1; None where it mimics none.
    """

    link: str
    place: pin.SE3
    inertia: pin.Inertia
    joint: str
    parent: str
    axis: Array
    limits: tuple[float, ...] = ()
    leader: str | None = None


@dataclass(frozen=True, eq=False, repr=False)
class PlanPin:
    """A pin that closes a loop.

    Attributes:
        name: Name of the ``<loop_joint>``.
        type: Type of the ``<loop_joint>``.
        link1: Name of its first link.
        link2: Name of its second link.
        point: (3,) place in the world [m].
    """

    name: str
    type: str
    link1: str
    link2: str
    point: Array


@dataclass(frozen=True, eq=False, repr=False)
class PressPlan:
    """A planar press.

    Attributes:
        name: Name of the press.
        frame: Name of the root link.
        frame_inertia: Inertia of the root link.
        bodies: Bodies, parents before their children.
        pins: Pins that close the loops.
        driver: Name of the driver joint.
        slide: Name of the slide's link.
        normal: (3,) normal of the plane in world axes.
        gravity: (3,) [m/s2].
        size: Length of the linkage, to which rounding is relative [m].
    """

    name: str
    frame: str
    frame_inertia: pin.Inertia
    bodies: tuple[PlanBody, ...]
    pins: tuple[PlanPin, ...]
    driver: str
    slide: str | None
    normal: Array
    gravity: tuple[float, ...]
    size: float

    def body(self, link: str) -> PlanBody:
        """The body of this name."""
        return next(body for body in self.bodies if body.link == link)


def plan_of(press: Linkage) -> PressPlan:
    """The plan of a planar press without gear pairs. Links that are welded together are one body, with the name of the first or the slide.

    Raises:
        PinpressError: The press is not planar, or has gear pairs or several drivers.
    """
    refusal = f"{press.name} is not planar with one driver, or has gear pairs: give a planar press of pins and guides"
    plane = press.plane_or_refuse(refusal)
    if press.couplings:
        raise PinpressError(refusal)
    model, at = press.model, poses(press, press.closed[None])
    links = {joint: press.link_of(joint) for joint in range(model.njoints)}
    if press.slide is not None:
        links[press.slide_guide[0] + 1] = press.slide  # not one that it is welded to: positions are the slide's own
    bodies = []
    for j, (name, axis, start) in enumerate(zip(press.joints, press.axes, press.closed, strict=True), 1):
        at_q, at_v = model.idx_qs[j], model.idx_vs[j]
        travel = float(model.lowerPositionLimit[at_q]) - start, float(model.upperPositionLimit[at_q]) - start
        limits = (*travel, float(model.upperEffortLimit[at_v]), float(model.velocityLimit[at_v]))
        own = model.frames[model.getFrameId(links[j], pin.BODY)].placement
        place, inertia = pin.SE3(at.rotation[j, 0], at.position[j, 0]) * own, own.actInv(model.inertias[j])
        parent, direction = links[int(model.parents[j])], own.rotation.T @ axis.direction
        bodies.append(PlanBody(links[j], place, inertia, name, parent, direction, () if axis.turns else limits))
    pins = [PlanPin(k.name, k.type, links[k.joint1], links[k.joint2], at.points(k.joint1, k.point1)[0]) for k in press.loops]
    normal, gravity = plane.normal, tuple(model.gravity.linear.tolist())
    size = press.size
    return PressPlan(press.name, links[0], model.inertias[0], tuple(bodies), tuple(pins), press.driver, press.slide, normal, gravity, size)


def press_of(plan: PressPlan, comment: str) -> Linkage:
    """The press of a plan, loaded from its URDF, which has this comment. Raises what `load` raises."""
    places = {plan.frame: pin.SE3.Identity()} | {body.link: body.place for body in plan.bodies}
    content = [_link(plan.frame, plan.frame_inertia, plan.size)]
    content += [_link(body.link, body.inertia, plan.size) for body in plan.bodies]
    content += [_joint(body, places[body.parent].actInv(body.place), plan.size) for body in plan.bodies]
    content += [_loop(each, places, plan.normal, plan.size) for each in plan.pins]
    content.append(tag("transmission", {"name": "crank_drive"}, tag("joint", {"name": plan.driver})))
    robot = tag("robot", {"name": plan.name}, "".join(f"\n  {element}" for element in content) + "\n")
    text = f'<?xml version="1.0"?>\n<!--\n  {comment}\n-->\n{robot}\n'.encode()
    file = f"{plan.name}.urdf (not written)"  # the file's name in errors
    document = Document(file, text)
    findings.refuse(reader.errors(document), findings.command(file))
    press = loading.assembled(document, None, plan.slide, plan.gravity)
    loading.check_drawn_pose(press)
    return press


def _link(name: str, inertia: pin.Inertia, size: float) -> str:
    if not inertia.mass:  # the frame's
        return tag("link", {"name": name})
    origin, mass = tag("origin", {"xyz": _written(inertia.lever, size)}), tag("mass", {"value": _written([inertia.mass])})
    largest = float(np.abs(inertia.inertia).max())
    moments = tag("inertia", {name: _written([inertia.inertia[i, j]], largest) for name, i, j in _MOMENTS})
    return tag("link", {"name": name}, tag("inertial", {}, origin + mass + moments))


def _joint(body: PlanBody, place: pin.SE3, size: float) -> str:
    ends = tag("parent", {"link": body.parent}) + tag("child", {"link": body.link})
    content = ends + tag("origin", _placement(place, size)) + tag("axis", {"xyz": _written(body.axis, 1.0)})
    if body.limits:
        names = ("lower", "upper", "effort", "velocity")
        content += tag("limit", {name: _written([value]) for name, value in zip(names, body.limits, strict=True)})
    if body.leader is not None:
        content += tag("mimic", {"joint": body.leader, "multiplier": "-1", "offset": "0"})
    return tag("joint", {"name": body.joint, "type": "prismatic" if body.limits else "continuous"}, content)


def _loop(each: PlanPin, places: Mapping[str, pin.SE3], normal: Array, size: float) -> str:
    """A loop joint whose two ends have the world's axes in the drawn pose."""
    there = pin.SE3(np.eye(3), each.point)
    ends = (("link1", each.link1), ("link2", each.link2))
    content = "".join(tag(end, {"link": link} | _placement(places[link].actInv(there), size)) for end, link in ends)
    content += tag("axis", {"xyz": _written(normal, 1.0)}) if each.type == "revolute" else ""
    return tag("loop_joint", {"name": each.name, "type": each.type}, content)


def _placement(place: pin.SE3, size: float) -> dict[str, str]:
    return {"xyz": _written(place.translation, size), "rpy": _written(pin.rpy.matrixToRpy(place.rotation), 1.0)}


def _written(numbers: Array | list[float], size: float = 0.0) -> str:
    """Numbers as text; those that are rounding beside a size are zero."""
    return " ".join(repr(float(number) if abs(number) > BELOW_ROUNDING * size else 0.0) for number in numbers)
