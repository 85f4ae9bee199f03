"""How bearings share idle forces in space, as `engines.forces` says: by all idle multipliers together or, in a long chain, by neighbours.

An idle multiplier belongs to one block of equations, and loads the bearings of its loops and of the joints on these alone. In a chain few
others load the same bearings. Then the matrix of the normal equations has a narrow band, and multipliers that have no bearing in common are
kept in one column: what they do to the bearings is worked out for all of a column at once.

That all of them are determined needs no decomposition there: the force of an idle multiplier on its own loop's bearing is of unit length,
whatever the joints carry.

Bearings that hold rotations carry idle couples too, which change no force. Where each idle multiplier is either a force or a couple, as in
planar groups, forces make a chain, shared by the sum of squared forces, and couples another, shared by that of moments after it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.frozen import Frozen
from ...common.quantities import Array
from ..forces import INVERTIBLE, lexicographic_responses

if TYPE_CHECKING:
    from scipy.sparse import csr_array

MANY_IDLE = 16  # idle multipliers from which on it pays to look for a band
CROWDED = 3  # a band pays where columns, and neighbours, are fewer than idle multipliers by this factor


@dataclass(frozen=True, eq=False, repr=False)
class Chain(Frozen):
    """Idle multipliers of which each loads few bearings.

    Attributes:
        column: (k,) column of every idle multiplier; those of one column have no bearing in common.
        columns: number of columns.
        of_row: (columns, rows) which idle multiplier has an equation, of those in a column; k where none has.
        of_bearing: (columns, bearings) which one loads a bearing; k where none does.
        place: (k,) of every idle multiplier in the order in which the band is narrow.
        band: number of diagonals below the main one.
        own_loops: loops on whose bearings the idle multipliers are forces of unit length.
    """

    column: NDArray[np.intp]
    columns: int
    of_row: NDArray[np.intp]
    of_bearing: NDArray[np.intp]
    place: NDArray[np.intp]
    band: int
    own_loops: NDArray[np.intp]

    def together(self, idle: Array) -> Array:
        """All idle multipliers (k, rows, m), of those in columns (columns, rows, m)."""
        result = np.zeros((len(self.column), *idle.shape[1:]))
        column, row = np.nonzero(self.of_row < len(self.column))
        result[self.of_row[column, row], row] = idle[column, row]
        return result

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Pairs of columns that may have bearings in common, and each with itself."""
        return [(p, q) for q in range(self.columns) for p in range(q + 1)]

    def band_entries(self) -> csr_array:
        """The matrix (band + 1 times k, pairs times bearings) that sums products of forces, of `pairs` in every bearing, to the diagonals
        of the normal equations."""
        from scipy.sparse import csr_array  # needed in long chains alone

        count, bearings = len(self.column), self.of_bearing.shape[1]
        entries: list[NDArray[np.intp]] = []
        for at, (p, q) in enumerate(self.pairs):
            some = np.flatnonzero((self.of_bearing[p] < count) & (self.of_bearing[q] < count))
            one, other = self.place[self.of_bearing[p, some]], self.place[self.of_bearing[q, some]]
            entries.append(np.array([np.abs(one - other) * count + np.minimum(one, other), at * bearings + some]))
        rows, columns = np.concatenate(entries, axis=1)
        return csr_array((np.ones(len(rows)), (rows, columns)), shape=((self.band + 1) * count, len(self.pairs) * bearings))


