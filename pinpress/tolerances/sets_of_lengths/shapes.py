"""A press with many sets of lengths at once: the interface for Newton's method.

`planar_shapes` has planar presses with one driver, `spatial_shapes` has all other presses. `endings` follows the sets to dead centres and
heights.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

import numpy as np

from ...common.products import product
from ...common.quantities import Array
from ...linkage.linkage import Linkage


class Evaluated(NamedTuple):
    """The loop equations of sets at joint coordinates (nv, n).

    Attributes:
        gap: (n,) largest gap of a loop or coupling [m].
        step: (nv, n) change of the joint coordinates that closes the gaps.
        first: (nv, n) derivative of the joint coordinates by the crank angle; zero with several drivers.
        second: (nv, n) second derivative.
    """

    gap: Array
    step: Array
    first: Array
    second: Array


class Shapes(ABC):
    """A press whose pivots can be moved by k dimensions.

    Attributes:
        press: the press.
        guide_slopes: (k,) motion of the slide's guide along itself per unit of each dimension, which no joint coordinate includes.
        tolerance: gap at which a loop counts as closed [m].
    """

    press: Linkage
    guide_slopes: Array
    tolerance: float

    def position(self, joint_position: Array, deviations: Array) -> Array:
        """Slide position (n,) at joint coordinates (nv, n) of sets with deviations (k, n) [m]."""
        guide, offset, sign = self.press.slide_guide
        return np.asarray(sign * (joint_position[guide] + product(self.guide_slopes, deviations)) + offset)

    @abstractmethod
    def added(self, deviations: Array) -> Any:
        """Changes of the equations of every set by deviations (k, n), for `evaluated`."""

    @abstractmethod
    def evaluated(self, x: Array, added: Any) -> Evaluated:
        """The loop equations of sets at joint coordinates (nv, n)."""

    @abstractmethod
    def joint_slopes(self, start: Array) -> tuple[Array, Array]:
        """Derivatives of joint coordinates (nv,) that close the nominal press: (nv, k) by the dimensions with drivers at rest, and (nv, 1)
        by the crank angle, zero with several drivers."""

    @abstractmethod
    def slide_slopes(self, position: Array, v: Array) -> tuple[Array, Array]:
        """Derivatives (k,) of the slide's position and velocity by the dimensions, at joint coordinates (nv,) and rates (nv,) of the closed
        nominal press. The drivers keep their positions and speeds.

        Raises:
            PinpressError: a dimension opens redundant bearings.
        """
