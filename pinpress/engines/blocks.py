"""The order in which the equations of loops and couplings are solved: in groups as small as possible, one after another.

A press linkage is a chain of dyads: the first loop determines its joints from the driver, the next one its own from those, and so on.
Solved in this order, n loops take n times as long as one; solved all together, n cubed times.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from graphlib import TopologicalSorter
from heapq import heapify, heappop, heappush
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from scipy.sparse import csr_array

FEW = 8  # loops and couplings up to which the smallest group is found by trying all


class Group(NamedTuple):
    """Equations that are solved together.

    Attributes:
        members: their loops and couplings.
        joints: the joints that they determine, rising.
    """

    members: tuple[int, ...]
    joints: tuple[int, ...]


def ordered_groups(
    involved: Mapping[int, Collection[int]], equation_count: Callable[[int], int], known: Collection[int], one_block: bool = False
) -> list[Group] | None:
    """Groups as small as possible, ordered so that each needs only the joints of the ones before it; None where there is no such order.

    Args:
        involved: the joints of every loop and coupling. Among equally small groups those of the first ones come first.
        equation_count: number of equations of a loop or coupling, and of joints that it can determine.
        known: the joints that need not be determined.
        one_block: whether to put all equations into one group.
    """
    waiting, result = _Waiting(involved, equation_count, known), []
    while waiting.unknown:
        found = tuple(waiting.unknown) if one_block else waiting.next_group()
        if found is None:
            return None
        joints = tuple(sorted(waiting.unknown_of(found)))
        if len(joints) > sum(map(equation_count, found)):
            return None
        result.append(Group(found, joints))
        waiting.settle(found, joints)
    return result


class _Waiting:
    """The loops and couplings that are in no group yet.

    Attributes:
        unknown: by loop or coupling, those of its joints that no group determines yet.
    """

    def __init__(self, involved: Mapping[int, Collection[int]], equation_count: Callable[[int], int], known: Collection[int]) -> None:
        self.equation_count = equation_count
        self.unknown = {k: set(joints).difference(known) for k, joints in involved.items()}
        self._places = {k: place for place, k in enumerate(self.unknown)}
        self._at: dict[int, set[int]] = {}  # loops and couplings by their unknown joints
        for k, unknown in self.unknown.items():
            for joint in unknown:
                self._at.setdefault(joint, set()).add(k)
        self._planned: list[tuple[int, ...]] = []
        self._ready = [(self.surplus(k), place, k) for k, place in self._places.items() if self.surplus(k) >= 0]
        heapify(self._ready)

    def surplus(self, k: int) -> int:
        """Number of equations that a loop or coupling has beyond its unknown joints; below 0 where it cannot determine them alone."""
        return self.equation_count(k) - len(self.unknown[k])

    def unknown_of(self, group: Collection[int]) -> set[int]:
        """The unknown joints of a group."""
        return set().union(*(self.unknown[k] for k in group))

    def settle(self, group: Collection[int], joints: Collection[int]) -> None:
        """Take a group out, because it determines these joints."""
        for k in group:
            del self.unknown[k]
        for joint in joints:
            for k in self._at.pop(joint) & self.unknown.keys():
                self.unknown[k].discard(joint)
                if self.surplus(k) >= 0:
                    heappush(self._ready, (self.surplus(k), self._places[k], k))

    def next_group(self) -> tuple[int, ...] | None:
        """The members of the next group: a single one if it determines its joints, else as few as possible that do so together.
        None where there are none."""
        while self._ready:
            surplus, _, k = self._ready[0]
            if k in self.unknown and surplus == self.surplus(k):
                return (k,)
            heappop(self._ready)
        return self._smallest_group() if len(self.unknown) <= FEW else self._next_interdependent()

    def _smallest_group(self) -> tuple[int, ...] | None:
        """The smallest group that determines its joints, found by trying all groups; None where there is none."""
        for size in range(2, len(self.unknown) + 1):
            found, fewest = None, 0
            for group in combinations(self.unknown, size):
                surplus = sum(map(self.equation_count, group)) - len(self.unknown_of(group))
                if surplus >= 0 and (found is None or surplus < fewest):
                    found, fewest = group, surplus
            if found is not None:
                return found
        return None

    def _next_interdependent(self) -> tuple[int, ...] | None:
        """The next group of loops and couplings that need each other, where there are many; None where there is none."""
        while self._planned and self.unknown.keys().isdisjoint(self._planned[-1]):
            self._planned.pop()
        planned = self._planned[-1] if self._planned else ()
        if not planned or not self.unknown.keys() >= set(planned) or sum(map(self.equation_count, planned)) < len(self.unknown_of(planned)):
            self._planned = interdependent_groups(self.unknown, self.equation_count)[::-1]
        return self._planned.pop() if self._planned else None


def interdependent_groups(unknown: Mapping[int, set[int]], equation_count: Callable[[int], int]) -> list[tuple[int, ...]]:
    """Loops and couplings in groups that need each other, each group after those that it needs; empty where a joint has no equation.

    Every joint is assigned to one equation that determines it. A loop or coupling then needs those to which its other joints are assigned;
    the groups are the strongly connected components of these needs.

    Args:
        unknown: unknown joints by loop or coupling.
        equation_count: number of equations of a loop or coupling.
    """
    from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching  # see `_graph`

    members = list(unknown)
    equations = [place for place, k in enumerate(members) for _ in range(equation_count(k))]
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
