"""Exact derivatives of the accelerations of a closed linkage, and of the forces that close it, by its state and the efforts of its joints.

They are what trajectory optimisation, control and stability need: the linearised equation of motion. Any linkage, planar or in space, by
Pinocchio's derivatives of its constraint dynamics; `engines.pinocchio.acceleration_derivatives` says where these are completed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import suitable_numbers, typed
from ..common.quantities import Array
from ..common.results import Tabular
from ..common.tables import by_driver
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..kinematics.motion import Motion, refuse_motion_of_another
from ..linkage.linkage import Linkage

AXES = "xyz"


@dataclass(frozen=True, eq=False, repr=False)
class AccelerationSensitivity(Tabular):
    """Accelerations and multipliers of n states of a motion, and their derivatives. All arrays are read-only.

    The loops stay closed only if positions and rates change together: the derivatives belong to changes dx and dv with J dx = 0 and
    J dv + (dJ/dx dx) v = 0, where J is the Jacobian of loops and gear pairs. Along others, what an open loop does is a matter of convention
    (Pinocchio's points here). Changes of efforts are free.

    Attributes:
        motion: the motion.
        efforts: (n, nv) of the joints [N m, N].
        acceleration: (n, nv) under these efforts [rad/s2, m/s2].
        by_position: (n, nv, nv) derivative of each acceleration by each joint coordinate.
        by_rate: (n, nv, nv) derivative of each acceleration by each joint rate.
        by_effort: (n, nv, nv) derivative of each acceleration by each joint effort.
        multiplier_names: (rows,) of the loops' forces in world axes, such as "C x", and of the torques of gear pairs. A revolute loop is
            held at two points and a fixed one at three, ``press.size`` apart along its axes: "C 2 x".
        multipliers: (n, rows) force of link1 on link2 at the point [N], torque on the follower of a gear pair [N m; N where it slides].
            Those that rigid mechanics leaves open are of least size, as across the plane of a planar press, where they are zero; a torque
            counts as the force that it is at the length of the linkage, ``press.size``.
        multipliers_by_position: (n, rows, nv).
        multipliers_by_rate: (n, rows, nv).
        multipliers_by_effort: (n, rows, nv).
        algorithm: what computed the derivatives.
    """

    motion: Motion
    efforts: Array
    acceleration: Array
    by_position: Array
    by_rate: Array
    by_effort: Array
    multiplier_names: tuple[str, ...]
    multipliers: Array
    multipliers_by_position: Array
    multipliers_by_rate: Array
    multipliers_by_effort: Array
    algorithm: str
    _turns: tuple[bool, ...]

    @property
    def title(self) -> str:
        states = f"{len(self.acceleration)} states from {self.motion.place(0)} on"
        return f"AccelerationSensitivity of {self.motion.linkage}: {states}, by {self.algorithm}"

    def columns(self) -> dict[str, Array]:
        """Crank angle, accelerations, and the derivative of each by position, rate and effort of every joint, as (n,) columns."""
        columns = by_driver([each.heads[0] for each in self.motion.driver_coordinates], self.motion.crank_angle, self.motion.drivers)
        joints = list(zip(self.motion.joints, ("rad" if turns else "m" for turns in self._turns), strict=True))
        for k, (joint, unit) in enumerate(joints):
            columns[f"acceleration_{joint} [{unit}/s2]"] = self.acceleration[:, k]
        for what, values, per in (("position", self.by_position, ""), ("rate", self.by_rate, "/s"), ("effort", self.by_effort, None)):
            for k, (joint, unit) in enumerate(joints):
                for j, (other, its) in enumerate(joints):
                    under = f"{its}{per}" if per is not None else "N m" if its == "rad" else "N"
                    columns[f"acceleration_{joint}_by_{what}_{other} [({unit}/s2)/({under})]"] = values[:, k, j]
        return columns


@typed
def acceleration_derivatives(
    press: Linkage, motion: Motion, *, efforts: ArrayLike | None = None, armature: ArrayLike | None = None
) -> AccelerationSensitivity:
    """Exact derivatives of the accelerations of a closed linkage by positions, rates and efforts of its joints.

    Args:
        press: any linkage.
        motion: gives the states, positions and rates; of this linkage.
        efforts: of the joints, (nv,) or (n, nv), positive as their rates [N m, N]; None: those of the drivers under which the motion has
            its own accelerations, without loads.
        armature: (nv,) inertia that turns with the joints, as of a flywheel at the driver [kg m2; kg at one that slides].

    Raises:
        PinpressError: the motion belongs to another linkage; efforts or armature of another shape, or not finite; a joint that moves no
            mass.
        SingularityError: the loops lose an equation in a state, or nearly so.
    """
    from ..engines.pinocchio.acceleration_derivatives import ForwardDerivatives  # no other derivative needs it

    refuse_motion_of_another(press, motion)
    count, joints = len(motion.crank_angle), press.model.nv
    added_inertia = (
        np.zeros(joints) if armature is None else suitable_numbers("armature", armature, f"{joints} finite inertias [kg m2]", (joints,))
    )
    if efforts is None:
        effort_rows = np.zeros((count, joints))
        effort_rows[:, list(press.driver_indices)] = np.reshape(
            inverse_dynamics(press, motion, passive="given").driving_torque, (count, -1)
        )
        effort_rows += added_inertia * motion.a
    else:
        wanted = f"({joints},) or ({count}, {joints}) finite efforts of the joints [N m, N]"
        numbers = suitable_numbers("efforts", efforts, wanted, None, lambda values: values.shape in ((joints,), (count, joints)))
        effort_rows = np.broadcast_to(numbers, (count, joints)).copy()
    press.refuse_joint_springs(
        "derivatives of accelerations leave them out; take them out, and add their slopes to by_position and by_rate"
    )
    if press.loses_power or press.structure.curves:
        press.refuse_contacts("derivatives of accelerations have neither losses nor cams; leave them out")
    rows = press.structure.relation_coefficients[: len(press.relations)]
    with np.errstate(all="ignore"):  # what is not finite is refused
        derivatives = ForwardDerivatives(press.forward_dynamics(added_inertia), rows)
        states = zip(np.array(motion.joint_position), np.array(motion.v), effort_rows, strict=True)
        derivatives_by_state = [derivatives.at(*state) for state in states]
    by_position, by_rate, by_effort = (np.array([state[k] for state in derivatives_by_state]).reshape(count, -1, joints) for k in (2, 3, 4))
    return AccelerationSensitivity(
        motion=motion,
        efforts=effort_rows,
        acceleration=np.array([state.acceleration for state in derivatives_by_state]).reshape(count, joints),
        by_position=by_position[:, :joints],
        by_rate=by_rate[:, :joints],
        by_effort=by_effort[:, :joints],
        multiplier_names=_multiplier_names(press),
        multipliers=np.array([state.multipliers for state in derivatives_by_state]).reshape(count, -1),
        multipliers_by_position=by_position[:, joints:],
        multipliers_by_rate=by_rate[:, joints:],
        multipliers_by_effort=by_effort[:, joints:],
        algorithm="computeConstraintDynamicsDerivatives" + (", gear pairs eliminated" if len(rows) else ""),
        _turns=tuple(axis.turns for axis in press.axes),
    )


def _multiplier_names(press: Linkage) -> tuple[str, ...]:
    """Names of the forces at the points that hold the loops, and of the gear pairs."""
    names = []
    for loop in press.loops:
        points = {0: 1, 2: 2, 3: 3}[loop.held_rotations]
        names += [f"{loop.name} {k + 1}" if points > 1 else loop.name for k in range(points)]
    return (*(f"{name} {axis}" for name in names for axis in AXES), *(relation.name for relation in press.relations))
