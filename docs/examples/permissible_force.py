"""How much force may the press give 30 mm above the bottom?

The nominal force holds near bottom dead centre only. Further up, the crank's torque, the bearings or the energy of the
flywheel limit the force. Each limit is a closed form of the height. The capacities are assumed, not this machine's;
strength of frame and parts, friction and the motor are left out. What a press may do is on its plate.
"""

import pinpress as pp

press = pp.load("zxn2_3000b")
capacities = pp.ratings.Capacities(
    nominal_force=3000e3,  # N
    nominal_height=0.013,  # m above bottom dead centre: from here down the crank bears the nominal force
    bearings={"A": 1.5e6, "D": 3.3e6, "E": 3.3e6},  # N
    flywheel_inertia=6000,  # kg m2 at the crank's shaft
    speed_drop=0.2,
)
found = pp.ratings.rate(press, 70 * pp.RPM, capacities)
k = abs(found.height - 0.030).argmin()
for name, limit in found.limits.items():
    print(f"{name}: {limit[k] / 1e3:.0f} kN")

figure = pp.plots.draw(found, "force", "near_bottom", "work")
