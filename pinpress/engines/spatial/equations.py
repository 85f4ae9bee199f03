"""The equations of loops and relations in space at all configurations at once.

Equations, their order and their scaling are those of `engines.structure`. Of their Jacobian only the entries are computed that can differ
from zero: a joint moves only the loops that it is on.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ...common.frozen import Frozen
from ...common.products import product
from ...common.quantities import Array
from ..body_motion import cross, turned
from ..engine import PIECE
from ..friction import REST
from ..structure import Structure
from .blocks import Blocks, build_blocks
from .bodies import Bodies, Placements, accelerations, build_bodies, displaced, motion_axes, placements, velocities

PARALLEL_TO_ROUNDING = 1e-14  # sine of an angle that rounding leaves between parallel axes: an entry as small is zero
JACOBIANS = 500_000  # entries of the Jacobians of all configurations that are worked through at a time
HALF_TURN = -0.99  # cosine of an angle from which on the logarithm of a rotation needs care


@dataclass(frozen=True, eq=False, repr=False)
class Loops(Frozen):
    """Constants of the equations of a linkage.

    Attributes:
        structure: of the linkage.
        bodies: constants of its bodies.
        joint: (2, nl) Pinocchio's indices of the joints whose bodies carry ends 1 and 2.
        point: (2, nl, 3) ends in the frames of these joints [m].
        passive: indices of the passive joints in v.
        pair_loop: (np,) a loop of each pair of a loop and a joint that carries one of its ends alone.
        pair_joint: (np,) index in v of the joint of each pair.
        pair_end: (np,) the end that it carries, 0 for end 1, 1 for end 2.
        entries: (2, ne) equation and joint of every entry of the Jacobian that can differ from zero: three for each pair, then those of
            the rotations that bearings prevent, loop by loop and joint by joint, then those of the relations.
        rows: number of equations.
    """

    structure: Structure
    bodies: Bodies
    joint: NDArray[np.intp]
    point: Array
    passive: NDArray[np.intp]
    pair_loop: NDArray[np.intp]
    pair_joint: NDArray[np.intp]
    pair_end: NDArray[np.intp]
    entries: NDArray[np.intp]
    rows: int

    @cached_property
    def piece(self) -> int:
        """Number of configurations that are worked through at a time, so that their Jacobians take a few megabytes."""
        return max(8, min(PIECE, JACOBIANS // max(1, self.rows * len(self.bodies.parents))))

    @cached_property
    def _irregular(self) -> Array:
        """(ne + 1, 1) see `Equations.entries`, in a configuration in which nothing is as it is by accident; it leaves the loops open."""
        turns = self.bodies.turns
        x = np.where(turns, 0.2, 0.2 * self.structure.size) * np.sin(1.0 + 1.7 * np.arange(len(turns)))
        return equations(self, x[:, None]).entries

    @cached_property
    def blocks(self) -> Blocks | None:
        """The order in which the equations are solved; None if there are fewer of them than passive joints, and if they contradict
        each other: all of them together have one least-squares solution."""
        structure, count = self.structure, len(self.structure.loops)
        if structure.misfit:
            return None
        held = np.repeat(np.arange(count), [loop.held_rotations for loop in structure.loops])
        members = np.concatenate([np.repeat(np.arange(count), 3), held, count + np.arange(len(structure.relations))])
        return build_blocks(self.entries, self._irregular[:-1, 0], members, self.passive)

    @cached_property
    def driving_places(self) -> NDArray[np.intp]:
        """(rows, drivers) see `places_in`."""
        return self.places_in(np.array(self.structure.drivers, dtype=np.intp))

    @cached_property
    def passive_places(self) -> NDArray[np.intp]:
        """(rows, passive joints) see `places_in`."""
        return self.places_in(self.passive)

    def places_in(self, joints: NDArray[np.intp]) -> NDArray[np.intp]:
        """Places (rows, k) of the numbers in the columns of k joints among the Jacobian's entries; where they are zero that of an entry
        more, which is zero."""
        column = np.full(len(self.bodies.parents), -1)
        column[joints] = np.arange(len(joints))
        own = np.flatnonzero(column[self.entries[1]] >= 0)
        result = np.full((self.rows, len(joints)), self.entries.shape[1])
        result[self.entries[0, own], column[self.entries[1, own]]] = own
        return result

    @cached_property
    def fixed_entries(self) -> Array:
        """(entries of relations, 1) the entries of the Jacobian that do not change."""
        slopes = self.structure.relation_slopes
        first = self.rows - len(slopes)
        rows, joints = self.entries[:, self.entries[0] >= first]
        return np.asarray(slopes[rows - first, joints][:, None])

    @cached_property
    def curve_places(self) -> list[int]:
        """Places of the slopes of curves among the Jacobian's entries."""
        first, places = self.rows - len(self.structure.relations), list(map(tuple, self.entries.T.tolist()))
        return [places.index((first + k, curve.joint)) for k, curve in self.structure.curves]

    @cached_property
    def pair_sign(self) -> Array:
        """(np, 1, 1) +1 where the joint carries end 2, -1 where it carries end 1."""
        return np.asarray(2.0 * self.pair_end[:, None, None] - 1.0)

    @cached_property
    def pairs(self) -> list[tuple[int, int, np.ufunc]]:
        """Loop and joint of every pair, and whether to add to the joint what it has from the loop or, where it carries end 2, subtract."""
        changes = [np.subtract if end else np.add for end in self.pair_end.tolist()]
        return list(zip(self.pair_loop.tolist(), self.pair_joint.tolist(), changes, strict=True))

    @cached_property
    def spinning(self) -> Array:
        """(nl, nv) sums over the joints on a loop, +1 where a joint carries only its end 2, -1 where only its end 1."""
        return np.ascontiguousarray(self.structure.incidence.T)

    @cached_property
    def pair_turns(self) -> NDArray[np.bool_]:
        """(np,) whether the joint turns."""
        return np.asarray(self.bodies.turns[self.pair_joint])


