"""Convex programs: the minimum of a linear cost under linear, second-order-cone and semidefinite constraints, by Clarabel.

    minimise cost @ x + squares / 2 x @ x  with  bound - matrix @ x  in a cone, for each `Rows`

The proof of an optimum is computed from what the solver returns. The dual variables z of the rows prove it: if cost + squares x +
sum(matrix' z) = 0 and all z are in their dual cones, -sum(bound z) - squares / 2 x @ x is a lower bound of the cost of every x that fulfils
the constraints. Dual variables also prove that no x fulfils them: if sum(matrix' z) = 0 and -sum(bound z) > 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from .errors import PinpressError
from .quantities import Array

if TYPE_CHECKING:
    from scipy import sparse

    Matrix: TypeAlias = Array | sparse.csc_array | sparse.csc_matrix

EQUAL, AT_MOST, CONE, SEMIDEFINITE = "equal", "at most", "cone", "semidefinite"
TOLERANCE = 1e-12  # that the solver aims at, for programs scaled to numbers about one
PROVED = 1e-8  # largest residual of the optimality conditions that is accepted
REACH = 1e4  # dual variables must show that no x up to this size fulfils the constraints


@dataclass(frozen=True, eq=False, repr=False)
class Rows:
    """Constraints of one kind on the slack ``bound - matrix @ x``.

    Attributes:
        kind: `EQUAL`: the slack is zero. `AT_MOST`: it is not negative. `CONE`: its first element is not less than the length of the
            others. `SEMIDEFINITE`: so is the symmetric matrix whose upper triangle it is, by columns, off the diagonal times the root of 2.
        matrix: (rows, variables), dense or sparse.
        bound: (rows,).
        name: as text, for messages; empty for a constraint that only defines a quantity.
        unit: size of 1 of the bound, in the unit of the constrained quantity; 0 where it has none.
        size: number of rows of each cone; 0: all rows are one cone.
    """

    kind: str
    matrix: Matrix
    bound: Array
    name: str = ""
    unit: float = 1.0
    size: int = 0

    def slack(self, x: Array) -> Array:
        """(rows,) at a point (variables,)."""
        return np.asarray(self.bound - self.matrix @ x)

    def into_cone(self, slack: Array) -> Array:
        """A slack, or dual variables of an inequality, moved into the cone."""
        if self.kind == EQUAL:
            return np.zeros_like(slack)
        if self.kind == AT_MOST:
            return np.asarray(np.maximum(slack, 0.0))
        if self.kind == CONE:
            cones = slack.reshape(-1, self.size or len(slack)).copy()
            cones[:, 0] = np.maximum(cones[:, 0], np.linalg.norm(cones[:, 1:], axis=1))
            return np.asarray(cones.ravel())
        # of the lower triangle by rows, which is the upper one by columns
        rows, columns = np.tril_indices(int(np.sqrt(2 * len(slack))))
        scale = np.where(rows == columns, 1.0, np.sqrt(2.0))
        symmetric = np.zeros((rows[-1] + 1, rows[-1] + 1))
        symmetric[rows, columns] = symmetric[columns, rows] = slack / scale
        values, vectors = np.linalg.eigh(symmetric)
        return np.asarray(((vectors * np.maximum(values, 0.0)) @ vectors.T)[rows, columns] * scale)

    def outside(self, slack: Array) -> float:
        """Distance by which a slack is outside the cone."""
        return float(np.abs(self.into_cone(slack) - slack).max(initial=0.0))


@dataclass(frozen=True, eq=False, repr=False)
class Optimum:
    """A solution and its proof.

    Attributes:
        x: (variables,).
        value: cost of x.
        bound: dual cost; no x costs less.
        residual: largest violation of the optimality conditions: of constraints, of the dual equations, and of value = bound.
        prices: dual variables of every `Rows`, in their cones: by how much the cost falls where the bound is raised by one.
        slope: (variables,) what prices leave of the dual equations; the bound is lower by its product with the size of x.
    """

    x: Array
    value: float
    bound: float
    residual: float
    prices: tuple[Array, ...]
    slope: Array


class InfeasibleError(Exception):
    """No x fulfils the constraints, as dual variables prove."""


class UnsolvedError(PinpressError):
    """The solver neither found a solution with a proof nor proved that there is no solution."""


def minimise(
    cost: Array,
    rows: Sequence[Rows],
    *,
    squares: float = 0.0,
    tolerance: float = TOLERANCE,
    equilibrate: bool | None = None,
    within: float = PROVED,
    remedy: str,
) -> Optimum:
    """The optimum of a program.

    Args:
        cost: (variables,).
        rows: the constraints.
        squares: half of this times the square of the length of x is added to the cost. With 1 and no other cost, x is the nearest to 0.
        tolerance: that the solver aims at. Below 1e-10 it refines the solutions of its linear equations.
        equilibrate: whether the solver scales rows and columns. None: it does not, as the program is scaled by the sizes of its quantities;
            but if the optimum is not proved so, it does. (Rounding decides where everything can be balanced, so that no force is left.)
        within: largest residual that is accepted; inf where the caller judges the solution.
        remedy: what to do about a program that is not solved, the end of the error's message.

    Raises:
        InfeasibleError: there is no solution.
        UnsolvedError: the solver found no solution and did not prove that there is none, or the solution violates the optimality
            conditions.
    """
    from scipy import sparse  # to save start-up time

    fault, matrix = "", sparse.csc_matrix(sparse.vstack([sparse.coo_matrix(part.matrix) for part in rows]))
    for method, scaled in (("faer", False), ("qdldl", True)) if equilibrate is None else (("auto", equilibrate),):
        x, prices, status = _answer(cost, squares, rows, matrix, tolerance, method, scaled)
        if "PrimalInfeasible" in status:
            slope = float(np.abs(matrix.T @ np.concatenate(prices)).sum())
            if -float(sum(part.bound @ z for part, z in zip(rows, prices, strict=True))) > REACH * slope:
                raise InfeasibleError
            fault = f"{status}, which its dual variables do not prove"
        elif not (np.isfinite(x).all() and all(np.isfinite(z).all() for z in prices)):
            fault = status
        else:
            optimum = _proved(cost, squares, rows, matrix, x, prices)
            if optimum.residual <= within:
                return optimum
            fault = f"{status}: its conditions are missed by {optimum.residual:.1e}, more than rounding"
    raise UnsolvedError(f"the optimum was not found ({fault}); {remedy}")


def _answer(
    cost: Array, squares: float, rows: Sequence[Rows], matrix: Matrix, tolerance: float, method: str, equilibrate: bool
) -> tuple[Array, list[Array], str]:
    """What Clarabel returns: variables, dual variables of every `Rows` moved into their cones, and its status."""
    import clarabel  # to save start-up time
    from scipy import sparse  # to save start-up time

    kinds = {EQUAL: clarabel.ZeroConeT, AT_MOST: clarabel.NonnegativeConeT, CONE: clarabel.SecondOrderConeT}
    cones: list[object] = []
    for part in rows:
        count = len(part.bound)
        if part.kind == SEMIDEFINITE:
            cones.append(clarabel.PSDTriangleConeT(int(np.sqrt(2 * count))))
        else:
            size = part.size or count
            cones += [kinds[part.kind](size)] * (count // size if size else 0)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.direct_solve_method = method
    settings.equilibrate_enable = equilibrate
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
    if tolerance < 1e-10:
        # Many programs are so flat near their optimum that steps are only as good as the linear equations are solved.
        settings.iterative_refinement_max_iter = 50
        settings.iterative_refinement_reltol = settings.iterative_refinement_abstol = 1e-16
        settings.iterative_refinement_stop_ratio = 1.1
    solution = clarabel.DefaultSolver(
        squares * sparse.eye_array(len(cost), format="csc") if squares else sparse.csc_matrix((len(cost), len(cost))),
        cost,
        matrix,
        np.concatenate([part.bound for part in rows]),
        cones,
        settings,
    ).solve()
    split = _split(np.array(solution.z), rows)
    prices = [z if part.kind == EQUAL or not np.isfinite(z).all() else part.into_cone(z) for part, z in zip(rows, split, strict=True)]
    return np.array(solution.x), prices, str(solution.status)


def _split(values: Array, rows: Sequence[Rows]) -> list[Array]:
    """Values of all rows, by `Rows`."""
    return np.split(values, np.cumsum([len(part.bound) for part in rows])[:-1])


def _proved(cost: Array, squares: float, rows: Sequence[Rows], matrix: Matrix, x: Array, prices: Sequence[Array]) -> Optimum:
    """The solver's answer with its proof. Residuals are relative to the magnitudes of their terms."""
    curved = 0.5 * squares * float(x @ x)
    value, dual = float(cost @ x) + curved, -float(sum(part.bound @ z for part, z in zip(rows, prices, strict=True))) - curved
    z, magnitude = np.concatenate(prices), abs(matrix)
    slope = cost + squares * x + matrix.T @ z
    terms = np.abs(cost) + squares * np.abs(x) + magnitude.T @ np.abs(z)
    bound = np.concatenate([part.bound for part in rows])
    slacks, sizes = (_split(values, rows) for values in (bound - matrix @ x, np.abs(bound) + magnitude @ np.abs(x)))
    missed = [part.outside(slack) / max(1.0, float(size.max(initial=0.0))) for part, slack, size in zip(rows, slacks, sizes, strict=True)]
    residual = max(float((np.abs(slope) / np.maximum(terms, 1.0)).max()), *missed, abs(value - dual) / max(1.0, abs(value)))
    # Prices that do not fulfil the dual equations exactly can have added this much to the bound, for x of this size.
    excess = float(np.abs(slope) @ np.abs(x))
    return Optimum(x, value, dual - excess, residual, tuple(prices), slope)
