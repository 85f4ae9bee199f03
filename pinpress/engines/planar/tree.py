"""Sums along a deep tree, joint by joint, so that time grows with the joints and not with the square of their number.

In a long row of links every joint is moved by all joints before it, and carries all links behind it: a matrix of these sums has half as
many entries as the square of the joints. Where few joints hang on each other the matrices (`Plane.turn`, `Bodies.open_tree`) are faster.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ...common.quantities import Array
from ..joints import product
from .model import Plane


def sum_outwards(plane: Plane, values: Any) -> None:
    """Add to the row of every joint in ``values`` (nv, n) those of all joints between it and the frame."""
    _add(list(values), plane.hanging)


def sum_inwards(plane: Plane, values: Any) -> None:
    """Add to the row of every joint in ``values`` (nv, n) those of all joints that it carries."""
    _add(list(values), ((parent, joint) for joint, parent in reversed(plane.hanging)))


def _add(rows: list[Any], steps: Iterable[tuple[int, int]]) -> None:
    for to, by in steps:
        rows[to] += rows[by]


def absolute_turns(plane: Plane, x: Array) -> Array:
    """Absolute angles (nr, n) of the rotors at joint coordinates (nv, n), or their rates; see `Plane.turn`."""
    if not plane.deep:
        return np.asarray(product(plane.turn, x))
    angles = plane.sense[:, None] * x
    sum_outwards(plane, angles)
    return angles[list(plane.revolute)]


def turning_efforts(plane: Plane, moments: Array) -> Array:
    """Efforts (nv, n) of the joints about their axes that moments (nr, n) on the rotors ask for; 0 of joints that slide."""
    if not plane.deep:
        return np.asarray(plane.turn.T.dot(moments))
    efforts = np.zeros((len(plane.parents), moments.shape[1]))
    efforts[list(plane.revolute)] = moments
    sum_inwards(plane, efforts)
    efforts *= plane.sense[:, None]
    return efforts
