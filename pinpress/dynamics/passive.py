"""Accelerations of passive coordinates: those at which no drive is needed there.

Efforts of the drivers are linear in their accelerations. With the efforts u of a motion and the rates N of all joints by those of the
passive coordinates, the accelerations a + N z need the efforts u + M z at the passive coordinates, where M = N' M N is their reduced
mass matrix. Its columns are differences of efforts, so that a linkage without passive coordinates knows nothing of all this.
Source: Featherstone, Rigid Body Dynamics Algorithms (2008), 9.6, hybrid dynamics, of closed loops.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..common.errors import PinpressError
from ..common.quantities import Array
from ..engines.engine import ClosedStates, Engine
from ..engines.friction import FrictionLaw
from ..engines.machine_elements.forces import inverse_dynamics
from ..engines.wrenches import AppliedConditions, AppliedForce
from ..linkage.linkage import Linkage
from .applied_loads import joint_efforts

PROBE = 1e6  # acceleration beside which weights and the motion's own inertia forces are rounding [rad/s2 or m/s2]
WITHOUT_INERTIA = 1e-12  # share of the largest inertia below which the inertia of a passive coordinate is rounding


def free_accelerations(
    press: Linkage, engine: Engine, states: ClosedStates, loads: Sequence[AppliedForce], law: FrictionLaw | None
) -> ClosedStates:
    """The states with the accelerations at which no effort is needed at the passive coordinates; those of the motors are kept.

    Args:
        press: the linkage, which has passive coordinates.
        engine: of the linkage.
        states: closed states.
        loads: forces on links.
        law: friction of the bearings, viscous only; None for none.

    Raises:
        PinpressError: friction that depends on bearing forces; a passive coordinate without inertia.
    """
    if law is not None and law.arm.any():
        raise PinpressError(
            f"{press.name} has passive coordinates ({', '.join(press.passive)}), whose accelerations depend on Coulomb friction and it on"
            " them: leave the coefficient out (viscous friction is taken), or give all accelerations, passive='given'"
        )
    a = np.empty_like(states.a)
    for start in range(0, a.shape[1], engine.piece):
        piece = slice(start, start + engine.piece)
        a[:, piece] = _free_piece(press, engine, states.part(piece), [load.part(piece) for load in loads], law, start)
    return ClosedStates(states.position, states.v, a, states.basis, states.solved)


def _free_piece(
    press: Linkage, engine: Engine, states: ClosedStates, loads: Sequence[AppliedForce], law: FrictionLaw | None, start: int
) -> Array:
    """Joint accelerations (nv, n) of `free_accelerations` in the states from ``start`` on."""
    count, n, position = len(press.drivers), states.v.shape[1], states.position
    first, still = len(press.motors), np.zeros((count, n))
    rates, solved = [], None
    for k in range(first, count):
        unit = still.copy()
        unit[k] = 1.0
        found = engine.rates(position, unit, still)
        rates.append(found.v)
        solved = found.solved
    by = np.array(rates)  # (passive, nv, n)

    def efforts(a: Array) -> Array:
        """(passive, n) that accelerations (nv, n) need at the passive coordinates."""
        moving = ClosedStates(position, states.v, a, states.basis, solved)
        conditions = AppliedConditions(list(loads), law, None, joint_efforts(press, engine, moving))
        return inverse_dynamics(engine, moving, conditions, bearings=False).torque[first:]

    a, needed = states.a, efforts(states.a)
    columns = [(efforts(a + PROBE * way) - needed) / PROBE for way in by]
    mass = np.array(columns).transpose(2, 1, 0)  # (n, passive, passive)
    _refuse_without_inertia(press, mass, start)
    for _ in range(3):  # the first step finds them, the others take off what rounding of the mass matrix has left
        step = np.linalg.solve(mass, -needed.T[:, :, None])[:, :, 0]
        a = a + np.einsum("nk,kjn->jn", step, by)
        needed = efforts(a)
    return a


def _refuse_without_inertia(press: Linkage, mass: Array, first: int) -> None:
    """Raise PinpressError where a motion of the passive coordinates alone moves no mass; ``mass``: (n, passive, passive), from the state
    ``first`` on."""
    units = press.lengths[list(press.driver_indices[len(press.motors) :])]
    scaled = mass * np.multiply.outer(units, units)
    values, ways = np.linalg.eigh(0.5 * (scaled + scaled.transpose(0, 2, 1)))
    heavy = float(np.max([press.size**2 * inertia.mass + np.abs(inertia.inertia).max() for inertia in press.model.inertias]))
    light = ~(values[:, 0] > WITHOUT_INERTIA * heavy)
    if light.any():
        state = int(np.argmax(light))
        moving = press.passive[int(np.abs(ways[state, :, 0]).argmax())] if np.isfinite(ways[state]).all() else press.passive[0]
        problem = f"passive coordinate {moving!r} of {press.name} moves no mass in state {first + state}, so that nothing determines its"
        remedy = "give its link an inertia, or name the joint as a driver"
        if moving in press.base:
            remedy = "the base is near a quarter turn about its y there, where its three turns are not independent; keep away from it"
        raise PinpressError(f"{problem} acceleration: {remedy}")
