"""Inverse dynamics of linkages in space, all configurations at once: driving torque and the wrenches of the bearings.

The forces of the open tree are sums over the bodies that a joint carries. The multipliers of the equations balance the efforts of its
passive joints; what they leave open is shared as `engines.sharing` says. A bearing's force is that of the open tree less the loop forces
that cross it. Pinocchio's engine has equations and forces of the open tree by its own algorithms, and all else from here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.quantities import Array
from ..body_motion import components_first, cross
from ..engine import LOOSEST, ClosedStates, other_linkage
from ..friction import FrictionLaw
from ..sharing import Shared, share
from ..wrenches import AppliedConditions, AppliedForce, BearingLoads, Idle, Wrenches
from .bodies import Placements, accelerations, inertia_forces, motion_axes, sum_carried, velocities
from .closing import PassiveColumns
from .equations import AT_ONCE, Equations, Kinematics, Loops, loop_turning


class OpenTree(NamedTuple):
    """Forces of the tree with all loops open, in world axes.

    Attributes:
        effort: (nv, n) of the joints about or along their axes [N m or N].
        force: (nv, 3, n) of the joints [N].
        moment: (nv, 3, n) of the joints about their origins [N m].
    """

    effort: Array
    force: Array
    moment: Array


class Method(NamedTuple):
    """How equations and forces of the open tree are computed.

    Attributes:
        kinematics: of the equations.
        open_tree: of constants, equations at closed states, these states and the loads.
    """

    kinematics: Kinematics
    open_tree: Callable[[Loops, Equations, ClosedStates, Sequence[AppliedForce]], OpenTree]


def inverse_dynamics(loops: Loops, states: ClosedStates, conditions: AppliedConditions, bearings: bool, by: Method) -> Wrenches:
    """Driving torque and the wrenches of joints and loops; see `Engine.inverse_dynamics`."""
    structure, n, law = loops.structure, states.v.shape[1], conditions.law
    result = Wrenches.zeros(len(structure.drivers), len(structure.relations), structure.model.nv + len(structure.loops), n, bearings)
    pieces = [slice(start, start + loops.piece) for start in range(0, n, loops.piece)]
    fastest = None if law is None or len(pieces) == 1 else law.moving(_speeds(loops, states, pieces, by))
    for piece in pieces:
        part = states if len(pieces) == 1 else states.part(piece)
        acting = conditions.part(piece)
        balance = _Balance(loops, part, acting.loads, conditions.compliance, by, acting.efforts)
        if law is None:
            friction = balance.known_friction(acting.friction)
            multipliers = balance.multipliers(friction, shared=bearings)
        else:
            speeds = law.moving(balance.speeds()) if fastest is None else fastest[:, piece]
            multipliers, friction, lost = balance.with_friction(law, speeds)
            result.friction[:, piece] = lost
        balance.fill(result.part(piece), multipliers, friction, bearings)
    return result


def bearing_loads(loops: Loops, states: ClosedStates, conditions: AppliedConditions, rates: Array, by: Method) -> BearingLoads:
    """See `Engine.bearing_loads`."""
    n, structure = states.v.shape[1], loops.structure
    speed, relations = np.empty((structure.model.nv + len(structure.loops), n)), np.empty((len(structure.relations), n))
    radial = np.empty((*speed.shape, 3))
    for start in range(0, n, loops.piece):
        piece = slice(start, start + loops.piece)
        acting = conditions.part(piece)
        balance = _Balance(loops, states.part(piece), acting.loads, acting.compliance, by, acting.efforts)
        speed[:, piece], directions = balance.ways(rates[:, piece])
        multipliers = balance.multipliers(balance.known_friction(acting.friction, directions))
        radial[:, piece] = balance.radial(multipliers, directions).transpose(0, 2, 1)
        relations[:, piece] = balance.efforts_of_relations(multipliers)
    return BearingLoads(speed, radial, relations)


def idle_forces(loops: Loops, position: Array, by: Method) -> Idle:
    """The idle forces at positions (nv, n); see `Engine.idle`."""
    structure, n = loops.structure, position.shape[1]
    parts, units = [], structure.relation_units
    for start in range(0, n, loops.piece):
        equations = by.kinematics.equations(loops, position[:, start : start + loops.piece])
        for part in PassiveColumns(loops, equations.entries, by.kinematics.in_blocks).parts:
            if part.idle.shape[2] and len(part.idle):
                parts.append((np.arange(start, min(start + loops.piece, n))[part.states], equations, part))
    count = max((part.idle.shape[2] for _, _, part in parts), default=0)
    relations = np.zeros((count, len(units), n))
    force, moment = np.zeros((2, count, structure.model.nv + len(structure.loops), n, 3))
    for states, equations, part in parts:
        idle = _configurations_last(part.idle)
        forces, moments = _loop_wrenches(loops, equations, part.states, idle)
        relations[: len(idle), :, states] = units[:, None] * idle[:, loops.rows - len(units) :]
        force[: len(idle), :, states] = _forces_of_bearings(loops, forces).transpose(0, 1, 3, 2)
        moments = _moments_of_bearings(loops, equations, part.states, forces, moments)
        moment[: len(idle), :, states] = moments.transpose(0, 1, 3, 2)
    return Idle(relations, force, moment)


def indeterminate(loops: Loops, position: Array, axes: Array, by: Method) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Force and moment components (bearings, 6) along the rows of ``axes`` (3, 3), and efforts of relations (nr,), that idle forces
    change in any of the positions (nv, n); see `Engine.indeterminate`."""
    structure, idle = loops.structure, idle_forces(loops, position, by)
    parts = [np.einsum("ai,kbni->kbna", axes, vectors) / unit for vectors, unit in ((idle.force, 1.0), (idle.moment, structure.size))]
    reached = np.abs(np.concatenate(parts, axis=3)).max(axis=(0, 2), initial=0.0)
    efforts = np.abs(idle.relations).max(axis=(0, 2), initial=0.0) / structure.relation_units
    return reached > structure.rank_tolerance, efforts > structure.rank_tolerance


