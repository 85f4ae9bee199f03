"""A planar linkage as constant matrices over rotors, and the order in which its equations are solved.

In the plane a vector is a complex number, and a rotation is a multiplication by a rotor u = exp(i phi). Every point of a linkage is then a
constant linear combination of a few functions of the configuration, its *basis* (nb, n):

    row 0         1                       the frame
    revolute      u of the link it turns  absolute rotor, 1 in the drawn pose
    prismatic     travel x u of its guide

Positions and loop gaps are ``rows @ basis``, velocities and accelerations ``rows`` times the derivatives of the basis: one matrix product
for all links and all crank angles. The rows are read once from the Pinocchio model in its drawn pose (all joints at zero). Complex numbers
are components along ``axes[0]`` and ``axes[1]``, which with ``normal`` make a right-handed frame.

The equations are solved block by block (`ordered_blocks`), because a press linkage is a chain of dyads.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ...common.quantities import CRANK, RAM, Array, ComplexArray, DriverCoordinate
from ..blocks import ordered_groups
from ..constraints import Relation
from ..engine import PIECE
from ..structure import ACCEPTED, Structure, drawn_placements

COORDINATES = 40_960  # joint coordinates of the states that are worked through at a time: their arrays take some megabytes
PARALLEL = 1e-12  # a linkage is spatial where a joint axis is further from the plane's normal than this [rad]
ROUNDING = 1e-12  # share of the distances of points from the world origin below which the length of a loop is rounding


@dataclass(frozen=True, eq=False, repr=False)
class Block:
    """Equations that are solved together, two for each loop and one for each relation, and the joints that they determine.

    Attributes:
        loops: indices of the loops.
        relations: indices of the relations.
        joints: indices in v of the joints that this block determines; where there are more equations than joints, some are redundant.
    """

    loops: tuple[int, ...]
    relations: tuple[int, ...]
    joints: tuple[int, ...]

    @cached_property
    def redundant(self) -> int:
        """Number of redundant equations."""
        return 2 * len(self.loops) + len(self.relations) - len(self.joints)

    @cached_property
    def kind(self) -> str:
        """Kind of the block. Three have a closed solution: "dyad" (two joints close a loop), "lever" (one joint closes a loop) and "gear"
        (a relation determines a joint). All others are "dense"."""
        shape = len(self.loops), len(self.relations), len(self.joints)
        return {(1, 0, 2): "dyad", (1, 0, 1): "lever", (0, 1, 1): "gear"}.get(shape, "dense")


@dataclass(frozen=True, eq=False, repr=False)
class Plane:
    """Constants of a planar linkage. Joints are counted as in v, loops as declared.

    The module says what the basis is.

    Attributes:
        normal: (3,) unit normal of the plane in the world.
        axes: (2, 3) axes of the plane in the world.
        driver: index of the driver joint.
        parents: (nv,) index of every joint's parent joint, -1 for the frame.
        sense: (nv,) +1 where a revolute axis lies along the normal, -1 where it lies against it, 0 for a prismatic joint.
        revolute: indices of the revolute joints, in the order of the basis.
        prismatic: indices of the prismatic joints, in the order of the basis.
        turn: (nr, nv) joint angles to the absolute angles of the rotors.
        spin: (nv, nv) joint angles to the absolute angles of all links, also of those that only slide.
        frames: (nv, 3, 3) components in a joint's frame to those along axes[0], axes[1] and normal in the drawn pose.
        rotors: (nv,) basis row of the rotor of every joint's link, 0 for links that only translate.
        guide_rotors: (np,) basis row of the rotor that turns each prismatic direction, 0 where it does not turn.
        origins: (nv, nb) joint origins.
        centers: (nv, nb) centres of mass, from the origin of their joint.
        heights: (nv,) joint origins along the normal, from the world origin [m].
        center_heights: (nv,) centres of mass along the normal, from the world origin [m].
        directions: (np, nb) prismatic directions.
        gap_rows: (nl, nb) loop gaps, point 2 less point 1.
        loop_links: (nl,) joints of link 1 and link 2 of every loop, -1 for the frame.
        loop_points: (nl, nb) point 1 of every loop.
        loop_heights: (nl,) points of the loops along the normal, from the world origin [m].
        resists_tilting: (nl,) whether the loop's bearing keeps its links from tilting out of the plane: a revolute one does.
        relation_slopes: (nr, nv) slopes of the relations.
        relation_rows: (nr,) the same by joints, rising, without zeros.
        relation_units: (nr,) lengths by which relations are multiplied: ``size`` for those that determine a joint that turns, else 1.
        offsets: (nr,) right-hand sides of the relations.
        blocks: the equations in the order in which they are solved.
        subtree: (nv, nv) 1 where joint j (the row) carries the link of joint k.
        incidence: (nv, nl) +1 where joint j carries only end 2 of loop l, -1 where it carries only end 1.
        size: sum of the lengths round the largest loop [m].
    """

    normal: Array
    axes: Array
    driver: int
    parents: tuple[int, ...]
    sense: Array
    revolute: tuple[int, ...]
    prismatic: tuple[int, ...]
    turn: Array
    spin: Array
    frames: Array
    rotors: tuple[int, ...]
    guide_rotors: tuple[int, ...]
    origins: ComplexArray
    centers: ComplexArray
    heights: Array
    center_heights: Array
    directions: ComplexArray
    gap_rows: ComplexArray
    loop_links: tuple[tuple[int, int], ...]
    loop_points: ComplexArray
    loop_heights: Array
    resists_tilting: NDArray[np.bool_]
    relation_slopes: Array
    relation_rows: tuple[Mapping[int, float], ...]
    relation_units: Array
    offsets: Array
    blocks: tuple[Block, ...]
    subtree: Array
    incidence: Array
    size: float

    @property
    def coordinate(self) -> DriverCoordinate:
        """What the coordinate of the driver is."""
        return CRANK if self.sense[self.driver] else RAM

    @cached_property
    def rounding(self) -> float:
        """Gap that rounding leaves in a closed loop [m]."""
        return 8 * float(np.finfo(float).eps) * self.size

    @cached_property
    def tolerance(self) -> float:
        """Gap up to which a loop counts as closed [m]."""
        return ACCEPTED * self.rounding

    @cached_property
    def piece(self) -> int:
        """Number of states that are worked through at a time: more of a small linkage, where the number of calls decides."""
        return max(PIECE, COORDINATES // len(self.parents))

    @cached_property
    def guides(self) -> tuple[tuple[int, int, int], ...]:
        """For every prismatic joint its row of the basis, its index, and the row of the rotor that turns its direction (0: none)."""
        rows = range(1 + len(self.revolute), 1 + len(self.parents))
        return tuple(zip(rows, self.prismatic, self.guide_rotors, strict=True))

    @cached_property
    def world_components(self) -> tuple[tuple[int, float, float, float], ...]:
        """Indices of the world axes with the components of ``axes[0]``, ``axes[1]`` and ``normal`` along them."""
        parts = zip(range(3), *self.axes.tolist(), self.normal.tolist(), strict=True)
        return tuple((i, first, second, along) for i, first, second, along in parts)

    @cached_property
    def centripetal(self) -> ComplexArray:
        """(nl, nr) what the squared speeds of the rotors, times the rotors, add to the second derivatives of the gaps."""
        return -self.gap_rows[:, 1 : 1 + len(self.revolute)]

    @cached_property
    def loops_of_joint(self) -> tuple[dict[int, float], ...]:
        """(nv,) entries of ``incidence`` by loops, where they are not zero."""
        return tuple({k: float(row[k]) for k in np.flatnonzero(row).tolist()} for row in self.incidence)

    @cached_property
    def redundant(self) -> bool:
        """Whether some of the equations in the plane are redundant."""
        return any(block.redundant for block in self.blocks)

    def rotor(self, joint: int) -> int:
        """Basis row of the rotor of a joint's link; 0 for the frame (joint -1) and for links that only translate."""
        return self.rotors[joint] if joint >= 0 else 0

    def carriers(self, joint: int) -> list[int]:
        """The joint and all joints between it and the frame, rising."""
        line = []
        while joint >= 0:
            line.append(joint)
            joint = self.parents[joint]
        return line[::-1]

    def point(self, joint: int, arm: complex) -> ComplexArray:
        """Row (nb,) of a point of a joint's link, at ``arm`` from the joint's origin in the drawn pose."""
        row: ComplexArray = self.origins[joint].copy()
        row[self.rotor(joint)] += arm
        return row


