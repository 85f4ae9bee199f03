"""Forces as arrays, as every engine takes and returns them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..common.quantities import Array
from .friction import FrictionLaw

ORIGIN = np.zeros(3)


@dataclass(frozen=True)
class AppliedForce:
    """The force and the moment of one load over a motion.

    Attributes:
        joint: Pinocchio joint on whose body they act, 0 for the frame.
        point: (3,) where the force acts, in that joint's frame [m].
        force: (n, 3) in world axes [N].
        moment: (n, 3) in addition to that of the force, in world axes [N m]; None for none.
    """

    joint: int
    point: Array
    force: Array
    moment: Array | None = None

    @staticmethod
    def couple(joint: int, moment: Array) -> AppliedForce:
        """A moment (n, 3) alone."""
        return AppliedForce(joint, ORIGIN, np.zeros_like(moment), moment)

    def times(self, factor: float) -> AppliedForce:
        """The load, multiplied by a number."""
        return AppliedForce(self.joint, self.point, factor * self.force, None if self.moment is None else factor * self.moment)

    def part(self, points: slice) -> AppliedForce:
        """The load over a part of the motion."""
        return AppliedForce(self.joint, self.point, self.force[points], None if self.moment is None else self.moment[points])


class AppliedConditions(NamedTuple):
    """What acts on a linkage in motion.

    Attributes:
        loads: forces on links.
        law: friction of the bearings; None for none.
        compliance: (bearings,) compliances by which bearings share redundant forces [m/N]; None if no stiffness is given.
        efforts: (nv, n) what springs, dampers and rotors in the joints supply, along the joints' axes [N m, N]; None if there are none.
        friction: (bearings, n) efforts of friction that are known, in place of a law; None for none.
    """

    loads: list[AppliedForce]
    law: FrictionLaw | None
    compliance: Array | None
    efforts: Array | None = None
    friction: Array | None = None

    def part(self, points: slice) -> AppliedConditions:
        """The conditions over a part of the motion."""
        efforts, friction = (None if each is None else each[:, points] for each in (self.efforts, self.friction))
        return self._replace(loads=[load.part(points) for load in self.loads], efforts=efforts, friction=friction)

    def under(self, loads: Iterable[AppliedForce], friction: Array | None) -> AppliedConditions:
        """The conditions under more loads and known efforts of friction (bearings, n), in place of a law."""
        return self._replace(loads=[*self.loads, *loads], law=None, friction=friction)


@dataclass(frozen=True, eq=False, repr=False)
class Wrenches:
    """Driving torques, and the forces and moments of the bearings.

    Bearings are the joints in Pinocchio's order, then the loops as declared. Forces and moments are in world axes, the action of parent on
    child (of link1 on link2). `machine_elements.forces` adds the contacts behind the bearings: the action of the first body on the second
    one, the moment about the point where they touch.

    Attributes:
        torque: (drivers, n) on the driver joints, positive along their axes [N m, of a driver that slides N].
        relations: (relations, n) effort of every relation on the joint that it determines [N m, or N where the joint slides]. Without the
            bearings it is one of several solutions that balance, where rigid mechanics leaves it open.
        friction: (bearings, n) power lost in every bearing [W].
        force: (bearings, n, 3) forces [N]; (0, n, 3) where the bearings are left out.
        moment: (bearings, n, 3) moments about the origin of the child's joint frame, of a loop about its point [N m]; (0, n, 3) as above.
            Along the axis in which a joint is free the moment is the effort of drive, gear pairs and friction.
        on_frame: what contacts do to the frame.
    """

    torque: Array
    relations: Array
    friction: Array
    force: Array
    moment: Array
    on_frame: tuple[AppliedForce, ...] = ()

    @staticmethod
    def zeros(drivers: int, relations: int, bearings: int, n: int, with_bearings: bool) -> Wrenches:
        """Wrenches to be filled in, of n states, with the forces and moments of the bearings or without; arguments are numbers of each.

        In memory the states are next to each other: components along one axis are filled in, and read, at once.
        """
        force, moment = np.zeros((2, 3, bearings if with_bearings else 0, n)).transpose(0, 2, 3, 1)
        return Wrenches(np.zeros((drivers, n)), np.zeros((relations, n)), np.zeros((bearings, n)), force, moment)

    def part(self, points: slice) -> Wrenches:
        """Views of a part of the motion."""
        torque, relations, friction = (array[:, points] for array in (self.torque, self.relations, self.friction))
        return Wrenches(torque, relations, friction, self.force[:, points], self.moment[:, points])


class Idle(NamedTuple):
    """Forces that balance each other and move nothing, k of them in every state; those of a state with fewer are zero.

    Attributes:
        relations: (k, relations, n) efforts, as of `Wrenches`.
        force: (k, bearings, n, 3) forces of the bearings.
        moment: (k, bearings, n, 3) moments.
    """

    relations: Array
    force: Array
    moment: Array


class BearingLoads(NamedTuple):
    """What friction depends on in every bearing, joints in Pinocchio's order, then loops.

    Attributes:
        speed: (bearings, n) speeds of the bearings [rad/s, of a guide m/s].
        radial: (bearings, n, 3) vectors whose lengths are the radial forces; they are affine in accelerations, loads and efforts [N].
        relations: (relations, n) efforts of the relations, as of `Wrenches`.
    """

    speed: Array
    radial: Array
    relations: Array
