"""Sections of results as a page draws them (`templates/report.js`): with chosen units, states thinned to those of the page, and the
quantity that a chart's cursor follows."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

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
from .shown import Shown, refuse_others

DIGITS = 5  # digits of numbers on a page
STRIPS = ("height", "torque", "driving_force", "process")  # charts that a page shows first, low and one below the other
SAME = 1e-6  # rounding errors may put an angle beyond its period by this share of a period

Follows = Literal["frames", "position", "height", "time", "nothing"]
"""The quantity of the recording that a chart's cursor follows: key frames, the driver's position within the period [deg or mm], the slide's
height [mm], the time [s], or nothing."""


def sections_of(result: Tabular, page: Shown) -> Sequence[described.Section]:
    """The sections of a result.

    Raises:
        PinpressError: the result has no sections, or is of another press.
    """
    if isinstance(result, OfPress):
        refuse_others(type(result).__name__, result._press, page)
    sections = result.described(page.reactions)
    if not sections:
        raise PinpressError(
            f"results: a report has no section for {text_of(result)}; give results that have some, as ratings, runs or budgets"
        )
    for part in sections:
        if part.press is not None:
            refuse_others(part.of, part.press, page)  # type: ignore[arg-type]  # a linkage
    return sections


def section(part: described.Section, shown: Shown, before: Shown | None = None, *, headlines: bool = True) -> dict[str, Any]:
    """A section as a page draws it.

    Args:
        part: the section.
        shown: the moving press of the page.
        before: the press before, whose curves are dashed; None for none.
        headlines: whether the section contains its most important figures; otherwise the page shows them at its top.

    Raises:
        PinpressError: a number is not finite.
    """
    figures = [figure(each) for each in part.figures if headlines or not each.kind]
    polars = [block for block in part.blocks if isinstance(block, described.Polar)]
    # the table of the bearings has a curve in each row, and their peaks as numbers: one chart of all would not tell them apart
    sizes = next((block for block in part.blocks if isinstance(block, described.Chart) and block.name == "bearings"), None)
    small = {} if sizes is None or not polars else {curve.name: curve.y for curve in sizes.curves}
    if small:
        part = replace(part, blocks=[block for block in part.blocks if block.name not in ("bearings", "peaks")])
    details = {block.name: block for block in part.blocks if isinstance(block, described.Chart) and block.detail}
    blocks = [{"kind": "figures", "figures": figures}] if figures else []
    for block in part.blocks:
        if block not in polars and block not in details.values():
            drawn = _block(block, shown, before)
            if block.name in STRIPS and not headlines and drawn.get("follows") == "frames":
                drawn["strip"] = True
            if small and block.name == "bearings_at_peak":
                drawn["curves"] = [packed(small[row[0]][shown.keys], row[0]) if row[0] in small else "" for row in drawn["rows"]]
            blocks.append(drawn)
    if polars:
        blocks.append({"kind": "bearings", "bearings": [_bearing(polar, details, shown, before) for polar in polars]})
    else:
        blocks += [_block(chart, shown, before) for chart in details.values()]
    return {"title": part.title, "note": part.note, "blocks": blocks}


def figure(number: described.Figure) -> dict[str, str]:
    """A number with its unit and its note."""
    value = " ".join(filter(None, text.value(number, DIGITS)))
    return {"name": number.name, "value": value, "at": text.remark(number, DIGITS)}


def table(title: str, heads: Sequence[str], rows: Sequence[Sequence[str]], words: int = 1, note: str = "") -> dict[str, Any]:
    """A table of finished cells; the first ``words`` columns are flush left."""
    return {"kind": "table", "title": title, "heads": heads, "rows": rows, "words": words, "note": note}


def _block(block: described.Block, shown: Shown, before: Shown | None) -> dict[str, Any]:
    old = None if before is None else before.charts.get(block.name)
    if isinstance(block, described.Chart):
        return _line_chart(block, shown, old if isinstance(old, described.Chart) else None, before)
    if isinstance(block, described.Bars):
        return _bars(block, old if isinstance(old, described.Bars) else None)
    if isinstance(block, described.Map):
        return _map(block)
    assert isinstance(block, described.Table)
    heads, rows = text.cells(block, DIGITS)
    flush = [all(cell is None or isinstance(cell, str) for cell in column.cells) for column in block.columns]
    left = next((k for k, words in enumerate(flush) if not words), len(flush))
    gap = [tables.GAP, *[""] * (len(heads) - 1)]
    return table(block.title, heads, [gap if row is None else row for row in tables.shortened(rows, block.most)], left, block.note)


# ------------------------------------------------------------------------------------------------------------------------------- curves


@dataclass(frozen=True, eq=False)
class Line:
    """A curve in the units of its chart.

    Attributes:
        name: its name.
        look: how it is drawn.
        y: (m,) values.
        x: (m,) x values; None for those of the key frames.
        at_frames: (k, 2) x and y at the key frames, for a curve that is not a function of x; None if the cursor reads the value from the
            curve.
        band: (m, 2) ends of a band around the curve; None: no band.
        before: (b,) values of the press before, over its own abscissa; None: no such values.
    """

    name: str
    look: described.Look
    y: Array
    x: Array | None = None
    at_frames: Array | None = None
    band: Array | None = None
    before: Array | None = None


def _states(of: object, shown: Shown) -> tuple[NDArray[np.intp], NDArray[np.intp], Array | None] | None:
    """For the motion of the page: indices of the states on curves (c,) and at the key frames (k,), and the x values (c,) of the first, None
    for those of the key frames. None for other motions."""
    if of is shown.drawn.motion:
        return shown.states, shown.keys, shown.own_along
    return (shown.frames.states, shown.frames.states, None) if of is shown.motion else None


def _line_chart(chart: described.Chart, shown: Shown, old: described.Chart | None, before: Shown | None) -> dict[str, Any]:
    """A chart, with the chart of the press before as dashed curves. It is thinned to the states of the page if its points are states of the
    page's motion."""
    known = {} if old is None else {curve.name: curve for curve in old.curves}
    along = _states(chart.along.of, shown) is not None and chart.along.values is not None
    follows = "frames" if along else _follows(chart, shown)
    up = quantity(chart.quantity).scale(_sizes([*chart.curves, *known.values()]), chart.reference)
    across, unit = _across(chart, follows)
    if chart.square:  # the same scale for both axes
        places = (float(np.abs(curve.x).max()) for curve in chart.curves if curve.x is not None and len(curve.x))
        up = quantity(chart.quantity).scale([*_sizes(chart.curves), *places])
        across, unit = up.factor, up.unit
    lines = []
    for curve in chart.curves:
        other, dashed = known.get(curve.name), None
        if along and other is not None and old is not None and before is not None and curve.x is None:
            its = _states(old.along.of, before)
            dashed = None if its is None else up.factor * other.y[its[0]]
        lines.append(_line(curve, chart, across, up.factor, follows, shown, dashed))
    under = {} if chart.stacked else covered(lines)
    above: dict[int, list[str]] = {}
    for upper, lower in under.items():
        above.setdefault(lower, []).append(lines[upper].name)
    notes = [chart.note] if chart.note else []
    for lower, names in above.items():
        lie, are = ("lies", "is") if len(names) == 1 else ("lie", "are")
        notes.append(f"{', '.join(names)} {lie} on {lines[lower].name} and {are} dotted")
    sizes = {"x": across, "y": up.factor}
    return {
        "kind": "lines",
        "title": chart.title,
        "unit": up.unit,
        "across": "" if along else chart.along.name + (f" [{unit}]" if unit else ""),
        "follows": follows,
        "reach": None if None in chart.reach else [across * end for end in chart.reach if end is not None],
        "logarithmic": chart.logarithmic,
        "stacked": chart.stacked,
        "square": chart.square,
        "note": "; ".join([*([chart.note.rstrip(".")] if chart.note and len(notes) > 1 else notes[:1]), *notes[1:]]),
        "marks": [
            {"name": mark.name, "axis": mark.axis, "at": [sizes[mark.axis] * each for each in np.atleast_1d(mark.at).tolist()]}
            for mark in chart.marks
        ],
        "curves": [_curve(chart.title, line, k in under, k in above) for k, line in enumerate(lines)],
    }


