"""Charts of a motion and its reactions, drawn from the data of `visual.charts`, with its signs and axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..common.arguments import typed
from ..common.errors import PinpressError
from ..common.quantities import Array
from ..dynamics.extremes import AXES
from ..dynamics.harmonics import HarmonicAnalysis, harmonics
from ..dynamics.inverse_dynamics import Reactions
from ..kinematics.motion import Motion
from ..visual import charts
from ..visual.charts import Chart, Curve
from .loci import draw_loci
from .style import COLOURS, GREY, SMALL, Over, above, draw, drawing, grid, legend, plain

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SAME = 1e-6  # of the largest value: curves that differ by less are drawn as one
INTERPOLATED = 1e-6  # of the largest value: a smaller mean is an error of interpolation
ROW = 0.45  # height of a row of a legend [cm]
MOST_ABOVE = 4  # names of curves in a legend of one line above the axes
BEFORE, PALE, AFTER = GREY, "#b0b0b0", COLOURS[0]


@typed
def slide(motion: Motion) -> Figure:
    """Draw position, velocity and acceleration of the slide, and the speed of the crank where it is not constant.

    Args:
        motion: Result of `cycle`, `simulate` or `steady_state`.

    Raises:
        PinpressError: the linkage has no slide, a value is not finite, or Matplotlib is not installed.
    """
    shown = [*charts.slide(motion)]
    if not shown:
        raise PinpressError(f"{motion.linkage} has no slide: name a link that the frame guides, load(..., slide=...)")
    speed = charts.crank_speed(motion)
    return _stacked(motion, shown if speed is None else [*shown, speed], 4.2)


@typed
def torque(reactions: Reactions) -> Figure:
    """Draw the driving torque of every driver, and for a run also the torque of its drive.

    Args:
        reactions: Result of `inverse_dynamics`.

    Raises:
        PinpressError: a value is not finite, or Matplotlib is not installed.
    """
    return _stacked(reactions.motion, [charts.torque(reactions)], 6.0)


@typed
def bearings(reactions: Reactions) -> Figure:
    """Draw the magnitudes of all bearing and guide forces, and of the moments in bearings and guides that hold one.

    Curves that coincide are drawn once, under both names.

    Args:
        reactions: Result of `inverse_dynamics`, with all bearings.

    Raises:
        PinpressError: a value is not finite, or Matplotlib is not installed.
    """
    moments = charts.bearing_moment(reactions)
    shown = [_merged(chart) for chart in (charts.bearing(reactions), moments) if chart is not None]
    return _stacked(reactions.motion, shown, 7.5, 4.5)


@typed
def polar(reactions: Reactions, *bearings: str) -> Figure:
    """Draw polar diagrams of bearing forces.

    A diagram shows the path of the force vector's tip in world axes (solid) and in axes that turn with the link on which the force acts
    (dashed), with dots at every quarter turn of the crank in the last period. Circles are lines of constant force.

    Args:
        reactions: Result of `inverse_dynamics`.
        *bearings: Names of bearings and guides; by default all.

    Raises:
        UnknownNameError: There is no such bearing.
        PinpressError: A value is not finite, or Matplotlib is not installed.
    """
    names = bearings or reactions._press.bearings
    return draw_loci(reactions.motion, [charts.locus(reactions, name) for name in names])


@typed
def shaking(reactions: Reactions) -> Figure:
    """Draw the components of the shaking force in world axes, and the amplitudes of its harmonics in the last full period.

    Args:
        reactions: Result of `inverse_dynamics`. Without a full period there are no harmonics.

    Raises:
        PinpressError: a value is not finite, or Matplotlib is not installed.
    """
    motion, chart = reactions.motion, charts.shaking(reactions)
    found = harmonics(motion, reactions.shaking_force)
    if found is None or len(found.orders) < 2:
        return _stacked(motion, [chart], 6.0)
    with drawing(12.0) as figure:
        top, bottom = figure.subplots(2, 1, height_ratios=(1.2, 1.0))
        _panel(top, Over(motion), chart)
        _amplitudes(bottom, chart, found)
        figure.align_ylabels()
    return figure


@typed
def comparison(before: Reactions, after: Reactions) -> Figure:
    """Draw the reactions of two presses, or of two operating points of one press, over each other.

    It shows driving torque, shaking force, and the peaks of the forces in the bearings that both have, each with its change in percent.

    Args:
        before: Reactions drawn dashed.
        after: Reactions drawn solid.

    Raises:
        PinpressError: They have no bearing of one name, one motion is over the crank angle and the other over time, they turn in different
            directions, or Matplotlib is not installed.
    """
    peaks = _pairs(charts.bearing(before), charts.bearing(after))
    if not peaks:
        raise PinpressError(f"{before.motion.linkage} and {after.motion.linkage} have no bearing of one name: there is nothing to compare")
    overs = Over(before.motion), Over(after.motion)
    kinds = [over.abscissa.quantity for over in overs]
    if _backwards(overs[0]) != _backwards(overs[1]):
        raise PinpressError("one motion turns forwards, the other backwards: compare two that turn the same way")
    if kinds[0] != kinds[1]:
        raise PinpressError(f"one motion is drawn over {kinds[0]}, the other over {kinds[1]}: compare two cycles, or two runs")
    pairs = _torques(before, after) + _shaking(before, after)
    rows = (len(pairs) + 1) // 2
    high = 0.62 * len(peaks) + 1.2
    with drawing(1.2 + 4.8 * rows + high) as figure:
        places = figure.add_gridspec(rows + 1, 2, height_ratios=[4.8] * rows + [high])
        lines = []
        for k, pair in enumerate(pairs):
            wide = k == 0 and len(pairs) % 2 == 1  # the first of an odd number takes a whole row
            place = k + len(pairs) % 2
            axes = figure.add_subplot(places[0, :] if wide else places[place // 2, place % 2])
            lines = _compare(axes, overs, pair, wide)
        _bars(figure.add_subplot(places[rows, :]), peaks)
        names = [f"before: {before.motion.linkage}", f"after: {after.motion.linkage}"]
        legend(figure, lines, names, loc="outside upper center", ncols=2)
    return figure


def _amplitudes(axes: Axes, chart: Chart, found: HarmonicAnalysis) -> None:
    """Bars of the harmonics' amplitudes of a chart's components, side by side; the legend names their means."""
    factor = charts.factor(chart.quantity, chart.unit)
    apart = float(found.orders[1])
    width, bars, names = 0.8 * apart / len(chart.curves), [], []
    for i, curve in enumerate(chart.curves):
        axis = AXES.index(curve.name)
        place = found.orders[1:] + (i - 0.5 * (len(chart.curves) - 1)) * width
        bars.append(axes.bar(place, factor * found.amplitude[1:, axis], width, color=COLOURS[i]).patches[0])
        mean = factor * found.amplitude[0, axis]
        negligible = abs(mean) < INTERPOLATED * np.abs(curve.values).max()
        names.append(f"{curve.name} (mean {_number(0.0 if negligible else mean)} {chart.unit})")
    grid(axes, f"amplitude [{chart.unit}]")
    axes.grid(False, axis="x")
    axes.set_xlim(0.4 * apart, found.orders[-1] + 0.6 * apart)
    axes.set_xticks(np.arange(1.0, found.orders[-1] + 1.0) if found.orders[-1] >= 1 else found.orders[1:])
    axes.set_xlabel("order of the crank's speed")
    above(axes, bars, names)


def _backwards(over: Over) -> bool:
    return bool(over.x[-1] < over.x[0])


def _stacked(motion: Motion, shown: Sequence[Chart], *least: float) -> Figure:
    """Charts one below the other over one abscissa, as high as their legends need.

    Args:
        motion: The motion.
        shown: The charts.
        *least: Least heights of the charts, the last one for all others [cm].
    """
    lines = [sum(1 + curve.name.count("\n") for curve in chart.curves) for chart in shown]
    heights = [max(least[min(i, len(least) - 1)], 0.5 + ROW * count) for i, count in enumerate(lines)]
    with drawing(1.0 + sum(heights)) as figure:
        over = Over(motion)
        column = figure.subplots(len(shown), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
        for axes, chart in zip(column, shown, strict=True):
            _panel(axes, over, chart)
        for axes in column[:-1]:
            axes.set_xlabel("")
        figure.align_ylabels()
    return figure


def _panel(axes: Axes, over: Over, chart: Chart) -> None:
    grid(axes, f"{_words(chart)} [{chart.unit}]")
    lines, names = draw(axes, over, chart.curves), [curve.name for curve in chart.curves]
    over.label(axes)
    if len(names) == 1 and f" {chart.title.lower()}".endswith(f" {names[0]}"):
        return  # the axis names the only curve
    if len(names) <= MOST_ABOVE:
        above(axes, lines, names)
    else:
        legend(axes, lines, names, loc="upper left", bbox_to_anchor=(1.0, 1.02), borderaxespad=0.3)


def _words(chart: Chart) -> str:
    """Label of the vertical axis."""
    return {"Bearing forces": "bearing force", "Moments in bearings and guides": "moment held"}.get(chart.title, chart.title.lower())


def _merged(chart: Chart) -> Chart:
    """The chart with coinciding curves as one, under both names, as for the two halves of a symmetric press."""
    least = SAME * max(float(np.abs(curve.values).max()) for curve in chart.curves)
    merged: list[Curve] = []
    for curve in chart.curves:
        twin = next((k for k, other in enumerate(merged) if np.abs(curve.values - other.values).max() <= least), None)
        if twin is None:
            merged.append(curve)
        else:
            merged[twin] = replace(merged[twin], name=f"{merged[twin].name},\n{curve.name}")
    return replace(chart, curves=tuple(merged))


class _Pair(NamedTuple):
    """One quantity before and after, (n,) and (m,), in one unit."""

    title: str
    quantity: str
    unit: str
    before: Array
    after: Array


def _torques(before: Reactions, after: Reactions) -> list[_Pair]:
    """Driving torques of the drivers that both have."""
    first, second = (_without_drive(reactions) for reactions in (before, after))
    several = len(first.curves) > 1
    return [pair._replace(title=f"{first.title} {pair.title}" if several else first.title) for pair in _pairs(first, second)]


def _without_drive(reactions: Reactions) -> Chart:
    chart = charts.torque(reactions)
    return replace(chart, curves=chart.curves[: len(reactions.motion.drivers)])


def _shaking(before: Reactions, after: Reactions) -> list[_Pair]:
    """Components of the shaking force; a component that only one press has is zero in the other."""
    pair = charts.shaking(before), charts.shaking(after)
    names = sorted({curve.name for chart in pair for curve in chart.curves if curve.values.any()}) or list(AXES)
    first, second = (_with_components(chart, names) for chart in pair)
    return [pair._replace(title=f"{first.title} {pair.title}") for pair in _pairs(first, second)]


def _with_components(chart: Chart, names: Sequence[str]) -> Chart:
    known = {curve.name: curve.values for curve in chart.curves}
    zero = np.zeros_like(chart.curves[0].values)
    return replace(chart, curves=tuple(Curve(name, known.get(name, zero)) for name in names))


def _pairs(before: Chart, after: Chart) -> list[_Pair]:
    """Curves of one name, in the larger of the charts' units."""
    quantity = before.quantity
    unit = min(before.unit, after.unit, key=lambda unit: charts.factor(quantity, unit))
    scale = [charts.factor(quantity, unit) / charts.factor(quantity, chart.unit) for chart in (before, after)]
    known = {curve.name: curve.values for curve in after.curves}
    common = [curve for curve in before.curves if curve.name in known]
    return [_Pair(curve.name, quantity, unit, scale[0] * curve.values, scale[1] * known[curve.name]) for curve in common]


