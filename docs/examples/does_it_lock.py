"""Does my linkage come close to locking?

A dyad passes force on well while its two links stand across each other, and locks where they are in line. The
transmission angle of every dyad over the turn says how close it comes. Textbooks ask for at least 40 degrees where a
force is transmitted. A longer crank comes nearer to this limit.
"""

import matplotlib.pyplot as plt
import numpy as np

import pinpress as pp

figure, axes = plt.subplots(figsize=(6.3, 2.8), layout="constrained")
press = pp.load("zxn2_3000b")
for length in (0.143, 0.200, 0.280):  # m, of the crank
    longer = pp.derivatives.reshaped(press, {("B", "crank"): (length, 0, 0)})
    motion = pp.cycle(longer, speed=70 * pp.RPM, points=720)
    angle = pp.measures.transmission_angle_curves(longer, motion).transmission_angle["C"]
    stroke = 1e3 * pp.measures.stroke(motion)
    print(f"crank of {1e3 * length:.0f} mm: stroke {stroke:.0f} mm, at least {np.degrees(angle.min()):.1f} deg in C")
    axes.plot(np.degrees(motion.crank_angle), np.degrees(angle), label=f"{1e3 * length:.0f} mm")
axes.axhline(40, color="grey", linewidth=0.8)
axes.set(xlabel="crank angle [deg]", ylabel="transmission angle of C [deg]")
axes.legend(title="crank")
