"""Charts of any result, drawn with Matplotlib from what the result describes (`Tabular.described`)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ..common.arguments import expect
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.outlets.described import Along, Bars, Chart, Curve, Map, Mark, Polar, charts_of
from ..common.quantities import ShownUnit, quantity
from ..common.results import Tabular
from ..dynamics.reactions import Reactions
from ..kinematics.motion import Motion
from .loci import draw_loci
from .style import COLOURS, GREY, LINES, SMALL, THIN, WIDTH, above, brief, grid, legend, panels, plain

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Drawn: TypeAlias = Chart | Bars | Polar | Map
ROW = 0.45  # height of a row of a legend, and of a bar [cm]
MOST_ABOVE = 4  # most names of curves in a legend of one line above the axes
HIGH = 4.4  # least height of a chart [cm]
PALE = "#b0b0b0"
DASHED = (0, (4, 1.5))
LIMIT = 1.0  # width of the line of a limit [pt]


def draw(
    result: Tabular | Mapping[str, Tabular],
    *names: str,
    before: Tabular | None = None,
    page: Reactions | None = None,
    ax: Axes | Iterable[Axes] | None = None,
) -> Figure:
    """Draw charts of a result, or the same charts of several results over each other.

        pp.plots.draw(reactions, "torque", "bearings")
        pp.plots.draw(reactions, "polar A", "polar D")
        pp.plots.draw({"idle": idle, "pressing": pressing}, "torque")

    Args:
        result: any result of the library that has charts, or results by their names.
        *names: names of charts; a first word stands for all that begin with it, "polar" for the polar diagrams of all bearings. By default
            all charts of the result, except those of one bearing or channel among many.
        before: a result to compare with, drawn dashed and grey.
        page: reactions of the press, whose process ratings are compared with; None for none.
        ax: the caller's axes, one for each chart; by default those of a new figure.

    Raises:
        PinpressError: the result has no charts, the two cannot be compared, a value is not finite, ``ax`` are not as many axes as charts,
            or Matplotlib is not installed.
        UnknownNameError: the result has no such chart.
    """
    if page is not None:
        expect("page", page, Reactions, "inverse_dynamics")
    if before is not None:
        expect("before", before, Tabular, "a function of pinpress")
    if isinstance(result, Mapping):
        if before is not None:
            raise PinpressError("before goes with one result: give it as one of the results by name instead")
        charts = _over_each_other(result, names, page)
    else:
        charts = _chosen(result, names, page)
    old = {} if before is None else charts_of(before.described())
    if before is not None and not any(chart.name in old for chart in charts):
        raise PinpressError(
            f"{shown(before)} has none of the charts {', '.join(chart.name for chart in charts)}: there is nothing to compare"
        )
    for chart in charts:
        other = old.get(chart.name)
        if isinstance(chart, Chart) and isinstance(other, Chart):
            one, two = chart.along, other.along
            if one.name != two.name:
                raise PinpressError(f"one is drawn over {one.name}, the other over {two.name}: compare two cycles, or two runs")
            ways = {along.values[-1] < along.values[0] for along in (one, two) if along.values is not None}
            if one.quantity != "s" and len(ways) > 1:
                raise PinpressError("one motion turns forwards, the other backwards: compare two that turn the same way")
    return _figure(charts, old, ax)


def _chosen(result: Tabular, names: Sequence[str], page: Reactions | None) -> list[Drawn]:
    """The charts of a result that are named; all if none is."""
    if not isinstance(result, Tabular) or not all(isinstance(name, str) for name in names):
        raise PinpressError(f"{shown(result)} is no result: give what a function of pinpress returns, or such results by names")
    known = charts_of(result.described(page))
    if not known:
        remedy = " ".join(filter(None, (section.note for section in result.described(page))))
        raise PinpressError(f"{shown(result)} has no charts" + (f". {remedy}" if remedy else ""))
    if not names:
        every: list[Drawn] = list(known.values())
        return [chart for chart in every if not isinstance(chart, Polar) and not getattr(chart, "detail", False)] or every
    charts: list[Drawn] = []
    for name in names:
        of_name = [known[name]] if name in known else [chart for key, chart in known.items() if key.startswith(f"{name} ")]
        if not of_name:
            raise UnknownNameError("chart", name, known)
        charts += of_name
    return charts


def _over_each_other(results: Mapping[str, Tabular], names: Sequence[str], page: Reactions | None) -> list[Drawn]:
    """The charts of several results with one name as one."""
    if not results:
        raise PinpressError("there is nothing to draw: give results, each under a name")
    by_result = {name: {chart.name: chart for chart in _chosen(result, names, page)} for name, result in results.items()}
    first = next(iter(by_result.values()))
    return [
        _joined(chart, {name: charts[chart.name] for name, charts in by_result.items() if chart.name in charts}) for chart in first.values()
    ]


def _joined(first: Drawn, same: Mapping[str, Drawn]) -> Drawn:
    """Charts of one name as one, whose curves have the names of the results."""
    if len(same) < 2 or isinstance(first, Map | Polar):
        return first

    def named(name: str, curve: str, count: int) -> str:
        return name if count == 1 else f"{name}, {curve}"

    if isinstance(first, Bars):
        bars = {name: each for name, each in same.items() if isinstance(each, Bars) and list(each.places) == list(first.places)}
        series = {named(name, one, len(each.series)): values for name, each in bars.items() for one, values in each.series.items()}
        return replace(first, series=series, band=None)
    curves: list[Curve] = []
    guides = dict[str, Curve]()
    shared = _shared_points([each for each in same.values() if isinstance(each, Chart)])
    for name, each in same.items():
        if not isinstance(each, Chart) or (each.along.name, each.quantity) != (first.along.name, first.quantity):
            raise PinpressError(f"{name} has its chart {first.name} over another quantity: draw it alone")
        own = [curve for curve in each.curves if curve.look not in ("guide", "limit") and curve.name not in shared]
        curves += [replace(_closed(each.along, curve), name=named(name, curve.name, len(own))) for curve in own]
        x = each.along.values
        guides |= {curve.name: replace(curve, x=x if curve.x is None else curve.x) for curve in each.curves if curve not in own}
    return replace(first, curves=[*curves, *guides.values()], along=replace(first.along, period=None))


def _shared_points(charts: Sequence[Chart]) -> list[str]:
    """Names of curves of a single point that is the same in all charts, as the press before balancing."""
    points = [
        {curve.name: [*curve.x.tolist(), *curve.y.tolist()] for curve in chart.curves if len(curve.y) == 1 and curve.x is not None}
        for chart in charts
    ]
    first, *others = points
    return [name for name, place in first.items() if all(known.get(name) == place for known in others)]


# ------------------------------------------------------------------------------------------------------------------------------- layout


def _figure(charts: Sequence[Drawn], old: Mapping[str, Drawn], ax: Axes | Iterable[Axes] | None) -> Figure:
    """Charts below each other, polar diagrams side by side below them."""
    loci = [chart for chart in charts if isinstance(chart, Polar)]
    others = [chart for chart in charts if not isinstance(chart, Polar)]
    heights = [_height(chart) for chart in others]
    columns = {1: 1, 2: 2, 4: 2}.get(len(loci), 3 if len(loci) < 10 else 4)
    rows = math.ceil(len(loci) / columns)
    side = min(WIDTH / columns, 8.0)

    def laid_out(figure: Figure) -> list[Axes]:
        places = figure.add_gridspec(len(others) + rows, columns, height_ratios=[*heights, *[side] * rows])
        axes = [figure.add_subplot(places[k, :]) for k in range(len(others))]
        return axes + [figure.add_subplot(places[len(others) + k // columns, k % columns]) for k in range(len(loci))]

    with panels(ax, len(charts), 1.4 + sum(heights) + rows * (side + 0.8), laid_out) as drawn:
        order = {chart.name: axes for chart, axes in zip([*others, *loci] if drawn.own else charts, drawn.axes, strict=True)}
        for chart in others:
            axes, before = order[chart.name], old.get(chart.name)
            if isinstance(chart, Bars):
                _bars(axes, chart, before if isinstance(before, Bars) else None)
            elif isinstance(chart, Map):
                _map(axes, chart)
            elif isinstance(chart, Chart):
                _chart(axes, chart, before if isinstance(before, Chart) else None)
        if drawn.own:  # of charts below each other along one quantity, the lowest alone names it
            for upper, lower in itertools.pairwise(order[chart.name] for chart in others):
                if upper.get_xlabel() == lower.get_xlabel() and upper.get_xlim() == lower.get_xlim():
                    upper.set_xlabel("")
        if loci:
            earlier = {name: each for name, each in old.items() if isinstance(each, Polar)}
            draw_loci(drawn, [order[locus.name] for locus in loci], loci, earlier)
        drawn.align_labels()
    return drawn.figure


def _height(chart: Drawn) -> float:
    """Height of a chart, as its legend or its bars need [cm]."""
    if isinstance(chart, Map) or (isinstance(chart, Chart) and chart.square):
        return 8.0
    if isinstance(chart, Bars):
        if not _words(chart):
            return HIGH
        series = 1 if chart.stacked else max(len(chart.series), 1)
        return max(2.4, 1.2 + ROW * len(chart.places) * max(1.0, 0.6 * series))
    assert isinstance(chart, Chart)
    names = sum(1 + curve.name.count("\n") for curve in _merged(chart).curves) + sum(bool(mark.name) for mark in chart.marks)
    return max(HIGH, 0.8 + ROW * names) if names > MOST_ABOVE else HIGH


# ------------------------------------------------------------------------------------------------------------------------------- curves


def _chart(axes: Axes, chart: Chart, old: Chart | None) -> None:
    chart = _merged(chart)
    before = {} if old is None else {curve.name: curve for curve in old.curves}
    across, up = _scales(chart, list(before.values()))
    grid(axes, _label(quantity(chart.quantity).name, up))
    _backdrop(axes, chart.along, across)
    lines: list[Artist] = []
    names: list[str] = []
    coloured = 0
    for curve in chart.curves:
        colour, style = _look(curve, coloured)
        coloured += curve.look != "guide"
        closed = _closed(chart.along, curve)
        assert closed.x is not None
        x, y = across.factor * closed.x, up.factor * closed.y
        if closed.band is not None:
            low, high = up.factor * closed.band.T
            if curve.look == "points":
                axes.vlines(x, low, high, color=colour, linewidth=LIMIT)
            else:
                axes.fill_between(x, low, high, color=colour, alpha=0.25, linewidth=0)
        other = before.get(curve.name.split(",\n")[0])
        if old is not None and other is not None:
            earlier = _closed(old.along, other)
            assert earlier.x is not None
            dashes: dict[str, Any] = {"color": GREY if len(chart.curves) == 1 else colour, "linestyle": DASHED, "alpha": 0.7}
            axes.plot(across.factor * earlier.x, up.factor * earlier.y, **dashes)
        drawn = axes.plot(x, y, **style)
        if curve.look != "guide":
            lines += drawn
            names.append(curve.name)
    for k, mark in enumerate(chart.marks):
        made = _mark(axes, mark, across if mark.axis == "x" else up, COLOURS[k % len(COLOURS)] if mark.name else PALE)
        if mark.name:
            lines.append(made)
            names.append(mark.name)
    _limits(axes, chart, across)
    title = chart.title
    if old is not None and len(chart.curves) == 1:
        other = before.get(chart.curves[0].name)
        title += f", range {'' if other is None else change(float(np.ptp(other.y)), float(np.ptp(chart.curves[0].y)))}"
    _title(axes, title, lines, names, in_one_line=sum(map(len, names)) < 80)


def _title(axes: Axes, title: str, handles: Sequence[Artist], names: Sequence[str], in_one_line: bool = True) -> None:
    """Title and legend of a chart: the legend of a few names is one line above the axes, others are beside them."""
    over = in_one_line and 1 < len(names) <= MOST_ABOVE
    plain(axes.set_title(brief(title, 90), loc="left", pad=17.0 if over else 5.0))
    if over:
        above(axes, handles, names)
    elif len(names) > 1:
        legend(axes, handles, names, loc="upper left", bbox_to_anchor=(1.0, 1.02), borderaxespad=0.3)


def _look(curve: Curve, k: int) -> tuple[str, dict[str, Any]]:
    """Colour and style of the k-th curve, in colours and kinds of lines that the colour-blind can tell apart."""
    colour = GREY if curve.look == "guide" else COLOURS[k % len(COLOURS)]
    style: dict[str, Any] = {"color": colour, "linestyle": LINES[k // len(COLOURS) % len(LINES)]}
    if curve.look == "points" or len(curve.y) == 1:
        style = {"color": colour, "linestyle": "none", "marker": "o", "markersize": 3.5}
    elif curve.look == "marked":
        style |= {"marker": "o", "markersize": 2.5}
    elif curve.look == "strong":
        style |= {"linewidth": 3.0, "alpha": 0.75, "solid_capstyle": "round"}
    elif curve.look == "limit":
        style |= {"linewidth": LIMIT, "linestyle": LINES[1 + k // len(COLOURS) % (len(LINES) - 1)]}
    elif curve.look == "guide":
        style |= {"linewidth": THIN, "linestyle": "-"}
    return colour, style


def _merged(chart: Chart) -> Chart:
    """The chart with coinciding curves as one, under both names, as for the two halves of a symmetric press."""
    if chart.stacked:
        return _stacked(chart)
    least = 1e-6 * max((float(np.nanmax(np.abs(curve.y), initial=0.0)) for curve in chart.curves), default=0.0)
    merged: list[Curve] = []
    for curve in chart.curves:
        twin = next((k for k, other in enumerate(merged) if _alike(curve, other, least)), None)
        if twin is None:
            merged.append(curve)
        else:
            merged[twin] = replace(merged[twin], name=f"{merged[twin].name},\n{curve.name}")
    return replace(chart, curves=merged)


def _alike(one: Curve, other: Curve, least: float) -> bool:
    if one.look != other.look or one.look == "guide" or one.y.shape != other.y.shape or one.band is not None or other.band is not None:
        return False
    along = one.x is other.x or (one.x is not None and other.x is not None and np.array_equal(one.x, other.x))
    return along and bool(np.abs(one.y - other.y).max(initial=0.0) <= least)


def _stacked(chart: Chart) -> Chart:
    """Curves standing on each other, each as the band from the one below it; positive and negative ones grow apart."""
    high = low = np.zeros_like(chart.curves[0].y)
    curves = []
    for curve in chart.curves:
        start = np.where(curve.y >= 0, high, low)
        top = start + curve.y
        high, low = np.maximum(high, top), np.minimum(low, top)
        curves.append(replace(curve, y=top, band=np.column_stack([start, top])))
    return replace(chart, curves=curves, stacked=False)


def _closed(along: Along, curve: Curve) -> Curve:
    """A curve with its places; one of the states of a period is closed by its first state."""
    x, period = along.values if curve.x is None else curve.x, along.period
    assert x is not None
    of_states = curve.x is None or (isinstance(along.of, Motion) and len(x) == len(along.of.crank_angle))
    if period is None or not of_states or len(x) != len(curve.y):
        return replace(curve, x=x)
    end = x[0] + period if curve.x is None else x[0]
    band = None if curve.band is None else np.concatenate([curve.band, curve.band[:1]])
    return replace(curve, x=np.append(x, end), y=np.append(curve.y, curve.y[0]), band=band)


def _scales(chart: Chart, others: Sequence[Curve]) -> tuple[ShownUnit, ShownUnit]:
    """How places and values of a chart are written."""
    curves = [*chart.curves, *others]
    places = [chart.along.values] if chart.along.values is not None else []
    places += [curve.x for curve in curves if curve.x is not None]
    ends = [end for end in chart.reach if end is not None]
    widths = ends or [float(value) for x in places for value in (np.nanmin(x), np.nanmax(x)) if len(x)]
    values = [float(np.nanmax(np.abs(curve.y), initial=0.0)) for curve in curves if np.isfinite(curve.y).any()]
    if chart.square:  # one scale for both
        both = quantity(chart.quantity).scale([*widths, *values])
        return both, both
    return quantity(chart.along.quantity).scale(widths), quantity(chart.quantity).scale(values, chart.reference)


def _label(name: str, scale: ShownUnit) -> str:
    name = "" if name == quantity("-").name else name  # a pure number: the title says what it is
    return f"{name} [{scale.unit}]".strip() if scale.unit else name


def _backdrop(axes: Axes, along: Along, across: ShownUnit) -> None:
    """The working stroke shaded, and thin lines at marks with their names."""
    if along.shaded is not None:
        axes.axvspan(*(across.factor * end for end in along.shaded), color="#f3f3f3", zorder=0, linewidth=0)
    for name, place in along.marks.items():
        axes.vlines(across.factor * place, 0.0, 1.0, transform=axes.get_xaxis_transform(), color=PALE, linewidth=THIN, linestyle=":")
        look = {"fontsize": SMALL - 2, "color": GREY, "va": "top", "ha": "right"}
        plain(axes.text(across.factor * place, 0.99, f"{name} ", transform=axes.get_xaxis_transform(), **look))  # type: ignore[arg-type]


def _mark(axes: Axes, mark: Mark, scale: ShownUnit, colour: str) -> Artist:
    if isinstance(mark.at, tuple):
        span = axes.axvspan if mark.axis == "x" else axes.axhspan
        return span(scale.factor * mark.at[0], scale.factor * mark.at[1], color=colour, alpha=0.5, linewidth=1.0)
    line = axes.axvline if mark.axis == "x" else axes.axhline
    return line(scale.factor * mark.at, color=GREY, linewidth=LIMIT, linestyle="--")


def _limits(axes: Axes, chart: Chart, across: ShownUnit) -> None:
    """Label, ends and ticks of both axes."""
    from matplotlib.ticker import MaxNLocator, MultipleLocator  # optional, and slow to import

    plain(axes.set_xlabel(_label(chart.along.name, across)))
    x, period = chart.along.values, chart.along.period
    if any(end is not None for end in chart.reach):
        axes.set_xlim(*(None if end is None else across.factor * end for end in chart.reach))
        if chart.reach[0] == 0.0 and all(np.nanmin(curve.y) >= 0 for curve in chart.curves):
            axes.set_ylim(bottom=0.0)
    elif x is not None and len(x) and all(curve.x is None for curve in chart.curves):
        first, last = float(x[0]), float(x[-1] if period is None else x[0] + period)
        if first != last:
            axes.set_xlim(across.factor * first, across.factor * last)  # also for a falling angle, as time runs to the right
    if across.unit == "deg":
        turned = abs(float(np.subtract(*axes.get_xlim())))
        whole = MultipleLocator(45 * max(1, round(turned / 360)))
        axes.xaxis.set_major_locator(whole if turned >= 270 else MaxNLocator(9, steps=[1, 1.5, 3, 4.5, 6, 9, 10]))
    if chart.logarithmic:
        axes.set_yscale("log")
    if chart.logarithmic == "xy":
        axes.set_xscale("log")
    if chart.square:
        axes.set_aspect("equal", adjustable="datalim")
    elif any(curve.look == "points" for curve in chart.curves) and not chart.logarithmic:
        axes.margins(x=0.04)


def change(before: float, after: float) -> str:
    """The change of a size in percent, or in words if it was zero before."""
    if before == 0.0:
        return "0 as before" if after == 0.0 else "0 before"
    share = round(100 * (after / before - 1), 1) + 0.0  # no "-0.0"
    return f"{share:+.1f} %".replace("-", "\u2212") if share else "±0.0 %"


# --------------------------------------------------------------------------------------------------------------------------- bars and maps


def _words(chart: Bars) -> bool:
    return bool(len(chart.places)) and isinstance(chart.places[0], str)


def _bars(axes: Axes, chart: Bars, old: Bars | None) -> None:
    """Horizontal bars at words, upright ones at numbers; those before are pale, with the change behind them."""
    known = {} if old is None else {name: dict(zip(old.places, values, strict=True)) for name, values in old.series.items()}
    if old is not None:  # at the places that both have
        kept = [k for k, place in enumerate(chart.places) if place in old.places]
        if not kept:
            raise PinpressError(f"the two have no place of {chart.title.lower()} of one name: there is nothing to compare")
        places: list[Any] = [chart.places[k] for k in kept]
        chart = replace(chart, places=places, series={name: values[kept] for name, values in chart.series.items()}, band=None)
    values = [float(value) for series in chart.series.values() for value in series]
    scale = quantity(chart.quantity).scale([*values, *(float(each) for series in known.values() for each in series.values())])
    flat = _words(chart)
    at = np.arange(len(chart.places), dtype=float) if flat else np.asarray(chart.places, dtype=float)
    apart = float(np.diff(at).min(initial=1.0)) if len(at) > 1 else 1.0
    rows = 1 if chart.stacked else len(chart.series) * (1 if old is None else 2)
    width, draw_bar = 0.8 * apart / max(rows, 1), axes.barh if flat else axes.bar
    grid(axes, "" if flat else _label(quantity(chart.quantity).name, scale))
    axes.grid(False, axis="y" if flat else "x")
    handles: list[Artist] = []
    high = low = np.zeros(len(at))
    row = 0
    for k, (name, series) in enumerate(chart.series.items()):
        colour, sizes = COLOURS[k % len(COLOURS)], scale.factor * np.asarray(series, dtype=float)
        if name in known:
            pale = np.array([scale.factor * known[name][place] for place in chart.places])
            draw_bar(at + (row - 0.5 * (rows - 1)) * width, pale, width, color=PALE, linewidth=0)
            row += 1
        start = np.where(sizes >= 0, high, low) if chart.stacked else np.zeros(len(at))
        place = at if chart.stacked else at + (row - 0.5 * (rows - 1)) * width
        handles.append(draw_bar(place, sizes, width, start, color=colour, linewidth=0).patches[0])
        if name in known:
            for spot, old_size, new_size in zip(place, pale, sizes, strict=True):
                words = change(float(old_size), float(new_size))
                where: dict[str, Any] = {"textcoords": "offset points", "va": "center", "fontsize": SMALL}
                plain(axes.annotate(words, (max(old_size, new_size), spot), (4, 0), **where))
        high, low = (np.maximum(high, start + sizes), np.minimum(low, start + sizes)) if chart.stacked else (high, low)
        row += 0 if chart.stacked else 1
    if chart.band is not None:  # a dot at the sum of each place
        sums = scale.factor * np.sum(list(chart.series.values()), axis=0)
        ends = np.maximum(np.abs(scale.factor * chart.band.T - sums), 0.0)
        look: dict[str, Any] = {"fmt": "o", "color": "black", "markersize": 3.5, "capsize": 2.5, "linewidth": 1.0}
        if flat:
            axes.errorbar(sums, at, xerr=ends, **look)
        else:
            axes.errorbar(at, sums, yerr=ends, **look)
    if flat:
        axes.set_yticks(at, [brief(str(place)) for place in chart.places])
        for text in axes.get_yticklabels():
            plain(text)
        axes.set_ylim(len(at) - 0.4, -0.6)  # the first at the top
        plain(axes.set_xlabel(_label(quantity(chart.quantity).name, scale)))
        axes.margins(x=0.12)
    else:
        axes.set_xlim(at[0] - 0.6 * apart, at[-1] + 0.6 * apart)
        axes.set_xticks(np.arange(1.0, at[-1] + 1.0) if at[-1] >= 1 and len(at) <= 40 else at)
        plain(axes.set_xlabel(chart.across))
    _title(axes, chart.title, handles, list(chart.series))


def _map(axes: Axes, chart: Map) -> None:
    """Values as colours; written ones as numbers in squares."""
    scale = quantity(chart.quantity).scale(np.abs(chart.values[np.isfinite(chart.values)]).tolist())
    x, y = chart.across.values, chart.up.values
    assert x is not None
    assert y is not None
    across = quantity(chart.across.quantity).scale(np.ravel(x).tolist(), digits=4)
    up = quantity(chart.up.quantity).scale(np.ravel(y).tolist(), digits=4)
    values = scale.factor * chart.values
    grid(axes, _label(chart.up.name, up))
    axes.grid(False)
    if chart.written:
        axes.imshow(values, cmap="Blues", aspect="auto", vmin=0.0)
        middle = 0.5 * float(np.nanmax(values))
        for (i, k), value in np.ndenumerate(values):
            axes.text(k, i, f"{value:.2f}", ha="center", va="center", fontsize=6, color="white" if value > middle else "black")
        axes.set_xticks(range(values.shape[1]), [across.shown(float(each)) for each in x], rotation=45, fontsize=7)
        axes.set_yticks(range(values.shape[0]), [up.shown(float(each)) for each in y], fontsize=7)
    else:
        from matplotlib.colors import LogNorm  # optional, and slow to import

        top = float(np.nanmax(values)) or 1.0
        norm = LogNorm(top * 10**-chart.decades, top, clip=True) if chart.decades else None
        grid_x, grid_y = np.broadcast_arrays(x if x.ndim == 2 else x[None, :], y if y.ndim == 2 else y[:, None])
        colours = {"cmap": "viridis", "shading": "gouraud", "rasterized": True, "norm": norm}
        mesh = axes.pcolormesh(across.factor * grid_x, up.factor * grid_y, values, **colours)  # type: ignore[arg-type]
        bar = axes.figure.colorbar(mesh, cax=axes.inset_axes((1.02, 0.0, 0.025, 1.0)))  # inside axes that the caller gave
        plain(bar.ax.set_ylabel(_label(quantity(chart.quantity).name, scale)))
    for mark in chart.marks:
        if not isinstance(mark.at, tuple):
            line, size = (axes.axvline, across) if mark.axis == "x" else (axes.axhline, up)
            line(size.factor * mark.at, color="white", linewidth=0.8, linestyle=DASHED)
    handles: list[Artist] = []
    for k, curve in enumerate(chart.curves):
        assert curve.x is not None
        look: dict[str, Any] = {"color": COLOURS[(1 + 2 * k) % len(COLOURS)], "linestyle": "none", "marker": "o", "markersize": 2.5}
        handles += axes.plot(across.factor * curve.x, up.factor * curve.y, **look)
    plain(axes.set_xlabel(_label(chart.across.name, across)))
    plain(axes.set_title(brief(chart.title, 90), loc="left", pad=17.0 if handles else 5.0))
    if handles:
        above(axes, handles, [curve.name for curve in chart.curves])
