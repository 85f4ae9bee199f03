"""Transmission angles of a planar linkage: how well each of its dyads passes a force on.

A dyad is two links that three bearings join: one bearing joins the links to each other, the other two hold them to links whose motion is
known already. A press linkage is the driver and a chain of dyads.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...common.arguments import typed
from ...common.frozen import NamedArrays
from ...common.quantities import Array
from ...common.results import Record, Records, Tabular
from ...engines.planar.model import Block, Plane
from ...linkage.linkage import Linkage
from ...linkage.memo import per_linkage
from ..cycle import motion_through_change_points
from ..motion import Motion, refuse_motion_of_another
from ..poses import bearing_points, poses

SAMPLES = 720  # crank angles of a turn between which the least angle is searched
CLOSER, ROUNDS = 10, 7  # factor by which each round of the search is finer than the one before, and number of rounds
EQUAL = 1e-12  # difference of angles that is rounding [rad]
IN_LINE = 1e-7  # a smaller angle is that of links that come into line, where the search converges only linearly [rad]


@dataclass(frozen=True, repr=False)
class Dyad(Record, units={"least_transmission_angle": "rad", "crank_angle": "rad"}):
    """Two links of a planar linkage and the three bearings that join them.

    Attributes:
        bearing: name of the bearing that joins the two links to each other.
        ends: names of the bearings that join them to the rest.
        least_transmission_angle: smallest transmission angle, 0 to pi/2, over all crank angles, see `least_transmission_angles` [rad].
        crank_angle: crank angle at which it is reached first [rad]; position of a driver that slides [m].
    """

    bearing: str
    ends: tuple[str, str]
    least_transmission_angle: float
    crank_angle: float


@dataclass(frozen=True, repr=False)
class DyadOverTravel(Dyad, units={"least_transmission_angle": "rad", "crank_angle": "m"}):
    """A `Dyad` of a linkage whose driver slides; the crank angle is the position of the driver [m]."""


@typed
@per_linkage(of_geometry=True)
def least_transmission_angles(press: Linkage) -> Records[Dyad]:
    """The least transmission angle of every dyad of a planar linkage, over a period or as far as the crank turns.

    It is the angle between the dyad's two links at the pin that joins them, folded to 0 to pi/2: each link's line goes from this pin to
    the pin at its other end, and where a guide or slot is at its other end, across the guide. Where the two links slide on each other, it
    is the angle between the line through the pins at their ends and the normal to the slot, or between the slot and the guide at an end.
    At pi/2 the dyad passes forces on best; at 0 its links are in line and it locks. Designers keep it above 30 to 40 degrees where force
    is passed on; a knuckle or toggle lies flat by design. Of a four-bar it is the transmission angle of Alt, of a crank-slide that
    between rod and normal of the guide.

    Loops that only add constraint, gear pairs, and groups of more than two links that cannot be solved dyad by dyad have none.

    Args:
        press: A planar linkage with one driver.

    Returns:
        The dyads in the order in which they follow from the driver; angles to 1e-12 rad, to 1e-7 rad where links come into line.

    Raises:
        PinpressError: the linkage is not planar, or has several drivers.
        AssemblyError: the loops do not stay closed.
    """
    plane = press.plane_or_refuse(f"{press.name} has no transmission angles: they are those of planar linkages with one driver")
    bearings = [_bearings(press, plane, block) for block in plane.blocks if block.kind == "dyad"]
    if not bearings:
        return Records(Dyad, [])
    branch = press.branch_through_change_points
    first, last = (0.0, branch.period) if branch.period is not None else (float(branch.angles[0]), float(branch.angles[-1]))
    turns = (last - first) / (2 * np.pi) if press.driver_coordinates[0].turns else 1.0  # there is the turn of a driver that slides
    steps = max(2, round(SAMPLES * turns))
    centres, step = np.linspace(first, last, steps + 1)[None], (last - first) / steps
    for _ in range(ROUNDS):
        sampled = _angles(press, plane, bearings, centres)
        least = np.argmax(sampled <= sampled.min(axis=1, keepdims=True) + EQUAL, axis=1)[:, None]  # the first of equal ones
        crank = np.take_along_axis(np.broadcast_to(centres, sampled.shape), least, axis=1)
        step /= CLOSER
        centres = np.clip(crank + step * np.arange(-CLOSER, CLOSER + 1), first, last)
    angles = np.take_along_axis(sampled, least, axis=1)[:, 0]
    kind = Dyad if branch.coordinate.turns else DyadOverTravel
    return Records(
        kind,
        (
            kind(dyad.middle, dyad.ends, float(angle) if angle > IN_LINE else 0.0, float(place))
            for dyad, angle, place in zip(bearings, angles, crank[:, 0], strict=True)
        ),
    )


@typed
def transmission_angle_curves(press: Linkage, motion: Motion) -> DyadAngles:
    """The transmission angle of every dyad of a planar linkage in the states of a motion; `least_transmission_angles` says what it is.

    Of a rod that drives a slide it is the angle between rod and normal of the guide, so that its `pressure_angle` is that between rod and
    guide (Chen 2002, (18), at its largest).

    Args:
        press: a planar linkage with one driver.
        motion: its motion.

    Raises:
        PinpressError: the linkage is not planar, has several drivers, or is not that of the motion.
    """
    plane = press.plane_or_refuse(f"{press.name} has no transmission angles: they are those of planar linkages with one driver")
    refuse_motion_of_another(press, motion)
    dyads = [_bearings(press, plane, block) for block in plane.blocks if block.kind == "dyad"]
    placed = _place_bearings(press, motion.joint_position)
    angles = np.array([_angle(plane, placed, dyad) for dyad in dyads]).reshape(len(dyads), len(motion.joint_position))
    return DyadAngles(motion, NamedArrays(tuple(dyad.middle for dyad in dyads), angles))


@dataclass(frozen=True, eq=False, repr=False)
class DyadAngles(Tabular):
    """Transmission angles of all dyads of a planar linkage over a motion, see `least_transmission_angles`.

    Attributes:
        motion: the motion.
        transmission_angle: name of the bearing that joins a dyad's two links -> (n,) angle, 0 to pi/2 [rad].
    """

    motion: Motion
    transmission_angle: Mapping[str, Array]

    @property
    def pressure_angle(self) -> Mapping[str, Array]:
        """pi/2 less the transmission angle, by the same names (n,) [rad]: between rod and guide the angle of force and velocity."""
        angles = np.array([np.pi / 2 - angle for angle in self.transmission_angle.values()])
        return NamedArrays(tuple(self.transmission_angle), angles)

    @property
    def title(self) -> str:
        least = ", ".join(f"{name} {np.degrees(angle.min()):.4g} deg" for name, angle in self.transmission_angle.items())
        return f"DyadAngles of {self.motion.linkage}: {len(self.motion.joint_position)} states, least in {least or 'no dyad'}"

    def columns(self) -> dict[str, Array]:
        """The driver's coordinate, then the transmission angle of each dyad."""
        angles = {f"transmission_angle_{name} [rad]": angle for name, angle in self.transmission_angle.items()}
        return self.motion.position_columns() | angles

    @property
    def _pictured(self) -> tuple[str, ...]:
        return tuple(self.columns())


