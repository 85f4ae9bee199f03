"""Which counterweight quietens my press?

Counterweights of up to 400 kg may be on the crank and the rod, within 300 mm of their pins. Which masses, and where,
give the least vertical shaking force with at most 10 kN horizontally? The answer is proved: no others in these regions
are better.
"""

import numpy as np

import pinpress as pp
from pinpress.balancing import AddedMass, CounterweightRegion, Range, balance

press = pp.load("zxn2_3000b")
motion = pp.cycle(press, speed=70 * pp.RPM)
regions = [CounterweightRegion("crank", radius=0.3), CounterweightRegion("rod", radius=0.3, mass=(0, 200))]
best = balance(
    press, motion, regions=regions, minimise=Range("shaking_force", "z"), limits={Range("shaking_force", "x"): 10e3, AddedMass(): 400}
)

for weight in best.counterweights:
    x, _, z = weight.position
    print(f"{weight.mass:.1f} kg on the {weight.link}, {1e3 * x:+.0f} mm along it and {1e3 * z:+.0f} mm across")
before, after = (pp.inverse_dynamics(each, motion) for each in (press, best.press))
for axis, k in {"horizontal": 0, "vertical": 2}.items():
    print(f"{axis}: {np.ptp(before.shaking_force[:, k]) / 1e3:.1f} -> {np.ptp(after.shaking_force[:, k]) / 1e3:.1f} kN")

figure = pp.plots.draw(after, "torque", "shaking", "peaks", before=before)
