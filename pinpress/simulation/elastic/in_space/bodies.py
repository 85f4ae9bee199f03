"""A linkage in space as bodies joined by springs: its inertia and spring forces, and their derivatives, at many states at once.

Every body has six coordinates: its centre of mass r in world axes [m], and the small turn w beside its nominal one (`turning`). The last
coordinate is the crank angle p, which turns the nominal bodies along; the crank has no turn about its own axis beside it. Points and
directions of a body are linear in its matrix X = (R, r), and all springs have extensions of the same kind,

    y = a (X2 s2 - X1 s1),

with a direction a of the first body or of the frame, and points or directions s: a bearing's gap along an axis, or the cosine between two
axes that are square to each other unless the bearing twists. They pull with k y + c y'. Inertia is constant by X,

    m r'',   R'' J   with J = tr(I) / 2 - I,

so that the rows of Lagrange's equations are the products of these with the derivatives of X by the coordinates. Loops that hold each other
when they are rigid, as those of a planar press do in space, are determinate here: their springs share what they carry.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....common.products import product
from ....common.quantities import Array
from ....kinematics.motion import Motion, poses
from ....linkage.linkage import Linkage
from ..contact import OpenPin
from ..panels import Indices, VaryingInertia
from ..preloaded_joint import JointSpring, OpenJoint
from ..press_on_springs import JointMotion, SpringForces, frequencies, reference_angle
from .turning import NominalTurns, Turned, turned

KEPT = 2  # sets of states whose matrices are kept


class SpringsInSpace(NamedTuple):
    """Springs between two bodies each, S of them; the frame is the last body.

    Attributes:
        first: (S,) bodies 1.
        second: (S,) bodies 2.
        direction: (S, 3) directions a, in the axes of body 1, or of the frame.
        turning: (S,) 1 where the direction turns with body 1, else 0.
        arm1: (S, 3) s1 of body 1, from its centre of mass in its axes [m or -].
        arm2: (S, 3) s2 of body 2 likewise.
        place: (S,) 1 where s1 and s2 are points, 0 where they are directions.
        stiffness: (S,) [N/m or N m/rad].
        damping: (S,) [N s/m or N m s/rad].
        bearing: (S,) number of the bearing of each.
    """

    first: Indices
    second: Indices
    direction: Array
    turning: Array
    arm1: Array
    arm2: Array
    place: Array
    stiffness: Array
    damping: Array
    bearing: Indices


class _Springs(NamedTuple):
    """Springs at n states: of the extensions y = a b.

    Attributes:
        turned: matrices of the bodies, the frame last.
        along: (n, S, 3) directions a in world axes.
        gap: (n, S, 3) b in world axes.
        extension: (n, S).
        opening: (n, S) rates of the extensions.
        along_rate: (n, S, 3).
        gap_rate: (n, S, 3).
    """

    turned: Turned
    along: Array
    gap: Array
    extension: Array
    opening: Array
    along_rate: Array
    gap_rate: Array


@dataclass(frozen=True, eq=False, repr=False)
class PressInSpace:
    """Constants of a linkage in space on springs; see `PressOnSprings`. Its B bodies are those with mass; the frame is body B.

    Attributes:
        press: the linkage.
        joints: Pinocchio's joints of the bodies.
        crank_body: the body that the driver turns.
        own_axes: (B, 3, 3) principal or other axes of each body in its joint's frame, as columns; vectors of bodies are in these axes.
        lever: (B, 3) centres of mass in the joints' frames and axes [m].
        mass_of: (B,) [kg].
        shape: (B, 3, 3) J = tr(I) / 2 - I of the moments of inertia about the centres of mass [kg m2].
        gravity: (3,) [m/s2].
        nominal: turns of the bodies over the crank angle, and the frame's last.
        springs: of all bearings.
        joined: for each bearing the bodies that it joins, the acting one first.
        alike: for each bearing the one that has its springs: itself, but for joints of a cross without mass, which carries as much.
        preloaded: preloaded joints, each with the number of its spring, which is that of the closed joint.
        open_joints: preloaded joints that may open, whose members have no springs in ``springs``.
        closed: the same press with closed joints; None where it is the same.
    """

    press: Linkage
    joints: tuple[int, ...]
    crank_body: int
    own_axes: Array
    lever: Array
    mass_of: Array
    shape: Array
    gravity: Array
    nominal: NominalTurns
    springs: SpringsInSpace
    joined: tuple[tuple[int, int], ...]
    alike: tuple[int, ...]

    preloaded: tuple[tuple[JointSpring, int], ...] = ()
    open_pins: tuple[OpenPin, ...] = ()
    open_joints: tuple[OpenJoint, ...] = ()
    closed: PressInSpace | None = None
    _last_turned: list[tuple[Turned, Array, Array]] = field(default_factory=list, init=False)

    # ----------------------------------------------------------------------------------------------------------------- coordinates

    @property
    def count(self) -> int:
        """Number of bodies."""
        return len(self.joints)

    @cached_property
    def carry(self) -> Array:
        """(k, f) free coordinates to all: six of each body, those of the frame, and the crank angle."""
        size = 6 * self.count + 7
        return np.asarray(np.eye(size)[:, self._kept])

    @cached_property
    def _kept(self) -> Indices:
        """(f,) which of all coordinates are free: the crank's axis is the third of its own axes."""
        size = 6 * self.count + 7
        left_out = [6 * self.crank_body + 5, *range(6 * self.count, 6 * self.count + 6)]
        return np.array([each for each in range(size) if each not in left_out])

    @property
    def free(self) -> int:
        return len(self._kept)

    @cached_property
    def lowest_frequency(self) -> float:
        """Lowest natural frequency at bottom dead centre, with the crank held and without dampers [rad/s]."""
        return float(frequencies(self.closed or self, reference_angle(self.press))[0])

    def opening(self) -> PressInSpace:
        """The same press with preloaded joints that may open."""
        if not self.preloaded:
            return self
        springs, found = self.springs, []
        stiffness, damping = springs.stiffness.copy(), springs.damping.copy()
        for joint, spring in self.preloaded:
            found.append(joint.opened(spring, float(damping[spring])))
            stiffness[spring], damping[spring] = found[-1].always, found[-1].damping
        springs = springs._replace(stiffness=stiffness, damping=damping)
        return replace(self, springs=springs, open_joints=tuple(found), closed=self.closed or self)

    def all_coordinates(self, free: Array) -> Array:
        return self.all_rates(free)

    def all_rates(self, rates: Array) -> Array:
        return product(rates, self.carry.T)

    def free_coordinates(self, coordinates: Array) -> Array:
        return np.asarray(coordinates[:, self._kept])

    def free_rates(self, rates: Array) -> Array:
        return np.asarray(rates[:, self._kept])

    def to_free(self, columns: Array) -> Array:
        """Gradients (..., f) by the free coordinates, of those by all (..., k)."""
        return np.asarray(columns[..., self._kept])

    def to_free_twice(self, matrices: Array) -> Array:
        """Second derivatives (n, f, f) by the free coordinates, of those by all (n, k, k)."""
        return np.asarray(matrices[:, self._kept[:, None], self._kept])

    def turned(self, coordinates: Array, rates: Array, derivatives: bool = True) -> Turned:
        """The bodies' matrices at all coordinates and rates (n, k), the frame's last."""
        w, w_rate = (each[:, :-1].reshape(len(each), self.count + 1, 6)[:, :, 3:] for each in (coordinates, rates))
        kept = self._last_turned  # springs, inertia and paths ask for the same states one after the other
        for found, place, rate in kept:
            if (found.by_twice is not None or not derivatives) and np.array_equal(place, coordinates) and np.array_equal(rate, rates):
                return found
        found = turned(self.nominal, w, coordinates[:, -1], w_rate, rates[:, -1], derivatives)
        kept[:] = [(found, coordinates.copy(), rates.copy()), *kept[: KEPT - 1]]
        return found

    def places(self, values: Array) -> Array:
        """(n, B + 1, 3) centres of mass, or their rates, of all coordinates or rates (n, k)."""
        return np.asarray(values[:, :-1].reshape(len(values), self.count + 1, 6)[:, :, :3])

    def rigid_coordinates(self, motion: Motion) -> tuple[Array, Array, Array]:
        """All coordinates, rates and accelerations (n, k) of the rigid press in a motion."""
        engine, states = self.press.engine("space"), motion.states(self.press)
        n, found = states.v.shape[1], []
        for _ in range(3):
            found.append(np.zeros((n, 6 * self.count + 7)))
        for body, joint in enumerate(self.joints):
            where, speed = engine.point_motion(states, joint, self.lever[body])
            _, change = engine.point_accelerations(states, joint, self.lever[body][None])
            for each, value in zip(found, (where, speed, change[0]), strict=True):
                each[:, 6 * body : 6 * body + 3] = value
        for each, value in zip(found, (motion.crank_angle, motion.crank_speed, motion.crank_acceleration), strict=True):
            each[:, -1] = value
        return found[0], found[1], found[2]

    def crank(self, coordinates: Array, rates: Array) -> tuple[Array, Array]:
        """Angle and speed (n,) of the crank's joint."""
        return coordinates[:, -1], rates[:, -1]

    def displacement(self, coordinates: Array, motion: Motion) -> Array:
        """(n, links, 6) of all moving links beside the rigid press in a motion: of their centres of mass in world axes [m], and vectors of
        their turns, along the axis and as long as the angle [rad]. A cross without mass moves with its carrier."""
        rigid, placed = self.rigid_coordinates(motion)[0], poses(self.press, motion.joint_position)
        matrices = self.turned(coordinates, np.zeros_like(coordinates), derivatives=False).matrix.reshape(len(coordinates), -1, 3, 3)
        found = np.zeros((len(coordinates), self.press.model.nv, 6))
        shift = self.places(coordinates) - self.places(rigid)
        for body, joint in enumerate(self.joints):
            before = placed.rotation[joint] @ self.own_axes[body]
            found[:, joint - 1, :3] = shift[:, body]
            found[:, joint - 1, 3:] = _turn_of(matrices[:, body] @ before.swapaxes(1, 2))
        for joint in range(1, self.press.model.nv + 1):
            if joint not in self.joints:
                carrier = int(self.press.model.parents[joint])
                centre = placed.points(carrier, self.press.model.inertias[carrier].lever)
                arm = placed.position[joint] - centre
                found[:, joint - 1] = found[:, carrier - 1]
                found[:, joint - 1, :3] += np.cross(found[:, carrier - 1, 3:], arm)
        return found

    # --------------------------------------------------------------------------------------------------------------------- inertia

    has_constant_mass = False

    @cached_property
    def mass(self) -> Array:
        """(f, f) the constant part of the mass matrix: that of the centres of mass."""
        diagonal = np.zeros(6 * self.count + 7)
        for axis in range(3):
            diagonal[axis : 6 * self.count : 6] = self.mass_of
        return np.diag(diagonal[self._kept])

    def mass_at(self, coordinates: Array) -> Array:
        still = np.zeros_like(coordinates)
        return self.mass + self.varying_inertia(coordinates, still, still).by_acceleration

    def varying_inertia(self, coordinates: Array, rates: Array, accelerations: Array) -> VaryingInertia:
        """Inertia forces of the turning bodies at all coordinates and rates (n, k) and accelerations (n, k)."""
        at, b, n = self.turned(coordinates, rates), self.count, len(coordinates)
        assert at.by_twice is not None
        assert at.curve_by is not None
        by, by_twice = at.by[:, :b], at.by_twice[:, :b]
        turning = accelerations[:, : 6 * b].reshape(n, b, 6)[:, :, 3:]
        own = np.concatenate([turning, np.broadcast_to(accelerations[:, None, -1:], (n, b, 1))], axis=2)
        pushed = self._weighed((own[:, :, None] @ by)[:, :, 0] + at.curve[:, :b])[..., None]
        changed = (own[:, :, None] @ by_twice.reshape(n, b, 4, 36)).reshape(n, b, 4, 9) + at.curve_by[:, :b]
        by_place = (by_twice.reshape(n, b, 16, 9) @ pushed).reshape(n, b, 4, 4) + by @ self._weighed(changed).swapaxes(2, 3)
        others = (by @ self._weighed(each).swapaxes(2, 3) for each in (2 * at.rate_by[:, :b], by))
        force, matrices = (by @ pushed)[..., 0], [self._scattered(each) for each in (by_place, *others)]
        rows = np.zeros((n, 6 * b + 7))
        rows[:, : 6 * b].reshape(n, b, 6)[:, :, 3:] = force[:, :, :3]
        rows[:, -1] = force[:, :, 3].sum(axis=1)
        by_place, by_rate, by_acceleration = (self.to_free_twice(each) for each in matrices)
        return VaryingInertia(self.to_free(rows), by_place, by_rate, by_acceleration, np.zeros((n, self.free)))

    def _weighed(self, matrices: Array) -> Array:
        """Matrices (n, B, ..., 9) of the bodies times their J."""
        n, b = matrices.shape[:2]
        return np.asarray((matrices.reshape(n, b, -1, 3) @ self.shape).reshape(matrices.shape))

    def _scattered(self, blocks: Array) -> Array:
        """(n, k, k) of blocks (n, B or B + 1, 4, 4) by the bodies' turns and the crank angle."""
        n, b = blocks.shape[:2]
        found = np.zeros((n, 6 * self.count + 7, 6 * self.count + 7))
        for body in range(b):
            own = slice(6 * body + 3, 6 * body + 6)
            found[:, own, own], found[:, own, -1], found[:, -1, own] = (
                blocks[:, body, :3, :3],
                blocks[:, body, :3, 3],
                blocks[:, body, 3, :3],
            )
        found[:, -1, -1] = blocks[:, :, 3, 3].sum(axis=1)
        return found

    def kinetic_energy(self, coordinates: Array, rates: Array) -> Array:
        """Kinetic energy (n,) of all bodies [J]."""
        rate, speed = self.turned(coordinates, rates, derivatives=False).rate[:, : self.count], self.places(rates)[:, : self.count]
        return np.asarray(0.5 * ((speed**2).sum(axis=2) @ self.mass_of + (self._weighed(rate) * rate).sum(axis=(1, 2))))

    def weight_less_inertia(self, accelerations: Array) -> Array:
        """Sum (n, 3) of the weights less the inertia forces of all bodies, of free accelerations (n, f), in world axes [N]."""
        change = self.places(self.all_rates(accelerations))[:, : self.count]
        return np.asarray(np.einsum("nbi,b->ni", self.gravity - change, self.mass_of))

    # --------------------------------------------------------------------------------------------------------------------- springs

    def _springs(self, coordinates: Array, rates: Array, derivatives: bool) -> _Springs:
        return self._strained(self.turned(coordinates, rates, derivatives), coordinates, rates)

    def _strained(self, at: Turned, coordinates: Array, rates: Array) -> _Springs:
        springs = self.springs
        place, speed = self.places(coordinates), self.places(rates)

        def of_bodies(matrices: Array, r: Array) -> tuple[Array, Array]:
            own = matrices[:, springs.first]
            directions = springs.turning[:, None] * _applied(own, springs.direction)
            gap = _applied(matrices[:, springs.second], springs.arm2) - _applied(own, springs.arm1)
            return directions, gap + springs.place[:, None] * (r[:, springs.second] - r[:, springs.first])

        (along, gap), (along_rate, gap_rate) = of_bodies(at.matrix, place), of_bodies(at.rate, speed)
        along = along + (1 - springs.turning)[:, None] * springs.direction
        extension = (along * gap).sum(axis=2)
        opening = (along_rate * gap + along * gap_rate).sum(axis=2)
        return _Springs(at, along, gap, extension, opening, along_rate, gap_rate)

    def spring_forces(self, coordinates: Array, rates: Array, derivatives: bool = True) -> SpringForces:
        """Forces of all springs and of weight on the free coordinates, at all coordinates and rates (n, k)."""
        at, springs = self._springs(coordinates, rates, derivatives), self.springs
        pull = -(springs.stiffness * at.extension + springs.damping * at.opening)
        by = at.turned.by
        pushed, pushed_rate = self._pushed(at.along, at.gap), self._pushed(at.along_rate, at.gap_rate)
        gradient = self._placed(self._parts(by, pushed), at.along)
        force = self.to_free(np.matmul(pull[:, None], gradient)[:, 0]) + self.free_weight
        if not derivatives:
            return SpringForces(force, None, None)
        changing = self._parts(at.turned.rate_by, pushed) + self._parts(by, pushed_rate)
        gradient_rate = self._placed(changing, at.along_rate)
        yielding = springs.stiffness[:, None] * gradient + springs.damping[:, None] * gradient_rate
        transposed = gradient.swapaxes(1, 2)
        stiffness = transposed @ yielding - self._bend(at, pull)
        damping = transposed @ (springs.damping[:, None] * gradient)
        return SpringForces(force, self.to_free_twice(stiffness), self.to_free_twice(damping))

    def gradients(self, coordinates: Array) -> Array:
        """Gradients (n, S, k) of the extensions of all springs."""
        at = self._springs(coordinates, np.zeros_like(coordinates), derivatives=True)
        return self._placed(self._parts(at.turned.by, self._pushed(at.along, at.gap)), at.along)

    def alone(self, spring: int) -> PressInSpace:
        """The same press with one of its springs alone."""
        return replace(self, springs=SpringsInSpace._make(column[spring : spring + 1] for column in self.springs))

    def extensions(self, turned: Turned, coordinates: Array, rates: Array) -> tuple[Array, Array, Array, Array]:
        """Extensions of all springs and their rates (n, S), gradients (n, S, k), and the sum of their second derivatives (n, k, k)."""
        at = self._strained(turned, coordinates, rates)
        gradient = self._placed(self._parts(turned.by, self._pushed(at.along, at.gap)), at.along)
        return at.extension, at.opening, gradient, self._bend(at, np.ones_like(at.extension))

    def joint_motions(self, coordinates: Array, rates: Array) -> list[JointMotion]:
        """The preloaded joints that may open."""
        if not self.open_joints:
            return []
        at, springs, found = self._springs(coordinates, rates, derivatives=False), self.springs, []
        for joint in self.open_joints:
            k = joint.spring
            pull = springs.stiffness[k] * at.extension[:, k] + springs.damping[k] * at.opening[:, k]
            found.append(JointMotion(joint, at.extension[:, k], at.opening[:, k], pull, at.along[:, k]))
        return found

    @cached_property
    def free_weight(self) -> Array:
        """(f,) gravity on the free coordinates."""
        found = np.zeros(6 * self.count + 7)
        found[: 6 * self.count].reshape(self.count, 6)[:, :3] = self.mass_of[:, None] * self.gravity
        return np.asarray(found[self._kept])

    def _pushed(self, along: Array, gap: Array) -> tuple[Array, Array]:
        """Derivatives (n, S, 9) of the extensions by the matrices of their bodies 1 and 2."""
        springs, n = self.springs, len(along)
        one = (springs.turning[:, None] * gap)[..., None] * springs.direction[:, None] - along[..., None] * springs.arm1[:, None]
        return one.reshape(n, -1, 9), (along[..., None] * springs.arm2[:, None]).reshape(n, -1, 9)

    def _parts(self, by: Array, pushed: tuple[Array, Array]) -> Array:
        """(n, S, 2, 4) derivatives of the extensions by the turns of both bodies and the crank angle; ``by``: (n, B + 1, 4, 9) of the
        bodies' matrices."""
        bodies = (self.springs.first, self.springs.second)
        return np.stack([np.einsum("nsak,nsk->nsa", by[:, body], each) for body, each in zip(bodies, pushed, strict=True)], axis=2)

    def _placed(self, parts: Array, along: Array) -> Array:
        """Gradients (n, S, k) from `_parts`, and from those by the second centre of mass, the directions (n, S, 3)."""
        springs, rows = self.springs, np.arange(len(self.springs.first))
        found = np.zeros((len(parts), len(rows), 6 * self.count + 7))
        for axis in range(3):
            straight = springs.place * along[:, :, axis]
            found[:, rows, 6 * springs.first + axis], found[:, rows, 6 * springs.second + axis] = -straight, straight
            found[:, rows, 6 * springs.first + 3 + axis] = parts[:, :, 0, axis]
            found[:, rows, 6 * springs.second + 3 + axis] = parts[:, :, 1, axis]
        found[:, :, -1] = parts[:, :, :, 3].sum(axis=2)
        return found

    def _bend(self, at: _Springs, pull: Array) -> Array:
        """(n, k, k): second derivatives of the extensions times the pulls (n, S), summed."""
        springs, by, n = self.springs, at.turned.by, len(pull)
        assert at.turned.by_twice is not None
        on_second, on_first, on_axis = self._spread
        sideways = (pull[..., None] * at.along).swapaxes(1, 2)
        pushed = sideways @ on_second - sideways @ on_first + (pull[..., None] * at.gap).swapaxes(1, 2) @ on_axis
        pushed = pushed.reshape(n, 3, self.count + 1, 3).swapaxes(1, 2).reshape(n, self.count + 1, 9, 1)
        found = self._scattered((at.turned.by_twice.reshape(n, self.count + 1, 16, 9) @ pushed).reshape(n, self.count + 1, 4, 4))
        some = np.flatnonzero(springs.turning)
        first, second = springs.first[some], springs.second[some]
        own = pull[:, some, None, None] * _applied(by[:, first], springs.direction[some, None])  # (n, T, 4, 3)
        ends = [-_applied(by[:, first], springs.arm1[some, None]), _applied(by[:, second], springs.arm2[some, None])]
        turns = [own @ end.swapaxes(2, 3) for end in ends]  # (n, T, 4, 4)
        straight = springs.place[some, None, None] * own
        for k in range(len(some)):
            one, two = 6 * int(first[k]), 6 * int(second[k])
            rows = np.array([one + 3, one + 4, one + 5, -1])
            for start, each in ((one, -straight[:, k]), (two, straight[:, k])):
                _add_twice(found, rows, np.arange(start, start + 3), each)
            for start, each in ((one, turns[0][:, k]), (two, turns[1][:, k])):
                _add_twice(found, rows, np.array([start + 3, start + 4, start + 5, -1]), each)
        return found

    @cached_property
    def _spread(self) -> tuple[Array, Array, Array]:
        """(S, 3 (B + 1)) arms 2 at the columns of their bodies, arms 1, and the directions that turn with body 1."""
        springs, rows = self.springs, np.arange(len(self.springs.first))
        found = [np.zeros((len(rows), self.count + 1, 3)) for _ in range(3)]
        found[0][rows, springs.second], found[1][rows, springs.first] = springs.arm2, springs.arm1
        found[2][rows, springs.first] = springs.turning[:, None] * springs.direction
        return tuple(each.reshape(len(rows), -1) for each in found)  # type: ignore[return-value]

    def bearing_forces(self, coordinates: Array, rates: Array) -> Array:
        """Forces (bearings, n, 3), parent on child or link1 on link2, in world axes [N]."""
        at, springs = self._springs(coordinates, rates, derivatives=False), self.springs
        forces = -(springs.place * (springs.stiffness * at.extension + springs.damping * at.opening))[..., None] * at.along
        found = np.zeros((len(self.press.bearings), len(coordinates), 3))
        for number, same in enumerate(self.alike):
            found[number] = forces[:, springs.bearing == same].sum(axis=1)
        return found

    def lost_power(self, coordinates: Array, rates: Array) -> Array:
        """Power (n,) lost in the dampers [W]."""
        return np.asarray(self._springs(coordinates, rates, derivatives=False).opening ** 2 @ self.springs.damping)

    def stored_energy(self, coordinates: Array) -> Array:
        """Energy (n,) of springs and weights [J]."""
        at = self._springs(coordinates, np.zeros_like(coordinates), derivatives=False)
        joints = sum(joint.stored(at.extension[:, joint.spring]) for joint in self.open_joints)
        return np.asarray(0.5 * at.extension**2 @ self.springs.stiffness + joints - coordinates[:, self._kept] @ self.free_weight)


