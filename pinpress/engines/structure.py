"""The structure of a linkage: the tree of its joints, its constraints and drivers, its size; and the coordinates of its joints.

Every joint has one coordinate, in the order of v: an angle [rad], unwrapped, or a travel [m], zero in the drawn pose. Pinocchio's q holds
these coordinates too, but for an unbounded (``continuous``) joint it holds the cosine and sine of its angle.

The equations of a structure are, in this order: for every loop the distance of its ends, three rows (point 2 less point 1, world axes); for
every loop the rotations that its bearing prevents, of body 2 against body 1 about axes of end 1; one row for every relation. Rows of angles
[rad] are multiplied by the size of the linkage, so that all rows are lengths and can be compared. The multiplier of such a row is a torque
divided by that length.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ..common.errors import PinpressError
from ..common.quantities import CRANK, RAM, Array, DriverCoordinate
from .constraints import Curve, LoopJoint, Relation
from .contacts import Contact, racks

ACCEPTED = 1e3  # multiples of rounding up to which a gap counts as closed
ZERO = 1e-9  # singular values below this share of the largest are rounding, columns scaled to unit length
SMALLEST_MARGIN = 1e-6  # singular value below which a linkage counts as locked: rounding decides there between two assemblies
MOST_JOINTS = 200  # `pin.Data` has 7 arrays whose size grows with the cube of the joints: half a gigabyte at this number


@dataclass(frozen=True, eq=False, repr=False)
class Structure:
    """What the engines compute with: a linkage without names and masses of its links.

    Attributes:
        model: Pinocchio's model of the tree.
        loops: bearings at which loops were cut, as declared.
        relations: between joint coordinates, as declared.
        drivers: indices of the driver joints in v.
        size: length of the linkage [m]: largest extent of joints and loop points in the drawn pose.
        rounding: gap that rounding leaves in a closed loop [m].
        slots: places of the joints in q.
        axes: axes of the joints.
        misfit: gap that is left because redundant equations contradict each other, where the numbers of a file are rounded [m]; 0 where
            that gap is rounding. See `engines.misfit`.
        contacts: where bodies push on each other by teeth, threads or rollers, by the multipliers of relations; those of the linkage, then
            those of racks that are relations alone.
    """

    model: pin.Model
    loops: tuple[LoopJoint, ...]
    relations: tuple[Relation, ...]
    drivers: tuple[int, ...]
    size: float
    rounding: float
    slots: tuple[Slot, ...]
    axes: tuple[Axis, ...]
    misfit: float = 0.0
    contacts: tuple[Contact, ...] = ()

    @cached_property
    def tolerance(self) -> float:
        """Gap up to which a loop counts as closed [m]."""
        return max(ACCEPTED * self.rounding, 10 * self.misfit)

    @cached_property
    def rank_tolerance(self) -> float:
        """Singular values below this count as zero, columns scaled to unit length. Rounded numbers lift those of redundant equations from
        zero to 0.1 to 3 times the misfit, in lengths of the linkage."""
        return max(ZERO, 30 * self.misfit / self.size)

    @cached_property
    def smallest_margin(self) -> float:
        """Smallest singular value of the passive joints' columns below which the linkage counts as locked."""
        return max(SMALLEST_MARGIN, self.rank_tolerance)

    @cached_property
    def turns(self) -> NDArray[np.bool_]:
        """(nv,) whether a joint turns."""
        return np.array([axis.turns for axis in self.axes], dtype=bool)

    @cached_property
    def lengths(self) -> Array:
        """(nv,) what counts as 1 rad of each joint [rad or m]."""
        return np.where(self.turns, 1.0, self.size)

    @cached_property
    def parents(self) -> tuple[int, ...]:
        """(nv,) index in v of every joint's parent joint, -1 for the frame."""
        return tuple(int(parent) - 1 for parent in list(self.model.parents)[1:])

    @cached_property
    def passive_joints(self) -> tuple[int, ...]:
        """Indices in v of all joints but the drivers."""
        return tuple(j for j in range(self.model.nv) if j not in self.drivers)

    @cached_property
    def joints_of_loop(self) -> tuple[dict[int, float], ...]:
        """(nl,) the joints on every loop: +1 where a joint carries only its end 2, -1 where only its end 1."""
        return tuple(joints_between(self.parents, loop.joint1 - 1, loop.joint2 - 1) for loop in self.loops)

    @cached_property
    def joints_of_constraints(self) -> tuple[tuple[int, ...], ...]:
        """(nl + nr,) the joints that every loop, then every relation names."""
        return (*map(tuple, self.joints_of_loop), *(relation.joints for relation in self.relations))

    @cached_property
    def on_loop(self) -> NDArray[np.bool_]:
        """(nv,) whether a joint is on a loop."""
        return np.asarray((self.incidence != 0.0).any(axis=1))

    @cached_property
    def returning(self) -> NDArray[np.bool_]:
        """(nv,) whether a joint has to come back, but for whole turns, before motion repeats itself: on loops, and of cams and their
        followers."""
        curved = [joint for relation in self.relations if relation.curve is not None for joint in relation.joints]
        return self.on_loop | np.isin(np.arange(self.model.nv), curved)

    @cached_property
    def incidence(self) -> Array:
        """(nv, nl) ``joints_of_loop`` as a matrix, zero where a joint is not on a loop."""
        return _matrix(self.joints_of_loop, self.model.nv).T.copy()

    @cached_property
    def relation_units(self) -> Array:
        """(nr,) factors that make the equations of the relations lengths [m; 1 if the joint slides that a relation determines]. The
        multiplier of an equation times its factor is the effort on this joint."""
        return np.array([self.size if self.axes[relation.joint].turns else 1.0 for relation in self.relations])

    @cached_property
    def relation_coefficients(self) -> Array:
        """(nr, nv) coefficients of the relations."""
        return _matrix([relation.coefficients for relation in self.relations], self.model.nv)

    @cached_property
    def relation_slopes(self) -> Array:
        """(nr, nv) slopes of the equations of the relations, without those of curves."""
        return np.asarray(self.relation_units[:, None] * self.relation_coefficients)

    @cached_property
    def relation_offsets(self) -> Array:
        """(nr,) right-hand sides of these equations."""
        return np.asarray(self.relation_units * [relation.offset for relation in self.relations])

    @cached_property
    def curves(self) -> tuple[tuple[int, Curve], ...]:
        """Indices of the relations with curves, and the curves."""
        return tuple((k, relation.curve) for k, relation in enumerate(self.relations) if relation.curve is not None)

    def relation_gaps(self, x: Array) -> Array:
        """What the equations of the relations miss at joint coordinates (nv, n): (nr, n)."""
        gaps = np.asarray(self.relation_slopes @ x - self.relation_offsets[:, None])
        for k, curve in self.curves:
            gaps[k] -= self.relation_units[k] * curve.at(x)[0]
        return gaps

    def slopes_of_curves(self, x: Array) -> Iterator[tuple[int, int, Array]]:
        """Relation, joint and slope (n,) by this joint of every curve, at joint coordinates (nv, n)."""
        for k, curve in self.curves:
            yield k, curve.joint, -self.relation_units[k] * curve.at(x)[1]

    def relation_drift(self, x: Array, v: Array) -> Array:
        """Second derivative (nr, n) of these gaps at joint coordinates and rates (nv, n) and no joint acceleration."""
        drift = np.zeros((len(self.relations), *x.shape[1:]))
        for k, curve in self.curves:
            drift[k] = -self.relation_units[k] * curve.at(x)[2] * v[curve.joint] ** 2
        return drift

    @cached_property
    def coordinates(self) -> tuple[DriverCoordinate, ...]:
        """What the coordinates of the drivers are."""
        return tuple(CRANK if self.axes[driver].turns else RAM for driver in self.drivers)

    def place(self, position: Array) -> str:
        """Where the drivers are at joint coordinates (nv,), as text: "crank angle 30 deg", of several "A 30 deg, B -30 deg"."""
        return self.place_of_drivers(position[list(self.drivers)])

    def place_of_drivers(self, positions: Array) -> str:
        """`place` by the positions (drivers,) of the drivers [rad or m]; of many drivers the first few are named."""
        if len(self.drivers) == 1:
            return self.coordinates[0].at(float(positions[0]))
        places = zip((self.model.names[driver + 1] for driver in self.drivers), self.coordinates, positions, strict=True)
        shown = [f"{name} {coordinate.shown(float(position))}" for name, coordinate, position in places]
        most = 6  # more would fill the message
        return ", ".join(shown) if len(shown) <= most else f"{', '.join(shown[:most])} and {len(shown) - most} more"


