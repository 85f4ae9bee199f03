"""What holds the tree of a linkage together: the bearings at which its loops were cut, and the gear pairs between its joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..common.arrays import Array
from ..common.frozen import Frozen, read_only

_HELD = {"spherical": 0, "revolute": 2, "fixed": 3}


@dataclass(frozen=True, eq=False, repr=False)
class LoopJoint(Frozen):
    """A bearing at which a loop was cut. End k is fixed to the body of Pinocchio joint k (0: the frame), in that joint's frame.

    Attributes:
        type: "spherical", "revolute" (turns about the first axis of its ends) or "fixed".
        point1, point2: (3,) where the ends are [m].
        rotation1, rotation2: (3, 3) axes of the ends, as columns.
        line: of its element in the URDF.
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
        for name in ("point1", "rotation1", "point2", "rotation2"):  # copies, as what a caller keeps is his to change
            object.__setattr__(self, name, read_only(np.array(getattr(self, name), dtype=float)))

    @property
    def held(self) -> int:
        """How many of its rotations the bearing holds: the last ones, about the axes of end 1."""
        return _HELD[self.type]


@dataclass(frozen=True, eq=False, repr=False)
class Coupling:
    """A gear pair or the like: coordinate of ``follower`` = ``multiplier`` x that of ``leader`` + ``offset``, indices in v [rad or m].

    ``name`` is the follower's, ``line`` that of its ``<mimic>``.
    """

    name: str
    follower: int
    leader: int
    multiplier: float
    offset: float
    line: int


def between(parents: Sequence[int], joint1: int, joint2: int) -> dict[int, float]:
    """The joints of the tree on the way from one joint to another, rising: +1 of those that carry only the second, -1 only the first.

    ``parents`` of the joints, all in the order of v; -1 stands for the frame.
    """
    signs: dict[int, float] = {}
    for joint, sign in ((joint2, 1.0), (joint1, -1.0)):
        while joint >= 0:
            signs[joint] = signs.get(joint, 0.0) + sign
            joint = parents[joint]
    return {joint: sign for joint, sign in sorted(signs.items()) if sign}