def _applied(matrices: Array, vectors: Array) -> Array:
    """Matrices (..., 9) times vectors (..., 3)."""
    own = matrices.reshape(*matrices.shape[:-1], 3, 3)
    return np.asarray(own[..., 0] * vectors[..., 0, None] + own[..., 1] * vectors[..., 1, None] + own[..., 2] * vectors[..., 2, None])


def _add_twice(found: Array, rows: Indices, columns: Indices, block: Array) -> None:
    """Add a block (n, rows, columns) to matrices, and its transpose. The crank angle may be among rows and columns."""
    found[:, rows[:, None], columns] += block
    found[:, columns[:, None], rows] += block.swapaxes(1, 2)


def _turn_of(rotation: Array) -> Array:
    """Vectors (n, 3) of small rotations (n, 3, 3): along the axis, as long as the angle [rad]."""
    across = 0.5 * np.stack(
        [rotation[:, 2, 1] - rotation[:, 1, 2], rotation[:, 0, 2] - rotation[:, 2, 0], rotation[:, 1, 0] - rotation[:, 0, 1]], axis=1
    )
    sine = np.linalg.norm(across, axis=1)
    angle = np.arctan2(sine, 0.5 * (np.trace(rotation, axis1=1, axis2=2) - 1))
    return np.asarray(across * np.where(sine > 0, angle / np.maximum(sine, np.finfo(float).tiny), 1.0)[:, None])
