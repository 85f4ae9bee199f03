"""Sections of a report for results beside the motion and its reactions, by their class."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ...common.errors import PinpressError, shown
from ...common.results import Tabular
from ...linkage.linkage import OfPress
from ...ratings.rating import PressRatings
from ...tolerances.accuracy_budget import AccuracyBudget
from ...tolerances.allocation import AllocatedTolerances
from ...tolerances.clearances import SlidePlay
from ...tolerances.clearances_over_speed import DeadCentresInClearances
from ...tolerances.dead_centre_scatter import DeadCentreScatter
from ...tolerances.points import SlideParallelism
from ...tolerances.temperatures import HeatShift
from . import tolerances
from .blocks import Section
from .drawn import section
from .shown import Shown, refuse_others

MAKERS: Mapping[type[Tabular], Callable[[Any, Shown], Section]] = {
    DeadCentreScatter: tolerances.dead_centres,
    AllocatedTolerances: tolerances.allocated,
    SlidePlay: tolerances.play,
    DeadCentresInClearances: tolerances.over_speeds,
    HeatShift: tolerances.heat,
    AccuracyBudget: tolerances.budget,
    SlideParallelism: tolerances.parallelism,
}


def ratings_among(results: Sequence[Tabular]) -> PressRatings | None:
    """The ratings whose permissible force stands beside the process force; the first, where there are several."""
    return next((result for result in results if isinstance(result, PressRatings)), None)


def sections_of(result: Tabular, page: Shown) -> list[Section]:
    """The sections of a result.

    Raises:
        PinpressError: It has none, or is of another press.
    """
    if isinstance(result, OfPress):
        refuse_others(type(result).__name__, result._press, page)
    if described := result.described(page.reactions):
        return [section(part, page) for part in described]
    make = next((make for kind, make in MAKERS.items() if isinstance(result, kind)), None)
    if make is None:
        known = ", ".join(kind.__name__ for kind in MAKERS)
        raise PinpressError(f"results: a report has no section for {shown(result)}; give any of {known}")
    return [make(result, page)]
