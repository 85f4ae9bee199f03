"""What is rounding among the forces and moments of a motion, and what bearings hold without it.

Signs and axes as in `inverse_dynamics`. All raise `PinpressError` for values that are not finite.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..common.arrays import Array
from ..common.errors import PinpressError, expect
from ..kinematics.poses import poses
from .inverse_dynamics import Reactions

AXES = ("x", "y", "z")
ROUNDING = 1e-9  # of the largest force, and of a constant crank speed


class Rounding(NamedTuple):
    """Sizes below which a component is rounding.

    Attributes:
        force: Of forces [N].
        moment: Of moments and torques [N m].
    """

    force: float
    moment: float


def rounding(reactions: Reactions) -> Rounding:
    """What is rounding beside the largest bearing force, and beside the largest of driving torque and that force times the linkage's size.

    Raises:
        PinpressError: Bearings were left out of the reactions, or a force is not finite.
    """
    expect("reactions", reactions, Reactions, "inverse_dynamics")
    largest = max((float(np.abs(force).max(initial=0.0)) for force in finite_forces(reactions).values()), default=0.0)
    torque = float(np.abs(finite("driving torque", reactions.driving_torque)).max(initial=0.0))
    return Rounding(ROUNDING * largest, ROUNDING * max(torque, largest * reactions._press.size))


def finite_forces(reactions: Reactions) -> dict[str, Array]:
    """Bearing forces (n, 3) [N] by the bearings' names.

    Raises:
        PinpressError: Bearings were left out, the largest force being what tells rounding, or a force is not finite.
    """
    if reactions.left_out:
        raise PinpressError(
            f"charts need all bearings, and {', '.join(reactions.left_out)} were left out: make the reactions without bearings=..."
        )
    return {name: finite(f"force in {name}", force) for name, force in reactions.bearing_force.items()}


def finite(quantity: str, values: Array) -> Array:
    """The values (n, ...) themselves.

    Raises:
        PinpressError: There is no value, or one is not finite.
    """
    if not len(values):
        raise PinpressError(f"{quantity} has no states: give a motion of at least one")
    if not np.isfinite(values).all():
        at = int(np.argwhere(~np.isfinite(values))[0][0])
        raise PinpressError(f"{quantity} is not finite at index {at}: give what cycle, simulate and inverse_dynamics return")
    return values


def torque_without_rounding(reactions: Reactions) -> Array:
    """Driving torque (n,) or (n, drivers) [N m], zero where it is rounding throughout."""
    torque = finite("driving torque", reactions.driving_torque)
    return np.where(np.abs(torque).max(axis=0) > rounding(reactions).force * reactions._press.size, torque, 0.0)


def is_constant(speed: Array) -> bool:
    """Whether speeds (n,) or (n, drivers) differ by rounding alone."""
    return bool(np.all(np.ptp(speed, axis=0) <= ROUNDING * np.abs(speed).max(axis=0)))


def held_moments(reactions: Reactions) -> dict[str, Array]:
    """Moments (n, 3) [N m] that hold links against turning, by bearing.

    About a turning joint's own axis there is but the torque of drive, gear pair and friction, which is left out; a spherical loop holds
    no moment.
    """
    press, moments = reactions._press, {}
    rotation = poses(press, reactions.motion.joint_position).rotation
    joints = enumerate(zip(press.joints, press.axes, strict=True), 1)
    turning = {name: (body, axis.direction) for body, (name, axis) in joints if axis.turns}
    turning |= {loop.name: (loop.joint1, loop.rotation1[:, 0]) for loop in press.loops if loop.type == "revolute"}
    spherical = {loop.name for loop in press.loops if loop.type == "spherical"}
    for name, moment in reactions.bearing_moment.items():
        held = finite(f"moment in {name}", moment)
        if name in turning:
            body, direction = turning[name]
            axis = rotation[body] @ direction
            held = held - np.sum(held * axis, axis=1, keepdims=True) * axis
        moments[name] = np.zeros_like(held) if name in spherical else held
    return moments