def to_complex(plane: Plane, vectors: Array) -> ComplexArray:
    """World vectors (..., 3) as complex numbers; their components along the normal are left out."""
    return np.asarray(vectors @ plane.axes[0] + 1j * (vectors @ plane.axes[1]))


def to_world(plane: Plane, vectors: ComplexArray) -> Array:
    """Complex numbers (...) as world vectors (..., 3)."""
    return np.asarray(np.multiply.outer(vectors.real, plane.axes[0]) + np.multiply.outer(vectors.imag, plane.axes[1]))


def put_normal(plane: Plane, values: Array, out: Array) -> None:
    """Fill ``out`` (..., 3), zero so far, with vectors along the normal whose lengths are ``values`` (...)."""
    for i, _, _, along in plane.world_components:
        if along == 1.0:
            out[..., i] = values
        elif along == -1.0:
            np.negative(values, out=out[..., i])
        elif along:
            np.multiply(values, along, out=out[..., i])


def build_plane(structure: Structure, one_block: bool = False) -> Plane | None:
    """Constants of a linkage with one driver.

    None if the linkage is not planar, if a curve relates its joints, or if its equations do not fall into blocks with as many
    unknown joints as equations, or fewer.

    Args:
        structure: of the linkage.
        one_block: whether to solve all equations together.
    """
    model, loops, relations, driver = structure.model, structure.loops, structure.relations, structure.drivers[0]
    place, turning = drawn_placements(model), [axis.turns for axis in structure.axes]
    directions = [p.rotation @ axis.direction for p, axis in zip(place[1:], structure.axes, strict=True)]
    normal = None if structure.curves else _find_normal(structure, place, directions)
    if normal is None:
        return None
    tree, count = _planar_tree(structure, place, directions, normal), model.nv
    ends = [(tree.end(loop.joint1, loop.point1), tree.end(loop.joint2, loop.point2)) for loop in loops]
    gaps = np.array([second.row - first.row for first, second in ends]).reshape(len(ends), 1 + count)
    lengths = np.abs(gaps).sum(axis=1)
    if any(abs(first.height - second.height) > PARALLEL * length for (first, second), length in zip(ends, lengths, strict=True)):
        return None
    blocks = ordered_blocks(structure.joints_of_loop, relations, driver, count, one_block)
    if blocks is None:
        return None
    # the lengths round the loops, without travels along guides
    size = float(np.abs(gaps[:, : 1 + len(tree.revolute)]).sum(axis=1).max(initial=0.0))
    reach = max((float(np.abs(first.row).sum()) for first, _ in ends), default=0.0)
    if size <= ROUNDING * reach:  # slides alone go round the loops, so that the lengths round them are the rounding of points
        size = reach
    size = size or 1.0
    units = np.array([size if turning[relation.joint] else 1.0 for relation in relations])
    slopes = units[:, None] * structure.relation_coefficients
    carried = np.eye(count)  # by links: 1 for the joints that carry them
    for joint, parent in enumerate(structure.parents):
        if parent >= 0:
            carried[joint] += carried[parent]
    spin = carried * tree.sense
    centers: ComplexArray = np.zeros((count, 1 + count), complex)
    for j, inertia in enumerate(list(model.inertias)[1:]):
        centers[j, tree.rotors[j]] = tree.flat(place[j + 1].rotation @ inertia.lever)
    guide_rotors = tuple(tree.rotor(structure.parents[j]) for j in tree.prismatic)
    guide_directions: ComplexArray = np.zeros((len(tree.prismatic), 1 + count), complex)
    for k, (j, rotor) in enumerate(zip(tree.prismatic, guide_rotors, strict=True)):
        guide_directions[k, rotor] = tree.flat(directions[j])
    return Plane(
        normal=tree.normal,
        axes=tree.axes,
        driver=driver,
        parents=structure.parents,
        sense=tree.sense,
        revolute=tree.revolute,
        prismatic=tree.prismatic,
        turn=spin[list(tree.revolute)],
        spin=spin,
        frames=np.array([np.array([*tree.axes, tree.normal]) @ p.rotation for p in place[1:]]),
        rotors=tree.rotors,
        guide_rotors=guide_rotors,
        origins=tree.origins,
        centers=centers,
        heights=np.array([p.translation @ tree.normal for p in place[1:]]),
        center_heights=np.array([place[j].act(model.inertias[j].lever) @ tree.normal for j in range(1, count + 1)]),
        directions=guide_directions,
        gap_rows=gaps,
        loop_links=tuple((loop.joint1 - 1, loop.joint2 - 1) for loop in loops),
        loop_points=np.array([first.row for first, _ in ends]).reshape(len(ends), 1 + count),
        loop_heights=np.array([first.height for first, _ in ends]),
        resists_tilting=np.array([loop.held_rotations > 0 for loop in loops], dtype=bool),
        relation_slopes=slopes,
        relation_rows=tuple({joint: float(row[joint]) for joint in np.flatnonzero(row).tolist()} for row in slopes),
        relation_units=units,
        offsets=units * [relation.offset for relation in relations],
        blocks=blocks,
        subtree=carried.T.copy(),
        incidence=structure.incidence,
        size=size,
    )


