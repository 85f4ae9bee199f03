"""Convex programs: the minimum of a linear cost under linear and second-order-cone constraints, by Clarabel's interior-point method.

    minimise cost @ x  with  bound - coefficients @ x  in a cone, for each `Rows`

The proof of the optimum is computed again from what the solver returns. The dual variables z of the rows prove it: where
cost + sum(coefficients' z) = 0 with all z in their dual cones, -sum(bound z) is a lower bound of the cost of every x that fulfils the
constraints.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .quantities import Array

EQUAL, AT_MOST, CONE = "equal", "at most", "cone"
TOLERANCE = 1e-12  # tolerance that the solver aims at, for programs scaled to numbers about one
PROVED = 1e-8  # largest residual of the optimality conditions that is accepted
# Solvers of the steps' linear equations, and whether rows are scaled once more, one after the other until the optimum is proved: programs
# are scaled by the sizes of their quantities already, but rounding decides where everything can be balanced, so that no force is left.
SOLVERS = (("faer", False), ("qdldl", True))


@dataclass(frozen=True, eq=False, repr=False)
class Rows:
    """One constraint: the slack ``bound - coefficients @ x`` is zero (`EQUAL`), not negative (`AT_MOST`), or has a first element not less
    than the length of the others (`CONE`).

    Attributes:
        kind: one of these.
        coefficients: (rows, variables).
        bound: (rows,).
        name: in words, for messages; empty for a constraint that only defines a quantity.
        unit: size of 1 of the bound, in the unit of the constrained quantity; 0 where it has none.
    """

    kind: str
    coefficients: Array
    bound: Array
    name: str = ""
    unit: float = 1.0

    def slack(self, x: Array) -> Array:
        """(rows,) at a point (variables,)."""
        return np.asarray(self.bound - self.coefficients @ x)

    def size(self, x: Array) -> float:
        """Largest sum of the magnitudes of a slack's terms, at least 1."""
        return max(1.0, float((np.abs(self.bound) + np.abs(self.coefficients) @ np.abs(x)).max(initial=0.0)))


@dataclass(frozen=True, eq=False, repr=False)
class Optimum:
    """A solution and its proof.

    Attributes:
        x: (variables,).
        value: cost of x.
        bound: dual cost; no x costs less.
        residual: largest violation of the optimality conditions: of constraints, of the dual equations and cones, and of value = bound.
        prices: dual variables of every `Rows`: by how much the cost falls where the bound is raised by one.
    """

    x: Array
    value: float
    bound: float
    residual: float
    prices: tuple[Array, ...]


class InfeasibleError(Exception):
    """No x fulfils the constraints."""


class UnsolvedError(Exception):
    """The solver found neither a solution that is proved nor that there is none; in words, without what to do."""


def minimise(cost: Array, rows: Sequence[Rows]) -> Optimum:
    """The optimum of a program.

    Raises:
        InfeasibleError: the solver proved that there is no solution.
        UnsolvedError: the solver found neither a solution nor that proof, or a solution that violates the optimality conditions.
    """
    for solver, equilibrated in SOLVERS:
        x, prices, status = _answer(cost, rows, solver, equilibrated)
        optimum = _proved(cost, rows, x, prices)
        if optimum.residual <= PROVED:
            return optimum
    raise UnsolvedError(f"the optimum was not found ({status}): its conditions are missed by {optimum.residual:.1e}, more than rounding")


def _answer(cost: Array, rows: Sequence[Rows], solver: str, equilibrated: bool) -> tuple[Array, list[Array], str]:
    """What Clarabel returns: variables, dual variables of every `Rows`, and its status; raises InfeasibleError."""
    import clarabel  # to save start-up time
    from scipy import sparse  # to save start-up time

    cones = {EQUAL: clarabel.ZeroConeT, AT_MOST: clarabel.NonnegativeConeT, CONE: clarabel.SecondOrderConeT}
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.direct_solve_method = solver
    settings.equilibrate_enable = equilibrated
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    # Many programs are so flat near their optimum that steps are only as good as the linear equations are solved.
    settings.iterative_refinement_max_iter = 50
    settings.iterative_refinement_reltol = settings.iterative_refinement_abstol = 1e-16
    settings.iterative_refinement_stop_ratio = 1.1
    variables = len(cost)
    solution = clarabel.DefaultSolver(
        sparse.csc_matrix((variables, variables)),
        cost,
        sparse.csc_matrix(np.concatenate([part.coefficients for part in rows])),
        np.concatenate([part.bound for part in rows]),
        [cones[part.kind](len(part.bound)) for part in rows],
        settings,
    ).solve()
    if solution.status in (clarabel.SolverStatus.PrimalInfeasible, clarabel.SolverStatus.AlmostPrimalInfeasible):
        raise InfeasibleError
    prices = np.split(np.array(solution.z), np.cumsum([len(part.bound) for part in rows])[:-1])
    return np.array(solution.x), prices, str(solution.status)


def _proved(cost: Array, rows: Sequence[Rows], x: Array, prices: Sequence[Array]) -> Optimum:
    """The solver's answer with its proof, computed anew. Residuals are relative to the magnitudes of their terms."""
    value, dual = float(cost @ x), -float(sum(part.bound @ z for part, z in zip(rows, prices, strict=True)))
    stationary, terms = cost.copy(), np.abs(cost)
    for part, z in zip(rows, prices, strict=True):
        stationary += part.coefficients.T @ z
        terms += np.abs(part.coefficients.T) @ np.abs(z)
    slope = float((np.abs(stationary) / np.maximum(terms, 1.0)).max())
    missed = [_outside(part.kind, part.slack(x)) / part.size(x) for part in rows]
    outside = [0.0 if part.kind == EQUAL else _outside(part.kind, z) for part, z in zip(rows, prices, strict=True)]
    beyond = [each / max(1.0, float(np.abs(z).max())) for each, z in zip(outside, prices, strict=True)]
    residual = max(slope, *missed, *beyond, abs(value - dual) / max(1.0, abs(value)))
    # This much prices that are not exactly dual can have added to the bound, for designs of this size.
    excess = np.abs(stationary) @ np.abs(x) + sum(each * np.abs(part.slack(x)).sum() for each, part in zip(outside, rows, strict=True))
    return Optimum(x, value, dual - float(excess), residual, tuple(prices))


def _outside(kind: str, slack: Array) -> float:
    """Distance by which a slack is outside its cone."""
    if kind == EQUAL:
        return float(np.abs(slack).max(initial=0.0))
    if kind == AT_MOST:
        return float(np.maximum(-slack, 0.0).max(initial=0.0))
    return max(0.0, float(np.linalg.norm(slack[1:]) - slack[0]))
