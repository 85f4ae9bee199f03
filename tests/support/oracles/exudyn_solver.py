"""A run of a system in Exudyn, with its errors as ours."""

from typing import Any

import exudyn
import numpy as np

from pinpress.common.errors import SimulationError


def solve(mbs: Any, made: Any, solver: Any = exudyn.DynamicSolverType.TrapezoidalIndex2) -> None:
    """Run a system.

    Raises:
        SimulationError: Exudyn finds no solution.
    """
    loud = exudyn.config.printToConsole
    exudyn.config.printToConsole = False  # it would print what the error says here
    try:
        done = mbs.SolveDynamic(made, solverType=solver, showHints=False)
    except exudyn.ExudynError as error:
        raise SimulationError(f"Exudyn finds no solution: {' '.join(str(error).split())}") from None
    finally:
        exudyn.config.printToConsole = loud
    if not done or not np.isfinite(mbs.systemData.GetODE2Coordinates()).all():
        raise SimulationError("Exudyn finds no solution: give a shorter step")
