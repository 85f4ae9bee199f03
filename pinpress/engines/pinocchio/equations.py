"""The equations of a linkage by Pinocchio's constraint models, one configuration at a time; their order is that of `engines.structure`.

This engine computes loops in space, any number of drivers and redundant equations, and by its results those of the other engines are
tested.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import pinocchio as pin

from ...common.quantities import Array
from ..rank import rank
from ..spatial.bodies import Placements
from ..spatial.equations import PARALLEL_TO_ROUNDING, Equations, Kinematics, Loops
from ..structure import Structure, configuration, data_of


@dataclass(frozen=True, eq=False, repr=False)
class Rows:
    """The equations at one configuration.

    Attributes:
        q: (nq,) the configuration.
        gaps: (rows,) what each equation misses [m].
        columns: (rows, nv) Jacobian of the gaps.
        held_directions: for every loop (3, 0 to 3) world axes, as columns, of the rotations that its bearing prevents.
    """

    q: Array
    gaps: Array
    columns: Array
    held_directions: list[Array]


class OneConfiguration:
    """The equations of a linkage by Pinocchio's constraint models. They are built for each call, because constraint models can be neither
    copied nor pickled."""

    def __init__(self, structure: Structure) -> None:
        self.model, self.loops, self.size, self.slots = structure.model, structure.loops, structure.size, structure.slots
        self.data = data_of(self.model)
        self.placements, self.wrenches = self.data.oMi, self.data.f  # live: fetching them costs more than the algorithm that fills them
        self.anchors = [
            pin.PointAnchorConstraintModel(self.model, k.joint1, pin.SE3(np.eye(3), k.point1), k.joint2, pin.SE3(np.eye(3), k.point2))
            for k in self.loops
        ]
        self.datas = [anchor.createData() for anchor in self.anchors]
        self.structure, self.incidence = structure, structure.incidence
        # of the joints that carry one end alone: the others would move a gap by rounding, or because it is open
        self.moving = [column != 0 for column in self.incidence.T]
        self.rows = 3 * len(self.loops) + sum(loop.held_rotations for loop in self.loops) + len(structure.relations)
        self.rotations_held = any(loop.held_rotations for loop in self.loops)

    def at(self, x: Array) -> Rows:
        """The equations at joint coordinates (nv,). Afterwards ``data`` has the placements there."""
        q = configuration(self.slots, x)
        pin.computeJointJacobians(self.model, self.data, q)
        gaps, columns = np.empty(self.rows), np.empty((self.rows, self.model.nv))
        for k, (anchor, d) in enumerate(zip(self.anchors, self.datas, strict=True)):
            anchor.calc(self.model, self.data, d)
            rotation = d.oMc1.rotation
            gaps[3 * k : 3 * k + 3] = rotation @ d.constraint_position_error
            columns[3 * k : 3 * k + 3] = rotation @ anchor.jacobian(self.model, self.data, d).reshape(3, self.model.nv) * self.moving[k]
        held = self._fill_rotation_rows(gaps, columns) if self.rotations_held else [np.empty((3, 0))] * len(self.loops)
        if relations := len(self.structure.relations):
            columns[-relations:] = self.structure.relation_slopes
            gaps[-relations:] = self.structure.relation_gaps(x[:, None])[:, 0]
            for k, joint, slope in self.structure.slopes_of_curves(x[:, None]):
                columns[k - relations, joint] = slope[0]
        return Rows(q, gaps, columns, held)

    def drift(self, rows: Rows, v: Array) -> Array:
        """Second derivative (rows,) of the gaps at joint rates (nv,) and no joint acceleration, without that of curves."""
        pin.forwardKinematics(self.model, self.data, rows.q, v, np.zeros(self.model.nv))
        result = np.zeros(self.rows)
        row = 3 * len(self.loops)
        for k, (anchor, d) in enumerate(zip(self.anchors, self.datas, strict=True)):
            anchor.calc(self.model, self.data, d)
            result[3 * k : 3 * k + 3] = d.oMc1.rotation @ d.constraint_acceleration_error
            if count := self.loops[k].held_rotations:
                (spin1, turned1), (spin2, turned2) = (self._spin(joint) for joint in (self.loops[k].joint1, self.loops[k].joint2))
                # of t . (spin2 - spin1), where the direction t turns with body 1
                result[row : row + count] = self.size * rows.held_directions[k].T @ (turned2 - turned1 + cross(spin2 - spin1, spin1))
                row += count
        return result

    def _fill_rotation_rows(self, gaps: Array, columns: Array) -> list[Array]:
        """Fill in the rows of the rotations that bearings prevent, and return their world axes."""
        turning, row, directions = self.data.J.reshape(6, -1)[3:], 3 * len(self.loops), []
        for k, loop in enumerate(self.loops):
            first, second = (
                self.placements[joint].rotation @ rotation
                for joint, rotation in ((loop.joint1, loop.rotation1), (loop.joint2, loop.rotation2))
            )
            if loop.type == "revolute":
                # the two axes are aligned, but may point against each other; axes across each other are a quarter turn apart either way
                error = cross(first[:, 0], second[:, 0]) * (-1.0 if first[:, 0] @ second[:, 0] < 0.0 else 1.0)
            elif loop.type == "fixed":
                error = first @ pin.log3(first.T @ second)
            else:
                error = np.zeros(3)
            held = first[:, 3 - loop.held_rotations :]
            gaps[row : row + loop.held_rotations] = self.size * held.T @ error
            turned = held.T @ (turning * self.incidence[:, k])
            turned[np.abs(turned) < PARALLEL_TO_ROUNDING] = 0.0
            columns[row : row + loop.held_rotations] = self.size * turned
            directions.append(held)
            row += loop.held_rotations
        return directions

    def _spin(self, joint: int) -> tuple[Array, Array]:
        """Angular velocity and acceleration (3,) of a joint's body in world axes [rad/s, rad/s2]."""
        rotation = self.placements[joint].rotation
        return rotation @ self.data.v[joint].angular, rotation @ self.data.a[joint].angular


