"""A report: one web page with the recording of a press, and charts of its motion, torque and forces that follow it."""

from __future__ import annotations

import itertools
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..common import files
from ..common.arguments import expect, typed
from ..common.errors import PinpressError
from ..common.quantities import RPM
from ..dynamics.extremes import AXES, ExtremeValues, extremes, rounding
from ..dynamics.harmonics import HarmonicAnalysis, harmonics, is_cycle
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..kinematics.motion import Motion
from ..kinematics.slide_path import stroke_turns
from ..linkage.linkage import Linkage
from ..simulation.run import Run, inputs_of
from . import charts, pages
from .charts import Chart
from .pages import packed
from .recording import KeyFrames, key_frames, scene

if TYPE_CHECKING:
    from ..ratings.rating import PressRatings

MOST_POINTS = 5000  # states of which each is a point of the process force over the height


@typed
def report(
    press: Linkage,
    motion: Motion,
    path: str | os.PathLike[str],
    *,
    reactions: Reactions | None = None,
    traces: Sequence[tuple[str, ArrayLike]] = (),
    before: Reactions | None = None,
    ratings: PressRatings | None = None,
) -> Path:
    """Write a self-contained page with the recording (see `record`) and interactive charts whose cursor follows it; return its path.

    The charts show slide position, velocity and acceleration; driving torque, and crank speed where it is not constant; every bearing and
    guide force, its magnitude, components, and polar diagrams in the world's axes and in those of the link on which it acts; moments in
    guides; shaking force with its harmonics, and shaking moment. Under process loads they show these over the crank angle and over the
    slide's height, and their work in a stroke. The page states what it was computed from, with the version and the day. A table lists the
    extremes over all states. Curves have the recording's key frames, at most 360 a turn.

    Args:
        press: As for `record`.
        motion: As for `record`.
        path: Path of the file, as for `record`.
        reactions: Reactions to this motion; by default those without loads and friction. Give them for a run under loads.
        traces: As for `record`.
        before: Reactions of another press, or of this one at another operating point. They are drawn as dashed curves, and the table gives
            their ranges too.
        ratings: Ratings of the press, whose permissible force is drawn beside the process force, over the height.

    Raises:
        PinpressError: As `record`, or a run under loads has no reactions, Plotly is not installed, the ratings are of another press, or
            ``before`` is over another quantity (time or crank angle) than the motion, or turns the other way.
        UnknownNameError: As `record`.
    """
    frames = key_frames(press, motion)
    if reactions is None and isinstance(motion, Run) and any(force.drive is None for force in motion.problem.driven.forces):
        raise PinpressError("the run has loads: give its reactions with them, inverse_dynamics(press, run, loads=[...])")
    if reactions is None:
        reactions = inverse_dynamics(press, motion)
    if before is not None:
        expect("before", before, Reactions, "inverse_dynamics")
    if ratings is not None:
        from ..ratings.rating import PressRatings  # which most reports do without

        expect("ratings", ratings, PressRatings, "ratings.rate")
        ratings.utilisation(reactions)  # refuses those of another press
    data = scene(press, motion, frames, reactions, traces) | {"report": _report(press, reactions, frames, before, ratings)}
    content = pages.page("report.html", press.name, data, {"viewer": pages.meshcat(), "plotly": pages.plotly()})
    return files.write(path, content)


def _report(
    press: Linkage, reactions: Reactions, frames: KeyFrames, before: Reactions | None, ratings: PressRatings | None
) -> dict[str, Any]:
    abscissa = charts.abscissa(reactions.motion)
    over = abscissa.quantity
    other = None if before is None else _other(before, reactions.motion, over)
    values = extremes(reactions)
    return {
        "subtitle": _subtitle(reactions, other),
        "cards": [*_cards(values), *_process_cards(reactions)],
        "inputs": _inputs(reactions, before, ratings),
        "process": _process(reactions, frames, ratings),
        "over": {"quantity": over, "unit": abscissa.unit},
        "before": None if other is None else other["x"],
        "sections": [
            {"title": title, "charts": [_chart(chart, frames, matching) for chart, matching in _paired(all_charts, other, title)]}
            for title, all_charts in _sections(reactions)
        ],
        "bearings": [_bearing(reactions, name, frames, before, other) for name in press.bearings],
        "harmonics": _harmonics(reactions, before),
        "table": _table(values, None if before is None else extremes(before)),
    }


def _sections(reactions: Reactions) -> list[tuple[str, list[Chart]]]:
    speed, moments, process = charts.crank_speed(reactions.motion), charts.bearing_moment(reactions), charts.process(reactions)
    sections = [
        ("Slide", list(charts.slide(reactions.motion))),
        ("Process", [] if process is None else [process]),
        ("Drive", [charts.torque(reactions), *([] if speed is None else [speed])]),
        ("Bearings and guides", [charts.bearing(reactions), *([] if moments is None else [moments])]),
        ("Foundation", [charts.shaking(reactions), charts.shaking_moment(reactions)]),
    ]
    return [(title, some) for title, some in sections if some]


