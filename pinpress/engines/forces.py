"""What either engine takes and returns, as arrays: forces on the links; friction in all bearings at once, found together with the forces
that cause it; efforts of drives and gear pairs; the force and moment in every joint and loop.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.arrays import Array
from ..common.errors import PinpressError


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


REST = 1e-12  # share of the motion's largest speed below which a bearing rests: in a dead centre the speed is rounding
MOST_ITERATIONS = 200


@dataclass(frozen=True, eq=False, repr=False)
class FrictionLaw:
    """The friction of all bearings, joints in Pinocchio's order, then loops.

    Attributes:
        arm: (bearings,) mu r [m], of guides mu [-].
        viscous: (bearings,).
        turns: (bearings,) true but for guides.
        size: length of the linkage [m].
    """

    arm: Array
    viscous: Array
    turns: NDArray[np.bool_]
    size: float

    def moving(self, speeds: Array) -> Array:
        """Speeds (bearings, n), zero where they are rounding, beside the fastest of the motion."""
        turning = np.abs(speeds[self.turns]).max(initial=0.0)
        sliding = max(self.size * turning, np.abs(speeds[~self.turns]).max(initial=0.0))
        return np.where(np.abs(speeds) <= REST * np.where(self.turns, turning, sliding)[:, None], 0.0, speeds)

    def efforts(self, speeds: Array, forces: Callable[[Array], Array], angle: Array) -> Array:
        """Efforts (bearings, n) of friction, along the speeds, against them.

        Args:
            speeds: (bearings, n) of the bearings; exactly zero where one rests.
            forces: radial forces (bearings, n) under efforts (bearings, n) of friction.
            angle: (n,) crank angles, to name one.

        Raises:
            PinpressError: no consistent forces are found: friction locks the linkage, or nearly so.
        """
        steady = -self.viscous[:, None] * speeds
        against = -self.arm[:, None] * np.sign(speeds)
        found, change = steady, np.full(speeds.shape[1], np.inf)
        for _ in range(MOST_ITERATIONS):
            pressing = forces(found)
            following = steady + against * pressing
            before, change = change, np.abs(following - found).max(axis=0)
            # also beside what the largest force could do: a guide's own may be nothing but rounding
            size = np.maximum(np.abs(following).max(axis=0), self.arm.max() * pressing.max(axis=0))
            found = following
            # rounding can keep the last digits moving: stop where the change no longer shrinks
            if np.all((change <= 1e-15 * size) | ((change <= 1e-12 * size) & (change >= before))):
                return found
            if not np.isfinite(size).all():
                break
        worst = int(np.argmax(np.where(np.isfinite(change), change, np.inf)))
        raise PinpressError(
            f"friction locks the linkage, or nearly so, at crank angle {np.degrees(angle[worst]):.6g} deg: no consistent bearing forces are"
            " found; lower the coefficients of friction, or keep away from the dead point"
        )
