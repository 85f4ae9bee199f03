"""What does a balance cylinder do for the drive?

Four air cylinders with a tank bear the slide of 7 t. The torque of the empty press falls to a third. The rod pays for
it. Without air it carries the hanging slide all the way round. With air it is pushed and pulled in every turn, so that
its clearances change sides. Air can fail, so a brake is judged without air.
"""

import matplotlib.pyplot as plt
import numpy as np

import pinpress as pp

press = pp.load("zxn2_3000b")
motion = pp.cycle(press, speed=50 * pp.RPM, points=720)
air = pp.loads.BalanceCylinder(bore=0.200, pressure=5.5e5, volume=0.250, count=4)  # m, Pa above the atmosphere, m3

figure, axes = plt.subplots(figsize=(6.3, 2.8), layout="constrained")
for name, loads in {"without": [], "with air": [air]}.items():
    reactions = pp.inverse_dynamics(press, motion, loads=loads)
    rod = reactions.bearing_force["F"][:, 2]
    print(f"{name}: torque {np.ptp(reactions.driving_torque) / 1e3:.1f} kN m from least to most", end=", ")
    print(f"wrist pin {rod.min() / 1e3:+.0f} to {rod.max() / 1e3:+.0f} kN")
    axes.plot(np.degrees(motion.crank_angle), reactions.driving_torque / 1e3, label=name)
axes.set(xlabel="crank angle [deg]", ylabel="driving torque [kN m]")
axes.legend()
