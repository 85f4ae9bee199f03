"""Motion, torques and forces in reports: their charts, a second press dashed beside them, and their extremes."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...common.quantities import Array
from ...dynamics.extremes import AXES, ExtremeValues, at_peaks, extremes, rounding
from ...dynamics.harmonics import HarmonicAnalysis, harmonics, is_cycle
from ...dynamics.reactions import Reactions
from ...kinematics.slide_path import slide_turns, stroke_turns
from ...simulation.run import Run
from .. import charts
from ..charts import Chart, Locus
from ..pages import packed
from . import driving
from .blocks import BarChart, Block, Figure, Line, LineChart, Section, Table, alike, with_prefix
from .shown import Shown

if TYPE_CHECKING:
    from ...ratings.rating import PressRatings

MOST_POINTS = 5000  # states of which each is a point of the process force over the height
HEIGHT = "slide height"
DIGITS = {"deg": 1, "mm": 1, "s": 4}  # behind the point, of places by their unit


def sections(shown: Shown, before: Shown | None, ratings: PressRatings | None) -> list[Section]:
    """Sections of motion and reactions, without the table of extremes."""
    reactions, other = shown.reactions, {} if before is None else {chart.title: chart for chart in _charts(before)}
    motion, heights, curves = reactions.motion, _force_over_height(shown, ratings), shown.drawn

    def drawn(*some: Chart | None) -> list[Block]:
        return [_line_chart(chart, shown, other.get(chart.title), before) for chart in some if chart is not None]

    run = [*driving.motor(motion, shown.frames), *driving.strokes(motion)] if isinstance(motion, Run) else []
    bearings: list[Block] = [_Bearings(shown, before)] if shown.press.bearings else []
    found = harmonics_chart(reactions, None if before is None else before.reactions)
    named: list[tuple[str, list[Block]]] = [
        ("Slide", drawn(*charts.slide(curves.motion, shown.bottom))),
        ("Process", [*drawn(charts.process(curves)), *heights]),
        ("Drive", [*drawn(*charts.driving(curves), *charts.driver_speeds(curves.motion)), *run, *driving.energy(reactions)]),
        ("Bearings and guides", [*drawn(charts.bearing(curves), charts.bearing_moment(curves)), *bearings]),
        ("Foundation", [*drawn(charts.shaking(curves), charts.shaking_moment(curves)), *([] if found is None else [found])]),
    ]
    return [Section(title, blocks) for title, blocks in named if blocks]


def _charts(shown: Shown) -> list[Chart]:
    """All charts of a motion and its reactions."""
    reactions = shown.drawn
    some = [
        *charts.slide(reactions.motion, shown.bottom),
        charts.process(reactions),
        *charts.driving(reactions),
        *charts.driver_speeds(reactions.motion),
        charts.bearing(reactions),
        charts.bearing_moment(reactions),
        charts.shaking(reactions),
        charts.shaking_moment(reactions),
    ]
    return [chart for chart in some if chart is not None]


def _line_chart(chart: Chart, shown: Shown, other: Chart | None, before: Shown | None) -> LineChart:
    """A chart of what is drawn of a motion, its counterpart of the press before dashed."""
    dashed: dict[str, Array] = {}
    if other is not None and before is not None:
        factor = charts.factor(chart.quantity, chart.unit) / charts.factor(other.quantity, other.unit)
        dashed = {curve.name: factor * curve.values[before.states] for curve in other.curves}
    lines = [Line(curve.name, curve.values[shown.states], shown.own_along, dashed.get(curve.name)) for curve in chart.curves]
    return LineChart(chart.title, chart.unit, lines)


def _force_over_height(shown: Shown, ratings: PressRatings | None) -> list[Block]:
    """Process force and permissible force over the height; nothing without a process."""
    chart, keys = charts.force_over_height(shown.drawn), shown.keys
    if chart is None:
        return []
    closed = np.append(np.arange(len(chart.height)), 0 if is_cycle(shown.motion) else [])
    every = closed.astype(int) if len(closed) <= MOST_POINTS else shown.states
    at_frames = np.column_stack([chart.height[keys], chart.force[keys]])
    lines = [Line("process force", chart.force[every], chart.height[every], at_frames=at_frames)]
    if ratings is not None:
        lines.append(Line("permissible force", charts.factor("force", chart.unit) * ratings.force, 1e3 * ratings.height))
    axis = "height above bottom dead centre" if chart.above_bottom else "height above the lowest state"
    follows: Any = "height" if chart.above_bottom else "nothing"
    return [LineChart("Force over the height", chart.unit, lines, across=f"{axis} [mm]", follows=follows, reach=(0.0, chart.reach))]


@dataclass(frozen=True, eq=False)
class _Bearings:
    """Components and polar diagrams of one bearing at a time, which the reader chooses.

    Attributes:
        shown: What the page shows.
        before: The press before; None for none.
    """

    shown: Shown
    before: Shown | None

    def as_json(self) -> dict[str, Any]:
        reactions, before = self.shown.reactions, {}
        if self.before is not None:
            names = list(self.before.reactions.bearing_force)
            before = dict(zip(names, charts.loci(self.before.drawn, names), strict=True))
        found = charts.loci(reactions, self.shown.press.bearings_as_drawn)
        return {"kind": "bearings", "bearings": [self._bearing(locus, before.get(locus.bearing)) for locus in found]}

    def _bearing(self, locus: Locus, old: Locus | None) -> dict[str, Any]:
        """A bearing, whose locus was ``old`` before; None where there was none."""
        reactions, frames, name, other = self.shown.reactions, self.shown.frames, locus.bearing, None
        bearing: dict[str, Any] = {"name": name, "link": locus.link, "axes": locus.axes, "unit": locus.unit, "before": None}
        bearing |= {key: packed(getattr(locus, key)[frames.states], name) for key in ("frame", "own")}
        if self.before is not None and old is not None:
            other = charts.components(self.before.drawn, name)
            if old.axes == locus.axes:
                factor = charts.factor("force", locus.unit) / charts.factor("force", old.unit)
                bearing["before"] = {key: packed(factor * getattr(old, key)[self.before.states], name) for key in ("frame", "own")}
        components = _line_chart(charts.components(self.shown.drawn, name), self.shown, other, self.before)
        return bearing | {"open": _left_open(reactions, name), "components": components.as_json()}


def _left_open(reactions: Reactions, name: str) -> str:
    """What rigid mechanics does not decide of a bearing, and is not zero, in words; empty where there is nothing."""
    least = rounding(reactions)
    axes = reactions.indeterminate_axes.T
    sizes = [np.abs(vector @ axes).max(axis=0) for vector in (reactions.bearing_force[name], reactions.bearing_moment[name])]
    shown = np.concatenate([sizes[0] > least.force, sizes[1] > least.moment]) & reactions.indeterminate[name]
    names = AXES if np.array_equal(axes, np.eye(3)) else ("h", "across the plane", "u")
    components = [f"{kind} {axis}" for kind in ("force", "moment") for axis in names]
    return ", ".join(itertools.compress(components, shown))


def harmonics_chart(reactions: Reactions, before: Reactions | None) -> BarChart | None:
    """Amplitudes of the shaking force by axis, those that are not zero; None where the motion has no full period."""
    found = harmonics(reactions.motion, reactions.shaking_force)
    if found is None:
        return None
    other = None if before is None else harmonics(before.motion, before.shaking_force)
    chart = charts.shaking(reactions)
    factor = charts.factor(chart.quantity, chart.unit)
    every = sorted({*found.orders[1:], *([] if other is None else other.orders[1:])})  # one may repeat itself after more turns

    def bars(shown: HarmonicAnalysis) -> dict[str, list[float]]:
        amplitude = dict(zip(shown.orders, factor * shown.amplitude, strict=True))
        none = np.zeros(3)
        return {curve.name: [float(amplitude.get(order, none)[AXES.index(curve.name)]) for order in every] for curve in chart.curves}

    return BarChart(
        "Harmonics of the shaking force",
        chart.unit,
        [int(order) if order.is_integer() else float(order) for order in every],
        bars(found),
        None if other is None else bars(other),
        across="order of the crank's speed",
    )


# --------------------------------------------------------------------------------------------------------------------------------- extremes


def figures(shown: Shown) -> list[Figure]:
    """What is looked for first."""
    values = _extremes(shown)
    by_name, unit = {value.quantity: value for value in values}, values[0].units["smallest_at"]
    found = []
    if travel := by_name.get(HEIGHT) or by_name.get("slide position"):
        found.append(Figure("slide travel", with_prefix(1e-3 * travel.range, "m")))
    efforts = [f"driving {kind}" for kind in dict.fromkeys(each.effort for each in shown.motion.driver_coordinates)]
    of_drivers = [(f"largest {effort}", [value for value in values if value.quantity.startswith(effort)]) for effort in efforts]
    forces = [value for value in values if value.quantity.startswith("force in ") and value.quantity.endswith(", magnitude")]
    for name, some in (*of_drivers, ("largest bearing force", forces)):
        if some:
            most = max(some, key=lambda value: max(abs(value.smallest), abs(value.largest)))
            size, at = max((abs(most.smallest), most.smallest_at), (abs(most.largest), most.largest_at))
            whose = most.quantity.removeprefix("force in ").removesuffix(", magnitude")
            whose = whose if some is forces else whose.partition(" of ")[2]
            place = f"at {at:.{DIGITS[unit]}f}{'°' if unit == 'deg' else f' {unit}'}{_remark_at(shown.reactions, unit, at)}"
            found.append(Figure(name, with_prefix(size, most.unit), f"{whose}, {place}" if whose else place))
    for axis in "xyz":
        if value := by_name.get(f"shaking force, {axis}"):
            found.append(Figure(f"shaking force {axis}, range", with_prefix(value.range, value.unit)))
    return [*found, *_work_of_process(shown.reactions)]


def _remark_at(reactions: Reactions, unit: str, at: float) -> str:
    """What is at a place of the table of extremes, as ", where the load begins"; mostly nothing."""
    found = at_peaks(reactions)
    places = found.reactions.motion.time if unit == "s" else found.reactions.motion.shown_position
    remark = found.remarks[int(np.abs(places - at).argmin())] if places.ndim == 1 else ""
    return f", {remark}" if remark else ""


def _work_of_process(reactions: Reactions) -> list[Figure]:
    """The work of the process, by strokes where the motion is one period."""
    if not reactions.process_force.any():
        return []
    work, turns, when = reactions.process_work, stroke_turns(reactions._press), "over the motion"
    if is_cycle(reactions.motion) and turns is not None and reactions.motion.period_turns is not None:
        differ = "a stroke" if turns == slide_turns(reactions._press) else "a stroke, on average"
        work, when = work * turns / reactions.motion.period_turns, differ
    return [Figure("work of the process", with_prefix(work, "J"), when)]


def _extremes(shown: Shown) -> list[ExtremeValues]:
    """The extremes, with the slide's height above bottom dead centre in place of its position."""
    found = []
    for value in extremes(shown.reactions):
        if value.quantity == "slide position" and shown.bottom is not None:
            height = 1e3 * (shown.motion.slide_position - shown.bottom)
            smallest, largest = (1e3 * (1e-3 * each - shown.bottom) for each in (value.smallest, value.largest))
            rms = float(np.sqrt(np.mean(height**2)))
            value = replace(value, quantity=HEIGHT, smallest=smallest, largest=largest, rms=rms)
        found.append(value)
    return found


