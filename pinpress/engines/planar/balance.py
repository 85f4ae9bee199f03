"""The balance of forces of a planar linkage at n configurations: block by block backwards, in absolute angles.

The power of a force f at a velocity v is Re(conj(f) v): the conjugates of forces are what appears everywhere, and here all forces are
conjugates until they are written to the result. The *work* of a function (see `functions`) is that of all inertia forces less weights and
loads on it: the force f at a point that moves with c times the function counts conj(f) c. The coordinates are the absolute angles of the
links that turn and the ways along guides. A rotor u with the work W asks for the effort -Im(u W), a way along a guide with the rotor u for
Re(u W). A block of loops and couplings supplies the efforts of the coordinates that it determines. With the inverses e1 and e2 of a dyad
(see `dyads`) the force p of its loop is

    conj(p) = -(e1 effort1 + e2 effort2)

It takes c conj(p) from the work of every function that has the coefficient c in the loop. A coupling acts between each of its joints and
what carries it. What is left at the driver is the driving torque.

Redundant equations of a block leave *idle* forces open, which the blocks before it balance: a lever supplies the effort of its rotor
across itself, and along it any force is left open. `engines.forces` says how much of it is added.

In a few linkages a block is closed on a link that moves itself and is determined later, or the driver stands on such a link. Absolute
angles are then found only together: all equations are one block, and the driver *rides* on the link that carries it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...common.products import SERIAL_COMPLEX
from ...common.quantities import Array, ComplexArray
from ..forces import AppliedForce
from .bodies import Bodies
from .dyads import I
from .functions import Functions
from .guide_moments import GuidedBody, guided_bodies
from .model import Block, Plane, to_complex
from .sharing import shares_of_idle_forces

PIECE, SMALLEST_PIECE = 7200, 900  # most states that are worked through at a time, and those below which calls would take most of it
IN_CACHE = 40_000  # states times blocks whose arrays stay in the cache


class LoopRows(NamedTuple):
    """What the force of a loop does, by rows of functions.

    Attributes:
        loop: its index.
        coefficients: of all functions that move its gap.
        relieved: coefficients of the functions that are known before it is closed.
        turned: of the ways that it determines along guides whose rotors are known before: rotor, way and coefficient of the way.
        carriers: the joints that carry one of its ends, with `Plane.incidence`.
    """

    loop: int
    coefficients: Mapping[int, ComplexArray]
    relieved: tuple[tuple[int, ComplexArray], ...]
    turned: tuple[tuple[int, int, ComplexArray], ...]
    carriers: tuple[tuple[int, float], ...]


class BlockRows(NamedTuple):
    """Equations that are balanced together.

    Attributes:
        joints: the joints whose coordinates they determine.
        rows: rows of these joints' functions.
        riding: pairs of a function and of the rotor that turns it, those furthest outside first: the ways of the block, and a driver that
            rides on it.
        loops: its loops.
        couplings: its couplings.
        closed: whether it is a dyad or a lever, which has inverses.
        redundant: number of redundant equations.
        balancing: places of the blocks before it that balance its idle forces, the last one first.
    """

    joints: tuple[int, ...]
    rows: tuple[int, ...]
    riding: tuple[tuple[int, int], ...]
    loops: tuple[LoopRows, ...]
    couplings: tuple[int, ...]
    closed: bool
    redundant: int
    balancing: tuple[int, ...]


class Tree(NamedTuple):
    """The links that hang on one joint of the frame.

    Attributes:
        joints: its joints, consecutive.
        rows: rows of functions, the row of ones first.
        to_work: second derivatives of the functions to the work on them.
        to_forces: the same to the forces of all links that each joint carries.
        single: the four numbers of these matrices where there is one joint.
    """

    joints: slice
    rows: slice
    to_work: ComplexArray
    to_forces: ComplexArray
    single: tuple[ComplexArray, ...]


class Pose(NamedTuple):
    """n closed configurations, (n,) arrays by rows of functions.

    Attributes:
        functions: the functions; of ways along guides that do not turn they may be missing.
        ways: travels along guides.
        inverses: of the coordinates that a dyad or lever determines, see `dyads`.
        slopes: by place of all other blocks with loops the matrix (n, equations, coordinates) of their slopes.
    """

    functions: Sequence[ComplexArray]
    ways: Sequence[Array]
    inverses: Sequence[ComplexArray]
    slopes: Mapping[int, Array]


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
        functions: rows of its functions.
        blocks: its equations in the order in which they are closed.
        together: (work, forces of joints; rows) of all trees together.
        trees: the same tree by tree; empty where the joints of a tree are not consecutive.
        guided: the links on guides.
    """

    bodies: Bodies
    functions: Functions
    blocks: tuple[BlockRows, ...]
    together: ComplexArray
    trees: tuple[Tree, ...]
    guided: tuple[GuidedBody, ...]

    @property
    def plane(self) -> Plane:
        """Constants of the linkage's geometry."""
        return self.functions.plane

    @cached_property
    def bearing_count(self) -> int:
        """Number of bearings."""
        return len(self.plane.parents) + len(self.plane.loop_heights)

    @cached_property
    def turned(self) -> tuple[int, ...]:
        """The joints that transmit moments about the normal without friction: the driver, if it turns, geared shafts, and all guides."""
        plane = self.plane
        return tuple(sorted({*plane.prismatic, *self.bodies.geared, *([plane.driver] if plane.sense[plane.driver] else [])}))

    @cached_property
    def backwards(self) -> tuple[int, ...]:
        """Places of all blocks, the last one first."""
        return tuple(reversed(range(len(self.blocks))))

    @cached_property
    def piece(self) -> int:
        """Number of states that are worked through at a time: fewer of long linkages, and where idle forces take memory, too."""
        most = max(1, PIECE // (1 + sum(block.redundant for block in self.blocks)))
        return min(most, max(SMALLEST_PIECE, IN_CACHE // max(1, len(self.blocks))))

    @cached_property
    def coupled_slides(self) -> tuple[int, ...]:
        """Prismatic joints that are coupled."""
        return tuple(j for j in self.plane.prismatic if any(j in row for row in self.plane.coupling_rows))


def build_statics(bodies: Bodies) -> Statics:
    """Constants of the balance of forces of a linkage with these bodies."""
    functions = Functions(bodies.plane)
    count, joints = functions.count, len(functions.rows)
    together: ComplexArray = np.zeros((count + joints, count), complex)
    trees = []
    for one, end in zip(functions.ones, (*functions.ones[1:], count), strict=True):
        carried = [j for j, row in enumerate(functions.rows) if one < row < end]
        columns = [functions.places[row] for row in range(one, end)]
        rows, of_joints = slice(one, end), slice(carried[0], carried[-1] + 1)
        to_work = bodies.reduced[[place - 1 for place in columns[1:]]][:, columns].conj()
        to_forces = bodies.subtree_forces[carried][:, columns].conj()
        single = tuple(np.array(entry) for entry in (*to_work[0], *to_forces[0])) if len(carried) == 1 else ()
        trees.append(Tree(of_joints, rows, to_work, to_forces, single))
        together[one + 1 : end, rows] = to_work
        together[count + carried[0] : count + carried[-1] + 1, rows] = to_forces
    return Statics(bodies, functions, block_rows(functions), together, tuple(trees), guided_bodies(functions, bodies))


# -------------------------------------------------------------------------------------------------------- blocks by rows of functions


def block_rows(functions: Functions) -> tuple[BlockRows, ...]:
    """The equations of a linkage in the order in which they are closed."""
    plane = functions.plane
    coefficients = [_coefficients(functions, loop) for loop in range(len(plane.loop_heights))]
    blocks, follow = plane.blocks, _blocks_follow_each_other(functions, coefficients)
    if not follow:
        joints = tuple(j for j in range(len(plane.parents)) if j != plane.driver)
        loops, couplings = tuple(range(len(plane.loop_heights))), tuple(range(len(plane.offsets)))
        blocks = (Block(loops, couplings, joints, ((),) * len(loops), ((),) * len(loops)),)
    found: list[BlockRows] = []
    for block in blocks:
        rows = tuple(functions.rows[joint] for joint in block.joints)
        loops_of_block = tuple(_loop_rows(functions, loop, coefficients[loop], rows) for loop in block.loops)
        riding = _riding(functions, rows, rides=not follow)
        closed = follow and block.kind in ("dyad", "lever")
        balancing = _balancing(plane, loops_of_block, block.couplings, rows, found) if block.redundant else ()
        found.append(BlockRows(block.joints, rows, riding, loops_of_block, block.couplings, closed, block.redundant, balancing))
    return tuple(found)


def _coefficients(functions: Functions, loop: int) -> dict[int, ComplexArray]:
    """The coefficients of a loop's gap that are not zero, by rows of functions."""
    gap = functions.plane.gap_rows[loop]
    return {functions.order[place]: np.array(gap[place]) for place in np.flatnonzero(gap).tolist() if place}


def _blocks_follow_each_other(functions: Functions, coefficients: Sequence[Mapping[int, ComplexArray]]) -> bool:
    """Whether every block needs only absolute angles that the driver and the blocks before it determine."""
    plane, rows = functions.plane, functions.rows

    def moving(joints: Iterable[int]) -> set[int]:
        """Rows of the rotors that turn the frames of these joints."""
        return {functions.order[carrier] for j in joints if (carrier := plane.rotor(plane.parents[j]))}

    known = {rows[plane.driver]}
    if not moving([plane.driver]) <= known:
        return False
    for block in plane.blocks:
        known |= {rows[joint] for joint in block.joints}
        coupled = [joint for coupling in block.couplings for joint in plane.coupling_rows[coupling]]
        needed = set().union(moving([*block.joints, *coupled]), *(coefficients[loop] for loop in block.loops))
        if not needed <= known:
            return False
    return True


def _loop_rows(functions: Functions, loop: int, coefficients: Mapping[int, ComplexArray], determined: Sequence[int]) -> LoopRows:
    plane = functions.plane
    carriers = tuple((joint, signs[loop]) for joint, signs in enumerate(plane.loops_of_joint) if loop in signs)
    turned = tuple(
        (rotor, row, by)
        for row, by in coefficients.items()
        if row in determined and (rotor := functions.guides.get(row)) is not None and rotor not in determined
    )
    relieved = tuple((row, by) for row, by in coefficients.items() if row not in determined)
    return LoopRows(loop, coefficients, relieved, turned, carriers)


def _riding(functions: Functions, determined: Sequence[int], rides: bool) -> tuple[tuple[int, int], ...]:
    """`BlockRows.riding` of a block that determines these rows; ``rides``: whether the driver rides on one of them."""
    plane = functions.plane
    driver = functions.rows[plane.driver]
    carrier = plane.rotor(plane.parents[plane.driver])
    pairs = []
    if rides and plane.sense[plane.driver] and carrier:
        pairs += [(way, driver) for way, rotor in functions.guides.items() if rotor == driver]
        pairs.append((driver, functions.order[carrier]))
    for way, rotor in functions.guides.items():
        if rotor is not None and (way in determined or (rides and way == driver)) and (way, rotor) not in pairs:
            pairs.append((way, rotor))
    return tuple(pairs)


def _balancing(
    plane: Plane, loops: Sequence[LoopRows], couplings: Sequence[int], rows: Sequence[int], before: Sequence[BlockRows]
) -> tuple[int, ...]:
    """The places of the blocks before one that move its equations, the last one first."""
    if couplings:
        return tuple(reversed(range(len(before))))
    moving, found = _moved_by(loops), []
    for place in reversed(range(len(before))):
        block = before[place]
        if block.couplings or not moving.isdisjoint(block.rows):
            found.append(place)
            moving |= _moved_by(block.loops)
    return tuple(found)


def _moved_by(loops: Iterable[LoopRows]) -> set[int]:
    """Rows of the functions that are known before loops are closed and move them."""
    return {row for loop in loops for row, _ in loop.relieved} | {rotor for loop in loops for rotor, *_ in loop.turned}


# ------------------------------------------------------------------------------------------------------------------------- configurations


def pose_at(statics: Statics, basis: ComplexArray, position: Array) -> Pose:
    """The configurations with this ``basis`` (nb, n) and these joint coordinates (nv, n)."""
    functions, plane = statics.functions, statics.plane
    ways: list[Array] = [position[0]] * functions.count
    for joint in plane.prismatic:
        ways[functions.rows[joint]] = position[joint]
    rows: list[ComplexArray] = [basis[place] for place in functions.places]
    inverses = list(rows)
    for block in statics.blocks:
        if block.closed:
            of_rows = [_slope(functions, block, block.loops[0], row, rows) for row in block.rows]
            for row, inverse in zip(block.rows, _inverses(*of_rows), strict=True):
                inverses[row] = inverse
    return pose_of(statics, rows, ways, inverses)


def pose_of(statics: Statics, functions: Sequence[ComplexArray], ways: Sequence[Array], inverses: Sequence[ComplexArray]) -> Pose:
    """The configurations with these (n,) functions, ways, and inverses of dyads and levers, by rows."""
    slopes = {place: _slopes(statics, block, functions) for place, block in enumerate(statics.blocks) if not block.closed and block.rows}
    return Pose(functions, ways, inverses, slopes)


def _inverses(a: ComplexArray, b: ComplexArray | None = None) -> tuple[ComplexArray, ...]:
    """The inverses of a dyad with the slopes a and b, or of a lever with one."""
    first = a.conj()
    if b is None:
        return (first * (-1.0 / (a.real * a.real + a.imag * a.imag)),)
    by_determinant = 1.0 / (first * b).imag
    second = b.conj()
    second *= by_determinant * -1j
    first *= by_determinant * 1j
    return second, first


def _slope(functions: Functions, block: BlockRows, loop: LoopRows, row: int, values: Sequence[ComplexArray]) -> ComplexArray:
    """The derivative (n,) of a loop's gap by a coordinate of the block; ``values``: functions by rows."""
    if row in functions.guides:
        by, rotor = loop.coefficients.get(row, np.array(0j)), functions.guides[row]
        return by * values[rotor] if rotor is not None else np.full(values[row].shape, by)
    turned = {row}
    for rider, rotor in reversed(block.riding):
        if rotor in turned:
            turned.add(rider)
    slope = np.zeros(values[row].shape, complex)
    for moved in sorted(turned & loop.coefficients.keys()):
        slope += loop.coefficients[moved] * values[moved]
    slope *= I
    return slope


def _slopes(statics: Statics, block: BlockRows, values: Sequence[ComplexArray]) -> Array:
    """`Pose.slopes` of a block: the real and imaginary part of every loop, then the couplings."""
    functions, loops = statics.functions, 2 * len(block.loops)
    matrix = np.zeros((len(values[0]), loops + len(block.couplings), len(block.rows)))
    for k, loop in enumerate(block.loops):
        for place, row in enumerate(block.rows):
            slope = _slope(functions, block, loop, row, values)
            matrix[:, 2 * k, place], matrix[:, 2 * k + 1, place] = slope.real, slope.imag
    riding = dict(block.riding)
    for k, coupling in enumerate(block.couplings, loops):
        for row, by in _efforts_of_coupling(statics, coupling):
            row = row if row in block.rows else riding.get(row, row)
            if row in block.rows:
                matrix[:, k, block.rows.index(row)] += by
    return matrix


def _efforts_of_coupling(statics: Statics, coupling: int) -> Iterator[tuple[int, float]]:
    """Rows of coordinates, and the effort that a unit of a coupling's multiplier supplies to each; a row may come twice."""
    for joint, by in statics.plane.coupling_rows[coupling].items():
        yield from _efforts_of_joint(statics.functions, joint, by)


def _efforts_of_joint(functions: Functions, joint: int, effort: float) -> Iterator[tuple[int, float]]:
    """Rows of coordinates, and what an effort of a joint, along or about its axis, does to each."""
    row, sense = functions.rows[joint], float(functions.plane.sense[joint])
    yield row, effort * (sense or 1.0)
    outer = functions.outer[joint]
    if outer is not None:
        yield outer, -effort * sense


# ------------------------------------------------------------------------------------------------------------------------------- balance


def open_tree(statics: Statics, second: ComplexArray, loads: Sequence[AppliedForce]) -> OpenTree:
    """Forces with all loops open.

    Args:
        statics: constants of the balance.
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
            _add_tree(part, second[part.rows], tree, first)
    for load in loads:
        if load.joint:
            _take_load(statics, load, tree)
    return tree


def without_work(statics: Statics, of_joints: ComplexArray) -> OpenTree:
    """The tree whose joints carry these conjugate forces (nv, n), and on whose functions no force does any work."""
    first = statics.functions.count
    tree = OpenTree.of(np.zeros((first + statics.bearing_count, of_joints.shape[1]), complex), first)
    tree.array[first : first + len(of_joints)] = of_joints
    return tree


def _add_tree(part: Tree, second: ComplexArray, tree: OpenTree, first: int) -> None:
    """Fill in what hangs on one joint of the frame; ``second`` has only its rows."""
    if part.single:
        constant1, by1, constant2, by2 = part.single
        for row, by, constant in ((tree.work[part.rows.start + 1], by1, constant1), (tree.forces[part.joints.start], by2, constant2)):
            np.add(np.multiply(second[1], by, row), constant, row)
        return
    _multiply(part.to_work, second, tree.array[part.rows.start + 1 : part.rows.stop])
    _multiply(part.to_forces, second, tree.array[first + part.joints.start : first + part.joints.stop])


def _multiply(rows: ComplexArray, columns: ComplexArray, out: ComplexArray) -> None:
    """`products.product` of several rows into an array."""
    step = max(1, SERIAL_COMPLEX // rows.size)
    for start in range(0, columns.shape[1], step):
        s = slice(start, start + step)
        np.matmul(rows, columns[:, s], out=out[:, s])


def _take_load(statics: Statics, load: AppliedForce, tree: OpenTree) -> None:
    """Take a load from the work of functions and from the forces of the joints that carry its link."""
    plane, order = statics.plane, statics.functions.order
    joint, force = load.joint - 1, to_complex(plane, load.force).conj()
    point = plane.point(joint, complex(*(plane.frames[joint] @ load.point)[:2]))
    for place in np.flatnonzero(point[1:]) + 1:
        tree.work[order[place]] -= point[place] * force
    for carrier in plane.carriers(joint):
        tree.forces[carrier] -= force


def direction_of(statics: Statics, pose: Pose, joint: int) -> ComplexArray:
    """The direction of a prismatic joint, (n,) or without axes."""
    functions = statics.functions
    drawn = statics.plane.directions[statics.plane.prismatic.index(joint)]
    rotor = functions.guides[functions.rows[joint]]
    return np.asarray(drawn.sum() if rotor is None else drawn.sum() * pose.functions[rotor])


def efforts_by_rows(statics: Statics, efforts: Array) -> dict[int, Array]:
    """What efforts (nv, n) of the joints, along or about their axes, do to the coordinates (n,), by rows."""
    result: dict[int, Array] = {}
    for joint, effort in enumerate(efforts):
        for row, part in _efforts_of_joint(statics.functions, joint, effort):
            result[row] = result[row] + part if row in result else part
    return result


def balance(
    statics: Statics,
    pose: Pose,
    tree: OpenTree,
    multipliers: Array,
    efforts: dict[int, Array] | None = None,
    places: Sequence[int] | None = None,
) -> Array:
    """Balance the forces of the open tree, without idle forces.

    Args:
        statics: constants of the balance.
        pose: the configurations.
        tree: its forces, to which those of the loops are added; its work is overwritten.
        multipliers: (couplings, n) of the couplings, to be filled in.
        efforts: by rows the efforts (n,) of coordinates besides those of the work; overwritten.
        places: of the blocks that balance it, the last one first; all by default.

    Returns:
        The driving torque (n,), of a driver that slides its force.
    """
    functions, plane, work, forces = statics.functions, statics.plane, tree.work, tree.forces
    given = {} if efforts is None else efforts
    joints = len(plane.parents)
    for place in statics.backwards if places is None else places:
        block = statics.blocks[place]
        for rider, rotor in block.riding:
            if rider in functions.guides:
                work[rotor] += pose.ways[rider] * work[rider]
            else:
                given[rotor] = given.get(rotor, 0.0) - _minus_effort(functions, pose, work, rider, given)
        asked = [_minus_effort(functions, pose, work, row, given) for row in block.rows]
        if block.closed:
            force = np.multiply(pose.inverses[block.rows[0]], asked[0], forces[joints + block.loops[0].loop])
            for row, minus_effort in zip(block.rows[1:], asked[1:], strict=True):
                force += pose.inverses[row] * minus_effort
            _relieve(pose, block.loops[0], force, tree)
            continue
        if block.rows:
            _distribute(statics, block, _multipliers(pose.slopes[place], -np.stack(asked, axis=1)), tree, multipliers)
        else:  # all its equations are redundant: its forces are idle ones
            for loop in block.loops:
                forces[joints + loop.loop][:] = 0.0
            multipliers[list(block.couplings)] = 0.0
        _pass_on(statics, pose, block, tree, multipliers, given)
    driver = functions.rows[plane.driver]
    against = _minus_effort(functions, pose, work, driver, given)
    return against if plane.sense[plane.driver] < 0.0 else -against


def _minus_effort(functions: Functions, pose: Pose, work: Sequence[ComplexArray], row: int, efforts: Mapping[int, Array]) -> Array:
    """Minus the effort (n,) that a coordinate asks for."""
    if row in functions.guides:
        rotor = functions.guides[row]
        against = -(work[row].real if rotor is None else (work[row] * pose.functions[rotor]).real)
    else:
        against = (pose.functions[row] * work[row]).imag
    return np.asarray(against - efforts[row] if row in efforts else against)


def _multipliers(slopes: Array, efforts: Array) -> Array:
    """Multipliers (n, equations) that supply efforts (n, coordinates); those of least norm where there are more equations."""
    if slopes.shape[1:] == (1, 1):
        return efforts / slopes[:, 0]
    if slopes.shape[1] == slopes.shape[2]:
        return np.asarray(np.linalg.solve(slopes.transpose(0, 2, 1), efforts[:, :, None])[:, :, 0])
    orthogonal, triangle = np.linalg.qr(slopes)
    return np.asarray((orthogonal @ np.linalg.solve(triangle.transpose(0, 2, 1), efforts[:, :, None]))[:, :, 0])


def _distribute(statics: Statics, block: BlockRows, found: Array, tree: OpenTree, multipliers: Array) -> None:
    """Write the multipliers (n, equations) of a block to its loops and couplings."""
    joints = len(statics.plane.parents)
    for k, loop in enumerate(block.loops):
        force = tree.forces[joints + loop.loop]
        force.real, force.imag = found[:, 2 * k], -found[:, 2 * k + 1]
    multipliers[list(block.couplings)] = found[:, 2 * len(block.loops) :].T


def _relieve(pose: Pose, loop: LoopRows, force: ComplexArray, tree: OpenTree) -> None:
    """Subtract the force (n,) of a loop where it relieves functions that are known before it is closed, and joints."""
    for row, by in loop.relieved:
        tree.work[row] -= by * force
    for rotor, way, by in loop.turned:
        tree.work[rotor] -= (pose.ways[way] * by) * force
    for joint, sign in loop.carriers:
        if sign > 0.0:
            tree.forces[joint] -= force
        else:
            tree.forces[joint] += force


def _pass_on(statics: Statics, pose: Pose, block: BlockRows, tree: OpenTree, multipliers: Array, efforts: dict[int, Array]) -> None:
    """Subtract what the forces of a block do on coordinates that are known before it, and on joints."""
    joints = len(statics.plane.parents)
    for loop in block.loops:
        _relieve(pose, loop, tree.forces[joints + loop.loop], tree)
    for coupling in block.couplings:
        for row, by in _efforts_of_coupling(statics, coupling):
            efforts[row] = efforts.get(row, 0.0) - by * multipliers[coupling]


# ------------------------------------------------------------------------------------------------------------------------------ idle forces


class IdleForces(NamedTuple):
    """Idle forces of n configurations, one for every redundant equation.

    Attributes:
        bearings: (idle, bearings, n) what each adds to the bearings, conjugate.
        multipliers: (idle, couplings, n) what each adds to the multipliers of the couplings.
        slides: directions of the coupled prismatic joints, by joint.
    """

    bearings: ComplexArray
    multipliers: Array
    slides: Mapping[int, ComplexArray]


def idle_forces(statics: Statics, pose: Pose) -> IdleForces | None:
    """The idle forces; None where no equation is redundant."""
    count, n = sum(block.redundant for block in statics.blocks), len(pose.functions[statics.functions.rows[0]])
    if not count:
        return None
    bearings = np.zeros((count, statics.bearing_count, n), complex)
    multipliers = np.zeros((count, len(statics.plane.offsets), n))
    number = 0
    for place, block in enumerate(statics.blocks):
        if not block.redundant:
            continue
        null = None if block.closed else _null_space(statics, pose, place)
        for k in range(block.redundant):
            work = list(np.zeros((statics.functions.count, n), complex))
            tree = OpenTree(bearings[number], work, list(bearings[number]))
            efforts: dict[int, Array] = {}
            if null is None:  # along the lever
                np.multiply(pose.inverses[block.rows[0]], I, tree.forces[len(statics.plane.parents) + block.loops[0].loop])
            else:
                _distribute(statics, block, null[:, :, k], tree, multipliers[number])
            _pass_on(statics, pose, block, tree, multipliers[number], efforts)
            balance(statics, pose, tree, multipliers[number], efforts, block.balancing)
            number += 1
    slides = {joint: direction_of(statics, pose, joint) for joint in statics.coupled_slides}
    return IdleForces(bearings, multipliers, slides)


def _null_space(statics: Statics, pose: Pose, place: int) -> Array:
    """The multipliers (n, equations, redundant) that balance within a block."""
    block = statics.blocks[place]
    if not block.rows:
        return np.tile(np.eye(block.redundant), (len(pose.functions[statics.functions.rows[0]]), 1, 1))
    return np.linalg.qr(pose.slopes[place], mode="complete")[0][:, :, len(block.rows) :]


def add_idle_forces(idle: IdleForces, forces: ComplexArray, multipliers: Array, compliance: Array | None) -> None:
    """Add idle forces to the conjugate forces of all bearings (bearings, n) and to the multipliers of the couplings (couplings, n).
    ``compliance`` as in `AppliedConditions`."""
    parts = np.concatenate([idle.bearings, forces[None]])
    for joint, direction in idle.slides.items():  # the force of a gear pair along its slide does not count
        parts[:, joint] = 1j * direction.conj() * (direction * parts[:, joint]).imag
    for share, of_bearings, of_couplings in zip(shares_of_idle_forces(parts, compliance), idle.bearings, idle.multipliers, strict=True):
        forces += share * of_bearings
        multipliers += share * of_couplings
