"""The equations of a planar linkage in absolute coordinates: the angles of the links that turn, and the ways along guides.

A loop's gap is a constant plus the sum of c f over the functions f of joints (see `functions`). Its derivative by the absolute angle of a
link with the rotor u is i times the sum of c f over u and the ways that u turns; by a way along a guide with the rotor u it is c u. Blocks
of equations are solved in the order in which they depend on each other. The rates x and y of a dyad with the derivatives a and b close what
opens at the rate o, a x + b y + o = 0 with complex a, b, o and real x, y:

    x = Re(o e1),  y = Re(o e2)    with the inverses    e1 = -i conj(b) / D,  e2 = i conj(a) / D,   D = Im(conj(a) b)

A lever, whose one rate x closes what opens across it, has the inverse e1 = -conj(a) / |a|^2. All other blocks are solved as matrices.

In a few linkages a block is closed on a link that moves itself and is determined later, or the driver stands on such a link. Absolute
angles are then found only together: all equations are one block, and the driver *rides* on the link that carries it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...common.quantities import Array, ComplexArray
from .dyads import I
from .functions import Functions
from .model import Block, Plane

Coefficients = Sequence[Mapping[int, ComplexArray]]
"""By loop and row of a function what it is multiplied by in the gap."""
Terms = tuple[tuple[int | None, ComplexArray], ...]
"""Rows of functions, None for 1, and what they are multiplied by in a slope."""


class LoopRows(NamedTuple):
    """What the force of a loop does, by rows of functions.

    Attributes:
        loop: its index.
        relieved: coefficients of the functions that are known before it is closed.
        turned: of the ways that it determines along guides whose rotors are known before: rotor, way and coefficient of the way.
        moved: the coordinates that are known before it is closed, and what its gap's slope by each is made of, see `slope`.
        determined: the same of the coordinates of its block.
        carriers: the joints that carry one of its ends, with `Plane.incidence`.
    """

    loop: int
    relieved: tuple[tuple[int, ComplexArray], ...]
    turned: tuple[tuple[int, int, ComplexArray], ...]
    moved: tuple[tuple[int, Terms], ...]
    determined: tuple[Terms, ...]
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


@dataclass(frozen=True, eq=False, repr=False)
class Equations:
    """The equations of a linkage in the order in which they are closed.

    Attributes:
        functions: rows of its functions.
        blocks: its blocks.
    """

    functions: Functions
    blocks: tuple[BlockRows, ...]

    @staticmethod
    def of(plane: Plane, coefficients: Coefficients | None = None) -> Equations:
        """The equations of a linkage, or those that it has with other ``coefficients``."""
        functions = Functions(plane)
        given = [nonzero(functions, gap) for gap in plane.gap_rows] if coefficients is None else coefficients
        return Equations(functions, _block_rows(functions, given))

    def with_coefficients(self, coefficients: Coefficients) -> Equations:
        """The same blocks with other coefficients of the same functions."""
        blocks = []
        for block in self.blocks:
            loops = (_loop_rows(self.functions, each.loop, coefficients[each.loop], block.rows, block.riding) for each in block.loops)
            blocks.append(block._replace(loops=tuple(loops)))
        return Equations(self.functions, tuple(blocks))


class Pose(NamedTuple):
    """n closed configurations, (n,) arrays by rows of functions.

    Attributes:
        functions: the functions.
        ways: travels along guides.
        inverses: of the coordinates that a dyad or lever determines.
        slopes: by place of all other blocks with loops the matrix (n, equations, coordinates) of their slopes.
    """

    functions: Sequence[ComplexArray]
    ways: Sequence[Array]
    inverses: Sequence[ComplexArray]
    slopes: Mapping[int, Array]


# -------------------------------------------------------------------------------------------------------- blocks by rows of functions


def _block_rows(functions: Functions, coefficients: Coefficients) -> tuple[BlockRows, ...]:
    """`Equations.blocks`."""
    plane = functions.plane
    blocks, follow = plane.blocks, _blocks_follow_each_other(functions, coefficients)
    if not follow:
        joints = tuple(j for j in range(len(plane.parents)) if j != plane.driver)
        loops, couplings = tuple(range(len(plane.loop_heights))), tuple(range(len(plane.offsets)))
        blocks = (Block(loops, couplings, joints),)
    found: list[BlockRows] = []
    for block in blocks:
        rows = tuple(functions.rows[joint] for joint in block.joints)
        riding = _riding(functions, rows, rides=not follow)
        loops_of_block = tuple(_loop_rows(functions, loop, coefficients[loop], rows, riding) for loop in block.loops)
        closed = follow and block.kind in ("dyad", "lever")
        balancing = _balancing(plane, loops_of_block, block.couplings, rows, found) if block.redundant else ()
        found.append(BlockRows(block.joints, rows, riding, loops_of_block, block.couplings, closed, block.redundant, balancing))
    return tuple(found)


def nonzero(functions: Functions, gap: ComplexArray) -> dict[int, ComplexArray]:
    """The coefficients of a gap (nb,) over the basis that are not zero, by rows of functions."""
    return {functions.order[place]: np.array(gap[place]) for place in np.flatnonzero(gap).tolist() if place}


def _blocks_follow_each_other(functions: Functions, coefficients: Coefficients) -> bool:
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


def _loop_rows(
    functions: Functions, loop: int, coefficients: Mapping[int, ComplexArray], determined: Sequence[int], riding: Sequence[tuple[int, int]]
) -> LoopRows:
    """What the loop does in a block that determines these rows, with what rides on them."""
    carriers = tuple((joint, signs[loop]) for joint, signs in enumerate(functions.plane.loops_of_joint) if loop in signs)
    turned = tuple(
        (rotor, row, by)
        for row, by in coefficients.items()
        if row in determined and (rotor := functions.guides.get(row)) is not None and rotor not in determined
    )
    relieved = tuple((row, by) for row, by in coefficients.items() if row not in determined)
    known = dict.fromkeys((*(row for row, _ in relieved), *(rotor for rotor, *_ in turned)))
    moved = tuple((row, _terms(functions, coefficients, row, riding)) for row in known)
    return LoopRows(loop, relieved, turned, moved, tuple(_terms(functions, coefficients, row, riding) for row in determined), carriers)


def _terms(functions: Functions, coefficients: Mapping[int, ComplexArray], row: int, riding: Sequence[tuple[int, int]]) -> Terms:
    """What the derivative of a gap by a coordinate is made of."""
    if row in functions.guides:
        return ((functions.guides[row], coefficients[row]),) if row in coefficients else ()
    return tuple((each, coefficients[each] * I) for each in _turned_by(functions, row, riding) if each in coefficients)


def _turned_by(functions: Functions, row: int, riding: Sequence[tuple[int, int]]) -> list[int]:
    """The functions that turn with a rotor: itself, the ways that it guides, and a driver that rides on it."""
    turned = [row, *(way for way, rotor in functions.guides.items() if rotor == row)]
    for rider, rotor in riding:
        if rotor == row and rider not in functions.guides:
            turned += _turned_by(functions, rider, riding)
    return turned


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
    moving, found = _rows_before(loops), []
    for place in reversed(range(len(before))):
        block = before[place]
        if block.couplings or not moving.isdisjoint(block.rows):
            found.append(place)
            moving |= _rows_before(block.loops)
    return tuple(found)


def _rows_before(loops: Iterable[LoopRows]) -> set[int]:
    """Rows of the functions that are known before loops are closed and move them."""
    return {row for loop in loops for row, _ in loop.relieved} | {rotor for loop in loops for rotor, *_ in loop.turned}


# ------------------------------------------------------------------------------------------------------------------------- configurations


def pose_at(equations: Equations, basis: ComplexArray, position: Array) -> Pose:
    """The configurations with this ``basis`` (nb, n) and these joint coordinates (nv, n)."""
    functions = equations.functions
    ways: list[Array] = [position[0]] * functions.count
    for joint in functions.plane.prismatic:
        ways[functions.rows[joint]] = position[joint]
    rows: list[ComplexArray] = [basis[place] for place in functions.places]
    inverses = list(rows)
    for block in equations.blocks:
        if block.closed:
            for row, inverse in zip(block.rows, _inverses(*slopes_of_dyad(block, rows)), strict=True):
                inverses[row] = inverse
    blocks = enumerate(equations.blocks)
    slopes = {place: matrix_of(equations, block, rows) for place, block in blocks if not block.closed and block.rows}
    return Pose(rows, ways, inverses, slopes)


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


def slopes_of_dyad(block: BlockRows, values: Sequence[ComplexArray]) -> list[ComplexArray]:
    """The derivatives (n,) of the gap of a dyad or lever by its coordinates; ``values``: functions by rows."""
    return [slope(terms, values) for terms in block.loops[0].determined]


def slope(terms: Terms, values: Sequence[ComplexArray]) -> ComplexArray:
    """The derivative (n,) of a loop's gap by a coordinate; ``values``: functions by rows."""
    if not terms:
        return np.zeros(values[0].shape, complex)
    (row, by), *others = terms
    total = np.full(values[0].shape, by) if row is None else values[row] * by
    for other, by in others:
        if other is not None:
            total += values[other] * by
    return total


