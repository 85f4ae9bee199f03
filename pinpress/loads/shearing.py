"""Blanking that feels the speed of the slide, and has a falling flank before the blank breaks through.

Metal resists fast shearing more than slow. Where a thermally activated flow decides, by Prandtl and Eyring, the stress grows with the
inverse hyperbolic sine of the strain rate; at high rates that is the factor 1 + C ln(rate) of Johnson and Cook (1983), whose C is 0.01 to
0.06 for steels. The strain rate in the gap between punch and die is the slide's speed by the gap, nearly. Once cracks grow, the force falls
before it vanishes.

So a slide that pauses, or creeps, before break-through lets the force down, and what springs back is less: what Zhang 2007 reports in 1.2.1
and names in 5.7.6 of Seidel and of Otsu. Signs, heights and datum are those of `process`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from ..common.errors import PinpressError, caution
from ..common.parameters import Checked, parameter
from ..common.quantities import Values
from .process import RESISTS, ForceInterval, constant_law


@dataclass(frozen=True, eq=False)
class RateSensitiveBlanking(Checked):
    """Blanking whose force grows with the speed of the slide: F s(h) (1 + C arsinh(-v / reference_speed)) on the way down.

    s is a quarter sine from the height ``start`` to 1 at ``peak``, and from there a quarter cosine to the share ``remaining`` at ``end``,
    where the blank breaks through. Where the slide springs back within the blank, v > 0, the force is below that at rest.

    Attributes:
        force: F, the largest at rest [N], or (S,) for S scenarios; not negative.
        start: height at which the punch meets the blank [m].
        end: height at which it breaks through [m], below ``start``.
        sensitivity: C [-], or (S,); 0: the force does not feel the speed.
        reference_speed: at which it begins to count: a strain rate, often 1/s, times the gap between punch and die [m/s].
        peak: height at which the force is largest [m], from ``start`` to ``end``; None: ``end``.
        remaining: share of the force that is left at ``end``, from 0 to 1 [-].
        stripping: as of `Blanking` [N], or (S,).
        datum: slide position from which heights count [m]; None: that of bottom dead centre.

    Warns:
        PinpressWarning: the reference speed is above 0.1 m/s: it may be in mm/s.

    Raises:
        PinpressError: a number is not as declared, ``start`` is not above ``end``, ``peak`` not between them, ``sensitivity`` not below 1,
            or something remains of a force without a falling flank.
    """

    force: Values = field(metadata=parameter("N", "not negative", scenarios=True, remark=RESISTS))
    start: float = field(metadata=parameter("m"))
    end: float = field(metadata=parameter("m"))
    sensitivity: Values = field(metadata=parameter("-", "not negative", scenarios=True))
    reference_speed: float = field(metadata=parameter("m/s", "positive"))
    peak: float | None = field(default=None, metadata=parameter("m"))
    remaining: float = field(default=1.0, metadata=parameter("-"))
    stripping: Values = field(default=0.0, metadata=parameter("N", "not negative", scenarios=True, remark=RESISTS))
    datum: float | None = field(default=None, metadata=parameter("m"))

    def __post_init__(self) -> None:
        super().__post_init__()
        name, peak = type(self).__name__, self.end if self.peak is None else self.peak
        if not self.start > peak >= self.end or not math.isfinite(math.pi / (self.start - peak)):
            raise PinpressError(
                f"{name}: start, peak and end are {self.start:g}, {peak:g} and {self.end:g}; give heights [m] that fall, peak may be end"
            )
        if np.any(np.asarray(self.sensitivity) >= 1):
            raise PinpressError(f"{name}: sensitivity is {np.max(self.sensitivity):g}; steels have 0.01 to 0.06, give a number below 1")
        # A strain rate of 1/s times a gap is 1e-3 m/s at most, a hundred times less.
        if np.any(self.sensitivity) and self.reference_speed > 0.1:
            caution(f"{name}: reference_speed is {self.reference_speed:g} m/s: if mm/s are meant, write {self.reference_speed:g}e-3")
        if not 0 <= self.remaining <= 1:
            raise PinpressError(f"{name}: remaining is {self.remaining:g}; give the share of the force that is left, from 0 to 1")
        if peak == self.end and self.remaining != 1:
            raise PinpressError(f"{name}: remaining is {self.remaining:g}, but the force does not fall: give peak, a height above end [m]")
        if peak > self.end and not math.isfinite(math.pi / (peak - self.end)):
            raise PinpressError(f"{name}: peak and end are too close to each other; move them apart, or leave out peak")

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        if not downwards:
            law = constant_law(-self.stripping)
            return (ForceInterval(self.start, self.end, law, heeds_velocity=False),) if np.any(self.stripping) else ()
        peak = self.end if self.peak is None else self.peak
        rate = partial(_rate_factor, self.force, self.sensitivity, self.reference_speed)
        feels = bool(np.any(self.sensitivity))
        rising = ForceInterval(self.start, peak, partial(_sine_rise, rate, self.start, 0.5 * math.pi / (self.start - peak)), False, feels)
        if peak == self.end:
            return (rising,)
        falling = partial(_cosine_fall, rate, peak, 0.5 * math.pi / (peak - self.end), self.remaining)
        return rising, ForceInterval(peak, self.end, falling, heeds_velocity=feels)


# Module functions that `partial` binds, not closures: loads can then be sent to other processes.


def _rate_factor(force: Any, sensitivity: Any, reference: float, velocity: Any) -> Any:
    share = -velocity / reference
    return force * (1.0 + sensitivity * (math.asinh(share) if isinstance(share, float) else np.arcsinh(share)))


def _sine_rise(rate: Any, start: float, slope: float, height: Any, velocity: Any) -> Any:
    angle = slope * (start - height)
    return rate(velocity) * (math.sin(angle) if isinstance(angle, float) else np.sin(angle))


def _cosine_fall(rate: Any, peak: float, slope: float, remaining: float, height: Any, velocity: Any) -> Any:
    angle = slope * (peak - height)
    cosine = math.cos(angle) if isinstance(angle, float) else np.cos(angle)
    return rate(velocity) * (remaining + (1.0 - remaining) * cosine)
