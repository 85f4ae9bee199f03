"""What motions on springs ask of a press, whether it stands in a plane (`sprung_press`) or in space (`in_space`).

Both describe a press by free coordinates, the last of which is the angle of the crank, or of the shaft behind it. Coordinates of all bodies
follow from them; only the press itself knows what they mean.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np

from ...common.errors import PinpressError
from ...common.quantities import Array
from ...kinematics.motion import Motion, motion_through_change_points
from ...kinematics.slide_path import dead_centres
from ...linkage.linkage import Linkage
from .contact import OpenPin
from .panels import VaryingInertia
from .preloaded_joint import OpenJoint


class SpringForces(NamedTuple):
    """Forces of the springs on the free coordinates at n states, and their derivatives.

    Attributes:
        force: (n, f) generalised forces [N, N m].
        stiffness: (n, f, f) minus d force / d coordinates; None where it is not asked for.
        damping: (n, f, f) minus d force / d rates; None where it is not asked for.
    """

    force: Array
    stiffness: Array | None
    damping: Array | None


class PathMotion(NamedTuple):
    """A length along which a load acts, at n states.

    Attributes:
        value: (n,) [m].
        rate: (n,) [m/s].
        gradient: (n, f) of the value by the free coordinates.
        bend: (n, f, f) its second derivatives.
    """

    value: Array
    rate: Array
    gradient: Array
    bend: Array


class JointMotion(NamedTuple):
    """A preloaded joint that may open, at n states.

    Attributes:
        joint: the joint.
        extension: (n,) positive where the joint is pulled [m].
        rate: (n,) of the extension [m/s].
        pull: (n,) of the spring and damper that always hold [N].
        along: (n, 3) direction of a force along the extension, parent on child or link1 on link2, in world axes.
    """

    joint: OpenJoint
    extension: Array
    rate: Array
    pull: Array
    along: Array


class LoadPath(Protocol):
    """A length of a press on springs along which a load acts. It knows its own kind of press."""

    def over(self, sprung: Any, coordinates: Array, rates: Array) -> PathMotion:
        """The path at all coordinates and rates (n, k)."""


class PressOnSprings(Protocol):
    """A press on springs; k is the number of coordinates of all bodies, f that of the free ones."""

    @property
    def press(self) -> Linkage:
        """The linkage."""

    @property
    def free(self) -> int:
        """Number of free coordinates."""

    @property
    def carry(self) -> Array:
        """(k, f) rates of the free coordinates to all rates."""

    @property
    def lowest_frequency(self) -> float:
        """Lowest natural frequency at bottom dead centre, with the crank held and without dampers [rad/s]."""

    @property
    def open_pins(self) -> tuple[OpenPin, ...]:
        """Pins with clearance."""

    @property
    def open_joints(self) -> tuple[OpenJoint, ...]:
        """Preloaded joints that may open."""

    @property
    def closed(self) -> Any:
        """The same press without clearance and with closed joints; None where it is the same."""

    def opening(self) -> Any:
        """The same press with preloaded joints that may open."""

    def joint_motions(self, coordinates: Array, rates: Array) -> list[JointMotion]:
        """The preloaded joints that may open."""

    def all_coordinates(self, free: Array) -> Array:
        """All coordinates (n, k) of free ones (n, f)."""

    def all_rates(self, rates: Array) -> Array:
        """Rates or accelerations (n, k) of all coordinates, of those (n, f) of the free ones."""

    def free_coordinates(self, coordinates: Array) -> Array:
        """Free coordinates (n, f) of all coordinates (n, k)."""

    def free_rates(self, rates: Array) -> Array:
        """Free rates or accelerations (n, f) of those of all coordinates (n, k)."""

    def rigid_coordinates(self, motion: Motion) -> tuple[Array, Array, Array]:
        """All coordinates, rates and accelerations (n, k) of the rigid press in a motion."""

    @property
    def mass(self) -> Array:
        """(f, f) constant part of the mass matrix."""

    def mass_at(self, coordinates: Array) -> Array:
        """Mass matrices (n, f, f) of the free coordinates, or (f, f) where it is the same everywhere."""

    def spring_forces(self, coordinates: Array, rates: Array, derivatives: bool = True) -> SpringForces:
        """Forces of all springs and of weight on the free coordinates."""

    @property
    def has_constant_mass(self) -> bool:
        """Whether ``mass_at`` is the same everywhere, and no inertia forces depend on the rates."""

    def varying_inertia(self, coordinates: Array, rates: Array, accelerations: Array) -> VaryingInertia:
        """Inertia forces on the free coordinates, and their derivatives by these, beside those of the constant mass matrix."""

    def crank(self, coordinates: Array, rates: Array) -> tuple[Array, Array]:
        """Angle and speed (n,) of the crank's joint."""

    def displacement(self, coordinates: Array, motion: Motion) -> Array:
        """Of all moving links beside the rigid press in a motion, as in `ElasticRun`."""

    def bearing_forces(self, coordinates: Array, rates: Array) -> Array:
        """Forces (bearings, n, 3) of the springs, parent on child or link1 on link2, in world axes [N]."""

    def lost_power(self, coordinates: Array, rates: Array) -> Array:
        """Power (n,) lost in the dampers [W]."""

    def kinetic_energy(self, coordinates: Array, rates: Array) -> Array:
        """Kinetic energy (n,) of all bodies [J]."""

    def stored_energy(self, coordinates: Array) -> Array:
        """Energy (n,) of springs and weights [J]."""

    def weight_less_inertia(self, accelerations: Array) -> Array:
        """Sum (n, 3) of the weights less the inertia forces of all bodies, of free accelerations (n, f), in world axes [N]."""


def reference_angle(press: Linkage) -> float:
    """Crank angle of the rigid bottom dead centre, else 0 [rad]."""
    try:
        return dead_centres(press).bottom_angle
    except PinpressError:
        return 0.0


def frequencies(sprung: PressOnSprings, angle: float) -> Array:
    """Natural frequencies (f,) with the crank held at an angle, rising, without dampers and loads [rad/s]."""
    place, _, _ = sprung.rigid_coordinates(motion_through_change_points(sprung.press, np.array([angle]), 0.0))
    forces, mass = sprung.spring_forces(place, np.zeros_like(place)), sprung.mass_at(place)
    assert forces.stiffness is not None
    inverse = np.linalg.inv(np.linalg.cholesky(mass[..., :-1, :-1]))
    squared = np.linalg.eigvalsh(inverse @ forces.stiffness[:, :-1, :-1] @ np.swapaxes(inverse, -1, -2))[0]
    return np.asarray(np.sqrt(np.maximum(squared, 0.0)))
