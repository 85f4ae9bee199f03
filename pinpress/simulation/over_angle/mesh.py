"""A mesh of panels over the crank angle, with all that does not depend on speed.

Panels end where a force is not smooth: at the heights where a load begins and ends, and at dead centres. Each has Gauss's nodes.
A panel that starts or ends at rest runs over the square root of the angle, in which time is smooth.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.numerics import gauss_rule
from ...common.quantities import Array
from ...loads.process import ForceInterval
from ..bearing_model import BearingStates
from ..driven_press import DrivenPress
from ..reduced_model import COORDINATES, INERTIA, POTENTIAL, WEIGHT, ReducedModel

Indices = NDArray[np.intp]

SAME = 1e-8  # borders closer than this are one [rad]
STEADY, FROM_REST, TO_REST = 0, 1, -1  # kinds of panels: over the angle, or over its square root from a rest or to one


class PanelForce(NamedTuple):
    """An interval of a force, with the panels on which it acts."""

    row: int  # of the coordinate along which it acts
    datum: float  # value of the coordinate from which heights count [m]
    interval: ForceInterval  # with its law
    panels: Indices  # indices of the panels on which it acts


@dataclass(frozen=True, eq=False, repr=False)
class AngleMesh:
    """p panels over the angle travelled from a start, with all that does not depend on speed, at q nodes of each and at p + 1 borders.

    Attributes:
        start: crank angle [rad].
        direction: +1 or -1.
        borders: (p + 1,) angle travelled [rad].
        kinds: (p,) `STEADY`, or over the square root of the angle `FROM_REST` or `TO_REST`.
        measure: (q, p) derivative of the angle travelled by x, which goes from -1 to 1 over a panel.
        angle: (q, p) crank angles [rad].
        inertia: (q, p) I [kg m2].
        slope: (q, p) I' [kg m2].
        weight: (q, p) -V' along the travel [N m].
        lifted: (q, p) potential energy gained since the start [J].
        lifted_ends: (p + 1,) potential energy gained up to the borders [J].
        inertia_ends: (p + 1,) I at the borders [kg m2].
        position: (coordinates, q, p) coordinates c [m].
        lever: (coordinates, q, p) c' [m].
        position_ends: (coordinates, p + 1) c at the borders [m].
        lever_ends: (coordinates, p + 1) c' at the borders [m].
        forces: intervals of forces, each with the panels on which it acts.
        bearings: the bearings with friction at the q p nodes, node by node; None for none.
        periods: of the press over which it goes, 1 where that has no period.
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
    bearings: BearingStates | None
    periods: int = 1

    def travelled(self, panel: Indices, x: Array) -> tuple[Array, Array]:
        """Angle travelled at places x (n,), from -1 to 1 on panels (n,), and its derivative by x."""
        return _travel(self.borders, self.kinds, panel, x)


def mesh_borders(driven: DrivenPress, start: float, direction: int, extent: float) -> Array:
    """Borders of panels as angles travelled from crank angle ``start`` over an ``extent`` [rad]: those of the reduced model, and places at
    which a force is not smooth."""
    turns = np.arange(2 * np.pi, extent, 2 * np.pi)
    ends = np.sort(np.concatenate([turns, angle_to(driven.model, (driven.model.borders, *driven.switch_angles), start, direction)]))
    ends = ends[(ends > SAME) & (ends < extent - SAME)]
    return np.concatenate([[0.0], ends[np.diff(ends, prepend=0.0) > SAME], [extent]])


def angle_to(model: ReducedModel, places: Sequence[Array], start: float, direction: int) -> Array:
    """Angles to be travelled from crank angle ``start`` to each of the ``places``, which are crank angles in the model's range [rad]."""
    travelled = (np.concatenate([np.zeros(0), *places]) - start) * direction
    return travelled if model.period is None else travelled - np.floor(travelled / model.period) * model.period


def range_ahead(model: ReducedModel, start: float, direction: int) -> float:
    """Angle over which a model goes on from a crank angle: a period, or the rest of its range [rad]."""
    if model.period is not None:
        return model.period
    return float(model.borders[-1] - start if direction > 0 else start - model.borders[0])


