"""A run without any solver of the simulation: SciPy's DOP853, with the crank's acceleration from inverse dynamics.

The driving torque is affine in the acceleration at a given angle and speed, so that two calls determine the acceleration. The drive's
torque is smooth in the speed, and nothing else acts but the weights.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import pinpress as pp

RPM = np.pi / 30


def run(press, times, angle: float, speed: float, inertia: float, torque: Callable[[float], float]) -> NDArray[np.float64]:
    """Angles and speeds (2, n) of the crank at times (n,); ``inertia``: of flywheel and drive at the crank [kg m2]."""

    def rates(_: float, y: NDArray[np.float64]) -> list[float]:
        motion = pp.servo_cycle(press, [y[0], y[0]], speed=y[1], acceleration=np.array([0.0, 1.0]))
        at_rest, at_one = pp.inverse_dynamics(press, motion, bearings=()).driving_torque
        return [y[1], (torque(y[1]) - at_rest) / (at_one - at_rest + inertia)]

    return solve_ivp(rates, (0.0, times[-1]), [angle, speed], "DOP853", times, rtol=1e-10, atol=1e-12).y


def kloss(power: float, rated_speed: float, ratio: float, frequency: float = 50.0, poles: int = 4, breakdown: float = 2.5):
    """Torque at the crank by its speed of an induction motor behind gears, by Kloss's formula."""
    synchronous, rated = 4 * np.pi * frequency / poles, rated_speed * RPM
    slip = 1 - rated / synchronous
    most, largest = slip * (breakdown + np.sqrt(breakdown**2 - 1)), breakdown * power / rated

    def torque(speed: float) -> float:
        s = 1 - speed * ratio / synchronous
        return ratio * 2 * largest * s * most / (s**2 + most**2)

    return torque
