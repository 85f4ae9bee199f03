"""Contacts of machine elements: teeth, threads, rollers on cams, through which two bodies push on each other.

A relation moves the joints of a contact; its multiplier is an effort on the joint that it determines. What really acts is the wrench of one
body on the other one at their contact. Both do the same work in every motion of the linkage, so that the driving torque is the same, but
not the forces in the bearings. A contact says how the wrench follows from the multiplier.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..common.frozen import Frozen
from ..common.quantities import Array

ZERO = np.zeros(3)


class UnitWrench(NamedTuple):
    """What the first body does to the second one where the effort of the relation is 1, in the axes of the carrier's joint frame.

    Attributes:
        point: (3,) or (n, 3) where the two bodies touch, in the carrier's joint frame [m].
        force: (3,) or (n, 3) force at the point, which changes its sign with the effort [1/m where the effort is a torque, else 1].
        couple: (3,) or (n, 3) moment in addition to that of the force, which changes its sign with the effort [1, or m].
        push: (3,) or (n, 3) force at the point by the size of the effort, whatever its sign: teeth separate the gears.
    """

    point: Array
    force: Array
    couple: Array = ZERO
    push: Array = ZERO


class Rubbing(NamedTuple):
    """Friction of a contact, as a wrench between two bodies against the speed with which they rub.

    The speed is the power of this wrench in the motion of the second body relative to the first one. Friction is a share of the size of the
    effort of the contact's relation, in the opposite sense.

    Attributes:
        first: Pinocchio joint of the body that rubs, 0 for the frame.
        second: Pinocchio joint of the body on which it rubs, 0 for the frame.
        force: (3,) force on the second body at the contact's point, in the axes of the carrier [1/m where the effort is a torque, else 1].
        couple: (3,) moment on the second body in addition, likewise.
        forward: share of the effort where the contact's first body drives its second one.
        backward: share of the effort where the second body drives the first one.
        push_backward: (3,) `UnitWrench.push` where the second body drives, if it is another one, as in a worm gear; None: the same.
    """

    first: int
    second: int
    force: Array
    couple: Array
    forward: float
    backward: float
    push_backward: Array | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Contact(Frozen):
    """A contact whose wrench stands still in its carrier: teeth at a pitch point, a thread.

    Attributes:
        name: of the contact; empty for the pair of a shaft and a slide in ``<mimic>``, which has no bearing of its own in results.
        kind: "gears", "rack", "screw", "worm" or "cam".
        relation: index of its relation in `Structure.relations`.
        first: Pinocchio joint of the first body, 0 for the frame.
        second: Pinocchio joint of the second body, 0 for the frame.
        carrier: Pinocchio joint of the body that carries both, 0 for the frame.
        unit: the wrench of the first on the second body by the effort.
        rubbing: its friction; empty without losses.
        shares: number of equal contacts round the first body for which this one stands, as of planets. Each takes an equal part of the
            effort, and together they load neither the bearing of the sun nor that of the ring.
    """

    name: str
    kind: str
    relation: int
    first: int
    second: int
    carrier: int
    unit: UnitWrench
    rubbing: tuple[Rubbing, ...] = ()
    shares: int = 1

    def wrench(self, position: Array) -> UnitWrench:
        """The unit wrench at joint coordinates (nv, n)."""
        return self.unit
