"""A press with many sets of lengths at once: what Newton's method needs of all of them together.

`planar_shapes` has planar presses with one driver, `spatial_shapes` all others; `endings` follows the sets to where their slides end.
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
        step: (nv, n) that closes them.
        first: (nv, n) derivative of the joint coordinates by the crank angle; zero where there are several drivers.
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
        guide_slopes: (k,) by how much each dimension moves the slide's guide along itself, which no joint coordinate shows.
        tolerance: gap at which a loop is closed to rounding [m].
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
        """What deviations (k, n) add to the equations of every set, for `evaluated`."""

    @abstractmethod
    def evaluated(self, x: Array, added: Any) -> Evaluated:
        """The loop equations of sets at joint coordinates (nv, n)."""

    @abstractmethod
    def joint_slopes(self, start: Array) -> tuple[Array, Array]:
        """Derivatives of joint coordinates (nv,) that close the nominal press: (nv, k) by the dimensions with the drivers at rest, and
        (nv, 1) by the crank angle, zero where there are several drivers."""

    @abstractmethod
    def slide_slopes(self, position: Array, v: Array) -> tuple[Array, Array]:
        """Derivatives (k,) of the slide's position and of its velocity by the dimensions, at joint coordinates (nv,) that close the nominal
        press and joint rates (nv,) that keep it closed. The drivers keep place and speed.

        Raises:
            PinpressError: a dimension opens bearings that hold each other.
        """
