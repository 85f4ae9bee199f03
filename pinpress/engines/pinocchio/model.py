"""Constants of any linkage, the equations of its loops and couplings at one configuration, and Pinocchio's constraint models of the loops.

This engine computes loops in space, any number of drivers and redundant equations, and by its results those of the planar engine are
tested. The rank of the equations is found from their singular values.

The equations are, in this order: for every loop the distance of its ends, three rows (point 2 less point 1, world axes); for every loop the
rotations that its bearing prevents, of body 2 against body 1 about axes of end 1; one row for every coupling. Rotations [rad] are
multiplied by the length of the linkage, so that all rows are lengths and can be compared. The multiplier of such a row is a torque divided
by that length.

`constraint_models` are for users of Pinocchio: a spherical loop is held at its point; a revolute one at two points of its axis, because
Pinocchio has no constraint of a pin in space; a fixed one as a frame. `ForwardDynamics` holds a fixed loop at three points.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ...common.quantities import CRANK, RAM, Array, DriverCoordinate
from ..joints import Axis, Coupling, LoopJoint, Slot, axes, configuration, data_of, drawn_placements, joints_between, slots
from ..racks import Rack, racks

PARALLEL_TO_ROUNDING = 1e-14  # sine of an angle that rounding leaves between parallel axes: an entry as small is zero
FEW = 6  # drivers whose positions a message lists
PointPair = tuple[int, pin.SE3, int, pin.SE3]
"""Two points that a loop holds together: joint and place in its frame, of either side."""


@dataclass(frozen=True, eq=False, repr=False)
class SpatialModel:
    """Constants of a linkage, planar or not.

    Attributes:
        model: Pinocchio's model of the tree.
        loops: its loop joints, as declared.
        couplings: its gear pairs, as declared.
        drivers: indices of the driver joints in v.
        passive_joints: indices of all other joints in v.
        joints_of_loop: (nl,) the joints on every loop: +1 where a joint carries only its end 2, -1 where only its end 1.
        size: length of the linkage [m]: largest extent of joints and loop points in the drawn pose.
        tolerance: gap at which a loop is closed to rounding [m].
        slots: places of the joints in q.
        axes: axes of the joints.
    """

    model: pin.Model
    loops: tuple[LoopJoint, ...]
    couplings: tuple[Coupling, ...]
    drivers: tuple[int, ...]
    passive_joints: tuple[int, ...]
    joints_of_loop: tuple[Mapping[int, float], ...]
    size: float
    tolerance: float
    slots: tuple[Slot, ...]
    axes: tuple[Axis, ...]

    @cached_property
    def racks(self) -> tuple[Rack, ...]:
        """The couplings between whose joints teeth or threads push."""
        return racks(self.model, self.axes, self.couplings)

    def follower_unit(self, coupling: int) -> float:
        """Effort of a coupling on its follower by the multiplier of its equation [m, 1 where the follower slides]."""
        return self.size if self.axes[self.couplings[coupling].follower].turns else 1.0

    @cached_property
    def coordinates(self) -> tuple[DriverCoordinate, ...]:
        """What the coordinates of the drivers are."""
        return tuple(CRANK if self.axes[driver].turns else RAM for driver in self.drivers)

    def place(self, position: Array) -> str:
        """Where the drivers are at joint coordinates (nv,), in words: "crank angle 30 deg", of several "A 30 deg, B -30 deg"."""
        return self.place_of_drivers(position[list(self.drivers)])

    def place_of_drivers(self, positions: Array) -> str:
        """`place` by the positions (drivers,) of the drivers [rad or m]; of many drivers the first few are named."""
        if len(self.drivers) == 1:
            return self.coordinates[0].at(float(positions[0]))
        names = [str(self.model.names[driver + 1]) for driver in self.drivers]
        each = [f"{name} {of.shown(float(at))}" for name, of, at in zip(names, self.coordinates, positions, strict=True)]
        more = len(each) - FEW
        return ", ".join(each) if more <= 0 else f"{', '.join(each[:FEW])} and {more} more"

    @cached_property
    def on_loop(self) -> NDArray[np.bool_]:
        """(nv,) whether a joint is on a loop."""
        found = np.zeros(self.model.nv, dtype=bool)
        found[[joint for joints in self.joints_of_loop for joint in joints]] = True
        return found

    @cached_property
    def incidence(self) -> Array:
        """(nv, nl) ``joints_of_loop`` as a matrix, zero where a joint is not on a loop."""
        result = np.zeros((self.model.nv, len(self.loops)))
        for k, joints in enumerate(self.joints_of_loop):
            for joint, sign in joints.items():
                result[joint, k] = sign
        return result

    def equations(self) -> Equations:
        """The equations of loops and couplings, for use within one call: they hold Pinocchio's data."""
        return Equations(self)


