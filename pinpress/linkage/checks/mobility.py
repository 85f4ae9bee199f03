"""Mobility of a linkage at one configuration: which joints can move, which equations are redundant, which loop or gear pair is too many.

A joint or an equation takes part in a free motion, or in a redundancy, if its share of the null vectors is above rounding error.
"""

from typing import NamedTuple

import numpy as np

from ...common.quantities import Array
from ...engines.constraints import LoopJoint, Relation
from ...engines.pinocchio.equations import Rows
from ...engines.rank import PassiveJacobian, rank, singular_values
from ..driving.freedoms import generic_ways
from ..linkage import Linkage
from ..machine_elements import WORDS

TAKES_PART = 1e-6  # share of a unit null vector above which a joint or an equation takes part in it


class Constraint(NamedTuple):
    """A loop or relation, such as a gear pair, and its equations.

    Attributes:
        by: the loop joint or relation.
        points: indices of its equations of points.
        turns: indices of its equations of rotations, or of the relation.
        kind: of the contact that the relation stands for; empty for others.
    """

    by: LoopJoint | Relation
    points: tuple[int, ...]
    turns: tuple[int, ...]
    kind: str = ""

    @property
    def title(self) -> str:
        if isinstance(self.by, LoopJoint):
            return f"loop {self.by.name!r}"
        if self.kind:
            return f"{WORDS[self.kind]} {self.by.name!r}"
        return f"{'gear pair' if self.by.is_pair else 'relation'} of joint {self.by.name!r}"

    def gap(self, gaps: Array) -> float:
        """How far it is from being closed, from the gaps (rows,) of all equations; rotations count in lengths of the linkage [m]."""
        return max(float(np.linalg.norm(gaps[list(self.points)])), float(np.abs(gaps[list(self.turns)]).max(initial=0.0)))


def element(press: Linkage, each: Constraint) -> str:
    """The element of a loop or gear pair, as messages call it."""
    if isinstance(each.by, LoopJoint):
        return press.document.called("loop_joint", each.by.name)
    if each.kind:
        return press.document.called("gear_mesh" if each.kind == "gears" else each.kind, each.by.name)
    for relation in press.document.description.relations:
        if each.by.name == relation.joints[0]:
            return press.document.called("relation", relation.name)
    return f"<mimic> of {press.document.called('joint', each.by.name)}"


class Redundancy(NamedTuple):
    """Numbers of redundant equations out of the plane of a planar linkage, which parallel axes fulfil in any case, and of further ones; and
    the loops and gear pairs that take part in the further ones."""

    out_of_plane: int
    further: int
    among: tuple[Constraint, ...]


def constraints(press: Linkage) -> list[Constraint]:
    """All loops, then relations, with the indices of their equations (see `engines.structure`)."""
    result, row = [], 3 * len(press.loops)
    for k, loop in enumerate(press.loops):
        result.append(Constraint(loop, (3 * k, 3 * k + 1, 3 * k + 2), tuple(range(row, row + loop.held_rotations))))
        row += loop.held_rotations
    kinds = {contact.relation: contact.kind for contact in press.contacts}
    return result + [Constraint(relation, (), (row + k,), kinds.get(k, "")) for k, relation in enumerate(press.relations)]


def opening(press: Linkage, each: Constraint, gaps: Array) -> tuple[float, float]:
    """How far a loop or gear pair is from being closed, from the gaps (rows,) of all equations: distance [m] and angle [rad]."""
    distance, turned = float(np.linalg.norm(gaps[list(each.points)])), float(np.linalg.norm(gaps[list(each.turns)]))
    if isinstance(each.by, Relation) and not press.axes[each.by.joint].turns:
        return turned, 0.0
    angle = turned / press.size
    return distance, float(np.arcsin(min(angle, 1.0))) if isinstance(each.by, LoopJoint) and each.by.type == "revolute" else angle


def undetermined_joints(press: Linkage, rows: Rows) -> list[str]:
    """Names of the joints that can still move while the drivers stand still."""
    passive = PassiveJacobian(rows.columns, press.structure)
    shares = np.linalg.norm(passive.right[passive.rank :], axis=0)
    return [press.joints[j] for j, share in zip(passive.joints, shares, strict=True) if share > TAKES_PART]


def overconstraining(press: Linkage, rows: Rows) -> list[Constraint]:
    """The loops and gear pairs that are one too many: without this one alone, the drivers would move the linkage and determine it."""
    drivers = len(press.drivers)
    return [each for each, columns in _without_one(press, rows) if _freedom(press, columns) == (drivers, drivers)]


def locking(press: Linkage, rows: Rows) -> list[Constraint]:
    """The loops and gear pairs that lock a linkage: without this one alone, some of its drivers could move."""
    return [each for each, columns in _without_one(press, rows) if _freedom(press, columns)[1] > 0]


