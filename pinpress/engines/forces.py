"""What either engine takes and returns, as arrays: forces on the links; friction in all bearings at once, found together with the forces
that cause it; efforts of drives and gear pairs; the force and moment in every joint and loop; and how forces are shared that rigid
mechanics leaves open.

A linkage with more constraints than it needs can carry idle forces, which move nothing: any multiple y of them may be added to a solution.
Of all y the one is taken that makes the first objective least, of those that do so the one that makes the second least, and so on:

    elastic energy, where stiffnesses are given (bearings without one count as rigid)
    sum of squared bearing forces
    sum of squared bearing moments

Efforts about or along the axis in which a joint is free, those of drives, gear pairs and friction, carry no weight. What is open even then
(torques in a ring of gears) is taken as small as possible.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import number
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.quantities import Array


@dataclass(frozen=True)
class AppliedForce:
    """A load worked out for one motion: on the body of Pinocchio joint ``joint`` (0: the frame), ``point`` (3,) in that joint's
    frame [m], ``force`` (n, 3) in world axes [N]."""

    joint: int
    point: Array
    force: Array

    def part(self, points: slice) -> AppliedForce:
        """The load over a part of the motion."""
        return AppliedForce(self.joint, self.point, self.force[points])


class AppliedConditions(NamedTuple):
    """What acts on a linkage in motion, and what is asked of its gears.

    Attributes:
        loads: forces on links.
        law: friction of the bearings, None where there is none.
        compliance: (bearings,) by which bearings share forces [m/N], None where no stiffness is given.
        gears: whether the torques of gear pairs are wanted; if not, they are one of several that balance.
    """

    loads: list[AppliedForce]
    law: FrictionLaw | None
    compliance: Array | None
    gears: bool

    def part(self, points: slice) -> AppliedConditions:
        """The conditions over a part of the motion."""
        return self._replace(loads=[load.part(points) for load in self.loads])


@dataclass(frozen=True, eq=False, repr=False)
class Wrenches:
    """Joints in Pinocchio's order, then loops as declared; all in world axes, parent on child (link1 on link2), at the joint. Forces and
    moments are of the bearings that were wanted, in the same order.

    Attributes:
        torque: (drivers, n) on the driver joints, positive along their axes [N m].
        coupling: (couplings, n) torque on the follower of each, positive along its axis [N m, or N where it slides].
        friction: (bearings, n) power lost in each [W].
        force: (wanted bearings, n, 3) [N].
        moment: (wanted bearings, n, 3) about the origin of the child's joint frame [N m], of a loop about its point; along the axis in
            which a joint is free it is the effort of drive, gear pairs and friction.
    """

    torque: Array
    coupling: Array
    friction: Array
    force: Array
    moment: Array

    @staticmethod
    def zeros(drivers: int, couplings: int, bearings: int, n: int, wanted: int) -> Wrenches:
        """To be filled in; counts of each, ``wanted`` of the bearings."""
        return Wrenches(
            torque=np.zeros((drivers, n)),
            coupling=np.zeros((couplings, n)),
            friction=np.zeros((bearings, n)),
            force=np.zeros((wanted, n, 3)),
            moment=np.zeros((wanted, n, 3)),
        )

    def part(self, points: slice) -> Wrenches:
        """Views of a part of the motion."""
        return Wrenches(
            self.torque[:, points], self.coupling[:, points], self.friction[:, points], self.force[:, points], self.moment[:, points]
        )


REST = 1e-12  # share of the motion's largest speed below which a bearing rests: in a dead centre the speed is rounding
MOST_ITERATIONS = 200


@dataclass(frozen=True, eq=False, repr=False)
class FrictionLaw:
    """The friction of all bearings, joints in Pinocchio's order, then loops.

    Attributes:
        arm: (bearings,) mu r [m], of guides mu [-].
        viscous: (bearings,).
        turns: (bearings,) true but for guides.
        size: length of the linkage [m].
    """

    arm: Array
    viscous: Array
    turns: NDArray[np.bool_]
    size: float

    def moving(self, speeds: Array) -> Array:
        """Speeds (bearings, n), zero where they are rounding, beside the fastest of the motion."""
        turning = np.abs(speeds[self.turns]).max(initial=0.0)
        sliding = max(self.size * turning, np.abs(speeds[~self.turns]).max(initial=0.0))
        return np.where(np.abs(speeds) <= REST * np.where(self.turns, turning, sliding)[:, None], 0.0, speeds)

    def efforts(self, speeds: Array, forces: Callable[[Array], Array], angle: Array) -> Array:
        """Efforts (bearings, n) of friction, along the speeds, against them.

        Args:
            speeds: (bearings, n) of the bearings; exactly zero where one rests.
            forces: radial forces (bearings, n) under efforts (bearings, n) of friction.
            angle: (n,) crank angles, to name one.

        Raises:
            PinpressError: no consistent forces are found: friction locks the linkage, or nearly so.
        """
        steady = -self.viscous[:, None] * speeds
        against = -self.arm[:, None] * np.sign(speeds)
        found, change = steady, np.full(speeds.shape[1], np.inf)
        for _ in range(MOST_ITERATIONS):
            pressing = forces(found)
            following = steady + against * pressing
            before, change = change, np.abs(following - found).max(axis=0)
            # also beside what the largest force could do: a guide's own may be nothing but rounding
            size = np.maximum(np.abs(following).max(axis=0), self.arm.max() * pressing.max(axis=0))
            found = following
            # rounding can keep the last digits moving: stop where the change no longer shrinks
            if np.all((change <= 1e-15 * size) | ((change <= 1e-12 * size) & (change >= before))):
                return found
            if not np.isfinite(size).all():
                break
        worst = int(np.argmax(np.where(np.isfinite(change), change, np.inf)))
        raise PinpressError(
            f"friction locks the linkage, or nearly so, at crank angle {np.degrees(angle[worst]):.6g} deg: no consistent bearing forces are"
            " found; lower the coefficients of friction, or keep away from the dead point"
        )


RANK = 1e-9  # singular values below this share of the largest are zero, columns scaled to unit length

WELL = 1e-3  # the same of squared ones, from which on normal equations lose no digits to speak of


class Objective(NamedTuple):
    """|A y + b| is to be least: A (..., m, k), b (..., m). What is small beside ``scale``, a unit of A, is rounding."""

    matrix: Array
    start: Array
    scale: float


def lexicographic_least_squares(objectives: Iterable[Objective]) -> Array:
    """y (..., k) that makes the first objective least, of those that do so the one that makes the second least, and so on; the shortest of
    those left open."""
    share, free = None, None
    for matrix, start, scale in objectives:
        if share is None or free is None:
            squares = matrix.swapaxes(-1, -2) @ matrix
            values = np.linalg.eigvalsh(squares)
            if np.all(values[..., 0] > WELL * np.maximum(values[..., -1], scale**2)):
                # nothing is left open: the normal equations serve, and cost a third
                return np.asarray(-np.linalg.solve(squares, matrix.swapaxes(-1, -2) @ start[..., None])[..., 0])
            share = np.zeros((*start.shape[:-1], matrix.shape[-1], 1))
            free = np.broadcast_to(np.eye(matrix.shape[-1]), (*start.shape[:-1], matrix.shape[-1], matrix.shape[-1]))
        left, values, right = np.linalg.svd(matrix @ free, full_matrices=False)
        # measured by the whole matrix: where an earlier objective left nothing free, all values are rounding
        kept = values > RANK * np.maximum(np.linalg.norm(matrix, axis=(-2, -1)), scale)[..., None]
        inverse = right.swapaxes(-1, -2) * np.where(kept, 1.0 / np.where(kept, values, 1.0), 0.0)[..., None, :] @ left.swapaxes(-1, -2)
        share = share - inverse @ (matrix @ share + start[..., None])
        free = free - inverse @ (matrix @ free)
        if np.abs(free).max(initial=0.0) < 1e-6:
            break
    assert share is not None
    return share[..., 0]


def compliances(stiffness: Mapping[str, float], bearings: Sequence[str]) -> Array | None:
    """(bearings,) of the linkage with bearings of these names [m/N], zero where no stiffness is given; None where none is given at all.

    Raises:
        UnknownNameError: a bearing that the linkage does not have.
        PinpressError: a stiffness that is not a positive finite number.
    """
    if not isinstance(stiffness, Mapping):
        raise PinpressError("stiffness is no mapping: give {name of a bearing: stiffness [N/m]}")
    if not stiffness:
        return None
    result = np.zeros(len(bearings))
    for name, value in stiffness.items():
        if name not in bearings:
            raise UnknownNameError("bearing", name, bearings)
        result[bearings.index(name)] = 1 / number(f"stiffness of {shown(name)} [N/m]", value, positive=True)
    return result
