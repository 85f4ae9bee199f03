"""What either engine takes and returns, as arrays: forces on the links; efforts of drives, gear pairs and friction; the force and moment in
every joint and loop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..common.arrays import Array
from .friction import FrictionLaw


@dataclass(frozen=True)
class AppliedForce:
    """A load worked out for one motion: on the body of Pinocchio joint ``joint`` (0: the frame), ``point`` (3,) in that joint's
    frame [m], ``force`` (n, 3) in world axes [N]."""

    joint: int
    point: Array
    force: Array

    def part(self, points: slice) -> AppliedForce:
        """The load over a part of the motion."""
        return AppliedForce(self.joint, self.point, self.force[points])


class AppliedConditions(NamedTuple):
    """What acts on a linkage in motion, and what is asked of its gears.

    Attributes:
        loads: forces on links.
        law: friction of the bearings, None where there is none.
        compliance: (bearings,) by which bearings share forces [m/N], None where no stiffness is given.
        gears: whether the torques of gear pairs are wanted; if not, they are one of several that balance.
    """

    loads: list[AppliedForce]
    law: FrictionLaw | None
    compliance: Array | None
    gears: bool

    def part(self, points: slice) -> AppliedConditions:
        """The conditions over a part of the motion."""
        return self._replace(loads=[load.part(points) for load in self.loads])


@dataclass(frozen=True, eq=False, repr=False)
class Wrenches:
    """Joints in Pinocchio's order, then loops as declared; all in world axes, parent on child (link1 on link2), at the joint. Forces and
    moments are of the bearings that were wanted, in the same order.

    Attributes:
        torque: (drivers, n) on the driver joints, positive along their axes [N m].
        coupling: (couplings, n) torque on the follower of each, positive along its axis [N m, or N where it slides].
        friction: (bearings, n) power lost in each [W].
        force: (wanted bearings, n, 3) [N].
        moment: (wanted bearings, n, 3) about the origin of the child's joint frame [N m], of a loop about its point; along the axis in
            which a joint is free it is the effort of drive, gear pairs and friction.
    """

    torque: Array
    coupling: Array
    friction: Array
    force: Array
    moment: Array

    @staticmethod
    def zeros(drivers: int, couplings: int, bearings: int, n: int, wanted: int) -> Wrenches:
        """To be filled in; counts of each, ``wanted`` of the bearings."""
        return Wrenches(
            torque=np.zeros((drivers, n)),
            coupling=np.zeros((couplings, n)),
            friction=np.zeros((bearings, n)),
            force=np.zeros((wanted, n, 3)),
            moment=np.zeros((wanted, n, 3)),
        )

    def part(self, points: slice) -> Wrenches:
        """Views of a part of the motion."""
        return Wrenches(
            self.torque[:, points], self.coupling[:, points], self.friction[:, points], self.force[:, points], self.moment[:, points]
        )
