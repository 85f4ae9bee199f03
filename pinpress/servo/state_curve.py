"""A quantity between the states of a motion: the quintic that has its value, rate and acceleration in both states of a step.

Two states at one instant are a corner, where the acceleration jumps: each has the acceleration of its own side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..common.errors import PinpressError
from ..common.numerics import quintics
from ..common.quantities import Array

PIECES = 100  # most pieces of a motion that all begin at corners
JUMP = 0.01  # share of the range of the second derivative that is a corner of a motion of more pieces
SAME = 1e-8  # share of the whole motion: states that are closer count as one instant


@dataclass(frozen=True, eq=False)
class StateCurve:
    """A quantity over time, or over a place that rises with time.

    Attributes:
        starts: (m,) rising starts of the steps.
        ends: (m,) ends of the steps; the end of a step and the start of the next are one instant.
        coefficients: (6, m) for rising powers of the distance from a step's start.
        corners: (k,) places where two states are at one instant. Of motions of more than 100 pieces, such as a best motion with its
            nodes, only those where the second derivative jumps by more than a hundredth of its range.
        missed: (m,) by how much the end-corrected trapezoidal rule misses the next state; small if the states resolve the motion.
    """

    starts: Array
    ends: Array
    coefficients: Array
    corners: Array
    missed: Array

    def at(self, places: Array, before: bool = False) -> tuple[Array, Array, Array]:
        """Value, first and second derivative (m,) at places (m,); at a corner the values after the corner, or ``before`` it."""
        step = np.searchsorted(self.starts, places, side="left" if before else "right") - 1
        step = np.clip(step, 0, len(self.starts) - 1)
        since = np.minimum(places, self.ends[step]) - self.starts[step]
        c = self.coefficients[:, step]
        value, first, second = c[5], 5 * c[5], 20 * c[5]
        for power in (4, 3, 2, 1, 0):
            value = value * since + c[power]
            first = first * since + power * c[power] if power else first
            second = second * since + power * (power - 1) * c[power] if power > 1 else second
        return value, first, second


def state_curve(places: Array, value: Array, first: Array, second: Array) -> StateCurve:
    """The curve through states (n,) at places in rising order; two may be equal.

    Raises:
        PinpressError: there are fewer than two states.
    """
    steps = np.diff(places)
    kept = steps > SAME * (places[-1] - places[0])
    if not kept.any():
        raise PinpressError("the motion has fewer than two states, or takes no time: give a motion over a period")
    h = steps[kept]
    x, v, a = (np.stack([each[:-1][kept], each[1:][kept]], axis=1) for each in (value, first, second))
    missed = np.abs(x[:, 1] - x[:, 0] - 0.5 * h * v.sum(axis=1) - h**2 / 12 * (a[:, 0] - a[:, 1]))
    corner = np.diff(np.flatnonzero(kept)) > 1
    if np.count_nonzero(corner) > PIECES:
        corner &= np.abs(a[1:, 0] - a[:-1, 1]) > JUMP * np.ptp(second)
    starts = places[:-1][kept]
    return StateCurve(starts, places[1:][kept], quintics(h[:, None], x, v, a)[..., 0], starts[1:][corner], missed)
