"""The contest of a press on springs: half a stroke in which it cuts a blank, down to bottom dead centre, where it still rings.

The crank turns at its speed, all bearings and guides yield, and at top dead centre the springs carry the rigid motion's forces. The same
equations go to SciPy's integrators, with the order in which the blank is touched and cut, so that they end a step where it happens; the
same bodies and springs go to Exudyn. The stroke that the press repeats is found directly besides, and judged by its own reference: the
others would have to follow stroke after stroke until vibrations of the first one have died out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, ClassVar, NamedTuple

import numpy as np
from support.oracles.end_on_springs import End, end_of

from pinpress.accuracy.scenes import build_blank
from pinpress.accuracy.work_precision import Contest, Contestant, Errors, Group
from pinpress.common.errors import PinpressError, SimulationError
from pinpress.common.quantities import Array
from pinpress.drives.transmission import PrescribedSpeed
from pinpress.kinematics.slide_path import dead_centres
from pinpress.linkage.linkage import Linkage
from pinpress.loads.process import Blanking, ForceInterval
from pinpress.simulation.elastic.description import Elastic, Stiffness
from pinpress.simulation.elastic.press.assembly import sprung_press
from pinpress.simulation.elastic.run import ElasticRun, ElasticSegment
from pinpress.simulation.elastic.strokes import CRANK_ANGLE, Event
from pinpress.simulation.elastic.task import ElasticSolution
from pinpress.simulation.simulate import simulate
from pinpress.simulation.steady_state import steady_state

SPRINGS = "blanking on springs"

STIFFNESS = 1e9  # of the springs with which the lowest vibration is found at first [N/m]
VIBRATIONS = 60.0  # frequency of the lowest vibration at bottom dead centre, divided by that of the crank
DAMPING = 0.02  # damping ratio of the lowest vibration
POINTS = 181  # states of the reference in which the largest displacement is looked for
FINEST, FINEST_STROKE = 1e-9, 1e-8  # tolerances of the references; rounding ends Newton's method of a whole stroke first
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)  # of ours, beside the largest displacement
INTEGRATORS = {"LSODA": (1e-5, 1e-7, 1e-9), "Radau": (1e-4, 1e-6, 1e-8), "DOP853": (1e-3, 1e-6)}  # tolerances worth measuring
CERTIFYING = "LSODA", 1e-11  # integrator of SciPy and its tolerance that must agree with the reference
LENGTH, RATE = 1e-4, 1e-2  # what absolute tolerances of SciPy are multiples of [m or rad], [m/s or rad/s]


@dataclass(frozen=True, eq=False)
class SpringsScene:
    """Half a stroke of a press on springs.

    Attributes:
        press: the press.
        elastic: its springs.
        speed: of the crank [rad/s].
        angle: of the crank at the start, at top dead centre [rad].
        bottom: of the crank at bottom dead centre [rad].
        duration: from one to the other [s].
        load: the blank.
        words: the scene in words.
    """

    group: ClassVar[str] = SPRINGS
    press: Linkage
    elastic: Elastic
    speed: float
    angle: float
    bottom: float
    duration: float
    load: Blanking
    words: str

    @cached_property
    def driven(self) -> Mapping[str, Any]:
        """What both kinds of runs take."""
        return {"drive": PrescribedSpeed(self.speed), "loads": [self.load], "elastic": self.elastic}

    def run(self, tolerance: float, points: int = 2) -> ElasticRun:
        """The run of the scene."""
        run = simulate(self.press, self.duration, angle=self.angle, points=points, tolerance=tolerance, **self.driven)
        assert isinstance(run, ElasticRun)
        return run

    def stroke(self, tolerance: float) -> ElasticRun:
        """The stroke that the press repeats, from bottom dead centre to bottom dead centre."""
        run = steady_state(self.press, self.speed, angle=self.bottom, points=2, tolerance=tolerance, **self.driven)
        assert isinstance(run, ElasticRun)
        return run


class Judge(NamedTuple):
    """The end of the reference, by which others are judged. No error counts as less than the difference of its two methods.

    Attributes:
        end: of the reference.
        size: largest displacement of a link [m].
        peak: largest force of any bearing in the run [N].
        certificates: differences of the two methods, of the slide's place by ``size`` and of the forces by ``peak``.
    """

    end: End
    size: float
    peak: float
    certificates: tuple[float, float] = (0.0, 0.0)

    def errors(self, end: End) -> Errors:
        """Errors of another end."""
        slide = abs(end.slide - self.end.slide) / self.size
        force = float(np.linalg.norm(end.force - self.end.force, axis=1).max()) / self.peak
        return Errors(
            max(slide, self.certificates[0]),
            max(force, self.certificates[1]),
            energy_error=end.energy_error,
            evaluations=end.evaluations,
        )


def build_springs_scene(press: Linkage, speed: float, flywheel: float) -> SpringsScene:
    """The scene of a press, with springs and a blank that belong to its size, speed and flywheel.

    Raises:
        PinpressError: the press is none that can stand on springs, or has no slide with dead centres.
    """
    press.plane_or_refuse(f"{press.name} is not planar")
    found = dead_centres(press)
    load = build_blank(press, speed, flywheel)
    lowest = sprung_press(press, _on_springs(press, STIFFNESS)).lowest_frequency
    stiffness = float(f"{STIFFNESS * (VIBRATIONS * speed / lowest) ** 2:.1e}")
    duration = float(np.sign(speed) * (found.bottom_angle - found.top_angle) % (2 * np.pi)) / abs(speed)
    words = (
        f"all bearings on springs of {stiffness:.1e} N/m with a damping ratio of {DAMPING:g}, from top to bottom dead centre; it blanks"
        f" with {load.force / 1e3:.3g} kN from {1e3 * load.start:.3g} to {1e3 * load.end:.3g} mm"
    )
    angle, bottom = float(found.top_angle), float(found.bottom_angle)
    return SpringsScene(press, _on_springs(press, stiffness), speed, angle, bottom, duration, load, words)


def _on_springs(press: Linkage, stiffness: float) -> Elastic:
    """Springs of one stiffness in all bearings; guides against turning as by two such springs one size of the linkage apart."""
    guides = [joint for joint, axis in zip(press.joints, press.axes, strict=True) if not axis.turns]
    turning = dict.fromkeys(guides, 0.5 * stiffness * press.size**2)
    return Elastic(Stiffness(dict.fromkeys(press.bearings, stiffness), moments=turning), damping_ratio=DAMPING)


def springs_contest(scene: SpringsScene) -> tuple[Contest, list[str]]:
    """Ours over tolerances, SciPy's integrators on the same equations, and Exudyn with the same bodies and springs where it is installed.

    The reference is ours at its finest tolerance; SciPy must agree with it. A line says of each program that is left out why.
    """
    fine = scene.run(FINEST, POINTS)
    segment = fine.trajectory.segments[0]
    assert isinstance(segment, ElasticSegment)
    solution = segment.solution
    ahead = SciPy(solution)
    first = Judge(_end(fine), float(np.abs(fine.displacement[..., :2]).max()), float(max(fine.peaks.values())))
    certificate = first.errors(ahead.run(*CERTIFYING))
    judge = first._replace(certificates=(certificate.error, certificate.force_error or 0.0))
    entries, skipped = [*_ours("elastic", scene.run, judge)], []
    try:
        entries += _ours("elastic, steady stroke", scene.stroke, judge._replace(end=_end(scene.stroke(FINEST_STROKE))))
    except SimulationError as error:
        skipped.append(f"the steady stroke is left out in {SPRINGS}: {error}")
    entries += _by_scipy(ahead, judge)
    try:
        entries += _by_exudyn(scene, solution, judge)
    except ModuleNotFoundError:
        skipped.append(f"Exudyn is left out in {SPRINGS}: not installed; pip install 'pinpress[peers]'")
    except PinpressError as error:
        skipped.append(f"Exudyn is left out in {SPRINGS}: {error}")
    group = Group(
        scene.words,
        "of half a stroke and the forces at its end",
        "of the slide's place at its end, of the largest displacement by the springs",
        max(judge.certificates),
        f"collocation and SciPy's {CERTIFYING[0]}",
        "force_error",
    )
    return Contest(SPRINGS, group, tuple(entries)), skipped


def _ours(method: str, run: Callable[[float], ElasticRun], judge: Judge) -> Iterator[Contestant]:
    for tolerance in TOLERANCES:
        yield Contestant(
            SPRINGS, method, f"tolerance {tolerance:.0e}", tolerance, partial(run, tolerance), lambda found: judge.errors(_end(found))
        )


def _by_scipy(ahead: SciPy, judge: Judge) -> Iterator[Contestant]:
    for integrator, tolerances in INTEGRATORS.items():
        for tolerance in tolerances:
            work = partial(ahead.run, integrator, tolerance)
            yield Contestant(SPRINGS, f"SciPy {integrator}, on springs", f"tolerance {tolerance:.0e}", tolerance, work, judge.errors)


def _by_exudyn(scene: SpringsScene, solution: ElasticSolution, judge: Judge) -> Iterator[Contestant]:
    from support.oracles.exudyn_on_springs import NAME, SETTINGS, ExudynOnSprings  # optional, and slow to import

    peer = ExudynOnSprings(solution, scene.duration, scene.load)
    for how in SETTINGS:

        def work(how: Any = how) -> End:
            return end_of(solution, peer.run(how))

        yield Contestant(SPRINGS, f"{NAME}, {how.solver}", how.words, how.number, work, judge.errors)


def _end(run: ElasticRun) -> End:
    force = np.array([run.bearing_force[name][-1] for name in run.bearing_force])
    return End(float(run.slide_position[-1]), force, run.stats.energy_error, run.stats.evaluations)


@dataclass(frozen=True, eq=False)
class SciPy:
    """SciPy's integrators on the equations of a solution, from its first state, through its segments.

    Attributes:
        solution: the solution that says which forces act in which order.
    """

    solution: ElasticSolution

    def run(self, integrator: str, tolerance: float) -> End:
        """The end of the run by an integrator, with steps to a tolerance.

        Raises:
            SimulationError: the integrator gives up.
        """
        from scipy.integrate import solve_ivp  # slow to import

        equations, knots = self.solution.equations, self.solution.panels.mesh.knots
        time, state, evaluations = float(knots[0]), self.solution.panels.states[0], 0
        atol = tolerance * np.repeat([LENGTH, RATE], equations.size)
        for number in range(len(equations.segments)):
            event = (equations.events or {}).get(number + 1)
            waits = isinstance(event, Event) and event.path != CRANK_ANGLE
            until = float(knots[-1] if waits else knots[number + 1])
            more = {} if integrator == "DOP853" else {"jac": partial(self._jacobian, number)}
            found = solve_ivp(
                partial(self._rates, number),
                (time, until),
                state,
                integrator,
                rtol=tolerance,
                atol=atol,
                events=[self._reaches(event)] if waits and isinstance(event, Event) else None,
                **more,
            )
            evaluations += found.nfev
            time, state = float(found.t[-1]), found.y[:, -1]
            if not found.success or not np.isfinite(state).all():
                raise SimulationError(f"SciPy's {integrator} finds no end of the run: {found.message}", time)
        return end_of(self.solution, equations.state(np.array([time]), *np.split(state[None], 2, axis=1)), evaluations)

    @cached_property
    def _inverse(self) -> Array:
        return np.asarray(np.linalg.inv(self.solution.equations.mass))

    def _rates(self, segment: int, time: float, state: Array) -> Array:
        """Rates of a state; forces alone, without the derivatives that the collocation takes along."""
        equations, sprung = self.solution.equations, self.solution.equations.sprung
        size = equations.size
        bodies = equations.state(np.array([time]), state[None, :size], state[None, size:])
        force = sprung.spring_forces(bodies, derivatives=False).force
        for law, interval in zip(equations.all_forces, equations.segments[segment], strict=True):
            if isinstance(interval, ForceInterval):
                path = equations.paths[law.row].over(sprung, bodies)
                force = force + np.asarray(interval.force(path.value - law.datum, path.rate)) * path.gradient
        return np.concatenate([state[size:], self._inverse @ force[0, :size]])

    def _jacobian(self, segment: int, time: float, state: Array) -> Array:
        equations = self.solution.equations
        size, number = equations.size, np.array([segment])
        at = equations.linearised(np.array([time]), state[None, :size], state[None, size:], np.zeros((1, size)), number)
        rows = -self._inverse @ np.concatenate([at.stiffness[0], at.damping[0]], axis=1)
        return np.concatenate([np.concatenate([np.zeros((size, size)), np.eye(size)], axis=1), rows])

    def _reaches(self, event: Event) -> Callable[[float, Array], float]:
        """How far the slide is from the border at which a segment ends."""
        equations, sprung = self.solution.equations, self.solution.equations.sprung
        size = equations.size

        def reaches(time: float, state: Array) -> float:
            path = equations.paths[event.path].over(sprung, equations.state(np.array([time]), state[None, :size], state[None, size:]))
            return float(path.value[0]) - event.value

        reaches.terminal = True  # type: ignore[attr-defined]
        return reaches
