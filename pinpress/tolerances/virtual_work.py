"""The shift of the slide by displaced bearings, by virtual work.

The drivers keep their positions. A force of 1 N acts on the slide along its guide, positive along `Linkage.slide_direction` (upwards). It
causes the force f in a bearing, parent on child (link1 on link2). If the child's bearing is displaced from the parent's by a small u, the
virtual work of the balanced forces is zero, 1 z + sum f . u = 0, so the slide shifts by

    z = - sum f . u

over all bearings (principle of virtual forces; any textbook of mechanics). This is exact to first order in u, for presses in a plane and in
space. It holds for any cause of the displacement: a clearance, another length of a link, or a warm link. At a dead centre z is also the
shift of the dead centre, because the slide does not move with the crank there.

If parallel rods hold the slide, their forces f under the unit load depend on how they share it, and so does the shift. A rigid slide with a
displaced rod would jam. A slide on springs takes the mean, weighted by the stiffnesses.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..common.frozen import FrozenMapping
from ..common.quantities import Array
from ..derivatives.motion import Displacements
from ..dynamics.applied_loads import force_on_slide
from ..dynamics.inverse_dynamics import NONE_GIVEN, inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.motion import Motion
from ..kinematics.poses import poses
from ..linkage.linkage import Linkage


@dataclass(frozen=True, eq=False)
class UnitForces:
    """Forces in the bearings per newton on the slide along its guide, in the n states of a motion.

    Attributes:
        press: the press.
        motion: the motion.
        force: name of a bearing -> (n, 3) force per newton in world axes, for a planar press only in its plane [-].
        moment: name of a bearing -> (n, 3) moment per newton about the origin of its joint's frame, in world axes [m].
    """

    press: Linkage
    motion: Motion
    force: Mapping[str, Array]
    moment: Mapping[str, Array]

    def shift(self, moved: Displacements) -> Array:
        """(n,) shift of the slide by displacements of pivots in their links [m, or per unit of a direction]."""
        press, total = self.press, np.zeros(len(self.motion.crank_angle))
        rotation = poses(press, self.motion.joint_position).rotation
        ends = [
            (-1.0, name, parent, by) for name, parent, by in zip(press.joints, list(press.model.parents)[1:], moved.joints, strict=True)
        ]
        for loop, (first, second) in zip(press.loops, moved.ends, strict=True):
            ends += [(-1.0, loop.name, loop.joint1, first), (1.0, loop.name, loop.joint2, second)]
        for sign, name, body, by in ends:
            if by.any():
                total += sign * np.einsum("nk,nk->n", self.force[name], rotation[body] @ by)
        return total


def unit_forces(
    press: Linkage, motion: Motion, reactions: Reactions | None = None, *, stiffness: Mapping[str, float] = NONE_GIVEN
) -> UnitForces:
    """Compute the forces per newton on the slide.

    Args:
        press: the press.
        motion: the motion; only its positions count, not its speeds.
        reactions: reactions of this motion by weight and inertia, with or without loads, if already computed; None otherwise.
        stiffness: stiffnesses by which redundant bearings share forces, as in `inverse_dynamics`.

    Raises:
        PinpressError: as `inverse_dynamics`, or the press has no slide.
    """
    if press.loses_power:  # losses, which do no virtual work, need speeds
        motion, reactions = replace(motion, crank_speed=0.0 * motion.crank_speed, v=0.0 * motion.v), None
    if reactions is None:
        reactions = inverse_dynamics(press, motion, stiffness=stiffness)
    # A force of the size of the others is not lost in rounding error; a small one leaves teeth on the flanks on which they are.
    size = max(1.0, *(float(np.abs(force).max()) for force in reactions.bearing_force.values())) * (1e-5 if press.uneven else 1.0)
    loaded = inverse_dynamics(press, motion, [*reactions.loads, force_on_slide(press, size)], stiffness=stiffness)
    force = {name: in_plane(press, (loaded.bearing_force[name] - before) / size) for name, before in reactions.bearing_force.items()}
    moment = {name: (loaded.bearing_moment[name] - before) / size for name, before in reactions.bearing_moment.items()}
    return UnitForces(press, motion, FrozenMapping(force), FrozenMapping(moment))


def in_plane(press: Linkage, force: Array) -> Array:
    """A force (n, 3) without the part across the plane of a planar press, which is undetermined in rigid mechanics and does no work."""
    directions = press.engine().directions
    return np.asarray(force @ (directions.T @ directions))
