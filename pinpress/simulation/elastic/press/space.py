"""Bodies in space and the lines between them: inertia, extensions of springs, and their derivatives, at many states at once.

Every body has six coordinates: its centre of mass r in world axes [m], and the small turn w from its nominal one (`turning`). The last
coordinate is the crank angle p, which turns the nominal bodies along; the crank itself has no other turn about its axis. Points and
directions of a body are linear in its matrix X = (R, r), and all lines have extensions of the same kind,

    y = a (X2 s2 - X1 s1),

with a direction a of the first body or of the frame, and points or directions s: a bearing's gap along an axis, or the cosine between two
axes that are square to each other unless the bearing twists. Inertia is constant by X,

    m r'',   R'' J   with J = tr(I) / 2 - I,

so that the rows of Lagrange's equations are the products of these with the derivatives of X by the coordinates. Loops that hold each other
when they are rigid, as those of a planar press do in space, are determinate here: their springs share what they carry.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ....common.quantities import Array
from ....kinematics.motion import Motion
from ....kinematics.poses import poses
from ....linkage.linkage import Linkage
from ..panels import Indices
from .geometry import PointMotion, VaryingInertia
from .turning import NominalTurns, Turned, turn_bodies


class LinesInSpace(NamedTuple):
    """Lines between two bodies each, S of them; the frame is the last body.

    Attributes:
        first: (S,) bodies 1.
        second: (S,) bodies 2.
        direction: (S, 3) directions a, in the axes of body 1, or of the frame.
        turning: (S,) 1 where the direction turns with body 1, else 0.
        arm1: (S, 3) s1 of body 1, from its centre of mass in its axes [m or -].
        arm2: (S, 3) s2 of body 2, from its centre of mass in its axes.
        place: (S,) 1 where s1 and s2 are points, 0 where they are directions.
    """

    first: Indices
    second: Indices
    direction: Array
    turning: Array
    arm1: Array
    arm2: Array
    place: Array


class SpaceState(NamedTuple):
    """Bodies in space at n states.

    Attributes:
        coordinates: (n, k) of all bodies.
        rates: (n, k).
        turned: matrices of the bodies, the frame last.
    """

    coordinates: Array
    rates: Array
    turned: Turned


class StrainsInSpace(NamedTuple):
    """Lines at n states: of the extensions y = a b.

    Attributes:
        extension: (n, S) from the drawn pose.
        opening: (n, S) rates of the extensions.
        turned: matrices of the bodies, the frame last.
        along: (n, S, 3) directions a in world axes.
        gap: (n, S, 3) b in world axes.
        along_rate: (n, S, 3).
        gap_rate: (n, S, 3).
    """

    extension: Array
    opening: Array
    turned: Turned
    along: Array
    gap: Array
    along_rate: Array
    gap_rate: Array


@dataclass(frozen=True, eq=False, repr=False)
class SpaceGeometry:
    """Bodies in space and the lines of their springs; see `geometry.Geometry`. The B bodies are those with mass; the frame is body B.

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
        lines: of all bearings.
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
    lines: LinesInSpace

    base: ClassVar[None] = None
    constant_mass: ClassVar[bool] = False

    # ----------------------------------------------------------------------------------------------------------------- coordinates

    @property
    def count(self) -> int:
        """Number of bodies."""
        return len(self.joints)

    @property
    def size(self) -> int:
        """Number of coordinates: six of each body, those of the frame, and the crank angle."""
        return 6 * self.count + 7

    @cached_property
    def carry(self) -> Array:
        """(k, f) free coordinates to all: the frame stands, and the crank's axis is the third of its own axes."""
        left_out = [6 * self.crank_body + 5, *range(6 * self.count, 6 * self.count + 6)]
        return np.delete(np.eye(self.size), left_out, axis=1)

    @cached_property
    def inertia(self) -> Array:
        """(k,) that of the centres of mass."""
        diagonal = np.zeros(self.size)
        for axis in range(3):
            diagonal[axis : 6 * self.count : 6] = self.mass_of
        return diagonal

    @cached_property
    def weight(self) -> Array:
        """(k,) gravity on the coordinates."""
        weight = np.zeros(self.size)
        weight[: 6 * self.count].reshape(self.count, 6)[:, :3] = self.mass_of[:, None] * self.gravity
        return weight

    def places(self, values: Array) -> Array:
        """(n, B + 1, 3) centres of mass, or their rates, of all coordinates or rates (n, k)."""
        return np.asarray(values[:, :-1].reshape(len(values), self.count + 1, 6)[:, :, :3])

    def rigid(self, motion: Motion) -> tuple[Array, Array, Array]:
        engine, states = self.press.engine("space"), motion.states(self.press)
        result = [np.zeros((states.v.shape[1], self.size)) for _ in range(3)]
        for values, centers in zip(result, engine.body_motion(states, self.joints).points(self.lever), strict=True):
            for body, center in enumerate(centers):
                values[:, 6 * body : 6 * body + 3] = center.T
        for values, value in zip(result, (motion.crank_angle, motion.crank_speed, motion.crank_acceleration), strict=True):
            values[:, -1] = value
        return result[0], result[1], result[2]

    def crank(self, values: Array) -> Array:
        return values[:, -1]

    def displacement(self, coordinates: Array, motion: Motion) -> Array:
        """(n, links, 6) of all moving links from the rigid press in a motion: of their centres of mass in world axes [m], and vectors of
        their turns, along the axis and as long as the angle [rad]. A cross without mass moves with its carrier."""
        rigid, placed = self.rigid(motion)[0], poses(self.press, motion.joint_position)
        matrices = self.state(coordinates, np.zeros_like(coordinates), derivatives=False).turned.matrix.reshape(len(coordinates), -1, 3, 3)
        moved = np.zeros((len(coordinates), self.press.model.nv, 6))
        shift = self.places(coordinates) - self.places(rigid)
        for body, joint in enumerate(self.joints):
            before = placed.rotation[joint] @ self.own_axes[body]
            moved[:, joint - 1, :3] = shift[:, body]
            moved[:, joint - 1, 3:] = _turn_of(matrices[:, body] @ before.swapaxes(1, 2))
        for joint in range(1, self.press.model.nv + 1):
            if joint not in self.joints:
                carrier = int(self.press.model.parents[joint])
                centre = placed.points(carrier, self.press.model.inertias[carrier].lever)
                arm = placed.position[joint] - centre
                moved[:, joint - 1] = moved[:, carrier - 1]
                moved[:, joint - 1, :3] += np.cross(moved[:, carrier - 1, 3:], arm)
        return moved

    def total(self, forces: Array, body: int | None = None) -> Array:
        assert body is None
        return np.asarray(self.places(forces)[:, : self.count].sum(axis=1))

    # ------------------------------------------------------------------------------------------------------------------- states

    def state(self, coordinates: Array, rates: Array, derivatives: bool = True) -> SpaceState:
        w, w_rate = (values[:, :-1].reshape(len(values), self.count + 1, 6)[:, :, 3:] for values in (coordinates, rates))
        return SpaceState(coordinates, rates, turn_bodies(self.nominal, w, coordinates[:, -1], w_rate, rates[:, -1], derivatives))

    def point(self, state: SpaceState, body: int, arm: Array) -> PointMotion:
        turned, first = state.turned, 6 * body
        assert turned.by_twice is not None
        n, k = state.coordinates.shape
        place = self.places(state.coordinates)[:, body] + turned.matrix[:, body].reshape(n, 3, 3) @ arm
        by, columns = np.zeros((n, k, 3)), np.array([first + 3, first + 4, first + 5, k - 1])
        by[:, first : first + 3] = np.eye(3)
        by[:, columns] = turned.by[:, body].reshape(n, 4, 3, 3) @ arm
        return PointMotion(place, by, columns, turned.by_twice[:, body].reshape(n, 4, 4, 3, 3) @ arm)

    def with_lines(self, kept: Any) -> SpaceGeometry:
        return replace(self, lines=LinesInSpace._make(column[kept] for column in self.lines))

    # --------------------------------------------------------------------------------------------------------------------- inertia

    def varying_inertia(self, state: SpaceState, accelerations: Array) -> VaryingInertia:
        turned, b, n = state.turned, self.count, len(accelerations)
        assert turned.by_twice is not None
        assert turned.curve_by is not None
        by, by_twice = turned.by[:, :b], turned.by_twice[:, :b]
        turning = accelerations[:, : 6 * b].reshape(n, b, 6)[:, :, 3:]
        change = np.concatenate([turning, np.broadcast_to(accelerations[:, None, -1:], (n, b, 1))], axis=2)
        pushed = self.weigh((change[:, :, None] @ by)[:, :, 0] + turned.curve[:, :b])[..., None]
        changed = (change[:, :, None] @ by_twice.reshape(n, b, 4, 36)).reshape(n, b, 4, 9) + turned.curve_by[:, :b]
        by_place = (by_twice.reshape(n, b, 16, 9) @ pushed).reshape(n, b, 4, 4) + by @ self.weigh(changed).swapaxes(2, 3)
        others = (by @ self.weigh(matrices).swapaxes(2, 3) for matrices in (2 * turned.rate_by[:, :b], by))
        force, rows = (by @ pushed)[..., 0], np.zeros((n, self.size))
        rows[:, : 6 * b].reshape(n, b, 6)[:, :, 3:] = force[:, :, :3]
        rows[:, -1] = force[:, :, 3].sum(axis=1)
        return VaryingInertia(rows, *(self._scatter(blocks) for blocks in (by_place, *others)))

    def weigh(self, matrices: Array) -> Array:
        """Matrices (n, B, ..., 9) of the bodies times their J."""
        n, b = matrices.shape[:2]
        return np.asarray((matrices.reshape(n, b, -1, 3) @ self.shape).reshape(matrices.shape))

    def _scatter(self, blocks: Array) -> Array:
        """(n, k, k) of blocks (n, B or B + 1, 4, 4) by the bodies' turns and the crank angle."""
        n, b = blocks.shape[:2]
        matrix = np.zeros((n, self.size, self.size))
        for body in range(b):
            turns = slice(6 * body + 3, 6 * body + 6)
            matrix[:, turns, turns], matrix[:, turns, -1], matrix[:, -1, turns] = (
                blocks[:, body, :3, :3],
                blocks[:, body, :3, 3],
                blocks[:, body, 3, :3],
            )
        matrix[:, -1, -1] = blocks[:, :, 3, 3].sum(axis=1)
        return matrix

    def kinetic_energy(self, state: SpaceState) -> Array:
        rate, speed = state.turned.rate[:, : self.count], self.places(state.rates)[:, : self.count]
        return np.asarray(0.5 * ((speed**2).sum(axis=2) @ self.mass_of + (self.weigh(rate) * rate).sum(axis=(1, 2))))

    # --------------------------------------------------------------------------------------------------------------------- lines

    def strains(self, state: SpaceState) -> StrainsInSpace:
        lines = self.lines

        def of_bodies(matrices: Array, r: Array) -> tuple[Array, Array]:
            first = matrices[:, lines.first]
            directions = lines.turning[:, None] * _apply(first, lines.direction)
            gap = _apply(matrices[:, lines.second], lines.arm2) - _apply(first, lines.arm1)
            return directions, gap + lines.place[:, None] * (r[:, lines.second] - r[:, lines.first])

        along, gap = of_bodies(state.turned.matrix, self.places(state.coordinates))
        along_rate, gap_rate = of_bodies(state.turned.rate, self.places(state.rates))
        along = along + (1 - lines.turning)[:, None] * lines.direction
        extension = (along * gap).sum(axis=2)
        opening = (along_rate * gap + along * gap_rate).sum(axis=2)
        return StrainsInSpace(extension, opening, state.turned, along, gap, along_rate, gap_rate)

    def along(self, strains: StrainsInSpace) -> Array:
        return strains.along

    def gradient(self, strains: StrainsInSpace) -> Array:
        return self._place(self._parts(strains.turned.by, self._push(strains.along, strains.gap)), strains.along)

    def gradient_rate(self, strains: StrainsInSpace) -> Array:
        pushed, pushed_rate = self._push(strains.along, strains.gap), self._push(strains.along_rate, strains.gap_rate)
        return self._place(self._parts(strains.turned.rate_by, pushed) + self._parts(strains.turned.by, pushed_rate), strains.along_rate)

    def _push(self, along: Array, gap: Array) -> tuple[Array, Array]:
        """Derivatives (n, S, 9) of the extensions by the matrices of their bodies 1 and 2."""
        lines, n = self.lines, len(along)
        one = (lines.turning[:, None] * gap)[..., None] * lines.direction[:, None] - along[..., None] * lines.arm1[:, None]
        return one.reshape(n, -1, 9), (along[..., None] * lines.arm2[:, None]).reshape(n, -1, 9)

    def _parts(self, by: Array, pushed: tuple[Array, Array]) -> Array:
        """(n, S, 2, 4) derivatives of the extensions by the turns of both bodies and the crank angle; ``by``: (n, B + 1, 4, 9) of the
        bodies' matrices."""
        bodies = (self.lines.first, self.lines.second)
        return np.stack([np.einsum("nsak,nsk->nsa", by[:, body], each) for body, each in zip(bodies, pushed, strict=True)], axis=2)

    def _place(self, parts: Array, along: Array) -> Array:
        """Gradients (n, S, k) from `_parts`, and from those by the second centre of mass, the directions (n, S, 3)."""
        lines, rows = self.lines, np.arange(len(self.lines.first))
        gradient = np.zeros((len(parts), len(rows), self.size))
        for axis in range(3):
            straight = lines.place * along[:, :, axis]
            gradient[:, rows, 6 * lines.first + axis], gradient[:, rows, 6 * lines.second + axis] = -straight, straight
            gradient[:, rows, 6 * lines.first + 3 + axis] = parts[:, :, 0, axis]
            gradient[:, rows, 6 * lines.second + 3 + axis] = parts[:, :, 1, axis]
        gradient[:, :, -1] = parts[:, :, :, 3].sum(axis=2)
        return gradient

    def bend(self, strains: StrainsInSpace, pull: Array) -> Array:
        lines, by, n = self.lines, strains.turned.by, len(pull)
        assert strains.turned.by_twice is not None
        on_second, on_first, on_axis = self._spread
        sideways = (pull[..., None] * strains.along).swapaxes(1, 2)
        pushed = sideways @ on_second - sideways @ on_first + (pull[..., None] * strains.gap).swapaxes(1, 2) @ on_axis
        pushed = pushed.reshape(n, 3, self.count + 1, 3).swapaxes(1, 2).reshape(n, self.count + 1, 9, 1)
        matrix = self._scatter((strains.turned.by_twice.reshape(n, self.count + 1, 16, 9) @ pushed).reshape(n, self.count + 1, 4, 4))
        tilting = np.flatnonzero(lines.turning)
        first, second = lines.first[tilting], lines.second[tilting]
        own = pull[:, tilting, None, None] * _apply(by[:, first], lines.direction[tilting, None])  # (n, T, 4, 3)
        ends = [-_apply(by[:, first], lines.arm1[tilting, None]), _apply(by[:, second], lines.arm2[tilting, None])]
        turns = [own @ end.swapaxes(2, 3) for end in ends]  # (n, T, 4, 4)
        straight = lines.place[tilting, None, None] * own
        for k in range(len(tilting)):
            one, two = 6 * int(first[k]), 6 * int(second[k])
            rows = np.array([one + 3, one + 4, one + 5, -1])
            for start, block in ((one, -straight[:, k]), (two, straight[:, k])):
                _add_twice(matrix, rows, np.arange(start, start + 3), block)
            for start, block in ((one, turns[0][:, k]), (two, turns[1][:, k])):
                _add_twice(matrix, rows, np.array([start + 3, start + 4, start + 5, -1]), block)
        return matrix

    @cached_property
    def _spread(self) -> tuple[Array, Array, Array]:
        """(S, 3 (B + 1)) arms 2 at the columns of their bodies, arms 1, and the directions that turn with body 1."""
        lines, rows = self.lines, np.arange(len(self.lines.first))
        columns = [np.zeros((len(rows), self.count + 1, 3)) for _ in range(3)]
        columns[0][rows, lines.second], columns[1][rows, lines.first] = lines.arm2, lines.arm1
        columns[2][rows, lines.first] = lines.turning[:, None] * lines.direction
        return tuple(column.reshape(len(rows), -1) for column in columns)  # type: ignore[return-value]


