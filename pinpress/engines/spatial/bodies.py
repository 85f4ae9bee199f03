"""Bodies in space: where they are, how they move, and what accelerates them, at all configurations at once.

Arrays have the configurations last: rotations (nv + 1, 3, 3, n), vectors (nv + 1, 3, n), with the frame as body 0, so that Pinocchio's
indices of joints serve. All vectors are in world axes. Velocities and accelerations of a body are those of its point at the world origin,
and moments are taken about the world origin, so that sums over bodies need no transformation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.frozen import Frozen
from ...common.quantities import Array
from ..engine import ClosedStates, EnergyRates, PowerBalance
from ..forces import AppliedForce
from ..joints import Matrix, matrix, product
from ..pinocchio.model import SpatialModel


@dataclass(frozen=True, eq=False, repr=False)
class Bodies(Frozen):
    """Constants of the tree of joints and bodies.

    Attributes:
        parents: (nv,) Pinocchio's indices of the parents of the joints, 0 for the frame.
        turns: (nv,) whether a joint turns.
        offset: (nv, 3) origin of a joint in its parent's frame, where it slides at zero [m].
        slide: (nv, 3) direction in which it slides, in its parent's frame; zero where it turns.
        rotation: (nv, 9, 3) factors of 1, sine and cosine of the coordinate in the rotation from joint to parent.
        axis: (nv, 3) axis in the joint's own frame.
        carried: (nv, nv) 1 where the joint of a column carries the body of a row.
        mass: (nv,) masses [kg].
        lever: (nv, 3) centres of mass in the joint's frame [m].
        inertia: (nv, 3, 3) moments of inertia about the centre of mass, axes of the joint's frame [kg m2].
        gravity: (3,) acceleration of gravity [m/s2].
    """

    parents: tuple[int, ...]
    turns: NDArray[np.bool_]
    offset: Array
    slide: Array
    rotation: Array
    axis: Array
    carried: Matrix
    mass: Array
    lever: Array
    inertia: Array
    gravity: Array

    @cached_property
    def carrying(self) -> Matrix:
        """(nv, nv) ``carried`` transposed: sums over the bodies that a joint carries."""
        return np.ascontiguousarray(self.carried.T) if isinstance(self.carried, np.ndarray) else self.carried.T.tocsr()


def build_bodies(spatial: SpatialModel) -> Bodies:
    """The constants of a linkage."""
    model, count = spatial.model, spatial.model.nv
    parents = tuple(int(parent) for parent in list(model.parents)[1:])
    placements, inertias = list(model.jointPlacements)[1:], list(model.inertias)[1:]
    fixed = np.array([placement.rotation for placement in placements])
    axis, turns = np.array([a.direction for a in spatial.axes]), np.array([a.turns for a in spatial.axes])
    x, y, z = axis.T
    zero = np.zeros(count)
    skew = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1) * turns[:, None, None]
    squared = skew @ skew
    factors = np.stack([fixed @ (np.eye(3) + squared), fixed @ skew, -fixed @ squared], axis=-1)
    paths: list[dict[int, complex]] = []
    for joint, parent in enumerate(parents):
        paths.append({**(paths[parent - 1] if parent else {}), joint: 1.0})
    return Bodies(
        parents=parents,
        turns=turns,
        offset=np.array([placement.translation for placement in placements]),
        slide=np.where(turns[:, None], 0.0, (fixed @ axis[:, :, None])[:, :, 0]),
        rotation=factors.reshape(count, 9, 3),
        axis=axis,
        carried=matrix(paths, count, count, float),
        mass=np.array([inertia.mass for inertia in inertias]),
        lever=np.array([inertia.lever for inertia in inertias]),
        inertia=np.array([inertia.inertia for inertia in inertias]),
        gravity=np.array(model.gravity.linear),
    )


class Placements(NamedTuple):
    """Where the bodies are.

    Attributes:
        rotation: (nv + 1, 3, 3, n) from the body's frame to the world.
        origin: (nv + 1, 3, n) of the body's frame [m].
        axis: (nv, 3, n) axes of the joints.
    """

    rotation: Array
    origin: Array
    axis: Array

    def point(self, body: int, place: Array) -> Array:
        """World position (3, n) of a point (3,) fixed to a body [m]."""
        return np.asarray(self.origin[body] + np.einsum("ikn,k->in", self.rotation[body], place))


class Velocities(NamedTuple):
    """How the bodies move.

    Attributes:
        spin: (nv + 1, 3, n) angular velocity [rad/s].
        linear: (nv + 1, 3, n) velocity of the body's point at the world origin [m/s].
    """

    spin: Array
    linear: Array

    def of_point(self, body: int, at: Array) -> Array:
        """Velocity (3, n) of a body's point that is at world positions (3, n) [m/s]."""
        return np.asarray(self.linear[body] + cross(self.spin[body], at))


