"""The accuracy of a slide in reports: its place in the clearances, bottom dead centre by parts, parallelism."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...common import tables
from ...common.conic_program import PROVED
from ...common.quantities import Array
from ...dynamics.inputs import Inputs, of_friction
from ...kinematics.motion import Motion, is_cycle
from ...tolerances.accuracy_budget import NEGLIGIBLE, PARTS, AccuracyBudget
from ...tolerances.allocation import AllocatedTolerances
from ...tolerances.clearances import GuideClearance, SlidePlay
from ...tolerances.clearances_over_speed import DeadCentresInClearances
from ...tolerances.dead_centre_scatter import DeadCentreScatter
from ...tolerances.points import SlideParallelism
from ...tolerances.scatter import Scatter, scale_of, widest_coverage, written_tolerance
from ...tolerances.temperatures import HeatShift
from .blocks import BarChart, Block, Figure, Figures, Line, LineChart, Section, Table
from .shown import Shown, refuse_others

CLASSES = 61  # of the presses of a sample
MOST_REVERSALS = 24  # rows of the table of reversals
MINUS = "\u2212"


def play(found: SlidePlay, shown: Shown) -> Section:
    """The section of a slide in its clearances; raises `PinpressError` where it is of another press."""
    refuse_others("play", found._press, shown)
    motion, first = found.motion, found.motion.driver_coordinates[0]
    order, along = _around(motion)
    across = f"{first.counted} [{first.shown_unit}]"
    low, high = found.bottom_band
    figures = [
        Figure("bottom dead centre", _mm(found.bottom_shift), f"{_mm(low)} to {_mm(high)}"),
        Figure("top dead centre", _mm(found.top_shift)),
        Figure("forces that reverse", str(len(found.reversals))),
    ]
    offset = [Line("slide", 1e3 * found.offset[order], along)]
    if not np.array_equal(found.lowest, found.highest):
        offset = [Line("lowest", 1e3 * found.lowest[order], along), Line("highest", 1e3 * found.highest[order], along), *offset]
    shares = [Line(name, 1e3 * share[order], along) for name, share in found.by_bearing.items()]
    blocks: list[Block] = [
        Figures(figures),
        LineChart("Slide in its clearances", "mm", offset, across=across, follows="position"),
        LineChart("Shares of the bearings", "mm", shares, across=across, follows="position"),
    ]
    if found.reversals:
        forces = tables.scale("N", [each.force for each in found.reversals])
        rows = [
            [each.bearing, each.side, first.shown(each.crank_angle, ".1f"), _mm(each.change), forces.shown(each.force)]
            for each in found.reversals[:MOST_REVERSALS]
        ]
        more = len(found.reversals) - len(rows)
        note = f"{more} more are not listed" if more > 0 else ""
        blocks.append(
            Table(
                "Forces that reverse",
                ["bearing", "then it is", "at", "slide moves by", f"force left [{forces.unit}]"],
                rows,
                words=2,
                note=note,
            )
        )
    note = (
        "Offset from the rigid press without clearances, positive upwards, with every bearing closed by its force. Between lowest and"
        f" highest where a force is below {100 * found.known_to:.3g} % of its parts, so that its direction is not known"
        f"{', and where contacts with friction lean' if found.friction else ''}."
    )
    return Section("Slide in its clearances", blocks, _clearances_in_words(found), note)


def _around(motion: Motion) -> tuple[NDArray[np.intp], Array]:
    """The states in the order of the crank angle, and where they are drawn [deg]; a period ends with its first state once more. Those of a
    driver that slides to and fro keep their order [mm]."""
    places = motion.shown_position
    if not motion.driver_coordinates[0].turns:
        return np.arange(len(places)), places
    order = np.argsort(places, kind="stable")
    if not is_cycle(motion) or motion.period_turns is None:
        return order, places[order]
    return np.append(order, order[0]), np.append(places[order], places[order[0]] + 360.0 * motion.period_turns)


def over_speeds(found: DeadCentresInClearances, shown: Shown) -> Section:
    """The section of dead centres in clearances over the speed; raises `PinpressError` where it is of another press."""
    refuse_others("dead centres", found._press, shown)
    unit, size = found.coordinate.shown_speed
    order = np.argsort(found.speed)
    speed = found.speed[order] / size
    curves = {"bottom dead centre": found.bottom_shift, "lowest": found.bottom_lowest, "highest": found.bottom_highest}
    lines = [Line(name, 1e3 * values[order], speed) for name, values in (curves | {"top dead centre": found.top_shift}).items()]
    rows = [[name, f"{w / size:.4g} {unit}"] for name, w in sorted(found.reversing_speed.items(), key=lambda item: item[1])]
    blocks: list[Block] = [LineChart("Dead centres", "mm", lines, across=f"speed [{unit}]", follows="nothing")]
    if rows:
        blocks.append(Table("Forces that reverse", ["bearing", "from this speed on"], rows))
    return Section("Dead centres in the clearances over the speed", blocks)


def heat(found: HeatShift, shown: Shown) -> Section:
    """The section of warm links; raises `PinpressError` where it is of another press."""
    refuse_others("heat", found._press, shown)
    figures = [Figure("bottom dead centre", _mm(found.bottom_shift)), Figure("top dead centre", _mm(found.top_shift))]
    most_first = sorted(found.bottom_per_kelvin.items(), key=lambda item: -abs(item[1]))
    rows = []
    for name, slope in most_first:
        warm = found.rise.get(name, 0.0)
        cells = [f"{warm:+.4g} K".replace("-", MINUS), _mm(found.bottom_by_link[name])] if warm else ["", ""]
        rows.append([name, *cells, f"{1e6 * slope:+.3g} µm/K".replace("-", MINUS)])
    return Section("Heat", [Figures(figures), Table("", ["link", "warmer by", "bottom dead centre", "by a kelvin"], rows)])


def budget(found: AccuracyBudget, shown: Shown) -> Section:
    """The section of an accuracy budget; raises `PinpressError` where it is of another press."""
    refuse_others("budget", found._press, shown)
    unit, size = found.coordinate.shown_speed
    speeds = list(dict.fromkeys(each.speed for each in found.conditions))
    names = list(dict.fromkeys(each.condition for each in found.conditions))
    parts = [part for part in PARTS if any(abs(getattr(each, part)) > NEGLIGIBLE for each in found.conditions)]
    worst = found.worst
    figures = [
        Figure("largest rise", _mm(found.largest_rise), f"at {worst.speed / size:.4g} {unit}, {worst.condition}"),
        Figure("most of it by", found.decides),
    ]
    if found.machining is not None:
        low, high = found.machining.height.band()
        figures.append(Figure("machining", f"{_mm(low)} to {_mm(high)}", "99.73 % of presses; the setting takes it away"))
    blocks: list[Block] = [Figures(figures)]
    if len(speeds) > 1:
        across = np.array(sorted(speeds)) / size
        rising = sorted(found.conditions, key=lambda each: each.speed)
        lines = [Line(name, np.array([1e3 * each.rise for each in rising if each.condition == name]), across) for name in names]
        blocks.append(LineChart("Rise of bottom dead centre", "mm", lines, across=f"speed [{unit}]", follows="nothing"))
    last = [each for each in found.conditions if each.speed == worst.speed]
    bars = {part: [1e3 * getattr(each, part) for each in last] for part in parts}
    blocks.append(BarChart(f"Parts at {worst.speed / size:.4g} {unit}", "mm", [each.condition for each in last], bars))
    by_part, sums = [], []
    for each in found.conditions:
        where = f"{each.speed / size:.4g}, {each.condition}"
        by_part.append([where, *(_signed(getattr(each, part)) for part in parts)])
        sums.append([where, *map(_signed, (each.rise, each.shift, each.lowest, each.highest))])
    blocks.append(Table("Parts of bottom dead centre [mm]", [f"at [{unit}]", *parts], by_part))
    blocks.append(Table("Bottom dead centre [mm]", [f"at [{unit}]", "rise", "sum", "from", "to"], sums))
    note = (
        "Against the rigid press without clearances, positive upwards. Rise: from the first condition, in which the height of the die is"
        " set. From and to: undetermined clearances and stiffnesses at their ends."
    )
    return Section("Accuracy of bottom dead centre", blocks, note=note)


def dead_centres(found: DeadCentreScatter, shown: Shown) -> Section:
    """The section of dead centres whose dimensions scatter; raises `PinpressError` where it is of another press."""
    refuse_others("scatter", found._press, shown)
    order = np.argsort(-found.share, kind="stable")
    names = [found.parts[k].name for k in order]
    shares = {each.quantity: [100.0 * each.share[k] for k in order] for each in found.quantities}
    counts, edges = np.histogram(1e6 * found.height.deviation, bins=CLASSES)
    line = Line("bottom dead centre", 100.0 * counts / len(found.height.deviation), 0.5 * (edges[1:] + edges[:-1]))
    rows = [
        [found.parts[k].name, written_tolerance(found.parts[k]), *(tables.cell(float(each.gradient[k])) for each in found.quantities)]
        for k in order
    ]
    heads = ["dimension", "tolerance", *(f"{each.quantity} [{each.unit}]" for each in found.quantities)]
    blocks: list[Block] = [
        Figures([_scattered(each) for each in found.quantities]),
        BarChart("Shares of the variance", "%", names, shares),
        LineChart("Presses of the sample", "%", [line], across="deviation [µm]", follows="nothing"),
        Table("Derivatives by the dimensions [per m, of angles per rad]", heads, rows, words=2),
    ]
    note = f"Of {found.deviations.shape[1]} presses with lengths of their own. Bottom dead centre: {found.height.decided}."
    note += f" {found.way_down[0].upper()}{found.way_down[1:]}." if found.way_down else ""
    return Section("Dead centres and tolerances", blocks, note=note)


def _scattered(each: Scatter) -> Figure:
    """A quantity with its scatter."""
    scale, coverage = scale_of(each), widest_coverage(each)
    unit = scale.unit.replace("um", "µm")
    if coverage is None:
        return Figure(each.quantity, f"{scale.shown(each.first_order_sd)} {unit}", "standard deviation")
    low, high = (scale.shown(end).replace("-", MINUS) for end in each.band(coverage))
    return Figure(each.quantity, f"{low} to {high} {unit}", f"{100 * coverage:g} % of presses")


def allocated(found: AllocatedTolerances, shown: Shown) -> Section:
    """The section of the cheapest tolerances; raises `PinpressError` where they are of another press."""
    refuse_others("allocation", found._press, shown)
    figures = [
        Figure("cost", tables.cell(found.value), f"proved to {max(found.gap, PROVED):.1g}"),
        Figure("before", tables.cell(found.cost_before)),
    ]
    if found.cost_alike is not None:
        figures.append(Figure("all changed alike", tables.cell(found.cost_alike)))
    figures += [
        Figure(name, f"{1e6 * reached:.1f} µm", f"of {1e6 * found.targets[name]:.1f} µm") for name, reached in found.reached.items()
    ]
    rows = found.rows()
    return Section("Cheapest tolerances", [Figures(figures), Table("", rows[0], rows[1:], words=1)])


def parallelism(found: SlideParallelism, shown: Shown) -> Section:
    """The section of a slide's parallelism; raises `PinpressError` where it is of another press."""
    refuse_others("parallelism", found._press, shown)
    tilted = [(k, slope) for k, slope in enumerate(found.slopes) if slope.worst_case]
    first = found.coordinate
    blocks: list[Block] = [Figures([_scattered(slope) for _, slope in tilted])] if tilted else []
    turned, spread = first.scale * found.crank_angle, found.slope_sd
    if first.turns:  # of a period, without its end
        turned, spread = np.append(turned, 2 * turned[-1] - turned[-2]), np.concatenate([spread, spread[:1]])
    lines = [Line(slope.quantity, 3e6 * spread[:, k], turned) for k, slope in tilted]
    if lines:
        across = f"{first.counted} [{first.shown_unit}]"
        blocks.append(LineChart("Three standard deviations over the turn", "µm/m", lines, across=across, follows="position"))
    for _, slope in tilted:
        order = np.argsort(-slope.share, kind="stable")
        rows = [
            [slope.parts[k].name, written_tolerance(slope.parts[k]), f"{100 * slope.share[k]:.1f} %"] for k in order if slope.share[k] > 0
        ]
        blocks.append(Table(f"{slope.quantity}: what decides", ["dimension", "tolerance", "share"], rows))
    return Section(
        f"Parallelism on {len(found.points)} points",
        blocks,
        note="Slopes of the slide against the table; their bands at bottom dead centre.",
    )


def _clearances_in_words(found: SlidePlay) -> Inputs:
    """The clearances in words, those that are alike together."""
    alike: dict[str, list[str]] = {}
    for name, width in found.clearance.items():
        wide = (
            f"{1e3 * width.across:.4g} mm over {1e3 * width.length:.4g} mm"
            if isinstance(width, GuideClearance)
            else f"{1e3 * width:.4g} mm"
        )
        alike.setdefault(wide, []).append(name)
    friction = [("friction in them", words) for _, words in of_friction(found.friction)] if found.friction else []
    return [("radial clearance", "; ".join(f"{', '.join(names)}: {wide}" for wide, names in alike.items())), *friction]


def _mm(value: float) -> str:
    return f"{_signed(value)} mm"


def _signed(value: float) -> str:
    """A length in mm with its sign, without one where it is zero."""
    written = f"{1e3 * value:+.4f}"
    return "0.0000" if written in ("+0.0000", "-0.0000") else written.replace("-", MINUS)
