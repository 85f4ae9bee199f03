"""Zhang 2007, chapter 1 and 6.2: what it says of the balance of other machines, and the upper die that is balanced with the slide.

The machines of Figs 1-1 to 1-4 are shipped presses with the stroke and slide of the JF75G-125. What is inferred of them stands in their
URDFs.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from pinpress.balancing import classical
from pinpress.balancing.comparison import compare_conditions
from pinpress.balancing.counterweights import Counterweight, OperatingCondition, with_counterweights
from pinpress.balancing.problem import Range
from pinpress.balancing.regions import CounterweightRegion
from pinpress.common.quantities import RPM
from pinpress.kinematics.cycle import cycle
from pinpress.linkage.linkage import Linkage
from pinpress.linkage.loading import load
from pinpress.pin_table.building import build
from validation.pages import BEYOND, FINDINGS, FORMULAS, Grid, PageEntry, Row, figures
from validation.zhang2007_balancing import GRAVITY, POINTS, SPEED, turning

KNUCKLE_CRANK = 0.014679  # crank radius of the double knuckle [m]
AUXILIARY = 0.0297  # auxiliary crank of the shipped press [m]
DIES = (0.0, 200.0, 400.0)  # upper dies [kg]; ours
STROKES = (20.0, 30.0, 40.0)  # [mm]; ours
MACHINES = ("underdrive", "eccentric_blocks", "aida_balance_slide", "pirica_double_knuckle")
DOWN = (0.0, 0.0, -GRAVITY)


def machines(given: Mapping[str, Linkage]) -> PageEntry:
    """What the text says of Figs 1-1 to 1-4, and of the opposed slide, beside ours."""
    under, blocks, lever, knuckle = (load(name, gravity=DOWN) for name in MACHINES)
    plain = vertical(given["jf75g_125_plain"])
    short = build("aida_balance_slide", gravity=DOWN, f=240)
    faster = [vertical(blocks, rpm * RPM) / vertical(given["jf75g_125_plain"], rpm * RPM) for rpm in (200, 400)]
    tilting = float(np.ptp(turning(given["jf75g_125"]).shaking_moment[:, 1]))
    rotating = 2 * (52.25 + 77.49 / 2) * KNUCKLE_CRANK * SPEED**2  # of the crank, and of the half of the rod that turns with it
    changed = f"{kilo(vertical(with_die(lever, 400.0)))} with 400 kg, {kilo(vertical(short))} at 20 mm"
    claims = (
        (
            "Fig. 1-1 (b), driven from below: much mass goes to and fro, which shakes at speed",
            f"vertical range {kilo(vertical(under))}, from above {kilo(plain)}",
            "yes",
        ),
        (
            "Fig. 1-2, eccentric blocks: a simple balance, and incomplete",
            f"vertical range {kilo(vertical(blocks))}: the first order is gone, the second is left",
            "yes",
        ),
        ("Fig. 1-2: worse with another upper die", f"{kilo(vertical(with_die(blocks, 400.0)))} with 400 kg on the slide", "yes"),
        (
            "Fig. 1-2: worse at another speed",
            f"{100 * faster[0]:.1f} % of the plain press is left at 200 and {100 * faster[1]:.1f} % at 400 r/min: forces of inertia of"
            " rigid links all grow with the square of the speed",
            "no",
        ),
        (
            "Fig. 1-3, AIDA's balance slide: balance suffers from another die and another stroke",
            f"vertical range {kilo(vertical(lever))}; {changed}",
            "yes",
        ),
        (
            "Fig. 1-4, Pirica HK-45: the balance is good vertically, small forces are left across",
            f"vertical range {kilo(vertical(knuckle))}, lateral {kilo(lateral(knuckle))}: the knees leave a second order",
            "in part",
        ),
        (
            "Fig. 1-4: across, all pivots but O cancel one another",
            f"crank and rod alone have a lateral range of {kilo(rotating)}, the whole press {kilo(lateral(knuckle))}",
            "yes",
        ),
        (
            "an auxiliary slide opposite to the slide: the guides' forces are left and tilt the machine",
            f"range of the moment {tilting:.0f} N m",
            "yes",
        ),
    )
    reason = (
        "The thesis shows schemes without any size. Ours are presses of these kinds with the stroke, slide, crank and rod of the"
        " JF75G-125, at 300 strokes/min; their URDFs say what is inferred. `viz/arrangements.md` compares them with those of chapter"
        " 3."
    )
    rows = tuple(Row(says, "in words", f"{gives}. Agrees: {agrees}") for says, gives, agrees in claims)
    return PageEntry(figures(1, 1, 4), "machines of others, and how they are balanced", FINDINGS, rows, reason)


def dies(given: Mapping[str, Linkage]) -> tuple[PageEntry, ...]:
    """The counterweight by the formulas of 3.5 with the upper die m7, and what one counterweight is worth with other dies."""
    return (_counterweight(given["jf75g_125_plain"]), _changed(given["jf75g_125"]))


def vertical(press: Linkage, speed: float = SPEED) -> float:
    """Range of the vertical shaking force at constant speed [rad/s], in N."""
    return float(np.ptp(turning(press, speed).shaking_force[:, 2]))


def lateral(press: Linkage) -> float:
    """Range of the lateral shaking force [N]."""
    return float(np.ptp(turning(press).shaking_force[:, 0]))


def kilo(force: float) -> str:
    """A force [N] in words."""
    return f"{force / 1e3:.2f} kN"


def with_die(press: Linkage, mass: float) -> Linkage:
    """The press with an upper die [kg], whose place on the slide does not matter to forces."""
    return with_counterweights(press, [Counterweight("slide", mass)]) if mass else press


def _counterweight(plain: Linkage) -> PageEntry:
    main = classical.as_crank_slider(plain)
    rows = []
    for die in DIES:
        press = classical.with_opposed_balancer(plain, AUXILIARY, die_mass=die)
        built = float(press.model.inertias[press.model.getJointId("counterweight_guide")].mass)
        rod = main.rod_mass * main.crank_radius / AUXILIARY
        by_hand = main.crank_radius / AUXILIARY * (main.slide_mass + die + main.rod_mass / 2) - rod / 2
        rows.append(Row(f"m6 for m7 = {die:g} kg [kg]", f"{by_hand:.3f}", built, 1e-3, None, "formula"))
    reason = (
        "m6 = L1 / L2 m_A - m4 e4 / L4, where m_A is the mass of slide, upper die and the main rod's share at the slide's pin. The thesis"
        " names m7 in 3.5 and leaves it out of its models (2.2). Ours with the inferred lengths and an auxiliary rod of the main rod's"
        " ratio."
    )
    return PageEntry(("3.5, m7",), "counterweight for slide and upper die", FORMULAS, tuple(rows), reason)


def _changed(opposed: Linkage) -> PageEntry:
    dies = []
    for die in DIES:
        press = with_die(opposed, die)
        dies.append(OperatingCondition(cycle(press, SPEED, points=POINTS), press=press, name=f"die of {die:g} kg"))
    weight = CounterweightRegion("counterweight", at=(0.0, 0.0, 0.0), mass=(-600.0, 600.0), reset="mass")
    slide = CounterweightRegion("balance_slide", at=(0.0, 0.0, 0.0), mass=(-500.0, 500.0), reset="mass")
    blocks = [CounterweightRegion(f"crank_{side}", at=(-0.15, 0.0, 0.0), mass=(-100.0, 100.0), reset="mass") for side in ("left", "right")]
    grids = (
        _compared("opposed, 3.5", opposed, dies, [weight]),
        _compared("geared blocks, Fig. 1-2", *_strokes("eccentric_blocks", "r", lambda stroke: stroke / 2), blocks),
        _compared("balance slide, Fig. 1-3", *_strokes("aida_balance_slide", "f", lambda stroke: 400 / (1 + stroke / 30)), [slide]),
    )
    reason = (
        "1.2.1 says that balance suffers from another upper die or stroke; 6.2 (4) asks for an optimum of more general use. Ours:"
        " ranges of the vertical force at 300 strokes/min, balanced for one die or stroke, by a proved compromise, and set anew for"
        " each. Between strokes no compromise beats the middle one; masses that are set anew keep the balance at all of them."
    )
    return PageEntry(("1.2.1, 6.2 (4)",), "balance and the change of die and stroke", BEYOND, (), reason, grids=grids)


def _strokes(name: str, parameter: str, of_stroke: Callable[[float], float]) -> tuple[Linkage, list[OperatingCondition]]:
    """A shipped press, and its conditions with the strokes that a parameter of its table sets."""
    conditions = []
    for stroke in STROKES:
        values: dict[str, Any] = {parameter: of_stroke(stroke)}
        press = build(name, gravity=DOWN, **values)
        conditions.append(OperatingCondition(cycle(press, SPEED, points=POINTS), press=press, name=f"stroke of {stroke:g} mm"))
    return load(name, gravity=DOWN), conditions


def _compared(name: str, press: Linkage, conditions: Sequence[OperatingCondition], regions: Sequence[CounterweightRegion]) -> Grid:
    """Vertical ranges of the best for each condition, of the compromise, and of what is set anew, with the masses of these."""
    found = compare_conditions(press, conditions, regions=regions, minimise=Range("shaking_force", "z"))
    rows = []
    for design, values in enumerate(found.values):
        settings = found.designs[design - 1].settings if design else ((),)
        masses = [sum(weight.mass for weight in weights) for weights in settings]
        shown = [f"{mass:+.1f}" for mass in (masses if found.names[design] == "set anew" else masses[:1])]
        rows.append(
            (found.names[design], *(f"{value:.0f}" for value in values), ", ".join(shown).replace("+0.0", "0").replace("-0.0", "0"))
        )
    return Grid((name, *(f"{each} [N]" for each in found.conditions), "mass more [kg]"), tuple(rows))