def _compare(axes: Axes, overs: tuple[Over, Over], pair: _Pair, wide: bool) -> list[Artist]:
    grid(axes, f"{pair.quantity} [{pair.unit}]")
    old = axes.plot(overs[0].x, overs[0].along(pair.before), color=BEFORE, linestyle=(0, (4, 1.5)))
    new = axes.plot(overs[1].x, overs[1].along(pair.after), color=AFTER)
    max(overs, key=lambda over: float(np.ptp(over.x))).label(axes, wide)
    plain(axes.set_title(f"{pair.title}, range {_change(np.ptp(pair.before), np.ptp(pair.after))}", loc="left"))
    return [*old, *new]


def _bars(axes: Axes, peaks: Sequence[_Pair]) -> None:
    """Peaks of the bearings' forces, with their changes."""
    rows = np.arange(len(peaks), dtype=float)
    sizes = np.array([(pair.before.max(), pair.after.max()) for pair in peaks])
    grid(axes, "")
    axes.grid(False, axis="y")
    axes.barh(rows - 0.19, sizes[:, 0], 0.34, color=PALE, linewidth=0)
    axes.barh(rows + 0.19, sizes[:, 1], 0.34, color=AFTER, linewidth=0)
    for row, (old, new) in zip(rows, sizes, strict=True):
        plain(axes.annotate(_change(old, new), (max(old, new), row), (4, 0), textcoords="offset points", va="center", fontsize=SMALL))
    axes.set_yticks(rows)
    for text in axes.set_yticklabels([pair.title for pair in peaks]):
        text.set_parse_math(False)
    axes.set_ylim(len(peaks) - 0.4, -0.6)  # the first at the top
    axes.set_xlim(0.0, 1.12 * float(sizes.max()) or 1.0)
    axes.set_xlabel(f"peak bearing force [{peaks[0].unit}]")


def _change(before: float, after: float) -> str:
    """The change of a size in percent, or in words where it was zero before."""
    if before == 0.0:
        return "0 as before" if after == 0.0 else "0 before"
    change = round(100 * (after / before - 1), 1) + 0.0  # no "-0.0"
    return f"{change:+.1f} %".replace("-", "−") if change else "±0.0 %"


def _number(value: float) -> str:
    """A number with three figures and a typographic minus sign."""
    return f"{value + 0.0:.3g}".replace("-", "−")
