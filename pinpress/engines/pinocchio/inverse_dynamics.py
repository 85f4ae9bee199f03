"""Inverse dynamics of any linkage by Pinocchio's recursive Newton-Euler algorithm and constraint models, one configuration at a time.

Multipliers, friction and the sharing of redundant forces are those of `spatial.inverse_dynamics`, for all configurations together, from
singular values of the whole in place of blocks.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from ..body_motion import components_first, turned, turned_back
from ..engine import ClosedStates
from ..spatial.equations import Equations, Loops
from ..spatial.inverse_dynamics import Method, OpenTree
from ..structure import Structure, configuration, data_of
from ..wrenches import AppliedForce
from .equations import one_by_one


def by_pinocchio(structure: Structure) -> Method:
    """How Pinocchio's engine computes, for use within one call."""
    return Method(one_by_one(structure), _open_tree)


def _open_tree(loops: Loops, equations: Equations, states: ClosedStates, loads: Sequence[AppliedForce]) -> OpenTree:
    """Forces of the open tree."""
    structure, rotation, (count, n) = loops.structure, equations.placed.rotation, states.v.shape
    data, q = data_of(structure.model), configuration(structure.slots, states.position)
    pushed = np.zeros((n, count + 1, 6))  # forces and moments of the loads in the frames of the joints
    for load in loads:
        local = turned_back(rotation[load.joint], load.force.T).T
        pushed[:, load.joint, :3] += local
        pushed[:, load.joint, 3:] += np.cross(load.point, local)
        if load.moment is not None:
            pushed[:, load.joint, 3:] += turned_back(rotation[load.joint], load.moment.T).T
    effort, local = np.empty((count, n)), components_first(count, n, 2)
    wrenches = data.f  # live: fetching it costs more than the algorithm that fills it
    for i in range(n):
        external = pin.StdVec_Force([pin.Force(wrench) for wrench in pushed[i]])
        at, v, a = (np.ascontiguousarray(values[:, i]) for values in (q, states.v, states.a))
        effort[:, i] = pin.rnea(structure.model, data, at, v, a, external)
        for joint in range(count):
            wrench = wrenches[joint + 1]
            local[0, joint, :, i], local[1, joint, :, i] = wrench.linear, wrench.angular
    if structure.model.armature.any():  # Pinocchio's efforts have it; here it counts as what acts in the joint
        effort -= structure.model.armature[:, None] * states.a
    return OpenTree(effort, turned(rotation[1:], local[0]), turned(rotation[1:], local[1]))
