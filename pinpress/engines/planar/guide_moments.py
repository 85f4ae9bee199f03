"""Moments about the plane's normal that guides hold.

The moment of a guide follows from the link alone that it carries, once all forces are known. About the centre of mass the link is turned
by the loads, by the forces of all bearings on it, the guide's own among them, and by the moments that its other bearings transmit: those of
guides, of drives and gears, and of friction. Forces are conjugates, as in `balance`; the moment of a force f with the arm r is
-Im(r conj(f)).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...common.quantities import Array, ComplexArray
from ..wrenches import AppliedForce
from .bodies import Bodies
from .functions import Functions
from .model import Plane, to_complex

ROUNDING = 1e-15  # arms below this share of the linkage's size are rounding


class GuidedBody(NamedTuple):
    """A link on a guide. Arms are in the drawn pose [m]; those of zero length are left out.

    Attributes:
        joint: the guide.
        rotor: row of the rotor that turns the link; None if none does.
        inertia: its moment of inertia about its centre of mass [kg m2].
        center: centre of mass from the origin of the guide's joint [m].
        arms: by bearing the arm from the centre of mass, with its sign changed where the bearing's force acts on the link, not by it.
        ways: of guides on this link the row of the way, and their direction: their forces act where the way has come to.
        bearings: all bearings on the link but its own guide: -1 where the bearing's moment acts on the link, 1 where it acts by it.
    """

    joint: int
    rotor: int | None
    inertia: float
    center: complex
    arms: tuple[tuple[int, ComplexArray], ...]
    ways: tuple[tuple[int, int, ComplexArray], ...]
    bearings: tuple[tuple[int, float], ...]


def guided_bodies(functions: Functions, bodies: Bodies) -> tuple[GuidedBody, ...]:
    """The links on the guides of a linkage, tips of the tree first."""
    return tuple(_guided_body(functions, bodies, joint) for joint in sorted(functions.plane.prismatic, reverse=True))


def _guided_body(functions: Functions, bodies: Bodies, joint: int) -> GuidedBody:
    plane, rotor, count = functions.plane, functions.plane.rotors[joint], len(functions.rows)
    origin, inertias = plane.origins[joint], bodies.inertia[joint]
    center = complex(plane.centers[joint][rotor])
    arms = {joint: center}
    ways, bearings = [], []
    for child, parent in enumerate(plane.parents):
        if parent == joint:
            bearings.append((child, 1.0))
            arms[child] = (plane.origins[child] - origin)[rotor] - center
            if child in plane.prismatic:
                direction = plane.directions[plane.prismatic.index(child)][rotor]
                ways.append((child, functions.rows[child], np.array(direction)))
    for loop, links in enumerate(plane.loop_links):
        first = plane.loop_points[loop]
        for link, row, sign in zip(links, (first, first + plane.gap_rows[loop]), (1.0, -1.0), strict=True):
            if link == joint:
                bearings.append((count + loop, sign))
                arms[count + loop] = sign * ((row - origin)[rotor] - center)
    least = ROUNDING * plane.size
    return GuidedBody(
        joint=joint,
        rotor=functions.order[rotor] if rotor else None,
        inertia=float(np.abs(inertias).max(initial=0.0)) if rotor else 0.0,
        center=center,
        arms=tuple((bearing, np.array(arm)) for bearing, arm in arms.items() if abs(arm) > least),
        ways=tuple(ways),
        bearings=tuple(bearings),
    )


def add_moments_of_guides(
    plane: Plane,
    guided: Sequence[GuidedBody],
    rotors: Sequence[ComplexArray],
    ways: Sequence[Array],
    second: ComplexArray,
    forces: Sequence[ComplexArray],
    loads: Sequence[AppliedForce],
    moments: dict[int, Any],
) -> None:
    """Add the moments (n,) that the guides hold to those of the other bearings, by bearing; the number 0.0 where nothing has an arm.

    Args:
        plane: the linkage.
        guided: the links on its guides.
        rotors: (n,) functions by rows.
        ways: (n,) travels along guides by rows.
        second: (rows, n) conjugate second derivatives of the functions.
        forces: (n,) conjugates, of all bearings.
        loads: forces on links.
        moments: by bearing, see `GuidedBody`.
    """
    for body in guided:
        parts = [forces[bearing] * arm for bearing, arm in body.arms]
        parts += [forces[bearing] * (ways[row] * direction) for bearing, row, direction in body.ways]
        for load in loads:
            if load.joint - 1 == body.joint:
                arm = complex(*(plane.frames[body.joint] @ load.point)[:2])
                parts.append((body.center - arm) * to_complex(plane, load.force).conj())
        moment: Any = 0.0
        turning = [load.moment @ plane.normal for load in loads if load.joint - 1 == body.joint and load.moment is not None]
        if parts:
            total = sum(parts[1:], parts[0])
            moment = -(total if body.rotor is None else total * rotors[body.rotor]).imag
        if body.inertia and body.rotor is not None:  # its angular acceleration is Im(conj(u) u'') of its rotor u
            moment = moment - body.inertia * (rotors[body.rotor] * second[body.rotor]).imag
        for each in turning:
            moment = moment - each
        for bearing, sign in body.bearings:
            if bearing in moments:
                moment = moment + sign * moments[bearing]
        moments[body.joint] = moment