def build_spatial_model(
    model: pin.Model, loops: tuple[LoopJoint, ...], couplings: tuple[Coupling, ...], drivers: tuple[int, ...]
) -> SpatialModel:
    """Constants of a linkage from Pinocchio's model of its tree, its loops and couplings, and the indices of its drivers in v."""
    size, reach = _extent(model, loops)
    parents = [int(parent) - 1 for parent in list(model.parents)[1:]]
    return SpatialModel(
        model=model,
        loops=loops,
        couplings=couplings,
        drivers=drivers,
        passive_joints=tuple(j for j in range(model.nv) if j not in drivers),
        joints_of_loop=tuple(joints_between(parents, loop.joint1 - 1, loop.joint2 - 1) for loop in loops),
        size=size,
        tolerance=8 * float(np.finfo(float).eps) * (size + reach),
        slots=slots(model),
        axes=axes(model),
    )


@dataclass(frozen=True, eq=False, repr=False)
class Rows:
    """The equations at one configuration.

    Attributes:
        q: (nq,) the configuration.
        gaps: (rows,) what each equation misses [m].
        columns: (rows, nv) Jacobian of the gaps.
        held_directions: for every loop (3, 0 to 3) world axes, as columns, of the rotations that its bearing prevents.
    """

    q: Array
    gaps: Array
    columns: Array
    held_directions: list[Array]


