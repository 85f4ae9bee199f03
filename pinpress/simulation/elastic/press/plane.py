"""Bodies of a plane and the lines between their points: extensions of springs and their derivatives, at many states at once.

Every link is a free body of the plane with three coordinates: the displacement x + i z of its centre of mass, in the axes of the plane, and
its turn phi, both from the drawn pose. A bearing is two lines across each other between a point of one body and a point of another. A guide
is a line across its axis, which turns with the body that carries it. With the arms s of the points, turned by u = exp(i phi), and d from
point 1 to point 2, a line along the direction n has the extension

    y = Re(conj(n) d),   d = r2 + u2 s2 - r1 - u1 s1

Its gradient and second derivatives stand in closed form, so that Newton's method has exact Jacobians. A flexible link has coordinates of
its shapes too, which move the points s of its lines (`flexible_link`); they stand after those of all bodies.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ....common.errors import PinpressError, shown
from ....common.quantities import Array, ComplexArray
from ....engines.planar.engine import PlanarEngine
from ....engines.planar.kinematics import basis_acceleration, basis_at, basis_velocity
from ....engines.planar.model import Plane, to_complex, to_world
from ....kinematics.motion import Motion
from ....linkage.linkage import Linkage
from ..flexible_link import FlexibleBody
from ..panels import Indices
from .geometry import PointMotion, VaryingInertia


class Lines(NamedTuple):
    """Lines between points of two bodies, S of them; the ground is the last body.

    Attributes:
        first: (S,) bodies of the points 1.
        second: (S,) bodies of the points 2.
        arm1: (S,) points 1 from the centre of mass of their body, in the drawn pose [m].
        arm2: (S,) points 2 from the centre of mass of theirs [m].
        direction: (S,) directions n in the drawn pose, of length 1.
        turning: (S,) 1 where the direction turns with the first body, else 0.
    """

    first: Indices
    second: Indices
    arm1: ComplexArray
    arm2: ComplexArray
    direction: ComplexArray
    turning: Array


class PlaneState(NamedTuple):
    """Bodies of a plane at n states.

    Attributes:
        coordinates: (n, k) of all bodies.
        rates: (n, k).
        turned: (n, bodies) exp(i phi).
        place: (n, bodies) centres of mass [m].
        speed: (n, bodies) their velocities [m/s].
    """

    coordinates: Array
    rates: Array
    turned: ComplexArray
    place: ComplexArray
    speed: ComplexArray


class LineStrains(NamedTuple):
    """Lines at n states; complex numbers are components along the direction of each line and across it.

    Attributes:
        extension: (n, S) from the drawn pose [m].
        opening: (n, S) rates of the extensions [m/s].
        rates: (n, k) of all coordinates.
        against: (n, S) conjugates of the directions in the plane's axes.
        lever1: (n, S) points 1 from the centre of mass of their body [m]; where the direction turns with that body, points 2 from there.
        lever2: (n, S) points 2 from the centre of mass of their body [m].
        apart: (n, S) velocities of the second body's centre of mass less those of the first [m/s].
        spin1: (n, S) turning speeds of the first body [rad/s].
        spin2: (n, S) of the second.
        bends: (n, S, Q) displacements of points 1 and of points 2 by the coordinates of flexible links' shapes [-]; None: there are none.
    """

    extension: Array
    opening: Array
    rates: Array
    against: ComplexArray
    lever1: ComplexArray
    lever2: ComplexArray
    apart: ComplexArray
    spin1: Array
    spin2: Array
    bends: tuple[ComplexArray, ComplexArray] | None = None


@dataclass(frozen=True, eq=False, repr=False)
class PlaneGeometry:
    """Bodies of a planar press and the lines of its springs; see `geometry.Geometry`.

    Bodies are the links, counted as joints in v, then a crown and a rotor if there are any, the frame, and the ground if the frame stands
    on mounts. Coordinates are 3 of each body, Q of the flexible links' shapes: k in all.

    Attributes:
        press: the linkage.
        centers: (bodies,) centres of mass in the drawn pose; of the ground the world origin [m].
        inertia: (k,) masses and moments of inertia on the diagonal: m, m, J of every body, m of every shape [kg, kg m2].
        weight: (k,) generalised forces of gravity [N].
        lines: of bearings, guides, columns and mounts.
        shapes: (2, S, Q) by the coordinates of the flexible links, displacements of points 1 and 2 of the lines [-].
        crown: the body that carries the bearings on the frame, on its columns; None: the frame carries them.
        rotor: the body that a shaft joins to the crank; None: the crank is the shaft's own.
        base: the frame, where it stands on mounts.
        flexible: the flexible links.
    """

    press: Linkage
    centers: ComplexArray
    inertia: Array
    weight: Array
    lines: Lines
    shapes: ComplexArray
    crown: int | None = None
    rotor: int | None = None
    base: int | None = None
    flexible: tuple[FlexibleBody, ...] = ()

    @property
    def constant_mass(self) -> bool:
        return not self.flexible

    @property
    def rigid_size(self) -> int:
        """Number of the coordinates of bodies, after which those of shapes begin."""
        return 3 * len(self.centers)

    @cached_property
    def plane(self) -> Plane:
        """Constants of the planar linkage."""
        return plane_of(self.press)

    # ----------------------------------------------------------------------------------------------------------------- the linkage

    def rigid(self, motion: Motion) -> tuple[Array, Array, Array]:
        plane, states, count = self.plane, motion.states(self.press), self.press.model.nv
        basis = basis_at(plane, states.position)
        rows = plane.origins + plane.centers
        points = [rows @ basis - self.centers[:count, None], rows @ basis_velocity(plane, basis, states.v)]
        points.append(rows @ basis_acceleration(plane, basis, states.v, states.a))
        result = [np.zeros((states.v.shape[1], len(self.inertia))) for _ in range(3)]
        drivers = motion.crank_angle, motion.crank_speed, motion.crank_acceleration
        for values, place, joints, driver in zip(result, points, (states.position, states.v, states.a), drivers, strict=True):
            values[:, : 3 * count : 3], values[:, 1 : 3 * count : 3] = place.real.T, place.imag.T
            values[:, 2 : 3 * count : 3] = (plane.spin @ joints).T
            if self.rotor is not None:
                values[:, 3 * self.rotor + 2] = plane.sense[plane.driver] * driver
        return result[0], result[1], result[2]

    def crank(self, values: Array) -> Array:
        driver, parent = self.plane.driver, self.plane.parents[self.plane.driver]
        carrier = parent if parent >= 0 else self.base
        turn = values[:, 3 * driver + 2] - (0.0 if carrier is None else values[:, 3 * carrier + 2])
        return np.asarray(float(self.plane.sense[driver]) * turn)

    def displacement(self, coordinates: Array, motion: Motion) -> Array:
        """(n, links, 3) along the axes of the plane [m], and turns [rad]."""
        moved = coordinates - self.rigid(motion)[0]
        return np.asarray(moved[:, : 3 * self.press.model.nv].reshape(len(moved), -1, 3))

    def total(self, forces: Array, body: int | None = None) -> Array:
        bodies = slice(0, self.rigid_size, 3) if body is None else slice(3 * body, 3 * body + 1)
        along, across = forces[:, bodies], forces[:, bodies.start + 1 : bodies.stop + 1 : bodies.step]
        return to_world(self.plane, along.sum(axis=1) + 1j * across[:, : along.shape[1]].sum(axis=1))

    # ------------------------------------------------------------------------------------------------------------------- states

    def state(self, coordinates: Array, rates: Array, derivatives: bool = True) -> PlaneState:
        rigid = self.rigid_size
        return PlaneState(
            coordinates,
            rates,
            np.exp(1j * coordinates[:, 2:rigid:3]),
            self.centers + coordinates[:, :rigid:3] + 1j * coordinates[:, 1:rigid:3],
            rates[:, :rigid:3] + 1j * rates[:, 1:rigid:3],
        )

    def point(self, state: PlaneState, body: int, arm: complex) -> PointMotion:
        column, turned = 3 * body, arm * state.turned[:, body]
        place = state.place[:, body] + turned
        by = np.zeros((*state.coordinates.shape, 2))
        by[:, column, 0] = by[:, column + 1, 1] = 1.0
        by[:, column + 2, 0], by[:, column + 2, 1] = -turned.imag, turned.real
        bent = -np.stack([turned.real, turned.imag], axis=1)[:, None, None]
        return PointMotion(np.stack([place.real, place.imag], axis=1), by, np.array([column + 2]), bent)

    def with_lines(self, kept: Any) -> PlaneGeometry:
        return replace(self, lines=Lines._make(column[kept] for column in self.lines), shapes=self.shapes[:, kept])

    # ------------------------------------------------------------------------------------------------------------------- lines

    def strains(self, state: PlaneState) -> LineStrains:
        lines, rates, turned = self.lines, state.rates, state.turned
        arm1, arm2 = turned[:, lines.first], turned[:, lines.second]
        if self.flexible:
            bent1, bent2 = (arm[:, :, None] * shapes for arm, shapes in zip((arm1, arm2), self.shapes, strict=True))
            shape = state.coordinates[:, self.rigid_size :]
            arm1 = arm1 * lines.arm1 + np.einsum("nsq,nq->ns", bent1, shape)
            arm2 = arm2 * lines.arm2 + np.einsum("nsq,nq->ns", bent2, shape)
        else:
            arm1, arm2 = arm1 * lines.arm1, arm2 * lines.arm2
        against = (np.where(lines.turning, turned[:, lines.first], 1.0) * lines.direction).conj()
        gap = against * (state.place[:, lines.second] - state.place[:, lines.first] + (arm2 - arm1))
        lever1, lever2 = against * arm1 + lines.turning * gap, against * arm2
        apart = against * (state.speed[:, lines.second] - state.speed[:, lines.first])
        spin1, spin2 = rates[:, 3 * lines.first + 2], rates[:, 3 * lines.second + 2]
        opening = apart.real - lever2.imag * spin2 + lever1.imag * spin1
        bends = None
        if self.flexible:
            bends = against[:, :, None] * bent1, against[:, :, None] * bent2
            opening += np.einsum("nsq,nq->ns", (bends[1] - bends[0]).real, rates[:, self.rigid_size :])
        return LineStrains(gap.real, opening, rates, against, lever1, lever2, apart, spin1, spin2, bends)

    def along(self, strains: LineStrains) -> Array:
        return to_world(self.plane, strains.against.conj())

    def gradient(self, strains: LineStrains) -> Array:
        bent = None if strains.bends is None else (strains.bends[1] - strains.bends[0]).real
        return self._place(strains.against.real, -strains.against.imag, -strains.lever2.imag, strains.lever1.imag, bent)

    def gradient_rate(self, strains: LineStrains) -> Array:
        turning = self.lines.turning
        spin = strains.spin1 * turning
        first = np.where(
            turning > 0,
            strains.apart.imag + strains.spin2 * strains.lever2.real - strains.spin1 * strains.lever1.real,
            strains.spin1 * strains.lever1.real,
        )
        rate = -1j * spin * strains.against
        second = (spin - strains.spin2) * strains.lever2.real
        if strains.bends is None:
            return self._place(rate.real, -rate.imag, second, first, None)
        flow1, flow2 = (np.einsum("nsq,nq->ns", bend, strains.rates[:, self.rigid_size :]).imag for bend in strains.bends)
        first, second = first + np.where(turning > 0, flow2, flow1), second - flow2
        bent = strains.spin1[:, :, None] * strains.bends[0].imag - (strains.spin2 - spin)[:, :, None] * strains.bends[1].imag
        return self._place(rate.real, -rate.imag, second, first, bent)

    def _place(self, x: Array, z: Array, second: Array, first: Array, bent: Array | None) -> Array:
        """Derivatives (n, S, k) from those by x and z of the second body, which are minus those of the first, and by both
        angles, (n, S) each, and from those by the shapes' coordinates (n, S, Q)."""
        lines, rows = self.lines, np.arange(len(self.lines.first))
        gradient = np.zeros((len(x), len(rows), len(self.inertia)))
        gradient[:, rows, 3 * lines.first] = -x
        gradient[:, rows, 3 * lines.first + 1] = -z
        gradient[:, rows, 3 * lines.first + 2] = first
        gradient[:, rows, 3 * lines.second] = x
        gradient[:, rows, 3 * lines.second + 1] = z
        gradient[:, rows, 3 * lines.second + 2] = second
        if bent is not None:
            gradient[:, :, self.rigid_size :] = bent
        return gradient

    def bend(self, strains: LineStrains, pull: Array) -> Array:
        lines, size = self.lines, len(self.inertia)
        matrix = np.zeros((len(pull), size, size))
        by_turn1 = np.where(lines.turning > 0, -strains.lever1.real, strains.lever1.real) * pull
        by_turn2 = -strains.lever2.real * pull
        angles = np.arange(2, self.rigid_size, 3)
        matrix[:, angles, angles] = by_turn1 @ self._at_first + by_turn2 @ self._at_second
        for k in np.flatnonzero(lines.turning):
            a, b = 3 * int(lines.first[k]), 3 * int(lines.second[k])
            along = 1j * strains.against[:, k].conj() * pull[:, k]
            for row, values in ((b, along.real), (b + 1, along.imag), (a, -along.real), (a + 1, -along.imag), (b + 2, -by_turn2[:, k])):
                matrix[:, row, a + 2] += values
                matrix[:, a + 2, row] += values
        if strains.bends is not None:
            self._add_bent(strains, pull, matrix)
        return matrix

    def _add_bent(self, strains: LineStrains, pull: Array, found: Array) -> None:
        """Add the second derivatives by turns and shapes' coordinates, times the pulls (n, S), to a matrix (n, k, k)."""
        assert strains.bends is not None
        rigid, shapes = self.rigid_size, slice(self.rigid_size, None)
        pulled1, pulled2 = (pull[:, :, None] * bend.imag for bend in strains.bends)
        firsts = np.where(self.lines.turning[:, None] > 0, pulled2, pulled1)  # a direction that turns sees point 2 move
        for bodies, values in ((self._at_first, firsts), (self._at_second, -pulled2)):
            by_turn = np.einsum("nsq,sb->nbq", values, bodies)
            found[:, 2:rigid:3, shapes] += by_turn
            found[:, shapes, 2:rigid:3] += by_turn.transpose(0, 2, 1)

    @cached_property
    def _at_first(self) -> Array:
        """(S, bodies) 1 where the body has point 1 of the line."""
        return np.eye(len(self.centers))[self.lines.first]

    @cached_property
    def _at_second(self) -> Array:
        """(S, bodies) 1 where the body has point 2 of the line."""
        return np.eye(len(self.centers))[self.lines.second]

    # --------------------------------------------------------------------------------------------------- flexible links in a turning frame

    def kinetic_energy(self, state: PlaneState) -> Array:
        energy: Array = 0.5 * (state.rates**2 @ self.inertia)
        for link in self.flexible:
            q, dq, spin = state.coordinates[:, link.columns], state.rates[:, link.columns], state.rates[:, 3 * link.body + 2]
            energy += spin**2 * (q @ link.stretch + 0.5 * link.mass * (q**2).sum(axis=1)) + spin * ((q @ link.swirl) * dq).sum(axis=1)
        return energy

    def varying_inertia(self, state: PlaneState, accelerations: Array) -> VaryingInertia:
        """With T of `flexible_link` they are d/dt dT/dy' - dT/dy for the turn phi and the shapes' coordinates q of each flexible link."""
        count, size = state.coordinates.shape
        force = np.zeros((count, size))
        by_place, by_rate, by_acceleration = (np.zeros((count, size, size)) for _ in range(3))
        for link in self.flexible:
            phi, columns = 3 * link.body + 2, link.columns
            q, dq, ddq = (values[:, columns] for values in (state.coordinates, state.rates, accelerations))
            spin, growing = state.rates[:, phi, None], accelerations[:, phi, None]
            lever, around, whirl = link.stretch + link.mass * q, q @ link.swirl.T, dq @ link.swirl.T
            excess = 2 * q @ link.stretch + link.mass * (q**2).sum(axis=1)
            shapes = np.arange(columns.start, columns.stop)
            force[:, phi] += excess * growing[:, 0] + 2 * spin[:, 0] * (lever * dq).sum(axis=1) - (around * ddq).sum(axis=1)
            force[:, columns] -= growing * around + 2 * spin * whirl + spin**2 * lever
            by_place[:, phi, columns] += 2 * growing * lever + 2 * link.mass * spin * dq + ddq @ link.swirl.T
            by_place[:, columns, columns] -= growing[:, :, None] * link.swirl
            by_place[:, shapes, shapes] -= link.mass * spin**2
            by_rate[:, phi, columns] += 2 * spin * lever
            by_rate[:, phi, phi] += 2 * (lever * dq).sum(axis=1)
            by_rate[:, columns, columns] -= 2 * spin[:, :, None] * link.swirl
            by_rate[:, columns, phi] -= 2 * whirl + 2 * spin * lever
            by_acceleration[:, phi, phi] += excess
            by_acceleration[:, phi, columns] -= around
            by_acceleration[:, columns, phi] -= around
        return VaryingInertia(force, by_place, by_rate, by_acceleration)


