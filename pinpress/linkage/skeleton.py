"""A small drawing of a linkage for notebooks, as SVG: links as lines and plates, bearings as circles with their names.

A planar linkage is seen along the normal of its plane, one in space from the front, the right and above.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
import pinocchio as pin

from ..common.outlets.labels import Labels
from ..common.quantities import Array
from ..engines.constraints import LoopJoint
from ..engines.structure import Axis, drawn_placements
from .machine_elements import Mesh

WIDTH, HEIGHT, MARGIN = 360.0, 260.0, 34.0  # of the picture [pixels]
LETTERS = 11.0  # size of letters [pixels]
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")  # Okabe and Ito
FRONT = np.array([0.1, -1.0, 0.5])  # a planar linkage is seen along its normal, from the side on which this direction lies
OBLIQUE = np.array([0.40, -0.80, 0.45])  # direction towards the viewer of a linkage in space
PARALLEL = 1e-6  # sine of the largest angle between axes that are drawn as parallel, and cosine to those that are drawn as perpendicular
HALF_BLOCK, RAIL_OVERHANG = 16.0, 8.0  # half the length of a slide's block; how far a rail goes on beyond each end of it [pixels]


class _Bearing(NamedTuple):
    """A bearing: its place in world axes [m], and the Pinocchio joints whose bodies it connects (0: the frame). A guide has its sliding
    body alone, since it stands for no pin on its carrier."""

    name: str
    point: Array
    bodies: tuple[int, ...]


class PitchCircle(NamedTuple):
    """The pitch circle of a gear or a pinion in the drawn pose, in world axes.

    Attributes:
        link: name of its link.
        joint: Pinocchio joint whose body the link belongs to.
        centre: (3,) [m].
        axis: (3,) unit vector.
        radius: [m].
    """

    link: str
    joint: int
    centre: Array
    axis: Array
    radius: float


def pitch_circles(model: pin.Model, meshes: Iterable[Mesh]) -> list[PitchCircle]:
    """Pitch circles of gears and pinions, which mesh in the drawn pose of a model; one for each mesh of a gear."""
    places, circles = drawn_placements(model), []
    for mesh in meshes:
        for link, centre, axis, radius in zip(mesh.links, mesh.on_carrier, mesh.axes, mesh.radii, strict=False):
            frame = model.frames[model.getFrameId(link, pin.BODY)]
            turned = places[frame.parentJoint].rotation @ frame.placement.rotation @ axis
            circles.append(PitchCircle(link, int(frame.parentJoint), centre, turned, radius))
    return circles


def skeleton(
    model: pin.Model,
    loops: Sequence[LoopJoint],
    axes: Sequence[Axis],
    links: Sequence[str],
    description: str,
    circles: Sequence[PitchCircle] = (),
) -> str:
    """SVG of a linkage in its drawn pose.

    Args:
        model: its tree.
        loops: the bearings at which loops were cut.
        axes: of the moving joints, each in the frame of its joint.
        links: name of the body of each Pinocchio joint, that of the frame first.
        description: for readers who do not see the picture.
        circles: pitch circles, of which those are drawn that lie in the plane of the picture.
    """
    places = drawn_placements(model)
    bearings = _bearings(model, loops, axes, places)
    directions = [places[joint].rotation @ axis.direction for joint, axis in enumerate(axes, 1)]
    guided = {joint: directions[joint - 1] for joint, axis in enumerate(axes, 1) if not axis.turns}
    right, up = _view(directions, axes)
    seen = [circle for circle in circles if np.linalg.norm(np.cross(circle.axis, np.cross(right, up))) < PARALLEL]
    around = [circle.centre + circle.radius * way for circle in seen for way in (right, -right, up, -up)]
    onto_sheet = np.array([*(bearing.point for bearing in bearings), *around]) @ np.array([right, up]).T
    points, ends = np.split(_onto_sheet(onto_sheet), [len(bearings)])
    size = {"width": f"{WIDTH:g}", "height": f"{HEIGHT:g}", "viewBox": f"0 0 {WIDTH:g} {HEIGHT:g}"}
    style = {"font-family": "sans-serif", "font-size": f"{LETTERS:g}", "fill": "currentColor", "role": "img", "aria-label": description}
    root = Element("svg", {"xmlns": "http://www.w3.org/2000/svg", **size, **style})
    labels = Labels((WIDTH, HEIGHT))
    corners = [  # of each body: its bearings on the sheet
        np.array([points[k] for k, bearing in enumerate(bearings) if joint in bearing.bodies]).reshape(-1, 2) for joint in range(len(links))
    ]
    for joint in guided:
        carrier = int(model.parents[joint])
        if carrier and len(corners[joint]) and len(corners[carrier]):
            _connection(root, corners[carrier].mean(axis=0), corners[joint].mean(axis=0), COLOURS[(carrier - 1) % len(COLOURS)])
            labels.line(np.array([corners[carrier].mean(axis=0), corners[joint].mean(axis=0)]), 2.5)
    for circle, (east, west, *_) in zip(seen, ends.reshape(-1, 4, 2), strict=True):
        (x, y), radius = (east + west) / 2, float(east[0] - west[0]) / 2
        colour = COLOURS[(circle.joint - 1) % len(COLOURS)] if circle.joint else "currentColor"
        look = {"fill": "none", "stroke": colour, "stroke-width": "1.5", "stroke-dasharray": "8 3 2 3"}  # as pitch circles are drawn
        SubElement(root, "circle", {"cx": f"{x:.1f}", "cy": f"{y:.1f}", "r": f"{radius:.1f}", **look})
        labels.circle(np.array([x, y]), radius)
    for joint, link in enumerate(links[1:], 1):
        colour = COLOURS[(joint - 1) % len(COLOURS)]
        if joint in guided and len(corners[joint]):
            along = np.array([guided[joint] @ right, -(guided[joint] @ up)])  # in an SVG y points down
            _block(
                root, corners[joint].mean(axis=0), along, on_frame=int(model.parents[joint]) == 0, link=link, colour=colour, labels=labels
            )
        if len(corners[joint]):
            _link(root, corners[joint], link, colour)
            around_it = _around(corners[joint])
            labels.line(np.vstack([around_it, around_it[:1]]), 2.5) if len(around_it) > 1 else labels.circle(around_it[0], 10.0)
    for (x, y), bearing in zip(points, bearings, strict=True):
        if 0 in bearing.bodies:  # the frame under it
            path = f"M{x:.1f} {y:.1f} l-9 14 h18 z M{x - 12:.1f} {y + 14:.1f} h24"
            look = {"fill": "none", "stroke": "currentColor", "stroke-opacity": "0.6", "stroke-width": "1.5"}
            SubElement(root, "path", {"d": path, **look})
            labels.line(np.array([[x, y], [x - 12, y + 14], [x + 12, y + 14], [x, y]]), 1.0)
    _pins(
        root, points, [bearing.name for bearing in bearings] if len(bearings) <= 24 else [], labels
    )  # names of more would cover the picture
    return tostring(root, encoding="unicode")


def _bearings(model: pin.Model, loops: Sequence[LoopJoint], axes: Sequence[Axis], places: Sequence[pin.SE3]) -> list[_Bearing]:
    """Joints that turn, and loops. A guide is a bearing only if its sliding body has no other; it is then at the origin of its joint."""
    bearings = [_Bearing(loop.name, places[loop.joint1].act(loop.point1), (loop.joint1, loop.joint2)) for loop in loops]
    joints = [
        _Bearing(model.names[joint], place.translation, (int(model.parents[joint]), joint)) for joint, place in enumerate(places) if joint
    ]
    bearings += [joint for joint, axis in zip(joints, axes, strict=True) if axis.turns]
    with_bearings = {body for bearing in bearings for body in bearing.bodies}
    return bearings + [guide._replace(bodies=guide.bodies[1:]) for guide in joints if guide.bodies[1] not in with_bearings]


def _view(directions: Sequence[Array], axes: Sequence[Axis]) -> tuple[Array, Array]:
    """Unit vectors (3,) to the right and upwards in the picture; ``directions``: of the joints' axes in the world."""
    turning = [direction for direction, axis in zip(directions, axes, strict=True) if axis.turns]
    normal = turning[0] if turning else np.array([0.0, -1.0, 0.0])
    sliding = [direction for direction, axis in zip(directions, axes, strict=True) if not axis.turns]
    planar = all(np.linalg.norm(np.cross(normal, other)) < PARALLEL for other in turning) and all(
        abs(normal @ other) < PARALLEL for other in sliding
    )
    towards = (normal if normal @ FRONT >= 0 else -normal) if planar else OBLIQUE / np.linalg.norm(OBLIQUE)
    right = np.cross((0.0, 0.0, 1.0), towards)
    right = right / np.linalg.norm(right) if np.linalg.norm(right) > PARALLEL else np.array([1.0, 0.0, 0.0])
    return right, np.cross(towards, right)


