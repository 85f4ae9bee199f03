"""Inverse dynamics of linkages in space, all configurations at once: driving torque and the wrenches of the bearings.

The forces of the open tree are sums over the bodies that a joint carries. The multipliers of the equations balance the efforts of its
passive joints; what they leave open is shared as `engines.forces` says. A bearing's force is that of the open tree less the loop forces
that cross it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.quantities import Array
from ..engine import LOOSEST, ClosedStates, other_linkage
from ..forces import RANK, AppliedConditions, AppliedForce, BearingLoads, FrictionLaw, Objective, Wrenches, lexicographic_least_squares
from ..joints import product
from .bodies import accelerations, components_first, cross, inertia_forces, motion_axes, sum_carried, velocities
from .closing import PassiveColumns
from .equations import Equations, Loops, equations, loop_spins


def inverse_dynamics(loops: Loops, states: ClosedStates, conditions: AppliedConditions, wanted: Sequence[int]) -> Wrenches:
    """Driving torque and the wrenches of joints and loops; see `Engine.inverse_dynamics`."""
    spatial, n, law = loops.spatial, states.v.shape[1], conditions.law
    result = Wrenches.zeros(len(spatial.drivers), len(spatial.couplings), spatial.model.nv + len(spatial.loops), n, len(wanted))
    speeds = None if law is None else law.moving(_speeds(loops, states.position, states.v))
    for start in range(0, n, loops.piece):
        some = slice(start, start + loops.piece)
        balance = _Balance(loops, states if n <= loops.piece else states.part(some), [load.part(some) for load in conditions.loads])
        if law is None or speeds is None:
            # the driving torque does not depend on how idle forces are shared
            shared = bool(wanted or (conditions.with_gear_torques and spatial.couplings))
            friction = balance.no_friction()
            multipliers = balance.multipliers(friction, conditions.compliance, shared)
        else:
            multipliers, friction, lost = balance.with_friction(law, speeds[:, some], conditions.compliance)
            result.friction[:, some] = lost
        balance.fill(result.part(some), multipliers, friction, wanted)
    return result


def bearing_loads(loops: Loops, states: ClosedStates, loads: Sequence[AppliedForce], efforts: Array, rates: Array) -> BearingLoads:
    """See `Engine.bearing_loads`; the speeds of loops are magnitudes."""
    n = states.v.shape[1]
    speed, radial = np.empty_like(efforts), np.empty((*efforts.shape, 3))
    for start in range(0, n, loops.piece):
        some = slice(start, start + loops.piece)
        balance = _Balance(loops, states.part(some), [load.part(some) for load in loads])
        speed[:, some], directions = balance.ways(rates[:, some])
        multipliers = balance.multipliers(balance.friction(efforts[:, some], directions), None)
        radial[:, some] = balance.radial(multipliers, directions).transpose(0, 2, 1)
    return BearingLoads(speed, radial)


def indeterminate(loops: Loops, position: Array, axes: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Force and moment components (bearings, 6) along the rows of ``axes`` (3, 3), and coupling torques (nc,), that idle forces change in
    any of the positions (nv, n); see `Engine.indeterminate`."""
    spatial = loops.spatial
    marks, couplings = np.zeros((spatial.model.nv + len(spatial.loops), 6), dtype=bool), np.zeros(len(spatial.couplings), dtype=bool)
    for start in range(0, position.shape[1], loops.piece):
        found = equations(loops, position[:, start : start + loops.piece])
        for part in PassiveColumns(loops, found.entries).parts:
            if not part.idle.shape[2] or not len(part.idle):
                continue
            forces, moments, _ = _parts(loops, found, part.states, part.idle)
            for place, vectors, unit in (
                (0, _of_bearings(loops, forces), 1.0),
                (3, _moments(loops, found, part.states, forces, moments), spatial.size),
            ):
                marks[:, place : place + 3] |= np.abs(np.einsum("ai,mbik->mbak", axes, vectors)).max(axis=(0, 3)) > RANK * unit
            couplings |= np.abs(part.idle[:, loops.rows - len(couplings) :]).max(axis=(0, 2)) > RANK
    return marks, couplings


class _Friction(NamedTuple):
    """Friction of the bearings.

    Attributes:
        efforts: (nv, n) of the joints [N m or N].
        couples: (nl, 3, n) moments of the loops, world axes [N m].
    """

    efforts: Array
    couples: Array


