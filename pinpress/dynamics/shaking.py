"""Shaking force and shaking moment: the action of the machine on its foundation."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..common.quantities import Array
from ..engines.wrenches import AppliedForce, Wrenches
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..linkage.memo import per_linkage


@per_linkage(of_geometry=True)
def on_frame(press: Linkage) -> tuple[int, ...]:
    """Indices of the bearings on the frame in `Linkage.bearings`."""
    joints = [j for j, parent in enumerate(list(press.model.parents)[1:]) if parent == 0]
    return (*joints, *(k for k, loop in enumerate(press.loops, len(press.joints)) if 0 in (loop.joint1, loop.joint2)))


def shaking(press: Linkage, motion: Motion, wrenches: Wrenches, loads: list[AppliedForce]) -> tuple[Array, Array]:
    """Shaking force and shaking moment about the world origin, (n, 3) each, world axes [N, N m].

    Args:
        press: the press.
        motion: its motion.
        wrenches: of all bearings and contacts.
        loads: forces on links; only those on the frame are added, because the bearing forces include the others.
    """
    total = np.zeros((2, len(motion.crank_angle), 3))

    def add_force(on_frame: Array, about: Array | float, point: Array) -> None:
        total[0] += on_frame
        for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):  # np.cross takes several times as long
            total[1, :, i] += point[..., j] * on_frame[..., k] - point[..., k] * on_frame[..., j]
        total[1] += about

    model = press.model
    frame = model.inertias[0]
    add_force(frame.mass * model.gravity.linear, 0.0, frame.lever)
    for end in _frame_ends(press):
        add_force(end.sign * wrenches.force[end.bearing], end.sign * wrenches.moment[end.bearing], _acting_at(end, motion))
    for load in (*loads, *wrenches.on_frame):
        if load.joint == 0:
            add_force(load.force, 0.0 if load.moment is None else load.moment, load.point)
    return total[0], total[1]


class FrameEnd(NamedTuple):
    """A point of the frame at which a bearing acts on it.

    Attributes:
        bearing: index of the bearing.
        sign: of the bearing's force there.
        point: (3,) where it acts in the drawn pose, in world axes [m].
        along: (3,) direction in which the point travels with a guide; None if it does not.
    """

    bearing: int
    sign: float
    point: Array
    along: Array | None


@per_linkage(of_geometry=True)
def _frame_ends(press: Linkage) -> tuple[FrameEnd, ...]:
    """All ends of bearings on the frame; of a loop both may be there."""
    places, count, ends = press.model.jointPlacements, len(press.joints), []
    axes = press.axes
    for bearing in on_frame(press):
        if bearing < count:
            place, axis = places[bearing + 1], axes[bearing]
            along = None if axis.turns else place.rotation @ axis.direction
            ends.append(FrameEnd(bearing, -1.0, place.translation.copy(), along))
            continue
        loop = press.loops[bearing - count]
        if loop.joint1 == 0:
            ends.append(FrameEnd(bearing, -1.0, loop.point1, None))
        if loop.joint2 == 0:
            ends.append(FrameEnd(bearing, 1.0, loop.point2, None))
    return tuple(ends)


def on_frame_at(press: Linkage, motion: Motion, bearing: int) -> Iterator[tuple[float, Array]]:
    """The sign with which the force of a bearing acts on the frame, and its point of action, (3,) or (n, 3), in world axes [m].

    Both sides of a loop may be on the frame.
    """
    return ((end.sign, _acting_at(end, motion)) for end in _frame_ends(press) if end.bearing == bearing)


def _acting_at(end: FrameEnd, motion: Motion) -> Array:
    """Where an end acts on the frame over a motion, (3,) or (n, 3) [m]."""
    return end.point if end.along is None else end.point + motion.joint_position[:, end.bearing, None] * end.along
