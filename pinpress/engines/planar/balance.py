"""The balance of forces of a planar linkage at n configurations: block by block backwards.

The power of a force f at a velocity v is Re(conj(f) v): the conjugates of forces are what appears everywhere, and here all forces are
conjugates until they are written to the result. The *work* of a function (see `functions`) is that of all inertia forces less weights and
loads on it: the force f at a point that moves with c times the function counts conj(f) c. Coordinates are those of `equations`. A rotor u
with the work W asks for the effort -Im(u W), a way along a guide with the rotor u for Re(u W). A block of loops and relations supplies the
efforts of the coordinates that it determines. With the inverses e1 and e2 of a dyad the force p of its loop is

    conj(p) = -(e1 effort1 + e2 effort2)

It takes c conj(p) from the work of every function that has the coefficient c in the loop. A relation acts between each of its joints and
what carries it. What is left at the driver is the driving torque.

Redundant equations of a block leave *idle* forces open, which the blocks before it balance: a lever supplies the effort of its rotor
across itself, and along it any force is left open. `engines.sharing` says how much of it is added.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...common.products import SERIAL_COMPLEX, SERIAL_COMPLEX_VECTOR
from ...common.quantities import Array, ComplexArray
from ..wrenches import AppliedForce
from .bodies import Bodies
from .dyads import I
from .equations import BlockRows, Configurations, Equations, LoopRows, efforts_of_joint, efforts_of_relation
from .functions import Functions
from .guide_moments import GuidedBody, guided_bodies
from .model import Plane, to_complex
from .sharing import shares_of_idle_forces

PIECE, SMALLEST_PIECE = 7200, 900  # most states that are worked through at a time, and those below which calls would take most of it
IN_CACHE = 40_000  # states times blocks whose arrays stay in the cache


class Tree(NamedTuple):
    """The links that hang on one joint of the frame.

    Attributes:
        joints: its joints, consecutive.
        rows: rows of functions, the row of ones first.
        to_work: second derivatives of the functions to the work on them.
        to_forces: the same to the forces of all links that each joint carries.
    """

    joints: slice
    rows: slice
    to_work: ComplexArray
    to_forces: ComplexArray


class OpenTree(NamedTuple):
    """Forces of the linkage with all loops open, (n,) each.

    Attributes:
        array: (rows + bearings, n) both of the others.
        work: by rows, on the functions.
        forces: of all bearings; those of the loops are to be filled in.
    """

    array: ComplexArray
    work: list[ComplexArray]
    forces: list[ComplexArray]

    @staticmethod
    def of(array: ComplexArray, rows: int) -> OpenTree:
        """The tree whose array is given, with this number of rows of functions."""
        views = list(array)
        return OpenTree(array, views[:rows], views[rows:])


@dataclass(frozen=True, eq=False, repr=False)
class Statics:
    """Constants of the balance of forces. Forces follow from the conjugate second derivatives of the functions.

    Attributes:
        bodies: inertial constants of the linkage.
        equations: its equations.
        together: (work, forces of joints; rows) of all trees together.
        trees: the same tree by tree; empty where the joints of a tree are not consecutive.
        guided: the links on guides.
    """

    bodies: Bodies
    equations: Equations
    together: ComplexArray
    trees: tuple[Tree, ...]
    guided: tuple[GuidedBody, ...]

    @property
    def plane(self) -> Plane:
        """Constants of the linkage's geometry."""
        return self.bodies.plane

    @property
    def functions(self) -> Functions:
        """Rows of the functions of its joints."""
        return self.equations.functions

    @property
    def blocks(self) -> tuple[BlockRows, ...]:
        """The blocks of its equations."""
        return self.equations.blocks

    @cached_property
    def bearing_count(self) -> int:
        """Number of bearings."""
        return len(self.plane.parents) + len(self.plane.loop_heights)

    @cached_property
    def backwards(self) -> tuple[int, ...]:
        """Places of all blocks, the last one first."""
        return tuple(reversed(range(len(self.blocks))))

    @cached_property
    def piece(self) -> int:
        """Number of states that are worked through at a time: fewer of long linkages, and where idle forces take memory, too."""
        most = max(1, PIECE // (1 + sum(block.redundant for block in self.blocks)))
        return min(most, max(SMALLEST_PIECE, IN_CACHE // max(1, len(self.blocks))))


def build_statics(bodies: Bodies, equations: Equations) -> Statics:
    """Constants of the balance of forces of a linkage with these bodies and equations."""
    functions = equations.functions
    count, joints = functions.count, len(functions.rows)
    together: ComplexArray = np.zeros((count + joints, count), complex)
    trees = []
    for first_row, end in zip(functions.ones, (*functions.ones[1:], count), strict=True):
        carried = [j for j, row in enumerate(functions.rows) if first_row < row < end]
        columns = [functions.places[row] for row in range(first_row, end)]
        rows, of_joints = slice(first_row, end), slice(carried[0], carried[-1] + 1)
        to_work = bodies.reduced[[place - 1 for place in columns[1:]]][:, columns].conj()
        to_forces = bodies.subtree_forces[carried][:, columns].conj()
        trees.append(Tree(of_joints, rows, to_work, to_forces))
        together[first_row + 1 : end, rows] = to_work
        together[count + carried[0] : count + carried[-1] + 1, rows] = to_forces
    return Statics(bodies, equations, together, tuple(trees), guided_bodies(functions, bodies))


# ------------------------------------------------------------------------------------------------------------------------------- balance


def open_tree(statics: Statics, configurations: Configurations, second: ComplexArray, loads: Sequence[AppliedForce]) -> OpenTree:
    """Forces with all loops open.

    Args:
        statics: constants of the balance.
        configurations: the configurations.
        second: (rows, n) conjugate second derivatives of the functions, 1 in the rows of ones.
        loads: forces on links.
    """
    plane, first = statics.plane, statics.functions.count
    joints, n = len(plane.parents), second.shape[1]
    tree = OpenTree.of(np.empty((first + statics.bearing_count, n), complex), first)
    if statics.together.size * n <= SERIAL_COMPLEX:
        np.dot(statics.together, second, tree.array[: first + joints])
    else:
        for part in statics.trees:
            own_rows = second[part.rows]
            _multiply(part.to_work, own_rows, tree.array[part.rows.start + 1 : part.rows.stop])
            _multiply(part.to_forces, own_rows, tree.array[first + part.joints.start : first + part.joints.stop])
    for load in loads:
        if not load.joint:
            continue
        joint, force = load.joint - 1, to_complex(plane, load.force).conj()
        point = plane.point(joint, complex(*(plane.frames[joint] @ load.point)[:2]))
        for place in np.flatnonzero(point[1:]) + 1:
            tree.work[statics.functions.order[place]] -= point[place] * force
        for carrier in plane.carriers(joint):
            tree.forces[carrier] -= force
        if load.moment is not None and (rotor := plane.rotors[joint]):
            row = statics.functions.order[rotor]
            tree.work[row] += 1j * (load.moment @ plane.normal) * np.conj(configurations.functions[row])
    return tree


def tree_without_work(statics: Statics, of_joints: ComplexArray) -> OpenTree:
    """The tree whose joints carry these conjugate forces (nv, n), and on whose functions no force does any work."""
    first = statics.functions.count
    tree = OpenTree.of(np.zeros((first + statics.bearing_count, of_joints.shape[1]), complex), first)
    tree.array[first : first + len(of_joints)] = of_joints
    return tree


def _multiply(rows: ComplexArray, columns: ComplexArray, out: ComplexArray) -> None:
    """`products.product` into an array."""
    step = max(1, (SERIAL_COMPLEX if len(rows) > 1 else SERIAL_COMPLEX_VECTOR) // rows.size)
    for start in range(0, columns.shape[1], step):
        s = slice(start, start + step)
        np.matmul(rows, columns[:, s], out=out[:, s])


def direction_of(statics: Statics, configurations: Configurations, joint: int) -> ComplexArray:
    """The direction of a prismatic joint, (n,) or without axes."""
    functions = statics.functions
    drawn = statics.plane.directions[statics.plane.prismatic.index(joint)]
    rotor = functions.guides[functions.rows[joint]]
    return np.asarray(drawn.sum() if rotor is None else drawn.sum() * configurations.functions[rotor])


def efforts_by_rows(statics: Statics, efforts: Array) -> dict[int, Array]:
    """What efforts (nv, n) of the joints, along or about their axes, do to the coordinates (n,), by rows."""
    result: dict[int, Array] = {}
    for joint, effort in enumerate(efforts):
        for row, part in efforts_of_joint(statics.functions, joint, effort):
            result[row] = np.asarray(result[row] + part if row in result else part)
    return result


def balance(
    statics: Statics,
    configurations: Configurations,
    tree: OpenTree,
    multipliers: Array,
    efforts: dict[int, Array] | None = None,
    places: Sequence[int] | None = None,
) -> Array:
    """Balance the forces of the open tree, without idle forces.

    Args:
        statics: constants of the balance.
        configurations: the configurations.
        tree: its forces, to which those of the loops are added; its work is overwritten.
        multipliers: (relations, n) of the relations, to be filled in.
        efforts: by rows the efforts (n,) of coordinates besides those of the work; overwritten.
        places: of the blocks that balance it, the last one first; all by default.

    Returns:
        The driving torque (n,), of a driver that slides its force.
    """
    functions, plane, work, forces = statics.functions, statics.plane, tree.work, tree.forces
    efforts = {} if efforts is None else efforts
    joints = len(plane.parents)
    for place in statics.backwards if places is None else places:
        block = statics.blocks[place]
        for rider, rotor in block.riding:
            if rider in functions.guides:
                work[rotor] += configurations.ways[rider] * work[rider]
            else:
                efforts[rotor] = efforts.get(rotor, 0.0) - _minus_effort(functions, configurations, work, rider, efforts)
        minus_efforts = [_minus_effort(functions, configurations, work, row, efforts) for row in block.rows]
        if block.has_inverses:
            force = np.multiply(configurations.inverses[block.rows[0]], minus_efforts[0], forces[joints + block.loops[0].loop])
            for row, minus_effort in zip(block.rows[1:], minus_efforts[1:], strict=True):
                force += configurations.inverses[row] * minus_effort
            _subtract_loop(configurations, block.loops[0], force, tree)
            continue
        if block.rows:
            _distribute(statics, block, _multipliers(configurations.slopes[place], -np.stack(minus_efforts, axis=1)), tree, multipliers)
        else:  # all its equations are redundant: its forces are idle ones
            for loop in block.loops:
                forces[joints + loop.loop][:] = 0.0
            multipliers[list(block.relations)] = 0.0
        _subtract_block(statics, configurations, block, tree, multipliers, efforts)
    driver = functions.rows[plane.driver]
    against = _minus_effort(functions, configurations, work, driver, efforts)
    return against if plane.sense[plane.driver] < 0.0 else -against


def _minus_effort(
    functions: Functions, configurations: Configurations, work: Sequence[ComplexArray], row: int, efforts: Mapping[int, Array]
) -> Array:
    """Minus the effort (n,) that a coordinate needs."""
    if row in functions.guides:
        rotor = functions.guides[row]
        against = -(work[row].real if rotor is None else (work[row] * configurations.functions[rotor]).real)
    else:
        against = (configurations.functions[row] * work[row]).imag
    return np.asarray(against - efforts[row] if row in efforts else against)


def _multipliers(slopes: Array, efforts: Array) -> Array:
    """Multipliers (n, equations) that supply efforts (n, coordinates); those of least norm where there are more equations."""
    if slopes.shape[1:] == (1, 1):
        return efforts / slopes[:, 0]
    if slopes.shape[1] == slopes.shape[2]:
        return np.asarray(np.linalg.solve(slopes.transpose(0, 2, 1), efforts[:, :, None])[:, :, 0])
    orthogonal, triangle = np.linalg.qr(slopes)
    return np.asarray((orthogonal @ np.linalg.solve(triangle.transpose(0, 2, 1), efforts[:, :, None]))[:, :, 0])


def _distribute(statics: Statics, block: BlockRows, block_multipliers: Array, tree: OpenTree, multipliers: Array) -> None:
    """Write the multipliers (n, equations) of a block to its loops and relations."""
    joints = len(statics.plane.parents)
    for k, loop in enumerate(block.loops):
        force = tree.forces[joints + loop.loop]
        force.real, force.imag = block_multipliers[:, 2 * k], -block_multipliers[:, 2 * k + 1]
    multipliers[list(block.relations)] = block_multipliers[:, 2 * len(block.loops) :].T


def _subtract_loop(configurations: Configurations, loop: LoopRows, force: ComplexArray, tree: OpenTree) -> None:
    """Subtract the force (n,) of a loop from the work of earlier functions and from the forces of joints."""
    for row, by in loop.earlier_functions:
        tree.work[row] -= by * force
    for rotor, way, by in loop.earlier_guides:
        tree.work[rotor] -= (configurations.ways[way] * by) * force
    for joint, sign in loop.carriers:
        if sign > 0.0:
            tree.forces[joint] -= force
        else:
            tree.forces[joint] += force


def _subtract_block(
    statics: Statics, configurations: Configurations, block: BlockRows, tree: OpenTree, multipliers: Array, efforts: dict[int, Array]
) -> None:
    """Subtract what the forces of a block do on earlier coordinates, and on joints."""
    joints = len(statics.plane.parents)
    for loop in block.loops:
        _subtract_loop(configurations, loop, tree.forces[joints + loop.loop], tree)
    for relation in block.relations:
        for row, by in efforts_of_relation(statics.functions, relation):
            efforts[row] = efforts.get(row, 0.0) - by * multipliers[relation]


# ------------------------------------------------------------------------------------------------------------------------------ idle forces


class IdleForces(NamedTuple):
    """Idle forces of n configurations, one for every redundant equation.

    Attributes:
        bearings: (idle, bearings, n) what each adds to the bearings, conjugate.
        multipliers: (idle, relations, n) what each adds to the multipliers of the relations.
        slides: directions of the prismatic joints that a relation names, by joint.
    """

    bearings: ComplexArray
    multipliers: Array
    slides: Mapping[int, ComplexArray]


def idle_forces(statics: Statics, configurations: Configurations) -> IdleForces | None:
    """The idle forces; None if no equation is redundant."""
    count, n = sum(block.redundant for block in statics.blocks), len(configurations.functions[statics.functions.rows[0]])
    if not count:
        return None
    bearings = np.zeros((count, statics.bearing_count, n), complex)
    multipliers = np.zeros((count, len(statics.plane.offsets), n))
    number = 0
    for place, block in enumerate(statics.blocks):
        if not block.redundant:
            continue
        null = None  # (n, equations, redundant) multipliers that balance within the block
        if not block.rows:
            null = np.tile(np.eye(block.redundant), (n, 1, 1))
        elif not block.has_inverses:
            null = np.linalg.qr(configurations.slopes[place], mode="complete")[0][:, :, len(block.rows) :]
        for k in range(block.redundant):
            work = list(np.zeros((statics.functions.count, n), complex))
            tree = OpenTree(bearings[number], work, list(bearings[number]))
            efforts: dict[int, Array] = {}
            if null is None:  # along the lever
                np.multiply(configurations.inverses[block.rows[0]], I, tree.forces[len(statics.plane.parents) + block.loops[0].loop])
            else:
                _distribute(statics, block, null[:, :, k], tree, multipliers[number])
            _subtract_block(statics, configurations, block, tree, multipliers[number], efforts)
            balance(statics, configurations, tree, multipliers[number], efforts, block.balancing)
            number += 1
    related = {joint for row in statics.plane.relation_rows for joint in row}
    slides = {joint: direction_of(statics, configurations, joint) for joint in statics.plane.prismatic if joint in related}
    return IdleForces(bearings, multipliers, slides)


def add_idle_forces(idle: IdleForces, forces: ComplexArray, multipliers: Array, compliance: Array | None) -> None:
    """Add idle forces to the conjugate forces of all bearings (bearings, n) and to the multipliers of the relations (relations, n).
    ``compliance`` as in `AppliedConditions`."""
    parts = np.concatenate([idle.bearings, forces[None]])
    for joint, direction in idle.slides.items():  # the force of a gear pair along its slide does not count
        parts[:, joint] = 1j * direction.conj() * (direction * parts[:, joint]).imag
    for share, of_bearings, of_relations in zip(shares_of_idle_forces(parts, compliance), idle.bearings, idle.multipliers, strict=True):
        forces += share * of_bearings
        multipliers += share * of_relations
