"""Ratings of the ZXN2-3000(B) and the JF75G-125: the table of docs/ratings.md, and the first one's force, stroke and energy as a picture.

python viz/ratings.py

The documents print nominal force, speed, motor and flywheel, as far as they stand under PRINTED; nominal heights, bearing and gib data and
drops of speed they do not. What stands under ASSUMED is ours: customary figures of presses of their size, no data of these machines.
"""

from functools import cache
from pathlib import Path

import numpy as np

import pinpress as pp

HERE = Path(__file__).parent
POINTS = 1081
SPEEDS = {"zxn2_3000b": 70 * pp.RPM, "jf75g_125": 300 * pp.RPM}  # Kong 2025, Zhang 2007
TITLES = {"zxn2_3000b": "ZXN2-3000(B), 70 strokes/min", "jf75g_125": "JF75G-125, 300 strokes/min"}
PRINTED = {
    # Kong 2025: 3000 kN, motor of 75 kW
    "zxn2_3000b": {"nominal_force": 3000e3, "motor_power": 75e3},
    # Zhang 2007: 1250 kN, flywheel of 136 kg m2, motor of 30 kW
    "jf75g_125": {"nominal_force": 1250e3, "flywheel_inertia": 136.0, "motor_power": 30e3},
}
ASSUMED = {
    "zxn2_3000b": {
        "nominal_height": 0.013,
        "flywheel_inertia": 2000.0,
        "speed_drop": 0.2,
        "bearings": {"A": 1.5e6, "D": 3.3e6, "E": 3.3e6},
    },
    "jf75g_125": {"nominal_height": 0.003, "speed_drop": 0.15, "bearings": {"O": 1.4e6, "P4": 1.4e6}},
}
GIBS = {"zxn2_3000b": pp.ratings.Gibs(length=1.2, width=0.3), "jf75g_125": pp.ratings.Gibs(length=0.6, width=0.2)}
PRESSURE = 6e6  # permissible on the gibs [Pa]


def capacities(name: str) -> pp.ratings.Capacities:
    """What is printed and assumed."""
    return pp.ratings.Capacities(**PRINTED[name] | ASSUMED[name])


@cache
def rated(name: str) -> pp.ratings.PressRatings:
    return pp.ratings.rate(pp.load(name), SPEEDS[name], capacities(name), points=POINTS)


def table() -> str:
    """Markdown: assumptions and main data of both presses."""
    names = list(SPEEDS)
    rows: list[tuple[str, list[str]]] = []
    found = {name: rated(name) for name in names}

    def row(what: str, cells: list[str]) -> None:
        rows.append((what, cells))

    row("nominal force (printed)", [f"{one.capacities.nominal_force / 1e3:.0f} kN" for one in found.values()])
    row("nominal height (assumed)", [f"{1e3 * one.capacities.nominal_height:g} mm" for one in found.values()])
    row(
        "flywheel at the crank, drop of its speed",
        [
            f"{PRINTED[n].get('flywheel_inertia', ASSUMED[n].get('flywheel_inertia')):g} kg m2"
            f" ({'printed' if 'flywheel_inertia' in PRINTED[n] else 'assumed'}), {100 * ASSUMED[n]['speed_drop']:.0f} % (assumed)"
            for n in names
        ],
    )
    row("motor (printed)", [f"{PRINTED[n]['motor_power'] / 1e3:g} kW" for n in names])
    row(
        "bearings (assumed)",
        [", ".join(f"{b} {force / 1e3:.0f} kN" for b, force in one.capacities.bearings.items()) for one in found.values()],
    )
    row("torque capacity that follows", [f"{one.torque_capacity / 1e3:.2f} kN m" for one in found.values()])
    row("stroke", [f"{1e3 * one.stroke:.2f} mm" for one in found.values()])
    row("quick return ratio", [f"{one.quick_return_ratio:.4f}" for one in found.values()])
    row("speed at the nominal height", [f"{1e3 * one.contact_speed:.1f} mm/s" for one in found.values()])
    row("mechanical advantage there", [f"{one.contact_advantage:.2f} N for each N m" for one in found.values()])
    row("dwell within 1 % of the stroke", [f"{1e3 * one.dwell_time:.1f} ms" for one in found.values()])
    row("energy of the flywheel in a stroke", [f"{one.energies['flywheel energy'] / 1e3:.2f} kJ" for one in found.values()])
    row("energy of the motor in a turn", [f"{one.energies['motor energy'] / 1e3:.2f} kJ" for one in found.values()])
    row("nominal force to", [f"{1e3 * one.changes[-1]:.2f} mm, then {above(one)}" for one in found.values()])
    row(
        "idle speed at which a capacity is reached",
        [f"{one.speed_limit.strokes_per_minute:.0f} strokes/min ({one.speed_limit.limited_by})" for one in found.values()],
    )
    row("gibs, pressure (assumed)", [f"{GIBS[n].length:g} m x {GIBS[n].width:g} m, {PRESSURE / 1e6:g} MPa" for n in names])
    row("eccentricity of the nominal force up to the nominal height", [eccentricity(name) for name in names])
    head = f"| | {' | '.join(TITLES[name] for name in names)} |\n|---|{'---|' * len(names)}\n"
    return head + "\n".join(f"| {what} | {' | '.join(cells)} |" for what, cells in rows)


def above(one: pp.ratings.PressRatings) -> str:
    """The limit that governs above the heights at which the nominal force is permissible."""
    at = int(np.flatnonzero(one.height == one.changes[-1])[0])
    return one.limited_by[at - 1]


def eccentricity(name: str) -> str:
    """In the plane, at all crank angles from the nominal height down, with the pressure that a centred force makes there."""
    press, one = pp.load(name), rated(name)
    assert one.capacities.nominal_height is not None
    motion = pp.servo_cycle(press, speed=0.0, angle=one.crank_angle[one.height <= one.capacities.nominal_height + 1e-12])
    force = one.capacities.nominal_force
    left, right = pp.ratings.permissible_eccentricity(press, motion, force=force, gibs=GIBS[name], pressure=PRESSURE)
    central = pp.ratings.eccentric_load(press, motion, force=force, offset=(0.0, 0.0, 0.0), gibs=GIBS[name]).pressure.max()
    return f"{1e3 * left:.1f} to {1e3 * right:+.1f} mm (centred: {central / 1e6:.2f} MPa)"


if __name__ == "__main__":
    from light import light  # type: ignore[import-not-found]  # beside this script

    print(table())
    print(light(pp.plots.save(pp.plots.ratings(rated("zxn2_3000b")), HERE / "ratings.png")))
