"""Sections of a report for results beside the motion and its reactions."""

from __future__ import annotations

from collections.abc import Sequence

from ...common.errors import PinpressError, shown
from ...common.results import Tabular
from ...linkage.linkage import OfPress
from ...ratings.rating import PressRatings
from .blocks import Section
from .drawn import section
from .shown import Shown, refuse_others


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
    raise PinpressError(f"results: a report has no section for {shown(result)}; give results that have some, as ratings, runs or budgets")
