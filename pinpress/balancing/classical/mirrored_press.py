"""The plan of a planar press, to which parts are added or which is doubled by its mirror image, and the press of a plan.

In a plan everything has its place in the world, in the closed drawn pose, so that parts can be added, shifted and mirrored without regard
to who carries whom. The new press is written as a URDF and loaded from that.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from ...common.arrays import Array
from ...common.errors import PinpressError
from ...kinematics.poses import poses
from ...linkage import loading
from ...linkage.linkage import Linkage
from ...linkage.urdf import findings
from ...linkage.urdf import reader as urdf
from ...linkage.urdf.document import Document
from ...linkage.urdf.text_edits import tag
from ..counterweights import body as body_of
from ..counterweights import sum_of
from .crank_slider import CrankSlide, reach

SIDES = ("left", "right")
SPARE = 0.1  # of the auxiliary crank radius: how far the counterweight's limits are beyond its travel
BELOW_ROUNDING = 1e-15  # of a quantity's size: what turned frames leave of a zero
_MOMENTS = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))


@dataclass(frozen=True, eq=False, repr=False)
class Body:
    """A link and the joint that carries it, whose frame is the link's.

    Attributes:
        place: the frame's in the world. inertia: in that frame.
        joint: the joint's name. parent: the link it is fixed to. axis: (3,) of the joint in its frame.
        limits: of one that slides: lower, upper [m], effort, velocity; none of one that turns.
        leader: the joint that it mimics by -1.
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
class Pin:
    """A pin at which a loop is cut: its two links, and where it is in the world (3,). ``type``: of the ``<loop_joint>``."""

    name: str
    type: str
    link1: str
    link2: str
    point: Array


@dataclass(frozen=True, eq=False, repr=False)
class Plan:
    """A planar press.

    Attributes:
        frame, frame_inertia: name and inertia of the root link. bodies: parents before their children.
        driver: name of the driver joint. slide: name of the slide link. normal: (3,) of the plane. gravity: [m/s2].
        size: length of the linkage, to which rounding is relative [m].
    """

    name: str
    frame: str
    frame_inertia: pin.Inertia
    bodies: tuple[Body, ...]
    pins: tuple[Pin, ...]
    driver: str
    slide: str | None
    normal: Array
    gravity: tuple[float, ...]
    size: float

    def body(self, link: str) -> Body:
        """The one of this name."""
        return next(body for body in self.bodies if body.link == link)


def plan(press: Linkage) -> Plan:
    """The plan of a planar press without gear pairs: links that are welded together are one body, named by the first of them or the slide.

    Raises:
        PinpressError: it is not planar, has gear pairs or several drivers.
    """
    if press.plane is None or press.couplings:
        raise PinpressError(f"{press.name} is not planar with one driver, or has gear pairs: give a planar press of pins and guides")
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
        bodies.append(Body(links[j], place, inertia, name, parent, direction, () if axis.turns else limits))
    pins = [Pin(k.name, k.type, links[k.joint1], links[k.joint2], at.points(k.joint1, k.point1)[0]) for k in press.loops]
    normal, gravity = press.plane.normal, tuple(model.gravity.linear.tolist())
    size = press.size
    return Plan(press.name, links[0], model.inertias[0], tuple(bodies), tuple(pins), press.driver, press.slide, normal, gravity, size)


def with_auxiliary(drawn: Plan, main: CrankSlide, auxiliary: CrankSlide) -> Plan:
    """The plan of a crank-slide with an auxiliary one on its crank, whose slide is the counterweight. ``auxiliary.drawn_angle`` is as of
    ``main``, its direction the opposite one."""
    crank, slide, normal = drawn.body(main.crank), drawn.body(main.slide), np.cross(main.direction, main.across)
    flat = 0.5 * (np.eye(3) + np.outer(normal, normal))  # tensor of a lamina in the plane, of unit inertia
    into = crank.place.rotation.T
    centre = crank.place.actInv(auxiliary.point(auxiliary.crank_centre * auxiliary.drawn_crank))
    added = body_of(auxiliary.crank_mass, centre, auxiliary.crank_inertia * (into @ flat @ into.T))

    along = auxiliary.point(auxiliary.drawn_rod) - auxiliary.shaft
    axes = np.stack([along, -normal, np.cross(normal, along)], axis=1)  # x along the rod, which turns about -y
    rod_place = pin.SE3(axes, auxiliary.point(auxiliary.crank_radius * auxiliary.drawn_crank))
    rod_centre = np.array([auxiliary.rod_centre.real, 0.0, auxiliary.rod_centre.imag])
    rod = body_of(auxiliary.rod_mass, rod_centre, auxiliary.rod_inertia * np.diag([0.5, 1.0, 0.5]))

    distance = reach(auxiliary.crank_radius, auxiliary.rod_length, auxiliary.drawn_angle)
    end, up = auxiliary.point(complex(distance)), float(np.sign(auxiliary.direction @ slide.place.rotation @ slide.axis))
    spare = (1 + SPARE) * auxiliary.crank_radius
    low, high = sorted(up * (auxiliary.rod_length + sign * spare - distance) for sign in (-1, 1))
    limits = (low, high, *slide.limits[2:])
    weight = body_of(auxiliary.slide_mass, np.zeros(3), slide.inertia.inertia * (auxiliary.slide_mass / slide.inertia.mass))
    return replace(
        drawn,
        bodies=(
            *(replace(each, inertia=sum_of(each.inertia, added)) if each is crank else each for each in drawn.bodies),
            Body(auxiliary.rod, rod_place, rod, "auxiliary_pin", main.crank, np.array([0.0, -1.0, 0.0])),
            Body(auxiliary.slide, pin.SE3(slide.place.rotation, end), weight, "counterweight_guide", drawn.frame, slide.axis, limits),
        ),
        pins=(*drawn.pins, Pin("counterweight_pin", "spherical", auxiliary.rod, auxiliary.slide, end)),
    )


