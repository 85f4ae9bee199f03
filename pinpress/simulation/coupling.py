"""Clutch and brake: couplings that are open, slip or hold, and how they switch.

A coupling is switched at a time or at a crank angle: it closes once, and opens for good once. While it slips, its torque follows from its
capacity and from the sign of the relative speed. A brake is a coupling to the frame, whose speed is zero. Rigid and elastic runs use these
rules; times, torques and speeds may be arrays.
"""

import math
from enum import Enum
from typing import Any, Literal, NamedTuple

import numpy as np

from ..drives.transmission import Coupling, SwitchPoint

Side = Literal["clutch", "brake"]
"""Which coupling: a field of a mode and of a `DrivenPress`."""


class Grip(Enum):
    """The state of a clutch or brake."""

    OPEN = "open"
    SLIPPING = "slipping"
    HOLDING = "holding"


OPEN, SLIPPING, HOLDING = Grip


class CouplingMode(NamedTuple):
    """Mode of a clutch or brake."""

    grip: Grip  # whether it is open, slips or holds
    sign: int = 0  # of its torque on the crank while it slips
    since: float = -math.inf  # time at which it closed [s]
    spent: bool = False  # whether it has opened for good
    way: int = 1  # +1 or -1, direction in which the crank has to pass the angle that switches it

    def capacity(self, coupling: Coupling, time: Any) -> Any:
        """Torque that it can transmit at a time or at times [N m]."""
        return coupling.torque * np.minimum(1.0, np.maximum(0.0, (time - self.since) / coupling.rise)) if coupling.rise else coupling.torque

    def next_switch(self, coupling: Coupling | None) -> SwitchPoint | None:
        """What switches it next."""
        if coupling is None or self.spent:
            return None
        return coupling.closes if self.grip is OPEN else coupling.opens

    def switched(self, relative: float, time: float, way: int = 1) -> "CouplingMode":
        """The mode after it has been switched.

        Args:
            relative: speed of its other side less that of the crank [rad/s].
            time: at which it is switched [s].
            way: of the mode that follows.
        """
        if self.grip is not OPEN:
            return CouplingMode(OPEN, spent=True)
        return CouplingMode(SLIPPING if relative else HOLDING, sign_of(relative), time, way=way)

    def slipping(self, torque: float) -> "CouplingMode":
        """The mode after it has let go, where it would have to transmit a torque."""
        return self._replace(grip=SLIPPING, sign=sign_of(torque))


def coupling_at_start(coupling: Coupling | None, angle: float, speed: float, relative: float, missing: Grip) -> CouplingMode:
    """Mode of a coupling at the start.

    Args:
        coupling: the coupling; None if the press has none.
        angle: of the crank [rad].
        speed: of the crank [rad/s].
        relative: speed of the coupling's other side less that of the crank [rad/s].
        missing: grip of a coupling that the press does not have.
    """
    if coupling is None:
        return CouplingMode(missing)
    switch = coupling.closes or coupling.opens
    way = 1 if switch is None or switch.angle is None or switch.angle > angle or (switch.angle == angle and speed >= 0) else -1
    if coupling.closes is not None:
        return CouplingMode(OPEN, way=way)
    return CouplingMode(SLIPPING if relative else HOLDING, sign_of(relative) if relative else 0, way=way)


def sign_of(value: float) -> int:
    """+1 or -1; -1 of zero."""
    return 1 if value > 0 else -1
