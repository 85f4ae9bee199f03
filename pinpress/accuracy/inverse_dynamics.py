"""Contest of inverse dynamics: a turn at constant speed, from crank angles to the driving torque and every bearing force."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from ..common.arrays import Array
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..kinematics.motion import cycle
from ..linkage.linkage import Linkage
from .contests import Contest, Contestant, Errors, force_error, peak_force, peak_of
from .measurements import INVERSE_DYNAMICS
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
