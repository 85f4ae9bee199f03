"""Plots of balancing: trade-offs between criteria."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..balancing.optimum import TradeOffCurve
from ..balancing.problem import AddedMass, Target
from ..common.arguments import typed
from ..common.errors import PinpressError
from .style import COLOURS, GREY, drawing, grid, legend, panel_places, plain

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HIGH = 6.5  # height of a panel [cm]


@typed
def trade_offs(curves: Mapping[str, TradeOffCurve]) -> Figure:
    """Draw curves of `trade_off`, the first criterion over the second, with a panel for each pair of criteria.

    A grey cross marks the press before balancing.

    Args:
        curves: results of `pinpress.balancing.trade_off`, by the names of the curves.

    Raises:
        PinpressError: Matplotlib is not installed, or there is no curve.
    """
    if not isinstance(curves, Mapping) or not curves or not all(isinstance(curve, TradeOffCurve) for curve in curves.values()):
        raise PinpressError("there is no curve to draw: give what trade_off returns, under a name")
    panels: dict[tuple[Target, Target], dict[str, TradeOffCurve]] = {}
    for name, curve in curves.items():
        panels.setdefault((curve.first, curve.second), {})[name] = curve
    rows = (len(panels) + 1) // 2
    with drawing(HIGH * rows) as figure:
        places = figure.add_gridspec(rows, 2 if len(panels) > 1 else 1)
        for place, shown in zip(panel_places(places, len(panels)), panels.values(), strict=True):
            _panel(figure.add_subplot(place), shown)
    return figure


def _panel(axes: Axes, curves: Mapping[str, TradeOffCurve]) -> None:
    some = next(iter(curves.values()))
    (across, x_label), (up, y_label) = _scaled(some.second), _scaled(some.first)
    lines: list[Artist] = []
    for i, curve in enumerate(curves.values()):
        y, x = curve.values.T
        lines += axes.plot(across * x, up * y, color=COLOURS[i % len(COLOURS)], marker="o", markersize=2.5)
    grid(axes, y_label)
    plain(axes.set_xlabel(x_label))
    x, y = across * _before(some, some.second), up * _before(some, some.first)
    axes.plot([x], [y], color=GREY, marker="x", markersize=5.0, linestyle="none")
    axes.margins(x=0.04)
    if len(curves) > 1:
        legend(axes, lines, list(curves), loc="best")


def _before(curve: TradeOffCurve, target: Target) -> float:
    if isinstance(target, AddedMass):
        return 0.0
    return next(change.before for change in curve.designs[0].changes if change.criterion == target)


def _scaled(target: Target) -> tuple[float, str]:
    """Factor and label of an axis."""
    if isinstance(target, AddedMass):
        return 1.0, f"{target.words} [kg]"
    return 1e-3, f"{target.words} [k{target.unit}]"
