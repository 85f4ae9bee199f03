"""Records as rows of linear equations without accelerations: the angle as a spline, the equation of motion weighted over time.

The angle is a quintic spline that fits the samples by least squares, with as many knots a stroke as the record asks for. Each equation
(see `regressor`) is multiplied with B-splines phi over time and integrated by parts,

    integral of phi s dt  =  sum over p of  p integral of (-phi' A w - share phi A' w^2 + phi C) dt

so that only the angle's first derivative is needed. The right side is integrated by Gauss's rule, the left is the sum over the samples. The
noise of the samples makes the left sides correlated; they are made independent by the Cholesky factor of their covariance.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.errors import PinpressError
from ...common.frozen import Frozen
from ...common.quantities import Array
from ..records import MeasuredRun
from ..regressor import Coefficients

KNOTS = (6, 8, 12, 16, 24, 32, 48)  # a stroke at the highest speed
CLEARLY = 0.995  # of the expected error, by which more knots must lower it
FINEST = 4  # fewest samples between knots
DEGREE = 5  # of the weights: sums over samples are then as good as integrals
GAUSS = 5  # points between two knots
WEIGHTS = 24  # least knots of the weights a stroke
FEWEST = 1.5  # strokes of a record


class SmoothAngle(NamedTuple):
    """A record's angle as a spline at the points of Gauss's rule, m of them, and what weights them.

    Attributes:
        angle: (m,) [rad].
        speed: (m,) [rad/s].
        acceleration: (m,) [rad/s2].
        weighted: (rows, m) sparse: times values at the points it is their integrals with each weight phi.
        slopes: (rows, m) sparse: the same with each phi'.
        sampled: (rows, n) sparse: the same of the samples.
        factor: banded Cholesky factor of the covariance of these sums, for samples of variance 1.
        noise: standard deviation of the samples of the angle about the spline [rad].
    """

    angle: Array
    speed: Array
    acceleration: Array
    weighted: Any
    slopes: Any
    sampled: Any
    factor: Array
    noise: float

    def integrals(self, values: Array) -> Array:
        """(rows, k) independent rows of values at the points, (m, k)."""
        return self._independent(self.weighted @ values)

    def equations(self, found: Coefficients) -> Array:
        """(rows, parameters) independent rows of an equation by its coefficients at the points."""
        speed = self.speed[:, None]
        rows = -(self.slopes @ (found.inertia * speed)) + self.weighted @ (found.weight - found.share * found.slope * speed**2)
        return self._independent(rows)

    def measured(self, samples: Array) -> Array:
        """(rows,) independent rows of what was measured at the samples, (n,)."""
        return self._independent((self.sampled @ samples)[:, None])[:, 0]

    def without_offset(self, rows: Array) -> Array:
        """Independent rows, (rows,) or (rows, k), less what a constant offset of the samples could be: load cells are set to zero anyhow,
        and nobody knows the weight of the frame."""
        constant = self.integrals(np.ones((len(self.angle), 1)))[:, 0]
        share = constant @ rows / (constant @ constant)
        return np.asarray(rows - (np.outer(constant, share) if rows.ndim > 1 else constant * share))

    def _independent(self, rows: Array) -> Array:
        from scipy.linalg.lapack import dtbtrs  # to save start-up time

        return np.asarray(dtbtrs(self.factor, rows, uplo="L")[0]) if rows.size else np.zeros((self.factor.shape[1], 0))  # LAPACK needs some


def smoothed(run: MeasuredRun) -> SmoothAngle:
    """The angle of a record as a spline.

    Raises:
        PinpressError: the record is too short, or sampled too slowly.
    """
    from scipy.interpolate import BSpline  # to save start-up time
    from scipy.linalg import cholesky_banded
    from scipy.sparse import diags_array

    time = run.time - run.time[0]
    if run.strokes < FEWEST:
        raise PinpressError(
            f"{run.name}: {run.strokes:.3g} strokes: one stroke does not separate masses from friction. Measure ten strokes at three speeds"
        )
    spline, noise, step = _fitted(run, time)
    count = max(int(np.ceil(time[-1] / min(step, _stroke(run, time) / WEIGHTS))), 4 * DEGREE)
    breaks = np.linspace(0.0, time[-1], count + 1)
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS)
    half = 0.5 * (breaks[1] - breaks[0])
    points = (breaks[:-1, None] + half * (1 + nodes)).ravel()
    knots = np.concatenate([np.zeros(DEGREE), breaks, np.full(DEGREE, time[-1])])
    rows = slice(DEGREE, count)  # those that are 0 with their slopes at both ends

    def basis(at: Array) -> Any:
        return BSpline.design_matrix(at, knots, DEGREE).T.tocsr()[rows]

    # The slope is the difference of two splines of a degree less by the distance of knots, which is the same inside the record.
    lower = BSpline.design_matrix(points, knots[1:-1], DEGREE - 1).T.tocsr()
    share = diags_array(np.tile(half * weights, count))
    spacing = breaks[1] - breaks[0]
    slopes = (lower[DEGREE - 1 : count - 1] - lower[DEGREE:count]) / spacing
    sampled = basis(time) @ diags_array(np.gradient(time))  # by the trapezoidal rule; at both ends the splines are 0
    bands = _bands((sampled @ sampled.T).tocsr(), DEGREE)
    return SmoothAngle(
        spline(points),
        spline(points, 1),
        spline(points, 2),
        basis(points) @ share,
        slopes @ share,
        sampled,
        cholesky_banded(bands, lower=True),
        noise,
    )


def _stroke(run: MeasuredRun, time: Array) -> float:
    """Time of a turn at the highest speed [s]."""
    low, high = run.speeds
    return 2 * np.pi / max(abs(low), abs(high))


def _fitted(run: MeasuredRun, time: Array) -> tuple[Any, float, float]:
    """Quintic spline with the knots for which generalised cross-validation expects the least error; its noise, distance of knots."""
    best, shortest, tried = None, FINEST * run.sampling, 0
    for knots in KNOTS:
        step = max(_stroke(run, time) / knots, shortest)
        pieces = max(int(np.ceil(time[-1] / step)), 2)
        if pieces == tried or pieces + 5 >= len(time):
            break
        spline, tried = _least_squares(time, run.angle, pieces), pieces
        left = float(((spline(time) - run.angle) ** 2).mean())
        free = 1 - (pieces + 5) / len(time)
        if best is None or left / free**2 < CLEARLY * best[0]:
            best = left / free**2, spline, np.sqrt(left / free), time[-1] / pieces
    if best is None:
        raise PinpressError(f"{run.name}: {len(time)} samples in {run.strokes:.3g} strokes are too few: sample faster")
    return best[1], float(best[2]), float(best[3])


def _least_squares(time: Array, angle: Array, pieces: int) -> Any:
    """The quintic spline of so many equal pieces that is nearest to the samples, refined once for the rounding of the normal equations."""
    from scipy.interpolate import BSpline  # to save start-up time
    from scipy.linalg import solveh_banded  # to save start-up time

    inner = np.linspace(0.0, time[-1], pieces + 1)
    knots = np.concatenate([np.zeros(5), inner, np.full(5, time[-1])])
    matrix = BSpline.design_matrix(time, knots, 5)
    bands = _bands((matrix.T @ matrix).tocsr(), 5)
    coefficients = np.zeros(pieces + 5)
    for _ in range(2):
        coefficients = coefficients + solveh_banded(bands, matrix.T @ (angle - matrix @ coefficients), lower=True)
    return BSpline(knots, coefficients, 5)


def _bands(matrix: Any, below: int) -> Array:
    """The diagonal of a symmetric sparse matrix and those below it, as SciPy's banded solvers take them."""
    bands = np.zeros((below + 1, matrix.shape[0]))
    for k in range(below + 1):
        diagonal = matrix.diagonal(-k)
        bands[k, : len(diagonal)] = diagonal
    return bands


@dataclass(frozen=True, eq=False, repr=False)
class Rows(Frozen):
    """Equations of one quantity of one run, in the order of the time; the noise of ``values`` is even and independent.

    Attributes:
        quantity: "torque", "current", "force x" and so on.
        columns: (rows, unknowns) by the unknowns.
        values: (rows,) of what was measured.
        known: (rows,) of what is known of it.
    """

    quantity: str
    columns: Array
    values: Array
    known: Array


def quantities(run: MeasuredRun) -> dict[str, Array]:
    """What a run measures beside the angle, by the names of `InertialEquations.coefficients`; a current stands for the torque."""
    found = {} if run.torque is None and run.current is None else {"torque": run.torque if run.current is None else run.current}
    found |= {f"force {axis}": values for axis, values in run.shaking_force.items()}
    found |= {f"moment {axis}": values for axis, values in run.shaking_moment.items()}
    return {name: values for name, values in found.items() if values is not None}


def blocks(count: int, most: int) -> NDArray[np.intp]:
    """The block of each of so many rows: up to ``most`` of equal length, in their order."""
    return np.arange(count) * min(most, count) // max(count, 1)
