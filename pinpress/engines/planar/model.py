"""A planar linkage as constant matrices over rotors.

In the plane a vector is a complex number and a rotation a multiplication by a rotor u = exp(i phi). Every point of a linkage is then a
fixed linear combination of few functions of the configuration, its *basis* (nb, n):

    row 0         1                       the frame
    revolute      u of the link it turns  absolute rotor, 1 in the drawn pose
    prismatic     travel x u of its guide

so that positions, loop gaps and the columns of the loop Jacobian are ``rows @ basis``, and velocities and accelerations ``rows`` times the
basis' derivatives: one matrix product for all links and all crank angles. The rows are read once from the Pinocchio model in its drawn pose
(all joints at zero); complex numbers are components along ``axes[0]`` and ``axes[1]``, which with ``normal`` make a right-handed frame.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ...common.arrays import Array, ComplexArray
from ..constant_rows import Entries, Matrix, matrix, plain
from ..joints import Coupling, LoopJoint, between, drawn
from ..joints import axes as joint_axes
from .blocks import Block, ordered

EPSILON = float(np.finfo(float).eps)
PARALLEL = 1e-12  # joint axes further from the plane's normal than this [rad] make a linkage spatial


@dataclass(frozen=True, eq=False, repr=False)
class Plane:
    """Constants of a planar linkage; joints are counted as in v, loops as declared. See the module for ``basis``, and `constant_rows` for
    what a matrix is; ``dense`` has all of them as plain arrays.

    Attributes:
        normal, axes: (3,) and (2, 3) world directions.
        driver: index of the driver joint.
        parents: index of every joint's parent joint, -1 for the frame.
        sense: (nv,) +1 or -1 where a revolute axis lies along or against the normal, 0 for a prismatic joint.
        revolute, prismatic: joint indices in the order of the basis.
        turn: (nr, nv) absolute angles of the rotors from joint angles.
        spin: (nv, nv) the same of every link, also where it only slides.
        frames: (nv, 3, 3) a vector in a joint's frame to its components along axes[0], axes[1], normal in the drawn pose.
        rotors: (nv,) basis row of the rotor of every joint's link; 0 of links that only translate.
        guide_rotors: (np,) basis row of the rotor that carries each prismatic direction.
        origins, centers: (nv, nb) joint origins; centres of mass relative to their joint's origin.
        heights, center_heights: (nv,) the same along the normal, centres from the world origin [m].
        directions: (np, nb) prismatic directions.
        closure: (nl + columns, nb) loop gaps (point 2 minus point 1), then the columns of the loop Jacobian.
        loop_points: (nl, nb) point 1 of every loop.
        loop_heights: (nl,) along the normal [m].
        holding: (nl,) whether the loop's bearing holds its links upright: a revolute one does.
        coupled: (nc, nv) coefficients of the coupling equations, turning ones in lengths of the linkage.
        offsets: (nc,) right-hand sides.
        gears: the same row by row, coefficients by joints, rising.
        followers: (nc,) joints whose coordinate the couplings give.
        blocks: the order in which equations are solved.
        driven: per loop, row of the driver's column, None where it does not move the loop.
        subtree: (nv, nv) 1 where the link of joint k hangs on joint j.
        crossed: (nv, nl) +1 / -1 where loop l's point 2 / 1 hangs on joint j.
        round_loops: the same joint by joint, by loops, rising.
        size: of the largest loop: sum of the lengths round it [m].
    """

    normal: Array
    axes: Array
    driver: int
    parents: tuple[int, ...]
    sense: Array
    revolute: tuple[int, ...]
    prismatic: tuple[int, ...]
    turn: Matrix
    spin: Matrix
    frames: Array
    rotors: tuple[int, ...]
    guide_rotors: tuple[int, ...]
    origins: Matrix
    centers: Matrix
    heights: Array
    center_heights: Array
    directions: Matrix
    closure: Matrix
    loop_points: Matrix
    loop_heights: Array
    holding: NDArray[np.bool_]
    coupled: Matrix
    gears: tuple[Mapping[int, float], ...]
    offsets: Array
    followers: tuple[int, ...]
    blocks: tuple[Block, ...]
    driven: tuple[int | None, ...]
    subtree: Matrix
    crossed: Matrix
    round_loops: tuple[Mapping[int, float], ...]
    size: float

    @cached_property
    def tolerance(self) -> float:
        """Gap at which a loop is closed to rounding [m]."""
        return 8 * EPSILON * self.size

    @cached_property
    def redundant(self) -> bool:
        """Whether some of the equations in the plane say nothing new."""
        return any(block.redundant for block in self.blocks)

    @property
    def dense(self) -> Plane:
        """The constants with plain arrays for matrices."""
        return self if isinstance(self.closure, np.ndarray) else self._dense

    @cached_property
    def _dense(self) -> Plane:
        matrices = {field.name: plain(getattr(self, field.name)) for field in fields(self) if field.type is Matrix}
        return replace(self, **matrices)

    def rotor(self, joint: int) -> int:
        """Basis row of the rotor of a joint's link; 0 for the frame (joint -1) and for links that only translate."""
        return self.rotors[joint] if joint >= 0 else 0

    def carriers(self, joint: int) -> list[int]:
        """The joint and all joints between it and the frame."""
        return _ancestry(self.parents, joint)

    def point(self, joint: int, arm: complex) -> ComplexArray:
        """Row (nb,) of a point of a joint's link, at ``arm`` from the joint's origin in the drawn pose."""
        row: ComplexArray = plain(self.origins[[joint]])[0].copy()
        row[self.rotor(joint)] += arm
        return row


