"""A quantity of a press that scatters with its dimensions: what each of them adds, the worst case, and its values in a sample."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..common import tables
from ..common.arguments import number, suitable_numbers
from ..common.errors import PinpressError
from ..common.quantities import Array, ShownUnit
from ..common.results import Tabular
from ..common.tables import Column
from .dimensions import Dimension

COVERAGE = 0.9973  # share of the presses in the band that is shown: that of +/- 3 standard deviations of a normal quantity
COVERAGES = (COVERAGE, 0.95, 0.5)
LEAST_BEYOND = 5  # presses beyond each end of a band, below which its ends are chance
ROUNDING = 1e-9
DECIDES = 0.8  # share of the variance that the dimensions named first in a text make together


@dataclass(frozen=True, eq=False, repr=False)
class Scatter(Tabular):
    """A quantity of a press with k dimensions that scatter, in a sample of n presses. All arrays are read-only.

    Attributes:
        quantity: what it is, in words.
        unit: of the quantity.
        nominal: its value with nominal dimensions.
        parts: the k dimensions.
        gradient: (k,) its derivatives by the dimensions, to first order [unit per m, of an angle per rad].
        share: (k,) of the variance, to first order. They sum to 1; those of correlated dimensions can be negative.
        first_order_sd: standard deviation to first order.
        worst_case: largest deviation to first order, with all dimensions at the worst end of their tolerances: sum of abs(gradient) x
            tolerance.
        corners: (2,) deviations of the two presses with all dimensions at these ends, as they are: down and up.
        deviation: (n,) of every press of the sample from ``nominal``.
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

    @property
    def mean(self) -> float:
        """Mean deviation of the sample."""
        return float(self.deviation.mean())

    @property
    def sd(self) -> float:
        """Standard deviation of the sample."""
        return float(self.deviation.std(ddof=1))

    def band(self, coverage: float = COVERAGE) -> tuple[float, float]:
        """The deviations between which this share of the presses lies, with as many below as above them: quantiles of the sample, which
        need no normal distribution.

        Raises:
            PinpressError: a coverage that is not between 0 and 1, or one that leaves fewer than 5 presses of the sample at each end.
        """
        share = float(suitable_numbers("coverage", coverage, "a number between 0 and 1", suits=lambda found: (found > 0) & (found < 1)))
        beyond = 0.5 * (1.0 - share) * len(self.deviation)
        if beyond < LEAST_BEYOND:
            needed = math.ceil(round(2 * LEAST_BEYOND / (1.0 - share), 6))
            raise PinpressError(
                f"a band of {100 * share:g} % leaves {beyond:.2g} of {len(self.deviation)} presses at each end, which is chance: give"
                f" samples={needed} or more, or a smaller coverage"
            )
        low, high = np.quantile(self.deviation, [0.5 * (1.0 - share), 0.5 * (1.0 + share)])
        return float(low), float(high)

    def within(self, limit: float, upper: float | None = None) -> float:
        """The yield: share of the presses that deviate by at most ``limit``; with ``upper`` by ``limit`` at least and ``upper`` at most.

        Raises:
            PinpressError: a limit that is negative, or an upper one that is not above it.
        """
        first = number("limit", limit, self.unit, positive=upper is None)
        low, high = (-first, first) if upper is None else (first, number("upper", upper, self.unit))
        if not high > low:
            raise PinpressError(f"upper is {high:g} {self.unit}, not above the limit of {low:g} {self.unit}: exchange them")
        return float(np.mean((self.deviation >= low) & (self.deviation <= high)))

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

    def __str__(self) -> str:
        return "\n".join([self.title, *self.summary()[1:], *self.ranking()])

    def summary(self) -> list[str]:
        """Lines with nominal value, band and worst case."""
        scale = scale_of(self)
        low, high = (scale.shown(corner) for corner in self.corners)
        lines = [f"  {'nominal':22}{tables.cell(self.nominal)} {self.unit}"]
        if coverage := widest_coverage(self):
            ends = " to ".join(scale.shown(end) for end in self.band(coverage))
            lines.append(f"  {f'{100 * coverage:g} % of presses':22}{ends} {scale.unit}")
        spread = f"{scale.shown(self.sd)} {scale.unit} (first order {scale.shown(self.first_order_sd)})"
        return [*lines, f"  {'standard deviation':22}{spread}", f"  {'worst corners':22}{low} and {high} {scale.unit}"]

    def ranking(self) -> list[str]:
        """Lines of all dimensions, those with the largest shares first, and what decides."""
        order = np.argsort(-self.share, kind="stable")
        rows = [["dimension", "tolerance", "gradient", "share"]]
        rows += [
            [self.parts[k].name, written_tolerance(self.parts[k]), tables.cell(float(self.gradient[k])), f"{100 * self.share[k]:.1f} %"]
            for k in order
        ]
        return [*tables.fitted(rows), f"  {self.decided}"]

    @property
    def decided(self) -> str:
        """The dimensions that make most of the variance, in words, and what half of their tolerances brings."""
        if not self.first_order_sd:
            return "no dimension changes it to first order"
        order = np.argsort(-self.share, kind="stable")
        count = 1 + int(np.argmax(np.cumsum(self.share[order]) >= DECIDES - ROUNDING))
        first = [int(k) for k in order[:count]]
        names = ", ".join(self.parts[k].name for k in first)
        made = float(self.share[first].sum())
        left = math.sqrt(max(1.0 - 0.75 * made, 0.0))  # half the tolerance is a quarter of the variance
        verb = "makes" if count == 1 else "make"
        return f"{names} {verb} {100 * made:.0f} % of the variance: half as wide, the standard deviation falls to {100 * left:.0f} %"


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
    """A `Scatter` from the values (n,) of a sample and those (2,) of both corners; ``correlation``: (k, k) coefficients."""
    part = gradient * np.array([each.standard_deviation for each in parts])
    by_dimension = part * (correlation @ part)
    variance = float(by_dimension.sum())
    share = by_dimension / variance if variance > 0.0 else np.zeros(len(parts))
    worst = float(np.abs(gradient) @ np.array([each.tolerance for each in parts]))
    return Scatter(
        quantity, unit, nominal, tuple(parts), gradient, share, math.sqrt(max(variance, 0.0)), worst, corners - nominal, values - nominal
    )


def widest_coverage(found: Scatter) -> float | None:
    """The share of presses whose band is shown: 99.73 % where the sample is large enough, else less; None of a very small one."""
    beyond = 0.5 * len(found.deviation)
    return next((coverage for coverage in COVERAGES if (1.0 - coverage) * beyond >= LEAST_BEYOND), None)


def written_tolerance(part: Dimension) -> str:
    """The tolerance of a dimension in the units of a drawing."""
    return f"{1e3 * part.tolerance:.4g} mm" if part.unit == "m" else f"{math.degrees(part.tolerance):.4g} deg"


def scale_of(found: Scatter) -> ShownUnit:
    """How deviations are written: lengths in um, slopes in um/m."""
    largest = max(float(np.abs(found.deviation).max()), float(np.abs(found.corners).max()))
    if found.unit == "m":
        return ShownUnit("um", 1e6, 1 if largest >= 1e-6 else 4, 0.0)
    if found.unit == "m/m":
        return ShownUnit("um/m", 1e6, 2, 0.0)
    return tables.scale(found.unit, [largest])
