"""What the states of a motion are: finite, at constant speed, one period."""

from __future__ import annotations

import numpy as np

from ..common.errors import PinpressError
from ..common.quantities import Array
from .motion import Motion

EQUAL = 1e-9  # difference up to which steps of the crank angle are equal [rad]
ROUNDING = 1e-9  # share of the largest force below which a force, or of the crank speed below which its variation, is rounding


def is_cycle(motion: Motion) -> bool:
    """Whether the states are one period of a single crank in equal steps, without the end of the period."""
    angle = motion.crank_angle
    if motion.period_turns is None or len(angle) < 3:
        return False
    period = float(np.copysign(2 * np.pi * motion.period_turns, angle[-1] - angle[0]))
    return bool(np.allclose(np.diff(angle, append=angle[0] + period), period / len(angle), rtol=0.0, atol=EQUAL))


def is_constant(speed: Array) -> bool:
    """Whether speeds (n,) or (n, drivers) are constant to rounding."""
    return bool(np.all(np.ptp(speed, axis=0) <= ROUNDING * np.abs(speed).max(axis=0)))


def finite(quantity: str, values: Array) -> Array:
    """The values (n, ...), after a check.

    Raises:
        PinpressError: there is no value, or one is not finite.
    """
    if not len(values):
        raise PinpressError(f"{quantity} has no states: give a motion of at least one")
    if not np.isfinite(values).all():
        at = int(np.argwhere(~np.isfinite(values))[0][0])
        raise PinpressError(f"{quantity} is not finite at index {at}: give what cycle, simulate and inverse_dynamics return")
    return values
