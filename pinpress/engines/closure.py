"""Closed configurations of a linkage, as an engine returns them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..common.arrays import Array, ComplexArray

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
