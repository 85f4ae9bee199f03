"""Planar presses with one driver, with many sets of lengths at once.

The rows of a `Plane` are linear in the pivots, C(x) = C + sum x_k C'_k. Every set of deviations x_k has separate rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...common.products import product
from ...common.quantities import Array, ComplexArray
from ...derivatives.motion import Displacements, Rates, Shift, States, Tangent, guide_shift, planar, shift
from ...engines.planar.closing import NO_SLIPS, Slopes
from ...engines.planar.equations import Equations, nonzero
from ...engines.planar.functions import Functions
from ...engines.planar.kinematics import basis_acceleration, basis_at
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
        shifts: changes of the rows per unit of each dimension.
        places: (m, 2) indices of the entries of `Plane.gap_rows` that change.
        slopes: (m, k) derivatives of these entries by the dimensions.
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
            PinpressError: a dimension leads out of the press's plane.
        """
        plane, guide = planar(press), press.slide_guide.joint
        shifts = [shift(press, plane, displacements) for displacements in moved]
        changes = np.array([by.gap_rows for by in shifts])
        places = np.argwhere(changes.any(axis=0))
        guide_slopes = np.array([guide_shift(plane, by, guide) for by in shifts])
        slopes = changes[:, places[:, 0], places[:, 1]].T
        return PlanarShapes(press, guide_slopes, plane.tolerance, plane, tuple(shifts), places, slopes)

    def added(self, deviations: Array) -> ComplexArray:
        return product(self.slopes, deviations)

    def evaluated(self, x: Array, added: ComplexArray) -> Evaluated:
        plane = self.plane
        basis = basis_at(plane, x)
        gaps = self._opened(basis, added)
        slips = plane.relation_slopes @ x - plane.offsets[:, None] if len(plane.offsets) else NO_SLIPS
        gap = np.maximum(np.abs(gaps).max(axis=0, initial=0.0), np.abs(slips).max(axis=0, initial=0.0))
        slopes = Slopes.at(self._equations(added), basis, x)
        first = slopes.drive()
        turning = self._opened(basis_acceleration(plane, basis, first, None), added)
        second = slopes.solve([*turning, *[None] * len(plane.offsets)])
        return Evaluated(gap, slopes.solve([*gaps, *slips]), first, second)

    def _opened(self, basis: ComplexArray, added: ComplexArray) -> ComplexArray:
        """The gaps (loops, n) of every set at a basis (nb, n), or their changes by its derivatives; ``added``: (m, n) to the entries that
        change."""
        rows = np.array(product(self.plane.gap_rows, basis))
        for (row, column), values in zip(self.places, added, strict=True):
            rows[row] += values * basis[column]
        return rows

    def _equations(self, added: ComplexArray) -> Equations:
        """The equations of every set."""
        coefficients = [dict(gap) for gap in self._nominal]
        order = self._structure.functions.order
        for (loop, place), values in zip(self.places.tolist(), added, strict=True):
            if place:  # a pivot that moves on the frame moves no coordinate
                coefficients[loop][order[place]] = coefficients[loop][order[place]] + values
        return self._structure.with_coefficients(coefficients)

    @cached_property
    def _nominal(self) -> list[dict[int, ComplexArray]]:
        """By loop the nominal coefficients of all functions whose coefficients are not zero in every set."""
        functions = Functions(self.plane)
        coefficients = [nonzero(functions, gap) for gap in self.plane.gap_rows]
        for loop, place in self.places.tolist():
            if place:
                coefficients[loop].setdefault(functions.order[place], np.array(0j))
        return coefficients

    @cached_property
    def _structure(self) -> Equations:
        """The equations of the nominal press, with all functions that move a gap of any set."""
        return Equations.of(self.plane, self._nominal)

    def joint_slopes(self, start: Array) -> tuple[Array, Array]:
        states = States.of(self.plane, start[:, None])
        return np.stack([states.slope(by)[:, 0] for by in self.shifts], axis=1), states.slopes.drive()

    def slide_slopes(self, position: Array, v: Array) -> tuple[Array, Array]:
        states = States.of(self.plane, position[:, None])
        rates = Rates.of(states, v[:, None], np.zeros((len(v), 1)))
        tangents = [Tangent.of(states, rates, by) for by in self.shifts]
        guide, _, sign = self.press.slide_guide
        by_position = sign * (np.array([tangent.position[guide, 0] for tangent in tangents]) + self.guide_slopes)
        return by_position, sign * np.array([tangent.v[guide, 0] for tangent in tangents])
