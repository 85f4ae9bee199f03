"""Plots of a motion and its reactions, drawn from the data of `visual.charts`, with its signs and axes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..common.arguments import typed
from ..common.errors import PinpressError
from ..common.quantities import Array
from ..dynamics.extremes import AXES, at_peaks
from ..dynamics.harmonics import HarmonicAnalysis, harmonics, last_period
from ..dynamics.reactions import Reactions
from ..kinematics.motion import Motion
from ..simulation.run import Run
from ..visual import charts
from ..visual.charts import Chart, ChartCurve, Locus
from .style import (
    CENTIMETRE,
    COLOURS,
    GREY,
    LIGHT,
    LINE,
    SMALL,
    THIN,
    WIDTH,
    Over,
    above,
    brief,
    draw,
    grid,
    legend,
    panel_places,
    panels,
    plain,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Text

SAME = 1e-6  # curves and paths that differ by less than this share of the largest value are drawn as one
INTERPOLATED = 1e-6  # a mean below this share of the largest value is an error of interpolation
ROW = 0.45  # height of a row of a legend [cm]
MOST_ABOVE = 4  # most names of curves in a legend of one line above the axes
BEFORE, PALE, AFTER = GREY, "#b0b0b0", COLOURS[0]
# Polar diagrams
FRAME, OWN = COLOURS[0], COLOURS[1]
DASHED = (0, (4, 1.5))
QUARTER = 90  # difference of marked crank angles [deg]
CLOSE = 0.12  # marks that are closer together than this share of the largest force have one label
TINY = 6.5  # size of the letters in a diagram [pt]
LETTER = 0.16  # width of one of these [cm]
LARGEST = 8.0  # longest side of a diagram [cm]


@typed
def slide(motion: Motion, *, ax: Iterable[Axes] | None = None) -> Figure:
    """Draw position, velocity and acceleration of the slide, and the speed of the crank, or of several drivers, where it is not constant.

    Args:
        motion: result of `cycle`, `simulate` or `steady_state`.
        ax: the caller's axes, three, and one more for speeds that are not constant, of drivers that turn and of those that slide; by
            default those of a new figure.

    Raises:
        PinpressError: the linkage has no slide, a value is not finite, ``ax`` are not as many axes as charts, or Matplotlib is not
            installed.
    """
    shown = [*charts.slide(motion)]
    if not shown:
        _ = motion.slide_position  # raises, as there is no slide
    return _stacked(motion, [*shown, *charts.driver_speeds(motion)], ax, 4.2)


@typed
def torque(reactions: Reactions, *, ax: Axes | Iterable[Axes] | None = None) -> Figure:
    """Draw the driving torque of every driver, and for a run also the torque of its drive; of drivers that slide the forces.

    Args:
        reactions: result of `inverse_dynamics`.
        ax: the caller's axes, two where some drivers turn and some slide; by default those of a new figure.

    Raises:
        PinpressError: a value is not finite, ``ax`` are no axes, or Matplotlib is not installed.
    """
    drawn = _with_steps(reactions, charts.driving(reactions))
    return _stacked(drawn.motion, [*charts.driving(drawn)], ax, 6.0)


@typed
def bearings(reactions: Reactions, *, ax: Axes | Iterable[Axes] | None = None) -> Figure:
    """Draw the magnitudes of all bearing and guide forces, and of the moments in bearings and guides that hold one.

    Curves that coincide are drawn once, under both names.

    Args:
        reactions: result of `inverse_dynamics`, with all bearings.
        ax: the caller's axes, one, or two where there are moments; by default those of a new figure.

    Raises:
        PinpressError: a value is not finite, ``ax`` are not as many axes as charts, or Matplotlib is not installed.
    """
    drawn = _with_steps(reactions, charts.bearing(reactions))
    shown = [_merged(chart) for chart in (charts.bearing(drawn), charts.bearing_moment(drawn)) if chart is not None]
    return _stacked(drawn.motion, shown, ax, 7.5, 4.5)


@typed
def polar(reactions: Reactions, *bearings: str, ax: Axes | Iterable[Axes] | None = None) -> Figure:
    """Draw polar diagrams of bearing forces.

    A diagram shows the path of the force vector's tip in world axes (solid) and in axes that turn with the link on which the force acts
    (dashed), with dots at every quarter turn of the crank in the last period. Circles are lines of constant force.

    Args:
        reactions: result of `inverse_dynamics`.
        *bearings: names of bearings and guides; by default all, in the order of the drawing.
        ax: the caller's axes, one for each bearing; by default those of a new figure.

    Raises:
        UnknownNameError: there is no such bearing.
        PinpressError: a value is not finite, ``ax`` are not as many axes as bearings, or Matplotlib is not installed.
    """
    names = bearings or reactions._press.bearings_as_drawn
    return _draw_loci(reactions.motion, charts.loci(reactions, names), ax)


@typed
def shaking(reactions: Reactions, *, ax: Axes | Iterable[Axes] | None = None) -> Figure:
    """Draw the components of the shaking force in world axes, and the amplitudes of its harmonics in the last full period.

    Args:
        reactions: result of `inverse_dynamics`. Without a full period there are no harmonics.
        ax: the caller's axes, one, or two where there are harmonics; by default those of a new figure.

    Raises:
        PinpressError: a value is not finite, ``ax`` are not as many axes as charts, or Matplotlib is not installed.
    """
    motion, chart = reactions.motion, charts.shaking(reactions)
    found = harmonics(motion, reactions.shaking_force)
    if found is None or len(found.orders) < 2:
        return _stacked(motion, [chart], ax, 6.0)
    with panels(ax, 2, 12.0, lambda figure: figure.subplots(2, 1, height_ratios=(1.2, 1.0))) as drawn:
        top, bottom = drawn.axes
        _panel(top, Over(motion), chart)
        _amplitudes(bottom, chart, found)
        drawn.align_labels()
    return drawn.figure


@typed
def comparison(before: Reactions, after: Reactions, *, ax: Iterable[Axes] | None = None) -> Figure:
    """Draw the reactions of two presses, or of two operating points of one press, over each other.

    It shows driving torque, shaking force, and the peaks of the forces in the bearings that both have, each with its change in percent.

    Args:
        before: reactions drawn dashed.
        after: reactions drawn solid.
        ax: the caller's axes, one for each torque and each component of the shaking force, and one for the peaks; by default those of a new
            figure.

    Raises:
        PinpressError: they have no bearing of one name, one motion is over the crank angle and the other over time, they turn in different
            directions, ``ax`` are not as many axes as charts, or Matplotlib is not installed.
    """
    peaks = _pairs(*(charts.bearing(_with_steps(each, charts.bearing(each))) for each in (before, after)))
    if not peaks:
        raise PinpressError(f"{before.motion.linkage} and {after.motion.linkage} have no bearing of one name: there is nothing to compare")
    overs = Over(before.motion), Over(after.motion)
    _refuse_incomparable(*overs)
    pairs = _torques(before, after) + _shaking(before, after)
    rows = (len(pairs) + 1) // 2
    high = 0.62 * len(peaks) + 1.2

    def laid_out(figure: Figure) -> list[Axes]:
        places = figure.add_gridspec(rows + 1, 2, height_ratios=[4.8] * rows + [high])
        return [figure.add_subplot(place) for place in (*panel_places(places, len(pairs)), places[rows, :])]

    with panels(ax, len(pairs) + 1, 1.2 + 4.8 * rows + high, laid_out) as drawn:
        lines: list[Artist] = []
        for k, (axes, pair) in enumerate(zip(drawn.axes, pairs, strict=False)):
            lines = _compare(axes, overs, pair, wide=k == 0 and len(pairs) % 2 == 1)
        _bars(drawn.axes[-1], peaks)
        names = [f"before: {before.motion.linkage}", f"after: {after.motion.linkage}"]
        drawn.legend(lines, names, loc="outside upper center", ncols=2)
    return drawn.figure


def _refuse_incomparable(before: Over, after: Over) -> None:
    kinds = [over.abscissa.quantity for over in (before, after)]
    if (before.x[-1] < before.x[0]) != (after.x[-1] < after.x[0]):
        raise PinpressError("one motion turns forwards, the other backwards: compare two that turn the same way")
    if kinds[0] != kinds[1]:
        raise PinpressError(f"one motion is drawn over {kinds[0]}, the other over {kinds[1]}: compare two cycles, or two runs")


def _amplitudes(axes: Axes, chart: Chart, found: HarmonicAnalysis) -> None:
    """Draw the amplitudes of the harmonics of a chart's components as bars side by side; the legend names the means."""
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


