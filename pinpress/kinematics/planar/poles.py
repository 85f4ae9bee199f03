"""Drawings of lectures on planar linkages: poles of links, velocity and acceleration polygons, and Grashof's kinds of its four-bars."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...common.arguments import typed, whole_number
from ...common.errors import PinpressError
from ...common.frozen import NamedArrays, read_only
from ...common.quantities import Array
from ...common.results import Record, Records, Tabular
from ...common.tables import Column, by_axis
from ...engines.body_motion import BodyMotion
from ...linkage.linkage import Linkage
from ..motion import Motion, refuse_motion_of_another
from ..poses import bearing_points, body_of, loaded_bodies, poses

REST = 1e-12  # share of the fastest link below which a relative speed is rounding
EQUAL = 1e-9  # share of the lengths of a four-bar below which a difference is rounding error: files have about nine digits


@dataclass(frozen=True, eq=False, repr=False)
class PolePath(Tabular):
    """The pole (instant centre) of a link relative to another one, in the n states of a motion: where both have the same velocity.

    Attributes:
        link: name of the link that moves.
        to: name of the link relative to which it moves.
        motion: the motion.
        position: (n, 3) in world axes, in the plane through the link's joint [m]; NaN where the pole is at infinity.
        direction: (n, 3) unit vector towards a pole at infinity, across the relative velocity; NaN where the pole is not at infinity, or
            the links rest relative to each other.
        angular_velocity: (n, 3) of the link relative to the other one, in world axes [rad/s]. In a drawing with x to the right and z up a
            link turns counter-clockwise about -y.
        angular_acceleration: (n, 3) of the link relative to the other one, in world axes [rad/s2].
    """

    link: str
    to: str
    motion: Motion
    position: Array
    direction: Array
    angular_velocity: Array
    angular_acceleration: Array

    @property
    def title(self) -> str:
        far = int(np.isnan(self.position[:, 0]).sum())
        words = f", {far} of them without a pole nearer than infinity" if far else ""
        fastest = np.linalg.norm(self.angular_velocity, axis=1).max()
        return f"PolePath of {self.link} relative to {self.to}: at up to {fastest:.6g} rad/s, {len(self.position)} states{words}"

    def columns(self) -> dict[str, Column]:
        """A row for each state; without a value where the pole is at infinity."""
        columns: dict[str, Column] = dict(self.motion.position_columns())
        vectors = (
            ("pole", "m", self.position),
            ("direction", "-", self.direction),
            ("angular_velocity", "rad/s", self.angular_velocity),
            ("angular_acceleration", "rad/s2", self.angular_acceleration),
        )
        for name, unit, values in vectors:
            columns |= {head: np.ma.masked_invalid(column) for head, column in by_axis(name, unit, values).items()}
        return columns


@typed
def poles(press: Linkage, motion: Motion, link: str, to: str) -> PolePath:
    """Find the pole of a link relative to another one, such as a coupler and the frame.

    With the relative velocity v of a point B of the link, the relative angular velocity w and the plane's normal n, the pole is B + n x v /
    w. The poles of three links lie on a line (Kennedy).

    Args:
        press: a planar linkage with one driver.
        motion: its motion.
        link: name of the link that moves.
        to: name of the link relative to which it moves, such as the frame.

    Raises:
        UnknownNameError: a link that the linkage does not have.
        PinpressError: the linkage is not planar, has several drivers, or is not that of the motion; both links are one body.
    """
    normal = press.plane_or_refuse(f"{press.name} has no poles: only planar linkages with one driver have them").normal
    refuse_motion_of_another(press, motion)
    first, second = body_of(press, link), body_of(press, to)
    if first == second:
        raise PinpressError(f"{link} and {to} are one body, so they have no pole: give two links that move relative to each other")
    bodies = _bodies(press, motion)
    at = bodies.origin[first or second]
    velocity = bodies.at_arms(at - bodies.origin).velocity
    spin, turning = ((rates[first] - rates[second]).T for rates in (bodies.spin, bodies.turning))
    v, w = velocity[first] - velocity[second], spin @ normal
    fastest = np.linalg.norm([bodies.velocity / press.size, bodies.spin], axis=2).max(axis=(0, 1))
    turns, across = np.abs(w) > REST * fastest, np.cross(normal, v.T)
    speed = np.linalg.norm(v, axis=0)
    far = ~turns & (speed > REST * fastest * press.size)
    position, direction = np.full((2, len(w), 3), np.nan)
    position[turns] = at.T[turns] + across[turns] / w[turns, None]
    direction[far] = across[far] / speed[far, None]
    return PolePath(link, to, motion, *map(read_only, (position, direction, spin, turning)))


@dataclass(frozen=True, eq=False, repr=False)
class VectorPolygons(Tabular):
    """Velocity and acceleration polygons of a planar linkage in one state: the vectors of its pins, all drawn from one pole.

    Points are the pins by their names. A slot adds "P on rocker": the point of the link with the slot that is at the pin P now. The points
    of a link form a figure similar to the link. In the velocity polygon it is turned by a right angle and scaled by the link's angular
    velocity.

    Attributes:
        motion: the motion.
        state: index of the state.
        velocity: name of a point -> (3,) in world axes [m/s].
        acceleration: name of a point -> (3,) in world axes [m/s2].
        links: name of a link that moves -> names of its points, in their order round the link.
        axes: names of the two world axes of the drawing, as "x", "z".
    """

    motion: Motion
    state: int
    velocity: Mapping[str, Array]
    acceleration: Mapping[str, Array]
    links: Mapping[str, tuple[str, ...]]
    axes: tuple[str, str]

    @property
    def title(self) -> str:
        angle, first = np.atleast_1d(self.motion.crank_angle[self.state])[0], self.motion.driver_coordinates[0]
        fastest = max(np.linalg.norm(vector) for vector in self.velocity.values())
        head = f"VectorPolygons of {self.motion.linkage} at {first.shown(angle, '.2f')}"
        return f"{head}: {len(self.velocity)} points, at up to {fastest:.6g} m/s"

    def columns(self) -> dict[str, Column]:
        """A row for each point."""
        vectors = (("velocity", "m/s", self.velocity), ("acceleration", "m/s2", self.acceleration))
        columns: dict[str, Column] = {"point": list(self.velocity)}
        for name, unit, values in vectors:
            columns |= by_axis(name, unit, np.array(list(values.values())))
        return columns


@typed
def polygons(press: Linkage, motion: Motion, state: int = 0) -> VectorPolygons:
    """Velocity and acceleration polygons of a planar linkage in one state of a motion.

    Args:
        press: a planar linkage with one driver.
        motion: its motion.
        state: index of the state.

    Raises:
        PinpressError: the linkage is not planar, has several drivers, or is not that of the motion; the motion has no such state.
    """
    plane = press.plane_or_refuse(f"{press.name} has no polygons: only planar linkages with one driver have them")
    refuse_motion_of_another(press, motion)
    at = [whole_number("state", state, 0, len(motion.v) - 1)]
    bodies = _bodies(press, motion, at)
    names, links = dict[str, tuple[int, Array]](), dict[str, list[str]]()
    for name, body, place in _points(press, bearing_points(press, poses(press, motion.joint_position[at]))[:, 0]):
        names.setdefault(name, (body, place))
        links.setdefault(press.link_of(body), []).append(name)
    carrying = BodyMotion(*(values[[body for body, _ in names.values()]] for values in bodies))
    moved = carrying.at_arms(np.array([place for _, place in names.values()])[..., None] - carrying.origin)
    wide = [axis for axis in range(3) if axis != np.argmax(np.abs(plane.normal))]
    places = {name: place[wide] for name, (_, place) in names.items()}
    return VectorPolygons(
        motion,
        state,
        NamedArrays(tuple(names), moved.velocity[..., 0].copy()),
        NamedArrays(tuple(names), moved.acceleration[..., 0].copy()),
        {link: _round(its, places) for link, its in links.items() if link != press.link_of(0)},
        ("xyz"[wide[0]], "xyz"[wide[1]]),
    )


@dataclass(frozen=True, repr=False)
class FourBar(Record, units=dict.fromkeys(("frame", "crank", "coupler", "rocker", "margin"), "m")):
    """A four-bar or slider-crank within a linkage, and Grashof's kind of it.

    Attributes:
        kind: "double crank", "crank rocker", "double rocker", "triple rocker" or "change point"; of a slider-crank "crank slide", where the
            crank can turn fully, "rocker slide" or "change point".
        links: names of crank, coupler, and rocker or slide; the crank is the driver's link, if the driver is one of the pins.
        bearings: names of the bearings from frame to crank, crank to coupler, coupler to rocker, and rocker to frame.
        frame: distance of the two pins on the frame; of a slider-crank offset e of the crank's pin from the line of the slide's pin [m].
        crank: distance of the crank's pins [m].
        coupler: distance of the coupler's pins [m].
        rocker: distance of the rocker's pins [m]; None of a slider-crank.
        shortest: "frame", "crank", "coupler" or "rocker"; of a slider-crank "crank" or "coupler".
        margin: p + q - s - l, with the shortest length s, the longest l and the two others; of a slider-crank coupler - crank - e. If it is
            not negative, the shortest link (the crank) can turn fully [m].
    """

    kind: str
    links: tuple[str, ...]
    bearings: tuple[str, ...]
    frame: float
    crank: float
    coupler: float
    rocker: float | None
    shortest: str
    margin: float


@typed
def grashof(press: Linkage) -> Records[FourBar]:
    """The four-bars and slider-cranks of a planar linkage that have the frame as a link, and Grashof's kinds of them.

    Args:
        press: a planar linkage with one driver.

    Returns:
        All loops of four links with four pins, or with three pins and a guide on the frame; empty if there are none.

    Raises:
        PinpressError: the linkage is not planar, or has several drivers.
        AssemblyError: the loops do not stay closed.
    """
    plane = press.plane_or_refuse(f"{press.name} has no kinds by Grashof: only planar linkages with one driver have them")
    places = poses(press, press.closed[None])
    flat = bearing_points(press, places)[:, 0]
    flat = flat - np.outer(flat @ plane.normal, plane.normal)
    four_bars = []
    for bodies, bearings in _rounds(press):
        first, second, third, last = flat[list(bearings)]
        crank, coupler, rocker, frame = (
            float(np.linalg.norm(b - a)) for a, b in ((first, second), (second, third), (third, last), (last, first))
        )
        if slides := _slides(press, bearings[3]):
            guide = places.rotation[bearings[3] + 1][0] @ press.axes[bearings[3]].direction
            frame = float(abs(np.cross(guide, third - first) @ plane.normal))
        if min(crank, coupler, *([] if slides else [rocker, frame])) <= EQUAL * press.size:
            continue  # two pins in one place: both links turn about it
        kind, shortest, margin = _kind(frame, crank, coupler, None if slides else rocker)
        links, names = tuple(map(press.link_of, bodies)), tuple(press.bearings[each] for each in bearings)
        four_bars.append(FourBar(kind, links, names, frame, crank, coupler, None if slides else rocker, shortest, margin))
    return Records(FourBar, four_bars)


def _kind(frame: float, crank: float, coupler: float, rocker: float | None) -> tuple[str, str, float]:
    """Grashof's kind, the shortest link, and the margin [m]."""
    if rocker is None:
        margin = coupler - crank - frame
        kind = "change point" if abs(margin) <= EQUAL * (crank + coupler) else "crank slide" if margin > 0 else "rocker slide"
        return kind, "crank" if crank <= coupler else "coupler", margin
    by_link = {"frame": frame, "crank": crank, "coupler": coupler, "rocker": rocker}
    shortest = min(by_link, key=by_link.__getitem__)
    s, p, q, longest = sorted(by_link.values())
    margin = p + q - s - longest
    if abs(margin) <= EQUAL * (s + p + q + longest):
        return "change point", shortest, margin
    kinds = {"frame": "double crank", "coupler": "double rocker", "crank": "crank rocker", "rocker": "crank rocker"}
    return kinds[shortest] if margin > 0 else "triple rocker", shortest, margin