def matrix_of(equations: Equations, block: BlockRows, values: Sequence[ComplexArray]) -> Array:
    """The slopes (n, equations, coordinates) of a block: the real and imaginary part of every loop, then the couplings."""
    functions, loops = equations.functions, 2 * len(block.loops)
    matrix = np.zeros((len(values[0]), loops + len(block.couplings), len(block.rows)))
    for k, loop in enumerate(block.loops):
        for place, terms in enumerate(loop.determined):
            by = slope(terms, values)
            matrix[:, 2 * k, place], matrix[:, 2 * k + 1, place] = by.real, by.imag
    riding = dict(block.riding)
    for k, coupling in enumerate(block.couplings, loops):
        for row, coefficient in efforts_of_coupling(functions, coupling):
            carrier = row if row in block.rows else riding.get(row, row)
            if carrier in block.rows:
                matrix[:, k, block.rows.index(carrier)] += coefficient
    return matrix


def efforts_of_coupling(functions: Functions, coupling: int) -> Iterator[tuple[int, float]]:
    """Rows of coordinates, and what a unit of a coupling's multiplier supplies to each, its coefficient; a row may come twice."""
    for joint, by in functions.plane.coupling_rows[coupling].items():
        yield from efforts_of_joint(functions, joint, by)


def efforts_of_joint(functions: Functions, joint: int, effort: float) -> Iterator[tuple[int, float]]:
    """Rows of coordinates, and what an effort of a joint, along or about its axis, does to each."""
    row, sense = functions.rows[joint], float(functions.plane.sense[joint])
    yield row, effort * (sense or 1.0)
    outer = functions.outer[joint]
    if outer is not None:
        yield outer, -effort * sense