class _Bearings(NamedTuple):
    """The bearings of a dyad: names of the one that joins the two links, and of those that join the links to the rest."""

    middle: str
    ends: tuple[str, str]


def _bearings(press: Linkage, plane: Plane, block: Block) -> _Bearings:
    """Which bearing of a dyad is in the middle: of two joints on one side of the loop the outer one, else the loop itself."""
    loop = press.loops[block.loops[0]]
    for end in (loop.joint1, loop.joint2):
        carriers = plane.carriers(end - 1)
        if set(block.joints) <= set(carriers):
            inner, outer = sorted(block.joints, key=carriers.index)
            return _Bearings(press.joints[outer], (press.joints[inner], loop.name))
    first, second = block.joints
    return _Bearings(loop.name, (press.joints[first], press.joints[second]))


class _Placed(NamedTuple):
    """Bearings in n states, by their names: points (n, 3) where their forces act [m], and directions (n, 3) in which guides and slots
    slide, in world axes."""

    points: Mapping[str, Array]
    slides: Mapping[str, Array]


def _place_bearings(press: Linkage, position: Array) -> _Placed:
    """The bearings of a linkage at joint coordinates (n, nv)."""
    bodies = poses(press, position)
    sliding = ((joint, name, axis) for joint, (name, axis) in enumerate(zip(press.joints, press.axes, strict=True), 1) if not axis.turns)
    slides = {name: bodies.rotation[joint] @ axis.direction for joint, name, axis in sliding}
    return _Placed(dict(zip(press.bearings, bearing_points(press, bodies), strict=True)), slides)


def _angles(press: Linkage, plane: Plane, dyads: list[_Bearings], crank: Array) -> Array:
    """Transmission angles (dyads, n) at crank angles (dyads, n), or (1, n) for all."""
    placed = _place_bearings(press, motion_through_change_points(press, crank.ravel(), 0.0).joint_position)
    states = np.arange(crank.size).reshape(crank.shape)
    return np.array([_angle(plane, placed, dyad)[states[k % len(states)]] for k, dyad in enumerate(dyads)])


def _angle(plane: Plane, placed: _Placed, dyad: _Bearings) -> Array:
    """Transmission angle (n,) of a dyad."""
    line1, line2 = _lines(dyad, placed, plane.normal)
    across = np.cross(line1, line2) @ plane.normal
    return np.asarray(np.arctan2(np.abs(across), np.abs(np.sum(line1 * line2, axis=1))))


def _lines(dyad: _Bearings, placed: _Placed, normal: Array) -> tuple[Array, Array]:
    """Two directions (n, 3) in the plane, between which the transmission angle is."""
    (points, slides), middle = placed, dyad.middle

    def line(begin: str, end: str) -> Array:
        direction = points[end] - points[begin]
        return np.asarray(direction - np.outer(direction @ normal, normal))

    if middle in slides:
        guides = [slides[name] for name in dyad.ends if name in slides]
        return (slides[middle], guides[0]) if guides else (line(*dyad.ends), np.cross(normal, slides[middle]))
    first, second = (np.cross(normal, slides[name]) if name in slides else line(middle, name) for name in dyad.ends)
    return first, second
