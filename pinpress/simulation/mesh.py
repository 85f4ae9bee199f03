"""Panels over the crank angle: where the reduced equation is solved, with all there that does not depend on speed.

Panels end where a force is not smooth: at the heights where a load begins and ends, and at dead centres. Each carries Gauss's nodes; one
that starts from rest or ends at rest runs over the square root of the angle, in which time is smooth.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.arrays import Array
from ..loads.process import Stretch
from .driven_press import DrivenPress
from .reduced_model import COORDINATES, INERTIA, POTENTIAL, WEIGHT, Table, rule

Indices = NDArray[np.intp]

SAME = 1e-8  # borders closer than this are one [rad]
STEADY, FROM_REST, TO_REST = 0, 1, -1  # how a panel runs


class Push(NamedTuple):
    """A stretch of a force, on some of the panels."""

    row: int
    datum: float
    stretch: Stretch
    panels: Indices


@dataclass(frozen=True, eq=False, repr=False)
class Grid:
    """Panels over the angle travelled from a start, with what does not depend on speed at their nodes (q, p).

    Attributes:
        start: crank angle [rad]. direction: +1 or -1.
        borders: (p + 1,) angle travelled [rad]. kinds: (p,) `STEADY`, or `FROM_REST` or `TO_REST`: over the square root of the angle.
        measure: (q, p) derivative of the angle travelled by the panel's own x, from -1 to 1.
        angle: (q, p) crank angles. inertia, slope: I and I' [kg m2]. weight: -V' along the travel [N m].
        lifted: (q, p), lifted_ends: (p + 1,) potential energy since the start, at the nodes and borders [J].
        inertia_ends: (p + 1,) I at the borders. position_ends, lever_ends: (coordinates, p + 1) there.
        position, lever: (coordinates, q, p) coordinates c [m] and c' [m].
        pushes: the forces that act.
    """

    start: float
    direction: int
    borders: Array
    kinds: Indices
    measure: Array
    angle: Array
    inertia: Array
    slope: Array
    weight: Array
    lifted: Array
    lifted_ends: Array
    inertia_ends: Array
    position: Array
    lever: Array
    position_ends: Array
    lever_ends: Array
    pushes: tuple[Push, ...]


def on_the_way(table: Table, edges: Sequence[Array], start: float, direction: int) -> Array:
    """Angle to be travelled from crank angle ``start`` to each of the ``edges``, crank angles in the table's range."""
    travelled = (np.concatenate([np.zeros(0), *edges]) - start) * direction
    return travelled if table.period is None else travelled - np.floor(travelled / table.period) * table.period


def extent(table: Table, start: float, direction: int) -> float:
    """Angle over which a table goes on from a crank angle: a period, or what is left to its end [rad]."""
    if table.period is not None:
        return table.period
    return float(table.borders[-1] - start if direction > 0 else start - table.borders[0])


def borders(table: Table, edges: Sequence[Array], start: float, direction: int, extent: float) -> Array:
    """Borders of panels, angle travelled from crank angle ``start`` over ``extent`` [rad].

    Args:
        edges: crank angles in the table's range at which something is not smooth.
    """
    turns = np.arange(2 * np.pi, extent, 2 * np.pi)
    ends = np.sort(np.concatenate([turns, on_the_way(table, (table.borders, *edges), start, direction)]))
    ends = ends[(ends > SAME) & (ends < extent - SAME)]
    return np.concatenate([[0.0], ends[np.diff(ends, prepend=0.0) > SAME], [extent]])


def grid(driven: DrivenPress, table: Table, start: float, direction: int, ends: Array, rests: tuple[bool, bool] = (False, False)) -> Grid:
    """The grid with these borders; ``rests``: whether the crank starts from rest in the first panel, and comes to rest in the last."""
    r = rule()
    kinds = np.zeros(len(ends) - 1, dtype=int)
    kinds[0] = FROM_REST if rests[0] else STEADY
    kinds[-1] = TO_REST if rests[1] else kinds[-1]
    along, measure = _run(ends, kinds, np.arange(len(kinds)), r.nodes[:, None])
    middle = 0.5 * (ends[:-1] + ends[1:])
    angle = start + direction * along
    values, slopes = table.at(start + direction * np.concatenate([along.ravel(), middle, ends]))  # all at once: half as many calls
    rows, count = len(values), along.size
    at_middle, at_ends = values[:, count : count + len(middle)], values[:, count + len(middle) :]
    values, by = values[:, :count].reshape(rows, *along.shape), slopes[:, count : count + len(middle)]
    slopes_ends = slopes[:, count + len(middle) :]
    slopes = slopes[:, :count].reshape(rows, *along.shape)
    pushes = []
    for force in driven.forces:
        height, rising = at_middle[COORDINATES + force.row] - force.datum, by[COORDINATES + force.row] * direction > 0
        for up in (True, False):
            for stretch in force.stretches(up):
                panels = np.flatnonzero((rising == up) & (height > stretch.lower) & (height <= stretch.upper))
                if len(panels):
                    pushes.append(Push(force.row, force.datum, stretch, panels))
    return Grid(
        start=start,
        direction=direction,
        borders=ends,
        kinds=kinds,
        measure=measure,
        angle=angle,
        inertia=values[INERTIA],
        slope=slopes[INERTIA],
        weight=-direction * values[WEIGHT],
        lifted=values[POTENTIAL] - at_ends[POTENTIAL, 0],
        inertia_ends=at_ends[INERTIA],
        lifted_ends=at_ends[POTENTIAL] - at_ends[POTENTIAL, 0],
        position=values[COORDINATES:],
        lever=slopes[COORDINATES:],
        position_ends=at_ends[COORDINATES:],
        lever_ends=slopes_ends[COORDINATES:],
        pushes=tuple(pushes),
    )


def travelled(grid: Grid, panel: Indices, x: Array) -> tuple[Array, Array]:
    """Angle travelled at places x (n,), from -1 to 1, of panels (n,), and its derivative by x."""
    return _run(grid.borders, grid.kinds, panel, x)


def _run(ends: Array, kinds: Indices, panel: Indices, x: Array) -> tuple[Array, Array]:
    low, high = ends[panel], ends[panel + 1]
    half, share, kind = 0.5 * (high - low), 0.5 * (1 + x), kinds[panel]
    along, measure = low + 2 * half * share, half + 0.0 * x
    if kind.any():
        along = np.where(kind == FROM_REST, low + 2 * half * share**2, np.where(kind == TO_REST, high - 2 * half * (1 - share) ** 2, along))
        measure = np.where(kind == FROM_REST, 2 * half * share, np.where(kind == TO_REST, 2 * half * (1 - share), measure))
    return along, measure