def _find_normal(structure: Structure, place: Sequence[pin.SE3], directions: Sequence[Array]) -> Array | None:
    """The normal of the plane in which a linkage moves; None if it is not planar, or no joint turns.

    It is the axis of the driver, or of the first joint that turns where the driver slides.

    Args:
        structure: of the linkage.
        place: placements of the world and the joints in the drawn pose.
        directions: axes of the joints in the world.
    """
    turning = [axis.turns for axis in structure.axes]
    driver = structure.drivers[0]
    joint = driver if turning[driver] else next((j for j, turns in enumerate(turning) if turns), None)
    if joint is None:
        return None
    normal = directions[joint]

    def is_parallel(axis: Array) -> bool:
        return float(np.linalg.norm(np.cross(axis, normal))) <= PARALLEL

    if not all(is_parallel(axis) if turns else abs(axis @ normal) <= PARALLEL for axis, turns in zip(directions, turning, strict=True)):
        return None
    for loop in structure.loops:
        axes = (place[loop.joint1].rotation @ loop.rotation1[:, 0], place[loop.joint2].rotation @ loop.rotation2[:, 0])
        if loop.type == "fixed" or (loop.type == "revolute" and not all(map(is_parallel, axes))):
            return None
    return normal


class _End(NamedTuple):
    """A point of a link: its row (nb,) over the basis, and its height along the normal [m]."""

    row: ComplexArray
    height: float


