"""Search for an optimum by sequential quadratic programming (SciPy's SLSQP), from one design or many, and check its conditions.

A maximum of several elements is not smooth. So the search minimises one more variable, an upper bound of all elements.

At an optimum the gradients of active bounds and constraints balance the gradient of the objective, with multipliers of the right sign (the
conditions of Karush, Kuhn and Tucker). If the objective is the largest of several elements, its gradient is a weighted mean of the
gradients of the largest elements. Nonnegative least squares give the multipliers. Their residual is zero at an optimum.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..common.errors import PinpressError
from ..common.quantities import Array
from ..common.results import Record, Records
from .problem import Limit, Point, Problem, listed, missed

CONVERGED = 1e-6  # scaled residual of the conditions of an optimum
TOUCHED = 1e-6  # a bound counts as reached at a smaller scaled distance


class Search:
    """A search for the optimum of a problem, which counts its designs.

    Attributes:
        problem: the problem.
        evaluations: number of evaluated designs.
        infeasible: number of designs that could not be assembled or evaluated.
        why: error of the last design that could not be assembled or evaluated.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.evaluations = self.infeasible = 0
        self.why: PinpressError | None = None

    def local(self, start: Point) -> Point:
        """The optimum that SLSQP reaches from a design.

        Raises:
            PinpressError: no design keeps the constraints, or the search does not converge.
        """
        point, reach, lost = start, 1.0, 0
        for _ in range(12):  # each descent starts with new estimates of curvature
            descent = _Descent(self, point, reach)
            end = descent.end()
            lost += descent.lost
            if optimality(end).residual <= CONVERGED:
                return end
            if _better(end, point):
                point, reach = end, min(1.0, 2.0 * reach)
            else:
                reach *= 0.2
            if reach < 1e-3 or lost > 30:
                break
        if point.widest_violation > CONVERGED:
            raise PinpressError(
                f"no design keeps the constraints: {missed(point)}; relax these, widen the variables' bounds, or start elsewhere"
            )
        if lost:
            raise PinpressError(
                f"the search ends at {listed(point.problem.values(point.z))}, next to designs that cannot be assembled or evaluated:"
                f" {self.why}; exclude them by a constraint on a transmission or pressure angle, or by narrower bounds"
            ) from self.why
        raise PinpressError(
            f"the search does not converge: residual {optimality(point).residual:.2g} of the optimum's conditions, more than {CONVERGED:g};"
            " write smooth functions of a trial (return an array instead of its maximum: its largest element is minimised), or start"
            " elsewhere"
        )

    def best(self, start: Point, seed: int) -> Point:
        """The best of the optima reached from a design and from random designs within the bounds.

        Raises:
            PinpressError: no optimum is reached; this is the first error of `local`.
        """
        from scipy.stats import qmc  # slow to import

        spread = qmc.Sobol(len(start.z), seed=seed).random(16)  # a power of two, because of Sobol's sequence
        optima: list[Point] = []
        failure: PinpressError | None = None
        for z in [start.z, *spread]:
            near = self.at(z, start)
            if near is None:
                continue
            try:
                optima.append(self.local(near))
            except PinpressError as error:
                failure = failure or error
        if not optima:
            assert failure is not None
            raise failure
        return min(optima, key=lambda point: point.objective)

    def at(self, z: Array, near: Point) -> Point | None:
        """The problem at scaled variables (k,); None if the linkage cannot be assembled or a function fails.

        An error that all designs have was already raised for the start.
        """
        try:
            point = self.problem.at(z, near.design)
        except PinpressError as error:
            self.infeasible, self.why = self.infeasible + 1, error
            return None
        self.evaluations += 1
        return point


@dataclass(frozen=True, repr=False)
class ActiveBound(Record):
    """A bound that is active at the optimum.

    Attributes:
        name: name of the variable or constraint.
        side: "lower", "upper" or "equal".
        bound: the bound [SI].
        multiplier: derivative of the optimal objective by the bound [SI]: negative for an upper bound, because raising this bound widens
            the search; positive for a lower bound.
    """

    name: str
    side: str
    bound: float
    multiplier: float


