"""Forces of a chain of dyads at all crank angles at once: dyad by dyad backwards, each by its two inverses.

The power of a force f at a velocity v is Re(conj(f) v): the conjugates of forces are what appears everywhere, and here all forces are
conjugates until they are written to the result. The *work* of a function is that of all inertia forces less weights and loads on it: the
force f at a point that moves with c times the function counts conj(f) c. A rotor u with the work W asks for the effort -Im(u W), a way
along a guide with the rotor u for Re(u W). With the inverses e1 and e2 of a dyad (see `dyads`) the force p of its loop is

    conj(p) = -(e1 effort1 + e2 effort2)

and takes c conj(p) from the work of every function that has the coefficient c in the loop. What is left at the shafts that are geared to
the driver goes through the gears, and what is left at the driver is the driving torque.

A lever supplies the effort of its rotor across itself. Along it any force is left open: an *idle* force, which the dyads before it balance.
`engines.forces` says how much of it is added.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...common.products import SERIAL_COMPLEX
from ...common.quantities import Array, ComplexArray
from ..forces import AppliedForce, Wrenches
from . import out_of_plane
from .bodies import Bodies
from .chain import Chain, ChainStates, Closed, Equation, all_functions, rate_of
from .dyads import I
from .guide_moments import GuidedBody, guided_bodies, moments_of_guides
from .model import Plane, put_normal, to_complex
from .statics import shares_of, torques


class Tree(NamedTuple):
    """The links that hang on one joint of the frame.

    Attributes:
        joints: its joints, consecutive.
        rows: rows of functions, the row of ones first.
        to_work: second derivatives of the functions to the work on them.
        to_forces: the same to the forces of all links that each joint carries.
        single: the four numbers of these matrices where there is one joint.
    """

    joints: range
    rows: slice
    to_work: ComplexArray
    to_forces: ComplexArray
    single: tuple[ComplexArray, ...]


class OpenTree(NamedTuple):
    """Forces of the linkage with all loops open, (n,) each.

    Attributes:
        work: by rows, on the functions.
        forces: of all bearings; those of the loops are to be filled in.
        bearings: the same as one array (bearings, n).
    """

    work: list[ComplexArray]
    forces: list[ComplexArray]
    bearings: ComplexArray


@dataclass(frozen=True, eq=False, repr=False)
class ChainBodies:
    """Inertial constants of a chain; forces are conjugates, and follow from the conjugate second derivatives of the functions.

    Attributes:
        chain: the chain.
        bodies: inertial constants of the linkage.
        together: (work, forces of joints; rows) of all trees together, for few states.
        trees: the same tree by tree.
        guided: the links on guides.
        carriers: of every loop the joints that carry one of its ends, with `Plane.incidence`.
    """

    chain: Chain
    bodies: Bodies
    together: ComplexArray
    trees: tuple[Tree, ...]
    guided: tuple[GuidedBody, ...]
    carriers: tuple[tuple[tuple[int, float], ...], ...]

    @cached_property
    def turned(self) -> tuple[int, ...]:
        """The joints that transmit moments about the normal, rising: the driver, if it turns, geared shafts, and all guides."""
        plane = self.chain.plane
        return tuple(sorted({*plane.prismatic, *self.bodies.geared, *([plane.driver] if self.chain.turns else [])}))

    @cached_property
    def bearing_count(self) -> int:
        """Number of bearings."""
        return len(self.chain.rows) + len(self.carriers)

    @cached_property
    def backwards(self) -> tuple[int, ...]:
        """Places of all equations, the last one first."""
        return tuple(reversed(range(len(self.chain.equations))))

    @cached_property
    def balancing(self) -> tuple[tuple[int, ...], ...]:
        """For every lever the places of the equations before it whose forces balance its idle force, the last one first."""
        return tuple(_balancing(self.chain, lever) for lever in self.chain.levers)


def build_chain_bodies(chain: Chain, bodies: Bodies) -> ChainBodies:
    """Inertial constants of a chain."""
    plane = chain.plane
    places = [chain.order.index(row) if row not in chain.ones else 0 for row in range(chain.count)]  # of rows in the basis
    first, trees = chain.count, []
    together = np.zeros((first + len(plane.parents), chain.count), complex)
    for one, end in zip(chain.ones, (*chain.ones[1:], chain.count), strict=True):
        joints = [j for j, row in enumerate(chain.rows) if one < row < end]
        columns = [0, *places[one + 1 : end]]
        to_work = bodies.reduced[[place - 1 for place in columns[1:]]][:, columns].conj()
        to_forces = bodies.subtree_forces[joints][:, columns].conj()
        single = tuple(np.array(entry) for entry in (*to_work[0], *to_forces[0])) if len(joints) == 1 else ()
        trees.append(Tree(range(joints[0], joints[-1] + 1), slice(one, end), to_work, to_forces, single))
        together[one + 1 : end, one:end] = to_work
        together[first + joints[0] : first + joints[-1] + 1, one:end] = to_forces
    carriers: list[list[tuple[int, float]]] = [[] for _ in plane.loop_heights]
    for joint, signs in enumerate(plane.loops_of_joint):
        for loop, sign in signs.items():
            carriers[loop].append((joint, sign))
    return ChainBodies(chain, bodies, together, tuple(trees), guided_bodies(chain, bodies), tuple(map(tuple, carriers)))


def _balancing(chain: Chain, lever: int) -> tuple[int, ...]:
    """The places of the equations that move the ends of a lever, the last one first."""
    moving, found = _moved_by(chain.equations[lever]), []
    for place in reversed(range(lever)):
        equation = chain.equations[place]
        if not moving.isdisjoint(row for row, _ in equation.own):
            found.append(place)
            moving |= _moved_by(equation)
    return tuple(found)


def _moved_by(equation: Equation) -> set[int]:
    """Rows of the functions that are known before an equation and move its loop."""
    return {row for row, _ in equation.known} | {rotor for rotor, *_ in equation.turned}


def chain_forces(fixed: ChainBodies, states: ChainStates, loads: Sequence[AppliedForce], bearings: bool) -> Wrenches:
    """Driving torque and, with ``bearings``, their wrenches, without friction and stiffnesses."""
    chain, closure, n = fixed.chain, states.closure, len(states.closure.angle)
    tilted = bearings and out_of_plane.is_loaded(fixed.bodies, loads)
    count = fixed.bearing_count if bearings else 0
    found = Found(
        np.empty(n),
        np.empty((len(chain.plane.offsets), n)),
        np.empty((3, count, n)).transpose(1, 2, 0),
        np.zeros((3, count, n)).transpose(1, 2, 0),
    )
    for s, closed in closure.pieces():
        if s.stop - s.start == n:
            _fill(fixed, closed, states.speed, states.acceleration, loads, bearings, tilted, found)
            continue
        speed, acceleration = (of[s] if isinstance(of, np.ndarray) else of for of in (states.speed, states.acceleration))
        acting = [load.part(s) for load in loads]
        _fill(fixed, closed, speed, acceleration, acting, bearings, tilted, found.part(s))
    return Wrenches(found.torque[None], found.coupling, np.zeros((fixed.bearing_count, n)), found.force, found.moment)


class Found(NamedTuple):
    """What is to be filled in.

    Attributes:
        torque: (n,) of the driver [N m], force of one that slides [N].
        coupling: (couplings, n) torques on their followers [N m].
        force: (bearings, n, 3) forces [N]; (0, n, 3) where they are left out.
        moment: (bearings, n, 3) moments, zero so far [N m]; (0, n, 3) as above.
    """

    torque: Array
    coupling: Array
    force: Array
    moment: Array

    def part(self, points: slice) -> Found:
        """Views of a part of the motion."""
        return Found(self.torque[points], self.coupling[:, points], self.force[:, points], self.moment[:, points])


def _fill(
    fixed: ChainBodies,
    closed: Closed,
    speed: Array | float,
    acceleration: Array | float,
    loads: Sequence[AppliedForce],
    bearings: bool,
    tilted: bool,
    found: Found,
) -> None:
    """Fill in a piece of the motion.

    Args:
        fixed: inertial constants.
        closed: the closed chain.
        speed: of the driver.
        acceleration: of the driver.
        loads: forces on links.
        bearings: whether forces and moments of the bearings are found.
        tilted: whether something acts out of the plane.
        found: what is to be filled in.
    """
    chain, plane = fixed.chain, fixed.chain.plane
    second = _second_derivatives(chain, closed, speed, acceleration)
    open_tree = _open_tree(fixed, second)
    for load in loads:
        if load.joint:
            _take_load(plane, chain, load, open_tree)
    work, torque = open_tree.work, found.torque
    _solve(fixed, closed, fixed.backwards, work, open_tree.forces)
    _ask_driver(chain, closed, work, torque)
    if chain.gears:
        _through_gears(chain, closed, work, torque, found.coupling)
    if bearings:
        if chain.levers:
            open_tree = _share(fixed, closed, open_tree, found.coupling)
        _put_forces(plane, open_tree.bearings, found.force)
        moments = moments_of_guides(plane, fixed.guided, closed, speed, acceleration, open_tree.forces, loads)
        if chain.turns:
            moments[plane.driver] = torque
        if chain.gears:
            _add_geared(fixed, found.coupling, moments)
        for joint in fixed.turned:
            put_normal(plane, moments[joint], found.moment[joint])
        if tilted:
            _add_out_of_plane(fixed, closed, second, open_tree, loads, found)
    if chain.gears:
        torques(plane, found.coupling)


def _second_derivatives(chain: Chain, closed: Closed, speed: Array | float, acceleration: Array | float) -> ComplexArray:
    """Conjugate second derivatives (rows, n) of the functions, 1 in the rows of ones."""
    second: ComplexArray = np.multiply(closed.inward, np.asarray(-speed * speed, complex))  # NumPy takes longer for two types
    if isinstance(acceleration, np.ndarray):
        for row in chain.rows:
            second[row] += rate_of(chain, closed, row) * acceleration
    second[chain.ones_at] = 1.0
    return np.conjugate(second, second)


def _open_tree(fixed: ChainBodies, second: ComplexArray) -> OpenTree:
    """Forces with all loops open, from what `_second_derivatives` returned."""
    chain, first = fixed.chain, fixed.chain.count
    joints, n = len(chain.rows), second.shape[1]
    found = np.empty((first + fixed.bearing_count, n), complex)
    rows = list(found)
    work, forces = rows[:first], rows[first:]
    if fixed.together.size * n <= SERIAL_COMPLEX:
        np.dot(fixed.together, second, found[: first + joints])
        return OpenTree(work, forces, found[first:])
    for tree in fixed.trees:
        here, start, end = second[tree.rows], first + tree.joints.start, first + tree.joints.stop
        if tree.single:
            constant1, by1, constant2, by2 = tree.single
            for row, by, constant in ((rows[tree.rows.start + 1], by1, constant1), (rows[start], by2, constant2)):
                np.add(np.multiply(here[1], by, row), constant, row)
        else:
            _multiply(tree.to_work, here, found[tree.rows.start + 1 : tree.rows.stop])
            _multiply(tree.to_forces, here, found[start:end])
    return OpenTree(work, forces, found[first:])


def _multiply(rows: ComplexArray, columns: ComplexArray, out: ComplexArray) -> ComplexArray:
    """`products.product` of several rows into an array."""
    step = max(1, SERIAL_COMPLEX // rows.size)
    for start in range(0, columns.shape[1], step):
        s = slice(start, start + step)
        np.matmul(rows, columns[:, s], out=out[:, s])
    return out


def _add_out_of_plane(
    fixed: ChainBodies,
    closed: Closed,
    second: ComplexArray,
    open_tree: OpenTree,
    loads: Sequence[AppliedForce],
    found: Found,
) -> None:
    """Add what acts out of the plane to forces and moments; arguments as of `_fill`, ``second`` as of `_open_tree`."""
    chain, pins = fixed.chain, open_tree.bearings[len(fixed.chain.rows) :].conj()

    def basis() -> ComplexArray:
        return all_functions(chain, closed).take(chain.order, axis=0)

    axial = out_of_plane.forces(fixed.bodies, loads, None, second.shape[1])
    in_order = second.take(chain.order, axis=0)
    out_of_plane.add(fixed.bodies, basis, np.conjugate(in_order, in_order), pins, loads, axial, found.force, found.moment)


def _take_load(plane: Plane, chain: Chain, load: AppliedForce, open_tree: OpenTree) -> None:
    """Take a load from the work of functions and from the forces of the joints that carry its link."""
    joint, force = load.joint - 1, to_complex(plane, load.force).conj()
    point = plane.point(joint, complex(*(plane.frames[joint] @ load.point)[:2]))
    for place in np.flatnonzero(point[1:]) + 1:
        open_tree.work[chain.order[place]] -= point[place] * force
    for carrier in plane.carriers(joint):
        open_tree.forces[carrier] -= force


def _solve(fixed: ChainBodies, closed: Closed, places: Sequence[int], work: list[ComplexArray], forces: list[ComplexArray]) -> None:
    """Fill in the forces of the loops of the equations at these ``places``, from the last dyad to the first, and subtract them where they
    relieve joints and functions."""
    along, joints = closed.along, len(fixed.chain.rows)
    for place in places:
        equation, inverses = fixed.chain.equations[place], closed.inverses[place]
        efforts = equation.dyad.asked(along, work)
        force = np.multiply(inverses[0], efforts[0], forces[joints + equation.loop])
        if len(efforts) > 1:
            force += inverses[1] * efforts[1]
        _relieve(fixed, closed, equation, force, work, forces)


def _relieve(
    fixed: ChainBodies, closed: Closed, equation: Equation, force: ComplexArray, work: list[ComplexArray], forces: list[ComplexArray]
) -> None:
    """Subtract the force (n,) of a loop where it relieves functions that are known before it is closed, and joints."""
    for row, by in equation.known:
        work[row] -= by * force
    for rotor, way, by in equation.turned:
        work[rotor] += closed.along.ways[way] * (work[way] - by * force)
    for joint, sign in fixed.carriers[equation.loop]:
        if sign > 0.0:
            forces[joint] -= force
        else:
            forces[joint] += force


def _ask_driver(chain: Chain, closed: Closed, work: list[ComplexArray], torque: Array) -> None:
    """Fill in the driving torque (n,), or force, without that of gears."""
    if chain.turns:
        np.negative((closed.along.functions[chain.driver] * work[chain.driver]).imag, torque)
    else:
        torque[:] = work[chain.driver].real


def _through_gears(chain: Chain, closed: Closed, work: list[ComplexArray], torque: Array, multipliers: Array) -> None:
    """Fill in the multipliers (couplings, n) of gear pairs, and take what they do on the driver from its ``torque`` (n,)."""
    efforts = {chain.plane.driver: torque}
    for joint, _, row, sense, *_ in chain.gears:
        efforts[joint] = -sense * (closed.along.functions[row] * work[row]).imag
    for gear in reversed(chain.gears):
        coefficients = chain.plane.coupling_rows[gear.coupling]
        multiplier = np.divide(efforts[gear.joint], coefficients[gear.joint], multipliers[gear.coupling])
        for other, by in coefficients.items():
            if other != gear.joint:
                efforts[other] -= by * multiplier


def _share(fixed: ChainBodies, closed: Closed, open_tree: OpenTree, multipliers: Array) -> OpenTree:
    """The tree with the forces of all bearings, idle forces shared among them; what these do to the ``multipliers`` (couplings, n) is added
    there."""
    chain, n = fixed.chain, multipliers.shape[1]
    parts = np.zeros((len(chain.levers) + 1, fixed.bearing_count, n), complex)  # idle forces, then those of the bearings
    idle_multipliers, unused = np.zeros((len(chain.levers), *multipliers.shape)), np.empty(n)
    parts[-1] = open_tree.bearings
    for lever, places, forces, of_gears in zip(chain.levers, fixed.balancing, map(list, parts), idle_multipliers, strict=False):
        equation, work = chain.equations[lever], list(np.zeros((chain.count, n), complex))
        along_lever = np.multiply(closed.inverses[lever][0], I, forces[len(chain.rows) + equation.loop])
        _relieve(fixed, closed, equation, along_lever, work, forces)
        _solve(fixed, closed, places, work, forces)
        if chain.gears:
            _through_gears(chain, closed, work, unused, of_gears)
    for share, idle, of_gears in zip(shares_of(parts), parts, idle_multipliers, strict=False):
        parts[-1] += share * idle
        multipliers += share * of_gears
    return open_tree._replace(forces=list(parts[-1]), bearings=parts[-1])


def _put_forces(plane: Plane, forces: ComplexArray, out: Array) -> None:
    """Fill ``out`` (k, n, 3) with forces whose conjugates (k, n) are given."""
    for i, first, second, _ in plane.world_components:
        if not (first or second):
            out[..., i] = 0.0
        if first == 1.0:  # most presses stand in a coordinate plane
            out[..., i] = forces.real
        elif first:
            np.multiply(forces.real, first, out=out[..., i])
        if second and first:
            out[..., i] -= second * forces.imag
        elif second == 1.0:
            np.negative(forces.imag, out=out[..., i])
        elif second == -1.0:
            out[..., i] = forces.imag
        elif second:
            np.multiply(forces.imag, -second, out=out[..., i])


def _add_geared(fixed: ChainBodies, multipliers: Array, moments: dict[int, Any]) -> None:
    """Add what the multipliers (couplings, n) of gear pairs do to the moments of the shafts."""
    plane = fixed.chain.plane
    for coupling, coefficients in enumerate(plane.coupling_rows):
        for joint, by in coefficients.items():
            moments[joint] = moments.get(joint, 0.0) + plane.sense[joint] * by * multipliers[coupling]
