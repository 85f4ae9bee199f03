"""Contests of `pinpress.accuracy` with other programs as contestants, and two contests of settings.

Proximal settings: redundant equations (every planar pin has one, across the plane) make the matrix of Pinocchio's constraint dynamics
singular. Its proximal parameter mu regularises the matrix, and iterations remove the error by mu. With too small a mu rounding is divided
by it, with too large a mu the iterations do not converge. Reduced tables: samples of reduced inertia and potential energy.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from importlib import import_module

import numpy as np
import pinocchio as pin
from benchmarks.peers.peer import Answer, Peer, RunEnd

import pinpress as pp
from pinpress.accuracy.scenes import Scene
from pinpress.accuracy.work_precision import (
    INVERSE_DYNAMICS,
    Contest,
    Contestant,
    Errors,
    Group,
    Reference,
    inverse_dynamics_contest,
    peak_force,
    peak_of,
    reference_of,
    simulation_contest,
    solve_turn,
)
from pinpress.common.errors import PinpressError
from pinpress.common.numerics import NODES
from pinpress.common.quantities import Array
from pinpress.simulation import reduced_model
from pinpress.simulation.reduced_model import reduced_model_of

PROXIMAL, TABLE = "proximal settings", "reduced table"
PEERS = {  # package that must be installed, the extra that installs it, our module and class
    "hand script": ("numpy", "", "hand_script", "HandScript"),
    "Pinocchio in C++": ("pinocchio", "", "pinocchio_press", "PinocchioCpp"),
    "MuJoCo": ("mujoco", "peers", "mujoco_press", "Mujoco"),
    "MuJoCo's mj_step": ("mujoco", "peers", "mujoco_press", "MujocoSteps"),
    "Exudyn": ("exudyn", "peers", "exudyn_in_space", "exudyn_peer"),
    "Drake": ("pydrake", "drake", "drake_press", "Drake"),
    "Drake's steps": ("pydrake", "drake", "drake_press", "DrakeSteps"),
}
INTEGRATORS = ("DOP853", "LSODA", "Radau")  # of SciPy, on the closed form of the six-bar
PACE = 60 / 70  # length of a turn for which the steps of peers are meant [s]


def find_peers(press: pp.Linkage) -> tuple[list[Peer], list[str]]:
    """The peers that can treat a press, and a line for each that is skipped, with the reason."""
    peers: list[Peer] = []
    skipped: list[str] = []
    for name, (package, extra, module, kind) in PEERS.items():
        try:
            import_module(package)  # its absence is known even if our module has been imported before
            peers.append(getattr(import_module(f"benchmarks.peers.{module}"), kind)(press))
        except ModuleNotFoundError:
            skipped.append(f"{name} is skipped: not installed; pip install 'pinpress[{extra}]'")
        except PinpressError as error:
            skipped.append(f"{name} is skipped: {error}")
    if press.name.startswith("zxn2_3000b"):
        from benchmarks.peers.six_bar_press import SixBarEquation  # slow to import: SciPy

        peers += [SixBarEquation(integrator, press.name.endswith("_balanced")) for integrator in INTEGRATORS]
    else:
        skipped.append("SciPy on the closed form is skipped: it is for the six-bar alone")
    return peers, skipped


def turn_beside_peers(press: pp.Linkage, speed: float, points: int, peers: Sequence[Peer]) -> Contest:
    """Our engines and the peers over a turn. Of a peer's forces only what rigid-body mechanics determines is judged."""
    contest = inverse_dynamics_contest(press, speed, points)
    judge = solve_turn(press, speed, points, press.engines[0])
    peak = peak_force(judge.bearing_force)
    comparable = any(not np.all(judge.indeterminate[name][:3]) for name in judge.bearing_force)

    def errors(answer: Answer) -> Errors:
        torque = float(np.abs(answer.torque - judge.driving_torque).max()) / peak_of(judge.driving_torque)
        return Errors(torque, determined_force_error(answer.force, judge, peak) if comparable else None, evaluations=points)

    angle = judge.motion.crank_angle
    entries = [
        Contestant(INVERSE_DYNAMICS, peer.name, f"{points} crank angles", points, partial(peer.inverse_dynamics, angle, speed), errors)
        for peer in peers
        if peer.inverse
    ]
    return replace(contest, contestants=(*contest.contestants, *entries))


def determined_force_error(forces: Mapping[str, Array], expected: pp.Reactions, peak: float) -> float:
    """Largest distance of a bearing's force from the expected one, without the components that rigid-body mechanics leaves undetermined,
    which other programs share in their own ways; as a share of a peak force [-]."""
    off = []
    for name, force in expected.bearing_force.items():
        determined = ((forces[name] - force) @ expected.indeterminate_axes.T)[:, ~expected.indeterminate[name][:3]]
        off.append(float(np.linalg.norm(determined, axis=1).max()))
    return max(off) / peak


def run_beside_peers(press: pp.Linkage, scene: Scene, peers: Sequence[Peer]) -> tuple[Contest, list[str]]:
    """Our methods, and peers over their steps or tolerances; a line for each that is left out."""
    reference = reference_of(press, scene)
    contest = simulation_contest(press, scene, reference)
    entries, skipped = [*contest.contestants], []
    for peer in (peer for peer in peers if peer.steps or peer.tolerances):
        if scene.group in peer.left_out:
            skipped.append(f"{peer.name} is left out in the {scene.group}: {peer.left_out[scene.group]}")
            continue
        run = peer.prepared(scene)
        settings = {f"tolerance {tolerance:.0e}": tolerance for tolerance in peer.tolerances}
        settings |= {f"step {1e3 * step:.3g} ms": step for step in (step * scene.turn / PACE for step in peer.steps)}
        for words, number in settings.items():
            entries.append(Contestant(scene.group, peer.name, words, number, partial(run, number), partial(judge_end, reference)))
    return replace(contest, contestants=tuple(entries)), skipped


