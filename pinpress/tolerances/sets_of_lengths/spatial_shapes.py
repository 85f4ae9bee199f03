"""Presses in space, and presses with several drivers, with many sets of lengths at once.

The gaps of the loops and their Jacobian J are linear in the displacements of pivots, because these do not turn a body. So the explicit
derivatives by a dimension are differences, exact within rounding error. A dimension opens the gaps by g' per unit. At fixed drivers the
joint coordinates change by J x' = -g', and the rates v by J v' = -(J' v + H(x', v)). H is the second derivative of the gaps. Its quadratic
form H(v, v) is the loops' drift (`engines.spatial.equations.drift`): H(x', v) = (H(v + x', v + x') - H(v - x', v - x')) / 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...common.errors import PinpressError
from ...common.quantities import Array
from ...derivatives.motion import CONTRADICTED, Displacements
from ...engines.spatial.bodies import motion_axes
from ...engines.spatial.closing import PassiveColumns
from ...engines.spatial.equations import Equations, Loops, Moved, build_loops, drift, equations
from ...linkage.linkage import Linkage
from .shapes import Evaluated, Shapes


@dataclass(frozen=True)
class SpatialShapes(Shapes):
    """A press, planar or not, with one driver or several, whose pivots can be moved by k dimensions.

    Attributes:
        press: the press.
        guide_slopes: see `Shapes`.
        tolerance: see `Shapes`.
        loops: constants of the nominal linkage.
        joints: (nv, 3, k) displacements of joints per unit of the dimensions, in the frames of the bodies that carry them.
        ends: (2, nl, 3, k) displacements of the ends of loops per unit of the dimensions, in the same frames.
    """

    press: Linkage
    guide_slopes: Array
    tolerance: float
    loops: Loops
    joints: Array
    ends: Array

    @staticmethod
    def of(press: Linkage, moved: Sequence[Displacements]) -> SpatialShapes:
        """The press with dimensions that displace its pivots by ``moved`` per unit."""
        joints = np.stack([by.joints for by in moved], axis=-1)
        ends = np.stack([by.ends.swapaxes(0, 1) for by in moved], axis=-1)
        guide = press.slide_guide
        along = press.model.jointPlacements[guide.joint + 1].rotation @ press.axes[guide.joint].direction
        loops = build_loops(press.structure)
        return SpatialShapes(press, along @ joints[guide.joint], press.structure.tolerance, loops, joints, ends)

    def added(self, deviations: Array) -> Moved:
        return Moved(self.joints @ deviations, self.ends @ deviations)

    def evaluated(self, x: Array, added: Moved) -> Evaluated:
        system = equations(self.loops, x, added)
        gap = system.widest()
        system.entries[:, ~(np.isfinite(gap) & np.isfinite(system.entries).all(axis=0))] = 0.0
        passive = PassiveColumns(self.loops, system.entries)
        first = self._by_crank(system, passive)
        second = passive.rates(-drift(self.loops, system, motion_axes(self.loops.bodies, system.placed), first))
        return Evaluated(gap, passive.rates(-system.gaps), first, second)

    def joint_slopes(self, start: Array) -> tuple[Array, Array]:
        system, moved = self._at(start)
        passive = PassiveColumns(self.loops, system.entries)
        return passive.rates(system.gaps - moved.gaps), self._by_crank(system, passive)[:, :1]

    def slide_slopes(self, position: Array, v: Array) -> tuple[Array, Array]:
        loops, rates = self.loops, v[:, None]
        system, moved = self._at(position)
        passive, opened = PassiveColumns(loops, system.entries), moved.gaps - system.gaps
        still = passive.rates(-opened)
        left = np.abs(opened + _driven(loops, system.entries, still)).max(axis=0)
        sizes = np.maximum(np.abs(self.joints).max(axis=(0, 1)), np.abs(self.ends).max(axis=(0, 1, 2), initial=0.0))
        if np.any(left > CONTRADICTED * sizes):
            raise PinpressError(
                f"redundant bearings of {self.press.name} do not stay closed if a dimension deviates: move the pivots of all of them"
                " equally, in the plane of a planar press; for separate points of a slide use tolerances.parallelism"
            )
        opening = _driven(loops, moved.entries - system.entries, rates)
        axes = motion_axes(loops.bodies, system.placed)
        curved = 0.25 * (drift(loops, system, axes, rates + still) - drift(loops, system, axes, rates - still))
        velocity = passive.rates(-(opening + curved))
        guide, _, sign = self.press.slide_guide
        return sign * (still[guide] + self.guide_slopes), sign * velocity[guide]

    def _at(self, position: Array) -> tuple[Equations, Equations]:
        """The equations at joint coordinates (nv,) for each dimension: with nominal lengths, and with its unit displacements."""
        x = np.repeat(position[:, None], self.joints.shape[-1], axis=1)
        return equations(self.loops, x), equations(self.loops, x, Moved(self.joints, self.ends))

    def _by_crank(self, system: Equations, passive: PassiveColumns) -> Array:
        """(nv, n) derivative of the joint coordinates by the crank angle; zero with several drivers."""
        if len(self.press.drivers) > 1:
            return np.zeros((len(self.press.joints), passive.n))
        first = passive.rates(-system.driving[:, 0])
        first[self.press.driver_indices[0]] = 1.0
        return first


def _driven(loops: Loops, entries: Array, rates: Array) -> Array:
    """Rates (rows, n) of the gaps at joint rates (nv, n), by the Jacobian's entries (ne + 1, n)."""
    rows, joints = loops.entries
    result = np.zeros((loops.rows, entries.shape[1]))
    np.add.at(result, rows, entries[:-1] * rates[joints])
    return result
