"""Forces between teeth and threads: tangential, radial and axial."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..common.quantities import Array
from ..common.results import Tabular
from ..engines.contacts import Contact
from ..kinematics.motion import Motion
from ..kinematics.poses import rotation_of
from ..linkage.linkage import Linkage


@dataclass(frozen=True, eq=False, repr=False)
class ToothForces(Tabular):
    """Forces (n,) of the first on the second link of a machine element.

    Attributes:
        tangential: across the axis of the gear and the line of centres; its sign is that of the effort of the relation [N].
        radial: along the line of centres, positive where it pushes the two apart [N].
        axial: along the axis of the second body's joint if that turns, else of the first one's, positive along it [N].
        power: lost power [W].
    """

    tangential: Array
    radial: Array
    axial: Array
    power: Array

    @property
    def title(self) -> str:
        largest = (np.abs(each).max(initial=0.0) for each in (self.tangential, self.radial, self.axial))
        return "ToothForces up to {:.6g} N tangential, {:.6g} N radial, {:.6g} N axial".format(*largest)

    def columns(self) -> dict[str, Array]:
        """The forces and the power as columns under their names with units."""
        forces = {"tangential [N]": self.tangential, "radial [N]": self.radial, "axial [N]": self.axial}
        return forces | {"power_lost [W]": self.power}


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
