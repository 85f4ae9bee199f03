"""In which order the equations of a planar linkage are solved: block by block, as a press linkage is a chain of dyads."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

from .loops import Coupling


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
        loops, joints: how many there are. driver: index of its joint.
        one_block: all equations in one.
    """
    involved: list[set[int]] = [{j for k, j in owners if k == loop} for loop in range(loops)]
    involved += [{coupling.follower, coupling.leader} for coupling in couplings]
    rows = {owner: loops + row for row, owner in enumerate(owners)}
    # couplings first, so that it is not them that are found to be redundant
    known, remaining, blocks = {driver}, [*range(loops, len(involved)), *range(loops)], []
    while remaining:
        found: tuple[int, ...] | None = None
        fewest = 0
        for size in range(len(remaining) if one_block else 1, len(remaining) + 1):
            for group in combinations(remaining, size):
                spare = sum(2 if k < loops else 1 for k in group) - len(set().union(*(involved[k] for k in group)) - known)
                if spare >= 0 and (found is None or spare < fewest):
                    found, fewest = group, spare
            if found is not None:
                break
        if found is None:
            return None
        members = tuple(k for k in found if k < loops)
        unknown = tuple(sorted(set().union(*(involved[k] for k in found)) - known))
        own = tuple(tuple((j, rows[k, j]) for j in unknown if j in involved[k]) for k in members)
        before = tuple(tuple((j, rows[k, j]) for j in sorted(involved[k] & known - {driver})) for k in members)
        blocks.append(Block(members, tuple(k - loops for k in found if k >= loops), unknown, own, before))
        if blocks[-1].redundant and not members:
            return None  # a ring of gear pairs: its idle torques reach no bearing, by which they could be shared
        known |= set(unknown)
        remaining = [k for k in remaining if k not in found]
    return tuple(blocks) if len(known) == joints else None