def _onto_sheet(points: Array) -> Array:
    """Points (k, 2) of the picture's plane [m] as places on the sheet [pixels]."""
    low, high = points.min(axis=0), points.max(axis=0)
    room = np.array([WIDTH, HEIGHT]) - 2 * MARGIN
    spans = high - low
    scale = min(room[spans > 1e-9 * max(spans)] / spans[spans > 1e-9 * max(spans)], default=1.0)
    away = (points - (low + high) / 2) * scale
    return np.asarray(np.array([WIDTH / 2, HEIGHT / 2]) + away * [1.0, -1.0])


def _link(root: Element, corners: Array, link: str, colour: str) -> None:
    """A bar, a plate or, of a link with one bearing, a disc."""
    look = {"fill": colour, "fill-opacity": "0.25", "stroke": colour, "stroke-width": "5", "stroke-linejoin": "round"}
    if len(corners) == 1:
        shape = SubElement(root, "circle", {"cx": f"{corners[0, 0]:.1f}", "cy": f"{corners[0, 1]:.1f}", "r": "9", **look})
    else:
        kind = "polygon" if len(corners) > 2 else "polyline"
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in _around(corners))
        shape = SubElement(root, kind, {"points": points, "stroke-linecap": "round", **look})
    SubElement(shape, "title").text = link


