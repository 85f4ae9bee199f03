"""The shipped crank-slide with a flywheel under a force on its slide: the equation of `textbook_crank_slide`, integrated by SciPy."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from .textbook_crank_slide import BOTTOM, L, R, acceleration, height, lever


def angle_of(above: float) -> float:
    """Crank angle from bottom dead centre at which the slide is at a height, on the way up: law of cosines [rad]."""
    distance = -BOTTOM - above
    return math.acos((R**2 + distance**2 - L**2) / (2 * R * distance))


def run(
    force: Callable[[float, float], float], angle: float, speed: float, flywheel: float, times: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Angles and speeds (2, n) of the crank at times.

    Args:
        force: on the slide, of its height and velocity, upwards [N].
        angle: of the crank at the start, from bottom dead centre [rad].
        speed: of the crank at the start [rad/s].
        flywheel: inertia at the crank [kg m2].
        times: (n,) from 0 on [s].
    """

    def rates(_: float, y: NDArray[np.float64]) -> list[float]:
        q, w = float(y[0]), float(y[1])
        arm = lever(q, math)
        return [w, acceleration(q, w, force(height(q, math), arm * w) * arm, flywheel)]

    # SciPy does not stop at kinks of the force: short steps keep what they cost small
    found = solve_ivp(rates, (0.0, float(times[-1])), [angle, speed], "DOP853", t_eval=times, rtol=1e-9, atol=1e-11, max_step=2e-3)
    return np.asarray(found.y)
