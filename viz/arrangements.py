"""The JF75G-125's crank-slider through the classical balancing arrangements, and the machines of chapter 1 of Zhang 2007 beside it: the
page viz/arrangements.md, and its picture.
"""

from collections.abc import Sequence

import numpy as np
from make import ROOT, VIZ, write
from matplotlib.figure import Figure
from scipy.optimize import brentq
from support.markdown import table

import pinpress as pp
from pinpress.balancing import Counterweight, classical, with_counterweights

SPEED = 300 * pp.RPM
POINTS = 720
RADIUS = 0.15  # of counterweights on the crank [m]
ROD_RADIUS = 0.30  # of the one on the rod
AUXILIARY = 0.0297  # crank radius of the opposed crank-slider [m]
SHAFTS = 0.5  # between them [m]
STROKES, DIE = (20.0, 30.0, 40.0), 400.0  # [mm], [kg]
AIDA, PIRICA = "balance slide, Fig. 1-3", "double knuckle, Fig. 1-4"
SHIPPED = {
    "driven from above, Fig. 1-1 (a)": "jf75g_125_plain",
    "driven from below, Fig. 1-1 (b)": "underdrive",
    "geared blocks, Fig. 1-2": "eccentric_blocks",
    AIDA: "aida_balance_slide",
    PIRICA: "pirica_double_knuckle",
    "opposed, 3.5": "jf75g_125",
    "symmetric, 3.6": "jf75g_125_symmetric",
}
COLOURS = ("0.35", "C1", "C2", "C3", "C4", "C0", "C9")
QUANTITIES = ("force along the slide", "force across the slide", "tilting moment")
INTRODUCTION = f"""# Balancing arrangements of the JF75G-125

The plain crank-slider of Zhang 2007 (its lengths are inferred, see `urdf/jf75g_125_plain.urdf`) at 300 strokes/min, without load, and
what the arrangements of its chapter 3 make of it. The table has ranges over a turn, with 0 where there is rounding alone, and the orders of
the crank's speed, up to 6, that an arrangement cancels. Counterweights stand on the crank at {RADIUS:g} m, on the rod at {ROD_RADIUS:g} m;
blocks of balance shafts at {RADIUS:g} m; auxiliary crank {AUXILIARY:g} m, its rod of the same ratio; shafts {SHAFTS:g} m apart. The
tilting moment is about the shaft, or midway between the shafts; the bearing force is the largest of all pins, which includes weight.
Written by `python docs/make.py arrangements`.
"""
NOTES = """
- Complete balancing holds the centre of mass still, but takes more than twice the moving mass. The moment is hundreds of times as large,
  and the crank pin carries 143 kN instead of 58 kN. No other arrangement loads the bearings more than before.
- A counterweight on the crank for half of the reciprocating mass halves the first order along the slide and brings as much across it.
- A geared pair of shafts cancels one order. The pair for the first order weighs 224 kg, that for the second 3 kg. The fourth order is left.
- The opposed press as shipped meets its balance condition for the sum of its masses, to the rounding of the auxiliary crank radius. The
  ratios of its rods are 0.05 and 0.0495, so that a little force is left along the slide. Its turning parts are not balanced by themselves,
  which leaves most of the force across. Sized exactly, the opposed press leaves no force. The moment of the rods' inertia remains; an
  auxiliary rod with mass beyond its pins (`rod_inertia`) cancels that too.
- The symmetric press does not tilt; with opposed halves nothing is left at all.
"""
MACHINES = """
## The machines of chapter 1

The thesis describes these machines in 1.2.1; they are shipped presses, with the slide of 2200 kg, the crank, the rod and the stroke of
30 mm of the JF75G-125, at 300 strokes/min without load. The thesis prints no sizes; the URDFs say what is inferred. "Added" is
the moving mass beyond that of the plain press; the moment is about the world origin, on the slide's line; the bearing force is the
largest of all pins, which includes weight.
"""
OFFSETS = """
## Another stroke, another die

The same machines balanced at 30 mm without a die, then at other strokes or with an upper die of 400 kg on the slide: range of the
vertical force [N]. The radius of the crank sets the stroke; in AIDA's machine the place of the fulcrum does, and in the opposed press the
radii of both cranks.
"""
FINDINGS = """
- In the press driven from below, columns and crosshead move too: 970 kg more shake, with 42 % more force. Its advantage is a low drive.
- The geared blocks take the first order away and leave the second, 5 % of what there was. They suit every speed, but only one die and one
  stroke: at another stroke they are too heavy or too light.
- The balance slide takes almost all of the vertical force away, as its levers swing through only 8.6 degrees. The fulcrum changes the
  stroke of the slide but not that of the balance slide, so that the balance is gone at another stroke, as the thesis says. Crank and rod
  stay unbalanced across. Crank and guide block move both slides, so that their forces add up in the bearings of the crank: 130 kN where the
  plain press has 59 kN. The crank stands 0.4 m beside the slide, which gives the largest moment of all.
- The double knuckle keeps the first order balanced at every stroke, as one crank moves slide and weights: less than 0.3 % of it is left at
  20 and 40 mm. The thesis calls its vertical balance nearly perfect. Here a fifth of the force is left, because our knees
  move the slide with a second order too, which no weight on the arms cancels. (Knees bent more have less of it: arms of 125 degrees instead
  of 110, with a crank of 8.7 mm and weights of 1226 kg, leave 6 %.) The force across is that of crank and rod alone, at O, as the thesis
  says.
- Each die asks for its own weight: 400 kg more on the slide add a first order of 11.8 kN in every machine.
  [How to set weights anew](../docs/balancing.md#balance-that-survives-a-change-of-die).
"""
PICTURE = """
![Vertical shaking force of each machine over a turn, and its range over the stroke](arrangements.png)
"""


