"""What balancing shows: the counterweights, their effect on all criteria with the proof of the optimum, and trade-offs."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..common.outlets.described import Along, Block, Chart, Column, Curve, Figure, Section, Table
from ..common.quantities import RPM, quantity
from ..dynamics.described import along_states, drawn_states
from ..dynamics.described import shaking as shaking_of
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.motion import ROUNDING
from ..linkage.linkage import Linkage, is_same_press
from .counterweights import Counterweight, OperatingCondition, moving_mass
from .optimum import TradeOffCurve
from .problem import AddedMass, Target, limit_words
from .program import over_conditions
from .result import ActiveConstraint, BalancedPress, CriterionChange, condition_name

MASS = AddedMass()
KINDS = {  # of what a reader looks for first, by the quantity of a criterion
    "shaking_force": "floor",
    "shaking_moment": "floor",
    "driving_torque": "torque",
    "driving_force": "torque",
    "bearing_force": "bearing",
    "bearing_moment": "bearing",
}


def balanced_press(balanced: BalancedPress, page: Reactions | None = None) -> tuple[Section, ...]:
    """A balanced press in all its operating conditions; a page may show it before or after, in any of these."""
    figures = [*_limited(balanced), *_objective(balanced), *_checks(balanced)]
    blocks: list[Block] = [_conditions(balanced)] if len(balanced.conditions) > 1 else []
    blocks += [_counterweights(balanced), _criteria("criteria", "Criteria", balanced, balanced.changes), _shaking(balanced)]
    blocks += [_criteria("side_effects", "The rest of the press", balanced, balanced.side_effects)] if balanced.side_effects else []
    blocks += [_active(balanced)] if balanced.active else []
    shown = _press_of_page(balanced, page)
    return (Section("Balancing", figures, blocks, (), _note(balanced), shown, "balance"),)


def trade_off(curve: TradeOffCurve, page: Reactions | None = None) -> tuple[Section, ...]:
    """The trade-off between two criteria, with the press before balancing."""
    start = curve.designs[0]
    before = [np.array([before_balancing(start, target)]) for target in (curve.first, curve.second)]
    curves = [
        Curve("balanced", curve.values[:, 0], curve.values[:, 1], look="marked"),
        Curve("before balancing", before[0], before[1], look="points"),
    ]
    along = Along(curve.second.words, curve.second.unit)
    title = curve.first.words[:1].upper() + curve.first.words[1:]
    chart = Chart("trade_off", title, curve.first.unit, along, curves)
    columns = [
        Column(curve.first.words, curve.values[:, 0].tolist(), curve.first.unit),
        Column("its bound", curve.bounds.tolist(), curve.first.unit),
        Column(curve.second.words, curve.values[:, 1].tolist(), curve.second.unit),
    ]
    if MASS not in (curve.first, curve.second):
        columns.append(Column("added mass", [design.added_mass for design in curve.designs], "kg"))
    count = len(start.conditions)
    several = f" Values are those of the worst of {count} operating conditions." if count > 1 else ""
    blocks: list[Block] = [chart, Table("designs", "", columns)]
    return (Section("Trade-off", (), blocks, (), f"Each point is a proved optimum.{several}", _press_of_page(start, page), "balance"),)


def _press_of_page(balanced: BalancedPress, page: Reactions | None) -> Linkage:
    """The press of a page if it is one of those before or after balancing; else the press before balancing, which the page refuses."""
    before = (condition.set_up(balanced.original) for condition in balanced.conditions)
    presses = itertools.chain((balanced.press, *balanced.presses), before)
    if page is not None:
        return next((press for press in presses if is_same_press(press, page._press)), balanced.original)
    return balanced.original


# ------------------------------------------------------------------------------------------------------------------------------ numbers


def _limited(balanced: BalancedPress) -> list[Figure]:
    """The added mass, and every limited criterion in its worst operating condition next to its limit."""
    count = len(balanced.counterweights)
    weights = "in one counterweight" if count == 1 else f"in {count} counterweights"
    beside = f"{weights}, beside {quantity('kg').text(moving_mass(balanced.original), 5)} of moving mass"
    figures = [Figure("added mass", balanced.added_mass, "kg", beside, balanced.limits.get(MASS))]
    for target, limit in balanced.limits.items():
        if isinstance(target, AddedMass):
            continue
        changes = [change for change in balanced.changes if change.criterion == target]
        worst = max(changes, key=lambda change: change.after)
        where = condition_name(balanced, worst.condition) if len(balanced.conditions) > 1 else ""
        figures.append(Figure(target.words, worst.after, target.unit, where, limit, kind=KINDS[target.quantity]))
    return figures


def _objective(balanced: BalancedPress) -> list[Figure]:
    """The objective before and after, with its proven bound."""
    if balanced.unit:
        (target,) = balanced.objective
        before = before_balancing(balanced, target)
        named = f"{target.words}, before"
        where = ""
    else:
        before = sum(
            weight * before_balancing(balanced, target) / max(change.before for change in balanced.changes if change.criterion == target)
            for target, weight in balanced.objective.items()
            if not isinstance(target, AddedMass)
        )
        named, where = "weighted sum, before", "each criterion relative to before"
    unit, gap = balanced.unit or "-", balanced.value - balanced.bound
    rounding = abs(gap) < ROUNDING * (abs(before) or abs(balanced.value))
    return [
        Figure(named, before, unit, where),
        Figure("reached", balanced.value, unit),
        Figure("proven bound", balanced.bound, unit, "no counterweights in these regions have less"),
        Figure("gap", 0.0 if rounding else gap, unit),
    ]


def before_balancing(balanced: BalancedPress, target: Target) -> float:
    """A criterion that was minimised or limited, before balancing: its worst value or its mean by shares. No mass is added then."""
    values = [change.before for change in balanced.changes if change.criterion == target] or [0.0]
    return over_conditions(balanced.shares, values)


def _checks(balanced: BalancedPress) -> list[Figure]:
    proof = "largest violation of the conditions of optimality, relative to before"
    figures = [Figure("proof of the optimum", f"{balanced.residual:.3g}", "-", proof)]
    if balanced.between_states is not None:
        words = "most by which a criterion is larger there, relative to before"
        figures.append(Figure("between the states", balanced.between_states, "share", words))
    return figures


def _note(balanced: BalancedPress) -> str:
    """What was minimised under which limits, and in which motion."""
    objective = balanced.objective
    if balanced.unit:
        (target,) = objective
        what = target.words
    else:
        what = f"{' + '.join(f'{weight:g} x {target.words}' for target, weight in objective.items())}, each relative to before"
    limits = "; ".join(f"{target.words} at most {limit:g} {target.unit}" for target, limit in balanced.limits.items())
    if len(balanced.conditions) == 1:
        counted = f"The motion: {condition_in_words(balanced.conditions[0])}."
    elif balanced.shares is None:
        counted = "The worst operating condition counts."
    else:
        counted = "The mean of the operating conditions by their shares counts."
    least = f"The counterweights have the least {what}{f', with {limits}' if limits else ''}."
    return f"{least} {counted}"


# ------------------------------------------------------------------------------------------------------------------------------- tables


def condition_in_words(condition: OperatingCondition) -> str:
    """Speed, number of states and loads of an operating condition."""
    speed, states = condition.motion.crank_speed, f"{len(condition.motion.crank_angle)} states"
    even = speed.ndim == 1 and abs(speed - speed[0]).max() <= ROUNDING * abs(speed[0])
    loads = f", {len(condition.loads)} load{'s' if len(condition.loads) > 1 else ''}" if condition.loads else ""
    motion = f"{speed[0] / RPM:g} r/min of joint {condition.motion.drivers[0]}, {states}" if even else f"a motion of {states}"
    return f"{motion}{loads}"


def _conditions(balanced: BalancedPress) -> Table:
    names = [condition_name(balanced, number) for number in range(len(balanced.conditions))]
    columns = [Column("condition", names), Column("motion", [condition_in_words(each) for each in balanced.conditions])]
    if balanced.shares is not None:
        columns.append(Column("share", balanced.shares.tolist(), "share"))
    return Table("conditions", "Operating conditions", columns)


def _counterweights(balanced: BalancedPress) -> Table:
    """The counterweights; those of one operating condition with its name."""
    rows = list[tuple[str, Counterweight]]()
    for number, weights in enumerate(balanced.settings):
        for weight in weights:
            shared = all(weight in others for others in balanced.settings)
            if not (shared and number):
                rows.append(("" if shared else condition_name(balanced, number), weight))
    several = any(condition for condition, _ in rows)
    columns = [Column("link", [weight.link for _, weight in rows])]
    columns += [Column("condition", [condition for condition, _ in rows])] if several else []
    columns.append(Column("mass [kg]", [float(weight.mass) for _, weight in rows]))
    columns += [Column(axis, [float(weight.position[i]) for _, weight in rows], "height") for i, axis in enumerate("xyz")]
    columns.append(Column("inertia [kg m2]", [float(weight.inertia) for _, weight in rows]))
    note = "Centres of mass in the link's own frame; a counterweight that replaces a link's own mass is all of that mass."
    return Table("counterweights", "Counterweights", columns, note, most=200)


def _criteria(name: str, title: str, balanced: BalancedPress, changes: Sequence[CriterionChange]) -> Table:
    """Criteria before and after, in each operating condition."""
    columns = [Column("", [change.criterion.words for change in changes])]
    if len(balanced.conditions) > 1:
        columns.append(Column("condition", [condition_name(balanced, change.condition) for change in changes]))
    columns += [Column("before", [change.before for change in changes]), Column("after", [change.after for change in changes])]
    largest: dict[str, float] = {}
    for change in changes:
        largest[change.criterion.unit] = max(largest.get(change.criterion.unit, 0.0), change.before, change.after)
    # Up to this share of the largest of its unit a criterion is shown as 0, and has no change.
    seen = [max(change.before, change.after) > 1e-6 * largest[change.criterion.unit] for change in changes]
    shares = [change.change if is_seen else None for change, is_seen in zip(changes, seen, strict=True)]
    columns.append(Column("change", shares, "share", 1.0))
    limits = [balanced.limits.get(change.criterion) for change in changes]
    columns += [Column("at most", limits)] if any(limit is not None for limit in limits) else []
    return Table(name, title, columns, most=200, quantities=[change.criterion.unit for change in changes])


def _active(balanced: BalancedPress) -> Table:
    columns = [
        Column("", [active.constraint for active in balanced.active]),
        Column("", [_price_in_words(balanced, active) for active in balanced.active]),
    ]
    return Table("active", "Held back by", columns, most=200)


def _price_in_words(balanced: BalancedPress, active: ActiveConstraint) -> str:
    """The price of a constraint in words; the shape of a region has none."""
    if active.price is None:
        return ""
    units = {limit_words(target, limit): target.unit for target, limit in balanced.limits.items()}
    unit = units.get(active.constraint, MASS.unit)  # all other constraints on numbers are on masses of regions
    falls = f"{active.price:.3g} {balanced.unit}".rstrip()
    return f"the objective falls by {falls} for each {unit} relaxed"


# ------------------------------------------------------------------------------------------------------------------------------- charts


def _shaking(balanced: BalancedPress) -> Chart:
    """The shaking force in the first operating condition, before and after."""
    condition = balanced.conditions[0]
    charts = dict[str, Chart]()
    for words, press, motion in (
        ("before", condition.set_up(balanced.original), balanced.reactions_before[0].motion),
        ("after", balanced.presses[0], balanced.reactions_after[0].motion),
    ):
        # with all bearings, by which rounding is known; balancing computes only those that are asked for
        reactions = inverse_dynamics(press, motion, condition.loads)
        drawn = drawn_states(reactions)
        charts[words] = shaking_of(drawn, along_states(reactions, drawn))
    along, curves = charts["before"].along, list[Curve]()
    for words, chart in charts.items():
        same = np.array_equal(np.asarray(chart.along.values), np.asarray(along.values))
        curves += [Curve(f"{curve.name}, {words}", curve.y, None if same else chart.along.values) for curve in chart.curves]
    return Chart("shaking", "Shaking force before and after", "N", replace(along, of=None), curves)


SECTIONS = {BalancedPress: balanced_press, TradeOffCurve: trade_off}
"""How results of this room are described."""