class _Balance:
    """States under their loads: the efforts of the open tree, and the multipliers of the equations that balance them."""

    def __init__(self, loops: Loops, states: ClosedStates, loads: Sequence[AppliedForce]) -> None:
        """Work out the forces of the open tree.

        Raises:
            AssemblyError: a state leaves the loops open, because it belongs to another linkage.
        """
        self.loops, self.states = loops, states
        spatial, bodies = loops.spatial, loops.bodies
        self.count, self.n = states.v.shape
        if states.solved is None:
            self.found = equations(loops, states.position)
            self._refuse_open(self.found)
            self.passive = PassiveColumns(loops, self.found.entries)
        else:
            self.found, self.passive = states.solved
        found = self.found
        placed = found.placed
        axes = motion_axes(bodies, placed)
        moved = velocities(bodies, axes, states.v)
        needed = inertia_forces(bodies, placed, moved, accelerations(bodies, axes, moved, states.v, states.a))
        carried = components_first(self.count, self.n, 2)
        carried[0], carried[1] = needed.force, needed.couple
        carried[1] += cross(needed.center, needed.force)
        for load in loads:
            if load.joint:
                force = load.force.T
                carried[0, load.joint - 1] -= force
                carried[1, load.joint - 1] -= cross(placed.point(load.joint, load.point), force)
        sum_carried(bodies, carried)
        self.force, self.moment = carried
        self.moment -= cross(placed.origin[1:], self.force)  # about the joints' origins
        along = self.moment if bodies.turns.all() else np.where(bodies.turns[:, None, None], self.moment, self.force)
        self.effort = np.einsum("jin,jin->jn", placed.axis, along)
        self.size = spatial.size

    def _refuse_open(self, found: Equations) -> None:
        spatial = self.loops.spatial
        wrong = ~(np.abs(found.gaps).max(axis=0, initial=0.0) <= LOOSEST * spatial.size)
        if wrong.any():
            i = int(np.argmax(wrong))
            gap = float(found.widest()[i])
            raise other_linkage(float(self.states.position[spatial.drivers[0], i]), gap, spatial.coordinates[0])

    # -------------------------------------------------------------------------------------------------------------------- friction

    def no_friction(self) -> _Friction:
        return _Friction(np.zeros((self.count, self.n)), np.zeros((len(self.loops.spatial.loops), 3, self.n)))

    def friction(self, efforts: Array, directions: Array) -> _Friction:
        """Friction of efforts (bearings, n) about directions (bearings, 3, n)."""
        return _Friction(efforts[: self.count], efforts[self.count :, None] * directions[self.count :])

    def ways(self, rates: Array) -> tuple[Array, Array]:
        """Speeds (bearings, n) at joint rates (nv, n), of loops their magnitudes, and the axes (bearings, 3, n) about or along which the
        bearings move, world axes; zero of a loop that does not turn."""
        spins = loop_spins(self.loops, self.found.placed, rates)
        sizes = np.sqrt((spins * spins).sum(axis=1))
        directions = np.concatenate([self.found.placed.axis, spins / np.where(sizes == 0, 1.0, sizes)[:, None]])
        return np.concatenate([rates, sizes]), directions

    def with_friction(self, law: FrictionLaw, speeds: Array, compliance: Array | None) -> tuple[Array, _Friction, Array]:
        """Multipliers (rows, n), friction, and the power lost (bearings, n) [W].

        Args:
            law: friction of the bearings.
            speeds: (bearings, n) of the bearings, zero where they are rounding.
            compliance: (bearings,) as in `AppliedConditions`.

        Raises:
            PinpressError: friction locks the linkage.
        """
        _, directions = self.ways(self.states.v)
        directions[self.count :] *= (speeds[self.count :] != 0)[:, None]

        def radial(efforts: Array) -> Array:
            vectors = self.radial(self.multipliers(self.friction(efforts, directions), compliance), directions)
            return np.asarray(np.sqrt((vectors * vectors).sum(axis=1)))

        spatial = self.loops.spatial
        efforts = law.efforts(speeds, radial, self.states.position[spatial.drivers[0]], spatial.coordinates[0])
        friction = self.friction(efforts, directions)
        return self.multipliers(friction, compliance), friction, -efforts * speeds

    def radial(self, multipliers: Array, directions: Array) -> Array:
        """Vectors (bearings, 3, n) across the axes of the bearings, whose lengths are the radial forces [N]."""
        forces = _of_bearings(self.loops, self._loop_forces(multipliers)[..., None])[..., 0].transpose(1, 2, 0)
        forces[: self.count] += self.force
        return cross(forces, directions)

    def _loop_forces(self, multipliers: Array) -> Array:
        """Forces (n, nl, 3) of the loops from multipliers (rows, n)."""
        count = len(self.loops.spatial.loops)
        return multipliers[: 3 * count].T.reshape(self.n, count, 3)

    # ----------------------------------------------------------------------------------------------------------------- multipliers

    def multipliers(self, friction: _Friction, compliance: Array | None, shared: bool = True) -> Array:
        """Multipliers (rows, n) of the equations.

        Args:
            friction: of the bearings.
            compliance: (bearings,) as in `AppliedConditions`.
            shared: whether to share idle forces as `engines.forces` says; else the multipliers are those of least norm.
        """
        found = self.passive.multipliers(self._needed(friction))
        if not shared:
            return found
        for part in self.passive.parts:
            if part.idle.shape[2] and len(part.idle):
                y = lexicographic_least_squares(self._objectives(found, part.states, part.idle, friction, compliance))
                found[:, part.states] += (part.idle @ y[..., None])[..., 0].T
        return found

    def _needed(self, friction: _Friction) -> Array:
        """Efforts (nv, n) that loops, couplings and drives have to supply: those of the open tree less friction."""
        needed: Array = self.effort - friction.efforts
        if friction.couples.any():
            turning = np.where(self.loops.bodies.turns[:, None, None], self.found.placed.axis, 0.0)
            needed -= np.einsum("jl,jin,lin->jn", self.loops.spatial.incidence, turning, friction.couples, optimize=True)
        return needed

    def _objectives(
        self, found: Array, states: NDArray[np.intp] | slice, idle: Array, friction: _Friction, compliance: Array | None
    ) -> Iterator[Objective]:
        """The objectives by which idle forces of some states are shared. The generator works out the next one only where the ones before
        leave something open."""
        k = idle.shape[2]
        columns = np.concatenate([idle, found[:, states].T[:, :, None]], axis=2)
        loop_forces, loop_moments, _ = _parts(self.loops, self.found, states, columns)
        forces = _of_bearings(self.loops, loop_forces)
        forces[:, : self.count, :, k] += self.force[:, :, states].transpose(2, 0, 1)
        forces = self._across(forces, states, turning=False)
        if compliance is not None:
            weights = np.repeat(np.sqrt(compliance), 3)[:, None]
            yield Objective(weights * forces[..., :k], weights[:, 0] * forces[..., k], float(weights.max()))
        yield Objective(forces[..., :k], forces[..., k], 1.0)
        loop_moments[..., k] += friction.couples[:, :, states].transpose(2, 0, 1)
        moments = _moments(self.loops, self.found, states, loop_forces, loop_moments)
        moments[:, : self.count, :, k] += self.moment[:, :, states].transpose(2, 0, 1)
        moments = self._across(moments, states, turning=True)
        yield Objective(moments[..., :k], moments[..., k], self.size)

    def _across(self, vectors: Array, states: NDArray[np.intp] | slice, turning: bool) -> Array:
        """Vectors (m, bearings, 3, k) without their components along the axes of the joints that turn, or of those that slide, as
        (m, 3 bearings, k)."""
        some = np.flatnonzero(self.loops.bodies.turns == turning)
        if len(some):
            axis = self.found.placed.axis[some][:, :, states].transpose(2, 0, 1)[..., None]
            own = vectors[:, some]
            vectors[:, some] = own - axis * (axis * own).sum(axis=2, keepdims=True)
        return vectors.reshape(len(vectors), -1, vectors.shape[-1])

    # -------------------------------------------------------------------------------------------------------------------- result

    def fill(self, result: Wrenches, multipliers: Array, friction: _Friction, wanted: Sequence[int]) -> None:
        """Write the wrenches of these states into the result."""
        loops, spatial, count = self.loops, self.loops.spatial, self.count
        driving = list(spatial.drivers)
        result.torque[:] = self._needed(friction)[driving] - np.einsum("rdn,rn->dn", self.found.driving, multipliers)
        held = len(spatial.loops)
        units = np.array([spatial.size if spatial.axes[pair.follower].turns else 1.0 for pair in spatial.couplings])
        result.coupling[:] = units[:, None] * multipliers[loops.rows - len(units) :]
        if not len(wanted):
            return
        forces, moments = np.empty((count + held, 3, self.n)), np.empty((count + held, 3, self.n))
        forces[count:], moments[count:] = multipliers[: 3 * held].reshape(held, 3, self.n), friction.couples
        row = 3 * held
        for k, loop in enumerate(spatial.loops):
            if loop.held_rotations:
                own = multipliers[row : row + loop.held_rotations]
                moments[count + k] += spatial.size * np.einsum("ihn,hn->in", self.found.held[k], own)
                row += loop.held_rotations
        arms = self.found.ends[0][loops.pair_loop] - self.found.placed.origin[loops.pair_joint + 1]
        crossing = np.empty((len(arms), 2, 3, self.n))
        crossing[:, 0] = forces[count + loops.pair_loop]
        crossing[:, 1] = moments[count + loops.pair_loop] + cross(arms, crossing[:, 0])
        crossed = product(loops.crossing, crossing.reshape(len(arms), 6 * self.n)).reshape(count, 2, 3, self.n)
        np.subtract(self.force, crossed[:, 0], out=forces[:count])
        np.subtract(self.moment, crossed[:, 1], out=moments[:count])
        kept = slice(None) if len(wanted) == len(forces) else list(wanted)
        result.force[:], result.moment[:] = forces[kept].transpose(0, 2, 1), moments[kept].transpose(0, 2, 1)


