"""Any linkage, one configuration at a time, by Pinocchio's constraint models and recursive Newton-Euler algorithm.

The general path, and the judge of the planar one: loops in space, any number of drivers, more equations than are needed. The rank of the
equations is found from singular values; forces that rigid mechanics does not decide are shared as `load_sharing` says.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ...common.arrays import Array
from ..joints import Axis, Coupling, LoopJoint, Slot, axes, between, slots
from .constraints import Equations, crossed, extent


@dataclass(frozen=True, eq=False, repr=False)
class Spatial:
    """Constants of a linkage for this engine.

    Attributes:
        model: the Pinocchio model.
        loops, couplings: in declared order.
        drivers: indices of the driver joints in v.
        passive: of all others.
        round_loops: of every loop the joints round it, +1 / -1 where its end 2 / 1 hangs on them.
        size: length of the linkage [m].
        tolerance: gap at which a loop is closed to rounding [m].
        slots, axes: of the joints.
    """

    model: pin.Model
    loops: tuple[LoopJoint, ...]
    couplings: tuple[Coupling, ...]
    drivers: tuple[int, ...]
    passive: tuple[int, ...]
    round_loops: tuple[Mapping[int, float], ...]
    size: float
    tolerance: float
    slots: tuple[Slot, ...]
    axes: tuple[Axis, ...]

    @cached_property
    def on_loop(self) -> NDArray[np.bool_]:
        """(nv,) whether a joint is on a loop."""
        found = np.zeros(self.model.nv, dtype=bool)
        found[[joint for joints in self.round_loops for joint in joints]] = True
        return found

    @cached_property
    def crossed(self) -> Array:
        """(nv, nl) ``round_loops`` as a matrix."""
        return crossed(self.model, self.loops)

    @cached_property
    def share(self) -> Array:
        """(3 bearings, 3 nl) what loop forces add to the forces of all joints and loops."""
        return np.concatenate([-np.kron(self.crossed, np.eye(3)), np.eye(3 * len(self.loops))])

    def equations(self) -> Equations:
        """The equations of loops and couplings, for use within one call."""
        return Equations(self.model, self.loops, self.couplings, self.size)


def build(model: pin.Model, loops: tuple[LoopJoint, ...], couplings: tuple[Coupling, ...], drivers: tuple[int, ...]) -> Spatial:
    """Constants of a linkage."""
    size, reach = extent(model, loops)
    parents = [int(parent) - 1 for parent in list(model.parents)[1:]]
    return Spatial(
        model=model,
        loops=loops,
        couplings=couplings,
        drivers=drivers,
        passive=tuple(j for j in range(model.nv) if j not in drivers),
        round_loops=tuple(between(parents, loop.joint1 - 1, loop.joint2 - 1) for loop in loops),
        size=size,
        tolerance=8 * float(np.finfo(float).eps) * (size + reach),
        slots=slots(model),
        axes=axes(model),
    )
