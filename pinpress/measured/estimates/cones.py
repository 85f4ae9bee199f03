"""Estimates within the cones of real bodies: the nearest to the least squares, in the measure of their Hessian.

In the plane a body of mass m, first moments h and moment of inertia J about its joint is real where m >= 0 and J m >= h . h, which is
all of Wensing's condition (arXiv 1701.04395) there. In space its pseudo-inertia, (4, 4), is positive semidefinite. Friction is never
negative.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.conic_program import AT_MOST, CONE, SEMIDEFINITE, InfeasibleError, Rows, minimise
from ...common.errors import PinpressError
from ...common.quantities import Array
from .prior import Unknowns

TINY = 1e-9  # of scaled unknowns: as far outside the cones is rounding


class Solved(NamedTuple):
    """Least squares in numbers about one: their change, and its covariance."""

    change: Array
    covariance: Array


def within_cones(unknowns: Unknowns, values: Array, spread: Array, solved: Solved) -> Array:
    """The values (unknowns,) found by least squares, or the nearest ones within the cones.

    Args:
        unknowns: what they are.
        values: (unknowns,) by least squares.
        spread: (unknowns, k) their changes by numbers about one.
        solved: with the covariance of these.
    """
    cones = list[Rows]()  # on the unknowns
    position, moves = 0, np.abs(spread).max(axis=1) > 0
    for basis in unknowns.equations.bases:
        own = np.arange(position, position + basis.shape[1])
        position += basis.shape[1]
        if moves[own].any():
            kind, matrix = (_in_plane if basis.shape[1] == 4 else _in_space)(_units(unknowns, own))
            full = np.zeros((len(matrix), len(values)))
            full[:, own] = -matrix
            cones.append(Rows(kind, full, np.zeros(len(matrix))))
    for k in range(unknowns.inertial, len(values)):
        if moves[k] and "friction" in unknowns.parameters[k].name:
            cones.append(Rows(AT_MOST, -np.eye(len(values))[k : k + 1] / np.abs(spread[k]).max(), np.zeros(1)))
    if all(part.outside(part.slack(values)) <= TINY for part in cones):
        return values
    return _nearest(cones, values, spread, solved)


def _nearest(cones: Sequence[Rows], values: Array, spread: Array, solved: Solved) -> Array:
    """The values within the cones at the least distance from the least squares, by its Hessian."""
    # in numbers that are independent in the posterior, with a deviation of 1 each
    step = spread @ np.linalg.cholesky(solved.covariance)
    rows = [Rows(part.kind, part.matrix @ step, part.slack(values)) for part in cones]
    remedy = "check units and signs of torque and angle, and whether another force drives the press"
    try:
        # accepted within a millionth of the deviations, in which the change of the estimate is counted
        nearest = minimise(np.zeros(step.shape[1]), rows, squares=1.0, equilibrate=True, within=1e-6, remedy=remedy)
    except InfeasibleError:
        raise PinpressError(f"no real bodies explain these records: {remedy}") from None
    return np.asarray(values + step @ nearest.x)


def _units(unknowns: Unknowns, own: NDArray[np.intp]) -> Array:
    """(k,) sizes of a body's parameters in which mass x inertia is the square of a first moment."""
    parameters = [unknowns.parameters[k] for k in own]
    mass = max(parameters[0].size, 1e-300)
    arm = next((each.size for each in parameters if each.unit == "kg m"), 0.0) / mass or 1.0
    return np.array([{"kg": mass, "kg m": mass * arm, "kg m2": mass * arm**2}[each.unit] for each in parameters])


def _in_plane(sizes: Array) -> tuple[str, Array]:
    """(4, 4): J + m >= length of (2 h, J - m), which is J m >= h . h."""
    mass, first, second, turning = np.eye(4) / sizes[:, None]
    return CONE, np.stack([turning + mass, 2 * first, 2 * second, turning - mass])


def _in_space(sizes: Array) -> tuple[str, Array]:
    """(10, 10): the upper triangle of the pseudo-inertia by columns, off its diagonal times the root of 2, as Clarabel has it."""
    mass, x, y, z, xx, xy, yy, xz, yz, zz = np.eye(10) / sizes[:, None]
    half = 0.5 * (xx + yy + zz)
    root = np.sqrt(2.0)
    return SEMIDEFINITE, np.stack([half - xx, -root * xy, half - yy, -root * xz, -root * yz, half - zz, root * x, root * y, root * z, mass])
