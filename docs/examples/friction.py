"""How much torque does friction cost?

The plain bearings have a coefficient of 0.05 on pins of 60 mm radius. The example gives the torque at the crank, the
power that warms the bearings, and how far a measured torque is from that of the frictionless model.
"""

import pinpress as pp

press = pp.load("zxn2_3000b")
motion = pp.cycle(press, speed=70 * pp.RPM, points=720)
drawing = pp.loads.DeepDrawing(force=2e6, start=0.010)
friction = {name: pp.loads.Friction(0.05, radius=0.06) for name in "ABCDEF"} | {"slide_guide": pp.loads.Friction(0.05)}

smooth = pp.inverse_dynamics(press, motion, loads=[drawing])
real = pp.inverse_dynamics(press, motion, loads=[drawing], friction=friction)
print(f"largest torque {smooth.driving_torque.max() / 1e3:.1f} -> {real.driving_torque.max() / 1e3:.1f} kN m")
for name, power in sorted(real.friction_power.items(), key=lambda each: -each[1].mean())[:3]:
    print(f"{name}: {power.mean() / 1e3:.2f} kW on average")

figure = pp.plots.draw(real, "torque")