def flat(plane: Plane, vectors: Array) -> ComplexArray:
    """World vectors (..., 3) as complex numbers, what is along the normal left out."""
    return np.asarray(vectors @ plane.axes[0] + 1j * (vectors @ plane.axes[1]))


def in_space(plane: Plane, vectors: ComplexArray) -> Array:
    """Complex numbers (...) as world vectors (..., 3)."""
    return np.asarray(np.multiply.outer(vectors.real, plane.axes[0]) + np.multiply.outer(vectors.imag, plane.axes[1]))


def put(plane: Plane, vectors: ComplexArray, out: Array) -> None:
    """Fill ``out`` (..., 3), zero so far, with complex vectors (...). Most presses stand in a coordinate plane: zeros cost nothing."""
    for i, (first, second) in enumerate(plane.axes.T):
        if first:
            np.multiply(vectors.real, first, out=out[..., i])
        if second and first:
            out[..., i] += second * vectors.imag
        elif second:
            np.multiply(vectors.imag, second, out=out[..., i])


def put_normal(plane: Plane, values: Array, out: Array) -> None:
    """Fill ``out`` (n, 3), zero so far, with vectors of lengths (n,) along the normal."""
    for i, share in enumerate(plane.normal):
        if share:
            np.multiply(values, share, out=out[:, i])