def build_mesh(
    driven: DrivenPress, start: float, direction: int, borders: Array, rests: tuple[bool, bool] = (False, False), periods: int = 1
) -> AngleMesh:
    """The mesh with these borders.

    Args:
        driven: what is simulated.
        start: crank angle [rad].
        direction: +1 or -1.
        borders: (p + 1,) angle travelled [rad].
        rests: whether the crank starts from rest in the first panel, and comes to rest in the last.
        periods: see `AngleMesh`.
    """
    from_rest, to_rest = rests
    kinds = np.full(len(borders) - 1, STEADY)
    kinds[0] = FROM_REST if from_rest else STEADY
    kinds[-1] = TO_REST if to_rest else kinds[-1]
    along, measure = _travel(borders, kinds, np.arange(len(kinds)), gauss_rule().nodes[:, None])
    middle = 0.5 * (borders[:-1] + borders[1:])
    angle, nodes = start + direction * along, along.size
    # all at once: half as many calls
    values, slopes = driven.model.at(start + direction * np.concatenate([along.ravel(), middle, borders]))
    at_middle, slopes_middle = (rows[:, nodes : nodes + len(middle)] for rows in (values, slopes))
    at_ends, slopes_ends = (rows[:, nodes + len(middle) :] for rows in (values, slopes))
    at_nodes, slopes_nodes = (rows[:, :nodes].reshape(len(rows), *along.shape) for rows in (values, slopes))
    return AngleMesh(
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
        bearings=None if driven.bearing_model is None else driven.bearing_model.states(angle.ravel()),
        periods=periods,
    )


def repeat_mesh(mesh: AngleMesh, periods: int) -> AngleMesh:
    """The mesh of a period of the press, over as many periods one after the other. It has no rests, and no bearings with friction."""
    assert not mesh.kinds.any()
    assert mesh.bearings is None
    period, count = float(mesh.borders[-1]), len(mesh.kinds)
    begun = np.repeat(period * np.arange(periods), count)

    def again(values: Array) -> Array:
        return np.concatenate([values] * periods, axis=-1)

    def at_borders(values: Array) -> Array:
        return np.concatenate([again(values[..., :-1]), values[..., -1:]], axis=-1)

    first = count * np.arange(periods)[:, None]
    return replace(
        mesh,
        borders=np.append(again(mesh.borders[:-1]) + begun, periods * period),
        kinds=np.full(periods * count, STEADY),
        measure=again(mesh.measure),
        angle=again(mesh.angle) + mesh.direction * begun,
        inertia=again(mesh.inertia),
        slope=again(mesh.slope),
        weight=again(mesh.weight),
        lifted=again(mesh.lifted),
        lifted_ends=at_borders(mesh.lifted_ends),
        inertia_ends=at_borders(mesh.inertia_ends),
        position=again(mesh.position),
        lever=again(mesh.lever),
        position_ends=at_borders(mesh.position_ends),
        lever_ends=at_borders(mesh.lever_ends),
        forces=tuple(force._replace(panels=(first + force.panels).ravel()) for force in mesh.forces),
        periods=periods,
    )


def _panel_forces(driven: DrivenPress, position: Array, rising: NDArray[np.bool_]) -> tuple[PanelForce, ...]:
    """The forces that act on each panel.

    Args:
        driven: what is simulated.
        position: (coordinates, p) coordinates in the middles of the panels.
        rising: (coordinates, p) whether they rise there.
    """
    panel_forces = []
    for force in driven.forces:
        height = position[force.row] - force.datum
        for up in (True, False):
            for interval in force.intervals(up):
                panels = np.flatnonzero((rising[force.row] == up) & (height > interval.lower) & (height <= interval.upper))
                if len(panels):
                    panel_forces.append(PanelForce(force.row, force.datum, interval, panels))
    return tuple(panel_forces)


def _travel(borders: Array, kinds: Indices, panel: Indices, x: Array) -> tuple[Array, Array]:
    """See `AngleMesh.travelled`."""
    low, high = borders[panel], borders[panel + 1]
    half, share, kind = 0.5 * (high - low), 0.5 * (1 + x), kinds[panel]
    along, measure = low + 2 * half * share, half + 0.0 * x
    if kind.any():
        along = np.where(kind == FROM_REST, low + 2 * half * share**2, np.where(kind == TO_REST, high - 2 * half * (1 - share) ** 2, along))
        measure = np.where(kind == FROM_REST, 2 * half * share, np.where(kind == TO_REST, 2 * half * (1 - share), measure))
    return along, measure
