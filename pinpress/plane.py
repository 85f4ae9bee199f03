"""A planar linkage as constant matrices over rotors.

In the plane a vector is a complex number and a rotation a multiplication by a rotor u = exp(i phi). Every point of a linkage is then a
fixed linear combination of few functions of the configuration, its *basis* (nb, n):

    row 0         1                       the frame
    revolute      u of the link it turns  absolute rotor, 1 in the drawn pose
    prismatic     travel x u of its guide

so that positions, loop gaps and the columns of the loop Jacobian are ``rows @ basis``, and velocities and accelerations ``rows`` times the
basis' derivatives: one matrix product for all links and all crank angles. The rows are read once from the Pinocchio model in its drawn pose
(all joints at zero); complex numbers are components along ``axes[0]`` and ``axes[1]``, which with ``normal`` make a right-handed frame.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from .coordinates import Array, ComplexArray
from .coordinates import axes as joint_axes
from .loops import Coupling, LoopJoint
from .plane_blocks import Block, ordered

EPSILON = float(np.finfo(float).eps)
SERIAL = 65_536  # scalar multiplications up to which OpenBLAS makes a complex product in one thread
SERIAL_ROW = 4_095  # the same of one row, which is a vector to it
PARALLEL = 1e-12  # joint axes further from the plane's normal than this [rad] make a linkage spatial


@dataclass(frozen=True, eq=False, repr=False)
class Plane:
    """Constants of a planar linkage; joints are counted as in v, loops as declared. See the module for ``basis``.

    Attributes:
        normal, axes: (3,) and (2, 3) world directions.
        driver: index of the driver joint.
        parents: index of every joint's parent joint, -1 for the frame.
        sense: (nv,) +1 or -1 where a revolute axis lies along or against the normal, 0 for a prismatic joint.
        revolute, prismatic: joint indices in the order of the basis.
        turn: (nr, nv) absolute angles of the rotors from joint angles. spin: (nv, nv) the same of every link, also where it only slides.
        frames: (nv, 3, 3) a vector in a joint's frame to its components along axes[0], axes[1], normal in the drawn pose.
        guide_rotors: (np,) basis row of the rotor that carries each prismatic direction.
        origins, centers: (nv, nb) joint origins; centres of mass relative to their joint's origin.
        heights, center_heights: (nv,) the same along the normal, centres from the world origin [m].
        directions: (np, nb) prismatic directions.
        closure: (nl + columns, nb) loop gaps (point 2 minus point 1), then the columns of the loop Jacobian.
        loop_points: (nl, nb) point 1 of every loop. loop_heights: (nl,) along the normal [m].
        holding: (nl,) whether the loop's bearing holds its links upright: a revolute one does.
        coupled: (nc, nv) coefficients of the coupling equations, turning ones in lengths of the linkage. offsets: (nc,) right-hand sides.
        followers: (nc,) joints whose coordinate the couplings give.
        blocks: the order in which equations are solved. driven: per loop, row of the driver's column, None where it does not move the loop.
        carried: (nv, nv) 1 where the link of joint k hangs on joint j.
        crossed: (nv, nl) +1 / -1 where loop l's point 2 / 1 hangs on joint j.
        size: of the largest loop: sum of the lengths round it [m].
    """

    normal: Array
    axes: Array
    driver: int
    parents: tuple[int, ...]
    sense: Array
    revolute: tuple[int, ...]
    prismatic: tuple[int, ...]
    turn: Array
    spin: Array
    frames: Array
    guide_rotors: tuple[int, ...]
    origins: ComplexArray
    centers: ComplexArray
    heights: Array
    center_heights: Array
    directions: ComplexArray
    closure: ComplexArray
    loop_points: ComplexArray
    loop_heights: Array
    holding: NDArray[np.bool_]
    coupled: Array
    offsets: Array
    followers: tuple[int, ...]
    blocks: tuple[Block, ...]
    driven: tuple[int | None, ...]
    carried: Array
    crossed: Array
    size: float

    @cached_property
    def tolerance(self) -> float:
        """Gap at which a loop is closed to rounding [m]."""
        return 8 * EPSILON * self.size

    @cached_property
    def redundant(self) -> bool:
        """Whether some of the equations in the plane say nothing new."""
        return any(block.redundant for block in self.blocks)

    def rotor(self, joint: int) -> int:
        """Basis row of the rotor of a joint's link; 0 for the frame (joint -1) and for links that only translate."""
        while joint >= 0:
            if joint in self.revolute:
                return 1 + self.revolute.index(joint)
            joint = self.parents[joint]
        return 0

    def point(self, joint: int, position: ComplexArray | complex, origin: complex) -> ComplexArray:
        """Row (nb,) of a point of a joint's link that is at ``position`` in the drawn pose, where the joint is at ``origin``."""
        row = self.origins[joint].copy() if joint >= 0 else np.zeros(self.closure.shape[1], complex)
        row[self.rotor(joint)] += position - origin
        return row


