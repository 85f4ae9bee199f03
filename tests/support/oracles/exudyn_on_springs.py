"""A planar press on springs in Exudyn: rigid bodies of the plane, Cartesian spring-dampers in the bearings, and the blank as a connector.

Nothing is an equation with a multiplier here, so that the explicit integrators serve too: DOPRI5 with steps by its error, beside
generalised alpha with fixed steps and full Newton steps. A crank whose moment of inertia nothing slows down holds the speed. Whether the
blank is cut through is kept from step to step; no step ends where the blank is touched or breaks.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import exudyn
import numpy as np
from exudyn import itemInterface as items  # noqa: N813
from support.oracles.exudyn_solver import solve

from pinpress.common.errors import PinpressError
from pinpress.loads.process import Blanking
from pinpress.simulation.elastic.press.paths import PointPath
from pinpress.simulation.elastic.press.plane import PlaneGeometry, PlaneState
from pinpress.simulation.elastic.task import ElasticSolution

NAME = f"Exudyn {exudyn.config.Version()}"
HELD = 1e14  # moment of inertia of a crank that nothing slows down [kg m2]
FIRST = 100  # steps, of which the first one of an explicit run has the length


class Setting(NamedTuple):
    """How Exudyn is to run.

    Attributes:
        solver: in words.
        steps: of generalised alpha; 0: DOPRI5.
        tolerance: of DOPRI5.
    """

    solver: str
    steps: int = 0
    tolerance: float = 0.0

    @property
    def words(self) -> str:
        return f"{self.steps} steps" if self.steps else f"tolerance {self.tolerance:.0e}"

    @property
    def number(self) -> float:
        return float(self.steps) or self.tolerance


SETTINGS = (
    *(Setting("generalised alpha", steps=steps) for steps in (2000, 8000, 32000)),
    *(Setting("DOPRI5", tolerance=tolerance) for tolerance in (1e-4, 1e-6, 1e-8)),
)


@dataclass(frozen=True, eq=False)
class ExudynOnSprings:
    """The bodies, springs and load of an elastic run, from its first state.

    Attributes:
        solution: the run that says what the bodies and springs are, and how they start.
        until: time of the end [s].
        blank: the load; None: the press runs idle.
    """

    solution: ElasticSolution
    until: float
    blank: Blanking | None = None

    def __post_init__(self) -> None:
        sprung, path = self.solution.equations.sprung, self.solution.equations.paths[:1]
        press = sprung.press
        geometry = sprung.geometry
        if not isinstance(geometry, PlaneGeometry):
            raise PinpressError(f"{press.name} moves in space, and only planar presses on springs are compared in it")
        if press.couplings or geometry.crown is not None or geometry.rotor is not None or sprung.open_pins:
            raise PinpressError(f"{press.name} has gear pairs, a crown, a shaft or clearance, which are not compared in it")
        if press.model.parents[press.driver_indices[0] + 1] != 0:
            raise PinpressError(f"it is compared with cranks on the frame, and that of {press.name} is not")
        if self.blank is not None and not (isinstance(path[0], PointPath) and np.abs(path[0].direction - (0.0, 1.0)).max() < 1e-9):
            raise PinpressError(f"it is compared with slides on upright guides, and that of {press.name} is not")

    def run(self, how: Setting) -> PlaneState:
        """All bodies at the end.

        Raises:
            SimulationError: Exudyn finds no solution.
        """
        mbs = self.built()
        solve(mbs, self._settings(how), exudyn.DynamicSolverType.GeneralizedAlpha if how.steps else exudyn.DynamicSolverType.DOPRI5)
        at = mbs.systemData.GetODE2Coordinates(), mbs.systemData.GetODE2Coordinates_t()
        coordinates, rates = (np.concatenate([np.array(each), np.zeros(3)])[None] for each in at)
        return self._geometry.state(coordinates, rates)

    def _settings(self, how: Setting) -> Any:
        made = exudyn.SimulationSettings()
        made.solution.file.write = False
        made.solution.solverInformationFileName = ""
        run = made.timeIntegration
        run.endTime, run.verboseMode, run.verboseModeFile = self.until, 0, 0
        run.newton.useModifiedNewton = False
        run.numberOfSteps, run.automaticStepSize = how.steps or FIRST, not how.steps
        if how.steps:
            run.adaptiveStep = False
            run.generalizedAlpha.spectralRadius = 1.0
        else:
            run.relativeTolerance, run.absoluteTolerance = how.tolerance, 1e-4 * how.tolerance
        return made

    def built(self) -> Any:
        """The system of bodies, assembled, in its first state."""
        equations, panels = self.solution.equations, self.solution.panels
        geometry = self._geometry
        state = equations.state(panels.mesh.knots[:1], *np.split(panels.states[:1], 2, axis=1))
        places, speeds = state.coordinates[0].reshape(-1, 3), state.rates[0].reshape(-1, 3)
        mbs = exudyn.SystemContainer().AddSystem()
        frame, driver, bodies, nodes = geometry.press.model.nv, geometry.press.driver_indices[0], [], []
        for j in range(frame):
            mass, _, about = geometry.inertia[3 * j : 3 * j + 3].tolist()
            centre = [geometry.centers[j].real, geometry.centers[j].imag, 0.0]
            start = {"initialCoordinates": places[j].tolist(), "initialVelocities": speeds[j].tolist()}
            nodes.append(mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=centre, **start)))
            turning = HELD if j == driver else about
            bodies.append(mbs.AddObject(items.ObjectRigidBody2D(mass=mass, inertia=turning, nodeNumber=nodes[j])))
            own = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=bodies[j], localPosition=[0.0, 0.0, 0.0]))
            mbs.AddLoad(items.LoadForceVector(markerNumber=own, loadVector=[*geometry.weight[3 * j : 3 * j + 2].tolist(), 0.0]))
        bodies.append(mbs.AddObject(items.ObjectGround()))
        self._add_springs(mbs, bodies, nodes)
        if self.blank is not None:
            self._add_blank(mbs, bodies)
        mbs.Assemble()
        return mbs

    @property
    def _geometry(self) -> PlaneGeometry:
        geometry = self.solution.equations.sprung.geometry
        assert isinstance(geometry, PlaneGeometry)
        return geometry

    def _add_springs(self, mbs: Any, bodies: list[Any], nodes: list[Any]) -> None:
        lines, springs, turns = self._geometry.lines, self.solution.equations.sprung.springs, self.solution.equations.sprung.linear
        for k in range(len(lines.first)):
            along = lines.direction[k]
            stiff, damp = ([value * abs(along.real), value * abs(along.imag), 0.0] for value in (springs.stiffness[k], springs.damping[k]))
            ends = [_marker(mbs, bodies[lines.first[k]], lines.arm1[k]), _marker(mbs, bodies[lines.second[k]], lines.arm2[k])]
            mbs.AddObject(items.ObjectConnectorCartesianSpringDamper(markerNumbers=ends, stiffness=stiff, damping=damp))
        still = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0))
        for k, row in enumerate(turns.rows):
            angle = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[int(row.argmax()) // 3], coordinate=2))
            law = {"stiffness": float(turns.stiffness[k]), "damping": float(turns.damping[k])}
            mbs.AddObject(items.ObjectConnectorCoordinateSpringDamper(markerNumbers=[still, angle], **law))

    def _add_blank(self, mbs: Any, bodies: list[Any]) -> None:
        """The blank as a connector between frame and slide, whose force is the blank's until it is cut through."""
        assert self.blank is not None
        equations, through = self.solution.equations, False
        (interval,), path = self.blank.intervals(downwards=True), equations.paths[0]
        assert isinstance(path, PointPath)
        drawn = self._geometry.centers[path.body] + path.arm
        slide = _marker(mbs, bodies[path.body], path.arm)
        zero = path.offset + drawn.imag - equations.all_forces[0].datum

        def push(mbs: Any, t: float, item: int, apart: Any, opening: Any, *more: Any) -> list[float]:
            height = zero + apart[1]
            pushes = interval.lower < height <= interval.upper and not through
            return [0.0, -float(interval.force(height, opening[1])) if pushes else 0.0, 0.0]

        def step(mbs: Any, t: float) -> bool:
            nonlocal through
            at = mbs.GetMarkerOutput(slide, exudyn.OutputVariableType.Position)
            through = through or float(at[1]) - drawn.imag + zero <= interval.lower
            return True

        ground = _marker(mbs, bodies[-1], drawn)
        mbs.AddObject(items.ObjectConnectorCartesianSpringDamper(markerNumbers=[ground, slide], springForceUserFunction=push))
        mbs.SetPreStepUserFunction(step)


def _marker(mbs: Any, body: Any, arm: complex) -> Any:
    return mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[float(arm.real), float(arm.imag), 0.0]))