def _speeds(loops: Loops, position: Array, v: Array) -> Array:
    """Speeds (bearings, n) of all bearings at joint rates (nv, n), those of loops as magnitudes."""
    sizes = np.empty((len(loops.spatial.loops), v.shape[1]))
    for start in range(0, v.shape[1], loops.piece):
        some = slice(start, start + loops.piece)
        spins = loop_spins(loops, equations(loops, position[:, some]).placed, v[:, some])
        sizes[:, some] = np.sqrt((spins * spins).sum(axis=1))
    return np.concatenate([v, sizes])


def _parts(loops: Loops, found: Equations, states: NDArray[np.intp] | slice, multipliers: Array) -> tuple[Array, Array, Array]:
    """Forces and moments (m, nl, 3, k) of the loops, and torques (m, nc, k) of the couplings, from multipliers (m, rows, k)."""
    spatial, (m, _, k) = loops.spatial, multipliers.shape
    count = len(spatial.loops)
    forces, moments = multipliers[:, : 3 * count].reshape(m, count, 3, k), np.zeros((m, count, 3, k))
    row = 3 * count
    for index, loop in enumerate(spatial.loops):
        if loop.held_rotations:
            own = multipliers[:, row : row + loop.held_rotations]
            moments[:, index] = spatial.size * found.held[index][:, :, states].transpose(2, 0, 1) @ own
            row += loop.held_rotations
    units = np.array([spatial.size if spatial.axes[pair.follower].turns else 1.0 for pair in spatial.couplings])
    return forces, moments, units[:, None] * multipliers[:, row:]


