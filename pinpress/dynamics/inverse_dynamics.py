"""Inverse dynamics: the driving torque and every bearing and guide force of a motion."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from ..common.arguments import typed
from ..common.errors import PinpressError, SingularityError, UnknownNameError, caution, shown
from ..common.frozen import FrozenMapping, NamedArrays
from ..engines.branch import Branch
from ..engines.change_points import at_change_point
from ..engines.engine import Engine
from ..engines.machine_elements.cams import CamContact
from ..engines.sharing import compliances
from ..engines.wrenches import AppliedConditions, Wrenches
from ..kinematics.motion import Motion, accelerated, blank, filled, refuse_other_joints, with_gaps_of
from ..linkage.linkage import Linkage
from ..loads.link import Friction, Load
from ..loads.link import law as friction_law
from . import applied_loads
from .equilibrium import equilibrium
from .passive import free_accelerations
from .reactions import Reactions, carrying, find_wrenches

NONE_GIVEN: Mapping[str, Any] = FrozenMapping({})
PASSIVE = ("free", "given", "equilibrium")
ROUNDED = 1e-9  # share of the largest effort of a cam that is rounding error
CLEAR = 1e-3  # distance from the end of a branch from which on a state is at no change point [rad]
T = TypeVar("T")


@typed
def inverse_dynamics(
    press: Linkage,
    motion: Motion,
    loads: Sequence[Load] = (),
    friction: Mapping[str, Friction] = NONE_GIVEN,
    stiffness: Mapping[str, float] = NONE_GIVEN,
    engine: str = "auto",
    bearings: Collection[str] | None = None,
    passive: str = "free",
) -> Reactions:
    """Find the driving torque, the forces of bearings and guides, and the shaking force of a motion.

    Args:
        press: the press.
        motion: its motion, from `cycle`, `servo_cycle` or `simulate`. In states that are not `Motion.valid` all results are NaN.
        loads: forces on links from outside, springs and dampers between links, process loads.
        friction: friction of bearings and guides, by their names.
        stiffness: stiffnesses of bearings and guides, by their names [N/m]. Where rigid mechanics leaves open how bearings share a force,
            it is then shared with the least elastic energy (bearings without a stiffness count as rigid) instead of the least sum of
            squared bearing forces.
        engine: "plane" (a planar linkage), "space" (any linkage), "pinocchio" (any, by Pinocchio's own algorithms, one configuration at
            a time), or "auto": "plane" where the linkage is planar, else "space".
        bearings: names of the bearings and guides whose force and moment are wanted; by default all, ``()`` for none. Torques, friction
            power and shaking force are available in any case. Leaving out all bearings saves time where there is no friction; leaving out
            some saves none. Results are those of all bearings.
        passive: what the passive coordinates of the linkage do, if it has some (`Linkage.passive`): "free": in each state their positions
            and speeds are those of the motion, and their accelerations follow from the forces (`Reactions.motion` has them), with no
            drive there; "given": the motion is as given, and the drivers' efforts there are what holds it, such as force and moment on a
            base; "equilibrium": positions, speeds and accelerations are those of static equilibrium with weights, springs and constant
            forces, at the positions of the motors (`dynamics.equilibrium` says how), whatever the motion has there. The drivers' efforts
            there are then what inertia forces would need to keep it.

    Raises:
        PinpressError: a motion of a linkage with other joints; passive coordinates that have no inertia, or no stable equilibrium; a load
            of wrong shape, with a value that is not finite, or whose function fails; friction that makes no sense or locks the linkage; a
            stiffness that is not positive; ``bearings`` that are not names; forces too large for floating point; an unknown or unsuitable
            engine.
        UnknownNameError: a bearing or link that the linkage does not have.
        AssemblyError: a motion of a linkage with other lengths.
        SingularityError: a state of a simulated run at a change point.

    Warns:
        PinpressWarning: the roller of a cam leaves it.
    """
    refuse_other_joints(press, motion)
    chosen = press.engine(engine)
    indices = _select_bearings(press, bearings)
    if not isinstance(passive, str) or passive not in PASSIVE:
        raise PinpressError(f"passive is {shown(passive)}: write {', '.join(map(repr, PASSIVE))}")
    asked, motion = motion, filled(press, motion)
    _refuse_change_points(press, motion)
    law, compliance = friction_law(friction, press), compliances(stiffness, press.bearings)
    checked_loads = applied_loads.wrap_laws(loads)
    with np.errstate(all="ignore"):  # what overflows is refused
        if press.passive and passive == "equilibrium":
            motion = equilibrium(press, chosen, motion, loads)
        conditions = AppliedConditions(applied_loads.apply(checked_loads, press, motion), law, compliance)
        motion, conditions = _move_passive(press, chosen, motion, conditions, passive)
        wrenches = find_wrenches(press, chosen, motion, conditions, bearings=bool(indices))
    if indices:
        _doubt_cams(press, motion, wrenches)
    inputs = (tuple(loads), _freeze(friction), _freeze(stiffness), passive)
    return _reactions(press, with_gaps_of(press, motion, asked), chosen.name, conditions, indices, wrenches, inputs)


def _doubt_cams(press: Linkage, motion: Motion, wrenches: Wrenches) -> None:
    """Warn of rollers that would leave their cams, so that the forces are not those of the press."""
    for cam in (contact for contact in press.contacts if isinstance(contact, CamContact) and not contact.grooved):
        effort = cam.sense * wrenches.relations[cam.relation]
        least = int(effort.argmin())
        if effort[least] < -ROUNDED * np.abs(effort).max():
            problem = f"{press.name}: its roller leaves the cam {cam.name!r} at {motion.place(least)}, where the cam would have to pull it"
            caution(f"{problem}: press the roller on by a spring or a load, lower the speed, or write kind groove")


def _move_passive(
    press: Linkage, engine: Engine, motion: Motion, conditions: AppliedConditions, passive: str
) -> tuple[Motion, AppliedConditions]:
    """The motion with the accelerations that its passive coordinates have under these loads, and what then acts."""
    if press.passive and passive == "free":
        states = free_accelerations(press, engine, motion.states(press), conditions.loads, conditions.law)
        motion = accelerated(press, motion, states)
    efforts = applied_loads.joint_efforts(press, engine, motion.states(press))
    return motion, conditions if efforts is None else conditions._replace(efforts=efforts)


def in_other_states(reactions: Reactions, motion: Motion) -> Reactions:
    """Reactions under the same loads, friction and stiffness in other states of the same press, of which nobody is warned."""
    press, conditions = reactions._press, reactions._conditions
    indices = [k for k, name in enumerate(carrying(press)) if name in reactions.bearing_force]
    with np.errstate(all="ignore"):  # what overflows is refused
        loads = applied_loads.apply(applied_loads.wrap_laws(reactions.loads), press, motion, warned=True)
        conditions = conditions._replace(loads=loads)
        motion, conditions = _move_passive(press, press.engine(reactions.engine), motion, conditions, reactions.passive)
        wrenches = find_wrenches(press, press.engine(reactions.engine), motion, conditions, bearings=bool(indices))
    inputs = (reactions.loads, reactions.friction, reactions.stiffness, reactions.passive)
    return _reactions(press, motion, reactions.engine, conditions, indices, wrenches, inputs)


def _freeze(mapping: Mapping[str, T]) -> Mapping[str, T]:
    return mapping if isinstance(mapping, FrozenMapping) else FrozenMapping(mapping)


def _reactions(
    press: Linkage,
    motion: Motion,
    engine: str,
    conditions: AppliedConditions,
    indices: Sequence[int],
    wrenches: Wrenches,
    inputs: tuple[tuple[Load, ...], Mapping[str, Friction], Mapping[str, float], str],
) -> Reactions:
    """The wrenches that an engine has found, by the names of the wanted bearings; ``given``: loads, friction and stiffness."""
    names, several = carrying(press), len(press.drivers) > 1
    kept = names if len(indices) == len(names) else tuple(names[k] for k in indices)
    left_out = tuple(name for name in names if name not in kept) if len(kept) < len(names) else ()
    forces, moments = (blank(motion, each[: len(names)], 1) for each in (wrenches.force, wrenches.moment))
    if 0 < len(kept) < len(names):
        forces, moments = forces[list(indices)], moments[list(indices)]
    wrenches.torque.setflags(write=False)  # before there are views of it
    torque = blank(motion, wrenches.torque, 1)
    return Reactions(
        motion=motion,
        engine=engine,
        loads=inputs[0],
        friction=inputs[1],
        stiffness=inputs[2],
        passive=inputs[3],
        driving_torque=torque.T if several else torque[0],
        bearing_force=NamedArrays(kept, forces, left_out),
        bearing_moment=NamedArrays(kept, moments, left_out),
        friction_power=NamedArrays(names, blank(motion, wrenches.friction[: len(names)], 1)),
        left_out=left_out,
        _wrenches=wrenches,
        _press=press,
        _conditions=conditions,
    )


def _refuse_change_points(press: Linkage, motion: Motion) -> None:
    """Raise SingularityError where a state of a run is at a change point: towards it the forces of rigid links grow without bounds."""
    if len(press.drivers) > 1:
        return
    branch = press.branch
    # A crank that turns fully meets none. Else a motion that stays clear of the locks meets none, and then none need be looked for, which
    # would take as long as walking the branch.
    if branch.period is not None or _between_locks(branch, motion) or not press.branch_through_change_points.change_points:
        return
    at = at_change_point(press.branch_through_change_points.change_points, press.branch_through_change_points.period, motion.crank_angle)
    if at is not None:
        angle = float(motion.crank_angle[at])
        raise SingularityError(
            f"bearing forces have no value at the change point of {motion.linkage}, where they grow without bounds: leave this state out",
            angle,
            0.0,
            press.driver_coordinates[0].at(angle),
        )


def _between_locks(branch: Branch, motion: Motion) -> bool:
    """Whether a motion stays clear of the ends of the branch that has no change points."""
    angles, crank = branch.angles, motion.crank_angle
    return bool(angles[0] + CLEAR < crank.min() and crank.max() < angles[-1] - CLEAR)


def _select_bearings(press: Linkage, bearings: Collection[str] | None) -> Sequence[int]:
    """Rising indices of the wanted ones among `carrying`; raises as `inverse_dynamics`."""
    names = carrying(press)
    if bearings is None:
        return range(len(names))
    if isinstance(bearings, str) or not isinstance(bearings, Collection):
        raise PinpressError(
            f"bearings is {shown(bearings)}: give a list of names, e.g. [{shown(press.bearings[0])}], or () for the driving torque alone"
        )
    for name in bearings:
        if not isinstance(name, str) or name not in names:
            raise UnknownNameError("bearing", name, names)
    return [k for k, name in enumerate(names) if name in bearings]