def _apply(matrices: Array, vectors: Array) -> Array:
    """Matrices (..., 9) times vectors (..., 3)."""
    turns = matrices.reshape(*matrices.shape[:-1], 3, 3)
    return np.asarray(turns[..., 0] * vectors[..., 0, None] + turns[..., 1] * vectors[..., 1, None] + turns[..., 2] * vectors[..., 2, None])


def _add_twice(matrices: Array, rows: Indices, columns: Indices, block: Array) -> None:
    """Add a block (n, rows, columns) to matrices, and its transpose. The crank angle may be among rows and columns."""
    matrices[:, rows[:, None], columns] += block
    matrices[:, columns[:, None], rows] += block.swapaxes(1, 2)


def _turn_of(rotation: Array) -> Array:
    """Vectors (n, 3) of small rotations (n, 3, 3): along the axis, as long as the angle [rad]."""
    across = 0.5 * np.stack(
        [rotation[:, 2, 1] - rotation[:, 1, 2], rotation[:, 0, 2] - rotation[:, 2, 0], rotation[:, 1, 0] - rotation[:, 0, 1]], axis=1
    )
    sine = np.linalg.norm(across, axis=1)
    angle = np.arctan2(sine, 0.5 * (np.trace(rotation, axis1=1, axis2=2) - 1))
    return np.asarray(across * np.where(sine > 0, angle / np.maximum(sine, np.finfo(float).tiny), 1.0)[:, None])
