"""Estimates with their deviations from whitened rows: Gauss and Newton's method for the prior, cones of real bodies, and two covariances.

The equations are linear in masses, first moments and inertias about the joints, so that many rows are turned into one triangle at once;
what is known before concerns mass, centre of mass and inertia about that (`prior`), in which they are not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...common.errors import PinpressError
from ...common.quantities import Array
from ..regressor import Parameter
from .cones import Solved, within_cones
from .prior import Unknowns
from .weak_form import Rows, blocks

BLOCKS = 60  # of time, whose sums of squares show how far rows depend on each other
VAGUE = 30.0  # prior standard deviation of a loss, in rms torques that it makes alone
STEPS = 20  # of Gauss and Newton
SETTLED = 1e-4  # deviations by which an estimate may change in the last step
PASSES = 12  # of the motor constant


class Fit(NamedTuple):
    """Estimates of all unknowns, in their units.

    Attributes:
        values: (unknowns,).
        posterior: (unknowns, unknowns) covariance of the Gaussian posterior.
        sandwich: (unknowns, unknowns) covariance by blocks of time.
        learnt: trace of information / (information + prior).
        misfit: square of the changes of masses and inertias by their prior deviations, and how many were learnt, by scales too.
        noise: by quantity the standard deviation of one sample.
        weight: (unknowns,) rms torque that one unit of each makes, by the rms of what was measured.
        constant: motor constant and its deviation; None where torques were measured.
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
    """(unknowns,) standard deviations: zero where rounding made a variance negative, as of what is known before to rounding."""
    return np.sqrt(np.maximum(np.diag(covariance), 0.0))


def fitted(unknowns: Unknowns, rows: Sequence[Rows], current: bool) -> Fit:
    """Estimates from the rows of all runs; ``current``: whether these are currents in place of torques."""
    names = list(dict.fromkeys(row.quantity for row in rows))
    gathered = {name: [row for row in rows if row.quantity == name] for name in names}
    joined = {
        name: Rows(
            name,
            np.concatenate([row.columns for row in gathered[name]]),
            np.concatenate([row.values for row in gathered[name]]),
            np.concatenate([row.known for row in gathered[name]]),
        )
        for name in names
    }
    return _fitted_to_currents(unknowns, joined) if current else _fitted(unknowns, joined)


def _fitted(unknowns: Unknowns, rows: Mapping[str, Rows]) -> Fit:
    inertial, count = unknowns.inertial, len(unknowns.parameters)
    start = np.array([each.value for each in unknowns.parameters])
    targets = {name: row.values - row.known - row.columns @ start for name, row in rows.items()}
    torque = rows.get("torque")
    rms = 1.0 if torque is None else float(np.sqrt((torque.values**2).mean()))
    weight = np.zeros(count) if torque is None else np.sqrt((torque.columns**2).mean(axis=0)) / rms
    # All in numbers about one: deviations where something is known before, and losses that make the rms torque alone.
    priors = unknowns.deviation
    vague = ~np.isfinite(priors)
    sizes = np.where(vague, np.divide(1.0, weight, out=np.zeros(count), where=weight > 0), priors)
    moving = np.append(np.concatenate([each.deviation for each in unknowns.bodies]), sizes[inertial:]) > 0
    information = np.diag(np.where(vague, VAGUE, 1.0)[moving] ** -2)
    change = np.zeros(count)

    def turned(at: Array) -> tuple[Array, Array]:
        """(unknowns,) values there, and (unknowns, k) their changes by the numbers that are looked for."""
        values, spread = unknowns.at(at[:inertial])
        whole = np.diag(sizes)
        whole[:inertial, :inertial] = spread
        return np.concatenate([values, (start + sizes * at)[inertial:]]), whole[:, moving]

    # Few rows, whose least squares are those of all.
    short = {name: np.asarray(np.linalg.qr(np.column_stack([row.columns, targets[name]]), mode="r")) for name, row in rows.items()}
    noise = {name: _noise(each[:, :-1] @ turned(change)[1], each[:, -1], len(targets[name])) for name, each in short.items()}
    joined = np.concatenate([short[name] / noise[name] for name in rows])
    triangle, goal = joined[:, :-1], joined[:, -1]
    whole = np.concatenate([triangle, unknowns.weighed])
    for _ in range(STEPS):
        values, spread = turned(change)
        weighed = unknowns.weights - unknowns.weighed @ values
        left = np.concatenate([goal - triangle @ (values - start), weighed])
        solved = _solved(whole @ spread, left, information, change[moving])
        change[moving] += solved.change
        if (np.abs(solved.change) <= SETTLED * np.sqrt(np.diag(solved.covariance))).all():
            break
    values, spread = turned(change)
    found = within_cones(unknowns, values, spread, solved._replace(change=np.zeros(len(solved.change))))
    posterior = spread @ solved.covariance @ spread.T
    before = information + (unknowns.weighed @ spread).T @ (unknowns.weighed @ spread)
    system = np.concatenate([row.columns / noise[name] for name, row in rows.items()])
    left = np.concatenate([targets[name] / noise[name] for name in rows]) - system @ (values - start)
    sandwich = spread @ _sandwich(system @ spread, left, before, solved.covariance) @ spread.T
    masses = np.flatnonzero(moving) < inertial
    learnt = float(np.trace(np.eye(len(before)) - solved.covariance @ before))
    told = float((1 - np.diag(solved.covariance))[masses].sum())  # by records and scales
    return Fit(found, posterior, sandwich, learnt, (float((change[moving][masses] ** 2).sum()), told), noise, weight)