def build(
    model: pin.Model, loops: Sequence[LoopJoint], couplings: Sequence[Coupling], driver: int, one_block: bool = False
) -> Plane | None:
    """Constants of a linkage whose driver turns, or None where it is not planar or its equations do not fall into blocks with as many
    unknown joints, or fewer. ``one_block``: solve all equations together."""
    place, directions, turning = _drawn_joints(model)
    if _misalignment(directions, turning, driver) > PARALLEL or not all(_lies_across(loop, place, directions[driver]) for loop in loops):
        return None
    count = model.nv
    normal, axes = _frame(directions[driver])
    sense = np.array([np.sign(d @ normal) if t else 0.0 for d, t in zip(directions, turning, strict=True)])

    def in_plane(vector: Array) -> complex:
        return complex(*(axes @ vector))

    parents = tuple(int(parent) - 1 for parent in list(model.parents)[1:])
    revolute, prismatic = (tuple(j for j in range(count) if turning[j] is turns) for turns in (True, False))
    position = [in_plane(place[j + 1].translation) for j in range(count)]
    rotors: list[int] = []
    row_of = {j: row for row, j in enumerate((*revolute, *prismatic), 1)}  # of the basis
    origins: list[dict[int, complex]] = []
    directed: dict[int, dict[int, complex]] = {}
    for j, parent in enumerate(parents):  # parents come before their children in Pinocchio
        carrier = rotors[parent] if parent >= 0 else 0
        rotors.append(row_of[j] if turning[j] else carrier)
        step = position[j] - (position[parent] if parent >= 0 else 0.0)
        origins.append(_moved(origins[parent] if parent >= 0 else {}, carrier, step))
        if not turning[j]:
            origins[j][row_of[j]] = in_plane(directions[j])
            directed[j] = {carrier: in_plane(directions[j])}

    def end(joint: int, point: Array) -> tuple[dict[int, complex], float]:
        world = place[joint].act(point)
        start, carrier, origin = (origins[joint - 1], rotors[joint - 1], position[joint - 1]) if joint else ({}, 0, 0.0)
        return _moved(start, carrier, in_plane(world) - origin), float(world @ normal)

    ends = [(end(loop.joint1, loop.point1), end(loop.joint2, loop.point2)) for loop in loops]
    gaps = [_difference(second, first) for (first, _), (second, _) in ends]
    if any(abs(first[1] - second[1]) > PARALLEL * _length(gap) for (first, second), gap in zip(ends, gaps, strict=True)):
        return None
    crossed = [between(parents, loop.joint1 - 1, loop.joint2 - 1) for loop in loops]
    columns, owners = [], []
    for k, ((first, _), (second, _)) in enumerate(ends):
        for joint, sign in crossed[k].items():
            if turning[joint]:
                arm = _difference(second if sign > 0 else first, origins[joint])
                columns.append({row: 1j * sense[joint] * sign * entry for row, entry in arm.items()})
            else:
                columns.append({row: sign * entry for row, entry in directed[joint].items()})
            owners.append((k, joint))
    blocks = ordered(owners, len(loops), couplings, driver, count, one_block)
    if blocks is None:
        return None
    size = max((_length({row: entry for row, entry in gap.items() if row <= len(revolute)}) for gap in gaps), default=1.0)
    units = [size if turning[coupling.follower] else 1.0 for coupling in couplings]
    gears = tuple(
        dict(sorted({c.follower: unit, c.leader: -unit * c.multiplier}.items())) for c, unit in zip(couplings, units, strict=True)
    )
    driven = {k: len(loops) + row for row, (k, joint) in enumerate(owners) if joint == driver}
    lines = [_ancestry(parents, j) for j in range(count)]
    spin = [{k: sense[k] for k in line if turning[k]} for line in lines]
    return Plane(
        normal=normal,
        axes=axes,
        driver=driver,
        parents=parents,
        sense=sense,
        revolute=revolute,
        prismatic=prismatic,
        turn=matrix([spin[j] for j in revolute], count, count, float),
        spin=matrix(spin, count, count, float),
        frames=np.array([np.array([*axes, normal]) @ p.rotation for p in place[1:]]),
        rotors=tuple(rotors),
        guide_rotors=tuple(next(iter(directed[j])) for j in prismatic),
        origins=matrix(origins, 1 + count, count),
        centers=matrix(
            [{rotors[j]: in_plane(place[j + 1].rotation @ model.inertias[j + 1].lever)} for j in range(count)], 1 + count, count
        ),
        heights=np.array([p.translation @ normal for p in place[1:]]),
        center_heights=np.array([place[j].act(model.inertias[j].lever) @ normal for j in range(1, count + 1)]),
        directions=matrix([directed[j] for j in prismatic], 1 + count, count),
        closure=matrix(gaps + columns, 1 + count, count),
        loop_points=matrix([first for (first, _), _ in ends], 1 + count, count),
        loop_heights=np.array([height for (_, height), _ in ends]),
        holding=np.array([loop.held > 0 for loop in loops], dtype=bool),
        coupled=matrix(gears, count, count, float),
        gears=tuple({joint: by for joint, by in gear.items() if by} for gear in gears),
        offsets=np.array([unit * coupling.offset for coupling, unit in zip(couplings, units, strict=True)]),
        followers=tuple(coupling.follower for coupling in couplings),
        blocks=blocks,
        driven=tuple(driven.get(k) for k in range(len(loops))),
        subtree=matrix(_turned_over([dict.fromkeys(line, 1.0) for line in lines], count), count, count, float),
        crossed=matrix(_turned_over(crossed, count), len(loops), count, float),
        round_loops=tuple(_turned_over(crossed, count)),
        size=size,
    )


