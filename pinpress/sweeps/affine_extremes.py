"""Largest values over many states of quantities that are affine in two parameters, at every point of a grid of these, exactly.

With the square W of the speed and the amplitude F of the load a torque, or a vector of force, in state k is f_k = a_k W + c_k + d_k F. Its
largest value over the states, or largest length, is wanted at (n, m) points (W, F). The grid is cut into tiles. Most states are the largest
nowhere in a tile, and can be left out for good reason:

- Let u be a unit vector. The length of f_k less u . f_j is convex in (W, F), a length of something affine less something affine. So where
  it is not positive at the four corners of a tile, it is so all over it, and |f_k| <= u . f_j <= |f_j|: state j leaves state k out.
- Of scalars, u is 1 and the length the value itself: the same with nothing lost.

Of a few hundred states few are left in a tile, and are compared at all of its points.
"""

import itertools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.arrays import Array

TILES = 16  # along either axis: fewer leave more states over, more take longer to cut
LEAST = 24  # points of a tile along either axis


class Affine(NamedTuple):
    """A quantity of s states with k components: a W + c + d F, all (k, s). A scalar has one component, and its sign counts."""

    a: Array
    c: Array
    d: Array


def largest(quantity: Affine, squares: Array, forces: Array, lengths: bool, states: bool) -> tuple[Array, NDArray[np.intp] | None]:
    """Largest value (n, m) over the states, or largest length of a vector, and a state that has it.

    Args:
        quantity: of which the largest value is wanted.
        squares: W (n,), rising.
        forces: F (m,), rising.
        lengths: the quantity is a vector, and its length is wanted.
        states: the states are wanted too, which takes as long again; else None stands for them.
    """
    rows, columns = _cuts(len(squares)), _cuts(len(forces))
    kept = _left_over(quantity, squares[_corners(rows)], forces[_corners(columns)], lengths)
    best = np.empty((len(squares), len(forces)))
    state = np.empty(best.shape, dtype=np.intp) if states else None
    for i in range(len(rows) - 1):
        for j in range(len(columns) - 1):
            here = slice(rows[i], rows[i + 1]), slice(columns[j], columns[j + 1])
            _compare(
                quantity,
                np.flatnonzero(kept[i, j]),
                squares[here[0]],
                forces[here[1]],
                lengths,
                best[here],
                None if state is None else state[here],
            )
    return np.sqrt(best, out=best) if lengths else best, state


def _cuts(count: int) -> list[int]:
    """Where the tiles along an axis begin, and the end."""
    tiles = max(1, min(TILES, count // LEAST))
    return [round(k * count / tiles) for k in range(tiles + 1)]


def _corners(cuts: list[int]) -> NDArray[np.intp]:
    """First and last point of every tile along an axis (tiles, 2)."""
    return np.array([[start, end - 1] for start, end in itertools.pairwise(cuts)])


def _left_over(quantity: Affine, squares: Array, forces: Array, lengths: bool) -> NDArray[np.bool_]:
    """(rows, columns, s) whether a state may be the largest somewhere in a tile, whose corners are at ``squares`` (rows, 2) and ``forces``
    (columns, 2)."""
    kept = np.empty((len(squares), len(forces), quantity.a.shape[1]), dtype=np.bool_)
    for i, along in enumerate(squares):
        # (k, columns, 5, s): the four corners, then the middle
        w = np.array([along[0], along[0], along[1], along[1], along.mean()])
        f = np.concatenate([forces, forces, forces.mean(axis=1, keepdims=True)], axis=1)
        at = quantity.a[:, None, None] * w[:, None] + quantity.c[:, None, None] + quantity.d[:, None, None] * f[:, :, None]
        size = np.sqrt(np.einsum("kjcs,kjcs->jcs", at, at)) if lengths else at[0]
        judges = size.argmax(axis=2)  # (columns, 5)
        out = np.zeros((len(forces), at.shape[3]), dtype=np.bool_)
        for judge in judges.T[::-1]:
            of = np.take_along_axis(at, judge[None, :, None, None], axis=3)[..., 0]  # (k, columns, 5)
            if lengths:
                middle = of[:, :, 4]
                length = np.linalg.norm(middle, axis=0)
                pointing = middle / np.where(length > 0, length, 1.0)
                lower = np.einsum("kj,kjc->jc", pointing, of[:, :, :4])
            else:
                lower = of[0, :, :4]
            out |= (size[:, :4] <= lower[:, :, None]).all(axis=1)
        np.put_along_axis(out, judges, False, axis=1)  # those that judge are compared
        kept[i] = ~out
    return kept


def _compare(
    quantity: Affine,
    states: NDArray[np.intp],
    squares: Array,
    forces: Array,
    lengths: bool,
    best: Array,
    state: NDArray[np.intp] | None,
) -> None:
    """Write the largest values of some states (their squares, of lengths) at the points of a tile, and which states have them."""
    turned = quantity.a[:, states, None] * squares + quantity.c[:, states, None]  # (k, states, n)
    loaded = quantity.d[:, states, None] * forces  # (k, states, m)
    value, other = np.empty(best.shape), np.empty(best.shape)
    for number, here in enumerate(states):
        np.add(turned[0, number, :, None], loaded[0, number], out=value)
        if lengths:
            np.multiply(value, value, out=value)
            for k in range(1, len(turned)):
                np.add(turned[k, number, :, None], loaded[k, number], out=other)
                np.multiply(other, other, out=other)
                np.add(value, other, out=value)
        if number == 0:
            best[...] = value
            if state is not None:
                state[...] = here
        else:
            if state is not None:
                np.copyto(state, here, where=value > best)
            np.maximum(best, value, out=best)
