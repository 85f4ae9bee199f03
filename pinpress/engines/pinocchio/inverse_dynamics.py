"""Inverse dynamics of any linkage, one configuration at a time, by Pinocchio's recursive Newton-Euler algorithm.

There are three steps: the efforts and wrenches of the open tree; the multipliers of the equations, which balance the efforts of the passive
joints less their friction (`engines.forces` says how redundant forces are shared); the tree once more, under the wrenches of the loops.

Signs: forces and moments of a joint are the action of parent on child, of a loop the action of link1 on link2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ...common.quantities import Array
from ..engine import LOOSEST, ClosedStates, other_linkage
from ..forces import (
    RANK,
    REST,
    AppliedConditions,
    AppliedForce,
    BearingLoads,
    FrictionLaw,
    Objective,
    Wrenches,
    lexicographic_least_squares,
)
from ..joints import configuration
from .kinematics import PassiveJacobian
from .model import Equations, Rows, SpatialModel

Wrench = tuple[int, Array, Array, Array]
"""Joint, point in its frame [m], force and couple in world axes [N, N m]."""


def inverse_dynamics(spatial: SpatialModel, states: ClosedStates, conditions: AppliedConditions, bearings: bool) -> Wrenches:
    """Driving torque and the wrenches of joints and loops; see `Engine.inverse_dynamics`."""
    n, count, law = states.v.shape[1], spatial.model.nv, conditions.law
    result = Wrenches.zeros(len(spatial.drivers), len(spatial.couplings), count + len(spatial.loops), n, bearings)
    equations = spatial.equations()
    turning = None if law is None else _loop_turning(spatial, equations, states.position, states.v)
    speeds = None if law is None or turning is None else law.moving(np.concatenate([states.v, turning[0]]))
    for i in range(n):
        applied = [(load.joint, load.point, load.force[i], np.zeros(3)) for load in conditions.loads]
        state = _State(spatial, equations, states.position[:, i], states.v[:, i].copy(), states.a[:, i].copy(), applied)
        efforts, couples = np.zeros(count), np.zeros((len(spatial.loops), 3))
        if law is None or turning is None or speeds is None:
            multipliers = state.multipliers(efforts, couples, conditions.compliance, shared=bearings)
        else:
            multipliers, efforts, couples, lost = state.with_friction(law, speeds[:, i], turning[1][:, i], conditions.compliance)
            result.friction[:, i] = lost
        state.fill(result, i, multipliers, efforts, couples, bearings)
    return result


def bearing_loads(spatial: SpatialModel, states: ClosedStates, loads: Sequence[AppliedForce], efforts: Array, rates: Array) -> BearingLoads:
    """See `Engine.bearing_loads`."""
    n, count, equations = states.v.shape[1], spatial.model.nv, spatial.equations()
    loop_speeds, loop_axes = _loop_turning(spatial, equations, states.position, rates)
    speed = np.concatenate([rates, loop_speeds])
    radial = np.zeros((*efforts.shape, 3))
    for i in range(n):
        applied = [(load.joint, load.point, load.force[i], np.zeros(3)) for load in loads]
        state = _State(spatial, equations, states.position[:, i], states.v[:, i].copy(), states.a[:, i].copy(), applied)
        directions = state.directions(loop_axes[:, i])
        multipliers = state.multipliers(efforts[:count, i], efforts[count:, i, None] * directions[count:], None)
        radial[:, i] = state.radial(multipliers, directions)
    return BearingLoads(speed, radial)


def indeterminate(spatial: SpatialModel, position: Array, axes: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Force and moment components (bearings, 6) along the rows of ``axes`` (3, 3), and coupling torques (nc,), that idle forces change in
    any of the positions (nv, n); see `Engine.indeterminate`."""
    equations = spatial.equations()
    marks, couplings = np.zeros((spatial.model.nv + len(spatial.loops), 6), dtype=bool), np.zeros(len(spatial.couplings), dtype=bool)
    for x in position.T:
        rows = equations.at(x)
        idle = PassiveJacobian(rows.columns, spatial).idle
        if idle.shape[1]:
            forces, moments, _ = _parts(spatial, rows, idle)
            moments = _moments(spatial, equations.placements, forces, moments)
            forces_shared = spatial.share @ idle[: 3 * len(spatial.loops)]
            for place, vectors, unit in ((0, forces_shared, 1.0), (3, moments, spatial.size)):
                along = axes @ vectors.reshape(len(marks), 3, -1)
                marks[:, place : place + 3] |= np.abs(along).max(axis=2) > RANK * unit
            couplings |= np.abs(idle[len(idle) - len(couplings) :]).max(axis=1) > RANK
    return marks, couplings


