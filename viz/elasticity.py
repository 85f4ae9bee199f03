"""Two presses with assumed springs: compliance, bottom dead centre over speed and snap-through, for docs/elasticity.md.

No document prints a stiffness: all of them, damping, break-through time and clearance are ours, of the size usual for such presses, and
marked as assumed. The presses are those of Kong 2025 and Zhang 2007.
"""

import numpy as np
from make import VIZ, write

import pinpress as pp
from pinpress.plots import style

STEEL = 2.1e11  # modulus of elasticity [Pa]

# assumed: sections of links, radial stiffness of journal bearings with their shafts, frame, shaft from crank to gear
SPRINGS = {
    "zxn2_3000b": pp.elasticity.Stiffness(
        bearings={"A": 3e9, "B": 4e9, "C": 4e9, "D": 5e9, "E": 6e9, "F": 6e9, "slide_guide": 2e9},
        rods=[
            pp.elasticity.Rod("coupler", ("B", "C"), STEEL * 0.030 / 1.243),
            pp.elasticity.Rod("rocker", ("D", "E"), STEEL * 0.060 / 0.480),
            pp.elasticity.Rod("rod", ("E", "F"), STEEL * 0.060 / 0.480),
        ],
        shaft=3e7,
        frame=4e9,
    ),
    "jf75g_125": pp.elasticity.Stiffness(
        bearings={"O": 3e9, "P2": 4e9, "P4": 4e9, "P3": 2e9, "P5": 2e9, "slide_guide": 2e9},
        rods=[pp.elasticity.Rod("main_rod", ("P2", "P4"), STEEL * 0.030 / 0.300)],
        shaft=1e7,
        frame=3e9,
    ),
}
FORCE = 3.0e6  # nominal force of the ZXN2-3000(B), printed [N]
DIE = 1500.0  # assumed, upper die [kg]
HEIGHT = 0.003  # assumed, of break-through above bottom dead centre [m]
DAMPING, BREAK_TIME, CLEARANCE = 0.04, 1e-3, 1e-4  # assumed [-, s, m]


def snaps(press: pp.Linkage) -> dict[str, pp.elasticity.SnapThroughResponse]:
    """At nominal force, with damping alone, and with a clearance and a time of break-through."""
    ends = pp.dead_centres(press)
    angle = ends.bottom_angle - np.radians(np.linspace(0.0, 90.0, 3601))
    above = pp.servo_cycle(press, speed=1.0, angle=angle).slide_position - ends.bottom_position
    found = pp.elasticity.compliance(press, SPRINGS[press.name], angle=np.interp([HEIGHT], above, angle))
    case = FORCE, 1 / found.compliance[0], found.effective_mass[0] + DIE
    more = {"damping_ratio": DAMPING, "break_time": BREAK_TIME, "clearance": CLEARANCE}
    return {
        f"damping ratio {DAMPING:g}": pp.elasticity.snap_through(*case, damping_ratio=DAMPING),
        f"clearance {1e3 * CLEARANCE:g} mm": pp.elasticity.snap_through(*case, **more),
    }


def main(quick: bool = False) -> None:
    """Draw the picture; ``quick``: at few speeds."""
    six_bar, fast = (pp.load(name) for name in SPRINGS)
    speeds = np.linspace(0.0, 600.0, 4 if quick else 40) * pp.RPM
    with style.drawing(22.0) as figure:
        places = figure.subplots(4, 1)
        for place, press in zip(places, (six_bar, fast), strict=False):
            angle = pp.dead_centres(press).bottom_angle + np.radians(np.arange(-60.0, 60.1, 0.25))
            pp.plots.draw(pp.elasticity.compliance(press, SPRINGS[press.name], angle=angle), "compliance", ax=place)
        shift = pp.elasticity.dead_centre_shift(fast, SPRINGS[fast.name], speed=speeds)
        pp.plots.draw({"true bottom dead centre": shift}, "shift", ax=places[2])
        pp.plots.draw(snaps(six_bar), "spring_force", ax=places[3])
        for place, press in zip(places, (six_bar, fast, fast, six_bar), strict=True):
            place.set_title(f"{press.name}: {place.get_title(loc='left').lower()}", loc="left", pad=17.0 if place is places[3] else 5.0)
    write(VIZ / "elasticity.png", figure)
