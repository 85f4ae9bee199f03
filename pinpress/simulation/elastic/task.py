"""The problem of a press on springs, its solution by collocation on panels of time, and the deflection to which errors are compared.

The press has f coordinates. A segment is the time between two knots, at which a load, a contact or the drive changes its law.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...common.quantities import Array
from .equations import ElasticEquations
from .panels import Indices, Mesh, PanelSolution
from .strokes import Strokes

# Shared by the periodic solution (`period`) and the march in time (`march`).
STAGES = 7  # collocation points of a panel: 5 to 7 cost about the same for the same error, 7 less if the error is small
MOST_STEPS = 16  # of Newton's method
SETTLED = 1e-3  # Newton's method ends when it changes coordinates by less than this share of the tolerance
FIRST_PANELS, FEWEST = 24, 6  # panels of a period at first; least number of panels of a segment
LOOKS = 12  # places of a panel at which events are searched
PAST_TURNING = 1e-6  # beyond a reversal of the rigid press, the angle at which its new direction is read [rad]

RigidMotion = Callable[[Array], tuple[Array, Array, Array]]
"""Times (n,) to coordinates, rates and accelerations (n, f) of the rigid press."""


@dataclass(frozen=True, eq=False)
class ElasticSolution:
    """A motion on its segments.

    Attributes:
        equations: with the forces and events of the segments.
        panels: the motion.
        gain: (2 f,) difference of coordinates and rates after a period, such as 2 pi of the crank; None if the motion is not periodic.
        evaluations: number of states at which forces were computed for the last panels.
    """

    equations: ElasticEquations
    panels: PanelSolution
    gain: Array | None
    evaluations: int

    @property
    def decay(self) -> float:
        """Factor of a disturbance after a period: the largest Floquet multiplier, the spectral radius of the period map [-]. Below 1 the
        motion is stable."""
        passage = self.panels.passage
        for axis in (0, 1):  # works are integrals of the motion, on which it does not depend
            passage = np.delete(passage, self.equations.integrals, axis)
        return float(np.abs(np.linalg.eigvals(passage)).max())


class Task(NamedTuple):
    """The problem.

    Attributes:
        equations: of the press, still without segments.
        strokes: when each load acts, by the places that its path reaches.
        rigid: the motion of the rigid press at the same speed, or under the same drive.
        period: of the rigid press [s].
        speed: of the crank, its mean over a period [rad/s].
        gain: (2 f,) difference of coordinates and rates after a period.
        tolerance: error of a coordinate [m or rad].
        begins: ratio of the crank's speed at the start to ``speed`` [-].
    """

    equations: ElasticEquations
    strokes: Strokes
    rigid: RigidMotion
    period: float
    speed: float
    gain: Array
    tolerance: float
    begins: float = 1.0

    def times(self, travelled: Array) -> Array:
        """Times (n,) at which the crank of the rigid press has turned through angles (n,) [s]."""
        if self.equations.crank is not None:  # its speed is prescribed
            return travelled / abs(self.speed)
        times = np.linspace(0.0, self.period, 241)  # close enough for a first guess
        crank_angle = self.rigid(times)[0][:, -1]
        return np.interp(travelled, np.abs(crank_angle - crank_angle[0]), times)


def largest_deflection(task: Task, start: float) -> float:
    """Largest quasi-static deflection of a coordinate in a period of the rigid press from crank angle ``start`` on [m or rad].

    The unbalanced forces of the rigid motion, divided by the stiffness of the unloaded springs. Pins with clearance count as closed, since
    a journal that flies has no stiffness. Errors are compared to this deflection.
    """
    plan, sprung = task.strokes.plan(start), task.equations.sprung
    samples = 16  # of each segment
    share = (np.arange(samples) + 1) / samples
    times = task.times((plan.knots[:-1, None] + np.diff(plan.knots)[:, None] * share).ravel())  # the knots are angles
    y, v, a = task.rigid(times)
    contacts = (None,) * len(task.equations.contacts)  # the last forces of each segment
    closed = tuple(segment[: len(segment) - len(contacts)] + contacts for segment in plan.segments)
    unloaded = tuple((None,) * len(segment) for segment in plan.segments)
    equations = replace(task.equations, segments=closed, sprung=sprung if sprung.closed is None else sprung.closed)
    segments = np.repeat(np.arange(len(closed)), samples)
    springs = replace(equations, segments=unloaded)
    stiffness = springs.body_forces(times, segments, springs.state(times, y, v)).stiffness[:, : equations.size, : equations.size]
    unbalanced = equations.linearised(times, y, v, a, segments).left
    return float(np.abs(np.linalg.solve(stiffness, unbalanced[..., None])).max())


def even_mesh(knots: Array, counts: Indices) -> Mesh:
    """Numbers of panels of equal length in each segment."""
    low = np.concatenate([np.arange(count) / count for count in counts])
    high = np.concatenate([np.arange(1, count + 1) / count for count in counts])
    return Mesh(knots, np.repeat(np.arange(len(counts)), counts), low, high)
