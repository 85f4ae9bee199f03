"""The protocol of drives, both those of `drives` and a caller's own."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from ..common.arguments import truth_value
from ..common.parameters import Checked
from ..common.parameters import parameter as parameter  # named in pinpress.drives
from ..common.quantities import Values


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
    """A torque on a shaft that depends on the shaft's speed, and if it is ``timed`` on angle, time and its own states too.

    Any class with these members can drive a press. Its torque is a function: the same arguments always give the same torque, and arrays
    give it element by element. Memory, as of an excitation or a hysteresis, belongs in ``state`` with its ``rates``, not in other
    attributes. `simulate` and `steady_state` try a caller's own drive before a run, and ask for the run's torques again after it.

    A drive that also has ``power``, a method with the arguments of ``torque`` that returns a `MotorPower`, tells what it takes from the
    mains (`pinpress.measures.motor_energy`). With the numbers ``thermal_time`` [s] and ``thermal_resistance`` [K/W] it tells how warm it
    becomes too.

    On a driver that slides the torque is a force [N], the speed in m/s, the angle a position [m] and the inertia a mass [kg].

    Attributes:
        inertia: of all that turns with the shaft [kg m2]; (S,) where it differs between scenarios.
        state: values of the drive's own states at the start; () for most drives.
        timed: whether the torque depends on angle, time or states; if not, it depends on the speed alone.
        rated_torque: permanent torque of the motor at its own shaft [N m]; (S,) where it differs; None if it is not known.
        corners: speeds of the shaft at which the torque is not a smooth function of speed [rad/s], in any order; a `Corner` where the
            torque itself jumps; if ``timed`` at most standstill, where losses of gears jump.
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
        """Torque on the shaft [N m], finite for every finite speed in both directions.

        Args:
            speed: of the shaft [rad/s], (...); (..., S) where a parameter is (S,). The result has its shape, or one that broadcasts to it.
            angle: of the shaft [rad]. It broadcasts with the speed, as time and states do.
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
        """Torque of the motor at its own shaft [N m], including the torque that accelerates its rotor."""
        ...


class SpeedTorqueDrive(Checked):
    """Base of most drives: the torque is a smooth function of speed alone, there are no states, and the shaft is the motor's own.

    A dataclass made from it has its declared parameters checked (see `parameter`). It must define ``torque``, ``inertia`` and
    ``rated_torque``, and overrides what differs from the above.
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
    def heeds_speed(self) -> bool:
        """Whether the torque depends on the speed; a swing of the crank under forces that do not is computed once and repeated."""
        return True

    @property
    def reversals(self) -> tuple[float, ...]:
        """Speeds at which the torque changes its sign [rad/s], because a `Geared` with losses has corners there; () where none is known."""
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
    """The speeds of the corners of a drive's torque [rad/s], and whether the torque jumps there, which it does not at a plain speed."""
    return tuple((corner.speed, corner.jump) if isinstance(corner, Corner) else (corner, False) for corner in drive.corners)


def limit(lowest: float, value: Values, highest: float) -> Values:
    """A value limited to a range. For one number Python's own min and max take a tenth of the time of NumPy's."""
    if isinstance(value, float):
        return min(max(value, lowest), highest)
    return np.minimum(np.maximum(value, lowest), highest)