class Equations:
    """The equations of a linkage, evaluated by Pinocchio's constraint models. They are built for each call, because constraint models can
    be neither copied nor pickled."""

    def __init__(self, spatial: SpatialModel) -> None:
        self.model, self.loops, self.size, self.slots = spatial.model, spatial.loops, spatial.size, spatial.slots
        self.data = data_of(self.model)
        self.placements, self.wrenches = self.data.oMi, self.data.f  # live: fetching them costs more than the algorithm that fills them
        self.anchors = [
            pin.PointAnchorConstraintModel(self.model, k.joint1, pin.SE3(np.eye(3), k.point1), k.joint2, pin.SE3(np.eye(3), k.point2))
            for k in self.loops
        ]
        self.datas = [anchor.createData() for anchor in self.anchors]
        self.incidence = spatial.incidence
        # of the joints that carry one end alone: the others would move a gap by rounding, or because it is open
        self.moving = [column != 0 for column in self.incidence.T]
        self.coupled, self.offsets = _coupled(spatial)
        self.rows = 3 * len(self.loops) + sum(loop.held_rotations for loop in self.loops) + len(self.offsets)
        self.rotations_held = any(loop.held_rotations for loop in self.loops)

    def at(self, x: Array) -> Rows:
        """The equations at joint coordinates (nv,). Afterwards ``data`` has the placements there."""
        q = configuration(self.slots, x)
        pin.computeJointJacobians(self.model, self.data, q)
        gaps, columns = np.empty(self.rows), np.empty((self.rows, self.model.nv))
        for k, (anchor, d) in enumerate(zip(self.anchors, self.datas, strict=True)):
            anchor.calc(self.model, self.data, d)
            rotation = d.oMc1.rotation
            gaps[3 * k : 3 * k + 3] = rotation @ d.constraint_position_error
            columns[3 * k : 3 * k + 3] = rotation @ anchor.jacobian(self.model, self.data, d).reshape(3, self.model.nv) * self.moving[k]
        held = self._fill_rotation_rows(gaps, columns) if self.rotations_held else [np.empty((3, 0))] * len(self.loops)
        if len(self.offsets):
            columns[-len(self.offsets) :] = self.coupled
            gaps[-len(self.offsets) :] = self.coupled @ x - self.offsets
        return Rows(q, gaps, columns, held)

    def drift(self, rows: Rows, v: Array) -> Array:
        """Second derivative (rows,) of the gaps at joint rates (nv,) and no joint acceleration."""
        pin.forwardKinematics(self.model, self.data, rows.q, v, np.zeros(self.model.nv))
        result = np.zeros(self.rows)
        row = 3 * len(self.loops)
        for k, (anchor, d) in enumerate(zip(self.anchors, self.datas, strict=True)):
            anchor.calc(self.model, self.data, d)
            result[3 * k : 3 * k + 3] = d.oMc1.rotation @ d.constraint_acceleration_error
            if count := self.loops[k].held_rotations:
                (spin1, turned1), (spin2, turned2) = (self._spin(joint) for joint in (self.loops[k].joint1, self.loops[k].joint2))
                # of t . (spin2 - spin1), where the direction t turns with body 1
                result[row : row + count] = self.size * rows.held_directions[k].T @ (turned2 - turned1 + cross(spin2 - spin1, spin1))
                row += count
        return result

    def widest(self, gaps: Array) -> float:
        """Largest gap of a loop or coupling [m], where rotations are multiplied by the length of the linkage."""
        count = 3 * len(self.loops)
        of_points = np.linalg.norm(gaps[:count].reshape(-1, 3), axis=1).max(initial=0.0)
        return float(max(of_points, np.abs(gaps[count:]).max(initial=0.0)))

    def worst(self, gaps: Array) -> int:
        """Index of the loop or coupling with the largest gap; couplings are counted after the loops."""
        sizes = [float(np.linalg.norm(gaps[3 * k : 3 * k + 3])) for k in range(len(self.loops))]
        row = 3 * len(self.loops)
        for k, loop in enumerate(self.loops):
            sizes[k] = max(sizes[k], float(np.abs(gaps[row : row + loop.held_rotations]).max(initial=0.0)))
            row += loop.held_rotations
        return int(np.argmax(sizes + list(np.abs(gaps[row:]))))

    def _fill_rotation_rows(self, gaps: Array, columns: Array) -> list[Array]:
        """Fill in the rows of the rotations that bearings prevent, and return their world axes."""
        turning, row, directions = self.data.J.reshape(6, -1)[3:], 3 * len(self.loops), []
        for k, loop in enumerate(self.loops):
            first, second = (
                self.placements[joint].rotation @ rotation
                for joint, rotation in ((loop.joint1, loop.rotation1), (loop.joint2, loop.rotation2))
            )
            if loop.type == "revolute":
                # the two axes are aligned, but may point against each other; axes across each other are a quarter turn apart either way
                error = cross(first[:, 0], second[:, 0]) * (-1.0 if first[:, 0] @ second[:, 0] < 0.0 else 1.0)
            elif loop.type == "fixed":
                error = first @ pin.log3(first.T @ second)
            else:
                error = np.zeros(3)
            held = first[:, 3 - loop.held_rotations :]
            gaps[row : row + loop.held_rotations] = self.size * held.T @ error
            turned = held.T @ (turning * self.incidence[:, k])
            turned[np.abs(turned) < PARALLEL_TO_ROUNDING] = 0.0
            columns[row : row + loop.held_rotations] = self.size * turned
            directions.append(held)
            row += loop.held_rotations
        return directions

    def _spin(self, joint: int) -> tuple[Array, Array]:
        """Angular velocity and acceleration (3,) of a joint's body in world axes [rad/s, rad/s2]."""
        rotation = self.placements[joint].rotation
        return rotation @ self.data.v[joint].angular, rotation @ self.data.a[joint].angular