def build_chain(
    rows: Sequence[Collection[int]], loops: Sequence[Collection[int]], joints: Sequence[Collection[int]], size: tuple[int, int, int]
) -> Chain | None:
    """The chain of idle multipliers; None where these are few, or have too many bearings in common.

    Args:
        rows: of every idle multiplier the equations of its block.
        loops: the loops of its block.
        joints: the joints on these loops, as indices in v.
        size: numbers of equations, joints and loops of the linkage.
    """
    count, (row_count, joint_count, loop_count) = len(rows), size
    if count < MANY_IDLE:
        return None
    touched = [[*on, *(joint_count + loop for loop in own)] for on, own in zip(joints, loops, strict=True)]
    at: list[list[int]] = [[] for _ in range(joint_count + loop_count)]
    for k, bearings in enumerate(touched):
        for bearing in bearings:
            at[bearing].append(k)
    if CROWDED * max(map(len, at)) > count:
        return None
    column: list[int] = []
    for bearings in touched:
        taken = {column[other] for bearing in bearings for other in at[bearing] if other < len(column)}
        column.append(next(c for c in range(count) if c not in taken))
    columns = max(column) + 1
    place, band = _narrow_order(at, count)
    if CROWDED * max(columns, band) > count:
        return None
    of_row, of_bearing = np.full((columns, row_count), count), np.full((columns, joint_count + loop_count), count)
    for k in range(count):
        of_row[column[k], list(rows[k])] = k
        of_bearing[column[k], touched[k]] = k
    own_loops = np.unique(np.concatenate([list(own) for own in loops]))
    return Chain(np.array(column), columns, of_row, of_bearing, place, band, own_loops)


def _narrow_order(at: Iterable[Sequence[int]], count: int) -> tuple[NDArray[np.intp], int]:
    """Places (k,) of idle multipliers in an order in which those with common bearings are near each other, and how far apart they are."""
    from scipy.sparse import coo_array  # needed in long chains alone
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    together = np.array([(one, other) for those in at for one in those for other in those]).T
    order = reverse_cuthill_mckee(coo_array((np.ones(together.shape[1]), together), shape=(count, count)).tocsr(), symmetric_mode=True)
    place = np.empty(count, dtype=np.intp)
    place[order] = np.arange(count)
    one, other = place[together]
    return place, int(np.abs(one - other).max())


@dataclass(frozen=True, eq=False, repr=False)
class Chains(Frozen):
    """Idle forces and idle couples as chains. In arrays the columns of forces stand before those of couples.

    Attributes:
        forces: the chain of idle multipliers without moments at their own loops.
        couples: that of those without forces; None where there are none.
        is_couple: (k,) of every idle multiplier, in the order of its blocks, whether it is a couple.
    """

    forces: Chain
    couples: Chain | None
    is_couple: NDArray[np.bool_]

    @cached_property
    def column(self) -> NDArray[np.intp]:
        """(k,) column of every idle multiplier."""
        column = np.empty(len(self.is_couple), dtype=np.intp)
        column[~self.is_couple] = self.forces.column
        if self.couples is not None:
            column[self.is_couple] = self.forces.columns + self.couples.column
        return column

    @property
    def columns(self) -> int:
        """Number of columns."""
        return self.forces.columns + (0 if self.couples is None else self.couples.columns)

    def together(self, idle: Array) -> Array:
        """All idle multipliers (k, rows, m), forces first, of those in columns (columns, rows, m)."""
        forces = self.forces.together(idle[: self.forces.columns])
        return forces if self.couples is None else np.concatenate([forces, self.couples.together(idle[self.forces.columns :])])


def build_chains(
    rows: Sequence[Collection[int]],
    loops: Sequence[Collection[int]],
    joints: Sequence[Collection[int]],
    size: tuple[int, int, int],
    is_couple: NDArray[np.bool_],
) -> Chains | None:
    """The chains of idle multipliers; None where those of a kind are few, or have too many bearings in common.

    Arguments are those of `build_chain` and of `Chains`.
    """
    kinds = [np.flatnonzero(is_couple == couples).tolist() for couples in (False, True)]
    forces, couples = (
        build_chain([rows[k] for k in those], [loops[k] for k in those], [joints[k] for k in those], size) for those in kinds
    )
    return None if forces is None or (couples is None and kinds[1]) else Chains(forces, couples, is_couple)


# --------------------------------------------------------------------------------------------------------------------------- all together


