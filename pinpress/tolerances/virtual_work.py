"""How far the slide moves where bearings are displaced, by virtual work.

The drivers are held at their positions. Let f be the force in a bearing, parent on child (link1 on link2), that 1 N on the slide along its
guide adds, positive along `Linkage.slide_direction` (upwards). If the child's bearing stands off the parent's by a small u, the virtual
work of the balanced forces is zero, 1 z + sum f . u = 0, so that the slide stands off by

    z = - sum f . u

over all bearings (principle of virtual forces; any textbook of mechanics). This is exact to first order in u, for presses in a plane and in
space, and holds for whatever displaces a bearing: its clearance, a link that has another length, or one that is warm. At a dead centre it
is also the shift of the dead centre, because there the slide does not move with the crank.

Where parallel rods hold the slide, their forces f under the unit load, and with them the shift, depend on how they share it: a rigid slide
with a displaced rod would jam, and one on springs takes the mean, weighted by their stiffnesses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..common.frozen import FrozenMapping
from ..common.quantities import Array
from ..derivatives.motion import Displacements
from ..dynamics.applied_loads import force_on_slide
from ..dynamics.inverse_dynamics import NONE_GIVEN, inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.motion import Motion, of_states
from ..kinematics.poses import poses
from ..linkage.linkage import Linkage
from ..loads.link import Load


@dataclass(frozen=True, eq=False)
class UnitForces:
    """Forces in the bearings per newton on the slide along its guide, in the n states of a motion.

    Attributes:
        press: the press.
        motion: the motion.
        force: name of a bearing -> (n, 3) force by newton, of a planar press in its plane, in world axes [-].
        moment: name of a bearing -> (n, 3) moment by newton about the origin of its joint's frame, in world axes [m].
    """

    press: Linkage
    motion: Motion
    force: Mapping[str, Array]
    moment: Mapping[str, Array]

    def shift(self, moved: Displacements) -> Array:
        """(n,) how far the slide moves where pivots stand elsewhere in their links [m, or per unit of a direction]."""
        press, at = self.press, poses(self.press, self.motion.joint_position)
        total = np.zeros(len(self.motion.crank_angle))

        def add(sign: float, name: str, joint: int, displacement: Array) -> None:
            if displacement.any():
                total[:] += sign * np.einsum("nk,nk->n", self.force[name], at.rotation[joint] @ displacement)

        for name, parent, displacement in zip(press.joints, list(press.model.parents)[1:], moved.joints, strict=True):
            add(-1.0, name, int(parent), displacement)
        for loop, (one, two) in zip(press.loops, moved.ends, strict=True):
            add(-1.0, loop.name, loop.joint1, one)
            add(1.0, loop.name, loop.joint2, two)
        return total


def unit_forces(
    press: Linkage, motion: Motion, reactions: Reactions | None = None, *, stiffness: Mapping[str, float] = NONE_GIVEN
) -> UnitForces:
    """The forces per newton on the slide.

    Args:
        press: the press.
        motion: the motion whose positions count; its speeds make no difference.
        reactions: those of this motion by its weight and inertia, with or without loads, if they are known.
        stiffness: stiffnesses by which bearings share forces that rigid mechanics leaves open, as of `inverse_dynamics`.

    Raises:
        PinpressError: as `inverse_dynamics`, or the press has no slide.
    """
    if reactions is None:
        reactions = inverse_dynamics(press, motion, stiffness=stiffness)
    size = max([1.0, *(float(np.abs(force).max()) for force in reactions.bearing_force.values())])  # not lost in rounding beside the others
    loaded = inverse_dynamics(press, motion, [*reactions.loads, force_on_slide(press, size)], stiffness=stiffness)
    difference = {
        name: (
            in_plane(press, (loaded.bearing_force[name] - reactions.bearing_force[name]) / size),
            (loaded.bearing_moment[name] - reactions.bearing_moment[name]) / size,
        )
        for name in press.bearings
    }
    return UnitForces(
        press,
        motion,
        FrozenMapping({name: force for name, (force, _) in difference.items()}),
        FrozenMapping({name: moment for name, (_, moment) in difference.items()}),
    )


def in_plane(press: Linkage, force: Array) -> Array:
    """A force (n, 3) without its part across the plane of a planar press, which rigid mechanics leaves open and which does no work."""
    directions = press.engine().directions
    return np.asarray(force @ (directions.T @ directions))


def forces_by_cause(press: Linkage, motion: Motion, loads: Sequence[Load]) -> tuple[Reactions, list[Reactions]]:
    """The reactions under weight and inertia, and under them and every load alone.

    Returns:
        The reactions at standstill in the positions of the motion without loads; those in motion without loads, then with each load.
    """
    still = np.zeros_like(motion.v.T)
    at_rest = of_states(press, motion.joint_position.T, still, still.copy(), motion.closure_error, None)
    return inverse_dynamics(press, at_rest), [inverse_dynamics(press, motion, each) for each in ([], *([load] for load in loads))]
