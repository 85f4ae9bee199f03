"""A planar press as bodies joined by springs: its inertias, its spring forces, and their derivatives, at many states at once.

Every link is a free body of the plane with three coordinates: the displacement x + i z of its centre of mass, in the axes of the plane, and
its turn phi, both from the drawn pose. A bearing is two springs across each other between a point of one body and a point of another. A
guide is a spring across its axis, which turns with the body that carries it, and one against turning. With the arms s of the points, turned
by u = exp(i phi), and d from point 1 to point 2, a spring along the direction n has the extension

    y = Re(conj(n) d),   d = r2 + u2 s2 - r1 - u1 s1

and pulls with k y + c y'. Its gradient and second derivatives stand in closed form, so that Newton's method has exact Jacobians.

What the springs do not join is kept rigidly: the crank by its angle, gear pairs by their ratio, a crown by its columns. These conditions
are linear, so that the coordinates of all bodies are a constant matrix times the free ones: ``carry @ y + drawn``. The last of the free
ones is the angle of the crank, which may be prescribed. A flexible link has coordinates of its shapes too, which move the points s of its
springs (`flexible_link`); they stand after those of all bodies.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.products import product
from ...common.quantities import Array, ComplexArray
from ...engines.planar.engine import PlanarEngine
from ...engines.planar.kinematics import basis_acceleration, basis_at, basis_velocity
from ...engines.planar.model import Plane, to_world
from ...kinematics.motion import Motion
from ...linkage.linkage import Linkage
from .contact import OpenPin
from .flexible_link import FlexibleBody
from .panels import VaryingInertia
from .preloaded_joint import JointSpring, OpenJoint
from .press_on_springs import JointMotion, SpringForces, frequencies, reference_angle

Indices = NDArray[np.intp]


class LineSprings(NamedTuple):
    """Springs between points of two bodies, S of them; the frame is the last body.

    Attributes:
        first: (S,) bodies of the points 1.
        second: (S,) bodies of the points 2.
        arm1: (S,) points 1 from the centre of mass of their body, in the drawn pose [m].
        arm2: (S,) points 2 likewise [m].
        direction: (S,) directions n in the drawn pose, of length 1.
        turning: (S,) 1 where the direction turns with the first body, else 0.
        stiffness: (S,) [N/m].
        damping: (S,) [N s/m].
        rest: (S,) extensions at which they are slack [m].
        bearing: (S,) number of the bearing of each; -1: the columns of a crown.
        sign: (S,) 1 where the pull on the second body is the force of the bearing, -1 where it is its opposite.
    """

    first: Indices
    second: Indices
    arm1: ComplexArray
    arm2: ComplexArray
    direction: ComplexArray
    turning: Array
    stiffness: Array
    damping: Array
    rest: Array
    bearing: Indices
    sign: Array


class TurningSprings(NamedTuple):
    """Springs against the turning of one body against another, S of them.

    Attributes:
        first: (S,) bodies 1.
        second: (S,) bodies 2.
        stiffness: (S,) [N m/rad].
        damping: (S,) [N m s/rad].
        bearing: (S,) number of the guide of each; -1: the shaft.
    """

    first: Indices
    second: Indices
    stiffness: Array
    damping: Array
    bearing: Indices


@dataclass(frozen=True, eq=False, repr=False)
class SprungPress:
    """Constants of a press on springs. Bodies are the links, counted as joints in v, then a crown and a rotor if there are any, and the
    frame.

    Coordinates are 3 of each body, Q of the flexible links' shapes: k in all.

    Attributes:
        press: the linkage.
        centers: (bodies + 1,) centres of mass in the drawn pose; of the frame the world origin [m].
        inertia: (k,) masses and moments of inertia on the diagonal: m, m, J of every body, m of every shape [kg, kg m2].
        weight: (k,) generalised forces of gravity [N].
        lines: springs of bearings and guides.
        turns: springs against turning.
        carry: (k, f) free coordinates, the crank's angle last, to all coordinates.
        drawn: (k,) all coordinates where the free ones are zero.
        shapes: (2, S, Q) by the coordinates of the flexible links, displacements of points 1 and 2 of the line springs [-].
        crown: the body that carries the bearings on the frame, on its columns; None: the frame carries them.
        rotor: the body that a shaft joins to the crank; None: the crank is the shaft's own.
        joints: preloaded joints, whose springs in ``lines`` are those of closed joints.
        open_pins: pins with clearance, which have no springs in ``lines``.
        open_joints: preloaded joints that may open, whose members have no springs in ``lines``.
        closed: the same press without clearance and with closed joints; None where it is the same.
        flexible: the flexible links.
        base: the frame, where it stands on mounts; the ground is the last body then.
        fixed: the same press on a fixed frame, where it stands on mounts.
    """

    press: Linkage
    centers: ComplexArray
    inertia: Array
    weight: Array
    lines: LineSprings
    turns: TurningSprings
    carry: Array
    drawn: Array
    shapes: ComplexArray
    crown: int | None = None
    rotor: int | None = None
    joints: tuple[JointSpring, ...] = ()
    open_pins: tuple[OpenPin, ...] = ()
    open_joints: tuple[OpenJoint, ...] = ()
    closed: SprungPress | None = None
    flexible: tuple[FlexibleBody, ...] = ()
    base: int | None = None
    fixed: SprungPress | None = None

    @property
    def _rigid(self) -> int:
        """Number of the coordinates of bodies, after which those of shapes begin."""
        return 3 * len(self.centers)

    @property
    def free(self) -> int:
        """Number of free coordinates."""
        return int(self.carry.shape[1])

    def opening(self) -> SprungPress:
        """The same press with preloaded joints that may open."""
        if not self.joints:
            return self
        lines, found = self.lines, []
        columns = lines.stiffness.copy(), lines.damping.copy(), lines.rest.copy()
        for joint in self.joints:
            spring = int(np.flatnonzero(lines.bearing == joint.bearing)[0])
            found.append(joint.opened(spring, float(lines.damping[spring])))
            for column, value in zip(columns, (found[-1].always, found[-1].damping, found[-1].rest), strict=True):
                column[spring] = value
        return replace(
            self,
            lines=lines._replace(stiffness=columns[0], damping=columns[1], rest=columns[2]),
            open_joints=tuple(found),
            closed=self.closed or self,
            fixed=None if self.fixed is None else self.fixed.opening(),
        )

    def bodies_of(self, bearing: int) -> tuple[int, int]:
        """The bodies that a bearing joins, the acting one first."""
        lines = (self if self.closed is None else self.closed).lines
        spring = int(np.flatnonzero(lines.bearing == bearing)[0])
        bodies = int(lines.first[spring]), int(lines.second[spring])
        return bodies if lines.sign[spring] > 0 else bodies[::-1]

    @cached_property
    def mass(self) -> Array:
        """(f, f) mass matrix of the free coordinates."""
        return np.asarray(self.carry.T @ (self.inertia[:, None] * self.carry))

    @cached_property
    def free_weight(self) -> Array:
        """(f,) gravity on the free coordinates."""
        return np.asarray(self.carry.T @ self.weight)

    @cached_property
    def lowest_frequency(self) -> float:
        """Lowest natural frequency at bottom dead centre, with the crank held, closed joints and without dampers [rad/s]."""
        return float(frequencies(self if self.closed is None else self.closed, reference_angle(self.press))[0])

    def all_coordinates(self, free: Array) -> Array:
        """All coordinates (n, k) of free ones (n, f)."""
        return self.all_rates(free) + self.drawn

    def all_rates(self, rates: Array) -> Array:
        """Rates or accelerations (n, k) of all coordinates, of those (n, f) of the free ones."""
        return product(rates, self.carry.T)

    def free_coordinates(self, coordinates: Array) -> Array:
        """Free coordinates (n, f) of all coordinates (n, k)."""
        return self.free_rates(coordinates - self.drawn)

    def free_rates(self, rates: Array) -> Array:
        """Free rates or accelerations (n, f) of those of all coordinates (n, k)."""
        return product(rates, self._back)

    @cached_property
    def _back(self) -> Array:
        """(k, f) all rates to the free ones."""
        return np.asarray(np.linalg.pinv(self.carry).T)

    def mass_at(self, coordinates: Array) -> Array:
        """Mass matrix (f, f), the same everywhere."""
        return self.mass

    # ----------------------------------------------------------------------------------------------------------------- the linkage

    @cached_property
    def plane(self) -> Plane:
        """Constants of the planar linkage."""
        engine = self.press.engine("plane")
        assert isinstance(engine, PlanarEngine)
        return engine.plane

    def rigid_coordinates(self, motion: Motion) -> tuple[Array, Array, Array]:
        """All coordinates, rates and accelerations (n, k) of the rigid press in a motion."""
        plane, states, count = self.plane, motion.states(self.press), self.press.model.nv
        basis = basis_at(plane, states.position)
        rows = plane.origins + plane.centers
        points = [rows @ basis - self.centers[:count, None], rows @ basis_velocity(plane, basis, states.v)]
        points.append(rows @ basis_acceleration(plane, basis, states.v, states.a))
        found = [np.zeros((states.v.shape[1], len(self.drawn))) for _ in range(3)]
        drivers = motion.crank_angle, motion.crank_speed, motion.crank_acceleration
        for each, place, joints, driver in zip(found, points, (states.position, states.v, states.a), drivers, strict=True):
            each[:, : 3 * count : 3], each[:, 1 : 3 * count : 3] = place.real.T, place.imag.T
            each[:, 2 : 3 * count : 3] = (plane.spin @ joints).T
            if self.rotor is not None:
                each[:, 3 * self.rotor + 2] = plane.sense[plane.driver] * driver
        return found[0], found[1], found[2]

    def crank(self, coordinates: Array, rates: Array) -> tuple[Array, Array]:
        """Angle and speed (n,) of the crank's joint."""
        driver, parent = self.plane.driver, self.plane.parents[self.plane.driver]
        sense, carrier = float(self.plane.sense[driver]), parent if parent >= 0 else self.base
        angle, speed = (
            sense * (each[:, 3 * driver + 2] - (0.0 if carrier is None else each[:, 3 * carrier + 2])) for each in (coordinates, rates)
        )
        return angle, speed

    def displacement(self, coordinates: Array, motion: Motion) -> Array:
        """(n, links, 3) of all moving links beside the rigid press in a motion, along the axes of the plane [m], and turns [rad]."""
        moved = coordinates - self.rigid_coordinates(motion)[0]
        return np.asarray(moved[:, : 3 * self.press.model.nv].reshape(len(moved), -1, 3))

    def weight_less_inertia(self, accelerations: Array, body: int | None = None) -> Array:
        """Sum (n, 3) of the weights less the inertia forces of all bodies, or of one, of free accelerations (n, f), in world axes [N]."""
        left = self.weight - self.all_rates(accelerations) * self.inertia
        some = slice(0, self._rigid, 3) if body is None else slice(3 * body, 3 * body + 1)
        along, across = left[:, some], left[:, some.start + 1 : some.stop + 1 : some.step]
        return to_world(self.plane, along.sum(axis=1) + 1j * across[:, : along.shape[1]].sum(axis=1))

    # ------------------------------------------------------------------------------------------------------------------- springs

    def geometry(self, coordinates: Array, rates: Array) -> LineGeometry:
        """The line springs at all coordinates and rates (n, k)."""
        lines, rigid = self.lines, self._rigid
        turned = np.exp(1j * coordinates[:, 2:rigid:3])
        place = self.centers + coordinates[:, :rigid:3] + 1j * coordinates[:, 1:rigid:3]
        speed = rates[:, :rigid:3] + 1j * rates[:, 1:rigid:3]
        arm1, arm2 = turned[:, lines.first], turned[:, lines.second]
        if self.flexible:
            bent1, bent2 = (arm[:, :, None] * shapes for arm, shapes in zip((arm1, arm2), self.shapes, strict=True))
            arm1 = arm1 * lines.arm1 + np.einsum("nsq,nq->ns", bent1, coordinates[:, rigid:])
            arm2 = arm2 * lines.arm2 + np.einsum("nsq,nq->ns", bent2, coordinates[:, rigid:])
        else:
            arm1, arm2 = arm1 * lines.arm1, arm2 * lines.arm2
        against = (np.where(lines.turning, turned[:, lines.first], 1.0) * lines.direction).conj()
        gap = against * (place[:, lines.second] - place[:, lines.first] + (arm2 - arm1))
        lever1, lever2 = against * arm1 + lines.turning * gap, against * arm2
        apart = against * (speed[:, lines.second] - speed[:, lines.first])
        spin1, spin2 = rates[:, 3 * lines.first + 2], rates[:, 3 * lines.second + 2]
        opening = apart.real - lever2.imag * spin2 + lever1.imag * spin1
        bends = None
        if self.flexible:
            bends = against[:, :, None] * bent1, against[:, :, None] * bent2
            opening += np.einsum("nsq,nq->ns", (bends[1] - bends[0]).real, rates[:, rigid:])
        return LineGeometry(against, gap.real - lines.rest, opening, lever1, lever2, apart, spin1, spin2, bends)

    def spring_forces(self, coordinates: Array, rates: Array, derivatives: bool = True) -> SpringForces:
        """Forces of all springs and of weight on the free coordinates, at all coordinates and rates (n, k)."""
        lines, turns, turning = self.lines, self.turns, self._turning
        at = self.geometry(coordinates, rates)
        pull = -(lines.stiffness * at.extension + lines.damping * at.opening)  # on the second body, along the direction
        gradient = self._gradient(at)
        moment = -(self.turning_rates(coordinates) * turns.stiffness + self.turning_rates(rates) * turns.damping)
        force = np.matmul(pull[:, None, :], gradient)[:, 0] + product(moment, turning) + self.free_weight
        if self.flexible:
            force -= self.to_free(coordinates * self._of_shapes[0] + rates * self._of_shapes[1])
        if not derivatives:
            return SpringForces(force, None, None)
        yielding = lines.stiffness[:, None] * gradient + lines.damping[:, None] * self._gradient_rate(at, rates)
        transposed = gradient.transpose(0, 2, 1)
        stiffness = np.matmul(transposed, yielding) - self._bend(at, pull) + turning.T @ (turns.stiffness[:, None] * turning)
        damping = np.matmul(transposed, lines.damping[:, None] * gradient) + turning.T @ (turns.damping[:, None] * turning)
        if self.flexible:
            stiffness += self.carry.T @ (self._of_shapes[0][:, None] * self.carry)
            damping += self.carry.T @ (self._of_shapes[1][:, None] * self.carry)
        return SpringForces(force, stiffness, damping)

    def joint_motion(self, at: LineGeometry) -> list[tuple[OpenJoint, tuple[Array, Array]]]:
        """The preloaded joints that may open, each with its extension and the rate of that, (n,) each, where the springs are so."""
        rest = self.lines.rest
        return [(each, (at.extension[:, each.spring] + rest[each.spring], at.opening[:, each.spring])) for each in self.open_joints]

    def joint_motions(self, coordinates: Array, rates: Array) -> list[JointMotion]:
        """The preloaded joints that may open, with the forces of the springs that always hold."""
        lines, at, found = self.lines, self.geometry(coordinates, rates), []
        for joint, (extension, rate) in self.joint_motion(at):
            k = joint.spring
            pull = lines.stiffness[k] * at.extension[:, k] + lines.damping[k] * at.opening[:, k]
            found.append(JointMotion(joint, extension, rate, pull, to_world(self.plane, lines.sign[k] * at.against[:, k].conj())))
        return found

    def bearing_forces(self, coordinates: Array, rates: Array) -> Array:
        """Forces (bearings, n, 3) of the springs, parent on child or link1 on link2, in world axes [N]."""
        lines, at = self.lines, self.geometry(coordinates, rates)
        forces = -(lines.stiffness * at.extension + lines.damping * at.opening) * lines.sign * at.against.conj()
        found = np.zeros((len(self.press.bearings), len(coordinates)), dtype=complex)
        for spring, number in enumerate(lines.bearing):
            if number >= 0:
                found[number] += forces[:, spring]
        return to_world(self.plane, found)

    def lost_power(self, coordinates: Array, rates: Array) -> Array:
        """Power (n,) lost in the dampers [W]."""
        opening = self.geometry(coordinates, rates).opening
        return np.asarray(
            opening**2 @ self.lines.damping + self.turning_rates(rates) ** 2 @ self.turns.damping + rates**2 @ self._of_shapes[1]
        )

    def kinetic_energy(self, coordinates: Array, rates: Array) -> Array:
        """Kinetic energy (n,) of all bodies [J]."""
        found: Array = 0.5 * (rates**2 @ self.inertia)
        for link in self.flexible:
            q, dq, spin = coordinates[:, link.columns], rates[:, link.columns], rates[:, 3 * link.body + 2]
            found += spin**2 * (q @ link.stretch + 0.5 * link.mass * (q**2).sum(axis=1)) + spin * ((q @ link.swirl) * dq).sum(axis=1)
        return found

    def stored_energy(self, coordinates: Array) -> Array:
        """Energy (n,) of springs and weights [J]."""
        at, twist = self.geometry(coordinates, np.zeros_like(coordinates)), self.turning_rates(coordinates)
        extension, joints = at.extension, sum(joint.stored(motion[0]) for joint, motion in self.joint_motion(at))
        found = extension**2 @ self.lines.stiffness + twist**2 @ self.turns.stiffness + coordinates**2 @ self._of_shapes[0]
        return np.asarray(0.5 * found + joints - coordinates @ self.weight)

    @cached_property
    def _of_shapes(self) -> Array:
        """(2, k) stiffnesses and dampings of the flexible links' shapes; zero of all other coordinates."""
        found = np.zeros((2, len(self.drawn)))
        for link in self.flexible:
            found[:, link.columns] = link.stiffness, link.damping
        return found

    # --------------------------------------------------------------------------------------------------- flexible links in a turning frame

    @property
    def has_constant_mass(self) -> bool:
        """Whether no inertia forces depend on the state."""
        return not self.flexible

    def varying_inertia(self, coordinates: Array, rates: Array, accelerations: Array) -> VaryingInertia:
        """Inertia forces on the free coordinates, and their derivatives by these, beside those of the constant mass matrix.

        With T of `flexible_link` they are d/dt dT/dy' - dT/dy for the turn phi and the shapes' coordinates q of each flexible link.
        """
        count, free = len(coordinates), self.free
        force = np.zeros((count, free))
        by_place, by_rate, by_acceleration = (np.zeros((count, free, free)) for _ in range(3))
        for link in self.flexible:
            turn, own = 3 * link.body + 2, link.columns
            q, dq, ddq = (each[:, own] for each in (coordinates, rates, accelerations))
            spin, growing = rates[:, turn, None], accelerations[:, turn, None]
            lever, around, whirl = link.stretch + link.mass * q, q @ link.swirl.T, dq @ link.swirl.T
            excess = 2 * q @ link.stretch + link.mass * (q**2).sum(axis=1)
            phi = int(np.argmax(self.carry[turn]))
            at = slice(free - 1 - (len(self.drawn) - own.start), free - 1 - (len(self.drawn) - own.stop))
            shapes = np.arange(at.start, at.stop)
            force[:, phi] += excess * growing[:, 0] + 2 * spin[:, 0] * (lever * dq).sum(axis=1) - (around * ddq).sum(axis=1)
            force[:, at] -= growing * around + 2 * spin * whirl + spin**2 * lever
            by_place[:, phi, at] += 2 * growing * lever + 2 * link.mass * spin * dq + ddq @ link.swirl.T
            by_place[:, at, at] -= growing[:, :, None] * link.swirl
            by_place[:, shapes, shapes] -= link.mass * spin**2
            by_rate[:, phi, at] += 2 * spin * lever
            by_rate[:, phi, phi] += 2 * (lever * dq).sum(axis=1)
            by_rate[:, at, at] -= 2 * spin[:, :, None] * link.swirl
            by_rate[:, at, phi] -= 2 * whirl + 2 * spin * lever
            by_acceleration[:, phi, phi] += excess
            by_acceleration[:, phi, at] -= around
            by_acceleration[:, at, phi] -= around
        return VaryingInertia(force, by_place, by_rate, by_acceleration, np.zeros((count, free)))

    @cached_property
    def _angles(self) -> Array:
        """(T, k) gradients of the angles of `turns`."""
        gradient, rows = np.zeros((len(self.turns.first), len(self.drawn))), np.arange(len(self.turns.first))
        gradient[rows, 3 * self.turns.first + 2] = -1.0
        gradient[rows, 3 * self.turns.second + 2] += 1.0
        return gradient

    def turning_rates(self, rates: Array) -> Array:
        """(n, T) turning speeds of `turns`, or their angles, of rates or coordinates (n, k)."""
        return product(rates, self._angles.T)

    @cached_property
    def _turning(self) -> Array:
        """(T, f) likewise by the free coordinates."""
        return self._angles @ self.carry

    @cached_property
    def _kept(self) -> tuple[Indices, Array] | None:
        """Which of all coordinates each free one is, and its sign; None where conditions tie several together."""
        entries = np.count_nonzero(self.carry, axis=0)
        if (entries != 1).any() or (np.abs(self.carry[self.carry != 0]) != 1.0).any():
            return None
        rows = np.argmax(self.carry != 0, axis=0)
        return rows, self.carry[rows, np.arange(self.free)]

    def to_free(self, columns: Array) -> Array:
        """Gradients (..., f) by the free coordinates, of those by all (..., k)."""
        return columns[..., self._kept[0]] * self._kept[1] if self._kept is not None else np.asarray(columns @ self.carry)

    def to_free_twice(self, matrices: Array) -> Array:
        """Second derivatives (n, f, f) by the free coordinates, of those by all."""
        if self._kept is not None:
            rows, signs = self._kept
            return np.asarray(matrices[:, rows[:, None], rows] * np.multiply.outer(signs, signs))
        return np.asarray(self.carry.T @ matrices @ self.carry)

    def _gradient(self, at: LineGeometry) -> Array:
        """Gradients (n, S, f) of the extensions."""
        bent = None if at.bends is None else (at.bends[1] - at.bends[0]).real
        return self._placed(at.against.real, -at.against.imag, -at.lever2.imag, at.lever1.imag, bent)

    def _gradient_rate(self, at: LineGeometry, rates: Array) -> Array:
        """Rates (n, S, f) of the gradients, which are the gradients of the rates of the extensions."""
        turning = self.lines.turning
        spin = at.spin1 * turning
        first = np.where(
            turning > 0,
            at.apart.imag + at.spin2 * at.lever2.real - at.spin1 * at.lever1.real,
            at.spin1 * at.lever1.real,
        )
        rate = -1j * spin * at.against
        second = (spin - at.spin2) * at.lever2.real
        if at.bends is None:
            return self._placed(rate.real, -rate.imag, second, first, None)
        flow1, flow2 = (np.einsum("nsq,nq->ns", bend, rates[:, self._rigid :]).imag for bend in at.bends)
        first, second = first + np.where(turning > 0, flow2, flow1), second - flow2
        bent = at.spin1[:, :, None] * at.bends[0].imag - (at.spin2 - spin)[:, :, None] * at.bends[1].imag
        return self._placed(rate.real, -rate.imag, second, first, bent)

    def _placed(self, x: Array, z: Array, second: Array, first: Array, bent: Array | None) -> Array:
        """Derivatives (n, S, f) from those by x and z of the second body, which are minus those of the first, and by both
        angles, (n, S) each, and from those by the shapes' coordinates (n, S, Q)."""
        lines, rows = self.lines, np.arange(len(self.lines.first))
        found = np.zeros((len(x), len(rows), len(self.drawn)))
        found[:, rows, 3 * lines.first] = -x
        found[:, rows, 3 * lines.first + 1] = -z
        found[:, rows, 3 * lines.first + 2] = first
        found[:, rows, 3 * lines.second] = x
        found[:, rows, 3 * lines.second + 1] = z
        found[:, rows, 3 * lines.second + 2] = second
        if bent is not None:
            found[:, :, self._rigid :] = bent
        return self.to_free(found)

    def _bend(self, at: LineGeometry, pull: Array) -> Array:
        """(n, f, f): second derivatives of the extensions times the pulls (n, S), summed."""
        lines, size = self.lines, len(self.drawn)
        found = np.zeros((len(pull), size, size))
        own1 = np.where(lines.turning > 0, -at.lever1.real, at.lever1.real) * pull
        own2 = -at.lever2.real * pull
        angles = np.arange(2, self._rigid, 3)
        found[:, angles, angles] = own1 @ self._at_first + own2 @ self._at_second
        for k in np.flatnonzero(lines.turning):
            a, b = 3 * int(lines.first[k]), 3 * int(lines.second[k])
            along = 1j * at.against[:, k].conj() * pull[:, k]
            for row, values in ((b, along.real), (b + 1, along.imag), (a, -along.real), (a + 1, -along.imag), (b + 2, -own2[:, k])):
                found[:, row, a + 2] += values
                found[:, a + 2, row] += values
        if at.bends is not None:
            self._add_bent(at, pull, found)
        return self.to_free_twice(found)

    def _add_bent(self, at: LineGeometry, pull: Array, found: Array) -> None:
        """Add the second derivatives by turns and shapes' coordinates, times the pulls (n, S), to a matrix (n, k, k)."""
        assert at.bends is not None
        lines, shapes = self.lines, slice(self._rigid, None)
        pulled1, pulled2 = (pull[:, :, None] * bend.imag for bend in at.bends)
        firsts = np.where(lines.turning[:, None] > 0, pulled2, pulled1)  # a direction that turns sees point 2 move
        for bodies, values in ((self._at_first, firsts), (self._at_second, -pulled2)):
            by_turn = np.einsum("nsq,sb->nbq", values, bodies)
            found[:, 2 : self._rigid : 3, shapes] += by_turn
            found[:, shapes, 2 : self._rigid : 3] += by_turn.transpose(0, 2, 1)

    @cached_property
    def _at_first(self) -> Array:
        return _one_hot(self.lines.first, len(self.centers))

    @cached_property
    def _at_second(self) -> Array:
        return _one_hot(self.lines.second, len(self.centers))