def _curve(title: str, line: Line, dotted: bool, wide: bool) -> dict[str, Any]:
    what = f"{title}, {line.name}"
    look = {"guide": "pale", "line": "", "points": ""}.get(line.look, line.look)
    optional = {"x": line.x, "before": line.before, "at_frames": line.at_frames}
    return {
        "name": line.name,
        "y": packed(line.y, what),
        **{name: None if values is None else packed(values, what) for name, values in optional.items()},
        "points": line.look == "points",
        "band": None if line.band is None else [packed(end, what) for end in line.band.T],
        "look": "dotted" if dotted else look or ("wide" if wide else ""),
    }


def covered(lines: Sequence[Line]) -> dict[int, int]:
    """Index of each curve that coincides with an earlier curve -> index of the first such curve; curves of zeros count too."""
    width = float(np.ptp(np.concatenate([line.y for line in lines])))
    lower: dict[int, int] = {}
    for k, upper in enumerate(lines):
        for i, other in enumerate(lines[:k]):
            # curves that differ by less than 0.4 % of the chart's range coincide within the width of a line
            if i not in lower and _along_the_same(upper, other) and np.abs(upper.y - other.y).max() <= 4e-3 * width:
                lower[k] = i
                break
    return lower


def _along_the_same(one: Line, other: Line) -> bool:
    if not 0 < len(one.y) == len(other.y) or "points" in (one.look, other.look):
        return False
    return one.x is other.x or (one.x is not None and other.x is not None and np.array_equal(one.x, other.x))


