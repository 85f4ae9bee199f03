"""Balancing of the JF75G-125 and the ZXN2-3000(B): the tables of docs/balancing.md, and its picture."""

from typing import Any

from make import VIZ, write
from matplotlib.figure import Figure
from support import markdown

import pinpress as pp

VERTICAL, HORIZONTAL = pp.balancing.Range("shaking_force", "z"), pp.balancing.Range("shaking_force", "x")
ADDED = pp.balancing.AddedMass()
POINTS = 720

# Zhang 2007, table 5-1: masses of auxiliary rod and counterweight [kg] and the range that ADAMS found with the thesis' geometry [N]
PATH = {"start of the thesis": (100.0, 1000.0, 2887.80), "after its 17 steps": (113.31, 1045.0, 139.07)}

THREE_LINKS = [
    pp.balancing.CounterweightRegion("crank", radius=0.3),
    pp.balancing.CounterweightRegion("rocker", radius=0.6),
    pp.balancing.CounterweightRegion("rod", radius=0.3),
]
DIES = (100.0, 200.0, 400.0)  # upper dies [kg]
DIE, ON_COUNTERWEIGHT = (0.0, 0.0, -0.485), (0.0, 0.0, 0.235)  # under the slide, and the counterweight's centre of mass [m]
TOTAL = 605.496 + 55.536  # Kong 2025: counterweights on crank and rod [kg]


def table() -> str:
    """Markdown: the thesis' search, and changes of die."""
    return f"{jf75g_table()}\n\n{dies_table()}"


def dies_table() -> str:
    """The JF75G-125 balanced for one upper die, with others."""
    press = pp.load("jf75g_125")
    conditions = []
    for mass in DIES:
        with_die = pp.balancing.with_counterweights(press, [pp.balancing.Counterweight("slide", mass, DIE)])
        motion = pp.cycle(with_die, speed=300 * pp.RPM, points=POINTS)
        conditions.append(pp.balancing.OperatingCondition(motion, press=with_die, name=f"die of {mass:g} kg"))
    weight = pp.balancing.CounterweightRegion("counterweight", at=ON_COUNTERWEIGHT, mass=(-600, 600), reset="mass")
    found = pp.balancing.compare_conditions(press, conditions, regions=[weight], minimise=VERTICAL)
    heads = ["JF75G-125, 300 strokes/min, vertical range [N]", *found.conditions, "worst", "mass on the counterweight [kg]"]
    weights = [dict.fromkeys(f"{each.mass:+.1f}" for weights in design.settings for each in weights) for design in found.designs]
    masses = ["0", *map(", ".join, weights)]  # one, or one for every die
    rows = zip(found.names, found.values, masses, strict=True)
    return markdown.table(heads, [(name, *(f"{value:.0f}" for value in (*values, values.max())), added) for name, values, added in rows])


def jf75g_table() -> str:
    """The thesis' problem at 300 strokes/min: steps of its search with ranges of ours, and the optimum."""
    press = pp.load("jf75g_125")
    motion = pp.cycle(press, speed=300 * pp.RPM, points=POINTS)

    def best(rod: dict[str, Any], counterweight: dict[str, Any]) -> pp.balancing.BalancedPress:
        regions = [pp.balancing.CounterweightRegion("auxiliary_rod", replaces=True, **rod)]
        regions.append(pp.balancing.CounterweightRegion("counterweight", replaces=True, **counterweight))
        return pp.balancing.balance(press, motion, regions=regions, minimise=VERTICAL)

    rows = []
    for what, (rod, counterweight, printed) in PATH.items():
        ours = best({"mass": (rod, rod)}, {"mass": (counterweight, counterweight)}).changes[0].after
        rows.append((what, f"{rod:.2f}", f"{counterweight:.2f}", f"{printed:.2f}", f"{ours:.2f}"))
    for what, region in {
        "optimum": {},
        "optimum with a rod of 50 kg or more, its centre of mass within (5-15)": {"corners": ((0.3, 0, 0), (0.4, 0, 0)), "mass": (50, 200)},
    }.items():
        found = best(region, {})
        rows.append((what, *(f"{weight.mass:.4f}" for weight in found.counterweights), "", f"{found.changes[0].after:.4g}"))
    return markdown.table(("JF75G-125, 300 strokes/min", "m5 [kg]", "m6 [kg]", "thesis [N]", "pinpress [N]"), rows)


def picture(points: int) -> Figure:
    """Horizontal against vertical range for some added masses, and both against added mass; a chart for each pair of criteria."""
    press = pp.load("zxn2_3000b")
    motion = pp.cycle(press, speed=70 * pp.RPM, points=POINTS)

    def curve(
        first: pp.balancing.Range, second: pp.balancing.Range | pp.balancing.AddedMass, most: float | None = None
    ) -> pp.balancing.TradeOffCurve:
        limits = {} if most is None else {ADDED: most}
        return pp.balancing.trade_off(press, motion, regions=THREE_LINKS, first=first, second=second, limits=limits, points=points)

    charts = (
        {f"{mass:.0f} kg added": curve(HORIZONTAL, VERTICAL, mass) for mass in (350.0, TOTAL, 1000.0)},
        {"horizontal": curve(HORIZONTAL, ADDED)},
        {"vertical": curve(VERTICAL, ADDED, 1000.0)},
    )
    figure = Figure(figsize=(6.3, 7.8), layout="constrained")
    for axes, curves in zip(figure.subplots(3, 1), charts, strict=True):
        pp.plots.draw(curves, "trade_off", ax=axes)
    return figure


def main(quick: bool = False) -> None:
    """Print the tables and draw the picture; ``quick``: with few points."""
    print(table())
    write(VIZ / "balancing.png", picture(3 if quick else 25))
