"""Contest of the proximal settings of Pinocchio's constraint dynamics: accelerations and loop forces of states in a turn.

Equations that say nothing new (every planar pin has one, across the plane) make the matrix of constraint dynamics singular. Its proximal
parameter mu takes their place, and iterations take its error away again: too small a mu, and rounding is divided by it; too large, and the
iterations do not get there.
"""

from functools import partial

import numpy as np
import pinocchio as pin

from ..common.arrays import Array
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..kinematics.motion import cycle, servo_cycle
from ..linkage.linkage import Linkage
from ..simulation.reduced_model import tabulated
from .contests import Contest, Contestant, Errors, peak_of
from .measurements import PROXIMAL, PROXIMAL_STATES

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
    table, slope = tabulated(press).at(motion.crank_angle)
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
