"""At which speeds and forces is the torque too much?

One call gives torque and bearing forces of ten thousand operating points: every speed with every force of a draw over
the last 20 mm. They are affine in the force and in the square of the speed. The 100 kN m are assumed; bearings, energy
and strength are other limits.
"""

import matplotlib.pyplot as plt
import numpy as np

import pinpress as pp

press = pp.load("zxn2_3000b")
drawing = pp.loads.DeepDrawing(force=1.0, start=0.020)  # 1 N, which is multiplied by the forces
speeds, forces = np.linspace(20, 100, 81), np.linspace(0, 3e6, 121)
points = pp.sweeps.operating_points(press, speeds * pp.RPM, forces=forces, unit_load=drawing)
torque = points.grid("largest_driving_torque")  # (81, 121) N m

capacity = 100e3
for rate in (30, 60, 90):
    allowed = forces[torque[np.abs(speeds - rate).argmin()] <= capacity].max()
    print(f"{rate} strokes a minute: {allowed / 1e3:.0f} kN with {capacity / 1e3:.0f} kN m")

figure, axes = plt.subplots(figsize=(6.3, 3.4), layout="constrained")
lines = axes.contour(speeds, forces / 1e3, torque.T / 1e3, levels=[20, 40, 60, 80, 100, 120], colors="black", linewidths=0.8)
axes.clabel(lines, fmt="%g kN m")
axes.set(xlabel="strokes a minute", ylabel="drawing force [kN]")
