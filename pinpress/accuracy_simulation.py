"""`accuracy` of simulation: a free run with a flywheel on the crank, to the crank angle and every bearing force at its end; and of the
table that the method `reduced` works with."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from . import reduced
from .contestants import Contest, Contestant, Errors, force_error, peak_force
from .drives import Flywheel
from .linkage import Linkage
from .measurements import SIMULATION, TABLE
from .motion import carried
from .reactions import Reactions, inverse_dynamics
from .run import Run
from .simulation import LEAST_TOLERANCE, simulate

if TYPE_CHECKING:
    from .peers import End, Peer

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
STEPS = (40, 80, 160, 320, 640)  # of the classical Runge-Kutta method, per turn
PANELS = (1, 2, 3, 4, 6, 8, 11, 16, 22, 32)  # of a reduced table
PACE = 60 / 70  # length of a turn for which the steps of peers are meant [s]
BETWEEN = 997  # crank angles at which a table is looked at
STATES = 121  # of the reference, in which forces have their peaks


class Scene(NamedTuple):
    """A free run from crank angle 0: speed of the crank at the start [rad/s], inertia of the flywheel [kg m2], duration [s]."""

    speed: float
    flywheel: float
    duration: float


class Ended(NamedTuple):
    """A run and the forces in its last state."""

    run: Run
    last: Reactions


def contest(press: Linkage, scene: Scene, peers: "Sequence[Peer]") -> Contest:
    """Both methods over tolerances and fixed steps, and the peers over their steps.

    The reference is a run of all joints (`constraint`) with the least tolerance. The reduced equation, which shares no equation of motion
    with it, has to give the same; no error is said to be less than the difference of the two.
    """
    truth, other = (_ended(press, scene, method, tolerance=LEAST_TOLERANCE) for method in ("constraint", "reduced"))
    peak = peak_force(inverse_dynamics(press, _run(press, scene, "reduced", points=STATES)))
    angle = float(truth.run.crank_angle[-1])
    certificate = abs(float(other.run.crank_angle[-1]) - angle)
    force_certificate = force_error(other.last.bearing_force, truth.last, peak)

    def own(ended: Ended) -> Errors:
        stats, off = ended.run.stats, force_error(ended.last.bearing_force, truth.last, peak)
        error = abs(float(ended.run.crank_angle[-1]) - angle)
        return Errors(max(error, certificate), max(off, force_certificate), stats.closure_error, stats.energy_error, stats.evaluations)

    def of_peer(end: "End") -> Errors:
        off = force_error({name: force[None] for name, force in end.force.items()}, truth.last, peak, determined=True)
        return Errors(max(abs(end.crank_angle - angle), certificate), max(off, force_certificate), end.loop_gap, end.energy_error)

    def entry(method: str, setting: str, number: float, work: Callable[[], Any]) -> Contestant:
        return Contestant(SIMULATION, method, setting, number, work, own)

    turn = 2 * np.pi / abs(scene.speed)
    entries = [
        entry(method, f"tolerance {t:.0e}", t, partial(_ended, press, scene, method, tolerance=t))
        for method in ("reduced", "constraint")
        for t in TOLERANCES
    ]
    entries.append(entry("reduced, its table anew", "tolerance 1e-11", 1e-11, lambda: _ended(_without_table(press), scene, "reduced")))
    entries += [
        entry(f"{method}, Runge-Kutta 4", f"step {1e3 * turn / n:.3g} ms", turn / n, partial(_ended, press, scene, method, step=turn / n))
        for method in ("reduced", "constraint")
        for n in STEPS
    ]
    for peer in peers:
        for step in (step * turn / PACE for step in peer.steps):
            work = partial(peer.free_run, 0.0, scene.speed, scene.flywheel, scene.duration, step)
            entries.append(Contestant(SIMULATION, peer.name, f"step {1e3 * step:.3g} ms", step, work, of_peer))
    return Contest(SIMULATION, tuple(entries), certificate, "all joints and the reduced equation")


def tables(press: Linkage) -> Contest:
    """Tables of the reduced inertia and potential energy with so many samples, between which they are looked at."""
    chosen = reduced.build(press, ())
    angles = np.random.default_rng(0).uniform(chosen.borders[0], chosen.borders[-1], BETWEEN)
    exact = reduced.sampled(press, angles, ())[:2]
    ranges = np.maximum(np.ptp(exact, axis=1), np.finfo(float).tiny)

    def off(table: reduced.Table) -> float:
        missed = table.at(angles)[0][:2] - exact
        missed[1] -= missed[1].mean()  # the zero of the potential energy means nothing
        return float((np.abs(missed).max(axis=1) / ranges).max())

    def entry(method: str, samples: int, panels: int | None) -> Contestant:
        made = partial(reduced.build, press, (), panels)
        number = None if panels is None else float(samples)
        return Contestant(
            TABLE, method, f"{samples} samples", number, made, lambda table: Errors(off(table), evaluations=table.evaluations)
        )

    entries = [entry("reduced", panels * reduced.NODES, panels) for panels in PANELS]
    entries.append(entry("reduced, as many as resolve it", chosen.evaluations, None))
    finest = reduced.build(press, (), 2 * PANELS[-1])
    return Contest(TABLE, tuple(entries), off(finest), f"the linkage itself and a table of {finest.evaluations} samples")


def _ended(press: Linkage, scene: Scene, method: str, **how: float) -> Ended:
    run = _run(press, scene, method, points=2, **how)
    last = carried(press, run.crank_angle[-1:], run.crank_speed[-1:], run.crank_acceleration[-1:])
    return Ended(run, inverse_dynamics(press, last))


def _run(press: Linkage, scene: Scene, method: str, **how: Any) -> Run:
    run: Run = simulate(press, scene.duration, scene.speed, flywheel=Flywheel(scene.flywheel), method=method, **how)
    return run


def _without_table(press: Linkage) -> Linkage:
    """The same linkage, all that is derived from it kept but its table."""
    same = replace(press)
    same.__dict__.update({name: value for name, value in press.__dict__.items() if name != "table"})
    return same