def contradicting(press: Linkage) -> list[Constraint]:
    """The loops and gear pairs that a linkage with a misfit leaves open in its closed pose; where it happens to close there, those whose
    equations are redundant."""
    rows = press.assembly.rows
    left = np.abs(rows.gaps)
    if left.max() < 0.1 * press.assembly.misfit:
        left = np.linalg.norm(PassiveJacobian(rows.columns, press.structure).idle, axis=1)
    return [each for each in constraints(press) if left[[*each.points, *each.turns]].max() > 0.1 * left.max()]


def _without_one(press: Linkage, rows: Rows) -> list[tuple[Constraint, Array]]:
    """Every loop and gear pair, with the Jacobian of the equations of all others."""
    return [(each, np.delete(rows.columns, each.points + each.turns, axis=0)) for each in constraints(press)]


def _freedom(press: Linkage, columns: Array) -> tuple[int, int]:
    """Degrees of freedom, and how many of them the drivers determine."""
    passive, tolerance = columns[:, press.structure.passive_joints], press.structure.rank_tolerance
    mobility = int(columns.shape[1]) - rank(columns, tolerance)
    return mobility, mobility - (int(passive.shape[1]) - rank(passive, tolerance))


def redundancy(press: Linkage, x: Array) -> Redundancy:
    """The redundant equations at closed joint coordinates (nv,)."""
    plane = press.planarity
    if not press.engine().redundant(x):
        return Redundancy(sum(1 + loop.held_rotations for loop in press.loops) if plane.is_planar else 0, 0, ())
    rows = press.equations(x)
    single = np.eye(len(rows.gaps))
    parts, owners = [], []
    for k, each in enumerate(constraints(press)):
        part = single[[*each.points, *each.turns]]
        if each.points and plane.is_planar:
            part = np.linalg.svd(plane.normal[None])[2][1:] @ single[list(each.points)]
            if len(each.turns) == 3:  # a weld holds a rotation in the plane too, a pin only those out of it
                part = np.vstack([part, plane.normal @ rows.held_directions[k] @ single[list(each.turns)]])
        parts.append(part)
        owners += [each] * len(part)
    equations = np.vstack(parts) if parts else single
    idle = PassiveJacobian(equations @ rows.columns, press.structure).idle
    taking = [each for each, share in zip(owners, np.linalg.norm(idle, axis=1), strict=True) if share > TAKES_PART]
    return Redundancy(len(single) - len(equations), idle.shape[1], tuple(each for each in constraints(press) if each in taking))


def freedom_nearby(press: Linkage) -> int:
    """Degrees of freedom in a random pose near the drawn one, where no equation is redundant by chance."""
    away = np.random.default_rng(0).uniform(-1e-3, 1e-3, press.model.nv)  # a thousand times the rounding of files
    nearby = press.closed + away * press.lengths
    return int(press.model.nv) - rank(press.equations(nearby).columns, press.structure.rank_tolerance)


def is_shaky(press: Linkage) -> bool:
    """Whether equations that are redundant in the drawn pose are so in closed poses nearby too, as in two equal trammels that a rod joins.

    Near a change point the singular value that is zero there is about as large as the distance from it.
    """
    random = np.random.default_rng(0)
    # A robot may have more freedoms than drivers. A shaky linkage seems to have no more: its poses are closed to a root of rounding.
    last = press.model.nv - max(len(press.drivers), generic_ways(press.structure, press.closed)) - 1
    away, largest = 1e-2, 0.0  # distance of the poses [rad, lengths of the linkage]
    for _ in range(6):
        x = press.closed + away * press.lengths * random.uniform(-1, 1, press.model.nv)
        for _ in range(40):  # at a double root steps of Newton's method halve the distance, here from 1e-2 to rounding
            rows = press.equations(x)
            x = x - np.linalg.lstsq(rows.columns, rows.gaps, rcond=1e-9)[0]
        largest = max(largest, singular_value(press.equations(x).columns, last))
    return largest < 1e-3 * away  # a double root is found to the square root of rounding, 1e-8


def singular_value(columns: Array, index: int) -> float:
    """A singular value of a Jacobian, counted from the largest, 0; 0 if there are fewer equations."""
    values = singular_values(columns)
    return float(values[index]) if index < len(values) else 0.0


def rates_of_drivers(press: Linkage) -> Array:
    """(nv, drivers) rates of all joints at a unit rate of each driver alone, in the closed drawn pose."""
    rows, drivers = press.assembly.rows, list(press.driver_indices)
    passive = PassiveJacobian(rows.columns, press.structure)
    rates = np.array([passive.rates(-rows.columns[:, driver]) for driver in drivers]).T
    rates[drivers] = np.eye(len(drivers))
    return rates