def _sizes(curves: Sequence[described.Curve]) -> Iterator[float]:
    for curve in curves:
        if len(curve.y) and np.isfinite(curve.y).any():
            yield float(np.nanmax(np.abs(curve.y)))


def _line(
    curve: described.Curve, chart: described.Chart, across: float, up: float, follows: Follows, shown: Shown, dashed: Array | None
) -> Line:
    """A curve, with x values multiplied by ``across`` and y values by ``up``."""
    of, period = chart.along.of, chart.along.period
    states = _states(of, shown)
    x, y, band = curve.x, up * curve.y, None if curve.band is None else up * curve.band
    if states is not None and x is None:
        drawn, _, places = states
        return Line(curve.name, curve.look, y[drawn], places, None, None if band is None else band[drawn], dashed)
    x = chart.along.values if x is None else x
    assert x is not None
    x = across * x
    if states is not None and isinstance(of, Motion) and len(x) == len(of.crank_angle):  # a marker moves along this path
        drawn, keys, _ = states
        if len(x) <= 5000:  # each state is a point of the curve
            drawn = np.append(np.arange(len(x)), [] if period is None else 0).astype(int)
        return Line(curve.name, curve.look, y[drawn], x[drawn], np.column_stack([x, y])[keys])
    if period is not None and curve.x is None:
        x, y = np.append(x, x[0] + across * period), np.append(y, y[0])
        band = None if band is None else np.concatenate([band, band[:1]])
    if follows == "position" and len(x):  # counted like the cursor: from 0 up, or from 0 down if the driver turns in the negative direction
        turn = 360.0 * (shown.motion.period_turns or 1)
        if shown.period is not None and shown.period < 0:
            way = slice(None) if x[-1] < x[0] else slice(None, None, -1)  # in the order of the time
            x, y, band = x[way] - turn * np.floor(x.max() / turn + SAME), y[way], None if band is None else band[way]
        else:
            x = x - turn * np.floor(min(x[0], x[-1]) / turn + SAME)
    return Line(curve.name, curve.look, y, x, band=band)


def _follows(chart: described.Chart, shown: Shown) -> Follows:
    """The quantity that the cursor follows, for a chart whose abscissa is not that of the page."""
    along, first = chart.along, shown.motion.driver_coordinates[0]
    if along.name == "height above bottom dead centre":
        return "height" if shown.heights is not None else "nothing"
    if along.name == first.counted and along.quantity == first.unit:
        return "position"
    if along.name == "time" and along.values is not None and along.period is not None and len(shown.frames.time) > 1:
        return "time" if abs(along.period - shown.frames.time[-1]) <= SAME * along.period else "nothing"
    return "nothing"


def _across(chart: described.Chart, follows: Follows) -> tuple[float, str]:
    """Factor and unit of the x values; a quantity that the cursor follows has the page's unit."""
    if follows == "height" or (follows == "position" and chart.along.quantity == "m"):
        return 1e3, "mm"
    if follows == "time":
        return 1.0, "s"
    places = [chart.along.values, *(curve.x for curve in chart.curves)]
    scale = quantity(chart.along.quantity).scale(float(np.abs(x).max()) for x in places if x is not None and len(x))
    return scale.factor, scale.unit


# --------------------------------------------------------------------------------------------------------------- bars, maps and bearings


