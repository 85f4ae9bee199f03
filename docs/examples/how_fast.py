"""How much higher may I go in speed?

At a given crank angle every force of the idle press is A w² + c, so the speed at which a bearing reaches its capacity
is the root of an equation. Each limit is computed separately, with an assumed capacity. A faster press also takes
longer to stop, and its flywheel, clutch and brake have their own limits, which are left out here. Ask the maker before
you speed it up.
"""

import matplotlib.pyplot as plt

import pinpress as pp

press = pp.load("zxn2_3000b")
limits = {
    "bearing A, 300 kN": pp.ratings.Capacities(nominal_force=3000e3, bearings={"A": 300e3}),
    "bearing D, 700 kN": pp.ratings.Capacities(nominal_force=3000e3, bearings={"D": 700e3}),
    "slide, 3 g": pp.ratings.Capacities(nominal_force=3000e3, slide_acceleration=3 * 9.81),
    "floor, 250 kN": pp.ratings.Capacities(nominal_force=3000e3, shaking_force=250e3),
}
found = {name: pp.ratings.speed_limit(press, capacities) for name, capacities in limits.items()}
for name, limit in found.items():
    print(f"{name}: up to {limit.strokes_per_minute:.1f} strokes a minute")

figure, axes = plt.subplots(figsize=(6.3, 2.4), layout="constrained")
axes.barh(list(found), [limit.strokes_per_minute for limit in found.values()])
axes.axvline(70, color="black", linewidth=1)
axes.set_xlabel("strokes a minute; the line is today's speed")
