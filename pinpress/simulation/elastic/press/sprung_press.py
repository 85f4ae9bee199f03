"""A press on springs: bodies that the springs of its bearings join, in a plane or in space.

How the bodies lie and how springs lengthen with them is a `Geometry` (`plane`, `space`). What follows from it is the same
for both. A spring of the extension y pulls with k (y - rest) + c y', and pushes on the coordinates by the gradient of y; Newton's method
also takes the second derivatives of y. Some springs have constant gradients: those of guides and shafts against turning, and those of the
shapes of flexible links.

What the springs do not join is kept rigidly: the crank by its angle, gear pairs by their ratio, a crown by its columns. These conditions
are linear, so that the coordinates of all bodies are a constant matrix times the free ones: ``carry @ y + drawn``. The last of the free
ones is the angle of the crank, or of the shaft behind it, which may be prescribed.

A state of the bodies is turned once, by `SprungPress.state`, and passed on to all that ask about it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ....common.errors import PinpressError
from ....common.numerics import undamped_modes
from ....common.products import product
from ....common.quantities import Array
from ....kinematics.cycle import motion_through_change_points
from ....kinematics.motion import Motion
from ....kinematics.slide_path import dead_centres
from ....linkage.linkage import Linkage
from ..contact import OpenPin
from ..description import Elastic
from ..panels import Indices
from ..preloaded_joint import JointSpring, OpenJoint
from .geometry import BodyState, LinearSprings, Springs, Strains, VaryingInertia


class SpringForces(NamedTuple):
    """Forces on the free coordinates at n states, and their derivatives.

    Attributes:
        force: (n, f) generalised forces [N, N m].
        stiffness: (n, f, f) minus d force / d coordinates; None if it is not asked for.
        damping: (n, f, f) minus d force / d rates; None if it is not asked for.
    """

    force: Array
    stiffness: Any
    damping: Any


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


@dataclass(frozen=True, eq=False, repr=False)
class SprungPress:
    """Constants of a press on springs; f is the number of its free coordinates.

    Attributes:
        press: the linkage.
        elastic: what yields in it, as it was given.
        geometry: its bodies, and the lines of its springs.
        springs: along these lines.
        linear: springs with constant gradients.
        carry: (k, f) free coordinates, the crank's angle last, to all coordinates.
        drawn: (k,) all coordinates where the free ones are zero.
        reference: the rigid press at its bottom dead centre, else in its home pose; one state.
        alike: for each bearing the one that has its springs: itself, except for the joints of a cross without mass, which share one.
        joints: preloaded joints, whose springs in ``springs`` are those of closed joints.
        open_pins: pins with clearance, which have no springs in ``springs``.
        open_joints: preloaded joints that may open, whose members have no springs in ``springs``.
        closed: the same press without clearance and with closed joints; None if it is the same.
        fixed: the same press on a fixed frame, where it stands on mounts.
    """

    press: Linkage
    elastic: Elastic
    geometry: Any
    springs: Springs
    linear: LinearSprings
    carry: Array
    drawn: Array
    reference: Motion
    alike: tuple[int, ...]
    joints: tuple[JointSpring, ...] = ()
    open_pins: tuple[OpenPin, ...] = ()
    open_joints: tuple[OpenJoint, ...] = ()
    closed: SprungPress | None = None
    fixed: SprungPress | None = None

    def with_opening_joints(self) -> SprungPress:
        """The same press with preloaded joints that may open."""
        if not self.joints:
            return self
        springs, opened = self.springs, []
        stiffness, damping, rest = springs.stiffness.copy(), springs.damping.copy(), springs.rest.copy()
        for joint in self.joints:
            place = int(np.flatnonzero(springs.bearing == joint.bearing)[joint.number])
            opened.append(joint.open(place, float(damping[place])))
            stiffness[place], damping[place], rest[place] = opened[-1].always, opened[-1].damping, opened[-1].rest
        return replace(
            self,
            springs=springs._replace(stiffness=stiffness, damping=damping, rest=rest),
            open_joints=tuple(opened),
            closed=self.closed or self,
            fixed=None if self.fixed is None else self.fixed.with_opening_joints(),
        )

    def with_dampers(self, ratio: float, dampers: Mapping[int, float]) -> SprungPress:
        """The same press with dampers in proportion to its springs, so that the lowest vibration has a damping ratio; and some bearings, by
        their numbers, with their own [N s/m]."""
        springs, linear = self.springs, self.linear
        factor = 2 * ratio / self.lowest_frequency if ratio else 0.0
        damping = factor * springs.stiffness
        for bearing, damper in dampers.items():
            damping[(springs.bearing == self.alike[bearing]) & (springs.sign != 0.0)] = damper
        linear = linear._replace(damping=linear.damping + factor * linear.shared * linear.stiffness)
        return replace(self, springs=springs._replace(damping=damping), linear=linear)

    # ----------------------------------------------------------------------------------------------------------------- coordinates

    @property
    def free(self) -> int:
        """Number of free coordinates."""
        return int(self.carry.shape[1])

    def state(self, free: Array, rates: Array, derivatives: bool = True) -> Any:
        """The bodies at free coordinates and rates (n, f)."""
        return self.geometry.state(self.all_coordinates(free), self.all_rates(rates), derivatives)

    def all_coordinates(self, free: Array) -> Array:
        """All coordinates (n, k) of free ones (n, f)."""
        return self.all_rates(free) + self.drawn

    def all_rates(self, rates: Array) -> Array:
        """Rates or accelerations (n, k) of all coordinates, of those (n, f) of the free ones."""
        return product(rates, self.carry.T)

    def free_coordinates(self, coordinates: Array) -> Array:
        """Free coordinates (n, f) of all coordinates (n, k)."""
        return self.free_rates(coordinates - self.drawn)

    def free_rates(self, rates: Array) -> Array:
        """Free rates or accelerations (n, f) of those of all coordinates (n, k)."""
        return self.to_free(rates) if self._kept is not None else product(rates, self._back)

    @cached_property
    def _back(self) -> Array:
        """(k, f) all rates to the free ones."""
        return np.asarray(np.linalg.pinv(self.carry).T)

    @cached_property
    def _kept(self) -> tuple[Indices, Array] | None:
        """Which of all coordinates each free one is, and its sign; None if conditions tie several together."""
        entries = np.count_nonzero(self.carry, axis=0)
        if (entries != 1).any() or (np.abs(self.carry[self.carry != 0]) != 1.0).any():
            return None
        rows = np.argmax(self.carry != 0, axis=0)
        return rows, self.carry[rows, np.arange(self.free)]

    def to_free(self, columns: Array) -> Array:
        """Gradients (..., f) by the free coordinates, of those by all (..., k)."""
        return columns[..., self._kept[0]] * self._kept[1] if self._kept is not None else np.asarray(columns @ self.carry)

    def to_free_twice(self, matrices: Array) -> Array:
        """Second derivatives (n, f, f) by the free coordinates, of those by all."""
        if self._kept is not None:
            rows, signs = self._kept
            return np.asarray(matrices[:, rows[:, None], rows] * np.multiply.outer(signs, signs))
        return np.asarray(self.carry.T @ matrices @ self.carry)

    def rigid(self, angle: Array, speed: Any, acceleration: Any = 0.0) -> tuple[Array, Array, Array]:
        """Free coordinates, rates and accelerations (n, f) of the rigid press, of those (n,) of its crank."""
        motion = motion_through_change_points(self.press, angle, speed, acceleration)
        coordinates, rates, accelerations = self.geometry.rigid(motion)
        return self.free_coordinates(coordinates), self.free_rates(rates), self.free_rates(accelerations)

    # --------------------------------------------------------------------------------------------------------------------- inertia

    @cached_property
    def mass(self) -> Array:
        """(f, f) constant part of the mass matrix of the free coordinates."""
        return np.asarray(self.carry.T @ (self.geometry.inertia[:, None] * self.carry))

    @cached_property
    def free_weight(self) -> Array:
        """(f,) gravity on the free coordinates."""
        return np.asarray(self.carry.T @ self.geometry.weight)

    def varying_inertia(self, state: BodyState, accelerations: Array) -> VaryingInertia:
        """Inertia forces on the free coordinates at their accelerations (n, f), without those of the constant part of the mass matrix."""
        force, *matrices = self.geometry.varying_inertia(state, self.all_rates(accelerations))
        return VaryingInertia(self.to_free(force), *(self.to_free_twice(matrix) for matrix in matrices))

    def mass_at(self, state: BodyState) -> Array:
        """Mass matrices (n, f, f) of the free coordinates, or (f, f) where it is the same everywhere."""
        if self.geometry.constant_mass:
            return self.mass
        return np.asarray(self.mass + self.varying_inertia(state, np.zeros((len(state.coordinates), self.free))).by_acceleration)

    def weight_less_inertia(self, accelerations: Array, body: int | None = None) -> Array:
        """Sum (n, 3) of the weights less the inertia forces of all bodies, or of one, of free accelerations (n, f), in world axes [N]."""
        left = self.geometry.weight - self.all_rates(accelerations) * self.geometry.inertia
        return np.asarray(self.geometry.total(left, body))

    # --------------------------------------------------------------------------------------------------------------------- springs

    def pulls(self, strains: Strains) -> Array:
        """(n, S) forces of the springs on their second bodies along the lines [N]."""
        springs = self.springs
        return np.asarray(-(springs.stiffness * (strains.extension - springs.rest) + springs.damping * strains.opening))

    def spring_forces(self, state: BodyState, derivatives: bool = True) -> SpringForces:
        """Forces of all springs and of weight on the free coordinates."""
        geometry, springs, linear, turning = self.geometry, self.springs, self.linear, self._turning
        strains = geometry.strains(state)
        pull, gradient = self.pulls(strains), self.to_free(geometry.gradient(strains))
        moment = -(self.linear_rates(state.coordinates) * linear.stiffness + self.linear_rates(state.rates) * linear.damping)
        force = np.matmul(pull[:, None, :], gradient)[:, 0] + product(moment, turning) + self.free_weight
        if not derivatives:
            return SpringForces(force, None, None)
        rate = self.to_free(geometry.gradient_rate(strains))
        yielding = springs.stiffness[:, None] * gradient + springs.damping[:, None] * rate
        transposed = gradient.transpose(0, 2, 1)
        stiffness = np.matmul(transposed, yielding) - self.to_free_twice(geometry.bend(strains, pull))
        damping = np.matmul(transposed, springs.damping[:, None] * gradient)
        stiffness += turning.T @ (linear.stiffness[:, None] * turning)
        damping += turning.T @ (linear.damping[:, None] * turning)
        return SpringForces(force, stiffness, damping)

    def linear_rates(self, rates: Array) -> Array:
        """(n, T) rates of the extensions of `linear`, or extensions, of rates or coordinates (n, k)."""
        return product(rates, self.linear.rows.T)

    @cached_property
    def _turning(self) -> Array:
        """(T, f) gradients of `linear` by the free coordinates."""
        return self.linear.rows @ self.carry

    @cached_property
    def frequencies(self) -> Array:
        """(f - 1,) natural frequencies in the reference pose with the crank held, rising, without dampers and loads [rad/s]."""
        coordinates, rates, _ = self.geometry.rigid(self.reference)
        state = self.geometry.state(coordinates, rates)
        squared, _ = undamped_modes(self.mass_at(state)[..., :-1, :-1], self.spring_forces(state).stiffness[:, :-1, :-1])
        return np.asarray(np.sqrt(np.maximum(squared[0], 0.0)))

    @property
    def lowest_frequency(self) -> float:
        """Lowest natural frequency in the reference pose, with the crank held, closed joints and without dampers [rad/s]."""
        return float((self.closed or self).frequencies[0])

    def joint_motions(self, state: BodyState) -> list[JointMotion]:
        """The preloaded joints that may open."""
        if not self.open_joints:
            return []
        strains = self.geometry.strains(state)
        pull, along = self.pulls(strains), self.springs.sign[:, None] * self.geometry.along(strains)
        return [
            JointMotion(joint, strains.extension[:, k], strains.opening[:, k], -pull[:, k], along[:, k])
            for joint, k in ((joint, joint.spring) for joint in self.open_joints)
        ]

    def bearing_forces(self, state: BodyState) -> Array:
        """Forces (bearings, n, 3) of the springs, parent on child or link1 on link2, in world axes [N]."""
        strains, springs = self.geometry.strains(state), self.springs
        forces = (springs.sign * self.pulls(strains))[..., None] * self.geometry.along(strains)
        return np.array([forces[:, springs.bearing == same].sum(axis=1) for same in self.alike])

    def lost_power(self, state: BodyState) -> Array:
        """Power (n,) lost in the dampers [W]."""
        opening = self.geometry.strains(state).opening
        return np.asarray(opening**2 @ self.springs.damping + self.linear_rates(state.rates) ** 2 @ self.linear.damping)

    def stored_energy(self, state: BodyState) -> Array:
        """Energy (n,) of springs and weights [J]."""
        extension, turn = self.geometry.strains(state).extension, self.linear_rates(state.coordinates)
        springs = (extension - self.springs.rest) ** 2 @ self.springs.stiffness + turn**2 @ self.linear.stiffness
        joints = sum(joint.stored_energy(extension[:, joint.spring]) for joint in self.open_joints)
        return np.asarray(0.5 * springs + joints - state.coordinates @ self.geometry.weight)


def reference_motion(press: Linkage) -> Motion:
    """One state of the rigid press: at rest at its bottom dead centre, else in its home pose."""
    try:
        angle = dead_centres(press).bottom_angle
    except PinpressError:
        angle = float(press.closed[press.driver_indices[0]])
    return motion_through_change_points(press, np.array([angle]), 0.0)


def some_of(state: Any, rows: Indices) -> Any:
    """Some of the states of bodies, by their numbers."""
    parts = (some_of(part, rows) if isinstance(part, tuple) else None if part is None else part[rows] for part in state)
    return type(state)(*parts)
