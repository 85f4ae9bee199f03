"""The equations of a linkage in blocks that are solved one after another, at all configurations at once.

Which blocks there are is seen at one configuration. A loop has as many equations as the rank of its columns there: two of a planar loop
with a ball joint, three of one through space. A block determines as many joints as it has such equations. Then the whole is regular where
each block is, and a solution costs as much as those of all blocks by themselves. Where there are no such blocks, all equations are one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.frozen import Frozen
from ...common.quantities import Array
from ..blocks import Group, ordered_groups
from ..structure import ZERO


@dataclass(frozen=True, eq=False, repr=False)
class Block(Frozen):
    """Equations that are solved together.

    Attributes:
        rows: (m,) the equations.
        joints: (k,) indices in v of the joints that they determine, k <= m.
        known: (p,) indices in v of the passive joints of earlier blocks that they contain.
        shape: index of its shape in `Blocks.own`.
        place: its place among the blocks of this shape.
        coupling: where the entries of the known joints stand in `Blocks.coupling`; m x p of them.
    """

    rows: NDArray[np.intp]
    joints: NDArray[np.intp]
    known: NDArray[np.intp]
    shape: int
    place: int
    coupling: slice


@dataclass(frozen=True, eq=False, repr=False)
class Blocks(Frozen):
    """The order in which the equations of a linkage are solved.

    Attributes:
        blocks: in this order.
        own: for every shape of blocks (m, k, b) the places of their Jacobians' numbers among the entries, see `Loops.entries`.
        coupling: the same of the columns of known joints, of all blocks.
        rows: number of equations.
        idle: number of equations that are redundant where all blocks are regular.
    """

    blocks: tuple[Block, ...]
    own: tuple[NDArray[np.intp], ...]
    coupling: NDArray[np.intp]
    rows: int
    idle: int


def build_blocks(places: NDArray[np.intp], values: Array, members: NDArray[np.intp], passive: NDArray[np.intp]) -> Blocks | None:
    """The blocks of a linkage; None if there are fewer equations than joints.

    Args:
        places: (2, ne) equation and joint of every entry of the Jacobian, see `Loops.entries`.
        values: (ne,) these entries at a configuration that is nothing special.
        members: (rows,) the loop or coupling of every equation.
        passive: indices of the passive joints in v.
    """
    if not 0 < len(passive) <= len(members):
        return None
    place_of = {(row, joint): place for place, (row, joint) in enumerate(places.T.tolist())}
    moving = set(passive.tolist())
    rows_of: dict[int, list[int]] = {}
    for row, member in enumerate(members.tolist()):
        rows_of.setdefault(member, []).append(row)
    joints_of: dict[int, set[int]] = {member: set() for member in rows_of}
    for row, joint in place_of:
        if joint in moving:
            joints_of[int(members[row])].add(joint)
    with_zero = np.append(values, 0.0)

    def looked_up(rows: Sequence[int], joints: Sequence[int]) -> list[list[int]]:
        return [[place_of.get((row, joint), len(values)) for joint in joints] for row in rows]

    ranks = {k: _rank(with_zero[looked_up(rows, sorted(joints_of[k]))]) for k, rows in rows_of.items()}
    groups = ordered_groups(joints_of, lambda k: ranks[k], ())
    if groups is None or any(len(group.joints) != sum(ranks[k] for k in group.members) for group in groups):
        groups = [Group(tuple(rows_of), tuple(passive.tolist()))]
    own: dict[tuple[int, int], list[list[list[int]]]] = {}
    coupling: list[int] = []
    blocks = []
    for group in groups:
        rows = sorted(row for k in group.members for row in rows_of[k])
        known = sorted(set().union(*(joints_of[k] for k in group.members)).difference(group.joints))
        alike, start = own.setdefault((len(rows), len(group.joints)), []), len(coupling)
        alike.append(looked_up(rows, group.joints))
        coupling += [place for line in looked_up(rows, known) for place in line]
        shape = list(own).index((len(rows), len(group.joints)))
        rows_at, joints, known_at = (np.array(each, dtype=np.intp) for each in (rows, group.joints, known))
        blocks.append(Block(rows_at, joints, known_at, shape, len(alike) - 1, slice(start, len(coupling))))
    return Blocks(
        blocks=tuple(blocks),
        own=tuple(np.array(each, dtype=np.intp).reshape(len(each), *shape).transpose(1, 2, 0).copy() for shape, each in own.items()),
        coupling=np.array(coupling, dtype=np.intp),
        rows=len(members),
        idle=len(members) - len(passive),
    )


def _rank(columns: Array) -> int:
    return int(np.linalg.matrix_rank(columns, rtol=ZERO)) if columns.size else 0


class _Factors(NamedTuple):
    """Blocks of one shape: (k, m, b, n) from gaps to the joints that close them, in the least-squares sense, and (m - k, m, b, n)
    orthonormal multipliers that balance each other on the joints of the block."""

    inverse: Array
    idle: Array


class InBlocks:
    """The columns of the passive joints, factorised in blocks.

    Attributes:
        regular: (n,) the configurations at which all blocks certainly have full rank. At the others solutions are wrong or not finite.
    """

    def __init__(self, blocks: Blocks, entries: Array) -> None:
        n = entries.shape[1]
        self._blocks, self.regular = blocks, np.ones(n, dtype=bool)
        self._coupling = entries.take(blocks.coupling, axis=0)
        columns = [entries.take(own, axis=0) for own in blocks.own]
        lengths = [np.sqrt(np.einsum("mkbn,mkbn->kbn", each, each)) for each in columns]
        longest = np.max([each.max(axis=(0, 1), initial=0.0) for each in lengths], axis=0)
        with np.errstate(all="ignore"):  # blocks that are not regular
            self._factors = [self._factorised(*each, longest) for each in zip(columns, lengths, strict=True)]

    def _factorised(self, columns: Array, lengths: Array, longest: Array) -> _Factors:
        """Factors of columns (m, k, b, n) of these lengths (k, b, n); ``longest``: (n,) of all."""
        m, k, *last = columns.shape
        still = lengths <= ZERO * longest  # rounding: these joints move nothing here
        columns /= np.where(still, np.inf, lengths)
        inverse, idle = _triangularised(columns.reshape(m, k, math.prod(last)))
        # A smallest singular value above 1e-5 shows full rank with certainty; so does one above `ZERO`, but rounding is closer there.
        good = 1e-5 * np.sqrt(np.einsum("kmn,kmn->n", inverse, inverse)) < 1.0
        self.regular &= good.reshape(last).all(axis=0)
        inverse = inverse.reshape(k, m, *last)
        inverse /= lengths[:, None]
        return _Factors(inverse, idle.reshape(m - k, m, *last))

    def _each(self) -> Iterator[tuple[Block, Array, Array]]:
        """The blocks, their inverses (k, m, n), and the columns (m, p, n) of their known joints."""
        for block in self._blocks.blocks:
            coupling = self._coupling[block.coupling].reshape(len(block.rows), len(block.known), len(self.regular))
            yield block, self._factors[block.shape].inverse[:, :, block.place], coupling

    def rates(self, target: Array, result: Array) -> None:
        """Fill in the rates (nv, n) of the passive joints that change the gaps by ``target`` (rows, n)."""
        for block, inverse, coupling in self._each():
            wanted = target[block.rows]
            if len(block.known):
                wanted -= np.einsum("mpn,pn->mn", coupling, result[block.known])
            result[block.joints] = np.einsum("kmn,mn->kn", inverse, wanted)

    def multipliers(self, effort: Array) -> Array:
        """Multipliers (rows, n) of least norm that balance the efforts (nv, n) of the passive joints."""
        left, result = effort.copy(), np.empty((self._blocks.rows, effort.shape[1]))
        for block, inverse, coupling in reversed(list(self._each())):
            result[block.rows] = found = np.einsum("kmn,kn->mn", inverse, left[block.joints])
            if len(block.known):
                left[block.known] -= np.einsum("mpn,mn->pn", coupling, found)
        return result

    def idle(self) -> Array:
        """(n, rows, idle) orthonormal multipliers that balance each other on the passive joints.

        Each belongs to one block. On joints of earlier blocks it has no effort: their columns add nothing to the rank of a loop's own.
        """
        result, filled = np.zeros((self._blocks.rows, self._blocks.idle, len(self.regular))), 0
        for block in self._blocks.blocks:
            own = self._factors[block.shape].idle[:, :, block.place]
            result[block.rows, filled : filled + len(own)] = own.swapaxes(0, 1)
            filled += len(own)
        return result.transpose(2, 0, 1)


def _triangularised(columns: Array) -> tuple[Array, Array]:
    """Pseudo-inverses (k, m, n) of matrices (m, k, n) with k <= m, and orthonormal bases (m - k, m, n) of what is square to their columns,
    by Householder's reflections. Not finite where a matrix is singular.

    LAPACK takes such small matrices one by one, which costs several times as much.
    """
    m, k, n = columns.shape
    work = np.empty((m, k + m, n))  # becomes the triangle and the transposed orthogonal matrix
    work[:, :k], work[:, k:] = columns, np.eye(m)[:, :, None]
    diagonal = np.empty((k, n))
    for j in range(k):
        mirror = work[j:, j].copy()
        length = np.sqrt(np.einsum("in,in->n", mirror, mirror))
        np.copysign(length, -mirror[0], out=diagonal[j])
        mirror[0] -= diagonal[j]
        rest = work[j:, j + 1 :]
        along = np.einsum("in,icn->cn", mirror, rest)
        along /= length * np.abs(mirror[0])
        for row, part in zip(rest, mirror, strict=True):
            row -= part * along
    inverse = work[:k, k:].copy()
    for j in range(k - 1, -1, -1):
        if j < k - 1:
            inverse[j] -= np.einsum("in,imn->mn", work[j, j + 1 : k], inverse[j + 1 :])
        inverse[j] /= diagonal[j]
    return inverse, work[k:, k:]
