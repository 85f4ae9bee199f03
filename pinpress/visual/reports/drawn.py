"""Sections of results as a page draws them: units chosen, states thinned to those of the page, and what a chart's cursor follows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common import tables
from ...common.errors import PinpressError
from ...common.errors import shown as text_of
from ...common.outlets import described, text
from ...common.quantities import Array, quantity
from ...common.results import Tabular
from ...kinematics.motion import Motion
from ...linkage.linkage import OfPress
from ..pages import packed
from .blocks import BarChart, Block, ColourMap, Figure, Figures, Follows, Line, LineChart, Section, Table
from .shown import Shown, refuse_others

HEIGHT = "height above bottom dead centre"
DIGITS = 5  # of numbers on a page
MOST_POINTS = 5000  # states of which each is a point of a curve over the height
SAME = 1e-6  # periods by which an angle may lie beyond its period by rounding
# looks of a line of the page, and of a curve
LOOKS = {"points": "points", "marked": "marked", "strong": "strong", "pale": "guide", "limit": "limit"}
Charts = Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Before:
    """The press before, whose curves are dashed.

    Attributes:
        shown: what it shows moving.
        charts: its charts by their names.
    """

    shown: Shown
    charts: Charts


def sections_of(result: Tabular, page: Shown) -> list[Section]:
    """The sections of a result.

    Raises:
        PinpressError: It has none, or is of another press.
    """
    if isinstance(result, OfPress):
        refuse_others(type(result).__name__, result._press, page)
    if described := result.described(page.reactions):
        return [section(part, page) for part in described]
    raise PinpressError(f"results: a report has no section for {text_of(result)}; give results that have some, as ratings, runs or budgets")


def section(part: described.Section, shown: Shown, before: Before | None = None, *, headlines: bool = True) -> Section:
    """A section as a page draws it.

    Args:
        part: the section.
        shown: what the page shows moving.
        before: the press before; None for none.
        headlines: whether figures that a reader looks for first are in it; else the page shows them at its top.

    Raises:
        PinpressError: it is of another press than the page.
    """
    if part.press is not None:
        refuse_others(part.of, part.press, shown)  # type: ignore[arg-type]  # a linkage
    some = [figure_of(each) for each in part.figures if headlines or not each.kind]
    blocks: list[Block] = [Figures(some)] if some else []
    polars = [block for block in part.blocks if isinstance(block, described.Polar)]
    details = {block.name: block for block in part.blocks if isinstance(block, described.Chart) and block.detail}
    if polars:
        blocks_after: list[Block] = [Bearings(polars, details, shown, before)]
    else:
        blocks_after = [_block(chart, shown, before) for chart in details.values()]
    blocks += [_block(block, shown, before) for block in part.blocks if block not in polars and block not in details.values()]
    return Section(part.title, [*blocks, *blocks_after], part.inputs, part.note)


def figure_of(figure: described.Figure) -> Figure:
    """A number with its unit as a page shows it."""
    return Figure(figure.name, " ".join(filter(None, text.value(figure, DIGITS))), text.remark(figure, DIGITS))


def _block(block: described.Block, shown: Shown, before: Before | None) -> Block:
    old = None if before is None else before.charts.get(getattr(block, "name", ""))
    if isinstance(block, described.Chart):
        return line_chart(block, shown, old if isinstance(old, described.Chart) else None, before)
    if isinstance(block, described.Bars):
        return _bars(block, old if isinstance(old, described.Bars) else None)
    if isinstance(block, described.Map):
        return _map(block)
    assert isinstance(block, described.Table)
    return table(block)


def table(block: described.Table) -> Table:
    """A table with one unit and one number of decimals a column."""
    heads, rows = text.cells(block, DIGITS)
    words = [all(cell is None or isinstance(cell, str) for cell in column.cells) for column in block.columns]
    left = next((k for k, flush in enumerate(words) if not flush), len(words))
    shortened = [row if row is not None else ["...", *[""] * (len(heads) - 1)] for row in tables.shortened(rows, block.most)]
    return Table(block.title, heads, shortened, words=left, note=block.note)


# ------------------------------------------------------------------------------------------------------------------------------- curves


@dataclass(frozen=True, eq=False)
class _States:
    """How the states of a motion are drawn on a page.

    Attributes:
        drawn: (c,) indices of those on curves along the page's own abscissa.
        keys: (k,) indices of those at the key frames.
        x: (c,) places of the first; None: those of the key frames.
    """

    drawn: NDArray[np.intp]
    keys: NDArray[np.intp]
    x: Array | None


def _states(of: object, shown: Shown) -> _States | None:
    """How the states of a motion are drawn if it is that of the page; else None."""
    if of is None:
        return None
    if of is shown.drawn.motion:
        return _States(shown.states, shown.keys, shown.own_along)
    if of is shown.motion:
        return _States(shown.frames.states, shown.frames.states, None)
    return None


def line_chart(chart: described.Chart, shown: Shown, old: described.Chart | None, before: Before | None) -> LineChart:
    """A chart with its counterpart of the press before dashed; thinned to the states of the page if its points are these."""
    known = {} if old is None else {curve.name: curve for curve in old.curves}
    states = _states(chart.along.of, shown)
    along = states is not None and chart.along.values is not None
    follows = "frames" if along else _follows(chart, shown)
    up = quantity(chart.quantity).scale(_sizes([*chart.curves, *known.values()]), chart.reference)
    across, unit = _across(chart, follows)
    if chart.square:  # one scale for both
        places = (float(np.abs(curve.x).max()) for curve in chart.curves if curve.x is not None and len(curve.x))
        up = quantity(chart.quantity).scale([*_sizes(chart.curves), *places])
        across, unit = up.factor, up.unit
    lines = []
    for curve in chart.curves:
        line = _line(curve, chart, states, across, up.factor, follows, shown)
        other = known.get(curve.name)
        if along and other is not None and before is not None and curve.x is None:
            its = _states(old.along.of, before.shown) if old is not None else None
            line = replace(line, before=up.factor * other.y[before.shown.states if its is None else its.drawn])
        lines.append(line)
    name = chart.along.name + (f" [{unit}]" if unit else "")
    reach = None if any(end is None for end in chart.reach) else tuple(across * end for end in chart.reach if end is not None)
    marks = [
        (mark.name, mark.axis, [(across if mark.axis == "x" else up.factor) * each for each in np.atleast_1d(mark.at).tolist()])
        for mark in chart.marks
    ]
    return LineChart(
        chart.title,
        up.unit,
        lines,
        across="" if along else name,
        follows=follows,
        reach=reach,  # type: ignore[arg-type]  # two ends
        logarithmic=chart.logarithmic,
        stacked=chart.stacked,
        square=chart.square,
        note=chart.note,
        marks=marks,
    )


def _sizes(curves: Sequence[described.Curve]) -> Iterator[float]:
    for curve in curves:
        if len(curve.y) and np.isfinite(curve.y).any():
            yield float(np.nanmax(np.abs(curve.y)))


def _line(
    curve: described.Curve,
    chart: described.Chart,
    states: _States | None,
    across: float,
    up: float,
    follows: Follows,
    shown: Shown,
) -> Line:
    looks: dict[str, Any] = {key: curve.look == look for key, look in LOOKS.items()}
    if states is not None and curve.x is None:
        band = None if curve.band is None else up * curve.band[states.drawn]
        return Line(curve.name, up * curve.y[states.drawn], states.x, band=band, **looks)
    x = chart.along.values if curve.x is None else curve.x
    assert x is not None
    of = chart.along.of
    if states is not None and isinstance(of, Motion) and len(x) == len(of.crank_angle):  # a path that is walked with the recording
        pairs = np.column_stack([across * x, up * curve.y])
        every = np.arange(len(pairs)) if len(pairs) <= MOST_POINTS else states.drawn
        if len(pairs) <= MOST_POINTS and chart.along.period is not None:
            every = np.append(every, 0)
        return Line(curve.name, pairs[every, 1], pairs[every, 0], at_frames=pairs[states.keys], **looks)
    places, values, band = across * x, up * curve.y, None if curve.band is None else up * curve.band
    if chart.along.period is not None and curve.x is None:
        places = np.append(places, places[0] + across * chart.along.period)
        values, band = np.append(values, values[0]), None if band is None else np.concatenate([band, band[:1]])
    if follows == "position" and len(places):  # counted as the cursor is
        turn = 360.0 * (shown.motion.period_turns or 1)
        places = places - turn * np.floor(min(places[0], places[-1]) / turn + SAME)
    return Line(curve.name, values, places, band=band, **looks)


def _follows(chart: described.Chart, shown: Shown) -> Follows:
    """What the cursor of a chart along another quantity than the page's follows."""
    along, first = chart.along, shown.motion.driver_coordinates[0]
    if along.name == HEIGHT:
        return "height" if shown.heights is not None else "nothing"
    if along.name == first.counted and along.quantity == first.unit:
        return "position"
    if along.name == "time" and along.values is not None and along.period is not None and len(shown.frames.time) > 1:
        return "time" if abs(along.period - shown.frames.time[-1]) <= SAME * along.period else "nothing"
    return "nothing"


