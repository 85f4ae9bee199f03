"""What tolerances and clearances make of a slide: scatter of dead centres, place in clearances, heat, parts of bottom dead centre, tilt."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..common.conic_program import PROVED
from ..common.outlets.described import Along, Bars, Block, Chart, Column, Curve, Figure, Section, Table
from ..common.quantities import Array, quantity
from ..dynamics.inputs import Inputs, of_friction
from ..dynamics.reactions import Reactions
from ..kinematics.described import along_motion, kinds_of_drivers, over_angle
from ..kinematics.motion import Motion
from .accuracy_budget import NEGLIGIBLE, PARTS, AccuracyBudget
from .allocation import SLACK, AllocatedTolerances
from .clearances import GuideClearance, SlidePlay
from .clearances_over_speed import DeadCentresInClearances
from .dead_centre_scatter import DeadCentreScatter
from .dimensions import Dimension
from .points import ONE_PLACE, SlideParallelism
from .scatter import COVERAGE, LEAST_BEYOND, Scatter, widest_coverage
from .temperatures import HeatShift

BOTTOM, TOP = "bottom dead centre", "top dead centre"


# ------------------------------------------------------------------------------------------------------------------------------ scatter


def scatter(found: Scatter, page: Reactions | None = None) -> tuple[Section, ...]:
    """A quantity that scatters with its dimensions: its band, the shares of the dimensions, and the presses of the sample."""
    figures = [
        Figure("nominal", found.nominal, _places(found)),
        _band(found),
        Figure("standard deviation", found.sd, found.unit, f"to first order {quantity(found.unit).text(found.first_order_sd, 4)}"),
        Figure("worst corners", _ends(found, found.corners, "and")),
    ]
    if found.limit is not None:
        limits = f"of presses deviate by at most {quantity(found.unit).text(found.limit, 4)}"
        figures.append(Figure("within the limits", found.within(found.limit), "share", limits))
    ranking = Table("ranking", "Dimensions", [*_dimensions(found.parts, _by_share(found)), *_by_dimension(found)], most=200)
    return (Section(f"Scatter of {found.quantity}", figures, [_shares([found]), _presses(found), ranking], note=f"{found.decided}."),)


def dead_centres(found: DeadCentreScatter, page: Reactions | None = None) -> tuple[Section, ...]:
    """Dead centres whose dimensions scatter, with torques and speeds at heights."""
    order = _by_share(found.height)
    rows = [
        (
            result.quantity,
            quantity(_places(result)).text(result.nominal, 7),
            *(quantity(result.unit).text(sd, 4) for sd in (result.sd, result.first_order_sd)),
            _ends(result, result.corners, "and"),
        )
        for result in found.quantities
    ]
    heads = ("", "nominal", "standard deviation", "to first order", "worst corners")
    spread = [Column(head, list(cells)) for head, cells in zip(heads, zip(*rows, strict=True), strict=True)]
    gradients = [Column(f"{result.quantity} [{result.unit}]", result.gradient[order].tolist()) for result in found.quantities]
    share = Column(f"share of {BOTTOM}", [float(found.share[k]) for k in order], "share")
    blocks: list[Block] = [
        _shares(found.quantities),
        _presses(found.height),
        Table("spread", "", spread, most=200),
        Table(
            "gradients", "Derivatives by the dimensions [per m, of angles per rad]", [*_dimensions(found.parts, order), share, *gradients]
        ),
    ]
    note = f"Of {found.deviations.shape[1]} presses with lengths of their own. Bottom dead centre: {found.height.decided}."
    note += f" {found.way_down[0].upper()}{found.way_down[1:]}." if found.way_down else ""
    figures = [replace(_band(result), name=result.quantity) for result in found.quantities]
    return (Section("Dead centres and tolerances", figures, blocks, (), note, found._press, "scatter"),)


def _places(found: Scatter) -> str:
    """What nominal values of a quantity are written as: lengths as places."""
    return "height" if found.unit == "m" else found.unit


def _ends(found: Scatter, ends: Sequence[float] | Array, between: str) -> str:
    """Two deviations in one unit."""
    scale = quantity(found.unit).scale([float(end) for end in ends], digits=4)
    return f"{scale.shown(float(ends[0]))} {between} {scale.shown(float(ends[1]))} {scale.unit}"


def _band(found: Scatter) -> Figure:
    """The band of the largest share of presses whose ends are reliable in the sample; for a very small sample its standard deviation."""
    coverage = widest_coverage(found)
    if coverage is None:
        return Figure("band", found.first_order_sd, found.unit, "standard deviation to first order", kind="accuracy")
    return Figure("band", _ends(found, found.band(coverage), "to"), where=f"{100 * coverage:g} % of presses", kind="accuracy")


def _by_share(found: Scatter) -> list[int]:
    """Indices of the dimensions, the one with the largest share first."""
    return [int(k) for k in np.argsort(-found.share, kind="stable")]


def written_tolerance(part: Dimension) -> str:
    """The tolerance of a dimension in the units of a drawing."""
    return f"{1e3 * part.tolerance:.4g} mm" if part.unit == "m" else f"{math.degrees(part.tolerance):.4g} deg"


def _dimensions(parts: Sequence[Dimension], order: Sequence[int]) -> list[Column]:
    return [
        Column("dimension", [parts[k].name for k in order]),
        Column("tolerance", [written_tolerance(parts[k]) for k in order]),
    ]


def _by_dimension(found: Scatter) -> list[Column]:
    order = _by_share(found)
    return [
        Column("gradient", [float(found.gradient[k]) for k in order]),
        Column("share", [float(found.share[k]) for k in order], "share"),
    ]


def _shares(scatters: Sequence[Scatter]) -> Bars:
    """Shares of the dimensions in the variances, in the order of the first quantity; of more than eleven, the smallest are one bar."""
    parts, order = scatters[0].parts, _by_share(scatters[0])
    shown, rest = (order, []) if len(order) <= 11 else (order[:10], order[10:])
    names = [parts[k].name for k in shown] + [f"{len(rest)} others"] * bool(rest)
    series = {result.quantity: np.append(result.share[shown], [result.share[rest].sum()] if rest else []) for result in scatters}
    return Bars("shares", "Shares of the variance", "share", names, series)


def _presses(found: Scatter) -> Chart:
    """How many presses of the sample deviate by how much, next to the ends of the band, the worst corners and the limits."""
    counts, edges = np.histogram(found.deviation, bins=61)
    share = np.repeat(counts / len(found.deviation), 2)
    reach = float(max(np.abs(found.deviation).max(), np.abs(found.corners).max(), found.limit or 0.0))
    ends = dict[str, Sequence[float]]()
    if 0.5 * (1.0 - COVERAGE) * len(found.deviation) >= LEAST_BEYOND:
        ends[f"{100 * COVERAGE:g} % of presses"] = found.band(COVERAGE)
    ends["worst corners"] = found.corners.tolist()
    if found.limit is not None:
        ends[f"limits: {100 * found.within(found.limit):.4g} %"] = (-found.limit, found.limit)
    room = 1.08  # lines are a little higher than the largest class, and the chart a little wider than its lines
    column = room * float(share.max()) * np.array([1.0, 0.0, 0.0, 1.0])
    outline = Curve("presses", share, np.repeat(edges, 2)[1:-1], np.column_stack([np.zeros_like(share), share]))
    lines = [Curve(name, column, np.repeat([low, high], 2), look="limit") for name, (low, high) in ends.items()]
    along = Along(f"deviation of {found.quantity}", found.unit)
    reaches: tuple[float | None, float | None] = (-room * reach, room * reach) if reach else (None, None)
    return Chart("presses", "Presses of the sample", "share", along, [outline, *lines], reach=reaches)


def allocated(found: AllocatedTolerances, page: Reactions | None = None) -> tuple[Section, ...]:
    """The cheapest tolerances that keep targets."""
    figures = [
        Figure("cost", found.value, "number", f"proved to {max(found.gap, PROVED):.1g}"),
        Figure("before", found.cost_before, "number"),
    ]
    if found.cost_alike is not None:
        figures.append(Figure("all changed alike", found.cost_alike, "number"))
    for name, target in found.targets.items():
        used = "used up" if found.reached[name] > (1.0 - SLACK) * target else "not used up"
        figures.append(Figure(name, found.reached[name], "m", used, target, kind="accuracy"))
    before = [replace(part, tolerance=value, shape="normal", sd=None) for part, value in zip(found.parts, found.before, strict=True)]
    columns = [
        *_dimensions(found.parts, range(len(found.parts))),
        Column("before", [written_tolerance(part) for part in before]),
        Column("cost", found.costs.tolist(), "number"),
        Column("", [_at_bound(part.tolerance, ends) for part, ends in zip(found.parts, found.bounds, strict=True)]),
    ]
    table = Table("tolerances", "", columns, most=200)
    return (Section("Cheapest tolerances", figures, [table], press=found._press, of="allocation"),)


def _at_bound(tolerance: float, ends: Array) -> str:
    if tolerance <= ends[0] * (1.0 + SLACK):
        return "smallest"
    return "largest" if tolerance >= ends[1] * (1.0 - SLACK) else ""


def parallelism(found: SlideParallelism, page: Reactions | None = None) -> tuple[Section, ...]:
    """The tilt of a slide on several points over the turn, and the dimensions that decide it."""
    tilted = [(k, slope) for k, slope in enumerate(found.slopes) if slope.worst_case]
    figures = [replace(_band(slope), name=slope.quantity) for _, slope in tilted]
    for _, slope in tilted:
        first_order = f"standard deviation; to first order {quantity(slope.unit).text(slope.first_order_sd, 4)}"
        figures.append(Figure(f"{slope.quantity}, scatter", slope.sd, slope.unit, first_order))
        figures.append(Figure(f"{slope.quantity}, worst corners", _ends(slope, slope.corners, "and")))
    if found.misfit_sd.max() > 1e-3 * ONE_PLACE:  # less is rounding error
        figures.append(Figure("forced into the slide", float(found.misfit_sd.max()), "m", "standard deviation of a point off the plane"))
    if found.point_force_sd is not None and found.guide_moment_sd is not None:
        figures.append(Figure("force on a point", float(found.point_force_sd.max()), "N", "standard deviation"))
        figures.append(Figure("moment on the guides", float(found.guide_moment_sd.max()), "N m", "standard deviation"))
    first, place = found.coordinate, found.crank_angle
    period = float(2 * place[-1] - place[-2] - place[0]) if first.turns else None
    along = Along(first.counted, first.unit, place, period=period)
    curves = [Curve(slope.quantity, 3 * found.slope_sd[:, k]) for k, slope in tilted]
    blocks: list[Block] = [Chart("slopes", "Three standard deviations over the turn", "m/m", along, curves)] if tilted else []
    for _, slope in tilted:
        table = [*_dimensions(slope.parts, _by_share(slope)), *_by_dimension(slope)]
        blocks.append(Table(slope.quantity, f"{slope.quantity}: what decides", table, f"{slope.decided}.", most=200))
    note = "Slopes of the slide against the table; their bands at bottom dead centre."
    note += "" if tilted else " No dimension tilts the slide to first order."
    return (Section(f"Parallelism on {len(found.points)} points", figures, blocks, (), note, found._press, "parallelism"),)


# ---------------------------------------------------------------------------------------------------------------------------- clearances


def play(found: SlidePlay, page: Reactions | None = None) -> tuple[Section, ...]:
    """A slide in its clearances over the motion, the share of each bearing, and the forces that reverse."""
    motion, first = found.motion, found.motion.driver_coordinates[0]
    low, high = found.bottom_band
    between = f"{quantity('m').text(low, 4)} to {quantity('m').text(high, 4)}" if high > low else ""
    figures = [
        Figure(BOTTOM, found.bottom_shift, "m", between, kind="accuracy"),
        Figure(TOP, found.top_shift, "m"),
        Figure("forces that reverse", str(len(found.reversals)) if found.reversals else "none"),
    ]
    along = _along(motion)
    open_ = not np.array_equal(found.lowest, found.highest)
    curves = [Curve("slide", found.offset, band=np.column_stack([found.lowest, found.highest]) if open_ else None)]
    if found.reversals and along.quantity == first.unit and page is None:  # a page lists them
        places = np.array([reversal.crank_angle for reversal in found.reversals])
        curves.append(Curve("force reverses", _between(along, found.offset, places), places, look="points"))
    whole: tuple[float | None, float | None] = (None, None)
    if along.values is not None and page is None:
        first_place, last = float(along.values[0]), float(along.values[-1])
        whole = (first_place, last if along.period is None else first_place + along.period)
    blocks: list[Block] = [
        Chart("offset", "Slide in its clearances", "m", along, curves, reach=whole),
        Chart("by_bearing", "Shares of the bearings", "m", along, [Curve(name, share) for name, share in found.by_bearing.items()]),
    ]
    if found.reversals:
        heads = {"bearing": "", "side": "", "crank_angle": first.unit, "change": "m", "force": "N"}
        named = zip(heads.items(), ("bearing", "then it is", "at", "slide moves by", "force left"), strict=True)
        columns = [Column(head, [getattr(row, field) for row in found.reversals], unit) for (field, unit), head in named]
        blocks.append(Table("reversals", "Forces that reverse", columns))
    note = (
        "Offset from the rigid press without clearances, positive upwards, with every bearing closed by its force. Its band: where a"
        f" force is below {100 * found.known_to:.3g} % of its parts, so that its direction is not known"
        f"{', and where contacts with friction lean' if found.friction else ''}."
    )
    if not found.reversals:
        note += " No force reverses: the slide stays on one side of its clearances."
    return (Section("Slide in its clearances", figures, blocks, _clearances(found), note, found._press, "play"),)


def _along(motion: Motion) -> Along:
    """Along the coordinate of a single driver, else as the motion is drawn."""
    return over_angle(motion) if motion.crank_angle.ndim == 1 and len(kinds_of_drivers(motion)) == 1 else along_motion(motion)


def _between(along: Along, values: Array, places: Array) -> Array:
    """Values between states at places; a period is closed by its first state."""
    x, y = along.values, values
    assert x is not None
    if along.period is not None:
        x, y = np.append(x, x[0] + along.period), np.append(y, y[0])
    order = np.argsort(x, kind="stable")
    return np.asarray(np.interp(places, x[order], y[order]))


def _clearances(found: SlidePlay) -> Inputs:
    """The clearances as text, bearings with equal clearances together."""
    alike: dict[str, list[str]] = {}
    for name, width in found.clearance.items():
        if isinstance(width, GuideClearance):
            wide = f"{1e3 * width.across:.4g} mm over {1e3 * width.length:.4g} mm"
        else:
            wide = f"{1e3 * width:.4g} mm"
        alike.setdefault(wide, []).append(name)
    friction = [("friction in them", words) for _, words in of_friction(found.friction)] if found.friction else []
    return [("radial clearance", "; ".join(f"{', '.join(names)}: {wide}" for wide, names in alike.items())), *friction]


def over_speeds(found: DeadCentresInClearances, page: Reactions | None = None) -> tuple[Section, ...]:
    """Dead centres in clearances over the speed."""
    order, kind = np.argsort(found.speed), f"{found.coordinate.unit}/s"
    bottom, low, high, top = (part[order] for part in (found.bottom_shift, found.bottom_lowest, found.bottom_highest, found.top_shift))
    band = np.column_stack([low, high])
    curves = [Curve(BOTTOM, bottom, band=None if np.array_equal(low, high) else band), Curve(TOP, top)]
    lengths = {BOTTOM: bottom, "from": low, "to": high, TOP: top}
    columns = [
        Column("speed", found.speed[order].tolist(), kind),
        *_in_one_unit({head: values.tolist() for head, values in lengths.items()}),
        Column("reversals", [int(count) for count in found.reversals[order]]),
    ]
    along = Along(f"{found.coordinate.part} speed", kind, found.speed[order])
    blocks: list[Block] = [Chart("dead_centres", "Dead centres", "m", along, curves), Table("dead centres", "", columns)]
    if reversing := sorted(found.reversing_speed.items(), key=lambda item: item[1]):
        from_on = [
            Column("bearing", [name for name, _ in reversing]),
            Column("from this speed on", [speed for _, speed in reversing], kind),
        ]
        blocks.append(Table("reversals", "Forces that reverse", from_on))
    return (Section("Dead centres in the clearances over the speed", (), blocks, press=found._press, of="dead centres"),)


# ------------------------------------------------------------------------------------------------------------------------ heat and budget


def heat(found: HeatShift, page: Reactions | None = None) -> tuple[Section, ...]:
    """Dead centres by warm links."""
    slopes = dict(sorted(found.bottom_per_kelvin.items(), key=lambda item: -abs(item[1])))
    steepest = next(iter(slopes))
    figures = [
        Figure(BOTTOM, found.bottom_shift, "m", kind="accuracy"),
        Figure(TOP, found.top_shift, "m"),
        Figure("most by a kelvin", slopes[steepest], "m/K", steepest),
    ]
    shifts = {BOTTOM: found.bottom_by_link, TOP: found.top_by_link}
    columns = [
        Column("link", list(slopes)),
        Column("warmer by", [found.rise.get(name) or None for name in slopes], "K"),
        *_in_one_unit({head: [by_link.get(name) for name in slopes] for head, by_link in shifts.items()}),
        Column("by a kelvin", list(slopes.values()), "m/K"),
    ]
    note = "Of the slide's face from the table, positive upwards; by a kelvin: of bottom dead centre."
    return (Section("Heat", figures, [Table("heat", "", columns, most=200)], (), note, found._press, "heat"),)


def _in_one_unit(lengths: Mapping[str, Sequence[float | None]]) -> list[Column]:
    """Columns of lengths by their heads, all in one unit."""
    beside = [value for cells in lengths.values() for value in cells if value is not None]
    return [Column(head, cells, "m", beside=beside) for head, cells in lengths.items()]


def budget(found: AccuracyBudget, page: Reactions | None = None) -> tuple[Section, ...]:
    """Bottom dead centre in every condition by its parts, and its rise from the first condition."""
    kind, worst, conditions = f"{found.coordinate.unit}/s", found.worst, found.conditions
    parts = [part for part in (*PARTS, "crank") if any(abs(getattr(row, part)) > NEGLIGIBLE for row in conditions)]
    figures: list[Figure] = []
    if abs(found.largest_rise) > NEGLIGIBLE:
        where = f"at {quantity(kind).text(worst.speed, 4)}, {worst.condition}"
        figures.append(Figure("largest rise", found.largest_rise, "m", where, kind="accuracy"))
        figures.append(Figure("most of it", found.change(found.decides), "m", f"by {found.decides}", kind="accuracy"))
    if found.machining is not None:
        height = found.machining.height
        band = _band(height)
        if widest_coverage(height) is None:
            ends = (float(height.deviation.min()), float(height.deviation.max()))
            band = Figure("machining", _ends(height, ends, "to"), where=f"{len(height.deviation)} presses")
        figures.append(replace(band, name="machining", where=f"in {band.where}; the setting takes it away", kind=""))
    blocks: list[Block] = []
    speeds = np.unique([row.speed for row in conditions])
    if len(speeds) > 1:
        along = Along(f"{found.coordinate.part} speed", kind, speeds)
        curves = []
        for name in dict.fromkeys(row.condition for row in conditions):
            rises = sorted((row.speed, row.rise) for row in conditions if row.condition == name)
            at_speeds, rise = np.array(rises).T
            curves.append(Curve(name, rise, at_speeds))
        blocks.append(Chart("rise", "Rise of bottom dead centre", "m", along, curves))
    places = [f"{quantity(kind).text(row.speed, 4)}, {row.condition}" for row in conditions]
    series = {part: np.array([getattr(row, part) for row in conditions]) for part in parts}
    band_of_sum = np.array([[row.lowest, row.highest] for row in conditions])
    blocks.append(Bars("parts", "Parts of bottom dead centre", "m", places, series, stacked=True, band=band_of_sum))
    heads = {**{part: part for part in parts}, "sum": "shift", "from": "lowest", "to": "highest", "rise": "rise"}
    columns = [
        Column("speed", [row.speed for row in conditions], kind),
        Column("condition", [row.condition for row in conditions]),
        *_in_one_unit({head: [float(getattr(row, part)) for row in conditions] for head, part in heads.items()}),
    ]
    blocks.append(Table("parts", "", columns))
    note = (
        "Against the rigid press without clearances, positive upwards. Rise: from the first condition, in which the height of the die is"
        " set. From and to: undetermined clearances and stiffnesses at their ends; lines and dots on the bars are the sum with these ends."
    )
    return (Section("Accuracy of bottom dead centre", figures, blocks, (), note, found._press, "budget"),)


SECTIONS = {
    Scatter: scatter,
    DeadCentreScatter: dead_centres,
    AllocatedTolerances: allocated,
    SlideParallelism: parallelism,
    SlidePlay: play,
    DeadCentresInClearances: over_speeds,
    HeatShift: heat,
    AccuracyBudget: budget,
}
"""How results of this room are described."""
