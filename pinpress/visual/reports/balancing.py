"""Balancing in reports: counterweights, what they do to forces and torque, the proof of the optimum, and trade-offs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...balancing.optimum import TradeOffCurve
from ...balancing.problem import Target
from ...balancing.result import BalancedPress, CriterionChange, before_balancing, condition_name, counterweight_rows, price_in_words
from ...common import tables
from ...common.outlets.described import charts_of
from ...common.quantities import RPM, Array, quantity
from ...dynamics.described import described as of_reactions
from ...dynamics.inverse_dynamics import inverse_dynamics
from ...linkage.linkage import is_same_press
from .blocks import Block, Facts, Figure, Figures, Line, LineChart, Section, Table, with_prefix
from .shown import Shown, refuse_others


def section(balanced: BalancedPress, shown: Shown) -> Section:
    """The section of a balance; raises `PinpressError` where it is of another press."""
    _refuse_others(balanced, shown)
    asked, rest = _criteria("Criteria", balanced, balanced.changes), _criteria("The rest of the press", balanced, balanced.side_effects)
    held = Facts("Held back by", [(each.constraint, price_in_words(balanced, each)) for each in balanced.active])
    blocks: list[Block] = [_figures(balanced), _counterweights(balanced), *asked, *_shaking(balanced), *rest]
    what = " and ".join(target.words for target in balanced.objective)
    limits = "; ".join(f"{target.words} at most {limit:g} {target.unit}" for target, limit in balanced.limits.items())
    note = f"The counterweights have the least {what}{f', with {limits}' if limits else ''}. No counterweights in these regions have less."
    return Section("Balancing", [*blocks, *([held] if balanced.active else [])], note=note)


def trade_off(curve: TradeOffCurve, shown: Shown) -> Section:
    """The section of a trade-off; raises `PinpressError` where it is of another press."""
    first = curve.designs[0]
    _refuse_others(first, shown)
    (up, unit), (across, other) = (_scale(target, curve.values[:, k]) for k, target in enumerate((curve.first, curve.second)))
    line = Line("balanced", up * curve.values[:, 0], across * curve.values[:, 1], points=True)
    origin = [factor * before_balancing(first, target) for factor, target in ((up, curve.first), (across, curve.second))]
    lines = [line, Line("before balancing", np.array([origin[0]]), np.array([origin[1]]), points=True)]
    chart = LineChart(curve.first.words.capitalize(), unit, lines, across=f"{curve.second.words} [{other}]", follows="nothing")
    heads = [f"{curve.first.words} [{unit}]", "its bound", f"{curve.second.words} [{other}]", "added mass [kg]"]
    rows = [
        [f"{up * value[0]:.5g}", f"{up * bound:.5g}", f"{across * value[1]:.5g}", tables.cell(design.added_mass)]
        for value, bound, design in zip(curve.values, curve.bounds, curve.designs, strict=True)
    ]
    several = f" In the worst of {len(first.conditions)} operating conditions." if len(first.conditions) > 1 else ""
    return Section("Trade-off", [chart, Table("", heads, rows, words=0)], note=f"Each point is a proved optimum.{several}")


def _refuse_others(balanced: BalancedPress, shown: Shown) -> None:
    before = (each.set_up(balanced.original) for each in balanced.conditions)
    if not any(is_same_press(each, shown.press) for each in (balanced.press, *balanced.presses, *before)):
        refuse_others("balance", balanced.original, shown)


def _scale(target: Target, values: Array) -> tuple[float, str]:
    scale = tables.scale(target.unit, values.tolist())
    return scale.factor, scale.unit


def _figures(balanced: BalancedPress) -> Figures:
    if balanced.unit:
        (target,) = balanced.objective
        before = before_balancing(balanced, target)
        names = [(target.words, before), ("reached", balanced.value), ("proven bound", balanced.bound)]
        found = [Figure(name if k else f"{name}, before", with_prefix(value, balanced.unit)) for k, (name, value) in enumerate(names)]
    else:
        reached = {"reached": balanced.value, "proven bound": balanced.bound}
        found = [Figure(name, f"{value:.4g}", "of before, weighted") for name, value in reached.items()]
    return Figures(
        [
            Figure(
                "added mass",
                f"{balanced.added_mass:.4g} kg",
                "in one counterweight" if len(balanced.counterweights) == 1 else f"in {len(balanced.counterweights)} counterweights",
            ),
            *found,
        ]
    )


def _counterweights(balanced: BalancedPress) -> Table:
    heads = ["link", "condition", "mass [kg]", "x [mm]", "y [mm]", "z [mm]", "inertia [kg m²]"]
    rows = [
        [weight.link, condition, tables.cell(weight.mass), *places, tables.cell(weight.inertia)]
        for condition, weight, places in counterweight_rows(balanced)
    ]
    if not any(row[1] for row in rows):
        heads, *rows = ([*row[:1], *row[2:]] for row in [heads, *rows])
    note = "Centres of mass in the link's own frame; one that replaces a link's own mass is all of it."
    return Table("Counterweights", heads, rows, note=note)


def _criteria(title: str, balanced: BalancedPress, changes: Sequence[CriterionChange]) -> list[Block]:
    """Criteria before and after, in each operating condition."""
    if not changes:
        return []
    several, limited = len(balanced.conditions) > 1, any(change.criterion in balanced.limits for change in changes)
    heads = ["", *(["condition"] if several else []), "before", "after", "change", *(["at most"] if limited else [])]
    rows = []
    for change in changes:
        limit = balanced.limits.get(change.criterion)
        same = [value for each in changes if each.criterion == change.criterion for value in (each.before, each.after)]
        scale = tables.scale(change.criterion.unit, same)
        share = "" if math.isnan(change.change) else f"{round(100 * change.change, 2) + 0.0:+.2f} %"
        cells = [scale.shown(change.before), scale.shown(change.after), share]
        cells += ["" if limit is None else scale.shown(limit)] if limited else []
        rows.append(
            [f"{change.criterion.words} [{scale.unit}]", *([condition_name(balanced, change.condition)] if several else []), *cells]
        )
    note = (
        "; ".join(f"{condition_name(balanced, number)}: {_pace(balanced, number)}" for number in range(len(balanced.conditions)))
        if several
        else ""
    )
    return [Table(title, heads, rows, note=f"Conditions: {note}" if note else "")]


def _pace(balanced: BalancedPress, number: int) -> str:
    speed = balanced.conditions[number].motion.crank_speed
    return f"{float(np.ravel(speed)[0]) / RPM:g} r/min" if np.ptp(speed) <= 1e-9 * np.abs(speed).max() else "a motion"


def _shaking(balanced: BalancedPress) -> list[Block]:
    """The shaking force in the first operating condition, before and after."""
    original = balanced.conditions[0].set_up(balanced.original)
    known = (original, balanced.reactions_before[0]), (balanced.presses[0], balanced.reactions_after[0])
    # with all bearings, by which rounding is known; balancing computes only those that are asked for
    before, after = (
        charts_of(of_reactions(inverse_dynamics(press, each.motion, balanced.conditions[0].loads)))["shaking"] for press, each in known
    )
    motion = balanced.conditions[0].motion
    first = motion.driver_coordinates[0]
    if motion.crank_angle.ndim > 1:
        return []
    lines, scale = [], quantity("N").scale(float(np.abs(curve.y).max()) for chart in (before, after) for curve in chart.curves)
    for words, chart in (("before", before), ("after", after)):
        along = first.scale * chart.along.values
        lines += [Line(f"{curve.name}, {words}", scale.factor * curve.y, along) for curve in chart.curves]
    across = f"{first.counted} [{first.shown_unit}]"
    return [LineChart("Shaking force before and after", scale.unit, lines, across=across, follows="position")]
