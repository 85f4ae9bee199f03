"""Bodies in space: where they are, how they move, and what accelerates them, at all configurations at once.

Arrays have the configurations last: rotations (nv + 1, 3, 3, n), vectors (nv + 1, 3, n), with the frame as body 0, so that Pinocchio's
indices of joints serve. In memory the components come first, so that one component of all bodies is one row of numbers: products of vectors
then take a third of the time. All vectors are in world axes. Velocities and accelerations of a body are those of its point at the world
origin, and moments are taken about the world origin, so that sums over bodies need no transformation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.frozen import Frozen
from ...common.quantities import Array
from ..body_motion import BodyMotion, by_constants, components_first, cross, turned, turned_back
from ..engine import ClosedStates
from ..structure import Structure

ACROSS = (slice(1, 3), slice(2, None, -2), slice(0, 2))  # the other two axes of a frame, in cyclic order after each


@dataclass(frozen=True, eq=False, repr=False)
class Bodies(Frozen):
    """Constants of the tree of joints and bodies.

    Attributes:
        parents: (nv,) Pinocchio's indices of the parents of the joints, 0 for the frame.
        turns: (nv,) whether a joint turns.
        placement: (nv, 4, 3) of a joint in its parent's frame: the axes of its frame, of `aligned` where there is one, in cyclic order with
            the joint's own axis last; then its origin [m].
        along: (nv,) which axis of this frame is the joint's.
        aligned: (nv, 3, 3) the joint's frame from the frame of its placement, where the joint has none of its own frame's axes; None if
            it has.
        mass: (nv,) masses [kg].
        lever: (nv, 3) centres of mass in the joint's frame [m].
        inertia: (nv, 3, 3) moments of inertia about the centre of mass, axes of the joint's frame [kg m2].
        gravity: (3,) acceleration of gravity [m/s2].
    """

    parents: tuple[int, ...]
    turns: NDArray[np.bool_]
    placement: Array
    along: tuple[int, ...]
    aligned: tuple[Array | None, ...]
    mass: Array
    lever: Array
    inertia: Array
    gravity: Array


def build_bodies(structure: Structure) -> Bodies:
    """The constants of a linkage."""
    model = structure.model
    inertias, placement, along, aligned = list(model.inertias)[1:], [], [], []
    for place, axis in zip(list(model.jointPlacements)[1:], structure.axes, strict=True):
        own = int(np.argmax(axis.direction))
        turned_frame = None if np.array_equal(axis.direction, np.eye(3)[own]) else _frame_with(axis.direction)
        frame = place.rotation if turned_frame is None else place.rotation @ turned_frame
        along.append(own if turned_frame is None else 2)
        placement.append(np.vstack([np.roll(frame.T, 2 - along[-1], axis=0), place.translation]))
        aligned.append(turned_frame)
    return Bodies(
        parents=tuple(int(parent) for parent in list(model.parents)[1:]),
        turns=structure.turns,
        placement=np.array(placement),
        along=tuple(along),
        aligned=tuple(aligned),
        mass=np.array([inertia.mass for inertia in inertias]),
        lever=np.array([inertia.lever for inertia in inertias]),
        inertia=np.array([inertia.inertia for inertia in inertias]),
        gravity=np.array(model.gravity.linear),
    )


def _frame_with(axis: Array) -> Array:
    """Axes (3, 3), as columns, of a frame whose third axis is a unit vector (3,)."""
    first = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(axis, first), axis])


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


class Accelerations(NamedTuple):
    """How the motion of the bodies changes.

    Attributes:
        turning: (nv + 1, 3, n) angular acceleration [rad/s2].
        linear: (nv + 1, 3, n) rate of the velocity at the world origin, of whichever point of the body is there [m/s2].
    """

    turning: Array
    linear: Array


def placements(bodies: Bodies, x: Array) -> Placements:
    """Where the bodies are at joint coordinates (nv, n)."""
    count, n = x.shape
    cosines, sines = np.cos(x), np.empty((count, 2, n))
    np.sin(x, out=sines[:, 0])
    np.negative(sines[:, 0], out=sines[:, 1])
    rotation, origin, axis = np.empty((3, 3, count + 1, n)), np.empty((3, count + 1, n)), np.empty((3, count, n))
    rotation[:, :, 0], origin[:, 0] = np.eye(3)[:, :, None], 0.0
    frame, more = np.empty((3, 4, n)), np.empty((3, 2, n))
    for joint, parent in enumerate(bodies.parents):
        # axes of the frame before the joint moves, its own one last, and the origin, from the parent's
        np.matmul(bodies.placement[joint], rotation[:, :, parent], out=frame)
        own, place, along = rotation[:, :, joint + 1], origin[:, joint + 1], bodies.along[joint]
        across, own[:, along] = own[:, ACROSS[along]], frame[:, 2]
        np.add(origin[:, parent], frame[:, 3], out=place)
        axis[:, joint] = frame[:, 2]
        if bodies.turns[joint]:
            np.multiply(frame[:, :2], cosines[joint], out=across)
            across += np.multiply(frame[:, 1::-1], sines[joint], out=more)
        else:
            across[:] = frame[:, :2]
            place += axis[:, joint] * x[joint]
        aligned = bodies.aligned[joint]
        if aligned is not None:
            own[:] = np.matmul(aligned, own)
    return Placements(rotation.transpose(2, 0, 1, 3), origin.swapaxes(0, 1), axis.swapaxes(0, 1))


def displaced(bodies: Bodies, placed: Placements, joints: Array) -> Placements:
    """The placements where joints are displaced by (nv, 3, n) in the frames of the bodies that carry them, which turns no body [m]."""
    own, moved = turned(placed.rotation[list(bodies.parents)], joints), np.zeros_like(placed.origin)
    for joint, parent in enumerate(bodies.parents):
        moved[joint + 1] = moved[parent] + own[joint]
    return placed._replace(origin=placed.origin + moved)


def motion_axes(bodies: Bodies, placed: Placements) -> Array:
    """(nv, 2, 3, n) angular velocity of the bodies that a joint carries, and their velocity at the world origin, at unit rate."""
    axes = components_first(*placed.axis.shape[::2], 2)
    axes[0], axes[1] = placed.axis, cross(placed.origin[1:], placed.axis)
    if not bodies.turns.all():
        slides = ~bodies.turns
        axes[0, slides], axes[1, slides] = 0.0, placed.axis[slides]
    return axes.swapaxes(0, 1)


def velocities(bodies: Bodies, axes: Array, v: Array) -> Velocities:
    """How the bodies move at joint rates (nv, n); ``axes``: of `motion_axes`."""
    return Velocities(*_with_frame(bodies, axes * v[:, None, None]))


def accelerations(bodies: Bodies, axes: Array, moved: Velocities, v: Array, a: Array | None) -> Accelerations:
    """How the motion of the bodies changes at joint rates and accelerations (nv, n); None: none."""
    spin, linear = moved.spin[1:], moved.linear[1:]
    own = components_first(*spin.shape[::2], 2).swapaxes(0, 1)
    own[:, 0] = cross(spin, axes[:, 0])
    np.add(cross(spin, axes[:, 1]), cross(linear, axes[:, 0]), out=own[:, 1])
    own *= v[:, None, None]
    if a is not None:
        own += axes * a[:, None, None]
    return Accelerations(*_with_frame(bodies, own))


def _with_frame(bodies: Bodies, own: Array) -> Array:
    """Sums (2, nv + 1, 3, n) over the joints that carry a body, of what each adds (nv, 2, 3, n); zero for the frame."""
    count, n = len(own), own.shape[-1]
    result = components_first(count + 1, n, 2)
    result[:, 0], result[:, 1:] = 0.0, own.swapaxes(0, 1)
    for joint, parent in enumerate(bodies.parents):
        if parent:
            result[:, joint + 1] += result[:, parent]
    return result


def sum_carried(bodies: Bodies, own: Array) -> None:
    """Add to vectors of all bodies (..., nv, 3, n) those of the bodies that they carry, from the tips of the tree to the frame."""
    for joint in range(len(bodies.parents) - 1, -1, -1):
        if parent := bodies.parents[joint]:
            own[..., parent - 1, :, :] += own[..., joint, :, :]


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


def inertia_forces(bodies: Bodies, placed: Placements, moved: Velocities, changed: Accelerations) -> InertiaForces:
    """The forces and couples that accelerate and carry the bodies."""
    rotation = placed.rotation[1:]
    center = placed.origin[1:] + np.einsum("jikn,jk->jin", rotation, bodies.lever)
    spin, turning = moved.spin[1:], changed.turning[1:]
    force = cross(spin, center)
    force += moved.linear[1:]
    force = cross(spin, force)
    force += cross(turning, center)
    force += changed.linear[1:]
    force -= bodies.gravity[:, None]
    force *= bodies.mass[:, None, None]
    own_spin, own_turning = turned_back(rotation, spin), turned_back(rotation, turning)
    couple = cross(own_spin, by_constants(bodies.inertia, own_spin))
    couple += by_constants(bodies.inertia, own_turning)
    return InertiaForces(center, force, turned(rotation, couple))


def body_motion(bodies: Bodies, states: ClosedStates, with_accelerations: bool) -> BodyMotion:
    """Motion of all bodies, without the frame."""
    placed = placements(bodies, states.position) if states.solved is None else states.solved.equations.placed
    axes = motion_axes(bodies, placed)
    moved = velocities(bodies, axes, states.v)
    rotation, origin, spin = placed.rotation[1:], placed.origin[1:], moved.spin[1:]
    velocity = moved.linear[1:] + cross(spin, origin)
    if not with_accelerations:
        return BodyMotion(rotation, origin, velocity, spin)
    changed = accelerations(bodies, axes, moved, states.v, states.a)
    turning = changed.turning[1:]
    acceleration = changed.linear[1:] + cross(turning, origin) + cross(spin, velocity)
    return BodyMotion(rotation, origin, velocity, spin, acceleration, turning)
