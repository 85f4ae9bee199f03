"""What is to be found of a press on springs, and what was found; how far its springs yield at most."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...common.quantities import Array
from .equations import ElasticEquations
from .panels import Indices, Mesh, PanelSolution
from .strokes import Strokes

STAGES = 7  # collocation points of a panel: five to seven cost the same for the same error, seven less where it is small
MOST_STEPS = 16  # of Newton's method
SETTLED = 1e-3  # Newton's method ends where it changes coordinates by less than this share of the tolerance
FIRST_PANELS, FEWEST = 24, 6  # panels of a period at first, and of each segment
LOOKS = 12  # places on a panel at which events are looked for
PAST_TURNING = 1e-6  # angle past a turning at which it is seen which way the rigid press goes [rad]

RigidMotion = Callable[[Array], tuple[Array, Array, Array]]
"""Times (n,) to coordinates, rates and accelerations (n, f) of the rigid press."""


@dataclass(frozen=True, eq=False)
class ElasticSolution:
    """A motion on its segments.

    Attributes:
        equations: with the forces and events of the segments.
        panels: the motion.
        gain: (2 f,) what coordinates and rates gain in its period; None: it is no period.
        evaluations: of the forces at one state, that the last panels took.
    """

    equations: ElasticEquations
    panels: PanelSolution
    gain: Array | None
    evaluations: int

    @property
    def decay(self) -> float:
        """Factor by which a disturbance shrinks in a period: the largest size of an eigenvalue of its passage [-]."""
        passage = self.panels.passage
        for axis in (0, 1):
            passage = np.delete(passage, self.equations.integrals, axis)
        return float(np.abs(np.linalg.eigvals(passage)).max())


class Task(NamedTuple):
    """What is to be found.

    Attributes:
        equations: of the press; their segments are not yet known.
        strokes: of its loads.
        rigid: the motion of the rigid press at the same speed, or under the same drive.
        period: of the rigid press [s].
        speed: of the crank, its mean over a period [rad/s].
        gain: (2 f,) what coordinates and rates have gained after a period.
        tolerance: error of a coordinate [m or rad].
        begins: speed of the crank at the start by ``speed``.
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
        if self.equations.crank is not None:
            return travelled / abs(self.speed)
        times = np.linspace(0.0, self.period, 241)  # of a guess: interpolated between them
        angle = self.rigid(times)[0][:, -1]
        return np.interp(travelled, np.abs(angle - angle[0]), times)


def largest_deflection(task: Task, start: float) -> float:
    """Largest displacement of a coordinate by what acts in a period of the rigid press, on springs that follow at once [m or rad].

    It is that to which errors are compared.
    """
    plan, sprung = task.strokes.plan(start), task.equations.sprung
    samples = 16  # places of a segment at which the largest deflection is looked for
    share = (np.arange(samples) + 1) / samples
    times = (plan.knots[:-1, None] + np.diff(plan.knots)[:, None] * share).ravel() * (task.period / plan.knots[-1])
    y, v, a = task.rigid(times)
    contacts = (None,) * len(task.equations.contacts)
    plan = plan._replace(segments=tuple(segment[: len(segment) - len(contacts)] + contacts for segment in plan.segments))
    equations = replace(task.equations, segments=plan.segments, sprung=sprung.closed or sprung)
    segments = np.repeat(np.arange(len(plan.segments)), samples)
    bare = replace(equations, segments=tuple((None,) * len(segment) for segment in plan.segments))
    size, stiffness = equations.size, bare.body_forces(times, segments, bare.state(times, y, v)).stiffness
    left = equations.linearised(times, y, v, a, segments).left
    return float(np.abs(np.linalg.solve(stiffness[:, :size, :size], left[..., None])).max())


def even_mesh(knots: Array, counts: Indices) -> Mesh:
    """Panels of equal length in each segment."""
    low = np.concatenate([np.arange(count) / count for count in counts])
    high = np.concatenate([np.arange(1, count + 1) / count for count in counts])
    return Mesh(knots, np.repeat(np.arange(len(counts)), counts), low, high)
