"""What either engine returns: the driving torque and the force and moment in every joint and loop, as plain arrays."""

from dataclasses import dataclass

import numpy as np

from .coordinates import Array


@dataclass(frozen=True, eq=False, repr=False)
class Wrenches:
    """Joints in Pinocchio's order, then loops as declared; all in world axes, parent on child (link1 on link2), at the joint.

    Attributes:
        torque: (n,) on the driver joint, positive along its axis [N m].
        force: (bearings, n, 3) [N].
        moment: (bearings, n, 3) about the origin of the child's joint frame [N m]; the driver's includes the driving torque.
    """

    torque: Array
    force: Array
    moment: Array

    @staticmethod
    def zeros(bearings: int, n: int) -> "Wrenches":
        """To be filled in."""
        return Wrenches(
            torque=np.zeros(n),
            force=np.zeros((bearings, n, 3)),
            moment=np.zeros((bearings, n, 3)),
        )

    def part(self, points: slice) -> "Wrenches":
        """Views of a part of the motion."""
        return Wrenches(self.torque[points], self.force[:, points], self.moment[:, points])
