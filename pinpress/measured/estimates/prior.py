"""The unknowns of a press and their prior: masses, centres of mass, inertias, losses, the encoder's zero.

The uncertain numbers of a link are its mass, its centre of mass (within a share of the radius of gyration) and its tensor about the centre
of mass. The equations are linear in mass, first moments and inertias about the joint, which are products of these numbers. So the equations
use the changes of the parameters by one deviation of each number, at the present estimate. Then a prior of a fifth never describes an
impossible body.

Losses have no prior. The encoder's zero, which is its reading in the drawn pose, is known within some degrees. A weighed or
gauged value, such as the mass of the slide or of all links together, is one more equation.
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

USUAL = 0.2  # relative deviation of masses and inertias if the prior does not give another
ZERO = "encoder zero"
ZERO_DEVIATION = 0.1  # deviation of the encoder's zero if it is not given [rad]
TOTAL = "total mass"
NOTHING: Mapping[str, tuple[float, float]] = FrozenMapping({})


class Losses(NamedTuple):
    """The losses that are identified; see `identify`."""

    friction: tuple[str, ...]
    cylinder: bool
    radii: Mapping[str, float] | None


class Unknowns(NamedTuple):
    """The k unknowns of a press, in the order of columns: masses and inertias, losses, encoder zero.

    Attributes:
        equations: equations of masses and inertias.
        parameters: the unknowns.
        inertial: number of masses and inertias.
        described: (inertial,) mass, centre of mass and inertia about it of each body, as described.
        scatter: (k,) prior standard deviations: first of the described numbers, then of the other unknowns. It is 0 for fixed numbers
            and infinite if nothing is known.
        weighed: (rows, k) equations of weighed and gauged values, each divided by its standard deviation.
        weights: (rows,) these values, each divided by its standard deviation.
    """

    equations: InertialEquations
    parameters: tuple[Parameter, ...]
    inertial: int
    described: Array
    scatter: Array
    weighed: Array
    weights: Array

    def at(self, change: Array) -> tuple[Array, Array]:
        """Masses and inertias (inertial,), and their changes (inertial, inertial) by one deviation of each described number.

        Args:
            change: (inertial,) changes of the described numbers in deviations.
        """
        values, spread = np.zeros(self.inertial), np.zeros((self.inertial, self.inertial))
        scatter = self.scatter[: self.inertial]
        for place in self.equations.places:
            values[place], slopes = about_joint((self.described + scatter * change)[place])
            spread[place, place] = slopes * scatter[place]
        return values, spread

    @property
    def deviation(self) -> Array:
        """(k,) prior standard deviations of the unknowns; 0 for fixed unknowns, infinite without a prior."""
        masses = self.at(np.zeros(self.inertial))[1]
        return np.append(np.sqrt((masses**2).sum(axis=1)), self.scatter[self.inertial :])

    @property
    def zero(self) -> int:
        """Place of the encoder's zero."""
        return self.place(ZERO)

    def place(self, name: str) -> int:
        """Place of the unknown of this name."""
        return [each.name for each in self.parameters].index(name)

    @property
    def cylinder(self) -> tuple[int, int] | None:
        """Places of force and stiffness of the balance cylinder; None without a cylinder."""
        names = [each.name for each in self.parameters]
        return (self.place("cylinder force"), self.place("cylinder stiffness")) if "cylinder force" in names else None

    def about_zero(self, angle: float) -> Unknowns:
        """The same unknowns, with another prior mean of the encoder's zero [rad]."""
        return self._replace(parameters=tuple(each._replace(value=angle) if each.name == ZERO else each for each in self.parameters))

    def scaled(self, sizes: Array) -> Array:
        """(k, k) derivatives of the unknowns by the scaled unknowns, at the described values; ``sizes``: (k - inertial,) sizes of the other
        unknowns."""
        spread = np.diag(np.append(np.zeros(self.inertial), sizes))
        spread[: self.inertial, : self.inertial] = self.at(np.zeros(self.inertial))[1]
        return spread