def _slides(press: Linkage, bearing: int) -> bool:
    """Whether a bearing, by its index, is a guide or slot."""
    return bearing < len(press.joints) and not press.axes[bearing].turns


def _rounds(press: Linkage) -> Iterator[tuple[tuple[int, int, int], tuple[int, int, int, int]]]:
    """Rounds of three bodies and the frame, from the frame and the driver on: the bodies, and the indices of the bearings between them. A
    guide, of which there is at most one, is the last bearing."""
    bearings: dict[int, list[tuple[int, int]]] = {}
    for k, (one, other) in enumerate(_sides(press)):
        bearings.setdefault(one, []).append((k, other))
        bearings.setdefault(other, []).append((k, one))
    (driver,) = press.driver_indices
    for (first, a), (last, c) in itertools.permutations(bearings[0], 2):
        ordered = (_slides(press, first), first != driver, first) < (_slides(press, last), last != driver, last)
        if a == c or not ordered or _slides(press, first):
            continue
        for (second, b), (third, d) in itertools.product(bearings[a], bearings[c]):
            if b == d and b not in (0, a, c) and not _slides(press, second) and not _slides(press, third):
                yield (a, b, c), (first, second, third, last)


def _sides(press: Linkage) -> list[tuple[int, int]]:
    """Of every bearing the Pinocchio joints of the two bodies that it connects."""
    parents = (*press.model.parents[1:], *(loop.joint1 for loop in press.loops))
    return list(zip(map(int, parents), loaded_bodies(press), strict=True))


