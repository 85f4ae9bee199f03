"""Two presses with assumed springs: compliance, bottom dead centre over speed and snap-through, as Markdown tables and viz/elasticity.png.

No document prints a stiffness: all of them, damping, break-through time and clearance are ours, of the size usual for such presses, and
marked as assumed. The presses are those of Kong 2025 and Zhang 2007.

python viz/elasticity.py
"""

from pathlib import Path

import numpy as np

import pinpress as pp
from pinpress import figures
from pinpress.breakthrough import SnapThrough, permissible_breakthrough, snap_through
from pinpress.compliance import Elasticity, elasticity
from pinpress.elastic_elements import Rod, Stiffness
from pinpress.elastic_plots import draw_dead_centre_shift, draw_elasticity, draw_snap_through
from pinpress.elastic_slide import DeadCentreShift, dead_centre_shift

PICTURE = Path(__file__).with_suffix(".png")
STEEL = 2.1e11  # modulus of elasticity [Pa]

# assumed: sections of links, radial stiffness of journal bearings with their shafts, frame, shaft from crank to gear
SPRINGS = {
    "zxn2_3000b": Stiffness(
        bearings={"A": 3e9, "B": 4e9, "C": 4e9, "D": 5e9, "E": 6e9, "F": 6e9, "slide_guide": 2e9},
        rods=[
            Rod("coupler", ("B", "C"), STEEL * 0.030 / 1.243),
            Rod("rocker", ("D", "E"), STEEL * 0.060 / 0.480),
            Rod("rod", ("E", "F"), STEEL * 0.060 / 0.480),
        ],
        shaft=3e7,
        frame=4e9,
    ),
    "jf75g_125": Stiffness(
        bearings={"O": 3e9, "P2": 4e9, "P4": 4e9, "P3": 2e9, "P5": 2e9, "slide_guide": 2e9},
        rods=[Rod("main_rod", ("P2", "P4"), STEEL * 0.030 / 0.300)],
        shaft=1e7,
        frame=3e9,
    ),
}
FORCE = {"zxn2_3000b": 3.0e6, "jf75g_125": 1.25e6}  # nominal, printed [N]
SPEEDS = {"zxn2_3000b": (50, 60, 70), "jf75g_125": (150, 300, 450, 600)}  # printed ranges [strokes/min]
CURVE = {"zxn2_3000b": 70, "jf75g_125": 600}
DIE = {"zxn2_3000b": 1500.0, "jf75g_125": 400.0}  # assumed, upper die [kg]
HEIGHT = 0.003  # assumed, of break-through above bottom dead centre [m]
DAMPING, BREAK_TIME, CLEARANCE = 0.04, 1e-3, 1e-4  # assumed [-, s, m]
PERMITTED = 0.15  # assumed, reverse load by nominal force; builders often name 10 to 20 %


def at_height(press: pp.Linkage, found: Elasticity) -> int:
    """State on the way down that is nearest to break-through."""
    down = pp.cycle(press, 1.0, angle=found.crank_angle).slide_velocity < 0
    return int(np.where(down, np.abs(found.height - HEIGHT), np.inf).argmin())


def snaps(press: pp.Linkage, name: str, found: Elasticity) -> dict[str, SnapThrough]:
    """At nominal force, with more and more in it."""
    i = at_height(press, found)
    case = FORCE[name], 1 / found.compliance[i], found.effective_mass[i] + DIE[name]
    return {
        "at once, undamped": snap_through(*case),
        f"damping ratio {DAMPING:g}": snap_through(*case, DAMPING),
        f"within {1e3 * BREAK_TIME:g} ms": snap_through(*case, DAMPING, BREAK_TIME),
        f"clearance {1e3 * CLEARANCE:g} mm": snap_through(*case, DAMPING, BREAK_TIME, CLEARANCE),
    }


def compliance_table(name: str, found: Elasticity) -> str:
    """Shares of the parts at bottom dead centre, the largest first."""
    shares = sorted(found.bottom_shares.items(), key=lambda item: -item[1])
    rows = [f"| {part} | {100 * share:.1f} % |" for part, share in shares if share > 5e-4]
    heading = f"{name}: {1e-6 * found.bottom_stiffness:.0f} kN/mm at bottom dead centre (assumed springs)"
    return "\n".join([heading, "", "| part | share of the deflection |", "|---|---:|", *rows])


