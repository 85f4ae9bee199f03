"""The numbers of a linkage that the window can change: lengths of links, angles in them, and places of pivots on the frame.

A pivot of a link that turns is given by its distance from the link's origin, the bearing on its parent. If the link has more pivots, its
direction there is a number too. A pivot of the frame or of a slide is given by its coordinates, a guide or slot by its offset
across itself. In a linkage in space all pivots are given by coordinates in the frames of their links. Pivots of a link at the same point
move together. So do equal dimensions that cannot change alone, as in the two halves of a symmetric press, whose loops would not close.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from ..common.errors import PinpressError
from ..common.quantities import Array
from ..derivatives.motion import motion_derivatives, pivot_positions
from ..engines.planar.engine import PlanarEngine
from ..engines.structure import drawn_placements
from ..kinematics.cycle import cycle
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from .drivers import swing, swings

SAME = 1e-9  # share of the linkage's size: positions that are the same
REACH = 0.25  # share of the linkage's size by which a coordinate may be changed with its slider
TURN = 45.0  # by which an angle may be changed with its slider [deg]

Pivot = tuple[str, str]
"""Bearing and link, see `pivot_positions`."""


@dataclass(frozen=True)
class Dimension:
    """A number of a press that can be changed, as a slider shows it.

    Attributes:
        group: what it belongs to: a link, or a part of a table.
        name: of the number in its group.
        unit: in which it is shown, "" where it has none.
        value: the number, in this unit.
        low: lower end of its slider.
        high: upper end of its slider.
        step: of its slider.
        note: what else is known of it.
    """

    group: str
    name: str
    unit: str
    value: float
    low: float
    high: float
    step: float
    note: str = ""


def dimension(group: str, name: str, unit: str, value: float, reach: float | None, note: str = "") -> Dimension:
    """A dimension with ends and a step that are round numbers.

    Args:
        group: see `Dimension`.
        name: see `Dimension`.
        unit: see `Dimension`.
        value: see `Dimension`.
        reach: by how much its slider goes either way; None of a length, from half of it to half as much again.
        note: see `Dimension`.
    """
    half = abs(value) / 2 if reach is None else reach
    step = 10.0 ** math.floor(math.log10(2 * half / 300))  # a slider has 300 steps at least
    low, high = step * math.floor((value - half) / step), step * math.ceil((value + half) / step)
    return Dimension(group, name, unit, value, float(f"{low:.9g}"), float(f"{high:.9g}"), float(f"{step:.9g}"), note)


@dataclass(frozen=True, eq=False)
class _Part:
    """How pivots of one link at the same point are changed by one number.

    Attributes:
        pivots: the pivots.
        kind: "length" or "angle" from the link's origin, or "along" a direction.
        direction: (3,) unit vector in the link's frame; of an angle the normal about which it turns.
        value: the number now [m or rad].
        sign: -1 if it decreases when the number increases, else 1.
    """

    pivots: tuple[Pivot, ...]
    kind: str
    direction: Array
    value: float
    sign: float = 1.0


@dataclass(frozen=True, eq=False)
class LinkageDimensions:
    """The dimensions of a linkage, and what they move.

    Attributes:
        shown: the dimensions.
    """

    shown: tuple[Dimension, ...]
    _parts: tuple[tuple[_Part, ...], ...]
    _places: Mapping[Pivot, Array]
    _scale: tuple[float, ...]  # shown units to SI

    @staticmethod
    def of(press: Linkage) -> LinkageDimensions:
        """The dimensions of a linkage that can be changed."""
        places = pivot_positions(press)
        able = list(_that_close(press, places, list(_parts(press, places))))[:200]  # a window with more is of no use
        unit, metres = ("m", 1.0) if press.size > 50 else ("mm", 1e-3) if press.size > 0.02 else ("µm", 1e-6)
        shown, scale = [], []
        for parts in able:
            first = parts[0]
            group = " and ".join(dict.fromkeys(part.pivots[0][1] for part in parts))
            name = _named(press, parts)
            if first.kind == "angle":
                shown.append(dimension(group, name, "deg", float(f"{math.degrees(first.value):.12g}"), TURN))
            else:
                reach = None if first.kind == "length" else REACH * press.size / metres
                shown.append(dimension(group, name, unit, float(f"{first.value / metres:.12g}"), reach))
            scale.append(math.radians(1.0) if first.kind == "angle" else metres)
        return LinkageDimensions(tuple(shown), tuple(able), places, tuple(scale))

    def pivots(self, values: Sequence[float]) -> dict[Pivot, Array]:
        """Places of the pivots that other values of the dimensions move [m]; pivots that stay are left out."""
        changes = (
            (parts, scale * (value - each.value))
            for each, parts, scale, value in zip(self.shown, self._parts, self._scale, values, strict=True)
            if value != each.value
        )
        return _moved(self._places, changes)


def _named(press: Linkage, parts: Sequence[_Part]) -> str:
    """What is changed, by the names of bearings."""
    said = []
    for part in parts:
        bearings = ", ".join(dict.fromkeys(bearing for bearing, _ in part.pivots))
        if part.kind == "along":
            said.append(f"{bearings} {_axis(part.direction)}")
            continue
        hung = press.joints[_frame(press, part.pivots[0][1]).parentJoint - 1]
        said.append(f"{hung} to {bearings}" + (", direction" if part.kind == "angle" else ""))
    return " and ".join(dict.fromkeys(said))


def _axis(direction: Array) -> str:
    """Name of a direction: an axis, or where it lies across a guide "offset"."""
    axis = int(np.argmax(np.abs(direction)))
    return "xyz"[axis] if abs(direction[axis]) > 1 - 1e-9 else "offset"


def _frame(press: Linkage, link: str) -> pin.Frame:
    return next(frame for frame in press.model.frames if frame.name == link)


def _parts(press: Linkage, places: Mapping[Pivot, Array]) -> Iterator[_Part]:
    """What one number changes each, without regard to whether the loops then close."""
    normal, drawn = _normal(press), drawn_placements(press.model)
    by_link: dict[str, list[Pivot]] = {link: [] for link in (*(link for link in press.links if link != press.root), press.root)}
    for bearing, link in places:
        by_link[link].append((bearing, link))
    for link, pivots in by_link.items():
        joint = _frame(press, link).parentJoint
        slides = joint == 0 or not press.axes[joint - 1].turns
        turned = np.eye(3) if joint == 0 else drawn[joint].rotation @ _frame(press, link).placement.rotation
        across = None if normal is None else turned.T @ normal  # in the link's frame
        groups: list[list[Pivot]] = []
        for pivot in pivots:
            if (guide := _guide(press, pivot)) is not None:
                if across is not None:
                    sideways = np.cross(across, guide)
                    yield _Part((pivot,), "along", _positive(sideways), float(places[pivot] @ _positive(sideways)))
                continue
            near = next((g for g in groups if np.abs(places[g[0]] - places[pivot]).max() <= SAME * press.size), None)
            if near is None:
                groups.append([pivot])
            else:
                near.append(pivot)
        for group in groups:
            at = places[group[0]]
            flat = at if across is None else at - (at @ across) * across
            away = float(np.linalg.norm(flat))
            if across is None or slides or away <= SAME * press.size:
                for direction in np.eye(3) if across is None else _in_plane(across):
                    yield _Part(tuple(group), "along", direction, float(at @ direction))
                continue
            yield _Part(tuple(group), "length", across, away)
            if len(groups) > 1:
                first, second = _in_plane(across)
                yield _Part(tuple(group), "angle", across, math.atan2(float(flat @ second), float(flat @ first)))


def _normal(press: Linkage) -> Array | None:
    """(3,) normal of the plane of a planar linkage in the drawn pose; None of one in space."""
    engine = press.engine()
    return np.asarray(engine.plane.normal) if isinstance(engine, PlanarEngine) else None


def _guide(press: Linkage, pivot: Pivot) -> Array | None:
    """(3,) direction of a guide in the frame of its link; None of a pin."""
    bearing, link = pivot
    if bearing not in press.joints:
        return None
    joint = press.joints.index(bearing) + 1
    axis = press.axes[joint - 1]
    if axis.turns:
        return None
    return np.asarray(_frame(press, link).placement.rotation.T @ press.model.jointPlacements[joint].rotation @ axis.direction)


def _in_plane(normal: Array) -> tuple[Array, Array]:
    """Two directions (3,) of a plane, along axes where the plane has them; the second is a quarter turn about -normal or normal, so that
    angles count from the first to the second."""
    axes = [axis for axis in np.eye(3) if abs(axis @ normal) < 1e-9]
    first = axes[0] if axes else np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first = first / np.linalg.norm(first)
    return first, _positive(np.cross(normal, first))


def _positive(direction: Array) -> Array:
    """A direction (3,), of it and its opposite the one along whose main axis coordinates grow."""
    return np.asarray(direction if direction[int(np.argmax(np.abs(direction)))] > 0 else -direction)


def _moved(places: Mapping[Pivot, Array], changes: Iterable[tuple[Sequence[_Part], float]]) -> dict[Pivot, Array]:
    """Where pivots are after changes [m or rad] of what parts say."""
    now: dict[Pivot, Array] = {}
    for parts, change in changes:
        for part in parts:
            for pivot in part.pivots:
                at = now.get(pivot, places[pivot])
                if part.kind == "along":
                    at = at + part.sign * change * part.direction
                elif part.kind == "length":
                    along = at - (at @ part.direction) * part.direction
                    at = at + part.sign * change * along / np.linalg.norm(along)
                else:
                    at = _turned(at, part.direction, part.sign * change)
                now[pivot] = at
    return now


def _turned(at: Array, normal: Array, angle: float) -> Array:
    """A point turned about the normal of the plane, in the sense in which `_in_plane` counts angles."""
    first, second = _in_plane(normal)
    along = (at @ normal) * normal
    x, y = float(at @ first), float(at @ second)
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(along + (c * x - s * y) * first + (s * x + c * y) * second)


def _that_close(press: Linkage, places: Mapping[Pivot, Array], parts: Sequence[_Part]) -> Iterator[tuple[_Part, ...]]:
    """Parts that can change alone, and equal parts that can only change together, two or all."""
    engine = press.engine()
    if not (isinstance(engine, PlanarEngine) and engine.plane.redundant):
        yield from ((part,) for part in parts)
        return
    motion = (swing if swings(press) else cycle)(press, 1.0, points=12)
    left = list(parts)
    while left:
        first = left.pop(0)
        alike = [part for part in left if _alike(press, first, part)]
        for others in ([], *([part] for part in alike), alike):
            for signs in ((1.0, 1.0), (-1.0, -1.0)) if first.kind == "angle" else ((1.0, -1.0),):
                together = (first, *(replace(part, sign=signs[part.value * first.value < 0]) for part in others))
                if _closes(press, motion, places, together):
                    break
            else:
                continue
            yield together
            left = [part for part in left if part not in others]
            break


def _alike(press: Linkage, first: _Part, other: _Part) -> bool:
    """Whether two parts are equal, or mirror images."""
    equal = abs(abs(other.value) - abs(first.value)) <= SAME * max(press.size, 1.0)
    parallel = first.kind != "along" or abs(abs(first.direction @ other.direction) - 1) < 1e-9
    return bool(first.kind == other.kind and equal and parallel)


def _closes(press: Linkage, motion: Motion, places: Mapping[Pivot, Array], parts: Sequence[_Part]) -> bool:
    """Whether the loops of a redundant linkage stay closed when parts begin to change together."""
    step = 1e-6
    moved = _moved(places, [(parts, step)])
    try:
        motion_derivatives(press, motion, [{pivot: (at - places[pivot]) / step for pivot, at in moved.items()}])
    except PinpressError:
        return False
    return True
