"""Friction in all bearings at once, found together with the forces that cause it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..common.arrays import Array
from ..common.errors import PinpressError

REST = 1e-12  # share of the motion's largest speed below which a bearing rests: in a dead centre the speed is rounding
MOST_ITERATIONS = 200


@dataclass(frozen=True, eq=False, repr=False)
class FrictionLaw:
    """The friction of all bearings, joints in Pinocchio's order, then loops.

    Attributes:
        arm: (bearings,) mu r [m], of guides mu [-].
        viscous: (bearings,).
        turns: (bearings,) true but for guides.
        size: length of the linkage [m].
    """

    arm: Array
    viscous: Array
    turns: NDArray[np.bool_]
    size: float

    def moving(self, speeds: Array) -> Array:
        """Speeds (bearings, n), zero where they are rounding, beside the fastest of the motion."""
        turning = np.abs(speeds[self.turns]).max(initial=0.0)
        sliding = max(self.size * turning, np.abs(speeds[~self.turns]).max(initial=0.0))
        return np.where(np.abs(speeds) <= REST * np.where(self.turns, turning, sliding)[:, None], 0.0, speeds)

    def efforts(self, speeds: Array, forces: Callable[[Array], Array], angle: Array) -> Array:
        """Efforts (bearings, n) of friction, along the speeds, against them.

        Args:
            speeds: (bearings, n) of the bearings; exactly zero where one rests.
            forces: radial forces (bearings, n) under efforts (bearings, n) of friction.
            angle: (n,) crank angles, to name one.

        Raises:
            PinpressError: no consistent forces are found: friction locks the linkage, or nearly so.
        """
        steady = -self.viscous[:, None] * speeds
        against = -self.arm[:, None] * np.sign(speeds)
        found, change = steady, np.full(speeds.shape[1], np.inf)
        for _ in range(MOST_ITERATIONS):
            pressing = forces(found)
            following = steady + against * pressing
            before, change = change, np.abs(following - found).max(axis=0)
            # also beside what the largest force could do: a guide's own may be nothing but rounding
            size = np.maximum(np.abs(following).max(axis=0), self.arm.max() * pressing.max(axis=0))
            found = following
            # rounding can keep the last digits moving: stop where the change no longer shrinks
            if np.all((change <= 1e-15 * size) | ((change <= 1e-12 * size) & (change >= before))):
                return found
            if not np.isfinite(size).all():
                break
        worst = int(np.argmax(np.where(np.isfinite(change), change, np.inf)))
        raise PinpressError(
            f"friction locks the linkage, or nearly so, at crank angle {np.degrees(angle[worst]):.6g} deg: no consistent bearing forces are"
            " found; lower the coefficients of friction, or keep away from the dead point"
        )
