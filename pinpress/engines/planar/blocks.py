"""In which order the equations of a planar linkage are solved: block by block, as a press linkage is a chain of dyads."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from graphlib import TopologicalSorter
from heapq import heapify, heappop, heappush
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from ..joints import Coupling

if TYPE_CHECKING:
    from scipy.sparse import csr_array

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