class OptimalityConditions(NamedTuple):
    """The conditions of an optimum at a point.

    Attributes:
        residual: scaled residual of the conditions.
        active: bounds that are active at the point, with their multipliers.
        idle: names of the variables without influence.
    """

    residual: float
    active: Records[ActiveBound]
    idle: tuple[str, ...]


def optimality(point: Point) -> OptimalityConditions:
    """Multipliers of all bounds that may be active at a point, and the residual of the conditions of an optimum."""
    from scipy.optimize import nnls  # slow to import

    problem = point.problem
    size = problem.requirements[0].scale
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
    scaled = [np.abs(part).max(axis=0) / requirement.scale for part, requirement in zip(point.slopes, problem.requirements, strict=True)]
    strongest = np.max(scaled, axis=0)
    idle = tuple(v.name for v, slope in zip(problem.variables, strongest, strict=True) if slope <= 1e-9)  # rounding error
    return OptimalityConditions(max(float(residual), slack, point.widest_violation), _active(forces, multipliers, size), idle)


class _CreepingError(Exception):
    """A descent met too many designs that cannot be assembled."""


class _Descent:
    """One run of SLSQP.

    The variables x are the scaled variables, at most ``reach`` away from the start. If the objective has several elements, their upper
    bound is the last variable.

    Attributes:
        lost: number of designs that could not be assembled.
    """

    def __init__(self, search: Search, start: Point, reach: float) -> None:
        self.search, self.here, self.last = search, start, start
        self.tried: Array = start.z
        self.failed, self.lost = False, 0
        self.reach = reach
        self.scale = start.problem.requirements[0].scale
        self.level = len(start.values[0]) > 1
        self.limits = start.problem.limits

    def end(self) -> Point:
        """Run the descent, and return the design at which it stops."""
        from scipy.optimize import minimize  # slow to import

        start = self.here
        bounds: list[tuple[float | None, float | None]] = [(max(0.0, z - self.reach), min(1.0, z + self.reach)) for z in start.z.tolist()]
        x = start.z
        if self.level:
            bounds, x = [*bounds, (None, None)], np.append(x, start.objective / self.scale)
        equal = [limit for limit in self.limits if limit.side == "equal"]
        others = [limit for limit in self.limits if limit.side != "equal"]
        constraints = [self._constraint("eq", equal, False)] if equal else []
        if others or self.level:
            constraints.append(self._constraint("ineq", others, self.level))
        options = {"maxiter": 100, "ftol": 1e-15}
        try:
            result = minimize(self._value, x, jac=self._slope, bounds=bounds, constraints=constraints, method="SLSQP", options=options)
            self._at(result.x)
        except _CreepingError:
            return self.here
        return self.here if self.failed else self.last

    def _constraint(self, kind: str, limits: Sequence[Limit], below: bool) -> dict[str, Any]:
        """Constraints in the form that SciPy takes.

        Args:
            kind: "eq" or "ineq".
            limits: the limits.
            below: whether to keep all elements of the objective below their upper bound too.
        """
        return {"type": kind, "fun": lambda x: self._slacks(x, limits, below), "jac": lambda x: self._slack_slopes(x, limits, below)}

    def _at(self, x: Array) -> Point:
        """The problem at x, or at the last valid x if the linkage cannot be assembled at x."""
        z = x[: len(self.here.z)]
        z = np.where(z < 1e-12, 0.0, np.where(z > 1.0 - 1e-12, 1.0, z))  # SLSQP keeps bounds within rounding error
        if not np.array_equal(z, self.tried):
            self.tried = z
            point = self.search.at(z, self.here)
            self.failed = point is None
            if point is not None:
                self.last = point
                return point
            self.lost += 1
            if self.lost > 10:  # the descent creeps along the border of designs that can be assembled
                raise _CreepingError
        return self.last

    def _value(self, x: Array) -> float:
        point = self._at(x)
        if self.failed:
            return 1e6  # the line search steps back from it
        return float(x[-1]) if self.level else point.objective / self.scale

    def _slope(self, x: Array) -> Array:
        self.here = self._at(x)
        return np.asarray(np.eye(len(x))[-1] if self.level else self.here.slopes[0][0] / self.scale)

    def _slacks(self, x: Array, limits: Sequence[Limit], below: bool) -> Array:
        point = self._at(x)
        above = [x[-1] - point.values[0] / self.scale] if below else []
        return np.concatenate([*(point.slacks(limit) for limit in limits), *above])

    def _slack_slopes(self, x: Array, limits: Sequence[Limit], below: bool) -> Array:
        point = self._at(x)
        rows = [point.slack_slopes(limit) for limit in limits]
        if self.level:
            rows = [np.column_stack([row, np.zeros(len(row))]) for row in rows]
        if below:
            slopes = -point.slopes[0] / self.scale
            rows.append(np.column_stack([slopes, np.ones(len(slopes))]))
        return np.concatenate(rows)


