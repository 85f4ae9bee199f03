"""What is looked for, and what is known of it before: masses, centres of mass and inertias about them, each within a share of itself.

A link's uncertain numbers are its mass, its centre of mass (within a share of the radius of gyration) and its tensor about that. The
equations are linear in mass, first moments and inertia about the joint, which are products of these: their changes by one deviation of each
are taken at the present estimate. So a prior of a fifth never means a body that cannot be.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...common.arguments import number
from ...common.errors import PinpressError, UnknownNameError
from ...common.quantities import Array
from ...linkage.linkage import Linkage
from ..regressor import TENSOR, InertialEquations, Parameter, inertial_equations, loss_parameters

USUAL = 0.2  # share by which masses may be off where nothing is said
WIDEST = 10.0


class Losses(NamedTuple):
    """Which losses are looked for; see `identify`."""

    friction: tuple[str, ...]
    cylinder: bool
    radii: Mapping[str, float] | None


class BodyPrior(NamedTuple):
    """A body as described.

    Attributes:
        described: (k,) mass, centre of mass, and inertia about it: of a planar press in its plane (4), else in space (10).
        deviation: (k,) standard deviations of these; 0 of what is fixed.
    """

    described: Array
    deviation: Array

    def at(self, change: Array) -> tuple[Array, Array]:
        """(k,) mass, first moments and inertias about the joint, and (k, k) their changes by one deviation of each number, where these
        are so many deviations (k,) off."""
        return (_plane_body if len(change) == 4 else _space_body)(self.described + self.deviation * change, self.deviation)


class Unknowns(NamedTuple):
    """What is looked for, in the order of columns.

    Attributes:
        equations: of masses and inertias.
        parameters: of these, then losses.
        inertial: how many are masses and inertias.
        bodies: what is known of them.
    """

    equations: InertialEquations
    parameters: tuple[Parameter, ...]
    inertial: int
    bodies: tuple[BodyPrior, ...]

    def at(self, change: Array) -> tuple[Array, Array]:
        """(inertial,) masses and inertias, and (inertial, inertial) their changes by deviations, at a change in deviations (inertial,)."""
        values, spread, start = np.zeros(self.inertial), np.zeros((self.inertial, self.inertial)), 0
        for body in self.bodies:
            own = slice(start, start + len(body.described))
            values[own], spread[own, own] = body.at(change[own])
            start = own.stop
        return values, spread

    @property
    def deviation(self) -> Array:
        """(inertial,) standard deviations before the records; 0 of what is fixed."""
        return np.asarray(np.sqrt((self.at(np.zeros(self.inertial))[1] ** 2).sum(axis=1)))


def unknowns_of(press: Linkage, prior: float | Mapping[str, float], losses: Losses) -> Unknowns:
    """The unknowns of a press with their prior.

    Raises:
        PinpressError: several drivers, or a prior that makes no sense.
        UnknownNameError: a prior of a link that does not exist.
    """
    equations = inertial_equations(press)
    more = loss_parameters(losses.friction, losses.cylinder, losses.radii is not None)
    names = [each.name for each in equations.parameters]
    shares = np.full(len(names), USUAL)
    if isinstance(prior, Mapping):
        for name, share in prior.items():
            there = [k for k, full in enumerate(names) if name == full or full.startswith(f"{name} ")]
            if not there:
                raise UnknownNameError("link or parameter", name, [*press.links, *names])
            shares[there] = number(f"prior of {name}", share, positive=True)
    else:
        shares[:] = number("prior", prior, positive=True)
    if shares.max() > WIDEST:
        raise PinpressError(f"prior is {shares.max():g}: give a share, such as 0.2 for masses that may be a fifth off")
    bodies, start = [], 0
    for body, basis in enumerate(equations.bases, 1):
        own = shares[start : start + basis.shape[1]]
        bodies.append(_described(press.model.inertias[body], basis, own))
        start += basis.shape[1]
    return Unknowns(equations, (*equations.parameters, *more), len(names), tuple(bodies))


def _described(inertia: object, basis: Array, shares: Array) -> BodyPrior:
    """A body with relative deviations of mass, centre of mass and tensor."""
    mass, lever, central = float(inertia.mass), inertia.lever, inertia.inertia  # type: ignore[attr-defined]
    if basis.shape[1] == 10:
        arm = math.sqrt(np.trace(central) / 2 / mass) if mass > 0 else 0.0
        sizes = np.sqrt(np.maximum(np.diag(central), 0.0))
        across = _six(np.outer(sizes, sizes) * (0.5 + 0.5 * np.eye(3)))
        return BodyPrior(np.array([mass, *lever, *_six(central)]), shares * np.array([mass, arm, arm, arm, *across]))
    first, second = basis[1:4, 1], basis[1:4, 2]
    normal = np.cross(first, second)
    turning = max(float(normal @ central @ normal), 0.0)
    arm = math.sqrt(turning / mass) if mass > 0 else 0.0
    return BodyPrior(np.array([mass, first @ lever, second @ lever, turning]), shares * np.array([mass, arm, arm, turning]))


def _plane_body(own: Array, deviation: Array) -> tuple[Array, Array]:
    mass, x, y, turning = own
    rates = np.array([[1.0, 0, 0, 0], [x, mass, 0, 0], [y, 0, mass, 0], [x * x + y * y, 2 * mass * x, 2 * mass * y, 1.0]])
    return np.array([mass, mass * x, mass * y, turning + mass * (x * x + y * y)]), rates * deviation


def _space_body(own: Array, deviation: Array) -> tuple[Array, Array]:
    mass, lever, rates, axes = own[0], own[1:4], np.eye(10), np.eye(3)
    square = _six(lever @ lever * axes - np.outer(lever, lever))
    rates[1:4, 0], rates[4:, 0] = lever, square
    for k in range(3):
        rates[1 + k, 1 + k] = mass
        rates[4:, 1 + k] = mass * _six(2 * lever[k] * axes - np.outer(axes[k], lever) - np.outer(lever, axes[k]))
    return np.array([mass, *(mass * lever), *(own[4:] + mass * square)]), rates * deviation


def _six(tensor: Array) -> Array:
    return np.array([tensor[i, j] for i, j in TENSOR])
