"""What holds the tree of a linkage together: the bearings at which its loops were cut, and the gear pairs between its joints; joint
coordinates against Pinocchio's configurations; and matrices with few entries a row.

A joint coordinate is one number a joint, in the order of v: an angle [rad], unwrapped, or a travel [m], zero in the drawn pose. Pinocchio's
q has the same numbers, except for an unbounded (``continuous``) joint: its cosine and sine.

Constant matrices of joints, loops and functions of the configuration are plain arrays where a linkage is small, SciPy's sparse ones where
it is large, so that time and memory grow with the entries. Both take ``matrix @ columns``, slices of rows and transposition; for the rest
there are functions here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from ..common.errors import PinpressError
from ..common.frozen import Frozen, read_only
from ..common.quantities import Array, ComplexArray

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


MOST_JOINTS = 200  # `pin.Data` has 7 arrays of their cube: half a gigabyte


class Slot(NamedTuple):
    """Where a joint stands in q: its first place, and whether it is unbounded and takes two."""

    start: int
    unbounded: bool


def slots(model: pin.Model) -> tuple[Slot, ...]:
    """Slots of the moving joints, in the order of v."""
    return tuple(Slot(joint.idx_q, joint.nq == 2) for joint in list(model.joints)[1:])


class Axis(NamedTuple):
    """Axis (3,) of a joint in its own frame, and whether the joint turns about it or slides along it."""

    direction: Array
    turns: bool


def axes(model: pin.Model) -> tuple[Axis, ...]:
    """Axes of the moving joints, in the order of v."""
    columns = (np.ravel(joint.createData().S) for joint in list(model.joints)[1:])
    return tuple(Axis(c[3:].copy(), True) if np.linalg.norm(c[3:]) > 0.5 else Axis(c[:3].copy(), False) for c in columns)


def data_of(model: pin.Model) -> pin.Data:
    """Room for Pinocchio's algorithms; raises PinpressError where it would take gigabytes, as it grows with the joints cubed."""
    if model.nv > MOST_JOINTS:
        problem = f"{model.name} has {model.nv} joints, more than the {MOST_JOINTS} that Pinocchio has room for"
        raise PinpressError(f"{problem}; model fewer, or ask only for what the planar engine computes")
    return model.createData()


def drawn(model: pin.Model) -> list[pin.SE3]:
    """Placements of all joints in the world in the drawn pose, the world's own first.

    The product of constants down the tree. `pin.Data`, with which Pinocchio would find the same, has arrays of nv cubed numbers.
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
    """Angle of a joint [rad] in one configuration (nq,), of an unbounded one between -pi and pi."""
    return float(np.arctan2(q[slot.start + 1], q[slot.start]) if slot.unbounded else q[slot.start])


LARGE = 33  # joints from which sparse matrices are the faster ones
SERIAL = 65_536  # scalar multiplications up to which OpenBLAS makes a complex product in one thread
SERIAL_ROW = 4_095  # the same of one row, which is a vector to it

Matrix = Any
"""A NumPy array or a SciPy `csr_array`."""

Entries = Mapping[int, complex]
"""A row: its entries by their columns."""


def matrix(rows: Sequence[Entries], width: int, joints: int, dtype: type = complex) -> Matrix:
    """The matrix (rows, width) with these entries, of a linkage with so many ``joints``."""
    if joints < LARGE:
        filled: Array = np.zeros((len(rows), width), dtype)
        for place, row in enumerate(rows):
            for column, entry in row.items():
                filled[place, column] = entry
        return filled
    from scipy.sparse import csr_array  # its import takes longer than loading a small press

    ends = np.cumsum([0, *map(len, rows)])
    columns = np.array([column for row in rows for column in row], dtype=int)
    entries: Array = np.array([entry for row in rows for entry in row.values()], dtype)
    found = csr_array((entries, columns, ends), shape=(len(rows), width))
    found.sort_indices()
    return found


def product(rows: Matrix, columns: Any) -> Any:
    """``rows @ columns`` for any rows and many columns; of a plain array in pieces so small that BLAS keeps to one thread.

    Its threads are no gain here, and where the machine has other work to do they wait milliseconds for each other.
    """
    if not isinstance(rows, np.ndarray):
        return np.asarray(rows @ columns)
    step = max(1, (SERIAL if len(rows) > 1 else SERIAL_ROW) // max(1, rows.size))
    if columns.shape[1] <= step:
        return np.asarray(rows @ columns)
    result = np.empty((len(rows), columns.shape[1]), np.result_type(rows, columns))
    for start in range(0, columns.shape[1], step):
        np.matmul(rows, columns[:, start : start + step], out=result[:, start : start + step])
    return result


def plain(rows: Matrix) -> Any:
    """The matrix as a NumPy array."""
    return rows if isinstance(rows, np.ndarray) else rows.toarray()


def stacked(parts: Sequence[Matrix]) -> Matrix:
    """The rows of all parts, one below the other."""
    if isinstance(parts[0], np.ndarray):
        return np.concatenate(parts)
    from scipy.sparse import vstack  # see `matrix`

    return vstack(parts, format="csr")


def weighted(rows: Matrix, weights: Array) -> Matrix:
    """Every row times its weight."""
    return rows * weights[:, None] if isinstance(rows, np.ndarray) else rows.multiply(weights[:, None]).tocsr()


def compressed(rows: Matrix) -> Matrix:
    """A product or transpose of such matrices in the form of one of them again."""
    return rows if isinstance(rows, np.ndarray) else rows.tocsr()


def with_column(rows: Matrix, column: int, entries: ComplexArray) -> Matrix:
    """The matrix with one column replaced."""
    changed = rows.copy() if isinstance(rows, np.ndarray) else rows.tolil()
    changed[:, [column]] = entries[:, None]
    return compressed(changed)