def build_loops(structure: Structure) -> Loops:
    """The constants of a linkage."""
    loops, bodies = structure.loops, build_bodies(structure)
    pairs = [(k, joint, int(sign > 0)) for k, joints in enumerate(structure.joints_of_loop) for joint, sign in joints.items()]
    pair_loop, pair_joint, pair_end = np.array(pairs, dtype=np.intp).reshape(-1, 3).T.copy()
    entries = [(3 * k + row, joint) for k, joint, _ in pairs for row in range(3)]
    row = 3 * len(loops)
    for loop, joints in zip(loops, structure.joints_of_loop, strict=True):
        entries += [(row + held, joint) for joint in joints if bodies.turns[joint] for held in range(loop.held_rotations)]
        row += loop.held_rotations
    entries += [(row + k, joint) for k, relation in enumerate(structure.relations) for joint in relation.joints]
    return Loops(
        structure=structure,
        bodies=bodies,
        joint=np.array([[loop.joint1 for loop in loops], [loop.joint2 for loop in loops]], dtype=np.intp),
        point=np.array([[loop.point1 for loop in loops], [loop.point2 for loop in loops]]).reshape(2, len(loops), 3),
        passive=np.array(structure.passive_joints, dtype=np.intp),
        pair_loop=pair_loop,
        pair_joint=pair_joint,
        pair_end=pair_end,
        entries=np.array(entries, dtype=np.intp).reshape(-1, 2).T.copy(),
        rows=row + len(structure.relations),
    )


@dataclass(eq=False, repr=False)
class Equations:
    """The equations at n configurations.

    Attributes:
        loops: constants of the equations.
        x: (nv, n) joint coordinates.
        placed: where the bodies are.
        ends: (2, nl, 3, n) world positions of the ends of the loops [m].
        gaps: (rows, n) what each equation misses [m].
        entries: (ne + 1, n) entries of the Jacobian of the gaps, see `Loops.entries`, then zero.
        held: for every loop (3, 0 to 3, n) world axes, as columns, of the rotations that its bearing prevents.
    """

    loops: Loops
    x: Array
    placed: Placements
    ends: Array
    gaps: Array
    entries: Array
    held: list[Array]

    @cached_property
    def driving(self) -> Array:
        """(rows, drivers, n) columns of the drivers in the Jacobian."""
        return self.entries.take(self.loops.driving_places, axis=0)

    def widest(self) -> Array:
        """Largest gaps (n,) of a loop or relation [m]."""
        loops, n = self.ends.shape[1], self.gaps.shape[1]
        points = np.sqrt((self.gaps[: 3 * loops].reshape(loops, 3, n) ** 2).sum(axis=1)).max(axis=0, initial=0.0)
        return np.asarray(np.maximum(points, np.abs(self.gaps[3 * loops :]).max(axis=0, initial=0.0)))


