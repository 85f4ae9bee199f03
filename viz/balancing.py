"""Balancing of the JF75G-125 and the ZXN2-3000(B): the tables of docs/balancing.md, and its picture.

python viz/balancing.py
"""

from collections.abc import Callable, Mapping
from pathlib import Path

from matplotlib.figure import Figure

import pinpress as pp
from pinpress.accuracy.work_precision import least_seconds

HERE = Path(__file__).parent
VERTICAL, HORIZONTAL = pp.balancing.Range("shaking_force", "z"), pp.balancing.Range("shaking_force", "x")
ADDED = pp.balancing.AddedMass()
POINTS = 720
REPEATED = 5  # of which the least time counts

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


def jf75g() -> dict[str, Callable[[], pp.balancing.BalancedPress]]:
    """The thesis' problem at 300 strokes/min."""
    press = pp.load("jf75g_125")
    motion = pp.cycle(press, speed=300 * pp.RPM, points=POINTS)
    counterweight = pp.balancing.CounterweightRegion("counterweight", replaces=True)
    shape_kept = [pp.balancing.CounterweightRegion("auxiliary_rod", replaces=True), counterweight]
    # (5-15): centre of mass of the auxiliary rod 300 to 400 mm from its crank pin
    placed = [
        pp.balancing.CounterweightRegion("auxiliary_rod", corners=((0.3, 0, 0), (0.4, 0, 0)), mass=(50, 200), replaces=True),
        counterweight,
    ]
    return {
        "optimum": lambda: pp.balancing.balance(press, motion, regions=shape_kept, minimise=VERTICAL),
        "optimum with a rod of 50 kg or more, its centre of mass within (5-15)": lambda: pp.balancing.balance(
            press, motion, regions=placed, minimise=VERTICAL
        ),
    }


def on_the_way(rod: float, counterweight: float) -> float:
    """Range [N] with other masses [kg] of auxiliary rod and counterweight, of the same shape."""
    press = pp.load("jf75g_125")
    fixed = [
        pp.balancing.CounterweightRegion("auxiliary_rod", replaces=True, mass=(rod, rod)),
        pp.balancing.CounterweightRegion("counterweight", replaces=True, mass=(counterweight,) * 2),
    ]
    return (
        pp.balancing.balance(press, pp.cycle(press, speed=300 * pp.RPM, points=POINTS), regions=fixed, minimise=VERTICAL).changes[0].after
    )


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
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    masses = ["0", *(_masses(design) for design in found.designs)]
    for name, values, added in zip(found.names, found.values, masses, strict=True):
        lines.append(f"| {name} | {' | '.join(f'{value:.0f}' for value in values)} | {values.max():.0f} | {added} |")
    return "\n".join(lines)


def _masses(design: pp.balancing.BalancedPress) -> str:
    """The mass of the counterweight, or those for every die."""
    found = dict.fromkeys(f"{weight.mass:+.1f}" for weights in design.settings for weight in weights)
    return ", ".join(found)


def jf75g_table() -> str:
    lines = ["| JF75G-125, 300 strokes/min | m5 [kg] | m6 [kg] | thesis [N] | pinpress [N] |", "|---|---|---|---|---|"]
    for what, (rod, counterweight, printed) in PATH.items():
        lines.append(f"| {what} | {rod:.2f} | {counterweight:.2f} | {printed:.2f} | {on_the_way(rod, counterweight):.2f} |")
    for what, solve in jf75g().items():
        best = solve()
        rod, counterweight = (weight.mass for weight in best.counterweights)
        lines.append(f"| {what} | {rod:.4f} | {counterweight:.4f} | | {best.changes[0].after:.4g} |")
    return "\n".join(lines)


def picture(found: Mapping[str, pp.balancing.TradeOffCurve]) -> Figure:
    """A chart for each pair of criteria, one below the other."""
    pairs: dict[tuple[str, str], dict[str, pp.balancing.TradeOffCurve]] = {}
    for name, curve in found.items():
        pairs.setdefault((curve.first.words, curve.second.words), {})[name] = curve
    figure = Figure(figsize=(6.3, 2.6 * len(pairs)), layout="constrained")
    for axes, some in zip(figure.subplots(len(pairs), 1), pairs.values(), strict=True):
        pp.plots.draw(some, "trade_off", ax=axes)
    return figure


def curves() -> dict[str, pp.balancing.TradeOffCurve]:
    """Horizontal against vertical range for some added masses, and both against added mass."""
    press = pp.load("zxn2_3000b")
    motion = pp.cycle(press, speed=70 * pp.RPM, points=POINTS)
    found = {
        f"{mass:.0f} kg added": pp.balancing.trade_off(
            press, motion, regions=THREE_LINKS, first=HORIZONTAL, second=VERTICAL, limits={ADDED: mass}, points=25
        )
        for mass in (350.0, TOTAL, 1000.0)
    }
    found["horizontal"] = pp.balancing.trade_off(press, motion, regions=THREE_LINKS, first=HORIZONTAL, second=ADDED, points=25)
    found["vertical"] = pp.balancing.trade_off(
        press, motion, regions=THREE_LINKS, first=VERTICAL, second=ADDED, limits={ADDED: 1000.0}, points=25
    )
    return found


if __name__ == "__main__":
    from light import light  # type: ignore[import-not-found]  # beside this script

    print(table())
    print("\nOne call of balance, with the reactions before and after:")
    for what, solve in jf75g().items():
        print(f"  {what}: {1e3 * least_seconds([solve], REPEATED)[0]:.0f} ms")
    print(light(pp.plots.save(picture(curves()), HERE / "balancing.png")))