def _across(chart: described.Chart, follows: Follows) -> tuple[float, str]:
    """Factor and unit of places; those that a cursor follows are in the page's units."""
    fixed = {"height": (1e3, "mm"), "time": (1.0, "s")}
    if follows in fixed:
        return fixed[follows]
    places = [curve.x for curve in chart.curves if curve.x is not None]
    places += [] if chart.along.values is None else [chart.along.values]
    scale = quantity(chart.along.quantity).scale(float(np.abs(x).max()) for x in places if len(x))
    return (1e3, "mm") if follows == "position" and chart.along.quantity == "m" else (scale.factor, scale.unit)


def _bars(chart: described.Bars, old: described.Bars | None) -> BarChart:
    places = list(chart.places)
    if old is not None and places and not isinstance(places[0], str):
        places = sorted({*places, *old.places})  # numbers; one may repeat itself after more turns

    def at_places(bars: described.Bars) -> dict[str, list[float]]:
        known = {name: dict(zip(bars.places, values, strict=True)) for name, values in bars.series.items()}
        return {name: [float(values.get(place, 0.0)) for place in places] for name, values in known.items()}

    series, earlier = at_places(chart), None if old is None else at_places(old)
    scale = quantity(chart.quantity).scale([value for values in (*series.values(), *(earlier or {}).values()) for value in values])

    def scaled(bars: Mapping[str, Sequence[float]]) -> dict[str, list[float]]:
        return {name: [scale.factor * value for value in values] for name, values in bars.items()}

    band = None if chart.band is None else scale.factor * chart.band
    before = None if earlier is None else scaled(earlier)
    return BarChart(chart.title, scale.unit, places, scaled(series), before, chart.across, chart.note, chart.stacked, band)  # type: ignore[arg-type]


