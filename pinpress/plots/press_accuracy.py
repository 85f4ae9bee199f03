"""Plots of what tolerances make of a press: the dimensions by their shares, and the presses of a sample."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ..common import tables
from ..common.arguments import number, typed
from ..tolerances.scatter import COVERAGE, LEAST_BEYOND, Scatter
from .style import COLOURS, GREY, THIN, above, brief, grid, panels, plain

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HIGH = 7.0  # height of the charts [cm]
MOST = 10  # dimensions with a bar of their own
BINS = 61  # classes of the presses


@typed
def tolerances(scatter: Scatter, limit: float | None = None, *, ax: Iterable[Axes] | None = None) -> Figure:
    """Draw a Pareto chart of the dimensions, and how the presses of a sample deviate from the nominal one.

    The line over the bars is their sum. Lines beside the presses are the band of 99.73 % of them, where the sample is large enough, the
    worst corners, and the limits.

    Args:
        scatter: what `pinpress.tolerances.bottom_dead_centre` returns, ``height``, ``top``, ``stroke`` or another quantity of it.
        limit: largest deviation that is allowed, in both directions [unit of the quantity]; None: not drawn.
        ax: the caller's axes, two; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, the limit is not positive, or ``ax`` are not two axes.
    """
    allowed = None if limit is None else number("limit", limit, scatter.unit, positive=True)
    with panels(ax, 2, HIGH, lambda figure: figure.subplots(1, 2, width_ratios=(1.0, 1.25))) as drawn:
        _shares(drawn.axes[0], scatter)
        _presses(drawn.axes[1], scatter, allowed)
    return drawn.figure


def _shares(axes: Axes, scatter: Scatter) -> None:
    """Bars of the dimensions with the largest shares, and of the others together; over them their sum."""
    order = np.argsort(-scatter.share, kind="stable")
    shown = order if len(order) <= MOST + 1 else order[:MOST]
    names, shares = [scatter.parts[k].name for k in shown], [100.0 * scatter.share[k] for k in shown]
    if len(shown) < len(order):
        names.append(f"{len(order) - len(shown)} others")
        shares.append(100.0 - sum(shares))
    grid(axes, "share of the variance [%]")
    places = np.arange(len(shares))
    axes.bar(places, shares, color=COLOURS[0], width=0.7)
    axes.plot(places, np.cumsum(shares), color=GREY, marker="o", markersize=2.5, clip_on=False)
    axes.set_xlim(-0.6, len(shares) - 0.4)
    axes.set_ylim(min(0.0, *shares), 100.0)
    axes.set_xticks(places, [brief(name) for name in names], rotation=60.0, ha="right", rotation_mode="anchor")
    for text in axes.get_xticklabels():
        plain(text)


def _presses(axes: Axes, scatter: Scatter, limit: float | None) -> None:
    """How many presses of the sample deviate by how much."""
    reach = float(max(np.abs(scatter.deviation).max(), np.abs(scatter.corners).max(), limit or 0.0))
    scale = tables.scale(scatter.unit, [reach])
    unit, factor = {"m": ("µm", 1e6), "m/m": ("µm/m", 1e6)}.get(scatter.unit, (scale.unit, scale.factor))
    grid(axes, "presses [%]")
    axes.yaxis.grid(False)
    weights = np.full(len(scatter.deviation), 100.0 / len(scatter.deviation))
    axes.hist(factor * scatter.deviation, bins=BINS, weights=weights, color=COLOURS[5])
    lines: list[Artist] = []
    names = []
    for name, ends, colour, look in _ends(scatter, limit):
        made = [axes.axvline(factor * end, color=colour, linestyle=look, linewidth=2 * THIN) for end in ends]
        lines.append(made[0])
        names.append(name)
    axes.margins(y=0.1)
    axes.set_xlim(-1.08 * factor * reach, 1.08 * factor * reach)
    plain(axes.set_xlabel(f"deviation of {scatter.quantity} [{unit}]"))
    above(axes, lines, names)


def _ends(scatter: Scatter, limit: float | None) -> list[tuple[str, tuple[float, ...], str, str]]:
    """Name, places, colour and kind of the lines beside the presses."""
    found: list[tuple[str, tuple[float, ...], str, str]] = []
    if 0.5 * (1.0 - COVERAGE) * len(scatter.deviation) >= LEAST_BEYOND:
        found.append((f"{100 * COVERAGE:g} %", scatter.band(COVERAGE), COLOURS[0], "-"))
    found.append(("worst corners", tuple(map(float, scatter.corners)), GREY, "--"))
    if limit is not None:
        found.append((f"limits: {100 * scatter.within(limit):.4g} %", (-limit, limit), COLOURS[1], "-"))
    return found