def _other(before: Reactions, motion: Motion, over: str) -> dict[str, Any]:
    """The dashed curves: key frames, abscissas and charts of the reactions before."""
    its = charts.abscissa(before.motion).quantity
    if its != over:
        raise PinpressError(f"before is over {its}, the motion over {over}: compare a cycle with a cycle, or a run with a run")
    frames = key_frames(before._press, before.motion)
    if over != "time" and (motion.crank_angle[-1] > motion.crank_angle[0]) != (frames.crank[-1] > frames.crank[0]):
        raise PinpressError("before turns the other way than the motion: compare two that turn the same way")
    x = frames.time if over == "time" else before.motion.driver_coordinates[0].scale * frames.crank
    words = f"{before._press.name}, {_words(before.motion)}"
    return {"words": words, "frames": frames, "x": packed(x, "before"), "sections": dict(_sections(before))}


def _paired(some: list[Chart], other: dict[str, Any] | None, title: str) -> list[tuple[Chart, tuple[Chart, KeyFrames] | None]]:
    """Charts, each with its counterpart of the reactions before, if there is one."""
    beside = {} if other is None else {chart.title: (chart, other["frames"]) for chart in other["sections"].get(title, ())}
    return [(chart, beside.get(chart.title)) for chart in some]


def _chart(chart: Chart, frames: KeyFrames, beside: tuple[Chart, KeyFrames] | None = None) -> dict[str, Any]:
    before: dict[str, str] = {}
    if beside is not None:
        other, its = beside
        factor = charts.factor(chart.quantity, chart.unit) / charts.factor(other.quantity, other.unit)
        before = {curve.name: packed(factor * curve.values[its.states], chart.title) for curve in other.curves}
    curves = [
        {"name": curve.name, "values": packed(curve.values[frames.states], chart.title), "before": before.get(curve.name)}
        for curve in chart.curves
    ]
    return {"title": chart.title, "unit": chart.unit, "curves": curves}


def _bearing(reactions: Reactions, name: str, frames: KeyFrames, before: Reactions | None, other: dict[str, Any] | None) -> dict[str, Any]:
    locus, beside = charts.locus(reactions, name), None
    bearing: dict[str, Any] = {"name": name, "link": locus.link, "axes": locus.axes, "unit": locus.unit, "before": None}
    bearing |= {key: packed(getattr(locus, key)[frames.states], name) for key in ("frame", "own")}
    if before is not None and other is not None and name in before.bearing_force:
        its, old = other["frames"], charts.locus(before, name)
        beside = (charts.components(before, name), its)
        if old.axes == locus.axes:
            factor = charts.factor("force", locus.unit) / charts.factor("force", old.unit)
            bearing["before"] = {key: packed(factor * getattr(old, key)[its.states], name) for key in ("frame", "own")}
    return bearing | {"open": _left_open(reactions, name), "components": _chart(charts.components(reactions, name), frames, beside)}


def _left_open(reactions: Reactions, name: str) -> str:
    """What rigid mechanics does not decide of a bearing, and is not zero, in words; empty where there is nothing."""
    least = rounding(reactions)
    axes = reactions.indeterminate_axes.T
    sizes = [np.abs(vector @ axes).max(axis=0) for vector in (reactions.bearing_force[name], reactions.bearing_moment[name])]
    shown = np.concatenate([sizes[0] > least.force, sizes[1] > least.moment]) & reactions.indeterminate[name]
    names = AXES if np.array_equal(axes, np.eye(3)) else ("h", "across the plane", "u")
    components = [f"{kind} {axis}" for kind in ("force", "moment") for axis in names]
    return ", ".join(itertools.compress(components, shown))


def _harmonics(reactions: Reactions, before: Reactions | None) -> dict[str, Any] | None:
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

    return {
        "unit": chart.unit,
        "orders": [int(order) if order.is_integer() else float(order) for order in every],
        "amplitude": bars(found),
        "before": None if other is None else bars(other),
    }


def _subtitle(reactions: Reactions, other: dict[str, Any] | None) -> str:
    count = len(reactions.motion.crank_angle)
    beside = "" if other is None else f"; dashed: {other['words']}"
    return f"{_words(reactions.motion)}, {count} {'states' if count > 1 else 'state'}{beside}"


def _words(motion: Motion) -> str:
    """What the motion is."""
    if isinstance(motion, Run):
        return f"simulated run of {motion.time[-1]:.6g} s"
    if motion.crank_speed.ndim == 1 and charts.crank_speed(motion) is None:
        speed = float(motion.crank_speed[0])
        moving = f"crank at {speed / RPM:.6g} r/min" if motion.driver_coordinates[0].turns else f"driver at {1e3 * speed:.6g} mm/s"
        return moving.replace("-", "\u2212")
    return "prescribed motion"


