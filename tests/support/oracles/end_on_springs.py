"""The last state of a run on springs, as the equations of a solution have it, for integrators of any kind."""

from typing import NamedTuple

import numpy as np

from pinpress.common.quantities import Array
from pinpress.simulation.elastic.press.geometry import BodyState
from pinpress.simulation.elastic.states import ActingForces
from pinpress.simulation.elastic.task import ElasticSolution


class End(NamedTuple):
    """The last state of a run.

    Attributes:
        slide: place of the slide [m].
        force: (bearings, 3) forces as in `Reactions` [N].
        energy_error: error of the energy at the end, as a share of the largest [-]; None where it is not kept.
        evaluations: of the equations of motion, where they are counted.
    """

    slide: float
    force: Array
    energy_error: float | None = None
    evaluations: int | None = None


def end_of(solution: ElasticSolution, state: BodyState, evaluations: int | None = None) -> End:
    """The end where the bodies are so."""
    equations, mesh = solution.equations, solution.panels.mesh
    last = np.array([len(equations.segments) - 1])
    force = ActingForces(equations, mesh.knots[-1:], last, state).in_bearings
    place = equations.paths[0].over(equations.sprung, state).value
    return End(float(place[0]), force[:, 0], evaluations=evaluations)