def doubled(drawn: Plan, shared: Sequence[str], shaft: Array, across: Array, distance: float) -> Plan:
    """The plan with all bodies but the shared ones halved in mass, shifted by half a distance [m] against ``across``, and mirrored about
    the plane through the shaft that this direction (3,) is normal to. The right driver mimics the left one by -1."""
    shift = -0.5 * distance * across

    def named(name: str, side: str) -> str:
        return name if name in (drawn.frame, *shared) else f"{name}_{side}"

    def moved(point: Array, side: str) -> Array:
        point = point + shift
        return point if side == "left" else point - 2 * ((point - shaft) @ across) * across

    def half(each: Body, side: str) -> Body:
        # A mirrored frame keeps its axes, and what is fixed to it changes sides in it.
        to = each.place.rotation.T @ across
        mirror = np.eye(3) if side == "left" else np.eye(3) - 2 * np.outer(to, to)
        whole = each.inertia
        return Body(
            named(each.link, side),
            pin.SE3(each.place.rotation, moved(each.place.translation, side)),
            body_of(0.5 * whole.mass, mirror @ whole.lever, 0.5 * mirror @ whole.inertia @ mirror),
            f"{each.joint}_{side}",
            named(each.parent, side),
            mirror @ each.axis,
            each.limits,
            f"{drawn.driver}_left" if each.joint == drawn.driver and side == "right" else None,
        )

    kept = [each for each in drawn.bodies if each.link in shared]
    halves = [half(each, side) for side in SIDES for each in drawn.bodies if each.link not in shared]
    pins = [(each, side) for side in SIDES for each in drawn.pins]
    return replace(
        drawn,
        bodies=(*halves, *kept),
        pins=tuple(Pin(f"{k.name}_{s}", k.type, named(k.link1, s), named(k.link2, s), moved(k.point, s)) for k, s in pins),
        driver=f"{drawn.driver}_left",
    )


def built(plan: Plan, comment: str) -> Linkage:
    """The press of a plan, loaded from its URDF; raises what `load` would."""
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
    findings.refuse(urdf.errors(document), findings.command(file))
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


def _joint(body: Body, place: pin.SE3, size: float) -> str:
    ends = tag("parent", {"link": body.parent}) + tag("child", {"link": body.link})
    content = ends + tag("origin", _placement(place, size)) + tag("axis", {"xyz": _written(body.axis, 1.0)})
    if body.limits:
        names = ("lower", "upper", "effort", "velocity")
        content += tag("limit", {name: _written([value]) for name, value in zip(names, body.limits, strict=True)})
    if body.leader is not None:
        content += tag("mimic", {"joint": body.leader, "multiplier": "-1", "offset": "0"})
    return tag("joint", {"name": body.joint, "type": "prismatic" if body.limits else "continuous"}, content)


def _loop(each: Pin, places: Mapping[str, pin.SE3], normal: Array, size: float) -> str:
    """With the world's axes at both ends in the drawn pose."""
    there = pin.SE3(np.eye(3), each.point)
    ends = (("link1", each.link1), ("link2", each.link2))
    content = "".join(tag(end, {"link": link} | _placement(places[link].actInv(there), size)) for end, link in ends)
    content += tag("axis", {"xyz": _written(normal, 1.0)}) if each.type == "revolute" else ""
    return tag("loop_joint", {"name": each.name, "type": each.type}, content)


def _placement(place: pin.SE3, size: float) -> dict[str, str]:
    return {"xyz": _written(place.translation, size), "rpy": _written(pin.rpy.matrixToRpy(place.rotation), 1.0)}


def _written(numbers: Array | list[float], size: float = 0.0) -> str:
    """Numbers of a size; what is rounding beside it is zero."""
    return " ".join(repr(float(number) if abs(number) > BELOW_ROUNDING * size else 0.0) for number in numbers)