class _State:
    """One configuration under its loads: the efforts of the open tree, and the multipliers of the equations that balance them."""

    def __init__(self, spatial: SpatialModel, equations: Equations, x: Array, v: Array, a: Array, applied: list[Wrench]) -> None:
        self.spatial, self.equations, self.applied = spatial, equations, applied
        self.x, self.v, self.a = x, v, a
        self.rows = equations.at(x)
        if not np.abs(self.rows.gaps).max(initial=0.0) <= LOOSEST * spatial.size:
            raise other_linkage(float(x[spatial.drivers[0]]), equations.widest(self.rows.gaps), spatial.place(x))
        self.passive = PassiveJacobian(self.rows.columns, spatial)
        self.placements, self.wrenches = equations.placements, equations.wrenches
        self.rotations = [placement.rotation for placement in self.placements]
        self.effort = pin.rnea(spatial.model, equations.data, self.rows.q, v, a, self._external(applied)).copy()

    def multipliers(self, efforts: Array, couples: Array, compliance: Array | None, shared: bool = True) -> Array:
        """Multipliers (rows,) of the equations.

        Args:
            efforts: (nv,) friction efforts of the joints [N m or N].
            couples: (nl, 3) friction moments of the loops, world axes [N m].
            compliance: (bearings,) as in `AppliedConditions`.
            shared: whether to share idle forces as `engines.forces` says, on which the driving torque does not depend; else the multipliers
                are those of least norm.
        """
        found, idle = self.passive.multipliers(self._needed(efforts, couples)), self.passive.idle
        if not (shared and idle.shape[1]):
            return found
        return found + idle @ lexicographic_least_squares(self._objectives(found, idle, couples, compliance))

    def with_friction(
        self, law: FrictionLaw, speeds: Array, loop_axes: Array, compliance: Array | None
    ) -> tuple[Array, Array, Array, Array]:
        """Multipliers (rows,), friction efforts (nv,) of the joints, friction couples (nl, 3) of the loops, and power lost (bearings,) [W].

        Args:
            law: friction of the bearings.
            speeds: (bearings,) of the bearings, zero where one rests.
            loop_axes: (nl, 3) about which those of loops are, world axes.
            compliance: (bearings,) as in `AppliedConditions`.

        Raises:
            PinpressError: friction locks the linkage.
        """
        count = len(self.effort)
        directions = self.directions(loop_axes * (speeds[count:] != 0)[:, None])

        def multipliers(efforts: Array) -> Array:
            return self.multipliers(efforts[:count], efforts[count:, None] * directions[count:], compliance)

        def radial(efforts: Array) -> Array:
            return np.asarray(np.linalg.norm(self.radial(multipliers(efforts[:, 0]), directions), axis=1)[:, None])

        efforts = law.efforts(speeds[:, None], radial, lambda _: self.spatial.place(self.x))[:, 0]
        return multipliers(efforts), efforts[:count], efforts[count:, None] * directions[count:], -efforts * speeds

    def directions(self, loop_axes: Array) -> Array:
        """Axes (bearings, 3) about or along which the bearings move, world axes; those of loops are given (nl, 3)."""
        axes = [self.rotations[j + 1] @ axis.direction for j, axis in enumerate(self.spatial.axes)]
        return np.concatenate([np.array(axes), loop_axes])

    def radial(self, multipliers: Array, directions: Array) -> Array:
        """Vectors (bearings, 3) across the axes of the bearings, whose lengths are the radial forces [N]."""
        forces = self.spatial.share @ multipliers[: 3 * len(self.spatial.loops)]
        forces[: 3 * len(self.effort)] += self._tree_forces()
        forces = forces.reshape(-1, 3)
        for rack in self.spatial.racks:
            efforts = (
                self.spatial.follower_unit(rack.coupling) * multipliers[len(multipliers) - len(self.spatial.couplings) + rack.coupling]
            )
            forces[rack.shaft] += rack.by_torque * efforts * directions[rack.slide]
        return np.asarray(np.cross(forces, directions))

    def fill(self, result: Wrenches, i: int, multipliers: Array, efforts: Array, couples: Array, bearings: bool) -> None:
        """Write the wrenches of this configuration into the result, as its state i."""
        spatial, count = self.spatial, len(self.effort)
        forces, moments, torques = _parts(spatial, self.rows, multipliers)
        moments = moments + couples
        driving = self._needed(efforts, couples) - self.rows.columns.T @ multipliers
        result.torque[:, i] = driving[list(spatial.drivers)]
        result.coupling[:, i] = torques
        if not bearings:
            return
        result.force[count:, i], result.moment[count:, i] = forces, moments
        on2 = [(loop.joint2, loop.point2, forces[k], moments[k]) for k, loop in enumerate(spatial.loops)]
        on1 = [(loop.joint1, loop.point1, -forces[k], -moments[k]) for k, loop in enumerate(spatial.loops)]
        pin.rnea(spatial.model, self.equations.data, self.rows.q, self.v, self.a, self._external(on2 + on1 + self.applied))
        for j in range(count):
            wrench = self.wrenches[j + 1]
            result.force[j, i] = self.rotations[j + 1] @ wrench.linear
            result.moment[j, i] = self.rotations[j + 1] @ wrench.angular

    def _needed(self, efforts: Array, couples: Array) -> Array:
        """Efforts (nv,) that loops, couplings and drives have to supply: those of the open tree less friction."""
        needed: Array = self.effort - efforts
        if couples.any():
            turning = self.equations.data.J.reshape(6, -1)[3:]
            for couple, signs in zip(couples, self.spatial.incidence.T, strict=True):
                needed -= (turning * signs).T @ couple
        return needed

    def _tree_forces(self) -> Array:
        """Forces (3 nv,) of the joints of the open tree, world axes [N]."""
        forces: list[Array] = [self.rotations[j + 1] @ self.wrenches[j + 1].linear for j in range(len(self.effort))]
        return np.concatenate(forces)

    def _objectives(self, found: Array, idle: Array, couples: Array, compliance: Array | None) -> Iterator[Objective]:
        """The objectives by which idle forces are shared. The generator works out the next one only where the ones before leave something
        open."""
        spatial, count, k = self.spatial, 3 * len(self.spatial.loops), idle.shape[1]
        forces = spatial.share @ np.concatenate([idle[:count], found[:count, None]], axis=1)
        forces[: 3 * len(self.effort), k] += self._tree_forces()
        self._remove_free_components(forces, turning=False)
        if compliance is not None:
            weights = np.repeat(np.sqrt(compliance), 3)[:, None]
            yield Objective(weights * forces[:, :k], weights[:, 0] * forces[:, k], float(weights.max()))
        yield Objective(forces[:, :k], forces[:, k], 1.0)
        loop_forces, loop_moments, _ = _parts(spatial, self.rows, np.concatenate([idle, found[:, None]], axis=1))
        loop_moments[:, :, k] += couples
        moments = _moments(spatial, self.placements, loop_forces, loop_moments)
        for j in range(len(self.effort)):
            moments[3 * j : 3 * j + 3, k] += self.rotations[j + 1] @ self.wrenches[j + 1].angular
        self._remove_free_components(moments, turning=True)
        yield Objective(moments[:, :k], moments[:, k], spatial.size)

    def _remove_free_components(self, vectors: Array, turning: bool) -> None:
        """Subtract from vectors (3 bearings, ...) their components along the axes of the joints that turn, or of those that slide."""
        for j, axis in enumerate(self.spatial.axes):
            if axis.turns == turning:
                direction, own = self.rotations[j + 1] @ axis.direction, vectors[3 * j : 3 * j + 3]
                own -= np.outer(direction, direction @ own)

    def _external(self, wrenches: Sequence[Wrench]) -> pin.StdVec_Force:
        """Wrenches on the joints' bodies as Pinocchio's external forces, in joint frames."""
        totals = [np.zeros(6) for _ in self.rotations]
        for joint, point, force, couple in wrenches:
            local = self.rotations[joint].T @ force
            totals[joint][:3] += local
            totals[joint][3:] += pin.skew(point) @ local + self.rotations[joint].T @ couple
        return pin.StdVec_Force([pin.Force(w) for w in totals])