def _with_steps(reactions: Reactions, _: object) -> Reactions:
    """Reactions with the states at both sides of steps, so that a step is drawn as one, after a chart of them was made, which refuses what
    cannot be drawn."""
    found = at_peaks(reactions)
    return found.reactions if any(found.remarks) else reactions


def _stacked(motion: Motion, shown: Sequence[Chart], ax: Axes | Iterable[Axes] | None, *least: float) -> Figure:
    """Draw charts one below the other over one abscissa, as high as their legends need.

    Args:
        motion: the motion.
        shown: the charts.
        ax: the caller's axes, one for each chart.
        *least: least heights of the charts, the last one for all others [cm].
    """
    lines = [sum(1 + curve.name.count("\n") for curve in chart.curves) for chart in shown]
    heights = [max(least[min(i, len(least) - 1)], 0.5 + ROW * count) for i, count in enumerate(lines)]

    def laid_out(figure: Figure) -> Iterable[Axes]:
        column: Iterable[Axes] = figure.subplots(len(shown), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
        return column

    with panels(ax, len(shown), 1.0 + sum(heights), laid_out) as drawn:
        over = Over(motion)
        for axes, chart in zip(drawn.axes, shown, strict=True):
            _panel(axes, over, chart)
        if drawn.own:  # they share the lowest label
            for axes in drawn.axes[:-1]:
                axes.set_xlabel("")
        drawn.align_labels()
    return drawn.figure


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
    merged: list[ChartCurve] = []
    for curve in chart.curves:
        twin = next((k for k, other in enumerate(merged) if np.abs(curve.values - other.values).max() <= least), None)
        if twin is None:
            merged.append(curve)
        else:
            merged[twin] = replace(merged[twin], name=f"{merged[twin].name},\n{curve.name}")
    return replace(chart, curves=tuple(merged))


class _Pair(NamedTuple):
    """One quantity before and after, in one unit.

    Attributes:
        title: name of the curve.
        quantity: quantity, see `charts.UNITS`.
        unit: unit of both.
        before: (n,) values before.
        after: (m,) values after.
    """

    title: str
    quantity: str
    unit: str
    before: Array
    after: Array


def _torques(before: Reactions, after: Reactions) -> list[_Pair]:
    """Driving torques and forces of the drivers that both have."""
    known, several = {chart.title: chart for chart in _without_drives(after)}, len(before.motion.drivers) > 1
    return [
        pair._replace(title=f"{first.title} {pair.title}" if several else first.title)
        for first in _without_drives(before)
        if first.title in known
        for pair in _pairs(first, known[first.title])
    ]


def _without_drives(reactions: Reactions) -> Iterator[Chart]:
    for chart in charts.driving(reactions):
        with_drives = isinstance(reactions.motion, Run)  # a curve of the drive behind each of a driver
        yield replace(chart, curves=chart.curves[: len(chart.curves) // 2]) if with_drives else chart


def _shaking(before: Reactions, after: Reactions) -> list[_Pair]:
    """Components of the shaking force; a component that only one press has is zero in the other."""
    pair = charts.shaking(before), charts.shaking(after)
    names = sorted({curve.name for chart in pair for curve in chart.curves if curve.values.any()}) or list(AXES)
    first, second = (_with_components(chart, names) for chart in pair)
    return [pair._replace(title=f"{first.title} {pair.title}") for pair in _pairs(first, second)]


def _with_components(chart: Chart, names: Sequence[str]) -> Chart:
    known = {curve.name: curve.values for curve in chart.curves}
    zero = np.zeros_like(chart.curves[0].values)
    return replace(chart, curves=tuple(ChartCurve(name, known.get(name, zero)) for name in names))


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
    """Draw the peaks of the bearings' forces, with their changes."""
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


def _draw_loci(motion: Motion, loci: Sequence[Locus], ax: Axes | Iterable[Axes] | None) -> Figure:
    """Draw a diagram for each locus in the last full period, with equal scales on both axes.

    A diagram of a force on a link that does not turn has one path.
    """
    columns = {1: 1, 2: 2, 4: 2}.get(len(loci), 3 if len(loci) < 10 else 4)
    rows = math.ceil(len(loci) / columns)
    side = min(WIDTH / columns, LARGEST)

    def laid_out(figure: Figure) -> list[Axes]:
        places: list[Axes] = figure.subplots(rows, columns, squeeze=False).ravel().tolist()
        for empty in places[len(loci) :]:
            empty.set_axis_off()
        return places[: len(loci)]

    with panels(ax, len(loci), 1.4 + rows * (side + 0.8), laid_out) as drawn:
        over, marked = Over(motion), _quarters(motion)
        first = max(0, (last_period(motion) or 0) - 1)  # earlier periods would only hide the last
        for axes, locus in zip(drawn.axes, loci, strict=True):
            width = side if drawn.own else float(axes.get_window_extent().width) / float(axes.figure.dpi) / CENTIMETRE
            _draw(axes, locus, over, first, marked, min(width, LARGEST))
        place = drawn.axes[0]
        lines = [*place.plot([], [], color=FRAME), *place.plot([], [], color=OWN, linestyle=DASHED)]
        names = ["axes of the frame", "axes fixed to the link"]
        if marked:
            lines += place.plot([], [], "o", color=FRAME, markersize=4.0)
            names.append("crank angle [deg]")
        drawn.legend(lines, names, loc="outside lower center", ncols=len(names))
    return drawn.figure


def _draw(axes: Axes, locus: Locus, over: Over, first: int, marked: Sequence[tuple[int, int]], side: float) -> None:
    """Draw both paths from a state on, with marks; ``side`` is that of the diagram [cm]."""
    largest = float(np.hypot(*locus.frame.T).max())
    labels = _paper(axes, locus, largest)
    if not largest:
        axes.plot(0.0, 0.0, "o", color=FRAME, markersize=4.0)
        return
    turns = np.abs(locus.own - locus.frame).max() > SAME * largest
    if turns:
        axes.plot(*over.along(locus.own)[first:].T, color=OWN, linestyle=DASHED, linewidth=0.8 * LINE)
    axes.plot(*over.along(locus.frame)[first:].T, color=FRAME, linewidth=0.8 * LINE)
    if len(locus.frame) == 1:
        axes.plot(*locus.frame[0], "o", color=FRAME, markersize=4.0)
    for _, state in marked:
        if turns:
            axes.plot(*locus.own[state], "o", color="white", markersize=3.0, markeredgecolor=OWN, markeredgewidth=0.8)
        axes.plot(*locus.frame[state], "o", color=FRAME, markersize=4.0, markeredgecolor="white", markeredgewidth=THIN)
    letter = float(np.ptp(axes.get_xlim())) * LETTER / side
    taken = np.concatenate([locus.frame[first:], locus.own[first:], labels])
    for words, state in _together(locus.frame, marked, CLOSE * largest):
        size = letter * np.array([0.5 * len(words), 0.8])
        place = _free(locus.frame[state], size, 1.2 * letter, taken)
        _haloed(axes.annotate(words, tuple(place), color=FRAME, ha="center", va="center"))
        taken = np.concatenate([taken, place + np.multiply.outer([-1.0, -0.5, 0.0, 0.5, 1.0], [size[0], 0.0])])


def _together(path: Array, marked: Sequence[tuple[int, int]], close: float) -> list[tuple[str, int]]:
    """Labels of marked crank angles with their states; marks that are close together share a label at the first of them."""
    groups: list[tuple[list[str], int]] = []
    for degrees, state in marked:
        near = next((words for words, other in groups if np.hypot(*(path[state] - path[other])) < close), None)
        if near is None:
            groups.append(([str(degrees)], state))
        else:
            near.append(str(degrees))
    return [(", ".join(words), state) for words, state in groups]


def _free(mark: Array, size: Array, gap: float, taken: Array) -> Array:
    """Middle (2,) of a label next to its mark, clear of places (k, 2) that are taken; ``size``: its half width and height."""
    angles = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    middles = mark + directions * (gap + size)

    def clear(middle: Array) -> float:
        return min(gap, float(np.hypot(*np.maximum(np.abs(taken - middle) - size, 0.0).T).min()))

    return max(middles, key=clear)


def _paper(axes: Axes, locus: Locus, largest: float) -> Array:
    """Draw axes through zero, names, and circles of constant force with their values; return the places (k, 2) of the values."""
    step = _step(largest)
    radii: Array = np.arange(1, max(1, math.ceil(largest / step - 1e-9)) + 1, dtype=float) * step
    turn = np.linspace(0.0, 2 * np.pi, 181)
    for radius in radii:
        axes.plot(radius * np.cos(turn), radius * np.sin(turn), color=LIGHT, linewidth=THIN, zorder=0.5)
    end = float(radii[-1])
    for across in ([-1.15, 1.15], [0.0, 0.0]), ([0.0, 0.0], [-1.15, 1.15]):
        axes.plot(*np.multiply(end, across), color=LIGHT, linewidth=THIN, zorder=0.5)
    axes.set_aspect("equal")
    axes.set_xlim(-1.15 * end, 1.15 * end)
    axes.set_ylim(-1.15 * end, 1.3 * end)
    axes.set_axis_off()
    places = _clearest(locus, radii)
    for place, radius in zip(places, radii, strict=True):
        words = f"{radius:g}" + (f" {locus.unit}" if radius == end else "")
        _haloed(axes.annotate(words, tuple(place), color=GREY, ha="center", va="center"))
    look: dict[str, Any] = {"color": GREY, "fontsize": SMALL, "style": "italic", "va": "center"}
    plain(axes.text(1.17 * end, 0.0, locus.axes[0], ha="left", **look))
    plain(axes.text(0.0, 1.25 * end, locus.axes[1], ha="center", **look))
    plain(axes.set_title(f"{brief(locus.bearing)}\n", pad=4.0, fontweight="bold"))
    look = {"ha": "center", "fontsize": SMALL, "color": GREY}
    plain(axes.annotate(f"on {brief(locus.link)}", (0.5, 1.0), (0, 6.0), "axes fraction", "offset points", **look))
    return places


def _clearest(locus: Locus, radii: Array) -> Array:
    """Places (k, 2) on circles of these radii, along the diagonal that is farthest from both paths."""
    paths = np.concatenate([locus.frame, locus.own])
    diagonals = [np.multiply.outer(radii, math.sqrt(0.5) * np.array(signs)) for signs in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
    return max(diagonals, key=lambda places: float(np.hypot(*(places[:, None] - paths).T).min()))


def _haloed(text: Text) -> Text:
    """Make a text small, with a white edge that keeps it legible on lines."""
    from matplotlib.patheffects import withStroke  # optional, and slow to import

    text.set_fontsize(TINY)
    text.set_path_effects([withStroke(linewidth=1.2, foreground="white")])
    return text


def _step(largest: float) -> float:
    """A round step of which at most three make up a size."""
    if not largest:
        return 1.0
    power = 10.0 ** math.floor(math.log10(largest / 3))
    return next(factor * power for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if largest / (factor * power) <= 3 * (1 + 1e-9))


def _quarters(motion: Motion) -> list[tuple[int, int]]:
    """Quarter turns [deg] in the last period, each with its nearest state; empty for several drivers."""
    angle: Array = motion.crank_angle
    if angle.ndim > 1 or len(angle) < 3:
        return []
    turns = motion.period_turns or 1
    period = 2 * np.pi * turns
    last = np.flatnonzero(np.abs(angle - angle[-1]) < period * (1 - 1e-9))
    step = float(np.abs(np.diff(angle)).max())
    marked = []
    for degrees in range(0, 360 * turns, QUARTER):
        away = np.abs((angle[last] - np.radians(degrees) + 0.5 * period) % period - 0.5 * period)
        if away.min() <= 0.5 * step + 1e-9:
            marked.append((degrees, int(last[away.argmin()])))
    return marked
