"""A motion and its driving torques against the limits that the file gives to its joints: ``<limit lower upper effort velocity>``."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..common.arguments import typed
from ..common.quantities import Array
from ..common.results import Record, Records
from ..engines.mounting import limits
from .reactions import Reactions

UNLIMITED = 1e9  # limits as large are written where there is none


@dataclass(frozen=True, repr=False)
class LimitUse(Record, units={"time": "s"}):
    """How near a motion comes to one limit of a joint, and by how much it exceeds it.

    Attributes:
        joint: name of the joint.
        quantity: "position", "speed", "torque" or "force".
        unit: of limit, value and excess.
        limit: the limit; of a position the end that the joint comes nearest to, or exceeds by most.
        value: the value nearest to it, or beyond it, with its sign.
        excess: by how much the value is beyond the limit; negative: what is left.
        state: index of the state.
        time: of this state [s]; None if the states have no time.
    """

    joint: str
    quantity: str
    unit: str
    limit: float
    value: float
    excess: float
    state: int
    time: float | None


@typed
def joint_limits(reactions: Reactions) -> Records[LimitUse]:
    """Compare a motion and its driving torques with all limits of the joints in the file, in the states that are `Motion.valid`.

    Positions and speeds are those of all joints, efforts those of the motors. An effort or speed of zero, and one of 1e9 or more, counts as
    not given, because files of joints without limits have such numbers. Those that are exceeded are
    ``[use for use in joint_limits(reactions) if use.excess > 0]``.

    Args:
        reactions: of the motion.

    Returns:
        A record for each limit; that which is exceeded by the largest share first.
    """
    return Records(LimitUse, sorted(_uses(reactions), key=lambda use: -use.excess / (abs(use.limit) or 1.0)))


def _uses(reactions: Reactions) -> Iterator[LimitUse]:
    press, motion = reactions._press, reactions.motion
    states = np.flatnonzero(motion.valid)
    if not len(states):
        return

    def use(joint: int, quantity: str, unit: str, limit: Array, values: Array, excess: Array) -> LimitUse:
        worst = int(excess.argmax())
        time = None if motion._time is None else float(motion._time[states[worst]])
        at = float(np.broadcast_to(limit, excess.shape)[worst])
        return LimitUse(press.joints[joint], quantity, unit, at, float(values[worst]), float(excess[worst]), int(states[worst]), time)

    model, (lower, upper) = press.model, limits(press.structure)
    for joint, axis in enumerate(press.axes):
        unit, most = "rad" if axis.turns else "m", float(model.upperVelocityLimit[joint])
        place, rate = motion.joint_position[states, joint], motion.v[states, joint]
        if np.isfinite([lower[joint], upper[joint]]).any():
            below, above = lower[joint] - place, place - upper[joint]
            yield use(joint, "position", unit, np.where(below > above, lower[joint], upper[joint]), place, np.maximum(below, above))
        if 0.0 < most < UNLIMITED:
            yield use(joint, "speed", f"{unit}/s", np.array(most), rate, np.abs(rate) - most)
    efforts = np.reshape(reactions.driving_torque, (len(motion.v), -1))[states].T
    for joint, effort in zip(press.driver_indices[: len(press.motors)], efforts, strict=False):
        most, turns = float(model.upperEffortLimit[joint]), press.axes[joint].turns
        if 0.0 < most < UNLIMITED:
            quantity, unit = ("torque", "N m") if turns else ("force", "N")
            yield use(joint, quantity, unit, np.array(most), effort, np.abs(effort) - most)
