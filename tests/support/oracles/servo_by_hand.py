"""Best motions of a servo press by SLSQP in the squares of the speeds alone; of `pinpress.servo` nothing is used, but inverse dynamics."""

import dataclasses
import functools

import numpy as np
from scipy.optimize import minimize
from support import texts

import pinpress as pp


@functools.cache
def weightless(name):
    """A shipped press without gravity."""
    press = texts.shipped(name)
    model = press.model.copy()
    model.gravity.linear = np.zeros(3)
    return dataclasses.replace(press, model=model)


class Press:
    """Torque of a press over its crank angle: M b'/2 + M' b/2 + G + F, at any angles, from `inverse_dynamics`.

    way: 1 or -1, sense of turning.
    """

    def __init__(self, press, drive_inertia, loads=()):
        self.press, self.inertia, self.loads = press, drive_inertia, list(loads)

    def at(self, angle):
        """M with the drive, M', and G + F, (n,) each."""
        zero, one = np.zeros_like(angle), np.ones_like(angle)

        def torque(speed, acceleration, loads):
            motion = pp.servo_cycle(self.press, angle, speed=speed, acceleration=acceleration)
            return pp.inverse_dynamics(self.press, motion, loads, bearings=()).driving_torque

        still = torque(1e-3 * one, zero, [])
        accelerated, moving = torque(1e-3 * one, one, []), torque(one, zero, [])
        loaded = torque(1e-3 * one, zero, self.loads)
        return accelerated - still + self.inertia, 2.0 * (moving - still), loaded

    def slide(self, angle):
        """Height and travel by crank angle, (n,) each."""
        motion = pp.servo_cycle(self.press, angle, speed=np.ones_like(angle), acceleration=np.zeros_like(angle))
        return motion.slide_position - pp.dead_centres(self.press).bottom_position, motion.slide_velocity


def least_heat(press, angle, inner, time, most, start, exactly=False):
    """b (N,) at the nodes of a closed turn with the least heat, by SLSQP with exact gradients.

    Args:
        press: a `Press`.
        angle: (N + 1,) nodes, the last one the first again.
        inner: (2, N) places within the segments at which the torque is taken.
        time: of the turn.
        most: (N,) largest b, infinite where there is none.
        start: (N,) b to start from.
        exactly: whether the turn takes this time, and not at most this time.
    """
    step = np.diff(angle)
    size = start.mean()
    places = [press.at(angle[:-1] + share * step) for share in inner]

    def times(b):
        v = np.sqrt(np.append(b, b[0]))
        total = v[1:] + v[:-1]
        slope = -2.0 * step / total**2  # by each of the speeds
        return 2.0 * step / total, slope, v

    def heat(x):
        b = size * x
        duration, slope, v = times(b)
        torques = [_torque(b, place, share, step) for place, share in zip(places, inner, strict=True)]
        mean = 0.5 * sum(t**2 for t, _, _ in torques)
        value = float(mean @ duration)
        before = sum(t * first for t, first, _ in torques) * duration + mean * slope / (2.0 * v[:-1])
        after = sum(t * second for t, _, second in torques) * duration + mean * slope / (2.0 * v[1:])
        return value / scale, size * (before + np.roll(after, 1)) / scale

    def spare(x):
        return 1.0 - times(size * x)[0].sum() / time

    def spare_slope(x):
        _, slope, v = times(size * x)
        return -size * (slope / (2.0 * v[:-1]) + np.roll(slope / (2.0 * v[1:]), 1)) / time

    scale = 1.0
    scale = heat(start / size)[0]
    found = minimize(
        heat,
        start / size,
        jac=True,
        method="SLSQP",
        bounds=[(1e-6, None if np.isinf(m) else m / size) for m in most],
        constraints=[{"type": "eq" if exactly else "ineq", "fun": spare, "jac": spare_slope}],
        options={"maxiter": 2000, "ftol": 1e-15},
    )
    return size * found.x, float(found.fun * scale)


def _torque(b, place, share, step):
    """Torque at one place of each segment, and its slopes by b at both ends."""
    inertia, slope, fixed = place
    first, second = 0.5 * slope * (1.0 - share) - inertia / (2.0 * step), 0.5 * slope * share + inertia / (2.0 * step)
    after = np.append(b[1:], b[0])
    return first * b + second * after + fixed, first, second
