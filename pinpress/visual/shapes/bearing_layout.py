"""The skeleton of made-up shapes: the bearings of the links in the drawn pose."""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pinocchio as pin

from ...common.errors import PinpressError
from ...common.quantities import Array
from ...engines.structure import drawn_placements
from ...linkage.linkage import Linkage
from ...linkage.writing import AddedBallast

PARALLEL = 1e-6  # axes closer than this are drawn as parallel [rad]
TOWARDS = np.array([0.1, -1.0, 0.5])  # direction towards the viewer


@dataclass(frozen=True, eq=False)
class PlacedBearing:
    """A joint or a cut loop in the drawn pose, world axes. Side 0 is the parent's or link1's, side 1 the child's or link2's.

    Attributes:
        kind: "pin", "ball" (only in space; rotates about all axes), "guide" (slides) or "weld".
        links: the links of the two sides; None for a side whose link needs no made-up shapes.
        on_frame: whether each side is fixed to the frame.
        points: (2, 3) places of the two sides [m].
        axis: (3,) unit vector of the axis; not used for a ball and for a weld in space.
        travel: lowest and highest position of a guide [m].
    """

    kind: str
    links: tuple[str | None, str | None]
    on_frame: tuple[bool, bool]
    points: Array
    axis: Array
    travel: tuple[float, float]


@dataclass(frozen=True, eq=False)
class BodyMass:
    """The mass of a link and of the links welded to it, in the drawn pose, world axes.

    Attributes:
        mass: mass [kg].
        centre: (3,) centre of mass [m].
        gyration: (3, 3) squared radii of gyration about the centre, as a tensor [m2].
    """

    mass: float
    centre: Array
    gyration: Array


@dataclass(frozen=True, eq=False)
class Ballast:
    """A counterweight.

    Attributes:
        mass: mass [kg].
        centre: (3,) centre of mass, in world axes in the drawn pose [m].
    """

    mass: float
    centre: Array


@dataclass(frozen=True, eq=False)
class BearingLayout:
    """Bearings in the drawn pose, world axes.

    Attributes:
        links: the links that need made-up shapes, in document order.
        on_frame: those of ``links`` that are the frame or fixed to it.
        placements: link -> (4, 4) placement of its frame, for all links.
        bearings: joints, then cut loops.
        normal: (3,) normal of a planar linkage, towards the viewer; None for a linkage in space.
        welded: link -> origin (3,) at which it is welded to other links, if the visuals of those links show its body [m].
        masses: link -> its mass, if it has one; without counterweights that were added since the linkage was read.
        added: link -> the counterweight that was added since then.
        cranks: links that turn fully on the frame, or are driven on it.
        turning: joints of all such links, also of links with visuals.
        slide: the slide, if it needs made-up shapes; otherwise None.
        upwards: (3,) unit vector along which the slide's position grows; None without a slide.
        size: size of the linkage [m].
    """

    links: tuple[str, ...]
    on_frame: frozenset[str]
    placements: Mapping[str, Array]
    bearings: tuple[PlacedBearing, ...]
    normal: Array | None
    welded: Mapping[str, Array]
    masses: Mapping[str, BodyMass]
    added: Mapping[str, Ballast]
    cranks: frozenset[str]
    turning: frozenset[int]
    slide: str | None
    upwards: Array | None
    size: float

    def ends(self, link: str) -> list[tuple[PlacedBearing, int]]:
        """The bearings of a link, each with the link's side of it."""
        return self._ends.get(link, [])

    @cached_property
    def _ends(self) -> dict[str | None, list[tuple[PlacedBearing, int]]]:
        ends: dict[str | None, list[tuple[PlacedBearing, int]]] = {}
        for bearing in self.bearings:
            for side in (0, 1):
                ends.setdefault(bearing.links[side], []).append((bearing, side))
        return ends

    def nodes(self, link: str) -> Array:
        """(k, 3) distinct places that a link connects, projected on the plane of a planar linkage.

        If all bearings of a link are in one place, its centre of mass is a second place; for a slide, a place in the direction of its
        centre of mass.
        """
        points = [bearing.points[side] for bearing, side in self.ends(link)] + ([self.welded[link]] if link in self.welded else [])
        nodes = self._distinct(points)
        if len(nodes) == 1 and link in self.masses:
            away = self.flat(self.masses[link].centre - nodes[0])
            distance = float(np.linalg.norm(away))
            slides = any(bearing.kind == "guide" and side == 1 for bearing, side in self.ends(link))
            if 0.02 * self.size < distance < 2 * self.size:
                nodes = self._distinct([nodes[0], nodes[0] + away * min(1.0, 0.15 * self.size / distance if slides else 1.0)])
        return nodes

    def flat(self, points: Array) -> Array:
        """Points projected on the plane of a planar linkage."""
        return points if self.normal is None else points - np.multiply.outer(points @ self.normal, self.normal)

    def disc_radius(self, link: str, axis: Array, least: float) -> float:
        """Radius of the disc about an axis (3,) with the inertia of a link, within limits; ``least`` for a link without mass [m]."""
        if link not in self.masses:
            return least
        gyration = float(axis @ self.masses[link].gyration @ axis)
        return float(np.clip(math.sqrt(2 * max(gyration, 0.0)), least, 0.1 * self.size))

    def _distinct(self, points: list[Array]) -> Array:
        kept: list[Array] = []
        for point in map(self.flat, points):
            if all(np.linalg.norm(point - other) > 1e-6 * self.size for other in kept):
                kept.append(point)
        return np.array(kept).reshape(-1, 3)

    @cached_property
    def width(self) -> float:
        """Width of a bar: proportional to the linkage's size, smaller if links are short [m]."""
        lengths = [np.linalg.norm(b - a) for link in self.links if link not in self.on_frame for a, b in tree(self.nodes(link))]
        return float(np.clip(0.5 * min(lengths, default=np.inf), 0.03 * self.size, 0.042 * self.size))