def _open_tree(loops: Loops, equations: Equations, states: ClosedStates, loads: Sequence[AppliedForce]) -> OpenTree:
    """Forces of the open tree as sums over the bodies that each joint carries."""
    bodies, placed = loops.bodies, equations.placed
    axes = motion_axes(bodies, placed)
    moved = velocities(bodies, axes, states.v)
    needed = inertia_forces(bodies, placed, moved, accelerations(bodies, axes, moved, states.v, states.a))
    carried = components_first(*states.v.shape, 2)
    carried[0], carried[1] = needed.force, needed.couple
    carried[1] += cross(needed.center, needed.force)
    for load in loads:
        if load.joint:
            force = load.force.T
            carried[0, load.joint - 1] -= force
            carried[1, load.joint - 1] -= cross(placed.point(load.joint, load.point), force)
            if load.moment is not None:
                carried[1, load.joint - 1] -= load.moment.T
    sum_carried(bodies, carried)
    force, moment = carried
    moment -= cross(placed.origin[1:], force)  # about the joints' origins
    along = moment if bodies.turns.all() else np.where(bodies.turns[:, None, None], moment, force)
    return OpenTree(np.einsum("jin,jin->jn", placed.axis, along), force, moment)


IN_SPACE = Method(AT_ONCE, _open_tree)


class _Friction(NamedTuple):
    """Friction of the bearings: efforts (nv, n) of the joints [N m or N] and moments (nl, 3, n) of the loops in world axes [N m]."""

    efforts: Array
    couples: Array


