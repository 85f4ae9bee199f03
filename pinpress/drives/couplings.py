"""What stands between drive and crank: a clutch and a brake.

Flywheel and drive stand before the clutch, the brake behind it, on the crank; all is reduced to the driver joint. While it slips, a clutch
or brake transmits its friction torque, rising over its time of engagement; once its sides turn alike it holds, as long as it does not have
to hold more than that.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ..common.checks import is_number
from ..common.errors import PinpressError, shown
from ..common.parameters import Checked, parameter


@dataclass(frozen=True)
class SwitchPoint:
    """When a clutch or brake is switched: at a time, or where the crank passes an angle either way.

    Attributes:
        time: [s]; None: at an angle.
        angle: unwrapped [rad]; None: at a time.
    """

    time: float | None = None
    angle: float | None = None

    def __post_init__(self) -> None:
        given = [value for value in (self.time, self.angle) if value is not None]
        if len(given) != 1 or not is_number(given[0]):
            raise PinpressError(
                f"SwitchPoint: time is {shown(self.time)} and angle {shown(self.angle)}; give one of them, a finite number [s] or [rad]"
            )


@dataclass(frozen=True)
class Coupling(Checked):
    """What a clutch and a brake have in common.

    Attributes:
        torque: that it transmits while it slips, at the driver joint [N m].
        closes: when it closes; None: it is closed from the start, and holds what turns alike.
        opens: when it opens for good; None: never.
        rise: time in which its torque builds up [s].
    """

    torque: float = field(metadata=parameter("N m", "positive"))
    closes: SwitchPoint | None = None
    opens: SwitchPoint | None = None
    rise: float = field(default=0.0, metadata=parameter("s", "not negative"))

    def __post_init__(self) -> None:
        super().__post_init__()
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
        closes: when it closes; None: it is closed from the start, and holds where flywheel and crank turn alike.
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