def presses() -> dict[str, pp.Linkage]:
    """The press without balancing, and in every arrangement."""
    plain = pp.load("jf75g_125_plain")
    opposed = classical.with_opposed_balancer(plain, AUXILIARY)
    main = classical.as_crank_slider(plain)
    similar = AUXILIARY / main.crank_radius  # lengths of the auxiliary crank-slider times this, masses divided by it
    share = main.rod_share.real
    even = main.rod_mass * similar * main.rod_length**2 * share * (1 - share) - main.residual_inertia
    return {
        "none": plain,
        "complete": with_counterweights(plain, classical.complete_balance(plain, rod_radius=ROD_RADIUS, crank_radius=RADIUS)),
        "approximate, share 0.5": with_counterweights(plain, [classical.approximate_balance(plain, RADIUS)]),
        "balance shafts, order 1": classical.with_balance_shafts(plain, radius=RADIUS, shaft_distance=SHAFTS, orders=[1]),
        "balance shafts, orders 1 and 2": classical.with_balance_shafts(plain, radius=RADIUS, shaft_distance=SHAFTS),
        "opposed, as shipped (`jf75g_125`)": pp.load("jf75g_125"),
        "opposed": opposed,
        "opposed, rod that cancels the moment": classical.with_opposed_balancer(plain, AUXILIARY, rod_inertia=even),
        "symmetric": classical.mirrored(plain, SHAFTS),
        "symmetric, opposed halves": classical.mirrored(opposed, SHAFTS),
    }


def arrangements_table() -> str:
    """A row an arrangement."""
    rows, before, plain = [], None, 0.0
    for name, press in presses().items():
        result = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=POINTS))
        mass = sum(inertia.mass for inertia in press.model.inertias)
        before, plain = before or result, plain or mass
        changes = classical.compare_harmonics(before, result)
        remaining = {change.quantity for change in changes if change.change in ("reduced", "unchanged", "raised")}
        sizes = [size if quantity in remaining else 0.0 for size, quantity in zip(_ranges(result), QUANTITIES, strict=True)]
        cells = [*map(_figure, (*sizes, np.ptp(result.driving_torque))), _hardest(result)[0], _figure(mass - plain)]
        rows.append((name, *cells, *(_cancelled(changes, quantity) for quantity in QUANTITIES)))
    titles = ("vertical force [N]", "lateral force [N]", "tilting moment [N m]", "driving torque [N m]", "bearing force [N]")
    heads = ("arrangement", *titles, "added mass [kg]", "cancelled: vertical", "lateral", "tilting")
    return table(heads, rows, 6)


def _ranges(result: pp.Reactions) -> tuple[float, ...]:
    """Of the vertical and the lateral force and of the tilting moment over the turn."""
    force = result.shaking_force
    return tuple(float(np.ptp(values)) for values in (force[:, 2], force[:, 0], result.shaking_moment[:, 1]))


def machines() -> dict[str, pp.Linkage]:
    """The shipped machines, by what they are."""
    return {words: pp.load(name) for words, name in SHIPPED.items()}


def machines_table() -> str:
    """A row a machine."""
    rows, plain = [], 0.0
    for words, press in machines().items():
        result = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=POINTS))
        mass = sum(inertia.mass for inertia in press.model.inertias)
        plain = plain or mass
        hardest, least = _hardest(result)
        cells = [_figure(size if size > least else 0.0) for size in (*_ranges(result), float(np.ptp(result.driving_torque)))]
        rows.append((f"{words} (`{SHIPPED[words]}`)", *cells, hardest, _figure(mass - plain)))
    heads = ("vertical force [N]", "lateral force [N]", "moment [N m]", "driving torque [N m]", "bearing force [N]", "added mass [kg]")
    return table(("machine", *heads), rows, 6)


