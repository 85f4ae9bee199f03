"""What holds an optimum: multipliers of bounds and constraints, and how well the conditions of Karush, Kuhn and Tucker are met.

At an optimum the gradient of the objective is balanced by those of the bounds that hold it, with multipliers of the right sign. Of an
objective that is the largest of several elements it is a mean of the gradients of the largest ones. Multipliers are found by nonnegative
least squares; what is left over, the residual, is zero at an optimum.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..common.arrays import Array
from .problem import Point

TOUCHED = 1e-6  # scaled distance from a bound at which it counts as met
WITHOUT = 1e-9  # scaled gradient of a variable without influence


@dataclass(frozen=True)
class ActiveBound:
    """A bound that holds the optimum.

    Attributes:
        name: of the variable or constraint.
        side: "lower", "upper" or "equal".
        bound: [SI].
        multiplier: derivative of the optimum's value by the bound, in units of one per unit of the other. To raise an upper bound widens
            the search, so its multiplier is negative; that of a lower bound is positive.
    """

    name: str
    side: str
    bound: float
    multiplier: float


class Optimum(NamedTuple):
    """How well a point meets the conditions of an optimum.

    Attributes:
        residual: of the conditions, scaled.
        active: the bounds that hold the point, with their multipliers.
        idle: names of the variables without influence.
    """

    residual: float
    active: tuple[ActiveBound, ...]
    idle: tuple[str, ...]


class _Force(NamedTuple):
    """A bound that may hold the point, and the way it pushes.

    Attributes:
        gradient: (k,) of the slack, scaled.
        slack: scaled.
        name: as in `ActiveBound`.
        side: as in `ActiveBound`.
        bound: as in `ActiveBound`.
        unit: by which it is scaled [SI].
        rising: +1 where raising the bound narrows the search, else -1.
    """

    gradient: Array
    slack: float
    name: str
    side: str
    bound: float
    unit: float
    rising: float


def optimum(point: Point) -> Optimum:
    """The multipliers of all bounds that may hold a point, and the residual of the conditions there."""
    from scipy.optimize import nnls  # slow to import

    problem = point.problem
    size = problem.measures[0].scale
    values, slopes = point.values[0] / size, point.slopes[0] / size
    largest = values >= values.max() - TOUCHED
    forces = [*_of_variables(point), *_of_limits(point)]
    count = int(largest.sum())
    matrix = np.zeros((len(problem.variables) + 1, count + len(forces)))
    matrix[:-1, :count], matrix[-1, :count] = slopes[largest].T, 1.0
    if forces:
        matrix[:-1, count:] = -np.array([force.gradient for force in forces]).T
    target = np.zeros(len(matrix))
    target[-1] = 1.0
    shares, residual = nnls(matrix, target)
    multipliers = shares[count:] / max(shares[:count].sum(), np.finfo(float).tiny)
    slack = max((share * abs(force.slack) for share, force in zip(multipliers, forces, strict=True)), default=0.0)
    return Optimum(max(float(residual), slack, point.widest_violation), _active(forces, multipliers, size), _idle(point))


def _of_variables(point: Point) -> list[_Force]:
    found = []
    for along, z, v in zip(np.eye(len(point.z)), point.z, point.problem.variables, strict=True):
        if z <= TOUCHED:
            found.append(_Force(along, float(z), v.name, "lower", v.lower, v.range, 1.0))
        if 1.0 - z <= TOUCHED:
            found.append(_Force(-along, float(1.0 - z), v.name, "upper", v.upper, v.range, -1.0))
    return found


def _of_limits(point: Point) -> list[_Force]:
    found = []
    for limit in point.problem.limits:
        measure = point.problem.measures[limit.measure]
        for slack, gradient in zip(point.slacks(limit), point.slack_slopes(limit), strict=True):
            if slack > TOUCHED and limit.side != "equal":
                continue
            ways = (1.0, -1.0) if limit.side == "equal" else (1.0,)  # an equality pushes both ways
            found += [
                _Force(way * gradient, float(slack), measure.name, limit.side, limit.bound, measure.scale, way * limit.sign) for way in ways
            ]
    return found


def _active(forces: list[_Force], multipliers: Array, size: float) -> tuple[ActiveBound, ...]:
    """The bounds whose multipliers are more than rounding; the multipliers of one constraint's elements are added up.

    Args:
        size: by which the objective is scaled [SI].
    """
    sums: dict[tuple[str, str, float, float], float] = {}
    for force, share in zip(forces, multipliers, strict=True):
        key = (force.name, force.side, force.bound, force.unit)
        sums[key] = sums.get(key, 0.0) + force.rising * share
    return tuple(ActiveBound(*key[:3], float(multiplier * size / key[3])) for key, multiplier in sums.items() if abs(multiplier) > TOUCHED)


def _idle(point: Point) -> tuple[str, ...]:
    """The variables on which neither the objective nor a constraint depends, but for rounding."""
    slopes = [np.abs(s).max(axis=0) / m.scale for s, m in zip(point.slopes, point.problem.measures, strict=True)]
    strongest = np.max(slopes, axis=0)
    return tuple(v.name for v, slope in zip(point.problem.variables, strongest, strict=True) if slope <= WITHOUT)
