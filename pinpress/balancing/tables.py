"""What an engineer reads off a balanced press, as text and columns: counterweights, the proof, measures before and after."""

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from ..common.units import RPM
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..linkage.linkage import Linkage
from ..visual import charts
from .mass_response import Case, moving_mass
from .objectives import AddedMass, Measure, Peak, Range
from .program import limit_words

if TYPE_CHECKING:
    from .result import Active, Balance, Outcome

MASS = AddedMass()


def effects(balance: "Balance") -> "tuple[Outcome, ...]":
    """What balancing does to the rest of the press, case by case: range of the driving torque (of several their peak), peak of every
    bearing force, range of every component of shaking force and shaking moment. Measures that are outcomes already are left out.

    What is zero but for rounding is 0, and left out where it is so before and after in all cases.
    """
    from .result import Outcome  # which calls this module

    asked = {outcome.measure for outcome in balance.outcomes}
    before, after = (
        [inverse_dynamics(press, some.motion, case.loads) for some, case in zip(known, balance.cases, strict=True)]
        for press, known in ((balance.original, balance.before), (balance.press, balance.after))
    )
    rounding, found = [charts.rounding(reactions) for reactions in before], list[Outcome]()
    for measure in _measures(balance.original):
        rows = [
            Outcome(measure, case, _clean(measure, then, least), _clean(measure, now, least))
            for case, (then, now, least) in enumerate(zip(before, after, rounding, strict=True))
        ]
        if measure not in asked and any(row.before or row.after for row in rows):
            found += rows
    return tuple(found)


def columns(balance: "Balance") -> dict[str, list[object]]:
    """Measures as columns, those asked for and limited, then the effects on the rest; None where there is no value."""
    rows = [*balance.outcomes, *balance.effects]
    return {
        "measure": [row.measure.words for row in rows],
        "unit": [row.measure.unit for row in rows],
        "case": [row.case for row in rows],
        "before": [row.before for row in rows],
        "after": [row.after for row in rows],
        "change [-]": [None if math.isnan(row.change) else row.change for row in rows],
        "limit": [balance.limits.get(row.measure) for row in rows],
    }


def counterweight_columns(balance: "Balance") -> dict[str, list[object]]:
    """Counterweights as columns, in the order of the balance; positions in the links' own frames."""
    weights = balance.counterweights
    return {
        "link": [weight.link for weight in weights],
        "mass [kg]": [weight.mass for weight in weights],
        **{f"{axis} [m]": [weight.position[i] for weight in weights] for i, axis in enumerate(charts.AXES)},
        "inertia [kg m2]": [weight.inertia for weight in weights],
    }


def text(balance: "Balance") -> str:
    """Counterweights, objective with its proof, what holds it back, and all measures before and after; units beside every number."""
    heads = [_motion(case) for case in balance.cases]
    asked, rest = [list(_cells(balance, rows)) for rows in (balance.outcomes, balance.effects)]
    width = max(len(cells[0]) for cells in [*asked, *rest])
    return "\n".join(
        [
            f"{balance.original.name}, balanced: {heads[0]}" if len(heads) == 1 else f"{balance.original.name}, balanced in",
            *(f"  case {number}: {words}" for number, words in enumerate(heads) if len(heads) > 1),
            *_counterweights(balance),
            *_objective(balance),
            *_active(balance),
            *_table("Measures", balance, asked, width),
            *_table("The rest of the press", balance, rest, width),
            "",
            "Checks",
            f"  {'proof of the optimum':26}{balance.residual:12.3g} largest violation of its conditions, relative to before",
        ]
    )


def _measures(press: Linkage) -> Iterator[Measure]:
    yield Range("driving_torque") if len(press.drivers) == 1 else Peak("driving_torque")
    yield from (Peak("bearing_force", bearing=bearing) for bearing in press.bearings)
    yield from (Range(quantity, axis) for quantity in ("shaking_force", "shaking_moment") for axis in charts.AXES)


def _clean(measure: Measure, reactions: Reactions, least: charts.Rounding) -> float:
    """A measure, 0 where it is rounding."""
    value = measure.value(reactions)
    return value if value > (least.force if measure.unit == "N" else least.moment) else 0.0


