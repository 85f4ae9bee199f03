"""The mesh over the crank angle on which the reduced equation is solved, with all there that does not depend on speed.

Panels of the mesh end where a force is not smooth: at the heights where a load begins and ends, and at dead centres. Each carries Gauss's
nodes; one that starts from rest or ends at rest runs over the square root of the angle, in which time is smooth.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.arrays import Array
from ..common.gauss import gauss_rule
from ..loads.protocol import ForceInterval
from .driven_press import DrivenPress
from .reduced_model import COORDINATES, INERTIA, POTENTIAL, WEIGHT, ReducedModel

Indices = NDArray[np.intp]

SAME = 1e-8  # borders closer than this are one [rad]
STEADY, FROM_REST, TO_REST = 0, 1, -1  # how a panel runs


class PanelForce(NamedTuple):
    """An interval of a force, on the panels on which it acts.

    Attributes:
        row: of the coordinate along which it acts.
        datum: value of the coordinate from which heights count [m].
        interval: its law.
        panels: on which it acts.
    """

    row: int
    datum: float
    interval: ForceInterval
    panels: Indices


@dataclass(frozen=True, eq=False, repr=False)
class Mesh:
    """Panels over the angle travelled from a start, with what does not depend on speed at their q nodes and p + 1 borders.

    Attributes:
        start: crank angle [rad].
        direction: +1 or -1.
        borders: (p + 1,) angle travelled [rad].
        kinds: (p,) `STEADY`, or `FROM_REST` or `TO_REST`: over the square root of the angle.
        measure: (q, p) derivative of the angle travelled by the panel's own x, from -1 to 1.
        angle: (q, p) crank angles [rad].
        inertia: (q, p) I [kg m2].
        slope: (q, p) I' [kg m2].
        weight: (q, p) -V' along the travel [N m].
        lifted: (q, p) potential energy since the start [J].
        lifted_ends: (p + 1,) the same at the borders.
        inertia_ends: (p + 1,) I at the borders.
        position: (coordinates, q, p) coordinates c [m].
        lever: (coordinates, q, p) c' [m].
        position_ends: (coordinates, p + 1) c at the borders.
        lever_ends: (coordinates, p + 1) c' at the borders.
        forces: those that act, panel by panel.
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
    forces: tuple[PanelForce, ...]

    def travelled(self, panel: Indices, x: Array) -> tuple[Array, Array]:
        """Angle travelled at places x (n,), from -1 to 1, of panels (n,), and its derivative by x."""
        return _run(self.borders, self.kinds, panel, x)


def mesh_borders(driven: DrivenPress, start: float, direction: int, extent: float) -> Array:
    """Borders of panels, angle travelled from crank angle ``start`` over ``extent`` [rad]: those of the reduced model, and where a force is
    not smooth."""
    turns = np.arange(2 * np.pi, extent, 2 * np.pi)
    ends = np.sort(np.concatenate([turns, angle_to(driven.model, (driven.model.borders, *driven.switch_angles), start, direction)]))
    ends = ends[(ends > SAME) & (ends < extent - SAME)]
    return np.concatenate([[0.0], ends[np.diff(ends, prepend=0.0) > SAME], [extent]])


def angle_to(model: ReducedModel, places: Sequence[Array], start: float, direction: int) -> Array:
    """Angle to be travelled from crank angle ``start`` to each of the ``places``, crank angles in the model's range [rad]."""
    travelled = (np.concatenate([np.zeros(0), *places]) - start) * direction
    return travelled if model.period is None else travelled - np.floor(travelled / model.period) * model.period


def range_ahead(model: ReducedModel, start: float, direction: int) -> float:
    """Angle over which a model goes on from a crank angle: a period, or what is left to its end [rad]."""
    if model.period is not None:
        return model.period
    return float(model.borders[-1] - start if direction > 0 else start - model.borders[0])


def build_mesh(driven: DrivenPress, start: float, direction: int, borders: Array, rests: tuple[bool, bool] = (False, False)) -> Mesh:
    """The mesh with these borders; ``rests``: whether the crank starts from rest in the first panel, and comes to rest in the last."""
    kinds = _kinds(len(borders) - 1, *rests)
    along, measure = _run(borders, kinds, np.arange(len(kinds)), gauss_rule().nodes[:, None])
    middle = 0.5 * (borders[:-1] + borders[1:])
    angle, nodes = start + direction * along, along.size
    values, slopes = driven.model.at(
        start + direction * np.concatenate([along.ravel(), middle, borders])
    )  # all at once: half as many calls
    at_middle, slopes_middle = (rows[:, nodes : nodes + len(middle)] for rows in (values, slopes))
    at_ends, slopes_ends = (rows[:, nodes + len(middle) :] for rows in (values, slopes))
    at_nodes, slopes_nodes = (rows[:, :nodes].reshape(len(rows), *along.shape) for rows in (values, slopes))
    return Mesh(
        start=start,
        direction=direction,
        borders=borders,
        kinds=kinds,
        measure=measure,
        angle=angle,
        inertia=at_nodes[INERTIA],
        slope=slopes_nodes[INERTIA],
        weight=-direction * at_nodes[WEIGHT],
        lifted=at_nodes[POTENTIAL] - at_ends[POTENTIAL, 0],
        inertia_ends=at_ends[INERTIA],
        lifted_ends=at_ends[POTENTIAL] - at_ends[POTENTIAL, 0],
        position=at_nodes[COORDINATES:],
        lever=slopes_nodes[COORDINATES:],
        position_ends=at_ends[COORDINATES:],
        lever_ends=slopes_ends[COORDINATES:],
        forces=_panel_forces(driven, at_middle[COORDINATES:], slopes_middle[COORDINATES:] * direction > 0),
    )


def _kinds(count: int, from_rest: bool, to_rest: bool) -> Indices:
    kinds = np.full(count, STEADY)
    kinds[0] = FROM_REST if from_rest else STEADY
    kinds[-1] = TO_REST if to_rest else kinds[-1]
    return kinds


def _panel_forces(driven: DrivenPress, position: Array, rising: NDArray[np.bool_]) -> tuple[PanelForce, ...]:
    """The forces that act, by coordinates (coordinates, p) in the middles of the panels, and whether these are rising there."""
    found = []
    for force in driven.forces:
        height = position[force.row] - force.datum
        for up in (True, False):
            for interval in force.intervals(up):
                panels = np.flatnonzero((rising[force.row] == up) & (height > interval.lower) & (height <= interval.upper))
                if len(panels):
                    found.append(PanelForce(force.row, force.datum, interval, panels))
    return tuple(found)


def _run(borders: Array, kinds: Indices, panel: Indices, x: Array) -> tuple[Array, Array]:
    """Angle travelled at places x of panels, and its derivative by x."""
    low, high = borders[panel], borders[panel + 1]
    half, share, kind = 0.5 * (high - low), 0.5 * (1 + x), kinds[panel]
    along, measure = low + 2 * half * share, half + 0.0 * x
    if kind.any():
        along = np.where(kind == FROM_REST, low + 2 * half * share**2, np.where(kind == TO_REST, high - 2 * half * (1 - share) ** 2, along))
        measure = np.where(kind == FROM_REST, 2 * half * share, np.where(kind == TO_REST, 2 * half * (1 - share), measure))
    return along, measure