def judge_end(reference: Reference, end: RunEnd) -> Errors:
    """Errors of a run of a peer."""
    forces = {name: force[None] for name, force in end.force.items()}
    angle, force = reference.errors(end.crank_angle, determined_force_error(forces, reference.last, reference.peak))
    return Errors(angle, force, end.loop_gap, end.energy_error, end.evaluations)


# ------------------------------------------------------------------------------------------------------------------------------ settings

STATES = 24  # of a turn, in which proximal settings are measured
PARAMETERS = (0.0, *(10.0**k for k in range(-14, -1)))
ITERATIONS = (1, 5, 20)
PANELS = (1, 2, 3, 4, 6, 8, 11, 16, 22, 32)  # numbers of panels of a reduced table
BETWEEN = 997  # crank angles at which the error of a table is found


def proximal_contest(press: pp.Linkage, speed: float, flywheel: float) -> Contest | str:
    """Settings of `constraintDynamics`, among them the one that method `constraint` takes; or a line that says why there are none.

    The crank turns with a flywheel and without torque. The reference is the accelerations by the null space of the loops, which need no mu;
    the reduced equation must give the same.
    """
    crank = press.driver_indices[0]
    armature = np.zeros(press.model.nv)
    armature[crank] = flywheel
    dynamics = press.forward_dynamics(armature)
    if dynamics.quick is None or dynamics.quick.least is not None or press.couplings:  # forces at redundant loops are not determined
        return "proximal settings are skipped: they are compared for loops without gear pairs, massless links or redundant equations"
    turn = pp.cycle(press, speed=speed, points=STATES)
    states = list(zip(turn.joint_position.copy(), turn.v.copy(), strict=True))
    truth = np.array([dynamics.acceleration_in_null_space(x, v, dynamics.still) for x, v in states])
    motion = pp.servo_cycle(press, angle=turn.crank_angle, speed=speed, acceleration=truth[:, crank])
    loops = pp.inverse_dynamics(press, motion).bearing_force
    expected = np.array([loops[loop.name] for loop in press.loops]).transpose(1, 0, 2)
    peak, peak_of_loops = peak_of(truth), peak_of(np.linalg.norm(expected, axis=2))
    table, slope = reduced_model_of(press).at(motion.crank_angle)
    reduced = -(0.5 * slope[0] * speed**2 + slope[1]) / (table[0] + flywheel)
    certificate = float(np.abs(reduced - truth[:, crank]).max() / peak)

    quick = dynamics.quick

    def answer_by(settings: pin.ProximalSettings, x: Array, v: Array) -> tuple[Array, Array]:
        """The unchecked accelerations (nv,) and forces (points, 3) at the loops' points, link1 on link2, world axes [N]."""
        data, points, forces = quick.data, quick.points, quick.data_of_points
        result = np.array(pin.constraintDynamics(dynamics.model, data, x, v, dynamics.still, points, forces, settings))
        turned = [data.oMi[point.joint1_id].rotation @ point.joint1_placement.rotation for point in points]
        return result, np.array([-r @ each.contact_force.linear for r, each in zip(turned, forces, strict=True)])

    def answers(settings: pin.ProximalSettings) -> list[tuple[Array, Array]]:
        return [answer_by(settings, x, v) for x, v in states]

    def judged(answer: list[tuple[Array, Array]]) -> Errors:
        accelerations, forces = (np.array(values) for values in zip(*answer, strict=True))
        same = forces.shape == expected.shape
        off = float(np.linalg.norm(forces - expected, axis=2).max() / peak_of_loops) if same else None
        return Errors(max(float(np.abs(accelerations - truth).max()) / peak, certificate), off)

    settings = [
        (f"{iterations} iteration{'s' * (iterations > 1)}", pin.ProximalSettings(0.0, 1e-13, mu, iterations))
        for iterations in ITERATIONS
        for mu in PARAMETERS
    ]
    settings.append(("as chosen", quick.settings))
    entries = [Contestant(PROXIMAL, method, f"mu {each.mu:.0e}", each.mu, partial(answers, each), judged) for method, each in settings]
    certified_by = "null-space accelerations and the reduced equation"
    group = Group("", f"of {STATES} states", "of the joint accelerations, of their peak", certificate, certified_by)
    return Contest(PROXIMAL, group, tuple(entries))


def table_contest(press: pp.Linkage) -> Contest:
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
        work = partial(reduced_model.build_reduced_model, press, (), panels)
        number = None if panels is None else float(samples)
        return Contestant(
            TABLE, method, f"{samples} samples", number, work, lambda table: Errors(off(table), evaluations=table.evaluations)
        )

    entries = [entry("reduced", panels * NODES, panels) for panels in PANELS]
    entries.append(entry("reduced, as many as resolve it", chosen.evaluations, None))
    finest = reduced_model.build_reduced_model(press, (), 2 * PANELS[-1])
    certified_by = f"the linkage itself and a table of {finest.evaluations} samples"
    error = "of reduced inertia and potential energy between the samples, of their range"
    return Contest(TABLE, Group("", "of making it", error, off(finest), certified_by), tuple(entries))