def _misalignment(directions: Sequence[Array], turning: Sequence[bool], driver: int) -> float:
    """Largest angle [rad] by which a turning axis misses the direction of the driver's, or a sliding one the plane across it."""
    normal = directions[driver]
    return max(
        float(np.linalg.norm(np.cross(d, normal)) if turns else abs(d @ normal)) for d, turns in zip(directions, turning, strict=True)
    )


def _drawn_joints(model: pin.Model) -> tuple[list[pin.SE3], list[Array], list[bool]]:
    """Placements of the world and the joints in the drawn pose, the joints' axes in the world, and whether they turn."""
    place, found = drawn(model), joint_axes(model)
    return place, [p.rotation @ axis.direction for p, axis in zip(place[1:], found, strict=True)], [axis.turns for axis in found]


def _lies_across(loop: LoopJoint, place: Sequence[pin.SE3], normal: Array) -> bool:
    """Whether a loop's bearing lets its links move in the plane: a spherical one does, a revolute one with its axis along the normal."""
    ends = ((loop.joint1, loop.rotation1[:, 0]), (loop.joint2, loop.rotation2[:, 0]))
    return loop.type == "spherical" or (
        loop.type == "revolute"
        and all(float(np.linalg.norm(np.cross(place[joint].rotation @ axis, normal))) <= PARALLEL for joint, axis in ends)
    )


def _moved(row: Entries, rotor: int, step: complex) -> dict[int, complex]:
    """The row of a point that is a ``step`` of a rotor's link further on."""
    return {**row, rotor: row.get(rotor, 0j) + step}


def _difference(row: Entries, other: Entries) -> dict[int, complex]:
    """One row less another; what is in both alike is left out."""
    entries = {column: row.get(column, 0j) - other.get(column, 0j) for column in sorted({*row, *other})}
    return {column: entry for column, entry in entries.items() if entry}


def _length(row: Entries) -> float:
    return float(np.abs(np.array(list(row.values()))).sum())


def _turned_over(rows: Sequence[Mapping[int, float]], count: int) -> list[dict[int, float]]:
    """Rows of the transposed matrix."""
    result: list[dict[int, float]] = [{} for _ in range(count)]
    for place, row in enumerate(rows):
        for column, entry in row.items():
            result[column][place] = entry
    return result


def _ancestry(parents: Sequence[int], joint: int) -> list[int]:
    """The joint and all joints between it and the frame, rising."""
    line = []
    while joint >= 0:
        line.append(joint)
        joint = parents[joint]
    return line[::-1]


def _frame(normal: Array) -> tuple[Array, Array]:
    """Unit normal and the two axes of the plane, world x (or y, where x is the normal) projected into it first."""
    normal = normal / np.linalg.norm(normal)
    start = np.eye(3)[1 if abs(normal[0]) > 0.9 else 0]
    first = start - (start @ normal) * normal
    first /= np.linalg.norm(first)
    return normal, np.array([first, np.cross(normal, first)]) + 0.0  # + 0.0 turns -0.0 into 0.0
