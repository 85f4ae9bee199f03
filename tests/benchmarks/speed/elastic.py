"""Elastic motion: error against run time beside SciPy's integrators and Exudyn, on one work: the springs' ring over half a stroke.

Run `python tests/benchmarks/speed/elastic.py`; `--quick` for one repeat. pytest does not collect this file. The work is the release
test: the crank turns at its speed from half a turn before bottom dead centre, from the rigid pose with all springs slack, so that the links
ring under weight and inertia. Errors are those of the bearing forces at the end, by the largest of them, against the collocation at its
least tolerance, to which LSODA and Exudyn converge too. All contestants get the same bodies and springs, SciPy's implicit methods the
Jacobians in closed form. Exudyn is used as its manual shows; it is left out where it is not installed. Times are process CPU, the least of
the repeats, in turn. The same contestants at work, with a blank, are in `benchmarks/accuracy`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks import stopwatch
from benchmarks.accuracy.on_springs import SciPy
from support.oracles.end_on_springs import end_of

import pinpress as pp
from pinpress.common.quantities import Array
from pinpress.simulation.driven_press import driven_press
from pinpress.simulation.elastic.equations import ElasticEquations, HeldCrank
from pinpress.simulation.elastic.march import march
from pinpress.simulation.elastic.press.assembly import sprung_press
from pinpress.simulation.elastic.press.paths import load_path
from pinpress.simulation.elastic.strokes import Strokes
from pinpress.simulation.elastic.task import ElasticSolution, Task

CASES = (("jf75g_125_plain", 300.0, 2e9), ("zxn2_3000b", 70.0, 2e9), ("jf75g_125_plain", 300.0, 1e11))
URDF = Path(__file__).resolve().parents[3] / "urdf"


class Release:
    """The release test of a press."""

    def __init__(self, name: str, rpm: float, stiffness: float) -> None:
        press = pp.load(URDF / f"{name}.urdf")
        guides = [joint for joint, axis in zip(press.joints, press.axes, strict=True) if not axis.turns]
        springs = pp.elasticity.Stiffness(dict.fromkeys(press.bearings, stiffness), moments=dict.fromkeys(guides, 0.1 * stiffness))
        self.speed = rpm * pp.RPM
        sprung = sprung_press(press, pp.elasticity.Elastic(springs))
        self.start = pp.dead_centres(press).bottom_angle - np.pi
        self.until = np.pi / self.speed
        driven = driven_press(press, pp.drives.PrescribedSpeed(self.speed), None, [], None, None)
        paths = tuple(load_path(sprung, coordinate) for coordinate in driven.coordinates)
        self.equations = ElasticEquations(sprung, driven, paths, HeldCrank(self.start, self.speed), segments=((),))
        self.strokes = Strokes(driven, 1)
        motion = pp.servo_cycle(press, angle=[self.start], speed=self.speed)
        place, rates = (each[0][None] for each in sprung.geometry.rigid(motion)[:2])
        self.state = np.concatenate([sprung.free_coordinates(place)[0, :-1], sprung.free_rates(rates)[0, :-1]])

    def solution(self, tolerance: float) -> ElasticSolution:
        task = Task(self.equations, self.strokes, _no_rigid_motion, 2 * self.until, self.speed, np.zeros(len(self.state)), tolerance)
        return march(task, self.start, self.state, self.until)

    def collocation(self, tolerance: float) -> Array:
        found = self.solution(tolerance)
        return end_of(found, found.equations.state(np.array([self.until]), *np.split(found.panels.states[-1:], 2, axis=1))).force


def _no_rigid_motion(times: Array) -> tuple[Array, Array, Array]:
    raise NotImplementedError


def contest(name: str, rpm: float, stiffness: float, repeats: int) -> None:
    release = Release(name, rpm, stiffness)
    finest = release.solution(1e-13)
    truth, scipy = release.collocation(1e-13), SciPy(finest)
    size = float(np.abs(truth).max())
    print(f"\n{name}, {rpm:g} strokes/min, springs of {stiffness:.0e} N/m: half a stroke, {len(release.state) // 2} coordinates")
    entries: list[tuple[str, Callable[[], Array]]] = [
        (f"collocation {t:.0e} m", lambda t=t: release.collocation(t)) for t in (1e-7, 1e-8, 1e-9, 1e-10, 1e-11)
    ]
    for method in ("LSODA", "Radau", "DOP853"):
        entries += [(f"SciPy {method} {t:.0e}", lambda t=t, m=method: scipy.run(m, t).force) for t in (1e-5, 1e-7, 1e-9)]
    try:
        from support.oracles.exudyn_on_springs import ExudynOnSprings, Setting

        peer = ExudynOnSprings(finest, release.until)
        implicit = [Setting("generalised alpha", steps=steps) for steps in (5000, 20000, 80000)]
        explicit = [Setting("DOPRI5", tolerance=tolerance) for tolerance in (1e-4, 1e-6, 1e-8)]
        entries += [
            (f"Exudyn {how.solver} {how.words}", lambda how=how: end_of(finest, peer.run(how)).force) for how in (*implicit, *explicit)
        ]
    except ModuleNotFoundError:
        print("  Exudyn is not installed: pip install pinpress[peers]")
    for label, work in entries:
        found, (seconds,) = work(), stopwatch.least([work], repeats)
        print(f"  {label:42s} {seconds:9.4f} s   error {np.abs(found - truth).max() / size:.1e}")


QUICK = {"CASES": CASES[:1]}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    repeats = 1 if quick else 5
    for case in CASES:
        contest(*case, repeats=repeats)


if __name__ == "__main__":
    main()
