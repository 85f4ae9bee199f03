"""The interface of an engine, and the closed states that it works on. `Linkage.engine` chooses one of the engines.

Positions, rates and accelerations are (nv, n): one row for each joint, in the order of v, and one column for each state.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..common.errors import AssemblyError
from ..common.quantities import Array, ComplexArray
from .body_motion import BodyMotion
from .structure import Structure
from .wrenches import AppliedConditions, BearingLoads, Idle, Wrenches

PIECE = 2048  # crank angles that are worked through at a time: their arrays stay in the cache
MOST_NEWTON_STEPS = 12  # of one closure: from a good guess it takes one or two
LOOSEST = 1e-6  # gap, in lengths of the linkage, above which a motion belongs to another linkage
KEPT = 1 << 24  # freed memory of a process up to which it is kept for the next call [bytes]

# The GNU C library gives freed memory above a limit back to the system, and the next call takes it again page by page, which costs up to a
# third of its time. The limit rises to the largest block that was ever freed; this one is never touched, and so takes no memory.
np.empty(KEPT, dtype=np.uint8)


@dataclass(frozen=True, eq=False, repr=False)
class Closure:
    """Closed configurations and their first-order and second-order influence coefficients.

    Attributes:
        position: (nv, n) joint coordinates [rad or m].
        first: (nv, n) d position / d crank angle.
        second: (nv, n) d2 position / d crank angle2.
        gap: (n,) largest distance between the two sides of a loop [m]; large or not finite where Newton's method failed.
        widest: the largest gap of all configurations [m].
        iterations: number of Newton steps.
        margins: (blocks, n) distance of every block of loops from singularity: the smallest singular value of its Jacobian, whose columns
            are scaled to unit length, with the sign of its determinant. It is zero where two assemblies meet. The engines in space have one
            block, and no sign. None unless asked for.
        basis: (nb, n) the planar engine's basis functions, see `planar.model`; None from the other engines.
        solved: `spatial.closing.Solved`, what the engine in space keeps from closing; None from the other engines.
    """

    position: Array
    first: Array
    second: Array
    gap: Array
    widest: float
    iterations: int
    margins: Array | None = None
    basis: ComplexArray | None = None
    solved: Any = None


def joined(pieces: Iterable[Closure], count: int) -> Closure:
    """One closure from those of consecutive crank angles, ``count`` in all, without what the engines keep of a piece alone.

    Each piece is copied while it is in the cache, and its memory serves the next one.
    """
    whole: dict[str, Any] = {}
    widest, iterations, start = 0.0, 0, 0
    for piece in pieces:
        names = ("position", "first", "second", "gap", "margins", "basis")
        parts = {name: part for name in names if (part := getattr(piece, name)) is not None}
        if not whole:
            whole = {name: np.empty((*part.shape[:-1], count), part.dtype) for name, part in parts.items()}
        end = start + len(piece.gap)
        for name, part in parts.items():
            whole[name][..., start:end] = part
        widest = widest if piece.widest <= widest else piece.widest  # which may be NaN
        iterations, start = max(iterations, piece.iterations), end
    return Closure(**whole, widest=widest, iterations=iterations)


Close = Callable[[Array, Array], Closure]
"""(crank angles (n,), guesses (nv, n)) -> Closure with its margins. It never raises: the caller judges gap and margins."""
CloseDrivers = Callable[[Array, Array, Array], Closure]
"""(driver positions (drivers, n), driver rates (drivers, n) to which the influence coefficients belong, guesses (nv, n)) -> Closure
with its margins. It never raises: the caller judges gap and margins."""


@dataclass(frozen=True, eq=False, repr=False)
class ClosedStates:
    """Positions, rates and accelerations of a linkage whose loops are closed.

    Attributes:
        position: (nv, n) joint coordinates [rad or m].
        v: (nv, n) joint rates [rad/s or m/s].
        a: (nv, n) joint accelerations [rad/s2 or m/s2].
        basis: (nb, n) the planar engine's basis functions, kept from closing these positions, see `planar.model`; None if the planar
            engine did not close them.
        solved: what the engine in space keeps from closing these positions, see `Closure`; None if it did not close them all at once.
    """

    position: Array
    v: Array
    a: Array
    basis: ComplexArray | None = None
    solved: Any = None

    def part(self, points: slice) -> ClosedStates:
        """The states of a part of the motion, without what the engine in space keeps."""
        return ClosedStates(
            self.position[:, points], self.v[:, points], self.a[:, points], None if self.basis is None else self.basis[:, points]
        )


class JointRates(NamedTuple):
    """Rates of all joints at closed positions.

    Attributes:
        v: (nv, n) joint rates [rad/s or m/s].
        a: (nv, n) joint accelerations [rad/s2 or m/s2].
        gap: (n,) largest distance between the two sides of a loop [m].
        solved: what the engine in space keeps, see `Closure`.
    """

    v: Array
    a: Array
    gap: Array
    solved: Any = None


class Engine(Protocol):
    """What every engine computes of one linkage."""

    @property
    def name(self) -> str:
        """Name of the engine, "plane", "space" or "pinocchio"."""

    @property
    def structure(self) -> Structure:
        """The structure of the linkage."""

    @property
    def tolerance(self) -> float:
        """Gap at which a loop counts as closed [m]."""

    @property
    def piece(self) -> int:
        """Number of states that are worked through at a time."""

    @property
    def directions(self) -> Array:
        """(k, 3) unit vectors of the world along which points of the links can move: two for a planar linkage, else three."""

    def turning_axes(self, joint: int = 0) -> Array:
        """(k, 3) unit vectors about which links can turn, in the frame of a Pinocchio joint (0: the world): the plane's normal for a planar
        linkage, else three."""

    # ----------------------------------------------------------------------------------------------------------------- equations

    def close(self, angle: Array, guess: Array, with_margins: bool = False) -> Closure:
        """Close the loops of a linkage with one driver at crank angles (n,) from guesses (nv, n). It never raises: the caller judges gap
        and margins."""

    def closing_function(self) -> CloseDrivers:
        """A function that closes the loops at positions of all drivers, for many calls."""

    def rates(self, position: Array, speed: Array, acceleration: Array) -> JointRates:
        """Joint rates and accelerations at closed positions (nv, n), from those (drivers, n) of the drivers."""

    def gaps(self, position: Array) -> Array:
        """Largest gap (n,) of a loop or relation at positions (nv, n) [m]."""

    def redundant(self, x: Array) -> bool:
        """Whether some of the equations that the engine solves are redundant at joint coordinates (nv,)."""

    def closing_order(self) -> Iterator[tuple[int, Sequence[int]]]:
        """The loops and relations in the order in which they are closed.

        Each comes as its index, relations counted after the loops, and the indices of the joints that it determines; in Pinocchio's engine,
        which closes all loops together, of the joints that stand on it.
        """

    # -------------------------------------------------------------------------------------------------------------------- motion

    def body_motion(self, states: ClosedStates, joints: Sequence[int], accelerations: bool = True) -> BodyMotion:
        """Motion of the bodies of these Pinocchio joints, of which none is the frame; with their ``accelerations`` or without."""

    # ------------------------------------------------------------------------------------------------------------------ dynamics

    def inverse_dynamics(self, states: ClosedStates, conditions: AppliedConditions, bearings: bool = True) -> Wrenches:
        """Driving torque, and the wrenches of all bearings.

        Args:
            states: closed states.
            conditions: loads, friction and compliances.
            bearings: whether to find forces and moments of the bearings, too; without them the driving torque takes less time.

        Raises:
            AssemblyError: the states leave the loops open, because they belong to another linkage.
            PinpressError: friction locks the linkage.
        """

    def bearing_loads(self, states: ClosedStates, conditions: AppliedConditions, rates: Array) -> BearingLoads:
        """Speeds and radial forces of all bearings of a linkage with one driver.

        Args:
            states: closed states.
            conditions: loads, compliances, and efforts of friction that are known; no law.
            rates: (nv, n) joint rates to which the bearings' speeds belong; those of the states count for inertia forces alone.
        """

    def idle(self, states: ClosedStates) -> Idle:
        """The idle forces of redundant equations."""

    def indeterminate(self, position: Array, axes: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """What rigid mechanics leaves open in any of the positions (nv, n); see `Reactions.indeterminate`.

        Returns (bearings, 6) which force and moment components of the bearings, along the rows of ``axes`` (3, 3), and (relations,) which
        relation torques idle forces can change.
        """


def other_linkage(crank_angle: float, gap: float, place: str) -> AssemblyError:
    """The error for states whose gap [m] is above `LOOSEST`; ``place``: where the drivers are, in words."""
    return AssemblyError("the motion leaves the loops of this linkage open: it is another one's", crank_angle, gap, 0, place)