def build_structure(
    model: pin.Model,
    loops: tuple[LoopJoint, ...],
    relations: tuple[Relation, ...],
    drivers: tuple[int, ...],
    contacts: tuple[Contact, ...] = (),
) -> Structure:
    """The structure of a linkage from Pinocchio's model of its tree, its loops, relations and contacts, and the indices of its drivers in
    v."""
    size, reach = _extent(model, loops)
    own = axes(model)
    nameless = racks(model, [axis.turns for axis in own], [axis.direction for axis in own], relations, contacts)
    return Structure(
        model=model,
        loops=loops,
        relations=relations,
        drivers=drivers,
        size=size,
        rounding=8 * float(np.finfo(float).eps) * (size + reach),
        slots=slots(model),
        axes=own,
        contacts=(*contacts, *nameless),
    )


def _matrix(rows: Sequence[Mapping[int, float]], width: int) -> Array:
    """(rows, width) these entries by their columns; all others are zero."""
    result = np.zeros((len(rows), width))
    for row, entries in zip(result, rows, strict=True):
        row[list(entries)] = list(entries.values())
    return result


def _extent(model: pin.Model, loops: tuple[LoopJoint, ...]) -> tuple[float, float]:
    """Largest extent of joints and loop points in the drawn pose, and their largest distance from the world origin [m]."""
    places = drawn_placements(model)
    points = [place.translation.copy() for place in places[1:]]
    points += [places[k.joint1].act(k.point1) for k in loops] + [places[k.joint2].act(k.point2) for k in loops]
    cloud = np.array(points)
    size = float(np.linalg.norm(cloud.max(axis=0) - cloud.min(axis=0)))
    return size or 1.0, float(np.linalg.norm(cloud, axis=1).max())