class LineGeometry(NamedTuple):
    """Line springs at n states; complex numbers are components along the direction of each spring and across it.

    Attributes:
        against: (n, S) conjugates of the directions in the plane's axes.
        extension: (n, S) from where the spring is slack [m].
        opening: (n, S) rates of the extensions [m/s].
        lever1: (n, S) points 1 from the centre of mass of their body [m]; where the direction turns with that body, points 2 from there.
        lever2: (n, S) points 2 from the centre of mass of their body [m].
        apart: (n, S) velocities of the second body's centre of mass less those of the first [m/s].
        spin1: (n, S) turning speeds of the first body [rad/s].
        spin2: (n, S) of the second.
        bends: (n, S, Q) displacements of points 1 and of points 2 by the coordinates of flexible links' shapes [-]; None: there are none.
    """

    against: ComplexArray
    extension: Array
    opening: Array
    lever1: ComplexArray
    lever2: ComplexArray
    apart: ComplexArray
    spin1: Array
    spin2: Array
    bends: tuple[ComplexArray, ComplexArray] | None = None


def _one_hot(columns: Indices, count: int) -> Array:
    """(S, count) with a 1 in the given column of each row."""
    found = np.zeros((len(columns), count))
    found[np.arange(len(columns)), columns] = 1.0
    return found
