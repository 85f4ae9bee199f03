"""The constraints of a linkage: bearings at which loops were cut, and relations between joint coordinates.

A constraint has equations. Each is a gap that has to be zero, with slopes by the joints that it names, and a drift: the second derivative
of the gap at given joint rates without joint accelerations. The multiplier of an equation acts on these joints as efforts: slope times
multiplier.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ..common.frozen import Frozen, read_only
from ..common.quantities import Array

_PREVENTED_ROTATIONS = {"spherical": 0, "revolute": 2, "fixed": 3}


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
        return _PREVENTED_ROTATIONS[self.type]


class Curve(NamedTuple):
    """A function of the coordinate of one joint, as the lift of a cam.

    Attributes:
        joint: index of the joint in v.
        function: (n,) -> values and first and second derivatives (n,) each [rad or m, by rad or m].
        start: argument of the function where the joint's coordinate is zero [rad or m].
    """

    joint: int
    function: Callable[[Array], tuple[Array, Array, Array]]
    start: float = 0.0

    def at(self, x: Array) -> tuple[Array, Array, Array]:
        """Values and derivatives (n,) at joint coordinates (nv, n)."""
        return self.function(self.start + x[self.joint])


@dataclass(frozen=True, eq=False, repr=False)
class Relation:
    """One equation between joint coordinates: the sum of coefficient x coordinate, less the value of a curve, is the offset.

    It determines the first joint that it names, and its multiplier is the effort on that joint. Gear pairs, racks and screws are relations
    of two joints (`gear`), a joint that stands still is one of a single joint.

    Attributes:
        name: of the joint that it determines; that of a machine element, such as teeth, is its own.
        coefficients: by the indices of joints in v; that of the first joint, which it determines, is 1.
        offset: right-hand side, in the unit of the first joint [rad or m].
        line: line of its element in the URDF; 0 if none stands there.
        curve: of a joint without a coefficient; None for a linear relation.
    """

    name: str
    coefficients: Mapping[int, float]
    offset: float = 0.0
    line: int = 0
    curve: Curve | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "coefficients", MappingProxyType(dict(self.coefficients)))

    def __reduce__(self) -> tuple[object, ...]:  # a mapping proxy cannot be pickled
        return Relation, (self.name, dict(self.coefficients), self.offset, self.line, self.curve)

    @property
    def joint(self) -> int:
        """Index in v of the joint that it determines."""
        return next(iter(self.coefficients))

    @property
    def joints(self) -> tuple[int, ...]:
        """Indices in v of all joints that it names."""
        return (*self.coefficients, *(() if self.curve is None else (self.curve.joint,)))

    def through(self, pose: Array) -> Relation:
        """The relation with the offset that joint coordinates (nv,) fulfil."""
        value = 0.0 if self.curve is None else float(self.curve.at(pose[:, None])[0][0])
        return replace(self, offset=float(sum(by * pose[joint] for joint, by in self.coefficients.items())) - value)

    def drawn_in(self, pose: Array) -> Relation:
        """The relation between coordinates that count from a pose (nv,), which fulfils it."""
        curve = None if self.curve is None else self.curve._replace(start=self.curve.start + float(pose[self.curve.joint]))
        return replace(self, curve=curve).through(np.zeros_like(pose))

    def between(self, index: Mapping[int, int]) -> Relation:
        """The relation where its joints have other indices."""
        curve = None if self.curve is None else self.curve._replace(joint=index[self.curve.joint])
        return replace(self, coefficients={index[joint]: by for joint, by in self.coefficients.items()}, curve=curve)

    @property
    def is_pair(self) -> bool:
        """Whether it keeps a ratio between two joints."""
        return len(self.coefficients) == 2 and self.curve is None

    @property
    def ratios(self) -> dict[int, float]:
        """What the coordinate of the joint gains by each of the other joints that the relation names."""
        return {other: -coefficient for other, coefficient in self.coefficients.items() if other != self.joint}


@dataclass(frozen=True, eq=False, repr=False)
class Coupling:
    """A gear pair or the like, as a view of its `Relation`: coordinate of the follower = multiplier x coordinate of the leader + offset.

    Attributes:
        name: of the follower joint; that of a machine element is its own.
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

    @staticmethod
    def of(relation: Relation) -> Coupling:
        """The view of a relation of two joints."""
        ((leader, multiplier),) = relation.ratios.items()
        return Coupling(relation.name, relation.joint, leader, multiplier, relation.offset, relation.line)


def gear(name: str, follower: int, leader: int, multiplier: float, offset: float = 0.0, line: int = 0) -> Relation:
    """The relation of a gear pair, a rack or a screw; arguments as the attributes of `Coupling`."""
    return Relation(name, {follower: 1.0, leader: -multiplier}, offset, line)