def _hardest(reactions: pp.Reactions) -> tuple[str, float]:
    """The largest force of all bearings and where it is, and what is rounding beside it [N]."""
    largest = {name: float(np.linalg.norm(force, axis=1).max()) for name, force in reactions.bearing_force.items()}
    top = (1 - 1e-9) * max(largest.values())
    worst = next(name for name, size in largest.items() if size >= top)  # of two that are mirror images the first
    return f"{_figure(largest[worst])} in {worst}", 1e-9 * largest[worst]


def at_stroke(name: str, stroke: float) -> pp.Linkage:
    """A shipped machine set to a stroke [mm] by what its builder would change."""
    pins = ROOT / "urdf" / f"{SHIPPED[name]}.yaml"
    if name == AIDA:
        return pp.build(pins, f=400 / (1 + stroke / 30))
    return pp.build(pins, r=_knuckle_radius(stroke) if name == PIRICA else stroke / 2)


def _knuckle_radius(stroke: float) -> float:
    """The crank radius [mm] with which the knees make a stroke [mm]."""

    def missing(radius: float) -> float:
        press = pp.build(ROOT / "urdf" / f"{SHIPPED[PIRICA]}.yaml", r=radius)
        return float(1e3 * np.ptp(pp.cycle(press, 1.0, points=180).slide_position) - stroke)

    return float(brentq(missing, 0.2 * stroke, 0.7 * stroke, xtol=1e-6))


def offsets_table() -> str:
    """A row a machine: the vertical range at other strokes and with a die."""
    rows = []
    for words, name in SHIPPED.items():
        with_die = with_counterweights(pp.load(name), [Counterweight("slide", DIE)])
        rows.append((words, *(_figure(_vertical(press)) for press in (*(at_stroke(words, stroke) for stroke in STROKES), with_die))))
    return table(("machine", *(f"{stroke:g} mm" for stroke in STROKES), f"30 mm, die of {DIE:g} kg"), rows, 4)


def _vertical(press: pp.Linkage) -> float:
    return float(np.ptp(pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=POINTS), bearings=()).shaking_force[:, 2]))


def picture(strokes: Sequence[float]) -> Figure:
    """Force over a turn of each machine, and its vertical range over the stroke [mm]."""
    figure = Figure(figsize=(9.6, 3.9), layout="constrained")
    over_turn, over_stroke = figure.subplots(1, 2)
    for (words, press), colour in zip(machines().items(), COLOURS, strict=True):
        motion = pp.cycle(press, SPEED, points=POINTS)
        force = pp.inverse_dynamics(press, motion, bearings=()).shaking_force[:, 2] / 1e3
        over_turn.plot(np.degrees(motion.crank_angle), force - force.mean(), color=colour, label=words)
        over_stroke.plot(strokes, [_vertical(at_stroke(words, stroke)) / 1e3 for stroke in strokes], color=colour, marker="o", markersize=3)
    over_turn.set(
        xlabel="crank angle from bottom dead centre [deg]", ylabel="vertical shaking force less weight [kN]", xticks=range(0, 361, 90)
    )
    over_stroke.set(xlabel="stroke [mm], balanced at 30", ylabel="range of the vertical force [kN]", ylim=(0, None))
    for axes in (over_turn, over_stroke):
        axes.grid(alpha=0.25)
        axes.spines[["top", "right"]].set_visible(False)
    handles, names = over_turn.get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=3, frameon=False)
    return figure


def _figure(number: float) -> str:
    return np.format_float_positional(number, 5, fractional=False, trim="-")


def _cancelled(changes: tuple[classical.HarmonicChange, ...], quantity: str) -> str:
    """Orders that are cancelled; all of them where none is left."""
    there = [change for change in changes if change.quantity == quantity and change.before > 0 and change.change != "none"]
    orders = [str(change.order) for change in there if change.change == "cancelled"]
    return "all" if len(orders) == len(there) else ", ".join(orders) or "none"


def page() -> str:
    """The page in Markdown."""
    return "\n".join([INTRODUCTION, arrangements_table(), NOTES + MACHINES, machines_table(), OFFSETS, offsets_table(), FINDINGS + PICTURE])


def main(quick: bool = False) -> None:
    """Write the page and its picture; ``quick``: over two strokes."""
    write(VIZ / "arrangements.md", page())
    write(VIZ / "arrangements.png", picture((20.0, 40.0) if quick else (12.0, 16.0, 20.0, 24.0, 28.0, 30.0, 32.0, 36.0, 40.0)))