class _Balance:
    """States under their loads: the efforts of the open tree, and the multipliers of the equations that balance them."""

    def __init__(
        self,
        loops: Loops,
        states: ClosedStates,
        loads: Sequence[AppliedForce],
        compliance: Array | None,
        by: Method,
        efforts: Array | None = None,
    ) -> None:
        """Work out the forces of the open tree.

        Args:
            loops: constants of the linkage.
            states: closed states.
            loads: forces on links.
            compliance: (bearings,) as in `AppliedConditions`.
            by: how equations and forces of the open tree are computed.
            efforts: (nv, n) as in `AppliedConditions`.

        Raises:
            AssemblyError: a state leaves the loops open, because it belongs to another linkage.
        """
        self.loops, self.states, self.compliance = loops, states, compliance
        self.sharing: list[Shared] | None = None
        self.count, self.n = states.v.shape
        if states.solved is None or not by.kinematics.in_blocks:
            self.equations = by.kinematics.equations(loops, states.position)
            self._refuse_open(self.equations)
            self.passive = PassiveColumns(loops, self.equations.entries, by.kinematics.in_blocks)
        else:
            self.equations, self.passive = states.solved
        self.effort, self.force, self.moment = by.open_tree(loops, self.equations, states, loads)
        if efforts is not None:  # the drives need not supply them
            self.effort = self.effort - efforts
        self.size = loops.structure.size

    def _refuse_open(self, equations: Equations) -> None:
        structure = self.loops.structure
        wrong = ~(np.abs(equations.gaps).max(axis=0, initial=0.0) <= max(LOOSEST * structure.size, structure.tolerance))
        if wrong.any():
            i = int(np.argmax(wrong))
            gap = float(equations.widest()[i])
            raise other_linkage(float(self.states.position[structure.drivers[0], i]), gap, structure.place(self.states.position[:, i]))

    # -------------------------------------------------------------------------------------------------------------------- friction

    def friction(self, efforts: Array, directions: Array) -> _Friction:
        """Friction of efforts (bearings, n) about directions (bearings, 3, n)."""
        return _Friction(efforts[: self.count], efforts[self.count :, None] * directions[self.count :])

    def known_friction(self, efforts: Array | None, directions: Array | None = None) -> _Friction:
        """Friction of efforts (bearings, n) that are known, None for none; ``directions``: None for those of the states' own motion."""
        if efforts is None:
            return _Friction(np.zeros_like(self.states.v), np.zeros((len(self.loops.structure.loops), 3, self.n)))
        return self.friction(efforts, self.ways(self.states.v)[1] if directions is None else directions)

    def speeds(self) -> Array:
        """Speeds (bearings, n) of all bearings, those of loops as of `loop_turning`."""
        return _all_speeds(self.loops, self.equations.placed, self.states.v)

    def ways(self, rates: Array) -> tuple[Array, Array]:
        """Speeds (bearings, n) at joint rates (nv, n), and the axes (bearings, 3, n) about or along which the bearings move, world axes;
        those of loops as of `loop_turning`."""
        speeds, axes = loop_turning(self.loops, self.equations.placed, rates)
        directions = components_first(self.count + len(speeds), self.n)
        directions[: self.count], directions[self.count :] = self.equations.placed.axis, axes
        return np.concatenate([rates, speeds]), directions

    def with_friction(self, law: FrictionLaw, speeds: Array) -> tuple[Array, _Friction, Array]:
        """Multipliers (rows, n), friction, and the power lost (bearings, n) [W].

        Args:
            law: friction of the bearings.
            speeds: (bearings, n) of the bearings, zero where they are rounding.

        Raises:
            PinpressError: friction locks the linkage.
        """
        _, directions = self.ways(self.states.v)
        directions[self.count :] *= (speeds[self.count :] != 0)[:, None]

        def radial(efforts: Array) -> Array:
            vectors = self.radial(self.multipliers(self.friction(efforts, directions)), directions)
            return np.asarray(np.sqrt(np.einsum("bin,bin->bn", vectors, vectors)))

        structure = self.loops.structure
        efforts = law.efforts(speeds, radial, lambda state: structure.place(self.states.position[:, state]))
        friction = self.friction(efforts, directions)
        return self.multipliers(friction), friction, -efforts * speeds

    def radial(self, multipliers: Array, directions: Array) -> Array:
        """Vectors (bearings, 3, n) across the axes of the bearings, whose lengths are the radial forces [N]."""
        return cross(self._forces(multipliers), directions)

    def efforts_of_relations(self, multipliers: Array) -> Array:
        """Efforts (relations, n) on the joints that the relations determine."""
        units = self.loops.structure.relation_units
        return np.asarray(units[:, None] * multipliers[self.loops.rows - len(units) :])

    def _forces(self, multipliers: Array) -> Array:
        """Forces (bearings, 3, n) of all bearings [N], from multipliers (rows, n)."""
        forces: Array = _forces_of_bearings(self.loops, _loop_forces(self.loops, multipliers[None]))[0]
        forces[: self.count] += self.force
        return forces

    def _moments(self, multipliers: Array, friction: _Friction) -> Array:
        """Moments (bearings, 3, n) of all bearings [N m], from multipliers (rows, n)."""
        forces, moments = _loop_wrenches(self.loops, self.equations, slice(None), multipliers[None])
        moments += friction.couples
        result: Array = _moments_of_bearings(self.loops, self.equations, slice(None), forces, moments)[0]
        result[: self.count] += self.moment
        return result

    # ----------------------------------------------------------------------------------------------------------------- multipliers

    def multipliers(self, friction: _Friction, shared: bool = True) -> Array:
        """Multipliers (rows, n) of the equations.

        Args:
            friction: of the bearings.
            shared: whether to share idle forces as `engines.sharing` says; else they are those of least norm, which give the same
                driving torque.
        """
        result = self.passive.multipliers(self._needed(friction))
        if not shared:
            return result
        if self.sharing is None:
            self.sharing = list(self._share())
        starts = list(islice(self._starts(result, friction), max((sharing.objectives for sharing in self.sharing), default=0)))
        for sharing in self.sharing:
            result[:, sharing.states] += sharing.added(starts)
        return result

    def _share(self) -> Iterator[Shared]:
        for part in self.passive.parts:
            if part.idle.shape[2] and len(part.idle):
                idle = _configurations_last(part.idle)
                yield share(part.states, idle, self._objectives(idle, part.states), self.loops.structure.rank_tolerance)

    def _objectives(self, idle: Array, states: NDArray[np.intp] | slice) -> Iterator[tuple[Array, float]]:
        """The objectives (k, bearings, 3, m) by which multiples of idle multipliers (k, rows, m) of some states are chosen, and their
        scales, see `Objective`. The generator works out the next one only where the ones before leave something open."""
        loop_forces, loop_moments = _loop_wrenches(self.loops, self.equations, states, idle)
        forces = self._across(_forces_of_bearings(self.loops, loop_forces), states, turning=False)
        if self.compliance is not None:
            weights = np.sqrt(self.compliance)
            yield weights[:, None, None] * forces, float(weights.max())
        yield forces, 1.0
        moments = _moments_of_bearings(self.loops, self.equations, states, loop_forces, loop_moments)
        yield self._across(moments, states, turning=True), self.size

    def _starts(self, multipliers: Array, friction: _Friction) -> Iterator[Array]:
        """What the objectives minimise, (bearings, 3, n), without idle multipliers, in the order of `_objectives`."""
        every = slice(None)
        forces = self._across(self._forces(multipliers)[None], every, turning=False)[0]
        if self.compliance is not None:
            yield np.sqrt(self.compliance)[:, None, None] * forces
        yield forces
        yield self._across(self._moments(multipliers, friction)[None], every, turning=True)[0]

    def _across(self, vectors: Array, states: NDArray[np.intp] | slice, turning: bool) -> Array:
        """Vectors (k, bearings, 3, m) without their components along the axes of the joints that turn, or of those that slide."""
        joints = np.flatnonzero(self.loops.bodies.turns == turning)
        if len(joints):
            axis, vectors_of_joints = self.equations.placed.axis[joints][..., states], vectors[:, joints]
            vectors[:, joints] = vectors_of_joints - axis * np.einsum("jim,kjim->kjm", axis, vectors_of_joints)[:, :, None]
        return vectors

    def _needed(self, friction: _Friction) -> Array:
        """Efforts (nv, n) that loops, relations and drives have to supply: those of the open tree less friction."""
        needed: Array = self.effort - friction.efforts
        if friction.couples.any():
            loops = self.loops
            shares = np.einsum("pin,pin->pn", self.equations.placed.axis[loops.pair_joint], friction.couples[loops.pair_loop])
            for pair, (_, joint, change) in enumerate(loops.pairs):
                if loops.bodies.turns[joint]:
                    change(needed[joint], shares[pair], out=needed[joint])
        return needed

    # -------------------------------------------------------------------------------------------------------------------- result

    def fill(self, result: Wrenches, multipliers: Array, friction: _Friction, bearings: bool) -> None:
        """Write the wrenches of these states into the result."""
        driving = list(self.loops.structure.drivers)
        result.torque[:] = self._needed(friction)[driving] - np.einsum("rdn,rn->dn", self.equations.driving, multipliers)
        result.relations[:] = self.efforts_of_relations(multipliers)
        if bearings:
            result.force[:] = self._forces(multipliers).transpose(0, 2, 1)
            result.moment[:] = self._moments(multipliers, friction).transpose(0, 2, 1)