def _noise(matrix: Array, target: Array, count: int) -> float:
    """Standard deviation of one of so many samples, of what no choice of unknowns explains."""
    sizes = np.linalg.norm(matrix, axis=0)
    directions, values, _ = np.linalg.svd(matrix[:, sizes > 0] / sizes[sizes > 0], full_matrices=False)
    directions = directions[:, values > 1e-9 * values[0]]
    left = target - directions @ (directions.T @ target)
    freedom = max(count - directions.shape[1], 1)
    return max(float(np.sqrt((left**2).sum() / freedom)), 1e-13 * float(np.abs(target).max()), 1e-300)


def _solved(system: Array, target: Array, information: Array, change: Array) -> Solved:
    """One step of least squares of whitened rows, with priors about zero, (k, k) diagonal, of what has changed so far."""
    root = np.sqrt(information)
    stacked = np.concatenate([system, root])
    orthogonal, triangle = np.linalg.qr(stacked)
    inverse = np.linalg.solve(triangle, np.eye(len(triangle)))
    return Solved(inverse @ (orthogonal.T @ np.concatenate([target, -root @ change])), inverse @ inverse.T)


def _sandwich(system: Array, left: Array, information: Array, covariance: Array) -> Array:
    """Covariance by the sums of residuals x columns over blocks of time."""
    block = blocks(len(left), BLOCKS)
    starts = np.searchsorted(block, np.arange(block[-1] + 1))
    sums = np.add.reduceat(system * left[:, None], starts, axis=0)
    meat = sums.T @ sums + information
    return np.asarray(covariance @ meat @ covariance)


def _fitted_to_currents(unknowns: Unknowns, rows: Mapping[str, Rows]) -> Fit:
    """`_fitted` of currents i = (columns @ x + known) / k. What 1/k is off by is one more unknown, whose column is the torque expected of
    the last estimate: that measured would bring its noise in, and make k too small."""
    torque, whole = rows["torque"], slice(0, -1)
    estimate = np.array([each.value for each in unknowns.parameters])
    expected = torque.columns @ estimate + torque.known
    constant = float(expected @ expected / (expected @ torque.values))
    if constant <= 0:
        raise PinpressError("the currents and the torque of this press have opposite signs: change the sign of the ratio")
    more = unknowns._replace(
        parameters=(*unknowns.parameters, Parameter("motor constant", "-", 0.0, 0.0)),
        others=np.append(unknowns.others, np.inf),
        weighed=np.column_stack([unknowns.weighed, np.zeros(len(unknowns.weights))]),
    )
    for _ in range(PASSES):
        expected = torque.columns @ estimate + torque.known
        scaled = {name: _beside(row, constant, expected) for name, row in rows.items()}
        fit = _fitted(more, scaled)
        estimate = fit.values[whole]
        constant /= 1 + float(fit.values[-1])
        if abs(fit.values[-1]) < SETTLED * fit.deviation[-1]:
            break
    return fit._replace(
        values=fit.values[whole],
        posterior=fit.posterior[whole, whole],
        sandwich=fit.sandwich[whole, whole],
        weight=fit.weight[whole],
        noise={name: size / constant if name == "torque" else size for name, size in fit.noise.items()},
        constant=(constant, constant * float(fit.deviation[-1])),
    )


def _beside(row: Rows, constant: float, expected: Array) -> Rows:
    """Rows with the share by which the inverse of the motor constant is off as one more unknown."""
    if row.quantity != "torque":
        return Rows(row.quantity, np.column_stack([row.columns, np.zeros(len(row.values))]), row.values, row.known)
    return Rows(row.quantity, np.column_stack([row.columns, expected]), constant * row.values, row.known)
