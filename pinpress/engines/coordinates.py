"""Joint coordinates against Pinocchio's configurations.

A joint coordinate is one number a joint, in the order of v: an angle [rad], unwrapped, or a travel [m], zero in the drawn pose. Pinocchio's
q has the same numbers, except for an unbounded (``continuous``) joint: its cosine and sine.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common.arrays import Array
from ..common.errors import PinpressError

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
