"""Which bearing carries most, and when?

The six-bar press draws with 1000 kN over its last 10 mm, at 70 strokes a minute. Inverse dynamics gives the force in
every bearing over one turn of the crank. The peaks say which pin is loaded most, and whether the process or inertia
makes them.
"""

import numpy as np

import pinpress as pp

press = pp.load("zxn2_3000b")
motion = pp.cycle(press, speed=70 * pp.RPM, points=720)
drawing = pp.loads.DeepDrawing(force=1e6, start=0.010)  # half sine over the last 10 mm
idle = pp.inverse_dynamics(press, motion)
pressing = pp.inverse_dynamics(press, motion, loads=[drawing])

print("bearing   idle [kN]  drawing [kN]  at [deg]")
for name in "ABCDEF":
    before, force = (np.linalg.norm(reactions.bearing_force[name], axis=1) for reactions in (idle, pressing))
    print(f"{name:8} {before.max() / 1e3:10.1f} {force.max() / 1e3:13.1f} {np.degrees(motion.crank_angle[force.argmax()]):9.1f}")

figure = pp.plots.draw(pressing, "bearings")
