"""The JF75G-125's crank-slider through the classical balancing arrangements, as the Markdown table viz/arrangements.md.

python viz/arrangements.py
"""

from pathlib import Path

import numpy as np

import pinpress as pp
from pinpress.balancing import classical
from pinpress.balancing.counterweights import with_counterweights

PAGE = Path(__file__).with_suffix(".md")
SPEED = 300 * pp.RPM
POINTS = 720
RADIUS = 0.15  # of counterweights on the crank [m]
ROD_RADIUS = 0.30  # of the one on the rod
AUXILIARY = 0.0297  # crank radius of the opposed crank-slider [m]
SHAFTS = 0.5  # between them [m]
QUANTITIES = ("force along the slide", "force across the slide", "tilting moment")
INTRODUCTION = f"""# Balancing arrangements of the JF75G-125

The plain crank-slider of Zhang 2007 (its lengths are inferred, see `urdf/jf75g_125_plain.urdf`) at 300 strokes/min, without load, and what
the arrangements of its chapter 3 make of it: ranges over a turn, 0 where there is rounding alone; and which orders of the crank's speed, of
those up to 6 that there were, are cancelled. Counterweights on the crank at {RADIUS:g} m, on the rod at {ROD_RADIUS:g} m; auxiliary crank
{AUXILIARY:g} m, its rod of the same ratio; shafts {SHAFTS:g} m apart. The tilting moment is about the shaft, or midway between the shafts.
Written by `python viz/arrangements.py`.
"""
NOTES = """
- Complete balancing holds the centre of mass still, with more than twice the moving mass; the moment is hundreds of times as large.
- Half of the reciprocating mass balanced by the crank halves the first order along the slide and brings as much across it.
- Opposed, as the shipped press is drawn: its balance condition holds for the sum of its masses, to the rounding of the auxiliary crank
  radius, and its rods' ratios are 0.05 and 0.0495, so that a little is left along the slide. What turns is not balanced by itself, which
  leaves most of the force across it. Sized exactly, no force is left. The moment is that of the rods' inertia; an auxiliary rod with mass
  beyond its pins (`rod_inertia`) cancels that too.
- Symmetric, nothing tilts; with the opposed halves nothing is left at all.
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
        "opposed, as shipped (`jf75g_125`)": pp.load("jf75g_125"),
        "opposed": opposed,
        "opposed, rod that cancels the moment": classical.with_opposed_balancer(plain, AUXILIARY, rod_inertia=even),
        "symmetric": classical.mirrored(plain, SHAFTS),
        "symmetric, opposed halves": classical.mirrored(opposed, SHAFTS),
    }


def table() -> str:
    """Markdown, one row an arrangement."""
    titles = ["arrangement", "vertical force [N]", "lateral force [N]", "tilting moment [N m]", "driving torque [N m]", "added mass [kg]"]
    lines = ["| " + " | ".join([*titles, "cancelled: vertical", "lateral", "tilting"]) + " |", "|---" + "|---:" * 5 + "|---" * 3 + "|"]
    before, plain = None, 0.0
    for name, press in presses().items():
        result = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=POINTS))
        mass = sum(inertia.mass for inertia in press.model.inertias)
        before, plain = before or result, plain or mass
        changes = classical.compare_harmonics(before, result)
        force, moment = result.shaking_force, result.shaking_moment[:, 1]
        ranges = [np.ptp(each) for each in (force[:, 2], force[:, 0], moment)]
        left = [any(c.change in ("reduced", "unchanged", "raised") for c in changes if c.quantity == quantity) for quantity in QUANTITIES]
        shown = [_figure(size if there else 0.0) for size, there in zip(ranges, left, strict=True)]
        shown += [_figure(np.ptp(result.driving_torque)), _figure(mass - plain)]
        lines.append("| " + " | ".join([name, *shown, *(_cancelled(changes, quantity) for quantity in QUANTITIES)]) + " |")
    return "\n".join(lines)


def _figure(number: float) -> str:
    return np.format_float_positional(number, 5, fractional=False, trim="-")


def _cancelled(changes: tuple[classical.HarmonicChange, ...], quantity: str) -> str:
    """Orders that are cancelled; all of them where none is left."""
    there = [change for change in changes if change.quantity == quantity and change.before > 0 and change.change != "none"]
    orders = [str(change.order) for change in there if change.change == "cancelled"]
    return "all" if len(orders) == len(there) else ", ".join(orders) or "none"


if __name__ == "__main__":
    PAGE.write_text(f"{INTRODUCTION}\n{table()}\n{NOTES}", encoding="utf-8")
    print(PAGE.read_text(encoding="utf-8"))
