"""Limits that a motion of a servo press must keep, beside those of the drive itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..common import plausibility
from ..common.arguments import suitable_numbers, truth_value
from ..common.errors import PinpressError, shown
from ..common.parameters import Checked, parameter, set_field
from ..common.quantities import Array


@dataclass(frozen=True)
class SlideSpeed(Checked):
    """The slide is at most so fast between two heights: drawing speed, speed of impact.

    Attributes:
        speed: largest speed of the slide [m/s].
        heights: two heights above bottom dead centre, in either order, between which it holds [m]; None: everywhere.
        flank: "down": while the slide goes down; "up"; or "both".
        constant: whether the slide is exactly so fast there. Its heights must then lie within the stroke, away from the dead centres.
    """

    speed: float = field(metadata=parameter("m/s", "positive"))
    heights: Sequence[float] | None = None
    flank: str = "down"
    constant: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_window(self, self.flank)
        truth_value("SlideSpeed: constant", self.constant)
        plausibility.slide_speed("SlideSpeed: speed", self.speed)
        if self.constant and self.heights is None:
            raise PinpressError("SlideSpeed: constant is True, but a slide turns back: give heights=(upper, lower) between which it holds")


@dataclass(frozen=True)
class CrankSpeed(Checked):
    """The crank is at most so fast between two heights of the slide.

    Attributes:
        speed: largest speed of the crank, in both directions [rad/s].
        heights: two heights above bottom dead centre [m]; None: everywhere.
        flank: "down": while the slide goes down; "up"; or "both".
    """

    speed: float = field(metadata=parameter("rad/s", "positive"))
    heights: Sequence[float] | None = None
    flank: str = "both"

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_window(self, self.flank)


@dataclass(frozen=True)
class SlideAcceleration(Checked):
    """The slide's acceleration is at most so large, upwards and downwards.

    Attributes:
        acceleration: [m/s2].
        heights: two heights above bottom dead centre [m]; None: everywhere.
        flank: "down": while the slide goes down; "up"; or "both".
    """

    acceleration: float = field(metadata=parameter("m/s2", "positive"))
    heights: Sequence[float] | None = None
    flank: str = "both"

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_window(self, self.flank)


@dataclass(frozen=True)
class CrankAcceleration(Checked):
    """The crank's acceleration is at most so large, in both directions.

    Attributes:
        acceleration: [rad/s2].
    """

    acceleration: float = field(metadata=parameter("rad/s2", "positive"))


@dataclass(frozen=True)
class BearingForce(Checked):
    """The force of a bearing or guide is at most so large.

    Attributes:
        bearing: its name.
        force: [N].
    """

    bearing: str
    force: float = field(metadata=parameter("N", "positive"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.bearing, str):
            raise PinpressError(f"BearingForce: bearing is {shown(self.bearing)}; give the name of a bearing or guide")


@dataclass(frozen=True)
class TorqueRate(Checked):
    """The motor's torque changes at most so fast: how fast its current can be built up, or how much jerk gears and dies may have.

    It is not convex: the motion found is the best near it.

    Attributes:
        rate: at the motor's own shaft [N m/s].
    """

    rate: float = field(metadata=parameter("N m/s", "positive"))


@dataclass(frozen=True)
class RmsTorque(Checked):
    """The root mean square of the motor's torque over the cycle is at most so large.

    Attributes:
        torque: at the motor's own shaft [N m]; None: the drive's rated torque.
    """

    torque: float | None = field(default=None, metadata=parameter("N m", "positive"))


@dataclass(frozen=True)
class FeedWindow(Checked):
    """The slide is above a height for at least so long in each cycle, pauses included: time to feed the sheet and to take the part out.

    Attributes:
        height: above bottom dead centre [m].
        time: [s].
    """

    height: float = field(metadata=parameter("m", "positive"))
    time: float = field(metadata=parameter("s", "positive"))


Window = SlideSpeed | CrankSpeed | SlideAcceleration
StateLimit = Window | CrankAcceleration  # what the states of a motion tell, each by itself
Limit = SlideSpeed | CrankSpeed | SlideAcceleration | CrankAcceleration | BearingForce | RmsTorque | TorqueRate | FeedWindow


def checked(limits: object) -> tuple[Limit, ...]:
    """The limits; raises PinpressError where one is none."""
    found = tuple(limits)  # type: ignore[arg-type, var-annotated]  # a sequence, as `typed` has seen
    for each in found:
        if not isinstance(each, Limit):
            raise PinpressError(
                f"limit {shown(each)} is none: give servo.SlideSpeed, CrankSpeed, SlideAcceleration, CrankAcceleration, BearingForce,"
                " RmsTorque, TorqueRate or FeedWindow"
            )
    return found


def span(limit: Window) -> tuple[float, float]:
    """Lower and upper height between which a limit holds [m]; infinite where it holds everywhere."""
    return (-np.inf, np.inf) if limit.heights is None else (min(limit.heights), max(limit.heights))


def _check_window(limit: Window, flank: object) -> None:
    name = type(limit).__name__
    if limit.heights is not None:
        wanted = "two different heights above bottom dead centre, not negative [m], e.g. (0.06, 0)"
        heights: Array = suitable_numbers(
            f"{name}: heights", limit.heights, wanted, (2,), lambda h: np.all(h >= 0) and h[0] != h[1] and np.all(h < 1e12)
        )
        set_field(limit, "heights", tuple(heights.tolist()))
    if not isinstance(flank, str) or flank not in ("down", "up", "both"):
        raise PinpressError(f'{name}: flank is {shown(flank)}; give "down", "up" or "both"')


def in_words(limit: Limit) -> str:
    """A limit in words: "slide speed of 0.2 m/s from 60 to 0 mm"."""
    if isinstance(limit, SlideSpeed | CrankSpeed | SlideAcceleration):
        where = ""
        if limit.heights is not None:
            low, high = span(limit)
            ends = (high, low) if limit.flank == "down" else (low, high)
            where = f" from {1e3 * ends[0]:.6g} to {1e3 * ends[1]:.6g} mm"
        if isinstance(limit, SlideSpeed):
            return f"{'constant ' if limit.constant else ''}slide speed of {limit.speed:.6g} m/s{where}"
        if isinstance(limit, CrankSpeed):
            return f"crank speed of {limit.speed:.6g} rad/s{where}"
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