def product(rows: ComplexArray, columns: ComplexArray) -> ComplexArray:
    """``rows @ columns`` for any rows and many columns, in pieces so small that BLAS keeps to one thread.

    Its threads are no gain here, and where the machine has other work to do they wait milliseconds for each other.
    """
    step = max(1, (SERIAL if len(rows) > 1 else SERIAL_ROW) // max(1, rows.size))
    if columns.shape[1] <= step:
        return rows @ columns
    result = np.empty((len(rows), columns.shape[1]), complex)
    for start in range(0, columns.shape[1], step):
        np.matmul(rows, columns[:, start : start + step], out=result[:, start : start + step])
    return result


def flat(plane: Plane, vectors: Array) -> ComplexArray:
    """World vectors (..., 3) as complex numbers, what is along the normal left out."""
    return np.asarray(vectors @ plane.axes[0] + 1j * (vectors @ plane.axes[1]))


def in_space(plane: Plane, vectors: ComplexArray) -> Array:
    """Complex numbers (...) as world vectors (..., 3)."""
    return np.asarray(np.multiply.outer(vectors.real, plane.axes[0]) + np.multiply.outer(vectors.imag, plane.axes[1]))


def build(
    model: pin.Model, loops: Sequence[LoopJoint], couplings: Sequence[Coupling], driver: int, one_block: bool = False
) -> Plane | None:
    """Constants of a linkage whose driver turns, or None where it is not planar or its equations do not fall into blocks with as many
    unknown joints, or fewer. ``one_block``: solve all equations together."""
    if misalignment(model, driver) > PARALLEL:
        return None
    count = model.nv
    place, directions, turning = _drawn_joints(model)
    normal, axes = _frame(directions[driver])
    sense = np.array([np.sign(d @ normal) if t else 0.0 for d, t in zip(directions, turning, strict=True)])

    def in_plane(vector: Array) -> complex:
        return complex(*(axes @ vector))

    parents = tuple(int(model.parents[j + 1]) - 1 for j in range(count))
    revolute = tuple(j for j in range(count) if turning[j])
    prismatic = tuple(j for j in range(count) if not turning[j])
    width = 1 + count
    position = [in_plane(p.translation) for p in place]
    bodies = [(place[j], model.inertias[j + 1]) for j in range(count)]
    skeleton = Plane(
        normal=normal,
        axes=axes,
        driver=driver,
        parents=parents,
        sense=sense,
        revolute=revolute,
        prismatic=prismatic,
        turn=np.array([[sense[k] * (k in _ancestry(parents, j)) for k in range(count)] for j in revolute]),
        spin=np.array([[sense[k] * (k in _ancestry(parents, j)) for k in range(count)] for j in range(count)]),
        frames=np.array([np.array([*axes, normal]) @ p.rotation for p in place]),
        guide_rotors=(),
        origins=np.zeros((count, width), complex),
        centers=np.zeros((count, width), complex),
        heights=np.array([p.translation @ normal for p in place]),
        center_heights=np.array([p.act(y.lever) @ normal for p, y in bodies]),
        directions=np.zeros((len(prismatic), width), complex),
        closure=np.zeros((0, width), complex),
        loop_points=np.zeros((len(loops), width), complex),
        loop_heights=np.zeros(len(loops)),
        holding=np.array([loop.held > 0 for loop in loops], dtype=bool),
        coupled=np.zeros((len(couplings), count)),
        offsets=np.zeros(len(couplings)),
        followers=tuple(coupling.follower for coupling in couplings),
        blocks=(),
        driven=(),
        carried=np.array([[float(j in _ancestry(parents, k)) for k in range(count)] for j in range(count)]),
        crossed=np.array(
            [
                [float(j in _ancestry(parents, loop.joint2 - 1)) - float(j in _ancestry(parents, loop.joint1 - 1)) for loop in loops]
                for j in range(count)
            ]
        ).reshape(count, len(loops)),
        size=0.0,
    )
    for j in range(count):  # parents come before their children in Pinocchio
        p = parents[j]
        skeleton.origins[j] = skeleton.point(p, position[j], position[p] if p >= 0 else 0.0)
        if j in prismatic:
            k = prismatic.index(j)
            skeleton.origins[j, 1 + len(revolute) + k] = in_plane(directions[j])
            skeleton.directions[k, skeleton.rotor(p)] = in_plane(directions[j])
        skeleton.centers[j, skeleton.rotor(j)] = in_plane(place[j].rotation @ bodies[j][1].lever)
    return _with_loops(skeleton, loops, couplings, place, position, one_block)


def misalignment(model: pin.Model, driver: int) -> float:
    """Largest angle [rad] by which a turning axis misses the direction of the driver's, or a sliding one the plane across it."""
    _, directions, turning = _drawn_joints(model)
    normal = directions[driver]
    return max(
        float(np.linalg.norm(np.cross(d, normal)) if turns else abs(d @ normal)) for d, turns in zip(directions, turning, strict=True)
    )


def _drawn_joints(model: pin.Model) -> tuple[list[pin.SE3], list[Array], list[bool]]:
    """Placements of the joints in the drawn pose, their axes in the world, and whether they turn."""
    data = model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model))
    place = [data.oMi[j + 1].copy() for j in range(model.nv)]
    found = joint_axes(model)
    return place, [p.rotation @ axis.direction for p, axis in zip(place, found, strict=True)], [axis.turns for axis in found]


