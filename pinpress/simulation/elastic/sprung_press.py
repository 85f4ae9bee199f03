"""A planar press as bodies joined by springs: its inertias, its spring forces, and their derivatives, at many states at once.

Every link is a free body of the plane with three coordinates: the displacement x + i z of its centre of mass, in the axes of the plane, and
its turn phi, both from the drawn pose. A bearing is two springs across each other between a point of one body and a point of another. A
guide is a spring across its axis, which turns with the body that carries it, and one against turning. With the arms s of the points, turned
by u = exp(i phi), and d from point 1 to point 2, a spring along the direction n has the extension

    y = Re(conj(n) d),   d = r2 + u2 s2 - r1 - u1 s1

and pulls with k y + c y'. Its gradient and second derivatives stand in closed form, so that Newton's method has exact Jacobians.

What the springs do not join is kept rigidly: the crank by its angle, gear pairs by their ratio, a crown by its columns. These conditions
are linear, so that the coordinates of all bodies are a constant matrix times the free ones: ``carry @ y + drawn``. The last of the free
ones is the angle of the crank, which may be prescribed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.quantities import Array, ComplexArray
from ...engines.planar.engine import PlanarEngine
from ...engines.planar.kinematics import basis_acceleration, basis_at, basis_velocity
from ...engines.planar.model import Plane, to_world
from ...kinematics.motion import Motion
from ...linkage.linkage import Linkage
from .contact import OpenPin
from .press_on_springs import SpringForces

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

    Attributes:
        press: the linkage.
        centers: (bodies + 1,) centres of mass in the drawn pose; of the frame the world origin [m].
        inertia: (3 (bodies + 1),) masses and moments of inertia on the diagonal: m, m, J of every body [kg, kg m2].
        weight: (3 (bodies + 1),) generalised forces of gravity [N].
        lines: springs of bearings and guides.
        turns: springs against turning.
        carry: (3 (bodies + 1), f) free coordinates, the crank's angle last, to all coordinates.
        drawn: (3 (bodies + 1),) all coordinates where the free ones are zero.
        crown: the body that carries the bearings on the frame, on its columns; None: the frame carries them.
        rotor: the body that a shaft joins to the crank; None: the crank is the shaft's own.
        open_pins: pins with clearance, which have no springs in ``lines``.
        closed: the same press without clearance; None where there is none.
    """

    press: Linkage
    centers: ComplexArray
    inertia: Array
    weight: Array
    lines: LineSprings
    turns: TurningSprings
    carry: Array
    drawn: Array
    crown: int | None = None
    rotor: int | None = None
    open_pins: tuple[OpenPin, ...] = ()
    closed: SprungPress | None = None

    @property
    def free(self) -> int:
        """Number of free coordinates."""
        return int(self.carry.shape[1])

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

    def all_coordinates(self, free: Array) -> Array:
        """All coordinates (n, 3 (bodies + 1)) of free ones (n, f)."""
        return np.asarray(free @ self.carry.T + self.drawn)

    def free_coordinates(self, coordinates: Array) -> Array:
        """Free coordinates (n, f) of all coordinates (n, 3 (bodies + 1))."""
        return self.free_rates(coordinates - self.drawn)

    def free_rates(self, rates: Array) -> Array:
        """Free rates or accelerations (n, f) of those of all coordinates (n, 3 (bodies + 1))."""
        return np.asarray(rates @ self._back)

    @cached_property
    def _back(self) -> Array:
        """(3 (bodies + 1), f) all rates to the free ones."""
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
        return engine.plane.dense

    def rigid_coordinates(self, motion: Motion) -> tuple[Array, Array, Array]:
        """All coordinates, rates and accelerations (n, 3 (bodies + 1)) of the rigid press in a motion."""
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
        sense = float(self.plane.sense[driver])
        angle, speed = (
            sense * (each[:, 3 * driver + 2] - (each[:, 3 * parent + 2] if parent >= 0 else 0.0)) for each in (coordinates, rates)
        )
        return angle, speed

    def displacement(self, coordinates: Array, motion: Motion) -> Array:
        """(n, links, 3) of all moving links beside the rigid press in a motion, along the axes of the plane [m], and turns [rad]."""
        moved = coordinates - self.rigid_coordinates(motion)[0]
        return np.asarray(moved.reshape(len(moved), -1, 3)[:, : self.press.model.nv])

    def weight_less_inertia(self, accelerations: Array) -> Array:
        """Sum (n, 3) of the weights less the inertia forces of all bodies, of free accelerations (n, f), in world axes [N]."""
        left = self.weight - (accelerations @ self.carry.T) * self.inertia
        return to_world(self.plane, left[:, ::3].sum(axis=1) + 1j * left[:, 1::3].sum(axis=1))

    # ------------------------------------------------------------------------------------------------------------------- springs

    def geometry(self, coordinates: Array, rates: Array) -> LineGeometry:
        """The line springs at all coordinates and rates (n, 3 (bodies + 1))."""
        lines = self.lines
        turned = np.exp(1j * coordinates[:, 2::3])
        place = self.centers + coordinates[:, ::3] + 1j * coordinates[:, 1::3]
        speed = rates[:, ::3] + 1j * rates[:, 1::3]
        arm1, arm2 = turned[:, lines.first] * lines.arm1, turned[:, lines.second] * lines.arm2
        against = (np.where(lines.turning, turned[:, lines.first], 1.0) * lines.direction).conj()
        gap = against * (place[:, lines.second] - place[:, lines.first] + (arm2 - arm1))
        lever1, lever2 = against * arm1 + lines.turning * gap, against * arm2
        apart = against * (speed[:, lines.second] - speed[:, lines.first])
        spin1, spin2 = rates[:, 3 * lines.first + 2], rates[:, 3 * lines.second + 2]
        opening = apart.real - lever2.imag * spin2 + lever1.imag * spin1
        return LineGeometry(against, gap.real - lines.rest, opening, lever1, lever2, apart, spin1, spin2)

    def spring_forces(self, coordinates: Array, rates: Array, derivatives: bool = True) -> SpringForces:
        """Forces of all springs and of weight on the free coordinates, at all coordinates and rates (n, 3 (bodies + 1))."""
        lines, turns, turning = self.lines, self.turns, self._turning
        at = self.geometry(coordinates, rates)
        pull = -(lines.stiffness * at.extension + lines.damping * at.opening)  # on the second body, along the direction
        gradient = self._gradient(at)
        moment = -((coordinates @ self._angles.T) * turns.stiffness + (rates @ self._angles.T) * turns.damping)
        force = np.matmul(pull[:, None, :], gradient)[:, 0] + moment @ turning + self.free_weight
        if not derivatives:
            return SpringForces(force, None, None)
        yielding = lines.stiffness[:, None] * gradient + lines.damping[:, None] * self._gradient_rate(at)
        transposed = gradient.transpose(0, 2, 1)
        stiffness = np.matmul(transposed, yielding) - self._bend(at, pull) + turning.T @ (turns.stiffness[:, None] * turning)
        damping = np.matmul(transposed, lines.damping[:, None] * gradient) + turning.T @ (turns.damping[:, None] * turning)
        return SpringForces(force, stiffness, damping)

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
        return np.asarray(opening**2 @ self.lines.damping + self.turning_rates(rates) ** 2 @ self.turns.damping)

    def kinetic_energy(self, coordinates: Array, rates: Array) -> Array:
        """Kinetic energy (n,) of all bodies [J]."""
        return np.asarray(0.5 * (rates**2 @ self.inertia))

    def stored_energy(self, coordinates: Array) -> Array:
        """Energy (n,) of springs and weights [J]."""
        extension, twist = self.geometry(coordinates, np.zeros_like(coordinates)).extension, self.turning_rates(coordinates)
        return np.asarray(0.5 * (extension**2 @ self.lines.stiffness + twist**2 @ self.turns.stiffness) - coordinates @ self.weight)

    @cached_property
    def _angles(self) -> Array:
        """(T, 3 (bodies + 1)) gradients of the angles of `turns`."""
        gradient, rows = np.zeros((len(self.turns.first), len(self.drawn))), np.arange(len(self.turns.first))
        gradient[rows, 3 * self.turns.first + 2] = -1.0
        gradient[rows, 3 * self.turns.second + 2] += 1.0
        return gradient

    def turning_rates(self, rates: Array) -> Array:
        """(n, T) turning speeds of `turns`, or their angles, of rates or coordinates (n, 3 (bodies + 1))."""
        return np.asarray(rates @ self._angles.T)

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
        """Gradients (..., f) by the free coordinates, of those by all (..., 3 (bodies + 1))."""
        return columns[..., self._kept[0]] * self._kept[1] if self._kept is not None else np.asarray(columns @ self.carry)

    def to_free_twice(self, matrices: Array) -> Array:
        """Second derivatives (n, f, f) by the free coordinates, of those by all."""
        if self._kept is not None:
            rows, signs = self._kept
            return np.asarray(matrices[:, rows[:, None], rows] * np.multiply.outer(signs, signs))
        return np.asarray(self.carry.T @ matrices @ self.carry)

    def _gradient(self, at: LineGeometry) -> Array:
        """Gradients (n, S, f) of the extensions."""
        return self._placed(at.against.real, -at.against.imag, -at.lever2.imag, at.lever1.imag)

    def _gradient_rate(self, at: LineGeometry) -> Array:
        """Rates (n, S, f) of the gradients, which are the gradients of the rates of the extensions."""
        turning = self.lines.turning
        spin = at.spin1 * turning
        first = np.where(
            turning > 0,
            at.apart.imag + at.spin2 * at.lever2.real - at.spin1 * at.lever1.real,
            at.spin1 * at.lever1.real,
        )
        rate = -1j * spin * at.against
        return self._placed(rate.real, -rate.imag, (spin - at.spin2) * at.lever2.real, first)

    def _placed(self, x: Array, z: Array, second: Array, first: Array) -> Array:
        """Derivatives (n, S, f) from those by x and z of the second body, which are minus those of the first, and by both
        angles, (n, S) each."""
        lines, rows = self.lines, np.arange(len(self.lines.first))
        found = np.zeros((len(x), len(rows), len(self.drawn)))
        found[:, rows, 3 * lines.first] = -x
        found[:, rows, 3 * lines.first + 1] = -z
        found[:, rows, 3 * lines.first + 2] = first
        found[:, rows, 3 * lines.second] = x
        found[:, rows, 3 * lines.second + 1] = z
        found[:, rows, 3 * lines.second + 2] = second
        return self.to_free(found)

    def _bend(self, at: LineGeometry, pull: Array) -> Array:
        """(n, f, f): second derivatives of the extensions times the pulls (n, S), summed."""
        lines, size = self.lines, len(self.drawn)
        found = np.zeros((len(pull), size, size))
        own1 = np.where(lines.turning > 0, -at.lever1.real, at.lever1.real) * pull
        own2 = -at.lever2.real * pull
        angles = np.arange(2, size, 3)
        found[:, angles, angles] = own1 @ self._at_first + own2 @ self._at_second
        for k in np.flatnonzero(lines.turning):
            a, b = 3 * int(lines.first[k]), 3 * int(lines.second[k])
            along = 1j * at.against[:, k].conj() * pull[:, k]
            for row, values in ((b, along.real), (b + 1, along.imag), (a, -along.real), (a + 1, -along.imag), (b + 2, -own2[:, k])):
                found[:, row, a + 2] += values
                found[:, a + 2, row] += values
        return self.to_free_twice(found)

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
    """

    against: ComplexArray
    extension: Array
    opening: Array
    lever1: ComplexArray
    lever2: ComplexArray
    apart: ComplexArray
    spin1: Array
    spin2: Array


def _one_hot(columns: Indices, count: int) -> Array:
    """(S, count) with a 1 in the given column of each row."""
    found = np.zeros((len(columns), count))
    found[np.arange(len(columns)), columns] = 1.0
    return found
