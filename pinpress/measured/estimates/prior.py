"""What is looked for, and what is known of it before: masses, centres of mass and inertias about them, each within a share of itself.

Beside them are losses, of which nothing is known, and the reading of the encoder where the press is as drawn, which is off by some degrees.
What was weighed or gauged, the mass of the slide on a crane or of all links together, is one more equation each.

A link's uncertain numbers are its mass, its centre of mass (within a share of the radius of gyration) and its tensor about that. The
equations are linear in mass, first moments and inertia about the joint, which are products of these: their changes by one deviation of each
are taken at the present estimate. So a prior of a fifth never means a body that cannot be.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...common.arguments import number, numbers
from ...common.errors import PinpressError, UnknownNameError, shown
from ...common.frozen import FrozenMapping
from ...common.quantities import Array
from ...linkage.linkage import Linkage
from ..regressor import TENSOR, InertialEquations, Parameter, inertial_equations, loss_parameters

USUAL = 0.2  # share by which masses may be off where nothing is said
WIDEST = 10.0
ZERO = "encoder zero"
ZERO_DEVIATION = 0.1  # of the encoder's reading where the press is as drawn, where nothing is said [rad]
TOTAL = "total mass"
NOTHING: Mapping[str, tuple[float, float]] = FrozenMapping({})


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
    """What is looked for, in the order of columns, k unknowns.

    Attributes:
        equations: of masses and inertias.
        parameters: of these, then losses, then the encoder's zero.
        inertial: how many are masses and inertias.
        bodies: what is known of them.
        others: (k - inertial,) standard deviations before of the rest; infinite where nothing is known.
        weighed: (rows, k) of what was weighed or gauged, each by its standard deviation.
        weights: (rows,) what was found so, by its standard deviation.
    """

    equations: InertialEquations
    parameters: tuple[Parameter, ...]
    inertial: int
    bodies: tuple[BodyPrior, ...]
    others: Array
    weighed: Array
    weights: Array

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
        """(k,) standard deviations before the records; 0 of what is fixed, infinite where nothing is known."""
        return np.append(np.sqrt((self.at(np.zeros(self.inertial))[1] ** 2).sum(axis=1)), self.others)

    @property
    def zero(self) -> int:
        """Place of the encoder's zero."""
        return self.place(ZERO)

    @property
    def cylinder(self) -> tuple[int, int] | None:
        """Places of force and stiffness of the balance cylinder; None where there is none."""
        names = [each.name for each in self.parameters]
        return (self.place("cylinder force"), self.place("cylinder stiffness")) if "cylinder force" in names else None

    def about_zero(self, angle: float) -> Unknowns:
        """The same where the encoder's zero is about another angle [rad]."""
        own = self.parameters[self.zero]._replace(value=angle)
        return self._replace(parameters=tuple(own if each.name == ZERO else each for each in self.parameters))

    def place(self, name: str) -> int:
        """Place of the unknown of this name."""
        return [each.name for each in self.parameters].index(name)

    def scaled(self, sizes: Array) -> Array:
        """(k, k) changes of the unknowns, as described, by numbers about one; ``sizes``: (k - inertial,) those of the rest."""
        spread = np.diag(np.append(np.zeros(self.inertial), sizes))
        spread[: self.inertial, : self.inertial] = self.at(np.zeros(self.inertial))[1]
        return spread


def unknowns_of(
    press: Linkage, prior: float | Mapping[str, float], losses: Losses, known: Mapping[str, tuple[float, float]] = NOTHING
) -> Unknowns:
    """The unknowns of a press with their prior; ``known``: value and standard deviation of what was weighed or gauged, by its name.

    Raises:
        PinpressError: several drivers, or a prior that makes no sense.
        UnknownNameError: a prior of a link that does not exist, or something known of a parameter that is not looked for.
    """
    equations = inertial_equations(press)
    lost = loss_parameters(losses.friction, losses.cylinder, losses.radii is not None)
    more = (*lost, Parameter(ZERO, "rad", 0.0, 0.0))
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
        raise PinpressError(f"prior is {shares.max():g}: give a share, such as 0.2 for masses that may be off by a fifth")
    bodies, start = [], 0
    for body, basis in enumerate(equations.bases, 1):
        own = shares[start : start + basis.shape[1]]
        bodies.append(_described(press.model.inertias[body], basis, own))
        start += basis.shape[1]
    parameters = (*equations.parameters, *more)
    others = np.append(np.full(len(lost), np.inf), ZERO_DEVIATION)
    found = Unknowns(equations, parameters, len(names), tuple(bodies), others, *_weighed(parameters, known))
    for name, row in zip(known, found.weighed, strict=True):
        if not (found.deviation[row != 0] > 0).any():
            raise PinpressError(
                f"{name} is given in known, but the description of {press.name} has 0 for it, and 0 stays: describe it first"
            )
    return found


def _weighed(parameters: tuple[Parameter, ...], known: Mapping[str, tuple[float, float]]) -> tuple[Array, Array]:
    """(rows, unknowns) and (rows,) of what is known of unknowns, each by its standard deviation."""
    names = [each.name for each in parameters]
    rows, values = np.zeros((len(known), len(names))), np.zeros(len(known))
    for k, (name, given) in enumerate(known.items()):
        if name not in (*names, TOTAL):
            raise UnknownNameError("parameter", name, [*names, TOTAL])
        parts = [each for each in range(len(names)) if names[each] == name or (name == TOTAL and names[each].endswith(" mass"))]
        value, deviation = numbers(f"known {name}", given, (2,), unit=parameters[parts[0]].unit)
        if deviation <= 0 or (name.endswith("mass") and value <= 0):
            both = ", both above 0, as (2200.0, 5.0)" if name.endswith("mass") else " above 0, as (0.0, 0.001)"
            raise PinpressError(f"known {name} is {shown(given)}: give value and standard deviation{both}")
        rows[k, parts], values[k] = 1 / deviation, value / deviation
    return rows, values


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
