"""What an engine computes of a linkage. Every engine offers the same; `Linkage.engine` chooses one.

Positions, rates and accelerations are (nv, n): a row a joint, in the order of v, a column a state.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..common.quantities import Array, ComplexArray
from .forces import AppliedConditions, AppliedForce, Wrenches

PIECE = 2048  # crank angles worked through at a time: what is in flight stays in the cache
ACCEPTED = 1e3  # times the tolerance of rounding: a loop whose gap is not below that is open


@dataclass(frozen=True, eq=False, repr=False)
class Closure:
    """Closed configurations and their first-order and second-order influence coefficients.

    Attributes:
        position: (nv, n) joint coordinates [rad or m].
        first: (nv, n) d position / d crank angle.
        second: (nv, n) d2 position / d crank angle2.
        gap: (n,) largest distance between the two sides of a loop [m]; large or not finite where Newton's method failed.
        widest: the largest gap [m].
        iterations: Newton steps taken.
        margins: (blocks, n) distance of every block of loops from singularity: the smallest singular value of its Jacobian, columns scaled
            to unit length, with the sign of its determinant (the Pinocchio engine has one block, and no sign). Zero where two assemblies
            meet. None unless asked for.
        basis: of the planar engine, see `planar.model`; None from the other.
    """

    position: Array
    first: Array
    second: Array
    gap: Array
    widest: float
    iterations: int
    margins: Array | None = None
    basis: ComplexArray | None = None


def joined(pieces: Sequence[Closure]) -> Closure:
    """One closure from those of consecutive crank angles; margins are left out."""

    def along(name: str) -> Array:
        return np.concatenate([getattr(piece, name) for piece in pieces], axis=-1)

    return Closure(
        position=along("position"),
        first=along("first"),
        second=along("second"),
        gap=along("gap"),
        widest=max(piece.widest for piece in pieces),
        iterations=max(piece.iterations for piece in pieces),
        basis=None if pieces[0].basis is None else np.concatenate([p.basis for p in pieces if p.basis is not None], axis=1),
    )


Close = Callable[[Array, Array], Closure]
"""(crank angles (n,), guesses (nv, n)) -> Closure with its margins. Never raises; the caller judges gap and margins."""
CloseDrivers = Callable[[Array, Array, Array], Closure]
"""(positions (drivers, n), rates (drivers,) to which influence coefficients belong, guesses (nv, n)) -> Closure with its margins. Never
raises; the caller judges gap and margins."""


class ClosedStates(NamedTuple):
    """Closed states of a linkage, n of them.

    Attributes:
        position: (nv, n) joint coordinates [rad or m].
        v: (nv, n) joint rates [rad/s or m/s].
        a: (nv, n) joint accelerations [rad/s2 or m/s2].
        basis: (nb, n) what the planar engine knows of these positions from closing them, see `planar.model`; None where it did not.
    """

    position: Array
    v: Array
    a: Array
    basis: ComplexArray | None = None

    def part(self, points: slice) -> ClosedStates:
        """Some of the states."""
        return ClosedStates(
            self.position[:, points], self.v[:, points], self.a[:, points], None if self.basis is None else self.basis[:, points]
        )


class EnergyRates(NamedTuple):
    """Energies of the states of a motion.

    Attributes:
        kinetic: (n,) of all links [J].
        potential: (n,) of their weights, zero with all centres of mass at the world origin [J].
        lifting: (n,) rate of the potential energy [W].
    """

    kinetic: Array
    potential: Array
    lifting: Array


class PowerBalance(NamedTuple):
    """Power of the loads less the rate of kinetic and potential energy, and what it is small beside.

    Attributes:
        balance: (n,) [W].
        total: (n,) sum of the absolute powers [W].
        apparent: (n,) sum of the powers that there would be were all forces along the velocities [W].
    """

    balance: Array
    total: Array
    apparent: Array


class Engine(Protocol):
    """How a linkage is computed."""

    @property
    def name(self) -> str:
        """ "plane" or "pinocchio"."""

    @property
    def tolerance(self) -> float:
        """Gap at which a loop is closed to rounding [m]."""

    @property
    def directions(self) -> Array:
        """(k, 3) unit vectors of the world along which points of the links can move: two in a plane, else three."""

    def turning_axes(self, joint: int = 0) -> Array:
        """(k, 3) unit vectors about which links can turn, in the frame of a Pinocchio joint (0: the world): the normal of a plane, else
        three."""

    # ----------------------------------------------------------------------------------------------------------------- equations

    def close(self, angle: Array, guess: Array, with_margins: bool = False) -> Closure:
        """Close the loops of a linkage with one driver at crank angles (n,) from guesses (nv, n). Never raises; the caller judges."""

    def closer(self) -> CloseDrivers:
        """A function that closes the loops at positions of all drivers, for many calls."""

    def rates(self, position: Array, speed: Array, acceleration: Array) -> tuple[Array, Array, Array]:
        """Joint rates and accelerations (nv, n) at closed positions (nv, n), from those (drivers, n) of the drivers, and the gaps (n,)."""

    def gaps(self, position: Array) -> Array:
        """Largest gap (n,) of a loop or coupling at positions (nv, n) [m]."""

    def redundant(self, x: Array) -> bool:
        """Whether equations that the engine solves say nothing new at joint coordinates (nv,)."""

    def closing_order(self) -> Iterator[tuple[int, Sequence[int]]]:
        """Indices of loops, then couplings, in the order in which they are closed, each with the joints that it determines (of a linkage in
        space: with those of its loop)."""

    # -------------------------------------------------------------------------------------------------------------------- motion

    def point_motion(self, states: ClosedStates, joint: int, point: Array) -> tuple[Array, Array]:
        """World position [m] and velocity [m/s], (n, 3) each, of a point (3,) fixed to the body of a Pinocchio joint."""

    def point_accelerations(self, states: ClosedStates, joint: int, points: Array) -> tuple[Array, Array]:
        """World positions [m] and accelerations [m/s2], (p, n, 3) each, of points (p, 3) fixed to the body of a Pinocchio joint."""

    # ------------------------------------------------------------------------------------------------------------------ dynamics

    def inverse_dynamics(self, states: ClosedStates, under: AppliedConditions, wanted: Sequence[int]) -> Wrenches:
        """Driving torque, and the wrenches of the bearings ``wanted``, rising.

        Raises:
            AssemblyError: the states leave the loops open: they are those of another linkage.
            PinpressError: friction locks the linkage.
        """

    def indeterminate(self, position: Array, axes: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Components of bearings (bearings, 6) along ``axes`` (3, 3), its rows, and torques of couplings (couplings,), that idle forces
        reach in any of the positions (nv, n); see `Reactions.indeterminate`."""

    def power_balance(self, states: ClosedStates, loads: Sequence[AppliedForce]) -> PowerBalance:
        """The power balance of loads and links, found apart from inverse dynamics."""

    def energies(self, states: ClosedStates) -> EnergyRates:
        """Kinetic and potential energy."""
