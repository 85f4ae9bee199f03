"""The parts between motor and crank: flywheel, gears, clutch and brake; and a drive that holds its speed.

Torques and speeds are positive along the shaft on which the drive acts: the driver joint, or the faster shaft of a `Geared`. Several
scenarios at once have their parameters in arrays (S,), where a class allows it, and their speeds on the last axis of an array. Wrong
parameters raise a `PinpressError` that names class and field.

Flywheel and drive stand on the motor's side of the clutch, the brake on the crank; all is reduced to the driver joint. A clutch or brake
that slips transmits its friction torque, which rises over its time of engagement. Once both sides turn at the same speed it holds, as long
as that takes no more than the friction torque.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..common import plausibility
from ..common.arguments import is_number
from ..common.errors import PinpressError, shown
from ..common.parameters import Checked, in_declared_units, parameter
from ..common.quantities import Values
from .protocol import Corner, Drive, corners_of


@dataclass(frozen=True)
class Flywheel(Checked):
    """A flywheel on the driver joint's shaft, with all else that turns with it, reduced to that shaft. It is no drive by itself.

    Attributes:
        inertia: [kg m2], or (S,) for S scenarios. A negative inertia removes what the URDF has too much; the sum must stay positive.
        speed: of the flywheel at the start, which an open clutch lets differ from that of the crank [rad/s]; None: that of the crank.
    """

    inertia: Values = field(metadata=parameter("kg m2", scenarios=True))
    speed: float | None = field(default=None, metadata=parameter("rad/s"))


@dataclass(frozen=True)
class PrescribedSpeed(Checked):
    """A drive so strong that it holds the driver joint at a constant speed, whatever torque that takes. It has no torque curve.

    Attributes:
        speed: [rad/s], of a driver that slides [m/s]; negative: backwards; not zero.
    """

    speed: float = field(metadata=parameter("rad/s", "other than zero"))


@dataclass(frozen=True)
class Geared(Checked):
    """A drive through gears or a belt: its shaft turns ``ratio`` times as fast as the shaft on which the gears act. A screw that moves a
    driver that slides has 2 pi / lead as its ratio, with the lead in m a turn.

    Where the drive delivers power (or starts), the torque is ratio x its torque x efficiency; where it takes power, ratio x torque /
    efficiency. Only the drive's torque has losses; the torque that accelerates the drive's own inertia passes the gears without loss.

    Attributes:
        drive: any `Drive`, even another Geared.
        ratio: speed of its shaft by that of the slower one; negative: it turns in the opposite direction.
        gear_inertia: of the gears, at the slower shaft [kg m2], or (S,) for S scenarios. (``inertia`` is the total there.)
        efficiency: above 0, at most 1.
    """

    drive: Drive
    ratio: float = field(metadata=parameter("-", "other than zero"))
    gear_inertia: Values = field(default=0.0, metadata=parameter("kg m2", "not negative", scenarios=True))
    efficiency: float = field(default=1.0, metadata=parameter("-", "positive"))

    def __post_init__(self) -> None:
        if isinstance(self.drive, type) or not isinstance(self.drive, Drive):
            raise PinpressError(f"Geared: drive is {shown(self.drive)}; give one with a torque, e.g. an InductionMotor or ConstantTorque")
        super().__post_init__()
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
    def heeds_speed(self) -> bool:
        """Whether the torque depends on the speed, as losses do by its sign."""
        return self.efficiency < 1 or getattr(self.drive, "heeds_speed", True)

    @property
    def reversals(self) -> tuple[float, ...]:
        """Speeds at which the drive's torque changes its sign, if the drive names them [rad/s]."""
        return tuple(speed / self.ratio for speed in getattr(self.drive, "reversals", ()))

    @property
    def corners(self) -> tuple[Values | Corner, ...]:
        """The corners of the drive; with losses also the speeds at which its power changes sign: standstill, where the torque jumps, and
        the synchronous speed of an induction motor. (A drive without `reversals` should name them among its own corners.)"""
        if self.timed:  # where its power changes sign beside standstill depends on the time
            return (0.0,) if self.efficiency < 1 else ()
        lossy = (0.0, *self.reversals) if self.efficiency < 1 else ()
        slow = ((speed / self.ratio, jump) for speed, jump in corners_of(self.drive))
        return (*(Corner(speed, jump) if jump else speed for speed, jump in slow), *lossy)

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        fast = self.ratio * speed
        torque = self.drive.torque(fast, self.ratio * angle, time, state)
        if self.efficiency == 1.0:
            return self.ratio * torque
        return self.ratio * torque * self._gain(torque * fast)

    def rates(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> tuple[Values, ...]:
        return self.drive.rates(self.ratio * speed, self.ratio * angle, time, state)

    def motor_speed(self, speed: Values) -> Values:
        return self.drive.motor_speed(self.ratio * speed)

    def motor_torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        return self.drive.motor_torque(self.ratio * speed, self.ratio * angle, time, state)

    def _gain(self, power: Values) -> Values:
        """Torque behind the gears by that before them. At standstill the drive counts as delivering power."""
        if isinstance(power, float):
            return self.efficiency if power >= 0.0 else 1.0 / self.efficiency
        return np.where(power >= 0.0, self.efficiency, 1.0 / self.efficiency)


def innermost(drive: Drive) -> tuple[Drive, float]:
    """The drive behind all gears, and the speed of its shaft by that of the shaft on which the gears act."""
    ratio = 1.0
    while isinstance(drive, Geared):
        ratio *= drive.ratio
        drive = drive.drive
    return drive, ratio


@dataclass(frozen=True)
class SwitchPoint:
    """When a clutch or brake is switched: at a time, or where the crank passes an angle in either direction.

    Attributes:
        time: [s]; None: at an angle.
        angle: unwrapped [rad]; None: at a time.
    """

    time: float | None = field(default=None, metadata=parameter("s"))
    angle: float | None = field(default=None, metadata=parameter("rad"))

    def __post_init__(self) -> None:
        in_declared_units(self)
        points = [value for value in (self.time, self.angle) if value is not None]
        if len(points) != 1 or not is_number(points[0]):
            raise PinpressError(
                f"SwitchPoint: time is {shown(self.time)} and angle {shown(self.angle)}; give one of them, a finite number [s] or [rad]"
            )


@dataclass(frozen=True)
class Coupling(Checked):
    """Base of clutch and brake.

    Attributes:
        torque: that it transmits while it slips, at the driver joint [N m].
        closes: when it closes; None: it is closed from the start, and holds if both sides have the same speed.
        opens: when it opens for good; None: never.
        rise: time in which its torque builds up [s].
    """

    torque: float = field(metadata=parameter("N m", "positive"))
    closes: SwitchPoint | None = None
    opens: SwitchPoint | None = None
    rise: float = field(default=0.0, metadata=parameter("s", "not negative"))

    def __post_init__(self) -> None:
        super().__post_init__()
        plausibility.engagement(f"{type(self).__name__}: rise", self.rise)
        for name, point in (("closes", self.closes), ("opens", self.opens)):
            if not isinstance(point, SwitchPoint | None):
                raise PinpressError(
                    f"{type(self).__name__}: {name} is {shown(point)}; give SwitchPoint(time=...) or SwitchPoint(angle=...)"
                )


@dataclass(frozen=True)
class Clutch(Coupling):
    """A friction clutch between the flywheel, with the drive, and the crank.

    Attributes:
        torque: that it transmits while it slips, at the driver joint [N m].
        closes: when it closes; None: it is closed from the start, and holds if flywheel and crank have the same speed.
        opens: when it opens for good; None: never.
        rise: time in which its torque builds up [s].
    """


@dataclass(frozen=True)
class Brake(Coupling):
    """A friction brake on the crank: a coupling to the frame.

    Attributes:
        torque: that it brakes with while it slips, at the driver joint [N m].
        closes: when it closes; None: it is closed from the start.
        opens: when it opens for good; None: never.
        rise: time in which its torque builds up [s].
    """
