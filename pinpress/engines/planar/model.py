"""A planar linkage as constant matrices over rotors, and in which order its equations are solved.

In the plane a vector is a complex number and a rotation a multiplication by a rotor u = exp(i phi). Every point of a linkage is then a
fixed linear combination of few functions of the configuration, its *basis* (nb, n):

    row 0         1                       the frame
    revolute      u of the link it turns  absolute rotor, 1 in the drawn pose
    prismatic     travel x u of its guide

so that positions, loop gaps and the columns of the loop Jacobian are ``rows @ basis``, and velocities and accelerations ``rows`` times the
basis' derivatives: one matrix product for all links and all crank angles. The rows are read once from the Pinocchio model in its drawn pose
(all joints at zero); complex numbers are components along ``axes[0]`` and ``axes[1]``, which with ``normal`` make a right-handed frame.

The equations are solved block by block (`ordered`), as a press linkage is a chain of dyads.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from graphlib import TopologicalSorter
from heapq import heapify, heappop, heappush
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ...common.quantities import Array, ComplexArray
from ..joints import Coupling, Entries, LoopJoint, Matrix, between, drawn_placements, matrix, plain
from ..joints import axes as joint_axes

if TYPE_CHECKING:
    from scipy.sparse import csr_array

EPSILON = float(np.finfo(float).eps)
PARALLEL = 1e-12  # joint axes further from the plane's normal than this [rad] make a linkage spatial


@dataclass(frozen=True, eq=False, repr=False)
class Plane:
    """Constants of a planar linkage; joints are counted as in v, loops as declared. See the module for ``basis``, and `engines.joints`
    for what a matrix is; ``dense`` has all of them as plain arrays.

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
        coupling_rows: the coupling equations row by row: coefficients by joints, rising.
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
    resists_tilting: NDArray[np.bool_]
    coupled: Matrix
    coupling_rows: tuple[Mapping[int, float], ...]
    offsets: Array
    followers: tuple[int, ...]
    blocks: tuple[Block, ...]
    driven: tuple[int | None, ...]
    subtree: Matrix
    incidence: Matrix
    loops_of_joint: tuple[Mapping[int, float], ...]
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


def to_complex(plane: Plane, vectors: Array) -> ComplexArray:
    """World vectors (..., 3) as complex numbers, what is along the normal left out."""
    return np.asarray(vectors @ plane.axes[0] + 1j * (vectors @ plane.axes[1]))


def to_world(plane: Plane, vectors: ComplexArray) -> Array:
    """Complex numbers (...) as world vectors (..., 3)."""
    return np.asarray(np.multiply.outer(vectors.real, plane.axes[0]) + np.multiply.outer(vectors.imag, plane.axes[1]))


def put_in_plane(plane: Plane, vectors: ComplexArray, out: Array) -> None:
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