def cross(first: Array, second: Array) -> Array:
    """The vector product of two vectors (3,); `numpy.cross` takes ten times as long for so few numbers."""
    (a, b, c), (x, y, z) = first.tolist(), second.tolist()
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


def one_by_one(structure: Structure) -> Kinematics:
    """Kinematics of a linkage by Pinocchio, for use within one call: they hold its data."""
    one = OneConfiguration(structure)
    return Kinematics(partial(_equations, one), partial(_drift, one), in_blocks=False)


def _equations(one: OneConfiguration, loops: Loops, x: Array) -> Equations:
    """The equations of a linkage at joint coordinates (nv, n)."""
    structure, (count, n) = loops.structure, x.shape
    gaps, entries = np.empty((loops.rows, n)), np.zeros((loops.entries.shape[1] + 1, n))
    rotation, origin = np.empty((count + 1, 3, 3, n)), np.empty((count + 1, 3, n))
    held = [np.empty((3, loop.held_rotations, n)) for loop in structure.loops]
    row, joint = loops.entries
    for i in range(n):
        rows = one.at(np.ascontiguousarray(x[:, i]))
        gaps[:, i], entries[:-1, i] = rows.gaps, rows.columns[row, joint]
        for body, placement in enumerate(one.placements):
            rotation[body, ..., i], origin[body, :, i] = placement.rotation, placement.translation
        for prevented, directions in zip(held, rows.held_directions, strict=True):
            prevented[..., i] = directions
    directions = np.array([axis.direction for axis in structure.axes])
    placed = Placements(rotation, origin, np.einsum("jikn,jk->jin", rotation[1:], directions))
    ends = origin[loops.joint] + np.einsum("elikn,elk->elin", rotation[loops.joint], loops.point)
    return Equations(loops, x, placed, ends, gaps, entries, held)


def _drift(one: OneConfiguration, loops: Loops, equations: Equations, v: Array) -> Array:
    """Second derivative (rows, n) of the gaps at joint rates (nv, n) and no joint acceleration."""
    result, nothing = np.empty_like(equations.gaps), np.empty(0)
    q = configuration(loops.structure.slots, equations.x)
    for i in range(v.shape[1]):
        rows = Rows(np.ascontiguousarray(q[:, i]), nothing, nothing, [np.ascontiguousarray(held[..., i]) for held in equations.held])
        result[:, i] = one.drift(rows, np.ascontiguousarray(v[:, i]))
    if loops.structure.curves:
        result[-len(loops.structure.relations) :] = loops.structure.relation_drift(equations.x, v)
    return result


def redundant(structure: Structure, x: Array) -> bool:
    """Whether some of the equations are redundant at joint coordinates (nv,)."""
    rows = OneConfiguration(structure).at(x)
    return rank(rows.columns, structure.rank_tolerance) < len(rows.gaps)
