"""The functions of the joints of a planar linkage, as rows of the arrays in which forces are balanced and chains of dyads are closed.

Every joint has one function of the basis of `model.Plane`: a revolute joint the rotor of the link it turns, a prismatic joint its *way*
times the rotor of its guide. Here the functions stand in the order of the joints, and a row of ones before those of every joint on the
frame: in this order the forces of each tree follow from consecutive rows.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

from .model import Plane


class Functions:
    """The rows of the functions of a linkage.

    Attributes:
        plane: the linkage.
        rows: (nv,) row of every joint's function.
        ones: rows that are 1.
        count: number of rows.
        order: (nb,) rows in the order of the basis of `Plane`.
        guides: by row of a way that of the rotor of its guide, None if this does not turn.
    """

    def __init__(self, plane: Plane) -> None:
        self.plane = plane
        # Pinocchio's readers bring the joints of a tree one after the other; a model in another order counts as one tree.
        consecutive = all(plane.parents[j] < 0 or plane.carriers(j)[0] == plane.carriers(j - 1)[0] for j in range(1, len(plane.parents)))
        rows: list[int] = []
        ones: list[int] = []
        for parent in plane.parents:
            if parent < 0 and (consecutive or not ones):
                ones.append(len(rows) + len(ones))
            rows.append(len(rows) + len(ones))
        self.rows, self.ones, self.count = tuple(rows), tuple(ones), len(rows) + len(ones)
        self.order: tuple[int, ...] = (0, *(self.rows[joint] for joint in (*plane.revolute, *plane.prismatic)))
        self.guides: Mapping[int, int | None] = {self.order[way]: self.order[rotor] if rotor else None for way, _, rotor in plane.guides}

    @cached_property
    def places(self) -> tuple[int, ...]:
        """(count,) place of every row in the basis."""
        places = {row: place for place, row in enumerate(self.order)} | dict.fromkeys(self.ones, 0)
        return tuple(places[row] for row in range(self.count))

    @cached_property
    def outer(self) -> tuple[int | None, ...]:
        """(nv,) of every joint that turns the row of the rotor that turns its frame; None if none does, and of joints that slide."""
        return tuple(
            self.order[carrier] if sense and (carrier := self.plane.rotor(parent)) else None
            for parent, sense in zip(self.plane.parents, self.plane.sense, strict=True)
        )
