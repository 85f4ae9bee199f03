"""Elastic motion: error against run time beside SciPy's integrators and Exudyn, on one work: the springs' ring over half a stroke.

Run `python tests/benchmarks/benchmark_elastic.py`; `--quick` for one repeat. pytest does not collect this file. The work is the release
test: the crank turns at its speed from half a turn before bottom dead centre, from the rigid pose with all springs slack, so that the links
ring under weight and inertia. Errors are those of the bearing forces at the end, by the largest of them, against the collocation at its
least tolerance, to which LSODA and Exudyn converge too. All contestants get the same bodies and springs, SciPy's implicit methods the
Jacobians in closed form. Exudyn is used as its manual shows; it is left out where it is not installed. Times are process CPU, the least of
the repeats, in turn; building the model is not counted.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import pinpress as pp
from pinpress.common.quantities import Array
from pinpress.simulation.driven_press import driven_press
from pinpress.simulation.elastic.assembly import sprung_press
from pinpress.simulation.elastic.equations import ElasticEquations, HeldCrank
from pinpress.simulation.elastic.load_paths import load_path
from pinpress.simulation.elastic.marching import march
from pinpress.simulation.elastic.phases import LoadPhases
from pinpress.simulation.elastic.sprung_press import SprungPress
from pinpress.simulation.elastic.task import Task

CASES = (("jf75g_125_plain", 300.0, 2e9), ("zxn2_3000b", 70.0, 2e9), ("jf75g_125_plain", 300.0, 1e11))
URDF = Path(__file__).resolve().parents[2] / "urdf"


class Release:
    """The release test of a press."""

    def __init__(self, name: str, rpm: float, stiffness: float) -> None:
        press = pp.load(URDF / f"{name}.urdf")
        guides = [joint for joint, axis in zip(press.joints, press.axes, strict=True) if not axis.turns]
        springs = pp.elasticity.Stiffness(dict.fromkeys(press.bearings, stiffness), moments=dict.fromkeys(guides, 0.1 * stiffness))
        self.press, self.speed = press, rpm * pp.RPM
        self.sprung: SprungPress = sprung_press(press, pp.elasticity.Elastic(springs))
        self.start = pp.dead_centres(press).bottom_angle - np.pi
        self.until = np.pi / self.speed
        driven = driven_press(press, pp.drives.PrescribedSpeed(self.speed), None, [], None, None)
        paths = tuple(load_path(press, coordinate) for coordinate in driven.coordinates)
        self.equations = ElasticEquations(self.sprung, driven, paths, HeldCrank(self.start, self.speed), segments=((),))
        self.phases = LoadPhases(driven, 1)
        motion = pp.servo_cycle(press, angle=[self.start], speed=self.speed)
        self.whole = [each[0] for each in self.sprung.rigid_coordinates(motion)]
        self.y0 = self.sprung.free_coordinates(self.whole[0][None])[0, :-1]
        self.v0 = self.sprung.free_rates(self.whole[1][None])[0, :-1]

    def forces(self, y: Array, v: Array) -> Array:
        """Pulls (S,) of the springs at the end."""
        free, rates = self.equations.whole(np.array([self.until]), y[None], v[None])
        at = self.sprung.geometry(self.sprung.all_coordinates(free), rates @ self.sprung.carry.T)
        return np.asarray(self.sprung.lines.stiffness * at.extension[0] + self.sprung.lines.damping * at.opening[0])

    def collocation(self, tolerance: float) -> Array:
        task = Task(self.equations, self.phases, _no_rigid_motion, 2 * self.until, self.speed, np.zeros(2 * len(self.y0)), tolerance)
        found = march(task, self.start, np.concatenate([self.y0, self.v0]), self.until)
        return self.forces(*np.split(found.panels.states[-1], 2))

    def scipy(self, method: str, tolerance: float) -> Array:
        size, inverse, zero = len(self.y0), np.linalg.inv(self.equations.mass), np.zeros(1, dtype=int)

        def rates(t: float, state: Array) -> Array:
            force, *_ = self.equations.forces(np.array([t]), state[None, :size], state[None, size:], zero)
            return np.concatenate([state[size:], inverse @ force[0]])

        def jacobian(t: float, state: Array) -> Array:
            _, stiffness, damping, _ = self.equations.forces(np.array([t]), state[None, :size], state[None, size:], zero)
            top = np.concatenate([np.zeros((size, size)), np.eye(size)], axis=1)
            return np.concatenate([top, -inverse @ np.concatenate([stiffness[0], damping[0]], axis=1)])

        implicit = {} if method == "DOP853" else {"jac": jacobian}
        atol = tolerance * np.concatenate([np.full(size, 1e-4), np.full(size, 1e-2)])
        found = solve_ivp(rates, (0.0, self.until), np.concatenate([self.y0, self.v0]), method, rtol=tolerance, atol=atol, **implicit)
        return self.forces(found.y[:size, -1], found.y[size:, -1])

    def exudyn(self, steps: int = 0, tolerance: float = 0.0) -> tuple[Callable[[], Array], Callable[[], None]]:
        """A run of generalised alpha with so many steps, or of DOPRI5 with a tolerance; it must be built anew for each run."""
        import exudyn
        from exudyn import itemInterface as items  # noqa: N813

        sprung, press = self.sprung, self.press
        container = exudyn.SystemContainer()
        mbs = container.AddSystem()
        ground, bodies, nodes = mbs.AddObject(items.ObjectGround()), [], []
        driver = press.driver_indices[0]
        for j in range(press.model.nv):
            centre, rates = sprung.centers[j], self.whole[1][3 * j : 3 * j + 3]
            place = self.whole[0][3 * j : 3 * j + 3]
            turning = 1e14 if j == driver else sprung.inertia[3 * j + 2]  # a flywheel that nothing slows down holds the crank's speed
            nodes.append(
                mbs.AddNode(
                    items.NodeRigidBody2D(
                        referenceCoordinates=[centre.real, centre.imag, 0.0],
                        initialCoordinates=place.tolist(),
                        initialVelocities=rates.tolist(),
                    )
                )
            )
            bodies.append(mbs.AddObject(items.ObjectRigidBody2D(mass=sprung.inertia[3 * j], inertia=turning, nodeNumber=nodes[j])))
            own = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=bodies[j], localPosition=[0.0, 0.0, 0.0]))
            mbs.AddLoad(items.LoadForceVector(markerNumber=own, loadVector=[*sprung.weight[3 * j : 3 * j + 2].tolist(), 0.0]))

        def marker(body: int, arm: complex) -> Any:
            if body == press.model.nv:
                return mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground, localPosition=[arm.real, arm.imag, 0.0]))
            return mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=bodies[body], localPosition=[arm.real, arm.imag, 0.0]))

        lines, turns = sprung.lines, sprung.turns
        for k in range(len(lines.first)):
            along = lines.direction[k]
            stiff, damp = ([value * abs(along.real), value * abs(along.imag), 0.0] for value in (lines.stiffness[k], lines.damping[k]))
            ends = [marker(int(lines.first[k]), complex(lines.arm1[k])), marker(int(lines.second[k]), complex(lines.arm2[k]))]
            mbs.AddObject(items.ObjectConnectorCartesianSpringDamper(markerNumbers=ends, stiffness=stiff, damping=damp))
        fixed = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0))
        for k in range(len(turns.first)):
            angle = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[int(turns.second[k])], coordinate=2))
            mbs.AddObject(
                items.ObjectConnectorCoordinateSpringDamper(
                    markerNumbers=[fixed, angle], stiffness=float(turns.stiffness[k]), damping=float(turns.damping[k])
                )
            )
        mbs.Assemble()
        settings = exudyn.SimulationSettings()
        settings.timeIntegration.endTime = self.until
        settings.timeIntegration.verboseMode = 0
        settings.solution.file.write = False
        settings.timeIntegration.newton.useModifiedNewton = False
        if steps:
            settings.timeIntegration.numberOfSteps = steps
            settings.timeIntegration.generalizedAlpha.spectralRadius = 1.0
        else:
            settings.timeIntegration.numberOfSteps = 100
            settings.timeIntegration.automaticStepSize = True
            settings.timeIntegration.relativeTolerance, settings.timeIntegration.absoluteTolerance = tolerance, tolerance * 1e-4
        solver = exudyn.DynamicSolverType.GeneralizedAlpha if steps else exudyn.DynamicSolverType.DOPRI5

        def work() -> None:
            mbs.SolveDynamic(settings, solverType=solver)

        def result() -> Array:
            at = mbs.systemData.GetODE2Coordinates(), mbs.systemData.GetODE2Coordinates_t()
            coordinates, rates = (np.concatenate([np.array(each), np.zeros(3)])[None] for each in at)
            geometry = sprung.geometry(coordinates, rates)
            return np.asarray(lines.stiffness * geometry.extension[0] + lines.damping * geometry.opening[0])

        return result, work


def _no_rigid_motion(times: Array) -> tuple[Array, Array, Array]:
    raise NotImplementedError


def contest(name: str, rpm: float, stiffness: float, repeats: int) -> None:
    release = Release(name, rpm, stiffness)
    truth = release.collocation(1e-13)
    size = float(np.abs(truth).max())
    print(f"\n{name}, {rpm:g} strokes/min, springs of {stiffness:.0e} N/m: half a stroke, {len(release.y0)} coordinates")
    entries: list[tuple[str, Callable[[], Array]]] = [
        (f"collocation {t:.0e} m", lambda t=t: release.collocation(t)) for t in (1e-7, 1e-8, 1e-9, 1e-10, 1e-11)
    ]
    for method in ("LSODA", "Radau", "DOP853"):
        entries += [(f"SciPy {method} {t:.0e}", lambda t=t, m=method: release.scipy(m, t)) for t in (1e-5, 1e-7, 1e-9)]
    rows = [(label, *_timed(work, repeats)) for label, work in entries]
    try:
        for label, how in [
            *((f"Exudyn generalised alpha {n} steps", {"steps": n}) for n in (5000, 20000, 80000)),
            *((f"Exudyn DOPRI5 {t:.0e}", {"tolerance": t}) for t in (1e-4, 1e-6, 1e-8)),
        ]:
            best, found = np.inf, truth
            for _ in range(repeats):
                result, work = release.exudyn(**how)
                began = time.process_time()
                work()
                best, found = min(best, time.process_time() - began), result()
            rows.append((label, found, best))
    except ModuleNotFoundError:
        print("  Exudyn is not installed: pip install pinpress[peers]")
    for label, found, seconds in rows:
        print(f"  {label:38s} {seconds:9.4f} s   error {np.abs(found - truth).max() / size:.1e}")


def _timed(work: Callable[[], Array], repeats: int) -> tuple[Array, float]:
    best, found = np.inf, np.zeros(0)
    for _ in range(repeats):
        began = time.process_time()
        found = work()
        best = min(best, time.process_time() - began)
    return found, best


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="one repeat")
    for case in CASES:
        contest(*case, repeats=1 if parser.parse_args().quick else 5)