def _map(chart: described.Map) -> ColourMap:
    scale = quantity(chart.quantity).scale(np.abs(chart.values[np.isfinite(chart.values)]).tolist())
    names: list[str] = []
    places: list[Any] = []
    for along in (chart.across, chart.up):
        assert along.values is not None
        row = along.values if along.values.ndim == 1 else along.values[-1]
        its = quantity(along.quantity).scale(np.abs(row).tolist(), digits=4)
        names.append(f"{along.name} [{its.unit}]" if its.unit else along.name)
        places.append([its.shown(float(value)) for value in row] if chart.written else (its.factor * row).tolist())
    (across, up), (x, y) = names, places
    return ColourMap(chart.title, scale.unit, across, up, x, y, scale.factor * chart.values, chart.written, chart.note)


@dataclass(frozen=True, eq=False)
class Bearings:
    """Components and polar diagrams of one bearing at a time, which the reader chooses.

    Attributes:
        polars: polar diagrams of the bearings.
        charts: charts of the components of their forces by names.
        shown: what the page shows.
        before: the press before; None for none.
    """

    polars: Sequence[described.Polar]
    charts: Mapping[str, described.Chart]
    shown: Shown
    before: Before | None

    def as_json(self) -> dict[str, Any]:
        """The bearings as a page is given them."""
        return {"kind": "bearings", "bearings": [self._bearing(polar) for polar in self.polars]}

    def _bearing(self, polar: described.Polar) -> dict[str, Any]:
        chart = self.charts[polar.name.replace("polar ", "components ", 1)]
        old = None if self.before is None else self.before.charts.get(polar.name)
        scale = quantity(polar.quantity).scale(np.abs(polar.world).max(axis=0).tolist())
        bearing: dict[str, Any] = {"name": polar.title, "link": polar.link, "axes": polar.axes, "unit": scale.unit, "before": None}
        frames = self.shown.frames.states
        bearing |= {"frame": packed(scale.factor * polar.world[frames], polar.title)}
        bearing |= {"own": packed(scale.factor * polar.own[frames], polar.title)}
        components = None
        if self.before is not None and isinstance(old, described.Polar):
            components = self.before.charts.get(chart.name)
            if old.axes == polar.axes:
                states = self.before.shown.frames.states
                bearing["before"] = {
                    "frame": packed(scale.factor * old.world[states], polar.title),
                    "own": packed(scale.factor * old.own[states], polar.title),
                }
        return bearing | {"open": polar.note, "components": line_chart(chart, self.shown, components, self.before).as_json()}
