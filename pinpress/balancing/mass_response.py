"""What masses on the links change in torques and forces.

A mass m at a point of a link acts on the link as the force m (g - a) does at that point, a its acceleration (d'Alembert). So everything is
linear in the masses, and in whatever is made of point masses: a counterweight, a mass moment, a moment of inertia.
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
class Case(Frozen):
    """An operating condition: a motion and the loads on it, as `inverse_dynamics` takes them."""

    motion: Motion
    loads: Sequence[Load] = ()


@dataclass(frozen=True, eq=False, repr=False)
class PointMasses:
    """Masses (p,) at points (p, 3) of a link, in the link's own frame [m]; masses in kg times whatever they are one unit of."""

    link: str
    masses: Array
    points: Array


@dataclass(frozen=True, eq=False, repr=False)
class Change:
    """Change of the forces of `Reactions` by masses; arrays as there. What was not asked for is empty."""

    shaking_force: Array
    shaking_moment: Array
    driving_torque: Array
    bearing_force: Mapping[str, Array]
    bearing_moment: Mapping[str, Array]


def change(press: Linkage, case: Case, before: Reactions, masses: PointMasses, torque: bool) -> Change:
    """What masses change: the shaking force and moment; with ``torque`` the driving torque, and the bearings that ``before`` has.

    Args:
        before: reactions of the case without the masses.
    """
    position, force = _inertia_forces(press, case.motion, masses)
    shaking = force.sum(axis=0), np.cross(position, force).sum(axis=0)
    nothing = np.zeros((len(case.motion.crank_angle), 0))
    if not torque:
        return Change(*shaking, nothing, {}, {})
    # As large as the forces that they are added to, which are taken off again.
    largest = np.abs(masses.masses).max()
    factor = moving_mass(press) / largest if largest > 0 else 1.0
    added = [PointForce(masses.link, factor * f, tuple(p)) for f, p in zip(force, masses.points, strict=True) if f.any()]
    after = inverse_dynamics(press, case.motion, [*case.loads, *added], bearings=tuple(before.bearing_force))

    def by_bearing(name: str) -> dict[str, Array]:
        now, then = getattr(after, name), getattr(before, name)
        return {bearing: (now[bearing] - then[bearing]) / factor for bearing in then}

    return Change(
        *shaking, (after.driving_torque - before.driving_torque) / factor, by_bearing("bearing_force"), by_bearing("bearing_moment")
    )


def moving_mass(press: Linkage) -> float:
    """Of all links but the frame [kg]."""
    return float(sum(inertia.mass for inertia in list(press.model.inertias)[1:]))


def _inertia_forces(press: Linkage, motion: Motion, masses: PointMasses) -> tuple[Array, Array]:
    """World positions of the masses and inertia force less weight of each, (p, n, 3) both."""
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
    """The same by Pinocchio, one state at a time."""
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