def _parts(spatial: SpatialModel, rows: Rows, multipliers: Array) -> tuple[Array, Array, Array]:
    """Forces and moments (nl, 3) of the loops and torques (nc,) of the couplings from multipliers (rows,); from multipliers (rows, k) all
    have k as a last axis."""
    loops, last = len(spatial.loops), multipliers.shape[1:]
    forces, moments = multipliers[: 3 * loops].reshape(loops, 3, *last), np.zeros((loops, 3, *last))
    row = 3 * loops
    for k, loop in enumerate(spatial.loops):
        if loop.held_rotations:
            moments[k] = spatial.size * rows.held_directions[k] @ multipliers[row : row + loop.held_rotations]
            row += loop.held_rotations
    units = np.array([spatial.follower_unit(k) for k in range(len(spatial.couplings))])
    return forces, moments, units.reshape(-1, *[1] * len(last)) * multipliers[row:]


def _moments(spatial: SpatialModel, placements: pin.StdVec_SE3, forces: Array, moments: Array) -> Array:
    """What forces and moments (nl, 3, k) of the loops add to the moments (3 bearings, k) of all bearings, world axes."""
    count, k = spatial.model.nv, forces.shape[2]
    joints = np.zeros((count, 3, k))
    for loop, signs, force, moment in zip(spatial.loops, spatial.incidence.T, forces, moments, strict=True):
        point = placements[loop.joint1].act(loop.point1)
        for j in map(int, np.flatnonzero(signs)):
            joints[j] -= signs[j] * (moment + pin.skew(point - placements[j + 1].translation) @ force)
    return np.concatenate([joints, moments]).reshape(-1, k)