class _PlanarTree(NamedTuple):
    """The tree of a planar linkage in its drawn pose, as rows over the basis. Attributes are those of `Plane`, the placements of the world
    and the joints, and the complex positions of the joint origins [m]."""

    place: Sequence[pin.SE3]
    positions: list[complex]
    normal: Array
    axes: Array
    sense: Array
    revolute: tuple[int, ...]
    prismatic: tuple[int, ...]
    rotors: tuple[int, ...]
    origins: ComplexArray

    def flat(self, vector: Array) -> complex:
        """A world vector (3,) as a complex number."""
        return complex(*(self.axes @ vector))

    def rotor(self, joint: int) -> int:
        """`Plane.rotor`."""
        return self.rotors[joint] if joint >= 0 else 0

    def end(self, joint: int, point: Array) -> _End:
        """A point (3,) in the frame of a Pinocchio joint, 0 for the frame."""
        world = self.place[joint].act(point)
        row = self.origins[joint - 1].copy() if joint else np.zeros(self.origins.shape[1], complex)
        row[self.rotor(joint - 1)] += self.flat(world) - (self.positions[joint - 1] if joint else 0.0)
        return _End(row, float(world @ self.normal))


def _planar_tree(structure: Structure, place: Sequence[pin.SE3], directions: Sequence[Array], normal: Array) -> _PlanarTree:
    """The tree; arguments as of `_find_normal`, and what it returned."""
    normal = normal / np.linalg.norm(normal)
    start = np.eye(3)[1 if abs(normal[0]) > 0.9 else 0]  # world x, or y where x is the normal
    first = start - (start @ normal) * normal
    first /= np.linalg.norm(first)
    axes = np.array([first, np.cross(normal, first)]) + 0.0  # + 0.0 turns -0.0 into 0.0
    turning = [axis.turns for axis in structure.axes]
    revolute, prismatic = (tuple(j for j, turns in enumerate(turning) if turns is kind) for kind in (True, False))
    sense = np.array([np.sign(d @ normal) if t else 0.0 for d, t in zip(directions, turning, strict=True)])
    positions = [complex(*(axes @ placement.translation)) for placement in place[1:]]
    row_of = {j: row for row, j in enumerate((*revolute, *prismatic), 1)}  # of the basis
    rotors: list[int] = []
    origins: ComplexArray = np.zeros((len(turning), 1 + len(turning)), complex)
    for j, parent in enumerate(structure.parents):  # parents come before their children in Pinocchio
        carrier = rotors[parent] if parent >= 0 else 0
        rotors.append(row_of[j] if turning[j] else carrier)
        if parent >= 0:
            origins[j] = origins[parent]
        origins[j, carrier] += positions[j] - (positions[parent] if parent >= 0 else 0.0)
        if not turning[j]:
            origins[j, row_of[j]] = complex(*(axes @ directions[j]))
    return _PlanarTree(place, positions, normal, axes, sense, revolute, prismatic, tuple(rotors), origins)