def tree(nodes: Array) -> list[tuple[Array, Array]]:
    """The shortest lines that connect all nodes (k, 3) (minimum spanning tree)."""
    lines, reached = [], [0]
    nearest = {j: (float(np.linalg.norm(node - nodes[0])), 0) for j, node in enumerate(nodes) if j}  # distance, and the reached node
    while nearest:
        j = min(nearest, key=lambda j: (nearest[j], j))
        lines.append((nodes[reached[nearest.pop(j)[1]]], nodes[j]))
        for other, (distance, _) in nearest.items():
            if (closer := float(np.linalg.norm(nodes[other] - nodes[j]))) < distance:
                nearest[other] = (closer, len(reached))
        reached.append(j)
    return lines


def lay_out_bearings(press: Linkage, travel: Array, drawn: Collection[str], added: Mapping[int, AddedBallast]) -> BearingLayout:
    """Lay out the bearings of a press in the drawn pose; of one that is drawn open, in its home pose.

    Links that are welded together are drawn as their first link, unless one of them has visuals.

    Args:
        press: the linkage.
        travel: (2, nv) lowest and highest positions of the joints [rad or m].
        drawn: links that have visuals.
        added: counterweights that were added since the linkage was read, by the joint.

    Raises:
        PinpressError: the drawn pose is not finite.
    """
    if press.home:
        press, travel = press.drawn_at_home(), travel - press.closed
    model, places = press.model, drawn_placements(press.model)
    frames = {link: model.getFrameId(link, pin.BODY) for link in press.links}
    joint = {link: model.frames[frame].parentJoint for link, frame in frames.items()}
    mixed = {joint[link] for link in press.links if link in drawn}
    first: dict[int, str] = {}
    for frame in model.frames:  # in the order of the tree
        if frame.type == pin.BODY:
            first.setdefault(frame.parentJoint, frame.name)

    def owner(link: str) -> str | None:
        if joint[link] not in mixed:
            return first[joint[link]]
        return None if link in drawn else link

    bearings = _bearings(press, places, travel, owner, joint)
    normal = _normal(bearings)
    if normal is not None:
        bearings = [
            b if b.kind in ("pin", "guide") else replace(b, kind="pin" if b.kind == "ball" else b.kind, axis=normal) for b in bearings
        ]
    links = tuple(link for link in press.links if owner(link) == link)
    placements = {link: (places[joint[link]] * model.frames[frame].placement).homogeneous for link, frame in frames.items()}
    welded = {link: placements[link][:3, 3] for link in links if joint[link] in mixed and link != press.root}
    own = {link: joint[link] for link in links if joint[link] not in mixed | {0}}
    masses = {}
    for link, j in own.items():
        body = added[j].before if j in added else model.inertias[j]
        if body.mass > 0:
            turned = places[j].rotation
            with np.errstate(all="ignore"):
                gyration = turned @ body.inertia @ turned.T / body.mass
            if np.isfinite(gyration).all():  # overflows for a tiny mass
                masses[link] = BodyMass(body.mass, places[j].act(body.lever), gyration)
    since = {link: Ballast(added[j].mass, places[j].act(added[j].centre)) for link, j in own.items() if j in added}
    turning = frozenset(
        j + 1
        for j, (name, axis) in enumerate(zip(press.joints, press.axes, strict=True))
        if axis.turns and model.parents[j + 1] == 0 and (name in press.drivers or np.ptp(travel[:, j]) > 0.98 * 2 * math.pi)
    )
    cranks = frozenset(crank for j in turning if (crank := bearings[j - 1].links[1]) is not None)
    slide, upwards = (None, None) if press.slide is None else (owner(press.slide), press.slide_direction)
    points = np.concatenate([b.points for b in bearings])
    if not np.isfinite(points).all():
        raise PinpressError(f"the drawn pose of {press.name} is not finite: its model's joints have no place; load it again")
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    if size == 0:
        reaches = (float(np.linalg.norm(body.centre - points[0]) + np.sqrt(np.trace(body.gyration) / 2)) for body in masses.values())
        size = 4 * max(reaches, default=0.0) or 1.0
    on_frame = frozenset(link for link in links if joint[link] == 0)
    layout = BearingLayout(
        links, on_frame, placements, tuple(bearings), normal, welded, masses, since, cranks, turning, slide, upwards, size
    )
    # a link without other bearings that is welded to a link with visuals is left out, because the other link shows it
    stubs = {link for link in welded if len(layout.nodes(link)) < 2}
    without = [replace(each, links=tuple(None if link in stubs else link for link in each.links)) for each in bearings]  # type: ignore[arg-type]
    return replace(layout, links=tuple(link for link in links if link not in stubs), bearings=tuple(without))


