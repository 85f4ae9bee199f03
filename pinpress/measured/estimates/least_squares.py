"""Estimates with their deviations from independent rows: Gauss-Newton method for the prior, cones of real bodies, and two covariances.

The equations are linear in masses, first moments and inertias about the joints, so many rows become one triangle at once. The prior
concerns mass, centre of mass and inertia about the centre of mass (`prior`). The equations are not linear in these numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...common.errors import PinpressError
from ...common.quantities import Array
from ..regressor import Parameter
from .cones import within_cones
from .prior import Unknowns
from .weak_form import Rows

VAGUE = 30.0  # prior standard deviation of a loss, as a multiple of the loss that alone gives the rms torque


class Fit(NamedTuple):
    """Estimates of all unknowns, in their units.

    Attributes:
        values: (unknowns,) estimates.
        posterior: (unknowns, unknowns) covariance of the Gaussian posterior.
        sandwich: (unknowns, unknowns) covariance by the residuals of blocks of time.
        learnt: trace of information / (information + prior).
        misfit: sum of squares of (change / prior deviation) of masses and inertias, and the number of these changes that records and
            weighed values determine.
        noise: quantity -> standard deviation of one sample.
        weight: (unknowns,) rms torque for one unit of each unknown / measured rms torque.
        constant: motor constant and its deviation; None if torques were measured.
    """

    values: Array
    posterior: Array
    sandwich: Array
    learnt: float
    misfit: tuple[float, float]
    noise: Mapping[str, float]
    weight: Array
    constant: tuple[float, float] | None = None

    @property
    def deviation(self) -> Array:
        """(unknowns,) the larger of both standard deviations."""
        return np.maximum(deviations(self.posterior), deviations(self.sandwich))


def deviations(covariance: Array) -> Array:
    """(unknowns,) standard deviations: zero for a variance that rounding made negative, as happens for exactly known values."""
    return np.sqrt(np.maximum(np.diag(covariance), 0.0))


def fitted(unknowns: Unknowns, rows: Sequence[Rows], current: bool) -> Fit:
    """Estimates from the rows of all runs; ``current``: whether these are currents in place of torques."""
    parts = {name: [row[1:] for row in rows if row.quantity == name] for name in dict.fromkeys(row.quantity for row in rows)}
    joined = {name: Rows(name, *map(np.concatenate, zip(*each, strict=True))) for name, each in parts.items()}
    return _fitted_to_currents(unknowns, joined) if current else _fitted(unknowns, joined)


def _fitted(unknowns: Unknowns, rows: Mapping[str, Rows]) -> Fit:
    inertial, count = unknowns.inertial, len(unknowns.parameters)
    start = np.array([each.value for each in unknowns.parameters])
    targets = {name: row.values - row.known - row.columns @ start for name, row in rows.items()}
    torque = rows.get("torque")
    rms = 1.0 if torque is None else float(np.sqrt((torque.values**2).mean()))
    weight = np.zeros(count) if torque is None else np.sqrt((torque.columns**2).mean(axis=0)) / rms

    # The unknowns are scaled by their prior deviations; a loss, by the value with which it alone gives the rms torque.
    priors = unknowns.deviation
    vague = ~np.isfinite(priors)
    sizes = np.where(vague, np.divide(1.0, weight, out=np.zeros(count), where=weight > 0), priors)
    moving = np.append(unknowns.scatter[:inertial], sizes[inertial:]) > 0
    information = np.diag(np.where(vague, VAGUE, 1.0)[moving] ** -2)
    change = np.zeros(count)

    def scaled(change: Array) -> tuple[Array, Array]:
        """Values (unknowns,) after a change, and their slopes (unknowns, k) by the scaled unknowns."""
        values, spread = unknowns.at(change[:inertial])
        slopes = np.diag(sizes)
        slopes[:inertial, :inertial] = spread
        return np.concatenate([values, (start + sizes * change)[inertial:]]), slopes[:, moving]

    # the triangle has few rows and the same least-squares solution as all rows
    short = {name: np.asarray(np.linalg.qr(np.column_stack([row.columns, targets[name]]), mode="r")) for name, row in rows.items()}
    noise = {name: _noise(each[:, :-1] @ scaled(change)[1], each[:, -1], len(targets[name])) for name, each in short.items()}
    joined = np.concatenate([short[name] / noise[name] for name in rows])
    triangle, goal = joined[:, :-1], joined[:, -1]
    for _ in range(20):
        values, spread = scaled(change)
        left = np.concatenate([goal - triangle @ (values - start), unknowns.weights - unknowns.weighed @ values])
        step, covariance = _step(np.concatenate([triangle, unknowns.weighed]) @ spread, left, information, change[moving])
        change[moving] += step
        if (np.abs(step) <= 1e-4 * np.sqrt(np.diag(covariance))).all():
            break

    values, spread = scaled(change)
    estimate = within_cones(unknowns, values, spread, covariance)
    before = information + (unknowns.weighed @ spread).T @ (unknowns.weighed @ spread)
    system = np.concatenate([row.columns / noise[name] for name, row in rows.items()])
    left = np.concatenate([targets[name] / noise[name] for name in rows]) - system @ (values - start)
    posterior, sandwich = (spread @ each @ spread.T for each in (covariance, _sandwich(system @ spread, left, before, covariance)))
    masses = np.flatnonzero(moving) < inertial
    learnt = float(np.trace(np.eye(len(before)) - covariance @ before))
    misfit = float((change[moving][masses] ** 2).sum()), float((1 - np.diag(covariance))[masses].sum())
    return Fit(estimate, posterior, sandwich, learnt, misfit, noise, weight)


def _noise(matrix: Array, target: Array, count: int) -> float:
    """Standard deviation of one of ``count`` samples, from the part of the samples that no values of the unknowns explain."""
    sizes = np.linalg.norm(matrix, axis=0)
    directions, values, _ = np.linalg.svd(matrix[:, sizes > 0] / sizes[sizes > 0], full_matrices=False)
    directions = directions[:, values > 1e-9 * values[0]]
    left = target - directions @ (directions.T @ target)
    freedom = max(count - directions.shape[1], 1)
    return max(float(np.sqrt((left**2).sum() / freedom)), 1e-13 * float(np.abs(target).max()), 1e-300)


def _step(system: Array, target: Array, information: Array, change: Array) -> tuple[Array, Array]:
    """One step of least squares with independent rows, and its covariance. The prior, with diagonal information (k, k), is centred at zero
    change."""
    root = np.sqrt(information)
    orthogonal, triangle = np.linalg.qr(np.concatenate([system, root]))
    inverse = np.linalg.solve(triangle, np.eye(len(triangle)))
    return inverse @ (orthogonal.T @ np.concatenate([target, -root @ change])), inverse @ inverse.T


def _sandwich(system: Array, left: Array, information: Array, covariance: Array) -> Array:
    """Sandwich covariance from the sums of residuals x columns over 60 blocks of time, which include the correlation of rows."""
    blocks = min(60, len(left))
    starts = -(-np.arange(blocks) * len(left) // blocks)
    sums = np.add.reduceat(system * left[:, None], starts, axis=0)
    return np.asarray(covariance @ (sums.T @ sums + information) @ covariance)


def _fitted_to_currents(unknowns: Unknowns, rows: Mapping[str, Rows]) -> Fit:
    """`_fitted` for currents i = (columns @ x + known) / k.

    The relative error of 1/k is one more unknown. Its column is the torque of the last estimate. The measured torque would add its noise to
    the column and bias k to small values.
    """
    torque = rows["torque"]
    estimate = np.array([each.value for each in unknowns.parameters])
    expected = torque.columns @ estimate + torque.known
    constant = float(expected @ expected / (expected @ torque.values))
    if constant <= 0:
        raise PinpressError("the currents and the torque of this press have opposite signs: change the sign of the ratio")
    more = unknowns._replace(
        parameters=(*unknowns.parameters, Parameter("motor constant", "-", 0.0, 0.0)),
        scatter=np.append(unknowns.scatter, np.inf),
        weighed=np.column_stack([unknowns.weighed, np.zeros(len(unknowns.weights))]),
    )
    for _ in range(12):
        columns = {name: np.column_stack([row.columns, np.zeros(len(row.values))]) for name, row in rows.items()}
        columns["torque"][:, -1] = torque.columns @ estimate + torque.known
        scaled = {name: row._replace(columns=columns[name]) for name, row in rows.items()}
        scaled["torque"] = scaled["torque"]._replace(values=constant * torque.values)
        fit = _fitted(more, scaled)
        estimate = fit.values[:-1]
        constant /= 1 + float(fit.values[-1])
        if abs(fit.values[-1]) < 1e-4 * fit.deviation[-1]:
            break
    return fit._replace(
        values=estimate,
        posterior=fit.posterior[:-1, :-1],
        sandwich=fit.sandwich[:-1, :-1],
        weight=fit.weight[:-1],
        noise={name: size / constant if name == "torque" else size for name, size in fit.noise.items()},
        constant=(constant, constant * float(fit.deviation[-1])),
    )