def unknowns_of(
    press: Linkage, prior: float | Mapping[str, float], losses: Losses, known: Mapping[str, tuple[float, float]] = NOTHING
) -> Unknowns:
    """The unknowns of a press with their prior; ``known``: name -> weighed or gauged value and its standard deviation.

    Raises:
        PinpressError: the press has several drivers, or a prior makes no sense.
        UnknownNameError: the press has no link or unknown of this name.
    """
    equations = inertial_equations(press)
    lost = loss_parameters(losses.friction, losses.cylinder, losses.radii is not None)
    parameters = (*equations.parameters, *lost, Parameter(ZERO, "rad", 0.0, 0.0))
    names = [each.name for each in equations.parameters]
    shares = np.full(len(names), USUAL)
    if isinstance(prior, Mapping):
        for name, share in prior.items():
            places = [k for k, full in enumerate(names) if name == full or full.startswith(f"{name} ")]
            if not places:
                raise UnknownNameError("link or parameter", name, [*press.links, *names])
            shares[places] = number(f"prior of {name}", share, positive=True)
    else:
        shares[:] = number("prior", prior, positive=True)
    if shares.max() > 10:
        raise PinpressError(f"prior is {shares.max():g}: give a share, such as 0.2 for masses that may be off by a fifth")
    bodies = [_body(inertia, basis) for inertia, basis in zip(press.model.inertias.tolist()[1:], equations.bases, strict=True)]
    described = np.concatenate([values for values, _ in bodies])
    scatter = np.concatenate([shares * np.concatenate([sizes for _, sizes in bodies]), np.full(len(lost), np.inf), [ZERO_DEVIATION]])
    unknowns = Unknowns(equations, parameters, len(names), described, scatter, *_weighed(parameters, known))
    for name, row in zip(known, unknowns.weighed, strict=True):
        if not (unknowns.deviation[row != 0] > 0).any():
            raise PinpressError(
                f"{name} is given in known, but the description of {press.name} has 0 for it, and 0 stays: describe it first"
            )
    return unknowns


def _weighed(parameters: tuple[Parameter, ...], known: Mapping[str, tuple[float, float]]) -> tuple[Array, Array]:
    """Equations (rows, unknowns) and values (rows,) of weighed and gauged unknowns, each divided by its standard deviation."""
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


def _body(inertia: object, basis: Array) -> tuple[Array, Array]:
    """Mass, centre of mass and inertia about it (k,), and the sizes (k,) to which their relative deviations refer."""
    mass, lever, central = float(inertia.mass), inertia.lever, inertia.inertia  # type: ignore[attr-defined]
    if basis.shape[1] == 10:
        arm = math.sqrt(np.trace(central) / 2 / mass) if mass > 0 else 0.0
        sizes = np.sqrt(np.maximum(np.diag(central), 0.0))
        across = _six(np.outer(sizes, sizes) * (0.5 + 0.5 * np.eye(3)))
        return np.array([mass, *lever, *_six(central)]), np.array([mass, arm, arm, arm, *across])
    first, second = basis[1:4, 1], basis[1:4, 2]
    normal = np.cross(first, second)
    turning = max(float(normal @ central @ normal), 0.0)
    arm = math.sqrt(turning / mass) if mass > 0 else 0.0
    return np.array([mass, first @ lever, second @ lever, turning]), np.array([mass, arm, arm, turning])


def about_joint(own: Array) -> tuple[Array, Array]:
    """Mass, first moments and inertias of a body about its joint (k,), and their slopes (k, k).

    Args:
        own: (k,) mass, centre of mass, and inertia about it: four numbers in the plane, ten in space.
    """
    axes = np.eye(2 if len(own) == 4 else 3)
    mass, lever, end = own[0], own[1 : 1 + len(axes)], 1 + len(axes)
    square, slopes = _of_points(lever, lever), np.eye(len(own))
    slopes[1:end, 0], slopes[end:, 0] = lever, square
    slopes[1:end, 1:end] = mass * axes
    slopes[end:, 1:end] = np.stack([2 * mass * _of_points(lever, axis) for axis in axes], axis=1)
    return np.concatenate([[mass], mass * lever, own[end:] + mass * square]), slopes


def _of_points(a: Array, b: Array) -> Array:
    """Inertia of a unit mass at a for a = b; otherwise the corresponding bilinear form: one number in the plane, six in space."""
    return np.array([a @ b]) if len(a) == 2 else _six(a @ b * np.eye(3) - 0.5 * (np.outer(a, b) + np.outer(b, a)))


def _six(tensor: Array) -> Array:
    return np.array([tensor[i, j] for i, j in TENSOR])