def _bars(chart: described.Bars, old: described.Bars | None) -> dict[str, Any]:
    """Bars, with those of the press before at the same places."""
    places = list(chart.places)
    if old is not None and places and not isinstance(places[0], str):
        places = sorted({*places, *old.places})  # numbers; one press may have a longer period
    both = [chart] if old is None else [chart, old]
    scale = quantity(chart.quantity).scale([float(value) for bars in both for values in bars.series.values() for value in values])

    def at_places(bars: described.Bars) -> dict[str, list[float]]:
        known = {name: dict(zip(bars.places, values, strict=True)) for name, values in bars.series.items()}
        return {name: [float(scale.factor * values.get(place, 0.0)) for place in places] for name, values in known.items()}

    return {
        "kind": "bars",
        "stacked": chart.stacked,
        "band": None if chart.band is None else (scale.factor * chart.band).tolist(),
        "title": chart.title,
        "unit": scale.unit,
        "places": places,
        "bars": at_places(chart),
        "before": None if old is None else at_places(old),
        "across": chart.across,
        "note": chart.note,
    }


def _map(chart: described.Map) -> dict[str, Any]:
    """Values as colours over two quantities. A page draws them on a grid; for rays, each grid point gets the nearest value."""
    scale = quantity(chart.quantity).scale(np.abs(chart.values[np.isfinite(chart.values)]).tolist())
    x, y, values = chart.across.values, chart.up.values, scale.factor * chart.values
    assert x is not None
    assert y is not None
    if y.ndim == 2:
        x, y, values = _on_a_grid(x, y, values)
    names, places, factors = [], [], []
    for along, row in ((chart.across, x), (chart.up, y)):
        its = quantity(along.quantity).scale(np.abs(row).tolist(), digits=4)
        factors.append(its.factor)
        names.append(f"{along.name} [{its.unit}]" if its.unit else along.name)
        places.append([its.shown(float(value)) for value in row] if chart.written else (its.factor * row).tolist())
    rows = [[None if np.isnan(value) else float(value) for value in row] for row in values]
    words = {"title": chart.title, "unit": scale.unit, "across": names[0], "up": names[1], "note": chart.note}
    points = [
        {"name": curve.name} | {axis: (factor * at).tolist() for axis, factor, at in zip("xy", factors, (curve.x, curve.y), strict=True)}
        for curve in chart.curves
        if curve.x is not None
    ]
    return {"kind": "map", **words, "x": places[0], "y": places[1], "values": rows, "written": chart.written, "points": points}


def _on_a_grid(x: Array, y: Array, values: Array) -> tuple[Array, Array, Array]:
    """Coordinates (n,) and (k,), and values (k, n), for n rays (n, m) with one x each; NaN beyond the end of a ray.

    The grid is as fine as the finest ray, up to the 600 places that a screen can show.
    """
    rows = min(600, 1 + math.ceil(np.ptp(y) / np.diff(y).min() - 1e-9))
    up = np.linspace(y.min(), y.max(), rows)
    grid = np.full((rows, len(y)), np.nan)
    for ray, (heights, numbers) in enumerate(zip(y, values, strict=True)):
        inside = up <= heights[-1] * (1 + 1e-9)
        grid[inside, ray] = numbers[np.abs(up[inside, None] - heights).argmin(axis=1)]
    return x[:, 0], up, grid


def _bearing(polar: described.Polar, details: Mapping[str, described.Chart], shown: Shown, before: Shown | None) -> dict[str, Any]:
    """Components and polar diagrams of one bearing; the reader chooses which bearing is drawn."""
    chart = details[polar.name.replace("polar ", "components ", 1)]
    old = components = None
    if before is not None:
        old, components = before.charts.get(polar.name), before.charts.get(chart.name)
    scale = quantity(polar.quantity).scale(np.abs(polar.world).max(axis=0).tolist())

    def paths(locus: described.Polar, states: NDArray[np.intp]) -> dict[str, str]:
        both = {"frame": locus.world, "own": locus.own}
        return {name: packed(scale.factor * path[states], polar.title) for name, path in both.items()}

    comparable = before is not None and isinstance(old, described.Polar) and old.axes == polar.axes
    return {
        "name": polar.title,
        "link": polar.link,
        "axes": polar.axes,
        "unit": scale.unit,
        "before": paths(old, before.frames.states) if comparable else None,  # type: ignore[union-attr,arg-type]
        **paths(polar, shown.frames.states),
        "open": polar.note,
        "components": _line_chart(chart, shown, components if isinstance(components, described.Chart) else None, before),
    }