class Accelerations(NamedTuple):
    """How the motion of the bodies changes.

    Attributes:
        turning: (nv + 1, 3, n) angular acceleration [rad/s2].
        linear: (nv + 1, 3, n) rate of the velocity at the world origin, of whichever point of the body is there [m/s2].
    """

    turning: Array
    linear: Array

    def of_point(self, velocities: Velocities, body: int, at: Array) -> Array:
        """Acceleration (3, n) of a body's point that is at world positions (3, n) [m/s2]."""
        return np.asarray(self.linear[body] + cross(self.turning[body], at) + cross(velocities.spin[body], velocities.of_point(body, at)))


def cross(one: Array, other: Array) -> Array:
    """The vector product of vectors (..., 3, n)."""
    a, b, c = one[..., 0, :], one[..., 1, :], one[..., 2, :]
    x, y, z = other[..., 0, :], other[..., 1, :], other[..., 2, :]
    result = np.empty(np.broadcast_shapes(one.shape, other.shape))
    for row, first, second, third, fourth in ((0, b, z, c, y), (1, c, x, a, z), (2, a, y, b, x)):
        own = result[..., row, :]
        np.multiply(first, second, out=own)
        own -= third * fourth
    return result


def turned(rotation: Array, vectors: Array) -> Array:
    """Rotations (..., 3, 3, n) times vectors (..., 3, n)."""
    return np.asarray(
        rotation[..., 0, :] * vectors[..., :1, :] + rotation[..., 1, :] * vectors[..., 1:2, :] + rotation[..., 2, :] * vectors[..., 2:, :]
    )


def turned_back(rotation: Array, vectors: Array) -> Array:
    """Inverse rotations (..., 3, 3, n) times vectors (..., 3, n)."""
    return np.asarray(
        rotation[..., 0, :, :] * vectors[..., :1, :]
        + rotation[..., 1, :, :] * vectors[..., 1:2, :]
        + rotation[..., 2, :, :] * vectors[..., 2:, :]
    )


def placements(bodies: Bodies, x: Array) -> Placements:
    """Where the bodies are at joint coordinates (nv, n)."""
    count, n = x.shape
    powers = np.empty((count, 3, n))
    powers[:, 0] = 1.0
    np.sin(x, out=powers[:, 1])
    np.cos(x, out=powers[:, 2])
    local = np.matmul(bodies.rotation, powers).reshape(count, 3, 3, n)
    rotation, origin = np.empty((count + 1, 3, 3, n)), np.empty((count + 1, 3, n))
    rotation[0], origin[0] = np.eye(3)[:, :, None], 0.0
    for joint, parent in enumerate(bodies.parents):
        place = bodies.offset[joint][:, None]
        if not bodies.turns[joint]:
            place = place + bodies.slide[joint][:, None] * x[joint]
        if parent == 0:
            rotation[joint + 1], origin[joint + 1] = local[joint], place
            continue
        above, own = rotation[parent], rotation[joint + 1]
        np.multiply(above[:, :1], local[joint, 0], out=own)
        own += above[:, 1:2] * local[joint, 1]
        own += above[:, 2:] * local[joint, 2]
        np.add(origin[parent], turned(above, place), out=origin[joint + 1])
    return Placements(rotation, origin, np.einsum("jikn,jk->jin", rotation[1:], bodies.axis))


def motion_axes(bodies: Bodies, placed: Placements) -> Array:
    """(nv, 2, 3, n) angular velocity of the bodies that a joint carries, and their velocity at the world origin, at unit rate."""
    turns = bodies.turns[:, None, None]
    linear = cross(placed.origin[1:], placed.axis)
    if bodies.turns.all():
        return np.stack([placed.axis, linear], axis=1)
    return np.stack([np.where(turns, placed.axis, 0.0), np.where(turns, linear, placed.axis)], axis=1)


def velocities(bodies: Bodies, axes: Array, v: Array) -> Velocities:
    """How the bodies move at joint rates (nv, n); ``axes``: of `motion_axes`."""
    return Velocities(*_with_frame(bodies, axes * v[:, None, None]))


