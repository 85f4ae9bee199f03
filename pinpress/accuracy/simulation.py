"""Contests of simulation: scenes, judged by crank angle and bearing forces at their end; and the table behind method `reduced`."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..common.numerics import NODES
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.cycle import motion_through_change_points
from ..linkage.linkage import Linkage
from ..linkage.memo import keep_all_but
from ..simulation import reduced_model
from ..simulation.reduced_model import reduced_model_of
from ..simulation.run import Run
from ..simulation.simulate import simulate
from ..simulation.solvers import LEAST_TOLERANCE
from .contests import Contest, Contestant, Errors, force_error, peak_force
from .measurements import FREE_RUN, SPEED_LAW, TABLE
from .peers.peer import ClosedFormSolver, Peer, RunEnd
from .scenes import Scene

METHODS = ("reduced", "implicit", "constraint")
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
STEPS = (40, 80, 160, 320, 640)  # steps of the classical Runge-Kutta method per turn
PANELS = (1, 2, 3, 4, 6, 8, 11, 16, 22, 32)  # numbers of panels of a reduced table
PACE = 60 / 70  # length of a turn for which the steps of peers are meant [s]
BETWEEN = 997  # crank angles at which the error of a table is found
STATES = 121  # states of the reference in which forces have their peaks; the first one, in which a stiff drive gives a blow, does not count
UNSTABLE = f"fixed steps are left out in the {SPEED_LAW}: they are stable only below the time in which it forgets"


class Ended(NamedTuple):
    """A run and the forces in its last state.

    Attributes:
        run: the run.
        last: reactions in its last state.
    """

    run: Run
    last: Reactions


@dataclass(frozen=True, eq=False)
class Reference:
    """The reference end of a scene, by which all runs are judged. No error counts as less than the difference of its two methods.

    Attributes:
        last: reactions in the last state.
        angle: crank angle in the last state, unwrapped [rad].
        peak: largest force of any bearing in the run [N].
        certificate: difference of the two methods' crank angles [rad].
        force_certificate: largest difference of their bearing forces, divided by the peak [-].
    """

    last: Reactions
    angle: float
    peak: float
    certificate: float
    force_certificate: float

    def judge(self, ended: Ended) -> Errors:
        """Errors of a run by one of our methods."""
        stats = ended.run.stats
        error, force = self._errors(float(ended.run.crank_angle[-1]), force_error(ended.last.bearing_force, self.last, self.peak))
        return Errors(error, force, stats.closure_error, stats.energy_error, stats.evaluations)

    def judge_peer(self, end: RunEnd) -> Errors:
        """Errors of a run of a peer."""
        forces = {name: force[None] for name, force in end.force.items()}
        error, force = self._errors(end.crank_angle, force_error(forces, self.last, self.peak, determined=True))
        return Errors(error, force, end.loop_gap, end.energy_error, end.evaluations)

    def _errors(self, angle: float, force: float) -> tuple[float, float]:
        return max(abs(angle - self.angle), self.certificate), max(force, self.force_certificate)


def simulation_contest(press: Linkage, scene: Scene, peers: Sequence[Peer], solvers: Sequence[ClosedFormSolver]) -> Contest:
    """All methods over tolerances and fixed steps, peers over their steps, and solvers of the closed form over their tolerances.

    The reference is a run of all joints with the least tolerance. It must agree with the reduced equation, which shares no equation of
    motion with it.
    """
    reference = _reference(press, scene)
    entries = [*_adaptive_runs(press, scene, reference), *_fixed_step_runs(press, scene, reference)]
    skipped = [f"{each.name} is left out in the {scene.group}: {each.left_out[scene.group]}" for each in _left_out(peers, solvers, scene)]
    for peer in peers:
        if peer.steps and scene.group not in peer.left_out:
            entries += _peer_runs(peer, scene, reference)
    for solver in solvers:
        if scene.group not in solver.left_out:
            entries += _solver_runs(solver, scene, reference)
    if scene.group == SPEED_LAW:
        skipped.append(UNSTABLE)
    by = {"constraint": "all joints", "reduced": "the reduced equation", "implicit": "the reduced equation by Radau IIA"}
    certified_by = " and ".join(by[method] for method in scene.certifying)
    return Contest(scene.group, tuple(entries), reference.certificate, certified_by, tuple(skipped))


def _reference(press: Linkage, scene: Scene) -> Reference:
    truth, other = (_ended(press, scene, method, tolerance=LEAST_TOLERANCE) for method in scene.certifying)
    whole = inverse_dynamics(press, _run(press, scene, scene.certifying[1], points=STATES))
    peak = peak_force({name: force[1:] for name, force in whole.bearing_force.items()})
    angle = float(truth.run.crank_angle[-1])
    certificate = max(abs(float(other.run.crank_angle[-1]) - angle), float(np.spacing(abs(angle))))
    return Reference(truth.last, angle, peak, certificate, force_error(other.last.bearing_force, truth.last, peak))


def _adaptive_runs(press: Linkage, scene: Scene, reference: Reference) -> Iterator[Contestant]:
    """Runs by our methods with steps chosen by their error."""

    def toleranced(method: str, tolerance: float, setting: str) -> Contestant:
        work = partial(_ended, press, scene, method, tolerance=tolerance)
        return Contestant(scene.group, method, setting, tolerance, work, reference.judge)

    for method in METHODS:
        if method == "reduced" and _alike(press, scene):
            yield toleranced(method, 1e-11, "any tolerance")
        else:
            yield from (toleranced(method, tolerance, f"tolerance {tolerance:.0e}") for tolerance in TOLERANCES)
    if scene.group == FREE_RUN:
        method, setting = "reduced, its table anew", "tolerance 1e-11"
        yield Contestant(scene.group, method, setting, 1e-11, lambda: _ended(_without_table(press), scene, "reduced"), reference.judge)


def _fixed_step_runs(press: Linkage, scene: Scene, reference: Reference) -> Iterator[Contestant]:
    """Runs by our methods with fixed steps, which are stable in all scenes except the one with a stiff law."""
    if scene.group == SPEED_LAW:
        return
    for method in ("reduced", "constraint"):
        for step in (scene.turn / count for count in STEPS):
            work = partial(_ended, press, scene, method, step=step)
            yield Contestant(scene.group, f"{method}, Runge-Kutta 4", f"step {1e3 * step:.3g} ms", step, work, reference.judge)


def _peer_runs(peer: Peer, scene: Scene, reference: Reference) -> Iterator[Contestant]:
    for step in (step * scene.turn / PACE for step in peer.steps):
        if scene.group == FREE_RUN:
            work = partial(peer.free_run, scene.angle, scene.speed, float(scene.flywheel.inertia), scene.duration, step)
        else:
            work = partial(peer.run, scene, step)
        yield Contestant(scene.group, peer.name, f"step {1e3 * step:.3g} ms", step, work, reference.judge_peer, peer.cannot)


def _solver_runs(solver: ClosedFormSolver, scene: Scene, reference: Reference) -> Iterator[Contestant]:
    run = solver.prepared(scene)
    for tolerance in solver.tolerances:
        setting = f"tolerance {tolerance:.0e}"
        yield Contestant(scene.group, solver.name, setting, tolerance, partial(run, tolerance), reference.judge_peer)


def _left_out(peers: Sequence[Peer], solvers: Sequence[ClosedFormSolver], scene: Scene) -> list[Peer | ClosedFormSolver]:
    runners: list[Peer | ClosedFormSolver] = [*(peer for peer in peers if peer.steps), *solvers]
    return [each for each in runners if scene.group in each.left_out]


def table_contest(press: Linkage) -> Contest:
    """Tables of reduced inertia and potential energy with different numbers of samples, judged between the samples."""
    chosen = reduced_model.build_reduced_model(press, ())
    angles = np.random.default_rng(0).uniform(chosen.borders[0], chosen.borders[-1], BETWEEN)
    exact = reduced_model.sample_rows(press, angles, ())[:2]
    ranges = np.maximum(np.ptp(exact, axis=1), np.finfo(float).tiny)

    def off(table: reduced_model.ReducedModel) -> float:
        missed = table.at(angles)[0][:2] - exact
        missed[1] -= missed[1].mean()  # the zero of the potential energy means nothing
        return float((np.abs(missed).max(axis=1) / ranges).max())

    def entry(method: str, samples: int, panels: int | None) -> Contestant:
        made = partial(reduced_model.build_reduced_model, press, (), panels)
        number = None if panels is None else float(samples)
        return Contestant(
            TABLE, method, f"{samples} samples", number, made, lambda table: Errors(off(table), evaluations=table.evaluations)
        )

    entries = [entry("reduced", panels * NODES, panels) for panels in PANELS]
    entries.append(entry("reduced, as many as resolve it", chosen.evaluations, None))
    finest = reduced_model.build_reduced_model(press, (), 2 * PANELS[-1])
    return Contest(TABLE, tuple(entries), off(finest), f"the linkage itself and a table of {finest.evaluations} samples")


def _alike(press: Linkage, scene: Scene) -> bool:
    """Whether runs by the reduced equation do not depend on their tolerance, so that one row stands for all."""
    loose, tight = (_run(press, scene, "reduced", points=2, tolerance=tolerance) for tolerance in (TOLERANCES[0], TOLERANCES[-1]))
    return loose.crank_angle[-1] == tight.crank_angle[-1] and loose.stats.evaluations == tight.stats.evaluations


def _ended(press: Linkage, scene: Scene, method: str, **how: float) -> Ended:
    run = _run(press, scene, method, points=2, **how)
    last = motion_through_change_points(press, run.crank_angle[-1:], run.crank_speed[-1:], run.crank_acceleration[-1:])
    return Ended(run, inverse_dynamics(press, last))


def _run(press: Linkage, scene: Scene, method: str, **how: Any) -> Run:
    run = simulate(
        press,
        scene.duration,
        speed=scene.speed,
        angle=scene.angle,
        drive=scene.drive,
        flywheel=scene.flywheel,
        loads=scene.loads,
        method=method,
        clutch=scene.clutch,
        **how,
    )
    assert isinstance(run, Run)
    return run


def _without_table(press: Linkage) -> Linkage:
    """The linkage without its reduced table, with everything else that is derived from it."""
    same = replace(press)
    keep_all_but(reduced_model_of, same, press)
    return same