def _with_loops(
    plane: Plane,
    loops: Sequence[LoopJoint],
    couplings: Sequence[Coupling],
    place: list[pin.SE3],
    position: list[complex],
    one_block: bool,
) -> Plane | None:
    """The plane with its equations, None where the loops leave the plane or the equations do not fall into blocks."""

    def end(joint: int, point: Array) -> tuple[ComplexArray, float]:
        world = place[joint - 1].act(point) if joint else point
        row = plane.point(joint - 1, complex(*(plane.axes @ world)), position[joint - 1] if joint else 0.0)
        return row, float(world @ plane.normal)

    gaps, columns, owners = [], [], []

    def lies_across(loop: LoopJoint) -> bool:
        ends = ((loop.joint1, loop.rotation1[:, 0]), (loop.joint2, loop.rotation2[:, 0]))
        return all(
            float(np.linalg.norm(np.cross(place[joint - 1].rotation @ axis if joint else axis, plane.normal))) <= PARALLEL
            for joint, axis in ends
        )

    if not all(loop.type == "spherical" or (loop.type == "revolute" and lies_across(loop)) for loop in loops):
        return None
    for k, loop in enumerate(loops):
        (first, height1), (second, height2) = end(loop.joint1, loop.point1), end(loop.joint2, loop.point2)
        plane.loop_points[k], plane.loop_heights[k] = first, height1
        gaps.append(second - first)
        if abs(height1 - height2) > PARALLEL * np.abs(gaps[-1]).sum():
            return None
        for joint in np.flatnonzero(plane.crossed[:, k]):
            row = np.zeros_like(first)
            if joint in plane.revolute:
                side = second if plane.crossed[joint, k] > 0 else first
                row += 1j * plane.sense[joint] * plane.crossed[joint, k] * (side - plane.origins[joint])
            else:
                row += plane.crossed[joint, k] * plane.directions[plane.prismatic.index(joint)]
            columns.append(row)
            owners.append((k, int(joint)))
    blocks = ordered(owners, len(loops), couplings, plane.driver, len(plane.parents), one_block)
    if blocks is None:
        return None
    size = max((float(np.abs(g[: 1 + len(plane.revolute)]).sum()) for g in gaps), default=1.0)
    for k, coupling in enumerate(couplings):
        unit = size if coupling.follower in plane.revolute else 1.0
        plane.coupled[k, [coupling.follower, coupling.leader]] = unit, -unit * coupling.multiplier
        plane.offsets[k] = unit * coupling.offset
    changes = {
        "guide_rotors": tuple(plane.rotor(plane.parents[j]) for j in plane.prismatic),
        "closure": np.array(gaps + columns).reshape(-1, plane.origins.shape[1]),
        "blocks": blocks,
        "driven": tuple(next((len(loops) + r for r, o in enumerate(owners) if o == (k, plane.driver)), None) for k in range(len(loops))),
        "size": size,
    }
    return Plane(**{**plane.__dict__, **changes})


def _ancestry(parents: tuple[int, ...], joint: int) -> set[int]:
    """The joint and all joints between it and the frame."""
    line = set()
    while joint >= 0:
        line.add(joint)
        joint = parents[joint]
    return line


def _frame(normal: Array) -> tuple[Array, Array]:
    """Unit normal and the two axes of the plane, world x (or y, where x is the normal) projected into it first."""
    normal = normal / np.linalg.norm(normal)
    start = np.eye(3)[1 if abs(normal[0]) > 0.9 else 0]
    first = start - (start @ normal) * normal
    first /= np.linalg.norm(first)
    return normal, np.array([first, np.cross(normal, first)]) + 0.0  # + 0.0 turns -0.0 into 0.0