def _bearings(
    press: Linkage, places: Sequence[pin.SE3], travel: Array, owner: Callable[[str], str | None], joint: Mapping[str, int]
) -> list[PlacedBearing]:
    description = press.document.description
    between = {j.name: (j.parent, j.child) for j in description.joints}
    between |= {loop.name: (loop.link1.link, loop.link2.link) for loop in description.loops}

    def bearing(name: str, kind: str, points: list[Array], axis: Array, low: float, high: float) -> PlacedBearing:
        one, other = between[name]
        return PlacedBearing(kind, (owner(one), owner(other)), (joint[one] == 0, joint[other] == 0), np.array(points), axis, (low, high))

    bearings = []
    for j, (name, (direction, turns)) in enumerate(zip(press.joints, press.axes, strict=True)):
        place, (low, high) = places[j + 1], travel[:, j].tolist()
        bearings.append(bearing(name, "pin" if turns else "guide", [place.translation] * 2, place.rotation @ direction, low, high))
    kinds = {"revolute": "pin", "spherical": "ball", "fixed": "weld"}
    for loop in press.loops:
        points = [places[loop.joint1].act(loop.point1), places[loop.joint2].act(loop.point2)]
        bearings.append(bearing(loop.name, kinds[loop.type], points, places[loop.joint1].rotation @ loop.rotation1[:, 0], 0.0, 0.0))
    return bearings


def _normal(bearings: list[PlacedBearing]) -> Array | None:
    """Normal of the plane of a linkage with parallel pins and guides perpendicular to them; otherwise None."""
    axes = {kind: [bearing.axis for bearing in bearings if bearing.kind == kind] for kind in ("pin", "guide")}
    if not axes["pin"]:
        return None
    normal = axes["pin"][0]
    if any(np.linalg.norm(np.cross(normal, axis)) > PARALLEL for axis in axes["pin"]):
        return None
    if any(abs(normal @ axis) > PARALLEL for axis in axes["guide"]):
        return None
    return -normal if normal @ TOWARDS < 0 else normal
