"""Limits of the process force: the forces that capacities of drivers and bearings permit.

At a given angle and speed the driving torque and every bearing force are affine in the process force F: R = R0 + F R1. R0 are the reactions
of the idle press. R1 are the reactions of the press with massless links to a force of 1 N. So no difference of large numbers is taken. A
capacity C permits the F at which |R0 + F R1| = C, a quadratic equation.

With friction this still holds for the process force alone, because friction grows in proportion to it. With weights, inertia forces and
springs the friction of bearings is no longer affine in F. Then |R| still crosses C once, and Newton's method within a bracket finds the
crossing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common.errors import PinpressError, shown
from ..common.numerics import bracketed_roots
from ..common.quantities import Array
from ..dynamics.reactions import Reactions
from ..linkage.linkage import Linkage

NOMINAL, TORQUE, DRIVING_FORCE, BEARING = "nominal force", "torque", "driving force", "bearing "
TIE = 1e-9  # relative difference up to which two limits count as equal
SAME = 1e-12  # relative rounding error between limits that are equal at every height


class Limit(NamedTuple):
    """A capacity of a driver or bearing.

    Attributes:
        name: name of the limit.
        what: the loaded part, as text.
        capacity: largest magnitude [N or N m].
        unit: unit of the capacity.
        reaction: function from reactions to the limited driving torque or bearing force (n, k).
    """

    name: str
    what: str
    capacity: float
    unit: str
    reaction: Callable[[Reactions], Array]

    def size(self, reactions: Reactions) -> Array:
        """Magnitudes (n,) in reactions."""
        return np.asarray(np.linalg.norm(self.reaction(reactions), axis=1))


def driver_limit(press: Linkage, driver: str, capacity: float, named: bool = False) -> Limit:
    """The limit of a driver; ``named``: whether the name of the limit contains the driver's name."""
    column = press.drivers.index(driver)
    coordinate = press.driver_coordinates[column]

    def effort(reactions: Reactions) -> Array:
        return reactions.driving_torque.reshape(len(reactions.driving_torque), -1)[:, [column]]

    name, what = TORQUE if coordinate.turns else DRIVING_FORCE, f"the driving {coordinate.effort}"
    if named:
        name, what = f"{name} {driver}", f"{what} of {shown(driver)}"
    return Limit(name, what, capacity, coordinate.effort_unit, effort)


def bearing_limit(name: str, capacity: float) -> Limit:
    """The limit of a bearing or guide."""

    def force(reactions: Reactions) -> Array:
        return reactions.bearing_force[name]

    return Limit(BEARING + name, f"the force in bearing {shown(name)}", capacity, "N", force)


def affine_forces(limits: Sequence[Limit], idle: Reactions | None, unit: Reactions) -> dict[str, Array]:
    """The forces (n,) that limits permit if all reactions are affine in the process force; infinite if a limit permits any force.

    Args:
        limits: the limits.
        idle: reactions without a process; None if the process force counts alone.
        unit: reactions of the press without masses to a process force of 1 N.
    """
    forces = {}
    for limit in limits:
        slope = limit.reaction(unit)
        forces[limit.name] = largest_factor(0 * slope if idle is None else limit.reaction(idle), slope, limit.capacity)
    return forces


def forces_with_friction(
    limits: Sequence[Limit], sizes: Callable[[Array], Array], nominal: Array, place: Callable[[int], str], *, single: bool = True
) -> dict[str, Array]:
    """The forces (n,) that limits permit if weights, inertia forces and springs cause friction too.

    A force is infinite if it is above twice the nominal force, which governs then. It is 0 if the idle press exceeds the capacity.

    Args:
        limits: the l limits.
        sizes: function from process forces (k, n) to the magnitudes (l, k, n) of all limited quantities in n states [N].
        nominal: (n,) nominal force [N].
        place: function from the number of a state to its name.
        single: whether to check that every smaller force is permitted too.

    Raises:
        PinpressError: friction locks the linkage, or a smaller force than a permitted force is not permitted.
    """
    count, own = len(limits), np.arange(len(limits))
    if not limits:
        return {}
    capacity, step = np.array([limit.capacity for limit in limits])[:, None, None], 1e-6 * nominal
    largest = np.tile(2.0 * nominal, (count, 1))
    idle, furthest = np.moveaxis(sizes(np.array([0 * nominal, 2.0 * nominal])) / capacity, 1, 0)
    limited = (idle < 1.0) & (furthest > 1.0)

    def missing(force: Array) -> tuple[Array, Array]:
        """Used shares of the capacities less 1, and their slopes; a function with another root in states without a limit."""
        force = force.reshape(largest.shape)
        both = sizes(np.concatenate([force, force + step])) / capacity
        share, beside = both[own, own], both[own, count + own]
        value, slope = np.where(limited, share - 1.0, force / largest - 0.5), np.where(limited, (beside - share) / step, 1.0 / largest)
        return value.ravel(), slope.ravel()

    force = largest
    if limited.any():
        force = bracketed_roots(missing, 0 * largest.ravel(), largest.ravel(), relative=SAME).reshape(largest.shape)
    for part in (0.25, 0.5, 0.75) if single else ():
        beyond = limited & ((sizes(part * force) / capacity)[own, own] > 1.0 + TIE)
        if beyond.any():
            limit, state = np.argwhere(beyond)[0]
            raise PinpressError(
                f"at {place(state)} there is no single permissible force with friction: '{limits[limit].name}' permits"
                f" {force[limit, state]:.6g} N, but not every smaller force. Find it without friction"
            )
    permitted = np.where(idle >= 1.0, 0.0, np.where(limited, force, np.inf))
    return {limit.name: each for limit, each in zip(limits, permitted, strict=True)}


def without_masses(press: Linkage) -> Linkage:
    """The press with massless links. Its reactions are the reactions to the loads alone."""
    return press.with_inertias([pin.Inertia.Zero()] * press.model.njoints)


def largest_factor(constant: Array, slope: Array, capacity: Array | float) -> Array:
    """Largest factors f (n,) with |constant + f slope| <= capacity, infinite if any factor is allowed.

    With the vectors k and s divided by the capacity, f is the root >= 0 of f^2 s.s + 2 f k.s + k.k - 1 = 0, in the form without
    cancellation.

    Args:
        constant: (n, k) vectors, whose magnitude is within the capacity.
        slope: (n, k) vectors.
        capacity: capacity, a number or (n,).
    """
    scale = np.reshape(capacity, (-1, 1))
    unit = np.abs(slope).max(axis=1, keepdims=True)
    unit = np.where(unit > 0, unit, 1.0)  # squares of small numbers underflow
    k, s = constant / scale, slope / unit
    square, half, free = np.sum(s * s, axis=1), np.sum(k * s, axis=1), np.maximum(1.0 - np.sum(k * k, axis=1), 0.0)
    root = np.sqrt(half**2 + square * free)
    with np.errstate(all="ignore"):  # the root that divides by zero is not used; free / 0 = infinity means no limit
        outwards = np.where((half + root > 0) | (free > 0), free / (half + root), np.inf)
        return np.where(half >= 0, outwards, (root - half) / square) * (scale / unit)[:, 0]


def governing_names(forces: Mapping[str, Array]) -> tuple[str, ...]:
    """Name of the limit with the smallest force in every state; the first of several limits that are equal within rounding error."""
    names, limits = list(forces), np.array(list(forces.values()))
    return tuple(names[k] for k in np.argmax(limits <= (1 + TIE) * limits.min(axis=0), axis=0))
