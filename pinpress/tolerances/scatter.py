"""A quantity of a press that scatters with its dimensions: the shares of the dimensions, the worst case, and a sample."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..common import tables
from ..common.arguments import number, suitable_numbers
from ..common.errors import PinpressError
from ..common.quantities import Array, ShownUnit
from ..common.results import Tabular
from ..common.tables import Column
from .dimensions import Dimension

COVERAGE = 0.9973  # share of the presses in a printed band: +/- 3 standard deviations of a normal quantity
LEAST_BEYOND = 5  # least number of presses outside each end of a band: with fewer its ends are random


@dataclass(frozen=True, eq=False, repr=False)
class Scatter(Tabular):
    """A quantity of a press with k dimensions that scatter, in a sample of n presses. All arrays are read-only.

    Attributes:
        quantity: name of the quantity.
        unit: unit of the quantity.
        nominal: value with nominal dimensions.
        parts: the k dimensions.
        gradient: (k,) derivatives of the quantity by the dimensions, to first order [unit per m, of an angle per rad].
        share: (k,) shares of the dimensions in the variance, to first order [-]. They sum to 1; correlated dimensions can have negative
            shares.
        first_order_sd: standard deviation to first order.
        worst_case: largest deviation to first order, with all dimensions at an end of their tolerances: sum of abs(gradient) x tolerance.
        corners: (2,) exact deviations, lower and upper, of the two presses with all dimensions at these ends.
        deviation: (n,) deviation of every press of the sample from ``nominal``.
        limit: largest deviation that is allowed, for pictures and texts [unit of the quantity]; None for none, see `with_limit`.
    """

    quantity: str
    unit: str
    nominal: float
    parts: tuple[Dimension, ...]
    gradient: Array
    share: Array
    first_order_sd: float
    worst_case: float
    corners: Array
    deviation: Array
    limit: float | None = None

    @property
    def mean(self) -> float:
        """Mean deviation of the sample."""
        return float(self.deviation.mean())

    @property
    def sd(self) -> float:
        """Standard deviation of the sample."""
        return float(self.deviation.std(ddof=1))

    def band(self, coverage: float = COVERAGE) -> tuple[float, float]:
        """The deviations between which this share of the presses lies, with equal numbers of presses below and above.

        They are quantiles of the sample, which do not assume a normal distribution.

        Raises:
            PinpressError: coverage is not between 0 and 1, or fewer than 5 presses of the sample are outside each end.
        """
        share = float(suitable_numbers("coverage", coverage, "a number between 0 and 1", suits=lambda given: (given > 0) & (given < 1)))
        beyond = 0.5 * (1.0 - share) * len(self.deviation)
        if beyond < LEAST_BEYOND:
            needed = math.ceil(round(2 * LEAST_BEYOND / (1.0 - share), 6))
            raise PinpressError(
                f"a band of {100 * share:g} % leaves {beyond:.2g} of {len(self.deviation)} presses at each end, too few for a reliable end:"
                f" give samples={needed} or more, or a smaller coverage"
            )
        low, high = np.quantile(self.deviation, [0.5 * (1.0 - share), 0.5 * (1.0 + share)])
        return float(low), float(high)

    def within(self, limit: float, upper: float | None = None) -> float:
        """The yield: share of the presses that deviate by at most ``limit``; with ``upper``, share of the deviations from ``limit`` to
        ``upper``.

        Raises:
            PinpressError: limit is negative, or upper is not above limit.
        """
        first = number("limit", limit, self.unit, positive=upper is None)
        low, high = (-first, first) if upper is None else (first, number("upper", upper, self.unit))
        if not high > low:
            raise PinpressError(f"upper is {high:g} {self.unit}, not above the limit of {low:g} {self.unit}: exchange them")
        return float(np.mean((self.deviation >= low) & (self.deviation <= high)))

    def with_limit(self, limit: float) -> Scatter:
        """The same scatter next to the largest deviation that is allowed in both directions [unit of the quantity]: pictures and texts show
        the limits, and the share of the presses that keep them.

        Raises:
            PinpressError: limit is not positive.
        """
        return replace(self, limit=number("limit", limit, self.unit, positive=True))

    @property
    def title(self) -> str:
        scale = scale_of(self)
        scatter = f"standard deviation {scale.shown(self.sd)} {scale.unit} in {len(self.deviation)} presses"
        return f"Scatter of {self.quantity}: {tables.cell(self.nominal)} {self.unit}, {scatter}"

    def columns(self) -> dict[str, Column]:
        """The dimensions with tolerance, gradient and share as (k,) columns."""
        return {
            "dimension": [part.name for part in self.parts],
            "tolerance": np.array([part.tolerance for part in self.parts]),
            "tolerance_unit": [part.unit for part in self.parts],
            f"gradient [{self.unit} per unit]": self.gradient,
            "share": self.share,
        }

    @property
    def decided(self) -> str:
        """A sentence on the dimensions that together cause 80 % of the variance, and on the effect of halving their tolerances."""
        if not self.first_order_sd:
            return "no dimension changes it to first order"
        order = np.argsort(-self.share, kind="stable")
        first = order[: 1 + int(np.argmax(np.cumsum(self.share[order]) >= 0.8 - 1e-9))].tolist()
        names = ", ".join(self.parts[k].name for k in first)
        share = float(self.share[first].sum())
        halved = math.sqrt(max(1.0 - 0.75 * share, 0.0))  # half the tolerance is a quarter of the variance
        verb = "makes" if len(first) == 1 else "make"
        return f"{names} {verb} {100 * share:.0f} % of the variance: half as wide, the standard deviation falls to {100 * halved:.0f} %"


def scatter(
    quantity: str,
    unit: str,
    nominal: float,
    parts: Sequence[Dimension],
    gradient: Array,
    correlation: Array,
    values: Array,
    corners: Array,
) -> Scatter:
    """A `Scatter` from values (n,) of a sample and values (2,) of both corners; ``correlation``: (k, k) coefficients."""
    alone = gradient * np.array([part.standard_deviation for part in parts])
    by_dimension = alone * (correlation @ alone)
    variance = float(by_dimension.sum())
    share = by_dimension / variance if variance > 0.0 else np.zeros(len(parts))
    worst, sd = float(np.abs(gradient) @ np.array([part.tolerance for part in parts])), math.sqrt(max(variance, 0.0))
    return Scatter(quantity, unit, nominal, tuple(parts), gradient, share, sd, worst, corners - nominal, values - nominal)


def widest_coverage(found: Scatter) -> float | None:
    """The share of presses for the printed band: 99.73 %, less for a small sample, None for a very small sample."""
    beyond = 0.5 * len(found.deviation)
    return next((coverage for coverage in (COVERAGE, 0.95, 0.5) if (1.0 - coverage) * beyond >= LEAST_BEYOND), None)


def scale_of(found: Scatter) -> ShownUnit:
    """The unit in which deviations are written: um for lengths, um/m for slopes."""
    largest = max(float(np.abs(found.deviation).max()), float(np.abs(found.corners).max()))
    if found.unit == "m":
        return ShownUnit("um", 1e6, 1 if largest >= 1e-6 else 4, 0.0)
    if found.unit == "m/m":
        return ShownUnit("um/m", 1e6, 2, 0.0)
    return tables.scale(found.unit, [largest])