# ------------------------------------------------------------------------------------------------ the order in which equations are solved


def ordered_blocks(
    between: Sequence[Collection[int]], relations: Sequence[Relation], driver: int, joints: int, one_block: bool
) -> tuple[Block, ...] | None:
    """The equations in blocks as small as possible, ordered so that each needs only the joints of the ones before it.

    Among equally small blocks those without redundant equations come first. None if there is no such order.

    Args:
        between: of every loop the joints between its ends.
        relations: between joint coordinates.
        driver: index of the driver joint.
        joints: number of joints.
        one_block: whether to put all equations into one block.
    """
    loops = len(between)
    # relations stand first, so that redundant equations are found among the loops
    involved: dict[int, Collection[int]] = {loops + k: set(relation.coefficients) for k, relation in enumerate(relations)}
    involved |= dict(enumerate(between))
    known, blocks = {driver}, []
    for found, unknown in ordered_groups(involved, lambda k: 2 if k < loops else 1, known, one_block=one_block) or ():
        members = tuple(k for k in found if k < loops)
        blocks.append(Block(members, tuple(k - loops for k in found if k >= loops), unknown))
        if blocks[-1].redundant and not members:
            return None  # a ring of gear pairs: its idle torques load no bearing, so that nothing decides how they are shared
        known |= set(unknown)
    return tuple(blocks) if len(known) == joints else None