def shift_table(name: str, shift: DeadCentreShift) -> str:
    """Depth over speed."""
    rows = [
        f"| {round(w / pp.RPM)} | {1e6 * inertia:+.1f} | {1e6 * true:+.1f} |"
        for w, inertia, true in zip(shift.speed, shift.by_squared_speed * shift.speed**2, shift.shift, strict=True)
    ]
    weight = f"{name}: weight alone {1e6 * (shift.standstill_position - shift.rigid_position):+.1f} µm"
    return "\n".join([weight, "", "| strokes/min | inertia at the rigid angle [µm] | true shift [µm] |", "|---:|---:|---:|", *rows])


def snap_table(name: str, cases: dict[str, SnapThrough]) -> str:
    """Reverse load, overshoot, acceleration, frequency."""
    rows = [
        f"| {what} | {1e-3 * s.reverse_force:.0f} kN, {100 * s.reverse_ratio:.1f} % | {1e3 * s.overshoot:.3f} | {s.peak_acceleration:.0f} |"
        f" {s.frequency / (2 * np.pi):.1f} |"
        for what, s in cases.items()
    ]
    some = next(iter(cases.values()))
    heading = (
        f"{name}: {1e-3 * some.force:.0f} kN let go {1e3 * HEIGHT:g} mm above bottom dead centre, {some.mass:.0f} kg, {some.energy:.0f} J"
    )
    titles = "| | reverse load | overshoot [mm] | peak acceleration [m/s2] | frequency [Hz] |"
    return "\n".join([heading, "", titles, "|---|---:|---:|---:|---:|", *rows])


def permissible_table(press: pp.Linkage, name: str, found: Elasticity) -> str:
    """Force at break-through that a reverse load of `PERMITTED` allows, over height."""
    down = pp.cycle(press, 1.0, angle=found.crank_angle).slide_velocity < 0
    rows = []
    for height in (0.001, 0.003, 0.006, 0.010):
        i = int(np.where(down, np.abs(found.height - height), np.inf).argmin())
        case = PERMITTED * FORCE[name], 1 / found.compliance[i], found.effective_mass[i] + DIE[name]
        force = permissible_breakthrough(*case, DAMPING, BREAK_TIME)[0]
        rows.append(
            f"| {1e3 * found.height[i]:.2f} | {1e-6 / found.compliance[i]:.0f} | {found.effective_mass[i]:.0f} | {1e-3 * force:.1f} |"
        )
    heading = f"{name}: reverse load of {1e-3 * PERMITTED * FORCE[name]:.0f} kN permitted"
    titles = "| height [mm] | stiffness [kN/mm] | effective mass without die [kg] | permissible break-through force [kN] |"
    return "\n".join([heading, "", titles, "|---:|---:|---:|---:|", *rows])


if __name__ == "__main__":
    with figures.drawing(19.0) as figure:
        places = figure.subplots(3, 2)
        for column, name in enumerate(SPRINGS):
            press = pp.load(name)
            centre = pp.dead_centres(press).bottom_angle
            found = elasticity(press, SPRINGS[name], centre + np.radians(np.arange(-60.0, 60.1, 0.25)))
            shift = dead_centre_shift(press, SPRINGS[name], np.array(SPEEDS[name]) * pp.RPM)
            cases = snaps(press, name, found)
            tables = compliance_table(name, found), shift_table(name, shift), snap_table(name, cases), permissible_table(press, name, found)
            print("\n\n".join(tables), end="\n\n")
            draw_elasticity(places[0, column], found)
            places[0, column].set_title(name, loc="left")
            curve = dead_centre_shift(press, SPRINGS[name], np.linspace(0.0, CURVE[name], 40) * pp.RPM)
            draw_dead_centre_shift(places[1, column], {"true bottom dead centre": curve})
            draw_snap_through(places[2, column], {what: cases[what] for what in list(cases)[1::2]})
    figures.save_plot(figure, PICTURE)