class Moved(NamedTuple):
    """Pivots that stand elsewhere in their links, at each of n configurations elsewhere.

    Attributes:
        joints: (nv, 3, n) displacements of joints, in the frames of the bodies that carry them [m].
        ends: (2, nl, 3, n) displacements of both ends of the loops, in the frames of their bodies [m].
    """

    joints: Array
    ends: Array


def equations(loops: Loops, x: Array, moved: Moved | None = None) -> Equations:
    """The equations at joint coordinates (nv, n), with pivots where they are or where they have been moved to.

    Gaps and entries are linear in the displacements, which turn nothing."""
    n, count, pairs = x.shape[1], loops.joint.shape[1], len(loops.pair_loop)
    placed = placements(loops.bodies, x)
    if moved is not None:
        placed = displaced(loops.bodies, placed, moved.joints)
    ends = placed.origin[loops.joint] + np.einsum("elikn,elk->elin", placed.rotation[loops.joint], loops.point)
    if moved is not None:
        ends += turned(placed.rotation[loops.joint], moved.ends)
    gaps, entries = np.empty((loops.rows, n)), np.empty((loops.entries.shape[1] + 1, n))
    gaps[: 3 * count] = (ends[1] - ends[0]).reshape(3 * count, n)
    entries[: 3 * pairs] = _moving_pairs(loops, placed, ends).reshape(3 * pairs, n)
    held = _fill_rotation_rows(loops, placed, gaps, entries[3 * pairs :])
    entries[-1] = 0.0
    if relations := len(loops.structure.relations):
        entries[-1 - len(loops.fixed_entries) : -1] = loops.fixed_entries
        gaps[-relations:] = loops.structure.relation_gaps(x)
        for place, (_, _, slope) in zip(loops.curve_places, loops.structure.slopes_of_curves(x), strict=True):
            entries[place] = slope
    return Equations(loops, x, placed, ends, gaps, entries, held)


def _moving_pairs(loops: Loops, placed: Placements, ends: Array) -> Array:
    """What a unit rate of the joint of each pair adds to the gap of its loop, (np, 3, n)."""
    axis = placed.axis[loops.pair_joint]
    moved = cross(axis, ends[loops.pair_end, loops.pair_loop] - placed.origin[loops.pair_joint + 1])
    if not loops.pair_turns.all():
        moved = np.where(loops.pair_turns[:, None, None], moved, axis)
    moved *= loops.pair_sign
    return moved


def _fill_rotation_rows(loops: Loops, placed: Placements, gaps: Array, entries: Array) -> list[Array]:
    """Fill in the gaps and the ``entries`` of the rotations that bearings prevent, and return their world axes."""
    structure, n = loops.structure, gaps.shape[1]
    row, entry, held = 3 * len(structure.loops), 0, []
    for k, loop in enumerate(structure.loops):
        if not loop.held_rotations:
            held.append(np.empty((3, 0, n)))
            continue
        first = np.einsum("ikn,kl->iln", placed.rotation[loop.joint1], loop.rotation1)
        if loop.type == "revolute":
            axis2 = np.einsum("ikn,k->in", placed.rotation[loop.joint2], loop.rotation2[:, 0])
            # the two axes are aligned, but may point against each other; axes across each other are a quarter turn apart either way
            error = cross(first[:, 0], axis2) * np.where((first[:, 0] * axis2).sum(axis=0) < 0.0, -1.0, 1.0)
        else:
            second = np.einsum("ikn,kl->iln", placed.rotation[loop.joint2], loop.rotation2)
            error = np.einsum("ikn,kn->in", first, _logarithm(np.einsum("kin,kjn->ijn", first, second)))
        prevented = first[:, 3 - loop.held_rotations :]
        rows = slice(row, row + loop.held_rotations)
        gaps[rows] = structure.size * np.einsum("ihn,in->hn", prevented, error)
        for joint, sign in structure.joints_of_loop[k].items():
            if loops.bodies.turns[joint]:
                along = np.einsum("ihn,in->hn", prevented, sign * placed.axis[joint])
                along[np.abs(along) < PARALLEL_TO_ROUNDING] = 0.0
                np.multiply(structure.size, along, out=entries[entry : entry + loop.held_rotations])
                entry += loop.held_rotations
        held.append(prevented)
        row += loop.held_rotations
    return held


