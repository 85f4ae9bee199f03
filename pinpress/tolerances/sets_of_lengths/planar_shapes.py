"""Planar presses with one driver, with many sets of lengths at once.

The rows of a `Plane` follow the pivots in proportion, C(x) = C + sum x_k C'_k. Every set of deviations x_k has rows of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...common import products
from ...common.products import product
from ...common.quantities import Array, ComplexArray
from ...derivatives.motion import Displacements, Rates, Shift, States, Tangent, guide_shift, planar, shift
from ...engines.planar.kinematics import NO_SLIPS, basis_acceleration, basis_at, drive, factored, solve
from ...engines.planar.model import Plane
from ...linkage.linkage import Linkage
from .shapes import Evaluated, Shapes


@dataclass(frozen=True)
class PlanarShapes(Shapes):
    """A planar press with one driver whose pivots can be moved by k dimensions.

    Attributes:
        press: the press.
        guide_slopes: see `Shapes`.
        tolerance: see `Shapes`.
        plane: constants of the nominal linkage.
        shifts: what each dimension adds to the rows, per unit of it.
        places: (m, 2) the entries of `Plane.closure` that change.
        slopes: (m, k) their derivatives by the dimensions.
    """

    press: Linkage
    guide_slopes: Array
    tolerance: float
    plane: Plane
    shifts: tuple[Shift, ...]
    places: NDArray[np.intp]
    slopes: ComplexArray

    @staticmethod
    def of(press: Linkage, moved: Sequence[Displacements]) -> PlanarShapes:
        """The press with dimensions that displace its pivots by ``moved`` per unit.

        Raises:
            PinpressError: a dimension leads out of its plane.
        """
        plane, guide = planar(press), press.slide_guide.joint
        shifts = [shift(press, plane, each) for each in moved]
        changes = np.array([each.closure for each in shifts])
        places = np.argwhere(changes.any(axis=0))
        guide_slopes = np.array([guide_shift(plane, each, guide) for each in shifts])
        slopes = changes[:, places[:, 0], places[:, 1]].T
        return PlanarShapes(press, guide_slopes, plane.tolerance, plane, tuple(shifts), places, slopes)

    def added(self, deviations: Array) -> ComplexArray:
        return products.product(self.slopes, deviations)

    def evaluated(self, x: Array, added: ComplexArray) -> Evaluated:
        plane = self.plane
        loops = len(plane.loop_points)
        basis = basis_at(plane, x)
        rows = self._rows(basis, added, len(plane.closure))
        slips = plane.coupled @ x - plane.offsets[:, None] if len(plane.offsets) else NO_SLIPS
        gap = np.abs(rows[:loops]).max(axis=0, initial=0.0)
        if len(slips):
            gap = np.maximum(gap, np.abs(slips).max(axis=0))
        factors = factored(plane, rows)
        step, second = np.zeros_like(x), np.zeros_like(x)
        first = np.empty_like(x)
        solve(plane, rows, factors, [*rows[:loops], *slips], step)
        drive(plane, rows, factors, first)
        turning = self._rows(basis_acceleration(plane, basis, first, None), added, loops)
        solve(plane, rows, factors, [*turning, *[None] * len(plane.offsets)], second)
        return Evaluated(gap, step, first, second)

    def _rows(self, basis: ComplexArray, added: ComplexArray, count: int) -> ComplexArray:
        """The first ``count`` rows of every set's closure at a basis (nb, n); ``added``: (m, n) to the entries that change."""
        rows = np.array(product(self.plane.closure[:count], basis))
        for (row, column), values in zip(self.places, added, strict=True):
            if row < count:
                rows[row] += values * basis[column]
        return rows

    def joint_slopes(self, start: Array) -> tuple[Array, Array]:
        states = States.of(self.plane, start[:, None])
        first = np.empty((len(start), 1))
        drive(self.plane, states.rows, states.factors, first)
        return np.stack([states.slope(each)[:, 0] for each in self.shifts], axis=1), first

    def slide_slopes(self, position: Array, v: Array) -> tuple[Array, Array]:
        states, rest = States.of(self.plane, position[:, None]), np.zeros((len(v), 1))
        rates = Rates.of(states, v[:, None], rest)
        tangents = [Tangent.of(states, rates, each) for each in self.shifts]
        guide, _, sign = self.press.slide_guide
        by_position = sign * (np.array([each.position[guide, 0] for each in tangents]) + self.guide_slopes)
        return by_position, sign * np.array([each.v[guide, 0] for each in tangents])
