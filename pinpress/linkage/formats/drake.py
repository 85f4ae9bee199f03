"""Drake's bearings between two bodies, which URDF and SDF have in the same words: in attributes in the one, as texts in the other.

Source: multibody/parsing/parsing_doxygen.h of Drake, "Drake Extensions".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ...common.quantities import Array
from ..urdf.document import Element, Origin
from ..urdf.findings import Finding
from .elements import needed, numbers, refuse, remark

BALL, BUSHING, SPRING = "drake:ball_constraint", "drake:linear_bushing_rpy", "drake:linear_spring_damper"
Said = Callable[[Element], str]
"""What an element says: a name, or numbers."""


def ball_ends(file: str, element: Element, said: Said) -> list[tuple[Element, Array]]:
    """The elements that name bodies A and B of a ball constraint, each with its point: P in A coincides with Q in B [m]."""
    values = [needed(file, element, f"{BALL}_{name}") for name in ("body_A", "p_AP", "body_B", "p_BQ")]
    return [(body, numbers(file, point, said(point), 3)) for body, point in (values[:2], values[2:])]


def bushing_ends(file: str, element: Element) -> list[Element]:
    """The elements that name frames A and C of a bushing."""
    return [needed(file, element, f"drake:bushing_frame{side}") for side in ("A", "C")]


def bushing_axis(file: str, element: Element, said: Said) -> Array | None:
    """(3,) the axis of the pin that a bushing stands for, in its frames; None of a ball joint. Bushings elastic in other ways are refused.

    Torques are about x, y, z (roll, pitch, yaw), forces along them. A pin holds all three directions and two or none of the rotations; what
    holds nothing has neither stiffness nor damping.
    """
    values: Mapping[tuple[str, str], Array] = {
        (kind, word): numbers(file, found, said(found), 3)
        for kind in ("torque", "force")
        for word in ("stiffness", "damping")
        for found in (needed(file, element, f"drake:bushing_{kind}_{word}"),)
    }
    torque, force = values["torque", "stiffness"], values["force", "stiffness"]
    held = [axis for axis in range(3) if torque[axis] or values["torque", "damping"][axis]]
    if force.min() > 0 and not held:
        return None
    if force.min() > 0 and len(held) == 2 and torque[held].min() > 0:
        return np.asarray(np.eye(3)[next(axis for axis in range(3) if axis not in held)])
    problem = "a bushing is elastic, and this one is neither a pin (held but for the turn about one axis) nor a ball joint (no torques)"
    remedy = "write a <loop_joint> for a rigid bearing; for elastic ones give pp.elasticity.Stiffness"
    refuse(file, element, problem, remedy)


def bushing_remark(origin: Origin) -> Finding:
    """What is lost of a bushing."""
    problem = "it is read as a rigid bearing: its stiffness and damping are not"
    return remark("warning", origin, problem, "write a ball constraint or <loop_joint>, if that is meant")


def spring_remark(element: Element) -> Finding:
    """A spring between bodies."""
    return remark("warning", element, "a spring between bodies is not read", "give it as a load: loads=[SpringDamper(...)]")
