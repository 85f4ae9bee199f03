"""The plane in which a linkage moves, if it is planar, and how far its joints and loops are off the plane."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..common.quantities import Array
from ..engines.planar.model import PARALLEL
from ..engines.structure import Structure, drawn_placements

UPRIGHT = 1e-9  # difference of the normal from a world axis up to which a plane has the world's axes


class Planarity(NamedTuple):
    """How a linkage lies in the plane across one of its joints.

    Attributes:
        turning: index in v of that joint: the first driver, or where that slides the first joint that turns; None if no joint turns.
        normal: (3,) its axis in the drawn pose; without such a joint that of world y, across presses.
        joints_off: for every joint the angle between its axis and the normal, or between its guide and the plane [rad].
        loops_off: for every loop the larger of the angles between its axis at both ends and the normal [rad]; 0 for one without an axis.
    """

    turning: int | None
    normal: Array
    joints_off: tuple[float, ...]
    loops_off: tuple[float, ...]

    @staticmethod
    def of(structure: Structure) -> Planarity:
        """How a linkage lies in the plane of its first driver."""
        turned = [place.rotation.copy() for place in drawn_placements(structure.model)]
        directions = [turned[joint] @ axis.direction for joint, axis in enumerate(structure.axes, 1)]
        turning = next((j for j in (*structure.drivers[:1], *range(len(directions))) if structure.axes[j].turns), None)
        normal = np.array([0.0, -1.0, 0.0]) if turning is None else directions[turning]
        joints_off = [
            _angle_between(direction, normal) if axis.turns else np.pi / 2 - _angle_between(direction, normal)
            for direction, axis in zip(directions, structure.axes, strict=True)
        ]
        loops_off = []
        for loop in structure.loops:
            ends = ((loop.joint1, loop.rotation1), (loop.joint2, loop.rotation2)) if loop.type == "revolute" else ()
            loops_off.append(max((_angle_between(turned[joint] @ end[:, 0], normal) for joint, end in ends), default=0.0))
        return Planarity(turning, normal, tuple(joints_off), tuple(loops_off))

    @property
    def farthest_off(self) -> float:
        """The largest of these angles [rad]."""
        return max(*self.joints_off, *self.loops_off, 0.0)

    @property
    def is_planar(self) -> bool:
        """Whether the axes of all joints and loops are parallel to the normal, and all guides perpendicular to it."""
        return self.farthest_off <= PARALLEL

    @property
    def axes(self) -> Array:
        """(3, 3) unit vectors, as rows, that separate forces in the plane of motion from forces out of it.

        For a planar linkage whose normal is no world axis they are the horizontal in the plane, the normal, and the upward direction in the
        plane; else the world axes.
        """
        normal = self.normal
        if np.abs(normal).max() >= 1 - UPRIGHT or not self.is_planar:
            return np.eye(3)
        along = np.cross((0.0, 0.0, 1.0), normal)
        along *= (1.0 if along[np.argmax(np.abs(along))] > 0 else -1.0) / np.linalg.norm(along)
        upwards = np.cross(normal, along)
        upwards *= 1.0 if upwards[2] > 0 else -1.0
        return np.array([along, np.cross(upwards, along), upwards])


def _angle_between(line: Array, other: Array) -> float:
    """The angle between two lines [rad]."""
    return float(np.arctan2(np.linalg.norm(np.cross(line, other)), abs(line @ other)))
