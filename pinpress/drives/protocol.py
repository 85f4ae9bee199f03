"""What drives a press: the protocol that all drives follow, those of `drives` and a caller's own."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from ..common.arguments import truth_value
from ..common.parameters import Checked
from ..common.parameters import parameter as parameter  # named in pinpress.drives
from ..common.quantities import Array

Values = float | Array
"""A number, or an array of them: one of each scenario on the last axis."""


@dataclass(frozen=True)
class Corner(Checked):
    """A speed at which a drive's torque is not a smooth function of its shaft's speed.

    Attributes:
        speed: of the shaft [rad/s], or (S,) for S scenarios.
        jump: whether the torque itself jumps there, and not its slope alone.
    """

    speed: Values = field(metadata=parameter("rad/s", scenarios=True))
    jump: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        truth_value("Corner: jump", self.jump)


@runtime_checkable
class Drive(Protocol):
    """What acts on a shaft with a torque that depends on its speed, and where it is ``timed`` on angle, time and states of its own too.

    Any class with these members can drive a press. Its torque is a function: the same arguments give the same torque whenever they are
    asked, of an array element by element. What it remembers (an excitation, a hysteresis) it keeps in ``state`` with its ``rates``, not in
    itself. `simulate` and `steady_state` try a caller's own drive before a run, and ask for the run's torques once more after it.

    Attributes:
        inertia: of what turns with the shaft [kg m2]; (S,) where it differs between scenarios.
        state: values at the start of the drive's own states; () for most.
        timed: whether the torque depends on angle, time or states; where it is False, on the speed alone.
        rated_torque: of the motor, at its own shaft, bearable without end [N m]; (S,) where it differs; None where it is not known.
        corners: speeds of the shaft at which the torque is not a smooth function of speed [rad/s], in no order; a `Corner` where the torque
            itself jumps; () where ``timed``.
    """

    @property
    def inertia(self) -> Values: ...
    @property
    def state(self) -> tuple[float, ...]: ...
    @property
    def timed(self) -> bool: ...
    @property
    def rated_torque(self) -> Values | None: ...
    @property
    def corners(self) -> tuple[Values | Corner, ...]: ...

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        """Torque on the shaft [N m], finite for every finite speed of either direction.

        Args:
            speed: of the shaft [rad/s], (...) or (..., S); (..., S) where a parameter is (S,). The result has its shape, or broadcasts it.
            angle: of the shaft [rad]; it broadcasts with the speed, as the following do.
            time: [s].
            state: the drive's states.
        """
        ...

    def rates(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> tuple[Values, ...]:
        """Rates of the states [1/s]."""
        ...

    def motor_speed(self, speed: Values) -> Values:
        """Speed of the motor's own shaft [rad/s]."""
        ...

    def motor_torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        """Torque of the motor at its own shaft [N m], that which accelerates its rotor included."""
        ...


class SpeedTorqueDrive(Checked):
    """Base of most drives: torque by speed alone and smooth, no states, a shaft that is the motor's own.

    A dataclass made from it has its declared parameters checked (see `parameter`), and must give ``torque``, ``inertia`` and
    ``rated_torque``; what differs from the above it overrides.
    """

    @property
    def state(self) -> tuple[float, ...]:
        return ()

    @property
    def timed(self) -> bool:
        return False

    @property
    def corners(self) -> tuple[Values | Corner, ...]:
        return ()

    @property
    def reversals(self) -> tuple[float, ...]:
        """Speeds at which the torque changes its sign, where a `Geared` with losses has corners [rad/s]; () where none is known."""
        return ()

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        raise NotImplementedError

    def rates(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> tuple[Values, ...]:
        return ()

    def motor_speed(self, speed: Values) -> Values:
        return speed

    def motor_torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        return self.torque(speed, angle, time, state)


def corners_of(drive: Drive) -> tuple[tuple[Values, bool], ...]:
    """The speeds of the corners of a drive's torque [rad/s], and whether it jumps there: at a plain speed it does not."""
    return tuple((corner.speed, corner.jump) if isinstance(corner, Corner) else (corner, False) for corner in drive.corners)


def limited(lowest: float, value: Values, highest: float) -> Values:
    """Value limited to a range. Python's own min and max take a tenth of the time of NumPy's on one number."""
    if isinstance(value, float):
        return min(max(value, lowest), highest)
    return np.minimum(np.maximum(value, lowest), highest)
