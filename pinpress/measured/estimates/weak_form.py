"""Records as rows of linear equations without accelerations: the angle as a spline, the equation of motion weighted over time.

The angle is a quintic spline that fits the samples by least squares; the record decides how many knots a stroke it has. Each equation
(see `regressor`) is multiplied by B-splines phi over time and integrated by parts,

    integral of phi s dt  =  sum over p of  p integral of (-phi' A w - share phi A' w^2 + phi C) dt

so that only the first derivative of the angle is needed. Gauss's rule integrates the right side; the left side is a sum over the samples.
The noise of the samples makes the left sides correlated. The Cholesky factor of their covariance makes them independent.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...common.errors import PinpressError
from ...common.quantities import Array
from ..records import MeasuredRun
from ..regressor import Coefficients

DEGREE = 5  # degree of the weights; high enough that sums over samples are as accurate as integrals


class SmoothAngle(NamedTuple):
    """The angle of a record as a spline at the m points of Gauss's rule, and the weights of the equations.

    Attributes:
        angle: (m,) angles [rad].
        speed: (m,) speeds [rad/s].
        acceleration: (m,) accelerations [rad/s2].
        weighted: (rows, m) sparse: from values at the points to their integrals with each weight phi.
        slopes: (rows, m) sparse: the same with each phi'.
        sampled: (rows, n) sparse: from the n samples to their integrals with each phi.
        factor: banded Cholesky factor of the covariance of these integrals, for samples of variance 1.
        noise: standard deviation of the angle's samples from the spline [rad].
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
        """(rows, k) independent rows of values (m, k) at the points."""
        return self._independent(self.weighted @ values)

    def equations(self, coefficients: Coefficients) -> Array:
        """(rows, parameters) independent rows of an equation with these coefficients at the points."""
        inertia, slope, weight, share = coefficients
        speed = self.speed[:, None]
        return self._independent(-(self.slopes @ (inertia * speed)) + self.weighted @ (weight - share * slope * speed**2))

    def measured(self, samples: Array) -> Array:
        """(rows,) independent rows of measured samples (n,)."""
        return self._independent((self.sampled @ samples)[:, None])[:, 0]

    def without_offset(self, rows: Array) -> Array:
        """Independent rows, (rows,) or (rows, k), without the part that a constant offset of the samples can explain.

        Load cells are usually set to zero before a record, and the weight of the frame is not known.
        """
        constant = self.integrals(np.ones((len(self.angle), 1)))[:, 0]
        share = constant @ rows / (constant @ constant)
        return np.asarray(rows - (np.outer(constant, share) if rows.ndim > 1 else constant * share))

    def _independent(self, rows: Array) -> Array:
        from scipy.linalg.lapack import dtbtrs  # to save start-up time

        # LAPACK refuses an empty matrix
        return np.asarray(dtbtrs(self.factor, rows, uplo="L")[0]) if rows.size else np.zeros((self.factor.shape[1], 0))


def smoothed(run: MeasuredRun) -> SmoothAngle:
    """The angle of a record as a spline.

    Raises:
        PinpressError: the record is too short, or sampled too slowly.
    """
    from scipy.interpolate import BSpline  # to save start-up time
    from scipy.linalg import cholesky_banded
    from scipy.sparse import diags_array

    time = run.time - run.time[0]
    if run.strokes < 1.5:
        raise PinpressError(
            f"{run.name}: {run.strokes:.3g} strokes: one stroke does not separate masses from friction. Measure ten strokes at three speeds"
        )
    stroke = 2 * np.pi / max(map(abs, run.speeds))
    spline, noise, step = _fitted(run, time, stroke)

    # The weights are B-splines with at least 24 knots per stroke; only those that are zero with zero slope at both ends are used.
    count = max(int(np.ceil(time[-1] / min(step, stroke / 24))), 4 * DEGREE)
    breaks = np.linspace(0.0, time[-1], count + 1)
    spacing = breaks[1] - breaks[0]
    knots = np.concatenate([np.zeros(DEGREE), breaks, np.full(DEGREE, time[-1])])

    def basis(places: Array) -> Any:
        return BSpline.design_matrix(places, knots, DEGREE).T.tocsr()[DEGREE:count]

    nodes, weights = np.polynomial.legendre.leggauss(5)
    points = (breaks[:-1, None] + 0.5 * spacing * (1 + nodes)).ravel()
    share = diags_array(np.tile(0.5 * spacing * weights, count))
    # The slope is the difference of two splines of the next lower degree / knot distance, which is constant inside the record.
    lower = BSpline.design_matrix(points, knots[1:-1], DEGREE - 1).T.tocsr()
    slopes = (lower[DEGREE - 1 : count - 1] - lower[DEGREE:count]) / spacing
    sampled = basis(time) @ diags_array(np.gradient(time))  # by the trapezoidal rule; at both ends the splines are zero
    factor = cholesky_banded(_bands((sampled @ sampled.T).tocsr()), lower=True)
    return SmoothAngle(spline(points), spline(points, 1), spline(points, 2), basis(points) @ share, slopes @ share, sampled, factor, noise)


