"""Frames of links: where they are, and how they move with all joints and with the drivers, at all configurations at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ...common.quantities import Array
from ..body_motion import cross
from ..structure import joints_between
from .bodies import Placements, motion_axes, placements
from .closing import PassiveColumns
from .equations import Equations, Loops, equations


class Frame(NamedTuple):
    """A frame that is fixed to the body of a joint.

    Attributes:
        joint: Pinocchio's index of the joint, 0 for the ground.
        rotation: (3, 3) from the frame to the joint's frame.
        point: (3,) its origin in the joint's frame [m].
    """

    joint: int
    rotation: Array
    point: Array

    @staticmethod
    def of(frame: pin.Frame) -> Frame:
        """The frame of a link in a model."""
        return Frame(int(frame.parentJoint), frame.placement.rotation.copy(), frame.placement.translation.copy())

    def rotations(self, placed: Placements) -> Array:
        """(3, 3, n) from the frame to the world."""
        return np.asarray(np.einsum("ikn,kl->iln", placed.rotation[self.joint], self.rotation))

    def columns(self, loops: Loops, placed: Placements) -> Array:
        """(6, nv, n) velocity of the origin and angular velocity, world axes, at a unit rate of every joint of the open tree."""
        bodies, n = loops.bodies, placed.origin.shape[-1]
        result = np.zeros((6, len(bodies.parents), n))
        if carrying := list(joints_between(loops.structure.parents, -1, self.joint - 1)):
            axes = motion_axes(bodies, placed)[carrying]
            at = placed.point(self.joint, self.point)
            result[:3, carrying] = (axes[:, 1] + cross(axes[:, 0], at[None])).swapaxes(0, 1)
            result[3:, carrying] = axes[:, 0].swapaxes(0, 1)
        return result


def placed_frame(loops: Loops, frame: Frame, x: Array) -> Array:
    """Homogeneous matrices (n, 4, 4) from a frame to the world, at joint coordinates (nv, n)."""
    at = placements(loops.bodies, x)
    result = np.zeros((x.shape[1], 4, 4))
    result[:, :3, :3] = frame.rotations(at).transpose(2, 0, 1)
    result[:, :3, 3] = at.point(frame.joint, frame.point).T
    result[:, 3, 3] = 1.0
    return result


class Moving(NamedTuple):
    """How a frame moves with the drivers.

    Attributes:
        columns: (6, drivers, n) velocity of the origin and angular velocity, world axes, at a unit rate of each driver. Where the drivers
            do not determine how the joints move it is not finite.
        margins: (n,) least singular value of the passive joints' columns in the equations, scaled to unit length: zero where the linkage
            locks or two assemblies meet.
    """

    columns: Array
    margins: Array


def influence(loops: Loops, state: Equations, passive: PassiveColumns) -> Array:
    """(nv, drivers, n) rates of all joints at a unit rate of each driver; not a number where the drivers do not determine them."""
    moving, nv = list(loops.structure.drivers), loops.structure.model.nv
    result = np.empty((nv, len(moving), state.x.shape[1]))
    for k in range(len(moving)):
        result[:, k] = passive.rates(-state.driving[:, k])
    result[moving] = np.eye(len(moving))[:, :, None]
    result[:, :, passive.undetermined] = np.nan
    return result


def moving_frame(loops: Loops, x: Array, frame: Frame, with_margins: bool = False) -> Moving:
    """How a frame moves with the drivers at closed joint coordinates (nv, n); ``with_margins``: else these are empty."""
    n, step = x.shape[1], loops.piece
    columns, margins = np.empty((6, len(loops.structure.drivers), n)), np.empty(n if with_margins else 0)
    for start in range(0, n, step):
        piece = slice(start, start + step)
        state = equations(loops, x[:, piece])
        passive = PassiveColumns(loops, state.entries)
        with np.errstate(invalid="ignore"):  # of positions that are not determined
            columns[..., piece] = np.einsum(
                "ijn,jdn->idn", frame.columns(loops, state.placed), influence(loops, state, passive), optimize=True
            )
        if with_margins:
            margins[piece] = passive.margins()[0]
    return Moving(columns, margins)