def _loop_turning(spatial: SpatialModel, equations: Equations, position: Array, v: Array) -> tuple[Array, Array]:
    """How body 2 turns against body 1 of the loops: speeds (nl, n) [rad/s], and the axes (nl, n, 3) about which they are, world axes.

    A revolute loop has its own axis, and its speed a sign. The speed of another loop is a magnitude; where that is rounding beside the
    fastest joint, speed and axis are zero.
    """
    count, n, data = len(spatial.loops), v.shape[1], equations.data
    spins, own = np.zeros((count, n, 3)), np.zeros((count, n, 3))
    revolute = [k for k, loop in enumerate(spatial.loops) if loop.type == "revolute"]
    q = configuration(spatial.slots, position)
    for i in range(n):
        turning = pin.computeJointJacobians(spatial.model, data, np.ascontiguousarray(q[:, i]))[3:]
        spins[:, i] = (turning @ (spatial.incidence * v[:, i, None])).T
        for k in revolute:
            own[k, i] = data.oMi[spatial.loops[k].joint1].rotation @ spatial.loops[k].rotation1[:, 0]
    lengths = np.array([1.0 if axis.turns else spatial.size for axis in spatial.axes])
    sizes = np.linalg.norm(spins, axis=2)
    sizes[sizes <= REST * (np.abs(v) / lengths[:, None]).max(axis=0)] = 0.0
    axes = np.where(sizes[..., None] > 0, spins / np.where(sizes > 0, sizes, 1.0)[..., None], 0.0)
    axes[revolute], sizes[revolute] = own[revolute], (own[revolute] * spins[revolute]).sum(axis=2)
    return sizes, axes