def accelerations(bodies: Bodies, axes: Array, moved: Velocities, v: Array, a: Array | None) -> Accelerations:
    """How the motion of the bodies changes at joint rates and accelerations (nv, n); None: none."""
    spin, linear = moved.spin[1:], moved.linear[1:]
    own = np.stack([cross(spin, axes[:, 0]), cross(spin, axes[:, 1]) + cross(linear, axes[:, 0])], axis=1)
    own *= v[:, None, None]
    if a is not None:
        own += axes * a[:, None, None]
    return Accelerations(*_with_frame(bodies, own))


def _with_frame(bodies: Bodies, own: Array) -> Array:
    """Sums (2, nv + 1, 3, n) over the joints that carry a body, of what each adds (nv, 2, 3, n); zero for the frame."""
    count, n = len(own), own.shape[-1]
    result = np.zeros((2, count + 1, 3, n))
    result[:, 1:] = product(bodies.carried, own.reshape(count, -1)).reshape(count, 2, 3, n).swapaxes(0, 1)
    return result


class InertiaForces(NamedTuple):
    """What the bodies need beside the bearings' forces: mass x acceleration less weight.

    Attributes:
        center: (nv, 3, n) centres of mass [m].
        force: (nv, 3, n) [N].
        couple: (nv, 3, n) about the centre of mass [N m].
    """

    center: Array
    force: Array
    couple: Array


def inertia_forces(bodies: Bodies, placed: Placements, moved: Velocities, changed: Accelerations, weights: bool = True) -> InertiaForces:
    """The forces and couples that accelerate the bodies, and with ``weights`` carry them."""
    rotation, center = placed.rotation[1:], centers(bodies, placed)
    spin, turning = moved.spin[1:], changed.turning[1:]
    acceleration = changed.linear[1:] + cross(turning, center) + cross(spin, moved.linear[1:] + cross(spin, center))
    if weights:
        acceleration -= bodies.gravity[:, None]
    own_spin, own_turning = turned_back(rotation, spin), turned_back(rotation, turning)
    inertia = bodies.inertia[..., None]
    couple = turned(rotation, turned(inertia, own_turning) + cross(own_spin, turned(inertia, own_spin)))
    return InertiaForces(center, bodies.mass[:, None, None] * acceleration, couple)


def centers(bodies: Bodies, placed: Placements) -> Array:
    """World positions (nv, 3, n) of the centres of mass [m]."""
    return np.asarray(placed.origin[1:] + np.einsum("jikn,jk->jin", placed.rotation[1:], bodies.lever))


def energies(bodies: Bodies, states: ClosedStates) -> EnergyRates:
    """See `Engine`."""
    placed = placements(bodies, states.position)
    moved = velocities(bodies, motion_axes(bodies, placed), states.v)
    center, spin = centers(bodies, placed), turned_back(placed.rotation[1:], moved.spin[1:])
    velocity = moved.linear[1:] + cross(moved.spin[1:], center)
    turning = (spin * turned(bodies.inertia[..., None], spin)).sum(axis=(0, 1))
    kinetic = 0.5 * (bodies.mass @ (velocity * velocity).sum(axis=1) + turning)
    along = bodies.mass[:, None] * bodies.gravity  # weights [N]
    return EnergyRates(kinetic, -np.einsum("ji,jin->n", along, center), -np.einsum("ji,jin->n", along, velocity))


def power_balance(bodies: Bodies, states: ClosedStates, loads: Sequence[AppliedForce]) -> PowerBalance:
    """See `Engine`. The powers are summed body by body."""
    placed = placements(bodies, states.position)
    axes = motion_axes(bodies, placed)
    moved = velocities(bodies, axes, states.v)
    needed = inertia_forces(bodies, placed, moved, accelerations(bodies, axes, moved, states.v, states.a), weights=False)
    velocity, spin = moved.linear[1:] + cross(moved.spin[1:], needed.center), moved.spin[1:]
    pairs = [((bodies.mass[:, None] * bodies.gravity)[:, :, None], velocity), (-needed.force, velocity), (-needed.couple, spin)]
    for load in loads:
        if load.joint:
            at = placed.point(load.joint, load.point)
            pairs.append((load.force.T[None], moved.of_point(load.joint, at)[None]))
    powers = np.concatenate([(force * motion).sum(axis=1) for force, motion in pairs])
    sizes = [np.sqrt((force * force).sum(axis=1) * (motion * motion).sum(axis=1)) for force, motion in pairs]
    return PowerBalance(powers.sum(axis=0), np.abs(powers).sum(axis=0), np.concatenate(sizes).sum(axis=0))
