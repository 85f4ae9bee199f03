"""Harmonics of a force over one turn of the crank."""

from dataclasses import dataclass

import numpy as np

from .coordinates import Array
from .errors import PinpressError, expect
from .forces import numbers
from .frozen import Frozen
from .motion import Motion

EQUAL = 1e-9  # difference of the steps of the crank angle [rad] that is none
FINER = 8  # times as many angles as states that unequal ones are interpolated at
BESIDE = 3.0  # times the largest error of prediction within the turn that it may have where the turn closes


@dataclass(frozen=True, eq=False)
class Harmonics(Frozen):
    """A force over one turn of the crank as a sum of amplitude cos(order x crank angle + phase) over the orders.

    Attributes:
        orders: (k + 1,) 0 to k, of the crank's speed.
        amplitude: (k + 1, 3) along the world's axes [N]; of order 0 the mean, with its sign.
        phase: (k + 1, 3) [rad], -pi to pi; of order 0 zero.
    """

    orders: Array
    amplitude: Array
    phase: Array


def harmonics(motion: Motion, force: Array, orders: int = 12) -> Harmonics | None:
    """Harmonics of a force (n, 3) [N] over the last full turn of the crank, fewer than ``orders`` where the states carry no more.

    The states of a `cycle` of one turn are equally spaced, and their sums exact; other motions, runs among them, are interpolated by
    cubic splines over the crank angle. None where the crank makes no full turn one way, the linkage is elsewhere after it, or
    there are several drivers.

    Raises:
        PinpressError: force of another shape or with a value that is not finite, orders that are no whole number from 0.
    """
    if isinstance(orders, bool) or not isinstance(orders, int | np.integer) or orders < 0:
        raise PinpressError(f"orders is {orders!r}: give a whole number from 0")
    expect("motion", motion, Motion, "cycle or simulate")
    force = numbers(force, "harmonics", "force")
    if force.shape != (len(motion.crank_angle), 3):
        raise PinpressError(f"force has shape {force.shape}: give one of ({len(motion.crank_angle)}, 3), a state a row")
    start = last_turn(motion)
    if start is None:
        return None
    angle, states = motion.crank_angle, len(motion.crank_angle) - start
    if is_cycle(motion):
        angles, values = angle, force
    else:
        from scipy.interpolate import CubicSpline  # slow to import

        turn = np.copysign(2 * np.pi, angle[-1] - angle[0])
        angles = angle[-1] - turn * np.arange(FINER * states, 0, -1) / (FINER * states)
        rising = np.argsort(angle)
        values = CubicSpline(angle[rising], force[rising])(angles)
    order = np.arange(min(orders, (states - 1) // 2) + 1)
    sums = np.exp(-1j * np.multiply.outer(order, angles)) @ values / len(angles)
    sums[1:] *= 2
    amplitude, phase = np.abs(sums), np.angle(sums)
    amplitude[0], phase[0] = sums[0].real, 0.0
    result = Harmonics(order.astype(float), amplitude, phase)
    for array in (result.orders, result.amplitude, result.phase):
        array.setflags(write=False)
    return result


def last_turn(motion: Motion) -> int | None:
    """Index of the first state of the crank's last full turn, which ends with the last state, or a step after it in a motion of one turn
    without its end. None as of `harmonics`."""
    angle = motion.crank_angle
    if angle.ndim > 1 or len(angle) < 3:
        return None
    steps = np.diff(angle)
    if not (np.all(steps > 0) or np.all(steps < 0)):
        return None
    travel = np.abs(angle - angle[-1])
    if travel[0] < 2 * np.pi - EQUAL and not is_cycle(motion):
        return None
    start = int(np.argmax(travel < 2 * np.pi - EQUAL))  # a state a turn before the last one is that one again
    return start if _comes_back(motion, start) else None


def is_cycle(motion: Motion) -> bool:
    """Whether the states are one turn of a single crank in equal steps, its end left out."""
    angle = motion.crank_angle
    if angle.ndim > 1 or len(angle) < 3:
        return False
    turn = float(np.copysign(2 * np.pi, angle[-1] - angle[0]))
    return bool(np.allclose(np.diff(angle, append=angle[0] + turn), turn / len(angle), rtol=0.0, atol=EQUAL))


def _comes_back(motion: Motion, start: int) -> bool:
    """Whether the joints are where they were after the turn: the step from the last state to the first one, as the trapezoidal rule has it
    from the influence coefficients at both, is as right as the others."""
    angle, speed = motion.crank_angle[start:], motion.crank_speed[start:]
    if not speed.all():
        return False  # no influence coefficients from the rates of a crank that stands
    position, slope = motion.joint_position[start:], motion.v[start:] / speed[:, None]
    turn = np.copysign(2 * np.pi, angle[-1] - angle[0])
    steps = np.diff(angle, append=angle[0] + turn)[:, None]
    predicted = 0.5 * steps * (slope + np.roll(slope, -1, axis=0))
    error = np.diff(position, axis=0, append=position[:1]) - predicted
    for joint, slot in enumerate(motion._slots):
        if slot.unbounded:
            error[-1, joint] -= 2 * np.pi * np.round(error[-1, joint] / (2 * np.pi))
    error = np.abs(error)
    return bool(np.all(error[-1] <= BESIDE * error[:-1].max(axis=0) + EQUAL))
