"""What masses on the links change in torques and forces.

A mass m at a point of a link acts on the link as the force m (g - a) does at that point, where a is its acceleration (d'Alembert). So all
forces are linear in the masses, and in whatever is made of point masses: a counterweight, a mass moment, a moment of inertia.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..common.arrays import Array
from ..common.frozen import Frozen
from ..dynamics.applied_loads import place
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..engines.constant_rows import product
from ..engines.coordinates import data_of
from ..engines.planar.kinematics import basis, basis_acceleration
from ..engines.planar.model import Plane, in_space
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..loads.link import Load, PointForce


@dataclass(frozen=True)
class OperatingCondition(Frozen):
    """A motion of the press and the loads on it, as `inverse_dynamics` takes them.

    Attributes:
        motion: Motion of the press.
        loads: Loads on the press in this motion.
    """

    motion: Motion
    loads: Sequence[Load] = ()


@dataclass(frozen=True, eq=False, repr=False)
class PointMasses:
    """Point masses on a link.

    Attributes:
        link: Name of the link.
        masses: (p,) [kg], or kg times the unit of the quantity that the masses stand for.
        points: (p, 3) in the link's own frame [m].
    """

    link: str
    masses: Array
    points: Array


@dataclass(frozen=True, eq=False, repr=False)
class MassResponse:
    """The change of the forces of `Reactions` by masses, in arrays of the same shapes; what was not asked for is empty.

    Attributes:
        shaking_force: (n, 3) [N].
        shaking_moment: (n, 3) about the world's origin [N m].
        driving_torque: (n,), of several drivers (n, drivers) [N m].
        bearing_force: By bearing, (n, 3) [N].
        bearing_moment: By bearing, (n, 3) [N m].
    """

    shaking_force: Array
    shaking_moment: Array
    driving_torque: Array
    bearing_force: Mapping[str, Array]
    bearing_moment: Mapping[str, Array]


def mass_response(
    press: Linkage, condition: OperatingCondition, reactions: Reactions, masses: PointMasses, inner_forces: bool
) -> MassResponse:
    """What point masses change of the shaking force and moment and, where asked for, of the inner forces.

    Args:
        press: The press without the masses.
        condition: Motion and loads.
        reactions: Reactions of the press in this condition without the masses.
        masses: The point masses.
        inner_forces: Whether the driving torque and the bearings of ``reactions`` are wanted too.
    """
    position, force = _inertia_forces(press, condition.motion, masses)
    shaking = force.sum(axis=0), np.cross(position, force).sum(axis=0)
    if not inner_forces:
        return MassResponse(*shaking, np.zeros((len(condition.motion.crank_angle), 0)), {}, {})
    # The masses are made as heavy as the press, so that the difference of two reactions loses few digits.
    largest = np.abs(masses.masses).max()
    factor = moving_mass(press) / largest if largest > 0 else 1.0
    added = [PointForce(masses.link, factor * f, tuple(p)) for f, p in zip(force, masses.points, strict=True) if f.any()]
    after = inverse_dynamics(press, condition.motion, [*condition.loads, *added], bearings=tuple(reactions.bearing_force))
    return MassResponse(
        *shaking,
        driving_torque=(after.driving_torque - reactions.driving_torque) / factor,
        bearing_force={name: (after.bearing_force[name] - before) / factor for name, before in reactions.bearing_force.items()},
        bearing_moment={name: (after.bearing_moment[name] - before) / factor for name, before in reactions.bearing_moment.items()},
    )


def moving_mass(press: Linkage) -> float:
    """Mass of all links but the frame [kg]."""
    return float(sum(inertia.mass for inertia in list(press.model.inertias)[1:]))


def _inertia_forces(press: Linkage, motion: Motion, masses: PointMasses) -> tuple[Array, Array]:
    """World positions (p, n, 3) of the masses [m], and weight plus inertia force (p, n, 3) of each [N]."""
    places = [place(press, masses.link, tuple(point), "counterweight", "position") for point in masses.points]
    joint, points = places[0][0], np.array([point for _, point in places])
    position, acceleration = (
        _in_plane(press.plane, press, motion, joint, points) if press.plane else _in_space(press, motion, joint, points)
    )
    return position, masses.masses[:, None, None] * (press.model.gravity.linear - acceleration)


def _in_plane(plane: Plane, press: Linkage, motion: Motion, joint: int, points: Array) -> tuple[Array, Array]:
    """World positions and accelerations (p, n, 3) of points (p, 3) in a joint's frame."""
    at = motion.basis(press)
    at = basis(plane, motion.joint_position.T) if at is None else at
    x, y, height = plane.frames[joint - 1] @ points.T
    rows = np.array([plane.point(joint - 1, complex(*arm)) for arm in zip(x, y, strict=True)])
    position = in_space(plane, product(rows, at)) + (plane.heights[joint - 1] + height)[:, None, None] * plane.normal
    return position, in_space(plane, product(rows, basis_acceleration(plane, at, motion.v.T, motion.a.T)))


def _in_space(press: Linkage, motion: Motion, joint: int, points: Array) -> tuple[Array, Array]:
    """World positions and accelerations as of `_in_plane`, by Pinocchio, one state at a time."""
    position = np.empty((len(points), len(motion.v), 3))
    acceleration, data = np.empty_like(position), data_of(press.model)
    for i, (q, v, a) in enumerate(zip(np.array(motion.q), np.array(motion.v), np.array(motion.a), strict=True)):
        pin.forwardKinematics(press.model, data, q, v, a)
        body, velocity = data.oMi[joint], data.v[joint]
        rate = pin.classicAcceleration(velocity, data.a[joint])
        spin, turning = velocity.angular, data.a[joint].angular
        for p, point in enumerate(points):
            position[p, i] = body.act(point)
            acceleration[p, i] = body.rotation @ (rate + np.cross(turning, point) + np.cross(spin, np.cross(spin, point)))
    return position, acceleration
