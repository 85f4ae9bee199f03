"""Forces as arrays, as every engine takes and returns them; friction in the bearings; and how bearings share redundant forces.

A linkage with redundant constraints can carry idle forces: they balance each other and move nothing, so that any multiple y of them may be
added to a solution. Rigid mechanics leaves y open. We choose it by a list of objectives: y minimises the first one; where that leaves y
open, it minimises the second one too, and so on:

    elastic energy, where stiffnesses are given (bearings without one count as rigid)
    sum of squared bearing forces
    sum of squared bearing moments

The efforts of drives, gear pairs and friction, about or along the axis in which a joint is free, do not count in these sums. What is open
even then (torques in a ring of gears) is made as small as possible.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import number
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.quantities import Array
from .rank import RANK

REST = 1e-12  # share of the motion's largest speed below which a bearing rests: at a dead centre its speed is rounding
MOST_ITERATIONS = 200  # of friction efforts and bearing forces in turn: many are needed only where friction nearly locks the linkage
INVERTIBLE = 1e-7  # share of the squared size of a matrix above which its smallest squared singular value is certainly no rounding
WELL_CONDITIONED = 1e-3  # share of the largest squared singular value above which normal equations lose hardly a digit


@dataclass(frozen=True)
class AppliedForce:
    """The force of one load over a motion.

    Attributes:
        joint: Pinocchio joint on whose body the force acts, 0 for the frame.
        point: (3,) where it acts, in that joint's frame [m].
        force: (n, 3) in world axes [N].
    """

    joint: int
    point: Array
    force: Array

    def part(self, points: slice) -> AppliedForce:
        """The load over a part of the motion."""
        return AppliedForce(self.joint, self.point, self.force[points])


class AppliedConditions(NamedTuple):
    """What acts on a linkage in motion.

    Attributes:
        loads: forces on links.
        law: friction of the bearings; None for none.
        compliance: (bearings,) compliances by which bearings share redundant forces [m/N]; None where no stiffness is given.
    """

    loads: list[AppliedForce]
    law: FrictionLaw | None
    compliance: Array | None

    def part(self, points: slice) -> AppliedConditions:
        """The conditions over a part of the motion."""
        return self._replace(loads=[load.part(points) for load in self.loads])


@dataclass(frozen=True, eq=False, repr=False)
class Wrenches:
    """Driving torques, and the forces and moments of the bearings.

    Bearings are the joints in Pinocchio's order, then the loops as declared. Forces and moments are in world axes, the action of parent on
    child (of link1 on link2).

    Attributes:
        torque: (drivers, n) on the driver joints, positive along their axes [N m, of a driver that slides N].
        coupling: (couplings, n) torque on the follower of every coupling, positive along its axis [N m, or N where it slides]. Without the
            bearings it is one of several solutions that balance, where rigid mechanics leaves it open.
        friction: (bearings, n) power lost in every bearing [W].
        force: (bearings, n, 3) forces [N]; (0, n, 3) where the bearings are left out.
        moment: (bearings, n, 3) moments about the origin of the child's joint frame, of a loop about its point [N m]; (0, n, 3) as above.
            Along the axis in which a joint is free the moment is the effort of drive, gear pairs and friction.
    """

    torque: Array
    coupling: Array
    friction: Array
    force: Array
    moment: Array

    @staticmethod
    def zeros(drivers: int, couplings: int, bearings: int, n: int, with_bearings: bool) -> Wrenches:
        """Wrenches to be filled in, of n states, with the forces and moments of the bearings or without; arguments are numbers of each.

        In memory the states are next to each other: components along one axis are filled in, and read, at once.
        """
        force, moment = np.zeros((2, 3, bearings if with_bearings else 0, n)).transpose(0, 2, 3, 1)
        return Wrenches(np.zeros((drivers, n)), np.zeros((couplings, n)), np.zeros((bearings, n)), force, moment)

    def part(self, points: slice) -> Wrenches:
        """Views of a part of the motion."""
        torque, coupling, friction = (array[:, points] for array in (self.torque, self.coupling, self.friction))
        return Wrenches(torque, coupling, friction, self.force[:, points], self.moment[:, points])


@dataclass(frozen=True, eq=False, repr=False)
class FrictionLaw:
    """The friction of all bearings, joints in Pinocchio's order, then loops.

    Attributes:
        arm: (bearings,) effort of dry friction by the bearing's radial force: mu r of a pin [m], mu of a guide [-].
        viscous: (bearings,) effort by speed [N m s, of a guide N s/m].
        preload: (bearings,) force with which the gibs of a guide press on it without a load; zero of all others [N].
        turns: (bearings,) False for guides, True for all others.
        size: length of the linkage [m].
    """

    arm: Array
    viscous: Array
    preload: Array
    turns: NDArray[np.bool_]
    size: float

    def moving(self, speeds: Array) -> Array:
        """Speeds (bearings, n), set to zero where they are rounding beside the fastest of the motion."""
        turning = np.abs(speeds[self.turns]).max(initial=0.0)
        sliding = max(self.size * turning, np.abs(speeds[~self.turns]).max(initial=0.0))
        return np.where(np.abs(speeds) <= REST * np.where(self.turns, turning, sliding)[:, None], 0.0, speeds)

    def efforts(self, speeds: Array, forces: Callable[[Array], Array], place: Callable[[int], str]) -> Array:
        """Friction efforts (bearings, n), opposed to the speeds: negative where the speed is positive [N m, of a guide N].

        Bearing forces depend on friction and friction on them: both are found in turn until they no longer change.

        Args:
            speeds: (bearings, n) speeds of the bearings [rad/s, of a guide m/s], exactly zero where one rests.
            forces: function of friction efforts (bearings, n) that returns the radial forces (bearings, n) under them [N].
            place: gives where the drivers are in a state, in words, for the message of an error.

        Raises:
            PinpressError: there are no consistent forces, because friction locks the linkage, or nearly so.
        """
        steady = -self.viscous[:, None] * speeds
        against = -self.arm[:, None] * np.sign(speeds)
        found, change = steady, np.full(speeds.shape[1], np.inf)
        for _ in range(MOST_ITERATIONS):
            pressing = np.maximum(forces(found), self.preload[:, None])
            following = steady + against * pressing
            before, change = change, np.abs(following - found).max(axis=0)
            # measured also by what the largest force could do: the force of a single guide may be nothing but rounding
            size = np.maximum(np.abs(following).max(axis=0), self.arm.max() * pressing.max(axis=0))
            found = following
            # rounding can keep the last digits moving: stop where the change no longer shrinks
            if np.all((change <= 1e-15 * size) | ((change <= 1e-12 * size) & (change >= before))):
                return found
            if not np.isfinite(size).all():
                break
        worst = int(np.argmax(np.where(np.isfinite(change), change, np.inf)))
        raise PinpressError(
            f"friction locks the linkage, or nearly so, at {place(worst)}: no consistent bearing forces are found;"
            " lower the coefficients of friction, or keep away from the dead point"
        )


class BearingLoads(NamedTuple):
    """What friction depends on in every bearing, joints in Pinocchio's order, then loops.

    Attributes:
        speed: (bearings, n) speeds of the bearings [rad/s, of a guide m/s].
        radial: (bearings, n, 3) vectors whose lengths are the radial forces; they are affine in accelerations, loads and efforts [N].
    """

    speed: Array
    radial: Array


class Objective(NamedTuple):
    """A quantity |A y + b| to be minimised.

    Attributes:
        matrix: A (..., m, k).
        start: b (..., m).
        scale: size of an entry of A; what is small beside it is rounding.
    """

    matrix: Array
    start: Array
    scale: float


def lexicographic_least_squares(objectives: Iterable[Objective]) -> Array:
    """The y (..., k) that minimises the objectives one after the other: each among the y that the ones before it leave open. Of the y that
    all of them leave open, the shortest."""
    starts: list[Array] = []

    def matrices() -> Iterator[tuple[Array, float]]:
        for matrix, start, scale in objectives:
            starts.append(start)
            yield matrix, scale

    parts = zip(lexicographic_responses(matrices()), starts, strict=True)
    return np.asarray(-sum((response @ start[..., None])[..., 0] for response, start in parts))


def lexicographic_responses(objectives: Iterable[tuple[Array, float]]) -> list[Array]:
    """How the y of `lexicographic_least_squares` follows from the starts of the objectives: it is -sum(response @ start).

    Args:
        objectives: matrices A (..., m, k) and scales, see `Objective`. The next one is asked for only where the ones before it leave
            something open.

    Returns:
        Responses (..., k, m), of as many of the objectives as were asked for.
    """
    responses: list[Array] = []
    open_ways: Array | None = None  # (..., k, j) of y that the objectives leave open
    for matrix, scale in objectives:
        inner = matrix if open_ways is None else matrix @ open_ways
        # measured by the whole matrix: where the earlier objectives have decided all of y, every singular value is rounding
        size = np.maximum(np.linalg.norm(matrix, axis=(-2, -1)), scale)
        inverse, left_open = _by_squares(inner, size) or _by_singular_values(inner, size)
        step = inverse if open_ways is None else open_ways @ inverse
        responses = [earlier - step @ (matrix @ earlier) for earlier in responses] + [step]
        open_ways = left_open if open_ways is None else open_ways @ left_open
        if np.abs(open_ways).max(initial=0.0) < 1e-6:
            break
    return responses


def _by_squares(matrix: Array, size: Array) -> tuple[Array, Array] | None:
    """The pseudo-inverse (..., k, m) of a matrix (..., m, k) of this size (...), and orthonormal columns (..., k, j) that it takes to zero.

    From the normal equations, which cost a fifth of singular values, where all of these are well above rounding, or each is either large or
    rounding; None where they are not, or where the columns differ in number.
    """
    turned = matrix.swapaxes(-1, -2)
    squares = turned @ matrix
    with suppress(np.linalg.LinAlgError):  # singular
        inverse = np.linalg.inv(squares)
        smallest = 1.0 / np.linalg.norm(inverse, axis=(-2, -1))  # eigenvalue, or less
        if np.all(smallest > INVERTIBLE * size**2):
            inverse = inverse @ turned
            # a step of Newton's method for the inverse of a matrix brings the digits back that squares lose
            return inverse + (np.eye(squares.shape[-1]) - inverse @ matrix) @ inverse, squares[..., :0]
    values, vectors = np.linalg.eigh(squares)
    large = values > WELL_CONDITIONED * (size**2)[..., None]
    count = int(large.sum(axis=-1).max(initial=0))
    rest = values.shape[-1] - count
    if not large[..., rest:].all():
        return None
    left_open = vectors[..., :rest]
    if rest and not np.all(np.linalg.norm(matrix @ left_open, axis=(-2, -1)) <= RANK * size):
        return None
    kept = vectors[..., rest:]
    inverse = (kept / values[..., None, rest:]) @ (matrix @ kept).swapaxes(-1, -2)
    return inverse, left_open


def _by_singular_values(matrix: Array, size: Array) -> tuple[Array, Array]:
    """`_by_squares` for any matrix; the columns (..., k, k) that it takes to zero span them, but are not independent."""
    left, values, right = np.linalg.svd(matrix, full_matrices=False)
    kept = values > RANK * size[..., None]
    inverse = right.swapaxes(-1, -2) * np.where(kept, 1.0 / np.where(kept, values, 1.0), 0.0)[..., None, :] @ left.swapaxes(-1, -2)
    return inverse, np.eye(matrix.shape[-1]) - inverse @ matrix


def compliances(stiffness: Mapping[str, float], bearings: Sequence[str]) -> Array | None:
    """The compliances (bearings,) of bearings [m/N], zero where no stiffness is given; None where none is given at all.

    Args:
        stiffness: stiffnesses by the names of bearings [N/m].
        bearings: names of all bearings of the linkage, in order.

    Raises:
        UnknownNameError: a bearing that the linkage does not have.
        PinpressError: no mapping, or a stiffness that is not a positive finite number.
    """
    if not isinstance(stiffness, Mapping):
        raise PinpressError("stiffness is no mapping: give {name of a bearing: stiffness [N/m]}")
    if not stiffness:
        return None
    result = np.zeros(len(bearings))
    for name, value in stiffness.items():
        if name not in bearings:
            raise UnknownNameError("bearing", name, bearings)
        result[bearings.index(name)] = 1 / number(f"stiffness of {shown(name)} [N/m]", value, "N/m", positive=True)
    return result