def _better(point: Point, before: Point) -> bool:
    """Whether a point is an improvement: closer to the constraints, or with a lower objective."""
    if max(point.widest_violation, before.widest_violation) > CONVERGED:
        return point.widest_violation < before.widest_violation
    return point.objective < before.objective


class _Force(NamedTuple):
    """A bound that may be active at a point, with the direction in which it pushes.

    Attributes:
        gradient: (k,) gradient of the scaled slack.
        slack: scaled slack.
        name: as in `ActiveBound`.
        side: as in `ActiveBound`.
        bound: as in `ActiveBound`.
        unit: size that scales the bound [SI].
        rising: +1 if raising the bound narrows the search, else -1.
    """

    gradient: Array
    slack: float
    name: str
    side: str
    bound: float
    unit: float
    rising: float


def _of_variables(point: Point) -> list[_Force]:
    forces = []
    for along, z, v in zip(np.eye(len(point.z)), point.z, point.problem.variables, strict=True):
        if z <= TOUCHED:
            forces.append(_Force(along, float(z), v.name, "lower", v.lower, v.range, 1.0))
        if 1.0 - z <= TOUCHED:
            forces.append(_Force(-along, float(1.0 - z), v.name, "upper", v.upper, v.range, -1.0))
    return forces


def _of_limits(point: Point) -> list[_Force]:
    forces = []
    for limit in point.problem.limits:
        requirement = point.problem.requirements[limit.requirement]
        for slack, gradient in zip(point.slacks(limit), point.slack_slopes(limit), strict=True):
            if slack > TOUCHED and limit.side != "equal":
                continue
            ways = (1.0, -1.0) if limit.side == "equal" else (1.0,)  # an equality pushes both ways
            forces += [
                _Force(way * gradient, float(slack), requirement.name, limit.side, limit.bound, requirement.scale, way * limit.sign)
                for way in ways
            ]
    return forces


def _active(forces: list[_Force], multipliers: Array, size: float) -> Records[ActiveBound]:
    """The bounds whose multipliers exceed rounding errors, with the sum of the multipliers over the elements of a constraint.

    Args:
        forces: bounds that may be active at the point.
        multipliers: scaled multipliers of these bounds.
        size: size that scales the objective [SI].
    """
    sums: dict[tuple[str, str, float, float], float] = {}
    for force, share in zip(forces, multipliers, strict=True):
        key = (force.name, force.side, force.bound, force.unit)
        sums[key] = sums.get(key, 0.0) + force.rising * share
    felt = {key: multiplier for key, multiplier in sums.items() if abs(multiplier) > TOUCHED}
    return Records(ActiveBound, (ActiveBound(*key[:3], float(multiplier * size / key[3])) for key, multiplier in felt.items()))