def table_of_extremes(shown: Shown, before: Shown | None) -> Section:
    """Extremes over all states, in the units of the charts, with the ranges of the press before."""
    values = _extremes(shown)
    known = {} if before is None else {value.quantity: value for value in _extremes(before)}
    at = f"at [{values[0].units['smallest_at']}]"
    heads = ["", "smallest", at, "largest", at, "range", *([] if before is None else ["before", "change"]), "rms"]
    units, rows = _units(shown), []
    for value in values:
        unit, factor = units.get(value.quantity) or units.get(value.quantity.rpartition(", ")[0]) or (value.unit, 1.0)
        others = [] if before is None or value.quantity not in known else [known[value.quantity].range]
        numbers = alike([factor * each for each in (value.smallest, value.largest, value.range, value.rms, *others)])
        beside = [] if before is None else [*numbers[4:], _change(value, *others)] if others else ["", ""]
        digits = DIGITS[value.units["smallest_at"]]
        places = (f"{value.smallest_at:.{digits}f}", f"{value.largest_at:.{digits}f}")
        rows.append([f"{value.quantity} [{unit}]", numbers[0], places[0], numbers[1], places[1], numbers[2], *beside, numbers[3]])
    return Section("Extremes", [Table("", heads, rows)])


def _change(value: ExtremeValues, before: float) -> str:
    """By how much a range changed."""
    return f"{100 * (value.range / before - 1):+.2f} %" if before else ""


def _units(shown: Shown) -> dict[str, tuple[str, float]]:
    """Units of the charts, and the number of it in the unit of `extremes`, by the first words of a quantity's name."""
    reactions, found = shown.drawn, dict[str, tuple[str, float]]()

    def take(chart: Chart | None, *names: str) -> None:
        if chart is not None and chart.quantity in ("force", "torque", "moment"):
            found.update(dict.fromkeys(names, (chart.unit, charts.factor(chart.quantity, chart.unit))))

    for chart in charts.driving(reactions):
        efforts = [f"{what} {chart.quantity}" for what in ("driving", "drive")]
        take(chart, *efforts, *(f"{effort} of {driver}" for effort in efforts for driver in reactions.motion.drivers))
    take(charts.bearing(reactions), *(f"force in {name}" for name in reactions.bearing_force))
    take(charts.bearing_moment(reactions), *(f"moment in {name}" for name in reactions.bearing_force))
    take(charts.shaking(reactions), "shaking force")
    take(charts.shaking_moment(reactions), "shaking moment")
    return found
