"""`accuracy` of the proximal settings of Pinocchio's constraint dynamics: accelerations and loop forces of states in a turn.

Equations that say nothing new (every planar pin has one, across the plane) make the matrix of constraint dynamics singular. Its proximal
parameter mu takes their place, and iterations take its error away again: too small a mu, and rounding is divided by it; too large, and the
iterations do not get there.
"""

from functools import partial

import numpy as np
import pinocchio as pin

from .contestants import Contest, Contestant, Errors
from .coordinates import Array
from .forward_dynamics import ForwardDynamics
from .linkage import Linkage
from .measurements import PROXIMAL
from .motion import cycle

STATES = 24  # of a turn
PARAMETERS = (0.0, *(10.0**k for k in range(-14, -1)))
ITERATIONS = (1, 5, 20, 100)


def contest(press: Linkage, speed: float, flywheel: float) -> Contest:
    """Settings of `constraintDynamics`, of the crank turning with a flywheel and without torque, and what method `constraint` takes.

    The reference are null-space accelerations, in which there is no mu; those of the reduced equation have to be the same.
    """
    crank = press.spatial.drivers[0]
    armature = np.zeros(press.model.nv)
    armature[crank] = flywheel
    dynamics = ForwardDynamics(press, armature)
    if dynamics.quick is None:
        skipped = (
            "proximal settings are skipped: constraintDynamics does not treat gear pairs, links without mass or loops that hold each other"
        )
        return Contest(PROXIMAL, (), 0.0, "", (skipped,))
    motion = cycle(press, speed=speed, points=STATES)
    positions, rates = motion.joint_position.copy(), motion.v.copy()
    truth = np.array([dynamics.acceleration_in_null_space(x, v, dynamics.still) for x, v in zip(positions, rates, strict=True)])
    peak, certificate = np.abs(truth).max(), 0.0
    table, slope = press.table.at(motion.crank_angle)
    reduced = -(0.5 * slope[0] * speed**2 + slope[1]) / (table[0] + flywheel)
    certificate = float(np.abs(reduced - truth[:, crank]).max() / peak)

    def work(settings: "pin.ProximalSettings | None") -> Array:
        states = zip(positions, rates, strict=True)
        if settings is None:
            return np.array([dynamics.acceleration(x, v, dynamics.still) for x, v in states])
        return np.array([dynamics.acceleration_by(settings, x, v, dynamics.still) for x, v in states])

    def judged(found: Array) -> Errors:
        return Errors(max(float(np.abs(found - truth).max()) / peak, certificate))

    entries = [
        Contestant(
            PROXIMAL,
            f"{iterations} iteration{'s' * (iterations > 1)}",
            f"mu {mu:.0e}",
            mu,
            partial(work, pin.ProximalSettings(0.0, 1e-13, mu, iterations)),
            judged,
        )
        for iterations in ITERATIONS
        for mu in PARAMETERS
    ]
    mu = dynamics.quick.settings.mu
    entries.append(Contestant(PROXIMAL, "as method constraint chooses", f"mu {mu:.0e}", mu, partial(work, None), judged))
    return Contest(PROXIMAL, tuple(entries), certificate, "null-space accelerations and the reduced equation")
