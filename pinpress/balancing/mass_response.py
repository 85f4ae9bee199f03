"""What masses on the links change in torques and forces.

A mass m at a point of a link acts on the link as the force m (g - a) does at that point, where a is its acceleration (d'Alembert). So all
forces are linear in the masses, and in whatever is made of point masses: a counterweight, a mass moment, a moment of inertia.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..common.arrays import Array
from ..common.frozen import Frozen
from ..dynamics.applied_loads import place
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
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
    position, acceleration = press.engine().point_accelerations(motion.states(press), joint, points)
    return position, masses.masses[:, None, None] * (press.model.gravity.linear - acceleration)
