"""What bodies of a plane and bodies in space have in common: their springs, and what is asked of their geometry."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from ....common.quantities import Array
from ....kinematics.motion import Motion
from ..panels import Indices


class Springs(NamedTuple):
    """What pulls along the S lines of a geometry.

    Attributes:
        stiffness: (S,) [N/m; N m/rad where the line is a turn].
        damping: (S,) [N s/m or N m s/rad].
        rest: (S,) extensions at which they are slack [m].
        bearing: (S,) number of the bearing of each; -1: the columns of a crown, or mounts.
        sign: (S,) 1 where the pull on the second body is the force of the bearing, -1 where it is its opposite, 0 where the line is a turn.
    """

    stiffness: Array
    damping: Array
    rest: Array
    bearing: Indices
    sign: Array


class LinearSprings(NamedTuple):
    """Springs whose extensions are linear in the coordinates, T of them.

    Attributes:
        rows: (T, k) gradients of the extensions.
        stiffness: (T,) [N m/rad; of shapes N/m].
        damping: (T,) [N m s/rad; of shapes N s/m].
        shared: (T,) 1 where the damper goes with those of all other springs, 0 where it is the part's own.
        parts: (T,) name of the part of each.
    """

    rows: Array
    stiffness: Array
    damping: Array
    shared: Array
    parts: tuple[str, ...]


class BodyState(Protocol):
    """Bodies at n states, as their geometry turns them.

    Attributes:
        coordinates: (n, k) of all bodies.
        rates: (n, k).
    """

    @property
    def coordinates(self) -> Array: ...

    @property
    def rates(self) -> Array: ...


class Strains(Protocol):
    """The lines of a geometry at n states.

    Attributes:
        extension: (n, S) from the drawn pose [m].
        opening: (n, S) rates of the extensions [m/s].
    """

    @property
    def extension(self) -> Array: ...

    @property
    def opening(self) -> Array: ...


class PointMotion(NamedTuple):
    """A point of a body at n states, in d directions: two in a plane, three in space.

    Attributes:
        place: (n, d) [m].
        by: (n, k, d) its derivatives by all coordinates.
        columns: (t,) coordinates that turn the body.
        by_turns: (n, t, t, d) its second derivatives by these; the others are zero.
    """

    place: Array
    by: Array
    columns: Indices
    by_turns: Array

    def twice(self, direction: Array) -> Array:
        """(n, k, k) second derivatives of the place along directions (d,) or (n, d)."""
        second = np.zeros((*self.by.shape[:2], self.by.shape[1]))
        second[:, self.columns[:, None], self.columns] = (self.by_turns @ direction[..., None, :, None])[..., 0]
        return second


class VaryingInertia(NamedTuple):
    """Inertia forces that a constant mass matrix leaves out, at n states.

    Attributes:
        force: (n, k) or (n, f).
        by_place: (n, k, k) its derivatives by coordinates.
        by_rate: by rates.
        by_acceleration: by accelerations.
    """

    force: Array
    by_place: Array
    by_rate: Array
    by_acceleration: Array


class Geometry(Protocol):
    """Bodies and the lines between them; k is the number of coordinates of all bodies, S that of the lines.

    Attributes:
        inertia: (k,) constant part of the mass matrix, which is diagonal [kg, kg m2].
        weight: (k,) generalised forces of gravity [N].
        base: the body of the frame, where it stands on mounts; None: it is fixed.
        constant_mass: whether no inertia forces depend on the state.
    """

    @property
    def inertia(self) -> Array: ...

    @property
    def weight(self) -> Array: ...

    @property
    def base(self) -> int | None: ...

    @property
    def constant_mass(self) -> bool: ...

    def state(self, coordinates: Array, rates: Array, derivatives: bool = True) -> Any:
        """The bodies at coordinates and rates (n, k); ``derivatives``: whether second derivatives will be asked for."""

    def strains(self, state: Any) -> Any:
        """`Strains` of the lines."""

    def gradient(self, strains: Any) -> Array:
        """(n, S, k) gradients of the extensions."""

    def gradient_rate(self, strains: Any) -> Array:
        """(n, S, k) rates of the gradients, which are the gradients of the rates of the extensions."""

    def bend(self, strains: Any, pull: Array) -> Array:
        """(n, k, k): second derivatives of the extensions times the pulls (n, S), summed."""

    def along(self, strains: Any) -> Array:
        """(n, S, 3) directions of the lines in world axes."""

    def with_lines(self, kept: Any) -> Any:
        """The same bodies with some of the lines: their numbers, or whether each is kept (S,)."""

    def point(self, state: Any, body: int, arm: Any) -> PointMotion:
        """A point of a body, by its arm from the centre of mass in the axes of the geometry."""

    def varying_inertia(self, state: Any, accelerations: Array) -> VaryingInertia:
        """Inertia forces on all coordinates at accelerations (n, k), without those of the constant part."""

    def kinetic_energy(self, state: Any) -> Array:
        """(n,) of all bodies [J]."""

    def total(self, forces: Array, body: int | None = None) -> Array:
        """Sum (n, 3) in world axes of forces (n, k) on all bodies, or on one."""

    def rigid(self, motion: Motion) -> tuple[Array, Array, Array]:
        """All coordinates, rates and accelerations (n, k) of the rigid press in a motion."""

    def crank(self, values: Array) -> Array:
        """Angle, speed or acceleration (n,) of the crank's joint, of coordinates, rates or accelerations (n, k)."""

    def displacement(self, coordinates: Array, motion: Motion) -> Array:
        """Displacements of all moving links from the rigid press in a motion, as in `ElasticRun`."""


def in_columns(kind: Any, rows: Sequence[tuple[Any, ...]]) -> Any:
    """Lines or springs of a kind, of which at least one is given, from their rows."""
    return kind(*(np.array(column) for column in zip(*rows, strict=True)))