def build_plane(
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
    incidence = [between(parents, loop.joint1 - 1, loop.joint2 - 1) for loop in loops]
    columns, owners = [], []
    for k, ((first, _), (second, _)) in enumerate(ends):
        for joint, sign in incidence[k].items():
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
    coupling_rows = tuple(
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
        resists_tilting=np.array([loop.held_rotations > 0 for loop in loops], dtype=bool),
        coupled=matrix(coupling_rows, count, count, float),
        coupling_rows=tuple({joint: by for joint, by in row.items() if by} for row in coupling_rows),
        offsets=np.array([unit * coupling.offset for coupling, unit in zip(couplings, units, strict=True)]),
        followers=tuple(coupling.follower for coupling in couplings),
        blocks=blocks,
        driven=tuple(driven.get(k) for k in range(len(loops))),
        subtree=matrix(_turned_over([dict.fromkeys(line, 1.0) for line in lines], count), count, count, float),
        incidence=matrix(_turned_over(incidence, count), len(loops), count, float),
        loops_of_joint=tuple(_turned_over(incidence, count)),
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
    place, found = drawn_placements(model), joint_axes(model)
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


FEW = 8  # loops and couplings of which all groups are tried


@dataclass(frozen=True, eq=False, repr=False)
class Block:
    """Equations that are solved together, and the joints that they determine: two equations a loop, one a coupling.

    Attributes:
        loops, couplings: indices.
        joints: indices (in v) of the joints this block determines; where there are fewer than equations, these are redundant.
        own: per loop, (joint, row of `Plane.closure`) of the columns of these joints in its Jacobian.
        known: per loop, the same of the joints of earlier blocks.
    """

    loops: tuple[int, ...]
    couplings: tuple[int, ...]
    joints: tuple[int, ...]
    own: tuple[tuple[tuple[int, int], ...], ...]
    known: tuple[tuple[tuple[int, int], ...], ...]

    @cached_property
    def redundant(self) -> int:
        """How many of its equations say nothing new."""
        return 2 * len(self.loops) + len(self.couplings) - len(self.joints)

    @cached_property
    def kind(self) -> str:
        """What has a closed solution: "dyad" (two joints close a loop), "lever" (one joint does), "gear" (a coupling); else "dense"."""
        shape = len(self.loops), len(self.couplings), len(self.joints)
        return {(1, 0, 2): "dyad", (1, 0, 1): "lever", (0, 1, 1): "gear"}.get(shape, "dense")


def ordered(
    owners: list[tuple[int, int]], loops: int, couplings: Sequence[Coupling], driver: int, joints: int, one_block: bool
) -> tuple[Block, ...] | None:
    """The smallest blocks in an order in which each needs only the ones before it; None where there is no such order.

    Of blocks equally small, one without redundant equations comes first.

    Args:
        owners: (loop, joint) of every column of the loop Jacobian, in the order of `Plane.closure`.
        loops, joints: how many there are.
        driver: index of its joint.
        one_block: all equations in one.
    """
    waiting = _Waiting(owners, loops, couplings, driver)
    rows = {owner: loops + row for row, owner in enumerate(owners)}
    known, blocks = {driver}, []
    while waiting.unknown:
        found = tuple(waiting.unknown) if one_block else waiting.next_group()
        if found is None:
            return None
        members = tuple(k for k in found if k < loops)
        unknown = tuple(sorted(waiting.gives(found)))
        if len(unknown) > sum(map(waiting.worth, found)):
            return None
        own = tuple(tuple((j, rows[k, j]) for j in unknown if j in waiting.involved[k]) for k in members)
        before = tuple(tuple((j, rows[k, j]) for j in sorted(waiting.involved[k] & known - {driver})) for k in members)
        blocks.append(Block(members, tuple(k - loops for k in found if k >= loops), unknown, own, before))
        if blocks[-1].redundant and not members:
            return None  # a ring of gear pairs: its idle torques reach no bearing, by which they could be shared
        known |= set(unknown)
        waiting.take(found, unknown)
    return tuple(blocks) if len(known) == joints else None


class _Waiting:
    """The loops, then couplings, that are in no block yet.

    Attributes:
        involved: joints that take part in each.
        unknown: those of them that no block gives yet, by loop or coupling, couplings first so
            that it is not them that are found to be redundant.
    """

    def __init__(self, owners: list[tuple[int, int]], loops: int, couplings: Sequence[Coupling], driver: int) -> None:
        self.loops = loops
        self.involved: list[set[int]] = [set() for _ in range(loops)] + [{c.follower, c.leader} for c in couplings]
        for loop, joint in owners:
            self.involved[loop].add(joint)
        self.unknown = {k: self.involved[k] - {driver} for k in (*range(loops, len(self.involved)), *range(loops))}
        self._places = {k: place for place, k in enumerate(self.unknown)}
        self._at: dict[int, set[int]] = {}  # loops and couplings by their unknown joints
        for k, unknown in self.unknown.items():
            for joint in unknown:
                self._at.setdefault(joint, set()).add(k)
        self._planned: list[tuple[int, ...]] = []
        self._ready = [(self.spare(k), place, k) for k, place in self._places.items() if self.spare(k) >= 0]
        heapify(self._ready)

    def worth(self, k: int) -> int:
        """How many joints it can determine."""
        return 2 if k < self.loops else 1

    def spare(self, k: int) -> int:
        """How many of its equations say nothing new once it has determined its joints; below 0 where it cannot do so alone."""
        return self.worth(k) - len(self.unknown[k])

    def gives(self, group: Collection[int]) -> set[int]:
        """The joints that a group gives."""
        return set().union(*(self.unknown[k] for k in group))

    def take(self, group: Collection[int], joints: Collection[int]) -> None:
        """A block of this group determines these joints."""
        for k in group:
            del self.unknown[k]
        for joint in joints:
            for k in self._at.pop(joint) & self.unknown.keys():
                self.unknown[k].discard(joint)
                if self.spare(k) >= 0:
                    heappush(self._ready, (self.spare(k), self._places[k], k))

    def next_group(self) -> tuple[int, ...] | None:
        """The next block's: one alone if there is one, else as few as possible that determine their joints together."""
        while self._ready:
            spare, _, k = self._ready[0]
            if k in self.unknown and spare == self.spare(k):
                return (k,)
            heappop(self._ready)
        return self._smallest() if len(self.unknown) <= FEW else self._dependent()

    def _smallest(self) -> tuple[int, ...] | None:
        """The smallest group, by trying all; None where there is none."""
        for size in range(2, len(self.unknown) + 1):
            found, fewest = None, 0
            for group in combinations(self.unknown, size):
                spare = sum(map(self.worth, group)) - len(self.gives(group))
                if spare >= 0 and (found is None or spare < fewest):
                    found, fewest = group, spare
            if found is not None:
                return found
        return None

    def _dependent(self) -> tuple[int, ...] | None:
        """Of many: the next group of those that need each other; None where there is none."""
        while self._planned and self.unknown.keys().isdisjoint(self._planned[-1]):
            self._planned.pop()
        planned = self._planned[-1] if self._planned else ()
        if not planned or not self.unknown.keys() >= set(planned) or sum(map(self.worth, planned)) < len(self.gives(planned)):
            self._planned = groups(self.unknown, self.worth)[::-1]
        return self._planned.pop() if self._planned else None


def groups(unknown: Mapping[int, set[int]], worth: Callable[[int], int]) -> list[tuple[int, ...]]:
    """Equations in groups that need each other, each group after those that it needs; none where some joint is left without an equation.

    Every joint is given to one equation that determines it, which then needs whoever has its other joints.

    Args:
        unknown: joints by loop or coupling.
        worth: how many joints each can determine.
    """
    from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching  # see `_graph`

    members = list(unknown)
    equations = [place for place, k in enumerate(members) for _ in range(worth(k))]
    joints = {joint: place for place, joint in enumerate(sorted(set().union(*unknown.values())))}
    entries = [(row, joints[joint]) for row, place in enumerate(equations) for joint in unknown[members[place]]]
    if not entries:
        return []
    given_by = maximum_bipartite_matching(_graph(entries, (len(equations), len(joints))), perm_type="row")
    if given_by.min() < 0:
        return []
    needs = [(place, equations[given_by[joints[joint]]]) for place, k in enumerate(members) for joint in unknown[k]]
    count, label = connected_components(_graph(needs, (len(members), len(members))), connection="strong")
    result: list[list[int]] = [[] for _ in range(count)]
    for k, its in zip(members, label.tolist(), strict=True):
        result[its].append(k)
    before: dict[int, set[int]] = {its: set() for its in range(count)}
    for one, other in needs:
        if label[one] != label[other]:
            before[int(label[one])].add(int(label[other]))
    return [tuple(result[its]) for its in TopologicalSorter(before).static_order()]


def _graph(entries: list[tuple[int, int]], shape: tuple[int, int]) -> csr_array:
    from scipy.sparse import csr_array  # its import takes longer than loading a small press

    return csr_array((np.ones(len(entries)), np.array(entries).T), shape=shape)