def joints_between(parents: Sequence[int], joint1: int, joint2: int) -> dict[int, float]:
    """The joints on the path through the tree between two joints, rising: +1 for those that carry only the second one, -1 for those that
    carry only the first one.

    Args:
        parents: parent of every joint. Joints are counted in the order of v, -1 stands for the frame.
        joint1: the first joint.
        joint2: the second joint.
    """
    signs: dict[int, float] = {}
    for joint, sign in ((joint2, 1.0), (joint1, -1.0)):
        while joint >= 0:
            signs[joint] = signs.get(joint, 0.0) + sign
            joint = parents[joint]
    return {joint: sign for joint, sign in sorted(signs.items()) if sign}


# ------------------------------------------------------------------------------------------------------- Pinocchio's model of the tree


class Slot(NamedTuple):
    """Place of a joint in q.

    Attributes:
        start: index of its first number.
        unbounded: whether it has two numbers, cosine and sine, in place of one.
    """

    start: int
    unbounded: bool


def slots(model: pin.Model) -> tuple[Slot, ...]:
    """Slots of the moving joints, in the order of v."""
    return tuple(Slot(joint.idx_q, joint.nq == 2) for joint in list(model.joints)[1:])


class Axis(NamedTuple):
    """Axis of a joint.

    Attributes:
        direction: (3,) unit vector in the joint's own frame.
        turns: True where the joint turns about it, False where it slides along it.
    """

    direction: Array
    turns: bool

    def step(self, coordinate: float) -> pin.SE3:
        """Placement of the joint's frame at a coordinate, in that at zero."""
        along = self.direction * coordinate
        return pin.SE3(pin.exp3(along), np.zeros(3)) if self.turns else pin.SE3(np.eye(3), along)


def axes(model: pin.Model) -> tuple[Axis, ...]:
    """Axes of the moving joints, in the order of v."""
    columns = (np.ravel(joint.createData().S) for joint in list(model.joints)[1:])
    return tuple(Axis(c[3:].copy(), True) if np.linalg.norm(c[3:]) > 0.5 else Axis(c[:3].copy(), False) for c in columns)


def data_of(model: pin.Model) -> pin.Data:
    """Pinocchio's workspace for a model.

    Raises:
        PinpressError: more than `MOST_JOINTS` joints, for which it would take gigabytes.
    """
    if model.nv > MOST_JOINTS:
        problem = f"{model.name} has {model.nv} joints, more than the {MOST_JOINTS} that Pinocchio has room for"
        raise PinpressError(f"{problem}; model fewer, or ask only for what the planar engine computes")
    return model.createData()


def drawn_placements(model: pin.Model) -> list[pin.SE3]:
    """Placements of all joints in the world in the drawn pose, the world's own first.

    They are products of constant placements down the tree. Pinocchio's own function needs `pin.Data`, whose size grows with nv cubed.
    """
    places = [pin.SE3.Identity()]
    for joint, parent in enumerate(list(model.parents)[1:], 1):
        places.append(places[parent] * model.jointPlacements[joint])
    return places


def configuration(slots: tuple[Slot, ...], x: Array) -> Array:
    """Configurations (nq, ...) of joint coordinates (nv, ...)."""
    q = np.empty((sum(2 if slot.unbounded else 1 for slot in slots), *x.shape[1:]))
    for (start, unbounded), coordinate in zip(slots, x, strict=True):
        if unbounded:
            np.cos(coordinate, out=q[start, ...])
            np.sin(coordinate, out=q[start + 1, ...])
        else:
            q[start] = coordinate
    return q
