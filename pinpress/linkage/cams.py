"""Cams of a URDF in the drawing: the relation of the joints of cam and follower, and the contact of the cam with the roller."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from ..common.errors import UrdfError
from ..common.quantities import Array
from ..engines.constraints import Curve, Relation
from ..engines.contacts import ZERO, UnitWrench
from ..engines.machine_elements.cams import CamContact, CamLaw, CamPoint
from ..engines.structure import axes
from .description import Cam
from .document import Document

IN_PLANE = 1e-6  # sine of an angle up to which a direction counts as drawn right: files round them to some six digits
DRAWN = 1e-3  # share of the radius by which the drawn roller may be away from where the law has it: drawings are rounded


def relation(cam: Cam, document: Document, model: pin.Model) -> Relation:
    """The relation of the joints of a cam and its follower.

    Raises:
        UrdfError: the drawing does not suit the cam, or the cam is undercut.
    """
    contact = _drawn(cam, document, model)
    _check(cam, document, model, contact)
    return Relation(cam.name, {contact.second - 1: 1.0}, 0.0, cam.line, contact.curve).through(np.zeros(model.nv))


def contacts(document: Document, model: pin.Model, relations: Sequence[Relation]) -> Iterator[CamContact]:
    """The contacts of all cams, whose relations are among these by their names."""
    indices = {relation.name: k for k, relation in enumerate(relations)}
    for cam in document.description.cams:
        k = indices[cam.name]
        curve = relations[k].curve  # which may start elsewhere than that of the file
        assert curve is not None
        contact = replace(_drawn(cam, document, model), relation=k, curve=curve)
        yield replace(contact, unit=contact.wrench(np.zeros((model.nv, 1))))


def points(cam: Cam, unit: float) -> tuple[CamPoint, ...]:
    """The points of the law, with lifts by the unit of those in the file, and angles [rad]."""

    def times(value: float | None) -> float | None:
        return None if value is None else unit * value

    return tuple(
        CamPoint(math.radians(point.angle), unit * point.lift, point.law, times(point.slope), times(point.bend)) for point in cam.points
    )


def _drawn(cam: Cam, document: Document, model: pin.Model) -> CamContact:
    """The contact of a cam in the drawn pose, without its relation; raises UrdfError if cam and follower are not in one plane."""
    said, names, directions = document.description, list(model.names), axes(model)
    first, second = (names.index(said.carriers[said.bodies[link]].name) for link in (cam.cam, cam.follower))
    of_cam, of_follower = model.jointPlacements[first], model.jointPlacements[second]
    normal, way = of_cam.rotation @ directions[first - 1].direction, of_follower.rotation @ directions[second - 1].direction
    turns, roller = directions[second - 1].turns, _drawn_roller(cam, model, second)
    off = np.cross(normal, way) if turns else normal * (normal @ way)
    if np.abs(off).max() > IN_PLANE:
        remedy = "draw the pivot of the arm parallel to the axis of the cam" if turns else "draw the guide at a right angle to that axis"
        raise _refusal(cam, document, f"its follower does not move in the plane across the axis of the cam {cam.cam!r}", remedy)
    # a camshaft may be long: the roller is in the plane of its follower
    origin = of_cam.translation + normal * (normal @ ((of_follower.translation if roller is None else roller) - of_cam.translation))
    sense, offset, arm, distance, turning = 1.0, 0.0, 0.0, 0.0, 0.0
    if turns:
        to_pivot = of_follower.translation - origin
        to_pivot = to_pivot - normal * (normal @ to_pivot)
        distance = float(np.linalg.norm(to_pivot))
        if not distance > DRAWN * cam.radius:
            raise _refusal(
                cam, document, "the arm of its follower turns about the axis of the cam", "draw the pivot away from the axis of the cam"
            )
        plane = np.array([to_pivot, np.cross(normal, to_pivot)]) / distance
        arm, turning = cam.arm or 0.0, float(np.copysign(1.0, normal @ way))
        if roller is not None:
            x, y = plane @ (roller - origin) - [distance, 0.0]
            arm, sense = math.hypot(x, y), turning * float(np.copysign(1.0, np.angle(-complex(x, y))))
            turning *= sense
    else:
        sense = 1.0 if roller is None else float(np.copysign(1.0, (roller - origin) @ way))
        across = np.cross(sense * way, normal)
        plane = np.array([across, np.cross(normal, across)]) / np.linalg.norm(across)
        offset = cam.offset or 0.0 if roller is None else float((roller - origin) @ plane[0])
    law = CamLaw(points(cam, sense * (math.pi / 180 if turns else 1.0)), cam.tabulated)
    return CamContact(
        name=cam.name,
        kind="cam",
        relation=-1,
        first=first,
        second=second,
        carrier=int(model.parents[first]),
        unit=UnitWrench(ZERO, ZERO),
        curve=Curve(first - 1, law, math.radians(cam.drawn_at or 0.0)),
        sense=sense,
        radius=cam.radius,
        offset=offset,
        arm=arm,
        distance=distance,
        turning=turning,
        roller_radius=cam.roller_radius,
        roller_width=cam.roller_width,
        grooved=cam.kind == "groove",
        origin=origin,
        axes=plane,
    )


def _drawn_roller(cam: Cam, model: pin.Model, joint: int) -> Array | None:
    """The centre (3,) of the roller of a follower, in the frame of the carrier's joint [m]; None if it is not drawn."""
    if cam.center is None:
        return None
    frame = model.frames[model.getFrameId(cam.follower, pin.BODY)]
    return np.asarray(model.jointPlacements[joint].act(frame.placement.act(np.array(cam.center))))