def plane_of(press: Linkage) -> Plane:
    """Constants of a planar linkage."""
    engine = press.engine("plane")
    assert isinstance(engine, PlanarEngine)
    return engine.plane


class DrawnBodies:
    """A planar press in its drawn pose, all joints at zero.

    Attributes:
        press: the linkage.
        plane: its constants.
        origins: (links,) origins of the joints.
        centers: (links,) centres of mass.
        directions: by the joint of each guide.
    """

    def __init__(self, press: Linkage) -> None:
        self.press = press
        self.plane = plane_of(press)
        basis = basis_at(self.plane, np.zeros((press.model.nv, 1)))
        self.origins: ComplexArray = (self.plane.origins @ basis)[:, 0]
        self.centers: ComplexArray = ((self.plane.origins + self.plane.centers) @ basis)[:, 0]
        self.directions = dict(zip(self.plane.prismatic, (self.plane.directions @ basis)[:, 0], strict=True))

    def point(self, joint: int, point: Array) -> complex:
        """A point of a link, in the frame of its joint (-1: the world), in the axes of the plane [m]."""
        if joint < 0:
            return complex(to_complex(self.plane, point))
        return complex(self.origins[joint] + complex(*(self.plane.frames[joint] @ point)[:2]))

    def bearing(self, number: int) -> tuple[int, complex, int, complex]:
        """Link (-1: the frame) and point of both sides of a bearing: parent and child, or link1 and link2."""
        count = self.press.model.nv
        if number < count:
            return self.plane.parents[number], complex(self.origins[number]), number, complex(self.origins[number])
        loop = self.press.loops[number - count]
        if loop.type == "fixed":
            raise PinpressError(f"loop {shown(loop.name)} of {self.press.name} is welded: elastic motion takes bearings that turn")
        one, two = loop.joint1 - 1, loop.joint2 - 1
        return one, self.point(one, loop.point1), two, self.point(two, loop.point2)
