"""What acts in the joints themselves: springs, dampers, and rotors of motors that turn with them."""

from __future__ import annotations

from ..common.quantities import Array
from ..engines.engine import ClosedStates
from ..linkage.joint_springs import spring_efforts
from ..linkage.linkage import Linkage


def joint_efforts(press: Linkage, states: ClosedStates) -> Array | None:
    """Efforts (nv, n) that springs and dampers in the joints supply, less those that accelerate rotors (`Linkage.model`'s armature), along
    the joints' axes [N m, N]; None where a linkage has neither.

    The bearing of a joint passes on what the carried links need. A rotor is between the drive and the bearing.
    """
    armature = press.model.armature
    if not (press.joint_springs or armature.any()):
        return None
    return spring_efforts(press.joint_springs, press.joints, states.position, states.v) - armature[:, None] * states.a