def _speeds(loops: Loops, states: ClosedStates, pieces: Sequence[slice], by: Method) -> Array:
    """Speeds (bearings, n) of all bearings, those of loops as of `loop_turning`."""
    parts = ((by.kinematics.equations(loops, states.position[:, piece]).placed, states.v[:, piece]) for piece in pieces)
    return np.concatenate([_all_speeds(loops, *part) for part in parts], axis=1)


def _all_speeds(loops: Loops, placed: Placements, v: Array) -> Array:
    return np.concatenate([v, loop_turning(loops, placed, v)[0]])


# --------------------------------------------------------------------------------------------- what multipliers are as forces and moments


def _configurations_last(idle: Array) -> Array:
    """(k, rows, m) of idle multipliers (m, rows, k)."""
    return np.ascontiguousarray(idle.transpose(2, 1, 0))


def _loop_forces(loops: Loops, multipliers: Array) -> Array:
    """Forces (k, nl, 3, m) of the loops from multipliers (k, rows, m)."""
    count = len(loops.structure.loops)
    return multipliers[:, : 3 * count].reshape(len(multipliers), count, 3, multipliers.shape[2])


def _loop_wrenches(loops: Loops, equations: Equations, states: NDArray[np.intp] | slice, multipliers: Array) -> tuple[Array, Array]:
    """Forces and moments (k, nl, 3, m) of the loops from multipliers (k, rows, m)."""
    forces = _loop_forces(loops, multipliers)
    moments, row = np.zeros_like(forces), 3 * forces.shape[1]
    for index, loop in enumerate(loops.structure.loops):
        if loop.held_rotations:
            own = multipliers[:, row : row + loop.held_rotations]
            moments[:, index] = loops.structure.size * np.einsum("ihm,khm->kim", equations.held[index][:, :, states], own)
            row += loop.held_rotations
    return forces, moments


