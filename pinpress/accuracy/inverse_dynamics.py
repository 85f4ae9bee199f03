"""Contest of inverse dynamics: a turn at constant speed, from crank angles to the driving torque and every bearing force.

The proximal settings of Pinocchio's constraint dynamics have a contest beside it: accelerations and loop forces of states in a turn.
Equations that say nothing new (every planar pin has one, across the plane) make the matrix of constraint dynamics singular. Its proximal
parameter mu takes their place, and iterations take its error away again: too small a mu, and rounding is divided by it; too large, and the
iterations do not get there.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
import pinocchio as pin

from ..common.arrays import Array
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..kinematics.motion import cycle, servo_cycle
from ..linkage.linkage import Linkage
from ..simulation.reduced_model import reduced_model_of
from .contests import Contest, Contestant, Errors, force_error, peak_force, peak_of
from .measurements import INVERSE_DYNAMICS, PROXIMAL, PROXIMAL_STATES
from .peers.peer import Answer, Peer

STATES = 48  # of a turn, in which forward dynamics gives the accelerations back


def inverse_dynamics_contest(press: Linkage, speed: float, points: int, peers: Sequence[Peer]) -> Contest:
    """Both engines and the peers.

    The engines of a planar press share no equation and judge each other. The torque of a press in space is judged by forward dynamics,
    which gives the accelerations back under it.
    """
    engines = press.engines
    answers = {engine: _solved(press, speed, points, engine) for engine in engines}
    judges = {"plane": answers["pinocchio"], "pinocchio": answers[engines[0]]}
    torque, peak = peak_of(answers["pinocchio"].driving_torque), peak_force(answers["pinocchio"].bearing_force)
    returned = 0.0 if len(engines) > 1 else _returned(press, answers["pinocchio"])

    def judged(judge: Reactions, answer: Reactions) -> Errors:
        return Errors(
            _off(answer.driving_torque, judge.driving_torque, torque) if len(engines) > 1 else returned,
            force_error(answer.bearing_force, judge, peak) if len(engines) > 1 else None,
            float(answer.motion.closure_error.max()),
            float(np.abs(answer.power_residual).max()),
            points,
        )

    def by_peer(answer: Answer) -> Errors:
        truth = answers[engines[0]]
        return Errors(
            _off(answer.torque, truth.driving_torque, torque), force_error(answer.force, truth, peak, determined=True), evaluations=points
        )

    angle = answers[engines[0]].motion.crank_angle
    setting = f"{points} crank angles"
    own = [
        Contestant(
            INVERSE_DYNAMICS,
            engine,
            setting,
            points,
            partial(_solved, press, speed, points, engine),
            partial(judged, judges[engine]),
        )
        for engine in engines
    ]
    others = [
        Contestant(INVERSE_DYNAMICS, peer.name, setting, points, partial(peer.inverse_dynamics, angle, speed), by_peer)
        for peer in peers
        if peer.inverse
    ]
    if len(engines) > 1:
        agreement = judged(answers["pinocchio"], answers["plane"])
        certificate, certified_by = max(agreement.error, agreement.force_error or 0.0), "engines plane and pinocchio"
    else:
        certificate, certified_by = returned, "torque and forward dynamics under it"
    return Contest(INVERSE_DYNAMICS, (*own, *others), certificate, certified_by)


def _solved(press: Linkage, speed: float, points: int, engine: str) -> Reactions:
    return inverse_dynamics(press, cycle(press, speed=speed, points=points, engine=engine), engine=engine)


def _off(torque: Array, expected: Array, peak: float) -> float:
    return float(np.abs(torque - expected).max()) / peak


def _returned(press: Linkage, reactions: Reactions) -> float:
    """Largest difference of the accelerations that forward dynamics gives back under the driving torque, of their peak."""
    dynamics, motion, crank = press.forward_dynamics(np.zeros(press.model.nv)), reactions.motion, press.driver_indices[0]
    some = np.arange(0, len(motion.v), max(1, len(motion.v) // STATES))
    efforts = np.zeros((len(some), press.model.nv))
    efforts[:, crank] = reactions.driving_torque[some]
    states = zip(motion.joint_position[some].copy(), motion.v[some].copy(), efforts, strict=True)
    found = np.array([dynamics.acceleration(*state) for state in states])
    return float(np.abs(found - motion.a[some]).max()) / peak_of(motion.a[some])


PARAMETERS = (0.0, *(10.0**k for k in range(-14, -1)))
ITERATIONS = (1, 5, 20)
SKIPPED = (
    "proximal settings are skipped: constraintDynamics is for loops, without gear pairs, links without mass, or loops that hold each other"
)


def proximal_contest(press: Linkage, speed: float, flywheel: float) -> Contest:
    """Settings of `constraintDynamics`, among them the one that method `constraint` takes.

    The crank turns with a flywheel and without torque. The reference are null-space accelerations, in which there is no mu; those of the
    reduced equation have to be the same.
    """
    crank = press.driver_indices[0]
    armature = np.zeros(press.model.nv)
    armature[crank] = flywheel
    dynamics = press.forward_dynamics(armature)
    if dynamics.quick is None:
        return Contest(PROXIMAL, (), 0.0, "", (SKIPPED,))
    turn = cycle(press, speed=speed, points=PROXIMAL_STATES)
    states = list(zip(turn.joint_position.copy(), turn.v.copy(), strict=True))
    truth = np.array([dynamics.acceleration_in_null_space(x, v, dynamics.still) for x, v in states])
    motion = servo_cycle(press, angle=turn.crank_angle, speed=speed, acceleration=truth[:, crank])
    at_loops = inverse_dynamics(press, motion).bearing_force
    expected = np.array([at_loops[loop.name] for loop in press.loops]).transpose(1, 0, 2)
    peak, peak_at_loops = peak_of(truth), peak_of(np.linalg.norm(expected, axis=2))
    table, slope = reduced_model_of(press).at(motion.crank_angle)
    reduced = -(0.5 * slope[0] * speed**2 + slope[1]) / (table[0] + flywheel)
    certificate = float(np.abs(reduced - truth[:, crank]).max() / peak)

    def answers(settings: pin.ProximalSettings) -> list[tuple[Array, Array]]:
        return [dynamics.answer_by(settings, x, v, dynamics.still) for x, v in states]

    def judged(found: list[tuple[Array, Array]]) -> Errors:
        accelerations, forces = (np.array(values) for values in zip(*found, strict=True))
        off = float(np.linalg.norm(forces - expected, axis=2).max() / peak_at_loops) if forces.shape == expected.shape else None
        return Errors(max(float(np.abs(accelerations - truth).max()) / peak, certificate), off)

    settings = [
        (f"{iterations} iteration{'s' * (iterations > 1)}", pin.ProximalSettings(0.0, 1e-13, mu, iterations))
        for iterations in ITERATIONS
        for mu in PARAMETERS
    ]
    settings.append(("as chosen", dynamics.quick.settings))
    entries = [Contestant(PROXIMAL, method, f"mu {each.mu:.0e}", each.mu, partial(answers, each), judged) for method, each in settings]
    return Contest(PROXIMAL, tuple(entries), certificate, "null-space accelerations and the reduced equation")