def _connection(root: Element, begin: Array, end: Array, colour: str) -> None:
    """A line from a link to what slides along it, as from a cylinder to its piston."""
    (x1, y1), (x2, y2) = begin, end
    ends = {"x1": f"{x1:.1f}", "y1": f"{y1:.1f}", "x2": f"{x2:.1f}", "y2": f"{y2:.1f}"}
    SubElement(root, "line", {**ends, "stroke": colour, "stroke-width": "5", "stroke-opacity": "0.45"})


def _around(corners: Array) -> Array:
    """Corners (k, 2) in their order around their middle, so that a plate's sides do not cross."""
    away = corners - corners.mean(axis=0)
    return corners[np.argsort(np.arctan2(away[:, 1], away[:, 0]))] if len(corners) > 2 else corners


def _block(root: Element, middle: Array, along: Array, *, on_frame: bool, link: str, colour: str, labels: Labels) -> None:
    """A sliding body, between two rails if the frame guides it; ``along``: (2,) direction of the guide on the sheet."""
    x, y = middle
    turn = {"transform": f"translate({x:.1f} {y:.1f}) rotate({np.degrees(np.arctan2(along[1], along[0])):.1f})"}
    box = {"x": f"{-HALF_BLOCK:g}", "y": "-11", "width": f"{2 * HALF_BLOCK:g}", "height": "22", "rx": "2"}
    block = SubElement(root, "rect", {**box, **turn, "fill": colour, "fill-opacity": "0.3", "stroke": colour, "stroke-width": "2"})
    SubElement(block, "title").text = link
    way = along / max(float(np.linalg.norm(along)), PARALLEL) if np.linalg.norm(along) > PARALLEL else np.array([1.0, 0.0])
    across = np.array([-way[1], way[0]])
    half = HALF_BLOCK + RAIL_OVERHANG * on_frame
    for side in (-14, 14) if on_frame else (-11, 11):
        labels.line(np.array([middle - half * way + side * across, middle + half * way + side * across]), 2.0)
    for end in (-HALF_BLOCK, HALF_BLOCK):
        labels.line(np.array([middle + end * way - 11 * across, middle + end * way + 11 * across]), 1.0)
    if on_frame:
        rails = "".join(f"M{-HALF_BLOCK - RAIL_OVERHANG:g} {side} H{HALF_BLOCK + RAIL_OVERHANG:g}" for side in (-14, 14))
        SubElement(root, "path", {"d": rails, **turn, "stroke": "currentColor", "stroke-opacity": "0.6", "stroke-width": "3"})


def _pins(root: Element, points: Array, names: Sequence[str], labels: Labels) -> None:
    """Circles at the bearings, then their names clear of all that is drawn; bearings in one place have one circle."""
    names_at: list[tuple[Array, list[str]]] = []
    for k, place in enumerate(points):
        names_here = next((others for point, others in names_at if np.abs(point - place).max() < 0.5), None)  # half a pixel
        if names_here is None:
            names_here = []
            names_at.append((place, names_here))
        if names:
            names_here.append(names[k])
    for place, _ in names_at:
        circle = {"cx": f"{place[0]:.1f}", "cy": f"{place[1]:.1f}", "r": "4", "fill": "#fff", "stroke": "#222", "stroke-width": "1.5"}
        SubElement(root, "circle", circle)
        labels.circle(place, 4.0)
    for place, names_here in names_at:
        if names_here:
            words = ", ".join(names_here)
            (x, y), end = labels.place(place, words, LETTERS)
            if end is not None:
                ends = {"x1": f"{place[0]:.1f}", "y1": f"{place[1]:.1f}", "x2": f"{end[0]:.1f}", "y2": f"{end[1]:.1f}"}
                SubElement(root, "line", {**ends, "stroke": "currentColor", "stroke-opacity": "0.6"})
            SubElement(root, "text", {"x": f"{x:.1f}", "y": f"{y:.1f}"}).text = words