def _inputs(reactions: Reactions, before: Reactions | None, ratings: PressRatings | None) -> list[dict[str, Any]]:
    """What the page was computed from, and the dashed curves."""
    given = [("Inputs", [*inputs_of(reactions)])]
    if ratings is not None:
        from ..ratings.permissible_force import capacities_in_words  # which most reports do without

        given[0][1].extend(capacities_in_words(ratings.capacities, ratings.driver_coordinate))
    if before is not None:
        given.append(("Inputs of the dashed curves", [*inputs_of(before)]))
    return [{"title": title, "rows": [list(row) for row in rows]} for title, rows in given]


def _process(reactions: Reactions, frames: KeyFrames, ratings: PressRatings | None) -> dict[str, Any] | None:
    """Process force and permissible force over the height; None without a process."""
    chart = charts.force_over_height(reactions)
    if chart is None:
        return None
    closed = np.append(np.arange(len(chart.height)), 0 if is_cycle(reactions.motion) else [])
    every = closed.astype(int) if len(closed) <= MOST_POINTS else frames.states
    permissible = None
    if ratings is not None:
        factor = charts.factor("force", chart.unit)
        permissible = {"height": packed(1e3 * ratings.height, "height"), "force": packed(factor * ratings.force, "permissible force")}
    return {
        "unit": chart.unit,
        "axis": "height above bottom dead centre" if chart.above_bottom else "height above the lowest state",
        "reach": chart.reach,
        "height": packed(chart.height[every], "height"),
        "force": packed(chart.force[every], "process force"),
        "keys": {"height": packed(chart.height[frames.states], "height"), "force": packed(chart.force[frames.states], "process force")},
        "permissible": permissible,
    }


def _process_cards(reactions: Reactions) -> list[dict[str, str]]:
    """The work of the process, by strokes where the motion is one period."""
    if not reactions.process_force.any():
        return []
    work, turns, when = reactions.process_work, stroke_turns(reactions._press), "over the motion"
    if is_cycle(reactions.motion) and turns is not None and reactions.motion.period_turns is not None:
        work, when = work * turns / reactions.motion.period_turns, "a stroke"
    return [{"name": "work of the process", "value": _with_prefix(work, "J"), "at": when}]


def _cards(values: Sequence[ExtremeValues]) -> list[dict[str, str]]:
    """What is looked for first."""
    by_name, unit = {value.quantity: value for value in values}, values[0].units["smallest_at"]
    cards = []
    if travel := by_name.get("slide position"):
        cards.append({"name": "slide travel", "value": _with_prefix(1e-3 * travel.range, "m"), "at": ""})
    torques = [value for value in values if value.quantity.startswith("driving ")]
    forces = [value for value in values if value.quantity.startswith("force in ") and value.quantity.endswith(", magnitude")]
    for name, some in ((f"largest {torques[0].quantity}" if torques else "", torques), ("largest bearing force", forces)):
        if some:
            most = max(some, key=lambda value: max(abs(value.smallest), abs(value.largest)))
            size, at = max((abs(most.smallest), most.smallest_at), (abs(most.largest), most.largest_at))
            where = most.quantity.removeprefix("force in ").removesuffix(", magnitude") + ", " if "bearing" in name else ""
            cards.append(
                {"name": name, "value": _with_prefix(size, most.unit), "at": f"{where}at {at:.1f}{'°' if unit == 'deg' else f' {unit}'}"}
            )
    for axis in "xyz":
        if value := by_name.get(f"shaking force, {axis}"):
            cards.append({"name": f"shaking force {axis}, range", "value": _with_prefix(value.range, value.unit), "at": ""})
    return cards


def _with_prefix(value: float, unit: str) -> str:
    if value == 0.0:
        return f"0 {unit}"
    power = min(max(3 * int(np.floor(np.log10(abs(value)) / 3)), -9), 9)
    prefix = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}[power]
    return f"{value / 10.0**power:.4g} {prefix}{unit}"


def _table(values: Sequence[ExtremeValues], before: Sequence[ExtremeValues] | None) -> dict[str, Any]:
    at = f"at [{values[0].units['smallest_at']}]"
    head = ["", "unit", "smallest", at, "largest", at, "range", "rms"]
    if before is None:
        return {"head": head, "rows": [_row(value) for value in values]}
    known, rows = {value.quantity: value for value in before}, []
    for value in values:
        other, (*row, rms) = known.get(value.quantity), _row(value)
        if other is None:
            beside = ["", ""]
        else:
            beside = [_five(other.range), f"{100 * (value.range / other.range - 1):+.2f} %" if other.range else ""]
        rows.append([*row, *beside, rms])
    return {"head": [*head[:-1], "before", "changes by", "rms"], "rows": rows}


def _row(value: ExtremeValues) -> list[str]:
    at = (f"{value.smallest_at:.1f}", f"{value.largest_at:.1f}")
    return [value.quantity, value.unit, _five(value.smallest), at[0], _five(value.largest), at[1], _five(value.range), _five(value.rms)]


def _five(value: float) -> str:
    """Five significant digits, without an exponent where that is readable."""
    if not 1e-4 <= abs(value) < 1e8:
        return f"{value:.5g}"
    return f"{value:.{max(0, 4 - int(np.floor(np.log10(abs(value)))))}f}"
