"""Plots of the accuracy of a slide: its place in the clearances over the turn, and the parts of its bottom dead centre."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..common.arguments import typed
from ..tolerances.accuracy_budget import NEGLIGIBLE, PARTS, AccuracyBudget
from ..tolerances.clearances import SlidePlay
from .style import COLOURS, GREY, LINES, THIN, Over, grid, legend, panels, plain

if TYPE_CHECKING:
    from collections.abc import Iterable

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HIGH = 6.0  # height of a chart [cm]
ROOM = 1.35  # height of the chart of conditions beside that of its bars, for the names above them


@typed
def play(found: SlidePlay, *, ax: Iterable[Axes] | None = None) -> Figure:
    """Draw where the slide stands in its clearances over the motion, with the band where bearings are undetermined and a dot for each
    force that reverses, and below it the share of each bearing.

    Args:
        found: result of `pinpress.tolerances.play`.
        ax: the caller's axes, two; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, or ``ax`` are not two axes.
    """
    over = Over(found.motion)
    first = found.motion.driver_coordinates[0]
    with panels(ax, 2, 2 * HIGH, lambda figure: figure.subplots(2, 1, sharex=True)) as drawn:
        top, bottom = drawn.axes
        grid(top, "slide in its clearances [mm]")
        grid(bottom, "share of a bearing [mm]")
        top.fill_between(over.x, over.along(1e3 * found.lowest), over.along(1e3 * found.highest), color=COLOURS[5], alpha=0.5, linewidth=0)
        top.plot(over.x, over.along(1e3 * found.offset), color=COLOURS[0])
        at = first.scale * np.array([each.crank_angle for each in found.reversals])
        places = np.interp(at, over.x, over.along(1e3 * found.offset)) if over.x[-1] > over.x[0] else np.array([])
        if len(places):
            top.plot(at, places, "o", markersize=3, color="black")
        lines: list[Artist] = []
        for i, share in enumerate(found.by_bearing.values()):
            lines += bottom.plot(
                over.x, over.along(1e3 * share), color=COLOURS[i % len(COLOURS)], linestyle=LINES[i // len(COLOURS) % len(LINES)]
            )
        over.label(bottom)
        legend(bottom, lines, list(found.by_bearing), loc="upper center", ncols=min(len(lines), 7), columnspacing=0.8)
        low, high = bottom.get_ylim()
        bottom.set_ylim(low, high + 0.25 * (high - low))  # room for the names
        drawn.align_labels()
    return drawn.figure


@typed
def budget(found: AccuracyBudget, *, ax: Axes | None = None) -> Figure:
    """Draw the bottom dead centre of a press in every condition: shares stacked as bars, and their sum as a dot with its band.

    Args:
        found: result of `pinpress.tolerances.budget`.
        ax: the caller's axes; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, or ``ax`` are no axes.
    """
    unit, size = found.coordinate.shown_speed
    count = len(found.conditions)
    with panels(ax, 1, HIGH + 0.5 * count, lambda figure: [figure.subplots()]) as drawn:
        axes = drawn.axes[0]
        grid(axes, "")
        axes.axvline(0.0, color=GREY, linewidth=THIN)
        places = np.arange(count)
        above, below = np.zeros(count), np.zeros(count)
        bars: list[Artist] = []
        names = []
        for colour, part in zip(COLOURS, PARTS, strict=False):
            values = 1e3 * np.array([getattr(each, part) for each in found.conditions])
            if np.abs(values).max() <= 1e3 * NEGLIGIBLE:
                continue
            start = np.where(values > 0, above, below)
            bars.append(axes.barh(places, values, left=start, height=0.6, color=colour, alpha=0.75)[0])
            names.append(part)
            above, below = above + np.maximum(values, 0.0), below + np.minimum(values, 0.0)
        sums = 1e3 * np.array([each.shift for each in found.conditions])
        ends = 1e3 * np.array([[each.shift - each.lowest, each.highest - each.shift] for each in found.conditions]).T
        dots = axes.errorbar(sums, places, xerr=np.maximum(ends, 0.0), fmt="o", color="black", markersize=3.5, capsize=2.5, linewidth=1.0)
        axes.set_yticks(places, [f"{each.speed / size:.4g} {unit}, {each.condition}" for each in found.conditions])
        axes.set_ylim(count - 0.5, -0.5 - ROOM)
        axes.use_sticky_edges = False  # a part of zero begins where the sum ends, which is no border
        axes.margins(x=0.05)
        plain(axes.set_xlabel("bottom dead centre [mm], positive upwards"))
        legend(axes, [*bars, dots.lines[0]], [*names, "sum with its band"], loc="upper center", ncols=len(names) + 1)
    return drawn.figure
