"""How bearings share redundant forces.

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

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import number
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.quantities import Array
from .structure import ZERO


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


def lexicographic_responses(objectives: Iterable[tuple[Array, float]], tolerance: float = ZERO) -> list[Array]:
    """How the y of `lexicographic_least_squares` follows from the starts of the objectives: it is -sum(response @ start).

    Args:
        objectives: matrices A (..., m, k) and scales, see `Objective`. The next one is asked for only where the ones before it leave
            something open.
        tolerance: `Structure.rank_tolerance`.

    Returns:
        Responses (..., k, m), of as many of the objectives as were asked for.
    """
    responses: list[Array] = []
    open_ways: Array | None = None  # (..., k, j) of y that the objectives leave open
    for matrix, scale in objectives:
        inner = matrix if open_ways is None else matrix @ open_ways
        # measured by the whole matrix: where the earlier objectives have decided all of y, every singular value is rounding
        size = np.maximum(np.linalg.norm(matrix, axis=(-2, -1)), scale)
        inverse, left_open = _by_squares(inner, size, tolerance) or _by_singular_values(inner, size, tolerance)
        step = inverse if open_ways is None else open_ways @ inverse
        responses = [earlier - step @ (matrix @ earlier) for earlier in responses] + [step]
        open_ways = left_open if open_ways is None else open_ways @ left_open
        if np.abs(open_ways).max(initial=0.0) < 1e-6:
            break
    return responses


def _by_squares(matrix: Array, size: Array, tolerance: float) -> tuple[Array, Array] | None:
    """The pseudo-inverse (..., k, m) of a matrix (..., m, k) of this size (...), and orthonormal columns (..., k, j) that it takes to zero.

    From the normal equations, which cost a fifth of singular values, where all of these are well above rounding, or each is either large or
    rounding; None if they are not, or if the columns differ in number.
    """
    turned = matrix.swapaxes(-1, -2)
    squares = turned @ matrix
    with suppress(np.linalg.LinAlgError):  # singular
        inverse = np.linalg.inv(squares)
        smallest = 1.0 / np.linalg.norm(inverse, axis=(-2, -1))  # eigenvalue, or less
        # Squares lose half of the digits: above this share of the squared size the smallest eigenvalue is certainly no rounding.
        if np.all(smallest > max(1e-7, tolerance**2) * size**2):
            inverse = inverse @ turned
            # a step of Newton's method for the inverse of a matrix brings the digits back that squares lose
            return inverse + (np.eye(squares.shape[-1]) - inverse @ matrix) @ inverse, squares[..., :0]
    values, vectors = np.linalg.eigh(squares)
    large = values > 1e-3 * (size**2)[..., None]  # with these the normal equations lose three digits at most
    count = int(large.sum(axis=-1).max(initial=0))
    rest = values.shape[-1] - count
    if not large[..., rest:].all():
        return None
    left_open = vectors[..., :rest]
    if rest and not np.all(np.linalg.norm(matrix @ left_open, axis=(-2, -1)) <= tolerance * size):
        return None
    kept = vectors[..., rest:]
    inverse = (kept / values[..., None, rest:]) @ (matrix @ kept).swapaxes(-1, -2)
    return inverse, left_open


def _by_singular_values(matrix: Array, size: Array, tolerance: float) -> tuple[Array, Array]:
    """`_by_squares` for any matrix; the columns (..., k, k) that it takes to zero span them, but are not independent."""
    left, values, right = np.linalg.svd(matrix, full_matrices=False)
    kept = values > tolerance * size[..., None]
    inverse = right.swapaxes(-1, -2) * np.where(kept, 1.0 / np.where(kept, values, 1.0), 0.0)[..., None, :] @ left.swapaxes(-1, -2)
    return inverse, np.eye(matrix.shape[-1]) - inverse @ matrix


class Shared(NamedTuple):
    """How the idle forces of m states are shared, from decompositions of what they do to all bearings.

    Attributes:
        states: which states.
        idle: (k, rows, m) multipliers that balance each other.
        responses: (m, k, 3 bearings) see `lexicographic_responses`.
    """

    states: NDArray[np.intp] | slice
    idle: Array
    responses: list[Array]

    @property
    def objectives(self) -> int:
        """How many objectives decide."""
        return len(self.responses)

    def added(self, starts: Sequence[Array]) -> Array:
        """The multipliers (rows, m) to be added where objectives (bearings, 3, n) are these without idle ones."""
        parts = zip(self.responses, starts, strict=False)
        y = np.sum([response @ _configurations_first(start[None, ..., self.states]) for response, start in parts], axis=0)
        return np.asarray(np.einsum("krm,mk->rm", self.idle, -y[:, :, 0]))


def share(states: NDArray[np.intp] | slice, idle: Array, objectives: Iterable[tuple[Array, float]], tolerance: float = ZERO) -> Shared:
    """Idle multipliers (k, rows, m) of some states, shared by objectives (k, bearings, 3, m) of a scale each, see `Objective`;
    ``tolerance``: `Structure.rank_tolerance`."""
    configurations_first = ((_configurations_first(each), scale) for each, scale in objectives)
    return Shared(states, idle, lexicographic_responses(configurations_first, tolerance))


def _configurations_first(vectors: Array) -> Array:
    """(m, 3 bearings, k) of vectors (k, bearings, 3, m)."""
    return vectors.transpose(3, 1, 2, 0).reshape(vectors.shape[3], -1, len(vectors))


def compliances(stiffness: Mapping[str, float], bearings: Sequence[str]) -> Array | None:
    """The compliances (bearings,) of bearings [m/N], zero where no stiffness is given; None if none is given at all.

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
