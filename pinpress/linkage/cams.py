"""Cams of a URDF in the drawing: the relation of the joints of cam and follower, and the contact of the cam with the roller."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TypedDict

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
    turning, following = _joints(cam, document, model)
    drawn = _geometry(cam, document, model)
    _refuse_unreached(cam, document, drawn)
    sense = drawn["sense"]
    law_points = points(cam, bool(axes(model)[following].turns))
    signed = ((point, sense * point.lift, _times(sense, point.slope), _times(sense, point.bend)) for point in law_points)
    law = CamLaw(tuple(point._replace(lift=lift, slope=slope, bend=bend) for point, lift, slope, bend in signed), cam.tabulated)
    curve = Curve(turning, law, math.radians(cam.drawn_at or 0.0))
    found = Relation(cam.name, {following: 1.0}, 0.0, cam.line, curve).through(np.zeros(model.nv))
    _check(cam, document, model, _contact(cam, 0, found, document, model))
    return found


def contacts(document: Document, model: pin.Model, relations: Sequence[Relation]) -> tuple[CamContact, ...]:
    """The contacts of all cams, whose relations are among these by their names."""
    indices = {relation.name: k for k, relation in enumerate(relations)}
    said = document.description.cams
    return tuple(_contact(cam, indices[cam.name], relations[indices[cam.name]], document, model) for cam in said)


def _contact(cam: Cam, k: int, relation: Relation, document: Document, model: pin.Model) -> CamContact:
    """The contact of a cam, whose relation is the k-th one of the linkage."""
    turning, following = _joints(cam, document, model)
    assert relation.curve is not None
    made = CamContact(
        name=cam.name,
        kind="cam",
        relation=k,
        first=turning + 1,
        second=following + 1,
        carrier=int(model.parents[turning + 1]),
        unit=UnitWrench(ZERO, ZERO),
        curve=relation.curve,
        radius=cam.radius,
        roller_radius=cam.roller_radius,
        roller_width=cam.roller_width,
        grooved=cam.kind == "groove",
        **_geometry(cam, document, model),
    )
    return replace(made, unit=made.wrench(np.zeros((model.nv, 1))))


def _joints(cam: Cam, document: Document, model: pin.Model) -> tuple[int, int]:
    """Indices in v of the joints of the cam and of its follower."""
    carriers, bodies = document.description.carriers, document.description.bodies
    places = {name: place for place, name in enumerate(tuple(model.names)[1:])}
    turning, following = (places[carriers[bodies[name]].name] for name in (cam.cam, cam.follower))
    return turning, following


def points(cam: Cam, turns: bool) -> tuple[CamPoint, ...]:
    """The points of the law in SI units; ``turns``: whether the follower is on an arm, whose lifts are angles."""
    unit = math.pi / 180 if turns else 1.0
    return tuple(
        CamPoint(math.radians(each.angle), unit * each.lift, each.law, _times(unit, each.slope), _times(unit, each.bend))
        for each in cam.points
    )


def _times(factor: float, value: float | None) -> float | None:
    return None if value is None else factor * value


class _Geometry(TypedDict):
    """The fields of a `CamContact` that follow from the drawing."""

    sense: float
    offset: float
    arm: float
    distance: float
    turning: float
    origin: Array
    axes: Array


def _geometry(cam: Cam, document: Document, model: pin.Model) -> _Geometry:
    """Where cam and follower are in the drawing; raises UrdfError where they are not in one plane."""
    turning, following = _joints(cam, document, model)
    directions = axes(model)
    of_cam, of_follower = (model.jointPlacements[joint + 1] for joint in (turning, following))
    normal, way = (place.rotation @ directions[j].direction for place, j in ((of_cam, turning), (of_follower, following)))
    turns, origin = directions[following].turns, of_cam.translation
    off = np.cross(normal, way) if turns else normal * (normal @ way)
    if np.abs(off).max() > IN_PLANE:
        remedy = "draw the pivot of the arm parallel to the axis of the cam" if turns else "draw the guide at a right angle to that axis"
        raise _refusal(cam, document, f"its follower does not move in the plane across the axis of the cam {cam.cam!r}", remedy)
    roller = None
    if cam.center is not None:
        frame = model.frames[model.getFrameId(cam.follower, pin.BODY)]
        roller = of_follower.act(frame.placement.act(np.array(cam.center)))
    # a camshaft may be long: the roller is in the plane of its follower
    origin = origin + normal * (normal @ ((of_follower.translation if roller is None else roller) - origin))
    if not turns:
        sense = 1.0 if roller is None else float(np.copysign(1.0, (roller - origin) @ way))
        across = np.cross(sense * way, normal)
        plane = np.array([across, np.cross(normal, across)]) / np.linalg.norm(across)
        offset = cam.offset or 0.0 if roller is None else float((roller - origin) @ plane[0])
        return _Geometry(sense=sense, offset=offset, arm=0.0, distance=0.0, turning=0.0, origin=origin, axes=plane)
    to_pivot = of_follower.translation - origin
    to_pivot = to_pivot - normal * (normal @ to_pivot)
    distance = float(np.linalg.norm(to_pivot))
    if not distance > DRAWN * cam.radius:
        raise _refusal(cam, document, "the arm of its follower turns about the axis of the cam", "draw the pivot beside the cam")
    plane = np.array([to_pivot, np.cross(normal, to_pivot)]) / distance
    same = float(np.copysign(1.0, normal @ way))
    if roller is None:
        return _Geometry(sense=1.0, offset=0.0, arm=cam.arm or 0.0, distance=distance, turning=same, origin=origin, axes=plane)
    x, y = plane @ (roller - origin)
    turned = float(np.copysign(1.0, np.angle(-complex(x - distance, y))))
    return _Geometry(
        sense=turned * same, offset=0.0, arm=math.hypot(x - distance, y), distance=distance, turning=turned, origin=origin, axes=plane
    )


def _refuse_unreached(cam: Cam, document: Document, drawn: _Geometry) -> None:
    """Raise UrdfError for a roller that does not reach the radius of the cam."""
    arm, distance, offset = drawn["arm"], drawn["distance"], drawn["offset"]
    if arm and not abs(distance - arm) < cam.radius < distance + arm:
        problem = f"its arm of {arm:g} m, {distance:g} m away from the cam, does not reach the radius {cam.radius:g} m"
        raise _refusal(cam, document, problem, "write a radius between the difference and the sum of these lengths")
    if not arm and not abs(offset) < cam.radius:
        problem = f"its radius is {cam.radius:g} m, and the centre of the roller passes the cam at {abs(offset):g} m"
        raise _refusal(cam, document, problem, "write a larger radius, or a centre nearer to the line of the guide through the cam")


def _check(cam: Cam, document: Document, model: pin.Model, made: CamContact) -> None:
    """Raise UrdfError for a roller that is led too far or too near, is drawn elsewhere than the law has it, or undercuts the cam."""
    lowest, highest = -made.largest(lambda states: -states.lift)[0], made.largest(lambda states: states.lift)[0]
    if made.start + lowest <= 0.0 or (made.arm and made.start + highest >= np.pi):
        problem = "its lifts lead the roller beyond the line on which it is nearest to or farthest from the cam"
        raise _refusal(cam, document, problem, "write smaller lifts or a larger radius")
    nearest = -made.largest(lambda states: -np.abs(states.roller))[0]
    if nearest <= cam.roller_radius:
        problem = f"its roller has a radius of {cam.roller_radius:g} m, and its centre comes to {nearest:.6g} m from the axis of the cam"
        raise _refusal(cam, document, problem, "write a larger radius or a smaller roller")
    if cam.center is not None:
        frame = model.frames[model.getFrameId(cam.follower, pin.BODY)]
        roller = model.jointPlacements[made.second].act(frame.placement.act(np.array(cam.center)))
        drawn, angle = float(np.linalg.norm(roller - made.origin)), made.curve.start
        wanted = abs(complex(made.at(np.array([angle])).roller[0]))
        if abs(drawn - wanted) > DRAWN * cam.radius:
            problem = f"its roller is drawn {drawn:.6g} m from the axis of the cam, and the law has it at {wanted:.6g} m at"
            remedy = "draw it there, or write the angle of the law in the drawn pose: drawn_at"
            raise _refusal(cam, document, f"{problem} {math.degrees(angle):g} deg, as in the drawn pose", remedy)
    curvature, angle = made.largest(lambda states: np.abs(states.curvature) if made.grooved else states.curvature)
    if curvature * cam.roller_radius >= 1.0:
        path = f"the path of its roller has a radius of {1 / curvature:.4g} m at {math.degrees(angle):.4g} deg"
        problem = f"the cam is undercut: {path}, not more than that of the roller, {cam.roller_radius:g} m"
        raise _refusal(cam, document, problem, "write a smaller roller, a larger radius, or more angle for the lift")


def _refusal(cam: Cam, document: Document, problem: str, remedy: str) -> UrdfError:
    return UrdfError(document.file, document.called("cam", cam.name), cam.line, problem, remedy)
