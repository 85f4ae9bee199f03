"""Ratings of the ZXN2-3000(B): its permissible force, stroke and energy, the picture of docs/ratings.md.

python viz/ratings.py

Kong 2025 prints nominal force and motor. All else is assumed (ours): customary figures of presses of that size, no data of this machine.
"""

from pathlib import Path

import pinpress as pp

PICTURE = Path(__file__).with_suffix(".png")
SPEED = 70 * pp.RPM
CAPACITIES = pp.ratings.Capacities(
    nominal_force=3000e3,
    motor_power=75e3,
    nominal_height=0.013,
    flywheel_inertia=2000.0,
    speed_drop=0.2,
    bearings={"A": 1.5e6, "D": 3.3e6, "E": 3.3e6},
)

if __name__ == "__main__":
    from light import light  # type: ignore[import-not-found]  # beside this script

    rated = pp.ratings.rate(pp.load("zxn2_3000b"), SPEED, CAPACITIES, points=1081)
    print(light(pp.plots.save(pp.plots.draw(rated, "force", "near_bottom", "work"), PICTURE)))
