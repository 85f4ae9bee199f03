"""Poses of the bodies of a linkage in the states of a motion, and how points of them move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.errors import UnknownNameError
from ..common.quantities import Array
from ..engines.structure import Axis
from ..linkage.linkage import Linkage
from .motion import Motion


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses of the bodies of all Pinocchio joints (0: the frame) in n states, in world axes.

    Attributes:
        rotation: (joints + 1, n, 3, 3) rotation matrices of the joints' frames.
        position: (joints + 1, n, 3) positions of the joints' frames [m].
    """

    rotation: Array
    position: Array

    def points(self, joint: int, point: Array) -> Array:
        """(n, 3) world position of a point (3,) fixed to the body of a joint, in that joint's frame [m]."""
        return np.asarray(self.rotation[joint] @ point + self.position[joint])


def poses(press: Linkage, joint_position: Array) -> Poses:
    """Poses of all bodies at joint coordinates (n, nv), from the placements of the model's joints."""
    model, n = press.model, len(joint_position)
    rotation, position = np.empty((model.njoints, n, 3, 3)), np.empty((model.njoints, n, 3))
    rotation[0], position[0] = np.eye(3), 0.0
    for j, (axis, moved) in enumerate(zip(press.axes, joint_position.T, strict=True), 1):
        parent = model.parents[j]
        rotation[j], position[j] = carried(model.jointPlacements[j], axis, moved, rotation[parent], position[parent])
    return Poses(rotation, position)


def rotation_of(press: Linkage, joint_position: Array, joint: int) -> Array:
    """Rotations (n, 3, 3) of the body of a Pinocchio joint at joint coordinates (n, nv)."""
    model, axes, rotation = press.model, press.axes, np.broadcast_to(np.eye(3), (len(joint_position), 3, 3))
    while joint:
        turned = model.jointPlacements[joint].rotation
        axis = axes[joint - 1]
        if axis.turns:
            turned = turned @ _turned(axis.direction, joint_position[:, joint - 1])
        rotation, joint = turned @ rotation, model.parents[joint]
    return rotation


def carried(place: pin.SE3, axis: Axis, moved: Array, rotation: Array, position: Array) -> tuple[Array, Array]:
    """Rotations (n, 3, 3) and positions (n, 3) of the body of a joint with this placement and axis, at coordinates (n,), from those of the
    body that carries it."""
    turned = rotation @ place.rotation
    shifted = position + rotation @ place.translation
    if axis.turns:
        return turned @ _turned(axis.direction, moved), shifted
    return turned, shifted + moved[:, None] * (turned @ axis.direction)


def bearing_points(press: Linkage, at: Poses) -> Array:
    """(bearings, n, 3) points where the bearing forces act, in the order of `Linkage.bearings`, world axes [m]: origins of the joint
    frames, then points of the loops."""
    joints = [at.position[j] for j in range(1, press.model.njoints)]
    return np.array([*joints, *(at.points(loop.joint1, loop.point1) for loop in press.loops)])


def contact_points(press: Linkage, at: Poses, joint_position: Array) -> dict[str, Array]:
    """Points (n, 3) where bodies touch in gears, racks, screws, worms and cams, by the names of these, at joint coordinates (n, nv), world
    axes [m]."""
    placed = {}
    for contact in press.contacts:
        point = np.broadcast_to(contact.wrench(joint_position.T).point, (len(joint_position), 3))
        placed[contact.name] = np.einsum("nij,nj->ni", at.rotation[contact.carrier], point) + at.position[contact.carrier]
    return placed


def point_motion(press: Linkage, motion: Motion, joint: int, point: Array) -> tuple[Array, Array]:
    """World position [m] and velocity [m/s], (n, 3) each, of a point (3,) fixed to the body of a Pinocchio joint (0: the frame)."""
    n = len(motion.crank_angle)
    if joint == 0:
        return np.broadcast_to(point, (n, 3)), np.zeros((n, 3))
    moved = press.engine().body_motion(motion.states(press), [joint], accelerations=False).points(np.array([point]))
    return moved.place[0].T, moved.velocity[0].T


def point_on_body(press: Linkage, link: str, point: ArrayLike, what: str, name: str) -> tuple[int, Array]:
    """The Pinocchio joint to whose body a link belongs, and a point of the link in that joint's frame (3,) [m].

    Args:
        press: the linkage.
        link: name of the link.
        point: (3,) in the link's frame [m].
        what: what has the point, for messages.
        name: the argument's name, for messages.

    Raises:
        UnknownNameError: a link that the linkage does not have.
    """
    joint, position = body_of(press, link), np.asarray(point, dtype=float)
    plausibility.point(f"{what}: {name}", position, press.size)
    return joint, press.model.frames[press.model.getFrameId(link, pin.BODY)].placement.act(position)


def body_of(press: Linkage, link: str) -> int:
    """The Pinocchio joint to whose body a link belongs; raises UnknownNameError where the linkage has no such link."""
    if not isinstance(link, str) or link not in press.links:
        raise UnknownNameError("link", link, press.links)
    return int(press.model.frames[press.model.getFrameId(link, pin.BODY)].parentJoint)


def loaded_bodies(press: Linkage) -> tuple[int, ...]:
    """The Pinocchio joints on whose bodies the bearing forces act, in the order of `Linkage.bearings`: the child of a joint, link2 of a
    loop."""
    return (*range(1, press.model.njoints), *(loop.joint2 for loop in press.loops))


def _turned(axis: Array, angle: Array) -> Array:
    """(n, 3, 3) rotations by angles (n,) about an axis, by Rodrigues' formula."""
    skew = pin.skew(axis)
    return np.asarray(np.eye(3) + np.multiply.outer(np.sin(angle), skew) + np.multiply.outer(1.0 - np.cos(angle), skew @ skew))
