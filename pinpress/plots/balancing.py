"""Plots of balancing: trade-offs between criteria."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from ..balancing.optimum import TradeOffCurve
from ..balancing.problem import AddedMass, Target
from ..balancing.result import before_balancing
from ..common.arguments import typed
from ..common.errors import PinpressError
from .style import COLOURS, GREY, grid, legend, panel_places, panels, plain

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HIGH = 6.5  # height of a panel [cm]


@typed
def trade_offs(curves: Mapping[str, TradeOffCurve], *, ax: Axes | Iterable[Axes] | None = None) -> Figure:
    """Draw curves of `trade_off`, the first criterion over the second, with a panel for each pair of criteria.

    A grey cross marks the press before balancing. Of several operating conditions the worst is drawn.

    Args:
        curves: results of `pinpress.balancing.trade_off`, by the names of the curves.
        ax: the caller's axes, one for each pair of criteria; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, there is no curve, or ``ax`` are not as many axes as charts.
    """
    if not isinstance(curves, Mapping) or not curves or not all(isinstance(curve, TradeOffCurve) for curve in curves.values()):
        raise PinpressError("there is no curve to draw: give what trade_off returns, under a name")
    pairs: dict[tuple[Target, Target], dict[str, TradeOffCurve]] = {}
    for name, curve in curves.items():
        pairs.setdefault((curve.first, curve.second), {})[name] = curve
    rows = (len(pairs) + 1) // 2

    def laid_out(figure: Figure) -> list[Axes]:
        places = figure.add_gridspec(rows, 2 if len(pairs) > 1 else 1)
        return [figure.add_subplot(place) for place in panel_places(places, len(pairs))]

    with panels(ax, len(pairs), HIGH * rows, laid_out) as drawn:
        for axes, shown in zip(drawn.axes, pairs.values(), strict=True):
            _panel(axes, shown)
    return drawn.figure


def _panel(axes: Axes, curves: Mapping[str, TradeOffCurve]) -> None:
    some = next(iter(curves.values()))
    (across, x_label), (up, y_label) = _scaled(some.second), _scaled(some.first)
    lines: list[Artist] = []
    for i, curve in enumerate(curves.values()):
        y, x = curve.values.T
        lines += axes.plot(across * x, up * y, color=COLOURS[i % len(COLOURS)], marker="o", markersize=2.5)
    grid(axes, y_label)
    plain(axes.set_xlabel(x_label))
    x, y = (factor * before_balancing(some.designs[0], target) for factor, target in ((across, some.second), (up, some.first)))
    axes.plot([x], [y], color=GREY, marker="x", markersize=5.0, linestyle="none")
    axes.margins(x=0.04)
    if len(curves) > 1:
        legend(axes, lines, list(curves), loc="best")


def _scaled(target: Target) -> tuple[float, str]:
    """Factor and label of an axis."""
    if isinstance(target, AddedMass):
        return 1.0, f"{target.words} [kg]"
    return 1e-3, f"{target.words} [k{target.unit}]"
