"""Joints of a linkage: loop joints and couplings, joint coordinates, and Pinocchio's configurations.

Every joint has one coordinate, in the order of v: an angle [rad], unwrapped, or a travel [m], zero in the drawn pose. Pinocchio's q holds
these coordinates too, but for an unbounded (``continuous``) joint it holds the cosine and sine of its angle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from ..common.errors import PinpressError
from ..common.frozen import Frozen, read_only
from ..common.quantities import Array

MOST_JOINTS = 200  # `pin.Data` has 7 arrays whose size grows with the cube of the joints: half a gigabyte at this number

_HELD_ROTATIONS = {"spherical": 0, "revolute": 2, "fixed": 3}

Entries = Mapping[int, complex]
"""A row of a matrix: its entries by their columns."""


@dataclass(frozen=True, eq=False, repr=False)
class LoopJoint(Frozen):
    """A bearing at which a loop was cut. Its end 1 is fixed to the body of ``joint1``, its end 2 to that of ``joint2``.

    Attributes:
        name: of the loop.
        type: "spherical", "revolute" (it turns about the first axis of its ends) or "fixed".
        joint1: Pinocchio joint whose body carries end 1, 0 for the frame.
        point1: (3,) position of end 1 in that joint's frame [m].
        rotation1: (3, 3) axes of end 1 in that joint's frame, as columns.
        joint2: Pinocchio joint whose body carries end 2, 0 for the frame.
        point2: (3,) position of end 2 in that joint's frame [m].
        rotation2: (3, 3) axes of end 2 in that joint's frame, as columns.
        line: line of its element in the URDF.
    """

    name: str
    type: str
    joint1: int
    point1: Array
    rotation1: Array
    joint2: int
    point2: Array
    rotation2: Array
    line: int

    def __post_init__(self) -> None:
        for name in ("point1", "rotation1", "point2", "rotation2"):  # copied, because the caller may change his own array later
            object.__setattr__(self, name, read_only(np.array(getattr(self, name), dtype=float)))

    @property
    def held_rotations(self) -> int:
        """Number of rotations that the bearing prevents: those about the last axes of end 1."""
        return _HELD_ROTATIONS[self.type]


@dataclass(frozen=True, eq=False, repr=False)
class Coupling:
    """A gear pair or the like: coordinate of the follower = multiplier x coordinate of the leader + offset.

    Attributes:
        name: of the follower joint.
        follower: index of the follower in v.
        leader: index of the leader in v.
        multiplier: ratio of the two coordinates.
        offset: follower's coordinate where the leader's is zero [rad or m].
        line: line of the ``<mimic>`` element in the URDF.
    """

    name: str
    follower: int
    leader: int
    multiplier: float
    offset: float
    line: int


def joints_between(parents: Sequence[int], joint1: int, joint2: int) -> dict[int, float]:
    """The joints on the path through the tree between two joints, rising: +1 for those that carry only the second one, -1 for those that
    carry only the first one.

    Args:
        parents: parent of every joint. Joints are counted in the order of v, -1 stands for the frame.
        joint1: the first joint.
        joint2: the second joint.
    """
    signs: dict[int, float] = {}
    for joint, sign in ((joint2, 1.0), (joint1, -1.0)):
        while joint >= 0:
            signs[joint] = signs.get(joint, 0.0) + sign
            joint = parents[joint]
    return {joint: sign for joint, sign in sorted(signs.items()) if sign}


# ------------------------------------------------------------------------------------------------------- Pinocchio's model of the tree


class Slot(NamedTuple):
    """Place of a joint in q.

    Attributes:
        start: index of its first number.
        unbounded: whether it has two numbers, cosine and sine, in place of one.
    """

    start: int
    unbounded: bool


def slots(model: pin.Model) -> tuple[Slot, ...]:
    """Slots of the moving joints, in the order of v."""
    return tuple(Slot(joint.idx_q, joint.nq == 2) for joint in list(model.joints)[1:])


class Axis(NamedTuple):
    """Axis of a joint.

    Attributes:
        direction: (3,) unit vector in the joint's own frame.
        turns: True where the joint turns about it, False where it slides along it.
    """

    direction: Array
    turns: bool


def axes(model: pin.Model) -> tuple[Axis, ...]:
    """Axes of the moving joints, in the order of v."""
    columns = (np.ravel(joint.createData().S) for joint in list(model.joints)[1:])
    return tuple(Axis(c[3:].copy(), True) if np.linalg.norm(c[3:]) > 0.5 else Axis(c[:3].copy(), False) for c in columns)


def data_of(model: pin.Model) -> pin.Data:
    """Pinocchio's workspace for a model.

    Raises:
        PinpressError: more than `MOST_JOINTS` joints, for which it would take gigabytes.
    """
    if model.nv > MOST_JOINTS:
        problem = f"{model.name} has {model.nv} joints, more than the {MOST_JOINTS} that Pinocchio has room for"
        raise PinpressError(f"{problem}; model fewer, or ask only for what the planar engine computes")
    return model.createData()


def drawn_placements(model: pin.Model) -> list[pin.SE3]:
    """Placements of all joints in the world in the drawn pose, the world's own first.

    They are products of constant placements down the tree. Pinocchio's own function needs `pin.Data`, whose size grows with nv cubed.
    """
    places = [pin.SE3.Identity()]
    for joint, parent in enumerate(list(model.parents)[1:], 1):
        places.append(places[parent] * model.jointPlacements[joint])
    return places


def configuration(slots: tuple[Slot, ...], x: Array) -> Array:
    """Configurations (nq, ...) of joint coordinates (nv, ...)."""
    q = np.empty((sum(2 if slot.unbounded else 1 for slot in slots), *x.shape[1:]))
    for (start, unbounded), coordinate in zip(slots, x, strict=True):
        if unbounded:
            np.cos(coordinate, out=q[start, ...])
            np.sin(coordinate, out=q[start + 1, ...])
        else:
            q[start] = coordinate
    return q


def crank_angle(slot: Slot, q: Array) -> float:
    """Angle of a joint [rad] in one configuration (nq,); of an unbounded joint between -pi and pi."""
    return float(np.arctan2(q[slot.start + 1], q[slot.start]) if slot.unbounded else q[slot.start])


# ------------------------------------------------------------------------------------------------------------------------ constant matrices


def array_of(rows: Sequence[Entries], width: int, dtype: type = complex) -> Any:
    """The array (rows, width) with these entries, of numbers of this type; all others are zero."""
    result: Array = np.zeros((len(rows), width), dtype)
    for place, row in enumerate(rows):
        for column, entry in row.items():
            result[place, column] = entry
    return result
