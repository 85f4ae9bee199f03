"""The springs of a press: its elastic parts, and the internal force of each part over a motion.

Every part is a spring in series with the rigid linkage, linear except for preloaded joints that open. Its internal force N follows from
rigid inverse dynamics, so all results are of first order in the deflections. By virtual work a part with compliance c moves the slide by c
N . n, where n is its internal force under a unit force on the slide (unit-load method). The sign convention of N does not matter, because n
has the same convention. Only a preloaded joint needs a sign: positive in tension.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..common.arguments import positive
from ..common.errors import PinpressError, shown
from ..common.quantities import Array
from ..dynamics.reactions import Reactions
from ..dynamics.shaking import on_frame
from ..kinematics.motion import Motion
from ..kinematics.poses import bearing_points, poses
from ..linkage.linkage import Linkage
from ..simulation.elastic.contact import Clearance as Clearance
from ..simulation.elastic.contact import hertz_stiffness as hertz_stiffness
from ..simulation.elastic.description import Elastic as Elastic
from ..simulation.elastic.description import Rod as Rod
from ..simulation.elastic.description import Stiffness as Stiffness
from ..simulation.elastic.flexible_link import FlexibleLink as FlexibleLink
from ..simulation.elastic.flexible_link import read_flexible_link as read_flexible_link
from ..simulation.elastic.preloaded_joint import STIFFEST
from ..simulation.elastic.preloaded_joint import PreloadedJoint as PreloadedJoint
from ..simulation.elastic.yielding import (
    FRAME,
    SHAFT,
    bearing_number,
    doubt_stiffness,
    named,
    part_stiffness,
    refuse_joint_but_of_guide,
    refuse_meeting,
    rod_ends,
    rods_of,
)


class Spring(NamedTuple):
    """An elastic part, with the bearings whose forces determine its internal force.

    Attributes:
        name: name in tables.
        compliance: compliance of the spring [m/N or rad/(N m)].
        kind: "bearing", "moment", "rod", "shaft" or "frame".
        bearings: numbers of bearings with weights: the internal force is the sum of weight x bearing force.
        line: numbers of the two bearings at the ends of a rod.
        joint: the joint with its preload; while closed it has the stiffness of the spring. None: the part has no joint.
    """

    name: str
    compliance: float
    kind: str
    bearings: tuple[tuple[int, float], ...] = ()
    line: tuple[int, int] = (0, 0)
    joint: PreloadedJoint | None = None

    def elongations(self, force: Array) -> Array:
        """Elongations by internal forces (n, 1) or (n, 3), of the same shape [m, rad]; nonlinear if a joint opens."""
        if self.joint is None:
            return self.compliance * force
        if self.kind != "bearing":
            return self.joint.elongation(force)
        size = np.linalg.norm(force, axis=1, keepdims=True)  # for a guide: both gibs are equal
        return np.asarray(self.joint.elongation(size) * force / np.where(size > 0, size, 1.0))

    def opens(self, force: Array) -> bool:
        """Whether internal forces, as for `elongations`, open the joint."""
        if self.joint is None:
            return False
        signed = np.linalg.norm(force, axis=1) if self.kind == "bearing" else force
        return bool(signed.max(initial=0.0) > self.joint.opening_load or signed.min(initial=0.0) < -self.joint.slack_load)


def springs_of(press: Linkage, stiffness: Stiffness) -> tuple[Spring, ...]:
    """The springs of a press.

    Raises:
        UnknownNameError: the linkage has no such bearing or link.
        PinpressError: the press has no slide, several drivers and an elastic shaft, no spring, or a stiffness that is not positive, or
            a rod or guide is not as described.
    """
    if not isinstance(press, Linkage):
        raise PinpressError(f"press is a {type(press).__name__}, no Linkage: give what load returns")
    if not isinstance(stiffness, Stiffness):
        raise PinpressError(f"stiffness is a {type(stiffness).__name__}: give a Stiffness(bearings={{...}}, rods=[...], ...)")
    _ = press.slide_guide  # raises an error if there is no slide
    springs = [_bearing_spring(press, name, value) for name, value in named("bearings", stiffness.bearings).items()]
    springs += [_guide_spring(press, name, value) for name, value in named("moments", stiffness.moments).items()]
    springs += [_rod_spring(press, rod) for rod in rods_of(stiffness)]
    if stiffness.shaft is not None:
        press.refuse_several_drivers("shaft names none of them; leave shaft out")
        driver = press.bearings.index(press.driver)
        springs.append(Spring(SHAFT, 1 / part_stiffness("the shaft", stiffness.shaft, "N m/rad"), "shaft", ((driver, 1.0),)))
    if stiffness.frame is not None:
        compliance, count = 1 / part_stiffness("the frame", stiffness.frame), len(press.joints)
        # the bearings on the frame; the signs make their forces act on the frame
        forces = tuple((k, 1.0 if k >= count and press.loops[k - count].joint2 == 0 else -1.0) for k in on_frame(press))
        springs.append(Spring(FRAME, compliance, "frame", forces, joint=_joint(stiffness.frame)))
    doubt_stiffness(press, stiffness)
    if not springs:
        raise PinpressError(f"no part of {press.name} is elastic: give Stiffness the stiffness of at least one part")
    names = [part.name for part in springs]
    if len(set(names)) < len(names):
        raise PinpressError(f"several parts are named {', '.join(sorted({n for n in names if names.count(n) > 1}))}: give each once")
    return tuple(springs)


def sharing(press: Linkage, springs: Sequence[Spring]) -> dict[str, float]:
    """Stiffnesses of bearings for `inverse_dynamics`, which distribute the statically indeterminate forces.

    Each elastic bearing also gets half of the compliance of each rod that ends at it. So self-equilibrated forces between parallel rods do
    no work on the deflections, as in the elastic press.
    """
    compliance = dict.fromkeys(range(len(press.bearings)), 0.0)
    for part in springs:
        for bearing, _ in part.bearings if part.kind in ("bearing", "rod") else ():
            compliance[bearing] += part.compliance / len(part.bearings)
    return {press.bearings[bearing]: 1 / value for bearing, value in compliance.items() if value}


def internal_forces(press: Linkage, springs: Sequence[Spring], motion: Motion, reactions: Reactions) -> list[Array]:
    """The internal force of every part over a motion, (n, 3) for bearings, (n, 1) for other parts [N, N m].

    Forces of rods and of the frame's columns are positive in tension.

    Raises:
        PinpressError: the two bearings of a rod coincide.
    """
    lines = bearing_points(press, poses(press, motion.joint_position)) if any(part.kind == "rod" for part in springs) else np.empty(0)
    across = _in_plane(press)
    axis = press.slide_direction
    forces = []
    for part in springs:
        if part.kind == "shaft":
            forces.append(reactions.driving_torque[:, None])
        elif part.kind == "moment":
            moment = reactions.bearing_moment[press.bearings[part.bearings[0][0]]]
            forces.append(moment @ press.engine_of_one_driver.turning_axes().T)
        else:
            force = sum((weight * reactions.bearing_force[press.bearings[k]] for k, weight in part.bearings), np.zeros(3))
            if part.kind == "bearing":
                forces.append(_without_travel(press, motion, part.bearings[0][0], force @ across))
            elif part.kind == "frame":
                forces.append((force @ axis)[:, None])
            else:
                forces.append(_along(press, lines[part.line[1]] - lines[part.line[0]], force @ across, across, part.name))
    return forces


def _along(press: Linkage, line: Array, force: Array, across: Array, name: str) -> Array:
    """The component (n, 1) of a force (n, 3) along a rod's line (n, 3), positive in tension."""
    line = line @ across
    length = np.linalg.norm(line, axis=1)
    refuse_meeting(press, name, length)
    return np.asarray((np.einsum("nk,nk->n", force, line) / length)[:, None])


