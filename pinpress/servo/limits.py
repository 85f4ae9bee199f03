"""Limits that a motion of a servo press must keep, in addition to those of the drive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..common import plausibility
from ..common.arguments import suitable_numbers, truth_value
from ..common.errors import PinpressError, shown
from ..common.parameters import Checked, parameter, set_field
from ..common.quantities import Array


class Window(Checked):
    """A limit that may hold between two heights of the slide only, and on one flank only."""

    heights: Sequence[float] | None
    flank: str

    def __post_init__(self) -> None:
        super().__post_init__()
        name = type(self).__name__
        if self.heights is not None:
            expected = "two different heights above bottom dead centre, not negative [m], e.g. (0.06, 0)"
            heights: Array = suitable_numbers(
                f"{name}: heights", self.heights, expected, (2,), lambda h: np.all(h >= 0) and h[0] != h[1] and np.all(h < 1e12)
            )
            set_field(self, "heights", tuple(heights.tolist()))
        if not isinstance(self.flank, str) or self.flank not in ("down", "up", "both"):
            raise PinpressError(f'{name}: flank is {shown(self.flank)}; give "down", "up" or "both"')


@dataclass(frozen=True)
class SlideSpeed(Window):
    """Largest speed of the slide between two heights: a drawing speed, or the speed of impact.

    Attributes:
        speed: largest speed of the slide [m/s].
        heights: two heights above bottom dead centre, in either order, between which the limit holds [m]; None: everywhere.
        flank: "down": while the slide goes down; "up": while it goes up; or "both".
        constant: whether the slide has exactly this speed there. The heights must then lie within the stroke, away from dead centres.
    """

    speed: float = field(metadata=parameter("m/s", "positive"))
    heights: Sequence[float] | None = None
    flank: str = "down"
    constant: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        truth_value("SlideSpeed: constant", self.constant)
        plausibility.slide_speed("SlideSpeed: speed", self.speed)
        if self.constant and self.heights is None:
            raise PinpressError("SlideSpeed: constant is True, but the slide turns back at dead centres: give heights=(upper, lower)")


@dataclass(frozen=True)
class CrankSpeed(Window):
    """Largest speed of the crank between two heights of the slide.

    Attributes:
        speed: largest speed of the crank, in both directions [rad/s].
        heights: two heights above bottom dead centre, between which the limit holds [m]; None: everywhere.
        flank: "down": while the slide goes down; "up": while it goes up; or "both".
    """

    speed: float = field(metadata=parameter("rad/s", "positive"))
    heights: Sequence[float] | None = None
    flank: str = "both"


@dataclass(frozen=True)
class SlideAcceleration(Window):
    """Largest acceleration of the slide, upwards and downwards.

    Attributes:
        acceleration: largest acceleration of the slide [m/s2].
        heights: two heights above bottom dead centre, between which the limit holds [m]; None: everywhere.
        flank: "down": while the slide goes down; "up": while it goes up; or "both".
    """

    acceleration: float = field(metadata=parameter("m/s2", "positive"))
    heights: Sequence[float] | None = None
    flank: str = "both"


@dataclass(frozen=True)
class CrankAcceleration(Checked):
    """Largest acceleration of the crank, in both directions.

    Attributes:
        acceleration: largest acceleration of the crank [rad/s2].
    """

    acceleration: float = field(metadata=parameter("rad/s2", "positive"))


@dataclass(frozen=True)
class BearingForce(Checked):
    """Largest force of a bearing or guide.

    Attributes:
        bearing: name of the bearing or guide.
        force: largest force [N].
    """

    bearing: str
    force: float = field(metadata=parameter("N", "positive"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.bearing, str):
            raise PinpressError(f"BearingForce: bearing is {shown(self.bearing)}; give the name of a bearing or guide")


@dataclass(frozen=True)
class TorqueRate(Checked):
    """Largest rate of change of the motor's torque: how fast the current can rise, or how much jerk gears and dies may have.

    This limit is not convex, so the result is only the best of the motions near it.

    Attributes:
        rate: largest rate of the torque, at the motor's shaft [N m/s].
    """

    rate: float = field(metadata=parameter("N m/s", "positive"))


@dataclass(frozen=True)
class RmsTorque(Checked):
    """Largest rms torque of the motor over the cycle.

    Attributes:
        torque: largest rms torque, at the motor's shaft [N m]; None: the drive's rated torque.
    """

    torque: float | None = field(default=None, metadata=parameter("N m", "positive"))


@dataclass(frozen=True)
class FeedWindow(Checked):
    """Least time above a height in each cycle, pauses included: time to feed the sheet and to take the part out.

    Attributes:
        height: height of the slide above bottom dead centre [m].
        time: least time for which the slide is above this height [s].
    """

    height: float = field(metadata=parameter("m", "positive"))
    time: float = field(metadata=parameter("s", "positive"))


StateLimit = SlideSpeed | CrankSpeed | SlideAcceleration | CrankAcceleration  # limits that can be checked at one state of a motion
Limit = StateLimit | BearingForce | RmsTorque | TorqueRate | FeedWindow


def checked(limits: object) -> tuple[Limit, ...]:
    """The limits as a tuple; raises PinpressError for an object that is not a limit."""
    limits_ = tuple(limits)  # type: ignore[arg-type, var-annotated]  # `typed` has checked that it is a sequence
    for limit in limits_:
        if not isinstance(limit, Limit):
            raise PinpressError(
                f"limits has {shown(limit)}, which is not a limit: give servo.SlideSpeed, CrankSpeed, SlideAcceleration,"
                " CrankAcceleration, BearingForce, RmsTorque, TorqueRate or FeedWindow"
            )
    return limits_


def span(limit: Window) -> tuple[float, float]:
    """Lower and upper height between which a limit holds [m]; infinite for a limit without heights."""
    return (-np.inf, np.inf) if limit.heights is None else (min(limit.heights), max(limit.heights))


def in_words(limit: Limit) -> str:
    """A limit in words: "slide speed of 0.2 m/s from 60 to 0 mm"."""
    where = ""
    if isinstance(limit, Window) and limit.heights is not None:
        start, end = sorted(limit.heights, reverse=limit.flank == "down")
        where = f" from {1e3 * start:.6g} to {1e3 * end:.6g} mm"
    if isinstance(limit, SlideSpeed):
        return f"{'constant ' if limit.constant else ''}slide speed of {limit.speed:.6g} m/s{where}"
    if isinstance(limit, CrankSpeed):
        return f"crank speed of {limit.speed:.6g} rad/s{where}"
    if isinstance(limit, SlideAcceleration):
        return f"slide acceleration of {limit.acceleration:.6g} m/s2{where}"
    if isinstance(limit, CrankAcceleration):
        return f"crank acceleration of {limit.acceleration:.6g} rad/s2"
    if isinstance(limit, BearingForce):
        return f"force of {limit.force:.6g} N in {limit.bearing}"
    if isinstance(limit, TorqueRate):
        return f"rate of torque of {limit.rate:.6g} N m/s"
    if isinstance(limit, RmsTorque):
        return "rms torque of the motor" if limit.torque is None else f"rms torque of the motor of {limit.torque:.6g} N m"
    return f"feed window of {limit.time:.6g} s above {1e3 * limit.height:.6g} mm"