def _check(cam: Cam, document: Document, model: pin.Model, made: CamContact) -> None:
    """Raise UrdfError for a roller that does not reach the radius of the cam, comes too near or goes too far, is not drawn where the law
    puts it, or undercuts the cam."""
    if made.arm and not abs(made.distance - made.arm) < cam.radius < made.distance + made.arm:
        problem = f"its arm of {made.arm:g} m, {made.distance:g} m away from the cam, does not reach the radius {cam.radius:g} m"
        raise _refusal(cam, document, problem, "write a radius between the difference and the sum of these lengths")
    if not made.arm and not abs(made.offset) < cam.radius:
        problem = f"its radius is {cam.radius:g} m, and the centre of the roller passes the cam at {abs(made.offset):g} m"
        raise _refusal(cam, document, problem, "write a larger radius, or a centre nearer to the line of the guide through the cam")
    lowest, highest = -made.largest(lambda states: -states.lift)[0], made.largest(lambda states: states.lift)[0]
    if made.start + lowest <= 0.0 or (made.arm and made.start + highest >= np.pi):
        problem = "its lifts lead the roller beyond the line on which it is nearest to or farthest from the cam"
        raise _refusal(cam, document, problem, "write smaller lifts or a larger radius")
    nearest = -made.largest(lambda states: -np.abs(states.roller))[0]
    if nearest <= cam.roller_radius:
        problem = f"its roller has a radius of {cam.roller_radius:g} m, and its centre comes to {nearest:.6g} m from the axis of the cam"
        raise _refusal(cam, document, problem, "write a larger radius or a smaller roller")
    if (roller := _drawn_roller(cam, model, made.second)) is not None:
        drawn, angle = float(np.linalg.norm(roller - made.origin)), made.curve.start
        wanted = abs(complex(made.at(np.array([angle])).roller[0]))
        if abs(drawn - wanted) > DRAWN * cam.radius:
            problem = f"its roller is drawn {drawn:.6g} m from the axis of the cam, and the law has it at {wanted:.6g} m at"
            remedy = "draw it there, or write the angle of the law in the drawn pose: drawn_at"
            raise _refusal(cam, document, f"{problem} {math.degrees(angle):g} deg, as in the drawn pose", remedy)
    curvature, angle = made.largest(lambda states: np.abs(states.curvature) if made.grooved else states.curvature)
    if curvature * cam.roller_radius >= 1.0:
        path = f"the path of its roller has a radius of {1 / curvature:.4g} m at {math.degrees(angle):.4g} deg"
        problem = f"the cam is undercut: {path}, not more than the radius of the roller, {cam.roller_radius:g} m"
        raise _refusal(cam, document, problem, "write a smaller roller, a larger radius, or more angle for the lift")


def _refusal(cam: Cam, document: Document, problem: str, remedy: str) -> UrdfError:
    return UrdfError(document.file, document.called("cam", cam.name), cam.line, problem, remedy)
