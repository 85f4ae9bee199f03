"""Estimates within the cones of real bodies: the nearest ones to the estimates by least squares, in the metric of their Hessian.

In the plane a body with mass m, first moments h and moment of inertia J about its joint is real if m >= 0 and J m >= h . h. This is
Wensing's condition (arXiv 1701.04395) in the plane. In space the pseudo-inertia (4, 4) of a real body is positive semidefinite. Friction is
never negative.
"""

from __future__ import annotations

import numpy as np

from ...common.conic_program import AT_MOST, CONE, SEMIDEFINITE, InfeasibleError, Rows, minimise
from ...common.errors import PinpressError
from ...common.quantities import Array
from .prior import Unknowns

TINY = 1e-9  # a smaller distance of scaled unknowns from the cones is a rounding error


def within_cones(unknowns: Unknowns, values: Array, spread: Array, covariance: Array) -> Array:
    """The values (unknowns,) by least squares if they are within the cones, otherwise the nearest values within the cones.

    Args:
        unknowns: the unknowns.
        values: (unknowns,) values by least squares.
        spread: (unknowns, k) changes of the unknowns by k scaled unknowns.
        covariance: (k, k) covariance of the scaled unknowns.
    """
    cones, moves = list[Rows](), np.abs(spread).max(axis=1) > 0
    for place in unknowns.equations.places:
        if moves[place].any():
            kind, matrix = (_in_plane if place.stop - place.start == 4 else _in_space)(_units(unknowns, place))
            full = np.zeros((len(matrix), len(values)))
            full[:, place] = -matrix
            cones.append(Rows(kind, full, np.zeros(len(matrix))))
    for k in range(unknowns.inertial, len(values)):
        if moves[k] and "friction" in unknowns.parameters[k].name:
            cones.append(Rows(AT_MOST, -np.eye(len(values))[k : k + 1] / np.abs(spread[k]).max(), np.zeros(1)))
    if all(part.outside(part.slack(values)) <= TINY for part in cones):
        return values

    variances, directions = np.linalg.eigh(covariance)  # rounding may leave a variance a little below zero
    # the unknowns of the program are independent in the posterior, each with a standard deviation of 1
    step = spread @ (directions * np.sqrt(np.maximum(variances, 0.0)))
    rows = [Rows(part.kind, part.matrix @ step, part.slack(values)) for part in cones]
    remedy = "check units and signs of torque and angle, and whether another force drives the press"
    try:  # to a millionth of the deviations, the unit in which changes of the estimates are judged
        nearest = minimise(np.zeros(step.shape[1]), rows, squares=1.0, equilibrate=True, within=1e-6, remedy=remedy)
    except InfeasibleError:
        raise PinpressError(f"no real bodies explain these records: {remedy}") from None
    return np.asarray(values + step @ nearest.x)


def _units(unknowns: Unknowns, place: slice) -> Array:
    """(k,) sizes of a body's parameters for which mass x inertia is the square of a first moment."""
    parameters = unknowns.parameters[place]
    mass = max(parameters[0].size, 1e-300)
    arm = next((each.size for each in parameters if each.unit == "kg m"), 0.0) / mass or 1.0
    return np.array([{"kg": mass, "kg m": mass * arm, "kg m2": mass * arm**2}[each.unit] for each in parameters])


def _in_plane(sizes: Array) -> tuple[str, Array]:
    """(4, 4): J + m >= length of (2 h, J - m), which is J m >= h . h."""
    mass, first, second, turning = np.eye(4) / sizes[:, None]
    return CONE, np.stack([turning + mass, 2 * first, 2 * second, turning - mass])


def _in_space(sizes: Array) -> tuple[str, Array]:
    """(10, 10): the upper triangle of the pseudo-inertia by columns, with the root of 2 off its diagonal, as Clarabel takes it."""
    mass, x, y, z, xx, xy, yy, xz, yz, zz = np.eye(10) / sizes[:, None]
    half = 0.5 * (xx + yy + zz)
    root = np.sqrt(2.0)
    return SEMIDEFINITE, np.stack([half - xx, -root * xy, half - yy, -root * xz, -root * yz, half - zz, root * x, root * y, root * z, mass])