class SharedByAll(NamedTuple):
    """How the idle forces of m states are shared, from decompositions of what they do to all bearings.

    Attributes:
        states: which states.
        idle: (k, rows, m) multipliers that balance each other.
        responses: (m, k, 3 bearings) see `lexicographic_responses`.
    """

    states: NDArray[np.intp] | slice
    idle: Array
    responses: list[Array]

    @property
    def of_couples(self) -> bool:
        """Whether they are couples that are shared after the forces; here all are shared together."""
        return False

    @property
    def objectives(self) -> int:
        """How many objectives decide."""
        return len(self.responses)

    def added(self, starts: Sequence[Array]) -> Array:
        """The multipliers (rows, m) to be added where objectives (bearings, 3, n) are these without idle ones."""
        parts = zip(self.responses, starts, strict=False)
        y = np.sum([response @ _configurations_first(start[None, ..., self.states]) for response, start in parts], axis=0)
        return np.asarray(np.einsum("krm,mk->rm", self.idle, -y[:, :, 0]))


def shared_by_all(states: NDArray[np.intp] | slice, idle: Array, objectives: Iterable[tuple[Array, float]]) -> SharedByAll:
    """Idle multipliers (k, rows, m) of some states, shared by objectives (k, bearings, 3, m) of a scale each, see `Objective`."""
    return SharedByAll(states, idle, lexicographic_responses((_configurations_first(each), scale) for each, scale in objectives))


def _configurations_first(vectors: Array) -> Array:
    """(m, 3 bearings, k) of vectors (k, bearings, 3, m)."""
    return vectors.transpose(3, 1, 2, 0).reshape(vectors.shape[3], -1, len(vectors))


# --------------------------------------------------------------------------------------------------------------------------- in a chain


class SharedByNeighbours(NamedTuple):
    """How the idle forces of a chain are shared in m states: by one objective, which determines them.

    Attributes:
        states: which states.
        idle: (columns, rows, m) multipliers that balance each other, in columns.
        chain: which ones stand in a column.
        objective: (columns, bearings, 3, m) what they do to the bearings.
        triangle: (band + 1, m k) Cholesky's factor of the normal equations of all states, one state after the other.
        of_couples: whether they are couples, which are shared by moments after the forces.
    """

    states: NDArray[np.intp] | slice
    idle: Array
    chain: Chain
    objective: Array
    triangle: Array
    of_couples: bool = False

    @property
    def objectives(self) -> int:
        return 1

    def added(self, starts: Sequence[Array]) -> Array:
        """The multipliers (rows, m) to be added where the objective (bearings, 3, n) is the first of these without them."""
        from scipy.linalg import cho_solve_banded  # needed in long chains alone

        chain, start = self.chain, starts[0][..., self.states]
        count, m = len(chain.column), start.shape[2]
        wanted = np.zeros((count + 1, m))
        for of_bearing, own in zip(chain.of_bearing, np.einsum("cbin,bin->cbn", self.objective, start), strict=True):
            np.add.at(wanted, of_bearing, own)
        ordered = np.empty((m, count))
        ordered[:, chain.place] = wanted[:count].T
        found = cho_solve_banded((self.triangle, True), ordered.ravel(), check_finite=False).reshape(m, count)
        y = np.zeros((count + 1, m))  # the last one is none
        np.negative(found[:, chain.place].T, out=y[:count])
        return np.asarray(np.einsum("crn,crn->rn", self.idle, y[chain.of_row]))


def shared_by_neighbours(
    states: NDArray[np.intp] | slice, idle: Array, chain: Chain, objective: Array, smallest: float
) -> SharedByNeighbours | None:
    """Idle multipliers (columns, rows, m) of some states of a chain, shared by an objective (columns, bearings, 3, m).

    Returns None where it may leave something open. ``smallest``: the least that an idle multiplier does to the bearing of its own loop.
    """
    from scipy.linalg import cholesky_banded  # needed in long chains alone

    count, m = len(chain.column), idle.shape[2]
    products = np.array([np.einsum("bin,bin->bn", objective[p], objective[q]) for p, q in chain.pairs])
    diagonals = (chain.band_entries() @ products.reshape(-1, m)).reshape(chain.band + 1, count, m)
    if not np.all(smallest**2 > INVERTIBLE * diagonals[0].sum(axis=0)):
        return None
    normal = np.ascontiguousarray(diagonals.transpose(0, 2, 1)).reshape(chain.band + 1, m * count)
    triangle = cholesky_banded(normal, overwrite_ab=True, lower=True, check_finite=False)
    return SharedByNeighbours(states, idle, chain, objective, triangle)
