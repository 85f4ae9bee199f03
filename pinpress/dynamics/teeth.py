"""Forces between teeth and threads, along the directions that gears have."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..common.quantities import Array
from ..engines.contacts import Contact
from ..kinematics.motion import Motion
from ..kinematics.poses import rotation_of
from ..linkage.linkage import Linkage


class ToothForces(NamedTuple):
    """Forces (n,) of the first on the second body of a machine element.

    Attributes:
        tangential: across the axis of the gear and the line of centres; its sign is that of the effort of the relation [N].
        radial: along the line of centres, positive where it pushes the two apart [N].
        axial: along the axis of the second body's joint if that turns, else of the first one's, positive along it [N].
        power: lost [W].
    """

    tangential: Array
    radial: Array
    axial: Array
    power: Array


def tooth_forces(press: Linkage, motion: Motion, contact: Contact, force: Array, power: Array) -> ToothForces:
    """The components of the force (n, 3) in a contact, in world axes."""
    turning = contact.second if contact.second and press.axes[contact.second - 1].turns else contact.first
    axis = rotation_of(press, motion.joint_position, turning) @ press.axes[turning - 1].direction
    carrier, unit = rotation_of(press, motion.joint_position, contact.carrier), contact.wrench(motion.joint_position.T)

    def along(direction: Array) -> Array:
        size = np.linalg.norm(direction, axis=1)
        return np.asarray(np.einsum("ni,ni->n", force, direction) / np.where(size > 0.0, size, 1.0))

    pushing, apart = ((carrier @ vectors[..., None])[..., 0] for vectors in (unit.force, unit.push))
    pushing = pushing - np.einsum("ni,ni->n", pushing, axis)[:, None] * axis
    return ToothForces(along(pushing), along(apart), along(axis), power)