def _motion(case: Case) -> str:
    """A case in words."""
    speed, states = case.motion.crank_speed, f"{len(case.motion.crank_angle)} states"
    even = speed.ndim == 1 and abs(speed - speed[0]).max() <= charts.ROUNDING * abs(speed[0])
    loads = f", {len(case.loads)} load{'s' if len(case.loads) > 1 else ''}" if case.loads else ""
    return f"{speed[0] / RPM:g} r/min of joint {case.motion.drivers[0]}, {states}{loads}" if even else f"a motion of {states}{loads}"


def _counterweights(balance: "Balance") -> list[str]:
    weights, most = balance.counterweights, balance.limits.get(MASS)
    width = max(26, *(len(weight.link) + 2 for weight in weights)) if weights else 26
    heads = ("mass [kg]", "x [m]", "y [m]", "z [m]", "inertia [kg m2]")
    limited = "" if most is None else f", at most {most:g} kg"
    return [
        "",
        "Counterweights (centre of mass in the link's own frame; one in place of the link's own mass is all of that link's)",
        f"  {'':{width}}" + "".join(f"{head:>16}" for head in heads),
        *(
            f"  {weight.link:{width}}" + "".join(f"{number:16.6g}" for number in (weight.mass, *weight.position, weight.inertia))
            for weight in weights
        ),
        f"  {'added mass':{width}}{balance.added_mass:16.6g} kg, to {moving_mass(balance.original):.6g} kg that move{limited}",
    ]


def _objective(balance: "Balance") -> list[str]:
    terms, unit = balance.objective, balance.unit
    if unit:
        (target,) = terms
        what, before = target.words, balance.outcomes[0].before if isinstance(target, Measure) else 0.0
    else:
        what = (
            f"{' + '.join(f'{weight:g} x {target.words}' for target, weight in terms.items())}; each relative to before, of its worst case"
        )
        before = sum(weight for target, weight in terms.items() if isinstance(target, Measure))
    return [
        "",
        f"Objective: {what}",
        f"  {'before':26}{before:12.6g} {unit}".rstrip(),
        f"  {'reached':26}{balance.value:12.6g} {unit}".rstrip(),
        f"  {'proven bound':26}{balance.bound:12.6g} {unit:7}no counterweights in these rooms have less",
        f"  {'gap':26}{balance.value - balance.bound:12.3g} {unit}".rstrip(),
    ]


def _active(balance: "Balance") -> list[str]:
    if not balance.active:
        return []
    width = max(len(active.constraint) for active in balance.active)
    return ["", "Held back by", *(f"  {active.constraint:{width}}{_price(balance, active)}".rstrip() for active in balance.active)]


def _price(balance: "Balance", active: "Active") -> str:
    """What it would be worth to let a constraint out; the shape of a room has no price."""
    if active.price is None:
        return ""
    units = {limit_words(target, limit): target.unit for target, limit in balance.limits.items()}
    unit = units.get(active.constraint, MASS.unit)  # all other constraints on numbers are on masses of rooms
    falls = f"{active.price:.3g} {balance.unit}".rstrip()
    return f"   the objective falls by {falls} for each {unit} let out"


def _cells(balance: "Balance", rows: "Sequence[Outcome]") -> Iterator[list[str]]:
    """Name with unit, case where there are several, before, after, change and limit of measures."""
    for row in rows:
        limit = balance.limits.get(row.measure)
        yield [
            f"{row.measure.words} [{row.measure.unit}]",
            f"{row.case}" if len(balance.cases) > 1 else "",
            f"{row.before:.6g}",
            f"{row.after:.6g}",
            "" if math.isnan(row.change) else f"{round(100 * row.change, 2) + 0.0:+.2f} %",
            "" if limit is None else f"{limit:g}",
        ]


def _table(title: str, balance: "Balance", rows: list[list[str]], width: int) -> list[str]:
    heads = [title, "case" if len(balance.cases) > 1 else "", "before", "after", "change", "at most" if any(row[5] for row in rows) else ""]
    kept = [k for k in range(len(heads)) if heads[k]]
    lines = [
        "".join(f"{indent}{cells[k]:{width + 4 - len(indent)}}" if k == 0 else f"{cells[k]:>{6 if k == 1 else 14}}" for k in kept).rstrip()
        for indent, cells in [("", heads), *(("  ", row) for row in rows)]
    ]
    return ["", *lines] if rows else []
