"""Harmonics of a force over one period of the crank's motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..common import tables
from ..common.arguments import expect, is_whole_number, numbers, typed
from ..common.errors import PinpressError, shown
from ..common.products import product
from ..common.quantities import Array
from ..common.results import Tabular
from ..kinematics.motion import EQUAL, Motion, is_cycle

FINER = 8  # angles for each state at which unequally spaced states are interpolated


@dataclass(frozen=True, eq=False, repr=False)
class HarmonicAnalysis(Tabular):
    """A force over one period as a sum of amplitude cos(order x crank angle + phase) over the orders.

    Attributes:
        orders: (k + 1,) orders, as multiples of the crank speed, from 0: whole numbers, and fractions between them where the linkage
            repeats itself only after several turns (`Linkage.period_turns`).
        amplitude: (k + 1, 3) amplitudes along the world axes [N]; for order 0 the mean, with its sign.
        phase: (k + 1, 3) phases, -pi to pi [rad]; for order 0 zero.
    """

    orders: Array
    amplitude: Array
    phase: Array

    @property
    def title(self) -> str:
        largest = self.amplitude[1:].max(initial=0.0)
        mean = ", ".join(f"{component:.6g}" for component in self.amplitude[0])
        return f"HarmonicAnalysis of a force: orders 0 to {self.orders[-1]:g}, mean ({mean}) N, amplitudes up to {largest:.6g} N"

    @property
    def _pictured(self) -> tuple[str, ...]:
        return "order [-]", *(f"amplitude_{axis} [N]" for axis in "xyz")

    def columns(self) -> dict[str, Array]:
        """Orders, amplitudes and phases along the world axes as columns under their names with units."""
        return {"order [-]": self.orders, **tables.by_axis("amplitude", "N", self.amplitude), **tables.by_axis("phase", "rad", self.phase)}


@typed
def harmonics(motion: Motion, force: Array, orders: int = 12) -> HarmonicAnalysis | None:
    """Harmonics of a force over the last full period of a motion.

    The states of a `cycle` are equally spaced, so that sums over them are exact; other motions, such as runs, are interpolated by cubic
    splines over the crank angle. None if the motion has no full period in one direction, the linkage has no period, or there are several
    drivers.

    Args:
        motion: the motion of n states.
        force: (n, 3) a force over it, such as the shaking force [N].
        orders: highest order; fewer are returned where the states do not resolve it.

    Raises:
        PinpressError: force of another shape or with a value that is not finite, or orders that are no whole number from 0 on.
    """
    if not is_whole_number(orders) or orders < 0:
        raise PinpressError(f"orders is {shown(orders)}: give a whole number from 0")
    expect("motion", motion, Motion, "cycle or simulate")
    force = numbers("harmonics: force", force)
    if force.shape != (len(motion.crank_angle), 3):
        raise PinpressError(f"force has shape {force.shape}: give one of ({len(motion.crank_angle)}, 3), a state a row")
    start, turns = last_period(motion), motion.period_turns
    if start is None or turns is None:
        return None
    angle, states = motion.crank_angle, len(motion.crank_angle) - start
    if is_cycle(motion):
        angles, values = angle, force
    else:
        from scipy.interpolate import CubicSpline  # slow to import

        period = np.copysign(2 * np.pi * turns, angle[-1] - angle[0])
        angles = angle[-1] - period * np.arange(FINER * states, 0, -1) / (FINER * states)
        rising = np.argsort(angle)
        values = CubicSpline(angle[rising], force[rising])(angles)
    order = np.arange(min(orders * turns, (states - 1) // 2) + 1) / turns
    sums = product(np.exp(-1j * np.multiply.outer(order, angles)), values) / len(angles)
    sums[1:] *= 2
    amplitude, phase = np.abs(sums), np.angle(sums)
    amplitude[0], phase[0] = sums[0].real, 0.0
    return HarmonicAnalysis(order, amplitude, phase)


def last_period(motion: Motion) -> int | None:
    """Index of the first state of the last full period; None as for `harmonics`. The period ends with the last state, or one step after it
    where the motion is a `cycle`."""
    angle = motion.crank_angle
    if motion.period_turns is None or len(angle) < 3 or not motion.crank_speed.all():
        return None
    steps, period = np.diff(angle), 2 * np.pi * motion.period_turns
    if not (np.all(steps > 0) or np.all(steps < 0)):
        return None
    travel = np.abs(angle - angle[-1])
    if travel[0] < period - EQUAL and not is_cycle(motion):
        return None
    return int(np.argmax(travel < period - EQUAL))  # a state one period before the last state is not counted twice
