"""How bearings share idle forces in space, as `engines.sharing` says."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.quantities import Array
from ..sharing import lexicographic_responses


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


def share(states: NDArray[np.intp] | slice, idle: Array, objectives: Iterable[tuple[Array, float]]) -> Shared:
    """Idle multipliers (k, rows, m) of some states, shared by objectives (k, bearings, 3, m) of a scale each, see `Objective`."""
    return Shared(states, idle, lexicographic_responses((_configurations_first(each), scale) for each, scale in objectives))


def _configurations_first(vectors: Array) -> Array:
    """(m, 3 bearings, k) of vectors (k, bearings, 3, m)."""
    return vectors.transpose(3, 1, 2, 0).reshape(vectors.shape[3], -1, len(vectors))
