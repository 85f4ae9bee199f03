"""Moments about the plane's normal that the guides of a chain of dyads hold.

A pin transmits no moment. Therefore the moment of a guide follows from the link alone that it carries, once all forces are known. About
the centre of mass the link is turned by the loads, by the forces of all bearings on it, the guide's own among them, and by the moments of
guides on it. Forces are conjugates, as in `chain_forces`; the moment of a force f with the arm r is -Im(r conj(f)).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...common.quantities import Array, ComplexArray
from ..forces import AppliedForce
from .bodies import Bodies
from .chain import Chain, Closed
from .model import Plane, to_complex

ROUNDING = 1e-15  # arms below this share of the linkage's size are rounding


class GuidedBody(NamedTuple):
    """A link on a guide. Arms are in the drawn pose [m]; those of zero length are left out.

    Attributes:
        joint: the guide.
        rotor: row of the rotor that turns the link; None where none does.
        inertia: its moment of inertia about its centre of mass [kg m2].
        center: centre of mass from the origin of the guide's joint [m].
        arms: by bearing the arm from the centre of mass, with its sign changed where the bearing's force acts on the link, not by it.
        ways: of guides on this link the row of the way, and their direction: their forces act where the way has come to.
    """

    joint: int
    rotor: int | None
    inertia: float
    center: complex
    arms: tuple[tuple[int, ComplexArray], ...]
    ways: tuple[tuple[int, int, ComplexArray], ...]


def guided_bodies(chain: Chain, bodies: Bodies) -> tuple[GuidedBody, ...]:
    """The links on the guides of a chain, tips of the tree first."""
    return tuple(_guided_body(chain, bodies, joint) for joint in sorted(chain.plane.prismatic, reverse=True))


def _guided_body(chain: Chain, bodies: Bodies, joint: int) -> GuidedBody:
    plane, rotor, count = chain.plane, chain.plane.rotors[joint], len(chain.rows)
    origin, own = plane.origins[joint], bodies.inertia[joint]
    center = complex(plane.centers[joint][rotor])
    arms = {joint: center}
    ways = []
    for child, parent in enumerate(plane.parents):
        if parent == joint:
            arms[child] = (plane.origins[child] - origin)[rotor] - center
            if child in plane.prismatic:
                direction = plane.directions[plane.prismatic.index(child)][rotor]
                ways.append((child, chain.rows[child], np.array(direction)))
    for loop, links in enumerate(plane.loop_links):
        first = plane.loop_points[loop]
        for link, row, sign in zip(links, (first, first + plane.gap_rows[loop]), (1.0, -1.0), strict=True):
            if link == joint:
                arms[count + loop] = sign * ((row - origin)[rotor] - center)
    least = ROUNDING * plane.size
    return GuidedBody(
        joint=joint,
        rotor=chain.order[rotor] if rotor else None,
        inertia=float(np.abs(own).max(initial=0.0)) if rotor else 0.0,
        center=center,
        arms=tuple((bearing, np.array(arm)) for bearing, arm in arms.items() if abs(arm) > least),
        ways=tuple(ways),
    )


def moments_of_guides(
    plane: Plane,
    guided: Sequence[GuidedBody],
    closed: Closed,
    speed: Array | float,
    acceleration: Array | float,
    forces: Sequence[ComplexArray],
    loads: Sequence[AppliedForce],
) -> dict[int, Any]:
    """Moments (n,) that the guides hold, by their joints; the number 0.0 where nothing has an arm.

    Args:
        plane: the linkage.
        guided: the links on its guides.
        closed: the closed chain.
        speed: of the driver.
        acceleration: of the driver.
        forces: (n,) of all bearings.
        loads: forces on links.
    """
    along = closed.along
    moments: dict[int, Any] = {}
    for body in guided:
        parts = [forces[bearing] * arm for bearing, arm in body.arms]
        parts += [forces[bearing] * (along.ways[row] * direction) for bearing, row, direction in body.ways]
        for load in loads:
            if load.joint - 1 == body.joint:
                arm = complex(*(plane.frames[body.joint] @ load.point)[:2])
                parts.append((body.center - arm) * to_complex(plane, load.force).conj())
        moment: Any = 0.0
        if parts:
            total = sum(parts[1:], parts[0])
            moment = -(total if body.rotor is None else total * along.functions[body.rotor]).imag
        if body.inertia and body.rotor is not None:
            moment = moment + body.inertia * (along.first[body.rotor] * acceleration - along.second[body.rotor] * (speed * speed))
        for bearing, *_ in body.ways:
            moment = moment + moments[bearing]
        moments[body.joint] = moment
    return moments
