"""Drives of a press: what torque a motor gives on its shaft at a speed, and what turns with it.

Torques and speeds are positive along the shaft on which the drive acts: the driver joint, or the faster shaft of a `Geared`. A motor turns
its shaft in the positive direction; ``Geared(motor, -1.0)`` turns it round. Several scenarios at once have their parameters in arrays (S,),
where a class allows it, and their speeds on the last axis of an array. Wrong parameters raise a `PinpressError` that names class and field.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..common.errors import PinpressError, shown
from ..common.scenario_numbers import check
from .induction import InductionMotor, InverterMotor
from .protocol import Drive, SpeedTorqueDrive, Values
from .servo import ServoMotor
from .slip_clutch import SlipClutchMotor

__all__ = [
    "ConstantTorque",
    "Drive",
    "Flywheel",
    "Geared",
    "InductionMotor",
    "InverterMotor",
    "PrescribedSpeed",
    "ServoMotor",
    "SlipClutchMotor",
]


@dataclass(frozen=True)
class Flywheel:
    """A flywheel on the driver joint's shaft, or with whatever else turns with it, reduced to that shaft. No drive by itself.

    Attributes:
        inertia: [kg m2], or (S,). A negative one takes away what the URDF has too much; the sum must stay positive.
        speed: of the flywheel at the start, where an open clutch lets it differ from the crank's [rad/s]; None: that of the crank.
    """

    per_scenario: ClassVar[Mapping[str, int]] = {"inertia": 0}

    inertia: Values
    speed: float | None = None

    def __post_init__(self) -> None:
        check(self, "inertia", "finite", "kg m2", scenarios=True)
        if self.speed is not None:
            check(self, "speed", "finite", "rad/s")


@dataclass(frozen=True)
class PrescribedSpeed:
    """A drive so strong that it holds the driver joint at a constant speed, whatever torque that takes. It has no torque curve.

    Attributes:
        speed: [rad/s]; negative: backwards; not zero.
    """

    speed: float

    def __post_init__(self) -> None:
        check(self, "speed", "other than zero", "rad/s")


@dataclass(frozen=True)
class ConstantTorque(SpeedTorqueDrive):
    """The same torque at every speed: the M_d of Zhang 2007, section 4.2. It has no inertia: give a `Flywheel`.

    Attributes:
        value: [N m], or (S,); negative: backwards. (``torque`` is the method that all drives have.)
    """

    per_scenario: ClassVar[Mapping[str, int]] = {"value": 0}

    value: Values

    def __post_init__(self) -> None:
        check(self, "value", "finite", "N m", scenarios=True)

    @property
    def inertia(self) -> Values:
        return 0.0

    @property
    def rated_torque(self) -> Values | None:
        return None

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        return self.value + 0.0 * speed  # in the shape of the speed


@dataclass(frozen=True)
class Geared:
    """A drive through gears or a belt: its shaft turns ``ratio`` times as fast as that on which it acts.

    Where the drive gives power (or starts), the torque is ratio x its torque x efficiency, where it takes power, ratio x torque /
    efficiency. The losses are those of its torque alone; what accelerates the drive's own inertia passes the gears without loss.

    Attributes:
        drive: any `Drive`, also another Geared. ratio: speed of its shaft by that of the slower one; negative: it turns the other way.
        gear_inertia: of the gears, at the slower shaft [kg m2], or (S,). (``inertia`` is the total there.)
        efficiency: above 0, at most 1.
    """

    per_scenario: ClassVar[Mapping[str, int]] = {"gear_inertia": 0}

    drive: Drive
    ratio: float
    gear_inertia: Values = 0.0
    efficiency: float = 1.0

    def __post_init__(self) -> None:
        if isinstance(self.drive, type) or not isinstance(self.drive, Drive):
            raise PinpressError(f"Geared: drive is {shown(self.drive)}; give one with a torque, e.g. an InductionMotor or ConstantTorque")
        check(self, "ratio", "other than zero", "-")
        check(self, "gear_inertia", "not negative", "kg m2", scenarios=True)
        check(self, "efficiency", "positive", "-")
        if self.efficiency > 1:
            raise PinpressError(f"Geared: efficiency is {shown(self.efficiency)}; give a share of at most 1")
        if np.ndim(self.gear_inertia) and np.ndim(self.drive.inertia) and np.shape(self.gear_inertia) != np.shape(self.drive.inertia):
            raise PinpressError(
                f"Geared: gear_inertia has shape {np.shape(self.gear_inertia)}, the drive's inertia {np.shape(self.drive.inertia)};"
                " give one of each scenario in both"
            )

    @cached_property
    def inertia(self) -> Values:
        return self.ratio * self.ratio * self.drive.inertia + self.gear_inertia

    @property
    def state(self) -> tuple[float, ...]:
        return self.drive.state

    @property
    def timed(self) -> bool:
        return self.drive.timed

    @property
    def rated_torque(self) -> Values | None:
        return self.drive.rated_torque

    @property
    def corners(self) -> tuple[Values, ...]:
        """The drive's; with losses also those at which its power changes sign: standstill, where its torque jumps, and the synchronous
        speed of the induction motors here. (Where another drive's torque changes sign is not known here: let its own corners hold it.)"""
        if self.timed:
            return ()
        lossy = (0.0, *(speed / self.ratio for speed in _without_torque(self.drive))) if self.efficiency < 1 else ()
        return (*(corner / self.ratio for corner in self.drive.corners), *lossy)

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        fast = self.ratio * speed
        torque = self.drive.torque(fast, self.ratio * angle, time, state)
        if self.efficiency == 1.0:
            return self.ratio * torque
        return self.ratio * torque * self._passed(torque * fast)

    def rates(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> tuple[Values, ...]:
        return self.drive.rates(self.ratio * speed, self.ratio * angle, time, state)

    def motor_speed(self, speed: Values) -> Values:
        return self.drive.motor_speed(self.ratio * speed)

    def motor_torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        return self.drive.motor_torque(self.ratio * speed, self.ratio * angle, time, state)

    def _passed(self, power: Values) -> Values:
        """Torque behind the gears by that before them. At standstill the drive starts."""
        if isinstance(power, float):
            return self.efficiency if power >= 0.0 else 1.0 / self.efficiency
        return np.where(power >= 0.0, self.efficiency, 1.0 / self.efficiency)


def _without_torque(drive: Drive) -> tuple[float, ...]:
    """Speeds at which a drive's torque changes sign, where they are known."""
    if isinstance(drive, InductionMotor | InverterMotor):
        return (drive.synchronous_speed,)
    return tuple(speed / drive.ratio for speed in _without_torque(drive.drive)) if isinstance(drive, Geared) else ()