def _logarithm(rotations: Array) -> Array:
    """Rotation vectors (3, n) of rotations (3, 3, n)."""
    twice = np.stack([rotations[2, 1] - rotations[1, 2], rotations[0, 2] - rotations[2, 0], rotations[1, 0] - rotations[0, 1]])
    sine, cosine = 0.5 * np.sqrt((twice * twice).sum(axis=0)), 0.5 * (np.einsum("iin->n", rotations) - 1.0)
    angle = np.arctan2(sine, cosine)
    vectors = 0.5 * twice * np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 1.0)
    for i in np.flatnonzero(cosine < HALF_TURN):
        vectors[:, i] = pin.log3(np.ascontiguousarray(rotations[:, :, i]))
    return vectors


def drift(loops: Loops, state: Equations, axes: Array, v: Array) -> Array:
    """Second derivative (rows, n) of the gaps at joint rates (nv, n) and no joint acceleration; ``axes``: of `motion_axes`."""
    structure, count = loops.structure, len(loops.structure.loops)
    moved = velocities(loops.bodies, axes, v)
    changed = accelerations(loops.bodies, axes, moved, v, None)
    spin, linear = moved.spin[loops.joint], moved.linear[loops.joint]
    of_ends = changed.linear[loops.joint] + cross(changed.turning[loops.joint], state.ends)
    of_ends += cross(spin, linear + cross(spin, state.ends))
    result = np.zeros_like(state.gaps)
    result[: 3 * count] = (of_ends[1] - of_ends[0]).reshape(3 * count, v.shape[1])
    row = 3 * count
    for k, (loop, held) in enumerate(zip(structure.loops, state.held, strict=True)):
        if loop.held_rotations:
            (spin1, spin2), (turned1, turned2) = spin[:, k], changed.turning[loops.joint[:, k]]
            # of t . (spin2 - spin1), where the direction t turns with body 1
            relative = turned2 - turned1 + cross(spin2 - spin1, spin1)
            result[row : row + loop.held_rotations] = structure.size * np.einsum("ihn,in->hn", held, relative)
            row += loop.held_rotations
    if structure.curves:
        result[row:] = structure.relation_drift(state.x, v)
    return result


def loop_turning(loops: Loops, placed: Placements, v: Array) -> tuple[Array, Array]:
    """How body 2 turns against body 1 of the loops, at joint rates (nv, n).

    Returns speeds (nl, n) [rad/s], and the axes (nl, 3, n) about which they are. A revolute loop has its own axis, and its speed a sign,
    so that it is smooth where the loop turns back. The speed of another loop is a magnitude; where that is rounding beside the fastest
    joint, speed and axis are zero.
    """
    turning = np.where(loops.bodies.turns[:, None, None], placed.axis, 0.0) * v[:, None]
    count, _, n = turning.shape
    spins = np.asarray(product(loops.spinning, turning.reshape(count, 3 * n)).reshape(-1, 3, n))
    speeds, lengths = np.sqrt((spins * spins).sum(axis=1)), np.where(loops.bodies.turns, 1.0, loops.structure.size)
    speeds[speeds <= REST * (np.abs(v) / lengths[:, None]).max(axis=0)] = 0.0
    axes = np.where(speeds[:, None] > 0.0, spins / np.where(speeds > 0.0, speeds, 1.0)[:, None], 0.0)
    for k, loop in enumerate(loops.structure.loops):
        if loop.type == "revolute":
            axes[k] = np.einsum("ikn,k->in", placed.rotation[loop.joint1], loop.rotation1[:, 0])
            speeds[k] = (axes[k] * spins[k]).sum(axis=0)
    return speeds, axes


class Kinematics(NamedTuple):
    """How the equations of a linkage are computed and solved.

    Attributes:
        equations: of constants and joint coordinates (nv, n).
        drift: of constants, equations and joint rates (nv, n) the second derivative (rows, n) of the gaps without joint acceleration.
        in_blocks: whether they are solved block by block, and kept for inverse dynamics; else each configuration by the singular values of
            the whole.
    """

    equations: Callable[[Loops, Array], Equations]
    drift: Callable[[Loops, Equations, Array], Array]
    in_blocks: bool


def _drift(loops: Loops, state: Equations, v: Array) -> Array:
    return drift(loops, state, motion_axes(loops.bodies, state.placed), v)


AT_ONCE = Kinematics(equations, _drift, in_blocks=True)


def gaps(loops: Loops, position: Array, by: Kinematics) -> Array:
    """See `Engine.gaps`."""
    pieces = (position[:, k : k + loops.piece] for k in range(0, position.shape[1], loops.piece))
    return np.concatenate([np.zeros(0), *(by.equations(loops, piece).widest() for piece in pieces)])
