"""Zhang 2007, chapter 1 and 6.2: what it says of the balance of other machines, and the upper die that is balanced with the slide.

The machines of Figs 1-1 to 1-4 are shipped presses with the stroke and slide of the JF75G-125. What is inferred of them stands in their
URDFs.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any

from validation.rows import FORMULA, Row, Table
from validation.zhang2007_balancing import (
    AUXILIARY,
    CRANK,
    GRAVITY,
    POINTS,
    RADIUS,
    ROD,
    SLIDE,
    SPEED,
    lateral,
    opposed,
    plain,
    tilting,
    vertical,
)

from pinpress import RPM, Linkage, build, cycle, load
from pinpress.balancing import (
    Counterweight,
    CounterweightRegion,
    OperatingCondition,
    Range,
    classical,
    compare_conditions,
    with_counterweights,
)

KNUCKLE_CRANK = 0.014679  # crank radius of the double knuckle [m]
DIES = (0.0, 200.0, 400.0)  # upper dies [kg]; ours
STROKES = (20.0, 30.0, 40.0)  # [mm]; ours
DOWN = (0.0, 0.0, -GRAVITY)


def machine_rows() -> Iterator[Row]:
    """What the text says of Figs 1-1 to 1-4, and of the opposed slide, in words."""

    @cache
    def machine(name: str) -> Linkage:
        return load(name, gravity=DOWN)

    def at_other_speeds() -> str:
        left = [100 * vertical(machine("eccentric_blocks"), rpm * RPM) / vertical(plain(), rpm * RPM) for rpm in (200, 400)]
        return (
            f"{left[0]:.1f} % of the plain press is left at 200 and {left[1]:.1f} % at 400 r/min: forces of inertia of rigid links all grow"
            " with the square of the speed. Agrees: no"
        )

    def balance_slide() -> str:
        press, short = machine("aida_balance_slide"), build("aida_balance_slide", gravity=DOWN, f=240)
        changed = f"{kilo(vertical(with_die(press, 400.0)))} with 400 kg, {kilo(vertical(short))} at 20 mm"
        return f"vertical range {kilo(vertical(press))}; {changed}. Agrees: yes"

    def knees() -> str:
        press = machine("pirica_double_knuckle")
        return f"vertical range {kilo(vertical(press))}, lateral {kilo(lateral(press))}: the knees leave a second order. Agrees: in part"

    def pivots() -> str:
        rotating = 2 * (CRANK + ROD / 2) * KNUCKLE_CRANK * SPEED**2  # of the crank, and of the half of the rod that turns with it
        whole = kilo(lateral(machine("pirica_double_knuckle")))
        return f"crank and rod alone have a lateral range of {kilo(rotating)}, the whole press {whole}. Agrees: yes"

    claims = {
        "Fig. 1-1 (b), driven from below: much mass goes to and fro, which shakes at speed": lambda: (
            f"vertical range {kilo(vertical(machine('underdrive')))}, from above {kilo(vertical(plain()))}. Agrees: yes"
        ),
        "Fig. 1-2, eccentric blocks: a simple balance, and incomplete": lambda: (
            f"vertical range {kilo(vertical(machine('eccentric_blocks')))}: the first order is gone, the second is left. Agrees: yes"
        ),
        "Fig. 1-2: worse with another upper die": lambda: (
            f"{kilo(vertical(with_die(machine('eccentric_blocks'), 400.0)))} with 400 kg on the slide. Agrees: yes"
        ),
        "Fig. 1-2: worse at another speed": at_other_speeds,
        "Fig. 1-3, AIDA's balance slide: balance suffers from another die and another stroke": balance_slide,
        "Fig. 1-4, Pirica HK-45: the balance is good vertically, small forces are left across": knees,
        "Fig. 1-4: across, all pivots but O cancel one another": pivots,
        "an auxiliary slide opposite to the slide: the guides' forces are left and tilt the machine": lambda: (
            f"range of the moment {tilting(opposed()):.0f} N m. Agrees: yes"
        ),
    }
    for says, gives in claims.items():
        yield Row(says, "in words", gives)


def kilo(force: float) -> str:
    """A force [N] as text."""
    return f"{force / 1e3:.2f} kN"


def with_die(press: Linkage, mass: float) -> Linkage:
    """The press with an upper die [kg], whose place on the slide does not matter to forces."""
    return with_counterweights(press, [Counterweight("slide", mass)]) if mass else press


def die_rows() -> Iterator[Row]:
    """The counterweight by the formulas of 3.5, with the upper die m7."""
    for die in DIES:

        def built(die: float = die) -> float:
            press = classical.with_opposed_balancer(plain(), AUXILIARY, die_mass=die)
            return float(press.model.inertias[press.model.getJointId("counterweight_guide")].mass)

        by_hand = RADIUS / AUXILIARY * (SLIDE + die + ROD / 2) - ROD * RADIUS / AUXILIARY / 2
        yield Row(f"m6 for m7 = {die:g} kg [kg]", f"{by_hand:.3f}", built, 1e-3, FORMULA)


def changed_dies() -> Table:
    """The opposed press with other upper dies."""
    dies = []
    for die in DIES:
        press = with_die(opposed(), die)
        dies.append(OperatingCondition(cycle(press, SPEED, points=POINTS), press=press, name=f"die of {die:g} kg"))
    weight = CounterweightRegion("counterweight", at=(0.0, 0.0, 0.0), mass=(-600.0, 600.0), reset="mass")
    return _compared("opposed, 3.5", opposed(), dies, [weight])


def changed_blocks() -> Table:
    """The press with eccentric blocks with other strokes."""
    blocks = [CounterweightRegion(f"crank_{side}", at=(-0.15, 0.0, 0.0), mass=(-100.0, 100.0), reset="mass") for side in ("left", "right")]
    return _compared("geared blocks, Fig. 1-2", *_strokes("eccentric_blocks", "r", lambda stroke: stroke / 2), blocks)


def changed_slide() -> Table:
    """The press with a balance slide with other strokes."""
    slide = CounterweightRegion("balance_slide", at=(0.0, 0.0, 0.0), mass=(-500.0, 500.0), reset="mass")
    return _compared("balance slide, Fig. 1-3", *_strokes("aida_balance_slide", "f", lambda stroke: 400 / (1 + stroke / 30)), [slide])


def _strokes(name: str, parameter: str, of_stroke: Callable[[float], float]) -> tuple[Linkage, list[OperatingCondition]]:
    """A shipped press, and its conditions with the strokes that a parameter of its table sets."""
    conditions = []
    for stroke in STROKES:
        values: dict[str, Any] = {parameter: of_stroke(stroke)}
        press = build(name, gravity=DOWN, **values)
        conditions.append(OperatingCondition(cycle(press, SPEED, points=POINTS), press=press, name=f"stroke of {stroke:g} mm"))
    return load(name, gravity=DOWN), conditions


def _compared(name: str, press: Linkage, conditions: Sequence[OperatingCondition], regions: Sequence[CounterweightRegion]) -> Table:
    """Vertical ranges of the best for each condition, of the compromise, and of what is set anew, with the masses of these."""
    comparison = compare_conditions(press, conditions, regions=regions, minimise=Range("shaking_force", "z"))
    rows = []
    for design, values in enumerate(comparison.values):
        settings = comparison.designs[design - 1].settings if design else ((),)
        masses = [sum(weight.mass for weight in weights) for weights in settings]
        shown = [f"{mass:+.1f}" for mass in (masses if comparison.names[design] == "set anew" else masses[:1])]
        rows.append(
            (comparison.names[design], *(f"{value:.0f}" for value in values), ", ".join(shown).replace("+0.0", "0").replace("-0.0", "0"))
        )
    return Table((name, *(f"{each} [N]" for each in comparison.conditions), "mass more [kg]"), tuple(rows))
