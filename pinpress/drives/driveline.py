"""What stands between drive and crank: the flywheel, a clutch and a brake, and in which mode these are.

Flywheel and drive stand before the clutch, the brake behind it, on the crank; all is reduced to the driver joint. While it slips, a clutch
or brake transmits its friction torque, rising over its time of engagement; once its sides turn alike it holds, as long as it does not have
to hold more than that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from ..common.checks import is_number
from ..common.errors import PinpressError, shown
from .transmission import Drive, Flywheel

OPEN, SLIPPING, HOLDING = "open", "slipping", "holding"


@dataclass(frozen=True)
class At:
    """When a clutch or brake is switched: at a ``time`` [s], or where the crank passes an ``angle`` (unwrapped, either way) [rad]."""

    time: float | None = None
    angle: float | None = None

    def __post_init__(self) -> None:
        given = [value for value in (self.time, self.angle) if value is not None]
        if len(given) != 1 or not is_number(given[0]):
            raise PinpressError(
                f"At: time is {shown(self.time)} and angle {shown(self.angle)}; give one of them, a finite number [s] or [rad]"
            )


@dataclass(frozen=True)
class Clutch:
    """A friction clutch between the flywheel, with the drive, and the crank.

    Attributes:
        torque: that it transmits while it slips, at the driver joint [N m]. rise: time in which it builds up to that [s].
        closes: when it closes; None: closed, and holding, from the start. opens: when it opens for good; None: never.
    """

    torque: float
    closes: At | None = None
    opens: At | None = None
    rise: float = 0.0

    def __post_init__(self) -> None:
        _check(self)


@dataclass(frozen=True)
class Brake:
    """A friction brake on the crank.

    Attributes:
        torque: that it brakes with while it slips, at the driver joint [N m]. rise: time in which it builds up to that [s].
        closes: when it closes; None: closed from the start. opens: when it opens for good; None: never.
    """

    torque: float
    closes: At | None = None
    opens: At | None = None
    rise: float = 0.0

    def __post_init__(self) -> None:
        _check(self)


def _check(friction: Clutch | Brake) -> None:
    name = type(friction).__name__
    for field, least in (("torque", "positive"), ("rise", "not negative")):
        value = getattr(friction, field)
        if not is_number(value) or value < 0 or (value == 0 and least == "positive"):
            raise PinpressError(f"{name}: {field} is {shown(value)}; give a number that is {least} [{'N m' if field == 'torque' else 's'}]")
    for field in ("closes", "opens"):
        if not isinstance(getattr(friction, field), At | None):
            raise PinpressError(f"{name}: {field} is {shown(getattr(friction, field))}; give At(time=...) or At(angle=...)")


class Grip(NamedTuple):
    """State of a clutch or brake.

    Attributes:
        state: `OPEN`, `SLIPPING` or `HOLDING`. sign: of the torque while it slips. since: when it closed [s].
        spent: opened for good. way: +1 or -1, in which the crank has to pass the angle that switches it.
    """

    state: str
    sign: int = 0
    since: float = -math.inf
    spent: bool = False
    way: int = 1

    def capacity(self, friction: Clutch | Brake, time: float) -> float:
        """Torque that it can transmit [N m]."""
        return friction.torque * min(1.0, max(0.0, (time - self.since) / friction.rise)) if friction.rise else friction.torque


class Mode(NamedTuple):
    """Mode of a driveline."""

    clutch: Grip
    brake: Grip


@dataclass(frozen=True, eq=False)
class Driveline:
    """Drive, flywheel, clutch and brake of one press; each may be missing.

    Attributes:
        inertia: of flywheel and drive, at the driver joint [kg m2].
    """

    drive: Drive | None
    flywheel: Flywheel | None
    clutch: Clutch | None
    brake: Brake | None
    inertia: float

    def begin(self, angle: float, speed: float) -> tuple[Mode, tuple[float, ...]]:
        """Mode and states at the start: the drive's own, and of a clutch's driving side the speed."""
        states = () if self.drive is None else tuple(self.drive.state)
        own = speed
        if self.clutch is not None:
            if self.flywheel is not None and self.flywheel.speed is not None:
                own = self.flywheel.speed
            states = (*states, own)
        clutch, brake = _grip(self.clutch, angle, speed, own - speed, HOLDING), _grip(self.brake, angle, speed, speed, OPEN)
        return Mode(clutch, brake), states

    def drive_torque(self, speed: float, angle: float, time: float, states: tuple[float, ...]) -> Any:
        """Torque of the drive at the driver joint, at its own side's speed [N m]."""
        return 0.0 if self.drive is None else self.drive.torque(speed, angle, time, states)


def _grip(friction: Clutch | Brake | None, angle: float, speed: float, relative: float, missing: str) -> Grip:
    """State at the start, at a relative speed of the two sides; one that is ``missing`` is as if it did that for good."""
    if friction is None:
        return Grip(missing)
    at = friction.closes or friction.opens
    way = 1 if at is None or at.angle is None or at.angle > angle or (at.angle == angle and speed >= 0) else -1
    if friction.closes is not None:
        return Grip(OPEN, way=way)
    return Grip(SLIPPING, 1 if relative > 0 else -1, way=way) if relative else Grip(HOLDING, way=way)