def _of_bearings(loops: Loops, forces: Array) -> Array:
    """What forces (m, nl, 3, k) of the loops add to the forces (m, bearings, 3, k) of joints and loops."""
    m, count, _, k = forces.shape
    nv = len(loops.bodies.parents)
    result = np.empty((m, nv + count, 3, k))
    result[:, :nv] = (-loops.spatial.incidence @ forces.reshape(m, count, 3 * k)).reshape(m, nv, 3, k)
    result[:, nv:] = forces
    return result


def _moments(loops: Loops, found: Equations, states: NDArray[np.intp] | slice, forces: Array, moments: Array) -> Array:
    """What forces and moments (m, nl, 3, k) of the loops add to the moments (m, bearings, 3, k) of joints, about their origins, and
    loops."""
    (m, count, _, k), nv = forces.shape, len(loops.bodies.parents)
    result = np.zeros((m, nv + count, 3, k))
    result[:, nv:] = moments
    points, origins = found.ends[0][:, :, states], found.placed.origin[1:][:, :, states]
    for loop, joint, sign in zip(loops.pair_loop.tolist(), loops.pair_joint.tolist(), loops.pair_sign.ravel().tolist(), strict=True):
        arm, force = (points[loop] - origins[joint]).T[:, :, None], forces[:, loop]
        turning = np.stack(
            [
                arm[:, 1] * force[:, 2] - arm[:, 2] * force[:, 1],
                arm[:, 2] * force[:, 0] - arm[:, 0] * force[:, 2],
                arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0],
            ],
            axis=1,
        )
        result[:, joint] -= sign * (moments[:, loop] + turning)
    return result