def _points(press: Linkage, places: Array) -> Iterator[tuple[str, int, Array]]:
    """Names of points, the bodies that carry them, and their places (3,), from those of the bearings (bearings, 3)."""
    bearings = list(zip(press.bearings, _sides(press), places, strict=True))
    pins = [(name, body, place) for k, (name, sides, place) in enumerate(bearings) if not _slides(press, k) for body in sides]
    yield from pins
    for name, (parent, child), middle in (bearing for k, bearing in enumerate(bearings) if _slides(press, k)):
        pin, place = next(((pin, place) for pin, body, place in pins if body == child), (name, middle))
        if pin == name:
            yield name, child, middle
        if parent:
            yield f"{pin} on {press.link_of(parent)}", parent, place


def _round(names: Sequence[str], places: Mapping[str, Array]) -> tuple[str, ...]:
    """Names of points in their order round their middle."""
    away = np.array([places[name] for name in names]) - np.mean([places[name] for name in names], axis=0)
    return tuple(names[k] for k in np.argsort(np.arctan2(away[:, 1], away[:, 0]), kind="stable"))


def _bodies(press: Linkage, motion: Motion, states: Sequence[int] | slice = slice(None)) -> BodyMotion:
    """Motion of all bodies, the frame as the first, in some states."""
    moved = press.engine().body_motion(motion.states(press), range(1, press.model.njoints), accelerations=True)
    n = len(motion.v)
    frame = [np.broadcast_to(np.eye(3)[..., None], (3, 3, n)), *np.zeros((5, 3, n))]
    return BodyMotion(*(np.concatenate([still[None], values])[..., states] for still, values in zip(frame, moved, strict=True)))
