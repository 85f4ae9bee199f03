"""Springs and dampers in joints."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..common.parameters import Checked, parameter
from ..common.quantities import Array


@dataclass(frozen=True)
class JointSpring(Checked):
    """A spring and a damper in a joint: ``<joint_spring>`` of a URDF.

    The effort on the joint along its axis is -stiffness x (coordinate - reference) - damping x rate [N m; of a joint that slides N].

    Attributes:
        joint: name of the joint.
        stiffness: [N m/rad; of a joint that slides N/m].
        reference: coordinate of the joint at which the spring is slack [rad or m].
        damping: [N m s/rad; of a joint that slides N s/m].

    Raises:
        PinpressError: stiffness or damping is negative, or a number is not finite.
    """

    joint: str
    stiffness: float = field(default=0.0, metadata=parameter("N m/rad", "not negative"))
    reference: float = field(default=0.0, metadata=parameter("rad"))
    damping: float = field(default=0.0, metadata=parameter("N m s/rad", "not negative"))


def spring_efforts(springs: Iterable[JointSpring], joints: Sequence[str], x: Array, v: Array) -> Array:
    """Efforts (nv, ...) of springs on the joints with these names, at joint coordinates and rates (nv, ...)."""
    efforts = np.zeros_like(x)
    for spring in springs:
        joint = joints.index(spring.joint)
        efforts[joint] -= spring.stiffness * (x[joint] - spring.reference) + spring.damping * v[joint]
    return efforts