def _in_plane(press: Linkage) -> Array:
    """Projector (3, 3) on the plane of a planar press; forces across the plane are statically indeterminate."""
    directions = press.engine_of_one_driver.directions
    return np.asarray(directions.T @ directions)


def _without_travel(press: Linkage, motion: Motion, bearing: int, force: Array) -> Array:
    """The force (n, 3) of a bearing; for a guide, without the component along its axis, because the slide is free along it."""
    if bearing >= len(press.joints) or press.axes[bearing].turns:
        return force
    rotation = poses(press, motion.joint_position).rotation[bearing + 1]
    along = rotation @ press.axes[bearing].direction
    return np.asarray(force - np.einsum("nk,nk->n", force, along)[:, None] * along)


def _joint(stiffness: object) -> PreloadedJoint | None:
    return stiffness if isinstance(stiffness, PreloadedJoint) else None


def _bearing_spring(press: Linkage, name: str, stiffness: float | PreloadedJoint) -> Spring:
    number = bearing_number(press, name)
    refuse_joint_but_of_guide(press, number, stiffness)
    return Spring(name, 1 / part_stiffness(f"bearing {shown(name)}", stiffness), "bearing", ((number, 1.0),), joint=_joint(stiffness))


def _guide_spring(press: Linkage, name: str, stiffness: float) -> Spring:
    """The rotational spring of a guide, against rotation of the slide."""
    guide = bearing_number(press, name)
    if guide >= len(press.joints) or press.axes[guide].turns:
        raise PinpressError(f"moments names {shown(name)}, which is not a guide and carries no moment in the plane: leave it out")
    compliance = 1 / positive(f"stiffness of guide {shown(name)} against turning", stiffness, "N m/rad", STIFFEST)
    return Spring(f"{name} turning", compliance, "moment", ((guide, 1.0),))


def _rod_spring(press: Linkage, rod: Rod) -> Spring:
    _, (one, another), signs = rod_ends(press, rod)
    compliance = 1 / part_stiffness(f"rod {shown(rod.name)}", rod.stiffness)
    loads = ((one, -0.5 * signs[one]), (another, 0.5 * signs[another])) if len(signs) == 2 else ((another, signs[another]),)
    return Spring(rod.name, compliance, "rod", loads, (one, another), _joint(rod.stiffness))
