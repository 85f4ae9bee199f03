"""The order in which the equations of loops and relations are solved: in groups as small as possible, one after another.

A press linkage is a chain of dyads: the first loop determines its joints from the driver, the next one its own from those, and so on.
Solved in this order, n loops take n times as long as one; solved all together, n cubed times.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from heapq import heapify, heappop, heappush
from itertools import combinations
from typing import NamedTuple

FEW = 8  # loops and relations up to which all groups are tried; of more, which have millions of groups, pairs, triples and all together


class Group(NamedTuple):
    """Equations that are solved together.

    Attributes:
        members: their loops and relations.
        joints: the joints that they determine, rising.
    """

    members: tuple[int, ...]
    joints: tuple[int, ...]


def ordered_groups(
    involved: Mapping[int, Collection[int]], equation_count: Callable[[int], int], known: Collection[int], one_block: bool = False
) -> list[Group] | None:
    """Groups as small as possible, ordered so that each needs only the joints of the ones before it; None if there is no such order.

    Args:
        involved: the joints of every loop and relation. Among equally small groups those of the first ones come first.
        equation_count: number of equations of a loop or relation, and of joints that it can determine.
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
    """The loops and relations that are in no group yet.

    Attributes:
        unknown: by loop or relation, those of its joints that no group determines yet.
    """

    def __init__(self, involved: Mapping[int, Collection[int]], equation_count: Callable[[int], int], known: Collection[int]) -> None:
        self.equation_count = equation_count
        self.unknown = {k: set(joints).difference(known) for k, joints in involved.items()}
        self._places = {k: place for place, k in enumerate(self.unknown)}
        self._at: dict[int, set[int]] = {}  # loops and relations by their unknown joints
        for k, unknown in self.unknown.items():
            for joint in unknown:
                self._at.setdefault(joint, set()).add(k)
        self._ready = [(self.surplus(k), place, k) for k, place in self._places.items() if self.surplus(k) >= 0]
        heapify(self._ready)

    def surplus(self, k: int) -> int:
        """Number of equations that a loop or relation has beyond its unknown joints; below 0 where it cannot determine them alone."""
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
        None if there are none."""
        while self._ready:
            surplus, _, k = self._ready[0]
            if k in self.unknown and surplus == self.surplus(k):
                return (k,)
            heappop(self._ready)
        return self._smallest_group()

    def _smallest_group(self) -> tuple[int, ...] | None:
        """The smallest group that determines its joints, found by trying groups; None if there is none."""
        count = len(self.unknown)
        for size in range(2, count + 1) if count <= FEW else (2, 3, count):
            found, fewest = None, 0
            for group in combinations(self.unknown, size):
                surplus = sum(map(self.equation_count, group)) - len(self.unknown_of(group))
                if surplus >= 0 and (found is None or surplus < fewest):
                    found, fewest = group, surplus
            if found is not None:
                return found
        return None
