"""`accuracy` of simulation: scenes, to the crank angle and every bearing force at their end; and of the table that the method `reduced`
works with."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..common.gauss import NODES
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..kinematics.motion import carried
from ..linkage.linkage import Linkage
from ..linkage.memo import keep_all_but
from ..simulation import reduced_model as reduced
from ..simulation.reduced_model import tabulated
from ..simulation.run import Run
from ..simulation.simulate import LEAST_TOLERANCE, simulate
from .contestants import Contest, Contestant, Errors, force_error, peak_force
from .measurements import FREE_RUN, SPEED_LAW, TABLE
from .scenes import Scene

if TYPE_CHECKING:
    from .peers import End, Peer, Solver

METHODS = ("reduced", "implicit", "constraint")
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
STEPS = (40, 80, 160, 320, 640)  # of the classical Runge-Kutta method, per turn
PANELS = (1, 2, 3, 4, 6, 8, 11, 16, 22, 32)  # of a reduced table
PACE = 60 / 70  # length of a turn for which the steps of peers are meant [s]
BETWEEN = 997  # crank angles at which a table is looked at
STATES = 121  # of the reference, in which forces have their peaks; the first one, in which a stiff drive gives a blow, does not count
UNSTABLE = f"fixed steps are left out in the {SPEED_LAW}: they are stable only below the time in which it forgets"


class Ended(NamedTuple):
    """A run and the forces in its last state."""

    run: Run
    last: Reactions


def contest(press: Linkage, scene: Scene, peers: "Sequence[Peer]", solvers: "Sequence[Solver]") -> Contest:
    """All methods over tolerances and fixed steps, peers over their steps, and solvers of the closed form over their tolerances.

    The reference is a run of all joints with the least tolerance. The reduced equation, which shares no equation of motion with it, has to
    give the same; no error is said to be less than the difference of the two.
    """
    truth, other = (_ended(press, scene, method, tolerance=LEAST_TOLERANCE) for method in scene.certifying)
    whole = inverse_dynamics(press, _run(press, scene, scene.certifying[1], points=STATES))
    peak = peak_force({name: force[1:] for name, force in whole.bearing_force.items()})
    angle = float(truth.run.crank_angle[-1])
    certificate = max(abs(float(other.run.crank_angle[-1]) - angle), float(np.spacing(abs(angle))))
    force_certificate = force_error(other.last.bearing_force, truth.last, peak)

    def own(ended: Ended) -> Errors:
        stats, off = ended.run.stats, force_error(ended.last.bearing_force, truth.last, peak)
        error = abs(float(ended.run.crank_angle[-1]) - angle)
        return Errors(max(error, certificate), max(off, force_certificate), stats.closure_error, stats.energy_error, stats.evaluations)

    def of_peer(end: "End") -> Errors:
        off = force_error({name: force[None] for name, force in end.force.items()}, truth.last, peak, determined=True)
        error = abs(end.crank_angle - angle)
        return Errors(max(error, certificate), max(off, force_certificate), end.loop_gap, end.energy_error, end.evaluations)

    def entry(method: str, setting: str, number: float, work: Callable[[], Any]) -> Contestant:
        return Contestant(scene.group, method, setting, number, work, own)

    def toleranced(method: str, tolerance: float, setting: str = "") -> Contestant:
        work = partial(_ended, press, scene, method, tolerance=tolerance)
        return entry(method, setting or f"tolerance {tolerance:.0e}", tolerance, work)

    turn, entries = scene.turn, []
    for method in METHODS:
        if method == "reduced" and _alike(press, scene):
            entries.append(toleranced(method, 1e-11, "any tolerance"))
        else:
            entries += [toleranced(method, tolerance) for tolerance in TOLERANCES]
    if scene.group == FREE_RUN:
        entries.append(entry("reduced, its table anew", "tolerance 1e-11", 1e-11, lambda: _ended(_without_table(press), scene, "reduced")))
    if scene.group != SPEED_LAW:
        entries += [
            entry(
                f"{method}, Runge-Kutta 4", f"step {1e3 * turn / n:.3g} ms", turn / n, partial(_ended, press, scene, method, step=turn / n)
            )
            for method in ("reduced", "constraint")
            for n in STEPS
        ]
    skipped = []
    for peer in (peer for peer in peers if peer.steps):
        if scene.group in peer.left_out:
            skipped.append(f"{peer.name} is left out in the {scene.group}: {peer.left_out[scene.group]}")
            continue
        for step in (step * turn / PACE for step in peer.steps):
            if scene.group == FREE_RUN:
                work = partial(peer.free_run, scene.angle, scene.speed, float(scene.flywheel.inertia), scene.duration, step)
            else:
                work = partial(peer.run, scene, step)
            entries.append(Contestant(scene.group, peer.name, f"step {1e3 * step:.3g} ms", step, work, of_peer))
    for solver in solvers:
        if scene.group in solver.left_out:
            skipped.append(f"{solver.name} is left out in the {scene.group}: {solver.left_out[scene.group]}")
            continue
        run = solver.prepared(scene)
        for tolerance in solver.tolerances:
            entries.append(Contestant(scene.group, solver.name, f"tolerance {tolerance:.0e}", tolerance, partial(run, tolerance), of_peer))
    if scene.group == SPEED_LAW:
        skipped.append(UNSTABLE)
    by = {"constraint": "all joints", "reduced": "the reduced equation", "implicit": "the reduced equation by Radau IIA"}
    return Contest(scene.group, tuple(entries), certificate, " and ".join(by[method] for method in scene.certifying), tuple(skipped))


def tables(press: Linkage) -> Contest:
    """Tables of the reduced inertia and potential energy with so many samples, between which they are looked at."""
    chosen = reduced.build(press, ())
    angles = np.random.default_rng(0).uniform(chosen.borders[0], chosen.borders[-1], BETWEEN)
    exact = reduced.sampled(press, angles, ())[:2]
    ranges = np.maximum(np.ptp(exact, axis=1), np.finfo(float).tiny)

    def off(table: reduced.ReducedModel) -> float:
        missed = table.at(angles)[0][:2] - exact
        missed[1] -= missed[1].mean()  # the zero of the potential energy means nothing
        return float((np.abs(missed).max(axis=1) / ranges).max())

    def entry(method: str, samples: int, panels: int | None) -> Contestant:
        made = partial(reduced.build, press, (), panels)
        number = None if panels is None else float(samples)
        return Contestant(
            TABLE, method, f"{samples} samples", number, made, lambda table: Errors(off(table), evaluations=table.evaluations)
        )

    entries = [entry("reduced", panels * NODES, panels) for panels in PANELS]
    entries.append(entry("reduced, as many as resolve it", chosen.evaluations, None))
    finest = reduced.build(press, (), 2 * PANELS[-1])
    return Contest(TABLE, tuple(entries), off(finest), f"the linkage itself and a table of {finest.evaluations} samples")


def _alike(press: Linkage, scene: Scene) -> bool:
    """Whether runs by the reduced equation are the same whatever their tolerance: then they are one row."""
    loose, tight = (_run(press, scene, "reduced", points=2, tolerance=tolerance) for tolerance in (TOLERANCES[0], TOLERANCES[-1]))
    return loose.crank_angle[-1] == tight.crank_angle[-1] and loose.stats.evaluations == tight.stats.evaluations


def _ended(press: Linkage, scene: Scene, method: str, **how: float) -> Ended:
    run = _run(press, scene, method, points=2, **how)
    last = carried(press, run.crank_angle[-1:], run.crank_speed[-1:], run.crank_acceleration[-1:])
    return Ended(run, inverse_dynamics(press, last))


def _run(press: Linkage, scene: Scene, method: str, **how: Any) -> Run:
    run = simulate(
        press,
        scene.duration,
        scene.speed,
        scene.angle,
        scene.drive,
        scene.flywheel,
        scene.loads,
        method,
        scene.clutch,
        **how,
    )
    assert isinstance(run, Run)
    return run


def _without_table(press: Linkage) -> Linkage:
    """The same linkage, all that is derived from it kept but its table."""
    same = replace(press)
    keep_all_but(tabulated, same, press)
    return same