def _fitted(run: MeasuredRun, time: Array, stroke: float) -> tuple[Any, float, float]:
    """Quintic spline of the angle, its noise, and the distance of its knots.

    The number of knots is raised if generalised cross-validation predicts a clearly smaller error; ``stroke``: time of a turn at the
    highest speed.
    """
    best, tried = None, 0
    for knots in (6, 8, 12, 16, 24, 32, 48):  # knots per stroke
        step = max(stroke / knots, 4 * run.sampling)
        pieces = max(int(np.ceil(time[-1] / step)), 2)
        if pieces == tried or pieces + 5 >= len(time):
            break
        spline, tried = _least_squares(time, run.angle, pieces), pieces
        left = float(((spline(time) - run.angle) ** 2).mean())
        free = 1 - (pieces + 5) / len(time)
        if best is None or left / free**2 < 0.995 * best[0]:
            best = left / free**2, spline, np.sqrt(left / free), time[-1] / pieces
    if best is None:
        raise PinpressError(f"{run.name}: {len(time)} samples in {run.strokes:.3g} strokes are too few: sample faster")
    return best[1], float(best[2]), float(best[3])


def _least_squares(time: Array, angle: Array, pieces: int) -> Any:
    """The least-squares quintic spline with equal pieces; refined once to remove rounding errors of the normal equations."""
    from scipy.interpolate import BSpline  # to save start-up time
    from scipy.linalg import solveh_banded

    knots = np.concatenate([np.zeros(5), np.linspace(0.0, time[-1], pieces + 1), np.full(5, time[-1])])
    matrix = BSpline.design_matrix(time, knots, 5)
    bands = _bands((matrix.T @ matrix).tocsr())
    coefficients = np.zeros(pieces + 5)
    for _ in range(2):
        coefficients = coefficients + solveh_banded(bands, matrix.T @ (angle - matrix @ coefficients), lower=True)
    return BSpline(knots, coefficients, 5)


def _bands(matrix: Any) -> Array:
    """The diagonal of a symmetric sparse matrix and the five below it, as SciPy's banded solvers take them."""
    return np.stack([np.pad(matrix.diagonal(-k), (0, k)) for k in range(DEGREE + 1)])


class Rows(NamedTuple):
    """Equations of one quantity of one run, in the order of the time. The noise of ``values`` is white.

    Attributes:
        quantity: "torque", "force x" and so on; a current counts as a torque.
        columns: (rows, unknowns) columns of the unknowns.
        values: (rows,) measured values.
        known: (rows,) known parts of the values.
    """

    quantity: str
    columns: Array
    values: Array
    known: Array


def quantities(run: MeasuredRun) -> dict[str, Array]:
    """The measured quantities except the angle, by the names of `InertialEquations.coefficients`; a current counts as a torque."""
    effort = run.current if run.torque is None else run.torque
    forces = {f"force {axis}": values for axis, values in run.shaking_force.items()}
    moments = {f"moment {axis}": values for axis, values in run.shaking_moment.items()}
    return ({} if effort is None else {"torque": effort}) | forces | moments
