"""What either engine returns: the driving torque and the force and moment in every joint and loop, as plain arrays."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .coordinates import Array


@dataclass(frozen=True)
class Wrenches:
    """Joints in Pinocchio's order, then loops as declared; all in world axes, parent on child (link1 on link2), at the joint.

    Attributes:
        torque: (n,) on the driver joint, positive along its axis [N m].
        force: (bearings, n, 3) [N].
        moment: (bearings, n, 3) about the origin of the child's joint frame [N m]; the driver's includes the driving torque.
        shaking_force: (n, 3) of the machine on its foundation [N].
        shaking_moment: (n, 3) about the world origin [N m].
        indeterminate: (bearings, 6) bool: force x, y, z and moment x, y, z that rigid mechanics leaves open.
    """

    torque: Array
    force: Array
    moment: Array
    shaking_force: Array
    shaking_moment: Array
    indeterminate: NDArray[np.bool_]

    @staticmethod
    def joined(pieces: Sequence["Wrenches"]) -> "Wrenches":
        """One from consecutive pieces of a motion."""
        return Wrenches(
            torque=np.concatenate([p.torque for p in pieces]),
            force=np.concatenate([p.force for p in pieces], axis=1),
            moment=np.concatenate([p.moment for p in pieces], axis=1),
            shaking_force=np.concatenate([p.shaking_force for p in pieces]),
            shaking_moment=np.concatenate([p.shaking_moment for p in pieces]),
            indeterminate=np.any([p.indeterminate for p in pieces], axis=0),
        )