def _forces_of_bearings(loops: Loops, forces: Array) -> Array:
    """What forces (k, nl, 3, m) of the loops add to the forces (k, bearings, 3, m) of joints and loops."""
    result = _at_bearings(loops, forces)
    for loop, joint, change in loops.pairs:
        change(result[:, joint], forces[:, loop], out=result[:, joint])
    return result


def _moments_of_bearings(loops: Loops, equations: Equations, states: NDArray[np.intp] | slice, forces: Array, moments: Array) -> Array:
    """What forces and moments (k, nl, 3, m) of the loops add to the moments (k, bearings, 3, m) of joints, about their origins, and
    loops."""
    result = _at_bearings(loops, moments)
    arms = equations.ends[0][loops.pair_loop] - equations.placed.origin[loops.pair_joint + 1]
    turning = cross(arms[..., states], forces[:, loops.pair_loop])
    turning += moments[:, loops.pair_loop]
    for pair, (_, joint, change) in enumerate(loops.pairs):
        change(result[:, joint], turning[:, pair], out=result[:, joint])
    return result


def _at_bearings(loops: Loops, vectors: Array) -> Array:
    """Vectors (k, nl, 3, m) of the loops as those of all bearings (k, bearings, 3, m), zero of joints."""
    (k, _, _, m), count = vectors.shape, len(loops.bodies.parents)
    result = components_first(count + vectors.shape[1], m, k)
    result[:, :count], result[:, count:] = 0.0, vectors
    return result