def constraint_models(spatial: SpatialModel, closed: Array) -> tuple[pin.PointAnchorConstraintModel | pin.FrameAnchorConstraintModel, ...]:
    """See `Linkage.constraint_models`; ``closed``: (nv,) joint coordinates of the closed drawn pose."""
    model = spatial.model
    rotations: Sequence[Array] = ()
    if any(loop.held_rotations for loop in spatial.loops):
        data = data_of(model)
        pin.forwardKinematics(model, data, configuration(spatial.slots, closed))
        rotations = [placement.rotation for placement in data.oMi]
    found = []
    for loop in spatial.loops:
        if loop.type == "fixed":
            ends = pin.SE3(loop.rotation1, loop.point1), pin.SE3(loop.rotation2, loop.point2)
            anchors = [pin.FrameAnchorConstraintModel(model, loop.joint1, ends[0], loop.joint2, ends[1])]
        else:
            anchors = [
                pin.PointAnchorConstraintModel(
                    model, joint1, pin.SE3(loop.rotation1, place1.translation), joint2, pin.SE3(loop.rotation2, place2.translation)
                )
                for joint1, place1, joint2, place2 in held_points(loop, rotations, spatial.size)
            ]
        for anchor in anchors:
            anchor.name = loop.name
        found += anchors
    return tuple(found)


def held_points(loop: LoopJoint, rotations: Sequence[Array], size: float) -> list[PointPair]:
    """The points at which a loop is held: one of a spherical loop, two of a revolute and three of a fixed one.

    Args:
        loop: the loop.
        rotations: rotations of Pinocchio's joints in the closed pose; empty where no loop prevents rotations.
        size: length of the linkage, by which further points are away from the loop's own [m].
    """
    result = [(loop.joint1, pin.SE3(np.eye(3), loop.point1), loop.joint2, pin.SE3(np.eye(3), loop.point2))]
    for axis in range({0: 0, 2: 1, 3: 2}[loop.held_rotations]):
        along1, along2 = loop.rotation1[:, axis], loop.rotation2[:, axis]
        worlds = rotations[loop.joint1] @ along1, rotations[loop.joint2] @ along2
        turned = float(np.sign(worlds[0] @ worlds[1]))  # the axes of a revolute loop may point against each other
        places = (pin.SE3(np.eye(3), point) for point in (loop.point1 + size * along1, loop.point2 + turned * size * along2))
        result.append((loop.joint1, next(places), loop.joint2, next(places)))
    return result


def cross(one: Array, other: Array) -> Array:
    """The vector product of two vectors (3,); `numpy.cross` takes ten times as long for so few numbers."""
    (a, b, c), (x, y, z) = one.tolist(), other.tolist()
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


def _extent(model: pin.Model, loops: tuple[LoopJoint, ...]) -> tuple[float, float]:
    """Largest extent of joints and loop points in the drawn pose, and their largest distance from the world origin [m]."""
    places = drawn_placements(model)
    points = [place.translation.copy() for place in places[1:]]
    points += [places[k.joint1].act(k.point1) for k in loops] + [places[k.joint2].act(k.point2) for k in loops]
    cloud = np.array(points)
    size = float(np.linalg.norm(cloud.max(axis=0) - cloud.min(axis=0)))
    return size or 1.0, float(np.linalg.norm(cloud, axis=1).max())


def coupling_equations(spatial: SpatialModel) -> tuple[list[dict[int, float]], Array]:
    """Coefficients by joints of the coupling equations, and their right-hand sides (nc,)."""
    rows, offsets = [], np.zeros(len(spatial.couplings))
    for k, coupling in enumerate(spatial.couplings):
        unit = spatial.size if spatial.axes[coupling.follower].turns else 1.0
        rows.append({coupling.follower: unit, coupling.leader: -unit * coupling.multiplier})
        offsets[k] = unit * coupling.offset
    return rows, offsets


def _coupled(spatial: SpatialModel) -> tuple[Array, Array]:
    """Coefficients (nc, nv) and right-hand sides (nc,) of the coupling equations."""
    entries, offsets = coupling_equations(spatial)
    rows = np.zeros((len(entries), spatial.model.nv))
    for row, coefficients in zip(rows, entries, strict=True):
        row[list(coefficients)] = list(coefficients.values())
    return rows, offsets
