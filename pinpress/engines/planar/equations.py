"""The equations of a planar linkage in absolute coordinates: the absolute angles of the links that turn, and the travels along guides.

The travel along a guide is called a *way*. The gap of a loop is a constant plus the sum of c f over the functions f of the joints, with
complex coefficients c (see `functions`: a rotor u, or a way times the rotor u of its guide). Its *slope* is its derivative by a coordinate:

    by the absolute angle of a link with the rotor u    i times the sum of c f over u itself and all ways whose guides u turns
    by a way along a guide with the rotor u             c u

The equations are solved in blocks. A block needs only its own coordinates, the driver's and those of earlier blocks. In a *dyad* two
coordinates close one loop. If the loop opens at the rate o, their rates x and y close it: a x + b y + o = 0, with the complex slopes a and
b. The solution is

    x = Re(o e1),  y = Re(o e2)    with the inverses    e1 = -i conj(b) / D,  e2 = i conj(a) / D,   D = Im(conj(a) b)

In a *lever* one coordinate closes one loop, and a x + o = 0 has the inverse e1 = -conj(a) / |a|^2. All other blocks are solved as matrices.

The absolute angle of a link needs the angle of the link that carries its joint. In a few linkages a later block determines that angle, for
a joint of an earlier block or for the driver. Then all equations make one block. A driver on a moving link is said to *ride* on it.
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
"""By loop: row of a function -> its coefficient c in the gap."""
Terms = tuple[tuple[int | None, ComplexArray], ...]
"""The terms of a slope: rows of functions, each with its coefficient; the row None is the function 1."""


class LoopRows(NamedTuple):
    """A loop in its block: the functions in its gap, the slopes of its gap, and where its force acts.

    "Earlier" are the driver and the coordinates of earlier blocks.

    Attributes:
        loop: index of the loop.
        earlier_functions: rows and coefficients of earlier functions. The force of the loop does work on them.
        earlier_guides: rotor, way and coefficient of every way of this block whose guide turns with an earlier rotor.
        earlier_slopes: rows of the earlier coordinates that move the loop, each with the terms of the gap's slope, see `slope`.
        slopes: terms of the gap's slope by every coordinate of this block.
        carriers: the joints that carry only one of the loop's ends, with the sign in `Plane.incidence`.
    """

    loop: int
    earlier_functions: tuple[tuple[int, ComplexArray], ...]
    earlier_guides: tuple[tuple[int, int, ComplexArray], ...]
    earlier_slopes: tuple[tuple[int, Terms], ...]
    slopes: tuple[Terms, ...]
    carriers: tuple[tuple[int, float], ...]


class BlockRows(NamedTuple):
    """Equations that are solved together, for motion and for forces, by rows of functions.

    Attributes:
        joints: the joints whose coordinates the block determines.
        rows: rows of the functions of these joints.
        riding: pairs of a function and the rotor that turns it, for the ways of the block and for a driver that rides. The outer pair comes
            first: the ways along guides on the driver's link, then the driver.
        loops: the loops.
        relations: indices of the relations.
        has_inverses: whether the block is a dyad or a lever, whose solution has a closed form by inverses.
        redundant: number of redundant equations.
        balancing: indices of the earlier blocks that balance the idle forces of this one, the last block first; empty without redundant
            equations.
    """

    joints: tuple[int, ...]
    rows: tuple[int, ...]
    riding: tuple[tuple[int, int], ...]
    loops: tuple[LoopRows, ...]
    relations: tuple[int, ...]
    has_inverses: bool
    redundant: int
    balancing: tuple[int, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Equations:
    """The equations of a linkage, in the order in which they are solved.

    Attributes:
        functions: the functions of its joints, with their rows.
        blocks: the blocks of its equations.
    """

    functions: Functions
    blocks: tuple[BlockRows, ...]

    @staticmethod
    def of(plane: Plane, coefficients: Coefficients | None = None) -> Equations:
        """The equations of a linkage; ``coefficients``: in place of those of its own gaps."""
        functions = Functions(plane)
        if coefficients is None:
            coefficients = [nonzero(functions, gap) for gap in plane.gap_rows]
        return Equations(functions, _build_blocks(functions, coefficients))

    def with_coefficients(self, coefficients: Coefficients) -> Equations:
        """The same blocks, where the same functions have other coefficients."""
        blocks = []
        for block in self.blocks:
            loops = (_build_loop(self.functions, each.loop, coefficients[each.loop], block.rows, block.riding) for each in block.loops)
            blocks.append(block._replace(loops=tuple(loops)))
        return Equations(self.functions, tuple(blocks))


class Configurations(NamedTuple):
    """n configurations: lists of arrays (n,) by rows of functions, and matrices by blocks.

    Attributes:
        functions: values of the functions.
        ways: travels along guides; the rows of other functions have no meaning.
        inverses: inverses of the coordinates that a dyad or lever determines; the rows of other functions have no meaning.
        slopes: index of a block -> matrix (n, equations, coordinates) of its slopes, for all blocks that determine joints without inverses.
    """

    functions: Sequence[ComplexArray]
    ways: Sequence[Array]
    inverses: Sequence[ComplexArray]
    slopes: Mapping[int, Array]


# -------------------------------------------------------------------------------------------------------- blocks by rows of functions


def _build_blocks(functions: Functions, coefficients: Coefficients) -> tuple[BlockRows, ...]:
    """The blocks of `Plane.blocks` by rows of functions, or all equations in one block where no order is possible."""
    plane = functions.plane
    blocks, in_order = plane.blocks, _can_solve_in_order(functions, coefficients)
    if not in_order:
        joints = tuple(j for j in range(len(plane.parents)) if j != plane.driver)
        loops, relations = tuple(range(len(plane.loop_heights))), tuple(range(len(plane.offsets)))
        blocks = (Block(loops, relations, joints),)
    result: list[BlockRows] = []
    for block in blocks:
        rows = tuple(functions.rows[joint] for joint in block.joints)
        riding = _find_riding_pairs(functions, rows, one_block=not in_order)
        block_loops = tuple(_build_loop(functions, loop, coefficients[loop], rows, riding) for loop in block.loops)
        has_inverses = in_order and block.kind in ("dyad", "lever")
        balancing = _find_balancing_blocks(block_loops, block.relations, result) if block.redundant else ()
        result.append(BlockRows(block.joints, rows, riding, block_loops, block.relations, has_inverses, block.redundant, balancing))
    return tuple(result)


def nonzero(functions: Functions, gap: ComplexArray) -> dict[int, ComplexArray]:
    """Row of a function -> its coefficient in a gap (nb,), where this is not zero. The constant is left out."""
    return {functions.order[place]: np.array(gap[place]) for place in np.flatnonzero(gap).tolist() if place}


def _can_solve_in_order(functions: Functions, coefficients: Coefficients) -> bool:
    """Whether every block needs only coordinates of the driver, of earlier blocks and of its own."""
    plane, rows = functions.plane, functions.rows

    def carrier_rows(joints: Iterable[int]) -> set[int]:
        """Rows of the rotors of the links that carry these joints."""
        return {functions.order[carrier] for j in joints if (carrier := plane.rotor(plane.parents[j]))}

    available = {rows[plane.driver]}
    if not carrier_rows([plane.driver]) <= available:
        return False
    for block in plane.blocks:
        available |= {rows[joint] for joint in block.joints}
        coupled = [joint for relation in block.relations for joint in plane.relation_rows[relation]]
        necessary = set().union(carrier_rows([*block.joints, *coupled]), *(coefficients[loop] for loop in block.loops))
        if not necessary <= available:
            return False
    return True


def _build_loop(
    functions: Functions, loop: int, coefficients: Mapping[int, ComplexArray], block_rows: Sequence[int], riding: Sequence[tuple[int, int]]
) -> LoopRows:
    """A loop of a block that determines the coordinates of ``block_rows``; ``riding``: see `BlockRows`."""
    carriers = tuple((joint, signs[loop]) for joint, signs in enumerate(functions.plane.loops_of_joint) if loop in signs)
    earlier_guides = tuple(
        (rotor, row, coefficient)
        for row, coefficient in coefficients.items()
        if row in block_rows and (rotor := functions.guides.get(row)) is not None and rotor not in block_rows
    )
    earlier_functions = tuple((row, coefficient) for row, coefficient in coefficients.items() if row not in block_rows)
    earlier = dict.fromkeys((*(row for row, _ in earlier_functions), *(rotor for rotor, *_ in earlier_guides)))  # each row once, in order
    earlier_slopes = tuple((row, _collect_terms(functions, coefficients, row, riding)) for row in earlier)
    slopes = tuple(_collect_terms(functions, coefficients, row, riding) for row in block_rows)
    return LoopRows(loop, earlier_functions, earlier_guides, earlier_slopes, slopes, carriers)


def _collect_terms(functions: Functions, coefficients: Mapping[int, ComplexArray], row: int, riding: Sequence[tuple[int, int]]) -> Terms:
    """The terms of the slope of a gap by the coordinate of a row."""
    if row in functions.guides:
        return ((functions.guides[row], coefficients[row]),) if row in coefficients else ()
    return tuple((each, coefficients[each] * I) for each in _list_turning_rows(functions, row, riding) if each in coefficients)


def _list_turning_rows(functions: Functions, row: int, riding: Sequence[tuple[int, int]]) -> list[int]:
    """Rows of the functions that turn with a rotor: the rotor, the ways along its guides, and a driver that rides on it with all that turns
    with the driver."""
    turning = [row, *(way for way, rotor in functions.guides.items() if rotor == row)]
    for rider, rotor in riding:
        if rotor == row and rider not in functions.guides:
            turning += _list_turning_rows(functions, rider, riding)
    return turning


def _find_riding_pairs(functions: Functions, block_rows: Sequence[int], one_block: bool) -> tuple[tuple[int, int], ...]:
    """`BlockRows.riding` of a block that determines these rows; ``one_block``: whether all equations are this block."""
    plane = functions.plane
    driver = functions.rows[plane.driver]
    carrier = plane.rotor(plane.parents[plane.driver])
    pairs = []
    if one_block and plane.sense[plane.driver] and carrier:
        pairs += [(way, driver) for way, rotor in functions.guides.items() if rotor == driver]
        pairs.append((driver, functions.order[carrier]))
    for way, rotor in functions.guides.items():
        if rotor is not None and (way in block_rows or (one_block and way == driver)) and (way, rotor) not in pairs:
            pairs.append((way, rotor))
    return tuple(pairs)


def _find_balancing_blocks(loops: Sequence[LoopRows], relations: Sequence[int], earlier: Sequence[BlockRows]) -> tuple[int, ...]:
    """Indices of the earlier blocks that move the equations of a block, directly or through each other, the last one first.

    Blocks with relations are always counted, and all blocks for one with relations.
    """
    if relations:
        return tuple(reversed(range(len(earlier))))
    moving, places = _collect_earlier_rows(loops), []
    for place in reversed(range(len(earlier))):
        block = earlier[place]
        if block.relations or not moving.isdisjoint(block.rows):
            places.append(place)
            moving |= _collect_earlier_rows(block.loops)
    return tuple(places)


def _collect_earlier_rows(loops: Iterable[LoopRows]) -> set[int]:
    """Rows of the earlier coordinates that move loops."""
    return {row for loop in loops for row, _ in loop.earlier_functions} | {rotor for loop in loops for rotor, *_ in loop.earlier_guides}


# ------------------------------------------------------------------------------------------------------------------------- configurations


def configurations_at(equations: Equations, basis: ComplexArray, position: Array) -> Configurations:
    """The n configurations with the basis (nb, n) and the joint coordinates ``position`` (nv, n)."""
    functions = equations.functions
    ways: list[Array] = [position[0]] * functions.count  # only the rows of ways are filled in and read
    for joint in functions.plane.prismatic:
        ways[functions.rows[joint]] = position[joint]
    values: list[ComplexArray] = [basis[place] for place in functions.places]
    inverses = list(values)  # only the rows of dyads and levers are filled in and read
    for block in equations.blocks:
        if block.has_inverses:
            for row, inverse in zip(block.rows, _compute_inverses(*slopes_of_dyad(block, values)), strict=True):
                inverses[row] = inverse
    blocks = enumerate(equations.blocks)
    slopes = {place: matrix_of(equations, block, values) for place, block in blocks if not block.has_inverses and block.rows}
    return Configurations(values, ways, inverses, slopes)


def _compute_inverses(a: ComplexArray, b: ComplexArray | None = None) -> tuple[ComplexArray, ...]:
    """The inverses e1 and e2 of a dyad with the slopes a and b, or e1 of a lever with the slope a (see the module)."""
    conjugate_a = a.conj()
    if b is None:
        return (conjugate_a * (-1.0 / (a.real * a.real + a.imag * a.imag)),)
    factor = 1.0 / (conjugate_a * b).imag
    e1, e2 = b.conj(), conjugate_a
    e1 *= factor * -1j
    e2 *= factor * 1j
    return e1, e2


def slopes_of_dyad(block: BlockRows, values: Sequence[ComplexArray]) -> list[ComplexArray]:
    """The slopes (n,) of the gap of a dyad or lever by its coordinates; ``values``: of the functions, by rows."""
    return [slope(terms, values) for terms in block.loops[0].slopes]


def slope(terms: Terms, values: Sequence[ComplexArray]) -> ComplexArray:
    """The slope (n,) with these terms; ``values``: of the functions, by rows."""
    if not terms:
        return np.zeros(values[0].shape, complex)
    (row, coefficient), *others = terms
    total = np.full(values[0].shape, coefficient) if row is None else values[row] * coefficient
    for other, coefficient in others:
        if other is not None:
            total += values[other] * coefficient
    return total


def matrix_of(equations: Equations, block: BlockRows, values: Sequence[ComplexArray]) -> Array:
    """The matrix (n, equations, coordinates) of a block's slopes: two rows for the real and imaginary part of every loop, then the
    relations."""
    functions, loop_equations = equations.functions, 2 * len(block.loops)
    matrix = np.zeros((len(values[0]), loop_equations + len(block.relations), len(block.rows)))
    for k, loop in enumerate(block.loops):
        for column, terms in enumerate(loop.slopes):
            gap_slope = slope(terms, values)
            matrix[:, 2 * k, column], matrix[:, 2 * k + 1, column] = gap_slope.real, gap_slope.imag
    # a travel does not change as its guide turns, so that only angles are passed on to what carries them
    riding = {rider: rotor for rider, rotor in block.riding if rider not in functions.guides}
    for k, relation in enumerate(block.relations, loop_equations):
        for row, coefficient in efforts_of_relation(functions, relation):
            moving_row = row if row in block.rows else riding.get(row, row)  # a driver that rides turns with its carrier
            if moving_row in block.rows:
                matrix[:, k, block.rows.index(moving_row)] += coefficient
    return matrix


def efforts_of_relation(functions: Functions, relation: int) -> Iterator[tuple[int, float]]:
    """Rows of coordinates, each with the effort on it of a relation whose multiplier is 1; a row can come twice.

    By virtual work this effort is also the slope of the relation by the coordinate.
    """
    for joint, coefficient in functions.plane.relation_rows[relation].items():
        yield from efforts_of_joint(functions, joint, coefficient)


def efforts_of_joint(functions: Functions, joint: int, effort: float) -> Iterator[tuple[int, float]]:
    """Rows of coordinates, each with its share of an effort of a joint (force along its axis or torque about it): the coordinate of the
    joint, and opposite to it the angle of the link that carries the joint."""
    row, sense = functions.rows[joint], float(functions.plane.sense[joint])
    yield row, effort * (sense or 1.0)
    outer = functions.outer[joint]
    if outer is not None:
        yield outer, -effort * sense
